//! A segment as a master sees it: 1 to 124 slaves, two octets each way.
//!
//! The slaves are real until they exchange data; from then on each answers with the same octets, so that only the master
//! is counted. Both masters are called when they have something to do, and no oftener: ours says when that is, profirust is
//! polled when a request has left, when its answer is there, and when it may speak again.

use crate::rig::{BAUD, MASTER, Mirror, telegram};
use profirust::dp::{DpMaster, Peripheral, PeripheralOptions};
use profirust::fdl::{FdlActiveStation, ParametersBuilder};
use profirust::phy::ProfibusPhy;
use profirust::{Baudrate, time};
use profivac_dp::link::active::{Active, BusParameters};
use profivac_dp::link::{BitTime, CHARACTER_TBIT, Received, Receiver, Station, T_SYN_TBIT};
use profivac_dp::master::{Master, Mode, Settings, SlaveParameters};
use profivac_dp::slave::Slave;
use profivac_wire::control::{Control, Status};
use profivac_wire::{DataTelegram, Telegram};
use std::hint::black_box;

/// The most slaves there are, at the addresses 1 and up.
const MOST: u8 = 124;
/// Two octets in, two octets out.
const CFG: [u8; 2] = [0x11, 0x21];
/// How long a slave waits before it answers.
const T_SDR_TBIT: u64 = 11;

/// The slaves.
struct Segment {
    /// At the addresses 1 and up.
    slaves: Vec<Slave<Mirror>>,
    /// The answer of each slave to Data_Exchange.
    inputs: Vec<Vec<u8>>,
    /// The answer of each slave to FDL status.
    statuses: Vec<Vec<u8>>,
    /// The answer of a real slave.
    answer: Vec<u8>,
    exchanges: u32,
}

impl Segment {
    fn new(slaves: u8) -> Self {
        let inputs = |sa| DataTelegram { fc: Control::slave(Status::DataLow).to_octet(), du: &[1, 2], ..status(sa) };
        Self {
            slaves: (1..=slaves).map(|address| Slave::new(Mirror::default(), address, BAUD)).collect(),
            inputs: (1..=slaves).map(|sa| telegram(inputs(sa))).collect(),
            statuses: (1..=slaves).map(|sa| telegram(status(sa))).collect(),
            answer: Vec::new(),
            exchanges: 0,
        }
    }

    /// The answer to a telegram that ended at `end`.
    fn answer(&mut self, end: BitTime, octets: &[u8]) -> Option<&[u8]> {
        match octets {
            // An SD2 without access points: Data_Exchange.
            [0x68, _, _, _, da @ 1..=MOST, ..] => {
                self.exchanges += 1;
                self.inputs.get(usize::from(*da) - 1).map(Vec::as_slice)
            }
            [0x10, da @ 1..=MOST, _, 0x49, ..] => self.statuses.get(usize::from(*da) - 1).map(Vec::as_slice),
            // The token, and Global_Control.
            [0xDC, ..] | [0x68, _, _, _, 0xFF, ..] => None,
            _ => self.ask(end, octets),
        }
    }

    fn ask(&mut self, end: BitTime, octets: &[u8]) -> Option<&[u8]> {
        let telegram = Telegram::parse(octets).ok()?;
        self.answer = self.slaves.iter_mut().find_map(|slave| Some(slave.telegram(end, &telegram)?.octets.to_vec()))?;
        Some(&self.answer)
    }
}

/// The answer of a slave to FDL status.
fn status(sa: u8) -> DataTelegram<'static> {
    DataTelegram::short(MASTER, sa, Control::slave(Status::Ok))
}

/// Our master.
pub(crate) struct Ours {
    station: Active<Master<124, 4>>,
    receiver: Receiver,
    segment: Segment,
    now: BitTime,
}

impl Ours {
    /// All slaves exchange data.
    pub(crate) fn exchanging(slaves: u8) -> Self {
        let mut master = Self::new(slaves);
        while master.station.user.exchanging() < usize::from(slaves) {
            master.step();
        }
        master
    }

    fn new(slaves: u8) -> Self {
        let bus = BusParameters::new(MASTER, BAUD).check().unwrap_or_else(|rejected| unreachable!("{rejected}"));
        let mut station = Master::on(bus, Settings::new(BAUD), BitTime(0));
        for address in 1..=slaves {
            let parameters = SlaveParameters { watchdog: None, ..SlaveParameters::new(address, Mirror::IDENT, &CFG) };
            station.user.add(&parameters).unwrap_or_else(|rejected| unreachable!("{rejected}"));
        }
        station.user.set_mode(Mode::Operate);
        Self { station, receiver: Receiver::new(BitTime(0)), segment: Segment::new(slaves), now: BitTime(0) }
    }

    /// The number of exchanges, and the present time.
    pub(crate) const fn clock(&self) -> (u32, BitTime) {
        (self.segment.exchanges, self.now)
    }

