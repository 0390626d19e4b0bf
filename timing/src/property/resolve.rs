//! The resolution of predicates of scenarios in a built system.

use dotgen_analysis::model::{CodelRef, Owner, ServiceKind};

use super::{Atom, Predicate, SlotStatus, StatePhase, TaskState, data};
use crate::diagnostic::Diagnostic;
use crate::scn::ast::{Comparison, Path, Pred, Trigger};
use crate::scn::names::{Names, STATUSES, Target};
use crate::system::indexed::Built;
use crate::system::indexed::DeclaredTask;

/// Appends the components of a predicate, which must not be separated.
pub(crate) fn components_of(names: &Names, built: &Built, pred: &Pred, out: &mut Vec<usize>) {
    match pred {
        Pred::Atom(path) | Pred::Leave(path) | Pred::Comparison(Comparison { path, .. }) => {
            if let Some(&Target::Component(c)) = names.follow(path).first() {
                out.push(c);
            } else if let Some(first) = path.names.first() {
                let client = built.system.clients.iter().find(|client| client.name == first.value);
                for step in client.iter().flat_map(|client| &client.steps) {
                    if let crate::system::ClientAction::Send { service, .. } = step.action {
                        let number = built.system.services[service].component;
                        out.extend(
                            built.components.iter().filter(|(_, n)| **n == number).map(|(c, _)| *c),
                        );
                    }
                }
            }
        }
        Pred::Not(predicate) => components_of(names, built, predicate, out),
        Pred::And(one, other) | Pred::Or(one, other) => {
            components_of(names, built, one, out);
            components_of(names, built, other, out);
        }
    }
}

pub(crate) fn resolve(names: &Names, built: &Built, pred: &Pred) -> Result<Predicate, Diagnostic> {
    Ok(match pred {
        Pred::Atom(path) => atom(names, built, path)?,
        Pred::Comparison(comparison) => {
            let fact = data::resolve(names, built, comparison)?;
            let known = built.data.as_ref();
            let Some(fact) = known.and_then(|known| known.iter().position(|known| *known == fact))
            else {
                return Err(data::not_in_model(comparison));
            };
            Predicate::Atom(Atom::Data { fact, negated: false })
        }
        Pred::Leave(path) => match atom(names, built, path)? {
            Predicate::Atom(atom) => Predicate::Leave(atom),
            // A negated atom is left when the atom becomes true; only `void` is built like this.
            other => other,
        },
        Pred::Not(predicate) => resolve(names, built, predicate)?.negation(),
        Pred::And(one, other) => Predicate::And(
            Box::new(resolve(names, built, one)?),
            Box::new(resolve(names, built, other)?),
        ),
        Pred::Or(one, other) => Predicate::Or(
            Box::new(resolve(names, built, one)?),
            Box::new(resolve(names, built, other)?),
        ),
    })
}

