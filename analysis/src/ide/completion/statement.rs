//! Completion in a statement of a body.

use super::{
    CompletionKind, Completions,
    codel::{self, after_simple_codel},
    elements::{quantity, sizes, tasks},
    keywords,
    names::{NameCategory, VisibleNames},
};
use crate::{
    elab::Entity,
    ide::{
        SymbolKind,
        context::{BodyKind, Context, Word},
    },
};

pub(super) fn complete(
    names: &VisibleNames<'_, '_>,
    context: &Context,
    body: BodyKind,
    out: &mut Completions,
) {
    let words = context.current();
    let Some(first) = words.first() else {
        return beginning(names, context, body, out);
    };
    let rest = &words[1..];
    match first.text.as_str() {
        "const" => match rest.iter().rposition(|word| word.is("=")) {
            Some(eq) => {
                let expected = names.type_before_name(&rest[..eq]);
                names.constants(&rest[eq + 1..], expected, out);
            }
            None => type_or_nothing(names, context, rest, NameCategory::ConstTypes, out),
        },
        "typedef" => type_or_nothing(names, context, rest, NameCategory::Types, out),
        "union" if rest.len() == 1 => {
            let clause = match context.after.next() {
                Some(_) => "switch",
                None => "switch (${1:long}) {\n\tcase ${2:0}: ${3:long} ${4:member};$0\n};",
            };
            out.snippet("switch", clause, 0);
        }
        "case" if !rest.iter().any(|word| word.is(":")) => {
            names.constants(rest, names.switch_type(context), out);
        }
        "case" | "default" => {
            let colon = rest.iter().rposition(|word| word.is(":"));
            let rest = &rest[colon.map_or(0, |colon| colon + 1)..];
            type_or_nothing(names, context, rest, NameCategory::Types, out);
        }
        "port" => port(names, context, rest, out),
        "local" => {
            // As in the list of parameters.
            let last = rest.split(|word| word.is(",")).next_back();
            type_or_nothing(names, context, last.unwrap_or_default(), NameCategory::Types, out);
        }
        "task" if in_service(body) && rest.is_empty() => tasks(names, out),
        "provides" | "provide" | "uses" | "use" | "extends" | "extend" if expects_name(rest) => {
            names.interfaces(rest, 0, out);
            in_list(context, out);
        }
        "throws" | "throw" if rest.last().is_none_or(|word| word.is(",") || word.is("::")) => {
            exceptions(names, context, rest, out);
        }
        "interrupts" | "interrupt" | "before" | "after" if expects_name(rest) => {
            services(names, rest, context, out);
            in_list(context, out);
        }
        "scheduling" if rest.is_empty() => out.keywords(&["real-time"], 0),
        "period" | "delay" | "clock-rate" => quantity(names, rest, &["s", "ms", "us"], out),
        "stack" => quantity(names, rest, &["k", "M"], out),
        "priority" => quantity(names, rest, &[], out),
        "async" if rest.is_empty() => {
            codel::machine_snippets(names, context, out);
            if !context.after.next().is_some_and(|word| word.is("codel")) {
                out.keywords(&["codel"], 4);
            }
        }
        "async" => codel::clause(names, context, &rest[1..], out),
        "codel" => codel::clause(names, context, rest, out),
        "validate" if rest.is_empty() => codel::name(names, context, None, out),
        "validate" => after_simple_codel(names, context, rest, out),
        _ if matches!(body, BodyKind::Members | BodyKind::Ids) => {
            type_or_nothing(names, context, words, NameCategory::Types, out);
        }
        _ => {}
    }
}

