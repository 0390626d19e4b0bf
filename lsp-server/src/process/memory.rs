//! What the allocator of the system keeps of the memory that was freed.
//!
//! Rust frees what nobody needs; whether the system gets it back is up to the allocator. That of glibc has an arena for
//! each thread that ever met another one in it, and keeps in each what was freed there: after a rename over a thousand
//! components half of the process is such remains. Other allocators reserve address space ahead, which the limits of
//! confined programs (`RLIMIT_AS`, see [`super::confine`]) forbid.
#![allow(
    unsafe_code,
    reason = "two calls of the C library, which take and give numbers"
)]

/// Lets threads share two arenas, as many as threads work at most times. To be called before they are started.
pub(crate) fn share_arenas() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: the call sets a number, under a lock of the allocator.
    unsafe {
        libc::mallopt(libc::M_ARENA_MAX, 2);
    }
}

/// Gives the pages that hold nothing back to the system. It takes as long as there is memory, some hundredths of a
/// second for a gigabyte, and allocations wait meanwhile: for when nobody waits for an answer.
pub(crate) fn give_back() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: the call frees what is free, under the locks of the allocator.
    unsafe {
        libc::malloc_trim(0);
    }
}
