//! Builds the tree from the events of the grammar and the elements of the preprocessor.
//!
//! Every raw token is written exactly once, so the text of the tree is the text of the file. Text that the
//! grammar does not read goes to fixed places: comments right above a declaration belong to it, directives
//! and inactive text stay in the body around, and a macro call is inside the outermost node that begins with
//! its expansion, so that this node has a place in the text. The tokens that a macro call expands to are
//! written with an empty text; the [`ExpansionMap`] holds their spellings.

mod builder;
mod directive;

use rowan::{GreenNode, TextSize};

use self::builder::TreeBuilder;
use crate::{
    ExpansionMap, TextRange,
    kind::SyntaxKind::{self, *},
    lexer::RawTokens,
    parser::{Event, SyntaxError, is_read},
    preproc::{Element, Preprocessed},
};

/// Builds the tree. Also returns the errors inside directives.
pub(crate) fn build(
    text: &str,
    raw: &RawTokens,
    pre: &Preprocessed,
    mut events: Vec<Event>,
) -> (GreenNode, ExpansionMap, Vec<SyntaxError>) {
    let mut sink = Sink {
        text,
        raw,
        pre,
        next: 0,
        call: TextRange::default(),
        builder: TreeBuilder::default(),
        expansion: ExpansionMap::default(),
        errors: Vec::new(),
    };
    let mut depth = 0u32;
    let mut parents = Vec::new();
    for i in 0..events.len() {
        match events[i] {
            Event::Start { .. } => {
                // Later nodes that also begin here enclose this one.
                let mut at = i;
                while let Event::Start { kind, forward_parent } =
                    std::mem::replace(&mut events[at], Event::tombstone())
                {
                    if kind != TOMBSTONE {
                        parents.push(kind);
                    }
                    if forward_parent == 0 {
                        break;
                    }
                    at += forward_parent as usize;
                }
                for kind in parents.drain(..).rev() {
                    if depth == 0 {
                        sink.builder.start_node(kind);
                    } else {
                        sink.start_node(kind);
                    }
                    depth += 1;
                }
            }
            Event::Finish => {
                depth -= 1;
                if depth == 0 {
                    sink.write_until(pre.elements.len());
                }
                sink.builder.finish_node();
            }
            Event::Token { kind } => sink.token(kind),
        }
    }
    (sink.builder.finish(), sink.expansion, sink.errors)
}

struct Sink<'a> {
    text: &'a str,
    raw: &'a RawTokens,
    pre: &'a Preprocessed,
    /// Next element to write.
    next: usize,
    /// The macro call written last.
    call: TextRange,
    builder: TreeBuilder,
    expansion: ExpansionMap,
    /// Errors inside directives.
    errors: Vec<SyntaxError>,
}

