//! What was recorded.

use super::database::DatabaseReaders;
use super::problem::Problem;
use crate::rise::{self, Rise};
use crate::view::{EventView, RiseView, Trend};
use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_TYPE};
use axum::response::IntoResponse;
use profivac_recorder::{DatabaseError, Micros, Reader};
use serde::Deserialize;
use std::collections::HashSet;
use utoipa::IntoParams;

/// More pixels than any screen has.
const MOST_PIXELS: u32 = 20_000;

/// More events than anybody reads at once.
const MOST_EVENTS: u32 = 10_000;

/// More samples than a rise needs.
const MOST_FITTED: u32 = 20_000;

/// Which series, and when.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct TrendParameters {
    /// The name of what was recorded.
    series: String,
    /// The beginning, in milliseconds since 1970.
    #[param(example = 0)]
    from: i64,
    /// The end.
    #[param(example = 4_102_444_800_000_i64)]
    to: i64,
    /// How many pixels there are, 1 to 20000; 1000 if nothing is said.
    pixels: Option<u32>,
}

/// Which time.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct EventsParameters {
    /// The beginning, in milliseconds since 1970.
    #[param(example = 0)]
    from: i64,
    /// The end.
    #[param(example = 4_102_444_800_000_i64)]
    to: i64,
    /// How many at most, 1 to 10000; 200 if nothing is said.
    most: Option<u32>,
}

/// Which rise, in what volume.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct RiseParameters {
    /// The name of what was recorded.
    series: String,
    /// The beginning, in milliseconds since 1970.
    #[param(example = 0)]
    from: i64,
    /// The end.
    #[param(example = 4_102_444_800_000_i64)]
    to: i64,
    /// The volume in m³, for flows.
    volume_m3: Option<f64>,
}

/// What to export.
#[derive(Debug, PartialEq, Eq, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(try_from = "Vec<(String, String)>")]
pub struct ExportParameters {
    /// Names, `series` again for each; everything if nothing is said. What is no name may be several, separated by commas.
    #[serde(default)]
    series: Vec<String>,
    /// The beginning, in milliseconds since 1970.
    #[param(example = 0)]
    from: i64,
    /// The end.
    #[param(example = 4_102_444_800_000_i64)]
    to: i64,
}

impl TryFrom<Vec<(String, String)>> for ExportParameters {
    type Error = String;

    /// A name that comes again is what a struct does not take from a query.
    fn try_from(pairs: Vec<(String, String)>) -> Result<Self, String> {
        let (mut series, mut from, mut to) = (Vec::new(), None, None);
        for (name, value) in pairs {
            match name.as_str() {
                "series" => series.push(value),
                "from" => from = Some(moment(&name, &value)?),
                "to" => to = Some(moment(&name, &value)?),
                _ => {}
            }
        }
        let missing = |name| format!("expected {name} in milliseconds since 1970, got nothing");
        Ok(Self { series, from: from.ok_or_else(|| missing("from"))?, to: to.ok_or_else(|| missing("to"))? })
    }
}

fn moment(name: &str, value: &str) -> Result<i64, String> {
    value.parse().map_err(|_| format!("expected {name} in milliseconds since 1970, got {value:?}"))
}

/// The series that were asked for, of those that there are. A name may have a comma in it: only what is no name is taken
/// apart there.
fn named(asked: &[String], there: Vec<String>) -> Vec<String> {
    if asked.is_empty() {
        return there;
    }
    let names = asked.iter().flat_map(|text| match there.contains(text) {
        true => vec![text.clone()],
        false => text.split(',').map(str::to_owned).collect(),
    });
    // Who asks for the same a thousand times gets it once.
    let mut seen = HashSet::new();
    names.filter(|name| seen.insert(name.clone())).collect()
}

/// What was recorded of a series, drawn for so many pixels.
#[utoipa::path(get, path = "/api/trend", params(TrendParameters), responses((status = 200, body = Trend), (status = 400, body = Problem)))]
pub async fn trend(
    State(archive): State<DatabaseReaders>,
    window: Result<Query<TrendParameters>, QueryRejection>,
) -> Result<Json<Trend>, Problem> {
    let window = parsed_query(window)?;
    let (from, to) = time_range(window.from, window.to)?;
    let pixels = checked_range("pixels", window.pixels.unwrap_or(1000), MOST_PIXELS)?;
    let read = archive.read(move |reader| {
        let bins = reader.trend(&window.series, from, to, pixels)?;
        Ok(Json(Trend::of(&window.series, &bins)))
    });
    read.await
}

/// What happened, the latest first.
#[utoipa::path(get, path = "/api/events", params(EventsParameters), responses((status = 200, body = [EventView]), (status = 400, body = Problem)))]
pub async fn events(
    State(archive): State<DatabaseReaders>,
    time: Result<Query<EventsParameters>, QueryRejection>,
) -> Result<Json<Vec<EventView>>, Problem> {
    let time = parsed_query(time)?;
    let (from, to) = time_range(time.from, time.to)?;
    let most = checked_range("most", time.most.unwrap_or(200), MOST_EVENTS)?;
    let read = archive.read(move |reader| {
        let events = reader.events(from, to, most)?;
        Ok(Json(events.into_iter().map(EventView::from).collect()))
    });
    read.await
}

