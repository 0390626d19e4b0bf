//! Rules about execution times and periods.

use num_rational::Ratio;

use crate::model::fsm::Machine;
use crate::model::turn::Turn;
use crate::model::{CodelKind, CodelRef, Owner, Seconds, ServiceKind, Src};
use crate::quantity;

use super::{Lint, duration, list};

pub(super) fn check(lint: &mut Lint) {
    let timed = lint.has_timing();
    if timed || lint.config.always_missing_wcet {
        missing_wcet(lint);
    }
    for owner in lint.owners() {
        wcet_exceeds_period(lint, owner);
    }
    if timed {
        no_period(lint);
        overutilised(lint);
    }
    suspicious_units(lint);
}

/// `timing/missing-wcet`: one finding for each task or service.
fn missing_wcet(lint: &mut Lint) {
    for owner in lint.owners() {
        let missing: Vec<(CodelRef, Src)> = (0..)
            .zip(lint.component.codels_of(owner))
            .filter(|(_, codel)| codel.wcet.is_none())
            .map(|(index, codel)| (CodelRef { owner, index }, codel.src))
            .collect();
        let Some(&(_, at)) = missing.first() else {
            continue;
        };
        let names: Vec<&str> = missing
            .iter()
            .map(|(it, _)| lint.codel(*it).name.as_str())
            .collect();
        let (has, counts) = match names.len() {
            1 => ("has", "counts"),
            _ => ("have", "count"),
        };
        let message = format!(
            "{} of {} {has} no execution time and {counts} as taking none; add `wcet` with the measured worst case",
            list(&names),
            lint.owner_text(owner)
        );
        let found = lint.report("timing/missing-wcet", at, message);
        found.related = missing[1..]
            .iter()
            .map(|&(_, src)| (src, "no execution time either".into()))
            .collect();
    }
}

/// `timing/wcet-exceeds-period`: a codel, or the chain of codels of one turn, longer than the period.
fn wcet_exceeds_period(lint: &mut Lint, owner: Owner) {
    let Some(period) = lint
        .period_of(owner)
        .filter(|p| *p > Ratio::from_integer(0))
    else {
        return;
    };
    let machine = Machine::new(lint.component.codels_of(owner));
    let task = lint
        .task_of(owner)
        .map(|t| &lint.component.tasks[t as usize]);
    let Some(task) = task else { return };
    let period_src = task.period.as_ref().map_or(task.src, |p| p.src);
    let mut reported: Vec<usize> = Vec::new();
    for (v, (_, codel)) in machine.codels.iter().enumerate() {
        let Some(wcet) = codel
            .wcet
            .as_ref()
            .filter(|w| w.value > period && !codel.is_async)
        else {
            continue;
        };
        reported.push(v);
        let message = format!(
            "codel `{}` can take {}, longer than the period of task `{}` ({}); split it, make it `async`, or lengthen the period",
            codel.name,
            duration(wcet.value),
            task.name,
            duration(period)
        );
        let at = wcet.src;
        let found = lint.report("timing/wcet-exceeds-period", at, message);
        found
            .related
            .push((period_src, format!("period of task `{}`", task.name)));
    }
    for state in machine.turn_starts() {
        let Some(Turn::Bounded { sum, chain, .. }) = machine.longest_turn(state) else {
            continue;
        };
        if sum <= period || chain.len() < 2 || chain.iter().any(|v| reported.contains(v)) {
            continue;
        }
        let steps: Vec<String> = chain
            .iter()
            .map(|&v| {
                let codel = machine.at(v);
                let time = codel
                    .wcet
                    .as_ref()
                    .map_or("?".to_owned(), |w| duration(w.value));
                format!("{} {time}", codel.name)
            })
            .collect();
        let at = machine.at(chain[0]).src;
        let message = format!(
            "from `{state}` to the next pause, {} can take {} ({}), longer than the period of task `{}` ({}); pause in between",
            lint.owner_text(owner),
            duration(sum),
            steps.join(" + "),
            task.name,
            duration(period)
        );
        let found = lint.report("timing/wcet-exceeds-period", at, message);
        found.related = chain[1..]
            .iter()
            .map(|&v| (machine.at(v).src, format!("then `{}`", machine.at(v).name)))
            .chain([(period_src, format!("period of task `{}`", task.name))])
            .collect();
        // Later starts of the same chain say nothing new.
        reported.extend(chain);
    }
}

/// `timing/no-period`: execution times in a task without period bound nothing.
fn no_period(lint: &mut Lint) {
    for (index, task) in lint.component.tasks.iter().enumerate() {
        if task.period.is_some() {
            continue;
        }
        let runs_here = |s: &&crate::model::Service| s.task == Some(index as u32);
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
            lint.report(
                "timing/no-period",
                task.src,
                format!(
                    "task `{}` has execution times and a permanent activity that pauses, but no `period`: nothing says how often \
                     it runs, so its load and response times cannot be computed",
                    task.name
                ),
            );
        }
    }
}

/// `timing/overutilised`: the permanent activities alone need more than the platform has.
fn overutilised(lint: &mut Lint) {
    let Some(cores) = lint.config.cores else {
        return;
    };
    let mut total = Ratio::from_integer(0);
    let mut parts: Vec<(Src, String)> = Vec::new();
    for (index, task) in lint.component.tasks.iter().enumerate() {
        let Some(share) = lint.component.utilisation(index as u32) else {
            continue;
        };
        total += share;
        parts.push((
            task.src,
            format!("task `{}` needs {}", task.name, quantity::load(share)),
        ));
    }
    if total > Ratio::from_integer(i128::from(cores)) {
        let found = lint.report(
            "timing/overutilised",
            lint.component.src,
            format!(
                "the permanent activities of `{}` need {} of a core, but the platform has {cores}; lengthen periods or shorten codels",
                lint.component.name,
                quantity::load(total)
            ),
        );
        found.related = parts;
    }
}

/// `timing/suspicious-unit`: numbers that look like a forgotten or mistaken unit.
fn suspicious_units(lint: &mut Lint) {
    let long = Ratio::from_integer(10);
    let short = Ratio::new(10, 1_000_000);
    for it in lint.component.all_codels().collect::<Vec<_>>() {
        let codel = lint.codel(it);
        if let Some(wcet) = codel.wcet.as_ref().filter(|w| w.value > long) {
            let message = format!(
                "codel `{}` has a worst case of {}: a number without unit is in seconds; write `ms` or `us` if that was meant",
                codel.name,
                duration(wcet.value)
            );
            lint.report("timing/suspicious-unit", wcet.src, message);
        }
    }
    for task in &lint.component.tasks {
        if let Some(period) = task
            .period
            .as_ref()
            .filter(|p| p.value > Ratio::from_integer(0) && p.value < short)
        {
            let message = format!(
                "task `{}` has a period of {}, shorter than any real scheduler can keep; check the unit",
                task.name,
                duration(period.value)
            );
            lint.report("timing/suspicious-unit", period.src, message);
        }
    }
}

/// Total of the execution times of the codels that the control task runs for a service.
pub(super) fn control_task_time(lint: &Lint, service: u32) -> Option<Seconds> {
    let service = &lint.component.services[service as usize];
    if service.kind == ServiceKind::Activity {
        return None;
    }
    let codels = service.codels.iter().filter(|c| c.kind != CodelKind::Fsm);
    let sum: Seconds = codels.filter_map(|c| Some(c.wcet.as_ref()?.value)).sum();
    (sum > Ratio::from_integer(0)).then_some(sum)
}
