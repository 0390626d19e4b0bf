//! All resolved names of a file, with their meanings.

use std::sync::Arc;

use dotgen_syntax::{TextRange, directive::DirectiveKind, preproc::MacroSite};
use rustc_hash::FxHashSet;
use smol_str::SmolStr;

use super::{
    AccessKind, FileView, NavTarget, SymbolKind,
    document_links::{include_target, path_range},
    view::place,
};
use crate::{
    base::{Db, SourceFile},
    elab::{DefId, Definition, Elaborated},
    parallel,
    queries::{elaborate, elaborated},
    source_map::{bytes, offset},
    unit::{UnitKey, define, roots_of, unit_of_root},
};

/// The target of a name.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) enum Target {
    /// A declaration of the unit.
    Definition(DefId),
    /// A macro: its name, and its definition unless it is predefined.
    Macro(SmolStr, Option<MacroSite>),
    File(SourceFile),
}

/// A name of a file, resolved.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Occurrence {
    pub(crate) range: TextRange,
    pub(crate) target: DefId,
    pub(crate) access: AccessKind,
}

/// The resolved names of a file in a unit, by place, from all its visits.
#[salsa::tracked(lru = 24, returns(deref))]
pub(crate) fn occurrences<'db>(
    db: &'db dyn Db,
    unit: UnitKey<'db>,
    file: SourceFile,
) -> Vec<Occurrence> {
    let elaborated = elaborated(db, unit);
    let here = |src| {
        let (in_file, range) = place(db, unit, src)?;
        (in_file == file).then_some(range)
    };
    let mut out = Vec::new();
    for definition in &elaborated.definitions {
        if let Some(range) = here(definition.src) {
            out.push(Occurrence { range, target: definition.id, access: AccessKind::Declaration });
        }
    }
    for reference in &elaborated.references {
        if let Some(range) = here(reference.at) {
            out.push(Occurrence { range, target: reference.target, access: reference.access });
        }
    }
    out.sort_by_key(|occurrence| {
        (occurrence.range.start(), occurrence.range.end(), occurrence.target, occurrence.access)
    });
    out.dedup();
    out
}

/// The name under the cursor: the smallest name that touches the offset, with all its targets.
pub(crate) fn targets_at(view: &FileView<'_>, at: usize) -> Option<(TextRange, Vec<Target>)> {
    let at = offset(at);
    let touches = |range: TextRange| range.contains_inclusive(at);
    for (ordinal, include) in view.pre().includes.iter().enumerate() {
        // A macro in the operand is its own target.
        let delimited = path_range(view.text(), include.range);
        if touches(include.range) && delimited != include.range {
            let target = include_target(view, ordinal)?;
            return Some((delimited, vec![Target::File(target)]));
        }
    }
    let in_macros = macro_at(view, at);
    let all = occurrences(view.db, view.unit, view.file);
    // A name that contains or follows the cursor has precedence over one that ends there.
    let names = all.iter().filter(|occurrence| touches(occurrence.range));
    let best = names.min_by_key(|name| (name.range.end() == at, name.range.len()));
    match (in_macros, best) {
        (Some((range, target)), Some(best)) if best.range.len() < range.len() => {
            _ = target;
            Some((best.range, same_place(all, best.range)))
        }
        (Some((range, target)), _) => Some((range, vec![target])),
        (None, Some(best)) => Some((best.range, same_place(all, best.range))),
        (None, None) => None,
    }
}

/// Like [`targets_at`], without the entity declared right there if the name has another target too: a
/// parameter of an attribute is declared by naming a member of the ids.
pub(crate) fn meanings_at(view: &FileView<'_>, at: usize) -> Option<(TextRange, Vec<Target>)> {
    let (range, targets) = targets_at(view, at)?;
    let is_here = |target: &&Target| match target {
        Target::Definition(id) => identity(view.db, view.unit, *id)
            .is_some_and(|identity| identity.file == view.file && identity.range == range),
        _ => false,
    };
    let elsewhere: Vec<Target> =
        targets.iter().filter(|target| !is_here(target)).cloned().collect();
    let found = if elsewhere.is_empty() { targets } else { elsewhere };
    Some((range, found))
}

fn same_place(all: &[Occurrence], range: TextRange) -> Vec<Target> {
    let mut seen = FxHashSet::default();
    all.iter()
        .filter(|occurrence| occurrence.range == range)
        .filter(|occurrence| seen.insert(occurrence.target))
        .map(|occurrence| Target::Definition(occurrence.target))
        .collect()
}

/// The macro named under the cursor, in its definition, a condition or a call.
fn macro_at(view: &FileView<'_>, at: dotgen_syntax::TextSize) -> Option<(TextRange, Target)> {
    let pre = view.pre();
    let used = pre.macro_uses.iter().find(|usage| usage.range.contains_inclusive(at));
    if let Some(used) = used {
        let target = Target::Macro(used.name.clone(), used.site.clone());
        return Some((used.range, target));
    }
    pre.directives.iter().find_map(|directive| match &directive.kind {
        DirectiveKind::Define(define) => {
            let name = define.name.as_ref()?;
            let site = MacroSite {
                file: Some(view.file.path(view.db).as_str().into()),
                ordinal: define.ordinal,
            };
            name.range
                .contains_inclusive(at)
                .then(|| (name.range, Target::Macro(name.text.clone(), Some(site))))
        }
        _ => None,
    })
}

