//! Systems prepared for a run, with the questions of their checks.

use super::checks::{Single, What, expand};
use super::group::Group;
use super::{Cancel, Options, SystemInput, events, settings};
use crate::diagnostic::Diagnostic;
use crate::explore::{Run, Watched};
use crate::property::{Monitor, Predicate, data, resolve};
use crate::report::{CheckReport, Event, Report, TimeUnit, to_f64};
use crate::scn::ast::{Pred, Scenario};
use crate::scn::names::Names;
use crate::system::Ticks;
use crate::system::build::build;
use crate::system::indexed::Built;
use crate::system::indexed::DeclaredTask;
use dotgen_analysis::model::Seconds;

/// A system, and the questions of its checks.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// The system.
    pub built: Built,
    /// Checks, in order of the scenario; `*` gives one per task.
    pub checks: Vec<PreparedCheck>,
    /// Checks of chains, which are about data and have no question: `reaction A -> B`.
    pub chains: Vec<String>,
    /// The report before any answer: names, assumptions, diagnostics. If one of the diagnostics is an error,
    /// the system must not be run.
    pub report: Report,
}

/// A check, resolved in the system.
#[derive(Debug, Clone)]
pub struct PreparedCheck {
    /// Report of the check, without an answer.
    pub report: CheckReport,
    pub question: Question,
    /// Comparisons of data in the check, by number in [`Built::data`].
    pub data: Vec<usize>,
}

/// The question of a check, for every moment of a run. Tasks are numbered as in the system.
#[derive(Debug, Clone)]
pub enum Question {
    /// No tick comes before the previous job has ended.
    Schedulable(usize),
    /// No job waits for a core for its whole period.
    NoOverdue(usize),
    /// No job lasts longer than the limit, in base units, if there is one.
    Response(usize, Option<Ticks>),
    /// The other predicates follow the first one, in order, within the limit (in base units) if there is one.
    Within(Predicate, Vec<Predicate>, Option<Ticks>),
    /// The second predicate follows the first.
    LeadsTo(Predicate, Predicate),
    /// The predicate becomes true.
    Eventually(Predicate),
    Always(Predicate),
    /// The predicate can become true.
    Reachable(Predicate),
    /// The monitor is not violated.
    Pattern(Monitor),
    /// Some event always follows.
    Deadlock,
}

/// Builds a system and resolves its checks.
pub fn prepare(input: &SystemInput, scenario: &Scenario, options: &Options) -> Prepared {
    let names = Names::new(&input.specs);
    let settings = settings(scenario, options);
    let unit = TimeUnit::of(&settings);
    let mut built = build(&names, &settings, &|_| true);
    built.data = Some(data::facts(&names, &built, &settings.checks));
    let mut diagnostics = built.diagnostics.clone();
    let singles = expand(&names, &built, &settings, &mut diagnostics);
    if names.components.is_empty() {
        let message = "there is no component to run".to_owned();
        diagnostics.push(Diagnostic::error("scn-no-component", 0..0, message));
    }
    let cancel = Cancel::default();
    let group = Group {
        names: &names,
        built: &built,
        unit,
        settings: &settings,
        limits: options.limits,
        until_failure: false,
        cancel: &cancel,
        tell: &|_| {},
    };
    let checks = singles.iter().filter_map(|expand| {
        let question = group.question(expand)?;
        let data = (built.data.iter().flatten().enumerate())
            .filter(|(_, fact)| {
                data::facts(&names, &built, std::slice::from_ref(expand.check)).contains(fact)
            })
            .map(|(number, _)| number)
            .collect();
        Some(PreparedCheck { report: group.open(expand), question, data })
    });
    let checks = checks.collect();
    let chains = singles.iter().filter(|check| matches!(check.what, What::Chain(_)));
    let shown = |report: CheckReport| format!("{} {}", report.kind, report.of);
    let chains: Vec<String> = chains.map(|check| shown(group.open(check))).collect();
    let report = Report {
        scenario: settings.name.clone(),
        semantics: settings.semantics().text(),
        unit,
        assumptions: built.assumptions.clone(),
        notes: not_followed(&chains).into_iter().collect(),
        diagnostics,
        ..Report::default()
    };
    Prepared { built, checks, chains, report }
}

