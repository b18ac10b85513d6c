//! The words of a manual for the alarms of a device: the bits of Sensor Alarm and of Exception Detail Alarm.

/// A bit of Sensor Alarm, which is also a pair of octets in Exception Detail Alarm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AlarmBit {
    /// The octet, 0 or 1.
    pub octet: usize,
    /// The bit in it.
    pub mask: u8,
    /// The manual's word, with its explanation where the word alone does not say what is broken.
    pub name: &'static str,
}

/// The alarms of a device.
#[derive(Clone, Copy, Debug)]
pub struct AlarmWords {
    /// The instances to which the pairs of octets of Device Exception Detail Alarm belong, in their order. Empty for a device
    /// without that record, or without alarms.
    pub instances: &'static [u8],
    /// The bits of Sensor Alarm.
    pub sensor: &'static [AlarmBit],
    /// The bits of Manufacturer Exception Detail Alarm 0.
    pub manufacturer: &'static [(u8, &'static str)],
}

impl AlarmWords {
    /// A device without alarms.
    pub const NONE: Self = Self { instances: &[], sensor: &[], manufacturer: &[] };

    /// The names of the bits that are set in a Sensor Alarm.
    pub fn sensor_alarms(&self, octets: [u8; 2]) -> impl Iterator<Item = &'static str> {
        let is_set = move |bit: &&AlarmBit| octets.get(bit.octet).is_some_and(|octet| octet & bit.mask != 0);
        self.sensor.iter().filter(is_set).map(|bit| bit.name)
    }
}
