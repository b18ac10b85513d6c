//! The faults of the IMG 400.

use crate::model::faults;

faults! {
    /// The active faults. The details behind Exception Status cannot be read (120, 121 of errata-pxg55x-img400).
    pub Faults;
    eeprom         Eeprom        "common alarm and warning";
    ram            Ram           "common alarm and warning";
    eprom          Eprom         "common alarm and warning; together with ram CRITICAL FAULT";
    comm           Comm          "internal serial interface set wrong (3.2): common alarm and warning; stays in INIT";
    power          Power         "general power supply: manufacturer alarm and warning, channels 3 and 4 off until reset";
    overpressure   Overpressure  "channels 1 and 2 see more than p_max: emission goes off until acknowledged";
    sensor_1       Sensor1       "hot cathode supply of channel 1: manufacturer alarm and warning until reset";
    sensor_2       Sensor2       "hot cathode supply of channel 2: manufacturer alarm and warning until reset";
    sensor_3       Sensor3       "the gauge of channel 3 does not answer";
    sensor_4       Sensor4       "the gauge of channel 4 does not answer";
    electronics_1  Electronics1  "hot cathode supply of channel 1: manufacturer alarm and warning until reset";
    electronics_2  Electronics2  "hot cathode supply of channel 2: manufacturer alarm and warning until reset";
    electronics_3  Electronics3  "general power supply, as power";
    electronics_4  Electronics4  "general power supply, as power";
    unplugged_1    Unplugged1    "no gauge on channel 1";
    unplugged_2    Unplugged2    "no gauge on channel 2";
    unplugged_3    Unplugged3    "no gauge on channel 3";
    unplugged_4    Unplugged4    "no gauge on channel 4";
}
