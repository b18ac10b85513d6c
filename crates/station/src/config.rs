//! The file that describes a station.
//!
//! ```toml
//! [station]
//! name = "Target hall"
//! listen = "127.0.0.1:8080"        # where the dashboard is
//! record = "target-hall.db"        # beside this file
//! users = "target-hall.users.toml" # who may log in, beside this file
//! hosts = ["vacuum.example"]       # what browsers may call this computer, besides localhost
//!
//! [tls]                            # without it nobody but this computer is served
//! certificate = "target-hall.pem"
//! key = "target-hall.key"
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
//! poll = "200 ms"                  # how often its pressure is taken
//! gas = "ar"                       # shown corrected beside indicated
//! levels = { "process" = "1e-3 mbar" }
//! ```
//!
//! Everything is checked before anything starts; what is wrong is told with line and column.

mod alarms;
mod names;
mod webhooks;

use crate::alarm::Rule;
use crate::api::headers::host;
use crate::auth::Access;
use crate::server::TlsFiles;
use alarms::{AlarmToml, DefaultAlarmsToml};
use names::unique;
use profivac_client::pressure::Pressure;
use profivac_devices::catalog::MODELS;
use profivac_dp::link::Baud;
use profivac_host::port::PortError;
use profivac_host::text_file::{self, Parsed, baud, line_and_column, usual_baud};
use profivac_vacuum::Gas;
use profivac_virtual::device_spec::entry;
use profivac_virtual::segment_file::SegmentFile;
use serde::Deserialize;
use std::collections::{BTreeMap, HashSet};
use std::net::{IpAddr, SocketAddr};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;
use toml::Spanned;
use webhooks::WebhookToml;
pub use webhooks::{Secret, Webhook};

/// Where the dashboard is unless the file says otherwise: only this computer sees it.
const LISTEN: &str = "127.0.0.1:8080";

/// The highest address of a slave that can be parameterised, and of a master.
const MAX_ADDRESS: u8 = 125;

/// How often a pressure is taken unless the file says otherwise.
const POLL: Duration = Duration::from_millis(200);

/// From this likeness on a name may have been meant: half of its letters stand where they should. free choice.
const ALIKE: f64 = 0.5;

/// The quickest and the slowest.
const POLLS: (Duration, Duration) = (Duration::from_millis(20), Duration::from_secs(3600));

/// A station.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// Its name.
    pub name: String,
    /// Where the dashboard is.
    pub listen: SocketAddr,
    /// The recorder's file.
    pub database: PathBuf,
    /// Who may log in.
    pub users: UsersFile,
    /// Names and addresses of this computer, without ports.
    pub hosts: Vec<String>,
    /// Certificate and key.
    pub tls: Option<TlsFiles>,
    /// Its segments.
    pub segments: Vec<Segment>,
    /// Its alarms: those of the file, and those that there are by themselves.
    pub alarms: Vec<Rule>,
    /// Who is told of them.
    pub webhooks: Vec<Webhook>,
}

/// The file with those who may log in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UsersFile {
    /// Where it is.
    pub path: PathBuf,
    /// Whether the station's file names it: then it has to be there.
    pub named: bool,
}

/// A segment.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Its name.
    pub name: String,
    /// Its port.
    pub port: String,
    /// Its rate.
    pub baud: Baud,
    /// The address of our master.
    pub master: u8,
    /// Its gauges.
    pub gauges: Vec<Gauge>,
}

/// A gauge.
#[derive(Clone, Debug, PartialEq)]
pub struct Gauge {
    /// Its name, which no other gauge of the station has.
    pub name: String,
    /// Its address.
    pub address: u8,
    /// What it is.
    pub device: String,
    /// How often its pressure is taken.
    pub poll: Duration,
    /// What its chamber is filled with.
    pub gas: Gas,
    /// Where a line is drawn: names and pressures.
    pub levels: Vec<(String, Pressure)>,
}

impl Gauge {
    /// Whether this is the same slave, whatever else has changed.
    #[must_use]
    pub fn is_same_slave(&self, other: &Self) -> bool {
        (self.address, &self.device) == (other.address, &other.device)
    }
}

