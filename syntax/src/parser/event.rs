//! The output of the grammar, as a flat list of events.
//!
//! Events keep the grammar independent of the tree: it neither handles trivia, directives and macro calls nor
//! allocates nodes. [`crate::sink`] reads them.

use crate::kind::SyntaxKind;

/// One step of building the tree.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Event {
    /// A node begins.
    Start {
        /// `TOMBSTONE` while the node is open and for abandoned nodes.
        kind: SyntaxKind,
        /// Distance to the `Start` of a later node that also begins here and encloses this one (see
        /// `CompletedMarker::precede`); 0 if there is none.
        forward_parent: u32,
    },
    /// The last node begun ends.
    Finish,
    /// The next token of the input, under this kind.
    Token {
        /// The kind: a contextual keyword has become one here.
        kind: SyntaxKind,
    },
}

impl Event {
    pub(crate) fn tombstone() -> Event {
        Event::Start { kind: SyntaxKind::TOMBSTONE, forward_parent: 0 }
    }
}
