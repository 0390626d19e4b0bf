//! Values of ports as common messages, and common messages as values of ports.

use std::collections::BTreeMap;

use dotgen_analysis::model::{Component, PortDir, PortId, Spec, TypeId, TypeKind};
use dotgen_codegen::codels::cdr::{CdrReader, CdrWriter, Unions};
use dotgen_codegen::codels::value::{Reader, ValueError, Values};
use dotgen_syntax::suggestion::advice;
use serde_json::Value;

use crate::cdr::Stamp;
use crate::common::Leaf;
use crate::rules::{Plan, RuleError, Rules, Source, first};
use crate::scalar::{Scalar, equal, fits};

/// Maximum bytes of a list in the data of a port.
const DATA: usize = 64 << 20;

/// Conversions by the index of the port.
pub type Conversions = BTreeMap<PortId, Conversion>;

/// The conversion between the data of a port and a common message, or between the elements of their lists.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Conversion {
    /// The message: `geometry_msgs/msg/PoseStamped`.
    pub message: String,
    ty: TypeId,
    leaves: Vec<(Leaf, Source)>,
    members: Members,
    /// By leaf of a list that a member is assigned to: the conversion of its elements.
    lists: BTreeMap<usize, Conversion>,
    /// True for elements that have the same values in the port and in the message.
    is_plain: bool,
}

/// A member of a type, with the members and elements below it that are assigned.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
struct Members {
    /// The leaves of the message that the whole member is assigned to.
    leaves: Vec<usize>,
    /// By the index of the member or element.
    parts: BTreeMap<u64, Members>,
}

/// The conversions of a component's ports.
///
/// # Errors
/// A rule names a port, message, field or member that does not exist, or types that do not fit.
pub fn conversions(
    spec: &Spec,
    component: &Component,
    rules: &Rules,
) -> Result<Conversions, Vec<RuleError>> {
    let (mut out, mut errors) = (Conversions::new(), Vec::new());
    for (name, rule) in rules.get(component.name.as_str()).into_iter().flatten() {
        let keys = vec![component.name.to_string(), name.clone()];
        let mut ports = component.ports.iter_enumerated();
        let Some((index, port)) = ports.find(|(_, port)| port.name == name.as_str()) else {
            let names: Vec<&str> = component.ports.iter().map(|port| port.name.as_str()).collect();
            let component = &component.name;
            let advice = advice(name, &names);
            let why = format!("`{component}` has no port `{name}`; {advice}");
            errors.push(RuleError { keys, why });
            continue;
        };
        let constants = rule.constants.keys().next();
        if let (PortDir::In, Some(_)) = (port.dir, constants) {
            errors.push(RuleError {
                keys: [&keys[..], &["constants".to_owned()]].concat(),
                why: "an input port reads its message: remove the constants".to_owned(),
            });
        }
        match rule.plan(&keys).and_then(|plan| Conversion::new(spec, port.data, port.dir, plan, ""))
        {
            Ok(conversion) => {
                out.insert(index, conversion);
            }
            Err(some) => errors.extend(some),
        }
    }
    if errors.is_empty() { Ok(out) } else { Err(errors) }
}

impl Conversion {
    /// The conversion of a type by a plan. Messages name the type by `within`: `points[]`, empty for the type
    /// of the port.
    pub(crate) fn new(
        spec: &Spec,
        ty: TypeId,
        dir: PortDir,
        plan: Plan,
        within: &str,
    ) -> Result<Conversion, Vec<RuleError>> {
        let (mut members, mut lists) = (Members::default(), BTreeMap::new());
        let mut errors: Vec<RuleError> = Vec::new();
        for (at, (leaf, source)) in plan.leaves.iter().enumerate() {
            let Source::Member(path, keys) = source else {
                continue;
            };
            let added = find(spec, ty, path, within).and_then(|(steps, found)| {
                let path = format!("{within}{path}");
                match &leaf.elements {
                    None => fits(&spec.ty(found).kind, &path, leaf, dir)?,
                    Some(elements) => {
                        let element = element(&spec.ty(found).kind, &path, leaf, dir)?;
                        let plan = Plan::of_element(elements, keys);
                        let list =
                            Conversion::new(spec, element, dir, plan, &(path.clone() + "[]"));
                        lists.insert(at, list.map_err(|errors| errors[0].why.clone())?);
                    }
                }
                if members.add(&steps, at) || dir == PortDir::Out {
                    Ok(())
                } else {
                    Err(format!("the member `{path}` has two fields: remove one"))
                }
            });
            // A field of many leaves has one error.
            if let Err(why) = added
                && errors.iter().all(|error| error.keys != *keys)
            {
                let keys = keys.clone();
                errors.push(RuleError { keys, why });
            }
        }
        let is_plain = match plan.leaves.as_slice() {
            [(leaf, Source::Member(path, _))] if path.is_empty() => {
                equal(&spec.ty(spec.resolve_alias(ty)).kind, &leaf.base)
            }
            _ => false,
        };
        let (message, leaves) = (plan.message, plan.leaves);
        let conversion = Conversion { message, ty, leaves, members, lists, is_plain };
        if errors.is_empty() { Ok(conversion) } else { Err(errors) }
    }

