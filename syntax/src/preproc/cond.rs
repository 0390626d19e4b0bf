//! `#if` arithmetic (language reference, 2.5): 64-bit values, the precedences of the reference, and
//! division by zero that matters only where the value depends on it.

use super::token::Token;
use crate::{finding::preprocessing::Preprocessing, kind::SyntaxKind::*, lexer::is_word};

/// Maximum nesting of parentheses, unary operators and conditionals.
const MAX_DEPTH: u32 = 200;

/// Returns true if the condition holds. `tokens` are macro-expanded, except for the operands of `defined`,
/// which are passed to `is_defined`.
///
/// # Errors
/// Fails for an invalid expression, and if the value depends on a division by zero.
pub(crate) fn evaluate(
    tokens: &[Token],
    is_defined: impl Fn(&str) -> bool,
) -> Result<bool, Preprocessing> {
    let lexemes = lexemes(tokens, is_defined)?;
    let mut parser = Parser { lexemes: &lexemes, at: 0, depth: 0 };
    let value = parser.comma_expression()?;
    if let Some(extra) = parser.peek() {
        return Err(Preprocessing::Unexpected { found: extra.describe().into() });
    }
    match value {
        Some(value) => Ok(value.bits != 0),
        None => Err(Preprocessing::DivisionByZero),
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Value {
    bits: u64,
    unsigned: bool,
}

/// `None` if the value depends on a division by zero.
type MaybeValue = Option<Value>;

impl Value {
    fn signed(value: i64) -> Value {
        Value { bits: value as u64, unsigned: false }
    }

    fn bool_value(value: bool) -> Value {
        Value::signed(i64::from(value))
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Lexeme {
    Number(Value),
    Operator(&'static str),
}

impl Lexeme {
    fn describe(&self) -> String {
        match self {
            Lexeme::Number(value) if value.unsigned => format!("`{}`", value.bits),
            Lexeme::Number(value) => format!("`{}`", value.bits as i64),
            Lexeme::Operator(operator) => format!("`{operator}`"),
        }
    }
}

const PAIRS: [&str; 8] = ["==", "!=", "<=", ">=", "&&", "||", "++", "--"];
const SINGLES: [&str; 19] = [
    "+", "-", "*", "/", "%", "!", "~", "&", "|", "^", "<", ">", "<<", ">>", "?", ":", ",", "(", ")",
];

/// Replaces numbers, names and `defined` by their values, and joins operators of two characters.
fn lexemes(
    tokens: &[Token],
    is_defined: impl Fn(&str) -> bool,
) -> Result<Vec<Lexeme>, Preprocessing> {
    let mut lexemes = Vec::with_capacity(tokens.len());
    let mut rest = tokens;
    while let Some((token, after)) = rest.split_first() {
        rest = after;
        let glued = rest.first().filter(|token| !token.spaced);
        if is_word(token.kind, &token.text) {
            let mut value = false;
            if token.text == "defined" {
                let (name, after) = match rest {
                    [open, name, close, after @ ..]
                        if open.kind == L_PAREN && close.kind == R_PAREN =>
                    {
                        (Some(name), after)
                    }
                    [name, after @ ..] => (Some(name), after),
                    [] => (None, rest),
                };
                let name = name.filter(|name| is_word(name.kind, &name.text));
                let name = name.ok_or(Preprocessing::DefinedWithoutName)?;
                value = is_defined(&name.text);
                rest = after;
            }
            lexemes.push(Lexeme::Number(Value::bool_value(value)));
            continue;
        }
        match token.kind {
            INT | FLOAT | FIXED => {
                let mut text = token.text.to_string();
                // The preprocessor's numbers are longer than the lexer's.
                while let Some((next, after)) = rest.split_first()
                    && !next.spaced
                    && (matches!(next.kind, INT | FLOAT | FIXED | DOT)
                        || is_word(next.kind, &next.text))
                {
                    text.push_str(&next.text);
                    rest = after;
                }
                lexemes.push(Lexeme::Number(number(&text)?));
            }
            CHAR => lexemes.push(Lexeme::Number(character(&token.text)?)),
            _ => {
                let pair = glued.and_then(|next| {
                    let pair = format!("{}{}", token.text, next.text);
                    PAIRS.into_iter().find(|&known| known == pair)
                });
                if let Some(pair) = pair {
                    rest = rest.get(1..).unwrap_or_default();
                    lexemes.push(Lexeme::Operator(pair));
                } else if let Some(single) = SINGLES.into_iter().find(|&text| text == token.text) {
                    lexemes.push(Lexeme::Operator(single));
                } else {
                    return Err(Preprocessing::BadToken { token: token.text.clone() });
                }
            }
        }
    }
    Ok(lexemes)
}

/// Value of a number: a decimal, octal or hexadecimal integer; digits are read up to the first dot.
fn number(text: &str) -> Result<Value, Preprocessing> {
    let spelled = text;
    let (text, whole) = match text.split_once('.') {
        Some((digits, _)) => (digits, false),
        None => (text, true),
    };
    let (digits, radix) = match text.as_bytes() {
        [b'0', b'x' | b'X', ..] => (text.get(2..).unwrap_or(""), 16),
        [b'0', ..] => (text, 8),
        _ => (text, 10),
    };
    let len = digits.find(|digit: char| !digit.is_digit(radix)).unwrap_or(digits.len());
    let (digits, suffix) = digits.split_at(len);
    let suffix = suffix.to_ascii_lowercase();
    let valid = matches!(suffix.as_str(), "" | "u" | "l" | "ll" | "ul" | "lu" | "ull" | "llu");
    if !valid || (digits.is_empty() && whole) {
        return Err(Preprocessing::NoInteger { text: spelled.into() });
    }
    let mut bits = 0u64;
    for digit in digits.chars().filter_map(|character| character.to_digit(radix)) {
        bits = bits
            .checked_mul(u64::from(radix))
            .and_then(|number| number.checked_add(u64::from(digit)))
            .ok_or_else(|| Preprocessing::TooLarge { number: spelled.into() })?;
    }
    Ok(Value { bits, unsigned: suffix.contains('u') || i64::try_from(bits).is_err() })
}

/// Value of a character constant.
fn character(text: &str) -> Result<Value, Preprocessing> {
    let wrong = || Preprocessing::NoCharacter { text: text.into() };
    let content = text.get(1..text.len().saturating_sub(1)).ok_or_else(wrong)?;
    let mut chars = content.chars();
    let value = match (chars.next().ok_or_else(wrong)?, chars.as_str()) {
        ('\\', escape) => match escape {
            "n" => 10,
            "t" => 9,
            "v" => 11,
            "b" => 8,
            "r" => 13,
            "f" => 12,
            "a" => 7,
            "\\" | "?" | "'" | "\"" => i64::from(escape.as_bytes()[0]),
            _ => {
                let (digits, radix) = match escape.strip_prefix(['x', 'X']) {
                    Some(digits) => (digits, 16),
                    None if escape.len() <= 3 => (escape, 8),
                    None => return Err(wrong()),
                };
                i64::from_str_radix(digits, radix)
                    .ok()
                    .filter(|&number| number >= 0 && !digits.starts_with('+'))
                    .ok_or_else(wrong)?
            }
        },
        (char, "") => i64::from(u32::from(char)),
        _ => return Err(wrong()),
    };
    Ok(Value::signed(value))
}

struct Parser<'a> {
    lexemes: &'a [Lexeme],
    at: usize,
    depth: u32,
}

/// Binding power of a binary operator, and true if it associates.
fn power(operator: &str) -> Option<(u8, bool)> {
    Some(match operator {
        "||" => (1, true),
        "&&" => (2, true),
        "|" | "^" => (3, true),
        "&" => (4, true),
        "==" | "!=" => (5, false),
        "<" | ">" | "<=" | ">=" => (6, false),
        "<<" | ">>" => (7, true),
        "+" | "-" => (8, true),
        "*" | "/" | "%" => (9, true),
        _ => return None,
    })
}

impl Parser<'_> {
    fn peek(&self) -> Option<&Lexeme> {
        self.lexemes.get(self.at)
    }

    fn operator(&self) -> Option<&'static str> {
        match self.peek()? {
            Lexeme::Operator(operator) => Some(operator),
            Lexeme::Number(_) => None,
        }
    }

    fn eat(&mut self, operator: &str) -> bool {
        let found = self.operator() == Some(operator);
        self.at += usize::from(found);
        found
    }

    fn comma_expression(&mut self) -> Result<MaybeValue, Preprocessing> {
        let mut value = self.conditional()?;
        while self.eat(",") {
            value = self.conditional()?;
        }
        Ok(value)
    }

    fn conditional(&mut self) -> Result<MaybeValue, Preprocessing> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(Preprocessing::TooNested);
        }
        let mut value = self.binary(1)?;
        if self.eat("?") {
            let yes = self.comma_expression()?;
            if !self.eat(":") {
                return Err(Preprocessing::NoColon);
            }
            let no = self.conditional()?;
            value = value.and_then(|binary| if binary.bits != 0 { yes } else { no });
        }
        self.depth -= 1;
        Ok(value)
    }

    fn binary(&mut self, min_power: u8) -> Result<MaybeValue, Preprocessing> {
        let mut lhs = self.unary()?;
        let mut last = 0;
        while let Some(operator) = self.operator()
            && let Some((power, associates)) = power(operator)
            && power >= min_power
        {
            if power == last && !associates {
                return Err(Preprocessing::NoChain { operator: operator.into() });
            }
            last = power;
            self.at += 1;
            let rhs = self.binary(power + 1)?;
            lhs = apply(operator, lhs, rhs);
        }
        Ok(lhs)
    }

    fn unary(&mut self) -> Result<MaybeValue, Preprocessing> {
        let mut operators = Vec::new();
        while let Some(operator) = self.operator() {
            match operator {
                "!" | "~" | "-" | "+" => operators.push(operator),
                "++" | "--" => {
                    return Err(Preprocessing::BadOperator { operator: operator.into() });
                }
                _ => break,
            }
            self.at += 1;
        }
        let mut value = self.primary()?;
        for operator in operators.into_iter().rev() {
            value = value.map(|value| match operator {
                "!" => Value::bool_value(value.bits == 0),
                "~" => Value { bits: !value.bits, ..value },
                "-" => Value { bits: value.bits.wrapping_neg(), ..value },
                _ => value,
            });
        }
        Ok(value)
    }

    fn primary(&mut self) -> Result<MaybeValue, Preprocessing> {
        if self.eat("(") {
            let value = self.comma_expression()?;
            if !self.eat(")") {
                return Err(Preprocessing::NoParenthesis);
            }
            return Ok(value);
        }
        match self.peek() {
            Some(&Lexeme::Number(value)) => {
                self.at += 1;
                if matches!(self.operator(), Some("++" | "--")) {
                    return self.unary();
                }
                Ok(Some(value))
            }
            Some(lexeme) => Err(Preprocessing::NoValue { found: lexeme.describe().into() }),
            None if self.lexemes.is_empty() => Err(Preprocessing::EmptyCondition),
            None => Err(Preprocessing::ShortCondition),
        }
    }
}

