//! `dotgen deps`: the dependencies of specifications, where each was found, and how to install missing ones.

use std::io::Write;

use camino::{Utf8Path, Utf8PathBuf};
use clap::{Args, ValueEnum};
use dotgen_analysis::deps::{Dependencies, Include, Package, RequiredBy};
use dotgen_analysis::terminal;
use dotgen_codegen::codels::command::FileChange;
use dotgen_syntax::packages;
use serde::Serialize;
use serde_json::json;

use super::{CommandExit, SpecificationOptions, report, session};
use dotgen_lsp_server::features::codels::standins;
use dotgen_platform::files::vfs;

/// Version of the JSON output.
const VERSION: u32 = 2;

/// List dependencies, where each was found, and how to install missing ones
///
/// Dependencies are packages, included files and interfaces.
///
/// Exit status: 0 if nothing is missing, 1 if something is, 2 if a file cannot be read.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Specifications, and directories to search for .gen files
    #[arg(value_name = "PATH", required = true)]
    paths: Vec<Utf8PathBuf>,

    /// Write stand-ins for missing included files to .dotgen/standins next to each specification
    #[arg(long)]
    stand_ins: bool,

    /// Output format
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,

    #[command(flatten)]
    reading: SpecificationOptions,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Format {
    Text,
    Json,
}

/// The dependencies of one specification.
#[derive(Debug, Serialize)]
struct FileDependencies {
    file: String,
    complete: bool,
    #[serde(flatten)]
    needs: Dependencies,
    /// Stand-ins that were written.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    written: Vec<String>,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    let (files, mut trouble) = session::specifications(&arguments.paths);
    let mut all = Vec::new();
    for session in session::open(files, &arguments.reading)? {
        for file in &session.files {
            let path = &file.path;
            let mut needs = session.ask(path, |analysis| analysis.dependencies(path))?;
            needs.relative_to_here();
            let mut written = Vec::new();
            if arguments.stand_ins && !session::is_standard_input(path) {
                let found = session.ask(path, |analysis| analysis.stand_ins(path))?;
                let changes = standins::changes(path, &found);
                let content = |change: &FileChange| {
                    report::edited(&change.path, change.before.as_deref(), &change.after)
                };
                let contents = changes.iter().map(content).collect();
                trouble.ok_or_report(report::write_files(contents, &session.writable()));
                written = changes.iter().map(|change| session::display(&change.path)).collect();
            }
            all.push(FileDependencies {
                file: session::display(path),
                complete: needs.is_complete(),
                needs,
                written,
            });
        }
    }
    match arguments.format {
        Format::Json => {
            let text = format!("{:#}\n", json!({ "version": VERSION, "specifications": all }));
            std::io::stdout().write_all(dotgen_syntax::encoding::shown(&text).as_bytes())?;
        }
        Format::Text => {
            let mut out = Vec::new();
            all.iter().try_for_each(|dependencies| print(dependencies, &mut out))?;
            let text = String::from_utf8_lossy(&out);
            let text = dotgen_syntax::encoding::shown(&text);
            anstream::stdout().write_all(text.as_bytes())?;
        }
    }
    let complete = all.iter().all(|dependencies| dependencies.complete);
    Ok(trouble.outcome(if complete { CommandExit::Fine } else { CommandExit::Errors }))
}

/// Paths relative to the current directory.
trait Relative {
    fn relative_to_here(&mut self);
}

impl Relative for Dependencies {
    fn relative_to_here(&mut self) {
        let includes = self.includes.iter_mut();
        let includes = includes.flat_map(|include| {
            let found = include.found.iter_mut().chain(&mut include.searched);
            std::iter::once(&mut include.by).chain(found)
        });
        let interfaces = self.interfaces.iter_mut().flat_map(|interface| &mut interface.found);
        for path in includes.chain(interfaces) {
            let shown = session::display(path);
            *path = if shown.is_empty() { "." } else { &shown }.into();
        }
    }
}

