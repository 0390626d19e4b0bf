//! The model as a JSON document: the output of `dotgen model`.
//!
//! The document has the keys of the model summary (language reference, section 20), and additional ones:
//! places in the text, exact times, the shared data that causes exclusions, and the interfaces that a
//! component imports. `docs/model.md` describes it. Keys may be added, but never change their meaning.

mod codels;

use serde_json::{Map, Value as Json, json};

use crate::{
    model::{
        Codel, CodelKind, Component, ComponentId, Label, Owner, Quantity, ServiceId, ServiceList,
        Spec, Src, State, Task, TaskId, Type, TypeId, TypeKind, Value, layout::max_size,
    },
    source_map::Locations,
};

/// Prototypes of a codel of a component (by index), by language; the mapping of types to languages is in
/// another crate.
pub type Prototypes<'a> = dyn Fn(ComponentId, &Codel) -> Map<String, Json> + 'a;

/// The document of a whole unit. Without `locations`, it contains no places.
pub fn to_json(spec: &Spec, locations: Option<&dyn Locations>) -> Json {
    with_prototypes(spec, locations, None)
}

/// The document of a whole unit, with the prototypes of codels.
pub fn with_prototypes(
    spec: &Spec,
    locations: Option<&dyn Locations>,
    prototypes: Option<&Prototypes<'_>>,
) -> Json {
    let writer = Writer { spec, locations, prototypes };
    let mut components: Vec<&Component> = spec.components.iter().collect();
    components.sort_by(|a, b| a.name.cmp(&b.name));
    let components: Vec<Json> =
        components.iter().map(|component| writer.component(component)).collect();
    json!({ "components": components, "types": writer.types() })
}

struct Writer<'m> {
    spec: &'m Spec,
    locations: Option<&'m dyn Locations>,
    prototypes: Option<&'m Prototypes<'m>>,
}

/// An object under construction.
#[derive(Default)]
struct Object(Map<String, Json>);

impl Object {
    fn put(&mut self, key: &str, value: impl Into<Json>) -> &mut Self {
        self.0.insert(key.to_owned(), value.into());
        self
    }

    fn put_some(&mut self, key: &str, value: Option<impl Into<Json>>) -> &mut Self {
        if let Some(value) = value {
            self.put(key, value);
        }
        self
    }

    fn done(self) -> Json {
        Json::Object(self.0)
    }
}

