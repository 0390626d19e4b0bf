//! Comparison of returned events and raised exceptions with those that the specification allows.

use dotgen_analysis::model::fsm::Machine;
use dotgen_analysis::model::{CodelKind, CodelRef, TypeId, TypeKind};
use dotgen_syntax::suggestion::nearest;
use rustc_hash::FxHashSet;
use smol_str::SmolStr;

use super::finding::{Difference, States};
use super::{Check, Drift, FunctionIn, NameReplacement, Repair};
use crate::codels::{
    expected::{Expected, cut_tag, state_text},
    source::{Body, Call, Span, Value},
};
use crate::lang::Language;

/// Maximum depth of helpers through which a returned value is followed.
const MAX_HELPER_DEPTH: usize = 4;

/// Maximum number of declared events or exceptions that are offered in place of an undeclared one.
const MAX_SUGGESTIONS: usize = 3;

/// The events that the definitions of one codel return, as far as they are known.
#[derive(Default)]
struct Returns {
    returned: FxHashSet<SmolStr>,
    mentioned: FxHashSet<SmolStr>,
    unknown: bool,
    any: bool,
    /// Exceptions that helpers raise for the codel.
    raised: FxHashSet<(SmolStr, TypeId)>,
}

pub(super) fn check(check: &Check<'_>, definitions: &[FunctionIn<'_>], out: &mut Vec<Drift>) {
    let mut outcome = Returns::default();
    for found in definitions {
        let Some(body) = &found.function.body else {
            continue;
        };
        let flow = Flow { check, found: *found, body };
        flow.returns(&mut outcome, out);
        flow.raises(out);
    }
    if !outcome.unknown && outcome.any {
        never_yielded(check, definitions, &outcome, out);
    }
}

struct Flow<'a> {
    check: &'a Check<'a>,
    found: FunctionIn<'a>,
    body: &'a Body,
}

