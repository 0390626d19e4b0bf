//! Proposals in codels: parameters, states, execution times; and in the parameters of services.

use rustc_hash::FxHashSet;
use smol_str::SmolStr;

use super::{
    CompletionKind, Completions, initializer,
    names::{Names, Wanted, qualifier},
    statement::{after_simple_codel, quantity, type_or_nothing},
};
use crate::{
    elab::Entity,
    ide::{
        SymbolKind,
        context::{BodyKind, Context, FrameKind, Word},
        render,
    },
    model::{Codel, ParamDir, PortDir, Service, TypeId},
};

const DIRECTIONS: &[&str] = &["in", "out", "inout"];
const SOURCES: &[&str] = &["ids", "local", "port", "remote"];

/// After `codel`.
pub(super) fn clause(
    names: &Names<'_, '_>,
    context: &Context,
    rest: &[Word],
    out: &mut Completions,
) {
    let yields = rest.iter().position(|it| it.is_any(&["yield", "yields"]));
    if let Some(yields) = yields.filter(|it| *it > 0) {
        let after = &rest[yields + 1..];
        if let Some(wcet) = after.iter().position(|it| it.is("wcet")) {
            quantity(names, &after[wcet + 1..], &["s", "ms", "us"], out);
        } else if expects_state(after) {
            states(names, context, after, true, out);
        } else {
            out.snippet("wcet", "wcet ${1:1} ms", 1);
        }
        return;
    }
    let machine = matches!(context.body().0, BodyKind::Task | BodyKind::Activity);
    match rest {
        [] if machine => machine_snippets(names, context, out),
        [open, triggers @ ..] if open.is("<") && !triggers.iter().any(|it| it.is(">")) => {
            if expects_state(triggers) {
                states(names, context, triggers, false, out);
            }
        }
        [open, ..] if open.is("<") => {
            let done = rest.last().is_some_and(|it| it.is(")"));
            if done || rest.iter().any(|it| it.is("wcet")) {
                if done {
                    out.snippet("yield", "yield ${1:ether}", 0);
                }
                after_simple_codel(names, rest, out);
            }
        }
        _ => after_simple_codel(names, rest, out),
    }
}

fn expects_state(before: &[Word]) -> bool {
    before.last().is_none_or(|it| it.is(",") || it.is("::"))
}

/// The states known at the cursor, after `<` or `yield`.
fn states(
    names: &Names<'_, '_>,
    context: &Context,
    before: &[Word],
    yields: bool,
    out: &mut Completions,
) {
    let paused = before.last().is_some_and(|it| it.is("::"));
    let used = |state: &str, paused: bool| {
        before.split(|it| it.is(",")).any(|it| match it {
            [name] => !paused && name.is(state),
            [.., name] => paused && name.is(state),
            [] => false,
        })
    };
    let machine = Machine::around(names, context);
    let wanted: Vec<&SmolStr> = machine.missing().collect();
    let mut known: Vec<&str> = Vec::new();
    if yields {
        known.extend(machine.states.iter().map(SmolStr::as_str));
        known.extend(["start", "stop"]);
    } else {
        known.extend(wanted.iter().map(|it| it.as_str()));
        known.extend(["start", "stop"]);
        known.extend(machine.states.iter().map(SmolStr::as_str));
    }
    let elsewhere: Vec<&str> = machine.elsewhere.iter().map(SmolStr::as_str).collect();
    let own = known.len();
    known.extend(elsewhere);
    let mut seen = FxHashSet::default();
    for (i, state) in known.into_iter().enumerate() {
        if state == "ether" || !seen.insert(state) {
            continue;
        }
        let has_codel = machine.implemented.iter().any(|it| it == state);
        let rank = match (i < own, yields, has_codel) {
            (false, ..) => 4,
            (_, false, true) => 5,
            _ => 0,
        };
        let kind = CompletionKind::Symbol(SymbolKind::State);
        let definition = names.state(state);
        if !used(state, paused) {
            out.add(
                state,
                kind,
                rank + u8::from(yields && !has_codel && !paused),
            )
            .definition = definition;
        }
        if yields && !paused && i < own && !used(state, true) {
            out.add(format!("pause::{state}"), kind, rank + 2)
                .definition = definition;
        }
    }
    if yields && !paused && !used("ether", false) {
        out.add("ether", CompletionKind::Symbol(SymbolKind::State), 0)
            .detail = Some("ends the machine".into());
    }
    if yields && !paused {
        out.add("pause::", CompletionKind::Keyword, 3);
    }
}

