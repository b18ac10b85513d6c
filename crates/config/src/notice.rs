//! Notices about a valid configuration file.

use super::error::{ConfigProblem, Located};
use super::file::ConfigToml;
use profivac_client::cyclic::IntegerRange;
use profivac_host::text_file::line_and_column;
use profivac_recorder::{Forward, Retention};
use profivac_station::config::{Config, RenamedKey, Segment};
use profivac_web_server::auth::openid::OpenIdSettings;
use std::fmt;
use std::ops::Range;
use std::path::Path;
use std::time::Duration;

/// A setting that is valid but probably not intended.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ConfigNotice {
    /// A segment without gauges.
    #[error(
        "the segment {segment:?} has no [[segment.gauge]], so nothing of it is recorded; `profivac init` finds gauges"
    )]
    EmptySegment {
        /// The name of the segment.
        segment: String,
    },
    /// The integers of a gauge of another master do not show its whole range.
    #[error("the gauge {gauge:?}: {range}")]
    IntegerRange {
        /// The name of the gauge.
        gauge: String,
        /// The pressures that they show.
        range: IntegerRange,
    },
    /// The integers of a gauge of another master show other pressures in each unit, and the file does not name the unit.
    #[error(
        "the gauge {gauge:?}: its integers show only {ranges}: a higher pressure is over range, a lower one is under range; declare its unit, \
         and choose a module with floats if the limits are too narrow"
    )]
    IntegersWithoutUnit {
        /// The name of the gauge.
        gauge: String,
        /// The pressures that they show in each unit.
        ranges: String,
    },
    /// The parameters of an owned slave lack something, or its GSD file does not have the rate of the segment.
    #[error("the slave {slave:?}: {remark}")]
    Slave {
        /// The name of the slave.
        slave: String,
        /// What is wrong.
        remark: String,
    },
    /// A gateway whose protocol has neither encryption nor login listens beyond this computer.
    #[error(
        "[{gateway}] listens on {listen} without encryption and login, because the protocol has none: every program on a computer that \
         reaches it reads all values, and the network between can change them; use a network of the control system"
    )]
    UnprotectedGateway {
        /// The name of its table.
        gateway: &'static str,
        /// The addresses.
        listen: String,
    },
    /// A key with a former name.
    #[error(transparent)]
    RenamedKey(RenamedKey),
    /// The connection of a gateway to a broker or server on another computer has no encryption.
    #[error(
        "[{gateway}] connects to {host} without encryption (unencrypted = true): everybody on the way reads the values and the password, \
         and can change them"
    )]
    UnencryptedBroker {
        /// The name of its table.
        gateway: &'static str,
        /// The host of the broker or server.
        host: String,
    },
    /// Clients of a control system may write.
    #[error(
        "[{gateway}] lets programs on {clients} write as the user {user} without a login: they act with the role of that user, and the audit \
         trail names that user"
    )]
    WritableGateway {
        /// The name of its table.
        gateway: &'static str,
        /// The computers.
        clients: String,
        /// The user.
        user: String,
    },
}

/// What the GSD files of slaves say about the settings. A slave that the station does not own gets no parameters from it.
pub fn about_slaves(segments: &[Segment]) -> impl Iterator<Item = ConfigNotice> {
    let all = segments.iter().flat_map(|segment| segment.slaves.iter().map(move |slave| (segment, slave)));
    all.flat_map(|(segment, slave)| {
        let warnings = if slave.is_owned { slave.gsd.warnings() } else { Vec::new() };
        let rate = slave.gsd.device().check_rate(segment.baud.bits_per_second()).err();
        let rate = rate.filter(|_| !segment.detects_baud);
        let rate = rate.map(|error| format!("{error}: set a baud of the segment that all its slaves have"));
        let remarks = warnings.iter().map(ToString::to_string).chain(rate).collect::<Vec<_>>();
        remarks.into_iter().map(|remark| ConfigNotice::Slave { slave: slave.name.clone(), remark })
    })
}

/// A setting that differs from that of the running station and takes effect at its next start.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RestartNeeded {
    /// The key.
    pub key: &'static str,
    /// The setting of the running station.
    pub running: String,
    /// The setting of the changed file.
    pub configured: String,
}

impl fmt::Display for RestartNeeded {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { key, running, configured } = self;
        write!(formatter, "{key} stays {running} until the station is restarted, then it becomes {configured}")
    }
}

