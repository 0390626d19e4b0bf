//! Refactorings: one file each, from a place in a file to edits.
//!
//! To add one: write `assists/<name>.rs` with a function from [`Cx`] to an [`Assist`], and add it to
//! [`assists`]. Its tests give the text before and after; the text after is compiled and must have no error
//! that the text before does not have.

mod convert_wcet;
mod designate_initializers;
mod document_parameters;
mod execution_time;
mod extract_struct;
mod generate_interface;
mod implement_interface;
mod inline_typedef;
mod move_codel;
mod organize_includes;
mod split_codel;

use std::ops::Range;

pub use execution_time::TaskTime;
pub(crate) use execution_time::{execution_time, task_time};

use dotgen_syntax::{SyntaxElement, SyntaxKind, SyntaxNode, ast::AstNode, line_index::line_start};
use smol_str::SmolStr;

use super::FileView;
use crate::{
    diagnostic::FileEdit,
    model::{Codel, Component, Owner},
    source_map::{bytes, offset, text_range},
};

/// Kinds of refactoring, as LSP groups them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AssistKind {
    Extract,
    Inline,
    Move,
    Rewrite,
    OrganizeIncludes,
}

/// A refactoring that applies at a place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Assist {
    /// Stable identifier.
    pub id: &'static str,
    /// The action, in the imperative.
    pub title: String,
    /// The kind, for menus.
    pub kind: AssistKind,
    /// Edits that do not overlap.
    pub edits: Vec<FileEdit>,
}

/// The refactorings that apply to a selection.
pub(crate) fn assists(view: &FileView<'_>, range: &Range<usize>) -> Vec<Assist> {
    let text = view.text();
    if range.end > text.len()
        || range.start > range.end
        || !text.is_char_boundary(range.start)
        || !text.is_char_boundary(range.end)
    {
        return Vec::new();
    }
    let cx = Cx { view, range: range.clone() };
    let mut out: Vec<Assist> = Vec::new();
    out.extend(extract_struct::extract_struct(&cx));
    out.extend(inline_typedef::inline_typedef(&cx));
    out.extend(split_codel::split_codel(&cx));
    out.extend(move_codel::move_codel(&cx));
    out.extend(convert_wcet::convert_wcet(&cx));
    out.extend(designate_initializers::designate_initializers(&cx));
    out.extend(document_parameters::document_parameters(&cx));
    out.extend(generate_interface::generate_interface(&cx));
    out.extend(implement_interface::implement_interface(&cx));
    out.extend(organize_includes::organize_includes(&cx, false));
    out
}

/// Sorts the includes of a file, for any cursor.
pub(crate) fn organize_includes(view: &FileView<'_>) -> Option<Assist> {
    let cx = Cx { view, range: 0..0 };
    organize_includes::organize_includes(&cx, true)
}

/// A selection in a file.
struct Cx<'a, 'db> {
    view: &'a FileView<'db>,
    range: Range<usize>,
}

impl Cx<'_, '_> {
    /// The innermost node of a type around the selection.
    fn ancestor<N: AstNode>(&self) -> Option<N> {
        let root = self.view.root();
        let range = text_range(&self.range);
        if !root.text_range().contains_range(range) {
            return None;
        }
        let from = |element: SyntaxElement| match element {
            SyntaxElement::Node(node) => Some(node),
            SyntaxElement::Token(token) => token.parent(),
        };
        if !range.is_empty() {
            return from(root.covering_element(range))?.ancestors().find_map(N::cast);
        }
        // The cursor may be right behind the node.
        let tokens = root.token_at_offset(offset(self.range.start));
        let right = tokens.clone().right_biased().and_then(|token| token.parent());
        let left = tokens.left_biased().and_then(|token| token.parent());
        let mut around = right.into_iter().chain(left);
        around.find_map(|parent| parent.ancestors().find_map(N::cast))
    }

    /// Returns true if a node touches the selection.
    fn touches(&self, node: &SyntaxNode) -> bool {
        let range = self.node_range(node);
        range.start <= self.range.end && self.range.start <= range.end
    }

    fn node_range(&self, node: &SyntaxNode) -> Range<usize> {
        bytes(self.view.node_range(node))
    }

    /// The text of a node as written, without blanks around it.
    fn text(&self, node: &SyntaxNode) -> &str {
        self.slice(self.node_range(node))
    }

    fn slice(&self, range: Range<usize>) -> &str {
        self.view.text().get(range).unwrap_or_default()
    }

