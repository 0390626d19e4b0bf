//! Renames the entity under the cursor, everywhere.
//!
//! A rename changes every known mention in all units, and everything that gets its name from one of them (the
//! parameter `x` of `attribute set(in x)` has the name of the member). The result is compiled before it is
//! offered: a rename that would clash, capture, or change the target of a reference is refused with the
//! reason.

use std::ops::Range;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_syntax::{SyntaxKind, directive::DirectiveKind, lexer::lex};
use rustc_hash::{FxHashMap, FxHashSet};

use self::rename_check::RenameCheck;
use super::{
    FileView, RangeInfo,
    document_links::path_range,
    resolve::{
        Identity, Target, elaborated_of_many, find_identities, identity, identity_in, nav_target,
        targets_at,
    },
    speculate::{Comparison, compare_some},
    view::place,
};
use crate::fixes::is_name;
use crate::progress::Progress;
use crate::{
    base::{Db, SourceFile, lexed, normalize},
    diagnostic::FileEdit,
    elab::{DefId, DefKind},
    parallel,
    source_map::bytes,
    unit::{UnitKey, defines, files, preprocessed, roots_of, unit_of_root, visits},
};

/// The reason why a rename is refused: a message for the user.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RenameError(pub String);

impl std::fmt::Display for RenameError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for RenameError {}

fn refuse<T>(why: impl Into<String>) -> Result<T, RenameError> {
    Err(RenameError(why.into()))
}

/// The range and the present name of a rename.
///
/// # Errors
/// Returns the reason if the name cannot be renamed.
pub(crate) fn prepare(view: &FileView<'_>, at: usize) -> Result<RangeInfo<String>, RenameError> {
    let Some((range, targets)) = targets_at(view, at) else {
        return refuse("There is no name here that can be changed");
    };
    let range = bytes(range);
    let written = view.text().get(range.clone()).unwrap_or_default();
    let name = match targets.first() {
        Some(Target::Definition(id)) => definition_name(view, *id)?,
        Some(Target::Macro(name, Some(_))) if nav_target(view, &targets[0]).is_some() => {
            name.to_string()
        }
        Some(Target::Macro(name, _)) => {
            return refuse(format!("`{name}` is not defined in a file of this specification"));
        }
        Some(Target::File(_)) => {
            return refuse("To change a path, rename the file: its includes are updated");
        }
        None => return refuse("There is no name here that can be changed"),
    };
    if written != name {
        return refuse(format!(
            "`{name}` is written by the macro call `{written}`: change the macro"
        ));
    }
    Ok(RangeInfo { range, info: name })
}

fn definition_name(view: &FileView<'_>, id: DefId) -> Result<String, RenameError> {
    let all = &view.elaborated().definitions;
    let Some(definition) = all.get(id) else {
        return refuse("There is no name here that can be changed");
    };
    if definition.kind == DefKind::Ids {
        return refuse("`ids` is a word of the language");
    }
    if definition.kind == DefKind::State
        && matches!(definition.name.as_str(), "start" | "stop" | "ether")
    {
        return refuse(format!("The state `{}` has its name from the language", definition.name));
    }
    if view.place(definition.src).is_none() {
        return refuse(format!("`{}` is not defined in a file", definition.name));
    }
    Ok(definition.name.to_string())
}

/// The edits that rename the entity under the cursor.
///
/// # Errors
/// Returns the reason if the entity cannot have that name.
pub(crate) fn rename(
    view: &FileView<'_>,
    at: usize,
    new_name: &str,
    progress: &Progress,
) -> Result<Vec<FileEdit>, RenameError> {
    let old = prepare(view, at)?.info;
    check_name(new_name)?;
    if old == new_name {
        return Ok(Vec::new());
    }
    let Some((_, targets)) = targets_at(view, at) else {
        return refuse("There is no name here that can be changed");
    };
    let is_macro = targets.iter().any(|target| matches!(target, Target::Macro(..)));
    let places = if is_macro {
        macro_places(view, at, &old)
    } else {
        places_of(view, &targets, &old, new_name, progress)?
    };
    let db = view.db;
    let mut edits = Vec::with_capacity(places.len());
    for (file, range) in places {
        let written = file.text(db).get(range.clone()).unwrap_or_default();
        if written != old {
            let name = file.path(db).file_name().unwrap_or_default().to_owned();
            let line = 1 + file.text(db)[..range.start].matches('\n').count();
            return refuse(format!(
                "`{old}` also comes out of the macro call `{written}` ({name}, line {line}): change that by \
                    hand first"
            ));
        }
        edits.push(FileEdit { path: file.path(db).clone(), range, new_text: new_name.to_owned() });
    }
    // Sorted by the text of paths: comparing their components takes a second for many edits.
    edits.sort_by(|a, b| (a.path.as_str(), a.range.start).cmp(&(b.path.as_str(), b.range.start)));
    edits.dedup();
    check_macros(view, &edits, new_name, is_macro)?;
    let kind = targets.iter().find_map(|target| match target {
        Target::Definition(id) => Some(view.elaborated().definition(*id).kind),
        _ => None,
    });
    check_meaning(view, &edits, kind, (&old, new_name), progress)?;
    Ok(edits)
}

