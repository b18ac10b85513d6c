//! Exception Status and the two detail records. errata-bpg-bcg-tpg 40 to 52.
//!
//! Status, records and the copies for the parameter channel are all made from the details.

use crate::model::Value;

bitflags::bitflags! {
    /// Common Exception Detail 0, alike for alarms and warnings: errata-bpg-bcg-tpg 48 and 49.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct CommonExceptions: u8 {
        /// Internal diagnostic exception.
        const DIAGNOSTIC = 1 << 0;
        /// Microprocessor exception.
        const PROCESSOR = 1 << 1;
        /// EPROM exception.
        const EPROM = 1 << 2;
        /// EEPROM exception.
        const EEPROM = 1 << 3;
        /// RAM exception.
        const RAM = 1 << 4;
        /// Communications exception.
        const COMMUNICATION = 1 << 5;
        /// Internal real-time exception.
        const REAL_TIME = 1 << 6;
    }
}

impl CommonExceptions {
    /// The exceptions of memory faults: errata-bpg-bcg-tpg 48 and 49, errata-pxg55x-img400 37.
    #[must_use]
    pub fn from_memory_faults(eprom: bool, eeprom: bool, ram: bool) -> Self {
        let mut common = Self::empty();
        common.set(Self::EPROM, eprom);
        common.set(Self::EEPROM, eeprom);
        common.set(Self::RAM, ram);
        common
    }

    /// Whether the device cannot run reliably: program memory and working memory are both defective.
    // chosen: no manual says which fault is critical (transition 9).
    #[must_use]
    pub const fn is_critical(self) -> bool {
        self.contains(Self::EPROM.union(Self::RAM))
    }
}

bitflags::bitflags! {
    /// Exception Status.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct ExceptionStatus: u8 {
        /// An alarm of the common group.
        const ALARM_COMMON = 1 << 0;
        /// An alarm of the device group.
        const ALARM_DEVICE = 1 << 1;
        /// An alarm of the manufacturer group.
        const ALARM_MANUFACTURER = 1 << 2;
        /// A warning of the common group.
        const WARNING_COMMON = 1 << 4;
        /// A warning of the device group.
        const WARNING_DEVICE = 1 << 5;
        /// A warning of the manufacturer group.
        const WARNING_MANUFACTURER = 1 << 6;
        /// Always: the expanded format.
        const EXPANDED = 1 << 7;
    }
}

impl ExceptionStatus {
    /// Any alarm.
    pub const ALARM: Self = Self::ALARM_COMMON.union(Self::ALARM_DEVICE).union(Self::ALARM_MANUFACTURER);
}

/// The details of all alarms, or of all warnings. `N` octets belong to the device group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExceptionDetails<const N: usize> {
    /// Common Exception Detail 0; detail 1 is always 0.
    pub common: CommonExceptions,
    /// Device Exception Details.
    pub device: [u8; N],
    /// Manufacturer Exception Detail 0.
    pub manufacturer: u8,
}

impl<const N: usize> ExceptionDetails<N> {
    /// The record: each group after its size.
    #[must_use]
    pub fn record(&self) -> Value {
        self.record_of(N)
    }

    /// The record of a device with only the first `count` device details.
    #[must_use]
    pub fn record_of(&self, count: usize) -> Value {
        let device = self.device.get(..count).unwrap_or(&self.device);
        let common = [2, self.common.bits(), 0, u8::try_from(device.len()).unwrap_or(u8::MAX)];
        let manufacturer = [1, self.manufacturer];
        let octets = common.iter().chain(device).chain(&manufacturer);
        let mut record = [0; 24];
        let length = record.iter_mut().zip(octets).map(|(target, octet)| *target = *octet).count();
        Value::octets(record.get(..length).unwrap_or_default())
    }

    /// A copy of some device details, because the parameter channel transfers at most four octets.
    #[must_use]
    pub fn octets(&self, from: usize, to: usize) -> Value {
        Value::octets(self.device.get(from..to).unwrap_or_default())
    }

    /// Whether any detail is set.
    #[must_use]
    pub fn is_any(&self) -> bool {
        self.groups().contains(&true)
    }

    /// The groups with a detail: common, device, manufacturer.
    fn groups(&self) -> [bool; 3] {
        [!self.common.is_empty(), self.device.iter().any(|detail| *detail != 0), self.manufacturer != 0]
    }
}

/// Exception Status: each group bit is the OR of its details. errata-bpg-bcg-tpg 51.
#[must_use]
pub fn exception_status<const A: usize, const W: usize>(
    alarm: &ExceptionDetails<A>,
    warning: &ExceptionDetails<W>,
) -> ExceptionStatus {
    let [alarm_common, alarm_device, alarm_manufacturer] = alarm.groups();
    let [warning_common, warning_device, warning_manufacturer] = warning.groups();
    let mut status = ExceptionStatus::EXPANDED;
    status.set(ExceptionStatus::ALARM_COMMON, alarm_common);
    status.set(ExceptionStatus::ALARM_DEVICE, alarm_device);
    status.set(ExceptionStatus::ALARM_MANUFACTURER, alarm_manufacturer);
    status.set(ExceptionStatus::WARNING_COMMON, warning_common);
    status.set(ExceptionStatus::WARNING_DEVICE, warning_device);
    status.set(ExceptionStatus::WARNING_MANUFACTURER, warning_manufacturer);
    status
}

#[cfg(test)]
mod tests {
    use super::*;

    const NO_ALARM: ExceptionDetails<4> =
        ExceptionDetails { common: CommonExceptions::empty(), device: [0; 4], manufacturer: 0 };
    const NO_WARNING: ExceptionDetails<5> =
        ExceptionDetails { common: CommonExceptions::empty(), device: [0; 5], manufacturer: 0 };

    #[test]
    fn a_record_has_each_group_after_its_size() {
        // tira36e1 3.1.1.11 and 3.1.1.12: ten and eleven octets
        let alarm = ExceptionDetails {
            common: CommonExceptions::EEPROM | CommonExceptions::RAM,
            device: [1, 2, 3, 4],
            manufacturer: 5,
        };
        assert_eq!(alarm.record(), Value::octets(&[2, 0x18, 0, 4, 1, 2, 3, 4, 1, 5]));
        assert_eq!(NO_WARNING.record(), Value::octets(&[2, 0, 0, 5, 0, 0, 0, 0, 0, 1, 0]));
        assert_eq!(alarm.octets(1, 3), Value::octets(&[2, 3]));
        assert_eq!(alarm.octets(1, 9), Value::octets(&[]), "the group ends before");
    }

    #[test]
    fn each_group_of_details_sets_its_bit_of_exception_status() {
        assert_eq!(exception_status(&NO_ALARM, &NO_WARNING).bits(), 0x80);
        let common = CommonExceptions::EPROM;
        for (bit, alarm, warning) in [
            (0, ExceptionDetails { common, ..NO_ALARM }, NO_WARNING),
            (1, ExceptionDetails { device: [0, 0, 0, 2], ..NO_ALARM }, NO_WARNING),
            (2, ExceptionDetails { manufacturer: 1, ..NO_ALARM }, NO_WARNING),
            (4, NO_ALARM, ExceptionDetails { common, ..NO_WARNING }),
            (5, NO_ALARM, ExceptionDetails { device: [1, 0, 0, 0, 0], ..NO_WARNING }),
            (6, NO_ALARM, ExceptionDetails { manufacturer: 4, ..NO_WARNING }),
        ] {
            assert_eq!(exception_status(&alarm, &warning).bits(), 0x80 | 1 << bit);
            assert_eq!(alarm.is_any(), bit < 3);
        }
    }
}
