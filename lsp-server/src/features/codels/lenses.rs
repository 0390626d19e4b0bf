//! Lenses above the functions of codels: the declaration in the specification, and a link to it.

use camino::Utf8Path;
use dotgen_analysis::host::{Cancellable, UnitResult};
use dotgen_analysis::model::system::{System, listed, parts};
use dotgen_analysis::model::{Codel, CodelKind, CodelRef, Component, ParamSource, State, mutex};
use dotgen_analysis::quantity;
use dotgen_analysis::source_map::Locations;
use dotgen_codegen::codels::expected::{Expected, owner_words, state_text};
use dotgen_codegen::codels::links;
use serde_json::json;

use crate::features::codels;
use crate::features::commands::{SHOW_CODEL, SHOW_REFERENCES};
use crate::protocol::types::*;
use crate::workspace::snapshot::{Answer, Snapshot, Subject};

/// Maximum number of uses with a lens of their own. With more, a function has one lens for all.
const MAX_USES: usize = 3;

/// Appended to a lens while the specification has syntax errors.
const EARLIER: &str = " · as of the last text without syntax errors";

/// Maximum number of codels of other components in a lens.
const MAX_REMOTE: usize = 3;

/// `textDocument/codeLens` in a source: lenses above functions, at the place of the function's name.
pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &CodeLensParams,
) -> Answer<Option<Vec<CodeLens>>> {
    if !snapshot.config.code_lens.codels {
        return Ok(Some(Vec::new()));
    }
    let lines = snapshot.text_lines(&subject.path)?;
    let mut out = Vec::new();
    for (lens, range) in lenses(snapshot, &subject.path)? {
        let mut locations = Vec::new();
        for (path, range) in &lens.places {
            locations.extend(snapshot.location(path, range)?);
        }
        let range = lines.range(&range);
        let (command, argument) = match locations.as_slice() {
            [] => ("", json!(null)),
            [one] if snapshot.client.show_document => (SHOW_CODEL, json!(one)),
            several => (
                SHOW_REFERENCES,
                json!({ "uri": subject.uri, "position": range.start, "locations": several }),
            ),
        };
        let arguments = (!command.is_empty()).then(|| vec![argument]);
        out.push(CodeLens {
            range,
            command: Some(Command::new(lens.title, command.to_owned(), arguments)),
            data: None,
        });
    }
    Ok(Some(out))
}

/// The text of a lens and the place it links to.
#[derive(Debug, PartialEq, Eq, Hash)]
pub(crate) struct Lens {
    pub(crate) title: String,
    places: Vec<(camino::Utf8PathBuf, std::ops::Range<usize>)>,
}

/// The lenses of a source. The range of each begins at its function.
pub(crate) fn lenses(
    snapshot: &Snapshot,
    path: &Utf8Path,
) -> Cancellable<Vec<(Lens, std::ops::Range<usize>)>> {
    let mut out = Vec::new();
    let around = codels::around(snapshot, path)?;
    // Computed when the first codel uses a port.
    let mut units: Option<Vec<UnitResult>> = None;
    for folder in around.iter().flat_map(|folders| folders.folders()) {
        let all = folder.expected();
        let mut components = all.iter().map(Expected::component);
        let meets =
            |component: &Component| component.all_codels().any(|at| uses_port(component.codel(at)));
        if units.is_none() && components.any(meets) {
            units = Some(snapshot.system_units(path)?);
        }
    }
    let specs = units.iter().flatten().map(|unit| &*unit.spec);
    let connections = snapshot.config.connections_of(path);
    let system = System::new(parts(specs), &connections);
    for compared in &around {
        for folder in compared.folders() {
            let all = folder.expected();
            for function in links::codel_functions(&all, &folder.sources, path) {
                let mut found = Vec::new();
                for (component, at) in &function.codels {
                    let expected = all.iter().find(|expected| expected.component == *component);
                    let Some(expected) = expected else { continue };
                    let place = expected.component().codel(*at).src;
                    let place = folder.unit.locations.locate(place);
                    let places = place.into_iter().map(|place| (place.path, place.range)).collect();
                    let mut title = title(expected, *at, &system);
                    if folder.is_earlier {
                        title += EARLIER;
                    }
                    found.push(Lens { title, places });
                }
                if found.len() > MAX_USES {
                    let title = format!("codel of {} tasks and services", found.len());
                    let places = found.into_iter().flat_map(|lens| lens.places).collect();
                    found = vec![Lens { title, places }];
                }
                let range = function.range.start..function.name_range.end;
                out.extend(found.into_iter().map(|lens| (lens, range.clone())));
            }
        }
    }
    Ok(out)
}

/// `activity fill: start → wait, ether · wcet 5 us · excludes tank_mix`
fn title(expected: &Expected<'_>, at: CodelRef, system: &System<'_>) -> String {
    let component = expected.component();
    let codel = component.codel(at);
    let (kind, owner) = owner_words(component, at.owner);
    let mut out = format!("{kind} {owner}");
    let states = |all: &[State]| -> String {
        let all: Vec<String> = all.iter().map(state_text).collect();
        all.join(", ")
    };
    match codel.kind {
        CodelKind::Validate => out = format!("validates {out}"),
        CodelKind::Fsm => {
            out += &format!(": {} → {}", states(&codel.triggers), states(&codel.yields));
        }
        CodelKind::Simple => {}
    }
    if codel.is_async {
        out += " · async";
    }
    if let Some(wcet) = &codel.wcet {
        out += &format!(" · wcet {}", quantity::time(wcet.value));
    }
    let excluded = mutex::excluded_names(expected.spec, component, at);
    match excluded.as_slice() {
        [] => {}
        names if names.len() <= 3 => out += &format!(" · excludes {}", names.join(", ")),
        names => out += &format!(" · excludes {} codels", names.len()),
    }
    let remote = remote_exclusions(component, at, system);
    if !remote.is_empty() {
        out += &format!(" · excludes elsewhere {}", listed(&remote, MAX_REMOTE));
    }
    out
}

fn uses_port(codel: &Codel) -> bool {
    let mut params = codel.params.iter();
    params.any(|param| matches!(param.source, ParamSource::Port(_)))
}

/// Codels of other components that a codel excludes: `nav.go_codel through pom.pose`.
fn remote_exclusions(component: &Component, at: CodelRef, system: &System<'_>) -> Vec<String> {
    let Some(part) = system.part(&component.name).filter(|_| uses_port(component.codel(at))) else {
        return Vec::new();
    };
    // Another unit may have read the declaration differently.
    let read = system.parts[part].component;
    let name = |component: &Component| component.codel(at).name.clone();
    if !read.all_codels().any(|codel| codel == at) || name(read) != name(component) {
        return Vec::new();
    }
    let mut out = Vec::new();
    for exclusion in system.exclusions(part, at) {
        let other = system.parts[exclusion.part].component;
        let codel = &other.codel(exclusion.codel).name;
        let name = format!("{}.{codel} through {}", other.name, system.port_name(exclusion.port));
        if !out.contains(&name) {
            out.push(name);
        }
    }
    out
}
