//! Unused declarations.

use rustc_hash::FxHashSet;

use crate::elab::{DefId, DefKind, Elaborated};
use crate::finding::{Finding, lints::LintWarning};
use crate::model::{TypeKind, VisitId};

/// Reports unused types, natives, exceptions and local variables that are declared in a root file of a unit,
/// inside a component. `is_root` returns true for the visits of root files; declarations in other files are
/// for other units.
pub fn unused(unit: &Elaborated, is_root: impl Fn(VisitId) -> bool) -> Vec<Finding> {
    let used: FxHashSet<DefId> =
        unit.references.iter().filter(|r| !r.is_declaration()).map(|r| r.target).collect();
    let mut out = Vec::new();
    for definition in &unit.definitions {
        let name = definition.name.clone();
        let kind = match definition.kind {
            DefKind::Exception => LintWarning::NeverThrown { name },
            DefKind::Native => LintWarning::TypeUnused { what: "native type", name },
            DefKind::Typedef | DefKind::Struct | DefKind::Union | DefKind::Enum => {
                LintWarning::TypeUnused { what: "type", name }
            }
            DefKind::Local => LintWarning::LocalUnused { name },
            _ => continue,
        };
        if used.contains(&definition.id) || !is_root(definition.src.visit) {
            continue;
        }
        // Types outside of components may be included by other files.
        let inside = definition.container.map(|c| unit.definition(c).kind);
        let private = match definition.kind {
            DefKind::Local => true,
            _ => inside == Some(DefKind::Component),
        };
        if !private || enumerators_used(unit, definition.ty, &used) {
            continue;
        }
        out.push(Finding::new(kind, definition.src));
    }
    out
}

/// Returns true if a type is an enum and one of its values is used.
fn enumerators_used(
    unit: &Elaborated,
    ty: Option<crate::model::TypeId>,
    used: &FxHashSet<DefId>,
) -> bool {
    let Some(ty) = ty else { return false };
    let TypeKind::Enum { enumerators } = &unit.spec.ty(ty).kind else {
        return false;
    };
    unit.definitions.iter().any(|d| {
        d.kind == DefKind::Enumerator
            && d.ty.is_some_and(|t| enumerators.contains(&t))
            && used.contains(&d.id)
    })
}
