//! Numbers and strings, and the types that hold all values of another.

use dotgen_analysis::model::{PortDir, TypeKind};
use dotgen_codegen::codels::cdr::{CdrReader, CdrWriter};
use dotgen_codegen::codels::value::{Reader, ValueError};
use serde_json::Value;

use crate::common::{Leaf, SECOND};
use crate::description::Base;

/// A number, string or list.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Scalar {
    Integer(i128),
    Float(f64),
    Text(Vec<u8>),
    /// A sequence, as bytes of the glue.
    List(Vec<u8>),
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
            Value::Bool(is_true) => Scalar::Integer((*is_true).into()),
            _ => Scalar::Float(0.0),
        }
    }

    /// The value of a leaf without a source.
    pub(crate) fn default(leaf: &Leaf) -> Scalar {
        match leaf.base {
            Base::String => Scalar::Text(Vec::new()),
            _ => Scalar::Integer(leaf.default.into()),
        }
    }

    /// The number; 0 for a string.
    pub(crate) fn float(&self) -> f64 {
        match self {
            Scalar::Integer(number) => *number as f64,
            Scalar::Float(number) => *number,
            Scalar::Text(_) | Scalar::List(_) => 0.0,
        }
    }

    /// The number without its fraction; 0 for a string.
    pub(crate) fn integer(&self) -> i128 {
        match self {
            Scalar::Integer(number) => *number,
            Scalar::Float(number) => *number as i128,
            Scalar::Text(_) | Scalar::List(_) => 0,
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
            TypeKind::Boolean | TypeKind::Octet => u8::from_ne_bytes(from.take()?).into(),
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
        if let Scalar::List(bytes) = self {
            out.extend(bytes);
            return Some(());
        }
        match kind {
            TypeKind::Boolean => out.push(u8::from(number != 0)),
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

    /// Reads a leaf that is not a list from a message.
    ///
    /// # Errors
    /// The message ends before.
    pub(crate) fn of_message(leaf: &Leaf, from: &mut CdrReader<'_>) -> Result<Scalar, ValueError> {
        Ok(Scalar::Integer(match leaf.base {
            Base::Bool => u8::from(from.number()? != [0]).into(),
            Base::Uint8 => u8::from_ne_bytes(from.number()?).into(),
            Base::Int32 => i32::from_ne_bytes(from.number()?).into(),
            Base::Uint32 => u32::from_ne_bytes(from.number()?).into(),
            Base::Float32 => {
                return Ok(Scalar::Float(f32::from_ne_bytes(from.number()?).into()));
            }
            Base::Float64 => return Ok(Scalar::Float(f64::from_ne_bytes(from.number()?))),
            _ => return Ok(Scalar::Text(from.text()?.to_vec())),
        }))
    }

    /// Writes a leaf that is not a list to a message; `None` if its type does not hold the number.
    pub(crate) fn to_message(&self, leaf: &Leaf, out: &mut CdrWriter) -> Option<()> {
        let number = self.integer();
        match leaf.base {
            Base::Bool => out.number([u8::from(number != 0)]),
            Base::Uint8 => out.number(u8::try_from(number).ok()?.to_ne_bytes()),
            Base::Int32 => out.number(i32::try_from(number).ok()?.to_ne_bytes()),
            Base::Uint32 => {
                let number = u32::try_from(number).ok();
                let number = number.filter(|number| !leaf.is_time || *number < SECOND)?;
                out.number(number.to_ne_bytes());
            }
            Base::Float32 => out.number((self.float() as f32).to_ne_bytes()),
            Base::Float64 => out.number(self.float().to_ne_bytes()),
            _ => out.text(self.text()),
        }
        Some(())
    }
}

/// The values of a type.
#[derive(PartialEq)]
enum Range {
    Booleans,
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
            TypeKind::Boolean => Range::Booleans,
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
            Base::Bool => TypeKind::Boolean,
            Base::Uint8 => TypeKind::Octet,
            Base::Int32 => TypeKind::Long,
            Base::Uint32 => TypeKind::UnsignedLong,
            Base::Float32 => TypeKind::Float,
            Base::Float64 => TypeKind::Double,
            Base::Nested(_) => return None,
            _ => TypeKind::String { bound: None },
        })
    }

    /// True if no value of another type is lost.
    fn holds(&self, other: &Range) -> bool {
        match (self, other) {
            (Range::Booleans | Range::Integers(..), Range::Booleans) => true,
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

/// The values of an integer type, from and to.
pub(crate) fn integers(base: &Base) -> Option<(i128, i128)> {
    match Range::of_base(base)? {
        Range::Integers(from, to) => Some((from, to)),
        _ => None,
    }
}

/// True if a type has exactly the values of a type of ROS 2.
pub(crate) fn equal(kind: &TypeKind, base: &Base) -> bool {
    Range::of(kind).is_some_and(|range| Some(range) == Range::of_base(base))
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
        return Err(format!(
            "`{path}` is of type `{word}`: assign a number, a boolean or a string"
        ));
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
