//! The process of a task: its cycles, with a turn for each activity that has work.

use dotgen_timing::explore::Action;

use crate::model::{Edge, Guard, LocationKind, Process, Relation, Term, Update, all, any, var};

use super::super::checks::Checks;
use super::super::layout::{Layout, Part, TaskPart, position};
use super::super::published::{mode, waits_clock};

/// Returns the process of a task.
pub(super) fn process(layout: &Layout, part: &Part, task: &TaskPart, checks: &Checks) -> Process {
    let words = layout.task_in_words(task.id);
    let comment = match task.period {
        Some(period) => format!("task {words}, period {}", layout.time(period)),
        None => format!("task {words}, aperiodic"),
    };
    let mut out = Process::new(&format!("task_{}", task.name), comment);
    out.location("rests", LocationKind::Normal, "not started, or between two cycles");
    out.location("gives", LocationKind::Committed, "looks for the next activity of the cycle");
    out.location("runs", LocationKind::Normal, "an activity has its turn");
    release(layout, task, checks, &mut out);
    turns(layout, part, task, &mut out);
    let over = Edge::new("runs", "gives", "the turn is over");
    out.edge(over.receives(&format!("over_{}", task.name)));
    out
}

/// The updates that begin a cycle.
fn begins(task: &TaskPart) -> [Update; 2] {
    [task.position().set(position::CYCLE), task.flag("turn").set(0_usize)]
}

/// The release of a task, and its core.
fn release(layout: &Layout, task: &TaskPart, checks: &Checks, out: &mut Process) {
    let id = usize::from(task.id);
    let release = Edge::new("rests", "gives", "takes its tick and begins a cycle")
        .when(layout.is_released(task))
        .begins(Action::Release { task: id })
        .with([task.due().set(0_usize)])
        .with(checks.at_release(task));
    if !task.needs_core {
        out.edge(release.receives("begin").with(begins(task)));
        return;
    }
    out.location("waits", LocationKind::Normal, "waits for a core");
    let queue = |index: Term| Term::element("core_queue", index);
    let (length, used) = (var("core_waiting"), var("cores_used"));
    let tasks = layout.system.tasks.len();
    let mut release = release.with([task.position().set(position::WAITS)]);
    if layout.inserts(task) {
        "inserts".clone_into(&mut release.target);
        let clock = Update::Reset(waits_clock(task));
        out.edge(release.receives("begin").with([task.flag("at").set(0_usize), clock]));
        insert(layout, task, out);
    } else {
        "waits".clone_into(&mut release.target);
        let mut release = release.receives("ask");
        if layout.is_fifo() {
            release.updates.push(queue(length.clone()).set(id + 1));
            release.updates.push(length.clone().set(length.clone().plus(1)));
        }
        out.edge(release);
    }
    let mut grant = Edge::new("waits", "gives", "gets a core")
        .receives("grant")
        .begins(Action::Grant { task: id })
        .with([used.clone().set(used.plus(1))]);
    if layout.queues_for_cores() {
        grant.guard = queue(Term::from(0_usize)).is(id + 1);
        let shift = |index: usize| queue(Term::from(index)).set(queue(Term::from(index + 1)));
        grant.updates.extend((0..tasks).map(shift));
        grant.updates.push(length.clone().set(length.plus(-1)));
    }
    out.edge(grant.with(begins(task)));
}

