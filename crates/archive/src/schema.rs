//! The tables and views of the database, and how an older one gets them.
//!
//! Tables are in the schema `profivac_data`, views for people and Grafana in `profivac`. Each migration runs in one transaction. A
//! published migration never changes.

use crate::database::described;
use tokio_postgres::{Client, Error};

/// The migrations: number N leads from version N - 1 to version N.
const MIGRATIONS: [&str; 9] = [
    include_str!("../sql/1.sql"),
    include_str!("../sql/2.sql"),
    include_str!("../sql/3.sql"),
    include_str!("../sql/4.sql"),
    include_str!("../sql/5.sql"),
    include_str!("../sql/6.sql"),
    include_str!("../sql/7.sql"),
    include_str!("../sql/8.sql"),
    include_str!("../sql/9.sql"),
];

/// The number that locks the database while an archive changes its tables. chosen.
pub const LOCK: i64 = 0x7066_7663;

/// Why the tables cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SchemaError {
    /// The database has refused a statement.
    #[error("the tables cannot be made: {}", described(.0))]
    Database(#[from] Error),
    /// The database was used by a newer program.
    #[error("the tables have version {found}, and this program knows versions up to {known}: update it")]
    Newer {
        /// The version of the tables.
        found: i32,
        /// The version of this program.
        known: usize,
    },
}

/// Makes the tables of an empty database, or migrates an older one. Several archives may do so at once.
///
/// # Errors
/// [`SchemaError`]; the database is then as it was.
pub async fn upgrade(client: &mut Client) -> Result<(), SchemaError> {
    let transaction = client.transaction().await?;
    transaction.execute("SELECT pg_advisory_xact_lock($1)", &[&LOCK]).await?;
    transaction
        .batch_execute(
            "CREATE SCHEMA IF NOT EXISTS profivac_data;
             CREATE TABLE IF NOT EXISTS profivac_data.version (number integer NOT NULL)",
        )
        .await?;
    let row = transaction.query_one("SELECT coalesce(max(number), 0) FROM profivac_data.version", &[]).await?;
    let found: i32 = row.get(0);
    let Some(missing) = usize::try_from(found).ok().and_then(|done| MIGRATIONS.get(done..)) else {
        return Err(SchemaError::Newer { found, known: MIGRATIONS.len() });
    };
    for migration in missing {
        transaction.batch_execute(migration).await?;
        transaction
            .execute(
                "INSERT INTO profivac_data.version SELECT coalesce(max(number), 0) + 1 FROM profivac_data.version",
                &[],
            )
            .await?;
    }
    Ok(transaction.commit().await?)
}
