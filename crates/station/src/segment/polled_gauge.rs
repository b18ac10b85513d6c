//! A gauge that the station polls: it brings the gauge into data exchange, samples it, and searches it again when it is missing.

use super::find::FindError;
use super::first_round::FirstRound;
use super::loss::{self, Looked};
use super::moment::{LineMoment, Moment};
use super::readings::readings_of;
use super::shown_gauge::{Exchange, ShownGauge};
use super::watched::{self, Due, WatchedParameters};
use crate::config;
use crate::recording::RecorderHandle;
use crate::view::{self, BusStationState};
use profivac_client::cyclic::CyclicSlave;
use profivac_client::names::NamedParameter;
use profivac_devices::model::Model;
use profivac_devices::profile::ExceptionStatus;
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::HandlerState;
use profivac_host::session::{BusMaster, BusSession};
use profivac_recorder::Micros;
use profivac_recorder::validity::MAX_SILENCE;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The time between two searches for a missing gauge.
pub const SEARCH_INTERVAL: Duration = Duration::from_secs(3);

/// The time between two searches for a gauge without a free MS2 connection, which it will have soon. chosen.
const CONNECTION_INTERVAL: Duration = Duration::from_secs(1);

/// The time between two readings of the defects of a gauge with an alarm: another part may fail, or one be repaired. chosen.
const DEFECTS_INTERVAL: Duration = Duration::from_secs(10);

/// A gauge without data for this time is searched from the beginning: another device may answer at its address.
const SEARCH_AFTER: Duration = Duration::from_secs(5);

/// The longest inputs of a slave: a Data_Exchange answer has up to 244 octets (profibus-wire 2.1).
const MAX_INPUTS: usize = 244;

/// A gauge that the station polls.
pub struct PolledGauge {
    /// What it shows and records.
    pub shown: ShownGauge,
    /// The last data exchange on the line and on the clocks of the station; at first the time of adding the slave.
    exchange: (Option<BitTime>, Moment),
    first_round: FirstRound,
    looked: Looked,
    search_at: Instant,
    sample_at: Instant,
    /// The alarms whose defects are read, and when; `None` without an alarm.
    alarms: ExceptionStatus,
    defects_at: Option<Instant>,
    /// The parameters that gateways show.
    parameters: WatchedParameters,
}

impl PolledGauge {
    /// A gauge that has not been found yet.
    pub fn new(config: config::Gauge, now: Moment) -> Self {
        Self {
            shown: ShownGauge::new(config).lost_since(now.wall),
            exchange: (None, now),
            first_round: FirstRound::begin(now),
            looked: Looked::begin(now),
            search_at: now.at,
            sample_at: now.at,
            alarms: ExceptionStatus::empty(),
            defects_at: None,
            parameters: WatchedParameters::default(),
        }
    }

    /// A gauge whose slave the master already has.
    pub fn with_slave(config: config::Gauge, slave: CyclicSlave, now: Moment) -> Self {
        let shown = ShownGauge::starting(config.clone(), slave).lost_since(now.wall);
        Self { shown, ..Self::new(config, now) }
    }

    /// The same gauge, without readings since this time.
    pub fn lost_since(self, at: Micros) -> Self {
        Self { shown: self.shown.lost_since(at), ..self }
    }

    /// The same slave with another configuration. Under another name it is sampled at once, otherwise after the new interval at the latest.
    pub fn with_config(mut self, recorder: &RecorderHandle, config: config::Gauge, now: Moment) -> Self {
        let is_renamed = self.shown.reconfigure(recorder, config, now);
        let latest = if is_renamed { now.at } else { now.at + self.shown.config.poll };
        self.sample_at = self.sample_at.min(latest);
        self
    }

    /// The port was opened: the gauge is not missed until it was asked.
    pub fn port_opened(&mut self, now: Moment) {
        self.first_round.port_opened(now);
    }