/// A whole codel for each state that still needs one.
pub(super) fn machine_snippets(names: &Names<'_, '_>, context: &Context, out: &mut Completions) {
    let machine = Machine::around(names, context);
    let prefix = match context.current().last() {
        Some(it) if it.is("codel") => "",
        _ => "codel",
    };
    for state in machine.missing() {
        let label = format!("{prefix}<{state}>");
        let insert = format!("{prefix}<{state}> ${{1:{state}}}($2)\n\tyield ${{3:ether}};$0");
        out.snippet(label, insert, 0).detail = Some(format!("the codel of state `{state}`"));
    }
    if !prefix.is_empty() {
        return;
    }
    out.snippet(
        "<…>",
        "<${1:start}> ${2:name}($3)\n\tyield ${4:ether};$0",
        1,
    );
}

/// What is known of the machine around the cursor.
struct Machine {
    /// Mentioned by it, in order.
    states: Vec<SmolStr>,
    /// With a codel.
    implemented: Vec<SmolStr>,
    /// Led to from some codel.
    targets: Vec<SmolStr>,
    /// Of the other machines of the component.
    elsewhere: Vec<SmolStr>,
    activity: bool,
}

impl Machine {
    fn around(names: &Names<'_, '_>, context: &Context) -> Machine {
        let (body, frame) = context.body();
        let owner = context.name_of(frame);
        let mut machine = Machine {
            states: Vec::new(),
            implemented: Vec::new(),
            targets: Vec::new(),
            elsewhere: Vec::new(),
            activity: body == BodyKind::Activity,
        };
        let Some(component) = names.component() else {
            return machine;
        };
        let tasks = component
            .tasks
            .iter()
            .map(|it| (BodyKind::Task, &it.name, &it.codels));
        let services = component
            .services
            .iter()
            .map(|it| (BodyKind::Activity, &it.name, &it.codels));
        for (kind, name, codels) in tasks.chain(services) {
            let own = kind == body && owner.as_ref() == Some(name);
            for codel in codels {
                machine.codel(codel, own);
            }
        }
        machine
    }

    fn codel(&mut self, codel: &Codel, own: bool) {
        for state in codel.triggers.iter().chain(&codel.yields) {
            let to = if own {
                &mut self.states
            } else {
                &mut self.elsewhere
            };
            if !to.contains(&state.name) {
                to.push(state.name.clone());
            }
        }
        if own {
            self.implemented
                .extend(codel.triggers.iter().map(|it| it.name.clone()));
            self.targets
                .extend(codel.yields.iter().map(|it| it.name.clone()));
        }
    }

    /// States that need a codel and have none.
    fn missing(&self) -> impl Iterator<Item = &SmolStr> {
        static START: SmolStr = SmolStr::new_static("start");
        let start = self.activity.then_some(&START);
        let mut seen = FxHashSet::default();
        start
            .into_iter()
            .chain(&self.targets)
            .filter(|it| *it != "ether" && !self.implemented.contains(it))
            .filter(move |it| seen.insert(it.as_str()))
    }
}

/// Between parentheses: of a codel, of a service, of a `switch`, of an expression.
pub(super) fn in_parentheses(names: &Names<'_, '_>, context: &Context, out: &mut Completions) {
    let frame = context.top();
    let words = context.current();
    match list_kind(context, context.frames.len() - 1) {
        Some(List::Codel { simple }) => codel_param(names, context, words, simple, out),
        Some(List::Attribute) => attribute_param(names, context, words, out),
        Some(List::Service) => service_param(names, context, words, out),
        None if context.head(frame).last().is_some_and(|it| it.is("switch")) => {
            out.items.clear();
            names.scoped(words, Wanted::Types, 0, out);
            for it in [
                "long",
                "unsigned long",
                "short",
                "unsigned short",
                "char",
                "boolean",
            ] {
                out.add(it, CompletionKind::BaseType, 1);
            }
        }
        None => names.constants(words, None, out),
    }
}

