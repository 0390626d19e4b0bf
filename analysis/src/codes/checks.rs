//! Every diagnostic code of specifications. Each has a page in `docs/diagnostics`.
//!
//! The codes are those of the language reference, section 19; additional codes, which the reference compiler
//! does not have, are marked with [`ours`].

use super::Cause::{BrokenMachine, NamelessDeclaration, OpenMachine, UnreadText};
use super::Code;
use crate::diagnostic::Severity::{Hint, Warning};

const fn error(id: &'static str) -> Code {
    Code::error(id)
}

const fn warning(id: &'static str) -> Code {
    Code { severity: Warning, ..error(id) }
}

const fn hint(id: &'static str) -> Code {
    Code { severity: Hint, ..error(id) }
}

/// Marks a code that the reference compiler does not report.
const fn ours(code: Code) -> Code {
    code.of_reference(false)
}

/// All codes that elaboration and the checks of components report, by family, in the order of the reference.
pub const CODES: &[Code] = &[
    // Names and types.
    error("name-clash"),
    error("name-clash-module"),
    error("name-clash-enclosing"),
    error("unknown-type").follows(&[UnreadText]),
    error("comp-kind-conflict"),
    error("forward-undefined").follows(&[UnreadText]),
    error("forward-by-value"),
    error("forward-other-file"),
    error("void-exception-type"),
    error("fixed-unsupported"),
    error("union-switch-type"),
    error("union-duplicate-label"),
    warning("union-repeated-label"),
    error("union-member-switch-clash"),
    // Values.
    error("const-positive"),
    error("const-binary"),
    error("const-unary"),
    error("const-operand").follows(&[UnreadText]),
    error("const-convert"),
    error("const-type"),
    error("const-numeric"),
    error("const-div-zero"),
    ours(error("const-range")),
    error("init-compound-scalar"),
    error("init-scalar-compound"),
    error("init-member").follows(&[UnreadText]),
    error("init-array-member"),
    error("init-bounds"),
    error("init-struct-index"),
    error("init-too-many"),
    // Components, their properties, ports and interfaces.
    error("prop-not-in-component"),
    error("prop-not-in-task"),
    error("prop-not-in-service"),
    error("prop-duplicate"),
    warning("list-duplicate-string"),
    error("clock-rate-value"),
    error("clock-rate-multiple"),
    error("delay-without-period"),
    error("delay-range"),
    error("throw-not-exception").follows(&[UnreadText]),
    error("throw-duplicate"),
    error("port-anonymous"),
    error("port-native"),
    error("redefinition"),
    error("local-outside-service"),
    error("iface-unknown").follows(&[UnreadText]),
    error("iface-is-component"),
    error("iface-repeated"),
    error("pragma-provides-unknown").follows(&[UnreadText]),
    error("pragma-provides-component"),
    error("pragma-masquerade-syntax"),
    error("pragma-masquerade-type").follows(&[UnreadText]),
    error("pragma-masquerade-duplicate"),
    // Services.
    error("service-reserved"),
    error("service-kind-conflict"),
    error("service-param-name"),
    error("service-param-conflict"),
    error("service-param-extra"),
    error("service-param-missing"),
    error("service-task"),
    error("service-simple-codel"),
    error("service-fsm-codel"),
    error("service-native"),
    error("task-unknown").follows(&[UnreadText, NamelessDeclaration]),
    error("activity-task").follows(&[UnreadText, BrokenMachine]),
    error("activity-start").follows(&[UnreadText, BrokenMachine]),
    error("service-unknown").follows(&[UnreadText, NamelessDeclaration]),
    error("identifier-duplicate"),
    // Codels, their parameters and state machines.
    error("param-duplicate"),
    error("param-special"),
    error("param-no-ids").follows(&[UnreadText, NamelessDeclaration]),
    error("param-unknown-local").follows(&[UnreadText, NamelessDeclaration]),
    error("param-unknown-port").follows(&[UnreadText, NamelessDeclaration]),
    error("param-read-only-port"),
    error("param-port-member"),
    error("param-unknown-remote").follows(&[UnreadText, NamelessDeclaration]),
    error("param-remote-member"),
    error("param-remote-direction"),
    error("param-ambiguous"),
    error("param-unknown").follows(&[UnreadText, NamelessDeclaration]),
    error("param-unnamed"),
    error("param-member").follows(&[UnreadText, NamelessDeclaration]),
    error("param-scalar"),
    error("param-bounds"),
    error("codel-param-source"),
    error("codel-conflict"),
    error("fsm/paused-trigger"),
    error("codel-in-task"),
    error("fsm/duplicate-yield"),
    error("fsm/paused-ether"),
    error("fsm/duplicate-state"),
    error("fsm/undefined-state").follows(&[UnreadText, BrokenMachine]),
    error("throw/undeclared-use").follows(&[UnreadText]),
    error("fsm/unreachable-state").follows(&[UnreadText, BrokenMachine, OpenMachine]),
    error("fsm/stop-without-ether").follows(&[UnreadText, BrokenMachine, OpenMachine]),
    error("async/shared-resource"),
    error("async/shared-attribute"),
    // Times.
    ours(error("wcet-value")),
    ours(warning("wcet-bare")),
    ours(warning("glued-unit")),
    ours(error("wcet-pragma").follows(&[UnreadText])),
    // Text that the reference compiler accepts although it causes errors later.
    ours(warning("zero-size")),
    ours(warning("size-too-large")),
    ours(warning("not-a-type")),
    ours(warning("priority-range")),
    ours(warning("period-zero")),
    ours(warning("string-too-long")),
    ours(warning("octal-digit")),
    ours(warning("codels-requires-again")),
    ours(warning("attribute-codel")),
    ours(hint("newer-release")),
    ours(warning("inout-input-port")),
    ours(warning("writes-input")),
    ours(warning("ether-codel")),
    ours(warning("lists-itself")),
    ours(warning("unused-task").follows(&[UnreadText])),
];
