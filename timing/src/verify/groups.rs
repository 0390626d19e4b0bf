//! Independent groups of components, which are verified separately.

use typed_index_collections::{TiVec, ti_vec};

use super::checks::{Single, What};
use crate::scn::names::Names;
use crate::system::indexed::Built;
use crate::system::{ClientAction, ComponentId};

/// Divides the components into groups that share no lock, core, client or check. Such groups do not influence
/// each other (section 11).
pub(super) fn groups(names: &Names, whole: &Built, checks: &[Single]) -> Vec<Vec<usize>> {
    let n = names.components.len();
    let mut group: Vec<usize> = (0..n).collect();
    let mut join = |one: usize, other: usize| {
        let (from, to) = (group[one], group[other]);
        for group in &mut group {
            if *group == from {
                *group = to;
            }
        }
    };
    let system = &whole.system;
    let mut outer: TiVec<ComponentId, usize> = ti_vec![0; n];
    for (&c, &number) in &whole.components {
        outer[number] = c;
    }
    for codel in &system.codels {
        for other in codel.conflicts.iter() {
            join(outer[codel.component], outer[system.codels[other].component]);
        }
    }
    if system.platform.cores.is_some() {
        let on_cores: Vec<usize> = system
            .tasks
            .keys()
            .filter(|&task| system.needs_core(task))
            .map(|task| outer[system.tasks[task].component])
            .collect();
        on_cores.windows(2).for_each(|window| join(window[0], window[1]));
    }
    for client in &system.clients {
        let addressed: Vec<usize> = client
            .steps
            .iter()
            .filter_map(|step| match step.action {
                ClientAction::Send { service, .. } => {
                    Some(outer[system.services[service].component])
                }
                _ => None,
            })
            .collect();
        addressed.windows(2).for_each(|window| join(window[0], window[1]));
    }
    for check in checks {
        check.components.windows(2).for_each(|window| join(window[0], window[1]));
        if matches!(check.what, What::Deadlock) {
            (1..n).for_each(|other| join(0, other));
        }
    }
    let mut out: Vec<Vec<usize>> = Vec::new();
    for root in 0..n {
        let members: Vec<usize> = (0..n).filter(|&member| group[member] == root).collect();
        if !members.is_empty() {
            out.push(members);
        }
    }
    out.sort();
    out
}
