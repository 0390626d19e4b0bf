//! Checks without a subject. A result for a system without execution times, or for a task whose jobs are
//! never measured, says nothing about the robot.

use dotgen_analysis::model::{CodelKind, CodelRef, Owner};

use super::checks::Single;
use super::group::Group;
use crate::report::{CheckReport, Verdict};
use crate::scn::semantics::Cycle;
use crate::system::{Builtin, loops};

/// Number of codels named in a note; further codels are only counted.
const NAMED: usize = 3;

impl Group<'_> {
    /// Returns the answer to a check of a task that has nothing to verify: the missing information, and how
    /// to provide it.
    pub(super) fn nothing(&self, check: &Single) -> Option<CheckReport> {
        self.without_times(check)
            .or_else(|| self.without_jobs(check))
            .or_else(|| self.without_period(check))
    }

    /// Handles a task without a period, whose cycles have no tick to be counted from (servers).
    fn without_period(&self, check: &Single) -> Option<CheckReport> {
        let task = *self.built.tasks.get(&check.what.task()?)?;
        let system = &self.built.system;
        let has_jobs = system.platform.semantics.fixed().cycle == Cycle::Jobs;
        if has_jobs || system.tasks[task].period.is_some() {
            return None;
        }
        let path = system.task_path(task);
        Some(CheckReport {
            verdict: Verdict::Vacuous,
            limit: None,
            note: Some(format!("`{path}` has no period, so its cycles have no response time")),
            ..self.blank(check)
        })
    }

    /// Handles a task whose permanent activity never pauses: its first cycle, which is not measured, never
    /// ends.
    fn without_jobs(&self, check: &Single) -> Option<CheckReport> {
        let of = check.what.task()?;
        let system = &self.built.system;
        let id = *self.built.tasks.get(&of)?;
        let task = &system.tasks[id];
        let machine = system.machine_of(task.permanent?);
        let states = loops::states_of_endless_run(machine)?;
        let throws = |&state: &usize| system.codels[machine.states[state].codel].throws;
        // A client that kills a component leads its activities to `stop`. In the published models a task
        // executes its activities all the same.
        let ends = states.iter().any(throws) || system.has_builtin(|kill| kill == Builtin::Kill);
        let has_jobs = system.platform.semantics.fixed().cycle == Cycle::Jobs;
        let measured = has_jobs && (task.period.is_none() || !task.slots.is_empty());
        if ends || measured {
            return None;
        }
        let cycles = loops::pauseless_cycles(machine);
        let cycle = cycles.iter().find(|cycle| cycle.iter().all(|state| states.contains(state)))?;
        let names: Vec<&str> = cycle.iter().map(|&state| &*machine.states[state].name).collect();
        let path = system.task_path(id);
        let note = format!(
            "the permanent activity of `{path}` goes round {} and never pauses, so its first cycle never ends and no job of the \
             task is ever measured; let one of these codels yield `pause::` or `ether`",
            names.join(" → ")
        );
        Some(CheckReport {
            verdict: Verdict::Nothing,
            limit: None,
            note: Some(note),
            ..self.blank(check)
        })
    }

    /// Handles a component that has no execution times at all.
    fn without_times(&self, check: &Single) -> Option<CheckReport> {
        let c = check.what.task()?.component;
        let number = *self.built.components.get(&c)?;
        let system = &self.built.system;
        let component = self.names.components[c].component;
        let codels = || {
            let all = system.codels.iter();
            all.filter(|codel| codel.component == number && codel.site.is_some())
        };
        // Services without requests execute nothing. But if only these services have execution times, the
        // times of the other codels are missing.
        let has_time = |codel: CodelRef| component.codel(codel).wcet.is_some();
        let timed = codels()
            .any(|codel| codel.upper > 0 || codel.site.is_some_and(|site| has_time(site.1)));
        if timed {
            return None;
        }
        let executed: Vec<&str> = codels()
            .filter(|codel| {
                let fsm = |at: CodelRef| component.codel(at).kind == CodelKind::Fsm;
                let of_task = |at: CodelRef| matches!(at.owner, Owner::Task(_)) || fsm(at);
                codel.site.is_some_and(|site| of_task(site.1))
            })
            .map(|codel| &*codel.path)
            .collect();
        if executed.is_empty() {
            // No time is missing: the jobs take no time.
            return None;
        }
        let mut names = executed[..executed.len().min(NAMED)].join(", ");
        if executed.len() > NAMED {
            names += &format!(" and {} more", executed.len() - NAMED);
        }
        let name = &component.name;
        let note = format!(
            "no codel of `{name}` has an execution time: {names}; measure the longest one of each and write it as \
             `wcet`, or as `duration` in a scenario"
        );
        Some(CheckReport {
            verdict: Verdict::Nothing,
            limit: None,
            note: Some(note),
            ..self.blank(check)
        })
    }
}
