//! What a gauge shows and records, whether the station polls it or hears it.

use super::moment::Moment;
use super::readings::{Assumed, readings_of, state_of};
use crate::config;
use crate::recording::RecorderHandle;
use crate::view::{self, BusStationState};
use profivac_client::Defects;
use profivac_client::cyclic::{CyclicSlave, CyclicValues, IntegerRange};
use profivac_devices::Principle;
use profivac_devices::profile::ExceptionStatus;
use profivac_recorder::validity;
use profivac_recorder::{EventKind, Micros, Quality, Sample};
use std::sync::Arc;
use std::time::Duration;

/// A gauge as it is shown and recorded.
pub struct ShownGauge {
    /// The configuration.
    pub config: config::Gauge,
    /// The slave, once it was found or heard.
    pub slave: Option<CyclicSlave>,
    state: BusStationState,
    problem: Option<String>,
    /// The alarms in Exception Status, and what is known of the defects behind them.
    alarms: ExceptionStatus,
    defects: Defects,
    warnings: Vec<String>,
    readings: Vec<view::Reading>,
    /// The series whose last sample is not a gap.
    recorded: Vec<Arc<str>>,
    /// When the gauge gave the last readings: the time of their data exchange.
    read: Option<Moment>,
    /// When the station decided the present state of a gauge without readings. `None` while it has readings.
    lost_at: Option<Micros>,
    /// The pressures that its integers show, as the last event about them says it.
    integers: Option<IntegerRange>,
}

/// Readings of one data exchange.
pub struct Exchange<'a> {
    pub slave: &'a CyclicSlave,
    pub values: &'a CyclicValues,
    /// When the data were exchanged.
    pub read: Moment,
    /// What the values depend on and no telegram and no user has shown.
    pub assumed: Option<Assumed>,
}

impl ShownGauge {
    /// A gauge of which nothing is known yet.
    pub fn new(config: config::Gauge) -> Self {
        Self {
            config,
            slave: None,
            state: BusStationState::Missing,
            problem: None,
            alarms: ExceptionStatus::empty(),
            defects: Defects::default(),
            warnings: Vec::new(),
            readings: Vec::new(),
            recorded: Vec::new(),
            read: None,
            lost_at: None,
            integers: None,
        }
    }

    /// A gauge whose slave the master already has.
    pub fn starting(config: config::Gauge, slave: CyclicSlave) -> Self {
        Self { slave: Some(slave), state: BusStationState::Starting, ..Self::new(config) }
    }

    /// The same gauge, without readings since this time.
    pub fn lost_since(self, at: Micros) -> Self {
        Self { lost_at: Some(at), ..self }
    }

    /// The alarms that it reports.
    pub const fn alarms(&self) -> ExceptionStatus {
        self.alarms
    }

    /// Whether a hot cathode gives a pressure: the active part, or a part with a reading of its own.
    pub fn has_measuring_hot_cathode(&self) -> bool {
        let is_one = |it: &view::Reading| it.principle == Some(Principle::HotCathode) && it.quality == Quality::Valid;
        self.readings.iter().any(is_one)
    }

    /// The state on the bus.
    pub const fn state(&self) -> BusStationState {
        self.state
    }

    /// Takes and records the readings of a data exchange. One exchange gives one sample, with its time; a reading that becomes another
    /// one without an exchange has the time of this decision.
    pub fn take_exchange(&mut self, recorder: &RecorderHandle, exchange: &Exchange<'_>, now: Moment) {
        let Exchange { slave, values, read, assumed } = *exchange;
        let is_new = self.read.replace(read) != Some(read);
        let was_lost = self.lost_at.take().is_some();
        let before = std::mem::take(&mut self.readings);
        self.slave = Some(*slave);
        self.observe(slave, values, now.since(read));
        match assumed {
            Some(assumed) => self.withdraw(assumed, slave.unit.name, values),
            None => self.note_integers(recorder, slave, now),
        }
        self.note_problem(recorder, None, now);
        match assumed {
            // With another configuration the inputs have other series: none of them is recorded.
            Some(Assumed::Configuration) => self.record_gap(recorder, now.wall),
            _ if is_new => self.record(recorder, read.wall),
            _ if was_lost || self.readings != before => self.record(recorder, now.wall),
            _ => {}
        }
    }

