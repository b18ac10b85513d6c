//! RP2040 at 96 MHz, from a crystal of 12 MHz: Raspberry Pi Pico. **Not yet on hardware.**
//!
//! | Pin | Use |
//! |---|---|
//! | GP0, GP1 | transmitter and receiver of UART0 |
//! | GP2 | direction of the transceiver, high while the gauge sends |
//! | GP8 ... GP15 | address switch, closed to ground for 1 |
//! | GP25, GP3 | lights: data exchange, fault |
//! | GP26 | analogue input |
//!
//! Registers and their bits are those of the RP2040 datasheet. 96 MHz is 16 times 6 Mbit/s, and every slower rate has a divisor.

use crate::cortex::{
    EXCEPTIONS, Vector, handlers, modify, read, register, start_interrupts, start_systick, systick, vectors, write,
};
use crate::outgoing::OUTGOING;
use crate::{Handlers, Light, LineError};
use core::sync::atomic::{AtomicU32, Ordering};

/// The name of the board.
pub const NAME: &str = "RP2040";

/// The ticks of the timer in a second: the clock of the processor.
pub const TICKS_PER_SECOND: u32 = 96_000_000;

/// The port measures the idle time of PROFIBUS itself.
pub const IDLE_US: u64 = 0;

/// An answer is never sent after max T_SDR.
pub const TOLERANCE_US: u64 = 0;

/// The lowest bit rate of the serial port, and the highest.
pub const RATES: (u32, u32) = (9_600, 6_000_000);

const TICKS_PER_US: u32 = TICKS_PER_SECOND / 1_000_000;

const CLOCKS: usize = 0x4000_8000;
const RESETS: usize = 0x4000_C000;
const POWER_ON: usize = 0x4001_0000;
const PINS: usize = 0x4001_4000;
const PADS: usize = 0x4001_C000;
const CRYSTAL: usize = 0x4002_4000;
const PLL: usize = 0x4002_8000;
const UART: usize = 0x4003_4000;
const CONVERTER: usize = 0x4004_C000;
const TIMER: usize = 0x4005_4000;
const WATCHDOG: usize = 0x4005_8000;
const SIO: usize = 0xD000_0000;

/// Interrupts that the program causes. At these offsets of every register a write sets or clears its bits at once, so that no interrupt
/// comes between a read and a write.
const TIMER_FORCE: usize = TIMER + 0x3C;
const SET: usize = 0x2000;
const CLEAR: usize = 0x3000;

const UART_INTERRUPT: usize = 20;
/// The answer begins.
const ALARM_INTERRUPT: usize = 0;
/// The last octet has left.
const END_INTERRUPT: usize = 1;
/// Ends a wait every 10 ms: SysTick, which counts cycles, wraps after 175 ms only.
const TICK_INTERRUPT: usize = 2;
const TICKS_PER_WAIT: u32 = TICKS_PER_SECOND / 100;

const UART_CONTROL: usize = UART + 0x30;
const UART_FLAGS: usize = UART + 0x18;
const UART_MASK: usize = UART + 0x38;
const ON_RECEIVED: u32 = 1 << 4;
const ON_EMPTY: u32 = 1 << 5;
const BUSY: u32 = 1 << 3;

const RECEIVER: u32 = 1;
const DIRECTION: u32 = 2;
const SWITCHES: u32 = 8;
const BUS_LIGHT: u32 = 25;
const FAULT_LIGHT: u32 = 3;
const ANALOG: u32 = 26;

/// The watchdog restarts after two seconds; it counts twice for each tick of 1 us.
const WATCHDOG_LOAD: u32 = 4_000_000;

/// The ticks of a character at the present rate.
static CHARACTER: AtomicU32 = AtomicU32::new(0);

