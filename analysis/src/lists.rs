//! Appends to comma-separated lists (`yield`, `throw`, parameters) in the layout of their author.

use std::ops::Range;

use dotgen_syntax::line_index::line_start;

/// Maximum length of a line in columns. A longer line of a list is broken if other lines of the list are.
const LONG: usize = 80;

/// The insertions that put an item behind the last of a list: with the separator, the line break and the
/// indentation of the others. A comment stays with its item. `items` are the ranges of the items in text
/// order. Returns nothing for an empty list.
pub fn append_to_list(
    text: &str,
    items: &[Range<usize>],
    item: &str,
) -> Vec<(Range<usize>, String)> {
    let Some(last) = items.last() else {
        return Vec::new();
    };
    let separators: Vec<Separator> = items
        .windows(2)
        .filter_map(|window| Separator::read(text.get(window[0].end..window[1].start)?))
        .collect();
    let mut separator = separators.last().cloned().unwrap_or_default();
    let column = last.end - line_start(text, last.end);
    if !separator.breaks()
        && column + 2 + item.len() > LONG
        && let Some(broken) = separators.iter().rev().find(|separator| separator.breaks())
    {
        separator = broken.clone();
    }
    let Separator { before, after } = separator;
    let behind = text.get(last.end..).unwrap_or_default();
    let blanks = behind.len() - behind.trim_start_matches([' ', '\t']).len();
    let comment = &behind[blanks..];
    let here = |at: usize, text: String| (at..at, text);
    if comment.starts_with("//") {
        let end = comment.find(['\r', '\n']).unwrap_or(comment.len());
        let end = last.end + blanks + end;
        if before.contains('\n') {
            return vec![here(end, format!("{before},{after}{item}"))];
        }
        let line = if after.contains('\n') {
            after
        } else {
            format!("\n{}", " ".repeat(last.start - line_start(text, last.start)))
        };
        return vec![here(last.end, ",".to_owned()), here(end, line + item)];
    }
    let length = comment.strip_prefix("/*").and_then(|rest| rest.find("*/"));
    let inline = length.filter(|length| !comment[..*length].contains('\n'));
    let at = inline.map_or(last.end, |inline| last.end + blanks + inline + 4);
    vec![here(at, format!("{before},{after}{item}"))]
}

/// The blanks around a comma.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Separator {
    before: String,
    after: String,
}

impl Default for Separator {
    fn default() -> Separator {
        Separator { before: String::new(), after: " ".to_owned() }
    }
}

impl Separator {
    /// The text between two items, without its comments; `None` if it is more than a comma.
    fn read(gap: &str) -> Option<Separator> {
        let mut sides = [String::new(), String::new()];
        let (mut side, mut rest) = (0, gap);
        while let Some(first) = rest.chars().next() {
            let length = match first {
                '/' if rest.starts_with("//") => rest.find('\n').unwrap_or(rest.len()),
                '/' if rest.starts_with("/*") => rest.find("*/")? + 2,
                ',' if side == 0 => {
                    side = 1;
                    1
                }
                character if character.is_whitespace() => {
                    if character != '\r' {
                        sides[side].push(character);
                    }
                    character.len_utf8()
                }
                _ => return None,
            };
            rest = &rest[length..];
        }
        let [before, after] = sides.map(|side| match side.rfind('\n') {
            // Neither empty lines nor the blanks before a comment.
            Some(at) => side[at..].to_owned(),
            None => side.get(..1).unwrap_or_default().to_owned(),
        });
        (side == 1).then_some(Separator { before, after })
    }

    fn breaks(&self) -> bool {
        self.before.contains('\n') || self.after.contains('\n')
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the list of the words `a1`, `b2`, … in a text, with `new` appended.
    #[track_caller]
    fn check(text: &str, wanted: &str) {
        let mut items = Vec::new();
        let mut at = 0;
        while let Some(found) = text[at..].find(|character: char| character.is_ascii_digit()) {
            items.push(at + found - 1..at + found + 1);
            at += found + 1;
        }
        let mut out = text.to_owned();
        for (range, insert) in append_to_list(text, &items, "new").into_iter().rev() {
            out.replace_range(range, &insert);
        }
        assert_eq!(out, wanted);
    }

    #[test]
    fn an_item_follows_as_the_others_do() {
        check("yield a1;", "yield a1, new;");
        check("yield a1,b2;", "yield a1,b2,new;");
        check("yield a1,\n      b2;", "yield a1,\n      b2,\n      new;");
        check("yield a1\n  , b2;", "yield a1\n  , b2\n  , new;");
        check("yield a1,\n\n\tb2\n;", "yield a1,\n\n\tb2,\n\tnew\n;");
    }

    #[test]
    fn comments_stay_at_their_items() {
        check(
            "yield a1, // one\n      b2; // two",
            "yield a1, // one\n      b2,\n      new; // two",
        );
        check(
            "yield a1, // one\n      b2 // two\n  ;",
            "yield a1, // one\n      b2, // two\n      new\n  ;",
        );
        check("yield a1 // one\n;", "yield a1, // one\n      new\n;");
        check("yield a1 /* one */;", "yield a1 /* one */, new;");
        check("a1 // one\n, b2 // two\n;", "a1 // one\n, b2 // two\n, new\n;");
    }

    #[test]
    fn a_line_that_gets_long_is_broken_as_others_are() {
        let long = format!("a1,\n b2, {}c3;", " ".repeat(72));
        check(&long, &long.replace(';', ",\n new;"));
    }

    #[test]
    fn what_is_no_list_gets_a_comma() {
        check("yield a1 x b2;", "yield a1 x b2, new;");
        assert_eq!(append_to_list("yield ;", &[], "new"), []);
    }
}
