//! The state of all stations, read from the database again and again: once for all clients, and only what has changed. Readings that
//! pass through JetStream come before.

use super::passing::Passing;
use super::state::{ActiveAlarm, LatestReading, State, StationState};
use super::visibility::Hidden;
use crate::config::Config;
use crate::database::{ConnectError, Database, described};
use crate::schema::{SchemaError, upgrade};
use crate::store::Incoming;
use futures_util::StreamExt;
use profivac_archive_protocol::nats::{INBOX, NatsError, SUBJECTS, connect_for};
use profivac_model::{Micros, Quality, Word};
use profivac_web_server::tables::archive::Nats;
use std::collections::HashMap;
use std::future::pending;
use std::sync::{Arc, PoisonError, RwLock};
use std::time::Duration;
use thiserror::Error;
use tokio::sync::watch;
use tokio::time::{Instant, sleep, timeout};
use tokio_postgres::{Client, Row};

/// The shortest pause between two readings of the database. A station makes a batch at most once a second.
const PERIOD: Duration = Duration::from_secs(1);

/// The longest wait for what a state needs: a first one of a thousand stations takes some seconds.
const READ_TIMEOUT: Duration = Duration::from_secs(60);

/// The pause after a failure.
const PAUSE: Duration = Duration::from_secs(3);

/// Readings that are older are not shown: a gauge with a constant pressure is recorded once in ten minutes at least. The first reading of
/// the database looks as far back.
const LOOK_BACK_DAYS: i32 = 7;

const DAY_MS: i64 = 86_400_000;

/// The most batches that wait in memory for the view. The library drops others, and the database has their readings.
const MAX_WAITING: usize = 1_024;

/// The most alarms of a plant in a state.
const MAX_ALARMS: i64 = 500;

const STATIONS: &str = "
    SELECT station.id, station.plant, station.name, station.epoch, last.number,
        (extract(epoch FROM last.made) * 1000)::bigint AS made, (extract(epoch FROM last.stored) * 1000)::bigint AS stored,
        least(coalesce((SELECT sum(gap.last - gap.first + 1) FROM profivac_data.gap WHERE gap.station = station.id), 0),
            9007199254740991)::bigint AS missing,
        coalesce(put_aside.count, 0) AS put_aside, left(put_aside.reason, 500) AS reason
    FROM profivac_data.station LEFT JOIN profivac_data.put_aside ON put_aside.station = station.name LEFT JOIN LATERAL (
        SELECT number, made, stored FROM profivac_data.batch
        WHERE batch.station = station.id AND batch.epoch = station.epoch ORDER BY number DESC LIMIT 1
    ) AS last ON true";

/// The latest sample of each series, or its latest span of two minutes where that is later by more than the ten minutes within which a
/// constant pressure is recorded: the station sends no samples then. A sample long before the last span is not looked for: a day that is packed
/// has no order of times.
const READINGS: &str = "
    SELECT series.station, series.name, (extract(epoch FROM last.at) * 1000)::bigint AS at, last.pressure_pa, last.quality,
        (extract(epoch FROM span.start) * 1000)::bigint AS start, span.qualities,
        CASE WHEN span.count > 0 THEN 10 ^ (span.log10_sum / span.count) END AS mean_pa
    FROM profivac_data.series LEFT JOIN LATERAL (
        SELECT max(span.start) AS start FROM profivac_data.span WHERE span.series = series.id AND span.level = 2
    ) AS known ON true LEFT JOIN LATERAL (
        SELECT at, pressure_pa, quality FROM profivac_data.sample
        WHERE sample.series = series.id AND sample.at > now() - make_interval(days => $2)
            AND sample.at > coalesce(known.start - interval '1 hour', '-infinity') ORDER BY at DESC LIMIT 1
    ) AS last ON true LEFT JOIN LATERAL (
        SELECT start, qualities, log10_sum, count FROM profivac_data.span
        WHERE (last.at IS NULL OR last.at < now() - interval '10 minutes') AND span.series = series.id AND span.level = 2
            AND span.start > coalesce(last.at + interval '10 minutes', now() - make_interval(days => $2))
        ORDER BY span.start DESC, span.epoch DESC LIMIT 1
    ) AS span ON true
    WHERE series.station = ANY ($1) AND (last.at IS NOT NULL OR span.start IS NOT NULL)";

