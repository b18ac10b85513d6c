//! STM32F407 at 168 MHz with a crystal of 8 MHz, as on the Discovery board, and STM32F411 at 96 MHz with one of 25 MHz, as on the Black
//! Pill. **Not yet on hardware.**
//!
//! | Use | STM32F407 | STM32F411 |
//! |---|---|---|
//! | transmitter and receiver of USART1 | PB6, PB7 | PB6, PB7 |
//! | direction of the transceiver, high while the gauge sends | PA8 | PA8 |
//! | address switch, closed to ground for 1 | PE8 ... PE15 | PA0 ... PA7 |
//! | lights: data exchange, fault | PD12, PD14 | PC13 (low is on), PB12 |
//! | analogue input | PB1 | PB1 |
//!
//! PB2 is BOOT1, which both boards pull down; PA9 has the capacitor of a USB supply on the Discovery board. Registers and their bits are
//! those of the reference manuals RM0090 and RM0383.

use crate::cortex::{
    EXCEPTIONS, Vector, handlers, modify, read, register, start_interrupts, start_systick, vectors, write,
};
use crate::outgoing::OUTGOING;
use crate::{Handlers, Light, LineError};
use core::ptr::{read_volatile, write_volatile};

/// What the microcontrollers differ in.
#[cfg(feature = "stm32f407")]
mod chip {
    use super::{GPIO_D, GPIO_E, Lamp};

    pub const NAME: &str = "STM32F407";
    pub const PROCESSOR_HZ: u32 = 168_000_000;
    /// TIM2 has twice the clock of APB1, USART1 that of APB2.
    pub const TIMER_HZ: u32 = 84_000_000;
    pub const USART_HZ: u32 = 84_000_000;
    /// The wait states of the flash.
    pub const LATENCY: u32 = 5;
    /// The scale of the voltage regulator for this clock.
    pub const VOLTAGE: u32 = 1 << 14;
    /// 8 MHz / 8 * 336 / 2; 48 MHz for USB, which is not used.
    pub const PLL: u32 = 8 | 336 << 6 | 1 << 22 | 7 << 24;
    /// APB1 a quarter, APB2 a half.
    pub const BUSES: u32 = 0b101 << 10 | 0b100 << 13;
    /// GPIO A, B, D, E.
    pub const PORTS: u32 = 0b1_1011;
    pub const SWITCHES: (usize, u32) = (GPIO_E, 8);
    pub const BUS_LIGHT: Lamp = Lamp { port: GPIO_D, pin: 12, low_is_on: false };
    pub const FAULT_LIGHT: Lamp = Lamp { port: GPIO_D, pin: 14, low_is_on: false };
}

/// What the microcontrollers differ in.
#[cfg(feature = "stm32f411")]
mod chip {
    use super::{GPIO_A, GPIO_B, GPIO_C, Lamp};

    pub const NAME: &str = "STM32F411";
    pub const PROCESSOR_HZ: u32 = 96_000_000;
    /// TIM2 has twice the clock of APB1, USART1 that of APB2.
    pub const TIMER_HZ: u32 = 96_000_000;
    pub const USART_HZ: u32 = 96_000_000;
    /// The wait states of the flash.
    pub const LATENCY: u32 = 3;
    /// The scale of the voltage regulator for this clock.
    pub const VOLTAGE: u32 = 0b11 << 14;
    /// 25 MHz / 25 * 192 / 2; 48 MHz for USB, which is not used.
    pub const PLL: u32 = 25 | 192 << 6 | 1 << 22 | 4 << 24;
    /// APB1 a half, APB2 undivided.
    pub const BUSES: u32 = 0b100 << 10;
    /// GPIO A, B, C.
    pub const PORTS: u32 = 0b111;
    pub const SWITCHES: (usize, u32) = (GPIO_A, 0);
    pub const BUS_LIGHT: Lamp = Lamp { port: GPIO_C, pin: 13, low_is_on: true };
    pub const FAULT_LIGHT: Lamp = Lamp { port: GPIO_B, pin: 12, low_is_on: false };
}

/// The name of the board.
pub const NAME: &str = chip::NAME;

/// The ticks of the timer in a second.
pub const TICKS_PER_SECOND: u32 = chip::TIMER_HZ;

/// The port measures the idle time of PROFIBUS itself.
pub const IDLE_US: u64 = 0;

/// An answer is never sent after max T_SDR.
pub const TOLERANCE_US: u64 = 0;

/// The lowest bit rate of the serial port, and the highest: USART1 with eightfold oversampling.
pub const RATES: (u32, u32) = (9_600, 6_000_000);

const RCC: usize = 0x4002_3800;
const FLASH: usize = 0x4002_3C00;
const GPIO_A: usize = 0x4002_0000;
const GPIO_B: usize = 0x4002_0400;
#[cfg(feature = "stm32f411")]
const GPIO_C: usize = 0x4002_0800;
#[cfg(feature = "stm32f407")]
const GPIO_D: usize = 0x4002_0C00;
#[cfg(feature = "stm32f407")]
const GPIO_E: usize = 0x4002_1000;
const POWER: usize = 0x4000_7000;
const USART_1: usize = 0x4001_1000;
const TIMER_2: usize = 0x4000_0000;
const WATCHDOG: usize = 0x4000_3000;
const CONVERTER: usize = 0x4001_2000;

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

/// A light at a pin.
#[derive(Clone, Copy)]
struct Lamp {
    port: usize,
    pin: u32,
    low_is_on: bool,
}

