//! From specifications and a scenario to a report.

use std::time::Instant;

use dotgen_analysis::model::{Seconds, Spec};
use num_rational::Ratio;

pub use crate::cancel::Cancel;
use crate::explore::{
    Bound, Findings, Found, Limits, LivenessQuery, Measured, MomentKind, ResponseTime, Run, Stop,
    Watch, Within, explore, liveness,
};
use crate::property::{Predicate, resolve};
use crate::report::{CheckReport, Event, Report, Soundness, Value, Verdict};
use crate::scn::Diagnostic;
use crate::scn::ast::{
    Bound as AstBound, Check, CheckKind, Durations, Path, Policy, Pred, Scenario, Unit,
};
use crate::scn::names::Names;
use crate::system::build::{Built, build};
use crate::system::settings::Settings;
use crate::system::{ClientAction, Ticks};

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

/// A check of one thing.
struct Single<'c> {
    check: &'c Check,
    what: What<'c>,
    /// Components it is about; none: all of them.
    components: Vec<usize>,
}

enum What<'c> {
    Schedulable((usize, u32)),
    NoOverdue((usize, u32)),
    Response((usize, u32), AstBound),
    Within(&'c Pred, &'c Pred, AstBound),
    LeadsTo(&'c Pred, &'c Pred),
    Eventually(&'c Pred),
    Always(&'c Pred),
    Reachable(&'c Pred),
    Deadlock,
}

/// Checks of everything (`*`) become one per task.
fn expand<'c>(
    names: &Names,
    whole: &Built,
    settings: &'c Settings,
    diagnostics: &mut Vec<Diagnostic>,
) -> Vec<Single<'c>> {
    let mut out = Vec::new();
    let tasks = |path: &Option<Path>, periodic: bool| -> Result<Vec<(usize, u32)>, Diagnostic> {
        let has_period = |&(c, t): &(usize, u32)| {
            names.components[c].component.tasks[t as usize]
                .period
                .is_some()
        };
        if let Some(path) = path {
            let task = resolve::task(names, path)?;
            if periodic && !has_period(&task) {
                let message = format!(
                    "`{}` has no period, so this does not apply to it",
                    path.text()
                );
                return Err(Diagnostic::error("scn-aperiodic", path.range(), message));
            }
            return Ok(vec![task]);
        }
        let all =
            names.components.iter().enumerate().flat_map(|(c, member)| {
                (0..member.component.tasks.len() as u32).map(move |t| (c, t))
            });
        Ok(all.filter(|it| !periodic || has_period(it)).collect())
    };
    for check in &settings.checks {
        let mut push = |what, components| {
            out.push(Single {
                check,
                what,
                components,
            })
        };
        let mut preds = |list: &[&Pred]| -> Vec<usize> {
            let mut components = Vec::new();
            for pred in list {
                if let Err(error) = resolve::resolve(names, whole, pred) {
                    diagnostics.push(error);
                }
                resolve::components_of(names, whole, pred, &mut components);
            }
            components
        };
        let result: Result<(), Diagnostic> = match &check.kind {
            CheckKind::Schedulable(path) => tasks(path, true).map(|it| {
                it.into_iter()
                    .for_each(|it| push(What::Schedulable(it), vec![it.0]))
            }),
            CheckKind::NoOverdue(path) => tasks(path, true).map(|it| {
                it.into_iter()
                    .for_each(|it| push(What::NoOverdue(it), vec![it.0]))
            }),
            CheckKind::Response(path, bound) => tasks(path, false).map(|it| {
                it.into_iter()
                    .for_each(|it| push(What::Response(it, *bound), vec![it.0]));
            }),
            CheckKind::Within(p, q, bound) => {
                let components = preds(&[p, q]);
                push(What::Within(p, q, *bound), components);
                Ok(())
            }
            CheckKind::LeadsTo(p, q) => {
                let components = preds(&[p, q]);
                push(What::LeadsTo(p, q), components);
                Ok(())
            }
            CheckKind::Eventually(p) => {
                let components = preds(&[p]);
                push(What::Eventually(p), components);
                Ok(())
            }
            CheckKind::Always(p) => {
                let components = preds(&[p]);
                push(What::Always(p), components);
                Ok(())
            }
            CheckKind::Reachable(p) => {
                let components = preds(&[p]);
                push(What::Reachable(p), components);
                Ok(())
            }
            CheckKind::Deadlock => {
                push(What::Deadlock, Vec::new());
                Ok(())
            }
        };
        if let Err(error) = result {
            diagnostics.push(error);
        }
    }
    if settings.checks.is_empty() {
        let message = "the scenario checks nothing; add `check schedulable *;`".to_owned();
        diagnostics.push(Diagnostic::warning("scn-no-check", 0..0, message));
    }
    out
}

