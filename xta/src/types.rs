//! Types of variables, with their sizes in slots.

use std::sync::Arc;

/// Lowest and highest value.
pub(crate) type Range = (i32, i32);

/// Range of `int` without bounds.
pub(crate) const INT: Range = (-32768, 32767);

#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Type {
    Int(Range),
    Bool,
    Clock,
    Chan { urgent: bool, broadcast: bool },
    Array(Arc<Type>, u32),
    Record(Arc<Vec<(String, Type)>>),
    Void,
}

impl Type {
    /// Number of integers, clocks or channels. The size is computed with saturation.
    pub(crate) fn size(&self) -> u32 {
        match self {
            Type::Array(of, length) => of.size().saturating_mul(*length),
            Type::Record(fields) => {
                fields.iter().fold(0, |sum, (_, ty): &(String, Type)| sum.saturating_add(ty.size()))
            }
            Type::Void => 0,
            _ => 1,
        }
    }

    /// Range of an integer or a boolean.
    pub(crate) fn range(&self) -> Option<Range> {
        match self {
            Type::Int(range) => Some(*range),
            Type::Bool => Some((0, 1)),
            _ => None,
        }
    }

    /// The type below all dimensions.
    pub(crate) fn element(&self) -> &Type {
        match self {
            Type::Array(of, _) => of.element(),
            _ => self,
        }
    }

    /// Names of the slots of a variable, with their ranges.
    pub(crate) fn slots(&self, name: &str, out: &mut Vec<(String, Range)>) {
        match self {
            Type::Array(of, length) => {
                (0..*length).for_each(|i| of.slots(&format!("{name}[{i}]"), out));
            }
            Type::Record(fields) => {
                fields.iter().for_each(|(field, ty)| ty.slots(&format!("{name}.{field}"), out));
            }
            _ => out.push((name.to_owned(), self.range().unwrap_or((0, 0)))),
        }
    }
}
