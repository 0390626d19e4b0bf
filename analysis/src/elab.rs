//! Elaboration: from the item trees of a translation unit to its model.
//!
//! [`elaborate`] is a pure function, sequential and in a single pass, as the language is defined:
//! declarations take effect as they are read, included files are followed in place, components and interfaces
//! may be reopened, and a body is checked each time it ends. Besides the model it returns every diagnostic,
//! and two tables for editor features: one [`Definition`] for each declared entity and one [`Reference`] for
//! each resolved use of a name.

mod codel;
mod component;
mod constant;
mod context;
pub(crate) mod convert;
mod decl;
mod finish;
mod foreign;
mod import;
mod initializer;
mod newer_releases;
mod opaque;
mod operator;
mod param;
mod pragma;
mod property;
mod scope;
mod service;
mod signature;
mod state;
mod task;
pub(crate) mod types;
mod union;
mod value;
mod words;

use std::sync::Arc;

use smol_str::SmolStr;
use typed_index_collections::{TiSlice, TiVec};

use crate::{
    finding::Finding,
    item_tree::ItemTree,
    model::{Component, ComponentId, PortId, ServiceId, Spec, Src, TaskId, TypeId, VisitId},
    release::Release,
};

/// The files of a translation unit, in order of visit.
#[derive(Debug, Clone, Copy)]
pub struct UnitInput<'a> {
    /// `visits[0]` is the root. One file may be visited several times, since other macros may be defined each
    /// time.
    pub visits: &'a TiSlice<VisitId, Visit<'a>>,
    /// The release of GenoM3 that defines the language.
    pub release: Release,
}

/// One inclusion of one file.
#[derive(Debug, Clone)]
pub struct Visit<'a> {
    /// The declarations of the file.
    pub tree: &'a ItemTree,
    /// Identity of the file: equal numbers mean the same file (a forward declaration must be completed in its
    /// own file).
    pub file: u32,
    /// The visits its active `#include` directives lead to, by ordinal; `None` for those that
    /// could not be followed.
    pub includes: Vec<Option<VisitId>>,
    /// Path of the file, for messages.
    pub path: &'a str,
}

/// The result of [`elaborate`].
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Elaborated {
    /// The model. Complete even if there are errors; unresolved parts are [`crate::model::TypeKind::Unknown`]
    /// or left out.
    pub spec: Arc<Spec>,
    /// Every problem found during elaboration, in order of the visited text. The checks at the end of bodies
    /// are separate: see [`crate::check`].
    pub diagnostics: Vec<Finding>,
    /// One entry for each use of a name that was resolved, in the order of elaboration.
    pub references: Vec<Reference>,
    /// Everything declared, by [`DefId`].
    pub definitions: TiVec<DefId, Definition>,
    /// One entry for each body of a component or interface, in the order in which they end.
    pub closings: Vec<BodyEnd>,
}

crate::model::ids::ids! {
    /// Index into [`Elaborated::definitions`].
    pub DefId
}

/// The kinds of declared entities.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum DefKind {
    Module,
    Component,
    Interface,
    Typedef,
    Struct,
    Union,
    Enum,
    Enumerator,
    /// A member of a struct, union or exception.
    Member,
    IdsMember,
    Exception,
    Native,
    Const,
    /// The ids of a component; declared by its first `ids` block.
    Ids,
    Task,
    Port,
    Attribute,
    Function,
    Activity,
    /// A parameter of a service.
    Parameter,
    /// A local variable of a service.
    Local,
    /// A codel: one function, used by any number of services and tasks.
    Codel,
    /// The name a codel parameter has inside the codel, when it is given with `::name`.
    CodelParameter,
    /// A state, one per component; declared by its first mention in a `< >` or `yields` list.
    State,
}

/// A declaration. An entity declared in several places (a reopened module, component, task or service, a
/// completed forward declaration, a codel or state mentioned again) has one definition, and references with
/// [`Reference::declaration`] set for the other places.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Definition {
    /// The index of the definition.
    pub id: DefId,
    pub kind: DefKind,
    pub name: SmolStr,
    /// The name token. For a completed forward declaration, the token of the completion.
    pub src: Src,
    /// The whole declaration.
    pub node: Src,
    /// The entity that contains it; `None` at global scope.
    pub container: Option<DefId>,
    /// The type object (types, constants, members, ports, states), or the type of its value
    /// (parameters and local variables).
    pub ty: Option<TypeId>,
    /// The place in the model, if it is not a type object.
    pub entity: Option<Entity>,
}

/// A part of the model that is not a type object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Entity {
    /// Index into [`Spec::components`].
    Component(ComponentId),
    /// Component, index into its tasks.
    Task(ComponentId, TaskId),
    /// Component, index into its ports.
    Port(ComponentId, PortId),
    /// Component, index into its services.
    Service(ComponentId, ServiceId),
    /// Component, index into its services, index into the parameters of that service.
    Param(ComponentId, ServiceId, u32),
}

/// A use of a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Reference {
    /// The name token.
    pub at: Src,
    /// The named entity.
    pub target: DefId,
    /// The access of a codel or attribute.
    pub access: AccessKind,
    /// The component or interface that contains it.
    pub component: Option<ComponentId>,
}

/// The access of a reference to its target.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum AccessKind {
    /// The declaration itself, again, or a part of it.
    Declaration,
    /// A mention without access to data.
    Mention,
    Read,
    Write,
    ReadWrite,
}

/// The end of a body of a component or interface, at which the component must be consistent.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BodyEnd {
    /// Index into [`Spec::components`].
    pub component: ComponentId,
    /// The state of the component at this end, if it was reopened later; otherwise see the [`Spec`].
    pub snapshot: Option<Box<Component>>,
}

impl Reference {
    /// Returns true if it declares (again, or part of) the target instead of using it.
    pub fn is_declaration(&self) -> bool {
        self.access == AccessKind::Declaration
    }
}

impl Elaborated {
    pub fn definition(&self, id: DefId) -> &Definition {
        &self.definitions[id]
    }

    /// The definitions around a definition, from the inside.
    pub(crate) fn containers(&self, definition: &Definition) -> impl Iterator<Item = &Definition> {
        let around = |definition: &Definition| definition.container.map(|id| self.definition(id));
        std::iter::successors(around(definition), move |inner| around(inner))
    }
}

/// Elaborates a translation unit. Total: bad input gives diagnostics.
pub(crate) fn elaborate(unit: &UnitInput<'_>) -> Elaborated {
    let mut elaborator = context::Elaborator::new(unit);
    if let Some(root) = unit.visits.first() {
        elaborator.for_each(&root.tree.items, context::Elaborator::statement);
    }
    elaborator.finish()
}