    /// When the gauge needs to be sampled or searched.
    pub const fn due(&self) -> Instant {
        if self.shown.slave.is_some() { self.sample_at } else { self.search_at }
    }

    /// When a missing gauge is to be searched; `None` for one that was found.
    fn search_due(&self) -> Option<Instant> {
        self.shown.slave.is_none().then_some(self.search_at)
    }

    /// Whether the gauge is missing and is to be searched now. If so, sets the time of the next search.
    pub fn takes_search_turn(&mut self, now: Moment) -> bool {
        let is_due = self.search_due().is_some_and(|due| due <= now.at);
        if is_due {
            self.search_at = now.at + SEARCH_INTERVAL;
        }
        is_due
    }

    /// Takes the result of a search that ended `now`: adds the slave to the master, or notes the problem.
    pub fn search_finished(
        &mut self,
        recorder: &RecorderHandle,
        master: &mut BusMaster,
        baud: Baud,
        found: Result<CyclicSlave, FindError>,
        now: Moment,
    ) {
        let added = found.and_then(|slave| {
            master.remove(self.shown.config.address);
            master.add(&slave.parameters(baud))?;
            Ok(slave)
        });
        match added {
            Ok(slave) => {
                self.shown.note_integers(recorder, &slave, now);
                self.shown.slave = Some(slave);
                self.shown.lose(recorder, BusStationState::Starting, now);
                self.sample_at = now.at;
                self.exchange = (None, now);
            }
            Err(error) => {
                self.first_round.end();
                if matches!(error, FindError::NoConnection) {
                    self.search_at = now.at + CONNECTION_INTERVAL;
                }
                self.shown.lose_because(recorder, BusStationState::Missing, Some(error.to_string()), now);
            }
        }
    }

    /// Ends the data exchange because the port is lost, the segment stops or the gauge is removed.
    pub fn disconnect(&mut self, recorder: &RecorderHandle, problem: &str, now: Moment) {
        self.shown.disconnect(recorder, problem, now);
        self.plan_defects(now);
        self.search_at = now.at;
    }

    /// Removes the slave from the master.
    pub fn release(&self, session: &mut BusSession) {
        session.master().remove(self.shown.config.address);
    }

    /// Takes the present reading, if its time has come.
    pub fn sample(&mut self, recorder: &RecorderHandle, master: &mut BusMaster, line: LineMoment) {
        let now = line.now;
        self.parameters.expire(now);
        let has_looked = self.looked.looks(now);
        let Some(slave) = self.shown.slave.filter(|_| self.sample_at <= now.at) else { return };
        self.sample_at = now.at + self.shown.config.poll;
        let address = self.shown.config.address;
        if let Some(at) = master.exchanged_at(address).filter(|at| self.exchange.0 != Some(*at)) {
            self.exchange = (Some(at), line.of(at));
        }
        let read = self.exchange.1;
        let silence = now.since(read);
        match master.inputs(address).filter(|_| silence < MAX_SILENCE) {
            Some(inputs) => {
                self.first_round.end();
                let values = slave.decode_inputs(inputs);
                let exchange = Exchange { slave: &slave, values: &values, read, assumed: None };
                self.shown.take_exchange(recorder, &exchange, now);
                if self.shown.has_measuring_hot_cathode() {
                    self.parameters.emission_is_on(read);
                }
            }
            None => {
                let is_silent = has_looked && self.exchange.0.is_some() && silence >= MAX_SILENCE;
                self.take_no_reading(recorder, master, is_silent, now);
                // It may have a reading soon, however seldom it is sampled.
                self.sample_at = self.sample_at.min(now.at + MAX_SILENCE);
            }
        }
        self.plan_defects(now);
        if silence > SEARCH_AFTER {
            self.first_round.end();
            master.remove(address);
            self.shown.slave = None;
            self.search_at = now.at;
        }
    }

