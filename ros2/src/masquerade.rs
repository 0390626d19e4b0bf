//! `#pragma masquerade ros TYPE "geometry_msgs/Twist"`: types that stand for common messages.

use dotgen_analysis::model::{Port, Spec, TypeId, TypeKind};

use crate::common;
use crate::conversion::{Conversion, find, present};
use crate::description::{Base, Count, Field, TIME};
use crate::rules::{Plan, Source};
use crate::scalar::equal;

/// The strictness of a comparison between a type and a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Likeness {
    /// Their values have the same payload.
    Payload,
    /// A conversion exists: members have any order, times any integers, and a header may lack its stamp and
    /// have the `seq` of ROS 1.
    Members,
}

/// The conversion of a port whose type masquerades as a common message.
///
/// # Errors
/// In words: the message is not known, or differs from the type.
pub(crate) fn conversion(spec: &Spec, port: &Port) -> Result<Option<Conversion>, String> {
    let Some(pragma) = Pragma::of(spec, port.data) else {
        return Ok(None);
    };
    let message = pragma.message(Likeness::Members)?;
    let leaves = common::leaves(&message).into_iter().map(|leaf| {
        let is_stamp = leaf.path.starts_with("header.stamp.");
        let source = if is_stamp && find(spec, port.data, &leaf.path, "").is_err() {
            Source::Now
        } else {
            Source::Member(leaf.path.clone(), Vec::new())
        };
        (leaf, source)
    });
    let plan = Plan { leaves: leaves.collect(), message };
    let conversion = Conversion::new(spec, port.data, port.dir, plan, "");
    conversion.map(Some).map_err(|errors| pragma.advised(&errors[0].why))
}

/// The common message of a type that masquerades as it within a message of another type.
///
/// # Errors
/// In words: the message is not known, or has another payload.
pub(crate) fn nested(spec: &Spec, ty: TypeId) -> Result<Option<String>, String> {
    Pragma::of(spec, ty).map(|pragma| pragma.message(Likeness::Payload)).transpose()
}

/// A pragma for ROS.
struct Pragma<'s> {
    spec: &'s Spec,
    ty: TypeId,
    template: &'s str,
    data: &'s str,
}

impl<'s> Pragma<'s> {
    /// The pragma of a type, or of the type that it is an alias of. The template `ros2` goes before others.
    fn of(spec: &'s Spec, mut ty: TypeId) -> Option<Self> {
        // The bound protects against cycles in foreign data.
        for _ in 0..spec.types.len() {
            let of_ros = |name: &str| matches!(name.split('/').next(), Some("ros" | "ros2"));
            let mut pairs = spec.ty(ty).masquerade.iter().filter(|(name, _)| of_ros(name));
            let first = pairs.clone().find(|(name, _)| name.starts_with("ros2"));
            if let Some((template, data)) = first.or_else(|| pairs.next()) {
                return Some(Pragma { spec, ty, template, data });
            }
            ty = match spec.ty(ty).kind {
                TypeKind::Typedef { ty } | TypeKind::StructMember { ty } => ty,
                TypeKind::UnionMember { ty, .. } => ty,
                TypeKind::ForwardStruct { definition: Some(ty) } => ty,
                _ => return None,
            };
        }
        None
    }

    /// The full name of the message, if the type is like it.
    fn message(&self, likeness: Likeness) -> Result<String, String> {
        let data = self.data.trim_start_matches("::").replace("::", "/");
        let message = common::full_name(&data).map_err(|why| self.advised(&why))?;
        let alike = self.compare(self.ty, &message, "", likeness);
        alike.map_err(|why| self.advised(&why))?;
        Ok(message)
    }

    fn advised(&self, why: &str) -> String {
        let (template, data) = (self.template, self.data);
        let name = self.spec.full_name(self.ty).unwrap_or_default();
        let end = if why.ends_with('?') { "" } else { "." };
        format!(
            "`#pragma masquerade {template} {name} \"{data}\"`: {why}{end} Correct the type or the pragma, or \
             give the port a rule in `dotgen.toml`"
        )
    }

