//! Trials: one thing is changed, and all checks concerned are verified again.

use std::time::Instant;

use dotgen_analysis::model::{self, Seconds};

use super::change::Change;
use crate::explore::Limits;
use crate::limit::{Grid, Phase};
use crate::report::{CheckReport, Report, TimeUnit, Verdict};
use crate::scn::ast::{Durations, Path, Policy};
use crate::scn::names::Names;
use crate::system::build::build;
use crate::system::indexed::Built;
use crate::system::settings::Settings;
use crate::system::{Codel, CodelName, FOREVER, SharedPorts, TaskId, Ticks};
use crate::verify::{Cancel, verify_until_failure};

/// Number of additional cores that are tried.
const MORE_CORES: u32 = 3;

/// Number of parts of a period by which a task is tried to start later.
const OFFSETS: Ticks = 8;

/// The checks that must hold, and the effort for a trial.
pub(super) struct Trial<'t> {
    pub(super) names: &'t Names<'t>,
    /// Settings of the unchanged system, with the checks that must hold.
    settings: Settings,
    built: Built,
    report_unit: TimeUnit,
    limits: Limits,
    cancel: &'t Cancel,
    /// The report on the unchanged system.
    report: &'t Report,
    /// Time after which no further change is tried.
    end: Option<Instant>,
}

impl<'t> Trial<'t> {
    pub(super) fn new(
        names: &'t Names<'t>,
        settings: Settings,
        report: &'t Report,
        limits: Limits,
        cancel: &'t Cancel,
        end: Option<Instant>,
    ) -> Self {
        Trial {
            built: build(names, &settings, &|_| true),
            names,
            report_unit: TimeUnit::of(&settings),
            settings,
            limits,
            cancel,
            report,
            end,
        }
    }

    /// Returns true if a check holds for the reason only that nothing happens any more.
    fn is_emptied(&self, check: &CheckReport) -> bool {
        let same = |before: &&CheckReport| before.kind == check.kind && before.of == check.of;
        let was_empty = |before: &CheckReport| before.verdict == Verdict::Vacuous;
        check.verdict == Verdict::Vacuous
            && !self.report.checks.iter().find(same).is_some_and(was_empty)
    }

    /// Returns the unchanged system.
    pub(super) fn built(&self) -> &Built {
        &self.built
    }

    /// Verifies the checks that must hold, with these settings.
    fn holds(&self, settings: &Settings) -> Verdict {
        self.holds_within(settings, Phase::Units)
    }

    fn holds_within(&self, settings: &Settings, phase: Phase) -> Verdict {
        let mut limits = self.limits;
        limits.states = limits.states.min(phase.states());
        let late = self.end.is_some_and(|end| Instant::now() > end);
        if late || self.cancel.is_over() {
            return Verdict::Unknown;
        }
        let report = verify_until_failure(self.names, settings, limits, self.cancel);
        let checks = &report.checks;
        if report.has_errors() || checks.is_empty() {
            Verdict::Unknown
        } else if let Some(check) = checks.iter().find(|check| !check.verdict.holds()) {
            check.verdict
        } else if checks.iter().any(|check| check.exceeds() || self.is_emptied(check)) {
            Verdict::Refuted
        } else {
            Verdict::Proved
        }
    }

    fn with(&self, change: impl FnOnce(&mut Settings)) -> bool {
        let mut settings = self.settings.clone();
        change(&mut settings);
        self.holds(&settings) == Verdict::Proved
    }

    fn seconds(&self, ticks: Ticks) -> Seconds {
        self.built.system.seconds(ticks)
    }

    fn shown(&self, seconds: Seconds) -> f64 {
        self.report_unit.from_seconds(seconds)
    }

    /// Finds the longest execution time of a codel with which the checks hold.
    pub(super) fn wcet(&self, path: &CodelName) -> Option<Change> {
        let system = &self.built.system;
        let codel = system.codels.iter().find(|codel| codel.path == *path)?;
        let (lower, upper) = (codel.lower, codel.upper);
        let fixed = self.settings.durations == Durations::Fixed;
        if upper == FOREVER {
            return None;
        }
        let longest = system.tasks.iter().filter_map(|task| task.period).max();
        let grid = Grid::of(&self.settings, system.unit, self.seconds(longest.unwrap_or(upper)));
        // A codel must take time, and its greatest time cannot be below its least time.
        let least = if fixed { 1 } else { grid.steps(lower).max(1) };
        let upper_steps = grid.steps(upper);
        if upper_steps <= least {
            return None;
        }
        let mut settings = self.settings.clone();
        let mut holds = |time: Seconds, phase: Phase| {
            settings.upper_bound = Some((Path::of(path), time));
            self.holds_within(&settings, phase)
        };
        if !holds(grid.time(least), Phase::Units).holds() {
            return None;
        }
        let at_most = grid.time(grid.last(least, upper_steps, holds).steps);
        let c = codel.site.map(|site| site.0);
        Some(Change::Wcet {
            codel: path.to_owned(),
            now: self.shown(self.seconds(upper)),
            at_most: self.shown(at_most),
            seconds: at_most,
            or_less: !fixed,
            src: c.and_then(|c| Some((self.names.components[c].spec_index, codel.src?))),
        })
    }

