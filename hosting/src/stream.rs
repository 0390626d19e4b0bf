//! A connection with a client: through a Unix socket, or TCP.

use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::os::fd::AsFd as _;
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;

/// See the [module](self). Read and written by two threads.
#[derive(Debug)]
pub(super) enum Stream {
    /// A connection of this user.
    Unix(UnixStream),
    /// A connection of any process on this machine.
    Tcp(TcpStream),
}

impl Stream {
    /// Returns true if only this user can open such a connection.
    pub(super) fn is_private(&self) -> bool {
        matches!(self, Stream::Unix(_))
    }

    /// Limits the time of each read from a TCP port. A read that takes longer fails.
    fn limit_reads(&self, time: Option<Duration>) {
        if let Stream::Tcp(tcp) = self {
            // Fails only for a time of zero.
            let _ = tcp.set_read_timeout(time);
        }
    }

    /// Ends the connection.
    pub(super) fn disconnect(&self) {
        // The connection may have ended already.
        let _ = match self {
            Stream::Unix(unix) => unix.shutdown(Shutdown::Both),
            Stream::Tcp(tcp) => tcp.shutdown(Shutdown::Both),
        };
    }
}

impl Stream {
    /// Waits until the connection has ended in both directions.
    pub(super) fn wait_for_end(&self) {
        let fd = match self {
            Stream::Unix(unix) => unix.as_fd(),
            Stream::Tcp(tcp) => tcp.as_fd(),
        };
        // `poll` reports the end without a request for it.
        let mut polled = [PollFd::new(&fd, PollFlags::empty())];
        while poll(&mut polled, None) == Err(Errno::INTR) {}
    }
}

impl Read for &Stream {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        match self {
            Stream::Unix(unix) => (&*unix).read(bytes),
            Stream::Tcp(tcp) => (&*tcp).read(bytes),
        }
    }
}

impl Write for &Stream {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Stream::Unix(unix) => (&*unix).write(bytes),
            Stream::Tcp(tcp) => (&*tcp).write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The input of a connection, with a deadline for all reads together: a client that sends one byte at a time
/// has no more time than others.
pub(super) struct TimedInput<'a> {
    stream: &'a Stream,
    deadline: Option<Instant>,
    now: &'a dyn Fn() -> Instant,
}

impl<'a> TimedInput<'a> {
    /// An input without a deadline. `now` is the clock.
    pub(super) fn new(stream: &'a Stream, now: &'a dyn Fn() -> Instant) -> TimedInput<'a> {
        TimedInput { stream, deadline: None, now }
    }

    /// Limits the time of all reads from now; `None` ends the limit.
    pub(super) fn limit(&mut self, time: Option<Duration>) {
        self.deadline = time.and_then(|time| (self.now)().checked_add(time));
        self.stream.limit_reads(time);
    }
}

impl Read for TimedInput<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        if let Some(deadline) = self.deadline {
            let left = deadline.saturating_duration_since((self.now)());
            if left.is_zero() {
                return Err(io::ErrorKind::TimedOut.into());
            }
            self.stream.limit_reads(Some(left));
        }
        let mut stream = self.stream;
        stream.read(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    /// Each read finds a byte at once, and yet all of them together take too long.
    #[test]
    fn a_slow_client_has_no_more_time_than_others() {
        let (client, server) = UnixStream::pair().expect("a pair");
        (&client).write_all(b"{\"token\": ").expect("sent");
        let time = Cell::new(Instant::now());
        let now = || time.replace(time.get() + Duration::from_secs(4));
        let server = Stream::Unix(server);
        let mut input = TimedInput::new(&server, &now);
        input.limit(Some(Duration::from_secs(10)));
        let mut byte = [0];
        assert_eq!(input.read(&mut byte).expect("after 4 s"), 1);
        assert_eq!(input.read(&mut byte).expect("after 8 s"), 1);
        let late = input.read(&mut byte).expect_err("after 12 s");
        assert_eq!(late.kind(), io::ErrorKind::TimedOut);
        // Without a limit the rest is read.
        input.limit(None);
        assert_eq!(input.read(&mut byte).expect("the third byte"), 1);
    }
}
