//! Names of commands: client commands, which lenses and actions use, and server commands.

/// Client command that shows a state machine; argument `{ uri, component, owner }`.
pub(crate) const SHOW_DIAGRAM: &str = "dotgen.showDiagram";
/// Client command that lists references; argument `{ uri, position, locations }`.
pub(crate) const SHOW_REFERENCES: &str = "dotgen.showReferences";
/// Client command that shows a verification; argument `{ uri, check, run }`.
pub(crate) const SHOW_VERIFICATION: &str = "dotgen.showVerification";
/// Client command that runs a document on the virtual clock, without its codels; argument `{ uri }`.
pub(crate) const SIMULATE: &str = "dotgen.simulate";
/// Client command that runs a document on the real clock, with its codels; argument `{ uri }`.
pub(crate) const RUN: &str = "dotgen.run";
/// Server command: shows the declaration of a codel, or its function. Argument: a location.
pub(crate) const SHOW_CODEL: &str = "dotgen.showCodel";
/// Server command: a picture as Mermaid. Argument: as for `dotgen/diagram`.
pub(crate) const MERMAID: &str = "dotgen.diagram.mermaid";
/// Server command: a picture as Graphviz DOT.
pub(crate) const DOT: &str = "dotgen.diagram.dot";
/// Server command: shows an included file in the unit of another root.
pub(crate) const CHOOSE_ROOT: &str = "dotgen.chooseRoot";