/// Returns the note about checks of chains, which cannot be checked along a run.
fn not_followed(chains: &[String]) -> Option<String> {
    let list: Vec<String> = chains.iter().map(|chain| format!("`{chain}`")).collect();
    let list = list.join(", ");
    (!chains.is_empty()).then(|| {
        format!("not checked along runs: {list}; runs follow no data, `dotgen verify` answers these checks")
    })
}

impl Group<'_> {
    /// Returns the question of a check; `None` if the check names something that does not exist, which was
    /// reported.
    fn question(&self, check: &Single) -> Option<Question> {
        let task = |task: &DeclaredTask| self.built.tasks.get(task).map(|&task| usize::from(task));
        let predicate = |predicate: &Pred| resolve::resolve(self.names, self.built, predicate).ok();
        Some(match &check.what {
            What::Schedulable(of) => Question::Schedulable(task(of)?),
            What::NoOverdue(overdue) => Question::NoOverdue(task(overdue)?),
            What::Response(of, bound) => Question::Response(task(of)?, self.ticks(*bound)),
            What::Within(p, list, bound) => {
                let list: Option<Vec<Predicate>> = list.iter().map(predicate).collect();
                Question::Within(predicate(p)?, list?, self.ticks(*bound))
            }
            // Chains are not checked along a run.
            What::Chain(_) => return None,
            What::LeadsTo(p, q) => Question::LeadsTo(predicate(p)?, predicate(q)?),
            What::Eventually(p) => Question::Eventually(predicate(p)?),
            What::Always(p) => Question::Always(predicate(p)?),
            What::Reachable(p) => Question::Reachable(predicate(p)?),
            What::Pattern(pattern) => Question::Pattern(self.monitor(pattern)?),
            What::Deadlock => Question::Deadlock,
        })
    }
}

impl Prepared {
    /// Returns a run of the system in words, like a counterexample. `input` holds the specifications of the
    /// system.
    pub fn told(&self, input: &SystemInput, run: &Run) -> Vec<Event> {
        let names = Names::new(&input.specs);
        events::told(&names, &self.built.system, self.report.unit, run)
    }

    /// Converts a time from base units to the unit of the report.
    pub fn time(&self, ticks: u64) -> f64 {
        let time = self.built.system.seconds(ticks);
        self.report.unit.from_seconds(time)
    }

    /// Converts a time from base units to seconds.
    pub fn seconds(&self, ticks: u64) -> f64 {
        to_f64(self.built.system.seconds(ticks))
    }

    /// Converts seconds, which must not be negative, to base units, rounded down.
    pub fn ticks(&self, seconds: Seconds) -> u64 {
        let ticks = (seconds / self.built.system.unit).to_integer();
        u64::try_from(ticks).unwrap_or(u64::MAX)
    }

    /// Returns what is watched along a run, and for each check its index in [`Watched::reach`],
    /// [`Watched::within`] or [`Watched::monitors`], if it has one.
    pub fn watched(&self) -> (Watched, Vec<Option<usize>>) {
        let facts = self.built.data.iter().flatten().count();
        let mut out = Watched { facts, ..Watched::default() };
        let mut places = Vec::new();
        for check in &self.checks {
            let mut reach = |predicate: Predicate| {
                out.reach.push(predicate);
                Some(out.reach.len() - 1)
            };
            places.push(match &check.question {
                Question::Always(p) => reach(p.clone().negation()),
                Question::Reachable(p) | Question::Eventually(p) => reach(p.clone()),
                Question::Within(p, list, _) => {
                    out.within.push((p.clone(), list.clone()));
                    Some(out.within.len() - 1)
                }
                Question::LeadsTo(p, q) => {
                    out.within.push((p.clone(), vec![q.clone()]));
                    Some(out.within.len() - 1)
                }
                Question::Pattern(monitor) => {
                    out.monitors.push(monitor.clone());
                    Some(out.monitors.len() - 1)
                }
                Question::Schedulable(_)
                | Question::NoOverdue(_)
                | Question::Response(..)
                | Question::Deadlock => None,
            });
        }
        (out, places)
    }
}
