//! Components: their tasks, their services, and the order and interruptions between services.

use dotgen_analysis::model::{
    self, CodelKind, Owner, Param, ParamSource, Seconds, ServiceKind, ServiceList,
};
use num_rational::Ratio;

use super::Builder;
use super::times::TimeOf;
use crate::diagnostic::{Diagnostic, Place};
use crate::scn::ast::{DEFAULT_PLACES, DEFAULT_SLOTS};
use crate::scn::semantics::{Copies, Slots};
use crate::system::indexed::{DeclaredTask, Unrequested};
use crate::system::{Automaton, Component, ComponentId, Service, ServiceId, Task};

impl Builder<'_> {
    pub(super) fn component(&mut self, c: usize) {
        let component = self.names.components[c].component;
        let number = self.out.system.components.push_and_get_key(Component {
            name: component.name.to_string(),
            tasks: Vec::new(),
            services: Vec::new(),
        });
        self.out.components.insert(c, number);
        self.tasks(c, number);
        self.services(c, number);
    }

    fn tasks(&mut self, c: usize, number: ComponentId) {
        let component = self.names.components[c].component;
        for (t, task) in component.tasks.iter_enumerated() {
            let path = format!("{}.{}", component.name, task.name);
            let src = task.period.as_ref().map_or(task.src, |period| period.src);
            let period_of = self.time_of_task("period", &path, self.place(c, src, "the period"));
            let period = self.period(c, t).map(|time| self.ticks(time, &period_of));
            if period == Some(0) {
                let message = format!("the period of {path} is zero; give a period or none");
                let error = Diagnostic::error("scn-zero-period", 0..0, message);
                self.report(error.about(period_of.place));
            }
            let src = task.delay.as_ref().map_or(task.src, |delay| delay.src);
            let delay_of = self.time_of_task("delay", &path, self.place(c, src, "the delay"));
            let delay = self.delay(c, t).unwrap_or(Ratio::new(0, 1));
            let delay = self.ticks(delay, &delay_of);
            self.check_ticks(c, t, &path);
            let id = self.out.system.tasks.next_key();
            let permanent = self.machine(c, number, Owner::Task(t), &path).map(|machine| {
                self.out.system.automata.push_and_get_key(Automaton {
                    task: id,
                    machine,
                    service: None,
                })
            });
            // The servers have no such rule.
            let keep = self.idle_rule(c, t) && self.settings.semantics().fixed().keeps_idle_ticks;
            self.out.tasks.insert(DeclaredTask { component: c, index: t }, id);
            self.out.system.components[number].tasks.push(id);
            self.out.system.tasks.push(Task {
                name: task.name.to_string(),
                component: number,
                period: period.map(|period| period.max(1)),
                delay,
                keep_idle_tick: keep,
                permanent,
                slots: Vec::new(),
                places: self.places.get(&(c, t)).copied().unwrap_or(DEFAULT_PLACES),
                priority: (task.priority.as_ref())
                    .and_then(|priority| u32::try_from(priority.value.to_integer()).ok()),
                affinity: self.affinity.get(&(c, t)).map(|core| core - 1),
                src: Some((c, task.src)),
            });
        }
    }

    /// Reports clock rates that the ROS server rounds: it divides times in floating point and truncates the
    /// result.
    fn check_ticks(&mut self, c: usize, t: model::TaskId, path: &str) {
        let component = self.names.components[c].component;
        let task = &component.tasks[t];
        let Some(rate) = &component.clock_rate else {
            return;
        };
        if !self.settings.semantics().fixed().counts_clock_ticks {
            return;
        }
        let to_f64 = |seconds: Seconds| *seconds.numer() as f64 / *seconds.denom() as f64;
        let times = [("period", &task.period), ("delay", &task.delay)];
        for (what, time) in times {
            let Some(time) = time else { continue };
            let exact = time.value / rate.value;
            let cut_off = (to_f64(time.value) / to_f64(rate.value)).trunc();
            if exact.is_integer() && cut_off != to_f64(exact) {
                let message = format!(
                    "the {what} of {path} is {exact} ticks of the component's clock, but {cut_off} in the ROS server, which \
                     cuts off a quotient in floating point; choose another `clock-rate` or {what}"
                );
                let warning = Diagnostic::warning("timing-inexact-ticks", 0..0, message);
                let place = self.place(c, time.src, "this time");
                self.report(warning.about(place));
            }
        }
    }

    fn time_of_task(&self, what: &str, path: &str, place: Place) -> TimeOf {
        TimeOf { what: format!("the {what} of {path}"), range: 0..0, place }
    }

    fn services(&mut self, c: usize, number: ComponentId) {
        let component = self.names.components[c].component;
        for (s, service) in component.services.iter_enumerated() {
            let path = format!("{}.{}", component.name, service.name);
            let owner = Owner::Service(s);
            let activity = service.kind == ServiceKind::Activity;
            let id = self.out.system.services.next_key();
            let mut validate = None;
            let mut simple = Vec::new();
            for (index, codel) in service.codels.iter_enumerated() {
                match codel.kind {
                    CodelKind::Fsm => {}
                    CodelKind::Validate => {
                        validate = Some(self.codel(c, number, owner, index, "", codel));
                    }
                    CodelKind::Simple => {
                        simple.push(self.codel(c, number, owner, index, "", codel));
                    }
                }
            }
            // The servers copy values of the ids before codels run, for every kind of service.
            let copies = |param: &Param| param.source == ParamSource::Ids;
            if self.settings.semantics().fixed().copies == Copies::OfAttributes {
                if service.kind == ServiceKind::Attribute {
                    simple.push(self.attribute(c, number, s, &path));
                }
            } else if service.params.iter().any(copies) {
                simple.insert(0, self.attribute(c, number, s, &path));
            }
            let mut slots = Vec::new();
            if activity
                && let Some(machine) = self.machine(c, number, owner, &path)
                && let Some(task) = service
                    .task
                    .map(|index| DeclaredTask { component: c, index })
                    .and_then(|task| self.out.tasks.get(&task).copied())
            {
                let count = if self.settings.semantics().fixed().slots == Slots::OfService {
                    self.slots.get(&(c, s)).copied().unwrap_or(DEFAULT_SLOTS)
                } else {
                    1
                };
                let automaton = Automaton { task, machine, service: Some(id) };
                if self.requested.contains(&(c, s)) {
                    for _ in 0..count {
                        slots.push(self.out.system.automata.push_and_get_key(automaton));
                    }
                    self.out.system.tasks[task].slots.extend(&slots);
                } else {
                    let unrequested = Unrequested { service: id, automaton, slots: count };
                    self.out.unrequested.push(unrequested);
                }
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
                after: Vec::new(),
                before: Vec::new(),
                builtin: None,
                src: Some(service.src),
            });
        }
    }

    /// Fills in `interrupts`, `before` and `after` of the services.
    pub(super) fn order(&mut self, included: &[usize]) {
        let counts = self.settings.order();
        for &c in included {
            let component = self.names.components[c].component;
            for (s, service) in component.services.iter_enumerated() {
                let listed = |list: &ServiceList, itself: bool| -> Vec<ServiceId> {
                    let all = component.services.keys().filter(|&service| itself || service != s);
                    let list: Vec<_> = if list.all { all.collect() } else { list.services.clone() };
                    let known =
                        list.iter().filter_map(|service| self.out.services.get(&(c, *service)));
                    known.copied().collect()
                };
                let interrupts = listed(&service.interrupts, true);
                let (after, before) = if counts {
                    (listed(&service.after, false), listed(&service.before, false))
                } else {
                    (Vec::new(), Vec::new())
                };
                let id = self.out.services[&(c, s)];
                let out = &mut self.out.system.services[id];
                (out.interrupts, out.after, out.before) = (interrupts, after, before);
            }
        }
    }
}
