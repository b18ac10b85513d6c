//! A segment in memory: devices and their master on one line, octet by octet in bit times, at any speed.
//!
//! All stations use the codec that a real line uses.

use crate::device::VirtualDevice;
use crate::gsd_slave::GsdStation;
use profivac_client::cyclic::{CyclicSlave, CyclicValues};
use profivac_client::ms2::{Ms2Error, Ms2Line};
use profivac_dp::link::active::{Active, CheckedBus};
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Received, Receiver, Station, T_SYN_TBIT};
use profivac_dp::master::{Handle, Mode, Operation, Settings, SlaveListError};
use profivac_host::line::{Line, Pace, Stations};
use profivac_host::session::BusMaster;
use profivac_vacuum::sensor::Environment;
use profivac_wire::MAX_TELEGRAM;
use std::collections::VecDeque;
use std::time::Duration;

/// The number of telegrams in the history.
const MAX_TELEGRAMS: usize = 32;

/// The most octets of the traffic that wait for [`MemorySegment::take_traffic`]; the oldest are dropped. chosen: minutes of the line
/// of a demonstration.
const MAX_TRAFFIC: usize = 1 << 20;

/// Octets on the line without a pause between them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// When the first of them began.
    pub start: BitTime,
    /// The octets.
    pub octets: Vec<u8>,
    /// The positions of those that noise has changed.
    pub errors: Vec<usize>,
}

/// The stations of the segment.
struct MemoryStations {
    devices: Vec<VirtualDevice>,
    /// Slaves by their GSD files, which belong to no master of the segment.
    slaves: Vec<GsdStation>,
    master: Box<Active<BusMaster>>,
}

impl Stations for MemoryStations {
    type Station = dyn Station;

    fn all(&self) -> impl Iterator<Item = &Self::Station> {
        let devices = self.devices.iter().map(|device| device as &dyn Station);
        let slaves = self.slaves.iter().map(|slave| slave as &dyn Station);
        devices.chain(slaves).chain([&*self.master as &dyn Station])
    }

    fn all_mut(&mut self) -> impl Iterator<Item = &mut Self::Station> {
        let devices = self.devices.iter_mut().map(|device| device as &mut dyn Station);
        let slaves = self.slaves.iter_mut().map(|slave| slave as &mut dyn Station);
        devices.chain(slaves).chain([&mut *self.master as &mut dyn Station])
    }
}

/// A segment in memory with a history of its telegrams.
pub struct MemorySegment {
    line: Line<MemoryStations>,
    slaves: Vec<CyclicSlave>,
    baud: Baud,
    now: BitTime,
    receiver: Receiver,
    telegrams: VecDeque<Vec<u8>>,
    /// The traffic for a listener, and the number of its octets; `None` without one.
    traffic: Option<(VecDeque<Traffic>, usize)>,
}

impl MemorySegment {
    /// `devices` and a master on `bus` that exchanges data with `watched`.
    ///
    /// # Errors
    /// [`SlaveListError`] when the master cannot have such a slave.
    pub fn new(
        devices: Vec<VirtualDevice>,
        watched: Vec<CyclicSlave>,
        bus: CheckedBus,
        baud: Baud,
    ) -> Result<Self, SlaveListError> {
        let mut master = Box::new(BusMaster::on(bus, Settings::new(baud), BitTime(0)));
        for slave in &watched {
            master.user.add(&slave.parameters(baud))?;
        }
        master.user.set_mode(Mode::Operate);
        let receiver = Receiver::with_idle(BitTime(0), T_SYN_TBIT);
        Ok(Self {
            line: Line::new(MemoryStations { devices, slaves: Vec::new(), master }, receiver.clone(), Pace::ByLine),
            slaves: watched,
            baud,
            now: BitTime(0),
            receiver,
            telegrams: VecDeque::new(),
            traffic: None,
        })
    }

    /// The same with slaves by their GSD files, with which its master exchanges no data.
    #[must_use]
    pub fn with_slaves(mut self, slaves: Vec<GsdStation>) -> Self {
        self.line.stations_mut().slaves = slaves;
        self
    }

