//! Codels: parameters, states and execution times (language reference, sections 12, 13 and 17.4).

use num_rational::Ratio;

use super::{
    Access, DefId, DefKind, ElabDiagnostic, constant::Const, context::Elaborator,
    property::glued_microseconds, scope::ScopeId, types,
};
use crate::{
    item_tree::{CodelDecl, Duration, Name, StateRef, Unit},
    model::{
        Codel, CodelKind, Name as Text, Owner, Param, ParamDir, ParamSource, Quantity, Seconds,
        Src, State, TypeId, TypeKind,
    },
};

/// A codel as written, kept so that an importing component can resolve it again.
#[derive(Debug, Clone, Copy)]
pub(super) struct CodelSource<'a> {
    pub(super) decl: &'a CodelDecl,
    pub(super) visit: u32,
    /// Scope of the constants in its paths.
    pub(super) scope: ScopeId,
    pub(super) kind: CodelKind,
}

/// The first use of a codel name, which all others must agree with.
#[derive(Debug)]
pub(super) struct KnownCodel {
    def: DefId,
    src: Src,
    /// `None` when a parameter could not be resolved.
    signature: Option<Vec<(ParamDir, TypeId)>>,
}

impl<'a> Elaborator<'a> {
    /// The definition of a codel.
    pub(super) fn codel_def(&self, name: &Text) -> Option<DefId> {
        self.codels.get(name).map(|it| it.def)
    }

    /// A codel written in the current body.
    pub(super) fn codel_here(
        &mut self,
        index: u32,
        owner: Owner,
        decl: &'a CodelDecl,
        kind: CodelKind,
    ) {
        let source = CodelSource {
            decl,
            visit: self.visit,
            scope: self.scope,
            kind,
        };
        self.add_codel(index, owner, source);
    }

    /// Adds a codel to a task or service, resolved for that component.
    pub(super) fn add_codel(&mut self, index: u32, owner: Owner, source: CodelSource<'a>) {
        let container = self.container;
        self.in_visit(source.visit, |this| {
            this.within(source.scope, container, |this| {
                this.resolve_codel(index, owner, source);
            });
        });
    }

    fn resolve_codel(&mut self, index: u32, owner: Owner, source: CodelSource<'a>) {
        let decl = source.decl;
        let Some(name) = &decl.name else { return };
        let at = self.src(name.ptr);
        let known = self.spec.components[index as usize]
            .codels_of(owner)
            .iter()
            .find(|it| it.name == name.text);
        if let Some(first) = known {
            let message = format!(
                "codel `{}` is already used here; within one task or service a codel can be used \
                 once",
                name.text
            );
            let diagnostic = ElabDiagnostic::new("prop-duplicate", at, message)
                .related(first.src, "first used here");
            self.report(diagnostic);
            return;
        }
        let (params, complete) = self.codel_params(index, owner, decl, source.kind);
        if source.kind != CodelKind::Fsm {
            let stateful = params
                .iter()
                .find(|it| matches!(it.source, ParamSource::Port(_) | ParamSource::Remote(_)));
            if let Some(param) = stateful {
                let what = match param.source {
                    ParamSource::Port(_) => "port",
                    _ => "remote service",
                };
                let message = format!(
                    "codel `{}` cannot use {what} `{}`: codels without states have access to the \
                     ids and to the parameters of their service only",
                    name.text, param.name
                );
                let diagnostic = ElabDiagnostic::new("codel-param-source", at, message)
                    .related(param.src, "this parameter");
                self.report(diagnostic);
            }
        }
        self.register_codel(name, decl, &params, complete);
        let triggers = match &decl.triggers {
            Some(states) => self.states(index, states, Some(name)),
            None => Vec::new(),
        };
        let yields = match &decl.yields {
            Some(states) => self.states(index, states, None),
            None => Vec::new(),
        };
        self.check_attached(index, owner, at, &triggers);
        let wcet = self.wcet(decl);
        let codel = Codel {
            name: name.text.clone(),
            src: at,
            kind: source.kind,
            is_async: decl.is_async,
            params,
            triggers,
            yields,
            wcet,
        };
        let component = &mut self.spec.components[index as usize];
        let state = &mut self.components[index as usize];
        match owner {
            Owner::Task(i) => {
                component.tasks[i as usize].codels.push(codel);
                state.tasks[i as usize].codels.push(source);
            }
            Owner::Service(i) => {
                component.services[i as usize].codels.push(codel);
                state.services[i as usize].codels.push(source);
            }
        }
    }

    /// Checks the parameters of a codel that cannot be where it is, and notes what they refer to.
    pub(super) fn misplaced_params(
        &mut self,
        index: u32,
        owner: Owner,
        decl: &'a CodelDecl,
        kind: CodelKind,
    ) {
        self.codel_params(index, owner, decl, kind);
    }

