//! The states of a reading, and their codes in each protocol: the one table that all gateways use.

use profivac_devices::reading::Quality;
use profivac_station::view::{BusStationState, Gauge, Reading};

/// The state of a reading, finer than its quality: a gauge that is switched off is no defect, and one that starts is not missing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum State {
    /// The gauge measures.
    Ok = 0,
    /// The pressure is below the range; the value is the end of the range.
    UnderRange = 1,
    /// The pressure is above the range; the value is the end of the range.
    OverRange = 2,
    /// The gauge does not measure because its emission, its high voltage or its heating is off.
    Off = 3,
    /// The gauge is being brought into data exchange.
    Starting = 4,
    /// The gauge declares its number invalid.
    Invalid = 5,
    /// No gauge is connected to the channel.
    NotPresent = 6,
    /// The gauge gives no data, or gave the last ones too long ago.
    #[default]
    Stale = 7,
    /// The gauge reports a defect.
    Fault = 8,
    /// The gauge exchanges data, and the station has not read this parameter lately. No reading has this state.
    NotRead = 9,
    /// The status octet of a point of a slave calls its number uncertain (PROFIBUS PA profile 3.02). No reading has this state.
    Uncertain = 10,
}

/// The severity of an alarm in EPICS.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum EpicsSeverity {
    /// `NO_ALARM`.
    None = 0,
    /// `MINOR`.
    Minor = 1,
    /// `MAJOR`.
    Major = 2,
    /// `INVALID`: the value must not be used.
    Invalid = 3,
}

/// The status of an alarm in EPICS, with its number in Channel Access (`alarm.h` of EPICS base).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EpicsStatus {
    /// `NO_ALARM`.
    None = 0,
    /// `READ`.
    Read = 1,
    /// `HIHI`.
    HiHi = 3,
    /// `HIGH`.
    High = 4,
    /// `LOLO`.
    LoLo = 5,
    /// `LOW`.
    Low = 6,
    /// `STATE`.
    State = 7,
    /// `COMM`.
    Comm = 9,
    /// `TIMEOUT`.
    Timeout = 10,
    /// `HWLIMIT`.
    HwLimit = 11,
    /// `SCAN`: the value was not read again in time.
    Scan = 13,
    /// `UDF`: there is no value yet.
    Undefined = 17,
    /// `DISABLE`.
    Disable = 18,
    /// `SIMM`: the value is simulated.
    Simulated = 19,
}

/// The health of a device in OPC UA (`DeviceHealthEnumeration`, OPC 10000-100, after NAMUR NE 107).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Health {
    /// `NORMAL`.
    Normal = 0,
    /// `FAILURE`.
    Failure = 1,
    /// `CHECK_FUNCTION`.
    CheckFunction = 2,
    /// `OFF_SPEC`.
    OffSpec = 3,
}

/// The codes of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Codes {
    /// The words for users; EPICS allows 25 characters, 16 states.
    pub label: &'static str,
    /// Whether the value is a measured pressure.
    pub is_measured: bool,
    /// Whether there is a value: a measured pressure, or the end of the range.
    pub has_value: bool,
    /// The severity in EPICS, unless the site configures another one.
    pub epics_severity: EpicsSeverity,
    /// The status in EPICS while the severity is not `NO_ALARM`.
    pub epics_status: EpicsStatus,
    /// The status code in OPC UA (OPC 10000-4, table of status codes).
    pub opcua: u32,
    /// The property `Quality` in Sparkplug 3.0: 0 bad, 192 good, 500 stale. It has no uncertain values: what is not measured is bad.
    pub sparkplug: i32,
    /// The state in the Modbus map.
    pub modbus: u16,
    /// The health of the device.
    pub health: Health,
}