    fn take_no_reading(&mut self, recorder: &RecorderHandle, master: &BusMaster, is_silent: bool, now: Moment) {
        let address = self.shown.config.address;
        let problem = loss::reason(master, address, is_silent).map(|error| error.to_string());
        let is_present = !matches!(master.state(address), None | Some(HandlerState::Offline | HandlerState::Inactive));
        let is_starting = is_present && problem.is_none();
        let state = if is_starting { BusStationState::Starting } else { BusStationState::Missing };
        if problem.is_some() {
            self.first_round.end();
            self.shown.lose_because(recorder, state, problem, now);
        } else {
            self.shown.lose(recorder, state, now);
        }
    }

    /// Other alarms than before have other defects.
    fn plan_defects(&mut self, now: Moment) {
        let alarms = self.shown.alarms();
        if self.alarms != alarms {
            self.alarms = alarms;
            self.defects_at = (!alarms.is_empty()).then_some(now.at);
        }
    }

    /// When the defects of a gauge with an alarm are to be read; `None` without an alarm, and for a gauge without DP-V1.
    fn defects_due(&self) -> Option<Instant> {
        self.defects_at.filter(|_| self.shown.slave.is_some_and(|slave| slave.model.features.dpv1))
    }

    /// The slave whose defects are to be read now, if there is one. If so, sets the time of the next reading.
    fn takes_defects_turn(&mut self, now: Moment) -> Option<CyclicSlave> {
        let slave = self.shown.slave.filter(|_| self.defects_due().is_some_and(|due| due <= now.at))?;
        self.defects_at = Some(now.at + DEFECTS_INTERVAL);
        Some(slave)
    }

    /// When the next parameter is to be read for gateways; `None` for a gauge that does not exchange data.
    fn parameter_due(&mut self, now: Moment) -> Option<Due> {
        let slave = self.shown.slave?;
        if !matches!(self.shown.state(), BusStationState::DataExchange | BusStationState::Fault) {
            return None;
        }
        self.parameters.found(slave.model, now.at);
        self.parameters.due()
    }

    /// Takes the value of a parameter; `None` if the gauge did not give one.
    pub fn take_parameter(&mut self, parameter: &NamedParameter, value: Option<view::WatchedParameter>, now: Moment) {
        self.parameters.take(parameter, value, now);
    }

    /// An operation of the station has written `target`, and may have changed all its parameters.
    pub fn parameters_changed(&mut self, target: &NamedParameter, now: Moment) {
        self.parameters.changed(target, now);
    }

    /// The gauge as the API shows it.
    pub fn view_at(&self, segment: &str, now: Moment) -> view::Gauge {
        let is_awaited = self.first_round.is_awaited(now);
        view::Gauge { parameters: self.parameters.values(), is_awaited, ..self.shown.view_at(segment, now) }
    }
}

/// The gauge that takes the next search. One search can take longer than [`SEARCH_INTERVAL`], so the order is the waiting time: with the
/// order of the file two silent gauges would take all turns, and a third would never be searched.
pub fn next_search(gauges: &mut [PolledGauge], now: Moment) -> Option<&mut PolledGauge> {
    let gauge = longest_waiting(gauges, |gauge| gauge.search_due())?;
    gauge.takes_search_turn(now).then_some(gauge)
}

/// The gauge whose defects are read next, and its slave.
pub fn next_defects(gauges: &mut [PolledGauge], now: Moment) -> Option<(CyclicSlave, &mut PolledGauge)> {
    let gauge = longest_waiting(gauges, |gauge| gauge.defects_due())?;
    Some((gauge.takes_defects_turn(now)?, gauge))
}

/// The parameter that has waited longest for its reading, and its slave. Sets the time of its next reading.
pub fn next_parameter(gauges: &mut [PolledGauge], now: Moment) -> Option<(CyclicSlave, &'static NamedParameter)> {
    let gauge = longest_waiting(gauges, |gauge| gauge.parameter_due(now))?;
    Some((gauge.shown.slave?, gauge.parameters.takes_turn(now.at)?))
}