fn atom(names: &Names, built: &Built, path: &Path) -> Result<Predicate, Diagnostic> {
    if let Some(atom) = client(built, path)? {
        return Ok(Predicate::Atom(atom));
    }
    let targets = names.follow(path);
    let rest = path.names.len() - targets.len();
    let status = match (rest, path.names.last()) {
        (0, _) => None,
        (1, Some(last)) if STATUSES.contains(&last.value.as_str()) => Some(last),
        _ => return Err(names.unknown(path, &targets)),
    };
    let word = status.map_or("", |status| status.value.as_str());
    let wrong = || {
        let range = status.map_or(path.range(), |status| status.range.clone());
        let message = format!("`{}` has no status `{word}`", path.text());
        Err(Diagnostic::error("scn-wrong-status", range, message))
    };
    let Some(target) = targets.last() else {
        return Err(names.unknown(path, &targets));
    };
    let found = match target {
        Target::Component(c) => {
            let busy = Atom::ControlBusy(built.components[c]);
            match word {
                "" | "running" => busy,
                "idle" => return Ok(Predicate::Not(Box::new(Predicate::Atom(busy)))),
                _ => return wrong(),
            }
        }
        Target::Task(c, t) => {
            let state = match word {
                "" => TaskState::Active,
                "idle" => TaskState::Idle,
                "waiting" => TaskState::Waiting,
                "running" => TaskState::Running,
                "tick" if names.components[*c].component.tasks[*t].period.is_some() => {
                    let task = built.tasks[&DeclaredTask { component: *c, index: *t }];
                    return Ok(Predicate::Atom(Atom::Tick(task)));
                }
                _ => return wrong(),
            };
            Atom::Task(built.tasks[&DeclaredTask { component: *c, index: *t }], state)
        }
        Target::Service(c, s) => {
            let service = built.services[&(*c, *s)];
            let kind = names.components[*c].component.services[*s].kind;
            if kind == ServiceKind::Activity {
                let status = match word {
                    "" => SlotStatus::Active,
                    "waiting" => SlotStatus::Wait,
                    "run" | "running" => SlotStatus::Run,
                    "stop" => SlotStatus::Stop,
                    "void" | "idle" => SlotStatus::Void,
                    _ => return wrong(),
                };
                Atom::Slot(service, status)
            } else {
                let Some(phase) = phase(word) else { return wrong() };
                Atom::Handling { service, codel: None, phase }
            }
        }
        Target::State(c, owner, _, state) => {
            let Some(phase) = phase(word) else {
                return wrong();
            };
            let Some(&machine) = built.machines.get(&(*c, *owner)) else {
                let message = format!("`{}` is never executed: it has no `start`", path.text());
                return Err(Diagnostic::error("scn-not-executed", path.range(), message));
            };
            let states = &built.system.machines[machine].states;
            let Some(state) = states.iter().position(|candidate| candidate.name == *state) else {
                return Err(names.unknown(path, &targets));
            };
            Atom::State { machine, state, phase }
        }
        &Target::Codel(c, s, index) => {
            let Some(phase) = phase(word) else {
                return wrong();
            };
            let site = CodelRef { owner: Owner::Service(s), index };
            Atom::Handling {
                service: built.services[&(c, s)],
                codel: built.system.codels.position(|codel| codel.site == Some((c, site))),
                phase,
            }
        }
        Target::Port(..)
        | Target::Member(..)
        | Target::Client(_)
        | Target::Step(..)
        | Target::Status(_) => {
            return wrong();
        }
    };
    Ok(Predicate::Atom(found))
}

fn phase(word: &str) -> Option<StatePhase> {
    match word {
        "" => Some(StatePhase::Any),
        "lock" | "waiting" => Some(StatePhase::Lock),
        "exec" | "running" => Some(StatePhase::Exec),
        _ => None,
    }
}

/// Resolves `client` (all of its steps are done) or `client.label`.
fn client(built: &Built, path: &Path) -> Result<Option<Atom>, Diagnostic> {
    let Some(first) = path.names.first() else {
        return Ok(None);
    };
    let clients = &built.system.clients;
    let Some(k) = clients.position(|client| client.name == first.value) else {
        return Ok(None);
    };
    let steps: Vec<usize> = match path.names.get(1) {
        None => vec![clients[k].done()],
        Some(label) if label.value == Trigger::BEGUN && clients[k].awaits_event.is_some() => {
            (0..=clients[k].done()).filter(|&step| Some(step) != clients[k].awaits_event).collect()
        }
        Some(label)
            if let Some(of) = label.value.strip_prefix(Trigger::AFTER)
                && clients[k].awaits_event.is_some() =>
        {
            clients[k].after(of)
        }
        Some(label) => (0..clients[k].steps.len())
            .filter(|&step| clients[k].steps[step].label.as_ref() == Some(&label.value))
            .collect(),
    };
    if steps.is_empty() || path.names.len() > 2 {
        let message = format!(
            "client `{}` has no step `{}`; label one as `name: send …;`",
            first.value,
            path.names.last().map_or("", |name| name.value.as_str())
        );
        return Err(Diagnostic::error("scn-unknown-step", path.range(), message));
    }
    Ok(Some(Atom::Client(k, steps)))
}

/// Returns the task of a path, for checks of tasks.
pub(crate) fn task(names: &Names, path: &Path) -> Result<DeclaredTask, Diagnostic> {
    let message = match names.resolve(path)? {
        Target::Task(component, index) => return Ok(DeclaredTask { component, index }),
        Target::State(c, Owner::Task(_), ..) | Target::Component(c) => {
            let tasks: Vec<&str> =
                names.components[c].component.tasks.iter().map(|task| task.name.as_str()).collect();
            format!("`{}` is no task; there is {}", path.text(), tasks.join(", "))
        }
        _ => format!("`{}` is no task", path.text()),
    };
    Err(Diagnostic::error("scn-wrong-kind", path.range(), message))
}
