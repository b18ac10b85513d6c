//! Telegrams that go to their receivers alone.
//!
//! A passive station notices nothing but whole telegrams to itself. A shared tap that reads a whole telegram to another
//! station, undisturbed, is afterwards as before: it waits for the next telegram. So while all shared taps read all telegrams
//! undisturbed, a telegram is announced only to the taps that need it: those of its receivers, and those of single stations.
//! The first signal that may be disturbed, and every fault and change of the stations, ends this:
//! [`Segment::announce_everywhere`] announces what is still on the line to the other taps, and from then on each tap gets each
//! signal, until a telegram finds all shared taps in step again.

use super::Segment;
use crate::listeners::Listener;
use crate::signal::Signal;
use profivac_dp::link::BitTime;
use profivac_wire::Telegram;

/// A transmission on the line.
#[derive(Clone, Debug)]
pub(super) struct OnLine {
    pub(super) signal: Signal,
    pub(super) sender: usize,
    pub(super) position: u64,
    pub(super) begin: BitTime,
    pub(super) end: BitTime,
}

impl OnLine {
    /// When the signal begins at `position`.
    fn begin_at(&self, position: u64) -> BitTime {
        self.begin + self.position.abs_diff(position)
    }

    /// When the signal ends at `position`.
    fn end_at(&self, position: u64) -> BitTime {
        self.end + self.position.abs_diff(position)
    }
}

impl Segment {
    /// Whether all shared taps read a signal undisturbed as a telegram. Behind another one it does so at all positions if it
    /// begins after the end of that at its own: no signal overtakes another on the cable.
    pub(super) fn reaches_all_undisturbed(&self, next: &OnLine) -> bool {
        let mut shared = self.taps.iter().filter(|tap| tap.owner.is_none());
        next.signal.is_telegram()
            && self.echo.is_none()
            && self.cut.is_none()
            && match self.on_line.back() {
                Some(last) => last.end_at(next.position) <= next.begin,
                None => shared.all(|tap| tap.is_in_step(next.begin_at(tap.position))),
            }
    }

    /// Announces a telegram to the taps of its receivers and to those of single stations.
    pub(super) fn announce_to_receivers(&mut self, next: OnLine, telegram: &Telegram<'_>) {
        for index in &self.own_taps {
            let tap = &mut self.taps[*index];
            if tap.owner != Some(next.sender) {
                tap.announce(next.signal.clone(), Some(next.sender), next.begin_at(tap.position));
                self.tap_times.set(*index, tap.next());
            }
        }
        for Listener { tap: index, .. } in self.listeners.of(telegram) {
            let tap = &mut self.taps[index];
            tap.announce_once(next.signal.clone(), Some(next.sender), next.begin_at(tap.position));
            self.tap_times.set(index, tap.next());
        }
        let is_over = |before: &mut OnLine| before.end + self.length_tbit < next.begin;
        while self.on_line.pop_front_if(is_over).is_some() {}
        self.on_line.push_back(next);
    }