    /// The devices and the slaves by their GSD files, mutable.
    pub fn stations_mut(&mut self) -> (&mut [VirtualDevice], &mut [GsdStation]) {
        let stations = self.line.stations_mut();
        (&mut stations.devices, &mut stations.slaves)
    }

    /// Runs the segment until `seconds` after its start.
    pub fn run_until(&mut self, seconds: f64) {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a count of bit times, never negative"
        )]
        let end = self.now.max(BitTime((seconds * f64::from(self.baud.bits_per_second())) as u64));
        let mut out = Vec::new();
        while let Some(next) = self.line.wake_at().filter(|next| *next <= end) {
            self.now = self.now.max(next);
            out.clear();
            self.line.advance(self.now, &mut out);
            out.iter().for_each(|octet| self.record_octet(*octet));
        }
        self.now = end;
    }

    /// Keeps the traffic from now on for [`take_traffic`](Self::take_traffic).
    pub fn keep_traffic(&mut self) {
        self.traffic.get_or_insert_default();
    }

    /// The traffic since the last call, from [`keep_traffic`](Self::keep_traffic) on.
    pub fn take_traffic(&mut self) -> VecDeque<Traffic> {
        self.traffic.as_mut().map(std::mem::take).unwrap_or_default().0
    }

    /// The present time of the segment.
    #[must_use]
    pub const fn now(&self) -> BitTime {
        self.now
    }

    /// Keeps an octet that ended now.
    fn keep_octet(&mut self, octet: u8, is_hit: bool) {
        let start = BitTime(self.now.0.saturating_sub(CHARACTER_TBIT));
        let Some((traffic, count)) = &mut self.traffic else { return };
        let is_next = |last: &Traffic| last.start + CHARACTER_TBIT.saturating_mul(last.octets.len() as u64) == start;
        if traffic.back().is_none_or(|last| !is_next(last)) {
            traffic.push_back(Traffic { start, ..Traffic::default() });
        }
        let Some(last) = traffic.back_mut() else { return };
        if is_hit {
            last.errors.push(last.octets.len());
        }
        last.octets.push(octet);
        *count = count.saturating_add(1);
        while *count > MAX_TRAFFIC
            && let Some(oldest) = traffic.pop_front()
        {
            *count = count.saturating_sub(oldest.octets.len());
        }
    }

    fn record_octet(&mut self, octet: u8) {
        let is_hit = self.line.is_last_hit();
        self.keep_octet(octet, is_hit);
        if is_hit {
            self.receiver.character_error(self.now);
            return;
        }
        if let Received::Telegram(telegram) = self.receiver.octet(self.now, octet) {
            let mut octets = [0; MAX_TELEGRAM];
            let length = telegram.emit(&mut octets).unwrap_or_default();
            self.telegrams.push_back(octets.iter().take(length).copied().collect());
            if self.telegrams.len() > MAX_TELEGRAMS {
                self.telegrams.pop_front();
            }
        }
    }

    /// Sets the probability with which noise damages an octet, 0 to 1.
    pub fn set_noise(&mut self, part: f64) {
        self.line.set_noise(part);
    }

    /// The time since the start of the segment, in seconds.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.now.0 as f64 / f64::from(self.baud.bits_per_second())
    }

    /// Changes the environment of all devices.
    pub fn set_environment(&mut self, around: impl Into<Environment>) {
        let around = around.into();
        self.devices_mut().for_each(|device| device.set_environment(around));
    }

    /// The devices.
    pub fn devices(&self) -> impl Iterator<Item = &VirtualDevice> {
        self.line.stations().devices.iter()
    }

    /// The devices, mutable.
    pub fn devices_mut(&mut self) -> impl Iterator<Item = &mut VirtualDevice> {
        self.line.stations_mut().devices.iter_mut()
    }

    /// The slaves of the master.
    #[must_use]
    pub fn slaves(&self) -> &[CyclicSlave] {
        &self.slaves
    }

    /// The master.
    #[must_use]
    pub fn master(&self) -> &BusMaster {
        &self.line.stations().master.user
    }

    /// The master, mutable.
    pub fn master_mut(&mut self) -> &mut BusMaster {
        &mut self.line.stations_mut().master.user
    }

    /// The values in the last inputs of a slave.
    #[must_use]
    pub fn values(&self, watched: &CyclicSlave) -> CyclicValues {
        self.master().inputs(watched.address).map(|inputs| watched.decode_inputs(inputs)).unwrap_or_default()
    }

    /// The last telegrams on the line, the oldest first.
    pub fn telegrams(&self) -> impl DoubleEndedIterator<Item = &[u8]> {
        self.telegrams.iter().map(Vec::as_slice)
    }

    /// The baud rate.
    #[must_use]
    pub const fn baud(&self) -> Baud {
        self.baud
    }
}

