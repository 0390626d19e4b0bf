//! The interpreted system: specifications and a scenario as plain tables, read independently of the
//! verifier's builder.
//!
//! Times are whole milliseconds.

mod clients;

use dotgen_analysis::model::mutex::{self, Excluded};
use dotgen_analysis::model::{self, CodelKind, CodelRef, Owner, Seconds, ServiceKind, ServiceList};
use dotgen_timing::scn::ast::{self, Durations, Item, Policy, Scenario, Unit};
use dotgen_timing::scn::semantics::{Points, PortRule, Preset, Semantics};
use num_rational::Ratio;

pub(crate) use clients::{Aborted, Action, Client};

/// All tables.
pub(crate) struct System {
    pub(crate) components: Vec<Component>,
    pub(crate) clients: Vec<Client>,
    pub(crate) cores: Option<usize>,
    pub(crate) policy: Policy,
    pub(crate) aperiodic_core: bool,
    /// `before` and `after` apply.
    pub(crate) order: bool,
    pub(crate) semantics: Semantics,
}

pub(crate) struct Component {
    pub(crate) name: String,
    pub(crate) tasks: Vec<Task>,
    pub(crate) services: Vec<Service>,
    pub(crate) codels: Vec<Codel>,
}

pub(crate) struct Task {
    pub(crate) name: String,
    pub(crate) period: Option<u32>,
    pub(crate) delay: u32,
    pub(crate) slots: usize,
    pub(crate) priority: Option<u32>,
    /// Core that the task is bound to.
    pub(crate) affinity: Option<u32>,
    /// Permanent activity. Without states, it starts and ends at once.
    pub(crate) machine: Machine,
}

#[derive(Default)]
pub(crate) struct Machine {
    pub(crate) states: Vec<MachineState>,
    pub(crate) start: Option<usize>,
    pub(crate) stop: Option<usize>,
}

pub(crate) struct MachineState {
    pub(crate) name: String,
    pub(crate) codel: usize,
    pub(crate) outcomes: Vec<Outcome>,
}

/// The outcome of a codel of a machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    Next(usize),
    Pause(usize),
    End,
    Throw,
}

pub(crate) struct Service {
    pub(crate) name: String,
    /// Task and machine of an activity.
    pub(crate) activity: Option<(usize, Machine)>,
    /// Codels of the control task, in order.
    pub(crate) control: Vec<ControlCodel>,
    pub(crate) interrupts: Vec<usize>,
    pub(crate) before: Vec<usize>,
    pub(crate) after: Vec<usize>,
    pub(crate) builtin: Option<Builtin>,
}

/// A request that every component accepts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Builtin {
    Abort,
    Connect,
    Kill,
}

pub(crate) struct ControlCodel {
    /// Name; `None` for the copy of an attribute.
    pub(crate) name: Option<String>,
    pub(crate) codel: usize,
    /// The codel can refuse the request, or throw.
    pub(crate) can_fail: bool,
}

/// The execution of a codel: the task (`None`: the control task) and the name of the function.
pub(crate) type Executed = (Option<usize>, String);

pub(crate) struct Codel {
    pub(crate) lower: u32,
    pub(crate) upper: u32,
    pub(crate) executed: Executed,
    /// Executions for which the codel waits.
    pub(crate) waits_for: Vec<Executed>,
    /// Outputs that it uses, by component and name, if ports have locks.
    pub(crate) ports: Vec<(String, String)>,
    /// Data that the codel reads.
    pub(crate) reads: Vec<Datum>,
    /// Data that the codel writes.
    pub(crate) writes: Vec<Datum>,
}

/// A datum that codels read and write, of a component by name.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Datum {
    Port(String, String),
    Member(String, String),
    /// A parameter of a service, by number.
    Variable(String, model::ServiceId, u32),
}

fn millis(time: Seconds) -> u32 {
    let millis = time * Ratio::from_integer(1000);
    assert!(millis.is_integer(), "{time} s is no whole number of ms");
    millis.to_integer() as u32
}

fn in_millis(count: u64, unit: Unit) -> u32 {
    millis(unit.seconds() * Ratio::from_integer(i128::from(count)))
}

