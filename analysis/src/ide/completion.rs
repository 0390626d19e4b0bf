//! Completion at the cursor.
//!
//! [`context`](super::context) gives the position of the cursor in the structure, the elaborated unit gives
//! the names. Each submodule proposes one sort of item; nothing here needs a tree, so that completion works
//! in incomplete text.

mod codel;
mod directive;
mod elements;
pub(super) mod initializer;
mod keywords;
pub(super) mod names;
pub(super) mod parameter;
pub(super) mod parameter_list;
mod pattern;
mod scopes;
mod sharing;
mod statement;

use std::ops::Range;

use rustc_hash::FxHashSet;
use smol_str::SmolStr;

use super::{
    FileView, SymbolKind,
    context::{Context, FrameKind, Surroundings, Word, surroundings},
    hover,
};
use crate::elab::DefId;
use names::VisibleNames;

/// The kind of an item.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CompletionKind {
    Keyword,
    /// A whole clause.
    Snippet,
    Symbol(SymbolKind),
    BaseType,
    Unit,
    Directory,
    Package,
}

/// The text that is inserted with the name of a codel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CodelPlace {
    /// True if its parameters are inserted with it; otherwise they follow already.
    pub parameters: bool,
    /// The text inserted after the parameters: an LSP snippet.
    pub tail: &'static str,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CompletionItem {
    /// The displayed text.
    pub label: String,
    pub kind: CompletionKind,
    /// Type, direction…
    pub detail: Option<String>,
    /// The inserted text; with the placeholders of LSP snippets if `snippet`.
    pub insert: String,
    /// True if `insert` has placeholders.
    pub snippet: bool,
    /// The replaced byte range.
    pub replace: Range<usize>,
    /// The text that typed letters are matched with, if it differs from the label: `throws` for `throw`.
    pub filter: Option<String>,
    /// Smaller comes first.
    pub rank: u8,
    /// The definition, for [`CompletionDoc`].
    pub definition: Option<DefId>,
    /// The name of the definition, to find out later whether the text has changed.
    pub name: Option<SmolStr>,
    /// Set for the name of a codel: functions that no specification names fit here as well.
    pub codel: Option<CodelPlace>,
}

/// The documentation of an item, shown when it is selected.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CompletionDoc {
    pub markdown: String,
}

/// A snippet without its placeholders, for clients that do not support them. All occurrences of a placeholder
/// get the text of the first one.
pub fn plain_snippet(snippet: &str) -> String {
    let mut out = String::with_capacity(snippet.len());
    let mut chars = snippet.chars().peekable();
    let mut known: Vec<(String, String)> = Vec::new();
    // Open placeholders: number, and start of the text.
    let mut open: Vec<(String, usize)> = Vec::new();
    while let Some(character) = chars.next() {
        match character {
            '\\' => out.extend(chars.next()),
            '$' => {
                let braced = chars.next_if_eq(&'{').is_some();
                let mut number = String::new();
                while let Some(digit) = chars.next_if(char::is_ascii_digit) {
                    number.push(digit);
                }
                if braced && chars.next_if_eq(&'|').is_some() {
                    // For a choice, the first one.
                    let all: String =
                        chars.by_ref().take_while(|character| *character != '|').collect();
                    let first = all.split(',').next().unwrap_or_default();
                    out.push_str(first);
                    known.push((number, first.to_owned()));
                    chars.next_if_eq(&'}');
                } else if braced && chars.next_if_eq(&':').is_some() {
                    open.push((number, out.len()));
                } else {
                    if let Some((_, text)) = known.iter().find(|entry| entry.0 == number) {
                        out.push_str(text);
                    }
                    if braced {
                        chars.next_if_eq(&'}');
                    }
                }
            }
            '}' if !open.is_empty() => {
                if let Some((number, start)) = open.pop() {
                    known.push((number, out[start..].to_owned()));
                }
            }
            _ => out.push(character),
        }
    }
    out
}

/// Completion items at a cursor, best first.
pub(crate) fn completions(view: &FileView<'_>, at: usize) -> Vec<CompletionItem> {
    let at = at.min(view.text().len());
    if !view.text().is_char_boundary(at) {
        return Vec::new();
    }
    let context = Context::new(view, at);
    let mut out = Completions::empty();
    out.replace = context.word.clone();
    match surroundings(view, at) {
        Surroundings::Dead => {}
        Surroundings::Directive(index) => directive::complete(view, index, at, &mut out),
        Surroundings::String(range) => {
            out.replace = range.start + 1..at.max(range.start + 1);
            if statement::in_requires(&context) {
                directive::packages(view, &mut out);
            } else if statement::in_lang(&context) {
                for language in ["c", "c++"] {
                    out.add(language, CompletionKind::Keyword, 0);
                }
            }
        }
        // A directive is alone on its line.
        Surroundings::Code if line_behind(view, context.word.end.max(at)).starts_with('#') => {}
        Surroundings::Code => {
            let names = VisibleNames::new(view, &context, at);
            code(&names, &context, &mut out);
        }
    }
    let mut items = out.finish();
    let definitions = &view.elaborated().definitions;
    for item in &mut items {
        item.name = item.definition.map(|id| definitions[id].name.clone());
    }
    items
}

/// The rest of the cursor's line, without blanks.
fn line_behind<'v>(view: &'v FileView<'_>, at: usize) -> &'v str {
    let rest = view.text().get(at..).unwrap_or_default();
    rest.lines().next().unwrap_or_default().trim()
}

