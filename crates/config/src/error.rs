//! Errors in the configuration file.

use super::number_range::NumberRange;
use super::slave_problem::SlaveProblem;
use crate::time_span::TimeSpan;
use profivac_client::suggestion::list;
use profivac_station::alarm::Priority;
use profivac_station::directory::ViewState;
use profivac_station::drawing::DrawingProblem;
use profivac_virtual::device_spec::SpecError;
use profivac_web_server::auth::file_permissions::PermissionError;
use profivac_web_server::tables::{self, CertificateError, TableProblem};
use profivac_web_server::visible_text::TextProblem;
use std::fmt;
use std::io;
use std::net::SocketAddr;
use std::ops::Range;
use std::path::PathBuf;
use tokio_rustls::rustls::pki_types::pem;

/// An error in the configuration file, with its position; a file that cannot be read has none.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", self.location())]
pub struct ConfigError {
    /// The configuration file.
    pub file: PathBuf,
    /// The line, from 1.
    pub line: usize,
    /// The column, from 1.
    pub column: usize,
    /// The problem, with the expected and the found value.
    pub problem: Box<ConfigProblem>,
}

impl ConfigError {
    /// The file, and in it the line and the column.
    fn location(&self) -> String {
        let file = self.file.display();
        match *self.problem {
            ConfigProblem::Unreadable(_) => file.to_string(),
            _ => format!("{file}:{}:{}", self.line, self.column),
        }
    }
}

/// Why the file of a drawing cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DrawingFileProblem {
    /// It cannot be read.
    #[error("{0}")]
    Read(io::Error),
    /// It is no drawing for this station.
    #[error(transparent)]
    Drawing(#[from] DrawingProblem),
}

/// A problem and the octets of the file that cause it.
#[derive(Debug)]
pub struct Located {
    pub span: Range<usize>,
    pub problem: ConfigProblem,
}

impl Located {
    pub const fn new(span: Range<usize>, problem: ConfigProblem) -> Self {
        Self { span, problem }
    }
}

impl From<tables::Located> for Located {
    fn from(tables::Located { span, problem }: tables::Located) -> Self {
        Self { span, problem: ConfigProblem::Table(problem) }
    }
}

/// A table of the file that has a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NamedItem {
    /// `[station]`.
    Station,
    /// `[[segment]]`.
    Segment,
    /// The port of a segment.
    Port,
    /// `[[segment.gauge]]`.
    Gauge,
    /// `[[segment.slave.point]]`.
    Point,
    /// `unit` of a point.
    Unit,
    /// The text of a code of a point.
    CodeText,
    /// A level of a gauge.
    Level,
    /// `[[alarm]]`.
    Alarm,
    /// `[[webhook]]`.
    Webhook,
    /// `[[email]]`.
    Email,
    /// `[[volume]]`.
    Volume,
    /// `zone` of a volume.
    Zone,
    /// `group` of a gauge.
    Group,
    /// An entry of `tags` of a gauge.
    Tag,
    /// `location` of a gauge.
    Location,
    /// `[[view]]`.
    View,
    /// `search` of a view.
    Search,
    /// `[[pump]]` or `[[valve]]`.
    PlantPart,
    /// `[[plant-state]]`.
    PlantState,
    /// `description` of a plant state.
    Description,
}

impl fmt::Display for NamedItem {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Station => "station",
            Self::Segment => "segment",
            Self::Port => "port",
            Self::Gauge => "gauge",
            Self::Point => "point",
            Self::Unit => "unit",
            Self::CodeText => "text of a code",
            Self::Level => "level",
            Self::Alarm => "alarm",
            Self::Webhook => "webhook",
            Self::Email => "e-mail or webhook",
            Self::Volume => "volume",
            Self::Zone => "zone",
            Self::Group => "group",
            Self::Tag => "tag",
            Self::Location => "location",
            Self::View => "view",
            Self::Search => "search",
            Self::PlantPart => "pump or valve",
            Self::PlantState => "plant state",
            Self::Description => "description",
        })
    }
}

