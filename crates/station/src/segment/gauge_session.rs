//! A gauge of the station on its way into data exchange, and what it shows there.

use crate::config;
use crate::services::Services;
use crate::view::{self, BusStationState};
use profivac_client::cyclic::{ChannelValue, CyclicSlave, CyclicValues};
use profivac_client::discover::CyclicError;
use profivac_devices::Principle;
use profivac_devices::profile::StatusExtension;
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::HandlerState;
use profivac_host::port::PortError;
use profivac_host::scan;
use profivac_host::session::{BusMaster, BusSession, SessionError};
use profivac_recorder::{EventKind, Micros, Quality, Sample};
use profivac_vacuum::Gas;
use profivac_virtual::device_spec::entry;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How long a gauge that was not found is left alone.
const SEARCH_INTERVAL: Duration = Duration::from_secs(3);

/// A gauge whose data do not come for so long shows nothing any more, whatever it showed last: another master may have the line.
const STALE_AFTER: Duration = Duration::from_secs(1);

/// A gauge that is silent for so long is looked for from the beginning.
const SEARCH_AFTER: Duration = Duration::from_secs(5);

/// From 1 to 100 Pa the factors of a Pirani hold; below 0.1 Pa those of an ion gauge: BCG450 manual, page 54.
const PIRANI_PA: (f64, f64) = (1.0, 100.0);
const ION_PA: f64 = 0.1;

/// A gauge.
pub struct GaugeSession {
    /// What the file says.
    pub config: config::Gauge,
    /// What it is, once it was met.
    pub watched: Option<CyclicSlave>,
    standing: BusStationState,
    trouble: Option<String>,
    exceptions: Vec<String>,
    readings: Vec<view::Reading>,
    /// Series that were recorded and are not in a gap.
    recorded: Vec<Arc<str>>,
    read_at: Option<Instant>,
    /// When its last data came, on the bus and on our clock; at first when it was taken.
    last_exchange: (Option<BitTime>, Instant),
    search_at: Instant,
    sample_at: Instant,
}

impl GaugeSession {
    /// A gauge that nothing is known of.
    pub fn new(config: config::Gauge) -> Self {
        let now = Instant::now();
        Self {
            config,
            watched: None,
            standing: BusStationState::Missing,
            trouble: None,
            exceptions: Vec::new(),
            readings: Vec::new(),
            recorded: Vec::new(),
            read_at: None,
            last_exchange: (None, now),
            search_at: now,
            sample_at: now,
        }
    }

    /// A gauge that its master has already.
    pub fn known(config: config::Gauge, watched: CyclicSlave) -> Self {
        Self { watched: Some(watched), standing: BusStationState::Starting, ..Self::new(config) }
    }

    /// The same slave under what the file says now.
    pub fn with_config(mut self, config: config::Gauge) -> Self {
        self.config = config;
        self
    }

    /// When there is something to do.
    pub fn due(&self) -> Instant {
        if self.watched.is_some() { self.sample_at } else { self.search_at }
    }

    /// Whether it was not met yet and the time to look for it has come. If so, the next time is later.
    pub fn takes_search_turn(&mut self) -> bool {
        let now = Instant::now();
        let looks = self.watched.is_none() && self.search_at <= now;
        if looks {
            self.search_at = now + SEARCH_INTERVAL;
        }
        looks
    }

    /// What came of looking for it: it is taken, or there is a reason.
    pub fn search_finished(
        &mut self,
        plant: &Services,
        master: &mut BusMaster,
        baud: Baud,
        met: Result<CyclicSlave, String>,
    ) {
        let taken = met.and_then(|watched| {
            master.remove(self.config.address);
            master.add(&watched.parameters(baud)).map_err(|error| error.to_string())?;
            Ok(watched)
        });
        match taken {
            Ok(watched) => {
                let now = Instant::now();
                self.watched = Some(watched);
                self.standing = BusStationState::Starting;
                self.sample_at = now;
                self.last_exchange = (None, now);
            }
            Err(sentence) => self.missing(plant, &sentence),
        }
    }

    /// It is not there, and why.
    fn missing(&mut self, plant: &Services, sentence: &str) {
        self.standing = BusStationState::Missing;
        self.note_fault(plant, Some(sentence));
    }

    /// Notes a trouble, or its end, once.
    fn note_fault(&mut self, plant: &Services, trouble: Option<&str>) {
        if self.trouble.as_deref() != trouble {
            let sentence = trouble.unwrap_or("it exchanges data");
            plant.record_event(Some(&self.config.name), EventKind::Bus, format!("{}: {sentence}", self.config.name));
            self.trouble = trouble.map(str::to_owned);
        }
    }

