//! From specifications and a scenario to a report.

mod analysed;
mod checks;
mod groups;
mod soon;

use std::time::Instant;

use dotgen_analysis::model::{Seconds, Spec};
use num_rational::Ratio;

use self::analysed::Analysed;
use self::checks::{Single, What, expand};
use self::groups::groups;
use self::soon::Seen;
pub use crate::cancel::{Cancel, Effort};
use crate::explore::{
    Bound, Findings, Found, Limits, LivenessQuery, Measured, MomentKind, ResponseTime, Run, Stop,
    Watch, Within, explore, liveness,
};
use crate::property::{Predicate, resolve};
use crate::report::{CheckReport, Event, GaveUp, Report, Soundness, Value, Verdict};
use crate::scn::Diagnostic;
use crate::scn::ast::{Bound as AstBound, Check, Durations, Policy, Pred, Scenario, Unit};
use crate::scn::names::Names;
use crate::system::Ticks;
use crate::system::build::{Built, build};
use crate::system::settings::Settings;

/// The specifications of a system.
#[derive(Debug, Clone, Default)]
pub struct SystemInput<'a> {
    /// In the order of the scenario's `use`.
    pub specs: Vec<&'a Spec>,
}

/// What overrides the scenario.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    /// Number of cores; `Some(None)`: no limit.
    pub cores: Option<Option<u32>>,
    /// Order of grants.
    pub policy: Option<Policy>,
    /// How long codels take.
    pub durations: Option<Durations>,
    /// Checks instead of those of the scenario, if any.
    pub checks: Vec<Check>,
    /// When to give up.
    pub limits: Limits,
}

/// Verifies a scenario.
pub fn verify(
    input: &SystemInput,
    scenario: &Scenario,
    options: &Options,
    cancel: &Cancel,
) -> Report {
    let names = Names::new(&input.specs);
    verify_settings(&names, &settings(scenario, options), options.limits, cancel)
}

/// A scenario with its overrides.
pub fn settings(scenario: &Scenario, options: &Options) -> Settings {
    let mut settings = Settings::new(scenario);
    if let Some(cores) = options.cores {
        settings.cores = cores;
    }
    settings.policy = options.policy.unwrap_or(settings.policy);
    settings.durations = options.durations.unwrap_or(settings.durations);
    if !options.checks.is_empty() {
        settings.checks.clone_from(&options.checks);
    }
    settings
}

/// Verifies settings; what the derived questions vary.
pub(crate) fn verify_settings(
    names: &Names,
    settings: &Settings,
    limits: Limits,
    cancel: &Cancel,
) -> Report {
    let start = Instant::now();
    let (count, unit) = settings.unit.unwrap_or((1, Unit::Milliseconds));
    let mut report = Report {
        scenario: settings.name.clone(),
        unit: if count == 1 {
            unit.name().to_owned()
        } else {
            format!("{count} {}", unit.name())
        },
        ..Report::default()
    };
    let whole = build(names, settings, &|_| true);
    report.diagnostics.clone_from(&whole.diagnostics);
    report.assumptions.clone_from(&whole.assumptions);
    let checks = expand(names, &whole, settings, &mut report.diagnostics);
    if names.components.is_empty() {
        let message = "there is no component to verify".to_owned();
        report
            .diagnostics
            .push(Diagnostic::error("scn-no-component", 0..0, message));
    }
    if report.has_errors() {
        return report;
    }
    let unit = unit.seconds() * Ratio::from_integer(i128::from(count));
    let groups = groups(names, &whole, &checks);
    let mut answers: Vec<Option<CheckReport>> = vec![None; checks.len()];
    for group in &groups {
        let of_group: Vec<usize> = (0..checks.len())
            .filter(|&i| {
                checks[i]
                    .components
                    .first()
                    .is_none_or(|it| group.contains(it))
            })
            .collect();
        if of_group.is_empty() {
            continue;
        }
        let built = if groups.len() == 1 {
            whole.clone()
        } else {
            build(names, settings, &|c| group.contains(&c))
        };
        Group {
            names,
            built: &built,
            unit,
            settings,
            limits,
            cancel,
        }
        .answer(&checks, &of_group, &mut answers, &mut report);
    }
    report.checks = answers.into_iter().flatten().collect();
    report.seconds = start.elapsed().as_secs_f64();
    report
}

