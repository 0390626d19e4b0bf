//! The times of hosts and of the model.

/// The conversion between the time of the hosts, in nanoseconds, and the time of the model, in base units.
#[derive(Debug, Clone, Copy)]
pub struct ModelTime {
    /// Time of the start of the run, in nanoseconds.
    start: u64,
    /// Nanoseconds per base unit; at least 1.
    unit: u64,
}

impl ModelTime {
    /// Creates the conversion for a run that starts at a time, in nanoseconds.
    pub fn new(start: u64, nanos_per_unit: u64) -> ModelTime {
        ModelTime { start, unit: nanos_per_unit.max(1) }
    }

    /// Returns a time of the hosts in base units.
    pub fn ticks(self, nanos: u64) -> u64 {
        nanos.saturating_sub(self.start) / self.unit
    }

    /// Returns a time of the model in nanoseconds.
    pub fn nanos(self, ticks: u64) -> u64 {
        self.start.saturating_add(ticks.saturating_mul(self.unit))
    }

    /// Returns a duration of the model in nanoseconds.
    pub fn duration(self, ticks: u64) -> u64 {
        ticks.saturating_mul(self.unit)
    }
}
