//! A gauge of a segment: the station searches for it, brings it into data exchange, samples it and shows it.

use super::watched::{self, WatchedParameters};
use crate::config;
use crate::recording::RecorderHandle;
use crate::view::{self, BusStationState};
use profivac_client::cyclic::{ChannelValue, CyclicSlave, CyclicValues};
use profivac_client::discover::CyclicError;
use profivac_client::identify;
use profivac_client::ms2::Ms2;
use profivac_client::names::NamedParameter;
use profivac_client::pressure::Pressure;
use profivac_client::records::{RecordError, Unavailable};
use profivac_client::{ClientError, Defects};
use profivac_devices::Principle;
use profivac_devices::model::Model;
use profivac_devices::profile::ExceptionStatus;
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::{HandlerState, SlaveListError};
use profivac_host::port::PortError;
use profivac_host::scan;
use profivac_host::session::{BusMaster, BusSession, SessionError};
use profivac_recorder::validity::{self, MAX_SILENCE};
use profivac_recorder::{EventKind, Micros, Quality, Sample};
use profivac_vacuum::Gas;
use profivac_virtual::device_spec::{SpecError, entry};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The time between two searches for a missing gauge.
const SEARCH_INTERVAL: Duration = Duration::from_secs(3);

/// The time between two searches for a gauge without a free MS2 connection, which it will have soon. free choice.
const CONNECTION_INTERVAL: Duration = Duration::from_secs(1);

/// The time between two readings of the defects of a gauge with an alarm: another part may fail, or one be repaired. free choice.
const DEFECTS_INTERVAL: Duration = Duration::from_secs(10);

/// A gauge without data for this time is searched from the beginning: another device may answer at its address.
const SEARCH_AFTER: Duration = Duration::from_secs(5);

/// The longest inputs of a slave: a Data_Exchange answer has up to 244 octets (profibus-wire 2.1).
const MAX_INPUTS: usize = 244;

/// The gas factors of a Pirani hold from 1 to 100 Pa: BCG450 manual, page 54.
const PIRANI_PA: (f64, f64) = (1.0, 100.0);

/// The gas factors of an ion gauge hold below 0.1 Pa: BCG450 manual, page 54.
const ION_PA: f64 = 0.1;

/// The reason why a gauge cannot be brought into data exchange.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FindError {
    /// The port was lost.
    #[error(transparent)]
    Port(PortError),
    /// No slave answers at its address.
    #[error("no slave answers")]
    NoAnswer,
    /// The bus does not allow requests.
    #[error(transparent)]
    Session(SessionError),
    /// The slave cannot exchange data with this station.
    #[error(transparent)]
    Slave(CyclicError),
    /// All MS2 connections of the slave are in use, so its unit cannot be read.
    #[error(
        "waiting for an MS2 connection left by an earlier connection, for example of a station that was killed: its unit is read over \
         MS2, and the gauge closes an abandoned connection within 15 s"
    )]
    NoConnection,
    /// The station's file names a device that this program does not know.
    #[error(transparent)]
    UnknownDevice(#[from] SpecError),
    /// Another device has the address.
    #[error("it is a {found}, the station's file says {configured}")]
    OtherDevice {
        /// The device on the bus.
        found: &'static str,
        /// The device in the file.
        configured: String,
    },
    /// The master does not take it.
    #[error(transparent)]
    Rejected(#[from] SlaveListError),
}

impl From<SessionError> for FindError {
    fn from(error: SessionError) -> Self {
        match error {
            SessionError::Port(error) => Self::Port(error),
            error => Self::Session(error),
        }
    }
}

impl From<CyclicError> for FindError {
    fn from(error: CyclicError) -> Self {
        match error {
            CyclicError::Session(error) => error.into(),
            CyclicError::Client(ClientError::Unavailable { reason: Unavailable::NoConnection, .. })
            | CyclicError::UnreadableUnit { error: RecordError::Unavailable(Unavailable::NoConnection), .. } => {
                Self::NoConnection
            }
            error => Self::Slave(error),
        }
    }
}

/// A gauge.
pub struct GaugeSession {
    /// The configuration.
    pub config: config::Gauge,
    /// The slave, once it was found.
    pub slave: Option<CyclicSlave>,
    state: BusStationState,
    problem: Option<String>,
    /// The alarms in Exception Status, and what is known of the defects behind them.
    alarms: ExceptionStatus,
    defects: Defects,
    /// When the defects are to be read; `None` without an alarm.
    defects_at: Option<Instant>,
    warnings: Vec<String>,
    /// The parameters that gateways show.
    parameters: WatchedParameters,
    readings: Vec<view::Reading>,
    /// The series whose last sample is not a gap.
    recorded: Vec<Arc<str>>,
    /// When the gauge gave the readings, on the clock that is never set and on that of the system.
    read_at: Option<(Instant, Micros)>,
    /// The last data exchange in bus time, and when the station noticed it; at first the time of adding the slave.
    last_exchange: (Option<BitTime>, Instant),
    search_at: Instant,
    sample_at: Instant,
    /// Another master owns the gauge, and the station only listens.
    listens: bool,
    /// The assumptions about the configuration and the unit of a gauge of another master.
    assumptions: Vec<String>,
}

/// The heard facts about a gauge of another master.
pub struct Heard {
    /// Everything that decodes its inputs; `None` while the configuration is not known.
    pub slave: Option<CyclicSlave>,
    /// The values of its last inputs.
    pub values: CyclicValues,
    /// The time since the last data exchange; `None` without one.
    pub silence: Option<Duration>,
    /// The unknown facts, in sentences.
    pub unknown: Vec<String>,
    /// What the values depend on and no telegram and no user has shown.
    pub assumed: Option<Assumed>,
    /// The state on the line, for a gauge that does not exchange data.
    pub problem: String,
}

/// An assumption on which the pressures of a gauge depend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Assumed {
    /// The unit: a status is that of the gauge, a number is not.
    Unit,
    /// The configuration, which divides the inputs into fields: nothing in them is certain.
    Configuration,
}

