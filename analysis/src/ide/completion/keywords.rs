//! Keywords that begin a statement, by body, with snippets for whole clauses.
//!
//! Placeholders are filled with existing names, so that a clause is valid as inserted: `@task` is a task of
//! the component, `@main` an unused name like `main`. A clause without a suitable name is not offered.

use super::{
    Completions, codel,
    names::{NameCategory, VisibleNames},
    pattern,
};
use crate::{
    ide::context::{BodyKind, Context},
    model::{ComponentKind, TypeKind},
};

/// A keyword and its snippet. Spellings are those of most published components.
type Statement = (&'static str, &'static str);

const IDL: &[Statement] = &[
    ("const", "const ${1:long} ${2:@name} = ${3:0};"),
    ("typedef", "typedef ${1:long} ${2:@name};"),
    ("struct", "struct ${1:@name} {\n\t${2:long} ${3:member};$0\n};"),
    ("union", "union ${1:@name} switch (${2:long}) {\n\tcase ${3:0}: ${4:long} ${5:member};$0\n};"),
    ("enum", "enum ${1:@name} {\n\t${2:@NAME}$0\n};"),
    ("exception", "exception ${1:@e_name};"),
    ("native", "native ${1:@name};"),
];

/// Types that are declared with a member of them.
const NESTED: &[Statement] = &[
    ("struct", "struct ${1:@name} {\n\t${2:long} ${3:member};$0\n} ${4:@entry};"),
    (
        "union",
        "union ${1:@name} switch (${2:long}) {\n\tcase ${3:0}: ${4:long} ${5:member};$0\n} ${6:@entry};",
    ),
    ("enum", "enum ${1:@name} {\n\t${2:@NAME}$0\n} ${3:@entry};"),
];

const SPECIFICATION: &[Statement] = &[
    (
        "component",
        "component ${1:@name} {\n\tversion \"${2:1.0}\";\n\tlang \"${3|c,c++|}\";\n\n\t$0\n};",
    ),
    ("interface", "interface ${1:@name} {\n\t$0\n};"),
    ("module", "module ${1:@name} {\n\t${2:typedef long ${3:@t_name};}$0\n};"),
];

const COMPONENT: &[Statement] = &[
    ("port in", "port in ${1:@port-type} ${2:@data};"),
    ("port out", "port out ${1:@port-type} ${2:@data};"),
    ("port multiple in", "port multiple in ${1:@port-type} ${2:@data};"),
    ("port multiple out", "port multiple out ${1:@port-type} ${2:@data};"),
    ("ids", "ids {\n\t${1:long} ${2:@state};$0\n};"),
    ("doc", "doc \"$0\";"),
    ("version", "version \"${1:1.0}\";"),
    ("lang", "lang \"${1|c,c++|}\";"),
    ("email", "email \"$0\";"),
    ("require", "require \"$0\";"),
    ("codels-require", "codels-require \"$0\";"),
    ("clock-rate", "clock-rate ${1:@rate};"),
    ("provides", "provides ${1:@interface};"),
    ("uses", "uses ${1:@interface};"),
    ("extends", "extends ${1:@interface};"),
    ("throw", "throw ${1:@exception};"),
];

/// Tasks and services, with codels.
const IMPLEMENTED: &[Statement] = &[
    (
        "task",
        // Its machine starts, cycles and can be stopped, so that no lint reports it.
        "task ${1:@main} {\n\tperiod ${2:@period};\n\n\tcodel<start> ${1}_start(${3:@ids})\n\t\tyield ${4:run};\n\t\
         codel<${4}> ${1}_${4}($5)\n\t\tyield pause::${4}, stop;\n\tcodel<stop> ${1}_stop()\n\t\tyield ether;$0\n};",
    ),
    (
        "task aperiodic",
        "task ${1:@main} {\n\tcodel<start> ${1}_start(${2:@ids})\n\t\tyield ether;$0\n};",
    ),
    ("attribute", "attribute ${1:@name}(${2:in @member}$3);$0"),
    ("function", "function ${1:@name}($2) {\n\tdoc \"${3}\";\n\n\tcodel ${1}_codel($4);$0\n};"),
    (
        "activity",
        "activity ${1:@name}($2) {\n\tdoc \"${3}\";\n\ttask ${4:@task};\n\n\tcodel<start> ${1}_start($5)\n\t\t\
         yield ${6:ether};$0\n};",
    ),
];

/// Tasks and services in interfaces, whose components have the codels.
const DECLARED: &[Statement] = &[
    ("function", "function ${1:@name}($2) {\n\tdoc \"${3}\";$0\n};"),
    ("activity", "activity ${1:@name}($2) {\n\tdoc \"${3}\";$0\n};"),
];

const TASK: &[Statement] = &[
    ("period", "period ${1:@period};"),
    ("delay", "delay ${1:@delay};"),
    ("priority", "priority ${1:100};"),
    ("scheduling", "scheduling real-time;"),
    ("stack", "stack ${1:64} k;"),
];