impl Writer<'_> {
    fn component(&self, component: &Component) -> Json {
        let mut out = Object::default();
        out.put("name", component.name.as_str());
        out.put("kind", json!(component.kind));
        out.put_some("doc", component.doc.as_deref());
        out.put_some("version", component.version.as_deref());
        out.put_some("lang", component.lang.as_deref());
        out.put_some("email", component.email.as_deref());
        out.put("requires", json!(component.requires));
        out.put("codels-require", json!(component.codels_requires));
        self.time(&mut out, "clock-rate", &component.clock_rate);
        let stack = component.stack.as_ref().map(amount);
        out.put_some("stack", stack);
        if let Some(TypeKind::Struct { members }) = component.ids.map(|ty| &self.spec.ty(ty).kind) {
            let members: Vec<Json> =
                members.iter().map(|member| self.ids_member(*member)).collect();
            out.put("ids", members);
        }
        let all = |list: &mut dyn Iterator<Item = Json>| Json::Array(list.collect());
        let tasks = component.tasks.iter_enumerated();
        out.put("tasks", all(&mut tasks.map(|(i, task)| self.task(component, i, task))));
        out.put("ports", all(&mut component.ports.iter().map(|port| self.port(port))));
        let services = component.services.keys();
        out.put("services", all(&mut services.map(|service| self.service(component, service))));
        let remotes = component.remotes.iter();
        out.put("remotes", all(&mut remotes.map(|remote| self.remote(component, remote))));
        let mut throws = component.throws.clone();
        let inner = component.tasks.iter().map(|task| &task.throws);
        let inner = inner.chain(component.services.iter().map(|service| &service.throws));
        for ty in inner.flatten() {
            if !throws.contains(ty) {
                throws.push(*ty);
            }
        }
        out.put("throws", self.names_of(&throws));
        for (key, list) in [
            ("provides", &component.provides),
            ("uses", &component.uses),
            ("extends", &component.extends),
        ] {
            let names: Vec<&str> = list
                .iter()
                .filter_map(|number| self.spec.components.get(*number))
                .map(|component| component.name.as_str())
                .collect();
            if !names.is_empty() {
                out.put(key, json!(names));
            }
        }
        self.place(&mut out, component.src);
        out.done()
    }

    fn ids_member(&self, member: TypeId) -> Json {
        let mut out = Object::default();
        let ty = self.spec.ty(member);
        out.put("name", ty.name.as_deref().unwrap_or_default());
        out.put("type", self.type_name(self.spec.member_type(member)));
        self.place(&mut out, ty.src);
        out.done()
    }

    fn task(&self, component: &Component, index: TaskId, task: &Task) -> Json {
        let mut out = Object::default();
        out.put("name", task.name.as_str());
        out.put_some("doc", task.doc.as_deref());
        self.time(&mut out, "period", &task.period);
        self.time(&mut out, "delay", &task.delay);
        out.put_some("priority", task.priority.as_ref().map(amount));
        out.put_some("stack", task.stack.as_ref().map(amount));
        out.put_some("scheduling", task.real_time.then_some("real-time"));
        let throws = unique([&component.throws, &task.throws]);
        out.put("throws", self.names_of(&throws));
        out.put("codels", self.codels(component, Owner::Task(index), None));
        self.origin(&mut out, task.imported_from);
        self.place(&mut out, task.src);
        out.done()
    }

    fn port(&self, port: &crate::model::Port) -> Json {
        let mut out = Object::default();
        out.put("name", port.name.as_str());
        out.put("dir", json!(port.dir));
        out.put("kind", if port.multiple { "multiple" } else { "simple" });
        out.put("type", self.type_name(port.data));
        out.put_some("doc", port.doc.as_deref());
        self.origin(&mut out, port.imported_from);
        self.place(&mut out, port.src);
        out.done()
    }

    fn service(&self, component: &Component, index: ServiceId) -> Json {
        let service = &component.services[index];
        let mut out = Object::default();
        out.put("name", service.name.as_str());
        out.put("kind", json!(service.kind));
        out.put_some("doc", service.doc.as_deref());
        let task = service.task.and_then(|task| component.tasks.get(task));
        out.put_some("task", task.map(|task| task.name.as_str()));
        let params = service.params.iter().map(|param| self.param(component, None, param));
        out.put("params", params.collect::<Vec<_>>());
        for (key, kind) in [
            ("validate", CodelKind::Validate),
            ("simple", CodelKind::Simple),
            ("fsm", CodelKind::Fsm),
        ] {
            let codels = self.codels(component, Owner::Service(index), Some(kind));
            out.put(key, codels);
        }
        let none = Vec::new();
        let task_throws = task.map_or(&none, |task| &task.throws);
        let throws = unique([&component.throws, task_throws, &service.throws]);
        out.put("throws", self.names_of(&throws));
        out.put("interrupts", service_names(component, &service.interrupts));
        out.put("before", service_names(component, &service.before));
        out.put("after", service_names(component, &service.after));
        self.origin(&mut out, service.imported_from);
        self.place(&mut out, service.src);
        out.done()
    }

    fn remote(&self, component: &Component, remote: &crate::model::Remote) -> Json {
        let mut out = Object::default();
        out.put("name", remote.name.as_str());
        out.put("kind", json!(remote.kind));
        let params = remote.params.iter().map(|param| self.param(component, None, param));
        out.put("params", params.collect::<Vec<_>>());
        let interface = self.spec.components.get(remote.interface);
        out.put_some("interface", interface.map(|interface| interface.name.as_str()));
        out.put("throws", self.names_of(&remote.throws));
        self.place(&mut out, remote.src);
        out.done()
    }

    // Types

    fn types(&self) -> Json {
        let mut out = Object::default();
        let ids = self.spec.types.keys();
        let mut named: Vec<(String, TypeId)> = ids
            .filter(|ty| self.spec.ty(*ty).name.is_some() && is_listed(&self.spec.ty(*ty).kind))
            .filter_map(|ty| Some((self.spec.full_name(ty)?, ty)))
            .collect();
        named.sort_by(|a, b| a.0.cmp(&b.0));
        for (name, id) in named {
            out.put(&name, self.ty(id));
        }
        out.done()
    }

    fn ty(&self, id: TypeId) -> Json {
        let ty: &Type = self.spec.ty(id);
        let mut out = Object::default();
        out.put("kind", ty.kind.word());
        match &ty.kind {
            TypeKind::Typedef { ty } => {
                out.put("type", self.type_name(*ty));
            }
            TypeKind::Const { ty, value } => {
                out.put("type", self.type_name(*ty));
                out.put("value", self.value(value));
                out.put("valuekind", value.word());
            }
            TypeKind::Enum { enumerators } => {
                let names = enumerators.iter().map(|enumerator| self.short_name(*enumerator));
                out.put("members", names.collect::<Vec<_>>());
            }
            TypeKind::Struct { members } | TypeKind::Exception { members } => {
                let members = members.iter().map(|member| self.member(*member));
                out.put("members", members.collect::<Vec<_>>());
            }
            TypeKind::Union { switch, members } => {
                let members = members.iter().map(|member| self.member(*member));
                out.put("members", members.collect::<Vec<_>>());
                out.put("switch", self.type_name(*switch));
            }
            _ => {}
        }
        if !matches!(ty.kind, TypeKind::Const { .. }) {
            out.put_some("size", max_size(self.spec, id));
        }
        for (template, data) in &ty.masquerade {
            let known = out.0.entry("masquerade").or_insert_with(|| json!({}));
            known[template.as_str()] = json!(data);
        }
        self.place(&mut out, ty.src);
        out.done()
    }

    fn member(&self, id: TypeId) -> Json {
        let ty = self.spec.ty(id);
        let mut out = Object::default();
        out.put("name", self.short_name(id));
        out.put("kind", ty.kind.word());
        out.put("type", self.type_name(self.spec.member_type(id)));
        if let TypeKind::UnionMember { labels, .. } = &ty.kind {
            let labels = labels.iter().map(|label| match label {
                Label::Default => String::new(),
                Label::Case(value) => self.label(value),
            });
            out.put("cases", labels.collect::<Vec<_>>());
        }
        out.done()
    }

    fn short_name(&self, id: TypeId) -> &str {
        self.spec.ty(id).name.as_deref().unwrap_or_default()
    }

    /// A type where it is used.
    fn type_name(&self, id: TypeId) -> String {
        let composed = || self.spec.composed_text(id, ",", &|part| self.type_name(part));
        self.spec.full_name(id).unwrap_or_else(composed)
    }

    fn names_of(&self, types: &[TypeId]) -> Json {
        types.iter().map(|ty| self.type_name(*ty)).collect()
    }

    // Values

    fn value(&self, value: &Value) -> Json {
        match value {
            Value::Bool(flag) => json!(flag),
            Value::Uint(number) => json!(number),
            Value::Int(number) => json!(number),
            Value::Float(number) => json!(number),
            Value::Char(character) | Value::String(character) => json!(character),
            Value::Enum(enumeration) => json!(self.type_name(*enumeration)),
        }
    }

    fn label(&self, value: &Value) -> String {
        match value {
            Value::Bool(byte) => u8::from(*byte).to_string(),
            value => match self.value(value) {
                Json::String(text) => text,
                other => other.to_string(),
            },
        }
    }

    /// A time in seconds: as a float, and exactly.
    fn time(&self, out: &mut Object, key: &str, time: &Option<Quantity>) {
        if let Some(time) = time {
            let (numer, denom) = (time.value.numer(), time.value.denom());
            out.put(key, *numer as f64 / *denom as f64);
            out.put(&format!("{key}-exact"), format!("{numer}/{denom}"));
        }
    }

    // Places

    fn origin(&self, out: &mut Object, interface: Option<ComponentId>) {
        let interface = interface.and_then(|interface| self.spec.components.get(interface));
        out.put_some("imported-from", interface.map(|interface| interface.name.as_str()));
    }

    fn place(&self, out: &mut Object, src: Src) {
        if let Some(place) = self.locations.and_then(|location| location.locate(src)) {
            let place = json!({
                "file": place.path.as_str(),
                "line": place.start.line + 1,
                "column": place.start.col + 1,
            });
            out.put("location", place);
        }
    }
}

