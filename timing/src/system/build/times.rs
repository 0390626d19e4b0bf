//! Times: durations of codels, periods, the base unit, and from seconds to ticks.

use std::ops::Range;

use dotgen_analysis::model::{Codel as ModelCodel, CodelKind, Owner, Seconds, ServiceKind};
use num_rational::Ratio;

use super::Builder;
use crate::scn::ast::{self, Durations, StepKind};
use crate::scn::names::Target;
use crate::scn::{Diagnostic, Place};
use crate::system::{FOREVER, Ticks, units};

/// What a time is that of.
pub(super) struct TimeOf {
    /// In words.
    pub(super) what: String,
    /// Its `duration`; empty at 0 if there is none.
    pub(super) range: Range<usize>,
    pub(super) place: Place,
}

impl Builder<'_> {
    pub(super) fn override_durations(&mut self) {
        for (i, (path, ..)) in self.settings.duration.iter().enumerate() {
            let key = match self.names.resolve(path) {
                Ok(Target::State(c, owner, index, state)) => (c, owner, index, state),
                Ok(Target::Codel(c, s, index)) => (c, Owner::Service(s), index, String::new()),
                Ok(Target::Service(c, s))
                    if self.names.components[c].component.services[s as usize].kind
                        == ServiceKind::Attribute =>
                {
                    (c, Owner::Service(s), u32::MAX, String::new())
                }
                Ok(_) => {
                    let message = format!(
                        "`{}` is no codel; write component.task.state, component.service.state, or component.service.codel",
                        path.text()
                    );
                    self.report(Diagnostic::error("scn-not-a-codel", path.range(), message));
                    continue;
                }
                Err(error) => {
                    self.report(error);
                    continue;
                }
            };
            self.durations.insert(key, i);
        }
    }

    pub(super) fn choose_unit(&mut self, included: &[usize]) {
        let mut times = Vec::new();
        for &c in included {
            let component = self.names.components[c].component;
            for task in &component.tasks {
                times.extend(task.delay.as_ref().map(|it| it.value));
            }
            for t in 0..component.tasks.len() as u32 {
                times.extend(self.period(c, t));
            }
            for it in component.all_codels() {
                let codel = component.codel(it);
                let mut add = |state: &str| {
                    let (a, b) = self.duration(c, it.owner, it.index, state, Some(codel));
                    times.push(a);
                    times.extend(b);
                };
                if codel.kind == CodelKind::Fsm {
                    codel.triggers.iter().for_each(|state| add(&state.name));
                } else {
                    add("");
                }
            }
            for s in 0..component.services.len() as u32 {
                let (a, b) = self.duration(c, Owner::Service(s), u32::MAX, "", None);
                times.push(a);
                times.extend(b);
            }
        }
        for client in &self.settings.clients {
            delays(&client.steps, &mut times);
        }
        self.out.system.unit = units::base_unit(times);
    }

    /// The time of a codel, exactly, rounded to the unit of the scenario.
    pub(super) fn duration(
        &self,
        c: usize,
        owner: Owner,
        index: u32,
        state: &str,
        codel: Option<&ModelCodel>,
    ) -> (Seconds, Option<Seconds>) {
        let zero = Ratio::new(0, 1);
        let key = (c, owner, index, state.to_owned());
        let (lower, upper) = match self.durations.get(&key) {
            Some(&i) => {
                let (_, interval, unit) = &self.settings.duration[i];
                let seconds = |it: u64| unit.seconds() * Ratio::from_integer(i128::from(it));
                (seconds(interval.lower), interval.upper.map(seconds))
            }
            None => {
                let wcet = codel
                    .and_then(|it| it.wcet.as_ref())
                    .map_or(zero, |it| it.value);
                (zero, Some(wcet))
            }
        };
        let (lower, upper) = match self.settings.unit {
            Some((count, unit)) => {
                let unit = unit.seconds() * Ratio::from_integer(i128::from(count));
                (
                    units::round_down(lower, unit),
                    upper.map(|it| units::round_up(it, unit)),
                )
            }
            None => (lower, upper),
        };
        let upper = match &self.settings.upper_bound {
            Some((path, bound))
                if self.names.resolve(path).is_ok_and(|it| match it {
                    Target::State(a, b, c2, d) => {
                        (a, b, c2, d.as_str()) == (c, owner, index, state)
                    }
                    Target::Codel(a, s, c2) => (a, Owner::Service(s), c2) == (c, owner, index),
                    _ => false,
                }) =>
            {
                Some((*bound).max(lower))
            }
            _ => upper,
        };
        match (self.settings.durations, upper) {
            (Durations::Fixed, Some(upper)) => (upper, Some(upper)),
            _ => (lower, upper),
        }
    }

    pub(super) fn period(&self, c: usize, t: u32) -> Option<Seconds> {
        if let Some((path, period)) = &self.settings.period
            && self.names.resolve(path) == Ok(Target::Task(c, t))
        {
            return Some(*period);
        }
        self.names.components[c].component.tasks[t as usize]
            .period
            .as_ref()
            .map(|it| it.value)
    }

    pub(super) fn ticks(&mut self, time: Seconds, of: &TimeOf) -> Ticks {
        if let Some(ticks) = units::ticks(time, self.out.system.unit) {
            return ticks;
        }
        let message = format!(
            "the time of {} is too long for the base unit of {} s; choose a coarser `unit`",
            of.what, self.out.system.unit
        );
        let error = Diagnostic::error("scn-time-range", of.range.clone(), message);
        self.report(error.about(of.place.clone()));
        FOREVER / 8
    }
}

fn delays(steps: &[ast::Step], out: &mut Vec<Seconds>) {
    for step in steps {
        match &step.kind {
            StepKind::Delay(interval, unit) => {
                let seconds = |it: u64| unit.seconds() * Ratio::from_integer(i128::from(it));
                out.push(seconds(interval.lower));
                out.extend(interval.upper.map(seconds));
            }
            StepKind::Repeat(_, body) => delays(body, out),
            StepKind::Choice(branches) => branches.iter().for_each(|it| delays(it, out)),
            _ => {}
        }
    }
}
