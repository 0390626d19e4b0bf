//! Members that the sources use and that the mapped types lack: those that the specification has renamed.

use std::collections::BTreeMap;

use camino::Utf8PathBuf;
use dotgen_analysis::model::{ParamSource, Src, TypeId, TypeKind};
use dotgen_syntax::suggestion::nearest;
use rustc_hash::{FxHashMap, FxHashSet};
use smol_str::SmolStr;
use tree_sitter::Node;

use super::finding::Difference;
use super::{Drift, DriftCode, DriftOptions, Repair, Severity, SourcePlace};
use crate::codels::{
    expected::Expected,
    files::{IndexedFile, Sources},
    mapping,
    source::{
        Span, parse,
        place::{field_words, renamable},
        preorder,
        types::{Scope, Types},
    },
};

/// A mapped structure and a name that is not a member of it.
type Unknown = (SmolStr, SmolStr);

/// A use of a member.
struct Use<'a> {
    file: &'a IndexedFile,
    span: Span,
    /// The shape that the use of its value requires.
    shape: Shape,
}

/// The shape of a type, as far as the use of a value shows it.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Shape {
    Any,
    /// It has elements.
    Elements,
    /// It has this member.
    Member(SmolStr),
}

pub(super) fn check(
    expected: &Expected<'_>,
    sources: &Sources,
    options: &DriftOptions,
    out: &mut Vec<Drift>,
) {
    let Ok(text) = mapping::types(expected) else {
        return;
    };
    let mut types = Types::default();
    types.read(&text, mapping::grammar(expected));
    let open: FxHashSet<SmolStr> =
        expected.spec.open.iter().map(|ty| expected.spelling(*ty)).collect();
    let mapped: FxHashMap<SmolStr, Vec<SmolStr>> = types
        .structures()
        // A type that is declared in a missing file has no known members.
        .filter(|structure| !structure.1.is_empty() && !open.contains(structure.0))
        .map(|(name, members)| (name.clone(), members.keys().cloned().collect()))
        .collect();
    // A name that one structure lacks may be a member of another one: any use of a member has to be read.
    let uses_members = |file: &IndexedFile| field_words(&file.text).next().is_some();
    let mut members = Members {
        expected,
        options,
        types: Types::default(),
        mapped: &mapped,
        unknown: BTreeMap::new(),
        used: FxHashSet::default(),
        parameters: BTreeMap::new(),
    };
    if !mapped.is_empty() && sources.all().any(uses_members) {
        for file in sources.all() {
            types.read(&file.text, file.index.grammar);
        }
        members.types = types;
        sources.all().for_each(|file| members.read(file));
    }
    members.read_parameters(sources);
    members.report(out);
}

/// A parameter of a codel: its file, the place of its declaration, and its uses.
type Parameter<'a> = (&'a IndexedFile, Span, Vec<Span>);

/// The uses of members of mapped structures in the sources.
struct Members<'a, 'e> {
    expected: &'e Expected<'e>,
    options: &'e DriftOptions,
    types: Types,
    mapped: &'e FxHashMap<SmolStr, Vec<SmolStr>>,
    unknown: BTreeMap<Unknown, Vec<Use<'a>>>,
    used: FxHashSet<Unknown>,
    /// Parameters of codels that refer to a member of the `ids` under another name, by that name and the
    /// member.
    parameters: BTreeMap<(SmolStr, SmolStr), Vec<Parameter<'a>>>,
}

