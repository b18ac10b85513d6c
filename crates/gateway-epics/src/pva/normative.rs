//! `NTScalar`, `NTEnum` and `NTTable`: descriptions of their types, and their values.
//!
//! A value is always complete in its parts: the whole structure first, then value, alarm and time of what has changed.

use crate::database::World;
use crate::pva::wire::Writer;
use crate::record::{Answer, DECIMALS, Data, Meta, RecordType, STATUS_WORDS, Sample};
use profivac_gateway::{EpicsSeverity, EpicsStatus, Signal, Subject};
use profivac_recorder::Micros;

/// Codes of types (pvData, "introspection data").
mod code {
    pub const BOOLEAN: u8 = 0x00;
    pub const BYTE: u8 = 0x20;
    pub const INT: u8 = 0x22;
    pub const LONG: u8 = 0x23;
    pub const DOUBLE: u8 = 0x43;
    pub const STRING: u8 = 0x60;
    pub const ARRAY: u8 = 0x08;
    pub const STRUCTURE: u8 = 0x80;
}

/// The type of what a channel reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// `NTScalar` of a floating-point number.
    Double,
    /// `NTScalar` of a whole number.
    Long,
    /// `NTScalar` of a text.
    Text,
    /// `NTEnum`.
    Enum,
    /// `NTTable` of all gauges.
    Table,
}

impl Shape {
    /// The shape of a value.
    #[must_use]
    pub const fn of(data: &Data) -> Self {
        match data {
            Data::Double(_) => Self::Double,
            Data::Long(_) => Self::Long,
            Data::Text(_) => Self::Text,
            Data::Enum(_) => Self::Enum,
        }
    }

    /// The numbers of the fields value, alarm and time in the whole structure: every field counts, in depth.
    #[must_use]
    pub const fn changing_fields(self) -> [u8; 3] {
        match self {
            // value 1, alarm 2 with three fields, time 6.
            Self::Double | Self::Long | Self::Text => [1, 2, 6],
            // value 1 with index and choices, alarm 4, time 8.
            Self::Enum => [2, 4, 8],
            // labels 1, value 2 with its columns, alarm, time.
            Self::Table => [2, 2 + COLUMNS + 1, 2 + COLUMNS + 5],
        }
    }
}

/// The columns of the table of all gauges.
const COLUMNS: u8 = 7;
const LABELS: [&str; COLUMNS as usize] = ["gauge", "pressure", "unit", "state", "severity", "simulated", "time"];
const COLUMN_TYPES: [u8; COLUMNS as usize] =
    [code::STRING, code::DOUBLE, code::STRING, code::STRING, code::INT, code::BOOLEAN, code::STRING];

fn structure(out: &mut Writer, id: &str, fields: usize) {
    out.octet(code::STRUCTURE);
    out.text(id);
    out.size(fields);
}

fn named(out: &mut Writer, name: &str, code: u8) {
    out.text(name);
    out.octet(code);
}

/// Describes the type of a channel.
pub fn describe(out: &mut Writer, shape: Shape) {
    match shape {
        Shape::Double => describe_number(out, code::DOUBLE),
        Shape::Long => describe_number(out, code::LONG),
        Shape::Text => {
            structure(out, "epics:nt/NTScalar:1.0", 4);
            named(out, "value", code::STRING);
            describe_alarm_and_time(out);
            out.text("display");
            describe_short_display(out);
        }
        Shape::Enum => {
            structure(out, "epics:nt/NTEnum:1.0", 4);
            out.text("value");
            describe_choices(out);
            describe_alarm_and_time(out);
            out.text("display");
            structure(out, "", 1);
            named(out, "description", code::STRING);
        }
        Shape::Table => {
            structure(out, "epics:nt/NTTable:1.0", 4);
            named(out, "labels", code::STRING | code::ARRAY);
            out.text("value");
            structure(out, "", LABELS.len());
            for (label, code) in LABELS.iter().zip(COLUMN_TYPES) {
                named(out, label, code | code::ARRAY);
            }
            describe_alarm_and_time(out);
        }
    }
}

fn describe_choices(out: &mut Writer) {
    structure(out, "enum_t", 2);
    named(out, "index", code::INT);
    named(out, "choices", code::STRING | code::ARRAY);
}

