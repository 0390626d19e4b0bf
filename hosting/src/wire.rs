//! The messages between the engine and a host: frames with a length, over pipes.

use std::io::{self, Read, Write};

use dotgen_runtime::hosts::{
    Call, CodelEnd, CodelResult, DelegatedState, DelegatedYield, Delegation, HostMachine, PortWrite,
};
use dotgen_timing::system::ComponentId;

/// Maximum size of a frame. A greater length is invalid.
const MAX_FRAME_BYTES: usize = 1 << 30;

/// The value for the absence of a core.
const NO_CORE: u32 = u32::MAX;

/// The value for the absence of a state.
const NO_STATE: u32 = u32::MAX;

/// A command of the engine to a host.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum HostCommand {
    /// Creates a request.
    Make { service: u32, instance: u32, inputs: Vec<u8> },
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
    Share { port: u32, id: String, path: String },
    /// Answers a request of a codel: with the outputs, or a system error.
    Answered { ask: u32, error: u32, outputs: Vec<u8> },
}

/// A message of a host to the engine.
#[derive(Debug, Clone, PartialEq, Eq)]
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
    Ended(Vec<u8>),
    /// A right that the system does not grant, as text.
    Denied(String),
    /// A codel requests a service of another component.
    Asked { ask: u32, remote: u32, inputs: Vec<u8> },
}

impl HostCommand {
    /// Encodes the command as a frame.
    pub(super) fn bytes(&self) -> io::Result<Vec<u8>> {
        let mut out = Frame::default();
        match self {
            HostCommand::Make { service, instance, inputs } => {
                out.byte(0).number(*service).number(*instance).bytes(inputs)
            }
            HostCommand::Run(call) => out.byte(1).call(call),
            HostCommand::Delegate(delegation) => out.byte(5).delegation(delegation),
            HostCommand::Recall { lane } => out.byte(6).number(*lane),
            HostCommand::Probe { lane, probe } => out.byte(7).number(*lane).number(*probe),
            HostCommand::WatchEngine(machines) => {
                out.byte(8).index(machines.len());
                for machine in machines {
                    out.machine(machine);
                }
                &mut out
            }
            HostCommand::End { service, instance } => {
                out.byte(2).number(*service).number(*instance)
            }
            HostCommand::Share { port, id, path } => {
                out.byte(3).number(*port).bytes(id.as_bytes()).bytes(path.as_bytes())
            }
            HostCommand::Answered { ask, error, outputs } => {
                out.byte(4).number(*ask).number(*error).bytes(outputs)
            }
        };
        out.whole()
    }

    /// Reads a command. Returns `None` at the end of the input.
    pub(super) fn receive(from: &mut impl Read) -> io::Result<Option<HostCommand>> {
        let Some(bytes) = receive(from)? else {
            return Ok(None);
        };
        let mut reader = ByteReader(&bytes);
        let order = match reader.byte()? {
            0 => HostCommand::Make {
                service: reader.number()?,
                instance: reader.number()?,
                inputs: reader.bytes()?.to_vec(),
            },
            1 => HostCommand::Run(reader.call()?),
            2 => HostCommand::End { service: reader.number()?, instance: reader.number()? },
            3 => HostCommand::Share {
                port: reader.number()?,
                id: reader.text()?,
                path: reader.text()?,
            },
            4 => HostCommand::Answered {
                ask: reader.number()?,
                error: reader.number()?,
                outputs: reader.bytes()?.to_vec(),
            },
            5 => HostCommand::Delegate(reader.delegation()?),
            6 => HostCommand::Recall { lane: reader.number()? },
            8 => {
                let count = reader.index()?;
                let machines = (0..count).map(|_| reader.machine());
                HostCommand::WatchEngine(machines.collect::<io::Result<_>>()?)
            }
            7 => HostCommand::Probe { lane: reader.number()?, probe: reader.number()? },
            _ => return Err(nonsense()),
        };
        Ok(Some(order))
    }
}

impl HostMessage {
    /// Sends messages in one piece: a reader is woken once.
    pub(super) fn send_all(messages: &[HostMessage], to: &mut impl Write) -> io::Result<()> {
        let mut bytes = Vec::new();
        for message in messages {
            bytes.extend(message.bytes()?);
        }
        to.write_all(&bytes)?;
        to.flush()
    }

