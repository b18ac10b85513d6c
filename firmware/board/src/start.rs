//! Start of the processor, and what all Cortex-M have.

use crate::cortex::request_work;
use core::arch::asm;
use core::ptr::{read_volatile, write_volatile};
use core::sync::atomic::{AtomicBool, Ordering, compiler_fence};

unsafe extern "C" {
    static mut __data_start: u32;
    static mut __data_end: u32;
    static __data_load: u32;
    static mut __bss_start: u32;
    static mut __bss_end: u32;
    static __stack_top: u32;
}

unsafe extern "Rust" {
    /// The program, with `#[unsafe(no_mangle)]`: [`entry`](crate::entry) makes it.
    safe fn __profivac_main() -> !;
}

/// The octets with which the free stack is filled at the start.
const PAINT: u32 = 0x5041_494E;

/// Declares the function where the program begins: `entry!(main)`.
#[macro_export]
macro_rules! entry {
    ($main:path) => {
        #[doc(hidden)]
        #[unsafe(no_mangle)]
        fn __profivac_main() -> ! {
            $main()
        }
    };
}

/// The first instructions after a reset.
///
/// # Safety
/// Only the processor calls it, with the stack pointer at the top of the stack.
pub unsafe extern "C" fn reset() -> ! {
    // SAFETY: nothing else runs yet; the symbols of the linker script enclose these sections and the free stack.
    unsafe {
        #[cfg(target_abi = "eabihf")]
        {
            // CPACR: the compiler may use the FPU from here on.
            let cpacr = 0xE000_ED88 as *mut u32;
            write_volatile(cpacr, read_volatile(cpacr) | 0xF << 20);
            asm!("dsb", "isb");
        }
        let mut from = &raw const __data_load;
        let mut to = &raw mut __data_start;
        while to < &raw mut __data_end {
            write_volatile(to, read_volatile(from));
            to = to.add(1);
            from = from.add(1);
        }
        let mut to = &raw mut __bss_start;
        while to < &raw mut __bss_end {
            write_volatile(to, 0);
            to = to.add(1);
        }
        // The stack of this function lies above.
        let mut stack: u32;
        asm!("mov {}, sp", out(reg) stack);
        let mut to = &raw mut __bss_end;
        while (to as u32) < stack {
            write_volatile(to, PAINT);
            to = to.add(1);
        }
    }
    __profivac_main()
}

/// The octets of RAM between the data and the deepest use of the stack, and the octets of the stack that were used.
#[must_use]
pub fn free_stack() -> (u32, u32) {
    // SAFETY: reads words between the data and the top of the stack.
    unsafe {
        let start = &raw const __bss_end;
        let top = &raw const __stack_top as u32;
        let mut at = start;
        while (at as u32) < top && read_volatile(at) == PAINT {
            at = at.add(1);
        }
        ((at as u32).wrapping_sub(start as u32), top.wrapping_sub(at as u32))
    }
}

/// Calls `action` while no other context runs.
#[inline]
pub fn masked<R>(action: impl FnOnce() -> R) -> R {
    let before = mask();
    let result = action();
    unmask(before);
    result
}

/// Allows no interrupt; what was allowed before, for [`unmask`].
#[inline]
pub fn mask() -> u32 {
    let primask: u32;
    // SAFETY: `unmask` restores the register.
    unsafe {
        asm!("mrs {}, PRIMASK", "cpsid i", out(reg) primask);
    }
    primask
}

/// Allows interrupts if they were allowed before [`mask`].
#[inline]
pub fn unmask(before: u32) {
    if before & 1 == 0 {
        // SAFETY: interrupts were allowed before.
        unsafe {
            asm!("cpsie i");
        }
    }
}

/// The main context holds the work context up, which has been requested meanwhile.
static IS_HELD: AtomicBool = AtomicBool::new(false);
static IS_DUE: AtomicBool = AtomicBool::new(false);

/// Calls `action` while the work context does not run; the character context goes on.
#[inline]
pub fn hold_work<R>(action: impl FnOnce() -> R) -> R {
    IS_HELD.store(true, Ordering::Relaxed);
    compiler_fence(Ordering::SeqCst);
    let result = action();
    release_work();
    result
}

#[inline(never)]
fn release_work() {
    compiler_fence(Ordering::SeqCst);
    IS_HELD.store(false, Ordering::Relaxed);
    compiler_fence(Ordering::SeqCst);
    // If the work context runs here, it runs once more, for nothing.
    if IS_DUE.load(Ordering::Relaxed) {
        IS_DUE.store(false, Ordering::Relaxed);
        request_work();
    }
}

/// Whether the work context may run now; else it is requested again when the main context ends [`hold_work`].
#[inline]
pub(crate) fn may_work() -> bool {
    let is_held = IS_HELD.load(Ordering::Relaxed);
    if is_held {
        IS_DUE.store(true, Ordering::Relaxed);
    }
    !is_held
}

/// An exception that no program expects: waits for the watchdog.
pub extern "C" fn unexpected() {
    loop {
        core::hint::spin_loop();
    }
}