impl GaugeSession {
    /// A gauge that has not been found yet.
    pub fn new(config: config::Gauge) -> Self {
        let now = Instant::now();
        Self {
            config,
            slave: None,
            state: BusStationState::Missing,
            problem: None,
            alarms: ExceptionStatus::empty(),
            defects: Defects::default(),
            defects_at: None,
            warnings: Vec::new(),
            parameters: WatchedParameters::default(),
            readings: Vec::new(),
            recorded: Vec::new(),
            read_at: None,
            last_exchange: (None, now),
            search_at: now,
            sample_at: now,
            listens: false,
            assumptions: Vec::new(),
        }
    }

    /// A gauge of another master, of which nothing was heard yet.
    pub fn listening(config: config::Gauge) -> Self {
        Self { listens: true, ..Self::new(config) }
    }

    /// Whether a gauge of another master is to be sampled now. If so, sets the time of the next sample.
    pub fn takes_sample_turn(&mut self) -> bool {
        let now = Instant::now();
        let is_due = self.sample_at <= now;
        if is_due {
            self.sample_at = now + self.config.poll;
        }
        is_due
    }

    /// Takes the heard facts about a gauge of another master. Validity and age are those of a gauge that the station polls.
    pub fn take_heard(&mut self, recorder: &RecorderHandle, heard: Heard) {
        let Heard { slave, values, silence, unknown, assumed, problem } = heard;
        let silence = silence.filter(|silence| *silence < MAX_SILENCE);
        self.assumptions = unknown;
        match (slave, silence) {
            (Some(slave), Some(silence)) => {
                let now = Instant::now();
                self.slave = Some(slave);
                self.last_exchange.1 = now.checked_sub(silence).unwrap_or(now);
                self.read_at = Some((self.last_exchange.1, before_now(silence)));
                self.observe(&slave, &values, silence);
                if let Some(assumed) = assumed {
                    self.withdraw(assumed, slave.unit.name);
                }
                self.note_problem(recorder, None);
                // With another configuration the inputs have other series: none of them is recorded.
                match assumed {
                    Some(Assumed::Configuration) => self.record_gap(recorder),
                    Some(Assumed::Unit) | None => self.record(recorder),
                }
            }
            _ => {
                self.begin_gap(recorder);
                self.state = BusStationState::Missing;
                self.note_problem(recorder, Some(problem));
            }
        }
    }

    /// A gauge whose slave the master already has.
    pub fn with_slave(config: config::Gauge, slave: CyclicSlave) -> Self {
        Self { slave: Some(slave), state: BusStationState::Starting, ..Self::new(config) }
    }

    /// The same slave with another configuration.
    pub fn with_config(mut self, config: config::Gauge) -> Self {
        self.config = config;
        self
    }

    /// When the gauge needs to be sampled or searched.
    pub fn due(&self) -> Instant {
        if self.slave.is_some() { self.sample_at } else { self.search_at }
    }

