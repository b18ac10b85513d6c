//! Virtual devices, and the time and the ports through which a segment sees them.

use super::test_slave::TestSlave;
use crate::segment::edge::{Edge, SegmentCommand};
use crate::segment::moment::Moment;
use profivac_client::cyclic::CyclicSlave;
use profivac_client::pressure::Pressure;
use profivac_dp::link::active::BusParameters;
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Station, T_SYN_TBIT};
use profivac_host::clock::{duration_of, tbit_of};
use profivac_host::port::{Character, Port, PortError};
use profivac_host::readiness::Readiness;
use profivac_recorder::Micros;
use profivac_vacuum::Gas;
use profivac_virtual::device::{GasConditions, VirtualDevice};
use profivac_virtual::device_spec::{DeviceSpec, entry};
use profivac_virtual::memory_segment::{MemorySegment, Traffic};
use profivac_virtual::nonvolatile::NonvolatileMemory;
use profivac_wire::{DataTelegram, Telegram};
use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

/// The rate of the line of a polled segment.
pub const BAUD: Baud = Baud::B187500;

/// The address of the master of a line that the station hears.
pub const FOREIGN_MASTER: u8 = 1;

/// Class 2 masters use the service access points up to this one (profibus-wire 4.1).
const LAST_MS2: u8 = 50;

/// The step in which a foreign master runs.
const STEP: Duration = Duration::from_micros(200);

/// The pause of the line behind each telegram: a listener finds the beginning of a telegram behind a pause.
const PAUSE: Duration = Duration::from_millis(3);

/// A device on a polled line.
struct Slave {
    station: Box<dyn Station + Send>,
    address: u8,
    answers_ms2: bool,
}

/// What is connected to the port.
enum Bus {
    /// Slaves of the station's master.
    Slaves(Vec<Slave>),
    /// A foreign master with its slaves, and its time. It stands still while the line pauses.
    Foreign(Box<MemorySegment>, Duration),
}

/// Devices, time, and the state of cable and port.
pub struct Plant {
    now: Duration,
    bus: Bus,
    /// When an answer arrives, and its octets.
    arriving: VecDeque<(Duration, Vec<u8>)>,
    /// What the foreign master and its slave send.
    telegrams: Telegrams,
    pause_until: Duration,
    /// The cable is cut: nothing arrives.
    pub is_silent: bool,
    /// The port is gone, and cannot be opened.
    pub is_gone: bool,
    /// When the segment found that the port is gone, and when it tried to open it since.
    pub lost: Option<Duration>,
    pub openings: Vec<Duration>,
    /// How far the clock of the system was set.
    pub clock_set: i64,
}

/// The octets of a line without a pause between them, until a pause follows: a port delivers them together.
#[derive(Default)]
struct Telegrams(VecDeque<Traffic>);

impl Telegrams {
    fn add(&mut self, traffic: Traffic) {
        match self.0.back_mut().filter(|last| end(last) == traffic.start) {
            Some(last) => last.octets.extend(traffic.octets),
            None => self.0.push_back(traffic),
        }
    }

    fn take(&mut self, now: BitTime) -> Option<Vec<u8>> {
        let is_over = |first: &Traffic| end(first) + T_SYN_TBIT <= now;
        self.0.pop_front_if(|first| is_over(first)).map(|first| first.octets)
    }
}

fn end(traffic: &Traffic) -> BitTime {
    traffic.start + CHARACTER_TBIT * traffic.octets.len() as u64
}

/// A device by its specification: `bcg450@5`.
fn device(text: &str, baud: Baud) -> VirtualDevice {
    let spec: DeviceSpec = text.parse().unwrap();
    let conditions =
        GasConditions { pressure: Pressure::from_mbar(2e-3), atmosphere: Pressure::from_mbar(1000.0), gas: Gas::N2 };
    let unit = spec.build(NonvolatileMemory::volatile(), baud).unwrap();
    VirtualDevice::new(unit, spec.address, baud, conditions)
}

/// A BCG450 at address 5 whose master has another rate than the segment may expect.
fn foreign(baud: Baud) -> Box<MemorySegment> {
    let model = entry("bcg450").unwrap().model;
    let (configuration, unit) = (model.default_configuration, model.unit_named("mbar").unwrap());
    let slave = CyclicSlave { address: 5, model, configuration, unit, channels: Default::default() };
    let bus = BusParameters::new(FOREIGN_MASTER, baud).check().unwrap();
    let mut segment = MemorySegment::new(vec![device("bcg450@5", baud)], vec![slave], bus, baud).unwrap();
    segment.keep_traffic();
    Box::new(segment)
}

