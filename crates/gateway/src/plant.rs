//! The points of a station: one walk over segments, gauges and alarms, which gives the points and their values in the same order.

use crate::point::{Limits, Point, Subject};
use crate::signal::{Kind, Signal, alarm_state, gauge_state, line_state, priority, quality, segment_state};
use crate::state::State;
use profivac_client::names::{ParameterNames, Target};
use profivac_devices::Principle;
use profivac_devices::model::{AccessPath, Codes, DataType, Direction, Model, Row};
use profivac_devices::reading::Quality;
use profivac_listen::gauge::Origin;
use profivac_listen::report::{BusReport, Distribution, StationReport};
use profivac_recorder::export::seven_digits;
use profivac_recorder::{Micros, PointKind};
use profivac_station::alarm::view::{AlarmView, LimitKind};
use profivac_station::alarm::{AlarmState, ConditionKind, Priority};
use profivac_station::config::{self, Config, is_virtual};
use profivac_station::control::permissions;
use profivac_station::directory::{Directory, GaugeLabels};
use profivac_station::segment::{planned_parameters, planned_readings, planned_segments};
use profivac_station::services::Services;
use profivac_station::snapshot::SegmentSnapshot;
use profivac_station::view::{
    self, BusStationState, Gauge, GaugeKind, Reading, Segment, SegmentState, WatchedParameter,
};
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;
use std::time::Duration;

/// Everything that the points show, at one moment.
#[derive(Clone, Debug)]
pub struct Inputs {
    /// The station.
    pub station: view::Station,
    /// The segments, in the order of the file.
    pub segments: Vec<Segment>,
    /// The gauges, in the order of the file.
    pub gauges: Vec<Gauge>,
    /// The segments of the file before they start: a gauge that was not found yet has the readings that its gauge has there.
    pub plan: Arc<[SegmentSnapshot]>,
    /// All alarms.
    pub alarms: Vec<AlarmView>,
    /// The lines, by the name of the segment.
    pub buses: BTreeMap<String, Arc<BusReport>>,
    /// The labels of the gauges.
    pub directory: Arc<Directory>,
}

impl Inputs {
    /// The present state of a running station.
    #[must_use]
    pub fn of(services: &Services) -> Self {
        let (segments, gauges) = parts(services.snapshots().in_order_of_file());
        Self {
            station: services.station(),
            segments,
            gauges,
            plan: services.snapshots().plan(),
            alarms: services.alarms().all(),
            buses: services.snapshots().buses().reports(),
            directory: services.directory().view(),
        }
    }

    /// Whether the gauges of this segment are virtual.
    fn is_simulated(&self, segment: &str) -> bool {
        self.segments.iter().any(|it| it.name == segment && is_virtual(&it.port))
    }

    /// The state of a station of this file before it starts: without data, with the points that it will have.
    #[must_use]
    pub fn planned(config: &Config) -> Self {
        let (segments, gauges) = parts(planned_segments(&config.segments));
        Self {
            station: view::Station {
                name: config.name.clone(),
                version: env!("CARGO_PKG_VERSION"),
                started_ms: 0,
                now_ms: 0,
                recorder: view::RecorderView::default(),
                stopped_parts: Vec::new(),
                archive_problem: None,
            },
            segments,
            gauges,
            plan: Arc::default(),
            alarms: config.alarms.iter().map(AlarmView::planned).collect(),
            buses: BTreeMap::new(),
            directory: Arc::new(config.directory.clone()),
        }
    }

    /// A number that differs if the points differ: their subjects, segments, labels, ranges, limits and ages, not their values.
    #[must_use]
    pub fn structure(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        for segment in &self.segments {
            (&segment.name, is_virtual(&segment.port)).hash(&mut hasher);
        }
        for gauge in &self.gauges {
            (&gauge.name, &gauge.segment, &gauge.device, &gauge.vendor, gauge.stale_after_ms).hash(&mut hasher);
            gauge.integers.map(|it| [it.lowest_pa, it.highest_pa].map(f64::to_bits)).hash(&mut hasher);
            gauge.model.map(std::ptr::from_ref).hash(&mut hasher);
            (gauge.readings.len(), gauge.parameters.len()).hash(&mut hasher);
            gauge.parameters.iter().for_each(|it| (&it.target, &it.name, it.unit).hash(&mut hasher));
            for reading in &gauge.readings {
                let principle = reading.principle.map(|principle| principle as u8);
                (&reading.series, reading.instance, principle).hash(&mut hasher);
            }
        }
        self.directory.gauges.hash(&mut hasher);
        self.directory.points.iter().for_each(|it| it.point.hash(&mut hasher));
        for alarm in &self.alarms {
            let limit = alarm.limit.map(f64::to_bits);
            (&alarm.name, &alarm.segment, alarm.condition as u8, &alarm.series, alarm.priority, limit)
                .hash(&mut hasher);
            (&alarm.gauge, &alarm.point).hash(&mut hasher);
        }
        hasher.finish()
    }
}

