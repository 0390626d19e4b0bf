//! Codels: parameters, states and execution times (language reference, sections 12, 13 and 17.4).

use crate::finding::role::Role;
use dotgen_syntax::SyntaxKind;
use num_rational::Ratio;

use super::{
    AccessKind, DefId, DefKind,
    context::Elaborator,
    property::glued_microseconds,
    state::{CodelSource, KnownCodel},
    types,
    value::Const,
};
use crate::{
    finding::{Finding, codels::CodelProblem, values::ValueProblem},
    item_tree::{CodelDecl, Duration, Name, StateRef},
    model::{
        Codel, CodelKind, ComponentId, Name as Text, Owner, Param, ParamDir, ParamSource, Quantity,
        Seconds, Src, State, TypeId, TypeKind,
    },
};

/// The place of an execution time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TimePlace {
    /// In the `wcet` of a codel.
    Clause,
    /// In a `#pragma wcet`.
    Pragma,
}

impl<'a> Elaborator<'a> {
    /// The definition of a codel.
    pub(super) fn codel_def(&self, name: &Text) -> Option<DefId> {
        self.codels.get(name).map(|codel| codel.def)
    }

    /// Adds a codel written in the current body.
    pub(super) fn codel_here(
        &mut self,
        c: ComponentId,
        owner: Owner,
        decl: &'a CodelDecl,
        kind: CodelKind,
    ) {
        let source = CodelSource { decl, visit: self.visit, scope: self.scope, kind };
        self.add_codel(c, owner, source);
    }

    /// Adds a codel to a task or service, resolved for that component.
    pub(super) fn add_codel(&mut self, c: ComponentId, owner: Owner, source: CodelSource<'a>) {
        let container = self.container;
        self.in_visit(source.visit, |this| {
            this.within(source.scope, container, |this| {
                this.resolve_codel(c, owner, source);
            });
        });
    }

    fn resolve_codel(&mut self, c: ComponentId, owner: Owner, source: CodelSource<'a>) {
        let decl = source.decl;
        let Some(name) = &decl.name else { return };
        let (at, node) = (self.src(name.ptr), self.src(decl.ptr));
        let known =
            self.spec.components[c].codels_of(owner).iter().find(|codel| codel.name == name.text);
        if let Some(first) = known {
            let diagnostic = Finding::new(CodelProblem::CodelTwice { name: name.text.clone() }, at)
                .related(first.src, Role::FirstUsed);
            self.report(diagnostic);
            return;
        }
        let (params, complete) = self.codel_params(c, owner, decl, source.kind);
        if source.kind != CodelKind::Fsm {
            let stateful = params.iter().find(|param| {
                matches!(param.source, ParamSource::Port(_) | ParamSource::Remote(_))
            });
            if let Some(param) = stateful {
                let what = match param.source {
                    ParamSource::Port(_) => "port",
                    _ => "remote service",
                };

                let diagnostic = Finding::new(
                    CodelProblem::NoAccess {
                        codel: name.text.clone(),
                        what,
                        name: param.name.clone(),
                    },
                    at,
                )
                .related(param.src, Role::ThisParameter);
                self.report(diagnostic);
            }
        }
        self.register_codel(name, decl, &params, complete);
        let triggers = match &decl.triggers {
            Some(states) => self.states(c, states, Some(name)),
            None => Vec::new(),
        };
        let yields = match &decl.yields {
            Some(states) => self.states(c, states, None),
            None => Vec::new(),
        };
        self.check_attached(c, owner, at, &triggers);
        let wcet = self.wcet(decl);
        let codel = Codel {
            name: name.text.clone(),
            src: at,
            node,
            kind: source.kind,
            is_async: decl.is_async,
            params,
            triggers,
            yields,
            wcet,
        };
        let component = &mut self.spec.components[c];
        let state = &mut self.components[c];
        match owner {
            Owner::Task(i) => {
                component.tasks[i].codels.push(codel);
                state.tasks[i].codels.push(source);
            }
            Owner::Service(i) => {
                component.services[i].codels.push(codel);
                state.services[i].codels.push(source);
            }
        }
    }

