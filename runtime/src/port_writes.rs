//! The writes of output ports: how many, and how old their data become.

use std::collections::BTreeMap;

use dotgen_timing::system::ComponentId;

/// An output port: component and number.
pub type Port = (ComponentId, u32);

/// The writes of all output ports. Times are those of all runs together, in base units.
#[derive(Debug, Clone, Default)]
pub struct PortWrites(BTreeMap<Port, Writes>);

/// The writes of one port.
#[derive(Debug, Clone, Copy)]
struct Writes {
    count: u64,
    last: u64,
    /// Greatest time between two writes.
    longest: u64,
}

impl PortWrites {
    pub(crate) fn on_write(&mut self, now: u64, port: Port) {
        let writes = self.0.entry(port).or_insert(Writes { count: 0, last: now, longest: 0 });
        writes.count += 1;
        writes.longest = writes.longest.max(now.saturating_sub(writes.last));
        writes.last = now;
    }

    /// Returns the number of writes of a port.
    pub fn count(&self, port: Port) -> u64 {
        self.0.get(&port).map_or(0, |writes| writes.count)
    }

    /// Returns the age of the data of a port; `None` if it was never written.
    pub fn age(&self, now: u64, port: Port) -> Option<u64> {
        self.0.get(&port).map(|writes| now.saturating_sub(writes.last))
    }

    /// Returns the greatest age that the data of a port have had; `None` if it was never written.
    pub fn greatest_age(&self, now: u64, port: Port) -> Option<u64> {
        self.0.get(&port).map(|writes| writes.longest.max(now.saturating_sub(writes.last)))
    }
}