    /// The parameters, and whether all could be resolved.
    fn codel_params(
        &mut self,
        index: u32,
        owner: Owner,
        decl: &'a CodelDecl,
        kind: CodelKind,
    ) -> (Vec<Param>, bool) {
        let service = match owner {
            Owner::Service(service) => Some(service),
            Owner::Task(_) => None,
        };
        let mut params: Vec<Param> = Vec::with_capacity(decl.params.len());
        let mut complete = true;
        for decl in &decl.params {
            let Some(param) = self.codel_param(index, service, decl, kind) else {
                complete = false;
                continue;
            };
            if let Some(first) = params.iter().find(|it| it.name == param.name) {
                let message = format!(
                    "two parameters of this codel are called `{}`; rename one of them with `::`",
                    param.name
                );
                let diagnostic = ElabDiagnostic::new("param-duplicate", param.src, message)
                    .related(first.src, "the first one");
                self.report(diagnostic);
                complete = false;
                continue;
            }
            params.push(param);
        }
        (params, complete)
    }

    /// Notes a use of a codel name, which must agree with the earlier ones.
    fn register_codel(&mut self, name: &Name, decl: &CodelDecl, params: &[Param], complete: bool) {
        let at = self.src(name.ptr);
        let signature: Option<Vec<_>> =
            complete.then(|| params.iter().map(|it| (it.dir, it.ty)).collect());
        let Some(known) = self.codels.get_mut(&name.text) else {
            let node = self.src(decl.ptr);
            let container = self.container.take();
            let def = self.define(DefKind::Codel, &name.text, at, node, None);
            self.container = container;
            self.codels.insert(
                name.text.clone(),
                KnownCodel {
                    def,
                    src: at,
                    signature,
                },
            );
            return;
        };
        let (def, first) = (known.def, known.src);
        // A codel that is imported means what it means there from then on, and is not compared.
        if known.signature.is_none() || (self.importing.is_some() && complete) {
            known.signature = signature.clone();
        }
        self.refer_as(at, def, Access::None, true);
        let Some(known) = self.codels.get(&name.text) else {
            return;
        };
        let (Some(expected), Some(signature)) = (&known.signature, signature) else {
            return;
        };
        let same = expected.len() == signature.len()
            && expected
                .iter()
                .zip(&signature)
                .all(|((d, t), (e, u))| d == e && types::equal(&self.spec, *t, *u));
        if !same {
            let message = format!(
                "codel `{}` is used elsewhere as ({}), here as ({}); it is one function, so all \
                 uses need the same directions and types in the same order",
                name.text,
                self.signature_text(expected),
                self.signature_text(&signature)
            );
            let diagnostic =
                ElabDiagnostic::new("codel-conflict", at, message).related(first, "the other use");
            self.report(diagnostic);
        }
    }

    fn signature_text(&self, signature: &[(ParamDir, TypeId)]) -> String {
        let params: Vec<String> = signature
            .iter()
            .map(|(dir, ty)| {
                let dir = super::param::dir_text(*dir);
                format!("{dir} {}", types::display(&self.spec, *ty))
            })
            .collect();
        params.join(", ")
    }

    // States

    /// Creates the states that imported codels mention, in the order in which the reference compiler
    /// does. Their types, and so generated code, have that order, and the place of their codel.
    pub(super) fn import_states(&mut self, index: u32, codels: Vec<CodelSource<'a>>) {
        for codel in codels {
            let Some(name) = &codel.decl.name else {
                continue;
            };
            self.in_visit(codel.visit, |this| {
                let at = this.src(name.ptr);
                for state in codel.decl.yields.iter().flatten() {
                    let paused = state.paused && state.name.text != "ether";
                    this.event(index, &state.name, paused, at);
                }
                for state in codel.decl.triggers.iter().flatten() {
                    this.event(index, &state.name, false, at);
                }
            });
        }
    }

    /// The states of a `< >` list (with the codel's name) or of a `yields` list.
    fn states(&mut self, index: u32, list: &[StateRef], codel: Option<&Name>) -> Vec<State> {
        let mut states: Vec<State> = Vec::with_capacity(list.len());
        for state in list {
            let at = self.src(state.ptr);
            let name = &state.name.text;
            if state.paused
                && let Some(codel) = codel
            {
                let message = format!(
                    "a codel cannot implement the paused state `pause::{name}`; write `<{name}>`"
                );
                let codel = self.src(codel.ptr);
                let diagnostic = ElabDiagnostic::new("fsm/paused-trigger", codel, message)
                    .related(at, "this state");
                self.report(diagnostic);
            } else if state.paused && name == "ether" {
                self.error(
                    "fsm/paused-ether",
                    at,
                    "`ether` ends the state machine, so it cannot be paused; write `ether`",
                );
            }
            let paused = state.paused && codel.is_none() && name != "ether";
            if let Some(first) = states
                .iter()
                .find(|it| it.name == *name && it.paused == paused)
            {
                let pause = if paused { "pause::" } else { "" };
                let message = format!("`{pause}{name}` is already in this list; remove it");
                let diagnostic = ElabDiagnostic::new("fsm/duplicate-yield", at, message)
                    .related(first.src, "first here");
                self.report(diagnostic);
                continue;
            }
            let event = self.event(index, &state.name, paused, self.src(state.name.ptr));
            states.push(State {
                name: name.clone(),
                paused,
                event,
                src: at,
            });
        }
        states
    }

