//! Small edits of the text of a scenario: they change the value of an item in place.

use std::ops::Range;

use num_rational::Ratio;

use dotgen_analysis::model::Seconds;

use super::ast::{Item, Unit};
use super::lexer::{Kind, Token, lex};
use super::parse;

/// Returns the edit that changes a setting of the scenario (`cores`, `policy`). It changes the last item with
/// this word, which is the one that counts, or adds an item behind the last `use`. Returns `None` if the text
/// has no such place.
pub fn setting(text: &str, word: &str, value: &str) -> Option<(Range<usize>, String)> {
    let tokens: Vec<Token> = lex(text).into_iter().filter(|lex| !lex.kind.is_trivia()).collect();
    let of = |at: usize| tokens.get(at).map_or("", |token: &Token| &text[token.range.clone()]);
    let mut depth = 0;
    let (mut found, mut last_use) = (None, None);
    for at in 0..tokens.len() {
        let starts = depth == 1 && at > 0 && [";", "{", "}"].contains(&of(at - 1));
        match of(at) {
            "{" => depth += 1,
            "}" => depth -= 1,
            name if starts && (name == word || name == "use") => {
                let end = (at..tokens.len()).find(|&token| of(token) == ";")?;
                if name == "use" {
                    last_use = Some(tokens[end].range.end);
                } else if end > at + 1 {
                    found = Some(tokens[at + 1].range.start..tokens[end - 1].range.end);
                }
            }
            _ => {}
        }
    }
    match (found, last_use) {
        (Some(range), _) => Some((range, value.to_owned())),
        (None, Some(end)) => Some((end..end, format!("\n  {word} {value};"))),
        (None, None) => None,
    }
}

/// Returns the edit that sets the longest time of a codel, if the scenario states a `duration` for its path;
/// the last one counts. Returns `None` for a time that no scenario can state, such as a part of a
/// microsecond.
pub fn longest(text: &str, codel: &str, at_most: Seconds) -> Option<(Range<usize>, String)> {
    let items = parse(text).scenario.items.into_iter();
    let (path, interval, unit) = items.rev().find_map(|item| match item {
        Item::Duration(path, interval, unit) if path.text() == codel => {
            Some((path, interval, unit))
        }
        _ => None,
    })?;
    let micros = |seconds: Seconds| seconds / Unit::Microseconds.seconds();
    let lower = unit.seconds() * Ratio::from_integer(i128::from(interval.lower));
    let upper = micros(at_most);
    if !upper.is_integer() {
        return None;
    }
    let upper = upper.to_integer();
    let lower = micros(lower).floor().to_integer().min(upper);
    let start = path.range().end;
    let end = lex(text)
        .into_iter()
        .find(|lex| lex.range.start >= start && lex.kind == Kind::Semicolon)?
        .range
        .start;
    Some((start..end, format!(" [{lower}, {upper}] us")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn made(text: &str, edit: Option<(Range<usize>, String)>) -> String {
        let (range, new) = edit.expect("an edit");
        let mut text = text.to_owned();
        text.replace_range(range, &new);
        text
    }

    #[test]
    fn the_setting_that_counts_is_changed_or_added_behind_the_uses() {
        let text = "scenario s {\n  use \"a.gen\"; // policy edf;\n  cores 1; cores free;\n  client k { delay 3 ms; }\n}";
        let more = made(text, setting(text, "cores", "3"));
        assert!(more.contains("cores 1; cores 3;"), "{more}");
        let other = made(text, setting(text, "policy", "fifo"));
        assert!(other.contains("use \"a.gen\";\n  policy fifo; // policy edf;"), "{other}");
        // An action of a client is not a setting.
        let delay = made(text, setting(text, "delay", "9"));
        assert!(delay.contains("client k { delay 3 ms; }"), "{delay}");
        assert_eq!(setting("scenario s { }", "cores", "2"), None);
        assert_eq!(setting("scenario s { cores", "cores", "2"), None);
    }

    #[test]
    fn the_last_duration_of_a_codel_gets_another_upper_bound() {
        let text = "scenario s { duration a.t.main 4 ms; duration a.t.main [1, 5] ms; duration b.t.x 2 ms; }";
        let time = Seconds::new(7, 2000);
        let new = made(text, longest(text, "a.t.main", time));
        assert!(new.contains("duration a.t.main [1000, 3500] us; duration b.t.x 2 ms;"), "{new}");
        assert_eq!(longest(text, "a.t.other", time), None);
        assert_eq!(longest(text, "b.t.x", Seconds::new(1, 3_000_000)), None);
    }
}
