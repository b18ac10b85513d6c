//! The three contexts of a gauge.

use profivac_board::{self as board, Exclusive, Handlers, LineError};
use profivac_devices::SimulatedDevice;
use profivac_devices::profile::beside::{Application, BusSide};
use profivac_devices::profile::{Behaviour, BlockDevice};
use profivac_devices::store::Store;
use profivac_dp::link::{Baud, BitTime};
use profivac_runtime::bus::{BusStation, Line, Next, Timing};
use profivac_wire::{MAX_TELEGRAM, Telegram};

const TIMING: Timing =
    Timing { ticks_per_second: board::TICKS_PER_SECOND, idle_us: board::IDLE_US, tolerance_us: board::TOLERANCE_US };

/// How often the application runs, at most, in microseconds.
const PERIOD_US: u32 = 10_000;

const SECONDS_PER_TICK: f64 = 1.0 / board::TICKS_PER_SECOND as f64;

const TICKS_PER_US: u32 = board::TICKS_PER_SECOND / 1_000_000;

/// A light that flashes is on for these ticks and off for as many: the power of two in half a second. chosen
const FLASH_TICKS: u32 = 1 << (board::TICKS_PER_SECOND / 2).ilog2();

/// What the character context owns.
static LINE: Exclusive<Line> = Exclusive::new();

/// The telegram that the work context serves.
static TELEGRAM: Exclusive<[u8; MAX_TELEGRAM]> = Exclusive::new();

/// What the work context owns.
static BUS: Exclusive<BusStation<BusSide>> = Exclusive::new();

static HANDLERS: Handlers = Handlers { character, alarm, sent, work };

pub(crate) fn character(octet: Result<u8, LineError>) {
    let ticks = board::ticks();
    let is_complete = LINE.with(|line| line.character(ticks, octet.ok()));
    if is_complete == Some(true) {
        board::request_work();
    }
}

/// The first bit may leave.
fn alarm() {
    board::send();
}

/// The answer has left: the slave prepares the next one in the work context.
fn sent() {
    board::request_work();
}

/// A telegram is complete, or time has passed.
pub(crate) fn work() {
    TELEGRAM.with(|buffer| {
        let taken = board::masked(|| LINE.with(|line| line.take(buffer)));
        match taken.flatten() {
            Some((end, octets)) => {
                // The master of an answer that still waits has gone on.
                board::withdraw();
                serve(end, octets);
            }
            None => poll(),
        }
    });
}

fn poll() {
    let ticks = board::ticks();
    let next = BUS.with(|bus| bus.poll(ticks));
    if let Some(Next::SetRate(baud)) = next {
        set_rate(baud, ticks);
    }
    board::masked(|| LINE.with(|line| line.follow(board::ticks())));
}

fn serve(end: BitTime, octets: &[u8]) {
    let Ok(telegram) = Telegram::parse(octets) else {
        board::masked(|| LINE.with(Line::reject));
        return;
    };
    BUS.with(|bus| match bus.telegram(end, &telegram, board::ticks) {
        Next::Wait => {}
        Next::Send { after, octets } => send(after, octets),
        // Only the time changes the rate.
        Next::SetRate(_) => {}
    });
}

fn send(after: u32, octets: &[u8]) {
    if !board::prepare(octets) {
        return;
    }
    match after {
        0 => board::send(),
        _ => board::set_alarm(after),
    }
}

/// Begins to listen at a rate. The clock of the line begins at the same ticks as that of the slave.
///
/// A port that does not have the rate hears nothing: at the rate before, it would hear telegrams that the slave takes for those of the
/// rate that it searches.
#[inline(never)]
pub(crate) fn set_rate(baud: Baud, ticks: u32) {
    board::masked(|| {
        if board::set_rate(baud.bits_per_second()) {
            LINE.set(|| Line::new(&TIMING, baud, ticks));
        } else {
            #[cfg(feature = "defmt")]
            defmt::warn!("the port does not have {=u32} bit/s: it hears nothing", baud.bits_per_second());
            LINE.clear();
        }
    });
}

/// Whether the port does not have the rate of the bus. While the rate is searched, it is silent at rates that it does not have.
fn is_deaf() -> bool {
    !LINE.is_set() && with_bus(|bus| bus.is_searching()) == Some(false)
}

/// What a program adds to a device: its sensors.
pub trait Gauge<B, S> {
    /// Measures, and gives the device what was measured. `seconds` have passed since the last call.
    fn measure(&mut self, device: &mut BlockDevice<B, S>, seconds: f64);
}

/// Sensors that stay in air.
#[derive(Clone, Copy, Debug)]
pub struct NoSensors;

