//! STM32F407 at 168 MHz: Discovery, Nucleo and Black Pill boards with another crystal need another `PLL`. **Not yet on hardware.**
//!
//! | Pin | Use |
//! |---|---|
//! | PA9, PA10 | transmitter and receiver of USART1 |
//! | PA8 | direction of the transceiver, high while the gauge sends |
//! | PB0 ... PB7 | address switch, closed to ground for 1 |
//! | PD12, PD14 | lights: data exchange, fault |
//!
//! Registers and their bits are those of the reference manual RM0090.

use crate::start::{reset, unexpected};
use crate::{Handlers, LineError};
use core::cell::UnsafeCell;
use core::ptr::{read_volatile, write_volatile};
use core::sync::atomic::{AtomicU32, Ordering};

/// The name of the board.
pub const NAME: &str = "STM32F407";

/// The ticks of the timer in a second: TIM2, twice the clock of APB1.
pub const TICKS_PER_SECOND: u32 = 84_000_000;

/// The port measures the idle time of PROFIBUS itself.
pub const IDLE_US: u64 = 0;

/// An answer is never sent after max T_SDR.
pub const TOLERANCE_US: u64 = 0;

/// The lowest bit rate of the serial port, and the highest: USART1 with 84 MHz and eightfold oversampling.
pub const RATES: (u32, u32) = (9_600, 6_000_000);

/// The clock of USART1.
const USART_HZ: u32 = 84_000_000;

const RCC: usize = 0x4002_3800;
const FLASH: usize = 0x4002_3C00;
const GPIO_A: usize = 0x4002_0000;
const GPIO_B: usize = 0x4002_0400;
const GPIO_D: usize = 0x4002_0C00;
const USART_1: usize = 0x4001_1000;
const TIMER_2: usize = 0x4000_0000;
const WATCHDOG: usize = 0x4000_3000;
const NVIC_ENABLE: usize = 0xE000_E100;
const NVIC_PRIORITY: usize = 0xE000_E400;
const SYSTEM_PRIORITY_3: usize = 0xE000_ED20;
const ICSR: usize = 0xE000_ED04;
const AIRCR: usize = 0xE000_ED0C;

const USART_STATUS: usize = USART_1;
const USART_DATA: usize = USART_1 + 0x4;
const USART_RATE: usize = USART_1 + 0x8;
const USART_CONTROL: usize = USART_1 + 0xC;

/// Enabled, nine bits with even parity, eightfold oversampling, transmitter, receiver, interrupt of the receiver.
const CONTROL: u32 = 1 << 15 | 1 << 13 | 1 << 12 | 1 << 10 | 1 << 5 | 1 << 3 | 1 << 2;
/// Interrupts of the transmitter: register empty, and last bit sent.
const ON_EMPTY: u32 = 1 << 7;
const ON_COMPLETE: u32 = 1 << 6;

/// Interrupt numbers.
const USART_1_INTERRUPT: usize = 37;
const TIMER_2_INTERRUPT: usize = 28;

fn read(register: usize) -> u32 {
    // SAFETY: only called with registers of RM0090.
    unsafe { read_volatile(register as *const u32) }
}

fn write(register: usize, value: u32) {
    // SAFETY: as in `read`. No register of these makes the processor write to RAM.
    unsafe { write_volatile(register as *mut u32, value) }
}

fn modify(register: usize, clear: u32, set: u32) {
    write(register, read(register) & !clear | set);
}

const BUFFER: usize = 256;

/// The octets that are being sent. The character context reads them, and `prepare` writes them while nothing is being sent.
struct Outgoing {
    octets: UnsafeCell<[u8; BUFFER]>,
    length: AtomicU32,
    next: AtomicU32,
    end: AtomicU32,
}

// SAFETY: `prepare` writes the octets only while `next` equals `end`, and the interrupt reads them only while it does not.
unsafe impl Sync for Outgoing {}

