//! The methods of objects: the results of `$object method ?argument ...?` in a template.
//!
//! Everything except a filter given as a lambda is a pure function of the model and the current language; the
//! Tcl side caches pure answers.

use dotgen_analysis::model::{
    CodelKind, CodelRef, ComponentId, ComponentKind, Owner, Param, ServiceList, Spec, Src, TypeId,
};

use dotgen_analysis::release::Change;

use super::model::{Model, port_kind};
use super::object::{Lookup, Object, ParamRef};
use super::{Failure, tcl};
use crate::lang::{Anchor, LangError, MapObject, Place};

mod codel;
mod component;
mod param;
mod service;
mod task;
mod types;

pub(crate) use codel::boolean;

/// Evaluates a lambda of the template for an object, in the main interpreter.
pub(crate) type Lambda<'f> = dyn FnMut(&str, &str) -> Result<String, Failure> + 'f;

/// The answer to a question of the template.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Answer {
    pub(crate) text: String,
    /// True if the same question gets the same answer until more input is parsed.
    pub(crate) pure: bool,
}

impl Answer {
    pub(crate) fn pure(text: String) -> Answer {
        Answer { text, pure: true }
    }

    pub(crate) fn volatile(text: String) -> Answer {
        Answer { text, pure: false }
    }
}

type AnswerResult = Result<Answer, Failure>;

impl From<LangError> for Failure {
    fn from(error: LangError) -> Failure {
        if error.fatal { Failure::Fatal(error.message) } else { Failure::Error(error.message) }
    }
}

impl Model<'_> {
    /// Answers a method call. `words[0]` is the method, if any.
    pub(crate) fn call(
        &self,
        object: &Object,
        words: &[String],
        lambda: &mut Lambda<'_>,
    ) -> AnswerResult {
        match object {
            Object::Type(ty) => types::call(self, *ty, words, lambda),
            Object::Component(index) => component::call(self, *index, words, lambda),
            Object::Task(component, task) => task::task(self, *component, *task, words),
            Object::Port(component, port) => task::port(self, *component, *port, words),
            Object::Service(component, service) => {
                service::service(self, *component, *service, words)
            }
            Object::Remote(component, remote) => service::remote(self, *component, *remote, words),
            Object::Codel(component, codel) => codel::call(self, *component, *codel, words),
            Object::Param(component, param) => param::param(self, *component, *param, words),
            Object::Initializer(component, param, path) => {
                param::initializer(self, *component, *param, path, words)
            }
        }
    }

    /// Cheap methods without arguments, answered together with the first question about an object.
    pub(crate) fn cheap_methods(object: &Object) -> &'static [&'static str] {
        match object {
            Object::Type(_) => types::CHEAP,
            Object::Component(_) => component::CHEAP,
            Object::Task(..) => task::TASK_METHODS,
            Object::Port(..) => task::PORT_METHODS,
            Object::Service(..) => service::CHEAP,
            Object::Remote(..) => service::CHEAP_REMOTE,
            Object::Codel(..) => codel::CHEAP,
            Object::Param(..) => param::PARAM_METHODS,
            Object::Initializer(..) => param::INITIALIZER_METHODS,
        }
    }

    fn handle(&self, object: Object) -> Answer {
        Answer::pure(self.registry.handle(&object))
    }

    fn type_handle(&self, ty: TypeId) -> Answer {
        self.handle(Object::Type(ty))
    }

    fn list(&self, objects: impl IntoIterator<Item = Object>) -> Answer {
        Answer::pure(tcl::list(self.registry.handles(objects)))
    }

    fn type_list(&self, types: impl IntoIterator<Item = TypeId>) -> Answer {
        self.list(types.into_iter().map(Object::Type))
    }

    /// The place of an item without a context: `{FILE LINE COLUMN}`.
    fn location(&self, src: Src, anchor: Anchor<'_>) -> Option<Answer> {
        let place = self.places.place(src, anchor)?;
        Some(Answer::pure(tcl::list(elements(&place))))
    }

    /// `loc ?file|line|column|context?`: the place of an item, and its component or interface. Releases
    /// before contexts leave that element out of the list.
    fn place(
        &self,
        place: Option<Place>,
        context: Option<ComponentId>,
        arguments: &[String],
    ) -> Result<Option<Answer>, Failure> {
        let Some(place) = place else {
            return Ok(None);
        };
        let context = context.map(|context| self.registry.handle(&Object::Component(context)));
        let [file, line, column] = elements(&place);
        let all = [file, line, column, context.unwrap_or_default()];
        let Some(wanted) = arguments.first() else {
            let count = if self.spec.release.has(Change::ContextsOfPlaces) { 4 } else { 3 };
            return Ok(Some(Answer::pure(tcl::list(&all[..count]))));
        };
        let words = ["file", "line", "column", "context"];
        let found = words.iter().position(|word| word == wanted);
        let found = found.or_else(|| {
            let mut starting = (0..4).filter(|number| words[*number].starts_with(wanted.as_str()));
            starting.next().filter(|_| !wanted.is_empty() && starting.next().is_none())
        });
        if let Some(found) = found {
            Ok(Some(Answer::pure(all[found].clone())))
        } else {
            let problem = if words.iter().any(|word| word.starts_with(wanted.as_str()))
                && !wanted.is_empty()
            {
                "ambiguous"
            } else {
                "bad"
            };
            Err(Failure::Error(format!(
                "{problem} element \"{wanted}\": must be file, line, column, or context"
            )))
        }
    }

    /// [`Model::place`] of a node.
    fn place_of(
        &self,
        src: Src,
        anchor: Anchor<'_>,
        arguments: &[String],
    ) -> Result<Option<Answer>, Failure> {
        self.place(self.places.place(src, anchor), self.spec.body_of(src), arguments)
    }

    /// Parameters that pass a filter on their properties.
    fn params<'p>(
        &self,
        component: ComponentId,
        params: &'p [Param],
        reference: impl Fn(u32) -> ParamRef,
        filters: &[String],
        words: &[&str],
        matches: impl Fn(&'p Param, &str) -> bool,
    ) -> AnswerResult {
        let mut kept = Vec::new();
        for (index, param) in params.iter().enumerate() {
            let mut keep = filters.is_empty();
            for filter in filters {
                if keep {
                    break;
                }
                let word = words[find(words, filter, "direction")?];
                keep = matches(param, word);
            }
            if keep {
                kept.push(Object::Param(component, reference(index as u32)));
            }
        }
        Ok(self.list(kept))
    }

    /// The states that reach a codel of an owner, or the codel of one state.
    fn state_machine(
        &self,
        component: ComponentId,
        owner: Owner,
        state: Option<&String>,
    ) -> Answer {
        let declaration = self.spec.component(component);
        let mut states: Vec<(&str, TypeId, CodelRef)> = Vec::new();
        for (index, codel) in declaration.codels_of(owner).iter_enumerated() {
            let at = CodelRef { owner, index };
            for trigger in codel.triggers.iter().filter(|_| codel.kind == CodelKind::Fsm) {
                if !states.iter().any(|(name, ..)| *name == trigger.name) {
                    states.push((&trigger.name, trigger.event, at));
                }
            }
        }
        let Some(state) = state else {
            return self.type_list(states.into_iter().map(|(_, event, _)| event));
        };
        let name = match self.registry.object(state) {
            Some(Object::Type(ty)) => self.spec.ty(*ty).name.as_deref().unwrap_or_default(),
            _ => state,
        };
        match states.iter().find(|(text, ..)| *text == name) {
            Some((.., codel)) => self.handle(Object::Codel(component, *codel)),
            None => Answer::pure(String::new()),
        }
    }

    fn services(&self, component: ComponentId, list: &ServiceList) -> Answer {
        let all: Vec<_> = self.spec.component(component).services.keys().collect();
        let services = if list.all { &all } else { &list.services };
        self.list(services.iter().map(|service| Object::Service(component, *service)))
    }
}