    /// The message of the data of a port at a time. `None` if an optional member that is assigned is absent.
    ///
    /// # Errors
    /// The bytes are not a value of the type, or a time is not one of ROS 2.
    pub fn message(
        &self,
        spec: &Spec,
        data: &[u8],
        now: Stamp,
    ) -> Result<Option<Vec<u8>>, ValueError> {
        let mut out = CdrWriter::new(Unions::Branches);
        let is_there = self.put(spec, &mut Reader::new(data), now, &mut out)?;
        Ok(is_there.then(|| out.finish()))
    }

    /// Writes the message of a value. False if an optional member that is assigned is absent.
    fn put(
        &self,
        spec: &Spec,
        from: &mut Reader<'_>,
        now: Stamp,
        out: &mut CdrWriter,
    ) -> Result<bool, ValueError> {
        let mut found = vec![None; self.leaves.len()];
        read(spec, self.ty, Some(&self.members), from, &mut found)?;
        for (at, ((leaf, source), member)) in self.leaves.iter().zip(found).enumerate() {
            let value = match source {
                Source::Default if leaf.elements.is_some() => {
                    Scalar::List(0u32.to_ne_bytes().to_vec())
                }
                Source::Default => Scalar::default(leaf),
                Source::Constant(value) => {
                    if let (Value::Array(items), Some(elements)) = (value, &leaf.elements) {
                        put_items(items, elements, out)?;
                        continue;
                    }
                    Scalar::constant(value)
                }
                Source::Now if leaf.path.ends_with(".sec") => Scalar::Integer(now.sec.into()),
                Source::Now => Scalar::Integer(now.nanosec.into()),
                Source::Member(..) => match member {
                    Some(value) => value,
                    None => return Ok(false),
                },
            };
            let Scalar::List(bytes) = &value else {
                value.to_message(leaf, out).ok_or_else(|| wrong(leaf))?;
                continue;
            };
            let mut items = Reader::new(bytes);
            let count = u32::from_ne_bytes(items.take()?);
            out.number(count.to_ne_bytes());
            let Some(list) = self.lists.get(&at) else {
                continue;
            };
            for _ in 0..count {
                if list.is_plain {
                    out.value(Values::new(spec), list.ty, &mut items)?;
                } else if !list.put(spec, &mut items, now, out)? {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }

    /// The data of a port in a message. Members without a field are zero.
    ///
    /// # Errors
    /// The message is malformed, its time is not one of the port's type, or a list has too many bytes.
    pub fn data(&self, spec: &Spec, message: &[u8]) -> Result<Vec<u8>, ValueError> {
        let mut out = Vec::new();
        self.get(spec, &mut CdrReader::new(message, Unions::Branches)?, &mut out)?;
        Ok(out)
    }

    /// Reads a message, and appends its value of the glue.
    fn get(
        &self,
        spec: &Spec,
        from: &mut CdrReader<'_>,
        out: &mut Vec<u8>,
    ) -> Result<(), ValueError> {
        let mut values = Vec::with_capacity(self.leaves.len());
        for (at, (leaf, _)) in self.leaves.iter().enumerate() {
            let Some(elements) = &leaf.elements else {
                values.push(Scalar::of_message(leaf, from)?);
                continue;
            };
            let count = u32::from_ne_bytes(from.number()?);
            let mut items = count.to_ne_bytes().to_vec();
            // Each element needs at least one byte, so a larger count breaks off.
            for _ in 0..count {
                match self.lists.get(&at) {
                    Some(list) if list.is_plain => {
                        from.value(Values::new(spec), list.ty, &mut items)?;
                    }
                    Some(list) => list.get(spec, from, &mut items)?,
                    None => {
                        for leaf in elements {
                            Scalar::of_message(leaf, from)?;
                        }
                    }
                }
                if items.len() > DATA {
                    return Err(ValueError {
                        at: leaf.path.clone(),
                        what: format!("has to have at most {DATA} bytes in the port"),
                    });
                }
            }
            values.push(Scalar::List(items));
        }
        self.write(spec, self.ty, Some(&self.members), &values, out)
    }

    /// Writes a value of the glue. A value without assigned members is zero.
    fn write(
        &self,
        spec: &Spec,
        ty: TypeId,
        members: Option<&Members>,
        values: &[Scalar],
        out: &mut Vec<u8>,
    ) -> Result<(), ValueError> {
        let kind = &spec.ty(spec.resolve_alias(ty)).kind;
        let Some(assigned) = members else {
            out.extend(Values::new(spec).encode(ty, &Value::Null)?);
            return Ok(());
        };
        match kind {
            TypeKind::Optional { element } => {
                out.push(1);
                self.write(spec, *element, members, values, out)?;
            }
            TypeKind::Struct { members } => {
                for (at, &member) in (0..).zip(members) {
                    self.write(spec, member, assigned.parts.get(&at), values, out)?;
                }
            }
            TypeKind::Array { element, length } => {
                for at in 0..*length {
                    self.write(spec, *element, assigned.parts.get(&at), values, out)?;
                }
            }
            _ => {
                if let Some(&at) = assigned.leaves.first() {
                    let written = values[at].write(kind, out);
                    written.ok_or_else(|| wrong(&self.leaves[at].0))?;
                } else {
                    out.extend(Values::new(spec).encode(ty, &Value::Null)?);
                }
            }
        }
        Ok(())
    }
}

/// The type of the elements of a member that a list takes.
///
/// # Errors
/// In words: the member is not a list, or does not hold all lists of an input port.
fn element(kind: &TypeKind, path: &str, leaf: &Leaf, dir: PortDir) -> Result<TypeId, String> {
    let (word, field) = (kind.word(), &leaf.path);
    match kind {
        TypeKind::Sequence { element, bound: None } => Ok(*element),
        TypeKind::Sequence { element, .. } | TypeKind::Array { element, .. }
            if dir == PortDir::Out =>
        {
            Ok(*element)
        }
        TypeKind::Sequence { .. } | TypeKind::Array { .. } => Err(format!(
            "`{path}` does not hold lists of all lengths of the field `{field}`: make it a sequence without \
             bound"
        )),
        _ => Err(format!(
            "`{path}` is of type `{word}`, and the field `{field}` is a list: assign a sequence or an array"
        )),
    }
}

/// Writes a constant list.
fn put_items(items: &[Value], elements: &[Leaf], out: &mut CdrWriter) -> Result<(), ValueError> {
    out.number(u32::try_from(items.len()).unwrap_or(u32::MAX).to_ne_bytes());
    for item in items {
        for leaf in elements {
            let part = match item {
                Value::Object(table) => table.get(leaf.within_element()),
                value => Some(value),
            };
            let value = part.map_or_else(|| Scalar::default(leaf), Scalar::constant);
            value.to_message(leaf, out).ok_or_else(|| wrong(leaf))?;
        }
    }
    Ok(())
}

impl Members {
    /// Adds a leaf of a member by the indices on its path. False if the member, or a part or whole of it, has
    /// another leaf.
    fn add(&mut self, steps: &[u64], leaf: usize) -> bool {
        let is_free = self.leaves.is_empty();
        if let [step, rest @ ..] = steps {
            self.parts.entry(*step).or_default().add(rest, leaf) && is_free
        } else {
            self.leaves.push(leaf);
            is_free && self.parts.is_empty()
        }
    }
}

/// Reads the assigned members of a value of the glue. Those of an absent optional are not found.
fn read(
    spec: &Spec,
    ty: TypeId,
    members: Option<&Members>,
    from: &mut Reader<'_>,
    found: &mut [Option<Scalar>],
) -> Result<(), ValueError> {
    let kind = &spec.ty(spec.resolve_alias(ty)).kind;
    let skip =
        |from: &mut Reader<'_>| CdrWriter::new(Unions::Branches).value(Values::new(spec), ty, from);
    let Some(assigned) = members else {
        return skip(from);
    };
    match kind {
        TypeKind::Optional { element } => {
            if from.take::<1>()? != [0] {
                read(spec, *element, members, from, found)?;
            }
            return Ok(());
        }
        TypeKind::Sequence { .. } | TypeKind::Array { .. } if !assigned.leaves.is_empty() => {
            let mut behind = from.clone();
            skip(&mut behind)?;
            let mut list = match kind {
                TypeKind::Array { length, .. } => {
                    u32::try_from(*length).unwrap_or(u32::MAX).to_ne_bytes().to_vec()
                }
                _ => Vec::new(),
            };
            list.extend(from.clone().some(from.left() - behind.left())?);
            for &leaf in &assigned.leaves {
                found[leaf] = Some(Scalar::List(list.clone()));
            }
        }
        _ => {}
    }
    match kind {
        TypeKind::Struct { members } => {
            for (at, &member) in (0..).zip(members) {
                read(spec, member, assigned.parts.get(&at), from, found)?;
            }
        }
        TypeKind::Array { element, length } if !assigned.parts.is_empty() => {
            for at in 0..*length {
                read(spec, *element, assigned.parts.get(&at), from, found)?;
            }
        }
        TypeKind::Sequence { .. } | TypeKind::Array { .. } => skip(from)?,
        _ => {
            let value = Scalar::read(kind, from)?;
            for &leaf in &assigned.leaves {
                found[leaf] = Some(value.clone());
            }
        }
    }
    Ok(())
}

/// The member at a path: the indices that lead to it, and its type without optionals. `nanosec` is also found
/// as `nsec`.
pub(crate) fn find(
    spec: &Spec,
    ty: TypeId,
    path: &str,
    within: &str,
) -> Result<(Vec<u64>, TypeId), String> {
    let (mut ty, mut steps) = (present(spec, ty), Vec::new());
    let start = path.len() - path.trim_start_matches('.').len();
    let mut at = start;
    while at < path.len() {
        let so_far = match &path[start..at] {
            "" if within.is_empty() => "the port's type".to_owned(),
            known => format!("`{within}{known}`"),
        };
        let begin = at + usize::from(path[at..].starts_with('.'));
        let step = first(&path[begin..]);
        if path[begin..].starts_with('.') || step.is_empty() {
            return Err(format!("`{path}` has a point without a member after it"));
        }
        let index = step.strip_prefix('[').and_then(|rest| rest.strip_suffix(']'));
        let index = index.and_then(|digits| digits.parse::<u64>().ok());
        at = begin + step.len();
        let (index, inner) = match (&spec.ty(ty).kind, index) {
            (TypeKind::Struct { members }, None) => {
                let names = members.iter();
                let names =
                    names.map(|&member| spec.ty(member).name.as_deref().unwrap_or_default());
                let names: Vec<&str> = names.collect();
                let named = |name: &str| names.iter().position(|&candidate| candidate == name);
                let short = || named("nsec").filter(|_| step == "nanosec");
                let found = named(step).or_else(short);
                let found = found.ok_or_else(|| {
                    format!("{so_far} has no member `{step}`; {}", advice(step, &names))
                })?;
                (found as u64, members[found])
            }
            (TypeKind::Array { element, length }, Some(index)) if index < *length => {
                (index, *element)
            }
            (TypeKind::Array { length, .. }, _) => {
                let last = length.saturating_sub(1);
                return Err(format!(
                    "{so_far} is an array and has no `{step}`: name an element, `[0]` to `[{last}]`"
                ));
            }
            (kind @ (TypeKind::Sequence { .. } | TypeKind::Union { .. }), _) => {
                let word = kind.word();
                return Err(format!(
                    "{so_far} is a `{word}`: assign a member that every value has"
                ));
            }
            (kind, _) => {
                let word = kind.word();
                return Err(format!(
                    "{so_far} is a `{word}` and has no `{step}`: shorten the path"
                ));
            }
        };
        steps.push(index);
        ty = present(spec, inner);
    }
    Ok((steps, ty))
}

/// The type without aliases and optionals.
pub(crate) fn present(spec: &Spec, ty: TypeId) -> TypeId {
    let ty = spec.resolve_alias(ty);
    match &spec.ty(ty).kind {
        TypeKind::Optional { element } => present(spec, *element),
        _ => ty,
    }
}

fn wrong(leaf: &Leaf) -> ValueError {
    ValueError {
        at: leaf.path.clone(),
        what: "has to be a time: seconds of 32 bits, and nanoseconds of less than a second"
            .to_owned(),
    }
}
