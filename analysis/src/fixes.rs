//! Quick fixes that need the text: one function for each rule that has one.
//!
//! Rules work on the model, without the text. [`crate::finding`] lists the fixes of a finding next to its
//! message; this module makes the edits, from the tree around its place.

mod braces;
mod create;
mod includes;
mod range;
pub(crate) mod trial;
mod typos;

pub(crate) use braces::missing_brace;
pub(crate) use create::is_name;
pub(crate) use includes::near_include;

use camino::Utf8Path;

use dotgen_syntax::{
    NodeOrToken, SyntaxElement, SyntaxKind, SyntaxNode, SyntaxToken, TextRange, TextSize,
    ast::{self, AstNode, support},
};

use crate::{
    diagnostic::{FileEdit, Fix, FixKind},
    lists::append_to_list,
    source_map::bytes,
    spelling::Spelling,
};
use range::{end_of, indent_of, starts_line, whole_lines, with_comma, with_line_before};

/// A fix within one file: its title, and replacements of ranges.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct TextFix {
    /// See [`Fix::kind`].
    pub(crate) kind: FixKind,
    pub(crate) title: String,
    pub(crate) edits: Vec<(TextRange, String)>,
}

impl TextFix {
    /// A replacement that is a guess.
    pub(crate) fn guess(
        title: impl Into<String>,
        range: TextRange,
        text: impl Into<String>,
    ) -> TextFix {
        let edits = vec![(range, text.into())];
        TextFix { kind: FixKind::Guess, title: title.into(), edits }
    }

    /// The fix with one more edit.
    fn and(mut self, range: TextRange, text: String) -> TextFix {
        self.edits.push((range, text));
        self
    }

    /// The fix as the only way to correct the finding.
    pub(crate) fn plain(self) -> TextFix {
        TextFix { kind: FixKind::Plain, ..self }
    }

    /// The fix as one that changes the behaviour of the program.
    pub(crate) fn choice(self) -> TextFix {
        TextFix { kind: FixKind::Choice, ..self }
    }

    /// The fix of a file.
    pub(crate) fn within(self, path: &Utf8Path) -> Fix {
        let edit =
            |(range, new_text)| FileEdit { path: path.to_owned(), range: bytes(range), new_text };
        Fix {
            kind: self.kind,
            title: self.title,
            edits: self.edits.into_iter().map(edit).collect(),
        }
    }
}

/// A finding at its place, with the places related to it in the same file.
pub(crate) struct FixSite<'a> {
    pub(crate) root: &'a SyntaxNode,
    /// True if the text has syntax errors: unknown names may be declared in text that was not parsed.
    pub(crate) broken: bool,
    pub(crate) range: TextRange,
    pub(crate) related: &'a [TextRange],
    /// The text of the file.
    pub(crate) source: &'a str,
    /// Returns the writing style of the file's author.
    pub(crate) spelling: &'a dyn Fn() -> Spelling,
}

