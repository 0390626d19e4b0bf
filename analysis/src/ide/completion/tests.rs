use crate::test_support::Fixture;

use super::*;

/// `|` separates items; the best come first. A trailing `…` allows further items.
#[track_caller]
fn check(text: &str, expected: &str) {
    let fixture = Fixture::new(text);
    let items = fixture.analysis().completions(&fixture.at()).unwrap();
    let labels: Vec<&str> = items.iter().map(|item| item.label.as_str()).collect();
    let wanted: Vec<&str> = expected.split('|').map(str::trim).collect();
    match wanted.split_last() {
        Some((&"…", wanted)) => {
            let found = labels.get(..wanted.len()).unwrap_or(&labels);
            assert_eq!(found, wanted, "all: {labels:?}");
        }
        _ if expected.is_empty() => assert_eq!(labels, [""; 0]),
        _ => assert_eq!(labels, wanted),
    }
}

/// Checks that all of these are proposed, and none of those after `!`.
#[track_caller]
fn has(text: &str, expected: &str) {
    let fixture = Fixture::new(text);
    let items = fixture.analysis().completions(&fixture.at()).unwrap();
    let labels: Vec<&str> = items.iter().map(|item| item.label.as_str()).collect();
    for part in expected.split('|').map(str::trim) {
        match part.strip_prefix('!') {
            Some(rest) => assert!(!labels.contains(&rest), "`{rest}` in {labels:?}"),
            None => assert!(labels.contains(&part), "`{part}` not in {labels:?}"),
        }
    }
}

/// Checks the text after the item with this label is inserted, without placeholders.
#[track_caller]
fn takes(text: &str, label: &str, expected: &str) {
    let fixture = Fixture::new(text);
    let at = fixture.at();
    let items = fixture.analysis().completions(&at).unwrap();
    let item = items.iter().find(|item| item.label == label);
    let item = item.unwrap_or_else(|| panic!("no `{label}` in {items:#?}"));
    let mut text = fixture.text(at.path.as_str());
    let insert = if item.snippet { plain_snippet(&item.insert) } else { item.insert.clone() };
    text.replace_range(item.replace.clone(), &insert);
    assert_eq!(text, expected);
}

const ARM: &str = "
struct pose { double x, y; };
enum mode { OFF, ON };
exception e_bad { long why; };
interface io { function reset(); };
component arm {
  ids { pose goal; pose way[4]; mode m; };
  port in pose target;
  port out pose state;
  uses io;
  task motion { period 10 ms; codel<start> init(out ::ids) yield loop; };
  function get(out long n) { };
  HERE
};
";

fn in_arm(here: &str) -> String {
    ARM.replace("HERE", here)
}

#[test]
fn what_an_interface_brings_is_there_from_the_clause_on() {
    let interface = "struct s { long x; };
interface eye { port in s seen; task scan { period 1 ms; }; };
interface face { extends eye; };
";
    let above = "component c { provides face; activity a() { task $0";
    check(&format!("{interface}{above}"), "scan");
    let below = "component c { activity a() { task $0 }; provides face; };";
    check(&format!("{interface}{below}"), "");
    let codel = "task t { codel<start> f($0) yield ether; };";
    let above = format!("{interface}component c {{ provides face; {codel} }};");
    has(&above, "port in seen");
    let below = format!("{interface}component c {{ {codel} provides face; }};");
    has(&below, "!port in seen");
}

#[test]
fn what_stands_behind_the_cursor_is_not_torn_apart() {
    // A bound, a source and its direction, the rest of a path, a member of a parameter.
    has(
        "const long N = 6;\ncomponent c { activity a(in sequence<float, $0> x) { task t; };",
        "N | !in | !out",
    );
    check("component c { ids { long x, y; }; function f() { codel g(ids $0 out x); };", "");
    has(
        "struct s { long x; };\ncomponent c { activity a(in $0 ::s x) { task t; }; };",
        "!long | !unsigned short",
    );
    takes(
        "interface i { exception e; };\ncomponent c { task t { throw i::$0 e; }; };",
        "e",
        "interface i { exception e; };\ncomponent c { task t { throw i::e e; }; };",
    );
    has(
        "struct s { long x; };\ncomponent c { task t; activity a(in s p, in long q) { task t; codel<start> \
         f($0 in p.x) yield ether; }; };",
        "in q | !in p",
    );
    has("interface i { $0 attribute get(out x); };", "function | version");
    takes(
        "interface i { $0 attribute get(out x); };",
        "version",
        "interface i { version \"1.0\"; attribute get(out x); };",
    );
}

