//! Objects of the model as templates see them, and the names of their commands.
//!
//! Each object is a Tcl command `::dotgen::object::KIND@0xHEX`. Numbers grow in order of creation
//! and have a constant width, because templates sort these names. An object keeps its name when
//! more input is parsed, although its index in the model may change.

use dotgen_analysis::model::{
    Codel, CodelRef, Component, ComponentId, InitValue, Initializer, Owner, Param, Port, PortId,
    Remote, RemoteId, Service, ServiceId, Spec, Src, Task, TaskId, TypeId,
};
use rustc_hash::FxHashMap;

/// An object of the model, by its indexes.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) enum Object {
    /// A type object.
    Type(TypeId),
    /// Component or interface.
    Component(ComponentId),
    /// Component and task.
    Task(ComponentId, TaskId),
    /// Component and port.
    Port(ComponentId, PortId),
    /// Component and service.
    Service(ComponentId, ServiceId),
    /// Component and remote.
    Remote(ComponentId, RemoteId),
    /// Component and codel.
    Codel(ComponentId, CodelRef),
    /// Component and parameter.
    Param(ComponentId, ParamRef),
    /// A part of the default value of a parameter: the path of indexes from its root.
    Initializer(ComponentId, ParamRef, Vec<u32>),
}

/// Names a parameter of a component: the owner and the index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum ParamRef {
    Service(ServiceId, u32),
    Remote(RemoteId, u32),
    Codel(CodelRef, u32),
}

/// Looks up objects in a specification. The indexes come from the same specification.
pub(crate) trait Lookup {
    fn component(&self, component: ComponentId) -> &Component;

    fn task(&self, component: ComponentId, task: TaskId) -> &Task {
        &self.component(component).tasks[task]
    }

    fn port(&self, component: ComponentId, port: PortId) -> &Port {
        &self.component(component).ports[port]
    }

    fn service(&self, component: ComponentId, service: ServiceId) -> &Service {
        &self.component(component).services[service]
    }

    fn remote(&self, component: ComponentId, remote: RemoteId) -> &Remote {
        &self.component(component).remotes[remote]
    }

    fn codel(&self, component: ComponentId, codel: CodelRef) -> &Codel {
        self.component(component).codel(codel)
    }

    fn param(&self, component: ComponentId, param: ParamRef) -> &Param {
        match param {
            ParamRef::Service(service, index) => {
                &self.service(component, service).params[index as usize]
            }
            ParamRef::Remote(remote, index) => {
                &self.remote(component, remote).params[index as usize]
            }
            ParamRef::Codel(codel, index) => &self.codel(component, codel).params[index as usize],
        }
    }

    fn initializer(
        &self,
        component: ComponentId,
        param: ParamRef,
        path: &[u32],
    ) -> Option<&Initializer> {
        let mut at = self.param(component, param).init.as_ref()?;
        for index in path {
            match &at.value {
                InitValue::Compound(parts) => at = parts.get(*index as usize)?,
                _ => return None,
            }
        }
        Some(at)
    }
}

impl Lookup for Spec {
    fn component(&self, component: ComponentId) -> &Component {
        &self.components[component]
    }
}

