//! The declaration in the specification for a name in a source.

use std::ops::Range;

use camino::Utf8Path;
use dotgen_analysis::model::{Src, TypeId, TypeKind};
use smol_str::SmolStr;
use tree_sitter::Node;

use super::expected::{Expected, ExpectedFunction};
use super::files::{IndexedFile, Sources};
use super::mapping;
use super::source::place::{opened, qualifiers};
use super::source::types::{Scope, Types, scopes};
use super::source::{ctype::declared_name, parse};

/// Suffix of the name of the structure with the data of an exception.
const DETAIL: &str = "_detail";

/// A name in a source, and the declarations it refers to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Origin {
    /// The place of the name in the source, in bytes.
    pub range: Range<usize>,
    /// The places of its declarations: a function may implement several codels, each with its own parameters.
    pub declared: Vec<Src>,
}

/// The declarations of the name at an offset of a source: a member, type, exception, enumerator or constant,
/// a state, a codel, or a parameter of a codel. `None` for any other name, and for a member of a value whose
/// type is unknown.
pub fn origin(
    expected: &Expected<'_>,
    sources: &Sources,
    path: &Utf8Path,
    offset: usize,
) -> Option<Origin> {
    let file = sources.file(path)?;
    let tree = parse(&file.text, file.grammar)?;
    let root = tree.root_node();
    let ends_before = offset.checked_sub(1).into_iter().map(|before| (before, offset));
    let mut nodes = std::iter::once((offset, offset + 1))
        .chain(ends_before)
        .filter_map(|(start, end)| root.descendant_for_byte_range(start, end));
    let node = nodes.find(|node| node.kind().ends_with("identifier"))?;
    let name = file.text.get(node.byte_range())?;
    let lookup = Lookup { expected, file, node, name };
    let mut declared = match node.kind() {
        "field_identifier" => lookup.member(sources).into_iter().collect(),
        _ => lookup.identifier(root),
    };
    declared.dedup();
    (!declared.is_empty()).then(|| Origin { range: node.byte_range(), declared })
}

/// The lookup of one name.
struct Lookup<'a> {
    expected: &'a Expected<'a>,
    file: &'a IndexedFile,
    node: Node<'a>,
    name: &'a str,
}

