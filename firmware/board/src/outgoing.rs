//! The octets that are being sent.

use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicU32, Ordering};

/// The longest telegram.
const BUFFER: usize = 256;

/// The octets that are being sent. The character context reads them, and `prepare` writes them while nothing is being sent.
pub struct Outgoing {
    octets: UnsafeCell<[u8; BUFFER]>,
    /// The octets that are prepared.
    length: AtomicU32,
    next: AtomicU32,
    end: AtomicU32,
}

// SAFETY: `prepare` writes the octets only while `next` equals `end`, and `take` reads them only while it does not.
unsafe impl Sync for Outgoing {}

/// The octets of the bus.
pub static OUTGOING: Outgoing = Outgoing {
    octets: UnsafeCell::new([0; BUFFER]),
    length: AtomicU32::new(0),
    next: AtomicU32::new(0),
    end: AtomicU32::new(0),
};

impl Outgoing {
    /// Whether all octets were taken.
    pub fn is_over(&self) -> bool {
        self.next.load(Ordering::Relaxed) >= self.end.load(Ordering::Acquire)
    }

    /// Begins to send what was prepared, once. Returns whether there is something.
    pub fn begin(&self) -> bool {
        let length = self.length.load(Ordering::Acquire);
        self.length.store(0, Ordering::Relaxed);
        if length > 0 {
            self.next.store(0, Ordering::Relaxed);
            self.end.store(length, Ordering::Release);
        }
        length > 0
    }

    /// The next octet.
    pub fn take(&self) -> Option<u8> {
        if self.is_over() {
            return None;
        }
        let next = self.next.load(Ordering::Relaxed);
        // SAFETY: octets are being sent, so `prepare` does not write them.
        let octet = unsafe { &*self.octets.get() }.get(next as usize).copied();
        self.next.store(next.wrapping_add(1), Ordering::Release);
        octet
    }

    /// Drops what was prepared or is being sent.
    pub fn cancel(&self) {
        self.length.store(0, Ordering::Relaxed);
        self.next.store(self.end.load(Ordering::Relaxed), Ordering::Relaxed);
    }
}

/// Copies octets that `send` sends. Returns whether nothing is being sent and the octets fit.
pub fn prepare(octets: &[u8]) -> bool {
    if !OUTGOING.is_over() {
        return false;
    }
    // SAFETY: nothing is being sent, so the interrupt does not read the octets.
    let Some(target) = (unsafe { &mut *OUTGOING.octets.get() }).get_mut(..octets.len()) else { return false };
    target.copy_from_slice(octets);
    OUTGOING.length.store(octets.len() as u32, Ordering::Release);
    true
}
