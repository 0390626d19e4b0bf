//! Type descriptions of ROS 2 and their hashes (RIHS01).

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use sha2::{Digest as _, Sha256};

/// The type of a field, without its number of elements.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Base {
    Int8,
    Uint8,
    Int16,
    Uint16,
    Int32,
    Uint32,
    Int64,
    Uint64,
    Float32,
    Float64,
    Bool,
    String,
    /// A string of at most so many bytes.
    BoundedString(u64),
    /// A message: `or_t3d/msg/Pos`.
    Nested(String),
}

impl Base {
    /// The name in `.msg` files; a nested message is `or_t3d/Pos`.
    pub fn text(&self) -> String {
        match self {
            Base::Int8 => "int8".to_owned(),
            Base::Uint8 => "uint8".to_owned(),
            Base::Int16 => "int16".to_owned(),
            Base::Uint16 => "uint16".to_owned(),
            Base::Int32 => "int32".to_owned(),
            Base::Uint32 => "uint32".to_owned(),
            Base::Int64 => "int64".to_owned(),
            Base::Uint64 => "uint64".to_owned(),
            Base::Float32 => "float32".to_owned(),
            Base::Float64 => "float64".to_owned(),
            Base::Bool => "bool".to_owned(),
            Base::String => "string".to_owned(),
            Base::BoundedString(bound) => format!("string<={bound}"),
            Base::Nested(name) => name.replacen("/msg/", "/", 1),
        }
    }

    /// The id in type descriptions.
    fn id(&self) -> u8 {
        match self {
            Base::Nested(_) => 1,
            Base::Int8 => 2,
            Base::Uint8 => 3,
            Base::Int16 => 4,
            Base::Uint16 => 5,
            Base::Int32 => 6,
            Base::Uint32 => 7,
            Base::Int64 => 8,
            Base::Uint64 => 9,
            Base::Float32 => 10,
            Base::Float64 => 11,
            Base::Bool => 15,
            Base::String => 17,
            Base::BoundedString(_) => 21,
        }
    }
}

/// The number of elements of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Count {
    /// A single value.
    One,
    /// An array.
    Exactly(u64),
    /// A sequence of at most so many.
    AtMost(u64),
    /// A sequence.
    Any,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FieldType {
    /// The type of each element.
    pub base: Base,
    /// The number of elements.
    pub count: Count,
}

impl FieldType {
    /// A message.
    pub fn nested(name: impl Into<String>) -> Self {
        Base::Nested(name.into()).into()
    }

    /// The type in `.msg` files.
    pub fn text(&self) -> String {
        let base = self.base.text();
        match self.count {
            Count::One => base,
            Count::Exactly(number) => format!("{base}[{number}]"),
            Count::AtMost(number) => format!("{base}[<={number}]"),
            Count::Any => format!("{base}[]"),
        }
    }
}

impl From<Base> for FieldType {
    fn from(base: Base) -> Self {
        FieldType { base, count: Count::One }
    }
}

/// A field of a message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Field {
    pub name: String,
    pub ty: FieldType,
    /// The message with the constants of its enumeration. It is not part of the description.
    pub constants: Option<String>,
}

impl Field {
    pub fn new(name: impl Into<String>, ty: impl Into<FieldType>) -> Self {
        Field { name: name.into(), ty: ty.into(), constants: None }
    }
}

/// Messages, services and actions by name: `or_t3d/msg/Pos`. The request, response and event messages of a
/// service are types too.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Types(BTreeMap<String, Vec<Field>>);

impl Types {
    /// The types of ROS 2 that services and actions need.
    pub fn standard() -> Self {
        let mut out = Types::default();
        let bytes = || FieldType { base: Base::Uint8, count: Count::Exactly(16) };
        let list =
            |name: &str| FieldType { base: Base::Nested(name.to_owned()), count: Count::Any };
        let field = |name: &str, ty: FieldType| Field::new(name, ty);
        let nested = |name: &str| FieldType::nested(name);
        let time = vec![field("sec", Base::Int32.into()), field("nanosec", Base::Uint32.into())];
        out.add(TIME, time);
        out.add(UUID, vec![field("uuid", bytes())]);
        let event = vec![
            field("event_type", Base::Uint8.into()),
            field("stamp", nested(TIME)),
            field("client_gid", bytes()),
            field("sequence_number", Base::Int64.into()),
        ];
        out.add(EVENT, event);
        let goal = vec![field("goal_id", nested(UUID)), field("stamp", nested(TIME))];
        out.add(GOAL_INFO, goal);
        let status =
            vec![field("goal_info", nested(GOAL_INFO)), field("status", Base::Int8.into())];
        out.add(GOAL_STATUS, status);
        out.add(STATUS_ARRAY, vec![field("status_list", list(GOAL_STATUS))]);
        let response = vec![
            field("return_code", Base::Int8.into()),
            field("goals_canceling", list(GOAL_INFO)),
        ];
        out.service(CANCEL_GOAL, vec![field("goal_info", nested(GOAL_INFO))], response);
        out
    }

    /// Adds or replaces a message. A message without fields has one that holds its place.
    pub fn add(&mut self, name: &str, mut fields: Vec<Field>) {
        if fields.is_empty() {
            fields.push(Field::new(FILLER, Base::Uint8));
        }
        self.0.insert(name.to_owned(), fields);
    }

