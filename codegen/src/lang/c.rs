//! C: declarators and the passing of values.

use dotgen_analysis::model::{TypeId, TypeKind};

use dotgen_analysis::release::Change;

use super::{LangError, LangResult, Mapper, PassingMode, length_of};

/// Returns true for kinds that C passes by pointer to constant.
fn is_aggregate(kind: &TypeKind) -> bool {
    matches!(
        kind,
        TypeKind::Sequence { .. }
            | TypeKind::Optional { .. }
            | TypeKind::Struct { .. }
            | TypeKind::Union { .. }
            | TypeKind::Exception { .. }
            | TypeKind::Port { .. }
            | TypeKind::Remote { .. }
            // Most types of other packages are structures.
            | TypeKind::Unknown
    )
}

/// Returns true for kinds that are already addresses in C: arrays and bounded strings.
fn is_array_like(kind: &TypeKind) -> bool {
    matches!(kind, TypeKind::Array { .. } | TypeKind::String { bound: Some(_) })
}

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
        TypeKind::Event => "genom_event".into(),
        TypeKind::Any => return Err(LangError::error("type any not supported yet")),
        TypeKind::Native => format!("{} *", m.type_cname(ty)?),
        TypeKind::Exception { .. } => format!("{}_detail", m.type_cname(ty)?),
        TypeKind::Const { .. }
        | TypeKind::Enum { .. }
        | TypeKind::Struct { .. }
        | TypeKind::Union { .. }
        | TypeKind::Typedef { .. }
        | TypeKind::Port { .. }
        | TypeKind::Remote { .. } => m.type_cname(ty)?,
        TypeKind::Enumerator { .. }
        | TypeKind::StructMember { .. }
        | TypeKind::UnionMember { .. }
        | TypeKind::ForwardStruct { .. }
        | TypeKind::ForwardUnion { .. } => declarator(m, m.inner_or_error(ty)?, "")?,
        TypeKind::String { bound: None } => "char *".into(),
        TypeKind::String { bound: Some(n) } => format!("char[{n}]"),
        TypeKind::Array { element, length } => {
            with_dimension(&declarator(m, *element, "")?, *length)
        }
        TypeKind::Sequence { .. } | TypeKind::Optional { .. } => structure_name(m, ty)?,
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

/// Puts an outer dimension before the dimensions of a declarator.
pub(super) fn with_dimension(declarator: &str, length: u64) -> String {
    match declarator.split_once('[') {
        Some((before, after)) => format!("{before}[{length}][{after}"),
        None => format!("{declarator}[{length}]"),
    }
}

/// Name of the structure for a sequence or optional: kinds, lengths and element names, outermost first.
fn structure_name(m: &Mapper<'_>, ty: TypeId) -> LangResult {
    let mut out = m.kind(ty).word().to_owned();
    let length = |out: &mut String, ty: TypeId| {
        if let Some(length) = length_of(m.kind(ty)) {
            *out += &length.to_string();
        }
    };
    length(&mut out, ty);
    let mut ty = ty;
    while let TypeKind::Sequence { element, .. } | TypeKind::Optional { element } = m.kind(ty) {
        ty = *element;
        let name = m.spec.full_name(ty);
        let name = name.as_deref().unwrap_or(m.kind(ty).word());
        out.push('_');
        out += &m.cname(name)?;
        length(&mut out, ty);
    }
    Ok(out)
}

/// Puts a variable into an abstract declarator.
fn declare(declarator: &str, var: &str) -> String {
    if var.is_empty() {
        return declarator.to_owned();
    }
    let bracket = declarator.find('[').unwrap_or(declarator.len());
    let (before, after) = declarator.split_at(bracket);
    let space = if before.ends_with('*') { "" } else { " " };
    if !after.is_empty() && var.starts_with('*') {
        format!("{before}{space}({var}){after}")
    } else {
        format!("{before}{space}{var}{after}")
    }
}

pub(super) fn address(m: &Mapper<'_>, ty: TypeId, var: &str) -> String {
    match m.final_kind(ty) {
        TypeKind::String { .. } | TypeKind::Array { .. } | TypeKind::Native => var.to_owned(),
        _ => format!("&({var})"),
    }
}

pub(super) fn dereference(m: &Mapper<'_>, ty: TypeId, passing: PassingMode, var: &str) -> String {
    let kind = m.final_kind(ty);
    let pointer = match passing {
        PassingMode::Value => is_aggregate(kind),
        PassingMode::Reference => !is_array_like(kind),
    };
    if pointer { format!("*({var})") } else { var.to_owned() }
}

pub(super) fn argument(m: &Mapper<'_>, ty: TypeId, passing: PassingMode, var: &str) -> LangResult {
    let kind = m.final_kind(ty);
    match passing {
        PassingMode::Value if is_aggregate(kind) => {
            Ok(format!("const {}", declarator(m, ty, &format!("*{var}"))?))
        }
        PassingMode::Value => match kind {
            TypeKind::String { .. } | TypeKind::Array { .. } | TypeKind::Native => {
                Ok(format!("const {}", declarator(m, ty, var)?))
            }
            _ => declarator(m, ty, var),
        },
        PassingMode::Reference if is_array_like(kind) => declarator(m, ty, var),
        PassingMode::Reference => declarator(m, ty, &format!("*{var}")),
    }
}

pub(super) fn return_value(
    m: &Mapper<'_>,
    ty: TypeId,
    passing: PassingMode,
    var: &str,
) -> LangResult {
    if m.has(Change::ReturnValueVariables) {
        let constant = match passing {
            PassingMode::Value => "const ",
            PassingMode::Reference => "",
        };
        return match m.final_kind(ty) {
            TypeKind::String { bound: Some(_) } => Ok(format!("{constant}char *{var}")),
            TypeKind::Array { element, .. } => {
                let pointer = declarator(m, *element, &format!("*{var}"))?;
                Ok(format!("{constant}{pointer}"))
            }
            _ => argument(m, ty, passing, var),
        };
    }
    match (passing, m.final_kind(ty)) {
        (PassingMode::Reference, TypeKind::String { bound: Some(_) }) => Ok("char *".into()),
        (PassingMode::Reference, TypeKind::Array { element, .. }) => declarator(m, *element, "*"),
        _ => argument(m, ty, passing, ""),
    }
}

pub(super) fn pass(m: &Mapper<'_>, ty: TypeId, passing: PassingMode, var: &str) -> LangResult {
    let kind = m.final_kind(ty);
    Ok(match (passing, kind) {
        // A pointer to arrays converts to a pointer to constant arrays with a cast only
        // (http://c-faq.com/ansi/constmismatch.html).
        (PassingMode::Value, TypeKind::Array { element, .. })
            if matches!(
                m.final_kind(*element),
                TypeKind::Array { .. } | TypeKind::String { .. }
            ) =>
        {
            format!("((const {}){var})", declarator(m, *element, "(*)")?)
        }
        (PassingMode::Value, kind) if is_aggregate(kind) => format!("&({var})"),
        (PassingMode::Value, _) => var.to_owned(),
        (PassingMode::Reference, kind) if is_array_like(kind) => var.to_owned(),
        (PassingMode::Reference, _) => format!("&({var})"),
    })
}
