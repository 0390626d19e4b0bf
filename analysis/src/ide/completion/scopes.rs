//! Scopes: the nesting of declarations.

use smol_str::SmolStr;

use crate::{
    elab::{DefId, DefKind, Definition, Elaborated},
    ide::FileView,
};

/// The modules and components in which the file is included, outermost first.
pub(super) fn outer_scope(view: &FileView<'_>, elaborated: &Elaborated) -> Vec<DefId> {
    if view.key.fragment(view.db) == dotgen_syntax::Fragment::Specification {
        return Vec::new();
    }
    let here = |definition: &&Definition| {
        view.place(definition.src).is_some_and(|(file, _)| file == view.file)
    };
    let first = elaborated.definitions.iter().find(here);
    let around = first.into_iter().flat_map(|definition| elaborated.containers(definition));
    let outside = around.filter(|definition| {
        opens_scope(definition.kind)
            && view.place(definition.src).is_none_or(|(file, _)| file != view.file)
    });
    let mut chain: Vec<DefId> = outside.map(|definition| definition.id).collect();
    chain.reverse();
    chain
}

/// Returns true if a definition is found by its path.
pub(super) fn in_scopes(kind: DefKind) -> bool {
    use DefKind::*;
    matches!(
        kind,
        Module
            | Component
            | Interface
            | Typedef
            | Struct
            | Union
            | Enum
            | Enumerator
            | Exception
            | Native
            | Const
            | Ids
    )
}

/// Returns true if names are declared inside of a definition.
pub(super) fn opens_scope(kind: DefKind) -> bool {
    use DefKind::*;
    matches!(kind, Module | Component | Interface | Struct | Union | Ids)
}

/// The path by which a definition is found from the global scope.
pub(super) fn full_path(elaborated: &Elaborated, definition: &Definition) -> Vec<SmolStr> {
    // Enumerators are in the scope of their enum.
    let around = elaborated.containers(definition).filter(|around| around.kind != DefKind::Enum);
    let mut path: Vec<SmolStr> =
        std::iter::once(definition).chain(around).map(|part| part.name.clone()).collect();
    path.reverse();
    path
}
