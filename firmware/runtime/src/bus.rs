//! The slave on a line: what the interrupts of a serial port and a timer call.
//!
//! | Context | Owns | Calls |
//! |---|---|---|
//! | character | [`Line`] | [`Line::character`] |
//! | work | [`BusStation`] | [`BusStation::telegram`], [`BusStation::poll`] |

use crate::clock::TickClock;
use profivac_dp::link::{Baud, BitTime, Rate, RateControl, Receiver, Station, T_SYN_TBIT, Transmit};
use profivac_dp::slave::{Device, Slave};
use profivac_wire::{MAX_TELEGRAM, Telegram};

/// The timer and the serial port of a board.
#[derive(Clone, Copy, Debug)]
pub struct Timing {
    /// The ticks of the timer in a second.
    pub ticks_per_second: u32,
    /// The idle time of the line that the port can measure, in microseconds; 0 for one that measures 33 bit times.
    pub idle_us: u64,
    /// How much later than max T_SDR an answer may still be sent, in microseconds: 0 but for an emulator, which other programs
    /// hold up.
    pub tolerance_us: u64,
}

impl Timing {
    fn clock(&self, baud: Baud, ticks: u32) -> TickClock {
        TickClock::new(self.ticks_per_second, baud, ticks)
    }

    /// The latest start of an answer, from the end of its request.
    fn latest_tbit(&self, baud: Baud) -> u64 {
        u64::from(baud.max_tsdr_tbit()).saturating_add(baud.tbit_of_us(self.tolerance_us))
    }

    fn idle_tbit(&self, baud: Baud) -> u64 {
        baud.tbit_of_us(self.idle_us).max(T_SYN_TBIT)
    }
}

/// The receiver of the character interrupt.
#[derive(Clone, Debug)]
pub struct Line {
    receiver: Receiver,
    clock: TickClock,
    /// The ticks of the last character.
    last: u32,
    /// A character within these ticks after the last one continues its telegram: a little less than the gap that the receiver allows, so
    /// that the receiver decides whether there was one; 0 while the timer may wrap.
    gap: u32,
    /// The last character was stored without its time, which the receiver does not know yet.
    is_ahead: bool,
    /// A little less than the longest gap, in ticks.
    longest_gap: u32,
    /// The end of the character that completed a telegram.
    end: BitTime,
    /// A telegram waits.
    is_complete: bool,
    /// Telegrams that were not taken before the next character.
    lost: u32,
}

impl Line {
    /// Begins to listen.
    #[must_use]
    pub fn new(timing: &Timing, baud: Baud, ticks: u32) -> Self {
        let clock = timing.clock(baud, ticks);
        Self {
            receiver: Receiver::with_idle(BitTime(0), timing.idle_tbit(baud)),
            last: ticks,
            gap: 0,
            is_ahead: false,
            longest_gap: clock.ticks_in(timing.idle_tbit(baud)),
            clock,
            end: BitTime(0),
            is_complete: false,
            lost: 0,
        }
    }

    /// A character ended; `None` for one with an error. Returns whether a telegram may be complete.
    ///
    /// Most characters of a telegram are only stored, with their time in ticks; bit times are computed where the receiver decides.
    #[inline]
    pub fn character(&mut self, ticks: u32, octet: Option<u8>) -> bool {
        if let Some(octet) = octet
            && ticks.wrapping_sub(self.last) < self.gap
            && self.receiver.collect_plain(octet)
        {
            (self.last, self.is_ahead) = (ticks, true);
            return false;
        }
        self.decide(ticks, octet)
    }

    /// A character after which the receiver decides, or one with an error.
    #[inline(never)]
    fn decide(&mut self, ticks: u32, octet: Option<u8>) -> bool {
        let has_no_gap = ticks.wrapping_sub(self.last) < self.gap;
        if !has_no_gap {
            self.catch_up();
        }
        let end = self.clock.at(ticks);
        if core::mem::take(&mut self.is_ahead) {
            // Without a gap, any time within it leads to the same decision.
            self.receiver.continue_at(end);
        }
        (self.last, self.gap) = (ticks, self.longest_gap);
        if self.is_complete {
            self.lose();
        }
        let Some(octet) = octet else {
            self.receiver.character_error(end);
            return false;
        };
        if self.receiver.collect(end, octet) {
            (self.end, self.is_complete) = (end, true);
        }
        self.is_complete
    }

    /// Tells the receiver the time of the last character.
    fn catch_up(&mut self) {
        if core::mem::take(&mut self.is_ahead) {
            let last = self.clock.at(self.last);
            self.receiver.continue_at(last);
        }
    }

    #[cold]
    fn lose(&mut self) {
        self.is_complete = false;
        self.lost = self.lost.saturating_add(1);
        self.receiver.reject();
    }