/// 96 MHz: 12 MHz x 96 / 6 / 2. The timer and the watchdog count microseconds of the crystal.
fn start_clock() {
    // 1 to 15 MHz; about 1 ms until it is stable.
    write(CRYSTAL + 0xC, 47);
    write(CRYSTAL, 0xAA0 | 0xFAB << 12);
    while read(CRYSTAL + 0x4) & 1 << 31 == 0 {}
    // The reference is the crystal, the system the reference.
    write(CLOCKS + 0x30, 2);
    while read(CLOCKS + 0x38) & 1 << 2 == 0 {}
    modify(CLOCKS + 0x3C, 1, 0);
    while read(CLOCKS + 0x44) & 1 == 0 {}
    release(1 << 12);
    write(PLL, 1);
    write(PLL + 0x8, 96);
    // PLL and oscillator on, then the dividers.
    modify(PLL + 0x4, 1 | 1 << 5, 0);
    while read(PLL) & 1 << 31 == 0 {}
    write(PLL + 0xC, 6 << 16 | 2 << 12);
    modify(PLL + 0x4, 1 << 3, 0);
    write(CLOCKS + 0x3C, 0);
    write(CLOCKS + 0x3C, 1);
    while read(CLOCKS + 0x44) & 1 << 1 == 0 {}
    // The peripherals have the clock of the system.
    write(CLOCKS + 0x48, 1 << 11);
    write(WATCHDOG + 0x2C, 12 | 1 << 9);
}

/// Takes peripherals out of reset.
fn release(peripherals: u32) {
    modify(RESETS, peripherals, 0);
    while read(RESETS + 0x8) & peripherals != peripherals {}
}

fn function(pin: u32, function: u32) {
    write(PINS + 4 + 8 * pin as usize, function);
}

/// A pull-up instead of the pull-down of a reset.
fn pull_up(pin: u32) {
    modify(PADS + 4 + 4 * pin as usize, 1 << 2, 1 << 3);
}

/// Starts clock, timer and pins. The first call of a program.
pub fn start_timer() {
    start_clock();
    // IO, pads, timer, UART0.
    release(1 << 5 | 1 << 8 | 1 << 21 | 1 << 22);
    for pin in [0, 1] {
        function(pin, 2);
    }
    for pin in [DIRECTION, FAULT_LIGHT, BUS_LIGHT] {
        write(SIO + 0x18, 1 << pin);
        write(SIO + 0x24, 1 << pin);
        function(pin, 5);
    }
    // The transceiver lets the receiver's pin float while the gauge sends.
    pull_up(RECEIVER);
    for pin in SWITCHES..SWITCHES + 8 {
        pull_up(pin);
        function(pin, 5);
    }
    start_systick(1 << 24);
}

/// Starts serial port, watchdog and interrupts.
pub fn start(handlers: &'static Handlers) {
    register(handlers);
    // Enabled, transmitter, receiver; no FIFO, so an interrupt for each character.
    write(UART_CONTROL, 1 | 1 << 8 | 1 << 9);
    write(UART_MASK, ON_RECEIVED);
    write(TIMER + 0x38, 0b111);
    start_interrupts(&[UART_INTERRUPT, ALARM_INTERRUPT, END_INTERRUPT, TICK_INTERRUPT]);
    set_timer(TICK_INTERRUPT, TICKS_PER_WAIT);
    // All but the oscillators restart.
    write(POWER_ON + 0x8, 0x1_FFFC);
    write(WATCHDOG + 0x4, WATCHDOG_LOAD);
    modify(WATCHDOG, 0, 1 << 30);
}

/// Sets the bit rate. Returns whether the port has it.
pub fn set_rate(bits_per_second: u32) -> bool {
    if !(RATES.0..=RATES.1).contains(&bits_per_second) {
        return false;
    }
    // A port that is on does not take another divisor; it ends the character of before first.
    let control = read(UART_CONTROL);
    write(UART_CONTROL, 0);
    let start = ticks();
    while ticks().wrapping_sub(start) < CHARACTER.load(Ordering::Relaxed) {}
    // In 64ths of 16 bits.
    let divisor = (TICKS_PER_SECOND * 4 + bits_per_second / 2) / bits_per_second;
    write(UART + 0x24, divisor / 64);
    write(UART + 0x28, divisor % 64);
    // Eight bits, even parity. Written last: it takes the divisor over.
    write(UART + 0x2C, 0b11 << 5 | 1 << 2 | 1 << 1);
    write(UART_CONTROL, control);
    CHARACTER.store(11 * (TICKS_PER_SECOND / bits_per_second + 1), Ordering::Relaxed);
    true
}