/// Parameter lists.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(in crate::ide) enum List {
    /// Of a codel; `simple` ones have neither ports nor remotes.
    Codel {
        simple: bool,
    },
    Attribute,
    /// Of a function or activity.
    Service,
}

/// Which parameter list a frame is, if it is one.
pub(in crate::ide) fn list_kind(context: &Context, frame: usize) -> Option<List> {
    let it = context.frames.get(frame)?;
    let parent = context.frames.get(frame.checked_sub(1)?)?;
    if it.kind != FrameKind::Paren || !matches!(parent.kind, FrameKind::Body(_)) {
        return None;
    }
    let head = context.head(it);
    // Another parenthesis before it: the list is done, this is an execution time.
    if head.iter().any(|it| it.is(")")) {
        return None;
    }
    match head {
        [first, _, ..] if first.is("attribute") => Some(List::Attribute),
        [first, _, ..] if first.is_any(&["function", "activity"]) => Some(List::Service),
        [first, _, ..] if first.is("validate") => Some(List::Codel { simple: true }),
        [first, rest @ ..] if first.is_any(&["codel", "async"]) => Some(List::Codel {
            simple: !rest.iter().any(|it| it.is("<")),
        }),
        _ => None,
    }
}

/// The service around the cursor, as far as it is known.
pub(in crate::ide) fn service_around<'a>(
    names: &Names<'a, '_>,
    context: &Context,
) -> Option<(u32, &'a Service)> {
    let (body, frame) = context.body();
    if !matches!(
        body,
        BodyKind::Attribute | BodyKind::Function | BodyKind::Activity
    ) {
        return None;
    }
    let name = context.name_of(frame)?;
    let all = names.component()?.services.iter();
    let mut all = (0..).zip(all);
    all.find(|(_, it)| it.name == name)
}

/// Something a codel parameter may refer to.
struct Source {
    name: SmolStr,
    source: &'static str,
    directions: &'static [&'static str],
    ty: TypeId,
    kind: SymbolKind,
    definition: Option<u32>,
}

fn sources(names: &Names<'_, '_>, context: &Context, simple: bool) -> Vec<Source> {
    let mut out = Vec::new();
    let Some(component) = names.component() else {
        return out;
    };
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
            });
        }
    }
    for (name, ty) in component
        .ids
        .map(|ids| names.members(ids))
        .unwrap_or_default()
    {
        out.push(Source {
            name,
            source: "ids",
            directions: DIRECTIONS,
            ty,
            kind: SymbolKind::Member,
            definition: names.definition_of(ty),
        });
    }
    if simple {
        return out;
    }
    for (i, port) in component.ports.iter().enumerate() {
        out.push(Source {
            name: port.name.clone(),
            source: "port",
            directions: match port.dir {
                PortDir::In => &["in"],
                PortDir::Out => &["out", "in", "inout"],
            },
            ty: port.data,
            kind: SymbolKind::Port,
            definition: names.part(|c| Entity::Port(c, i as u32)),
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
        });
    }
    out
}

