//! The findings of verification. `dotgen_timing` computes them and the editor shows them; they are listed
//! here so that the manual and the configuration have one table.

use super::{Code, lints::lint};
use crate::diagnostic::Severity::*;

/// All verification codes.
pub const CODES: &[Code] = &[
    lint("timing/deadline-miss", Warning),
    lint("timing/response-exceeded", Warning),
    lint("timing/check-failed", Warning),
    lint("timing/vacuous-proof", Warning),
    lint("timing/gave-up", Information),
    lint("timing-no-wcet", Warning),
    lint("timing-state-cycle", Warning),
    lint("timing-lock-queue", Warning),
    lint("timing-port-hold", Warning),
    lint("timing-only-refused", Warning),
];