    /// Returns true if a node is written out: without macros, directives and excluded text.
    fn is_plain(&self, node: &SyntaxNode) -> bool {
        node.text_range().len() > 0.into()
            && !node.descendants().any(|node| {
                matches!(
                    node.kind(),
                    SyntaxKind::DIRECTIVE | SyntaxKind::INACTIVE | SyntaxKind::MACRO_CALL
                )
            })
    }

    fn edit(&self, range: Range<usize>, new_text: impl Into<String>) -> FileEdit {
        FileEdit {
            path: self.view.file.path(self.view.db).clone(),
            range,
            new_text: new_text.into(),
        }
    }

    /// The blanks at the start of the line of an offset.
    fn indent(&self, at: usize) -> &str {
        let text = self.view.text();
        let line = line_start(text, at);
        let rest = &text[line..at];
        &rest[..rest.len() - rest.trim_start_matches([' ', '\t']).len()]
    }

    /// A range with its line, if nothing else is on the line.
    fn whole_lines(&self, range: Range<usize>) -> Range<usize> {
        let text = self.view.text();
        let start = line_start(text, range.start);
        let end = text[range.end..].find('\n').map_or(text.len(), |rest| range.end + rest + 1);
        let alone =
            text[start..range.start].trim().is_empty() && text[range.end..end].trim().is_empty();
        if alone { start..end } else { range }
    }

    /// A name like `base` that is not used in the unit.
    fn unused_name(&self, base: &str) -> SmolStr {
        let elaborated = self.view.elaborated();
        let used = |name: &str| {
            elaborated.definitions.iter().any(|definition| definition.name == name)
                || elaborated.spec.components.iter().any(|component| {
                    component.services.iter().any(|service| service.name == name)
                        || component.ports.iter().any(|port| port.name == name)
                })
        };
        let numbered = (2..).map(|number| format!("{base}_{number}"));
        let mut candidates = std::iter::once(base.to_owned()).chain(numbered);
        candidates.find(|candidate| !used(candidate)).map_or_else(|| base.into(), SmolStr::from)
    }

    /// The codel whose name is written at a range.
    fn codel_at(&self, name: &Range<usize>) -> Option<(&Component, Owner, &Codel)> {
        let all = self.view.elaborated().spec.components.iter();
        let mut all = all.flat_map(|component| {
            component
                .all_codels()
                .map(move |codel| (component, codel.owner, component.codel(codel)))
        });
        all.find(|(_, _, codel)| {
            self.view
                .place(codel.src)
                .is_some_and(|(file, range)| file == self.view.file && bytes(range) == *name)
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::{
        ide::{Assist, speculate::apply},
        test_support::Fixture,
    };

    fn offered(text: &str) -> (Fixture, Vec<Assist>) {
        // A second `$0` ends a selection.
        let fixture = Fixture::new(text);
        let at = fixture.at();
        let text = fixture.text(at.path.as_str());
        let (fixture, range) = match text.find("$0") {
            Some(end) => {
                let mut fixture = fixture;
                fixture.edit(at.path.as_str(), text.replacen("$0", "", 1));
                (fixture, at.offset..end)
            }
            None => (fixture, at.offset..at.offset),
        };
        let assists = fixture.analysis().assists(&at.path, range).unwrap();
        (fixture, assists)
    }

    /// Applies a refactoring to a text; the result must have no new error.
    #[track_caller]
    pub(super) fn check(id: &str, before: &str, after: &str) {
        let (mut fixture, assists) = offered(before);
        let assist = assists.iter().find(|assist| assist.id == id);
        let assist = assist.unwrap_or_else(|| panic!("no {id} in {assists:#?}"));
        let errors = |fixture: &Fixture| {
            let all = fixture.all_diagnostics();
            all.lines().filter(|line| line.contains(" error ")).count()
        };
        let known = errors(&fixture);
        let path = fixture.at().path.clone();
        let edited = apply(&fixture.text(path.as_str()), &assist.edits);
        assert_eq!(edited, after);
        fixture.edit(path.as_str(), edited);
        assert!(errors(&fixture) <= known, "{}", fixture.all_diagnostics());
    }

    /// Checks that a refactoring does not apply.
    #[track_caller]
    pub(super) fn assert_not_offered(id: &str, text: &str) {
        let (_, assists) = offered(text);
        assert!(assists.iter().all(|assist| assist.id != id), "{assists:#?}");
    }
}
