//! The board `mps2-an386` as QEMU emulates it: a Cortex-M4 with CMSDK serial ports and timers.
//!
//! The serial port of the emulator has no bit rate, no direction and no defects of characters: octets arrive as fast as the program
//! takes them. The first port is the bus, the second one a console, the third one has the log. Two pages of a RAM that a reset keeps stand
//! for flash: they are erased in one step and written word by word, ones to zeros only.

use crate::cortex::{
    EXCEPTIONS, Vector, handlers, read, register, restart, start_interrupts, start_systick, vectors, write,
};
use crate::outgoing::OUTGOING;
use crate::{Handlers, Light, LineError};
use core::ptr::{read_volatile, write_volatile};
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// The name of the board.
pub const NAME: &str = "mps2-an386 in QEMU";

/// The ticks of the timer in a second.
pub const TICKS_PER_SECOND: u32 = 25_000_000;

/// The idle time of the line that the program can rely on, in microseconds. The emulator delivers a telegram in pieces.
pub const IDLE_US: u64 = 20_000;

/// The emulator may be held up by other programs: how much later than max T_SDR an answer is still sent, in microseconds.
pub const TOLERANCE_US: u64 = 2_000_000;

/// The lowest bit rate of the serial port, and the highest: the emulator knows none; these are those of the board to buy.
pub const RATES: (u32, u32) = (9_600, 6_000_000);

const BUS: usize = 0x4000_4000;
const CONSOLE: usize = 0x4000_5000;
#[cfg(feature = "defmt")]
const LOG: usize = 0x4000_6000;
/// Counts down from `u32::MAX`: the time.
const TIME: usize = 0x4000_0000;
/// Counts down once: the alarm.
const ALARM: usize = 0x4000_1000;

const RECEIVED_INTERRUPT: usize = 0;
const SENT_INTERRUPT: usize = 1;
const ALARM_INTERRUPT: usize = 9;

const DATA: usize = 0x0;
const STATE: usize = 0x4;
const CONTROL: usize = 0x8;
const INTERRUPT: usize = 0xC;
const BAUD_DIVIDER: usize = 0x10;

/// Starts the timer, the serial port and the interrupts.
pub fn start(handlers: &'static Handlers) {
    register(handlers);
    write(BUS + CONTROL, 0b1011);
    // An octet that came before has caused no interrupt, and none would come until it is read.
    discard();
    // Every 10 ms.
    start_systick(TICKS_PER_SECOND / 100);
    start_interrupts(&[RECEIVED_INTERRUPT, SENT_INTERRUPT, ALARM_INTERRUPT]);
}

/// Sets the bit rate. Returns whether the port has it.
pub fn set_rate(bits_per_second: u32) -> bool {
    (RATES.0..=RATES.1).contains(&bits_per_second)
}

/// The time; wraps.
#[inline]
#[must_use]
pub fn ticks() -> u32 {
    u32::MAX.wrapping_sub(read(TIME + 0x4))
}

/// Calls [`Handlers::alarm`] after this number of ticks, at least one. Replaces the alarm before.
pub fn set_alarm(after: u32) {
    write(ALARM, 0);
    write(ALARM + 0xC, 1);
    write(ALARM + 0x4, after.max(1));
    // Counts once: the handler stops it.
    write(ALARM + 0x8, after.max(1));
    write(ALARM, 0b1001);
}

/// Begins to send what was prepared, once.
pub fn send() {
    if OUTGOING.begin() {
        write(BUS + CONTROL, 0b1111);
        send_next();
    }
}

/// Drops what waits to be sent, and the alarm.
pub fn withdraw() {
    write(ALARM, 0);
    OUTGOING.withdraw();
}

/// Drops what waits or is being sent, and the alarm.
pub fn cancel() {
    write(ALARM, 0);
    OUTGOING.cancel();
}

/// Waits for this number of ticks.
pub fn pause(wanted: u32) {
    let start = ticks();
    while ticks().wrapping_sub(start) < wanted {}
}

