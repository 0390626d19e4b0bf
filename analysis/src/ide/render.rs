//! Declarations, types and values as text for display.

use dotgen_syntax::{SyntaxKind, SyntaxNode, SyntaxToken};

use super::FileView;
use crate::model::{Spec, TypeId, TypeKind, Value};

/// Maximum number of displayed lines of a declaration.
const MAX_LINES: usize = 24;

/// Column after which a list of parameters is wrapped.
const WIDTH: usize = 72;

/// The text of a node in a standard layout: without comments and directives, with macros expanded.
pub(crate) fn normalized(view: &FileView<'_>, node: &SyntaxNode) -> String {
    let mut layout = Layout::default();
    for element in node.descendants_with_tokens() {
        let Some(token) = element.as_token() else {
            continue;
        };
        if token.kind().is_trivia() || is_hidden(token, node) {
            continue;
        }
        layout.token(token.kind(), &view.map().text(token));
        if layout.lines >= MAX_LINES {
            layout.out.push('…');
            break;
        }
    }
    layout.out.trim_end().to_owned()
}

/// The text of a node on one line, without body.
pub(crate) fn one_line(view: &FileView<'_>, node: &SyntaxNode) -> String {
    let mut layout = Layout { flat: true, ..Layout::default() };
    for element in node.descendants_with_tokens() {
        let Some(token) = element.as_token() else {
            continue;
        };
        if token.kind().is_trivia() || is_hidden(token, node) {
            continue;
        }
        layout.token(token.kind(), &view.map().text(token));
    }
    layout.out.trim_end().to_owned()
}

/// Returns true for directives, excluded text, and macro calls.
fn is_hidden(token: &SyntaxToken, within: &SyntaxNode) -> bool {
    token.parent_ancestors().take_while(|ancestor| ancestor != within).any(|ancestor| {
        matches!(
            ancestor.kind(),
            SyntaxKind::DIRECTIVE | SyntaxKind::INACTIVE | SyntaxKind::MACRO_CALL
        )
    })
}

#[derive(Default)]
struct Layout {
    out: String,
    indent: usize,
    lines: usize,
    previous: Option<SyntaxKind>,
    /// Depth of parentheses and brackets, and of the braces of values within.
    nesting: usize,
    flat: bool,
    /// True if the list of parameters is wrapped.
    wraps: bool,
    /// True after `case` or `default`, up to its colon: `case 1:`, but `in long n = 1 : "doc"`.
    label: bool,
}

impl Layout {
    fn token(&mut self, kind: SyntaxKind, text: &str) {
        use SyntaxKind::*;
        // A value, `= { 1, .y = 2 }`, stays on its line.
        let is_value = match kind {
            L_CURLY => self.nesting > 0 || self.previous == Some(EQ),
            _ => self.nesting > 0,
        };
        if kind == R_CURLY && !is_value {
            self.indent = self.indent.saturating_sub(1);
        }
        let fresh = match self.previous {
            Some(L_CURLY) if kind == R_CURLY || is_value => false,
            Some(L_CURLY) => self.newline(),
            Some(SEMICOLON) if self.nesting == 0 => self.newline(),
            Some(_) if kind == R_CURLY && !is_value => self.newline(),
            None => true,
            Some(_) if std::mem::take(&mut self.wraps) => {
                self.newline() && {
                    self.out.push_str("    ");
                    true
                }
            }
            _ => false,
        };
        if !fresh && self.needs_blank(kind) {
            self.out.push(' ');
        }
        self.out.push_str(text);
        match kind {
            CASE_KW | DEFAULT_KW => self.label = true,
            COLON => self.label = false,
            COMMA => {
                let line = self.out.rsplit('\n').next().unwrap_or_default();
                self.wraps = self.nesting == 1 && line.chars().count() > WIDTH;
            }
            L_CURLY if is_value => self.nesting += 1,
            R_CURLY if is_value => self.nesting = self.nesting.saturating_sub(1),
            L_CURLY => self.indent += 1,
            L_PAREN | L_BRACK => self.nesting += 1,
            R_PAREN | R_BRACK => self.nesting = self.nesting.saturating_sub(1),
            _ => {}
        }
        self.previous = Some(kind);
    }

    fn newline(&mut self) -> bool {
        if self.flat {
            return false;
        }
        self.out.push('\n');
        self.lines += 1;
        for _ in 0..self.indent {
            self.out.push_str("  ");
        }
        true
    }