/// Reads specifications and a scenario.
pub(crate) fn read(specs: &[&model::Spec], scenario: &Scenario) -> System {
    let mut reader =
        Reader { fixed: false, exceptions: Vec::new(), connect: Vec::new(), all: specs };
    let mut points = Points::default();
    let mut out = System {
        components: Vec::new(),
        clients: Vec::new(),
        cores: None,
        policy: Policy::Fifo,
        aperiodic_core: true,
        order: true,
        semantics: Semantics::SERVERS,
    };
    for item in &scenario.items {
        match item {
            Item::Cores(cores) => out.cores = cores.map(|core| core as usize),
            Item::Policy(policy) => out.policy = *policy,
            Item::Durations(duration) => reader.fixed = *duration == Durations::Fixed,
            Item::AperiodicCore(core) => out.aperiodic_core = *core,
            Item::Order(order) => out.order = *order,
            Item::Exceptions(on, path) => reader.exceptions.push((*on, path.as_ref().map(text))),
            Item::Connect(from, to) => {
                reader.connect.push((text(from), to.as_ref().map(text)));
            }
            Item::Ticks(tick) => points.ticks = Some(*tick),
            Item::Turns(turn) => points.turns = Some(*turn),
            Item::Locks(lock) => points.locks = Some(*lock),
            Item::Ports(port) => points.ports = Some(*port),
            Item::Pause(pause) => points.pause = Some(*pause),
            _ => {}
        }
    }
    out.semantics = points.over(Preset::Servers);
    for spec in specs {
        for component in &spec.components {
            if component.kind == model::ComponentKind::Component {
                let semantics = out.semantics;
                out.components.push(reader.component(spec, component, semantics));
            }
        }
    }
    for item in &scenario.items {
        match item {
            Item::Slots(path, count) => out.task(path).slots = *count as usize,
            Item::Affinity(path, core) => out.task(path).affinity = Some(*core),
            Item::Client(declared) => {
                let client = clients::client(&out, declared);
                out.clients.push(client);
            }
            _ => {}
        }
    }
    out
}

impl System {
    pub(crate) fn component(&self, name: &str) -> usize {
        let mut all = self.components.iter();
        all.position(|component| component.name == name).expect("a component")
    }

    fn task(&mut self, path: &ast::Path) -> &mut Task {
        let c = self.component(&path.names[0].value);
        let mut tasks = self.components[c].tasks.iter_mut();
        let task = tasks.find(|task| task.name == path.names[1].value);
        task.expect("a task")
    }

    pub(crate) fn needs_core(&self, c: usize, t: usize) -> bool {
        let periodic = self.components[c].tasks[t].period.is_some();
        self.cores.is_some() && (periodic || self.aperiodic_core)
    }
}

fn text(path: &ast::Path) -> String {
    path.text()
}

struct Reader<'s> {
    fixed: bool,
    /// Rules for exceptions, in general or for a component, task or service; the last rule applies.
    exceptions: Vec<(bool, Option<String>)>,
    /// Inputs, each with its output, if any.
    connect: Vec<(String, Option<String>)>,
    all: &'s [&'s model::Spec],
}

/// Number of slots of a task, as in PocoLibs servers.
const SLOTS: usize = 16;

