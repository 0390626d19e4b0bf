//! Execution of expressions and functions.

use crate::ast::Binary;
use crate::code::{Argument, CONSTANT, Code, Function, Op, Place, Root};
use crate::types::Range;

/// Statements that one evaluation may execute.
const FUEL: u32 = 1_000_000;

/// An error of the model during an execution, in words.
pub(crate) type Trap = String;

/// A memory, and the functions that work on it.
pub(crate) struct Machine<'p> {
    functions: &'p [Function],
    constants: &'p [i32],
    pub(crate) memory: Vec<i32>,
    frame: u32,
    fuel: u32,
    /// Slots below this address must not be assigned, since a condition is evaluated.
    fixed: usize,
}

/// End of the execution of statements.
enum Flow {
    Next,
    Returned(i32),
}

impl<'p> Machine<'p> {
    pub(crate) fn new(
        functions: &'p [Function],
        constants: &'p [i32],
        memory: Vec<i32>,
    ) -> Machine<'p> {
        Machine { functions, constants, memory, frame: 0, fuel: FUEL, fixed: 0 }
    }

    /// Replaces the memory.
    pub(crate) fn load(&mut self, from: &[i32]) {
        self.memory.clear();
        self.memory.extend_from_slice(from);
    }

    /// The value of an update.
    pub(crate) fn run(&mut self, code: &Code) -> Result<i32, Trap> {
        self.fuel = FUEL;
        self.fixed = 0;
        self.eval(code)
    }

    /// The value of a condition, a bound or a channel, which must not assign.
    pub(crate) fn pure(&mut self, code: &Code) -> Result<i32, Trap> {
        self.fuel = FUEL;
        self.fixed = self.memory.len();
        self.eval(code)
    }

    /// Reports whether all conditions hold.
    pub(crate) fn all(&mut self, codes: &[Code]) -> Result<bool, Trap> {
        for code in codes {
            if self.pure(code)? == 0 {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn read(&self, address: u32) -> Result<i32, Trap> {
        let value = if address & CONSTANT != 0 {
            self.constants.get((address & !CONSTANT) as usize)
        } else {
            self.memory.get(address as usize)
        };
        value.copied().ok_or_else(|| "address beyond the memory".to_owned())
    }

    fn write(&mut self, address: u32, value: i32, range: Range) -> Result<(), Trap> {
        if value < range.0 || value > range.1 {
            return Err(format!("value {value} is out of the range [{}, {}]", range.0, range.1));
        }
        if (address as usize) < self.fixed {
            return Err("a condition assigns a variable".to_owned());
        }
        match self.memory.get_mut(address as usize) {
            Some(slot) => *slot = value,
            None => return Err("assignment to a constant".to_owned()),
        }
        Ok(())
    }

    fn address(&mut self, place: &Place) -> Result<u32, Trap> {
        let mut address = match place.root {
            Root::Static => place.offset,
            Root::Local => self.frame + place.offset,
            Root::Through(slot) => self.read(self.frame + slot)? as u32 + place.offset,
        };
        for index in &place.indices {
            let value = self.eval(&index.code)?;
            if value < 0 || value as u32 >= index.length {
                return Err(format!("index {value} is out of an array of length {}", index.length));
            }
            address += value as u32 * index.stride;
        }
        Ok(address)
    }

    fn eval(&mut self, code: &Code) -> Result<i32, Trap> {
        match code {
            Code::Const(value) => Ok(*value),
            Code::Load(place, _) => {
                let address = self.address(place)?;
                self.read(address)
            }
            Code::Not(inner) => Ok(i32::from(self.eval(inner)? == 0)),
            Code::Negate(inner) => {
                self.eval(inner)?.checked_neg().ok_or_else(|| "arithmetic overflow".to_owned())
            }
            Code::Binary(operator, parts) => {
                let (left, right) = (self.eval(&parts[0])?, self.eval(&parts[1])?);
                apply(*operator, left, right)
            }
            Code::All(parts) => self.first(parts, false),
            Code::Any(parts) => self.first(parts, true),
            Code::Choice(parts) => {
                let test = self.eval(&parts[0])?;
                self.eval(&parts[if test == 0 { 2 } else { 1 }])
            }
            Code::At { process, location } => Ok(i32::from(self.read(*process)? == *location)),
            _ => self.effect(code),
        }
    }

    /// The value of the first operand that decides, as of all others.
    fn first(&mut self, parts: &[Code], decides: bool) -> Result<i32, Trap> {
        for part in parts {
            if (self.eval(part)? != 0) == decides {
                return Ok(i32::from(decides));
            }
        }
        Ok(i32::from(!decides))
    }

    fn effect(&mut self, code: &Code) -> Result<i32, Trap> {
        match code {
            Code::Store { place, operator, value, range } => {
                let right = self.eval(value)?;
                let address = self.address(place)?;
                let value = match operator {
                    Some(operator) => apply(*operator, self.read(address)?, right)?,
                    None => right,
                };
                self.write(address, value, *range)?;
                Ok(value)
            }
            Code::Step { place, delta, prefix, range } => {
                let address = self.address(place)?;
                let before = self.read(address)?;
                let after = apply(Binary::Add, before, *delta)?;
                self.write(address, after, *range)?;
                Ok(if *prefix { after } else { before })
            }
            Code::Copy { to, from, size } => {
                let (to, from) = (self.address(to)?, self.address(from)?);
                for slot in 0..*size {
                    let value = self.read(from + slot)?;
                    self.write(to + slot, value, (i32::MIN, i32::MAX))?;
                }
                Ok(0)
            }
            Code::Call { function, arguments } => self.call(*function, arguments),
            _ => Ok(0),
        }
    }

    fn call(&mut self, function: u32, arguments: &[Argument]) -> Result<i32, Trap> {
        let function = &self.functions[function as usize];
        let mut slots = Vec::with_capacity(function.frame as usize);
        for argument in arguments {
            match argument {
                Argument::Value(code, range) => {
                    let value = self.eval(code)?;
                    if value < range.0 || value > range.1 {
                        let (low, high) = range;
                        return Err(format!(
                            "argument {value} is out of the range [{low}, {high}]"
                        ));
                    }
                    slots.push(value);
                }
                Argument::Address(place) => slots.push(self.address(place)? as i32),
                Argument::Copy(place, size) => {
                    let address = self.address(place)?;
                    for slot in 0..*size {
                        slots.push(self.read(address + slot)?);
                    }
                }
            }
        }
        slots.resize(function.frame as usize, 0);
        let (frame, end) = (self.frame, self.memory.len());
        self.memory.extend_from_slice(&slots);
        self.frame = end as u32;
        let flow = self.ops(&function.body);
        self.memory.truncate(end);
        self.frame = frame;
        match (flow?, function.result) {
            (Flow::Returned(value), Some((low, high))) if value < low || value > high => {
                Err(format!("result {value} is out of the range [{low}, {high}]"))
            }
            (Flow::Returned(value), _) => Ok(value),
            (Flow::Next, None) => Ok(0),
            (Flow::Next, Some(_)) => Err("a function ended without `return`".to_owned()),
        }
    }

    fn ops(&mut self, ops: &[Op]) -> Result<Flow, Trap> {
        for op in ops {
            if let Flow::Returned(value) = self.op(op)? {
                return Ok(Flow::Returned(value));
            }
        }
        Ok(Flow::Next)
    }

    fn op(&mut self, op: &Op) -> Result<Flow, Trap> {
        self.spend()?;
        match op {
            Op::Eval(code) => {
                self.eval(code)?;
                Ok(Flow::Next)
            }
            Op::If(test, yes, no) => {
                let taken = if self.eval(test)? != 0 { yes } else { no };
                self.ops(taken)
            }
            Op::Return(value) => Ok(Flow::Returned(match value {
                Some(value) => self.eval(value)?,
                None => 0,
            })),
            Op::Loop { test, step, body, after } => {
                let mut tested = !after;
                loop {
                    self.spend()?;
                    if let (Some(test), true) = (test, tested)
                        && self.eval(test)? == 0
                    {
                        return Ok(Flow::Next);
                    }
                    tested = true;
                    if let Flow::Returned(value) = self.ops(body)? {
                        return Ok(Flow::Returned(value));
                    }
                    for step in step {
                        self.eval(step)?;
                    }
                }
            }
        }
    }

    fn spend(&mut self) -> Result<(), Trap> {
        self.fuel = self
            .fuel
            .checked_sub(1)
            .ok_or_else(|| format!("more than {FUEL} statements in one step"))?;
        Ok(())
    }
}

/// The value of a binary operator.
pub(crate) fn apply(operator: Binary, left: i32, right: i32) -> Result<i32, Trap> {
    let overflow = || "arithmetic overflow".to_owned();
    Ok(match operator {
        Binary::Add => left.checked_add(right).ok_or_else(overflow)?,
        Binary::Sub => left.checked_sub(right).ok_or_else(overflow)?,
        Binary::Mul => left.checked_mul(right).ok_or_else(overflow)?,
        Binary::Div | Binary::Mod if right == 0 => return Err("division by zero".to_owned()),
        Binary::Div => left.checked_div(right).ok_or_else(overflow)?,
        Binary::Mod => left.checked_rem(right).ok_or_else(overflow)?,
        Binary::And => left & right,
        Binary::Or => left | right,
        Binary::Xor => left ^ right,
        Binary::Left | Binary::Right => {
            let by = u32::try_from(right).ok().filter(|by| *by < 32).ok_or_else(overflow)?;
            if operator == Binary::Left { left << by } else { left >> by }
        }
        Binary::Min => left.min(right),
        Binary::Max => left.max(right),
        Binary::Less => i32::from(left < right),
        Binary::LessEqual => i32::from(left <= right),
        Binary::Greater => i32::from(left > right),
        Binary::GreaterEqual => i32::from(left >= right),
        Binary::Equal => i32::from(left == right),
        Binary::NotEqual => i32::from(left != right),
    })
}
