//! The configuration file of a station.
//!
//! ```toml
//! [station]
//! name = "Target hall"
//! listen = "127.0.0.1:8080"        # address of the dashboard and the API
//! database = "target-hall.db"      # relative to this file
//! users = "target-hall.users.toml" # the users' file, relative to this file
//! hosts = ["vacuum.example"]       # host names that browsers use for this computer, besides localhost
//!
//! [tls]                            # required to listen beyond loopback
//! certificate = "target-hall.pem"
//! key = "target-hall.key"
//!
//! [openid]                         # login at a provider besides the users' file: docs/security.md
//! issuer = "https://login.example/realms/lab"
//! client-id = "profivac"
//! client-secret-file = "openid.secret"
//! url = "https://vacuum.example:8080"
//! roles-claim = "realm_access.roles"
//! roles = { operator = ["vacuum-operator"], engineer = ["vacuum-engineer"] }
//!
//! [retention]                      # how long rows of the database are kept, in recorded time
//! samples = "730 days"
//!
//! [[segment]]
//! name = "hall"
//! port = "/dev/ttyUSB0"            # a serial device, a pty, tcp://host:port, sim:FILE.toml
//! baud = 19200
//! master = 0
//!
//! [[segment.gauge]]
//! name = "chamber"
//! address = 5
//! device = "bcg450"
//! poll = "200 ms"                  # sampling interval
//! gas = "ar"                       # the dashboard shows a corrected pressure beside the indicated one
//! levels = { "process" = "1e-3 mbar" }
//! group = "target"                 # filters of the dashboard
//! tags = ["bake-out"]
//! location = "hall 2, rack 4"
//! calibrated = 2026-05-01
//! calibration-interval = "365 days"
//!
//! [[segment.slave]]                # a slave by its GSD file: docs/gsd-slaves.md
//! name = "turbo"
//! address = 12
//! gsd = "turbo.gsd"                # relative to this file; or device, a device file: docs/device-files.md
//! modules = [1, "status"]          # numbers and names of the GSD file, in slot order
//! parameters = { "State without bus" = "keep" }
//! own = true                       # the station takes it into data exchange, and sends these outputs
//! outputs = "01 00"
//!
//! [[segment.slave.point]]
//! name = "speed"
//! slot = 1
//! octet = 2
//! type = "u16"
//! unit = "Hz"
//!
//! [[segment]]
//! name = "plc"
//! port = "/dev/ttyUSB1"
//! listen-only = true               # the station sends nothing; without baud it finds the rate; no master
//!
//! [[segment.gauge]]
//! name = "furnace"
//! address = 12
//! device = "psg550"
//! configuration = "45 84 05 08 05" # octets of Chk_Cfg, until a start-up of the bus was heard
//! unit = "mbar"                    # the same for the unit
//!
//! [[volume]]                       # the picture of the plant
//! name = "target chamber"
//! zone = "target"
//! gauges = ["chamber"]
//!
//! [[pump]]
//! name = "turbo"
//! kind = "turbo"                   # turbo, roughing, capture
//! inlet = "target chamber"
//!
//! [[plant-state]]                  # an operator declares it; these alarms are suppressed then
//! name = "Vented"
//! zones = ["target"]
//! ```
//!
//! [`read`] gives the settings of the station, whose types are in `profivac_station::config`.
//! The whole file is checked before anything starts. An error names line and column.
//!
//! | Module | Holds |
//! |---|---|
//! | `file` | the whole file as TOML, and its defaults |
//! | `segments` | `[[segment]]`, `[[segment.gauge]]` |
//! | `slaves` | `[[segment.slave]]`, `[[segment.slave.point]]`: slaves by their GSD files |
//! | `alarms` | `[[alarm]]` |
//! | `default_alarms` | `[alarms]` |
//! | `devices` | the devices of device files |
//! | `webhooks` | `[[webhook]]` |
//! | `emails` | `[[email]]` |
//! | `labels` | group, tags, location and calibration of a gauge |
//! | `plant` | `[[volume]]`, `[[pump]]`, `[[valve]]` |
//! | `plant_states` | `[[plant-state]]` |
//! | `retention` | `[retention]` |
//! | [`gateways`] | `[epics]`, `[mqtt]`, `[prometheus]` and the other gateways to control systems |
//! | `check` | checks of segments, gauges and host names |
//! | `views` | `[[view]]` |
//! | `names`, `number_range`, `values` | rules for names; ranges of numbers; delays and priorities |
//! | `error`, `slave_problem` | errors with their positions |
//! | `notice` | notices about a valid file, and about changes that need a restart |