impl Plant {
    fn new(bus: Bus) -> Self {
        Self {
            now: Duration::ZERO,
            bus,
            arriving: VecDeque::new(),
            telegrams: Telegrams::default(),
            pause_until: Duration::ZERO,
            is_silent: false,
            is_gone: false,
            lost: None,
            openings: Vec::new(),
            clock_set: 0,
        }
    }

    /// Whether the device at this address answers class 2 masters.
    pub fn set_ms2(&mut self, address: u8, answers: bool) {
        let Bus::Slaves(slaves) = &mut self.bus else { panic!("a foreign master") };
        let slave = slaves.iter_mut().find(|slave| slave.address == address).unwrap();
        slave.answers_ms2 = answers;
    }

    /// Time passes while the segment does nothing.
    pub fn stall(&mut self, time: Duration) {
        self.now += time;
    }

    /// A foreign master and its slave at another rate. They exchange data already: nobody heard how they began.
    pub fn set_foreign(&mut self, baud: Baud) {
        let (mut segment, began) = (foreign(baud), Duration::from_secs(3));
        segment.run_until(began.as_secs_f64());
        segment.take_traffic();
        (self.bus, self.telegrams) = (Bus::Foreign(segment, began), Telegrams::default());
    }

    /// Other stations send these octets.
    pub fn hear(&mut self, octets: Vec<u8>) {
        self.arriving.push_back((self.now, octets));
    }

    /// The station sends.
    fn send(&mut self, octets: &[u8]) {
        let Bus::Slaves(slaves) = &mut self.bus else { panic!("a listener sent {octets:02X?}") };
        let end = BitTime(tbit_of(BAUD, self.now)) + octets.len() as u64 * CHARACTER_TBIT;
        // A token has no check octet, and no slave answers it.
        let Ok(telegram) = Telegram::parse(octets) else { return };
        if self.is_silent {
            return;
        }
        for slave in slaves {
            let is_ms2 = matches!(&telegram, Telegram::Data(frame) if frame.dsap.is_some_and(|sap| sap <= LAST_MS2));
            slave.station.poll(end);
            if is_ms2 && !slave.answers_ms2 {
                continue;
            }
            if let Some(answer) = slave.station.telegram(end, &telegram) {
                let begin = answer.not_before.max(end);
                let end = begin + answer.octets.len() as u64 * CHARACTER_TBIT;
                self.arriving.push_back((duration_of(BAUD, end.0), answer.octets.to_vec()));
            }
        }
    }

    /// Passes time, until octets arrive.
    fn pass(&mut self, at_most: Duration, rate: Baud) {
        let end = self.now + at_most.max(Duration::from_nanos(1));
        match &mut self.bus {
            Bus::Slaves(_) => self.now = self.arriving.front().map_or(end, |(at, _)| (*at).clamp(self.now, end)),
            Bus::Foreign(segment, time) => {
                while self.now < end && self.arriving.is_empty() {
                    if self.now < self.pause_until {
                        self.now = self.pause_until.min(end);
                        continue;
                    }
                    self.now = (self.now + STEP).min(end);
                    *time += STEP;
                    segment.run_until(time.as_secs_f64());
                    for traffic in segment.take_traffic() {
                        self.telegrams.add(traffic);
                    }
                    let Some(mut octets) = self.telegrams.take(segment.now()) else { continue };
                    self.pause_until = self.now + PAUSE;
                    // At another rate a UART finds other octets.
                    if segment.baud() != rate {
                        octets.iter_mut().for_each(|octet| *octet = !*octet);
                    }
                    if !self.is_silent {
                        self.arriving.push_back((self.now, octets));
                    }
                }
            }
        }
    }

    fn take(&mut self) -> Option<Vec<u8>> {
        let (_, octets) = self.arriving.pop_front_if(|(at, _)| *at <= self.now)?;
        Some(octets)
    }
}

/// The plant as a segment sees it.
#[derive(Clone)]
pub struct VirtualEdge {
    plant: Arc<Mutex<Plant>>,
    began: Moment,
}

impl VirtualEdge {
    fn new(bus: Bus) -> Self {
        let began = Moment { at: Instant::now(), wall: Micros::now() };
        Self { plant: Arc::new(Mutex::new(Plant::new(bus))), began }
    }

    /// Slaves for the master of the station.
    pub fn with_slaves(devices: &[&str]) -> Self {
        let slave = |text: &&str| {
            let device = device(text, BAUD);
            Slave { address: device.switch_address(), station: Box::new(device), answers_ms2: true }
        };
        Self::new(Bus::Slaves(devices.iter().map(slave).collect()))
    }

