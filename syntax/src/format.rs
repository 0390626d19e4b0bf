//! The formatter: changes of blanks and line breaks only.
//!
//! The tokens of a tree are printed one after the other; between two of them the [`rules`] choose nothing, a
//! blank, or a line break. Deliberate layout stays: line breaks in lists, columns in which neighbouring lines
//! agree, the unit of indentation, the place of a brace. Comments, directives, inactive text and macro calls
//! are printed as they are. A declaration that does not parse is left alone, so the rest of an incomplete
//! file can be formatted. If a brace is missing, the structure of the file is a guess: the whole file is left
//! alone.
//!
//! Formatting never makes a line longer than [`Options::width`] that was not longer before, and formatting is
//! idempotent.

mod chunks;
mod columns;
mod layout;
mod print;
mod rules;
mod unit;

use crate::{SyntaxNode, TextRange, TextSize};

use print::Printer;
pub use unit::{Unit, unit_of};

/// Width of a tabulator in columns, unless the unit of indentation specifies another.
pub const TAB: usize = 8;

/// Indentation of one level in blanks, if neither an option nor the file itself specifies one.
pub const DEFAULT_UNIT: Unit = Unit::Spaces(2);

/// The formatting options of a project.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Options {
    /// White space of one level; `None` keeps the unit of the file.
    pub unit: Option<Unit>,
    /// White space of one level in a file that has no indentation yet.
    pub otherwise: Unit,
    /// Maximum length of a line, in columns.
    pub width: usize,
    /// The treatment of columns.
    pub align: Align,
}

/// The treatment of words that are in one column with words of neighbouring lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Align {
    /// The words stay in one column.
    #[default]
    Keep,
    /// Columns are reduced to one blank. Trailing comments stay in their columns.
    None,
}

impl Default for Options {
    fn default() -> Self {
        Options { unit: None, otherwise: DEFAULT_UNIT, width: 80, align: Align::Keep }
    }
}

/// Some editors put a byte order mark at the beginning of a text.
const BYTE_ORDER_MARK: char = '\u{feff}';

/// Replacement of blanks and line breaks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TextEdit {
    /// The replaced range; it holds white space only.
    pub range: TextRange,
    /// White space.
    pub new_text: String,
}

/// Returns true if every brace of a text has its partner.
pub fn is_paired(root: &SyntaxNode) -> bool {
    chunks::is_paired(root)
}

/// The edits that format a tree, in text order, disjoint.
///
/// `broken` are the ranges of syntax errors: the declarations that hold them are left as they are. With
/// `within`, only edits that touch that range are returned. Without `within`, there are no edits for a text
/// whose braces are not paired.
pub fn format(
    root: &SyntaxNode,
    broken: &[TextRange],
    within: Option<TextRange>,
    options: &Options,
) -> Vec<TextEdit> {
    if within.is_none() && !broken.is_empty() && !chunks::is_paired(root) {
        return Vec::new();
    }
    let text = root.text().to_string();
    let chunks = chunks::chunks(root, broken);
    let mut edits = Printer::new(&text, &chunks, options).print();
    // A byte order mark belongs to the text behind it.
    if text.starts_with(BYTE_ORDER_MARK) {
        let behind = TextSize::of(BYTE_ORDER_MARK);
        edits.retain(|edit| edit.range.start() > behind);
    }
    if let Some(within) = within {
        edits.retain(|edit| edit.range.intersect(within).is_some());
    }
    edits
}

/// A text with edits applied.
pub fn apply(text: &str, edits: &[TextEdit]) -> String {
    let mut out = String::with_capacity(text.len());
    let mut at = 0;
    for edit in edits {
        out.push_str(&text[at..usize::from(edit.range.start())]);
        out.push_str(&edit.new_text);
        at = usize::from(edit.range.end());
    }
    out.push_str(&text[at..]);
    out
}