macro_rules! states {
    ($($state:ident $label:literal $measured:literal $value:literal $severity:ident $status:ident $opcua:literal $sparkplug:literal $modbus:literal $health:ident;)+) => {
        impl State {
            /// All states, by number.
            pub const ALL: [Self; [$($label),+].len()] = [$(Self::$state),+];

            /// The words of all states, by number.
            pub const LABELS: [&'static str; Self::ALL.len()] = [$($label),+];

            /// The codes in the protocols.
            #[must_use]
            pub const fn codes(self) -> Codes {
                match self {
                    $(Self::$state => Codes {
                        label: $label,
                        is_measured: $measured,
                        has_value: $value,
                        epics_severity: EpicsSeverity::$severity,
                        epics_status: EpicsStatus::$status,
                        opcua: $opcua,
                        sparkplug: $sparkplug,
                        modbus: $modbus,
                        health: Health::$health,
                    },)+
                }
            }
        }
    };
}

states! {
    // state    words         measured value EPICS             OPC UA      Sparkplug Modbus health
    Ok         "OK"           true  true  None    None     0x0000_0000 192 0 Normal;
    UnderRange "Under range"  false true  Minor   HwLimit  0x4094_0000 0   2 Normal;
    OverRange  "Over range"   false true  Minor   HwLimit  0x4094_0000 0   1 Normal;
    Off        "Off"          false false Minor   Disable  0x808D_0000 0   3 CheckFunction;
    Starting   "Starting"     false false Invalid State    0x8031_0000 500 4 CheckFunction;
    Invalid    "Invalid"      false false Invalid Read     0x808C_0000 0   3 OffSpec;
    NotPresent "Not present"  false false Invalid Comm     0x808A_0000 0   3 CheckFunction;
    Stale      "Stale"        false false Invalid Comm     0x8031_0000 500 4 Failure;
    Fault      "Fault"        false false Invalid Read     0x808C_0000 0   3 Failure;
    NotRead    "Not read lately" false false Invalid Scan  0x809B_0000 500 4 Normal;
    Uncertain  "Uncertain"    true  true  Minor   Read     0x4000_0000 192 0 OffSpec;
}

impl State {
    /// The words of the states of a reading, by number.
    pub const READING_LABELS: &'static [&'static str] = {
        let labels: &'static [&'static str] = &Self::LABELS;
        labels.split_at(Self::NotRead as usize).0
    };

    /// The state of a reading of `gauge`. A reading older than the limit of its gauge is stale, also if its segment does not say so.
    #[must_use]
    pub fn of(gauge: &Gauge, reading: &Reading) -> Self {
        let is_fresh = gauge.age_ms.is_some_and(|age| age <= gauge.stale_after_ms);
        match reading.quality {
            _ if gauge.state == BusStationState::Starting => Self::Starting,
            _ if !is_fresh => Self::Stale,
            // A number that is no pressure is no defect. A controller has no alarms of its own: the status of the channel reports its defect.
            Quality::Fault if gauge.exceptions.is_empty() && !reading.is_defect => Self::Invalid,
            quality => Self::recorded(quality),
        }
    }

    /// The state of a recorded sample with this quality.
    #[must_use]
    pub const fn recorded(quality: Quality) -> Self {
        match quality {
            Quality::Valid => Self::Ok,
            Quality::Underrange => Self::UnderRange,
            Quality::Overrange => Self::OverRange,
            Quality::Off => Self::Off,
            Quality::Missing => Self::NotPresent,
            Quality::Stale => Self::Stale,
            // A pressure in an assumed unit may be false: its text says what it would be.
            Quality::Assumed => Self::Invalid,
            Quality::Fault => Self::Fault,
        }
    }

    /// The words for users.
    #[must_use]
    pub const fn label(self) -> &'static str {
        self.codes().label
    }

    /// Its number, from 0.
    #[must_use]
    pub const fn number(self) -> u16 {
        self as u16
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_of_a_state_is_its_row() {
        for (number, state) in (0..).zip(State::ALL) {
            assert_eq!(state.number(), number);
        }
    }

    /// Channel Access allows 16 states with 25 characters and an end mark.
    #[test]
    fn the_words_fit_into_an_enumeration_of_epics() {
        assert!(State::ALL.len() <= 16);
        assert!(State::LABELS.iter().all(|label| label.len() <= 25));
    }

    /// Sparkplug 3.0, tck-id-payloads-propertyset-quality-value-value.
    #[test]
    fn sparkplug_has_three_qualities() {
        assert!(State::ALL.iter().all(|state| [0, 192, 500].contains(&state.codes().sparkplug)));
    }

    /// The end of the range must not look like a pressure.
    #[test]
    fn a_value_that_is_not_measured_is_not_good_in_epics_and_sparkplug() {
        for state in State::ALL {
            let Codes { is_measured, epics_severity, epics_status, sparkplug, .. } = state.codes();
            assert_eq!(epics_severity == EpicsSeverity::None, state == State::Ok, "{state:?}");
            assert_eq!(epics_status == EpicsStatus::None, state == State::Ok, "{state:?}");
            assert_eq!(sparkplug == 192, is_measured, "{state:?}");
        }
    }

    /// The two highest bits of a status code in OPC UA: 0 good, 1 uncertain, 2 bad.
    #[test]
    fn a_value_that_is_not_measured_is_not_good_in_opc_ua() {
        for state in State::ALL {
            let severity = state.codes().opcua >> 30;
            assert_eq!(severity == 0, state == State::Ok, "{state:?}");
            assert_eq!(severity == 2, !state.codes().has_value, "{state:?}");
        }
    }
}
