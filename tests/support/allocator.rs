//! The system's allocator, but it counts what each thread asks for.

#![allow(unsafe_code, reason = "a global allocator, here one that counts, cannot be written without")]
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// The allocator: a test binary that counts has it as its global one.
pub struct Counting;

thread_local! {
    // Without a destructor, so that they may be used in an allocator.
    static REQUESTS: Cell<u64> = const { Cell::new(0) };
    static HELD: Cell<i64> = const { Cell::new(0) };
}

fn count(bytes: i64) {
    REQUESTS.set(REQUESTS.get() + 1);
    HELD.set(HELD.get() + bytes);
}

// SAFETY: everything is handed on to `System` unchanged; counting does not allocate.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as i64);
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as i64);
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(size as i64 - layout.size() as i64);
        unsafe { System.realloc(pointer, layout, size) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // Giving back something is as bad: it was taken once.
        count(-(layout.size() as i64));
        unsafe { System.dealloc(pointer, layout) }
    }
}

/// What was asked of the allocator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Asked {
    /// How often, giving back included.
    pub requests: u64,
    /// Bytes taken, less those given back.
    pub bytes: i64,
}

/// By this thread, meanwhile.
pub fn asked_by(work: impl FnOnce()) -> Asked {
    let before = (REQUESTS.get(), HELD.get());
    work();
    Asked { requests: REQUESTS.get() - before.0, bytes: HELD.get() - before.1 }
}
