//! The model as a JSON document: the output of `dotgen model`.
//!
//! The document has the keys of the model summary (language reference, section 20), and additional ones:
//! places in the text, exact times, the shared data that causes exclusions, and the interfaces that a
//! component imports. `docs/model.md` describes it. Keys may be added, but never change their meaning.

use serde_json::{Map, Value as Json, json};

use crate::{
    elab::types::{elements, member_named, resolve_aliases},
    model::{
        Codel, CodelKind, CodelRef, Component, ComponentKind, InitValue, Initializer, Label, Name,
        Owner, Param, ParamSource, PathElement, Quantity, ServiceList, Spec, Src, State, Task,
        Type, TypeId, TypeKind, Value,
        layout::max_size,
        mutex::{Excluded, exclusions, path_text},
    },
    source_map::Locations,
};

/// Prototypes of a codel of a component (by index), by language; the mapping of types to languages is in
/// another crate.
pub type Prototypes<'a> = dyn Fn(u32, &Codel) -> Map<String, Json> + 'a;

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
    let writer = Writer {
        spec,
        locations,
        prototypes,
    };
    let mut components: Vec<&Component> = spec.components.iter().collect();
    components.sort_by(|a, b| a.name.cmp(&b.name));
    let components: Vec<Json> = components
        .iter()
        .map(|component| writer.component(component))
        .collect();
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
            let members: Vec<Json> = members
                .iter()
                .map(|member| self.ids_member(*member))
                .collect();
            out.put("ids", members);
        }
        let all = |list: &mut dyn Iterator<Item = Json>| Json::Array(list.collect());
        let tasks = (0..).zip(&component.tasks);
        out.put(
            "tasks",
            all(&mut tasks.map(|(i, task)| self.task(component, i, task))),
        );
        out.put(
            "ports",
            all(&mut component.ports.iter().map(|port| self.port(port))),
        );
        let services = 0..component.services.len() as u32;
        out.put(
            "services",
            all(&mut services.map(|service| self.service(component, service))),
        );
        let remotes = component.remotes.iter();
        out.put(
            "remotes",
            all(&mut remotes.map(|remote| self.remote(component, remote))),
        );
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
                .filter_map(|number| self.spec.components.get(*number as usize))
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
        out.put("type", self.type_name(value_type(self.spec, member)));
        self.place(&mut out, ty.src);
        out.done()
    }

    fn task(&self, component: &Component, index: u32, task: &Task) -> Json {
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

    fn service(&self, component: &Component, index: u32) -> Json {
        let service = &component.services[index as usize];
        let mut out = Object::default();
        out.put("name", service.name.as_str());
        out.put("kind", json!(service.kind));
        out.put_some("doc", service.doc.as_deref());
        let task = service
            .task
            .and_then(|task| component.tasks.get(task as usize));
        out.put_some("task", task.map(|task| task.name.as_str()));
        let params = service
            .params
            .iter()
            .map(|param| self.param(component, None, param));
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
        let params = remote
            .params
            .iter()
            .map(|param| self.param(component, None, param));
        out.put("params", params.collect::<Vec<_>>());
        let interface = self.spec.components.get(remote.interface as usize);
        out.put_some(
            "interface",
            interface.map(|interface| interface.name.as_str()),
        );
        out.put("throws", self.names_of(&remote.throws));
        self.place(&mut out, remote.src);
        out.done()
    }

    // Codels

    fn codels(&self, component: &Component, owner: Owner, kind: Option<CodelKind>) -> Json {
        let codels = (0..).zip(component.codels_of(owner));
        codels
            .filter(|(_, codel)| kind.is_none_or(|kind| codel.kind == kind))
            .map(|(index, codel)| self.codel(component, CodelRef { owner, index }, codel))
            .collect()
    }

    fn codel(&self, component: &Component, reference: CodelRef, codel: &Codel) -> Json {
        let mut out = Object::default();
        out.put("name", codel.name.as_str());
        out.put("kind", if codel.is_async { "async" } else { "sync" });
        let service = match reference.owner {
            Owner::Service(service) => component.services.get(service as usize),
            Owner::Task(_) => None,
        };
        let params = codel.params.iter();
        let params = params
            .map(|param| self.param(component, service.map(|service| &service.params), param));
        out.put("params", params.collect::<Vec<_>>());
        if codel.kind == CodelKind::Fsm {
            out.put("triggers", states(&codel.triggers));
            out.put("yields", states(&codel.yields));
        }
        if component.kind == ComponentKind::Component {
            self.locks(&mut out, component, reference);
        }
        self.time(&mut out, "wcet", &codel.wcet);
        let index = self.spec.components.iter();
        let index = index
            .zip(0..)
            .find(|(index, _)| index.name == component.name);
        if let (Some(prototypes), Some((_, index))) = (self.prototypes, index) {
            let prototypes = prototypes(index, codel);
            if !prototypes.is_empty() {
                out.put("prototypes", prototypes);
            }
        }
        self.place(&mut out, codel.src);
        out.done()
    }

    /// The exclusions of a codel: the names, and the shared data.
    fn locks(&self, out: &mut Object, component: &Component, codel: CodelRef) {
        let mut names: Vec<&str> = Vec::new();
        let mut locks: Vec<Json> = Vec::new();
        for exclusion in exclusions(self.spec, component, codel) {
            let mut lock = Object::default();
            let name: &Name = match exclusion.with {
                Excluded::Codel(other) => {
                    let name = &component.codel(other).name;
                    lock.put("codel", name.as_str());
                    match other.owner {
                        Owner::Task(task) => {
                            lock.put("task", component.tasks[task as usize].name.as_str())
                        }
                        Owner::Service(service) => lock.put(
                            "service",
                            component.services[service as usize].name.as_str(),
                        ),
                    };
                    name
                }
                Excluded::Service(other) => {
                    let name = &component.services[other as usize].name;
                    lock.put("attribute", name.as_str());
                    name
                }
            };
            names.push(name);
            let mut through: Vec<Json> = Vec::new();
            for parameters in &exclusion.through {
                let shared = match &parameters.shared {
                    crate::model::mutex::Shared::Ids(path) => json!({ "ids": path_text(path) }),
                    crate::model::mutex::Shared::Port(port) => {
                        let port = component.ports.get(*port as usize);
                        json!({ "port": port.map(|parameters| parameters.name.as_str()) })
                    }
                };
                if !through.contains(&shared) {
                    through.push(shared);
                }
            }
            lock.put("through", through);
            locks.push(lock.done());
        }
        names.sort_unstable();
        names.dedup();
        out.put("mutex", json!(names));
        if !locks.is_empty() {
            out.put("locks", locks);
        }
    }

    fn param(&self, component: &Component, locals: Option<&Vec<Param>>, param: &Param) -> Json {
        let mut out = Object::default();
        out.put("name", param.name.as_str());
        out.put("dir", json!(param.dir));
        let src = match param.source {
            ParamSource::Ids => "ids",
            ParamSource::Local(_) => "local",
            ParamSource::Port(_) => "port",
            ParamSource::Remote(_) => "remote",
            ParamSource::Opaque => "unknown",
        };
        out.put("src", src);
        let is_whole_ids = matches!(param.source, ParamSource::Ids) && param.path.is_empty();
        if is_whole_ids {
            out.put("type", "ids");
        } else if !matches!(param.source, ParamSource::Remote(_)) {
            out.put("type", self.type_name(param.ty));
        }
        if !param.path.is_empty() {
            out.put("member", self.member_text(param));
        }
        let of = match param.source {
            ParamSource::Local(Some(local)) => {
                locals.and_then(|all| Some(&all.get(local as usize)?.name))
            }
            ParamSource::Port(port) => component.ports.get(port as usize).map(|port| &port.name),
            ParamSource::Remote(remote) => component
                .remotes
                .get(remote as usize)
                .map(|remote| &remote.name),
            _ => None,
        };
        out.put_some("of", of.map(|name| name.as_str()));
        out.put_some(
            "init",
            param.init.as_ref().map(|init| self.initializer(init)),
        );
        self.place(&mut out, param.src);
        out.done()
    }

    /// The path inside a source as the reference compiler prints it: members of unions are accessed through
    /// `_u`, as in the C mapping.
    fn member_text(&self, param: &Param) -> String {
        let mut text = String::new();
        let mut ty = param.base;
        for element in &param.path {
            let last = resolve_aliases(self.spec, ty);
            match element {
                PathElement::Member(name) => {
                    if !text.is_empty() {
                        text.push('.');
                    }
                    if matches!(self.spec.ty(last).kind, TypeKind::Union { .. }) {
                        text.push_str("_u.");
                    }
                    text.push_str(name);
                    ty = member_named(self.spec, last, name).unwrap_or(last);
                }
                PathElement::Index(index) => {
                    text.push_str(&format!("[{index}]"));
                    ty = elements(self.spec, last).map_or(last, |(element, _)| element);
                }
            }
        }
        text
    }

    fn initializer(&self, init: &Initializer) -> Json {
        let mut out = Object::default();
        match &init.member {
            Some(PathElement::Member(name)) => out.put("member", name.as_str()),
            Some(PathElement::Index(index)) => out.put("member", *index),
            None => &mut out,
        };
        out.put_some("doc", init.doc.as_deref());
        match &init.value {
            InitValue::Void => out.put("kind", "void"),
            InitValue::Scalar(value) => out
                .put("kind", value.word())
                .put("value", self.value(value)),
            InitValue::Compound(parts) => {
                let parts: Vec<Json> = parts.iter().map(|part| self.initializer(part)).collect();
                out.put("kind", "compound").put("value", parts)
            }
        };
        out.done()
    }

    // Types

    fn types(&self) -> Json {
        let mut out = Object::default();
        let ids = (0..self.spec.types.len() as u32).map(TypeId);
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
                let names = enumerators
                    .iter()
                    .map(|enumerator| self.short_name(*enumerator));
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
        out.put("type", self.type_name(value_type(self.spec, id)));
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
        if let Some(name) = self.spec.full_name(id) {
            return name;
        }
        match &self.spec.ty(id).kind {
            TypeKind::String { bound: Some(bound) } => format!("string<{bound}>"),
            TypeKind::Array { .. } => {
                let (mut element, mut dimensions) = (id, String::new());
                while let (
                    None,
                    TypeKind::Array {
                        element: inner,
                        length,
                    },
                ) = (&self.spec.ty(element).name, &self.spec.ty(element).kind)
                {
                    dimensions.push_str(&format!("[{length}]"));
                    element = *inner;
                }
                self.type_name(element) + &dimensions
            }
            TypeKind::Sequence { element, bound } => match bound {
                Some(bound) => format!("sequence<{},{bound}>", self.type_name(*element)),
                None => format!("sequence<{}>", self.type_name(*element)),
            },
            TypeKind::Optional { element } => format!("optional<{}>", self.type_name(*element)),
            kind => kind.word().to_owned(),
        }
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

    fn origin(&self, out: &mut Object, interface: Option<u32>) {
        let interface =
            interface.and_then(|interface| self.spec.components.get(interface as usize));
        out.put_some(
            "imported-from",
            interface.map(|interface| interface.name.as_str()),
        );
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

/// The type of a member.
fn value_type(spec: &Spec, id: TypeId) -> TypeId {
    match spec.ty(id).kind {
        TypeKind::StructMember { ty } | TypeKind::UnionMember { ty, .. } => ty,
        _ => id,
    }
}

fn amount(quantity: &Quantity) -> Json {
    json!(u64::try_from(quantity.value.to_integer()).unwrap_or(u64::MAX))
}

fn states(states: &[State]) -> Json {
    let text = |state: &State| {
        if state.paused {
            format!("pause::{}", state.name)
        } else {
            state.name.to_string()
        }
    };
    states.iter().map(text).collect()
}

fn service_names(component: &Component, list: &ServiceList) -> Json {
    let name = |service: &crate::model::Service| service.name.to_string();
    if list.all {
        return component.services.iter().map(name).collect();
    }
    let named = list.services.iter();
    named
        .filter_map(|service| component.services.get(*service as usize))
        .map(name)
        .collect()
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
