//! The connection to PostgreSQL: unencrypted on this computer, with TLS to others.

use profivac_host::text_file;
use profivac_web_server::auth::file_permissions::{self, PermissionError};
use profivac_web_server::client_tls::{fault, is_of_another_name, trusting};
use profivac_web_server::host_name::is_loopback;
use profivac_web_server::tables::{CertificateError, ca_certificates};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use thiserror::Error;
use tokio::task::JoinHandle;
use tokio::time::timeout;
use tokio_postgres::config::{Host, SslMode};
use tokio_postgres::error::SqlState;
use tokio_postgres::{Client, Config, NoTls};
use tokio_postgres_rustls::MakeRustlsConnect;
use tokio_rustls::rustls::{self, ClientConfig};

/// The longest wait for an address of the server.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);

/// The longest wait until the server has taken the login: it may accept the connection and say nothing.
const LOGIN_TIMEOUT: Duration = Duration::from_secs(30);

/// A computer that is gone is noticed after a minute, while a statement waits too. chosen; the system waits for two hours.
const KEEPALIVE: Duration = Duration::from_secs(30);
const KEEPALIVE_INTERVAL: Duration = Duration::from_secs(10);
const KEEPALIVES: u32 = 3;

/// `[postgres]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct PostgresToml {
    /// How to connect: `host=`, `port=`, `user=`, `dbname=` as in libpq, without a password.
    connection: String,
    /// The file with the password, which only its owner may read.
    password_file: Option<PathBuf>,
    /// Certificates in PEM that are trusted in addition to those of the system, for a database on another computer.
    ca_file: Option<PathBuf>,
    /// `true` permits a connection to another computer without TLS. Default: `false`.
    #[serde(default)]
    unencrypted: bool,
}

/// Why `[postgres]` is wrong.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DatabaseProblem {
    /// The connection cannot be read.
    #[error("expected connection = \"host=/run/postgresql user=profivac dbname=profivac\" in [postgres]: {0}")]
    Connection(tokio_postgres::Error),
    /// The connection has a password.
    #[error("connection in [postgres] has a password: put it into a file, and name that in password-file")]
    Password,
    /// The connection forbids TLS to another computer.
    #[error(
        "the database is on another computer, and sslmode=disable sends passwords and data unencrypted: remove it, or write \
         unencrypted = true in [postgres] if the network is separate"
    )]
    Unencrypted,
    /// A file with a password is open to others.
    #[error(transparent)]
    Open(#[from] PermissionError),
    /// The file with the password cannot be read.
    #[error("{file} cannot be read: {error}", file = file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// The error of the system.
        error: std::io::Error,
    },
    /// The file with certificates cannot be used.
    #[error(transparent)]
    Certificates(#[from] CertificateError),
    /// The TLS library offers no protocol version.
    #[error(transparent)]
    Tls(#[from] rustls::Error),
}

/// How the database is reached.
#[derive(Clone, Debug)]
pub struct Database {
    config: Config,
    tls: Option<Arc<ClientConfig>>,
}

impl Database {
    /// Checks `[postgres]`. Files are in `folder`.
    ///
    /// # Errors
    /// [`DatabaseProblem`] says what to change.
    pub fn new(toml: &PostgresToml, folder: &Path) -> Result<Self, DatabaseProblem> {
        let mut config: Config = toml.connection.parse().map_err(DatabaseProblem::Connection)?;
        if config.get_password().is_some() {
            return Err(DatabaseProblem::Password);
        }
        let is_near = is_near(&config);
        let mode = config.get_ssl_mode();
        if mode == SslMode::Disable && !is_near && !toml.unencrypted {
            return Err(DatabaseProblem::Unencrypted);
        }
        // The default of the library, prefer, is unencrypted when the server wants it so.
        let uses_tls = mode == SslMode::Require || !(is_near || toml.unencrypted);
        config.ssl_mode(if uses_tls { SslMode::Require } else { SslMode::Disable });
        if let Some(file) = &toml.password_file {
            config.password(password(folder.join(file))?);
        }
        config.application_name("profivac archive").connect_timeout(CONNECT_TIMEOUT);
        // The file may have its own.
        if config.get_keepalives_retries().is_none() {
            config.keepalives_idle(KEEPALIVE).keepalives_interval(KEEPALIVE_INTERVAL).keepalives_retries(KEEPALIVES);
        }
        Ok(Self { config, tls: if uses_tls { Some(tls(toml, folder)?) } else { None } })
    }

    /// Connects. The task carries the connection, until the client is dropped.
    ///
    /// # Errors
    /// When the server cannot be reached, says nothing, has no certificate that is trusted, or refuses the login.
    pub async fn connect(&self) -> Result<(Client, JoinHandle<()>), ConnectError> {
        self.connect_within(LOGIN_TIMEOUT).await
    }

    async fn connect_within(&self, longest: Duration) -> Result<(Client, JoinHandle<()>), ConnectError> {
        timeout(longest, self.log_in()).await.map_err(|_| ConnectError::Silent(longest))?.map_err(ConnectError::Refused)
    }

    async fn log_in(&self) -> Result<(Client, JoinHandle<()>), tokio_postgres::Error> {
        // The error of a connection is also that of the statement that waits.
        match &self.tls {
            None => {
                let (client, connection) = self.config.connect(NoTls).await?;
                Ok((client, tokio::spawn(async { connection.await.unwrap_or_default() })))
            }
            Some(tls) => {
                let tls = MakeRustlsConnect::new(ClientConfig::clone(tls));
                let (client, connection) = self.config.connect(tls).await?;
                Ok((client, tokio::spawn(async { connection.await.unwrap_or_default() })))
            }
        }
    }
}

/// Why there is no connection to the database.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ConnectError {
    /// It cannot be reached, or refuses the login.
    #[error("{}", described(.0))]
    Refused(tokio_postgres::Error),
    /// It says nothing.
    #[error("it has not answered for {} s", .0.as_secs())]
    Silent(Duration),
}