static OUTGOING: Outgoing = Outgoing {
    octets: UnsafeCell::new([0; BUFFER]),
    length: AtomicU32::new(0),
    next: AtomicU32::new(0),
    end: AtomicU32::new(0),
};

struct Registered(UnsafeCell<Option<&'static Handlers>>);

// SAFETY: written once, by `start`, before interrupts are enabled.
unsafe impl Sync for Registered {}

static HANDLERS: Registered = Registered(UnsafeCell::new(None));

#[inline]
fn handlers() -> Option<&'static Handlers> {
    // SAFETY: `start` has written it before the first interrupt.
    unsafe { *HANDLERS.0.get() }
}

/// 168 MHz from a crystal of 8 MHz.
fn start_clock() {
    modify(RCC, 0, 1 << 16);
    while read(RCC) & 1 << 17 == 0 {}
    // Five wait states, prefetch, caches.
    write(FLASH, 5 | 0b111 << 8);
    // 8 MHz / 8 * 336 / 2; 48 MHz for USB, which is not used.
    write(RCC + 0x4, 8 | 336 << 6 | 1 << 22 | 7 << 24);
    modify(RCC, 0, 1 << 24);
    while read(RCC) & 1 << 25 == 0 {}
    // APB1 a quarter, APB2 a half; the system clock from the PLL.
    write(RCC + 0x8, 0b101 << 10 | 0b100 << 13 | 0b10);
    while read(RCC + 0x8) & 0b1100 != 0b1000 {}
}

/// Starts clock, timer, serial port and interrupts.
pub fn start(handlers: &'static Handlers) {
    // SAFETY: no interrupt is enabled yet, so nothing reads it.
    unsafe { *HANDLERS.0.get() = Some(handlers) };
    // USART1: the high priority; the work: the lowest.
    write(SYSTEM_PRIORITY_3, 0xFF << 16);
    for interrupt in [USART_1_INTERRUPT, TIMER_2_INTERRUPT] {
        modify(NVIC_PRIORITY + (interrupt & !3), 0xFF << (interrupt % 4 * 8), 0);
        write(NVIC_ENABLE + interrupt / 32 * 4, 1 << (interrupt % 32));
    }
    write(USART_CONTROL, CONTROL);
    // A tick of SysTick ends a wait, every 10 ms.
    write(0xE000_E014, 1_679_999);
    write(0xE000_E018, 0);
    write(0xE000_E010, 0b111);
    // The watchdog: 32 kHz / 64, 2 s.
    write(WATCHDOG, 0x5555);
    write(WATCHDOG + 0x4, 4);
    write(WATCHDOG + 0x8, 1000);
    write(WATCHDOG, 0xCCCC);
}

/// Starts the clock, the timer and the pins. The first call of a program.
pub fn start_timer() {
    start_clock();
    // GPIO A, B, D; TIM2; USART1.
    modify(RCC + 0x30, 0, 0b1011);
    modify(RCC + 0x40, 0, 1);
    modify(RCC + 0x44, 0, 1 << 4);
    // PA8 output, PA9 and PA10 alternate function 7.
    modify(GPIO_A, 0b11_1111 << 16, 0b10_1001 << 16);
    modify(GPIO_A + 0x24, 0xFF0, 0x770);
    // PB0 to PB7 inputs with pull-ups, PD12 and PD14 outputs.
    modify(GPIO_B + 0xC, 0xFFFF, 0x5555);
    modify(GPIO_D, 0b11 << 24 | 0b11 << 28, 0b01 << 24 | 0b01 << 28);
    write(TIMER_2 + 0x2C, u32::MAX);
    write(TIMER_2, 1);
}

/// Sets the bit rate. Returns whether the port has it.
pub fn set_rate(bits_per_second: u32) -> bool {
    if !(RATES.0..=RATES.1).contains(&bits_per_second) {
        return false;
    }
    // USARTDIV in eighths: the fraction has three bits, and bit 3 stays 0.
    let divisor = (USART_HZ + bits_per_second / 2) / bits_per_second;
    write(USART_RATE, divisor / 8 << 4 | divisor % 8);
    true
}