    /// It was silent for long: what is there when somebody answers again may be another device, or show another unit.
    fn forget(&mut self, master: &mut BusMaster) {
        master.remove(self.config.address);
        self.watched = None;
        self.search_at = Instant::now();
    }

    /// The line is gone, or the gauge is to be forgotten.
    pub fn disconnect(&mut self, plant: &Services, sentence: &str) {
        self.gap(plant);
        self.watched = None;
        self.standing = BusStationState::Missing;
        self.trouble = Some(sentence.to_owned());
        self.search_at = Instant::now();
    }

    /// Gives the slave back.
    pub fn release(&mut self, tool: &mut BusSession) {
        tool.master().remove(self.config.address);
    }

    /// Takes what the gauge shows, if the time for it has come.
    pub fn sample(&mut self, plant: &Services, master: &mut BusMaster) {
        let now = Instant::now();
        let Some(watched) = self.watched.filter(|_| self.sample_at <= now) else { return };
        self.sample_at = now + self.config.poll;
        let address = self.config.address;
        let exchanged_at = master.exchanged_at(address);
        if exchanged_at.is_some() && exchanged_at != self.last_exchange.0 {
            self.last_exchange = (exchanged_at, now);
        }
        let silent = now.saturating_duration_since(self.last_exchange.1);
        match master.inputs(address).filter(|_| silent < STALE_AFTER) {
            Some(inputs) => self.take_reading(plant, &watched, &watched.decode_inputs(inputs)),
            None => self.take_no_reading(plant, master),
        }
        if silent > SEARCH_AFTER {
            self.forget(master);
        }
    }

    fn take_reading(&mut self, plant: &Services, watched: &CyclicSlave, reading: &CyclicValues) {
        self.exceptions = reading.exceptions().into_iter().map(str::to_owned).collect();
        self.read_at = Some(self.last_exchange.1);
        self.standing = if self.exceptions.is_empty() { BusStationState::Exchanging } else { BusStationState::Faulty };
        self.note_fault(plant, None);
        self.record(plant, watched, &reading.values);
    }

    fn take_no_reading(&mut self, plant: &Services, master: &BusMaster) {
        self.gap(plant);
        let address = self.config.address;
        let trouble = master.exchange_error(address).map(|trouble| trouble.to_string());
        let is_there = !matches!(master.state(address), None | Some(HandlerState::Offline | HandlerState::Inactive));
        self.standing =
            if is_there && trouble.is_none() { BusStationState::Starting } else { BusStationState::Missing };
        if trouble.is_some() {
            self.note_fault(plant, trouble.as_deref());
        }
    }

    fn record(&mut self, plant: &Services, watched: &CyclicSlave, values: &[ChannelValue]) {
        let at = Micros::now();
        let alone = values.len() == 1;
        self.readings = values.iter().map(|value| self.reading(watched, value, alone)).collect();
        self.recorded.clear();
        for (reading, value) in self.readings.iter().zip(values) {
            let series: Arc<str> = Arc::from(reading.series.as_str());
            plant.recorder().push(&series, Sample::new(at, reading.pa, quality(value)));
            self.recorded.push(series);
        }
    }

    fn reading(&self, watched: &CyclicSlave, value: &ChannelValue, alone: bool) -> view::Reading {
        // Nothing for a channel of a TPG300 or TPG500: it tells nobody which gauge it has.
        let principle = watched.principle(value.instance);
        let name = &self.config.name;
        view::Reading {
            series: if alone { name.clone() } else { format!("{name}.{}", value.instance) },
            instance: value.instance,
            principle: principle.map(word),
            pa: value.pa,
            corrected_pa: value.pa.and_then(|pa| corrected(pa, principle?, self.config.gas)),
            quality: quality(value).word(),
        }
    }

    /// Nothing is heard any more.
    fn gap(&mut self, plant: &Services) {
        let at = Micros::now();
        for series in self.recorded.drain(..) {
            plant.recorder().push(&series, Sample::gap(at));
        }
        for reading in &mut self.readings {
            reading.pa = None;
            reading.corrected_pa = None;
            reading.quality = Quality::Gap.word();
        }
        self.exceptions.clear();
    }

    /// What the bus map shows.
    pub fn bus_station(&self) -> view::BusStation {
        let words = match (&self.trouble, self.standing) {
            (Some(trouble), _) => trouble.clone(),
            (None, BusStationState::Exchanging) => "exchanges data".to_owned(),
            (None, BusStationState::Faulty) => self.exceptions.join(", "),
            (None, _) => "is being brought into data exchange".to_owned(),
        };
        view::BusStation {
            address: self.config.address,
            standing: self.standing,
            name: Some(self.config.name.clone()),
            device: Some(self.config.device.clone()),
            ident: self.watched.map(|watched| format!("0x{:04X}", watched.model.ident)),
            words,
        }
    }

