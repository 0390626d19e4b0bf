//! Proposals in a statement of a body.

use super::{
    CompletionKind, Completions, codel, keywords,
    names::{Names, Wanted},
};
use crate::{
    elab::Entity,
    ide::{
        SymbolKind,
        context::{BodyKind, Context, Word},
    },
};

pub(super) fn complete(
    names: &Names<'_, '_>,
    context: &Context,
    body: BodyKind,
    out: &mut Completions,
) {
    let words = context.current();
    let Some(first) = words.first() else {
        keywords::statements(context, body, out);
        match body {
            BodyKind::Members | BodyKind::Ids => names.types(words, false, 0, out),
            BodyKind::Task | BodyKind::Activity => codel::machine_snippets(names, context, out),
            _ => {}
        }
        if !matches!(body, BodyKind::Enum | BodyKind::Port) {
            super::directive::macros(names.view, context.word.start, 8, out);
        }
        return;
    };
    let rest = &words[1..];
    match first.text.as_str() {
        "const" => match rest.iter().rposition(|it| it.is("=")) {
            Some(eq) => {
                let expected = names.type_before_name(&rest[..eq]);
                names.constants(&rest[eq + 1..], expected, out);
            }
            None => type_or_nothing(names, rest, false, out),
        },
        "typedef" => type_or_nothing(names, rest, false, out),
        "union" if rest.len() == 1 => {
            out.snippet("switch", "switch (${1:long}) {\n\tcase ${2:0}: $0\n}", 0);
        }
        "case" if !rest.iter().any(|it| it.is(":")) => names.constants(rest, None, out),
        "case" | "default" => {
            let colon = rest.iter().rposition(|it| it.is(":"));
            type_or_nothing(names, &rest[colon.map_or(0, |it| it + 1)..], false, out);
        }
        "port" => port(names, rest, out),
        "local" => type_or_nothing(names, rest, false, out),
        "task" if in_service(body) && rest.is_empty() => {
            tasks(names, out);
        }
        "provides" | "provide" | "uses" | "use" | "extends" | "extend" if expects_name(rest) => {
            names.interfaces(rest, 0, out);
        }
        "throws" | "throw" if rest.last().is_none_or(|it| it.is(",") || it.is("::")) => {
            names.scoped(rest, Wanted::Exceptions, 0, out);
        }
        "interrupts" | "interrupt" | "before" | "after" if expects_name(rest) => {
            services(names, rest, out);
        }
        "scheduling" if rest.is_empty() => out.keywords(&["real-time"], 0),
        "period" | "delay" | "clock-rate" => quantity(names, rest, &["s", "ms", "us"], out),
        "stack" => quantity(names, rest, &["k", "M"], out),
        "priority" => quantity(names, rest, &[], out),
        "async" if rest.is_empty() => {
            codel::machine_snippets(names, context, out);
            out.keywords(&["codel"], 4);
        }
        "async" => codel::clause(names, context, &rest[1..], out),
        "codel" => codel::clause(names, context, rest, out),
        "validate" => after_simple_codel(names, rest, out),
        _ if matches!(body, BodyKind::Members | BodyKind::Ids) => {
            type_or_nothing(names, words, false, out);
        }
        _ => {}
    }
}

/// Whether the cursor is in a string of a `requires` property.
pub(super) fn in_requires(context: &Context) -> bool {
    context
        .current()
        .first()
        .is_some_and(|it| it.is_any(&["requires", "require", "codels-requires", "codels-require"]))
}

/// Whether the cursor is in the string of a `lang` property.
pub(super) fn in_lang(context: &Context) -> bool {
    context.current().first().is_some_and(|it| it.is("lang"))
}

fn in_service(body: BodyKind) -> bool {
    matches!(
        body,
        BodyKind::Attribute | BodyKind::Function | BodyKind::Activity
    )
}

fn expects_name(rest: &[Word]) -> bool {
    rest.last().is_none_or(|it| it.is(","))
}

