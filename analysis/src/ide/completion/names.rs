//! Names in scope: types, constants, the parts of the component around the cursor.

mod interfaces;
mod values;

use rustc_hash::FxHashMap;
use smol_str::SmolStr;
use typed_index_collections::TiSlice;

use super::{
    CompletionKind, Completions,
    scopes::{full_path, in_scopes, opens_scope, outer_scope},
};
use crate::{
    elab::types::has_native,
    elab::{DefId, DefKind, Definition, Elaborated, Entity, Reference},
    ide::{
        FileView, SymbolKind,
        context::{BodyKind, Context, Frame, FrameKind, Word},
        render,
    },
    model::{Codel, CodelId, Component, ComponentId, Name, Spec, TypeId, TypeKind},
};

/// The names visible at the cursor.
pub(in crate::ide) struct VisibleNames<'a, 'db> {
    pub(in crate::ide) view: &'a FileView<'db>,
    pub(in crate::ide) elaborated: &'a Elaborated,
    /// The scope at the cursor, outermost first.
    scope: Vec<SmolStr>,
    /// The component around the cursor: index into the spec.
    component: Option<ComponentId>,
    at: usize,
    /// The start of the statement around the cursor, including enclosing type declarations: declarations from
    /// here on are not visible at the cursor.
    begins: usize,
    /// True if the cursor is between the braces of `ids`.
    in_ids: bool,
    /// Definitions in scopes, by full path.
    paths: FxHashMap<Vec<SmolStr>, DefId>,
}

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

