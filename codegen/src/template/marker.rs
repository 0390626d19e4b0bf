//! Translation of a template source into the Tcl program that prints its expansion.
//!
//! A source mixes literal text with `<' CODE '>` and `<" TEXT ">` markers. The program keeps the line breaks
//! of the source, so that Tcl's line numbers are those of the source.

use std::ops::Range;

/// The command that prints literal text and the word that ends its call.
pub(crate) const LITERAL: (&str, &str) = ("\u{2}=", "=\u{3}");
/// The command that prints a substituted text and the word that ends its call.
pub(crate) const SUBSTITUTE: (&str, &str) = ("\u{2}?", "?\u{3}");

/// Block size in characters. A text that is flushed at the end of a block is not subject to the newline rule
/// of the text after it.
const BLOCK: usize = 4096;

/// A source that cannot be translated.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct MarkerError {
    /// Line reached by the reader, from 1: the line of the last complete marker before.
    pub line: usize,
    /// The error.
    pub fault: Fault,
}

/// The error of a marker, with the quotes of its tags and their positions, in characters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fault {
    /// A closing tag without an opening one.
    Unopened { close: Tag },
    /// An opening tag without a closing one.
    Unclosed { open: Tag },
    /// Tags of different kinds.
    Unbalanced { open: Tag, close: Tag },
}

/// A tag of a marker: its quote, and the index of its first character.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Tag {
    pub quote: char,
    pub at: usize,
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Fault::Unopened { .. } => f.write_str("missing opening tag"),
            Fault::Unclosed { .. } => f.write_str("missing closing tag"),
            Fault::Unbalanced { open, close } => {
                write!(f, "unbalanced tags '<{}' and '{}>'", open.quote, close.quote)
            }
        }
    }
}

/// A translated source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Program {
    /// The Tcl program.
    pub text: String,
    /// The map from the program to the source, in order.
    pub pieces: Vec<Piece>,
}

/// A stretch of a program that came from a stretch of the source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Piece {
    /// Start in the program, in bytes.
    pub program: usize,
    /// Range in the source, in characters; without tags.
    pub source: Range<usize>,
    pub kind: PieceKind,
}

/// The kinds of pieces of a source.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PieceKind {
    /// Text between markers.
    Literal,
    /// The code of a marker, as it is.
    Code,
    /// The text of a marker that is substituted.
    Substitution,
}

/// Translates a source.
///
/// # Errors
/// Fails for a marker that is not closed, not opened, or closed with the other quote.
pub(crate) fn translate(source: &str) -> Result<Program, MarkerError> {
    Translator::new(source).run()
}

struct Translator {
    source: Vec<char>,
    /// Number of characters of the source read so far.
    read: usize,
    /// True if a read has met the end.
    ended: bool,
    /// Start of the text that was read but not yet translated.
    start: usize,
    line: usize,
    program: String,
    pieces: Vec<Piece>,
}

/// A complete marker in a buffer: indexes of `<`, of the closing quote, and the two quotes.
struct Marker {
    open: usize,
    close: usize,
    quotes: (char, char),
}

impl Translator {
    fn new(source: &str) -> Translator {
        Translator {
            source: source.chars().collect(),
            read: 0,
            ended: false,
            start: 0,
            line: 1,
            program: String::with_capacity(source.len() + source.len() / 4),
            pieces: Vec::new(),
        }
    }

    fn run(mut self) -> Result<Program, MarkerError> {
        while !self.ended {
            self.read_block();
            while let Some(found) = self.find_marker() {
                self.translate_marker(&found)?;
            }
            if let Some(at) = self.find_close(self.start, self.read) {
                let close = self.tag(at, at);
                return Err(self.error(Fault::Unopened { close }));
            }
            if self.find_open(self.start, self.read).is_some() {
                continue;
            }
            self.push_command(LITERAL, self.start..self.read, PieceKind::Literal);
            self.start = self.read;
        }
        if let Some(at) = self.find_open(self.start, self.read) {
            let open = self.tag(at, at + 1);
            return Err(self.error(Fault::Unclosed { open }));
        }
        Ok(Program { text: self.program, pieces: self.pieces })
    }

    fn read_more(&mut self, count: usize) {
        let until = self.read + count;
        self.ended |= until > self.source.len();
        self.read = until.min(self.source.len());
    }

    /// Reads a block, and continues while the block ends inside a possible delimiter of a marker.
    fn read_block(&mut self) {
        self.read_more(BLOCK);
        loop {
            let text = &self.source[self.start..self.read];
            let tail = &text[text.len().saturating_sub(2)..];
            let undecided = tail.contains(&'<') || tail.last() == Some(&'>');
            if !undecided || self.ended {
                return;
            }
            self.read_more(2);
        }
    }

    fn find_marker(&self) -> Option<Marker> {
        let text = &self.source[..self.read];
        let open = self.find_open(self.start, self.read)?;
        let close = self.find_close(open + 2, self.read)?;
        Some(Marker { open, close, quotes: (text[open + 1], text[close]) })
    }

    fn find_close(&self, from: usize, until: usize) -> Option<usize> {
        let text = &self.source[..until];
        (from..until.saturating_sub(1)).find(|&at| is_quote(text[at]) && text[at + 1] == '>')
    }

    fn find_open(&self, from: usize, until: usize) -> Option<usize> {
        let text = &self.source[..until];
        (from..until.saturating_sub(1)).find(|&at| text[at] == '<' && is_quote(text[at + 1]))
    }

    fn tag(&self, at: usize, quote: usize) -> Tag {
        Tag { quote: self.source[quote], at }
    }

