//! Proposals in codels: parameters, states, execution times; and in the parameters of services.

use rustc_hash::FxHashSet;
use smol_str::SmolStr;

use super::{
    CodelPlace, CompletionKind, Completions, initializer,
    names::{Names, Wanted, qualifier},
    pattern,
    statement::{after_simple_codel, quantity, type_or_nothing},
};
use crate::{
    elab::Entity,
    ide::{
        SymbolKind,
        context::{BodyKind, Context, FrameKind, Word},
        render,
    },
    model::{Codel, Component, ComponentKind, ParamDir, PortDir, Service, TypeId},
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
    let timed = context.after.rest.iter().any(|it| it.is("wcet"));
    let yields = rest.iter().position(|it| it.is_any(&["yield", "yields"]));
    if let Some(yields) = yields.filter(|it| *it > 0) {
        let after = &rest[yields + 1..];
        if let Some(wcet) = after.iter().position(|it| it.is("wcet")) {
            quantity(names, &after[wcet + 1..], &["s", "ms", "us"], out);
        } else if expects_state(after) {
            states(names, context, after, true, out);
        } else if !timed
            && !context
                .after
                .next()
                .is_some_and(|it| it.is_any(&[",", "::"]))
        {
            if after.last().is_some_and(|it| it.is("pause")) {
                out.keywords(&["::"], 0);
            } else {
                out.snippet("wcet", "wcet ${1:1} ms", 1);
            }
        }
        return;
    }
    let machine = matches!(context.body().0, BodyKind::Task | BodyKind::Activity);
    match rest {
        [] if machine => machine_snippets(names, context, out),
        [] => name(names, context, None, out),
        [open, triggers @ ..] if open.is("<") && !triggers.iter().any(|it| it.is(">")) => {
            if expects_state(triggers) {
                states(names, context, triggers, false, out);
            }
        }
        [open, state, .., close] if open.is("<") && close.is(">") => {
            name(names, context, Some(&state.text), out);
        }
        [open, ..] if open.is("<") => {
            let done = rest.last().is_some_and(|it| it.is(")"));
            if done || rest.iter().any(|it| it.is("wcet")) {
                let yields = |it: &Word| it.is_any(&["yield", "yields"]);
                if done && !context.after.rest.iter().any(yields) {
                    match context.after.next() {
                        Some(_) => out.keywords(&["yield"], 0),
                        None => {
                            out.snippet("yield", "yield ${1:ether}", 0);
                        }
                    }
                }
                after_simple_codel(names, context, rest, out);
            }
        }
        _ => after_simple_codel(names, context, rest, out),
    }
}

/// The name of a codel, as the others are named; with the rest of its declaration if nothing follows.
pub(super) fn name(
    names: &Names<'_, '_>,
    context: &Context,
    state: Option<&str>,
    out: &mut Completions,
) {
    let name = pattern::codel_name(names, context, state);
    let ends = |it: &Word| it.is_any(&["codel", "async", "validate", "}"]);
    let next = context.after.rest.first();
    let (parameters, tail) = match next {
        Some(next) if next.is("(") => (false, ""),
        Some(next) if next.is_any(&["yield", "yields"]) => (true, ""),
        Some(next) if context.after.same_line && !ends(next) => return,
        Some(next) if !ends(next) => (true, ""),
        _ if state.is_some() => (true, "\n\tyield ${2:ether};$0"),
        _ => (true, ";$0"),
    };
    let insert = match parameters {
        true => format!("{name}($1){tail}"),
        false => name.clone(),
    };
    let item = out.snippet(name, insert, 0);
    item.kind = CompletionKind::Symbol(SymbolKind::Codel);
    item.codel = Some(CodelPlace { parameters, tail });
}

fn expects_state(before: &[Word]) -> bool {
    before.last().is_none_or(|it| it.is(",") || it.is("::"))
}