#[test]
fn statements_fit_their_body() {
    check("$0", "component | interface | module | const | …");
    has(
        "component c { $0",
        "task | function | typedef | ids | !period | !codel | !provides | !activity | !port in",
    );
    has(&in_arm("$0"), "port in | task | activity | attribute | typedef | throw | !uses | !ids");
    has("component c { task t { $0", "period | codel | !task | !port in");
    has("component c { task t; activity a() { $0", "task | codel | local | interrupt | !period");
    has("module m { $0", "struct | module | !component | !task");
    has("component c { port in t p { $0", "doc | !throw");
    has("union u switch(long) { $0", "case | default");
    check("enum e { $0", "");
    check("// a $0", "");
    check("component c { doc \"$0\"; };", "");
}

#[test]
fn what_was_given_already_is_not_offered_again() {
    has("component c { task t { period 1 s; $0 }; };", "delay | !period");
    has("component c { task t { $0 priority 3; }; };", "period | !priority | !delay");
}

#[test]
fn a_member_with_the_name_of_a_port_says_what_it_is_of() {
    let text = "struct s { long x; };\ncomponent c { port in s goal; ids { s goal; s home; s rest; };\n\
                \x20 attribute a(in rest) { validate v($0); }; };";
    has(text, "in home | ids in goal | !in goal");
}

#[test]
fn an_attribute_has_no_parameter_that_its_codels_would_mix_up() {
    let text = "component c { ids { long a; struct s { long x, y; } b; };\n\
                attribute set($0) { validate v(local in x, inout b); }; };";
    has(text, "in a | !in b");
    let text = text.replace("inout b", "in b.x");
    has(&text, "in a | !in b");
}

#[test]
fn a_case_is_a_value_of_what_the_union_switches_on() {
    let text = "enum mode { IDLE, BUSY };\nconst long N = 3;\nunion u switch (mode) { $0 };";
    takes(
        text,
        "case",
        "enum mode { IDLE, BUSY };\nconst long N = 3;\nunion u switch (mode) { case IDLE: long member_name; };",
    );
    has(
        "enum mode { IDLE, BUSY };\nconst long N = 3;\nunion u switch (mode) { case $0: long x; };",
        "IDLE | BUSY | !N",
    );
}

#[test]
fn a_parameter_right_behind_the_cursor_is_not_offered_again() {
    let text = "component c { ids { long a; long b; }; task t {\n\
                codel<start> f(i$0 out a) yield ether; }; };";
    has(text, "in b | !in a");
}

#[test]
fn clauses_are_filled_in() {
    takes(
        "component c {\n  ta$0\n};",
        "task",
        "component c {\n  task main {\n\tperiod 10 ms;\n\n\tcodel<start> main_start()\n\t\tyield run;\n\t\
         codel<run> main_run()\n\t\tyield pause::run, stop;\n\tcodel<stop> main_stop()\n\t\tyield ether;\n};\n};",
    );
    takes("module m { str$0 };", "struct", "module m { struct name {\n\tlong member;\n}; };");
}

#[test]
fn types_constants_and_qualifiers() {
    let text = "module m { typedef long a; const long N = 2; typedef $0 };";
    check(text, "double | long | …");
    has(text, "a | long | unsigned long | sequence<…> | !N");
    has("module m { typedef long a; };\ntypedef $0", "m::a");
    check("module m { typedef long a; const long n = 1; };\ntypedef m::$0", "a");
    check("module m { typedef long a; module n { typedef long b; }; };\ntypedef ::$0", "m");
    check("const long n = 1;\ntypedef sequence<long, $0", "n");
    check("const long n = 1;\ntypedef long a[$0", "n");
    // Everything must be declared before it is used.
    has("typedef $0;\ntypedef long later;", "!later");
    check("typedef long $0", "long");
    check("typedef unsigned $0", "short | long | long long");
    has("enum e { A, B };\nconst e x = $0", "A | B");
}

#[test]
fn ports_take_named_types() {
    has(&in_arm("port in $0"), "pose | mode | !e_bad | !long | !sequence<…>");
    check(&in_arm("port $0"), "in | out | multiple");
}

