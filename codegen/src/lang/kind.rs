//! The words of the template language for kinds, directions, sources and constants.

use dotgen_analysis::model::{Label, ScopeKind, Spec, TypeKind, Value};

use super::text::format_g;

/// Length of an array, bound of a sequence or string, in elements; `None` if unbounded or of another kind.
pub fn length_of(kind: &TypeKind) -> Option<u64> {
    match kind {
        TypeKind::Array { length, .. } => Some(*length),
        TypeKind::Sequence { bound, .. } | TypeKind::String { bound } => *bound,
        _ => None,
    }
}

pub fn scope_word(kind: ScopeKind) -> &'static str {
    match kind {
        ScopeKind::Module => "module",
        ScopeKind::Struct => "struct",
        ScopeKind::Union => "union",
        ScopeKind::Exception => "exception",
    }
}

/// Text of a constant: booleans `1` and `0`, floats as C `%g`, enumerators by full name.
pub fn value_text(spec: &Spec, value: &Value) -> String {
    match value {
        Value::Bool(b) => if *b { "1" } else { "0" }.to_owned(),
        Value::Uint(u) => u.to_string(),
        Value::Int(i) => i.to_string(),
        Value::Float(f) => format_g(*f),
        Value::Char(text) | Value::String(text) => text.clone(),
        Value::Enum(ty) => spec.full_name(*ty).unwrap_or_default(),
    }
}

/// Text of a union label; empty for `default`.
pub fn label_text(spec: &Spec, label: &Label) -> String {
    match label {
        Label::Default => String::new(),
        Label::Case(value) => value_text(spec, value),
    }
}