fn describe_alarm_and_time(out: &mut Writer) {
    out.text("alarm");
    structure(out, "alarm_t", 3);
    named(out, "severity", code::INT);
    named(out, "status", code::INT);
    named(out, "message", code::STRING);
    out.text("timeStamp");
    structure(out, "time_t", 3);
    named(out, "secondsPastEpoch", code::LONG);
    named(out, "nanoseconds", code::INT);
    named(out, "userTag", code::INT);
}

fn describe_short_display(out: &mut Writer) {
    structure(out, "", 2);
    named(out, "description", code::STRING);
    named(out, "units", code::STRING);
}

fn describe_number(out: &mut Writer, value: u8) {
    structure(out, "epics:nt/NTScalar:1.0", 6);
    named(out, "value", value);
    describe_alarm_and_time(out);
    out.text("display");
    structure(out, "", 6);
    named(out, "limitLow", code::DOUBLE);
    named(out, "limitHigh", code::DOUBLE);
    named(out, "description", code::STRING);
    named(out, "units", code::STRING);
    named(out, "precision", code::INT);
    out.text("form");
    describe_choices(out);
    out.text("control");
    structure(out, "control_t", 3);
    for name in ["limitLow", "limitHigh", "minStep"] {
        named(out, name, code::DOUBLE);
    }
    out.text("valueAlarm");
    structure(out, "valueAlarm_t", 10);
    named(out, "active", code::BOOLEAN);
    for name in ["lowAlarmLimit", "lowWarningLimit", "highWarningLimit", "highAlarmLimit"] {
        named(out, name, code::DOUBLE);
    }
    for name in ["lowAlarmSeverity", "lowWarningSeverity", "highWarningSeverity", "highAlarmSeverity"] {
        named(out, name, code::INT);
    }
    named(out, "hysteresis", code::BYTE);
}

/// Writes the complete value of a channel.
pub fn put_whole(out: &mut Writer, answer: &Answer) {
    let (sample, meta) = (&answer.sample, &*answer.meta);
    match &sample.data {
        Data::Enum(index) => {
            out.int((*index).into());
            texts(out, meta.states);
            put_alarm_and_time(out, sample);
            out.text(&meta.description);
        }
        Data::Text(_) => {
            put_changing(out, answer);
            out.text(&meta.description);
            out.text(&meta.unit);
        }
        Data::Double(_) | Data::Long(_) => {
            put_changing(out, answer);
            put_number_meta(out, meta);
        }
    }
}

/// Writes value, alarm and time.
pub fn put_changing(out: &mut Writer, answer: &Answer) {
    match &answer.sample.data {
        Data::Double(number) => out.double(*number),
        Data::Long(number) => out.long(*number),
        Data::Enum(index) => out.int((*index).into()),
        Data::Text(text) => out.text(text),
    }
    put_alarm_and_time(out, &answer.sample);
}

fn texts(out: &mut Writer, texts: &[&str]) {
    out.size(texts.len());
    texts.iter().for_each(|text| out.text(text));
}

/// The forms in which a client may show a number (display_t of the Normative Types).
const FORMS: [&str; 7] = ["Default", "String", "Binary", "Decimal", "Hex", "Exponential", "Engineering"];
const EXPONENTIAL: i32 = 5;

fn put_number_meta(out: &mut Writer, meta: &Meta) {
    let (low, high) = meta.display;
    out.double(low);
    out.double(high);
    out.text(&meta.description);
    out.text(&meta.unit);
    // A client that shows an exponent takes the precision for the decimals before it.
    out.int(if meta.is_exponential { DECIMALS.into() } else { meta.precision.into() });
    out.int(if meta.is_exponential { EXPONENTIAL } else { 0 });
    texts(out, &FORMS);
    // control: the same range, and no smallest step.
    [low, high, 0.0].into_iter().for_each(|number| out.double(number));
    let limits = meta.limits;
    let rows = [
        (limits.low_low, EpicsSeverity::Major),
        (limits.low, EpicsSeverity::Minor),
        (limits.high, EpicsSeverity::Minor),
        (limits.high_high, EpicsSeverity::Major),
    ];
    out.octet(u8::from(rows.iter().any(|(limit, _)| !limit.is_nan())));
    rows.iter().for_each(|(limit, _)| out.double(*limit));
    rows.iter().for_each(|(limit, severity)| out.int(if limit.is_nan() { 0 } else { *severity as i32 }));
    out.octet(0);
}

