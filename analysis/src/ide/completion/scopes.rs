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
    let mut chain = Vec::new();
    let mut next = first.and_then(|definition| definition.container);
    while let Some(id) = next {
        let definition = elaborated.definition(id);
        if opens_scope(definition.kind)
            && view.place(definition.src).is_none_or(|(file, _)| file != view.file)
        {
            chain.insert(0, id);
        }
        next = definition.container;
    }
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
    let mut path = vec![definition.name.clone()];
    let mut next = definition.container;
    while let Some(id) = next {
        let container = elaborated.definition(id);
        // Enumerators are in the scope of their enum.
        if container.kind != DefKind::Enum {
            path.insert(0, container.name.clone());
        }
        next = container.container;
    }
    path
}
