//! The types an object needs, and digests of an object's interface.
//!
//! Both walk the model; a filter given by the template may leave objects out.

use dotgen_analysis::model::{
    ComponentId, ComponentKind, ParamDir, ServiceId, Spec, TypeId, TypeKind,
};
use dotgen_analysis::release::Change;
use md5::{Digest, Md5};
use rustc_hash::FxHashMap;

use super::Failure;
use super::model::{Model, port_kind};
use super::object::{Lookup, Object, ParamRef};
use super::throws::{remote_throws, service_throws, task_throws};
use crate::lang::length_of;

/// Returns true for objects to include.
pub(crate) type Filter<'f> = dyn FnMut(&Object) -> Result<bool, Failure> + 'f;

/// The requested types of a component.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Visibility {
    Public,
    Extern,
    Private,
}

/// Maximum nesting; a deeper type contains itself.
const DEPTH: usize = 200;

/// Types keyed by mangled name: a key stays at the place of its first type and keeps the last.
#[derive(Default)]
struct Types {
    order: Vec<TypeId>,
    places: FxHashMap<String, usize>,
}

impl Types {
    fn set(&mut self, key: String, ty: TypeId) {
        if let Some(place) = self.places.get(&key) {
            self.order[*place] = ty;
        } else {
            self.places.insert(key, self.order.len());
            self.order.push(ty);
        }
    }
}

pub(crate) fn types_of_type(
    model: &Model<'_>,
    ty: TypeId,
    filter: &mut Filter<'_>,
) -> Result<Vec<TypeId>, Failure> {
    let mut types = Types::default();
    add_type(model, ty, filter, &mut types, DEPTH)?;
    Ok(types.order)
}

pub(crate) fn types_of_component(
    model: &Model<'_>,
    index: ComponentId,
    visibility: Visibility,
    filter: &mut Filter<'_>,
) -> Result<Vec<TypeId>, Failure> {
    let mut types = Types::default();
    if !filter(&Object::Component(index))? {
        return Ok(types.order);
    }
    let component = model.spec.component(index);
    let private = visibility == Visibility::Private;
    let mut wanted = Vec::new();
    for port in &component.ports {
        wanted.push(port.data);
        if private {
            wanted.push(port.ty);
        }
    }
    for (at, service) in component.services.iter_enumerated() {
        let local = |dir| dir == dotgen_analysis::model::ParamDir::Local;
        let params = service.params.iter();
        wanted.extend(params.filter(|param| private || !local(param.dir)).map(|param| param.ty));
        wanted.extend(service_throws(component, at));
    }
    if visibility != Visibility::Public {
        for remote in &component.remotes {
            wanted.extend(remote.params.iter().map(|param| param.ty));
            wanted.extend(remote_throws(component, remote));
        }
    }
    if private {
        for task in &component.tasks {
            wanted.extend(task_throws(component, task));
        }
        wanted.extend(component.ids);
    }
    for ty in wanted {
        add_type(model, ty, filter, &mut types, DEPTH)?;
    }
    Ok(types.order)
}

fn too_deep() -> Failure {
    Failure::Error("too many nested evaluations (infinite loop?)".into())
}

fn add_type(
    model: &Model<'_>,
    ty: TypeId,
    filter: &mut Filter<'_>,
    types: &mut Types,
    depth: usize,
) -> Result<(), Failure> {
    let depth = depth.checked_sub(1).ok_or_else(too_deep)?;
    if !filter(&Object::Type(ty))? {
        return Ok(());
    }
    let mut listed = true;
    match model.spec.ty(ty).kind {
        TypeKind::Array { element: inner, .. }
        | TypeKind::Sequence { element: inner, .. }
        | TypeKind::Optional { element: inner }
        | TypeKind::Typedef { ty: inner } => add_type(model, inner, filter, types, depth)?,
        TypeKind::StructMember { ty: inner } | TypeKind::UnionMember { ty: inner, .. } => {
            add_type(model, inner, filter, types, depth)?;
            listed = false;
        }
        TypeKind::Struct { ref members } | TypeKind::Exception { ref members } => {
            for member in members {
                add_type(model, *member, filter, types, depth)?;
            }
        }
        TypeKind::Union { switch, ref members } => {
            add_type(model, switch, filter, types, depth)?;
            for member in members {
                add_type(model, *member, filter, types, depth)?;
            }
        }
        _ => {}
    }
    if listed {
        types.set(model.mapper().mangle(ty)?, ty);
    }
    Ok(())
}

/// The digest of an object; for classes without one, the digest of empty input.
///
/// # Errors
/// Fails if `filter` fails, or rejects an object outside of a list.
pub(crate) fn digest(
    model: &Model<'_>,
    object: &Object,
    filter: &mut Filter<'_>,
) -> Result<String, Failure> {
    let mut digest = Chunks(Md5::new());
    match *object {
        Object::Type(ty) => digest.type_(model.spec, ty, filter, DEPTH)?,
        Object::Service(component, service) => {
            digest.service(model.spec, component, service, filter)?;
        }
        Object::Remote(component, remote) => {
            wanted(filter, object)?;
            let declaration = model.spec.remote(component, remote);
            let params = (0..declaration.params.len() as u32)
                .filter(|at| declaration.params[*at as usize].dir != ParamDir::Local)
                .map(|at| ParamRef::Remote(remote, at));
            digest.params(model.spec, component, params, filter)?;
            for ty in remote_throws(model.spec.component(component), declaration) {
                digest.exception(model.spec, ty, filter)?;
            }
        }
        Object::Component(index)
            if model.spec.component(index).kind == ComponentKind::Component =>
        {
            wanted(filter, object)?;
            digest.component(model.spec, index, filter)?;
        }
        _ => {}
    }
    Ok(digest.finish())
}

