//! Declarations of names that are used but not declared, each at the place that fits the order of the file.

use dotgen_syntax::{
    SyntaxKind, SyntaxNode, SyntaxToken, TextRange, TextSize,
    ast::{self, AstNode},
};

use crate::diagnostic::FixKind;

use super::{FixSite, TextFix, end_of, indent_of, starts_line};

impl FixSite<'_> {
    /// `Declare exception …`, without members.
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

    /// `Declare port …`, in the direction of its use. Its type gets a declaration of its own before the
    /// component, since the type of a port must have a name. The definition of that type is a guess.
    pub(crate) fn declare_port(&self, name: &str) -> Option<TextFix> {
        let param: ast::PathParam = self.node(self.range)?;
        let codel = param.syntax().ancestors().find_map(ast::Codel::cast)?;
        // Codels without states have no ports, and a word of the language is a typing mistake.
        if codel.triggers().is_none() || is_word(name) {
            return None;
        }
        let component = param.syntax().ancestors().find_map(ast::Component::cast)?;
        // A codel that only reads it may read an output as well.
        let same = |it: &ast::PathParam| {
            let first = it.path().and_then(|it| it.syntax().first_token());
            first.is_some_and(|it| it.text() == name)
        };
        let mut uses = component
            .syntax()
            .descendants()
            .filter_map(ast::PathParam::cast);
        let direction = match uses.any(|it| it.in_token().is_none() && same(&it)) {
            true => "out",
            false => "in",
        };
        let at = before_comments(component.syntax())?;
        let indent = indent_of(component.syntax());
        let mut fix = self.declare(name, SyntaxKind::PORT, |name| {
            (
                format!("port {direction} {name}_data {name};"),
                format!("Declare the {direction}put port `{name}`"),
            )
        })?;
        let ty = format!("typedef long {name}_data;\n\n{indent}");
        fix.edits.insert(0, (TextRange::empty(at), ty));
        Some(fix)
    }

    /// `Declare activity …`, in the last task before it, or `Declare function …`, if there is no task.
    pub(crate) fn declare_service(&self, name: &str) -> Option<TextFix> {
        let item = self.item_of_component()?;
        let mut before = std::iter::successors(item.prev_sibling(), SyntaxNode::prev_sibling);
        let task = before.find_map(ast::Task::cast).and_then(|it| it.name());
        self.declare(name, SyntaxKind::SERVICE, |name| match &task {
            Some(task) => (
                format!(
                    "activity {name}() {{ task {}; codel<start> {name}_start() yield ether; }};",
                    task.syntax().text().to_string().trim()
                ),
                format!("Declare the activity `{name}`"),
            ),
            None => (
                format!("function {name}() {{ }};"),
                format!("Declare the function `{name}`"),
            ),
        })
    }

    /// `Declare struct …` before the component, with the members that are used of data of that type. Their
    /// types are a guess.
    pub(crate) fn declare_type(&self, name: &str) -> Option<TextFix> {
        let token = self.token_at(self.range)?;
        if self.broken || !is_name(name) || is_word(name) {
            return None;
        }
        // The type of a numeric default value is not a struct.
        let param = self.node::<ast::TypedParam>(self.range);
        if param
            .and_then(|it| it.initializer())
            .is_some_and(|it| it.initializer_list().is_none())
        {
            return None;
        }
        // A partial path has another meaning.
        let next = std::iter::successors(token.next_token(), SyntaxToken::next_token);
        let next = next.into_iter().find(|it| !it.kind().is_trivia());
        if next.is_some_and(|it| it.text().starts_with(':')) {
            return None;
        }
        // Types that several components share are declared outside of them; types in a module stay there.
        let item = token.parent_ancestors().find(|it| {
            let around = it.parent().filter(|it| ast::Body::can_cast(it.kind()));
            let owner = around.and_then(|it| it.parent());
            let is_inside = owner.map(|it| ast::Module::can_cast(it.kind()));
            let is_outermost = it.parent().is_some_and(|it| it.parent().is_none());
            ast::Item::can_cast(it.kind()) && is_inside.unwrap_or(is_outermost)
        })?;
        let mut members = members_of(&item, name);
        if members.is_empty() {
            members.push("value".to_owned());
        }
        let indent = indent_of(&item);
        let members = members.iter().map(|it| format!("{indent}  double {it};\n"));
        let members: String = members.collect();
        let text = format!("struct {name} {{\n{members}{indent}}};");
        let at = before_comments(&item)?;
        Some(TextFix {
            kind: FixKind::Guess,
            title: format!("Declare the struct `{name}`"),
            edits: vec![(TextRange::empty(at), format!("{text}\n\n{indent}"))],
        })
    }

    /// `Add … to the ids`: the last ones before the use. The type is a guess.
    pub(crate) fn declare_ids_member(&self, name: &str) -> Option<TextFix> {
        let item = self.item_of_component()?;
        if self.broken || !is_name(name) {
            return None;
        }
        let mut before = std::iter::successors(item.prev_sibling(), SyntaxNode::prev_sibling);
        let ids = before.find(|it| ast::Ids::can_cast(it.kind()))?;
        self.add_property(
            &ids,
            &format!("long {name};"),
            format!("Add `long {name}` to the ids"),
        )
    }

    /// A declaration behind the last one of its kind before the use in the same body, otherwise before the
    /// item that uses it.
    fn declare(
        &self,
        name: &str,
        kind: SyntaxKind,
        text: impl Fn(&str) -> (String, String),
    ) -> Option<TextFix> {
        let item = self.item_of_component()?;
        // A path must be declared in its scope, which is not here.
        if self.broken || !is_name(name) {
            return None;
        }
        let (text, title) = text(name);
        let text = self.as_written(&text);
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
            kind: FixKind::Guess,
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

/// Members of a type that an item uses, in order, for all data declared with that type in it.
fn members_of(item: &SyntaxNode, ty: &str) -> Vec<String> {
    let text = |it: &SyntaxNode| it.text().to_string().trim().to_owned();
    let is_ty = |it: &Option<ast::TypeSpec>| it.as_ref().is_some_and(|it| text(it.syntax()) == ty);
    let mut names: Vec<String> = Vec::new();
    for node in item.descendants() {
        if let Some(port) = ast::Port::cast(node.clone()).filter(|it| is_ty(&it.type_spec())) {
            names.extend(port.name().map(|it| text(it.syntax())));
        } else if let Some(member) = ast::Member::cast(node).filter(|it| is_ty(&it.type_spec())) {
            let all = member.declarators().filter_map(|it| it.name());
            names.extend(all.map(|it| text(it.syntax())));
        }
    }
    let mut out: Vec<String> = Vec::new();
    for path in item.descendants().filter_map(ast::ParamPath::cast) {
        let mut steps = path.steps().filter_map(|it| match it {
            ast::PathStep::MemberStep(it) => it.name_ref().map(|it| text(it.syntax())),
            ast::PathStep::IndexStep(_) => None,
        });
        if steps.next().is_some_and(|it| names.contains(&it))
            && let Some(member) = steps.next().filter(|it| !out.contains(it))
        {
            out.push(member);
        }
    }
    out
}

/// The start of an item, including the comments right before it.
fn before_comments(item: &SyntaxNode) -> Option<TextSize> {
    let tokens = item.descendants_with_tokens();
    let mut tokens = tokens.filter_map(|it| it.into_token());
    let first = tokens.find(|it| !it.kind().is_trivia())?;
    let mut at = first.text_range().start();
    let mut ends = 0;
    let mut before = first.prev_token();
    while let Some(it) = before.filter(|it| it.kind().is_trivia()) {
        match it.kind() {
            SyntaxKind::WHITESPACE | SyntaxKind::NEWLINE => {
                ends += it.text().matches('\n').count();
                if ends > 1 {
                    break;
                }
            }
            _ => (at, ends) = (it.text_range().start(), 0),
        }
        before = it.prev_token();
    }
    Some(at)
}

/// Returns true for a word of the language.
fn is_word(text: &str) -> bool {
    SyntaxKind::spellings().iter().any(|it| it.1 == text)
}

fn is_name(text: &str) -> bool {
    let mut chars = text.chars();
    let first = chars.next();
    first.is_some_and(|it| it.is_ascii_alphabetic() || it == '_')
        && chars.all(|it| it.is_ascii_alphanumeric() || it == '_')
}
