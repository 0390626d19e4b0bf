//! Messages and data from outside on their way to the engine, and its events for subscribers.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex};

use dotgen_analysis::model::PortId;
use dotgen_runtime::hosts::{Message, RequestReply};

use crate::wire::HostMessage;
use dotgen_timing::system::ComponentId;

/// An event for the engine: from a host, with the number of its start, or from outside.
pub(super) enum EngineEvent {
    HostMessage(ComponentId, u64, HostMessage),
    /// The output of a host has ended.
    Closed(ComponentId, u64),
    Outside(Message),
    /// An input port has data from outside.
    Fed(Arc<InputSlot>),
}

/// The newest data from outside for an input port. Data that the engine has not taken yet is replaced.
pub(crate) struct InputSlot {
    pub(super) component: ComponentId,
    pub(super) port: PortId,
    pub(super) name: String,
    data: Mutex<Option<Vec<u8>>>,
}

impl InputSlot {
    /// Creates an empty slot for a port of a component, and for the name by which the port finds the source.
    pub(crate) fn new(component: ComponentId, port: PortId, name: String) -> InputSlot {
        InputSlot { component, port, name, data: Mutex::default() }
    }

    pub(super) fn swap(&self, data: Option<Vec<u8>>) -> Option<Vec<u8>> {
        let mut held = self.data.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        std::mem::replace(&mut held, data)
    }
}

/// A subscriber of the events of a run, outside the engine.
pub trait RunListener {
    /// Receives the result of a request, or its acceptance.
    fn answer(&mut self, id: u64, answer: &RequestReply);
    /// Receives the new state of an activity that a request began.
    fn entered(&mut self, _id: u64, _state: &str) {}
    /// Receives the end of a component, with the way in which the component ended.
    fn gone(&mut self, component: ComponentId, why: &str);
    /// Receives new data of an output port.
    fn published(&mut self, component: ComponentId, port: PortId, id: &str, data: &[u8]);
}

/// A sender of messages from outside to the engine.
#[derive(Clone)]
pub struct RunInbox {
    pub(super) sender: Sender<EngineEvent>,
    pub(super) requests: Arc<AtomicU64>,
}

impl RunInbox {
    /// The number of a further request. No other request from outside has it.
    pub(crate) fn number(&self) -> u64 {
        self.requests.fetch_add(1, Ordering::Relaxed) + 1
    }

    /// Sends a message. Returns false after the end of the run.
    pub(crate) fn bring(&self, message: Message) -> bool {
        self.sender.send(EngineEvent::Outside(message)).is_ok()
    }

    /// Sends data for an input port. Returns false after the end of the run.
    pub(crate) fn feed(&self, newest: &Arc<InputSlot>, data: Vec<u8>) -> bool {
        let waits = newest.swap(Some(data)).is_some();
        waits || self.sender.send(EngineEvent::Fed(newest.clone())).is_ok()
    }
}
