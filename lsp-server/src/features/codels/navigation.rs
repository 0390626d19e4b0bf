//! From codels to functions, and from names in sources to the specification.

use std::collections::BTreeSet;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::FileEdit;
use dotgen_analysis::host::{Analysis, Cancellable};
use dotgen_analysis::ide::FilePosition;
use dotgen_analysis::source_map::Locations;
use dotgen_codegen::codels::drift::SourcePlace;
use dotgen_codegen::codels::folder::Folder;
use dotgen_codegen::codels::links;
use dotgen_codegen::codels::origin::origin;
use dotgen_codegen::codels::rename::{self, Renaming};

use crate::features::codels::{self, Texts};
use crate::features::specification::{goto, hover, references};
use crate::protocol::types::{
    GotoDefinitionParams, GotoDefinitionResponse, Hover, HoverParams, Location, Position, Range,
    ReferenceParams,
};
use crate::workspace::snapshot::{Snapshot, Subject};

/// Calls `visit` with the folder, the component (index into what the folder expects) and the name of
/// each codel that is written at an offset of a specification.
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
                        place.is_some_and(|it| {
                            it.path == path && it.range.start <= offset && offset <= it.range.end
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

/// A name in a source, and the places of specifications where what it stands for is declared.
struct Declared {
    range: Option<Range>,
    places: Vec<FilePosition>,
}

/// What the name at a position of a source stands for.
fn declared(
    snapshot: &Snapshot,
    subject: &Subject,
    position: Position,
) -> Cancellable<Option<Declared>> {
    let Some(at) = snapshot.cursor(subject, position)? else {
        return Ok(None);
    };
    let mut out: Option<Declared> = None;
    for compared in codels::around(snapshot, &at.path)? {
        for folder in compared.folders() {
            for expected in folder.expected() {
                let Some(it) = origin(&expected, &folder.sources, &at.path, at.offset) else {
                    continue;
                };
                let range = snapshot.location(&at.path, &it.range)?.map(|it| it.range);
                let places = &mut out
                    .get_or_insert(Declared {
                        range,
                        places: Vec::new(),
                    })
                    .places;
                for src in it.declared {
                    let place = folder.unit.locations.locate(src).map(|it| FilePosition {
                        path: it.path,
                        offset: it.range.end,
                    });
                    places.extend(place.filter(|it| !places.contains(it)));
                }
            }
        }
    }
    Ok(out)
}

/// `textDocument/definition` in a source: the declaration in the specification.
pub(crate) fn definition(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &GotoDefinitionParams,
) -> Cancellable<Option<GotoDefinitionResponse>> {
    let position = params.text_document_position_params.position;
    let Some(found) = declared(snapshot, subject, position)? else {
        return Ok(None);
    };
    let mut links = Vec::new();
    for at in &found.places {
        // The declaration of a parameter of a codel is that of the member or port that it passes.
        for link in goto::links(snapshot, at, Analysis::goto_definition)? {
            if !links.contains(&link) {
                links.push(link);
            }
        }
    }
    for link in &mut links {
        link.origin_selection_range = found.range;
    }
    Ok(goto::response(snapshot, links))
}

/// `textDocument/hover` in a source: that of the declaration in the specification.
pub(crate) fn hover(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &HoverParams,
) -> Cancellable<Option<Hover>> {
    let position = params.text_document_position_params.position;
    let Some(found) = declared(snapshot, subject, position)? else {
        return Ok(None);
    };
    let Some(at) = found.places.first() else {
        return Ok(None);
    };
    let hover = snapshot.analysis.hover(at)?;
    Ok(hover.map(|it| hover::response(snapshot, it.info.markdown, found.range)))
}

/// `textDocument/references` in a source: the mentions in specifications and scenarios.
pub(crate) fn mentions(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &ReferenceParams,
) -> Cancellable<Option<Vec<Location>>> {
    let position = params.text_document_position.position;
    let Some(found) = declared(snapshot, subject, position)? else {
        return Ok(None);
    };
    let mut locations: Vec<Location> = Vec::new();
    for at in &found.places {
        for it in references::of_specifications(snapshot, at, params.context.include_declaration)? {
            if !locations.contains(&it) {
                locations.push(it);
            }
        }
    }
    Ok(Some(locations).filter(|it| !it.is_empty()))
}

/// The edits of the sources and build files that go with a rename, whose edits of specifications are
/// `edits`; why they cannot follow.
pub(crate) fn rename(
    snapshot: &Snapshot,
    edits: &[FileEdit],
) -> Cancellable<Result<Renaming, String>> {
    let edited: BTreeSet<&Utf8PathBuf> = edits.iter().map(|it| &it.path).collect();
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
        // Of a unit without sources the model is not asked for: there may be a thousand.
        if !codels::may_have_sources(snapshot, &root)? {
            continue;
        }
        for compared in codels::around(snapshot, &root)? {
            // What the rename makes of a unit is compiled only where sources might follow.
            if !compared.folders().any(|it| it.sources.exists) {
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
