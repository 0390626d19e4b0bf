//! The process of a control task: requests, and the release and end of activities.

use dotgen_timing::explore::Action;

use crate::model::{Edge, Guard, LocationKind, Process, all, any};

use super::activities::{examine, free, interrupted, mark, resume_task};
use super::layout::{Layout, Part, status, step};
use super::requests;

/// Returns the process of a control task.
pub(super) fn process(layout: &Layout, part: &Part) -> Process {
    let name = format!("control_task_{}", part.name);
    let mut out = Process::new(&name, format!("the control task of {}", part.name));
    out.location("ready", LocationKind::Normal, "waits for requests and ends of activities");
    requests::add(layout, part, &mut out);
    out.location("examines", LocationKind::Committed, "examines the activities, in order");
    out.location("interrupts", LocationKind::Committed, "a waiting activity interrupts others");
    let signal = Edge::new("ready", "examines", "handles the ends of activities");
    let ended = all([part.step().is(step::READY), part.own("ended").is(1_usize)]);
    out.edge(signal.when(ended).with(examine(part)).begins(Action::Signal { component: part.id }));
    examination(layout, part, &mut out);
    if part.activities {
        let (at, released) = (part.own("at"), part.own("held").is(0_usize));
        let comment = "all that it interrupts are marked: it may begin unless some still run";
        let edge = Edge::new("interrupts", "examines", comment);
        let mut edge = edge.when(part.own("other").is(part.size - 1));
        edge.updates.push(part.released(at.clone()).set_if(released.clone(), 1_usize));
        edge.updates.extend(resume_task(part, &at, &released));
        edge.updates.push(at.clone().set(at.plus(1)));
        out.edge(edge);
    }
    out
}

/// The examination: activities that have ended are reported, accepted ones are released.
fn examination(layout: &Layout, part: &Part, out: &mut Process) {
    let at = part.own("at");
    let edge = |target: &str, comment: &str| Edge::new("examines", target, comment);
    let is = |value: usize| part.status(at.clone()).is(value);
    let next = at.clone().set(at.clone().plus(1));
    let mut cases = vec![(None, Guard::always())];
    if part.activities {
        let noted = part
            .kinds
            .iter()
            .filter(|kind| kind.service.is_some_and(|service| layout.notes_success(service)));
        let noted: Vec<_> = noted.collect();
        let others = all(noted.iter().map(|kind| part.kind(at.clone()).is_not(kind.number)));
        cases = vec![(None, others)];
        cases
            .extend(noted.iter().map(|kind| (kind.service, part.kind(at.clone()).is(kind.number))));
    }
    for (service, guard) in cases {
        let edge = edge("examines", "an activity has ended: its place is free");
        let mut edge = edge.when(all([is(status::ENDED), guard]));
        if let Some(service) = service {
            let success = part.success(at.clone()).is(1_usize);
            edge.updates.push(layout.success(service).set_if(success, 1_usize));
        }
        out.edge(edge.with(free(layout, part, &at)).with([next.clone()]));
    }
    let mut passed = vec![any([is(status::FREE), is(status::RUNS), is(status::STOPS)])];
    let waits = if part.activities {
        passed.push(all([is(status::ACCEPTED), part.released(at.clone()).is(1_usize)]));
        all([is(status::ACCEPTED), part.released(at.clone()).is(0_usize)])
    } else {
        passed.push(is(status::ACCEPTED));
        any([])
    };
    let skip = edge("examines", "no activity, or one that may go on");
    out.edge(skip.when(any(passed)).with([next.clone()]));
    for kind in part.kinds.iter().filter(|_| part.activities) {
        let interrupts =
            kind.service.is_some_and(|service| interrupted(layout, part, service).next().is_some());
        let guard = all([waits.clone(), part.kind(at.clone()).is(kind.number)]);
        if let Some(service) = kind.service.filter(|_| interrupts) {
            let edge = edge("interrupts", &format!("{} interrupts others first", kind.name));
            let updates = [part.own("other").set(0_usize), part.own("held").set(0_usize)];
            out.edge(edge.when(guard).with(updates));
            mark(layout, part, service, "interrupts", Some((kind.number, &at)), out);
        } else {
            let edge = edge("examines", &format!("{} may begin", kind.name));
            let released = part.released(at.clone()).set(1_usize);
            let edge = edge.when(guard).with([released]);
            out.edge(edge.with(resume_task(part, &at, &Guard::always())).with([next.clone()]));
        }
    }
    let last = part.size.saturating_sub(1);
    let ends = edge("examines", "the end of the places of a task");
    let inner = all([is(status::LAST), at.clone().is_not(last)]);
    out.edge(ends.when(inner).with([next]));
    let edge = edge("ready", "all activities are examined").sends("step");
    let end = all([is(status::LAST), at.clone().is(last)]);
    out.edge(edge.when(end).with([at.set(0_usize), part.own("held").set(0_usize)]));
}
