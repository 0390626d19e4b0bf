//! From components and a scenario to a [`TimedSystem`].

mod cycles;

use std::collections::HashMap;
use std::ops::Range;

use dotgen_analysis::model::{
    Codel as ModelCodel, CodelKind, CodelRef, Owner, Seconds, ServiceKind, Src,
};
use num_rational::Ratio;

use super::locks::exclude_codels;
use super::settings::Settings;
use super::{
    Automaton, Client, Codel, CodelSet, Component, FOREVER, LockOrder, Machine, Platform, Policy,
    Service, State, Task, Ticks, TimedSystem, Yield, program, units,
};
use crate::remark::Remark;
use crate::scn::ast::{self, Durations, Path, StepKind, Unit};
use crate::scn::names::{Names, Target};
use crate::scn::{Diagnostic, Place, Severity};

/// A system, and how to find things in it.
#[derive(Debug, Clone)]
pub struct Built {
    /// The system.
    pub system: TimedSystem,
    /// Tasks by component (as in [`Names::components`]) and index.
    pub tasks: HashMap<(usize, u32), usize>,
    /// Services likewise.
    pub services: HashMap<(usize, u32), usize>,
    /// Machines of tasks and activities.
    pub machines: HashMap<(usize, Owner), usize>,
    /// Components.
    pub components: HashMap<usize, usize>,
    /// Problems that do not prevent verification, or (with errors) do.
    pub diagnostics: Vec<Diagnostic>,
    /// What the result depends on, in words.
    pub assumptions: Vec<String>,
}

/// Builds the system of those components for which `include` holds, with the clients that address them.
pub fn build(names: &Names, settings: &Settings, include: &dyn Fn(usize) -> bool) -> Built {
    let mut builder = Builder {
        names,
        settings,
        durations: HashMap::new(),
        loop_rules: HashMap::new(),
        requested: Vec::new(),
        out: Built {
            system: TimedSystem {
                unit: Ratio::new(1, 1000),
                components: Vec::new(),
                tasks: Vec::new(),
                machines: Vec::new(),
                automata: Vec::new(),
                codels: Vec::new(),
                services: Vec::new(),
                clients: Vec::new(),
                platform: Platform {
                    cores: settings.cores,
                    policy: match settings.policy {
                        ast::Policy::Fifo => Policy::Fifo,
                        ast::Policy::Edf => Policy::Edf,
                        ast::Policy::Any => Policy::Any,
                    },
                    locks: if settings.locks_fifo {
                        LockOrder::Fifo
                    } else {
                        LockOrder::Free
                    },
                    async_free: settings.async_free,
                    aperiodic_core: settings.aperiodic_core,
                },
            },
            tasks: HashMap::new(),
            services: HashMap::new(),
            machines: HashMap::new(),
            components: HashMap::new(),
            diagnostics: Vec::new(),
            assumptions: Vec::new(),
        },
    };
    let included: Vec<usize> = (0..names.components.len())
        .filter(|&it| include(it))
        .collect();
    builder.override_durations();
    builder.find_requested();
    builder.choose_unit(&included);
    for &c in &included {
        builder.component(c);
    }
    builder.interrupts(&included);
    builder.clients();
    let out = &mut builder.out;
    exclude_codels(names, settings, &included, out);
    let needing = (0..out.system.tasks.len())
        .filter(|&it| out.system.needs_core(it))
        .count();
    if out
        .system
        .platform
        .cores
        .is_some_and(|cores| cores as usize >= needing)
    {
        // With as many cores as tasks all policies are the same (section 9).
        out.system.platform.cores = None;
    }
    builder.loops();
    builder.assumptions();
    builder.out
}

struct Builder<'b> {
    names: &'b Names<'b>,
    settings: &'b Settings,
    /// Overridden durations by component, owner, index of the codel and state.
    durations: HashMap<(usize, Owner, u32, String), usize>,
    /// Where the loop limits of machines are written.
    loop_rules: HashMap<usize, Range<usize>>,
    /// Services that some client requests.
    requested: Vec<(usize, u32)>,
    out: Built,
}

/// What a time is that of.
struct TimeOf {
    /// In words.
    what: String,
    /// Its `duration`; empty at 0 if there is none.
    range: Range<usize>,
    place: Place,
}

