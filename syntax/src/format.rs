//! The formatter: changes of blanks and line breaks only.
//!
//! The tokens of a tree are printed one after the other; between two of them the [`rules`] say
//! whether there is nothing, a blank, or a line break. What an author has laid out on purpose stays:
//! line breaks in lists, columns in which neighbouring lines agree, the unit of indentation, the place
//! of a brace. Comments, directives, inactive text and macro calls are printed as they are. A
//! declaration that does not parse is left alone, so the rest of a half-typed file can be formatted.
//! Where a brace is missing, what belongs to what is a guess: such a file is left alone as a whole.
//!
//! Formatting makes no line longer than [`Options::width`] that was not, and formatting twice is
//! formatting once.

mod chunks;
mod columns;
mod page;
mod print;
mod rules;
mod unit;

use crate::{SyntaxNode, TextRange, TextSize};

use print::Printer;
pub use unit::{Unit, unit_of};

/// Columns of a tabulator, unless the unit of indentation says otherwise.
pub const TAB: usize = 8;

/// Blanks a level, where neither an option nor the file itself says so.
pub const DEFAULT_UNIT: Unit = Unit::Spaces(2);

/// The choices that a project has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Options {
    /// White space of one level; `None`: as the file has it.
    pub unit: Option<Unit>,
    /// White space of one level in a file that has none yet.
    pub otherwise: Unit,
    /// Columns that a line should not exceed.
    pub width: usize,
    /// What becomes of columns.
    pub align: Align,
}

/// What becomes of words that stand in a column with those of the lines around.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Align {
    /// They stay in one.
    #[default]
    Keep,
    /// One blank is enough. Trailing comments stay in their columns.
    None,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            unit: None,
            otherwise: DEFAULT_UNIT,
            width: 80,
            align: Align::Keep,
        }
    }
}

/// Some editors put it at the beginning of a text.
const BYTE_ORDER_MARK: char = '\u{feff}';

/// Replacement of blanks and line breaks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TextEdit {
    /// What is replaced; it holds white space only.
    pub range: TextRange,
    /// White space.
    pub new_text: String,
}

/// Whether every brace of a text has its other half.
pub fn is_paired(root: &SyntaxNode) -> bool {
    chunks::is_paired(root)
}

/// The edits that bring a tree in shape, in text order, disjoint.
///
/// `broken` are the ranges of syntax errors: the declarations that hold them are left as they are.
/// With `within`, only edits that touch that range are returned. Without, there are none for a text
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
    // A byte order mark goes with what is behind it.
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
