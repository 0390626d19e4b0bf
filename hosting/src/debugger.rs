//! Hosts under a debugger.

use std::time::Duration;

/// Interval of checks for a debugger.
const LOOK: Duration = Duration::from_millis(20);

/// Permits any process of this user to attach. Many systems permit this only to the parent of a process.
pub(super) fn permit() {
    #[cfg(target_os = "linux")]
    {
        use rustix::process::{PTracer, set_ptracer};
        // Kernels without this call permit it anyway.
        let _ = set_ptracer(PTracer::Any);
    }
}

/// Waits until a debugger is attached.
pub(super) fn wait() {
    while !is_attached() {
        std::thread::sleep(LOOK);
    }
}

/// Returns true if a debugger is attached to this process.
fn is_attached() -> bool {
    let Ok(status) = std::fs::read_to_string("/proc/self/status") else {
        // Without this file the answer is unknown. The host does not wait.
        return true;
    };
    let tracer = status.lines().find_map(|line| line.strip_prefix("TracerPid:"));
    tracer.is_some_and(|tracer| tracer.trim() != "0")
}
