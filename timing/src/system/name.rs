//! Names of codels and threads: their parts as data, their text in one place.

use std::fmt;
use std::ops::Deref;
use std::sync::Arc;

use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

/// The name of a codel: `component.owner.state`, `component.service.codel`, or `component.service` for a step
/// of a control task without a codel. A clone is cheap.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CodelName {
    text: Arc<str>,
    /// Start of the name of the owner.
    owner: usize,
    /// Start of the last name.
    own: usize,
}

impl CodelName {
    /// Returns the name of a codel of a task or service.
    pub fn new(component: &str, owner: &str, own: &str) -> CodelName {
        CodelName {
            text: format!("{component}.{owner}.{own}").into(),
            owner: component.len() + 1,
            own: component.len() + owner.len() + 2,
        }
    }

    /// Returns the name of a step of a control task for a service.
    pub fn of_service(component: &str, service: &str) -> CodelName {
        CodelName {
            text: format!("{component}.{service}").into(),
            owner: component.len() + 1,
            own: component.len() + 1,
        }
    }

    /// Returns the last name: the state, or else the codel or the service.
    pub fn own(&self) -> &str {
        &self.text[self.own..]
    }

    /// Returns the name inside the component: `owner.state`.
    pub fn inside(&self) -> &str {
        &self.text[self.owner..]
    }
}

impl Deref for CodelName {
    type Target = str;

    fn deref(&self) -> &str {
        &self.text
    }
}

impl fmt::Display for CodelName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.text)
    }
}

impl Serialize for CodelName {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(&self.text)
    }
}

/// The name of a thread: a task, the control task of a component, or a client. As text: `component.task`, or
/// the component or client alone.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ThreadName {
    /// Component, or client.
    pub component: String,
    /// Task, without its component; `None` for a control task and for a client.
    pub task: Option<String>,
}

impl ThreadName {
    pub fn of_task(component: &str, task: &str) -> ThreadName {
        ThreadName { component: component.to_owned(), task: Some(task.to_owned()) }
    }

    /// Returns the name of the control task of a component, or of a client.
    pub fn of_component(component: &str) -> ThreadName {
        ThreadName { component: component.to_owned(), task: None }
    }

    /// Returns the last name: the task, or else the component or client.
    pub fn own(&self) -> &str {
        self.task.as_deref().unwrap_or(&self.component)
    }

    /// Writes the parts of the name as fields.
    pub(crate) fn serialize_parts<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(None)?;
        map.serialize_entry("component", &self.component)?;
        if let Some(task) = &self.task {
            map.serialize_entry("task", task)?;
        }
        map.end()
    }
}

impl fmt::Display for ThreadName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.task {
            Some(task) => f.pad(&format!("{}.{task}", self.component)),
            None => f.pad(&self.component),
        }
    }
}

impl Serialize for ThreadName {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_of_a_name_are_those_it_was_made_of() {
        let name = CodelName::new("lift", "report", "start");
        assert_eq!(
            (name.to_string(), name.inside(), name.own()),
            ("lift.report.start".into(), "report.start", "start")
        );
        let service = CodelName::of_service("lift", "abort");
        assert_eq!(
            (service.to_string(), service.inside(), service.own()),
            ("lift.abort".into(), "abort", "abort")
        );
        let task = ThreadName::of_task("lift", "control");
        assert_eq!((task.to_string(), task.own()), ("lift.control".into(), "control"));
    }
}
