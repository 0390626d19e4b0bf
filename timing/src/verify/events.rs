//! Runs as the events of a report.

use num_rational::Ratio;

use super::Group;
use super::units::to_f64;
use crate::explore::{MomentKind, Run};
use crate::report::{CheckReport, Event, Verdict};

impl Group<'_> {
    /// A check fails, as a run shows.
    pub(super) fn refute(&self, run: &Run, out: &mut CheckReport) {
        out.verdict = Verdict::Refuted;
        out.reason = self.reason(run, out.id.task);
        *self.shown_by(out) = self.events(run);
        out.left_out = run.left_out;
        out.cycle = run.cycle.map(|at| {
            let prefix = Run {
                steps: run.steps[..at].to_vec(),
                ..run.clone()
            };
            self.events(&prefix).len()
        });
    }

    /// Where the run goes that refutes a check: with rounded durations it need not be one of the system.
    pub(super) fn shown_by<'r>(&self, out: &'r mut CheckReport) -> &'r mut Vec<Event> {
        match out.rounded {
            true => &mut out.possible_run,
            false => &mut out.counterexample,
        }
    }

    /// A run shows what is told of a check.
    pub(super) fn witness(&self, run: &Run, out: &mut CheckReport) {
        out.witness = self.events(run);
        out.left_out = run.left_out;
    }

    /// A run in words and in the unit of the report.
    pub(super) fn events(&self, run: &Run) -> Vec<Event> {
        let system = &self.built.system;
        let factor = system.unit / self.unit;
        let spec_of = |c: usize| self.names.components[c].spec_index;
        run.moments(system)
            .into_iter()
            .map(|it| Event {
                time: to_f64(factor * Ratio::from_integer(i128::from(it.time))),
                src: match (it.codel, it.task) {
                    (Some(codel), _) => {
                        let codel = &system.codels[codel];
                        codel.site.and_then(|(c, _)| Some((spec_of(c), codel.src?)))
                    }
                    (None, Some(task)) => system.tasks[task].src.map(|(c, src)| (spec_of(c), src)),
                    (None, None) => None,
                },
                component: it.component,
                task: it.task.map(|task| system.tasks[task].name.clone()),
                what: it.what,
                for_core: it.kind == MomentKind::Release
                    && it.task.is_some_and(|task| system.needs_core(task)),
                kind: it.kind,
                codel: it.codel.map(|codel| system.codels[codel].path.clone()),
            })
            .collect()
    }

    /// The end of a run that exceeds a limit.
    pub(super) fn excess_event(&self, end: u64, component: String, what: String) -> Event {
        let factor = self.built.system.unit / self.unit;
        Event {
            time: to_f64(factor * Ratio::from_integer(i128::from(end))),
            component,
            task: None,
            what,
            kind: MomentKind::Excess,
            for_core: false,
            codel: None,
            src: None,
        }
    }
}