    /// The octets of the telegram and the time of its end, if one waits. The caller keeps the interrupt away meanwhile.
    pub fn take<'a>(&mut self, buffer: &'a mut [u8; MAX_TELEGRAM]) -> Option<(BitTime, &'a [u8])> {
        core::mem::take(&mut self.is_complete).then(|| (self.end, self.receiver.take(buffer)))
    }

    /// The octets taken last were no telegram.
    pub fn reject(&mut self) {
        self.receiver.reject();
    }

    /// Lets the clock follow a timer that wraps. The caller keeps the interrupt away meanwhile.
    pub fn follow(&mut self, ticks: u32) {
        self.catch_up();
        self.clock.at(ticks);
        if ticks.wrapping_sub(self.last) >= self.gap {
            self.gap = 0;
        }
    }

    /// The number of damaged telegrams, and of those that were not taken in time.
    #[must_use]
    pub const fn errors(&self) -> (u32, u32) {
        (self.receiver.damaged(), self.lost)
    }
}

/// What the program has to do after a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next<'a> {
    /// Nothing.
    Wait,
    /// Send these octets after this number of ticks.
    Send {
        /// From the ticks of the call; 0 for at once.
        after: u32,
        /// The telegram.
        octets: &'a [u8],
    },
    /// Set the port to this rate, and begin with a new [`Line`].
    SetRate(Baud),
}

/// The slave, its clock and its rate: what the work interrupt owns.
#[derive(Clone, Debug)]
pub struct BusStation<D> {
    slave: Slave<D>,
    rate: RateControl,
    clock: TickClock,
    timing: Timing,
    /// The latest start of an answer, from the end of its request.
    latest_tbit: u64,
    /// Answers that were not sent, because max T_SDR had passed.
    late: u32,
    #[cfg(feature = "defmt")]
    log: crate::log::BusLog,
}

impl<D: Device> BusStation<D> {
    /// A station at a fixed rate.
    pub fn fixed(device: D, address: u8, timing: &Timing, baud: Baud, ticks: u32) -> Self {
        Self::new(device, address, timing, Some(baud), ticks)
    }

    /// A station that searches the rate, from the highest down.
    pub fn searching(device: D, address: u8, timing: &Timing, ticks: u32) -> Self {
        Self::new(device, address, timing, None, ticks)
    }

    /// A station at this rate, or one that searches it. Inlined, so that the compiler makes it in its place: a station is large, and a
    /// copy would be on the stack.
    #[inline]
    pub fn new(device: D, address: u8, timing: &Timing, baud: Option<Baud>, ticks: u32) -> Self {
        let rate = baud.map_or_else(|| RateControl::automatic(BitTime(0)), RateControl::fixed);
        let baud = rate.rate().baud();
        // Before the first part of the station: behind a call the compiler would make the parts on the stack and copy them.
        let (clock, latest_tbit) = (timing.clock(baud, ticks), timing.latest_tbit(baud));
        Self {
            slave: Slave::new(device, address, baud),
            rate,
            clock,
            timing: *timing,
            latest_tbit,
            late: 0,
            #[cfg(feature = "defmt")]
            log: crate::log::BusLog::NEW,
        }
    }

    /// The rate of the port.
    #[must_use]
    pub const fn baud(&self) -> Baud {
        self.rate.rate().baud()
    }

    /// Whether the rate is not known yet.
    #[must_use]
    pub const fn is_searching(&self) -> bool {
        matches!(self.rate.rate(), Rate::Searching(_))
    }

    /// The slave.
    pub const fn slave(&self) -> &Slave<D> {
        &self.slave
    }

    /// The device, to copy tasks and snapshots.
    pub const fn device_mut(&mut self) -> &mut D {
        self.slave.device_mut()
    }

    /// The number of answers that were not sent, because max T_SDR had passed.
    #[must_use]
    pub const fn late(&self) -> u32 {
        self.late
    }

