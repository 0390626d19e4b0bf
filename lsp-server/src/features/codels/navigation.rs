//! From codels to functions.

use std::collections::BTreeSet;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::FileEdit;
use dotgen_analysis::host::Cancellable;
use dotgen_analysis::source_map::Locations;
use dotgen_codegen::codels::drift::SourcePlace;
use dotgen_codegen::codels::folder::Folder;
use dotgen_codegen::codels::links;
use dotgen_codegen::codels::rename::{self, Renaming};

use crate::features::codels::{self, Texts};
use crate::workspace::snapshot::Snapshot;

/// Calls `visit` with the folder, the component (index into the expected components of the folder) and the
/// name of each codel at an offset of a specification.
fn for_codel_at(
    snapshot: &Snapshot,
    path: &Utf8Path,
    offset: usize,
    mut visit: impl FnMut(&Folder, usize, &str),
) -> Cancellable<()> {
    if snapshot.is_code(path) {
        return Ok(());
    }
    for compared in codels::around(snapshot, path)? {
        for folder in compared.folders() {
            for (index, expected) in folder.expected().iter().enumerate() {
                let component = expected.component();
                for function in &expected.functions {
                    let mut uses = function.uses.iter();
                    let here = uses.any(|&at| {
                        let place = folder.unit.locations.locate(component.codel(at).src);
                        place.is_some_and(|place| {
                            place.path == path
                                && place.range.start <= offset
                                && offset <= place.range.end
                        })
                    });
                    if here {
                        visit(folder, index, &function.name);
                    }
                }
            }
        }
    }
    Ok(())
}

/// The functions of the codel at an offset of a specification.
pub(crate) fn implementations(
    snapshot: &Snapshot,
    path: &Utf8Path,
    offset: usize,
) -> Cancellable<Vec<SourcePlace>> {
    let mut out = Vec::new();
    for_codel_at(snapshot, path, offset, |folder, _, name| {
        out.extend(links::implementations(&folder.sources, name));
    })?;
    Ok(out)
}

/// Mentions in the sources of the codel at an offset of a specification.
pub(crate) fn references(
    snapshot: &Snapshot,
    path: &Utf8Path,
    offset: usize,
) -> Cancellable<Vec<SourcePlace>> {
    let mut out = Vec::new();
    for_codel_at(snapshot, path, offset, |folder, _, name| {
        out.extend(links::references(&folder.sources, name));
    })?;
    Ok(out)
}

/// The edits of sources and build files that go with a rename, whose edits of specifications are `edits`. The
/// error is the reason why they cannot follow.
pub(crate) fn rename(
    snapshot: &Snapshot,
    edits: &[FileEdit],
) -> Cancellable<Result<Renaming, String>> {
    let edited: BTreeSet<&Utf8PathBuf> = edits.iter().map(|edit| &edit.path).collect();
    let mut containing: BTreeSet<Utf8PathBuf> = BTreeSet::new();
    for path in edited {
        containing.extend(snapshot.analysis.roots_containing(path)?);
    }
    let mut roots: BTreeSet<Utf8PathBuf> = BTreeSet::new();
    for root in containing {
        roots.insert(snapshot.analysis.root_of(&root)?);
    }
    let mut out = Renaming::default();
    let texts = Texts::new(snapshot);
    for root in roots {
        // The model of a unit without sources is not built: there may be a thousand units.
        if !codels::may_have_sources(snapshot, &root)? {
            continue;
        }
        for compared in codels::around(snapshot, &root)? {
            // The renamed unit is compiled only if it has sources.
            if !compared.folders().any(|folder| folder.sources.exists) {
                continue;
            }
            let after = snapshot.analysis.edited_root_unit(&root, edits)?;
            for folder in compared.folders() {
                let one = rename::rename(folder, &after, &texts);
                texts.check()?;
                let one = match one {
                    Ok(one) => one,
                    Err(why) => return Ok(Err(why.to_string())),
                };
                if !out.edit.merge(one.edit) {
                    let folder = &folder.sources.folder;
                    return Ok(Err(format!(
                        "The sources in {folder} serve several specifications, which want different names \
                            there"
                    )));
                }
                out.left.extend(one.left);
            }
        }
    }
    out.left.sort();
    out.left.dedup();
    Ok(Ok(out))
}