/// The group of a status in `alarm_t`: 0 none, 1 device, 2 driver, 3 record, 4 database, 6 undefined.
const fn status_group(status: EpicsStatus) -> i32 {
    match status {
        EpicsStatus::None => 0,
        EpicsStatus::HiHi
        | EpicsStatus::High
        | EpicsStatus::LoLo
        | EpicsStatus::Low
        | EpicsStatus::State
        | EpicsStatus::HwLimit => 1,
        EpicsStatus::Read | EpicsStatus::Comm | EpicsStatus::Timeout | EpicsStatus::Scan => 2,
        EpicsStatus::Disable | EpicsStatus::Simulated => 3,
        EpicsStatus::Undefined => 6,
    }
}

/// An alarm has one text: as in EPICS base the words of the reason, or the word of the status where there are none.
fn put_alarm(out: &mut Writer, severity: EpicsSeverity, status: EpicsStatus, message: &str) {
    out.int(severity as i32);
    out.int(status_group(status));
    out.text(match status {
        _ if !message.is_empty() => message,
        EpicsStatus::None => "",
        other => STATUS_WORDS.get(other as usize).copied().unwrap_or_default(),
    });
}

fn put_time(out: &mut Writer, Micros(micros): Micros) {
    out.long(micros.div_euclid(Micros::SECOND));
    out.int(i32::try_from(micros.rem_euclid(Micros::SECOND).saturating_mul(1000)).unwrap_or_default());
    out.int(0);
}

fn put_alarm_and_time(out: &mut Writer, sample: &Sample) {
    put_alarm(out, sample.severity, sample.status, sample.message);
    put_time(out, sample.at);
}

/// A row of the table of all gauges.
struct TableRow<'a> {
    gauge: &'a str,
    pressure: f64,
    unit: &'a str,
    state: &'a str,
    severity: EpicsSeverity,
    is_simulated: bool,
    at: Micros,
}

fn table_rows(world: &World) -> Vec<TableRow<'_>> {
    let snapshot = &world.snapshot;
    let own = world.database.records.iter().take(world.database.of_points);
    let pressures = own.filter(|record| record.signal == Signal::Pressure && record.kind == RecordType::Ai);
    let row = |record| {
        let sample = world.sample(record)?;
        let point = snapshot.points.get(record.point)?;
        let Subject::Reading { series, .. } = &point.subject else { return None };
        let Data::Double(pressure) = sample.data else { return None };
        Some(TableRow {
            gauge: series,
            pressure,
            unit: &record.meta.unit,
            state: snapshot.values.get(record.point).map_or("", |value| value.state.label()),
            severity: sample.severity,
            is_simulated: record.is_simulated,
            at: sample.at,
        })
    };
    pressures.filter_map(row).collect()
}

/// How often the pressures of the table have changed.
#[must_use]
pub fn table_version(world: &World) -> u64 {
    let pressures = world.snapshot.iter().filter(|(point, _)| point.signal == Signal::Pressure);
    pressures.map(|(_, value)| value.version).fold(0, u64::wrapping_add)
}

/// Writes the table of all gauges: complete, or without its labels.
pub fn put_table(out: &mut Writer, world: &World, is_whole: bool) {
    let rows = table_rows(world);
    if is_whole {
        texts(out, &LABELS);
    }
    let column = |out: &mut Writer, put: &dyn Fn(&mut Writer, &TableRow)| {
        out.size(rows.len());
        rows.iter().for_each(|row| put(out, row));
    };
    column(out, &|out, row| out.text(row.gauge));
    column(out, &|out, row| out.double(row.pressure));
    column(out, &|out, row| out.text(row.unit));
    column(out, &|out, row| out.text(row.state));
    column(out, &|out, row| out.int(row.severity as i32));
    column(out, &|out, row| out.octet(u8::from(row.is_simulated)));
    column(out, &|out, row| out.text(&row.at.to_iso(3)));
    let worst = rows.iter().map(|row| row.severity).max().unwrap_or(EpicsSeverity::None);
    put_alarm(out, worst, if worst == EpicsSeverity::None { EpicsStatus::None } else { EpicsStatus::State }, "");
    put_time(out, rows.iter().map(|row| row.at).max().unwrap_or(Micros(0)));
}
