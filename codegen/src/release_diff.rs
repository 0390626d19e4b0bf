//! The effects of another release of GenoM3 on a specification: digests, which decide if clients and servers
//! are compatible; mapped types; prototypes of codels; and the stubs that `skeleton` writes.

use dotgen_analysis::model::{Component, ComponentKind, Spec, TypeId, TypeKind};
use dotgen_analysis::release::{Change, Release};
use rustc_hash::FxHashMap;
use serde::Serialize;

use crate::lang::{Language, MapObject, Mapper, NoPlaces};
use crate::template::component_digests;

/// The differences between two releases.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct ReleaseDiff {
    /// Components and services whose digest changes: programs built for one release are incompatible with
    /// those built for the other.
    pub digests: Vec<DigestChange>,
    /// Named types whose definition changes in C or C++.
    pub types: Vec<TextChange>,
    /// Codels whose prototype changes.
    pub prototypes: Vec<TextChange>,
    /// Stubs that `skeleton` writes in only one of the releases.
    pub stubs: Vec<StubChange>,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct DigestChange {
    pub component: String,
    /// The service; `None` for the component itself.
    pub service: Option<String>,
    /// In the first release.
    pub from: String,
    /// In the second.
    pub to: String,
}

/// A generated text.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct TextChange {
    /// Full name of the type, or `component.codel`.
    pub name: String,
    /// `c` or `c++`.
    pub language: &'static str,
    /// In the first release; empty if it does not exist there.
    pub from: String,
    /// In the second; empty if it does not exist there.
    pub to: String,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct StubChange {
    /// The component whose skeleton it is.
    pub component: String,
    pub codel: String,
    /// The interface that declares it.
    pub declared_by: String,
    /// The release that writes the stub.
    pub only_in: Release,
}

/// Compares the models of one specification in two releases.
pub fn compare(from: &Spec, to: &Spec) -> ReleaseDiff {
    let mut diff = ReleaseDiff::default();
    for (old, new) in pairs(from, to) {
        let component = &from.components[old as usize];
        if component.kind == ComponentKind::Component {
            digests(from, old, to, new, &mut diff.digests);
        }
        let language = language(component);
        prototypes(from, old, to, new, language, &mut diff.prototypes);
        stubs(from, old, to, new, &mut diff.stubs);
    }
    let mut languages: Vec<Language> = from.components.iter().map(language).collect();
    if languages.is_empty() {
        languages.push(Language::C);
    }
    for language in [Language::C, Language::Cxx] {
        if languages.contains(&language) {
            types(from, to, language, &mut diff.types);
        }
    }
    diff
}

fn language(component: &Component) -> Language {
    let named = component.lang.as_deref().and_then(Language::from_name);
    named.unwrap_or_default()
}

/// The components and interfaces that exist in both, as indexes.
fn pairs(from: &Spec, to: &Spec) -> Vec<(u32, u32)> {
    let new = (0u32..).zip(&to.components);
    let new: FxHashMap<&str, u32> =
        new.map(|(index, component)| (component.name.as_str(), index)).collect();
    let old = (0u32..).zip(&from.components);
    old.filter_map(|(index, component)| Some((index, *new.get(component.name.as_str())?))).collect()
}

fn digests(from: &Spec, old: u32, to: &Spec, new: u32, out: &mut Vec<DigestChange>) {
    let component = from.components[old as usize].name.to_string();
    let later: FxHashMap<Option<String>, String> = component_digests(to, new).into_iter().collect();
    for (service, from) in component_digests(from, old) {
        if let Some(to) = later.get(&service).filter(|digest| **digest != from) {
            out.push(DigestChange { component: component.clone(), service, from, to: to.clone() });
        }
    }
}

