//! Codes about codels, their parameters and their state machines.

use crate::codes::Cause::{BrokenMachine, NamelessDeclaration, OpenMachine, UnreadText};

use super::{Code, error};

pub(super) const CODES: &[Code] = &[
    error(
        "param-duplicate",
        "Two parameters, or a parameter and a local variable, of one list have the same name.",
        "The generated function would have two arguments with one name. A path such as `b.x` gives the \
         argument the name of its last part.",
        "Rename one of them: `b.x::y` passes `b.x` as `y`.",
    ),
    error(
        "param-special",
        "A parameter or local variable of a service has a port, a remote or a state as its type.",
        "Ports, remotes and states are not data types, although they share a scope with types.",
        "Use the data type of the port. If a codel needs the port itself, name the port among the parameters \
         of the codel.",
    ),
    error(
        "param-no-ids",
        "A parameter refers to the ids of a component that has none.",
        "Parameters of attributes are members of the ids. So are codel parameters that match nothing else.",
        "Add the member to an `ids { … };` above, or name a parameter of the service with `local`.",
    ).follows(&[UnreadText, NamelessDeclaration]),
    error(
        "param-unknown-local",
        "`local` does not name a parameter or local variable of the service.",
        "With `local`, the codel gets the argument from the request. The request has nothing of that name.",
        "Correct the spelling, or declare the parameter or variable before the codel.",
    ).follows(&[UnreadText, NamelessDeclaration]),
    error(
        "param-unknown-port",
        "`port` does not name a port of the component.",
        "The codel would have nothing to read or write.",
        "Correct the spelling, or declare the port in the component or in an interface that it \
         provides.",
    ).follows(&[UnreadText, NamelessDeclaration]),
    error(
        "param-read-only-port",
        "A codel writes an input port.",
        "An input port shows what another component writes. What this component writes would be lost.",
        "Read the port with `in`, or declare it as `port out`.",
    ),
    error(
        "param-port-member",
        "A parameter selects a member of a port.",
        "Codels get a port as a whole, as a handle that reads or writes all of its data.",
        "Pass the port, and select the member in the code of the codel. `goal::x` passes the port \
         under the name `x`.",
    ),
    error(
        "param-unknown-remote",
        "`remote` does not name a remote service.",
        "A component can call only the services of the interfaces that it `uses`.",
        "Correct the spelling, or add `uses` with the interface that has the service.",
    ).follows(&[UnreadText, NamelessDeclaration]),
    error(
        "param-remote-member",
        "A parameter selects a member of a remote service.",
        "Codels get a remote service as a whole, as a handle with which they call it.",
        "Pass the service, and give its parameters in the code of the codel. `goal::x` passes it under \
         the name `x`.",
    ),
    error(
        "param-remote-direction",
        "A remote service is passed with a direction other than `in`.",
        "The codel gets a handle to call the service. It cannot change the handle.",
        "Write `remote in`.",
    ),
    error(
        "param-ambiguous",
        "A parameter without `local`, `port`, `remote` or `ids` names several things in the component.",
        "The name alone does not select the data that the codel gets. In an attribute, the parameter and the \
         member of the ids always have the same name.",
        "Write the source in front: `local in x` is the parameter of the request, `ids in x` the \
         member of the ids.",
    ),
    error(
        "param-unknown",
        "A parameter without `local`, `port` or `remote` names nothing in the component.",
        "The name is looked up among members of the ids, parameters and local variables of the \
         service, ports and remote services.",
        "Correct the spelling, or declare what the codel needs. Parameters of another service are not \
         visible.",
    ).follows(&[UnreadText, NamelessDeclaration]),
    error(
        "param-unnamed",
        "`::name` is used with a source other than the ids.",
        "`::name` passes all ids together under one name. Locals, ports and remotes cannot be passed \
         together.",
        "Write the name of the parameter, port or remote without `::`.",
    ),
    error(
        "param-member",
        "A parameter names a member that does not exist.",
        "Each part of the path must be a member of the type before it. The path starts at the ids or at the \
         parameter.",
        "Correct the spelling, or add the member to the type.",
    ).follows(&[UnreadText, NamelessDeclaration]),
    error(
        "param-scalar",
        "An index is applied to something without elements.",
        "Only arrays and sequences have elements. A string is a single value.",
        "Remove the index, or make the data an array or a sequence.",
    ),
    error(
        "param-bounds",
        "An index is not less than the length of the array or bounded sequence.",
        "The codel would read or write memory outside the data. Indexes begin at 0.",
        "Correct the index, or make the array or the bound larger.",
    ),
    error(
        "codel-param-source",
        "A port or remote service is passed to a codel without states.",
        "The control task executes `validate` codels and the codels of functions and attributes. Only \
         codels that run in a task can use ports and remote services.",
        "Make the service an activity, or let a task copy the data of the port into the ids.",
    ),
    error(
        "codel-conflict",
        "A codel is used elsewhere in the specification with other parameters.",
        "A codel is one function. It cannot have two signatures, even in two components.",
        "Rename one of the two, or pass both the same types in the same order and directions.",
    ),
    error(
        "fsm/paused-trigger",
        "A codel implements a paused state.",
        "`pause::x` is a transition: the machine pauses and then enters the state `x`. A codel implements \
         the state, not the transition.",
        "Write `<x>` here, and `pause::x` in the `yields` list that leads to it.",
    ),
    error(
        "codel-in-task",
        "A task has a codel without states.",
        "A task runs a state machine: a codel without states would never be called.",
        "Write `codel<start> … yields …`.",
    ),
    error(
        "fsm/duplicate-yield",
        "A list contains the same state twice.",
        "The second name has no effect. Another state was probably meant.",
        "Remove the repetition. In a `yields` list, `x` and `pause::x` are different.",
    ),
    error(
        "fsm/paused-ether",
        "`pause::ether` is not allowed: `ether` ends the machine.",
        "After the end there is nothing to wait for.",
        "Write `ether`. If the machine should wait before it ends, pause in a state whose codel yields \
         `ether`.",
    ),
    error(
        "fsm/duplicate-state",
        "Two codels of one state machine implement the same state.",
        "When the machine enters the state, only one codel can run.",
        "Rename one of the states, or call both pieces of code from one codel.",
    ),
    error(
        "fsm/undefined-state",
        "A codel leads to an undefined state, which no codel implements.",
        "The machine would have nowhere to go when the codel returns that state. States of other tasks \
         and services do not count.",
        "Correct the spelling, add a codel for the state, or remove it from the `yields` list.",
    ).follows(&[UnreadText, BrokenMachine]),
    error(
        "throw/undeclared-use",
        "A codel yields an exception that its task or service does not throw.",
        "A `yields` list names states. An exception in it would be taken as a state that no codel \
         implements, and clients would not expect it.",
        "Remove the exception from the `yields` list, and add it to the `throws` of the task or service.",
    ).follows(&[UnreadText]),
    error(
        "fsm/unreachable-state",
        "A state can be reached neither from `start` nor from `stop`.",
        "Its codel never runs. Usually a `yields` list lacks the state.",
        "Add the state to the `yields` list of the codel that should lead to it, or remove the codel.",
    ).follows(&[UnreadText, BrokenMachine, OpenMachine]),
    error(
        "fsm/stop-without-ether",
        "No path leads from `stop` to `ether`.",
        "An interrupted activity runs its `stop` codel and has to end. Otherwise the interruption \
         never completes.",
        "Let the `stop` codel, or a state that it leads to, yield `ether`.",
    ).follows(&[UnreadText, BrokenMachine, OpenMachine]),
    error(
        "async/shared-resource",
        "An `async` codel shares data with a codel that may run at the same time.",
        "An `async` codel runs outside the locks of its task, so both can access the data at once and \
         read half-written values.",
        "Let the `async` codel work on `local` variables and copy them in a codel before and after, or share \
         only data that both codels read.",
    ),
    error(
        "async/shared-attribute",
        "An `async` codel shares data with an attribute.",
        "The control task can set or read the attribute while the `async` codel runs outside the \
         locks.",
        "Copy the data to a `local` variable in a codel before, or narrow the parameter to the members \
         that the attribute does not use.",
    ),
];
