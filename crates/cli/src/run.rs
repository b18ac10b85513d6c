//! `profivac run`: the station.

use crate::console::Signals;
use crate::failure::Failure;
use crate::output::{out, remark};
use clap::Args;
use profivac_host::port::wait;
use profivac_station::config::Config;
use profivac_station::server::Server;
use profivac_station::station::Station;
use rustix::fd::AsFd;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

/// The station: many segments, a recorder, a dashboard, left running for years.
///
/// The file is checked completely before anything starts. Gauges are parameterised, with the unit they have, and released
/// at the end. What is not there is waited for, what is lost comes back. SIGHUP reads the file again: what did not change
/// goes on undisturbed.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The file that describes the station
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
    /// Where the dashboard is, instead of where the file says; port 0 lets the system choose one
    #[arg(long, value_name = "HOST:PORT")]
    listen: Option<SocketAddr>,
    /// Let other computers see the station, if it listens at an address they reach
    #[arg(long)]
    public: bool,
    /// Only check the file
    #[arg(long)]
    check: bool,
}

const EXAMPLES: &str = "\
Examples:
  profivac init --port /dev/ttyUSB0 --out plant.toml
  profivac run plant.toml --check
  profivac run plant.toml
  profivac run plant.toml --listen 0.0.0.0:8080 --public";

/// How often somebody looks whether all threads live.
const WATCH: Duration = Duration::from_secs(5);

/// Runs until a signal comes.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let config = Config::read(&arguments.file)?;
    if arguments.check {
        let gauges: usize = config.segments.iter().map(|segment| segment.gauges.len()).sum();
        out(&format!("{}: {} segments, {gauges} gauges", arguments.file.display(), config.segments.len()));
        return Ok(());
    }
    let stop = Signals::of(&[SIGINT, SIGTERM])?;
    let mut reload = Signals::of(&[SIGHUP])?;
    let listen = arguments.listen.unwrap_or(config.listen);
    let mut station = Station::start(config)?;
    let server = Server::start(station.plant(), listen, arguments.public)?;
    out(&format!("ready http://{}", server.address()));
    loop {
        let said = wait(&[stop.as_fd(), reload.as_fd()], WATCH)?;
        if said.first() == Some(&true) {
            break;
        }
        if said.get(1) == Some(&true) {
            reload.forget();
            match Config::read(&arguments.file) {
                Ok(config) => station.become_like(config)?,
                Err(error) => remark(&format_args!("{error}; the station goes on as it was")),
            }
        }
        station.watch()?;
    }
    drop(server);
    station.stop();
    Ok(())
}
