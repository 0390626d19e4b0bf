//! Methods of codels.

use dotgen_analysis::model::{CodelRef, ComponentId, Owner};

use super::{Answer, AnswerResult, Model, method, wrong_args};
use crate::lang::Anchor;
use crate::template::mutex::codel_mutex;
use crate::template::object::{Lookup, Object, ParamRef};
use crate::template::{Failure, tcl};

const METHODS: &[&str] = &[
    "name",
    "kind",
    "parameters",
    "yields",
    "triggers",
    "task",
    "service",
    "mutex",
    "cname",
    "signature",
    "invoke",
    "loc",
    "class",
    "wcet",
];

pub(super) const CHEAP: &[&str] = &[
    "name",
    "kind",
    "parameters",
    "yields",
    "triggers",
    "task",
    "service",
    "cname",
    "class",
    "wcet",
];

const FILTERS: &[&str] = &["in", "out", "inout", "ids", "local", "port", "remote"];

pub(super) fn call(
    model: &Model<'_>,
    component: ComponentId,
    at: CodelRef,
    words: &[String],
) -> AnswerResult {
    let owner = model.spec.component(component);
    let codel = owner.codel(at);
    let method = method(METHODS, words, "name")?;
    let arguments = words.get(1..).unwrap_or_default();
    let usage = |usage: &str| {
        let handle = model.registry.handle(&Object::Codel(component, at));
        wrong_args(&format!("{handle} {method} {usage}"))
    };
    match method {
        "parameters" => {}
        "signature" if arguments.len() > 2 => return Err(usage("?separator? ?location?")),
        "signature" => {}
        "invoke" if arguments.len() != 1 => return Err(usage("params")),
        "invoke" => {}
        "loc" if arguments.len() > 1 => return Err(wrong_args("$codel loc ?element?")),
        "loc" => {}
        _ if arguments.is_empty() => {}
        _ => return Err(wrong_args("$codel subcommand")),
    }
    let mapper = model.mapper();
    let answer = match method {
        "name" => Some(Answer::pure(codel.name.to_string())),
        "kind" => Some(Answer::pure(if codel.is_async { "async" } else { "sync" }.into())),
        "parameters" => Some(model.params(
            component,
            &codel.params,
            |param| ParamRef::Codel(at, param),
            arguments,
            FILTERS,
            |param, word| match word {
                "in" | "out" | "inout" => param.dir.word() == word,
                _ => param.source.word() == word,
            },
        )?),
        "yields" => Some(model.type_list(codel.yields.iter().map(|state| state.event))),
        "triggers" => Some(model.type_list(codel.triggers.iter().map(|state| state.event))),
        "task" => {
            let task = owner.task_of(at);
            task.map(|task| model.handle(Object::Task(component, task)))
        }
        "service" => match at.owner {
            Owner::Service(service) => Some(model.handle(Object::Service(component, service))),
            Owner::Task(_) => None,
        },
        "mutex" => {
            let (codels, services) = codel_mutex(model.spec, owner, at);
            let codels = codels.into_iter().map(|at| Object::Codel(component, at));
            let services = services.into_iter();
            let services = services.map(|service| Object::Service(component, service));
            Some(model.list(codels.chain(services)))
        }
        "cname" => Some(Answer::pure(mapper.cname(&codel.name)?)),
        "signature" => {
            let separator = arguments.first().map_or(" ", String::as_str);
            let location = match arguments.get(1) {
                Some(text) => boolean(text)?,
                None => false,
            };
            Some(Answer::pure(mapper.signature(component, codel, separator, location)?))
        }
        "invoke" => {
            let arguments = tcl::parse_list(&arguments[0]).map_err(Failure::Error)?;
            Some(Answer::pure(mapper.invoke(component, codel, &arguments)?))
        }
        "loc" => model.place_of(codel.src, Anchor::First, arguments)?,
        "wcet" => codel.wcet.as_ref().map(|wcet| model.type_handle(wcet.ty)),
        _ => Some(Answer::pure("codel".into())),
    };
    answer.ok_or_else(|| model.undefined_in(method, "codel", &codel.name, codel.src))
}

/// The boolean argument of a language procedure.
///
/// # Errors
/// Fails for text that is not a Tcl boolean.
pub(crate) fn boolean(text: &str) -> Result<bool, Failure> {
    super::component::parse_boolean(text)
        .ok_or_else(|| Failure::Error(format!("expected boolean value but got \"{text}\"")))
}
