//! ROS 2 packages with the types of components, for nodes that talk to them.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use dotgen_analysis::model::{Component, ComponentKind, ScopeKind, Spec, Src, TypeKind};
use dotgen_codegen::command::Ros2Packages;

use crate::conversion::conversions;
use crate::description::{Base, FILLER, Field};
use crate::mapping::Mapping;
use crate::names;
use crate::node::offer;
use crate::refusal::Refusal;
use crate::rules::{RuleError, Rules};

/// Packages to build with `colcon`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Interfaces {
    /// The files, by path below the folder of the packages.
    pub files: BTreeMap<String, String>,
    /// Ports, services and types that have no form in ROS 2.
    pub refused: Vec<Refusal>,
}

/// Writes the packages of components: one for each module that the components use. A package has all types of
/// its module, so that components that include the same files have equal packages. The package of a component
/// has only the types that its ports and services use. Ports with a rule need no type of their own.
///
/// # Errors
/// A rule does not fit its component.
pub fn interfaces(
    spec: &Spec,
    components: &[&Component],
    rules: &Rules,
) -> Result<Interfaces, Vec<RuleError>> {
    let mut mapping = Mapping::new(spec);
    let mut refused = Vec::new();
    for component in components {
        let mut conversions = conversions(spec, component, rules)?;
        match offer(&mut mapping, spec, component, &mut conversions) {
            Ok((_, some)) => refused.extend(some),
            Err(error) => refused.push(error),
        }
    }
    types_of_modules(&mut mapping, spec, &mut refused);
    let mut files = BTreeMap::new();
    let packages: Vec<String> = mapping.packages().map(str::to_owned).collect();
    let needs: BTreeMap<&str, BTreeSet<String>> =
        packages.iter().map(|package| (package.as_str(), needs(&mapping, package))).collect();
    for package in &packages {
        if let Some(with) = circle(package, &needs) {
            let src = first_src(&mapping, package);
            refused.push(Refusal {
                part: format!("package `{package}`"),
                why: format!("it and `{with}` need each other: move types to one of the modules"),
                src,
            });
        }
        let of_package = format!("{package}/");
        let mut sources = Vec::new();
        for name in mapping.types.names() {
            if let Some(path) = name.strip_prefix(&of_package)
                && let Some((path, text)) = source(&mapping, name, path)
            {
                sources.push(path.clone());
                files.insert(format!("{package}/{path}"), text);
            }
        }
        for (name, constants) in &mapping.constants {
            if let Some(path) = name.strip_prefix(&of_package) {
                let mut text = heading(&mapping, name);
                for (constant, value) in constants {
                    // The field of the enumeration has the value also without a constant.
                    let _ = if names::is_macro(constant) {
                        writeln!(text, "# {constant}={value}: a macro of C, not a constant")
                    } else {
                        writeln!(text, "uint32 {constant}={value}")
                    };
                }
                let path = format!("{path}.msg");
                sources.push(path.clone());
                files.insert(format!("{package}/{path}"), text);
            }
        }
        if sources.is_empty() {
            continue;
        }
        sources.sort();
        let needs = &needs[package.as_str()];
        files.insert(format!("{package}/package.xml"), manifest(package, needs));
        let build = build(package, &sources, needs);
        files.insert(format!("{package}/CMakeLists.txt"), build);
    }
    Ok(Interfaces { files, refused })
}

/// The packages of all components of a specification, for the template `ros2-interfaces`.
///
/// # Errors
/// A rule does not fit its component.
pub fn packages(spec: &Spec, rules: &Rules) -> Result<Ros2Packages, Vec<RuleError>> {
    let all = spec.components.iter();
    let all: Vec<&Component> =
        all.filter(|component| component.kind == ComponentKind::Component).collect();
    let Interfaces { files, refused } = interfaces(spec, &all, rules)?;
    let refused = refused.iter().map(|refusal| (refusal.src, refusal.to_string()));
    Ok(Ros2Packages { files, refused: refused.collect() })
}

/// Adds all types of the packages in use, except for those of components. Types may need further packages.
fn types_of_modules(mapping: &mut Mapping<'_>, spec: &Spec, refused: &mut Vec<Refusal>) {
    loop {
        let known = mapping.packages().count();
        let mut found = Vec::new();
        add_types(mapping, spec, &mut found);
        if mapping.packages().count() == known {
            refused.extend(found);
            return;
        }
    }
}

fn add_types(mapping: &mut Mapping<'_>, spec: &Spec, refused: &mut Vec<Refusal>) {
    let packages: BTreeSet<String> = mapping.packages().map(str::to_owned).collect();
    for (ty, entry) in spec.types.iter_enumerated() {
        let is_wanted = match &entry.kind {
            TypeKind::Struct { .. } | TypeKind::Union { .. } | TypeKind::Enum { .. } => true,
            TypeKind::Exception { members } => !members.is_empty(),
            _ => false,
        };
        let modules = entry.scope.iter().filter(|scope| scope.kind == ScopeKind::Module);
        let modules: Vec<&str> = modules.map(|module| module.name.as_str()).collect();
        let is_internal = spec.components.iter().any(|component| {
            component.kind == ComponentKind::Component
                && modules.first() == Some(&component.name.as_str())
        });
        let package = names::package(modules);
        if !is_wanted || is_internal || !package.is_ok_and(|package| packages.contains(&package)) {
            continue;
        }
        if let Err(obstacle) = mapping.named(ty) {
            let name = spec.full_name(ty).unwrap_or_default();
            refused.push(Refusal {
                part: format!("type `{name}`"),
                why: obstacle.why,
                src: obstacle.src,
            });
        }
    }
}

