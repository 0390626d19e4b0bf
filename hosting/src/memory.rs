//! Memory that the engine shares with hosts. On systems with anonymous shared memory it has no name: the
//! system frees it with the last process that uses it, however that process ends.
#![allow(unsafe_code, reason = "memory that is shared with other processes is mapped")]

use std::ffi::c_void;
use std::fs::File;
use std::io;
use std::os::fd::AsRawFd as _;
use std::ptr::NonNull;

/// See the [module](self).
#[derive(Debug)]
pub(super) struct SharedMemory {
    file: File,
    /// The path of the memory, on systems without anonymous shared memory.
    #[cfg(not(target_os = "linux"))]
    passing: dotgen_platform::files::disk::TemporaryFile,
}

impl SharedMemory {
    /// Allocates memory of a size, in bytes.
    ///
    /// # Errors
    /// The system has no memory left.
    pub(super) fn new(length: usize) -> io::Result<SharedMemory> {
        #[cfg(target_os = "linux")]
        return anonymous_memory(length).map(|file| SharedMemory { file });
        #[cfg(not(target_os = "linux"))]
        named(length).map(|(file, passing)| SharedMemory { file, passing })
    }

    pub(super) fn file(&self) -> &File {
        &self.file
    }

    /// The path by which a host of this user opens the memory.
    pub(super) fn path(&self) -> String {
        #[cfg(target_os = "linux")]
        return format!("/proc/{}/fd/{}", std::process::id(), self.file.as_raw_fd());
        #[cfg(not(target_os = "linux"))]
        return self.passing.path().display().to_string();
    }
}

/// Maps a file that never becomes shorter.
///
/// # Errors
/// The system refuses, also if the length is 0.
pub(super) fn map(file: &File, length: usize, access: libc::c_int) -> io::Result<NonNull<c_void>> {
    // SAFETY: the system chooses the address.
    let memory = unsafe {
        let file = file.as_raw_fd();
        libc::mmap(std::ptr::null_mut(), length, access, libc::MAP_SHARED, file, 0)
    };
    match memory {
        libc::MAP_FAILED => Err(io::Error::last_os_error()),
        memory => NonNull::new(memory).ok_or_else(io::Error::last_os_error),
    }
}

/// Creates memory without a name that cannot become shorter and is allocated: no access to it fails for lack
/// of memory.
#[cfg(target_os = "linux")]
fn anonymous_memory(length: usize) -> io::Result<File> {
    use rustix::fs::{FallocateFlags, MemfdFlags, SealFlags};
    use rustix::process::{DumpableBehavior, set_dumpable_behavior};

    let flags = MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING;
    let file = rustix::fs::memfd_create("dotgen-port", flags)?;
    rustix::fs::ftruncate(&file, length as u64)?;
    rustix::fs::fallocate(&file, FallocateFlags::empty(), 0, length as u64)?;
    rustix::fs::fcntl_add_seals(&file, SealFlags::SHRINK | SealFlags::GROW)?;
    // If a program has capabilities of its own (for real-time scheduling), the system hides its descriptors
    // from hosts otherwise.
    let _ = set_dumpable_behavior(DumpableBehavior::Dumpable);
    Ok(File::from(file))
}

/// Creates a file that only this user can open, and that is removed with this process.
#[cfg(not(target_os = "linux"))]
fn named(length: usize) -> io::Result<(File, dotgen_platform::files::disk::TemporaryFile)> {
    static COUNT: std::sync::atomic::AtomicU64 = std::sync::atomic::AtomicU64::new(0);
    let number = COUNT.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    let name = format!("{}-{number}.port", std::process::id());
    let path = super::sockets::folder()?.join(name);
    let passing = dotgen_platform::files::disk::TemporaryFile::new(path.clone());
    let mut options = File::options();
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    let file = options.read(true).write(true).create(true).truncate(true).open(&path)?;
    file.set_len(length as u64)?;
    Ok((file, passing))
}
