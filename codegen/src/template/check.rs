//! Static checks of template files: mismatched tags of markers, and Tcl that cannot be complete.

use std::ops::Range;

use camino::Utf8Path;
use dotgen_analysis::codes::Code;
use dotgen_analysis::diagnostic::{Diagnostic, Related, Severity};

use super::marker::{self, Fault, Piece, PieceKind, Program, Tag};
use super::script::{self, Flaw, FlawKind};

/// Tags of markers.
pub const MARKER: &str = "template/marker";
/// The Tcl of markers and scripts.
pub const TCL: &str = "template/tcl";
/// Text that a comment swallows.
pub const COMMENT: &str = "template/comment";

/// The codes of this module.
pub const CODES: &[Code] = &[Code::error(MARKER), Code::error(TCL), Code::error(COMMENT)];

pub fn source(path: &Utf8Path, text: &str) -> Vec<Diagnostic> {
    let places = Places { path, text };
    let program = match marker::translate(text) {
        Ok(program) => program,
        Err(error) => return vec![places.fault(error.fault)],
    };
    let mut out: Vec<Diagnostic> = nested(text, &program)
        // The engine accepts it, and Tcl may.
        .map(|(open, inner)| Diagnostic {
            severity: Severity::Warning,
            ..places.nested(open, inner)
        })
        .collect();
    for flaw in script::flaws(&program.text) {
        let range = program.source(&flaw.range);
        out.push(places.flaw(range, flaw.kind, "before the end of the file"));
    }
    let substitutions = program.pieces.iter();
    for piece in substitutions.filter(|substitution| substitution.kind == PieceKind::Substitution) {
        let range = places.bytes(&piece.source);
        for flaw in script::subst_flaws(&text[range.clone()]) {
            let Flaw { range: at, kind } = flaw;
            let at = range.start + at.start..range.start + at.end;
            out.push(places.at(at, kind, "before `\">`"));
        }
    }
    out.sort_by_key(|diagnostic| (diagnostic.range.start, diagnostic.range.end));
    out
}

/// The diagnostics of a script: `template.tcl` and the files it requires.
pub fn script(path: &Utf8Path, text: &str) -> Vec<Diagnostic> {
    let places = Places { path, text };
    let flaws = script::flaws(text).into_iter();
    flaws.map(|flaw| places.at(flaw.range, flaw.kind, "before the end of the file")).collect()
}

/// Returns true if a text begins with a whole marker, after optional text.
pub(crate) fn has_marker(text: &str) -> bool {
    let open = ["<'", "<\""].map(|mark| text.find(mark));
    let Some(open) = open.into_iter().flatten().min() else {
        return false;
    };
    let quote = &text[open + 1..open + 2];
    let close = ["'>", "\">"].map(|mark| text[open + 2..].find(mark));
    let close = close.into_iter().flatten().min();
    close.is_some_and(|close| text[open + 2 + close..].starts_with(quote))
}

/// Markers of code with another opening tag inside, as indexes of both: the first is not closed, and ends
/// with the second.
fn nested<'a>(text: &'a str, program: &'a Program) -> impl Iterator<Item = (usize, usize)> + 'a {
    let chars: Vec<char> = text.chars().collect();
    let code = program.pieces.iter();
    let code = code.filter(|code| code.kind == PieceKind::Code);
    code.filter_map(move |code| {
        let inside = &chars[code.source.clone()];
        let at = inside.windows(2).position(|window| window == ['<', '\''])?;
        Some((code.source.start - 2, code.source.start + at))
    })
}

impl Program {
    /// The range in the source of a range of the program, in characters. Text that the translation added is
    /// at the end of the source text before it.
    fn source(&self, range: &Range<usize>) -> Range<usize> {
        let after = self.pieces.partition_point(|piece| piece.program <= range.start);
        let Some(piece) = after.checked_sub(1).map(|before| &self.pieces[before]) else {
            return 0..0;
        };
        let Piece { source, .. } = piece;
        if piece.kind != PieceKind::Code {
            return source.start..source.start;
        }
        let chars = |range: Range<usize>| self.text[range].chars().count();
        let start = source.start + chars(piece.program..range.start);
        let end = start + chars(range.clone());
        start.min(source.end)..end.min(source.end)
    }
}

/// The text of the diagnostics.
struct Places<'a> {
    path: &'a Utf8Path,
    text: &'a str,
}

