//! What a point says about its subject.

use crate::state::State;
use profivac_devices::reading::Quality;
use profivac_listen::station::StationState;
use profivac_model::{AlarmState, Priority};
use profivac_station::view::{BusStationState, SegmentState};

/// The kind of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A floating-point number.
    Float,
    /// A whole number.
    Integer,
    /// True or false.
    Boolean,
    /// A text.
    Text,
    /// One of these words, by its position.
    Choice(&'static [&'static str]),
    /// A time.
    Time,
}

/// What a subject is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SubjectKind {
    /// The station.
    Station,
    /// A segment.
    Segment,
    /// A gauge or controller.
    Gauge,
    /// A reading of a gauge, or a channel of a controller.
    Reading,
    /// A parameter of a gauge: emission, degas, trip point, relay.
    Parameter,
    /// An alarm.
    Alarm,
}

/// The words of a choice in the order in which gateways number them, a module with the number of each, and the number of each value of the
/// type that the choice shows.
macro_rules! choice {
    ($text:literal $words:ident $positions:ident $shown:ty { $($position:ident $word:expr, $($value:ident)*;)+ }) => {
        #[doc = $text]
        pub const $words: [&str; [$($word),+].len()] = [$($word),+];

        #[doc = concat!("The positions of the words in [`", stringify!($words), "`].")]
        pub mod $positions {
            #[allow(non_camel_case_types, clippy::upper_case_acronyms, reason = "the names of the constants")]
            enum Position { $($position),+ }
            $(
                #[doc = concat!("The position of `", stringify!($position), "`.")]
                pub const $position: u16 = Position::$position as u16;
            )+

            /// The position of a value.
            #[must_use]
            pub const fn of(value: $shown) -> u16 {
                type Shown = $shown;
                match value { $($(Shown::$value => $position,)*)+ }
            }
        }
    };
}

choice! {
    "The words of a gauge's state on the bus."
    GAUGE_STATES gauge_state super::BusStationState {
        DATA_EXCHANGE "data exchange", DataExchange;
        FAULT "fault", Fault;
        STARTING "starting", Starting;
        MISSING "missing", Missing OwnMaster OtherMaster Unconfigured;
    }
}

choice! {
    "The words of the quality of a reading."
    QUALITIES quality super::Quality {
        VALID Quality::Valid.word(), Valid;
        OVERRANGE Quality::Overrange.word(), Overrange;
        UNDERRANGE Quality::Underrange.word(), Underrange;
        FAULT Quality::Fault.word(), Fault;
        STALE Quality::Stale.word(), Stale;
        OFF Quality::Off.word(), Off;
        MISSING Quality::Missing.word(), Missing;
        ASSUMED Quality::Assumed.word(), Assumed;
    }
}

choice! {
    "The words of a station's state on the line, as the traffic shows it."
    LINE_STATES line_state super::StationState {
        MASTER StationState::Master.text(), Master;
        EXCHANGING StationState::Exchanging.text(), Exchanging;
        MISSING StationState::Missing.text(), Missing;
        NOT_CONFIGURED StationState::NotConfigured.text(), NotConfigured;
        NO_MASTER StationState::NoMaster.text(), NoMaster;
        NOT_ADDRESSED StationState::NotAddressed.text(), NotAddressed;
    }
}

choice! {
    "The words of a segment's state."
    SEGMENT_STATES segment_state super::SegmentState {
        WAITING SegmentState::Waiting.word(), Waiting;
        LISTENING SegmentState::Listening.word(), Listening;
        RUNNING SegmentState::Running.word(), Running;
    }
}

choice! {
    "The words of an alarm's state."
    ALARM_STATES alarm_state super::AlarmState {
        NORMAL AlarmState::Normal.word(), Normal;
        UNACKNOWLEDGED AlarmState::Unacknowledged.word(), Unacknowledged;
        ACKNOWLEDGED AlarmState::Acknowledged.word(), Acknowledged;
        RETURNED AlarmState::Returned.word(), Returned;
        OUT_OF_SERVICE "out of service", OutOfService;
        SHELVED AlarmState::Shelved.word(), Shelved;
        SUPPRESSED AlarmState::Suppressed.word(), Suppressed;
    }
}

choice! {
    "The words of a priority; `none` where no alarm is active."
    PRIORITIES priority super::Priority {
        NONE "none",;
        LOW Priority::Low.word(), Low;
        MEDIUM Priority::Medium.word(), Medium;
        HIGH Priority::High.word(), High;
    }
}

