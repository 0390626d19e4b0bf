//! Words and blanks with two ways, in inserted text as the author of the file has them.

use dotgen_syntax::lexer::lex;

/// Words of the language that mean the same (language reference, 2.3), the usual one first.
const PAIRS: [[&str; 2]; 7] = [
    ["yield", "yields"],
    ["throw", "throws"],
    ["interrupt", "interrupts"],
    ["provides", "provide"],
    ["uses", "use"],
    ["extends", "extend"],
    ["require", "requires"],
];

/// A piece of specification as the author of `text` would have written it: of two words that mean the same
/// the one that the text has more often, and blanks between `codel` and its states if it has them mostly.
/// Strings and comments of the piece stay.
pub fn as_in(text: &str, piece: &str) -> String {
    let tokens = lex(text);
    let words: Vec<&str> = (0..tokens.len()).map(|it| tokens.text(text, it)).collect();
    let count = |word: &str| words.iter().filter(|it| **it == word).count();
    let mut gaps = (0, 0);
    for it in words.windows(2).filter(|it| it[0] == "codel") {
        match it[1] {
            "<" => gaps.0 += 1,
            // A codel without states has a blank as well.
            blank if blank.trim().is_empty() => gaps.1 += 1,
            _ => {}
        }
    }
    let bare = words.windows(3);
    let bare = bare.filter(|it| it[0] == "codel" && it[1].trim().is_empty() && it[2] != "<");
    let spaced = gaps.1 - bare.count() > gaps.0;
    let tokens = lex(piece);
    let mut out = String::with_capacity(piece.len());
    for at in 0..tokens.len() {
        let word = tokens.text(piece, at);
        let pair = PAIRS.iter().find(|it| it.contains(&word));
        let other = pair.and_then(|it| it.iter().find(|it| **it != word));
        match other.filter(|it| count(it) > count(word)) {
            Some(other) => out.push_str(other),
            None => out.push_str(word),
        }
        if spaced && word == "codel" && tokens.text(piece, at + 1) == "<" {
            out.push(' ');
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::as_in;

    #[test]
    fn of_two_words_the_one_that_is_there() {
        let piece = "codel<start> f() yield ether; // yield\nthrow x;";
        assert_eq!(as_in("", piece), piece);
        assert_eq!(as_in("// yields throws\n\"yields\"", piece), piece);
        assert_eq!(
            as_in(
                "codel <a> g() yields a; codel <b> h() yields b; codel<c> i() yield a;",
                piece
            ),
            "codel <start> f() yields ether; // yield\nthrow x;"
        );
        assert_eq!(
            as_in("codel f(); codel g(); codel<a> h() yield b;", piece),
            piece
        );
    }
}