fn check_name(name: &str) -> Result<(), RenameError> {
    let raw = lex(name);
    if !is_name(name) {
        return refuse(format!(
            "`{name}` is not a name: use letters, digits and `_`, not beginning with a digit"
        ));
    }
    if raw.is_empty() || raw.kind(0) != SyntaxKind::IDENT {
        return refuse(format!("`{name}` is a reserved word"));
    }
    Ok(())
}

type FileSpan = (SourceFile, Range<usize>);
type Places = FxHashSet<FileSpan>;

/// Every mention of some definitions and of everything that shares its name with them.
fn places_of(
    view: &FileView<'_>,
    targets: &[Target],
    old: &str,
    new_name: &str,
    progress: &Progress,
) -> Result<Places, RenameError> {
    let db = view.db;
    let mut identities: Vec<Identity> = Vec::new();
    for target in targets {
        if let Target::Definition(id) = target {
            identities.extend(identity(db, view.unit, *id));
        }
    }
    let mut places = Places::default();
    let mut known: FxHashSet<Identity> = identities.iter().cloned().collect();
    let mut done = 0;
    while done < identities.len() {
        let fresh = identities[done..].to_vec();
        done = identities.len();
        let mut seen = FxHashSet::default();
        let mut roots: Vec<SourceFile> = view.unit.inputs(db).clone();
        for identity in &fresh {
            roots.extend(roots_of(db, identity.file));
        }
        roots.retain(|root| seen.insert(*root));
        progress.expect(roots.len());
        let found = parallel::over(db, &roots, |db, &root| {
            let found = mentions(db, unit_of_root(db, root), &fresh, old, roots.len());
            progress.step();
            found
        });
        for (place, identity) in found.into_iter().flatten() {
            places.insert(place);
            if known.insert(identity.clone()) {
                identities.push(identity);
            }
        }
        if identities.iter().any(|identity| {
            use super::SymbolKind::*;
            new_name == "all" && matches!(identity.kind, Attribute | Function | Activity)
        }) {
            return refuse("`all` cannot be the name of a service");
        }
    }
    Ok(places)
}

/// The mentions of `wanted` in one of `count` units, and the other definitions that get their name from one
/// of them.
fn mentions(
    db: &dyn Db,
    unit: UnitKey<'_>,
    wanted: &[Identity],
    old: &str,
    count: usize,
) -> Vec<(FileSpan, Identity)> {
    let elaborated = elaborated_of_many(db, unit, count);
    let ids = find_identities(db, unit, &elaborated, wanted);
    if ids.is_empty() {
        return Vec::new();
    }
    // Most names are different: their places are not looked up.
    let is_named = |definition: DefId| elaborated.definition(definition).name == old;
    let declared = elaborated.definitions.iter().map(|definition| (definition.src, definition.id));
    let used = elaborated.references.iter().map(|reference| (reference.at, reference.target));
    let named: Vec<(FileSpan, DefId)> = declared
        .chain(used)
        .filter(|(_, id)| is_named(*id))
        .filter_map(|(src, id)| {
            let (file, range) = place(db, unit, src)?;
            Some(((file, bytes(range)), id))
        })
        .collect();
    let found: FxHashSet<&FileSpan> =
        named.iter().filter(|(_, id)| ids.contains(id)).map(|(place, _)| place).collect();
    let mut identities: FxHashMap<DefId, Option<Identity>> = FxHashMap::default();
    let mut out = Vec::new();
    for (place, id) in named.iter().filter(|(place, _)| found.contains(place)) {
        let identity =
            identities.entry(*id).or_insert_with(|| identity_in(db, unit, &elaborated, *id));
        out.extend(identity.clone().map(|identity| (place.clone(), identity)));
    }
    out
}