/// The time; wraps.
#[inline]
#[must_use]
pub fn ticks() -> u32 {
    read(TIMER_2 + 0x24)
}

/// Calls [`Handlers::work`] as soon as no character is being handled.
#[inline]
pub fn request_work() {
    write(ICSR, 1 << 28);
}

/// Calls [`Handlers::alarm`] after this number of ticks, at least one. Replaces the alarm before.
pub fn set_alarm(after: u32) {
    write(TIMER_2 + 0x34, ticks().wrapping_add(after.max(1)));
    write(TIMER_2 + 0x10, 0);
    modify(TIMER_2 + 0xC, 0, 1 << 1);
    if ticks().wrapping_sub(read(TIMER_2 + 0x34)) < u32::MAX / 2 {
        // The time came before the comparison was on.
        write(TIMER_2 + 0x14, 1 << 1);
    }
}

/// Copies octets that [`send`] sends. Returns whether nothing is being sent and the octets fit.
pub fn prepare(octets: &[u8]) -> bool {
    if OUTGOING.next.load(Ordering::Relaxed) != OUTGOING.end.load(Ordering::Relaxed) {
        return false;
    }
    // SAFETY: nothing is being sent, so the interrupt does not read the octets.
    let Some(place) = (unsafe { &mut *OUTGOING.octets.get() }).get_mut(..octets.len()) else { return false };
    place.copy_from_slice(octets);
    OUTGOING.length.store(octets.len() as u32, Ordering::Release);
    true
}

/// Begins to send what was prepared, once.
pub fn send() {
    let length = OUTGOING.length.load(Ordering::Acquire);
    OUTGOING.length.store(0, Ordering::Relaxed);
    if length > 0 {
        OUTGOING.next.store(0, Ordering::Relaxed);
        OUTGOING.end.store(length, Ordering::Release);
        write(GPIO_A + 0x18, 1 << 8);
        write(USART_CONTROL, CONTROL | ON_EMPTY);
    }
}

fn send_next() {
    let next = OUTGOING.next.load(Ordering::Relaxed);
    // SAFETY: octets are being sent, so `prepare` does not write them.
    if let Some(octet) = unsafe { &*OUTGOING.octets.get() }.get(next as usize) {
        write(USART_DATA, u32::from(*octet));
    }
    let next = next.wrapping_add(1);
    OUTGOING.next.store(next, Ordering::Release);
    if next >= OUTGOING.end.load(Ordering::Acquire) {
        write(USART_CONTROL, CONTROL | ON_COMPLETE);
    }
}

extern "C" fn on_usart() {
    let status = read(USART_STATUS);
    let control = read(USART_CONTROL);
    // Received, or overrun.
    if status & (1 << 5 | 1 << 3) != 0 {
        let octet = read(USART_DATA) as u8;
        let is_bad = status & 0b1111 != 0;
        if let Some(handlers) = handlers() {
            (handlers.character)(if is_bad { Err(LineError) } else { Ok(octet) });
        }
    }
    if status & 1 << 7 != 0 && control & ON_EMPTY != 0 {
        send_next();
    } else if status & 1 << 6 != 0 && control & ON_COMPLETE != 0 {
        write(USART_CONTROL, CONTROL);
        write(GPIO_A + 0x18, 1 << (8 + 16));
        if let Some(handlers) = handlers() {
            (handlers.sent)();
        }
    }
}

extern "C" fn on_timer() {
    modify(TIMER_2 + 0xC, 1 << 1, 0);
    write(TIMER_2 + 0x10, 0);
    if let Some(handlers) = handlers() {
        (handlers.alarm)();
    }
}

extern "C" fn on_tick() {}

extern "C" fn on_work() {
    if let Some(handlers) = handlers() {
        (handlers.work)();
    }
}

/// Waits for an interrupt.
pub fn wait() {
    // SAFETY: has no effect on memory.
    unsafe { core::arch::asm!("wfi") };
}

