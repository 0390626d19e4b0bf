//! Conversion of runs to the events of a report.

use super::group::Group;
use crate::explore::{Blocker, Executing, Moment, MomentDetails, MomentKind, Run};
use crate::report::{Blocking, CheckReport, Event, TimeUnit, Verdict};
use crate::scn::names::Names;
use crate::system::{CodelId, ThreadName, TimedSystem};

impl Group<'_> {
    /// Sets the run that shows the failure of a check. With rounded durations, the run need not exist in the
    /// system: it is a candidate.
    pub(super) fn refute(&self, run: &Run, out: &mut CheckReport) {
        if out.rounded {
            self.candidate(run, out);
            return;
        }
        out.verdict = Verdict::Refuted;
        if self.until_failure {
            return;
        }
        out.reason = self.reason(run, out.id.task);
        out.job = self.late_job(run, out);
        out.counterexample = self.events(run);
        out.left_out = run.left_out;
        out.kept = self.kept(run);
        out.cycle = run.cycle.map(|at| {
            let prefix = Run { steps: run.steps[..at].to_vec(), ..run.clone() };
            self.events(&prefix).len()
        });
    }

    /// Keeps a run with rounded durations, which answers the check if the exact system has it as well.
    pub(super) fn candidate(&self, run: &Run, out: &mut CheckReport) {
        out.verdict = Verdict::Unknown;
        out.value = None;
        out.candidate = self.kept(run);
    }

    /// Sets the run that shows the value of a check.
    pub(super) fn witness(&self, run: &Run, out: &mut CheckReport) {
        if self.until_failure {
            return;
        }
        out.witness = self.events(run);
        out.left_out = run.left_out;
        out.kept = self.kept(run);
    }

    /// Returns a run in words, in the unit of the report.
    pub(super) fn events(&self, run: &Run) -> Vec<Event> {
        told(self.names, &self.built.system, self.unit, run)
    }

    /// Returns the final event of a run that exceeds a limit.
    pub(super) fn excess_event(&self, end: u64, thread: ThreadName, what: String) -> Event {
        Event::of_thread(self.at(end), thread, MomentKind::Excess, what)
    }
}

/// Returns a run of a system in words, with times in `unit`.
pub(super) fn told(names: &Names, system: &TimedSystem, unit: TimeUnit, run: &Run) -> Vec<Event> {
    let spec_of = |c: usize| names.components[c].spec_index;
    let path = |codel: CodelId| system.codels[codel].path.clone();
    let name = |executing: Executing| match executing {
        Executing::Task(task) => system.task_name(task),
        Executing::Control(component) => {
            ThreadName::of_component(&system.components[component].name)
        }
    };
    let event = |moment: Moment| {
        let src = match (moment.codel, moment.task) {
            (Some(codel), _) => {
                let codel = &system.codels[codel];
                codel.site.and_then(|(c, _)| Some((spec_of(c), codel.src?)))
            }
            (None, Some(task)) => system.tasks[task].src.map(|(c, src)| (spec_of(c), src)),
            (None, None) => None,
        };
        let time = unit.from_seconds(system.seconds(moment.time));
        let mut event = Event {
            for_core: moment.about == MomentDetails::AwaitsCore,
            codel: moment.codel.map(path),
            action: moment.action,
            src,
            ..Event::of_thread(time, thread(system, &moment), moment.kind, moment.what)
        };
        match moment.about {
            MomentDetails::Nothing | MomentDetails::AwaitsCore => {}
            MomentDetails::Blocked(by) => {
                let blocking = |blocker: Blocker| Blocking {
                    codel: path(blocker.codel),
                    by: name(blocker.by),
                    ahead: blocker.ahead,
                };
                event.waits_for = by.into_iter().map(blocking).collect();
            }
            MomentDetails::Requested { client, .. } => {
                event.client = Some(system.clients[client].name.clone());
            }
            MomentDetails::Released { task } => event.releases = Some(system.task_name(task)),
            MomentDetails::Preempted(executing) => event.preempts = Some(name(executing)),
        }
        event
    };
    run.moments(system).into_iter().map(event).collect()
}

/// Returns the thread of a line of a run.
pub(super) fn thread(system: &TimedSystem, moment: &Moment) -> ThreadName {
    match moment.task {
        Some(task) => system.task_name(task),
        None => ThreadName::of_component(&moment.component),
    }
}
