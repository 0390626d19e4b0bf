//! A connection with a client: through a Unix socket, or TCP.

use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::os::fd::AsFd as _;
use std::os::unix::net::UnixStream;
use std::time::Duration;

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
    pub(super) fn limit_reads(&self, time: Option<Duration>) {
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