    /// What the dashboard shows.
    pub fn gauge(&self, segment: &str) -> view::Gauge {
        let levels = self.config.levels.iter();
        view::Gauge {
            name: self.config.name.clone(),
            segment: segment.to_owned(),
            address: self.config.address,
            device: self.config.device.clone(),
            standing: self.standing,
            trouble: self.trouble.clone(),
            exceptions: self.exceptions.clone(),
            gas: self.config.gas.to_string(),
            levels: levels.map(|(name, level)| view::PressureLevel { name: name.clone(), pa: level.pa() }).collect(),
            readings: self.readings.clone(),
            age_ms: self.read_at.map(|at| view::duration_ms(at.elapsed())),
            poll_ms: view::duration_ms(self.config.poll),
        }
    }
}

/// Looks for the gauge at its address, and finds it if it is there, free, and what the file says; or else says why not.
pub fn find_gauge(
    tool: &mut BusSession,
    gauge: &config::Gauge,
    master: u8,
) -> Result<Result<CyclicSlave, String>, PortError> {
    // Quickly: to find somebody takes patience.
    match scan::probe(tool, gauge.address) {
        Ok(Some(seen)) if seen.slave.is_some() => {}
        Ok(_) => return Ok(Err("nobody answers".to_owned())),
        Err(SessionError::Port(error)) => return Err(error),
        Err(error) => return Ok(Err(error.to_string())),
    }
    match CyclicSlave::find(tool, gauge.address, master) {
        Ok(watched) => Ok(as_configured(watched, &gauge.device)),
        Err(CyclicError::Session(SessionError::Port(error))) => Err(error),
        Err(error) => Ok(Err(error.to_string())),
    }
}

/// What was found, as the device that the file says. Devices that share an ident number cannot be told apart on the bus.
fn as_configured(found: CyclicSlave, device: &str) -> Result<CyclicSlave, String> {
    let said = entry(device).map_err(|error| error.to_string())?.model;
    if said.ident != found.model.ident {
        return Err(format!("it is a {}, the file says {device}", found.model.name));
    }
    let configuration = said.configuration(found.configuration.octets).unwrap_or(found.configuration);
    Ok(CyclicSlave { model: said, configuration, unit: said.unit(found.unit.code).unwrap_or(found.unit), ..found })
}

fn quality(value: &ChannelValue) -> Quality {
    match (value.pa, value.status) {
        (Some(_), status) if status.contains(StatusExtension::OVER) => Quality::Overrange,
        (Some(_), status) if status.contains(StatusExtension::UNDER) => Quality::Underrange,
        (Some(_), _) => Quality::Valid,
        (None, _) => Quality::Invalid,
    }
}

const fn word(principle: Principle) -> &'static str {
    match principle {
        Principle::Pirani => "pirani",
        Principle::HotCathode => "hot-cathode",
        Principle::ColdCathode => "cold-cathode",
        Principle::Diaphragm => "diaphragm",
        Principle::Atmosphere => "atmosphere",
    }
}

/// The pressure of a gas at which a sensor that was calibrated for nitrogen indicates `pa`, where the factors hold.
fn corrected(pa: f64, principle: Principle, gas: Gas) -> Option<f64> {
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
    fn factors_are_used_only_where_they_hold() {
        assert_eq!(corrected(10.0, Principle::Pirani, Gas::Ar), Some(17.0));
        assert_eq!(corrected(1e4, Principle::Pirani, Gas::Ar), None);
        assert_eq!(corrected(1e4, Principle::Pirani, Gas::N2), Some(1e4));
        assert_eq!(corrected(1e4, Principle::Diaphragm, Gas::Ar), Some(1e4));
        assert_eq!(corrected(1.0, Principle::HotCathode, Gas::He), None);
        let helium = corrected(1e-4, Principle::HotCathode, Gas::He).unwrap();
        assert!((helium / 5.9e-4 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_value_is_worth_what_its_status_says() {
        let value = |pa, status| quality(&ChannelValue { instance: 1, pa, status });
        assert_eq!(value(Some(1.0), StatusExtension::empty()), Quality::Valid);
        assert_eq!(value(Some(1.0), StatusExtension::OVER), Quality::Overrange);
        assert_eq!(value(Some(1.0), StatusExtension::UNDER), Quality::Underrange);
        assert_eq!(value(None, StatusExtension::INVALID | StatusExtension::OVER), Quality::Invalid);
    }
}
