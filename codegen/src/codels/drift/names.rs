//! Invalid uses in the body of a codel: names that are no longer declared, and writes to read-only values.

use std::cell::OnceCell;

use dotgen_analysis::model::{Name, TypeKind};
use rustc_hash::FxHashSet;

use super::finding::Difference;
use super::{Check, Drift, FunctionIn};

/// Names that parameters of the component's codels have or could have, computed once.
pub(super) type KnownNames = OnceCell<FxHashSet<Name>>;

pub(super) fn check(
    check: &Check<'_>,
    definitions: &[FunctionIn<'_>],
    known: &KnownNames,
    out: &mut Vec<Drift>,
) {
    for found in definitions {
        let body = found.function.body.as_ref();
        let Some(body) = body.filter(|body| !body.broken) else {
            continue;
        };
        let name = || check.function.name.clone();
        for (used, span) in &body.free {
            // Any header may declare a name that is not in the specification.
            if !known.get_or_init(|| named(check)).contains(used.as_str())
                || is_declared(check, used)
            {
                continue;
            }
            let kind = Difference::NoName { function: name(), name: used.as_str().into() };
            out.push(Drift { source: Some(found.at(span.clone())), ..check.drift(kind) });
        }
        for (parameter, span) in &body.constant_writes {
            let kind = Difference::ConstantWrite {
                function: name(),
                parameter: parameter.as_str().into(),
            };
            out.push(Drift { source: Some(found.at(span.clone())), ..check.drift(kind) });
        }
    }
}

/// Names that parameters of codels and services have, or could have: members of the IDS.
fn named(check: &Check<'_>) -> FxHashSet<Name> {
    let component = check.expected.component();
    let mut out: FxHashSet<Name> = FxHashSet::default();
    for at in component.all_codels() {
        out.extend(component.codel(at).params.iter().map(|param| param.name.clone()));
    }
    for service in &component.services {
        out.extend(service.params.iter().map(|param| param.name.clone()));
    }
    let spec = check.expected.spec;
    let members = component.ids.map(|ty| &spec.ty(ty).kind);
    let names = match members {
        Some(TypeKind::Struct { members }) => members.as_slice(),
        _ => &[],
    }
    .iter();
    out.extend(names.filter_map(|&name| spec.ty(name).name.clone()));
    out
}

/// True if a source or header of the folder declares a name, or may declare it.
fn is_declared(check: &Check<'_>, name: &str) -> bool {
    let mut files = check.sources.all();
    files.any(|file| {
        let index = file.index();
        index.names.contains(name)
            || index.loose.contains(name)
            || index.macros.iter().any(|definition| definition.name == name)
    })
}