/// The longest wait for an MS2 answer, in seconds of the segment.
const MS2_TIMEOUT_S: f64 = 10.0;

/// The piece of time in which the segment advances while a request waits, in seconds.
const MS2_STEP_S: f64 = 1e-3;

impl Ms2Line for MemorySegment {
    fn baud(&self) -> Baud {
        self.baud
    }

    fn master(&mut self) -> &mut BusMaster {
        self.master_mut()
    }

    fn wait_for<O: Operation, T>(
        &mut self,
        handle: Handle<O>,
        take: impl FnOnce(O::Outcome<'_>) -> T,
    ) -> Result<T, Ms2Error> {
        let end = self.seconds() + MS2_TIMEOUT_S;
        while self.seconds() < end {
            if let Some(outcome) = self.master_mut().outcome(handle) {
                return Ok(take(outcome));
            }
            self.run_until(self.seconds() + MS2_STEP_S);
        }
        Err(Ms2Error::NoAnswer)
    }

    fn pause(&mut self, time: Duration) -> Result<(), Ms2Error> {
        self.run_until(self.seconds() + time.as_secs_f64());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::GasConditions;
    use crate::device_spec::DeviceSpec;
    use crate::nonvolatile::NonvolatileMemory;
    use profivac_client::cyclic::ReportedChannels;
    use profivac_client::ms2::Ms2;
    use profivac_client::pressure::Pressure;
    use profivac_devices::bcg450::table::MODEL;
    use profivac_dp::link::active::BusParameters;
    use profivac_vacuum::Gas;

    impl MemorySegment {
        fn run(&mut self, seconds: f64) {
            self.run_until(self.seconds() + seconds);
        }
    }

    fn conditions(mbar: f64) -> GasConditions {
        let atmosphere = Pressure::from_mbar(1013.25);
        GasConditions { pressure: Pressure::from_mbar(mbar), atmosphere, gas: Gas::N2 }
    }

    fn segment(baud: Baud) -> MemorySegment {
        segment_of(baud, |device| device)
    }

    fn segment_of(baud: Baud, change: impl Fn(VirtualDevice) -> VirtualDevice) -> MemorySegment {
        let devices = [5, 6].map(|address| {
            let spec: DeviceSpec = format!("bcg450@{address}").parse().unwrap();
            change(VirtualDevice::new(
                spec.build(NonvolatileMemory::volatile(), baud).unwrap(),
                address,
                baud,
                conditions(1e-3),
            ))
        });
        let (configuration, unit) = (MODEL.default_configuration, MODEL.unit_named("mbar").unwrap());
        let watched = [5, 6].map(|address| CyclicSlave {
            address,
            model: &MODEL,
            configuration,
            unit,
            channels: ReportedChannels::default(),
        });
        let bus = BusParameters::new(1, baud).check().unwrap();
        MemorySegment::new(devices.into(), watched.into(), bus, baud).unwrap()
    }

    #[test]
    fn the_master_reads_the_pressures_that_the_gauges_measure() {
        for baud in [Baud::B9600, Baud::B93750, Baud::B1500000] {
            let mut segment = segment(baud);
            for mbar in [1e-3, 5e-8, 0.2, 900.0] {
                segment.set_environment(conditions(mbar));
                segment.run(1.0);
                for watched in segment.slaves() {
                    let read = segment.values(watched).values[0].pa.unwrap() / 100.0;
                    assert!((read / mbar - 1.0).abs() < 1e-6, "{read} instead of {mbar} mbar at {baud}");
                }
            }
            let counters = *segment.master().counters(6).unwrap();
            assert!(counters.exchanges > 20, "{counters:?} at {baud}");
            assert_eq!((counters.lost, counters.repetitions, counters.starts), (0, 0, 1), "at {baud}");
            assert!((segment.seconds() - 4.0).abs() < 1e-3);
        }
    }

    #[test]
    fn with_real_sensors_a_seed_determines_the_course_at_any_step_length() {
        let run = |seed: u64, pieces: u32| {
            let mut segment = segment_of(Baud::B187500, |device| device.with_real_sensors(seed));
            (1..=pieces).for_each(|piece| segment.run_until(2.0 * f64::from(piece) / f64::from(pieces)));
            segment.slaves().iter().map(|watched| segment.values(watched).values[0].pa.unwrap()).collect::<Vec<_>>()
        };
        let once = run(7, 1);
        assert_eq!(run(7, 100), once);
        assert_ne!(run(8, 1), once);
        assert_ne!(once[0], once[1], "no two gauges are alike");
        assert!(once.iter().all(|pa| (pa / 0.1 - 1.0).abs() < 0.3), "{once:?}");
    }

    #[test]
    fn damaged_telegrams_are_repeated_and_never_read() {
        let mut segment = segment(Baud::B187500);
        segment.run(1.0);
        segment.set_noise(0.002);
        for _ in 0..20 {
            segment.run(0.5);
            for watched in segment.slaves() {
                let read = segment.values(watched).values[0].pa.unwrap() / 100.0;
                assert!((read / 1e-3 - 1.0).abs() < 1e-6, "{read}");
            }
        }
        let disturbed = *segment.master().counters(5).unwrap();
        assert!(disturbed.repetitions > 10, "{disturbed:?}");
        segment.set_noise(0.0);
        segment.run(5.0);
        let quiet = *segment.master().counters(5).unwrap();
        assert!(quiet.exchanges > disturbed.exchanges + 100 && quiet.repetitions == disturbed.repetitions, "{quiet:?}");
    }

    #[test]
    fn a_gauge_without_power_leaves_data_exchange_and_returns() {
        let mut segment = segment(Baud::B187500);
        segment.run(1.0);
        segment.devices_mut().take(1).for_each(|device| device.set_power(false));
        segment.run(1.0);
        let counters = |segment: &MemorySegment, address| *segment.master().counters(address).unwrap();
        assert!(counters(&segment, 5).lost > 0);
        assert_eq!(counters(&segment, 6).lost, 0);
        segment.devices_mut().for_each(|device| device.set_power(true));
        segment.run(1.0);
        assert_eq!(counters(&segment, 5).starts, 2);
    }

    /// Safe State of the selected instance is slot 1 index 39.
    #[test]
    fn a_write_after_the_gauge_was_switched_off_and_on_opens_a_new_connection() {
        let mut segment = segment(Baud::B187500);
        segment.run(1.0);
        let mut connection = Ms2::new(&mut segment, 5);
        connection.write(1, 39, &[2]).unwrap();
        let segment = connection.line();
        segment.devices_mut().take(1).for_each(|device| device.set_power(false));
        segment.run(10.0);
        segment.devices_mut().for_each(|device| device.set_power(true));
        segment.run(1.0);
        connection.write(1, 39, &[1]).unwrap();
        assert_eq!(connection.read(1, 39).unwrap(), [1]);
    }

    #[test]
    fn the_history_contains_the_last_telegrams() {
        let mut segment = segment(Baud::B187500);
        segment.run(1.0);
        let telegrams: Vec<_> = segment.telegrams().collect();
        assert_eq!(telegrams.len(), MAX_TELEGRAMS);
        assert!(telegrams.contains(&&[0xDC, 1, 1][..]));
        assert!(telegrams.iter().any(|octets| octets.starts_with(&[0x68, 0x0A, 0x0A, 0x68, 1, 5, 0x08])));
    }
}
