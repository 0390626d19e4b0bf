//! Rules of `dotgen.toml`: the common message that a port has, and the sources of its fields.

use std::collections::{BTreeMap, BTreeSet};

use dotgen_syntax::suggestion::advice;
use serde_json::Value;

use crate::common::{self, Leaf, SECOND};
use crate::description::Base;
use crate::scalar::integers;

/// Rules by component and port.
pub type Rules = BTreeMap<String, BTreeMap<String, Rule>>;

/// The common message of a port. Tables of fields may be nested: `pose = { position = "pos" }` is
/// `"pose.position" = "pos"`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Rule {
    /// The message: `geometry_msgs/PoseStamped`.
    pub message: String,
    /// Members of the port's type by field.
    pub fields: BTreeMap<String, Value>,
    /// Values by field.
    pub constants: BTreeMap<String, Value>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RuleError {
    /// The keys below the table of all rules: component, port and further ones.
    pub keys: Vec<String>,
    /// The error and the remedy.
    pub why: String,
}

impl std::fmt::Display for RuleError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "`ros2.messages")?;
        for key in &self.keys {
            if key.contains(|c: char| !c.is_ascii_alphanumeric() && c != '_' && c != '-') {
                write!(f, ".\"{key}\"")?;
            } else {
                write!(f, ".{key}")?;
            }
        }
        write!(f, "`: {}", self.why)
    }
}

impl std::error::Error for RuleError {}

/// The source of a leaf of a message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Source {
    /// None: the leaf has its default.
    Default,
    /// A fixed value.
    Constant(Value),
    /// A path within the port's type, and the keys that assign it.
    Member(String, Vec<String>),
    /// The time of publication.
    Now,
}

/// A rule whose message and fields exist.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Plan {
    /// The full name of the message.
    pub(crate) message: String,
    /// All leaves of the message, in the order of its payload.
    pub(crate) leaves: Vec<(Leaf, Source)>,
}

impl Plan {
    /// The elements of a list, whose members have the names of the fields.
    pub(crate) fn of_element(elements: &[Leaf], keys: &[String]) -> Plan {
        let leaves = elements.iter().map(|leaf| {
            let path = match leaf.within_element() {
                "" => String::new(),
                path => format!(".{path}"),
            };
            (leaf.clone(), Source::Member(path, keys.to_vec()))
        });
        Plan { message: String::new(), leaves: leaves.collect() }
    }
}

/// Errors that do not depend on a specification.
pub fn check(rules: &Rules) -> Vec<RuleError> {
    let ports = rules.iter().flat_map(|(component, ports)| {
        let rules = ports.iter();
        rules.filter_map(|(port, rule)| rule.plan(&[component.clone(), port.clone()]).err())
    });
    ports.flatten().collect()
}

impl Rule {
    /// The sources of all leaves. `keys` are those of the rule.
    pub(crate) fn plan(&self, keys: &[String]) -> Result<Plan, Vec<RuleError>> {
        let below = |key: &str| [keys, &[key.to_owned()]].concat();
        let message = common::full_name(&self.message)
            .map_err(|why| vec![RuleError { keys: below("type"), why }])?;
        let leaves = common::leaves(&message).into_iter();
        let mut leaves: Vec<_> = leaves.map(|leaf| (leaf, Source::Default)).collect();
        let mut errors = Vec::new();
        let tables = [("fields", &self.fields), ("constants", &self.constants)];
        for (table, entries) in tables {
            for entry in flat(entries, &below(table), "") {
                let assigned = match table {
                    "fields" => assign_member(&entry, &mut leaves),
                    _ => assign_constant(&entry, &mut leaves),
                };
                let keys = entry.keys;
                errors.extend(assigned.err().map(|why| RuleError { keys, why }));
            }
        }
        if flat(&self.fields, &[], "").is_empty() {
            let why = "no field has a source: add a table `fields`, such as \
                       `fields = { header.stamp = \"ts\" }`";
            let (keys, why) = (keys.to_vec(), why.to_owned());
            errors.push(RuleError { keys, why });
        }
        let stamp = |leaf: &Leaf| leaf.path.starts_with("header.stamp.");
        if leaves.iter().all(|(leaf, source)| !stamp(leaf) || *source == Source::Default) {
            let stamps = leaves.iter_mut().filter(|(leaf, _)| stamp(leaf));
            stamps.for_each(|(_, source)| *source = Source::Now);
        }
        if errors.is_empty() { Ok(Plan { message, leaves }) } else { Err(errors) }
    }
}

/// An entry of tables within tables.
struct Entry<'r> {
    keys: Vec<String>,
    /// The field: the keys, joined by points.
    field: String,
    value: &'r Value,
}

fn flat<'r>(
    table: impl IntoIterator<Item = (&'r String, &'r Value)>,
    keys: &[String],
    within: &str,
) -> Vec<Entry<'r>> {
    let entries = table.into_iter().flat_map(|(key, value)| {
        let keys = [keys, std::slice::from_ref(key)].concat();
        let field = format!("{within}{key}");
        match value {
            Value::Object(inner) => flat(inner, &keys, &format!("{field}.")),
            _ => vec![Entry { keys, field, value }],
        }
    });
    entries.collect()
}

fn assign_member(entry: &Entry<'_>, leaves: &mut [(Leaf, Source)]) -> Result<(), String> {
    let Value::String(member) = entry.value else {
        return Err(
            "expected a member of the port's type, such as \"pos.x\"; values are in `constants`"
                .to_owned(),
        );
    };
    for at in targets(&entry.field, leaves)? {
        let member = format!("{member}{}", &leaves[at].0.path[entry.field.len()..]);
        assign(&mut leaves[at], Source::Member(member, entry.keys.clone()))?;
    }
    Ok(())
}

