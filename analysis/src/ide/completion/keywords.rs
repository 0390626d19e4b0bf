//! What begins a statement, by body, with snippets for whole clauses.

use super::Completions;
use crate::ide::context::{BodyKind, Context};

/// A keyword, and what it inserts. Spellings are those most published components use.
type Statement = (&'static str, &'static str);

const IDL: &[Statement] = &[
    ("const", "const ${1:long} ${2:name} = ${3:0};"),
    ("typedef", "typedef ${1:long} ${2:name};"),
    ("struct", "struct ${1:name} {\n\t$0\n};"),
    (
        "union",
        "union ${1:name} switch (${2:long}) {\n\tcase ${3:0}: $0\n};",
    ),
    ("enum", "enum ${1:name} {\n\t$0\n};"),
    ("exception", "exception ${1:name};"),
    ("native", "native ${1:name};"),
];

const SPECIFICATION: &[Statement] = &[
    (
        "component",
        "component ${1:name} {\n\tversion \"${2:1.0}\";\n\tlang \"${3|c,c++|}\";\n\n\t$0\n};",
    ),
    ("interface", "interface ${1:name} {\n\t$0\n};"),
    ("module", "module ${1:name} {\n\t$0\n};"),
];

const COMPONENT: &[Statement] = &[
    ("port in", "port in ${1:type} ${2:name};"),
    ("port out", "port out ${1:type} ${2:name};"),
    ("port multiple in", "port multiple in ${1:type} ${2:name};"),
    (
        "port multiple out",
        "port multiple out ${1:type} ${2:name};",
    ),
    ("ids", "ids {\n\t$0\n};"),
    (
        "task",
        // Its machine begins, goes round and can be stopped, so that nothing is to be said of it.
        "task ${1:main} {\n\tperiod ${2:10} ms;\n\n\tcodel<start> ${1}_start(${3:out ::ids})\n\t\tyield ${4:run};\n\t\
         codel<${4}> ${1}_${4}($5)\n\t\tyield pause::${4}, stop;\n\tcodel<stop> ${1}_stop()\n\t\tyield ether;$0\n};",
    ),
    (
        "task aperiodic",
        "task ${1:main} {\n\tcodel<start> ${1}_start(${2:out ::ids})\n\t\tyield ether;$0\n};",
    ),
    ("attribute", "attribute ${1:name}(${2:in }$3);$0"),
    (
        "function",
        "function ${1:name}($2) {\n\tdoc \"${3}\";\n\n\tcodel ${4:name}($5);$0\n};",
    ),
    (
        "activity",
        "activity ${1:name}($2) {\n\tdoc \"${3}\";\n\ttask ${4:main};\n\n\tcodel<start> ${5:name}($6)\n\t\tyield ${7:ether};$0\n};",
    ),
    ("doc", "doc \"$0\";"),
    ("version", "version \"${1:1.0}\";"),
    ("lang", "lang \"${1|c,c++|}\";"),
    ("email", "email \"$0\";"),
    ("require", "require \"$0\";"),
    ("codels-require", "codels-require \"$0\";"),
    ("clock-rate", "clock-rate ${1:1} ms;"),
    ("provides", "provides $0;"),
    ("uses", "uses $0;"),
    ("extends", "extends $0;"),
    ("throw", "throw $0;"),
];

const TASK: &[Statement] = &[
    ("period", "period ${1:10} ms;"),
    ("delay", "delay ${1:0} ms;"),
    ("priority", "priority ${1:100};"),
    ("scheduling", "scheduling real-time;"),
    ("stack", "stack ${1:64} k;"),
];

const SERVICE: &[Statement] = &[
    ("interrupt", "interrupt $0;"),
    ("before", "before $0;"),
    ("after", "after $0;"),
    ("validate", "validate ${1:name}($0);"),
];

const MACHINE: &[Statement] = &[
    (
        "codel",
        "codel<${1:start}> ${2:name}($3)\n\tyield ${4:ether};$0",
    ),
    (
        "async codel",
        "async codel<${1:start}> ${2:name}($3)\n\tyield ${4:ether};$0",
    ),
];

const SIMPLE: &[Statement] = &[("codel", "codel ${1:name}($0);")];
const TASK_OF: &[Statement] = &[("task", "task $0;")];
const LOCAL: &[Statement] = &[("local", "local ${1:long} ${2:name};")];
const DOC: &[Statement] = &[("doc", "doc \"$0\";")];
const THROW: &[Statement] = &[("throw", "throw $0;")];
const CASES: &[Statement] = &[("case", "case ${1:0}: $0"), ("default", "default: $0")];

/// Given once only, within one pair of braces (language reference, section 9).
const ONCE: &[&str] = &[
    "version",
    "lang",
    "email",
    "clock-rate",
    "period",
    "delay",
    "priority",
    "scheduling",
    "stack",
    "task",
    "before",
    "after",
    "doc",
];

pub(super) fn statements(context: &Context, body: BodyKind, out: &mut Completions) {
    use BodyKind::*;
    let tables: &[(&[Statement], u8)] = match body {
        Specification => &[(SPECIFICATION, 0), (IDL, 1)],
        Module => &[(IDL, 0), (&SPECIFICATION[2..], 1)],
        Component | Interface => &[(COMPONENT, 0), (IDL, 2)],
        Members | Ids => &[(&IDL[2..5], 4)],
        Cases => &[(CASES, 0)],
        Task => &[(MACHINE, 2), (TASK, 1), (DOC, 3), (THROW, 3)],
        Port => &[(DOC, 0)],
        Attribute => &[(DOC, 0), (&SERVICE[3..], 0), (SERVICE, 1), (THROW, 1)],
        Function => &[(DOC, 0), (SIMPLE, 0), (SERVICE, 1), (THROW, 1), (LOCAL, 2)],
        Activity => &[
            (TASK_OF, 0),
            (MACHINE, 2),
            (DOC, 3),
            (SERVICE, 3),
            (THROW, 3),
            (LOCAL, 4),
        ],
        Enum | Unknown => &[],
    };
    let given = &context.top().given;
    let in_component = matches!(body, Component | Interface);
    for (table, rank) in tables {
        for (word, insert) in *table {
            // In a component `task` declares.
            let once = ONCE.contains(word) && !(in_component && *word == "task");
            let again = once && given.iter().any(|it| it == word);
            let rank = if again { rank + 6 } else { *rank };
            out.snippet(*word, *insert, rank).kind = super::CompletionKind::Keyword;
        }
    }
}