    /// Checks the parameters of a codel at a place that does not allow it, and records their references.
    pub(super) fn misplaced_params(
        &mut self,
        c: ComponentId,
        owner: Owner,
        decl: &'a CodelDecl,
        kind: CodelKind,
    ) {
        self.codel_params(c, owner, decl, kind);
    }

    /// The parameters, and true if all could be resolved.
    fn codel_params(
        &mut self,
        c: ComponentId,
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
            let Some(param) = self.codel_param(c, service, decl, kind) else {
                complete = false;
                params.extend(self.opaque_param(c, service, decl));
                continue;
            };
            let known =
                |other: &&Param| other.name == param.name && other.source != ParamSource::Opaque;
            if let Some(first) = params.iter().find(known) {
                let diagnostic =
                    Finding::new(CodelProblem::ParamTwice { name: param.name.clone() }, param.src)
                        .related(first.src, Role::First);
                self.report(diagnostic);
                complete = false;
                continue;
            }
            params.push(param);
        }
        (params, complete)
    }

    /// Records a use of a codel name, which must agree with the earlier ones.
    fn register_codel(&mut self, name: &Name, decl: &CodelDecl, params: &[Param], complete: bool) {
        let at = self.src(name.ptr);
        let signature: Option<Vec<_>> =
            complete.then(|| params.iter().map(|param| (param.dir, param.ty)).collect());
        let Some(known) = self.codels.get_mut(&name.text) else {
            let node = self.src(decl.ptr);
            let container = self.container.take();
            let def = self.define(DefKind::Codel, &name.text, at, node, None);
            self.container = container;
            self.codels.insert(name.text.clone(), KnownCodel { def, src: at, signature });
            return;
        };
        let (def, first) = (known.def, known.src);
        // An imported codel keeps its meaning at the point of import, and is not compared.
        if known.signature.is_none() || (self.importing.is_some() && complete) {
            known.signature.clone_from(&signature);
        }
        self.refer_as(at, def, AccessKind::Declaration);
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
            let diagnostic = Finding::new(
                CodelProblem::OtherSignature {
                    name: name.text.clone(),
                    there: self.signature_text(expected).into(),
                    here: self.signature_text(&signature).into(),
                },
                at,
            )
            .related(first, Role::OtherUse);
            self.report(diagnostic);
        }
    }

    fn signature_text(&self, signature: &[(ParamDir, TypeId)]) -> String {
        let params: Vec<String> = signature
            .iter()
            .map(|(dir, ty)| {
                let dir = dir.word();
                format!("{dir} {}", types::display(&self.spec, *ty))
            })
            .collect();
        params.join(", ")
    }

    // States

    /// Creates the states that imported codels mention, in the order of the reference compiler. Their types,
    /// and so generated code, have that order, and the place of their codel.
    pub(super) fn import_states(&mut self, c: ComponentId, codels: Vec<CodelSource<'a>>) {
        for codel in codels {
            let Some(name) = &codel.decl.name else {
                continue;
            };
            self.in_visit(codel.visit, |this| {
                let at = this.src(name.ptr);
                for state in codel.decl.yields.iter().flatten() {
                    let paused = state.paused && state.name.text != "ether";
                    this.event(c, &state.name, (paused, false), at);
                }
                for state in codel.decl.triggers.iter().flatten() {
                    this.event(c, &state.name, (false, true), at);
                }
            });
        }
    }

    /// The states of a `< >` list (with the codel's name) or of a `yields` list.
    fn states(&mut self, c: ComponentId, list: &[StateRef], codel: Option<&Name>) -> Vec<State> {
        let mut states: Vec<State> = Vec::with_capacity(list.len());
        for state in list {
            let at = self.src(state.ptr);
            let name = &state.name.text;
            if state.paused
                && let Some(codel) = codel
            {
                let codel = self.src(codel.ptr);
                let diagnostic =
                    Finding::new(CodelProblem::PausedTrigger { state: name.clone() }, codel)
                        .related(at, Role::ThisState);
                self.report(diagnostic);
            } else if state.paused && name == "ether" {
                self.error(at, CodelProblem::PausedEther);
            }
            let paused = state.paused && codel.is_none() && name != "ether";
            if let Some(first) =
                states.iter().find(|state| state.name == *name && state.paused == paused)
            {
                let pause = if paused { "pause::" } else { "" };

                let diagnostic = Finding::new(
                    CodelProblem::StateTwice { state: format!("{pause}{name}").into() },
                    at,
                )
                .related(first.src, Role::FirstHere);
                self.report(diagnostic);
                continue;
            }
            let created = self.src(state.name.ptr);
            let event = self.event(c, &state.name, (paused, codel.is_some()), created);
            states.push(State { name: name.clone(), paused, event, src: at });
        }
        states
    }

    /// The type object of a state, created at its first mention, with the place `created`.
    fn event(
        &mut self,
        c: ComponentId,
        name: &Name,
        (paused, is_trigger): (bool, bool),
        created: Src,
    ) -> TypeId {
        let at = self.src(name.ptr);
        let state = &self.components[c];
        let (scope, kind, other) = if paused {
            (state.pause, TypeKind::PauseEvent, state.scope)
        } else {
            (state.scope, TypeKind::Event, state.pause)
        };
        let event = match self.scopes.get(scope).names.get(&name.text) {
            Some(&event) if self.spec.ty(event).kind == kind => event,
            _ => {
                let event = self.named(kind, scope, name.text.clone(), created);
                // `yield pause`, without a state: an error of the state machine.
                if name.text != "pause" || paused || is_trigger {
                    self.declare_at(scope, &name.text, at, event);
                }
                event
            }
        };
        // A state and its paused form have one definition.
        let other = self.scopes.get(other).names.get(&name.text);
        let def = self.type_defs[event].or_else(|| self.type_defs[*other?]);
        match def {
            Some(def) if self.definitions[def].kind == DefKind::State => {
                self.type_defs[event] = Some(def);
                if self.definitions[def].src != at {
                    self.refer(at, def);
                }
            }
            Some(_) => {}
            None if self.importing.is_none() => {
                let container = self.container.replace(self.components[c].def);
                self.define(DefKind::State, &name.text, at, at, Some(event));
                self.container = container;
            }
            None => {}
        }
        event
    }

    /// Each state of a machine has at most one codel.
    fn check_attached(&mut self, c: ComponentId, owner: Owner, at: Src, triggers: &[State]) {
        let mut clashes: Vec<(Text, Text, Src)> = Vec::new();
        let component = &self.spec.components[c];
        for state in triggers {
            let first = component
                .codels_of(owner)
                .iter()
                .find(|codel| codel.triggers.iter().any(|trigger| trigger.name == state.name));
            if let Some(first) = first {
                clashes.push((state.name.clone(), first.name.clone(), first.src));
            }
        }
        for (state, codel, place) in clashes {
            let diagnostic = Finding::new(CodelProblem::StateTaken { state, codel }, at)
                .related(place, Role::OtherCodel);
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
                self.report(Finding::new(ValueProblem::WcetTwice, at).related(first, Role::First));
                continue;
            }
            first = Some(at);
            let Some(duration) = &clause.duration else {
                self.error(at, ValueProblem::WcetEmpty);
                continue;
            };
            if clause.bare {
                self.report(Finding::new(ValueProblem::WcetBare, at));
            }
            if let Some((number, unit)) = self.execution_time(duration, TimePlace::Clause, at) {
                result = Some(self.seconds(number, unit, at));
            }
        }
        result
    }

    /// The number and unit of an execution time.
    pub(super) fn execution_time(
        &mut self,
        duration: &'a Duration,
        place: TimePlace,
        at: Src,
    ) -> Option<(Seconds, Option<SyntaxKind>)> {
        let value = self.eval(&duration.value);
        if value == Const::Unknown {
            return None;
        }
        let Some(number) = value.exact() else {
            self.error(
                at,
                match place {
                    TimePlace::Clause => ValueProblem::WcetNoNumber { value: value.describe() },
                    TimePlace::Pragma => ValueProblem::PragmaNoNumber { value: value.describe() },
                },
            );
            return None;
        };
        if number < Ratio::from_integer(0) {
            self.error(
                at,
                match place {
                    TimePlace::Clause => ValueProblem::WcetNegative,
                    TimePlace::Pragma => ValueProblem::PragmaNegative,
                },
            );
            return None;
        }
        let unit = if glued_microseconds(duration) {
            Some(SyntaxKind::US_KW)
        } else {
            duration.unit.map(|(unit, _)| unit)
        };
        Some((number, unit))
    }
}
