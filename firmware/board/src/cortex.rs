//! What all boards have: registers, the handlers, and the exceptions of every Cortex-M.

use crate::Handlers;
use crate::start::{may_work, reset, unexpected};
use core::cell::UnsafeCell;
use core::ptr::{read_volatile, write_volatile};

const NVIC_ENABLE: usize = 0xE000_E100;
const NVIC_PRIORITY: usize = 0xE000_E400;
const SYSTEM_PRIORITY_3: usize = 0xE000_ED20;
const SYSTICK: usize = 0xE000_E010;
const ICSR: usize = 0xE000_ED04;
const AIRCR: usize = 0xE000_ED0C;

/// Reads a register of the processor or of the board.
#[inline]
pub fn read(register: usize) -> u32 {
    // SAFETY: the boards call it with registers of their reference manual only.
    unsafe { read_volatile(register as *const u32) }
}

/// Writes a register.
#[inline]
pub fn write(register: usize, value: u32) {
    // SAFETY: as in `read`. No register of these makes the processor write to RAM.
    unsafe { write_volatile(register as *mut u32, value) }
}

/// Clears and sets bits of a register.
#[cfg_attr(feature = "qemu", allow(dead_code))]
#[inline]
pub fn modify(register: usize, clear: u32, set: u32) {
    write(register, read(register) & !clear | set);
}

struct Registered(UnsafeCell<Option<&'static Handlers>>);

// SAFETY: written once, by `register`, before interrupts are enabled.
unsafe impl Sync for Registered {}

static HANDLERS: Registered = Registered(UnsafeCell::new(None));

/// Registers the handlers; no interrupt is enabled yet.
pub fn register(handlers: &'static Handlers) {
    // SAFETY: no interrupt is enabled, so nothing reads it.
    unsafe { *HANDLERS.0.get() = Some(handlers) };
}

/// The handlers of the program.
#[inline]
pub fn handlers() -> Option<&'static Handlers> {
    // SAFETY: `register` has written it before the first interrupt.
    unsafe { *HANDLERS.0.get() }
}

/// Starts SysTick, with an interrupt after this number of cycles that only ends a wait.
pub fn start_systick(cycles: u32) {
    write(SYSTICK + 0x4, cycles - 1);
    write(SYSTICK + 0x8, 0);
    write(SYSTICK, 0b111);
}

/// The cycles of SysTick until its interrupt.
#[cfg_attr(not(feature = "rp2040"), allow(dead_code))]
#[inline]
pub fn systick() -> u32 {
    read(SYSTICK + 0x8)
}

/// Enables the interrupts of port and alarm, with the highest priority; the work has the lowest.
pub fn start_interrupts(interrupts: &[usize]) {
    write(SYSTEM_PRIORITY_3, 0xFF << 16);
    for interrupt in interrupts {
        let register = NVIC_PRIORITY + (interrupt & !3);
        write(register, read(register) & !(0xFF << (interrupt % 4 * 8)));
        write(NVIC_ENABLE + interrupt / 32 * 4, 1 << (interrupt % 32));
    }
}

/// Calls [`Handlers::work`] as soon as no character is being handled.
#[inline]
pub fn request_work() {
    write(ICSR, 1 << 28);
}

/// Ends all writes before the next instruction.
#[cfg_attr(any(feature = "qemu", feature = "rp2040"), allow(dead_code))]
pub fn barrier() {
    // SAFETY: has no effect on memory.
    unsafe { core::arch::asm!("dsb") };
}

/// Waits for an interrupt.
pub fn wait() {
    // SAFETY: has no effect on memory.
    unsafe { core::arch::asm!("wfi") };
}

/// Resets the processor.
pub fn restart() -> ! {
    write(AIRCR, 0x05FA_0004);
    loop {
        wait();
    }
}

extern "C" fn on_tick() {}

extern "C" fn on_work() {
    if may_work()
        && let Some(handlers) = handlers()
    {
        (handlers.work)();
    }
}

/// An entry of the vector table.
#[repr(C)]
pub union Vector {
    handler: extern "C" fn(),
    reset: unsafe extern "C" fn() -> !,
    stack: *const u32,
    reserved: u32,
}

// SAFETY: never changes.
unsafe impl Sync for Vector {}

unsafe extern "C" {
    static __stack_top: u32;
}

/// The number of exceptions before the first interrupt.
pub const EXCEPTIONS: usize = 16;

/// The vector table of a program, with the handlers of these interrupts.
pub const fn vectors<const N: usize>(interrupts: &[(usize, extern "C" fn())]) -> [Vector; N] {
    let mut vectors = [const { Vector { handler: unexpected } }; N];
    vectors[0] = Vector { stack: &raw const __stack_top };
    vectors[1] = Vector { reset };
    vectors[7] = Vector { reserved: 0 };
    vectors[8] = Vector { reserved: 0 };
    vectors[9] = Vector { reserved: 0 };
    vectors[10] = Vector { reserved: 0 };
    vectors[13] = Vector { reserved: 0 };
    vectors[14] = Vector { handler: on_work };
    vectors[15] = Vector { handler: on_tick };
    let mut rest = interrupts;
    while let [(interrupt, handler), after @ ..] = rest {
        vectors[EXCEPTIONS + *interrupt] = Vector { handler: *handler };
        rest = after;
    }
    vectors
}