/// Drops the octets that have come from the bus.
pub fn discard() {
    while read(BUS + STATE) & 0b10 != 0 {
        read(BUS + DATA);
    }
}

/// Starts the timer and both ports, and no interrupt. The first call of a program.
pub fn start_timer() {
    write(TIME + 0x4, u32::MAX);
    write(TIME + 0x8, u32::MAX);
    write(TIME, 1);
    write(CONSOLE + BAUD_DIVIDER, 16);
    write(CONSOLE + CONTROL, 0b11);
    write(BUS + BAUD_DIVIDER, 16);
    write(BUS + CONTROL, 0b11);
    #[cfg(feature = "defmt")]
    {
        write(LOG + BAUD_DIVIDER, 16);
        write(LOG + CONTROL, 0b01);
    }
}

fn send_next() {
    match OUTGOING.take() {
        Some(octet) => write(BUS + DATA, u32::from(octet)),
        None => write(BUS + CONTROL, 0b1011),
    }
}

extern "C" fn on_received() {
    write(BUS + INTERRUPT, 0b10);
    let state = read(BUS + STATE);
    if state & 0b10 == 0 {
        return;
    }
    let octet = read(BUS + DATA) as u8;
    let overrun = state & 0b1000 != 0;
    if overrun {
        write(BUS + STATE, 0b1000);
    }
    if let Some(handlers) = handlers() {
        (handlers.character)(if overrun { Err(LineError) } else { Ok(octet) });
    }
}

extern "C" fn on_sent() {
    write(BUS + INTERRUPT, 0b01);
    send_next();
    if OUTGOING.is_over() && read(BUS + STATE) & 1 == 0 {
        OUTGOING.ended();
        if let Some(handlers) = handlers() {
            (handlers.sent)();
        }
    }
}

extern "C" fn on_alarm() {
    write(ALARM, 0);
    write(ALARM + 0xC, 1);
    if let Some(handlers) = handlers() {
        (handlers.alarm)();
    }
}

/// Tells the watchdog that the program runs; the emulated board has none.
pub fn feed_watchdog() {}

/// The address switch; above 125 there is none, and the stored address holds.
#[must_use]
pub fn address_switch() -> u8 {
    5
}

/// The next conversion of the analogue input, in steps of 12 bits; the emulated board has none, and always the same.
#[must_use]
pub fn analog_input() -> u16 {
    1750
}

static LIGHTS: [AtomicBool; 2] = [AtomicBool::new(false), AtomicBool::new(false)];

/// Switches a light on or off; the emulated board keeps its state.
pub fn set_light(light: Light, on: bool) {
    let [bus, fault] = &LIGHTS;
    match light {
        Light::Bus => bus,
        Light::Fault => fault,
    }
    .store(on, Ordering::Relaxed);
}

/// The lights: bus, fault.
#[must_use]
pub fn lights() -> [bool; 2] {
    LIGHTS.each_ref().map(|light| light.load(Ordering::Relaxed))
}

/// An octet from the console, if there is one.
#[must_use]
pub fn console_octet() -> Option<u8> {
    (read(CONSOLE + STATE) & 0b10 != 0).then(|| read(CONSOLE + DATA) as u8)
}

/// Writes to the console and waits until it is sent.
pub fn print(text: &[u8]) {
    write_all(CONSOLE, text);
}

/// Writes to the log and waits until it is sent.
#[cfg(feature = "defmt")]
pub(crate) fn log_octets(octets: &[u8]) {
    write_all(LOG, octets);
}

fn write_all(port: usize, octets: &[u8]) {
    for octet in octets {
        while read(port + STATE) & 1 != 0 {}
        write(port + DATA, u32::from(*octet));
    }
}

/// The two pages for nonvolatile values.
pub mod flash {
    use super::{ALARM, AtomicU32, BUS, CONTROL, Ordering, read, read_volatile, restart, write_volatile};
    use crate::outgoing::while_silent;