impl Builder<'_> {
    fn place(&self, c: usize, src: Src, what: &str) -> Place {
        Place {
            spec: self.names.components[c].spec_index,
            src,
            what: what.to_owned(),
        }
    }

    fn report(&mut self, diagnostic: Diagnostic) {
        if !self.out.diagnostics.contains(&diagnostic) {
            self.out.diagnostics.push(diagnostic);
        }
    }

    // ---- Times -----------------------------------------------------------------------------

    fn override_durations(&mut self) {
        for (i, (path, ..)) in self.settings.duration.iter().enumerate() {
            let key = match self.names.resolve(path) {
                Ok(Target::State(c, owner, index, state)) => (c, owner, index, state),
                Ok(Target::Codel(c, s, index)) => (c, Owner::Service(s), index, String::new()),
                Ok(Target::Service(c, s))
                    if self.names.components[c].component.services[s as usize].kind
                        == ServiceKind::Attribute =>
                {
                    (c, Owner::Service(s), u32::MAX, String::new())
                }
                Ok(_) => {
                    let message = format!(
                        "`{}` is no codel; write component.task.state, component.service.state, or component.service.codel",
                        path.text()
                    );
                    self.report(Diagnostic::error("scn-not-a-codel", path.range(), message));
                    continue;
                }
                Err(error) => {
                    self.report(error);
                    continue;
                }
            };
            self.durations.insert(key, i);
        }
    }

    /// The time of a codel, exactly, rounded to the unit of the scenario.
    fn duration(
        &self,
        c: usize,
        owner: Owner,
        index: u32,
        state: &str,
        codel: Option<&ModelCodel>,
    ) -> (Seconds, Option<Seconds>) {
        let zero = Ratio::new(0, 1);
        let key = (c, owner, index, state.to_owned());
        let (lower, upper) = match self.durations.get(&key) {
            Some(&i) => {
                let (_, interval, unit) = &self.settings.duration[i];
                let seconds = |it: u64| unit.seconds() * Ratio::from_integer(i128::from(it));
                (seconds(interval.lower), interval.upper.map(seconds))
            }
            None => {
                let wcet = codel
                    .and_then(|it| it.wcet.as_ref())
                    .map_or(zero, |it| it.value);
                (zero, Some(wcet))
            }
        };
        let (lower, upper) = match self.settings.unit {
            Some((count, unit)) => {
                let unit = unit.seconds() * Ratio::from_integer(i128::from(count));
                (
                    units::round_down(lower, unit),
                    upper.map(|it| units::round_up(it, unit)),
                )
            }
            None => (lower, upper),
        };
        let upper = match &self.settings.upper_bound {
            Some((path, bound))
                if self.names.resolve(path).is_ok_and(|it| match it {
                    Target::State(a, b, c2, d) => {
                        (a, b, c2, d.as_str()) == (c, owner, index, state)
                    }
                    Target::Codel(a, s, c2) => (a, Owner::Service(s), c2) == (c, owner, index),
                    _ => false,
                }) =>
            {
                Some((*bound).max(lower))
            }
            _ => upper,
        };
        match (self.settings.durations, upper) {
            (Durations::Fixed, Some(upper)) => (upper, Some(upper)),
            _ => (lower, upper),
        }
    }

    fn period(&self, c: usize, t: u32) -> Option<Seconds> {
        if let Some((path, period)) = &self.settings.period
            && self.names.resolve(path) == Ok(Target::Task(c, t))
        {
            return Some(*period);
        }
        self.names.components[c].component.tasks[t as usize]
            .period
            .as_ref()
            .map(|it| it.value)
    }

    fn choose_unit(&mut self, included: &[usize]) {
        let mut times = Vec::new();
        for &c in included {
            let component = self.names.components[c].component;
            for task in &component.tasks {
                times.extend(task.delay.as_ref().map(|it| it.value));
            }
            for t in 0..component.tasks.len() as u32 {
                times.extend(self.period(c, t));
            }
            for it in component.all_codels() {
                let codel = component.codel(it);
                let mut add = |state: &str| {
                    let (a, b) = self.duration(c, it.owner, it.index, state, Some(codel));
                    times.push(a);
                    times.extend(b);
                };
                if codel.kind == CodelKind::Fsm {
                    codel.triggers.iter().for_each(|state| add(&state.name));
                } else {
                    add("");
                }
            }
            for s in 0..component.services.len() as u32 {
                let (a, b) = self.duration(c, Owner::Service(s), u32::MAX, "", None);
                times.push(a);
                times.extend(b);
            }
        }
        for client in &self.settings.clients {
            delays(&client.steps, &mut times);
        }
        self.out.system.unit = units::base_unit(times);
    }

    fn ticks(&mut self, time: Seconds, of: &TimeOf) -> Ticks {
        if let Some(ticks) = units::ticks(time, self.out.system.unit) {
            return ticks;
        }
        let message = format!(
            "the time of {} is too long for the base unit of {} s; choose a coarser `unit`",
            of.what, self.out.system.unit
        );
        let error = Diagnostic::error("scn-time-range", of.range.clone(), message);
        self.report(error.about(of.place.clone()));
        FOREVER / 8
    }

    fn time_of_task(&self, what: &str, path: &str, place: Place) -> TimeOf {
        TimeOf {
            what: format!("the {what} of {path}"),
            range: 0..0,
            place,
        }
    }

    // ---- Components ------------------------------------------------------------------------

    fn component(&mut self, c: usize) {
        let it = self.names.components[c].component;
        let number = self.out.system.components.len();
        self.out.components.insert(c, number);
        self.out.system.components.push(Component {
            name: it.name.to_string(),
            tasks: Vec::new(),
            services: Vec::new(),
        });
        for (t, task) in (0..).zip(&it.tasks) {
            let path = format!("{}.{}", it.name, task.name);
            let src = task.period.as_ref().map_or(task.src, |it| it.src);
            let period_of = self.time_of_task("period", &path, self.place(c, src, "the period"));
            let period = self.period(c, t).map(|time| self.ticks(time, &period_of));
            if period == Some(0) {
                let message = format!("the period of {path} is zero; give a period or none");
                let error = Diagnostic::error("scn-zero-period", 0..0, message);
                self.report(error.about(period_of.place));
            }
            let src = task.delay.as_ref().map_or(task.src, |it| it.src);
            let delay_of = self.time_of_task("delay", &path, self.place(c, src, "the delay"));
            let delay = task.delay.as_ref().map_or(Ratio::new(0, 1), |it| it.value);
            let delay = self.ticks(delay, &delay_of);
            let id = self.out.system.tasks.len();
            let permanent = self
                .machine(c, number, Owner::Task(t), &path)
                .map(|machine| {
                    self.out.system.automata.push(Automaton {
                        task: id,
                        machine,
                        service: None,
                    });
                    self.out.system.automata.len() - 1
                });
            let keep = self.idle_rule(c, t);
            self.out.tasks.insert((c, t), id);
            self.out.system.components[number].tasks.push(id);
            self.out.system.tasks.push(Task {
                name: task.name.to_string(),
                component: number,
                period: period.map(|it| it.max(1)),
                delay,
                keep_idle_tick: keep,
                permanent,
                slots: Vec::new(),
                src: Some((c, task.src)),
            });
        }
        for (s, service) in (0..).zip(&it.services) {
            let path = format!("{}.{}", it.name, service.name);
            let owner = Owner::Service(s);
            let activity = service.kind == ServiceKind::Activity;
            let id = self.out.system.services.len();
            let mut validate = None;
            let mut simple = Vec::new();
            for (index, codel) in (0..).zip(&service.codels) {
                match codel.kind {
                    CodelKind::Fsm => {}
                    CodelKind::Validate => {
                        validate = Some(self.codel(c, number, owner, index, "", &path, codel));
                    }
                    CodelKind::Simple => {
                        simple.push(self.codel(c, number, owner, index, "", &path, codel));
                    }
                }
            }
            if service.kind == ServiceKind::Attribute {
                simple.push(self.attribute(c, number, s, &path));
            }
            let mut slots = Vec::new();
            if activity
                && let Some(machine) = self.machine(c, number, owner, &path)
                && let Some(task) = service
                    .task
                    .and_then(|t| self.out.tasks.get(&(c, t)).copied())
                && self.requested.contains(&(c, s))
            {
                for _ in 0..self.slots(c, s) {
                    self.out.system.automata.push(Automaton {
                        task,
                        machine,
                        service: Some(id),
                    });
                    slots.push(self.out.system.automata.len() - 1);
                }
                self.out.system.tasks[task].slots.extend(&slots);
            }
            self.out.services.insert((c, s), id);
            self.out.system.components[number].services.push(id);
            self.out.system.services.push(Service {
                name: service.name.to_string(),
                component: number,
                validate,
                simple,
                slots,
                activity,
                interrupts: Vec::new(),
                src: Some(service.src),
            });
        }
    }

    fn interrupts(&mut self, included: &[usize]) {
        for &c in included {
            let component = self.names.components[c].component;
            for (s, service) in (0..).zip(&component.services) {
                let all = 0..component.services.len() as u32;
                let list: Vec<u32> = if service.interrupts.all {
                    all.collect()
                } else {
                    service.interrupts.services.clone()
                };
                let id = self.out.services[&(c, s)];
                self.out.system.services[id].interrupts = list
                    .iter()
                    .filter_map(|it| self.out.services.get(&(c, *it)).copied())
                    .collect();
            }
        }
    }

    /// The state machine of a task or activity; `None` without a `start` codel.
    fn machine(&mut self, c: usize, number: usize, owner: Owner, path: &str) -> Option<usize> {
        let component = self.names.components[c].component;
        let codels = component.codels_of(owner);
        let mut names: Vec<(String, u32)> = Vec::new();
        for (index, codel) in (0..).zip(codels) {
            if codel.kind == CodelKind::Fsm {
                names.extend(codel.triggers.iter().map(|it| (it.name.to_string(), index)));
            }
        }
        let find = |name: &str| names.iter().position(|(it, _)| it == name);
        let start = find("start")?;
        let stop = find("stop");
        let states = names
            .iter()
            .map(|(name, index)| {
                let codel = &codels[*index as usize];
                let mut yields: Vec<Yield> = Vec::new();
                for it in &codel.yields {
                    let to = match find(&it.name) {
                        Some(to) if it.paused => Yield::Pause(to),
                        // A codel attached to `ether` is executed once, before the end.
                        Some(to) if it.name != "ether" || name != "ether" => Yield::Next(to),
                        _ => Yield::End,
                    };
                    if !yields.contains(&to) {
                        yields.push(to);
                    }
                }
                if yields.is_empty() {
                    yields.push(Yield::End);
                }
                State {
                    name: name.clone(),
                    codel: self.codel(c, number, owner, *index, name, path, codel),
                    yields,
                    is_async: codel.is_async,
                }
            })
            .collect();
        let id = self.out.system.machines.len();
        let (loop_limit, rule) = self.loop_limit(c, owner);
        self.loop_rules.extend(rule.map(|it| (id, it)));
        self.out.machines.insert((c, owner), id);
        self.out.system.machines.push(Machine {
            name: path.to_owned(),
            states,
            start,
            stop,
            loop_limit,
            rounds: false,
        });
        Some(id)
    }

    #[expect(clippy::too_many_arguments, reason = "the coordinates of a codel")]
    fn codel(
        &mut self,
        c: usize,
        number: usize,
        owner: Owner,
        index: u32,
        state: &str,
        path: &str,
        codel: &ModelCodel,
    ) -> usize {
        let name = if state.is_empty() {
            codel.name.as_str()
        } else {
            state
        };
        let path = format!("{path}.{name}");
        let given = self
            .durations
            .get(&(c, owner, index, state.to_owned()))
            .map(|&it| self.settings.duration[it].0.range());
        if codel.wcet.is_none() && given.is_none() {
            let remark = Remark::NoWcet {
                codel: codel.name.to_string(),
                path: path.clone(),
            };
            let place = self.place(c, codel.src, "no `wcet`");
            self.report(remark.warning(0..0, vec![place]));
        }
        let time_of = TimeOf {
            what: path.clone(),
            range: given.unwrap_or_default(),
            place: self.place(c, codel.src, "this codel"),
        };
        let site = Some((c, CodelRef { owner, index }));
        let times = self.duration(c, owner, index, state, Some(codel));
        self.push_codel(number, path, times, site, &time_of)
    }

    fn attribute(&mut self, c: usize, number: usize, s: u32, path: &str) -> usize {
        let service = &self.names.components[c].component.services[s as usize];
        let times = self.duration(c, Owner::Service(s), u32::MAX, "", None);
        let given = self
            .durations
            .get(&(c, Owner::Service(s), u32::MAX, String::new()))
            .map(|&it| self.settings.duration[it].0.range());
        let time_of = TimeOf {
            what: path.to_owned(),
            range: given.unwrap_or_default(),
            place: self.place(c, service.src, "this attribute"),
        };
        self.push_codel(number, path.to_owned(), times, None, &time_of)
    }

    fn push_codel(
        &mut self,
        number: usize,
        path: String,
        (lower, upper): (Seconds, Option<Seconds>),
        site: Option<(usize, CodelRef)>,
        time_of: &TimeOf,
    ) -> usize {
        let lower = self.ticks(lower, time_of);
        let upper = upper.map_or(FOREVER, |it| self.ticks(it, time_of));
        self.out.system.codels.push(Codel {
            path,
            component: number,
            lower,
            upper,
            conflicts: CodelSet::default(),
            site,
            src: Some(time_of.place.src),
        });
        self.out.system.codels.len() - 1
    }

    // ---- Settings of single things ---------------------------------------------------------

    fn idle_rule(&mut self, c: usize, t: u32) -> bool {
        let mut keep = false;
        for (rule, path) in &self.settings.idle {
            match path {
                None => keep = *rule,
                Some(path) => match self.names.resolve(path) {
                    Ok(Target::Task(a, b)) if (a, b) == (c, t) => keep = *rule,
                    Ok(Target::Component(a)) if a == c => keep = *rule,
                    Ok(Target::Task(..) | Target::Component(_)) => {}
                    Ok(_) => self.report(not_a("task", path)),
                    Err(error) => self.report(error),
                },
            }
        }
        keep
    }

    /// The limit, and where it is written.
    fn loop_limit(&mut self, c: usize, owner: Owner) -> (Option<u16>, Option<Range<usize>>) {
        let mut limit = (None, None);
        for (rule, path, range) in &self.settings.loops {
            let rule = (rule.map(|it| it as u16), Some(range.clone()));
            let Some(path) = path else {
                limit = rule;
                continue;
            };
            match self.names.resolve(path) {
                Ok(Target::Task(a, t)) if (a, Owner::Task(t)) == (c, owner) => limit = rule,
                Ok(Target::Service(a, s)) if (a, Owner::Service(s)) == (c, owner) => limit = rule,
                Ok(Target::Component(a)) if a == c => limit = rule,
                Ok(Target::Task(..) | Target::Service(..) | Target::Component(_)) => {}
                Ok(_) => self.report(not_a("task or activity", path)),
                Err(error) => self.report(error),
            }
        }
        limit
    }

    fn slots(&mut self, c: usize, s: u32) -> u32 {
        let mut slots = 2;
        for (path, count) in &self.settings.slots {
            match self.names.resolve(path) {
                Ok(Target::Service(a, b)) if (a, b) == (c, s) => slots = *count,
                Ok(Target::Service(..)) => {}
                Ok(_) => self.report(not_a("service", path)),
                Err(error) => self.report(error),
            }
        }
        if slots == 0 {
            let path = &self.settings.slots[0].0;
            let message = "an activity needs at least one slot".to_owned();
            self.report(Diagnostic::error("scn-no-slot", path.range(), message));
        }
        slots.clamp(1, 16)
    }

    // ---- Clients ---------------------------------------------------------------------------

    fn service(&self, path: &Path) -> Result<(usize, u32), Diagnostic> {
        match self.names.resolve(path)? {
            Target::Service(c, s) => Ok((c, s)),
            _ => Err(not_a("service", path)),
        }
    }

    fn find_requested(&mut self) {
        let mut paths = Vec::new();
        for client in &self.settings.clients {
            sends(&client.steps, &mut paths);
        }
        for path in paths {
            match self.service(path) {
                Ok(it) => self.requested.push(it),
                Err(error) => self.report(error),
            }
        }
    }

    fn clients(&mut self) {
        let unit = self.out.system.unit;
        let ticks = |count: u64, of: Unit| {
            let time = of.seconds() * Ratio::from_integer(i128::from(count));
            units::ticks(time, unit).unwrap_or(FOREVER / 8)
        };
        for client in &self.settings.clients {
            let mut paths = Vec::new();
            sends(&client.steps, &mut paths);
            let here = paths.iter().any(|path| {
                self.service(path)
                    .is_ok_and(|it| self.out.services.contains_key(&it))
            });
            if !here && !paths.is_empty() {
                continue;
            }
            let resolve = |path: &Path| {
                let it = self.service(path)?;
                self.out
                    .services
                    .get(&it)
                    .copied()
                    .ok_or_else(|| not_a("service", path))
            };
            let compiled: Result<Client, Diagnostic> = program::compile(client, &resolve, &ticks);
            match compiled {
                Ok(client) => self.out.system.clients.push(client),
                Err(error) => self.report(error),
            }
        }
    }

    // ---- Words -----------------------------------------------------------------------------

    fn assumptions(&mut self) {
        let settings = self.settings;
        let mut say = |text: String| self.out.assumptions.push(text);
        match settings.durations {
            Durations::Interval => say(
                "durations: every codel takes any time from 0, or its stated lower bound, to its upper bound".to_owned(),
            ),
            Durations::Fixed => say(
                "durations: every codel takes exactly its worst case; codels that end earlier can make other tasks later".to_owned(),
            ),
            Durations::Open => say(
                "durations: explored from 0 on instead of from just above 0; a failure may be a false alarm".to_owned(),
            ),
        }
        match settings.cores {
            None => say("cores: no limit".to_owned()),
            Some(cores) => say(format!(
                "cores: {cores}, granted {}, held from the grant to the end of the cycle, also while waiting for a lock",
                match settings.policy {
                    ast::Policy::Fifo => "in order of release",
                    ast::Policy::Edf => "by earliest deadline",
                    ast::Policy::Any => "to any waiting task",
                }
            )),
        }
        say(if settings.locks_fifo {
            "locks: in order of arrival among codels that exclude each other".to_owned()
        } else {
            "locks: any waiting codel may win, also repeatedly".to_owned()
        });
        if settings.clients.is_empty() {
            say("clients: none; only permanent activities run".to_owned());
        }
        say("any declared yield may be taken; exceptions are left out".to_owned());
        if !settings.async_free {
            let any = self.out.system.machines.iter().flat_map(|it| &it.states);
            if any.clone().any(|it| it.is_async) {
                self.out.assumptions.push(
                    "async: executed like any other codel, the task keeps its core".to_owned(),
                );
            }
        }
        for machine in &self.out.system.machines {
            if let Some(limit) = machine.loop_limit {
                let scope = if machine.rounds { "round" } else { "turn" };
                self.out.assumptions.push(format!(
                    "loop: {} enters no state more than {limit} time(s) in one {scope}; assumed, not proved",
                    machine.name
                ));
            }
        }
        let mut ordered: Vec<String> = Vec::new();
        for &(c, s) in &self.requested {
            let component = self.names.components[c].component;
            let it = &component.services[s as usize];
            let mut lists = [&it.before, &it.after].into_iter();
            let path = format!("{}.{}", component.name, it.name);
            if lists.any(|it| it.all || !it.services.is_empty()) && !ordered.contains(&path) {
                ordered.push(path);
            }
        }
        if !ordered.is_empty() {
            self.out.assumptions.push(format!(
                "requests: `before` and `after` of {} are not looked at; they are accepted at any time",
                ordered.join(", ")
            ));
        }
        if self
            .out
            .diagnostics
            .iter()
            .any(|it| it.code == "timing-no-wcet")
        {
            self.out
                .assumptions
                .push("codels without `wcet` take no time".to_owned());
        }
        if self.out.system.tasks.iter().any(|it| it.delay > 0) {
            self.out.assumptions.push(
                "delay: the first tick of a task comes one period and its delay after its start"
                    .to_owned(),
            );
        }
    }
}

