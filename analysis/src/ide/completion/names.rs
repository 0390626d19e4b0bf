//! Names in scope: types, constants, the parts of the component around the cursor.

use rustc_hash::FxHashMap;
use smol_str::SmolStr;

use super::{CompletionKind, Completions};
use crate::{
    elab::{DefId, DefKind, Definition, Elaborated, Entity},
    ide::{
        FileView, SymbolKind,
        context::{BodyKind, Context, FrameKind, Word},
        render,
    },
    model::{Component, Spec, TypeId, TypeKind},
};

/// What is visible at the cursor.
pub(in crate::ide) struct Names<'a, 'db> {
    pub(in crate::ide) view: &'a FileView<'db>,
    pub(in crate::ide) elaborated: &'a Elaborated,
    /// The scope at the cursor, outermost first.
    scope: Vec<SmolStr>,
    /// The component around the cursor: index into the spec.
    component: Option<u32>,
    at: usize,
    /// Definitions that live in scopes, by full path.
    paths: FxHashMap<Vec<SmolStr>, DefId>,
}

/// Which names of scopes are wanted.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Wanted {
    Types,
    /// With a name, so a port may carry them.
    PortTypes,
    Constants,
    Exceptions,
}

impl<'a, 'db> Names<'a, 'db> {
    pub(in crate::ide) fn new(
        view: &'a FileView<'db>,
        context: &Context,
        at: usize,
    ) -> Names<'a, 'db> {
        let elaborated = view.elaborated();
        let mut scope: Vec<SmolStr> = Vec::new();
        let mut component = None;
        for frame in &context.frames {
            let FrameKind::Body(kind) = frame.kind else {
                continue;
            };
            if matches!(kind, BodyKind::Component | BodyKind::Interface) {
                component = context.name_of(frame);
            }
            if matches!(
                kind,
                BodyKind::Module
                    | BodyKind::Component
                    | BodyKind::Interface
                    | BodyKind::Ids
                    | BodyKind::Members
                    | BodyKind::Cases
            ) {
                scope.extend(context.name_of(frame));
            }
        }
        let outer = outer_scope(view, elaborated);
        if component.is_none() {
            let is_component = |id: &DefId| {
                matches!(
                    elaborated.definition(*id).kind,
                    DefKind::Component | DefKind::Interface
                )
            };
            let found = outer.iter().find(|it| is_component(it));
            component = found.map(|it| elaborated.definition(*it).name.clone());
        }
        let outer = outer
            .iter()
            .map(|it| elaborated.definition(*it).name.clone());
        scope.splice(0..0, outer);
        let by_name = |name: SmolStr| {
            let all = &elaborated.spec.components;
            all.iter().position(|it| it.name == name)
        };
        let mut paths = FxHashMap::default();
        for it in &elaborated.definitions {
            if in_scopes(it.kind) {
                paths.entry(full_path(elaborated, it)).or_insert(it.id);
            }
        }
        Names {
            view,
            elaborated,
            scope,
            component: component.and_then(by_name).map(|it| it as u32),
            at,
            paths,
        }
    }

    /// The cursor.
    pub(super) fn at(&self) -> usize {
        self.at
    }

