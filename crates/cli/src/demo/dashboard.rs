//! The dashboard of the demonstration: that of the station, with the services in memory.

use super::pump_down::{PumpDown, is_evacuated};
use super::{alarms, plant};
use crate::failure::Failure;
use crate::output::notice;
use profivac_recorder::{Recorder, Settings};
use profivac_station::alarm::AlarmThread;
use profivac_station::segment::DemoSegment;
use profivac_station::services::Services;
use profivac_station::station::StationError;
use profivac_virtual::memory_segment::MemorySegment;
use profivac_virtual::scenario::{Run, Scenario};
use profivac_web_server::auth::rate_limit::{RateLimit, RateLimits};
use profivac_web_server::auth::{Access, Actor, Role, User};
use profivac_web_server::server::{Limits, Server, ServerError, Setup};
use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use tempfile::TempDir;

/// The default address.
const DEFAULT_ADDRESS: &str = "127.0.0.1:8080";

/// A free port, if the default address is in use.
const ANY_FREE_PORT: &str = "127.0.0.1:0";

/// The name of its segment.
const SEGMENT: &str = "demo";

/// The user of the demonstration, an engineer.
const USER: &str = "demo";

/// Records the demonstration and serves the dashboard.
pub struct Dashboard {
    shown: DemoSegment,
    services: Arc<Services>,
    /// Until the chamber is evacuated.
    pump_down: Option<PumpDown>,
    server: Option<Server>,
    _watcher: AlarmThread,
    /// Contains the database unless --record names a file; deleted at the end.
    _folder: TempDir,
}

/// The options of the dashboard.
pub struct DashboardOptions<'a> {
    /// Whether it is served.
    pub is_served: bool,
    /// The address, if not the default.
    pub listen: Option<SocketAddr>,
    /// The file of the database, if it is kept.
    pub record: Option<&'a Path>,
    /// Whether the chamber is full of air at first, as in the default scenario.
    pub begins_vented: bool,
}

impl Dashboard {
    /// Starts to record the memory segment, and serves the dashboard if the options require it.
    pub fn open(
        scenario: &Scenario,
        segment: &mut MemorySegment,
        master: u8,
        options: &DashboardOptions<'_>,
    ) -> Result<Self, Failure> {
        if let Some(address) = options.listen.filter(|address| !address.ip().is_loopback()) {
            let sentence = format!(
                "expected an address of this computer like {DEFAULT_ADDRESS}, got {address}; the demonstration has no users"
            );
            return Err(Failure::usage(sentence));
        }
        let folder = tempfile::tempdir()?;
        let file = options.record.map_or_else(|| folder.path().join("demo.db"), Path::to_owned);
        if file.exists() {
            // An existing database may contain valid samples.
            return Err(Failure::usage(format!("{} exists already; a demonstration needs a new file", file.display())));
        }
        let recorder = Recorder::start(&file, Settings::default()).map_err(StationError::from)?;
        let services = Arc::new(Services::new(scenario.title.clone(), file, recorder));
        let names = |address: u8| {
            let spec = scenario.specs().find(|spec| spec.address == address);
            let device = spec.map(|spec| spec.device.clone()).unwrap_or_default();
            (format!("{device} {address}"), device)
        };
        let (rules, plant_states) = alarms::rules(scenario, SEGMENT, names)?;
        services.alarms().start(rules, Vec::new()).map_err(StationError::from)?;
        services.alarms().start_plant_states(plant_states).map_err(StationError::from)?;
        let user = Actor { user: User { name: Arc::from(USER), role: Role::Engineer }, peer: None };
        let pump_down = options.begins_vented.then(|| PumpDown::declare(services.alarms(), user)).transpose()?;
        let (snapshots, recorder) = (Arc::clone(services.snapshots()), Arc::clone(services.recorder()));
        let _watcher =
            AlarmThread::start(Arc::clone(services.alarms()), snapshots, recorder, Arc::clone(services.gateways()))?;
        services.plant().set(plant::view(scenario.schematic(), |address| names(address).0));
        let shown = DemoSegment::new(services.for_segments(), SEGMENT, segment, master, names);
        // The gauges are published: the first request finds them.
        let server = match options.listen {
            _ if !options.is_served => None,
            Some(address) => Some(serve(&services, address)?),
            None => Some(serve_at_default(&services)?),
        };
        Ok(Self { shown, services, pump_down, server, _watcher, _folder: folder })
    }

    /// The address of the dashboard, if it is served.
    pub fn url(&self) -> Option<String> {
        self.server.as_ref().map(|server| format!("http://{}", server.address()))
    }

    /// Takes over the new samples, the states of the parts of the plant, and what the scenario tells.
    pub fn update(&mut self, segment: &mut MemorySegment, run: &Run) {
        let plant = self.services.plant();
        plant.report(plant::states(run));
        run.message().into_iter().for_each(|message| plant.tell(message));
        self.shown.run_once(segment);
        let chamber = self.services.snapshots().gauge(alarms::CHAMBER);
        if chamber.is_some_and(|gauge| is_evacuated(&gauge))
            && let Some(pump_down) = self.pump_down.take()
        {
            pump_down.end(self.services.alarms());
        }
    }
}

/// Serves the dashboard; every local user has the engineer role, because no gauge is real.
fn serve(services: &Arc<Services>, listen: SocketAddr) -> Result<Server, ServerError> {
    // No rate limit for commands: the audit trail is deleted at the end.
    let rate_limits = RateLimits { writes: RateLimit::new(100_000, Duration::from_millis(1)), ..RateLimits::default() };
    let limits = Limits { rate_limits, ..Limits::default() };
    let setup = Setup { limits, ..Setup::new(listen, Access::anonymous(USER, Role::Engineer)) };
    profivac_station::server::start(Arc::clone(services), setup)
}

/// Serves at the default address, or at a free port.
fn serve_at_default(services: &Arc<Services>) -> Result<Server, Failure> {
    let parsed = |text: &str| text.parse().map_err(|_| Failure::usage(format!("expected an address, got {text}")));
    match serve(services, parsed(DEFAULT_ADDRESS)?) {
        Err(error @ ServerError::Listen { .. }) => {
            notice(&format_args!("{error}; using a free port"));
            Ok(serve(services, parsed(ANY_FREE_PORT)?)?)
        }
        done => Ok(done?),
    }
}
