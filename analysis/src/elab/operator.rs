//! The operators of constant expressions (language reference, section 7).

use super::value::Const;
use crate::finding::values::ValueProblem;
use dotgen_syntax::SyntaxKind::{self, *};

pub(super) fn unary(op: SyntaxKind, value: &Const) -> Option<Const> {
    Some(match (op, value) {
        (_, Const::Unknown) => Const::Unknown,
        (TILDE, Const::Bool(flag)) => Const::Bool(!flag),
        (TILDE, Const::Int { value, signed }) => Const::Int { value: !value, signed: *signed },
        (MINUS, Const::Float(number)) => Const::Float(-number),
        (MINUS, Const::Int { .. }) => Const::Int { value: -value.integer()?, signed: true },
        (PLUS, Const::Float(_) | Const::Int { .. }) => value.clone(),
        _ => return None,
    })
}

/// The reason why a binary operation has no value.
#[derive(Debug, Clone, Copy)]
pub(super) enum BinaryProblem {
    Kinds,
    DivisionByZero,
    Overflow,
}

impl BinaryProblem {
    pub(super) fn explain(self, op: SyntaxKind, left: &Const, right: &Const) -> ValueProblem {
        let op = op.spelling().unwrap_or_default();
        match self {
            Self::Kinds => {
                ValueProblem::Binary { op, left: left.describe(), right: right.describe() }
            }
            Self::DivisionByZero => ValueProblem::DivisionByZero { op },
            Self::Overflow => ValueProblem::Overflow { op },
        }
    }
}

pub(super) fn binary(op: SyntaxKind, left: &Const, right: &Const) -> Result<Const, BinaryProblem> {
    let known =
        |constant: &Const| matches!(constant, Const::Unknown | Const::Int { .. } | Const::Float(_));
    if !known(left) || !known(right) {
        return Err(BinaryProblem::Kinds);
    }
    if *left == Const::Unknown || *right == Const::Unknown {
        return Ok(Const::Unknown);
    }
    if matches!(op, SHL | SHR) {
        return shift(op, left, right);
    }
    let (Const::Int { value: raw_a, signed: s }, Const::Int { value: raw_b, signed: t }) =
        (left, right)
    else {
        let (Some(a), Some(b)) = (left.number(), right.number()) else {
            return Err(BinaryProblem::Kinds);
        };
        return Ok(Const::Float(match op {
            PLUS => a + b,
            MINUS => a - b,
            STAR => a * b,
            SLASH => a / b,
            _ => return Err(BinaryProblem::Kinds),
        }));
    };
    let signed = *s || *t;
    // Bitwise operators keep complements symbolic, so that `~0 & mask` works at any width.
    let bitwise = match op {
        PIPE => Some(raw_a | raw_b),
        CARET => Some(raw_a ^ raw_b),
        AMP => Some(raw_a & raw_b),
        _ => None,
    };
    if let Some(value) = bitwise {
        return Ok(Const::Int { value, signed });
    }
    let (Some(a), Some(b)) = (left.integer(), right.integer()) else {
        return Err(BinaryProblem::Kinds);
    };
    if matches!(op, SLASH | PERCENT) && b == 0 {
        return Err(BinaryProblem::DivisionByZero);
    }
    let value = match op {
        PLUS => a.checked_add(b),
        MINUS => a.checked_sub(b),
        STAR => a.checked_mul(b),
        SLASH => a.checked_div(b),
        _ => a.checked_rem(b),
    };
    let value = value.ok_or(BinaryProblem::Overflow)?;
    Ok(Const::Int { value, signed: signed || value < 0 })
}

fn shift(op: SyntaxKind, left: &Const, right: &Const) -> Result<Const, BinaryProblem> {
    let Const::Int { signed, .. } = left else {
        return Err(BinaryProblem::Kinds);
    };
    let amount = right.integral().and_then(|integral| u32::try_from(integral).ok());
    let (Some(value), Some(amount)) = (left.integer(), amount) else {
        return Err(BinaryProblem::Kinds);
    };
    let value = match op {
        SHR => value >> amount.min(127),
        _ if value == 0 => 0,
        // Small enough that shifting loses no bit.
        _ if amount < 62 && value.unsigned_abs() < 1 << 65 => value << amount,
        _ => return Err(BinaryProblem::Overflow),
    };
    Ok(Const::Int { value, signed: *signed })
}