/// The states that may stand at the cursor, after `<` or `yield`: after `yield` those that have a codel, or
/// that something leads to already; after `<` those that something leads to and that have none.
fn states(
    names: &Names<'_, '_>,
    context: &Context,
    before: &[Word],
    yields: bool,
    out: &mut Completions,
) {
    let paused = before.last().is_some_and(|it| it.is("::"));
    let next = context.after.next();
    let state_follows =
        next.is_some_and(|it| it.kind == dotgen_syntax::SyntaxKind::IDENT && !it.is("wcet"));
    if state_follows && !context.word.is_empty() {
        return;
    }
    let elements = |state: &str, paused: bool, it: &[Word]| match it {
        [name] => !paused && name.is(state),
        [.., colons, name] if colons.is("::") => paused && name.is(state),
        [name, ..] => !paused && name.is(state),
        [] => false,
    };
    let behind: Vec<&[Word]> = context.elements_behind().collect();
    let used = |state: &str, paused: bool| {
        let mut all = before.split(|it| it.is(",")).chain(behind.iter().copied());
        all.any(|it| elements(state, paused, it))
    };
    let machine = Machine::around(names, context);
    let wanted: Vec<&SmolStr> = machine.missing().collect();
    let mut known: Vec<&str> = Vec::new();
    let here = machine.here.iter().map(SmolStr::as_str);
    if yields {
        known.extend(machine.states.iter().map(SmolStr::as_str));
        known.extend(here);
        if machine.open {
            known.extend(["start", "stop"]);
        }
    } else {
        known.extend(wanted.iter().map(|it| it.as_str()));
        known.extend(["start", "stop"]);
        // `stop` has to lead to the end.
        let yields = context
            .after
            .rest
            .iter()
            .position(|it| it.is_any(&["yield", "yields"]));
        let ends = yields.is_none_or(|at| context.after.rest[at..].iter().any(|it| it.is("ether")));
        known.retain(|it| *it != "stop" || ends);
        known.retain(|it| machine.open || !machine.implemented.iter().any(|other| other == it));
    }
    let mut seen = FxHashSet::default();
    for state in known {
        if state == "ether" || !seen.insert(state) {
            continue;
        }
        let has_codel = machine
            .implemented
            .iter()
            .chain(&machine.here)
            .any(|it| it == state);
        let kind = CompletionKind::Symbol(SymbolKind::State);
        let definition = names.state(state);
        if !used(state, paused) {
            out.add(state, kind, u8::from(yields && !has_codel && !paused))
                .definition = definition;
        }
        if yields && !paused && !used(state, true) {
            out.add(format!("pause::{state}"), kind, 2).definition = definition;
        }
    }
    if yields && !paused && !used("ether", false) {
        out.add("ether", CompletionKind::Symbol(SymbolKind::State), 0)
            .detail = Some("ends the machine".into());
    }
    if yields && !paused && out.items.iter().any(|it| it.label.starts_with("pause::")) {
        out.add("pause::", CompletionKind::Keyword, 3);
    }
    if state_follows {
        out.with_comma();
    }
}

/// The state that a new codel of the machine is most likely for: one that something leads to, else `start` or `stop`.
pub(super) fn next_state(names: &Names<'_, '_>, context: &Context) -> Option<String> {
    let machine = Machine::around(names, context);
    let free = |it: &&str| !machine.implemented.iter().any(|other| other == *it);
    let missing = machine.missing().next().map(ToString::to_string);
    missing.or_else(|| {
        ["start", "stop"]
            .into_iter()
            .find(free)
            .map(ToOwned::to_owned)
    })
}

/// A whole codel for each state that still needs one.
pub(super) fn machine_snippets(names: &Names<'_, '_>, context: &Context, out: &mut Completions) {
    if context.after.next().is_some_and(|it| it.is("<")) {
        return;
    }
    let machine = Machine::around(names, context);
    let prefix = match context.current().last() {
        Some(it) if it.is("codel") => "",
        _ => "codel",
    };
    for state in machine.missing() {
        let label = format!("{prefix}<{state}>");
        let name = pattern::codel_name(names, context, Some(state));
        let insert = format!("{prefix}<{state}> ${{1:{name}}}($2)\n\tyield ${{3:ether}};$0");
        out.snippet(label, insert, 0).detail = Some(format!("the codel of state `{state}`"));
    }
    let Some(state) = next_state(names, context).filter(|_| prefix.is_empty()) else {
        return;
    };
    let name = pattern::codel_name(names, context, Some(&state));
    out.snippet(
        "<…>",
        format!("<${{1:{state}}}> ${{2:{name}}}($3)\n\tyield ${{4:ether}};$0"),
        1,
    );
}

/// What is known of the machine around the cursor.
struct Machine {
    /// Mentioned by it, in order.
    states: Vec<SmolStr>,
    /// With a codel, but for the one that the cursor is in.
    implemented: Vec<SmolStr>,
    /// Of the codel that the cursor is in.
    here: Vec<SmolStr>,
    /// Led to from some codel.
    targets: Vec<SmolStr>,
    activity: bool,
    /// Of an interface: the component may have more codels.
    open: bool,
}

