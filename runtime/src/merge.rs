//! The reports of parts of one set of runs as one report.

use std::collections::BTreeSet;

use dotgen_timing::report::Value;

use crate::checker::Verdict;
use crate::counts::{MachineCounts, Transition, mean};
use crate::report::{CheckOutcome, RunMoment, RunReport, Violated, ViolationReport, together};

impl RunReport {
    /// Merges reports of runs of the same system. Their seeds say which runs they are about.
    ///
    /// # Errors
    ///
    /// Returns the reason if the parts are not about one system, or share a run.
    pub fn merge(mut parts: Vec<RunReport>) -> Result<RunReport, String> {
        parts.sort_by_key(|part| part.seed);
        for part in &parts {
            if part.runs == 0 || part.seed.checked_add(part.runs).is_none() {
                return Err(format!(
                    "{} runs from the seed {} are not part of a set of runs",
                    part.runs, part.seed
                ));
            }
        }
        for pair in parts.windows(2) {
            let (one, other) = (&pair[0], &pair[1]);
            one.check_same_system(other)?;
            if other.seed - one.seed < one.runs {
                return Err(format!("two reports contain the run with the seed {}", other.seed));
            }
        }
        let is_gap = |two: &[RunReport]| two[1].seed - two[0].seed > two[0].runs;
        let gaps = parts.windows(2).filter(|two| is_gap(two)).count();
        let mut parts = parts.into_iter();
        let mut whole = parts.next().ok_or("no report to merge")?;
        for part in parts {
            whole.add(part);
        }
        whole.verdict = together(whole.violation_count, &whole.checks);
        whole.estimate();
        if gaps > 0 {
            whole.notes.push(
                "the seeds of the runs have gaps: reports of some runs may be missing".to_owned(),
            );
        }
        Ok(whole)
    }

    fn check_same_system(&self, other: &RunReport) -> Result<(), String> {
        let checks = |report: &RunReport| -> Vec<_> {
            let checks = report.checks.iter();
            let shown = |check: &CheckOutcome| {
                (check.name.clone(), check.check, check.of.clone(), check.limit)
            };
            checks.map(shown).collect()
        };
        let periods = |report: &RunReport| -> Vec<Option<Value>> {
            report.tasks.iter().map(|task| task.period).collect()
        };
        let names = |report: &RunReport| -> Vec<String> {
            let tasks = report.tasks.iter().map(|task| task.task.clone());
            let services = report.services.iter().map(|service| service.service.clone());
            let codels = report.codels.iter().map(|codel| codel.codel.clone());
            let ports = report.ports.iter().map(|port| port.port.clone());
            let machines = report.machines.iter().map(|machine| machine.machine.clone());
            tasks.chain(services).chain(codels).chain(ports).chain(machines).collect()
        };
        let differs = [
            (self.format != other.format, "versions of the report"),
            (self.scenario != other.scenario, "scenarios"),
            (self.semantics != other.semantics, "semantics"),
            (self.unit != other.unit, "units of time"),
            (self.durations != other.durations, "choices of durations"),
            (self.until != other.until, "durations of a run"),
            (periods(self) != periods(other), "periods"),
            (checks(self) != checks(other), "checks"),
            (names(self) != names(other), "components"),
            (self.assumptions != other.assumptions, "assumptions"),
            (self.model != other.model, "systems, execution times or weights"),
        ];
        match differs.into_iter().find(|(differ, _)| *differ) {
            Some((_, what)) => Err(format!("the reports have different {what}")),
            None => Ok(()),
        }
    }

