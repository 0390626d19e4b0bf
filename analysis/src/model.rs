//! The resolved component model: plain data, no positions, no syntax.
//!
//! One [`Spec`] is the meaning of a translation unit after name resolution. All later stages (diagrams, code
//! generation, the verifier, `dotgen model`) read this and never the tree. Items refer to the text with a
//! [`Src`], which [`crate::source_map::Locations`] converts to a file and a range; the model itself therefore
//! stays equal when only positions change.
//!
//! Orders matter: types are in order of creation, everything else in order of declaration, as the template
//! language of GenoM3 exposes them (reference manual, "dotgen" objects).

pub mod fsm;
pub mod gaps;
pub(crate) mod ids;
pub mod layout;
pub mod mutex;
mod owner;
pub mod path;
pub mod system;
pub mod turn;
mod types;
pub(crate) mod visit;
mod words;

use num_rational::Ratio;
use serde::{Deserialize, Serialize};
use smol_str::SmolStr;
use typed_index_collections::{TiSlice, TiVec};

use crate::release::Release;
pub use gaps::{Gap, Missing, SourceKind, UnknownDependencies};
pub use ids::{CodelId, ComponentId, PortId, RemoteId, ServiceId, TaskId, TypeId, VisitId};
pub use owner::OwnerName;
pub use types::{Label, Scope, ScopeKind, Type, TypeKind, Value};

/// A name as written in the specification.
pub type Name = SmolStr;

/// An exact time in seconds.
pub type Seconds = Ratio<i128>;

/// The place of a declaration or mention: a node of the item tree of one visited file of the unit.
///
/// Ids are ordinals, not ranges, so that blank lines and comments do not change them.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, Default,
)]
pub struct Src {
    /// Index of the visit (one inclusion of one file) in the unit.
    pub visit: VisitId,
    /// Ordinal of the top-level item in that file.
    pub item: u32,
    /// Ordinal of the node inside that item.
    pub node: u32,
}

/// Everything one translation unit declares.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Spec {
    /// The release of GenoM3 that defines the language.
    pub release: Release,
    /// Every type object in order of creation, anonymous ones included. A type that was declared
    /// twice (a forward declaration and its definition) has two entries.
    pub types: TiVec<TypeId, Type>,
    /// Components and interfaces, in order of first declaration.
    pub components: TiVec<ComponentId, Component>,
    /// Packages of all `#pragma requires`, in order, without repetition.
    pub pragma_requires: Vec<String>,
    /// The bodies of components and interfaces, in order.
    pub bodies: Vec<Body>,
    /// The declarations of tasks and services, in order: a reopened one has several entries.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub owner_bodies: Vec<OwnerBody>,
    /// Gaps of components because a name could not be resolved; empty for specifications that GenoM3 accepts.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gaps: Vec<Gap>,
    /// Types declared by a stand-in, in order: their members are invented, so any member may exist.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub open: Vec<TypeId>,
    /// Interfaces declared by a stand-in: what they declare is unknown.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stand_ins: Vec<ComponentId>,
}

/// A part of the text in the body of a component or interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Body {
    pub visit: VisitId,
    /// The top-level item of the visit; `None` for the whole of a file that is included in the body.
    pub item: Option<u32>,
    pub component: ComponentId,
}

/// One declaration of a task or service.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct OwnerBody {
    pub component: ComponentId,
    /// The task or service.
    pub owner: Owner,
    /// The whole declaration.
    pub node: Src,
}

/// `component` or `interface`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ComponentKind {
    Component,
    Interface,
}

/// A number given in a property, with its anonymous constant type.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Quantity {
    /// Exact value: seconds for times, a plain number for `priority` and `stack` (bytes).
    #[serde(with = "crate::model::ratio_serde")]
    pub value: Seconds,
    /// The anonymous constant that templates see.
    pub ty: TypeId,
    /// The property.
    pub src: Src,
}

