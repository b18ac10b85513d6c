//! A line in simulated time with a gauge of one MS2 connection, whose answers are lost, damaged or late as a test says.
//!
//! The gauge and its time outlast the programs that use the line one after the other.

use profivac_devices::SimulatedDevice;
use profivac_devices::bcg450::Bcg450;
use profivac_devices::profile::Setup;
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Listening, Station, Transmit};
use profivac_dp::slave::Slave;
use profivac_host::clock::{duration_of, tbit_of};
use profivac_host::port::{Character, Delivery, Port, PortError};
use profivac_host::readiness::Readiness;
use profivac_host::session::{BusSession, bus_parameters};
use profivac_vacuum::Gas;
use profivac_virtual::device::{GasConditions, GaugeSlave, VirtualDevice};
use profivac_virtual::nonvolatile::NonvolatileMemory;
use profivac_wire::Telegram;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// The address of the gauge.
pub const ADDRESS: u8 = 5;

/// The function codes of answers without data, and the short acknowledgement in their place.
pub const UE: u8 = 1;
pub const RR: u8 = 2;
pub const RS: u8 = 3;
pub const SC: u8 = 0xE5;

/// min T_SDR of a DP slave.
const MIN_TSDR: u64 = 11;

/// Whether the data unit of a request between two access points begins like this.
fn begins_with(octets: &[u8], du: &[u8]) -> bool {
    octets.get(9..).is_some_and(|rest| rest.starts_with(du))
}

/// What happens to an answer. The first answer has the number 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    None,
    /// This many answers from this one on never arrive.
    Lost(usize, usize),
    /// This many answers from this one on have a wrong check octet.
    Damaged(usize, usize),
    /// From this answer on everything arrives later, until this time has passed: the computer or the slave does something else.
    Stalled(usize, Duration),
    /// This many requests from this one on never reach the gauge.
    Unheard(usize, usize),
}

/// A slave with one MS2 connection.
struct OneConnection<I>(Slave<I, 1>);

impl<I: SimulatedDevice + Send> Station for OneConnection<I> {
    fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
        self.0.telegram(end, telegram)
    }

    fn poll(&mut self, now: BitTime) -> Option<Transmit<'_>> {
        self.0.poll(now)
    }

    fn wake_at(&self) -> Option<BitTime> {
        self.0.wake_at()
    }

    fn listening(&self) -> Listening {
        self.0.listening()
    }
}

impl<I: SimulatedDevice + Send> GaugeSlave for OneConnection<I> {
    fn device(&self) -> &dyn SimulatedDevice {
        self.0.device()
    }

    fn device_mut(&mut self) -> &mut dyn SimulatedDevice {
        self.0.device_mut()
    }

    fn station_address(&self) -> u8 {
        self.0.address()
    }

    fn is_exchanging(&self) -> bool {
        self.0.state().is_exchanging()
    }

    fn power_up(&mut self) {
        let address = self.0.device().station_address();
        self.0.power_up(address);
    }
}

/// The line, the gauge and the time.
struct Plant {
    baud: Baud,
    delivery: Delivery,
    now: Duration,
    gauge: VirtualDevice,
    /// When an answer arrives, and its octets.
    arriving: VecDeque<(Duration, Vec<u8>)>,
    fault: Fault,
    statuses: Vec<(Vec<u8>, u8)>,
    requests: usize,
    answers: usize,
    /// The requests without the repetitions of the link layer, and the answer of the gauge to each.
    journal: Vec<(Vec<u8>, Vec<u8>)>,
    last_request: Vec<u8>,
    /// The last request that was no poll is an Initiate or a write: the master sends them once.
    is_single: bool,
    has_lost_a_single: bool,
}

impl Plant {
    fn tbit(&self, time: Duration) -> BitTime {
        BitTime(tbit_of(self.baud, time))
    }

