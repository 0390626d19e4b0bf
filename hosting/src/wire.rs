//! The messages between the engine and a host: frames with a length, over pipes.

use std::io::{self, Read, Write};

use dotgen_analysis::model::PortId;
use dotgen_runtime::hosts::{Call, CodelResult, Delegation, HostMachine};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Maximum size of a frame. A greater length is invalid.
const MAX_FRAME_BYTES: usize = 1 << 30;

/// A command of the engine to a host.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum HostCommand {
    /// Creates a request.
    Make {
        service: u32,
        instance: u32,
        #[serde(with = "serde_bytes")]
        inputs: Vec<u8>,
    },
    /// Executes a codel on a thread. The component is not sent: a host has only one.
    Run(Call),
    /// Lets a thread execute cycles by itself.
    Delegate(Delegation),
    /// Lets the host stop by itself, by these machines, if the engine is gone.
    WatchEngine(Vec<HostMachine>),
    /// Ends the cycles of a thread.
    Recall { lane: u32 },
    /// Asks for the results of the cycles of a thread.
    Probe { lane: u32, probe: u32 },
    /// Ends a request.
    End { service: u32, instance: u32 },
    /// Gives an input port the path of its [data](super::shared_data).
    Share { port: PortId, id: String, path: String },
    /// Answers a request of a codel: with the outputs, or a system error.
    Answered {
        ask: u32,
        error: u32,
        #[serde(with = "serde_bytes")]
        outputs: Vec<u8>,
    },
}

/// A message of a host to the engine.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum HostMessage {
    /// The shared object is loaded.
    Ready,
    /// The shared object is loaded, and the host waits for a debugger.
    Waiting,
    /// The shared object cannot be loaded.
    Unusable(String),
    /// A codel has ended, at a time of the [shared clock](super::clock).
    CodelResult(CodelResult),
    /// The cycles that a thread executed by itself have ended.
    Recalled { ticket: u32 },
    /// All results of cycles until a time of the shared clock have been sent.
    Probed { probe: u32, until: u64 },
    /// The outputs of a request.
    Ended(#[serde(with = "serde_bytes")] Vec<u8>),
    /// A right that the system does not grant, as text.
    Denied(String),
    /// A codel requests a service of another component.
    Asked {
        ask: u32,
        remote: u32,
        #[serde(with = "serde_bytes")]
        inputs: Vec<u8>,
    },
}

impl HostCommand {
    /// Encodes the command as a frame.
    pub(super) fn bytes(&self) -> io::Result<Vec<u8>> {
        let mut frame = Vec::new();
        append(self, &mut frame)?;
        Ok(frame)
    }

    /// Reads a command. Returns `None` at the end of the input.
    pub(super) fn receive(from: &mut impl Read) -> io::Result<Option<HostCommand>> {
        receive(from)
    }
}

impl HostMessage {
    /// Sends messages in one piece: a reader is woken once.
    pub(super) fn send_all(messages: &[HostMessage], to: &mut impl Write) -> io::Result<()> {
        let mut bytes = Vec::new();
        for message in messages {
            append(message, &mut bytes)?;
        }
        to.write_all(&bytes)?;
        to.flush()
    }

    /// Reads a message. Returns `None` at the end of the input.
    pub(super) fn receive(from: &mut impl Read) -> io::Result<Option<HostMessage>> {
        receive(from)
    }
}

/// Appends a message as a frame: its length in four bytes, and its encoding.
fn append(message: &impl Serialize, frames: &mut Vec<u8>) -> io::Result<()> {
    let start = frames.len();
    frames.extend([0; 4]);
    postcard::to_io(message, &mut *frames).map_err(|_| nonsense())?;
    let length = u32::try_from(frames.len() - start - 4).map_err(|_| nonsense())?;
    frames[start..start + 4].copy_from_slice(&length.to_le_bytes());
    Ok(())
}

fn receive<T: DeserializeOwned>(from: &mut impl Read) -> io::Result<Option<T>> {
    let mut length = [0; 4];
    match from.read_exact(&mut length) {
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(None),
        result => result?,
    }
    let length = u32::from_le_bytes(length) as usize;
    if length > MAX_FRAME_BYTES {
        return Err(nonsense());
    }
    let mut bytes = vec![0; length];
    from.read_exact(&mut bytes)?;
    postcard::from_bytes(&bytes).map(Some).map_err(|_| nonsense())
}

fn nonsense() -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, "this is no message of a host")
}

#[cfg(test)]
mod tests {
    use dotgen_runtime::hosts::{CodelEnd, DelegatedState, DelegatedYield, PortWrite};
    use dotgen_timing::system::ComponentId;

    use super::*;

    #[test]
    fn a_delegation_is_received_as_it_was_sent() {
        let delegation = Delegation {
            call: Call {
                component: ComponentId::from(0),
                lane: 1,
                ticket: 2,
                codel: 3,
                instance: 4,
                core: None,
            },
            first_tick: 1 << 40,
            period: 1_000_000,
            state: 1,
            states: vec![
                DelegatedState {
                    codel: 3,
                    next: vec![
                        ("::a::main".to_owned(), DelegatedYield::Next(1)),
                        ("::a::pause::start".to_owned(), DelegatedYield::Pause(0)),
                    ],
                },
                DelegatedState { codel: 9, next: Vec::new() },
            ],
        };
        let machine = |stop| HostMachine {
            name: "a.b".to_owned(),
            lane: 4,
            period: 1 << 33,
            states: delegation.states.clone(),
            stop,
        };
        let machines = HostCommand::WatchEngine(vec![machine(Some(1)), machine(None)]);
        let bytes = machines.bytes().expect("it is short");
        let received = HostCommand::receive(&mut bytes.as_slice());
        assert_eq!(received.expect("it is whole"), Some(machines));
        let command = HostCommand::Delegate(delegation);
        let bytes = command.bytes().expect("it is short");
        let received = HostCommand::receive(&mut bytes.as_slice());
        assert_eq!(received.expect("it is whole"), Some(command));
        let broken = &bytes[..bytes.len() - 1];
        assert!(HostCommand::receive(&mut &broken[..]).is_err());
    }

    #[test]
    fn what_is_sent_is_received() {
        let ran = CodelResult {
            ticket: 3,
            codel: 5,
            nanos: 1 << 40,
            ended: 1 << 50,
            how: CodelEnd::Exception,
            name: "::a::b".to_owned(),
            detail: vec![1, 2],
            written: vec![
                PortWrite { port: PortId(1), id: "x".to_owned(), data: Some(vec![9]) },
                PortWrite { port: PortId(2), id: String::new(), data: None },
            ],
        };
        let reply = HostMessage::CodelResult(ran);
        let mut bytes = Vec::new();
        let all = std::slice::from_ref(&reply);
        HostMessage::send_all(all, &mut bytes).expect("memory takes all");
        let mut from = bytes.as_slice();
        assert_eq!(HostMessage::receive(&mut from).expect("it is whole"), Some(reply));
        assert_eq!(HostMessage::receive(&mut from).expect("it is the end"), None);
        let broken = &bytes[..bytes.len() - 1];
        assert!(HostMessage::receive(&mut &broken[..]).is_err());
    }
}
