//! Clients of the socket: what they send and get, and the limits of both.

use std::io::{BufRead, Read as _, Write};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};

use serde_json::Value;

use super::stream::Stream;

/// Version of the replies.
pub(super) const VERSION: u32 = 1;

pub(super) const MAX_REQUEST_BYTES: usize = 4 << 20;

/// Lines that a client may be behind; a client that reads more slowly misses data of ports.
const MAX_QUEUED_LINES: usize = 1024;

/// Connections at a time: to the Unix socket, and as many to the TCP port.
pub(super) const MAX_CLIENTS: usize = 64;

/// Requests of a connection that have not ended.
pub(super) const MAX_WAITING: usize = 256;

/// A connected client. The connection ends when the last copy is dropped: a client that has closed its
/// sending half still gets the answers to its requests.
#[derive(Clone)]
pub(super) struct Client {
    pub(super) number: u64,
    lines: SyncSender<String>,
    stream: Arc<Stream>,
}

impl Client {
    /// A client, with the thread that writes to the stream.
    pub(super) fn new(number: u64, stream: Arc<Stream>) -> Client {
        let (lines, queue) = sync_channel(MAX_QUEUED_LINES);
        let output = stream.clone();
        std::thread::spawn(move || write(&output, &queue));
        Client { number, lines, stream }
    }

    /// Answers. A client that does not read is disconnected, as the answer would be missing.
    pub(super) fn say(&self, mapping: Value, id: &Value) {
        if !self.offer(mapping, id) {
            self.stream.disconnect();
        }
    }

    /// Sends a line that may be missed. Returns whether there was room for the line.
    pub(super) fn offer(&self, mut message: Value, id: &Value) -> bool {
        message["id"] = id.clone();
        message["version"] = VERSION.into();
        let sent = self.lines.try_send(format!("{message}\n"));
        !matches!(sent, Err(TrySendError::Full(_)))
    }
}

fn write(mut output: &Stream, queue: &Receiver<String>) {
    for line in queue {
        if output.write_all(line.as_bytes()).is_err() {
            break;
        }
    }
    output.disconnect();
}

/// A line of a client.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Line {
    /// A whole line; the last one needs no line end.
    Whole,
    /// The beginning of a line of more than [`MAX_REQUEST_BYTES`] bytes; [`skip_line`] reads the rest.
    TooLong,
    /// The client sends no more.
    End,
}

/// Reads a line, or its first [`MAX_REQUEST_BYTES`] bytes.
pub(super) fn read_line(input: &mut impl BufRead, line: &mut Vec<u8>) -> Line {
    line.clear();
    let most = MAX_REQUEST_BYTES as u64 + 1;
    match input.by_ref().take(most).read_until(b'\n', line) {
        Ok(1..) if line.ends_with(b"\n") || line.len() <= MAX_REQUEST_BYTES => Line::Whole,
        Ok(1..) => Line::TooLong,
        _ => Line::End,
    }
}

/// Reads to the end of the line, in constant memory.
pub(super) fn skip_line(input: &mut impl BufRead) {
    // An error is seen again by the next reader.
    let _ = input.skip_until(b'\n');
}