#[test]
fn members_after_a_dot() {
    check(&in_arm("attribute a(in goal.$0"), "x | y");
    check(&in_arm("attribute a(in way[1].$0"), "x | y");
    check(&in_arm("activity go(in pose p) { task motion; codel<start> f(local in p.$0"), "x | y");
}

#[test]
fn codel_parameters_by_source_and_direction() {
    let text = in_arm("activity go(in long speed) { task motion; codel<start> f($0");
    check(
        &text,
        "in speed | in goal | in way | in m | port in target | port out state | remote in reset | …",
    );
    let text =
        in_arm("activity go(in long speed) { task motion; codel<start> f(in speed, in goal, $0");
    check(&text, "in way | in m | port in target | port out state | …");
    check(&in_arm("task u { codel<start> f(port out $0"), "state");
    check(&in_arm("task u { codel<start> f(port in $0"), "target | state");
    check(&in_arm("task u { codel<start> f(remote in $0"), "reset");
    check(&in_arm("task u { codel<start> f(out ::$0"), "ids");
    // Simple codels have neither ports nor remotes.
    has(&in_arm("function f(in long a) { codel g($0"), "in a | in goal | !port in target | !port");
    has(
        &in_arm("function goal2(in pose goal) { codel g($0"),
        "local in goal | ids in goal | !in goal",
    );
}

#[test]
fn states_of_the_machine() {
    check(&in_arm("task u { codel<start> f() yield wait, go; codel<$0"), "wait | go | stop");
    check(&in_arm("task u { codel<start> f() yield $0"), "pause::start | ether | start | pause::");
    has(&in_arm("task u { codel<start> f() yield start, $0"), "!start | pause::start | ether");
    has(
        &in_arm("task u { codel<start> f() yield pause::$0"),
        "start | !stop | !ether | !pause::start",
    );
    // The next codel is not a state.
    check(
        &in_arm("task u { codel<start> f() yield $0\n codel<go> g() yield ether; };"),
        "pause::start | go | ether | start | pause::go | pause::",
    );
    check(&in_arm("task u { codel<start> f() $0"), "yield | wcet");
    // The word for the execution time is not a state.
    check(
        &in_arm("task u { codel<start> f() yield $0 wcet 3 us; codel<go> g() yield ether; };"),
        "go | pause::start | ether | pause::go | start | pause::",
    );
    check(
        &in_arm("task u { codel<start> f() yield go, $0 wcet 3 us; codel<go> g() yield ether; };"),
        "pause::start | ether | pause::go | start | pause::",
    );
    // Cycles through other states.
    check(
        &in_arm(
            "task u { codel<start> f() yield go; codel<go> g() yield $0; codel<on> h() yield go; };",
        ),
        "pause::start | pause::go | pause::on | ether | start | go | on | pause::",
    );
    has(
        &in_arm("const long N = 1; task u { codel<start> f() yield $0 wcet N * 2 us; };"),
        "start | ether | !wcet | !pause::wcet",
    );
    check(&in_arm("task u { codel<start> f() wcet 1 $0"), "s | ms | us");
    takes(
        "component c { task t; activity a() { task t; codel $0 }; };",
        "<start>",
        "component c { task t; activity a() { task t; codel <start> a_start()\n\tyield ether; }; };",
    );
}

#[test]
fn services_tasks_exceptions_interfaces() {
    check(&in_arm("port in $0"), "pose | mode");
    check(&in_arm("activity go() { interrupt $0"), "get | go | all");
    check(&in_arm("activity go() { interrupt get, $0"), "go | all");
    check(&in_arm("activity go() { task $0"), "motion");
    check(&in_arm("throw $0"), "e_bad");
    check("module m { exception e; };\ncomponent c { throw $0", "m::e");
    check(&in_arm("provides $0"), "");
    check("interface io;\ncomponent c { provides $0", "io");
    check("interface a;\ninterface b;\ncomponent c { extends a, $0", "b");
    check(&in_arm("task u { scheduling $0"), "real-time");
    check(&in_arm("task u { period 5 $0"), "s | ms | us");
    check(&in_arm("task u { stack 5 $0"), "k | M");
}

