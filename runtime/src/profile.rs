//! The format of GenoM3's profiler.
//!
//! One line for each run of a codel, with nine columns: when it asked for its locks, got them and released
//! them (seconds, with nine digits after the point), instance, task, service, function, and the events that
//! it came from and led to. The facts are from the recorder of GenoM3 (`templates/common/prof.c`) and from
//! a server that has it: what the control task executes is of the task `<control>`, and comes from
//! `validate` or `codel`; states are `::COMPONENT::STATE`, with `pause::` before the state where the codel
//! paused; no event is `::genom::ok`.

use std::io::{self, Write};

use dotgen_timing::explore::{Seen, Stepper, Work};
use dotgen_timing::scn::names::Names;
use dotgen_timing::system::{TimedSystem, Yield};
use num_rational::Ratio;

use crate::decide::yielded;
use crate::tally::Tally;

/// Nanoseconds of a second.
const NANOS: i128 = 1_000_000_000;

/// How a permanent activity is called where a service is expected: no service has such a name.
pub const PERMANENT: &str = "<permanent>";

/// Writes lines.
pub struct Profile<'s, W> {
    system: &'s TimedSystem,
    /// Names of the functions, by codel.
    functions: Vec<String>,
    out: W,
    /// What went wrong first.
    error: Option<io::Error>,
    lines: u64,
}

/// The C or C++ functions of the codels of a system. A codel that stands for none has its path.
pub fn functions(system: &TimedSystem, names: &Names) -> Vec<String> {
    let codels = system.codels.iter().map(|it| match it.site {
        Some((c, codel)) => names.components[c].component.codel(codel).name.to_string(),
        None => it.path.clone(),
    });
    codels.collect()
}

impl<'s, W: Write> Profile<'s, W> {
    /// To a file or the like, which should be buffered.
    pub fn new(system: &'s TimedSystem, functions: Vec<String>, out: W) -> Self {
        Profile {
            system,
            functions,
            out,
            error: None,
            lines: 0,
        }
    }

    /// Writes the end of a codel. `offset` is added to all times, in base units: runs stand one after the
    /// other.
    pub fn see(&mut self, tally: &mut Tally, stepper: &Stepper, seen: &Seen, offset: u64) {
        let Seen::Ended {
            executor,
            work,
            outcome,
        } = *seen
        else {
            return;
        };
        let Some(codel) = work.codel() else { return };
        let busy = *tally.busy(executor);
        let times = [busy.asked, busy.begun, stepper.now()];
        let times = times.map(|it| self.stamp(it + offset));
        let line = self.line(codel, &work, outcome, times);
        let result = self.out.write_all(line.as_bytes());
        self.lines += 1;
        self.error = self.error.take().or(result.err());
    }

    /// What it was written to, and how many lines.
    ///
    /// # Errors
    /// The first error there was on the way.
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

    fn line(&self, codel: usize, work: &Work, outcome: usize, times: [String; 3]) -> String {
        let system = self.system;
        let component = &system.components[system.codels[codel].component].name;
        let event = |state: &str| format!("::{component}::{state}");
        let (task, service, from, to);
        match *work {
            Work::State {
                task: of,
                automaton,
                state,
                ..
            } => {
                let machine = system.machine_of(automaton);
                let name = |it: usize| machine.states.get(it).map_or("", |it| &it.name);
                task = system.tasks[of].name.clone();
                service = match system.automata[automaton].service {
                    Some(it) => system.services[it].name.clone(),
                    None => PERMANENT.to_owned(),
                };
                from = event(name(state));
                to = match yielded(system, work, outcome) {
                    Some(Yield::Next(to)) => event(name(to)),
                    Some(Yield::Pause(to)) => event(&format!("pause::{}", name(to))),
                    Some(Yield::End) => event("ether"),
                    // Which exception is not known to the model.
                    None => "::genom::exception".to_owned(),
                };
            }
            Work::Control {
                service: of,
                number,
                ..
            } => {
                let it = &system.services[of];
                task = "<control>".to_owned();
                service = it.name.clone();
                let validates = number == 0 && it.validate.is_some();
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