mod alarms;
mod check;
mod default_alarms;
mod devices;
mod emails;
mod error;
mod file;
pub mod gateways;
mod labels;
mod names;
mod notice;
mod number_range;
mod plant;
mod plant_states;
mod retention;
mod segments;
mod slave_problem;
mod slaves;
pub mod time_span;
mod values;
mod views;
mod webhooks;

pub use devices::keep as keep_devices;
pub use error::{
    AddressUser, ArchiveProblem, BrokerUrlProblem, ConfigError, ConfigProblem, DrawingFileProblem, MqttProblem,
    NamedItem, WebhookUrlProblem,
};
pub use notice::{ConfigNotice, RestartNeeded, needs_restart};
pub use number_range::NumberRange;
pub use slave_problem::SlaveProblem;

use error::Located;
use file::ConfigToml;
use profivac_client::cyclic::IntegerRange;
use profivac_host::port::PortError;
use profivac_host::text_file::{self, line_and_column};
use profivac_station::config::{Config, ConfigSource};
use profivac_virtual::segment_file::SegmentFile;
use profivac_web_server::server::{PemItem, TlsError};
use std::path::{Path, PathBuf};

/// Reads the file at `path`.
///
/// # Errors
/// [`ConfigError`] with the position and the problem.
pub fn read(path: &Path) -> Result<Config, ConfigError> {
    parse(&text_of(path)?, path)
}

/// The file of the users of the station with the file at `path`. Only the key `users` is read: the rest of the file may have an error,
/// and a user can be removed all the same.
///
/// # Errors
/// [`ConfigError`] if the file cannot be read, or is no TOML.
pub fn read_users_file(path: &Path) -> Result<PathBuf, ConfigError> {
    let text = text_of(path)?;
    file::users_file_of(&text, path).map_err(|error| in_file(error, &text, path))
}

/// Parses `text` as the contents of the file at `path`. Relative paths in the text are relative to the folder of `path`.
///
/// # Errors
/// [`ConfigError`] with the position and the problem.
pub fn parse(text: &str, path: &Path) -> Result<Config, ConfigError> {
    let located = |error: Located| in_file(error, text, path);
    let mut file = ConfigToml::parse(text).map_err(located)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let devices = devices::resolve(&mut file, folder).map_err(located)?;
    check::check(&file).map_err(located)?;
    let renamed_keys = notice::renamed_keys(&file, text, path).map_err(located)?;
    let mut alarms = alarms::rules(&file.alarm, &file.alarms, &file.segment).map_err(located)?;
    let webhooks = webhooks::webhooks(&file.webhook, path).map_err(located)?;
    let taken: Vec<_> = webhooks.iter().map(|webhook| webhook.name.as_str()).collect();
    let emails = emails::emails(&file.email, path, &taken).map_err(located)?;
    let mut plant = plant::plant(&file.volume, &file.pump, &file.valve, &file.segment).map_err(located)?;
    plant.drawing = plant::drawing(file.station.drawing.as_ref(), &plant, &file.segment, folder).map_err(located)?;
    let mut directory = labels::directory(&file.segment).map_err(located)?;
    directory.views = views::views(&file.view, &file.segment, &directory).map_err(located)?;
    let known = plant_states::Known { rules: &alarms, segments: &file.segment, directory: &directory, plant: &plant };
    let plant_states = plant_states::plant_states(&file.plant_state, &known).map_err(located)?;
    let retention = retention::retention(&file.retention).map_err(located)?;
    let openid = file.openid(folder).map_err(located)?;
    let gateways = file.take_gateways(path).and_then(|tables| gateways::settings(tables, path)).map_err(located)?;
    alarms.extend(gateways.iter().find_map(gateways::alarm));
    let source = ConfigSource::new(path, text, parse_again);
    let slaves = file.segment.iter().map(|it| slaves::slaves(&it.slave, it.listen_only, folder));
    let slaves = slaves.collect::<Result<Vec<_>, _>>().map_err(located)?;
    let mut config = file.into_config(path);
    for (segment, slaves) in config.segments.iter_mut().zip(slaves) {
        (segment.slaves, segment.devices) = (slaves, devices);
    }
    let all = config.segments.iter().flat_map(|segment| &segment.slaves);
    directory.points = all.flat_map(|it| it.points.iter().map(|point| point.described(&it.name))).collect();
    Ok(Config {
        devices,
        alarms,
        plant_states,
        webhooks,
        emails,
        plant,
        directory,
        retention,
        openid,
        renamed_keys,
        gateways,
        source,
        ..config
    })
}