/// A type, unless one is already there and a name comes next.
pub(super) fn type_or_nothing(
    names: &Names<'_, '_>,
    words: &[Word],
    port: bool,
    out: &mut Completions,
) {
    let Some(last) = words.last() else {
        names.types(words, port, 0, out);
        return;
    };
    let before_last = words.len().checked_sub(2).map(|it| &words[it]);
    match last.text.as_str() {
        "::" => names.types(words, port, 0, out),
        "<" if before_last.is_some_and(|it| it.is_any(&["sequence", "optional"])) => {
            names.types(&[], false, 0, out);
        }
        "<" if before_last.is_some_and(|it| it.is("string")) => names.constants(&[], None, out),
        "," if in_angles(words) => names.constants(&[], None, out),
        "unsigned" => out.keywords(&["short", "long", "long long"], 0),
        "long" if before_last.is_none_or(|it| !it.is("long")) => out.keywords(&["long"], 5),
        _ => {}
    }
}

fn in_angles(words: &[Word]) -> bool {
    let depth = words
        .iter()
        .fold(0_i32, |depth, it| match it.text.as_str() {
            "<" => depth + 1,
            ">" => depth - 1,
            ">>" => depth - 2,
            _ => depth,
        });
    depth > 0
}

fn port(names: &Names<'_, '_>, rest: &[Word], out: &mut Completions) {
    let dir = rest.iter().position(|it| it.is_any(&["in", "out"]));
    match dir {
        Some(dir) => type_or_nothing(names, &rest[dir + 1..], true, out),
        None => {
            out.keywords(&["in", "out"], 0);
            if rest.is_empty() {
                out.keywords(&["multiple"], 1);
            }
        }
    }
}

fn tasks(names: &Names<'_, '_>, out: &mut Completions) {
    let Some(component) = names.component() else {
        return;
    };
    for (i, task) in component.tasks.iter().enumerate() {
        let definition = names.part(|c| Entity::Task(c, i as u32));
        let item = out.add(
            task.name.as_str(),
            CompletionKind::Symbol(SymbolKind::Task),
            0,
        );
        item.definition = definition;
        item.detail = task
            .period
            .as_ref()
            .map(|it| format!("period {}", crate::lint::duration(it.value)));
    }
}

fn services(names: &Names<'_, '_>, used: &[Word], out: &mut Completions) {
    let component = names.component();
    for (i, service) in component
        .into_iter()
        .flat_map(|it| it.services.iter().enumerate())
    {
        if used.iter().any(|it| it.text == service.name) {
            continue;
        }
        let definition = names.part(|c| Entity::Service(c, i as u32));
        let kind = SymbolKind::from(service.kind);
        let item = out.add(service.name.as_str(), CompletionKind::Symbol(kind), 0);
        item.definition = definition;
    }
    if !used.iter().any(|it| it.is("all")) {
        out.keywords(&["all"], 1);
    }
}

/// A number, then its unit.
pub(super) fn quantity(
    names: &Names<'_, '_>,
    rest: &[Word],
    units: &[&str],
    out: &mut Completions,
) {
    use dotgen_syntax::SyntaxKind::*;
    match rest.last().map(|it| it.kind) {
        Some(INT | FLOAT | IDENT | R_PAREN) => {
            for it in units {
                out.add(*it, CompletionKind::Unit, 0);
            }
        }
        _ => {
            names.constants(rest, None, out);
            out.items.retain(|it| it.kind != CompletionKind::Keyword);
            super::directive::values(names.view, names.at(), 4, out);
        }
    }
}

pub(super) fn after_simple_codel(names: &Names<'_, '_>, rest: &[Word], out: &mut Completions) {
    if let Some(wcet) = rest.iter().rposition(|it| it.is("wcet")) {
        quantity(names, &rest[wcet + 1..], &["s", "ms", "us"], out);
    } else if rest.last().is_some_and(|it| it.is(")")) {
        out.snippet("wcet", "wcet ${1:1} ms", 1);
    }
}
