//! What the system grants to who has to be in time. What it does not grant is done without.
#![allow(
    unsafe_code,
    reason = "three calls of the C library, which take numbers and a structure that is filled"
)]

/// Priority of threads: above all ordinary ones, below those of drivers.
#[cfg(target_os = "linux")]
const PRIORITY: i32 = 40;

/// Keeps all pages of this process in memory; whether that is granted.
pub(crate) fn lock_memory() -> bool {
    #[cfg(target_os = "linux")]
    // SAFETY: the call takes flags.
    unsafe {
        return libc::mlockall(libc::MCL_CURRENT | libc::MCL_FUTURE) == 0;
    }
    #[allow(unreachable_code, reason = "elsewhere nothing is asked for")]
    false
}

/// Schedules this thread before all ordinary ones, and waked at its time exactly; whether that is granted.
pub(crate) fn raise_priority() -> bool {
    #[cfg(target_os = "linux")]
    // SAFETY: the structure is whole, and the kernel only reads it.
    unsafe {
        libc::prctl(libc::PR_SET_TIMERSLACK, 1 as libc::c_ulong, 0, 0, 0);
        let mut parameter: libc::sched_param = std::mem::zeroed();
        parameter.sched_priority = PRIORITY;
        return libc::sched_setscheduler(0, libc::SCHED_FIFO, &parameter) == 0;
    }
    #[allow(unreachable_code, reason = "elsewhere nothing is asked for")]
    false
}