    /// Adds a report of later runs of the same system.
    fn add(&mut self, other: RunReport) {
        let before = other.seed - self.seed;
        let (time, more) = (number(self.time), number(other.time));
        for (one, other) in self.tasks.iter_mut().zip(other.tasks) {
            let total = number(one.total) + number(other.total);
            one.jobs += other.jobs;
            (one.total, one.mean) = (Value::Time(total), mean(total, one.jobs));
            one.greatest = greater(one.greatest, other.greatest);
            one.missed += other.missed;
            let load = |one: f64, other: f64| {
                (one * time + other * more) / (time + more).max(f64::MIN_POSITIVE)
            };
            one.load = one.load.zip(other.load).map(|(one, other)| load(one, other));
        }
        for (one, other) in self.services.iter_mut().zip(other.services) {
            one.requests += other.requests;
            one.refused += other.refused;
            one.ended += other.ended;
        }
        for (one, other) in self.codels.iter_mut().zip(other.codels) {
            one.runs += other.runs;
            one.greatest =
                greater(Some(one.greatest), Some(other.greatest)).unwrap_or(one.greatest);
            one.waited = greater(Some(one.waited), Some(other.waited)).unwrap_or(one.waited);
        }
        for (one, other) in self.machines.iter_mut().zip(other.machines) {
            one.add(other);
        }
        for (one, other) in self.ports.iter_mut().zip(other.ports) {
            one.writes += other.writes;
            one.greatest_age = greater(one.greatest_age, other.greatest_age);
        }
        for (one, other) in self.checks.iter_mut().zip(other.checks) {
            one.add(other, before);
        }
        for mut violation in other.violations {
            violation.at.run += before;
            match self.violations.iter_mut().find(|known| known.is_same(&violation)) {
                Some(known) => known.times += violation.times,
                None => self.violations.push(violation),
            }
        }
        let known: BTreeSet<String> = self.notes.iter().cloned().collect();
        self.notes.extend(other.notes.into_iter().filter(|note| !known.contains(note)));
        self.unfinished.extend(other.unfinished);
        self.violation_count += other.violation_count;
        self.requests_outside_model += other.requests_outside_model;
        self.time = Value::Time(time + more);
        self.runs += other.runs;
        self.end = other.end;
        self.is_sample &= other.is_sample;
    }
}

impl MachineCounts {
    /// Adds counts of the same machine. Exceptions are listed only if they were thrown.
    fn add(&mut self, other: MachineCounts) {
        for other in other.transitions {
            let same = |one: &Transition| (&one.from, &one.to) == (&other.from, &other.to);
            if let Some(one) = self.transitions.iter_mut().find(|one| same(one)) {
                one.taken += other.taken;
                one.greatest = greater(one.greatest, other.greatest);
                continue;
            }
            let last = self.transitions.iter().rposition(|one| one.from == other.from);
            self.transitions.insert(last.map_or(0, |last| last + 1), other);
        }
    }
}

impl CheckOutcome {
    /// Adds the outcome of later runs, which come after `before` others.
    fn add(&mut self, other: CheckOutcome, before: u64) {
        let rank = |verdict: Verdict| match verdict {
            Verdict::NotExercised | Verdict::NotSeen => 0,
            Verdict::Kept | Verdict::Seen => 1,
            Verdict::Simulated => 2,
            Verdict::Violated => 3,
        };
        if rank(other.verdict) > rank(self.verdict) {
            let at = other.at.map(|at| RunMoment { run: at.run + before, ..at });
            (self.verdict, self.at, self.why) = (other.verdict, at, other.why);
        }
        self.greatest = greater(self.greatest, other.greatest);
        self.exceeded |= other.exceeded;
        self.violations += other.violations;
        self.in_runs += other.in_runs;
    }
}

impl ViolationReport {
    /// Returns true if another violation is of the same kind, and of the same part of the system.
    fn is_same(&self, other: &ViolationReport) -> bool {
        match (&self.what, &other.what) {
            (Violated::Check { check }, Violated::Check { check: other }) => check == other,
            (Violated::BeyondBound { task, .. }, Violated::BeyondBound { task: other, .. }) => {
                task == other
            }
            (
                Violated::Undeclared { codel, event, .. },
                Violated::Undeclared { codel: other, event: another, .. },
            ) => (codel, event) == (other, another),
            (Violated::Lost { component, .. }, Violated::Lost { component: other, .. }) => {
                component == other
            }
            (Violated::Overrun { codel, .. }, Violated::Overrun { codel: other, .. }) => {
                codel == other
            }
            _ => false,
        }
    }
}

fn number(value: Value) -> f64 {
    match value {
        Value::Time(time) => time,
        Value::Unbounded => f64::INFINITY,
    }
}

fn greater(one: Option<Value>, other: Option<Value>) -> Option<Value> {
    match (one, other) {
        (Some(one), Some(other)) => Some(if number(other) > number(one) { other } else { one }),
        (one, other) => one.or(other),
    }
}
