//! The state of an elaboration beyond the model: components, tasks, services and codels as written, and the
//! work that waits for the end of the input.

use dotgen_syntax::SyntaxKind;
use rustc_hash::{FxHashMap, FxHashSet};
use typed_index_collections::TiVec;

use super::{DefId, scope::ScopeId};
use crate::{
    item_tree::{CodelDecl, ParamDecl},
    model::{
        CodelKind, ComponentId, Name as Text, ParamDir, PortId, RemoteId, Seconds, ServiceId, Src,
        TaskId, TypeId, VisitId,
    },
    release::{Change, Release},
};

/// The state of a component beyond the model.
#[derive(Debug)]
pub(super) struct ComponentState<'a> {
    pub(super) def: DefId,
    pub(super) scope: ScopeId,
    /// The scope of paused states.
    pub(super) pause: ScopeId,
    /// The scope of the ids, once they exist.
    pub(super) ids: Option<ScopeId>,
    /// Properties that do not merge, with the place where they were given.
    pub(super) given: FxHashMap<&'static str, Src>,
    /// Parallel to `Component::tasks`.
    pub(super) tasks: TiVec<TaskId, TaskState<'a>>,
    /// Parallel to `Component::services`.
    pub(super) services: TiVec<ServiceId, ServiceState<'a>>,
    /// Parallel to `Component::ports`.
    pub(super) ports: TiVec<PortId, DefId>,
    /// Parallel to `Component::remotes`.
    pub(super) remotes: TiVec<RemoteId, DefId>,
    pub(super) task_by_name: FxHashMap<Text, TaskId>,
    pub(super) service_by_name: FxHashMap<Text, ServiceId>,
    pub(super) port_by_name: FxHashMap<Text, PortId>,
    pub(super) remote_by_name: FxHashMap<Text, RemoteId>,
    /// Names of ports, services and remotes that were refused: their uses are not reported again.
    pub(super) lost: FxHashSet<Text>,
    /// True if an interface could not be imported, so that any name may be missing.
    pub(super) incomplete: bool,
    /// Interfaces whose contents it has, directly or indirectly.
    pub(super) imported: Vec<ComponentId>,
    /// Interfaces in its `uses`, `extends` and `provides`, and in those of the interfaces it imports.
    pub(super) lists: [Vec<ComponentId>; 3],
    /// Index of its last closing.
    pub(super) closing: Option<usize>,
}

/// The state of a task beyond the model.
#[derive(Debug)]
pub(super) struct TaskState<'a> {
    pub(super) def: DefId,
    /// Properties that do not merge, with the place where they were given.
    pub(super) given: FxHashMap<&'static str, Src>,
    /// Parallel to the codels of the task.
    pub(super) codels: Vec<CodelSource<'a>>,
    /// True if it has codels that were refused, so that its state machine is not known.
    pub(super) incomplete: bool,
}

/// The state of a service beyond the model.
#[derive(Debug, Clone)]
pub(super) struct ServiceState<'a> {
    pub(super) def: DefId,
    /// Parallel to the parameters and local variables.
    pub(super) params: Vec<DefId>,
    /// The parameters of an attribute as written, to be resolved again by importing components.
    pub(super) paths: Vec<PathSource<'a>>,
    /// Parallel to the codels.
    pub(super) codels: Vec<CodelSource<'a>>,
    /// Properties that do not merge, with the place where they were given.
    pub(super) given: FxHashMap<&'static str, Src>,
    /// `interrupts`, `before`, `after`, as far as named.
    pub(super) lists: [NameList; 3],
    /// The local variables in the declaration that is being read.
    pub(super) locals_here: Vec<Text>,
}

/// A parameter of an attribute, as written.
#[derive(Debug, Clone, Copy)]
pub(super) struct PathSource<'a> {
    pub(super) decl: &'a ParamDecl,
    pub(super) visit: VisitId,
    pub(super) scope: ScopeId,
}

/// The names in `interrupts`, `before` or `after`. They are resolved when the body ends.
#[derive(Debug, Clone, Default)]
pub(super) struct NameList {
    pub(super) names: Vec<(Text, Src)>,
}

/// A codel as written, kept so that an importing component can resolve it again.
#[derive(Debug, Clone, Copy)]
pub(super) struct CodelSource<'a> {
    pub(super) decl: &'a CodelDecl,
    pub(super) visit: VisitId,
    /// Scope of the constants in its paths.
    pub(super) scope: ScopeId,
    pub(super) kind: CodelKind,
}

/// The first use of a codel name, with which all others must agree.
#[derive(Debug)]
pub(super) struct KnownCodel {
    pub(super) def: DefId,
    pub(super) src: Src,
    /// `None` if a parameter could not be resolved.
    pub(super) signature: Option<Vec<(ParamDir, TypeId)>>,
}

/// `#pragma wcet`, kept until all codels are known.
#[derive(Debug)]
pub(super) struct PragmaWcet {
    pub(super) codel: Text,
    /// The name of the codel.
    pub(super) name: Src,
    /// The directive.
    pub(super) at: Src,
    pub(super) number: Seconds,
    pub(super) unit: Option<SyntaxKind>,
}

/// The newer releases referred to by a unit.
#[derive(Debug, Default)]
pub(super) struct NewerReleases {
    /// The used changes, with a description and a place for each.
    pub(super) uses: Vec<(Change, &'static str, Src)>,
    /// The releases that `requires` properties name, with their places.
    pub(super) requirements: Vec<(Release, Src)>,
}
