mod conditions;
mod macros;

use std::collections::BTreeMap;

use expect_test::{Expect, expect};
use proptest::prelude::*;

use super::*;
use crate::{
    lexer::lex,
    preproc::{IncludeError, IncludeRequest, MacroSite, NoIncludes, RequiredPackages},
};

/// Files in memory. A fixture has parts that begin with `//- name`; the first is the main file.
struct Files {
    texts: BTreeMap<SmolStr, String>,
    depth: usize,
    errors: Vec<String>,
}

impl Files {
    fn parse(fixture: &str) -> (SmolStr, Files) {
        let mut texts = BTreeMap::new();
        let mut main = SmolStr::new("main.gen");
        match fixture.strip_prefix("//- ") {
            None => {
                texts.insert(main.clone(), fixture.to_owned());
            }
            Some(parts) => {
                for (i, part) in parts.split("\n//- ").enumerate() {
                    let (name, text) = part.split_once('\n').unwrap_or((part, ""));
                    if i == 0 {
                        main = name.into();
                    }
                    texts.insert(name.into(), format!("{}\n", text.trim_end_matches('\n')));
                }
            }
        }
        (main, Files { texts, depth: 0, errors: Vec::new() })
    }

    fn run(&mut self, file: &SmolStr, env: MacroEnv) -> Option<Preprocessed> {
        let text = self.texts.get(file)?.clone();
        let raw = lex(&text);
        let out = preprocess(file, &text, &raw, env, self);
        assert_covers(&text, &raw, &out);
        for error in &out.errors {
            let line = text[..usize::from(error.range.start())].matches('\n').count() + 1;
            let severity = format!("{:?}", error.severity).to_lowercase();
            self.errors.push(format!(
                "{file}:{line}: {severity} {}: {}",
                error.kind.code(),
                error.kind.wording()
            ));
        }
        Some(out)
    }
}

impl Host for Files {
    fn include(
        &mut self,
        request: &IncludeRequest,
        env: &MacroEnv,
    ) -> Result<MacroEnv, IncludeError> {
        if self.depth > 20 {
            return Err(IncludeError::TooDeep);
        }
        self.depth += 1;
        let out = self.run(&request.path, env.clone());
        self.depth -= 1;
        match out {
            Some(out) => Ok(out.exit_env),
            None => Err(IncludeError::NotFound { searched: vec!["here".into()] }),
        }
    }

    fn requires(
        &mut self,
        arguments: &[SmolStr],
        env: &MacroEnv,
    ) -> Result<RequiredPackages, String> {
        let mut env = env.clone();
        for argument in arguments {
            let package =
                argument.strip_prefix("have").ok_or(format!("unknown package `{argument}`"))?;
            env.define_option(&format!("HAVE{package}=7"))?;
        }
        Ok(env.into())
    }
}

/// The elements cover all raw tokens, in order, without gap.
fn assert_covers(text: &str, raw: &RawTokens, out: &Preprocessed) {
    let mut next = 0;
    for element in &out.elements {
        let (first, end) = match *element {
            Element::Trivia(i) | Element::Real(i) => (i, i + 1),
            Element::Virtual(_) => (next, next),
            Element::Call { first, end }
            | Element::Directive { first, end, .. }
            | Element::Inactive { first, end } => (first, end),
        };
        assert_eq!(first, next, "a gap or an overlap in {text:?}");
        assert!(end >= first);
        next = end;
    }
    assert_eq!(next as usize, raw.len(), "tokens left in {text:?}");
    for (i, include) in out.includes.iter().enumerate() {
        assert_eq!(out.include_ordinal(include.directive), Some(i as u32));
    }
}

/// The tokens that the parser reads, as text, one line for each line of the file.
fn live_text(text: &str, raw: &RawTokens, out: &Preprocessed) -> String {
    let mut live = String::new();
    for element in &out.elements {
        match element {
            Element::Trivia(i) if raw.kind(*i as usize) == NEWLINE => live.push('\n'),
            Element::Trivia(_) | Element::Call { .. } | Element::Inactive { .. } => live.push(' '),
            Element::Directive { index, .. } => {
                let directive = &out.directives[*index as usize];
                if let (DirectiveKind::Pragma(pragma), true) = (&directive.kind, directive.active) {
                    let words: Vec<&str> = pragma
                        .name
                        .iter()
                        .map(|name| &name.text)
                        .chain(pragma.args.iter().map(|argument| &argument.text))
                        .map(SmolStr::as_str)
                        .collect();
                    live.push_str(&format!(" #pragma[{}] ", words.join("|")));
                }
            }
            Element::Real(i) => live.push_str(raw.text(text, *i as usize)),
            Element::Virtual(token) => {
                if !token.glued {
                    live.push(' ');
                }
                live.push_str(&token.text);
            }
        }
    }
    let lines = live.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "));
    lines.filter(|line| !line.is_empty()).map(|line| line + "\n").collect()
}