fn print(dependencies: &FileDependencies, out: &mut impl Write) -> std::io::Result<()> {
    let needs = &dependencies.needs;
    writeln!(out, "{}", terminal::name(&dependencies.file))?;
    if needs.packages.is_empty() && needs.includes.is_empty() && needs.interfaces.is_empty() {
        writeln!(out, "  needs nothing")?;
    }
    for package in &needs.packages {
        print_package(package, out)?;
    }
    for include in &needs.includes {
        print_include(include, needs, out)?;
    }
    for interface in &needs.interfaces {
        let from = match &interface.found {
            Some(path) => format!("from {}", place(path)),
            None => "MISSING: no file that was found declares it".to_owned(),
        };
        writeln!(
            out,
            "  interface {} (of {}): {from}",
            terminal::text(&interface.name),
            terminal::text(&interface.component)
        )?;
    }
    for name in &needs.unknown {
        writeln!(
            out,
            "  {} {}: MISSING: no file that was found declares it",
            name.used_as,
            terminal::text(&name.name)
        )?;
    }
    for path in &dependencies.written {
        writeln!(out, "  created {}", terminal::name(path))?;
    }
    Ok(())
}

/// Returns a path for display. The interfaces that come with dotgen are in a cache, whose path is not shown.
fn place(path: &Utf8Path) -> String {
    let absolute = camino::absolute_utf8(path).unwrap_or_else(|_| path.to_owned());
    match vfs::include_of_own_interface(&absolute) {
        Some(include) => format!("<own interfaces>/{}", terminal::name(include.as_str())),
        None => terminal::name(path.as_str()).into_owned(),
    }
}

fn print_package(package: &Package, out: &mut impl Write) -> std::io::Result<()> {
    let by = match &package.required_by {
        RequiredBy::Specification => "to be read".to_owned(),
        RequiredBy::Component(name) => format!("to build {name}"),
        RequiredBy::Codels(name) => format!("for the codels of {name}"),
    };
    let requirement = terminal::text(&package.requirement);
    let by = terminal::text(&by);
    match &package.missing {
        None if package.own => writeln!(
            out,
            "  package {requirement} ({by}): not installed; its interfaces come with dotgen"
        ),
        None => writeln!(out, "  package {requirement} ({by}): found"),
        Some(why) => {
            let brings = package.brought_by.iter();
            let brings: Vec<String> =
                brings.map(|provider| packages::advice(&provider.package)).collect();
            let why = terminal::text(why);
            writeln!(out, "  package {requirement} ({by}): MISSING: {why}")?;
            writeln!(out, "    install {}", terminal::text(&brings.join("; ")))
        }
    }
}

fn print_include(
    include: &Include,
    needs: &Dependencies,
    out: &mut impl Write,
) -> std::io::Result<()> {
    let path = terminal::name(&include.path);
    match &include.found {
        Some(found) if include.stand_in => {
            writeln!(out, "  include {path}: STAND-IN {}", terminal::name(found.as_str()))
        }
        Some(found) => writeln!(out, "  include {path}: {}", place(found)),
        None => {
            let packages = needs.missing_packages().flat_map(|package| &package.brought_by);
            let packages: Vec<&str> = packages.map(|package| package.package.as_str()).collect();
            let advice = match packages.as_slice() {
                [] => "add its directory with -I, or install the package that has it".to_owned(),
                [one] => format!("most likely it comes with {one}"),
                several => format!("most likely it comes with one of {}", several.join(", ")),
            };
            let by = terminal::name(include.by.as_str());
            writeln!(out, "  include {path} (of {by}): MISSING: {}", terminal::text(&advice))?;
            let places: Vec<&str> = include.searched.iter().map(|path| path.as_str()).collect();
            let places = match places.as_slice() {
                [] => "nowhere: no directory is searched for `<>`".to_owned(),
                places => places.join(", "),
            };
            writeln!(out, "    looked in {}", terminal::text(&places))
        }
    }
}