/// Every use of a macro, also in conditions and in the bodies of other macros.
fn macro_places(view: &FileView<'_>, at: usize, old: &str) -> Places {
    let db = view.db;
    let mut places = Places::default();
    let found = super::references::references(view, at, true).unwrap_or_default();
    let mut concerned: FxHashSet<SourceFile> = FxHashSet::default();
    for reference in found {
        let file = db.file(&reference.place.path);
        places.insert((file, reference.place.range));
        for &root in roots_of(db, file) {
            concerned.extend(files(db, unit_of_root(db, root)));
        }
    }
    for file in concerned {
        let (raw, text) = (&lexed(db, file).raw, file.text(db));
        for define in defines(db, file).iter() {
            for i in define.body.clone() {
                if raw.clean_text(text, i as usize) == old {
                    places.insert((file, raw.range(i as usize)));
                }
            }
        }
        // An include guard is mentioned before it is defined.
        for visit in roots_of(db, file).iter().flat_map(|root| {
            let visits = visits(db, unit_of_root(db, *root)).all();
            visits.iter().filter(|visit| visit.key.file(db) == file)
        }) {
            for directive in &preprocessed(db, visit.key).directives {
                if let DirectiveKind::Ifdef(operand)
                | DirectiveKind::Ifndef(operand)
                | DirectiveKind::Undef(operand) = &directive.kind
                    && let Some(name) = &operand.name
                    && name.text == old
                {
                    places.insert((file, bytes(name.range)));
                }
            }
        }
    }
    places
}

/// Refuses a name that is a macro somewhere, since it would be expanded there, and a new name of a macro that
/// would expand other names.
fn check_macros(
    view: &FileView<'_>,
    edits: &[FileEdit],
    new_name: &str,
    is_macro: bool,
) -> Result<(), RenameError> {
    let db = view.db;
    let mut seen = FxHashSet::default();
    for edit in edits {
        let edited = db.file(&edit.path);
        for &root in roots_of(db, edited) {
            if !seen.insert(root) {
                continue;
            }
            for file in files(db, unit_of_root(db, root)) {
                let name = file.path(db).file_name().unwrap_or_default();
                if !crate::unit::mentioned(db, file).words.contains(new_name) {
                    continue;
                }
                let defined = defines(db, file)
                    .iter()
                    .any(|define| define.name.as_ref().is_some_and(|name| name.text == new_name));
                if defined {
                    return refuse(format!("`{new_name}` is a macro, defined in {name}"));
                }
                if is_macro {
                    return refuse(format!(
                        "{name} already says `{new_name}`, which the macro would replace"
                    ));
                }
            }
        }
    }
    Ok(())
}

/// Checks that only names differ after the rename.
fn check_meaning(
    view: &FileView<'_>,
    edits: &[FileEdit],
    kind: Option<DefKind>,
    (old, new_name): (&str, &str),
    progress: &Progress,
) -> Result<(), RenameError> {
    let differs = |db: &dyn Db, comparison: &Comparison| {
        let taken = || clash::taken(db, comparison, kind, new_name);
        if let Some(error) = comparison.new_errors.first() {
            // The error is about a text that is not visible to the user: the clash is more informative.
            return Some(taken().unwrap_or_else(|| error.message.to_string()));
        }
        let same = comparison.before.references == comparison.after.references
            && std::iter::zip(&comparison.before.definitions, &comparison.after.definitions).all(
                |(a, b)| {
                    (a.id, a.kind, a.src, a.container, a.ty)
                        == (b.id, b.kind, b.src, b.container, b.ty)
                },
            )
            && comparison.before.definitions.len() == comparison.after.definitions.len()
            && shape(&comparison.before.spec) == shape(&comparison.after.spec);
        (!same).then(|| {
            taken().unwrap_or_else(|| {
                "some names would then mean something else; choose another name".to_owned()
            })
        })
    };
    // The rename is always compiled in the requested unit.
    let fresh = RenameCheck::new(view.db, edits, old, new_name);
    let here = view.unit.inputs(view.db);
    let tried = |db: &dyn Db, root| here.contains(&root) || !fresh.in_unit_of(db, root);
    match compare_some(view.db, edits, tried, differs, progress).first() {
        Some(why) => refuse(format!("`{old}` cannot be called `{new_name}`: {why}")),
        None => Ok(()),
    }
}