impl<B: Behaviour, S: Store> Gauge<B, S> for NoSensors {
    fn measure(&mut self, _device: &mut BlockDevice<B, S>, _seconds: f64) {}
}

/// The rate of the bus for [`run`]: the port of the emulator has no rate, so there the gauge does not search one unless the feature
/// `baud-search` is on.
pub const BUS_RATE: Option<Baud> =
    if cfg!(all(feature = "qemu", not(feature = "baud-search"))) { Some(Baud::B19200) } else { None };

/// Runs a gauge. `baud` is the rate of the bus; `None` searches it.
pub fn run<B: Behaviour, S: Store>(
    device: &mut BlockDevice<B, S>,
    gauge: &mut impl Gauge<B, S>,
    baud: Option<Baud>,
) -> ! {
    #[cfg(feature = "diagnostics")]
    crate::diagnostics::wait_after_power_cut();
    start_bus(device, baud);
    let mut application = Application::new(device);
    board::start(&HANDLERS);
    let mut last = board::ticks();
    loop {
        let passed = board::ticks().wrapping_sub(last);
        last = last.wrapping_add(passed);
        let seconds = f64::from(passed) * SECONDS_PER_TICK;
        adopt(&mut application);
        application.device_mut().advance(seconds);
        gauge.measure(application.device_mut(), seconds);
        publish(&mut application);
        board::request_work();
        board::feed_watchdog();
        // The time of the log follows the timer, also while nothing is logged.
        #[cfg(feature = "defmt")]
        board::time_us();
        #[cfg(feature = "diagnostics")]
        crate::diagnostics::serve();
        while board::ticks().wrapping_sub(last) < PERIOD_US.wrapping_mul(TICKS_PER_US) && !has_tasks() {
            board::wait();
        }
    }
}

/// A function of its own, so that the slave is on the stack only while it is made.
#[inline(never)]
pub(crate) fn start_bus<B: Behaviour, S: Store>(device: &BlockDevice<B, S>, baud: Option<Baud>) {
    let ticks = board::ticks();
    let side = BusSide::new(device);
    let address = side.address();
    #[cfg(feature = "defmt")]
    {
        use profivac_dp::slave::Device;
        defmt::info!("{=str}: address {=u8}, ident {=u16:04x}", board::NAME, address, side.ident_number());
    }
    TELEGRAM.set(|| [0; MAX_TELEGRAM]);
    BUS.set(|| BusStation::new(side, address, &TIMING, baud, ticks));
    set_rate(baud.unwrap_or(Baud::B12000000), ticks);
}

fn with_bus<R>(action: impl FnOnce(&mut BusStation<BusSide>) -> R) -> Option<R> {
    #[cfg(feature = "diagnostics")]
    let start = board::ticks();
    let result = board::hold_work(|| BUS.with(action));
    #[cfg(feature = "diagnostics")]
    crate::measure::work_was_held(board::ticks().wrapping_sub(start));
    result
}

/// Whether a master wants something.
fn has_tasks() -> bool {
    with_bus(|bus| bus.slave().device().has_tasks()).unwrap_or(false)
}

/// Does what the bus wants. Tasks and snapshot are in functions of their own, so that they are not on the stack together.
#[inline(never)]
pub(crate) fn adopt<B: Behaviour, S: Store>(application: &mut Application<'_, B, S>) {
    if let Some(tasks) = with_bus(|bus| bus.device_mut().take_tasks()) {
        application.adopt(&tasks);
    }
}

#[inline(never)]
pub(crate) fn publish<B: Behaviour, S: Store>(application: &mut Application<'_, B, S>) {
    let snapshot = application.snapshot();
    let is_exchanging = with_bus(|bus| {
        bus.device_mut().publish(&snapshot);
        bus.slave().device().is_exchanging()
    });
    // As the NET light of a PCG550 (3.4): red at an alarm; else green in data exchange, and flashing green without it.
    let is_red = is_deaf() || application.device().has_alarm();
    let is_green = is_exchanging == Some(true) || board::ticks() & FLASH_TICKS != 0;
    board::set_light(board::Light::Bus, is_green && !is_red);
    board::set_light(board::Light::Fault, is_red);
}

/// Numbers for a diagnosis of the bus.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counters {
    /// Damaged telegrams, character errors and long gaps.
    pub damaged: u32,
    /// Telegrams that the work context did not take in time.
    pub lost: u32,
    /// Answers that were too late and not sent.
    pub late: u32,
}

/// The counters since the start.
#[must_use]
pub fn counters() -> Counters {
    let errors = board::masked(|| LINE.with(|line| line.errors()));
    let (damaged, lost) = errors.unwrap_or_default();
    Counters { damaged, lost, late: with_bus(|bus| bus.late()).unwrap_or_default() }
}
