//! The format of GenoM3's profiler.
//!
//! A line describes one run of a codel in nine columns: the times at which the codel asked for its locks, got
//! them and released them (in seconds, with nine digits after the point), instance, task, service, function,
//! and the events before and after the run. The facts are from the recorder of GenoM3
//! (`templates/common/prof.c`) and from a server that contains it: the control task has the name `<control>`,
//! with the event `validate` or `codel` before the run; states are `::COMPONENT::STATE`, with `pause::`
//! before the state if the codel paused; no event is `::genom::ok`.

use std::io::{self, Write};

use dotgen_timing::explore::{Seen, Stepper, Work};
use dotgen_timing::scn::names::Names;
use dotgen_timing::system::{CodelId, TaskId, TimedSystem, Yield};
use num_rational::Ratio;
use typed_index_collections::TiVec;

use crate::decide::yield_of_outcome;
use crate::tally::Tally;

/// Nanoseconds per second.
const NANOS: i128 = 1_000_000_000;

/// The service of a permanent activity: no other service can have this name.
pub const PERMANENT: &str = "<permanent>";

/// The line after which the components of a run are shut down.
pub const ENDING: &str = "# dotgen: the run begins to end\n";

/// Writes lines of a log.
pub struct Profile<'s, W> {
    system: &'s TimedSystem,
    /// Functions, by codel.
    functions: TiVec<CodelId, String>,
    out: W,
    /// First error.
    error: Option<io::Error>,
    lines: u64,
}

/// Returns the C or C++ function of each codel of a system. A codel without a function is represented by its
/// path.
pub fn functions(system: &TimedSystem, names: &Names) -> TiVec<CodelId, String> {
    let codels = system.codels.iter().map(|other| match other.site {
        Some((c, codel)) => names.components[c].component.codel(codel).name.to_string(),
        None => other.path.to_string(),
    });
    codels.collect()
}

impl<'s, W: Write> Profile<'s, W> {
    /// Creates a writer to `out`, which should be buffered.
    pub fn new(system: &'s TimedSystem, functions: TiVec<CodelId, String>, out: W) -> Self {
        Profile { system, functions, out, error: None, lines: 0 }
    }

    /// Writes the end of a codel. `offset`, in base units, is added to all times: it puts runs one after the
    /// other.
    pub(crate) fn on_event(
        &mut self,
        tally: &mut Tally,
        stepper: &Stepper,
        seen: &Seen,
        offset: u64,
    ) {
        let Seen::Ended { executor, work, outcome } = *seen else {
            return;
        };
        let Some(codel) = work.codel() else { return };
        let busy = *tally.busy(executor);
        let times = [busy.asked, busy.begun, stepper.now()];
        let times = times.map(|time| self.stamp(time + offset));
        let line = self.line(codel, &work, outcome, times);
        let result = self.out.write_all(line.as_bytes());
        self.lines += 1;
        self.error = self.error.take().or(result.err());
    }

    /// Writes that the run begins to end.
    pub fn on_ending(&mut self) {
        let result = self.out.write_all(ENDING.as_bytes());
        self.error = self.error.take().or(result.err());
    }

    /// Returns the writer and the number of lines.
    ///
    /// # Errors
    ///
    /// Returns the first error of a write.
    pub fn finish(self) -> io::Result<(W, u64)> {
        match self.error {
            Some(error) => Err(error),
            None => Ok((self.out, self.lines)),
        }
    }

    fn stamp(&self, time: u64) -> String {
        let nanos = self.system.unit * Ratio::from_integer(i128::from(time) * NANOS);
        let nanos = nanos.round().to_integer();
        format!("{}.{:09}", nanos / NANOS, nanos % NANOS)
    }

    fn line(&self, codel: CodelId, work: &Work, outcome: usize, times: [String; 3]) -> String {
        let system = self.system;
        let component = &system.components[system.codels[codel].component].name;
        let event = |state: &str| format!("::{component}::{state}");
        let (task, service, from, to);
        match *work {
            Work::State { task: of, automaton, state, .. } => {
                let machine = system.machine_of(automaton);
                let name = |index: usize| machine.states.get(index).map_or("", |state| &state.name);
                task = system.tasks[TaskId::from(of)].name.clone();
                service = match system.automata[automaton].service {
                    Some(service) => system.services[service].name.clone(),
                    None => PERMANENT.to_owned(),
                };
                from = event(name(state));
                to = match yield_of_outcome(system, work, outcome) {
                    Some(Yield::Next(to)) => event(name(to)),
                    Some(Yield::Pause(to)) => event(&format!("pause::{}", name(to))),
                    Some(Yield::End) => event("ether"),
                    // The model does not know the name of the exception.
                    None => "::genom::exception".to_owned(),
                };
            }
            Work::Control { service: of, number, .. } => {
                let definition = &system.services[of];
                task = "<control>".to_owned();
                service = definition.name.clone();
                let validates = number == 0 && definition.validate.is_some();
                from = if validates { "validate" } else { "codel" }.to_owned();
                to = match outcome {
                    0 => "::genom::ok",
                    _ => "::genom::exception",
                }
                .to_owned();
            }
            Work::Delay { .. } => return String::new(),
        }
        let [asked, begun, ended] = times;
        let function = &self.functions[codel];
        format!("{asked} {begun} {ended} {component} {task} {service} {function} {from} {to}\n")
    }
}
