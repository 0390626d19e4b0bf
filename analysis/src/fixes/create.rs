//! Declarations of what is used and declared nowhere, each at the place that the order of the file suggests.

use dotgen_syntax::{
    SyntaxKind, SyntaxNode, TextRange,
    ast::{self, AstNode},
};

use super::{Place, TextFix, add_property, end_of, indent_of, starts_line};

impl Place<'_> {
    /// `Declare exception …`, which says nothing of members.
    pub(crate) fn declare_exception(&self, name: &str) -> Option<TextFix> {
        self.declare(name, SyntaxKind::EXCEPTION_DECL, |name| {
            (
                format!("exception {name};"),
                format!("Declare the exception `{name}`"),
            )
        })
    }

    /// `Declare task …`, aperiodic until a period is given.
    pub(crate) fn declare_task(&self, name: &str) -> Option<TextFix> {
        self.declare(name, SyntaxKind::TASK, |name| {
            (
                format!("task {name} {{ }};"),
                format!("Declare the task `{name}`"),
            )
        })
    }

    /// `Add … to the ids`: the last ones before the use. The type is a guess.
    pub(crate) fn declare_ids_member(&self, name: &str) -> Option<TextFix> {
        let item = self.item_of_component()?;
        if !is_name(name) {
            return None;
        }
        let mut before = std::iter::successors(item.prev_sibling(), SyntaxNode::prev_sibling);
        let ids = before.find(|it| ast::Ids::can_cast(it.kind()))?;
        add_property(
            &ids,
            &format!("long {name};"),
            format!("Add `long {name}` to the ids"),
        )
    }

    /// A declaration behind the last of its kind before the use in the same body, else in front of what uses it.
    fn declare(
        &self,
        name: &str,
        kind: SyntaxKind,
        text: impl Fn(&str) -> (String, String),
    ) -> Option<TextFix> {
        let item = self.item_of_component()?;
        // A path has to be declared where it leads, and that is not here.
        if !is_name(name) {
            return None;
        }
        let (text, title) = text(name);
        let mut before = std::iter::successors(item.prev_sibling(), SyntaxNode::prev_sibling);
        let edit = match before.find(|it| it.kind() == kind && starts_line(it)) {
            Some(last) => {
                let indent = indent_of(&last);
                (TextRange::empty(end_of(&last)), format!("\n{indent}{text}"))
            }
            None => {
                let first = item
                    .descendants_with_tokens()
                    .filter_map(|it| it.into_token())
                    .find(|it| !it.kind().is_trivia())?;
                let at = TextRange::empty(first.text_range().start());
                match starts_line(&item) {
                    true => (at, format!("{text}\n\n{}", indent_of(&item))),
                    false => (at, format!("{text} ")),
                }
            }
        };
        Some(TextFix {
            plain: false,
            title,
            edits: vec![edit],
        })
    }

    /// The declaration around, directly in the body of a component or interface.
    fn item_of_component(&self) -> Option<SyntaxNode> {
        let token = self.token_at(self.range)?;
        token.parent_ancestors().find(|it| {
            let body = it.parent().filter(|it| ast::Body::can_cast(it.kind()));
            let owner = body.and_then(|it| it.parent());
            ast::Item::can_cast(it.kind())
                && owner.is_some_and(|it| ast::Component::can_cast(it.kind()))
        })
    }
}

fn is_name(text: &str) -> bool {
    let mut chars = text.chars();
    let first = chars.next();
    first.is_some_and(|it| it.is_ascii_alphabetic() || it == '_')
        && chars.all(|it| it.is_ascii_alphanumeric() || it == '_')
}
