//! What a specification lacks because a name in it could not be resolved.
//!
//! A fresh clone has not the packages that it requires: interfaces, types and exceptions that come from there
//! are unknown. What does not depend on them goes on; who draws a conclusion from the absence of something
//! asks here first whether it may be in a gap.

use rustc_hash::FxHashSet;
use serde::{Deserialize, Serialize};

use super::{Codel, Name, Owner, ParamDir, ParamSource, PathElement, Spec, TypeId, TypeKind};

/// One thing that is lacking.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Gap {
    /// Index into [`Spec::components`]; `None` outside of components and interfaces.
    pub component: Option<u32>,
    /// What could not be resolved.
    pub missing: Missing,
}

/// What could not be resolved.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Missing {
    /// An interface, so that anything that it would bring may be missing.
    Interface {
        /// Its name.
        name: Name,
        /// It is only used: no tasks, services and codels of the component come from there.
        used: bool,
    },
    /// The programming language: the component names none, and an interface that is not known may.
    Language,
    /// An exception in a list of exceptions.
    Exception {
        /// Its path as written.
        name: Name,
        /// The task or service that throws it; `None` for the component.
        owner: Option<Owner>,
    },
    /// A type or constant that is named.
    Name {
        /// Its path as written.
        name: Name,
        /// It is used as a constant.
        constant: bool,
    },
    /// Something inside a value of an unknown type, as a parameter names it.
    Member {
        /// Full name of the type.
        of: Name,
        /// The path from there.
        path: Vec<PathElement>,
    },
    /// A port, service or member that a codel names.
    Source {
        /// Its name.
        name: Name,
        /// What it is said to be; `None` if nothing is said.
        kind: Option<SourceKind>,
        /// What the codel does with it.
        dir: ParamDir,
        /// The service whose codel it is, by index.
        service: Option<u32>,
    },
    /// A task that an activity names, which an interface that is not known may have.
    Task {
        /// Its name.
        name: Name,
    },
    /// A service that another one interrupts, or comes before or after, likewise.
    Service {
        /// Its name.
        name: Name,
    },
}

/// What the parameter of a codel may be said to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs, reason = "GenoM3's own words")]
pub enum SourceKind {
    Ids,
    Local,
    Port,
    Remote,
}

impl Spec {
    /// The gaps of a component, those of the interfaces that it imports included.
    pub fn gaps_of(&self, component: u32) -> impl Iterator<Item = &Missing> {
        let it = &self.components[component as usize];
        let lists = [&it.provides, &it.uses, &it.extends];
        self.gaps
            .iter()
            .filter(move |gap| {
                let of = |at: u32| at == component || lists.iter().any(|all| all.contains(&at));
                gap.component.is_some_and(of)
            })
            .map(|gap| &gap.missing)
    }

    /// Interfaces that a component imports and that are not known, each once.
    pub fn missing_interfaces(&self, component: u32) -> Vec<&Name> {
        let mut out = Vec::new();
        for it in self.gaps_of(component) {
            if let Missing::Interface { name, .. } = it
                && !out.contains(&name)
            {
                out.push(name);
            }
        }
        out
    }

    /// Whether tasks, services, codels or properties of a component may come from an interface that is not
    /// known.
    pub fn lacks_declarations(&self, component: u32) -> bool {
        let brings = |it: &Missing| matches!(it, Missing::Interface { used: false, .. });
        self.gaps_of(component).any(brings)
    }

    /// Whether a component, or one of its tasks and services, may throw more than is known.
    pub fn lacks_exceptions(&self, component: u32, owner: Owner) -> bool {
        self.gaps_of(component).any(|it| match it {
            Missing::Interface { .. } => true,
            Missing::Exception { owner: None, .. } => true,
            Missing::Exception {
                owner: Some(it), ..
            } => {
                let task = match owner {
                    Owner::Service(service) => self.components[component as usize].services
                        [service as usize]
                        .task
                        .map(Owner::Task),
                    Owner::Task(_) => None,
                };
                *it == owner || Some(*it) == task
            }
            _ => false,
        })
    }

    /// Whether a stand-in declares a type: it may have any member, and agrees with any type of a codel.
    pub fn is_open(&self, ty: TypeId) -> bool {
        self.open.binary_search(&ty).is_ok()
    }

    /// The unknown or open type that decides how values of a type are written, if there is one: behind
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
                | TypeKind::ForwardStruct {
                    definition: Some(aliased),
                }
                | TypeKind::ForwardUnion {
                    definition: Some(aliased),
                } => ty = aliased,
                TypeKind::Unknown => return Some(ty),
                TypeKind::Array { element, .. }
                | TypeKind::Sequence { element, .. }
                | TypeKind::Optional { element } => ty = element,
                _ => return None,
            }
        }
        None
    }

    /// What a codel of a component waits for.
    pub fn awaited(&self, component: u32, codel: &Codel) -> Awaited {
        let mut out = Awaited::default();
        let add = |all: &mut Vec<Name>, name: &Name| {
            if !all.contains(name) {
                all.push(name.clone());
            }
        };
        for param in &codel.params {
            // A port or remote service is an object of the component, whatever its data.
            if matches!(param.source, ParamSource::Port(_) | ParamSource::Remote(_)) {
                continue;
            }
            let Some(ty) = self.opaque(param.ty) else {
                continue;
            };
            let ty = self.ty(ty);
            let is_source = |it: &Missing| matches!(it, Missing::Source { name, .. } if ty.name.as_ref() == Some(name));
            let interfaces = self.missing_interfaces(component);
            if param.source == ParamSource::Opaque
                && !interfaces.is_empty()
                && self.gaps_of(component).any(is_source)
            {
                interfaces
                    .into_iter()
                    .for_each(|it| add(&mut out.interfaces, it));
                continue;
            }
            let own = &self.components[component as usize].name;
            let outermost = ty.scope.first().map(|it| &it.name);
            let name = outermost.filter(|it| *it != own).or(ty.name.as_ref());
            name.into_iter().for_each(|it| add(&mut out.types, it));
        }
        out
    }
}

/// What the parameters of a codel wait for, each once.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Awaited {
    /// Interfaces that are not known, one of which has to bring what a parameter names.
    pub interfaces: Vec<Name>,
    /// Modules and types that are not known, of which the type of a parameter is: it agrees with any.
    pub types: Vec<Name>,
}
