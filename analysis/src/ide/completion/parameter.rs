//! Completion in lists of parameters, of codels and of services.

use rustc_hash::FxHashMap;
use smol_str::SmolStr;

use super::{
    CompletionKind, Completions, initializer,
    names::{NameCategory, VisibleNames},
    parameter_list::{DIRECTIONS, List, SOURCES, list_kind, parameter_type, service_around, walk},
    sharing::Shared,
    statement::type_or_nothing,
};
use crate::{
    elab::{DefId, Entity},
    ide::{
        SymbolKind,
        context::{Context, Word},
        render,
    },
    model::{Codel, Owner, ParamDir, ParamSource, PathElement, PortDir, TypeId},
};

/// Between parentheses: of a codel, of a service, of a `switch`, of an expression.
pub(super) fn in_parentheses(
    names: &VisibleNames<'_, '_>,
    context: &Context,
    out: &mut Completions,
) {
    let frame = context.top();
    let words = context.current();
    match list_kind(context, context.frames.len() - 1) {
        Some(List::Codel { simple }) => codel_param(names, context, words, simple, out),
        Some(List::Attribute) => attribute_param(names, context, words, out),
        Some(List::Service) => service_param(names, context, words, out),
        None if context.head(frame).last().is_some_and(|head| head.is("switch")) => {
            out.items.clear();
            type_or_nothing(names, context, words, NameCategory::SwitchTypes, out);
        }
        None => names.numbers(words, false, out),
    }
    // Another parameter follows without a comma.
    let next = context.after.next();
    if list_kind(context, context.frames.len() - 1).is_some()
        && next.is_some_and(|word| word.is_any(DIRECTIONS) || word.is_any(SOURCES))
    {
        out.with_comma();
    }
}

/// Items for a parameter that continues after the cursor: directions, if only they are missing.
fn complete_before_parameter(context: &Context) -> bool {
    let next = context.after.next();
    next.is_some_and(|word| {
        word.kind == dotgen_syntax::SyntaxKind::IDENT
            && !word.is_any(DIRECTIONS)
            && !word.is_any(SOURCES)
            || word.is("::")
    })
}

/// Replaces the rest of a path together with its beginning.
fn whole_path(context: &Context, out: &mut Completions) {
    let mut depth = 0_i32;
    let rest = context.after.list();
    let end = rest.iter().position(|word| {
        match word.text.as_str() {
            "[" => depth += 1,
            "]" => depth -= 1,
            _ => {}
        }
        depth == 0 && word.is_any(&[",", "=", "::"])
    });
    let path = &rest[..end.unwrap_or(rest.len())];
    if path.first().is_some_and(|path| path.is_any(&[".", "["])) {
        out.replaces_too(path);
    }
}

/// A source that a codel parameter may refer to.
struct Source {
    name: SmolStr,
    source: &'static str,
    directions: &'static [&'static str],
    ty: TypeId,
    kind: SymbolKind,
    definition: Option<DefId>,
    /// True if another part of the component has the name, so that the source must be written, even where
    /// that part would be invalid.
    ambiguous: bool,
}

fn sources(names: &VisibleNames<'_, '_>, context: &Context, simple: bool) -> Vec<Source> {
    let mut out = Vec::new();
    let Some(component) = names.component() else {
        return out;
    };
    locals(names, context, &mut out);
    for (name, ty) in names.ids().map(|ids| names.members(ids)).unwrap_or_default() {
        out.push(Source {
            name,
            source: "ids",
            directions: DIRECTIONS,
            ty,
            kind: SymbolKind::Member,
            definition: names.definition_of(ty),
            ambiguous: false,
        });
    }
    for (i, port) in component.ports.iter_enumerated() {
        if !names.is_imported_above(port.imported_from) {
            continue;
        }
        out.push(Source {
            name: port.name.clone(),
            source: "port",
            directions: match port.dir {
                PortDir::In => &["in"],
                PortDir::Out => &["out", "in", "inout"],
            },
            ty: port.data,
            kind: SymbolKind::Port,
            definition: names.part(|c| Entity::Port(c, i)),
            ambiguous: false,
        });
    }
    for remote in &component.remotes {
        out.push(Source {
            name: remote.name.clone(),
            source: "remote",
            directions: &["in"],
            ty: remote.ty,
            kind: SymbolKind::Remote,
            definition: names.definition_of(remote.ty),
            ambiguous: false,
        });
    }
    let mut times: FxHashMap<SmolStr, usize> = FxHashMap::default();
    for source in &out {
        *times.entry(source.name.clone()).or_default() += 1;
    }
    for source in &mut out {
        source.ambiguous = times[&source.name] > 1;
    }
    if simple {
        out.retain(|source| !matches!(source.source, "port" | "remote"));
    } else {
        out.retain(|source| source.source == "local" || names.is_known(source.definition));
    }
    out
}

