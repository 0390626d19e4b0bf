//! Expressions to code.

use super::scope::{Scope, Symbol};
use crate::ast::{BaseType, Binary, Dimension, Expr, ExprKind, TypeExpr};
use crate::code::{Argument, CONSTANT, Code, Index, Place, Root};
use crate::error::{Res, fail};
use crate::eval::apply;
use crate::types::{INT, Range, Type};

/// A variable or a part of it.
pub(crate) struct Located {
    pub(crate) place: Place,
    pub(crate) ty: Type,
    pub(crate) constant: bool,
}

impl Scope<'_> {
    /// The variable that an expression names, or `None` if the expression is of another kind.
    pub(crate) fn located(&mut self, expr: &Expr) -> Res<Option<Located>> {
        match &expr.kind {
            ExprKind::Name(name) => match self.symbol(expr.at, name)? {
                Symbol::Variable { root, offset, ty, constant } => {
                    let place = Place { root: *root, offset: *offset, indices: Vec::new() };
                    Ok(Some(Located { place, ty: ty.clone(), constant: *constant }))
                }
                _ => Ok(None),
            },
            ExprKind::Field(of, field) => {
                if let Some(symbol) = self.member(of, field) {
                    return match symbol? {
                        Symbol::Variable { root, offset, ty, constant } => {
                            let place = Place { root, offset, indices: Vec::new() };
                            Ok(Some(Located { place, ty, constant }))
                        }
                        _ => Ok(None),
                    };
                }
                let Some(mut whole) = self.located(of)? else { return Ok(None) };
                let Type::Record(fields) = &whole.ty else {
                    return fail(expr.at, format!("`.{field}` of a value that is not a record"));
                };
                let Some(position) = fields.iter().position(|(name, _)| name == field) else {
                    return fail(expr.at, format!("unknown field `{field}`"));
                };
                let before: u32 = fields[..position].iter().map(|(_, ty)| ty.size()).sum();
                let ty = fields[position].1.clone();
                whole.place.offset += before;
                Ok(Some(Located { ty, ..whole }))
            }
            ExprKind::Index(of, index) => {
                let Some(mut whole) = self.located(of)? else { return Ok(None) };
                let Type::Array(element, length) = &whole.ty else {
                    return fail(expr.at, "index of a value that is not an array");
                };
                let (element, length) = ((**element).clone(), *length);
                let (code, stride) = (self.scalar(index)?, element.size());
                match code {
                    Code::Const(value) if value < 0 || value as u32 >= length => {
                        return fail(
                            index.at,
                            format!("index {value} is out of an array of length {length}"),
                        );
                    }
                    Code::Const(value) => whole.place.offset += value as u32 * stride,
                    code => whole.place.indices.push(Index { code, length, stride }),
                }
                Ok(Some(Located { ty: element, ..whole }))
            }
            _ => Ok(None),
        }
    }

    /// The symbol of `P.name` in a query, or `None` if the expression is a field of a record.
    fn member(&self, of: &Expr, field: &str) -> Option<Res<Symbol>> {
        let ExprKind::Name(name) = &of.kind else { return None };
        if !self.query || self.find(name).is_some() {
            return None;
        }
        let Some(member) = self.program.members.get(name) else {
            return Some(fail(of.at, format!("unknown process `{name}`")));
        };
        if member.locations.contains_key(field) {
            return Some(Ok(Symbol::Type(Type::Void)));
        }
        Some(match member.names.get(field) {
            Some(symbol) => Ok(symbol.clone()),
            None => {
                fail(of.at, format!("process `{name}` has no location and no variable `{field}`"))
            }
        })
    }

    /// The test of `P.location` in a query.
    fn location(&self, expr: &Expr) -> Option<Code> {
        let ExprKind::Field(of, field) = &expr.kind else { return None };
        let ExprKind::Name(name) = &of.kind else { return None };
        if !self.query || self.find(name).is_some() {
            return None;
        }
        let member = self.program.members.get(name)?;
        let location = *member.locations.get(field)?;
        Some(Code::At { process: member.process, location })
    }

    /// The clock that an expression names, if it is one.
    pub(crate) fn clock(&mut self, expr: &Expr) -> Res<Option<u32>> {
        if !matches!(expr.kind, ExprKind::Name(_) | ExprKind::Field(..) | ExprKind::Index(..)) {
            return Ok(None);
        }
        match self.located(expr)? {
            Some(Located { place, ty: Type::Clock, .. }) => match self.load(place, INT) {
                Code::Const(clock) => Ok(Some(clock as u32)),
                _ => fail(expr.at, "index of an array of clocks must be a constant"),
            },
            _ => Ok(None),
        }
    }

    /// Reports whether a clock occurs in an expression. Unknown names are no clocks.
    pub(crate) fn mentions_clock(&mut self, expr: &Expr) -> bool {
        let mut any = |parts: &[Expr]| parts.iter().any(|part| self.mentions_clock(part));
        match &expr.kind {
            ExprKind::Name(_) | ExprKind::Field(..) | ExprKind::Index(..) => self
                .located(expr)
                .is_ok_and(|found| found.is_some_and(|found| *found.ty.element() == Type::Clock)),
            ExprKind::All(parts) | ExprKind::Any(parts) | ExprKind::Call(_, parts) => any(parts),
            ExprKind::Choice(parts) => any(&parts[..]),
            ExprKind::Not(inner) | ExprKind::Negate(inner) => self.mentions_clock(inner),
            ExprKind::Binary(_, left, right) | ExprKind::Assign(_, left, right) => {
                self.mentions_clock(left) || self.mentions_clock(right)
            }
            ExprKind::Step { place, .. } => self.mentions_clock(place),
            ExprKind::Quantifier { body, .. } => self.mentions_clock(body),
            ExprKind::Rate | ExprKind::Deadlock | ExprKind::Int(_) => false,
        }
    }

    /// The load of a place, folded if the place is a constant.
    pub(crate) fn load(&self, place: Place, range: Range) -> Code {
        if place.root == Root::Static && place.offset & CONSTANT != 0 && place.indices.is_empty() {
            let value = self.program.constants.get((place.offset & !CONSTANT) as usize);
            if let Some(value) = value {
                return Code::Const(*value);
            }
        }
        Code::Load(place, range)
    }

    /// An expression whose value is an integer or a boolean. The value of an effect without a result is 0.
    pub(crate) fn scalar(&mut self, expr: &Expr) -> Res<Code> {
        self.deepest = self.deepest.max(u32::from(expr.depth));
        let code = match &expr.kind {
            ExprKind::Int(value) => Code::Const(*value),
            ExprKind::Name(_) | ExprKind::Field(..) | ExprKind::Index(..) => self.named(expr)?,
            ExprKind::Not(inner) => match self.scalar(inner)? {
                Code::Const(value) => Code::Const(i32::from(value == 0)),
                code => Code::Not(Box::new(code)),
            },
            ExprKind::Negate(inner) => match self.scalar(inner)? {
                Code::Const(value) if value != i32::MIN => Code::Const(-value),
                code => Code::Negate(Box::new(code)),
            },
            ExprKind::Binary(operator, left, right) => {
                let (left, right) = (self.scalar(left)?, self.scalar(right)?);
                match (&left, &right) {
                    (Code::Const(a), Code::Const(b)) => match apply(*operator, *a, *b) {
                        Ok(value) => Code::Const(value),
                        Err(trap) => return fail(expr.at, trap),
                    },
                    _ => Code::Binary(*operator, Box::new([left, right])),
                }
            }
            ExprKind::All(parts) => Code::All(self.scalars(parts)?),
            ExprKind::Any(parts) => Code::Any(self.scalars(parts)?),
            ExprKind::Choice(parts) => {
                let [test, yes, no] = &**parts;
                Code::Choice(Box::new([self.scalar(test)?, self.scalar(yes)?, self.scalar(no)?]))
            }
            ExprKind::Quantifier { all, name, ty, body } => {
                let parts = self.copies(name, ty, |scope| scope.scalar(body))?;
                if *all { Code::All(parts) } else { Code::Any(parts) }
            }
            ExprKind::Assign(..) | ExprKind::Step { .. } => self.effect(expr)?,
            ExprKind::Call(name, arguments) => self.call(expr.at, name, arguments)?,
            ExprKind::Rate => {
                return fail(expr.at, "rates of clocks (stopwatches) are not supported");
            }
            ExprKind::Deadlock => {
                return fail(expr.at, "`deadlock` is a predicate of queries only");
            }
        };
        Ok(code)
    }

    fn scalars(&mut self, exprs: &[Expr]) -> Res<Vec<Code>> {
        exprs.iter().map(|expr| self.scalar(expr)).collect()
    }

    fn named(&mut self, expr: &Expr) -> Res<Code> {
        if let Some(code) = self.location(expr) {
            return Ok(code);
        }
        if let ExprKind::Field(of, field) = &expr.kind
            && let Some(symbol) = self.member(of, field)
            && let Symbol::Constant(value) = symbol?
        {
            return Ok(Code::Const(value));
        }
        if let ExprKind::Name(name) = &expr.kind {
            match self.symbol(expr.at, name)? {
                Symbol::Constant(value) => return Ok(Code::Const(*value)),
                Symbol::Function(_) => {
                    return fail(expr.at, format!("`{name}` is a function: expected `(`"));
                }
                Symbol::Type(_) => {
                    return fail(expr.at, format!("`{name}` is a type, not a value"));
                }
                Symbol::Variable { .. } => {}
            }
        }
        let Some(found) = self.located(expr)? else {
            return fail(expr.at, "expected a variable");
        };
        match (&found.ty, found.ty.range()) {
            (_, Some(range)) => Ok(self.load(found.place, range)),
            (Type::Clock, _) => fail(
                expr.at,
                "a clock may only be compared with an integer in guards, invariants and queries, or reset \
                 in `assign` (differences of clocks are not supported)",
            ),
            (Type::Chan { .. }, _) => fail(expr.at, "a channel is not a value"),
            _ => fail(expr.at, "an array or a record is not a value here"),
        }
    }

    /// One result for each value of a bounded type, with a name for the value.
    pub(crate) fn copies<T>(
        &mut self,
        name: &crate::ast::Name,
        ty: &TypeExpr,
        mut each: impl FnMut(&mut Self) -> Res<T>,
    ) -> Res<Vec<T>> {
        let resolved = self.resolve(ty)?;
        let Some((low, high)) = resolved.range() else {
            return fail(ty.at, "expected a bounded integer type");
        };
        let mut out = Vec::new();
        for value in low..=high {
            if self.copies == 0 {
                return fail(ty.at, "too many values: give the type a smaller range");
            }
            self.copies -= 1;
            self.locals.push(super::scope::Symbols::default());
            self.declare(name, Symbol::Constant(value))?;
            out.push(each(self)?);
            self.locals.pop();
        }
        Ok(out)
    }

    /// An assignment or a step.
    fn effect(&mut self, expr: &Expr) -> Res<Code> {
        let (target, step) = match &expr.kind {
            ExprKind::Step { delta, prefix, place } => (place, Some((*delta, *prefix))),
            ExprKind::Assign(_, target, _) => (target, None),
            _ => return fail(expr.at, "expected an assignment"),
        };
        let Some(found) = self.located(target)? else {
            let constant = matches!(&target.kind, ExprKind::Name(name)
                if matches!(self.find(name), Some(Symbol::Constant(_))));
            let what = if constant {
                "assignment to a constant"
            } else {
                "expected a variable to assign to"
            };
            return fail(target.at, what);
        };
        if found.constant {
            let what = if *found.ty.element() == Type::Clock {
                "a clock may be reset in `assign` of an edge only"
            } else {
                "assignment to a constant"
            };
            return fail(target.at, what);
        }
        let Located { place, ty, .. } = found;
        let ExprKind::Assign(operator, _, value) = &expr.kind else {
            let (delta, prefix) = step.unwrap_or((1, true));
            return match ty.range() {
                Some(range) => Ok(Code::Step { place, delta, prefix, range }),
                None => fail(target.at, "expected an integer variable"),
            };
        };
        let Some(range) = ty.range() else {
            return self.copy(place, &ty, value);
        };
        let mut code = self.scalar(value)?;
        if ty == Type::Bool && operator.is_none() {
            code = self.boolean(code);
        }
        Ok(Code::Store { place, operator: *operator, value: Box::new(code), range })
    }

    /// A value as a boolean: any value but 0 is 1.
    pub(crate) fn boolean(&self, code: Code) -> Code {
        let (low, high) = crate::code::range(&code, &self.program.functions);
        if low >= 0 && high <= 1 {
            return code;
        }
        Code::Binary(Binary::NotEqual, Box::new([code, Code::Const(0)]))
    }

    /// The copy of an array or a record.
    pub(crate) fn copy(&mut self, to: Place, ty: &Type, value: &Expr) -> Res<Code> {
        match self.located(value)? {
            Some(from) if from.ty == *ty => {
                Ok(Code::Copy { to, from: from.place, size: ty.size() })
            }
            Some(_) => fail(value.at, "the types of the two sides of the assignment differ"),
            None => fail(value.at, "expected a variable of the same type"),
        }
    }

    fn call(&mut self, at: u32, name: &str, arguments: &[Expr]) -> Res<Code> {
        let Symbol::Function(function) = self.symbol(at, name)? else {
            return fail(at, format!("`{name}` is not a function"));
        };
        let function = *function;
        let callee = &self.program.functions[function as usize];
        let (depth, result, parameters) = (callee.depth, callee.result, callee.parameters.clone());
        self.deepest_callee = self.deepest_callee.max(depth);
        if parameters.len() != arguments.len() {
            let (wanted, given) = (parameters.len(), arguments.len());
            return fail(at, format!("`{name}` takes {wanted} arguments, not {given}"));
        }
        let mut out = Vec::new();
        for (argument, (ty, reference)) in arguments.iter().zip(&parameters) {
            out.push(self.argument(argument, ty, *reference)?);
        }
        if result.is_none() && self.query {
            return fail(at, format!("`{name}` has no result"));
        }
        Ok(Code::Call { function, arguments: out })
    }

    fn argument(&mut self, argument: &Expr, ty: &Type, reference: bool) -> Res<Argument> {
        if let (false, Some(range)) = (reference, ty.range()) {
            let code = self.scalar(argument)?;
            let code = if *ty == Type::Bool { self.boolean(code) } else { code };
            return Ok(Argument::Value(code, range));
        }
        let Some(found) = self.located(argument)? else {
            return fail(argument.at, "expected a variable");
        };
        if found.ty != *ty {
            return fail(
                argument.at,
                "the type of the argument differs from that of the parameter",
            );
        }
        match (reference, found.constant) {
            (true, true) => fail(argument.at, "reference to a constant"),
            (true, false) => Ok(Argument::Address(found.place)),
            _ => Ok(Argument::Copy(found.place, ty.size())),
        }
    }

    /// An expression whose value is known before the first step.
    pub(crate) fn constant(&mut self, expr: &Expr) -> Res<i32> {
        let code = self.scalar(expr)?;
        if let Code::Const(value) = code {
            return Ok(value);
        }
        if !is_constant(&code) {
            return fail(expr.at, "expected a constant");
        }
        let program = self.program;
        let mut machine =
            crate::eval::Machine::new(&program.functions, &program.constants, Vec::new());
        machine.run(&code).or_else(|trap| fail(expr.at, trap))
    }

    pub(crate) fn resolve(&mut self, ty: &TypeExpr) -> Res<Type> {
        Ok(match &ty.base {
            BaseType::Bool => Type::Bool,
            BaseType::Clock => Type::Clock,
            BaseType::Void => Type::Void,
            BaseType::Chan => Type::Chan { urgent: ty.urgent, broadcast: ty.broadcast },
            BaseType::Int(None) => Type::Int(INT),
            BaseType::Int(Some(bounds)) => {
                let (low, high) = (self.constant(&bounds.0)?, self.constant(&bounds.1)?);
                // `int[0, -1]` is the type of an index that is never used.
                Type::Int((low, high))
            }
            BaseType::Named(name) => match self.symbol(ty.at, name)? {
                Symbol::Type(named) => named.clone(),
                _ => return fail(ty.at, format!("`{name}` is not a type")),
            },
            BaseType::Struct(fields) => {
                let mut out: Vec<(String, Type)> = Vec::new();
                for (ty, declarators) in fields {
                    for declarator in declarators {
                        let of = self.resolve(ty)?;
                        let of = self.dimensions(of, &declarator.dimensions)?;
                        if of.element().range().is_none()
                            && !matches!(of.element(), Type::Record(_))
                        {
                            return fail(
                                ty.at,
                                "only integers and booleans are supported in records",
                            );
                        }
                        out.push((declarator.name.text.clone(), of));
                    }
                }
                Type::Record(out.into())
            }
        })
    }

    /// An array type, of which the first dimension is the outermost.
    pub(crate) fn dimensions(&mut self, mut ty: Type, dimensions: &[Dimension]) -> Res<Type> {
        for dimension in dimensions.iter().rev() {
            let length = match dimension {
                Dimension::Length(expr) => {
                    let named = match &expr.kind {
                        ExprKind::Name(name) => match self.find(name) {
                            Some(Symbol::Type(ty)) => ty.range(),
                            _ => None,
                        },
                        _ => None,
                    };
                    match named {
                        Some(range) => index_length(range),
                        None => self.constant(expr)? as i64,
                    }
                }
                Dimension::Type(ty) => self.resolve(ty)?.range().map_or(-1, index_length),
            };
            if !(0..=super::scope::LARGEST as i64).contains(&length) {
                let at = match dimension {
                    Dimension::Length(expr) => expr.at,
                    Dimension::Type(ty) => ty.at,
                };
                return fail(at, format!("length {length} of an array is out of range"));
            }
            ty = Type::Array(ty.into(), length as u32);
        }
        Ok(ty)
    }
}

/// Length of an array that is indexed by a range from 0, or -1.
fn index_length(range: Range) -> i64 {
    if range.0 == 0 { range.1 as i64 + 1 } else { -1 }
}

/// Reports whether the value of an expression is known before the first step.
fn is_constant(code: &Code) -> bool {
    match code {
        Code::Const(_) => true,
        Code::Load(place, _) => {
            place.root == Root::Static
                && place.offset & CONSTANT != 0
                && place.indices.iter().all(|index| is_constant(&index.code))
        }
        Code::Not(inner) | Code::Negate(inner) => is_constant(inner),
        Code::Binary(_, parts) => parts.iter().all(is_constant),
        Code::All(parts) | Code::Any(parts) => parts.iter().all(is_constant),
        Code::Choice(parts) => parts.iter().all(is_constant),
        _ => false,
    }
}
