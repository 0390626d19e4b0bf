//! The dependencies of a specification: packages, files and names, the place where each was found, and the
//! missing ones.

use std::ops::Range;

use camino::Utf8PathBuf;
use dotgen_syntax::packages;
use serde::Serialize;

use crate::base::{Db, SourceFile};
use crate::model::{ComponentKind, Missing, Name, Spec};
use crate::queries::elaborated;
use crate::source_map::{Locations, UnitLocations, bytes};
use crate::unit::{UnitKey, is_standin, preprocessed, unit_of_root, visits, walk_unit};

pub mod standin;

/// All dependencies of a specification.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Dependencies {
    /// Required packages, in order.
    pub packages: Vec<Package>,
    /// Included files, in order of first inclusion.
    pub includes: Vec<Include>,
    /// Interfaces that components import, in order.
    pub interfaces: Vec<Interface>,
    /// Other names that are not declared, in order.
    pub unknown: Vec<UnknownName>,
}

/// A required package.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Package {
    /// The requirement as written, with its version.
    pub requirement: String,
    /// The property that requires it.
    pub required_by: RequiredBy,
    /// The reason why it is not usable; `None` if it is.
    pub missing: Option<String>,
    /// True if it is not installed and replaced by definitions that come with dotgen.
    pub own: bool,
    /// The packages that install it.
    pub brought_by: Vec<Provider>,
}

/// The property that requires a package.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RequiredBy {
    /// `#pragma require`: the specification cannot be read without the package.
    Specification,
    /// `require` of a component.
    Component(Name),
    /// `codels-require` of a component.
    Codels(Name),
}

/// A package that installs a required one.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Provider {
    /// The required package, by its pkg-config name.
    pub package: String,
    /// The robotpkg package.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robotpkg: Option<String>,
    /// The Debian package.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub debian: Option<String>,
}

/// An included file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Include {
    /// As written.
    pub path: String,
    /// The file that includes it.
    pub by: Utf8PathBuf,
    /// The file found.
    pub found: Option<Utf8PathBuf>,
    /// The searched directories, in order.
    pub searched: Vec<Utf8PathBuf>,
    /// True for a stand-in that dotgen wrote.
    pub stand_in: bool,
    /// Byte offsets of the path as written, in the including file.
    #[serde(skip)]
    pub at: Range<usize>,
}

/// An interface that a component imports.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Interface {
    /// The name of the interface.
    pub name: Name,
    pub component: Name,
    /// The file that declares it.
    pub found: Option<Utf8PathBuf>,
}

/// A name that no file declares.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct UnknownName {
    /// The name, with its scopes as written.
    pub name: Name,
    /// The kind of thing it is used as.
    pub used_as: &'static str,
}

impl Dependencies {
    /// Returns true if nothing is missing.
    pub fn is_complete(&self) -> bool {
        self.packages.iter().all(|package| package.missing.is_none())
            && self.includes.iter().all(|include| include.found.is_some())
            && self.interfaces.iter().all(|interface| interface.found.is_some())
            && self.unknown.is_empty()
    }

    /// Missing packages that the specification itself requires: unknown names may be declared in them.
    pub fn missing_packages(&self) -> impl Iterator<Item = &Package> {
        let wanted = |package: &&Package| package.required_by == RequiredBy::Specification;
        self.packages.iter().filter(wanted).filter(|package| package.missing.is_some())
    }
}

/// The dependencies of the specification of a root.
pub(crate) fn dependencies(db: &dyn Db, root: SourceFile) -> Dependencies {
    let unit = unit_of_root(db, root);
    let spec = &elaborated(db, unit).spec;
    let locations = UnitLocations::new(db, unit);
    Dependencies {
        packages: packages(db, spec),
        includes: includes(db, unit),
        interfaces: interfaces(spec, &locations),
        unknown: unknown(spec),
    }
}

