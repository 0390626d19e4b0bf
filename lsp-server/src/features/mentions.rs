//! Names of specifications in scenarios: their declarations, and their mentions in scenarios.

use std::ops::Range;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::FileEdit;
use dotgen_analysis::host::{Cancellable, FileContent};
use dotgen_analysis::ide::FilePosition;
use dotgen_analysis::language::is_scenario;
use dotgen_analysis::source_map::Locations;
use dotgen_timing::scn::names::{Names, Target};
use dotgen_timing::scn::outline::{self, EntryKind};

use crate::features::verification::problems;
use crate::workspace::snapshot::Snapshot;
use dotgen_platform::files::vfs;
use dotgen_views::verification::Problem;

/// The declaration of a target.
pub(crate) fn declaration(
    snapshot: &Snapshot,
    problem: &Problem,
    target: &Target,
) -> Cancellable<Option<FilePlace>> {
    let specs = problem.specs();
    let names = Names::new(&specs);
    let own = |range: Range<usize>| Some(FilePlace { path: problem.path.clone(), range });
    let declared = match target {
        Target::Client(name) => {
            let entries = outline::outline(&problem.text, &problem.scenario);
            let mut children = entries.into_iter().flat_map(|entry| entry.children);
            return Ok(children
                .find(|child| child.kind == EntryKind::Client && child.name == *name)
                .and_then(|child| own(child.selection)));
        }
        Target::Step(client, label) => {
            let entries = outline::outline(&problem.text, &problem.scenario);
            let children = entries.into_iter().flat_map(|entry| entry.children);
            let mut steps = children
                .filter(|child| child.kind == EntryKind::Client && child.name == *client)
                .flat_map(|child| child.children);
            return Ok(steps.find(|step| step.name == *label).and_then(|step| own(step.selection)));
        }
        _ => names.declaration(target),
    };
    let Some((spec, src)) = declared else {
        return Ok(None);
    };
    let place = problem.units[spec].locations.locate(src);
    let Some(place) = place else {
        return Ok(None);
    };
    // Analysis finds the place of the name.
    let at = FilePosition { path: place.path.clone(), offset: place.range.start };
    let found = snapshot.analysis.goto_definition(&at)?;
    let name = found.and_then(|definition| definition.info.into_iter().next());
    Ok(Some(match name {
        Some(name) if !matches!(target, Target::State(..) | Target::Codel(..)) => {
            FilePlace { path: name.path, range: name.focus_range }
        }
        _ => FilePlace { path: place.path, range: place.range },
    }))
}

/// A range of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct FilePlace {
    pub(crate) path: Utf8PathBuf,
    pub(crate) range: Range<usize>,
}

/// The texts of the scenarios of the workspace and of the open scenarios.
pub(crate) fn texts(snapshot: &Snapshot) -> Cancellable<Vec<(Utf8PathBuf, String)>> {
    let open = snapshot.open.keys().filter(|key| is_scenario(key));
    let mut paths: Vec<&Utf8PathBuf> = snapshot.scenarios.iter().chain(open).collect();
    paths.sort();
    paths.dedup();
    let mut out = Vec::new();
    for path in paths {
        let text = match snapshot.analysis.text(path)? {
            Some(text) => text.to_string(),
            None => match vfs::read(path) {
                FileContent::Text(text) => text,
                _ => continue,
            },
        };
        out.push((path.clone(), text));
    }
    Ok(out)
}

/// The scenarios that use a file, with their present texts.
fn scenarios_using(snapshot: &Snapshot, file: &Utf8Path) -> Cancellable<Vec<Problem>> {
    let mut out = Vec::new();
    for (path, text) in texts(snapshot)? {
        let problem = problems::scenario(snapshot, &path, text)?;
        if problem.reads(file) {
            out.push(problem);
        }
    }
    Ok(out)
}

/// The mentions in scenarios of the declaration at a place of a specification.
pub(crate) fn mentions(
    snapshot: &Snapshot,
    at: &FilePosition,
) -> Cancellable<Vec<(Utf8PathBuf, Range<usize>)>> {
    let mut out = Vec::new();
    if is_scenario(&at.path) {
        return Ok(out);
    }
    let scenarios = scenarios_using(snapshot, &at.path)?;
    if scenarios.is_empty() {
        return Ok(out);
    }
    let Some(found) = snapshot.analysis.goto_definition(at)? else {
        return Ok(out);
    };
    for problem in scenarios {
        let specs = problem.specs();
        let references = Names::new(&specs).references(&problem.scenario);
        for reference in references {
            let Some(place) = declaration(snapshot, &problem, &reference.target)? else {
                continue;
            };
            let same = |target: &dotgen_analysis::ide::NavTarget| {
                target.path == place.path && target.focus_range == place.range
            };
            if found.info.iter().any(same) {
                out.push((problem.path.clone(), reference.range));
            }
        }
    }
    Ok(out)
}

/// The edits of scenarios for a rename in a specification.
pub(crate) fn renames(
    snapshot: &Snapshot,
    at: &FilePosition,
    new_name: &str,
) -> Cancellable<Vec<FileEdit>> {
    let mentions = mentions(snapshot, at)?.into_iter();
    let edits =
        mentions.map(|(path, range)| FileEdit { path, range, new_text: new_name.to_owned() });
    Ok(edits.collect())
}
