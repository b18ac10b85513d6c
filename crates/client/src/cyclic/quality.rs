//! The quality of a reading from what a device sends beside it.
//!
//! | Device | Condition | Quality |
//! |---|---|---|
//! | BPG, HPG, BCG, PCG, PSG | Reading Invalid, and an alarm in Exception Status (errata-bpg-bcg-tpg 54) | fault |
//! | IMG 400 | Reading Invalid, and a common or manufacturer alarm, which concerns all channels (errata-pxg55x-img400 35) | fault |
//! | all but TPG | Underrange or Overrange Exceeded | underrange, overrange |
//! | BPG, HPG, BCG | Reading Invalid, the Pirani is active below its range: no emission (errata-bpg-bcg-tpg 57) | underrange |
//! | BPG, HPG, BCG, PCG, PSG | Reading Invalid, the value is within the range: a defect that is only a warning | fault |
//! | BPG, HPG, BCG, PCG, PSG | Reading Invalid otherwise: not in EXECUTING, or the Pirani is not heated | off |
//! | IMG 400, ion gauge | Reading Invalid: no emission, or no gauge (errata-pxg55x-img400 125) | off |
//! | IMG 400, other gauge | Reading Invalid while another channel measures | missing |
//! | TPG | Measurement Status 1, 2, 3, 4, 5 (i9973ber/a 3.2.4.1) | underrange, overrange, fault, off, missing |
//! | PCG, PSG in TTR compatibility mode | Bit 7 of the status (tira56e1 4.4.1) | fault |
//! | PCG, PSG in TTR compatibility mode | the value is at an end of the range of the gauge or beyond: the telegram has no status of it | underrange, overrange |
//! | all | no condition above, and the number is the highest integer of its format (errata-bpg-bcg-tpg 70, errata-pxg55x-img400 16) | overrange |
//! | all | no condition above, bit 7 of Exception Status is set, the part is named, and the number is the integer 0, not on a logarithmic scale of COUNTS: less than one unit | underrange |
//! | all | no condition above, and the number is positive and finite | valid |
//! | all | no condition above | fault |

use profivac_devices::Principle;
use profivac_devices::model::{HeldPressure, MeasuringRange};
use profivac_devices::profile::{ExceptionStatus, StatusExtension};
use profivac_devices::reading::{Quality, is_pressure};
use std::fmt;

/// What a device sends about the validity of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ValueStatus {
    /// One Of N Status Extension of a gauge.
    Gauge(StatusExtension),
    /// The status extension of a channel, in Channel Status of a controller.
    Channel(StatusExtension),
    /// Measurement Status of a channel.
    Measurement(u8),
    /// The status in telegram 205 of the TTR compatibility mode.
    Ttr {
        /// The gauge has an error.
        has_error: bool,
    },
    /// The configuration has no status.
    None,
}

/// Why a reading is not valid, beyond its quality.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The alarms in Exception Status.
    Alarms(ExceptionStatus),
    /// The controller reports an error of the channel.
    ChannelError,
    /// The gauge declares its reading invalid and reports no alarm.
    DeclaredInvalid,
    /// The gauge reports an error in telegram 205.
    GaugeError,
    /// The number is the highest integer of its format: the pressure may be any higher one.
    HighestInteger,
    /// The number is the integer 0: the pressure is below one unit.
    BelowOneUnit,
    /// The number is not a pressure.
    NoPressure,
    /// The configuration has no status of the value, and the device reports a warning.
    NoStatus,
    /// The ionisation part has no emission; the Pirani shows the end of its range.
    NoEmission,
    /// The gauge does not measure.
    NotMeasuring,
    /// The controller does not tell a gauge without emission from a channel without gauge.
    OffOrNoGauge,
    /// The controller reports a device alarm; the cyclic data do not tell of which channel.
    AlarmOfController,
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Alarms(exception) => {
                f.write_str(&super::exception_texts(*exception & ExceptionStatus::ALARM).join(", "))
            }
            Self::ChannelError => f.write_str("the controller reports an error of the channel"),
            Self::DeclaredInvalid => f.write_str("the gauge declares its reading invalid"),
            Self::GaugeError => f.write_str("the gauge reports an error"),
            Self::HighestInteger => f.write_str("the number is the highest of its format: the pressure may be higher"),
            Self::BelowOneUnit => f.write_str("the integer is 0, less than one unit"),
            Self::NoPressure => f.write_str("the number is not a pressure"),
            Self::NoStatus => {
                f.write_str("the configuration has no status of the reading, and the device reports a warning")
            }
            Self::NoEmission => f.write_str("no emission, the Pirani shows the end of its range"),
            Self::NotMeasuring => f.write_str("the gauge does not measure"),
            Self::OffOrNoGauge => f.write_str("no emission, or no gauge is connected"),
            Self::AlarmOfController => f.write_str("the controller reports an alarm"),
        }
    }
}