/// Adds the parameters and local variables of the service at the cursor.
fn locals(names: &VisibleNames<'_, '_>, context: &Context, out: &mut Vec<Source>) {
    if let Some((index, service)) = service_around(names, context) {
        for (i, param) in service.params.iter().enumerate() {
            out.push(Source {
                name: param.name.clone(),
                source: "local",
                directions: match param.dir {
                    ParamDir::In => &["in"],
                    ParamDir::Out => &["out"],
                    _ => &["in", "out", "inout"],
                },
                ty: param.ty,
                kind: match param.dir {
                    ParamDir::Local => SymbolKind::Local,
                    _ => SymbolKind::Parameter,
                },
                definition: names.part(|c| Entity::Param(c, index, i as u32)),
                ambiguous: false,
            });
        }
    }
}

/// The sources that a codel parameter at the cursor may name.
struct Choices<'w> {
    all: Vec<Source>,
    whole_ids: bool,
    /// The keyword of the source, if it is written.
    written: Option<&'w Word>,
}

impl<'w> Choices<'w> {
    /// The sources that are not used yet and that the other codels of the component allow.
    fn around(
        names: &VisibleNames<'_, '_>,
        context: &Context,
        words: &'w [Word],
        simple: bool,
    ) -> Choices<'w> {
        let mut all = sources(names, context, simple);
        let used = used_names(names, context);
        let whole_ids = all.iter().any(|source| source.source == "ids")
            && !used.iter().any(|name| name == "ids");
        let shared = Shared::around(names, context);
        all.retain(|source| {
            !used.contains(&source.name) && !shared.forbids(source.source, &source.name)
        });
        let mut whole_ids = whole_ids && !shared.any;
        // A codel that is used elsewhere has the same parameters everywhere.
        if let Some(other) = other_use_of_codel(names, context) {
            all.retain_mut(|source| {
                let same = other.params.iter().find(|param| param.name == source.name);
                source.directions = match same.map(|param| param.dir) {
                    Some(ParamDir::In) => &["in"],
                    Some(ParamDir::Out) => &["out"],
                    Some(ParamDir::Inout) => &["inout"],
                    _ => &[],
                };
                !source.directions.is_empty()
            });
            whole_ids &=
                other.params.iter().any(|param| param.path.is_empty() && param.name == "ids");
        }
        let written = words.first().filter(|word| word.is_any(SOURCES));
        Choices { all, whole_ids, written }
    }

    /// The sources of the kind that is written, or all.
    fn matching(&self) -> impl Iterator<Item = &Source> {
        self.all.iter().filter(|source| self.written.is_none_or(|word| word.is(source.source)))
    }

    /// Returns true if the parameter may be the whole ids.
    fn offers_ids(&self) -> bool {
        self.written.is_none_or(|word| word.is("ids")) && self.whole_ids
    }

    /// Completion before the direction: sources with a direction, and the keywords of both.
    fn before_direction(
        &self,
        names: &VisibleNames<'_, '_>,
        context: &Context,
        out: &mut Completions,
    ) {
        if complete_before_parameter(context) {
            out.keywords(DIRECTIONS, 0);
            return;
        }
        // Nothing is missing between a source and its direction.
        let next = context.after.next();
        let complete = self.written.is_some() && next.is_some_and(|word| word.is_any(DIRECTIONS));
        if complete && context.word.is_empty() {
            return;
        }
        for node in self.matching() {
            // Ports are usually written with `port`.
            let is_object = matches!(node.source, "port" | "remote");
            let prefix = if self.written.is_none() && (node.ambiguous || is_object) {
                format!("{} ", node.source)
            } else {
                String::new()
            };
            for (rank, dir) in (0..).zip(node.directions) {
                let label = format!("{prefix}{dir} {}", node.name);
                push(names, node, label, rank, out);
            }
        }
        if self.offers_ids() {
            for (rank, dir) in (3..).zip(DIRECTIONS) {
                push_ids(format!("{dir} ::ids"), rank, out);
            }
        }
        let directed = |dir: &&str| self.matching().any(|source| source.directions.contains(dir));
        let directions: Vec<&str> = DIRECTIONS.iter().copied().filter(directed).collect();
        out.keywords(&directions, 4);
        if self.written.is_none() {
            let there = |name: &&str| self.all.iter().any(|source| source.source == *name);
            let there: Vec<&str> = SOURCES.iter().copied().filter(there).collect();
            out.keywords(&there, 6);
        }
        whole_path(context, out);
    }

    /// Completion after a direction: sources, those that allow the direction first.
    fn after_direction(&self, names: &VisibleNames<'_, '_>, dir: &Word, out: &mut Completions) {
        for node in self.matching() {
            let fits = node.directions.contains(&dir.text.as_str());
            let rank = u8::from(!fits) * 2;
            let ambiguous = self.written.is_none() && node.ambiguous;
            if !(ambiguous || matches!(node.source, "port" | "remote") && !fits) {
                push(names, node, node.name.to_string(), rank, out);
            }
        }
        if self.offers_ids() {
            push_ids("::ids".into(), 3, out);
        }
    }
}

