//! What the database has of each station, and which batches it lacks: the stations are told, and send again what they still have.

use super::{Store, StoreError};
use crate::metrics::StationFigures;
use profivac_archive_protocol::request::{Copied, Missing, Status};
use profivac_recorder::Micros;
use std::collections::{BTreeMap, HashMap};
use std::time::Duration;
use tokio_postgres::Row;

/// The time between two searches for gaps in the numbers of batches. chosen: a station keeps its batches for a day at least.
pub const SEARCH_INTERVAL: Duration = Duration::from_secs(30);

/// The most gaps that a station is told at once, in any order: those that it cannot fill keep out no others.
const MAX_GAPS: i64 = 16;

/// The most characters of the reason that a station is told.
const MAX_REASON: usize = 500;

/// What a station is told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StationStatus {
    /// Its plant.
    pub plant: String,
    /// Its name.
    pub station: String,
    /// What the database has of it.
    pub status: Status,
}

/// A gap that was not filled for a week will not be: a station keeps unconfirmed batches no longer, and need not keep the later ones for it.
const STATIONS: &str = "
    SELECT station.id, station.plant, station.name, station.epoch,
        coalesce((SELECT min(gap.first) - 1 FROM profivac_data.gap WHERE gap.station = station.id AND gap.epoch = station.epoch
            AND gap.found > clock_timestamp() - interval '7 days'), epoch.settled, 0) AS stored,
        epoch.copied, put_aside.count, put_aside.reason,
        (SELECT least(sum(gap.last - gap.first + 1), 9223372036854775807)::bigint FROM profivac_data.gap WHERE gap.station = station.id) AS missing,
        (extract(epoch FROM last.made) * 1000000)::bigint AS made, (extract(epoch FROM last.stored) * 1000000)::bigint AS batch_stored
    FROM profivac_data.station LEFT JOIN profivac_data.epoch ON epoch.station = station.id AND epoch.epoch = station.epoch
    LEFT JOIN profivac_data.put_aside ON put_aside.station = station.name LEFT JOIN LATERAL (
        SELECT made, stored FROM profivac_data.batch
        WHERE batch.station = station.id AND batch.epoch = station.epoch ORDER BY number DESC LIMIT 1
    ) AS last ON true";

const GAPS: &str = "
    SELECT station, epoch, first, last FROM (
        SELECT station, epoch, first, last, row_number() OVER (PARTITION BY station ORDER BY random()) AS place FROM profivac_data.gap
    ) AS placed WHERE place <= $1";

const CLAIM: &str =
    "UPDATE profivac_data.told SET at = clock_timestamp() WHERE at < clock_timestamp() - make_interval(secs => $1)";

impl Store {
    /// Notes the gaps in the numbers of batches. Returns what the database has of each station.
    ///
    /// # Errors
    /// [`StoreError`] when the database refuses.
    pub async fn find_gaps(&self) -> Result<Vec<StationStatus>, StoreError> {
        self.client.execute("SELECT profivac_data.find_gaps()", &[]).await?;
        let mut gaps: HashMap<i32, Vec<Missing>> = HashMap::new();
        for row in self.client.query(GAPS, &[&MAX_GAPS]).await? {
            gaps.entry(row.get("station")).or_default().push(missing(&row));
        }
        let status = |row: &Row| {
            let missing = gaps.get(&row.get("id")).cloned().unwrap_or_default();
            let put_aside = row.get::<_, Option<i64>>("count").and_then(|count| u64::try_from(count).ok()).unwrap_or(0);
            let reason: Option<String> = row.get("reason");
            let reason = reason.map(|reason| reason.chars().take(MAX_REASON).collect());
            let epoch = row.get("epoch");
            let copied = row.get::<_, Option<i64>>("copied").map(|first| Copied { epoch, first });
            let status = Status { epoch, stored: row.get("stored"), missing, copied, put_aside, reason };
            StationStatus { plant: row.get("plant"), station: row.get("name"), status }
        };
        let stations = self.client.query(STATIONS, &[]).await?;
        let figures = stations.iter().map(|row| ((row.get("plant"), row.get("name")), figures(row)));
        self.metrics.found(BTreeMap::from_iter(figures));
        Ok(stations.iter().map(status).collect())
    }

    /// Whether this archive is to tell the stations now: of several archives one does.
    ///
    /// # Errors
    /// [`StoreError`] when the database refuses.
    pub async fn claim_telling(&self) -> Result<bool, StoreError> {
        let least = SEARCH_INTERVAL.mul_f64(0.8).as_secs_f64();
        Ok(self.client.execute(CLAIM, &[&least]).await? == 1)
    }
}

fn figures(row: &Row) -> StationFigures {
    let count = |name| row.get::<_, Option<i64>>(name).and_then(|count| u64::try_from(count).ok()).unwrap_or(0);
    let time = |name| row.get::<_, Option<i64>>(name).map(Micros);
    StationFigures {
        missing: count("missing"),
        rejected: count("count"),
        stored: time("batch_stored"),
        made: time("made"),
    }
}

fn missing(row: &Row) -> Missing {
    Missing { epoch: row.get("epoch"), first: row.get("first"), last: row.get("last") }
}