/// Completion at the beginning of a statement.
fn beginning(
    names: &VisibleNames<'_, '_>,
    context: &Context,
    body: BodyKind,
    out: &mut Completions,
) {
    // Between `}` and its `;`.
    if context.after.ends {
        return;
    }
    keywords::statements(names, context, body, out);
    match body {
        BodyKind::Members | BodyKind::Ids => {
            type_or_nothing(names, context, &[], NameCategory::Types, out);
        }
        BodyKind::Task | BodyKind::Activity => codel::machine_snippets(names, context, out),
        _ => {}
    }
    if !matches!(body, BodyKind::Enum | BodyKind::Port) {
        // The code that an item inserts begins with its keyword.
        let no_letter = |character: char| !(character.is_alphanumeric() || character == '-');
        let codes = out.items.iter().map(|item| item.insert.as_str());
        let known: Vec<String> =
            codes.map(|code| code.split(no_letter).next().unwrap_or_default().to_owned()).collect();
        let begins = |word: &str| known.iter().any(|keyword| keyword == word);
        super::directive::beginning(names.view, context.word.start, 8, &begins, out);
    }
}

/// Exceptions that the list at the cursor does not name yet.
fn exceptions(
    names: &VisibleNames<'_, '_>,
    context: &Context,
    rest: &[Word],
    out: &mut Completions,
) {
    names.scoped(rest, NameCategory::Exceptions, 0, out);
    let same = |words: &[Word], label: &str| {
        words.iter().map(|word| word.text.as_str()).collect::<String>() == label
    };
    let before: Vec<&[Word]> = rest.split(|word| word.is(",")).collect();
    let qualifier: String = match before.last() {
        Some(part) => part.iter().map(|word| word.text.as_str()).collect(),
        None => String::new(),
    };
    out.items.retain(|item| {
        let label = format!("{qualifier}{}", item.label);
        !before.iter().any(|part| same(part, &label))
            && !context.elements_behind().any(|element| same(element, &label))
    });
    in_list(context, out);
}

/// Returns true if the cursor is in a string of a `requires` property.
pub(super) fn in_requires(context: &Context) -> bool {
    context.current().first().is_some_and(|word| {
        word.is_any(&["requires", "require", "codels-requires", "codels-require"])
    })
}

/// Returns true if the cursor is in the string of a `lang` property.
pub(super) fn in_lang(context: &Context) -> bool {
    context.current().first().is_some_and(|word| word.is("lang"))
}

fn in_service(body: BodyKind) -> bool {
    matches!(body, BodyKind::Attribute | BodyKind::Function | BodyKind::Activity)
}

fn expects_name(rest: &[Word]) -> bool {
    rest.last().is_none_or(|word| word.is(","))
}

/// In a list of names: adds a comma if another name follows.
fn in_list(context: &Context, out: &mut Completions) {
    let follows =
        context.after.next().is_some_and(|word| word.kind == dotgen_syntax::SyntaxKind::IDENT);
    let in_path = context.current().last().is_some_and(|word| word.is("::"));
    if follows && context.word.is_empty() {
        // A name after a qualifier is part of the path.
        if !in_path {
            out.with_comma();
        }
    } else if follows {
        out.items.clear();
    }
}

/// A type, unless there already is one and a name comes next.
pub(super) fn type_or_nothing(
    names: &VisibleNames<'_, '_>,
    context: &Context,
    words: &[Word],
    wanted: NameCategory,
    out: &mut Completions,
) {
    let known = out.items.len();
    type_at(names, words, wanted, out);
    let rest = &context.after.rest;
    let [next, then, ..] = rest.as_slice() else {
        return;
    };
    // The words of a base type belong together: `unsigned long`.
    let part = |word: &Word| word.is_any(&["long", "short", "unsigned"]);
    if !context.word.is_empty() && context.after.same_line && part(next) {
        let parts = rest.iter().take_while(|word| part(word)).last();
        let end = parts.map_or(out.replace.end, |part| part.range.end);
        for item in &mut out.items[known..] {
            item.replace.end = end;
        }
        return;
    }
    // There already is a type: another one does not fit before it.
    let word = |word: &Word| word.kind == dotgen_syntax::SyntaxKind::IDENT;
    let typed =
        context.after.same_line && (word(next) && (word(then) || then.is_any(&["::", "<"])));
    if typed && next.range.start == names.at() {
        // The cursor touches the type that is being written.
        let path =
            rest.chunks(2).take_while(|chunk| matches!(chunk, [_, colons] if colons.is("::")));
        let parts = rest.iter().take_while(|word| part(word)).count();
        let last = (2 * path.count()).max(parts.saturating_sub(1));
        let end = rest.get(last).map_or(next.range.end, |word| word.range.end);
        for item in &mut out.items[known..] {
            item.replace.end = end;
        }
    } else if typed {
        out.items.truncate(known);
    }
    // Before a path, names that open a scope.
    if context.after.same_line && next.is("::") {
        out.items.retain(|completion_item| completion_item.kind != CompletionKind::BaseType);
    }
    // Before angle brackets, types that have them.
    if context.after.same_line && next.is("<") {
        for item in out.items[known..].iter_mut().filter(|completion_item| completion_item.snippet)
        {
            let bare = item.insert.split('<').next().unwrap_or_default().to_owned();
            item.insert = bare;
            item.snippet = false;
        }
        out.items.retain(|completion_item| {
            completion_item.kind != CompletionKind::BaseType || completion_item.label == "string"
        });
    }
}