    /// The next telegram of the master, and its answer if there is one.
    pub(crate) fn step(&mut self) {
        self.now = self.station.wake_at().unwrap_or(self.now).max(self.now);
        let Some(transmit) = self.station.poll(self.now) else { return };
        self.now = transmit.not_before.max(self.now) + CHARACTER_TBIT * transmit.octets.len() as u64;
        let answer = self.segment.answer(self.now, transmit.octets);
        self.station.sent(self.now);
        let Some(answer) = answer else { return };
        let first = self.now + T_SDR_TBIT + CHARACTER_TBIT;
        if let (_, Received::Telegram(telegram)) = self.receiver.octets(first, answer) {
            self.now = self.now + T_SDR_TBIT + CHARACTER_TBIT * answer.len() as u64;
            black_box(self.station.telegram(self.now, &telegram));
        }
    }
}

/// Runs `times` exchanges of this project's master, once all slaves exchange data.
pub fn exchange<const SLAVES: u8>(times: u32) {
    let mut master = Ours::exchanging(SLAVES);
    let goal = master.segment.exchanges + times;
    while master.segment.exchanges < goal {
        master.step();
    }
}

/// The port of profirust: it answers every telegram at once, and the driver advances the time by its duration.
struct Phy {
    segment: Segment,
    now: BitTime,
    heard: Vec<u8>,
}

impl ProfibusPhy for Phy {
    fn poll_transmission(&mut self, _now: time::Instant) -> bool {
        false
    }

    fn transmit_data<F: FnOnce(&mut [u8]) -> (usize, R), R>(&mut self, _now: time::Instant, fill: F) -> R {
        let mut buffer = [0; 256];
        let (length, result) = fill(&mut buffer);
        self.now = self.now + CHARACTER_TBIT * length as u64;
        if let Some(answer) = self.segment.answer(self.now, &buffer[..length]) {
            self.heard.extend_from_slice(answer);
            self.now = self.now + T_SDR_TBIT + CHARACTER_TBIT * answer.len() as u64;
        }
        result
    }

    fn receive_data<F: FnOnce(&[u8]) -> (usize, R), R>(&mut self, _now: time::Instant, take: F) -> R {
        let (taken, result) = take(&self.heard);
        self.heard.drain(..taken);
        result
    }
}

/// The master of profirust.
pub(crate) struct Theirs<'a> {
    station: FdlActiveStation,
    master: DpMaster<'a>,
    phy: Phy,
}

impl Theirs<'_> {
    /// All slaves exchange data.
    pub(crate) fn exchanging(slaves: u8) -> Self {
        let mut master = Self::new(slaves);
        while !master.all_exchange() {
            master.step(T_SYN_TBIT);
        }
        master
    }

    fn new(slaves: u8) -> Self {
        let mut master = DpMaster::new(Vec::new());
        for address in 1..=slaves {
            let options = PeripheralOptions {
                ident_number: Mirror::IDENT,
                user_parameters: Some(&[]),
                config: Some(&CFG),
                max_tsdr: 150,
                ..PeripheralOptions::default()
            };
            master.add(Peripheral::new(address, options, vec![0; 2], vec![0; 2]));
        }
        let mut parameters = ParametersBuilder::new(MASTER, Baudrate::B1500000);
        let mut station = FdlActiveStation::new(parameters.slot_bits(300).build_verified(&master));
        station.set_online();
        master.enter_operate();
        Self { station, master, phy: Phy { segment: Segment::new(slaves), now: BitTime(0), heard: Vec::new() } }
    }

    /// The number of exchanges, and the present time.
    pub(crate) const fn clock(&self) -> (u32, BitTime) {
        (self.phy.segment.exchanges, self.phy.now)
    }

    /// Polls, and lets some time pass if nothing was sent.
    pub(crate) fn step(&mut self, idle_tbit: u64) {
        let before = self.phy.now;
        let us = before.0.saturating_mul(1_000_000) / u64::from(BAUD.bits_per_second());
        let now = time::Instant::from_micros(i64::try_from(us).unwrap_or(i64::MAX));
        self.station.poll(now, &mut self.phy, &mut self.master);
        black_box(self.master.take_last_events());
        if self.phy.now == before {
            self.phy.now = before + idle_tbit;
        }
    }

    fn all_exchange(&self) -> bool {
        self.master.iter().all(|(_, peripheral)| peripheral.is_running())
    }
}

/// Runs `times` exchanges of profirust, once all slaves exchange data.
pub fn exchange_peer<const SLAVES: u8>(times: u32) {
    let mut master = Theirs::exchanging(SLAVES);
    let goal = master.phy.segment.exchanges + times;
    while master.phy.segment.exchanges < goal {
        master.step(T_SYN_TBIT);
    }
}