fn codel_param(
    names: &VisibleNames<'_, '_>,
    context: &Context,
    words: &[Word],
    simple: bool,
    out: &mut Completions,
) {
    let choices = Choices::around(names, context, words, simple);
    let rest = &words[usize::from(choices.written.is_some())..];
    let Some((dir, path)) = rest.split_first().filter(|(dir, _)| dir.is_any(DIRECTIONS)) else {
        if rest.is_empty() {
            choices.before_direction(names, context, out);
        }
        return;
    };
    match path {
        [] if context
            .after
            .next()
            .is_some_and(|word| word.kind == dotgen_syntax::SyntaxKind::IDENT) => {}
        [] => {
            choices.after_direction(names, dir, out);
            whole_path(context, out);
        }
        [colons] if colons.is("::") && choices.whole_ids => push_ids("ids".into(), 0, out),
        [first, steps @ .., dot] if dot.is(".") => {
            let mut matching = choices.matching();
            let start = matching.find(|source| source.name == first.text);
            let ty = start.and_then(|start| walk(names, start.ty, steps));
            members(names, ty, out);
        }
        _ => {}
    }
}

/// Adds the whole ids.
fn push_ids(label: String, rank: u8, out: &mut Completions) {
    out.add(label, CompletionKind::Symbol(SymbolKind::Ids), rank).detail =
        Some("the whole ids".into());
}

/// The same codel at another place of the component.
fn other_use_of_codel<'a>(names: &VisibleNames<'a, '_>, context: &Context) -> Option<&'a Codel> {
    let name = context.head(context.top()).last()?;
    let component = names.component()?;
    let mut all = component.all_codels().map(|codel| component.codel(codel));
    all.find(|codel| codel.name == name.text && !names.is_at(codel.src, name.range.start))
}

fn push(
    names: &VisibleNames<'_, '_>,
    source: &Source,
    label: String,
    rank: u8,
    out: &mut Completions,
) {
    let item = out.add(label, CompletionKind::Symbol(source.kind), rank);
    item.detail = Some(render::type_text(names.spec(), source.ty));
    item.definition = source.definition;
}

fn attribute_param(
    names: &VisibleNames<'_, '_>,
    context: &Context,
    words: &[Word],
    out: &mut Completions,
) {
    if words.iter().any(|word| word.is(":")) {
        return;
    }
    let ids = names.ids();
    if let Some(eq) = words.iter().position(|word| word.is("=")) {
        let expected = parameter_type(names, context, context.frames.len() - 1, &words[..eq]);
        initializer::value(names, &words[eq + 1..], expected, out);
        return;
    }
    let mut used = used_names(names, context);
    used.extend(members_of_codels(names, context));
    let all = ids.map(|ty| names.carried(ty)).unwrap_or_default();
    let member = |label: String, name: &SmolStr, ty: TypeId, rank: u8, out: &mut Completions| {
        if used.contains(name) {
            return;
        }
        let item = out.add(label, CompletionKind::Symbol(SymbolKind::Member), rank);
        item.detail = Some(render::type_text(names.spec(), ty));
        item.definition = names.definition_of(ty);
    };
    match words {
        [] if complete_before_parameter(context) => out.keywords(DIRECTIONS, 0),
        [dir]
            if dir.is_any(DIRECTIONS)
                && context
                    .after
                    .next()
                    .is_some_and(|word| word.kind == dotgen_syntax::SyntaxKind::IDENT) => {}
        [] => {
            for (name, ty) in &all {
                for (rank, dir) in DIRECTIONS.iter().enumerate() {
                    member(format!("{dir} {name}"), name, *ty, rank as u8, out);
                }
            }
            if !out.items.is_empty() {
                out.keywords(DIRECTIONS, 4);
            }
            whole_path(context, out);
        }
        [dir] if dir.is_any(DIRECTIONS) => {
            for (name, ty) in &all {
                member(name.to_string(), name, *ty, 0, out);
            }
            whole_path(context, out);
        }
        [dir, steps @ .., dot] if dir.is_any(DIRECTIONS) && dot.is(".") => {
            let ty = ids.and_then(|ids| walk(names, ids, steps));
            members(names, ty, out);
        }
        _ => {}
    }
}