/// The keys of `file` that are written with a former name.
pub fn renamed_keys(file: &ConfigToml, text: &str, path: &Path) -> Result<Vec<RenamedKey>, Located> {
    let renamed = |(old, new): (&'static str, &'static str), old_value: Option<Range<usize>>, is_new_given: bool| {
        let Some(value) = old_value else { return Ok(None) };
        if is_new_given {
            return Err(Located::new(value, ConfigProblem::BothNames { old, new }));
        }
        // Only an equals sign, blanks and quotes stand between a key and its value.
        let key = text.get(..value.start).and_then(|before| before.rfind(old)).unwrap_or(value.start);
        let (line, column) = line_and_column(text, key);
        Ok(Some(RenamedKey { file: path.to_owned(), line, column, old, new }))
    };
    let station = &file.station;
    let alarms = &file.alarms;
    let keys = [
        renamed(("record", "database"), station.record.as_ref().map(|old| old.span()), station.database.is_some()),
        renamed(("record", "database"), alarms.record.as_ref().map(|old| old.span()), alarms.database.is_some()),
        renamed(
            ("blind", "not-measurable"),
            alarms.blind.as_ref().map(|old| old.span()),
            alarms.not_measurable.is_some(),
        ),
    ];
    let keys: Result<Vec<_>, _> = keys.into_iter().collect();
    Ok(keys?.into_iter().flatten().collect())
}

/// A retention in one line.
fn retention(retention: &Retention) -> String {
    let days = |kept: Option<Duration>| {
        kept.map_or_else(|| "unlimited".to_owned(), |kept| format!("{} days", kept.as_secs() / 86_400))
    };
    let Retention { samples, spans: [spans, ..], events, alarm_history, batches } = *retention;
    let [samples, spans, events, history, batches] = [samples, spans, events, alarm_history, batches].map(days);
    format!("samples {samples}, spans {spans}, events {events}, alarm-history {history}, archive-batches {batches}")
}

/// The samples for the archive, as one word.
fn outbox(config: &Config) -> String {
    match config.outbox() {
        None => "without an archive".to_owned(),
        Some(Forward::All) => "all".to_owned(),
        Some(Forward::Deadband(decades)) => format!("deadband of {:.1} percent", (10_f64.powf(decades) - 1.0) * 100.0),
        Some(Forward::Off) => "off".to_owned(),
    }
}

/// The OpenID provider in one line, without its secret.
fn openid(config: &Config) -> String {
    let Some(settings) = &config.openid else { return "off".to_owned() };
    let OpenIdSettings { name, issuer, client_id, url, user_claim, roles_claim, roles, scopes, .. } = settings;
    let roles = roles.iter().map(|(value, role)| format!("{value} {role}")).collect::<Vec<_>>().join(", ");
    let url = url.as_deref().unwrap_or("the address of the server");
    format!(
        "{name} at {issuer} for {client_id} at {url} with {user_claim}, {roles_claim} ({roles}), scopes {}",
        scopes.join(" ")
    )
}

/// The settings that differ in `new` and that the station applies only at its next start.
#[must_use]
pub fn needs_restart(running: &Config, new: &Config) -> Vec<RestartNeeded> {
    let tls = |config: &Config| match &config.tls {
        None => "off".to_owned(),
        Some(tls) => format!("{} with {}", tls.certificate.display(), tls.key.display()),
    };
    let settings = |config: &Config| {
        [
            ("listen", config.listen.to_string()),
            ("database", config.database.display().to_string()),
            ("retention", retention(&config.retention)),
            ("name", config.name.clone()),
            ("users", config.users.path.display().to_string()),
            ("hosts", format!("{:?}", config.hosts)),
            ("tls", tls(config)),
            ("openid", openid(config)),
            ("archive.samples", outbox(config)),
        ]
    };
    let both = settings(running).into_iter().zip(settings(new));
    let is_secret_new = running.openid != new.openid && openid(running) == openid(new);
    let secret = is_secret_new.then(|| RestartNeeded {
        key: "openid",
        running: "as it is".to_owned(),
        configured: "one with the new secret or the new certificates".to_owned(),
    });
    both.filter(|((_, running), (_, new))| running != new)
        .map(|((key, running), (_, configured))| RestartNeeded { key, running, configured })
        .chain(secret)
        .collect()
}
