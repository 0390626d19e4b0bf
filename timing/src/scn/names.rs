//! The resolution of paths of a scenario.

use std::ops::Range;

use dotgen_analysis::model::{
    CodelId, CodelKind, Component, ComponentKind, Owner, PortId, ServiceId, ServiceKind, Spec,
    TaskId, TypeId, TypeKind,
};
use dotgen_syntax::suggestion::nearest;

use super::ast::{
    CheckKind, Client, Comparison, Item, Path, Pred, Scenario, Spanned, Step, StepKind, TriggerKind,
};
use crate::diagnostic::Diagnostic;

/// The components of a scenario.
#[derive(Debug, Clone)]
pub struct Names<'a> {
    /// Components, in order of the specifications, then of declaration.
    pub components: Vec<Member<'a>>,
}

/// A component and its specification.
#[derive(Debug, Clone, Copy)]
pub struct Member<'a> {
    /// Number of the specification.
    pub spec_index: usize,
    /// Specification.
    pub spec: &'a Spec,
    pub component: &'a Component,
}

/// The target of a name in a path. Components are numbered as in [`Names::components`].
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Target {
    Component(usize),
    /// A task: component, index.
    Task(usize, TaskId),
    /// A service: component, index.
    Service(usize, ServiceId),
    /// A port: component, index.
    Port(usize, PortId),
    /// A member of the data of a port: component, index of the port, names of the members that lead to it.
    Member(usize, PortId, Vec<String>),
    /// A codel state: component, owner, index of the codel, name of the state.
    State(usize, Owner, CodelId, String),
    /// A codel of the control task: component, service, index of the codel.
    Codel(usize, ServiceId, CodelId),
    /// A client of the scenario.
    Client(String),
    /// A step of a client: client, label or name of the service.
    Step(String, String),
    /// `waiting`, `exec`, … after a target that has such a status.
    Status(String),
}

/// A name and its target.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reference {
    /// Range of the name.
    pub range: Range<usize>,
    pub target: Target,
}

/// Words that may follow a task, service or codel state in a predicate.
pub const STATUSES: &[&str] =
    &["waiting", "running", "idle", "exec", "lock", "run", "stop", "void", "tick"];

impl<'a> Names<'a> {
    /// Collects the components (not the interfaces) of some specifications.
    pub fn new(specs: &[&'a Spec]) -> Self {
        let components = specs
            .iter()
            .enumerate()
            .flat_map(|(spec_index, &spec)| {
                let members = spec.components.iter();
                members
                    .filter(|member| member.kind == ComponentKind::Component)
                    .map(move |component| Member { spec_index, spec, component })
            })
            .collect();
        Names { components }
    }

    /// Follows a path as far as possible. Returns one target per name that was resolved.
    pub fn follow(&self, path: &Path) -> Vec<Target> {
        let mut out = Vec::new();
        let mut names = path.names.iter().map(|name| name.value.as_str());
        let Some(first) = names.next() else {
            return out;
        };
        let Some(c) =
            self.components.iter().position(|component| component.component.name == first)
        else {
            return out;
        };
        out.push(Target::Component(c));
        let component = self.components[c].component;
        let Some(second) = names.next() else {
            return out;
        };
        let third = names.next();
        let task = component.tasks.position(|task| task.name == second);
        let service = component.services.position(|service| service.name == second);
        let port = component.ports.position(|port| port.name == second);
        // Tasks and services may share a name; the one with the requested state is meant.
        let has = |owner: Owner| third.is_some_and(|name| self.state(c, owner, name).is_some());
        let owner = match (task, service) {
            (Some(t), Some(s)) if has(Owner::Service(s)) && !has(Owner::Task(t)) => {
                Some(Owner::Service(s))
            }
            (Some(t), _) => Some(Owner::Task(t)),
            (None, Some(s)) => Some(Owner::Service(s)),
            (None, None) => None,
        };
        match (owner, port) {
            (Some(Owner::Task(t)), _) => out.push(Target::Task(c, t)),
            (Some(Owner::Service(s)), _) => out.push(Target::Service(c, s)),
            (None, Some(p)) => {
                let names = third.into_iter().chain(names);
                self.follow_members((c, p), names, &mut out);
                return out;
            }
            (None, None) => return out,
        }
        let (Some(owner), Some(third)) = (owner, third) else {
            return out;
        };
        if let Some(target) = self.state(c, owner, third) {
            out.push(target);
        }
        out
    }

    /// Appends a port, and the members of its data.
    fn follow_members<'n>(
        &self,
        (c, p): (usize, PortId),
        names: impl Iterator<Item = &'n str>,
        out: &mut Vec<Target>,
    ) {
        out.push(Target::Port(c, p));
        let Member { spec, component, .. } = self.components[c];
        let mut ty = component.ports[p].data;
        let mut path = Vec::new();
        for name in names {
            let Some((_, member)) = members(spec, ty).find(|(member, _)| *member == name) else {
                return;
            };
            ty = member;
            path.push(name.to_owned());
            out.push(Target::Member(c, p, path.clone()));
        }
    }