    /// A valid telegram ended at `end`. `ticks` is read when the answer is ready: an answer after max T_SDR is dropped, because
    /// the master has given up then and may be sending.
    pub fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>, ticks: impl FnOnce() -> u32) -> Next<'_> {
        #[cfg(feature = "defmt")]
        self.log_before(end, Some(telegram));
        let Self { slave, rate, clock, latest_tbit, late, .. } = self;
        if rate.telegram_received(end, telegram, slave.address()) {
            #[cfg(feature = "defmt")]
            defmt::info!("the bus has {=u32} bit/s", rate.rate().baud().bits_per_second());
            slave.rate_found(rate.rate().baud());
        }
        if let Rate::Searching(_) = rate.rate() {
            return Next::Wait;
        }
        let Some(Transmit { not_before, octets }) = slave.telegram(end, telegram) else { return Next::Wait };
        let now = clock.at(ticks());
        if now > end + *latest_tbit {
            *late = late.saturating_add(1);
            return Next::Wait;
        }
        let wait_tbit = not_before - now;
        Next::Send { after: if wait_tbit == 0 { 0 } else { clock.ticks_in(wait_tbit) }, octets }
    }

    /// Advances the time: watchdog, connections and the search of the rate. To be called at least every 10 ms.
    pub fn poll(&mut self, ticks: u32) -> Next<'static> {
        let now = self.clock.at(ticks);
        #[cfg(feature = "defmt")]
        self.log_before(now, None);
        self.slave.poll(now);
        if !self.rate.elapse(now, self.slave.watchdog_is_running()) {
            return Next::Wait;
        }
        let baud = self.baud();
        #[cfg(feature = "defmt")]
        defmt::info!("searches the bus at {=u32} bit/s", baud.bits_per_second());
        self.clock = self.clock.restarted(baud, ticks);
        self.latest_tbit = self.timing.latest_tbit(baud);
        Next::SetRate(baud)
    }

    /// Logs what has changed before this time. A telegram comes next, or the time passes.
    #[cfg(feature = "defmt")]
    fn log_before(&mut self, now: BitTime, telegram: Option<&Telegram<'_>>) {
        let Self { slave, log, late, .. } = self;
        log.observe(slave.state(), slave.device().ident_number(), *late);
        log.before(slave.state(), now);
        if let Some(telegram) = telegram {
            log.telegram(telegram, slave.address());
        }
    }
}

#[cfg(test)]
#[allow(clippy::arithmetic_side_effects, clippy::unwrap_used, clippy::panic, reason = "tests")]
mod tests {
    extern crate std;
    use super::*;
    use profivac_devices::bcg450::Bcg450;
    use profivac_devices::profile::Setup;
    use profivac_devices::profile::beside::BusSide;
    use profivac_devices::store::RamStore;
    use std::vec::Vec;

    /// Ten ticks in a bit at 1.5 Mbit/s.
    const TIMING: Timing = Timing { ticks_per_second: 15_000_000, idle_us: 0, tolerance_us: 0 };
    const FDL_STATUS: [u8; 6] = [0x10, 5, 2, 0x49, 0x50, 0x16];

    fn side() -> BusSide {
        let gauge: Bcg450<RamStore> = Bcg450::new(RamStore::default(), Setup::new(5));
        BusSide::new(&gauge)
    }

    /// The characters of a telegram, the first of which ends at `ticks`; the ticks of the last, and whether it completes a telegram.
    fn receive(line: &mut Line, mut ticks: u32, per_character: u32, octets: &[u8]) -> (u32, bool) {
        let mut is_complete = false;
        for (number, octet) in octets.iter().enumerate() {
            ticks += if number == 0 { 0 } else { per_character };
            is_complete = line.character(ticks, Some(*octet));
        }
        (ticks, is_complete)
    }

    /// The answer to a request: its delay in ticks, and its octets.
    fn answer(delay: u32) -> (Option<(u32, Vec<u8>)>, u32) {
        let mut line = Line::new(&TIMING, Baud::B1500000, 0);
        let mut bus = BusStation::fixed(side(), 5, &TIMING, Baud::B1500000, 0);
        let (ticks, is_complete) = receive(&mut line, 5000, 110, &FDL_STATUS);
        assert!(is_complete);
        let mut buffer = [0; MAX_TELEGRAM];
        let (end, octets) = line.take(&mut buffer).unwrap();
        let telegram = Telegram::parse(octets).unwrap();
        let sent = match bus.telegram(end, &telegram, || ticks + delay) {
            Next::Send { after, octets } => Some((after, octets.to_vec())),
            Next::Wait | Next::SetRate(_) => None,
        };
        (sent, bus.late())
    }

    #[test]
    fn an_answer_leaves_after_min_tsdr_and_never_after_max_tsdr() {
        let status = std::vec![0x10, 2, 5, 0, 7, 0x16];
        let (sent, late) = answer(20);
        let (after, octets) = sent.unwrap();
        assert!((90..=101).contains(&after) && octets == status && late == 0, "{after}");
        assert_eq!(answer(110), (Some((0, status.clone())), 0));
        assert_eq!(answer(1490), (Some((0, status)), 0));
        assert_eq!(answer(1520), (None, 1), "the master has given up");
    }

