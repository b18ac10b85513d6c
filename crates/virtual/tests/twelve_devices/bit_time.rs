//! The line in bit times: telegram by telegram, without a clock.

use crate::twelve_devices::rig::{BAUD, Line, MASTER};
use profivac_devices::{Principle, SimulatedDevice};
use profivac_dp::link::active::{Active, BusParameters};
use profivac_dp::link::{BitTime, CHARACTER_TBIT, Listening, Station};
use profivac_dp::master::Settings;
use profivac_host::clock::duration_of;
use profivac_host::session::BusMaster;
use profivac_virtual::device::GaugeSlave;
use profivac_virtual::device_spec::DeviceSpec;
use profivac_virtual::nonvolatile::NonvolatileMemory;
use profivac_wire::{BROADCAST, Telegram};
use std::time::Duration;

pub struct InBitTime {
    station: Box<Active<BusMaster>>,
    units: Vec<Box<dyn GaugeSlave>>,
    now: BitTime,
}

impl InBitTime {
    pub fn new(devices: &[String]) -> Self {
        // A small GAP, because these tests do not test it.
        let bus = BusParameters { hsa: MASTER, ..BusParameters::new(MASTER, BAUD) };
        let station = Box::new(BusMaster::on(bus.check().unwrap(), Settings::new(BAUD), BitTime(0)));
        let unit = |device: &String| {
            let mut unit = device.parse::<DeviceSpec>().unwrap().build(NonvolatileMemory::volatile(), BAUD).unwrap();
            evacuate(unit.device_mut());
            unit
        };
        Self { station, units: devices.iter().map(unit).collect(), now: BitTime(0) }
    }

    /// Delivers a telegram that was sent to the stations it concerns. Returns the answer, if there is one.
    fn deliver(&mut self, octets: &[u8]) -> Option<(BitTime, Vec<u8>)> {
        let telegram = Telegram::parse(octets).unwrap();
        let mut answer = None;
        for unit in &mut self.units {
            if unit.wake_at().is_some_and(|due| due <= self.now) {
                unit.poll(self.now);
            }
            if !concerns(&telegram, unit.listening()) {
                continue;
            }
            let sent = unit.telegram(self.now, &telegram).map(|answer| (answer.not_before, answer.octets.to_vec()));
            if let Some((not_before, octets)) = &sent {
                unit.sent(self.now.max(*not_before) + octets.len() as u64 * CHARACTER_TBIT);
            }
            answer = answer.or(sent);
        }
        answer
    }
}

/// Whether a station receives a telegram, as on any line.
fn concerns(telegram: &Telegram<'_>, listening: Listening) -> bool {
    match (listening, telegram) {
        (Listening::Everything, _) => true,
        (Listening::Own(address), Telegram::Data(frame)) => [address, BROADCAST].contains(&frame.da),
        (Listening::Own(_), _) => false,
    }
}

impl Line for InBitTime {
    fn master(&mut self) -> &mut BusMaster {
        &mut self.station.user
    }

    /// Sends one telegram of the master and delivers its answer.
    fn step(&mut self) {
        self.now = self.now.max(self.station.wake_at().unwrap());
        let Some(transmit) = self.station.poll(self.now) else { return };
        let octets = transmit.octets.to_vec();
        self.now = self.now.max(transmit.not_before) + octets.len() as u64 * CHARACTER_TBIT;
        self.station.sent(self.now);
        let Some((not_before, octets)) = self.deliver(&octets) else { return };
        self.now = self.now.max(not_before) + octets.len() as u64 * CHARACTER_TBIT;
        self.station.telegram(self.now, &Telegram::parse(&octets).unwrap());
    }

    fn elapsed(&self) -> Duration {
        duration_of(BAUD, self.now.0)
    }

    fn settle(&mut self) {
        self.units.iter_mut().for_each(|unit| unit.device_mut().settle());
    }
}

/// All sensors in a good vacuum, where everything can be switched on.
fn evacuate(simulated: &mut dyn SimulatedDevice) {
    simulated.settle();
    for part in 0..simulated.parts().len() {
        if simulated.parts()[part].principle != Principle::Atmosphere {
            simulated.sense(part, 1e-4);
        }
    }
    simulated.settle();
}
