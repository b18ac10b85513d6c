//! The dashboard of the demonstration: the station's, over the plant in memory.

use super::alarms;
use crate::failure::Failure;
use crate::output::notice;
use profivac_recorder::{Recorder, Settings};
use profivac_station::alarm::AlarmThread;
use profivac_station::auth::rate_limit::{RateLimit, RateLimits};
use profivac_station::auth::{Access, Role};
use profivac_station::segment::DemoSegment;
use profivac_station::server::{Limits, Server, ServerError, Setup};
use profivac_station::services::Services;
use profivac_station::station::StationError;
use profivac_virtual::memory_segment::MemorySegment;
use profivac_virtual::scenario::Scenario;
use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use tempfile::TempDir;

/// Where it is unless somebody says otherwise.
const DEFAULT_ADDRESS: &str = "127.0.0.1:8080";

/// Somewhere else, if somebody has that already.
const ANY_FREE_PORT: &str = "127.0.0.1:0";

/// What its segment is called.
const SEGMENT: &str = "demo";

/// What records, and serves the dashboard.
pub struct Dashboard {
    exhibit: DemoSegment,
    server: Option<Server>,
    _watcher: AlarmThread,
    /// The record of a demonstration ends with it, unless somebody wants to keep it.
    _folder: TempDir,
}

/// What is wanted of it.
pub struct DashboardOptions<'a> {
    /// Whether it is served.
    pub is_served: bool,
    /// Where, if not at the usual place.
    pub listen: Option<SocketAddr>,
    /// Where the record is kept, if it is.
    pub record: Option<&'a Path>,
}

impl Dashboard {
    /// Records `scene`, and serves it at the place that is wanted.
    pub fn open(
        scenario: &Scenario,
        scene: &MemorySegment,
        master: u8,
        wanted: &DashboardOptions<'_>,
    ) -> Result<Self, Failure> {
        if let Some(address) = wanted.listen.filter(|address| !address.ip().is_loopback()) {
            let sentence = format!(
                "the demonstration is for this computer alone: expected an address like {DEFAULT_ADDRESS}, got {address}"
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
        let plant = Arc::new(Services::new(scenario.title.clone(), file, recorder));
        let server = match wanted.listen {
            _ if !wanted.is_served => None,
            Some(address) => Some(serve(&plant, address)?),
            None => Some(serve_at_default(&plant)?),
        };
        let names = |address: u8| {
            let spec = scenario.specs().find(|spec| spec.address == address);
            let device = spec.map(|spec| spec.device.clone()).unwrap_or_default();
            (format!("{device} {address}"), device)
        };
        let rules = alarms::rules(scenario, SEGMENT, names)?;
        plant.alarms().begin(&plant, rules, Vec::new()).map_err(StationError::from)?;
        let _watcher = AlarmThread::start(Arc::clone(&plant))?;
        let exhibit = DemoSegment::new(plant, SEGMENT, scene, master, names);
        Ok(Self { exhibit, server, _watcher, _folder: folder })
    }

    /// Where it is, if it is served.
    pub fn url(&self) -> Option<String> {
        self.server.as_ref().map(|server| format!("http://{}", server.address()))
    }

    /// Takes what is new.
    pub fn update(&mut self, scene: &mut MemorySegment) {
        self.exhibit.run_once(scene);
    }
}

/// Whoever sits here may do everything: nothing of it is real.
fn serve(plant: &Arc<Services>, listen: SocketAddr) -> Result<Server, ServerError> {
    // Who does very much here fills no audit trail that anybody keeps.
    let rate_limits = RateLimits { writes: RateLimit::new(100_000, Duration::from_millis(1)), ..RateLimits::default() };
    let limits = Limits { rate_limits, ..Limits::default() };
    let setup = Setup { limits, ..Setup::new(listen, Access::anonymous("demo", Role::Engineer)) };
    Server::start(Arc::clone(plant), setup)
}

/// At the usual place, or wherever there is room.
fn serve_at_default(plant: &Arc<Services>) -> Result<Server, Failure> {
    let parsed = |text: &str| text.parse().map_err(|_| Failure::usage(format!("{text} is no address")));
    match serve(plant, parsed(DEFAULT_ADDRESS)?) {
        Err(error @ ServerError::Listen { .. }) => {
            notice(&format_args!("{error}; the dashboard is elsewhere"));
            Ok(serve(plant, parsed(ANY_FREE_PORT)?)?)
        }
        done => Ok(done?),
    }
}