/// The segments, and the gauges of all of them in the same order.
fn parts(snapshots: Vec<SegmentSnapshot>) -> (Vec<Segment>, Vec<Gauge>) {
    let parts = snapshots.into_iter().map(|SegmentSnapshot { segment, gauges }| (segment, gauges));
    let (segments, gauges): (Vec<_>, Vec<_>) = parts.unzip();
    (segments, gauges.into_iter().flatten().collect())
}

/// The readings of a gauge of which nothing was heard yet.
pub(crate) fn default_readings(gauge: &Gauge, plan: &[SegmentSnapshot]) -> Vec<Reading> {
    let segment = plan.iter().find(|it| it.segment.name == gauge.segment);
    let planned = segment.and_then(|it| it.gauges.iter().find(|planned| planned.name == gauge.name));
    if let Some(planned) = planned {
        return planned.readings.clone();
    }
    let Some(model) = gauge.model else { return Vec::new() };
    planned_readings(&config::Gauge::plain(gauge.name.clone(), gauge.address, model))
}

/// The parameters of a gauge that were not read yet. Those of a gauge that belongs to another master are never read.
pub(crate) fn default_parameters(gauge: &Gauge) -> Vec<WatchedParameter> {
    match gauge.model {
        Some(model) if !gauge.listen_only => planned_parameters(model),
        _ => Vec::new(),
    }
}

/// The same reading without a value.
pub(crate) fn without_value(reading: &Reading) -> Reading {
    let Reading { series, instance, principle, .. } = reading;
    Reading {
        series: series.clone(),
        instance: *instance,
        principle: *principle,
        pa: None,
        limit_pa: None,
        corrected_pa: None,
        quality: Quality::Stale,
        cause: None,
        is_defect: false,
    }
}

/// A value that borrows from the inputs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Raw<'a> {
    /// There is none.
    None,
    /// See [`crate::Value::Float`].
    Float(f64),
    /// See [`crate::Value::Integer`].
    Integer(i64),
    /// See [`crate::Value::Boolean`].
    Boolean(bool),
    /// See [`crate::Value::Text`].
    Text(&'a str),
    /// See [`crate::Value::Choice`].
    Choice(u16),
    /// See [`crate::Value::Time`].
    Time(Micros),
}

impl Raw<'_> {
    fn float(number: Option<f64>) -> Self {
        number.map_or(Raw::None, Raw::Float)
    }

    fn count(number: u64) -> Self {
        Raw::Integer(i64::try_from(number).unwrap_or(i64::MAX))
    }

    fn optional_count(number: Option<u64>) -> Self {
        number.map_or(Raw::None, Self::count)
    }
}

/// A receiver of the points in their order.
pub trait Sink {
    /// The next subject: what follows belongs to it. `describe` gives its points without their signals.
    fn subject(&mut self, describe: impl FnOnce() -> PointOf);
    /// The next point of the subject.
    fn point(&mut self, signal: Signal, value: Raw, state: State, at: Option<Micros>);
}

/// What the points of one subject share.
#[derive(Clone, Debug)]
pub struct PointOf {
    /// The subject.
    pub subject: Subject,
    /// Its segment.
    pub segment: Option<Arc<str>>,
    /// The measuring range of its pressure.
    pub range_pa: Option<(f64, f64)>,
    /// The limits of the alarms on its pressure, or on its number.
    pub limits: Limits,
    /// The unit of the values that have the unit of an alarm's limit, or of the number of a parameter.
    pub own_unit: Option<&'static str>,
    /// The age in milliseconds from which it is stale, of a reading.
    pub stale_after_ms: Option<u64>,
    /// It is virtual.
    pub is_simulated: bool,
    /// It is a parameter that the station writes, if it controls the gauge.
    pub is_writable: bool,
    /// Its number is a code, bits or another integer without a unit.
    pub is_whole: bool,
    /// The manufacturer of its gauge.
    pub vendor: Option<Arc<str>>,
    /// The point of a slave as the recorder knows it.
    pub recorded: Option<Arc<profivac_recorder::Point>>,
}

impl PointOf {
    fn plain(subject: Subject, segment: Option<Arc<str>>, is_simulated: bool) -> Self {
        Self {
            subject,
            segment,
            range_pa: None,
            limits: Limits::default(),
            own_unit: None,
            stale_after_ms: None,
            is_simulated,
            is_writable: false,
            is_whole: false,
            vendor: None,
            recorded: None,
        }
    }
}

/// A sink that collects the points and ignores their values.
#[derive(Default)]
struct Collector {
    present: Option<PointOf>,
    points: Vec<Point>,
}

impl Sink for Collector {
    fn subject(&mut self, describe: impl FnOnce() -> PointOf) {
        self.present = Some(describe());
    }