/// Tells the watchdog that the program runs.
pub fn feed_watchdog() {
    write(WATCHDOG, 0xAAAA);
}

/// The address switch; above 125 the stored address holds.
#[must_use]
pub fn address_switch() -> u8 {
    !read(GPIO_B + 0x10) as u8
}

/// A light of the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Light {
    /// Data exchange.
    Bus,
    /// A fault.
    Fault,
}

/// Switches a light on or off.
pub fn set_light(light: Light, on: bool) {
    let pin = match light {
        Light::Bus => 12,
        Light::Fault => 14,
    };
    write(GPIO_D + 0x18, 1 << if on { pin } else { pin + 16 });
}

/// Resets the processor.
pub fn restart() -> ! {
    write(AIRCR, 0x05FA_0004);
    loop {
        wait();
    }
}

/// The two pages for nonvolatile values: sectors 1 and 2, of which the first 4 KiB are used.
///
/// While a sector is erased the processor cannot read its program: the gauge answers nothing for up to 0.8 s.
pub mod flash {
    use super::{FLASH, modify, read, read_volatile, write, write_volatile};

    /// The octets of a page.
    pub const PAGE: usize = 4096;

    const FIRST: usize = 0x0800_4000;
    const SECTOR: usize = 0x4000;
    const KEY: usize = FLASH + 0x4;
    const STATUS: usize = FLASH + 0xC;
    const CONTROL: usize = FLASH + 0x10;

    fn address(page: usize, offset: usize) -> usize {
        FIRST + page % 2 * SECTOR + (offset & (PAGE - 4))
    }

    /// The word at `offset` of a page, 0 or 1.
    #[must_use]
    pub fn word(page: usize, offset: usize) -> u32 {
        // SAFETY: the address is inside sectors 1 and 2, in which there is no program.
        unsafe { read_volatile(address(page, offset) as *const u32) }
    }

    fn operate(control: u32, action: impl FnOnce()) {
        write(KEY, 0x4567_0123);
        write(KEY, 0xCDEF_89AB);
        // Errors of before.
        write(STATUS, 0xF2);
        // 32 bits at a time.
        write(CONTROL, control | 0b10 << 8);
        action();
        while read(STATUS) & 1 << 16 != 0 {}
        write(CONTROL, 1 << 31);
    }

    /// Programs a word that is erased.
    pub fn program(page: usize, offset: usize, value: u32) {
        // SAFETY: as in `word`; the flash takes the word instead of the bus.
        operate(1, || unsafe { write_volatile(address(page, offset) as *mut u32, value) });
    }

    /// Erases a page.
    pub fn erase(page: usize) {
        let sector = 1 + page as u32 % 2;
        operate(1 << 1 | sector << 3, || modify(CONTROL, 0, 1 << 16));
        // The data cache may have the words of before.
        modify(FLASH, 1 << 10, 0);
        modify(FLASH, 0, 1 << 12);
        modify(FLASH, 1 << 12, 0);
        modify(FLASH, 0, 1 << 10);
    }
}

#[repr(C)]
union Vector {
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

/// The vector table: stack, reset, exceptions, interrupts 0 to 81.
#[used]
#[unsafe(link_section = ".vectors")]
static VECTORS: [Vector; 98] = {
    let mut vectors = [const { Vector { handler: unexpected } }; 98];
    vectors[0] = Vector { stack: &raw const __stack_top };
    vectors[1] = Vector { reset };
    vectors[7] = Vector { reserved: 0 };
    vectors[8] = Vector { reserved: 0 };
    vectors[9] = Vector { reserved: 0 };
    vectors[10] = Vector { reserved: 0 };
    vectors[13] = Vector { reserved: 0 };
    vectors[14] = Vector { handler: on_work };
    vectors[15] = Vector { handler: on_tick };
    vectors[16 + TIMER_2_INTERRUPT] = Vector { handler: on_timer };
    vectors[16 + USART_1_INTERRUPT] = Vector { handler: on_usart };
    vectors
};