/// Why a file describes no station: what is wrong, and where.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}:{column}: {what}", file = file.display())]
pub struct ConfigError {
    /// The file.
    pub file: PathBuf,
    /// The line, from 1.
    pub line: usize,
    /// The column, from 1.
    pub column: usize,
    /// What was expected and what came.
    pub what: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ConfigToml {
    #[serde(default)]
    station: StationToml,
    tls: Option<TlsToml>,
    #[serde(default)]
    segment: Vec<SegmentToml>,
    #[serde(default)]
    alarm: Vec<AlarmToml>,
    #[serde(default)]
    alarms: DefaultAlarmsToml,
    #[serde(default)]
    webhook: Vec<WebhookToml>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct StationToml {
    name: Option<String>,
    listen: Option<Parsed<SocketAddr>>,
    record: Option<PathBuf>,
    users: Option<PathBuf>,
    #[serde(default)]
    hosts: Vec<Spanned<String>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TlsToml {
    certificate: PathBuf,
    key: PathBuf,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SegmentToml {
    name: Spanned<String>,
    port: Spanned<String>,
    #[serde(default = "usual_baud", deserialize_with = "baud")]
    baud: Baud,
    #[serde(default)]
    master: Option<Spanned<u8>>,
    #[serde(default)]
    gauge: Vec<GaugeToml>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct GaugeToml {
    name: Spanned<String>,
    address: Spanned<u8>,
    device: Spanned<String>,
    poll: Option<Spanned<Parsed<humantime::Duration>>>,
    gas: Option<Parsed<Gas>>,
    #[serde(default)]
    levels: BTreeMap<String, Parsed<Pressure>>,
}

/// A complaint about a place in the file.
type SpannedMessage = (Range<usize>, String);

impl Config {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// [`ConfigError`] with the place and what was expected there.
    pub fn read(path: &Path) -> Result<Self, ConfigError> {
        let error = |error: std::io::Error| ConfigError {
            file: path.to_owned(),
            line: 1,
            column: 1,
            what: format!("the file cannot be read: {error}"),
        };
        Self::parse(&text_file::read(path).map_err(error)?, path)
    }

    /// Whether the files behind `sim:` ports can be read, too. They belong to others and may change or come later, so a
    /// station begins without asking.
    ///
    /// # Errors
    /// [`PortError::File`] with the place in such a file.
    pub fn check_ports(&self) -> Result<(), PortError> {
        let files = self.segments.iter().filter_map(|segment| segment.port.strip_prefix("sim:"));
        files.map(Path::new).try_for_each(|file| SegmentFile::read(file).map(drop))
    }

    /// What is allowed and yet hardly wanted, in sentences.
    #[must_use]
    pub fn hints(&self) -> Vec<String> {
        let empty = self.segments.iter().filter(|segment| segment.gauges.is_empty());
        let hint = |segment: &Segment| {
            let name = &segment.name;
            format!(
                "the segment {name:?} has no [[segment.gauge]], so nothing of it is recorded; `profivac init` finds gauges"
            )
        };
        empty.map(hint).collect()
    }

    /// Who is let in: everybody may look, unless there is a file with users.
    #[must_use]
    pub fn access(&self) -> Access {
        let UsersFile { path, named } = &self.users;
        if *named || path.exists() { Access::Users(path.clone()) } else { Access::anonymous_viewer() }
    }

    /// Whether it holds secrets or says where they are, so that only its owner may read it. The address of a webhook often is one.
    #[must_use]
    pub const fn is_private(&self) -> bool {
        self.users.named || self.tls.is_some() || !self.webhooks.is_empty()
    }

    /// What only a restart brings about, between this file and a changed one, in sentences.
    #[must_use]
    pub fn needs_restart(&self, new: &Self) -> Vec<String> {
        let listen = ("listen", self.listen.to_string(), new.listen.to_string());
        let files =
            |config: &Self| config.tls.as_ref().map_or_else(|| "off".to_owned(), |tls| tls.key.display().to_string());
        let tls = ("tls", files(self), files(new));
        let users = ("users", self.users.path.display().to_string(), new.users.path.display().to_string());
        let hosts = ("hosts", format!("{:?}", self.hosts), format!("{:?}", new.hosts));
        let record = ("record", self.database.display().to_string(), new.database.display().to_string());
        let name = ("name", self.name.clone(), new.name.clone());
        let changed = [listen, record, name, users, hosts, tls].into_iter().filter(|(_, old, new)| old != new);
        changed
            .map(|(what, old, new)| format!("{what} is {old} until the station is started again, then {new}"))
            .collect()
    }

    /// What `text` describes, as if it stood at `path`.
    ///
    /// # Errors
    /// [`ConfigError`] with the place and what was expected there.
    pub fn parse(text: &str, path: &Path) -> Result<Self, ConfigError> {
        let at = |(span, what): SpannedMessage| {
            let (line, column) = line_and_column(text, span.start);
            ConfigError { file: path.to_owned(), line, column, what }
        };
        let written: ConfigToml =
            toml::from_str(text).map_err(|error| at((error.span().unwrap_or_default(), error.message().to_owned())))?;
        check(&written).map_err(at)?;
        let alarms = alarms::rules(&written.alarm, &written.alarms, &written.segment).map_err(at)?;
        let webhooks = webhooks::webhooks(&written.webhook, path).map_err(at)?;
        Ok(Self { alarms, webhooks, ..written.into_config(path) })
    }
}

/// Everything that no single value shows.
fn check(written: &ConfigToml) -> Result<(), SpannedMessage> {
    if written.segment.is_empty() {
        return Err((0..0, "expected at least one [[segment]]".to_owned()));
    }
    written.station.hosts.iter().try_for_each(check_host)?;
    unique("segment", written.segment.iter().map(|segment| &segment.name))?;
    unique("port", written.segment.iter().map(|segment| &segment.port))?;
    unique("gauge", written.segment.iter().flat_map(|segment| &segment.gauge).map(|gauge| &gauge.name))?;
    written.segment.iter().try_for_each(check_segment)
}

/// Names are given without ports: a certificate has none either.
fn check_host(name: &Spanned<String>) -> Result<(), SpannedMessage> {
    let text = name.get_ref();
    let bare = host(text).filter(|host| host == text) == Some(text.clone());
    let address = text.parse::<IpAddr>().is_ok();
    if bare && !text.is_empty() || address {
        return Ok(());
    }
    Err((name.span(), format!("expected a name or an address of this computer without a port, got {text:?}")))
}

fn check_segment(segment: &SegmentToml) -> Result<(), SpannedMessage> {
    let mut taken = HashSet::from([master(segment)]);
    if let Some(master) = segment.master.as_ref().filter(|master| *master.get_ref() > MAX_ADDRESS) {
        return Err((master.span(), format!("expected a master's address from 0 to 125, got {}", master.get_ref())));
    }
    for gauge in &segment.gauge {
        check_gauge(gauge)?;
        let address = *gauge.address.get_ref();
        if !taken.insert(address) {
            let other = if address == master(segment) { "the master" } else { "another gauge" };
            return Err((gauge.address.span(), format!("the address {address} belongs to {other}")));
        }
    }
    Ok(())
}

fn check_gauge(gauge: &GaugeToml) -> Result<(), SpannedMessage> {
    let address = *gauge.address.get_ref();
    if address > MAX_ADDRESS {
        return Err((gauge.address.span(), format!("expected a slave's address from 0 to 125, got {address}")));
    }
    entry(gauge.device.get_ref()).map_err(|error| {
        let alike = alike(gauge.device.get_ref()).map(|name| format!("; did you mean {name}?")).unwrap_or_default();
        (gauge.device.span(), format!("{error}{alike}"))
    })?;
    match &gauge.poll {
        Some(poll) if !(POLLS.0..=POLLS.1).contains(&*poll.get_ref().0) => {
            Err((poll.span(), format!("expected a time from 20ms to 1h, got {}", poll.get_ref().0)))
        }
        _ => Ok(()),
    }
}

/// The device whose name is most like this one, if any is.
fn alike(name: &str) -> Option<&'static str> {
    let wanted = name.to_lowercase().replace([' ', '-', '_'], "");
    let likeness = |known: &&str| strsim::normalized_damerau_levenshtein(&wanted, known);
    let best = MODELS.iter().map(|model| model.name).max_by(|one, two| likeness(one).total_cmp(&likeness(two)));
    best.filter(|best| likeness(best) >= ALIKE)
}

fn master(segment: &SegmentToml) -> u8 {
    segment.master.as_ref().map_or(0, |master| *master.get_ref())
}

impl ConfigToml {
    fn into_config(self, path: &Path) -> Config {
        let stem = path.file_stem().map_or_else(|| "station".to_owned(), |stem| stem.to_string_lossy().into_owned());
        let record = self.station.record.unwrap_or_else(|| PathBuf::from(format!("{stem}.db")));
        let beside = |file: PathBuf| path.parent().unwrap_or(Path::new("")).join(file);
        let users = UsersFile {
            named: self.station.users.is_some(),
            path: beside(self.station.users.unwrap_or_else(|| PathBuf::from(format!("{stem}.users.toml")))),
        };
        Config {
            name: self.station.name.unwrap_or(stem),
            listen: self.station.listen.map_or_else(usual_listen, |listen| listen.0),
            database: beside(record),
            users,
            hosts: self.station.hosts.into_iter().map(Spanned::into_inner).collect(),
            tls: self.tls.map(|tls| TlsFiles { certificate: beside(tls.certificate), key: beside(tls.key) }),
            segments: self.segment.into_iter().map(SegmentToml::into_segment).collect(),
            alarms: Vec::new(),
            webhooks: Vec::new(),
        }
    }
}

fn usual_listen() -> SocketAddr {
    LISTEN.parse().unwrap_or_else(|_| SocketAddr::from(([127, 0, 0, 1], 8080)))
}

impl SegmentToml {
    fn into_segment(self) -> Segment {
        Segment {
            master: master(&self),
            name: self.name.into_inner(),
            port: self.port.into_inner(),
            baud: self.baud,
            gauges: self.gauge.into_iter().map(GaugeToml::into_gauge).collect(),
        }
    }
}

impl GaugeToml {
    fn into_gauge(self) -> Gauge {
        Gauge {
            name: self.name.into_inner(),
            address: self.address.into_inner(),
            device: self.device.into_inner(),
            poll: self.poll.map_or(POLL, |poll| poll.into_inner().0.into()),
            gas: self.gas.map_or(Gas::N2, |gas| gas.0),
            levels: self.levels.into_iter().map(|(name, level)| (name, level.0)).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = r#"
[station]
name = "Target hall"

[[segment]]
name = "hall"
port = "/dev/ttyUSB0"
baud = 93750
master = 1

[[segment.gauge]]
name = "chamber"
address = 5
device = "bcg450"
poll = "100 ms"
gas = "ar"
levels = { process = "1e-3 mbar" }
"#;

    fn parse(text: &str) -> Result<Config, ConfigError> {
        Config::parse(text, Path::new("plants/hall.toml"))
    }

    #[test]
    fn a_file_describes_a_station() {
        let config = parse(FILE).unwrap();
        assert_eq!((config.name.as_str(), config.database.as_path()), ("Target hall", Path::new("plants/hall.db")));
        assert_eq!(config.listen.to_string(), "127.0.0.1:8080");
        let segment = &config.segments[0];
        assert_eq!((segment.name.as_str(), segment.baud, segment.master), ("hall", Baud::B93750, 1));
        let gauge = &segment.gauges[0];
        assert_eq!((gauge.address, gauge.poll, gauge.gas), (5, Duration::from_millis(100), Gas::Ar));
        assert_eq!(gauge.levels[0].0, "process");
        assert!((gauge.levels[0].1.pa() - 0.1).abs() < 1e-12);
    }

    #[test]
    fn who_comes_in_and_how_is_said_beside_the_file() {
        let more = "\"\nusers = \"people.toml\"\nhosts = [\"vacuum.example\", \"10.0.0.1\", \"fe80::1\"]\n[tls]\ncertificate = \"a.pem\"\nkey = \"/etc/a.key\"";
        let config = parse(&FILE.replacen("hall\"", &format!("hall{more}"), 1)).unwrap();
        assert_eq!(config.access(), Access::Users(PathBuf::from("plants/people.toml")));
        assert_eq!(config.hosts, ["vacuum.example", "10.0.0.1", "fe80::1"]);
        let tls = config.tls.clone().unwrap();
        assert_eq!(
            (tls.certificate.as_path(), tls.key.as_path()),
            (Path::new("plants/a.pem"), Path::new("/etc/a.key"))
        );
        assert!(config.is_private() && !parse(FILE).unwrap().is_private());
    }

    #[test]
    fn what_is_not_said_is_usual() {
        let config =
            parse("[[segment]]\nname = 'a'\nport = 'b'\n[[segment.gauge]]\nname='c'\naddress=5\ndevice='bcg450'");
        let config = config.unwrap();
        let gauge = &config.segments[0].gauges[0];
        assert_eq!(
            (config.name.as_str(), config.segments[0].master, gauge.poll, gauge.gas),
            ("hall", 0, POLL, Gas::N2)
        );
        assert_eq!(
            (config.users.path.as_path(), config.access()),
            (Path::new("plants/hall.users.toml"), Access::anonymous_viewer())
        );
    }

    #[test]
    fn what_is_wrong_is_told_with_its_place() {
        let altered = |from: &str, to: &str| parse(&FILE.replace(from, to)).unwrap_err().to_string();
        for (from, to, sentence) in [
            ("baud = 93750", "baud = 9", "hall.toml:8:8: expected a PROFIBUS rate out of 9600, "),
            ("master = 1", "master = 5", "hall.toml:13:11: the address 5 belongs to the master"),
            ("master = 1", "master = 126", "hall.toml:9:10: expected a master's address from 0 to 125, got 126"),
            ("address = 5", "address = 126", "hall.toml:13:11: expected a slave's address from 0 to 125, got 126"),
            ("address = 5", "address = 300", "hall.toml:13:11: "),
            ("bcg450", "bcg451", "hall.toml:14:10: unknown device \"bcg451\"; there are "),
            ("bcg450", "BCG-450", "; did you mean bcg450?"),
            ("bcg450", "PSG 550-SP", "; did you mean psg550?"),
            ("bcg450", "thermometer", "bpg400"),
            ("100 ms", "1 ms", "hall.toml:15:8: expected a time from 20ms to 1h, got 1ms"),
            ("100 ms", "often", "hall.toml:15:8: "),
            ("\"100 ms\"", "\"100\"", "hall.toml:15:8: time unit needed, for example 100sec or 100ms"),
            ("\"100 ms\"", "100", "hall.toml:15:8: invalid type: integer `100`, expected a string"),
            ("100 ms", "2 h", "hall.toml:15:8: expected a time from 20ms to 1h, got 2h"),
            ("\"ar\"", "\"beer\"", "hall.toml:16:7: expected a gas out of "),
            ("1e-3 mbar", "low", "hall.toml:17:22: "),
            ("gas =", "gass =", "hall.toml:16:1: unknown field `gass`, expected one of `name`, `address`, "),
            ("name = \"chamber\"", "name = \"\"", "hall.toml:12:8: expected the name of a gauge, got nothing"),
            (
                "[station]",
                "[stations]",
                "hall.toml:2:2: unknown field `stations`, expected one of `station`, `tls`, `segment`, ",
            ),
            (
                "[station]",
                "[station]\nhosts = [\"a.example\", \"b.example:80\"]",
                "hall.toml:3:23: expected a name or an",
            ),
            ("[station]", "[tls]\nkey = \"a\"\n[station]", "hall.toml:2:1: missing field `certificate`"),
            ("port = \"/dev/ttyUSB0\"", "", "missing field `port`"),
        ] {
            let told = altered(from, to);
            assert!(told.contains(sentence), "{to}: {told}");
        }
        assert_eq!(parse("").unwrap_err().to_string(), "plants/hall.toml:1:1: expected at least one [[segment]]");
        let twice = FILE.to_owned()
            + FILE
                .split_once("[[segment]]")
                .unwrap()
                .1
                .replace("name = \"hall\"", "[[segment]]\nname = \"annex\"")
                .as_str();
        assert_eq!(parse(&twice).unwrap_err().what, "the port \"/dev/ttyUSB0\" stands twice");
    }

    #[test]
    fn a_device_that_is_like_none_is_not_guessed() {
        let told = parse(&FILE.replace("bcg450", "thermometer")).unwrap_err().what;
        assert!(!told.contains("did you mean"), "{told}");
    }

    #[test]
    fn what_takes_a_restart_is_told() {
        let old = parse(FILE).unwrap();
        assert_eq!(old.needs_restart(&old), Vec::<String>::new());
        let new = FILE.replace("Target hall\"", "Target hall\"\nlisten = \"127.0.0.1:9090\"\nrecord = \"other.db\"");
        let told = old.needs_restart(&parse(&new).unwrap());
        assert_eq!(
            told,
            [
                "listen is 127.0.0.1:8080 until the station is started again, then 127.0.0.1:9090",
                "record is plants/hall.db until the station is started again, then plants/other.db"
            ]
        );
    }

    #[test]
    fn a_segment_without_gauges_is_hinted_at() {
        assert_eq!(parse(FILE).unwrap().hints(), Vec::<String>::new());
        let empty = parse("[[segment]]\nname = 'a'\nport = 'b'").unwrap();
        assert!(empty.hints()[0].starts_with("the segment \"a\" has no [[segment.gauge]]"));
    }

    #[test]
    fn two_gauges_at_one_address_are_none() {
        let twice = FILE.to_owned() + "[[segment.gauge]]\nname = \"second\"\naddress = 5\ndevice = \"pcg550\"\n";
        assert_eq!(parse(&twice).unwrap_err().what, "the address 5 belongs to another gauge");
        let same_name = twice.replace("second", "chamber");
        assert_eq!(parse(&same_name).unwrap_err().what, "the gauge \"chamber\" stands twice");
        let two_lines = FILE.replace("\"chamber\"", "\"cham\\nber\"");
        let what = "expected a name without control characters, got \"cham\\nber\"";
        assert_eq!(parse(&two_lines).unwrap_err().what, what);
    }

    #[test]
    fn a_file_that_is_not_there_is_told_by_name() {
        let missing = Path::new("no/such/plant.toml");
        assert!(
            Config::read(missing)
                .unwrap_err()
                .to_string()
                .starts_with("no/such/plant.toml:1:1: the file cannot be read")
        );
    }
}