/// A component or an interface.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Component {
    pub name: Name,
    /// Component or interface.
    pub kind: ComponentKind,
    /// The name in its first declaration.
    pub src: Src,
    /// `doc` texts, joined with newlines.
    pub doc: Option<String>,
    /// `version`; components default to `"0"`.
    pub version: Option<String>,
    /// `lang`; components default to `"c"`.
    pub lang: Option<String>,
    /// `email`
    pub email: Option<String>,
    /// `requires`, in order, without repetition.
    pub requires: Vec<String>,
    /// `codels-requires`, in order, without repetition.
    pub codels_requires: Vec<String>,
    /// Given, imported, or (components with a periodic task) computed.
    pub clock_rate: Option<Quantity>,
    /// `stack`, in bytes: for all threads whose task does not set its own.
    pub stack: Option<Quantity>,
    /// The ids structure.
    pub ids: Option<TypeId>,
    /// Interfaces named by `provides` (also by pragma), `uses`, `extends`.
    pub provides: Vec<ComponentId>,
    /// See [`Component::provides`].
    pub uses: Vec<ComponentId>,
    /// See [`Component::provides`].
    pub extends: Vec<ComponentId>,
    /// Exceptions thrown by all services (the component's own `throws`).
    pub throws: Vec<TypeId>,
    /// Execution tasks.
    pub tasks: TiVec<TaskId, Task>,
    pub ports: TiVec<PortId, Port>,
    /// Attributes, functions and activities.
    pub services: TiVec<ServiceId, Service>,
    /// Remote services (imported with `uses`).
    pub remotes: TiVec<RemoteId, Remote>,
}

/// An execution task.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Task {
    pub name: Name,
    pub src: Src,
    pub doc: Option<String>,
    /// Period in seconds; `None` for an aperiodic task.
    pub period: Option<Quantity>,
    /// Delay in seconds.
    pub delay: Option<Quantity>,
    pub priority: Option<Quantity>,
    /// `scheduling real-time`
    pub real_time: bool,
    /// Stack size in bytes.
    pub stack: Option<Quantity>,
    /// Own `throws` only.
    pub throws: Vec<TypeId>,
    /// The state machine of the permanent activity.
    pub codels: TiVec<CodelId, Codel>,
    /// The interface it was imported from, if any.
    pub imported_from: Option<ComponentId>,
}

/// Direction of a port.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PortDir {
    In,
    Out,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Port {
    pub name: Name,
    /// The declaration (the name).
    pub src: Src,
    /// Direction as seen from this component (already reversed for `uses`).
    pub dir: PortDir,
    /// `port multiple`
    pub multiple: bool,
    pub data: TypeId,
    /// The port's own type object.
    pub ty: TypeId,
    /// `doc`
    pub doc: Option<String>,
    /// The interface it was imported from, if any.
    pub imported_from: Option<ComponentId>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ServiceKind {
    Attribute,
    Function,
    Activity,
}

/// A list of services in `interrupts`, `before` or `after`.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ServiceList {
    /// `all` was named: every service of the component.
    pub all: bool,
    /// The services named: indexes into [`Component::services`].
    pub services: Vec<ServiceId>,
}

/// An attribute, function or activity.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Service {
    pub name: Name,
    /// The last declaration (the name).
    pub src: Src,
    pub kind: ServiceKind,
    /// `doc`
    pub doc: Option<String>,
    /// Task it runs in (activities): index into [`Component::tasks`].
    pub task: Option<TaskId>,
    /// Parameters and local variables, in order. For attributes these are paths into the ids.
    pub params: Vec<Param>,
    /// All codels, in order of properties, of any [`CodelKind`].
    pub codels: TiVec<CodelId, Codel>,
    /// Own `throws` only.
    pub throws: Vec<TypeId>,
    /// `interrupts`
    pub interrupts: ServiceList,
    /// `before`
    pub before: ServiceList,
    /// `after`
    pub after: ServiceList,
    /// The interface it was imported from, if any.
    pub imported_from: Option<ComponentId>,
}

/// A service of an interface that the component uses.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Remote {
    pub name: Name,
    /// The service in the interface.
    pub src: Src,
    pub kind: ServiceKind,
    /// The parameters.
    pub params: Vec<Param>,
    /// The type object of the remote.
    pub ty: TypeId,
    /// The interface it comes from.
    pub interface: ComponentId,
    /// The service of that interface: index into [`Component::services`].
    pub service: ServiceId,
    /// Exceptions: providing interface, its task, the service.
    pub throws: Vec<TypeId>,
}

