//! Codes about properties, tasks, ports, interfaces and pragmas.

use crate::codes::Cause::UnreadText;

use super::{Code, error, warning};

pub(super) const CODES: &[Code] = &[
    error(
        "prop-not-in-component",
        "A component or interface has a property that is not allowed there.",
        "Periods and priorities belong to tasks; `interrupts`, `before`, `after` and codels belong to \
         services or tasks.",
        "Move the property to its task or service. The rate of a component is its `clock-rate`.",
    ),
    error(
        "prop-not-in-task",
        "A task or port has a property that is not allowed there.",
        "A task takes `period`, `delay`, `priority`, `scheduling`, `stack`, `doc`, `throws` and \
         codels. A port takes only `doc`.",
        "Move the property to its component or service.",
    ),
    error(
        "prop-not-in-service",
        "A service has a property that is not allowed there.",
        "Periods, priorities and stacks belong to the task that runs the service; versions, languages \
         and interfaces belong to the component.",
        "Move the property to the task or the component.",
    ),
    error(
        "prop-duplicate",
        "A property that may occur only once is given twice.",
        "Lists such as `doc`, `requires` and `throws` are merged. Any other property may occur once in a \
         component, task or service. The second one can come from an interface or from a component that is \
         reopened.",
        "Keep one of the two. A codel and a `validate` codel of one service need different names.",
    ),
    warning(
        "list-duplicate-string",
        "A list contains the same string twice.",
        "The second string has no effect. Another package was probably meant.",
        "Remove the repetition.",
    ),
    error(
        "clock-rate-value",
        "A period, delay or clock-rate is negative.",
        "Nothing can be scheduled with a negative time.",
        "Write a positive time.",
    ),
    error(
        "clock-rate-multiple",
        "A period or delay is not a multiple of the clock-rate.",
        "Periodic tasks wake up on ticks of the component's clock, so they cannot run between two \
         ticks.",
        "Adjust the period, choose a `clock-rate` that divides all periods and delays, or leave \
         `clock-rate` out: it is then computed.",
    ),
    error(
        "delay-without-period",
        "A task has a `delay` but no `period`.",
        "The delay shifts the ticks of a periodic task. A task without a period has no ticks.",
        "Add a `period`, or remove the delay.",
    ),
    error(
        "delay-range",
        "The delay of a task is not less than its period.",
        "The delay is the offset within a period. A longer one would skip whole periods.",
        "Choose a delay from 0 up to, but not including, the period.",
    ),
    error(
        "throw-not-exception",
        "A `throws` list names something that is not an exception.",
        "Clients decode a failure by its exception. An alias of an exception is a data type and does \
         not count.",
        "Name an exception, or declare the name with `exception`.",
    ).follows(&[UnreadText]),
    error(
        "throw-duplicate",
        "A `throws` list contains the same exception twice.",
        "The second name has no effect. Another exception was probably meant.",
        "Remove the repetition.",
    ),
    error(
        "port-anonymous",
        "The type of a port has no name.",
        "Other components read and write the port, so both sides must be able to name its type.",
        "Declare the type with `typedef`, `struct` or `enum`, and use its name.",
    ),
    error(
        "port-native",
        "The type of a port is or contains a native type.",
        "Only the codels know the content of a native type, so the middleware cannot send it to another \
         component.",
        "Publish a struct with plain members, and keep the native type in the ids.",
    ),
    error(
        "redefinition",
        "A service, remote or port has the name of another one in the same component.",
        "Codel parameters and clients refer to services, remotes and ports by name alone, so names must be \
         unique.",
        "Rename one of the two. For a name that comes with an interface, rename the one in the \
         component.",
    ),
    error(
        "local-outside-service",
        "Local variables are declared outside a function or activity.",
        "`local` variables live as long as one request of a function or activity. Components, tasks \
         and attributes have no such requests.",
        "Move the variable into the function or activity that uses it, or into the ids.",
    ),
    error(
        "iface-unknown",
        "`provides`, `uses` or `extends` names an interface that is not declared before it.",
        "An interface is imported as declared up to that point of the text, so the declaration must come \
         first.",
        "Correct the spelling, include the file that declares the interface, or move the declaration \
         up.",
    ).follows(&[UnreadText]),
    error(
        "iface-is-component",
        "`provides`, `uses` or `extends` names a component where an interface is needed.",
        "Only interfaces can be shared: a component also has tasks and codels of its own.",
        "Move the common part into an `interface`, and name the interface here and in the other \
         component.",
    ),
    error(
        "iface-repeated",
        "A list contains the same interface twice.",
        "The second name has no effect. Another interface was probably meant.",
        "Remove the repetition.",
    ),
    error(
        "pragma-provides-unknown",
        "`#pragma provides` names an interface that is not declared before it.",
        "The pragma takes effect where it stands, for the components that follow.",
        "Move the pragma below the interface, or correct the name.",
    ).follows(&[UnreadText]),
    error(
        "pragma-provides-component",
        "`#pragma provides` names a component.",
        "Every component that follows provides the interfaces of the pragma. A component cannot be \
         given to another one.",
        "Name an interface, or change the keyword `component` to `interface`.",
    ),
    error(
        "pragma-masquerade-syntax",
        "`#pragma masquerade` does not have exactly three arguments.",
        "The pragma needs the template, the type, and the text with which the template replaces the \
         type.",
        "Write `#pragma masquerade TEMPLATE TYPE \"TEXT\"`, with quotes around a text that has blanks.",
    ),
    error(
        "pragma-masquerade-type",
        "`#pragma masquerade` names a type that is not declared before it.",
        "The type is looked up like any other name, in the scope and at the place of the pragma.",
        "Move the pragma below the type, correct the name, or qualify it (`module::type`).",
    ).follows(&[UnreadText]),
    error(
        "pragma-masquerade-duplicate",
        "A type is masqueraded twice for the same template.",
        "A template can replace the type by one text only.",
        "Remove one of the pragmas, or name another template.",
    ),
];
