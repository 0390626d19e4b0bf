//! Named declarations of all units of the workspace.

use std::cmp::Reverse;

use rustc_hash::FxHashSet;
use smol_str::SmolStr;

use super::{FileRange, WorkspaceSymbol, resolve::container_name, view::place};
use crate::{
    base::Db,
    elab::DefKind,
    queries::elaborated,
    source_map::bytes,
    unit::{roots_of, unit_of_root},
};

/// The best `limit` declarations that match a query.
pub(crate) fn workspace_symbols(db: &dyn Db, query: &str, limit: usize) -> Vec<WorkspaceSymbol> {
    let mut found: Vec<(Reverse<u8>, SmolStr, WorkspaceSymbol)> = Vec::new();
    let mut seen = FxHashSet::default();
    for path in db.workspace().roots(db) {
        let root = db.file(path);
        // A file that is included elsewhere is listed there.
        if roots_of(db, root).first() != Some(&root) {
            continue;
        }
        let unit = unit_of_root(db, root);
        let elaborated = elaborated(db, unit);
        for it in &elaborated.definitions {
            if !is_listed(it.kind) {
                continue;
            }
            let Some(rank) = rank(&it.name, query) else {
                continue;
            };
            let Some((file, range)) = place(db, unit, it.src) else {
                continue;
            };
            if seen.insert((file, range, it.name.clone())) {
                let symbol = WorkspaceSymbol {
                    name: it.name.clone(),
                    kind: it.kind.into(),
                    container: container_name(&elaborated.definitions, it),
                    target: FileRange {
                        path: file.path(db).clone(),
                        range: bytes(range),
                    },
                };
                found.push((Reverse(rank), it.name.clone(), symbol));
            }
        }
    }
    found.sort_by(|a, b| {
        let place = |it: &WorkspaceSymbol| (it.target.path.clone(), it.target.range.start);
        (a.0, &a.1, place(&a.2)).cmp(&(b.0, &b.1, place(&b.2)))
    });
    found.truncate(limit);
    found.into_iter().map(|(.., it)| it).collect()
}

/// Returns false for parameters and local variables, which are not listed outside their service.
fn is_listed(kind: DefKind) -> bool {
    !matches!(
        kind,
        DefKind::Parameter | DefKind::Local | DefKind::CodelParameter
    )
}

/// The quality of a match: equal, prefix, substring, scattered; `None` without a match.
fn rank(name: &str, query: &str) -> Option<u8> {
    let lower = name.to_lowercase();
    let query = query.to_lowercase();
    if lower == query {
        return Some(4);
    }
    if lower.starts_with(&query) {
        return Some(3);
    }
    if lower.contains(&query) {
        return Some(2);
    }
    let mut letters = lower.chars();
    query
        .chars()
        .all(|wanted| letters.any(|it| it == wanted))
        .then_some(1)
}

#[cfg(test)]
mod tests {
    use super::rank;

    #[test]
    fn ranks() {
        assert_eq!(rank("Goto", "goto"), Some(4));
        assert_eq!(rank("GotoPosition", "goto"), Some(3));
        assert_eq!(rank("do_goto", "goto"), Some(2));
        assert_eq!(rank("grow", "goto"), None);
        assert_eq!(rank("go_to", "goto"), Some(1));
        assert_eq!(rank("anything", ""), Some(3));
    }
}
