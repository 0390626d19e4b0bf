//! The state of an elaboration, and the operations that all parts of it share: places, diagnostics,
//! declarations and references.

use crate::finding::role::Role;
use std::{cell::Cell, sync::Arc};

use rustc_hash::{FxHashMap, FxHashSet};
use typed_index_collections::{TiSlice, TiVec};

use super::{
    AccessKind, BodyEnd, DefId, DefKind, Definition, Elaborated, Entity, Reference, UnitInput,
    Visit,
    scope::{Clash, GLOBAL, ScopeId, Scopes},
    state::{ComponentState, KnownCodel, NewerReleases, PragmaWcet},
    words,
};
use crate::{
    finding::{Finding, FindingKind, Near, Severity, lints::LintWarning, names::NameProblem},
    item_tree::{Item, Name, Ptr},
    model::{Body, ComponentId, Name as Text, Spec, Src, Type, TypeId, TypeKind, VisitId},
};

/// Maximum nesting of includes. The preprocessor allows 100; this limit only stops the recursion on malformed
/// input.
const MAX_INCLUDE_DEPTH: usize = 128;

/// Maximum number of suggestions of near names for one unit.
const MAX_HINTS: u32 = 100;

/// An elaboration in progress.
pub(super) struct Elaborator<'a> {
    pub(super) visits: &'a TiSlice<VisitId, Visit<'a>>,
    /// The visit being read.
    pub(super) visit: VisitId,
    include_depth: usize,

    pub(super) spec: Spec,
    pub(super) scopes: Scopes,
    /// The current scope.
    pub(super) scope: ScopeId,
    /// The component whose body is being read.
    pub(super) component: Option<ComponentId>,
    /// The definition whose inside is being read.
    pub(super) container: Option<DefId>,

    /// By [`TypeId`]: the definition of a type object.
    pub(super) type_defs: TiVec<TypeId, Option<DefId>>,
    /// By [`TypeId`]: place in the order of creation, which differs from the id only for the ids.
    pub(super) type_order: TiVec<TypeId, u32>,
    /// By [`TypeId`]: the type behind its aliases when it was created. Chains of aliases are followed once.
    behind: TiVec<TypeId, TypeId>,
    /// Members of ids that were imported, and the members they are copies of.
    pub(super) origins: FxHashMap<TypeId, TypeId>,
    next_order: u32,
    /// Forward declarations, with the file of each.
    pub(super) forwards: Vec<ForwardDeclaration>,

    /// Parallel to [`Spec::components`].
    pub(super) components: TiVec<ComponentId, ComponentState<'a>>,
    pub(super) component_by_name: FxHashMap<Text, ComponentId>,
    pub(super) codels: FxHashMap<Text, KnownCodel>,

    /// Interfaces of `#pragma provides` so far.
    pub(super) pragma_provides: Vec<ComponentId>,
    /// Unknown interfaces of `#pragma provides`.
    pub(super) pragma_unknown: Vec<Text>,
    pub(super) pragma_wcet: Vec<PragmaWcet>,

    /// Uses of features that only newer releases accept, and the releases that `requires` properties name.
    pub(super) newer: NewerReleases,

    diagnostics: Vec<Finding>,
    reported: FxHashSet<(Src, FindingKind)>,
    reported_at: FxHashSet<(&'static str, Src)>,
    /// Number of suggestions that may still be searched: a search takes time, and a text with very many
    /// unknown names is not misspelt.
    hints: Cell<u32>,
    /// Repeated imports of one interface for which an error was reported.
    repeated_imports: FxHashSet<Src>,
    references: Vec<Reference>,
    /// Names in lists of services that are already recorded: bodies may end several times.
    pub(super) listed: FxHashSet<Src>,
    pub(super) definitions: TiVec<DefId, Definition>,
    pub(super) closings: Vec<BodyEnd>,
    /// Set while contents of an interface are resolved again for an importing component: their names were
    /// recorded when the interface was read.
    pub(super) importing: Option<ImportInProgress>,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct ImportInProgress {
    /// The interface's name in the importing property.
    pub(super) at: Src,
    /// The reason why the component already has this interface. Its contents clash; only the first clash is
    /// reported.
    pub(super) again: Option<&'static str>,
}

#[derive(Debug)]
pub(super) struct ForwardDeclaration {
    pub(super) ty: TypeId,
    pub(super) file: u32,
    /// True if a later declaration of the name could not complete it, which was reported.
    pub(super) excused: bool,
}

impl<'a> Elaborator<'a> {
    pub(super) fn new(unit: &UnitInput<'a>) -> Self {
        Self {
            visits: unit.visits,
            visit: VisitId(0),
            include_depth: 0,
            spec: Spec { release: unit.release, ..Spec::default() },
            scopes: Scopes::new(),
            scope: GLOBAL,
            component: None,
            container: None,
            type_defs: TiVec::new(),
            type_order: TiVec::new(),
            behind: TiVec::new(),
            origins: FxHashMap::default(),
            next_order: 0,
            forwards: Vec::new(),
            components: TiVec::new(),
            component_by_name: FxHashMap::default(),
            codels: FxHashMap::default(),
            pragma_provides: Vec::new(),
            pragma_unknown: Vec::new(),
            pragma_wcet: Vec::new(),
            newer: NewerReleases::default(),
            diagnostics: Vec::new(),
            reported: FxHashSet::default(),
            reported_at: FxHashSet::default(),
            hints: Cell::new(MAX_HINTS),
            repeated_imports: FxHashSet::default(),
            references: Vec::new(),
            listed: FxHashSet::default(),
            definitions: TiVec::new(),
            closings: Vec::new(),
            importing: None,
        }
    }

    /// The result of the elaboration.
    pub(super) fn into_elaborated(self) -> Elaborated {
        Elaborated {
            spec: Arc::new(self.spec),
            diagnostics: self.diagnostics,
            references: self.references,
            definitions: self.definitions,
            closings: self.closings,
        }
    }

    /// Passes each item to `visit`, following includes in place.
    pub(super) fn for_each(
        &mut self,
        items: &'a [Item],
        mut visit: impl FnMut(&mut Self, &'a Item),
    ) {
        self.for_each_dyn(items, &mut visit);
    }

    fn for_each_dyn(&mut self, items: &'a [Item], visit: &mut dyn FnMut(&mut Self, &'a Item)) {
        for item in items {
            let Item::Include { ordinal, .. } = item else {
                visit(self, item);
                continue;
            };
            let here = self.visits.get(self.visit);
            let target = here.and_then(|visit| *visit.includes.get(*ordinal as usize)?);
            let Some(target) = target else { continue };
            let Some(included) = self.visits.get(target) else {
                continue;
            };
            if self.include_depth >= MAX_INCLUDE_DEPTH {
                continue;
            }
            if let Some(component) = self.component {
                self.spec.bodies.push(Body { visit: target, item: None, component });
            }
            self.include_depth += 1;
            let outer = std::mem::replace(&mut self.visit, target);
            self.for_each_dyn(&included.tree.items, visit);
            self.visit = outer;
            self.include_depth -= 1;
        }
    }

    /// The file being read.
    pub(super) fn file(&self) -> u32 {
        self.visits.get(self.visit).map_or(0, |visit| visit.file)
    }

    /// A node of the visit being read.
    pub(super) fn src(&self, ptr: Ptr) -> Src {
        Src { visit: self.visit, item: ptr.item, node: ptr.node }
    }

    // Diagnostics

    /// Reports a problem, once. While an interface is imported, problems are reported at its name in the
    /// importing property, except problems of the interface itself, which were reported when it was read.
    pub(super) fn report(&mut self, mut finding: Finding) {
        if let Some(importing) = self.importing
            && importing.at != finding.at
        {
            if self.reported_at.contains(&(finding.code(), finding.at)) {
                return;
            }
            let place = (finding.at, Role::InInterface);
            finding.related.insert(0, place);
            finding.at = importing.at;
        }
        if let Some(ImportInProgress { at, again: Some(why) }) = self.importing {
            let is_error = finding.severity == Severity::Error;
            if is_error && !self.repeated_imports.insert(at) {
                return;
            }
            finding.because = Some(why);
        }
        if self.reported.insert((finding.at, finding.kind.clone())) {
            self.reported_at.insert((finding.code(), finding.at));
            self.diagnostics.push(finding);
        }
    }

    /// Removes the last finding if it has this code: a worse error is reported for the same text.
    pub(super) fn retract(&mut self, code: &str) {
        if self.diagnostics.last().is_some_and(|diagnostic| diagnostic.code() == code) {
            self.diagnostics.pop();
        }
    }

    /// The probable meaning of an unknown name; `at` is its token.
    pub(super) fn near<'n>(
        &self,
        at: Src,
        name: &str,
        candidates: impl IntoIterator<Item = &'n str>,
    ) -> Option<Near> {
        self.hint(at, || dotgen_syntax::suggestion::nearest(name, candidates))
    }

    /// The declared name that a search finds. `None` if there were many searches already.
    pub(super) fn hint<'n>(
        &self,
        at: Src,
        search: impl FnOnce() -> Option<&'n str>,
    ) -> Option<Near> {
        let left = self.hints.get().checked_sub(1)?;
        self.hints.set(left);
        search().map(|near| Near::new(at, near))
    }

    /// Reports a problem that has only one place.
    pub(super) fn error(&mut self, at: Src, kind: impl Into<FindingKind>) {
        self.report(Finding::new(kind, at));
    }

    /// Reports text that GenoM3 reads otherwise: a deviation. In imported text, it was reported there.
    pub(super) fn deviation(&mut self, at: Src, kind: LintWarning) {
        if self.importing.is_none() {
            self.report(Finding::new(kind, at));
        }
    }

    /// Reports an unknown name.
    pub(super) fn unresolved(&mut self, at: Src, kind: impl Into<FindingKind>, near: Option<Near>) {
        self.report(Finding::new(kind, at).near(near));
    }

    // Types

    /// A new anonymous type object.
    pub(super) fn anonymous(&mut self, kind: TypeKind, src: Src) -> TypeId {
        self.push_type(Type {
            kind,
            name: None,
            scope: self.scopes.get(self.scope).path.clone(),
            src,
            parent: None,
            masquerade: Vec::new(),
        })
    }

    /// A new type object named `name` in `scope`; it is not declared there yet.
    pub(super) fn named(&mut self, kind: TypeKind, scope: ScopeId, name: Text, src: Src) -> TypeId {
        let scope = self.scopes.get(scope).path.clone();
        self.push_type(Type {
            kind,
            name: Some(name),
            scope,
            src,
            parent: None,
            masquerade: Vec::new(),
        })
    }

    fn push_type(&mut self, ty: Type) -> TypeId {
        let id = self.spec.types.next_key();
        self.behind.push(match ty.kind {
            TypeKind::Typedef { ty }
            | TypeKind::StructMember { ty }
            | TypeKind::UnionMember { ty, .. }
            | TypeKind::Const { ty, .. } => self.resolve_alias(ty),
            _ => id,
        });
        self.spec.types.push(ty);
        self.type_defs.push(None);
        self.type_order.push(self.next_order);
        self.next_order += 1;
        id
    }

    /// Moves a type object to the end of the order of creation.
    pub(super) fn move_to_end(&mut self, id: TypeId) {
        self.type_order[id] = self.next_order;
        self.next_order += 1;
    }

    /// [`Spec::resolve_alias`], in constant time.
    pub(super) fn resolve_alias(&self, id: TypeId) -> TypeId {
        self.spec.resolve_alias(self.behind.get(id).copied().unwrap_or(id))
    }

    /// A type in the place of an unresolved one.
    pub(super) fn unknown(&mut self, src: Src) -> TypeId {
        self.anonymous(TypeKind::Unknown, src)
    }

    /// Returns true if an error about this type was already reported.
    pub(super) fn is_unknown(&self, id: TypeId) -> bool {
        matches!(self.spec.ty(self.resolve_alias(id)).kind, TypeKind::Unknown)
    }

    // Declarations

    /// Records a declaration.
    pub(super) fn define(
        &mut self,
        kind: DefKind,
        name: &Text,
        src: Src,
        node: Src,
        ty: Option<TypeId>,
    ) -> DefId {
        let id = self.definitions.next_key();
        self.definitions.push(Definition {
            id,
            kind,
            name: name.clone(),
            src,
            node,
            container: self.container,
            ty,
            entity: None,
        });
        if let Some(ty) = ty {
            let slot = &mut self.type_defs[ty];
            if slot.is_none() {
                *slot = Some(id);
            }
        }
        id
    }

    pub(super) fn set_entity(&mut self, def: DefId, entity: Entity) {
        self.definitions[def].entity = Some(entity);
    }

    /// Adds a type object to a scope, or reports the reason why it cannot be there.
    pub(super) fn declare(&mut self, scope: ScopeId, name: &Name, ty: TypeId) -> bool {
        let at = self.src(name.ptr);
        self.declare_at(scope, &name.text, at, ty)
    }

    /// Like [`Self::declare`], for a name that is written elsewhere.
    pub(super) fn declare_at(&mut self, scope: ScopeId, name: &Text, at: Src, ty: TypeId) -> bool {
        let clash = self.scopes.clash(scope, name, false);
        if let Some(clash) = clash {
            self.report_clash(scope, name, at, clash);
        }
        // If the name is not taken, it is recorded for its uses.
        if matches!(clash, None | Some(Clash::Enclosing)) {
            let names = &mut self.scopes.get_mut(scope).names;
            names.insert(name.clone(), ty);
        }
        clash.is_none()
    }

    /// Reports the reason why a name cannot be declared.
    pub(super) fn report_clash(&mut self, scope: ScopeId, name: &Text, at: Src, clash: Clash) {
        if let Clash::Name(previous) = clash
            && let Some(forward) = self.forward_of(previous)
        {
            forward.excused = true;
        }
        let diagnostic = match clash {
            Clash::Name(previous) => {
                let what = words::describe(&self.spec, previous);
                let place = self.type_place(previous);
                let kind = match place {
                    Some(_) => NameProblem::Clash { name: name.clone(), what },
                    None => NameProblem::ClashWithState { name: name.clone(), what },
                };
                let diagnostic = Finding::new(kind, at);
                match place {
                    Some(place) => diagnostic.related(place, Role::FirstDeclared),
                    None => diagnostic,
                }
            }
            Clash::Scope(child) => {
                let def = self.scopes.get(child).def;
                let what = match def.map(|definition| self.definitions[definition].kind) {
                    Some(DefKind::Component) => "a component",
                    Some(DefKind::Interface) => "an interface",
                    Some(DefKind::Module) => "a module",
                    Some(_) => "a type",
                    None => "the scope of paused states",
                };
                let diagnostic =
                    Finding::new(NameProblem::ClashWithScope { name: name.clone(), what }, at);
                match def {
                    Some(def) => {
                        let place = self.definitions[def].src;
                        diagnostic.related(place, Role::FirstDeclared)
                    }
                    None => diagnostic,
                }
            }
            Clash::Enclosing => {
                let def = self.scopes.get(scope).def;
                let diagnostic =
                    Finding::new(NameProblem::ClashWithEnclosing { name: name.clone() }, at);
                match def {
                    Some(def) => {
                        let place = self.definitions[def].src;
                        diagnostic.related(place, Role::Is(name.clone()))
                    }
                    None => diagnostic,
                }
            }
        };
        self.report(diagnostic);
    }

    /// The forward declaration of a type, if it is one.
    pub(super) fn forward_of(&mut self, ty: TypeId) -> Option<&mut ForwardDeclaration> {
        // In order of creation.
        let found = self.forwards.binary_search_by_key(&ty, |declaration| declaration.ty);
        self.forwards.get_mut(found.ok()?)
    }

    /// The declaration of a type object, if it was declared in a text.
    pub(super) fn type_place(&self, ty: TypeId) -> Option<Src> {
        let def = self.type_defs[ty]?;
        Some(self.definitions[def].src)
    }

    /// Runs `inside` with another current scope and container.
    pub(super) fn within<R>(
        &mut self,
        scope: ScopeId,
        container: Option<DefId>,
        inside: impl FnOnce(&mut Self) -> R,
    ) -> R {
        let outer_scope = std::mem::replace(&mut self.scope, scope);
        let outer_container = std::mem::replace(&mut self.container, container);
        let result = inside(self);
        self.scope = outer_scope;
        self.container = outer_container;
        result
    }

    /// Runs `inside` in the context of another visit.
    pub(super) fn in_visit<R>(&mut self, visit: VisitId, inside: impl FnOnce(&mut Self) -> R) -> R {
        let outer = std::mem::replace(&mut self.visit, visit);
        let result = inside(self);
        self.visit = outer;
        result
    }

    // References

    /// Records the use of a name.
    pub(super) fn refer(&mut self, at: Src, target: DefId) {
        self.refer_as(at, target, AccessKind::Mention);
    }

    /// Records the use of a type object's name.
    pub(super) fn refer_type(&mut self, at: Src, ty: TypeId) {
        if let Some(def) = self.type_defs[ty] {
            self.refer(at, def);
        }
    }

    pub(super) fn refer_as(&mut self, at: Src, target: DefId, access: AccessKind) {
        if self.importing.is_none() {
            self.references.push(Reference { at, target, access, component: self.component });
        }
    }
}
