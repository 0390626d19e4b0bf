//! Stand-ins for files that are not found: the minimal declarations that make the names used by a
//! specification resolve, in the way they are used.
//!
//! A stand-in states in its text that it is not the real file. It is outside of the sources, in the folder
//! that every unit of the directory searches last (`.dotgen/standins`); the real file takes precedence as
//! soon as it is installed.

use std::fmt::Write as _;
use std::ops::Range;

use camino::{Utf8Path, Utf8PathBuf};

use super::{Dependencies, Include, UnknownName};
use crate::model::{
    Gap, Missing, Name, Param, ParamDir, PathElement, Service, ServiceKind, SourceKind, Spec,
    TypeKind,
};
use crate::unit::STANDINS;

/// The first words of every stand-in.
const MARK: &str = "/* Stand-in written by dotgen";

/// A file to write.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StandIn {
    /// The include it is for, as written.
    pub include: String,
    /// The file that includes it.
    pub by: Utf8PathBuf,
    /// Byte offsets of the include in that file.
    pub at: Range<usize>,
    /// The path to write it to.
    pub path: Utf8PathBuf,
    pub text: String,
}

/// The folder of the stand-ins of a specification.
pub fn folder(specification: &Utf8Path) -> Utf8PathBuf {
    let beside = specification.parent().unwrap_or(Utf8Path::new(""));
    beside.join(STANDINS)
}

/// Stand-ins for all included files that are not found. Each name goes to the file with the most similar
/// path, the others to the first one.
pub fn stand_ins(root: &Utf8Path, needs: &Dependencies, spec: &Spec) -> Vec<StandIn> {
    let missing = needs.includes.iter().filter(|include| include.found.is_none());
    let mut trees = Trees(missing.map(|include| (include, Module::default())).collect());
    if trees.0.is_empty() {
        return Vec::new();
    }
    for interface in needs.interfaces.iter().filter(|interface| interface.found.is_none()) {
        trees.interface(&interface.name);
    }
    for name in &needs.unknown {
        trees.declare(name);
    }
    for gap in &spec.gaps {
        trees.fill(spec, gap);
    }
    let folder = folder(root);
    let files = trees.0.iter().filter_map(|(include, tree)| {
        let below = Utf8Path::new(&include.path);
        let climbs = below.components().any(|component| {
            !matches!(component, camino::Utf8Component::Normal(_) | camino::Utf8Component::CurDir)
        });
        (!climbs).then(|| StandIn {
            include: include.path.clone(),
            by: include.by.clone(),
            at: include.at.clone(),
            path: folder.join(below),
            text: file(&include.path, tree),
        })
    });
    files.collect()
}

/// The declarations of each file that is not found; there is at least one.
struct Trees<'n>(Vec<(&'n Include, Module)>);

impl Trees<'_> {
    /// The file of a name.
    fn home(&mut self, name: &str) -> &mut Module {
        let likely = self.0.iter().enumerate();
        let best = likely
            .filter_map(|(index, (include, _))| Some((likeness(name, &include.path)?, index)))
            .max_by_key(|(likeness, index)| (*likeness, usize::MAX - index));
        &mut self.0[best.map_or(0, |(_, index)| index)].1
    }

    /// The interface of a name, in its file.
    fn interface(&mut self, name: &str) -> &mut Module {
        self.home(name).interface(name)
    }

    /// Declares a name in its file, as what it is used as.
    fn declare(&mut self, name: &UnknownName) {
        let path: Vec<&str> = name.name.split("::").filter(|part| !part.is_empty()).collect();
        let Some((last, scopes)) = path.split_last() else {
            return;
        };
        let declared = match name.used_as {
            "constant" => StandInDeclaration::Constant,
            "exception" => StandInDeclaration::Exception,
            _ => StandInDeclaration::Type(Vec::new()),
        };
        self.home(&name.name).within(scopes).declare(last, declared);
    }

    /// Declares what a gap of the model lacks.
    fn fill(&mut self, spec: &Spec, gap: &Gap) {
        match &gap.missing {
            Missing::Member { of, path } => {
                let names: Vec<&str> = of.split("::").filter(|part| !part.is_empty()).collect();
                if let Some((last, scopes)) = names.split_last() {
                    self.home(of).within(scopes).member(last, path);
                }
            }
            Missing::Source {
                name, kind: Some(SourceKind::Local), service: Some(service), ..
            } => {
                let service = gap.component.and_then(|component| {
                    let services = &spec.components[component].services;
                    services.get(*service)
                });
                let params = service.and_then(|service| params(spec, service));
                if let (Some(service), Some(params), Some(interface)) =
                    (service, params, unknown_interface(spec, gap, false))
                {
                    self.interface(interface).local(service, params, name);
                }
            }
            Missing::Source { name, kind, dir, .. } => {
                let provided =
                    unknown_interface(spec, gap, false).map(|interface| (interface, false));
                let used = unknown_interface(spec, gap, true).map(|interface| (interface, true));
                // Remote services are derived from the used interfaces.
                let from = match kind {
                    Some(SourceKind::Remote) => used.or(provided),
                    _ => first_of(spec, gap),
                };
                if let Some((interface, used)) = from {
                    self.interface(interface).source(name, *kind, *dir, used);
                }
            }
            Missing::Task { name } | Missing::Service { name } => {
                if let Some(interface) = unknown_interface(spec, gap, false) {
                    let module = self.interface(interface);
                    let list = match gap.missing {
                        Missing::Task { .. } => &mut module.tasks,
                        _ => &mut module.services,
                    };
                    if !list.contains(name) {
                        list.push(name.clone());
                    }
                }
            }
            _ => {}
        }
    }
}