const ALARMS: &str = "
    SELECT * FROM (
        SELECT plant, station, alarm, state, priority, occurrence, subject, (extract(epoch FROM at) * 1000)::bigint AS at, user_name,
            left(text, 2000) AS text, count(*) OVER (PARTITION BY plant) AS total,
            row_number() OVER (PARTITION BY plant
                ORDER BY CASE state WHEN 'unacknowledged' THEN 0 WHEN 'returned' THEN 1 WHEN 'acknowledged' THEN 2 ELSE 3 END,
                    CASE priority WHEN 'high' THEN 0 WHEN 'medium' THEN 1 ELSE 2 END, active_alarm.at DESC, station, alarm) AS place
        FROM profivac.active_alarm
    ) AS placed WHERE place <= $1";

/// Why the state could not be read.
#[derive(Debug, Error)]
enum WatchError {
    #[error("the database does not answer: {0}")]
    Connect(#[from] ConnectError),
    #[error("the database does not answer: {}", described(.0))]
    Database(#[from] tokio_postgres::Error),
    #[error("the database has not answered for {} s", READ_TIMEOUT.as_secs())]
    Silent,
    #[error(transparent)]
    Schema(#[from] SchemaError),
}

/// The present state. Clones share it.
#[derive(Clone)]
pub struct Watch {
    state: Arc<RwLock<State>>,
    passing: Passing,
}

impl Default for Watch {
    /// A state that was not read yet, and says so.
    fn default() -> Self {
        let problem = Some("the database was not read yet".to_owned());
        Self { state: Arc::new(RwLock::new(State { problem, ..State::default() })), passing: Passing::default() }
    }
}

impl Watch {
    /// The plant of a station, or why the state has none.
    pub(super) fn plant_of(&self, station: &str) -> Result<String, Option<String>> {
        let state = self.state.read().unwrap_or_else(PoisonError::into_inner);
        state.stations.get(station).map(|station| station.plant.clone()).ok_or_else(|| state.problem.clone())
    }

    /// The present state without the plants `hidden`, with the present time.
    pub(super) fn state(&self, hidden: &Hidden) -> State {
        let mut state = self.stored().without(hidden);
        self.passing.add_to(&mut state);
        State { now_ms: Micros::now().0 / 1000, ..state }
    }

    /// The state as it was read from the database.
    fn stored(&self) -> State {
        self.state.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Reads the database again and again, and the batches that pass, until it is told to stop. After a failure of the database the state
    /// stays, with the reason.
    pub async fn run(&self, config: &Config, mut stop: watch::Receiver<bool>) {
        tokio::select! {
            () = self.read_forever(&config.database) => {}
            () = self.follow_forever(config.nats.as_ref()) => {}
            () = async { drop(stop.wait_for(|is_stopped| *is_stopped).await) } => {}
        }
    }

    /// Follows the batches. The archive itself reports failures of the same servers.
    async fn follow_forever(&self, nats: Option<&Nats>) {
        let Some(nats) = nats else { return pending().await };
        loop {
            self.follow(nats).await.ok();
            sleep(PAUSE).await;
        }
    }

    /// One connection to the servers. The library connects again after a failure, and subscribes again.
    async fn follow(&self, nats: &Nats) -> Result<(), NatsError> {
        let client = connect_for(nats, "profivac archive, view", MAX_WAITING, INBOX).await?.client();
        let mut batches = client.subscribe(SUBJECTS).await.map_err(|error| NatsError::new(nats, error))?;
        while let Some(message) = batches.next().await {
            self.passing.take(&Incoming::of(&message), &self.state, Micros::now());
        }
        Ok(())
    }

    async fn read_forever(&self, database: &Database) {
        loop {
            if let Err(error) = self.session(database).await {
                self.state.write().unwrap_or_else(PoisonError::into_inner).problem = Some(error.to_string());
            }
            sleep(PAUSE).await;
        }
    }

    /// One connection to the database; it ends with an error.
    async fn session(&self, database: &Database) -> Result<(), WatchError> {
        let (mut client, _task) = database.connect().await?;
        upgrade(&mut client).await?;
        let mut stations = HashMap::new();
        loop {
            let begun = Instant::now();
            let read = timeout(READ_TIMEOUT, read(&client, &mut stations, self.stored())).await;
            let next = read.map_err(|_| WatchError::Silent)??;
            self.passing.forget_stored(&next);
            *self.state.write().unwrap_or_else(PoisonError::into_inner) = next;
            // Many stations: the database has at least three quarters of its time for batches.
            sleep(PERIOD.max(begun.elapsed() * 3)).await;
        }
    }
}

/// The last batch of each station, by its id.
type LastBatches = HashMap<i32, (String, Option<i64>)>;

/// The state after `before`: readings of stations that have sent a batch since.
async fn read(client: &Client, known: &mut LastBatches, before: State) -> Result<State, tokio_postgres::Error> {
    let mut changed = Vec::new();
    let mut state = State { problem: None, stations: Default::default(), alarms: Default::default(), ..before };
    for row in client.query(STATIONS, &[]).await? {
        let (id, name, number): (i32, String, Option<i64>) = (row.get("id"), row.get("name"), row.get("number"));
        if known.get(&id).is_none_or(|(_, last)| *last != number) {
            known.insert(id, (name.clone(), number));
            changed.push(id);
        }
        let station = StationState {
            plant: row.get("plant"),
            epoch: row.get("epoch"),
            made_ms: row.get("made"),
            stored_ms: row.get("stored"),
            missing: row.get("missing"),
            put_aside: row.get("put_aside"),
            put_aside_reason: row.get("reason"),
        };
        state.stations.insert(name, station);
    }
    if !changed.is_empty() {
        for row in client.query(READINGS, &[&changed, &LOOK_BACK_DAYS]).await? {
            let station = known.get(&row.get("station")).map(|(name, _)| name.clone()).unwrap_or_default();
            let reading = reading(station, &row);
            state.readings.insert(format!("{}/{}", reading.station, reading.series), reading);
        }
    }
    let oldest = Micros::now().0 / 1000 - i64::from(LOOK_BACK_DAYS) * DAY_MS;
    let State { readings, stations, .. } = &mut state;
    readings.retain(|_, reading| reading.at_ms > oldest && stations.contains_key(&reading.station));
    let alarms = client.query(ALARMS, &[&MAX_ALARMS]).await?;
    state.alarms_of_plant = alarms.iter().map(|row| (row.get("plant"), row.get("total"))).collect();
    state.alarms =
        alarms.iter().map(alarm).map(|alarm| (format!("{}/{}", alarm.station, alarm.alarm), alarm)).collect();
    Ok(state)
}

fn reading(station: String, row: &Row) -> LatestReading {
    let series = row.get("name");
    if let Some(start) = row.get("start") {
        return LatestReading::of_span(station, series, start, row.get("mean_pa"), row.get("qualities"));
    }
    let quality = quality(row.get("quality"));
    let pressure: Option<f64> = row.get("pressure_pa");
    let is_valid = quality == Quality::Valid;
    LatestReading {
        station,
        series,
        at_ms: row.get("at"),
        pa: pressure.filter(|_| is_valid),
        limit_pa: pressure.filter(|_| !is_valid),
        quality,
        mean_of_ms: None,
    }
}

/// The quality of a number in the database; one of a later program is shown as a fault.
fn quality(number: i16) -> Quality {
    Quality::from_number(number.into()).unwrap_or(Quality::Fault)
}

fn alarm(row: &Row) -> ActiveAlarm {
    ActiveAlarm {
        plant: row.get("plant"),
        station: row.get("station"),
        alarm: row.get("alarm"),
        state: Word::read(row.get("state")),
        priority: Word::read(row.get("priority")),
        occurrence: row.get("occurrence"),
        subject: row.get("subject"),
        at_ms: row.get("at"),
        user: row.get("user_name"),
        text: row.get("text"),
    }
}