impl Flow<'_> {
    fn expected(&self) -> &Expected<'_> {
        self.check.expected
    }

    fn returns(&self, outcome: &mut Returns, out: &mut Vec<Drift>) {
        let mut reported: FxHashSet<SmolStr> = FxHashSet::default();
        for value in self.body.returns.iter().flat_map(|result| &result.values) {
            outcome.any = true;
            match value {
                Value::Unknown => outcome.unknown = true,
                Value::Call { call, variable } => {
                    let call = &self.body.calls[*call];
                    if self.exception(&call.name).is_none() {
                        self.through_helper(call, *variable, outcome, &mut reported, out);
                    }
                }
                Value::Name { name, span, variable } => {
                    let Some(event) = self.event(name) else {
                        outcome.unknown = true;
                        continue;
                    };
                    outcome.returned.insert(event.clone());
                    if self.check.function.returns.contains(&event)
                        // A variable is often initialized with this value.
                        || event == self.expected().ok() && *variable
                    {
                        continue;
                    }
                    if reported.insert(event.clone()) {
                        out.push(self.undeclared_yield(&event, span));
                    }
                }
            }
        }
        outcome.unknown |= self.body.broken || self.body.sample || self.hides_returns();
        outcome.mentioned.extend(self.body.mentions.iter().cloned());
    }

    /// Values that a helper returns count at the call of the helper.
    fn through_helper(
        &self,
        call: &Call,
        variable: bool,
        outcome: &mut Returns,
        reported: &mut FxHashSet<SmolStr>,
        out: &mut Vec<Drift>,
    ) {
        let mut inner = Returns::default();
        self.helper(&call.name, MAX_HELPER_DEPTH, &mut inner);
        let mut events: Vec<&SmolStr> = inner.returned.iter().collect();
        events.sort();
        for event in events {
            let allowed = self.check.function.returns.contains(event)
                // A variable is mostly returned only if it has another value.
                || event == self.expected().ok() && variable;
            if !allowed && reported.insert(event.clone()) {
                out.push(self.undeclared_yield(event, &call.span));
            }
        }
        let mut raised: Vec<&(SmolStr, TypeId)> = inner.raised.iter().collect();
        raised.sort();
        for (name, exception) in raised {
            let allowed =
                self.may_throw(*exception) || self.check.function.throws.contains(exception);
            if !allowed && reported.insert(name.clone()) {
                out.push(self.undeclared_throw(name, &call.span, Some(*exception)));
            }
        }
        outcome.unknown |= inner.unknown;
        outcome.returned.extend(inner.returned);
        outcome.mentioned.extend(inner.mentioned);
    }

    /// Adds the return values of a function of the sources.
    fn helper(&self, name: &str, depth: usize, outcome: &mut Returns) {
        let all: Vec<&Body> = self
            .check
            .sources
            .all()
            .flat_map(|file| &file.index().functions)
            .filter(|function| function.name == name)
            .filter_map(|function| function.body.as_ref())
            .collect();
        let [body] = all.as_slice() else {
            outcome.unknown = true;
            return;
        };
        let helper = Flow { body, ..*self };
        outcome.unknown |= depth == 0 || body.broken || helper.hides_returns();
        outcome.mentioned.extend(body.mentions.iter().cloned());
        for value in body.returns.iter().flat_map(|result| &result.values) {
            match value {
                Value::Call { call, .. } if !outcome.unknown => {
                    let call = &body.calls[*call];
                    match self.exception(&call.name) {
                        Some(exception) => {
                            outcome.raised.insert((call.name.clone(), exception));
                        }
                        None => self.helper(&call.name, depth - 1, outcome),
                    }
                }
                Value::Name { name, .. } => match self.event(name) {
                    Some(event) => {
                        outcome.returned.insert(event);
                    }
                    None => outcome.unknown = true,
                },
                _ => outcome.unknown = true,
            }
        }
    }

    /// The event of a returned name; `None` if the name is not an event.
    fn event(&self, name: &SmolStr) -> Option<SmolStr> {
        let expected = self.expected();
        if name == expected.ok() || expected.events.contains_key(name) {
            return Some(name.clone());
        }
        if expected.language == Language::Cxx {
            // Scopes may be missing after `using namespace`.
            let mut all = expected.events.keys();
            let long = all.find(|key| {
                key.strip_suffix(name.as_str()).is_some_and(|stem| stem.ends_with("::"))
            });
            if long.is_some() {
                return long.cloned();
            }
        }
        let component = &expected.component().name;
        let prefix = format!("{component}{}", expected.separator());
        (name.starts_with(&prefix) && !self.is_declared(name)).then(|| name.clone())
    }

    /// True if the sources declare the name, so that it is not a name of the specification.
    fn is_declared(&self, name: &str) -> bool {
        let short = name.rsplit("::").next().unwrap_or(name);
        self.check.sources.all().any(|file| {
            file.index().names.contains(short)
                || file.index().macros.iter().any(|known| known.name == short)
        })
    }

    /// True if the function uses a macro as a statement, which may contain a `return`.
    fn hides_returns(&self) -> bool {
        self.body.calls.iter().filter(|call| call.statement).any(|call| {
            let name = &call.name;
            let macros = self.check.sources.all().flat_map(|file| &file.index().macros);
            let mut known = macros.filter(|defined| defined.name == *name).peekable();
            if known.peek().is_some() {
                return known.any(|definition| definition.returns);
            }
            let loud = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_';
            name.chars().all(loud)
        })
    }

    fn undeclared_yield(&self, event: &str, span: &Span) -> Drift {
        let expected = self.expected();
        let name = &self.check.function.name;
        let component = expected.component();
        let fsm = |codel: &&CodelRef| component.codel(**codel).kind == CodelKind::Fsm;
        let machine = self.check.function.uses.iter().find(fsm);
        let (function, event_name) = (name.clone(), event.into());
        let kind = match machine {
            _ if event == expected.ok() => {
                let first = self.check.function.uses.first();
                Difference::ReturnsOk {
                    function,
                    event: event_name,
                    yields: States(first.map(|&of| yields(expected, of)).unwrap_or_default()),
                }
            }
            None => {
                Difference::HasNoStates { function, event: event_name, ok: expected.ok().into() }
            }
            Some(&at) => Difference::NotYielded {
                function,
                event: event_name,
                yields: States(yields(expected, at)),
            },
        };
        let mut drift = self.check.drift(kind);
        drift.source = Some(self.found.at(span.clone()));
        drift.found = Some(event.to_owned());
        for &at in &self.check.function.uses {
            if let Some(state) = self.reachable_state(at, event) {
                drift.repairs.extend(self.paused_yield(at, &state, event));
                drift.repairs.push(Repair::AddYield { at, state });
            }
        }
        let declared = self.returnable(event).into_iter();
        let declared = declared.filter_map(|text| self.returning(event, &text));
        for way in declared.map(Repair::ReturnDeclared) {
            if !drift.repairs.contains(&way) {
                drift.repairs.push(way);
            }
        }
        drift
    }

    /// The repair that adds a pause before a state, with its yield if that is missing. `None` unless the
    /// state machine would otherwise be in a cycle without a pause.
    fn paused_yield(&self, at: CodelRef, state: &str, event: &str) -> Option<Repair> {
        let component = self.expected().component();
        let machine = Machine::new(component.codels_of(at.owner));
        let own = &component.codel(at).triggers;
        let is_own = |name: &str| own.iter().any(|own| own.name == name);
        if state.starts_with("pause::") || !machine.reaches_without_pause(state, is_own) {
            return None;
        }
        let paused = self.expected().paused(event)?;
        let returns = self.returning(event, &paused)?;
        let mut yields = component.codel(at).yields.iter();
        Some(if yields.any(|other| other.paused && other.name == state) {
            Repair::ReturnDeclared(returns)
        } else {
            Repair::AddPausedYield { at, state: state.to_owned(), returns }
        })
    }

    /// Events that the function may return in place of one, the most similar name first. If there are any
    /// that it does not return yet, only those.
    fn returnable(&self, event: &str) -> Vec<SmolStr> {
        let expected = self.expected();
        let component = expected.component();
        let mut all: Vec<SmolStr> = Vec::new();
        for &at in &self.check.function.uses {
            let codel = component.codel(at);
            let yields = codel.yields.iter().map(|state| expected.spelling(state.event));
            match codel.kind {
                CodelKind::Fsm => all.extend(yields),
                _ => all.push(expected.ok().into()),
            }
        }
        let mut seen = FxHashSet::default();
        all.retain(|name| name != event && seen.insert(name.clone()));
        let unused = |event: &SmolStr| self.returned_places(event).next().is_none();
        if all.iter().any(unused) {
            all.retain(unused);
        }
        let near = nearest(event, all.iter().map(SmolStr::as_str)).map(SmolStr::from);
        all.sort_by_key(|text| Some(text) != near.as_ref());
        all.truncate(MAX_SUGGESTIONS);
        all
    }

    /// The places where the function returns an event by its name.
    fn returned_places<'s>(&'s self, event: &'s str) -> impl Iterator<Item = &'s Span> {
        let values = self.body.returns.iter().flat_map(|result| &result.values);
        values.filter_map(move |result| match result {
            Value::Name { name, span, .. } => {
                (self.event(name).as_deref() == Some(event)).then_some(span)
            }
            _ => None,
        })
    }

    /// The repair that returns another event where the function returns one by its name; `None` if a helper
    /// returns it.
    fn returning(&self, event: &str, to: &str) -> Option<NameReplacement> {
        self.respelled(self.returned_places(event), event, to)
    }

    /// Another name at some places of the function. Scopes that the present name omits are omitted there too.
    fn respelled<'s>(
        &self,
        places: impl Iterator<Item = &'s Span>,
        from: &str,
        to: &str,
    ) -> Option<NameReplacement> {
        let text = &self.found.file.text;
        let mut out: Vec<(Span, String)> = Vec::new();
        for span in places {
            let written = text.get(span.clone())?;
            let left_out = from.strip_suffix(written).unwrap_or_default();
            let short = to.strip_prefix(left_out).unwrap_or(to).to_owned();
            if out.iter().all(|entry| entry.0 != *span) {
                out.push((span.clone(), short));
            }
        }
        (!out.is_empty()).then(|| NameReplacement {
            function: self.check.function.name.clone(),
            path: self.found.file.path.clone(),
            places: out,
            to: to.to_owned(),
        })
    }

    /// The state of an event, if the state machine of the codel has it.
    fn reachable_state(&self, at: CodelRef, event: &str) -> Option<String> {
        let component = self.expected().component();
        if component.codel(at).kind != CodelKind::Fsm {
            return None;
        }
        let (paused, name) = cut_tag(event, &component.name);
        let codels = component.codels_of(at.owner);
        let here = name == "ether"
            || codels.iter().flat_map(|codel| &codel.triggers).any(|trigger| trigger.name == name);
        let pause = if paused { "pause::" } else { "" };
        here.then(|| format!("{pause}{name}"))
    }

    fn raises(&self, out: &mut Vec<Drift>) {
        let mut reported: FxHashSet<SmolStr> = FxHashSet::default();
        let throws =
            self.body.throws.iter().map(|exception| (&exception.name, &exception.span, None));
        let calls = self.body.calls.iter().map(|call| (&call.name, &call.span, Some(call)));
        let mut all: Vec<_> = throws.chain(calls).collect();
        all.sort_by_key(|exception| exception.1.start);
        for (name, span, call) in all {
            let exception = self.exception(name);
            let allowed = match exception {
                Some(exception) => {
                    self.check.function.throws.contains(&exception) || self.may_throw(exception)
                }
                None => !call.is_some_and(|call| self.is_undeclared_raise(call)),
            };
            if !allowed && reported.insert(name.clone()) {
                out.push(self.undeclared_throw(name, span, exception));
            }
        }
    }

    /// True if an exception may be in a list that is not completely known. An interface that is missing
    /// cannot contain an exception that the component declares itself.
    fn may_throw(&self, exception: TypeId) -> bool {
        let check = self.check;
        let trust = &check.options.trust;
        let broken = trust.lacks_text;
        let scope = check.expected.spec.ty(exception).scope.first();
        let own = scope.is_some_and(|scope| scope.name == check.expected.component().name);
        broken || check.function.may_throw_more && !(own && trust.lacks_files)
    }

    fn exception(&self, name: &SmolStr) -> Option<TypeId> {
        let expected = self.expected();
        if let Some(&exception) = expected.exceptions.get(name) {
            return Some(exception);
        }
        if expected.language != Language::Cxx {
            return None;
        }
        let mut all = expected.exceptions.iter();
        let long = all.find(|exception| {
            exception.0.strip_suffix(name.as_str()).is_some_and(|stem| stem.ends_with("::"))
        });
        long.map(|exception| *exception.1)
    }

    /// True for a call in the form of a raise, with a name of the component that is not declared.
    fn is_undeclared_raise(&self, call: &Call) -> bool {
        let expected = self.expected();
        let trust = &self.check.options.trust;
        if trust.lacks_text || trust.may_declare(&call.name) {
            return false;
        }
        let prefix = format!("{}_e_", expected.component().name);
        let context = self.found.function.parameters.last();
        let context = context.and_then(|context| context.name.as_ref());
        expected.language == Language::C
            && call.name.starts_with(&prefix)
            && matches!(call.arguments, 1 | 2)
            && context.is_some()
            && call.last.as_ref() == context
            && !self.is_declared(&call.name)
            && !self.check.sources.incomplete
    }

    fn undeclared_throw(&self, name: &str, span: &Span, exception: Option<TypeId>) -> Drift {
        let function = &self.check.function.name;
        let (function, name_of) = (function.clone(), name.into());
        let kind = match exception {
            Some(_) => {
                Difference::NotThrown { function, exception: name_of, owners: self.owners().into() }
            }
            None => Difference::NoException { function, exception: name_of },
        };
        let mut drift = self.check.drift(kind);
        drift.source = Some(self.found.at(span.clone()));
        drift.found = Some(name.to_owned());
        if let Some(exception) = exception {
            for at in &self.check.function.uses {
                let owner = at.owner;
                drift.repairs.push(Repair::AddThrow { owner, exception });
            }
        }
        let declared = self.raisable(name, exception).into_iter();
        let declared = declared.filter_map(|text| self.raising(name, &text));
        drift.repairs.extend(declared.map(Repair::RaiseDeclared));
        drift
    }

    /// Declared exceptions that can be raised with the same arguments: those without details, because the
    /// details of others have their own types.
    fn raisable(&self, name: &str, exception: Option<TypeId>) -> Vec<SmolStr> {
        let expected = self.expected();
        let is_plain = |ty: TypeId| match &expected.spec.ty(ty).kind {
            TypeKind::Exception { members } => members.is_empty(),
            _ => false,
        };
        let mut calls = self.body.calls.iter();
        let plain = match exception {
            Some(exception) => is_plain(exception),
            // In C, the only argument is the context.
            None => calls.any(|call| call.name == name && call.arguments == 1),
        };
        let throws = self.check.function.throws.iter().copied();
        let throws = throws.filter(|&ty| plain && is_plain(ty) && Some(ty) != exception);
        let mut all: Vec<SmolStr> = throws.map(|ty| expected.spelling(ty)).collect();
        all.sort();
        let near = nearest(name, all.iter().map(SmolStr::as_str)).map(SmolStr::from);
        all.sort_by_key(|spelling| Some(spelling) != near.as_ref());
        all.truncate(MAX_SUGGESTIONS);
        all
    }

    /// The repair that raises another exception where the function itself raises one.
    fn raising(&self, name: &str, to: &str) -> Option<NameReplacement> {
        let throws = self.body.throws.iter().map(|exception| (&exception.name, &exception.span));
        let calls = self.body.calls.iter().map(|call| (&call.name, &call.span));
        let places = throws.chain(calls).filter(|exception| exception.0 == name);
        let from = match self.exception(&name.into()) {
            Some(exception) => self.expected().spelling(exception),
            None => name.into(),
        };
        self.respelled(places.map(|place| place.1), &from, to)
    }

    fn owners(&self) -> String {
        let component = self.expected().component();
        let uses = self.check.function.uses.iter();
        let mut out: Vec<String> = uses
            .map(|usage| {
                let (kind, name) = crate::codels::expected::owner_words(component, usage.owner);
                format!("{kind} `{name}`")
            })
            .collect();
        out.dedup();
        out.join(" nor ")
    }
}

