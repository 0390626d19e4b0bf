//! Sizes of types.

use rustc_hash::FxHashMap;

use super::{Spec, TypeId, TypeKind};

/// The maximum size of a value of a type in bytes, without padding; `None` if there is no limit.
///
/// Enums and lengths count 4 bytes, presence flags 1, strings one more than their bound.
pub(crate) fn max_size(spec: &Spec, ty: TypeId) -> Option<u64> {
    measure(spec, ty, &mut FxHashMap::default())
}

/// Sizes of composite types in bytes; also `None` during their computation.
type Known = FxHashMap<TypeId, Option<u64>>;

fn measure(spec: &Spec, ty: TypeId, known: &mut Known) -> Option<u64> {
    let ty = spec.resolve_alias(ty);
    let mut members = |spec: &Spec, members: &[TypeId], add: fn(u64, u64) -> u64| {
        if let Some(size) = known.get(&ty) {
            return *size;
        }
        known.insert(ty, None);
        let mut sizes = members.iter().map(|member| measure(spec, *member, known));
        let size = sizes.try_fold(0u64, |total, size| Some(add(total, size?)));
        known.insert(ty, size);
        size
    };
    Some(match &spec.ty(ty).kind {
        TypeKind::Boolean | TypeKind::Octet | TypeKind::Char => 1,
        TypeKind::Short | TypeKind::UnsignedShort => 2,
        TypeKind::Long | TypeKind::UnsignedLong | TypeKind::Float | TypeKind::Enum { .. } => 4,
        TypeKind::LongLong | TypeKind::UnsignedLongLong | TypeKind::Double => 8,
        TypeKind::String { bound } => (*bound)?.saturating_add(1),
        TypeKind::Array { element, length } => {
            measure(spec, *element, known)?.saturating_mul(*length)
        }
        TypeKind::Sequence { element, bound } => {
            let bound = (*bound)?;
            measure(spec, *element, known)?.saturating_mul(bound).saturating_add(4)
        }
        TypeKind::Optional { element } => measure(spec, *element, known)?.saturating_add(1),
        TypeKind::Struct { members: them } | TypeKind::Exception { members: them } => {
            members(spec, them, u64::saturating_add)?
        }
        TypeKind::Union { switch, members: them } => {
            let largest = members(spec, them, u64::max)?;
            measure(spec, *switch, known)?.saturating_add(largest)
        }
        _ => return None,
    })
}