/// `object types` and `object digest`.
pub(crate) fn closure(
    model: &Model<'_>,
    what: &str,
    object: &Object,
    arguments: &[String],
    lambda: &mut Lambda<'_>,
) -> AnswerResult {
    if what == "types" {
        component::types(model, object, arguments, lambda)
    } else {
        component::digest(model, object, arguments, lambda)
    }
}

/// A codel or type given as an object to a language procedure.
pub(crate) fn map_object(object: &Object) -> Option<MapObject> {
    match object {
        Object::Type(ty) => Some(MapObject::Type(*ty)),
        Object::Codel(component, codel) => Some(MapObject::Codel(*component, *codel)),
        _ => None,
    }
}

/// `class` of an object.
pub(crate) fn class(spec: &Spec, object: &Object) -> &'static str {
    match object {
        Object::Type(_) => "type",
        Object::Component(index) => match spec.component(*index).kind {
            ComponentKind::Component => "component",
            ComponentKind::Interface => "interface",
        },
        Object::Task(..) => "task",
        Object::Port(..) => "port",
        Object::Service(..) => "service",
        Object::Remote(..) => "remote",
        Object::Codel(..) => "codel",
        Object::Param(..) => "parameter",
        Object::Initializer(..) => "initializer",
    }
}

fn codel_kind_word(kind: CodelKind) -> &'static str {
    match kind {
        CodelKind::Validate => "validate",
        CodelKind::Simple => "simple",
        CodelKind::Fsm => "fsm",
    }
}

const CODEL_KINDS: &[&str] = &["validate", "simple", "fsm"];

fn dir_matches(param: &Param, word: &str) -> bool {
    param.dir.word() == word
}

fn find(words: &[&str], wanted: &str, what: &str) -> Result<usize, Failure> {
    tcl::find_word(words, wanted, what).map_err(Failure::Error)
}

/// The called method: the first word, or the default.
fn method(
    methods: &'static [&'static str],
    words: &[String],
    default: &'static str,
) -> Result<&'static str, Failure> {
    match words.first() {
        Some(word) => Ok(methods[find(methods, word, "subcommand")?]),
        None => Ok(default),
    }
}

fn wrong_args(usage: &str) -> Failure {
    Failure::Error(format!("wrong # args: should be \"{usage}\""))
}

fn undefined(method: &str) -> Failure {
    Failure::Error(format!("undefined member \"{method}\""))
}

impl Model<'_> {
    /// The failure for a member that a declaration does not have, with the declaration and its place.
    fn undefined_in(&self, method: &str, what: &str, name: &str, src: Src) -> Failure {
        let place = self.places.place(src, Anchor::First);
        let place = place.map(|place| format!(" ({}:{})", place.file, place.line));
        let place = place.unwrap_or_default();
        Failure::Error(format!("undefined member \"{method}\": {what} `{name}`{place} has none"))
    }
}

/// File, line and column.
fn elements(place: &Place) -> [String; 3] {
    [place.file.clone(), place.line.to_string(), place.column.to_string()]
}

fn text(value: &Option<String>) -> Option<Answer> {
    value.clone().map(Answer::pure)
}
