//! Rules about codels that block each other.

use crate::finding::role::Role;
use crate::finding::{
    Severity,
    lints::{LintWarning, Time},
};
use crate::model::mutex::{self, Excluded, SharedParameters};
use crate::model::{CodelRef, Owner, TaskId};
use crate::phrase::Phrase;

use super::Lint;

pub(super) fn check(lint: &mut Lint) {
    for codel in lint.component.all_codels().collect::<Vec<_>>() {
        let exclusions = mutex::exclusions(lint.spec, lint.component, codel);
        long_hold(lint, codel, &exclusions);
        self_blocking(lint, codel);
    }
}

/// `lock/long-hold`: a codel that holds data longer than the period of a task that needs it.
fn long_hold(lint: &mut Lint, codel: CodelRef, exclusions: &[mutex::Exclusion]) {
    let Some(wcet) = lint.codel(codel).wcet.as_ref().map(|q| (q.value, q.src)) else {
        return;
    };
    let mut seen: Vec<TaskId> = Vec::new();
    for exclusion in exclusions {
        let Excluded::Codel(other) = exclusion.with else {
            continue;
        };
        let Some(task) = lint.component.task_of(other) else {
            continue;
        };
        if seen.contains(&task) || only_starts_or_stops(lint, other) {
            continue;
        }
        let component = lint.component;
        let Some(period) = component.tasks[task].period.as_ref() else {
            continue;
        };
        if wcet.0 <= period.value {
            continue;
        }
        seen.push(task);
        let name = &component.tasks[task].name;
        let through = describe(lint, &exclusion.through);
        let found = lint.report(
            wcet.1,
            LintWarning::LongHold {
                codel: lint.codel_name(codel),
                through: through.as_str().into(),
                time: Time(wcet.0),
                task: name.clone(),
                period: Time(period.value),
                other: lint.codel_name(other),
            },
        );
        found.related.push((component.codel(other).src, Role::WaitsFor(through.as_str().into())));
        found.related.push((period.src, Role::PeriodOfWaiting));
    }
}

/// `lock/self-blocking`: an asynchronous codel and another codel of its own task use the same data, so the
/// task waits for its own activity.
fn self_blocking(lint: &mut Lint, codel: CodelRef) {
    if !lint.codel(codel).is_async {
        return;
    }
    let Some(task) = lint.component.task_of(codel) else {
        return;
    };
    for other in lint.component.all_codels().collect::<Vec<_>>() {
        // One instance runs its own codels one after the other.
        if other.owner == codel.owner || lint.component.task_of(other) != Some(task) {
            continue;
        }
        if only_starts_or_stops(lint, other) {
            continue;
        }
        let other_codel = lint.codel(other);
        let through = mutex::collisions(lint.spec, lint.codel(codel), lint.codel(other));
        if through.is_empty() {
            continue;
        }
        let through = describe(lint, &through);
        let task_name = lint.component.tasks[task].name.clone();
        let at = lint.codel(codel).src;
        let found = lint.report(
            at,
            LintWarning::SelfBlocking {
                codel: lint.codel_name(codel),
                through: through.as_str().into(),
                other: lint.codel_name(other),
                task: task_name,
            },
        );
        found.severity = Severity::Information;
        found.related.push((other_codel.src, Role::AlsoUses(through.as_str().into())));
        return;
    }
}

/// The data two codels share: `trajectory` of the ids.
fn describe(lint: &Lint, through: &[SharedParameters]) -> String {
    let mut names: Vec<Phrase> = Vec::new();
    for parameter in through {
        let name = parameter.shared.describe(lint.component);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    Phrase::joined(&names, " and ").to_string()
}

/// Returns true for a codel of a task that is bound only to `start` or `stop` and has no incoming transition:
/// it runs before or after all others.
pub(super) fn only_starts_or_stops(lint: &Lint, codel: CodelRef) -> bool {
    let ends = |name: &str| name == "start" || name == "stop";
    let mut yields = lint.component.codels_of(codel.owner).iter().flat_map(|c| &c.yields);
    matches!(codel.owner, Owner::Task(_))
        && lint.codel(codel).triggers.iter().all(|s| ends(&s.name))
        && yields.all(|s| s.name != "start")
}