/// Assigns a value, or each value of a list to one leaf.
fn assign_constant(entry: &Entry<'_>, leaves: &mut [(Leaf, Source)]) -> Result<(), String> {
    let targets = targets(&entry.field, leaves)?;
    let is_list = targets.iter().any(|&at| leaves[at].0.elements.is_some());
    let values = match entry.value {
        Value::Array(values) if !is_list => values.as_slice(),
        value => std::slice::from_ref(value),
    };
    if targets.len() != values.len() {
        let field = &entry.field;
        return Err(match targets.len() {
            1 => format!("`{field}` has one value: give no list"),
            number => format!("`{field}` has {number} values: give a list of them"),
        });
    }
    for (at, value) in targets.into_iter().zip(values) {
        check_constant(&leaves[at].0, value)?;
        assign(&mut leaves[at], Source::Constant(value.clone()))?;
    }
    Ok(())
}

/// Accepts a value for a leaf.
fn check_constant(leaf: &Leaf, value: &Value) -> Result<(), String> {
    if let Some(elements) = &leaf.elements {
        let Value::Array(items) = value else {
            return Err(format!("expected a list of all values of `{}`, not {value}", leaf.path));
        };
        return items.iter().try_for_each(|item| check_item(leaf, elements, item));
    }
    let (fits, expected) = match (&leaf.base, integers(&leaf.base)) {
        (_, Some((from, to))) => {
            let is_nanoseconds = leaf.is_time && leaf.base == Base::Uint32;
            let to = if is_nanoseconds { i128::from(SECOND) - 1 } else { to };
            let number = value.as_number().and_then(serde_json::Number::as_i128);
            let fits = number.is_some_and(|number| (from..=to).contains(&number));
            (fits, format!("a whole number from {from} to {to}"))
        }
        (Base::Float32 | Base::Float64, _) => (value.is_number(), "a number".to_owned()),
        (Base::Bool, _) => (value.is_boolean(), "true or false".to_owned()),
        _ => (value.is_string(), "a string".to_owned()),
    };
    if fits { Ok(()) } else { Err(format!("expected {expected}, not {value}")) }
}

/// Accepts a value for an element of a list: a table for a message.
fn check_item(list: &Leaf, elements: &[Leaf], item: &Value) -> Result<(), String> {
    if let [one] = elements
        && one.within_element().is_empty()
    {
        return check_constant(one, item);
    }
    let names: Vec<&str> = elements.iter().map(Leaf::within_element).collect();
    let Value::Object(table) = item else {
        let (path, base) = (&list.path, list.base.text());
        return Err(format!("expected elements of `{path}`, of type `{base}`, not {item}"));
    };
    for (key, value) in table {
        let leaf = names.iter().position(|name| name == key).ok_or_else(|| {
            format!("an element of `{}` has no field `{key}`; {}", list.path, advice(key, &names))
        })?;
        check_constant(&elements[leaf], value)?;
    }
    Ok(())
}

fn assign((leaf, source): &mut (Leaf, Source), value: Source) -> Result<(), String> {
    if *source != Source::Default {
        let path = &leaf.path;
        return Err(format!("`{path}` has two sources: remove one"));
    }
    *source = value;
    Ok(())
}

/// The leaves of a field, which is a leaf itself, or a message or array.
fn targets(field: &str, leaves: &[(Leaf, Source)]) -> Result<Vec<usize>, String> {
    let found: Vec<usize> =
        (0..leaves.len()).filter(|&at| below(field, &leaves[at].0.path).is_some()).collect();
    if found.is_empty() { Err(unknown(field, leaves)) } else { Ok(found) }
}

/// The rest of the path of a leaf of a field.
fn below<'p>(field: &str, path: &'p str) -> Option<&'p str> {
    let rest = path.strip_prefix(field)?;
    (rest.is_empty() || rest.starts_with(['.', '['])).then_some(rest)
}

/// A message about a field that does not exist.
fn unknown(field: &str, leaves: &[(Leaf, Source)]) -> String {
    let ends = field.match_indices(['.', '[']).map(|(at, _)| &field[..at]);
    let children = |known: &str| -> BTreeSet<&str> {
        let rests = leaves.iter().filter_map(|(leaf, _)| match known {
            "" => Some(leaf.path.as_str()),
            _ => below(known, &leaf.path),
        });
        rests.map(first).collect()
    };
    let known = ends.rev().find(|end| !children(end).is_empty());
    let known = known.unwrap_or_default();
    let names: Vec<&str> = children(known).into_iter().collect();
    let wanted = field[known.len()..].trim_start_matches('.');
    let of = match known {
        "" => "the message".to_owned(),
        known => format!("`{known}`"),
    };
    match names.as_slice() {
        [""] => format!("{of} has no parts: assign it as a whole"),
        [first, ..] if first.starts_with('[') => {
            let last = names.len() - 1;
            format!("{of} has no element `{wanted}`: there are `[0]` to `[{last}]`")
        }
        names => {
            let wanted = wanted.split(['.', '[']).next().unwrap_or(wanted);
            format!("{of} has no field `{wanted}`; {}", advice(wanted, names))
        }
    }
}

/// The first name or index of a path.
pub(crate) fn first(path: &str) -> &str {
    let path = path.strip_prefix('.').unwrap_or(path);
    let end =
        if path.starts_with('[') { path.find(']').map(|at| at + 1) } else { path.find(['.', '[']) };
    &path[..end.unwrap_or(path.len())]
}