/// A rejected object outside of a list ends the digest, with Tcl's message.
fn wanted(filter: &mut Filter<'_>, object: &Object) -> Result<(), Failure> {
    if filter(object)? {
        Ok(())
    } else {
        Err(Failure::Error("invoked \"continue\" outside of a loop".into()))
    }
}

struct Chunks(Md5);

impl Chunks {
    fn push(&mut self, chunk: &str) {
        self.0.update(chunk.as_bytes());
        self.0.update(b"|");
    }

    /// Hexadecimal without leading zeros in each byte, as GenoM3 writes it.
    fn finish(self) -> String {
        let bytes = self.0.finalize();
        bytes.iter().map(|byte| format!("{byte:x}")).collect()
    }

    fn component(
        &mut self,
        spec: &Spec,
        index: ComponentId,
        filter: &mut Filter<'_>,
    ) -> Result<(), Failure> {
        let component = spec.component(index);
        for (at, port) in component.ports.iter_enumerated() {
            if !filter(&Object::Port(index, at))? {
                continue;
            }
            self.push("port");
            self.push(port_kind(port));
            self.push(&port.name);
            self.type_(spec, port.data, filter, DEPTH)?;
        }
        for (at, service) in component.services.iter_enumerated() {
            if !filter(&Object::Service(index, at))? {
                continue;
            }
            self.push(service.kind.word());
            self.push(&service.name);
            self.service(spec, index, at, filter)?;
        }
        Ok(())
    }

    fn service(
        &mut self,
        spec: &Spec,
        component: ComponentId,
        service: ServiceId,
        filter: &mut Filter<'_>,
    ) -> Result<(), Failure> {
        wanted(filter, &Object::Service(component, service))?;
        let all = &spec.service(component, service).params;
        let without_locals = spec.release.has(Change::DigestsOfExceptions);
        let params = (0..all.len() as u32)
            .filter(|param| !without_locals || all[*param as usize].dir != ParamDir::Local)
            .map(|at| ParamRef::Service(service, at));
        self.params(spec, component, params, filter)?;
        for ty in service_throws(spec.component(component), service) {
            self.exception(spec, ty, filter)?;
        }
        Ok(())
    }

    fn exception(
        &mut self,
        spec: &Spec,
        ty: TypeId,
        filter: &mut Filter<'_>,
    ) -> Result<(), Failure> {
        if spec.release.has(Change::DigestsOfExceptions) {
            self.push(&spec.full_name(ty).unwrap_or_default());
        }
        self.type_(spec, ty, filter, DEPTH)
    }

    fn params(
        &mut self,
        spec: &Spec,
        component: ComponentId,
        params: impl Iterator<Item = ParamRef>,
        filter: &mut Filter<'_>,
    ) -> Result<(), Failure> {
        for at in params {
            if !filter(&Object::Param(component, at))? {
                continue;
            }
            let param = spec.param(component, at);
            self.push(param.dir.word());
            self.type_(spec, param.ty, filter, DEPTH)?;
        }
        Ok(())
    }

    fn type_(
        &mut self,
        spec: &Spec,
        ty: TypeId,
        filter: &mut Filter<'_>,
        depth: usize,
    ) -> Result<(), Failure> {
        let depth = depth.checked_sub(1).ok_or_else(too_deep)?;
        wanted(filter, &Object::Type(ty))?;
        let kind = &spec.ty(ty).kind;
        match kind {
            TypeKind::String { .. } => {
                self.push("string");
                if let Some(length) = length_of(kind) {
                    self.push(&length.to_string());
                }
            }
            TypeKind::Const { ty: inner, .. }
            | TypeKind::Typedef { ty: inner }
            | TypeKind::StructMember { ty: inner }
            | TypeKind::ForwardStruct { definition: Some(inner) }
            | TypeKind::ForwardUnion { definition: Some(inner) } => {
                self.type_(spec, *inner, filter, depth)?;
            }
            TypeKind::Array { element, .. }
            | TypeKind::Sequence { element, .. }
            | TypeKind::Optional { element } => {
                self.push(kind.word());
                if let Some(length) = length_of(kind) {
                    self.push(&length.to_string());
                }
                self.type_(spec, *element, filter, depth)?;
            }
            TypeKind::Enum { enumerators: members }
            | TypeKind::Struct { members }
            | TypeKind::Union { members, .. }
            | TypeKind::Exception { members } => {
                for member in members {
                    self.push(spec.ty(*member).name.as_deref().unwrap_or_default());
                    self.type_(spec, *member, filter, depth)?;
                }
            }
            other => self.push(other.word()),
        }
        Ok(())
    }
}
