//! Connections to the database for requests: a few, so that many clients cost the database no more than a few statements at a time.

use crate::database::{ConnectError, Database, described};
use profivac_web_server::problem::Problem;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::timeout;
use tokio_postgres::types::ToSql;
use tokio_postgres::{Client, Row};

/// Statements at the same time. chosen.
const MAX_CONNECTIONS: usize = 4;

/// The longest wait for a connection.
const PERMIT_TIMEOUT: Duration = Duration::from_secs(10);

/// The longest wait for the rows: a database that runs gives up before.
const ROWS_TIMEOUT: Duration = Duration::from_secs(30);

/// Connections read, and give up after 20 s: chosen, longer than a year of ten series takes.
const SETTINGS: &str = "SET default_transaction_read_only = on; SET statement_timeout = '20s'; SET timezone = 'UTC'";

/// Why the database does not answer.
#[derive(Debug, thiserror::Error)]
pub enum PoolError {
    /// All connections are in use.
    #[error("too many requests wait for the database; try again")]
    Busy,
    /// There is no connection.
    #[error("the database of the archive does not answer: {0}")]
    Connect(#[from] ConnectError),
    /// The database has refused something.
    #[error("the database of the archive does not answer: {}", described(.0))]
    Database(#[from] tokio_postgres::Error),
    /// The database has not refused, and sends nothing.
    #[error("the database of the archive has not answered for {} s", .0.as_secs())]
    Silent(Duration),
}

impl From<PoolError> for Problem {
    fn from(error: PoolError) -> Self {
        // Class 22 of SQL: a value of the request that the database has no form for, for instance a text with the octet 0.
        let is_of_request =
            |error: &tokio_postgres::Error| error.code().is_some_and(|code| code.code().starts_with("22"));
        match &error {
            PoolError::Database(cause) if is_of_request(cause) => Self::bad_request(described(cause)),
            _ => Self::unavailable(error.to_string()),
        }
    }
}

/// The connections.
#[derive(Clone)]
pub struct Pool {
    database: Database,
    permits: Arc<Semaphore>,
    idle: Arc<Mutex<Vec<Client>>>,
}

impl Pool {
    /// A pool without connections. They are made when they are needed.
    pub fn of(database: Database) -> Self {
        Self { database, permits: Arc::new(Semaphore::new(MAX_CONNECTIONS)), idle: Arc::default() }
    }

    /// The rows of a query.
    ///
    /// # Errors
    /// [`PoolError`].
    pub async fn query(&self, sql: &str, parameters: &[&(dyn ToSql + Sync)]) -> Result<Vec<Row>, PoolError> {
        let (client, _permit) = self.client().await?;
        let rows = timeout(ROWS_TIMEOUT, client.query(sql, parameters)).await;
        let rows = rows.map_err(|_| PoolError::Silent(ROWS_TIMEOUT))??;
        // A connection with an error is dropped.
        self.idle.lock().unwrap_or_else(PoisonError::into_inner).push(client);
        Ok(rows)
    }

    async fn client(&self) -> Result<(Client, OwnedSemaphorePermit), PoolError> {
        let permit = timeout(PERMIT_TIMEOUT, Arc::clone(&self.permits).acquire_owned()).await;
        let Ok(Ok(permit)) = permit else { return Err(PoolError::Busy) };
        let idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        if let Some(client) = idle.filter(|client| !client.is_closed()) {
            return Ok((client, permit));
        }
        let (client, _task) = self.database.connect().await?;
        let set = timeout(ROWS_TIMEOUT, client.batch_execute(SETTINGS)).await;
        set.map_err(|_| PoolError::Silent(ROWS_TIMEOUT))??;
        Ok((client, permit))
    }
}