/// The first unknown interface among those that a component imports, and true if the component only uses it.
fn first_of<'s>(spec: &'s Spec, gap: &Gap) -> Option<(&'s Name, bool)> {
    imports(spec, gap).next()
}

/// The first unknown interface among those that a component uses if `used`, otherwise among those that it
/// provides or extends.
fn unknown_interface<'s>(spec: &'s Spec, gap: &Gap, used: bool) -> Option<&'s Name> {
    imports(spec, gap).find(|import| import.1 == used).map(|(name, _)| name)
}

fn imports<'s>(spec: &'s Spec, gap: &Gap) -> impl Iterator<Item = (&'s Name, bool)> {
    let component = gap.component;
    let of = spec.gaps.iter().filter(move |gap| gap.component.is_some());
    of.filter_map(move |gap| match &gap.missing {
        Missing::Interface { name, used } if gap.component == component => Some((name, *used)),
        _ => None,
    })
}

/// The parameters of a service as a stand-in can declare them: a repeated declaration must have the same
/// parameters. `None` if one has a type that the stand-in cannot name.
fn params(spec: &Spec, service: &Service) -> Option<Vec<String>> {
    let declared = service.params.iter().filter(|param| param.dir != ParamDir::Local);
    let one = |param: &Param| {
        let ty = spec.ty(param.ty);
        let named = match ty.kind {
            TypeKind::Unknown => spec.full_name(param.ty)?,
            TypeKind::Boolean
            | TypeKind::Octet
            | TypeKind::Char
            | TypeKind::Short
            | TypeKind::UnsignedShort
            | TypeKind::Long
            | TypeKind::UnsignedLong
            | TypeKind::LongLong
            | TypeKind::UnsignedLongLong
            | TypeKind::Float
            | TypeKind::Double
            | TypeKind::String { bound: None }
                if ty.name.is_none() =>
            {
                ty.kind.word().to_owned()
            }
            _ => return None,
        };
        let dir = param.dir.word();
        Some(format!("{dir} {named} {}", param.name))
    };
    declared.map(one).collect()
}

/// The similarity of a name to a file path: the number of words of the path in the name; `None` unless it
/// contains the last word.
fn likeness(name: &str, path: &str) -> Option<usize> {
    let path = Utf8Path::new(path);
    let stem = path.file_stem()?;
    let flat = name.replace("::", "_");
    let flat = format!("_{flat}_");
    if !flat.contains(&format!("_{stem}_")) {
        return None;
    }
    let words = path.with_extension("");
    let words = words.components().filter(|component| flat.contains(&format!("_{component}_")));
    Some(words.count() + stem.len())
}

