//! `profivac run`: runs the station.

use crate::console::{SIGHUP, SIGINT, SIGTERM, Signals};
use crate::explanation::counted;
use crate::failure::Failure;
use crate::gateways::{self, Gateways};
use crate::names;
use crate::output::{notice, out};
use clap::Args;
use profivac_devices::catalog::KnownDevices;
use profivac_host::readiness::wait;
use profivac_recorder::{EventKind, is_in_use};
use profivac_station::config::Config;
use profivac_station::services::Services;
use profivac_station::station::Station;
use profivac_web_server::auth::file_permissions::{self, PermissionError};
use profivac_web_server::server::{Keys, Server, ServerError, Setup};
use std::fmt::Display;
use std::net::{SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Run the station: segments, recorder, alarms and dashboard.
///
/// The file is checked completely before anything starts. The station sets the parameters of its gauges, keeps their units, and releases
/// them at the end; a gauge that is released returns to IDLE, stops measuring and opens its relays. The station waits for missing
/// gauges and reopens lost ports. On SIGHUP it reads the file, certificate and key again; unchanged segments continue. Without
/// users (see `profivac user`) every user of this computer may view the dashboard.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The file that describes the station
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
    /// The address of the dashboard; it overrides the file. Port 0 selects a free port
    #[arg(long, value_name = "HOST:PORT")]
    listen: Option<SocketAddr>,
    /// Only check the file, the files it names (segments in memory, users, certificate, key) and, unless a station runs on the
    /// database, its addresses
    #[arg(long)]
    check: bool,
}

const EXAMPLES: &str = "\
Examples:
  profivac init --port /dev/ttyUSB0 --out plant.toml
  profivac run plant.toml --check
  profivac run plant.toml
  profivac run plant.toml --listen 127.0.0.1:9090
  profivac run plant.toml --listen 0.0.0.0:8443          # with users and [tls], see docs/station.md";

/// The time between two checks of the threads and parts of the station.
const THREAD_CHECK_PERIOD: Duration = Duration::from_secs(1);

/// The time between two attempts to listen on the address of the dashboard.
const LISTEN_PERIOD: Duration = Duration::from_secs(10);

/// Runs until SIGINT or SIGTERM.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let config = profivac_config::read(&arguments.file)?;
    profivac_config::notices(&config).iter().for_each(notice);
    check_private(&arguments.file, &config)?;
    gateways::check(&config.gateways)?;
    names::check(&config)?;
    let listen = arguments.listen.unwrap_or(config.listen);
    let Config { hosts, tls, openid, .. } = config.clone();
    let setup = Setup { hosts, tls, openid, ..Setup::new(listen, config.access()) };
    if arguments.check {
        profivac_config::check_ports(&config)?;
        Server::check(&setup).map_err(|error| server_failure(&config, error))?;
        check_distinct(&addresses(&config, listen))?;
        check_addresses(&config, listen)?;
        let gauges: usize = config.segments.iter().map(|segment| segment.gauges.len()).sum();
        let slaves: usize = config.segments.iter().map(|segment| segment.slaves.len()).sum();
        let (segments, gauges) = (counted(config.segments.len() as u64, "segment"), counted(gauges as u64, "gauge"));
        let slaves = if slaves == 0 { String::new() } else { format!(", {}", counted(slaves as u64, "slave")) };
        out(&format!("{}: {segments}, {gauges}{slaves}", arguments.file.display()));
        return Ok(());
    }
    if let Some(files) = setup.tls.clone() {
        Keys::read(files).map_err(|error| server_failure(&config, error.into()))?;
    }
    let stop = Signals::of(&[SIGINT, SIGTERM])?;
    let mut reload = Signals::of(&[SIGHUP])?;
    let started_with = config.clone();
    let mut devices = config.devices;
    let mut station = Station::start(config)?;
    let mut dashboard = Dashboard::new(setup);
    dashboard.start(&station.services(), Instant::now())?;
    let mut gateways = Gateways::default();
    gateways.apply(&started_with.gateways, &station.services())?;
    loop {
        let readable = wait(&[stop.readiness(), reload.readiness()], THREAD_CHECK_PERIOD)?;
        if readable.first() == Some(&true) {
            break;
        }
        if readable.get(1) == Some(&true) {
            reload.clear();
            dashboard.renew().iter().for_each(|problem| tell(&station, problem));
            let services = station.services();
            // A change in the dashboard comes before or after this one.
            let _held = services.alarm_editor().hold();
            let read = profivac_config::read(&arguments.file).map_err(Failure::from);
            match read.and_then(|config| names::check(&config).map(|()| config)) {
                Ok(config) => {
                    let wanted = config.gateways.clone();
                    devices = apply_config(&mut station, &started_with, devices, config);
                    if let Err(error) = gateways.apply(&wanted, &station.services()) {
                        tell(&station, &error);
                    }
                }
                Err(error) => tell(
                    &station,
                    &format_args!(
                        "the changed file was not taken: {error}; the station keeps the present configuration"
                    ),
                ),
            }
        }
        dashboard.start(&station.services(), Instant::now())?;
        station.restart_ended_threads();
        station.report_stopped_parts().iter().for_each(notice);
    }
    drop(dashboard);
    drop(gateways);
    station.stop().map_err(|error| Failure::no_answer(error.to_string()))
}