/// The time; wraps.
///
/// The timer counts microseconds, SysTick cycles with 24 bits, both from one crystal. The difference of their low 24 bits changes
/// little, so its sign is known, and their sum has the width of the timer and the steps of SysTick.
#[inline]
#[must_use]
pub fn ticks() -> u32 {
    let coarse = read(TIMER + 0x28).wrapping_mul(TICKS_PER_US);
    let fine = 0_u32.wrapping_sub(systick());
    let difference = (fine.wrapping_sub(coarse) << 8) as i32 >> 8;
    coarse.wrapping_add(difference as u32)
}

fn set_timer(alarm: usize, after: u32) {
    let after_us = after / TICKS_PER_US + 1;
    let at = read(TIMER + 0x28).wrapping_add(after_us);
    write(TIMER + 0x10 + 4 * alarm, at);
    // The timer compares for equality: a time that has passed would come in an hour.
    if read(TIMER + 0x28).wrapping_sub(at) < u32::MAX / 2 && read(TIMER + 0x20) & 1 << alarm != 0 {
        write(TIMER_FORCE + SET, 1 << alarm);
    }
}

fn acknowledge(alarm: usize) {
    write(TIMER_FORCE + CLEAR, 1 << alarm);
    write(TIMER + 0x20, 1 << alarm);
    write(TIMER + 0x34, 1 << alarm);
}

/// Calls [`Handlers::alarm`] after this number of ticks, at least one. Replaces the alarm before.
pub fn set_alarm(after: u32) {
    set_timer(ALARM_INTERRUPT, after);
}

/// Begins to send what was prepared, once.
pub fn send() {
    if OUTGOING.begin() {
        write(SIO + 0x14, 1 << DIRECTION);
        write(UART_MASK, ON_RECEIVED | ON_EMPTY);
        send_next();
    }
}

/// Drops what waits to be sent, and the alarm.
pub fn withdraw() {
    acknowledge(ALARM_INTERRUPT);
    OUTGOING.withdraw();
}

/// The interrupt comes when the register for the next octet is empty, which is before the last octet has left.
fn send_next() {
    match OUTGOING.take() {
        Some(octet) => write(UART, u32::from(octet)),
        None => {
            write(UART_MASK, ON_RECEIVED);
            set_timer(END_INTERRUPT, CHARACTER.load(Ordering::Relaxed));
        }
    }
}

extern "C" fn on_uart() {
    let pending = read(UART + 0x40);
    write(UART + 0x44, pending);
    if pending & ON_RECEIVED != 0 {
        let data = read(UART);
        if let Some(handlers) = handlers() {
            // Stop bit, parity, break, overrun.
            (handlers.character)(if data & 0xF00 == 0 { Ok(data as u8) } else { Err(LineError) });
        }
    }
    if pending & ON_EMPTY != 0 {
        send_next();
    }
}

extern "C" fn on_alarm() {
    acknowledge(ALARM_INTERRUPT);
    if let Some(handlers) = handlers() {
        (handlers.alarm)();
    }
}

extern "C" fn on_end() {
    acknowledge(END_INTERRUPT);
    while read(UART_FLAGS) & BUSY != 0 {}
    write(SIO + 0x18, 1 << DIRECTION);
    OUTGOING.ended();
    if let Some(handlers) = handlers() {
        (handlers.sent)();
    }
}

extern "C" fn on_tick() {
    acknowledge(TICK_INTERRUPT);
    set_timer(TICK_INTERRUPT, TICKS_PER_WAIT);
}

/// Tells the watchdog that the program runs.
pub fn feed_watchdog() {
    write(WATCHDOG + 0x4, WATCHDOG_LOAD);
}

/// The address switch; above 125 the stored address holds.
#[must_use]
pub fn address_switch() -> u8 {
    !(read(SIO + 0x4) >> SWITCHES) as u8
}

