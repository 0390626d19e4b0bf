//! The process of a control task: requests, and the release and end of activities.

use dotgen_timing::system::ServiceId;

use crate::model::{Edge, Guard, LocationKind, Process, Term, Update, all, any};

use super::layout::{Layout, Part, status, step, tracked};
use super::requests;

/// Returns the process of a control task.
pub(super) fn process(layout: &Layout, part: &Part) -> Process {
    let name = format!("control_{}", part.name);
    let mut out = Process::new(&name, format!("the control task of {}", part.name));
    out.location("ready", LocationKind::Normal, "waits for requests and ends of activities");
    requests::add(layout, part, &mut out);
    out.location("examines", LocationKind::Committed, "examines the activities, in order");
    out.location("interrupts", LocationKind::Committed, "a waiting activity interrupts others");
    let signal = Edge::new("ready", "examines", "handles the ends of activities");
    let ended = all([part.step().is(step::READY), part.own("ended").is(1_usize)]);
    out.edge(signal.when(ended).with(examine(part)));
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

/// Returns the updates that begin the examination of all activities.
pub(super) fn examine(part: &Part) -> Vec<Update> {
    vec![part.own("ended").set(0_usize), part.own("at").set(0_usize)]
}

/// Returns the updates that make the aperiodic task of a place runnable under a condition.
fn resume_task(part: &Part, place: &Term, condition: &Guard) -> Vec<Update> {
    let aperiodic = part.tasks.iter().filter(|task| task.period.is_none());
    let own = aperiodic.map(|task| {
        let mut guards = vec![condition.clone()];
        if part.tasks.len() > 1 {
            guards.push(place.clone().at_least(task.base));
            guards.push(place.clone().below(task.base + task.count));
        }
        task.due().set_if(all(guards), 1_usize)
    });
    own.collect()
}

/// Returns the updates that free a place, and end the waits for its activity.
pub(super) fn free(layout: &Layout, part: &Part, place: &Term) -> Vec<Update> {
    let mut out = vec![
        part.status(place.clone()).set(status::FREE),
        part.kind(place.clone()).set(0_usize),
        part.state(place.clone()).set(0_usize),
        part.permanent(place.clone()).set(0_usize),
    ];
    out.extend(part.clear(place));
    for (client, number) in layout.trackers() {
        let tracker = layout.tracker(client, number);
        let value = place.clone().plus((tracked::PLACE + part.offset) as i64);
        out.push(tracker.clone().set_if(tracker.is(value), tracked::NOTHING));
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

/// Returns the numbers of the activities that a service interrupts, if they can run.
pub(super) fn interrupted<'p>(
    layout: &Layout,
    part: &'p Part,
    service: ServiceId,
) -> impl Iterator<Item = usize> + 'p {
    let list = layout.system.services[service].interrupts.clone();
    let listed = part
        .kinds
        .iter()
        .filter(move |kind| kind.service.is_some_and(|service| list.contains(&service)));
    listed.map(|kind| kind.number)
}

/// The marks that a service sets on the activities it interrupts. `itself`: its kind and place, which is not
/// marked.
pub(super) fn mark(
    layout: &Layout,
    part: &Part,
    service: ServiceId,
    location: &str,
    itself: Option<(usize, &Term)>,
    out: &mut Process,
) {
    let (other, held) = (part.own("other"), part.own("held"));
    let is = |value: usize| part.status(other.clone()).is(value);
    let kinds = interrupted(layout, part, service);
    let listed = any(kinds.map(|kind| part.kind(other.clone()).is(kind)));
    let mut guards = vec![listed];
    if let Some((kind, at)) = itself {
        guards.push(part.kind(at.clone()).is(kind));
        guards.push(other.clone().is_not(at.clone()));
    }
    let marked = all(guards);
    let mut passed = vec![marked.negated()];
    if let Some((kind, at)) = itself {
        // The other kinds that interrupt have edges of their own.
        passed = vec![all([part.kind(at.clone()).is(kind), marked.negated()])];
    }
    passed.push(all([marked.clone(), any([is(status::FREE), is(status::ENDED)])]));
    let next = other.clone().set(other.clone().plus(1));
    let mut add = |guard: Guard, comment: &str, updates: Vec<Update>| {
        let edge = Edge::new(location, location, comment).when(guard);
        out.edge(edge.with(updates).with([next.clone()]));
    };
    let set = part.interrupted(other.clone()).set(1_usize);
    let accepted = all([marked.clone(), is(status::ACCEPTED)]);
    add(accepted, "an activity that waits is interrupted", vec![set.clone()]);
    let mut updates = vec![set, held.clone().set(1_usize)];
    updates.extend(resume_task(part, &other, &Guard::always()));
    add(all([marked.clone(), is(status::RUNS)]), "an activity is interrupted", updates);
    add(all([marked, is(status::STOPS)]), "an activity stops already", vec![held.set(1_usize)]);
    let inside = other.is_not(part.size - 1);
    add(all([any(passed), inside]), "not interrupted", Vec::new());
}
