//! The views of the station that the API sends as JSON.
//!
//! Pressures are in Pa. Another unit, or the correction for a gas, is a matter of display.

use profivac_client::cyclic::IntegerRange;
use profivac_devices::model::Model;
use profivac_identify::Interval;
use profivac_identify::rise::{Cause, Flow};
use profivac_model::{Micros, Principle, Quality, words};
use profivac_web_server::auth::Role;
use serde::{Serialize, Serializer};
use std::sync::Arc;
use std::time::Duration;
use utoipa::ToSchema;

/// The station.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Station {
    /// The name.
    pub name: String,
    /// The version of the program.
    pub version: &'static str,
    /// When it was started, in milliseconds since 1970.
    pub started_ms: i64,
    /// The time of its clock, in milliseconds since 1970.
    pub now_ms: i64,
    /// The recorder.
    pub recorder: RecorderView,
    /// The parts that cannot run, for example a gateway whose address another program has; the station tries again.
    pub stopped_parts: Vec<StoppedPart>,
    /// What the archive does not have of the station, in a sentence: it does not answer, or has put batches aside.
    pub archive_problem: Option<String>,
}

/// A part of the station that cannot run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct StoppedPart {
    /// Its name: that of a gateway.
    pub name: String,
    /// Why it does not run, in a sentence.
    pub problem: String,
}

/// The recorder.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct RecorderView {
    /// The time of the last write, in milliseconds since 1970.
    pub last_write_ms: Option<i64>,
    /// Why it does not write, if it does not.
    pub error: Option<String>,
    /// Samples that were dropped.
    pub lost_samples: u64,
    /// Events that were dropped.
    pub lost_events: u64,
    /// When the last check of the whole database ended, in milliseconds since 1970; `null` before the first one.
    pub last_check_ms: Option<i64>,
    /// The damage that the last check has found, if it has found any.
    pub damage: Option<String>,
}

words! {
    /// The state of a segment.
    pub enum SegmentState {
        /// The port is not open.
        Waiting = "waiting",
        /// The master listens before it enters the ring, or the station only listens and has received no telegram for three seconds.
        Listening = "listening",
        /// The master is in the ring, or the station only listens and receives telegrams.
        Running = "running",
    }
}

/// A segment with the stations on its bus.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Segment {
    /// Its name.
    pub name: String,
    /// Its port.
    pub port: String,
    /// Bits per second.
    pub baud: u32,
    /// The address of the master of this station; `null` if the station only listens.
    pub master: Option<u8>,
    /// The station only listens: it sends nothing, and offers no control.
    pub listen_only: bool,
    /// The state.
    pub state: SegmentState,
    /// Why it does not run, in a sentence.
    pub problem: Option<String>,
    /// The duration of a cycle, in milliseconds.
    pub cycle_ms: Option<f64>,
    /// Telegrams that arrived damaged since the port was opened.
    pub damaged_telegrams: u32,
    /// The stations on the bus, by address.
    pub stations: Vec<BusStation>,
}

/// The state of a station on the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum BusStationState {
    /// The master of this station.
    OwnMaster,
    /// Another master.
    OtherMaster,
    /// A gauge in data exchange.
    DataExchange,
    /// A gauge in data exchange that reports a fault.
    Fault,
    /// A gauge that is being brought into data exchange.
    Starting,
    /// A gauge that does not answer, or belongs to another master.
    #[default]
    Missing,
    /// A slave that is not in the station's file.
    Unconfigured,
}

/// A station on a segment.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct BusStation {
    /// Its address, 0 to 126.
    pub address: u8,
    /// The state.
    pub state: BusStationState,
    /// The name in the station's file.
    pub name: Option<String>,
    /// The device, if it is known.
    pub device: Option<String>,
    /// Ident_Number, in hex.
    pub ident: Option<String>,
    /// A description of the state.
    pub description: String,
}

words! {
    /// What the station knows of a slave in its file.
    #[derive(Default)]
    pub enum GaugeKind {
        /// A gauge or controller of its tables, with pressures.
        #[default]
        Gauge = "gauge",
        /// Another slave by its GSD file, with points instead of pressures.
        Slave = "slave",
    }
}

