//! Statements of functions.

use super::cursor::Cursor;
use crate::ast::Statement;
use crate::error::{Res, fail};

impl Cursor<'_> {
    /// `{ … }`
    pub(super) fn block(&mut self) -> Res<Vec<Statement>> {
        self.expect("{")?;
        let mut out = Vec::new();
        while !self.eat("}") {
            out.push(self.statement()?);
        }
        Ok(out)
    }

    fn statement(&mut self) -> Res<Statement> {
        self.nested(Self::statement_inner)
    }

    fn statement_inner(&mut self) -> Res<Statement> {
        let token = self.peek();
        match token.text {
            "{" => Ok(Statement::Block(self.block()?)),
            ";" => {
                self.bump();
                Ok(Statement::Block(Vec::new()))
            }
            "if" => {
                self.bump();
                let test = self.test()?;
                let yes = Box::new(self.statement()?);
                let no = if self.eat("else") { Some(Box::new(self.statement()?)) } else { None };
                Ok(Statement::If(test, yes, no))
            }
            "while" => {
                self.bump();
                let test = Some(self.test()?);
                let body = Box::new(self.statement()?);
                Ok(Statement::Loop {
                    start: Vec::new(),
                    test,
                    step: Vec::new(),
                    body,
                    after: false,
                })
            }
            "do" => {
                self.bump();
                let body = Box::new(self.statement()?);
                self.expect("while")?;
                let test = Some(self.test()?);
                self.expect(";")?;
                Ok(Statement::Loop { start: Vec::new(), test, step: Vec::new(), body, after: true })
            }
            "for" => self.counted(),
            "return" => {
                self.bump();
                let value = if self.is(";") { None } else { Some(self.expr()?) };
                self.expect(";")?;
                Ok(Statement::Return(token.at, value))
            }
            "break" | "continue" | "switch" => {
                fail(token.at, format!("`{}` is not supported in functions", token.text))
            }
            _ if self.starts_type() => {
                let ty = self.type_expr()?;
                Ok(Statement::Declaration(ty, self.declarators()?))
            }
            _ => {
                let expr = self.expr()?;
                self.expect(";")?;
                Ok(Statement::Expr(expr))
            }
        }
    }

    fn test(&mut self) -> Res<crate::ast::Expr> {
        self.expect("(")?;
        let test = self.expr()?;
        self.expect(")")?;
        Ok(test)
    }

    fn counted(&mut self) -> Res<Statement> {
        self.bump();
        self.expect("(")?;
        if self.ahead(1).text == ":" {
            let name = self.name()?;
            self.expect(":")?;
            let ty = self.type_expr()?;
            self.expect(")")?;
            let body = Box::new(self.statement()?);
            return Ok(Statement::Each { name, ty, body });
        }
        let start = self.list(";")?;
        self.expect(";")?;
        let test = if self.is(";") { None } else { Some(self.expr()?) };
        self.expect(";")?;
        let step = self.list(")")?;
        self.expect(")")?;
        let body = Box::new(self.statement()?);
        Ok(Statement::Loop { start, test, step, body, after: false })
    }
}
