//! The kinds of content of a file.

/// The content of a text: a whole specification, or the inside of one kind of body for a file that is
/// included there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Fragment {
    /// A whole specification.
    Specification,
    /// The body of a module.
    Module,
    /// The body of a component or interface.
    Component,
    /// The body of a struct, an exception or `ids`.
    Members,
    /// The body of a union.
    Cases,
    /// The properties of a task, port or service.
    Properties,
}
