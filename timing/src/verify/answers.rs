//! Answers to single checks, from the findings of an exploration.

use super::checks::{Single, What};
use super::group::Group;
use super::units::{limit_text, seconds};
use crate::explore::{Bound, Findings, LivenessQuery, Measured, Run, Stop, liveness};
use crate::property::{Atom, Predicate, resolve};
use crate::report::{
    CheckId, CheckReport, Event, GaveUp, Limit, Report, Soundness, Value, Verdict,
};
use crate::scn::ast::{Durations, Pattern, Pred};
use crate::system::ThreadName;
use crate::system::indexed::DeclaredTask;
use crate::system::loops::{can_be_limited, pauseless_cycles};

/// The note for a `within` check whose first predicate is never true.
const NEVER_TRUE: &str = "the first predicate never becomes true";

impl Group<'_> {
    pub(super) fn blank(&self, check: &Single) -> CheckReport {
        let arrow = |p: &Pred, q: &[Pred]| format!("{} => {}", p.text(), sequence(q));
        let of = || match &check.what {
            What::Schedulable(pair) | What::NoOverdue(pair) | What::Response(pair, _) => {
                self.task_name(*pair).to_string()
            }
            What::Within(p, list, _) => arrow(p, list),
            What::Chain(chain) => chain.path.text(),
            What::LeadsTo(p, q) => arrow(p, std::slice::from_ref(q)),
            What::Eventually(p) | What::Always(p) | What::Reachable(p) => p.text(),
            What::Pattern(pattern) => pattern.text(),
            What::Deadlock => String::new(),
        };
        let of = check.check.subject.clone().unwrap_or_else(of);
        let live = matches!(check.what, What::LeadsTo(..) | What::Eventually(_));
        let bound = match check.what {
            What::Response(_, bound) | What::Within(_, _, bound) => bound,
            What::Chain(chain) => chain.bound,
            _ => None,
        };
        let stated = bound.map(|bound| Limit::Stated(self.unit.from_seconds(seconds(bound))));
        let period = || match check.what {
            What::Response(of, _) => {
                let tasks = &self.names.components[of.component].component.tasks;
                let task = &tasks[of.index];
                let period = task.period.as_ref()?.value;
                Some(Limit::Period(self.unit.from_seconds(period)))
            }
            _ => None,
        };
        let rounded = !self.built.rounded.is_empty();
        let preempts = self.built.system.preempts();
        CheckReport {
            id: CheckId { written: check.written, task: check.what.task() },
            name: check.check.name.as_ref().map(|name| name.value.clone()),
            kind: check.what.kind(),
            of,
            task: check.what.task().map(|task| self.task_name(task)),
            limit: stated.or_else(period),
            bound: stated.map(|bound| Value::Time(bound.time())),
            verdict: Verdict::Unknown,
            conditions: self.built.conditions.clone(),
            soundness: match (self.settings.durations, live) {
                // If a codel is preempted, its remaining time need not be a whole number of units.
                (Durations::Interval | Durations::Open, _) if preempts && rounded => {
                    Soundness::Neither
                }
                (Durations::Interval | Durations::Open, _) if preempts => Soundness::WholeUnits,
                // Rounding up adds runs if durations are intervals, and changes runs if durations are fixed.
                (Durations::Interval, _) if rounded => Soundness::Safe,
                (Durations::Fixed, _) if rounded => Soundness::Neither,
                (Durations::Interval, _) => Soundness::Exact,
                (Durations::Open, _) => Soundness::Safe,
                (Durations::Fixed, false) => Soundness::Under,
                (Durations::Fixed, true) => Soundness::Neither,
            },
            value: None,
            note: None,
            gave_up: None,
            by: None,
            counterexample: Vec::new(),
            reason: Vec::new(),
            job: None,
            spent: Vec::new(),
            endless: None,
            witness: Vec::new(),
            cycle: None,
            left_out: false,
            kept: None,
            candidate: None,
            rounded,
        }
    }

    /// Returns the report of a check without an answer.
    pub(super) fn open(&self, check: &Single) -> CheckReport {
        CheckReport { verdict: Verdict::Open, ..self.blank(check) }
    }

    pub(super) fn one(&self, check: &Single, place: usize, found: &Findings) -> CheckReport {
        let mut out = self.blank(check);
        let (stopped, size) = (found.stopped, (found.states, found.bytes));
        let absent = |result: &Option<Run>, out: &mut CheckReport| match result {
            Some(found) => {
                self.refute(found, out);
            }
            None => self.unless_stopped(stopped, size, Verdict::Proved, out),
        };
        match check.what {
            What::Schedulable(_) => absent(&found.missed[place], &mut out),
            What::NoOverdue(_) => absent(&found.overdue[place], &mut out),
            What::Always(_) | What::Pattern(_) => absent(&found.reached[place], &mut out),
            What::Deadlock => absent(&found.deadlock, &mut out),
            What::Reachable(_) => match &found.reached[place] {
                Some(found) if out.rounded => self.candidate(found, &mut out),
                Some(found) => {
                    out.verdict = Verdict::Proved;
                    self.witness(found, &mut out);
                }
                None => self.unless_stopped(stopped, size, Verdict::Refuted, &mut out),
            },
            What::Response(task, bound) => {
                let never = self.never_released(task, found);
                let never = never.unwrap_or_else(|| "it is never released".to_owned());
                self.bounded(&found.response[place], &never, found, &mut out);
                if out.value == Some(Value::Unbounded) && out.note.is_none() {
                    out.note = self.loop_of(task);
                }
                if let Some(measured) = &found.response[place] {
                    self.spent_by_task(task, &measured.longest, &mut out);
                }
                let end = exceeded(&found.response[place]).filter(|_| !out.rounded);
                if let (Some(end), Some(bound)) = (end, bound) {
                    let what = format!("the job has taken more than {}", limit_text(bound));
                    let src = self.built.system.tasks[self.built.tasks[&task]].src;
                    out.counterexample.push(Event {
                        src: src.map(|(c, src)| (self.names.components[c].spec_index, src)),
                        ..self.excess_event(end, self.task_name(task), what)
                    });
                }
            }
            What::Within(trigger, list, bound) => {
                self.bounded(&found.within[place], NEVER_TRUE, found, &mut out);
                if let Some(measured) = &found.within[place] {
                    let longest = &measured.longest;
                    let run = measured.excess.as_ref().unwrap_or(longest);
                    self.spent_until_response((trigger, list), (run, longest), &mut out);
                }
                let end = exceeded(&found.within[place]).filter(|_| !out.rounded);
                if let (Some(end), Some(bound)) = (end, bound) {
                    let what = format!(
                        "`{}` has not followed within {}",
                        sequence(list),
                        limit_text(bound)
                    );
                    let event = self.excess_event(end, self.last_component(check), what);
                    out.counterexample.push(event);
                }
            }
            What::Chain(_) | What::LeadsTo(..) | What::Eventually(_) => {}
        }
        self.mark_vacuous(self.never(check, found), &mut out);
        // A run that was found exists, whatever the verdict.
        let has_run = match out.verdict {
            Verdict::Refuted => !out.counterexample.is_empty(),
            Verdict::Proved => matches!(check.what, What::Reachable(_)),
            _ => false,
        };
        if has_run && out.value.is_none() && out.soundness == Soundness::WholeUnits {
            out.soundness = Soundness::Exact;
        }
        out
    }

    /// Returns the loop without a pause that makes the jobs of a task unbounded, and a remedy.
    fn loop_of(&self, task: DeclaredTask) -> Option<String> {
        let system = &self.built.system;
        let task = &system.tasks[self.built.tasks[&task]];
        let machines = task.permanent.iter().chain(&task.slots).map(|&a| system.machine_of(a));
        let mut free = machines.filter(|machine| machine.loop_limit.is_none());
        let (machine, cycle) = free
            .find_map(|machine| Some((machine, pauseless_cycles(machine).into_iter().next()?)))?;
        let names: Vec<&str> = cycle.iter().map(|&at| &*machine.states[at].name).collect();
        let advice = if can_be_limited(machine) {
            format!("`loop once {};` in a scenario limits its rounds", machine.name)
        } else {
            "a `pause::` or `ether` among its yields ends it".to_owned()
        };
        let loops = names.join(" → ");
        Some(format!("{} may go round {loops} without a pause; {advice}", machine.name))
    }

    pub(super) fn bounded(
        &self,
        measurement: &Option<Measured>,
        never: &str,
        found: &Findings,
        out: &mut CheckReport,
    ) {
        let Some(measurement) = measurement else {
            out.note = Some(never.to_owned());
            self.unless_stopped(found.stopped, (found.states, found.bytes), Verdict::Vacuous, out);
            return;
        };
        out.value = Some(match measurement.bound {
            Bound::Unbounded => Value::Unbounded,
            Bound::Finite(ticks) => self.time(ticks),
        });
        if let Some(excess) = &measurement.excess {
            if matches!(measurement.bound, Bound::Finite(_)) {
                let size = (found.states, found.bytes);
                self.unless_stopped(found.stopped, size, Verdict::Refuted, out);
                if let Some(note) = &mut out.note {
                    note.push_str(": this is a lower bound");
                }
            }
            self.refute(excess, out);
        } else if measurement.bound == Bound::Unbounded {
            self.refute(&measurement.longest, out);
        } else {
            self.witness(&measurement.longest, out);
            self.unless_stopped(found.stopped, (found.states, found.bytes), Verdict::Proved, out);
        }
    }

    pub(super) fn live(
        &self,
        check: &Single,
        trigger: Option<&Pred>,
        response: &Pred,
        report: &mut Report,
    ) -> CheckReport {
        let mut out = self.blank(check);
        let predicate = |pred: &Pred| resolve::resolve(self.names, self.built, pred).ok();
        let Some(response) = predicate(response) else {
            return out;
        };
        let query = LivenessQuery { trigger: trigger.and_then(predicate), response };
        let found = liveness(&self.built.system, &query, self.limits, self.cancel);
        report.states += found.states;
        report.memory = report.memory.max(found.bytes);
        if let Some(run) = &found.counterexample {
            self.refute(run, &mut out);
            let (spans, codels) = self.cycle(run, &query.response);
            self.set_spent(&[], (&spans, &codels), &mut out);
            if out.cycle.is_none() {
                out.note = Some("after the end of the run nothing ever happens".to_owned());
            }
        } else {
            let size = (found.states, found.bytes);
            self.unless_stopped(found.stopped, size, Verdict::Proved, &mut out);
            let never = (!found.triggered).then(|| NEVER_TRUE.to_owned());
            self.mark_vacuous(never, &mut out);
        }
        out
    }

    /// Marks an answer that is proved only because something never happens, with the reason.
    fn mark_vacuous(&self, never: Option<String>, out: &mut CheckReport) {
        if out.verdict == Verdict::Proved
            && let Some(never) = never
        {
            out.verdict = Verdict::Vacuous;
            out.note = Some(never);
        }
    }

    /// Returns the event that never happens, although the check is about it.
    fn never(&self, check: &Single, found: &Findings) -> Option<String> {
        match check.what {
            What::Schedulable(task) | What::NoOverdue(task) => self.never_released(task, found),
            What::Always(pred) => self.never_true(pred, found),
            What::Pattern(pattern) => self.never_opened(pattern, found),
            _ => None,
        }
    }

    /// Returns the reason why no job of a task is ever released, if no job was seen.
    fn never_released(&self, task: DeclaredTask, found: &Findings) -> Option<String> {
        let (system, task) = (&self.built.system, self.built.tasks[&task]);
        let start_up = found.absent.job(task)?.start_up;
        let why = start_up.map(|start_up| {
            let starting = system.task_path(start_up);
            let holders =
                found.hold_cores.iter().map(|&task| format!("`{}`", system.task_path(task)));
            let held = match &holders.collect::<Vec<_>>()[..] {
                [] => String::new(),
                [holder] => format!(", because {holder} can hold a core for ever"),
                holders => format!(", because {} can hold cores for ever", holders.join(", ")),
            };
            format!(": the start-up of `{starting}` never completes{held}")
        });
        let path = system.task_path(task);
        Some(format!("`{path}` is never released{}", why.unwrap_or_default()))
    }

    /// Returns the part of a predicate that was never true, if the predicate always holds for that reason.
    pub(super) fn never_true(&self, pred: &Pred, found: &Findings) -> Option<String> {
        let predicate = |pred: &Pred| resolve::resolve(self.names, self.built, pred).ok();
        let absent = |atom: &Atom| found.absent.has(atom);
        if !predicate(pred)?.is_vacuous(&absent) {
            return None;
        }
        let mut parts = pred.parts();
        let never = parts.find(|part| match predicate(part) {
            Some(Predicate::Atom(atom) | Predicate::Leave(atom)) => absent(&atom),
            _ => false,
        })?;
        Some(format!("`{}` never becomes true", never.text()))
    }

    /// Returns the predicate that was never true, if the pattern says nothing without it.
    fn never_opened(&self, pattern: &Pattern, found: &Findings) -> Option<String> {
        let monitor = self.monitor(pattern)?;
        let absent = |atom: &Atom| found.absent.has(atom);
        let needed = [Some(monitor.kind.opening()), monitor.kind.closing()];
        let mut needed = needed.into_iter().flatten();
        let never = needed.find(|&needed| monitor.predicates[needed].is_never(&absent))?;
        Some(format!("`{}` never becomes true", pattern.predicates[never].text()))
    }

    fn unless_stopped(
        &self,
        stopped: Option<Stop>,
        (states, memory): (usize, usize),
        verdict: Verdict,
        out: &mut CheckReport,
    ) {
        match stopped {
            None => out.verdict = verdict,
            Some(Stop::Answered) => {}
            Some(reason) => {
                let gave_up = GaveUp {
                    reason,
                    states,
                    memory,
                    seconds: self.cancel.time_limit().map(|limit| limit.as_secs_f64()),
                };
                out.note = Some(gave_up.to_string());
                out.gave_up = Some(gave_up);
            }
        }
    }

    /// Returns the component at which the subject of a check ends.
    pub(super) fn last_component(&self, check: &Single) -> ThreadName {
        let name = |&component: &usize| &*self.names.components[component].component.name;
        ThreadName::of_component(check.components.last().map_or("", name))
    }

    fn task_name(&self, task: DeclaredTask) -> ThreadName {
        let component = self.names.components[task.component].component;
        ThreadName::of_task(&component.name, &component.tasks[task.index].name)
    }
}

/// Returns a sequence of predicates as the scenario writes it.
fn sequence(list: &[Pred]) -> String {
    let list: Vec<String> = list.iter().map(Pred::text).collect();
    list.join(" then ")
}

/// Returns the time, in base units, at which a known run exceeds the limit.
pub(super) fn exceeded(measurement: &Option<Measured>) -> Option<u64> {
    let run = measurement.as_ref()?.excess.as_ref()?;
    (!run.left_out).then_some(run.end)
}
