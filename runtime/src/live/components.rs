//! The parts of a system with real codels.

use dotgen_analysis::model::{self, Name, Param, PortDir, PortId, Remote, ServiceKind};
use dotgen_codegen::codels::value::{Values, is_input, is_output};
use dotgen_timing::scn::names::{Member, Names};
use dotgen_timing::system::settings::Settings;
use dotgen_timing::system::{
    ClientId, CodelId, ComponentId, FOREVER, ServiceId, TimedSystem, sources,
};
use dotgen_timing::verify::Prepared;
use num_rational::Ratio;
use std::collections::HashSet;
use typed_index_collections::{TiVec, ti_vec};

/// A component that a host runs.
#[derive(Debug, Clone)]
pub struct HostedComponent<'s> {
    /// Component and its specification.
    pub member: Member<'s>,
    /// Functions of codels that the component lacks.
    pub missing: HashSet<Name>,
}

/// A data flow from an output port to an input port.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DataFlow {
    /// Component of the system, and output port.
    pub from: (ComponentId, PortId),
    /// Component of the system, and input port.
    pub to: (ComponentId, PortId),
    /// The input distinguishes its sources by name.
    pub multiple: bool,
}

/// All parts, and their connections. Indices are components, codels or services of the system.
#[derive(Debug)]
pub struct HostedComponents<'s> {
    components: TiVec<ComponentId, Option<HostedComponent<'s>>>,
    codels: TiVec<CodelId, Option<u32>>,
    functions: TiVec<CodelId, String>,
    /// Full names of the declared events, by codel.
    declared: TiVec<CodelId, Vec<String>>,
    /// Stated execution times in nanoseconds, by codel.
    limits: TiVec<CodelId, Option<u64>>,
    /// Component and service, as in [`Names::components`], by service of the system.
    pub(super) services: TiVec<ServiceId, (usize, model::ServiceId)>,
    /// Codels that copy the values of attributes, by service.
    pub(super) copies: TiVec<ServiceId, Option<u32>>,
    /// Inputs of requests by clients of the scenario, by service.
    pub(super) inputs: TiVec<ServiceId, Vec<u8>>,
    /// Flows from outputs to inputs.
    pub feeds: Vec<DataFlow>,
    /// Inputs that are not fed because their types differ.
    pub unlike: Vec<String>,
    /// Services of the system that remotes stand for, by component and remote.
    remotes: TiVec<ComponentId, Vec<Option<ServiceId>>>,
    /// First client that stands for requests from outside. The clients are in the order of components.
    first_outside: Option<ClientId>,
}

impl<'s> HostedComponents<'s> {
    /// Looks up the parts. `parts` are the components with hosts, by number in [`Names::components`].
    /// `inputs` are the inputs of a service, by `component.service`.
    pub fn new(
        prepared: &Prepared,
        names: &Names<'s>,
        settings: &Settings,
        mut parts: Vec<Option<HostedComponent<'s>>>,
        inputs: &dyn Fn(&str) -> Option<Vec<u8>>,
    ) -> Self {
        let built = &prepared.built;
        let system = &built.system;
        let mut out = HostedComponents {
            components: (system.components.keys()).map(|_| None).collect(),
            codels: ti_vec![None; system.codels.len()],
            functions: ti_vec![String::new(); system.codels.len()],
            declared: ti_vec![Vec::new(); system.codels.len()],
            limits: ti_vec![None; system.codels.len()],
            services: ti_vec![(0, 0.into()); system.services.len()],
            copies: ti_vec![None; system.services.len()],
            inputs: ti_vec![Vec::new(); system.services.len()],
            feeds: Vec::new(),
            unlike: Vec::new(),
            remotes: ti_vec![Vec::new(); system.components.len()],
            first_outside: None,
        };
        for (&name, &component) in &built.components {
            out.components[component] = parts.get_mut(name).and_then(Option::take);
        }
        let nanos = system.unit * Ratio::from_integer(1_000_000_000);
        for (at, codel) in system.codels.iter_enumerated() {
            let Some((name, site)) = codel.site else {
                continue;
            };
            let member = &names.components[name];
            let definition = member.component.codel(site);
            out.functions[at] = definition.name.to_string();
            let events = definition.yields.iter();
            out.declared[at] =
                events.filter_map(|event| member.spec.full_name(event.event)).collect();
            // Without a `wcet`, a time is one that the scenario states.
            let stated = definition.wcet.is_some() || codel.upper > 0;
            if codel.upper != FOREVER && stated {
                let limit = (nanos * Ratio::from_integer(i128::from(codel.upper))).to_integer();
                out.limits[at] = u64::try_from(limit).ok();
            }
            let part = out.components[codel.component].as_ref();
            if part.is_some_and(|part| !part.missing.contains(&definition.name)) {
                let number = member.component.all_codels().position(|codel| codel == site);
                out.codels[at] = number.and_then(|number| u32::try_from(number).ok());
            }
        }
        for (&(name, index), &service) in &built.services {
            let component = names.components[name].component;
            out.services[service] = (name, index);
            let definition = &component.services[index];
            if definition.kind == ServiceKind::Attribute {
                let number = component.all_codels().count() + usize::from(index);
                out.copies[service] = u32::try_from(number).ok();
            }
            let values = Values::new(names.components[name].spec);
            let given = inputs(&system.service_path(service));
            out.inputs[service] = given.unwrap_or_else(|| {
                let defaults = values.inputs(definition, &serde_json::Map::new());
                defaults.unwrap_or_default()
            });
        }
        out.connect(prepared, names, settings);
        for (&name, &component) in &built.components {
            let remotes = names.components[name].component.remotes.iter();
            let service = |remote| built.services.get(&provider(names, name, remote)?).copied();
            out.remotes[component] = remotes.map(service).collect();
        }
        out
    }