/// Number of parts of each component.
fn shape(spec: &crate::model::Spec) -> Vec<[usize; 5]> {
    let of = |component: &crate::model::Component| {
        let codels = component.all_codels().count();
        let parts = [component.tasks.len(), component.ports.len(), component.services.len()];
        [parts[0], parts[1], parts[2], component.remotes.len(), codels]
    };
    spec.components.iter().map(of).collect()
}

/// The edits of include directives after moving files or folders: pairs of old and new path.
pub(crate) fn files_moved(db: &dyn Db, moves: &[(Utf8PathBuf, Utf8PathBuf)]) -> Vec<FileEdit> {
    let moved = |path: &Utf8Path| -> Option<Utf8PathBuf> {
        moves.iter().find_map(|(from, to)| {
            let rest = path.strip_prefix(normalize(from)).ok()?;
            let to = normalize(to);
            Some(if rest.as_str().is_empty() { to } else { to.join(rest) })
        })
    };
    let mut edits: Vec<FileEdit> = Vec::new();
    for root in db.workspace().roots(db).clone() {
        db.unwind_if_revision_cancelled();
        let all = visits(db, unit_of_root(db, db.file(&root))).all();
        for visit in all {
            let file = visit.key.file(db);
            let pre = preprocessed(db, visit.key);
            for (include, leads_to) in std::iter::zip(&pre.includes, &visit.includes) {
                let target = leads_to.and_then(|lead| all.get(lead));
                let (Some(target), Some(request)) = (target, &include.request) else {
                    continue;
                };
                let (from, target) = (file.path(db), target.key.file(db).path(db));
                let (new_from, new_target) = (moved(from), moved(target));
                if new_from.is_none() && new_target.is_none() {
                    continue;
                }
                let range = path_range(file.text(db), include.range);
                let new_from = new_from.as_deref().unwrap_or(from);
                let new_target = new_target.as_deref().unwrap_or(target);
                let spelled = Utf8Path::new(request.path.as_str());
                let new = respell(db, spelled, request.angled, from, target, new_from, new_target);
                // The name of a macro as an operand is not a path to change.
                let path = (range != include.range).then_some(new).flatten();
                if let Some(path) = path.filter(|path| path.as_str() != request.path) {
                    edits.push(FileEdit {
                        path: from.clone(),
                        range: bytes(range),
                        new_text: path.into_string(),
                    });
                }
            }
        }
    }
    // Sorted by the text of paths: comparing their components takes a second for many edits.
    edits.sort_by(|a, b| (a.path.as_str(), a.range.start).cmp(&(b.path.as_str(), b.range.start)));
    edits.dedup();
    edits
}

/// The new spelling of an include; `None` if it must stay.
fn respell(
    db: &dyn Db,
    spelled: &Utf8Path,
    angled: bool,
    from: &Utf8Path,
    target: &Utf8Path,
    new_from: &Utf8Path,
    new_target: &Utf8Path,
) -> Option<Utf8PathBuf> {
    if spelled.is_absolute() {
        return Some(new_target.to_owned());
    }
    let own = from.parent()?;
    if !angled && normalize(&own.join(spelled)) == target {
        return relative(new_from.parent()?, new_target);
    }
    // Found in a directory of the search path, configured or of a package.
    let tail = normalize(spelled);
    let base = target.as_str().strip_suffix(tail.as_str());
    let base = Utf8Path::new(base?.trim_end_matches('/')).to_owned();
    let dirs = std::iter::once(&base).chain(db.workspace().reading(db, from).0);
    let mut below = dirs.filter_map(|dir| new_target.strip_prefix(dir).ok());
    match below.next() {
        Some(path) => Some(path.to_owned()),
        None if angled => None,
        None => relative(new_from.parent()?, new_target),
    }
}

/// The path of a file relative to a directory; `None` if they have no common root.
pub fn relative(from: &Utf8Path, to: &Utf8Path) -> Option<Utf8PathBuf> {
    let mut up = Utf8PathBuf::new();
    for ancestor in from.ancestors() {
        if let Ok(rest) = to.strip_prefix(ancestor) {
            return Some(up.join(rest));
        }
        up.push("..");
    }
    None
}

mod clash;
mod rename_check;
#[cfg(test)]
mod tests;
