//! The rules of the scenario for single tasks, machines and services: idle ticks, loop limits, slots.

use std::ops::Range;

use dotgen_analysis::model::{Owner, TaskId};

use super::Builder;
use crate::diagnostic::Diagnostic;
use crate::scn::ast::Policy;
use crate::scn::names::Target;
use crate::system::indexed::not_a;

impl Builder<'_> {
    /// Looks up the subjects of the rules.
    pub(super) fn choose_rules(&mut self) {
        let semantics = self.settings.semantics();
        let preempts = matches!(self.settings.policy(), Policy::Priority | Policy::Fair);
        if preempts && !semantics.fixed().may_preempt {
            let message = format!(
                "`semantics {}` with `policy {}` go not together; write `semantics servers;`, or another \
                    policy",
                semantics.text(),
                self.settings.policy().name()
            );
            self.report(Diagnostic::error("scn-semantics", 0..0, message));
        }
        if self.settings.order() && !semantics.fixed().has_order {
            let message = "the published models know no order of services; write `semantics servers;`, or \
                leave `order on;` out";
            self.report(Diagnostic::error("scn-semantics", 0..0, message.to_owned()));
        }
    }

    pub(super) fn idle_rule(&mut self, c: usize, t: TaskId) -> bool {
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

    /// Returns the loop limit, and its place in the scenario.
    pub(super) fn loop_limit(
        &mut self,
        c: usize,
        owner: Owner,
    ) -> (Option<u16>, Option<Range<usize>>) {
        let mut limit = (None, None);
        for (rule, path, range) in &self.settings.loops {
            let rule = (rule.map(|rule| rule as u16), Some(range.clone()));
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

    /// Returns true if codels of this owner may throw, provided that they declare exceptions.
    pub(super) fn may_throw(&mut self, c: usize, owner: Owner) -> bool {
        let mut on = self.settings.semantics().fixed().throws;
        for (rule, path) in &self.settings.exceptions {
            let Some(path) = path else {
                on = *rule;
                continue;
            };
            match self.names.resolve(path) {
                Ok(Target::Task(a, t)) if (a, Owner::Task(t)) == (c, owner) => on = *rule,
                Ok(Target::Service(a, s)) if (a, Owner::Service(s)) == (c, owner) => on = *rule,
                Ok(Target::Component(a)) if a == c => on = *rule,
                Ok(Target::Task(..) | Target::Service(..) | Target::Component(_)) => {}
                Ok(_) => self.report(not_a("task or service", path)),
                Err(error) => self.report(error),
            }
        }
        on && self.declares_exceptions(c, owner)
    }

    /// Returns true if an owner of codels, its task or its component declares exceptions.
    fn declares_exceptions(&self, c: usize, owner: Owner) -> bool {
        let component = self.names.components[c].component;
        let of_task = |t: TaskId| !component.tasks[t].throws.is_empty();
        let own = match owner {
            Owner::Task(t) => of_task(t),
            Owner::Service(s) => {
                let service = &component.services[s];
                !service.throws.is_empty() || service.task.is_some_and(of_task)
            }
        };
        own || !component.throws.is_empty()
    }

    pub(super) fn tie_to_cores(&mut self) {
        let preempts = matches!(self.settings.policy(), Policy::Priority | Policy::Fair);
        for (path, core) in &self.settings.affinity {
            if self.settings.cores.is_some() && !preempts {
                let message = format!(
                    "policy {} gives a task any core that is free; write `policy priority;` or `policy \
                        fair;` to tie `{}` to one",
                    self.settings.policy().name(),
                    path.text()
                );
                self.report(Diagnostic::error("scn-affinity", path.range(), message));
                continue;
            }
            let error = match self.names.resolve(path) {
                Ok(Target::Task(c, t)) => {
                    self.affinity.insert((c, t), *core);
                    match self.settings.cores {
                        Some(cores) if *core <= cores => continue,
                        Some(cores) => {
                            let message = format!("there is no core {core}; `cores` is {cores}");
                            Diagnostic::error("scn-affinity", path.range(), message)
                        }
                        None => {
                            let message = "with `cores free` no task is tied to a core; give a number of \
                                cores";
                            Diagnostic::error("scn-affinity", path.range(), message.to_owned())
                        }
                    }
                }
                Ok(_) => not_a("task", path),
                Err(error) => error,
            };
            self.report(error);
        }
    }

    pub(super) fn number_slots(&mut self) {
        for (path, count) in &self.settings.slots {
            let error = match self.names.resolve(path) {
                Ok(Target::Service(c, s)) if self.names.is_activity(c, s) => {
                    self.slots.insert((c, s), *count);
                    continue;
                }
                Ok(Target::Task(c, t)) => {
                    self.places.insert((c, t), *count);
                    continue;
                }
                Ok(_) => {
                    let message = format!(
                        "`{}` is neither a task nor an activity, and nothing else has slots; name one, or \
                            remove this line",
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