/// The range of a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range {
    low_pa: f64,
    high_pa: f64,
}

impl From<MeasuringRange> for Range {
    fn from(range: MeasuringRange) -> Self {
        Self { low_pa: range.lowest_pa, high_pa: range.highest_pa }
    }
}

impl Range {
    /// Whether the pressure is within, not at an end: an end is shown in place of a value.
    fn contains(&self, pa: f64) -> bool {
        pa > self.low_pa * (1.0 + ROUNDING) && pa < self.high_pa * (1.0 - ROUNDING)
    }
}

/// A number on the wire differs from the pressure by this part at most: COUNTS of the coarsest scale.
const ROUNDING: f64 = 5e-3;

/// All that decides the quality of a value.
#[derive(Clone, Copy, Debug)]
pub(super) struct Evidence {
    /// The status.
    pub status: ValueStatus,
    /// Exception Status of the device.
    pub exception: ExceptionStatus,
    /// The number, in Pa. `None` for one that is no pressure.
    pub held: Option<HeldPressure>,
    /// The range of the active part, if it is known.
    pub range: Option<Range>,
    /// Beyond its range the device shows the end of the range in place of the pressure.
    pub shows_end: bool,
    /// The principle of the active part.
    pub principle: Option<Principle>,
    /// The gauge has an ionisation part beside a Pirani.
    pub has_ion_part: bool,
    /// Another channel of the controller measures.
    pub others_measure: bool,
}

/// The quality of a value with its cause and the end of the range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Verdict {
    pub quality: Quality,
    pub cause: Option<Cause>,
    pub limit_pa: Option<f64>,
}

impl Evidence {
    /// The quality of the value.
    pub fn verdict(&self) -> Verdict {
        let (quality, cause) = match self.status {
            ValueStatus::Gauge(status) | ValueStatus::Channel(status) => self.by_extension(status),
            ValueStatus::Measurement(status) => self.by_measurement(status),
            ValueStatus::Ttr { has_error } => self.by_ttr(has_error),
            ValueStatus::None => self.without_status(),
        };
        Verdict { quality, cause, limit_pa: self.limit_pa(quality, cause) }
    }

    /// The number in Pa. `None` for a pressure below one unit: it has none.
    pub const fn pa(&self) -> Option<f64> {
        match self.held {
            Some(HeldPressure::Exact(pa) | HeldPressure::AtLeast(pa)) => Some(pa),
            Some(HeldPressure::Below(_)) | None => None,
        }
    }

    fn by_extension(&self, status: StatusExtension) -> (Quality, Option<Cause>) {
        let is_invalid = status.contains(StatusExtension::INVALID);
        match (status.contains(StatusExtension::UNDER), status.contains(StatusExtension::OVER)) {
            _ if is_invalid && self.exception.intersects(self.own_alarms()) => {
                (Quality::Fault, Some(Cause::Alarms(self.exception)))
            }
            (true, true) => (Quality::Fault, Some(Cause::DeclaredInvalid)),
            (true, false) => (Quality::Underrange, None),
            (false, true) => (Quality::Overrange, None),
            (false, false) if is_invalid => self.invalid(),
            (false, false) => self.in_range(),
        }
    }

    /// The alarms that concern this reading. A device alarm of a controller may belong to another channel.
    const fn own_alarms(&self) -> ExceptionStatus {
        match self.status {
            ValueStatus::Channel(_) => ExceptionStatus::ALARM_COMMON.union(ExceptionStatus::ALARM_MANUFACTURER),
            ValueStatus::Gauge(_) | ValueStatus::Measurement(_) | ValueStatus::Ttr { .. } | ValueStatus::None => {
                ExceptionStatus::ALARM
            }
        }
    }