    /// Announces the telegrams on the line to the taps that do not know them, except where they ended before `from`. From now on
    /// all taps get each signal.
    pub(super) fn announce_everywhere(&mut self, from: BitTime) {
        for before in std::mem::take(&mut self.on_line) {
            for (index, tap) in self.taps.iter_mut().enumerate().filter(|(_, tap)| tap.owner.is_none()) {
                if before.end_at(tap.position) >= from {
                    tap.announce_once(before.signal.clone(), Some(before.sender), before.begin_at(tap.position));
                    self.tap_times.set(index, tap.next());
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stations::{ReceivedTelegram, Tester};
    use crate::{Fault, Noise, OctetErrors, Random, StationHandle, StationId, TelegramFault};
    use profivac_dp::link::{Baud, Listening, Station, Transmit};
    use profivac_wire::{BROADCAST, MAX_TELEGRAM};

    const SEEDS: u64 = 40;
    const TELEGRAMS: u64 = 250;

    /// A passive station that keeps what it gets, answers most requests, and takes another address with some.
    struct Listener {
        address: u8,
        random: Random,
        received: Vec<ReceivedTelegram>,
        answer: Vec<u8>,
    }

    impl Listener {
        fn new(address: u8, seed: u64) -> Self {
            Self { address, random: Random::new(seed), received: Vec::new(), answer: Vec::new() }
        }
    }

    impl Station for Listener {
        fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
            self.received.push(ReceivedTelegram { end, octets: octets(telegram) });
            let Telegram::Data(data) = telegram else { return None };
            if data.da == BROADCAST {
                return None;
            }
            if self.random.below(10) == 0 {
                self.address = 1 + self.random.below(100) as u8;
            }
            self.answer = match self.random.below(60) {
                0..10 => return None,
                10..20 => vec![0xE5],
                // Not a telegram.
                20 => vec![0x10, 1, 2],
                _ => sd1(data.sa, data.da, 0),
            };
            Some(Transmit { not_before: end + 11 + self.random.below(60), octets: &self.answer })
        }

        fn poll(&mut self, _now: BitTime) -> Option<Transmit<'_>> {
            None
        }

        fn wake_at(&self) -> Option<BitTime> {
            None
        }

        fn listening(&self) -> Listening {
            Listening::Own(self.address)
        }
    }

    fn octets(telegram: &Telegram<'_>) -> Vec<u8> {
        let mut octets = [0; MAX_TELEGRAM];
        let length = telegram.emit(&mut octets).unwrap();
        octets[..length].to_vec()
    }

    fn sd1(da: u8, sa: u8, fc: u8) -> Vec<u8> {
        vec![0x10, da, sa, fc, da.wrapping_add(sa).wrapping_add(fc), 0x16]
    }

    /// Two testers, which send telegrams with faults between them, and passive stations at a few positions.
    struct Plant {
        segment: Segment,
        testers: Vec<StationHandle<Tester>>,
        listeners: Vec<StationHandle<Listener>>,
        violations: Vec<String>,
        /// How often telegrams went to their receivers alone at the end of a run, and how often not.
        direct: usize,
        everywhere: usize,
    }

    impl Plant {
        fn new(seed: u64) -> Self {
            let mut random = Random::new(seed);
            let mut segment = Segment::new(Baud::B1500000);
            segment.set_trace_length(usize::MAX);
            let positions = [0, random.below(60), random.below(400), random.below(400)];
            let mut anywhere = || positions[random.below(4) as usize];
            let testers = (0..2).map(|_| segment.attach_at(anywhere(), Tester::new())).collect();
            let mut passive =
                |address: u8| segment.attach_at(anywhere(), Listener::new(address, seed + u64::from(address)));
            let listeners = (1..=12).map(&mut passive).collect();
            Self { segment, testers, listeners, violations: Vec::new(), direct: 0, everywhere: 0 }
        }

        /// A station that no signal reaches in time: its tap is never in step, so all taps get each signal.
        fn with_a_remote_station(mut self) -> Self {
            self.segment.attach_at(u64::MAX / 4, Listener::new(0, 0));
            self
        }

        fn run_until(&mut self, end: BitTime) {
            while let Err(violation) = self.segment.run_until(end) {
                self.violations.push(violation.to_string());
            }
            *(if self.segment.on_line.is_empty() { &mut self.everywhere } else { &mut self.direct }) += 1;
        }

        /// Sends telegrams at random times, mostly long after each other, and injects or schedules random faults.
        fn play(&mut self, seed: u64) {
            let mut random = Random::new(!seed);
            for _ in 0..TELEGRAMS {
                let pause = if random.below(40) == 0 { random.below(120) } else { 500 + random.below(1500) };
                let at = self.segment.now() + pause;
                let tester = self.testers[random.below(2) as usize];
                let listener = self.listeners[random.below(12) as usize];
                let da = self.segment.station(listener).address;
                self.segment.station_mut(tester).send(at, &request(da, &mut random));
                match random.below(50) {
                    0 => self.segment.inject(fault(&mut random)),
                    1 => self.segment.schedule_fault(at + random.below(300), fault(&mut random)),
                    // A fault at the end of the telegram, at a station where it begins.
                    2 => self.segment.schedule_fault(at + 66, fault(&mut random)),
                    3..10 => self.end_faults(),
                    _ => {}
                }
                self.run_until(at + random.below(200));
            }
        }

        fn end_faults(&mut self) {
            for fault in [Fault::Noise(None), Fault::OctetErrors(None), Fault::Echo(None), Fault::Cut(None)] {
                self.segment.inject(fault);
            }
        }

        /// Everything that stations and referee notice.
        fn noticed(&self) -> (Vec<Vec<ReceivedTelegram>>, Vec<usize>, &[String]) {
            let testers = self.testers.iter().map(|tester| self.segment.station(*tester));
            let listeners = self.listeners.iter().map(|listener| self.segment.station(*listener).received.clone());
            let received = testers.clone().map(|tester| tester.received.clone()).chain(listeners).collect();
            (received, testers.map(|tester| tester.characters).collect(), &self.violations)
        }
    }

    /// A fault. Power fails at, and comes back to, the first stations only: with power or noise of its own a station shares no tap.
    fn fault(random: &mut Random) -> Fault {
        let (station, few) = (StationId(random.below(14) as usize), StationId(random.below(6) as usize));
        match random.below(8) {
            0 => Fault::Power(few, random.below(3) > 0),
            1 => Fault::Noise(Some(Noise::new(random.below(1000), 0.002))),
            2 => Fault::NoiseAt(few, Some(Noise::new(random.below(1000), 0.001))),
            3 => Fault::Telegram(station, TelegramFault::Flip(vec![random.below(60) as usize])),
            4 => Fault::Telegram(station, TelegramFault::Lose(random.below(6) as usize)),
            5 => Fault::OctetErrors(Some(OctetErrors { seed: random.below(1000), loss: 0.02, insertion: 0.02 })),
            6 => Fault::Echo(Some(random.below(300))),
            _ => Fault::Cut(Some(random.below(400))),
        }
    }

    /// A telegram to `da` or to all, a token, or octets that are none.
    fn request(da: u8, random: &mut Random) -> Vec<u8> {
        match random.below(60) {
            0..5 => vec![0xDC, da, 0],
            5..10 => sd1(BROADCAST, 0, 0x46),
            10 => vec![0x10, 0xE5],
            _ => sd1(da, 0, 0x49),
        }
    }

    #[test]
    fn a_station_with_a_tap_of_its_own_gets_a_telegram_to_its_new_address_once() {
        let mut segment = Segment::new(Baud::B1500000);
        let tester = segment.attach(Tester::new());
        let station = segment.attach(Listener::new(5, 1));
        segment.attach(Listener::new(6, 2));
        segment.inject(Fault::NoiseAt(station.id(), None));
        segment.station_mut(station).address = 7;
        segment.station_mut(tester).send(BitTime(100), &sd1(7, 0, 0x49));
        segment.run_until(BitTime(170)).unwrap();
        assert_eq!(segment.station(station).received.len(), 1);
    }

    #[test]
    fn stations_and_referee_notice_the_same_as_if_each_tap_got_each_signal() {
        let (mut direct, mut everywhere) = (0, 0);
        for seed in 0..SEEDS {
            let mut fast = Plant::new(seed);
            let mut general = Plant::new(seed).with_a_remote_station();
            fast.play(seed);
            general.play(seed);
            assert_eq!(fast.segment.trace(), general.segment.trace(), "seed {seed}");
            assert_eq!(fast.noticed(), general.noticed(), "seed {seed}");
            assert_eq!(general.direct, 0, "seed {seed}");
            (direct, everywhere) = (direct + fast.direct, everywhere + fast.everywhere);
        }
        let runs = (SEEDS * TELEGRAMS) as usize;
        assert!(direct > runs / 5 && everywhere > runs / 5, "{direct} of {runs} direct, {everywhere} everywhere");
    }
}
