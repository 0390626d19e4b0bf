//! Ctrl-C on a terminal: a verification ends with what is known so far. A second one ends everything at once.

use std::io::IsTerminal;

use dotgen_timing::verify::Interrupt;

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

/// The next signal that asks for the end.
async fn asked() -> std::io::Result<()> {
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        let mut end = signal(SignalKind::terminate())?;
        let mut hangs_up = signal(SignalKind::hangup())?;
        tokio::select! {
            it = tokio::signal::ctrl_c() => it,
            _ = end.recv() => Ok(()),
            _ = hangs_up.recv() => Ok(()),
        }
    }
    #[cfg(not(unix))]
    tokio::signal::ctrl_c().await
}

fn watched() -> Interrupt {
    let interrupt = Interrupt::default();
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build();
    let Ok(runtime) = runtime else {
        return interrupt;
    };
    let raised = interrupt.clone();
    // It waits until the process ends.
    std::thread::spawn(move || {
        runtime.block_on(async {
            // Without a handler the signal does what it always did.
            if asked().await.is_ok() {
                raised.raise();
            }
            if asked().await.is_ok() {
                std::process::exit(ENDED);
            }
        });
    });
    interrupt
}