    fn send(&mut self, octets: &[u8]) {
        let end = self.tbit(self.now) + octets.len() as u64 * CHARACTER_TBIT;
        let is_repetition = octets == self.last_request;
        self.last_request = octets.to_vec();
        let is_token = octets.first() == Some(&0xDC);
        if is_token {
            return;
        }
        // A poll has no data unit, and a request for the FDL status has no access points.
        if let Some([function, _, _, ..]) = octets.get(9..) {
            self.is_single = matches!(function, 0x57 | 0x5F);
        }
        let number = self.requests;
        self.requests += 1;
        let answer = match self.fault {
            Fault::Unheard(from, count) if (from..from.saturating_add(count)).contains(&number) => {
                self.has_lost_a_single |= self.is_single;
                None
            }
            _ => self.ask(end, octets),
        };
        if !is_repetition {
            let answered = answer.as_ref().map(|(_, octets)| octets.clone()).unwrap_or_default();
            self.journal.push((octets.to_vec(), answered));
        }
        if let Some((not_before, octets)) = answer {
            self.answer(not_before.max(end), octets);
        }
    }

    /// The gauge gets a telegram. Returns its answer, and when that begins at the earliest.
    fn ask(&mut self, end: BitTime, octets: &[u8]) -> Option<(BitTime, Vec<u8>)> {
        if let Some((_, status)) = self.statuses.iter().find(|(du, _)| begins_with(octets, du)) {
            let (da, sa) = (octets[5] & 0x7F, octets[4] & 0x7F);
            let check = da.wrapping_add(sa).wrapping_add(*status);
            let answer = if *status == SC { vec![0xE5] } else { vec![0x10, da, sa, *status, check, 0x16] };
            return Some((end + MIN_TSDR, answer));
        }
        self.gauge.poll(end);
        let answer = self.gauge.telegram(end, &Telegram::parse(octets).unwrap());
        answer.map(|answer| (answer.not_before, answer.octets.to_vec()))
    }

    /// The answer leaves the gauge.
    fn answer(&mut self, begin: BitTime, mut octets: Vec<u8>) {
        let number = self.answers;
        self.answers += 1;
        let end = begin + octets.len() as u64 * CHARACTER_TBIT;
        let mut at = duration_of(self.baud, end.0) + self.delivery.delay(self.baud);
        match self.fault {
            Fault::Lost(from, count) if (from..from.saturating_add(count)).contains(&number) => {
                self.has_lost_a_single |= self.is_single;
                return;
            }
            Fault::Damaged(from, count) if (from..from.saturating_add(count)).contains(&number) => {
                self.has_lost_a_single |= self.is_single;
                octets.iter_mut().for_each(|octet| *octet ^= 0x10);
            }
            Fault::Stalled(from, time) if from == number => at += time,
            _ => {}
        }
        let before = self.arriving.back().map_or(Duration::ZERO, |(at, _)| *at);
        self.arriving.push_back((at.max(before), octets));
    }
}

/// A line that several programs use one after the other.
#[derive(Clone)]
pub struct LateLine(Arc<Mutex<Plant>>);

impl LateLine {
    /// A BCG450 at [`ADDRESS`] behind a port that delivers characters like this.
    pub fn new(baud: Baud, delivery: Delivery) -> Self {
        let gauge = Bcg450::new(NonvolatileMemory::volatile(), Setup::new(ADDRESS));
        let slave = Box::new(OneConnection(Slave::with_connections(gauge, ADDRESS, baud)));
        let pressure = profivac_client::pressure::Pressure::from_mbar;
        let around = GasConditions { pressure: pressure(1e-3), atmosphere: pressure(1013.25), gas: Gas::N2 };
        Self(Arc::new(Mutex::new(Plant {
            baud,
            delivery,
            now: Duration::ZERO,
            gauge: VirtualDevice::new(slave, ADDRESS, baud, around),
            arriving: VecDeque::new(),
            fault: Fault::None,
            statuses: Vec::new(),
            requests: 0,
            answers: 0,
            journal: Vec::new(),
            last_request: Vec::new(),
            is_single: false,
            has_lost_a_single: false,
        })))
    }

    /// The master of a new program, at address 0. Characters that came before are lost.
    pub fn session(&self) -> BusSession {
        self.session_of(0)
    }

