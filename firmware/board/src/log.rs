//! Logs of defmt, behind the feature `defmt`.
//!
//! The emulated board writes the frames to its third serial port. A board with a debugger keeps them in RAM for the debugger (RTT), in
//! the channel of defmt-rtt.

use crate::start::masked;
use crate::{TICKS_PER_SECOND, ticks};
use core::sync::atomic::{AtomicU32, Ordering};

/// How often the timer has wrapped, and its ticks at the last look.
static WRAPS: AtomicU32 = AtomicU32::new(0);
static LAST: AtomicU32 = AtomicU32::new(0);

/// The time since [`start_timer`](crate::start_timer) in microseconds. It must be asked more often than the timer wraps.
pub fn time_us() -> u64 {
    let (wraps, low) = masked(|| {
        let now = ticks();
        let wraps = WRAPS.load(Ordering::Relaxed).wrapping_add(u32::from(now < LAST.load(Ordering::Relaxed)));
        WRAPS.store(wraps, Ordering::Relaxed);
        LAST.store(now, Ordering::Relaxed);
        (wraps, now)
    });
    (u64::from(wraps) << 32 | u64::from(low)) / u64::from(TICKS_PER_SECOND / 1_000_000)
}

defmt::timestamp!("{=u64:us}", time_us());

#[cfg(feature = "qemu")]
mod port {
    use crate::qemu::log_octets;
    use crate::start::{mask, unmask};
    use core::cell::UnsafeCell;
    use defmt::Encoder;

    #[defmt::global_logger]
    struct Port;

    struct Frame(UnsafeCell<(Encoder, u32)>);

    // SAFETY: used between `acquire` and `release` only, while no interrupt is allowed.
    unsafe impl Sync for Frame {}

    static FRAME: Frame = Frame(UnsafeCell::new((Encoder::new(), 0)));

    // SAFETY: no other context runs between `acquire` and `release`, so one frame is written at a time.
    unsafe impl defmt::Logger for Port {
        fn acquire() {
            let before = mask();
            // SAFETY: interrupts are masked.
            let (encoder, mask) = unsafe { &mut *FRAME.0.get() };
            *mask = before;
            encoder.start_frame(log_octets);
        }

        unsafe fn flush() {}

        unsafe fn release() {
            // SAFETY: `acquire` has masked the interrupts.
            let (encoder, before) = unsafe { &mut *FRAME.0.get() };
            encoder.end_frame(log_octets);
            unmask(*before);
        }

        unsafe fn write(octets: &[u8]) {
            // SAFETY: as in `release`.
            let (encoder, _) = unsafe { &mut *FRAME.0.get() };
            encoder.write(octets, log_octets);
        }
    }
}

#[cfg(not(feature = "qemu"))]
mod debugger {
    use crate::start::{mask, unmask};
    use defmt_rtt as _;

    struct Masked;
    critical_section::set_impl!(Masked);

    // SAFETY: one core, and no interrupt between `acquire` and `release`.
    unsafe impl critical_section::Impl for Masked {
        unsafe fn acquire() -> u32 {
            mask()
        }

        unsafe fn release(before: u32) {
            unmask(before);
        }
    }
}
