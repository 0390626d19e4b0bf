//! Numbers and strings, and the types that hold all values of another.

use dotgen_analysis::model::{PortDir, TypeKind};
use dotgen_codegen::codels::value::{Reader, ValueError};
use serde_json::Value;

use crate::common::Leaf;
use crate::description::Base;

/// A number or string.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Scalar {
    Integer(i128),
    Float(f64),
    Text(Vec<u8>),
}

impl Scalar {
    /// A number or string of JSON.
    pub(crate) fn constant(value: &Value) -> Scalar {
        match value {
            Value::String(text) => Scalar::Text(text.clone().into_bytes()),
            Value::Number(number) => match number.as_i128() {
                Some(number) => Scalar::Integer(number),
                None => Scalar::Float(number.as_f64().unwrap_or_default()),
            },
            _ => Scalar::Float(0.0),
        }
    }

    /// The number; 0 for a string.
    pub(crate) fn float(&self) -> f64 {
        match self {
            Scalar::Integer(number) => *number as f64,
            Scalar::Float(number) => *number,
            Scalar::Text(_) => 0.0,
        }
    }

    /// The number without its fraction; 0 for a string.
    pub(crate) fn integer(&self) -> i128 {
        match self {
            Scalar::Integer(number) => *number,
            Scalar::Float(number) => *number as i128,
            Scalar::Text(_) => 0,
        }
    }

    /// The bytes of the string; none for a number.
    pub(crate) fn text(&self) -> &[u8] {
        match self {
            Scalar::Text(text) => text,
            _ => &[],
        }
    }

    /// Reads a value of the glue.
    ///
    /// # Errors
    /// The bytes end before.
    pub(crate) fn read(kind: &TypeKind, from: &mut Reader<'_>) -> Result<Scalar, ValueError> {
        Ok(Scalar::Integer(match kind {
            TypeKind::Octet => u8::from_ne_bytes(from.take()?).into(),
            TypeKind::Char => i8::from_ne_bytes(from.take()?).into(),
            TypeKind::Short => i16::from_ne_bytes(from.take()?).into(),
            TypeKind::UnsignedShort => u16::from_ne_bytes(from.take()?).into(),
            TypeKind::Long => i32::from_ne_bytes(from.take()?).into(),
            TypeKind::UnsignedLong => u32::from_ne_bytes(from.take()?).into(),
            TypeKind::LongLong => i64::from_ne_bytes(from.take()?).into(),
            TypeKind::UnsignedLongLong => u64::from_ne_bytes(from.take()?).into(),
            TypeKind::Float => return Ok(Scalar::Float(f32::from_ne_bytes(from.take()?).into())),
            TypeKind::Double => return Ok(Scalar::Float(f64::from_ne_bytes(from.take()?))),
            _ => {
                let length = u32::from_ne_bytes(from.take()?);
                return Ok(Scalar::Text(from.some(length as usize)?.to_vec()));
            }
        }))
    }

    /// Writes a value of the glue; `None` if the type does not hold the number.
    pub(crate) fn write(&self, kind: &TypeKind, out: &mut Vec<u8>) -> Option<()> {
        let number = self.integer();
        match kind {
            TypeKind::Octet => out.extend(u8::try_from(number).ok()?.to_ne_bytes()),
            TypeKind::Char => out.extend(i8::try_from(number).ok()?.to_ne_bytes()),
            TypeKind::Short => out.extend(i16::try_from(number).ok()?.to_ne_bytes()),
            TypeKind::UnsignedShort => out.extend(u16::try_from(number).ok()?.to_ne_bytes()),
            TypeKind::Long => out.extend(i32::try_from(number).ok()?.to_ne_bytes()),
            TypeKind::UnsignedLong => out.extend(u32::try_from(number).ok()?.to_ne_bytes()),
            TypeKind::LongLong => out.extend(i64::try_from(number).ok()?.to_ne_bytes()),
            TypeKind::UnsignedLongLong => out.extend(u64::try_from(number).ok()?.to_ne_bytes()),
            TypeKind::Float => out.extend((self.float() as f32).to_ne_bytes()),
            TypeKind::Double => out.extend(self.float().to_ne_bytes()),
            _ => {
                let text = self.text();
                out.extend(u32::try_from(text.len()).ok()?.to_ne_bytes());
                out.extend(text);
            }
        }
        Some(())
    }
}

/// The values of a type.
enum Range {
    /// From and to.
    Integers(i128, i128),
    /// Numbers of so many binary digits.
    Floats(u32),
    /// Strings of at most so many bytes.
    Texts(Option<u64>),
}

impl Range {
    fn of(kind: &TypeKind) -> Option<Range> {
        let signed = |bits: u32| Range::Integers(-(1 << (bits - 1)), (1 << (bits - 1)) - 1);
        let unsigned = |bits: u32| Range::Integers(0, (1 << bits) - 1);
        Some(match kind {
            TypeKind::Octet => unsigned(8),
            TypeKind::Char => signed(8),
            TypeKind::Short => signed(16),
            TypeKind::UnsignedShort => unsigned(16),
            TypeKind::Long => signed(32),
            TypeKind::UnsignedLong => unsigned(32),
            TypeKind::LongLong => signed(64),
            TypeKind::UnsignedLongLong => unsigned(64),
            TypeKind::Float => Range::Floats(24),
            TypeKind::Double => Range::Floats(53),
            TypeKind::String { bound } => Range::Texts(*bound),
            _ => return None,
        })
    }

    fn of_base(base: &Base) -> Option<Range> {
        Range::of(&match base {
            Base::Int32 => TypeKind::Long,
            Base::Uint32 => TypeKind::UnsignedLong,
            Base::Float64 => TypeKind::Double,
            _ => TypeKind::String { bound: None },
        })
    }

    /// True if no value of another type is lost.
    fn holds(&self, other: &Range) -> bool {
        match (self, other) {
            (Range::Integers(from, to), Range::Integers(least, most)) => {
                from <= least && most <= to
            }
            (Range::Floats(digits), Range::Integers(least, most)) => {
                let end = 1 << digits;
                -end <= *least && *most <= end
            }
            (Range::Floats(digits), Range::Floats(other)) => other <= digits,
            (Range::Texts(None), Range::Texts(_)) => true,
            (Range::Texts(Some(bound)), Range::Texts(Some(other))) => other <= bound,
            _ => false,
        }
    }
}

/// Accepts a member for a leaf if no value is lost in the direction of the port. The parts of a time may be
/// any integers: their values are checked.
///
/// # Errors
/// In words: the types do not fit.
pub(crate) fn fits(kind: &TypeKind, path: &str, leaf: &Leaf, dir: PortDir) -> Result<(), String> {
    let word = match kind {
        TypeKind::String { bound: Some(bound) } => format!("string<{bound}>"),
        _ => kind.word().to_owned(),
    };
    let (Some(member), Some(field)) = (Range::of(kind), Range::of_base(&leaf.base)) else {
        return Err(format!("`{path}` is of type `{word}`: assign a number or a string"));
    };
    if leaf.is_time && matches!(member, Range::Integers(..)) {
        return Ok(());
    }
    let (field_path, base) = (&leaf.path, leaf.base.text());
    match dir {
        PortDir::Out if !field.holds(&member) => Err(format!(
            "`{path}` is of type `{word}`, and the field `{field_path}` of type `{base}` does not hold all \
             its values: assign a member of another type"
        )),
        PortDir::In if !member.holds(&field) => Err(format!(
            "`{path}` is of type `{word}` and does not hold all values of the field `{field_path}` of type \
             `{base}`: assign a member of another type"
        )),
        _ => Ok(()),
    }
}
