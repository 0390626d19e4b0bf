//! Ctrl-C on a terminal: a verification ends with what is known so far. A second one ends everything at once.

use std::io::IsTerminal;

use dotgen_timing::verify::Interrupt;
#[cfg(unix)]
use tokio::signal::unix::{Signal, SignalKind, signal};

use dotgen_platform::files::disk;

/// What a process says that was ended by Ctrl-C.
const ENDED: i32 = 130;

/// Raised by Ctrl-C, if somebody sits at a terminal; elsewhere the signal ends the process as it does others.
pub(crate) fn on_terminal() -> Interrupt {
    match std::io::stderr().is_terminal() {
        true => watched(),
        false => Interrupt::default(),
    }
}

/// Raised by Ctrl-C, and by the wish that this process ends, wherever that comes from.
pub(crate) fn on_signals() -> Interrupt {
    watched()
}

/// The signals that ask for the end. Those that come while nobody waits are heard by who waits next.
#[cfg(unix)]
struct Signals {
    interrupts: Signal,
    ends: Signal,
    hangs_up: Signal,
    /// Where this is heard, a file that may not grow is an error of that file, and not the end.
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

    /// The next one.
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

fn watched() -> Interrupt {
    let interrupt = Interrupt::default();
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build();
    let Ok(runtime) = runtime else {
        return interrupt;
    };
    let (raised, listens) = (interrupt.clone(), std::sync::mpsc::channel());
    // It waits until the process ends.
    std::thread::spawn(move || {
        runtime.block_on(async {
            let signals = Signals::new();
            let _ = listens.0.send(());
            // Without a handler the signal does what it always did.
            let Ok(mut signals) = signals else { return };
            signals.next().await;
            raised.raise();
            signals.next().await;
            disk::leave(ENDED);
        });
    });
    // From here on a signal is heard.
    let _ = listens.1.recv();
    interrupt
}