    /// Whether the gauge is missing and is to be searched now. If so, sets the time of the next search.
    pub fn takes_search_turn(&mut self) -> bool {
        let now = Instant::now();
        let is_due = self.slave.is_none() && self.search_at <= now;
        if is_due {
            self.search_at = now + SEARCH_INTERVAL;
        }
        is_due
    }

    /// Takes the result of a search: adds the slave to the master, or notes the problem.
    pub fn search_finished(
        &mut self,
        recorder: &RecorderHandle,
        master: &mut BusMaster,
        baud: Baud,
        found: Result<CyclicSlave, FindError>,
    ) {
        let added = found.and_then(|slave| {
            master.remove(self.config.address);
            master.add(&slave.parameters(baud))?;
            Ok(slave)
        });
        match added {
            Ok(slave) => {
                let now = Instant::now();
                self.slave = Some(slave);
                self.state = BusStationState::Starting;
                self.sample_at = now;
                self.last_exchange = (None, now);
            }
            Err(error) => {
                if matches!(error, FindError::NoConnection) {
                    self.search_at = Instant::now() + CONNECTION_INTERVAL;
                }
                self.state = BusStationState::Missing;
                self.note_problem(recorder, Some(error.to_string()));
            }
        }
    }

    /// Sets the problem, and records an event if it is another one than before.
    fn note_problem(&mut self, recorder: &RecorderHandle, problem: Option<String>) {
        if self.problem != problem {
            let sentence = problem.as_deref().unwrap_or("in data exchange");
            let text = format!("{}: {sentence}", self.config.name);
            recorder.event_now(Some(&self.config.name), EventKind::Bus, text);
            self.problem = problem;
        }
    }

    /// Ends the data exchange because the port is lost, the segment stops or the gauge is removed.
    pub fn disconnect(&mut self, recorder: &RecorderHandle, problem: &str) {
        self.begin_gap(recorder);
        self.slave = None;
        self.state = BusStationState::Missing;
        self.problem = Some(problem.to_owned());
        self.search_at = Instant::now();
    }

    /// Removes the slave from the master.
    pub fn release(&mut self, session: &mut BusSession) {
        session.master().remove(self.config.address);
    }

    /// Takes the present reading, if its time has come.
    pub fn sample(&mut self, recorder: &RecorderHandle, master: &mut BusMaster) {
        let now = Instant::now();
        let Some(slave) = self.slave.filter(|_| self.sample_at <= now) else { return };
        self.sample_at = now + self.config.poll;
        let address = self.config.address;
        let exchanged_at = master.exchanged_at(address);
        if exchanged_at.is_some() && exchanged_at != self.last_exchange.0 {
            self.last_exchange = (exchanged_at, now);
        }
        let silence = now.saturating_duration_since(self.last_exchange.1);
        match master.inputs(address).filter(|_| silence < MAX_SILENCE) {
            Some(inputs) => self.take_reading(recorder, &slave, &slave.decode_inputs(inputs), silence),
            None => self.take_no_reading(recorder, master),
        }
        if silence > SEARCH_AFTER {
            master.remove(address);
            self.slave = None;
            self.search_at = Instant::now();
        }
    }

    fn take_reading(
        &mut self,
        recorder: &RecorderHandle,
        slave: &CyclicSlave,
        values: &CyclicValues,
        silence: Duration,
    ) {
        self.read_at = Some((self.last_exchange.1, before_now(silence)));
        self.observe(slave, values, silence);
        self.note_problem(recorder, None);
        self.record(recorder);
    }

    /// Takes the values of a data exchange that was `silence` ago.
    pub fn observe(&mut self, slave: &CyclicSlave, values: &CyclicValues, silence: Duration) {
        self.take_alarms(values.exception & ExceptionStatus::ALARM);
        self.warnings = values.warnings().into_iter().map(str::to_owned).collect();
        self.state = state_of(values);
        let is_only = values.values.len() == 1;
        let reading = |value| reading(&self.config, slave, value, is_only, silence);
        self.readings = values.values.iter().map(reading).collect();
    }