/// The next conversion of the analogue input, in steps of 12 bits.
#[must_use]
pub fn analog_input() -> u16 {
    // The clock of the converter: half of 96 MHz.
    write(CLOCKS + 0x64, 2 << 8);
    write(CLOCKS + 0x60, 1 << 11 | 1 << 5);
    release(1);
    // The pin with neither output, input, nor resistors.
    write(PADS + 4 + 4 * ANALOG as usize, 1 << 7);
    // On, and one conversion of the first channel.
    write(CONVERTER, 1);
    while read(CONVERTER) & 1 << 8 == 0 {}
    write(CONVERTER, 1 | 1 << 2);
    while read(CONVERTER) & 1 << 8 == 0 {}
    read(CONVERTER + 0x4) as u16
}

/// Switches a light on or off.
pub fn set_light(light: Light, on: bool) {
    let pin = match light {
        Light::Bus => BUS_LIGHT,
        Light::Fault => FAULT_LIGHT,
    };
    write(SIO + if on { 0x14 } else { 0x18 }, 1 << pin);
}

/// The two pages for nonvolatile values: the last two sectors of 2 MiB.
///
/// While a sector is erased or written the processor cannot read its program: the gauge answers nothing for up to 0.4 s. The functions
/// of the ROM do both, when no answer is being sent or waits.
pub mod flash {
    use crate::outgoing::while_silent;
    use core::ptr::{null, read_volatile};

    /// The octets of a page.
    pub const PAGE: usize = 4096;

    const START: usize = 0x1000_0000;
    const FIRST: usize = 0x1F_E000;
    /// The octets that the flash writes at a time.
    const WRITTEN: usize = 256;
    const ERASE_SECTOR: u8 = 0x20;

    /// The offset in the flash.
    fn offset_of(page: usize, offset: usize) -> usize {
        FIRST + page % 2 * PAGE + (offset & (PAGE - 4))
    }

    /// The word at `offset` of a page, 0 or 1.
    #[must_use]
    pub fn word(page: usize, offset: usize) -> u32 {
        // SAFETY: the address is inside the last two sectors of the flash, in which there is no program.
        unsafe { read_volatile((START + offset_of(page, offset)) as *const u32) }
    }

    /// The functions of the ROM, by the two letters of their codes.
    struct Rom {
        connect: unsafe extern "C" fn(),
        exit: unsafe extern "C" fn(),
        erase: unsafe extern "C" fn(u32, usize, u32, u8),
        program: unsafe extern "C" fn(u32, *const u8, usize),
        flush: unsafe extern "C" fn(),
        enter: unsafe extern "C" fn(),
    }

    impl Rom {
        fn new() -> Self {
            // SAFETY: the words at 14h and 18h of the ROM are the addresses of a table and of the function that searches it, and the
            // functions of these codes have these types.
            unsafe {
                let table = usize::from(read_volatile(0x14 as *const u16)) as *const u16;
                let search = usize::from(read_volatile(0x18 as *const u16));
                let search: unsafe extern "C" fn(*const u16, u32) -> usize = core::mem::transmute(search);
                let find = |code: &[u8; 2]| search(table, u32::from(u16::from_le_bytes(*code)));
                Self {
                    connect: core::mem::transmute::<usize, unsafe extern "C" fn()>(find(b"IF")),
                    exit: core::mem::transmute::<usize, unsafe extern "C" fn()>(find(b"EX")),
                    erase: core::mem::transmute::<usize, unsafe extern "C" fn(u32, usize, u32, u8)>(find(b"RE")),
                    program: core::mem::transmute::<usize, unsafe extern "C" fn(u32, *const u8, usize)>(find(b"RP")),
                    flush: core::mem::transmute::<usize, unsafe extern "C" fn()>(find(b"FC")),
                    enter: core::mem::transmute::<usize, unsafe extern "C" fn()>(find(b"CX")),
                }
            }
        }
    }