    pub(in crate::ide) fn spec(&self) -> &'a Spec {
        &self.elaborated.spec
    }

    /// The component around the cursor.
    pub(in crate::ide) fn component(&self) -> Option<&'a Component> {
        self.spec().components.get(self.component? as usize)
    }

    /// The definition of a part of the component around the cursor.
    pub(super) fn part(&self, part: impl Fn(u32) -> Entity) -> Option<u32> {
        let wanted = part(self.component?);
        let all = &self.elaborated.definitions;
        let found = all.iter().find(|it| it.entity == Some(wanted))?;
        Some(found.id.0)
    }

    /// The declaration of a type object.
    pub(super) fn definition_of(&self, ty: TypeId) -> Option<u32> {
        let all = &self.elaborated.definitions;
        Some(all.iter().find(|it| it.ty == Some(ty))?.id.0)
    }

    /// What a path means from the cursor (language reference, 5.4).
    pub(in crate::ide) fn resolve(
        &self,
        absolute: bool,
        segments: &[SmolStr],
    ) -> Option<&'a Definition> {
        let depths = match absolute {
            true => 0..=0,
            false => 0..=self.scope.len(),
        };
        depths.rev().find_map(|depth| {
            let mut path = self.scope[..depth].to_vec();
            path.extend_from_slice(segments);
            self.paths
                .get(&path)
                .map(|it| self.elaborated.definition(*it))
        })
    }

    /// Whether a declaration comes before the cursor, as far as that can be told.
    fn is_before(&self, it: &Definition) -> bool {
        match self.view.place(it.src) {
            Some((file, range)) if file == self.view.file => usize::from(range.start()) < self.at,
            _ => true,
        }
    }

    /// Names of scopes, after a qualifier in the last words of `before`.
    pub(super) fn scoped(&self, before: &[Word], wanted: Wanted, rank: u8, out: &mut Completions) {
        let (absolute, qualifier) = qualifier(before);
        let within = match (absolute, qualifier.is_empty()) {
            (false, true) => None,
            (true, true) => Some(Vec::new()),
            _ => match self.resolve(absolute, &qualifier) {
                Some(it) => Some(full_path(self.elaborated, it)),
                None => return,
            },
        };
        for (path, id) in self.sorted() {
            let it = self.elaborated.definition(*id);
            let fits = self.fits(it, wanted);
            match &within {
                Some(within) => {
                    let child = path.len() == within.len() + 1 && path.starts_with(within);
                    if child && (fits || opens_scope(it.kind)) && self.is_before(it) {
                        self.push(it, it.name.to_string(), rank + u8::from(!fits), out);
                    }
                }
                None if fits && self.is_before(it) => {
                    let common = std::iter::zip(path.iter(), &self.scope)
                        .take_while(|(a, b)| a == b)
                        .count()
                        .min(path.len() - 1);
                    let label = path[common..].join("::");
                    let far = path.len() - common > 1;
                    self.push(it, label, rank + u8::from(far), out);
                }
                None => {}
            }
        }
    }

    /// By place of declaration, so that equal ranks come as the author wrote them.
    fn sorted(&self) -> Vec<(&Vec<SmolStr>, &DefId)> {
        let mut all: Vec<_> = self.paths.iter().collect();
        all.sort_by_key(|(_, id)| **id);
        all
    }

    fn push(&self, it: &Definition, label: String, rank: u8, out: &mut Completions) {
        let kind = CompletionKind::Symbol(SymbolKind::from(it.kind));
        let item = out.add(label, kind, rank);
        item.definition = Some(it.id.0);
        item.detail = self.detail(it);
    }

    fn detail(&self, it: &Definition) -> Option<String> {
        let ty = it.ty?;
        let spec = self.spec();
        match &spec.types.get(ty.0 as usize)?.kind {
            TypeKind::Const { value, .. } => Some(format!("= {}", render::value(spec, value))),
            TypeKind::Enumerator { enumeration, .. } => Some(render::type_text(spec, *enumeration)),
            _ => render::resolved_type_text(spec, ty),
        }
    }

    fn fits(&self, it: &Definition, wanted: Wanted) -> bool {
        match wanted {
            Wanted::Types | Wanted::PortTypes => match it.kind {
                DefKind::Typedef | DefKind::Struct | DefKind::Union | DefKind::Enum | DefKind::Ids => true,
                DefKind::Native => wanted == Wanted::Types,
                DefKind::Exception => it.ty.is_some_and(|ty| {
                    matches!(&self.spec().ty(ty).kind, TypeKind::Exception { members } if !members.is_empty())
                }),
                _ => false,
            },
            Wanted::Constants => matches!(it.kind, DefKind::Const | DefKind::Enumerator),
            Wanted::Exceptions => it.kind == DefKind::Exception,
        }
    }

    /// Everything that may begin a type.
    pub(super) fn types(&self, before: &[Word], port: bool, rank: u8, out: &mut Completions) {
        let wanted = if port {
            Wanted::PortTypes
        } else {
            Wanted::Types
        };
        self.scoped(before, wanted, rank, out);
        if port || before.last().is_some_and(|it| it.is("::")) {
            return;
        }
        for it in [
            "boolean",
            "char",
            "double",
            "float",
            "long",
            "long long",
            "octet",
            "short",
            "string",
            "unsigned long",
            "unsigned long long",
            "unsigned short",
            "any",
        ] {
            out.add(it, CompletionKind::BaseType, rank + 1);
        }
        out.snippet("sequence<…>", "sequence<${1:long}>", rank + 1);
        out.snippet("sequence<…, n>", "sequence<${1:long}, ${2:8}>", rank + 1);
        out.snippet("optional<…>", "optional<${1:long}>", rank + 1);
        out.snippet("string<n>", "string<${1:64}>", rank + 1);
    }

    /// Everything that may stand in an expression; what fits `expected` first.
    pub(super) fn constants(
        &self,
        before: &[Word],
        expected: Option<TypeId>,
        out: &mut Completions,
    ) {
        let first = out.items.len();
        self.scoped(before, Wanted::Constants, 3, out);
        let spec = self.spec();
        let resolved = expected.map(|it| self.value_type(it));
        for item in &mut out.items[first..] {
            let definition = item
                .definition
                .and_then(|it| self.elaborated.definitions.get(it as usize));
            let ty = definition.and_then(|it| it.ty);
            let of = match ty.map(|it| &spec.ty(it).kind) {
                Some(TypeKind::Enumerator { enumeration, .. }) => Some(*enumeration),
                Some(TypeKind::Const { ty, .. }) => Some(self.value_type(*ty)),
                _ => None,
            };
            match (resolved, of) {
                (Some(wanted), Some(of)) if self.same(wanted, of) => item.rank = 0,
                // An enumerator is of no use where something else is wanted.
                (Some(_), Some(of)) if matches!(spec.ty(of).kind, TypeKind::Enum { .. }) => {
                    item.rank += 3
                }
                _ => {}
            }
        }
        if before.last().is_some_and(|it| it.is("::")) {
            return;
        }
        let boolean = resolved.is_some_and(|it| matches!(spec.ty(it).kind, TypeKind::Boolean));
        if boolean || resolved.is_none() {
            out.keywords(&["TRUE", "FALSE"], if boolean { 0 } else { 6 });
        }
    }

    /// A type without aliases and optionals.
    pub(in crate::ide) fn value_type(&self, id: TypeId) -> TypeId {
        let spec = self.spec();
        let mut id = spec.resolve_alias(id);
        for _ in 0..spec.types.len() {
            match spec.ty(id).kind {
                TypeKind::Optional { element } => id = spec.resolve_alias(element),
                _ => break,
            }
        }
        id
    }

    fn same(&self, a: TypeId, b: TypeId) -> bool {
        let number = |it: TypeId| {
            matches!(
                self.spec().ty(it).kind,
                TypeKind::Octet
                    | TypeKind::Short
                    | TypeKind::UnsignedShort
                    | TypeKind::Long
                    | TypeKind::UnsignedLong
                    | TypeKind::LongLong
                    | TypeKind::UnsignedLongLong
                    | TypeKind::Float
                    | TypeKind::Double
            )
        };
        a == b || number(a) && number(b) || self.spec().ty(a).kind == self.spec().ty(b).kind
    }

    /// Members of a struct, union, exception or ids, and what an element of an array is.
    pub(in crate::ide) fn members(&self, ty: TypeId) -> Vec<(SmolStr, TypeId)> {
        let spec = self.spec();
        let members = match &spec.ty(self.value_type(ty)).kind {
            TypeKind::Struct { members }
            | TypeKind::Union { members, .. }
            | TypeKind::Exception { members } => members.as_slice(),
            _ => return Vec::new(),
        };
        let named = members
            .iter()
            .filter_map(|&it| Some((spec.ty(it).name.clone()?, it)));
        named.collect()
    }

    /// What `[n]` selects.
    pub(in crate::ide) fn element(&self, ty: TypeId) -> Option<TypeId> {
        match self.spec().ty(self.value_type(ty)).kind {
            TypeKind::Array { element, .. } | TypeKind::Sequence { element, .. } => Some(element),
            _ => None,
        }
    }

    /// Components and interfaces by kind, as the author declared them.
    pub(super) fn interfaces(&self, used: &[Word], rank: u8, out: &mut Completions) {
        for it in &self.elaborated.definitions {
            let own = self.component().is_some_and(|own| own.name == it.name);
            let named = used.iter().any(|word| word.text == it.name);
            if it.kind == DefKind::Interface && !own && !named && self.is_before(it) {
                self.push(it, it.name.to_string(), rank, out);
            }
        }
    }
}

