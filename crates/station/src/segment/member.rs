//! A gauge of the station on its way into data exchange, and what it shows there.

use crate::config;
use crate::plant::Plant;
use crate::view::{self, Standing};
use profivac_client::watch::{Reading, Value, WatchError, Watched};
use profivac_devices::Principle;
use profivac_devices::profile::StatusExtension;
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::State;
use profivac_host::port::PortError;
use profivac_host::scan;
use profivac_host::session::{BusMaster, BusSession, SessionError};
use profivac_recorder::{EventKind, Micros, Quality, Sample};
use profivac_vacuum::Gas;
use profivac_virtual::factory::entry;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How long a gauge that was not found is left alone.
const LOOK_AGAIN: Duration = Duration::from_secs(3);

/// A gauge whose data do not come for so long shows nothing any more, whatever it showed last: another master may have the line.
const STALE: Duration = Duration::from_secs(1);

/// A gauge that is silent for so long is looked for from the beginning.
const SILENT: Duration = Duration::from_secs(5);

/// From 1 to 100 Pa the factors of a Pirani hold; below 0.1 Pa those of an ion gauge: BCG450 manual, page 54.
const PIRANI_PA: (f64, f64) = (1.0, 100.0);
const ION_PA: f64 = 0.1;

/// A gauge.
pub struct Member {
    /// What the file says.
    pub config: config::Gauge,
    /// What it is, once it was met.
    pub watched: Option<Watched>,
    standing: Standing,
    trouble: Option<String>,
    exceptions: Vec<String>,
    readings: Vec<view::Reading>,
    /// Series that were recorded and are not in a gap.
    recorded: Vec<Arc<str>>,
    read_at: Option<Instant>,
    /// When its last data came, on the bus and on our clock; at first when it was taken.
    fresh: (Option<BitTime>, Instant),
    look_at: Instant,
    sample_at: Instant,
}

impl Member {
    /// A gauge that nothing is known of.
    pub fn new(config: config::Gauge) -> Self {
        let now = Instant::now();
        Self {
            config,
            watched: None,
            standing: Standing::Missing,
            trouble: None,
            exceptions: Vec::new(),
            readings: Vec::new(),
            recorded: Vec::new(),
            read_at: None,
            fresh: (None, now),
            look_at: now,
            sample_at: now,
        }
    }

    /// A gauge that its master has already.
    pub fn known(config: config::Gauge, watched: Watched) -> Self {
        Self { watched: Some(watched), standing: Standing::Starting, ..Self::new(config) }
    }

    /// The same slave under what the file says now.
    pub fn renamed(mut self, config: config::Gauge) -> Self {
        self.config = config;
        self
    }

    /// When there is something to do.
    pub fn due(&self) -> Instant {
        if self.watched.is_some() { self.sample_at } else { self.look_at }
    }

    /// Whether it was not met yet and the time to look for it has come. If so, the next time is later.
    pub fn begins_to_look(&mut self) -> bool {
        let now = Instant::now();
        let looks = self.watched.is_none() && self.look_at <= now;
        if looks {
            self.look_at = now + LOOK_AGAIN;
        }
        looks
    }

    /// What came of looking for it: it is taken, or there is a reason.
    pub fn met(&mut self, plant: &Plant, master: &mut BusMaster, baud: Baud, met: Result<Watched, String>) {
        let taken = met.and_then(|watched| {
            master.remove(self.config.address);
            master.add(&watched.parameters(baud)).map_err(|error| error.to_string())?;
            Ok(watched)
        });
        match taken {
            Ok(watched) => {
                let now = Instant::now();
                self.watched = Some(watched);
                self.standing = Standing::Starting;
                self.sample_at = now;
                self.fresh = (None, now);
            }
            Err(sentence) => self.missing(plant, &sentence),
        }
    }

    /// It is not there, and why.
    fn missing(&mut self, plant: &Plant, sentence: &str) {
        self.standing = Standing::Missing;
        self.say(plant, Some(sentence));
    }

    /// Notes a trouble, or its end, once.
    fn say(&mut self, plant: &Plant, trouble: Option<&str>) {
        if self.trouble.as_deref() != trouble {
            let sentence = trouble.unwrap_or("it exchanges data");
            plant.remark(Some(&self.config.name), EventKind::Bus, format!("{}: {sentence}", self.config.name));
            self.trouble = trouble.map(str::to_owned);
        }
    }

    /// It was silent for long: what is there when somebody answers again may be another device, or show another unit.
    fn forget(&mut self, master: &mut BusMaster) {
        master.remove(self.config.address);
        self.watched = None;
        self.look_at = Instant::now();
    }

    /// The line is gone, or the gauge is to be forgotten.
    pub fn lose(&mut self, plant: &Plant, sentence: &str) {
        self.gap(plant);
        self.watched = None;
        self.standing = Standing::Missing;
        self.trouble = Some(sentence.to_owned());
        self.look_at = Instant::now();
    }