    /// Compares the members of a type with the fields of a message. `within` is the path of the type: `pose.`
    fn compare(
        &self,
        ty: TypeId,
        message: &str,
        within: &str,
        likeness: Likeness,
    ) -> Result<(), String> {
        let kind = &self.spec.ty(self.resolved(ty, likeness)).kind;
        let short = message.replacen("/msg/", "/", 1);
        let TypeKind::Struct { members } = kind else {
            let (of, word) = (of(within), kind.word());
            return Err(format!("{of} is of type `{word}`, but `{short}` is a structure"));
        };
        let name = |member: TypeId| self.spec.ty(member).name.as_deref().unwrap_or_default();
        let fields: Vec<Field> = common::fields(message).map(|(field, _)| field).collect();
        let is_header = message == "std_msgs/msg/Header" && likeness == Likeness::Members;
        let is_for = |member: TypeId, field: &Field| {
            name(member) == field.name || (name(member) == "nsec" && field.name == "nanosec")
        };
        for (at, field) in fields.iter().enumerate() {
            let path = format!("{within}{}", field.name);
            let Some(found) = members.iter().position(|&member| is_for(member, field)) else {
                if is_header && field.name == "stamp" {
                    continue;
                }
                let of = of(within);
                return Err(format!("{of} has no member `{}`, a field of `{short}`", field.name));
            };
            if likeness == Likeness::Payload && found != at {
                let place = at + 1;
                return Err(format!("`{path}` is not member {place}, its place in `{short}`"));
            }
            self.compare_field(members[found], field, &path, message, likeness)?;
        }
        let is_known = |member: TypeId| {
            fields.iter().any(|field| is_for(member, field)) || (is_header && name(member) == "seq")
        };
        match members.iter().find(|&&member| !is_known(member)) {
            Some(&extra) => Err(format!("`{within}{}` is not a field of `{short}`", name(extra))),
            None => Ok(()),
        }
    }

    /// Compares a member with a field of a message.
    fn compare_field(
        &self,
        member: TypeId,
        field: &Field,
        path: &str,
        message: &str,
        likeness: Likeness,
    ) -> Result<(), String> {
        let kind = |ty| &self.spec.ty(self.resolved(ty, likeness)).kind;
        let differs = || {
            let (word, wanted) = (described(self.spec, member), field.ty.text());
            let short = message.replacen("/msg/", "/", 1);
            Err(format!("`{path}` is of type `{word}`, but of type `{wanted}` in `{short}`"))
        };
        let element = match (field.ty.count, kind(member)) {
            (Count::One, _) => member,
            (Count::Exactly(number), TypeKind::Array { element, length }) if *length == number => {
                *element
            }
            (Count::Any, TypeKind::Sequence { element, .. }) => *element,
            (Count::Any, TypeKind::Array { element, .. }) if likeness == Likeness::Members => {
                *element
            }
            _ => return differs(),
        };
        let is_time = message == TIME && likeness == Likeness::Members;
        match (&field.ty.base, kind(element)) {
            (Base::Nested(name), TypeKind::Struct { .. }) => {
                let list = if field.ty.count == Count::One { "" } else { "[]" };
                self.compare(element, name, &format!("{path}{list}."), likeness)
            }
            (Base::String, TypeKind::String { .. }) => Ok(()),
            (Base::Nested(_), _) => differs(),
            (base, kind) if equal(kind, base) || (is_time && is_integer(kind)) => Ok(()),
            _ => differs(),
        }
    }

    /// The type without aliases, and without optionals where values are converted.
    fn resolved(&self, ty: TypeId, likeness: Likeness) -> TypeId {
        match likeness {
            Likeness::Payload => self.spec.resolve_alias(ty),
            Likeness::Members => present(self.spec, ty),
        }
    }
}

/// The part at a path that ends with a point.
fn of(within: &str) -> String {
    match within.trim_end_matches('.') {
        "" => "the type".to_owned(),
        path => format!("`{path}`"),
    }
}

fn is_integer(kind: &TypeKind) -> bool {
    [Base::Int32, Base::Uint32].iter().any(|base| equal(kind, base))
        || matches!(
            kind,
            TypeKind::LongLong
                | TypeKind::UnsignedLongLong
                | TypeKind::Short
                | TypeKind::UnsignedShort
        )
}

/// A type in the words of the specification: `sequence<double>`.
fn described(spec: &Spec, ty: TypeId) -> String {
    let ty = spec.resolve_alias(ty);
    let name = |ty| spec.ty(spec.resolve_alias(ty)).kind.word();
    match &spec.ty(ty).kind {
        TypeKind::Array { element, length } => format!("{}[{length}]", name(*element)),
        kind @ (TypeKind::Sequence { element, .. } | TypeKind::Optional { element }) => {
            format!("{}<{}>", kind.word(), name(*element))
        }
        TypeKind::Struct { .. } => spec.full_name(ty).unwrap_or_default(),
        kind => kind.word().to_owned(),
    }
}