/// Divides the components into groups that share no lock, core, client or check. What one group does
/// is independent of the others (section 11).
fn groups(names: &Names, whole: &Built, checks: &[Single]) -> Vec<Vec<usize>> {
    let n = names.components.len();
    let mut group: Vec<usize> = (0..n).collect();
    let mut join = |one: usize, other: usize| {
        let (from, to) = (group[one], group[other]);
        for it in &mut group {
            if *it == from {
                *it = to;
            }
        }
    };
    let system = &whole.system;
    let mut outer = vec![0; n];
    for (&c, &number) in &whole.components {
        outer[number] = c;
    }
    for codel in &system.codels {
        for other in codel.conflicts.iter() {
            join(
                outer[codel.component],
                outer[system.codels[other].component],
            );
        }
    }
    if system.platform.cores.is_some() {
        let on_cores: Vec<usize> = (0..system.tasks.len())
            .filter(|&it| system.needs_core(it))
            .map(|it| outer[system.tasks[it].component])
            .collect();
        on_cores.windows(2).for_each(|it| join(it[0], it[1]));
    }
    for client in &system.clients {
        let addressed: Vec<usize> = client
            .steps
            .iter()
            .filter_map(|it| match it.action {
                ClientAction::Send { service, .. } => {
                    Some(outer[system.services[service].component])
                }
                _ => None,
            })
            .collect();
        addressed.windows(2).for_each(|it| join(it[0], it[1]));
    }
    for check in checks {
        check
            .components
            .windows(2)
            .for_each(|it| join(it[0], it[1]));
        if matches!(check.what, What::Deadlock) {
            (1..n).for_each(|it| join(0, it));
        }
    }
    let mut out: Vec<Vec<usize>> = Vec::new();
    for root in 0..n {
        let members: Vec<usize> = (0..n).filter(|&it| group[it] == root).collect();
        if !members.is_empty() {
            out.push(members);
        }
    }
    out.sort();
    out
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

impl Group<'_> {
    /// Answers the checks of this group.
    fn answer(
        &self,
        checks: &[Single],
        of_group: &[usize],
        answers: &mut [Option<CheckReport>],
        report: &mut Report,
    ) {
        let mut watch = Watch::default();
        // Where the answer to each check will be found.
        let mut places = Vec::new();
        let predicate = |pred: &Pred| resolve::resolve(self.names, self.built, pred).ok();
        for &i in of_group {
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
        let explored = places
            .iter()
            .any(|&(i, _)| !matches!(checks[i].what, What::LeadsTo(..) | What::Eventually(_)));
        let found = if explored {
            explore(&self.built.system, &watch, self.limits, self.cancel)
        } else {
            Findings::default()
        };
        report.states += found.states;
        report.steps += found.steps;
        report.memory = report.memory.max(found.bytes);
        for &service in &found.refused {
            report.notes.push(format!(
                "a request of {} can be refused because all its slots are in use",
                self.built.system.service_path(service)
            ));
        }
        for (i, place) in places {
            answers[i] = Some(match checks[i].what {
                What::LeadsTo(p, q) => self.live(&checks[i], Some(p), q, report),
                What::Eventually(p) => self.live(&checks[i], None, p, report),
                _ => self.one(&checks[i], place, &found),
            });
        }
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
        let stopped = found.stopped;
        let absent = |it: &Option<Found>, out: &mut CheckReport| match it {
            Some(found) => {
                out.verdict = Verdict::Refuted;
                out.counterexample = self.events(&found.run);
            }
            None => self.unless_stopped(stopped, found.states, Verdict::Proved, out),
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
                None => self.unless_stopped(stopped, found.states, Verdict::Refuted, &mut out),
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
        states: usize,
        verdict: Verdict,
        out: &mut CheckReport,
    ) {
        match stopped {
            None => out.verdict = verdict,
            Some(Stop::Limit) => out.note = Some(format!("gave up at {states} states")),
            Some(Stop::Answered) => {}
            Some(Stop::Cancelled) => out.note = Some("cancelled".to_owned()),
        }
    }

    fn bounded(&self, it: &Option<Measured>, never: &str, found: &Findings, out: &mut CheckReport) {
        let Some(it) = it else {
            out.note = Some(never.to_owned());
            self.unless_stopped(found.stopped, found.states, Verdict::Proved, out);
            return;
        };
        let base = self.built.system.unit;
        let time = |ticks| base * Ratio::from_integer(i128::from(ticks));
        out.value = Some(match it.bound {
            Bound::Unbounded => Value::Unbounded,
            Bound::Finite(ticks) => Value::Time(to_f64(time(ticks) / self.unit)),
        });
        if let (Some(Stop::Limit | Stop::Cancelled), Bound::Finite(_)) = (found.stopped, it.bound) {
            let states = found.states;
            out.note = Some(format!("gave up at {states} states: this is a lower bound"));
        }
        if let Some(excess) = &it.excess {
            out.verdict = Verdict::Refuted;
            out.counterexample = self.events(&excess.run);
        } else if it.bound == Bound::Unbounded {
            out.verdict = Verdict::Refuted;
            out.counterexample = self.events(&it.longest.run);
        } else {
            out.witness = self.events(&it.longest.run);
            self.unless_stopped(found.stopped, found.states, Verdict::Proved, out);
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
                out.verdict = Verdict::Refuted;
                let prefix = Run {
                    steps: run.steps[..run.cycle.unwrap_or(run.steps.len())].to_vec(),
                    ..run.clone()
                };
                out.counterexample = self.events(run);
                if run.cycle.is_some() {
                    out.cycle = Some(self.events(&prefix).len());
                } else {
                    out.note = Some("after the end of the run nothing ever happens".to_owned());
                }
            }
            None => self.unless_stopped(found.stopped, found.states, Verdict::Proved, &mut out),
        }
        out
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