    /// Reading Invalid without an alarm of its own and within the range.
    fn invalid(&self) -> (Quality, Option<Cause>) {
        let (quality, cause) = self.invalid_by_value();
        let is_channel = matches!(self.status, ValueStatus::Channel(_));
        let has_alarm = is_channel && self.exception.contains(ExceptionStatus::ALARM_DEVICE);
        (quality, if has_alarm { Some(Cause::AlarmOfController) } else { cause })
    }

    fn invalid_by_value(&self) -> (Quality, Option<Cause>) {
        let pa = self.pa().filter(|pa| is_pressure(*pa));
        let is_within = self.range.zip(pa).is_some_and(|(range, pa)| range.contains(pa));
        let is_at_low_end = self.range.zip(pa).is_some_and(|(range, pa)| pa <= range.low_pa * (1.0 + ROUNDING));
        match (self.status, self.principle) {
            (ValueStatus::Channel(_), Some(Principle::HotCathode)) => (Quality::Off, Some(Cause::OffOrNoGauge)),
            (ValueStatus::Channel(_), _) if self.others_measure => (Quality::Missing, None),
            (ValueStatus::Channel(_), _) => (Quality::Off, Some(Cause::NotMeasuring)),
            (_, Some(Principle::Pirani)) if self.has_ion_part && is_at_low_end => {
                (Quality::Underrange, Some(Cause::NoEmission))
            }
            _ if is_within => (Quality::Fault, Some(Cause::DeclaredInvalid)),
            _ => (Quality::Off, Some(Cause::NotMeasuring)),
        }
    }

    fn by_measurement(&self, status: u8) -> (Quality, Option<Cause>) {
        match status {
            0 => self.in_range(),
            1 => (Quality::Underrange, None),
            2 => (Quality::Overrange, None),
            4 => (Quality::Off, None),
            5 => (Quality::Missing, None),
            _ => (Quality::Fault, Some(Cause::ChannelError)),
        }
    }

    /// Telegram 205 shows an end of the range like any other pressure.
    fn by_ttr(&self, has_error: bool) -> (Quality, Option<Cause>) {
        let (Some(pa), Some(range)) = (self.pa(), self.range) else { return self.in_range() };
        match () {
            () if has_error => (Quality::Fault, Some(Cause::GaugeError)),
            () if range.contains(pa) => (Quality::Valid, None),
            () if pa <= range.low_pa * (1.0 + ROUNDING) => (Quality::Underrange, None),
            () => (Quality::Overrange, None),
        }
    }

    /// Without a status only a device that reports neither alarm nor warning vouches for its values.
    fn without_status(&self) -> (Quality, Option<Cause>) {
        match self.exception {
            alarms if alarms.intersects(ExceptionStatus::ALARM) => (Quality::Fault, Some(Cause::Alarms(alarms))),
            warning if warning.contains(ExceptionStatus::WARNING_DEVICE) => (Quality::Fault, Some(Cause::NoStatus)),
            _ => self.in_range(),
        }
    }

    fn in_range(&self) -> (Quality, Option<Cause>) {
        match self.held {
            Some(HeldPressure::AtLeast(_)) => (Quality::Overrange, Some(Cause::HighestInteger)),
            Some(HeldPressure::Below(_)) => (Quality::Underrange, Some(Cause::BelowOneUnit)),
            Some(HeldPressure::Exact(pa)) if is_pressure(pa) => (Quality::Valid, None),
            Some(HeldPressure::Exact(_)) | None => (Quality::Fault, Some(Cause::NoPressure)),
        }
    }

    /// The bound of a pressure below or above it, in Pa: the end of the integers if the number alone decided; otherwise the end of the
    /// range in the tables or as the device reports it, the number that the device shows, or the end of the integers. `None` if none of
    /// them is known.
    fn limit_pa(&self, quality: Quality, cause: Option<Cause>) -> Option<f64> {
        let of_format = match (quality, self.held) {
            (Quality::Overrange, Some(HeldPressure::AtLeast(pa))) => Some(pa),
            (Quality::Underrange, Some(HeldPressure::Below(pa))) => Some(pa),
            _ => None,
        };
        if matches!(cause, Some(Cause::HighestInteger | Cause::BelowOneUnit)) {
            return of_format;
        }
        let shown = self.pa().filter(|pa| self.shows_end && is_pressure(*pa));
        match quality {
            Quality::Underrange => self.range.map(|range| range.low_pa).or(shown).or(of_format),
            Quality::Overrange => self.range.map(|range| range.high_pa).or(shown).or(of_format),
            _ => None,
        }
    }
}
