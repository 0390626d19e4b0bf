//! Methods of components and interfaces.

use std::sync::LazyLock;

use dotgen_analysis::model::{ComponentId, PortDir};
use dotgen_analysis::release::Change;

use super::{
    Answer, AnswerResult, CODEL_KINDS, Lambda, Model, class, codel_kind_word, find, method,
    port_kind, text, undefined, wrong_args,
};
use crate::lang::Anchor;
use crate::template::closure::{self, Visibility};
use crate::template::object::{Lookup, Object};
use crate::template::throws::component_throws;
use crate::template::{Failure, tcl};

/// In order of the messages; `stack` is new in 2.99.40.
const METHODS: &[&str] = &[
    "name",
    "doc",
    "ids",
    "version",
    "language",
    "email",
    "require",
    "codels-require",
    "clock-rate",
    "stack",
    "throws",
    "tasks",
    "ports",
    "services",
    "remotes",
    "codels",
    "types",
    "digest",
    "loc",
    "class",
];

/// The methods of older releases.
static BEFORE_STACK: LazyLock<Vec<&'static str>> =
    LazyLock::new(|| METHODS.iter().copied().filter(|method| *method != "stack").collect());

pub(super) const CHEAP: &[&str] = &[
    "name", "doc", "ids", "version", "language", "email", "throws", "tasks", "ports", "services",
    "remotes", "codels", "class",
];

pub(super) fn call(
    model: &Model<'_>,
    index: ComponentId,
    words: &[String],
    lambda: &mut Lambda<'_>,
) -> AnswerResult {
    let component = model.spec.component(index);
    let method = if model.spec.release.has(Change::ComponentStack) {
        method(METHODS, words, "name")?
    } else {
        method(&BEFORE_STACK, words, "name")?
    };
    let arguments = words.get(1..).unwrap_or_default();
    match method {
        "ports" | "codels" | "types" | "digest" | "loc" => {}
        _ if arguments.is_empty() => {}
        _ => return Err(wrong_args("$component subcommand")),
    }
    let answer = match method {
        "name" => Some(Answer::pure(component.name.to_string())),
        "doc" => text(&component.doc),
        "ids" => component.ids.map(|ty| model.type_handle(ty)),
        "version" => text(&component.version),
        "language" => text(&component.lang),
        "email" => text(&component.email),
        "require" => Some(Answer::pure(tcl::list(&component.requires))),
        "codels-require" => Some(Answer::pure(tcl::list(&component.codels_requires))),
        "clock-rate" => component.clock_rate.as_ref().map(|rate| model.type_handle(rate.ty)),
        "stack" => component.stack.as_ref().map(|stack| model.type_handle(stack.ty)),
        "throws" => Some(model.type_list(component_throws(component))),
        "tasks" => Some(model.list(component.tasks.keys().map(|at| Object::Task(index, at)))),
        "ports" => Some(ports(model, index, arguments)?),
        "services" => {
            let services = component.services.keys();
            Some(model.list(services.map(|at| Object::Service(index, at))))
        }
        "remotes" => {
            let remotes = component.remotes.keys();
            Some(model.list(remotes.map(|at| Object::Remote(index, at))))
        }
        "codels" => Some(codels(model, index, arguments)?),
        "types" => {
            if arguments.is_empty() {
                return Err(wrong_args("$component types visibility ?filter?"));
            }
            let object = Object::Component(index);
            return types(model, &object, arguments, lambda);
        }
        "digest" => return digest(model, &Object::Component(index), arguments, lambda),
        // Items outside of every other component.
        "loc" => model.place(model.places.place(component.src, Anchor::First), None, arguments)?,
        _ => Some(Answer::pure(class(model.spec, &Object::Component(index)).into())),
    };
    answer.ok_or_else(|| undefined(method))
}

