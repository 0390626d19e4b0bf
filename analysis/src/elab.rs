//! Elaboration: from the item trees of a translation unit to its model.
//!
//! [`elaborate`] is a pure function, sequential and in a single pass, because that is how the
//! language is defined: declarations take effect as they are read, included files are followed in
//! place, components and interfaces may be reopened, and a body is checked each time it ends.
//! Besides the model it returns every diagnostic, and two tables from which editor features are
//! derived: one [`Definition`] for each thing a text declares and one [`Reference`] for each name
//! use that was resolved.

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
mod newer;
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

use crate::{
    finding::Finding,
    item_tree::ItemTree,
    model::{Component, Spec, Src, TypeId},
    release::Release,
};

/// The files of a translation unit, in the form they are visited.
#[derive(Debug, Clone, Copy)]
pub struct UnitInput<'a> {
    /// `visits[0]` is the root. One file may be visited several times, as the preprocessor found
    /// other macros defined each time.
    pub visits: &'a [Visit<'a>],
    /// The release of GenoM3 whose language it is.
    pub release: Release,
}

/// One inclusion of one file.
#[derive(Debug, Clone)]
pub struct Visit<'a> {
    /// What it declares.
    pub tree: &'a ItemTree,
    /// Identity of the file: equal numbers mean the same file (a forward declaration must be
    /// completed in the file it stands in).
    pub file: u32,
    /// The visits its active `#include` directives lead to, by ordinal; `None` for those that
    /// could not be followed.
    pub includes: Vec<Option<u32>>,
    /// Path of the file, for messages.
    pub path: &'a str,
}

/// What [`elaborate`] found.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Elaborated {
    /// The model. Complete even when there are errors; what could not be resolved is
    /// [`crate::model::TypeKind::Unknown`] or left out.
    pub spec: Arc<Spec>,
    /// Every problem found while elaborating, in the order of the text as it is visited. The checks
    /// made at the end of bodies are separate: see [`crate::check`].
    pub diagnostics: Vec<Finding>,
    /// One entry for each use of a name that was resolved, in the order of elaboration.
    pub references: Vec<Reference>,
    /// Everything declared, by [`DefId`].
    pub definitions: Vec<Definition>,
    /// One entry for each body of a component or interface, in the order in which they end.
    pub closings: Vec<Closing>,
}

/// Index into [`Elaborated::definitions`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct DefId(pub u32);

/// What was declared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[allow(missing_docs, reason = "the words of the language")]
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
    /// A member of the ids.
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
    /// A codel: one function, however many services and tasks use it.
    Codel,
    /// The name a codel parameter has inside the codel, when it is given with `::name`.
    CodelParameter,
    /// A state, one per component; declared by its first mention in a `< >` or `yields` list.
    State,
}

/// A declaration. What is declared in several places (a reopened module, component, task or
/// service, a completed forward declaration, a codel or state mentioned again) has one definition,
/// and references with [`Reference::declaration`] set for the other places.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Definition {
    /// Its own index.
    pub id: DefId,
    /// What it is.
    pub kind: DefKind,
    /// Its name.
    pub name: SmolStr,
    /// The name token. For a completed forward declaration, that of the completion.
    pub src: Src,
    /// The whole declaration.
    pub node: Src,
    /// What it is declared in; `None` at global scope.
    pub container: Option<DefId>,
    /// Its type object (types, constants, members, ports, states), or the type of its value
    /// (parameters and local variables).
    pub ty: Option<TypeId>,
    /// Where to find it in the model, when it is not a type object.
    pub entity: Option<Entity>,
}

/// A part of the model that is not a type object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Entity {
    /// Index into [`Spec::components`].
    Component(u32),
    /// Component, index into its tasks.
    Task(u32, u32),
    /// Component, index into its ports.
    Port(u32, u32),
    /// Component, index into its services.
    Service(u32, u32),
    /// Component, index into its services, index into the parameters of that.
    Param(u32, u32, u32),
}

/// A use of a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Reference {
    /// The name token.
    pub at: Src,
    /// What it means.
    pub target: DefId,
    /// What a codel or attribute does with it.
    pub access: Access,
    /// It declares (again, or part of) the target rather than using it.
    pub declaration: bool,
    /// The component or interface in whose body it stands.
    pub component: Option<u32>,
}

/// What a parameter of a codel or attribute does with the data it names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Access {
    /// Not an access to data.
    #[default]
    None,
    /// `in`
    Read,
    /// `out`
    Write,
    /// `inout`
    ReadWrite,
}

/// The end of a body of a component or interface, where it must be consistent.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Closing {
    /// Index into [`Spec::components`].
    pub component: u32,
    /// The component as it was then, when it was reopened later; otherwise look in the [`Spec`].
    pub snapshot: Option<Box<Component>>,
}

impl Elaborated {
    /// A definition.
    pub fn definition(&self, id: DefId) -> &Definition {
        &self.definitions[id.0 as usize]
    }
}

/// Gives a translation unit its meaning. Total: bad input gives diagnostics.
pub fn elaborate(unit: &UnitInput<'_>) -> Elaborated {
    let mut elaborator = context::Elaborator::new(unit);
    if let Some(root) = unit.visits.first() {
        elaborator.for_each(&root.tree.items, |this, item| this.statement(item));
    }
    elaborator.finish()
}