/// The properties of an object that stay the same when the model is built again with more input.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum Identity {
    /// Kind, place, name, and index among equal ones.
    Type(&'static str, Src, String, u32),
    Component(String),
    /// Component, kind of thing, name.
    Member(String, &'static str, String),
    /// Component, owner, place, index among equal ones.
    Codel(String, String, Src, u32),
    /// Owner's handle and path inside.
    Inside(u64, Vec<u32>),
}

/// The names of all objects of the current model.
#[derive(Debug, Default, Clone)]
pub(crate) struct Registry {
    objects: FxHashMap<String, Object>,
    handles: FxHashMap<Object, String>,
    numbers: FxHashMap<Identity, u64>,
    next: u64,
}

/// The first number; it has the width of the numbers that GenoM3 shows.
const FIRST: u64 = 0x1000_0000_0000;

impl Registry {
    pub(crate) fn object(&self, handle: &str) -> Option<&Object> {
        match self.objects.get(handle) {
            None if !handle.starts_with("::") => self.objects.get(&format!("::{handle}")),
            found => found,
        }
    }

    /// The handle of an object of the current model.
    pub(crate) fn handle(&self, object: &Object) -> String {
        self.handles.get(object).cloned().unwrap_or_default()
    }

    /// Handles of several objects.
    pub(crate) fn handles(&self, objects: impl IntoIterator<Item = Object>) -> Vec<String> {
        objects.into_iter().map(|object| self.handle(&object)).collect()
    }

    /// Takes the objects of a new model; returns the handles that did not exist before.
    pub(crate) fn update(&mut self, spec: &Spec) -> Vec<String> {
        let known: Vec<String> = self.objects.keys().cloned().collect();
        let known: rustc_hash::FxHashSet<String> = known.into_iter().collect();
        self.objects.clear();
        self.handles.clear();
        let mut alike: FxHashMap<(&'static str, Src, String), u32> = FxHashMap::default();
        for (id, ty) in spec.types.iter_enumerated() {
            let kind = ty.kind.word();
            let name = spec.full_name(id).unwrap_or_default();
            let count = alike.entry((kind, ty.src, name.clone())).or_default();
            let identity = Identity::Type(kind, ty.src, name, *count);
            *count += 1;
            self.add("type", Object::Type(id), identity);
        }
        for index in spec.components.keys() {
            self.add_component(spec, index);
        }
        let mut created: Vec<String> =
            self.objects.keys().filter(|handle| !known.contains(*handle)).cloned().collect();
        created.sort_unstable();
        created
    }

    fn add(&mut self, class: &str, object: Object, identity: Identity) -> u64 {
        let next = self.next;
        let number = *self.numbers.entry(identity).or_insert(next);
        if number == next {
            self.next += 1;
        }
        let handle = format!("::dotgen::object::{class}@{:#x}", FIRST + number * 16);
        self.objects.insert(handle.clone(), object.clone());
        self.handles.insert(object, handle);
        number
    }

    fn add_component(&mut self, spec: &Spec, index: ComponentId) {
        let component = spec.component(index);
        let name = component.name.to_string();
        let member = |kind, member: &str| Identity::Member(name.clone(), kind, member.to_owned());
        self.add("component", Object::Component(index), Identity::Component(name.clone()));
        for (at, task) in component.tasks.iter_enumerated() {
            let object = Object::Task(index, at);
            self.add("task", object, member("task", &task.name));
        }
        for (at, port) in component.ports.iter_enumerated() {
            let object = Object::Port(index, at);
            self.add("port", object, member("port", &port.name));
        }
        for (at, service) in component.services.iter_enumerated() {
            let object = Object::Service(index, at);
            self.add("service", object, member("service", &service.name));
        }
        for (at, remote) in component.remotes.iter_enumerated() {
            let object = Object::Remote(index, at);
            let number = self.add("remote", object, member("remote", &remote.name));
            for param in 0..remote.params.len() as u32 {
                self.add_param(spec, index, ParamRef::Remote(at, param), number, param);
            }
        }
        let mut alike: FxHashMap<(String, Src), u32> = FxHashMap::default();
        for owner in in_order(component) {
            let (word, owner_name) = match owner {
                Owner::Task(task) => ("task", &component.tasks[task].name),
                Owner::Service(service) => ("service", &component.services[service].name),
            };
            if let Owner::Service(at) = owner {
                let number = self.numbers[&member("service", owner_name)];
                for param in 0..component.services[at].params.len() as u32 {
                    self.add_param(spec, index, ParamRef::Service(at, param), number, param);
                }
            }
            let owner_name = format!("{word} {owner_name}");
            for (codel_index, codel) in component.codels_of(owner).iter_enumerated() {
                let at = CodelRef { owner, index: codel_index };
                let count = alike.entry((owner_name.clone(), codel.src)).or_default();
                let identity = Identity::Codel(name.clone(), owner_name.clone(), codel.src, *count);
                *count += 1;
                let number = self.add("codel", Object::Codel(index, at), identity);
                for param in 0..codel.params.len() as u32 {
                    self.add_param(spec, index, ParamRef::Codel(at, param), number, param);
                }
            }
        }
    }

    fn add_param(
        &mut self,
        spec: &Spec,
        component: ComponentId,
        param: ParamRef,
        owner: u64,
        index: u32,
    ) {
        let object = Object::Param(component, param);
        let number = self.add("param", object, Identity::Inside(owner, vec![index]));
        if let Some(init) = &spec.param(component, param).init {
            self.add_initializer(component, param, init, number, &mut Vec::new());
        }
    }

    fn add_initializer(
        &mut self,
        component: ComponentId,
        param: ParamRef,
        init: &Initializer,
        owner: u64,
        path: &mut Vec<u32>,
    ) {
        // The path is marked to distinguish it from the parameters of an owner with the same number.
        let mut inside = vec![u32::MAX];
        inside.extend(&*path);
        self.add(
            "initer",
            Object::Initializer(component, param, path.clone()),
            Identity::Inside(owner, inside),
        );
        if let InitValue::Compound(parts) = &init.value {
            for (index, part) in parts.iter().enumerate() {
                path.push(index as u32);
                self.add_initializer(component, param, part, owner, path);
                path.pop();
            }
        }
    }
}

/// Tasks and services in order of creation: first those from interfaces, then the rest as written.
fn in_order(component: &Component) -> Vec<Owner> {
    let tasks = component.tasks.iter_enumerated();
    let services = component.services.iter_enumerated();
    let mut all: Vec<(Src, Owner)> =
        tasks.map(|(index, task)| (task.src, Owner::Task(index))).collect();
    all.extend(services.map(|(index, service)| (service.src, Owner::Service(index))));
    let home = (component.src.visit, component.src.item);
    all.sort_by_key(|(src, _)| {
        let own = (src.visit, src.item) == home;
        (own, if own { src.node } else { 0 })
    });
    all.into_iter().map(|(_, owner)| owner).collect()
}