    /// Encodes the message as a frame.
    fn bytes(&self) -> io::Result<Vec<u8>> {
        let mut out = Frame::default();
        match self {
            HostMessage::Ready => out.byte(0),
            HostMessage::Waiting => out.byte(6),
            HostMessage::Recalled { ticket } => out.byte(7).number(*ticket),
            HostMessage::Probed { probe, until } => out.byte(8).number(*probe).long(*until),
            HostMessage::Unusable(why) => out.byte(1).bytes(why.as_bytes()),
            HostMessage::Ended(outputs) => out.byte(2).bytes(outputs),
            HostMessage::Denied(what) => out.byte(4).bytes(what.as_bytes()),
            HostMessage::Asked { ask, remote, inputs } => {
                out.byte(5).number(*ask).number(*remote).bytes(inputs)
            }
            HostMessage::CodelResult(ran) => {
                let how = match ran.how {
                    CodelEnd::Event => 0,
                    CodelEnd::Exception => 1,
                    CodelEnd::Other => 2,
                };
                out.byte(3).number(ran.ticket).number(ran.codel);
                out.long(ran.nanos).long(ran.ended).byte(how);
                out.bytes(ran.name.as_bytes()).bytes(&ran.detail);
                out.number(u32::try_from(ran.written.len()).unwrap_or(u32::MAX));
                for port_write in &ran.written {
                    out.number(port_write.port).bytes(port_write.id.as_bytes());
                    match &port_write.data {
                        Some(data) => out.byte(1).bytes(data),
                        None => out.byte(0),
                    };
                }
                &mut out
            }
        };
        out.whole()
    }

    /// Reads a message. Returns `None` at the end of the input.
    pub(super) fn receive(from: &mut impl Read) -> io::Result<Option<HostMessage>> {
        let Some(bytes) = receive(from)? else {
            return Ok(None);
        };
        let mut reader = ByteReader(&bytes);
        let reply = match reader.byte()? {
            0 => HostMessage::Ready,
            1 => HostMessage::Unusable(reader.text()?),
            2 => HostMessage::Ended(reader.bytes()?.to_vec()),
            3 => HostMessage::CodelResult(CodelResult {
                ticket: reader.number()?,
                codel: reader.number()?,
                nanos: reader.long()?,
                ended: reader.long()?,
                how: match reader.byte()? {
                    0 => CodelEnd::Event,
                    1 => CodelEnd::Exception,
                    _ => CodelEnd::Other,
                },
                name: reader.text()?,
                detail: reader.bytes()?.to_vec(),
                written: {
                    let count = reader.number()?;
                    let mut all = Vec::new();
                    for _ in 0..count {
                        all.push(PortWrite {
                            port: reader.number()?,
                            id: reader.text()?,
                            data: match reader.byte()? {
                                0 => None,
                                _ => Some(reader.bytes()?.to_vec()),
                            },
                        });
                    }
                    all
                },
            }),
            4 => HostMessage::Denied(reader.text()?),
            5 => HostMessage::Asked {
                ask: reader.number()?,
                remote: reader.number()?,
                inputs: reader.bytes()?.to_vec(),
            },
            6 => HostMessage::Waiting,
            7 => HostMessage::Recalled { ticket: reader.number()? },
            8 => HostMessage::Probed { probe: reader.number()?, until: reader.long()? },
            _ => return Err(nonsense()),
        };
        Ok(Some(reply))
    }
}

#[derive(Default)]
struct Frame(Vec<u8>);

impl Frame {
    fn byte(&mut self, byte: u8) -> &mut Self {
        self.0.push(byte);
        self
    }

    fn number(&mut self, number: u32) -> &mut Self {
        self.0.extend(number.to_le_bytes());
        self
    }

    fn long(&mut self, number: u64) -> &mut Self {
        self.0.extend(number.to_le_bytes());
        self
    }

    fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        self.number(u32::try_from(bytes.len()).unwrap_or(u32::MAX));
        self.0.extend(bytes);
        self
    }

    fn call(&mut self, call: &Call) -> &mut Self {
        self.number(call.lane)
            .number(call.ticket)
            .number(call.codel)
            .number(call.instance)
            .number(call.core.unwrap_or(NO_CORE))
    }

    fn delegation(&mut self, delegation: &Delegation) -> &mut Self {
        self.call(&delegation.call)
            .long(delegation.first_tick)
            .long(delegation.period)
            .index(delegation.state)
            .states(&delegation.states)
    }

    fn machine(&mut self, machine: &HostMachine) {
        self.bytes(machine.name.as_bytes())
            .number(machine.lane)
            .long(machine.period)
            .number(machine.stop.and_then(|stop| u32::try_from(stop).ok()).unwrap_or(NO_STATE))
            .states(&machine.states);
    }

    fn states(&mut self, states: &[DelegatedState]) -> &mut Self {
        self.index(states.len());
        for state in states {
            self.number(state.codel).index(state.next.len());
            for (event, next) in &state.next {
                self.bytes(event.as_bytes());
                match *next {
                    DelegatedYield::Next(to) => self.byte(0).index(to),
                    DelegatedYield::Pause(to) => self.byte(1).index(to),
                };
            }
        }
        self
    }

    fn index(&mut self, index: usize) -> &mut Self {
        self.number(u32::try_from(index).unwrap_or(u32::MAX))
    }

    /// Returns the frame with its length in one piece: a reader that is woken for a length alone is woken
    /// twice.
    fn whole(&self) -> io::Result<Vec<u8>> {
        let length = u32::try_from(self.0.len()).map_err(|_| nonsense())?;
        let mut whole = Vec::with_capacity(self.0.len() + 4);
        whole.extend(length.to_le_bytes());
        whole.extend(&self.0);
        Ok(whole)
    }
}

fn receive(from: &mut impl Read) -> io::Result<Option<Vec<u8>>> {
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
    Ok(Some(bytes))
}

fn nonsense() -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, "this is no message of a host")
}

/// Reads values from bytes, in order.
pub(super) struct ByteReader<'b>(pub(super) &'b [u8]);

impl<'b> ByteReader<'b> {
    fn some(&mut self, count: usize) -> io::Result<&'b [u8]> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or_else(nonsense)?;
        self.0 = rest;
        Ok(taken)
    }

    fn byte(&mut self) -> io::Result<u8> {
        Ok(self.some(1)?.first().copied().unwrap_or(0))
    }

    pub(super) fn number(&mut self) -> io::Result<u32> {
        let bytes = self.some(4)?.try_into().map_err(|_| nonsense())?;
        Ok(u32::from_le_bytes(bytes))
    }

    fn long(&mut self) -> io::Result<u64> {
        let bytes = self.some(8)?.try_into().map_err(|_| nonsense())?;
        Ok(u64::from_le_bytes(bytes))
    }

    fn index(&mut self) -> io::Result<usize> {
        Ok(self.number()? as usize)
    }

    fn call(&mut self) -> io::Result<Call> {
        Ok(Call {
            component: ComponentId::from(0),
            lane: self.number()?,
            ticket: self.number()?,
            codel: self.number()?,
            instance: self.number()?,
            core: Some(self.number()?).filter(|core| *core != NO_CORE),
        })
    }

    fn delegation(&mut self) -> io::Result<Delegation> {
        let call = self.call()?;
        let (first_tick, period) = (self.long()?, self.long()?);
        let (state, states) = (self.index()?, self.delegated_states()?);
        Ok(Delegation { call, first_tick, period, state, states })
    }

    fn machine(&mut self) -> io::Result<HostMachine> {
        Ok(HostMachine {
            name: self.text()?,
            lane: self.number()?,
            period: self.long()?,
            stop: Some(self.number()?).filter(|stop| *stop != NO_STATE).map(|stop| stop as usize),
            states: self.delegated_states()?,
        })
    }

    fn delegated_states(&mut self) -> io::Result<Vec<DelegatedState>> {
        let count = self.index()?;
        (0..count).map(|_| self.delegated_state()).collect()
    }

    fn delegated_state(&mut self) -> io::Result<DelegatedState> {
        let (codel, count) = (self.number()?, self.index()?);
        let next = (0..count).map(|_| {
            let event = self.text()?;
            let next = match self.byte()? {
                0 => DelegatedYield::Next(self.index()?),
                _ => DelegatedYield::Pause(self.index()?),
            };
            Ok((event, next))
        });
        Ok(DelegatedState { codel, next: next.collect::<io::Result<_>>()? })
    }

    pub(super) fn bytes(&mut self) -> io::Result<&'b [u8]> {
        let length = self.number()? as usize;
        self.some(length)
    }

    pub(super) fn text(&mut self) -> io::Result<String> {
        Ok(String::from_utf8_lossy(self.bytes()?).into_owned())
    }
}

#[cfg(test)]
mod tests {
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
                PortWrite { port: 1, id: "x".to_owned(), data: Some(vec![9]) },
                PortWrite { port: 2, id: String::new(), data: None },
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