fn yields(expected: &Expected<'_>, at: CodelRef) -> Vec<String> {
    let codel = expected.component().codel(at);
    codel.yields.iter().map(state_text).collect()
}

fn never_yielded(
    check: &Check<'_>,
    definitions: &[FunctionIn<'_>],
    outcome: &Returns,
    out: &mut Vec<Drift>,
) {
    let component = check.expected.component();
    for &at in &check.function.uses {
        let codel = component.codel(at);
        for (index, state) in codel.yields.iter().enumerate() {
            let event = check.expected.spelling(state.event);
            let short = event.rsplit("::").next().unwrap_or(&event);
            if outcome.returned.contains(&event)
                || outcome.mentioned.contains(&event)
                || check.expected.language == Language::Cxx && outcome.mentioned.contains(short)
            {
                continue;
            }
            let mut drift = check.drift(Difference::NeverReturned {
                codel: codel.name.clone(),
                state: state_text(state).into(),
                event: event.as_str().into(),
            });
            drift.spec = vec![state.src];
            let found = definitions.first();
            drift.source =
                found.map(|definition| definition.at(definition.function.name_span.clone()));
            drift.expected = Some(event.to_string());
            if codel.yields.len() > 1 {
                drift.repairs.push(Repair::RemoveYield { at, index });
            }
            // An event that the code returns without permission may be a wrong spelling of this one.
            let mut others: Vec<&SmolStr> = outcome.returned.iter().collect();
            others.retain(|text| !check.function.returns.contains(*text));
            others.sort();
            for found in definitions {
                let Some(body) = &found.function.body else {
                    continue;
                };
                let found = *found;
                let flow = Flow { check, found, body };
                let ways = others.iter().filter_map(|name| flow.returning(name, &event));
                drift.repairs.extend(ways.map(Repair::ReturnDeclared));
            }
            out.push(drift);
        }
    }
}
