//! Trends and events of all stations.

use super::pool::{Pool, PoolError};
use super::visibility::Hidden;
use profivac_model::{Event, Micros, Word};
use profivac_recorder::{CodeText, Point, PointKind, PointTrend, Trend};
use serde::Serialize;
use tokio_postgres::Row;
use utoipa::ToSchema;

const MINUTE_MS: i64 = 60_000;

/// The levels of spans with the time that each span covers, the longest first.
const LEVELS: [(i16, i64); 3] = [(4, 360 * MINUTE_MS), (3, 30 * MINUTE_MS), (2, 2 * MINUTE_MS)];

/// A summary of samples begins at its first sample, so that single samples keep their times. The end of a range (quality 1, 2) is in no
/// mean.
const SAMPLES: &str = "
    SELECT (extract(epoch FROM min(at)) * 1000)::bigint AS start, min(pressure_pa) AS low, max(pressure_pa) AS high,
        10 ^ avg(log(pressure_pa)) FILTER (WHERE pressure_pa > 0 AND quality = 0) AS mean,
        (max(ARRAY[extract(epoch FROM at)::double precision, CASE WHEN quality = 0 THEN pressure_pa END]))[2] AS last, bit_or(1 << quality)::integer AS qualities
    FROM profivac.sample
    WHERE station = $1 AND series = $2 AND at >= to_timestamp($3::bigint / 1000.0::double precision)
        AND at < to_timestamp($4::bigint / 1000.0::double precision)
    GROUP BY floor((extract(epoch FROM at)::double precision * 1000 - $3::bigint) / $5::double precision)
    ORDER BY 1";

/// A summary of spans begins at its first span. A station of version 0.1 counts the ends of ranges, also where no pressure is valid (bit 0).
const SPANS: &str = "
    SELECT (extract(epoch FROM min(start)) * 1000)::bigint AS start, min(min_pa) AS low, max(max_pa) AS high,
        10 ^ (sum(log(mean_pa) * count) FILTER (WHERE qualities & 1 = 1) / nullif(sum(count) FILTER (WHERE qualities & 1 = 1), 0)) AS mean,
        NULL::double precision AS last, bit_or(qualities)::integer AS qualities
    FROM profivac.span
    WHERE station = $1 AND series = $2 AND level = $6 AND start >= to_timestamp($3::bigint / 1000.0::double precision)
        AND start < to_timestamp($4::bigint / 1000.0::double precision)
    GROUP BY floor((extract(epoch FROM start)::double precision * 1000 - $3::bigint) / $5::double precision)
    ORDER BY 1";

/// The points of all plants but some.
const POINTS: &str = "
    SELECT plant, station, slave, point, unit, kind FROM profivac.point WHERE plant <> ALL ($1) ORDER BY station, point_id LIMIT 100000";

/// A point of a station, in the unit of its last value unless one is given.
const POINT: &str = "
    SELECT point_id, slave, point, unit, kind FROM profivac.point
    WHERE station = $1 AND slave = $2 AND point = $3 AND ($4::text IS NULL OR unit = $4)
    ORDER BY greatest((SELECT max(at) FROM profivac_data.point_sample AS sample WHERE sample.point = point_id),
        (SELECT max(start) FROM profivac_data.point_span AS span WHERE span.point = point_id)) DESC NULLS LAST, point_id DESC LIMIT 1";

/// The texts of a point.
const POINT_TEXTS: &str = "SELECT value, text FROM profivac_data.point_text WHERE point = $1 ORDER BY value LIMIT 1000";

/// As for pressures. The mean of a code is left out later.
const POINT_SAMPLES: &str = "
    SELECT (extract(epoch FROM min(at)) * 1000)::bigint AS start, min(value) AS low, max(value) AS high, avg(value) AS mean,
        (array_agg(value ORDER BY at DESC) FILTER (WHERE value IS NOT NULL))[1] AS last, bit_or(1 << quality)::integer AS qualities
    FROM profivac_data.point_sample
    WHERE point = $1 AND at >= to_timestamp($2::bigint / 1000.0::double precision)
        AND at < to_timestamp($3::bigint / 1000.0::double precision)
    GROUP BY floor((extract(epoch FROM at)::double precision * 1000 - $2::bigint) / $4::double precision)
    ORDER BY 1";

