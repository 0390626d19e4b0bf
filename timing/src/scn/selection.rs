//! The nested ranges around a place of a scenario, for growing selections.

use std::ops::Range;

use super::lexer::{Kind, lex};

/// Returns the ranges that contain an offset, the smallest first: the word, the path, the item, the contents
/// of the brackets, the brackets, …, the whole text.
pub fn selections(text: &str, offset: usize) -> Vec<Range<usize>> {
    let whole = 0..text.len();
    let mut ranges = Vec::from([whole]);
    let mut open: Vec<Level> = vec![Level::at(0)];
    let mut path: Option<Range<usize>> = None;
    for token in lex(text) {
        let Range { start, end } = token.range;
        if token.kind == Kind::Space {
            continue;
        }
        // At the end of a word, the word counts and not the punctuation after it.
        if token.kind.is_trivia() || matches!(token.kind, Kind::Name | Kind::Number | Kind::Text) {
            ranges.push(start..end);
        }
        if token.kind.is_trivia() {
            continue;
        }
        path = match (token.kind, path) {
            (Kind::Name | Kind::Dot, Some(path)) if path.end == start => Some(path.start..end),
            (Kind::Name, _) => Some(start..end),
            _ => None,
        };
        ranges.extend(path.clone());
        let ends = matches!(
            token.kind,
            Kind::CloseBrace | Kind::CloseBracket | Kind::CloseParen | Kind::Semicolon
        );
        if let Some(level) = open.last_mut().filter(|_| !ends) {
            level.item.get_or_insert(start);
        }
        match token.kind {
            Kind::OpenBrace | Kind::OpenBracket | Kind::OpenParen => open.push(Level::at(start)),
            Kind::CloseBrace | Kind::CloseBracket | Kind::CloseParen if open.len() > 1 => {
                let closed = open.pop().map_or(start, |level| level.bracket);
                ranges.push(closed + 1..start);
                ranges.push(closed..end);
                if token.kind == Kind::CloseBrace {
                    ranges.extend(end_item(&mut open, end));
                }
            }
            Kind::Semicolon => ranges.extend(end_item(&mut open, end)),
            _ => {}
        }
    }
    ranges.retain(|range| range.start <= offset && offset <= range.end && !range.is_empty());
    ranges.sort_by_key(|range| (range.len(), range.start));
    ranges.dedup();
    // At the border of two words only one of them can be in a chain of nested ranges.
    let mut chain: Vec<Range<usize>> = Vec::new();
    for range in ranges {
        let inner = chain.last();
        if inner.is_none_or(|inner| range.start <= inner.start && inner.end <= range.end) {
            chain.push(range);
        }
    }
    chain
}

/// A pair of brackets that is not closed yet.
struct Level {
    /// The offset of the opening bracket.
    bracket: usize,
    /// The start of the present item.
    item: Option<usize>,
}

impl Level {
    fn at(bracket: usize) -> Level {
        Level { bracket, item: None }
    }
}

/// Ends the present item of the innermost level, and returns the range of the item.
fn end_item(open: &mut [Level], end: usize) -> Option<Range<usize>> {
    let start = open.last_mut()?.item.take()?;
    Some(start..end)
}

#[cfg(test)]
mod tests {
    use super::selections;

    fn texts(text: &str) -> Vec<String> {
        let offset = text.find('$').expect("a cursor");
        let text = text.replace('$', "");
        let ranges = selections(&text, offset);
        ranges.into_iter().map(|range| text[range].to_owned()).collect()
    }

    #[test]
    fn selections_grow_from_the_word_to_the_text() {
        let text = "scenario s {\n  client c { send a.bcd$; await a.b; }\n  check x: response a.t <= 8 ms;\n}\n";
        assert_eq!(
            texts(text),
            [
                "bcd",
                "a.bcd",
                "send a.bcd;",
                " send a.bcd; await a.b; ",
                "{ send a.bcd; await a.b; }",
                "client c { send a.bcd; await a.b; }",
                "\n  client c { send a.bcd; await a.b; }\n  check x: response a.t <= 8 ms;\n",
                "{\n  client c { send a.bcd; await a.b; }\n  check x: response a.t <= 8 ms;\n}",
                "scenario s {\n  client c { send a.bcd; await a.b; }\n  check x: response a.t <= 8 ms;\n}",
                "scenario s {\n  client c { send a.bcd; await a.b; }\n  check x: response a.t <= 8 ms;\n}\n",
            ]
        );
    }

    #[test]
    fn incomplete_texts_have_nested_selections() {
        assert_eq!(texts("} ; ) check $a."), ["a", "a.", "} ; ) check a."]);
        assert_eq!(texts("$"), Vec::<String>::new());
    }
}
