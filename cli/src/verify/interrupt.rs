//! Ctrl-C: a verification ends with the answers so far, a run in order. The last Ctrl-C ends the process at
//! once.

use std::io::IsTerminal;

use dotgen_timing::verify::Interrupt;
#[cfg(unix)]
use tokio::signal::unix::{Signal, SignalKind, signal};

use dotgen_platform::files::disk;

/// Exit status of a process that was ended by Ctrl-C.
const ENDED: i32 = 130;

/// Returns an interrupt that Ctrl-C raises, if the process has a terminal. Otherwise the signal ends the
/// process.
pub(crate) fn on_terminal() -> Interrupt {
    if std::io::stderr().is_terminal() { watched(false) } else { Interrupt::default() }
}

/// Returns an interrupt that Ctrl-C, TERM and HUP raise, whatever their source. The second signal forces it,
/// the third one ends the process.
pub(crate) fn on_signals() -> Interrupt {
    watched(true)
}

/// The signals that request the end. A signal that comes while no task waits for it is kept for the next one.
#[cfg(unix)]
struct Signals {
    interrupts: Signal,
    ends: Signal,
    hangs_up: Signal,
    /// With this handler, a file that may not grow causes an error of its write, and does not end the
    /// process.
    #[cfg(target_os = "linux")]
    _too_large: Option<Signal>,
}

#[cfg(unix)]
impl Signals {
    fn new() -> std::io::Result<Signals> {
        Ok(Signals {
            interrupts: signal(SignalKind::interrupt())?,
            ends: signal(SignalKind::terminate())?,
            hangs_up: signal(SignalKind::hangup())?,
            #[cfg(target_os = "linux")]
            _too_large: signal(SignalKind::from_raw(libc::SIGXFSZ)).ok(),
        })
    }

    /// Waits for the next signal.
    async fn next(&mut self) {
        tokio::select! {
            _ = self.interrupts.recv() => {}
            _ = self.ends.recv() => {}
            _ = self.hangs_up.recv() => {}
        }
    }
}

#[cfg(not(unix))]
struct Signals;

#[cfg(not(unix))]
impl Signals {
    fn new() -> std::io::Result<Signals> {
        Ok(Signals)
    }

    async fn next(&mut self) {
        if tokio::signal::ctrl_c().await.is_err() {
            std::future::pending::<()>().await
        }
    }
}

fn watched(in_order: bool) -> Interrupt {
    let interrupt = Interrupt::default();
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let Ok(runtime) = runtime else {
        return interrupt;
    };
    let (raised, listens) = (interrupt.clone(), std::sync::mpsc::channel());
    // The thread ends with the process.
    std::thread::spawn(move || {
        runtime.block_on(async {
            let signals = Signals::new();
            let _ = listens.0.send(());
            // Without a handler the signal has its default effect.
            let Ok(mut signals) = signals else { return };
            signals.next().await;
            raised.raise();
            signals.next().await;
            if in_order {
                raised.force();
                signals.next().await;
            }
            disk::leave(ENDED);
        });
    });
    // From here on signals are handled.
    let _ = listens.1.recv();
    interrupt
}