    /// Returns the type of a port, or of a member of its data; `None` for other targets.
    pub(crate) fn data_type(&self, target: &Target) -> Option<TypeId> {
        let (&Target::Port(c, p) | &Target::Member(c, p, _)) = target else { return None };
        let path = if let Target::Member(_, _, path) = target { path } else { &Vec::new() };
        let Member { spec, component, .. } = self.components[c];
        path.iter().try_fold(component.ports[p].data, |ty, name| {
            members(spec, ty).find(|(member, _)| member == name).map(|(_, ty)| ty)
        })
    }

    /// Returns a state of a machine, or a codel of the control task by its name or as `validate`.
    fn state(&self, c: usize, owner: Owner, name: &str) -> Option<Target> {
        let component = self.components[c].component;
        for (index, codel) in component.codels_of(owner).iter_enumerated() {
            if codel.kind == CodelKind::Fsm {
                if codel.triggers.iter().any(|trigger| trigger.name == name) {
                    return Some(Target::State(c, owner, index, name.to_owned()));
                }
            } else if let Owner::Service(s) = owner
                && (codel.name == name || (codel.kind == CodelKind::Validate && name == "validate"))
            {
                return Some(Target::Codel(c, s, index));
            }
        }
        None
    }

    /// Returns true if a service of a component is an activity.
    pub(crate) fn is_activity(&self, c: usize, s: ServiceId) -> bool {
        let services = &self.components[c].component.services;
        services[s].kind == ServiceKind::Activity
    }

    /// Resolves a whole path.
    ///
    /// # Errors
    ///
    /// Returns a diagnostic if the path leads nowhere.
    pub fn resolve(&self, path: &Path) -> Result<Target, Diagnostic> {
        let targets = self.follow(path);
        match targets.last() {
            Some(target) if targets.len() == path.names.len() => Ok(target.clone()),
            _ => Err(self.unknown(path, &targets)),
        }
    }

    /// Returns the diagnostic for the first name of a path that leads nowhere.
    pub fn unknown(&self, path: &Path, followed: &[Target]) -> Diagnostic {
        let Some(name) = path.names.get(followed.len()) else {
            return Diagnostic::error("scn-path", path.range(), "incomplete path".to_owned());
        };
        let candidates: Vec<String> =
            self.after(followed.last()).into_iter().map(|(name, _)| name).collect();
        let place = if followed.last().is_none() {
            "the system has no component".to_owned()
        } else {
            let before: Vec<&str> =
                path.names[..followed.len()].iter().map(|name| name.value.as_str()).collect();
            format!("`{}` has nothing called", before.join("."))
        };
        let mut message = format!("{place} `{}`", name.value);
        let near = nearest(&name.value, candidates.iter().map(String::as_str));
        if near.is_none() && !candidates.is_empty() && candidates.len() <= 12 {
            message.push_str(&format!("; there is {}", candidates.join(", ")));
        }
        let error = Diagnostic::error("scn-unknown-name", name.range.clone(), message);
        match near {
            Some(near) => error.suggest_name(near),
            None => error,
        }
    }

