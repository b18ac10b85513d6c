//! The three contexts of a gauge.

use profivac_board::{self as board, Exclusive, Handlers, LineError};
use profivac_devices::SimulatedDevice;
use profivac_devices::profile::beside::{Application, BusSide};
use profivac_devices::profile::{Behaviour, BlockDevice};
use profivac_devices::store::Store;
use profivac_dp::link::{Baud, BitTime};
use profivac_runtime::bus::{BusStation, Line, Next, Timing};
use profivac_wire::{MAX_TELEGRAM, Telegram};

const TIMING: Timing = Timing { ticks_per_second: board::TICKS_PER_SECOND, idle_us: board::IDLE_US };

/// How often the application runs, at most, in microseconds.
const PERIOD_US: u32 = 10_000;

const SECONDS_PER_TICK: f64 = 1.0 / board::TICKS_PER_SECOND as f64;

const TICKS_PER_US: u32 = board::TICKS_PER_SECOND / 1_000_000;

/// What the character context owns.
static LINE: Exclusive<Line> = Exclusive::new();

/// What the work context owns.
static BUS: Exclusive<BusStation<BusSide>> = Exclusive::new();

/// The answer that waits for its time. The work context writes it, the character context sends it.
static ANSWER: Exclusive<Answer> = Exclusive::new();

struct Answer {
    length: usize,
    octets: [u8; MAX_TELEGRAM],
}

static HANDLERS: Handlers = Handlers { character, alarm, sent, work };

fn character(octet: Result<u8, LineError>) {
    let ticks = board::ticks();
    let is_complete = LINE.with(|line| line.character(ticks, octet.ok()));
    if is_complete == Some(true) {
        board::request_work();
    }
}

/// The first bit may leave.
fn alarm() {
    ANSWER.with(|answer| {
        board::send(answer.octets.get(..answer.length).unwrap_or_default());
        answer.length = 0;
    });
}

const fn sent() {}

/// A telegram is complete, or time has passed.
fn work() {
    let mut place = [0; MAX_TELEGRAM];
    let taken = board::masked(|| LINE.with(|line| line.take(&mut place)));
    match taken.flatten() {
        Some((end, octets)) => serve(end, octets),
        None => poll(),
    }
}

fn poll() {
    let next = BUS.with(|bus| bus.poll(board::ticks()));
    if let Some(Next::SetRate(baud)) = next {
        set_rate(baud);
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
        Next::Send { after: 0, octets } => {
            board::send(octets);
        }
        Next::Send { after, octets } => send_later(after, octets),
        Next::SetRate(baud) => set_rate(baud),
    });
}

fn send_later(after: u32, octets: &[u8]) {
    board::masked(|| {
        ANSWER.with(|answer| {
            if let Some(place) = answer.octets.get_mut(..octets.len()) {
                place.copy_from_slice(octets);
                answer.length = octets.len();
                board::set_alarm(after);
            }
        });
    });
}

fn set_rate(baud: Baud) {
    board::set_rate(baud.bits_per_second());
    board::masked(|| LINE.set(Line::new(&TIMING, baud, board::ticks())));
}

/// What a program adds to a device: its sensors.
pub trait Gauge<B, S> {
    /// Measures, and gives the device what was measured. `seconds` have passed since the last call.
    fn measure(&mut self, device: &mut BlockDevice<B, S>, seconds: f64);
}

/// Runs a gauge. `baud` is the rate of the bus; `None` searches it.
pub fn run<B: Behaviour, S: Store>(device: BlockDevice<B, S>, gauge: &mut impl Gauge<B, S>, baud: Option<Baud>) -> ! {
    let mut application = Application::new(device);
    let ticks = board::ticks();
    let side = BusSide::new(application.device());
    let address = side.address();
    BUS.set(match baud {
        Some(baud) => BusStation::fixed(side, address, &TIMING, baud, ticks),
        None => BusStation::searching(side, address, &TIMING, ticks),
    });
    ANSWER.set(Answer { length: 0, octets: [0; MAX_TELEGRAM] });
    set_rate(baud.unwrap_or(Baud::B12000000));
    board::start(&HANDLERS);
    let mut last = board::ticks();
    loop {
        let passed = board::ticks().wrapping_sub(last);
        last = last.wrapping_add(passed);
        let seconds = f64::from(passed) * SECONDS_PER_TICK;
        round(&mut application, gauge, seconds);
        board::request_work();
        board::feed_watchdog();
        #[cfg(feature = "diagnostics")]
        crate::diagnostics::serve();
        while board::ticks().wrapping_sub(last) < PERIOD_US.wrapping_mul(TICKS_PER_US) && !has_tasks() {
            board::wait();
        }
    }
}

fn with_bus<R>(action: impl FnOnce(&mut BusStation<BusSide>) -> R) -> Option<R> {
    board::hold_work(|| BUS.with(action))
}

/// Whether a master wants something.
fn has_tasks() -> bool {
    with_bus(|bus| bus.device_mut().has_tasks()).unwrap_or(false)
}

/// What the main context does again and again.
fn round<B: Behaviour, S: Store>(application: &mut Application<B, S>, gauge: &mut impl Gauge<B, S>, seconds: f64) {
    if let Some(tasks) = with_bus(|bus| bus.device_mut().take_tasks()) {
        application.adopt(&tasks);
    }
    application.device_mut().advance(seconds);
    gauge.measure(application.device_mut(), seconds);
    let snapshot = application.snapshot();
    with_bus(|bus| bus.device_mut().publish(&snapshot));
    board::set_light(board::Light::Bus, with_bus(|bus| bus.device_mut().is_exchanging()) == Some(true));
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
