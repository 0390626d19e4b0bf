//! The reductions that the explorations of a verification used, and the reasons against the others.

use crate::abstraction::Refusal;
use crate::explore::{Activity, Kind, Reason};

/// The use of each reduction, over all explorations.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ReductionUse {
    /// Number of explorations.
    pub explorations: usize,
    /// The outcomes of schedule abstraction before the explorations, each with its count: used, or refused.
    pub abstractions: Vec<(Option<Refusal>, usize)>,
    /// Tasks without bounds of schedule abstraction, in systems in which other tasks have bounds.
    pub left_open: Vec<(String, Refusal)>,
    /// Reductions, in the order of their first occurrence.
    pub reductions: Vec<UseOfReduction>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UseOfReduction {
    /// Kind of the reduction.
    pub kind: Kind,
    /// Number of explorations in which it was used.
    pub used: usize,
    /// Reasons for not using it, each with the number of explorations.
    pub off: Vec<(Reason, usize)>,
}

impl ReductionUse {
    /// Adds an exploration.
    pub(crate) fn add(&mut self, activities: &[Activity]) {
        self.explorations += 1;
        for activity in activities {
            let known = self.reductions.iter().position(|all| all.kind == activity.kind);
            let at = known.unwrap_or_else(|| {
                self.reductions.push(UseOfReduction {
                    kind: activity.kind,
                    used: 0,
                    off: Vec::new(),
                });
                self.reductions.len() - 1
            });
            let all = &mut self.reductions[at];
            let Some(reason) = activity.off else {
                all.used += 1;
                continue;
            };
            match all.off.iter_mut().find(|(known, _)| *known == reason) {
                Some((_, count)) => *count += 1,
                None => all.off.push((reason, 1)),
            }
        }
    }

    /// Adds a system that schedule abstraction treated or refused.
    pub(crate) fn add_abstraction(&mut self, off: Option<Refusal>) {
        match self.abstractions.iter_mut().find(|abstraction| abstraction.0 == off) {
            Some((_, count)) => *count += 1,
            None => self.abstractions.push((off, 1)),
        }
    }

    fn abstraction(&self) -> Option<(&'static str, String)> {
        let all: usize = self.abstractions.iter().map(|abstraction| abstraction.1).sum();
        let parts = self.abstractions.iter().map(|(off, count)| {
            let part = match count {
                count if *count == all => String::new(),
                count => format!(" in {count} of {all} parts"),
            };
            match off {
                None => format!("used{part}"),
                Some(reason) => format!("not used{part}: {reason}"),
            }
        });
        let open = self.left_open.iter();
        let open = open.map(|(task, reason)| format!("not for {task}: {reason}"));
        let parts: Vec<String> = parts.chain(open).collect();
        (all > 0).then(|| (Kind::ScheduleAbstraction.name(), parts.join("; ")))
    }

    /// Returns one line for each reduction: its name, and how often it was used or why not.
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        let line = |reduction: &UseOfReduction| {
            let mut parts = Vec::new();
            match reduction.used {
                0 => {}
                n if n == self.explorations => parts.push("used".to_owned()),
                n => parts.push(format!("used in {n} of {} explorations", self.explorations)),
            }
            for (reason, count) in &reduction.off {
                parts.push(if *count == self.explorations {
                    format!("not used: {reason}")
                } else {
                    format!("not used in {count} of {}: {reason}", self.explorations)
                });
            }
            (reduction.kind.name(), parts.join("; "))
        };
        let lines = self.reductions.iter().map(line);
        self.abstraction().into_iter().chain(lines).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn explorations_that_differ_are_counted() {
        let activity = |kind, off| Activity { kind, off };
        let mut all = ReductionUse::default();
        all.add(&[
            activity(Kind::SleepSets, Some(Reason::Clients)),
            activity(Kind::RestingLoops, None),
            activity(Kind::Deferral, None),
        ]);
        all.add(&[
            activity(Kind::SleepSets, Some(Reason::Clients)),
            activity(Kind::RestingLoops, None),
            activity(Kind::Deferral, Some(Reason::SwitchedOff)),
        ]);
        let lines = [
            ("sleep-sets", "not used: there are clients"),
            ("resting-loops", "used"),
            ("deferral", "used in 1 of 2 explorations; not used in 1 of 2: switched off"),
        ];
        assert_eq!(all.lines(), lines.map(|(name, line)| (name, line.to_owned())));
    }
}