fn file(include: &str, tree: &Module) -> String {
    let guard: String =
        include
            .chars()
            .map(|character| {
                if character.is_ascii_alphanumeric() { character.to_ascii_uppercase() } else { '_' }
            })
            .collect();
    let mut out = format!(
        "{MARK} for `{include}`, which was not found.\n \
         * It has what the specification uses of it, with types that are made up. Nothing that is generated from it fits\n \
         * the real one. Install the package that has the real file; `dotgen deps` says which. */\n\
         #ifndef STANDIN_{guard}\n#define STANDIN_{guard}\n\n"
    );
    tree.write(&mut out, 0);
    out += "\n#endif\n";
    out
}

/// The kind of declaration for a name.
#[derive(Debug, Clone, PartialEq, Eq)]
enum StandInDeclaration {
    /// A struct with these members.
    Type(Vec<(Name, Vec<Vec<PathElement>>)>),
    Constant,
    Exception,
}

/// The declarations of a module, an interface or a file.
#[derive(Debug, Default)]
struct Module {
    modules: Vec<(String, Module)>,
    declared: Vec<(String, StandInDeclaration)>,
    /// Set for an interface, with its ports, services and ids members.
    interface: Option<Vec<(Name, SourceKind, bool)>>,
    /// Tasks that activities name.
    tasks: Vec<Name>,
    /// Services that others name in their lists.
    services: Vec<Name>,
    /// Services whose local variables codels name.
    declared_again: Vec<RedeclaredService>,
}

/// A service of an interface that a component declares again.
#[derive(Debug)]
struct RedeclaredService {
    name: Name,
    kind: ServiceKind,
    params: Vec<String>,
    locals: Vec<Name>,
}

impl Module {
    fn module(&mut self, name: &str) -> &mut Module {
        let at = if let Some(at) = self.modules.iter().position(|module| module.0 == name) {
            at
        } else {
            self.modules.push((name.to_owned(), Module::default()));
            self.modules.len() - 1
        };
        &mut self.modules[at].1
    }

    fn within(&mut self, scopes: &[&str]) -> &mut Module {
        scopes.iter().fold(self, |module, scope| module.module(scope))
    }

    fn interface(&mut self, name: &str) -> &mut Module {
        let module = self.module(name);
        module.interface.get_or_insert_with(Vec::new);
        module
    }

    fn declare(&mut self, name: &str, declared: StandInDeclaration) {
        if !self.declared.iter().any(|entry| entry.0 == name) {
            self.declared.push((name.to_owned(), declared));
        }
    }

    /// Adds a member of a type, and the members below it.
    fn member(&mut self, ty: &str, path: &[PathElement]) {
        self.declare(ty, StandInDeclaration::Type(Vec::new()));
        let found = self.declared.iter_mut().find(|entry| entry.0 == ty);
        let (Some((_, StandInDeclaration::Type(members))), Some((PathElement::Member(name), rest))) =
            (found, path.split_first())
        else {
            return;
        };
        match members.iter_mut().find(|member| member.0 == *name) {
            Some((_, known)) => known.push(rest.to_vec()),
            None => members.push((name.clone(), vec![rest.to_vec()])),
        }
    }

    /// Adds a port, service or ids member of an interface. With `used`, ports have the opposite direction in
    /// the interface.
    fn source(&mut self, name: &Name, kind: Option<SourceKind>, dir: ParamDir, used: bool) {
        let Some(sources) = &mut self.interface else {
            return;
        };
        let kind = kind.unwrap_or(SourceKind::Port);
        let out = (dir != ParamDir::In) != used;
        if kind != SourceKind::Local && !sources.iter().any(|source| source.0 == *name) {
            sources.push((name.clone(), kind, out));
        }
    }

    /// Adds a local variable of a service.
    fn local(&mut self, service: &Service, params: Vec<String>, name: &Name) {
        let all = &mut self.declared_again;
        let at = if let Some(at) = all.iter().position(|other| other.name == service.name) {
            at
        } else {
            all.push(RedeclaredService {
                name: service.name.clone(),
                kind: service.kind,
                params,
                locals: Vec::new(),
            });
            all.len() - 1
        };
        if !all[at].locals.contains(name) {
            all[at].locals.push(name.clone());
        }
    }

