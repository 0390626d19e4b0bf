//! A new component: `dotgen/interfaces`, `dotgen/newComponent` and `dotgen new`. This module makes the files;
//! the editor, or the command line, writes them.

use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::Severity;
use dotgen_analysis::host::{AnalysisHost, Cancellable, Change};
use dotgen_analysis::ide;
use dotgen_analysis::language::SCENARIO;
use dotgen_analysis::model::{Component, ComponentKind, PortDir};
use dotgen_analysis::source_map::Locations;
use dotgen_codegen::codels::command::{self, Project, StubTarget};
use dotgen_codegen::codels::files::{Files, FilesConfig, ModificationTime};
use dotgen_codegen::codels::stub::StubOptions;
use dotgen_codegen::component::{NewComponent, NewInterface, NewPort, NewTask};
use dotgen_syntax::{format, parse_text};
use dotgen_timing::scn;
use serde::{Deserialize, Serialize};

use crate::features::codels::judged_actions::private_host;
use crate::features::codels::{Disk, Texts};
use crate::protocol::convert::uri;
use crate::protocol::types::Uri;
use crate::protocol::user_result::UserResult;
use crate::workspace::snapshot::{Snapshot, Subject};

/// The contents of a new component, with interfaces by name and file.
#[derive(Debug, Clone, Default)]
pub struct Answers {
    /// The name of the component.
    pub name: String,
    pub tasks: Vec<NewTask>,
    /// Interfaces that it provides: name and file.
    pub provides: Vec<(String, Utf8PathBuf)>,
    /// Interfaces that it uses: name and file.
    pub uses: Vec<(String, Utf8PathBuf)>,
}

/// The files of a component in a folder: specification, scenario, sources of the codels. `texts` has every
/// existing file. The error is a message for the user.
pub fn files(
    host: &mut AnalysisHost,
    texts: &dyn Files,
    folder: &Utf8Path,
    answers: &Answers,
) -> Result<Vec<(Utf8PathBuf, String)>, String> {
    let mut wanted = NewComponent {
        name: answers.name.clone(),
        tasks: answers.tasks.clone(),
        ..NewComponent::default()
    };
    let provides = answers.provides.iter().map(|provided| (provided, false));
    let uses = answers.uses.iter().map(|usage| (usage, true));
    for ((name, path), reversed) in provides.chain(uses) {
        let interface = interface(host, folder, name, path, reversed)?;
        let all = if reversed { &mut wanted.uses } else { &mut wanted.provides };
        all.push(interface);
    }
    let made = wanted.texts().map_err(|error| error.to_string())?;
    let specification = folder.join(format!("{}.gen", answers.name));
    let text = formatted(&made.specification);
    host.apply(Change {
        files: vec![(specification.clone(), Some(text.clone()))],
        ..Change::default()
    });
    let found = host.analysis().diagnostics(&specification);
    let found = found.map_err(|error| error.to_string())?;
    if let Some(error) = found.iter().find(|diagnostic| diagnostic.severity == Severity::Error) {
        return Err(format!("the component would have an error: {}", error.message));
    }
    let options = StubOptions { use_parameters: true, ..StubOptions::default() };
    let mut project = Project::new(host, texts, FilesConfig::default(), options);
    project.overlay(specification.clone(), text.clone());
    let stubs = command::stub(&mut project, &specification, &StubTarget::All)?;
    drop(project);
    let scenario = specification.with_extension(SCENARIO);
    let of_scenario = scn::format(&made.scenario).unwrap_or(made.scenario);
    let mut out = vec![(specification, text), (scenario, of_scenario)];
    out.extend(stubs.into_iter().map(|stub| (stub.path, stub.after)));
    match out.iter().find(|(path, _)| texts.read(path).is_some()) {
        Some((path, _)) => Err(format!(
            "`{}` is there already: choose another name or folder, or remove it",
            path.strip_prefix(folder.parent().unwrap_or(folder)).unwrap_or(path)
        )),
        None => Ok(out),
    }
}

fn formatted(text: &str) -> String {
    let parse = parse_text(text);
    let style = format::Options::default();
    format::apply(text, &format::format(&parse.syntax(), &parse.broken(), None, &style))
}

/// An interface of a file, in the form that a component uses.
fn interface(
    host: &AnalysisHost,
    folder: &Utf8Path,
    name: &str,
    path: &Utf8Path,
    reversed: bool,
) -> Result<NewInterface, String> {
    let unit = host.analysis().root_unit(path).map_err(|error| error.to_string())?;
    if let Some(error) = unit.errors_in_text().next() {
        return Err(format!("{path} has an error: {}", error.message));
    }
    let all = &unit.spec.components;
    let found = all.iter().find(|component| is_interface(component) && component.name == name);
    let Some(found) = found else {
        return Err(format!("{path} has no interface `{name}`: name the file that declares it"));
    };
    let include = ide::relative_path(folder, path).ok_or_else(|| {
        format!("there is no way from {folder} to {path} that an `#include` could name")
    })?;
    Ok(NewInterface {
        name: name.to_owned(),
        include: include.as_str().replace('\\', "/"),
        ports: found
            .ports
            .iter()
            .map(|port| NewPort {
                name: port.name.to_string(),
                writes: (port.dir == PortDir::Out) != reversed,
            })
            .collect(),
    })
}