/// The station of a segment that already has an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AddressUser {
    /// The master of the station.
    Master,
    /// Another gauge or slave of the segment.
    Gauge,
}

impl fmt::Display for AddressUser {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Master => "the master",
            Self::Gauge => "another gauge or slave",
        })
    }
}

/// The reason why a URL cannot be that of a webhook.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum WebhookUrlProblem {
    /// The URL has no host.
    #[error("a URL without a host")]
    NoHost,
    /// The URL contains a user name or a password.
    #[error("a URL with a password; use token or token-file instead")]
    Password,
    /// The scheme is neither `https` nor `http`.
    #[error("another scheme")]
    Scheme,
    /// A token would travel unencrypted to another computer.
    #[error("http with a token, which would travel unencrypted; use https")]
    TokenWithoutTls,
}

/// A problem in a configuration file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ConfigProblem {
    /// The file cannot be read.
    #[error("the file cannot be read: {0}")]
    Unreadable(#[source] io::Error),
    /// The text is not TOML, a key is unknown, or a value has the wrong type or form. Holds the message of the parser.
    #[error("{0}")]
    Syntax(String),
    /// A key is given by its current and by its former name.
    #[error("expected {new} or its former name {old}, found both: delete {old}")]
    BothNames {
        /// The former name.
        old: &'static str,
        /// The current name.
        new: &'static str,
    },
    /// A retention is no time, or out of range.
    #[error("expected a time from 1 day to 36525 days, or \"unlimited\", found {0:?}")]
    Retention(String),
    /// A value of the table of a gateway.
    #[error("expected {expected}, found {found:?}")]
    Gateway {
        /// The expected value, and what to do.
        expected: &'static str,
        /// The value.
        found: String,
    },
    /// A slave by its GSD file.
    #[error(transparent)]
    Slave(Box<SlaveProblem>),
    /// The file has no segment.
    #[error("expected at least one [[segment]]")]
    NoSegment,
    /// A name is empty.
    #[error("expected a name for the {0}, found an empty string")]
    EmptyName(NamedItem),
    /// A text has characters that are not visible, or a name is a path.
    #[error(transparent)]
    Text(TextProblem),
    /// Two tables have the same name.
    #[error("the {item} {name:?} is defined twice; {}", twice_hint(*.item))]
    Duplicate {
        /// The kind of table.
        item: NamedItem,
        /// The name.
        name: String,
    },
    /// An entry of `hosts` is not a host name.
    #[error("expected a name or an address of this computer without a port, found {0:?}")]
    HostName(String),
    /// An alarm is neither about gauges nor about a station of a segment, or has not one condition.
    #[error(
        "expected for the alarm {0:?} one of: gauge, or gauges and count, with above, below or rise; segment and station with \
         repetitions, lost or damaged"
    )]
    AlarmSubject(String),
    /// A segment that only listens has no master.
    #[error("a segment with listen-only = true has no master: delete the key master")]
    MasterOfListener,
    /// A key for gauges of another master, on a segment of this station's master.
    #[error("the key {0} is for segments with listen-only = true; here the station reads it from the gauge: delete it")]
    OnlyForListening(&'static str),
    /// The device has no such configuration.
    #[error("expected the octets of Chk_Cfg of a {device}, one of: {known}; found {found:?}")]
    UnknownConfiguration {
        /// The device.
        device: &'static str,
        /// The value.
        found: String,
        /// The configurations of the device.
        known: String,
    },
    /// The device has no such unit.
    #[error("expected a unit of a {device}, one of: {known}; found {found:?}")]
    UnknownUnit {
        /// The device.
        device: &'static str,
        /// The value.
        found: String,
        /// The units of the device.
        known: String,
    },
    /// The address of a master is out of range.
    #[error("expected a master address from 0 to 125, found {0}")]
    MasterAddress(u8),
    /// The address of a slave is out of range.
    #[error("expected a slave address from 0 to 125, found {0}")]
    SlaveAddress(u8),
    /// An address of the segment is used twice.
    #[error("address {address} is already used by {user}")]
    AddressInUse {
        /// The address.
        address: u8,
        /// The station that has it.
        user: AddressUser,
    },
    /// A device file is wrong.
    #[error("{0}")]
    DeviceFile(String),
    /// The device model does not exist.
    #[error(transparent)]
    UnknownDevice(SpecError),
    /// A sampling interval is out of range.
    #[error("expected a sampling interval from 20ms to 1h, found {0}")]
    PollInterval(TimeSpan),
    /// No gauge has this name.
    #[error("there is no gauge {name:?}{}", hint_or_list(.suggestion.as_deref(), .known))]
    UnknownGauge {
        /// The name.
        name: String,
        /// The most similar name of a gauge.
        suggestion: Option<String>,
        /// The names of the gauges.
        known: Vec<String>,
    },
    /// No volume has this name.
    #[error("there is no volume {name:?}{}; [[volume]] defines one", hint(.suggestion.as_deref()))]
    UnknownVolume {
        /// The name.
        name: String,
        /// The most similar name of a volume.
        suggestion: Option<String>,
    },
    /// A part connects a volume with itself.
    #[error("expected two different volumes, found {0:?} twice")]
    SameVolume(String),
    /// A gauge is at two volumes.
    #[error("the gauge {gauge:?} is at the volume {volume:?} already; delete one of both")]
    GaugePlacedTwice {
        /// The gauge.
        gauge: String,
        /// The volume that has it.
        volume: String,
    },
    /// A text has too many characters.
    #[error("expected a {item} of at most {most} characters, found {found}; shorten it")]
    LongText {
        /// The kind of text.
        item: NamedItem,
        /// The permitted number.
        most: usize,
        /// The number.
        found: usize,
    },
    /// A view is neither a filter nor a group of trends, or both.
    #[error(
        "expected for the view {0:?} either series, a list for the trends, or a filter of the overview: one or more of search, group, \
         tag, location and state"
    )]
    ViewContent(String),
    /// The state of a view does not exist.
    #[error("expected a state, one of {}, found {found:?}", view_states())]
    UnknownViewState {
        /// The word.
        found: String,
    },
    /// No gauge has this label.
    #[error("no gauge has the {item} {name:?}{}; add it to a [[segment.gauge]], or change the view", hint(.suggestion.as_deref()))]
    UnknownLabel {
        /// The kind of label.
        item: NamedItem,
        /// The label.
        name: String,
        /// The most similar label.
        suggestion: Option<String>,
    },
    /// The file has too many plant states.
    #[error("expected at most {most} [[plant-state]], found {found}; delete some")]
    TooManyPlantStates {
        /// The permitted number.
        most: usize,
        /// The number.
        found: usize,
    },
    /// A plant state says not what it suppresses.
    #[error(
        "expected for the plant state {0:?} what it suppresses: one or more of gauges, groups, tags, zones, segments, kinds and alarms"
    )]
    PlantStateContent(String),
    /// An entry of a plant state selects no alarm.
    #[error(
        "{key}: no alarm of the kinds {kinds} is about {name:?}, so the entry suppresses nothing; add an [[alarm]] about it, change \
         kinds, or delete the entry"
    )]
    PlantStateSelectsNothing {
        /// The key of the entry.
        key: &'static str,
        /// The entry.
        name: String,
        /// The kinds of the plant state.
        kinds: String,
    },
    /// A kind of a plant state selects no alarm.
    #[error(
        "kinds: the plant state {state:?} has no alarm of the kind {kind}; delete it, or add the gauges of such an alarm"
    )]
    PlantStateKind {
        /// The kind.
        kind: String,
        /// The plant state.
        state: String,
    },
    /// The kind of alarms does not exist, or is never suppressed.
    #[error("expected a kind of alarms, one of {known}, found {found:?}")]
    UnknownAlarmKind {
        /// The word.
        found: String,
        /// The kinds.
        known: String,
    },
    /// No gauge or volume has this label.
    #[error("no gauge has the {item} {name:?}{}; add it to a {}, or change the plant state", hint(.suggestion.as_deref()), label_table(*.item))]
    UnknownPlantStateLabel {
        /// The kind of label.
        item: NamedItem,
        /// The label.
        name: String,
        /// The most similar label.
        suggestion: Option<String>,
    },
    /// No alarm has this name.
    #[error("there is no alarm {name:?}{}; the page Alarms and /api/alarms have all names", hint(.suggestion.as_deref()))]
    UnknownAlarm {
        /// The name.
        name: String,
        /// The most similar name of an alarm.
        suggestion: Option<String>,
    },
    /// The alarm about the database is never suppressed.
    #[error("no plant state suppresses the alarm {0:?}: a station must record in every state; delete the entry")]
    NeverSuppressed(String),
    /// `longest` is out of range.
    #[error("expected a time from 1m to 31 days, found {0}")]
    LongestDeclared(TimeSpan),
    /// The role that declares a plant state does not exist, or only reads.
    #[error("expected operator or engineer, found {0:?}")]
    DeclaringRole(String),
    /// The drawing of the plant cannot be used.
    #[error("{}: {problem}", file.display())]
    Drawing {
        /// Its file.
        file: PathBuf,
        /// Why.
        problem: DrawingFileProblem,
    },
    /// A gauge has too many tags.
    #[error("expected at most {most} tags for a gauge, found {found}; delete some, or use group")]
    TooManyTags {
        /// The permitted number.
        most: usize,
        /// The number.
        found: usize,
    },
    /// `calibrated` is no date.
    #[error("expected the day of the last calibration without quotes and time, such as 2026-05-01, found {0}")]
    CalibrationDate(String),
    /// `calibration-interval` is no time, or out of range.
    #[error("expected a time from 1 day to 36525 days, such as \"365 days\", found {0:?}")]
    CalibrationInterval(String),
    /// `calibration-interval` without `calibrated`.
    #[error(
        "calibration-interval counts from the last calibration: add calibrated = DATE, such as 2026-05-01, or delete it"
    )]
    IntervalWithoutCalibration,
    /// No segment has this name.
    #[error("there is no segment {name:?}; write the name of a [[segment]], or add one{}", hint(.suggestion.as_deref()))]
    UnknownSegment {
        /// The name.
        name: String,
        /// The most similar name of a segment.
        suggestion: Option<String>,
    },
    /// The default alarm for the database has nothing to be excepted from.
    #[error("the alarm about the database applies to the whole station and has no exceptions; found {0:?}")]
    NoExceptions(String),
    /// An alarm has the name of a default alarm.
    #[error("{0:?} is the name of a default alarm; choose another name, or change the default alarm in [alarms]")]
    DefaultAlarmName(String),
    /// An alarm has no condition, or several.
    #[error("expected one of above, below and rise for the alarm {0:?}")]
    OneCondition(String),
    /// `count` is 0, or more than the list `gauges` has.
    #[error("expected count from 1 to the number of gauges, which is {gauges}, got {count}")]
    CountOfGauges {
        /// The value of `count`.
        count: usize,
        /// The length of the list.
        gauges: usize,
    },
    /// The list `gauges` has a gauge twice.
    #[error("{0:?} is twice in the list of gauges")]
    RepeatedGauge(String),
    /// `unacknowledged-after` is too short or too long.
    #[error("expected a time from 1s to 1 day, found {0}")]
    UnacknowledgedAfter(TimeSpan),
    /// `quiet` is not two times.
    #[error("expected the beginning and the end of the quiet hours such as 22:00-06:00, found {0:?}")]
    QuietHours(String),
    /// `window` is given without `rise`.
    #[error("window applies to rise only")]
    WindowWithoutRise,
    /// `reset` is given with `rise`.
    #[error("reset does not apply to rise; use hysteresis, in decades per minute")]
    ResetWithRise,
    /// `reset` and `hysteresis` are both given.
    #[error("expected reset or hysteresis, found both")]
    ResetAndHysteresis,
    /// A limit is not a positive pressure.
    #[error("expected a pressure above 0, found {0}")]
    LimitNotPositive(String),
    /// The reset of a limit is on the wrong side of the limit.
    #[error("expected a reset not {side} the limit {limit}, found {reset}")]
    ResetBeyondLimit {
        /// `above` or `below`.
        side: &'static str,
        /// The limit with its unit.
        limit: String,
        /// The reset with its unit.
        reset: String,
    },
    /// No reading of the gauge can be beyond the limit.
    #[error(
        "expected a limit in the range of a {device}, {lowest} to {highest}, found {limit}: no reading is beyond it, so the alarm \
         could never be raised"
    )]
    LimitBeyondRange {
        /// The limit.
        limit: String,
        /// The device.
        device: &'static str,
        /// The lower end of its range.
        lowest: String,
        /// The upper end of its range.
        highest: String,
    },
    /// A number is out of range.
    #[error("expected {quantity} {range}, found {found}")]
    OutOfRange {
        /// The quantity with its unit.
        quantity: &'static str,
        /// The permitted range.
        range: NumberRange,
        /// The number.
        found: f64,
    },
    /// The window of a rise is out of range.
    #[error("expected a window from 5s to 10m, found {0}")]
    Window(TimeSpan),
    /// A delay is too long.
    #[error("expected a delay of at most 1h, found {0}")]
    Delay(TimeSpan),
    /// A priority does not exist.
    #[error("expected a priority, one of {}, found {found:?}", priorities(*.may_be_off))]
    UnknownPriority {
        /// The word.
        found: String,
        /// Whether `off` is permitted.
        may_be_off: bool,
    },
    /// `limit` is given for another default alarm than `damage`.
    #[error("only damage has a limit, in telegrams per minute")]
    LimitWithoutDamage,
    /// The URL of a webhook cannot be used.
    #[error("expected a URL like https://host/path, found {0}")]
    WebhookUrl(WebhookUrlProblem),
    /// The program sends no e-mail.
    #[error(
        "the file has [[email]], and this program was built without e-mail: delete the table, or build with --features email"
    )]
    WithoutEmail,
    /// The server of an e-mail cannot be used.
    #[error("expected a mail server like smtp.example.org or smtp.example.org:587, found {0:?}")]
    MailServer(String),
    /// The way to encrypt does not exist.
    #[error("expected security, one of starttls, tls, none, found {0:?}")]
    MailSecurity(String),
    /// A message would travel unencrypted to another computer.
    #[error(
        "expected starttls or tls for the mail server {0}: only a server on this computer may have security = \"none\""
    )]
    MailWithoutTls(String),
    /// An address is none.
    #[error("expected an address like ada@example.org or Ada <ada@example.org>, found {0:?}")]
    MailAddress(String),
    /// No recipients, or too many.
    #[error("expected 1 to 50 recipients, found {0}; a longer list belongs to the mail server")]
    Recipients(usize),
    /// A user without a password, or the reverse.
    #[error("expected user and password-file together")]
    MailCredentials,
    /// The address of the dashboard is none.
    #[error("expected a link like https://vacuum.example:8443, found {0:?}")]
    MailLink(String),
    /// `token` and `token-file` are both given.
    #[error("expected token or token-file, found both")]
    TwoTokens,
    /// A table that the files of a station and of an archive share.
    #[error(transparent)]
    Table(TableProblem),
    /// The time after which a gateway closes an idle connection is out of range.
    #[error("expected an idle time from 1s to 1h, found {0}")]
    Idle(TimeSpan),
    /// Two gauges have the same slot.
    #[error(
        "the slot {slot} belongs to the gauge {gauge:?}; choose another number, or delete the key for the next free slot"
    )]
    SlotInUse {
        /// The slot.
        slot: u16,
        /// The gauge that has it.
        gauge: String,
    },
    /// A gateway listens beyond loopback without protection.
    #[error("[{gateway}] listens beyond loopback on {listen}, which needs {needs}; without, listen on 127.0.0.1")]
    GatewayExposed {
        /// The name of its table.
        gateway: &'static str,
        /// The address.
        listen: SocketAddr,
        /// The protection that is missing.
        needs: &'static str,
    },
    /// The certificates of a webhook cannot be read.
    #[error(transparent)]
    Certificates(CertificateError),
    /// `[mqtt]` cannot be used.
    #[error(transparent)]
    Mqtt(MqttProblem),
    /// `[archive]` cannot be used.
    #[error(transparent)]
    Archive(ArchiveProblem),
}

