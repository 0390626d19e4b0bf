use proptest::prelude::*;

use super::*;

/// Bytes in which every interesting value is frequent: parts of sequences, escapes, line ends.
fn bytes() -> impl Strategy<Value = Vec<u8>> {
    let piece = prop_oneof![
        any::<Vec<u8>>(),
        any::<String>().prop_map(String::into_bytes),
        (0x80u8..).prop_map(|byte| escape_of(byte).to_string().into_bytes()),
        proptest::sample::select(vec![
            &b"\xe9"[..],
            b"caf\xe9 \xc3",
            b"\xf4\x8f\x9e",
            b"\xf4\x8f\x9f\xbf",
            b"\xef\xbb\xbf",
            b"\xef\xbf\xbd",
            b"\r\n",
            b"\n",
            b"\xed\xa0\x80",
            b"\0",
        ])
        .prop_map(<[u8]>::to_vec),
    ];
    proptest::collection::vec(piece, 0..8).prop_map(|bytes| bytes.concat())
}

proptest! {
    #[test]
    fn every_byte_string_comes_back(bytes in bytes()) {
        let text = decode(bytes.clone());
        prop_assert_eq!(encode(&text).into_owned(), bytes.clone());
        prop_assert_eq!(first_escape(&shown(&text)).is_some(), has_real_escape(&bytes));
        if String::from_utf8(bytes.clone()).is_ok_and(|text| first_escape(&text).is_none()) {
            prop_assert_eq!(text.as_bytes(), &bytes[..], "valid text is not touched");
        }
    }

    #[test]
    fn an_edit_leaves_other_bytes_alone(
        bytes in bytes(), new in any::<String>(), from in any::<prop::sample::Index>(), to in any::<prop::sample::Index>()
    ) {
        let text = decode(bytes.clone());
        let places: Vec<usize> = text.char_indices().map(|(at, _)| at).chain([text.len()]).collect();
        let (from, to) = (from.index(places.len()), to.index(places.len()));
        let (from, to) = (places[from.min(to)], places[from.max(to)]);
        let edited = format!("{}{}{}", &text[..from], escape(&new), &text[to..]);
        let expected = [&encode(&text[..from])[..], new.as_bytes(), &encode(&text[to..])].concat();
        prop_assert_eq!(encode(&edited).into_owned(), expected);
        // The text on both sides of the edit is unchanged.
        let at = bytes.len() - encode(&text[to..]).len();
        prop_assert_eq!(&encode(&text[..from])[..], &bytes[..encode(&text[..from]).len()]);
        prop_assert_eq!(&encode(&text[to..])[..], &bytes[at..]);
    }

    #[test]
    fn text_of_others_is_taken_as_it_is(text in any::<String>()) {
        let escaped = escape(&text).into_owned();
        prop_assert_eq!(encode(&escaped).into_owned(), text.clone().into_bytes());
        prop_assert_eq!(decode(text.clone().into_bytes()), escaped);
    }
}

/// Returns true if a file holds scalars that look like escapes: they are shown as themselves.
fn has_real_escape(bytes: &[u8]) -> bool {
    first_escape(&String::from_utf8_lossy(bytes)).is_some()
}

#[test]
fn bytes_that_are_no_utf8_are_one_scalar_each() {
    let text = decode(b"/* caf\xe9, \xff\xfe */".to_vec());
    assert_eq!(text, "/* caf\u{10f7e9}, \u{10f7ff}\u{10f7fe} */");
    assert_eq!(shown(&text), "/* caf\u{fffd}, \u{fffd}\u{fffd} */");
    assert_eq!(latin1(&text), "/* café, ÿþ */");
    assert_eq!(first_escape(&text), Some(6));
    assert_eq!(first_escape("/* café 😀 */"), None);
}

#[test]
fn line_ends_are_those_of_most_lines() {
    assert_eq!(LineEnd::of("a\r\nb\r\nc\n"), LineEnd::CrLf);
    assert_eq!(LineEnd::of("a\r\nb\n"), LineEnd::Lf);
    assert_eq!(LineEnd::of("a"), LineEnd::Lf);
    assert_eq!(LineEnd::CrLf.fit("a\nb\r\nc"), "a\r\nb\r\nc");
    assert_eq!(LineEnd::Lf.fit("a\nb\r\nc"), "a\nb\nc");
}

#[test]
fn files_in_wider_units_are_recognised() {
    let text = "// caf\u{e9}\nstruct a { long x; };\n";
    let little = |text: &str| text.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<_>>();
    let big = |text: &str| text.encode_utf16().flat_map(u16::to_be_bytes).collect::<Vec<_>>();
    let marked = format!("\u{feff}{text}");
    for bytes in [little(text), big(text), little(&marked), big(&marked), little("\u{feff}")] {
        assert_eq!(other_unicode(&bytes), Some("UTF-16"), "{bytes:x?}");
    }
    let wide: Vec<u8> = marked.chars().flat_map(|c| u32::from(c).to_le_bytes()).collect();
    assert_eq!(other_unicode(&wide), Some("UTF-32"));
    for bytes in [
        &b""[..],
        b"\0",
        b"a\0",
        b"\xef\xbb\xbfab",
        b"caf\xe9",
        b"ab\0cd\0ef",
        b"\xff",
        b"\0\0\0\0",
    ] {
        assert_eq!(other_unicode(bytes), None, "{bytes:x?}");
    }
    assert_eq!(other_unicode(text.as_bytes()), None);
}
