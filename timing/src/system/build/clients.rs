//! Clients, and the services that they request.

use crate::system::CodelSet;
use dotgen_analysis::model::{self, PortDir};
use num_rational::Ratio;
use typed_index_collections::{TiSlice, ti_vec};

use super::{Builder, program};
use crate::diagnostic::Diagnostic;
use crate::diagnostic::remark::Remark;
use crate::scn::ast::{self, Ending, Path, Step, StepKind, TriggerKind, Unit};
use crate::scn::names::Target;
use crate::system::indexed::{Measure, MeasureEvent, not_a};
use crate::system::{
    Builtin, Client, ClientId, Codel, CodelId, CodelName, ComponentId, FOREVER, Service, ServiceId,
    units,
};

impl Builder<'_> {
    pub(super) fn find_requested(&mut self) {
        for path in self.settings.clients.iter().flat_map(sends) {
            match self.named_service(path) {
                Ok(service) => self.requested.push(service),
                Err(error) => self.report(error),
            }
        }
        if !self.settings.semantics().fixed().has_builtin_services {
            for client in &self.settings.clients {
                self.only_of_servers(client);
            }
        }
    }

    /// Reports steps that the published models do not have: requests that every component accepts, and
    /// outcomes of requests.
    fn only_of_servers(&mut self, client: &ast::Client) {
        for step in Step::all(&client.steps) {
            let what = match &step.kind {
                StepKind::Abort(_) => "abort",
                StepKind::Kill(_) => "kill",
                StepKind::Connect(_) => "connect",
                StepKind::AwaitEnded(Ending::Ok, _) => "await ended ok",
                StepKind::AwaitEnded(Ending::Failed, _) => "await ended failed",
                _ => continue,
            };
            let message = format!(
                "the published models have no `{what}`; write `semantics servers;`, or leave this step out"
            );
            self.report(Diagnostic::error("scn-semantics", step.range.clone(), message));
        }
    }

    /// Adds services for the requests that all components accept, if a client makes such requests.
    fn builtins(&mut self) {
        let mut found: Vec<(ComponentId, Builtin, Vec<ServiceId>)> = Vec::new();
        for client in &self.settings.clients {
            builtins(client, &mut |path, which| {
                // A path that names no component is reported when the client is compiled.
                let Some(c) = self.component_of(path) else { return };
                let Some(&number) = self.out.components.get(&c) else { return };
                let interrupts = match which {
                    Builtin::Interrupt => self.activity(path).into_iter().collect(),
                    _ => Vec::new(),
                };
                let new = (number, which, interrupts);
                if !found.contains(&new) {
                    found.push(new);
                }
            });
        }
        for (number, which, interrupts) in found {
            self.add_builtin(number, which, interrupts);
        }
    }

    fn add_builtin(&mut self, number: ComponentId, which: Builtin, interrupts: Vec<ServiceId>) {
        let system = &mut self.out.system;
        let component = system.components[number].name.clone();
        let mut simple = Vec::new();
        let mut codel = |service: &str, system: &mut crate::system::TimedSystem| {
            let id = system.codels.push_and_get_key(Codel {
                path: CodelName::of_service(&component, service),
                component: number,
                lower: 0,
                upper: 0,
                conflicts: CodelSet::default(),
                throws: false,
                site: None,
                src: None,
            });
            simple.push(id);
            id
        };
        codel(which.name(), system);
        if which == Builtin::Connect {
            let all = codel(&format!("{} (all tasks at rest)", which.name()), system);
            let executed = system.automata.iter();
            let executed =
                executed.filter(|automaton| system.tasks[automaton.task].component == number);
            let states = executed.flat_map(|automaton| &system.machines[automaton.machine].states);
            let codels: Vec<CodelId> = states.map(|state| state.codel).collect();
            for other in codels {
                system.exclude(all, other);
            }
        }
        let id = system.services.push_and_get_key(Service {
            name: which.name().to_owned(),
            component: number,
            validate: None,
            simple,
            slots: Vec::new(),
            activity: false,
            interrupts,
            after: Vec::new(),
            before: Vec::new(),
            builtin: Some(which),
            src: None,
        });
        system.components[number].services.push(id);
    }

    fn component_of(&self, path: &Path) -> Option<usize> {
        let name = path.names.first()?;
        match self.names.resolve(&Path::from(name.clone())) {
            Ok(Target::Component(c)) => Some(c),
            _ => None,
        }
    }

    pub(super) fn clients(&mut self) {
        self.builtins();
        let unit = self.out.system.unit;
        let ticks = |count: u64, of: Unit| {
            let time = of.seconds() * Ratio::from_integer(i128::from(count));
            units::ticks(time, unit).unwrap_or(FOREVER / 8)
        };
        for client in &self.settings.clients {
            let mut paths: Vec<&Path> = sends(client).collect();
            builtins(client, &mut |path, _| paths.push(path));
            let here = paths.iter().any(|path| {
                self.component_of(path)
                    .is_some_and(|component| self.out.components.contains_key(&component))
            });
            if !here && !paths.is_empty() {
                continue;
            }
            let compiled: Result<Client, Diagnostic> = program::compile(client, self, &ticks);
            match compiled {
                Ok(compiled) => {
                    let id = self.out.system.clients.push_and_get_key(compiled);
                    let trigger =
                        client.trigger.as_ref().map(|trigger| self.measure(id, client, trigger));
                    match trigger.transpose() {
                        Ok(measure) => self.out.measures.extend(measure),
                        Err(error) => self.report(error),
                    }
                }
                Err(error) => self.report(error),
            }
        }
        self.only_refused();
    }

    /// Returns what a run needs to take a measure.
    fn measure(
        &self,
        id: ClientId,
        client: &ast::Client,
        trigger: &ast::Trigger,
    ) -> Result<Measure, Diagnostic> {
        let events = trigger.of.iter().filter_map(|path| self.event(trigger, path).transpose());
        Ok(Measure {
            client: id,
            events: events.collect::<Result<_, _>>()?,
            stops: client.steps.last().is_some_and(|step| step.kind == StepKind::Stop),
        })
    }

    /// Returns an event of a measure; `None` if it is one of a component that is not part of the system.
    fn event(
        &self,
        trigger: &ast::Trigger,
        path: &Path,
    ) -> Result<Option<MeasureEvent>, Diagnostic> {
        let event = match trigger.kind {
            TriggerKind::Violation => {
                let name = path.text();
                let mut checks = self.settings.checks.iter().flat_map(|check| &check.name);
                if !checks.any(|check| check.value == name) {
                    return Err(not_a("named check", path));
                }
                MeasureEvent::Violation(name)
            }
            TriggerKind::Late => match self.names.resolve(path)? {
                Target::Task(..) => MeasureEvent::LateTask(path.text()),
                Target::State(..) | Target::Codel(..) => MeasureEvent::LateCodel(path.text()),
                _ => return Err(not_a("codel or task", path)),
            },
            TriggerKind::Lost => match self.names.resolve(path)? {
                Target::Component(_) => MeasureEvent::Lost(path.text()),
                _ => return Err(not_a("component", path)),
            },
            TriggerKind::Stale => match self.names.resolve(path)? {
                Target::Port(c, port)
                    if self.names.components[c].component.ports[port].dir == PortDir::Out =>
                {
                    let Some(&component) = self.out.components.get(&c) else { return Ok(None) };
                    let (count, unit) = trigger.after.unwrap_or((0, Unit::Seconds));
                    let after = unit.seconds() * Ratio::from_integer(i128::from(count));
                    MeasureEvent::Stale { component, port, after }
                }
                _ => return Err(not_a("output port", path)),
            },
        };
        Ok(Some(event))
    }

    /// Reports requests that are always refused (section 18): those of services whose `after` services cannot
    /// succeed.
    fn only_refused(&mut self) {
        let system = &self.out.system;
        let requested = system.requested();
        // Fixed point of the services that can succeed: services all of whose predecessors can.
        let mut can = ti_vec![false; system.services.len()];
        let after = |service: ServiceId, can: &TiSlice<ServiceId, bool>| {
            let mut all = system.services[service].after.iter();
            all.all(|&earlier| can[earlier])
        };
        while let Some(new) = (can.keys())
            .find(|&index: &ServiceId| requested[index] && !can[index] && after(index, &can))
        {
            can[new] = true;
        }
        let mut found: Vec<(ServiceId, &Path)> = Vec::new();
        for path in self.settings.clients.iter().flat_map(sends) {
            let service = self.service(path).ok();
            // The requests of a client with an error are not known.
            if let Some(service) = service.filter(|&service| requested[service] && !can[service])
                && found.iter().all(|other| other.0 != service)
            {
                found.push((service, path));
            }
        }
        for (service, path) in found {
            let system = &self.out.system;
            let missing = system.services[service].after.iter().filter(|&&index| !can[index]);
            let remark = Remark::OnlyRefused {
                service: system.service_path(service),
                missing: missing.map(|&service| system.service_path(service)).collect(),
            };
            self.report(remark.warning(path.range(), Vec::new()));
        }
    }

    fn named_service(&self, path: &Path) -> Result<(usize, model::ServiceId), Diagnostic> {
        match self.names.resolve(path)? {
            Target::Service(c, s) => Ok((c, s)),
            _ => Err(not_a("service", path)),
        }
    }

    pub(in crate::system) fn service(&self, path: &Path) -> Result<ServiceId, Diagnostic> {
        let service = self.named_service(path)?;
        let found = self.out.services.get(&service).copied();
        found.ok_or_else(|| not_a("service", path))
    }

    pub(in crate::system) fn activity(&self, path: &Path) -> Result<ServiceId, Diagnostic> {
        let (c, s) = self.named_service(path)?;
        if !self.names.is_activity(c, s) {
            return Err(not_a("activity", path));
        }
        self.service(path)
    }

    /// Returns the service of a request that every component accepts. The first name of the path is the
    /// component.
    pub(in crate::system) fn builtin(
        &self,
        path: &Path,
        which: Builtin,
    ) -> Result<ServiceId, Diagnostic> {
        // An abort names an activity of the component; the other requests name the component alone.
        let of_activity = matches!(which, Builtin::Abort | Builtin::Interrupt);
        let alone = of_activity || path.names.len() == 1;
        let interrupts = match which {
            Builtin::Interrupt => Some(self.activity(path)?),
            _ => None,
        };
        let number = (self.component_of(path).filter(|_| alone))
            .and_then(|component| self.out.components.get(&component));
        let mut services = self.out.system.services.iter_enumerated();
        services
            .find(|(_, service)| {
                Some(&service.component) == number
                    && service.builtin == Some(which)
                    && service.interrupts.first() == interrupts.as_ref()
            })
            .map(|service| service.0)
            .ok_or_else(|| not_a("component", path))
    }
}

/// Calls `each` with the path of every request that all components accept. For a label, the path is that of
/// the labelled request.
fn builtins<'s>(client: &'s ast::Client, each: &mut impl FnMut(&'s Path, Builtin)) {
    for step in Step::all(&client.steps) {
        match &step.kind {
            StepKind::Abort(path) => match path.names.as_slice() {
                [label] => {
                    let labels = program::labelled(&client.steps);
                    let requests = labels.filter(|other| other.0 == label.value);
                    requests.for_each(|request| each(request.1, Builtin::Abort));
                }
                _ if client.trigger.is_some() => each(path, Builtin::Interrupt),
                _ => each(path, Builtin::Abort),
            },
            StepKind::Kill(path) => each(path, Builtin::Kill),
            StepKind::Connect(path) => each(path, Builtin::Connect),
            _ => {}
        }
    }
}

/// Returns the paths of all requests.
fn sends(client: &ast::Client) -> impl Iterator<Item = &Path> {
    Step::all(&client.steps).into_iter().filter_map(|step| match &step.kind {
        StepKind::Send(path) => Some(path),
        _ => None,
    })
}
