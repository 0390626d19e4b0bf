//! The settings of a scenario, independent of the order of its statements.

use std::ops::Range;

use dotgen_analysis::model::Seconds;

use crate::scn::ast::{Check, Client, Durations, Interval, Item, Path, Policy, Scenario, Unit};
use crate::scn::semantics::{Points, Preset, Semantics};
use crate::scn::times::TimesFile;
use crate::system::CodelName;

/// The settings of a scenario, with the options that override it.
#[derive(Debug, Clone, Default)]
pub struct Settings {
    /// Name of the scenario.
    pub name: String,
    /// Unit of values in the result.
    pub unit: Option<(u64, Unit)>,
    /// Execution times are rounded to the unit: a system with fewer states, for proofs and candidates.
    pub rounds: bool,
    /// Number of cores; `None`: no limit.
    pub cores: Option<u32>,
    /// Preset of the semantics.
    pub preset: Preset,
    /// Single points of the semantics that differ from the preset.
    pub points: Points,
    /// Order in which cores are granted, if stated.
    pub stated_policy: Option<Policy>,
    /// Cores that tasks are bound to, counted from 1.
    pub affinity: Vec<(Path, u32)>,
    /// Permission of codels to throw, the most general rule first.
    pub exceptions: Vec<(bool, Option<Path>)>,
    /// Effect of `before` and `after`, if stated.
    pub stated_order: Option<bool>,
    /// Interpretation of execution times.
    pub durations: Durations,
    /// Durations of single codels.
    pub duration: Vec<(Path, Interval, Unit)>,
    /// Files of execution times, for codels without another time.
    pub times: Vec<TimesFile>,
    /// Loop limits with their place in the scenario, the most general first.
    pub loops: Vec<(Option<u32>, Option<Path>, Range<usize>)>,
    /// Rules for idle ticks, the most general first.
    pub idle: Vec<(bool, Option<Path>)>,
    /// Asynchronous codels need no core.
    pub async_free: bool,
    /// Aperiodic tasks need no core.
    pub aperiodic_free: bool,
    /// Connections of ports.
    pub connect: Vec<(Path, Option<Path>)>,
    /// Numbers of slots.
    pub slots: Vec<(Path, u32)>,
    pub clients: Vec<Client>,
    pub checks: Vec<Check>,
    /// An upper bound that replaces the execution time of one codel, for derived questions.
    pub upper_bound: Option<(Path, Seconds)>,
    /// A period that replaces that of one task, for derived questions.
    pub period: Option<(Path, Seconds)>,
    /// A delay that replaces that of one task, for derived questions.
    pub delay: Option<(Path, Seconds)>,
    /// A codel (`component.owner.state`) and the codels that it no longer excludes, for derived questions.
    pub apart: Option<(CodelName, Vec<CodelName>)>,
}

impl Settings {
    /// Collects the settings of a scenario.
    pub fn new(scenario: &Scenario) -> Self {
        let mut out = Settings {
            name: scenario.name.clone(),
            times: scenario.times.clone(),
            checks: scenario.checks().cloned().collect(),
            ..Settings::default()
        };
        for item in &scenario.items {
            match item.clone() {
                Item::Use(_) | Item::Times(_) | Item::Weights(_) => {}
                Item::Unit(count, unit) => out.unit = Some((count, unit)),
                Item::Cores(cores) => out.cores = cores,
                Item::Semantics(preset) => out.preset = preset,
                Item::Ticks(tick) => out.points.ticks = Some(tick),
                Item::Turns(turn) => out.points.turns = Some(turn),
                Item::Locks(lock) => out.points.locks = Some(lock),
                Item::Ports(port) => out.points.ports = Some(port),
                Item::Pause(pause) => out.points.pause = Some(pause),
                Item::Exceptions(on, path) => out.exceptions.push((on, path)),
                Item::Order(on) => out.stated_order = Some(on),
                Item::Affinity(path, core) => out.affinity.push((path, core)),
                Item::Policy(policy) => out.stated_policy = Some(policy),
                Item::Durations(durations) => out.durations = durations,
                Item::Duration(path, interval, unit) => out.duration.push((path, interval, unit)),
                Item::Loop(limit, path, range) => out.loops.push((limit, path, range)),
                Item::Idle(keep, path) => out.idle.push((keep, path)),
                Item::AsyncFree(free) => out.async_free = free,
                Item::AperiodicCore(core) => out.aperiodic_free = !core,
                Item::Connect(from, to) => out.connect.push((from, to)),
                Item::Slots(path, count) => out.slots.push((path, count)),
                Item::Client(client) => out.clients.push(client),
                Item::Check(_) => {}
            }
        }
        // A specific rule overrides a general one, whatever their order in the scenario.
        out.loops.sort_by_key(|(_, path, _)| path.is_some());
        out.idle.sort_by_key(|(_, path)| path.is_some());
        out.exceptions.sort_by_key(|(_, path)| path.is_some());
        out
    }

    /// Returns the semantics of the model, with all points set.
    pub fn semantics(&self) -> Semantics {
        self.points.over(self.preset)
    }

    /// Returns true if `before` and `after` apply.
    pub fn order(&self) -> bool {
        self.stated_order.unwrap_or(self.semantics().fixed().has_order)
    }

    /// Returns true if a thread can lose its core to another one.
    pub fn preempts(&self) -> bool {
        matches!(self.policy(), Policy::Priority | Policy::Fair)
    }

    /// Returns the order in which cores are granted.
    pub fn policy(&self) -> Policy {
        self.stated_policy.unwrap_or(self.semantics().fixed().policy)
    }
}
