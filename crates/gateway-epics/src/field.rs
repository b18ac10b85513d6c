//! The fields of a record, which clients read as `NAME.FIELD`.

use crate::record::{AlarmLimits, Answer, Data, Meta, Put, Record, RecordType, SEVERITY_WORDS, STATUS_WORDS, Sample};
use profivac_gateway::EpicsSeverity;
use std::borrow::Cow;
use std::sync::Arc;

/// The change that archivers keep, as a part of the value: Diamond and NSLS-II set `ADEL` to a twentieth of the pressure.
pub const ARCHIVE_DEADBAND: f64 = 0.05;

const NO_YES: [&str; 2] = ["NO", "YES"];
const SCANS: [&str; 3] = ["Passive", "Event", "I/O Intr"];

macro_rules! fields {
    ($($field:ident $name:literal $text:literal;)+) => {
        /// A field of a record.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Field {
            $(#[doc = $text] $field,)+
            /// A word of an enumeration: `ZRST` to `FFST`, `ZNAM`, `ONAM`.
            Word(u8),
        }

        /// The fields by name, besides the words of enumerations.
        const FIELDS: &[(&str, Field)] = &[$(($name, Field::$field)),+];
    };
}

fields! {
    Value "VAL" "The value.";
    Name "NAME" "The name of the record.";
    Description "DESC" "What it is.";
    Type "RTYP" "The type of the record.";
    DeviceType "DTYP" "What reads the value.";
    Unit "EGU" "The unit.";
    Precision "PREC" "The number of decimals.";
    HighDisplay "HOPR" "The upper end of the range.";
    LowDisplay "LOPR" "The lower end of the range.";
    HighHigh "HIHI" "The limit of the upper alarm MAJOR.";
    High "HIGH" "The limit of the upper alarm MINOR.";
    Low "LOW" "The limit of the lower alarm MINOR.";
    LowLow "LOLO" "The limit of the lower alarm MAJOR.";
    HighHighSeverity "HHSV" "The severity beyond `HIHI`.";
    HighSeverity "HSV" "The severity beyond `HIGH`.";
    LowSeverity "LSV" "The severity below `LOW`.";
    LowLowSeverity "LLSV" "The severity below `LOLO`.";
    Hysteresis "HYST" "The hysteresis of the limits.";
    ArchiveDeadband "ADEL" "The change that archivers get.";
    MonitorDeadband "MDEL" "The change that monitors get.";
    Severity "SEVR" "The severity of the alarm.";
    Status "STAT" "The reason of the alarm.";
    NewSeverity "NSEV" "The severity while the record is processed.";
    NewStatus "NSTA" "The status while the record is processed.";
    UnacknowledgedSeverity "ACKS" "The severity that waits for an acknowledgement in EPICS: none.";
    MustAcknowledge "ACKT" "Transient alarms need an acknowledgement in EPICS: no.";
    SimulationMode "SIMM" "The gauge is virtual.";
    SimulationSeverity "SIMS" "The severity of a virtual gauge.";
    Scan "SCAN" "When the record is processed: when the gauge was read.";
    TimeStampEvent "TSE" "The source of the time: -2, the reading.";
    Undefined "UDF" "The value is undefined.";
    Disabled "DISA" "The record is disabled: no.";
    AccessGroup "ASG" "The access security group.";
    AlarmMessage "AMSG" "The reason of the alarm in words: the state of the reading.";
    UserTag "UTAG" "The user tag of the time: 0.";
    Input "INP" "Where the value comes from: what the point says.";
    ForwardLink "FLNK" "The record that is processed next: none.";
    Process "PROC" "Processes the record when it is written; here it cannot.";
    Active "PACT" "The record is being processed: no.";
    PutDisabled "DISP" "Puts are disabled: where clients only read.";
    LastAlarm "LALM" "The value of the last alarm: the value.";
    LastArchived "ALST" "The value that archivers got last: the value.";
    LastMonitored "MLST" "The value that monitors got last: the value.";
}

const WORDS: [&str; 16] = [
    "ZRST", "ONST", "TWST", "THST", "FRST", "FVST", "SXST", "SVST", "EIST", "NIST", "TEST", "ELST", "TVST", "TTST",
    "FTST", "FFST",
];

impl Field {
    /// The field of this name, if records of this type have it.
    #[must_use]
    pub fn named(name: &str, kind: RecordType) -> Option<Self> {
        let word = || WORDS.iter().position(|word| *word == name).and_then(|index| u8::try_from(index).ok());
        let field = match (kind, name) {
            (RecordType::Bi, "ZNAM") => Some(Self::Word(0)),
            (RecordType::Bi, "ONAM") => Some(Self::Word(1)),
            (RecordType::Mbbi, _) if word().is_some() => word().map(Self::Word),
            _ => FIELDS.iter().find(|(known, _)| *known == name).map(|(_, field)| *field),
        }?;
        field.is_of(kind).then_some(field)
    }