fn prototypes(
    from: &Spec,
    old: u32,
    to: &Spec,
    new: u32,
    language: Language,
    out: &mut Vec<TextChange>,
) {
    let all = |spec: &Spec, index: u32| -> Vec<(String, String)> {
        let mapper = Mapper::new(spec, &NoPlaces, language);
        let component = &spec.components[index as usize];
        let codels = component.all_codels().map(|at| component.codel(at));
        codels
            .filter_map(|codel| {
                Some((codel.name.to_string(), mapper.prototype(index, codel, " ").ok()?))
            })
            .collect()
    };
    let later: FxHashMap<String, String> = all(to, new).into_iter().collect();
    let component = &from.components[old as usize].name;
    for (name, from) in all(from, old) {
        let Some(to) = later.get(&name).filter(|spec| **spec != from) else {
            continue;
        };
        let name = format!("{component}.{name}");
        if out.iter().all(|change| change.name != name) {
            out.push(TextChange { name, language: language.name(), from, to: to.clone() });
        }
    }
}

/// The codels of a component without a stub in its skeleton, with the interface of each.
fn codels_without_stub(spec: &Spec, index: u32) -> Vec<(String, String)> {
    if !spec.release.has(Change::PerComponentSkeletons) {
        return Vec::new();
    }
    let component = &spec.components[index as usize];
    let codels = component.all_codels().map(|at| component.codel(at));
    let external = codels.filter_map(|codel| {
        let body = spec.body_of(codel.src).filter(|body| *body != index)?;
        let owner = spec.components[body as usize].name.to_string();
        Some((codel.name.to_string(), owner))
    });
    external.collect()
}

fn stubs(from: &Spec, old: u32, to: &Spec, new: u32, out: &mut Vec<StubChange>) {
    // The older release writes no skeletons for interfaces.
    if from.components[old as usize].kind == ComponentKind::Interface {
        return;
    }
    let (before, after) = (codels_without_stub(from, old), codels_without_stub(to, new));
    let component = from.components[old as usize].name.to_string();
    let mut add = |list: &[(String, String)], other: &[(String, String)], only_in: Release| {
        for pair in list.iter().filter(|pair| !other.contains(pair)) {
            let change = StubChange {
                component: component.clone(),
                codel: pair.0.clone(),
                declared_by: pair.1.clone(),
                only_in,
            };
            if !out.contains(&change) {
                out.push(change);
            }
        }
    };
    add(&after, &before, from.release);
    add(&before, &after, to.release);
}

fn types(from: &Spec, to: &Spec, language: Language, out: &mut Vec<TextChange>) {
    let (before, after) = (definitions(from, language), definitions(to, language));
    let later: FxHashMap<&str, &str> =
        after.iter().map(|pair| (pair.0.as_str(), pair.1.as_str())).collect();
    let earlier: FxHashMap<&str, &str> =
        before.iter().map(|pair| (pair.0.as_str(), pair.1.as_str())).collect();
    let mut add = |name: &str, from: &str, to: &str| {
        out.push(TextChange {
            name: name.to_owned(),
            language: language.name(),
            from: from.to_owned(),
            to: to.to_owned(),
        });
    };
    for (name, text) in &before {
        let new = later.get(name.as_str()).copied().unwrap_or_default();
        if new != text {
            add(name, text, new);
        }
    }
    for (name, text) in &after {
        if !earlier.contains_key(name.as_str()) {
            add(name, "", text);
        }
    }
}

/// Named types with their definitions, without include guards and line marks.
fn definitions(spec: &Spec, language: Language) -> Vec<(String, String)> {
    let mapper = Mapper::new(spec, &NoPlaces, language);
    let mut out: Vec<(String, String)> = Vec::new();
    for (index, ty) in (0u32..).zip(&spec.types) {
        let special = matches!(ty.kind, TypeKind::Event | TypeKind::PauseEvent | TypeKind::Unknown);
        let id = TypeId(index);
        let Some(name) = spec.full_name(id).filter(|_| !special) else {
            continue;
        };
        let Ok(text) = mapper.mapping(&[MapObject::Type(id)], false) else {
            continue;
        };
        let kept = text.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
        let text: Vec<&str> = kept.collect();
        if !text.is_empty() && out.iter().all(|entry| entry.0 != name) {
            out.push((name, text.join("\n")));
        }
    }
    out
}