    fn point(&mut self, signal: Signal, _: Raw, _: State, _: Option<Micros>) {
        let Some(of) = self.present.clone() else { return };
        let PointOf { subject, segment, range_pa, limits, own_unit, stale_after_ms, .. } = of;
        let PointOf { is_simulated, is_writable, is_whole, vendor, recorded, .. } = of;
        let has_own_unit =
            matches!(signal, Signal::AlarmValue | Signal::AlarmLimit | Signal::RaisedValue | Signal::ParameterNumber);
        self.points.push(Point {
            subject,
            signal,
            segment,
            unit: signal.unit().or(own_unit.filter(|_| has_own_unit)),
            range: range_pa.and_then(|range| range_of(signal, range)),
            limits: if has_limits(signal) { limits } else { Limits::default() },
            stale_after_ms,
            is_simulated,
            is_writable,
            is_whole,
            vendor,
            recorded: recorded.filter(|_| signal.kind() == Kind::Float),
        });
    }
}

/// Whether the limits of a subject are limits of this signal.
const fn has_limits(signal: Signal) -> bool {
    matches!(
        signal,
        Signal::Pressure | Signal::ParameterPressure | Signal::ParameterPercentage | Signal::ParameterNumber
    )
}

/// The range of a signal of a reading with this measuring range in Pa.
fn range_of(signal: Signal, (low, high): (f64, f64)) -> Option<(f64, f64)> {
    match signal {
        Signal::Pressure | Signal::CorrectedPressure => Some((low, high)),
        Signal::PressureLog10 => (low > 0.0).then(|| (low.log10(), high.log10())),
        _ => None,
    }
}

/// The points of these inputs.
#[must_use]
pub fn points(inputs: &Inputs) -> Vec<Point> {
    let mut collector = Collector::default();
    walk(inputs, &mut collector);
    collector.points
}

/// Gives every point with its value to the sink: those of the station, of the segments, of the gauges with their readings, and of the
/// alarms.
pub fn walk(inputs: &Inputs, sink: &mut impl Sink) {
    station(inputs, sink);
    for it in &inputs.segments {
        segment(it, inputs.buses.get(&it.name).map(AsRef::as_ref), sink);
    }
    let alarms = GaugeAlarms::by_gauge(&inputs.alarms);
    for it in &inputs.gauges {
        gauge(inputs, it, alarms.get(it.name.as_str()).copied().unwrap_or_default(), sink);
        it.readings.iter().for_each(|reading| self::reading(inputs, it, reading, sink));
        it.parameters.iter().for_each(|parameter| self::parameter(inputs, it, parameter, sink));
    }
    let gauges: HashMap<&str, &Gauge> = inputs.gauges.iter().map(|gauge| (gauge.name.as_str(), gauge)).collect();
    for it in &inputs.alarms {
        alarm(it, it.gauge.as_deref().and_then(|gauge| gauges.get(gauge).copied()), sink);
    }
}

/// The alarms of one gauge together.
#[derive(Clone, Copy, Default)]
struct GaugeAlarms {
    /// The highest priority of the active ones, as a position in [`crate::signal::PRIORITIES`].
    priority: u16,
    /// One of them waits for an acknowledgement.
    is_unacknowledged: bool,
}

impl GaugeAlarms {
    /// One pass over all alarms: a station may have thousands, and each gauge has some of them.
    fn by_gauge(alarms: &[AlarmView]) -> HashMap<&str, Self> {
        let mut all: HashMap<&str, Self> = HashMap::new();
        for alarm in alarms {
            let Some(gauge) = &alarm.gauge else { continue };
            let own = all.entry(gauge).or_default();
            if alarm.state.is_active() {
                own.priority = own.priority.max(priority::of(alarm.priority));
            }
            own.is_unacknowledged |= alarm.state.needs_acknowledgement();
        }
        all
    }
}

/// A point that no gauge measures.
fn plain(sink: &mut impl Sink, signal: Signal, value: Raw) {
    sink.point(signal, value, State::Ok, None);
}