    /// Finds a longer period of a task with which the checks hold, up to four times the present one, next to
    /// a period with which they do not hold.
    pub(super) fn period(&self, task: TaskId) -> Option<Change> {
        let (c, declared) = self.declared(task)?;
        let path = self.built.system.task_path(task);
        let now = self.built.system.tasks[task].period?;
        let mut settings = self.settings.clone();
        let grid = Grid::of(&self.settings, self.built.system.unit, self.seconds(now));
        let mut holds = |time: Seconds, phase: Phase| {
            settings.period = Some((Path::of(&path), time));
            self.holds_within(&settings, phase)
        };
        let mut fails = grid.steps(now);
        let found = [2, 4].into_iter().find_map(|times| {
            let longer = grid.steps(now).checked_mul(times)?;
            if holds(grid.time(longer), Phase::Units).holds() {
                return Some((longer, fails));
            }
            fails = longer;
            None
        });
        let (longer, fails) = found?;
        let needed = grid.time(grid.last(longer, fails, holds).steps);
        let src = self.names.components[c].component.tasks[declared].period.as_ref()?.src;
        Some(Change::Period {
            task: path,
            now: self.shown(self.seconds(now)),
            needed: self.shown(needed),
            seconds: needed,
            src: Some((self.names.components[c].spec_index, src)),
        })
    }

    /// Finds an offset of a task with which the checks hold: the first of some parts of its period.
    pub(super) fn delay(&self, task: TaskId) -> Option<Change> {
        let (c, declared) = self.declared(task)?;
        let definition = &self.built.system.tasks[task];
        let (path, period, now) =
            (self.built.system.task_path(task), definition.period?, definition.delay);
        let parts =
            (1..OFFSETS).map(|offset| u64::from(period) * u64::from(offset) / u64::from(OFFSETS));
        let mut parts: Vec<Ticks> = parts.filter_map(|ticks| Ticks::try_from(ticks).ok()).collect();
        parts.retain(|&delay| delay > now);
        parts.dedup();
        let with = |ticks: &Ticks| {
            let delay = (Path::of(&path), self.seconds(*ticks));
            self.with(|settings| settings.delay = Some(delay))
        };
        let needed = self.seconds(parts.into_iter().find(with)?);
        let member = self.names.components[c];
        let task = &member.component.tasks[declared];
        Some(Change::Delay {
            task: path,
            now: self.shown(self.seconds(now)),
            needed: self.shown(needed),
            seconds: needed,
            src: Some((member.spec_index, task.delay.as_ref().map_or(task.src, |delay| delay.src))),
        })
    }

    /// Tests a copy of the data that a codel shares with another one. A copy also separates the codel from
    /// all other codels with which it shares nothing else.
    pub(super) fn apart(&self, codel: &CodelName, other: &CodelName) -> Option<Change> {
        let codels = &self.built.system.codels;
        let find = |path: &CodelName| codels.iter().find(|codel| codel.path == *path);
        let ports = SharedPorts::new(self.names, &self.settings);
        let (copies, through) = (find(codel)?, ports.through(find(codel)?, find(other)?));
        let shares_less = |codel: &&Codel| {
            let words = ports.through(copies, codel);
            !words.is_empty() && words.iter().all(|word| through.contains(word))
        };
        let others = codels.iter().filter(shares_less);
        let others: Vec<CodelName> = others.map(|codel| codel.path.clone()).collect();
        self.with(|settings| settings.apart = Some((codel.clone(), others))).then(|| Change::Lock {
            codel: codel.clone(),
            other: other.clone(),
            through: through.iter().map(ToString::to_string).collect(),
        })
    }

    /// Finds the least number of additional cores with which the checks hold.
    pub(super) fn cores(&self) -> Option<Change> {
        let now = self.settings.cores?;
        let enough = |needed: &u32| self.with(|settings| settings.cores = Some(*needed));
        let needed = (now + 1..=now + MORE_CORES).find(enough)?;
        Some(Change::Cores { now, needed })
    }

    /// Tests another policy.
    pub(super) fn policy(&self, needed: Policy) -> Option<Change> {
        let now = self.settings.policy();
        let useful = self.settings.cores.is_some() && needed != now;
        let holds = useful && self.with(|settings| settings.stated_policy = Some(needed));
        holds.then_some(Change::Policy { now, needed })
    }

    /// Returns the component of a task, as in [`Names::components`], and the index of the task there.
    fn declared(&self, task: TaskId) -> Option<(usize, model::TaskId)> {
        let mut tasks = self.built.tasks.iter();
        let (declared, _) = tasks.find(|candidate| *candidate.1 == task)?;
        Some((declared.component, declared.index))
    }
}
