//! Constant expressions: values, operators and conversions (language reference, section 7).

use crate::finding::role::Role;

use super::{
    context::Elaborator,
    operator::{BinaryProblem, binary, unary},
    value::Const,
    words,
};
use crate::{
    finding::{Finding, lints::LintWarning, values::ValueProblem},
    item_tree::{Expr, ExprKind, Path},
    model::{Name, Src, TypeKind, Value},
};

/// The content of a string literal: `\"` stands for a quote, other backslashes are kept.
pub(super) fn string_content(literal: &str) -> String {
    let text = literal.strip_prefix('"').unwrap_or(literal);
    let text = text.strip_suffix('"').unwrap_or(text);
    if !text.contains("\\\"") {
        return text.to_owned();
    }
    let mut out = String::with_capacity(text.len());
    let mut chars = text.chars().peekable();
    while let Some(c) = chars.next() {
        match (c, chars.peek()) {
            ('\\', Some('"')) => {}
            ('\\', Some(&next)) => {
                out.push('\\');
                out.push(next);
                chars.next();
            }
            _ => out.push(c),
        }
    }
    out
}

impl<'a> Elaborator<'a> {
    /// The value of an expression. Every wrong operator and name is reported.
    pub(super) fn eval(&mut self, expr: &'a Expr) -> Const {
        let at = self.src(expr.ptr);
        match &expr.kind {
            ExprKind::Bool(value) => Const::Bool(*value),
            ExprKind::Int(text) => self.integer(text, at),
            ExprKind::Float(text) => {
                let digits = text.trim_end_matches(['f', 'F', 'l', 'L']);
                digits.parse().map_or(Const::Unknown, Const::Float)
            }
            ExprKind::Fixed => {
                self.error(at, ValueProblem::FixedLiteral);
                Const::Unknown
            }
            ExprKind::Char(text) => {
                let content = text.strip_prefix('\'').unwrap_or(text);
                let content = content.strip_suffix('\'').unwrap_or(content);
                if !is_one_character(content) {
                    self.error(at, ValueProblem::NotACharacter { text: text.clone() });
                    return Const::Unknown;
                }
                self.deviation(at, LintWarning::CharacterLiteral { text: text.clone() });
                Const::Char(content.to_owned())
            }
            ExprKind::Str(parts) => {
                Const::Str(parts.iter().map(|(text, _)| string_content(text)).collect())
            }
            ExprKind::Path(path) => self.named_value(path, at),
            ExprKind::Paren(inner) => self.eval(inner),
            ExprKind::Unary { op, op_ptr, operand } => {
                let value = self.eval(operand);
                let result = unary(*op, &value);
                result.unwrap_or_else(|| {
                    let at = self.src(*op_ptr);
                    let op = op.spelling().unwrap_or_default();
                    self.error(at, ValueProblem::Unary { op, value: value.describe() });
                    value
                })
            }
            ExprKind::Binary { op, op_ptr, left, right } => {
                let left = self.eval(left);
                let right = self.eval(right);
                match binary(*op, &left, &right) {
                    Ok(value) => value,
                    Err(problem) => {
                        let at = self.src(*op_ptr);
                        self.error(at, problem.explain(*op, &left, &right));
                        match problem {
                            BinaryProblem::Kinds => left,
                            _ => Const::Unknown,
                        }
                    }
                }
            }
            ExprKind::Missing => Const::Unknown,
        }
    }

    /// The value of an integer literal.
    fn integer(&mut self, text: &Name, at: Src) -> Const {
        if let Some((value, odd)) = parse_integer(text) {
            if odd {
                self.error(at, ValueProblem::OctalDigit { text: text.clone(), value });
            }
            if value > i128::from(i32::MAX) {
                // GenoM3 keeps the low 32 bits, as a signed integer.
                let kept = value as u32 as i32;
                self.deviation(at, LintWarning::WideInteger { text: text.clone(), kept });
            }
            Const::unsigned(value)
        } else {
            self.error(at, ValueProblem::TooLong { text: text.clone() });
            Const::Unknown
        }
    }

