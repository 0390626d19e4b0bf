//! Every diagnostic code of specifications, in one table.
//!
//! The codes are those of the language reference, section 19; further ones, which the reference
//! compiler does not have, stand at the end.

use crate::diagnostic::Severity;

/// What is known about one code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Code {
    /// The code, as shown and as used in configuration.
    pub id: &'static str,
    /// How bad it is unless configured otherwise.
    pub severity: Severity,
    /// What it means, in one line.
    pub meaning: &'static str,
    /// Whether the reference compiler reports it too.
    pub reference: bool,
}

const fn error(id: &'static str, meaning: &'static str) -> Code {
    Code {
        id,
        severity: Severity::Error,
        meaning,
        reference: true,
    }
}

const fn warning(id: &'static str, meaning: &'static str) -> Code {
    Code {
        id,
        severity: Severity::Warning,
        meaning,
        reference: true,
    }
}

const fn hint(id: &'static str, meaning: &'static str) -> Code {
    Code {
        id,
        severity: Severity::Hint,
        meaning,
        reference: true,
    }
}

/// Not reported by the reference compiler.
const fn ours(code: Code) -> Code {
    Code {
        reference: false,
        ..code
    }
}

/// The entry of a code.
pub fn find(id: &str) -> Option<&'static Code> {
    CODES.iter().find(|it| it.id == id)
}

