//! Declarations by qualified name.

use rustc_hash::FxHashSet;

use super::{NamedDeclaration, resolve::elaborated_of_many, view::place};
use crate::{
    base::{Db, SourceFile},
    elab::{DefId, Definition},
    parallel,
    source_map::bytes,
    unit::{roots_of, unit_of_root},
};

/// The declarations of all units whose qualified name ends with `names` (`["control", "start"]`), in order of
/// file and place. Without names, all declarations.
pub(crate) fn named(db: &dyn Db, names: &[&str]) -> Vec<NamedDeclaration> {
    let workspace = db.workspace();
    let paths = workspace.roots(db);
    let roots: Vec<SourceFile> = paths.iter().map(|path| db.file(path)).collect();
    let found = parallel::over(db, &roots, |db, &root| {
        // The declarations of a file that is included elsewhere are found there.
        if roots_of(db, root).first() == Some(&root) {
            of_unit(db, root, names, roots.len())
        } else {
            Vec::new()
        }
    });
    let mut found: Vec<NamedDeclaration> = found.into_iter().flatten().collect();
    let mut seen = FxHashSet::default();
    found.retain(|declaration| {
        seen.insert((declaration.path.clone(), declaration.range.start, declaration.names.clone()))
    });
    found.sort_by(|a, b| (&a.path, a.range.start).cmp(&(&b.path, b.range.start)));
    found
}

fn of_unit(db: &dyn Db, root: SourceFile, names: &[&str], units: usize) -> Vec<NamedDeclaration> {
    let unit = unit_of_root(db, root);
    let elaborated = elaborated_of_many(db, unit, units);
    let all = &elaborated.definitions;
    let mut found = Vec::new();
    for declaration in all.iter().filter(|definition| has_name(all, definition, names)) {
        let Some((file, range)) = place(db, unit, declaration.src) else {
            continue;
        };
        let Some((_, full_range)) = place(db, unit, declaration.node) else {
            continue;
        };
        found.push(NamedDeclaration {
            names: names_of(all, declaration),
            kind: declaration.kind.into(),
            path: file.path(db).clone(),
            range: bytes(range),
            full_range: bytes(full_range),
        });
    }
    found
}

/// Returns true if the qualified name of a declaration ends with `names`.
fn has_name(all: &[Definition], declaration: &Definition, names: &[&str]) -> bool {
    let mut declaration = Some(declaration);
    for name in names.iter().rev() {
        match declaration {
            Some(definition) if definition.name == *name => {
                declaration = definition.container.and_then(|container| at(all, container));
            }
            _ => return false,
        }
    }
    true
}

/// The names of a declaration and of those that contain it, outermost first.
fn names_of(all: &[Definition], declaration: &Definition) -> Vec<String> {
    let mut names = vec![declaration.name.to_string()];
    let mut container = declaration.container;
    while let Some(definition) = container.and_then(|container| at(all, container)) {
        names.push(definition.name.to_string());
        container = definition.container;
    }
    names.reverse();
    names
}

fn at(all: &[Definition], id: DefId) -> Option<&Definition> {
    all.get(id.0 as usize)
}
