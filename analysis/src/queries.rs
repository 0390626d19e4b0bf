//! Elaboration and checks as queries over the database.
//!
//! [`elaborated`] depends on the item trees of a unit. The checks of each body run behind a [`BodyView`]: the
//! body with the part of the model it can see, renumbered, so that an edit in one component leaves the views
//! of the others equal.

use std::sync::Arc;

use smol_str::SmolStr;

use crate::{
    base::Db,
    body_view::BodyView,
    check,
    elab::{self, Elaborated, UnitInput},
    finding::Finding,
    item_tree::{Item, ItemTree, Ptr},
    lint,
    model::Component,
    requirement,
    unit::{UnitKey, item_tree, visits},
};

/// Visit index of the wrapper in the elaborator; the visits of the unit follow.
pub(crate) const WRAPPER: u32 = 0;

/// The elaboration of a unit. Cached only for the most recently used units: recomputing is cheaper than the
/// memory.
#[salsa::tracked(lru = 24)]
pub(crate) fn elaborated<'db>(db: &'db dyn Db, unit: UnitKey<'db>) -> Arc<Elaborated> {
    Arc::new(elaborate(db, unit))
}

/// The elaboration of a unit, computed now and not cached: for a query over very many units.
pub(crate) fn elaborate<'db>(db: &'db dyn Db, unit: UnitKey<'db>) -> Elaborated {
    let visits = &visits(db, unit).visits;
    let roots: Vec<u32> = (0..visits.len() as u32)
        .filter(|&index| visits[index as usize].includer.is_none())
        .collect();
    let wrapper = ItemTree {
        items: (0..roots.len() as u32)
            .map(|ordinal| Item::Include { ordinal, ptr: Ptr { item: ordinal, node: 0 } })
            .collect(),
    };
    let paths: Vec<SmolStr> =
        visits.iter().map(|visit| SmolStr::new(visit.key.file(db).path(db).as_str())).collect();
    let after_wrapper = |visit: u32| visit + 1;
    let mut input = vec![elab::Visit {
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
                    include.filter(|&include| visits[include as usize].reached).map(after_wrapper)
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

/// Sets the maximum number of units and bodies with cached results.
pub(crate) fn keep(db: &mut dyn Db, count: usize) {
    elab_findings::set_lru_capacity(db, count);
    check_body::set_lru_capacity(db, count);
    lint_body::set_lru_capacity(db, count);
}

/// Number of bodies to check.
#[salsa::tracked(returns(copy))]
pub(crate) fn body_count<'db>(db: &'db dyn Db, unit: UnitKey<'db>) -> u32 {
    elaborated(db, unit).closings.len() as u32
}

/// The part of the model that the checks of one body can see.
#[salsa::tracked(lru = 24)]
pub(crate) fn body_view<'db>(db: &'db dyn Db, unit: UnitKey<'db>, body: u32) -> Arc<BodyView> {
    let elaborated = elaborated(db, unit);
    let spec = &elaborated.spec;
    let none = || Arc::new(BodyView::default());
    let Some(closing) = elaborated.closings.get(body as usize) else {
        return none();
    };
    let component: Option<&Component> = match &closing.snapshot {
        Some(snapshot) => Some(snapshot),
        None => spec.components.get(closing.component as usize),
    };
    match component {
        Some(component) => Arc::new(BodyView::new(spec, closing.component, component)),
        None => none(),
    }
}

/// The lints of one component, after all of it was read. Empty for a body that is reopened later.
#[salsa::tracked(lru = 0)]
pub(crate) fn lint_body<'db>(db: &'db dyn Db, unit: UnitKey<'db>, body: u32) -> Arc<Vec<Finding>> {
    if !is_last_body(db, unit, body) {
        return Arc::default();
    }
    let view = body_view(db, unit, body);
    Arc::new(match view.component() {
        Some(component) => lint::component(&view.spec, component, db.workspace().lints(db)),
        None => Vec::new(),
    })
}

/// Returns true if a component is not reopened after a body.
#[salsa::tracked(returns(copy))]
fn is_last_body<'db>(db: &'db dyn Db, unit: UnitKey<'db>, body: u32) -> bool {
    let closings = &elaborated(db, unit).closings;
    closings.get(body as usize).is_some_and(|end| {
        let later = &closings[body as usize + 1..];
        end.snapshot.is_none() && later.iter().all(|that| that.component != end.component)
    })
}

/// Declarations of the root files of a unit that nothing uses.
#[salsa::tracked]
pub(crate) fn lint_unused<'db>(db: &'db dyn Db, unit: UnitKey<'db>) -> Arc<Vec<Finding>> {
    let visits = &visits(db, unit).visits;
    let is_root = |visit: u32| {
        let visit = visit.checked_sub(WRAPPER + 1).and_then(|index| visits.get(index as usize));
        visit.is_some_and(|visit| visit.includer.is_none())
    };
    Arc::new(lint::unused(elaborated(db, unit), is_root))
}

/// The diagnostics of one body.
#[salsa::tracked(lru = 0)]
pub(crate) fn check_body<'db>(db: &'db dyn Db, unit: UnitKey<'db>, body: u32) -> Arc<Vec<Finding>> {
    let view = body_view(db, unit, body);
    Arc::new(match view.component() {
        Some(component) => check::component(&view.spec, component),
        None => Vec::new(),
    })
}
