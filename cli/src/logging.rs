//! The log, on standard error; standard output belongs to the protocol. `DOTGEN_LOG` filters the log, in the
//! syntax of `RUST_LOG` (`DOTGEN_LOG=debug`, `DOTGEN_LOG=dotgen_lsp_server=trace`).
//!
//! A client may start the server with a pipe that it never reads. A full pipe blocks its writer, so only one
//! thread writes. The lines that do not fit into its queue are dropped and counted.

use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::{Duration, Instant};

use tracing_subscriber::EnvFilter;

/// Starts logging. `default` is the filter without `DOTGEN_LOG`: an editor keeps a log, and a terminal shows
/// it.
pub(crate) fn install(default: &str) -> Flush {
    let filter = EnvFilter::try_from_env("DOTGEN_LOG").unwrap_or_else(|_| EnvFilter::new(default));
    let (lines, queue) = sync_channel(QUEUE_LINES);
    let log = Log { lines, waiting: Arc::default(), dropped: Arc::default() };
    let (waiting, dropped) = (log.waiting.clone(), log.dropped.clone());
    let writer = std::thread::Builder::new().name("log".to_owned());
    let started = writer.spawn(move || write(&mut std::io::stderr(), &queue, &waiting, &dropped));
    if started.is_err() {
        // Without a log, the session goes on.
        return Flush(log);
    }
    // The default hook writes to standard error itself.
    std::panic::set_hook(Box::new(|info| tracing::error!("{info}")));
    let flush = Flush(log.clone());
    // A second call, as in tests, keeps the first log.
    let _ = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(move || log.clone())
        .with_ansi(std::io::IsTerminal::is_terminal(&std::io::stderr()))
        .try_init();
    flush
}

/// Maximum number of lines that wait to be written.
const QUEUE_LINES: usize = 1024;
/// Maximum time that the end of the process waits for the last lines.
const LAST_LINES: Duration = Duration::from_millis(300);

/// A log that never blocks.
#[derive(Debug, Clone)]
struct Log {
    lines: SyncSender<Vec<u8>>,
    waiting: Arc<AtomicUsize>,
    dropped: Arc<AtomicUsize>,
}

impl Write for Log {
    fn write(&mut self, line: &[u8]) -> std::io::Result<usize> {
        self.waiting.fetch_add(1, Ordering::AcqRel);
        if self.lines.try_send(line.to_owned()).is_err() {
            self.waiting.fetch_sub(1, Ordering::AcqRel);
            self.dropped.fetch_add(1, Ordering::AcqRel);
        }
        Ok(line.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// Writes the lines of a queue, and the number of those that were dropped.
fn write(
    output: &mut impl Write,
    queue: &Receiver<Vec<u8>>,
    waiting: &AtomicUsize,
    dropped: &AtomicUsize,
) {
    while let Ok(line) = queue.recv() {
        // An error means that the log has no reader any more.
        let _ = output.write_all(&line);
        let count = dropped.swap(0, Ordering::AcqRel);
        if count > 0 {
            let _ = writeln!(output, "{count} lines of the log were dropped: it was not read");
        }
        waiting.fetch_sub(1, Ordering::AcqRel);
    }
}

/// Lets the last lines be written. The process must call it before it exits.
#[must_use]
#[derive(Debug)]
pub(crate) struct Flush(Log);

impl Flush {
    /// Waits until every line is written, for a limited time.
    pub(crate) fn wait(&self) {
        let started = Instant::now();
        while self.0.waiting.load(Ordering::Acquire) > 0 && started.elapsed() < LAST_LINES {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_that_do_not_fit_are_counted() {
        let (lines, queue) = sync_channel(2);
        let mut log = Log { lines, waiting: Arc::default(), dropped: Arc::default() };
        for line in 0..5 {
            log.write_all(format!("{line}\n").as_bytes()).unwrap();
        }
        let (waiting, dropped) = (log.waiting.clone(), log.dropped.clone());
        assert_eq!((waiting.load(Ordering::Acquire), dropped.load(Ordering::Acquire)), (2, 3));
        drop(log);
        let mut output = Vec::new();
        write(&mut output, &queue, &waiting, &dropped);
        let output = String::from_utf8(output).unwrap();
        assert_eq!(output, "0\n3 lines of the log were dropped: it was not read\n1\n");
        assert_eq!(waiting.load(Ordering::Acquire), 0);
    }
}