#[test]
fn what_follows_the_cursor_counts() {
    // Another element follows: a comma is inserted.
    takes(
        "component c { ids { long a, b; }; task t { codel<start> f($0in a) yield ether; }; };",
        "in b",
        "component c { ids { long a, b; }; task t { codel<start> f(in b, in a) yield ether; }; };",
    );
    // A name that is used after the cursor, too.
    has(&in_arm("task u { codel<start> f($0, in goal) yield ether; };"), "in way | !in goal");
    // Only the direction, or only the first word of the statement, is missing.
    check(&in_arm("task u { codel<start> f($0 goal) yield ether; };"), "in | out | inout");
    takes("component c { ta$0 main { }; };", "task", "component c { task main { }; };");
    // Before another statement, in either form of its first word, a whole clause is inserted.
    for word in ["throw", "throws"] {
        let with = |clause: &str| {
            format!(
                "component c {{ exception e; task t {{ }}; activity a() {{ task t; {clause}{word} e; codel<start> \
                 f() yield ether; }}; }};"
            )
        };
        takes(&with("do$0 "), "doc", &with("doc \"\"; "));
    }
    // The rest of a path is replaced with its beginning.
    takes(
        "module m { typedef long a; };\ntypedef long b;\ntypedef m$0::a c;",
        "b",
        "module m { typedef long a; };\ntypedef long b;\ntypedef b c;",
    );
    // The cursor touches a type.
    takes(
        "module m { typedef long a; };\ntypedef $0m::a c;",
        "double",
        "module m { typedef long a; };\ntypedef double c;",
    );
    check("component c { ids { long a; }$0;", "");
}

#[test]
fn codels_are_named_as_the_others_are() {
    let text = "component c { task t { codel<start> c_t_start() yield run; codel<run> $0";
    check(text, "c_t_run");
    check("component c { task t; activity go() { codel<start> $0", "go_start");
    check("component c { function f() { codel $0", "f_codel");
}

#[test]
fn either_spelling_of_a_keyword_finds_it() {
    let fixture = Fixture::new(&in_arm("thr$0"));
    let items = fixture.analysis().completions(&fixture.at()).unwrap();
    let throw = items.iter().find(|item| item.label == "throw").unwrap();
    assert_eq!(throw.filter.as_deref(), Some("throws"));
}

#[test]
fn initializers() {
    check(&in_arm("function f(in mode m = $0"), "OFF | ON");
    check(&in_arm("attribute f(in m = $0"), "OFF | ON");
    check(&in_arm("function f(in pose p = { $0"), ".x = | .y = | …");
    check(&in_arm("function f(in pose p = { .$0"), "x | y");
    check(&in_arm("function f(in pose p = { .x = 1, $0"), ".y = | …");
    takes(
        "struct s { long a; boolean b; };\ncomponent c { function f(in s x = $0",
        "{ … }",
        "struct s { long a; boolean b; };\ncomponent c { function f(in s x = { .a = 0, .b = FALSE }",
    );
}

#[test]
fn directives_and_macros() {
    has("#$0", "include | define | pragma requires");
    takes("#inc$0", "include", "#include \"\"");
    has("#define LIMIT 3\n#ifdef $0", "LIMIT | !__FILE__");
    // At the start of a statement only macros for statements are proposed, and no include guards.
    has("#define LIMIT 3\n#define T typedef long t;\n$0", "T | !LIMIT");
    has(
        "#ifndef GUARD_H\n#define GUARD_H\n#define LIMIT 3\n#ifdef $0\n#endif\n#endif\n",
        "LIMIT | !GUARD_H",
    );
    check("#define GUARD\n#define RATE 5\ncomponent c { task t { period $0", "RATE");
    check("#pragma $0", "requires | provides | masquerade | wcet");
    check("interface i;\n#pragma provides $0", "i");
    check("component c { task t { codel<start> f() yield ether; }; };\n#pragma wcet $0", "f");
    check(
        "//- /main.gen\n#include \"sub/$0\"\n//- /sub/a.idl\n\n//- /sub/deep/b.idl\n\n//- /c.idl\n",
        "a.idl | deep/",
    );
    check("//- /main.gen\n#include \"$0\n//- /sub/a.idl\n\n//- /c.idl\n", "c.idl | sub/");
    has(
        "//- /main.gen\n#include \"m.idl\"\ntask $0\n#if $0\n//- /m.idl\n#define FROM_THERE 1\n",
        "!FROM_THERE",
    );
    has(
        "//- /main.gen\n#include \"m.idl\"\n#if $0\n//- /m.idl\n#define FROM_THERE 1\n",
        "FROM_THERE | defined",
    );
    check("#if 0\ntypedef $0\n#endif\n", "");
}

