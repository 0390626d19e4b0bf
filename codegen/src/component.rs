//! A new component from a few answers: its specification and a scenario that verifies it, as text.
//!
//! Each is made from a template, and formatted afterwards. The sources of the codels are ordinary stubs
//! ([`crate::codels::command::stub`]). Execution times are written as `#pragma wcet`, which every release of
//! GenoM3 accepts.

use std::fmt;

use minijinja::{Environment, UndefinedBehavior, context};
use serde::Serialize;

/// The contents of a new component.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct NewComponent {
    pub name: String,
    /// Its tasks; at least one.
    pub tasks: Vec<NewTask>,
    /// Interfaces whose ports it provides, in the declared direction.
    pub provides: Vec<NewInterface>,
    /// Interfaces whose ports it uses, in the opposite direction.
    pub uses: Vec<NewInterface>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewTask {
    pub name: String,
    /// Its period, such as `10 ms`; without one the task is aperiodic.
    pub period: Option<String>,
}

/// An interface that the component provides or uses.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewInterface {
    pub name: String,
    /// The path in its `#include`, relative to the folder of the component.
    pub include: String,
    /// Its ports, in the directions of the component.
    pub ports: Vec<NewPort>,
}

/// A port of a component.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct NewPort {
    pub name: String,
    /// True if the component writes it, false if the component reads it.
    pub writes: bool,
}

/// An error in the answers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NewComponentError {
    /// The name is not an identifier of C.
    Name(String),
    /// The name is a keyword of specifications.
    Keyword(String),
    /// Two tasks have this name.
    Twice(String),
    /// The period of a task is invalid.
    Period {
        task: String,
        /// The given text.
        period: String,
    },
    /// There is no task, so nothing would execute.
    NoTask,
    /// The text could not be generated: an error in the template.
    Template(String),
}

impl fmt::Display for NewComponentError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        use NewComponentError::*;
        match self {
            Name(name) => write!(
                f,
                "`{name}` is not a valid name: write a letter or `_`, then letters, digits and `_`"
            ),
            Keyword(name) => {
                write!(f, "`{name}` is a keyword of specifications: choose another name")
            }
            Twice(name) => write!(f, "two tasks are called `{name}`: give one another name"),
            Period { task, period } => write!(
                f,
                "`{period}` is not a valid period of task `{task}`: write a number above 0 and its unit, as in `10 ms`"
            ),
            NoTask => write!(f, "a component needs a task: give at least one"),
            Template(why) => write!(f, "the specification cannot be written: {why}"),
        }
    }
}

impl std::error::Error for NewComponentError {}

/// The texts of a component.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewTexts {
    /// The specification, not yet formatted.
    pub specification: String,
    /// The scenario, not yet formatted.
    pub scenario: String,
}

/// A task, in the form of the templates.
#[derive(Serialize)]
struct TaskData<'a> {
    name: &'a str,
    period: Option<String>,
    /// Execution time of each of its codels, as text.
    wcet: String,
    /// Ports that its main codel uses.
    ports: Vec<&'a NewPort>,
}

const SPECIFICATION: &str = include_str!("component/component.gen.jinja");
const SCENARIO: &str = include_str!("component/component.scn.jinja");

/// Microseconds in a unit.
fn unit(word: &str) -> Option<f64> {
    Some(match word {
        "s" => 1e6,
        "ms" => 1e3,
        "us" => 1.0,
        _ => return None,
    })
}

/// The period in microseconds, and its form in a specification, for texts such as `10 ms`, `10ms` or `0.5 s`.
fn period(text: &str) -> Option<(f64, String)> {
    let text = text.trim();
    let end = text.find(|character: char| !character.is_ascii_digit() && character != '.')?;
    let (number, word) = (&text[..end], text[end..].trim());
    let value: f64 = number.parse().ok()?;
    let micros = value * unit(word)?;
    (micros >= 1.0 && micros.is_finite()).then(|| (micros, format!("{number} {word}")))
}

/// True if a text is an identifier of C.
fn is_name(text: &str) -> bool {
    let mut chars = text.chars();
    let first = chars.next();
    first.is_some_and(|character| character.is_ascii_alphabetic() || character == '_')
        && chars.all(|character| character.is_ascii_alphanumeric() || character == '_')
}

/// Returns `true` if a text is a word that specifications reserve.
fn is_keyword(text: &str) -> bool {
    let tokens = dotgen_syntax::lexer::lex(text);
    let kind = tokens.kinds().first();
    kind.is_some_and(|kind| kind.is_reserved_word())
}