    /// The value of a constant or enumerator.
    fn named_value(&mut self, path: &'a Path, at: Src) -> Const {
        let Some(ty) = self.resolve_path(path) else {
            self.report_unresolved(path, false);
            self.record_unresolved(crate::model::Missing::Name {
                name: words::path_text(path).into(),
                constant: true,
            });
            return Const::Unknown;
        };
        match &self.spec.ty(ty).kind {
            TypeKind::Const { value, .. } => from_value(value),
            TypeKind::Enumerator { .. } => Const::Enum(ty),
            TypeKind::Unknown => Const::Unknown,
            _ => {
                let what = words::describe(&self.spec, ty);
                let mut diagnostic = Finding::new(
                    ValueProblem::HasNoValue { path: words::path_text(path).into(), what },
                    at,
                );
                if let Some(place) = self.type_place(ty) {
                    diagnostic = diagnostic.related(place, Role::Declared);
                }
                self.report(diagnostic);
                Const::Unknown
            }
        }
    }

    /// A value that must be a non-negative integer; `None` if it is not, which was reported.
    pub(super) fn non_negative_integer(
        &mut self,
        expr: &'a Expr,
        what: &'static str,
    ) -> Option<u64> {
        let value = self.eval(expr);
        if value == Const::Unknown {
            return None;
        }
        let integer = value.integral().and_then(|integral| u64::try_from(integral).ok());
        if integer.is_none() {
            let at = self.src(expr.ptr);

            self.error(at, ValueProblem::NotNatural { what, value: value.describe() });
        }
        integer
    }
}

/// The value of an integer literal, and true if it is octal with decimal digits.
fn parse_integer(text: &str) -> Option<(i128, bool)> {
    let digits = text.trim_end_matches(['u', 'U', 'l', 'L']);
    let fits = |number: u64| i128::from(number);
    if let Some(hex) = digits.strip_prefix("0x").or(digits.strip_prefix("0X")) {
        return u64::from_str_radix(hex, 16).ok().map(|number| (fits(number), false));
    }
    match digits.strip_prefix('0') {
        None | Some("") => digits.parse().ok().map(|number| (fits(number), false)),
        Some(octal) => {
            let end = octal.find(['8', '9']);
            let valid = &octal[..end.unwrap_or(octal.len())];
            if valid.is_empty() {
                return Some((0, end.is_some()));
            }
            let value = u64::from_str_radix(valid, 8).ok()?;
            Some((fits(value), end.is_some()))
        }
    }
}

/// Returns true if the content of a character literal is one character or one escape.
fn is_one_character(content: &str) -> bool {
    let mut chars = content.chars();
    match (chars.next(), chars.next()) {
        (Some('\\'), Some(kind)) => {
            let rest = chars.as_str();
            match kind {
                'x' => {
                    (1..=2).contains(&rest.len())
                        && rest.chars().all(|character| character.is_ascii_hexdigit())
                }
                '0'..='7' => {
                    rest.len() <= 2 && rest.chars().all(|character| matches!(character, '0'..='7'))
                }
                _ => rest.is_empty(),
            }
        }
        (Some(_), None) => true,
        _ => false,
    }
}

pub(super) fn from_value(value: &Value) -> Const {
    match value {
        Value::Bool(flag) => Const::Bool(*flag),
        Value::Uint(number) => Const::unsigned(i128::from(*number)),
        Value::Int(number) => Const::Int { value: i128::from(*number), signed: true },
        Value::Float(number) => Const::Float(*number),
        Value::Char(character) => Const::Char(character.clone()),
        Value::String(text) => Const::Str(text.clone()),
        Value::Enum(enumeration) => Const::Enum(*enumeration),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integer_literals() {
        for (text, value) in [
            ("42", Some((42, false))),
            ("0x2AuL", Some((42, false))),
            ("052", Some((42, false))),
            ("0", Some((0, false))),
            ("09", Some((0, true))),
            ("0129", Some((10, true))),
            ("18446744073709551615", Some((u64::MAX.into(), false))),
            ("18446744073709551616", None),
        ] {
            assert_eq!(parse_integer(text), value, "{text}");
        }
    }

    #[test]
    fn only_quotes_are_unescaped_in_strings() {
        assert_eq!(string_content(r#""a \"b\" \\ \n""#), r#"a "b" \\ \n"#);
        assert_eq!(string_content(r#""a\\""#), r"a\\");
    }
}