/// The reason why `[archive]` cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ArchiveProblem {
    /// A name that is no part of a subject.
    #[error("expected 1 to 60 letters, digits, - and _, found {0:?}: the name is a part of a subject of NATS")]
    Name(String),
    /// A deadband without sense.
    #[error("expected 0.1 to 100 percent, found {0}")]
    Deadband(f64),
    /// A deadband that has no effect.
    #[error("deadband-percent belongs to samples = \"deadband\": delete it, or change samples")]
    DeadbandUnused,
    /// A limit with which no batch arrives.
    #[error("expected at least 1000 octets per second, found {0}")]
    Limit(u32),
    /// Hours until an alarm that are none.
    #[error("expected 0 to 720 hours, found {0}; 0 is for no alarm")]
    AlarmHours(f64),
    /// The table says not where to send.
    #[error(
        "expected [archive.nats] or [archive.https], found neither: name the servers of NATS or the archive to send to"
    )]
    NoTransport,
    /// The table has two destinations.
    #[error("expected [archive.nats] or [archive.https], found both: delete one of them")]
    TwoTransports,
    /// No archive or too many archives that ask the station.
    #[error(
        "expected 1 to 8 URLs in request-urls, found {0}; without the key the station takes requests from the archive of url"
    )]
    RequestUrls(usize),
    /// The URL is not that of an archive.
    #[error("expected a URL like https://archive.example:8443, without a user and a path")]
    Url,
    /// The connection to an archive on another computer is unencrypted, and the file does not say that this is intended.
    #[error(
        "expected https:// for an archive on another computer, found http://, with which everybody on the way reads the values and \
         the token: use https://, or write unencrypted = true if the network is separate"
    )]
    UnencryptedUrl,
    /// The archive takes no such token.
    #[error("expected a token of at least {least} characters, found {found}: `openssl rand -hex 32` makes one")]
    ShortToken {
        /// The fewest characters.
        least: usize,
        /// Those of the file.
        found: usize,
    },
}

