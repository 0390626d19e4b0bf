//! Elaboration and checks as queries over the database.
//!
//! [`elaborated`] depends on the item trees of a unit, and the checks of its components on that.

use std::sync::Arc;

use smol_str::SmolStr;
use typed_index_collections::ti_vec;

use crate::{
    base::Db,
    check,
    elab::{self, Elaborated, UnitInput},
    finding::Finding,
    item_tree::{Item, ItemTree, Ptr},
    lint,
    model::VisitId,
    requirement,
    unit::{UnitKey, item_tree, visits, walk::WalkId},
};

/// The elaboration of a unit. Cached only for the most recently used units: recomputing is cheaper than the
/// memory.
#[salsa::tracked(lru = 24)]
pub(crate) fn elaborated<'db>(db: &'db dyn Db, unit: UnitKey<'db>) -> Arc<Elaborated> {
    Arc::new(elaborate(db, unit))
}

/// The elaboration of a unit, computed now and not cached: for a query over very many units.
pub(crate) fn elaborate<'db>(db: &'db dyn Db, unit: UnitKey<'db>) -> Elaborated {
    let visits = visits(db, unit).all();
    let roots: Vec<WalkId> =
        visits.keys().filter(|&visit| visits[visit].includer.is_none()).collect();
    let wrapper = ItemTree {
        items: (0..roots.len() as u32)
            .map(|ordinal| Item::Include { ordinal, ptr: Ptr { item: ordinal, node: 0 } })
            .collect(),
    };
    let paths: Vec<SmolStr> =
        visits.iter().map(|visit| SmolStr::new(visit.key.file(db).path(db).as_str())).collect();
    let after_wrapper = |visit: WalkId| VisitId(visit.0 + 1);
    let mut input = ti_vec![elab::Visit {
        tree: &wrapper,
        file: u32::MAX,
        includes: roots.iter().map(|&root| Some(after_wrapper(root))).collect(),
        path: "",
    }];
    input.extend(visits.iter().zip(&paths).map(|(visit, path)| {
        elab::Visit {
            tree: item_tree(db, visit.key),
            file: visit.file_number,
            includes: visit
                .includes
                .iter()
                .map(|include| {
                    include.filter(|&include| visits[include].reached).map(after_wrapper)
                })
                .collect(),
            path,
        }
    }));
    db.unwind_if_revision_cancelled();
    elab::elaborate(&UnitInput {
        visits: &input,
        release: requirement::of_inputs(db, unit.inputs(db)).release,
    })
}

/// The findings of the elaboration of a unit.
#[salsa::tracked(lru = 0)]
pub(crate) fn elab_findings<'db>(db: &'db dyn Db, unit: UnitKey<'db>) -> Arc<Vec<Finding>> {
    Arc::new(elaborated(db, unit).diagnostics.clone())
}

/// Sets the maximum number of units with cached results.
pub(crate) fn keep(db: &mut dyn Db, count: usize) {
    elab_findings::set_lru_capacity(db, count);
    body_findings::set_lru_capacity(db, count);
}

/// The findings at the ends of the bodies of a unit.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct BodyFindings {
    /// Those of the checks, body by body.
    pub(crate) checks: Vec<Finding>,
    /// Those of the lints, component by component, after all of each was read.
    pub(crate) lints: Vec<Finding>,
}

/// Checks the bodies of a unit.
#[salsa::tracked(lru = 0)]
pub(crate) fn body_findings<'db>(db: &'db dyn Db, unit: UnitKey<'db>) -> Arc<BodyFindings> {
    let Elaborated { spec, closings, .. } = &**elaborated(db, unit);
    let mut found = BodyFindings::default();
    for (index, end) in closings.iter().enumerate() {
        db.unwind_if_revision_cancelled();
        let last = spec.components.get(end.component);
        let Some(component) = end.snapshot.as_deref().or(last) else {
            continue;
        };
        found.checks.extend(check::component(spec, component));
        let later = &closings[index + 1..];
        if end.snapshot.is_none() && later.iter().all(|that| that.component != end.component) {
            found.lints.extend(lint::component(spec, component, db.workspace().lints(db)));
        }
    }
    Arc::new(found)
}

/// Declarations of the root files of a unit that nothing uses.
#[salsa::tracked]
pub(crate) fn lint_unused<'db>(db: &'db dyn Db, unit: UnitKey<'db>) -> Arc<Vec<Finding>> {
    let visits = visits(db, unit);
    let is_root = |visit: VisitId| visits.of(visit).is_some_and(|visit| visit.includer.is_none());
    Arc::new(lint::unused(elaborated(db, unit), is_root))
}