fn is_listed(kind: &TypeKind) -> bool {
    !matches!(
        kind,
        TypeKind::StructMember { .. }
            | TypeKind::UnionMember { .. }
            | TypeKind::Enumerator { .. }
            | TypeKind::Event
            | TypeKind::PauseEvent
            | TypeKind::Port { .. }
            | TypeKind::Remote { .. }
            | TypeKind::ForwardStruct { .. }
            | TypeKind::ForwardUnion { .. }
            | TypeKind::Unknown
    )
}

fn amount(quantity: &Quantity) -> Json {
    json!(u64::try_from(quantity.value.to_integer()).unwrap_or(u64::MAX))
}

fn states(states: &[State]) -> Json {
    let text = |state: &State| {
        if state.paused { format!("pause::{}", state.name) } else { state.name.to_string() }
    };
    states.iter().map(text).collect()
}

fn service_names(component: &Component, list: &ServiceList) -> Json {
    let name = |service: &crate::model::Service| service.name.to_string();
    if list.all {
        return component.services.iter().map(name).collect();
    }
    let named = list.services.iter();
    named.filter_map(|service| component.services.get(*service)).map(name).collect()
}

fn unique<const N: usize>(lists: [&Vec<TypeId>; N]) -> Vec<TypeId> {
    let mut all: Vec<TypeId> = Vec::new();
    for ty in lists.into_iter().flatten() {
        if !all.contains(ty) {
            all.push(*ty);
        }
    }
    all
}