/// The reason why a URL cannot be that of a broker.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BrokerUrlProblem {
    /// The URL has no host.
    #[error("a URL without a host")]
    NoHost,
    /// The URL contains a user name.
    #[error("a URL with a user; use credentials instead")]
    User,
    /// The URL contains a path.
    #[error("a URL with a path")]
    Path,
    /// The scheme is neither `mqtts` nor `mqtt`.
    #[error("another scheme")]
    Scheme,
    /// A standby broker has another scheme than the first one.
    #[error("another scheme than that of broker")]
    OtherScheme,
}

/// The reason why `[mqtt]` cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MqttProblem {
    /// The URL is not that of a broker.
    #[error("expected a URL like mqtts://broker.example:8883, found {0}")]
    Url(BrokerUrlProblem),
    /// The connection to another computer is unencrypted, and the file does not say that this is intended.
    #[error(
        "expected mqtts:// for a broker on another computer, found mqtt://, with which everybody on the way reads the values and the \
         password: use mqtts://, or write unencrypted = true if the network is separate"
    )]
    Unencrypted,
    /// A key that belongs to TLS, with a URL without TLS.
    #[error("{0} belongs to mqtts://, and the broker has mqtt://: delete {0}, or use mqtts://")]
    OnlyWithTls(&'static str),
    /// `unencrypted = true` with TLS.
    #[error("unencrypted = true belongs to mqtt://, and the broker has mqtts://: delete it")]
    OnlyWithoutTls,
    /// A certificate without its key, or a key without its certificate.
    #[error("expected certificate and key together, found {0} alone")]
    HalfCertificate(&'static str),
    /// The file holds no private key.
    #[error("expected a private key in PEM in {file}: {error}", file = file.display())]
    Key {
        /// The file.
        file: PathBuf,
        /// The error of the parser.
        error: pem::Error,
    },
    /// The file of the private key is open to others.
    #[error(transparent)]
    Open(PermissionError),
    /// A file holds no certificates.
    #[error(transparent)]
    Certificates(CertificateError),
    /// A part of a topic has characters that MQTT or Sparkplug reserve, or the wrong length.
    #[error("expected {expected}, found {found:?}")]
    Topic {
        /// The permitted values.
        expected: &'static str,
        /// The value.
        found: String,
    },
    /// Neither plain topics nor Sparkplug.
    #[error("expected plain = true or a table [mqtt.sparkplug], found neither: the gateway would publish nothing")]
    Nothing,
    /// A key of the plain topics without plain topics.
    #[error("{0} belongs to the plain topics, and the file has plain = false: delete {0}, or write plain = true")]
    OnlyWithPlain(&'static str),
    /// The backlog is out of range.
    #[error("expected a backlog from 0s to 36525 days, found {0}")]
    Backlog(TimeSpan),
}

fn twice_hint(item: NamedItem) -> &'static str {
    match item {
        NamedItem::Port => "put all its gauges into one segment",
        NamedItem::Tag => "delete one of both",
        NamedItem::Webhook | NamedItem::Email => "give each a name of its own",
        NamedItem::Station
        | NamedItem::Segment
        | NamedItem::Gauge
        | NamedItem::Level
        | NamedItem::Alarm
        | NamedItem::Volume
        | NamedItem::Zone
        | NamedItem::Group
        | NamedItem::Location
        | NamedItem::View
        | NamedItem::Search
        | NamedItem::PlantPart
        | NamedItem::PlantState
        | NamedItem::Description
        | NamedItem::Point
        | NamedItem::Unit
        | NamedItem::CodeText => "choose another name",
    }
}

/// The table that has a label.
const fn label_table(item: NamedItem) -> &'static str {
    match item {
        NamedItem::Zone => "[[volume]] with its gauges",
        _ => "[[segment.gauge]]",
    }
}

