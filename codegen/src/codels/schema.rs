//! JSON Schema of types, for the output of [`Values`].

use dotgen_analysis::model::{InitValue, Initializer, Param, PathElement, Spec, TypeId, TypeKind};
use serde_json::{Map, Value, json};

use super::value::Values;

/// Maximum depth of types within types; below it, the schema accepts any value.
const DEPTH: usize = 64;

/// The schema of the values of a type. Where a type contains itself, the schema accepts any value.
pub fn of_type(spec: &Spec, ty: TypeId) -> Value {
    schema(spec, ty, &mut Vec::new())
}

/// The schema of a parameter of a service. It is the schema of its type, with `description`, `unit` and
/// `default`, also for its members, if the specification contains them. The unit is the end of a doc text in
/// brackets: `Level to reach (m)`.
pub fn of_param(spec: &Spec, param: &Param) -> Value {
    let mut out = of_type(spec, param.ty);
    if let Some(init) = &param.init {
        annotate(&mut out, init, Values::new(spec));
    }
    out
}

fn annotate(schema: &mut Value, init: &Initializer, values: Values<'_>) {
    let Some(of) = schema.as_object_mut() else {
        return;
    };
    if let Some(doc) = &init.doc {
        let (text, unit) = with_unit(doc);
        if !text.is_empty() {
            of.insert("description".to_owned(), text.into());
        }
        if let Some(unit) = unit {
            of.insert("unit".to_owned(), unit.into());
        }
    }
    if let Some(default) = values.initial(init) {
        of.insert("default".to_owned(), default);
    }
    let InitValue::Compound(members) = &init.value else {
        return;
    };
    for initializer in members {
        let Some(PathElement::Member(name)) = &initializer.member else {
            continue;
        };
        let properties = schema.get_mut("properties");
        if let Some(member) = properties.and_then(|all| all.get_mut(name.as_str())) {
            annotate(member, initializer, values);
        }
    }
}

/// A doc text, and the unit at its end. A unit is in brackets and without blanks; a text with blanks is a
/// remark.
fn with_unit(doc: &str) -> (&str, Option<&str>) {
    let doc = doc.trim();
    let close = match doc.chars().last() {
        Some(')') => '(',
        Some(']') => '[',
        _ => return (doc, None),
    };
    let split = doc.rfind(close).map(|at| (&doc[..at], &doc[at + 1..doc.len() - 1]));
    match split {
        Some((text, unit)) if !unit.is_empty() && !unit.contains(char::is_whitespace) => {
            (text.trim_end(), Some(unit))
        }
        _ => (doc, None),
    }
}

fn schema(spec: &Spec, ty: TypeId, around: &mut Vec<TypeId>) -> Value {
    let ty = spec.resolve_alias(ty);
    if around.contains(&ty) || around.len() >= DEPTH {
        return json!({});
    }
    around.push(ty);
    let out = of_kind(spec, ty, around);
    around.pop();
    out
}

/// The schema of an integer with this number of bits.
pub(crate) fn integer(bits: u32, signed: bool) -> Value {
    let least = if signed { i64::MIN >> (64 - bits) } else { 0 };
    let greatest = u64::MAX >> (64 - bits + u32::from(signed));
    json!({"type": "integer", "minimum": least, "maximum": greatest})
}

fn of_kind(spec: &Spec, ty: TypeId, around: &mut Vec<TypeId>) -> Value {
    let name = |ty: TypeId| {
        let name = spec.ty(ty).name.as_ref();
        name.map(ToString::to_string).unwrap_or_default()
    };
    let kind = &spec.ty(ty).kind;
    if let Some((bits, signed)) = kind.integer() {
        return integer(bits, signed);
    }
    match kind {
        TypeKind::Boolean => json!({"type": "boolean"}),
        TypeKind::Char => integer(8, true),
        // A float that is NaN or infinite is `null`.
        TypeKind::Float | TypeKind::Double => json!({"type": ["number", "null"]}),
        TypeKind::Enum { enumerators } => {
            let names: Vec<String> =
                enumerators.iter().map(|&enumerator| name(enumerator)).collect();
            // A number that is not an enumerator remains a number.
            json!({"anyOf": [{"type": "string", "enum": names}, integer(32, false)]})
        }
        TypeKind::String { .. } => json!({"type": "string"}),
        TypeKind::Array { element, length } => {
            let items = schema(spec, *element, around);
            json!({"type": "array", "items": items, "minItems": length, "maxItems": length})
        }
        TypeKind::Sequence { element, bound } => {
            let mut out = json!({"type": "array", "items": schema(spec, *element, around)});
            if let Some(bound) = bound {
                out["maxItems"] = (*bound).into();
            }
            out
        }
        TypeKind::Optional { element } => {
            json!({"anyOf": [schema(spec, *element, around), {"type": "null"}]})
        }
        TypeKind::Struct { members } | TypeKind::Exception { members } => {
            let names: Vec<String> = members.iter().map(|&member| name(member)).collect();
            let all = members.iter().map(|&member| (name(member), schema(spec, member, around)));
            let all: Map<String, Value> = all.collect();
            json!({
                "type": "object",
                "properties": all,
                "required": names,
                "additionalProperties": false,
            })
        }
        TypeKind::Union { switch, members } => {
            // `_d` selects the other member.
            let switch = ("_d".to_owned(), schema(spec, *switch, around));
            let all = members.iter().map(|&member| (name(member), schema(spec, member, around)));
            let all: Map<String, Value> = std::iter::once(switch).chain(all).collect();
            json!({
                "type": "object",
                "properties": all,
                "required": ["_d"],
                "additionalProperties": false,
            })
        }
        _ => json!({"type": "null"}),
    }
}