fn apply(operator: &str, lhs: MaybeValue, rhs: MaybeValue) -> MaybeValue {
    match operator {
        "&&" => {
            return if lhs?.bits == 0 {
                lhs.map(|_| Value::bool_value(false))
            } else {
                rhs.map(|value| Value::bool_value(value.bits != 0))
            };
        }
        "||" => {
            return if lhs?.bits != 0 {
                Some(Value::bool_value(true))
            } else {
                rhs.map(|value| Value::bool_value(value.bits != 0))
            };
        }
        _ => {}
    }
    let (lhs, rhs) = (lhs?, rhs?);
    if matches!(operator, "<<" | ">>") {
        return Some(shift(operator == "<<", lhs, rhs));
    }
    let unsigned = lhs.unsigned || rhs.unsigned;
    let (a, b) = (lhs.bits, rhs.bits);
    let (sa, sb) = (a as i64, b as i64);
    let less = |a: u64, b: u64| {
        if unsigned { a < b } else { (a as i64) < b as i64 }
    };
    let bits = match operator {
        "|" => a | b,
        "^" => a ^ b,
        "&" => a & b,
        "+" => a.wrapping_add(b),
        "-" => a.wrapping_sub(b),
        "*" => a.wrapping_mul(b),
        "/" | "%" if b == 0 => return None,
        "/" if unsigned => a / b,
        "%" if unsigned => a % b,
        "/" => sa.wrapping_div(sb) as u64,
        "%" => sa.wrapping_rem(sb) as u64,
        "==" => return Some(Value::bool_value(a == b)),
        "!=" => return Some(Value::bool_value(a != b)),
        "<" => return Some(Value::bool_value(less(a, b))),
        ">" => return Some(Value::bool_value(less(b, a))),
        "<=" => return Some(Value::bool_value(!less(b, a))),
        _ => return Some(Value::bool_value(!less(a, b))),
    };
    Some(Value { bits, unsigned })
}

/// A shift; a negative count shifts in the other direction, as in C compilers.
fn shift(left: bool, value: Value, count: Value) -> Value {
    let negative = !count.unsigned && (count.bits as i64) < 0;
    let by = if negative { count.bits.wrapping_neg() } else { count.bits };
    let by = u32::try_from(by).unwrap_or(u32::MAX);
    let bits = if left != negative {
        value.bits.checked_shl(by).unwrap_or(0)
    } else if value.unsigned {
        value.bits.checked_shr(by).unwrap_or(0)
    } else {
        ((value.bits as i64) >> by.min(63)) as u64
    };
    Value { bits, ..value }
}