/// A gauge, or another slave of the station's file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, ToSchema)]
pub struct Gauge {
    /// Its name.
    pub name: String,
    /// A gauge with readings, or a slave with points.
    pub kind: GaugeKind,
    /// Its segment.
    pub segment: String,
    /// Its address.
    pub address: u8,
    /// The device: `bcg450`; of a slave vendor and model of its GSD file.
    pub device: String,
    /// Its tables; a slave by its GSD file has none.
    #[serde(skip)]
    pub model: Option<&'static Model>,
    /// The vendor, of a slave by its GSD file; that of a gauge is in its tables. Gateways show it.
    #[serde(skip)]
    pub vendor: Option<Arc<str>>,
    /// The pressures that the integers of its telegram hold, if that is less than every pressure: its range ends there at the latest.
    #[serde(skip)]
    pub integers: Option<IntegerRange>,
    /// Whether the device has DP-V1: its parameters travel over MS2, those of other devices in the parameter channel.
    pub has_dpv1: bool,
    /// The state.
    pub state: BusStationState,
    /// Why it is not in data exchange, in a sentence.
    pub problem: Option<String>,
    /// Another master owns it and the station only listens: no parameter is read and no command is sent.
    pub listen_only: bool,
    /// The assumptions about its configuration and unit, in sentences; its readings depend on it. Empty unless the station only listens.
    pub assumptions: Vec<String>,
    /// The alarms that it reports: its defects in the words of the manual, once the station has read them.
    pub exceptions: Vec<String>,
    /// The warnings that it reports, without those that the qualities of its readings explain.
    pub warnings: Vec<String>,
    /// The gas for which the readings are corrected; empty for a slave.
    pub gas: String,
    /// Pressures that trends mark with a line.
    pub levels: Vec<PressureLevel>,
    /// The readings, one for each measuring part in the cyclic data.
    pub readings: Vec<Reading>,
    /// The parameters that gateways show beside the pressures, empty while no gateway runs; of a slave its points.
    #[schema(value_type = Vec<WatchedParameter>)]
    #[serde(serialize_with = "sequence")]
    pub parameters: Arc<[WatchedParameter]>,
    /// The age of the readings in milliseconds; `null` if there never was one.
    pub age_ms: Option<u64>,
    /// When the gauge gave the readings, in milliseconds since 1970; `null` if there never was one.
    #[schema(value_type = Option<i64>)]
    #[serde(rename = "read_ms")]
    pub read_at: Option<Micros>,
    /// When the station decided the present state of a gauge without readings: lost, or being brought into data exchange. `None` while
    /// it has readings. Gateways show it as the time of their loss.
    #[serde(skip)]
    pub lost_at: Option<Micros>,
    /// The station has not found out yet whether the gauge answers: in the first round of its segment, at most 30 s. It is not missed yet.
    #[serde(skip)]
    pub is_awaited: bool,
    /// The poll interval in milliseconds.
    pub poll_ms: u64,
    /// The age in milliseconds from which the readings are stale.
    pub stale_after_ms: u64,
}

/// A parameter that the station reads from time to time: emission, degas, trip points, relays. A point of a slave is one too.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct WatchedParameter {
    /// The name by which it is read and written: `trip-point.1/high-trip-point`; of a point its name.
    pub target: String,
    /// The manual's name; of a point its place in the inputs.
    pub name: String,
    /// The unit of its number: `Pa` for a pressure, `%` for a percentage, `null` for a number or a code without a unit; of a point the
    /// unit in the station's file.
    pub unit: Option<&'static str>,
    /// The value in this unit; `null` if it was not read, the gauge did not answer the last time, or a state was read more than 60 s ago.
    pub number: Option<f64>,
    /// The value in the words of the manual, or of the station's file for a point; of a stale point why its record was not read.
    pub text: String,
    /// The quality: `valid`; `stale` without a value; `fault` for a point whose number is bad.
    #[schema(value_type = profivac_model::quality::schema::Quality)]
    #[serde(serialize_with = "words::serialize")]
    pub quality: Quality,
    /// When it was read, in milliseconds since 1970.
    #[schema(value_type = Option<i64>)]
    #[serde(rename = "read_ms")]
    pub read_at: Option<Micros>,
    /// When the station decided that it has no value; `None` with a value, of one that was never read, and of a point. Gateways date the
    /// loss with it.
    #[serde(skip)]
    pub lost_at: Option<Micros>,
}

/// A pressure that a trend marks with a line.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct PressureLevel {
    /// The name.
    pub name: String,
    /// In Pa.
    pub pa: f64,
}

