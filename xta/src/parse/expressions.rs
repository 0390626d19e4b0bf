//! Expressions, by precedence climbing.

use super::cursor::{Cursor, DEEPEST};
use crate::ast::{Binary, Expr, ExprKind};
use crate::error::{Res, fail};
use crate::lexer::Kind;

/// An infix operator.
#[derive(Clone, Copy)]
enum Infix {
    Binary(Binary),
    All,
    Any,
    Imply,
    Choice,
    Assign(Option<Binary>),
}

/// The infix operator of a spelling, with its precedence. Higher binds tighter. Assignment and `?` are right
/// associative.
fn infix(text: &str) -> Option<(Infix, u8)> {
    use Binary::*;
    Some(match text {
        "imply" => (Infix::Imply, 2),
        "or" => (Infix::Any, 2),
        "and" => (Infix::All, 3),
        ":=" | "=" => (Infix::Assign(None), 4),
        "+=" => (Infix::Assign(Some(Add)), 4),
        "-=" => (Infix::Assign(Some(Sub)), 4),
        "*=" => (Infix::Assign(Some(Mul)), 4),
        "/=" => (Infix::Assign(Some(Div)), 4),
        "%=" => (Infix::Assign(Some(Mod)), 4),
        "&=" => (Infix::Assign(Some(And)), 4),
        "|=" => (Infix::Assign(Some(Or)), 4),
        "^=" => (Infix::Assign(Some(Xor)), 4),
        "<<=" => (Infix::Assign(Some(Left)), 4),
        ">>=" => (Infix::Assign(Some(Right)), 4),
        "?" => (Infix::Choice, 5),
        "||" => (Infix::Any, 6),
        "&&" => (Infix::All, 7),
        "|" => (Infix::Binary(Or), 8),
        "^" => (Infix::Binary(Xor), 9),
        "&" => (Infix::Binary(And), 10),
        "==" => (Infix::Binary(Equal), 11),
        "!=" => (Infix::Binary(NotEqual), 11),
        "<" => (Infix::Binary(Less), 12),
        "<=" => (Infix::Binary(LessEqual), 12),
        ">" => (Infix::Binary(Greater), 12),
        ">=" => (Infix::Binary(GreaterEqual), 12),
        "<?" => (Infix::Binary(Min), 13),
        ">?" => (Infix::Binary(Max), 13),
        "<<" => (Infix::Binary(Left), 14),
        ">>" => (Infix::Binary(Right), 14),
        "+" => (Infix::Binary(Add), 15),
        "-" => (Infix::Binary(Sub), 15),
        "*" => (Infix::Binary(Mul), 16),
        "/" => (Infix::Binary(Div), 16),
        "%" => (Infix::Binary(Mod), 16),
        _ => return None,
    })
}

/// Level of the operands of `-` and `!`.
const UNARY: u8 = 17;

/// Level of the operand of `not`: `not a == b` is `not (a == b)`.
const NOT: u8 = 4;

/// An expression one level above its parts.
pub(super) fn node(at: u32, parts: u16, kind: ExprKind) -> Res<Expr> {
    if parts >= DEEPEST {
        return fail(at, format!("expression with more than {DEEPEST} levels"));
    }
    Ok(Expr { at, depth: parts + 1, kind })
}

fn deepest(exprs: &[Expr]) -> u16 {
    exprs.iter().map(|expr| expr.depth).max().unwrap_or(0)
}

