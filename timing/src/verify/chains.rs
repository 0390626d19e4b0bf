//! Checks of cause-effect chains: reaction time and data age (section 19).

use super::answers::exceeded;
use super::checks::{ChainOf, Single};
use super::group::Group;
use super::units::limit_text;
use crate::analytic::reaction_bound;
use crate::explore::{Measured, explore_chain, is_exact};
use crate::report::{CheckReport, Report, Soundness, Verdict};
use crate::system::CodelId;
use crate::system::chain::ChainKind;
use crate::system::flow::{self, FoundChain};

impl Group<'_> {
    /// Answers a check of a chain by exploring the chain with one token.
    pub(super) fn chain(&self, check: &Single, of: ChainOf, report: &mut Report) -> CheckReport {
        let mut out = self.blank(check);
        let Ok(chain) = flow::chain(self.names, self.settings, self.built, &of.asked()) else {
            return out;
        };
        let system = &self.built.system;
        let limit = self.ticks(of.bound);
        let found = explore_chain(system, &chain.chain, limit, self.limits, self.cancel);
        report.effort(&found);
        let measured: Option<Measured> = found.within.first().cloned().flatten();
        let never = "the first datum is never written";
        self.bounded(&measured, never, &found, &mut out);
        self.set_spent(&found.chain.late, (&found.chain.cycle, &found.chain.codels), &mut out);
        let end = exceeded(&measured).filter(|_| !out.rounded);
        if let (Some(end), Some(limit)) = (end, of.bound) {
            let (from, to) = (of.path.from.text(), of.path.to.text());
            let limit = limit_text(limit);
            let what = match of.kind {
                ChainKind::Reaction => {
                    format!("`{to}` has not been written from the `{from}` of {limit} ago")
                }
                ChainKind::Age => format!("`{to}` depends on a `{from}` of more than {limit} ago"),
            };
            let event = self.excess_event(end, self.last_component(check), what);
            out.counterexample.push(event);
        }
        if measured.is_some_and(|value| !is_exact(system, &chain.chain, value.bound)) {
            // The age reached the counting limit: the value is a lower bound.
            if out.verdict == Verdict::Proved {
                out.verdict = Verdict::Unknown;
            }
            out.note = Some("the age is at least this, and was not counted any further".to_owned());
        }
        if out.verdict == Verdict::Unknown
            && of.kind == ChainKind::Reaction
            && let Some(bound) = reaction_bound(system, &chain.ways)
        {
            let within = limit.is_none_or(|limit| bound <= limit);
            let by = ("periods and response times along the chain", "it takes");
            self.bounded_by(by, bound, within, &mut out);
        }
        let ways = self.ways(&chain);
        out.note = Some(match out.note.take() {
            Some(note) => format!("{note}; {ways}"),
            None => ways,
        });
        // If a codel is preempted, its remaining time need not be a whole number of units.
        if out.verdict == Verdict::Refuted && out.soundness == Soundness::WholeUnits {
            out.soundness = Soundness::Exact;
        }
        out
    }

    /// Returns the paths of the data, in words.
    fn ways(&self, found: &FoundChain) -> String {
        let codels = &self.built.system.codels;
        let one = |way: &Vec<CodelId>| {
            let names: Vec<&str> = way.iter().map(|&codel| &*codels[codel].path).collect();
            names.join(" → ")
        };
        let ways: Vec<String> = found.ways.iter().map(one).collect();
        if let ([way], false) = (&ways[..], found.more) {
            format!("by {way}")
        } else {
            let more = if found.more { ", and more" } else { "" };
            let all = ways.join("; ");
            format!("by any of these ways{more} (`via` chooses): {all}")
        }
    }
}