fn codel_param(
    names: &Names<'_, '_>,
    context: &Context,
    words: &[Word],
    simple: bool,
    out: &mut Completions,
) {
    let all = sources(names, context, simple);
    let used = used_names(context);
    let source = words.first().filter(|it| it.is_any(SOURCES));
    let rest = &words[usize::from(source.is_some())..];
    let matching = |it: &&Source| source.is_none_or(|source| source.is(it.source));
    let Some((dir, path)) = rest.split_first().filter(|(dir, _)| dir.is_any(DIRECTIONS)) else {
        if !rest.is_empty() {
            return;
        }
        for it in all.iter().filter(matching) {
            let ambiguous = all.iter().filter(|other| other.name == it.name).count() > 1;
            // Ports are usually named as such.
            let explicit =
                source.is_none() && (ambiguous || matches!(it.source, "port" | "remote"));
            for (i, dir) in it.directions.iter().enumerate() {
                let prefix = if explicit {
                    format!("{} ", it.source)
                } else {
                    String::new()
                };
                let rank = i as u8 + if used.contains(&it.name) { 5 } else { 0 };
                push(names, it, format!("{prefix}{dir} {}", it.name), rank, out);
            }
        }
        if source.is_none_or(|it| it.is("ids"))
            && names.component().is_some_and(|it| it.ids.is_some())
        {
            for (i, dir) in DIRECTIONS.iter().enumerate() {
                let item = out.add(
                    format!("{dir} ::ids"),
                    CompletionKind::Symbol(SymbolKind::Ids),
                    3 + i as u8,
                );
                item.detail = Some("the whole ids".into());
            }
        }
        out.keywords(DIRECTIONS, 4);
        if source.is_none() {
            out.keywords(if simple { &SOURCES[..2] } else { SOURCES }, 6);
        }
        return;
    };
    match path {
        [] => {
            for it in all.iter().filter(matching) {
                let fits = it.directions.contains(&dir.text.as_str());
                let rank = if used.contains(&it.name) {
                    5
                } else {
                    u8::from(!fits) * 2
                };
                let ambiguous = source.is_none()
                    && all.iter().filter(|other| other.name == it.name).count() > 1;
                if !(ambiguous || it.source == "port" && !fits) {
                    push(names, it, it.name.to_string(), rank, out);
                }
            }
            if source.is_none_or(|it| it.is("ids")) {
                out.add("::ids", CompletionKind::Symbol(SymbolKind::Ids), 3)
                    .detail = Some("the whole ids".into());
            }
        }
        [colons] if colons.is("::") => {
            out.add("ids", CompletionKind::Symbol(SymbolKind::Ids), 0)
                .detail = Some("the whole ids".into());
        }
        [first, steps @ .., dot] if dot.is(".") => {
            let start = all.iter().filter(matching).find(|it| it.name == first.text);
            let ty = start.and_then(|it| walk(names, it.ty, steps));
            members(names, ty, out);
        }
        _ => {}
    }
}

fn push(names: &Names<'_, '_>, it: &Source, label: String, rank: u8, out: &mut Completions) {
    let item = out.add(label, CompletionKind::Symbol(it.kind), rank);
    item.detail = Some(render::type_text(names.spec(), it.ty));
    item.definition = it.definition;
}

fn attribute_param(
    names: &Names<'_, '_>,
    context: &Context,
    words: &[Word],
    out: &mut Completions,
) {
    let ids = names.component().and_then(|it| it.ids);
    if let Some(eq) = words.iter().position(|it| it.is("=")) {
        let expected = parameter_type(names, context, context.frames.len() - 1, &words[..eq]);
        initializer::value(names, &words[eq + 1..], expected, out);
        return;
    }
    let used = used_names(context);
    let all = ids.map(|it| names.members(it)).unwrap_or_default();
    let member = |label: String, name: &SmolStr, ty: TypeId, rank: u8, out: &mut Completions| {
        let rank = if used.contains(name) { rank + 5 } else { rank };
        let item = out.add(label, CompletionKind::Symbol(SymbolKind::Member), rank);
        item.detail = Some(render::type_text(names.spec(), ty));
        item.definition = names.definition_of(ty);
    };
    match words {
        [] => {
            for (name, ty) in &all {
                for (rank, dir) in DIRECTIONS.iter().enumerate() {
                    member(format!("{dir} {name}"), name, *ty, rank as u8, out);
                }
            }
            out.keywords(DIRECTIONS, 4);
        }
        [dir] if dir.is_any(DIRECTIONS) => {
            for (name, ty) in &all {
                member(name.to_string(), name, *ty, 0, out);
            }
        }
        [dir, steps @ .., dot] if dir.is_any(DIRECTIONS) && dot.is(".") => {
            let ty = ids.and_then(|ids| walk(names, ids, steps));
            members(names, ty, out);
        }
        _ => {}
    }
}

fn service_param(names: &Names<'_, '_>, context: &Context, words: &[Word], out: &mut Completions) {
    if let Some(eq) = words.iter().position(|it| it.is("=")) {
        let expected = parameter_type(names, context, context.frames.len() - 1, &words[..eq]);
        initializer::value(names, &words[eq + 1..], expected, out);
        return;
    }
    match words.split_first() {
        Some((dir, rest)) if dir.is_any(DIRECTIONS) => type_or_nothing(names, rest, false, out),
        Some(_) => {}
        None => out.keywords(DIRECTIONS, 0),
    }
}

