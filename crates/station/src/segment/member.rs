//! A gauge of the station on its way into data exchange, and what it shows there.

use crate::config;
use crate::plant::Plant;
use crate::recorder::{EventKind, Micros, Quality, Sample};
use crate::view::{self, Standing};
use profivac_devices::Principle;
use profivac_devices::profile::StatusExtension;
use profivac_dp::master::State;
use profivac_host::live;
use profivac_host::port::PortError;
use profivac_host::tool::{BusMaster, Tool, ToolError};
use profivac_host::watch::{Value, WatchError, Watched};
use profivac_vacuum::Gas;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How long a gauge that was not found is left alone.
const LOOK_AGAIN: Duration = Duration::from_secs(3);

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
            look_at: now,
            sample_at: now,
        }
    }

    /// A gauge that exchanges data already, or will.
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

    /// Whether it was not met yet and the time to look for it has come.
    pub fn wants_to_look(&self) -> bool {
        self.watched.is_none() && self.look_at <= Instant::now()
    }

    /// Looks for the gauge, and takes it if it is there, free, and what the file says.
    pub fn look(&mut self, plant: &Plant, tool: &mut Tool, master: u8) -> Result<(), PortError> {
        self.look_at = Instant::now() + LOOK_AGAIN;
        let address = self.config.address;
        // Quickly, so that an absent gauge costs the others nothing.
        match live::look(tool, address) {
            Ok(Some(seen)) if seen.slave.is_some() => {}
            Ok(_) => {
                self.missing(plant, "nobody answers");
                return Ok(());
            }
            Err(ToolError::Port(error)) => return Err(error),
            Err(error) => {
                self.missing(plant, &error.to_string());
                return Ok(());
            }
        }
        match Watched::find(tool, address, master) {
            Ok(watched) if watched.model.name != self.config.device && !self.is_alike(&watched) => {
                let sentence = format!("it is a {}, the file says {}", watched.model.name, self.config.device);
                self.missing(plant, &sentence);
            }
            Ok(watched) => self.take(plant, tool, watched),
            Err(WatchError::Tool(ToolError::Port(error))) => return Err(error),
            Err(error) => self.missing(plant, &error.to_string()),
        }
        Ok(())
    }

    /// Devices that share an ident number cannot be told apart on the bus.
    fn is_alike(&self, watched: &Watched) -> bool {
        let wanted = profivac_host::instrument::entry(&self.config.device);
        wanted.is_ok_and(|wanted| wanted.model.ident == watched.model.ident)
    }

    fn take(&mut self, plant: &Plant, tool: &mut Tool, watched: Watched) {
        tool.master().remove(self.config.address);
        match tool.master().add(&watched.parameters()) {
            Ok(()) => {
                self.watched = Some(watched);
                self.standing = Standing::Starting;
                self.sample_at = Instant::now();
            }
            Err(error) => self.missing(plant, &error.to_string()),
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
            plant.note(Some(&self.config.name), EventKind::Bus, format!("{}: {sentence}", self.config.name));
            self.trouble = trouble.map(str::to_owned);
        }
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
    pub fn leave(&mut self, tool: &mut Tool) {
        tool.master().remove(self.config.address);
    }

    /// Takes what the gauge shows, if the time for it has come.
    pub fn sample(&mut self, plant: &Plant, master: &BusMaster) {
        let now = Instant::now();
        let Some(watched) = self.watched.filter(|_| self.sample_at <= now) else { return };
        self.sample_at = now + self.config.poll;
        let address = self.config.address;
        let state = master.state(address);
        let trouble = master.trouble(address).map(|trouble| trouble.to_string());
        let reading = master.inputs(address).map(|inputs| watched.reading(inputs));
        match reading {
            Some(reading) => {
                self.exceptions = reading.exceptions().into_iter().map(str::to_owned).collect();
                self.read_at = Some(now);
                self.standing = if self.exceptions.is_empty() { Standing::Exchanging } else { Standing::Faulty };
                self.say(plant, None);
                self.record(plant, &watched, &reading.values);
            }
            None => {
                self.gap(plant);
                let is_there = !matches!(state, None | Some(State::Offline | State::Inactive));
                self.standing = if is_there && trouble.is_none() { Standing::Starting } else { Standing::Missing };
                if trouble.is_some() {
                    self.say(plant, trouble.as_deref());
                }
            }
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
        let facts = watched.model.ranges.iter().find(|facts| facts.part.instance == value.instance);
        let principle = facts.map(|facts| facts.part.principle);
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
            age_ms: self.read_at.map(|at| u64::try_from(at.elapsed().as_millis()).unwrap_or(u64::MAX)),
            poll_ms: u64::try_from(self.config.poll.as_millis()).unwrap_or(u64::MAX),
        }
    }
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
