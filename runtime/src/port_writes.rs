//! The writes of output ports: how many, and how old their data become.

use std::collections::BTreeMap;

use dotgen_analysis::model::PortId;
use dotgen_timing::system::ComponentId;

/// An output port: component and number.
pub type Port = (ComponentId, PortId);

/// The writes of all output ports. Times are those of the present run, in base units.
#[derive(Debug, Clone, Default)]
pub struct PortWrites(BTreeMap<Port, Writes>);

/// The writes of one port.
#[derive(Debug, Clone, Copy, Default)]
struct Writes {
    /// Number of writes in all runs.
    count: u64,
    /// Time of the last write in the present run.
    last: Option<u64>,
    /// Longest time of a run without a write after its first one.
    longest: u64,
}

impl PortWrites {
    pub(crate) fn on_write(&mut self, now: u64, port: Port) {
        let writes = self.0.entry(port).or_default();
        writes.longest = writes.longest.max(writes.age(now).unwrap_or(0));
        writes.count += 1;
        writes.last = Some(now);
    }

    /// Handles the end of a run at a time.
    pub(crate) fn end_run(&mut self, now: u64) {
        for writes in self.0.values_mut() {
            writes.longest = writes.longest.max(writes.age(now).unwrap_or(0));
            writes.last = None;
        }
    }

    /// Returns the number of writes of a port in all runs.
    pub fn count(&self, port: Port) -> u64 {
        self.0.get(&port).map_or(0, |writes| writes.count)
    }

    /// Returns the age of the data of a port; `None` if the present run has not written it.
    pub(crate) fn age(&self, now: u64, port: Port) -> Option<u64> {
        self.0.get(&port)?.age(now)
    }

    /// Returns the greatest age that the data of a port had in a run that has ended; `None` if it was never
    /// written.
    pub fn greatest_age(&self, port: Port) -> Option<u64> {
        self.0.get(&port).map(|writes| writes.longest)
    }
}

impl Writes {
    fn age(&self, now: u64) -> Option<u64> {
        self.last.map(|last| now.saturating_sub(last))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_data_of_one_run_do_not_age_in_the_next() {
        let mut ports = PortWrites::default();
        let port = (ComponentId::from(0), PortId(0));
        ports.on_write(10, port);
        ports.on_write(14, port);
        assert_eq!(ports.age(20, port), Some(6));
        ports.end_run(17);
        assert_eq!((ports.age(90, port), ports.greatest_age(port)), (None, Some(4)));
        ports.on_write(95, port);
        ports.end_run(100);
        assert_eq!((ports.count(port), ports.greatest_age(port)), (3, Some(5)));
    }
}