/// The purpose of a codel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CodelKind {
    /// Checks the parameters of a request.
    Validate,
    /// Executed in order by the control task (functions).
    Simple,
    /// Bound to states of a state machine (tasks and activities).
    Fsm,
}

/// A codel in one place of use.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Codel {
    /// Name of the C/C++ function.
    pub name: Name,
    /// The name in the declaration.
    pub src: Src,
    /// The whole declaration.
    pub node: Src,
    /// The purpose.
    pub kind: CodelKind,
    /// `async`
    pub is_async: bool,
    /// Parameters in order.
    pub params: Vec<Param>,
    /// States it implements (fsm codels).
    pub triggers: Vec<State>,
    /// States it can lead to, in order of declaration.
    pub yields: Vec<State>,
    /// Worst-case execution time, in seconds.
    pub wcet: Option<Quantity>,
}

/// A state as named in `< >` or in a `yields` list.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct State {
    /// State name without `pause::`.
    pub name: Name,
    /// Written with `pause::`.
    pub paused: bool,
    /// The event type object.
    pub event: TypeId,
    /// This mention.
    pub src: Src,
}

/// Direction of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ParamDir {
    /// A local variable of a service.
    Local,
    In,
    Out,
    Inout,
}

/// The data that a parameter refers to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(tag = "kind", content = "index", rename_all = "lowercase")]
pub enum ParamSource {
    Ids,
    /// For service parameters and local variables: itself (`None`). For codel parameters: a
    /// parameter or local variable of the service (index into [`Service::params`]).
    Local(Option<u32>),
    /// A port (index into [`Component::ports`]).
    Port(PortId),
    /// A remote (index into [`Component::remotes`]).
    Remote(RemoteId),
    /// An unresolved reference: its target is missing, or comes from a missing file. Its type is
    /// [`TypeKind::Unknown`].
    Opaque,
}

impl ParamSource {
    /// The word of the template language.
    pub fn word(self) -> &'static str {
        match self {
            ParamSource::Ids => "ids",
            ParamSource::Local(_) => "local",
            ParamSource::Port(_) => "port",
            ParamSource::Remote(_) => "remote",
            ParamSource::Opaque => "unknown",
        }
    }
}

/// One step of a path into a value.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(untagged)]
pub enum PathElement {
    /// `.name`
    Member(Name),
    /// `[index]`
    Index(u64),
}

/// A parameter of a service or codel, or a local variable of a service.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Param {
    /// Name after renaming.
    pub name: Name,
    /// The parameter.
    pub src: Src,
    /// Direction.
    pub dir: ParamDir,
    /// The data it refers to.
    pub source: ParamSource,
    /// Type the path starts from (the ids, port data, remote type, or local type).
    pub base: TypeId,
    /// Type after the path.
    pub ty: TypeId,
    /// Path inside the source; starts with the member name for ids, empty for the whole ids.
    pub path: Vec<PathElement>,
    /// Default value (parameters of services).
    pub init: Option<Initializer>,
}

/// A default value, matched to the members of its type.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Initializer {
    /// The initialized member or index, inside a compound.
    pub member: Option<PathElement>,
    /// Documentation string.
    pub doc: Option<String>,
    /// The value.
    pub value: InitValue,
    /// Type of the initialized value.
    pub ty: TypeId,
    /// The initializer.
    pub src: Src,
}

/// The value of an initializer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InitValue {
    /// Documentation only.
    Void,
    /// A constant.
    Scalar(Value),
    /// `{ … }`
    Compound(Vec<Initializer>),
}

/// Owner of a codel inside a component.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Owner {
    /// Index into [`Component::tasks`].
    Task(TaskId),
    /// Index into [`Component::services`].
    Service(ServiceId),
}

/// Names one codel of a component.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct CodelRef {
    /// Task or service that declares it.
    pub owner: Owner,
    /// Index into that owner's codels.
    pub index: CodelId,
}

