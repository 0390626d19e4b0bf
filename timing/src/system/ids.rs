//! Indices into the tables of a [`TimedSystem`](super::TimedSystem), one type for each table.
//!
//! States of the explorer hold them as plain numbers; they are converted where such a number is read or
//! written. The default is the first index.

/// Declares the index into one table of a system.
macro_rules! ids {
    ($($(#[$doc:meta])* $name:ident)*) => {$(
        $(#[$doc])*
        #[derive(Debug, Default, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(usize);

        impl From<usize> for $name {
            #[inline]
            fn from(index: usize) -> Self {
                $name(index)
            }
        }

        impl From<$name> for usize {
            #[inline]
            fn from(id: $name) -> usize {
                id.0
            }
        }
    )*};
}

ids! {
    /// An instance of a state machine: an index into [`TimedSystem::automata`](super::TimedSystem::automata).
    AutomatonId
    /// A client: an index into [`TimedSystem::clients`](super::TimedSystem::clients).
    ClientId
    /// A codel in one place of use: an index into [`TimedSystem::codels`](super::TimedSystem::codels).
    CodelId
    /// A component: an index into [`TimedSystem::components`](super::TimedSystem::components). Components of
    /// specifications, in [`Names::components`](crate::scn::names::Names::components), have other numbers.
    ComponentId
    /// A state machine: an index into [`TimedSystem::machines`](super::TimedSystem::machines).
    MachineId
    /// A service: an index into [`TimedSystem::services`](super::TimedSystem::services).
    ServiceId
    /// An execution task: an index into [`TimedSystem::tasks`](super::TimedSystem::tasks).
    TaskId
}
