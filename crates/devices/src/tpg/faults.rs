//! The faults of TPG300 and TPG500.

use super::CHANNELS;
use crate::model::faults;

faults! {
    /// The active faults; the numbers are those of the channels.
    pub Faults;
    comm           Comm          "no link to the controller: error on every channel, nothing can be written (156)";
    sensor_1       Sensor1       "error on channel A1";
    sensor_2       Sensor2       "error on channel A2";
    sensor_3       Sensor3       "error on channel B1";
    sensor_4       Sensor4       "error on channel B2";
    electronics_1  Electronics1  "error on channel A1";
    electronics_2  Electronics2  "error on channel A2";
    electronics_3  Electronics3  "error on channel B1";
    electronics_4  Electronics4  "error on channel B2";
    unplugged_1    Unplugged1    "error on channel A1";
    unplugged_2    Unplugged2    "error on channel A2";
    unplugged_3    Unplugged3    "error on channel B1";
    unplugged_4    Unplugged4    "error on channel B2";
}

impl Faults {
    /// The failed channels. The measurement status does not distinguish the causes.
    pub(super) const fn failed(&self) -> [bool; CHANNELS] {
        [
            self.sensor_1 || self.electronics_1 || self.unplugged_1,
            self.sensor_2 || self.electronics_2 || self.unplugged_2,
            self.sensor_3 || self.electronics_3 || self.unplugged_3,
            self.sensor_4 || self.electronics_4 || self.unplugged_4,
        ]
    }
}