impl Spec {
    /// The type object of an id.
    pub fn ty(&self, id: TypeId) -> &Type {
        &self.types[id]
    }

    /// The component or interface whose body contains a node.
    pub fn body_of(&self, src: Src) -> Option<ComponentId> {
        // Parts created with a component have the place of its name, which is not in any body.
        if self.components.iter().any(|component| component.src == src) {
            return None;
        }
        let inside =
            |body: &&Body| body.visit == src.visit && body.item.is_none_or(|item| item == src.item);
        self.bodies.iter().find(inside).map(|body| body.component)
    }

    /// The type behind typedefs, members, constants and completed forward declarations.
    pub fn resolve_alias(&self, mut id: TypeId) -> TypeId {
        // The elaborator never builds a cycle; the bound protects against foreign data.
        for _ in 0..self.types.len() {
            id = match self.ty(id).kind {
                TypeKind::Typedef { ty }
                | TypeKind::StructMember { ty }
                | TypeKind::UnionMember { ty, .. }
                | TypeKind::Const { ty, .. } => ty,
                TypeKind::ForwardStruct { definition: Some(ty) }
                | TypeKind::ForwardUnion { definition: Some(ty) } => ty,
                _ => return id,
            };
        }
        id
    }

    /// `::full::name` of a named type, `None` for anonymous ones.
    pub fn full_name(&self, id: TypeId) -> Option<String> {
        let ty = self.ty(id);
        let name = ty.name.as_ref()?;
        let mut out = String::new();
        for scope in &ty.scope {
            out.push_str("::");
            out.push_str(&scope.name);
        }
        out.push_str("::");
        out.push_str(name);
        Some(out)
    }
}

impl Component {
    pub fn codels_of(&self, owner: Owner) -> &TiSlice<CodelId, Codel> {
        match owner {
            Owner::Task(i) => &self.tasks[i].codels,
            Owner::Service(i) => &self.services[i].codels,
        }
    }

    pub fn codel(&self, codel: CodelRef) -> &Codel {
        &self.codels_of(codel.owner)[codel.index]
    }

    /// Everything that has codels: tasks in order, then services in order.
    pub fn owners(&self) -> impl Iterator<Item = Owner> + use<> {
        let tasks = self.tasks.keys().map(Owner::Task);
        tasks.chain(self.services.keys().map(Owner::Service))
    }

    /// Tasks and services with a state machine, in order.
    pub fn machines(&self) -> impl Iterator<Item = Owner> + '_ {
        let has_machine =
            |owner: &Owner| self.codels_of(*owner).iter().any(|codel| codel.kind == CodelKind::Fsm);
        self.owners().filter(has_machine)
    }

    /// Name of a task or service.
    pub fn owner_name(&self, owner: Owner) -> &Name {
        match owner {
            Owner::Task(task) => &self.tasks[task].name,
            Owner::Service(service) => &self.services[service].name,
        }
    }

    /// Every codel: those of tasks in order, then those of services in order.
    pub fn all_codels(&self) -> impl Iterator<Item = CodelRef> + '_ {
        self.owners().flat_map(|owner| {
            self.codels_of(owner).keys().map(move |index| CodelRef { owner, index })
        })
    }

    /// The execution task that runs a codel; `None` for codels that the control task runs (validate and
    /// simple codels).
    pub fn task_of(&self, codel: CodelRef) -> Option<TaskId> {
        match codel.owner {
            Owner::Task(i) => Some(i),
            Owner::Service(i) if self.codel(codel).kind == CodelKind::Fsm => self.services[i].task,
            Owner::Service(_) => None,
        }
    }
}

/// Exact rationals as `"num/den"` text.
pub mod ratio_serde {
    use num_rational::Ratio;
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    /// Writes `num/den`.
    ///
    /// # Errors
    /// Returns the error of the serializer.
    pub fn serialize<S: Serializer>(value: &Ratio<i128>, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(&format_args!("{}/{}", value.numer(), value.denom()))
    }

    /// Reads `num/den`.
    ///
    /// # Errors
    /// Fails for any other text.
    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Ratio<i128>, D::Error> {
        let text = String::deserialize(from)?;
        text.parse().map_err(D::Error::custom)
    }
}
