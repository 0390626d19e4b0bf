//! Words for declarations and type objects.

use crate::{
    item_tree::Path,
    model::{Spec, TypeId, TypeKind},
};

pub(super) fn path_text(path: &Path) -> String {
    let mut text = String::new();
    for (index, segment) in path.segments.iter().enumerate() {
        if index > 0 || path.absolute {
            text.push_str("::");
        }
        text.push_str(&segment.text);
    }
    text
}

/// The kind of a type object, with an article: "a constant".
pub(super) fn describe(spec: &Spec, ty: TypeId) -> &'static str {
    match &spec.ty(ty).kind {
        TypeKind::Enum { .. } => "an enum",
        TypeKind::Enumerator { .. } => "an enumerator",
        TypeKind::Struct { .. } => "a struct",
        TypeKind::StructMember { .. } | TypeKind::UnionMember { .. } => "a member",
        TypeKind::Union { .. } => "a union",
        TypeKind::Exception { .. } => "an exception",
        TypeKind::Native => "a native type",
        TypeKind::Typedef { .. } => "a typedef",
        TypeKind::Const { .. } => "a constant",
        TypeKind::ForwardStruct { .. } => "a struct",
        TypeKind::ForwardUnion { .. } => "a union",
        TypeKind::Event | TypeKind::PauseEvent => "a state",
        TypeKind::Port { .. } => "a port",
        TypeKind::Remote { .. } => "a remote service",
        _ => "a type",
    }
}