/// The clock of the processor from the crystal.
fn start_clock() {
    modify(RCC, 0, 1 << 16);
    while read(RCC) & 1 << 17 == 0 {}
    // The regulator has its clock, and its scale before the PLL runs.
    modify(RCC + 0x40, 0, 1 << 28);
    modify(POWER, 0b11 << 14, chip::VOLTAGE);
    // Wait states, prefetch, caches.
    write(FLASH, chip::LATENCY | 0b111 << 8);
    write(RCC + 0x4, chip::PLL);
    modify(RCC, 0, 1 << 24);
    while read(RCC) & 1 << 25 == 0 {}
    // The system clock from the PLL.
    write(RCC + 0x8, chip::BUSES | 0b10);
    while read(RCC + 0x8) & 0b1100 != 0b1000 {}
}

/// Starts clock, timer, serial port and interrupts.
pub fn start(handlers: &'static Handlers) {
    register(handlers);
    // Every 10 ms.
    start_systick(chip::PROCESSOR_HZ / 100);
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
    // GPIO, TIM2, USART1.
    modify(RCC + 0x30, 0, chip::PORTS);
    modify(RCC + 0x40, 0, 1);
    modify(RCC + 0x44, 0, 1 << 4);
    // PA8 output, PB6 and PB7 alternate function 7.
    modify(GPIO_A, 0b11 << 16, 0b01 << 16);
    modify(GPIO_B, 0b1111 << 12, 0b1010 << 12);
    modify(GPIO_B + 0x20, 0xFF << 24, 0x77 << 24);
    // PA8 and PB6 fast: at 6 Mbit/s a bit has 167 ns, and a slow pin needs 100 ns for an edge.
    modify(GPIO_A + 0x8, 0b11 << 16, 0b10 << 16);
    modify(GPIO_B + 0x8, 0b11 << 12, 0b10 << 12);
    // PB7 with a pull-up: the transceiver lets it float while the gauge sends.
    modify(GPIO_B + 0xC, 0b11 << 14, 0b01 << 14);
    // Switches: inputs with pull-ups.
    let (port, first) = chip::SWITCHES;
    modify(port, 0xFFFF << (2 * first), 0);
    modify(port + 0xC, 0xFFFF << (2 * first), 0x5555 << (2 * first));
    for Lamp { port, pin, .. } in [chip::BUS_LIGHT, chip::FAULT_LIGHT] {
        modify(port, 0b11 << (2 * pin), 0b01 << (2 * pin));
    }
    for light in [Light::Bus, Light::Fault] {
        set_light(light, false);
    }
    write(TIMER_2 + 0x2C, u32::MAX);
    write(TIMER_2, 1);
}

/// Sets the bit rate. Returns whether the port has it.
pub fn set_rate(bits_per_second: u32) -> bool {
    if !(RATES.0..=RATES.1).contains(&bits_per_second) {
        return false;
    }
    // USARTDIV in eighths: the fraction has three bits, and bit 3 stays 0.
    let divisor = (chip::USART_HZ + bits_per_second / 2) / bits_per_second;
    write(USART_RATE, divisor / 8 << 4 | divisor % 8);
    true
}

/// Drops what waits to be sent, and the alarm.
pub fn withdraw() {
    modify(TIMER_2 + 0xC, 1 << 1, 0);
    OUTGOING.withdraw();
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
        OUTGOING.ended();
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
    let (port, first) = chip::SWITCHES;
    !(read(port + 0x10) >> first) as u8
}

/// The next conversion of the analogue input, in steps of 12 bits.
#[must_use]
pub fn analog_input() -> u16 {
    // ADC1, and PB1 analogue.
    modify(RCC + 0x44, 0, 1 << 8);
    modify(GPIO_B, 0, 0b11 << 2);
    // A quarter of the clock of APB2; channel 9, sampled for 480 cycles.
    modify(CONVERTER + 0x304, 0b11 << 16, 0b01 << 16);
    modify(CONVERTER + 0x10, 0, 0b111 << 27);
    write(CONVERTER + 0x34, 9);
    if read(CONVERTER + 0x8) & 1 == 0 {
        write(CONVERTER + 0x8, 1);
        // It is stable after 3 us.
        let start = ticks();
        while ticks().wrapping_sub(start) < chip::TIMER_HZ / 250_000 {}
    }
    write(CONVERTER, 0);
    modify(CONVERTER + 0x8, 0, 1 << 30);
    while read(CONVERTER) & 1 << 1 == 0 {}
    read(CONVERTER + 0x4C) as u16
}

/// Switches a light on or off.
pub fn set_light(light: Light, on: bool) {
    let Lamp { port, pin, low_is_on } = match light {
        Light::Bus => chip::BUS_LIGHT,
        Light::Fault => chip::FAULT_LIGHT,
    };
    write(port + 0x18, 1 << if on != low_is_on { pin } else { pin + 16 });
}

/// The two pages for nonvolatile values: sectors 1 and 2, of which the first 4 KiB are used.
///
/// While a sector is erased or a word is written the processor cannot read its program: the gauge answers nothing for up to 0.8 s or
/// 100 us. Both wait until no answer is being sent or waits.
pub mod flash {
    use super::{FLASH, modify, read, read_volatile, write, write_volatile};
    use crate::cortex::barrier;
    use crate::outgoing::while_silent;

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
        while_silent(|| {
            write(KEY, 0x4567_0123);
            write(KEY, 0xCDEF_89AB);
            // Errors of before.
            write(STATUS, 0xF2);
            // 32 bits at a time.
            write(CONTROL, control | 0b10 << 8);
            action();
            // The write has reached the flash before its state is read.
            barrier();
            while read(STATUS) & 1 << 16 != 0 {}
            write(CONTROL, 1 << 31);
        });
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
