//! The actions of a trace, performed by the rules of the verifier.

use dotgen_timing::explore::{Action, Possible, Run, Stepper, Watched};
use dotgen_timing::system::{ClientStep, Ticks, TimedSystem};
use dotgen_timing::verify::Prepared;

use super::Error;
use super::times::Taken;

/// Greatest length of a run, in base units.
const MOST: u64 = 1 << 40;

/// A run of the system under way.
struct Replay<'s> {
    system: &'s TimedSystem,
    stepper: Stepper<'s>,
    possible: Possible,
    run: Run,
}

/// Returns the run of actions at the times of their transitions. The last time is the end.
pub(super) fn run(prepared: &Prepared, actions: &[Taken], times: &[i64]) -> Result<Run, Error> {
    let system = &prepared.built.system;
    let stepper = Stepper::new(system, &Watched::default());
    let mut replay = Replay { system, stepper, possible: Possible::default(), run: Run::default() };
    replay.stepper.begin(&mut Vec::new());
    let in_words = |time: u64| prepared.report.unit.show(prepared.time(time));
    let end = times.last().copied().unwrap_or(0);
    let ends = actions.iter().map(|taken| (times[taken.transition - 1], Some(taken)));
    for (time, taken) in ends.chain([(end, None)]) {
        let until = u64::try_from(time).ok().filter(|&until| until <= MOST);
        let until = until.ok_or_else(|| Error::new("the times of the trace are too long"))?;
        if let Err(now) = replay.wait(until) {
            let (until, now) = (in_words(until), in_words(now));
            let message =
                format!("time passes to {until}, but at {now} the verified system must act first");
            return Err(Error { line: taken.map(|taken| taken.line), message });
        }
        let Some(Taken { line, action, words, .. }) = taken else { continue };
        replay.look();
        if !replay.possible.actions().contains(action) {
            let message = format!("{words} is not possible in the verified system here");
            return Err(Error::at(*line, message));
        }
        replay.perform(*action);
    }
    replay.run.end = replay.stepper.now();
    Ok(replay.run)
}

impl Replay<'_> {
    /// Lists the possible actions. Control tasks without requests, which are not in the model, handle the
    /// ends of permanent activities first.
    fn look(&mut self) {
        let system = self.system;
        let requested = (system.clients.iter())
            .flat_map(|client| client.steps.iter().filter_map(ClientStep::requests))
            .map(|service| system.services[service].component);
        loop {
            self.stepper.possible(&mut self.possible);
            let signal = self.possible.actions().iter().copied().find(|action| match action {
                Action::Signal { component } => !requested.clone().any(|other| other == *component),
                _ => false,
            });
            match signal {
                Some(signal) => self.perform(signal),
                None => return,
            }
        }
    }

    /// Lets time pass. An error is a time at which an action must happen first.
    fn wait(&mut self, until: u64) -> Result<(), u64> {
        while self.stepper.now() < until {
            self.look();
            if !self.possible.may_wait() {
                return Err(self.stepper.now());
            }
            let rest = Ticks::try_from(until - self.stepper.now()).unwrap_or(Ticks::MAX);
            let moment = self.stepper.next_moment().map_or(rest, |moment| moment.clamp(1, rest));
            self.stepper.pass(moment, &mut Vec::new());
        }
        Ok(())
    }

    fn perform(&mut self, action: Action) {
        self.run.steps.push((self.stepper.now(), action));
        self.stepper.perform(action, &mut Vec::new());
    }
}
