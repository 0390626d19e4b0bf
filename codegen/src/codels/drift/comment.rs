//! Outdated comments of the skeleton.

use dotgen_analysis::model::{CodelKind, CodelRef};

use super::finding::{Clauses, Difference};
use super::{Check, Drift, FunctionIn, Repair};
use crate::codels::{
    expected::{cut_tag, owner_words, state_text},
    source::Generated,
};
use crate::lang::text;

pub(super) fn check(check: &Check<'_>, definitions: &[FunctionIn<'_>], out: &mut Vec<Drift>) {
    for found in definitions {
        for (distance, comment) in found.function.comments.iter().enumerate() {
            let Some(generated) = &comment.generated else {
                continue;
            };
            let Some(at) = described_use(check, generated, distance == 0) else {
                continue;
            };
            let wrong = false_statements(check, at, generated);
            if wrong.is_empty() {
                continue;
            }
            let codel = check.expected.component().codel(at);
            let mut drift = check.drift(Difference::StaleComment {
                codel: codel.name.clone(),
                wrong: Clauses(wrong),
            });
            drift.spec = vec![codel.src];
            drift.source = Some(found.at(comment.span.clone()));
            if !may_throw_more(check) {
                drift.repairs.push(Repair::RefreshComment {
                    at,
                    path: found.file.path.clone(),
                    start: comment.span.start,
                });
            }
            out.push(drift);
        }
    }
}

/// The use of a codel that a comment describes. A codel with several uses has a comment for each. The
/// comments of later uses have no function: the next declaration follows them.
fn described_use(check: &Check<'_>, comment: &Generated, nearest: bool) -> Option<CodelRef> {
    let component = check.expected.component();
    let owner = |codel: &&CodelRef| owner_words(component, codel.owner).1 == comment.owner.as_str();
    if let Some(other) = check.expected.function(&comment.codel)
        && other.name != check.function.name
    {
        return other.uses.iter().find(owner).copied();
    }
    let about_this = comment.codel == check.function.name || nearest;
    let uses = check.function.uses.iter();
    let found = uses.clone().find(owner).or(check.function.uses.first());
    found.copied().filter(|_| about_this)
}

/// True if the known part of the specification may lack exceptions.
fn may_throw_more(check: &Check<'_>) -> bool {
    check.function.may_throw_more || check.options.trust.lacks_text
}

/// The incorrect statements of a comment.
fn false_statements(check: &Check<'_>, at: CodelRef, comment: &Generated) -> Vec<String> {
    let expected = check.expected;
    let component = expected.component();
    let codel = component.codel(at);
    let mut out = Vec::new();
    let (kind, owner) = owner_words(component, at.owner);
    // Older skeletons write "service" for every kind.
    let same_kind = comment.owner_kind == kind || comment.owner_kind == "service" && kind != "task";
    if comment.codel != codel.name
        || comment.owner != *owner
        || !same_kind
        || comment.validation != (codel.kind == CodelKind::Validate)
    {
        let validation = match codel.kind {
            CodelKind::Validate => "validation codel",
            _ => "codel",
        };
        out.push(format!("it is now {validation} `{}` of {kind} `{owner}`", codel.name));
    }
    if comment.triggers.is_none() && comment.yields.is_none() && comment.throws.is_none() {
        return out;
    }
    let states = |all: &[dotgen_analysis::model::State]| -> Vec<String> {
        all.iter().map(state_text).collect()
    };
    let throws = expected.throws_of(at.owner);
    let throws: Vec<String> = throws
        .into_iter()
        .map(|exception| {
            let name = expected.spec.full_name(exception).unwrap_or_default();
            text::c_name(cut_tag(&name, &component.name).1)
        })
        .collect();
    let mut sentence = |is: &[String], said: &Option<Vec<smol_str::SmolStr>>, words: &str| {
        let said = said.as_deref().unwrap_or_default().iter().map(|text| {
            let (paused, name) = cut_tag(text, &component.name);
            let name = text::c_name(name);
            if paused { format!("pause::{name}") } else { name }
        });
        let mut said: Vec<String> = said.collect();
        let mut now = is.to_vec();
        now.sort();
        now.dedup();
        said.sort();
        said.dedup();
        if now != said {
            let list = if is.is_empty() { "nothing".into() } else { is.join(", ") };
            out.push(format!("it now {words} {list}"));
        }
    };
    if codel.kind == CodelKind::Fsm {
        sentence(&states(&codel.triggers), &comment.triggers, "is triggered by");
        sentence(&states(&codel.yields), &comment.yields, "yields to");
    }
    if !may_throw_more(check) {
        sentence(&throws, &comment.throws, "throws");
    }
    out
}
