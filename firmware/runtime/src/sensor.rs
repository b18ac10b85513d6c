//! A sensor of one's own behind one of the devices.

use profivac_devices::model::Fault;
use profivac_devices::profile::{Behaviour, BlockDevice};
use profivac_devices::store::Store;
use profivac_devices::{Action, Drive, SimulatedDevice};

/// The state of a sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SensorStatus {
    /// It measures.
    #[default]
    Good,
    /// The sensor is broken: filament, wire, diaphragm.
    SensorFailed,
    /// The electronics around it have failed.
    ElectronicsFailed,
}

/// A measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// The pressure that the sensor senses, in Pa, without the adjustments of the device.
    pub pa: f64,
    /// The state of the sensor.
    pub status: SensorStatus,
}

/// A sensor: the part of a gauge that one builds oneself.
///
/// The device does the rest: units, ranges, validity, safe values, relays, and the adjustment of zero, which it stores.
pub trait Sensor {
    /// The device switches heater, emission or degas. Called before every measurement.
    fn drive(&mut self, _drive: Drive) {}

    /// Measures. May take as long as it needs, since it runs beside the bus.
    fn measure(&mut self) -> Measurement;

    /// Whether the user holds a push button of the board. When it is pressed, the device does what its first button does.
    fn is_button_held(&mut self) -> bool {
        false
    }
}

/// A sensor and the part of the device that it measures for.
#[derive(Clone, Debug)]
pub struct Attached<T> {
    sensor: T,
    part: usize,
    status: SensorStatus,
    /// The button was held at the last measurement.
    is_held: bool,
}

impl<T: Sensor> Attached<T> {
    /// The sensor of a part: 0 for the first in [`SimulatedDevice::parts`].
    pub const fn new(sensor: T, part: usize) -> Self {
        Self { sensor, part, status: SensorStatus::Good, is_held: false }
    }

    /// The sensor.
    pub const fn sensor_mut(&mut self) -> &mut T {
        &mut self.sensor
    }

    /// Measures, and gives the device what was measured.
    pub fn serve<B: Behaviour, S: Store>(&mut self, device: &mut BlockDevice<B, S>) {
        self.sensor.drive(device.drive(self.part));
        let Measurement { pa, status } = self.sensor.measure();
        device.sense(self.part, pa);
        if status != self.status {
            self.status = status;
            self.report(device);
        }
        // Once for each time that it is pressed: what the button sets is stored.
        let was_held = core::mem::replace(&mut self.is_held, self.sensor.is_button_held());
        if self.is_held && !was_held {
            // A device without a button has no such adjustment.
            let _ = device.operate(Action::Button(1));
        }
    }

    /// The faults of the part; a device that does not have one of them cannot report it.
    fn report<B: Behaviour, S: Store>(&self, device: &mut BlockDevice<B, S>) {
        let Some(instance) = device.parts().get(self.part).map(|part| part.instance) else { return };
        let faults = [
            (Fault::of_sensor(instance), SensorStatus::SensorFailed),
            (Fault::of_electronics(instance), SensorStatus::ElectronicsFailed),
        ];
        for (fault, status) in faults {
            if let Some(fault) = fault {
                let _ = device.operate(Action::Fault { fault, active: self.status == status });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use profivac_devices::bcg450::Bcg450;
    use profivac_devices::img400::{Gauges, Img400};
    use profivac_devices::profile::Setup;
    use profivac_devices::store::RamStore;
    use profivac_dp::slave::Device;

    /// A button that is held or not.
    struct Button(bool);

    impl Sensor for Button {
        fn measure(&mut self) -> Measurement {
            Measurement { pa: 1e-4, status: SensorStatus::Good }
        }

        fn is_button_held(&mut self) -> bool {
            self.0
        }
    }

    /// The key of an IMG400 switches the emission of a channel on and off.
    #[test]
    fn a_button_that_is_held_counts_once() {
        let mut controller: Img400<RamStore> = Img400::new(RamStore::default(), Setup::new(5), Gauges::default());
        controller.set_prm(&[0, 0, 0, 0x13, 0x08]).unwrap();
        controller.chk_cfg(&[0x45, 0x90, 5, 8, 8, 8, 8]).unwrap();
        controller.set_exchanging(true);
        controller.settle();
        let mut sensor = Attached::new(Button(true), 0);
        let mut emission = std::vec::Vec::new();
        for is_held in [true, true, true, false, true, true] {
            sensor.sensor_mut().0 = is_held;
            sensor.serve(&mut controller);
            emission.push(controller.report().emission.iter().next().copied());
        }
        assert_eq!(emission, [true, true, true, true, false, false].map(Some));
    }

    struct Broken(SensorStatus, Drive);

    impl Sensor for Broken {
        fn drive(&mut self, drive: Drive) {
            self.1 = drive;
        }

        fn measure(&mut self) -> Measurement {
            Measurement { pa: 5.0, status: self.0 }
        }
    }

    #[test]
    fn a_failed_sensor_is_an_alarm_until_it_measures_again() {
        let mut gauge: Bcg450<RamStore> = Bcg450::new(RamStore::default(), Setup::new(5));
        gauge.settle();
        let good = gauge.report().exception_status;
        let mut sensor = Attached::new(Broken(SensorStatus::Good, Drive::Off), 0);
        for (status, alarm) in [
            (SensorStatus::Good, false),
            (SensorStatus::SensorFailed, true),
            (SensorStatus::ElectronicsFailed, true),
            (SensorStatus::Good, false),
        ] {
            sensor.sensor_mut().0 = status;
            sensor.serve(&mut gauge);
            assert_eq!(gauge.report().exception_status != good, alarm, "{status:?}");
            assert_eq!(gauge.has_alarm(), alarm, "{status:?}");
        }
        assert_eq!(sensor.sensor_mut().1, Drive::On, "the device drives its sensor");
        assert_eq!(gauge.report().indicated.iter().next().map(|reading| reading.value_mbar), Some(0.05));
    }
}
