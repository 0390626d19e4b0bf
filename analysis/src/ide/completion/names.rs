//! Names in scope: types, constants, the parts of the component around the cursor.

use rustc_hash::FxHashMap;
use smol_str::SmolStr;

use super::{
    CompletionKind, Completions,
    scopes::{full_path, in_scopes, opens_scope, outer_scope},
};
use crate::{
    elab::{DefId, DefKind, Definition, Elaborated, Entity, Reference},
    elab::{convert::holds, types::has_native},
    ide::{
        FileView, SymbolKind,
        context::{BodyKind, Context, Frame, FrameKind, Word},
        render,
    },
    model::{Codel, Component, Name, Spec, TypeId, TypeKind, Value},
};

/// The names visible at the cursor.
pub(in crate::ide) struct Names<'a, 'db> {
    pub(in crate::ide) view: &'a FileView<'db>,
    pub(in crate::ide) elaborated: &'a Elaborated,
    /// The scope at the cursor, outermost first.
    scope: Vec<SmolStr>,
    /// The component around the cursor: index into the spec.
    component: Option<u32>,
    at: usize,
    /// The start of the statement around the cursor, including enclosing type declarations: declarations from
    /// here on are not visible at the cursor.
    begins: usize,
    /// True if the cursor is between the braces of `ids`.
    in_ids: bool,
    /// Definitions in scopes, by full path.
    paths: FxHashMap<Vec<SmolStr>, DefId>,
}

/// The rank of items that are not proposed.
const NOT_PROPOSED: u8 = u8::MAX;

