//! Completion in codels: names, states, execution times.

use rustc_hash::FxHashSet;
use smol_str::SmolStr;

use super::{
    CodelPlace, CompletionKind, Completions, elements::quantity, names::VisibleNames, pattern,
};
use crate::{
    elab::{DefId, DefKind},
    ide::{
        SymbolKind,
        context::{BodyKind, Context, Word},
    },
    model::{Codel, Component, ComponentKind, fsm},
};

/// The words after the cursor that belong to the codel at the cursor.
fn own_words(context: &Context) -> impl Iterator<Item = &Word> {
    let behind = context.after.rest.iter();
    behind.take_while(|word| !word.is_any(&["codel", "async", "validate"]))
}

/// After `codel`.
pub(super) fn clause(
    names: &VisibleNames<'_, '_>,
    context: &Context,
    rest: &[Word],
    out: &mut Completions,
) {
    let timed = own_words(context).any(|word| word.is("wcet"));
    let yields = rest.iter().position(|word| word.is_any(&["yield", "yields"]));
    if let Some(yields) = yields.filter(|place| *place > 0) {
        let after = &rest[yields + 1..];
        if let Some(wcet) = after.iter().position(|word| word.is("wcet")) {
            quantity(names, &after[wcet + 1..], &["s", "ms", "us"], out);
        } else if expects_state(after) {
            states(names, context, after, true, out);
        } else if !timed && !context.after.next().is_some_and(|word| word.is_any(&[",", "::"])) {
            if after.last().is_some_and(|word| word.is("pause")) {
                out.keywords(&["::"], 0);
            } else {
                out.wcet(context);
            }
        }
        return;
    }
    let machine = matches!(context.body().0, BodyKind::Task | BodyKind::Activity);
    match rest {
        [] if machine => machine_snippets(names, context, out),
        [] => name(names, context, None, out),
        [open, triggers @ ..]
            if open.is("<") && !triggers.iter().any(|trigger| trigger.is(">")) =>
        {
            if expects_state(triggers) {
                states(names, context, triggers, false, out);
            }
        }
        [open, state, .., close] if open.is("<") && close.is(">") => {
            name(names, context, Some(&state.text), out);
        }
        [open, ..] if open.is("<") => {
            let done = rest.last().is_some_and(|word| word.is(")"));
            if done || rest.iter().any(|word| word.is("wcet")) {
                if done && !own_words(context).any(|word| word.is_any(&["yield", "yields"])) {
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

/// The name of a codel, in the pattern of the others; with the rest of its declaration if nothing follows.
pub(super) fn name(
    names: &VisibleNames<'_, '_>,
    context: &Context,
    state: Option<&str>,
    out: &mut Completions,
) {
    let name = pattern::codel_name(names, context, state);
    let ends = |word: &Word| word.is_any(&["codel", "async", "validate", "}"]);
    let next = context.after.rest.first();
    let (parameters, tail) = match next {
        Some(next) if next.is("(") => (false, ""),
        Some(next) if next.is_any(&["yield", "yields"]) => (true, ""),
        Some(next) if context.after.same_line && !ends(next) => return,
        Some(next) if !ends(next) => (true, ""),
        _ if state.is_some() => (true, "\n\tyield ${2:ether};$0"),
        _ => (true, ";$0"),
    };
    let insert = if parameters { format!("{name}($1){tail}") } else { name.clone() };
    let item = out.snippet(name, insert, 0);
    item.kind = CompletionKind::Symbol(SymbolKind::Codel);
    item.codel = Some(CodelPlace { parameters, tail });
}

fn expects_state(before: &[Word]) -> bool {
    before.last().is_none_or(|word| word.is(",") || word.is("::"))
}

/// The states allowed at the cursor, after `<` or `yield`: after `yield`, the states that have a codel or a
/// transition to them; after `<`, the states with a transition to them and without a codel.
fn states(
    names: &VisibleNames<'_, '_>,
    context: &Context,
    before: &[Word],
    yields: bool,
    out: &mut Completions,
) {
    let paused = before.last().is_some_and(|word| word.is("::"));
    let next = context.after.next();
    let state_follows =
        next.is_some_and(|word| word.kind == dotgen_syntax::SyntaxKind::IDENT && !word.is("wcet"));
    if state_follows && !context.word.is_empty() {
        return;
    }
    let elements = |state: &str, paused: bool, words: &[Word]| match words {
        [name] => !paused && name.is(state),
        [.., colons, name] if colons.is("::") => paused && name.is(state),
        [name, ..] => !paused && name.is(state),
        [] => false,
    };
    let behind: Vec<&[Word]> = context.elements_behind().collect();
    let used = |state: &str, paused: bool| {
        let mut all = before.split(|word| word.is(",")).chain(behind.iter().copied());
        all.any(|part| elements(state, paused, part))
    };
    let machine = Machine::around(names, context);
    let mut seen = FxHashSet::default();
    let mut may_pause = false;
    for state in machine.allowed(context, yields) {
        if state == "ether" || !seen.insert(state) {
            continue;
        }
        let has_codel = machine.implemented.iter().chain(&machine.here).any(|name| name == state);
        let kind = CompletionKind::Symbol(SymbolKind::State);
        let definition = names.state(state);
        // A transition that closes a cycle is most likely meant to pause.
        let closes = yields && !paused && machine.closing.iter().any(|name| name == state);
        let rank = u8::from(yields && !has_codel && !paused);
        let (plain, pausing) = if closes { (2, rank) } else { (rank, 2) };
        if !used(state, paused) {
            out.add(state, kind, plain).definition = definition;
        }
        if yields && !paused && !used(state, true) {
            may_pause = true;
            out.add(format!("pause::{state}"), kind, pausing).definition = definition;
        }
    }
    if yields && !paused && !used("ether", false) {
        out.add("ether", CompletionKind::Symbol(SymbolKind::State), 0).detail =
            Some("ends the machine".into());
    }
    if may_pause {
        out.add("pause::", CompletionKind::Keyword, 3);
    }
    if state_follows {
        out.with_comma();
    }
}

/// The most likely state of a new codel of the machine: the target of a transition, otherwise `start` or
/// `stop`.
pub(super) fn next_state(names: &VisibleNames<'_, '_>, context: &Context) -> Option<String> {
    let machine = Machine::around(names, context);
    let free = |text: &&str| !machine.implemented.iter().any(|other| other == *text);
    let missing = machine.missing().next().map(ToString::to_string);
    missing.or_else(|| ["start", "stop"].into_iter().find(free).map(ToOwned::to_owned))
}

/// A whole codel for each state that still needs one.
pub(super) fn machine_snippets(
    names: &VisibleNames<'_, '_>,
    context: &Context,
    out: &mut Completions,
) {
    if context.after.next().is_some_and(|word| word.is("<")) {
        return;
    }
    let machine = Machine::around(names, context);
    let prefix = match context.current().last() {
        Some(word) if word.is("codel") => "",
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
    out.snippet("<…>", format!("<${{1:{state}}}> ${{2:{name}}}($3)\n\tyield ${{4:ether}};$0"), 1);
}

/// The machine around the cursor.
struct Machine {
    /// States mentioned by it, in order.
    states: Vec<SmolStr>,
    /// States with a codel, except the codel at the cursor.
    implemented: Vec<SmolStr>,
    /// States of the codel at the cursor.
    here: Vec<SmolStr>,
    /// Targets of some codel.
    targets: Vec<SmolStr>,
    /// States that would close a cycle without pause if the codel at the cursor led to them.
    closing: Vec<SmolStr>,
    activity: bool,
    /// True for an interface: the component may have more codels.
    open: bool,
    /// True for an interface that no component of the specification provides.
    unprovided: bool,
}

impl Machine {
    fn around(names: &VisibleNames<'_, '_>, context: &Context) -> Machine {
        let (body, frame) = context.body();
        let owner = context.name_of(frame);
        let mut machine = Machine {
            states: Vec::new(),
            implemented: Vec::new(),
            here: written_triggers(context.current()),
            targets: Vec::new(),
            closing: Vec::new(),
            activity: body == BodyKind::Activity,
            open: false,
            unprovided: false,
        };
        let Some(component) = names.component() else {
            return machine;
        };
        machine.open = component.kind == ComponentKind::Interface;
        let number = names.component_number();
        let mut components = names.spec().components.iter();
        machine.unprovided = machine.open
            && !components.any(|other| number.is_some_and(|own| other.provides.contains(&own)));
        for (kind, name, codels) in names.owners() {
            if kind == body && owner.as_ref() == Some(name) {
                for codel in codels {
                    machine.codel(codel, names.is_around(codel.node));
                }
                let known = fsm::Machine::new(codels);
                let here = |text: &str| machine.here.iter().any(|here| here == text);
                let states = machine.states.iter().chain(&machine.here);
                let closing = states.filter(|state| known.reaches_without_pause(state, here));
                machine.closing = closing.cloned().collect();
            }
        }
        machine
    }

    /// Records a codel; `here` is true for the codel at the cursor.
    fn codel(&mut self, codel: &Codel, here: bool) {
        let triggers = codel.triggers.iter().map(|trigger| trigger.name.clone());
        let yields = codel.yields.iter().map(|state| state.name.clone());
        let mut mention = |text: SmolStr| {
            if !self.states.contains(&text) {
                self.states.push(text);
            }
        };
        // States that only the codel at the cursor mentions are still being written.
        if !here {
            triggers.clone().for_each(&mut mention);
            yields.clone().for_each(&mut mention);
            self.implemented.extend(triggers);
        }
        self.targets.extend(yields);
    }

    /// The states allowed at the cursor, after `yield` or after `<`.
    fn allowed(&self, context: &Context, yields: bool) -> Vec<&str> {
        let wanted: Vec<&SmolStr> = self.missing().collect();
        let mut known: Vec<&str> = Vec::new();
        if yields {
            known.extend(self.states.iter().map(SmolStr::as_str));
            known.extend(self.here.iter().map(SmolStr::as_str));
            // If a component provides the interface, a state without a codel there is an error.
            if self.unprovided {
                known.extend(["start", "stop"]);
            }
        } else {
            known.extend(wanted.iter().map(|text| text.as_str()));
            known.extend(["start", "stop"]);
            // `stop` must lead to the end.
            let yields =
                context.after.rest.iter().position(|word| word.is_any(&["yield", "yields"]));
            let ends = yields
                .is_none_or(|at| context.after.rest[at..].iter().any(|word| word.is("ether")));
            known.retain(|text| *text != "stop" || ends);
            known.retain(|text| self.open || !self.implemented.iter().any(|other| other == text));
        }
        known
    }

    /// States that need a codel and have none.
    fn missing(&self) -> impl Iterator<Item = &SmolStr> {
        static START: SmolStr = SmolStr::new_static("start");
        let start = self.activity.then_some(&START);
        let mut seen = FxHashSet::default();
        start
            .into_iter()
            .chain(&self.targets)
            .filter(|start| *start != "ether" && !self.implemented.contains(start))
            .filter(move |start| seen.insert(start.as_str()))
    }
}

/// The states of the codel that is being written: between `<` and `>`.
fn written_triggers(words: &[Word]) -> Vec<SmolStr> {
    let open = words.iter().position(|word| word.is("<"));
    let close = words.iter().position(|word| word.is(">"));
    let (Some(open), Some(close)) = (open, close) else {
        return Vec::new();
    };
    let between = words.get(open + 1..close).unwrap_or_default();
    between.iter().filter(|word| !word.is(",")).map(|word| word.text.clone()).collect()
}

/// Returns true if a component has asynchronous codels.
pub(super) fn has_async(component: &Component) -> bool {
    component.all_codels().any(|codel| component.codel(codel).is_async)
}

impl VisibleNames<'_, '_> {
    /// The definition of a state of the component around the cursor.
    fn state(&self, name: &str) -> Option<DefId> {
        let mut all = self.elaborated.definitions.iter();
        let component = &self.component()?.name;
        let found = all.find(|definition| {
            definition.kind == DefKind::State
                && definition.name == name
                && definition.container.is_some_and(|container| {
                    self.elaborated.definition(container).name == *component
                })
        })?;
        Some(found.id)
    }
}

/// After the parameters of a codel without states.
pub(super) fn after_simple_codel(
    names: &VisibleNames<'_, '_>,
    context: &Context,
    rest: &[Word],
    out: &mut Completions,
) {
    let timed = own_words(context).any(|word| word.is("wcet"));
    if let Some(wcet) = rest.iter().rposition(|word| word.is("wcet")) {
        quantity(names, &rest[wcet + 1..], &["s", "ms", "us"], out);
    } else if rest.last().is_some_and(|word| word.is(")")) && !timed {
        out.wcet(context);
    }
}