impl<'a> Lookup<'a> {
    /// The node of the function around the name.
    fn function(&self) -> Option<Node<'a>> {
        let mut at = self.node.parent();
        while let Some(node) = at.filter(|parent| parent.kind() != "function_definition") {
            at = node.parent();
        }
        at
    }

    /// The codels whose function is around the name.
    fn codels(&self) -> Option<(&'a ExpectedFunction, &'a super::source::Function)> {
        let around = self.file.index().function_at(self.node.start_byte())?;
        Some((self.expected.function(&around.name)?, around))
    }

    fn member(&self, sources: &Sources) -> Option<Src> {
        let mut types = Types::default();
        let mapped = mapping::types(self.expected).ok()?;
        types.read(&mapped, mapping::grammar(self.expected));
        // Other sources are not visible in this one.
        let headers = sources.headers.iter();
        for file in headers.chain([self.file]) {
            types.read(&file.text, file.grammar);
        }
        let scope = Scope::new(self.function(), &self.file.text, &types);
        let parent = self.node.parent()?;
        let structure = match parent.kind() {
            "field_expression" => {
                let of = parent.child_by_field_name("argument")?;
                types.structure_of(&scope.type_of(of)?)
            }
            "field_designator" => scope.designated(parent),
            _ => None,
        }?;
        let spec = self.expected.spec;
        let declared = spec.types.iter_enumerated();
        let mut found = declared.filter_map(|(id, ty)| {
            let (TypeKind::Struct { members }
            | TypeKind::Union { members, .. }
            | TypeKind::Exception { members }) = &ty.kind
            else {
                return None;
            };
            let mut members = members.iter().map(|member| spec.ty(*member));
            let member = members.find(|member| member.name.as_deref() == Some(self.name))?;
            let spelling = self.expected.spelling(id);
            let detail = || structure.strip_suffix(DETAIL) == Some(spelling.as_str());
            (structure == spelling || detail()).then_some(member.src)
        });
        found.next()
    }

    fn identifier(&self, root: Node<'a>) -> Vec<Src> {
        let path = qualifiers(self.node, &self.file.text);
        if path.is_empty() {
            let no_types = Types::default();
            let scope = Scope::new(self.function(), &self.file.text, &no_types);
            if scope.has(self.name) {
                return self.parameter();
            }
        }
        for spelling in self.spellings(&path, root) {
            let found = self.declared(&spelling);
            if !found.is_empty() {
                return found;
            }
        }
        Vec::new()
    }

    /// The parameters of the codels whose function has a parameter of the name, if nothing shadows it.
    fn parameter(&self) -> Vec<Src> {
        let named =
            |parameter: &super::source::Parameter| parameter.name.as_deref() == Some(self.name);
        let Some((function, around)) = self.codels().filter(|_| !self.is_shadowed()) else {
            return Vec::new();
        };
        let Some(position) = around.parameters.iter().position(named) else {
            return Vec::new();
        };
        let component = self.expected.component();
        let uses = function.uses.iter();
        let params = uses.filter_map(|at| component.codel(*at).params.get(position));
        params.map(|param| param.src).collect()
    }

    /// Returns true if a block around the name declares a variable of the name.
    fn is_shadowed(&self) -> bool {
        let text = &self.file.text;
        let mut at = self.node.parent();
        while let Some(node) = at.filter(|parent| parent.kind() != "function_definition") {
            let mut cursor = node.walk();
            let declared = node.named_children(&mut cursor).any(|child| {
                let mut cursor = child.walk();
                let mut names = child
                    .children_by_field_name("declarator", &mut cursor)
                    .filter_map(declared_name);
                child.kind() == "declaration"
                    && names.any(|name| text.get(name.byte_range()) == Some(self.name))
            });
            if declared {
                return true;
            }
            at = node.parent();
        }
        false
    }

    /// The possible full names: as written, in the enclosing scopes, and in the scopes that the file opens.
    fn spellings(&self, path: &[SmolStr], root: Node<'a>) -> Vec<SmolStr> {
        let full = |around: &[SmolStr]| {
            let mut all = around.to_vec();
            all.extend_from_slice(path);
            all.push(self.name.into());
            all.retain(|text| !text.is_empty());
            SmolStr::from(all.join("::"))
        };
        let around = scopes(self.node, &self.file.text);
        let outwards = (0..=around.len()).rev().map(|scope| full(&around[..scope]));
        let opened = opened(root, &self.file.text);
        outwards.chain(opened.iter().map(|snapshot| full(snapshot))).collect()
    }

    /// The declarations of a full name.
    fn declared(&self, spelling: &str) -> Vec<Src> {
        let (expected, component) = (self.expected, self.expected.component());
        if let Some(function) = expected.function(spelling) {
            let uses = function.uses.iter();
            return uses.map(|at| component.codel(*at).src).collect();
        }
        if let Some(&event) = expected.events.get(spelling) {
            return self.state(event).into_iter().collect();
        }
        if let Some(name) = spelling.strip_suffix(DETAIL)
            && let Some(&exception) = expected.exceptions.get(name)
        {
            return vec![expected.spec.ty(exception).src];
        }
        let types = expected.spec.types.iter_enumerated();
        let mut named = types.filter(|(id, ty)| {
            let member =
                matches!(ty.kind, TypeKind::StructMember { .. } | TypeKind::UnionMember { .. });
            ty.name.is_some() && !member && expected.spelling(*id) == spelling
        });
        named.next().map(|ty| ty.1.src).into_iter().collect()
    }

    /// The declaration of an event's state: the codel that the event triggers, first in the service of the
    /// function around the name.
    fn state(&self, event: TypeId) -> Option<Src> {
        let component = self.expected.component();
        let codels = || component.all_codels().map(|at| (at.owner, component.codel(at)));
        let mut states = codels().flat_map(|(_, codel)| codel.triggers.iter().chain(&codel.yields));
        let state = states.find(|state| state.event == event)?;
        let here = self.codels().map(|codel| codel.0.uses.iter().map(|at| at.owner));
        let here: Vec<_> = here.into_iter().flatten().collect();
        let triggers = |near: bool| {
            let codels = codels().filter(move |codel| !near || here.contains(&codel.0));
            codels.flat_map(|(_, codel)| &codel.triggers).find(|trigger| trigger.name == state.name)
        };
        let found = triggers.clone()(true).or_else(|| triggers(false));
        Some(found.unwrap_or(state).src)
    }
}
