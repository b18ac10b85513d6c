//! `profivac run`: the station.

use crate::console::Signals;
use crate::failure::Failure;
use crate::output::{notice, out};
use clap::Args;
use profivac_host::port::wait;
use profivac_station::auth::file_permissions::{self, PermissionError};
use profivac_station::config::Config;
use profivac_station::server::{Server, Setup};
use profivac_station::station::Station;
use rustix::fd::AsFd;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The station: many segments, a recorder, a dashboard, left running for years.
///
/// The file is checked completely before anything starts. Gauges are parameterised, with the unit they have, and released
/// at the end. What is not there is waited for, what is lost comes back. SIGHUP reads the file again, and certificate and key:
/// what did not change goes on undisturbed. Without users (see `profivac user`) everybody on this computer may look.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The file that describes the station
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
    /// Where the dashboard is, instead of where the file says; port 0 lets the system choose one
    #[arg(long, value_name = "HOST:PORT")]
    listen: Option<SocketAddr>,
    /// Only check the file, and what it names: ports of segments in memory, users, certificate, key
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

/// How often somebody looks whether all threads live.
const THREAD_CHECK_PERIOD: Duration = Duration::from_secs(5);

/// Runs until a signal comes.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let config = Config::read(&arguments.file)?;
    config.notices().iter().for_each(notice);
    check_private(&arguments.file, &config)?;
    let listen = arguments.listen.unwrap_or(config.listen);
    let setup = Setup { hosts: config.hosts.clone(), tls: config.tls.clone(), ..Setup::new(listen, config.access()) };
    if arguments.check {
        config.check_ports()?;
        Server::check(&setup)?;
        let gauges: usize = config.segments.iter().map(|segment| segment.gauges.len()).sum();
        out(&format!("{}: {} segments, {gauges} gauges", arguments.file.display(), config.segments.len()));
        return Ok(());
    }
    let stop = Signals::of(&[SIGINT, SIGTERM])?;
    let mut reload = Signals::of(&[SIGHUP])?;
    let begun = config.clone();
    let mut station = Station::start(config)?;
    let server = Server::start(station.services(), setup)?;
    out(&format!("ready {}", server.url()));
    loop {
        let said = wait(&[stop.as_fd(), reload.as_fd()], THREAD_CHECK_PERIOD)?;
        if said.first() == Some(&true) {
            break;
        }
        if said.get(1) == Some(&true) {
            reload.clear();
            if let Err(error) = server.renew() {
                notice(&format_args!("{error}; the certificate stays as it was"));
            }
            match Config::read(&arguments.file) {
                Ok(config) => apply_config(&mut station, &begun, config)?,
                Err(error) => notice(&format_args!("{error}; the station goes on as it was")),
            }
        }
        station.restart_ended_threads()?;
    }
    drop(server);
    station.stop();
    Ok(())
}

/// A file that holds secrets or says where they are is its owner's alone; any other one hardly is for everybody, and no more is
/// the record: who did what stands there, and some let others read it on purpose.
fn check_private(file: &Path, config: &Config) -> Result<(), Failure> {
    if let Err(PermissionError::Open(record, _)) = file_permissions::check(&config.database) {
        notice(&format_args!("the record {record} is open to others: chmod 600 {record}", record = record.display()));
    }
    match file_permissions::check(file) {
        Err(PermissionError::Open(..)) if !config.is_private() => {
            notice(&format_args!("{file} is open to others: chmod 600 {file}", file = file.display()));
            Ok(())
        }
        checked => Ok(checked?),
    }
}

/// What only a restart brings about is told: whoever changed it believes that it holds.
fn apply_config(station: &mut Station, begun: &Config, config: Config) -> Result<(), Failure> {
    begun.needs_restart(&config).iter().for_each(notice);
    config.notices().iter().for_each(notice);
    Ok(station.reconfigure(config)?)
}