    /// The same with another station address.
    pub fn session_of(&self, master: u8) -> BusSession {
        // Bounds a hang only: simulated time passes at any speed.
        self.session_with(master, Duration::from_secs(600))
    }

    /// The same with another timeout.
    pub fn session_with(&self, master: u8, timeout: Duration) -> BusSession {
        let mut plant = self.0.lock().unwrap();
        plant.arriving.clear();
        let (baud, delivery) = (plant.baud, plant.delivery);
        drop(plant);
        let port = LatePort { line: self.clone(), begun: self.now() };
        BusSession::new(Box::new(port), baud, bus_parameters(master, baud, delivery), timeout).unwrap()
    }

    /// From now on the answers, counted from 0, have this fault.
    pub fn set_fault(&self, fault: Fault) {
        let mut plant = self.0.lock().unwrap();
        (plant.fault, plant.answers, plant.requests, plant.has_lost_a_single) = (fault, 0, 0, false);
        plant.journal.clear();
    }

    /// Whether an Initiate, a write, a poll for their response or an answer to these was lost since then.
    pub fn has_lost_a_single(&self) -> bool {
        self.0.lock().unwrap().has_lost_a_single
    }

    pub fn fault(&self) -> Fault {
        self.0.lock().unwrap().fault
    }

    /// From now on requests whose data unit begins like this get this answer without data, and the gauge does not get them.
    pub fn answer_with(&self, du: &[u8], status: u8) {
        self.0.lock().unwrap().statuses.push((du.to_vec(), status));
    }

    /// The number of answers since the last call of [`set_fault`](Self::set_fault).
    pub fn answers(&self) -> usize {
        self.0.lock().unwrap().answers
    }

    pub fn requests(&self) -> usize {
        self.0.lock().unwrap().requests
    }

    pub fn now(&self) -> Duration {
        self.0.lock().unwrap().now
    }

    /// The requests since the last call of [`set_fault`](Self::set_fault) whose data unit begins like this, without repetitions of the
    /// link layer.
    pub fn requests_with(&self, du: &[u8]) -> usize {
        let plant = self.0.lock().unwrap();
        plant.journal.iter().filter(|(octets, _)| begins_with(octets, du)).count()
    }

    /// The same requests without those that the gauge did not get or did not take: it answered RS, RR or UE.
    pub fn taken(&self, du: &[u8]) -> usize {
        let plant = self.0.lock().unwrap();
        let is_taken = |answer: &[u8]| !matches!(answer, [] | [0x10, _, _, 1..=3, ..]);
        let sent = plant.journal.iter().filter(|(_, answer)| is_taken(answer));
        sent.filter(|(octets, _)| begins_with(octets, du)).count()
    }
}

/// The port of one program.
struct LatePort {
    line: LateLine,
    begun: Duration,
}

impl Port for LatePort {
    fn name(&self) -> &str {
        "late"
    }

    fn delivery(&self) -> Delivery {
        self.line.0.lock().unwrap().delivery
    }

    fn readiness(&self) -> Vec<Readiness<'_>> {
        Vec::new()
    }

    fn receive(&mut self, characters: &mut Vec<Character>) -> Result<(), PortError> {
        let mut plant = self.line.0.lock().unwrap();
        let now = plant.now;
        while plant.arriving.front().is_some_and(|(at, _)| *at <= now) {
            let (_, octets) = plant.arriving.pop_front().unwrap();
            characters.extend(octets.into_iter().map(Character::Octet));
        }
        Ok(())
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
        self.line.0.lock().unwrap().send(octets);
        Ok(())
    }

    fn simulated_time(&self) -> Option<Duration> {
        Some(self.line.now().saturating_sub(self.begun))
    }

    fn simulate(&mut self, at_most: Duration) {
        let mut plant = self.line.0.lock().unwrap();
        let end = plant.now + at_most.max(Duration::from_nanos(1));
        plant.now = plant.arriving.front().map_or(end, |(at, _)| (*at).clamp(plant.now, end));
    }
}
