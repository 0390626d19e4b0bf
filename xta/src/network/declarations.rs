//! Declarations of variables, types, functions and priorities.

use super::functions::{function, leaves};
use super::scope::{Channel, LARGEST, Program, Scope, Symbol, Symbols, declare};
use crate::ast::{Declaration, Declarator, Expr, Initial, Name, TypeExpr};
use crate::code::{CONSTANT, Root};
use crate::error::{Res, fail};
use crate::eval::Machine;
use crate::types::Type;

/// Where declarations go: the global names, or the names of a process with its name as prefix.
pub(crate) struct Target<'n> {
    pub(crate) names: Option<&'n mut Symbols>,
    pub(crate) prefix: &'n str,
}

impl Target<'_> {
    fn scope<'p>(&'p self, program: &'p Program) -> Scope<'p> {
        Scope::new(program, self.names.as_deref())
    }

    pub(crate) fn declare(
        &mut self,
        program: &mut Program,
        name: &Name,
        symbol: Symbol,
    ) -> Res<()> {
        match &mut self.names {
            Some(names) => declare(names, name, symbol),
            None => declare(&mut program.global, name, symbol),
        }
    }
}

/// Declares what one declaration contains.
pub(crate) fn add(
    program: &mut Program,
    target: &mut Target<'_>,
    declaration: &Declaration,
) -> Res<()> {
    match declaration {
        Declaration::Variables(ty, declarators) => {
            declarators.iter().try_for_each(|declarator| variable(program, target, ty, declarator))
        }
        Declaration::Typedef(ty, declarators) => declarators.iter().try_for_each(|declarator| {
            let resolved = resolved(program, target, ty, declarator)?;
            target.declare(program, &declarator.name, Symbol::Type(resolved))
        }),
        Declaration::Function(ast) => {
            let code = function(&mut target.scope(program), ast)?;
            program.functions.push(code);
            let index = program.functions.len() as u32 - 1;
            target.declare(program, &ast.name, Symbol::Function(index))
        }
        Declaration::Priority(levels) => priority(program, target, levels),
    }
}

fn resolved(
    program: &Program,
    target: &Target<'_>,
    ty: &TypeExpr,
    declarator: &Declarator,
) -> Res<Type> {
    let mut scope = target.scope(program);
    let of = scope.resolve(ty)?;
    let of = scope.dimensions(of, &declarator.dimensions)?;
    let total = program.initial.len() + program.constants.len() + of.size() as usize;
    if of.size() as usize > LARGEST || total > LARGEST {
        return fail(declarator.name.at, format!("more than {LARGEST} variables"));
    }
    Ok(of)
}

fn variable(
    program: &mut Program,
    target: &mut Target<'_>,
    ty: &TypeExpr,
    declarator: &Declarator,
) -> Res<()> {
    let of = resolved(program, target, ty, declarator)?;
    let name = &declarator.name;
    let full = format!("{}{}", target.prefix, name.text);
    match of.element() {
        Type::Void => return fail(ty.at, "a variable cannot be `void`"),
        Type::Clock | Type::Chan { .. } => {
            if declarator.initial.is_some() {
                return fail(name.at, "clocks and channels have no initial value");
            }
            return handles(program, target, name, &full, of);
        }
        _ => {}
    }
    let values = initial(program, target, &of, declarator)?;
    if ty.constant && of.range().is_some() {
        if declarator.initial.is_none() {
            return fail(name.at, "a constant needs a value");
        }
        return target.declare(program, name, Symbol::Constant(values[0]));
    }
    let symbol = |offset, ty| Symbol::Variable { root: Root::Static, offset, ty, constant: false };
    if ty.constant {
        let offset = CONSTANT | program.constants.len() as u32;
        program.constants.extend(values);
        let symbol = Symbol::Variable { root: Root::Static, offset, ty: of, constant: true };
        return target.declare(program, name, symbol);
    }
    let offset = program.initial.len() as u32;
    program.initial.extend(values);
    of.slots(&full, &mut program.slots);
    target.declare(program, name, symbol(offset, of))
}

