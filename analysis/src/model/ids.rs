//! Indices into the tables of the model, one type for each table.

use serde::{Deserialize, Serialize};

/// Declares the index into one table.
macro_rules! ids {
    ($($(#[$doc:meta])* $name:ident)*) => {$(
        $(#[$doc])*
        #[derive(
            Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize,
        )]
        pub struct $name(pub u32);

        impl From<usize> for $name {
            #[inline]
            fn from(index: usize) -> Self {
                $name(index as u32)
            }
        }

        impl From<$name> for usize {
            #[inline]
            fn from(id: $name) -> usize {
                id.0 as usize
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                self.0.fmt(f)
            }
        }
    )*};
}

ids! {
    /// A component or interface: an index into [`Spec::components`](super::Spec::components).
    ComponentId
    /// A port: an index into [`Component::ports`](super::Component::ports).
    PortId
    /// A remote service: an index into [`Component::remotes`](super::Component::remotes).
    RemoteId
    /// An attribute, function or activity: an index into [`Component::services`](super::Component::services).
    ServiceId
    /// An execution task: an index into [`Component::tasks`](super::Component::tasks).
    TaskId
}
