//! Clients at the socket of a run, each with one request at a time.

use std::io::{BufRead as _, BufReader, Read, Write};
use std::net::{Ipv4Addr, TcpStream};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Result, bail};

/// The number of clients that a run accepts at its Unix socket. Further ones connect to the TCP port.
const UNIX_CLIENTS: usize = 64;
const REQUEST: &[u8] = b"{\"id\": 1, \"call\": \"server.twice\", \"input\": {\"given\": 21}}\n";

/// Returns the times of all round trips of some clients, in nanoseconds.
///
/// # Errors
/// A client cannot connect, or gets another answer.
pub(super) fn round_trips(
    socket: &Path,
    port: u16,
    clients: usize,
    seconds: f64,
) -> Result<Vec<u64>> {
    let mut streams: Vec<(Box<dyn Read + Send>, Box<dyn Write + Send>)> = Vec::new();
    for client in 0..clients {
        streams.push(match client < UNIX_CLIENTS {
            true => {
                let stream = UnixStream::connect(socket)?;
                (Box::new(stream.try_clone()?), Box::new(stream))
            }
            false => {
                let stream = TcpStream::connect((Ipv4Addr::LOCALHOST, port))?;
                stream.set_nodelay(true)?;
                (Box::new(stream.try_clone()?), Box::new(stream))
            }
        });
    }
    let length = Duration::from_secs_f64(seconds);
    std::thread::scope(|scope| {
        let clients: Vec<_> = streams
            .into_iter()
            .map(|(input, output)| scope.spawn(move || client(input, output, length)))
            .collect();
        let mut trips = Vec::new();
        for client in clients {
            match client.join() {
                Ok(times) => trips.extend(times?),
                Err(_) => bail!("a client panicked"),
            }
        }
        Ok(trips)
    })
}

fn client(input: impl Read, mut output: impl Write, length: Duration) -> Result<Vec<u64>> {
    let mut input = BufReader::new(input);
    let (mut trips, mut line) = (Vec::new(), String::new());
    let started = Instant::now();
    while started.elapsed() < length {
        let sent = Instant::now();
        output.write_all(REQUEST)?;
        line.clear();
        input.read_line(&mut line)?;
        if !line.contains("42") {
            bail!("an unexpected answer: {line}");
        }
        trips.push(u64::try_from(sent.elapsed().as_nanos())?);
    }
    Ok(trips)
}
