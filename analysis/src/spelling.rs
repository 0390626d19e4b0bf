//! Words and blanks with two spellings: inserted text follows the style of the file.

use std::cmp::Ordering;

use dotgen_syntax::{SyntaxKind, lexer::lex};

/// Words of the language with the same meaning (language reference, 3.3) that edits write.
const PAIRS: [[&str; 2]; 3] =
    [["yield", "yields"], ["throw", "throws"], ["interrupt", "interrupts"]];

/// The style of an author for words with two spellings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Spelling {
    /// For each pair, the index of the more frequent word.
    chosen: [Option<usize>; PAIRS.len()],
    /// True if most codels have blanks before their states.
    spaced: bool,
}

impl Spelling {
    /// The style of a text. Strings and comments do not count.
    pub fn of(text: &str) -> Spelling {
        let tokens = lex(text);
        let mut counts = [[0_usize; 2]; PAIRS.len()];
        let (mut glued, mut spaced) = (0_usize, 0_usize);
        for at in 0..tokens.len() {
            if tokens.kind(at) != SyntaxKind::IDENT {
                continue;
            }
            let word = tokens.text(text, at);
            if word == "codel" {
                match (tokens.text(text, at + 1), tokens.text(text, at + 2)) {
                    ("<", _) => glued += 1,
                    (_, "<") => spaced += 1,
                    _ => {}
                }
            } else if let Some((pair, which)) = place(word) {
                counts[pair][which] += 1;
            }
        }
        Spelling {
            chosen: counts.map(|length| match length[0].cmp(&length[1]) {
                Ordering::Greater => Some(0),
                Ordering::Equal => None,
                Ordering::Less => Some(1),
            }),
            spaced: spaced > glued,
        }
    }

    /// A piece of specification in this style. Strings and comments stay, and so do words that the author
    /// writes in both ways, or never.
    pub fn apply(self, piece: &str) -> String {
        let tokens = lex(piece);
        let mut out = String::with_capacity(piece.len() + 8);
        for at in 0..tokens.len() {
            let word = tokens.text(piece, at);
            let chosen = place(word).and_then(|(pair, _)| Some(PAIRS[pair][self.chosen[pair]?]));
            out.push_str(chosen.unwrap_or(word));
            if self.spaced && word == "codel" && tokens.text(piece, at + 1) == "<" {
                out.push(' ');
            }
        }
        out
    }
}

/// The pair of a word, and its index in the pair.
fn place(word: &str) -> Option<(usize, usize)> {
    Some(match word {
        "yield" => (0, 0),
        "yields" => (0, 1),
        "throw" => (1, 0),
        "throws" => (1, 1),
        "interrupt" => (2, 0),
        "interrupts" => (2, 1),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::Spelling;

    fn as_in(text: &str, piece: &str) -> String {
        Spelling::of(text).apply(piece)
    }

    #[test]
    fn of_two_words_the_one_that_is_there() {
        let piece = "codel<start> f() yield ether; // yield\nthrow x;";
        assert_eq!(as_in("", piece), piece);
        assert_eq!(as_in("// yields throws\n\"yields\"", piece), piece);
        assert_eq!(
            as_in("codel <a> g() yields a; codel <b> h() yields b; codel<c> i() yield a;", piece),
            "codel <start> f() yields ether; // yield\nthrow x;"
        );
        assert_eq!(as_in("codel f(); codel g(); codel<a> h() yield b;", piece), piece);
    }
}
