//! The dashboard of the demonstration: the station's, over the plant in memory.

use super::alarms;
use crate::failure::Failure;
use crate::output::remark;
use profivac_recorder::{Recorder, Settings};
use profivac_station::alarm::Watcher;
use profivac_station::people::rates::{Pace, Paces};
use profivac_station::people::{Access, Role};
use profivac_station::plant::Plant;
use profivac_station::segment::Exhibit;
use profivac_station::server::{Limits, Server, ServerError, Setup};
use profivac_station::station::StationError;
use profivac_virtual::scenario::Scenario;
use profivac_virtual::scene::Scene;
use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use tempfile::TempDir;

/// Where it is unless somebody says otherwise.
const USUAL: &str = "127.0.0.1:8080";

/// Somewhere else, if somebody has that already.
const ANYWHERE: &str = "127.0.0.1:0";

/// What its segment is called.
const SEGMENT: &str = "demo";

/// What records, and serves the dashboard.
pub struct Dashboard {
    exhibit: Exhibit,
    server: Option<Server>,
    _watcher: Watcher,
    /// The record of a demonstration ends with it, unless somebody wants to keep it.
    _folder: TempDir,
}

/// What is wanted of it.
pub struct Wanted<'a> {
    /// Whether it is served.
    pub is_served: bool,
    /// Where, if not at the usual place.
    pub listen: Option<SocketAddr>,
    /// Where the record is kept, if it is.
    pub record: Option<&'a Path>,
}

impl Dashboard {
    /// Records `scene`, and serves it at the place that is wanted.
    pub fn open(scenario: &Scenario, scene: &Scene, master: u8, wanted: &Wanted<'_>) -> Result<Self, Failure> {
        if let Some(address) = wanted.listen.filter(|address| !address.ip().is_loopback()) {
            let sentence = format!(
                "the demonstration is for this computer alone: expected an address like {USUAL}, got {address}"
            );
            return Err(Failure::usage(sentence));
        }
        let folder = tempfile::tempdir()?;
        let file = wanted.record.map_or_else(|| folder.path().join("demo.db"), Path::to_owned);
        if file.exists() {
            // What is in it may have been measured.
            return Err(Failure::usage(format!(
                "{} is there already; a demonstration begins a new record",
                file.display()
            )));
        }
        let recorder = Recorder::start(&file, Settings::default()).map_err(StationError::from)?;
        let plant = Arc::new(Plant::new(scenario.title.clone(), file, recorder));
        let server = match wanted.listen {
            _ if !wanted.is_served => None,
            Some(address) => Some(serve(&plant, address)?),
            None => Some(usual(&plant)?),
        };
        let names = |address: u8| {
            let spec = scenario.specs().find(|spec| spec.place == address);
            let device = spec.map(|spec| spec.device.clone()).unwrap_or_default();
            (format!("{device} {address}"), device)
        };
        let rules = alarms::rules(scenario, SEGMENT, names)?;
        plant.alarms().begin(&plant, rules, Vec::new()).map_err(StationError::from)?;
        let _watcher = Watcher::start(Arc::clone(&plant))?;
        let exhibit = Exhibit::new(plant, SEGMENT, scene, master, names);
        Ok(Self { exhibit, server, _watcher, _folder: folder })
    }

    /// Where it is, if it is served.
    pub fn url(&self) -> Option<String> {
        self.server.as_ref().map(|server| format!("http://{}", server.address()))
    }

    /// Takes what is new.
    pub fn look(&mut self, scene: &mut Scene) {
        self.exhibit.look(scene);
    }
}

/// Whoever sits here may do everything: nothing of it is real.
fn serve(plant: &Arc<Plant>, listen: SocketAddr) -> Result<Server, ServerError> {
    // Who does very much here fills no audit trail that anybody keeps.
    let paces = Paces { acts: Pace::new(100_000, Duration::from_millis(1)), ..Paces::default() };
    let limits = Limits { paces, ..Limits::default() };
    let setup = Setup { limits, ..Setup::new(listen, Access::everybody("demo", Role::Engineer)) };
    Server::start(Arc::clone(plant), setup)
}

/// At the usual place, or wherever there is room.
fn usual(plant: &Arc<Plant>) -> Result<Server, Failure> {
    let parsed = |text: &str| text.parse().map_err(|_| Failure::usage(format!("{text} is no address")));
    match serve(plant, parsed(USUAL)?) {
        Err(error @ ServerError::Listen { .. }) => {
            remark(&format_args!("{error}; the dashboard is elsewhere"));
            Ok(serve(plant, parsed(ANYWHERE)?)?)
        }
        done => Ok(done?),
    }
}
