//! Data of one context at a time.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering, compiler_fence};

/// Data that one context uses at a time. A context that interrupts a use does not get the data.
///
/// It is empty, and costs no octet of the program, until [`set`](Self::set).
#[derive(Debug)]
pub struct Exclusive<T> {
    is_used: AtomicBool,
    is_set: AtomicBool,
    data: UnsafeCell<MaybeUninit<T>>,
}

// SAFETY: `with` gives the data to one context at a time. The program runs on one core, and a context that interrupts another
// ends before the other goes on: between the load and the store in `with` it leaves `is_used` as it was.
unsafe impl<T: Send> Sync for Exclusive<T> {}

impl<T> Default for Exclusive<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T> Exclusive<T> {
    /// No data yet.
    pub const fn new() -> Self {
        Self {
            is_used: AtomicBool::new(false),
            is_set: AtomicBool::new(false),
            data: UnsafeCell::new(MaybeUninit::uninit()),
        }
    }

    /// Sets the data, which are made in their place; those before are not dropped. Returns whether no other context uses them.
    #[inline]
    pub fn set(&self, make: impl FnOnce() -> T) -> bool {
        self.enter(|place| {
            place.write(make());
            self.is_set.store(true, Ordering::Relaxed);
        })
        .is_some()
    }

    /// Forgets the data, without a drop, until the next [`set`](Self::set).
    #[inline]
    pub fn clear(&self) {
        self.is_set.store(false, Ordering::Relaxed);
    }

    /// Whether there are data.
    #[inline]
    #[must_use]
    pub fn is_set(&self) -> bool {
        self.is_set.load(Ordering::Relaxed)
    }

    /// Calls `use_data` with the data; `None` if there are none, or if this context has interrupted a use.
    #[inline]
    pub fn with<R>(&self, use_data: impl FnOnce(&mut T) -> R) -> Option<R> {
        if !self.is_set.load(Ordering::Relaxed) {
            return None;
        }
        // SAFETY: `set` has written the data.
        self.enter(|place| use_data(unsafe { place.assume_init_mut() }))
    }

    #[inline]
    fn enter<R>(&self, action: impl FnOnce(&mut MaybeUninit<T>) -> R) -> Option<R> {
        if self.is_used.load(Ordering::Relaxed) {
            return None;
        }
        self.is_used.store(true, Ordering::Relaxed);
        compiler_fence(Ordering::SeqCst);
        // SAFETY: `is_used` was false, so no other reference exists, and none is made until it is false again.
        let result = action(unsafe { &mut *self.data.get() });
        compiler_fence(Ordering::SeqCst);
        self.is_used.store(false, Ordering::Relaxed);
        Some(result)
    }
}