/// The insertion into the queue for cores: behind all tasks whose deadline is not later.
fn insert(layout: &Layout, task: &TaskPart, out: &mut Process) {
    out.location("inserts", LocationKind::Committed, "looks for its place in the queue for cores");
    let queue = |index: Term| Term::element("core_queue", index);
    let (at, length) = (task.flag("at"), var("core_waiting"));
    let tasks = layout.system.tasks.len();
    let mut updates: Vec<Update> = (0..tasks)
        .rev()
        .map(|index| {
            let behind = Guard::Compare(Term::from(index), Relation::AtLeast, at.clone());
            queue(Term::from(index + 1)).set_if(behind, queue(Term::from(index)))
        })
        .collect();
    updates.push(queue(at.clone()).set(usize::from(task.id) + 1));
    updates.push(length.clone().set(length.clone().plus(1)));
    updates.push(at.clone().set(0_usize));
    let mut add = |guard: Guard, clock: Option<(&TaskPart, Relation, i64)>, passes: bool| {
        let (target, comment) = if passes {
            ("inserts", "the deadline there is not later")
        } else {
            ("waits", "takes its place")
        };
        let mut edge = Edge::new("inserts", target, comment).when(guard);
        if let Some((other, relation, value)) = clock {
            edge = edge.when_clock(&waits_clock(other), relation, value);
        }
        out.edge(if passes {
            edge.with([at.clone().set(at.clone().plus(1))])
        } else {
            edge.sends("step").with(updates.clone())
        });
    };
    add(at.clone().is(length), None, false);
    let others = layout.parts.iter().flat_map(|part| &part.tasks);
    for other in others.filter(|other| other.needs_core && other.id != task.id) {
        let is_other = queue(at.clone()).is(usize::from(other.id) + 1);
        match (other.period, task.period) {
            (_, None) => add(is_other, None, true),
            (None, Some(_)) => add(is_other, None, false),
            (Some(other_period), Some(period)) if other_period <= period => {
                add(is_other, None, true);
            }
            (Some(other_period), Some(period)) => {
                let elapsed = other_period - period;
                add(is_other.clone(), Some((other, Relation::AtLeast, elapsed)), true);
                add(is_other, Some((other, Relation::Less, elapsed)), false);
            }
        }
    }
}

/// The turns of a cycle.
fn turns(layout: &Layout, part: &Part, task: &TaskPart, out: &mut Process) {
    let turn = task.flag("turn");
    let automata = layout.automata(task.id);
    for (index, &id) in automata.iter().enumerate() {
        let name = layout.automaton_name(id);
        let works = layout.can_run(id);
        let edge = |target: &str, comment: String| {
            let edge = Edge::new("gives", target, comment).when(turn.clone().is(index));
            edge.with([turn.clone().set(index + 1)])
        };
        out.edge(edge("gives", format!("{name} has nothing to do")).when(works.negated()));
        let give = edge("runs", format!("the turn of {name}")).sends(&layout.turn(id));
        if layout.system.automata[id].service.is_none() {
            out.edge(give.when(works));
            continue;
        }
        let interrupted = layout.interrupted(id).is(1_usize);
        out.edge(give.clone().when(all([works.clone(), interrupted.negated()])));
        let noticed = layout.interrupted(id).set(0_usize);
        let stopped = all([works, interrupted]);
        out.edge(match layout.system.machine_of(id).stop {
            Some(stop) => give
                .when(stopped)
                .with([layout.mode(id).set(mode::STOPS), layout.state(id).set(stop)])
                .with([noticed]),
            None => edge("gives", format!("{name} has no stop codel: it ends"))
                .when(stopped)
                .with([layout.mode(id).set(mode::ENDED), layout.state(id).set(0_usize)])
                .with([noticed]),
        });
    }
    let end =
        Edge::new("gives", "rests", "the cycle is over").when(turn.clone().is(automata.len()));
    let mut end = end.sends("step").with([task.position().set(position::IDLE)]);
    end.updates.push(turn.set(0_usize));
    if task.needs_core {
        let used = var("cores_used");
        end.updates.push(used.clone().set(used.plus(-1)));
    }
    let activities = automata.iter().filter(|&&id| layout.system.automata[id].service.is_some());
    let ended = any(activities.map(|&id| layout.mode(id).is(mode::ENDED)));
    if part.control {
        end.updates.push(part.own("ended").set_if(ended, 1_usize));
    }
    out.edge(end);
}