#[test]
fn languages_of_codels_are_listed() {
    check("component c { lang \"$0\"; };", "c | c++");
    check("component c { doc \"$0\"; };", "");
}

#[test]
fn packages_are_listed() {
    let fixture = Fixture::new("component c { require \"eigen3\", \"op$0\"; };");
    fixture.loader.packages.lock().unwrap().insert("openrobots".into(), Default::default());
    let items = fixture.analysis().completions(&fixture.at()).unwrap();
    assert_eq!(items.len(), 1);
    assert_eq!(items[0].label, "openrobots");
}

#[test]
fn fragments_know_the_component_that_includes_them() {
    check(
        "//- /main.gen\ncomponent c { ids { long a; }; task t;\n#include \"s.idl\"\n};\n//- /s.idl\ntask u { codel<start> f(in $0",
        "a | ::ids",
    );
}

#[test]
fn text_before_the_cursor_may_be_broken() {
    // No `;`, no `}`, no `)`.
    check(&in_arm("function f(in long a\n  activity go() { interrupt $0"), "get | f | go | all");
    check(&in_arm("task u { period 5 ms\n codel<start> f(port in $0"), "target | state");
    check(
        &in_arm("task u { codel<start> f(in x yield ether;\n activity go() { task $0"),
        "motion | u",
    );
}

#[test]
fn documentation_on_demand() {
    let fixture = Fixture::new("struct s { long x; };\ntypedef $0;");
    let analysis = fixture.analysis();
    let items = analysis.completions(&fixture.at()).unwrap();
    let item = items.iter().find(|item| item.label == "s").unwrap();
    assert_eq!((item.label.as_str(), item.detail.as_deref()), ("s", Some("struct s (1 member)")));
    let path = &fixture.at().path;
    assert_eq!(item.name.as_deref(), Some("s"));
    let definition = item.definition.unwrap();
    let doc = analysis.resolve_completion(path, definition, "s").unwrap().unwrap();
    assert!(doc.markdown.contains("long x;"), "{}", doc.markdown);
    // Stale items have no documentation.
    assert_eq!(analysis.resolve_completion(path, definition, "other").unwrap(), None);
    assert_eq!(analysis.resolve_completion(path, DefId(99), "s").unwrap(), None);
}

#[test]
fn snippets_without_placeholders() {
    assert_eq!(plain_snippet("a ${1:b} $2 {\n$0}"), "a b  {\n}");
    assert_eq!(plain_snippet("\"${1|c,c++|}\";"), "\"c\";");
    assert_eq!(plain_snippet("${1:x} \\$ }"), "x $ }");
    assert_eq!(plain_snippet("task ${1:t} { ${1}_f $1 $2 }"), "task t { t_f t  }");
}

#[test]
fn what_follows_the_parameters_of_a_codel_ends_where_the_next_begins() {
    let task = "component c { task t { codel<start> f() HERE\n codel<stop> g() yield ether wcet 1 ms; }; };";
    check(&task.replace("HERE", "$0"), "yield | wcet");
    check(&task.replace("HERE", "yield ether $0"), "wcet");
}

#[test]
fn a_constant_is_offered_where_its_value_fits() {
    let constants = "const double R = 1.5; const long N = 300; const double W = 2.0;\n";
    has(&format!("{constants}const long M = $0;"), "N | W | !R");
    has(&format!("{constants}const octet M = $0;"), "W | !N | !R");
    has(&format!("{constants}const float M = $0;"), "W | N | R");
}

#[test]
fn the_ids_are_no_type_within_themselves() {
    has("component c { ids { long a; sequence<$0> b; }; };", "long | !ids");
    has("component c { ids { long a; $0 }; };", "long | !ids");
    has("component c { ids { long a; }; port in $0 };", "!ids");
}

#[test]
fn there_may_be_several_docs() {
    has("component c { doc \"a\"; $0 task t { doc \"b\"; }; };", "doc | version");
    has("component c { task t { doc \"b\"; $0 }; };", "doc | period");
}
