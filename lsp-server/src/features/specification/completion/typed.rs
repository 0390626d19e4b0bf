//! The decision if a typed character asks for proposals.
//!
//! Clients ask after each trigger character, in every context. A list that opens in an indentation or after a
//! comment would take the next Enter as a choice.

use crate::protocol::convert::Lines;
use crate::protocol::types::*;

/// True if proposals are wanted. False only after a character that has another meaning in its context.
pub(super) fn wanted(
    context: Option<&CompletionContext>,
    lines: &Lines,
    position: Position,
) -> bool {
    let by_character = |context: &&CompletionContext| {
        context.trigger_kind == CompletionTriggerKind::TRIGGER_CHARACTER
    };
    if context.as_ref().is_none_or(|x| !by_character(x)) {
        return true;
    }
    let line = lines.line(position.line).zip(lines.offset(position));
    line.is_none_or(|(line, at)| asks(&lines.text()[line.start..at.max(line.start)]))
}

/// True if the last character of the beginning of a line asks for proposals.
fn asks(before: &str) -> bool {
    let Some(typed) = before.chars().next_back() else {
        return true;
    };
    let before = &before[..before.len() - typed.len_utf8()];
    let in_string = before.matches('"').count() % 2 == 1;
    let directive = before.trim_start().starts_with('#');
    match typed {
        // After a word or between the items of a list, not in an indentation or after a complete item.
        ' ' => {
            let before = before.strip_suffix("<=").unwrap_or(before);
            before.ends_with(|character: char| {
                character.is_alphanumeric() || matches!(character, '_' | ',' | '=' | ')' | '>')
            })
        }
        // In a list of states or elements, not in a comparison.
        '<' => directive || !before.ends_with(' '),
        // In a path.
        ':' => before.ends_with(':'),
        // Before a member, not in a number.
        '.' => {
            let word =
                before.rsplit(|character: char| !character.is_alphanumeric() && character != '_');
            let mut word = word.map(|word| word.starts_with(|c: char| c.is_ascii_digit()));
            directive || in_string || word.next() != Some(true)
        }
        // At the beginning of a string, not at its end.
        '"' => !in_string,
        '/' => directive || in_string,
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::asks;

    #[test]
    fn where_a_name_may_follow() {
        for before in [
            "  yield ",
            "  codel<start> f(in x, ",
            "  codel<start> f(in x) ",
            "  const long n = ",
            "  yield pause::",
            "#include \"",
            "#include \"or/",
            "#include \"../",
            "#include <or/",
            "  requires \"",
            "  use \"idl/",
            "  codel<",
            "#",
            "  x = a1.",
            "  out trajectory.",
        ] {
            assert!(asks(before), "{before:?}");
        }
    }

    #[test]
    fn not_where_a_line_break_is_next() {
        for before in [
            " ",
            "    ",
            "  double x; ",
            "  double x;  ",
            "  } ",
            "  ids { ",
            "  /* why */",
            "  /* why */ ",
            "  //",
            "  doc \"Moves the arm.\"",
            "  in double x = 1.",
            "  in double x = 0. :",
            "  yield pause:",
            "  check within a => b <",
            "  check within a => b <= ",
        ] {
            assert!(!asks(before), "{before:?}");
        }
    }
}