fn station(inputs: &Inputs, sink: &mut impl Sink) {
    let Inputs { station, segments, alarms, .. } = inputs;
    sink.subject(|| PointOf::plain(Subject::Station, None, false));
    let uptime_s = station.now_ms.saturating_sub(station.started_ms) / 1000;
    let count = |is_counted: fn(&AlarmState) -> bool| {
        Raw::count(alarms.iter().filter(|alarm| is_counted(&alarm.state)).count() as u64)
    };
    let down = segments.iter().filter(|segment| segment.state != SegmentState::Running).count();
    plain(sink, Signal::Heartbeat, Raw::Integer(uptime_s));
    plain(sink, Signal::Version, Raw::Text(station.version));
    plain(sink, Signal::Started, time(station.started_ms));
    plain(sink, Signal::Recording, Raw::Boolean(station.recorder.error.is_none()));
    plain(sink, Signal::LostSamples, Raw::count(station.recorder.lost_samples));
    plain(sink, Signal::LostEvents, Raw::count(station.recorder.lost_events));
    plain(sink, Signal::LastWrite, station.recorder.last_write_ms.map_or(Raw::None, time));
    plain(sink, Signal::RecorderProblem, Raw::Text(station.recorder.error.as_deref().unwrap_or_default()));
    plain(sink, Signal::ActiveAlarms, count(|state| state.is_active()));
    plain(sink, Signal::UnacknowledgedAlarms, count(|state| state.needs_acknowledgement()));
    plain(sink, Signal::SegmentsDown, Raw::count(down as u64));
}

/// A time in milliseconds since 1970.
const fn time(ms: i64) -> Raw<'static> {
    Raw::Time(Micros(ms.saturating_mul(1000)))
}

fn segment(segment: &Segment, bus: Option<&BusReport>, sink: &mut impl Sink) {
    let name: Arc<str> = Arc::from(segment.name.as_str());
    sink.subject(|| PointOf::plain(Subject::Segment(Arc::clone(&name)), Some(name), is_virtual(&segment.port)));
    let cycle_s = segment.cycle_ms.map(|ms| ms / 1e3);
    let rotation_s = bus.and_then(|bus| bus.rotation.mean_us).map(microseconds);
    let sum = |count: fn(&StationReport) -> u64| {
        Raw::optional_count(bus.map(|bus| bus.stations.iter().map(count).fold(0, u64::saturating_add)))
    };
    let damaged = bus.map_or(u64::from(segment.damaged_telegrams), |bus| bus.damaged);
    plain(sink, Signal::SegmentState, Raw::Choice(segment_state::of(segment.state)));
    plain(sink, Signal::SegmentUp, Raw::Boolean(segment.state == SegmentState::Running));
    plain(sink, Signal::SegmentProblem, Raw::Text(segment.problem.as_deref().unwrap_or_default()));
    plain(sink, Signal::CycleTime, Raw::float(cycle_s));
    plain(sink, Signal::TokenRotation, Raw::float(rotation_s));
    plain(sink, Signal::Telegrams, Raw::optional_count(bus.map(|bus| bus.telegrams)));
    plain(sink, Signal::DamagedTelegrams, Raw::count(damaged));
    plain(sink, Signal::SegmentRepetitions, sum(|station| station.total.repeated));
    plain(sink, Signal::SegmentLostCycles, sum(|station| station.total.lost));
    let longest =
        |times: fn(&BusReport) -> &Distribution| Raw::float(bus.and_then(|bus| times(bus).max_us).map(microseconds));
    plain(sink, Signal::LongestCycle, longest(|bus| &bus.cycle));
    plain(sink, Signal::LongestRotation, longest(|bus| &bus.rotation));
    plain(sink, Signal::DamagedLastMinute, Raw::optional_count(bus.map(|bus| bus.damaged_last_minute)));
    plain(sink, Signal::ObservedTime, Raw::optional_count(bus.map(|bus| bus.observed_ms / 1000)));
    plain(sink, Signal::TokenRing, Raw::Text(&bus.map(ring_text).unwrap_or_default()));
    plain(sink, Signal::SegmentListenOnly, Raw::Boolean(segment.listen_only));
    plain(sink, Signal::Baud, Raw::Integer(segment.baud.into()));
    plain(sink, Signal::Master, segment.master.map_or(Raw::None, |address| Raw::Integer(address.into())));
}

/// The addresses of the masters in the order of the token: `1 3`.
fn ring_text(bus: &BusReport) -> String {
    bus.ring.iter().map(u8::to_string).collect::<Vec<_>>().join(" ")
}

/// Microseconds in seconds.
#[expect(clippy::cast_precision_loss, reason = "a duration of 285 years has 53 bits")]
fn microseconds(us: u64) -> f64 {
    us as f64 / 1e6
}

