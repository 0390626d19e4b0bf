//! The clock that the engine and its hosts share.

use rustix::time::{ClockId, clock_gettime};

/// Returns the time of the monotonic clock, in nanoseconds. It is the same in all processes of a machine.
pub(crate) fn monotonic_nanos() -> u64 {
    let time = clock_gettime(ClockId::Monotonic);
    let seconds = u64::try_from(time.tv_sec).unwrap_or(0);
    let nanos = u64::try_from(time.tv_nsec).unwrap_or(0);
    seconds.saturating_mul(1_000_000_000).saturating_add(nanos)
}
