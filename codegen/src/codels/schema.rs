//! JSON Schema of types: what [`Values`](super::value::Values) writes fits it.

use dotgen_analysis::model::{Spec, TypeId, TypeKind};
use serde_json::{Map, Value, json};

/// Levels of types within types before anything fits.
const DEPTH: usize = 64;

/// The schema of the values of a type.
pub fn of_type(spec: &Spec, ty: TypeId) -> Value {
    schema(spec, ty, DEPTH)
}

fn schema(spec: &Spec, ty: TypeId, depth: usize) -> Value {
    let Some(depth) = depth.checked_sub(1) else {
        return json!({});
    };
    let name = |it: TypeId| {
        let name = spec.ty(it).name.as_ref();
        name.map(|it| it.to_string()).unwrap_or_default()
    };
    let whole = |least: i64, greatest: u64| json!({"type": "integer", "minimum": least, "maximum": greatest});
    let signed = |bits: u32| whole(-(1i64 << (bits - 1)), (1u64 << (bits - 1)) - 1);
    match &spec.ty(spec.resolve_alias(ty)).kind {
        TypeKind::Boolean => json!({"type": "boolean"}),
        TypeKind::Octet => whole(0, u8::MAX.into()),
        TypeKind::Char => signed(8),
        TypeKind::Short => signed(16),
        TypeKind::UnsignedShort => whole(0, u16::MAX.into()),
        TypeKind::Long => signed(32),
        TypeKind::UnsignedLong => whole(0, u32::MAX.into()),
        TypeKind::LongLong => whole(i64::MIN, i64::MAX as u64),
        TypeKind::UnsignedLongLong => whole(0, u64::MAX),
        // A float that is none is `null`.
        TypeKind::Float | TypeKind::Double => json!({"type": ["number", "null"]}),
        TypeKind::Enum { enumerators } => {
            let names: Vec<String> = enumerators.iter().map(|&it| name(it)).collect();
            // A number that is none of them stays one.
            json!({"anyOf": [{"type": "string", "enum": names}, whole(0, u32::MAX.into())]})
        }
        TypeKind::String { .. } => json!({"type": "string"}),
        TypeKind::Array { element, length } => {
            let items = schema(spec, *element, depth);
            json!({"type": "array", "items": items, "minItems": length, "maxItems": length})
        }
        TypeKind::Sequence { element, bound } => {
            let mut out = json!({"type": "array", "items": schema(spec, *element, depth)});
            if let Some(bound) = bound {
                out["maxItems"] = (*bound).into();
            }
            out
        }
        TypeKind::Optional { element } => {
            json!({"anyOf": [schema(spec, *element, depth), {"type": "null"}]})
        }
        TypeKind::Struct { members } | TypeKind::Exception { members } => {
            let names: Vec<String> = members.iter().map(|&it| name(it)).collect();
            let all = members
                .iter()
                .map(|&it| (name(it), schema(spec, it, depth)));
            let all: Map<String, Value> = all.collect();
            json!({
                "type": "object",
                "properties": all,
                "required": names,
                "additionalProperties": false,
            })
        }
        TypeKind::Union { switch, members } => {
            // `_d` says which of the others is there.
            let switch = ("_d".to_owned(), schema(spec, *switch, depth));
            let all = members
                .iter()
                .map(|&it| (name(it), schema(spec, it, depth)));
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