    /// Takes the values of a data exchange that was `silence` ago.
    pub fn observe(&mut self, slave: &CyclicSlave, values: &CyclicValues, silence: Duration) {
        self.take_alarms(values.exception & ExceptionStatus::ALARM);
        self.warnings = values.warnings().into_iter().map(str::to_owned).collect();
        self.state = state_of(values);
        self.readings = readings_of(&self.config, slave, values, silence);
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
        }
    }

    /// Takes the defects that were read. An alarm that ended meanwhile has none.
    pub fn take_defects(&mut self, defects: Defects) {
        if !self.alarms.is_empty() {
            self.defects = defects;
        }
    }

    /// The gauge has no readings: `state` says why. If that is news, the station decides it `now`.
    pub fn lose(&mut self, recorder: &RecorderHandle, state: BusStationState, now: Moment) {
        if self.lost_at.is_none() || self.state != state {
            self.lost_at = Some(now.wall);
        }
        self.state = state;
        self.begin_gap(recorder, now);
    }

    /// The same, for this reason. An event tells one that is new.
    pub fn lose_because(
        &mut self,
        recorder: &RecorderHandle,
        state: BusStationState,
        problem: Option<String>,
        now: Moment,
    ) {
        self.lose(recorder, state, now);
        self.note_problem(recorder, problem, now);
    }

    /// Ends the readings because the port is lost, the segment stops or the gauge is removed. The segment tells the reason in an event.
    pub fn disconnect(&mut self, recorder: &RecorderHandle, problem: &str, now: Moment) {
        self.lose(recorder, BusStationState::Missing, now);
        self.slave = None;
        self.problem = Some(problem.to_owned());
    }

    /// Begins a gap in each recorded series, and shows no pressure.
    fn begin_gap(&mut self, recorder: &RecorderHandle, now: Moment) {
        self.record_gap(recorder, now.wall);
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

    /// Records an event if the integers of the slave do not show the whole range of the gauge, once for each range.
    pub fn note_integers(&mut self, recorder: &RecorderHandle, slave: &CyclicSlave, now: Moment) {
        let range = slave.integer_range();
        if self.integers != range
            && let Some(range) = range
        {
            let text = format!("{}: {range}", self.config.name);
            recorder.event_at(now.wall, Some(&self.config.name), EventKind::Bus, text);
        }
        self.integers = range;
    }

    /// Sets the problem, and records an event if it is another one than before.
    fn note_problem(&mut self, recorder: &RecorderHandle, problem: Option<String>, now: Moment) {
        if self.problem != problem {
            let sentence = problem.as_deref().unwrap_or("in data exchange");
            let text = format!("{}: {sentence}", self.config.name);
            recorder.event_at(now.wall, Some(&self.config.name), EventKind::Bus, text);
            self.problem = problem;
        }
    }

    /// Takes another configuration of the same slave. Returns whether its series have another name: the former ones end with a gap, and
    /// their readings are not shown any more.
    pub fn reconfigure(&mut self, recorder: &RecorderHandle, config: config::Gauge, now: Moment) -> bool {
        let is_renamed = self.config.name != config.name;
        if is_renamed {
            self.record_gap(recorder, now.wall);
            self.readings.clear();
        }
        self.config = config;
        is_renamed
    }

    /// Records a sample of each reading. A series without a reading any more ends with a gap.
    fn record(&mut self, recorder: &RecorderHandle, at: Micros) {
        let present: Vec<Arc<str>> = self.readings.iter().map(|reading| Arc::from(reading.series.as_str())).collect();
        self.recorded.retain(|series| !present.contains(series));
        self.record_gap(recorder, at);
        for (series, reading) in present.iter().zip(&self.readings) {
            recorder.push(series, Sample::new(at, reading.bound_pa(), reading.quality));
        }
        self.recorded = present;
    }

    fn record_gap(&mut self, recorder: &RecorderHandle, at: Micros) {
        for series in self.recorded.drain(..) {
            recorder.push(&series, Sample::gap(at));
        }
    }

    /// The alarms in words: their defects, as far as they are known.
    fn exceptions(&self) -> Vec<String> {
        self.defects.texts(self.alarms)
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
            device: Some(self.config.device.name.to_owned()),
            ident: self.slave.map(|slave| format!("0x{:04X}", slave.model.ident)),
            description,
        }
    }

    /// The gauge as the API shows it at this moment.
    pub fn view_at(&self, segment: &str, now: Moment) -> view::Gauge {
        let age_ms = self.read.map(|read| view::duration_ms(now.since(read)));
        view::Gauge { age_ms, ..self.view(segment) }
    }

    /// The gauge as the API shows it, without an age.
    pub fn view(&self, segment: &str) -> view::Gauge {
        let levels = self.config.levels.iter();
        view::Gauge {
            name: self.config.name.clone(),
            kind: view::GaugeKind::Gauge,
            segment: segment.to_owned(),
            address: self.config.address,
            device: self.config.device.name.to_owned(),
            model: Some(self.config.device),
            vendor: None,
            integers: self.integers.or_else(|| self.config.integer_range()),
            has_dpv1: self.config.device.features.dpv1,
            listen_only: false,
            assumptions: Vec::new(),
            state: self.state,
            problem: self.problem.clone(),
            exceptions: self.exceptions(),
            warnings: self.warnings.clone(),
            gas: self.config.gas.to_string(),
            levels: levels.map(|(name, level)| view::PressureLevel { name: name.clone(), pa: level.pa() }).collect(),
            readings: self.readings.clone(),
            parameters: Arc::default(),
            age_ms: None,
            read_at: self.read.map(|read| read.wall),
            lost_at: self.lost_at,
            is_awaited: false,
            poll_ms: view::duration_ms(self.config.poll),
            stale_after_ms: validity::stale_after_ms(view::duration_ms(self.config.poll)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_client::cyclic::ReportedChannels;
    use profivac_devices::catalog::model_named;
    use profivac_recorder::{Recorder, Settings};
    use std::time::Instant;

    #[test]
    fn each_state_without_readings_has_the_time_at_which_it_began() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let recorder = RecorderHandle::new(Recorder::start(&path, Settings::default()).unwrap(), path);
        let mut gauge = ShownGauge::new(config::Gauge::plain("chamber".to_owned(), 5, model_named("bcg450").unwrap()));
        let at = Instant::now();
        for (second, state, lost_second) in [
            (10, BusStationState::Missing, 10),
            (11, BusStationState::Missing, 10),
            (12, BusStationState::Starting, 12),
            (13, BusStationState::Starting, 12),
            (14, BusStationState::Missing, 14),
        ] {
            gauge.lose(&recorder, state, Moment { at, wall: Micros(second * Micros::SECOND) });
            assert_eq!(gauge.view("hall").lost_at, Some(Micros(lost_second * Micros::SECOND)), "{second} {state:?}");
        }
    }

    #[test]
    fn a_series_that_another_configuration_does_not_have_ends_with_a_gap() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plant.db");
        let recorder = RecorderHandle::new(Recorder::start(&path, Settings::default()).unwrap(), path);
        let model = model_named("tpg300").unwrap();
        let exchanged = |configuration| {
            let (unit, channels) = (model.units.first().unwrap(), ReportedChannels::default());
            let slave = CyclicSlave { address: 5, model, configuration, unit, channels };
            (slave, slave.decode_inputs(&[0; 64]))
        };
        let number = |(_, values): &(CyclicSlave, CyclicValues)| values.values.len();
        // The only reading of a gauge has the name of the gauge.
        let several = model.configurations.iter().map(exchanged).filter(|exchanged| number(exchanged) > 1);
        let (most, least) = (several.clone().max_by_key(number).unwrap(), several.min_by_key(number).unwrap());
        assert!(number(&most) > number(&least));
        let mut gauge = ShownGauge::new(config::Gauge::plain("chamber".to_owned(), 5, model_named("tpg300").unwrap()));
        let begin = Instant::now();
        let mut series = Vec::new();
        for (second, (slave, values)) in (1..).zip([most, least]) {
            let wall = Micros(i64::try_from(second).unwrap() * Micros::SECOND);
            let now = Moment { at: begin + Duration::from_secs(second), wall };
            let exchange = Exchange { slave: &slave, values: &values, read: now, assumed: None };
            gauge.take_exchange(&recorder, &exchange, now);
            series.push(gauge.view("hall").readings.into_iter().map(|reading| reading.series).collect::<Vec<_>>());
        }
        let reader = recorder.open_reader().unwrap();
        drop(recorder);
        for name in &series[0] {
            let last = *reader.samples(name, Micros(0), Micros(i64::MAX)).unwrap().last().unwrap();
            assert_eq!(last.at, Micros(2 * Micros::SECOND), "{name}");
            assert_eq!(last == Sample::gap(last.at), !series[1].contains(name), "{name}: {last:?}");
        }
    }
}
