//! The file of a station, and everything that it names.

use super::{Finding, database, port};
use crate::{gateways, names};
use profivac_config::ConfigNotice;
use profivac_devices::model::Model;
use profivac_files::{free_octets, is_folder_writable};
use profivac_host::port::is_serial_port;
use profivac_station::config::{Config, Segment};
use profivac_web_server::auth::file_permissions::{self, PermissionError};
use std::io::ErrorKind;
use std::net::TcpListener;
use std::path::Path;

/// Below this free space, in octets, a database is in danger. chosen: some weeks of ten gauges.
const LITTLE_SPACE: u64 = 1 << 30;

/// The findings about a station's file.
pub fn check(path: &Path) -> Vec<Finding> {
    let config = match profivac_config::read(path) {
        Ok(config) => config,
        Err(error) => {
            return vec![Finding::bad_file(
                error.to_string(),
                "correct this position; docs/station.md describes the file",
            )];
        }
    };
    let gauges: usize = config.segments.iter().map(|segment| segment.gauges.len()).sum();
    let mut findings =
        vec![Finding::good(format!("the file of a station, segments: {}, gauges: {gauges}", config.segments.len()))];
    findings.extend(profivac_config::notices(&config).iter().map(|notice| {
        let next = match notice {
            ConfigNotice::RenamedKey(key) => format!("write {} in place of {}", key.new, key.old),
            _ => "see docs/station.md".to_owned(),
        };
        Finding::note(notice.to_string(), next)
    }));
    findings.extend(config.segments.iter().flat_map(segment));
    let checked = profivac_config::check_ports(&config).map_err(|error| error.to_string());
    let checked = checked.and_then(|()| gateways::check(&config.gateways).map_err(|error| error.to_string()));
    let checked = checked.and_then(|()| names::check(&config).map_err(|error| error.to_string()));
    if let Err(error) = checked {
        findings.push(Finding::bad_file(error, "correct the file; `profivac run FILE.toml --check` checks it again"));
    }
    findings.extend(permissions(path, &config));
    findings.extend(database(&config));
    findings.push(listen(&config));
    findings
}

/// The port of a segment, without opening it: the station may use it.
fn segment(segment: &Segment) -> Vec<Finding> {
    let is_device = is_serial_port(&segment.port);
    let findings = if is_device { port::check_unopened(&segment.port) } else { Vec::new() };
    let named = |finding: Finding| Finding { found: format!("segment {}: {}", segment.name, finding.found), ..finding };
    findings.into_iter().map(named).collect()
}

fn permissions(path: &Path, config: &Config) -> Option<Finding> {
    let Err(PermissionError::Open(..)) = file_permissions::check(path) else { return None };
    let found = format!("other users can read {}", path.display());
    let next = format!("run chmod 600 {}", path.display());
    Some(if config.is_private() { Finding::bad_file(found, next) } else { Finding::note(found, next) })
}

/// The device that records a series: `chamber`, or `rack.2` for a channel of the controller `rack`.
fn model(config: &Config, series: &str) -> Option<&'static Model> {
    let named = |name: &str| {
        let mut gauges = config.segments.iter().flat_map(|segment| &segment.gauges);
        gauges.find(|gauge| gauge.name == name).map(|gauge| gauge.device)
    };
    named(series).or_else(|| named(series.rsplit_once('.')?.0))
}

/// The database, or the folder in which it will be.
fn database(config: &Config) -> Vec<Finding> {
    let path = &config.database;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut findings = match path.exists() {
        true => database::check(path, |series| model(config, series)),
        false => vec![match is_folder_writable(folder) {
            true => Finding::good(format!("the database will be {}", path.display())),
            false => Finding::bad_file(
                format!("the database cannot be made in {}", folder.display()),
                "make the folder and give the user of the station the right to write there, or change `database`",
            ),
        }],
    };
    findings.extend(free_space(folder));
    findings
}

fn free_space(folder: &Path) -> Option<Finding> {
    let free = free_octets(folder)?;
    let found = format!("{:.1} GB are free for the database", free as f64 / 1e9);
    Some(match free >= LITTLE_SPACE {
        true => Finding::good(found),
        false => Finding::note(found, "free some space, move the database, or shorten `samples-days` in [retention]"),
    })
}

/// Whether the address of the dashboard is free.
fn listen(config: &Config) -> Finding {
    match TcpListener::bind(config.listen) {
        Ok(_) => Finding::good(format!("the address of the dashboard, {}, is free", config.listen)),
        Err(error) if error.kind() == ErrorKind::AddrInUse => Finding::note(
            format!("another program has the address of the dashboard, {}", config.listen),
            "it may be this station: open it in a browser; otherwise change `listen`",
        ),
        Err(error) => Finding::bad_port(
            format!("the dashboard cannot listen at {}: {error}", config.listen),
            "change `listen` to an address of this computer and a port above 1023",
        ),
    }
}
