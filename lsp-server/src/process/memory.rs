//! Where the memory comes from: jemalloc.
//!
//! A third of the time of `dotgen check` over many components was spent in the allocator of glibc, and a
//! server kept what had been freed after a rename: that allocator has an arena for each thread that ever met
//! another one in it. Others reserve address space ahead, which the limits of confined programs (`RLIMIT_AS`,
//! see [`super::confine`]) forbid; `docs/performance.md` has the figures.
#![allow(
    unsafe_code,
    reason = "what the allocator is told: a constant, and a flag that lives longer than the call"
)]

#[cfg(all(unix, not(test)))]
#[global_allocator]
static ALLOCATOR: tikv_jemallocator::Jemalloc = tikv_jemallocator::Jemalloc;

/// What the allocator reads when the program starts. Few arenas, for more keep more of what was freed; pages
/// that hold nothing go back to the system after half a second.
#[cfg(all(unix, not(test)))]
// SAFETY: this is the name and the type under which jemalloc looks for its configuration.
#[unsafe(export_name = "_rjem_malloc_conf")]
static CONFIGURATION: Configuration =
    Configuration(c"narenas:4,dirty_decay_ms:500,muzzy_decay_ms:0".as_ptr());

/// A pointer to a text that is never written.
#[cfg(all(unix, not(test)))]
#[repr(transparent)]
struct Configuration(#[allow(dead_code, reason = "read by the allocator")] *const std::ffi::c_char);

// SAFETY: nobody writes to what it points to.
#[cfg(all(unix, not(test)))]
unsafe impl Sync for Configuration {}

/// Lets a thread give back what was freed, also when nothing is allocated any more. To be called by what
/// waits for requests; a command that ends soon needs no such thread.
pub(crate) fn return_when_idle() {
    #[cfg(all(unix, not(test)))]
    {
        let mut on = true;
        // SAFETY: the name ends with a null byte, nothing is read back, and the flag has the size that is
        // given.
        let error = unsafe {
            tikv_jemalloc_sys::mallctl(
                c"background_thread".as_ptr(),
                std::ptr::null_mut(),
                std::ptr::null_mut(),
                (&raw mut on).cast(),
                size_of::<bool>(),
            )
        };
        if error != 0 {
            let error = std::io::Error::from_raw_os_error(error);
            tracing::info!("memory that was freed stays with the server: {error}");
        }
    }
}