    /// Whether records of this type have the field.
    const fn is_of(self, kind: RecordType) -> bool {
        match self {
            Self::Precision => matches!(kind, RecordType::Ai),
            Self::Unit
            | Self::HighDisplay
            | Self::LowDisplay
            | Self::HighHigh
            | Self::High
            | Self::Low
            | Self::LowLow
            | Self::HighHighSeverity
            | Self::HighSeverity
            | Self::LowSeverity
            | Self::LowLowSeverity
            | Self::Hysteresis => matches!(kind, RecordType::Ai | RecordType::Int64in),
            Self::ArchiveDeadband
            | Self::MonitorDeadband
            | Self::LastAlarm
            | Self::LastArchived
            | Self::LastMonitored => matches!(kind, RecordType::Ai | RecordType::Int64in),
            _ => true,
        }
    }

    /// Whether its value is a text.
    #[must_use]
    pub const fn is_text(self, kind: RecordType) -> bool {
        match self {
            Self::Value => matches!(kind, RecordType::Stringin),
            Self::Name
            | Self::Description
            | Self::Type
            | Self::DeviceType
            | Self::Unit
            | Self::AccessGroup
            | Self::AlarmMessage
            | Self::Input
            | Self::ForwardLink
            | Self::Word(_) => true,
            _ => false,
        }
    }

    /// Whether its value depends on the sample, not on the record alone.
    #[must_use]
    pub const fn changes(self) -> bool {
        matches!(
            self,
            Self::Value
                | Self::Severity
                | Self::Status
                | Self::AlarmMessage
                | Self::Undefined
                | Self::ArchiveDeadband
                | Self::LastAlarm
                | Self::LastArchived
                | Self::LastMonitored
        )
    }
}

fn severity_of_limit(limit: f64, severity: EpicsSeverity) -> u16 {
    if limit.is_nan() { 0 } else { severity as u16 }
}

/// The value of a field. It has the alarm and the time of the record, as in EPICS.
#[must_use]
pub fn read(field: Field, record: &Record, sample: Sample) -> Answer<'static> {
    let (data, states) = data(field, record, &sample);
    let meta = Meta {
        description: record.meta.description.clone(),
        unit: record.meta.unit.clone(),
        precision: record.meta.precision,
        is_exponential: record.meta.is_exponential,
        display: record.meta.display,
        limits: AlarmLimits::NONE,
        states,
    };
    Answer { sample: Sample { data, ..sample }, meta: Cow::Owned(meta) }
}

fn data(field: Field, record: &Record, sample: &Sample) -> (Data, &'static [&'static str]) {
    let meta = &record.meta;
    let text = |text: &str| (Data::Text(Arc::from(text)), [].as_slice());
    let number = |number: f64| (Data::Double(number), [].as_slice());
    let long = |number: i64| (Data::Long(number), [].as_slice());
    let severity = |number: u16| (Data::Enum(number), SEVERITY_WORDS.as_slice());
    let limits = meta.limits;
    match field {
        Field::Value => (sample.data.clone(), meta.states),
        Field::Name => text(&record.name),
        Field::Description => text(&meta.description),
        Field::Type => text(record.kind.name()),
        Field::DeviceType => text("profivac"),
        Field::Unit => text(&meta.unit),
        Field::AccessGroup => text(if record.put == Put::Refused { "READONLY" } else { "WRITABLE" }),
        Field::AlarmMessage => text(sample.message),
        Field::ForwardLink => text(""),
        Field::Input => text(&record.about),
        Field::PutDisabled => long(i64::from(record.put == Put::Refused)),
        Field::UserTag | Field::Process | Field::Active => long(0),
        Field::LastAlarm | Field::LastArchived | Field::LastMonitored => (sample.data.clone(), [].as_slice()),
        Field::Precision => long(meta.precision.into()),
        Field::HighDisplay => number(meta.display.1),
        Field::LowDisplay => number(meta.display.0),
        Field::HighHigh => number(limits.high_high),
        Field::High => number(limits.high),
        Field::Low => number(limits.low),
        Field::LowLow => number(limits.low_low),
        Field::HighHighSeverity => severity(severity_of_limit(limits.high_high, EpicsSeverity::Major)),
        Field::HighSeverity => severity(severity_of_limit(limits.high, EpicsSeverity::Minor)),
        Field::LowSeverity => severity(severity_of_limit(limits.low, EpicsSeverity::Minor)),
        Field::LowLowSeverity => severity(severity_of_limit(limits.low_low, EpicsSeverity::Major)),
        Field::Hysteresis | Field::MonitorDeadband => number(0.0),
        Field::ArchiveDeadband => number(match sample.data {
            Data::Double(value) if record.is_pressure && value.is_finite() => value * ARCHIVE_DEADBAND,
            _ => 0.0,
        }),
        Field::Severity | Field::NewSeverity => severity(sample.severity as u16),
        Field::Status | Field::NewStatus => (Data::Enum(sample.status as u16), STATUS_WORDS.as_slice()),
        Field::UnacknowledgedSeverity | Field::SimulationSeverity => severity(0),
        Field::MustAcknowledge => (Data::Enum(0), NO_YES.as_slice()),
        Field::SimulationMode => (Data::Enum(u16::from(record.is_simulated)), NO_YES.as_slice()),
        Field::Scan => (Data::Enum(2), SCANS.as_slice()),
        Field::TimeStampEvent => long(-2),
        Field::Undefined => long(i64::from(matches!(sample.data, Data::Double(value) if value.is_nan()))),
        Field::Disabled => long(0),
        Field::Word(index) => text(meta.states.get(usize::from(index)).copied().unwrap_or_default()),
    }
}