impl Cursor<'_> {
    pub(super) fn expr(&mut self) -> Res<Expr> {
        self.climb(0)
    }

    /// An expression whose infix operators have at least the precedence `level`.
    fn climb(&mut self, level: u8) -> Res<Expr> {
        self.nested(|cursor| {
            let mut left = cursor.unary()?;
            loop {
                let token = cursor.peek();
                let Some((operator, precedence)) =
                    (token.kind != Kind::Text).then(|| infix(token.text)).flatten()
                else {
                    return Ok(left);
                };
                if precedence < level || cursor.ends_sync() {
                    return Ok(left);
                }
                cursor.bump();
                left = cursor.infix_tail(left, operator, precedence, token.at)?;
            }
        })
    }

    /// Reports whether `?` ends the channel of a synchronisation, since no operand follows.
    fn ends_sync(&self) -> bool {
        self.is("?") && matches!(self.ahead(1).text, ";" | "," | "}" | "")
    }

    fn infix_tail(&mut self, left: Expr, operator: Infix, precedence: u8, at: u32) -> Res<Expr> {
        match operator {
            Infix::Assign(operator) => {
                let right = self.climb(precedence)?;
                let parts = left.depth.max(right.depth);
                node(at, parts, ExprKind::Assign(operator, Box::new(left), Box::new(right)))
            }
            Infix::Choice => {
                let yes = self.climb(4)?;
                self.expect(":")?;
                let no = self.climb(precedence)?;
                let parts = left.depth.max(yes.depth).max(no.depth);
                node(at, parts, ExprKind::Choice(Box::new([left, yes, no])))
            }
            Infix::Imply => {
                let right = self.climb(precedence + 1)?;
                let not = node(left.at, left.depth, ExprKind::Not(Box::new(left)))?;
                join(at, vec![not], right, false)
            }
            Infix::All | Infix::Any => {
                let right = self.climb(precedence + 1)?;
                let all = matches!(operator, Infix::All);
                let parts = match left.kind {
                    ExprKind::All(parts) if all => parts,
                    ExprKind::Any(parts) if !all => parts,
                    kind => vec![Expr { kind, ..left }],
                };
                join(at, parts, right, all)
            }
            Infix::Binary(operator) => {
                let right = self.climb(precedence + 1)?;
                let parts = left.depth.max(right.depth);
                node(at, parts, ExprKind::Binary(operator, Box::new(left), Box::new(right)))
            }
        }
    }

    fn unary(&mut self) -> Res<Expr> {
        let token = self.peek();
        let minus_number = token.text == "-" && self.ahead(1).kind == Kind::Number;
        match token.text {
            "-" if minus_number => {
                self.bump();
                let number = self.bump();
                let value = integer(&format!("-{}", number.text), token.at)?;
                node(token.at, 0, ExprKind::Int(value))
            }
            "-" | "+" | "!" => {
                self.bump();
                let operand = self.climb(UNARY)?;
                let depth = operand.depth;
                match token.text {
                    "-" => node(token.at, depth, ExprKind::Negate(Box::new(operand))),
                    "+" => Ok(operand),
                    _ => node(token.at, depth, ExprKind::Not(Box::new(operand))),
                }
            }
            "not" => {
                self.bump();
                let operand = self.climb(NOT)?;
                node(token.at, operand.depth, ExprKind::Not(Box::new(operand)))
            }
            "++" | "--" => {
                self.bump();
                let delta = if token.text == "++" { 1 } else { -1 };
                let place = Box::new(self.climb(UNARY)?);
                node(token.at, place.depth, ExprKind::Step { delta, prefix: true, place })
            }
            "forall" | "exists" => self.quantifier(),
            "sum" => fail(token.at, "`sum` is not supported: write the sum out"),
            _ => self.postfix(),
        }
    }

    fn quantifier(&mut self) -> Res<Expr> {
        let word = self.bump();
        self.expect("(")?;
        let name = self.name()?;
        self.expect(":")?;
        let ty = Box::new(self.type_expr()?);
        self.expect(")")?;
        // The body extends as far as possible.
        let body = Box::new(self.climb(0)?);
        let all = word.text == "forall";
        node(word.at, body.depth, ExprKind::Quantifier { all, name, ty, body })
    }

    fn postfix(&mut self) -> Res<Expr> {
        let mut left = self.primary()?;
        loop {
            let at = self.at();
            if self.eat("[") {
                let index = self.expr()?;
                self.expect("]")?;
                let parts = left.depth.max(index.depth);
                left = node(at, parts, ExprKind::Index(Box::new(left), Box::new(index)))?;
            } else if self.eat(".") {
                let field = self.name()?.text;
                left = node(at, left.depth, ExprKind::Field(Box::new(left), field))?;
            } else if self.is("++") || self.is("--") {
                let delta = if self.bump().text == "++" { 1 } else { -1 };
                let place = Box::new(left);
                left = node(at, place.depth, ExprKind::Step { delta, prefix: false, place })?;
            } else if self.eat("'") {
                left = node(at, left.depth, ExprKind::Rate)?;
            } else {
                return Ok(left);
            }
        }
    }

    fn primary(&mut self) -> Res<Expr> {
        let token = self.peek();
        match (token.kind, token.text) {
            (Kind::Number, text) => {
                self.bump();
                node(token.at, 0, ExprKind::Int(integer(text, token.at)?))
            }
            (_, "true" | "false") => {
                self.bump();
                node(token.at, 0, ExprKind::Int(i32::from(token.text == "true")))
            }
            (_, "deadlock") => {
                self.bump();
                node(token.at, 0, ExprKind::Deadlock)
            }
            (_, "(") => {
                self.bump();
                let inner = self.expr()?;
                self.expect(")")?;
                Ok(inner)
            }
            (Kind::Word, _) => {
                let name = self.name()?;
                if !self.eat("(") {
                    return node(name.at, 0, ExprKind::Name(name.text));
                }
                let arguments = self.list(")")?;
                self.expect(")")?;
                node(name.at, deepest(&arguments), ExprKind::Call(name.text, arguments))
            }
            _ => self.unexpected("an expression"),
        }
    }

    /// Expressions separated by commas, possibly none, before `end`.
    pub(super) fn list(&mut self, end: &str) -> Res<Vec<Expr>> {
        let mut out = Vec::new();
        if self.is(end) {
            return Ok(out);
        }
        loop {
            out.push(self.expr()?);
            if !self.eat(",") {
                return Ok(out);
            }
        }
    }
}

/// A conjunction or a disjunction with one more part.
fn join(at: u32, mut parts: Vec<Expr>, last: Expr, all: bool) -> Res<Expr> {
    parts.push(last);
    let depth = deepest(&parts);
    node(at, depth, if all { ExprKind::All(parts) } else { ExprKind::Any(parts) })
}

fn integer(text: &str, at: u32) -> Res<i32> {
    if text.contains(['.', 'e', 'E']) {
        return fail(at, format!("`{text}`: numbers with a fraction are not supported"));
    }
    match text.parse() {
        Ok(value) => Ok(value),
        Err(_) => fail(at, format!("`{text}` is beyond 32 bits")),
    }
}