impl NewComponent {
    /// The texts of the component.
    ///
    /// # Errors
    /// The first invalid answer.
    pub fn texts(&self) -> Result<NewTexts, NewComponentError> {
        use NewComponentError::{Keyword, Name, NoTask, Period, Template, Twice};
        let names = std::iter::once(&self.name).chain(self.tasks.iter().map(|task| &task.name));
        if let Some(wrong) = names.clone().find(|name| !is_name(name)) {
            return Err(Name(wrong.clone()));
        }
        if let Some(keyword) = names.clone().find(|name| is_keyword(name)) {
            return Err(Keyword(keyword.clone()));
        }
        if self.tasks.is_empty() {
            return Err(NoTask);
        }
        let mut tasks = Vec::new();
        for (index, task) in self.tasks.iter().enumerate() {
            if self.tasks[..index].iter().any(|other| other.name == task.name) {
                return Err(Twice(task.name.clone()));
            }
            let given = task.period.as_deref().map(|text| {
                period(text)
                    .ok_or_else(|| Period { task: task.name.clone(), period: text.to_owned() })
            });
            let given = given.transpose()?;
            // An estimate with which all tasks fit on one core.
            let share = given.as_ref().map_or(1e3, |(micros, _)| *micros)
                / (10.0 * self.tasks.len() as f64);
            let interfaces = self.provides.iter().chain(&self.uses);
            tasks.push(TaskData {
                name: &task.name,
                period: given.map(|(_, period)| period),
                wcet: format!("{} us", share.floor().max(1.0)),
                ports: match index {
                    0 => interfaces.flat_map(|interface| &interface.ports).collect(),
                    _ => Vec::new(),
                },
            });
        }
        let includes: Vec<&str> = {
            let all = self.provides.iter().chain(&self.uses);
            let mut out: Vec<&str> = Vec::new();
            for provided in all {
                if !out.contains(&provided.include.as_str()) {
                    out.push(&provided.include);
                }
            }
            out
        };
        let list = |all: &[NewInterface]| -> Vec<String> {
            all.iter().map(|interface| interface.name.clone()).collect()
        };
        let data = context! {
            name => self.name,
            includes,
            provides => list(&self.provides).join(", "),
            uses => list(&self.uses).join(", "),
            periodic => tasks.iter().any(|task| task.period.is_some()),
            tasks,
        };
        let expand = |text: &str| {
            let mut environment = Environment::new();
            environment.set_undefined_behavior(UndefinedBehavior::Strict);
            environment.set_trim_blocks(true);
            environment.set_lstrip_blocks(true);
            let expanded = environment.render_str(text, &data);
            expanded.map_err(|error| Template(error.to_string()))
        };
        Ok(NewTexts { specification: expand(SPECIFICATION)?, scenario: expand(SCENARIO)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn task(name: &str, period: Option<&str>) -> NewTask {
        NewTask { name: name.to_owned(), period: period.map(str::to_owned) }
    }

    #[test]
    fn answers_of_which_nothing_can_be_made_are_refused() {
        let with = |name: &str, tasks: Vec<NewTask>| NewComponent {
            name: name.to_owned(),
            tasks,
            ..NewComponent::default()
        };
        let say = |component: NewComponent| component.texts().err().map(|say| say.to_string());
        for (given, part) in [
            (with("2d", vec![task("t", None)]), "`2d` is not a valid name"),
            (with("", vec![task("t", None)]), "`` is not a valid name"),
            (with("c", vec![task("t u", None)]), "`t u` is not a valid name"),
            (with("struct", vec![task("t", None)]), "`struct` is a keyword"),
            (with("c", Vec::new()), "needs a task"),
            (with("c", vec![task("t", None), task("t", None)]), "two tasks"),
            (with("c", vec![task("t", Some("soon"))]), "`soon` is not a valid period"),
            (with("c", vec![task("t", Some("10"))]), "`10` is not a valid period"),
            (with("c", vec![task("t", Some("0 ms"))]), "`0 ms` is not a valid period"),
            (with("c", vec![task("t", Some("1.2.3 ms"))]), "is not a valid period"),
            (with("c", vec![task("t", Some("10 years"))]), "is not a valid period"),
        ] {
            let said = say(given.clone());
            assert!(said.as_ref().is_some_and(|say| say.contains(part)), "{given:?}: {said:?}");
        }
        assert_eq!(period("10ms"), Some((1e4, "10 ms".to_owned())));
        assert_eq!(period(" 0.5  s "), Some((5e5, "0.5 s".to_owned())));
    }
}