    fn connect(&mut self, prepared: &Prepared, names: &Names<'s>, settings: &Settings) {
        let number = |name: usize| prepared.built.components.get(&name).copied();
        for (name, member) in names.components.iter().enumerate() {
            let Some(reader) = number(name) else { continue };
            for (index, port) in member.component.ports.iter_enumerated() {
                if port.dir == PortDir::Out {
                    continue;
                }
                for (other, source) in sources(names, settings, (name, index)) {
                    let Some(writer) = number(other) else {
                        continue;
                    };
                    let from = &names.components[other];
                    let output = &from.component.ports[source];
                    let written = Values::new(from.spec).layout(output.data);
                    if written != Values::new(member.spec).layout(port.data) {
                        self.unlike.push(format!(
                            "`{}.{}` is not fed by `{}.{}`: their types hold something else",
                            member.component.name, port.name, from.component.name, output.name
                        ));
                        continue;
                    }
                    self.feeds.push(DataFlow {
                        from: (writer, source),
                        to: (reader, index),
                        multiple: port.multiple,
                    });
                }
            }
        }
    }

    /// Returns the service of the system that a remote of a component stands for.
    pub fn remote(&self, component: ComponentId, remote: u32) -> Option<ServiceId> {
        *self.remotes.get(component)?.get(remote as usize)?
    }

    /// Returns true if codels of a component may request services of others.
    pub(crate) fn has_remotes(&self, component: ComponentId) -> bool {
        let remotes = self.remotes.get(component);
        remotes.is_some_and(|remotes| !remotes.is_empty())
    }

    /// Adds clients for requests from outside. They follow the clients of the scenario: see
    /// [`refine`](crate::refine).
    pub fn with_outside(mut self, first: ClientId) -> Self {
        self.first_outside = Some(first);
        self
    }

    /// Returns the component to which a client sends requests from outside.
    pub fn outside(&self, client: ClientId) -> Option<ComponentId> {
        let index = usize::from(client).checked_sub(self.first_outside?.into());
        index.map(ComponentId::from)
    }

    /// Returns the client that sends the outside requests to a component.
    pub(crate) fn client_of(&self, component: ComponentId) -> Option<ClientId> {
        let first = usize::from(self.first_outside?);
        Some(ClientId::from(first + usize::from(component)))
    }

    /// Returns the component, if it has a host.
    pub fn of(&self, component: ComponentId) -> Option<&HostedComponent<'s>> {
        self.components.get(component)?.as_ref()
    }

    /// Returns the number of a codel in its host; `None` if the codel is simulated.
    pub fn codel(&self, codel: CodelId) -> Option<u32> {
        self.codels.get(codel).copied().flatten()
    }

    pub fn function(&self, codel: CodelId) -> String {
        self.functions.get(codel).cloned().unwrap_or_default()
    }

    /// Returns true if a codel may end with an event of this full name.
    pub fn declares(&self, codel: CodelId, event: &str) -> bool {
        self.events(codel).iter().any(|name| name == event)
    }

    /// Returns the full names of the events that a codel may end with.
    pub fn events(&self, codel: CodelId) -> &[String] {
        self.declared.get(codel).map_or(&[], Vec::as_slice)
    }

    /// Returns the stated execution time of a codel, in nanoseconds.
    pub fn limit(&self, codel: CodelId) -> Option<u64> {
        self.limits.get(codel).copied().flatten()
    }

    /// Returns the numbers of executed and of simulated codels.
    pub fn counts(&self, system: &TimedSystem) -> (usize, usize) {
        let real = self.codels.iter().flatten().count();
        // The copies of attributes are codels of no specification, and count as neither.
        let all = system.codels.iter().filter(|codel| codel.site.is_some()).count();
        (real, all.saturating_sub(real))
    }
}

/// Returns the component and service that a remote stands for: the only other component that is the interface
/// or provides it. `None` also if the types of the parameters differ.
fn provider(
    names: &Names<'_>,
    asking: usize,
    remote: &Remote,
) -> Option<(usize, model::ServiceId)> {
    let own = &names.components[asking];
    let interface = &own.spec.components.get(remote.interface)?.name;
    let all = names.components.iter().enumerate();
    let mut found = all.filter(|(name, member)| {
        let mut provided = member.component.provides.iter();
        let provides = provided.any(|of| member.spec.components[*of].name == *interface);
        *name != asking && (member.component.name == *interface || provides)
    });
    let (name, member) = found.next()?;
    if found.next().is_some() {
        return None;
    }
    let mut services = member.component.services.iter_enumerated();
    let (number, service) = services.find(|service| service.1.name == remote.name)?;
    let shape = |spec, params: &[Param]| -> Vec<_> {
        let crosses = params.iter().filter(|param| is_input(param) || is_output(param));
        let layout = |param: &Param| (param.dir, Values::new(spec).layout(param.ty));
        crosses.map(layout).collect()
    };
    let alike = shape(own.spec, &remote.params) == shape(member.spec, &service.params);
    alike.then_some((name, number))
}
