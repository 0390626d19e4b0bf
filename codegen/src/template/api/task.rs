//! Methods of tasks and ports.

use dotgen_analysis::model::{CodelKind, CodelRef, ComponentId, Owner, PortId, TaskId};

use super::{Answer, AnswerResult, Model, method, port_kind, text, undefined, wrong_args};
use crate::lang::Anchor;
use crate::template::object::{Lookup, Object};
use crate::template::throws::task_throws;

pub(super) const TASK_METHODS: &[&str] = &[
    "name",
    "component",
    "doc",
    "period",
    "delay",
    "priority",
    "scheduling",
    "stack",
    "services",
    "codels",
    "fsm",
    "throws",
    "loc",
    "class",
];

pub(super) const PORT_METHODS: &[&str] =
    &["name", "dir", "kind", "component", "type", "datatype", "doc", "throws", "loc", "class"];

pub(super) fn task(
    model: &Model<'_>,
    component: ComponentId,
    index: TaskId,
    words: &[String],
) -> AnswerResult {
    let task = model.spec.task(component, index);
    let method = method(TASK_METHODS, words, "name")?;
    let arguments = words.get(1..).unwrap_or_default();
    let most = if matches!(method, "fsm" | "loc") { 2 } else { 1 };
    if words.len() > most {
        return Err(wrong_args(match method {
            "fsm" => "$task fsm event",
            "loc" => "$task loc ?element?",
            _ => "$task subcommand",
        }));
    }
    let quantity = |quantity: &Option<dotgen_analysis::model::Quantity>| {
        quantity.as_ref().map(|quantity| model.type_handle(quantity.ty))
    };
    let answer = match method {
        "name" => Some(Answer::pure(task.name.to_string())),
        "component" => Some(model.handle(Object::Component(component))),
        "doc" => text(&task.doc),
        "period" => quantity(&task.period),
        "delay" => quantity(&task.delay),
        "priority" => quantity(&task.priority),
        "scheduling" => task.real_time.then(|| Answer::pure("real-time".into())),
        "stack" => quantity(&task.stack),
        "services" => {
            let services = model.spec.component(component).services.iter_enumerated();
            let own = services.filter(|(_, service)| service.task == Some(index));
            Some(model.list(own.map(|(at, _)| Object::Service(component, at))))
        }
        "codels" => {
            let codels = task.codels.iter_enumerated();
            let listed = codels.filter(|(_, codel)| codel.kind != CodelKind::Validate);
            Some(model.list(listed.map(|(at, _)| {
                let owner = Owner::Task(index);
                Object::Codel(component, CodelRef { owner, index: at })
            })))
        }
        "fsm" => Some(model.state_machine(component, Owner::Task(index), words.get(1))),
        "throws" => {
            let throws = task_throws(model.spec.component(component), task);
            Some(model.type_list(throws))
        }
        "loc" => model.place_of(task.src, Anchor::Keyword("task"), arguments)?,
        _ => Some(Answer::pure("task".into())),
    };
    answer.ok_or_else(|| model.undefined_in(method, "task", &task.name, task.src))
}

pub(super) fn port(
    model: &Model<'_>,
    component: ComponentId,
    index: PortId,
    words: &[String],
) -> AnswerResult {
    let port = model.spec.port(component, index);
    let method = method(PORT_METHODS, words, "name")?;
    let arguments = words.get(1..).unwrap_or_default();
    match (method, arguments.len()) {
        (_, 0) | ("loc", 1) => {}
        ("loc", _) => return Err(wrong_args("$port loc ?element?")),
        _ => return Err(wrong_args("$port subcommand")),
    }
    let answer = match method {
        "name" => Some(Answer::pure(port.name.to_string())),
        "dir" => Some(Answer::pure(port.dir.word().into())),
        "kind" => Some(Answer::pure(port_kind(port).into())),
        "component" => Some(model.handle(Object::Component(component))),
        "type" => Some(model.type_handle(port.ty)),
        "datatype" => Some(model.type_handle(port.data)),
        "doc" => text(&port.doc),
        "throws" => {
            let throws = &model.spec.component(component).throws;
            Some(model.type_list(throws.iter().copied()))
        }
        "loc" => model.place_of(port.src, Anchor::Keyword("port"), arguments)?,
        _ => Some(Answer::pure("port".into())),
    };
    answer.ok_or_else(|| undefined(method))
}