    #[test]
    fn a_telegram_that_is_not_taken_before_the_next_character_is_lost_and_the_one_after_it_is_received() {
        let mut line = Line::new(&TIMING, Baud::B1500000, 0);
        let (ticks, _) = receive(&mut line, 5000, 110, &FDL_STATUS);
        let (ticks, is_complete) = receive(&mut line, ticks + 110, 110, &FDL_STATUS);
        assert!(!is_complete && line.errors().1 == 1);
        let (_, is_complete) = receive(&mut line, ticks + 1000, 110, &FDL_STATUS);
        assert!(is_complete);
    }

    /// The same line with bit times at every character.
    fn asks_always(receiver: &mut Receiver, clock: &mut TickClock, ticks: u32, octet: Option<u8>) -> bool {
        let end = clock.at(ticks);
        match octet {
            Some(octet) => receiver.collect(end, octet),
            None => {
                receiver.character_error(end);
                false
            }
        }
    }

    /// Characters that follow each other at once, after gaps around the idle time, and after more than a wrap of the timer.
    #[test]
    fn a_line_that_stores_most_characters_without_their_time_receives_the_same_telegrams() {
        let mut random = 1_u32;
        let mut below = |end: u32| {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (random >> 8) % end
        };
        let telegram = [0x68, 5, 5, 0x68, 0x85, 0x82, 0x6D, 0x3C, 0x3E, 0xEE, 0x16];
        for baud in [Baud::B9600, Baud::B1500000, Baud::B12000000] {
            let timing = Timing { ticks_per_second: 84_000_000, ..TIMING };
            let mut line = Line::new(&timing, baud, 0);
            let mut receiver = Receiver::with_idle(BitTime(0), timing.idle_tbit(baud));
            let mut clock = timing.clock(baud, 0);
            let per_bit = 84_000_000 / baud.bits_per_second();
            let (mut ticks, mut complete) = (0_u32, 0);
            for _ in 0..20_000 {
                let octets: &[u8] = if below(4) == 0 { &FDL_STATUS } else { &telegram };
                for (number, octet) in octets.iter().enumerate() {
                    let bits = match below(60) {
                        _ if number == 0 => 60,
                        0 => 40 + below(8),
                        1 => below(100),
                        _ => 11,
                    };
                    ticks = ticks.wrapping_add(bits * per_bit + below(per_bit));
                    if below(100) == 0 {
                        // The main loop looks at the clock while the line is idle, for a whole turn of the timer or less.
                        let pause = if below(2) == 0 { 1 << 31 } else { below(1 << 31) };
                        for _ in 0..2 {
                            ticks = ticks.wrapping_add(pause);
                            line.follow(ticks);
                            clock.at(ticks);
                        }
                    }
                    let octet = Some(*octet).filter(|_| below(200) > 0);
                    let expected = asks_always(&mut receiver, &mut clock, ticks, octet);
                    assert_eq!(line.character(ticks, octet), expected, "at {baud}");
                    if expected {
                        let (mut buffer, mut other) = ([0; MAX_TELEGRAM], [0; MAX_TELEGRAM]);
                        let (end, taken) = line.take(&mut buffer).unwrap();
                        assert_eq!((end, taken), (clock.at(ticks), receiver.take(&mut other)), "at {baud}");
                        complete += 1;
                    }
                    assert_eq!(line.errors(), (receiver.damaged(), 0), "at {baud}");
                }
            }
            assert!(complete > 1_000, "{complete} telegrams at {baud}");
        }
    }

    /// A line at 500 kbit/s, whose characters look damaged at every other rate.
    #[test]
    fn the_search_finds_the_rate_of_the_bus_and_answers_at_it() {
        const TRUE_RATE: Baud = Baud::B500000;
        const PERIOD: u32 = 150_000;
        let mut bus = BusStation::searching(side(), 5, &TIMING, 0);
        let mut line = Line::new(&TIMING, bus.baud(), 0);
        let mut ticks = 0;
        for _ in 0..2000 {
            ticks += PERIOD;
            let is_true = bus.baud() == TRUE_RATE;
            let heard = FDL_STATUS.map(|octet| Some(octet).filter(|_| is_true));
            let mut end = ticks;
            let mut is_complete = false;
            for octet in heard {
                end += 330;
                is_complete = line.character(end, octet);
            }
            let mut buffer = [0; MAX_TELEGRAM];
            if is_complete && let Some((at, octets)) = line.take(&mut buffer) {
                let telegram = Telegram::parse(octets).unwrap();
                assert!(matches!(bus.telegram(at, &telegram, || end + 100), Next::Send { .. }), "at {}", bus.baud());
                assert_eq!(bus.baud(), TRUE_RATE);
                return;
            }
            let now = end + 5000;
            if let Next::SetRate(baud) = bus.poll(now) {
                line = Line::new(&TIMING, baud, now);
            }
        }
        panic!("not found; the rate is {}", bus.baud());
    }
}