/// Prints a notice and records it as an event: who looks at the dashboard does not see the standard error of a service.
fn tell(station: &Station, sentence: &impl Display) {
    notice(sentence);
    station.record_event(&sentence.to_string());
}

/// The server of the dashboard. While its address is taken, the station records without it.
struct Dashboard {
    setup: Setup,
    server: Option<Server>,
    /// The last attempt, if it failed.
    failed: Option<Failed>,
}

/// An attempt to start the server that failed.
struct Failed {
    at: Instant,
    reason: String,
}

impl Dashboard {
    const fn new(setup: Setup) -> Self {
        Self { setup, server: None, failed: None }
    }

    /// Starts the server if it does not run, at most once in [`LISTEN_PERIOD`], and prints that it is ready. A failure to listen is a
    /// notice and an event, once; every other failure of the first attempt ends the program. Later the station records, and no failure of
    /// the dashboard ends it.
    fn start(&mut self, services: &Arc<Services>, now: Instant) -> Result<(), Failure> {
        let is_due =
            self.failed.as_ref().is_none_or(|failed| now.saturating_duration_since(failed.at) >= LISTEN_PERIOD);
        if self.server.is_some() || !is_due {
            return Ok(());
        }
        match profivac_station::server::start(Arc::clone(services), self.setup.clone()) {
            Ok(server) => {
                if self.failed.take().is_some() {
                    services.recorder().event_now(None, EventKind::Station, "the dashboard: the problem is over");
                }
                out(&format!("ready {}", server.url()));
                self.server = Some(server);
            }
            Err(error) if self.failed.is_none() && !matches!(error, ServerError::Listen { .. }) => {
                return Err(error.into());
            }
            Err(error) => {
                let failed = Failed { at: now, reason: error.to_string() };
                if self.failed.as_ref().is_none_or(|before| before.reason != failed.reason) {
                    let text = format!("the dashboard does not run: {error}; the station tries again");
                    notice(&text);
                    services.recorder().event_now(None, EventKind::Station, text);
                }
                self.failed = Some(failed);
            }
        }
        Ok(())
    }

    /// Reads certificate and key again, and returns why that failed.
    fn renew(&self) -> Option<String> {
        let error = self.server.as_ref()?.renew().err()?;
        Some(format!("{error}; the station keeps the present certificate"))
    }
}

/// The failure of a server, which names the line of a wrong TLS file.
fn server_failure(config: &Config, error: ServerError) -> Failure {
    match error {
        ServerError::Tls(error) => {
            let sentence = profivac_config::tls_sentence(config, &error);
            Failure::from(ServerError::Tls(error)).with_sentence(&sentence)
        }
        error => error.into(),
    }
}

/// The parts of the station that listen, and their addresses.
fn addresses(config: &Config, listen: SocketAddr) -> Vec<(String, SocketAddr)> {
    let gateways = config
        .gateways
        .iter()
        .flat_map(|gateway| gateway.listens_on().into_iter().map(|address| (format!("[{}]", gateway.name()), address)));
    std::iter::once(("the dashboard".to_owned(), listen)).chain(gateways).collect()
}

/// Fails if two parts have one address: the second one would not start.
fn check_distinct(parts: &[(String, SocketAddr)]) -> Result<(), Failure> {
    for (number, (part, address)) in parts.iter().enumerate() {
        if let Some((other, taken)) = parts.iter().take(number).find(|(_, taken)| overlap(*taken, *address)) {
            return Err(Failure::usage(format!(
                "{other} listens on {taken} and {part} on {address}; give one of them another port with `listen`"
            )));
        }
    }
    Ok(())
}

/// Whether two parts cannot listen on these addresses together. Port 0 is any free port.
fn overlap(one: SocketAddr, other: SocketAddr) -> bool {
    let is_all = one.ip().is_unspecified() || other.ip().is_unspecified();
    one.port() != 0 && one.port() == other.port() && (one.ip() == other.ip() || is_all)
}

