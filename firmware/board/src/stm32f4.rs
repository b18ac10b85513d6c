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

use crate::cortex::{
    EXCEPTIONS, Vector, handlers, modify, read, register, start_interrupts, start_systick, vectors, write,
};
use crate::outgoing::OUTGOING;
use crate::{Handlers, Light, LineError};
use core::ptr::{read_volatile, write_volatile};

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
    register(handlers);
    // Every 10 ms.
    start_systick(1_680_000);
    start_interrupts(&[USART_1_INTERRUPT, TIMER_2_INTERRUPT]);
    write(USART_CONTROL, CONTROL);
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

/// Drops what was prepared or is being sent, and the alarm.
pub fn cancel() {
    modify(TIMER_2 + 0xC, 1 << 1, 0);
    OUTGOING.cancel();
}

/// The time; wraps.
#[inline]
#[must_use]
pub fn ticks() -> u32 {
    read(TIMER_2 + 0x24)
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

/// Begins to send what was prepared, once.
pub fn send() {
    if OUTGOING.begin() {
        write(GPIO_A + 0x18, 1 << 8);
        write(USART_CONTROL, CONTROL | ON_EMPTY);
    }
}

fn send_next() {
    if let Some(octet) = OUTGOING.take() {
        write(USART_DATA, u32::from(octet));
    }
    if OUTGOING.is_over() {
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

/// Tells the watchdog that the program runs.
pub fn feed_watchdog() {
    write(WATCHDOG, 0xAAAA);
}

/// The address switch; above 125 the stored address holds.
#[must_use]
pub fn address_switch() -> u8 {
    !read(GPIO_B + 0x10) as u8
}

/// Switches a light on or off.
pub fn set_light(light: Light, on: bool) {
    let pin = match light {
        Light::Bus => 12,
        Light::Fault => 14,
    };
    write(GPIO_D + 0x18, 1 << if on { pin } else { pin + 16 });
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

/// The vector table: exceptions, interrupts 0 to 81.
#[used]
#[unsafe(link_section = ".vectors")]
static VECTORS: [Vector; EXCEPTIONS + 82] = vectors(&[(TIMER_2_INTERRUPT, on_timer), (USART_1_INTERRUPT, on_usart)]);
