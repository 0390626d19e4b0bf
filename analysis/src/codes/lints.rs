//! The table of rules, from which settings are generated. Each has a page in `docs/diagnostics`.

use super::Cause::*;
use super::Code;
use crate::diagnostic::Severity::{self, *};

/// The entry of a rule.
pub fn find(id: &str) -> Option<&'static Code> {
    CODES.iter().find(|code| code.id == id)
}

/// A comment that allows a code that is not reported.
pub const UNUSED_SUPPRESSION: &str = "lint/unused-suppression";
/// A comment that allows a code without a reason.
pub const NO_REASON: &str = "lint/no-reason";

pub(super) const fn lint(id: &'static str, severity: Severity) -> Code {
    Code::new(id, severity)
}

/// All rules.
pub const CODES: &[Code] = &[
    lint("fsm/busy-loop", Information),
    lint("fsm/no-termination", Warning).absence().follows(&[BrokenMachine, OpenMachine]),
    lint("fsm/pause-in-aperiodic-task", Information),
    lint("fsm/dead-end", Warning),
    lint("fsm/codel-named-as-event", Warning),
    lint("fsm/missing-stop", Hint).absence().follows(&[BrokenMachine]),
    lint("port/write-race", Warning),
    lint("port/never-written", Warning).absence(),
    lint("port/never-read", Hint).absence().unnecessary(),
    lint("ids/never-written", Hint).absence(),
    lint("ids/never-read", Hint).absence().unnecessary(),
    lint("ids/read-before-write", Hint).absence(),
    lint("lock/long-hold", Warning),
    lint("lock/self-blocking", Information),
    lint("timing/missing-wcet", Warning).absence(),
    lint("timing/wcet-exceeds-period", Warning),
    lint("timing/overutilised", Warning),
    lint("timing/no-period", Information).absence(),
    lint("timing/suspicious-unit", Warning),
    lint("service/concurrent-instances", Hint).absence(),
    lint("service/blind-validate", Warning).absence(),
    lint("service/long-function", Information),
    lint("service/order-cycle", Warning),
    lint("unused/exception", Hint).absence().unnecessary(),
    lint("unused/type", Hint).absence().unnecessary(),
    lint("unused/local", Hint).absence().unnecessary(),
    lint("style/missing-doc", Hint).off().absence(),
    lint("style/naming", Hint).off(),
    lint("style/order", Hint).off(),
    lint("genom3/deviation", Information),
    lint(UNUSED_SUPPRESSION, Hint).absence(),
    lint(NO_REASON, Hint),
];