fn gauge(inputs: &Inputs, gauge: &Gauge, alarms: GaugeAlarms, sink: &mut impl Sink) {
    let is_simulated = inputs.is_simulated(&gauge.segment);
    let bus =
        inputs.buses.get(&gauge.segment).and_then(|bus| bus.stations.iter().find(|it| it.address == gauge.address));
    sink.subject(|| {
        let subject = Subject::Gauge(Arc::from(gauge.name.as_str()));
        let plain = PointOf::plain(subject, Some(Arc::from(gauge.segment.as_str())), is_simulated);
        PointOf { vendor: gauge.vendor.clone().or_else(|| gauge.model.map(|model| Arc::from(model.vendor))), ..plain }
    });
    let counts = bus.map(|bus| bus.total);
    plain(sink, Signal::GaugeState, Raw::Choice(gauge_state::of(gauge.state)));
    plain(sink, Signal::Problem, Raw::Text(gauge.problem.as_deref().unwrap_or_default()));
    plain(sink, Signal::Faults, Raw::Text(&gauge.exceptions.join(", ")));
    plain(sink, Signal::Warnings, Raw::Text(&gauge.warnings.join(", ")));
    plain(sink, Signal::Assumptions, Raw::Text(&gauge.assumptions.join(" ")));
    plain(sink, Signal::Device, Raw::Text(&gauge.device));
    plain(sink, Signal::Address, Raw::Integer(gauge.address.into()));
    plain(sink, Signal::Gas, Raw::Text(&gauge.gas));
    if let Some(labels) = inputs.directory.gauges.get(&gauge.name) {
        self::labels(labels, sink);
    }
    plain(sink, Signal::Simulated, Raw::Boolean(is_simulated));
    plain(sink, Signal::ListenOnly, Raw::Boolean(gauge.listen_only));
    plain(sink, Signal::AlarmPriority, Raw::Choice(alarms.priority));
    plain(sink, Signal::Unacknowledged, Raw::Boolean(alarms.is_unacknowledged));
    plain(sink, Signal::Requests, Raw::optional_count(counts.map(|counts| counts.requests)));
    plain(sink, Signal::Repetitions, Raw::optional_count(counts.map(|counts| counts.repeated)));
    plain(sink, Signal::LostCycles, Raw::optional_count(counts.map(|counts| counts.lost)));
    plain(sink, Signal::DamagedAnswers, Raw::optional_count(counts.map(|counts| counts.damaged)));
    on_line(bus, sink);
}

/// The labels that the file gives a gauge. A label that it does not give is no point.
fn labels(labels: &GaugeLabels, sink: &mut impl Sink) {
    let GaugeLabels { group, tags, location, calibrated, calibration_due } = labels;
    let tags = (!tags.is_empty()).then(|| tags.join(", "));
    for (signal, label) in [
        (Signal::Group, group),
        (Signal::Tags, &tags),
        (Signal::Location, location),
        (Signal::Calibrated, calibrated),
        (Signal::CalibrationDue, calibration_due),
    ] {
        if let Some(label) = label {
            plain(sink, signal, Raw::Text(label));
        }
    }
}

/// What the traffic shows of a gauge beside the counters of its requests.
fn on_line(bus: Option<&StationReport>, sink: &mut impl Sink) {
    let is_known = |station: &&StationReport| station.unit_origin.is_some_and(|origin| origin != Origin::Assumed);
    let unit = bus.filter(is_known).and_then(|station| station.unit.as_deref());
    let owner = bus.and_then(|station| station.owner);
    let diagnosis = bus.map(|station| station.diagnosis.join(", ")).unwrap_or_default();
    plain(sink, Signal::Refusals, Raw::optional_count(bus.map(|station| station.total.refused)));
    plain(sink, Signal::LongestSequence, Raw::optional_count(bus.map(|station| station.longest_sequence.into())));
    plain(sink, Signal::LineState, bus.map_or(Raw::None, |station| Raw::Choice(line_state::of(station.state))));
    plain(sink, Signal::LineUnit, Raw::Text(unit.unwrap_or_default()));
    plain(sink, Signal::Owner, owner.map_or(Raw::None, |address| Raw::Integer(address.into())));
    plain(sink, Signal::Diagnosis, Raw::Text(&diagnosis));
}

fn reading(inputs: &Inputs, gauge: &Gauge, reading: &Reading, sink: &mut impl Sink) {
    sink.subject(|| PointOf {
        subject: Subject::Reading {
            gauge: Arc::from(gauge.name.as_str()),
            channel: (gauge.readings.len() > 1).then_some(reading.instance),
            series: Arc::from(reading.series.as_str()),
        },
        segment: Some(Arc::from(gauge.segment.as_str())),
        own_unit: None,
        range_pa: range_pa(gauge, reading),
        limits: limits(&inputs.alarms, |alarm| side_of_series(alarm, &reading.series)),
        stale_after_ms: Some(gauge.stale_after_ms),
        is_simulated: inputs.is_simulated(&gauge.segment),
        is_writable: false,
        is_whole: false,
        vendor: None,
        recorded: None,
    });
    let state = State::of(gauge, reading);
    let pressure = reading.bound_pa().filter(|_| state.codes().has_value);
    let corrected = reading.corrected_pa.filter(|_| state.codes().is_measured);
    let text = state_text(reading, state);
    let at = decided_at(gauge, state);
    sink.point(Signal::Pressure, Raw::float(pressure), state, at);
    sink.point(Signal::PressureLog10, Raw::float(pressure.map(f64::log10)), state, at);
    sink.point(Signal::CorrectedPressure, Raw::float(corrected), state, at);
    sink.point(Signal::State, Raw::Choice(state.number()), state, at);
    sink.point(Signal::StateText, Raw::Text(&text), state, at);
    sink.point(Signal::Usable, Raw::Boolean(state.codes().is_measured), state, at);
    sink.point(Signal::LastReading, gauge.read_at.map_or(Raw::None, Raw::Time), state, at);
    sink.point(Signal::Quality, Raw::Choice(quality(reading, state)), state, at);
    sink.point(Signal::Cause, Raw::Text(reading.cause.as_deref().unwrap_or_default()), state, at);
}