/// Documentation of an item.
pub(crate) fn resolve(view: &FileView<'_>, definition: DefId, name: &str) -> Option<CompletionDoc> {
    let found = view.elaborated().definitions.get(definition)?;
    // The text may have changed since the item was proposed.
    if found.name != name {
        return None;
    }
    let markdown = hover::definition(view, definition)?;
    Some(CompletionDoc { markdown })
}

fn code(names: &VisibleNames<'_, '_>, context: &Context, out: &mut Completions) {
    propose(names, context, out);
    // No value is proposed before another one.
    use dotgen_syntax::SyntaxKind::*;
    let value = |word: &Word| matches!(word.kind, INT | FLOAT | STRING | CHAR);
    if context.after.next().is_some_and(value) {
        out.items.retain(|completion_item| {
            use SymbolKind::*;
            !matches!(completion_item.kind, CompletionKind::Symbol(Const | Enumerator | Macro))
                && !["TRUE", "FALSE"].contains(&completion_item.label.as_str())
        });
    }
    // A path that continues after the cursor is replaced as a whole; in parameters `::` renames.
    if !matches!(context.top().kind, FrameKind::Paren) {
        let rest = &context.after.rest;
        let path = rest
            .iter()
            .take_while(|word| word.is("::") || word.kind == dotgen_syntax::SyntaxKind::IDENT);
        let path = path.count();
        if rest.first().is_some_and(|word| word.is("::")) {
            out.replaces_too(&rest[..path]);
        }
    }
}

fn propose(names: &VisibleNames<'_, '_>, context: &Context, out: &mut Completions) {
    match context.top().kind {
        FrameKind::Body(kind) => statement::complete(names, context, kind, out),
        FrameKind::Paren => parameter::in_parentheses(names, context, out),
        FrameKind::Bracket => names.numbers(context.current(), true, out),
        FrameKind::Initializers => initializer::complete(names, context, out),
    }
}

/// Completion items under construction.
pub(super) struct Completions {
    replace: Range<usize>,
    items: Vec<CompletionItem>,
}

impl Completions {
    pub(super) fn empty() -> Completions {
        Completions { replace: 0..0, items: Vec::new() }
    }

    /// Extends the replaced range over text after the cursor that belongs to the item, such as the rest of a
    /// path.
    fn replaces_too(&mut self, words: &[Word]) {
        for word in words {
            if word.range.start != self.replace.end {
                break;
            }
            self.replace.end = word.range.end;
        }
        for item in &mut self.items {
            item.replace = self.replace.clone();
        }
    }

    /// If another element follows without a comma: adds a comma to items that are whole elements.
    fn with_comma(&mut self) {
        for completion_item in &mut self.items {
            if !completion_item.insert.ends_with("::")
                && !matches!(completion_item.kind, CompletionKind::Keyword)
            {
                completion_item.insert.push_str(", ");
            }
        }
    }

    /// Adds an item whose label is inserted.
    fn add(
        &mut self,
        label: impl Into<String>,
        kind: CompletionKind,
        rank: u8,
    ) -> &mut CompletionItem {
        let label = label.into();
        self.items.push(CompletionItem {
            insert: label.clone(),
            label,
            kind,
            detail: None,
            filter: None,
            snippet: false,
            replace: self.replace.clone(),
            rank,
            definition: None,
            name: None,
            codel: None,
        });
        let last = self.items.len() - 1;
        &mut self.items[last]
    }

    /// Adds an item that inserts more than its label.
    fn snippet(
        &mut self,
        label: impl Into<String>,
        insert: impl Into<String>,
        rank: u8,
    ) -> &mut CompletionItem {
        let item = self.add(label, CompletionKind::Snippet, rank);
        item.insert = insert.into();
        item.snippet = true;
        item
    }

    fn keywords(&mut self, words: &[&str], rank: u8) {
        for word in words {
            self.add(*word, CompletionKind::Keyword, rank);
        }
    }

    /// The clause with an execution time; only the keyword if the time already follows the cursor.
    fn wcet(&mut self, context: &Context) {
        use dotgen_syntax::SyntaxKind::{FLOAT, INT};
        let next = context.after.next();
        if next.is_some_and(|word| matches!(word.kind, INT | FLOAT)) {
            self.keywords(&["wcet"], 1);
        } else {
            self.snippet("wcet", "wcet ${1:1} ms", 1);
        }
    }

    pub(super) fn finish(mut self) -> Vec<CompletionItem> {
        // A stable sort: items of equal rank stay in order of declaration.
        self.items.sort_by_key(|completion_item| completion_item.rank);
        for completion_item in self
            .items
            .iter_mut()
            .filter(|completion_item| completion_item.kind == CompletionKind::Keyword)
        {
            completion_item.filter = longer_spelling(&completion_item.label);
        }
        let mut seen = FxHashSet::default();
        self.items.retain(|completion_item| {
            seen.insert((completion_item.label.clone(), completion_item.insert.clone()))
        });
        self.items
    }
}

/// The other spelling of a keyword, if it is longer: both have the same prefix, so typed letters of either
/// match it.
fn longer_spelling(word: &str) -> Option<String> {
    use dotgen_syntax::SyntaxKind;
    let longer = format!("{word}s");
    let same = SyntaxKind::contextual(word)? == SyntaxKind::contextual(&longer)?;
    same.then_some(longer)
}

#[cfg(test)]
mod tests;
