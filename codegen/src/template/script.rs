//! The structure of a Tcl script: errors that are certain without running it.
//!
//! Tcl reads a script command by command, and parses a braced word only when something evaluates it. This
//! module does the same: it descends into the words that a known command evaluates, and into command
//! substitutions. Every reported script fails for any values of its variables.

use std::ops::Range;

use super::marker::{LITERAL, SUBSTITUTE};

/// An error that makes a script fail. Ranges are bytes of the script.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Flaw {
    /// The range of the error.
    pub range: Range<usize>,
    pub kind: FlawKind,
}

/// See [`Flaw`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FlawKind {
    /// `{` without `}`.
    Brace,
    /// `[` without `]`.
    Bracket,
    /// `"` without `"`.
    Quote,
    /// `${` without `}`.
    Name,
    /// `$name(` without `)`.
    Index,
    /// Text right after a `}` or `"` that ends a word.
    Extra(char),
    /// A command that begins with `}`.
    Stray,
    /// `else` or `elseif` where a command begins.
    Detached,
    /// A comment that swallows a literal or a substitution of a source.
    Comment,
}

/// Maximum depth of nested scripts that are checked.
const DEPTH: usize = 100;

/// The flaws of a script. A flaw that leaves a word without an end is the last one.
pub(crate) fn flaws(script: &str) -> Vec<Flaw> {
    let mut reader = Reader::new(script.as_bytes(), 0..script.len());
    // The text up to an open end has been checked.
    let _ = reader.script(false);
    reader.flaws
}

/// The flaws of a text whose variables and commands are substituted.
pub(crate) fn subst_flaws(text: &str) -> Vec<Flaw> {
    let mut reader = Reader::new(text.as_bytes(), 0..text.len());
    let _ = reader.substituted(|_| false);
    reader.flaws
}

/// The error for a missing end; its flaw is already recorded.
struct UnclosedError;

struct Reader<'a> {
    text: &'a [u8],
    at: usize,
    end: usize,
    depth: usize,
    flaws: Vec<Flaw>,
}

/// A word of a command.
struct Word {
    range: Range<usize>,
    /// True for a word in braces: its content is evaluated only by the command.
    braced: bool,
}