    /// Takes back what depends on an assumption, before it is shown, recorded or evaluated: a pressure becomes the cause of a reading
    /// without one.
    fn withdraw(&mut self, assumed: Assumed, unit: &str) {
        for reading in self.readings.iter_mut().filter(|reading| assumed.concerns(reading.quality)) {
            reading.cause = Some(assumed.cause(reading, unit));
            reading.quality = Quality::Assumed;
            (reading.pa, reading.limit_pa, reading.corrected_pa) = (None, None, None);
        }
        if assumed == Assumed::Configuration {
            self.take_alarms(ExceptionStatus::empty());
            self.warnings.clear();
            self.state = BusStationState::DataExchange;
        }
    }

    /// Other alarms than before: what was known of their defects does not hold any more.
    fn take_alarms(&mut self, alarms: ExceptionStatus) {
        if self.alarms != alarms {
            self.alarms = alarms;
            self.defects = Defects::default();
            self.defects_at = (!alarms.is_empty()).then(Instant::now);
        }
    }

    /// The slave whose defects are to be read now, if there is one. If so, sets the time of the next reading.
    pub fn takes_defects_turn(&mut self) -> Option<CyclicSlave> {
        let (now, slave) = (Instant::now(), self.slave?);
        let is_due = slave.model.features.dpv1 && self.defects_at? <= now;
        self.defects_at = if is_due { Some(now + DEFECTS_INTERVAL) } else { self.defects_at };
        is_due.then_some(slave)
    }

    /// Takes the defects that were read. An alarm that ended meanwhile has none.
    pub fn take_defects(&mut self, defects: Defects) {
        if !self.alarms.is_empty() {
            self.defects = defects;
        }
    }

    /// When the next parameter is to be read for gateways; `None` for a gauge that does not exchange data.
    pub fn parameter_due(&mut self) -> Option<Instant> {
        let slave = self.slave?;
        if !matches!(self.state, BusStationState::DataExchange | BusStationState::Fault) {
            return None;
        }
        self.parameters.found(slave.model, Instant::now());
        self.parameters.due()
    }

    /// The parameter that is to be read now for gateways, if there is one. If so, sets the time of its next reading.
    pub fn takes_parameter_turn(&mut self) -> Option<(CyclicSlave, &'static NamedParameter)> {
        Some((self.slave?, self.parameters.takes_turn(Instant::now())?))
    }

    /// Takes the value of a parameter; `None` if the gauge did not give one.
    pub fn take_parameter(&mut self, parameter: &NamedParameter, value: Option<view::WatchedParameter>) {
        self.parameters.take(parameter, value);
    }

    /// An operation of the station may have changed its parameters.
    pub fn parameters_changed(&mut self) {
        self.parameters.changed(Instant::now());
    }

    /// The alarms in words: their defects, as far as they are known.
    fn exceptions(&self) -> Vec<String> {
        self.defects.texts(self.alarms)
    }

    fn take_no_reading(&mut self, recorder: &RecorderHandle, master: &BusMaster) {
        self.begin_gap(recorder);
        let address = self.config.address;
        let problem = master.exchange_error(address).map(|error| error.to_string());
        let is_present = !matches!(master.state(address), None | Some(HandlerState::Offline | HandlerState::Inactive));
        self.state = if is_present && problem.is_none() { BusStationState::Starting } else { BusStationState::Missing };
        if problem.is_some() {
            self.note_problem(recorder, problem);
        }
    }

    fn record(&mut self, recorder: &RecorderHandle) {
        let at = Micros::now();
        self.recorded.clear();
        for reading in &self.readings {
            let series: Arc<str> = Arc::from(reading.series.as_str());
            recorder.push(&series, Sample::new(at, reading.bound_pa(), reading.quality));
            self.recorded.push(series);
        }
    }

    fn record_gap(&mut self, recorder: &RecorderHandle) {
        let at = Micros::now();
        for series in self.recorded.drain(..) {
            recorder.push(&series, Sample::gap(at));
        }
    }

    /// Begins a gap in each recorded series, and shows no pressure.
    fn begin_gap(&mut self, recorder: &RecorderHandle) {
        self.record_gap(recorder);
        for reading in &mut self.readings {
            reading.pa = None;
            reading.limit_pa = None;
            reading.corrected_pa = None;
            reading.cause = None;
            reading.quality = Quality::Stale;
        }
        self.take_alarms(ExceptionStatus::empty());
        self.warnings.clear();
    }