fn hint(suggestion: Option<&str>) -> String {
    suggestion.map(|name| format!("; did you mean {name:?}?")).unwrap_or_default()
}

/// The most similar name, or else the names that exist.
fn hint_or_list(suggestion: Option<&str>, known: &[String]) -> String {
    match (suggestion, known) {
        (Some(_), _) => hint(suggestion),
        (None, []) => "; the file has no gauge".to_owned(),
        (None, known) => format!("; the gauges are {}", list(known)),
    }
}

fn view_states() -> String {
    ViewState::ALL.map(ViewState::word).join(", ")
}

fn priorities(may_be_off: bool) -> String {
    let off = may_be_off.then_some("off");
    Priority::ALL.iter().rev().map(|priority| priority.word()).chain(off).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_client::suggestion::MAX_LISTED;

    #[test]
    fn a_wrong_name_gets_the_similar_one_or_the_list() {
        let known = ["chamber".to_owned(), "lock".to_owned()];
        assert_eq!(hint_or_list(Some("chamber"), &known), "; did you mean \"chamber\"?");
        assert_eq!(hint_or_list(None, &known), "; the gauges are chamber, lock");
        assert_eq!(hint_or_list(None, &[]), "; the file has no gauge");
        let many: Vec<_> = (0..=MAX_LISTED).map(|number| number.to_string()).collect();
        assert!(hint_or_list(None, &many).ends_with(", 19 and 1 more"));
    }
}