fn longest_waiting<D: Copy + Ord>(
    gauges: &mut [PolledGauge],
    due: impl Fn(&mut PolledGauge) -> Option<D>,
) -> Option<&mut PolledGauge> {
    let with_due = gauges.iter_mut().filter_map(|gauge| Some((due(gauge)?, gauge)));
    with_due.min_by_key(|(due, _)| *due).map(|(_, gauge)| gauge)
}

/// A gauge of the station's file before anything was heard of it: without data, with the readings of its default configuration.
#[must_use]
pub fn planned_gauge(config: &config::Gauge, segment: &str, listen_only: bool) -> view::Gauge {
    let readings = planned_readings(config);
    // A gauge of another master has none.
    let parameters = if listen_only { Arc::default() } else { planned_parameters(config.device).into() };
    view::Gauge { readings, parameters, listen_only, ..ShownGauge::new(config.clone()).view(segment) }
}

/// The parameters of a device that gateways show, without values.
#[must_use]
pub fn planned_parameters(device: &'static Model) -> Vec<view::WatchedParameter> {
    watched::planned(device)
}

/// The readings of a gauge in its configuration, without values.
#[must_use]
pub fn planned_readings(config: &config::Gauge) -> Vec<view::Reading> {
    let model = config.device;
    let Some(unit) = config.unit.or_else(|| model.units.first()) else { return Vec::new() };
    let configuration = config.configuration.unwrap_or(model.default_configuration);
    let slave = CyclicSlave { address: config.address, model, configuration, unit, channels: Default::default() };
    readings_of(config, &slave, &slave.decode_inputs(&[0; MAX_INPUTS]), MAX_SILENCE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_client::cyclic::ReportedChannels;
    use profivac_devices::catalog::model_named;

    fn moment() -> Moment {
        Moment { at: Instant::now(), wall: Micros(0) }
    }

    /// Each search takes longer than the interval: all three are due again whenever one ends.
    #[test]
    fn gauges_whose_search_takes_long_are_searched_in_turn() {
        let mut now = moment();
        let gauge = |name: &str, address| {
            PolledGauge::new(config::Gauge::plain(name.to_owned(), address, model_named("bcg450").unwrap()), now)
        };
        let mut gauges = vec![gauge("a", 5), gauge("b", 6), gauge("c", 7)];
        let mut searched = String::new();
        for _ in 0..6 {
            now.at += SEARCH_INTERVAL + Duration::from_millis(1);
            searched += &next_search(&mut gauges, now).unwrap().shown.config.name;
        }
        assert_eq!(searched, "abcabc");
        let waiting = now.at + SEARCH_INTERVAL / 2;
        assert!(gauges.iter_mut().all(|gauge| {
            gauge.search_at = waiting;
            true
        }));
        assert!(next_search(&mut gauges, now).is_none());
    }

    #[test]
    fn the_defects_of_gauges_with_alarms_are_read_in_turn() {
        let mut now = moment();
        let slave = |address| {
            let model = model_named("bcg450").unwrap();
            let (configuration, unit) = (&model.configurations[0], model.units.first().unwrap());
            CyclicSlave { address, model, configuration, unit, channels: ReportedChannels::default() }
        };
        let gauge = |name: &str, address| {
            let config = config::Gauge::plain(name.to_owned(), address, model_named("bcg450").unwrap());
            PolledGauge { defects_at: Some(now.at), ..PolledGauge::with_slave(config, slave(address), now) }
        };
        let mut gauges = vec![gauge("a", 5), gauge("b", 6)];
        let mut read = String::new();
        for _ in 0..4 {
            now.at += DEFECTS_INTERVAL + Duration::from_millis(1);
            read += &next_defects(&mut gauges, now).unwrap().1.shown.config.name;
        }
        assert_eq!(read, "abab");
    }
}
