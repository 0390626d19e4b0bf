//! The pipe to a host, and the end of a host in words.

use std::io::{self, Write as _};
use std::process::{ChildStdin, ExitStatus};
use std::time::Instant;

use rustix::event::{PollFd, PollFlags};

use super::REPLY_TIMEOUT;
use crate::host::ALONE;

/// Writes to a host. The host reads all the time, and gets [`REPLY_TIMEOUT`] to do so.
pub(super) fn send(input: &mut ChildStdin, mut bytes: &[u8]) -> io::Result<()> {
    let until = Instant::now() + REPLY_TIMEOUT;
    while !bytes.is_empty() {
        match input.write(bytes) {
            Ok(count) => bytes = bytes.get(count..).unwrap_or_default(),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                let left = until.saturating_duration_since(Instant::now());
                if left.is_zero() {
                    return Err(io::ErrorKind::TimedOut.into());
                }
                let left = rustix::event::Timespec::try_from(left).map_err(io::Error::other)?;
                let mut wanted = [PollFd::new(&*input, PollFlags::OUT)];
                match rustix::event::poll(&mut wanted, Some(&left)) {
                    Ok(_) | Err(rustix::io::Errno::INTR) => {}
                    Err(error) => return Err(error.into()),
                }
            }
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

/// Describes the end of a process.
pub(super) fn in_words(status: ExitStatus) -> String {
    use std::os::unix::process::ExitStatusExt as _;
    let name = |number: i32| match number {
        4 => " (SIGILL)",
        6 => " (SIGABRT)",
        7 => " (SIGBUS)",
        8 => " (SIGFPE)",
        9 => " (SIGKILL)",
        11 => " (SIGSEGV)",
        15 => " (SIGTERM)",
        _ => "",
    };
    match (status.signal(), status.code()) {
        (Some(signal), _) => format!("was ended by signal {signal}{}", name(signal)),
        (None, Some(ALONE)) => "had no engine, and has ended by itself".to_owned(),
        (None, Some(code)) => format!("ended its process with exit status {code}"),
        (None, None) => "ended".to_owned(),
    }
}