impl<'a, 'db> VisibleNames<'a, 'db> {
    pub(in crate::ide) fn new(
        view: &'a FileView<'db>,
        context: &Context,
        at: usize,
    ) -> VisibleNames<'a, 'db> {
        let elaborated = view.elaborated();
        let mut scope: Vec<SmolStr> = Vec::new();
        let mut component = None;
        let in_ids = |frame: &Frame| matches!(frame.kind, FrameKind::Body(BodyKind::Ids));
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
                matches!(elaborated.definition(*id).kind, DefKind::Component | DefKind::Interface)
            };
            let found = outer.iter().find(|scope| is_component(scope));
            component = found.map(|scope| elaborated.definition(*scope).name.clone());
        }
        let outer = outer.iter().map(|scope| elaborated.definition(*scope).name.clone());
        scope.splice(0..0, outer);
        let by_name = |name: SmolStr| {
            let all = &elaborated.spec.components;
            all.position(|component| component.name == name)
        };
        let mut paths = FxHashMap::default();
        for definition in &elaborated.definitions {
            if in_scopes(definition.kind) {
                paths.entry(full_path(elaborated, definition)).or_insert(definition.id);
            }
        }
        VisibleNames {
            view,
            elaborated,
            scope,
            component: component.and_then(by_name),
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
        self.spec().components.get(self.component?)
    }

    /// The index of the component around the cursor in [`Spec::components`](crate::model::Spec).
    pub(super) fn component_number(&self) -> Option<ComponentId> {
        self.component
    }

    /// Tasks and services of the component around the cursor, each with its body, its name and its codels.
    pub(super) fn owners(
        &self,
    ) -> impl Iterator<Item = (BodyKind, &'a Name, &'a TiSlice<CodelId, Codel>)> {
        let component = self.component().into_iter();
        component.flat_map(|component| {
            let tasks = component.tasks.iter();
            let tasks = tasks.map(|task| (BodyKind::Task, &task.name, task.codels.as_slice()));
            let services = component.services.iter();
            tasks.chain(
                services
                    .map(|service| (BodyKind::Activity, &service.name, service.codels.as_slice())),
            )
        })
    }

    /// The definition of a part of the component around the cursor.
    pub(super) fn part(&self, part: impl Fn(ComponentId) -> Entity) -> Option<DefId> {
        let wanted = part(self.component?);
        let all = &self.elaborated.definitions;
        let found = all.iter().find(|definition| definition.entity == Some(wanted))?;
        Some(found.id)
    }

    /// Returns true if a definition is before the cursor; definitions without a place count as known.
    pub(super) fn is_known(&self, definition: Option<DefId>) -> bool {
        definition.is_none_or(|id| self.is_before(self.elaborated.definition(id)))
    }

    /// Returns true if a definition is above the cursor.
    pub(super) fn is_above(&self, definition: Option<DefId>) -> bool {
        let found = definition.map(|id| self.elaborated.definition(id));
        found.is_none_or(|definition| match self.view.place(definition.src) {
            Some((file, range)) if file == self.view.file => usize::from(range.start()) < self.at,
            _ => true,
        })
    }

    /// Returns true if a part imported from an interface is visible at the cursor: a `provides`, `uses` or
    /// `extends` above it names the interface, or one that includes it. Own parts are visible, and so are
    /// imports by a pragma or from another file.
    pub(super) fn is_imported_above(&self, from: Option<ComponentId>) -> bool {
        let Some(from) = from else { return true };
        let components = &self.spec().components;
        let leads_to_it = |interface: ComponentId| {
            let mut seen = vec![interface];
            let mut next = 0;
            while let Some(&number) = seen.get(next) {
                next += 1;
                let Some(component) = components.get(number) else {
                    continue;
                };
                for provided in
                    component.provides.iter().chain(&component.uses).chain(&component.extends)
                {
                    if !seen.contains(provided) {
                        seen.push(*provided);
                    }
                }
            }
            seen.contains(&from)
        };
        let own = |reference: &&Reference| reference.component == self.component;
        let names = self.elaborated.references.iter().filter(own);
        let names = names.filter(|name| match self.elaborated.definition(name.target).entity {
            Some(Entity::Component(component)) => leads_to_it(component),
            _ => false,
        });
        let mut below = false;
        for name in names {
            match self.view.place(name.at) {
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
        bodies.filter(|body| Some(body.component) == own).count() > 1
    }

    /// Members allowed in parameters of a service.
    pub(super) fn carried(&self, ty: TypeId) -> Vec<(SmolStr, TypeId)> {
        let mut all = self.members(ty);
        all.retain(|member| !has_native(self.spec(), member.1));
        all
    }

    /// The ids of the component, if they are declared before the cursor.
    pub(super) fn ids(&self) -> Option<TypeId> {
        let ids = self.component()?.ids?;
        self.is_known(self.definition_of(ids)).then_some(ids)
    }

    /// The declaration of a type object.
    pub(super) fn definition_of(&self, ty: TypeId) -> Option<DefId> {
        let all = &self.elaborated.definitions;
        Some(all.iter().find(|definition| definition.ty == Some(ty))?.id)
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
        let depths = if absolute { 0..=0 } else { 0..=self.scope.len() };
        depths.rev().find_map(|depth| {
            let mut path = self.scope[..depth].to_vec();
            path.extend_from_slice(segments);
            self.paths.get(&path).map(|path| self.elaborated.definition(*path))
        })
    }

    /// Returns true if a declaration is before the cursor, as far as known.
    fn is_before(&self, definition: &Definition) -> bool {
        match self.view.place(definition.src) {
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
                Some(definition) => Some(full_path(self.elaborated, definition)),
                None => return,
            },
        };
        for (path, id) in self.sorted() {
            let definition = self.elaborated.definition(*id);
            let fits = self.fits(definition, wanted);
            match &within {
                Some(within) => {
                    let child = path.len() == within.len() + 1 && path.starts_with(within);
                    if child && (fits || opens_scope(definition.kind)) && self.is_before(definition)
                    {
                        self.push(
                            definition,
                            definition.name.to_string(),
                            rank + u8::from(!fits),
                            out,
                        );
                    }
                }
                None if fits && self.is_before(definition) => {
                    let common = std::iter::zip(path.iter(), &self.scope)
                        .take_while(|(a, b)| a == b)
                        .count()
                        .min(path.len() - 1);
                    let label = path[common..].join("::");
                    let far = path.len() - common > 1;
                    self.push(definition, label, rank + u8::from(far), out);
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

    fn push(&self, definition: &Definition, label: String, rank: u8, out: &mut Completions) {
        let kind = CompletionKind::Symbol(SymbolKind::from(definition.kind));
        let item = out.add(label, kind, rank);
        item.definition = Some(definition.id);
        item.detail = self.detail(definition);
    }

    fn detail(&self, definition: &Definition) -> Option<String> {
        let ty = definition.ty?;
        let spec = self.spec();
        match &spec.types.get(ty)?.kind {
            TypeKind::Const { value, .. } => Some(format!("= {}", render::value(spec, value))),
            TypeKind::Enumerator { enumeration, .. } => Some(render::type_text(spec, *enumeration)),
            _ => render::resolved_type_text(spec, ty),
        }
    }

    fn fits(&self, definition: &Definition, wanted: NameCategory) -> bool {
        match wanted {
            NameCategory::Types | NameCategory::PortTypes => {
                let carried = |ty| wanted == NameCategory::Types || !has_native(self.spec(), ty);
                matches!(
                    definition.kind,
                    DefKind::Typedef
                        | DefKind::Struct
                        | DefKind::Union
                        | DefKind::Enum
                        | DefKind::Ids
                        | DefKind::Native
                ) && definition.ty.is_none_or(carried)
                    && !(definition.kind == DefKind::Ids
                        && (self.in_ids || wanted == NameCategory::PortTypes))
            }
            NameCategory::ConstTypes | NameCategory::SwitchTypes => {
                let kind =
                    definition.ty.map(|ty| &self.spec().ty(self.spec().resolve_alias(ty)).kind);
                matches!(definition.kind, DefKind::Typedef | DefKind::Enum)
                    && kind
                        .is_some_and(|kind| has_values(kind, wanted == NameCategory::SwitchTypes))
            }
            NameCategory::Constants => {
                matches!(definition.kind, DefKind::Const | DefKind::Enumerator)
            }
            NameCategory::Exceptions => definition.kind == DefKind::Exception,
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
        if named_only || before.last().is_some_and(|word| word.is("::")) {
            return;
        }
        self.base_types(wanted, rank, out);
    }

    /// The base types of the language, the most frequent first.
    pub(super) fn base_types(&self, wanted: NameCategory, rank: u8, out: &mut Completions) {
        for text in [
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
                    !matches!(text, "double" | "float" | "string" | "octet" | "any")
                }
                NameCategory::ConstTypes => text != "any",
                _ => true,
            };
            if fits {
                out.add(text, CompletionKind::BaseType, rank);
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
                .any(|definition| definition.name == name || definition.name.starts_with(&begun))
                || dotgen_syntax::SyntaxKind::contextual(name).is_some()
        };
        if !taken(base) {
            return base.to_owned();
        }
        let mut numbered = (2_u32..).map(|number| format!("{base}{number}"));
        numbered.find(|format| !taken(format)).unwrap_or_default()
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

/// See [`VisibleNames::begins`].
fn begins(context: &Context, at: usize) -> usize {
    let outermost = context.frames.iter().find(|frame| {
        !matches!(
            frame.kind,
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
    context.tokens.get(first).map_or(at, |token| token.range.start.min(at))
}
