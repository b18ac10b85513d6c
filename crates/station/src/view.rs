//! What can be seen of the station, as the API and the dashboard have it.
//!
//! Pressures are in Pa. Whatever shows them in another unit, or corrected for a gas, does so for the eye alone.

use crate::auth::Role;
use profivac_recorder::{Event, Micros, Qualities, Quality};
use serde::Serialize;
use std::time::Duration;
use utoipa::ToSchema;

/// The station as a whole.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Station {
    /// Its name.
    pub name: String,
    /// The version of the program.
    pub version: &'static str,
    /// When it began, in milliseconds since 1970.
    pub started_ms: i64,
    /// What its clock shows, in milliseconds since 1970.
    pub now_ms: i64,
    /// Whether the recorder writes.
    pub recorder: RecorderView,
}

/// The recorder.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct RecorderView {
    /// When it wrote last, in milliseconds since 1970.
    pub last_write_ms: Option<i64>,
    /// Why it does not, if it does not.
    pub error: Option<String>,
    /// Samples it could not keep.
    pub lost_samples: u64,
    /// Events it could not keep.
    pub lost_events: u64,
}

/// Where a segment stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SegmentState {
    /// Its port is being opened, or waited for.
    Waiting,
    /// Its master listens before it takes the line.
    Listening,
    /// Its master has the token, alone or in turn.
    Running,
}

/// A segment and everybody on it.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Segment {
    /// Its name.
    pub name: String,
    /// Its port.
    pub port: String,
    /// Bits per second.
    pub baud: u32,
    /// The address of our master.
    pub master: u8,
    /// Where it stands.
    pub state: SegmentState,
    /// Why it does not run, in a sentence.
    pub problem: Option<String>,
    /// How long a cycle takes, in milliseconds.
    pub cycle_ms: Option<f64>,
    /// Telegrams that arrived damaged since it runs.
    pub damaged_telegrams: u32,
    /// Who is on it.
    pub stations: Vec<BusStation>,
}

/// What a station of a segment is to us.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum BusStationState {
    /// Our master.
    OwnMaster,
    /// Another master.
    OtherMaster,
    /// A slave of ours that exchanges data.
    DataExchange,
    /// A slave of ours that reports a fault.
    Fault,
    /// A slave of ours that is being brought into data exchange.
    Starting,
    /// A slave of ours that does not answer, or belongs to another master.
    Missing,
    /// A slave that is not ours.
    Unconfigured,
}

/// A station on a segment.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct BusStation {
    /// Its address, 0 to 126.
    pub address: u8,
    /// What it is to us.
    pub state: BusStationState,
    /// The name we gave it.
    pub name: Option<String>,
    /// What it is, as far as we know.
    pub device: Option<String>,
    /// Ident_Number, in hex.
    pub ident: Option<String>,
    /// What it is doing, in words.
    pub description: String,
}

/// A gauge.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Gauge {
    /// Its name.
    pub name: String,
    /// Its segment.
    pub segment: String,
    /// Its address.
    pub address: u8,
    /// What it is: `bcg450`.
    pub device: String,
    /// What it is to us.
    pub state: BusStationState,
    /// Why it does not measure, in a sentence.
    pub problem: Option<String>,
    /// What it reports beside the pressure, in words.
    pub exceptions: Vec<String>,
    /// The gas its readings are corrected for beside the indicated ones.
    pub gas: String,
    /// Where a line is drawn in a trend.
    pub levels: Vec<PressureLevel>,
    /// What it measures, one for each measuring part that travels.
    pub readings: Vec<Reading>,
    /// How old the readings are, in milliseconds; nothing if there never was one.
    pub age_ms: Option<u64>,
    /// How often they are taken, in milliseconds: older than a few of these, they are stale.
    pub poll_ms: u64,
    /// The age in milliseconds from which the readings are stale.
    pub stale_after_ms: u64,
}

/// A pressure at which something happens.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct PressureLevel {
    /// What happens.
    pub name: String,
    /// In Pa.
    pub pa: f64,
}

/// What a measuring part shows.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Reading {
    /// The name under which it is recorded: that of the gauge, with the channel of a controller.
    pub series: String,
    /// The instance or channel, 0 if there is only one.
    pub instance: u8,
    /// How the part senses: `pirani`, `hot-cathode`, `cold-cathode`, `diaphragm`, `atmosphere`.
    pub principle: Option<&'static str>,
    /// In Pa, as indicated; nothing unless there is a value.
    pub pa: Option<f64>,
    /// In Pa, corrected for the gas; nothing where no factor holds.
    pub corrected_pa: Option<f64>,
    /// The quality: `valid`, `overrange`, `underrange`, `invalid`, `gap`.
    #[schema(value_type = String)]
    pub quality: Quality,
}

