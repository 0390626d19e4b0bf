//! The signals that end a host.
#![allow(unsafe_code, reason = "calls of the C library, which take numbers")]

/// Gives the signals of crashes their default effect. The runtime of Rust has a handler for them: it lets the
/// thread repeat what it did, so a codel that sends itself the signal would go on.
pub(super) fn crash_as_usual() {
    for signal in [libc::SIGSEGV, libc::SIGBUS] {
        // SAFETY: the default effect runs no code.
        unsafe { libc::signal(signal, libc::SIG_DFL) };
    }
}