/// Path and text of the file of a type, if it has one of its own.
fn source(mapping: &Mapping<'_>, name: &str, path: &str) -> Option<(String, String)> {
    let (folder, local) = path.split_once('/')?;
    if local.contains('_') {
        return None;
    }
    let parts: &[&str] = match folder {
        "msg" => &[""],
        "srv" => &["_Request", "_Response"],
        _ => &["_Goal", "_Result", "_Feedback"],
    };
    let mut text = heading(mapping, name);
    for (index, part) in parts.iter().enumerate() {
        if index > 0 {
            text += "---\n";
        }
        let fields = mapping.types.fields(&format!("{name}{part}"));
        for field in fields.unwrap_or_default() {
            if field.name != FILLER {
                line(field, &mut text);
            }
        }
    }
    Some((format!("{path}.{folder}"), text))
}

/// A comment: the part of the model that a file is for.
fn heading(mapping: &Mapping<'_>, name: &str) -> String {
    let origin = mapping.origin(name).map(|origin| origin.0.plain());
    format!("# GenoM3: {}\n", origin.unwrap_or_default())
}

fn line(field: &Field, out: &mut String) {
    let _ = write!(out, "{} {}", field.ty.text(), field.name);
    if let Some(constants) = &field.constants {
        let _ = write!(out, "  # a constant of {}", constants.replacen("/msg/", "/", 1));
    }
    out.push('\n');
}

/// The packages that a package depends on.
fn needs(mapping: &Mapping<'_>, package: &str) -> BTreeSet<String> {
    let of_package = format!("{package}/");
    let own = || mapping.types.names().filter(|name| name.starts_with(&of_package));
    let fields = own().flat_map(|text| mapping.types.fields(text).unwrap_or_default());
    let nested = fields.filter_map(|field| match &field.ty.base {
        Base::Nested(name) => name.split('/').next(),
        _ => None,
    });
    let mut out: BTreeSet<String> = nested.map(str::to_owned).collect();
    out.remove(package);
    // The build tools add these to services and actions.
    out.remove("service_msgs");
    out.remove("unique_identifier_msgs");
    out.remove("builtin_interfaces");
    if own().any(|text| text.starts_with(&format!("{package}/action/"))) {
        out.insert("action_msgs".to_owned());
    }
    out
}

/// Another package that a package needs and that needs it, also indirectly.
fn circle<'n>(package: &str, needs: &'n BTreeMap<&str, BTreeSet<String>>) -> Option<&'n str> {
    let direct = needs.get(package)?.iter().map(String::as_str);
    direct.into_iter().find(|&start| {
        let mut seen = BTreeSet::new();
        let mut waiting = vec![start];
        while let Some(name) = waiting.pop() {
            if name == package {
                return true;
            }
            if seen.insert(name) {
                waiting.extend(needs.get(name).into_iter().flatten().map(String::as_str));
            }
        }
        false
    })
}

fn first_src(mapping: &Mapping<'_>, package: &str) -> Src {
    let of_package = format!("{package}/");
    let mut names = mapping.types.names().filter(|name| name.starts_with(&of_package));
    names.find_map(|name| mapping.origin(name)).map(|origin| origin.1).unwrap_or_default()
}

fn manifest(package: &str, needs: &BTreeSet<String>) -> String {
    let mut depends = String::new();
    for need in needs {
        let _ = writeln!(depends, "  <depend>{need}</depend>");
    }
    format!(
        "<?xml version=\"1.0\"?>\n<package format=\"3\">\n  <name>{package}</name>\n  \
         <version>0.0.0</version>\n  \
         <description>Types of GenoM3 components, written by dotgen</description>\n  \
         <maintainer email=\"unknown@example.com\">unknown</maintainer>\n  <license>unknown</license>\n  \
         <buildtool_depend>ament_cmake</buildtool_depend>\n  \
         <buildtool_depend>rosidl_default_generators</buildtool_depend>\n{depends}  \
         <exec_depend>rosidl_default_runtime</exec_depend>\n  \
         <member_of_group>rosidl_interface_packages</member_of_group>\n  \
         <export>\n    <build_type>ament_cmake</build_type>\n  </export>\n</package>\n"
    )
}

fn build(package: &str, sources: &[String], needs: &BTreeSet<String>) -> String {
    let mut find = String::new();
    for need in needs {
        let _ = writeln!(find, "find_package({need} REQUIRED)");
    }
    let mut depends = String::new();
    if !needs.is_empty() {
        let needs: Vec<&str> = needs.iter().map(String::as_str).collect();
        depends = format!("  DEPENDENCIES {}\n", needs.join(" "));
    }
    let sources: String = sources.iter().map(|source| format!("  \"{source}\"\n")).collect();
    format!(
        "cmake_minimum_required(VERSION 3.20)\nproject({package})\n\nfind_package(ament_cmake REQUIRED)\n\
         find_package(rosidl_default_generators REQUIRED)\n{find}\n\
         rosidl_generate_interfaces(${{PROJECT_NAME}}\n{sources}{depends})\n\n\
         ament_export_dependencies(rosidl_default_runtime)\nament_package()\n"
    )
}