    /// The octets of a page.
    pub const PAGE: usize = 4096;

    const FIRST: usize = 0x2100_0000;
    const MARK: usize = FIRST + 2 * PAGE;
    const FAILED: u32 = 0xDEAD_0FF5;

    /// After this number of operations the power fails; 0 for never.
    static CUT_AFTER: AtomicU32 = AtomicU32::new(0);

    /// The number of operations since the start.
    static OPERATIONS: AtomicU32 = AtomicU32::new(0);

    /// The number of operations while an answer waited or was being sent.
    static DISTURBING: AtomicU32 = AtomicU32::new(0);

    /// The address of a word, inside the pages in any case.
    fn address(page: usize, offset: usize) -> usize {
        FIRST + page % 2 * PAGE + (offset & (PAGE - 4))
    }

    /// The word at `offset` of a page, 0 or 1.
    #[must_use]
    pub fn word(page: usize, offset: usize) -> u32 {
        // SAFETY: the address is inside the pages, a RAM that nothing else uses.
        unsafe { read_volatile(address(page, offset) as *const u32) }
    }

    /// Writes a word: bits become 0, none becomes 1.
    pub fn program(page: usize, offset: usize, value: u32) {
        while_silent(|| {
            operate();
            // SAFETY: as in `word`.
            unsafe { write_volatile(address(page, offset) as *mut u32, word(page, offset) & value) }
        });
    }

    /// Erases a page: all bits become 1.
    pub fn erase(page: usize) {
        while_silent(|| {
            for offset in (0..PAGE).step_by(4) {
                // A power cut may leave a page half erased.
                if offset == PAGE / 2 {
                    operate();
                }
                // SAFETY: as in `word`.
                unsafe { write_volatile(address(page, offset) as *mut u32, u32::MAX) }
            }
        });
    }

    /// Lets the power fail before the operation of this number from now on, 1 for the next.
    pub fn cut_power_after(operations: u32) {
        OPERATIONS.store(0, Ordering::Relaxed);
        CUT_AFTER.store(operations, Ordering::Relaxed);
    }

    /// The number of operations since the start or since [`cut_power_after`].
    #[must_use]
    pub fn operations() -> u32 {
        OPERATIONS.load(Ordering::Relaxed)
    }

    /// The number of operations since the start that came while an answer waited for its time or was being sent: those of a
    /// microcontroller would stop its processor meanwhile.
    #[must_use]
    pub fn disturbing() -> u32 {
        DISTURBING.load(Ordering::Relaxed)
    }

    /// Whether the alarm runs, or the interrupt of the transmitter is on.
    fn is_answering() -> bool {
        read(ALARM) & 1 != 0 || read(BUS + CONTROL) & 0b100 != 0
    }

    /// Whether the power has failed at an operation; the question clears the mark.
    #[must_use]
    pub fn power_has_failed() -> bool {
        // SAFETY: a word behind the pages, in the same RAM.
        unsafe {
            let has_failed = read_volatile(MARK as *const u32) == FAILED;
            write_volatile(MARK as *mut u32, 0);
            has_failed
        }
    }

    fn operate() {
        let count = OPERATIONS.load(Ordering::Relaxed).wrapping_add(1);
        OPERATIONS.store(count, Ordering::Relaxed);
        if is_answering() {
            DISTURBING.store(disturbing().wrapping_add(1), Ordering::Relaxed);
        }
        if count == CUT_AFTER.load(Ordering::Relaxed) {
            // SAFETY: as in `power_has_failed`.
            unsafe { write_volatile(MARK as *mut u32, FAILED) };
            restart();
        }
    }
}

/// The vector table: exceptions, interrupts 0 to 9.
#[used]
#[unsafe(link_section = ".vectors")]
static VECTORS: [Vector; EXCEPTIONS + 10] =
    vectors(&[(RECEIVED_INTERRUPT, on_received), (SENT_INTERRUPT, on_sent), (ALARM_INTERRUPT, on_alarm)]);