    /// Adds a service with its messages.
    pub fn service(&mut self, name: &str, request: Vec<Field>, response: Vec<Field>) {
        let [request_name, response_name, event_name] =
            ["Request", "Response", "Event"].map(|text| format!("{name}_{text}"));
        self.add(&request_name, request);
        self.add(&response_name, response);
        let optional =
            |name: &str| FieldType { base: Base::Nested(name.to_owned()), count: Count::AtMost(1) };
        let event = vec![
            Field::new("info", FieldType::nested(EVENT)),
            Field::new("request", optional(&request_name)),
            Field::new("response", optional(&response_name)),
        ];
        self.add(&event_name, event);
        let service = vec![
            Field::new("request_message", FieldType::nested(request_name)),
            Field::new("response_message", FieldType::nested(response_name)),
            Field::new("event_message", FieldType::nested(event_name)),
        ];
        self.add(name, service);
    }

    /// Adds an action with its services and messages.
    pub fn action(
        &mut self,
        name: &str,
        goal: Vec<Field>,
        result: Vec<Field>,
        feedback: Vec<Field>,
    ) {
        let part = |text: &str| FieldType::nested(format!("{name}_{text}"));
        let parts = [("Goal", goal), ("Result", result), ("Feedback", feedback)];
        for (part, fields) in parts {
            self.add(&format!("{name}_{part}"), fields);
        }
        let id = || Field::new("goal_id", FieldType::nested(UUID));
        let accepted =
            vec![Field::new("accepted", Base::Bool), Field::new("stamp", FieldType::nested(TIME))];
        let request = vec![id(), Field::new("goal", part("Goal"))];
        self.service(&format!("{name}_SendGoal"), request, accepted);
        let response = vec![Field::new("status", Base::Int8), Field::new("result", part("Result"))];
        self.service(&format!("{name}_GetResult"), vec![id()], response);
        let message = vec![id(), Field::new("feedback", part("Feedback"))];
        self.add(&format!("{name}_FeedbackMessage"), message);
        let action = [
            ("goal", "Goal"),
            ("result", "Result"),
            ("feedback", "Feedback"),
            ("send_goal_service", "SendGoal"),
            ("get_result_service", "GetResult"),
            ("feedback_message", "FeedbackMessage"),
        ];
        let action = action.map(|(field, action)| Field::new(field, part(action)));
        self.add(name, action.to_vec());
    }

    /// The fields of a type.
    pub fn fields(&self, name: &str) -> Option<&[Field]> {
        self.0.get(name).map(Vec::as_slice)
    }

    /// All names, in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }

    /// The types that a type refers to, also indirectly, in order and without itself.
    pub(crate) fn referenced(&self, name: &str) -> BTreeSet<&str> {
        let mut out = BTreeSet::new();
        let mut waiting = vec![name];
        while let Some(name) = waiting.pop() {
            for field in self.fields(name).unwrap_or_default() {
                if let Base::Nested(name) = &field.ty.base
                    && out.insert(name.as_str())
                {
                    waiting.push(name);
                }
            }
        }
        out.remove(name);
        out
    }

    /// The hash of a type: `RIHS01_…`. Every type that it refers to has to be there.
    pub fn hash(&self, name: &str) -> String {
        let referenced: Vec<String> =
            self.referenced(name).into_iter().map(|name| self.json(name)).collect();
        let text = format!(
            "{{\"type_description\": {}, \"referenced_type_descriptions\": [{}]}}",
            self.json(name),
            referenced.join(", ")
        );
        let mut out = "RIHS01_".to_owned();
        for byte in Sha256::digest(text) {
            let _ = write!(out, "{byte:02x}");
        }
        out
    }

    /// The description of one type. Names need no escapes.
    fn json(&self, name: &str) -> String {
        let fields = self.fields(name).unwrap_or_default().iter().map(|field| {
            let (offset, capacity) = match field.ty.count {
                Count::One => (0, 0),
                Count::Exactly(number) => (48, number),
                Count::AtMost(number) => (96, number),
                Count::Any => (144, 0),
            };
            let (string, nested) = match &field.ty.base {
                Base::BoundedString(bound) => (*bound, ""),
                Base::Nested(name) => (0, name.as_str()),
                _ => (0, ""),
            };
            format!(
                "{{\"name\": \"{}\", \"type\": {{\"type_id\": {}, \"capacity\": {capacity}, \
                 \"string_capacity\": {string}, \"nested_type_name\": \"{nested}\"}}}}",
                field.name,
                field.ty.base.id() + offset,
            )
        });
        let fields: Vec<String> = fields.collect();
        format!("{{\"type_name\": \"{name}\", \"fields\": [{}]}}", fields.join(", "))
    }
}

/// The field of a message without fields.
pub const FILLER: &str = "structure_needs_at_least_one_member";
/// A moment.
pub const TIME: &str = "builtin_interfaces/msg/Time";
/// The id of a goal.
pub const UUID: &str = "unique_identifier_msgs/msg/UUID";
/// A goal with the moment of its acceptance.
pub const GOAL_INFO: &str = "action_msgs/msg/GoalInfo";
pub const STATUS_ARRAY: &str = "action_msgs/msg/GoalStatusArray";
/// The service that cancels goals.
pub const CANCEL_GOAL: &str = "action_msgs/srv/CancelGoal";
const GOAL_STATUS: &str = "action_msgs/msg/GoalStatus";
const EVENT: &str = "service_msgs/msg/ServiceEventInfo";
