//! Construction of a [`TimedSystem`] from components and a scenario.

mod assumptions;
mod blocking;
mod clients;
mod components;
mod cycles;
mod machines;
mod program;
mod rules;
mod times;

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::sync::OnceLock;

use dotgen_analysis::model::{self, Owner, Seconds, Src};
use num_rational::Ratio;
use typed_index_collections::TiVec;

use super::indexed::Built;
use super::locks::exclude_codels;
use super::settings::Settings;
use super::{CodelId, MachineId, Platform, TimedSystem};
use crate::diagnostic::{Diagnostic, Place};
use crate::scn::names::Names;

/// Builds the system of the components for which `include` returns true, with the clients that address these
/// components. If the exact times are too many of their common unit, they are rounded to the unit of the
/// scenario: [`Built::rounded`] names them.
pub fn build(names: &Names, settings: &Settings, include: &dyn Fn(usize) -> bool) -> Built {
    let built = build_with(names, settings, include);
    let too_long = built.diagnostics.iter().any(|diagnostic| diagnostic.code == TOO_LONG);
    if too_long && settings.unit.is_some() && !settings.rounds {
        let rounding = Settings { rounds: true, ..settings.clone() };
        return build_with(names, &rounding, include);
    }
    built
}

fn build_with(names: &Names, settings: &Settings, include: &dyn Fn(usize) -> bool) -> Built {
    let mut builder = Builder {
        names,
        settings,
        durations: HashMap::new(),
        loop_rules: HashMap::new(),
        slots: HashMap::new(),
        places: HashMap::new(),
        affinity: HashMap::new(),
        given: given_times(settings),
        timed_by: BTreeMap::new(),
        untimed: Vec::new(),
        requested: Vec::new(),
        out: Built {
            system: TimedSystem {
                unit: Ratio::new(1, 1000),
                components: TiVec::new(),
                tasks: TiVec::new(),
                machines: TiVec::new(),
                automata: TiVec::new(),
                codels: TiVec::new(),
                services: TiVec::new(),
                clients: TiVec::new(),
                platform: Platform {
                    cores: settings.cores,
                    policy: settings.policy(),
                    semantics: settings.semantics(),
                    async_free: settings.async_free,
                    aperiodic_core: !settings.aperiodic_free,
                },
            },
            tasks: HashMap::new(),
            services: HashMap::new(),
            machines: HashMap::new(),
            components: HashMap::new(),
            unrequested: Vec::new(),
            measures: Vec::new(),
            data: None,
            diagnostics: Vec::new(),
            assumptions: Vec::new(),
            conditions: Vec::new(),
            rounded: Vec::new(),
            exact_unit: None,
            shared: OnceLock::new(),
        },
    };
    let included: Vec<usize> =
        (0..names.components.len()).filter(|&component| include(component)).collect();
    builder.choose_rules();
    builder.override_durations();
    builder.number_slots();
    builder.tie_to_cores();
    builder.find_requested();
    builder.whole_periods(&included);
    builder.choose_unit(&included);
    for &c in &included {
        builder.component(c);
    }
    builder.order(&included);
    builder.clients();
    let out = &mut builder.out;
    exclude_codels(names, settings, &included, out);
    if let Some((one, others)) = &settings.apart {
        for name in others {
            out.system.separate(one, name);
        }
    }
    let preempts = settings.preempts();
    // If an operating system grants cores, control tasks need cores as well.
    let control_tasks = if preempts { out.system.components.len() } else { 0 };
    let needing =
        control_tasks + out.system.tasks.keys().filter(|&task| out.system.needs_core(task)).count();
    // Tasks bound to the same core wait for each other, however many other cores there are.
    let tied = out.system.tasks.iter().any(|task| task.affinity.is_some());
    let cores = out.system.platform.cores.filter(|_| !tied);
    if cores.is_some_and(|cores| cores as usize >= needing) {
        // With at least as many cores as tasks, all policies are equivalent (section 9).
        out.system.platform.cores = None;
    }
    builder.loops();
    builder.blocking();
    builder.assumptions();
    builder.conditions(&included);
    builder.out
}

/// Returns the times of the files of execution times, with the names of the files, by specification and
/// function. A file that the scenario names has no specification. Of two files, the first one counts.
fn given_times(settings: &Settings) -> HashMap<(Option<usize>, &str), (Seconds, &str)> {
    let mut out = HashMap::new();
    for file in &settings.times {
        for given in &file.times {
            out.entry((file.beside, given.function.as_str()))
                .or_insert((given.time, file.name.as_str()));
        }
    }
    out
}

/// The code of a time that is too long for the base unit.
const TOO_LONG: &str = "scn-time-range";

pub(super) struct Builder<'b> {
    names: &'b Names<'b>,
    settings: &'b Settings,
    /// Overridden durations by component, owner, index of the codel and state.
    durations: HashMap<(usize, Owner, Option<model::CodelId>, String), usize>,
    /// Places of the loop limits of machines, in the scenario.
    loop_rules: HashMap<MachineId, Range<usize>>,
    /// Numbers of slots of activities, if the scenario states them.
    slots: HashMap<(usize, model::ServiceId), u32>,
    /// Numbers of activities of tasks, if the scenario states them.
    places: HashMap<(usize, model::TaskId), u32>,
    /// Cores of tasks, counted from 1, if the scenario states them.
    affinity: HashMap<(usize, model::TaskId), u32>,
    /// Codels without execution time.
    untimed: Vec<CodelId>,
    /// Times of files, see [`given_times`].
    given: HashMap<(Option<usize>, &'b str), (Seconds, &'b str)>,
    /// Number of codels with a time from a file, by its name.
    timed_by: BTreeMap<&'b str, usize>,
    /// Services that some client requests.
    requested: Vec<(usize, model::ServiceId)>,
    out: Built,
}

impl Builder<'_> {
    fn place(&self, c: usize, src: Src, what: &str) -> Place {
        Place { spec: self.names.components[c].spec_index, src, what: what.to_owned() }
    }

    fn report(&mut self, diagnostic: Diagnostic) {
        if !self.out.diagnostics.contains(&diagnostic) {
            self.out.diagnostics.push(diagnostic);
        }
    }
}
