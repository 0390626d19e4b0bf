//! Constant expressions.

use super::*;

/// A finished expression and its depth: a long chain of operators makes a deep tree too.
type Operand = (CompletedMarker, u32);

/// Maximum depth of an expression.
const MAX_HEIGHT: u32 = 200;

const FIRST: TokenSet = TokenSet::new(&[
    TRUE_KW,
    FALSE_KW,
    INT,
    FLOAT,
    FIXED,
    CHAR,
    STRING,
    OPEN_STRING,
    L_PAREN,
    IDENT,
    COLON2,
    MINUS,
    PLUS,
    TILDE,
]);

/// A constant expression; reports a missing one.
// test expr
// const long a = 1 | 2 ^ 3 & 4 << 5 >> 6 + 7 - 8 * 9 / 10 % 11;
// const long b = -(1 + m::n) * ~2 - +3;
// const string c = "a" "b";
// const boolean d = TRUE;
// const double e = 1.5 + .5e3;
// const char f = 'x';
// const long g = a xor b bitand c bitor compl d;
pub(super) fn expr(p: &mut Parser<'_>) -> bool {
    expr_or(p, "a value")
}

/// Like `expr`; `what` is the expected thing, for the message.
pub(super) fn expr_or(p: &mut Parser<'_>, what: &str) -> bool {
    let outer = std::mem::replace(&mut p.in_angles, false);
    let found = binary(p, 1, what).is_some();
    p.in_angles = outer;
    found
}

/// An expression between `<` and `>`, where a `>>` may be two closing brackets.
pub(super) fn in_angles(p: &mut Parser<'_>) {
    let outer = std::mem::replace(&mut p.in_angles, true);
    binary(p, 1, "a value");
    p.in_angles = outer;
}

/// The binding power of the current token as a binary operator; 0 if it is not one.
fn binding_power(p: &Parser<'_>) -> u8 {
    match p.current() {
        PIPE => 1,
        CARET => 2,
        AMP => 3,
        SHR if p.in_angles && !p.nth_at_ts(1, FIRST) => 0,
        SHL | SHR => 4,
        PLUS | MINUS => 5,
        STAR | SLASH | PERCENT => 6,
        _ => 0,
    }
}

fn binary(p: &mut Parser<'_>, weakest: u8, what: &str) -> Option<Operand> {
    let (mut lhs, mut height) = unary(p, what)?;
    loop {
        let binding_power = binding_power(p);
        if binding_power < weakest || binding_power == 0 {
            return Some((lhs, height));
        }
        if height >= MAX_HEIGHT {
            p.error_here(Parsing::LongExpression);
            p.skip_construct();
            return Some((lhs, height));
        }
        let m = lhs.precede(p);
        p.bump_any();
        let rhs = binary(p, binding_power + 1, "a value after the operator");
        height = height.max(rhs.map_or(0, |binary| binary.1)) + 1;
        lhs = m.complete(p, BINARY_EXPR);
        if rhs.is_none() {
            return Some((lhs, height));
        }
    }
}

fn unary(p: &mut Parser<'_>, what: &str) -> Option<Operand> {
    if !(p.at(MINUS) || p.at(PLUS) || p.at(TILDE)) {
        return primary(p, what);
    }
    let m = p.start();
    p.bump_any();
    let height = if p.at(MINUS) || p.at(PLUS) || p.at(TILDE) {
        p.error_here(Parsing::TwoOperators);
        while p.at(MINUS) || p.at(PLUS) || p.at(TILDE) {
            p.bump_any();
        }
        primary(p, "a value after the operator")
    } else {
        primary(p, "a value after the operator")
    };
    let height = height.map_or(0, |height| height.1) + 1;
    Some((m.complete(p, PREFIX_EXPR), height))
}

fn primary(p: &mut Parser<'_>, what: &str) -> Option<Operand> {
    let m = p.start();
    let done = match p.current() {
        TRUE_KW | FALSE_KW | INT | FLOAT | FIXED | CHAR => {
            p.bump_any();
            m.complete(p, LITERAL)
        }
        STRING | OPEN_STRING => {
            while p.at(STRING) || p.at(OPEN_STRING) {
                string_token(p);
            }
            m.complete(p, LITERAL)
        }
        IDENT | COLON2 => {
            path(p);
            m.complete(p, PATH_EXPR)
        }
        L_PAREN => return paren(p, m),
        _ => {
            m.abandon(p);
            p.expected(what);
            return None;
        }
    };
    Some((done, 1))
}

fn paren(p: &mut Parser<'_>, m: Marker) -> Option<Operand> {
    if !p.enter() {
        m.abandon(p);
        return None;
    }
    p.bump(L_PAREN);
    let outer = std::mem::replace(&mut p.in_angles, false);
    let inner = binary(p, 1, "a value");
    p.in_angles = outer;
    p.expect(R_PAREN);
    p.leave();
    let height = inner.map_or(0, |binary| binary.1) + 1;
    Some((m.complete(p, PAREN_EXPR), height))
}
