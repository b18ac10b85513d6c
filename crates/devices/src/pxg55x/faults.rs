//! The faults of the series.

use crate::model::{FaultList, faults};

faults! {
    /// The active faults. The effect of each is a bit of the exception details (7.1.12). The list ends with the
    /// faults of the instances, because a gauge has those of its own instances only.
    pub Faults;
    eeprom         Eeprom        "EEPROM exception, alarm and warning";
    ram            Ram           "RAM exception, alarm and warning";
    eprom          Eprom         "EPROM exception, alarm and warning; together with ram CRITICAL FAULT";
    comm           Comm          "internal communication exception, manufacturer alarm and warning";
    sensor_1       Sensor1       "Sensor Element Failure of instance 1";
    electronics_1  Electronics1  "Electronics Failure of instance 1";
    sensor_2       Sensor2       "Sensor Element Failure of instance 2";
    electronics_2  Electronics2  "Electronics Failure of instance 2";
    sensor_3       Sensor3       "Sensor Element Failure of the atmosphere sensor, in its own block only";
    electronics_3  Electronics3  "Electronics Failure of the atmosphere sensor, in its own block only";
}

/// The faults of the device, and two for each of this number of instances: the first of the list.
const fn of_instances(instances: usize) -> FaultList {
    const OF_DEVICE: usize = 4;
    let count = OF_DEVICE.saturating_add(instances.saturating_mul(2));
    let (faults, _) = Faults::LIST.faults.split_at(count);
    let (effects, _) = Faults::LIST.effects.split_at(count);
    FaultList { faults, effects }
}

/// The faults of a PCG55x with an atmosphere sensor.
pub static PCG_WITH_ATM_FAULTS: FaultList = of_instances(3);

/// The faults of a PCG55x without one.
pub static PCG_FAULTS: FaultList = of_instances(2);

/// The faults of a PSG55x.
pub static PSG_FAULTS: FaultList = of_instances(1);
