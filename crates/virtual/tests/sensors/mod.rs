//! Virtual devices with their sensors: readings in different gases, the effect of adjustments, and processes that take
//! time.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

mod adjust;
mod curves;
mod drive;
mod picture;
mod time;

use profivac_dp::link::Baud;
use profivac_dp::slave::{Dpv1Error, Outputs, Relation};
use profivac_vacuum::sensor::{Environment, REFERENCE_K};
use profivac_vacuum::{Gas, Mixture};
use profivac_virtual::device::VirtualDevice;
use profivac_virtual::device_spec::DeviceSpec;
use profivac_virtual::nonvolatile::NonvolatileMemory;

const ATMOSPHERE_PA: f64 = 101_325.0;

fn around(gas: Gas, mbar: f64) -> Environment {
    Environment { gas: Mixture::pure(gas, mbar * 100.0), atmosphere_pa: ATMOSPHERE_PA, temperature_k: REFERENCE_K }
}

/// A device from its spec, in nitrogen, before it measures.
fn device(spec: &str, mbar: f64) -> VirtualDevice {
    let spec: DeviceSpec = format!("{spec}@5").parse().unwrap();
    let unit = spec.build(NonvolatileMemory::volatile(), Baud::B1500000).unwrap();
    VirtualDevice::new(unit, 5, Baud::B1500000, around(Gas::N2, mbar))
}

/// A device that measures because a master exchanges data with it; on a controller every gauge is switched on.
fn start(device: &mut VirtualDevice) {
    device.device_mut().set_exchanging(true);
    device.advance(1.0);
    let simulated = device.device_mut();
    match simulated.name() {
        // The parameter channel, then Sensor On_Off of four channels.
        "tpg500" => simulated.outputs(Outputs::Data(&[0, 0, 0, 0, 0, 0, 0, 0, 0xFF])),
        "img400" => [1, 2].iter().for_each(|slot| simulated.write(Relation::Ms2(0), *slot, 14, &[3, 1]).unwrap()),
        _ => {}
    }
}

/// Writes a record as a class 2 master.
fn write(device: &mut VirtualDevice, slot: u8, index: u8, octets: &[u8]) -> Result<(), Dpv1Error> {
    device.device_mut().write(Relation::Ms2(0), slot, index, octets)
}

/// The indication of an instance in mbar.
fn indicated(device: &VirtualDevice, instance: u8) -> f64 {
    let report = device.report();
    report.indicated.iter().find(|it| it.instance == instance).unwrap().value_mbar
}

/// The reading of the active instance in mbar.
fn shown(device: &VirtualDevice) -> f64 {
    indicated(device, device.report().active_instance)
}

/// The mean indication of an instance over the next second.
fn mean(device: &mut VirtualDevice, instance: u8) -> f64 {
    let values = (0..100).map(|_| {
        device.advance(0.01);
        indicated(device, instance)
    });
    values.sum::<f64>() / 100.0
}