const SERVICE: &[Statement] = &[
    ("interrupt", "interrupt ${1:@service};"),
    ("before", "before ${1:@service};"),
    ("after", "after ${1:@service};"),
    ("validate", "validate ${1:@check_codel}($0);"),
];

const MACHINE: &[Statement] = &[
    ("codel", "codel<${1:@next-state}> ${2:@codel}($3)\n\tyield ${4:ether};$0"),
    ("async codel", "async codel<${1:@next-state}> ${2:@codel}($3)\n\tyield ${4:ether};$0"),
];

const SIMPLE: &[Statement] = &[("codel", "codel ${1:@codel}($0);")];
const TASK_OF: &[Statement] = &[("task", "task ${1:@task};")];
const LOCAL: &[Statement] = &[("local", "local ${1:long} ${2:@variable};")];
const DOC: &[Statement] = &[("doc", "doc \"$0\";")];
const THROW: &[Statement] = &[("throw", "throw ${1:@exception};")];
const CASES: &[Statement] = &[
    ("case", "case ${1:@case}: ${2:long} ${3:@member_name};$0"),
    ("default", "default: ${1:long} ${2:@member_name};$0"),
];

/// A word from these tables begins a statement of its own.
const ALL: &[&[Statement]] =
    &[SPECIFICATION, IDL, COMPONENT, IMPLEMENTED, TASK, SERVICE, MACHINE, LOCAL, THROW, CASES];

/// Properties allowed only once within one pair of braces (language reference, section 9).
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
    "ids",
    "default",
];

pub(super) fn statements(
    names: &VisibleNames<'_, '_>,
    context: &Context,
    body: BodyKind,
    out: &mut Completions,
) {
    use BodyKind::*;
    let tables: &[(&[Statement], u8)] = match body {
        Specification => &[(SPECIFICATION, 0), (IDL, 1)],
        Module => &[(IDL, 0), (&SPECIFICATION[2..], 1)],
        Component => &[(&COMPONENT[..5], 0), (IMPLEMENTED, 0), (&COMPONENT[5..], 0), (IDL, 2)],
        Interface => &[(&COMPONENT[..4], 0), (DECLARED, 0), (&COMPONENT[5..], 1), (IDL, 2)],
        Members | Ids => &[(NESTED, 4)],
        Cases => &[(CASES, 0)],
        Task => &[(MACHINE, 2), (TASK, 1), (DOC, 3), (THROW, 3)],
        Port => &[(DOC, 0)],
        Attribute => &[(DOC, 0), (&SERVICE[3..], 0), (SERVICE, 1), (THROW, 1)],
        Function => &[(DOC, 0), (SIMPLE, 0), (SERVICE, 1), (THROW, 1), (LOCAL, 2)],
        Activity => &[(TASK_OF, 0), (MACHINE, 2), (DOC, 3), (SERVICE, 3), (THROW, 3), (LOCAL, 4)],
        Enum | Unknown => &[],
    };
    let given = &context.top().given;
    let behind = context.after.rest.first().map(|word| &word.text);
    let given = |word: &str| {
        let mut all = given.iter().chain(&context.after.later).chain(behind);
        all.any(|text| text == word)
    };
    let in_component = matches!(body, Component | Interface);
    // Only the first word of the statement is missing, so only the word is inserted.
    // Some words have two forms, such as `throw` and `throws`.
    let stem = |word: &str| word.strip_suffix('s').unwrap_or(word).to_owned();
    let first_words = |word: &str| {
        let firsts = ALL.iter().copied().flatten();
        let mut firsts = firsts.filter_map(|clause| clause.0.split(' ').next());
        firsts.any(|first| stem(first) == stem(word))
    };
    let goes_on =
        context.after.next().is_some_and(|word| !word.is("}") && !first_words(&word.text));
    for (table, rank) in tables {
        for (word, insert) in *table {
            // In a component `task` is a declaration.
            let once = ONCE.contains(word) && !(in_component && *word == "task");
            if once && (given(word) || in_component && names.is_reopened()) {
                continue;
            }
            let inserted = if goes_on {
                Some((*word).to_owned()).filter(|_| *word != "task aperiodic")
            } else {
                fill_clause(names, context, body, word, insert, &given)
            };
            let Some(inserted) = inserted else { continue };
            let item = out.snippet(*word, inserted, *rank);
            item.kind = super::CompletionKind::Keyword;
            item.snippet = !goes_on;
        }
    }
}