/// The error with its cause: that of the library alone says only "db error".
pub(crate) fn described(error: &tokio_postgres::Error) -> String {
    match (error.as_db_error(), std::error::Error::source(error)) {
        (Some(error), _) => match advice(error.code()) {
            Some(advice) => format!("{error}; {advice}"),
            None => error.to_string(),
        },
        (None, Some(source)) if fault(source).is_some_and(is_of_another_name) => {
            format!("{error}: {source}; write a name of the certificate as host in connection of [postgres]")
        }
        (None, Some(source)) if matches!(fault(source), Some(rustls::Error::InvalidCertificate(_))) => {
            format!("{error}: {source}; name a file with the certificate of its issuer in ca-file of [postgres]")
        }
        (None, Some(source)) if source.is::<std::io::Error>() => {
            format!("{error}: {source}; check that it runs, and host and port in connection of [postgres]")
        }
        (None, Some(source)) if source.to_string() == NO_PASSWORD => {
            format!("{error}: {source}; name a file with it in password-file of [postgres]")
        }
        (None, Some(source)) => format!("{error}: {source}"),
        (None, None) => error.to_string(),
    }
}

/// What the library says when the server wants a password and the file has none.
const NO_PASSWORD: &str = "password missing";

/// What a person can do about a refusal of the database.
fn advice(state: &SqlState) -> Option<&'static str> {
    if [SqlState::INVALID_PASSWORD, SqlState::INVALID_AUTHORIZATION_SPECIFICATION].contains(state) {
        return Some("check user in connection of [postgres], password-file, and pg_hba.conf of the database");
    }
    match *state {
        SqlState::INVALID_CATALOG_NAME => {
            Some("correct dbname in connection of [postgres], or make the database: createdb -O USER DATABASE")
        }
        SqlState::INSUFFICIENT_PRIVILEGE => {
            Some("let the user in connection of [postgres] own the database: ALTER DATABASE ... OWNER TO ...")
        }
        SqlState::UNDEFINED_OBJECT => Some("make the role with CREATE ROLE, or correct readers of [[plant]]"),
        // Of a former session: each session makes its own temporary tables.
        SqlState::DUPLICATE_TABLE => Some(
            "if a pool of connections is between the archive and the database, let it pool by session: pool_mode = session in pgbouncer.ini",
        ),
        _ => None,
    }
}

