//! Ctrl-C on a terminal: a verification ends with what is known so far. A second one ends everything at once.

use std::io::IsTerminal;

use dotgen_timing::verify::Interrupt;

/// What a process says that was ended by Ctrl-C.
const ENDED: i32 = 130;

/// Raised by Ctrl-C, if somebody sits at a terminal; elsewhere the signal ends the process as it does others.
pub(crate) fn on_terminal() -> Interrupt {
    let interrupt = Interrupt::default();
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build();
    let (Ok(runtime), true) = (runtime, std::io::stderr().is_terminal()) else {
        return interrupt;
    };
    let raised = interrupt.clone();
    // It waits until the process ends.
    std::thread::spawn(move || {
        runtime.block_on(async {
            // Without a handler the signal does what it always did.
            if tokio::signal::ctrl_c().await.is_ok() {
                raised.raise();
            }
            if tokio::signal::ctrl_c().await.is_ok() {
                std::process::exit(ENDED);
            }
        });
    });
    interrupt
}
