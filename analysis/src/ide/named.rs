//! Declarations by qualified name.

use rustc_hash::FxHashSet;

use super::{NamedDeclaration, resolve::over_units, view::place};
use crate::{base::Db, elab::Elaborated, source_map::bytes, unit::UnitKey};

/// The declarations of all units whose qualified name ends with `names` (`["control", "start"]`), in order of
/// file and place. Without names, all declarations.
pub(crate) fn named(db: &dyn Db, names: &[&str]) -> Vec<NamedDeclaration> {
    let mut found = over_units(db, |db, unit, elaborated| of_unit(db, unit, elaborated, names));
    let mut seen = FxHashSet::default();
    found.retain(|declaration| {
        seen.insert((declaration.path.clone(), declaration.range.start, declaration.names.clone()))
    });
    found.sort_by(|a, b| (&a.path, a.range.start).cmp(&(&b.path, b.range.start)));
    found
}

fn of_unit(
    db: &dyn Db,
    unit: UnitKey<'_>,
    elaborated: &Elaborated,
    names: &[&str],
) -> Vec<NamedDeclaration> {
    let mut found = Vec::new();
    for declaration in &elaborated.definitions {
        let inside_out = || {
            let around = elaborated.containers(declaration);
            std::iter::once(declaration).chain(around).map(|part| part.name.as_str())
        };
        if !inside_out().take(names.len()).eq(names.iter().rev().copied()) {
            continue;
        }
        let Some((file, range)) = place(db, unit, declaration.src) else {
            continue;
        };
        let Some((_, full_range)) = place(db, unit, declaration.node) else {
            continue;
        };
        let mut qualified: Vec<String> = inside_out().map(str::to_owned).collect();
        qualified.reverse();
        found.push(NamedDeclaration {
            names: qualified,
            kind: declaration.kind.into(),
            path: file.path(db).clone(),
            range: bytes(range),
            full_range: bytes(full_range),
        });
    }
    found
}
