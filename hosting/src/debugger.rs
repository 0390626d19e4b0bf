//! A host that a debugger looks into.

use std::time::Duration;

/// How often it is looked whether the debugger is there.
const LOOK: Duration = Duration::from_millis(20);

/// Lets any process of this user attach: many systems let only parents of a process do so, and a debugger
/// that is attached is none.
pub(super) fn permit() {
    #[cfg(target_os = "linux")]
    {
        use rustix::process::{PTracer, set_ptracer};
        // Where the kernel does not know of this, nothing has to be permitted.
        let _ = set_ptracer(PTracer::Any);
    }
}

/// Waits until a debugger is attached and lets this process go on.
pub(super) fn wait() {
    while !is_attached() {
        std::thread::sleep(LOOK);
    }
}

/// Whether a debugger is attached to this process.
fn is_attached() -> bool {
    let Ok(status) = std::fs::read_to_string("/proc/self/status") else {
        // Nobody can tell.
        return true;
    };
    let tracer = status.lines().find_map(|it| it.strip_prefix("TracerPid:"));
    tracer.is_some_and(|it| it.trim() != "0")
}