    /// The gauge as a station on the bus.
    pub fn bus_station(&self) -> view::BusStation {
        let description = match (&self.problem, self.state) {
            (Some(problem), _) => problem.clone(),
            (None, BusStationState::DataExchange) => "in data exchange".to_owned(),
            (None, BusStationState::Fault) => view::fault_text(&self.exceptions(), &self.readings),
            (None, _) => "is being brought into data exchange".to_owned(),
        };
        view::BusStation {
            address: self.config.address,
            state: self.state,
            name: Some(self.config.name.clone()),
            device: Some(self.config.device.clone()),
            ident: self.slave.map(|slave| format!("0x{:04X}", slave.model.ident)),
            description,
        }
    }

    /// The gauge as the API shows it.
    pub fn view(&self, segment: &str) -> view::Gauge {
        let levels = self.config.levels.iter();
        view::Gauge {
            name: self.config.name.clone(),
            segment: segment.to_owned(),
            address: self.config.address,
            device: self.config.device.clone(),
            has_dpv1: entry(&self.config.device).is_ok_and(|entry| entry.model.features.dpv1),
            listen_only: self.listens,
            assumptions: self.assumptions.clone(),
            state: self.state,
            problem: self.problem.clone(),
            exceptions: self.exceptions(),
            warnings: self.warnings.clone(),
            gas: self.config.gas.to_string(),
            levels: levels.map(|(name, level)| view::PressureLevel { name: name.clone(), pa: level.pa() }).collect(),
            readings: self.readings.clone(),
            parameters: self.parameters.values(),
            age_ms: self.read_at.map(|(at, _)| view::duration_ms(at.elapsed())),
            read_at: self.read_at.map(|(_, at)| at),
            poll_ms: view::duration_ms(self.config.poll),
            stale_after_ms: validity::stale_after_ms(view::duration_ms(self.config.poll)),
        }
    }
}

/// A gauge of the station's file before anything was heard of it: without data, with the readings of its default configuration.
#[must_use]
pub fn planned_gauge(config: &config::Gauge, segment: &str, listen_only: bool) -> view::Gauge {
    let readings = planned_readings(config);
    // A gauge of another master has none.
    let parameters = if listen_only { Vec::new() } else { planned_parameters(&config.device) };
    view::Gauge { readings, parameters, listen_only, ..GaugeSession::new(config.clone()).view(segment) }
}

/// The parameters of a device that gateways show, without values.
#[must_use]
pub fn planned_parameters(device: &str) -> Vec<view::WatchedParameter> {
    entry(device).map(|entry| watched::planned(entry.model)).unwrap_or_default()
}

/// The readings of a gauge in its configuration, without values.
#[must_use]
pub fn planned_readings(config: &config::Gauge) -> Vec<view::Reading> {
    let Ok(model) = entry(&config.device).map(|entry| entry.model) else { return Vec::new() };
    let Some(unit) = config.unit.or_else(|| model.units.first()) else { return Vec::new() };
    let configuration = config.configuration.unwrap_or(model.default_configuration);
    let slave = CyclicSlave { address: config.address, model, configuration, unit, channels: Default::default() };
    let mut session = GaugeSession::new(config.clone());
    session.observe(&slave, &slave.decode_inputs(&[0; MAX_INPUTS]), MAX_SILENCE);
    session.readings
}

/// Searches for a gauge at its address: a slave that answers, that no other master owns, and that is the configured device.
pub fn find_gauge(session: &mut BusSession, gauge: &config::Gauge, master: u8) -> Result<CyclicSlave, FindError> {
    // A probe takes less time than waiting for a slave that is absent.
    let probed = scan::probe(session, gauge.address)?;
    if probed.is_none_or(|station| station.slave.is_none()) {
        return Err(FindError::NoAnswer);
    }
    let found = CyclicSlave::find(session, gauge.address, master)?;
    let configured = entry(&gauge.device)?.model;
    // A model that the search only assumes is no reason to doubt the file: the model is read again.
    let reported = if configured.ident == found.model.ident && configured.name != found.model.name {
        identify::reported_model(found.model.ident, &mut Ms2::new(session, gauge.address))
    } else {
        None
    };
    as_configured(found, reported, configured, &gauge.device)
}

/// The found slave as the configured device. Devices that share an ident number differ in the model that they report; TPG300
/// and TPG500 report none.
fn as_configured(
    found: CyclicSlave,
    reported: Option<&'static Model>,
    model: &'static Model,
    device: &str,
) -> Result<CyclicSlave, FindError> {
    let is_other = |other: &Model| other.name != model.name;
    let other =
        if model.ident == found.model.ident { reported.filter(|other| is_other(other)) } else { Some(found.model) };
    if let Some(other) = other {
        return Err(FindError::OtherDevice { found: other.name, configured: device.to_owned() });
    }
    let configuration = model.configuration(found.configuration.octets).unwrap_or(found.configuration);
    Ok(CyclicSlave { model, configuration, unit: model.unit(found.unit.code).unwrap_or(found.unit), ..found })
}

