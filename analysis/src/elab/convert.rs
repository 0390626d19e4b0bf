//! Conversion of constant values to declared types (language reference, section 7.1).

use smol_str::format_smolstr;

use super::{constant::from_value, types, value::Const};
use crate::{
    finding::values::{Purpose, ValueProblem},
    model::{Spec, TypeId, TypeKind, Value},
};

/// The reason why a value does not convert.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ConversionError {
    /// The type holds no constants.
    Type,
    /// A value of another kind.
    Kind,
    /// Out of the type's range.
    Range,
}

/// Returns true if a type can hold the value of a constant.
pub(crate) fn holds(spec: &Spec, ty: TypeId, value: &Value) -> bool {
    convert(spec, &from_value(value), ty).is_ok()
}

/// Converts the value to the declared type.
pub(super) fn convert(spec: &Spec, value: &Const, ty: TypeId) -> Result<Value, ConversionError> {
    let last = types::resolve_aliases(spec, ty);
    let kind = &spec.ty(last).kind;
    if let Some((bits, signed)) = kind.integer() {
        return convert_integer(value, bits, signed);
    }
    match kind {
        TypeKind::Boolean => match value {
            Const::Bool(flag) => Ok(Value::Bool(*flag)),
            _ => Err(ConversionError::Kind),
        },
        TypeKind::Float | TypeKind::Double => {
            value.number().map(Value::Float).ok_or(ConversionError::Kind)
        }
        TypeKind::Char => match value {
            Const::Char(character) => Ok(Value::Char(character.clone())),
            Const::Str(text) => Ok(Value::String(text.clone())),
            _ => Err(ConversionError::Kind),
        },
        TypeKind::String { .. } => match value {
            Const::Str(text) => Ok(Value::String(text.clone())),
            _ => Err(ConversionError::Kind),
        },
        TypeKind::Enum { .. } => match value {
            Const::Enum(ty) => match spec.ty(*ty).kind {
                TypeKind::Enumerator { enumeration, .. } if enumeration == last => {
                    Ok(Value::Enum(*ty))
                }
                _ => Err(ConversionError::Kind),
            },
            _ => Err(ConversionError::Kind),
        },
        _ => Err(ConversionError::Type),
    }
}

fn convert_integer(value: &Const, bits: u32, signed: bool) -> Result<Value, ConversionError> {
    let max = (1i128 << (bits - u32::from(signed))) - 1;
    let min = if signed { -max - 1 } else { 0 };
    let value = match value {
        // The complement of an unsigned number has the width of its type.
        Const::Int { value, signed: false } if *value < 0 && !signed => value & max,
        Const::Int { value, .. } => *value,
        Const::Float(_) => value.integral().ok_or(ConversionError::Kind)?,
        _ => return Err(ConversionError::Kind),
    };
    if value < 0 && !signed {
        return Err(ConversionError::Kind);
    }
    if value < min || value > max {
        return Err(ConversionError::Range);
    }
    Ok(if signed { Value::Int(value as i64) } else { Value::Uint(value as u64) })
}

/// The error for a value that does not convert.
pub(super) fn explain_misfit(
    spec: &Spec,
    misfit: ConversionError,
    value: &Const,
    ty: TypeId,
    of: Purpose,
) -> ValueProblem {
    let ty = types::display(spec, ty).into();
    match misfit {
        ConversionError::Type => ValueProblem::NoConstants { of, ty },
        ConversionError::Kind => match value {
            Const::Enum(enumeration) => ValueProblem::OtherEnum {
                of,
                name: spec.ty(*enumeration).name.clone().unwrap_or_default(),
                ty,
            },
            _ => ValueProblem::OtherKind {
                of,
                value: match value {
                    Const::Float(number) => format_smolstr!("{number}"),
                    Const::Int { value, .. } => format_smolstr!("{value}"),
                    _ => value.describe().into(),
                },
                ty,
            },
        },
        ConversionError::Range => {
            ValueProblem::OutOfRange { of, number: value.integer().unwrap_or_default(), ty }
        }
    }
}
