//! The octets that are being sent.

use crate::start::{mask, unmask};
use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering, compiler_fence};

/// The longest telegram.
const BUFFER: usize = 256;

/// The octets that are being sent. The character context reads them, and `prepare` writes them while nothing is being sent.
pub struct Outgoing {
    octets: UnsafeCell<[u8; BUFFER]>,
    /// The octets that are prepared.
    length: AtomicU32,
    next: AtomicU32,
    end: AtomicU32,
    /// The gauge drives the line: from the first octet until the last bit has left.
    drives: AtomicBool,
}

// SAFETY: `prepare` writes the octets only while nothing is prepared and `next` equals `end`, so no interrupt can begin to send;
// `take` reads them only while `next` is before `end`.
unsafe impl Sync for Outgoing {}

/// The octets of the bus.
pub static OUTGOING: Outgoing = Outgoing {
    octets: UnsafeCell::new([0; BUFFER]),
    length: AtomicU32::new(0),
    next: AtomicU32::new(0),
    end: AtomicU32::new(0),
    drives: AtomicBool::new(false),
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
            self.drives.store(true, Ordering::Relaxed);
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

    /// The last bit has left.
    pub fn ended(&self) {
        self.drives.store(false, Ordering::Release);
    }

    /// Drops what was prepared and has not begun.
    pub fn withdraw(&self) {
        self.length.store(0, Ordering::Relaxed);
        compiler_fence(Ordering::SeqCst);
    }

    /// Drops what was prepared or is being sent.
    #[cfg(feature = "qemu")]
    pub fn cancel(&self) {
        self.withdraw();
        self.next.store(self.end.load(Ordering::Relaxed), Ordering::Relaxed);
        self.ended();
    }

    /// Whether nothing is being sent or waits to be sent.
    fn is_silent(&self) -> bool {
        self.length.load(Ordering::Acquire) == 0 && !self.drives.load(Ordering::Acquire)
    }
}

/// Copies octets that `send` sends, in place of those that wait. Returns whether nothing is being sent and the octets fit.
pub fn prepare(octets: &[u8]) -> bool {
    // From here on an alarm begins nothing.
    OUTGOING.withdraw();
    if !OUTGOING.is_over() {
        return false;
    }
    // SAFETY: nothing is prepared and nothing is being sent, so no interrupt reads the octets.
    let Some(target) = (unsafe { &mut *OUTGOING.octets.get() }).get_mut(..octets.len()) else { return false };
    target.copy_from_slice(octets);
    OUTGOING.length.store(octets.len() as u32, Ordering::Release);
    true
}

/// Calls `action`, in which the processor may stand still, as soon as no answer is being sent or waits. No other context runs meanwhile.
///
/// An answer that stops in its middle holds the line for all stations, and one that begins late meets the telegram of another one.
pub fn while_silent<R>(action: impl FnOnce() -> R) -> R {
    loop {
        let before = mask();
        if OUTGOING.is_silent() {
            let result = action();
            unmask(before);
            return result;
        }
        unmask(before);
    }
}
