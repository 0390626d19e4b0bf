//! An allocator that counts allocations by thread.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

pub(crate) struct Counting;

thread_local! {
    static LIVE: Cell<isize> = const { Cell::new(0) };
    static PEAK: Cell<isize> = const { Cell::new(0) };
    static COUNT: Cell<u64> = const { Cell::new(0) };
    static MARK: Cell<u64> = const { Cell::new(0) };
}

fn change(by: isize) {
    // A thread that ends no longer has counters.
    let _ = LIVE.try_with(|live| {
        live.set(live.get() + by);
        let _ = PEAK.try_with(|peak| peak.set(peak.get().max(live.get())));
    });
}

fn count() {
    let _ = COUNT.try_with(|cell| cell.set(cell.get() + 1));
}

// SAFETY: the system allocator does all the work.
#[allow(unsafe_code, reason = "an allocator cannot be written without")]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        change(layout.size() as isize);
        count();
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        change(-(layout.size() as isize));
        unsafe { System.dealloc(at, layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // Both blocks exist while one is copied to the other.
        change(size as isize);
        change(-(layout.size() as isize));
        count();
        unsafe { System.realloc(at, layout, size) }
    }
}

/// Returns the greatest number of bytes that this thread has allocated at one time during a call.
pub(crate) fn peak<T>(what: impl FnOnce() -> T) -> (T, usize) {
    let before = LIVE.get();
    PEAK.set(before);
    let out = what();
    (out, (PEAK.get() - before) as usize)
}

/// Sets the mark: allocations count from here.
pub(crate) fn mark() {
    MARK.set(COUNT.get());
}

/// Returns the number of allocations since the mark.
pub(crate) fn since_mark() -> u64 {
    COUNT.get() - MARK.get()
}