impl<'a> Members<'a, '_> {
    fn read(&mut self, file: &'a IndexedFile) {
        let text = &file.text;
        let Some(tree) = parse(text, file.index.grammar) else {
            return;
        };
        let mut functions = Vec::new();
        preorder(tree.root_node(), |node| {
            let is_function = node.kind() == "function_definition";
            if is_function {
                functions.push(node);
            }
            !is_function
        });
        for function in functions.into_iter().filter(|function| !function.has_error()) {
            let scope = Scope::new(Some(function), text, &self.types);
            let mut found = Vec::new();
            preorder(function, |node| {
                if node.kind() == "field_identifier"
                    && let Some(structure) = structure_of(node, &scope, &self.types)
                    && self.mapped.contains_key(&structure)
                {
                    found.push((structure, node));
                }
                true
            });
            for (structure, node) in found {
                let span = node.byte_range();
                let name = SmolStr::from(text.get(span.clone()).unwrap_or_default());
                let shape = shape(node, text);
                if self
                    .types
                    .members_of(&structure)
                    .is_some_and(|member| member.contains_key(&name))
                {
                    self.used.insert((structure, name));
                } else if !self.options.trust.lacks_text {
                    let uses = self.unknown.entry((structure, name)).or_default();
                    uses.push(Use { file, span, shape });
                }
            }
        }
    }

    /// The structure of the `ids`, if the component has one.
    fn ids(&self) -> Option<SmolStr> {
        Some(self.expected.spelling(self.expected.component().ids?))
    }

    /// Reads the parameters that refer to members of the `ids`, and compares their names.
    fn read_parameters(&mut self, sources: &'a Sources) {
        let Some(ids) = self.ids() else { return };
        let component = self.expected.component();
        for function in &self.expected.functions {
            let Some(&at) = function.uses.first() else {
                continue;
            };
            let params = &component.codel(at).params;
            for file in sources.all() {
                for found in file.index.definitions(&function.name) {
                    // With another number of parameters, the position may refer to another parameter.
                    let wanted = function.shape.as_ref().map_or(0, |shape| shape.parameters.len());
                    if wanted != found.parameters.len() {
                        continue;
                    }
                    for (param, parameter) in params.iter().zip(&found.parameters) {
                        let of_ids =
                            matches!(param.source, ParamSource::Ids) && param.path.len() == 1;
                        let Some(name) = parameter.name.as_ref().filter(|_| of_ids) else {
                            continue;
                        };
                        if *name == param.name.as_str() {
                            self.used.insert((ids.clone(), name.clone()));
                        } else if !self.is_named(name) {
                            let places =
                                renamable(&file.text, file.index.grammar, found, name, &param.name);
                            let all = (name.clone(), param.name.as_str().into());
                            let all = self.parameters.entry(all).or_default();
                            all.push((file, parameter.span.clone(), places));
                        }
                    }
                }
            }
        }
    }

    /// True if the specification has a member of the `ids` or a parameter of that name.
    fn is_named(&self, name: &str) -> bool {
        let component = self.expected.component();
        let mut params = component.all_codels().flat_map(|codel| &component.codel(codel).params);
        let members = self.ids().and_then(|text| self.mapped.get(&text));
        let mut members = members.into_iter().flatten();
        params.any(|param| param.name == name)
            || members.any(|member| member == name)
            || self.options.trust.may_declare(name)
    }

    fn report(&self, out: &mut Vec<Drift>) {
        let ids = self.ids();
        let renamed = self.renamed();
        let mut followed: FxHashSet<(&SmolStr, &SmolStr)> = FxHashSet::default();
        for ((structure, name), uses) in &self.unknown {
            let to = renamed.get(&(structure.clone(), name.clone()));
            let mut places: Vec<(Utf8PathBuf, Span)> =
                uses.iter().map(|usage| (usage.file.path.clone(), usage.span.clone())).collect();
            if let Some(to) = to.filter(|_| ids.as_ref() == Some(structure))
                && let Some((key, all)) = self.parameters.get_key_value(&(name.clone(), to.clone()))
            {
                followed.insert((&key.0, &key.1));
                places.extend(all.iter().flat_map(|(file, _, places)| {
                    places.iter().map(|place| (file.path.clone(), place.clone()))
                }));
            }
            let repair = to.map(|to| Repair::FollowMember {
                structure: structure.as_str().into(),
                from: name.as_str().into(),
                to: to.as_str().into(),
                places,
            });
            let kind = Difference::NoMember {
                structure: structure.as_str().into(),
                member: name.as_str().into(),
            };
            for usage in uses {
                let spec = self.declared(structure, to).into_iter();
                out.push(Drift {
                    repairs: repair.iter().cloned().collect(),
                    found: Some(name.to_string()),
                    expected: to.map(ToString::to_string),
                    ..self.drift(kind.clone(), spec.collect(), usage.file, usage.span.clone())
                });
            }
        }
        self.report_parameters(&followed, out);
    }

    /// Reports parameters that seem to have the former name of their member.
    fn report_parameters(&self, followed: &FxHashSet<(&SmolStr, &SmolStr)>, out: &mut Vec<Drift>) {
        let Some(ids) = self.ids() else { return };
        let members = self.mapped.get(&ids);
        let names = || members.into_iter().flatten().map(SmolStr::as_str);
        for ((name, to), all) in &self.parameters {
            if followed.contains(&(name, to)) || nearest(name, names()) != Some(to) {
                continue;
            }
            let places: Vec<(Utf8PathBuf, Span)> = all
                .iter()
                .flat_map(|(file, _, places)| {
                    places.iter().map(|place| (file.path.clone(), place.clone()))
                })
                .collect();
            for (file, span, own) in all.iter().filter(|triple| !triple.2.is_empty()) {
                let kind = Difference::FormerMember {
                    parameter: name.as_str().into(),
                    member: to.as_str().into(),
                };
                let spec = self.declared(&ids, Some(to)).into_iter().collect();
                let span = own.first().unwrap_or(span).clone();
                let mut drift = self.drift(kind, spec, file, span);
                drift.severity = Severity::Hint;
                drift.found = Some(name.to_string());
                drift.expected = Some(to.to_string());
                drift.repairs = vec![Repair::FollowMember {
                    structure: ids.as_str().into(),
                    from: name.as_str().into(),
                    to: to.as_str().into(),
                    places: places.clone(),
                }];
                out.push(drift);
            }
        }
    }

    fn drift(&self, kind: Difference, spec: Vec<Src>, file: &IndexedFile, span: Span) -> Drift {
        let code = DriftCode::of(&kind);
        Drift {
            code,
            severity: code.severity(),
            kind,
            component: self.expected.component,
            spec,
            source: Some(SourcePlace { path: file.path.clone(), range: span }),
            expected: None,
            found: None,
            repairs: Vec::new(),
        }
    }

    /// The declaration of a member, or of the structure, in the specification.
    fn declared(&self, structure: &str, member: Option<&SmolStr>) -> Option<Src> {
        let spec = self.expected.spec;
        let mut all = (0u32..).map(TypeId).zip(&spec.types);
        let (_, ty) = all.find(|(id, ty)| {
            let has_members = matches!(
                ty.kind,
                TypeKind::Struct { .. } | TypeKind::Union { .. } | TypeKind::Exception { .. }
            );
            has_members && self.expected.spelling(*id) == structure
        })?;
        let TypeKind::Struct { members } = &ty.kind else {
            return Some(ty.src);
        };
        let mut members = members.iter().map(|member| spec.ty(*member));
        let named = members.find(|ty| ty.name.as_deref() == member.map(SmolStr::as_str));
        Some(named.map_or(ty.src, |member| member.src))
    }

    /// The present names of unknown members. A present name is the member that a parameter of the old name
    /// refers to, or the most similar name that is not used yet; the similarity must be the highest in both
    /// directions. A single remaining member is not sufficient evidence. The type of the member must allow
    /// its uses.
    fn renamed(&self) -> FxHashMap<Unknown, SmolStr> {
        let mut out = FxHashMap::default();
        let mut structures: Vec<&SmolStr> = self.unknown.keys().map(|key| &key.0).collect();
        structures.dedup();
        for structure in structures {
            let mut lost: Vec<&SmolStr> = Vec::new();
            lost.extend(self.unknown.keys().filter(|key| key.0 == *structure).map(|key| &key.1));
            let mut free: Vec<&SmolStr> =
                self.mapped.get(structure).into_iter().flatten().collect();
            free.retain(|text| !self.used.contains(&(structure.clone(), (*text).clone())));
            free.sort();
            let mut pairs: Vec<(SmolStr, SmolStr)> = Vec::new();
            for name in &lost {
                if let Some(to) = self.called(structure, name).filter(|text| free.contains(text)) {
                    pairs.push(((*name).clone(), to.clone()));
                }
            }
            lost.retain(|text| pairs.iter().all(|pair| pair.0 != **text));
            free.retain(|text| pairs.iter().all(|pair| pair.1 != **text));
            for name in &lost {
                let to = nearest(name, free.iter().map(|text| text.as_str()));
                let back = to.and_then(|to| nearest(to, lost.iter().map(|text| text.as_str())));
                if let Some(to) = to.filter(|_| back == Some(name)) {
                    pairs.push(((*name).clone(), to.into()));
                }
            }
            for (name, to) in pairs {
                let key = (structure.clone(), name);
                let uses = self.unknown.get(&key).into_iter().flatten();
                if uses.into_iter().all(|usage| self.fits(structure, &to, &usage.shape)) {
                    out.insert(key, to);
                }
            }
        }
        out
    }

    /// The member of the `ids` that parameters of a name refer to, if all refer to one member.
    fn called(&self, structure: &SmolStr, name: &SmolStr) -> Option<&SmolStr> {
        let of_ids = self.ids().as_ref() == Some(structure);
        let mut all = self.parameters.keys().filter(|key| of_ids && key.0 == *name);
        let (_, to) = all.next()?;
        all.next().is_none().then_some(to)
    }

    /// True if the type of a member allows a use.
    fn fits(&self, structure: &str, member: &str, shape: &Shape) -> bool {
        let members = self.types.members_of(structure);
        let Some(ty) = members.and_then(|types| types.get(member)) else {
            return false;
        };
        match shape {
            Shape::Any => true,
            Shape::Elements => self.types.element(ty).is_some(),
            Shape::Member(name) => {
                let inner = self.types.structure_of(ty);
                let inner = inner
                    .and_then(|structure| Some((self.types.members_of(&structure)?, structure)));
                inner.is_some_and(|(all, text)| {
                    all.contains_key(name) || self.unknown.contains_key(&(text, name.clone()))
                })
            }
        }
    }
}

/// The structure of the member that a node names.
fn structure_of(node: Node<'_>, scope: &Scope<'_>, types: &Types) -> Option<SmolStr> {
    let parent = node.parent()?;
    match parent.kind() {
        "field_expression" => {
            let of = scope.type_of(parent.child_by_field_name("argument")?)?;
            types.structure_of(&of)
        }
        "field_designator" => scope.designated(parent),
        _ => None,
    }
}

/// The shape that the use of a member requires.
fn shape(node: Node<'_>, text: &str) -> Shape {
    let Some(value) = node.parent().filter(|parent| parent.kind() == "field_expression") else {
        return Shape::Any;
    };
    let Some(around) = value.parent() else {
        return Shape::Any;
    };
    match around.kind() {
        "subscript_expression" if around.child_by_field_name("argument") == Some(value) => {
            Shape::Elements
        }
        "field_expression" if around.child_by_field_name("argument") == Some(value) => {
            let name = around.child_by_field_name("field");
            let name = name.and_then(|name| text.get(name.byte_range()));
            Shape::Member(name.unwrap_or_default().into())
        }
        _ => Shape::Any,
    }
}
