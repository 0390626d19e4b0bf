//! Panics of one request must not end the process: they are caught, logged with their place, and shown to the
//! user once.

use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;

thread_local! {
    static ISOLATED: Cell<bool> = const { Cell::new(false) };
    static LAST_PANIC: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Runs `work`. The error is the message of a panic, with its place.
pub fn isolate<R>(work: impl FnOnce() -> R) -> Result<R, String> {
    install_hook();
    let outer = ISOLATED.replace(true);
    let result = catch_unwind(AssertUnwindSafe(work));
    ISOLATED.set(outer);
    result.map_err(|_| {
        LAST_PANIC
            .with_borrow_mut(Option::take)
            .unwrap_or_else(|| "panic without message".to_owned())
    })
}

/// Inside [`isolate`], a panic leaves its message and place for the caller. Elsewhere it is reported as
/// usual.
fn install_hook() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let default = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if !ISOLATED.get() {
                return default(info);
            }
            let place = info.location().map_or_else(String::new, |location| {
                format!(" at {}:{}", location.file(), location.line())
            });
            let payload = info.payload();
            let message = payload
                .downcast_ref::<&str>()
                .copied()
                .or_else(|| payload.downcast_ref::<String>().map(String::as_str))
                .unwrap_or("no message");
            LAST_PANIC.with_borrow_mut(|last| *last = Some(format!("{message}{place}")));
        }));
    });
}
