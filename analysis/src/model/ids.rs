//! Indices into the tables of the model, one type for each table.

/// Declares the index into one table.
macro_rules! ids {
    ($($(#[$doc:meta])* $vis:vis $name:ident)*) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[derive(serde::Serialize, serde::Deserialize)]
        $vis struct $name($vis u32);

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
pub(crate) use ids;

ids! {
    /// A codel: an index into those of its [`Owner`](super::Owner).
    pub CodelId
    /// A component or interface: an index into [`Spec::components`](super::Spec::components).
    pub ComponentId
    /// A port: an index into [`Component::ports`](super::Component::ports).
    pub PortId
    /// A remote service: an index into [`Component::remotes`](super::Component::remotes).
    pub RemoteId
    /// An attribute, function or activity: an index into [`Component::services`](super::Component::services).
    pub ServiceId
    /// An execution task: an index into [`Component::tasks`](super::Component::tasks).
    pub TaskId
    /// A type object: an index into [`Spec::types`](super::Spec::types).
    pub TypeId
    /// One inclusion of one file, as the elaborator numbers them: the wrapper, then those of the unit.
    #[derive(Default)]
    pub VisitId
}
