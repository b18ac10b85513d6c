//! Trends and events of all stations.

use super::pool::{Pool, PoolError};
use super::visibility::Hidden;
use profivac_model::{Event, Micros, Word};
use profivac_recorder::Trend;
use serde::Serialize;
use tokio_postgres::Row;
use utoipa::ToSchema;

const MINUTE_MS: i64 = 60_000;

/// The levels of spans with the time that each span covers, the longest first.
const LEVELS: [(i16, i64); 3] = [(4, 360 * MINUTE_MS), (3, 30 * MINUTE_MS), (2, 2 * MINUTE_MS)];

/// A summary of samples begins at its first sample, so that single samples keep their times.
const SAMPLES: &str = "
    SELECT (extract(epoch FROM min(at)) * 1000)::bigint AS start, min(pressure_pa) AS low, max(pressure_pa) AS high,
        10 ^ avg(log(pressure_pa)) FILTER (WHERE pressure_pa > 0) AS mean, bit_or(1 << quality)::integer AS qualities
    FROM profivac.sample
    WHERE station = $1 AND series = $2 AND at >= to_timestamp($3::bigint / 1000.0::double precision)
        AND at < to_timestamp($4::bigint / 1000.0::double precision)
    GROUP BY floor((extract(epoch FROM at)::double precision * 1000 - $3::bigint) / $5::double precision)
    ORDER BY 1";

/// A summary of spans begins at its first span.
const SPANS: &str = "
    SELECT (extract(epoch FROM min(start)) * 1000)::bigint AS start, min(min_pa) AS low, max(max_pa) AS high,
        10 ^ (sum(log(mean_pa) * count) / nullif(sum(count), 0)) AS mean, bit_or(qualities)::integer AS qualities
    FROM profivac.span
    WHERE station = $1 AND series = $2 AND level = $6 AND start >= to_timestamp($3::bigint / 1000.0::double precision)
        AND start < to_timestamp($4::bigint / 1000.0::double precision)
    GROUP BY floor((extract(epoch FROM start)::double precision * 1000 - $3::bigint) / $5::double precision)
    ORDER BY 1";

/// Events of all plants but some. A sentence of a station is far shorter than 2,000 characters.
const EVENTS: &str = "
    SELECT plant, station, (extract(epoch FROM at) * 1000)::bigint AS at, series, kind, left(text, 2000) AS text
    FROM profivac.event
    WHERE at >= to_timestamp($1::bigint / 1000.0::double precision) AND at < to_timestamp($2::bigint / 1000.0::double precision)
        AND plant <> ALL ($3)";

const LATEST_FIRST: &str = "ORDER BY event.at DESC, event.epoch DESC, event.id DESC LIMIT $4";

/// A series and a time.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// The station.
    pub station: String,
    /// The series.
    pub series: String,
    /// The beginning and the end, in milliseconds since 1970; the end is later.
    pub time: (i64, i64),
    /// The most entries of the trend.
    pub pixels: u32,
}

impl Wanted {
    fn pixel_ms(&self) -> f64 {
        let (from, to) = self.time;
        to.saturating_sub(from) as f64 / f64::from(self.pixels.max(1))
    }

    /// The level whose spans are as long as a pixel or shorter; `None` for samples.
    fn level(&self) -> Option<i16> {
        LEVELS.into_iter().find(|(_, length)| self.pixel_ms() >= *length as f64).map(|(level, _)| level)
    }
}

/// The trend of a series. A short time is drawn from samples, or from spans of two minutes where the station sends no samples.
///
/// # Errors
/// [`PoolError`].
pub async fn trend(pool: &Pool, wanted: &Wanted) -> Result<Trend, PoolError> {
    let rows = match wanted.level() {
        Some(level) => spans(pool, wanted, level).await?,
        None => {
            let (from, to) = wanted.time;
            let pixel = wanted.pixel_ms();
            let samples = pool.query(SAMPLES, &[&wanted.station, &wanted.series, &from, &to, &pixel]).await?;
            if samples.is_empty() { spans(pool, wanted, LEVELS[2].0).await? } else { samples }
        }
    };
    Ok(trend_of(format!("{}/{}", wanted.station, wanted.series), &rows))
}

async fn spans(pool: &Pool, wanted: &Wanted, level: i16) -> Result<Vec<Row>, PoolError> {
    let (from, to) = wanted.time;
    pool.query(SPANS, &[&wanted.station, &wanted.series, &from, &to, &wanted.pixel_ms(), &level]).await
}

fn trend_of(series: String, rows: &[Row]) -> Trend {
    let qualities = |row: &Row| u8::try_from(row.get::<_, Option<i32>>("qualities").unwrap_or(0)).unwrap_or(0);
    Trend {
        series,
        start_ms: rows.iter().map(|row| row.get("start")).collect(),
        low: rows.iter().map(|row| row.get("low")).collect(),
        high: rows.iter().map(|row| row.get("high")).collect(),
        mean: rows.iter().map(|row| row.get("mean")).collect(),
        qualities: rows.iter().map(qualities).collect(),
    }
}

/// Something that happened at a station.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct ArchivedEvent {
    /// The plant.
    pub plant: String,
    /// The station.
    pub station: String,
    /// The event, with its time by the clock of the station.
    #[serde(flatten)]
    pub event: Event,
}

/// Events of one station or of all plants that are not hidden, the latest first.
///
/// # Errors
/// [`PoolError`].
pub async fn events(
    pool: &Pool,
    station: Option<&str>,
    (from, to): (i64, i64),
    limit: i64,
    hidden: &Hidden,
) -> Result<Vec<ArchivedEvent>, PoolError> {
    let hidden: Vec<_> = hidden.iter().map(String::as_str).collect();
    // A statement of its own uses the index of the station.
    let rows = match station {
        None => pool.query(&format!("{EVENTS} {LATEST_FIRST}"), &[&from, &to, &hidden, &limit]).await?,
        Some(station) => {
            let sql = format!("{EVENTS} AND station = $5 {LATEST_FIRST}");
            pool.query(&sql, &[&from, &to, &hidden, &limit, &station]).await?
        }
    };
    let event = |row: &Row| ArchivedEvent {
        plant: row.get("plant"),
        station: row.get("station"),
        event: Event {
            at: Micros(row.get::<_, i64>("at").saturating_mul(1000)),
            gauge: row.get("series"),
            kind: Word::read(row.get("kind")),
            text: row.get("text"),
        },
    };
    Ok(rows.iter().map(event).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trend_is_drawn_from_the_longest_spans_that_fit_into_a_pixel() {
        let hour = 60 * MINUTE_MS;
        let day = 24 * hour;
        for (length, pixels, expected) in [
            (hour, 1000, None),
            (day, 1000, None),
            (2 * day, 1000, Some(2)),
            (21 * day, 1000, Some(3)),
            (365 * day, 1000, Some(4)),
            (365 * day, 20_000, Some(2)),
        ] {
            let wanted = Wanted { station: String::new(), series: String::new(), time: (0, length), pixels };
            assert_eq!(wanted.level(), expected, "{length} ms, {pixels} pixels");
        }
    }
}