    /// The type object of a state, created when it is mentioned for the first time, with the place
    /// `created`.
    fn event(&mut self, index: u32, name: &Name, paused: bool, created: Src) -> TypeId {
        let at = self.src(name.ptr);
        let state = &self.components[index as usize];
        let (scope, kind, other) = if paused {
            (state.pause, TypeKind::PauseEvent, state.scope)
        } else {
            (state.scope, TypeKind::Event, state.pause)
        };
        let event = match self.scopes.get(scope).names.get(&name.text) {
            Some(&event) if self.spec.ty(event).kind == kind => event,
            _ => {
                let event = self.named(kind, scope, name.text.clone(), created);
                self.declare_at(scope, &name.text, at, event);
                event
            }
        };
        // A state and its paused form are the same thing for whoever looks for it.
        let other = self.scopes.get(other).names.get(&name.text);
        let def = self.type_defs[event.0 as usize].or_else(|| self.type_defs[other?.0 as usize]);
        match def {
            Some(def) if self.definitions[def.0 as usize].kind == DefKind::State => {
                self.type_defs[event.0 as usize] = Some(def);
                if self.definitions[def.0 as usize].src != at {
                    self.refer(at, def);
                }
            }
            Some(_) => {}
            None if self.importing.is_none() => {
                let container = self.container.replace(self.components[index as usize].def);
                self.define(DefKind::State, &name.text, at, at, Some(event));
                self.container = container;
            }
            None => {}
        }
        event
    }

    /// Each state of a machine has at most one codel.
    fn check_attached(&mut self, index: u32, owner: Owner, at: Src, triggers: &[State]) {
        let mut clashes: Vec<(Text, Text, Src)> = Vec::new();
        let component = &self.spec.components[index as usize];
        for state in triggers {
            let first = component
                .codels_of(owner)
                .iter()
                .find(|it| it.triggers.iter().any(|it| it.name == state.name));
            if let Some(first) = first {
                clashes.push((state.name.clone(), first.name.clone(), first.src));
            }
        }
        for (state, codel, place) in clashes {
            let message = format!(
                "state `{state}` is already implemented by codel `{codel}`; a state has one codel"
            );
            let diagnostic = ElabDiagnostic::new("fsm/duplicate-state", at, message)
                .related(place, "the other codel");
            self.report(diagnostic);
        }
    }

    // Execution times

    fn wcet(&mut self, decl: &'a CodelDecl) -> Option<Quantity> {
        let mut result: Option<Quantity> = None;
        let mut first = None;
        for clause in &decl.wcet {
            let at = self.src(clause.ptr);
            if let Some(first) = first {
                self.report(
                    ElabDiagnostic::new(
                        "wcet-value",
                        at,
                        "a codel has one worst-case execution time; remove one of them",
                    )
                    .related(first, "the first one"),
                );
                continue;
            }
            first = Some(at);
            let Some(duration) = &clause.duration else {
                self.error(
                    "wcet-value",
                    at,
                    "`wcet` needs a duration, for instance `wcet 2 ms`",
                );
                continue;
            };
            if clause.bare {
                self.report(
                    ElabDiagnostic::new(
                        "wcet-bare",
                        at,
                        "a duration after the states is taken for the worst-case execution time; \
                         write `wcet` before it",
                    )
                    .fix(super::Fix::InsertBefore {
                        at,
                        text: "wcet ".into(),
                        title: "Write `wcet` before the duration".to_owned(),
                    }),
                );
            }
            if let Some((number, unit)) = self.execution_time(duration, "wcet-value", at) {
                result = Some(self.seconds(number, unit, at));
            }
        }
        result
    }

    /// The number and unit of an execution time.
    pub(super) fn execution_time(
        &mut self,
        duration: &'a Duration,
        code: &'static str,
        at: Src,
    ) -> Option<(Seconds, Option<Unit>)> {
        let value = self.eval(&duration.value);
        if value == Const::Unknown {
            return None;
        }
        let Some(number) = value.exact() else {
            let message = format!(
                "an execution time is a number with a unit, but this is {}",
                value.describe()
            );
            self.error(code, at, message);
            return None;
        };
        if number < Ratio::from_integer(0) {
            self.error(code, at, "an execution time cannot be negative");
            return None;
        }
        let unit = if glued_microseconds(duration) {
            Some(Unit::Us)
        } else {
            duration.unit.map(|(unit, _)| unit)
        };
        Some((number, unit))
    }
}