/// Components that are explored together.
struct Group<'g> {
    names: &'g Names<'g>,
    built: &'g Built,
    /// Unit of the report.
    unit: Seconds,
    settings: &'g Settings,
    limits: Limits,
    cancel: &'g Cancel,
}

/// Said when all checks were answered before everything was explored.
const NOT_EXAMINED: &str =
    "no request was seen to be refused for want of a slot, but not everything was looked at";

impl Group<'_> {
    /// Answers the checks of this group.
    fn answer(
        &self,
        checks: &[Single],
        of_group: &[usize],
        answers: &mut [Option<CheckReport>],
        report: &mut Report,
    ) {
        let analysed = Analysed::new(self.built);
        for &i in of_group {
            answers[i] = if let Some(bound) = analysed.deadline(&checks[i]) {
                Some(self.meets_deadlines(&checks[i], bound))
            } else if analysed.is_zero(&checks[i]) {
                Some(self.takes_no_time(&checks[i]))
            } else {
                None
            };
        }
        let seen = self.soon(checks, of_group, answers, report);
        let open = of_group.iter().copied().filter(|&i| answers[i].is_none());
        // What makes reductions impossible is not looked for together with what does not.
        let (together, apart): (Vec<usize>, Vec<usize>) =
            open.partition(|&i| self.is_about_ticks(&checks[i]));
        if together.is_empty() && apart.is_empty() {
            let limits = self.limits;
            let found = explore(&self.built.system, &Watch::default(), limits, self.cancel);
            self.refusals(&found, report);
        }
        for part in [together, apart] {
            self.explore(checks, &part, &analysed, &seen, answers, report);
        }
    }

    /// Notes which requests can be refused, as far as has been seen.
    fn refusals(&self, found: &Findings, report: &mut Report) {
        let system = &self.built.system;
        for &service in &found.refused {
            report.note(format!(
                "a request of {} can be refused because all its slots are in use",
                system.service_path(service)
            ));
        }
        let early = found.stopped == Some(Stop::Answered);
        if early && found.refused.is_empty() && system.may_refuse() {
            report.note(NOT_EXAMINED.to_owned());
        }
    }

    /// Whether a check is about what happens from ticks on, so that steps between them can be put off.
    fn is_about_ticks(&self, check: &Single) -> bool {
        match check.what {
            What::Schedulable(_) | What::NoOverdue(_) => true,
            What::Response(it, _) => {
                let task = self.built.tasks[&it];
                self.built.system.tasks[task].period.is_some()
            }
            _ => false,
        }
    }

    /// What is to be watched for these checks, and where the answer to each will be found.
    fn watch(
        &self,
        checks: &[Single],
        part: impl Iterator<Item = usize>,
        analysed: &Analysed,
    ) -> (Watch, Vec<(usize, usize)>) {
        let mut watch = Watch::default();
        let mut places = Vec::new();
        let predicate = |pred: &Pred| resolve::resolve(self.names, self.built, pred).ok();
        for i in part {
            let mut task = |list: fn(&mut Watch) -> &mut Vec<usize>, it| {
                let task = self.built.tasks[&it];
                let list = list(&mut watch);
                list.iter().position(|&it| it == task).unwrap_or_else(|| {
                    list.push(task);
                    list.len() - 1
                })
            };
            let place = match checks[i].what {
                What::Schedulable(it) => task(|it| &mut it.schedulable, it),
                What::NoOverdue(it) => task(|it| &mut it.overdue, it),
                What::Response(it, bound) => {
                    let it = ResponseTime {
                        task: self.built.tasks[&it],
                        limit: self.ticks(bound),
                        most: analysed.response(&checks[i]),
                    };
                    let same = watch.response.iter().position(|other| *other == it);
                    same.unwrap_or_else(|| {
                        watch.response.push(it);
                        watch.response.len() - 1
                    })
                }
                What::Within(p, q, bound) => {
                    let (Some(trigger), Some(response)) = (predicate(p), predicate(q)) else {
                        continue;
                    };
                    watch.within.push(Within {
                        trigger,
                        response,
                        limit: self.ticks(bound),
                    });
                    watch.within.len() - 1
                }
                What::Always(p) => {
                    let Some(p) = predicate(p) else { continue };
                    watch.reach.push(Predicate::Not(Box::new(p)));
                    watch.reach.len() - 1
                }
                What::Reachable(p) => {
                    let Some(p) = predicate(p) else { continue };
                    watch.reach.push(p);
                    watch.reach.len() - 1
                }
                What::Deadlock => {
                    watch.deadlock = true;
                    0
                }
                What::LeadsTo(..) | What::Eventually(_) => 0,
            };
            places.push((i, place));
        }
        (watch, places)
    }

    fn explore(
        &self,
        checks: &[Single],
        part: &[usize],
        analysed: &Analysed,
        seen: &Seen,
        answers: &mut [Option<CheckReport>],
        report: &mut Report,
    ) {
        let (watch, places) = self.watch(checks, part.iter().copied(), analysed);
        let explored = places
            .iter()
            .any(|&(i, _)| !matches!(checks[i].what, What::LeadsTo(..) | What::Eventually(_)));
        let found = if explored {
            explore(&self.built.system, &watch, self.limits, self.cancel)
        } else {
            Findings::default()
        };
        report.effort(&found);
        if explored {
            self.refusals(&found, report);
        }
        for (i, place) in places {
            answers[i] = Some(match checks[i].what {
                What::LeadsTo(p, q) => self.live(&checks[i], Some(p), q, report),
                What::Eventually(p) => self.live(&checks[i], None, p, report),
                _ => {
                    let mut it = self.one(&checks[i], place, &found);
                    seen.add_to(i, &mut it);
                    self.bound_unknown(&checks[i], analysed, &mut it);
                    it
                }
            });
        }
    }

    fn time(&self, ticks: Ticks) -> Value {
        let time = self.built.system.unit * Ratio::from_integer(i128::from(ticks));
        Value::Time(to_f64(time / self.unit))
    }

    fn in_words(&self, ticks: Ticks) -> String {
        self.with_unit(self.time(ticks))
    }

    fn with_unit(&self, time: Value) -> String {
        let (count, unit) = self.settings.unit.unwrap_or((1, Unit::Milliseconds));
        let unit = if count == 1 {
            unit.name().to_owned()
        } else {
            format!("× {count} {}", unit.name())
        };
        format!("{time} {unit}")
    }

    fn meets_deadlines(&self, check: &Single, bound: Ticks) -> CheckReport {
        CheckReport {
            verdict: Verdict::Proved,
            note: Some(match check.what {
                What::NoOverdue(_) if bound == 0 => "no job ever waits for a core".to_owned(),
                _ => format!(
                    "by response-time analysis: a job takes at most {}",
                    self.in_words(bound)
                ),
            }),
            ..self.blank(check)
        }
    }

    fn takes_no_time(&self, check: &Single) -> CheckReport {
        CheckReport {
            verdict: Verdict::Proved,
            value: Some(self.time(0)),
            note: Some("by response-time analysis: a job takes no time".to_owned()),
            ..self.blank(check)
        }
    }

    /// Where the exploration was given up, a bound from analysis may still be an answer.
    fn bound_unknown(&self, check: &Single, analysed: &Analysed, out: &mut CheckReport) {
        let (Verdict::Unknown, Some(bound)) = (out.verdict, analysed.of_task(check)) else {
            return;
        };
        let beyond = match check.what {
            What::Response(_, limit) => self.ticks(limit).is_some_and(|limit| bound > limit),
            _ => true,
        };
        if beyond {
            if let Some(note) = &mut out.note {
                let bound = self.in_words(bound);
                note.push_str(&format!(
                    "; by response-time analysis a job takes at most {bound}"
                ));
            }
            return;
        }
        out.verdict = Verdict::Proved;
        if out.value == Some(self.time(bound)) {
            // Reached, and never exceeded.
            (out.note, out.gave_up) = (None, None);
            return;
        }
        let why = out.gave_up.map_or(String::new(), |it| format!(": {it}"));
        let reached = match out.value {
            Some(it @ Value::Time(_)) => format!(", and {} is reached", self.with_unit(it)),
            _ => String::new(),
        };
        out.note = Some(format!(
            "by response-time analysis: at most {}{reached}; the exact value was not found{why}",
            self.in_words(bound)
        ));
        out.value = Some(self.time(bound));
        out.soundness = Soundness::UpperBound;
        out.witness.clear();
    }

    /// A limit in base units, rounded down: times are whole. Without one if it is beyond all that is counted.
    fn ticks(&self, limit: AstBound) -> Option<Ticks> {
        let ticks = (seconds(limit?) / self.built.system.unit).to_integer();
        Ticks::try_from(ticks).ok().filter(|&it| it < Ticks::MAX)
    }

    fn blank(&self, check: &Single) -> CheckReport {
        let task = |it: &(usize, u32)| {
            let (component, task) = self.task_names(*it);
            format!("{component}.{task}")
        };
        let arrow = |p: &Pred, q: &Pred| format!("{} => {}", p.text(), q.text());
        let (kind, of) = match &check.what {
            What::Schedulable(it) => ("schedulable", task(it)),
            What::NoOverdue(it) => ("no-overdue", task(it)),
            What::Response(it, _) => ("response", task(it)),
            What::Within(p, q, _) => ("within", arrow(p, q)),
            What::LeadsTo(p, q) => ("leadsto", arrow(p, q)),
            What::Eventually(p) => ("eventually", p.text()),
            What::Always(p) => ("always", p.text()),
            What::Reachable(p) => ("reachable", p.text()),
            What::Deadlock => ("deadlock", String::new()),
        };
        let live = matches!(check.what, What::LeadsTo(..) | What::Eventually(_));
        let bound = match check.what {
            What::Response(_, bound) | What::Within(_, _, bound) => bound,
            _ => None,
        };
        CheckReport {
            name: check.check.name.as_ref().map(|it| it.value.clone()),
            check: kind,
            of,
            bound: bound.map(|it| Value::Time(to_f64(seconds(it) / self.unit))),
            verdict: Verdict::Unknown,
            soundness: match (self.settings.durations, live) {
                (Durations::Interval, _) => Soundness::Exact,
                (Durations::Open, _) => Soundness::Safe,
                (Durations::Fixed, false) => Soundness::Under,
                (Durations::Fixed, true) => Soundness::Neither,
            },
            value: None,
            note: None,
            gave_up: None,
            counterexample: Vec::new(),
            witness: Vec::new(),
            cycle: None,
        }
    }

    fn task_names(&self, (c, t): (usize, u32)) -> (String, String) {
        let component = self.names.components[c].component;
        let task = &component.tasks[t as usize].name;
        (component.name.to_string(), task.to_string())
    }

    fn one(&self, check: &Single, place: usize, found: &Findings) -> CheckReport {
        let mut out = self.blank(check);
        let (stopped, size) = (found.stopped, (found.states, found.bytes));
        let absent = |it: &Option<Found>, out: &mut CheckReport| match it {
            Some(found) => {
                self.refute(&found.run, out);
            }
            None => self.unless_stopped(stopped, size, Verdict::Proved, out),
        };
        match check.what {
            What::Schedulable(_) => absent(&found.missed[place], &mut out),
            What::NoOverdue(_) => absent(&found.overdue[place], &mut out),
            What::Always(_) => absent(&found.reached[place], &mut out),
            What::Deadlock => absent(&found.deadlock, &mut out),
            What::Reachable(_) => match &found.reached[place] {
                Some(it) => {
                    out.verdict = Verdict::Proved;
                    out.witness = self.events(&it.run);
                }
                None => self.unless_stopped(stopped, size, Verdict::Refuted, &mut out),
            },
            What::Response(task, bound) => {
                let never = "it is never released";
                self.bounded(&found.response[place], never, found, &mut out);
                if let (Some(end), Some(it)) = (exceeded(&found.response[place]), bound) {
                    let what = format!("the job has taken more than {}", limit_text(it));
                    let (component, name) = self.task_names(task);
                    let src = self.built.system.tasks[self.built.tasks[&task]].src;
                    out.counterexample.push(Event {
                        task: Some(name),
                        src: src.map(|(c, src)| (self.names.components[c].spec_index, src)),
                        ..self.excess_event(end, component, what)
                    });
                }
            }
            What::Within(_, q, bound) => {
                let never = "the first predicate never becomes true";
                self.bounded(&found.within[place], never, found, &mut out);
                if let (Some(end), Some(it)) = (exceeded(&found.within[place]), bound) {
                    let what = format!("`{}` has not followed within {}", q.text(), limit_text(it));
                    let about = check.components.last();
                    let component = about.map_or(String::new(), |&it| {
                        self.names.components[it].component.name.to_string()
                    });
                    out.counterexample
                        .push(self.excess_event(end, component, what));
                }
            }
            What::LeadsTo(..) | What::Eventually(_) => {}
        }
        out
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
                    seconds: self.cancel.time_limit().map(|it| it.as_secs_f64()),
                };
                out.note = Some(gave_up.to_string());
                out.gave_up = Some(gave_up);
            }
        }
    }

    fn bounded(&self, it: &Option<Measured>, never: &str, found: &Findings, out: &mut CheckReport) {
        let Some(it) = it else {
            out.note = Some(never.to_owned());
            self.unless_stopped(
                found.stopped,
                (found.states, found.bytes),
                Verdict::Proved,
                out,
            );
            return;
        };
        let base = self.built.system.unit;
        let time = |ticks| base * Ratio::from_integer(i128::from(ticks));
        out.value = Some(match it.bound {
            Bound::Unbounded => Value::Unbounded,
            Bound::Finite(ticks) => Value::Time(to_f64(time(ticks) / self.unit)),
        });
        if let Some(excess) = &it.excess {
            if matches!(it.bound, Bound::Finite(_)) {
                let size = (found.states, found.bytes);
                self.unless_stopped(found.stopped, size, Verdict::Refuted, out);
                if let Some(note) = &mut out.note {
                    note.push_str(": this is a lower bound");
                }
            }
            self.refute(&excess.run, out);
        } else if it.bound == Bound::Unbounded {
            self.refute(&it.longest.run, out);
        } else {
            out.witness = self.events(&it.longest.run);
            self.unless_stopped(
                found.stopped,
                (found.states, found.bytes),
                Verdict::Proved,
                out,
            );
        }
    }

    /// The end of a run that exceeds a limit.
    fn excess_event(&self, end: u64, component: String, what: String) -> Event {
        let factor = self.built.system.unit / self.unit;
        Event {
            time: to_f64(factor * Ratio::from_integer(i128::from(end))),
            component,
            task: None,
            what,
            kind: MomentKind::Excess,
            codel: None,
            src: None,
        }
    }

    fn live(
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
        let query = LivenessQuery {
            trigger: trigger.and_then(predicate),
            response,
        };
        let found = liveness(&self.built.system, &query, self.limits, self.cancel);
        report.states += found.states;
        report.memory = report.memory.max(found.bytes);
        match &found.counterexample {
            Some(run) => {
                self.refute(run, &mut out);
                if out.cycle.is_none() {
                    out.note = Some("after the end of the run nothing ever happens".to_owned());
                }
            }
            None => self.unless_stopped(
                found.stopped,
                (found.states, found.bytes),
                Verdict::Proved,
                &mut out,
            ),
        }
        out
    }

    /// A check fails, as a run shows.
    fn refute(&self, run: &Run, out: &mut CheckReport) {
        out.verdict = Verdict::Refuted;
        out.counterexample = self.events(run);
        out.cycle = run.cycle.map(|at| {
            let prefix = Run {
                steps: run.steps[..at].to_vec(),
                ..run.clone()
            };
            self.events(&prefix).len()
        });
    }

    /// A run in words and in the unit of the report.
    fn events(&self, run: &Run) -> Vec<Event> {
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
                kind: it.kind,
                codel: it.codel.map(|codel| system.codels[codel].path.clone()),
            })
            .collect()
    }
}

/// When a limit is exceeded, in base units.
fn exceeded(it: &Option<Measured>) -> Option<u64> {
    Some(it.as_ref()?.excess.as_ref()?.run.end)
}

fn seconds((count, unit): (u64, Unit)) -> Seconds {
    unit.seconds() * Ratio::from_integer(i128::from(count))
}

fn limit_text((count, unit): (u64, Unit)) -> String {
    format!("{count} {}", unit.name())
}

pub(crate) fn to_f64(time: Seconds) -> f64 {
    *time.numer() as f64 / *time.denom() as f64
}
