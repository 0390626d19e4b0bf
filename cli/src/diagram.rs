//! `dotgen diagram`

use std::io::Write;

use anyhow::bail;
use camino::{Utf8Path, Utf8PathBuf};
use clap::{Args, ValueEnum};
use dotgen_codegen::disk::NewContent;
use dotgen_diagram::render::png::png;
use dotgen_diagram::theme::Theme;
use dotgen_syntax::encoding;
use serde_json::json;

use super::{CommandExit, SpecificationOptions, report, session};
use dotgen_views::pictures::{self, Form, Kind, Picture, PictureRequest, SystemContext};

/// Draw state machines, components and locks
///
/// `fsm` draws the state machine of a task or activity, `system` the components with their ports, `locks` the
/// codels that exclude each other. Several pictures go into the directory OUT; without OUT, text formats are
/// printed one after the other. The same input gives the same bytes.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Kind of picture
    kind: Kind,

    /// Specifications, directories to search for .gen files, or - for standard input
    #[arg(value_name = "FILE", required = true)]
    files: Vec<Utf8PathBuf>,

    /// Draw only this component
    #[arg(long, value_name = "NAME")]
    component: Option<String>,

    /// Draw only this activity
    #[arg(long, value_name = "NAME", conflicts_with = "task")]
    service: Option<String>,

    /// Draw only the permanent activity of this task
    #[arg(long, value_name = "NAME")]
    task: Option<String>,

    /// File format [default: by the extension of OUT, else svg]
    #[arg(long, value_enum)]
    format: Option<Format>,

    /// Colours of SVG and PNG
    #[arg(long, value_enum, default_value_t = Colours::Auto)]
    theme: Colours,

    /// Add the longest time from each state to the next pause
    #[arg(long)]
    paths: bool,

    /// Show how many codels each codel excludes; in a system, which components take turns at a port
    #[arg(long)]
    locks: bool,

    /// Mark the longest path through these states of a machine, with its execution time
    #[arg(long, value_name = "STATE,…", value_delimiter = ',')]
    way: Vec<String>,

    /// In a system, show all details of this component
    #[arg(long, value_name = "COMPONENT")]
    open: Vec<String>,

    /// Leave out execution times
    #[arg(long)]
    no_wcet: bool,

    /// In a system, show which services interrupt which
    #[arg(long)]
    interrupts: bool,

    /// In a system, the width of the picture in pixels, for letters of at least 9 pixels: a wider system is
    /// drawn in rows, if it fits
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(100..))]
    width: Option<u32>,

    /// In a system, list at most N services per component
    #[arg(long, value_name = "N", default_value_t = 6)]
    services: usize,

    /// File to write, or directory for several pictures [default: standard output]
    #[arg(short, long, value_name = "OUT")]
    output: Option<Utf8PathBuf>,

    #[command(flatten)]
    reading: SpecificationOptions,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    Svg,
    Png,
    Dot,
    Mermaid,
    Json,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Colours {
    /// Light, or dark if the viewer prefers dark
    Auto,
    Light,
    Dark,
    /// The colours of a VS Code webview
    Editor,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    let format = format(arguments)?;
    let mut units = Vec::new();
    let mut connections = Vec::new();
    let mut outcome = CommandExit::Fine;
    let (files, mut trouble) = session::specifications(&arguments.files);
    if files.is_empty() {
        return Ok(trouble.outcome(outcome));
    }
    for session in session::open(files, &arguments.reading)? {
        for file in &session.files {
            let unit = session.ask(&file.path, |analysis| analysis.root_unit(&file.path));
            let Some(unit) = trouble.ok_or_report(unit) else {
                continue;
            };
            if !unit.accepted() {
                let mut texts = session::Texts::default();
                session.add_texts(&unit.diagnostics, &mut texts)?;
                report::text::print_errors(&unit.diagnostics, &texts)?;
                outcome = CommandExit::Errors;
            }
            units.push(unit);
        }
        connections.extend_from_slice(session.connections());
    }
    let wish = request(arguments);
    let around = SystemContext { connections, ..SystemContext::default() };
    let drawn = pictures::draw(&units, &around, &wish);
    if drawn.is_empty() {
        bail!("{}", nothing(&wish));
    }
    if format == Format::Json {
        let all = drawn.iter().map(|picture| as_json(&units, picture));
        let mut text = serde_json::to_string_pretty(&all.collect::<Vec<_>>())?;
        text.push('\n');
        let text = encoding::shown(&text).into_owned().into_bytes();
        write(vec![(arguments.output.clone(), text)])?;
        return Ok(trouble.outcome(outcome));
    }
    write(pictures_as_files(arguments, format, &drawn)?)?;
    Ok(trouble.outcome(outcome))
}

/// Returns the pictures that the arguments ask for.
fn request(arguments: &Arguments) -> PictureRequest {
    let opened = arguments.open.iter().map(|text| (text.clone(), true));
    PictureRequest {
        kind: arguments.kind,
        component: arguments.component.clone(),
        owner: arguments.service.clone().or(arguments.task.clone()),
        wcet: !arguments.no_wcet,
        paths: arguments.paths,
        locks: arguments.locks,
        services: arguments.services,
        interrupts: arguments.interrupts,
        load: !arguments.no_wcet,
        way: arguments.way.clone(),
        opened: opened.collect(),
        width: arguments.width,
        ..PictureRequest::default()
    }
}