impl FixSite<'_> {
    /// Adds an item to the last list of a kind in a body, or a new list. `words` are the spellings of the
    /// property.
    fn add_to_list(
        &self,
        node: &SyntaxNode,
        words: [&str; 2],
        item: &str,
        title: String,
    ) -> Option<TextFix> {
        let body = node.children().find_map(ast::Body::cast);
        let last = body.into_iter().flat_map(|body| body.syntax().children());
        let last = last.filter(|child| {
            support::first_text_token(child).is_some_and(|token| words.contains(&token.text()))
        });
        let Some(list) = last.last() else {
            return self.add_property(node, &format!("{} {item};", words[0]), title);
        };
        let edits = list_edits(&list, list.children(), item);
        Some(TextFix { kind: FixKind::Guess, title, edits })
    }

    /// Adds a property at the end of the body of a declaration. Creates the body if there is none.
    fn add_property(&self, node: &SyntaxNode, property: &str, title: String) -> Option<TextFix> {
        let property = self.as_written(property);
        let outer = indent_of(node);
        let (at, text) = if let Some(body) = node.children().find_map(ast::Body::cast) {
            let last = body.syntax().children().last();
            match last {
                // A body on one line stays on it.
                Some(last) if !starts_line(&last) => {
                    (TextRange::empty(end_of(&last)), format!(" {property}"))
                }
                Some(last) => {
                    let indent = indent_of(&last);
                    (TextRange::empty(end_of(&last)), format!("\n{indent}{property}"))
                }
                None => {
                    let open = body.syntax().first_token()?;
                    (
                        TextRange::empty(open.text_range().end()),
                        format!("\n{outer}  {property}\n{outer}"),
                    )
                }
            }
        } else {
            let end = node.last_token().filter(|token| token.kind() == SyntaxKind::SEMICOLON)?;
            (
                TextRange::empty(end.text_range().start()),
                format!(" {{\n{outer}  {property}\n{outer}}}"),
            )
        };
        Some(TextFix::guess(title, at, text))
    }

    fn token_at(&self, range: TextRange) -> Option<SyntaxToken> {
        if range.start() > self.root.text_range().end() {
            return None;
        }
        self.root.token_at_offset(range.start()).right_biased()
    }

    /// The node of a type that a range is in.
    fn node<N: AstNode>(&self, range: TextRange) -> Option<N> {
        self.token_at(range)?.parent_ancestors().find_map(N::cast)
    }

    fn text(&self, range: TextRange) -> String {
        let range = range.intersect(self.root.text_range()).unwrap_or_default();
        // The text of the whole tree would be walked from its start.
        match self.root.covering_element(range) {
            SyntaxElement::Node(node) => {
                let text = node.text();
                text.slice(range - node.text_range().start()).to_string()
            }
            SyntaxElement::Token(token) => {
                let range = range - token.text_range().start();
                token.text()[range].to_owned()
            }
        }
    }

    /// `Declare a codel for the state`: after the codel that yields it.
    pub(crate) fn declare_state(&self, state: &str) -> Option<TextFix> {
        let codel: ast::CodelProperty = self.node(self.range)?;
        let owner = self.owner_name(codel.syntax())?;
        let indent = indent_of(codel.syntax());
        let codel_name = self.free_codel(&format!("{owner}_{state}"));
        let text = format!("\n{indent}codel<{state}> {codel_name}() yield ether;");
        let title = format!("Declare a codel for the state `{state}`");
        let at = TextRange::empty(end_of(codel.syntax()));
        Some(TextFix::guess(title, at, self.as_written(&text)).choice())
    }

    /// `Throw it instead`: out of the states, into the `throw` of the task or service.
    pub(crate) fn declare_throw(&self, path: &str) -> Option<TextFix> {
        let state = self.node::<ast::State>(self.range)?;
        let yields = ast::Yields::cast(state.syntax().parent()?)?;
        let (left_out, instead) = match yields.states().count() {
            // At least one state must follow.
            1 => (state.syntax().text_range(), "ether".to_owned()),
            _ => (with_comma(state.syntax()), String::new()),
        };
        let owner = state.syntax().ancestors().find(|ancestor| {
            ast::Task::can_cast(ancestor.kind()) || ast::Service::can_cast(ancestor.kind())
        })?;
        let written = path.strip_prefix("::").unwrap_or(path);
        let title = format!("Throw `{written}` instead of yielding it");
        let fix = self.add_to_list(&owner, ["throw", "throws"], path, title)?;
        Some(fix.and(left_out, instead).choice())
    }

    /// A piece of specification in the style of the file.
    fn as_written(&self, piece: &str) -> String {
        (self.spelling)().apply(piece)
    }

    /// The name, with a number if the file already has the word: an existing name would refer to another
    /// function.
    fn free_codel(&self, name: &str) -> String {
        // Called for many findings of a file, so the tree is not walked.
        let taken = |name: &str| {
            self.source.match_indices(name).any(|(at, _)| {
                let around = [
                    self.source[..at].chars().next_back(),
                    self.source[at + name.len()..].chars().next(),
                ];
                let goes_on = |character: char| character.is_alphanumeric() || character == '_';
                !around.into_iter().flatten().any(goes_on)
            })
        };
        let numbered = (2..).map(|number| format!("{name}_{number}"));
        let mut all = std::iter::once(name.to_owned()).chain(numbered);
        all.find(|name| !taken(name)).unwrap_or_default()
    }

    /// Name of the task or service around a node.
    fn owner_name(&self, node: &SyntaxNode) -> Option<String> {
        node.ancestors().find_map(|ancestor| {
            let name = match ast::Task::cast(ancestor.clone()) {
                Some(task) => task.name(),
                None => ast::Service::cast(ancestor)?.name(),
            };
            Some(name?.syntax().text().to_string())
        })
    }

    /// Connects or removes a codel. With `paused`, the transition pauses, since it would otherwise close a
    /// cycle.
    pub(crate) fn connect_or_remove_codel(&self, paused: bool) -> Vec<TextFix> {
        let mut fixes = Vec::new();
        let Some(codel) = self.node::<ast::CodelProperty>(self.range) else {
            return fixes;
        };
        let name = self.text(self.range);
        let state = codel
            .syntax()
            .descendants()
            .find_map(ast::Triggers::cast)
            .and_then(|trigger| trigger.syntax().descendants().find_map(ast::State::cast))
            .map(|state| state.syntax().text().to_string());
        // In most cases, the codel before it lacks the transition.
        let before = std::iter::successors(codel.syntax().prev_sibling(), SyntaxNode::prev_sibling)
            .find_map(ast::CodelProperty::cast);
        if let (Some(state), Some(before)) = (state, before) {
            let state = state.trim();
            let pause = paused.then(|| format!("pause::{state}"));
            let ways = pause.as_deref().into_iter().chain([state]);
            fixes.extend(ways.filter_map(|pause| add_yield(before.syntax(), pause)));
        }
        let title = format!("Remove the codel `{name}`");
        fixes.push(TextFix::guess(title, whole_lines(codel.syntax()), ""));
        fixes
    }

    /// `Pause before …`: one fix for each transition of a cycle. The state that closes the cycle comes first,
    /// as the message advises.
    pub(crate) fn pause_somewhere(&self) -> Vec<TextFix> {
        let mut around = self.related.to_vec();
        if !around.is_empty() {
            around.rotate_right(1);
        }
        around
            .into_iter()
            .filter(|&range| self.text(range) != "ether")
            .map(|range| {
                let (at, text) = self.paused(range);
                TextFix::guess(format!("Pause before `{}`", self.text(range)), at, text).choice()
            })
            .collect()
    }

    /// The edit that makes a transition pause. If the codel already yields the state with a pause, the
    /// unpaused one is removed.
    fn paused(&self, range: TextRange) -> (TextRange, String) {
        let pause = (TextRange::empty(range.start()), "pause::".to_owned());
        let state: Option<ast::State> = self.node(range);
        let list = state.as_ref().and_then(|state| state.syntax().parent());
        let Some((state, list)) = state.zip(list.and_then(ast::Yields::cast)) else {
            return pause;
        };
        let paused = format!("pause::{}", self.text(range));
        if list.states().any(|state| state.syntax().text() == paused.as_str()) {
            (with_comma(state.syntax()), String::new())
        } else {
            pause
        }
    }

    pub(crate) fn end_somewhere(&self) -> Option<TextFix> {
        add_yield(self.node::<ast::CodelProperty>(self.range)?.syntax(), "ether")
    }

    pub(crate) fn interrupt_itself(&self) -> Option<TextFix> {
        let service = self.node::<ast::Service>(self.range)?;
        let name = self.text(self.range);
        let title = format!("Let `{name}` interrupt itself");
        let words = ["interrupts", "interrupt"];
        self.add_to_list(service.syntax(), words, &name, title).map(TextFix::choice)
    }

    pub(crate) fn add_wcet(&self) -> Vec<TextFix> {
        const PLACEHOLDER: &str = "wcet 1 ms";
        let end = |range: TextRange| {
            let codel: ast::Codel = self.node(range)?;
            Some(TextRange::empty(end_of(codel.syntax())))
        };
        let text = || format!(" {PLACEHOLDER}");
        let one = end(self.range);
        let title = format!("Insert `{PLACEHOLDER}` here, to be replaced by the measured time");
        let mut fixes: Vec<TextFix> =
            one.map(|at| TextFix::guess(title, at, text()).choice()).into_iter().collect();
        let others = self.related.iter().filter_map(|&range| end(range));
        let edits: Vec<_> = one.into_iter().chain(others).map(|at| (at, text())).collect();
        if edits.len() > 1 {
            let title = format!("Insert `{PLACEHOLDER}` in all {} codels", edits.len());
            fixes.push(TextFix { kind: FixKind::Choice, title, edits });
        }
        fixes
    }

    /// Renames a codel wherever the file declares it or states its execution time.
    pub(crate) fn rename_codel(&self, from: &str, to: &str) -> TextFix {
        let mut edits = Vec::new();
        for node in self.root.descendants() {
            if let Some(codel) = ast::Codel::cast(node.clone()) {
                let name = codel.name().and_then(|name| name.ident_token());
                edits.extend(name.filter(|name| name.text() == from).map(|name| name.text_range()));
            } else if node.kind() == SyntaxKind::DIRECTIVE {
                // `#pragma wcet CODEL TIME`
                let tokens = node.descendants_with_tokens().filter_map(NodeOrToken::into_token);
                let named = tokens
                    .filter(|token| token.kind() == SyntaxKind::IDENT && token.text() == from);
                edits.extend(named.map(|token| token.text_range()));
            }
        }
        let edits = edits.into_iter().map(|range| (range, to.to_owned())).collect();
        let title = format!("Rename the codel to `{to}`");
        TextFix { kind: FixKind::Guess, title, edits }
    }

    pub(crate) fn validate_new_value(&self) -> Option<TextFix> {
        let edits: Vec<(TextRange, String)> = self
            .related
            .iter()
            .map(|&range| {
                let text = self.text(range);
                let rest =
                    text.strip_prefix("ids").filter(|rest| rest.starts_with(char::is_whitespace));
                let length = if rest.is_some() { 4 } else { 0 };
                (TextRange::at(range.start(), TextSize::from(length)), "local ".to_owned())
            })
            .collect();
        let title = "Validate the new value".to_owned();
        (!edits.is_empty()).then_some(TextFix { kind: FixKind::Choice, title, edits })
    }

    /// Removes the declaration of a name: its statement, or its part of a list.
    pub(crate) fn remove_declaration(&self) -> Option<TextFix> {
        let name = self.text(self.range);
        let part = self.token_at(self.range)?.parent_ancestors().find(|ancestor| {
            matches!(
                ancestor.kind(),
                SyntaxKind::EXCEPTION
                    | SyntaxKind::DECLARATOR
                    | SyntaxKind::NATIVE_DECL
                    | SyntaxKind::TYPE_DECL
            )
        })?;
        let alone = match part.parent() {
            Some(list) if matches!(part.kind(), SyntaxKind::EXCEPTION | SyntaxKind::DECLARATOR) => {
                list.children().filter(|child| child.kind() == part.kind()).count() == 1
            }
            _ => true,
        };
        let range = if alone {
            whole_lines(&part.ancestors().find(|ancestor| ast::Item::can_cast(ancestor.kind()))?)
        } else {
            with_comma(&part)
        };
        Some(TextFix::guess(format!("Remove `{name}`"), range, ""))
    }

    pub(crate) fn remove_comment(&self) -> Option<TextFix> {
        let comment = self.token_at(self.range)?;
        if !matches!(comment.kind(), SyntaxKind::LINE_COMMENT | SyntaxKind::BLOCK_COMMENT) {
            return None;
        }
        let range = with_line_before(comment.text_range(), Some(comment));
        Some(TextFix::guess("Remove the comment", range, ""))
    }
}

/// The edits that add an item to a list, whose items are nodes.
fn list_edits(
    list: &SyntaxNode,
    items: impl Iterator<Item = SyntaxNode>,
    item: &str,
) -> Vec<(TextRange, String)> {
    let base = list.text_range().start();
    let items =
        items.map(|item| bytes(TextRange::new(item.text_range().start(), end_of(&item)) - base));
    let edits = append_to_list(&list.text().to_string(), &items.collect::<Vec<_>>(), item);
    let edits = edits.into_iter().filter_map(|(range, text)| {
        let at = TextSize::try_from(range.start).ok()?;
        Some((TextRange::empty(base + at), text))
    });
    edits.collect()
}

fn add_yield(codel: &SyntaxNode, state: &str) -> Option<TextFix> {
    let yields = codel.descendants().find_map(ast::Yields::cast)?;
    if yields.states().any(|candidate| candidate.syntax().text() == state) {
        return None;
    }
    let name = codel.descendants().find_map(ast::Codel::cast)?.name()?;
    let edits = list_edits(codel, yields.states().map(|state| state.syntax().clone()), state);
    let title = format!("Let `{}` yield `{state}`", name.syntax().text());
    Some(TextFix { kind: FixKind::Choice, title, edits })
}