fn packages(db: &dyn Db, spec: &Spec) -> Vec<Package> {
    let mut wanted: Vec<(String, RequiredBy)> = Vec::new();
    for requirement in &spec.pragma_requires {
        wanted.push((requirement.clone(), RequiredBy::Specification));
    }
    let components = spec.components.iter();
    for component in components.filter(|component| component.kind == ComponentKind::Component) {
        let own = component.requires.iter();
        let own = own.filter(|requirement| !spec.pragma_requires.contains(requirement));
        wanted
            .extend(own.map(|text| (text.clone(), RequiredBy::Component(component.name.clone()))));
        let codels = component.codels_requires.iter();
        wanted
            .extend(codels.map(|text| (text.clone(), RequiredBy::Codels(component.name.clone()))));
    }
    wanted.dedup();
    let one = |(requirement, required_by): (String, RequiredBy)| {
        let asked = db.packages(std::slice::from_ref(&requirement));
        let names = packages::names(&requirement).into_iter();
        Package {
            missing: asked.flags(db).as_ref().err().cloned(),
            own: asked.flags(db).as_ref().is_ok_and(|flag| !flag.own.is_empty()),
            brought_by: names.map(provider).collect(),
            requirement,
            required_by,
        }
    };
    wanted.into_iter().map(one).collect()
}

fn provider(name: &str) -> Provider {
    let provider = packages::providers(name);
    Provider { package: name.to_owned(), robotpkg: provider.robotpkg, debian: provider.debian }
}

fn includes(db: &dyn Db, unit: UnitKey<'_>) -> Vec<Include> {
    let mut out: Vec<Include> = Vec::new();
    let all = visits(db, unit).all();
    let walk = walk_unit(db, unit);
    for (number, visit) in all.iter_enumerated() {
        let by = visit.key.file(db).path(db);
        for (ordinal, include) in preprocessed(db, visit.key).includes.iter().enumerate() {
            let Some(request) = &include.request else {
                continue;
            };
            let target = visit.includes.get(ordinal).copied().flatten();
            let found = target.and_then(|target| all.get(target));
            let found = found.map(|target| target.key.file(db).path(db).clone());
            if out
                .iter()
                .any(|include| include.path == request.path.as_str() && include.found == found)
            {
                continue;
            }
            out.push(Include {
                path: request.path.to_string(),
                by: by.clone(),
                searched: walk.places(db, number, ordinal, request),
                at: bytes(include.range),
                stand_in: found.as_ref().is_some_and(|path| is_standin(path)),
                found,
            });
        }
    }
    out
}

fn interfaces(spec: &Spec, locations: &UnitLocations) -> Vec<Interface> {
    let mut out: Vec<Interface> = Vec::new();
    for (index, component) in spec.components.iter_enumerated() {
        if component.kind != ComponentKind::Component {
            continue;
        }
        let lists = [&component.provides, &component.uses, &component.extends];
        for &interface in lists.into_iter().flatten() {
            let interface = &spec.components[interface];
            out.push(Interface {
                name: interface.name.clone(),
                component: component.name.clone(),
                found: locations.locate(interface.src).map(|location| location.path),
            });
        }
        for name in spec.missing_interfaces(index) {
            out.push(Interface {
                name: name.clone(),
                component: component.name.clone(),
                found: None,
            });
        }
    }
    let mut seen: Vec<(Name, Name)> = Vec::new();
    out.retain(|interface| {
        let key = (interface.name.clone(), interface.component.clone());
        let fresh = !seen.contains(&key);
        seen.push(key);
        fresh
    });
    out
}

fn unknown(spec: &Spec) -> Vec<UnknownName> {
    let mut out: Vec<UnknownName> = Vec::new();
    for gap in &spec.gaps {
        let (name, used_as) = match &gap.missing {
            Missing::Name { name, constant: true } => (name, "constant"),
            Missing::Name { name, .. } => (name, "type"),
            Missing::Exception { name, .. } => (name, "exception"),
            _ => continue,
        };
        let name = UnknownName { name: name.clone(), used_as };
        if !out.contains(&name) {
            out.push(name);
        }
    }
    out
}
