//! Visiting every type id that a part of the model holds.

use super::{
    Codel, Component, InitValue, Initializer, Label, Param, Quantity, Spec, State, Type, TypeId,
    TypeKind, Value,
};

/// Things that refer to types.
pub(crate) trait TypeIds {
    /// Calls `f` with every type id, which `f` may change.
    fn for_each_type_id(&mut self, f: &mut dyn FnMut(&mut TypeId));
}

impl<T: TypeIds> TypeIds for [T] {
    fn for_each_type_id(&mut self, f: &mut dyn FnMut(&mut TypeId)) {
        for element in self {
            element.for_each_type_id(f);
        }
    }
}

impl<T: TypeIds> TypeIds for Option<T> {
    fn for_each_type_id(&mut self, f: &mut dyn FnMut(&mut TypeId)) {
        if let Some(present) = self {
            present.for_each_type_id(f);
        }
    }
}

impl TypeIds for TypeId {
    fn for_each_type_id(&mut self, f: &mut dyn FnMut(&mut TypeId)) {
        f(self);
    }
}

impl TypeIds for Spec {
    fn for_each_type_id(&mut self, f: &mut dyn FnMut(&mut TypeId)) {
        self.types.raw.for_each_type_id(f);
        self.components.raw.for_each_type_id(f);
        self.open.for_each_type_id(f);
    }
}

impl TypeIds for Type {
    fn for_each_type_id(&mut self, f: &mut dyn FnMut(&mut TypeId)) {
        self.parent.for_each_type_id(f);
        match &mut self.kind {
            TypeKind::Array { element: ty, .. }
            | TypeKind::Sequence { element: ty, .. }
            | TypeKind::Optional { element: ty }
            | TypeKind::Enumerator { enumeration: ty, .. }
            | TypeKind::StructMember { ty }
            | TypeKind::Typedef { ty } => f(ty),
            TypeKind::Enum { enumerators: types }
            | TypeKind::Struct { members: types }
            | TypeKind::Exception { members: types } => types.for_each_type_id(f),
            TypeKind::Union { switch, members } => {
                f(switch);
                members.for_each_type_id(f);
            }
            TypeKind::UnionMember { ty, labels } => {
                f(ty);
                for label in labels {
                    if let Label::Case(value) = label {
                        value.for_each_type_id(f);
                    }
                }
            }
            TypeKind::Const { ty, value } => {
                f(ty);
                value.for_each_type_id(f);
            }
            TypeKind::ForwardStruct { definition } | TypeKind::ForwardUnion { definition } => {
                definition.for_each_type_id(f);
            }
            _ => {}
        }
    }
}

impl TypeIds for Value {
    fn for_each_type_id(&mut self, f: &mut dyn FnMut(&mut TypeId)) {
        if let Self::Enum(ty) = self {
            f(ty);
        }
    }
}

impl TypeIds for Quantity {
    fn for_each_type_id(&mut self, f: &mut dyn FnMut(&mut TypeId)) {
        f(&mut self.ty);
    }
}

impl TypeIds for Component {
    fn for_each_type_id(&mut self, f: &mut dyn FnMut(&mut TypeId)) {
        self.clock_rate.for_each_type_id(f);
        self.stack.for_each_type_id(f);
        self.ids.for_each_type_id(f);
        self.throws.for_each_type_id(f);
        for task in &mut self.tasks {
            for quantity in [&mut task.period, &mut task.delay, &mut task.priority, &mut task.stack]
            {
                quantity.for_each_type_id(f);
            }
            task.throws.for_each_type_id(f);
            task.codels.raw.for_each_type_id(f);
        }
        for port in &mut self.ports {
            f(&mut port.data);
            f(&mut port.ty);
        }
        for service in &mut self.services {
            service.params.for_each_type_id(f);
            service.codels.raw.for_each_type_id(f);
            service.throws.for_each_type_id(f);
        }
        for remote in &mut self.remotes {
            remote.params.for_each_type_id(f);
            f(&mut remote.ty);
            remote.throws.for_each_type_id(f);
        }
    }
}

impl TypeIds for Codel {
    fn for_each_type_id(&mut self, f: &mut dyn FnMut(&mut TypeId)) {
        self.params.for_each_type_id(f);
        self.triggers.for_each_type_id(f);
        self.yields.for_each_type_id(f);
        self.wcet.for_each_type_id(f);
    }
}

impl TypeIds for State {
    fn for_each_type_id(&mut self, f: &mut dyn FnMut(&mut TypeId)) {
        f(&mut self.event);
    }
}

impl TypeIds for Param {
    fn for_each_type_id(&mut self, f: &mut dyn FnMut(&mut TypeId)) {
        f(&mut self.base);
        f(&mut self.ty);
        self.init.for_each_type_id(f);
    }
}

impl TypeIds for Initializer {
    fn for_each_type_id(&mut self, f: &mut dyn FnMut(&mut TypeId)) {
        f(&mut self.ty);
        match &mut self.value {
            InitValue::Void => {}
            InitValue::Scalar(value) => value.for_each_type_id(f),
            InitValue::Compound(parts) => parts.for_each_type_id(f),
        }
    }
}
