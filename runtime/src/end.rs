//! The reason for the end of a run, and its bound.

use std::time::Duration;

/// Longest end of a run, unless another one is given.
pub(crate) const STOP_WITHIN: Duration = Duration::from_secs(2);

/// Time in which a host must answer, unless another one is given.
pub(crate) const HOST_WITHIN: Duration = Duration::from_secs(2);

/// The reason for the end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum End {
    /// The run has reached its requested duration.
    Done,
    /// No further event is possible.
    NothingLeft,
    /// Time does not pass, because too many actions take no time.
    Standstill,
    /// The run was to end at the first violation.
    Stopped,
    /// A measure of the scenario has ended the run.
    Measure,
    /// The run was interrupted.
    Interrupted,
    /// A component could not be started.
    NotStarted,
}

impl End {
    /// Returns true if no further run follows a run that ended so.
    pub(crate) fn ends_all(self) -> bool {
        !matches!(self, End::Done | End::NothingLeft)
    }
}
