//! Findings about components: their properties, ports, services and parameters.

use std::fmt;

use dotgen_syntax::findings;

use crate::{
    finding::names::Described,
    fixes::{FixSite, TextFix},
    model::Name,
    release::Release,
};

/// The component that imports a service, if it is not its own.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct ImportedBy(pub Option<Name>);

impl fmt::Display for ImportedBy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Some(component) => write!(f, ", imported by `{component}`,"),
            None => Ok(()),
        }
    }
}

findings! {
    /// An invalid declaration in a component.
    pub enum DeclarationProblem {
        "prop-duplicate" PropertyTwice { word: &'static str }
            => "`{word}` is given twice", "keep one of them";
        "prop-duplicate" PropertyImported { interface: Name, word: &'static str }
            => "interface `{interface}` brings a `{word}`, but the component has one already",
               "keep one of them";
        "prop-duplicate" TaskPropertyImported { task: Name, word: &'static str }
            => "task `{task}` of the interface has a `{word}`, and so has the task of that name here",
               "keep one of them";
        "prop-duplicate" ServicePropertyImported { service: Name, word: &'static str }
            => "`{service}` has a `{word}` both here and in the interface", "keep one of them";
        "prop-not-in-component" NotInComponent { word: &'static str, home: &'static str }
            => "`{word}` cannot stand here", "it belongs {home}";
        "prop-not-in-component" StackInComponent { home: &'static str, since: Release }
            => "`stack` cannot stand here",
               "it belongs {home} (GenoM3 accepts it from release {since} on: to use that, require \
                \"genom3 >= {since}\", or set `release`)";
        "newer-release" NewerThanRequired { what: &'static str, since: Release, bound: Release }
            => "{what}: releases of GenoM3 before {since} refuse it, but the specification requires only \
                {bound}",
               "write `require \"genom3 >= {since}\"`";
        "newer-release" NewerThanAny { what: &'static str, since: Release }
            => "{what}: releases of GenoM3 before {since} refuse it, but the specification does not say that it \
                needs this one",
               "write `require \"genom3 >= {since}\"`";
        "prop-not-in-task" NotInPort { word: &'static str }
            => "a port cannot have `{word}`", "its only property is `doc`";
        "prop-not-in-task" NotInTask { word: &'static str, home: &'static str }
            => "a task cannot have `{word}`", "it belongs {home}";
        "prop-not-in-service" NotInService { kind: &'static str, word: &'static str, home: &'static str }
            => "{kind} cannot have `{word}`", "it belongs {home}";
        "local-outside-service" LocalOutside { place: &'static str }
            => "{place} has no local variables",
               "only functions and activities do (for data that lasts, use the ids)";
        "codels-requires-again" RequiresTwice
            => "a second `codels-requires`: the lists are joined, but generators before version 2.99.41 \
                refuse it",
               "use one list";
        "codels-requires-again" RequiresImported
            => "the `codels-requires` of the interface is added to another one",
               "generators before version 2.99.41 refuse that";
        "list-duplicate-string" ListedTwice { text: Name, word: Name }
            => "\"{text}\" is already in this `{word}` list", "remove it";
        "port-anonymous" AnonymousPort { name: Name, ty: Name }
            => "the type of port `{name}` must have a name",
               "write `typedef {ty} {name}_data;` and use that";
        "port-native" NativePort { name: Name, ty: Name }
            => "port `{name}` cannot hold the native type in `{ty}`",
               "native data stays inside a component";

        "service-reserved" Reserved
            => "`all` stands for every service in `interrupts`, `before` and `after`",
               "choose another name";
        "service-kind-conflict" OtherKind { name: Name, was: &'static str, is: &'static str }
            => "`{name}` is {was}", "it cannot be declared again as {is}";
        "service-task" NoTask { name: Name, kind: &'static str }
            => "`{name}` is {kind}, so it has no task", "only activities run in one";
        "task-unknown" UnknownTask { name: Name }
            => "there is no task `{name}` so far",
               "tasks are declared before the activities that run in them";
        "service-simple-codel" CodelWithoutState
            => "an activity is a state machine, its codels have states: write `codel<start> …`";
        "service-fsm-codel" CodelWithState { kind: &'static str }
            => "{kind} runs no state machine, so its codels have no states",
               "leave out the `< >` and the `yields`, or make it an activity";
        "codel-in-task" TaskCodelWithoutState { codel: Name, task: Name }
            => "codel `{codel}` of task `{task}` has no states",
               "write `codel<start> {codel}(…) yields …`";
        "attribute-codel" AttributeCodel
            => "generators before version 2.99.41 refuse codels of attributes other than `validate`",
               "use a function to be accepted by all";
        "activity-task" ActivityWithoutTask { name: Name, by: ImportedBy, task: Name }
            => "activity `{name}`{by} runs in no task", "add for instance `task {task};`";
        "activity-task" ActivityWithoutAnyTask { name: Name, by: ImportedBy }
            => "activity `{name}`{by} runs in no task", "declare one and add `task …;`";
        "activity-start" ActivityWithoutStart { name: Name, by: ImportedBy }
            => "activity `{name}`{by} has no codel for the state `start`, where it begins",
               "add `codel<start> …`";
        "lists-itself" ListsItself { name: Name, word: &'static str }
            => "`{name}` cannot run {word} itself";
        "identifier-duplicate" NamedTwice { name: Name, word: Name }
            => "`{name}` is already in this `{word}` list", "remove it";
        "service-unknown" UnknownService { name: Name, component: Name }
            => "there is no service `{name}` in `{component}`";
        "service-unknown" OnlyRemote { name: Name, component: Name }
            => "there is no service `{name}` in `{component}`, only a remote one";

        "service-native" NativeParam { param: Name, service: Name }
            => "parameter `{param}` of `{service}` holds a native type",
               "native data stays inside a component (local variables and ids may hold it)";
        "param-special" SpecialParam { name: Name, what: Described, ty: Name }
            => "`{name}` cannot be {what}", "`{ty}` holds no data; use the type of its data";
        "param-duplicate" ParamTwice { what: &'static str, name: Name }
            => "a {what} called `{name}` exists already";
        "service-param-name" OtherName { service: Name, old: Name, new: Name }
            => "`{service}` was declared before with parameter `{old}` in this place, not `{new}`";
        "service-param-conflict" OtherDirection { name: Name, old: &'static str, new: &'static str }
            => "`{name}` was declared before as `{old}`, not `{new}`";
        "service-param-conflict" OtherType { name: Name, old: Name, new: Name }
            => "`{name}` was declared before with type `{old}`, not `{new}`";
        "service-param-conflict" OtherLocal { name: Name, service: Name }
            => "local variable `{name}` of `{service}` is something else in the interface";
        "service-param-extra" ParamExtra { service: Name, name: Name }
            => "`{service}` was declared before without parameter `{name}`";
        "service-param-missing" ParamMissing { service: Name, name: Name }
            => "`{service}` was declared before with parameter `{name}`, which is missing here",
               "repeat all parameters";
    }
}

impl DeclarationProblem {
    /// The fixes, the best first, made from the text around.
    pub(crate) fn fixes(&self, here: &FixSite<'_>) -> Vec<TextFix> {
        let fix = match self {
            DeclarationProblem::ListedTwice { .. } => here.remove_part().map(TextFix::plain),
            DeclarationProblem::ActivityWithoutTask { task, .. } => here.add_task(task),
            DeclarationProblem::AnonymousPort { name, .. } => here.name_port_type(name),
            DeclarationProblem::UnknownTask { name } => here.declare_task(name),
            DeclarationProblem::UnknownService { name, .. } => here.declare_service(name),
            DeclarationProblem::CodelWithoutState
            | DeclarationProblem::TaskCodelWithoutState { .. } => here.add_first_state(),
            DeclarationProblem::ActivityWithoutStart { .. } => here.add_codel("start"),
            _ => None,
        };
        fix.into_iter().collect()
    }
}