impl Sink<'_> {
    /// Begins a node. Elements before it that do not belong to it are written outside.
    fn start_node(&mut self, kind: SyntaxKind) {
        let first = self.next;
        let end = first
            + self.pre.elements[first..]
                .iter()
                .take_while(|element| self.is_passed(element))
                .count();
        // A call is part of the node that its expansion begins.
        let end = match self.pre.elements.get(end) {
            Some(Element::Virtual(_)) => self.leading_call(first, end),
            _ => end,
        };
        let attached = if takes_comments(kind) { self.attached_comments(first, end) } else { end };
        self.write_until(attached);
        self.builder.start_node(kind);
        self.write_until(end);
        if let Some(Element::Call { .. }) = self.pre.elements.get(self.next) {
            self.write_element();
        }
    }

    /// The next token of the grammar, under this kind.
    fn token(&mut self, kind: SyntaxKind) {
        while let Some(element) = self.pre.elements.get(self.next) {
            if self.is_passed(element) {
                self.write_element();
            } else {
                break;
            }
        }
        match self.pre.elements.get(self.next) {
            Some(Element::Real(i)) => {
                let text = self.raw.text(self.text, *i as usize);
                self.builder.token(kind, text);
            }
            Some(Element::Virtual(_)) => self.virtual_token(kind),
            _ => {}
        }
        self.next += 1;
    }

    fn write_until(&mut self, end: usize) {
        while self.next < end {
            self.write_element();
        }
    }

    /// Returns true if the grammar does not read this element.
    fn is_passed(&self, element: &Element) -> bool {
        match element {
            Element::Real(i) => !is_read(self.raw.kind(*i as usize)),
            Element::Virtual(token) => !is_read(token.kind),
            _ => true,
        }
    }

    /// Writes an element that the grammar did not read.
    fn write_element(&mut self) {
        match &self.pre.elements[self.next] {
            Element::Trivia(i) | Element::Real(i) => self.raw_token(*i),
            Element::Virtual(token) => self.virtual_token(token.kind),
            Element::Call { first, end } => {
                self.call = self.raw_range(*first, *end);
                self.builder.start_node(MACRO_CALL);
                let name = self.raw.kind(*first as usize);
                if *first < *end && (name == IDENT || name.is_reserved_word()) {
                    self.wrapped_token(*first, NAME_REF);
                    (first + 1..*end).for_each(|i| self.raw_token(i));
                } else {
                    (*first..*end).for_each(|i| self.raw_token(i));
                }
                self.builder.finish_node();
            }
            Element::Directive { first, end, index } => self.directive(*first, *end, *index),
            Element::Inactive { first, end } => {
                self.builder.start_node(INACTIVE);
                (*first..*end).for_each(|i| self.raw_token(i));
                self.builder.finish_node();
            }
        }
        self.next += 1;
    }

    fn virtual_token(&mut self, kind: SyntaxKind) {
        if let Element::Virtual(token) = &self.pre.elements[self.next] {
            self.expansion.push(self.builder.path(), (**token).clone(), self.call);
            self.builder.token(kind, "");
        }
    }

    fn raw_token(&mut self, i: u32) {
        let text = self.raw.text(self.text, i as usize);
        self.builder.token(self.raw.kind(i as usize), text);
    }

    /// One raw token in a node of its own.
    fn wrapped_token(&mut self, i: u32, kind: SyntaxKind) {
        self.builder.start_node(kind);
        self.raw_token(i);
        self.builder.finish_node();
    }

    fn raw_range(&self, first: u32, end: u32) -> TextRange {
        let start = self.raw.start(first as usize) as u32;
        let end = self.raw.start(end as usize) as u32;
        TextRange::new(TextSize::new(start), TextSize::new(end))
    }

    /// The index, among the elements before a virtual token, of the call it comes from.
    fn leading_call(&self, first: usize, end: usize) -> usize {
        (first..end)
            .rev()
            .find(|&i| matches!(self.pre.elements[i], Element::Call { .. }))
            .unwrap_or(end)
    }

    /// The index, among the elements before a declaration, of the first comment right above it. A comment
    /// that follows something on its line belongs to that; an empty line or a directive separates.
    fn attached_comments(&self, first: usize, end: usize) -> usize {
        let kind = |i: usize| match &self.pre.elements[i] {
            Element::Trivia(raw) => self.raw.kind(*raw as usize),
            _ => ERROR,
        };
        let mut attached = end;
        let mut line_ends = 0;
        for i in (first..end).rev() {
            match kind(i) {
                NEWLINE => line_ends += 1,
                WHITESPACE | SPLICE => {}
                node if node.is_comment() => {
                    let before = (first..i).rev().find(|&i| kind(i) != WHITESPACE);
                    let begins_line = match before {
                        Some(i) => kind(i) == NEWLINE || kind(i).is_comment(),
                        None => first == 0,
                    };
                    if !begins_line {
                        break;
                    }
                    attached = i;
                    line_ends = 0;
                }
                _ => break,
            }
            if line_ends > 1 {
                break;
            }
        }
        attached
    }
}

/// Returns true if comments right above a node of this kind belong to it.
fn takes_comments(kind: SyntaxKind) -> bool {
    matches!(
        kind,
        MODULE
            | CONST_DECL
            | TYPEDEF_DECL
            | NATIVE_DECL
            | EXCEPTION_DECL
            | EXCEPTION
            | TYPE_DECL
            | FORWARD_DECL
            | COMPONENT
            | IDS
            | TASK
            | PORT
            | SERVICE
            | MEMBER
            | CASE
            | ENUMERATOR
            | TYPED_PARAM
            | PATH_PARAM
            | STRING_PROPERTY
            | REQUIRES_PROPERTY
            | DURATION_PROPERTY
            | INTERFACES_PROPERTY
            | THROWS_PROPERTY
            | PRIORITY_PROPERTY
            | SCHEDULING_PROPERTY
            | STACK_PROPERTY
            | TASK_PROPERTY
            | SERVICES_PROPERTY
            | VALIDATE_PROPERTY
            | LOCAL_PROPERTY
            | CODEL_PROPERTY
    )
}
