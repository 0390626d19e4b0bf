//! Codes about services and their requirements on tasks.

use crate::codes::Cause::{BrokenMachine, NamelessDeclaration, UnreadText};

use super::{Code, error};

pub(super) const CODES: &[Code] = &[
    error(
        "service-reserved",
        "A service is called `all`.",
        "In `interrupts all`, `before all` and `after all` the word means every service.",
        "Give the service another name.",
    ),
    error(
        "service-kind-conflict",
        "A service is declared again with another kind.",
        "A second declaration adds to the first. A service is either an attribute, a function or an \
         activity.",
        "Use the kind of the first declaration, which can come from an interface, or give the second \
         one another name.",
    ),
    error(
        "service-param-name",
        "A service is declared again with another parameter name.",
        "A second declaration adds to the first and repeats its parameters, which clients know by \
         name.",
        "Use the names of the first declaration.",
    ),
    error(
        "service-param-conflict",
        "A service is declared again with another direction or type of a parameter, or another type of \
         a local variable.",
        "A second declaration adds to the first and repeats its parameters: a service has one \
         signature.",
        "Repeat directions and types as in the first declaration, which can come from an interface.",
    ),
    error(
        "service-param-extra",
        "A service is declared again with more parameters than before.",
        "A second declaration adds to the first and repeats its parameters. Clients that use the first \
         declaration would not send the extra ones.",
        "Remove the parameter, or add it to the first declaration. Data that only codels need can be \
         `local`.",
    ),
    error(
        "service-param-missing",
        "A service is declared again with fewer parameters than before.",
        "A second declaration adds to the first and repeats all of its parameters. The reference \
         compiler crashes here.",
        "Repeat all parameters of the first declaration.",
    ),
    error(
        "service-task",
        "An attribute or function has a `task`.",
        "The control task executes attributes and functions. Only activities run in a task of the \
         component.",
        "Remove the `task` property. If the service takes long, make it an activity.",
    ),
    error(
        "service-simple-codel",
        "An activity has a codel without states.",
        "An activity is a state machine: a codel without states would never be called.",
        "Give the codel a state (`codel<state> … yields …`), or write `validate` if it checks the \
         request.",
    ),
    error(
        "service-fsm-codel",
        "An attribute or function has a codel with states.",
        "The control task calls the codels of an attribute or function once, in order, without a state \
         machine.",
        "Remove the states and the `yields` list, or make the service an activity.",
    ),
    error(
        "service-native",
        "A parameter of a service is or contains a native type.",
        "Parameters travel between client and component, and the middleware cannot send what only the \
         codels know.",
        "Use a type with plain members as parameter, and keep the native type `local` or in the ids.",
    ),
    error(
        "task-unknown",
        "The task of an activity is not declared before it.",
        "The task that runs the activity has to exist at that point of the text.",
        "Correct the spelling, or move the `task` above the activity.",
    ).follows(&[UnreadText, NamelessDeclaration]),
    error(
        "activity-task",
        "An activity of a component has no task.",
        "A task executes the activity's codels and gives them their period and priority. Only an activity of \
         an interface may leave the task open.",
        "Add `task NAME;` to the activity.",
    ).follows(&[UnreadText, BrokenMachine]),
    error(
        "activity-start",
        "An activity of a component has no codel for the state `start`.",
        "Every request for the activity begins in `start`.",
        "Add `codel<start> … yields …`. An activity of an imported interface is completed by declaring \
         it again.",
    ).follows(&[UnreadText, BrokenMachine]),
    error(
        "service-unknown",
        "`interrupts`, `before` or `after` names a service that the component does not have.",
        "The relation would never apply. With `interrupts`, for example, the intended service would keep \
         running.",
        "Correct the spelling, declare the service, or write `all`.",
    ).follows(&[UnreadText, NamelessDeclaration]),
    error(
        "identifier-duplicate",
        "A list contains the same service twice.",
        "The second name has no effect. Another service was probably meant.",
        "Remove the repetition.",
    ),
];
