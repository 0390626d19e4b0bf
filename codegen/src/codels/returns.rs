//! The values that a codel may return, for completion after `return`.

use std::ops::Range;

use camino::Utf8Path;
use dotgen_analysis::model::{CodelKind, TypeKind};

use super::expected::{Expected, state_text};
use super::files::{IndexedFile, Sources};
use super::source::{Grammar, parse};
use crate::lang::Language;

/// A value that a codel may return.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReturnValue {
    /// The text in the mapping of the component.
    pub text: String,
    /// The state or exception in the specification.
    pub detail: String,
}

/// The text after `return` at an offset: the part of a value that is already written.
pub fn written_value(text: &str, offset: usize) -> Option<Range<usize>> {
    let before = text.get(..offset)?;
    let value = before.trim_end_matches(|c: char| c.is_alphanumeric() || matches!(c, '_' | ':'));
    let keyword = value.trim_end_matches([' ', '\t']);
    let word = keyword.strip_suffix("return")?;
    let apart = keyword.len() < value.len();
    let is_word = !word.ends_with(|c: char| c.is_alphanumeric() || c == '_');
    (apart && is_word).then_some(value.len()..offset)
}

/// The values that the codels of the function around an offset may return: events in the order of their
/// yields, then exceptions. C++ throws exceptions; they are absent there.
pub fn return_values(
    expected: &Expected<'_>,
    sources: &Sources,
    path: &Utf8Path,
    offset: usize,
) -> Vec<ReturnValue> {
    let mut out: Vec<ReturnValue> = Vec::new();
    let Some(file) = sources.file(path).filter(|file| !is_in_comment(file, offset)) else {
        return out;
    };
    let around = file.index().function_at(offset);
    let Some((around, function)) =
        around.and_then(|around| Some((around, expected.function(&around.name)?)))
    else {
        return out;
    };
    let component = expected.component();
    let mut add = |text: String, detail: String| {
        if !out.iter().any(|known| known.text == text) {
            out.push(ReturnValue { text, detail });
        }
    };
    for at in &function.uses {
        let codel = component.codel(*at);
        if codel.kind != CodelKind::Fsm {
            add(expected.ok().to_owned(), format!("end of codel {}", codel.name));
        }
        for state in &codel.yields {
            let detail = format!("yield {} of codel {}", state_text(state), codel.name);
            add(expected.spelling(state.event).to_string(), detail);
        }
    }
    let mut contexts =
        around.parameters.iter().filter(|parameter| parameter.ty.base == "genom_context");
    let context = contexts.next().and_then(|parameter| parameter.name.as_deref());
    let Some(context) = context.filter(|_| expected.language == Language::C) else {
        return out;
    };
    for exception in function.uses.iter().flat_map(|at| expected.throws_of(at.owner)) {
        let spelling = expected.spelling(exception);
        let TypeKind::Exception { members } = &expected.spec.ty(exception).kind else {
            continue;
        };
        let text = match file.grammar {
            _ if members.is_empty() => format!("{spelling}({context})"),
            Grammar::C => format!("{spelling}(&({spelling}_detail){{0}}, {context})"),
            // C++ has no address of a temporary detail.
            Grammar::Cxx => continue,
        };
        let name = expected.spec.full_name(exception).unwrap_or_default();
        add(text, format!("exception {}", name.trim_start_matches("::")));
    }
    out
}

fn is_in_comment(file: &IndexedFile, offset: usize) -> bool {
    let Some(tree) = parse(&file.text, file.grammar) else {
        return true;
    };
    let before = offset.saturating_sub(1);
    let node = tree.root_node().descendant_for_byte_range(before, before);
    node.is_some_and(|node| node.kind() == "comment" || node.kind().starts_with("string"))
}

#[cfg(test)]
mod tests {
    use super::written_value;

    #[test]
    fn a_value_is_the_word_after_return() {
        let written =
            |text: &str| written_value(text, text.len()).map(|range| text[range].to_owned());
        assert_eq!(written("{ return "), Some(String::new()));
        assert_eq!(written("if (x) return c_ma"), Some("c_ma".to_owned()));
        assert_eq!(written("return c::ma"), Some("c::ma".to_owned()));
        for other in ["return", "no_return ", "return 1 + ", "x = ", "returns "] {
            assert_eq!(written(other), None, "{other}");
        }
    }
}