    fn translate_marker(&mut self, found: &Marker) -> Result<(), MarkerError> {
        if found.open > self.start {
            if let Some(at) = self.find_close(self.start, found.open) {
                self.line += newlines(&self.source[self.start..=at]);
                let close = self.tag(at, at);
                return Err(self.error(Fault::Unopened { close }));
            }
            self.line += newlines(&self.source[self.start..found.open]);
            // A line that holds only code is removed: one of its two newlines is dropped.
            let after = found.close + 2;
            let drop = found.quotes == ('\'', '\'')
                && self.source[found.open - 1] == '\n'
                && after < self.read
                && self.source[after] == '\n';
            let end = found.open - usize::from(drop);
            if end > self.start {
                self.push_command(LITERAL, self.start..end, PieceKind::Literal);
            }
            if drop {
                self.program.push('\n');
            }
        }
        let inside = found.open + 2..found.close;
        match found.quotes {
            ('\'', '\'') => {
                self.piece(inside.clone(), PieceKind::Code);
                self.program.extend(&self.source[inside]);
            }
            ('"', '"') => self.push_command(SUBSTITUTE, inside, PieceKind::Substitution),
            _ => {
                let open = self.tag(found.open, found.open + 1);
                let close = self.tag(found.close, found.close);
                return Err(self.error(Fault::Unbalanced { open, close }));
            }
        }
        self.line += newlines(&self.source[found.open + 2..found.close]);
        self.start = found.close + 2;
        Ok(())
    }

    fn push_command(&mut self, command: (&str, &str), source: Range<usize>, kind: PieceKind) {
        let (name, end) = command;
        self.program.push(';');
        self.program.push_str(name);
        self.program.push_str(" {");
        self.piece(source.clone(), kind);
        escape(&self.source[source], &mut self.program);
        self.program.push_str("} ");
        self.program.push_str(end);
        self.program.push(';');
    }

    fn piece(&mut self, source: Range<usize>, kind: PieceKind) {
        self.pieces.push(Piece { program: self.program.len(), source, kind });
    }

    fn error(&self, fault: Fault) -> MarkerError {
        MarkerError { line: self.line, fault }
    }
}

fn is_quote(c: char) -> bool {
    matches!(c, '\'' | '"')
}

fn newlines(text: &[char]) -> usize {
    text.iter().filter(|c| **c == '\n').count()
}

/// Escapes text between braces so that it stays unchanged, line breaks included; the printing command
/// reverses it.
fn escape(text: &[char], out: &mut String) {
    for &c in text {
        if matches!(c, '{' | '}' | '\\') {
            out.push('\\');
        }
        out.push(c);
    }
}

/// Shows a command of a translated program as it was written, for error messages.
pub(crate) fn restore(command: &str) -> String {
    let mut out = command.to_owned();
    for ((name, end), open, close) in [(LITERAL, "'>", "<'"), (SUBSTITUTE, "<\"", "\">")] {
        for (from, to) in [
            (format!(";{name} {{"), open),
            (format!("{name} {{"), open),
            (format!("}} {end};"), close),
            (format!("}} {end}"), close),
        ] {
            out = out.replace(&from, to);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The program with its printing commands written as `[=text]` and `["text]`.
    fn shown(source: &str) -> String {
        match translate(source) {
            Ok(program) => program
                .text
                .replace(";\u{2}= {", "[=")
                .replace("} =\u{3};", "]")
                .replace(";\u{2}? {", "[\"")
                .replace("} ?\u{3};", "]"),
            Err(error) => format!("{}: {}", error.line, error.fault),
        }
    }

    #[test]
    fn literals_code_and_substitutions() {
        assert_eq!(shown("a<'set x 1'>b<\"$x\">c"), "[=a]set x 1[=b][\"$x][=c]");
        assert_eq!(shown(""), "[=]");
        assert_eq!(shown("{ \\ }"), "[=\\{ \\\\ \\}]");
        assert_eq!(shown("<'a'><'b'>"), "ab[=]");
    }

    #[test]
    fn a_line_of_code_alone_disappears() {
        assert_eq!(shown("a\n<'x'>\nb"), "[=a]\nx[=\nb]");
        assert_eq!(shown("<'x'>\nb"), "x[=\nb]");
        assert_eq!(shown("a\n<'x'> \nb"), "[=a\n]x[= \nb]");
        assert_eq!(shown("a\n<\"x\">\nb"), "[=a\n][\"x][=\nb]");
        assert_eq!(shown("\n<'x'>\n"), "\nx[=\n]");
    }

    #[test]
    fn markers_must_match() {
        assert_eq!(shown("one\ntwo\n<' x\nthree"), "1: missing closing tag");
        assert_eq!(shown("one\ntwo '>\n"), "1: missing opening tag");
        assert_eq!(shown("one\n<' x \">"), "2: unbalanced tags '<'' and '\">'");
        assert_eq!(shown("a\nb'>c<'x'>"), "2: missing opening tag");
        assert_eq!(shown("a < b > c ' \" <"), "[=a < b > c ' \" <]");
    }

    #[test]
    fn a_newline_at_the_end_of_a_block_stays() {
        let before = "x".repeat(BLOCK - 1);
        let source = format!("{before}\n<'y'>\nz");
        assert_eq!(shown(&source), format!("[={before}\n]y[=\nz]"));
        let inside = "x".repeat(BLOCK - 2);
        let source = format!("{inside}\n<'y'>\nz");
        assert_eq!(shown(&source), format!("[={inside}]\ny[=\nz]"));
    }

    #[test]
    fn commands_are_shown_as_written() {
        let program = translate("<\"$nosuch\">").unwrap();
        assert_eq!(restore(program.text.split('\n').next().unwrap()), "<\"$nosuch\">'><'");
    }
}