impl<'a> Reader<'a> {
    fn new(text: &'a [u8], range: Range<usize>) -> Reader<'a> {
        Reader { text, at: range.start, end: range.end, depth: 0, flaws: Vec::new() }
    }

    fn peek(&self) -> Option<u8> {
        (self.at < self.end).then(|| self.text[self.at])
    }

    fn note(&mut self, range: Range<usize>, kind: FlawKind) {
        self.flaws.push(Flaw { range, kind });
    }

    /// Records a word without an end that begins at `start`, with an opening of this many characters.
    fn open(&mut self, start: usize, length: usize, kind: FlawKind) -> UnclosedError {
        self.note(start..start + length, kind);
        UnclosedError
    }

    /// Skips a backslash and the character after it.
    fn skip_escape(&mut self) {
        self.at = (self.at + 2).min(self.end);
    }

    /// Returns true if a backslash and the end of a line are next: white space.
    fn at_continuation(&self) -> bool {
        self.peek() == Some(b'\\')
            && self.at + 1 < self.end
            && matches!(self.text[self.at + 1], b'\n')
    }

    /// Reads commands up to the end, or, in a substitution, up to its `]`. Returns true if the `]` was found.
    fn script(&mut self, nested: bool) -> Result<bool, UnclosedError> {
        loop {
            match self.peek() {
                None => return Ok(false),
                Some(b']') if nested => {
                    self.at += 1;
                    return Ok(true);
                }
                Some(b' ' | b'\t' | b'\r' | 0xb | 0xc | b'\n' | b';') => self.at += 1,
                Some(_) if self.at_continuation() => self.skip_escape(),
                Some(b'#') => self.comment()?,
                Some(_) => self.command(nested)?,
            }
        }
    }

    fn comment(&mut self) -> Result<(), UnclosedError> {
        let start = self.at;
        while let Some(c) = self.peek() {
            match c {
                b'\\' => self.skip_escape(),
                b'\n' => break,
                _ => self.at += 1,
            }
        }
        let marks = [LITERAL.0, SUBSTITUTE.0].map(|text| text.as_bytes()[0]);
        if self.text[start..self.at].iter().any(|byte| marks.contains(byte)) {
            // Half of the swallowed text is behind it.
            return Err(self.open(start, 1, FlawKind::Comment));
        }
        Ok(())
    }

    fn command(&mut self, nested: bool) -> Result<(), UnclosedError> {
        let mut words = Vec::new();
        loop {
            match self.peek() {
                Some(b' ' | b'\t' | b'\r' | 0xb | 0xc) => self.at += 1,
                Some(_) if self.at_continuation() => self.skip_escape(),
                None | Some(b'\n' | b';') => break,
                Some(b']') if nested => break,
                Some(_) => words.push(self.word(nested)?),
            }
        }
        if let Some(first) = words.first() {
            let name = &self.text[first.range.clone()];
            if name.starts_with(b"}") {
                self.note(first.range.start..first.range.start + 1, FlawKind::Stray);
            } else if matches!(name, b"else" | b"elseif") {
                self.note(first.range.clone(), FlawKind::Detached);
            }
        }
        self.bodies(&words)
    }

    /// Returns true if a word ends here.
    fn at_end_of_word(&self, nested: bool) -> bool {
        match self.peek() {
            None | Some(b' ' | b'\t' | b'\r' | 0xb | 0xc | b'\n' | b';') => true,
            Some(b']') => nested,
            Some(_) => self.at_continuation(),
        }
    }

    fn word(&mut self, nested: bool) -> Result<Word, UnclosedError> {
        let rest = &self.text[self.at..self.end];
        if rest.starts_with(b"{*}")
            && !matches!(rest.get(3), None | Some(b' ' | b'\t' | b'\n' | b';'))
        {
            self.at += 3;
        }
        let start = self.at;
        let quoted = self.peek().filter(|byte| matches!(byte, b'{' | b'"'));
        match quoted {
            Some(b'{') => self.braces()?,
            Some(_) => {
                self.at += 1;
                let closed = self.substituted(|reader| reader.peek() == Some(b'"'))?;
                if !closed {
                    return Err(self.open(start, 1, FlawKind::Quote));
                }
                self.at += 1;
            }
            None => {
                self.substituted(|reader| reader.at_end_of_word(nested))?;
            }
        }
        if let Some(quote) = quoted
            && !self.at_end_of_word(nested)
        {
            let at = self.at;
            let close = if quote == b'{' { '}' } else { '"' };
            self.note(at - 1..at, FlawKind::Extra(close));
            self.substituted(|reader| reader.at_end_of_word(nested))?;
        }
        Ok(Word { range: start..self.at, braced: quoted == Some(b'{') })
    }

    fn braces(&mut self) -> Result<(), UnclosedError> {
        let start = self.at;
        let mut depth = 0usize;
        while let Some(c) = self.peek() {
            match c {
                b'\\' => {
                    self.skip_escape();
                    continue;
                }
                b'{' => depth += 1,
                b'}' => depth -= 1,
                _ => {}
            }
            self.at += 1;
            if depth == 0 {
                return Ok(());
            }
        }
        Err(self.open(start, 1, FlawKind::Brace))
    }

    /// Reads text with substitutions, until `ends`. Returns true if the end was found.
    fn substituted(
        &mut self,
        ends: impl Fn(&Reader<'_>) -> bool + Copy,
    ) -> Result<bool, UnclosedError> {
        while let Some(c) = self.peek() {
            if ends(self) {
                return Ok(true);
            }
            match c {
                b'\\' => self.skip_escape(),
                b'[' => {
                    let start = self.at;
                    self.at += 1;
                    if !self.script(true)? {
                        return Err(self.open(start, 1, FlawKind::Bracket));
                    }
                }
                b'$' => self.variable()?,
                _ => self.at += 1,
            }
        }
        Ok(ends(self))
    }

    fn variable(&mut self) -> Result<(), UnclosedError> {
        let start = self.at;
        self.at += 1;
        if self.peek() == Some(b'{') {
            while let Some(c) = self.peek() {
                self.at += 1;
                if c == b'}' {
                    return Ok(());
                }
            }
            return Err(self.open(start, 2, FlawKind::Name));
        }
        while self.peek().is_some_and(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
            || self.text[self.at..self.end].starts_with(b"::")
        {
            self.at += if self.text[self.at] == b':' { 2 } else { 1 };
        }
        if self.peek() == Some(b'(') {
            let length = self.at + 1 - start;
            self.at += 1;
            if !self.substituted(|reader| reader.peek() == Some(b')'))? {
                return Err(self.open(start, length, FlawKind::Index));
            }
            self.at += 1;
        }
        Ok(())
    }

    /// Checks the words of a command that are scripts.
    fn bodies(&mut self, words: &[Word]) -> Result<(), UnclosedError> {
        let Some((name, arguments)) = words.split_first() else {
            return Ok(());
        };
        let scripts: Vec<&Word> = match &self.text[name.range.clone()] {
            b"if" => self.branches(arguments),
            b"foreach" | b"lmap" if arguments.len() >= 3 => arguments.last().into_iter().collect(),
            b"while" if arguments.len() == 2 => vec![&arguments[1]],
            b"proc" if arguments.len() == 3 => vec![&arguments[2]],
            b"for" if arguments.len() == 4 => [0, 2, 3].map(|argument| &arguments[argument]).into(),
            _ => Vec::new(),
        };
        for word in scripts.into_iter().filter(|script| script.braced) {
            // A word that continues after its brace is already recorded.
            let inside = word.range.start + 1..word.range.end - 1;
            if self.depth == DEPTH || self.text[word.range.end - 1] != b'}' {
                continue;
            }
            let outside = (self.at, self.end);
            (self.at, self.end) = (inside.start, inside.end);
            self.depth += 1;
            let read = self.script(false);
            self.depth -= 1;
            read?;
            (self.at, self.end) = outside;
        }
        Ok(())
    }

    /// The scripts of `if`: `if C ?then? S ?elseif C ?then? S?... ??else? S?`.
    fn branches<'w>(&self, arguments: &'w [Word]) -> Vec<&'w Word> {
        let is = |word: &Word, what: &[u8]| self.text[word.range.clone()] == *what;
        let mut out = Vec::new();
        // The condition.
        let mut rest = arguments.get(1..).unwrap_or_default();
        while let Some((word, after)) = rest.split_first() {
            rest = after;
            if is(word, b"elseif") {
                rest = after.get(1..).unwrap_or_default();
            } else if !is(word, b"then") && !is(word, b"else") {
                out.push(word);
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(script: &str, flaws: Vec<Flaw>) -> Vec<String> {
        let one = |flaw: Flaw| {
            format!("{} {:?} {}", flaw.range.start, flaw.kind, &script[flaw.range.clone()])
        };
        flaws.into_iter().map(one).collect()
    }

    fn check(script: &str) -> Vec<String> {
        shown(script, flaws(script))
    }

    #[test]
    fn healthy_scripts() {
        for script in [
            "",
            "# { [ \"\nset a {\\{}\nset b \"\\\"{ $a(x y) [list \"a b\" {c}] ${odd name}\"",
            "if {$a} then {set b \"x\"} elseif {$c} {set d {}} else {foreach e $f {puts [list $e]}}",
            "puts a\"b; puts a{b; puts c}d; puts ]; puts {*}$argv {*}{a b}",
            "foreach x {1 2} \\\n  { puts $x }\nset s {an \"odd text [}",
            "proc f {a {b 1}} { return $a$b }; for {set i 0} {$i < 3} {incr i} {f $i}",
            "switch -- $x { a { b } default { c } }\nset y [expr {$x < 3 ? \"[f]\" : \"\\}\"}]",
            "regsub -all {[{}]} $a \"\" b; set p $; set q $::ns::v; set r \"cost: $\"",
        ] {
            assert_eq!(check(script), [""; 0], "{script}");
        }
    }

    #[test]
    fn words_without_an_end() {
        assert_eq!(check("a\nif {$x} {\n puts {y}\n"), ["10 Brace {"]);
        assert_eq!(check("puts [list a {b}"), ["5 Bracket ["]);
        assert_eq!(check("puts \"a [b]\nc"), ["5 Quote \""]);
        assert_eq!(check("puts ${a b"), ["5 Name ${"]);
        assert_eq!(check("puts $a(b c"), ["5 Index $a("]);
    }

    #[test]
    fn what_is_inside_the_bodies_of_commands_counts() {
        assert_eq!(check("foreach x $l { puts [f $x }"), ["20 Bracket ["]);
        assert_eq!(check("if {1} {a} else {puts \"b}"), ["22 Quote \""]);
        assert_eq!(check("proc f {} { while {1} { puts $a( } }"), ["29 Index $a("]);
        // It is not known that this text is evaluated.
        assert_eq!(check("set a { puts [f }"), [""; 0]);
    }

    #[test]
    fn commands_that_are_none() {
        assert_eq!(
            check("if {1} {\n}\nelse {\n}\n}\n}"),
            ["11 Detached else", "20 Stray }", "22 Stray }"]
        );
        assert_eq!(check("set a {b}c; set d \"e\"f"), ["8 Extra('}') }", "20 Extra('\"') \""]);
    }

    #[test]
    fn substituted_texts() {
        let check = |text: &str| shown(text, subst_flaws(text));
        assert_eq!(check("a \" { } ; # $b ] \\[ [f \"x\"]"), [""; 0]);
        assert_eq!(check("a [f {x}"), ["2 Bracket ["]);
        assert_eq!(check("${a"), ["0 Name ${"]);
        assert_eq!(check("[f \"]"), ["3 Quote \""]);
    }
}
