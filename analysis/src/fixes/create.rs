//! Declarations of names that are used but not declared, each at the place that fits the order of the file.

use dotgen_syntax::{
    SyntaxKind, SyntaxNode, SyntaxToken, TextRange, TextSize,
    ast::{self, AstNode, support},
};

use super::{FixSite, TextFix, end_of, indent_of, starts_line};

impl FixSite<'_> {
    /// `Declare exception …`, without members.
    pub(crate) fn declare_exception(&self, name: &str) -> Option<TextFix> {
        self.declare(name, SyntaxKind::EXCEPTION_DECL, |name| {
            (format!("exception {name};"), format!("Declare the exception `{name}`"))
        })
    }

    /// `Declare task …`, aperiodic until a period is given.
    pub(crate) fn declare_task(&self, name: &str) -> Option<TextFix> {
        self.declare(name, SyntaxKind::TASK, |name| {
            (format!("task {name} {{ }};"), format!("Declare the task `{name}`"))
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
        let same = |param: &ast::PathParam| {
            let first = param.path().and_then(|path| path.syntax().first_token());
            first.is_some_and(|token| token.text() == name)
        };
        let mut uses = component.syntax().descendants().filter_map(ast::PathParam::cast);
        let direction =
            if uses.any(|usage| usage.in_token().is_none() && same(&usage)) { "out" } else { "in" };
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

    /// `Name the type …`: a `typedef` before the port.
    pub(crate) fn name_port_type(&self, port: &str) -> Option<TextFix> {
        let declaration: ast::Port = self.node(self.range)?;
        let ty = declaration.type_spec()?;
        let range = TextRange::new(ty.syntax().text_range().start(), end_of(ty.syntax()));
        let name = format!("{port}_data");
        let at = before_comments(declaration.syntax())?;
        let indent = indent_of(declaration.syntax());
        let text = self.text(range);
        let declared = format!("typedef {text} {name};\n{indent}");
        let title = format!("Name the type `{name}`");
        Some(TextFix::guess(title, TextRange::empty(at), declared).and(range, name))
    }

    /// `Declare activity …`, in the last task before it, or `Declare function …`, if there is no task.
    pub(crate) fn declare_service(&self, name: &str) -> Option<TextFix> {
        let item = self.item_of_component()?;
        let mut before = std::iter::successors(item.prev_sibling(), SyntaxNode::prev_sibling);
        let task = before.find_map(ast::Task::cast).and_then(|task| task.name());
        self.declare(name, SyntaxKind::SERVICE, |name| match &task {
            Some(task) => (
                format!(
                    "activity {name}() {{ task {}; codel<start> {name}_start() yield ether; }};",
                    task.syntax().text().to_string().trim()
                ),
                format!("Declare the activity `{name}`"),
            ),
            None => (format!("function {name}() {{ }};"), format!("Declare the function `{name}`")),
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
            .and_then(|param| param.initializer())
            .is_some_and(|initializer| initializer.initializer_list().is_none())
        {
            return None;
        }
        // A partial path has another meaning.
        let next = std::iter::successors(token.next_token(), SyntaxToken::next_token);
        let next = next.into_iter().find(|token| !token.kind().is_trivia());
        if next.is_some_and(|token| token.text().starts_with(':')) {
            return None;
        }
        // Types that several components share are declared outside of them; types in a module stay there.
        let item = token.parent_ancestors().find(|ancestor| {
            let around = ancestor.parent().filter(|parent| ast::Body::can_cast(parent.kind()));
            let owner = around.and_then(|parent| parent.parent());
            let is_inside = owner.map(|owner| ast::Module::can_cast(owner.kind()));
            let is_outermost = ancestor.parent().is_some_and(|parent| parent.parent().is_none());
            ast::Item::can_cast(ancestor.kind()) && is_inside.unwrap_or(is_outermost)
        })?;
        let mut members = members_of(&item, name);
        if members.is_empty() {
            members.push("value".to_owned());
        }
        let indent = indent_of(&item);
        let members = members.iter().map(|member| format!("{indent}  double {member};\n"));
        let members: String = members.collect();
        let text = format!("struct {name} {{\n{members}{indent}}};");
        let at = before_comments(&item)?;
        let title = format!("Declare the struct `{name}`");
        Some(TextFix::guess(title, TextRange::empty(at), format!("{text}\n\n{indent}")))
    }

    /// `Add … to the ids`: the last ones before the use. The type is a guess.
    pub(crate) fn declare_ids_member(&self, name: &str) -> Option<TextFix> {
        let item = self.item_of_component()?;
        if self.broken || !is_name(name) {
            return None;
        }
        let mut before = std::iter::successors(item.prev_sibling(), SyntaxNode::prev_sibling);
        let ids = before.find(|sibling| ast::Ids::can_cast(sibling.kind()))?;
        self.add_property(&ids, &format!("long {name};"), format!("Add `long {name}` to the ids"))
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
        let (at, text) = if let Some(last) =
            before.find(|sibling| sibling.kind() == kind && starts_line(sibling))
        {
            let indent = indent_of(&last);
            (TextRange::empty(end_of(&last)), format!("\n{indent}{text}"))
        } else {
            let first = support::first_text_token(&item)?;
            let at = TextRange::empty(first.text_range().start());
            if starts_line(&item) {
                (at, format!("{text}\n\n{}", indent_of(&item)))
            } else {
                (at, format!("{text} "))
            }
        };
        Some(TextFix::guess(title, at, text))
    }

    /// The declaration around, directly in the body of a component or interface.
    fn item_of_component(&self) -> Option<SyntaxNode> {
        let token = self.token_at(self.range)?;
        token.parent_ancestors().find(|ancestor| {
            let body = ancestor.parent().filter(|parent| ast::Body::can_cast(parent.kind()));
            let owner = body.and_then(|body| body.parent());
            ast::Item::can_cast(ancestor.kind())
                && owner.is_some_and(|owner| ast::Component::can_cast(owner.kind()))
        })
    }
}

/// Members of a type that an item uses, in order, for all data declared with that type in it.
fn members_of(item: &SyntaxNode, ty: &str) -> Vec<String> {
    let text = |node: &SyntaxNode| node.text().to_string().trim().to_owned();
    let is_ty = |known_type: &Option<ast::TypeSpec>| {
        known_type.as_ref().is_some_and(|known_type| text(known_type.syntax()) == ty)
    };
    let mut names: Vec<String> = Vec::new();
    for node in item.descendants() {
        if let Some(port) = ast::Port::cast(node.clone()).filter(|port| is_ty(&port.type_spec())) {
            names.extend(port.name().map(|name| text(name.syntax())));
        } else if let Some(member) =
            ast::Member::cast(node).filter(|member| is_ty(&member.type_spec()))
        {
            let all = member.declarators().filter_map(|declarator| declarator.name());
            names.extend(all.map(|name| text(name.syntax())));
        }
    }
    let mut out: Vec<String> = Vec::new();
    for path in item.descendants().filter_map(ast::ParamPath::cast) {
        let mut steps = path.steps().filter_map(|step| match step {
            ast::PathStep::MemberStep(member_step) => {
                member_step.name_ref().map(|name| text(name.syntax()))
            }
            ast::PathStep::IndexStep(_) => None,
        });
        if steps.next().is_some_and(|step| names.contains(&step))
            && let Some(member) = steps.next().filter(|step| !out.contains(step))
        {
            out.push(member);
        }
    }
    out
}

/// The start of an item, including the comments right before it.
fn before_comments(item: &SyntaxNode) -> Option<TextSize> {
    let first = support::first_text_token(item)?;
    let mut at = first.text_range().start();
    let mut ends = 0;
    let mut before = first.prev_token();
    while let Some(token) = before.filter(|token| token.kind().is_trivia()) {
        match token.kind() {
            SyntaxKind::WHITESPACE | SyntaxKind::NEWLINE => {
                ends += token.text().matches('\n').count();
                if ends > 1 {
                    break;
                }
            }
            _ => (at, ends) = (token.text_range().start(), 0),
        }
        before = token.prev_token();
    }
    Some(at)
}

/// Returns true for a word of the language.
fn is_word(text: &str) -> bool {
    SyntaxKind::spellings().iter().any(|spelling| spelling.1 == text)
}

/// Returns true for text with the form of a name.
pub(crate) fn is_name(text: &str) -> bool {
    let mut chars = text.chars();
    let first = chars.next();
    first.is_some_and(|character| character.is_ascii_alphabetic() || character == '_')
        && chars.all(|character| character.is_ascii_alphanumeric() || character == '_')
}
