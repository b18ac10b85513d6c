//! `profivac archive`: what many stations record, in PostgreSQL.

use crate::console::{SIGINT, SIGTERM, Signals};
use crate::failure::Failure;
use crate::output::{notice, out};
use clap::Args;
use profivac_archive::config::Config;
use profivac_archive::https::{self, Server};
use profivac_archive::metrics::{self, Metrics};
use profivac_archive::service::{self, Report};
use profivac_archive::store::{Store, StoreError};
use profivac_archive::view::{self, Watch};
use profivac_host::readiness::wait;
use profivac_recorder::Micros;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Store the records of many stations, from NATS JetStream or over HTTPS, in PostgreSQL.
///
/// A station sends its records if its file has [archive]. Any number of archives may run with one file, on one computer or on
/// several: they share the work. A batch is acknowledged after the commit, so a kill at any moment neither loses nor duplicates a row.
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
    /// Drop all samples that are older than samples-days, also more than a week of them, and exit
    #[arg(long, conflicts_with = "check")]
    drop_old_samples: bool,
    /// If two databases send under the name of this station: choose the one whose batches were put aside last, and exit
    #[arg(long, value_name = "STATION", conflicts_with_all = ["check", "drop_old_samples"])]
    accept: Option<String>,
    /// Store the batches that were put aside and whose reason no longer applies, and exit; with --accept, after the choice
    #[arg(long, conflicts_with_all = ["check", "drop_old_samples"])]
    again: bool,
}

const EXAMPLES: &str = "\
Examples:
  profivac archive archive.toml --check
  profivac archive archive.toml
  profivac archive archive.toml --drop-old-samples
  profivac archive archive.toml --accept hall-1 --again";

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
        config.prometheus.as_ref().map_or(Ok(()), metrics::check)?;
        let (file, plants, days) = (arguments.file.display(), config.plants.len(), config.samples_days);
        out(&format!("{file}: {sources}, plants with readers: {plants}, samples are kept for {days} days"));
        return Ok(());
    }
    let signals = Signals::of(&[SIGINT, SIGTERM])?;
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_io().enable_time().build()?;
    if arguments.drop_old_samples {
        return runtime.block_on(drop_old_samples(&config));
    }
    if arguments.accept.is_some() || arguments.again {
        return runtime.block_on(store_again(&config, arguments.accept.as_deref(), arguments.again));
    }
    let metrics = Metrics::default();
    let server = config.https.as_ref().map(|https| runtime.block_on(Server::bind(https, &metrics))).transpose()?;
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
    let prometheus = config.prometheus.as_ref().map(|it| runtime.block_on(metrics::Server::bind(it, &metrics)));
    let prometheus = prometheus.transpose()?;
    if let Some(server) = &prometheus {
        out(&format!("metrics at {}", server.url()));
    }
    let (stop, stopped) = tokio::sync::watch::channel(false);
    let archive = runtime.spawn(async move {
        let mut reported = Instant::now();
        let watched = async {
            if config.view.is_some() {
                watch.run(&config, stopped.clone()).await;
            }
        };
        let serve = async {
            match prometheus {
                Some(server) => server.run().await,
                None => std::future::pending().await,
            }
        };
        let run = service::run(&config, server, &metrics, stopped.clone(), |it| report(&it, &mut reported));
        tokio::select! {
            _ = async { tokio::join!(run, watched) } => {}
            () = serve => {}
        }
    });
    let mut renewed = Instant::now();
    while !archive.is_finished() {
        if let Some(page) = page.as_ref().filter(|_| renewed.elapsed() >= KEYS_PERIOD) {
            renewed = Instant::now();
            // One that cannot be read leaves the former one in use.
            page.renew().ok();
        }
        let readable = wait(&[signals.readiness()], CHECK_PERIOD)?;
        if readable.first() == Some(&true) {
            stop.send_replace(true);
            break;
        }
    }
    runtime
        .block_on(archive)
        .map_err(|_| Failure::no_answer("the archive has failed unexpectedly: start it again, and report the defect"))
}

/// Chooses a database of a station, and stores the batches that were put aside.
async fn store_again(config: &Config, station: Option<&str>, again: bool) -> Result<(), Failure> {
    let failed = |error: StoreError| Failure::no_answer(error.to_string());
    let mut store = Store::connect(&config.database, config.samples_days).await.map_err(failed)?;
    if let Some(station) = station {
        let chosen = store.accept_other(station).await.map_err(failed)?;
        let none = || {
            Failure::usage(format!(
                "expected a station with batches of another database that are put aside, found none of {station:?}: \
                 SELECT station, put_aside_reason FROM profivac.station names them"
            ))
        };
        let began = chosen.ok_or_else(none)?.to_iso(0);
        out(&format!("the database of {began} is the one of {station}; later ones of that name are refused"));
    }
    if again {
        let stored = store.store_again(Micros::now()).await.map_err(failed)?;
        out(&format!("{} batches are stored, {} stay put aside", stored.batches, stored.rejected));
    }
    Ok(())
}

/// Drops the samples that are older than the retention, however many days these are.
async fn drop_old_samples(config: &Config) -> Result<(), Failure> {
    let failed = |error: StoreError| Failure::no_answer(error.to_string());
    let mut store = Store::connect(&config.database, config.samples_days).await.map_err(failed)?;
    let old = store.old_days(Micros::now()).await.map_err(failed)?;
    let Some(range) = old.range() else {
        out(&format!("no samples are older than {} days", config.samples_days));
        return Ok(());
    };
    out(&format!("{range} are dropped: samples-days is {}", config.samples_days));
    let dropped = store.drop_days(&old).await.map_err(failed)?;
    if let Some(gone) = dropped.gone() {
        out(&gone);
    }
    dropped.stays().map_or(Ok(()), |stays| Err(Failure::no_answer(stays)))
}

fn report(report: &Report<'_>, reported: &mut Instant) {
    match report {
        Report::Ready => out("ready"),
        Report::Failed(error) => notice(&format_args!("{error}; the archive tries again, and batches wait")),
        Report::OtherStream(sentence)
        | Report::PutAside(sentence)
        | Report::Retention(sentence)
        | Report::Packing(sentence)
        | Report::Roles(sentence) => {
            notice(&format_args!("{sentence}"));
        }
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
