//! The newest data of an output port, in memory that the engine shares with the hosts that read it.
//!
//! There are two places. The writer fills the one that is not current, and then makes it current. So the
//! writer never waits, and readers never wait for the writer. A reader repeats its read only if the writer
//! filled its place meanwhile. Readers map the memory without the right to write, so a faulty codel damages
//! only its own component. On systems with anonymous shared memory, the memory has no name: the system frees
//! it with the last process that uses it, however that process ends.
//!
//! The other side is `glue_look` in `codegen/src/codels/glue/prelude.h`.
#![allow(
    unsafe_code,
    reason = "memory that is shared with other processes is mapped, and reached through a pointer"
)]

use std::ffi::c_void;
use std::fs::File;
use std::io;
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU64, Ordering};

use super::memory::{SharedMemory, map};

/// Bytes before the first place: see `struct glue_board`.
const HEADER_BYTES: usize = 64;

/// Minimum size of a place.
const MIN_ROOM_BYTES: usize = 1024;

/// The header at the start of the memory.
#[repr(C)]
struct BoardHeader {
    /// Number of writes; 0 if there is no data. The newest data is in place `turn % 2`.
    turn: AtomicU64,
    /// Bytes of a place.
    room: AtomicU64,
    /// Bytes of data, by place.
    sizes: [AtomicU64; 2],
}

/// See the [module](self).
#[derive(Debug)]
pub(super) struct SharedData {
    memory: SharedMemory,
    board: NonNull<BoardHeader>,
    room: usize,
    turn: u64,
}

// SAFETY: the memory is reached through `&mut SharedData` only, and is mapped for all threads of this
// process.
unsafe impl Send for SharedData {}

impl SharedData {
    /// Allocates memory for data of a size, with some reserve.
    ///
    /// # Errors
    /// The system has no memory left.
    pub(super) fn new(size: usize) -> io::Result<SharedData> {
        let room = size.max(MIN_ROOM_BYTES).next_power_of_two();
        let length = HEADER_BYTES + 2 * room;
        let memory = SharedMemory::new(length)?;
        let access = libc::PROT_READ | libc::PROT_WRITE;
        let board =
            SharedData { turn: 0, board: map(memory.file(), length, access)?.cast(), memory, room };
        board.head().room.store(room as u64, Ordering::Relaxed);
        Ok(board)
    }

    /// The path by which a host of this user opens the memory.
    pub(super) fn path(&self) -> String {
        self.memory.path()
    }

    /// Returns true if data of a size fits.
    pub(super) fn holds(&self, size: usize) -> bool {
        size <= self.room
    }

    /// Writes new data. Data that does not fit is ignored.
    pub(super) fn write(&mut self, data: &[u8]) {
        if !self.holds(data.len()) {
            return;
        }
        self.turn += 1;
        let place = (self.turn % 2) as usize;
        let head = self.head();
        head.sizes[place].store(data.len() as u64, Ordering::Relaxed);
        // SAFETY: the place lies within the mapping, and there is one writer. A reader of this place sees
        // afterwards that `turn` has changed, and reads again.
        unsafe {
            let to = self.board.as_ptr().cast::<u8>();
            let to = to.add(HEADER_BYTES + place * self.room);
            std::ptr::copy_nonoverlapping(data.as_ptr(), to, data.len());
        }
        head.turn.store(self.turn, Ordering::Release);
        // The next write comes after this fence: a reader that sees its bytes also sees that this turn has
        // begun.
        std::sync::atomic::fence(Ordering::SeqCst);
    }

    fn head(&self) -> &BoardHeader {
        // SAFETY: the mapping is longer than the header, aligned to a page, and lives as long as `self`.
        unsafe { self.board.as_ref() }
    }
}

/// A read-only mapping of shared data, in a host.
#[derive(Debug)]
pub(super) struct View {
    memory: NonNull<BoardHeader>,
    length: usize,
}

// SAFETY: the mapping belongs to no thread, and is only read.
unsafe impl Send for View {}

// SAFETY: as above.
unsafe impl Sync for View {}

impl View {
    /// Maps the memory at a path.
    ///
    /// # Errors
    /// The memory cannot be opened.
    pub(super) fn open(path: &str) -> io::Result<View> {
        let file = File::open(path)?;
        let length = usize::try_from(file.metadata()?.len()).map_err(io::Error::other)?;
        if length < HEADER_BYTES {
            return Err(io::ErrorKind::InvalidData.into());
        }
        let memory = map(&file, length, libc::PROT_READ)?.cast();
        Ok(View { memory, length })
    }

    /// The address for the glue. The memory stays mapped for as long as the glue may read it.
    pub(super) fn address(&self) -> *const c_void {
        self.memory.as_ptr().cast()
    }
}

impl Drop for View {
    fn drop(&mut self) {
        // SAFETY: the mapping belongs to `self`, with this length.
        unsafe {
            libc::munmap(self.memory.as_ptr().cast(), self.length);
        }
    }
}

impl Drop for SharedData {
    fn drop(&mut self) {
        // SAFETY: the mapping belongs to `self`, with this length. No reference to it remains.
        unsafe {
            libc::munmap(self.board.as_ptr().cast(), HEADER_BYTES + 2 * self.room);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reads as the glue does: returns the newest data, if it is whole.
    fn look(view: &View, seen: &mut u64) -> Option<Vec<u8>> {
        // SAFETY: the view is mapped, and longer than the header.
        let head = unsafe { view.memory.as_ref() };
        loop {
            let turn = head.turn.load(Ordering::Acquire);
            if turn == *seen {
                return None;
            }
            let place = (turn % 2) as usize;
            let room = head.room.load(Ordering::Relaxed) as usize;
            let size = head.sizes[place].load(Ordering::Relaxed) as usize;
            assert!(size <= room);
            let mut bytes = vec![0; size];
            // SAFETY: the place lies within the mapping.
            unsafe {
                let from = view.address().cast::<u8>().add(HEADER_BYTES + place * room);
                std::ptr::copy_nonoverlapping(from, bytes.as_mut_ptr(), size);
            }
            std::sync::atomic::fence(Ordering::Acquire);
            if head.turn.load(Ordering::Relaxed) == turn {
                *seen = turn;
                return Some(bytes);
            }
        }
    }

    #[test]
    fn readers_see_whole_data_only_and_the_last_one_for_sure() {
        let mut board = SharedData::new(4096).expect("there is memory");
        let view = View::open(&board.path()).expect("it is there");
        let mut seen = 0;
        assert_eq!(look(&view, &mut seen), None);
        let reader = std::thread::scope(|scope| {
            let reader = scope.spawn(|| {
                let (mut seen, mut last) = (0, 0);
                while last != 250 {
                    let Some(bytes) = look(&view, &mut seen) else {
                        continue;
                    };
                    let first = bytes[0];
                    assert_eq!(bytes, vec![first; 1000 + usize::from(first)]);
                    last = first;
                }
                seen
            });
            for turn in 0..20_000u64 {
                let byte = (turn % 250) as u8;
                board.write(&vec![byte; 1000 + usize::from(byte)]);
            }
            board.write(&[250; 1250]);
            reader.join().expect("it has seen whole data")
        });
        assert_eq!(reader, 20_001);
        assert!(!board.holds(4097));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn nobody_else_can_write_or_shorten_it() {
        let board = SharedData::new(10).expect("there is memory");
        assert!(board.memory.file().set_len(10).is_err());
        assert!(board.memory.file().set_len(1 << 20).is_err());
        assert!(!board.path().contains("shm"), "it has no name that could stay behind");
    }
}