impl Places<'_> {
    /// Characters as bytes.
    fn bytes(&self, chars: &Range<usize>) -> Range<usize> {
        let byte = |at: usize| {
            let found = self.text.char_indices().nth(at);
            found.map_or(self.text.len(), |(byte, _)| byte)
        };
        byte(chars.start)..byte(chars.end)
    }

    fn line(&self, at: usize) -> usize {
        self.text[..at].matches('\n').count() + 1
    }

    fn diagnostic(&self, code: &'static str, range: Range<usize>, message: String) -> Diagnostic {
        let severity =
            CODES.iter().find(|candidate| candidate.id == code).map(|code| code.severity);
        let severity = severity.unwrap_or(Severity::Error);
        Diagnostic::new(code, severity, message, self.path.to_owned(), range)
    }

    fn related(&self, range: Range<usize>, message: &str) -> Related {
        Related { path: self.path.to_owned(), range, message: message.into() }
    }

    fn tag(&self, tag: Tag) -> Range<usize> {
        self.bytes(&(tag.at..tag.at + 2))
    }

    fn fault(&self, fault: Fault) -> Diagnostic {
        match fault {
            Fault::Unopened { close } => {
                let quote = close.quote;
                let message = format!(
                    "`{quote}>` closes no marker: write `<{quote}` where the marker begins, or take this \
                        tag out"
                );
                self.diagnostic(MARKER, self.tag(close), message)
            }
            Fault::Unclosed { open } => {
                let quote = open.quote;
                let message = format!("this marker is not closed: write `{quote}>` where it ends");
                self.diagnostic(MARKER, self.tag(open), message)
            }
            Fault::Unbalanced { open, close } => {
                let (first, last) = (self.tag(open), self.tag(close));
                let inside = &self.text[first.end..last.start];
                // The tag belongs to another marker, which begins before the first has ended.
                if let Some(at) = inside.rfind(&format!("<{}", close.quote)) {
                    let inner = first.end + at;
                    return self.nested_at(first, open.quote, inner);
                }
                let line = self.line(first.start);
                let (open, close) = (open.quote, close.quote);
                let message = format!(
                    "the marker that `<{open}` opens in line {line} is closed with `{close}>`: write \
                        `{open}>`"
                );
                let mut diagnostic = self.diagnostic(MARKER, last, message);
                diagnostic.related.push(self.related(first, "the marker begins here"));
                diagnostic
            }
        }
    }

    fn nested(&self, open: usize, inner: usize) -> Diagnostic {
        let inner = self.bytes(&(inner..inner)).start;
        self.nested_at(self.bytes(&(open..open + 2)), '\'', inner)
    }

    fn nested_at(&self, open: Range<usize>, quote: char, inner: usize) -> Diagnostic {
        let line = self.line(inner);
        let message = format!(
            "this marker is not closed before the next one begins in line {line}: write `{quote}>` where it \
                ends"
        );
        let mut diagnostic = self.diagnostic(MARKER, open, message);
        let next = self.related(inner..inner + 2, "the next marker begins here");
        diagnostic.related.push(next);
        diagnostic
    }

    /// A flaw at characters.
    fn flaw(&self, chars: Range<usize>, kind: FlawKind, before: &str) -> Diagnostic {
        self.at(self.bytes(&chars), kind, before)
    }

    fn at(&self, range: Range<usize>, kind: FlawKind, before: &str) -> Diagnostic {
        let open = |what: &str, close: &str| {
            let message = format!("`{what}` is not closed: write `{close}` {before}");
            (TCL, message)
        };
        let (code, message) = match kind {
            FlawKind::Brace => open("{", "}"),
            FlawKind::Bracket => open("[", "]"),
            FlawKind::Quote => open("\"", "\""),
            FlawKind::Name => open("${", "}"),
            FlawKind::Index => open(&self.text[range.clone()], ")"),
            FlawKind::Extra(close) => (
                TCL,
                format!(
                    "a word that ends with `{close}` goes on behind it: write a space there, or put `\\` before \
                     what is part of the word"
                ),
            ),
            FlawKind::Stray => (
                TCL,
                "`}` closes nothing: open a `{` before, or take it out".to_owned(),
            ),
            FlawKind::Detached => {
                let word = &self.text[range.clone()];
                let message = format!(
                    "`{word}` begins a command of its own: write it behind the `}}` of its `if`, in the \
                        same marker"
                );
                (TCL, message)
            }
            FlawKind::Comment => (
                COMMENT,
                "this comment ends with the line, and the text behind the marker is part of it: put `'>` on a line \
                 of its own"
                    .to_owned(),
            ),
        };
        self.diagnostic(code, range, message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Findings with places as the editor counts them: `line:column code message`, and the text there.
    fn shown(text: &str, found: &[Diagnostic]) -> Vec<String> {
        let one = |diagnostic: &Diagnostic| {
            let before = &text[..diagnostic.range.start];
            let line = before.matches('\n').count() + 1;
            let column =
                before.chars().rev().take_while(|character| *character != '\n').count() + 1;
            let what = &text[diagnostic.range.clone()];
            format!("{line}:{column} {what:?} {}: {}", diagnostic.code, diagnostic.message)
        };
        found.iter().map(one).collect()
    }

    fn check(text: &str) -> Vec<String> {
        let found = source("t.c".into(), text);
        // An error of the engine is always reported.
        let refused = marker::translate(text).is_err();
        assert!(!refused || found.iter().any(|source| source.code == MARKER));
        shown(text, &found)
    }

    #[test]
    fn a_healthy_source_has_no_findings() {
        let text = "é <'# one\nif {$a} {'>\n{ [ \" <\"[f \"a b\"] ${x y}\">\n<'} else {'>\n  '<'}'> #\n'a' \"b\" <c>\n";
        assert_eq!(check(text), [""; 0]);
        assert_eq!(check("a\n<'foreach x {1 2} {'>\n}\n<'}'>\n"), [""; 0]);
    }

    #[test]
    fn tags_that_do_not_match() {
        assert_eq!(
            check("é\n  x '>\n"),
            [
                "2:5 \"'>\" template/marker: `'>` closes no marker: write `<'` where the marker begins, or \
                    take this tag out"
            ]
        );
        assert_eq!(
            check("a\nb <'set x\n"),
            ["2:3 \"<'\" template/marker: this marker is not closed: write `'>` where it ends"]
        );
        assert_eq!(
            check("a\n<' x\n \">\n"),
            [
                "3:2 \"\\\">\" template/marker: the marker that `<'` opens in line 2 is closed with `\">`: \
                    write `'>`"
            ]
        );
        let line = "1:1 \"<'\" template/marker: this marker is not closed before the next one begins in line 2: write `'>` \
                    where it ends";
        assert_eq!(check("<'set x 1\nb <\"$x\">\n"), [line]);
        assert_eq!(check("<'set x 1\nb <'puts x'>\n"), [line]);
    }

    #[test]
    fn tcl_that_cannot_be_complete_is_told_where_it_was_written() {
        assert_eq!(
            check("é{\n<'foreach x $l {'>\n text }\n<\"$x\">\n"),
            ["2:16 \"{\" template/tcl: `{` is not closed: write `}` before the end of the file"]
        );
        assert_eq!(
            check("a <'set x 1'>\nb <'}'>\n"),
            ["2:5 \"}\" template/tcl: `}` closes nothing: open a `{` before, or take it out"]
        );
        assert_eq!(
            check("a <\"é [f {x}\"> b\n"),
            ["1:7 \"[\" template/tcl: `[` is not closed: write `]` before `\">`"]
        );
        assert_eq!(
            check("<'if {$x} {'>a<'}'>\n<'else {'>b<'}'>\n"),
            [
                "2:3 \"else\" template/tcl: `else` begins a command of its own: write it behind the `}` of its `if`, in the \
             same marker"
            ]
        );
        assert_eq!(
            check("<'if {$x} {puts [f $x }'>\n"),
            ["1:17 \"[\" template/tcl: `[` is not closed: write `]` before the end of the file"]
        );
    }

    #[test]
    fn a_comment_at_the_end_of_a_marker_takes_text_with_it() {
        let found = check("<'set n 0 ;# none'> first\n");
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].starts_with("1:12 \"#\" template/comment"));
    }

    #[test]
    fn scripts() {
        let text =
            "template options {\n  -C { engine chdir [template arg] }\n}\nforeach f $argv {\n";
        assert_eq!(
            shown(text, &script("template.tcl".into(), text)),
            ["4:17 \"{\" template/tcl: `{` is not closed: write `}` before the end of the file"]
        );
    }

    #[test]
    fn the_examples_of_the_manual_trigger_their_codes() {
        for code in CODES {
            let page = dotgen_loaders::pages::Page::read(code.id).expect("every code has a page");
            let found = source("t.c".into(), page.texts("text", false)[0]);
            let codes: Vec<&str> = found.iter().map(|source| source.code).collect();
            assert_eq!(codes, [code.id]);
            let found = source("t.c".into(), page.texts("text", true)[0]);
            assert_eq!(found, [], "{}", code.id);
        }
    }
}
