//! `profivac run`: runs the station.

use crate::console::Signals;
use crate::explanation::counted;
use crate::failure::Failure;
use crate::gateways::{self, Gateways};
use crate::names;
use crate::output::{notice, out};
use clap::Args;
use profivac_host::readiness::{Readiness, wait};
use profivac_station::config::Config;
use profivac_station::station::Station;
use profivac_web_server::auth::file_permissions::{self, PermissionError};
use profivac_web_server::server::{Server, Setup};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Run the station: segments, recorder, alarms and dashboard.
///
/// The file is checked completely before anything starts. The station parameterises gauges, keeps their units, and releases them
/// at the end; a gauge that is released returns to IDLE, stops measuring and opens its relays. The station waits for missing
/// gauges and reopens lost ports. On SIGHUP it reads the file, certificate and key again; unchanged segments continue. Without
/// users (see `profivac user`) every user of this computer may view the dashboard.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The file that describes the station
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
    /// The address of the dashboard, instead of that in the file; port 0 selects a free one
    #[arg(long, value_name = "HOST:PORT")]
    listen: Option<SocketAddr>,
    /// Only check the file and the files it names: segments in memory, users, certificate, key
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

/// The time between two checks of the threads of the station.
const THREAD_CHECK_PERIOD: Duration = Duration::from_secs(5);

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
        Server::check(&setup)?;
        let gauges: usize = config.segments.iter().map(|segment| segment.gauges.len()).sum();
        let slaves: usize = config.segments.iter().map(|segment| segment.slaves.len()).sum();
        let (segments, gauges) = (counted(config.segments.len() as u64, "segment"), counted(gauges as u64, "gauge"));
        let slaves = if slaves == 0 { String::new() } else { format!(", {}", counted(slaves as u64, "slave")) };
        out(&format!("{}: {segments}, {gauges}{slaves}", arguments.file.display()));
        return Ok(());
    }
    let stop = Signals::of(&[SIGINT, SIGTERM])?;
    let mut reload = Signals::of(&[SIGHUP])?;
    let started_with = config.clone();
    let mut station = Station::start(config)?;
    let server = profivac_station::server::start(station.services(), setup)?;
    let mut gateways = Gateways::default();
    gateways.apply(&started_with.gateways, &station.services())?;
    out(&format!("ready {}", server.url()));
    loop {
        let readable = wait(&[Readiness::of(&stop), Readiness::of(&reload)], THREAD_CHECK_PERIOD)?;
        if readable.first() == Some(&true) {
            break;
        }
        if readable.get(1) == Some(&true) {
            reload.clear();
            if let Err(error) = server.renew() {
                notice(&format_args!("{error}; the station keeps the present certificate"));
            }
            let services = station.services();
            // A change in the dashboard comes before or after this one.
            let _held = services.alarm_editor().hold();
            let read = profivac_config::read(&arguments.file).map_err(Failure::from);
            match read.and_then(|config| names::check(&config).map(|()| config)) {
                Ok(config) => {
                    let wanted = config.gateways.clone();
                    apply_config(&mut station, &started_with, config)?;
                    if let Err(error) = gateways.apply(&wanted, &station.services()) {
                        notice(&error);
                    }
                }
                Err(error) => notice(&format_args!("{error}; the station keeps the present configuration")),
            }
        }
        station.restart_ended_threads()?;
    }
    drop(server);
    drop(gateways);
    station.stop();
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

/// Applies a changed configuration, and prints a notice for each change that needs a restart.
fn apply_config(station: &mut Station, started_with: &Config, config: Config) -> Result<(), Failure> {
    profivac_config::needs_restart(started_with, &config).iter().for_each(notice);
    profivac_config::notices(&config).iter().for_each(notice);
    Ok(station.reconfigure(config)?)
}
