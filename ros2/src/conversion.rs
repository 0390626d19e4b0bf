//! Values of ports as common messages, and common messages as values of ports.

use std::collections::BTreeMap;

use dotgen_analysis::model::{Component, Port, PortDir, Spec, TypeId, TypeKind};
use dotgen_codegen::codels::cdr::{CdrReader, CdrWriter, Unions};
use dotgen_codegen::codels::value::{Reader, ValueError, Values};
use dotgen_syntax::suggestion::advice;
use serde_json::Value;

use crate::cdr::Stamp;
use crate::common::{Leaf, SECOND};
use crate::description::Base;
use crate::rules::{Plan, RuleError, Rules, Source, first};
use crate::scalar::{Scalar, fits};

/// Conversions by the index of the port.
pub type Conversions = BTreeMap<u32, Conversion>;

/// The conversion between the data of a port and a common message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Conversion {
    /// The message: `geometry_msgs/msg/PoseStamped`.
    pub message: String,
    ty: TypeId,
    leaves: Vec<(Leaf, Source)>,
    members: Members,
}

/// The members of a type that are assigned.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Members {
    /// A number or string, with the leaves of the message.
    Scalar(Vec<usize>),
    /// By the index of the member or element.
    Parts(BTreeMap<u64, Members>),
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
        let mut ports = (0u32..).zip(&component.ports);
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
        match rule.plan(&keys).and_then(|plan| Conversion::new(spec, port, plan)) {
            Ok(conversion) => {
                out.insert(index, conversion);
            }
            Err(some) => errors.extend(some),
        }
    }
    if errors.is_empty() { Ok(out) } else { Err(errors) }
}