/// Fails if an address of the station cannot be used. A station that runs on the same database has them, so they are not tried then.
fn check_addresses(config: &Config, listen: SocketAddr) -> Result<(), Failure> {
    if is_in_use(&config.database) {
        return Ok(());
    }
    for (part, address) in addresses(config, listen) {
        if let Err(error) = TcpListener::bind(address) {
            return Err(Failure::no_answer(format!(
                "{part} cannot listen on {address}: {error}; end the program that has the address, or change `listen`"
            )));
        }
    }
    Ok(())
}

/// Fails if a file with secrets, or with the names of such files, is readable by others. Any other file and the database, which
/// contains the audit trail, only cause a notice: some sites let others read them on purpose.
fn check_private(file: &Path, config: &Config) -> Result<(), Failure> {
    if let Err(PermissionError::Open(database, _)) = file_permissions::check(&config.database) {
        notice(&format_args!(
            "other users can read the database {database}; run chmod 600 {database}",
            database = database.display()
        ));
    }
    match file_permissions::check(file) {
        Err(PermissionError::Open(..)) if !config.is_private() => {
            notice(&format_args!("other users can read {file}; run chmod 600 {file}", file = file.display()));
            Ok(())
        }
        checked => Ok(checked?),
    }
}

/// Applies a changed configuration, and tells each change that needs a restart. A device that the station has already known
/// keeps its tables. Returns the devices that the station knows now.
fn apply_config(station: &mut Station, started_with: &Config, known: KnownDevices, mut config: Config) -> KnownDevices {
    for device in profivac_config::keep_devices(known, &mut config) {
        let changed = format!(
            "the device file of {device} has changed: slaves use it now, gauges from the next start of the station"
        );
        tell(station, &changed);
    }
    let devices = config.devices;
    profivac_config::needs_restart(started_with, &config).iter().for_each(|change| tell(station, change));
    profivac_config::notices(&config).iter().for_each(notice);
    station.reconfigure(config);
    devices
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;
    use profivac_web_server::server::TlsFiles;
    use std::fs;

    fn station(folder: &Path) -> Station {
        fs::write(folder.join("bus.toml"), "devices = [\"bcg450@5\"]\n").unwrap();
        let file = folder.join("plant.toml");
        let segment = "[[segment]]\nname = \"a\"\nport = \"sim:bus.toml\"\n[[segment.gauge]]\nname = \"chamber\"\naddress = 5\ndevice = \"bcg450\"\n";
        fs::write(&file, segment).unwrap();
        Station::start(profivac_config::read(&file).unwrap()).unwrap()
    }

    #[test]
    fn parts_that_cannot_listen_together_have_one_port_and_one_address_or_all() {
        let address = |text: &str| text.parse().unwrap();
        for (one, other, expected) in [
            ("127.0.0.1:80", "127.0.0.1:80", true),
            ("0.0.0.0:80", "127.0.0.1:80", true),
            ("[::]:80", "127.0.0.1:80", true),
            ("127.0.0.1:80", "127.0.0.2:80", false),
            ("127.0.0.1:80", "127.0.0.1:81", false),
            ("0.0.0.0:80", "127.0.0.1:81", false),
            ("127.0.0.1:0", "127.0.0.1:0", false),
        ] {
            assert_eq!(overlap(address(one), address(other)), expected, "{one} {other}");
            assert_eq!(overlap(address(other), address(one)), expected, "{other} {one}");
        }
    }

    /// The station records already when the second attempt fails for another reason, here a certificate that has gone.
    #[test]
    fn a_failure_of_a_later_attempt_does_not_end_the_station() {
        let folder = tempfile::tempdir().unwrap();
        let station = station(folder.path());
        let taken = TcpListener::bind("127.0.0.1:0").unwrap();
        let config = profivac_config::read(&folder.path().join("plant.toml")).unwrap();
        let setup = Setup::new(taken.local_addr().unwrap(), config.access());
        let mut dashboard = Dashboard::new(setup);
        let begun = Instant::now();
        dashboard.start(&station.services(), begun).unwrap();
        let reason = |dashboard: &Dashboard| dashboard.failed.as_ref().map(|failed| failed.reason.clone());
        assert!(reason(&dashboard).unwrap().contains("cannot listen"));
        let gone = folder.path().join("gone.pem");
        dashboard.setup.tls = Some(TlsFiles { certificate: gone.clone(), key: gone });
        dashboard.start(&station.services(), begun + LISTEN_PERIOD).unwrap();
        assert!(reason(&dashboard).unwrap().contains("gone.pem"), "{:?}", reason(&dashboard));
        let mut first = Dashboard::new(dashboard.setup.clone());
        assert!(first.start(&station.services(), begun).is_err(), "a first attempt ends the command");
        station.stop().unwrap();
    }
}
