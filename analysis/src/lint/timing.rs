//! Rules about execution times and periods.

use crate::finding::role::Role;
use num_rational::Ratio;

use crate::model::fsm::Machine;
use crate::model::turn::Turn;
use crate::model::{CodelKind, Owner, Seconds, ServiceId, ServiceKind, Src};

use super::Lint;
use crate::finding::lints::{Chain, LintWarning, Share, Time};

pub(super) fn check(lint: &mut Lint) {
    let timed = lint.has_timing();
    if timed || lint.config.always_missing_wcet {
        missing_wcet(lint);
    }
    for owner in lint.component.owners() {
        wcet_exceeds_period(lint, owner);
    }
    if timed {
        no_period(lint);
        overutilised(lint);
    }
    suspicious_units(lint);
}

/// `timing/missing-wcet`: one finding at each codel.
fn missing_wcet(lint: &mut Lint) {
    for owner in lint.component.owners() {
        for codel in lint.component.codels_of(owner).iter().filter(|codel| codel.wcet.is_none()) {
            lint.report(codel.src, LintWarning::MissingWcet { codel: codel.name.clone() });
        }
    }
}

/// `timing/wcet-exceeds-period`: a codel, or the chain of codels of one turn, longer than the period.
fn wcet_exceeds_period(lint: &mut Lint, owner: Owner) {
    let Some(period) = lint.period_of(owner).filter(|p| *p > Ratio::from_integer(0)) else {
        return;
    };
    let machine = Machine::new(lint.component.codels_of(owner));
    let task = lint.task_of(owner).map(|t| &lint.component.tasks[t]);
    let Some(task) = task else { return };
    let period_src = task.period.as_ref().map_or(task.src, |p| p.src);
    let mut reported: Vec<usize> = Vec::new();
    for (v, (_, codel)) in machine.codels.iter().enumerate() {
        let Some(wcet) = codel.wcet.as_ref().filter(|w| w.value > period && !codel.is_async) else {
            continue;
        };
        reported.push(v);

        let at = wcet.src;
        let found = lint.report(
            at,
            LintWarning::CodelExceedsPeriod {
                codel: codel.name.clone(),
                time: Time(wcet.value),
                task: task.name.clone(),
                period: Time(period),
            },
        );
        found.related.push((period_src, Role::PeriodOf(task.name.clone())));
    }
    for state in machine.turn_starts() {
        let Some(Turn::Bounded { sum, chain, .. }) = machine.longest_turn(state) else {
            continue;
        };
        if sum <= period || chain.len() < 2 || chain.iter().any(|v| reported.contains(v)) {
            continue;
        }
        let steps = chain.iter().map(|&v| {
            let codel = machine.at(v);
            (codel.name.clone(), codel.wcet.as_ref().map(|w| Time(w.value)))
        });
        let steps = Chain(steps.collect());
        let at = machine.at(chain[0]).src;

        let found = lint.report(
            at,
            LintWarning::ChainExceedsPeriod {
                state: state.into(),
                owner: lint.owner_name(owner),
                time: Time(sum),
                chain: steps,
                task: task.name.clone(),
                period: Time(period),
            },
        );
        found.related = chain[1..]
            .iter()
            .map(|&v| (machine.at(v).src, Role::Then(machine.at(v).name.clone())))
            .chain([(period_src, Role::PeriodOf(task.name.clone()))])
            .collect();
        // Later starts of the same chain are redundant.
        reported.extend(chain);
    }
}

/// `timing/no-period`: execution times in a task without period, which bound nothing.
fn no_period(lint: &mut Lint) {
    for (index, task) in lint.component.tasks.iter_enumerated() {
        if task.period.is_some() {
            continue;
        }
        let runs_here = |s: &&crate::model::Service| s.task == Some(index);
        let timed = task.codels.iter().any(|c| c.wcet.is_some())
            || lint
                .component
                .services
                .iter()
                .filter(runs_here)
                .flat_map(|s| &s.codels)
                .any(|c| c.wcet.is_some());
        let pauses = task.codels.iter().flat_map(|c| &c.yields).any(|s| s.paused);
        if timed && pauses {
            lint.report(task.src, LintWarning::NoPeriod { task: task.name.clone() });
        }
    }
}

/// `timing/overutilised`: the permanent activities alone need more cores than the platform has.
fn overutilised(lint: &mut Lint) {
    let Some(cores) = lint.config.cores else {
        return;
    };
    let mut total = Ratio::from_integer(0);
    let mut parts: Vec<(Src, Role)> = Vec::new();
    for (index, task) in lint.component.tasks.iter_enumerated() {
        let Some(share) = lint.component.utilisation(index) else {
            continue;
        };
        total += share;
        parts.push((task.src, Role::Load { task: task.name.clone(), share: Share(share) }));
    }
    if total > Ratio::from_integer(i128::from(cores)) {
        let found = lint.report(
            lint.component.src,
            LintWarning::Overutilised {
                component: lint.component.name.clone(),
                share: Share(total),
                cores,
            },
        );
        found.related = parts;
    }
}

/// `timing/suspicious-unit`: numbers that look like a forgotten or mistaken unit.
fn suspicious_units(lint: &mut Lint) {
    let long = Ratio::from_integer(10);
    let short = Ratio::new(10, 1_000_000);
    for reference in lint.component.all_codels().collect::<Vec<_>>() {
        let codel = lint.codel(reference);
        if let Some(wcet) = codel.wcet.as_ref().filter(|w| w.value > long) {
            lint.report(
                wcet.src,
                LintWarning::LongCodel { codel: codel.name.clone(), time: Time(wcet.value) },
            );
        }
    }
    for task in &lint.component.tasks {
        if let Some(period) =
            task.period.as_ref().filter(|p| p.value > Ratio::from_integer(0) && p.value < short)
        {
            lint.report(
                period.src,
                LintWarning::ShortPeriod { task: task.name.clone(), period: Time(period.value) },
            );
        }
    }
}

/// Sum of the execution times of the codels that the control task runs for a service, in seconds.
pub(super) fn control_task_time(lint: &Lint, service: ServiceId) -> Option<Seconds> {
    let service = &lint.component.services[service];
    if service.kind == ServiceKind::Activity {
        return None;
    }
    let codels = service.codels.iter().filter(|c| c.kind != CodelKind::Fsm);
    let sum: Seconds = codels.filter_map(|c| Some(c.wcet.as_ref()?.value)).sum();
    (sum > Ratio::from_integer(0)).then_some(sum)
}
