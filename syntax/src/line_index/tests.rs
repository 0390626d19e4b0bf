use proptest::prelude::*;

use super::{PositionEncoding::*, *};

#[test]
fn lines_end_in_three_ways() {
    let index = LineIndex::new("a\nbc\r\nd\re");
    let lines: Vec<(u32, u32)> = (0..index.line_count())
        .filter_map(|line| index.line_range(line))
        .map(|range| (range.start().into(), range.end().into()))
        .collect();
    assert_eq!(lines, [(0, 1), (2, 4), (6, 7), (8, 9)]);
    // Between \r and \n is the end of the line.
    assert_eq!(index.line_col(5.into(), Utf8), LineCol { line: 1, col: 2 });
}

#[test]
fn columns_depend_on_the_encoding() {
    let index = LineIndex::new("é😀x\nü");
    let x = TextSize::new(6);
    assert_eq!(index.line_col(x, Utf8).col, 6);
    assert_eq!(index.line_col(x, Utf16).col, 3);
    assert_eq!(index.line_col(x, Utf32).col, 2);
    // Inside the surrogate pair, and beyond the line.
    assert_eq!(index.offset(LineCol { line: 0, col: 2 }, Utf16), Some(2.into()));
    assert_eq!(index.offset(LineCol { line: 0, col: 99 }, Utf16), Some(7.into()));
    assert_eq!(index.offset(LineCol { line: 2, col: 0 }, Utf16), None);
    assert_eq!(index.offset(LineCol { line: 1, col: u32::MAX }, Utf32), Some(10.into()));
}

/// Position of a character boundary, by counting.
fn naive(text: &str, offset: usize, encoding: PositionEncoding) -> LineCol {
    let mut position = LineCol { line: 0, col: 0 };
    let mut chars = text.char_indices().peekable();
    while let Some((at, char)) = chars.next() {
        if at >= offset {
            break;
        }
        let crlf = char == '\r' && chars.peek().is_some_and(|&(_, next)| next == '\n');
        if crlf {
            if offset == at + 1 {
                break;
            }
            chars.next();
        }
        if matches!(char, '\n' | '\r') {
            position = LineCol { line: position.line + 1, col: 0 };
        } else {
            position.col += match encoding {
                Utf8 => char.len_utf8(),
                Utf16 => char.len_utf16(),
                Utf32 => 1,
            } as u32;
        }
    }
    position
}

proptest! {
    #[test]
    fn agrees_with_counting(text in "[a\\n\\ré😀漢]{0,30}") {
        let index = LineIndex::new(&text);
        for encoding in [Utf8, Utf16, Utf32] {
            for offset in (0..=text.len()).filter(|&at| text.is_char_boundary(at)) {
                let expected = naive(&text, offset, encoding);
                let size = TextSize::new(offset as u32);
                prop_assert_eq!(index.line_col(size, encoding), expected, "{:?}", offset);
                let inside_crlf = offset > 0 && text[..offset].ends_with('\r') && text[offset..].starts_with('\n');
                if !inside_crlf {
                    prop_assert_eq!(index.offset(expected, encoding), Some(size));
                }
            }
        }
    }

    #[test]
    fn is_total_and_on_boundaries(text in "[a\\n\\ré😀]{0,20}", offset in any::<u32>(), line in 0u32..30, col in any::<u32>()) {
        let index = LineIndex::new(&text);
        for encoding in [Utf8, Utf16, Utf32] {
            index.line_col(offset.into(), encoding);
            index.line_col((offset % 64).into(), encoding);
            for col in [col, col % 30] {
                if let Some(found) = index.offset(LineCol { line, col }, encoding) {
                    prop_assert!(text.is_char_boundary(found.into()));
                }
            }
        }
    }
}
