//! Real-time priority, cores and locked memory. A run continues without the rights that the system refuses.
#![allow(
    unsafe_code,
    reason = "calls of the C library, which take numbers and structures that are filled"
)]

/// Real-time priority of the engine: above the threads of codels, which it watches, and below the interrupt
/// handlers of Linux, which have 50.
pub const ENGINE_PRIORITY: u8 = 49;

/// Greatest real-time priority of a thread of codels.
const GREATEST_PRIORITY: u8 = ENGINE_PRIORITY - 1;

/// Least real-time priority of a thread of codels: above all ordinary threads.
const LEAST_PRIORITY: u8 = 10;

/// The nice value of a thread that works while others execute codels.
#[cfg(target_os = "linux")]
const BACKGROUND_NICE: libc::c_int = 19;

/// Pages of a process to lock in memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pages {
    /// The pages that the process has.
    Present,
    /// The present pages, and all later ones.
    All,
}

/// Sets the name of this process in `ps` and `top`: the first 15 bytes.
pub(crate) fn name_process(name: &str) {
    #[cfg(target_os = "linux")]
    if let Ok(name) = std::ffi::CString::new(name) {
        // SAFETY: the kernel only reads the text, to its end or 15 bytes.
        unsafe { libc::prctl(libc::PR_SET_NAME, name.as_ptr()) };
    }
    #[cfg(not(target_os = "linux"))]
    let _ = name;
}

/// Lets this process live on when its parent has ended, for an end of its own.
pub(crate) fn outlive_parent() {
    #[cfg(target_os = "linux")]
    let _ = rustix::process::set_parent_process_death_signal(None);
}

/// Locks pages of this process in memory. Returns false if the system refuses.
pub fn lock_memory(pages: Pages) -> bool {
    #[cfg(target_os = "linux")]
    // SAFETY: the calls take numbers, and a structure that they fill.
    unsafe {
        let mut limit: libc::rlimit = std::mem::zeroed();
        let known = libc::getrlimit(libc::RLIMIT_MEMLOCK, &raw mut limit) == 0;
        // Under a limit, a codel that allocates memory later would fail.
        if libc::geteuid() != 0 && !(known && limit.rlim_cur == libc::RLIM_INFINITY) {
            return false;
        }
        let flags = match pages {
            Pages::Present => libc::MCL_CURRENT,
            Pages::All => libc::MCL_CURRENT | libc::MCL_FUTURE,
        };
        return libc::mlockall(flags) == 0;
    }
    #[cfg(not(target_os = "linux"))]
    let _ = pages;
    #[allow(unreachable_code, reason = "elsewhere nothing is asked for")]
    false
}

/// Returns the real-time priorities of threads whose order is given by ranks, the lowest first. Equal ranks
/// have equal priorities. If there are more ranks than priorities, the last ranks share the least priority.
pub fn priorities(ranks: &[u64]) -> Vec<u8> {
    let mut order = ranks.to_vec();
    order.sort_unstable();
    order.dedup();
    let below = |rank: &u64| order.binary_search(rank).unwrap_or_else(|place| place);
    let levels = usize::from(GREATEST_PRIORITY - LEAST_PRIORITY);
    let priority = |rank| GREATEST_PRIORITY - u8::try_from(below(rank).min(levels)).unwrap_or(0);
    ranks.iter().map(priority).collect()
}

/// Gives this thread a real-time priority (`SCHED_FIFO`) and exact timers. Threads and processes that it
/// starts do not have this priority. Returns false if the system refuses.
pub fn raise_priority(priority: u8) -> bool {
    #[cfg(target_os = "linux")]
    // SAFETY: the structure is complete, and the kernel only reads it.
    unsafe {
        libc::prctl(libc::PR_SET_TIMERSLACK, 1 as libc::c_ulong, 0, 0, 0);
        let mut parameter: libc::sched_param = std::mem::zeroed();
        parameter.sched_priority = priority.into();
        let policy = libc::SCHED_FIFO | libc::SCHED_RESET_ON_FORK;
        return libc::sched_setscheduler(0, policy, &raw const parameter) == 0;
    }
    #[cfg(not(target_os = "linux"))]
    let _ = priority;
    #[allow(unreachable_code, reason = "elsewhere nothing is asked for")]
    false
}

/// Gives this thread the lowest priority, so that it does not delay other threads.
pub fn lower_priority() {
    #[cfg(target_os = "linux")]
    // SAFETY: only numbers are passed. On Linux the priority is that of the calling thread.
    unsafe {
        libc::setpriority(libc::PRIO_PROCESS, 0, BACKGROUND_NICE);
    }
}

/// Binds this thread to a core. Returns false if the system refuses.
pub(crate) fn pin(core: u32) -> bool {
    #[cfg(target_os = "linux")]
    // SAFETY: the set is complete, cores beyond its size are excluded, and the kernel only reads it.
    unsafe {
        let mut set: libc::cpu_set_t = std::mem::zeroed();
        if core as usize >= libc::CPU_SETSIZE as usize {
            return false;
        }
        libc::CPU_SET(core as usize, &mut set);
        return libc::sched_setaffinity(0, size_of::<libc::cpu_set_t>(), &raw const set) == 0;
    }
    #[allow(unreachable_code, reason = "elsewhere nothing is asked for")]
    {
        let _ = core;
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lower_ranks_have_higher_priorities() {
        assert_eq!(priorities(&[20, 10, 20, u64::MAX]), [47, 48, 47, 46]);
        let many: Vec<u64> = (0..100).collect();
        let priorities = priorities(&many);
        assert_eq!((priorities[0], priorities[38], priorities[99]), (48, 10, 10));
        assert!(priorities.is_sorted_by(|a, b| a >= b));
    }
}