/// The time of the system clock `silence` ago.
fn before_now(silence: Duration) -> Micros {
    let micros = i64::try_from(silence.as_micros()).unwrap_or(i64::MAX);
    Micros(Micros::now().0.saturating_sub(micros))
}

impl Assumed {
    /// Whether a reading with this quality may be false.
    const fn concerns(self, quality: Quality) -> bool {
        match self {
            Self::Unit => quality.has_pressure(),
            Self::Configuration => !matches!(quality, Quality::Stale),
        }
    }

    /// What the reading would be if the assumption is right.
    fn cause(self, reading: &view::Reading, unit: &str) -> String {
        let sign = match reading.quality {
            Quality::Overrange => "> ",
            Quality::Underrange => "< ",
            _ => "",
        };
        let value = reading.bound_pa().map(|pa| format!("{sign}{:.1e} mbar", Pressure::from_pa(pa).mbar()));
        let value = value.unwrap_or_else(|| reading.quality.label().to_owned());
        match self {
            Self::Unit => format!("{value} if the unit is {unit}"),
            Self::Configuration => format!("{value} if configuration and unit are the assumed ones"),
        }
    }
}

/// The state of a gauge that exchanges data.
fn state_of(values: &CyclicValues) -> BusStationState {
    if values.has_fault() { BusStationState::Fault } else { BusStationState::DataExchange }
}

fn reading(
    gauge: &config::Gauge,
    slave: &CyclicSlave,
    value: &ChannelValue,
    is_only: bool,
    silence: Duration,
) -> view::Reading {
    // A TPG300 or TPG500 does not report which gauges its channels have.
    let principle = slave.principle(value.instance);
    let name = &gauge.name;
    let quality = validity::quality_after(value.quality, silence);
    let is_fresh = quality == value.quality;
    view::Reading {
        series: if is_only { name.clone() } else { format!("{name}.{}", value.instance) },
        instance: value.instance,
        principle,
        pa: value.pa.filter(|_| is_fresh),
        limit_pa: value.limit_pa.filter(|_| is_fresh),
        corrected_pa: value.pa.filter(|_| is_fresh).and_then(|pa| corrected(pa, principle?, gauge.gas)),
        quality,
        cause: value.cause.filter(|_| is_fresh).map(|cause| cause.to_string()),
    }
}

/// The pressure of a gas at which a sensor that was calibrated for nitrogen indicates `pa`, where the factors hold.
#[must_use]
pub fn corrected(pa: f64, principle: Principle, gas: Gas) -> Option<f64> {
    match principle {
        Principle::Diaphragm | Principle::Atmosphere => Some(pa),
        _ if gas == Gas::N2 => Some(pa),
        Principle::Pirani => (PIRANI_PA.0..=PIRANI_PA.1).contains(&pa).then(|| pa * gas.pirani_factor()),
        Principle::HotCathode | Principle::ColdCathode => (pa < ION_PA).then(|| pa * gas.ion_factor()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gas_factors_are_used_only_where_they_hold() {
        assert_eq!(corrected(10.0, Principle::Pirani, Gas::Ar), Some(17.0));
        assert_eq!(corrected(1e4, Principle::Pirani, Gas::Ar), None);
        assert_eq!(corrected(1e4, Principle::Pirani, Gas::N2), Some(1e4));
        assert_eq!(corrected(1e4, Principle::Diaphragm, Gas::Ar), Some(1e4));
        assert_eq!(corrected(1.0, Principle::HotCathode, Gas::He), None);
        let helium = corrected(1e-4, Principle::HotCathode, Gas::He).unwrap();
        assert!((helium / 5.9e-4 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_gauge_whose_connections_are_in_use_is_told_as_waiting_for_them() {
        let unreadable = |error: RecordError| FindError::from(CyclicError::UnreadableUnit { address: 5, error });
        let waiting = unreadable(Unavailable::NoConnection.into()).to_string();
        assert!(waiting.starts_with("waiting for an MS2 connection left by an earlier connection"), "{waiting}");
        let other = unreadable(Unavailable::NoMs1.into()).to_string();
        assert!(other.starts_with("the unit of the slave at address 5 cannot be read: "), "{other}");
    }
}
