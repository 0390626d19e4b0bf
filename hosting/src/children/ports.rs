//! The data of ports that hosts read.

use std::collections::HashMap;

use dotgen_analysis::model::PortId;
use dotgen_runtime::hosts::Reader;
use dotgen_timing::system::ComponentId;

use super::Children;
use crate::shared_data::SharedData;
use crate::wire::HostCommand;

/// The source of the data of an input port.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum Origin {
    /// Component, output port and instance.
    Output(ComponentId, PortId, String),
    /// A source outside the run: the component, the input port and the name of the source.
    Elsewhere(ComponentId, PortId, String),
}

/// The shared memory with the data of ports that are read.
#[derive(Default)]
pub(super) struct SharedDataPool {
    /// The shared memory of each source, with its number.
    of: HashMap<Origin, (u64, SharedData)>,
    /// The number of the shared memory that each input port reads, by component, port and name of the source.
    shown: HashMap<(ComponentId, PortId, String), u64>,
    made: u64,
    /// Shared memory that was too small and was replaced. It is kept, because a host may still open it by its
    /// path, and no other memory may get this path.
    small: Vec<SharedData>,
}

impl Children {
    /// Puts new data of a source into shared memory, and sends its path to readers that do not have it.
    pub(super) fn show(&mut self, origin: Origin, readers: &[Reader<'_>], data: &[u8]) {
        let board = self.shared_data.of.get(&origin);
        let fits = board.is_some_and(|(_, board)| board.holds(data.len()));
        if !fits {
            let Ok(board) = SharedData::new(data.len()) else {
                // Memory is exhausted: readers keep their data.
                self.denied.insert("memory for the data of ports".to_owned());
                return;
            };
            self.shared_data.made += 1;
            let small = self.shared_data.of.insert(origin.clone(), (self.shared_data.made, board));
            self.shared_data.small.extend(small.map(|(_, board)| board));
        }
        let Some((number, board)) = self.shared_data.of.get_mut(&origin) else {
            return;
        };
        board.write(data);
        let (number, path) = (*number, board.path());
        for reader in readers {
            let place = (reader.component, reader.port, reader.name.to_owned());
            if self.shared_data.shown.insert(place, number) != Some(number) {
                let order = HostCommand::Share {
                    port: reader.port,
                    id: reader.name.to_owned(),
                    path: path.clone(),
                };
                self.order(reader.component, &order);
            }
        }
    }
}