    /// The same line with these slaves besides.
    pub fn and(self, slaves: &[&TestSlave]) -> Self {
        if let Bus::Slaves(all) = &mut self.plant().bus {
            all.extend(slaves.iter().map(|slave| {
                let station = Box::new(profivac_dp::slave::Slave::<_, 2>::new((*slave).clone(), slave.address, BAUD));
                Slave { address: slave.address, station, answers_ms2: true }
            }));
        }
        self
    }

    /// A foreign master with one gauge.
    pub fn with_foreign(baud: Baud) -> Self {
        Self::new(Bus::Foreign(foreign(baud), Duration::ZERO))
    }

    /// Master 7, which is not heard, sends these telegrams to the slave at `address`.
    pub fn master_7_sends(&self, address: u8, telegrams: &[(Option<u8>, &[u8])]) {
        let mut plant = self.plant();
        let Bus::Slaves(slaves) = &mut plant.bus else { panic!("a foreign master") };
        let slave = slaves.iter_mut().find(|slave| slave.address == address).unwrap();
        // The first request has no frame count bit, the next ones alternate.
        for (number, (dsap, du)) in (1..).zip(telegrams) {
            let fc = if number == 1 {
                0x6D
            } else if number % 2 == 0 {
                0x5D
            } else {
                0x7D
            };
            let ssap = dsap.map(|_| 62);
            let request = DataTelegram { da: address, sa: 7, dsap: *dsap, ssap, fc, du };
            let answer = slave.station.telegram(BitTime(number * 10_000), &Telegram::Data(request));
            assert!(answer.is_some(), "telegram {number}");
        }
    }

    pub fn plant(&self) -> MutexGuard<'_, Plant> {
        self.plant.lock().unwrap()
    }

    /// The time since the beginning.
    pub fn elapsed(&self) -> Duration {
        self.plant().now
    }

    fn port(&self, name: &str, rate: Baud) -> Result<Box<dyn Port>, PortError> {
        let mut plant = self.plant();
        let now = plant.now;
        plant.openings.push(now);
        if plant.is_gone {
            return Err(PortError::Lost(name.to_owned()));
        }
        plant.arriving.clear();
        Ok(Box::new(VirtualPort { name: name.to_owned(), edge: self.clone(), opened: now, rate }))
    }
}

impl Edge for VirtualEdge {
    fn now(&self) -> Moment {
        let plant = self.plant();
        let wall = Micros(self.began.wall.after(plant.now).0 + plant.clock_set);
        Moment { at: self.began.at + plant.now, wall }
    }

    fn open(&self, name: &str, baud: Baud) -> Result<Box<dyn Port>, PortError> {
        self.port(name, baud)
    }

    fn open_to_listen(&self, name: &str, baud: Baud) -> Result<Box<dyn Port>, PortError> {
        self.port(name, baud)
    }

    fn command(
        &self,
        commands: &Receiver<SegmentCommand>,
        at_most: Duration,
    ) -> Result<SegmentCommand, RecvTimeoutError> {
        commands.try_recv().map_err(|error| match error {
            TryRecvError::Disconnected => RecvTimeoutError::Disconnected,
            TryRecvError::Empty => {
                self.plant().now += at_most;
                RecvTimeoutError::Timeout
            }
        })
    }
}

/// A port in virtual time.
struct VirtualPort {
    name: String,
    edge: VirtualEdge,
    opened: Duration,
    rate: Baud,
}

impl VirtualPort {
    fn plant(&self) -> Result<MutexGuard<'_, Plant>, PortError> {
        let mut plant = self.edge.plant();
        if !plant.is_gone {
            return Ok(plant);
        }
        (plant.lost, plant.openings) = (Some(plant.now), Vec::new());
        Err(PortError::Lost(self.name.clone()))
    }
}

impl Port for VirtualPort {
    fn name(&self) -> &str {
        &self.name
    }

    fn readiness(&self) -> Vec<Readiness<'_>> {
        Vec::new()
    }

    fn receive(&mut self, characters: &mut Vec<Character>) -> Result<(), PortError> {
        let mut plant = self.plant()?;
        while let Some(octets) = plant.take() {
            characters.extend(octets.into_iter().map(Character::Octet));
        }
        Ok(())
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
        self.plant()?.send(octets);
        Ok(())
    }

    fn set_baud(&mut self, baud: Baud) -> Result<(), PortError> {
        self.rate = baud;
        Ok(())
    }

    fn simulated_time(&self) -> Option<Duration> {
        Some(self.edge.elapsed().saturating_sub(self.opened))
    }

    fn simulate(&mut self, at_most: Duration) {
        self.edge.plant().pass(at_most, self.rate);
    }
}