/// The reading of a measuring part.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Reading {
    /// The name under which it is recorded: that of the gauge, with the channel of a controller.
    pub series: String,
    /// The instance or channel, 0 if there is only one.
    pub instance: u8,
    /// How the part senses.
    #[schema(value_type = Option<profivac_model::quality::schema::Principle>)]
    #[serde(serialize_with = "words::serialize_optional")]
    pub principle: Option<Principle>,
    /// The indicated pressure in Pa; `null` unless the quality is `valid`.
    pub pa: Option<f64>,
    /// The end of the range in Pa, of a pressure below it (`underrange`) or above it (`overrange`).
    pub limit_pa: Option<f64>,
    /// The pressure in Pa, corrected for the gas; `null` where no factor holds.
    pub corrected_pa: Option<f64>,
    /// The quality.
    #[schema(value_type = profivac_model::quality::schema::Quality)]
    #[serde(serialize_with = "words::serialize")]
    pub quality: Quality,
    /// The cause of the quality, in a few words, where the gauge reports one; for `assumed` the pressure that the assumption gives.
    pub cause: Option<String>,
    /// The device reports a defect of this part beside the reading, in a status octet or as an alarm. Gateways tell it from a number that
    /// is no pressure: a TPG300 or TPG500 has no alarms of its own.
    #[serde(skip)]
    pub is_defect: bool,
}

/// The remark behind the text of a point that its status octet calls uncertain.
pub const UNCERTAIN: &str = " (uncertain)";

impl WatchedParameter {
    /// The text without the remark about the status: an uncertain value is the same value to an alarm and to an event.
    #[must_use]
    pub fn text_without_remark(&self) -> &str {
        self.text.strip_suffix(UNCERTAIN).unwrap_or(&self.text)
    }

    /// Whether its status octet calls it uncertain.
    #[must_use]
    pub fn is_uncertain(&self) -> bool {
        self.text.ends_with(UNCERTAIN)
    }
}

impl Reading {
    /// The pressure, or the end of the range beyond which it is, in Pa.
    #[must_use]
    pub fn bound_pa(&self) -> Option<f64> {
        self.pa.or(self.limit_pa)
    }
}

/// The alarms of a gauge, or the faults of its readings.
#[must_use]
pub fn fault_text(exceptions: &[String], readings: &[Reading]) -> String {
    if !exceptions.is_empty() {
        return exceptions.join(", ");
    }
    let faults = readings.iter().filter(|reading| reading.quality == Quality::Fault);
    let faults: Vec<_> =
        faults.map(|it| format!("{}: {}", it.series, it.cause.as_deref().unwrap_or("fault"))).collect();
    if faults.is_empty() { "a fault".to_owned() } else { faults.join(", ") }
}

/// A pressure in a sentence, with the digits that the dashboard shows: `1013 mbar`, `5.00 mbar`, `5.00e-4 mbar`.
#[must_use]
pub fn mbar(pa: f64) -> String {
    let value = pa / 100.0;
    match value.abs() {
        99.95..9999.5 => format!("{value:.0} mbar"),
        9.995..99.95 => format!("{value:.1} mbar"),
        0.9995..9.995 => format!("{value:.2} mbar"),
        _ => format!("{value:.2e} mbar"),
    }
}

fn sequence<S: Serializer, T: Serialize>(items: &Arc<[T]>, serializer: S) -> Result<S::Ok, S::Error> {
    items[..].serialize(serializer)
}

/// A value with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct IntervalView {
    /// The mean.
    pub mean: f64,
    /// The lower bound.
    pub low: f64,
    /// The upper bound.
    pub high: f64,
}

impl From<Interval> for IntervalView {
    fn from(Interval { mean, low, high }: Interval) -> Self {
        Self { mean, low, high }
    }
}

/// A gas flow in three units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct FlowView {
    /// In Pa m³/s.
    pub pa_m3_per_s: IntervalView,
    /// In mbar l/s.
    pub mbar_l_per_s: IntervalView,
    /// In sccm at 0 °C and 1013.25 mbar, from the temperature of the gas.
    pub sccm: IntervalView,
}

impl From<Flow> for FlowView {
    fn from(flow: Flow) -> Self {
        Self {
            pa_m3_per_s: flow.pa_m3_per_s.into(),
            mbar_l_per_s: flow.mbar_l_per_s().into(),
            sccm: flow.sccm().into(),
        }
    }
}

