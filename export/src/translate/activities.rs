//! What a control task does with activities: it marks, releases and frees them.

use dotgen_timing::system::ServiceId;

use crate::model::{Edge, Guard, Process, Term, Update, all, any};

use super::layout::{Layout, Part, status, tracked};

/// Returns the updates that begin the examination of all activities.
pub(super) fn examine(part: &Part) -> Vec<Update> {
    vec![part.own("ended").set(0_usize), part.own("at").set(0_usize)]
}

/// Returns the updates that make the aperiodic task of a place runnable under a condition.
pub(super) fn resume_task(part: &Part, place: &Term, condition: &Guard) -> Vec<Update> {
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
    for (client, number) in layout.trackers() {
        let tracker = layout.tracker(client, number);
        let follows = tracker.clone().is(place.clone().plus((tracked::PLACE + part.offset) as i64));
        if layout.asks_outcome(client, number) {
            let failed = all([follows.clone(), part.success(place.clone()).is(0_usize)]);
            out.push(tracker.clone().set_if(failed, tracked::FAILED));
        }
        out.push(tracker.set_if(follows, tracked::NOTHING));
    }
    out.extend(part.clear(place));
    out
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