    /// Erases the sector at `at`, or writes the octets at `data` if it is not null. Runs in RAM, and calls the ROM only.
    ///
    /// # Safety
    /// Nothing else reads the flash meanwhile; `at` is in the last two sectors, and `data` is null or has [`WRITTEN`] octets of RAM.
    #[inline(never)]
    #[unsafe(link_section = ".data.flash")]
    unsafe extern "C" fn operate(rom: &Rom, at: u32, data: *const u8) {
        // SAFETY: the order of the datasheet, 2.8.3.1.3; the rest is up to the caller.
        unsafe {
            (rom.connect)();
            (rom.exit)();
            if data.is_null() {
                (rom.erase)(at, PAGE, PAGE as u32, ERASE_SECTOR);
            } else {
                (rom.program)(at, data, WRITTEN);
            }
            (rom.flush)();
            (rom.enter)();
        }
    }

    fn run(at: usize, data: *const u8) {
        let rom = Rom::new();
        // By its address, because RAM is too far from flash for a branch.
        let operate = core::hint::black_box(operate as unsafe extern "C" fn(&Rom, u32, *const u8));
        // SAFETY: no interrupt runs, and the other core has not been started. `at` is in the last two sectors.
        while_silent(|| unsafe { operate(&rom, at as u32, data) });
    }

    /// Programs a word that is erased: the other octets of the write are ones, which change nothing.
    pub fn program(page: usize, offset: usize, value: u32) {
        let at = offset_of(page, offset);
        let mut octets = [0xFF_u8; WRITTEN];
        if let Some(target) = octets.get_mut(at % WRITTEN..).and_then(|rest| rest.first_chunk_mut()) {
            *target = value.to_le_bytes();
        }
        run(at & !(WRITTEN - 1), octets.as_ptr());
    }

    /// Erases a page.
    pub fn erase(page: usize) {
        run(offset_of(page, 0), null());
    }
}

/// The second stage of the start, which the ROM copies to RAM and runs: it lets the flash be read as memory, with the command 03h of
/// every flash (clock / 4, eight bits of command, 24 of address, 32 of data), and starts the program at 1000_0100h.
#[rustfmt::skip]
const BOOT_CODE: [u16; 34] = [
    0x4B0A, 0x2100, 0x6099,         // ldr r3, =XIP_SSI; SSIENR = 0
    0x2104, 0x6159,                 // BAUDR = 4
    0x4909, 0x6019,                 // CTRLR0
    0x2100, 0x6059,                 // CTRLR1 = 0
    0x4908, 0x4808, 0x6001,         // SPI_CTRLR0
    0x2101, 0x6099,                 // SSIENR = 1
    0x4807, 0x4908, 0x6008,         // VTOR
    0xC803, 0xF380, 0x8808, 0x4708, // ldm r0, {r0, r1}; msr msp, r0; bx r1
    0x46C0,
    0x0000, 0x1800, 0x0300, 0x001F, 0x0218, 0x0300, 0x00F4, 0x1800, 0x0100, 0x1000, 0xED08, 0xE000,
];

/// The second stage with its checksum, without which the ROM does not run it: CRC-32 with the polynomial 04C1_1DB7h, high bit first.
#[used]
#[unsafe(no_mangle)]
#[unsafe(link_section = ".boot")]
static BOOT: [u8; 256] = {
    let mut octets = [0; 256];
    let mut at = 0;
    while at < BOOT_CODE.len() {
        let [low, high] = BOOT_CODE[at].to_le_bytes();
        octets[2 * at] = low;
        octets[2 * at + 1] = high;
        at += 1;
    }
    let mut checksum = u32::MAX;
    let mut at = 0;
    while at < 252 {
        checksum ^= (octets[at] as u32) << 24;
        let mut bit = 0;
        while bit < 8 {
            checksum = checksum << 1 ^ if checksum & 1 << 31 == 0 { 0 } else { 0x04C1_1DB7 };
            bit += 1;
        }
        at += 1;
    }
    let checksum = checksum.to_le_bytes();
    let mut at = 0;
    while at < 4 {
        octets[252 + at] = checksum[at];
        at += 1;
    }
    octets
};

/// The vector table: exceptions, interrupts 0 to 25.
#[used]
#[unsafe(link_section = ".vectors")]
static VECTORS: [Vector; EXCEPTIONS + 26] = vectors(&[
    (ALARM_INTERRUPT, on_alarm),
    (END_INTERRUPT, on_end),
    (TICK_INTERRUPT, on_tick),
    (UART_INTERRUPT, on_uart),
]);
