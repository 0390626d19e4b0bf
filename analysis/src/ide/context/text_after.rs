//! The text after the cursor: the rest of the list and statement around it, and the statements after it.

use dotgen_syntax::SyntaxKind;
use smol_str::SmolStr;

use super::Word;
use crate::ide::FileView;

/// Maximum number of tokens to scan; few bodies are longer.
const MOST: usize = 4_000;

/// The text after the cursor; see the module.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct TextAfter {
    /// The rest of the statement, brackets included, up to its `;`, to the end of the innermost body, or to a
    /// `{`.
    pub(crate) rest: Vec<Word>,
    /// True if the first of these is on the line of the cursor.
    pub(crate) same_line: bool,
    /// First words of the statements behind this one in the same body.
    pub(crate) later: Vec<SmolStr>,
    /// True if the next token is the `;` that ends the statement.
    pub(crate) ends: bool,
}

impl TextAfter {
    pub(super) fn new(view: &FileView<'_>, at: usize) -> TextAfter {
        let (raw, text) = (view.raw(), view.text());
        let mut out = TextAfter::default();
        if raw.is_empty() || at >= text.len() {
            return out;
        }
        let first = raw.token_at(at);
        let mut rest_open = true;
        let mut begins = false;
        let mut line = true;
        let mut directive = false;
        let mut depth = 0_usize;
        for i in (first..raw.len()).take(MOST) {
            let (kind, range) = (raw.kind(i), raw.range(i));
            if range.start < at {
                continue;
            }
            let spelt = raw.text(text, i);
            if kind.is_trivia() {
                let breaks = spelt.contains('\n');
                line &= !breaks;
                directive &= !breaks;
                continue;
            }
            directive |= spelt == "#";
            if directive {
                continue;
            }
            if out.rest.is_empty() && rest_open {
                out.same_line = line;
                out.ends = kind == SyntaxKind::SEMICOLON;
            }
            use SyntaxKind::*;
            match kind {
                // A bracket that is closed here was opened before the cursor; except for braces, it ends only
                // a list.
                R_CURLY if depth == 0 => break,
                R_CURLY => depth -= 1,
                L_CURLY => {
                    rest_open = false;
                    depth += 1;
                }
                SEMICOLON if depth == 0 => {
                    rest_open = false;
                    begins = true;
                    continue;
                }
                _ => {}
            }
            if begins && depth == 0 {
                out.later.push(spelt.into());
            }
            begins = kind == R_CURLY && depth == 0;
            if rest_open {
                out.rest.push(Word {
                    kind: match kind {
                        kind if kind.is_keyword() => IDENT,
                        kind => kind,
                    },
                    text: spelt.into(),
                    range,
                });
            }
        }
        out
    }

    /// The next word or sign of the statement, if it is on the line of the cursor.
    pub(crate) fn next(&self) -> Option<&Word> {
        self.rest.first().filter(|_| self.same_line)
    }

    /// The rest of the list around the cursor: up to the bracket that closes it, or to the end of the
    /// statement.
    pub(crate) fn list(&self) -> &[Word] {
        let mut depth = 0_i32;
        let end = self.rest.iter().position(|word| {
            match word.text.as_str() {
                "(" | "[" | "<" => depth += 1,
                ")" | "]" | ">" => depth -= 1,
                _ => {}
            }
            depth < 0
        });
        &self.rest[..end.unwrap_or(self.rest.len())]
    }
}
