//! Methods of services and remotes.

use dotgen_analysis::model::{CodelKind, CodelRef, ComponentId, Owner, RemoteId, ServiceId};

use super::{
    Answer, AnswerResult, CODEL_KINDS, Model, codel_kind_word, dir_matches, find, method, text,
    undefined, wrong_args,
};
use crate::lang::Anchor;
use crate::template::closure;
use crate::template::mutex::service_mutex;
use crate::template::object::{Lookup, Object, ParamRef};
use crate::template::throws::{remote_throws, service_throws};

const METHODS: &[&str] = &[
    "name",
    "kind",
    "component",
    "doc",
    "task",
    "validate",
    "codels",
    "parameters",
    "fsm",
    "throws",
    "interrupts",
    "before",
    "after",
    "mutex",
    "digest",
    "loc",
    "class",
];

pub(super) const CHEAP: &[&str] = &[
    "name",
    "kind",
    "component",
    "doc",
    "task",
    "validate",
    "codels",
    "parameters",
    "throws",
    "interrupts",
    "class",
];

const REMOTE_METHODS: &[&str] =
    &["name", "kind", "component", "type", "parameters", "throws", "digest", "loc", "class"];

pub(super) const CHEAP_REMOTE: &[&str] =
    &["name", "kind", "component", "type", "parameters", "throws", "class"];

const DIRECTIONS: &[&str] = &["local", "in", "out", "inout"];

pub(super) fn service(
    model: &Model<'_>,
    component: ComponentId,
    index: ServiceId,
    words: &[String],
) -> AnswerResult {
    let service = model.spec.service(component, index);
    let method = method(METHODS, words, "name")?;
    let arguments = words.get(1..).unwrap_or_default();
    match method {
        "parameters" | "codels" => {}
        "fsm" if arguments.len() > 1 => return Err(wrong_args("$service fsm ?event?")),
        "fsm" => {}
        "loc" if arguments.len() > 1 => return Err(wrong_args("$service loc ?element?")),
        "loc" => {}
        _ if arguments.is_empty() => {}
        _ => return Err(wrong_args("$service subcommand")),
    }
    let codels = |wanted: &dyn Fn(CodelKind) -> bool| {
        let codels = service.codels.iter_enumerated();
        let listed = codels.filter(|(_, codel)| wanted(codel.kind));
        model.list(listed.map(|(at, _)| {
            let owner = Owner::Service(index);
            Object::Codel(component, CodelRef { owner, index: at })
        }))
    };
    let answer = match method {
        "name" => Some(Answer::pure(service.name.to_string())),
        "kind" => Some(Answer::pure(service.kind.word().into())),
        "component" => Some(model.handle(Object::Component(component))),
        "doc" => text(&service.doc),
        "task" => service.task.map(|task| model.handle(Object::Task(component, task))),
        "validate" => Some(codels(&|kind| kind == CodelKind::Validate)),
        "codels" => {
            let mut kinds = Vec::new();
            for filter in arguments.iter().filter(|_| !service.codels.is_empty()) {
                kinds.push(CODEL_KINDS[find(CODEL_KINDS, filter, "kind")?]);
            }
            Some(codels(&|kind| arguments.is_empty() || kinds.contains(&codel_kind_word(kind))))
        }
        "parameters" => Some(model.params(
            component,
            &service.params,
            |at| ParamRef::Service(index, at),
            arguments,
            DIRECTIONS,
            dir_matches,
        )?),
        "fsm" => Some(model.state_machine(component, Owner::Service(index), arguments.first())),
        "throws" => {
            let throws = service_throws(model.spec.component(component), index);
            Some(model.type_list(throws))
        }
        "interrupts" => Some(model.services(component, &service.interrupts)),
        "before" => Some(model.services(component, &service.before)),
        "after" => Some(model.services(component, &service.after)),
        "mutex" => {
            let codels = service_mutex(model.spec, model.spec.component(component), index);
            Some(model.list(codels.into_iter().map(|at| Object::Codel(component, at))))
        }
        "digest" => {
            let object = Object::Service(component, index);
            let digest = closure::digest(model, &object, &mut |_| Ok(true))?;
            Some(Answer::pure(digest))
        }
        "loc" => model.place_of(service.src, Anchor::Keyword(service.kind.word()), arguments)?,
        _ => Some(Answer::pure("service".into())),
    };
    answer.ok_or_else(|| undefined(method))
}

pub(super) fn remote(
    model: &Model<'_>,
    component: ComponentId,
    index: RemoteId,
    words: &[String],
) -> AnswerResult {
    let remote = model.spec.remote(component, index);
    let method = method(REMOTE_METHODS, words, "name")?;
    let arguments = words.get(1..).unwrap_or_default();
    if method != "parameters" && !arguments.is_empty() {
        return Err(wrong_args("$remote subcommand"));
    }
    let answer = match method {
        "name" => Some(Answer::pure(remote.name.to_string())),
        "kind" => Some(Answer::pure(remote.kind.word().into())),
        "component" => Some(model.handle(Object::Component(component))),
        "type" => Some(model.type_handle(remote.ty)),
        "parameters" => Some(model.params(
            component,
            &remote.params,
            |at| ParamRef::Remote(index, at),
            arguments,
            &DIRECTIONS[1..],
            dir_matches,
        )?),
        "throws" => {
            let throws = remote_throws(model.spec.component(component), remote);
            Some(model.type_list(throws))
        }
        "digest" => {
            let object = Object::Remote(component, index);
            let digest = closure::digest(model, &object, &mut |_| Ok(true))?;
            Some(Answer::pure(digest))
        }
        "loc" => model.location(remote.src, Anchor::Keyword(remote.kind.word())),
        _ => Some(Answer::pure("remote".into())),
    };
    answer.ok_or_else(|| undefined(method))
}
