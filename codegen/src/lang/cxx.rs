//! C++: declarators and the passing of values.

use dotgen_analysis::model::{TypeId, TypeKind};

use super::{LangError, LangResult, Mapper, PassingMode, c::with_dimension};

pub(super) fn declarator(m: &Mapper<'_>, ty: TypeId, var: &str) -> LangResult {
    let abstract_declarator = match m.kind(ty) {
        TypeKind::Boolean => "bool".into(),
        TypeKind::UnsignedShort => "uint16_t".into(),
        TypeKind::Short => "int16_t".into(),
        TypeKind::UnsignedLong => "uint32_t".into(),
        TypeKind::UnsignedLongLong => "uint64_t".into(),
        TypeKind::Long => "int32_t".into(),
        TypeKind::LongLong => "int64_t".into(),
        TypeKind::Float => "float".into(),
        TypeKind::Double => "double".into(),
        TypeKind::Char => "int8_t".into(),
        TypeKind::Octet => "uint8_t".into(),
        TypeKind::Event => "genom::event".into(),
        TypeKind::Any => return Err(LangError::error("type any not supported yet")),
        TypeKind::Native => format!("{} *", m.type_cname(ty)?),
        TypeKind::Const { .. }
        | TypeKind::Enum { .. }
        | TypeKind::Struct { .. }
        | TypeKind::Union { .. }
        | TypeKind::Typedef { .. }
        | TypeKind::Exception { .. }
        | TypeKind::Port { .. }
        | TypeKind::Remote { .. } => m.type_cname(ty)?,
        TypeKind::Enumerator { .. }
        | TypeKind::StructMember { .. }
        | TypeKind::UnionMember { .. }
        | TypeKind::ForwardStruct { .. }
        | TypeKind::ForwardUnion { .. } => declarator(m, m.inner_or_error(ty)?, "")?,
        TypeKind::String { bound: None } => "std::string".into(),
        TypeKind::String { bound: Some(n) } => format!("char[{n}]"),
        TypeKind::Array { element, length } => {
            with_dimension(&declarator(m, *element, "")?, *length)
        }
        TypeKind::Sequence { element, bound: None } => {
            format!("std::vector< {} >", declarator(m, *element, "")?)
        }
        TypeKind::Sequence { element, bound: Some(n) } => {
            format!("genom::bounded_sequence< {},{n} >", declarator(m, *element, "")?)
        }
        TypeKind::Optional { element } => {
            format!("genom::optional< {} >", declarator(m, *element, "")?)
        }
        TypeKind::Unknown => m.opaque_name(ty)?,
        kind @ TypeKind::PauseEvent => {
            return Err(LangError::fatal(format!(
                "internal error: unhandled type '{}'",
                kind.word()
            )));
        }
    };
    Ok(declare(&abstract_declarator, var))
}

fn declare(declarator: &str, var: &str) -> String {
    if var.is_empty() {
        return declarator.to_owned();
    }
    match declarator.find('[') {
        Some(bracket) => {
            let (before, after) = declarator.split_at(bracket);
            format!("{before} {var}{after}")
        }
        None if declarator.ends_with('*') => format!("{declarator}{var}"),
        None => format!("{declarator} {var}"),
    }
}

pub(super) fn address(m: &Mapper<'_>, ty: TypeId, var: &str) -> String {
    match m.final_kind(ty) {
        TypeKind::String { bound: Some(_) } | TypeKind::Array { .. } | TypeKind::Native => {
            var.to_owned()
        }
        _ => format!("&({var})"),
    }
}

pub(super) fn argument(m: &Mapper<'_>, ty: TypeId, passing: PassingMode, var: &str) -> LangResult {
    let by_reference = || declarator(m, ty, &format!("&{var}"));
    match (passing, m.final_kind(ty)) {
        (
            PassingMode::Value,
            TypeKind::Sequence { .. }
            | TypeKind::Optional { .. }
            | TypeKind::Struct { .. }
            | TypeKind::Union { .. }
            | TypeKind::Exception { .. }
            | TypeKind::String { bound: None }
            | TypeKind::Unknown,
        ) => Ok(format!("const {}", by_reference()?)),
        (
            PassingMode::Value,
            TypeKind::String { bound: Some(_) } | TypeKind::Array { .. } | TypeKind::Native,
        ) => Ok(format!("const {}", declarator(m, ty, var)?)),
        (PassingMode::Value, TypeKind::Port { .. } | TypeKind::Remote { .. }) => by_reference(),
        (PassingMode::Value, _) => declarator(m, ty, var),
        (PassingMode::Reference, TypeKind::String { bound: Some(_) } | TypeKind::Array { .. }) => {
            declarator(m, ty, var)
        }
        (PassingMode::Reference, _) => by_reference(),
    }
}