/// The definition of a target; `None` for predefined macros.
pub(crate) fn nav_target(view: &FileView<'_>, target: &Target) -> Option<NavTarget> {
    match target {
        Target::Definition(id) => definition_target(view.db, view.unit, *id),
        Target::Macro(name, site) => {
            let site = site.as_ref()?;
            let path = camino::Utf8Path::new(site.file.as_ref()?.as_str());
            let file = view.db.file(path);
            let definition = define(view.db, file, site.ordinal)?;
            let focus = bytes(definition.name?.range);
            Some(NavTarget {
                path: file.path(view.db).clone(),
                full_range: focus.clone(),
                focus_range: focus,
                name: name.clone(),
                kind: SymbolKind::Macro,
                container: None,
            })
        }
        Target::File(file) => {
            let path = file.path(view.db);
            Some(NavTarget {
                path: path.clone(),
                full_range: 0..file.text(view.db).len(),
                focus_range: 0..0,
                name: path.file_name().unwrap_or_default().into(),
                kind: SymbolKind::File,
                container: None,
            })
        }
    }
}

/// The place of a definition of a unit.
pub(crate) fn definition_target<'db>(
    db: &'db dyn Db,
    unit: UnitKey<'db>,
    id: DefId,
) -> Option<NavTarget> {
    let elaborated = elaborated(db, unit);
    let definition = elaborated.definitions.get(id)?;
    let (file, focus) = place(db, unit, definition.src)?;
    let full = place(db, unit, definition.node).filter(|(in_file, _)| *in_file == file);
    let full = full.map_or(focus, |(_, full)| full.cover(focus));
    Some(NavTarget {
        path: file.path(db).clone(),
        full_range: bytes(full),
        focus_range: bytes(focus),
        name: definition.name.clone(),
        kind: definition.kind.into(),
        container: container_name(elaborated, definition),
    })
}

/// Name of the declaration that contains a definition.
pub(crate) fn container_name(elaborated: &Elaborated, definition: &Definition) -> Option<SmolStr> {
    Some(elaborated.definition(definition.container?).name.clone())
}

/// The identity of a definition, equal in every unit that contains it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct Identity {
    pub(crate) file: SourceFile,
    pub(crate) range: TextRange,
    pub(crate) name: SmolStr,
    pub(crate) kind: SymbolKind,
}

/// The identity of a definition of a unit.
pub(crate) fn identity<'db>(db: &'db dyn Db, unit: UnitKey<'db>, id: DefId) -> Option<Identity> {
    identity_in(db, unit, elaborated(db, unit), id)
}

/// [`identity`], for an elaborated unit.
pub(crate) fn identity_in<'db>(
    db: &'db dyn Db,
    unit: UnitKey<'db>,
    elaborated: &Elaborated,
    id: DefId,
) -> Option<Identity> {
    let definition = elaborated.definitions.get(id)?;
    let (file, range) = place(db, unit, definition.src)?;
    Some(Identity { file, range, name: definition.name.clone(), kind: definition.kind.into() })
}

/// The definitions of a unit with any of these identities.
pub(crate) fn find_identities<'db>(
    db: &'db dyn Db,
    unit: UnitKey<'db>,
    elaborated: &Elaborated,
    wanted: &[Identity],
) -> FxHashSet<DefId> {
    let found = elaborated
        .definitions
        .iter()
        .filter(|definition| wanted.iter().any(|wanted| wanted.name == definition.name))
        .filter(|definition| {
            let found = identity_in(db, unit, elaborated, definition.id);
            found.is_some_and(|identity| wanted.contains(&identity))
        });
    found.map(|definition| definition.id).collect()
}

/// Maximum number of units of a query whose results are cached. A query over more units caches none of them.
const MANY: usize = 32;

/// The elaboration of a unit, as one of `count` units of the same query.
pub(crate) fn elaborated_of_many<'db>(
    db: &'db dyn Db,
    unit: UnitKey<'db>,
    count: usize,
) -> Arc<Elaborated> {
    if count > MANY { Arc::new(elaborate(db, unit)) } else { elaborated(db, unit).clone() }
}

/// The declarations that `of` finds in each unit of the workspace. Those of a file that is included elsewhere
/// are found there. A large workspace is searched without keeping what was computed.
pub(super) fn over_units<T: Send>(
    db: &dyn Db,
    of: impl Fn(&dyn Db, UnitKey<'_>, &Elaborated) -> Vec<T> + Sync,
) -> Vec<T> {
    let paths = db.workspace().roots(db);
    let roots: Vec<SourceFile> = paths.iter().map(|path| db.file(path)).collect();
    let found = parallel::over(db, &roots, |db, &root| {
        if roots_of(db, root).first() != Some(&root) {
            return Vec::new();
        }
        let unit = unit_of_root(db, root);
        of(db, unit, &elaborated_of_many(db, unit, roots.len()))
    });
    found.into_iter().flatten().collect()
}