/// The cause of a pressure rise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RiseCause {
    /// A leak; outgassing is not certain.
    Leak,
    /// Outgassing; a leak is not certain.
    Outgassing,
    /// Both are certain.
    Both,
    /// Leak and outgassing cannot be distinguished.
    Undistinguished,
    /// The pressure does not rise.
    NoRise,
}

impl From<Cause> for RiseCause {
    fn from(cause: Cause) -> Self {
        match cause {
            Cause::Leak => Self::Leak,
            Cause::Outgassing => Self::Outgassing,
            Cause::Both => Self::Both,
            Cause::Undistinguished => Self::Undistinguished,
            Cause::NoRise => Self::NoRise,
        }
    }
}

/// The probabilities of the shapes of a rise; they add up to 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct RiseShapes {
    /// A straight line.
    pub straight: f64,
    /// A straight line and outgassing that falls with the time.
    pub inverse_time: f64,
    /// A straight line and outgassing that saturates.
    pub saturating: f64,
}

/// The flows of a pressure rise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct RiseFlows {
    /// The leak.
    pub leak: FlowView,
    /// The outgassing at the beginning.
    pub outgassing: FlowView,
}

/// A point of the fitted rise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct RisePoint {
    /// Seconds since the beginning.
    pub s: f64,
    /// The pressure in Pa.
    pub pa: f64,
}

/// A pressure rise, separated into leak and outgassing.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct RiseView {
    /// The cause.
    pub cause: RiseCause,
    /// The leak in Pa/s.
    pub leak_pa_per_s: IntervalView,
    /// The outgassing at the beginning in Pa/s.
    pub outgassing_pa_per_s: IntervalView,
    /// Both as flows; `null` if the volume is not known.
    pub flows: Option<RiseFlows>,
    /// The probabilities of the shapes.
    pub shapes: RiseShapes,
    /// The root mean square of the residuals divided by the noise: near 1 for a good fit.
    pub misfit: f64,
    /// The time constant of saturation in seconds; `null` unless that shape is the most probable one.
    pub tau_s: Option<f64>,
    /// The time of pumping before the beginning in seconds; `null` if the database has no pump-down before it.
    pub pumped_s: Option<f64>,
    /// The accuracy of the gauge that the intervals contain, as a fraction; `null` if it was not given.
    pub accuracy: Option<f64>,
    /// The best fit, at most 400 points.
    pub fitted: Vec<RisePoint>,
    /// The number of fitted samples.
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

/// The progress of reading the parameters of a gauge.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct ReadProgress {
    /// The gauge.
    pub gauge: String,
    /// The number of parameters that were read.
    pub done: usize,
    /// The number of all parameters.
    pub total: usize,
}

/// The user who has control.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct ControlAuthorityView {
    /// The user; `null` if control is free.
    pub holder: Option<String>,
    /// Since when, in milliseconds since 1970.
    pub since_ms: Option<i64>,
    /// The user who requests control.
    pub requested_by: Option<String>,
    /// Since when.
    pub requested_ms: Option<i64>,
}

/// A parameter of a gauge.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Parameter {
    /// The name by which it is read and written: `trip-point.1/high-trip-point`.
    pub target: String,
    /// The manual's name.
    pub name: String,
    /// Slot and index, or the number of the parameter channel.
    pub numbers: String,
    /// The access that the manual allows: `R`, `R/W`, ...
    pub access: String,
    /// The present value with its unit; `null` if it could not be read.
    pub value: Option<String>,
    /// Why it could not be read.
    pub read_error: Option<String>,
    /// How it is written; `null` if it is not writable, or only by a command.
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

/// How a parameter is written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct WriteInfo {
    /// A description of the expected value, with its unit.
    pub expects: String,
    /// The allowed values, if only some are allowed.
    pub allowed_values: Vec<String>,
    /// The risk.
    pub risk: Risk,
    /// The role it needs.
    pub role: Role,
    /// Why the station never writes it.
    pub blocked_reason: Option<String>,
}

/// Milliseconds since 1970.
#[must_use]
pub const fn unix_ms(at: Micros) -> i64 {
    at.milliseconds()
}

/// A time in whole milliseconds.
#[must_use]
pub fn duration_ms(time: Duration) -> u64 {
    u64::try_from(time.as_millis()).unwrap_or(u64::MAX)
}