/// All codes that elaboration and the checks of components report, in the order of the reference.
pub const CODES: &[Code] = &[
    error("name-clash", "a name is declared twice in the same scope"),
    error(
        "name-clash-module",
        "a declaration takes the name of a module or component of the same scope",
    ),
    error(
        "name-clash-enclosing",
        "a declaration takes the name of the scope it is in",
    ),
    error("unknown-type", "a name does not resolve"),
    error(
        "comp-kind-conflict",
        "a component is reopened as an interface or the reverse",
    ),
    error(
        "forward-undefined",
        "a forward declaration is never completed",
    ),
    error(
        "forward-by-value",
        "a forward-declared type is used where its contents must be known",
    ),
    error(
        "forward-other-file",
        "a forward-declared type is completed in another file",
    ),
    error(
        "void-exception-type",
        "an exception without members is used as a data type",
    ),
    error(
        "fixed-unsupported",
        "the type `fixed` or a fixed point literal is used",
    ),
    error("union-switch-type", "a type that a union cannot switch on"),
    error(
        "union-duplicate-label",
        "two members of a union have an equal label",
    ),
    warning(
        "union-repeated-label",
        "the same label twice in front of one member",
    ),
    error(
        "union-member-switch-clash",
        "a union member has the name of the switch type",
    ),
    error(
        "const-positive",
        "a size, bound, index, priority or stack is no non-negative integer",
    ),
    error(
        "const-binary",
        "a binary operator on operands it does not accept",
    ),
    error(
        "const-unary",
        "a unary operator on an operand it does not accept",
    ),
    error("const-operand", "a name in an expression that has no value"),
    error(
        "const-convert",
        "a value does not convert to the declared type",
    ),
    error("const-type", "a type that cannot hold a constant"),
    error("const-numeric", "a time or size that is not a number"),
    error("const-div-zero", "integer division or remainder by zero"),
    ours(error("const-range", "an integer does not fit its type")),
    error(
        "prop-not-in-component",
        "a property that a component or interface cannot have",
    ),
    error(
        "prop-not-in-task",
        "a property that a task or port cannot have",
    ),
    error(
        "prop-not-in-service",
        "a property that a service cannot have",
    ),
    error(
        "prop-duplicate",
        "a property that does not merge is given twice",
    ),
    warning("list-duplicate-string", "the same string twice in one list"),
    error("clock-rate-value", "a negative period, delay or clock-rate"),
    error(
        "clock-rate-multiple",
        "a period or delay is no multiple of the clock-rate",
    ),
    error("delay-without-period", "a task has a delay but no period"),
    error("delay-range", "a delay is not less than the period"),
    error(
        "throw-not-exception",
        "something thrown is not an exception",
    ),
    error("throw-duplicate", "the same exception twice in one list"),
    error("port-anonymous", "the type of a port has no name"),
    error("port-native", "the type of a port holds a native type"),
    error(
        "redefinition",
        "a service, remote or port takes the name of another one",
    ),
    error("service-reserved", "a service is called `all`"),
    error(
        "service-kind-conflict",
        "a service is declared again with another kind",
    ),
    error(
        "service-param-name",
        "a service is declared again with another parameter name",
    ),
    error(
        "service-param-conflict",
        "a service is declared again with another parameter direction or type",
    ),
    error(
        "service-param-extra",
        "a service is declared again with more parameters",
    ),
    error(
        "service-param-missing",
        "a service is declared again with fewer parameters",
    ),
    error("service-task", "an attribute or function is given a task"),
    error(
        "service-simple-codel",
        "an activity has a codel without states",
    ),
    error(
        "service-fsm-codel",
        "an attribute or function has a codel with states",
    ),
    error(
        "service-native",
        "a parameter of a service holds a native type",
    ),
    error(
        "task-unknown",
        "the task of an activity is not declared before it",
    ),
    error("activity-task", "an activity of a component has no task"),
    error(
        "activity-start",
        "an activity of a component has no codel for the state `start`",
    ),
    error(
        "service-unknown",
        "`interrupts`, `before` or `after` names no service of the component",
    ),
    error("identifier-duplicate", "the same service twice in one list"),
    error(
        "local-outside-service",
        "local variables where there can be none",
    ),
    error(
        "param-duplicate",
        "two parameters of one list have the same name",
    ),
    error(
        "param-special",
        "a parameter or local variable of a service is a port, remote or event",
    ),
    error(
        "param-no-ids",
        "the ids are used but the component has none",
    ),
    error(
        "param-unknown-local",
        "`local` names no parameter or local variable of the service",
    ),
    error("param-unknown-port", "`port` names no port"),
    error("param-read-only-port", "an input port is written"),
    error("param-port-member", "a member of a port is selected"),
    error("param-unknown-remote", "`remote` names no remote service"),
    error(
        "param-remote-member",
        "a member of a remote service is selected",
    ),
    error(
        "param-remote-direction",
        "a remote service that is not `in`",
    ),
    error(
        "param-ambiguous",
        "a name without source matches several things",
    ),
    error("param-unknown", "a name without source matches nothing"),
    error(
        "param-unnamed",
        "`::name` alone with another source than the ids",
    ),
    error("param-member", "a path names a member that does not exist"),
    error("param-scalar", "an index on something without elements"),
    error("param-bounds", "an index beyond the length"),
    error(
        "codel-param-source",
        "a port or remote in a codel without states",
    ),
    error(
        "codel-conflict",
        "a codel is used elsewhere with other parameters",
    ),
    error("fsm/paused-trigger", "a codel implements a paused state"),
    error("codel-in-task", "a task has a codel without states"),
    error("fsm/duplicate-yield", "the same state twice in one list"),
    error("fsm/paused-ether", "`pause::ether` does not exist"),
    error(
        "fsm/duplicate-state",
        "two codels of one state machine implement the same state",
    ),
    error(
        "fsm/undefined-state",
        "a codel leads to a state that no codel implements",
    ),
    error(
        "throw/undeclared-use",
        "a codel yields an exception that its task or service does not throw",
    ),
    error(
        "fsm/unreachable-state",
        "a state can be reached neither from `start` nor from `stop`",
    ),
    error(
        "fsm/stop-without-ether",
        "no path leads from `stop` to `ether`",
    ),
    error(
        "async/shared-resource",
        "an async codel shares data with a codel that may run at the same time",
    ),
    error(
        "async/shared-attribute",
        "an async codel shares data with an attribute",
    ),
    error(
        "init-compound-scalar",
        "`{ }` as the value of something that has no parts",
    ),
    error(
        "init-scalar-compound",
        "a single value for something that has parts",
    ),
    error(
        "init-member",
        "an initializer names a member that does not exist",
    ),
    error(
        "init-array-member",
        "an initializer names a member of an array or sequence",
    ),
    error("init-bounds", "an initializer beyond the length"),
    error(
        "init-struct-index",
        "an initializer indexes a struct or union",
    ),
    error("init-too-many", "more initializers than members"),
    error("iface-unknown", "an interface that is not declared before"),
    error(
        "iface-is-component",
        "a component where an interface is needed",
    ),
    error("iface-repeated", "the same interface twice in one list"),
    error(
        "pragma-provides-unknown",
        "`#pragma provides` names an unknown interface",
    ),
    error(
        "pragma-provides-component",
        "`#pragma provides` names a component",
    ),
    error(
        "pragma-masquerade-syntax",
        "`#pragma masquerade` needs three arguments",
    ),
    error(
        "pragma-masquerade-type",
        "`#pragma masquerade` names an unknown type",
    ),
    error(
        "pragma-masquerade-duplicate",
        "a second masquerade of a type for one template",
    ),
    ours(error(
        "wcet-value",
        "an execution time that is negative, not a number, missing or given twice",
    )),
    ours(warning(
        "wcet-bare",
        "an execution time without the word `wcet`",
    )),
    ours(warning(
        "glued-unit",
        "a number glued to `us` is read as seconds",
    )),
    ours(error(
        "wcet-pragma",
        "`#pragma wcet` that cannot be applied",
    )),
    // Not in the reference at all.
    ours(warning("zero-size", "an array size or bound of zero")),
    ours(warning(
        "not-a-type",
        "a constant, enumerator, state, port or remote service is used as a type",
    )),
    ours(warning("priority-range", "a priority above 255")),
    ours(warning("period-zero", "a period of zero")),
    ours(warning(
        "string-too-long",
        "a string constant longer than its bound",
    )),
    ours(warning("octal-digit", "an octal literal with 8 or 9")),
    ours(warning(
        "codels-requires-again",
        "a second `codels-requires`, which older generators refuse",
    )),
    ours(warning(
        "attribute-codel",
        "a codel of an attribute, which older generators refuse",
    )),
    ours(hint(
        "newer-release",
        "what only newer releases of GenoM3 accept, where the specification claims to work with older ones",
    )),
    ours(warning("inout-input-port", "`inout` on an input port")),
    ours(warning("writes-input", "a codel writes an `in` parameter")),
    ours(warning("ether-codel", "a codel for the state `ether`")),
    ours(warning(
        "lists-itself",
        "a service is before or after itself",
    )),
    ours(warning("unused-task", "a task that runs nothing")),
];