fn is_interface(component: &Component) -> bool {
    component.kind == ComponentKind::Interface
}

/// Parameters of `dotgen/interfaces` and `dotgen/newComponent`.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(crate) struct NewComponentParams {
    /// The folder of the component, which need not exist.
    folder: Option<Uri>,
    name: String,
    tasks: Vec<TaskParams>,
    provides: Vec<InterfaceParams>,
    uses: Vec<InterfaceParams>,
}

/// A task, and its period if it has one.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct TaskParams {
    name: String,
    #[serde(default)]
    period: Option<String>,
}

/// An interface and the file that declares it.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct InterfaceParams {
    name: String,
    uri: Uri,
}

/// An interface that a new component can provide or use.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct InterfaceInfo {
    name: String,
    uri: Uri,
    /// Its ports as declared: `out pose`.
    ports: Vec<String>,
    /// True if it has only ports: a component that provides services needs codels for them.
    can_be_provided: bool,
}

/// A file to be written.
#[derive(Debug, Serialize, Deserialize)]
struct NewFile {
    uri: Uri,
    text: String,
}

/// Answer of `dotgen/newComponent`. The specification is the first file.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct NewFiles {
    files: Vec<NewFile>,
}

/// The interfaces of the workspace, by name.
pub(crate) fn interfaces(
    snapshot: &Snapshot,
    _: Option<&Subject>,
    _: &NewComponentParams,
) -> Cancellable<Vec<InterfaceInfo>> {
    let mut out: Vec<InterfaceInfo> = Vec::new();
    for root in snapshot.roots.iter() {
        let unit = snapshot.analysis.root_unit(root)?;
        let components = &unit.spec.components;
        // Two files with components cannot be in one unit.
        let file_of = |component: &Component| {
            unit.locations.locate(component.src).map(|location| location.path)
        };
        let with_components: Vec<Utf8PathBuf> = components
            .iter()
            .filter(|component| !is_interface(component))
            .filter_map(file_of)
            .collect();
        for component in components.iter().filter(|component| is_interface(component)) {
            let Some(path) = file_of(component).filter(|file| !with_components.contains(file))
            else {
                continue;
            };
            let Some(uri) = snapshot.uri(&path) else {
                continue;
            };
            if out.iter().any(|known| known.uri == uri && known.name == component.name.as_str()) {
                continue;
            }
            let ports = component.ports.iter().map(|port| {
                let dir = port.dir.word();
                format!("{dir} {}", port.name)
            });
            out.push(InterfaceInfo {
                name: component.name.to_string(),
                uri,
                ports: ports.collect(),
                can_be_provided: component.services.is_empty() && component.tasks.is_empty(),
            });
        }
    }
    out.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(out)
}

/// The files of a new component.
pub(crate) fn new_component(
    snapshot: &Snapshot,
    params: &NewComponentParams,
) -> Cancellable<UserResult<NewFiles>> {
    let Some(folder) = &params.folder else {
        return Ok(UserResult(Err("a component needs a folder: name one".to_owned())));
    };
    let folder = uri::to_path(folder);
    let named = |all: &[InterfaceParams]| -> Vec<(String, Utf8PathBuf)> {
        let all = all.iter();
        all.map(|param| (param.name.clone(), uri::to_path(&param.uri))).collect()
    };
    let answers = Answers {
        name: params.name.clone(),
        tasks: params
            .tasks
            .iter()
            .map(|task| NewTask { name: task.name.clone(), period: task.period.clone() })
            .collect(),
        provides: named(&params.provides),
        uses: named(&params.uses),
    };
    let mut host = private_host(snapshot)?;
    let texts = Unwritten(Texts::new(snapshot));
    let made = files(&mut host, &texts, &folder, &answers);
    texts.0.check()?;
    Ok(UserResult(made.map(|made| {
        let file = |(path, text): (Utf8PathBuf, String)| {
            Some(NewFile { uri: uri::from_path(&path)?, text })
        };
        Some(NewFiles { files: made.into_iter().filter_map(file).collect() })
    })))
}

/// The files of a snapshot, of which those not open are read from the disk. Analysis would remember that the
/// files of the new component do not exist.
struct Unwritten<'a>(Texts<'a>);

impl Files for Unwritten<'_> {
    fn read(&self, path: &Utf8Path) -> Option<Arc<str>> {
        if self.0.is_open(path) { self.0.read(path) } else { Disk.read(path) }
    }

    fn list(&self, folder: &Utf8Path) -> Option<Vec<Utf8PathBuf>> {
        self.0.list(folder)
    }

    fn changed(&self, path: &Utf8Path) -> Option<ModificationTime> {
        if self.0.is_open(path) { self.0.changed(path) } else { self.0.changed_on_disk(path) }
    }
}
