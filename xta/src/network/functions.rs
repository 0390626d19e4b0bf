//! Functions to code.

use super::scope::{LARGEST, Scope, Symbol, Symbols};
use crate::ast::{Declarator, Expr, Function, Initial, Statement, TypeExpr};
use crate::code::{self, Code, Op, Place, Root};
use crate::error::{Res, fail};
use crate::types::{Range, Type};

/// Levels of recursion that one evaluation may need.
const DEEPEST: u32 = 600;

/// Compiles a function with the names declared so far, so that no function is recursive.
pub(crate) fn function(scope: &mut Scope<'_>, function: &Function) -> Res<code::Function> {
    scope.locals.push(Symbols::default());
    let mut parameters = Vec::new();
    for parameter in &function.parameters {
        let ty = scope.resolve(&parameter.ty)?;
        let ty = scope.dimensions(ty, &parameter.declarator.dimensions)?;
        let at = parameter.declarator.name.at;
        if matches!(ty.element(), Type::Clock | Type::Chan { .. } | Type::Void) {
            return fail(at, "clocks and channels are not supported as parameters of functions");
        }
        let slot = scope.frame;
        let (root, offset) =
            if parameter.reference { (Root::Through(slot), 0) } else { (Root::Local, slot) };
        scope.allocate(at, if parameter.reference { 1 } else { ty.size() })?;
        let constant = parameter.ty.constant;
        scope.declare(
            &parameter.declarator.name,
            Symbol::Variable { root, offset, ty: ty.clone(), constant },
        )?;
        parameters.push((ty, parameter.reference));
    }
    let result = scope.resolve(&function.result)?;
    if result != Type::Void && result.range().is_none() {
        return fail(function.result.at, "a function returns an integer, a boolean or nothing");
    }
    let body = scope.block(&function.body, 1, &result)?;
    scope.locals.pop();
    let depth = scope.deepest + scope.deepest_callee;
    if depth > DEEPEST {
        return fail(
            function.name.at,
            format!("calls need more than {DEEPEST} levels of recursion"),
        );
    }
    Ok(code::Function {
        frame: scope.largest_frame,
        body,
        result: result.range(),
        depth,
        parameters,
    })
}