fn service_param(
    names: &VisibleNames<'_, '_>,
    context: &Context,
    words: &[Word],
    out: &mut Completions,
) {
    // Its documentation.
    if words.iter().any(|word| word.is(":")) {
        return;
    }
    if let Some(eq) = words.iter().position(|word| word.is("=")) {
        let expected = parameter_type(names, context, context.frames.len() - 1, &words[..eq]);
        initializer::value(names, &words[eq + 1..], expected, out);
        return;
    }
    match words.split_first() {
        Some((dir, rest)) if dir.is_any(DIRECTIONS) => {
            type_or_nothing(names, context, rest, NameCategory::PortTypes, out);
            if rest.last().is_none_or(|word| !word.is("::")) && rest.is_empty() {
                let follows = &context.after.rest;
                let typed = matches!(follows.as_slice(), [a, b, ..]
                    if a.kind == dotgen_syntax::SyntaxKind::IDENT
                        && (b.kind == dotgen_syntax::SyntaxKind::IDENT || b.is_any(&["::", "<"])));
                let in_path = follows.first().is_some_and(|word| word.is("::"));
                if !in_path && (!typed || !context.word.is_empty()) {
                    names.base_types(NameCategory::Types, 0, out);
                }
            }
            // An existing default value fits few other types.
            let mut element = context.after.list().iter().take_while(|word| !word.is(","));
            if element.any(|element| element.is("=")) {
                out.items
                    .retain(|completion_item| completion_item.kind == CompletionKind::BaseType);
            }
        }
        Some(_) => {}
        None => out.keywords(DIRECTIONS, 0),
    }
}

fn members(names: &VisibleNames<'_, '_>, ty: Option<TypeId>, out: &mut Completions) {
    for (name, member) in ty.map(|ty| names.members(ty)).unwrap_or_default() {
        let item = out.add(name.as_str(), CompletionKind::Symbol(SymbolKind::Member), 0);
        item.detail = Some(render::type_text(names.spec(), member));
        item.definition = names.definition_of(member);
    }
}

/// Names of the other parameters of the list at the cursor.
fn used_names(names: &VisibleNames<'_, '_>, context: &Context) -> Vec<SmolStr> {
    let frame = context.top();
    let before = &context.tokens[frame.open + 1..frame.start];
    // A parameter right after the cursor, with a missing comma.
    let next = context.after.next();
    let joined = next.is_some_and(|word| word.is_any(DIRECTIONS) || word.is_any(SOURCES));
    let joined = joined.then(|| context.after.list().split(|word| word.is(",")).next());
    let params =
        before.split(|word| word.is(",")).chain(joined.flatten()).chain(context.elements_behind());
    let service = service_around(names, context).map(|service| service.1);
    let is_local = |name: &str| {
        let mut params = service.into_iter().flat_map(|service| &service.params);
        params.any(|param| param.name == name)
    };
    let name = |param| parameter_name(param, &is_local);
    params.filter_map(name).collect()
}

/// Ids members that the codels of an attribute use without a source: a parameter of that name would change
/// their meaning.
fn members_of_codels(names: &VisibleNames<'_, '_>, context: &Context) -> Vec<SmolStr> {
    let (Some(component), [.., name]) = (names.component(), context.head(context.top())) else {
        return Vec::new();
    };
    let mut services = component.services.iter_enumerated();
    let Some((service, _)) = services.find(|(_, service)| service.name == name.text) else {
        return Vec::new();
    };
    let codels = component.codels_of(Owner::Service(service));
    let params = codels.iter().flat_map(|codel| &codel.params);
    let of_ids = params.filter(|param| param.source == ParamSource::Ids);
    let named = of_ids.flat_map(|param| {
        let member = param.path.first().and_then(|path| match path {
            PathElement::Member(member) => Some(member.clone()),
            PathElement::Index(_) => None,
        });
        member.into_iter().chain([param.name.clone()])
    });
    named.collect()
}

/// The name of a parameter: its new name, or the last member of its path; for a parameter or local variable
/// of the service, the first (language reference, section 12).
fn parameter_name(param: &[Word], is_local: &dyn Fn(&str) -> bool) -> Option<SmolStr> {
    let dir = param.iter().position(|param| param.is_any(DIRECTIONS))?;
    let path = param.get(dir + 1..)?;
    let end = path.iter().position(|word| word.is("=")).unwrap_or(path.len());
    let mut depth = 0_i32;
    let names = path[..end].iter().filter(|word| {
        match word.text.as_str() {
            "[" => depth += 1,
            "]" => depth -= 1,
            _ => {}
        }
        depth == 0 && word.kind == dotgen_syntax::SyntaxKind::IDENT
    });
    let mut names = names;
    let first = names.next()?;
    let is_renamed = path[..end].iter().skip(1).any(|word| word.is("::"));
    let local = param[..dir].iter().any(|param| param.is("local"));
    let other = param[..dir].iter().any(|param| param.is_any(SOURCES)) && !local;
    let name = if !is_renamed && !other && (local || is_local(&first.text)) {
        first
    } else {
        names.last().unwrap_or(first)
    };
    Some(name.text.clone())
}
