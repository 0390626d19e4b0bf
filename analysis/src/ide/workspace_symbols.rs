//! Named declarations of all units of the workspace.

use std::cmp::Reverse;

use rustc_hash::FxHashSet;
use smol_str::SmolStr;

use super::{
    FileRange, WorkspaceSymbol,
    resolve::{container_name, over_units},
    view::place,
};
use crate::{
    base::Db,
    elab::{DefKind, Elaborated},
    source_map::bytes,
    unit::UnitKey,
};

/// A declaration and how well it matches, as it is sorted.
type Ranked = (Reverse<u8>, SmolStr, WorkspaceSymbol);

/// The best `limit` declarations that match a query.
pub(crate) fn workspace_symbols(db: &dyn Db, query: &str, limit: usize) -> Vec<WorkspaceSymbol> {
    let mut found = over_units(db, |db, unit, elaborated| {
        let mut found = of_unit(db, unit, elaborated, query);
        best(&mut found, limit);
        found
    });
    let mut seen = FxHashSet::default();
    found.retain(|(.., symbol)| {
        let place = &symbol.target;
        seen.insert((place.path.clone(), place.range.clone(), symbol.name.clone()))
    });
    best(&mut found, limit);
    found.into_iter().map(|(.., symbol)| symbol).collect()
}

/// Keeps the first `limit` of the sorted list.
fn best(found: &mut Vec<Ranked>, limit: usize) {
    let place = |symbol: &WorkspaceSymbol| (symbol.target.path.clone(), symbol.target.range.start);
    found.sort_by(|a, b| (a.0, &a.1, place(&a.2)).cmp(&(b.0, &b.1, place(&b.2))));
    found.truncate(limit);
}

/// The declarations of a unit that match a query.
fn of_unit(db: &dyn Db, unit: UnitKey<'_>, elaborated: &Elaborated, query: &str) -> Vec<Ranked> {
    let mut found = Vec::new();
    for definition in elaborated.definitions.iter().filter(|definition| is_listed(definition.kind))
    {
        let Some(rank) = rank(&definition.name, query) else {
            continue;
        };
        let Some((file, range)) = place(db, unit, definition.src) else {
            continue;
        };
        let symbol = WorkspaceSymbol {
            name: definition.name.clone(),
            kind: definition.kind.into(),
            container: container_name(elaborated, definition),
            target: FileRange { path: file.path(db).clone(), range: bytes(range) },
        };
        found.push((Reverse(rank), definition.name.clone(), symbol));
    }
    found
}

/// Returns false for parameters and local variables, which are not listed outside their service.
fn is_listed(kind: DefKind) -> bool {
    !matches!(kind, DefKind::Parameter | DefKind::Local | DefKind::CodelParameter)
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
    query.chars().all(|wanted| letters.any(|letter| letter == wanted)).then_some(1)
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