const POINT_SPANS: &str = "
    SELECT (extract(epoch FROM min(start)) * 1000)::bigint AS start, min(min_value) AS low, max(max_value) AS high,
        sum(sum) / nullif(sum(count), 0)::double precision AS mean,
        (array_agg(last_value ORDER BY start DESC, epoch DESC) FILTER (WHERE last_value IS NOT NULL))[1] AS last,
        bit_or(qualities)::integer AS qualities
    FROM profivac_data.point_span
    WHERE point = $1 AND level = $5 AND start >= to_timestamp($2::bigint / 1000.0::double precision)
        AND start < to_timestamp($3::bigint / 1000.0::double precision)
    GROUP BY floor((extract(epoch FROM start)::double precision * 1000 - $2::bigint) / $4::double precision)
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

fn qualities(row: &Row) -> u8 {
    u8::try_from(row.get::<_, Option<i32>>("qualities").unwrap_or(0)).unwrap_or(0)
}

fn trend_of(series: String, rows: &[Row]) -> Trend {
    Trend {
        series,
        start_ms: rows.iter().map(|row| row.get("start")).collect(),
        low: rows.iter().map(|row| row.get("low")).collect(),
        high: rows.iter().map(|row| row.get("high")).collect(),
        mean: rows.iter().map(|row| row.get("mean")).collect(),
        last: rows.iter().map(|row| row.get("last")).collect(),
        qualities: rows.iter().map(qualities).collect(),
    }
}

/// A point of a station of the archive.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct ArchivedPoint {
    /// The plant.
    pub plant: String,
    /// The station.
    pub station: String,
    /// The point, with its unit.
    pub point: Point,
}

fn point(row: &Row) -> Point {
    Point {
        slave: row.get("slave"),
        name: row.get("point"),
        unit: Some(row.get::<_, String>("unit")).filter(|unit| !unit.is_empty()),
        kind: PointKind::from_word(row.get("kind")).unwrap_or(PointKind::Code),
    }
}

/// The points of all plants that are not hidden, at most 100,000.
///
/// # Errors
/// [`PoolError`].
pub async fn points(pool: &Pool, hidden: &Hidden) -> Result<Vec<ArchivedPoint>, PoolError> {
    let hidden: Vec<_> = hidden.iter().map(String::as_str).collect();
    let rows = pool.query(POINTS, &[&hidden]).await?;
    let archived =
        |row: &Row| ArchivedPoint { plant: row.get("plant"), station: row.get("station"), point: point(row) };
    Ok(rows.iter().map(archived).collect())
}

/// The trend of a point, `wanted.series` of a slave. `None` if the archive has no value of it.
///
/// # Errors
/// [`PoolError`].
pub async fn point_trend(
    pool: &Pool,
    slave: &str,
    unit: Option<&str>,
    wanted: &Wanted,
) -> Result<Option<PointTrend>, PoolError> {
    let found = pool.query(POINT, &[&wanted.station, &slave, &wanted.series, &unit]).await?;
    let Some(found) = found.first() else { return Ok(None) };
    let (id, point): (i32, Point) = (found.get("point_id"), point(found));
    let (from, to) = wanted.time;
    let pixel = wanted.pixel_ms();
    let rows = match wanted.level() {
        Some(level) => pool.query(POINT_SPANS, &[&id, &from, &to, &pixel, &level]).await?,
        None => {
            let samples = pool.query(POINT_SAMPLES, &[&id, &from, &to, &pixel]).await?;
            let finest = LEVELS[2].0;
            if samples.is_empty() {
                pool.query(POINT_SPANS, &[&id, &from, &to, &pixel, &finest]).await?
            } else {
                samples
            }
        }
    };
    let has_mean = point.kind == PointKind::Number;
    let texts = if has_mean { Vec::new() } else { pool.query(POINT_TEXTS, &[&id]).await? };
    Ok(Some(PointTrend {
        point,
        texts: texts.iter().map(|row| CodeText { number: row.get("value"), text: row.get("text") }).collect(),
        start_ms: rows.iter().map(|row| row.get("start")).collect(),
        low: rows.iter().map(|row| row.get("low")).collect(),
        high: rows.iter().map(|row| row.get("high")).collect(),
        mean: rows.iter().map(|row| row.get::<_, Option<f64>>("mean").filter(|_| has_mean)).collect(),
        last: rows.iter().map(|row| row.get("last")).collect(),
        qualities: rows.iter().map(qualities).collect(),
    }))
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