/// When a gauge came into the state of its readings: the time of the data exchange that gave them, or the time at which the station
/// decided that there are none. A client that keeps one event for each time (an EPICS archiver) would miss a loss with the time of the last
/// reading.
fn decided_at(gauge: &Gauge, state: State) -> Option<Micros> {
    match (gauge.lost_at, gauge.read_at) {
        (None, Some(read_at)) if state == State::Stale => {
            Some(read_at.after(Duration::from_millis(gauge.stale_after_ms)))
        }
        (lost_at, read_at) => lost_at.or(read_at),
    }
}

/// The position of the quality in [`crate::signal::QUALITIES`]; an old reading is stale, also if its segment does not say so.
fn quality(reading: &Reading, state: State) -> u16 {
    quality::of(if matches!(state, State::Stale | State::Starting) { Quality::Stale } else { reading.quality })
}

/// The row of this parameter in the tables of a device.
fn row_of(model: &'static Model, target: &str) -> Option<&'static Row> {
    match ParameterNames::shared(model).find(model.name, target) {
        Ok(Target::Parameter(named)) => Some(named.parameter.row),
        _ => None,
    }
}

/// Whether the station writes the parameter of this row of a device.
fn is_writable(model: &Model, row: &Row) -> bool {
    let path = if model.features.dpv1 { AccessPath::Class2 } else { AccessPath::ParameterChannel };
    row.access.allows(path, Direction::Write) && permissions::blocked_reason(row).is_none()
}

/// Whether the numbers of a parameter are whole: codes, bits, or integers without a unit.
const fn is_whole(row: &Row) -> bool {
    match &row.codes {
        Codes::Names(_) | Codes::Commands(_) | Codes::Bits(_) | Codes::Units | Codes::BitCommands(_) => true,
        Codes::Plain | Codes::Range(..) => matches!(
            row.data_type,
            DataType::Boolean
                | DataType::Int8
                | DataType::Uint8
                | DataType::Int16
                | DataType::Uint16
                | DataType::Int32
                | DataType::Uint32
        ),
        Codes::PerMille(..) | Codes::Quantity(_) | Codes::Version => false,
    }
}

fn parameter(inputs: &Inputs, gauge: &Gauge, parameter: &WatchedParameter, sink: &mut impl Sink) {
    sink.subject(|| {
        let subject = Subject::Parameter {
            gauge: Arc::from(gauge.name.as_str()),
            target: Arc::from(parameter.target.as_str()),
            name: Arc::from(parameter.name.as_str()),
        };
        let segment = Some(Arc::from(gauge.segment.as_str()));
        let recorded = inputs.directory.point(&gauge.name, &parameter.target).map(|it| Arc::new(it.point.clone()));
        let plain = PointOf::plain(subject, segment, inputs.is_simulated(&gauge.segment));
        let limits = limits(&inputs.alarms, |alarm| side_of_point(alarm, &gauge.name, &parameter.target));
        let row = gauge.model.and_then(|model| Some((model, row_of(model, &parameter.target)?)));
        let is_writable = row.is_some_and(|(model, row)| is_writable(model, row));
        let is_whole = row.is_some_and(|(_, row)| is_whole(row))
            || recorded.as_ref().is_some_and(|point| point.kind == PointKind::Code);
        PointOf { own_unit: parameter.unit, limits, is_writable, is_whole, recorded, ..plain }
    });
    let ParameterState { is_read, state, at } = ParameterState::of(gauge, parameter);
    let number = Raw::float(parameter.number.filter(|_| is_read));
    let signal = match parameter.unit {
        Some("Pa") => Signal::ParameterPressure,
        Some("%") => Signal::ParameterPercentage,
        _ => Signal::ParameterNumber,
    };
    sink.point(signal, number, state, at);
    // A stale point of a slave says why; a stale parameter has no text.
    let has_text = is_read && !(matches!(state, State::Stale | State::NotRead) && parameter.text.is_empty());
    let text = if has_text { Raw::Text(&parameter.text) } else { Raw::None };
    sink.point(Signal::ParameterText, text, state, at);
}

/// What is known of the value of a parameter.
struct ParameterState {
    /// It was read, and its gauge has not been lost since.
    is_read: bool,
    state: State,
    /// When it was read, or when the station decided that it has no value.
    at: Option<Micros>,
}

impl ParameterState {
    fn of(gauge: &Gauge, parameter: &WatchedParameter) -> Self {
        let counts = match gauge.kind {
            // A gauge that is not in data exchange may have lost what was read.
            GaugeKind::Gauge => matches!(gauge.state, BusStationState::DataExchange | BusStationState::Fault),
            // The records of a slave are read without data exchange, and the points of a slave that is lost have no time.
            GaugeKind::Slave => gauge.age_ms.is_some_and(|age| age <= gauge.stale_after_ms),
        };
        let read_at = parameter.read_at.filter(|_| counts);
        let is_read = read_at.is_some();
        let state = if is_read { State::recorded(parameter.quality) } else { State::Stale };
        let at = match gauge.kind {
            GaugeKind::Slave if state == State::Stale => decided_at(gauge, state),
            GaugeKind::Gauge if state == State::Stale => gauge.lost_at.max(parameter.lost_at).or(read_at),
            GaugeKind::Gauge | GaugeKind::Slave => read_at,
        };
        // The gauge is there: to say that there is no communication would be false.
        let state = match (state, gauge.kind) {
            (State::Stale, GaugeKind::Gauge) if counts => State::NotRead,
            (State::Ok, GaugeKind::Slave) if parameter.is_uncertain() => State::Uncertain,
            (state, _) => state,
        };
        Self { is_read, state, at }
    }
}

/// A pressure, or a state with its cause. A gateway whose protocol has short texts cuts it.
fn state_text(reading: &Reading, state: State) -> String {
    let pressure = |pa: f64| format!("{pa:.2e} Pa");
    match (state, reading.bound_pa(), &reading.cause) {
        (State::Ok, Some(pa), _) => pressure(pa),
        (State::UnderRange, Some(pa), _) => format!("< {}", pressure(pa)),
        (State::OverRange, Some(pa), _) => format!("> {}", pressure(pa)),
        (_, _, Some(cause)) => format!("{}: {cause}", state.label()),
        _ => state.label().to_owned(),
    }
}

/// The pressures that a reading can show: the measuring range, as far as the integers of the telegram hold it. Beyond them the reading is
/// over or under range, and its limit is their end.
fn range_pa(gauge: &Gauge, reading: &Reading) -> Option<(f64, f64)> {
    let (low, high) = measuring_range_pa(gauge, reading)?;
    let (low, high) = gauge.integers.map_or((low, high), |it| (low.max(it.lowest_pa), high.min(it.highest_pa)));
    // The manuals give mbar: 5e-10 mbar in Pa is 5.0000000000000004e-8 before it is rounded.
    (low < high).then(|| (seven_digits(low), seven_digits(high)))
}

/// The range of the part that gives a reading: that of its principle, or of the whole gauge where one reading stands for all parts.
fn measuring_range_pa(gauge: &Gauge, reading: &Reading) -> Option<(f64, f64)> {
    let model = gauge.model?;
    let of_instance = model.parts.iter().filter(|spec| spec.part.instance == reading.instance);
    let own: Vec<_> = of_instance.filter(|spec| reading.principle.is_none_or(|it| it == spec.part.principle)).collect();
    let chamber = model.parts.iter().filter(|spec| spec.part.principle != Principle::Atmosphere);
    let parts = if own.is_empty() || gauge.readings.len() == 1 { chamber.collect() } else { own };
    // A controller accepts different gauges on a channel: without knowing which, there is no range.
    let ranges = parts.iter().map(|spec| (spec.limits.under_pa, spec.limits.over_pa));
    ranges.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// On which side of its limit an alarm on this series is raised.
fn side_of_series(alarm: &AlarmView, series: &str) -> Option<LimitKind> {
    match alarm.condition {
        _ if alarm.series.as_deref() != Some(series) => None,
        ConditionKind::Above => Some(LimitKind::Above),
        ConditionKind::Below => Some(LimitKind::Below),
        _ => None,
    }
}

/// On which side of its limit an alarm on this point of a slave is raised.
fn side_of_point(alarm: &AlarmView, gauge: &str, point: &str) -> Option<LimitKind> {
    let limited = alarm.point.as_ref()?;
    (alarm.gauge.as_deref() == Some(gauge) && limited.name == point).then_some(limited.side)
}

/// The limits of the alarms of a subject, by the side on which each is raised.
fn limits(alarms: &[AlarmView], side: impl Fn(&AlarmView) -> Option<LimitKind>) -> Limits {
    let mut limits = Limits::default();
    for alarm in alarms {
        let (Some(side), Some(limit)) = (side(alarm), alarm.limit) else { continue };
        let is_high = alarm.priority == Priority::High;
        let (target, is_tighter): (_, fn(f64, f64) -> bool) = match (side, is_high) {
            (LimitKind::Above, true) => (&mut limits.high_high, |new, old| new < old),
            (LimitKind::Above, false) => (&mut limits.high, |new, old| new < old),
            (LimitKind::Below, false) => (&mut limits.low, |new, old| new > old),
            (LimitKind::Below, true) => (&mut limits.low_low, |new, old| new > old),
            (LimitKind::Rise, _) => continue,
        };
        if target.is_none_or(|old| is_tighter(limit, old)) {
            *target = Some(limit);
        }
    }
    limits
}

/// When the present value of an alarm was measured, or when it was lost: that of the reading, or of the point of a slave. `None` for an
/// alarm about something else, whose value no gauge measures.
fn measured_at(alarm: &AlarmView, gauge: &Gauge) -> Option<Micros> {
    if let Some(limited) = &alarm.point {
        let parameter = gauge.parameters.iter().find(|parameter| parameter.target == limited.name)?;
        return ParameterState::of(gauge, parameter).at;
    }
    let series = alarm.series.as_deref()?;
    let reading = gauge.readings.iter().find(|reading| reading.series == series)?;
    decided_at(gauge, State::of(gauge, reading))
}

/// Why an alarm was raised. The sentence is in the present tense, so that of an alarm that is not active says when it was true.
fn alarm_text(alarm: &AlarmView) -> Cow<'_, str> {
    if alarm.text.is_empty() || alarm.state.is_active() {
        Cow::Borrowed(&alarm.text)
    } else {
        Cow::Owned(format!("when raised: {}", alarm.text))
    }
}

fn alarm(alarm: &AlarmView, gauge: Option<&Gauge>, sink: &mut impl Sink) {
    sink.subject(|| {
        let segment = alarm.segment.as_deref().map(Arc::from);
        let subject = Subject::Alarm(Arc::from(alarm.name.as_str()));
        PointOf { own_unit: alarm.unit, ..PointOf::plain(subject, segment, false) }
    });
    // The value changes with the readings. What the file says has the time at which it changed, and the rest that of the change of the alarm.
    let measured_at = gauge.and_then(|gauge| measured_at(alarm, gauge));
    let changed_at = alarm.since_ms.map(|ms| Micros(ms.saturating_mul(1000)));
    let text = alarm_text(alarm);
    let mut put = |signal: Signal, value| {
        let at = match signal {
            Signal::AlarmValue => measured_at,
            Signal::Priority | Signal::AlarmLimit | Signal::AlarmUnit | Signal::Instruction => None,
            _ => changed_at,
        };
        sink.point(signal, value, State::Ok, at);
    };
    put(Signal::AlarmState, Raw::Choice(alarm_state::of(alarm.state)));
    put(Signal::AlarmActive, Raw::Boolean(alarm.state.is_active()));
    put(Signal::AlarmAcknowledged, Raw::Boolean(!alarm.state.needs_acknowledgement()));
    put(Signal::Priority, Raw::Choice(priority::of(alarm.priority)));
    put(Signal::Occurrence, Raw::Integer(alarm.occurrence));
    put(Signal::AlarmText, Raw::Text(&text));
    let suppression = alarm.out_of_service.as_ref().or(alarm.shelved.as_ref()).or(alarm.suppressed.as_ref());
    put(Signal::AlarmValue, Raw::float(alarm.value));
    put(Signal::AlarmLimit, Raw::float(alarm.limit));
    put(Signal::AlarmUnit, Raw::Text(alarm.unit.unwrap_or_default()));
    put(Signal::AcknowledgedBy, Raw::Text(alarm.acknowledged_by.as_deref().unwrap_or_default()));
    put(Signal::AcknowledgedAt, alarm.acknowledged_ms.map_or(Raw::None, time));
    put(Signal::Raised, alarm.raised_ms.map_or(Raw::None, time));
    put(Signal::RaisedValue, Raw::float(alarm.raised_value));
    put(Signal::OutOfService, Raw::Text(suppression.map_or("", |it| &it.reason)));
    put(Signal::SuppressedBy, Raw::Text(suppression.map_or("", |it| &it.user)));
    put(Signal::SuppressedUntil, suppression.and_then(|it| it.until_ms).map_or(Raw::None, time));
    put(Signal::Instruction, Raw::Text(alarm.message.as_deref().unwrap_or_default()));
}

/// Whether a value has the kind of its signal; a point without a value has every kind.
#[must_use]
pub const fn has_kind(signal: Signal, value: Raw) -> bool {
    matches!(
        (signal.kind(), value),
        (_, Raw::None)
            | (Kind::Float, Raw::Float(_))
            | (Kind::Integer, Raw::Integer(_))
            | (Kind::Boolean, Raw::Boolean(_))
            | (Kind::Text, Raw::Text(_))
            | (Kind::Choice(_), Raw::Choice(_))
            | (Kind::Time, Raw::Time(_))
    )
}
