//! Settings for ROS 2.

use std::collections::BTreeMap;

use dotgen_ros2::rules::{self, Rule, RuleError, Rules};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::problem::{Problem, ProblemKind, range_of};

/// Settings for components as ROS 2 nodes.
#[derive(Debug, Clone, PartialEq, Eq, Default, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case", default)]
pub struct Ros2 {
    /// Common messages of ports, by component and port. Other ports have messages of their own types.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub messages: BTreeMap<String, BTreeMap<String, Message>>,
}

/// A common message that a port has instead of a message of its own type.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Message {
    /// The message, for example `geometry_msgs/PoseStamped`.
    #[serde(rename = "type")]
    pub message: String,
    /// By field of the message, the member of the port's type, for example `pose.position = "pos"`. A field
    /// with parts takes the members of the same names.
    #[serde(default)]
    pub fields: BTreeMap<String, Value>,
    /// By field of the message of an output port, its value, for example `header.frame_id = "map"`.
    #[serde(default)]
    pub constants: BTreeMap<String, Value>,
}

impl Ros2 {
    /// The rules for ports.
    pub fn rules(&self) -> Rules {
        let rule = |message: &Message| Rule {
            message: message.message.clone(),
            fields: message.fields.clone(),
            constants: message.constants.clone(),
        };
        let components = self.messages.iter().map(|(component, ports)| {
            let ports = ports.iter().map(|(port, message)| (port.clone(), rule(message)));
            (component.clone(), ports.collect())
        });
        components.collect()
    }

    /// Errors that do not depend on specifications, with their JSON pointers.
    pub(super) fn problems(&self) -> Vec<(String, Problem)> {
        let errors = rules::check(&self.rules()).into_iter();
        let problems = errors.map(|error| (pointer(&error), problem(&error)));
        problems.collect()
    }
}

fn problem(error: &RuleError) -> Problem {
    Problem { kind: ProblemKind::BadValue, message: format!("bad value for {error}"), range: None }
}

fn pointer(error: &RuleError) -> String {
    format!("/ros2/messages/{}", error.keys.join("/"))
}

/// An error in a rule as a problem at its place in the text of a `dotgen.toml`.
pub fn rule_problem(text: &str, error: &RuleError) -> Problem {
    Problem { range: range_of(text, &pointer(error)), ..problem(error) }
}

/// A problem in words, with its place in a file.
pub fn located(path: &str, text: &str, problem: &Problem) -> String {
    let start = problem.range.as_ref().map_or(0, |range| range.start);
    let before = text.get(..start).unwrap_or_default();
    let line = before.matches('\n').count() + 1;
    format!("{path}:{line}: {}", problem.message)
}
