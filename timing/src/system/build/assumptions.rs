//! The assumptions on which the result depends, in words.

use super::Builder;
use crate::scn::ast::{self, Durations};
use crate::scn::names::Member;
use crate::scn::semantics::{LockRule, StartUp};
use crate::system::ground::Condition;

impl Builder<'_> {
    /// The conditions: codels without a time that can execute in this scenario, and unknown interfaces.
    pub(super) fn conditions(&mut self, included: &[usize]) {
        let executed = self.out.system.executed();
        let executed = self.untimed.iter().filter(|id| executed[**id]);
        let codels = executed.map(|id| self.out.system.codels[*id].path.clone());
        self.out.conditions = codels.map(|codel| Condition::Wcet { codel }).collect();
        for &index in included {
            let Member { spec, component, .. } = self.names.components[index];
            let Some(at) = spec.components.position(|other| other.name == component.name) else {
                continue;
            };
            let unknown = spec.unknown_interfaces(at).into_iter();
            self.out.conditions.extend(unknown.map(|interface| Condition::Interface {
                interface: interface.to_string(),
                component: component.name.to_string(),
            }));
        }
    }

    pub(super) fn assumptions(&mut self) {
        let settings = self.settings;
        let assumptions = &mut self.out.assumptions;
        let mut say = |text: String| assumptions.push(text);
        say(format!("semantics: {}", settings.semantics().text()));
        match settings.durations {
            Durations::Interval => say(
                "durations: every codel takes any time from 0, or its stated lower bound, to its upper \
                    bound".to_owned(),
            ),
            Durations::Fixed => say(
                "durations: every codel takes exactly its worst case; codels that end earlier can make \
                    other tasks later".to_owned(),
            ),
            Durations::Open => say(
                "durations: explored from 0 on instead of from just above 0; a failure may be a false alarm".to_owned(),
            ),
        }
        for (file, count) in &self.timed_by {
            let codels = if *count == 1 {
                "1 codel has its".to_owned()
            } else {
                format!("{count} codels have their")
            };
            say(format!("times: {codels} worst case from `{file}`"));
        }
        match settings.cores {
            None => say("cores: no limit".to_owned()),
            Some(cores) => say(match settings.policy() {
                ast::Policy::Priority => format!(
                    "cores: {cores}, at each moment for the ready tasks of highest priority, control tasks \
                        included{}",
                    if self.out.system.tasks.iter().any(|task| task.priority.is_some()) {
                        ""
                    } else {
                        "; no task has a `priority`: the shorter period goes first"
                    }
                ),
                ast::Policy::Fair => format!(
                    "cores: {cores}, at each moment for any ready tasks, control tasks included, as long as \
                        no core idles"
                ),
                ast::Policy::Fifo | ast::Policy::Edf | ast::Policy::Any => format!(
                    "cores: {cores}, granted {}, held from the grant to the end of the cycle, also while \
                        waiting for a lock",
                    match settings.policy() {
                        ast::Policy::Fifo => "in order of release",
                        ast::Policy::Edf => "by earliest deadline",
                        _ => "to any waiting task",
                    }
                ),
            }),
        }
        let locks = match settings.semantics().locks {
            LockRule::Queue => "in one queue per component; all codels wait behind its head",
            LockRule::Fifo => "in order of arrival among codels that exclude each other",
            LockRule::Free => "any waiting codel may win, also repeatedly",
        };
        say(format!("locks: {locks}"));
        if settings.clients.is_empty() {
            say("clients: none; only permanent activities run".to_owned());
        }
        let throws = self.out.system.codels.iter().any(|codel| codel.throws);
        let points = settings.semantics().fixed();
        say(match (throws, points.throws) {
            (true, _) => {
                "any declared yield may be taken, or an exception thrown where some are declared"
            }
            (false, false) => "any declared yield may be taken; exceptions are left out",
            (false, true) => "any declared yield may be taken",
        }
        .to_owned());
        if !settings.async_free || !points.may_run_apart {
            let any = self.out.system.machines.iter().flat_map(|machine| &machine.states);
            if any.clone().any(|state| state.is_async) {
                self.out.assumptions.push(
                    "async: executed like any other codel, the task keeps its core".to_owned(),
                );
            }
        }
        for machine in &self.out.system.machines {
            if let Some(limit) = machine.loop_limit {
                let scope = if machine.rounds { "round" } else { "turn" };
                self.out.assumptions.push(format!(
                    "loop: {} enters no state more than {limit} time(s) in one {scope}; assumed, not proved",
                    machine.name
                ));
            }
        }
        let mut ordered: Vec<String> = Vec::new();
        for &(c, s) in &self.requested {
            let component = self.names.components[c].component;
            let service = &component.services[s];
            let mut lists = [&service.before, &service.after].into_iter();
            let path = format!("{}.{}", component.name, service.name);
            if lists.any(|service_list| service_list.all || !service_list.services.is_empty())
                && !ordered.contains(&path)
            {
                ordered.push(path);
            }
        }
        if !ordered.is_empty() && !settings.order() {
            self.out.assumptions.push(format!(
                "requests: `before` and `after` of {} are not looked at; they are accepted at any time",
                ordered.join(", ")
            ));
        }
        if points.start_up == StartUp::FirstCodel
            && self.out.system.tasks.iter().any(|task| task.delay > 0)
        {
            self.out.assumptions.push(
                "delay: the first tick of a task comes one period and its delay after its start"
                    .to_owned(),
            );
        }
    }
}
