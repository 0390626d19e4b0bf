//! Codels of the document: their parameters, states and exclusions.

use serde_json::{Value as Json, json};
use smol_str::SmolStr;

use super::{Object, Writer, states};
use crate::{
    elab::types::{elements, member_named, resolve_aliases},
    model::{
        Codel, CodelKind, CodelRef, Component, ComponentKind, InitValue, Initializer, Name, Owner,
        Param, ParamSource, PathElement, TypeKind,
        mutex::{Excluded, Shared, exclusions, path_text},
    },
};

impl Writer<'_> {
    pub(super) fn codels(
        &self,
        component: &Component,
        owner: Owner,
        kind: Option<CodelKind>,
    ) -> Json {
        let codels = component.codels_of(owner).iter_enumerated();
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
            Owner::Service(service) => component.services.get(service),
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
        let index = self.spec.components.position(|other| other.name == component.name);
        if let (Some(prototypes), Some(index)) = (self.prototypes, index) {
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
                        Owner::Task(task) => lock.put("task", component.tasks[task].name.as_str()),
                        Owner::Service(service) => {
                            lock.put("service", component.services[service].name.as_str())
                        }
                    };
                    name
                }
                Excluded::Service(other) => {
                    let name = &component.services[other].name;
                    lock.put("attribute", name.as_str());
                    name
                }
            };
            names.push(name);
            let mut through: Vec<Json> = Vec::new();
            for parameters in &exclusion.through {
                let shared = match &parameters.shared {
                    Shared::Ids(path) => json!({ "ids": path_text(path) }),
                    Shared::Port(port) => {
                        let port = component.ports.get(*port);
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

    pub(super) fn param(
        &self,
        component: &Component,
        locals: Option<&Vec<Param>>,
        param: &Param,
    ) -> Json {
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
            ParamSource::Port(port) => component.ports.get(port).map(|port| &port.name),
            ParamSource::Remote(remote) => component.remotes.get(remote).map(|remote| &remote.name),
            _ => None,
        };
        out.put_some("of", of.map(SmolStr::as_str));
        out.put_some("init", param.init.as_ref().map(|init| self.initializer(init)));
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
            InitValue::Scalar(value) => {
                out.put("kind", value.word()).put("value", self.value(value))
            }
            InitValue::Compound(parts) => {
                let parts: Vec<Json> = parts.iter().map(|part| self.initializer(part)).collect();
                out.put("kind", "compound").put("value", parts)
            }
        };
        out.done()
    }
}