    fn needs_blank(&self, kind: SyntaxKind) -> bool {
        use SyntaxKind::*;
        let Some(previous) = self.previous else {
            return false;
        };
        let glued_before = matches!(kind, SEMICOLON | COMMA | R_PAREN | R_BRACK | COLON2 | R_ANGLE)
            || (matches!(kind, DOT | L_BRACK) && !matches!(previous, L_CURLY | COMMA))
            || (kind == COLON && self.label);
        let glued_after = matches!(previous, L_PAREN | L_BRACK | COLON2 | DOT | L_ANGLE);
        if kind == COLON2 {
            // `in ::whole` and `throw ::e`, but `a::b`.
            return !(previous == IDENT || previous == PAUSE_KW || glued_after);
        }
        if matches!(kind, L_PAREN | L_ANGLE) {
            return !(previous.is_keyword() || previous == IDENT);
        }
        !(glued_before || glued_after)
    }
}

/// A value in the syntax of a specification.
pub(crate) fn value(spec: &Spec, value: &Value) -> String {
    match value {
        Value::Bool(true) => "TRUE".into(),
        Value::Bool(false) => "FALSE".into(),
        Value::Uint(number) => number.to_string(),
        Value::Int(number) => number.to_string(),
        Value::Float(number) => format!("{number:?}"),
        Value::Char(character) => format!("'{character}'"),
        Value::String(text) => format!("\"{text}\""),
        Value::Enum(id) => spec
            .types
            .get(*id)
            .and_then(|ty| ty.name.as_ref())
            .map_or_else(String::new, ToString::to_string),
    }
}

/// A type with the full names of all types in it, `pose::state[4]`.
pub(crate) fn type_text(spec: &Spec, id: TypeId) -> String {
    if spec.types.get(id).is_none() {
        return String::new();
    }
    let id = spec.member_type(id);
    match spec.full_name(id) {
        Some(full) => full.trim_start_matches("::").to_owned(),
        None => spec.composed_text(id, ", ", &|part| type_text(spec, part)),
    }
}

/// The type behind aliases, if it is more informative than the name.
pub(crate) fn resolved_type_text(spec: &Spec, id: TypeId) -> Option<String> {
    let resolved = spec.resolve_alias(id);
    let ty = spec.types.get(resolved)?;
    Some(match &ty.kind {
        TypeKind::Unknown => return None,
        TypeKind::Struct { members } => {
            format!("struct {} ({})", type_text(spec, resolved), count(members.len(), "member"))
        }
        TypeKind::Union { members, .. } => {
            format!("union {} ({})", type_text(spec, resolved), count(members.len(), "case"))
        }
        TypeKind::Enum { enumerators } => {
            format!("enum {} ({})", type_text(spec, resolved), count(enumerators.len(), "value"))
        }
        TypeKind::Exception { members } => {
            format!("exception {} ({})", type_text(spec, resolved), count(members.len(), "member"))
        }
        TypeKind::Native => format!("native {}", type_text(spec, resolved)),
        _ => type_text(spec, resolved),
    })
}

/// Size in bytes of the values of a type without padding; `None` if it depends on the value or on the
/// implementation.
pub(crate) fn packed_size(spec: &Spec, id: TypeId) -> Option<u64> {
    size(spec, id, 0)
}

fn size(spec: &Spec, id: TypeId, depth: u32) -> Option<u64> {
    // Types cannot contain themselves, but foreign data might.
    if depth > 64 {
        return None;
    }
    let ty = spec.types.get(spec.resolve_alias(id))?;
    Some(match &ty.kind {
        TypeKind::Boolean | TypeKind::Octet | TypeKind::Char => 1,
        TypeKind::Short | TypeKind::UnsignedShort => 2,
        TypeKind::Long | TypeKind::UnsignedLong | TypeKind::Float | TypeKind::Enum { .. } => 4,
        TypeKind::LongLong | TypeKind::UnsignedLongLong | TypeKind::Double => 8,
        TypeKind::Array { element, length } => {
            size(spec, *element, depth + 1)?.checked_mul(*length)?
        }
        TypeKind::Struct { members } | TypeKind::Exception { members } => {
            let mut sum = 0_u64;
            for &member in members {
                sum = sum.checked_add(size(spec, member, depth + 1)?)?;
            }
            sum
        }
        _ => return None,
    })
}

fn count(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}
