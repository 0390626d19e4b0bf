//! Types, variables, functions and priorities of channels.

use super::cursor::Cursor;
use crate::ast::{
    BaseType, Declaration, Declarator, Dimension, Expr, Function, Initial, Parameter, TypeExpr,
};
use crate::error::{Res, fail};
use crate::lexer::Kind;

impl Cursor<'_> {
    /// Reports whether a type starts here.
    pub(super) fn starts_type(&self) -> bool {
        let token = self.peek();
        let word = matches!(
            token.text,
            "const"
                | "urgent"
                | "broadcast"
                | "meta"
                | "hybrid"
                | "int"
                | "bool"
                | "clock"
                | "chan"
                | "void"
                | "struct"
                | "scalar"
                | "double"
                | "string"
        );
        word || (token.kind == Kind::Word && self.types.contains(token.text))
    }

    pub(super) fn type_expr(&mut self) -> Res<TypeExpr> {
        self.nested(Self::type_inner)
    }

    fn type_inner(&mut self) -> Res<TypeExpr> {
        let at = self.at();
        let (mut constant, mut urgent, mut broadcast) = (false, false, false);
        loop {
            if self.eat("const") {
                constant = true;
            } else if self.eat("urgent") {
                urgent = true;
            } else if self.eat("broadcast") {
                broadcast = true;
            } else if self.is("meta") {
                return fail(self.at(), "`meta` variables are not supported");
            } else {
                break;
            }
        }
        let token = self.peek();
        let base = match token.text {
            "int" => {
                self.bump();
                BaseType::Int(self.bounds()?)
            }
            "bool" | "clock" | "chan" | "void" => {
                self.bump();
                match token.text {
                    "bool" => BaseType::Bool,
                    "clock" => BaseType::Clock,
                    "chan" => BaseType::Chan,
                    _ => BaseType::Void,
                }
            }
            "struct" => {
                self.bump();
                BaseType::Struct(self.fields()?)
            }
            "scalar" | "double" | "string" | "hybrid" => {
                return fail(token.at, format!("`{}` is not supported", token.text));
            }
            // A query may use the types of its model.
            _ if token.kind == Kind::Word => BaseType::Named(self.name()?.text),
            _ => return self.unexpected("a type"),
        };
        Ok(TypeExpr { at, constant, urgent, broadcast, base })
    }

    /// `[lowest, highest]`, if any.
    fn bounds(&mut self) -> Res<Option<Box<(Expr, Expr)>>> {
        if !self.eat("[") {
            return Ok(None);
        }
        let lowest = self.expr()?;
        self.expect(",")?;
        let highest = self.expr()?;
        self.expect("]")?;
        Ok(Some(Box::new((lowest, highest))))
    }

    fn fields(&mut self) -> Res<Vec<(TypeExpr, Vec<Declarator>)>> {
        self.expect("{")?;
        let mut out = Vec::new();
        while !self.eat("}") {
            let ty = self.type_expr()?;
            out.push((ty, self.declarators()?));
        }
        Ok(out)
    }

    /// Declarators separated by commas, with the `;` at their end.
    pub(super) fn declarators(&mut self) -> Res<Vec<Declarator>> {
        let mut out = vec![self.declarator()?];
        while self.eat(",") {
            out.push(self.declarator()?);
        }
        self.expect(";")?;
        Ok(out)
    }

    fn declarator(&mut self) -> Res<Declarator> {
        let name = self.name()?;
        self.declarator_tail(name)
    }

    fn declarator_tail(&mut self, name: crate::ast::Name) -> Res<Declarator> {
        let mut dimensions = Vec::new();
        while self.eat("[") {
            dimensions.push(if self.starts_type() {
                Dimension::Type(self.type_expr()?)
            } else {
                Dimension::Length(self.expr()?)
            });
            self.expect("]")?;
        }
        let initial = if self.eat(":=") || self.eat("=") { Some(self.initial()?) } else { None };
        Ok(Declarator { name, dimensions, initial })
    }

    fn initial(&mut self) -> Res<Initial> {
        self.nested(|cursor| {
            let at = cursor.at();
            if !cursor.eat("{") {
                return Ok(Initial::Value(cursor.expr()?));
            }
            let mut parts = Vec::new();
            loop {
                if cursor.peek().kind == Kind::Word && cursor.ahead(1).text == ":" {
                    return fail(
                        cursor.at(),
                        "names of fields in a value are not supported: use their order",
                    );
                }
                parts.push(cursor.initial()?);
                if !cursor.eat(",") {
                    break;
                }
            }
            cursor.expect("}")?;
            Ok(Initial::List(at, parts))
        })
    }

    pub(super) fn parameters(&mut self) -> Res<Vec<Parameter>> {
        self.expect("(")?;
        let mut out = Vec::new();
        if self.eat(")") {
            return Ok(out);
        }
        loop {
            let ty = self.type_expr()?;
            let reference = self.eat("&");
            let declarator = self.declarator()?;
            if declarator.initial.is_some() {
                return fail(declarator.name.at, "a parameter has no default value");
            }
            out.push(Parameter { ty, reference, declarator });
            if !self.eat(",") {
                break;
            }
        }
        self.expect(")")?;
        Ok(out)
    }

    pub(super) fn declaration(&mut self) -> Res<Declaration> {
        if self.is("chan") && self.ahead(1).text == "priority" {
            return self.channel_priority();
        }
        if self.eat("typedef") {
            let ty = self.type_expr()?;
            let declarators = self.declarators()?;
            self.types.extend(declarators.iter().map(|declarator| declarator.name.text.clone()));
            return Ok(Declaration::Typedef(ty, declarators));
        }
        let ty = self.type_expr()?;
        let name = self.name()?;
        if self.is("(") {
            let parameters = self.parameters()?;
            let body = self.block()?;
            return Ok(Declaration::Function(Function { result: ty, name, parameters, body }));
        }
        let mut out = vec![self.declarator_tail(name)?];
        if self.eat(",") {
            out.extend(self.declarators()?);
        } else {
            self.expect(";")?;
        }
        Ok(Declaration::Variables(ty, out))
    }

    fn channel_priority(&mut self) -> Res<Declaration> {
        self.bump();
        self.bump();
        let mut out = vec![Vec::new()];
        loop {
            let channel = if self.eat("default") { None } else { Some(self.channel()?) };
            if let Some(last) = out.last_mut() {
                last.push(channel);
            }
            if self.eat("<") {
                out.push(Vec::new());
            } else if !self.eat(",") {
                break;
            }
        }
        self.expect(";")?;
        Ok(Declaration::Priority(out))
    }

    /// A channel, with the indices of an array.
    fn channel(&mut self) -> Res<Expr> {
        let name = self.name()?;
        let mut out = super::expressions::node(name.at, 0, crate::ast::ExprKind::Name(name.text))?;
        while self.eat("[") {
            let index = self.expr()?;
            self.expect("]")?;
            let parts = out.depth.max(index.depth);
            let kind = crate::ast::ExprKind::Index(Box::new(out), Box::new(index));
            out = super::expressions::node(name.at, parts, kind)?;
        }
        Ok(out)
    }
}