/// Ports that pass every filter.
fn ports(model: &Model<'_>, index: ComponentId, filters: &[String]) -> AnswerResult {
    const WORDS: &[&str] = &["in", "out", "simple", "multiple"];
    let mut kept = Vec::new();
    for (at, port) in model.spec.component(index).ports.iter_enumerated() {
        let mut keep = true;
        for filter in filters {
            keep &= match WORDS[find(WORDS, filter, "filter")?] {
                "in" => port.dir == PortDir::In,
                "out" => port.dir == PortDir::Out,
                kind => port_kind(port) == kind,
            };
        }
        if keep {
            kept.push(Object::Port(index, at));
        }
    }
    Ok(model.list(kept))
}

/// Codels that pass any filter.
fn codels(model: &Model<'_>, index: ComponentId, filters: &[String]) -> AnswerResult {
    let kinds: Vec<&str> = filters
        .iter()
        .map(|filter| Ok(CODEL_KINDS[find(CODEL_KINDS, filter, "kind")?]))
        .collect::<Result<_, Failure>>()?;
    let component = model.spec.component(index);
    let kept = component.all_codels().filter(|at| {
        kinds.is_empty() || kinds.contains(&codel_kind_word(component.codel(*at).kind))
    });
    Ok(model.list(kept.map(|at| Object::Codel(index, at))))
}

/// `object types OBJ VISIBILITY ?LAMBDA?`.
pub(in crate::template) fn types(
    model: &Model<'_>,
    object: &Object,
    arguments: &[String],
    lambda: &mut Lambda<'_>,
) -> AnswerResult {
    let (visibility, filter) = match arguments {
        [visibility] => (visibility, None),
        [visibility, filter] => (visibility, Some(filter)),
        _ => return Err(wrong_args("object types object visibility ?filter?")),
    };
    let visibility = match visibility.as_str() {
        "public" => Visibility::Public,
        "extern" => Visibility::Extern,
        "private" => Visibility::Private,
        other => {
            return Err(Failure::Error(format!(
                "bad parameter {other}: must be public, extern or private"
            )));
        }
    };
    let mut keep = filter_of(model, filter, lambda);
    let types = match object {
        Object::Type(ty) => closure::types_of_type(model, *ty, &mut keep)?,
        Object::Component(index) if class(model.spec, object) == "component" => {
            closure::types_of_component(model, *index, visibility, &mut keep)?
        }
        other => {
            return Err(Failure::Error(format!(
                "bad genom object type {}",
                class(model.spec, other)
            )));
        }
    };
    Ok(Answer { pure: filter.is_none(), ..model.type_list(types) })
}

/// `object digest OBJ ?LAMBDA?`.
pub(in crate::template) fn digest(
    model: &Model<'_>,
    object: &Object,
    arguments: &[String],
    lambda: &mut Lambda<'_>,
) -> AnswerResult {
    if arguments.len() > 1 {
        return Err(wrong_args("object digest object ?filter?"));
    }
    let filter = arguments.first();
    let mut keep = filter_of(model, filter, lambda);
    Ok(Answer { text: closure::digest(model, object, &mut keep)?, pure: filter.is_none() })
}

fn filter_of<'f>(
    model: &'f Model<'_>,
    filter: Option<&'f String>,
    lambda: &'f mut Lambda<'_>,
) -> impl FnMut(&Object) -> Result<bool, Failure> + 'f {
    move |object| {
        let Some(filter) = filter else {
            return Ok(true);
        };
        let answer = lambda(filter, &model.registry.handle(object))?;
        parse_boolean(&answer)
            .ok_or_else(|| Failure::Error(format!("expected boolean value but got \"{answer}\"")))
    }
}

/// A Tcl boolean.
pub(super) fn parse_boolean(text: &str) -> Option<bool> {
    let word = text.trim().to_ascii_lowercase();
    if let Ok(number) = word.parse::<f64>() {
        return Some(number != 0.0);
    }
    let starts = |full: &str, least: usize| word.len() >= least && full.starts_with(&word);
    if starts("true", 1) || starts("yes", 1) || starts("on", 2) {
        Some(true)
    } else if starts("false", 1) || starts("no", 1) || starts("off", 2) {
        Some(false)
    } else {
        None
    }
}
