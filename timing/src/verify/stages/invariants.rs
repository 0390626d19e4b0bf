//! Answers by invariants: what never holds, without an exploration of the system.

use crate::explore::{Findings, Kind, Watch, search_once};
use crate::invariants::never_holds;
use crate::property::{Atom, Predicate, resolve};
use crate::report::{CheckReport, Layer, Report, Soundness, Verdict};
use crate::scn::ast::Pred;
use crate::verify::checks::{Single, What};
use crate::verify::group::Group;
use crate::verify::part::Part;

/// Limit on the actions of the random search for the parts of predicates: a proof about parts that never
/// become true says nothing.
const STEPS: u64 = 100_000;

/// The note of an answer.
const NOTE: &str = "by invariants, for any execution times";

/// Answers the checks of predicates that invariants prove, and whose parts become true.
pub(super) fn answer(part: &mut Part, report: &mut Report) {
    let group = part.group;
    let mut proved = part.open(report);
    proved.retain(|(_, check)| group.is_invariant(check));
    if proved.is_empty() {
        return;
    }
    let claims = proved.iter().filter_map(|(_, check)| group.claim(check));
    let absent = group.not_found(claims.collect());
    for (i, check) in proved {
        let claim = group.claim(check);
        let vacuous = claim.is_some_and(|claim| claim.is_vacuous(&|atom| absent.contains(atom)));
        // The exploration may find the parts later.
        if !vacuous {
            report.answer(i, group.by_invariants(check));
        }
    }
}

impl Group<'_> {
    /// Returns what a check claims to hold always.
    fn claim(&self, check: &Single) -> Option<Predicate> {
        match check.what {
            What::Always(pred) => self.predicate(pred),
            _ => None,
        }
    }

    /// Returns the predicate that holds in no state if invariants answer a check.
    pub(in crate::verify) fn excluded(&self, check: &Single) -> Option<Predicate> {
        match check.what {
            What::Reachable(pred) => self.predicate(pred),
            _ => (self.claim(check)).map(|claim| Predicate::Not(Box::new(claim))),
        }
    }

    fn predicate(&self, pred: &Pred) -> Option<Predicate> {
        resolve::resolve(self.names, self.built, pred).ok()
    }

    /// Returns the atoms of predicates that do not become true in a short random search.
    fn not_found(&self, claims: Vec<Predicate>) -> Vec<Atom> {
        let mut atoms: Vec<Atom> = Vec::new();
        for claim in claims {
            claim.atoms(&mut |atom| {
                if !atoms.contains(atom) {
                    atoms.push(atom.clone());
                }
            });
        }
        let watch = Watch {
            reach: atoms.iter().cloned().map(Predicate::Atom).collect(),
            ..Watch::default()
        };
        let system = &self.built.system;
        let found = search_once(system, &watch, (0, STEPS), self.limits, self.cancel);
        let reached = atoms.into_iter().zip(&found.reached);
        let absent = reached.filter(|(_, run)| run.is_none());
        absent.map(|(atom, _)| atom).collect()
    }

    /// Answers a check after an exploration that was given up.
    pub(super) fn after_all(&self, check: &Single, found: &Findings, out: &mut CheckReport) {
        if out.verdict != Verdict::Unknown || !self.is_invariant(check) {
            return;
        }
        let unseen = match check.what {
            What::Always(pred) => self.never_true(pred, found),
            _ => None,
        };
        *out = self.by_invariants(check);
        if let Some(unseen) = unseen {
            out.note = Some(format!("{NOTE}; in the states that were explored, {unseen}"));
        }
    }

    /// Returns true if invariants answer a check.
    fn is_invariant(&self, check: &Single) -> bool {
        !self.limits.without.contains(Kind::Invariants)
            && (self.excluded(check)).is_some_and(|bad| never_holds(&self.built.system, &bad))
    }

    fn by_invariants(&self, check: &Single) -> CheckReport {
        CheckReport {
            verdict: match check.what {
                What::Reachable(_) => Verdict::Refuted,
                _ => Verdict::Proved,
            },
            // Invariants do not depend on durations.
            conditions: self
                .built
                .conditions
                .iter()
                .filter(|condition| !condition.is_wcet())
                .cloned()
                .collect(),
            soundness: Soundness::Exact,
            by: Some(Layer::Invariants),
            note: Some(NOTE.to_owned()),
            ..self.blank(check)
        }
    }
}
