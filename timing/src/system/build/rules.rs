//! What the scenario says of single tasks, machines and services: idle ticks, loop limits, slots.

use std::ops::Range;

use dotgen_analysis::model::Owner;

use super::{Builder, not_a};
use crate::scn::Diagnostic;
use crate::scn::ast::Policy;
use crate::scn::names::Target;
use crate::scn::semantics::{LockRule, Semantics};

impl Builder<'_> {
    /// What there are rules for.
    pub(super) fn choose_rules(&mut self) {
        let semantics = self.settings.semantics();
        let locks = semantics.locks;
        let published = semantics
            == Semantics {
                locks,
                ..Semantics::PUBLISHED
            };
        let preempts = matches!(self.settings.policy(), Policy::Priority | Policy::Fair);
        if !published || locks == LockRule::Queue || preempts {
            let message = format!(
                "`semantics {}` with `policy {}` cannot be verified yet; write `semantics published;`",
                semantics.text(),
                self.settings.policy().name()
            );
            self.report(Diagnostic::error("scn-semantics", 0..0, message));
        }
    }

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

    pub(super) fn number_slots(&mut self) {
        for (path, count) in &self.settings.slots {
            let error = match self.names.resolve(path) {
                Ok(Target::Service(c, s)) if self.names.is_activity(c, s) => {
                    self.slots.insert((c, s), *count);
                    continue;
                }
                Ok(_) => {
                    let message = format!(
                        "`{}` is no activity, and nothing else has slots; name an activity, or remove this line",
                        path.text()
                    );
                    Diagnostic::error("scn-wrong-kind", path.range(), message)
                }
                Err(error) => error,
            };
            self.report(error);
        }
    }
}
