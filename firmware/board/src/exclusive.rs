//! Data of one context at a time.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU8, Ordering, compiler_fence};

/// Data that one context uses at a time. A context that interrupts a use does not get the data.
///
/// It is empty, and costs no octet of the program, until [`set`](Self::set).
#[derive(Debug)]
pub struct Exclusive<T> {
    /// One of the three below: one look at it decides everything.
    state: AtomicU8,
    data: UnsafeCell<MaybeUninit<T>>,
}

const EMPTY: u8 = 0;
const FREE: u8 = 1;
const USED: u8 = 2;

// SAFETY: `with` gives the data to one context at a time. The program runs on one core, and a context that interrupts another
// ends before the other goes on: between the load and the store in `enter` it leaves `state` as it was.
unsafe impl<T: Send> Sync for Exclusive<T> {}

impl<T> Default for Exclusive<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T> Exclusive<T> {
    /// No data yet.
    pub const fn new() -> Self {
        Self { state: AtomicU8::new(EMPTY), data: UnsafeCell::new(MaybeUninit::uninit()) }
    }

    /// Sets the data, which are made in their place; those before are not dropped. Returns whether no other context uses them.
    #[inline]
    pub fn set(&self, make: impl FnOnce() -> T) -> bool {
        let is_mine = self.state.load(Ordering::Relaxed) != USED;
        if is_mine {
            self.enter(|data| {
                data.write(make());
            });
        }
        is_mine
    }

    /// Forgets the data, without a drop, until the next [`set`](Self::set). Returns whether no other context uses them.
    #[inline]
    pub fn clear(&self) -> bool {
        let is_mine = self.state.load(Ordering::Relaxed) != USED;
        if is_mine {
            self.state.store(EMPTY, Ordering::Relaxed);
        }
        is_mine
    }

    /// Whether there are data.
    #[inline]
    #[must_use]
    pub fn is_set(&self) -> bool {
        self.state.load(Ordering::Relaxed) != EMPTY
    }

    /// Calls `use_data` with the data; `None` if there are none, or if this context has interrupted a use.
    #[inline]
    pub fn with<R>(&self, use_data: impl FnOnce(&mut T) -> R) -> Option<R> {
        if self.state.load(Ordering::Relaxed) != FREE {
            return None;
        }
        // SAFETY: `set` has written the data.
        Some(self.enter(|data| use_data(unsafe { data.assume_init_mut() })))
    }

    /// Calls `action` with the data, which may be empty. The caller has seen that no other context uses it.
    #[inline]
    fn enter<R>(&self, action: impl FnOnce(&mut MaybeUninit<T>) -> R) -> R {
        self.state.store(USED, Ordering::Relaxed);
        compiler_fence(Ordering::SeqCst);
        // SAFETY: the state was not `USED`, so no other reference exists, and none is made until it is `FREE` again.
        let result = action(unsafe { &mut *self.data.get() });
        compiler_fence(Ordering::SeqCst);
        self.state.store(FREE, Ordering::Relaxed);
        result
    }
}