impl Reader<'_> {
    /// Returns true if exceptions of a task or service count.
    fn may_throw(&self, component: &str, owner: &str) -> bool {
        let path = format!("{component}.{owner}");
        let about = |pair: &&(bool, Option<String>)| match &pair.1 {
            None => true,
            Some(written) => *written == path || written == component,
        };
        self.exceptions.iter().rfind(about).is_none_or(|exception| exception.0)
    }

    /// Returns the data that a codel names, except parameters with this direction.
    fn data(&self, component: &model::Component, at: CodelRef, but: model::ParamDir) -> Vec<Datum> {
        let name = component.name.to_string();
        let params = component.codel(at).params.iter();
        let data = |param: &model::Param| match (param.source, at.owner) {
            (model::ParamSource::Port(p), _) => {
                let port = &component.ports[p];
                self.sources(component, port)
            }
            (model::ParamSource::Ids, _) => vec![member(&name, param)],
            (model::ParamSource::Local(Some(i)), Owner::Service(s)) => {
                vec![Datum::Variable(name.clone(), s, i)]
            }
            other => panic!("{other:?} is not drawn"),
        };
        params.filter(|param| param.dir != but).flat_map(data).collect()
    }

    /// Returns the outputs that supply the data of a port, or the port itself.
    fn sources(&self, component: &model::Component, port: &model::Port) -> Vec<Datum> {
        let outputs = self.outputs(component, port).into_iter();
        let found: Vec<Datum> = outputs.map(|(c, p)| Datum::Port(c, p)).collect();
        if found.is_empty() {
            vec![Datum::Port(component.name.to_string(), port.name.to_string())]
        } else {
            found
        }
    }

    /// Returns the outputs that are used with a port of a component.
    fn outputs(&self, component: &model::Component, port: &model::Port) -> Vec<(String, String)> {
        let name = component.name.to_string();
        if port.dir == model::PortDir::Out {
            return vec![(name, port.name.to_string())];
        }
        let input = format!("{name}.{}", port.name);
        let mut stated = self.connect.iter().filter(|entry| entry.0 == input).peekable();
        if stated.peek().is_some() {
            let outputs = stated.filter_map(|(_, output)| output.as_ref()?.split_once('.'));
            return outputs.map(|output| (output.0.to_owned(), output.1.to_owned())).collect();
        }
        // An output of the same name.
        let others = self.all.iter().flat_map(|spec| &spec.components);
        let others = others.filter(|other| other.name != component.name);
        let mut found = others.filter_map(|component| {
            let mut ports = component.ports.iter();
            ports.find(|other| other.dir == model::PortDir::Out && other.name == port.name)?;
            Some((component.name.to_string(), port.name.to_string()))
        });
        found.next().into_iter().collect()
    }

    fn component(
        &self,
        spec: &model::Spec,
        component: &model::Component,
        semantics: Semantics,
    ) -> Component {
        let mut codels = Vec::new();
        let throws = |owner: &str, more: &[&[model::TypeId]]| {
            let declares = !component.throws.is_empty() || more.iter().any(|ty| !ty.is_empty());
            declares && self.may_throw(&component.name, owner)
        };
        let mut codel = |at: CodelRef| {
            let codel = component.codel(at);
            let upper = codel.wcet.as_ref().map_or(0, |wcet| millis(wcet.value));
            let executed = |at: CodelRef| {
                let task = component.task_of(at).map(usize::from);
                (task, component.codel(at).name.to_string())
            };
            let list = mutex::exclusions(spec, component, at).into_iter();
            codels.push(Codel {
                lower: if self.fixed { upper } else { 0 },
                upper,
                executed: executed(at),
                waits_for: list
                    .map(|found| match found.with {
                        Excluded::Codel(other) => executed(other),
                        Excluded::Service(s) => (None, copy_of(component, s)),
                    })
                    .collect(),
                ports: (codel.params.iter())
                    .filter_map(|param| match param.source {
                        model::ParamSource::Port(p) => Some(&component.ports[p]),
                        _ => None,
                    })
                    .flat_map(|port| self.outputs(component, port))
                    .filter(|_| semantics.ports == PortRule::Lock)
                    .collect(),
                reads: self.data(component, at, model::ParamDir::Out),
                writes: self.data(component, at, model::ParamDir::In),
            });
            codels.len() - 1
        };
        let mut machine = |owner: Owner, throws: bool| {
            let list = component.codels_of(owner);
            let mut names: Vec<(&str, model::CodelId)> = Vec::new();
            let fsm = list.iter_enumerated().filter(|(_, codel)| codel.kind == CodelKind::Fsm);
            for (index, codel) in fsm {
                names.extend(codel.triggers.iter().map(|trigger| (trigger.name.as_str(), index)));
            }
            let find = |name: &str| names.iter().position(|candidate| candidate.0 == name);
            let states = names.iter().map(|&(name, index)| {
                let yields = list[index].yields.iter();
                let mut outcomes: Vec<Outcome> = yields
                    .map(|to| match find(&to.name) {
                        _ if to.name == "ether" => Outcome::End,
                        Some(state) if to.paused => Outcome::Pause(state),
                        Some(state) => Outcome::Next(state),
                        None => panic!("no codel for state {}", to.name),
                    })
                    .collect();
                outcomes.extend(throws.then_some(Outcome::Throw));
                MachineState {
                    name: name.to_owned(),
                    codel: codel(CodelRef { owner, index }),
                    outcomes,
                }
            });
            Machine { states: states.collect(), start: find("start"), stop: find("stop") }
        };
        let tasks = component.tasks.iter_enumerated().map(|(t, task)| Task {
            name: task.name.to_string(),
            period: task.period.as_ref().map(|period| millis(period.value)),
            delay: task.delay.as_ref().map_or(0, |delay| millis(delay.value)),
            slots: SLOTS,
            priority: (task.priority.as_ref())
                .and_then(|priority| u32::try_from(priority.value.to_integer()).ok()),
            affinity: None,
            machine: machine(Owner::Task(t), throws(&task.name, &[&task.throws])),
        });
        let tasks: Vec<Task> = tasks.collect();
        let mut machines: Vec<Option<(usize, Machine)>> = component
            .services
            .iter_enumerated()
            .map(|(s, service)| {
                let task = service.task.filter(|_| service.kind == ServiceKind::Activity)?;
                let throws =
                    throws(&service.name, &[&service.throws, &component.tasks[task].throws]);
                Some((usize::from(task), machine(Owner::Service(s), throws)))
            })
            .collect();
        let services = component.services.iter_enumerated().map(|(s, service)| {
            let owner = Owner::Service(s);
            let of_kind = |kind: CodelKind| {
                let all = service.codels.iter_enumerated();
                all.filter(move |(_, codel)| codel.kind == kind)
            };
            let mut control: Vec<ControlCodel> = Vec::new();
            for (index, found) in of_kind(CodelKind::Validate) {
                control.push(ControlCodel {
                    name: Some(found.name.to_string()),
                    codel: codel(CodelRef { owner, index }),
                    can_fail: true,
                });
            }
            if service.kind == ServiceKind::Attribute {
                control.push(ControlCodel { name: None, codel: usize::MAX, can_fail: false });
            }
            for (index, found) in of_kind(CodelKind::Simple) {
                control.push(ControlCodel {
                    name: Some(found.name.to_string()),
                    codel: codel(CodelRef { owner, index }),
                    can_fail: throws(&service.name, &[&service.throws]),
                });
            }
            let all = component.services.len();
            let list = |list: &ServiceList| {
                if list.all {
                    (0..all).collect()
                } else {
                    list.services.iter().map(|&service| usize::from(service)).collect()
                }
            };
            Service {
                name: service.name.to_string(),
                activity: machines[usize::from(s)].take(),
                control,
                interrupts: list(&service.interrupts),
                before: list(&service.before),
                after: list(&service.after),
                builtin: None,
            }
        });
        let mut services: Vec<Service> = services.collect();
        for (s, service) in component.services.keys().zip(&mut services) {
            for copy in service.control.iter_mut().filter(|control| control.name.is_none()) {
                let others = mutex::service_exclusions(spec, component, s).into_iter();
                let others = others.map(|at| {
                    let task = component.task_of(at).map(usize::from);
                    (task, component.codel(at).name.to_string())
                });
                let params = &component.services[s].params;
                let copied = || (0..).zip(params).filter(|(_, of)| of.dir != model::ParamDir::Out);
                copy.codel = codels.len();
                codels.push(Codel {
                    lower: 0,
                    upper: 0,
                    executed: (None, copy_of(component, s)),
                    waits_for: others.collect(),
                    ports: Vec::new(),
                    reads: copied()
                        .map(|(i, _)| Datum::Variable(component.name.to_string(), s, i))
                        .collect(),
                    writes: copied().map(|(_, param)| member(&component.name, param)).collect(),
                });
            }
        }
        self.builtins(&mut services, &mut codels);
        Component { name: component.name.to_string(), tasks, services, codels }
    }
}

