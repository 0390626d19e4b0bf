//! Descriptions of names and words in a scenario, for hovers.

use std::ops::Range;

use dotgen_analysis::model::{Codel, CodelKind, Owner, Quantity, Src};

use super::ast::Scenario;
use super::lexer::{Kind, lex};
use super::names::{Names, Target};
use super::words;

/// The description of a place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Description {
    /// Range of bytes.
    pub range: Range<usize>,
    /// Syntax, or declaration.
    pub form: String,
    pub meaning: String,
}

/// Describes the name of the specifications, or the word of the language, at an offset.
pub fn describe(
    text: &str,
    scenario: &Scenario,
    names: &Names,
    offset: usize,
) -> Option<Description> {
    let touches = |range: &Range<usize>| range.start <= offset && offset <= range.end;
    let references = names.references(scenario);
    if let Some(reference) = references.into_iter().find(|reference| touches(&reference.range)) {
        if let Target::Status(status) = &reference.target {
            return of_word(status, reference.range);
        }
        let (form, meaning) = names.describe(&reference.target);
        return Some(Description { range: reference.range, form, meaning });
    }
    let token = lex(text).into_iter().find(|lex| lex.kind == Kind::Name && touches(&lex.range))?;
    of_word(&text[token.range.clone()], token.range)
}

fn of_word(word: &str, range: Range<usize>) -> Option<Description> {
    let word = words::find(word)?;
    Some(Description { range, form: word.form.to_owned(), meaning: word.meaning.to_owned() })
}

impl Names<'_> {
    /// Returns the declaration and the description of a target.
    pub fn describe(&self, target: &Target) -> (String, String) {
        let component = |c: usize| self.components[c].component;
        match target {
            &Target::Component(c) => {
                let component = component(c);
                let (tasks, services) = (component.tasks.len(), component.services.len());
                let meaning = format!("{tasks} tasks, {services} services");
                (format!("component {}", component.name), meaning)
            }
            &Target::Task(c, t) => {
                let task = &component(c).tasks[t];
                let meaning = match &task.period {
                    Some(period) => format!("period {}", time(period)),
                    None => "aperiodic: runs whenever something is runnable in it".to_owned(),
                };
                (format!("task {}.{}", component(c).name, task.name), meaning)
            }
            &Target::Service(c, s) => {
                let service = &component(c).services[s];
                let kind = service.kind.word();
                let tasks = &component(c).tasks;
                let meaning = match service.task.and_then(|t| tasks.get(t)) {
                    Some(task) => format!("runs in task `{}`", task.name),
                    None => "runs in the control task".to_owned(),
                };
                (format!("{kind} {}.{}", component(c).name, service.name), meaning)
            }
            &Target::Port(c, p) => {
                let port = &component(c).ports[p];
                let dir = port.dir.word();
                let form = format!("port {dir} {}.{}", component(c).name, port.name);
                (form, "an output port is one lock for all that use it".to_owned())
            }
            Target::Member(c, p, path) => {
                let port = &component(*c).ports[*p];
                let form = format!("{}.{}.{}", component(*c).name, port.name, path.join("."));
                (form, "data of a port, which runs and recordings have".to_owned())
            }
            Target::State(c, owner, index, state) => {
                let codel = component(*c).codels_of(*owner).get(*index);
                let meaning = codel.map_or(String::new(), |codel| of_codel(codel, Some(state)));
                (
                    codel.map_or(String::new(), |codel| format!("codel<{state}> {}", codel.name)),
                    meaning,
                )
            }
            &Target::Codel(c, s, index) => {
                let codel = component(c).codels_of(Owner::Service(s)).get(index);
                let form = codel.map_or(String::new(), |codel| match codel.kind {
                    CodelKind::Validate => format!("validate {}", codel.name),
                    _ => format!("codel {}", codel.name),
                });
                (form, codel.map_or(String::new(), |codel| of_codel(codel, None)))
            }
            Target::Client(name) => {
                (format!("client {name}"), "a client of this scenario".to_owned())
            }
            Target::Step(client, name) => (
                format!("{client}.{name}"),
                "a step of a client: true while the client is at it".to_owned(),
            ),
            Target::Status(status) => {
                let known = words::find(status);
                (status.clone(), known.map_or(String::new(), |word| word.meaning.to_owned()))
            }
        }
    }

    /// Returns the place of a declaration: number of the specification, and name.
    pub fn declaration(&self, target: &Target) -> Option<(usize, Src)> {
        let member = |c: usize| (self.components[c].spec_index, self.components[c].component);
        let (c, src) = match target {
            &Target::Component(c) => (c, Some(member(c).1.src)),
            &Target::Task(c, t) => (c, member(c).1.tasks.get(t).map(|task| task.src)),
            &Target::Service(c, s) => (c, member(c).1.services.get(s).map(|service| service.src)),
            &Target::Port(c, p) => (c, member(c).1.ports.get(p).map(|port| port.src)),
            &Target::Member(c, ..) => {
                (c, self.data_type(target).map(|ty| self.components[c].spec.ty(ty).src))
            }
            Target::State(c, owner, index, state) => {
                let codel = member(*c).1.codels_of(*owner).get(*index);
                let trigger = codel
                    .and_then(|codel| codel.triggers.iter().find(|trigger| trigger.name == *state));
                (*c, trigger.map(|trigger| trigger.src))
            }
            &Target::Codel(c, s, index) => {
                let codel = member(c).1.codels_of(Owner::Service(s)).get(index);
                (c, codel.map(|codel| codel.src))
            }
            Target::Client(_) | Target::Step(..) | Target::Status(_) => return None,
        };
        Some((member(c).0, src?))
    }
}

fn of_codel(codel: &Codel, state: Option<&str>) -> String {
    let mut parts = Vec::new();
    if let (Some(state), true) = (state, codel.triggers.len() > 1) {
        parts.push(format!("one of the states of this codel is `{state}`"));
    }
    parts.push(match &codel.wcet {
        Some(wcet) => format!("takes at most {}", time(wcet)),
        None => "has no `wcet`: takes no time".to_owned(),
    });
    if !codel.yields.is_empty() {
        let yields = codel.yields.iter().map(|state| {
            if state.paused { format!("pause::{}", state.name) } else { state.name.to_string() }
        });
        parts.push(format!("yields {}", yields.collect::<Vec<_>>().join(", ")));
    }
    parts.join("; ")
}

fn time(quantity: &Quantity) -> String {
    let micros = *quantity.value.numer() as f64 / *quantity.value.denom() as f64 * 1e6;
    match micros {
        number if number >= 1e6 => format!("{} s", number / 1e6),
        number if number >= 1e3 => format!("{} ms", number / 1e3),
        number => format!("{number} us"),
    }
}
