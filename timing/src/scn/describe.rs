//! Descriptions of names and words in a scenario, for hovers.

use std::ops::Range;

use dotgen_analysis::model::{
    Codel, CodelKind, Component, Owner, PortDir, Quantity, ServiceKind, Src,
};

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
    /// Meaning.
    pub meaning: String,
}

/// Describes the name of the specifications, or the word of the language, at an offset.
pub fn describe(
    text: &str,
    scenario: &Scenario,
    names: &Names,
    offset: usize,
) -> Option<Description> {
    let touches = |it: &Range<usize>| it.start <= offset && offset <= it.end;
    let references = names.references(scenario);
    if let Some(it) = references.into_iter().find(|it| touches(&it.range)) {
        if let Target::Status(status) = &it.target {
            return of_word(status, it.range);
        }
        let (form, meaning) = names.describe(&it.target);
        return Some(Description {
            range: it.range,
            form,
            meaning,
        });
    }
    let token = lex(text)
        .into_iter()
        .find(|it| it.kind == Kind::Name && touches(&it.range))?;
    of_word(&text[token.range.clone()], token.range)
}

fn of_word(word: &str, range: Range<usize>) -> Option<Description> {
    let it = words::find(word)?;
    Some(Description {
        range,
        form: it.form.to_owned(),
        meaning: it.meaning.to_owned(),
    })
}

impl Names<'_> {
    /// Returns the declaration and the description of a target.
    pub fn describe(&self, target: &Target) -> (String, String) {
        let component = |c: usize| self.components[c].component;
        match target {
            &Target::Component(c) => {
                let it = component(c);
                let (tasks, services) = (it.tasks.len(), it.services.len());
                let meaning = format!("{tasks} tasks, {services} services");
                (format!("component {}", it.name), meaning)
            }
            &Target::Task(c, t) => {
                let it = &component(c).tasks[t as usize];
                let meaning = match &it.period {
                    Some(period) => format!("period {}", time(period)),
                    None => "aperiodic: runs whenever something is runnable in it".to_owned(),
                };
                (format!("task {}.{}", component(c).name, it.name), meaning)
            }
            &Target::Service(c, s) => {
                let it = &component(c).services[s as usize];
                let kind = match it.kind {
                    ServiceKind::Attribute => "attribute",
                    ServiceKind::Function => "function",
                    ServiceKind::Activity => "activity",
                };
                let tasks = &component(c).tasks;
                let meaning = match it.task.and_then(|t| tasks.get(t as usize)) {
                    Some(task) => format!("runs in task `{}`", task.name),
                    None => "runs in the control task".to_owned(),
                };
                (format!("{kind} {}.{}", component(c).name, it.name), meaning)
            }
            &Target::Port(c, p) => {
                let it = &component(c).ports[p as usize];
                let dir = match it.dir {
                    PortDir::In => "in",
                    PortDir::Out => "out",
                };
                let form = format!("port {dir} {}.{}", component(c).name, it.name);
                (
                    form,
                    "an output port is one lock for all that use it".to_owned(),
                )
            }
            Target::State(c, owner, index, state) => {
                let it = codel_at(component(*c), *owner, *index);
                let meaning = it.map_or(String::new(), |it| of_codel(it, Some(state)));
                (
                    it.map_or(String::new(), |it| format!("codel<{state}> {}", it.name)),
                    meaning,
                )
            }
            &Target::Codel(c, s, index) => {
                let it = codel_at(component(c), Owner::Service(s), index);
                let form = it.map_or(String::new(), |it| match it.kind {
                    CodelKind::Validate => format!("validate {}", it.name),
                    _ => format!("codel {}", it.name),
                });
                (form, it.map_or(String::new(), |it| of_codel(it, None)))
            }
            Target::Client(name) => (
                format!("client {name}"),
                "a client of this scenario".to_owned(),
            ),
            Target::Step(client, name) => (
                format!("{client}.{name}"),
                "a step of a client: true while the client is at it".to_owned(),
            ),
            Target::Status(status) => {
                let known = words::find(status);
                (
                    status.clone(),
                    known.map_or(String::new(), |it| it.meaning.to_owned()),
                )
            }
        }
    }

    /// Returns the place of a declaration: number of the specification, and name.
    pub fn declaration(&self, target: &Target) -> Option<(usize, Src)> {
        let member = |c: usize| (self.components[c].spec_index, self.components[c].component);
        let (c, src) = match target {
            &Target::Component(c) => (c, Some(member(c).1.src)),
            &Target::Task(c, t) => (c, member(c).1.tasks.get(t as usize).map(|it| it.src)),
            &Target::Service(c, s) => (c, member(c).1.services.get(s as usize).map(|it| it.src)),
            &Target::Port(c, p) => (c, member(c).1.ports.get(p as usize).map(|it| it.src)),
            Target::State(c, owner, index, state) => {
                let codel = codel_at(member(*c).1, *owner, *index);
                let trigger = codel.and_then(|it| it.triggers.iter().find(|it| it.name == *state));
                (*c, trigger.map(|it| it.src))
            }
            &Target::Codel(c, s, index) => {
                let codel = codel_at(member(c).1, Owner::Service(s), index);
                (c, codel.map(|it| it.src))
            }
            Target::Client(_) | Target::Step(..) | Target::Status(_) => return None,
        };
        Some((member(c).0, src?))
    }
}

fn codel_at(component: &Component, owner: Owner, index: u32) -> Option<&Codel> {
    component.codels_of(owner).get(index as usize)
}

fn of_codel(it: &Codel, state: Option<&str>) -> String {
    let mut parts = Vec::new();
    if let (Some(state), true) = (state, it.triggers.len() > 1) {
        parts.push(format!("one of the states of this codel is `{state}`"));
    }
    parts.push(match &it.wcet {
        Some(wcet) => format!("takes at most {}", time(wcet)),
        None => "has no `wcet`: takes no time".to_owned(),
    });
    if !it.yields.is_empty() {
        let yields = it.yields.iter().map(|it| match it.paused {
            true => format!("pause::{}", it.name),
            false => it.name.to_string(),
        });
        parts.push(format!("yields {}", yields.collect::<Vec<_>>().join(", ")));
    }
    parts.join("; ")
}

fn time(it: &Quantity) -> String {
    let micros = *it.value.numer() as f64 / *it.value.denom() as f64 * 1e6;
    match micros {
        it if it >= 1e6 => format!("{} s", it / 1e6),
        it if it >= 1e3 => format!("{} ms", it / 1e3),
        it => format!("{it} us"),
    }
}
