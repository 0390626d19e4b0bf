//! Parts of a verification: groups of components with their checks.

use super::bounds::ResponseBounds;
use super::checks::Single;
use super::group::Group;
use super::groups::groups;
use super::rounding;
use super::seen::Seen;
use crate::diagnostic::remark::Sighting;
use crate::explore::{Findings, Stop, Watch, explore};
use crate::report::Report;
use crate::scn::names::Names;
use crate::system::ServiceId;
use crate::system::build::build;
use crate::system::indexed::Built;
use crate::system::settings::Settings;

/// The note of a report whose checks were all answered before the exploration was complete.
const NOT_EXAMINED: &str =
    "no request was seen to be refused for want of a slot, but not everything was looked at";

/// A group with its checks: the question to each stage, and what earlier stages know of it.
#[derive(Clone)]
pub(super) struct Part<'p> {
    pub(super) group: Group<'p>,
    /// All checks of the scenario.
    pub(super) checks: &'p [Single<'p>],
    /// Indices of the checks of this group.
    pub(super) of_group: &'p [usize],
    /// The scenario has no other group.
    pub(super) alone: bool,
    pub(super) analysed: ResponseBounds<'p>,
    pub(super) seen: Seen,
    /// Refused requests were looked for, or seen.
    pub(super) examined: bool,
    /// Checks that fail with rounded times, and for which no run with the exact times was found.
    pub(super) unconfirmed: Vec<usize>,
}

impl<'p> Part<'p> {
    pub(super) fn new(
        group: Group<'p>,
        checks: &'p [Single<'p>],
        of_group: &'p [usize],
        alone: bool,
    ) -> Self {
        Part {
            group,
            checks,
            of_group,
            alone,
            analysed: ResponseBounds::new(group.built, group.cancel),
            seen: Seen::none(checks.len()),
            examined: false,
            unconfirmed: Vec::new(),
        }
    }

    /// Returns the checks without an answer, with their indices.
    pub(super) fn open(&self, report: &Report) -> Vec<(usize, &'p Single<'p>)> {
        let open = self.of_group.iter().filter(|&&i| report.is_open(i));
        open.map(|&i| (i, &self.checks[i])).collect()
    }

    /// Notes the requests that can be refused, among those seen so far.
    pub(super) fn refusals(&mut self, found: &Findings, report: &mut Report) {
        let system = &self.group.built.system;
        let path = |&service: &ServiceId| system.service_path(service);
        let refused = found.refused.iter().map(path);
        let restarts = found.restarts.iter().map(path);
        let seen = (refused.map(|service| Sighting::NoSlot { service }))
            .chain(restarts.map(|service| Sighting::RestartsEndBoth { service }));
        seen.for_each(|no_slot| report.note(no_slot.to_string()));
        let looked = found.stopped != Some(Stop::Answered) && found.hold_cores.is_empty();
        self.examined |= looked || !found.refused.is_empty();
    }

    /// Adds notes about what was not found. If no exploration looked for refused requests, a short one does.
    pub(super) fn finish(&mut self, report: &mut Report) {
        let Group { built, limits, cancel, .. } = self.group;
        if !self.examined {
            let found = explore(&built.system, &Watch::default(), limits, cancel);
            self.refusals(&found, report);
        }
        if !self.examined && self.group.built.system.may_refuse() {
            report.note(NOT_EXAMINED.to_owned());
        }
        rounding::note_unconfirmed(&self.unconfirmed, report);
    }

    /// Returns true if no stage is needed any more.
    pub(super) fn is_done(&self, report: &Report) -> bool {
        self.of_group.iter().all(|&i| !report.is_open(i))
            || self.group.until_failure && report.refuted()
    }
}

/// A group of components as a system, and the indices of its checks.
pub(super) struct Parted {
    pub(super) built: Built,
    pub(super) of_group: Vec<usize>,
}

/// Returns the groups of components that have checks.
pub(super) fn parted(
    names: &Names,
    settings: &Settings,
    whole: &Built,
    checks: &[Single],
) -> Vec<Parted> {
    let groups = groups(names, whole, checks);
    let mut out = Vec::new();
    for group in &groups {
        let of_group: Vec<usize> = (0..checks.len())
            .filter(|&i| {
                checks[i].components.first().is_none_or(|component| group.contains(component))
            })
            .collect();
        if of_group.is_empty() {
            continue;
        }
        let built = match groups.len() {
            1 => whole.clone(),
            _ => build(names, settings, &|c| group.contains(&c)),
        };
        out.push(Parted { built, of_group });
    }
    out
}