impl Machine {
    fn around(names: &Names<'_, '_>, context: &Context) -> Machine {
        let (body, frame) = context.body();
        let owner = context.name_of(frame);
        let mut machine = Machine {
            states: Vec::new(),
            implemented: Vec::new(),
            here: written_triggers(context.current()),
            targets: Vec::new(),
            activity: body == BodyKind::Activity,
            open: false,
        };
        let Some(component) = names.component() else {
            return machine;
        };
        machine.open = component.kind == ComponentKind::Interface;
        let tasks = component
            .tasks
            .iter()
            .map(|it| (BodyKind::Task, &it.name, &it.codels));
        let services = component
            .services
            .iter()
            .map(|it| (BodyKind::Activity, &it.name, &it.codels));
        for (kind, name, codels) in tasks.chain(services) {
            if kind == body && owner.as_ref() == Some(name) {
                for codel in codels {
                    machine.codel(codel, names.is_around(codel.node));
                }
            }
        }
        machine
    }

    /// Notes a codel; `here` if the cursor is in it.
    fn codel(&mut self, codel: &Codel, here: bool) {
        let triggers = codel.triggers.iter().map(|it| it.name.clone());
        let yields = codel.yields.iter().map(|it| it.name.clone());
        let mut mention = |it: SmolStr| {
            if !self.states.contains(&it) {
                self.states.push(it);
            }
        };
        // States that only the codel at the cursor speaks of are being written.
        if !here {
            triggers.clone().for_each(&mut mention);
            yields.clone().for_each(&mut mention);
            self.implemented.extend(triggers);
        }
        self.targets.extend(yields);
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

/// The states of the codel that is being written: between `<` and `>`.
fn written_triggers(words: &[Word]) -> Vec<SmolStr> {
    let open = words.iter().position(|it| it.is("<"));
    let close = words.iter().position(|it| it.is(">"));
    let (Some(open), Some(close)) = (open, close) else {
        return Vec::new();
    };
    let between = words.get(open + 1..close).unwrap_or_default();
    between
        .iter()
        .filter(|it| !it.is(","))
        .map(|it| it.text.clone())
        .collect()
}

/// Whether a component has codels that run beside the others.
pub(super) fn has_async(component: &Component) -> bool {
    component
        .all_codels()
        .any(|it| component.codel(it).is_async)
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
            type_or_nothing(names, context, words, Wanted::SwitchTypes, out);
        }
        None => names.numbers(words, false, out),
    }
    // Another parameter follows without a comma.
    let next = context.after.next();
    if context.word.is_empty()
        && words.is_empty()
        && list_kind(context, context.frames.len() - 1).is_some()
        && next.is_some_and(|it| it.is_any(DIRECTIONS) || it.is_any(SOURCES))
    {
        out.with_comma();
    }
}

/// What may stand where a parameter goes on behind the cursor: directions, if only they are missing.
fn goes_on(context: &Context) -> bool {
    let next = context.after.next();
    next.is_some_and(|it| {
        it.kind == dotgen_syntax::SyntaxKind::IDENT && !it.is_any(DIRECTIONS) && !it.is_any(SOURCES)
            || it.is("::")
    })
}