    /// Returns diagnostics for names in paths that lead nowhere, except clients and statuses.
    pub fn unknown_names(&self, scenario: &Scenario) -> Vec<Diagnostic> {
        let mut out = Vec::new();
        for_each_path(scenario, &mut |path| {
            let targets = self.follow(path);
            let Some(name) = path.names.get(targets.len()) else {
                return;
            };
            let mut of_client = Vec::new();
            client_references(scenario, path, &mut of_client);
            let status = !targets.is_empty() && STATUSES.contains(&name.value.as_str());
            if !status && of_client.is_empty() {
                out.push(self.unknown(path, &targets));
            }
        });
        out
    }

    /// Returns the names that may follow a target (`None`: at the beginning of a path), for completion.
    pub fn after(&self, target: Option<&Target>) -> Vec<(String, Target)> {
        let mut out = Vec::new();
        match target {
            None => {
                for (c, component) in self.components.iter().enumerate() {
                    out.push((component.component.name.to_string(), Target::Component(c)));
                }
            }
            Some(&Target::Component(c)) => {
                let component = self.components[c].component;
                for (i, task) in component.tasks.iter_enumerated() {
                    out.push((task.name.to_string(), Target::Task(c, i)));
                }
                for (i, service) in component.services.iter_enumerated() {
                    out.push((service.name.to_string(), Target::Service(c, i)));
                }
                for (i, port) in component.ports.iter_enumerated() {
                    out.push((port.name.to_string(), Target::Port(c, i)));
                }
            }
            Some(&Target::Task(c, t)) => self.states(c, Owner::Task(t), &mut out),
            Some(&Target::Service(c, s)) => self.states(c, Owner::Service(s), &mut out),
            Some(target @ (&Target::Port(c, p) | &Target::Member(c, p, _))) => {
                let path = if let Target::Member(_, _, path) = target { &**path } else { &[] };
                let ty = self.data_type(target);
                for (name, _) in ty.into_iter().flat_map(|ty| members(self.components[c].spec, ty))
                {
                    let path = [path, &[name.to_owned()]].concat();
                    out.push((name.to_owned(), Target::Member(c, p, path)));
                }
            }
            Some(_) => {}
        }
        out
    }

    fn states(&self, c: usize, owner: Owner, out: &mut Vec<(String, Target)>) {
        let component = self.components[c].component;
        for (index, codel) in component.codels_of(owner).iter_enumerated() {
            match (codel.kind, owner) {
                (CodelKind::Fsm, _) => {
                    for state in &codel.triggers {
                        let name = state.name.to_string();
                        out.push((name.clone(), Target::State(c, owner, index, name)));
                    }
                }
                (_, Owner::Service(s)) => {
                    out.push((codel.name.to_string(), Target::Codel(c, s, index)));
                }
                _ => {}
            }
        }
    }

    /// Returns every name in the paths of a scenario that has a target, in order.
    pub fn references(&self, scenario: &Scenario) -> Vec<Reference> {
        let mut out = Vec::new();
        for_each_path(scenario, &mut |path| {
            let targets = self.follow(path);
            if targets.is_empty() {
                client_references(scenario, path, &mut out);
                return;
            }
            let followed = targets.len();
            for (name, target) in path.names.iter().zip(targets) {
                out.push(Reference { range: name.range.clone(), target });
            }
            if let Some(name) = path.names.get(followed)
                && STATUSES.contains(&name.value.as_str())
            {
                let target = Target::Status(name.value.clone());
                out.push(Reference { range: name.range.clone(), target });
            }
        });
        for item in &scenario.items {
            if let Item::Client(client) = item {
                out.extend(aborted_labels(client));
            }
        }
        out.sort_by_key(|reference| reference.range.start);
        out
    }
}

