//! The clients of the interpreted system, from those of a scenario.

use dotgen_timing::scn::ast::{self, Ending, StepKind};

use super::{Builtin, System, in_millis};

pub(crate) struct Client {
    pub(crate) name: String,
    pub(crate) nodes: Vec<Node>,
    /// Possible first nodes.
    pub(crate) first: Vec<usize>,
    /// The end of some request is awaited.
    pub(crate) awaits: bool,
    /// The outcome of some request matters.
    pub(crate) outcomes: bool,
    /// Some instance is aborted.
    pub(crate) aborts: bool,
}

/// The target of an abort.
#[derive(Debug, Clone)]
pub(crate) enum Aborted {
    /// The last accepted instance of a service: component and service.
    Last(usize, usize),
    /// The last accepted instance of the steps with this label.
    Labelled(String),
}

pub(crate) struct Node {
    pub(crate) label: Option<String>,
    pub(crate) action: Action,
    /// Possible next nodes; the number of nodes stands for the end.
    pub(crate) next: Vec<usize>,
    pub(crate) aborts: Option<Aborted>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Action {
    /// Component and service.
    Send(usize, usize),
    AwaitAccepted,
    /// Awaits the end of the last request, or of the last request for a service.
    AwaitEnded(Option<(usize, usize)>),
    Delay(u32, u32),
    /// Awaits the success (`true`) or failure of the request of [`Action::AwaitEnded`].
    AwaitOutcome(Option<(usize, usize)>, bool),
    /// Waits for the first of the outcomes that follow.
    Either,
    /// Not a step: beginning and end of loops.
    Jump,
}

pub(super) fn client(system: &System, client: &ast::Client) -> Client {
    let mut out = Client {
        name: client.name.value.clone(),
        nodes: Vec::new(),
        first: Vec::new(),
        awaits: false,
        outcomes: false,
        aborts: false,
    };
    let mut labels = Vec::new();
    labelled(&client.steps, &mut labels);
    let end = out.push(None, Action::Jump, Vec::new());
    out.first = vec![out.steps((system, &labels), &client.steps, end)];
    out
}

/// Appends the labels of requests, with the components they address.
fn labelled(steps: &[ast::Step], out: &mut Vec<(String, String)>) {
    for step in steps {
        match (&step.label, &step.kind) {
            (Some(label), StepKind::Send(path)) => {
                out.push((label.value.clone(), path.names[0].value.clone()));
            }
            (_, StepKind::Repeat(_, body)) => labelled(body, out),
            (_, StepKind::Choice(branches)) => {
                for branch in branches {
                    labelled(branch, out);
                }
            }
            _ => {}
        }
    }
}

/// The system, and the labels of a client.
type Context<'c> = (&'c System, &'c [(String, String)]);

impl Client {
    /// Returns the end: a jump that leads nowhere.
    pub(crate) fn end(&self) -> usize {
        0
    }

    fn push(&mut self, label: Option<String>, action: Action, next: Vec<usize>) -> usize {
        self.nodes.push(Node { label, action, next, aborts: None });
        self.nodes.len() - 1
    }

    /// Adds steps before a node; returns the first node of the steps.
    fn steps(&mut self, system: Context, steps: &[ast::Step], then: usize) -> usize {
        steps.iter().rev().fold(then, |then, step| self.step(system, step, then))
    }

    fn step(&mut self, context: Context, step: &ast::Step, then: usize) -> usize {
        let (system, labels) = context;
        let builtin = |component: &str, which: Builtin| {
            let c = system.component(component);
            let mut services = system.components[c].services.iter();
            let found = services.position(|service| service.builtin == Some(which));
            Action::Send(c, found.expect("a request of all"))
        };
        let service = |path: &ast::Path| {
            let names: Vec<&str> = path.names.iter().map(|name| name.value.as_str()).collect();
            let c = system.component(names[0]);
            let mut services = system.components[c].services.iter();
            let found = services.position(|service| service.name == names[1]);
            (c, found.expect("a service"))
        };
        let label = step.label.as_ref().map(|label| label.value.clone());
        let action = match &step.kind {
            StepKind::Send(path) => {
                let (c, s) = service(path);
                // A request without a label has the name of its service.
                let label = label.or(Some(system.components[c].services[s].name.clone()));
                return self.push(label, Action::Send(c, s), vec![then]);
            }
            StepKind::AwaitAccepted(_) => Action::AwaitAccepted,
            StepKind::AwaitEnded(ending, path) => {
                self.awaits = true;
                let of = path.as_ref().map(service);
                let succeeds = match ending {
                    Ending::Any => return self.push(label, Action::AwaitEnded(of), vec![then]),
                    Ending::Ok => true,
                    Ending::Failed => false,
                };
                self.outcomes = true;
                let outcome = self.push(None, Action::AwaitOutcome(of, succeeds), vec![then]);
                return self.push(label, Action::Either, vec![outcome]);
            }
            StepKind::Abort(path) => {
                self.aborts = true;
                let (component, aborted) = match path.names.as_slice() {
                    [label] => {
                        let found = labels.iter().find(|other| other.0 == label.value);
                        let component = found.expect("a label of a request").1.as_str();
                        (component, Aborted::Labelled(label.value.clone()))
                    }
                    names => {
                        let (c, s) = service(path);
                        (names[0].value.as_str(), Aborted::Last(c, s))
                    }
                };
                let node = self.push(label, builtin(component, Builtin::Abort), vec![then]);
                self.nodes[node].aborts = Some(aborted);
                return node;
            }
            StepKind::Stop => return then,
            StepKind::Kill(path) => builtin(&path.names[0].value, Builtin::Kill),
            StepKind::Connect(path) => builtin(&path.names[0].value, Builtin::Connect),
            StepKind::Delay(interval, unit) => {
                let upper = interval.upper.expect("a bound");
                Action::Delay(in_millis(interval.lower, *unit), in_millis(upper, *unit))
            }
            StepKind::Repeat(Some(times), body) => {
                return (0..*times).fold(then, |then, _| self.steps(context, body, then));
            }
            StepKind::Repeat(None, body) => {
                let again = self.push(None, Action::Jump, Vec::new());
                let first = self.steps(context, body, again);
                self.nodes[again].next = vec![first];
                return again;
            }
            StepKind::Choice(branches) => {
                let firsts = branches.iter().map(|branch| self.steps(context, branch, then));
                let next: Vec<usize> = firsts.collect();
                // Branches that wait for an outcome are merged: the first outcome to come is taken.
                let (waiting, mut next): (Vec<usize>, Vec<usize>) =
                    (next.into_iter()).partition(|&step| self.nodes[step].action == Action::Either);
                if let [first, others @ ..] = waiting.as_slice() {
                    next.push(*first);
                    for &other in others {
                        let outcomes = self.nodes[other].next.clone();
                        self.nodes[*first].next.extend(outcomes);
                    }
                }
                return self.push(label, Action::Jump, next);
            }
        };
        self.push(label, action, vec![then])
    }

    /// Returns the steps, or the end, that are reached from some nodes without any action.
    pub(crate) fn reach(&self, from: &[usize]) -> Vec<usize> {
        let (mut out, mut todo) = (Vec::new(), from.to_vec());
        let mut seen = Vec::new();
        while let Some(node) = todo.pop() {
            if seen.contains(&node) {
                continue;
            }
            seen.push(node);
            match self.nodes[node].action {
                Action::Jump if node != self.end() => todo.extend(&self.nodes[node].next),
                _ => out.push(node),
            }
        }
        out
    }
}
