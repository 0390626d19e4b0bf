use expect_test::{Expect, expect};

use super::*;

/// Shows the directive and the text of its parts.
fn check(text: &str, expect: Expect) {
    let raw = lex(text);
    let first = (0..raw.len()).find(|&i| raw.kind(i) == HASH).unwrap_or(0);
    let directive = Directive::parse(text, &raw, first, &mut 0);
    let at = |range: &TextRange| &text[std::ops::Range::<usize>::from(*range)];
    let tokens = |range: &Range<u32>| {
        let start = raw.start(range.start as usize);
        &text[start..raw.start(range.end as usize).max(start)]
    };
    let operand = |operand: &Operand| {
        let name = operand.name.as_ref().map(|name| at(&name.range));
        format!("{name:?} then {:?}", tokens(&operand.rest))
    };
    let kind = match &directive.kind {
        DirectiveKind::Include(include) => {
            format!(
                "include {:?} at {:?} then {:?}",
                include.form,
                at(&include.range),
                tokens(&include.rest)
            )
        }
        DirectiveKind::Define(define) => {
            let params = define.params.as_ref().map(|param| {
                let names: Vec<&str> = param.names.iter().map(|name| at(&name.range)).collect();
                let dots = if param.variadic { " ..." } else { "" };
                let broken = if param.well_formed { "" } else { " broken" };
                format!("({}{dots}{broken})", names.join(" "))
            });
            let name = define.name.as_ref().map(|name| at(&name.range));
            let glued = if define.glued { " glued" } else { "" };
            format!("define {name:?} {params:?} as {:?}{glued}", tokens(&define.body))
        }
        DirectiveKind::Undef(undef) => format!("undef {}", operand(undef)),
        DirectiveKind::Ifdef(ifdef) => format!("ifdef {}", operand(ifdef)),
        DirectiveKind::Ifndef(ifndef) => format!("ifndef {}", operand(ifndef)),
        DirectiveKind::If(range) => format!("if {:?}", tokens(range)),
        DirectiveKind::Elif(elif) => format!("elif {:?}", tokens(elif)),
        DirectiveKind::Else(otherwise) => format!("else {:?}", tokens(otherwise)),
        DirectiveKind::Endif(endif) => format!("endif {:?}", tokens(endif)),
        DirectiveKind::Line(line) => format!("line {:?}", tokens(line)),
        DirectiveKind::Pragma(pragma) => {
            let words: Vec<String> = std::iter::zip(
                pragma.name.iter().map(|name| &name.text),
                pragma.name.iter().map(|name| &name.range),
            )
            .chain(pragma.args.iter().map(|argument| (&argument.text, &argument.range)))
            .map(|(text, range)| format!("{text:?} at {:?}", at(range)))
            .collect();
            format!("pragma {}", words.join(", "))
        }
        other => format!("{other:?}"),
    };
    expect.assert_eq(&format!("{:?}: {kind}", at(&directive.range)));
}

#[test]
fn includes() {
    check(
        "#include \"a/b.idl\" // c\n",
        expect![[
            r##""#include \"a/b.idl\"": include Quoted("a/b.idl") at "\"a/b.idl\"" then """##
        ]],
    );
    check(
        " # include<a//b.idl> x",
        expect![[r##""# include<a//b.idl>": include Angled("a//b.idl") at "<a//b.idl>" then """##]],
    );
    check(
        "#include <a.idl> x",
        expect![[r##""#include <a.idl> x": include Angled("a.idl") at "<a.idl>" then "x""##]],
    );
    check(
        "#include FILE(1)\n",
        expect![[r##""#include FILE(1)": include Macro(3..7) at "FILE(1)" then """##]],
    );
    check("#include", expect![[r##""#include": include Macro(2..2) at "" then """##]]);
}

#[test]
fn defines() {
    check(
        "#define N /* */ 1 + 2 // x\n",
        expect![[r##""#define N /* */ 1 + 2": define Some("N") None as "1 + 2""##]],
    );
    check(
        "%: define F(a, b) a##b",
        expect![[r#""%: define F(a, b) a##b": define Some("F") Some("(a b)") as "a##b""#]],
    );
    check(
        "#define F(a, ...) x\\\n y",
        expect![[
            r##""#define F(a, ...) x\\\n y": define Some("F") Some("(a ...)") as "x\\\n y""##
        ]],
    );
    check("#define F( ) x", expect![[r##""#define F( ) x": define Some("F") Some("()") as "x""##]]);
    check("#define F (a)", expect![[r##""#define F (a)": define Some("F") None as "(a)""##]]);
    check(
        "#define F(a b) x",
        expect![[r##""#define F(a b) x": define Some("F") Some("(a broken)") as "x""##]],
    );
    check(
        "#define F(a, ",
        expect![[r##""#define F(a,": define Some("F") Some("(a broken)") as """##]],
    );
    check("#define N+1", expect![[r##""#define N+1": define Some("N") None as "+1" glued"##]]);
    check("#define 3", expect![[r##""#define 3": define None None as "3""##]]);
}

#[test]
fn conditionals_and_others() {
    check("#ifdef A B\n", expect![[r##""#ifdef A B": ifdef Some("A") then "B""##]]);
    check("#ifndef +\n", expect![[r##""#ifndef +": ifndef None then "+""##]]);
    check("#undef long", expect![[r##""#undef long": undef Some("long") then """##]]);
    check("#if  A > 1 /* x */\n", expect![[r##""#if  A > 1": if "A > 1""##]]);
    check("#else foo", expect![[r##""#else foo": else "foo""##]]);
    check("#error don't  stop\n", expect![[r##""#error don't  stop": Error("don't  stop")"##]]);
    check("# 12 \"f\"", expect![[r##""# 12 \"f\"": Unknown"##]]);
    check("#import x", expect![[r##""#import x": Unknown"##]]);
    check("# /* */\nx", expect![[r##""#": Empty"##]]);
}

#[test]
fn pragmas() {
    check(
        "#pragma requires \"a >= 1\" b-c/**/d \"\\\"q\\\"\"\n",
        expect![[
            r##""#pragma requires \"a >= 1\" b-c/**/d \"\\\"q\\\"\"": pragma "requires" at "requires", "a >= 1" at "\"a >= 1\"", "b-c/**/d" at "b-c/**/d", "\\\"q\\\"" at "\"\\\"q\\\"\"""##
        ]],
    );
    check(
        "#pragma wcet stop 26us",
        expect![[
            r##""#pragma wcet stop 26us": pragma "wcet" at "wcet", "stop" at "stop", "26us" at "26us""##
        ]],
    );
    check("#pragma", expect![[r##""#pragma": pragma "##]]);
    let pragma = Pragma::from_operator(r#""requires \"tiny\" \\\"x""#, TextRange::default());
    let words: Vec<&str> = pragma.args.iter().map(|argument| argument.text.as_str()).collect();
    assert_eq!(pragma.name.as_ref().map(|name| name.text.as_str()), Some("requires"));
    assert_eq!(words, ["tiny", "\\", "x"]);
}
