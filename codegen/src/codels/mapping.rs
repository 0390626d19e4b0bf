//! The mapped types of a component as one text, for readers of declarations.

use super::expected::Expected;
use super::source::Grammar;
use crate::lang::{LangError, Language, MapObject};

/// All mapped types of the specification, without text that only a compiler needs.
pub(crate) fn types(expected: &Expected<'_>) -> Result<String, LangError> {
    let all = expected.spec.types.keys().map(MapObject::Type);
    let out = expected.mapper().mapping(&all.collect::<Vec<_>>(), false)?;
    // The grammars would take this macro for the declared name.
    let blank = " ".repeat("genom_extern_weak".len());
    Ok(out.replace("genom_extern_weak", &blank))
}

/// The grammar that a mapping is read with.
pub(crate) fn grammar(expected: &Expected<'_>) -> Grammar {
    match expected.language {
        Language::Cxx => Grammar::Cxx,
        _ => Grammar::C,
    }
}