impl Reader<'_> {
    /// Adds the requests that all components accept after their services, in the order of [`Builtin`].
    fn builtins(&self, services: &mut Vec<Service>, codels: &mut Vec<Codel>) {
        let of_tasks: Vec<Executed> = (codels.iter())
            .map(|codel| codel.executed.clone())
            .filter(|codel| codel.0.is_some())
            .collect();
        let stop = (None, "all tasks at rest".to_owned());
        for codel in codels.iter_mut().filter(|codel| codel.executed.0.is_some()) {
            codel.waits_for.push(stop.clone());
        }
        for builtin in [Builtin::Abort, Builtin::Connect, Builtin::Kill] {
            let mut control = Vec::new();
            let mut codel = |executed: Executed, waits_for: Vec<Executed>| {
                codels.push(Codel {
                    lower: 0,
                    upper: 0,
                    executed,
                    waits_for,
                    ports: Vec::new(),
                    reads: Vec::new(),
                    writes: Vec::new(),
                });
                control.push(ControlCodel { name: None, codel: codels.len() - 1, can_fail: false });
            };
            codel((None, format!("{builtin:?} itself")), Vec::new());
            if builtin == Builtin::Connect {
                codel(stop.clone(), of_tasks.clone());
            }
            services.push(Service {
                name: format!("{builtin:?} of all"),
                activity: None,
                control,
                interrupts: Vec::new(),
                before: Vec::new(),
                after: Vec::new(),
                builtin: Some(builtin),
            });
        }
    }
}

/// The copy of an attribute is not a function; its name is one that no function has.
fn member(component: &str, param: &model::Param) -> Datum {
    match param.path.first() {
        Some(model::PathElement::Member(name)) => {
            Datum::Member(component.to_owned(), name.to_string())
        }
        other => panic!("{other:?} is not drawn"),
    }
}

fn copy_of(component: &model::Component, service: model::ServiceId) -> String {
    format!("copy {}", component.services[service].name)
}