/// A clause with an existing name for each `@word`; `None` if a name is missing.
fn fill_clause(
    names: &VisibleNames<'_, '_>,
    context: &Context,
    body: BodyKind,
    word: &str,
    clause: &str,
    given: &dyn Fn(&str) -> bool,
) -> Option<String> {
    if word == "delay" && !given("period") {
        return None;
    }
    let mut out = String::with_capacity(clause.len());
    let mut rest = clause;
    while let Some((before, after)) = rest.split_once('@') {
        out.push_str(before);
        let end = after.find(|character: char| {
            !character.is_ascii_alphanumeric() && !"_-".contains(character)
        });
        let (wanted, tail) = after.split_at(end.unwrap_or(after.len()));
        out.push_str(&clause_value(names, context, body, wanted)?);
        rest = tail;
    }
    out.push_str(rest);
    Some(out)
}

fn clause_value(
    names: &VisibleNames<'_, '_>,
    context: &Context,
    body: BodyKind,
    wanted: &str,
) -> Option<String> {
    let component = names.component();
    let first = |fill: &dyn Fn(&mut Completions)| {
        let mut found = Completions::empty();
        fill(&mut found);
        found.finish().into_iter().next().map(|completion_item| completion_item.label)
    };
    match wanted {
        "port-type" => first(&|out| names.scoped(&[], NameCategory::PortTypes, 0, out)),
        "exception" => first(&|out| names.scoped(&[], NameCategory::Exceptions, 0, out)),
        "interface" => first(&|out| names.interfaces(&[], 0, out)),
        "task" => {
            let mut tasks = Completions::empty();
            super::elements::tasks(names, &mut tasks);
            tasks.finish().into_iter().next().map(|completion_item| completion_item.label)
        }
        "service" => {
            let own = context.name_of(context.top());
            let mut others = component?.services.iter().map(|service| &service.name);
            let other = others.find(|name| Some(*name) != own.as_ref());
            Some(other.map_or_else(|| "all".to_owned(), ToString::to_string))
        }
        "member" => Some(names.carried(names.ids()?).first()?.0.to_string()),
        "ids" => {
            let shared = names.ids().is_some() && !codel::has_async(component?);
            Some(if shared { "out ::ids" } else { "" }.to_owned())
        }
        "case" => Some(case(names, context)),
        "next-state" => codel::next_state(names, context),
        "codel" => Some(match body {
            BodyKind::Task | BodyKind::Activity => {
                pattern::codel_name(names, context, codel::next_state(names, context).as_deref())
            }
            _ => pattern::codel_name(names, context, None),
        }),
        "rate" => Some(time(clock(names).unwrap_or((1, 1000)))),
        "delay" => Some(format!("0 {}", "ms")),
        // A multiple of the clock, near 10 ms.
        "period" => Some(match component.and_then(|component| component.clock_rate.as_ref()) {
            Some(rate)
                if component
                    .is_some_and(|component| component.kind == ComponentKind::Component) =>
            {
                let rate = rate.value;
                let ten = crate::model::Seconds::new(1, 100);
                let times = (ten / rate).floor().max(1.into());
                let value = rate * times;
                time((*value.numer(), *value.denom()))
            }
            _ => "10 ms".to_owned(),
        }),
        base => Some(names.unused_name_like(base)),
    }
}

/// A value of the switch type of the union around the cursor.
fn case(names: &VisibleNames<'_, '_>, context: &Context) -> String {
    let zero = || "0".to_owned();
    let Some(ty) = names.switch_type(context) else {
        return zero();
    };
    match &names.spec().ty(names.value_type(ty)).kind {
        TypeKind::Boolean => "TRUE".to_owned(),
        TypeKind::Char => "'a'".to_owned(),
        TypeKind::Enum { .. } => {
            let mut found = Completions::empty();
            names.constants(&[], Some(ty), &mut found);
            let first = found.finish().into_iter().next();
            first.map_or_else(zero, |completion_item| completion_item.label)
        }
        _ => zero(),
    }
}

/// The greatest common divisor of all periods and delays of the component, at most one millisecond.
fn clock(names: &VisibleNames<'_, '_>) -> Option<(i128, i128)> {
    let tasks = &names.component()?.tasks;
    let times = tasks.iter().flat_map(|task| task.period.iter().chain(&task.delay));
    let times: Vec<_> = times.map(|time| time.value).collect();
    let fits = |rate: &&(i128, i128)| {
        let rate = crate::model::Seconds::new(rate.0, rate.1);
        times.iter().all(|time| (*time / rate).is_integer())
    };
    [(1, 1000), (1, 2000), (1, 10_000), (1, 100_000), (1, 1_000_000)].iter().find(fits).copied()
}

/// A time as written, in the largest unit in which it is an integer.
fn time((numerator, denominator): (i128, i128)) -> String {
    let units = [(1, "s"), (1_000, "ms"), (1_000_000, "us")];
    let whole = units.iter().rev().rfind(|unit| {
        numerator.checked_mul(unit.0).is_some_and(|product| product % denominator == 0)
    });
    match whole {
        Some((scale, unit)) => format!("{} {unit}", numerator * scale / denominator),
        None => "10 ms".to_owned(),
    }
}