macro_rules! signals {
    ($($signal:ident $key:literal $subject:ident $kind:expr, $unit:expr, $text:literal;)+) => {
        /// What a point says about its subject.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Signal {
            $(#[doc = $text] $signal,)+
        }

        impl Signal {
            /// All signals.
            pub const ALL: &'static [Self] = &[$(Self::$signal),+];

            /// Its name, unique for its subject; gateways form theirs from it.
            #[must_use]
            pub const fn key(self) -> &'static str {
                match self { $(Self::$signal => $key,)+ }
            }

            /// What it belongs to.
            #[must_use]
            pub const fn subject(self) -> SubjectKind {
                match self { $(Self::$signal => SubjectKind::$subject,)+ }
            }

            /// The kind of its value.
            #[must_use]
            pub const fn kind(self) -> Kind {
                match self { $(Self::$signal => $kind,)+ }
            }

            /// The unit of its value.
            #[must_use]
            pub const fn unit(self) -> Option<&'static str> {
                match self { $(Self::$signal => $unit,)+ }
            }

            /// A description.
            #[must_use]
            pub const fn description(self) -> &'static str {
                match self { $(Self::$signal => $text,)+ }
            }
        }
    };
}

signals! {
    // signal           key                     subject  kind                        unit         description
    Pressure            "pressure"              Reading Kind::Float,                 Some("Pa"),  "Indicated pressure; the end of the range while it is over or under range";
    PressureLog10       "pressure-log10"        Reading Kind::Float,                 None,        "Decimal logarithm of the indicated pressure in Pa";
    CorrectedPressure   "corrected-pressure"    Reading Kind::Float,                 Some("Pa"),  "Pressure, corrected for the gas";
    State               "state"                 Reading Kind::Choice(State::READING_LABELS), None,       "State of the reading";
    StateText           "state-text"            Reading Kind::Text,                  None,        "Pressure or state in words, with the cause";
    Usable              "usable"                Reading Kind::Boolean,               None,        "The pressure is measured";
    LastReading         "last-reading"          Reading Kind::Time,                  None,        "Time of the last reading";
    Quality             "quality"               Reading Kind::Choice(&QUALITIES),    None,        "Quality of the reading";
    Cause               "cause"                 Reading Kind::Text,                  None,        "Cause of the quality; for an assumed one what the pressure would be";
    GaugeState          "gauge-state"           Gauge   Kind::Choice(&GAUGE_STATES), None,        "State of the gauge on the bus";
    Problem             "problem"               Gauge   Kind::Text,                  None,        "Why the gauge is not in data exchange";
    Faults              "faults"                Gauge   Kind::Text,                  None,        "Defects that the gauge reports";
    Warnings            "warnings"              Gauge   Kind::Text,                  None,        "Warnings that the gauge reports";
    Assumptions         "assumptions"           Gauge   Kind::Text,                  None,        "What the readings of a gauge of another master depend on and no telegram has shown";
    Device              "device"                Gauge   Kind::Text,                  None,        "Device model";
    Address             "address"               Gauge   Kind::Integer,               None,        "Bus address";
    Gas                 "gas"                   Gauge   Kind::Text,                  None,        "Gas of the corrected pressure";
    Group               "group"                 Gauge   Kind::Text,                  None,        "Group of the gauge";
    Tags                "tags"                  Gauge   Kind::Text,                  None,        "Tags of the gauge";
    Location            "location"              Gauge   Kind::Text,                  None,        "Place where the gauge is mounted";
    Calibrated          "calibrated"            Gauge   Kind::Text,                  None,        "Day of the last calibration, as 2026-05-01";
    CalibrationDue      "calibration-due"       Gauge   Kind::Text,                  None,        "Last day on which the calibration is valid";
    Simulated           "simulated"             Gauge   Kind::Boolean,               None,        "The gauge is virtual";
    ListenOnly          "listen-only"           Gauge   Kind::Boolean,               None,        "Another master owns the gauge, and the station only listens";
    AlarmPriority       "alarm-priority"        Gauge   Kind::Choice(&PRIORITIES),   None,        "Highest priority of the active alarms of the gauge";
    Unacknowledged      "unacknowledged"        Gauge   Kind::Boolean,               None,        "An alarm of the gauge waits for an acknowledgement";
    Requests            "requests"              Gauge   Kind::Integer,               None,        "Requests to the gauge on the line";
    Repetitions         "repetitions"           Gauge   Kind::Integer,               None,        "Repeated requests to the gauge";
    LostCycles          "lost-cycles"           Gauge   Kind::Integer,               None,        "Message cycles with the gauge that had no answer";
    DamagedAnswers      "damaged-answers"       Gauge   Kind::Integer,               None,        "Damaged telegrams of message cycles with the gauge";
    Refusals            "refusals"              Gauge   Kind::Integer,               None,        "Answers of the gauge that refuse a request";
    LongestSequence     "longest-sequence"      Gauge   Kind::Integer,               None,        "Longest sequence of repetitions of one request to the gauge";
    LineState           "line-state"            Gauge   Kind::Choice(&LINE_STATES),  None,        "State of the gauge as the traffic on the line shows it";
    LineUnit            "line-unit"             Gauge   Kind::Text,                  None,        "Unit of the pressures on the line; empty where it is assumed";
    Owner               "owner"                 Gauge   Kind::Integer,               None,        "Address of the master that owns the gauge, if a diagnosis showed it";
    Diagnosis           "diagnosis"             Gauge   Kind::Text,                  None,        "What the last diagnosis on the line reports";
    ParameterPressure   "parameter-pressure"    Parameter Kind::Float,               Some("Pa"),  "Value of a parameter that is a pressure";
    ParameterPercentage "parameter-percentage"  Parameter Kind::Float,               Some("%"),   "Value of a parameter that is a percentage";
    ParameterNumber     "parameter-number"      Parameter Kind::Float,               None,        "Value of another parameter: a number or a code";
    ParameterText       "parameter-text"        Parameter Kind::Text,                None,        "Value of the parameter in the words of the manual";
    SegmentState        "segment-state"         Segment Kind::Choice(&SEGMENT_STATES), None,      "State of the segment";
    SegmentUp           "segment-up"            Segment Kind::Boolean,               None,        "The segment runs";
    SegmentProblem      "segment-problem"       Segment Kind::Text,                  None,        "Why the segment does not run";
    CycleTime           "cycle-time"            Segment Kind::Float,                 Some("s"),   "Duration of a cycle";
    TokenRotation       "token-rotation"        Segment Kind::Float,                 Some("s"),   "Mean time between two tokens to the same master";
    Telegrams           "telegrams"             Segment Kind::Integer,               None,        "Valid telegrams on the line";
    DamagedTelegrams    "damaged-telegrams"     Segment Kind::Integer,               None,        "Damaged telegrams on the line";
    SegmentRepetitions  "segment-repetitions"   Segment Kind::Integer,               None,        "Repeated requests on the line";
    SegmentLostCycles   "segment-lost-cycles"   Segment Kind::Integer,               None,        "Message cycles on the line that had no answer";
    LongestCycle        "longest-cycle"         Segment Kind::Float,                 Some("s"),   "Longest cycle on the line";
    LongestRotation     "longest-rotation"      Segment Kind::Float,                 Some("s"),   "Longest time between two tokens to the same master";
    DamagedLastMinute   "damaged-last-minute"   Segment Kind::Integer,               None,        "Damaged telegrams on the line in the last minute";
    ObservedTime        "observed-time"         Segment Kind::Integer,               Some("s"),   "Seconds of the line that were observed";
    TokenRing           "token-ring"            Segment Kind::Text,                  None,        "Addresses of the masters in the order of the token";
    SegmentListenOnly   "segment-listen-only"   Segment Kind::Boolean,               None,        "The station only listens on the segment";
    Baud                "baud"                  Segment Kind::Integer,               Some("bit/s"), "Baud rate";
    Master              "master"                Segment Kind::Integer,               None,        "Address of the master of this station; none if it only listens";
    Heartbeat           "heartbeat"             Station Kind::Integer,               Some("s"),   "Seconds since the station started";
    Version             "version"               Station Kind::Text,                  None,        "Version of the program";
    Started             "started"               Station Kind::Time,                  None,        "Time of the start";
    Recording           "recording"             Station Kind::Boolean,               None,        "The recorder writes";
    LostSamples         "lost-samples"          Station Kind::Integer,               None,        "Samples that the recorder has dropped";
    LostEvents          "lost-events"           Station Kind::Integer,               None,        "Events that the recorder has dropped";
    LastWrite           "last-write"            Station Kind::Time,                  None,        "Time of the last write of the recorder";
    RecorderProblem     "recorder-problem"      Station Kind::Text,                  None,        "Why the recorder does not write";
    ActiveAlarms        "active-alarms"         Station Kind::Integer,               None,        "Active alarms";
    UnacknowledgedAlarms "unacknowledged-alarms" Station Kind::Integer,              None,        "Alarms that wait for an acknowledgement";
    SegmentsDown        "segments-down"         Station Kind::Integer,               None,        "Segments that do not run";
    AlarmState          "alarm-state"           Alarm   Kind::Choice(&ALARM_STATES), None,        "State of the alarm";
    AlarmActive         "alarm-active"          Alarm   Kind::Boolean,               None,        "The condition of the alarm is met";
    AlarmAcknowledged   "alarm-acknowledged"    Alarm   Kind::Boolean,               None,        "The alarm needs no acknowledgement";
    Priority            "priority"              Alarm   Kind::Choice(&PRIORITIES),   None,        "Priority of the alarm";
    Occurrence          "occurrence"            Alarm   Kind::Integer,               None,        "Number of the last occurrence";
    AlarmText           "alarm-text"            Alarm   Kind::Text,                  None,        "Why the alarm was raised";
    AlarmValue          "alarm-value"           Alarm   Kind::Float,                 None,        "Present value that the alarm watches, in the unit of its limit";
    AlarmLimit          "alarm-limit"           Alarm   Kind::Float,                 None,        "Limit of the alarm";
    AlarmUnit           "alarm-unit"            Alarm   Kind::Text,                  None,        "Unit of value and limit of the alarm";
    AcknowledgedBy      "acknowledged-by"       Alarm   Kind::Text,                  None,        "User who has acknowledged the alarm";
    AcknowledgedAt      "acknowledged-at"       Alarm   Kind::Time,                  None,        "Time of the acknowledgement";
    Raised              "raised"                Alarm   Kind::Time,                  None,        "Time when the alarm was raised last";
    RaisedValue         "raised-value"          Alarm   Kind::Float,                 None,        "Value that raised the alarm, in the unit of its limit";
    OutOfService        "out-of-service"        Alarm   Kind::Text,                  None,        "Why the alarm is shelved, out of service or suppressed; empty otherwise";
    SuppressedBy        "suppressed-by"         Alarm   Kind::Text,                  None,        "User who has shelved the alarm, taken it out of service or declared the plant state that suppresses it";
    SuppressedUntil     "suppressed-until"      Alarm   Kind::Time,                  None,        "When the alarm is unshelved, returns to service or is no longer suppressed by itself";
    Instruction         "instruction"           Alarm   Kind::Text,                  None,        "Instruction for the operator";
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn the_key_of_a_signal_is_unique() {
        let keys: BTreeSet<_> = Signal::ALL.iter().map(|signal| signal.key()).collect();
        assert_eq!(keys.len(), Signal::ALL.len());
    }

    #[test]
    fn a_position_is_that_of_its_word() {
        assert_eq!(GAUGE_STATES[usize::from(gauge_state::STARTING)], "starting");
        assert_eq!(LINE_STATES[usize::from(line_state::NOT_ADDRESSED)], "not addressed");
        assert_eq!(SEGMENT_STATES[usize::from(segment_state::RUNNING)], "running");
        assert_eq!(ALARM_STATES[usize::from(alarm_state::SHELVED)], "shelved");
        assert_eq!(ALARM_STATES[usize::from(alarm_state::SUPPRESSED)], "suppressed");
        assert_eq!(PRIORITIES[usize::from(priority::HIGH)], "high");
    }

    /// Clients of Modbus, EPICS and OPC UA know the numbers.
    #[test]
    fn the_numbers_of_the_choices_do_not_change() {
        assert_eq!(GAUGE_STATES, ["data exchange", "fault", "starting", "missing"]);
        assert_eq!(QUALITIES, Quality::ALL.map(Quality::word));
        assert!(Quality::ALL.iter().all(|it| quality::of(*it) == *it as u16));
        let of_the_line =
            ["master", "exchanging", "missing", "not configured", "present without a master", "not addressed"];
        assert_eq!(LINE_STATES, of_the_line);
        assert_eq!(SEGMENT_STATES, ["waiting", "listening", "running"]);
        let of_alarms =
            ["normal", "unacknowledged", "acknowledged", "returned", "out of service", "shelved", "suppressed"];
        assert_eq!(ALARM_STATES, of_alarms);
        assert_eq!(PRIORITIES, ["none", "low", "medium", "high"]);
    }

    #[test]
    fn every_word_of_a_choice_fits_into_an_enumeration_of_epics() {
        for signal in Signal::ALL {
            if let Kind::Choice(words) = signal.kind() {
                assert!(words.len() <= 16 && words.iter().all(|word| word.len() <= 25), "{signal:?}");
            }
        }
    }
}
