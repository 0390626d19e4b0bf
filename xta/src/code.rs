//! Expressions and functions in the form that is executed. Names are addresses.
//!
//! An address is an index of the memory: the locations of the processes, the variables, then the frames of
//! functions. An address with [`CONSTANT`] is an index of the constants.

use crate::ast::Binary;
use crate::types::{Range, Type};

/// Mark of the address of a constant.
pub(crate) const CONSTANT: u32 = 1 << 30;

#[derive(Debug, Clone)]
pub(crate) enum Code {
    Const(i32),
    Load(Place, Range),
    Not(Box<Code>),
    Negate(Box<Code>),
    Binary(Binary, Box<[Code; 2]>),
    All(Vec<Code>),
    Any(Vec<Code>),
    Choice(Box<[Code; 3]>),
    /// Assignment, of which the value is the value that was assigned.
    Store {
        place: Place,
        operator: Option<Binary>,
        value: Box<Code>,
        range: Range,
    },
    Step {
        place: Place,
        delta: i32,
        prefix: bool,
        range: Range,
    },
    /// Assignment of an array or a record.
    Copy {
        to: Place,
        from: Place,
        size: u32,
    },
    Call {
        function: u32,
        arguments: Vec<Argument>,
    },
    /// Test that a process is in a location.
    At {
        process: u32,
        location: i32,
    },
}

#[derive(Debug, Clone)]
pub(crate) enum Argument {
    Value(Code, Range),
    /// A reference.
    Address(Place),
    /// An array or a record by value.
    Copy(Place, u32),
}

#[derive(Debug, Clone)]
pub(crate) struct Place {
    pub(crate) root: Root,
    pub(crate) offset: u32,
    pub(crate) indices: Vec<Index>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Root {
    /// The offset is an address.
    Static,
    /// The offset is relative to the frame.
    Local,
    /// The offset is relative to the address in this slot of the frame.
    Through(u32),
}

#[derive(Debug, Clone)]
pub(crate) struct Index {
    pub(crate) code: Code,
    pub(crate) length: u32,
    pub(crate) stride: u32,
}

#[derive(Debug, Clone)]
pub(crate) enum Op {
    Eval(Code),
    If(Code, Vec<Op>, Vec<Op>),
    /// The flag is set if the body runs before the test.
    Loop {
        test: Option<Code>,
        step: Vec<Code>,
        body: Vec<Op>,
        after: bool,
    },
    Return(Option<Code>),
}

#[derive(Debug, Clone)]
pub(crate) struct Function {
    /// Number of slots of parameters and variables.
    pub(crate) frame: u32,
    pub(crate) body: Vec<Op>,
    /// `None` for `void`.
    pub(crate) result: Option<Range>,
    /// Levels of recursion of an execution.
    pub(crate) depth: u32,
    pub(crate) parameters: Vec<(Type, bool)>,
}

/// Bound of the values of an expression.
pub(crate) fn range(code: &Code, functions: &[Function]) -> Range {
    const WIDEST: (i64, i64) = (i32::MIN as i64, i32::MAX as i64);
    fn wide(code: &Code, functions: &[Function]) -> (i64, i64) {
        let of = |range: Range| (range.0 as i64, range.1 as i64);
        match code {
            Code::Const(value) => (*value as i64, *value as i64),
            Code::Load(_, range) | Code::Store { range, .. } => of(*range),
            Code::Step { range, .. } => (range.0 as i64 - 1, range.1 as i64 + 1),
            Code::Not(_) | Code::All(_) | Code::Any(_) | Code::At { .. } | Code::Copy { .. } => {
                (0, 1)
            }
            Code::Negate(inner) => {
                let (low, high) = wide(inner, functions);
                (-high, -low)
            }
            Code::Choice(parts) => {
                let (yes, no) = (wide(&parts[1], functions), wide(&parts[2], functions));
                (yes.0.min(no.0), yes.1.max(no.1))
            }
            Code::Call { function, .. } => functions[*function as usize].result.map_or((0, 0), of),
            Code::Binary(operator, parts) => {
                let (left, right) = (wide(&parts[0], functions), wide(&parts[1], functions));
                binary(*operator, left, right)
            }
        }
    }
    fn binary(operator: Binary, left: (i64, i64), right: (i64, i64)) -> (i64, i64) {
        let largest = left.0.abs().max(left.1.abs());
        match operator {
            Binary::Add => (left.0 + right.0, left.1 + right.1),
            Binary::Sub => (left.0 - right.1, left.1 - right.0),
            Binary::Mul => {
                let ends = [left.0 * right.0, left.0 * right.1, left.1 * right.0, left.1 * right.1];
                (ends.into_iter().min().unwrap_or(0), ends.into_iter().max().unwrap_or(0))
            }
            Binary::Div if right.0 > 0 => {
                let ends = [left.0 / right.0, left.0 / right.1, left.1 / right.0, left.1 / right.1];
                (ends.into_iter().min().unwrap_or(0), ends.into_iter().max().unwrap_or(0))
            }
            Binary::Div | Binary::Mod => (-largest, largest),
            Binary::Min => (left.0.min(right.0), left.1.min(right.1)),
            Binary::Max => (left.0.max(right.0), left.1.max(right.1)),
            Binary::Less | Binary::LessEqual | Binary::Greater | Binary::GreaterEqual => (0, 1),
            Binary::Equal | Binary::NotEqual => (0, 1),
            _ => WIDEST,
        }
    }
    let (low, high) = wide(code, functions);
    let clamp = |value: i64| value.clamp(WIDEST.0, WIDEST.1) as i32;
    (clamp(low), clamp(high))
}
