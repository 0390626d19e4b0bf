//! The interface that all typed nodes share.

use std::marker::PhantomData;

use crate::{
    SyntaxKind, SyntaxNode,
    ast::{Body, Item},
};

/// A node of a known kind: a thin wrapper without a cost at run time.
pub trait AstNode: Sized {
    /// Returns true if a node of this kind can be wrapped.
    fn can_cast(kind: SyntaxKind) -> bool;
    /// Wraps a node of the right kind.
    fn cast(syntax: SyntaxNode) -> Option<Self>;
    /// The node itself.
    fn syntax(&self) -> &SyntaxNode;
}

/// Defines a typed node of a kind.
macro_rules! node {
    ($name:ident: $kind:ident) => {
        #[derive(Debug, Clone, PartialEq, Eq, Hash)]
        pub struct $name {
            syntax: $crate::SyntaxNode,
        }
        impl AstNode for $name {
            fn can_cast(kind: $crate::SyntaxKind) -> bool {
                kind == $kind
            }
            fn cast(syntax: $crate::SyntaxNode) -> Option<Self> {
                Self::can_cast(syntax.kind()).then_some(Self { syntax })
            }
            fn syntax(&self) -> &$crate::SyntaxNode {
                &self.syntax
            }
        }
    };
}

/// Defines a choice between typed nodes and other choices.
macro_rules! choice {
    ($name:ident: $($variant:ident),+) => {
        #[derive(Debug, Clone, PartialEq, Eq, Hash)]
        pub enum $name {
            $($variant($variant)),+
        }
        impl AstNode for $name {
            fn can_cast(kind: $crate::SyntaxKind) -> bool {
                $($variant::can_cast(kind))||+
            }
            fn cast(syntax: $crate::SyntaxNode) -> Option<Self> {
                match syntax.kind() {
                    $(kind if $variant::can_cast(kind) => {
                        $variant::cast(syntax).map(Self::$variant)
                    })+
                    _ => None,
                }
            }
            fn syntax(&self) -> &$crate::SyntaxNode {
                match self {
                    $(Self::$variant(node) => node.syntax()),+
                }
            }
        }
    };
}

pub(super) use {choice, node};

/// The children of one type, in text order.
#[derive(Debug, Clone)]
pub struct AstChildren<N> {
    inner: rowan::SyntaxNodeChildren<crate::GenomLanguage>,
    marker: PhantomData<N>,
}

impl<N: AstNode> Iterator for AstChildren<N> {
    type Item = N;

    fn next(&mut self) -> Option<N> {
        self.inner.by_ref().find_map(N::cast)
    }
}

/// A declaration whose body holds items (declarations, properties, members or cases).
pub trait HasBody: AstNode {
    /// The braces with the text between them.
    fn body(&self) -> Option<Body> {
        support::child(self.syntax())
    }

    /// The items between the braces, directives included; empty without braces.
    fn items(&self) -> impl Iterator<Item = Item> {
        self.body().into_iter().flat_map(|body| body.items())
    }
}

/// Look-ups shared by the generated accessors.
pub mod support {
    use super::{AstChildren, AstNode, PhantomData};
    use crate::{SyntaxKind, SyntaxNode, SyntaxToken};

    /// First child of a type.
    pub fn child<N: AstNode>(parent: &SyntaxNode) -> Option<N> {
        parent.children().find_map(N::cast)
    }

    /// All children of a type.
    pub fn children<N: AstNode>(parent: &SyntaxNode) -> AstChildren<N> {
        AstChildren { inner: parent.children(), marker: PhantomData }
    }

    /// The first token of a node that is spelled in the text, other than blanks and comments.
    pub fn first_text_token(node: &SyntaxNode) -> Option<SyntaxToken> {
        let mut tokens = node.descendants_with_tokens().filter_map(rowan::NodeOrToken::into_token);
        tokens.find(is_text)
    }

    /// The last token of a node that is spelled in the text, other than blanks and comments.
    pub fn last_text_token(node: &SyntaxNode) -> Option<SyntaxToken> {
        let tokens = node.descendants_with_tokens().filter_map(rowan::NodeOrToken::into_token);
        tokens.filter(is_text).last()
    }

    /// Returns true for a token that is spelled in the text, and is not a blank or comment.
    pub fn is_text(token: &SyntaxToken) -> bool {
        !token.kind().is_trivia() && !token.text_range().is_empty()
    }

    /// First token of a kind directly below a node.
    pub fn token(parent: &SyntaxNode, kind: SyntaxKind) -> Option<SyntaxToken> {
        parent
            .children_with_tokens()
            .filter_map(rowan::NodeOrToken::into_token)
            .find(|token| token.kind() == kind)
    }
}