/// The rest of a path is replaced with its beginning.
fn whole_path(context: &Context, out: &mut Completions) {
    let mut depth = 0_i32;
    let rest = context.after.list();
    let end = rest.iter().position(|it| {
        match it.text.as_str() {
            "[" => depth += 1,
            "]" => depth -= 1,
            _ => {}
        }
        depth == 0 && it.is_any(&[",", "=", "::"])
    });
    let path = &rest[..end.unwrap_or(rest.len())];
    if path.first().is_some_and(|it| it.is_any(&[".", "["])) {
        out.replaces_too(path);
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
    for (name, ty) in names
        .ids()
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
    let known = |it: &Source| it.source == "local" || names.is_known(it.definition);
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
    out.retain(known);
    out
}

fn codel_param(
    names: &Names<'_, '_>,
    context: &Context,
    words: &[Word],
    simple: bool,
    out: &mut Completions,
) {
    let mut all = sources(names, context, simple);
    let used = used_names(context);
    let whole_ids = all.iter().any(|it| it.source == "ids") && !used.iter().any(|it| it == "ids");
    let shared = Shared::around(names, context);
    all.retain(|it| !used.contains(&it.name) && !shared.forbids(it.source, &it.name));
    let mut whole_ids = whole_ids && !shared.any;
    // A codel that is used elsewhere has the same parameters everywhere.
    if let Some(other) = elsewhere(names, context) {
        all.retain_mut(|it| {
            let same = other.params.iter().find(|param| param.name == it.name);
            it.directions = match same.map(|it| it.dir) {
                Some(ParamDir::In) => &["in"],
                Some(ParamDir::Out) => &["out"],
                Some(ParamDir::Inout) => &["inout"],
                _ => &[],
            };
            !it.directions.is_empty()
        });
        whole_ids &= other
            .params
            .iter()
            .any(|it| it.path.is_empty() && it.name == "ids");
    }
    let source = words.first().filter(|it| it.is_any(SOURCES));
    let rest = &words[usize::from(source.is_some())..];
    let matching = |it: &&Source| source.is_none_or(|source| source.is(it.source));
    let Some((dir, path)) = rest.split_first().filter(|(dir, _)| dir.is_any(DIRECTIONS)) else {
        if !rest.is_empty() {
            return;
        }
        if goes_on(context) {
            out.keywords(DIRECTIONS, 0);
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
                let rank = i as u8;
                push(names, it, format!("{prefix}{dir} {}", it.name), rank, out);
            }
        }
        if source.is_none_or(|it| it.is("ids")) && whole_ids {
            for (i, dir) in DIRECTIONS.iter().enumerate() {
                let item = out.add(
                    format!("{dir} ::ids"),
                    CompletionKind::Symbol(SymbolKind::Ids),
                    3 + i as u8,
                );
                item.detail = Some("the whole ids".into());
            }
        }
        let directed = |dir: &&str| {
            all.iter()
                .filter(matching)
                .any(|it| it.directions.contains(dir))
        };
        let directions: Vec<&str> = DIRECTIONS.iter().copied().filter(directed).collect();
        out.keywords(&directions, 4);
        if source.is_none() {
            let there = |it: &&str| all.iter().any(|source| source.source == *it);
            let there: Vec<&str> = SOURCES.iter().copied().filter(there).collect();
            out.keywords(&there, 6);
        }
        whole_path(context, out);
        return;
    };
    match path {
        [] if context
            .after
            .next()
            .is_some_and(|it| it.kind == dotgen_syntax::SyntaxKind::IDENT) => {}
        [] => {
            for it in all.iter().filter(matching) {
                let fits = it.directions.contains(&dir.text.as_str());
                let rank = u8::from(!fits) * 2;
                let ambiguous = source.is_none()
                    && all.iter().filter(|other| other.name == it.name).count() > 1;
                if !(ambiguous || matches!(it.source, "port" | "remote") && !fits) {
                    push(names, it, it.name.to_string(), rank, out);
                }
            }
            if source.is_none_or(|it| it.is("ids")) && whole_ids {
                out.add("::ids", CompletionKind::Symbol(SymbolKind::Ids), 3)
                    .detail = Some("the whole ids".into());
            }
            whole_path(context, out);
        }
        [colons] if colons.is("::") && whole_ids => {
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

/// The same codel in another place of the component.
fn elsewhere<'a>(names: &Names<'a, '_>, context: &Context) -> Option<&'a Codel> {
    let name = context.head(context.top()).last()?;
    let component = names.component()?;
    let mut all = component.all_codels().map(|it| component.codel(it));
    all.find(|it| it.name == name.text && !names.is_at(it.src, name.range.start))
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
    if words.iter().any(|it| it.is(":")) {
        return;
    }
    let ids = names.ids();
    if let Some(eq) = words.iter().position(|it| it.is("=")) {
        let expected = parameter_type(names, context, context.frames.len() - 1, &words[..eq]);
        initializer::value(names, &words[eq + 1..], expected, out);
        return;
    }
    let used = used_names(context);
    let all = ids.map(|it| names.carried(it)).unwrap_or_default();
    let member = |label: String, name: &SmolStr, ty: TypeId, rank: u8, out: &mut Completions| {
        if used.contains(name) {
            return;
        }
        let item = out.add(label, CompletionKind::Symbol(SymbolKind::Member), rank);
        item.detail = Some(render::type_text(names.spec(), ty));
        item.definition = names.definition_of(ty);
    };
    match words {
        [] if goes_on(context) => out.keywords(DIRECTIONS, 0),
        [dir]
            if dir.is_any(DIRECTIONS)
                && context
                    .after
                    .next()
                    .is_some_and(|it| it.kind == dotgen_syntax::SyntaxKind::IDENT) => {}
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

fn service_param(names: &Names<'_, '_>, context: &Context, words: &[Word], out: &mut Completions) {
    // Its description.
    if words.iter().any(|it| it.is(":")) {
        return;
    }
    if let Some(eq) = words.iter().position(|it| it.is("=")) {
        let expected = parameter_type(names, context, context.frames.len() - 1, &words[..eq]);
        initializer::value(names, &words[eq + 1..], expected, out);
        return;
    }
    match words.split_first() {
        Some((dir, rest)) if dir.is_any(DIRECTIONS) => {
            type_or_nothing(names, context, rest, Wanted::PortTypes, out);
            if rest.last().is_none_or(|it| !it.is("::")) && rest.is_empty() {
                let follows = &context.after.rest;
                let typed = matches!(follows.as_slice(), [a, b, ..]
                    if a.kind == dotgen_syntax::SyntaxKind::IDENT
                        && (b.kind == dotgen_syntax::SyntaxKind::IDENT || b.is_any(&["::", "<"])));
                if !typed || !context.word.is_empty() {
                    names.base_types(Wanted::Types, 0, out);
                }
            }
            // A default value that is there fits few other types.
            let mut element = context.after.list().iter().take_while(|it| !it.is(","));
            if element.any(|it| it.is("=")) {
                out.items.retain(|it| it.kind == CompletionKind::BaseType);
            }
        }
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

/// Names of the other parameters of the list that the cursor is in.
fn used_names(context: &Context) -> Vec<SmolStr> {
    let frame = context.top();
    let before = &context.tokens[frame.open + 1..frame.start];
    let params = before
        .split(|it| it.is(","))
        .chain(context.elements_behind());
    params.filter_map(parameter_name).collect()
}

/// The name of a parameter: what it is renamed to, or the last member of its path.
fn parameter_name(param: &[Word]) -> Option<SmolStr> {
    let dir = param.iter().position(|it| it.is_any(DIRECTIONS))?;
    let path = param.get(dir + 1..)?;
    let end = path.iter().position(|it| it.is("=")).unwrap_or(path.len());
    let mut depth = 0_i32;
    let names = path[..end].iter().filter(|it| {
        match it.text.as_str() {
            "[" => depth += 1,
            "]" => depth -= 1,
            _ => {}
        }
        depth == 0 && it.kind == dotgen_syntax::SyntaxKind::IDENT
    });
    names.last().map(|it| it.text.clone())
}

/// What the codel at the cursor must not touch, as an async codel runs at the same time, or is one itself.
struct Shared {
    /// Source and first name.
    names: Vec<(&'static str, SmolStr)>,
    /// Whether the whole ids are among it.
    any: bool,
}

impl Shared {
    fn around(names: &Names<'_, '_>, context: &Context) -> Shared {
        let mut out = Shared {
            names: Vec::new(),
            any: false,
        };
        let Some(component) = names.component() else {
            return out;
        };
        let own = context
            .frames
            .len()
            .checked_sub(2)
            .map(|it| &context.frames[it]);
        let head = own.map_or(&[][..], |it| {
            &context.tokens[it.start.min(context.tokens.len())..]
        });
        let is_async = head.first().is_some_and(|it| it.is("async"));
        if !is_async && !has_async(component) {
            return out;
        }
        out.any = true;
        for at in component.all_codels() {
            let codel = component.codel(at);
            if (is_async || codel.is_async) && !names.is_around(codel.node) {
                out.add(&codel.params);
            }
        }
        if is_async {
            for it in &component.services {
                if it.kind == crate::model::ServiceKind::Attribute {
                    out.add(&it.params);
                }
            }
        }
        out
    }

    fn add(&mut self, params: &[crate::model::Param]) {
        use crate::model::{ParamSource, PathElement};
        for it in params {
            let source = match it.source {
                ParamSource::Port(_) => "port",
                ParamSource::Ids => "ids",
                _ => continue,
            };
            let first = match it.path.first() {
                Some(PathElement::Member(name)) if source == "ids" => name.clone(),
                _ => it.name.clone(),
            };
            self.names.push((source, first));
        }
    }

    fn forbids(&self, source: &str, name: &str) -> bool {
        self.names.iter().any(|it| it.0 == source && it.1 == name)
    }
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
        // The bound of a string does not matter to its values.
        let bound = path
            .iter()
            .position(|it| it.is("<"))
            .filter(|_| path.last().is_some_and(|it| it.is(">")));
        let path = &path[..bound.unwrap_or(path.len())];
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
