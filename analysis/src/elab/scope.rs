//! The tree of scopes and the lookup rules (language reference, section 5).

use rustc_hash::FxHashMap;
use typed_index_collections::{TiVec, ti_vec};

use super::DefId;
use crate::model::{Name, Scope, ScopeKind, TypeId};

crate::model::ids::ids! {
    /// Index into [`Scopes`].
    pub(super) ScopeId
}

pub(super) const GLOBAL: ScopeId = ScopeId(0);

#[derive(Debug)]
pub(super) struct ScopeData {
    /// Empty for the global scope.
    pub(super) name: Name,
    pub(super) kind: ScopeKind,
    pub(super) parent: Option<ScopeId>,
    /// The declarations in it: types, constants, members, states, ports, remotes.
    pub(super) names: FxHashMap<Name, TypeId>,
    /// The scopes directly inside.
    pub(super) children: FxHashMap<Name, ScopeId>,
    /// The module, component or type that it belongs to.
    pub(super) def: Option<DefId>,
    /// The names from the outermost scope down to this one, as types hold them.
    pub(super) path: Vec<Scope>,
}

#[derive(Debug)]
pub(super) struct Scopes {
    all: TiVec<ScopeId, ScopeData>,
}

/// The reason why a name cannot be declared in a scope.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Clash {
    /// The name is taken.
    Name(TypeId),
    /// A module or component of this scope has the name.
    Scope(ScopeId),
    /// The scope itself has the name.
    Enclosing,
}

impl Scopes {
    pub(super) fn new() -> Self {
        let global = ScopeData {
            name: Name::default(),
            kind: ScopeKind::Module,
            parent: None,
            names: FxHashMap::default(),
            children: FxHashMap::default(),
            def: None,
            path: Vec::new(),
        };
        Self { all: ti_vec![global] }
    }

    pub(super) fn get(&self, id: ScopeId) -> &ScopeData {
        &self.all[id]
    }

    pub(super) fn get_mut(&mut self, id: ScopeId) -> &mut ScopeData {
        &mut self.all[id]
    }

    /// Creates a scope inside `parent`, and adds it there unless it is `detached` (because its name was
    /// refused).
    pub(super) fn open(
        &mut self,
        parent: ScopeId,
        name: &Name,
        kind: ScopeKind,
        def: Option<DefId>,
        detached: bool,
    ) -> ScopeId {
        let id = self.all.next_key();
        let mut path = self.get(parent).path.clone();
        path.push(Scope { kind, name: name.clone() });
        self.all.push(ScopeData {
            name: name.clone(),
            kind,
            parent: Some(parent),
            names: FxHashMap::default(),
            children: FxHashMap::default(),
            def,
            path,
        });
        if !detached {
            self.get_mut(parent).children.insert(name.clone(), id);
        }
        id
    }

    /// The conflict with declaring `name` in `scope`, if any. `opens_scope`: the declaration has a scope of
    /// its own (a module, struct, union or exception).
    pub(super) fn clash(&self, scope: ScopeId, name: &Name, opens_scope: bool) -> Option<Clash> {
        let data = self.get(scope);
        if let Some(&previous) = data.names.get(name) {
            return Some(Clash::Name(previous));
        }
        if let Some(&child) = data.children.get(name) {
            return Some(Clash::Scope(child));
        }
        let shares_name = data.parent.is_some() && data.name == *name;
        (shares_name && (opens_scope || data.kind == ScopeKind::Module)).then_some(Clash::Enclosing)
    }

    /// The type object that the complete path names, seen from `from`: the first enclosing scope that
    /// contains the whole path wins, unless the type object there is not `wanted`.
    pub(super) fn lookup(
        &self,
        from: ScopeId,
        absolute: bool,
        path: &[&Name],
        wanted: impl Fn(TypeId) -> bool,
    ) -> Option<(TypeId, Vec<ScopeId>)> {
        let mut scope = Some(if absolute { GLOBAL } else { from });
        while let Some(id) = scope {
            if let Some(found) = self.lookup_in(id, path)
                && wanted(found.0)
            {
                return Some(found);
            }
            scope = self.get(id).parent;
        }
        None
    }

    fn lookup_in(&self, mut scope: ScopeId, path: &[&Name]) -> Option<(TypeId, Vec<ScopeId>)> {
        let (last, qualifiers) = path.split_last()?;
        let mut through = Vec::with_capacity(qualifiers.len());
        for qualifier in qualifiers {
            scope = *self.get(scope).children.get(*qualifier)?;
            through.push(scope);
        }
        let found = *self.get(scope).names.get(*last)?;
        Some((found, through))
    }

    /// The scope that the qualifiers of a path lead to, as far as they resolve, with the number of resolved
    /// qualifiers. For error messages.
    pub(super) fn follow(&self, from: ScopeId, absolute: bool, path: &[&Name]) -> (ScopeId, usize) {
        let Some((_, qualifiers)) = path.split_last() else {
            return (from, 0);
        };
        let Some(first) = qualifiers.first() else {
            return (if absolute { GLOBAL } else { from }, 0);
        };
        let mut start = if absolute { GLOBAL } else { from };
        while !self.get(start).children.contains_key(*first) {
            match self.get(start).parent {
                Some(parent) => start = parent,
                None => break,
            }
        }
        let mut followed = 0;
        for qualifier in qualifiers {
            match self.get(start).children.get(*qualifier) {
                Some(&child) => start = child,
                None => break,
            }
            followed += 1;
        }
        (start, followed)
    }

    /// Every name visible unqualified from `from`, inner scopes first.
    pub(super) fn visible(&self, from: ScopeId) -> impl Iterator<Item = (&Name, TypeId)> {
        std::iter::successors(Some(from), |&id| self.get(id).parent)
            .flat_map(|id| self.get(id).names.iter().map(|(name, &ty)| (name, ty)))
    }
}