/// Returns the bytes of each picture, with its file; without one, it goes to standard output.
///
/// # Errors
/// There are several pictures for one file.
fn pictures_as_files(
    arguments: &Arguments,
    format: Format,
    drawn: &[Picture],
) -> anyhow::Result<Vec<(Option<Utf8PathBuf>, Vec<u8>)>> {
    let count = drawn.len();
    let directory = match &arguments.output {
        Some(output) if count > 1 => {
            if output.is_file() || by_name(output).is_some() {
                bail!(
                    "there are {count} pictures, and `{output}` is one file; name one picture with --service or \
                     --task, or a directory with -o"
                );
            }
            Some(output)
        }
        _ => None,
    };
    if count > 1 && directory.is_none() && format == Format::Png {
        bail!(
            "there are {count} pictures; name one with --service or --task, or a directory with -o"
        );
    }
    let files = drawn.iter().map(|picture| {
        let output = match directory {
            Some(directory) => Some(directory.join(file_name(picture, format))),
            None => arguments.output.clone(),
        };
        Ok((output, bytes(picture, format, arguments.theme)?))
    });
    files.collect()
}

/// Returns the requested format, or that of the file's name. Both have to agree.
fn format(arguments: &Arguments) -> anyhow::Result<Format> {
    let file = arguments.output.as_deref().filter(|output| !output.is_dir());
    let named = file.and_then(by_name);
    if let (None, None, Some(file)) = (arguments.format, named, file)
        && let Some(unknown) = file.extension()
    {
        bail!(
            "`{file}`: there is no picture format `{unknown}`; name the file .svg, .png, .dot, .mmd or .json, \
             or choose a format with --format"
        );
    }
    match (arguments.format, named, &arguments.output) {
        (Some(asked), Some(named), Some(output)) if asked != named => bail!(
            "`{output}` is the name of a {} file, and --format asks for {}; leave one of them out",
            extension(named),
            extension(asked)
        ),
        (asked, named, _) => Ok(asked.or(named).unwrap_or(Format::Svg)),
    }
}

/// Returns the format of a file by its extension.
fn by_name(path: &Utf8Path) -> Option<Format> {
    match path.extension()?.to_ascii_lowercase().as_str() {
        "svg" => Some(Format::Svg),
        "png" => Some(Format::Png),
        "dot" | "gv" => Some(Format::Dot),
        "mmd" | "mermaid" => Some(Format::Mermaid),
        "json" => Some(Format::Json),
        _ => None,
    }
}

fn extension(format: Format) -> &'static str {
    match format {
        Format::Svg => "svg",
        Format::Png => "png",
        Format::Dot => "dot",
        Format::Mermaid => "mmd",
        Format::Json => "json",
    }
}

fn nothing(wish: &PictureRequest) -> String {
    let what = match (wish.kind, &wish.owner) {
        (Kind::Fsm, Some(owner)) => format!("no task or activity `{owner}` with a state machine"),
        (Kind::Fsm, None) => "no task or activity with a state machine".to_owned(),
        (_, Some(owner)) => format!("no task or service `{owner}`"),
        _ => "no component".to_owned(),
    };
    match &wish.component {
        Some(component) => format!("there is {what} in a component `{component}`"),
        None => format!("there is {what} in these files"),
    }
}

fn bytes(picture: &Picture, format: Format, theme: Colours) -> anyhow::Result<Vec<u8>> {
    let theme = match theme {
        Colours::Auto => Theme::Auto,
        Colours::Light => Theme::Light,
        Colours::Dark => Theme::Dark,
        Colours::Editor => Theme::Editor,
    };
    let form = match format {
        Format::Png => {
            return png(&picture.graph, &picture.layout, theme).map_err(anyhow::Error::msg);
        }
        Format::Dot => Form::Dot,
        Format::Mermaid => Form::Mermaid,
        Format::Svg | Format::Json => Form::Svg,
    };
    Ok(encoding::shown(&picture.text(form, theme)).into_owned().into_bytes())
}

fn file_name(picture: &Picture, format: Format) -> String {
    let extension = extension(format);
    let names = [&picture.component, &picture.owner];
    let names: Vec<&str> = names.into_iter().flatten().map(String::as_str).collect();
    format!("{}.{extension}", names.join("."))
}

fn as_json(units: &[dotgen_analysis::host::UnitResult], picture: &Picture) -> serde_json::Value {
    let (nodes, edges) = pictures::data(units, picture, &|location| {
        Some(json!({
            "file": session::display(&location.path),
            "line": location.start.line + 1,
            "column": location.start.col + 1,
        }))
    });
    json!({
        "version": 1,
        "title": picture.graph.title,
        "component": picture.component,
        "owner": picture.owner,
        "notes": picture.graph.notes,
        "nodes": nodes,
        "edges": edges,
    })
}

/// Writes pictures to their files, all or none. Pictures without a name go to standard output.
fn write(pictures: Vec<(Option<Utf8PathBuf>, Vec<u8>)>) -> anyhow::Result<()> {
    let mut files = Vec::new();
    for (path, bytes) in pictures {
        match path.filter(|path| path != "-") {
            Some(path) => files.push(NewContent::new(path, bytes)),
            None => std::io::stdout().write_all(&bytes)?,
        }
    }
    report::write_files(files, &[])
}
