//! The gaps of a specification: names that could not be resolved.
//!
//! In a fresh clone the required packages may be missing: their interfaces, types and exceptions are unknown.
//! Independent parts are still checked; a check that concludes from the absence of something must first
//! consult the gaps.

use rustc_hash::FxHashSet;
use serde::{Deserialize, Serialize};

use super::{
    Codel, ComponentId, Name, Owner, ParamDir, ParamSource, PathElement, ServiceId, Spec, TypeId,
    TypeKind,
};

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Gap {
    /// `None` outside of components and interfaces.
    pub component: Option<ComponentId>,
    /// The unresolved name.
    pub missing: Missing,
}

/// An unresolved name.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Missing {
    /// An interface, so that any of its declarations may be missing.
    Interface {
        name: Name,
        /// True if it is only used: no tasks, services and codels of the component come from it.
        used: bool,
    },
    /// The programming language: the component names none, and an unknown interface may name it.
    Language,
    /// An exception in a list of exceptions.
    Exception {
        /// The path as written.
        name: Name,
        /// The task or service that throws it; `None` for the component.
        owner: Option<Owner>,
    },
    /// A type or constant.
    Name {
        /// The path as written.
        name: Name,
        /// True if it is used as a constant.
        constant: bool,
    },
    /// A member of a value of an unknown type, named by a parameter.
    Member {
        /// Full name of the type.
        of: Name,
        /// The path from there.
        path: Vec<PathElement>,
    },
    /// A port, service or member that a codel names.
    Source {
        name: Name,
        /// The kind as written; `None` if it is not written.
        kind: Option<SourceKind>,
        /// The access of the codel.
        dir: ParamDir,
        /// The service whose codel it is, by index.
        service: Option<ServiceId>,
    },
    /// A task that an activity names, which an unknown interface may declare.
    Task { name: Name },
    /// A service in the `interrupts`, `before` or `after` of another one, which an unknown interface may
    /// declare.
    Service { name: Name },
}

/// The kinds of sources that a codel parameter may name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SourceKind {
    Ids,
    Local,
    Port,
    Remote,
}

impl Spec {
    /// The gaps of a component, those of the interfaces that it imports included.
    pub fn gaps_of(&self, component: ComponentId) -> impl Iterator<Item = &Missing> {
        let declaration = &self.components[component];
        let lists = [&declaration.provides, &declaration.uses, &declaration.extends];
        self.gaps
            .iter()
            .filter(move |gap| {
                let of =
                    |at: ComponentId| at == component || lists.iter().any(|all| all.contains(&at));
                gap.component.is_some_and(of)
            })
            .map(|gap| &gap.missing)
    }

    /// Unknown interfaces that a component imports, each once.
    pub(crate) fn missing_interfaces(&self, component: ComponentId) -> Vec<&Name> {
        let mut out = Vec::new();
        for gap in self.gaps_of(component) {
            if let Missing::Interface { name, .. } = gap
                && !out.contains(&name)
            {
                out.push(name);
            }
        }
        out
    }

    /// Interfaces from which tasks, services and codels of a component come, although nothing is known of
    /// what they declare: each is missing, or a stand-in takes its place.
    pub fn unknown_interfaces(&self, component: ComponentId) -> Vec<&Name> {
        let missing = self.gaps_of(component).filter_map(|gap| match gap {
            Missing::Interface { name, used: false } => Some(name),
            _ => None,
        });
        let declaration = &self.components[component];
        let imported = [&declaration.provides, &declaration.extends].into_iter().flatten();
        let stand_ins = imported.filter(|interface| self.stand_ins.contains(interface));
        let stand_ins = stand_ins.map(|&interface| &self.components[interface].name);
        let mut out: Vec<&Name> = Vec::new();
        for name in missing.chain(stand_ins) {
            if !out.contains(&name) {
                out.push(name);
            }
        }
        out
    }