fn members(names: &Names<'_, '_>, ty: Option<TypeId>, out: &mut Completions) {
    for (name, member) in ty.map(|it| names.members(it)).unwrap_or_default() {
        let item = out.add(name.as_str(), CompletionKind::Symbol(SymbolKind::Member), 0);
        item.detail = Some(render::type_text(names.spec(), member));
        item.definition = names.definition_of(member);
    }
}

/// Follows `.a [ 0 ] .b`.
fn walk(names: &Names<'_, '_>, mut ty: TypeId, steps: &[Word]) -> Option<TypeId> {
    let mut steps = steps.iter();
    while let Some(step) = steps.next() {
        match step.text.as_str() {
            "." => {}
            "[" => {
                ty = names.element(ty)?;
                steps.by_ref().find(|it| it.is("]"));
            }
            name => ty = names.members(ty).into_iter().find(|it| it.0 == name)?.1,
        }
    }
    Some(ty)
}

/// Names of the parameters before the cursor in its list.
fn used_names(context: &Context) -> Vec<SmolStr> {
    let frame = context.top();
    let before = &context.tokens[frame.open + 1..frame.start];
    let params = before.split(|it| it.is(","));
    let named = params.filter_map(|param| {
        let dir = param.iter().position(|it| it.is_any(DIRECTIONS))?;
        Some(param.get(dir + 1)?.text.clone())
    });
    named.collect()
}

/// The type of the parameter whose first words are given, in the parameter list of a service.
pub(in crate::ide) fn parameter_type(
    names: &Names<'_, '_>,
    context: &Context,
    frame: usize,
    words: &[Word],
) -> Option<TypeId> {
    let words = match words.iter().position(|it| it.is("=")) {
        Some(eq) => &words[..eq],
        None => words,
    };
    let (dir, rest) = words.split_first()?;
    if !dir.is_any(DIRECTIONS) {
        return None;
    }
    match list_kind(context, frame)? {
        List::Attribute => {
            let path = rest.iter().position(|it| it.is("::")).unwrap_or(rest.len());
            let ids = names.component()?.ids?;
            if path == 0 {
                return Some(ids);
            }
            walk(names, ids, &rest[..path])
        }
        List::Service => names.type_before_name(rest),
        List::Codel { .. } => None,
    }
}

impl Names<'_, '_> {
    /// The named type before the name of what is declared with it: `m::t name`.
    pub(in crate::ide) fn type_before_name(&self, words: &[Word]) -> Option<TypeId> {
        let (name, path) = words.split_last()?;
        let last = path.last()?;
        if name.is("]") {
            return None;
        }
        let (absolute, mut segments) = qualifier(&path[..path.len() - 1]);
        segments.push(last.text.clone());
        match self.resolve(absolute, &segments) {
            Some(found) => found.ty,
            None => self.base_type(&last.text),
        }
    }

    fn base_type(&self, word: &str) -> Option<TypeId> {
        use crate::model::TypeKind::*;
        let fits = |kind: &crate::model::TypeKind| match word {
            "boolean" => matches!(kind, Boolean),
            "double" => matches!(kind, Double),
            "float" => matches!(kind, Float),
            "octet" => matches!(kind, Octet),
            "short" => matches!(kind, Short | UnsignedShort),
            "long" => matches!(kind, Long | UnsignedLong | LongLong | UnsignedLongLong),
            "char" => matches!(kind, Char),
            "string" => matches!(kind, String { .. }),
            _ => false,
        };
        let found = self.spec().types.iter().position(|it| fits(&it.kind))?;
        Some(TypeId(found as u32))
    }

    /// The definition of a state of the component around the cursor.
    fn state(&self, name: &str) -> Option<u32> {
        let mut all = self.elaborated.definitions.iter();
        let component = &self.component()?.name;
        let found = all.find(|it| {
            it.kind == crate::elab::DefKind::State
                && it.name == name
                && it
                    .container
                    .is_some_and(|it| self.elaborated.definition(it).name == *component)
        })?;
        Some(found.id.0)
    }
}