impl Built {
    /// Whether something prevents verification.
    pub fn has_errors(&self) -> bool {
        self.diagnostics
            .iter()
            .any(|it| it.severity == Severity::Error)
    }
}

pub(crate) fn not_a(what: &str, path: &Path) -> Diagnostic {
    let message = format!("`{}` is no {what}", path.text());
    Diagnostic::error("scn-wrong-kind", path.range(), message)
}

fn delays(steps: &[ast::Step], out: &mut Vec<Seconds>) {
    for step in steps {
        match &step.kind {
            StepKind::Delay(interval, unit) => {
                let seconds = |it: u64| unit.seconds() * Ratio::from_integer(i128::from(it));
                out.push(seconds(interval.lower));
                out.extend(interval.upper.map(seconds));
            }
            StepKind::Repeat(_, body) => delays(body, out),
            StepKind::Choice(branches) => branches.iter().for_each(|it| delays(it, out)),
            _ => {}
        }
    }
}

/// Paths of all requests.
pub(crate) fn sends<'s>(steps: &'s [ast::Step], out: &mut Vec<&'s Path>) {
    for step in steps {
        match &step.kind {
            StepKind::Send(path) => out.push(path),
            StepKind::Repeat(_, body) => sends(body, out),
            StepKind::Choice(branches) => branches.iter().for_each(|it| sends(it, out)),
            _ => {}
        }
    }
}