    /// Gives the slave back.
    pub fn leave(&mut self, tool: &mut BusSession) {
        tool.master().remove(self.config.address);
    }

    /// Takes what the gauge shows, if the time for it has come.
    pub fn sample(&mut self, plant: &Plant, master: &mut BusMaster) {
        let now = Instant::now();
        let Some(watched) = self.watched.filter(|_| self.sample_at <= now) else { return };
        self.sample_at = now + self.config.poll;
        let address = self.config.address;
        let exchanged_at = master.exchanged_at(address);
        if exchanged_at.is_some() && exchanged_at != self.fresh.0 {
            self.fresh = (exchanged_at, now);
        }
        let silent = now.saturating_duration_since(self.fresh.1);
        match master.inputs(address).filter(|_| silent < STALE) {
            Some(inputs) => self.shows(plant, &watched, &watched.reading(inputs)),
            None => self.shows_nothing(plant, master),
        }
        if silent > SILENT {
            self.forget(master);
        }
    }

    fn shows(&mut self, plant: &Plant, watched: &Watched, reading: &Reading) {
        self.exceptions = reading.exceptions().into_iter().map(str::to_owned).collect();
        self.read_at = Some(self.fresh.1);
        self.standing = if self.exceptions.is_empty() { Standing::Exchanging } else { Standing::Faulty };
        self.say(plant, None);
        self.record(plant, watched, &reading.values);
    }

    fn shows_nothing(&mut self, plant: &Plant, master: &BusMaster) {
        self.gap(plant);
        let address = self.config.address;
        let trouble = master.trouble(address).map(|trouble| trouble.to_string());
        let is_there = !matches!(master.state(address), None | Some(State::Offline | State::Inactive));
        self.standing = if is_there && trouble.is_none() { Standing::Starting } else { Standing::Missing };
        if trouble.is_some() {
            self.say(plant, trouble.as_deref());
        }
    }

    fn record(&mut self, plant: &Plant, watched: &Watched, values: &[Value]) {
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

    fn reading(&self, watched: &Watched, value: &Value, alone: bool) -> view::Reading {
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
    fn gap(&mut self, plant: &Plant) {
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
    pub fn on_bus(&self) -> view::OnBus {
        let words = match (&self.trouble, self.standing) {
            (Some(trouble), _) => trouble.clone(),
            (None, Standing::Exchanging) => "exchanges data".to_owned(),
            (None, Standing::Faulty) => self.exceptions.join(", "),
            (None, _) => "is being brought into data exchange".to_owned(),
        };
        view::OnBus {
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
            levels: levels.map(|(name, level)| view::TripLevel { name: name.clone(), pa: level.pa() }).collect(),
            readings: self.readings.clone(),
            age_ms: self.read_at.map(|at| view::whole_milliseconds(at.elapsed())),
            poll_ms: view::whole_milliseconds(self.config.poll),
        }
    }
}

/// Looks for the gauge at its address, and finds it if it is there, free, and what the file says; or else says why not.
pub fn meet(tool: &mut BusSession, gauge: &config::Gauge, master: u8) -> Result<Result<Watched, String>, PortError> {
    // Quickly: to find somebody takes patience.
    match scan::look(tool, gauge.address) {
        Ok(Some(seen)) if seen.slave.is_some() => {}
        Ok(_) => return Ok(Err("nobody answers".to_owned())),
        Err(SessionError::Port(error)) => return Err(error),
        Err(error) => return Ok(Err(error.to_string())),
    }
    match Watched::find(tool, gauge.address, master) {
        Ok(watched) => Ok(as_said(watched, &gauge.device)),
        Err(WatchError::Tool(SessionError::Port(error))) => Err(error),
        Err(error) => Ok(Err(error.to_string())),
    }
}

/// What was found, as the device that the file says. Devices that share an ident number cannot be told apart on the bus.
fn as_said(found: Watched, device: &str) -> Result<Watched, String> {
    let said = entry(device).map_err(|error| error.to_string())?.model;
    if said.ident != found.model.ident {
        return Err(format!("it is a {}, the file says {device}", found.model.name));
    }
    let configuration = said.configuration(found.configuration.octets).unwrap_or(found.configuration);
    Ok(Watched { model: said, configuration, unit: said.unit(found.unit.code).unwrap_or(found.unit), ..found })
}

fn quality(value: &Value) -> Quality {
    match (value.pa, value.status) {
        (Some(_), status) if status.contains(StatusExtension::OVER) => Quality::Over,
        (Some(_), status) if status.contains(StatusExtension::UNDER) => Quality::Under,
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
        let value = |pa, status| quality(&Value { instance: 1, pa, status });
        assert_eq!(value(Some(1.0), StatusExtension::empty()), Quality::Valid);
        assert_eq!(value(Some(1.0), StatusExtension::OVER), Quality::Over);
        assert_eq!(value(Some(1.0), StatusExtension::UNDER), Quality::Under);
        assert_eq!(value(None, StatusExtension::INVALID | StatusExtension::OVER), Quality::Invalid);
    }
}
