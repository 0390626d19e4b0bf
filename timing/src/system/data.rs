//! Facts about the data of ports. Runs and recordings have the data, the timed model does not.

use std::cmp::Ordering;

use dotgen_analysis::model;
use serde_json::{Number, Value};

use crate::scn::ast::Operator;
use crate::system::ComponentId;

/// A comparison of the data of an output port, resolved in a system.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DataFact {
    pub component: ComponentId,
    /// Port, by number in the model of the component.
    pub port: model::PortId,
    /// `component.port`
    pub path: String,
    /// Names of the members that lead to the compared value.
    pub(crate) members: Vec<String>,
    pub(crate) operator: Operator,
    pub(crate) operand: String,
}

impl DataFact {
    /// Returns true if the comparison holds of the data of its port. A number that is not finite is `null` in
    /// JSON and satisfies no comparison.
    pub fn holds(&self, data: &Value) -> bool {
        let mut names = self.members.iter();
        let Some(value) = names.try_fold(data, |value, name| value.get(name)) else {
            return false;
        };
        let order = match value {
            Value::Bool(value) => equality(*value == (self.operand == "true")),
            Value::String(name) => equality(*name == self.operand),
            Value::Number(number) => order(number, &self.operand),
            _ => None,
        };
        order.is_some_and(|order| match self.operator {
            Operator::Below => order.is_lt(),
            Operator::AtMost => order.is_le(),
            Operator::Above => order.is_gt(),
            Operator::AtLeast => order.is_ge(),
            Operator::Equal => order.is_eq(),
            Operator::Unequal => order.is_ne(),
        })
    }

    /// Returns true if the comparison holds of the data in a message of a recording, which is an object: the
    /// member `value` has any other value.
    pub fn holds_in_message(&self, message: &Value) -> bool {
        self.holds(if self.members.is_empty() { &message["value"] } else { message })
    }
}

/// Returns an order for values that are only equal or not.
fn equality(equal: bool) -> Option<Ordering> {
    Some(if equal { Ordering::Equal } else { Ordering::Less })
}

fn order(number: &Number, operand: &str) -> Option<Ordering> {
    let whole = number.as_i64().map(i128::from).or(number.as_u64().map(i128::from));
    match (whole, operand.parse::<i128>()) {
        (Some(whole), Ok(operand)) => Some(whole.cmp(&operand)),
        _ => number.as_f64()?.partial_cmp(&operand.parse().ok()?),
    }
}
