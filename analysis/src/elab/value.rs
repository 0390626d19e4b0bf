//! The values of constant expressions (language reference, section 7).

use num_rational::Ratio;

use crate::model::{Seconds, TypeId};

/// The value of an expression before it is converted to a declared type.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Const {
    Bool(bool),
    /// `signed: false` with a negative value is the complement of an unsigned number. It takes the width of
    /// the type it is converted to.
    Int {
        value: i128,
        signed: bool,
    },
    Float(f64),
    Char(String),
    Str(String),
    Enum(TypeId),
    /// Already reported.
    Unknown,
}

impl Const {
    pub(super) fn unsigned(value: i128) -> Self {
        Self::Int { value, signed: false }
    }

    /// The kind of the value, with an article.
    pub(super) fn describe(&self) -> &'static str {
        match self {
            Self::Bool(_) => "a boolean",
            Self::Int { value, .. } if *value < 0 => "a negative number",
            Self::Int { .. } => "an integer",
            Self::Float(_) => "a floating point number",
            Self::Char(_) => "a character",
            Self::Str(_) => "a string",
            Self::Enum(_) => "an enumerator",
            Self::Unknown => "unknown",
        }
    }

    /// The value of an integer, with complements of unsigned numbers taken at 64 bits.
    pub(super) fn integer(&self) -> Option<i128> {
        match self {
            Self::Int { value, signed: false } if *value < 0 => Some(value & i128::from(u64::MAX)),
            Self::Int { value, .. } => Some(*value),
            _ => None,
        }
    }

    pub(super) fn number(&self) -> Option<f64> {
        match self {
            Self::Float(value) => Some(*value),
            _ => self.integer().map(|integer| integer as f64),
        }
    }

    /// The value as an integer, if it is a number without fraction.
    pub(super) fn integral(&self) -> Option<i128> {
        match self {
            Self::Float(value) if value.fract() == 0.0 && value.abs() < 1e36 => {
                Some(*value as i128)
            }
            Self::Float(_) => None,
            _ => self.integer(),
        }
    }

    /// The exact value of a number.
    pub(super) fn exact(&self) -> Option<Seconds> {
        match self {
            Self::Float(value) => Some(exact(*value)),
            _ => self.integer().map(|integer| Ratio::from_integer(integer.clamp(-LIMIT, LIMIT))),
        }
    }
}

/// Larger than any time or size; keeps exact arithmetic from overflowing.
const LIMIT: i128 = 1_000_000_000_000_000_000;

/// The rational number for the shortest decimal text of a float: 0.005 is 1/200.
pub(super) fn exact(value: f64) -> Seconds {
    if !value.is_finite() {
        return Ratio::from_integer(if value.is_sign_negative() { -LIMIT } else { LIMIT });
    }
    let text = format!("{value:e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let decimals = mantissa.split_once('.').map_or(0, |(_, text)| text.len() as i32);
    let digits: String = mantissa.chars().filter(|character| *character != '.').collect();
    let Ok(digits) = digits.parse::<i128>() else {
        return Ratio::from_integer(0);
    };
    let power = exponent - decimals;
    if exponent >= 18 {
        Ratio::from_integer(if digits < 0 { -LIMIT } else { LIMIT })
    } else if power >= 0 {
        Ratio::from_integer(digits * 10i128.pow(power as u32))
    } else if power >= -30 {
        Ratio::new(digits, 10i128.pow(-power as u32))
    } else if power >= -48 {
        // Beyond 30 decimals the rest is negligible.
        Ratio::new(digits / 10i128.pow((-power - 30) as u32), 10i128.pow(30))
    } else {
        Ratio::from_integer(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_become_the_fractions_that_were_written() {
        for (value, numer, denom) in [
            (0.005, 1, 200),
            (2.5, 5, 2),
            (0.1, 1, 10),
            (-0.000_026, -13, 500_000),
            (3.0, 3, 1),
            (1e-7, 1, 10_000_000),
            (1e300, LIMIT, 1),
            (f64::NEG_INFINITY, -LIMIT, 1),
            (1e-300, 0, 1),
        ] {
            assert_eq!(exact(value), Ratio::new(numer, denom), "{value}");
        }
    }
}
