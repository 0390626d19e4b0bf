//! Macros: definitions, calls, and the result of expansion.

use super::*;

#[test]
fn object_macros() {
    check(
        "#define N 4\n#define M N + __LINE__\n#define SELF SELF + x\n#define A B\n#define B A\n\
         long a[N] = M; SELF A\n\"N\" __FILE__ __GENOM__\n",
        expect![[r#"
            long a[ 4] = 4 + 6; SELF + x A
            "N" "main.gen" 2.99.41
        "#]],
    );
}

#[test]
fn function_macros() {
    check(
        "#define SQ(x) ((x)*(x))\n#define Z() 7\n#define LIST(first, ...) __VA_ARGS__ first\n\
         #define ID(x) x\n\
         SQ(SQ(a)) SQ Z( ) LIST(A, (B, C), D) LIST(A)\nID(SQ)(2) ID(\n1\n) ID()\n\
         #define f(x) x f\nf(1)(2)(3)\n#define g f\ng(1)(2)\n",
        expect![[r"
            ((((a)*(a)))*(((a)*(a)))) SQ 7 (B, C), D A A
            ((2)*(2)) 1
            1 f(2)(3)
            1 f(2)
        "]],
    );
}

#[test]
fn strings_and_pastes() {
    check(
        r#"#define S(x) #x
#define X(x) S(x)
#define CAT(a, b) a ## b
#define XCAT(a, b) CAT(a, b)
#define N 4
#define V(a, ...) a##__VA_ARGS__ #__VA_ARGS__
#define H # x
S( a  +/**/b ) S("q\n" 'c') X(N) S(N)
CAT(N, N) XCAT(N, N) CAT(,a) CAT(a,)x CAT(,) CAT(1, ms) CAT(clock-, rate)
V(a, b, c)
"#,
        expect![[r#"
            "a + b" "\"q\\n\" 'c'" "4" "N"
            NN 44 a ax 1ms clock-rate
            ab, c "b, c"
        "#]],
    );
}

/// The examples of the C standard on rescanning (6.10.3.5), but for the first line of the second.
#[test]
fn rescanning_as_in_the_standard() {
    check(
        r"#define x 3
#define f(a) f(x * (a))
#undef x
#define x 2
#define g f
#define z z[0]
#define h g(~
#define m(a) a(w)
#define w 0,1
#define t(a) a
#define p() int
#define q(x) x
#define r(x,y) x ## y
f(y+1) + f(f(z)) % t(t(g)(0) + t)(1);
g(x+(3,4)-w) | h 5) & m(f)^m(m);
p() i[q()] = { q(1), r(2,3), r(4,), r(,5), r(,) };
",
        expect![[r"
            f(2 * (y+1)) + f(2 * (f(2 * (z[0])))) % f(2 * (0)) + t(1);
            f(2 * (2+(3,4)-0,1)) | f(2 * (~ 5)) & f(2 * (0,1))^ m(0,1);
            int i[ ] = { 1, 23, 4, 5, };
        "]],
    );
}

#[test]
fn letters_behind_a_number_are_no_macro() {
    check(
        "#define ms s\nperiod 10ms; period 10 ms;\n",
        expect![[r"
        period 10ms; period 10 s;
    "]],
    );
}

#[test]
fn calls_gone_wrong() {
    check(
        "#define F(x, y) x+y\n#define Z() 0\nF(1) F(1, 2, 3) Z(1)\nF(1,\n2,\n3)\n",
        expect![[r"
            1+ 1+2 0
            1+2
            main.gen:3: error pp-macro-args: the macro `F` takes 2 arguments, 1 given
            main.gen:3: error pp-macro-args: the macro `F` takes 2 arguments, 3 given
            main.gen:3: error pp-macro-args: the macro `Z` takes 0 arguments, 1 given
            main.gen:6: error pp-macro-args: the macro `F` takes 2 arguments, 3 given
        "]],
    );
    check(
        "#define F(x) x\na; F(1, F(2\nb;\n#define G 1\nG F\n",
        expect![[r"
            a; F(1, F(2
            b;
            1 F
            main.gen:2: error pp-macro-eof: a directive inside the arguments of the macro `F`: close the call before it
        "]],
    );
}

#[test]
fn macros_that_grow_are_stopped() {
    let mut text = String::from("#define A0 x x x x\n");
    for i in 1..30 {
        text.push_str(&format!("#define A{i} A{0} A{0} A{0} A{0}\n", i - 1));
    }
    text.push_str("A29\nA29\n");
    let (files, ..) = run(&text);
    assert_eq!(files.errors.len(), 1, "{:?}", files.errors);
    assert!(files.errors[0].contains("pp-macro-limit"), "{:?}", files.errors);

    // Texts that double, arguments in arguments, and calls without end.
    let deep = |open: &str, count: usize| {
        format!(
            "#define E(x) D(x)\n#define D(x) x##x\n#define S(x) #x\n#define T(x) S(x)\n{}a{}\n",
            open.repeat(count),
            ")".repeat(count)
        )
    };
    for text in [deep("E(", 100), deep("T(", 100), deep("E(", 20_000)] {
        let (files, ..) = run(&text);
        assert_eq!(files.errors.len(), 1, "{:?}", files.errors);
    }
    let (files, ..) = run(&format!("#define F(x) x\n{}", "F( ".repeat(50_000)));
    assert_eq!(files.errors.len(), 1, "{:?}", files.errors);
}

#[test]
fn definition_mistakes() {
    check(
        "#define\n#define 3\n#define F(x, x) x\n#define V(x) __VA_ARGS__\n#define S(x) #y\n\
         #define P(x) ## x\n#define Q x ##\n#define N+1\n#define B(a b\n#define defined 1\n\
         #define clock-rate 1\n#undef 3\n#undef N N\n#define O #x ok\n#define U __VA_ARGS__\n",
        expect![[r"
            main.gen:1: error pp-define-bad: `#define` must be followed by the name of a macro
            main.gen:2: error pp-define-bad: `#define` must be followed by the name of a macro
            main.gen:3: error pp-define-dup-param: the macro `F` has two parameters `x`
            main.gen:4: error pp-va-args: `__VA_ARGS__` in the macro `V`, whose parameters do not end in `...`
            main.gen:5: error pp-stringize: `#` in the macro `S` must precede a parameter
            main.gen:6: error pp-define-bad: `##` is first or last in the body of the macro `P`
            main.gen:7: error pp-define-bad: `##` is first or last in the body of the macro `Q`
            main.gen:8: error pp-define-bad: a blank is missing between the macro `N` and its body
            main.gen:9: error pp-define-bad: the parameter list of the macro `B` is broken: expected names separated by commas, then `)`
            main.gen:11: error pp-define-bad: the name of a macro cannot have a hyphen: `clock-rate`
            main.gen:12: error pp-undef-bad: `#undef` must be followed by the name of a macro
            main.gen:13: error pp-extra-tokens: `#undef` takes exactly one name: remove what follows it
            main.gen:15: error pp-va-args: `__VA_ARGS__` in the macro `U`, whose parameters do not end in `...`
        "]],
    );
    let params: Vec<String> = (0..129).map(|i| format!("p{i}")).collect();
    let (files, ..) = run(&format!("#define F({}) p0\n", params.join(", ")));
    assert!(files.errors[0].contains("pp-define-bad"), "{:?}", files.errors);
    let (files, ..) = run(&format!("#define F({}) p0\n", params[..128].join(", ")));
    assert_eq!(files.errors, [""; 0]);
}

#[test]
fn redefinitions() {
    check(
        "#define N 4 + 1\n#define N 4/* */+  1\n#define N 5\n#define F(x) x\n#define F(y) y\nN\n#undef N\nN\n#undef N\n",
        expect![[r"
            5
            N
            main.gen:3: warning pp-redefined: the macro `N` is defined again with another body; this one is used from here on
            main.gen:5: warning pp-redefined: the macro `F` is defined again with another body; this one is used from here on
        "]],
    );
}

#[test]
fn uses_and_definitions_of_macros() {
    let text = "#define A B\n#define B 1\n#define F(x) x A\n#ifdef A\nF(A) Z\n#endif\n#if defined B && Q\n#endif\n#undef A\n";
    let (_, out, _) = run(text);
    let uses: Vec<String> = out
        .macro_uses
        .iter()
        .map(|usage| {
            format!(
                "{:?} {} {:?}",
                usage.range,
                usage.name,
                usage.site.as_ref().map(|site| site.ordinal)
            )
        })
        .collect();
    assert_eq!(
        uses,
        [
            "10..11 B Some(1)",
            "39..40 A Some(0)",
            "48..49 A Some(0)",
            "50..51 F Some(2)",
            "52..53 A Some(0)",
            "76..77 B Some(1)",
            "81..82 Q None",
            "97..98 A Some(0)"
        ]
    );
    let origins: Vec<String> = out
        .elements
        .iter()
        .filter_map(|element| match element {
            Element::Virtual(token) => Some(format!("{} {:?}", token.text, token.origin)),
            _ => None,
        })
        .collect();
    let site = |ordinal: u32| MacroSite { file: Some("main.gen".into()), ordinal };
    let body = |ordinal: u32| format!("1 {:?}", crate::preproc::Origin::Body(site(ordinal)));
    assert_eq!(origins, [body(1), body(1)]);
}

#[test]
fn spliced_tokens_are_presented_clean() {
    check(
        "#define NA\\\nME 4\nNAM\\\nE co\\\nde = \\\n3\n",
        expect![[r"
        4 code = 3
    "]],
    );
}