fn run(fixture: &str) -> (Files, Preprocessed, String) {
    let (main, mut files) = Files::parse(fixture);
    let out = files.run(&main, MacroEnv::predefined()).unwrap();
    let text = &files.texts[&main];
    let live = live_text(text, &lex(text), &out);
    (files, out, live)
}

/// Checks the tokens that the parser reads of the main file, and the errors of all files.
fn check(fixture: &str, expect: Expect) {
    let (files, _, mut live) = run(fixture);
    for error in &files.errors {
        live.push_str(error);
        live.push('\n');
    }
    expect.assert_eq(&live);
}

#[test]
fn includes() {
    check(
        "//- main.gen\n#include \"a.idl\"\n#define H \"a.idl\"\n#include H\n#define G <a.idl>\n#include G\nWIDTH\n\
         #include \"none\"\n#include nowhere\n#include \"a.idl\" junk\n#include \"\"\n#include \"a.idl\n#include\n\
         //- a.idl\n#ifndef A\n#define A\n#define WIDTH 4\n#endif\n",
        expect![[r#"
            4
            main.gen:7: error pp-include-not-found: cannot find the file `none`, searched in here; add its directory to the include path
            main.gen:8: error pp-include-bad: `#include` must be followed by `"file"`, `<file>`, or a macro that stands for one of them
            main.gen:9: error pp-include-bad: nothing may follow the name of the file in an `#include`
            main.gen:10: error pp-include-bad: `#include` must be followed by `"file"`, `<file>`, or a macro that stands for one of them
            main.gen:11: error pp-include-bad: `#include` must be followed by `"file"`, `<file>`, or a macro that stands for one of them
            main.gen:12: error pp-include-bad: `#include` must be followed by `"file"`, `<file>`, or a macro that stands for one of them
        "#]],
    );
    let (_, out, _) =
        run("//- main.gen\n#if 0\n#include \"x\"\n#endif\n#include \"a\"\n#include <b>\n//- a\n");
    let requests: Vec<String> = out
        .includes
        .iter()
        .map(|include| {
            format!(
                "{} {:?} {}",
                include.directive,
                include.request.as_ref().map(|request| (&*request.path, request.angled)),
                include.included
            )
        })
        .collect();
    assert_eq!(requests, [r#"3 Some(("a", false)) true"#, r#"4 Some(("b", true)) false"#]);
}

#[test]
fn an_include_cycle_ends_at_the_limit_of_the_host() {
    let (files, ..) = run("//- main.gen\n#include \"main.gen\"\n");
    assert_eq!(
        files.errors,
        [
            "main.gen:1: error pp-include-depth: including the file `main.gen` would open more than 100 \
                files at once: does it include itself?"
        ]
    );
}

#[test]
fn conditionals_end_in_their_file() {
    check(
        "//- main.gen\n#if 1\n#include \"a\"\n#endif\n//- a\n#endif\n#if 0\n",
        expect![[r"
            a:1: error pp-endif-without-if: `#endif` without `#if` before it
            a:3: error pp-cond-unterminated: the file ends inside a conditional: an `#endif` is missing
        "]],
    );
}

#[test]
fn pragmas() {
    check(
        r#"#pragma requires "have_a" have_b
HAVE_a HAVE_b
#pragma requires none
#pragma require
#pragma requires a b c d e f g h i
#pragma
#pragma provides i j
#pragma masquerade tmpl a::b "x y"
#if 0
#pragma
#endif
"#,
        expect![[r"
            #pragma[requires|have_a|have_b]
            7 7
            #pragma[requires|none]
            #pragma[require]
            #pragma[requires|a|b|c|d|e|f|g|h|i]
            #pragma[]
            #pragma[provides|i|j]
            #pragma[masquerade|tmpl|a::b|x y]
            main.gen:3: error pp-requires-unresolved: unknown package `none`; install `none` (on Debian most likely package `libnone-dev`); until then, what comes from there is unknown
            main.gen:4: error pp-requires-empty: `#pragma require` must be followed by a package
            main.gen:5: error pp-requires-many: `#pragma requires` takes at most 8 arguments, 9 given: use several pragmas, and quotes around a package with its version
            main.gen:6: error pp-pragma-bad: `#pragma` must be followed by a word
        "]],
    );
}

#[test]
fn pragma_operators() {
    check(
        r#"_Pragma("requires \"have_a\"") HAVE_a
#define P(x) a _Pragma(#x) b
P(provides i)
x _Pragma(requires) y _Pragma z
_Pragma("a" "b") c
"#,
        expect![[r#"
            #pragma[requires|have_a] 7
            a #pragma[provides|i] b
            x #pragma[] y #pragma[] z
            #pragma[] c
            main.gen:4: error pp-pragma-operator: `_Pragma` takes exactly one string in parentheses: `_Pragma("…")`
            main.gen:4: error pp-pragma-operator: `_Pragma` takes exactly one string in parentheses: `_Pragma("…")`
            main.gen:5: error pp-pragma-operator: `_Pragma` takes exactly one string in parentheses: `_Pragma("…")`
        "#]],
    );
}

#[test]
fn other_directives() {
    check(
        "#error it's \\\n wrong\n#warning\n#line 3\n#define L 12 \"f\"\n#line L\n#line \"x\"\n#line\n#foo\n# 12 \"f\"\n#\n%: define N 1\n",
        expect![[r"
            main.gen:1: error pp-error-directive: it's  wrong
            main.gen:3: warning pp-warning-directive: `#warning`
            main.gen:7: error pp-line-bad: `#line` must be followed by a line number and, optionally, a file name in quotes
            main.gen:8: error pp-line-bad: `#line` must be followed by a line number and, optionally, a file name in quotes
            main.gen:9: hint pp-unknown-directive: unknown directive `#foo`: the line is ignored
            main.gen:10: hint pp-unknown-directive: unknown directive `#`: the line is ignored
        "]],
    );
}

#[test]
fn stray_characters() {
    check(
        "a@ = 1; # é /* é */ \"é\" \u{1}\n#if 0\n@\n#endif\n#define X $\nX X\n\"open\nb\n/* open\n#if\n",
        expect![[r#"
            a = 1; "é"
            "open
            b
            main.gen:1: error lex-stray: `@` cannot stand here: remove it
            main.gen:1: error lex-stray: `#` is not at the beginning of a line: directives are lines of their own
            main.gen:1: error lex-stray: `é` is only allowed in comments and strings: names are ASCII
            main.gen:1: error pp-bad-char: `\u{1}` cannot stand here: remove it
            main.gen:6: error lex-stray: `$` cannot stand here: remove it
            main.gen:6: error lex-stray: `$` cannot stand here: remove it
            main.gen:9: error lex-comment-open: this comment has no end: `*/` is missing
        "#]],
    );
}

#[test]
fn open_comments_explain_what_is_missing() {
    check(
        "#if 0\n#endif /* open\n",
        expect![[r"
        main.gen:2: error lex-comment-open: this comment has no end: `*/` is missing
    "]],
    );
    check(
        "#if 1\na /* open\n#endif\n",
        expect![[r"
        a
        main.gen:2: error lex-comment-open: this comment has no end: `*/` is missing
    "]],
    );
    check(
        "#if 0\n/* open\n#endif\n",
        expect![[r"
        main.gen:2: error lex-comment-open: this comment has no end: `*/` is missing
    "]],
    );
}

#[test]
fn garbage_does_not_flood() {
    let (_, out, _) = run(&"@ ".repeat(100_000));
    assert_eq!(out.errors.len(), MAX_ERRORS + 1);
}

/// Each of these texts takes very long if a step is quadratic.
#[test]
fn large_files_of_one_piece() {
    for piece in [
        "#if\n",
        "#if 1\n",
        "#endif\n",
        "#else\n",
        "#define A 1\n#define A 2\n",
        "\\\n",
        "_Pragma(",
        "_Pragma(\"a\") ",
        "#pragma a\n",
        "#include \"a\n",
        "#define A(",
        "A,",
        "\u{0}",
        "é ",
        "'\n",
        "\"\\\"",
        "((",
        "#if (\n#endif\n",
        "/*",
    ] {
        run(&format!("#define F(x) x\n{}", piece.repeat(10_000)));
        run(&format!("#pragma x {}", piece.repeat(10_000)));
        run(&format!("#define G({}", piece.repeat(10_000)));
        run(&format!("#if 0\n{}", piece.repeat(10_000)));
    }
}

#[test]
fn environments_are_values() {
    let env = |text: &str| run(text).1.exit_env;
    let hash = |env: &MacroEnv| {
        use std::hash::BuildHasher;
        rustc_hash::FxBuildHasher.hash_one(env)
    };
    let a = env("#define A 1\n#define B A\n");
    // Order and intermediate definitions do not matter, sites and bodies do.
    let b = env("#define A 1\n#define B A\n#define C\n#undef C\n");
    assert_eq!(a, b);
    assert_eq!(hash(&a), hash(&b));
    assert_ne!(a, env("#define A 2\n#define B A\n"));
    assert_ne!(a, env("#define B A\n#define A 1\n"));
    assert_ne!(a, env("#define A 1\n"));

    let words = |text: &str| crate::preproc::mentioned(&lex(text), text);
    let names = |env: MacroEnv| format!("{env:?}");
    let all = env("#define A B\n#define B(x) C x\n#define C 1\n#define D C\n");
    assert_eq!(names(all.restrict(&words("A \"D\" /* D */"))), r#"{"A", "B", "C"}"#);
    assert_eq!(names(all.restrict(&words("c"))), "{}");
    assert_eq!(all.restrict(&words("a ## b")), all);
    let pastes = env("#define P(a) a##b\n#define D\n");
    assert_eq!(pastes.restrict(&words("P")), pastes);
    assert_eq!(names(pastes.restrict(&words("D __LINE__"))), r#"{"D", "__LINE__"}"#);
}

#[test]
fn options_define_macros() {
    let mut env = MacroEnv::predefined();
    env.define_option("A").unwrap();
    env.define_option("B=2 + 3").unwrap();
    env.define_option("F(x)=x x").unwrap();
    env.define_option("B=4").unwrap();
    assert!(env.define_option("3").is_err());
    assert!(env.define_option("").is_err());
    let text = "A B F(y)\n#define B 4\n#define A 2\n";
    let raw = lex(text);
    let out = preprocess(&"f".into(), text, &raw, env, &mut NoIncludes);
    assert_eq!(live_text(text, &raw, &out), "1 4 y y\n");
    let codes: Vec<&str> = out.errors.iter().map(|error| error.kind.code()).collect();
    assert_eq!(codes, ["pp-redefined"]);
    let texts: Vec<String> = ["B", "F"]
        .iter()
        .filter_map(|text| out.exit_env.get(text))
        .map(|definition| definition.definition_text())
        .collect();
    assert_eq!(texts, ["4", "(x) x x"]);
}

const PIECES: &[&str] = &[
    "#if",
    "#ifdef A",
    "#else",
    "#elif 1",
    "#endif",
    "#define A",
    "#define F(x)",
    "#define G(a, ...)",
    "x ## x",
    "#x",
    "#undef A",
    "#include",
    "#pragma",
    "_Pragma",
    "A",
    "F",
    "G",
    "(",
    ")",
    ",",
    "\"",
    "'",
    "\\",
    "\n",
    "\n",
    "\n",
    " ",
    "/*",
    "*/",
    "//",
    "defined",
    "1",
    "10",
    "+",
    "==",
    "@",
    "é",
    "__VA_ARGS__",
    "__LINE__",
    "##",
    "#",
    "<",
    ">",
];

proptest! {
    #[test]
    fn elements_cover_any_text(pieces in prop::collection::vec(prop::sample::select(PIECES), 0..60)) {
        run(&pieces.concat());
    }

    #[test]
    fn elements_cover_lines(lines in prop::collection::vec(prop::collection::vec(prop::sample::select(PIECES), 0..6), 0..12)) {
        let lines: Vec<String> = lines.into_iter().map(|line| line.join(" ")).collect();
        run(&lines.join("\n"));
    }
}