    /// Returns true if tasks, services, codels or properties of a component may come from an unknown
    /// interface.
    pub fn lacks_declarations(&self, component: ComponentId) -> bool {
        let brings = |missing: &Missing| matches!(missing, Missing::Interface { used: false, .. });
        self.gaps_of(component).any(brings)
    }

    /// Returns true if a component, or one of its tasks and services, may throw unknown exceptions.
    pub fn lacks_exceptions(&self, component: ComponentId, owner: Owner) -> bool {
        self.gaps_of(component).any(|gap| match gap {
            Missing::Interface { .. } => true,
            Missing::Exception { owner: None, .. } => true,
            Missing::Exception { owner: Some(of), .. } => {
                let task = match owner {
                    Owner::Service(service) => {
                        self.components[component].services[service].task.map(Owner::Task)
                    }
                    Owner::Task(_) => None,
                };
                *of == owner || Some(*of) == task
            }
            _ => false,
        })
    }

    /// Returns true if a type is declared by a stand-in: it may have any member, and agrees with any type of
    /// a codel.
    pub fn is_open(&self, ty: TypeId) -> bool {
        self.open.binary_search(&ty).is_ok()
    }

    /// The unknown or open type that determines the form of values of a type, if there is one: behind
    /// aliases, and as the element of an array, sequence or optional. Members do not count: a struct has a
    /// name of its own.
    pub fn opaque(&self, ty: TypeId) -> Option<TypeId> {
        let mut seen = FxHashSet::default();
        let mut ty = ty;
        while seen.insert(ty) {
            if self.is_open(ty) {
                return Some(ty);
            }
            match self.ty(ty).kind {
                TypeKind::Typedef { ty: aliased }
                | TypeKind::StructMember { ty: aliased }
                | TypeKind::UnionMember { ty: aliased, .. }
                | TypeKind::ForwardStruct { definition: Some(aliased) }
                | TypeKind::ForwardUnion { definition: Some(aliased) } => ty = aliased,
                TypeKind::Unknown => return Some(ty),
                TypeKind::Array { element, .. }
                | TypeKind::Sequence { element, .. }
                | TypeKind::Optional { element } => ty = element,
                _ => return None,
            }
        }
        None
    }

    /// The unknown interfaces and types that a codel of a component depends on.
    pub fn unknown_dependencies(
        &self,
        component: ComponentId,
        codel: &Codel,
    ) -> UnknownDependencies {
        let mut out = UnknownDependencies::default();
        let add = |all: &mut Vec<Name>, name: &Name| {
            if !all.contains(name) {
                all.push(name.clone());
            }
        };
        for param in &codel.params {
            // A port or remote service is an object of the component, for any data type.
            if matches!(param.source, ParamSource::Port(_) | ParamSource::Remote(_)) {
                continue;
            }
            let Some(ty) = self.opaque(param.ty) else {
                continue;
            };
            let ty = self.ty(ty);
            let is_source = |missing: &Missing| matches!(missing, Missing::Source { name, .. } if ty.name.as_ref() == Some(name));
            let interfaces = self.missing_interfaces(component);
            if param.source == ParamSource::Opaque
                && !interfaces.is_empty()
                && self.gaps_of(component).any(is_source)
            {
                for interface in interfaces {
                    add(&mut out.interfaces, interface);
                }
                continue;
            }
            let own = &self.components[component].name;
            let outermost = ty.scope.first().map(|scope| &scope.name);
            let name = outermost.filter(|name| *name != own).or(ty.name.as_ref());
            if let Some(name) = name {
                add(&mut out.types, name);
            }
        }
        out
    }
}

/// The unknown interfaces and types that the parameters of a codel depend on, each once.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct UnknownDependencies {
    /// Unknown interfaces, one of which must declare the source of a parameter.
    pub interfaces: Vec<Name>,
    /// Unknown modules and types that the type of a parameter depends on: it agrees with any type.
    pub types: Vec<Name>,
}
