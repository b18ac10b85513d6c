//! The faults of the BCG450-SP.

use crate::model::faults;

faults! {
    /// The active faults. The effect of each is a bit of the exception details (3.1.1.11, 3.1.1.12).
    pub Faults;
    eeprom         Eeprom        "EEPROM exception, alarm and warning";
    ram            Ram           "RAM exception, alarm and warning";
    eprom          Eprom         "EPROM exception, alarm and warning; together with ram CRITICAL FAULT";
    comm           Comm          "internal communication, manufacturer alarm and warning";
    pirani_adjust  PiraniAdjust  "electronics warning of the Pirani";
    sensor_1       Sensor1       "sensor alarm of the Pirani";
    sensor_2       Sensor2       "sensor alarm of the BA";
    sensor_3       Sensor3       "sensor alarm of the CDG";
    electronics_1  Electronics1  "sensor alarm of the Pirani";
    electronics_2  Electronics2  "sensor alarm of the BA";
    electronics_3  Electronics3  "sensor alarm of the CDG";
}