impl Scope<'_> {
    fn allocate(&mut self, at: u32, size: u32) -> Res<()> {
        self.frame = self.frame.saturating_add(size);
        self.largest_frame = self.largest_frame.max(self.frame);
        if self.frame as usize > LARGEST {
            return fail(at, "the variables of the function are too large");
        }
        Ok(())
    }

    fn block(&mut self, statements: &[Statement], level: u32, result: &Type) -> Res<Vec<Op>> {
        let frame = self.frame;
        self.locals.push(Symbols::default());
        let mut out = Vec::new();
        for statement in statements {
            self.statement(statement, level, result, &mut out)?;
        }
        self.locals.pop();
        self.frame = frame;
        Ok(out)
    }

    fn one(&mut self, statement: &Statement, level: u32, result: &Type) -> Res<Vec<Op>> {
        self.block(std::slice::from_ref(statement), level + 1, result)
    }

    /// An expression of a statement at a level of nesting.
    fn at_level(&mut self, expr: &Expr, level: u32) -> Res<Code> {
        let before = std::mem::take(&mut self.deepest);
        let code = self.scalar(expr)?;
        self.deepest = before.max(self.deepest + level);
        Ok(code)
    }

    fn statement(
        &mut self,
        statement: &Statement,
        level: u32,
        result: &Type,
        out: &mut Vec<Op>,
    ) -> Res<()> {
        match statement {
            Statement::Declaration(ty, declarators) => {
                for declarator in declarators {
                    self.local(ty, declarator, level, out)?;
                }
            }
            Statement::Expr(expr) => out.push(Op::Eval(self.at_level(expr, level)?)),
            Statement::Block(statements) => {
                out.extend(self.block(statements, level + 1, result)?);
            }
            Statement::If(test, yes, no) => {
                let test = self.at_level(test, level)?;
                let yes = self.one(yes, level, result)?;
                let no = match no {
                    Some(no) => self.one(no, level, result)?,
                    None => Vec::new(),
                };
                out.push(Op::If(test, yes, no));
            }
            Statement::Loop { start, test, step, body, after } => {
                for expr in start {
                    out.push(Op::Eval(self.at_level(expr, level)?));
                }
                let test = match test {
                    Some(test) => Some(self.at_level(test, level)?),
                    None => None,
                };
                let step =
                    step.iter().map(|expr| self.at_level(expr, level)).collect::<Res<_>>()?;
                let body = self.one(body, level, result)?;
                out.push(Op::Loop { test, step, body, after: *after });
            }
            Statement::Each { name, ty, body } => {
                for ops in self.copies(name, ty, |scope| scope.one(body, level, result))? {
                    out.extend(ops);
                }
            }
            Statement::Return(at, value) => {
                let value = match value {
                    Some(value) => Some(self.at_level(value, level)?),
                    None => None,
                };
                if value.is_some() == (*result == Type::Void) {
                    return fail(*at, "`return` does not fit the type of the function");
                }
                out.push(Op::Return(value));
            }
        }
        Ok(())
    }

    fn local(
        &mut self,
        ty: &TypeExpr,
        declarator: &Declarator,
        level: u32,
        out: &mut Vec<Op>,
    ) -> Res<()> {
        let of = self.resolve(ty)?;
        let of = self.dimensions(of, &declarator.dimensions)?;
        if matches!(of.element(), Type::Clock | Type::Chan { .. } | Type::Void) {
            return fail(ty.at, "clocks and channels cannot be declared in functions");
        }
        let offset = self.frame;
        self.allocate(declarator.name.at, of.size())?;
        let place = Place { root: Root::Local, offset, indices: Vec::new() };
        match &declarator.initial {
            Some(Initial::Value(expr)) if of.range().is_none() => {
                out.push(Op::Eval(self.copy(place, &of, expr)?));
            }
            initial => self.stores(offset, &of, initial.as_ref(), level, out)?,
        }
        let symbol = Symbol::Variable { root: Root::Local, offset, ty: of, constant: ty.constant };
        self.declare(&declarator.name, symbol)
    }

    /// Assignments of the initial values of a local variable.
    fn stores(
        &mut self,
        offset: u32,
        ty: &Type,
        initial: Option<&Initial>,
        level: u32,
        out: &mut Vec<Op>,
    ) -> Res<()> {
        for (offset, (value, range)) in (offset..).zip(leaves(ty, initial)?) {
            let code = match value {
                Some(expr) => self.at_level(expr, level)?,
                None => Code::Const(0.clamp(range.0.min(range.1), range.1)),
            };
            let place = Place { root: Root::Local, offset, indices: Vec::new() };
            out.push(Op::Eval(Code::Store { place, operator: None, value: Box::new(code), range }));
        }
        Ok(())
    }
}

/// The slots of a type with their initial values and ranges. `None` is the default value.
pub(crate) fn leaves<'i>(
    ty: &Type,
    initial: Option<&'i Initial>,
) -> Res<Vec<(Option<&'i Expr>, Range)>> {
    let mut out = Vec::new();
    leaf(ty, initial, &mut out)?;
    Ok(out)
}

fn leaf<'i>(
    ty: &Type,
    initial: Option<&'i Initial>,
    out: &mut Vec<(Option<&'i Expr>, Range)>,
) -> Res<()> {
    let parts: Vec<&Type> = match ty {
        Type::Array(of, length) => vec![&**of; *length as usize],
        Type::Record(fields) => fields.iter().map(|(_, ty)| ty).collect(),
        _ => {
            let range = ty.range().unwrap_or((0, 0));
            match initial {
                None => out.push((None, range)),
                Some(Initial::Value(expr)) => out.push((Some(expr), range)),
                Some(Initial::List(at, _)) => {
                    return fail(*at, "expected a single value, found a list");
                }
            }
            return Ok(());
        }
    };
    match initial {
        None => parts.iter().try_for_each(|part| leaf(part, None, out)),
        Some(Initial::List(at, values)) if values.len() != parts.len() => {
            fail(*at, format!("expected {} values, found {}", parts.len(), values.len()))
        }
        Some(Initial::List(_, values)) => {
            parts.iter().zip(values).try_for_each(|(part, value)| leaf(part, Some(value), out))
        }
        Some(Initial::Value(expr)) => fail(expr.at, "expected a list of values in `{ }`"),
    }
}
