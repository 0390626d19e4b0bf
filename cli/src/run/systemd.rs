//! `dotgen run --systemd`: a unit that starts the same run with the machine.

use std::cell::Cell;
use std::ffi::OsString;
use std::os::unix::net::UnixDatagram;
use std::time::{Duration, Instant};

use dotgen_hosting::realtime;

/// Time after which systemd ends an engine that does not report. The engine waits up to 10 s for the reply of
/// a host.
const WATCHDOG: Duration = Duration::from_secs(15);

/// Time between two reports of the engine.
const REPORT_INTERVAL: Duration = Duration::from_secs(1);

/// Time that systemd leaves for the end of a run, beyond that of the components, in seconds.
const STOP_MARGIN_SECS: u64 = 5;

/// Reports to systemd that the engine goes on, if systemd has started it (`NOTIFY_SOCKET`).
pub(super) struct Watchdog {
    socket: Option<UnixDatagram>,
    reported: Cell<Option<Instant>>,
}

impl Watchdog {
    /// Connects to systemd, if it has started the run. Not supported: sockets with an abstract name.
    pub(super) fn new() -> Watchdog {
        Watchdog::connected(std::env::var_os("NOTIFY_SOCKET"))
    }

    fn connected(path: Option<OsString>) -> Watchdog {
        let socket = path.and_then(|path| {
            let socket = UnixDatagram::unbound().ok()?;
            socket.set_nonblocking(true).ok()?;
            socket.connect(path).ok()?;
            Some(socket)
        });
        Watchdog { socket, reported: Cell::new(None) }
    }

    /// Reports, at most once a second. The first report says that the components run.
    pub(super) fn report(&self) {
        let Some(socket) = &self.socket else { return };
        let last = self.reported.get();
        if last.is_some_and(|last| last.elapsed() < REPORT_INTERVAL) {
            return;
        }
        let text = if last.is_none() { "READY=1\nWATCHDOG=1" } else { "WATCHDOG=1" };
        // Without systemd at the other end, nothing waits for the report.
        let _ = socket.send(text.as_bytes());
        self.reported.set(Some(Instant::now()));
    }
}

/// The option itself, which the unit leaves out.
const OPTION: &str = "--systemd";

/// Returns the unit of a run of this program with these arguments, in the current folder.
///
/// # Errors
/// The program or the folder has no path as text.
pub(super) fn unit(
    title: &str,
    arguments: impl Iterator<Item = OsString>,
    stop_within: Duration,
) -> anyhow::Result<String> {
    let program = std::env::current_exe()?;
    let folder = std::env::current_dir()?;
    let mut words = vec![quoted(&text(program.into())?)];
    for argument in arguments.filter(|argument| argument != OPTION) {
        words.push(quoted(&text(argument)?));
    }
    Ok(format!(
        "[Unit]\n\
         Description=GenoM3 components: {title}\n\
         After=network-online.target\n\
         Wants=network-online.target\n\
         \n\
         [Service]\n\
         # Ready when the components run; the engine reports that it goes on.\n\
         Type=notify\n\
         NotifyAccess=main\n\
         TimeoutStartSec=infinity\n\
         WatchdogSec={watchdog}\n\
         # More than `--stop-within`: activities execute their `stop` codels.\n\
         TimeoutStopSec={stop}\n\
         KillMode=mixed\n\
         User={user}\n\
         WorkingDirectory={folder}\n\
         ExecStart={command}\n\
         # 3: the run was stopped; 1: after a violation; 4: not in time; 2: nothing can be run.\n\
         SuccessExitStatus=3\n\
         Restart=on-failure\n\
         RestartPreventExitStatus=1 2 4\n\
         # Real-time priority and locked memory for codels.\n\
         LimitRTPRIO={priority}\n\
         LimitMEMLOCK=infinity\n\
         \n\
         [Install]\n\
         WantedBy=multi-user.target\n",
        title = escaped(&text(title.into())?),
        watchdog = WATCHDOG.as_secs(),
        stop = stop_within.as_secs() + STOP_MARGIN_SECS,
        user = rustix::process::getuid().as_raw(),
        folder = escaped(&text(folder.into())?),
        command = words.join(" "),
        priority = realtime::ENGINE_PRIORITY,
    ))
}

fn text(argument: OsString) -> anyhow::Result<String> {
    match argument.into_string() {
        Ok(text) if !text.contains(char::is_control) => Ok(text),
        Ok(text) => anyhow::bail!(
            "{text:?} has a line end or another control character: a unit cannot contain it"
        ),
        Err(argument) => {
            anyhow::bail!("{} is not UTF-8: a unit cannot contain it", argument.display())
        }
    }
}

/// A word of a command line, as systemd reads it: `%` and `$` stand for themselves.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_owned();
    }
    let word = escaped(word).replace('\\', "\\\\").replace('"', "\\\"").replace('$', "$$");
    format!("\"{word}\"")
}

fn escaped(text: &str) -> String {
    text.replace('%', "%%")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_report_says_ready_and_the_next_one_waits() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("notify");
        let systemd = UnixDatagram::bind(&path).expect("a socket");
        systemd.set_nonblocking(true).expect("a socket");
        let watchdog = Watchdog::connected(Some(path.into()));
        watchdog.report();
        watchdog.report();
        let mut bytes = [0; 64];
        let length = systemd.recv(&mut bytes).expect("a report");
        assert_eq!(&bytes[..length], b"READY=1\nWATCHDOG=1");
        assert!(systemd.recv(&mut bytes).is_err(), "one report a second");
        Watchdog::connected(None).report();
    }

    #[test]
    fn words_stay_whole() {
        assert_eq!(quoted("pump.scn"), "pump.scn");
        assert_eq!(quoted("pump.fill={\"height\": 2}"), "\"pump.fill={\\\"height\\\": 2}\"");
        assert_eq!(quoted("a $b 5%"), "\"a $$b 5%%\"");
        assert_eq!(quoted(""), "\"\"");
    }
}
