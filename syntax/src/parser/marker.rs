//! Nodes under construction.

use crate::{
    kind::SyntaxKind,
    parser::{Parser, event::Event},
};

/// An open node. It must be completed or abandoned.
#[must_use]
pub(crate) struct Marker {
    position: u32,
}

impl Marker {
    pub(super) fn new(position: u32) -> Marker {
        Marker { position }
    }

    /// Ends the node and sets its kind.
    pub(crate) fn complete(self, p: &mut Parser<'_>, kind: SyntaxKind) -> CompletedMarker {
        if let Event::Start { kind: slot, .. } = &mut p.events[self.position as usize] {
            *slot = kind;
        }
        p.events.push(Event::Finish);
        CompletedMarker { position: self.position }
    }

    /// Ends the node if it holds something, abandons it otherwise.
    pub(crate) fn complete_unless_empty(self, p: &mut Parser<'_>, holds: bool, kind: SyntaxKind) {
        if holds {
            self.complete(p, kind);
        } else {
            self.abandon(p);
        }
    }

    /// Abandons the node; its content belongs to its parent.
    pub(crate) fn abandon(self, p: &mut Parser<'_>) {
        if self.position as usize + 1 == p.events.len() {
            p.events.pop();
        }
    }
}

/// A node that has ended.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CompletedMarker {
    position: u32,
}

impl CompletedMarker {
    /// Begins a node around this one.
    pub(crate) fn precede(self, p: &mut Parser<'_>) -> Marker {
        let outer = p.start();
        if let Event::Start { forward_parent, .. } = &mut p.events[self.position as usize] {
            *forward_parent = outer.position - self.position;
        }
        outer
    }
}
