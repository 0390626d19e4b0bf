//! The codels that the threads of a host execute, in memory shared with the engine: if the host is lost, the
//! engine names the codel, and it knows how long a codel has executed that has not returned.
#![allow(
    unsafe_code,
    reason = "memory that is shared with other processes is mapped, and reached through a pointer"
)]

use std::fs::File;
use std::io;
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU64, Ordering};

use super::memory::{SharedMemory, map};

/// See the [module](self). A codel may damage the memory: a number means nothing unless it is checked.
#[derive(Debug)]
pub(super) struct Executing {
    /// By lane, one more than the codel (0: none), and the time of its call. The last entry has the heartbeat
    /// of the engine.
    table: NonNull<[AtomicU64; 2]>,
    lanes: usize,
    /// In the engine: the memory, which lasts as long as this value.
    memory: Option<SharedMemory>,
}

// SAFETY: the mapping belongs to no thread, and only atomic numbers are in it.
unsafe impl Send for Executing {}

// SAFETY: as above.
unsafe impl Sync for Executing {}

impl Executing {
    /// Allocates the memory, in the engine.
    ///
    /// # Errors
    /// The system has no memory left.
    pub(super) fn new(lanes: usize) -> io::Result<Executing> {
        let memory = SharedMemory::new(length(lanes))?;
        let mut executing = Executing::of(memory.file(), lanes)?;
        executing.memory = Some(memory);
        Ok(executing)
    }

    /// Maps the memory at a path, in a host.
    ///
    /// # Errors
    /// The memory cannot be opened.
    pub(super) fn open(path: &str, lanes: usize) -> io::Result<Executing> {
        let file = File::options().read(true).write(true).open(path)?;
        Executing::of(&file, lanes)
    }

    fn of(file: &File, lanes: usize) -> io::Result<Executing> {
        let length = length(lanes);
        if file.metadata()?.len() < length as u64 {
            return Err(io::ErrorKind::InvalidData.into());
        }
        let table = map(file, length, libc::PROT_READ | libc::PROT_WRITE)?;
        Ok(Executing { table: table.cast(), lanes, memory: None })
    }

    /// The path by which a host of this user opens the memory.
    pub(super) fn path(&self) -> String {
        self.memory.as_ref().map(SharedMemory::path).unwrap_or_default()
    }

    /// Sets the codel that a thread executes, with the time of its call on the clock of the hosts, in
    /// nanoseconds.
    pub(super) fn set(&self, lane: u32, executes: Option<(u32, u64)>) {
        let Some([codel, begun]) = self.place(lane) else { return };
        if let Some((_, time)) = executes {
            begun.store(time, Ordering::Relaxed);
        }
        codel.store(executes.map_or(0, |(codel, _)| u64::from(codel) + 1), Ordering::Release);
    }

    /// Returns the codel that a thread executes, with the time of its call.
    pub(super) fn get(&self, lane: u32) -> Option<(u32, u64)> {
        let [codel, begun] = self.place(lane)?;
        let codel = codel.load(Ordering::Acquire).checked_sub(1)?;
        Some((u32::try_from(codel).ok()?, begun.load(Ordering::Relaxed)))
    }

    /// A heartbeat of the engine.
    pub(super) fn beat(&self) {
        self.entry(self.lanes)[0].fetch_add(1, Ordering::Relaxed);
    }

    /// Returns the number of heartbeats of the engine.
    pub(super) fn beats(&self) -> u64 {
        self.entry(self.lanes)[0].load(Ordering::Relaxed)
    }

    fn place(&self, lane: u32) -> Option<&[AtomicU64; 2]> {
        let lane = usize::try_from(lane).ok().filter(|&lane| lane < self.lanes)?;
        Some(self.entry(lane))
    }

    /// `number` is at most the number of lanes.
    fn entry(&self, number: usize) -> &[AtomicU64; 2] {
        // SAFETY: the mapping has one entry more than lanes, is aligned to a page, and lives as long as
        // `self`.
        unsafe { self.table.add(number.min(self.lanes)).as_ref() }
    }
}

impl Drop for Executing {
    fn drop(&mut self) {
        // SAFETY: the mapping belongs to `self`, with this length. No reference to it remains.
        unsafe {
            libc::munmap(self.table.as_ptr().cast(), length(self.lanes));
        }
    }
}

/// Returns the size of the table, in bytes.
fn length(lanes: usize) -> usize {
    (lanes + 1) * size_of::<[AtomicU64; 2]>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_host_writes_and_the_engine_reads() {
        let engine = Executing::new(3).expect("there is memory");
        let host = Executing::open(&engine.path(), 3).expect("it is there");
        assert_eq!(engine.get(1), None);
        host.set(1, Some((7, 70)));
        host.set(3, Some((8, 80)));
        assert_eq!(engine.get(1), Some((7, 70)));
        assert_eq!(engine.get(3), None, "there are three lanes");
        engine.beat();
        assert_eq!(host.beats(), 1);
        host.set(1, None);
        drop(host);
        assert_eq!(engine.get(1), None);
        assert!(Executing::open(&engine.path(), 10_000).is_err(), "it is too small");
    }
}