    fn write(&self, out: &mut String, depth: usize) {
        let indent = "  ".repeat(depth);
        // Exceptions and types come first: interfaces of the same file may use them.
        for (name, declared) in &self.declared {
            match declared {
                StandInDeclaration::Constant => {
                    let _ = writeln!(out, "{indent}const unsigned long {name} = 1;");
                }
                StandInDeclaration::Exception => {
                    let _ = writeln!(out, "{indent}exception {name} {{}};");
                }
                StandInDeclaration::Type(members) => write_struct(out, name, members, depth),
            }
        }
        for (name, module) in &self.modules {
            let word = match module.interface {
                Some(_) => "interface",
                None => "module",
            };
            let _ = writeln!(out, "{indent}{word} {name} {{");
            module.write_sources(out, depth + 1);
            module.write(out, depth + 1);
            let _ = writeln!(out, "{indent}}};");
        }
    }

    fn write_sources(&self, out: &mut String, depth: usize) {
        let indent = "  ".repeat(depth);
        for name in &self.tasks {
            let _ = writeln!(out, "{indent}task {name} {{}};");
        }
        let again = |name: &Name| self.declared_again.iter().any(|service| service.name == *name);
        for name in self.services.iter().filter(|service| !again(service)) {
            let _ = writeln!(out, "{indent}function {name}() {{}};");
        }
        let mut typed: Vec<&Name> = Vec::new();
        for service in &self.declared_again {
            for local in &service.locals {
                if !typed.contains(&local) {
                    let _ = writeln!(out, "{indent}struct {local}_data {{ octet opaque; }};");
                    typed.push(local);
                }
            }
            let word = match service.kind {
                ServiceKind::Function => "function",
                ServiceKind::Activity => "activity",
                // Attributes have no local variables.
                ServiceKind::Attribute => continue,
            };
            let (name, params) = (&service.name, service.params.join(", "));
            let _ = writeln!(out, "{indent}{word} {name}({params}) {{");
            for local in &service.locals {
                let _ = writeln!(out, "{indent}  local {local}_data {local};");
            }
            let _ = writeln!(out, "{indent}}};");
        }
        for (name, kind, is_out) in self.interface.iter().flatten() {
            let _ = match kind {
                SourceKind::Remote => writeln!(out, "{indent}function {name}() {{}};"),
                SourceKind::Ids => writeln!(out, "{indent}ids {{ octet {name}; }};"),
                SourceKind::Port | SourceKind::Local => {
                    let dir = if *is_out { "out" } else { "in" };
                    writeln!(
                        out,
                        "{indent}struct {name}_data {{ octet opaque; }};\n\
                         {indent}port {dir} {name}_data {name};"
                    )
                }
            };
        }
    }
}

fn write_struct(
    out: &mut String,
    name: &str,
    members: &[(Name, Vec<Vec<PathElement>>)],
    depth: usize,
) {
    let indent = "  ".repeat(depth);
    let _ = writeln!(out, "{indent}struct {name} {{");
    if members.is_empty() {
        let _ = writeln!(out, "{indent}  octet opaque;");
    }
    for (member, paths) in members {
        write_member(out, member, paths, depth + 1);
    }
    let _ = writeln!(out, "{indent}}};");
}

/// Writes a member, with the type that the paths below it need.
fn write_member(out: &mut String, name: &str, paths: &[Vec<PathElement>], depth: usize) {
    let indent = "  ".repeat(depth);
    let mut inner: Vec<(Name, Vec<Vec<PathElement>>)> = Vec::new();
    let mut dimensions = 0;
    for path in paths {
        let indexes = path.iter().take_while(|element| matches!(element, PathElement::Index(_)));
        let indexes = indexes.count();
        dimensions = dimensions.max(indexes);
        if let Some((PathElement::Member(member), rest)) = path[indexes..].split_first() {
            match inner.iter_mut().find(|entry| entry.0 == *member) {
                Some((_, known)) => known.push(rest.to_vec()),
                None => inner.push((member.clone(), vec![rest.to_vec()])),
            }
        }
    }
    let suffix = "[64]".repeat(dimensions);
    if inner.is_empty() {
        let _ = writeln!(out, "{indent}double {name}{suffix};");
        return;
    }
    let _ = writeln!(out, "{indent}struct {name}_t {{");
    for (member, paths) in &inner {
        write_member(out, member, paths, depth + 1);
    }
    let _ = writeln!(out, "{indent}}} {name}{suffix};");
}
