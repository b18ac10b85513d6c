//! A gauge of a segment: the station brings it into data exchange, samples it and shows it.

use super::find::FindError;
use super::readings::{Assumed, reading, state_of};
use super::watched::{self, WatchedParameters};
use crate::config;
use crate::recording::RecorderHandle;
use crate::view::{self, BusStationState};
use profivac_client::Defects;
use profivac_client::cyclic::{CyclicSlave, CyclicValues, IntegerRange};
use profivac_client::names::NamedParameter;
use profivac_devices::profile::ExceptionStatus;
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::HandlerState;
use profivac_host::session::{BusMaster, BusSession};
use profivac_recorder::validity::{self, MAX_SILENCE};
use profivac_recorder::{EventKind, Micros, Quality, Sample};
use profivac_virtual::device_spec::entry;
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
    /// The pressures that its integers show, as the last event about them says it.
    integers: Option<IntegerRange>,
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
            integers: None,
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

    /// Updates a gauge that another master owns from what was observed on the line. Validity and age follow the rules for a polled gauge.
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
                match assumed {
                    Some(assumed) => self.withdraw(assumed, slave.unit.name, &values),
                    None => self.note_integers(recorder, &slave),
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

    /// When a missing gauge is to be searched; `None` for one that was found.
    fn search_due(&self) -> Option<Instant> {
        self.slave.is_none().then_some(self.search_at)
    }

    /// Whether the gauge is missing and is to be searched now. If so, sets the time of the next search.
    pub fn takes_search_turn(&mut self, now: Instant) -> bool {
        let is_due = self.search_due().is_some_and(|due| due <= now);
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
                self.note_integers(recorder, &slave);
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

    /// Records an event if the integers of the slave do not show the whole range of the gauge, once for each range.
    fn note_integers(&mut self, recorder: &RecorderHandle, slave: &CyclicSlave) {
        let range = slave.integer_range();
        if self.integers != range
            && let Some(range) = range
        {
            let text = format!("{}: {range}", self.config.name);
            recorder.event_now(Some(&self.config.name), EventKind::Bus, text);
        }
        self.integers = range;
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
    pub fn sample(&mut self, recorder: &RecorderHandle, master: &mut BusMaster, now: Instant) {
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
    fn withdraw(&mut self, assumed: Assumed, unit: &str, values: &CyclicValues) {
        let pairs = self.readings.iter_mut().zip(&values.values);
        for (reading, _) in pairs.filter(|(reading, value)| assumed.concerns(reading.quality, value.cause)) {
            reading.cause = Some(assumed.cause(reading, unit));
            reading.quality = Quality::Assumed;
            (reading.pa, reading.limit_pa, reading.corrected_pa) = (None, None, None);
        }
        if assumed == Assumed::Configuration {
            self.take_alarms(ExceptionStatus::empty());
            self.warnings.clear();
        }
        let has_fault = self.readings.iter().any(|reading| reading.quality == Quality::Fault);
        self.state =
            if has_fault || !self.alarms.is_empty() { BusStationState::Fault } else { BusStationState::DataExchange };
    }

    /// Other alarms than before: what was known of their defects does not hold any more.
    fn take_alarms(&mut self, alarms: ExceptionStatus) {
        if self.alarms != alarms {
            self.alarms = alarms;
            self.defects = Defects::default();
            self.defects_at = (!alarms.is_empty()).then(Instant::now);
        }
    }

    /// When the defects of a gauge with an alarm are to be read; `None` without an alarm, and for a gauge without DP-V1.
    fn defects_due(&self) -> Option<Instant> {
        self.defects_at.filter(|_| self.slave.is_some_and(|slave| slave.model.features.dpv1))
    }

    /// The slave whose defects are to be read now, if there is one. If so, sets the time of the next reading.
    pub fn takes_defects_turn(&mut self, now: Instant) -> Option<CyclicSlave> {
        let slave = self.slave.filter(|_| self.defects_due().is_some_and(|due| due <= now))?;
        self.defects_at = Some(now + DEFECTS_INTERVAL);
        Some(slave)
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

/// The gauge that takes the next search. One search can take longer than [`SEARCH_INTERVAL`], so the order is the waiting time: with the
/// order of the file two silent gauges would take all turns, and a third would never be searched.
pub fn next_search(gauges: &mut [GaugeSession], now: Instant) -> Option<&mut GaugeSession> {
    let gauge = longest_waiting(gauges, GaugeSession::search_due)?;
    gauge.takes_search_turn(now).then_some(gauge)
}

/// The gauge whose defects are read next, and its slave.
pub fn next_defects(gauges: &mut [GaugeSession], now: Instant) -> Option<(CyclicSlave, &mut GaugeSession)> {
    let gauge = longest_waiting(gauges, GaugeSession::defects_due)?;
    Some((gauge.takes_defects_turn(now)?, gauge))
}

fn longest_waiting(
    gauges: &mut [GaugeSession],
    due: impl Fn(&GaugeSession) -> Option<Instant>,
) -> Option<&mut GaugeSession> {
    let with_due = gauges.iter_mut().filter_map(|gauge| Some((due(gauge)?, gauge)));
    with_due.min_by_key(|(due, _)| *due).map(|(_, gauge)| gauge)
}

/// A gauge of the station's file before anything was heard of it: without data, with the readings of its default configuration.
#[must_use]
pub fn planned_gauge(config: &config::Gauge, segment: &str, listen_only: bool) -> view::Gauge {
    let readings = planned_readings(config);
    // A gauge of another master has none.
    let parameters = if listen_only { Arc::default() } else { planned_parameters(&config.device).into() };
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

/// The time of the system clock `silence` ago.
fn before_now(silence: Duration) -> Micros {
    let micros = i64::try_from(silence.as_micros()).unwrap_or(i64::MAX);
    Micros(Micros::now().0.saturating_sub(micros))
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_client::cyclic::ReportedChannels;
    use profivac_devices::catalog::model_named;
    use profivac_devices::profile::StatusExtension;
    use profivac_recorder::{Recorder, Settings};

    /// Each search takes longer than the interval: all three are due again whenever one ends.
    #[test]
    fn gauges_whose_search_takes_long_are_searched_in_turn() {
        let gauge = |name: &str, address| {
            GaugeSession::new(config::Gauge::plain(name.to_owned(), address, "bcg450".to_owned()))
        };
        let mut gauges = vec![gauge("a", 5), gauge("b", 6), gauge("c", 7)];
        let mut now = Instant::now();
        let mut searched = String::new();
        for _ in 0..6 {
            now += SEARCH_INTERVAL + Duration::from_millis(1);
            searched += &next_search(&mut gauges, now).unwrap().config.name;
        }
        assert_eq!(searched, "abcabc");
        let waiting = now + SEARCH_INTERVAL / 2;
        assert!(gauges.iter_mut().all(|gauge| {
            gauge.search_at = waiting;
            true
        }));
        assert!(next_search(&mut gauges, now).is_none());
    }

    #[test]
    fn the_defects_of_gauges_with_alarms_are_read_in_turn() {
        let slave = |address| {
            let model = model_named("bcg450").unwrap();
            let (configuration, unit) = (&model.configurations[0], model.units.first().unwrap());
            CyclicSlave { address, model, configuration, unit, channels: ReportedChannels::default() }
        };
        let gauge = |name: &str, address| {
            let config = config::Gauge::plain(name.to_owned(), address, "bcg450".to_owned());
            GaugeSession { defects_at: Some(Instant::now()), ..GaugeSession::with_slave(config, slave(address)) }
        };
        let mut gauges = vec![gauge("a", 5), gauge("b", 6)];
        let mut now = Instant::now();
        let mut read = String::new();
        for _ in 0..4 {
            now += DEFECTS_INTERVAL + Duration::from_millis(1);
            read += &next_defects(&mut gauges, now).unwrap().1.config.name;
        }
        assert_eq!(read, "abab");
    }

    /// The number may be a pressure in the true unit, so the gauge has no fault that raises an alarm.
    #[test]
    fn a_number_that_is_no_pressure_in_an_assumed_unit_is_no_fault_of_the_gauge() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let recorder = RecorderHandle::new(Recorder::start(&path, Settings::default()).unwrap(), path);
        let model = model_named("bcg450").unwrap();
        let (configuration, unit) = (&model.configurations[4], model.unit_named("COUNTS").unwrap());
        let slave = CyclicSlave { address: 5, model, configuration, unit, channels: ReportedChannels::default() };
        let heard = |exception: u8, status: u8, assumed| {
            let values = slave.decode_inputs(&[&[0; 8][..], &[exception, status, 2, 0, 0]].concat());
            let mut gauge = GaugeSession::listening(config::Gauge::plain("chamber".to_owned(), 5, "bcg450".to_owned()));
            let (slave, silence, unknown) = (Some(slave), Some(Duration::ZERO), Vec::new());
            gauge.take_heard(&recorder, Heard { slave, values, silence, unknown, assumed, problem: String::new() });
            (gauge.readings[0].quality, gauge.state)
        };
        let invalid = StatusExtension::INVALID.bits();
        for (exception, status, assumed, quality, state) in [
            (0x80, 0, None, Quality::Fault, BusStationState::Fault),
            (0x80, 0, Some(Assumed::Unit), Quality::Assumed, BusStationState::DataExchange),
            // An alarm of the gauge does not depend on the unit.
            (0xA2, invalid, Some(Assumed::Unit), Quality::Fault, BusStationState::Fault),
            (0xA2, 0, Some(Assumed::Unit), Quality::Assumed, BusStationState::Fault),
            (0xA2, invalid, Some(Assumed::Configuration), Quality::Assumed, BusStationState::DataExchange),
        ] {
            assert_eq!(heard(exception, status, assumed), (quality, state), "{exception:02X} {status:02X} {assumed:?}");
        }
    }

    /// A BCG450 with integers in Pascal at 900 mbar: the diaphragm shows 32767.
    #[test]
    fn the_highest_integer_is_recorded_as_a_bound_and_one_event_names_the_limits() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let recorder = RecorderHandle::new(Recorder::start(&path, Settings::default()).unwrap(), path);
        let model = model_named("bcg450").unwrap();
        let (configuration, unit) = (&model.configurations[4], model.unit_named("Pascal").unwrap());
        let slave = CyclicSlave { address: 5, model, configuration, unit, channels: ReportedChannels::default() };
        let values = slave.decode_inputs(&[&[0; 8][..], &[0x80, 0, 3, 0x7F, 0xFF]].concat());
        let config = config::Gauge::plain("chamber".to_owned(), 5, "bcg450".to_owned());
        let mut gauge = GaugeSession::listening(config);
        for _ in 0..3 {
            gauge.take_heard(
                &recorder,
                Heard {
                    slave: Some(slave),
                    values: values.clone(),
                    silence: Some(Duration::ZERO),
                    unknown: Vec::new(),
                    assumed: None,
                    problem: String::new(),
                },
            );
        }
        let reading = &gauge.readings[0];
        assert_eq!((reading.quality, reading.pa, reading.limit_pa), (Quality::Overrange, None, Some(32767.0)));
        let reader = recorder.open_reader().unwrap();
        drop(recorder);
        let samples = reader.samples("chamber", Micros(0), Micros(i64::MAX)).unwrap();
        let is_bound = |sample: &Sample| (sample.quality, sample.pa) == (Quality::Overrange, Some(32767.0));
        assert!(!samples.is_empty() && samples.iter().all(is_bound), "{samples:?}");
        let events = reader.events(Micros(0), Micros(i64::MAX), 100).unwrap();
        let limits = "chamber: its integers in Pascal show 0.01 to 327.67 mbar only";
        assert_eq!(events.iter().filter(|event| event.text.starts_with(limits)).count(), 1, "{events:?}");
    }
}
