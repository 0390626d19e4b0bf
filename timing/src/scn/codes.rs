//! Every diagnostic code of scenarios. Each has a page in `docs/diagnostics`.

use crate::diagnostic::Severity;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Code {
    pub id: &'static str,
    pub severity: Severity,
}

const fn error(id: &'static str) -> Code {
    Code { id, severity: Severity::Error }
}

const fn warning(id: &'static str) -> Code {
    Code { id, severity: Severity::Warning }
}

/// All codes of scenarios.
pub const CODES: &[Code] = &[
    error("scn-syntax"),
    error("scn-lexical"),
    error("scn-nesting"),
    error("scn-number"),
    error("scn-interval"),
    error("scn-repeat"),
    error("scn-zero-unit"),
    error("scn-no-core"),
    error("scn-loop-zero"),
    error("scn-stop"),
    error("scn-slots"),
    error("scn-unknown-name"),
    error("scn-path"),
    error("scn-wrong-kind"),
    error("scn-wrong-status"),
    error("scn-not-executed"),
    error("scn-unknown-step"),
    error("scn-abort"),
    error("scn-not-a-codel"),
    error("scn-port-direction"),
    error("scn-no-use"),
    error("scn-use-not-found"),
    error("scn-times"),
    warning("scn-times-name"),
    error("scn-no-component"),
    error("scn-affinity"),
    error("scn-semantics"),
    error("scn-zero-period"),
    error("scn-period-unit"),
    error("scn-time-range"),
    error("scn-contradictory-loop"),
    error("scn-client-size"),
    error("scn-empty-repeat"),
    warning("scn-no-check"),
    error("scn-aperiodic"),
    error("scn-chain-end"),
    error("scn-no-way"),
    warning("scn-data"),
];
