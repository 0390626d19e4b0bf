//! Errors of models.

use dotgen_xta::{queries, read};

const PROCESS: &str = "process P() { clock x; state a; init a; trans a -> a { }; } system P;";

fn error(model: &str) -> String {
    read(model).expect_err(model).to_string()
}

#[test]
fn an_error_has_its_place_and_what_was_expected() {
    assert_eq!(error("int a\nint b;"), "2:1: expected `;`, found `int`");
    assert_eq!(error("int ä;"), "1:5: unexpected character `ä`");
    assert_eq!(error("/* é */ int a := ;"), "1:18: expected an expression, found `;`");
    assert_eq!(
        error("int a;"),
        "1:7: expected a declaration, a process, an instance or `system`, found the end of the text"
    );
    assert_eq!(error("/* no end"), "1:1: comment without an end: expected `*/`");
    assert_eq!(
        error(&format!("{PROCESS} int a;")),
        "1:71: expected the end of the text after `system`, found `int`"
    );
}

#[test]
fn names_and_types_are_checked() {
    let with = |text: &str| error(&format!("{text} {PROCESS}"));
    assert_eq!(with("int a := b;"), "1:10: unknown name `b`");
    assert_eq!(with("int[0, 3] a := 4;"), "1:16: value 4 is out of the range [0, 3]");
    assert_eq!(with("int a; int a;"), "1:12: `a` is declared twice");
    // Processes and variables have one scope.
    assert!(with("int P;").ends_with("`P` is declared twice"), "{}", with("int P;"));
    assert_eq!(with("int a[2] := {1};"), "1:13: expected 2 values, found 1");
    assert_eq!(with("int f() { return f(); }"), "1:18: unknown name `f`");
    assert_eq!(with("int n; int a[n];"), "1:14: expected a constant");
    assert_eq!(with("const int a := 1; void f() { a := 2; }"), "1:30: assignment to a constant");
    assert_eq!(error("system P;"), "1:8: unknown process `P`");
    assert_eq!(error(&PROCESS.replace("init a", "init b")), "1:38: unknown location `b`");
}

#[test]
fn what_is_not_supported_is_refused_by_name() {
    let edge = |body: &str| {
        error(&format!("urgent chan u; {}", PROCESS.replace("{ };", &format!("{{ {body} }};"))))
    };
    let told = |message: String, words: &str| assert!(message.contains(words), "{message}");
    told(edge("guard x - x < 3;"), "differences of clocks");
    told(edge("guard x < 3 || x > 4;"), "can only be joined by `&&`");
    told(edge("guard x > 1; sync u!;"), "urgent channel");
    told(edge("probability 3;"), "probabilities");
    told(error(&PROCESS.replace("state a", "state a { ; 3 }")), "exponential rates");
    told(error(&PROCESS.replace("state a", "state a { x' == 0 }")), "rates of clocks");
    told(error(&PROCESS.replace("state a", "state a { x >= 2 }")), "bound clocks from above");
    told(error(&PROCESS.replace("state a;", "state a; branchpoint b;")), "branch points");
    told(error(&format!("meta int a; {PROCESS}")), "`meta`");
    told(error(&format!("double a; {PROCESS}")), "`double`");
    told(error(&PROCESS.replace("trans a ->", "trans a -u->")), "uncontrollable");
}

#[test]
fn deep_nesting_is_an_error() {
    let deep = |open: &str, close: &str| {
        let text = format!("int a := {}1{};", open.repeat(100_000), close.repeat(100_000));
        error(&format!("{text} {PROCESS}"))
    };
    assert!(deep("(", ")").contains("nested more than"));
    assert!(deep("-(", ")").contains("nested more than"));
    assert!(deep("1 + ", "").contains("levels"));
    assert!(deep("{", "}").contains("nested more than"));
    let blocks = format!("void f() {}{} {PROCESS}", "{".repeat(10_000), "}".repeat(10_000));
    assert!(error(&blocks).contains("nested more than"));
    // A long disjunction is not deep.
    let long = format!("A[] {} P.a", "P.x > 3 or ".repeat(2000));
    assert_eq!(queries(&long).expect("parses").len(), 1);
}

#[test]
fn calls_that_need_deep_recursion_are_an_error() {
    let mut text = "int f0(int a) { return a; }".to_owned();
    for index in 1..2000 {
        text += &format!("int f{index}(int a) {{ return f{}(a); }}", index - 1);
    }
    assert!(error(&format!("{text} {PROCESS}")).contains("levels of recursion"));
}

#[test]
fn large_inputs_are_errors() {
    let arrays = format!("int a[60000][60000]; {PROCESS}");
    assert!(error(&arrays).contains("variables"));
    let quantifiers =
        "bool f() { return forall (i : int[0, 9999]) forall (j : int[0, 9999]) i < j; }";
    assert!(error(&format!("{quantifiers} {PROCESS}")).contains("too many values"));
    let text = " ".repeat((16 << 20) + 1);
    assert!(error(&text).contains("too large"));
}
