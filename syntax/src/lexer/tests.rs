use expect_test::{Expect, expect};
use proptest::prelude::*;

use super::*;

fn dump(text: &str) -> String {
    let raw = lex(text);
    let tokens = (0..raw.len()).filter(|&i| raw.kind(i) != WHITESPACE);
    tokens.map(|i| format!("{:?} {:?}\n", raw.kind(i), raw.text(text, i))).collect()
}

fn check(text: &str, expect: Expect) {
    assert_covers(text);
    expect.assert_eq(&dump(text));
}

fn assert_covers(text: &str) {
    let raw = lex(text);
    let joined: String = (0..raw.len()).map(|i| raw.text(text, i)).collect();
    assert_eq!(joined, text);
    assert!((0..raw.len()).all(|i| !raw.range(i).is_empty()), "an empty token in {text:?}");
}

#[test]
fn numbers_end_where_the_reference_says() {
    check(
        "10ms 12abc 0x 0x1FuL 1LL 1.5 .5 5. 1e3 1e 1.e-2 1.5E+3f 2.5d 500us",
        expect![[r#"
            INT "10"
            IDENT "ms"
            INT "12"
            IDENT "abc"
            INT "0"
            IDENT "x"
            INT "0x1FuL"
            INT "1L"
            IDENT "L"
            FLOAT "1.5"
            FLOAT ".5"
            FLOAT "5."
            FLOAT "1e3"
            INT "1"
            IDENT "e"
            FLOAT "1.e-2"
            FLOAT "1.5E+3f"
            FIXED "2.5d"
            INT "500u"
            IDENT "s"
        "#]],
    );
}

#[test]
fn hyphenated_keywords_are_single_tokens() {
    check(
        "clock-rate clock - rate clock-rat codels-requires codels-require real-time my-real-time",
        expect![[r#"
            IDENT "clock-rate"
            IDENT "clock"
            MINUS "-"
            IDENT "rate"
            IDENT "clock"
            MINUS "-"
            IDENT "rat"
            IDENT "codels-requires"
            IDENT "codels-require"
            IDENT "real-time"
            IDENT "my"
            MINUS "-"
            IDENT "real-time"
        "#]],
    );
}

#[test]
fn digraphs_and_operator_words_are_what_they_stand_for() {
    check(
        "<% %> <: :> ::> <:: %:%: %: xor not note >>",
        expect![[r#"
            L_CURLY "<%"
            R_CURLY "%>"
            L_BRACK "<:"
            R_BRACK ":>"
            COLON2 "::"
            R_ANGLE ">"
            L_BRACK "<:"
            COLON ":"
            HASH2 "%:%:"
            HASH "%:"
            CARET "xor"
            BANG "not"
            IDENT "note"
            SHR ">>"
        "#]],
    );
}

#[test]
fn strings_and_characters() {
    check(
        r#""a\\" "b\"c" 'x' '\'' "two
lines" 'open
"open
next"#,
        expect![[r#"
            STRING "\"a\\\\\""
            STRING "\"b\\\"c\""
            CHAR "'x'"
            CHAR "'\\''"
            STRING "\"two\nlines\""
            OPEN_STRING "'open"
            NEWLINE "\n"
            OPEN_STRING "\"open"
            NEWLINE "\n"
            IDENT "next"
        "#]],
    );
}

#[test]
fn the_name_of_an_included_file_ends_with_its_line() {
    check(
        "# /**/ include \"pose\nstring s = \"a\nb\"",
        expect![[r##"
            HASH "#"
            BLOCK_COMMENT "/**/"
            IDENT "include"
            OPEN_STRING "\"pose"
            NEWLINE "\n"
            STRING_KW "string"
            IDENT "s"
            EQ "="
            STRING "\"a\nb\""
        "##]],
    );
}

#[test]
fn line_ends_comments_and_stray_characters() {
    check(
        "a\r\nb\rc // d\r\n/* e\n*/ $@ é \0\0 \\ /* f",
        expect![[r#"
            IDENT "a"
            NEWLINE "\r\n"
            IDENT "b"
            NEWLINE "\r"
            IDENT "c"
            LINE_COMMENT "// d"
            NEWLINE "\r\n"
            BLOCK_COMMENT "/* e\n*/"
            STRAY "$@"
            STRAY "é"
            STRAY "\0\0"
            STRAY "\\"
            OPEN_COMMENT "/* f"
        "#]],
    );
}

#[test]
fn splices_join_lines_everywhere() {
    check(
        "co\\\nde \\\r\n clock\\\n-rate // on\\\nand on\n\"s\\\nt\"\\\n",
        expect![[r#"
            IDENT "co\\\nde"
            SPLICE "\\\r\n"
            IDENT "clock\\\n-rate"
            LINE_COMMENT "// on\\\nand on"
            NEWLINE "\n"
            STRING "\"s\\\nt\""
            SPLICE "\\\n"
        "#]],
    );
    let raw = lex("co\\\nde");
    assert_eq!(raw.clean_text("co\\\nde", 0), "code");
}

#[test]
fn tokens_are_found_by_offset() {
    let raw = lex("ab cd");
    let found: Vec<usize> = (0..=5).map(|offset| raw.token_at(offset)).collect();
    assert_eq!(found, [0, 0, 1, 2, 2, 2]);
}

#[test]
fn unterminated_strings_stay_linear() {
    let text = "\\\"\n".repeat(200_000);
    assert_covers(&text);
}

proptest! {
    #[test]
    fn tokens_cover_any_text(text in "\\PC*") {
        assert_covers(&text);
    }

    #[test]
    fn tokens_cover_texts_of_difficult_pieces(
        pieces in prop::collection::vec(
            prop::sample::select(vec![
                "\"", "'", "\\", "\n", "\r", "\r\n", "/*", "*/", "//", "#", "include", "a", "0x", "1e",
                ".", "-", "clock", "rate", "é", "\u{0}", " ", "<", ":", "%", "😀",
            ]),
            0..40,
        )
    ) {
        assert_covers(&pieces.concat());
    }

    #[test]
    fn tokens_cover_any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        assert_covers(&String::from_utf8_lossy(&bytes));
    }

    /// Splices change nothing but the text of the tokens.
    #[test]
    fn splices_do_not_change_tokens(text in "[a-z0-9\"'/*# \n.-]{0,40}", at in 0usize..40) {
        let at = at.min(text.len());
        let spliced = format!("{}\\\n{}", &text[..at], &text[at..]);
        let tokens = |text: &str| {
            let raw = lex(text);
            let mut tokens: Vec<(SyntaxKind, String)> = Vec::new();
            for i in (0..raw.len()).filter(|&i| raw.kind(i) != SPLICE) {
                let text = raw.clean_text(text, i);
                match tokens.last_mut() {
                    Some((WHITESPACE, blank)) if raw.kind(i) == WHITESPACE => blank.push_str(&text),
                    _ => tokens.push((raw.kind(i), text.into_owned())),
                }
            }
            tokens
        };
        prop_assert_eq!(tokens(&text), tokens(&spliced));
    }
}