fn type_at(
    names: &VisibleNames<'_, '_>,
    words: &[Word],
    wanted: NameCategory,
    out: &mut Completions,
) {
    let Some(last) = words.last() else {
        names.types(words, wanted, 0, out);
        return;
    };
    let before_last = words.len().checked_sub(2).map(|place| &words[place]);
    match last.text.as_str() {
        "::" => names.types(words, wanted, 0, out),
        "<" if before_last.is_some_and(|word| word.is_any(&["sequence", "optional"])) => {
            let known = out.items.len();
            names.types(&[], NameCategory::Types, 0, out);
            // `>>` is one token.
            for item in out.items[known..]
                .iter_mut()
                .filter(|completion_item| completion_item.insert.ends_with('>'))
            {
                item.insert.push(' ');
            }
        }
        "<" if before_last.is_some_and(|word| word.is("string")) => sizes(names, out),
        "," if in_angles(words) => sizes(names, out),
        "unsigned" => out.keywords(&["short", "long", "long long"], 0),
        "long" if before_last.is_none_or(|word| !word.is_any(&["long", "double"])) => {
            out.keywords(&["long"], 5);
        }
        _ => {}
    }
}

fn in_angles(words: &[Word]) -> bool {
    let depth = words.iter().fold(0_i32, |depth, word| match word.text.as_str() {
        "<" => depth + 1,
        ">" => depth - 1,
        ">>" => depth - 2,
        _ => depth,
    });
    depth > 0
}

fn port(names: &VisibleNames<'_, '_>, context: &Context, rest: &[Word], out: &mut Completions) {
    let dir = rest.iter().position(|word| word.is_any(&["in", "out"]));
    if let Some(dir) = dir {
        type_or_nothing(names, context, &rest[dir + 1..], NameCategory::PortTypes, out);
    } else {
        let next = context.after.next();
        let directed = next.is_some_and(|word| word.is_any(&["in", "out"]));
        if !directed && !next.is_some_and(|word| word.is("multiple")) {
            out.keywords(&["in", "out"], 0);
        }
        if rest.is_empty() {
            out.keywords(&["multiple"], 1);
        }
    }
}

fn services(names: &VisibleNames<'_, '_>, used: &[Word], context: &Context, out: &mut Completions) {
    let component = names.component();
    let behind: Vec<Word> = context.elements_behind().flatten().cloned().collect();
    let used = [used, &behind].concat();
    for (i, service) in
        component.into_iter().flat_map(|component| component.services.iter_enumerated())
    {
        if used.iter().any(|word| word.text == service.name) {
            continue;
        }
        let definition = names.part(|c| Entity::Service(c, i));
        let kind = SymbolKind::from(service.kind);
        let item = out.add(service.name.as_str(), CompletionKind::Symbol(kind), 0);
        item.definition = definition;
    }
    if !used.iter().any(|word| word.is("all")) {
        out.keywords(&["all"], 1);
    }
}
