//! Times: durations of codels, periods, the base unit, and the conversion from seconds to ticks.

use std::ops::Range;

use dotgen_analysis::model::{
    self, Codel as ModelCodel, CodelKind, Owner, Seconds, ServiceKind, TaskId,
};
use dotgen_analysis::quantity;
use num_rational::Ratio;

use super::Builder;
use crate::diagnostic::{Diagnostic, Place};
use crate::scn::ast::{self, Durations, Step, StepKind};
use crate::scn::names::Target;
use crate::system::indexed::Rounded;
use crate::system::{FOREVER, Ticks, units};

/// The subject of a time.
pub(super) struct TimeOf {
    /// Description.
    pub(super) what: String,
    /// Range of its `duration` in the scenario; empty at 0 if there is none.
    pub(super) range: Range<usize>,
    pub(super) place: Place,
}

impl<'b> Builder<'b> {
    pub(super) fn override_durations(&mut self) {
        for (i, (path, ..)) in self.settings.duration.iter().enumerate() {
            let key = match self.names.resolve(path) {
                Ok(Target::State(c, owner, index, state)) => (c, owner, Some(index), state),
                Ok(Target::Codel(c, s, index)) => {
                    (c, Owner::Service(s), Some(index), String::new())
                }
                Ok(Target::Service(c, s))
                    if self.names.components[c].component.services[s].kind
                        == ServiceKind::Attribute =>
                {
                    (c, Owner::Service(s), None, String::new())
                }
                Ok(_) => {
                    let message = format!(
                        "`{}` is no codel; write component.task.state, component.service.state, or \
                            component.service.codel",
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
            for t in component.tasks.keys() {
                times.extend(self.delay(c, t));
                times.extend(self.period(c, t));
            }
            for reference in component.all_codels() {
                let codel = component.codel(reference);
                let mut add = |state: &str| {
                    let (a, b) = self.duration(
                        c,
                        reference.owner,
                        Some(reference.index),
                        state,
                        Some(codel),
                    );
                    times.push(a);
                    times.extend(b);
                };
                if codel.kind == CodelKind::Fsm {
                    codel.triggers.iter().for_each(|state| add(&state.name));
                } else {
                    add("");
                }
            }
            for s in component.services.keys() {
                let (a, b) = self.duration(c, Owner::Service(s), None, "", None);
                times.push(a);
                times.extend(b);
            }
        }
        times.extend(self.settings.clients.iter().flat_map(delays));
        self.out.system.unit = units::base_unit(times);
    }

    /// Returns the execution time of a codel as it is stated.
    fn stated(
        &self,
        c: usize,
        owner: Owner,
        index: Option<model::CodelId>,
        state: &str,
        codel: Option<&ModelCodel>,
    ) -> (Seconds, Option<Seconds>) {
        let zero = Ratio::new(0, 1);
        let key = (c, owner, index, state.to_owned());
        if let Some(&i) = self.durations.get(&key) {
            let (_, interval, unit) = &self.settings.duration[i];
            let seconds = |number: u64| unit.seconds() * Ratio::from_integer(i128::from(number));
            (seconds(interval.lower), interval.upper.map(seconds))
        } else {
            let wcet = codel.and_then(|codel| self.worst_case(c, codel));
            (zero, Some(wcet.unwrap_or(zero)))
        }
    }

    /// Returns the worst case of a codel: that of the specification, or of a file of execution times.
    fn worst_case(&self, c: usize, codel: &ModelCodel) -> Option<Seconds> {
        let of_file = || self.given_by(c, codel).map(|(time, _)| time);
        codel.wcet.as_ref().map(|wcet| wcet.value).or_else(of_file)
    }

    /// Returns the time of a codel in a file of execution times, and the name of the file.
    pub(super) fn given_by(&self, c: usize, codel: &ModelCodel) -> Option<(Seconds, &'b str)> {
        let beside = self.names.components[c].spec_index;
        let given = |spec| self.given.get(&(spec, codel.name.as_str())).copied();
        given(None).or_else(|| given(Some(beside)))
    }

    /// Returns the unit of the scenario, if it states one.
    fn stated_unit(&self) -> Option<Seconds> {
        let (count, unit) = self.settings.unit?;
        Some(unit.seconds() * Ratio::from_integer(i128::from(count)))
    }

    /// Returns the unit to which execution times are rounded, if they are.
    fn unit(&self) -> Option<Seconds> {
        self.stated_unit().filter(|_| self.settings.rounds)
    }

    /// Returns the execution time of a codel, rounded if the settings say so.
    pub(super) fn duration(
        &self,
        c: usize,
        owner: Owner,
        index: Option<model::CodelId>,
        state: &str,
        codel: Option<&ModelCodel>,
    ) -> (Seconds, Option<Seconds>) {
        let (lower, upper) = self.stated(c, owner, index, state, codel);
        let (lower, upper) = match self.unit() {
            Some(unit) => {
                (units::round_down(lower, unit), upper.map(|ratio| units::round_up(ratio, unit)))
            }
            None => (lower, upper),
        };
        let upper = match &self.settings.upper_bound {
            Some((path, bound))
                if self.names.resolve(path).is_ok_and(|target| match target {
                    Target::State(a, b, c2, d) => {
                        (a, b, Some(c2), d.as_str()) == (c, owner, index, state)
                    }
                    Target::Codel(a, s, c2) => {
                        (a, Owner::Service(s), Some(c2)) == (c, owner, index)
                    }
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

    /// Records the rounding of a time, and the unit in which all times of codels are whole.
    pub(super) fn note_rounding(
        &mut self,
        (c, owner, index, state): (usize, Owner, Option<model::CodelId>, &str),
        codel: Option<&ModelCodel>,
        path: &str,
    ) {
        let Some(unit) = self.unit() else { return };
        let (lower, upper) = self.stated(c, owner, index, state, codel);
        let exact_unit = self.out.exact_unit.unwrap_or(unit);
        let times = [exact_unit, lower, upper.unwrap_or(exact_unit)];
        self.out.exact_unit = Some(units::base_unit(times));
        let up = upper.map(|ratio| (ratio, units::round_up(ratio, unit)));
        let down = (lower, units::round_down(lower, unit));
        let changed = [up, Some(down)].into_iter().flatten();
        let changed = { changed }.find(|(exact, taken)| exact != taken);
        self.out.rounded.extend(changed.map(|(exact, taken)| Rounded {
            codel: path.to_owned(),
            exact,
            taken,
        }));
    }

    /// Reports periods that are not multiples of the unit. Periods are never rounded: such a system is not
    /// verified.
    pub(super) fn whole_periods(&mut self, included: &[usize]) {
        let Some(unit) = self.stated_unit() else { return };
        // A period tried by a derived question is not a stated one.
        if self.settings.period.is_some() {
            return;
        }
        let mut fits = unit;
        let mut wrong = Vec::new();
        for &c in included {
            let component = self.names.components[c].component;
            for task in &component.tasks {
                let Some(period) = &task.period else { continue };
                if !(period.value / unit).is_integer() {
                    fits = units::base_unit([fits, period.value]);
                    let path = format!("{}.{}", component.name, task.name);
                    wrong.push((c, path, period.value, period.src));
                }
            }
        }
        let advice = match units::as_written(fits) {
            Some(unit) => format!("write `unit {unit};`"),
            None => "leave `unit` out".to_owned(),
        };
        for (c, path, period, src) in wrong {
            let message = format!(
                "the period of {path}, {}, is no multiple of the unit of the scenario, {}; {advice}",
                quantity::time(period),
                quantity::time(unit)
            );
            let error = Diagnostic::error("scn-period-unit", 0..0, message);
            self.report(error.about(self.place(c, src, "the period")));
        }
    }

    pub(super) fn period(&self, c: usize, t: TaskId) -> Option<Seconds> {
        if let Some((path, period)) = &self.settings.period
            && self.names.resolve(path) == Ok(Target::Task(c, t))
        {
            return Some(*period);
        }
        self.names.components[c].component.tasks[t].period.as_ref().map(|period| period.value)
    }

    pub(super) fn delay(&self, c: usize, t: TaskId) -> Option<Seconds> {
        if let Some((path, delay)) = &self.settings.delay
            && self.names.resolve(path) == Ok(Target::Task(c, t))
        {
            return Some(*delay);
        }
        let task = &self.names.components[c].component.tasks[t];
        task.delay.as_ref().map(|delay| delay.value)
    }

    pub(super) fn ticks(&mut self, time: Seconds, of: &TimeOf) -> Ticks {
        if let Some(ticks) = units::ticks(time, self.out.system.unit) {
            return ticks;
        }
        let message = format!(
            "the time of {} is too long for the base unit of {} s; choose a coarser `unit`",
            of.what, self.out.system.unit
        );
        let error = Diagnostic::error(super::TOO_LONG, of.range.clone(), message);
        self.report(error.about(of.place.clone()));
        FOREVER / 8
    }
}

/// Returns the times for which a client waits.
fn delays(client: &ast::Client) -> impl Iterator<Item = Seconds> {
    Step::all(&client.steps).into_iter().flat_map(|step| {
        let StepKind::Delay(interval, unit) = &step.kind else { return Vec::new() };
        let ends = [Some(interval.lower), interval.upper];
        let seconds = |number: u64| unit.seconds() * Ratio::from_integer(i128::from(number));
        ends.into_iter().flatten().map(seconds).collect()
    })
}
