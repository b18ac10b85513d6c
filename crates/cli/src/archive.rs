//! `profivac archive`: what many stations record, in PostgreSQL.

use crate::console::Signals;
use crate::failure::Failure;
use crate::output::{notice, out};
use clap::Args;
use profivac_archive::config::Config;
use profivac_archive::https::{self, Server};
use profivac_archive::service::{self, Report};
use profivac_archive::view::{self, Watch};
use profivac_host::readiness::{Readiness, wait};
use signal_hook::consts::{SIGINT, SIGTERM};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Collect what many stations record from NATS JetStream, or over HTTPS, into PostgreSQL.
///
/// A station sends what it records when its file has [archive]. Any number of archives may run with one file, on one computer or on
/// several: they share the work. A batch is acknowledged after the commit, so that a kill at any moment neither loses nor doubles a row.
/// While a server or the database is down, batches wait; the archive connects again by itself. With [view] it serves a page of all
/// stations. docs/archive.md is an introduction.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The file that names the servers and the database
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
    /// Only check the file and the files it names
    #[arg(long)]
    check: bool,
}

const EXAMPLES: &str = "\
Examples:
  profivac archive archive.toml --check
  profivac archive archive.toml";

/// The time between two looks at the thread of the archive.
const CHECK_PERIOD: Duration = Duration::from_secs(1);

/// The time between two readings of certificate and key of the view, because certificates are renewed.
const KEYS_PERIOD: Duration = Duration::from_secs(60);

/// The time between two lines about what was stored.
const REPORT_INTERVAL: Duration = Duration::from_secs(60);

/// Runs until SIGINT or SIGTERM.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let config = Config::read(&arguments.file).map_err(|error| Failure::usage(error.to_string()))?;
    if arguments.check {
        let nats = config.nats.as_ref().map(|nats| nats.servers.join(", "));
        let senders = config.https.as_ref().map(|it| format!("{} stations over HTTPS", it.stations.len()));
        let sources = nats.into_iter().chain(senders).collect::<Vec<_>>().join(", ");
        config.https.as_ref().map_or(Ok(()), https::check)?;
        config.view.as_ref().map_or(Ok(()), view::check)?;
        out(&format!("{}: {sources}, plants with readers: {}", arguments.file.display(), config.plants.len()));
        return Ok(());
    }
    let signals = Signals::of(&[SIGINT, SIGTERM])?;
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_io().enable_time().build()?;
    let server = config.https.as_ref().map(|https| runtime.block_on(Server::bind(https))).transpose()?;
    if let Some(server) = &server {
        out(&format!("listening on {}", server.url()));
    }
    let watch = Watch::default();
    let log = |sentence: &str| notice(&format_args!("{sentence}"));
    let pending = server.as_ref().map(Server::pending).unwrap_or_default();
    let page = config.view.as_ref().map(|view| view::start(&config, view, &watch, pending, log)).transpose()?;
    if let Some(page) = &page {
        out(&format!("view at {}", page.url()));
    }
    let (stop, stopped) = tokio::sync::watch::channel(false);
    let archive = runtime.spawn(async move {
        let mut reported = Instant::now();
        let watched = async {
            if config.view.is_some() {
                watch.run(&config, stopped.clone()).await;
            }
        };
        tokio::join!(service::run(&config, server, stopped.clone(), |it| report(&it, &mut reported)), watched);
    });
    let mut renewed = Instant::now();
    while !archive.is_finished() {
        if let Some(page) = page.as_ref().filter(|_| renewed.elapsed() >= KEYS_PERIOD) {
            renewed = Instant::now();
            // One that cannot be read leaves the former one in use.
            page.renew().ok();
        }
        let readable = wait(&[Readiness::of(&signals)], CHECK_PERIOD)?;
        if readable.first() == Some(&true) {
            stop.send_replace(true);
            break;
        }
    }
    runtime
        .block_on(archive)
        .map_err(|_| Failure::no_answer("the archive has failed unexpectedly: start it again, and report the defect"))
}

fn report(report: &Report<'_>, reported: &mut Instant) {
    match report {
        Report::Ready => out("ready"),
        Report::Failed(error) => notice(&format_args!("{error}; the archive tries again, and batches wait")),
        Report::OtherStream(sentence) => notice(&format_args!("{sentence}")),
        Report::Silent(time) => {
            let seconds = time.as_secs();
            notice(&format_args!(
                "the database has not answered for {seconds} s; the archive waits for it, and batches wait"
            ));
        }
        Report::Stored(stored) if reported.elapsed() >= REPORT_INTERVAL => {
            *reported = Instant::now();
            out(&format!("{} batches, {} samples, {} rejected", stored.batches, stored.samples, stored.rejected));
        }
        Report::Stored(_) => {}
    }
}
