//! The words of kinds and directions, as specifications and templates write them.

use super::{ParamDir, PortDir, ServiceKind};

impl ServiceKind {
    /// The word in specifications and templates.
    pub fn word(self) -> &'static str {
        match self {
            ServiceKind::Attribute => "attribute",
            ServiceKind::Function => "function",
            ServiceKind::Activity => "activity",
        }
    }
}

impl ParamDir {
    /// Returns true for input, and true for output.
    pub(crate) fn flow(self) -> (bool, bool) {
        use ParamDir::*;
        (matches!(self, In | Inout), matches!(self, Out | Inout))
    }

    /// The word in specifications and templates.
    pub fn word(self) -> &'static str {
        match self {
            ParamDir::Local => "local",
            ParamDir::In => "in",
            ParamDir::Out => "out",
            ParamDir::Inout => "inout",
        }
    }
}

impl PortDir {
    /// The word in specifications and templates.
    pub fn word(self) -> &'static str {
        match self {
            PortDir::In => "in",
            PortDir::Out => "out",
        }
    }
}