/// Checks the segment files of `sim:` ports. A station does not check them at its start, because these files belong to
/// other programs and may appear or change later.
///
/// # Errors
/// [`PortError::File`] with the position in the segment file.
pub fn check_ports(config: &Config) -> Result<(), PortError> {
    let files = config.segments.iter().filter_map(|segment| segment.port.strip_prefix("sim:"));
    files.map(Path::new).try_for_each(|file| Ok(SegmentFile::read(file).map(drop)?))
}

/// The sentence about an error of TLS, with the line and the key of the file that names the wrong file.
#[must_use]
pub fn tls_sentence(config: &Config, error: &TlsError) -> String {
    let (item, key) = match error {
        TlsError::Pem { expected: PemItem::Certificate, .. } => (PemItem::Certificate, "certificate"),
        _ => (PemItem::Key, "key"),
    };
    let (text, path) = (config.source.text(), config.source.path().display());
    match file::tls_span(text, item) {
        Some(span) => {
            let (line, column) = line_and_column(text, span.start);
            format!("{path}:{line}:{column}: {key} in [tls]: {error}")
        }
        None => error.to_string(),
    }
}

/// Notices about settings that are valid but probably not intended.
#[must_use]
pub fn notices(config: &Config) -> Vec<ConfigNotice> {
    let renamed = config.renamed_keys.iter().cloned().map(ConfigNotice::RenamedKey);
    let empty = config.segments.iter().filter(|it| it.gauges.is_empty() && it.slaves.is_empty());
    let empty = empty.map(|segment| ConfigNotice::EmptySegment { segment: segment.name.clone() });
    let gauges = config.segments.iter().flat_map(|segment| &segment.gauges);
    let integers = gauges.filter_map(|gauge| {
        Some(ConfigNotice::IntegerRange { gauge: gauge.name.clone(), range: gauge.integer_range()? })
    });
    let gauges = config.segments.iter().flat_map(|segment| &segment.gauges);
    let unknown_units = gauges.filter_map(|gauge| {
        let ranges: Vec<_> = gauge.integer_ranges().iter().map(IntegerRange::limits).collect();
        let (gauge, ranges) = (gauge.name.clone(), ranges.join(", "));
        (!ranges.is_empty()).then_some(ConfigNotice::IntegersWithoutUnit { gauge, ranges })
    });
    let unprotected = config.gateways.iter().filter_map(|gateway| {
        Some(ConfigNotice::UnprotectedGateway { gateway: gateway.name(), listen: gateway.unprotected()? })
    });
    let writers = config.gateways.iter().filter_map(|gateway| {
        let write = gateway.writer()?;
        let clients = write.clients.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
        Some(ConfigNotice::WritableGateway { gateway: gateway.name(), clients, user: write.user.clone() })
    });
    let brokers = config.gateways.iter().filter_map(|gateway| {
        let host = gateway.unencrypted_broker()?.to_owned();
        Some(ConfigNotice::UnencryptedBroker { gateway: gateway.name(), host })
    });
    let slaves = notice::about_slaves(&config.segments);
    let gauges = renamed.chain(empty).chain(integers).chain(unknown_units).chain(slaves);
    gauges.chain(unprotected).chain(writers).chain(brokers).collect()
}

/// Parses a text that the station has edited; the error says the problem without its position.
fn parse_again(text: &str, path: &Path) -> Result<Config, String> {
    parse(text, path).map_err(|error| error.problem.to_string())
}

/// The text of the file at `path`.
fn text_of(path: &Path) -> Result<String, ConfigError> {
    let unreadable = |error| {
        let problem = Box::new(ConfigProblem::Unreadable(error));
        ConfigError { file: path.to_owned(), line: 1, column: 1, problem }
    };
    text_file::read(path).map_err(unreadable)
}

/// The error with its line and column in the text of the file at `path`.
fn in_file(Located { span, problem }: Located, text: &str, path: &Path) -> ConfigError {
    let (line, column) = line_and_column(text, span.start);
    ConfigError { file: path.to_owned(), line, column, problem: Box::new(problem) }
}

#[cfg(test)]
mod openid_tests;
#[cfg(test)]
mod tests;
