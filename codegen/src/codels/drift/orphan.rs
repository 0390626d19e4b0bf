//! Functions that look like codels and that no specification names.

use dotgen_analysis::model::{CodelKind, CodelRef, Owner};
use dotgen_syntax::suggestion::nearest;
use rustc_hash::FxHashSet;

use super::finding::Difference;
use super::{Drift, DriftOptions, FunctionIn, Repair};
use crate::codels::{
    expected::{Expected, ExpectedFunction, cut_tag, owner_words},
    files::Sources,
    source::{Function, Layer},
};
use crate::lang::Language;

/// Orphans in file and text order.
pub(super) fn find<'a>(
    all: &[Expected<'_>],
    sources: &'a Sources,
    options: &DriftOptions,
) -> Vec<FunctionIn<'a>> {
    let named = |name: &str| {
        options.also_named.contains(name)
            || options.trust.may_declare(name)
            || all.iter().any(|expected| {
                let mut components = expected.spec.components.iter();
                components.any(|component| {
                    component.all_codels().any(|at| component.codel(at).name == name)
                })
            })
    };
    let components: Vec<&str> =
        all.iter().map(|expected| expected.component().name.as_str()).collect();
    let mut out = Vec::new();
    for file in sources.of_components(&components) {
        for function in &file.index().functions {
            let found = FunctionIn { file, function };
            if function.body.is_some()
                && function.is_global()
                && !function.is_static
                && all.iter().any(|expected| has_codel_shape(function, expected.language))
                && !named(&function.name)
                && (comment_names_codel(function) || !is_helper(found, sources))
            {
                out.push(found);
            }
        }
    }
    out
}

/// True if all names in specifications are known. With missing files, or text that does not parse, all codels
/// declared there would be orphans.
pub(super) fn are_certain(all: &[Expected<'_>], options: &DriftOptions) -> bool {
    let elsewhere = |expected: &Expected<'_>| expected.spec.lacks_declarations(expected.component);
    !options.trust.lacks_text && !all.iter().any(elsewhere)
}

/// True if a function takes the context and returns an event.
fn has_codel_shape(function: &Function, language: Language) -> bool {
    let event = function.result.layers.is_empty();
    if language == Language::Cxx {
        event && function.result.base == "genom::event"
    } else {
        let last = function.parameters.last();
        event
            && function.result.base == "genom_event"
            && last.is_some_and(|parameter| {
                parameter.ty.base == "genom_context" && parameter.ty.layers.is_empty()
            })
    }
}

fn comment_names_codel(function: &Function) -> bool {
    let mut comments = function.comments.iter().filter_map(|comment| comment.generated.as_ref());
    comments.any(|comment| comment.codel == function.name)
}

/// True if other functions use it, or if it has a prototype for them.
fn is_helper(input: FunctionIn<'_>, sources: &Sources) -> bool {
    let name = &input.function.name;
    let declared = |function: &Function| function.body.is_none() && function.name == *name;
    sources.all().any(|file| {
        file.index().functions.iter().any(|other| {
            let body = other.body.as_ref();
            declared(other)
                || other.name != *name && body.is_some_and(|body| body.mentions.contains(name))
        })
    })
}

/// The orphan that a codel without a function most likely refers to: the one whose comment names the same
/// owner and states, else the one with the most similar name.
pub(super) fn renamed<'a>(
    orphans: &[FunctionIn<'a>],
    function: &ExpectedFunction,
    expected: &Expected<'_>,
    sources: &Sources,
) -> Option<FunctionIn<'a>> {
    let mut said = orphans.iter().filter(|orphan| {
        let mut uses = function.uses.iter();
        uses.any(|&at| comment_names_owner(orphan.function, expected, at))
    });
    if let (Some(only), None) = (said.next(), said.next()) {
        return Some(*only);
    }
    let names = orphans.iter().map(|orphan| orphan.function.name.as_str());
    let name = nearest(&function.name, names)?;
    // The similarity must be the highest in both directions.
    let functions = expected.functions.iter().map(|function| function.name.as_str());
    let missing = functions.filter(|name| {
        let mut files = sources.all();
        !files.any(|file| file.index().definitions(name).next().is_some())
    });
    let back = nearest(name, missing)?;
    let found = orphans.iter().find(|orphan| orphan.function.name == name);
    found.filter(|_| back == function.name.as_str()).copied()
}

/// True if its comment names the owner of a codel, and its states if it has some.
fn comment_names_owner(function: &Function, expected: &Expected<'_>, at: CodelRef) -> bool {
    let component = expected.component();
    let codel = component.codel(at);
    let mut comments = function.comments.iter().filter_map(|comment| comment.generated.as_ref());
    comments.any(|comment| {
        let said = comment.triggers.as_deref().unwrap_or_default().iter();
        let said: FxHashSet<&str> =
            said.map(|trigger| cut_tag(trigger, &component.name).1).collect();
        let now = codel.triggers.iter().map(|trigger| trigger.name.as_str()).collect();
        comment.codel == function.name
            && comment.owner == *owner_words(component, at.owner).1
            && (comment.owner_kind == "task") == matches!(at.owner, Owner::Task(_))
            && comment.validation == (codel.kind == CodelKind::Validate)
            && said == now
    })
}

pub(super) fn report(orphan: &FunctionIn<'_>, all: &[Expected<'_>]) -> Option<Drift> {
    let function = orphan.function;
    let expected = all.iter().find(|expected| has_codel_shape(function, expected.language))?;
    let name = &function.name;
    let mut repairs = Vec::new();
    let references = function.parameters.iter().flat_map(|parameter| &parameter.ty.layers);
    if function.known
        && !references.clone().any(|reference| matches!(reference, Layer::Function { .. }))
    {
        repairs.push(Repair::DeclareCodel {
            name: name.as_str().into(),
            path: orphan.file.path.clone(),
            start: function.span.start,
        });
    }
    let kind = Difference::Orphan { function: name.as_str().into() };
    Some(Drift {
        source: Some(orphan.at(function.name_span.clone())),
        repairs,
        ..Drift::new(kind, expected.component, Vec::new())
    })
}
