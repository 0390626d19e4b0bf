//! The nodes of directive lines.

use super::*;
use crate::{
    directive::{Define, DirectiveKind, IncludeForm, Name},
    parser::parse_wcet_pragma,
};

/// A run of raw tokens that makes a node inside a directive.
struct DirectiveNode {
    first: u32,
    end: u32,
    kind: SyntaxKind,
}

impl Sink<'_> {
    /// Writes a directive line, split into its parts. A `_Pragma` that comes out of a macro covers no token
    /// and makes an empty node.
    pub(super) fn directive(&mut self, first: u32, end: u32, index: u32) {
        let wcet = self.wcet_arguments(first, end, index);
        let limit = wcet.unwrap_or(end);
        self.builder.start_node(DIRECTIVE);
        let mut at = first;
        for part in self.parts(first, end, index) {
            if part.first < at || part.end > limit || part.first >= part.end {
                continue;
            }
            (at..part.first).for_each(|i| self.raw_token(i));
            self.builder.start_node(part.kind);
            (part.first..part.end).for_each(|i| self.raw_token(i));
            self.builder.finish_node();
            at = part.end;
        }
        match wcet {
            Some(arguments) => {
                (at..arguments).for_each(|i| self.raw_token(i));
                self.wcet(arguments, end);
            }
            None => (at..end).for_each(|i| self.raw_token(i)),
        }
        self.builder.finish_node();
    }

    fn parts(&self, first: u32, end: u32, index: u32) -> Vec<DirectiveNode> {
        let Some(directive) = self.pre.directives.get(index as usize) else {
            return Vec::new();
        };
        let of_range = |range, kind| self.node_of(range, kind);
        let of_name = |name: &Option<Name>, kind| {
            name.iter().map(|name| of_range(name.range, kind)).collect()
        };
        let of_tokens = |range: &std::ops::Range<u32>, kind| {
            vec![DirectiveNode { first: range.start, end: range.end, kind }]
        };
        match &directive.kind {
            DirectiveKind::Include(include) => match &include.form {
                IncludeForm::Quoted(_) | IncludeForm::Angled(_) => {
                    vec![of_range(include.range, INCLUDE_PATH)]
                }
                IncludeForm::Macro(tokens) => of_tokens(tokens, INCLUDE_PATH),
            },
            DirectiveKind::Define(define) => self.define_parts(define),
            DirectiveKind::Undef(undef)
            | DirectiveKind::Ifdef(undef)
            | DirectiveKind::Ifndef(undef) => {
                let mut parts: Vec<DirectiveNode> = of_name(&undef.name, NAME_REF);
                parts.extend(of_tokens(&undef.rest, DIRECTIVE_TEXT));
                parts
            }
            DirectiveKind::If(range) | DirectiveKind::Elif(range) => of_tokens(range, CONDITION),
            DirectiveKind::Else(otherwise)
            | DirectiveKind::Endif(otherwise)
            | DirectiveKind::Line(otherwise) => of_tokens(otherwise, DIRECTIVE_TEXT),
            DirectiveKind::Pragma(pragma) if !pragma.operator => {
                let mut parts: Vec<DirectiveNode> = of_name(&pragma.name, NAME_REF);
                parts.extend(
                    pragma.args.iter().map(|argument| of_range(argument.range, PRAGMA_ARG)),
                );
                parts
            }
            DirectiveKind::Pragma(_) => Vec::new(),
            DirectiveKind::Error(_) | DirectiveKind::Warning(_) | DirectiveKind::Unknown => {
                let after = directive
                    .keyword
                    .as_ref()
                    .map_or(first + 1, |keyword| of_range(keyword.range, NAME).end);
                let text = |i: &u32| !self.raw.kind(*i as usize).is_trivia();
                match ((after..end).find(text), (after..end).rfind(text)) {
                    (Some(first), Some(last)) => of_tokens(&(first..last + 1), DIRECTIVE_TEXT),
                    _ => Vec::new(),
                }
            }
            DirectiveKind::Empty => Vec::new(),
        }
    }

    fn define_parts(&self, define: &Define) -> Vec<DirectiveNode> {
        let name = define.name.iter();
        let mut parts: Vec<_> = name.map(|name| self.node_of(name.range, NAME)).collect();
        if define.params.is_some()
            && let Some(name) = parts.last()
        {
            let last =
                (name.end..define.body.start).rev().find(|&i| self.raw.kind(i as usize) == R_PAREN);
            parts.push(DirectiveNode {
                first: name.end,
                end: last.map_or(name.end, |close| close + 1),
                kind: MACRO_PARAMS,
            });
        }
        parts.push(DirectiveNode {
            first: define.body.start,
            end: define.body.end,
            kind: MACRO_BODY,
        });
        parts
    }

    fn node_of(&self, range: TextRange, kind: SyntaxKind) -> DirectiveNode {
        let last = usize::from(range.end()).saturating_sub(1);
        DirectiveNode {
            first: self.raw.token_at(range.start().into()) as u32,
            end: self.raw.token_at(last) as u32 + 1,
            kind,
        }
    }

    /// First raw token of the arguments of a `#pragma wcet` that is written as a line.
    fn wcet_arguments(&self, first: u32, end: u32, index: u32) -> Option<u32> {
        let DirectiveKind::Pragma(pragma) = &self.pre.directives.get(index as usize)?.kind else {
            return None;
        };
        let name = pragma.name.as_ref()?;
        if pragma.operator || name.text != "wcet" || first == end {
            return None;
        }
        let name = self.raw.token_at(name.range.start().into()) as u32;
        Some((name + 1..end).find(|&i| !self.raw.kind(i as usize).is_trivia()).unwrap_or(end))
    }

    /// The arguments of a `#pragma wcet`, read by the grammar. The model reports their errors
    /// (`wcet-pragma`).
    fn wcet(&mut self, first: u32, end: u32) {
        let elements: Vec<Element> = (first..end)
            .map(|i| {
                if is_read(self.raw.kind(i as usize)) {
                    Element::Real(i)
                } else {
                    Element::Trivia(i)
                }
            })
            .collect();
        let (events, errors) = parse_wcet_pragma(self.text, self.raw, &elements);
        self.errors.extend(errors);
        let pre = Preprocessed { elements, ..Preprocessed::default() };
        let (arguments, ..) = build(self.text, self.raw, &pre, events);
        for child in arguments.children() {
            self.green(child);
        }
    }

    /// Copies a finished element.
    fn green(
        &mut self,
        element: rowan::NodeOrToken<&rowan::GreenNodeData, &rowan::GreenTokenData>,
    ) {
        match element {
            rowan::NodeOrToken::Node(node) => {
                self.builder.start_node(SyntaxKind::from_raw(node.kind().0));
                node.children().for_each(|child| self.green(child));
                self.builder.finish_node();
            }
            rowan::NodeOrToken::Token(token) => {
                self.builder.token(SyntaxKind::from_raw(token.kind().0), token.text());
            }
        }
    }
}