/// Declares clocks or channels, which are constants that are their indices.
fn handles(
    program: &mut Program,
    target: &mut Target<'_>,
    name: &Name,
    full: &str,
    ty: Type,
) -> Res<()> {
    let offset = CONSTANT | program.constants.len() as u32;
    let mut slots = Vec::new();
    ty.slots(full, &mut slots);
    for (full, _) in slots {
        let index = if let Type::Chan { urgent, broadcast } = ty.element() {
            let (urgent, broadcast) = (*urgent, *broadcast);
            program.channels.push(Channel { name: full, urgent, broadcast, priority: 0 });
            program.channels.len() - 1
        } else {
            program.clocks.push(full);
            program.clocks.len() - 1
        };
        program.constants.push(index as i32);
    }
    let symbol = Symbol::Variable { root: Root::Static, offset, ty, constant: true };
    target.declare(program, name, symbol)
}

/// The initial values of the slots of a variable.
fn initial(
    program: &Program,
    target: &Target<'_>,
    ty: &Type,
    declarator: &Declarator,
) -> Res<Vec<i32>> {
    let mut scope = target.scope(program);
    let mut machine = Machine::new(&program.functions, &program.constants, program.initial.clone());
    if let (Some(Initial::Value(expr)), None) = (&declarator.initial, ty.range()) {
        return copied(&mut scope, &mut machine, expr, ty);
    }
    let mut out = Vec::new();
    for (value, range) in leaves(ty, declarator.initial.as_ref())? {
        let Some(expr) = value else {
            out.push(0.clamp(range.0.min(range.1), range.1));
            continue;
        };
        if let Some(at) = super::edges::effect(expr) {
            return fail(at, "an initial value must not assign");
        }
        let code = scope.scalar(expr)?;
        let code = if ty.element() == &Type::Bool { scope.boolean(code) } else { code };
        let value = machine.run(&code).or_else(|trap| fail(expr.at, trap))?;
        if value < range.0 || value > range.1 {
            return fail(
                expr.at,
                format!("value {value} is out of the range [{}, {}]", range.0, range.1),
            );
        }
        out.push(value);
    }
    Ok(out)
}

/// The values of another array or record.
fn copied(
    scope: &mut Scope<'_>,
    machine: &mut Machine<'_>,
    expr: &Expr,
    ty: &Type,
) -> Res<Vec<i32>> {
    match scope.located(expr)? {
        Some(from) if from.ty == *ty && from.place.indices.is_empty() => (0..ty.size())
            .map(|slot| {
                let mut place = from.place.clone();
                place.offset += slot;
                let code = crate::code::Code::Load(place, (i32::MIN, i32::MAX));
                machine.run(&code).or_else(|trap| fail(expr.at, trap))
            })
            .collect(),
        _ => fail(expr.at, "expected a list of values in `{ }`, or a variable of the same type"),
    }
}

/// Sets the priorities of channels. Those that are not named have that of `default`.
fn priority(program: &mut Program, target: &Target<'_>, levels: &[Vec<Option<Expr>>]) -> Res<()> {
    if target.names.is_some() {
        let at = levels.iter().flatten().flatten().next().map_or(0, |expr| expr.at);
        return fail(at, "priorities of channels are declared globally");
    }
    let default =
        levels.iter().position(|level| level.iter().any(Option::is_none)).unwrap_or(0) as i32;
    let mut set = Vec::new();
    for (level, channels) in levels.iter().enumerate() {
        for expr in channels.iter().flatten() {
            let mut scope = target.scope(program);
            let found = scope.located(expr)?;
            let Some(found) = found.filter(|found| matches!(found.ty.element(), Type::Chan { .. }))
            else {
                return fail(expr.at, "expected a channel or `default`");
            };
            if !found.place.indices.is_empty() {
                return fail(expr.at, "index of a channel must be a constant here");
            }
            let first = (found.place.offset & !CONSTANT) as usize;
            let indices =
                program.constants.get(first..first + found.ty.size() as usize).unwrap_or(&[]);
            set.extend(indices.iter().map(|channel| (*channel as usize, level as i32 - default)));
        }
    }
    for (channel, priority) in set {
        if let Some(channel) = program.channels.get_mut(channel) {
            channel.priority = priority;
        }
    }
    Ok(())
}
