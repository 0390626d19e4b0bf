//! Declarations nobody uses.

use rustc_hash::FxHashSet;

use crate::elab::{DefKind, ElabDiagnostic, Elaborated};
use crate::model::TypeKind;

use super::codes;

/// Reports unused types, natives, exceptions and local variables that are declared in
/// a root file of a unit (by visit; what other files declare is for others to use), inside a component.
pub fn unused(unit: &Elaborated, is_root: impl Fn(u32) -> bool) -> Vec<ElabDiagnostic> {
    let used: FxHashSet<u32> = unit
        .references
        .iter()
        .filter(|r| !r.declaration)
        .map(|r| r.target.0)
        .collect();
    let mut out = Vec::new();
    for definition in &unit.definitions {
        let (code, what) = match definition.kind {
            DefKind::Exception => ("unused/exception", "exception"),
            DefKind::Native => ("unused/type", "native type"),
            DefKind::Typedef | DefKind::Struct | DefKind::Union | DefKind::Enum => {
                ("unused/type", "type")
            }
            DefKind::Local => ("unused/local", "local variable"),
            _ => continue,
        };
        if used.contains(&definition.id.0) || !is_root(definition.src.visit) {
            continue;
        }
        // Types outside components are there to be included.
        let inside = definition.container.map(|c| unit.definition(c).kind);
        let private = match definition.kind {
            DefKind::Local => true,
            _ => inside == Some(DefKind::Component),
        };
        if !private || enumerators_used(unit, definition.ty, &used) {
            continue;
        }
        let severity = codes::find(code).map_or(crate::elab::Severity::Hint, |c| c.severity);
        let verb = if definition.kind == DefKind::Exception {
            "thrown"
        } else {
            "used"
        };
        out.push(ElabDiagnostic {
            code,
            severity,
            message: format!("{what} `{}` is never {verb}", definition.name),
            at: definition.src,
            related: Vec::new(),
            fix: None,
        });
    }
    out
}

/// An enum counts as used when one of its values is.
fn enumerators_used(
    unit: &Elaborated,
    ty: Option<crate::model::TypeId>,
    used: &FxHashSet<u32>,
) -> bool {
    let Some(ty) = ty else { return false };
    let TypeKind::Enum { enumerators } = &unit.spec.ty(ty).kind else {
        return false;
    };
    unit.definitions.iter().any(|d| {
        d.kind == DefKind::Enumerator
            && d.ty.is_some_and(|t| enumerators.contains(&t))
            && used.contains(&d.id.0)
    })
}
