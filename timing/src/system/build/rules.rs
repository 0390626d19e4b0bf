//! What the scenario says of single tasks, machines and services: idle ticks, loop limits, slots.

use std::ops::Range;

use dotgen_analysis::model::Owner;

use super::{Builder, not_a};
use crate::scn::Diagnostic;
use crate::scn::names::Target;

impl Builder<'_> {
    pub(super) fn idle_rule(&mut self, c: usize, t: u32) -> bool {
        let mut keep = false;
        for (rule, path) in &self.settings.idle {
            match path {
                None => keep = *rule,
                Some(path) => match self.names.resolve(path) {
                    Ok(Target::Task(a, b)) if (a, b) == (c, t) => keep = *rule,
                    Ok(Target::Component(a)) if a == c => keep = *rule,
                    Ok(Target::Task(..) | Target::Component(_)) => {}
                    Ok(_) => self.report(not_a("task", path)),
                    Err(error) => self.report(error),
                },
            }
        }
        keep
    }

    /// The limit, and where it is written.
    pub(super) fn loop_limit(
        &mut self,
        c: usize,
        owner: Owner,
    ) -> (Option<u16>, Option<Range<usize>>) {
        let mut limit = (None, None);
        for (rule, path, range) in &self.settings.loops {
            let rule = (rule.map(|it| it as u16), Some(range.clone()));
            let Some(path) = path else {
                limit = rule;
                continue;
            };
            match self.names.resolve(path) {
                Ok(Target::Task(a, t)) if (a, Owner::Task(t)) == (c, owner) => limit = rule,
                Ok(Target::Service(a, s)) if (a, Owner::Service(s)) == (c, owner) => limit = rule,
                Ok(Target::Component(a)) if a == c => limit = rule,
                Ok(Target::Task(..) | Target::Service(..) | Target::Component(_)) => {}
                Ok(_) => self.report(not_a("task or activity", path)),
                Err(error) => self.report(error),
            }
        }
        limit
    }

    pub(super) fn slots(&mut self, c: usize, s: u32) -> u32 {
        let mut slots = 2;
        for (path, count) in &self.settings.slots {
            match self.names.resolve(path) {
                Ok(Target::Service(a, b)) if (a, b) == (c, s) => slots = *count,
                Ok(Target::Service(..)) => {}
                Ok(_) => self.report(not_a("service", path)),
                Err(error) => self.report(error),
            }
        }
        if slots == 0 {
            let path = &self.settings.slots[0].0;
            let message = "an activity needs at least one slot".to_owned();
            self.report(Diagnostic::error("scn-no-slot", path.range(), message));
        }
        slots.clamp(1, 16)
    }
}
