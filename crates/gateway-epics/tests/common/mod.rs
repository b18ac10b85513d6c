//! A plant whose readings a test sets.

#![allow(dead_code, reason = "each test program uses a part")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests are tests")]

use profivac_gateway::model::Modeller;
use profivac_gateway::{Inputs, Snapshot};
use profivac_gateway_epics::database::{Database, World, held};
use profivac_recorder::{Micros, Quality};
use profivac_station::config::Config;
use profivac_station::config::gateways::GatewaySettings;
use profivac_station::config::gateways::epics::Settings;
use profivac_station::directory::GaugeLabels;
use profivac_station::view::BusStationState;
use std::path::Path;
use std::sync::Arc;

const FILE: &str = r#"
[[segment]]
name = "hall"
port = "/dev/ttyUSB0"

[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"

[[segment.gauge]]
name = "fore line"
address = 6
device = "tpg300"

[[segment]]
name = "model"
port = "sim:model.toml"

[[segment.gauge]]
name = "copy"
address = 5
device = "bcg450"

[[alarm]]
name = "Chamber high"
gauge = "chamber"
above = "1e-3 mbar"
priority = "high"

[[alarm]]
name = "Chamber not pumped"
gauge = "chamber"
above = "1e-4 mbar"
priority = "low"
"#;

/// The plant with `[epics]` and this text in it.
pub fn config(epics: &str) -> (Config, Settings) {
    parsed(&format!("{FILE}\n[epics]\n{epics}"))
}

/// The plant of a file with a table `[epics]`.
pub fn parsed(file: &str) -> (Config, Settings) {
    let config = profivac_config::parse(file, Path::new("plant.toml")).unwrap();
    let [GatewaySettings::Epics(settings)] = &config.gateways[..] else { panic!("one gateway") };
    let settings = settings.clone();
    (config, settings)
}

/// A running plant.
pub struct Plant {
    modeller: Modeller,
    inputs: Inputs,
    station: String,
    pub settings: Settings,
    world: Option<World>,
    now: i64,
}

impl Plant {
    /// With `[epics]` and this text in it; no gauge has been read.
    pub fn new(epics: &str) -> Self {
        let (config, settings) = config(epics);
        let inputs = Inputs::planned(&config);
        Self { modeller: Modeller::default(), inputs, station: config.name, settings, world: None, now: 1_000_000_000 }
    }

    /// Gives each parameter of a gauge this number.
    pub fn reads_parameters(&mut self, gauge: &str, number: f64) {
        let gauge = self.inputs.gauges.iter_mut().find(|it| it.name == gauge).unwrap();
        for parameter in Arc::make_mut(&mut gauge.parameters) {
            (parameter.number, parameter.quality, parameter.read_at) = (Some(number), Quality::Valid, Some(Micros(1)));
        }
    }

    /// Sets the reading of a gauge.
    pub fn reads(&mut self, gauge: &str, quality: Quality, pa: Option<f64>, read_at: i64) {
        let gauge = self.inputs.gauges.iter_mut().find(|it| it.name == gauge).unwrap();
        gauge.state = BusStationState::DataExchange;
        (gauge.age_ms, gauge.read_at) = (Some(10), Some(Micros(read_at)));
        let reading = &mut gauge.readings[0];
        (reading.quality, reading.pa, reading.limit_pa) = (quality, None, None);
        match quality {
            Quality::Valid => reading.pa = pa,
            _ => reading.limit_pa = pa,
        }
    }

    /// Gives a gauge a label of each kind.
    pub fn labels(&mut self, gauge: &str) {
        let text = |text: &str| Some(text.to_owned());
        let labels = GaugeLabels {
            group: text("hall 2"),
            tags: vec!["beam".to_owned()],
            location: text("rack 4"),
            calibrated: text("2026-05-01"),
            calibration_due: text("2027-05-01"),
        };
        Arc::make_mut(&mut self.inputs.directory).gauges.insert(gauge.to_owned(), labels);
    }

    /// Lets a gauge disappear.
    pub fn loses(&mut self, gauge: &str) {
        let gauge = self.inputs.gauges.iter_mut().find(|it| it.name == gauge).unwrap();
        gauge.state = BusStationState::Missing;
        gauge.age_ms = Some(gauge.stale_after_ms + 1);
    }

    /// The station decides at this time that a gauge has no readings, for this reason.
    pub fn decides(&mut self, gauge: &str, state: BusStationState, lost_at: i64) {
        let gauge = self.inputs.gauges.iter_mut().find(|it| it.name == gauge).unwrap();
        (gauge.state, gauge.lost_at) = (state, Some(Micros(lost_at)));
        let reading = &mut gauge.readings[0];
        (reading.quality, reading.pa, reading.limit_pa) = (Quality::Stale, None, None);
    }

    /// Sets the limit of the alarm "Chamber high" in Pa, as after a change of the file.
    pub fn limit(&mut self, pa: f64) {
        self.inputs.alarms.iter_mut().find(|alarm| alarm.name == "Chamber high").unwrap().limit = Some(pa);
    }

    /// Gives the alarm "Chamber high" an occurrence.
    pub fn occurs(&mut self, occurrence: i64) {
        self.inputs.alarms.iter_mut().find(|alarm| alarm.name == "Chamber high").unwrap().occurrence = occurrence;
    }

    /// Removes a gauge, as after a change of the file.
    pub fn removes(&mut self, gauge: &str) {
        self.inputs.gauges.retain(|it| it.name != gauge);
    }

    fn snapshot(&mut self) -> Arc<Snapshot> {
        self.now += 100_000;
        Arc::new(self.modeller.next(self.inputs.clone(), Micros(self.now)))
    }

    /// The present records and values.
    pub fn world(&mut self) -> World {
        let snapshot = self.snapshot();
        let old = self.world.take();
        let same = old.as_ref().filter(|old| snapshot.has_points_of(&old.snapshot));
        let database = match same {
            Some(old) => Arc::clone(&old.database),
            None => Arc::new(Database::new(&self.station, &snapshot, &self.settings).unwrap()),
        };
        let before = old.as_ref().map(|old| Arc::clone(&old.held)).unwrap_or_default();
        let held = held(&before, &snapshot, same.is_some(), &self.settings);
        let world = World { database, snapshot, held };
        self.world = Some(world.clone());
        world
    }
}