impl Conversion {
    fn new(spec: &Spec, port: &Port, plan: Plan) -> Result<Conversion, Vec<RuleError>> {
        let mut members = Members::Parts(BTreeMap::new());
        let mut errors: Vec<RuleError> = Vec::new();
        for (at, (leaf, source)) in plan.leaves.iter().enumerate() {
            let Source::Member(path, keys) = source else {
                continue;
            };
            let added = find(spec, port.data, path).and_then(|(steps, ty)| {
                fits(&spec.ty(ty).kind, path, leaf, port.dir)?;
                if members.add(&steps, at) || port.dir == PortDir::Out {
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
        if errors.is_empty() {
            Ok(Conversion { message: plan.message, ty: port.data, leaves: plan.leaves, members })
        } else {
            Err(errors)
        }
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
        let mut found = vec![None; self.leaves.len()];
        read(spec, self.ty, Some(&self.members), &mut Reader::new(data), &mut found)?;
        let mut out = CdrWriter::new(Unions::Branches);
        for ((leaf, source), member) in self.leaves.iter().zip(found) {
            let value = match source {
                Source::Default if leaf.base == Base::String => Scalar::Text(Vec::new()),
                Source::Default => Scalar::Integer(leaf.default.into()),
                Source::Constant(value) => Scalar::constant(value),
                Source::Now if leaf.path.ends_with(".sec") => Scalar::Integer(now.sec.into()),
                Source::Now => Scalar::Integer(now.nanosec.into()),
                Source::Member(..) => match member {
                    Some(value) => value,
                    None => return Ok(None),
                },
            };
            let wrong = || wrong(leaf);
            match leaf.base {
                Base::Float64 => out.number(value.float().to_ne_bytes()),
                Base::Int32 => {
                    let number = i32::try_from(value.integer()).map_err(|_| wrong())?;
                    out.number(number.to_ne_bytes());
                }
                Base::Uint32 => {
                    let number = u32::try_from(value.integer()).ok();
                    let number = number.filter(|number| !leaf.is_time || *number < SECOND);
                    out.number(number.ok_or_else(wrong)?.to_ne_bytes());
                }
                _ => out.text(value.text()),
            }
        }
        Ok(Some(out.finish()))
    }

    /// The data of a port in a message. Members without a field are zero.
    ///
    /// # Errors
    /// The message is malformed, or its time is not one of the port's type.
    pub fn data(&self, spec: &Spec, message: &[u8]) -> Result<Vec<u8>, ValueError> {
        let mut from = CdrReader::new(message, Unions::Branches)?;
        let mut values = Vec::new();
        for (leaf, _) in &self.leaves {
            values.push(match leaf.base {
                Base::Float64 => Scalar::Float(f64::from_ne_bytes(from.number()?)),
                Base::Int32 => Scalar::Integer(i32::from_ne_bytes(from.number()?).into()),
                Base::Uint32 => Scalar::Integer(u32::from_ne_bytes(from.number()?).into()),
                _ => Scalar::Text(from.text()?.to_vec()),
            });
        }
        let mut out = Vec::new();
        self.write(spec, self.ty, Some(&self.members), &values, &mut out)?;
        Ok(out)
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
        match (kind, members) {
            (TypeKind::Optional { element }, Some(_)) => {
                out.push(1);
                self.write(spec, *element, members, values, out)?;
            }
            (TypeKind::Struct { members }, Some(Members::Parts(parts))) => {
                for (at, &member) in (0..).zip(members) {
                    self.write(spec, member, parts.get(&at), values, out)?;
                }
            }
            (TypeKind::Array { element, length }, Some(Members::Parts(parts))) => {
                for at in 0..*length {
                    self.write(spec, *element, parts.get(&at), values, out)?;
                }
            }
            (_, Some(Members::Scalar(leaves))) => {
                let at = leaves[0];
                let written = values[at].write(kind, out);
                written.ok_or_else(|| wrong(&self.leaves[at].0))?;
            }
            _ => out.extend(Values::new(spec).encode(ty, &Value::Null)?),
        }
        Ok(())
    }
}

impl Members {
    /// Adds a member by the indices on its path, and its leaf. False if the member has another leaf.
    fn add(&mut self, steps: &[u64], leaf: usize) -> bool {
        match (self, steps) {
            (Members::Parts(parts), [step, rest @ ..]) => {
                let empty = match rest {
                    [] => Members::Scalar(Vec::new()),
                    _ => Members::Parts(BTreeMap::new()),
                };
                parts.entry(*step).or_insert(empty).add(rest, leaf)
            }
            (Members::Scalar(leaves), _) => {
                leaves.push(leaf);
                leaves.len() == 1
            }
            (parts, []) => {
                *parts = Members::Scalar(vec![leaf]);
                true
            }
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
    match (kind, members) {
        (TypeKind::Optional { element }, Some(_)) => {
            if from.take::<1>()? != [0] {
                read(spec, *element, members, from, found)?;
            }
        }
        (TypeKind::Struct { members }, Some(Members::Parts(parts))) => {
            for (at, &member) in (0..).zip(members) {
                read(spec, member, parts.get(&at), from, found)?;
            }
        }
        (TypeKind::Array { element, length }, Some(Members::Parts(parts))) => {
            for at in 0..*length {
                read(spec, *element, parts.get(&at), from, found)?;
            }
        }
        (_, Some(Members::Scalar(leaves))) => {
            let value = Scalar::read(kind, from)?;
            for &leaf in leaves {
                found[leaf] = Some(value.clone());
            }
        }
        // The value is skipped.
        _ => CdrWriter::new(Unions::Branches).value(Values::new(spec), ty, from)?,
    }
    Ok(())
}

/// The member at a path: the indices that lead to it, and its type without optionals. `nanosec` is also found
/// as `nsec`.
fn find(spec: &Spec, ty: TypeId, path: &str) -> Result<(Vec<u64>, TypeId), String> {
    let (mut ty, mut steps) = (present(spec, ty), Vec::new());
    let start = path.len() - path.trim_start_matches('.').len();
    let mut at = start;
    while at < path.len() {
        let so_far = match &path[start..at] {
            "" => "the port's type".to_owned(),
            known => format!("`{known}`"),
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
fn present(spec: &Spec, ty: TypeId) -> TypeId {
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