/// Returns the members of a struct, with their types; none for other types.
fn members(spec: &Spec, ty: TypeId) -> impl Iterator<Item = (&str, TypeId)> {
    let members = match &spec.ty(spec.resolve_alias(ty)).kind {
        TypeKind::Struct { members } => &**members,
        _ => &[],
    };
    members.iter().filter_map(|&member| Some((spec.ty(member).name.as_deref()?, member)))
}

/// Returns the labels of steps that `abort` names.
fn aborted_labels(client: &Client) -> impl Iterator<Item = Reference> {
    Step::all(&client.steps).into_iter().filter_map(|step| {
        let StepKind::Abort(path) = &step.kind else { return None };
        let [label] = path.names.as_slice() else { return None };
        let target = Target::Step(client.name.value.clone(), label.value.clone());
        Some(Reference { range: label.range.clone(), target })
    })
}

fn client_references(scenario: &Scenario, path: &Path, out: &mut Vec<Reference>) {
    let Some(first) = path.names.first() else {
        return;
    };
    let client = scenario.items.iter().find_map(|item| match item {
        Item::Client(client) if client.name.value == first.value => Some(client),
        _ => None,
    });
    let Some(client) = client else { return };
    let name = client.name.value.clone();
    out.push(Reference { range: first.range.clone(), target: Target::Client(name.clone()) });
    if let Some(second) = path.names.get(1) {
        let target = Target::Step(name, second.value.clone());
        out.push(Reference { range: second.range.clone(), target });
    }
}

/// Calls `each` with every path of a scenario.
pub(crate) fn for_each_path<'s>(scenario: &'s Scenario, each: &mut impl FnMut(&'s Path)) {
    for item in &scenario.items {
        match item {
            Item::Duration(path, ..) | Item::Slots(path, _) => each(path),
            Item::Loop(_, Some(path), _) | Item::Idle(_, Some(path)) => each(path),
            Item::Connect(from, to) => {
                each(from);
                to.iter().for_each(&mut *each);
            }
            Item::Client(client) => {
                Step::all(&client.steps).into_iter().filter_map(path_of).for_each(&mut *each);
                let components = client.trigger.iter();
                let components =
                    components.filter(|trigger| trigger.kind != TriggerKind::Violation);
                components.flat_map(|trigger| &trigger.of).for_each(&mut *each);
            }
            Item::Check(check) => {
                check.kind.task().into_iter().for_each(&mut *each);
                if let CheckKind::Chain(_, chain, _) = &check.kind {
                    chain.paths().for_each(&mut *each);
                }
                for predicate in check.kind.predicates() {
                    pred(predicate, each);
                }
            }
            _ => {}
        }
    }
}

/// Returns the path of a step.
fn path_of(step: &Step) -> Option<&Path> {
    match &step.kind {
        StepKind::Send(path)
        | StepKind::Abort(path)
        | StepKind::Kill(path)
        | StepKind::Connect(path) => Some(path),
        StepKind::AwaitAccepted(path) | StepKind::AwaitEnded(_, path) => path.as_ref(),
        _ => None,
    }
}

fn pred<'s>(predicate: &'s Pred, each: &mut impl FnMut(&'s Path)) {
    match predicate {
        Pred::Atom(path) | Pred::Leave(path) | Pred::Comparison(Comparison { path, .. }) => {
            each(path);
        }
        Pred::Not(predicate) => pred(predicate, each),
        Pred::And(one, other) | Pred::Or(one, other) => {
            pred(one, each);
            pred(other, each);
        }
    }
}

/// A conversion for callers that have only a name.
impl From<Spanned<String>> for Path {
    fn from(name: Spanned<String>) -> Self {
        Path { names: vec![name] }
    }
}