/// A rise of pressure after a valve was closed, told apart into a leak and outgassing.
#[utoipa::path(get, path = "/api/rise", params(RiseParameters), responses((status = 200, body = RiseView), (status = 400, body = Problem)))]
pub async fn rise(
    State(archive): State<DatabaseReaders>,
    rising: Result<Query<RiseParameters>, QueryRejection>,
) -> Result<Json<RiseView>, Problem> {
    let rising = parsed_query(rising)?;
    let (from, to) = time_range(rising.from, rising.to)?;
    let volume = rising.volume_m3;
    if let Some(volume) = volume.filter(|volume| !(volume.is_finite() && *volume > 0.0)) {
        return Err(Problem::bad(format!("expected a volume in m³ above 0, got {volume}")));
    }
    let samples = archive.read(move |reader| Ok(pressures(&reader, &rising.series, from, to)?)).await?;
    let fitted = rise::fit(&samples).map_err(|error| Problem::bad(error.to_string()))?;
    Ok(Json(seen(&fitted, volume, samples.len())))
}

/// What was recorded, as a table: time (ISO 8601, UTC), series, pressure in Pa, quality.
#[utoipa::path(get, path = "/api/export.csv", params(ExportParameters), responses((status = 200, content_type = "text/csv", body = String), (status = 400, body = Problem)))]
pub async fn export(
    State(archive): State<DatabaseReaders>,
    wanted: Result<Query<ExportParameters>, QueryRejection>,
) -> Result<impl IntoResponse, Problem> {
    let wanted = parsed_query(wanted)?;
    let (from, to) = time_range(wanted.from, wanted.to)?;
    let headers =
        [(CONTENT_TYPE, "text/csv; charset=utf-8"), (CONTENT_DISPOSITION, "attachment; filename=\"pressures.csv\"")];
    let export = archive.read(move |reader| {
        let series = named(&wanted.series, reader.gauges()?);
        Ok(profivac_recorder::Export::new(reader, series, from, to))
    });
    let export = export.await?;
    Ok((headers, archive.stream_export(export)))
}

/// What is asked, or why it makes no sense.
pub fn parsed_query<T>(query: Result<Query<T>, QueryRejection>) -> Result<T, Problem> {
    query.map(|Query(query)| query).map_err(|rejection| Problem::bad(rejection.body_text()))
}

/// A time that ends after it begins.
pub fn time_range(from: i64, to: i64) -> Result<(Micros, Micros), Problem> {
    if from >= to {
        return Err(Problem::bad(format!("expected from to lie before to, got {from} and {to}")));
    }
    Ok((Micros(from.saturating_mul(1000)), Micros(to.saturating_mul(1000))))
}

/// A number from 1 to `most`.
pub fn checked_range(name: &str, given: u32, most: u32) -> Result<u32, Problem> {
    let fits = (1..=most).contains(&given);
    if fits { Ok(given) } else { Err(Problem::bad(format!("expected {name} from 1 to {most}, got {given}"))) }
}

/// Seconds since `from` and pressures: all samples, or where there are very many, the mean of each of so many pieces.
fn pressures(reader: &Reader, series: &str, from: Micros, to: Micros) -> Result<Vec<(f64, f64)>, DatabaseError> {
    let seconds = |at: i64| at.saturating_sub(from.0) as f64 / Micros::SECOND as f64;
    let samples = reader.page(series, from, to, MOST_FITTED.saturating_add(1))?;
    if samples.len() <= MOST_FITTED as usize {
        return Ok(samples.iter().filter_map(|sample| Some((seconds(sample.at.0), sample.pa?))).collect());
    }
    let half = to.0.saturating_sub(from.0) / i64::from(MOST_FITTED) / 2;
    let bins = reader.trend(series, from, to, MOST_FITTED)?;
    let middle = |start: Micros| seconds(start.0.saturating_add(half));
    Ok(bins.iter().filter_map(|bin| Some((middle(bin.start), bin.summary.mean()?))).collect())
}

fn seen(rise: &Rise, volume: Option<f64>, samples: usize) -> RiseView {
    RiseView {
        start_pa: rise.start_pa,
        steady_pa_per_s: rise.steady_pa_per_s,
        leak_pa_m3_per_s: volume.map(|volume| volume * rise.steady_pa_per_s),
        bend_pa: rise.bend.map(|bend| bend.height_pa),
        tau_s: rise.bend.map(|bend| bend.tau_s),
        outgassing_pa_m3_per_s: volume.zip(rise.bend).map(|(volume, bend)| volume * bend.initial_pa_per_s()),
        explained: rise.explained,
        samples,
    }
}
