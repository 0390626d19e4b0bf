//! Names and their meaning.

use std::collections::HashMap;

use crate::ast::Name;
use crate::code::{Function, Root};
use crate::error::{Res, fail};
use crate::types::{Range, Type};

/// Largest number of variables, clocks or channels of a network.
pub(crate) const LARGEST: usize = 1 << 16;

#[derive(Debug, Clone)]
pub(crate) enum Symbol {
    Constant(i32),
    /// A variable, or clocks and channels: constants that are their indices.
    Variable {
        root: Root,
        offset: u32,
        ty: Type,
        constant: bool,
    },
    Function(u32),
    Type(Type),
}

pub(crate) type Symbols = HashMap<String, Symbol>;

#[derive(Debug, Clone)]
pub(crate) struct Channel {
    pub(crate) name: String,
    pub(crate) urgent: bool,
    pub(crate) broadcast: bool,
    /// Higher is more urgent.
    pub(crate) priority: i32,
}

/// A process instance as queries name it.
#[derive(Debug, Clone)]
pub(crate) struct Member {
    pub(crate) process: u32,
    pub(crate) locations: HashMap<String, i32>,
    pub(crate) names: Symbols,
}

/// Everything that code refers to.
#[derive(Debug, Clone, Default)]
pub(crate) struct Program {
    pub(crate) functions: Vec<Function>,
    pub(crate) constants: Vec<i32>,
    /// Locations of the processes, then variables.
    pub(crate) initial: Vec<i32>,
    /// Name and range of each slot of `initial`.
    pub(crate) slots: Vec<(String, Range)>,
    pub(crate) clocks: Vec<String>,
    pub(crate) channels: Vec<Channel>,
    pub(crate) global: Symbols,
    pub(crate) members: HashMap<String, Member>,
}

/// The scopes at a place of a text.
pub(crate) struct Scope<'p> {
    pub(crate) program: &'p Program,
    pub(crate) process: Option<&'p Symbols>,
    pub(crate) locals: Vec<Symbols>,
    /// Slots of the frame in use, and the most in use so far.
    pub(crate) frame: u32,
    pub(crate) largest_frame: u32,
    /// Deepest expression so far, and deepest function called.
    pub(crate) deepest: u32,
    pub(crate) deepest_callee: u32,
    /// Copies that quantifiers may still make.
    pub(crate) copies: u32,
    /// Set in queries, where `P.name` is allowed.
    pub(crate) query: bool,
}

impl<'p> Scope<'p> {
    pub(crate) fn new(program: &'p Program, process: Option<&'p Symbols>) -> Scope<'p> {
        Scope {
            program,
            process,
            locals: Vec::new(),
            frame: 0,
            largest_frame: 0,
            deepest: 0,
            deepest_callee: 0,
            copies: 20_000,
            query: false,
        }
    }

    pub(crate) fn find(&self, name: &str) -> Option<&Symbol> {
        let locals = self.locals.iter().rev().find_map(|names| names.get(name));
        locals.or_else(|| self.process?.get(name)).or_else(|| self.program.global.get(name))
    }

    pub(crate) fn symbol(&self, at: u32, name: &str) -> Res<&Symbol> {
        match self.find(name) {
            Some(symbol) => Ok(symbol),
            None => fail(at, format!("unknown name `{name}`")),
        }
    }

    /// Declares a name in the innermost scope.
    pub(crate) fn declare(&mut self, name: &Name, symbol: Symbol) -> Res<()> {
        match self.locals.last_mut() {
            Some(names) => declare(names, name, symbol),
            None => fail(name.at, "declaration outside of a block"),
        }
    }
}

/// Declares a name. A name may be declared once in a scope.
pub(crate) fn declare(names: &mut Symbols, name: &Name, symbol: Symbol) -> Res<()> {
    match names.insert(name.text.clone(), symbol) {
        None => Ok(()),
        Some(_) => fail(name.at, format!("`{}` is declared twice", name.text)),
    }
}
