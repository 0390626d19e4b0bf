//! Templates without Tcl: MiniJinja texts over the JSON model, described by a `template.toml`.
//!
//! Some are included in dotgen. Any folder with a `template.toml` on the search path is one too. See
//! docs/templates.md for the format.

mod arguments;
mod expand;
mod json_schema;
mod manifest;
mod mappings;
mod python;
mod render;
mod ros2_interfaces;

use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use crate::compiler::Compiler;
use crate::disk::Disk;
use crate::environment::Environment;
use crate::options::Options;
use crate::template::{Confinement, Confirmation, Output, OutputSink, readable_files};

pub use expand::serve as serve_renderer;
pub use manifest::{FileRule, Manifest, RunScope};

/// A template included in dotgen.
struct Embedded {
    name: &'static str,
    files: &'static [(&'static str, &'static str)],
}

macro_rules! embedded {
    ($name:literal: $($file:literal),+ $(,)?) => {
        Embedded {
            name: $name,
            files: &[$(($file, include_str!(concat!("../templates/", $name, "/", $file)))),+],
        }
    };
}

const EMBEDDED: &[Embedded] = &[
    embedded!("docs": "template.toml", "component.jinja"),
    embedded!("docs-asciidoc": "template.toml", "component.jinja", "picture.jinja"),
    embedded!("json-schema": "template.toml", "schema.jinja"),
    embedded!("python": "template.toml", "stub.jinja"),
    embedded!("stubs": "template.toml", "codels.jinja"),
    embedded!(
        "skeleton": "template.toml", "codels.jinja", "component.pc.jinja",
        "component-uninstalled.pc.jinja", "readme.jinja", "bootstrap.jinja",
        "ag_templates.jinja", "configure.jinja", "top.jinja", "makefile.jinja",
    ),
];

/// Files that templates read from the built-in folder.
pub const SUPPORT: &[(&str, &str)] = &[
    ("common/genom.gen", include_str!("../templates/common/genom.gen")),
    ("common/json-types.h", include_str!("../templates/common/json-types.h")),
];

/// The location of a template's texts.
pub(crate) enum Texts {
    /// In the program.
    Embedded(&'static [(&'static str, &'static str)]),
    /// In a folder.
    Folder(PathBuf),
}

impl Texts {
    fn manifest(&self, disk: &dyn Disk) -> Result<Manifest, String> {
        toml::from_str(&self.read(disk, "template.toml")?)
            .map_err(|error| format!("template.toml: {}", error.message()))
    }

    /// A text. The text of a folder must be in that folder, also after following links: a template may not be
    /// trusted, and its output shows what it reads.
    fn read(&self, disk: &dyn Disk, name: &str) -> Result<String, String> {
        match self {
            Texts::Embedded(files) => files
                .iter()
                .find(|(file, _)| *file == name)
                .map(|(_, text)| (*text).to_owned())
                .ok_or_else(|| format!("no text {name}")),
            Texts::Folder(dir) => {
                let path = dir.join(name);
                let plain = Path::new(name)
                    .components()
                    .all(|component| matches!(component, Component::Normal(_)));
                if !plain || !readable_files::is_below(disk, &path, std::slice::from_ref(dir)) {
                    return Err(format!("{name} is not in the folder of the template"));
                }
                disk.read(&path)
                    .and_then(|bytes| String::from_utf8(bytes).map_err(std::io::Error::other))
                    .map_err(|error| format!("cannot read {}: {error}", path.display()))
            }
        }
    }
}

/// Names of the templates included in dotgen, sorted.
pub fn names() -> Vec<&'static str> {
    let mut names: Vec<&str> = EMBEDDED.iter().map(|embedded| embedded.name).collect();
    names.extend(["mappings", ros2_interfaces::NAME]);
    names.sort_unstable();
    names
}

/// The description of a template of dotgen.
pub(crate) fn about(disk: &dyn Disk, name: &str) -> String {
    match name {
        "mappings" => return mappings::ABOUT.to_owned(),
        ros2_interfaces::NAME => return ros2_interfaces::ABOUT.to_owned(),
        _ => {}
    }
    let found = EMBEDDED.iter().find(|embedded| embedded.name == name);
    let manifest = found.and_then(|embedded| Texts::Embedded(embedded.files).manifest(disk).ok());
    manifest.map(|manifest| manifest.about).unwrap_or_default()
}

/// The description of the template in a folder.
pub(crate) fn about_folder(disk: &dyn Disk, dir: &Path) -> Option<String> {
    let manifest = Texts::Folder(dir.to_owned()).manifest(disk);
    manifest.ok().map(|manifest| manifest.about)
}

/// Runs a template of dotgen; `None` if there is no template of that name.
pub(crate) fn run(
    name: &str,
    args: &[String],
    options: &Options,
    compiler: &mut Compiler,
    env: &mut Environment<'_>,
) -> Option<i32> {
    let result = if name == "mappings" {
        mappings::run(args, options, compiler, env)
    } else if name == ros2_interfaces::NAME {
        ros2_interfaces::run(args, options, compiler, env)
    } else {
        let found = EMBEDDED.iter().find(|embedded| embedded.name == name)?;
        render::run(name, &Texts::Embedded(found.files), args, options, compiler, env)
    };
    Some(finish(name, result, env))
}

/// Runs a template with its output, as one of dotgen, and writes the files if the status is 0.
fn with_output(
    name: &str,
    options: &Options,
    env: &mut Environment<'_>,
    run: impl FnOnce(&mut Environment<'_>, &mut Output) -> Result<i32, String>,
) -> Result<i32, String> {
    let sink = std::mem::replace(&mut env.sink, OutputSink::DIRECT);
    let disk = Arc::clone(&env.disk);
    let mut output = Output::new(name.to_owned(), env.base.clone(), options.debug, disk, sink);
    // Hidden and executable results of templates of dotgen are allowed.
    output.confined = env
        .confined
        .clone()
        .map(|confined| Confinement { confirmed: Confirmation::All, ..confined });
    let result = run(env, &mut output);
    let (sink, written) = output.finish(!matches!(result, Ok(0)));
    env.sink = sink;
    written.map_err(|error| error.to_string()).and(result)
}

/// Runs the template of a folder.
pub(crate) fn run_folder(
    dir: &Path,
    args: &[String],
    options: &Options,
    compiler: &mut Compiler,
    env: &mut Environment<'_>,
) -> i32 {
    let name = dir.file_name().unwrap_or_default().to_string_lossy();
    let texts = Texts::Folder(dir.to_owned());
    let result = render::run(&name, &texts, args, options, compiler, env);
    if let Err(message) = &result {
        env.failed_at = crate::template::place(&*env.disk, dir, message, "");
    }
    finish(&name, result, env)
}

fn finish(name: &str, result: Result<i32, String>, env: &mut Environment<'_>) -> i32 {
    result.unwrap_or_else(|message| {
        env.console.err(&format!("{name}: {message}"));
        2
    })
}