/// A trend: one entry of each list for every pixel in which something was recorded.
#[derive(Clone, Debug, Default, PartialEq, Serialize, ToSchema)]
pub struct Trend {
    /// The name of what was recorded.
    pub series: String,
    /// Where pixels begin, in milliseconds since 1970, rising.
    pub start_ms: Vec<i64>,
    /// The lowest pressure in Pa; nothing where there was none.
    pub low: Vec<Option<f64>>,
    /// The highest.
    pub high: Vec<Option<f64>>,
    /// The geometric mean.
    pub mean: Vec<Option<f64>>,
    /// What occurred: bit 0 valid, 1 overrange, 2 underrange, 3 invalid, 4 gap.
    pub qualities: Vec<u8>,
}

impl Trend {
    /// A trend of bins.
    #[must_use]
    pub fn of(series: &str, bins: &[profivac_recorder::Span]) -> Self {
        Self {
            series: series.to_owned(),
            start_ms: bins.iter().map(|bin| unix_ms(bin.start)).collect(),
            low: bins.iter().map(|bin| bin.summary.low).collect(),
            high: bins.iter().map(|bin| bin.summary.high).collect(),
            mean: bins.iter().map(|bin| bin.summary.mean()).collect(),
            qualities: bins.iter().map(|bin| bin.summary.qualities).map(|Qualities(bits)| bits).collect(),
        }
    }
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct EventView {
    /// When, in milliseconds since 1970.
    pub at_ms: i64,
    /// To which gauge.
    pub gauge: Option<String>,
    /// What kind of thing: `station`, `bus`, `gauge`, `command`, `note`.
    pub kind: &'static str,
    /// One sentence.
    pub text: String,
}

impl From<Event> for EventView {
    fn from(event: Event) -> Self {
        Self { at_ms: unix_ms(event.at), gauge: event.gauge, kind: event.kind.word(), text: event.text }
    }
}

/// What a rise of pressure consists of.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct RiseView {
    /// The pressure at the beginning, in Pa.
    pub start_pa: f64,
    /// The part that does not slow down, in Pa/s.
    pub steady_pa_per_s: f64,
    /// The same as a flow, in Pa m³/s, if the volume is known.
    pub leak_pa_m3_per_s: Option<f64>,
    /// How far the part that slows down rises, in Pa; nothing if it cannot be told from the steady one.
    pub bend_pa: Option<f64>,
    /// Its time constant in seconds.
    pub tau_s: Option<f64>,
    /// Its flow at the beginning, in Pa m³/s, if the volume is known.
    pub outgassing_pa_m3_per_s: Option<f64>,
    /// How much of the variation is explained, 0 to 1.
    pub explained: f64,
    /// How many samples were fitted.
    pub samples: usize,
}

/// A block of a gauge with its parameters.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Block {
    /// The manual's name of the block.
    pub name: String,
    /// Its parameters.
    pub parameters: Vec<Parameter>,
}

/// How far the parameters of a gauge are read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct ReadProgress {
    /// The gauge.
    pub gauge: String,
    /// So many were read.
    pub done: usize,
    /// Of so many.
    pub total: usize,
}

/// Who may act on gauges now.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct ControlAuthorityView {
    /// Who; nothing if it is free.
    pub holder: Option<String>,
    /// Since when, in milliseconds since 1970.
    pub since_ms: Option<i64>,
    /// Who wants it.
    pub requested_by: Option<String>,
    /// Since when.
    pub requested_ms: Option<i64>,
}

/// A parameter of a gauge.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Parameter {
    /// By what it is read and written: `trip-point.1/high-trip-point`.
    pub target: String,
    /// The manual's name.
    pub name: String,
    /// Slot and index, or the number of the parameter channel.
    pub numbers: String,
    /// What the manual allows: `R`, `R/W`, ...
    pub access: String,
    /// What it shows now, with its unit; nothing if it could not be read.
    pub value: Option<String>,
    /// Why it could not be read.
    pub read_error: Option<String>,
    /// What it takes to write it; nothing if it is not written, or only as a command.
    pub write: Option<WriteInfo>,
}

/// How large a risk is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RiskClass {
    /// A command without a risk in the tables.
    Harmless,
    /// A value that is lost at power-off.
    Volatile,
    /// A value that is kept if the device is told to store it.
    StoredOnRequest,
    /// A value that is kept at power-off.
    Persistent,
    /// The tables warn of it.
    Dangerous,
}

/// A risk.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Risk {
    /// How large it is.
    pub class: RiskClass,
    /// A description, from the table where it has one.
    pub description: String,
}

/// What it takes to write a parameter.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct WriteInfo {
    /// What it takes, in words with its unit.
    pub expects: String,
    /// The values it takes, if it takes only these.
    pub allowed_values: Vec<String>,
    /// What it risks.
    pub risk: Risk,
    /// Who may.
    pub role: Role,
    /// Why nobody may from here.
    pub blocked_reason: Option<String>,
}

/// Milliseconds since 1970.
#[must_use]
pub const fn unix_ms(at: Micros) -> i64 {
    at.0.div_euclid(1000)
}

/// A time in whole milliseconds.
#[must_use]
pub fn duration_ms(time: Duration) -> u64 {
    u64::try_from(time.as_millis()).unwrap_or(u64::MAX)
}