/// The `a::b::` or `::` at the end of some words.
pub(in crate::ide) fn qualifier(words: &[Word]) -> (bool, Vec<SmolStr>) {
    let mut segments = Vec::new();
    let mut rest = words;
    while let [before @ .., last] = rest
        && last.is("::")
    {
        match before {
            [before @ .., name] if dotgen_syntax::lexer::is_word(name.kind, &name.text) => {
                segments.insert(0, name.text.clone());
                rest = before;
            }
            _ => return (true, segments),
        }
    }
    (false, segments)
}

/// What the file is included in: modules and components, outermost first.
fn outer_scope(view: &FileView<'_>, elaborated: &Elaborated) -> Vec<DefId> {
    if view.key.fragment(view.db) == dotgen_syntax::Fragment::Specification {
        return Vec::new();
    }
    let here = |it: &&Definition| {
        view.place(it.src)
            .is_some_and(|(file, _)| file == view.file)
    };
    let first = elaborated.definitions.iter().find(here);
    let mut chain = Vec::new();
    let mut next = first.and_then(|it| it.container);
    while let Some(id) = next {
        let it = elaborated.definition(id);
        if opens_scope(it.kind) && view.place(it.src).is_none_or(|(file, _)| file != view.file) {
            chain.insert(0, id);
        }
        next = it.container;
    }
    chain
}

fn in_scopes(kind: DefKind) -> bool {
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

fn opens_scope(kind: DefKind) -> bool {
    use DefKind::*;
    matches!(kind, Module | Component | Interface | Struct | Union | Ids)
}

/// The path by which a definition is found from the global scope.
fn full_path(elaborated: &Elaborated, it: &Definition) -> Vec<SmolStr> {
    let mut path = vec![it.name.clone()];
    let mut next = it.container;
    while let Some(id) = next {
        let container = elaborated.definition(id);
        // Enumerators live beside their enum.
        if container.kind != DefKind::Enum {
            path.insert(0, container.name.clone());
        }
        next = container.container;
    }
    path
}