/// The kind of names to propose.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum NameCategory {
    Types,
    /// Types allowed for services and ports: without natives.
    PortTypes,
    /// Types allowed for constants.
    ConstTypes,
    /// Types allowed for the switch of a union.
    SwitchTypes,
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
        let in_ids = |it: &Frame| matches!(it.kind, FrameKind::Body(BodyKind::Ids));
        let in_ids = context.frames.iter().any(in_ids);
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
            begins: begins(context, at),
            in_ids,
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

    /// Tasks and services of the component around the cursor, each with its body, its name and its codels.
    pub(super) fn owners(&self) -> impl Iterator<Item = (BodyKind, &'a Name, &'a [Codel])> {
        let component = self.component().into_iter();
        component.flat_map(|it| {
            let tasks = it.tasks.iter();
            let tasks = tasks.map(|it| (BodyKind::Task, &it.name, it.codels.as_slice()));
            let services = it.services.iter();
            tasks.chain(services.map(|it| (BodyKind::Activity, &it.name, it.codels.as_slice())))
        })
    }

    /// The definition of a part of the component around the cursor.
    pub(super) fn part(&self, part: impl Fn(u32) -> Entity) -> Option<u32> {
        let wanted = part(self.component?);
        let all = &self.elaborated.definitions;
        let found = all.iter().find(|it| it.entity == Some(wanted))?;
        Some(found.id.0)
    }

    /// Returns true if a definition is before the cursor; definitions without a place count as known.
    pub(super) fn is_known(&self, definition: Option<u32>) -> bool {
        let found = definition.and_then(|it| self.elaborated.definitions.get(it as usize));
        found.is_none_or(|it| self.is_before(it))
    }

    /// Returns true if a definition is above the cursor.
    pub(super) fn is_above(&self, definition: Option<u32>) -> bool {
        let found = definition.and_then(|it| self.elaborated.definitions.get(it as usize));
        found.is_none_or(|it| match self.view.place(it.src) {
            Some((file, range)) if file == self.view.file => usize::from(range.start()) < self.at,
            _ => true,
        })
    }

    /// Returns true if a part imported from an interface is visible at the cursor: a `provides`, `uses` or
    /// `extends` above it names the interface, or one that includes it. Own parts are visible, and so are
    /// imports by a pragma or from another file.
    pub(super) fn is_imported_above(&self, from: Option<u32>) -> bool {
        let Some(from) = from else { return true };
        let components = &self.spec().components;
        let leads_to_it = |interface: u32| {
            let mut seen = vec![interface];
            let mut next = 0;
            while let Some(&it) = seen.get(next) {
                next += 1;
                let Some(it) = components.get(it as usize) else {
                    continue;
                };
                for it in it.provides.iter().chain(&it.uses).chain(&it.extends) {
                    if !seen.contains(it) {
                        seen.push(*it);
                    }
                }
            }
            seen.contains(&from)
        };
        let own = |it: &&Reference| it.component == self.component;
        let names = self.elaborated.references.iter().filter(own);
        let names = names.filter(|it| match self.elaborated.definition(it.target).entity {
            Some(Entity::Component(it)) => leads_to_it(it),
            _ => false,
        });
        let mut below = false;
        for it in names {
            match self.view.place(it.at) {
                Some((file, range)) if file == self.view.file => {
                    if usize::from(range.start()) < self.at {
                        return true;
                    }
                    below = true;
                }
                _ => return true,
            }
        }
        !below
    }

    /// Returns true if the component has several bodies: a property allowed once may be in another one.
    pub(super) fn is_reopened(&self) -> bool {
        let own = self.component;
        let bodies = self.spec().bodies.iter();
        bodies.filter(|it| Some(it.component) == own).count() > 1
    }

    /// Members allowed in parameters of a service.
    pub(super) fn carried(&self, ty: TypeId) -> Vec<(SmolStr, TypeId)> {
        let mut all = self.members(ty);
        all.retain(|it| !has_native(self.spec(), it.1));
        all
    }

    /// The ids of the component, if they are declared before the cursor.
    pub(super) fn ids(&self) -> Option<TypeId> {
        let ids = self.component()?.ids?;
        self.is_known(self.definition_of(ids)).then_some(ids)
    }

    /// The declaration of a type object.
    pub(super) fn definition_of(&self, ty: TypeId) -> Option<u32> {
        let all = &self.elaborated.definitions;
        Some(all.iter().find(|it| it.ty == Some(ty))?.id.0)
    }

    /// Returns true if the cursor is in a declaration.
    pub(super) fn is_around(&self, node: crate::model::Src) -> bool {
        let found = self.view.place(node);
        found.is_some_and(|(file, range)| {
            let (start, end) = (usize::from(range.start()), usize::from(range.end()));
            file == self.view.file && start <= self.at && self.at <= end
        })
    }

    /// Returns true if a declaration begins at an offset of the file.
    pub(super) fn is_at(&self, src: crate::model::Src, offset: usize) -> bool {
        let found = self.view.place(src);
        found.is_some_and(|(file, range)| {
            file == self.view.file && usize::from(range.start()) == offset
        })
    }

    /// The meaning of a path at the cursor (language reference, 5.4).
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

    /// Returns true if a declaration is before the cursor, as far as known.
    fn is_before(&self, it: &Definition) -> bool {
        match self.view.place(it.src) {
            Some((file, range)) if file == self.view.file => {
                usize::from(range.start()) < self.begins
            }
            _ => true,
        }
    }

    /// Names of scopes, after a qualifier in the last words of `before`.
    pub(super) fn scoped(
        &self,
        before: &[Word],
        wanted: NameCategory,
        rank: u8,
        out: &mut Completions,
    ) {
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

    /// By place of declaration, so that equal ranks keep the author's order.
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

    fn fits(&self, it: &Definition, wanted: NameCategory) -> bool {
        match wanted {
            NameCategory::Types | NameCategory::PortTypes => {
                let carried = |ty| wanted == NameCategory::Types || !has_native(self.spec(), ty);
                matches!(
                    it.kind,
                    DefKind::Typedef
                        | DefKind::Struct
                        | DefKind::Union
                        | DefKind::Enum
                        | DefKind::Ids
                        | DefKind::Native
                ) && it.ty.is_none_or(carried)
                    && !(it.kind == DefKind::Ids && self.in_ids)
            }
            NameCategory::ConstTypes | NameCategory::SwitchTypes => {
                let kind = it
                    .ty
                    .map(|it| &self.spec().ty(self.spec().resolve_alias(it)).kind);
                matches!(it.kind, DefKind::Typedef | DefKind::Enum)
                    && kind.is_some_and(|it| has_values(it, wanted == NameCategory::SwitchTypes))
            }
            NameCategory::Constants => matches!(it.kind, DefKind::Const | DefKind::Enumerator),
            NameCategory::Exceptions => it.kind == DefKind::Exception,
        }
    }

    /// Everything that may begin a type.
    pub(super) fn types(
        &self,
        before: &[Word],
        wanted: NameCategory,
        rank: u8,
        out: &mut Completions,
    ) {
        let named_only = wanted == NameCategory::PortTypes;
        self.scoped(before, wanted, rank + u8::from(!named_only), out);
        if named_only || before.last().is_some_and(|it| it.is("::")) {
            return;
        }
        self.base_types(wanted, rank, out);
    }

    /// The base types of the language, the most frequent first.
    pub(super) fn base_types(&self, wanted: NameCategory, rank: u8, out: &mut Completions) {
        for it in [
            "double",
            "long",
            "unsigned long",
            "boolean",
            "string",
            "octet",
            "float",
            "short",
            "unsigned short",
            "long long",
            "unsigned long long",
            "char",
            "any",
        ] {
            let fits = match wanted {
                NameCategory::SwitchTypes => {
                    !matches!(it, "double" | "float" | "string" | "octet" | "any")
                }
                NameCategory::ConstTypes => it != "any",
                _ => true,
            };
            if fits {
                out.add(it, CompletionKind::BaseType, rank);
            }
        }
        if wanted != NameCategory::Types {
            return;
        }
        out.snippet("sequence<…>", "sequence<${1:long}>", rank + 1);
        out.snippet("sequence<…, n>", "sequence<${1:long}, ${2:8}>", rank + 1);
        out.snippet("optional<…>", "optional<${1:long}>", rank + 1);
        out.snippet("string<n>", "string<${1:64}>", rank + 1);
    }

    /// An unused name like this one that is not a prefix of another name.
    pub(super) fn unused_name_like(&self, base: &str) -> String {
        let all = &self.elaborated.definitions;
        let taken = |name: &str| {
            let begun = format!("{name}_");
            all.iter()
                .any(|it| it.name == name || it.name.starts_with(&begun))
                || dotgen_syntax::SyntaxKind::contextual(name).is_some()
        };
        if !taken(base) {
            return base.to_owned();
        }
        let mut numbered = (2_u32..).map(|it| format!("{base}{it}"));
        numbered.find(|it| !taken(it)).unwrap_or_default()
    }

    /// Everything that may be in an expression; values of the `expected` type first.
    pub(super) fn constants(
        &self,
        before: &[Word],
        expected: Option<TypeId>,
        out: &mut Completions,
    ) {
        if is_operand(before) {
            return;
        }
        let first = out.items.len();
        self.scoped(before, NameCategory::Constants, 3, out);
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
            let value = ty.and_then(|it| match &spec.ty(it).kind {
                TypeKind::Const { value, .. } => Some(value),
                _ => None,
            });
            let holds = |ty| value.is_none_or(|it| holds(spec, ty, it));
            match (resolved, of) {
                (Some(wanted), Some(of)) if self.same_type(wanted, of) && holds(wanted) => {
                    item.rank = 0
                }
                // Other values do not convert.
                (Some(_), Some(_)) => item.rank = NOT_PROPOSED,
                _ => {}
            }
        }
        out.items.retain(|it| it.rank != NOT_PROPOSED);
        if before.last().is_some_and(|it| it.is("::")) {
            return;
        }
        let boolean = resolved.is_some_and(|it| matches!(spec.ty(it).kind, TypeKind::Boolean));
        if boolean || resolved.is_none() {
            out.keywords(&["TRUE", "FALSE"], if boolean { 0 } else { 6 });
        }
    }

    /// Constants that are numbers; with `whole`, only non-negative integers.
    pub(super) fn numbers(&self, before: &[Word], whole: bool, out: &mut Completions) {
        if is_operand(before) {
            return;
        }
        let first = out.items.len();
        self.scoped(before, NameCategory::Constants, 3, out);
        let spec = self.spec();
        let fits = |item: &super::CompletionItem| {
            let definition = item
                .definition
                .and_then(|it| self.elaborated.definitions.get(it as usize))?;
            // Names that are only the beginning of a path.
            let Some(TypeKind::Const { value, .. }) = definition.ty.map(|it| &spec.ty(it).kind)
            else {
                return Some(!matches!(definition.kind, DefKind::Enumerator));
            };
            Some(match value {
                Value::Uint(_) => true,
                Value::Int(it) => *it >= 0,
                Value::Float(it) => !whole && *it >= 0.0,
                _ => false,
            })
        };
        let mut index = 0;
        out.items.retain(|it| {
            index += 1;
            index <= first || fits(it).unwrap_or(true)
        });
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

    fn same_type(&self, a: TypeId, b: TypeId) -> bool {
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

    /// Members of a struct, union, exception or ids, also of the elements of an array.
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

    /// The type that `[n]` selects.
    pub(in crate::ide) fn element(&self, ty: TypeId) -> Option<TypeId> {
        match self.spec().ty(self.value_type(ty)).kind {
            TypeKind::Array { element, .. } | TypeKind::Sequence { element, .. } => Some(element),
            _ => None,
        }
    }

    /// Returns true if no name from an interface clashes with a name of the component. False if the interface
    /// is not known.
    fn has_room_for(&self, interface: &str) -> bool {
        let Some(interface) = self
            .spec()
            .components
            .iter()
            .find(|it| it.name == interface)
        else {
            return false;
        };
        fn all(it: &Component) -> impl Iterator<Item = &SmolStr> {
            let services = it.services.iter().map(|it| &it.name);
            let ports = it.ports.iter().map(|it| &it.name);
            services
                .chain(ports)
                .chain(it.tasks.iter().map(|it| &it.name))
        }
        let own = self.component();
        !all(interface).any(|name| own.is_some_and(|own| all(own).any(|it| it == name)))
    }

    /// Returns true if the component already provides, uses or extends an interface.
    fn has_interface(&self, interface: &str) -> bool {
        let all = &self.spec().components;
        let named = |it: &u32| all.get(*it as usize).is_some_and(|it| it.name == interface);
        self.component().is_some_and(|it| {
            let mut listed = it.provides.iter().chain(&it.uses).chain(&it.extends);
            listed.any(named)
        })
    }

    /// Components and interfaces by kind, in order of declaration.
    pub(super) fn interfaces(&self, used: &[Word], rank: u8, out: &mut Completions) {
        for it in &self.elaborated.definitions {
            let own = self.component().is_some_and(|own| own.name == it.name);
            let named =
                used.iter().any(|word| word.text == it.name) || self.has_interface(&it.name);
            let unused_name_like = || self.has_room_for(&it.name);
            if it.kind == DefKind::Interface
                && !own
                && !named
                && self.is_before(it)
                && unused_name_like()
            {
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

/// Returns true if an expression ends in an operand, so that an operator or nothing comes next.
fn is_operand(before: &[Word]) -> bool {
    use dotgen_syntax::SyntaxKind::*;
    let last = before.last().map(|it| it.kind);
    matches!(
        last,
        Some(INT | FLOAT | STRING | CHAR | IDENT | R_PAREN | R_CURLY | R_BRACK)
    )
}

/// Returns true if a type can have constants, or be the switch type of unions.
fn has_values(kind: &TypeKind, switch: bool) -> bool {
    use TypeKind::*;
    match kind {
        Boolean
        | Char
        | Short
        | UnsignedShort
        | Long
        | UnsignedLong
        | LongLong
        | UnsignedLongLong
        | Enum { .. } => true,
        Octet | Float | Double | String { .. } => !switch,
        _ => false,
    }
}

/// See [`Names::begins`].
fn begins(context: &Context, at: usize) -> usize {
    let outermost = context.frames.iter().find(|it| {
        !matches!(
            it.kind,
            FrameKind::Body(
                BodyKind::Specification
                    | BodyKind::Module
                    | BodyKind::Component
                    | BodyKind::Interface
                    | BodyKind::Ids
            )
        )
    });
    let first = match outermost {
        Some(frame) if frame.head < frame.open => frame.head,
        _ => context.top().start,
    };
    context
        .tokens
        .get(first)
        .map_or(at, |it| it.range.start.min(at))
}
