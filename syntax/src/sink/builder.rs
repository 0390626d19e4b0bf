//! A green tree under construction that tracks its current path.

use rowan::{GreenNode, GreenNodeBuilder};

use crate::kind::SyntaxKind;

/// Rowan's builder, with the path to the next element.
#[derive(Default)]
pub(super) struct TreeBuilder {
    green: GreenNodeBuilder<'static>,
    /// For each open node below the root, and for the next element in the last one: its index among its
    /// siblings.
    path: Vec<u32>,
}

impl TreeBuilder {
    /// Indexes among siblings of the next element and the nodes it is in, from below the root.
    pub(super) fn path(&self) -> &[u32] {
        &self.path
    }

    pub(super) fn start_node(&mut self, kind: SyntaxKind) {
        self.green.start_node(kind.into());
        self.path.push(0);
    }

    pub(super) fn token(&mut self, kind: SyntaxKind, text: &str) {
        self.green.token(kind.into(), text);
        self.next_sibling();
    }

    pub(super) fn finish_node(&mut self) {
        self.green.finish_node();
        self.path.pop();
        self.next_sibling();
    }

    pub(super) fn finish(self) -> GreenNode {
        self.green.finish()
    }

    fn next_sibling(&mut self) {
        if let Some(index) = self.path.last_mut() {
            *index += 1;
        }
    }
}