/// Whether every server is on this computer. Where both are given, the library connects to `hostaddr`, and `host` is only a name.
fn is_near(config: &Config) -> bool {
    let is_near_host = |host: &Host| match host {
        #[cfg(unix)]
        Host::Unix(_) => true,
        Host::Tcp(host) => is_loopback(host),
    };
    config.get_hosts().iter().all(is_near_host) && config.get_hostaddrs().iter().all(|address| address.is_loopback())
}

fn tls(toml: &PostgresToml, folder: &Path) -> Result<Arc<ClientConfig>, DatabaseProblem> {
    let file = toml.ca_file.as_ref().map(|file| folder.join(file));
    let trusted = file.as_deref().map(ca_certificates).transpose()?.unwrap_or_default();
    Ok(Arc::new(trusting(trusted)?.with_no_client_auth()))
}

fn password(file: PathBuf) -> Result<String, DatabaseProblem> {
    // Reading reports why the file cannot be read.
    if let Err(error @ PermissionError::Open(..)) = file_permissions::check(&file) {
        return Err(error.into());
    }
    let text = text_file::read(&file).map_err(|error| DatabaseProblem::Read { file, error })?;
    Ok(text.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::net::TcpListener;

    fn database(connection: &str) -> Database {
        let toml =
            PostgresToml { connection: connection.to_owned(), password_file: None, ca_file: None, unencrypted: false };
        Database::new(&toml, Path::new("")).unwrap()
    }

    #[tokio::test]
    async fn a_server_that_accepts_and_says_nothing_is_an_error() {
        let listener = TcpListener::bind(("127.0.0.1", 0)).await.unwrap();
        let port = listener.local_addr().unwrap().port();
        let silent = database(&format!("host=127.0.0.1 port={port} user=profivac"));
        let longest = Duration::from_millis(50);
        let connected = silent.connect_within(longest).await;
        assert!(matches!(connected, Err(ConnectError::Silent(waited)) if waited == longest));
    }

    #[test]
    fn a_server_that_is_gone_is_noticed_within_a_minute_unless_the_file_says_otherwise() {
        let config = |connection| database(connection).config;
        let usual = config("host=127.0.0.1");
        let longest = usual.get_keepalives_idle()
            + usual.get_keepalives_interval().unwrap() * usual.get_keepalives_retries().unwrap();
        assert_eq!(longest, Duration::from_secs(60));
        let own = config("host=127.0.0.1 keepalives_retries=9 keepalives_idle=5");
        assert_eq!((own.get_keepalives_retries(), own.get_keepalives_idle()), (Some(9), Duration::from_secs(5)));
    }

    #[tokio::test]
    async fn a_server_that_cannot_be_reached_names_the_key() {
        let listener = TcpListener::bind(("127.0.0.1", 0)).await.unwrap();
        let port = listener.local_addr().unwrap().port();
        drop(listener);
        let gone = database(&format!("host=127.0.0.1 port={port} user=profivac")).connect().await;
        let error = gone.err().unwrap().to_string();
        assert!(error.ends_with("check that it runs, and host and port in connection of [postgres]"), "{error}");
    }

    #[test]
    fn a_refusal_says_what_to_change() {
        for (state, key) in [
            (SqlState::INVALID_PASSWORD, "password-file"),
            (SqlState::INVALID_AUTHORIZATION_SPECIFICATION, "pg_hba.conf"),
            (SqlState::INVALID_CATALOG_NAME, "dbname"),
            (SqlState::INSUFFICIENT_PRIVILEGE, "OWNER TO"),
            (SqlState::UNDEFINED_OBJECT, "readers of [[plant]]"),
            (SqlState::DUPLICATE_TABLE, "pool_mode = session"),
        ] {
            assert!(advice(&state).unwrap().contains(key), "{state:?}");
        }
        assert_eq!(advice(&SqlState::DISK_FULL), None);
    }
}
