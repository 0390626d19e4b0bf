//! The memory allocator of releases: jemalloc. Test builds have that of the system.
//!
//! glibc's allocator took a third of the time of `dotgen check` over many components. A server kept the
//! memory that a rename had freed, because that allocator adds an arena whenever two threads compete for one.
//! Other allocators reserve address space in advance, which the limits of confined programs (`RLIMIT_AS`, see
//! [`super::confine`]) forbid. `docs/performance.md` has the figures.
#![allow(
    unsafe_code,
    reason = "what the allocator is told: a constant, and a flag that lives longer than the call"
)]

#[cfg(all(unix, feature = "jemalloc"))]
#[global_allocator]
static ALLOCATOR: tikv_jemallocator::Jemalloc = tikv_jemallocator::Jemalloc;

/// The configuration that the allocator reads at the start of the program. It sets few arenas, because with
/// more of them more freed memory is kept. Empty pages are returned to the system after half a second.
#[cfg(all(unix, feature = "jemalloc"))]
// SAFETY: this is the name and the type under which jemalloc looks for its configuration.
#[unsafe(export_name = "_rjem_malloc_conf")]
static CONFIGURATION: Configuration =
    Configuration(c"narenas:4,dirty_decay_ms:500,muzzy_decay_ms:0".as_ptr());

/// A pointer to a constant text.
#[cfg(all(unix, feature = "jemalloc"))]
#[repr(transparent)]
struct Configuration(#[allow(dead_code, reason = "read by the allocator")] *const std::ffi::c_char);

// SAFETY: the text is never written.
#[cfg(all(unix, feature = "jemalloc"))]
unsafe impl Sync for Configuration {}

/// Starts a thread that returns freed memory to the system, even if nothing is allocated any more. For
/// servers, which wait for requests; a short command does not need the thread.
pub fn return_when_idle() {
    #[cfg(all(unix, feature = "jemalloc"))]
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
