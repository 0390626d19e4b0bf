//! Words for declarations and type objects.

use crate::{
    finding::names::Described,
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

/// The kind of a type object.
pub(super) fn describe(spec: &Spec, ty: TypeId) -> Described {
    let noun = match &spec.ty(ty).kind {
        TypeKind::Enum { .. } => "enum",
        TypeKind::Enumerator { .. } => "enumerator",
        TypeKind::Struct { .. } => "struct",
        TypeKind::StructMember { .. } | TypeKind::UnionMember { .. } => "member",
        TypeKind::Union { .. } => "union",
        TypeKind::Exception { .. } => "exception",
        TypeKind::Native => "native type",
        TypeKind::Typedef { .. } => "typedef",
        TypeKind::Const { .. } => "constant",
        TypeKind::ForwardStruct { .. } => "struct",
        TypeKind::ForwardUnion { .. } => "union",
        TypeKind::Event | TypeKind::PauseEvent => "state",
        TypeKind::Port { .. } => "port",
        TypeKind::Remote { .. } => "remote service",
        _ => "type",
    };
    Described { noun }
}
