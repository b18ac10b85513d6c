//! What was recorded.

use super::problem::Problem;
use crate::plant::Plant;
use crate::recorder::{Micros, Reader, Sample, StoreError};
use crate::rise::{self, Rise};
use crate::view::{Happening, RiseView, Trend};
use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_TYPE};
use axum::response::IntoResponse;
use serde::Deserialize;
use std::sync::Arc;
use utoipa::IntoParams;

/// More pixels than any screen has.
const MOST_PIXELS: u32 = 20_000;

/// More events than anybody reads at once.
const MOST_EVENTS: u32 = 10_000;

/// More samples than a rise needs.
const MOST_FITTED: usize = 20_000;

/// Which series, and when.
#[derive(Debug, Deserialize, IntoParams)]
pub struct Window {
    /// The name of what was recorded.
    series: String,
    /// The beginning, in milliseconds since 1970.
    from: i64,
    /// The end.
    to: i64,
    /// How many pixels there are, 1 to 20000; 1000 if nothing is said.
    pixels: Option<u32>,
}

/// Which time.
#[derive(Debug, Deserialize, IntoParams)]
pub struct Time {
    /// The beginning, in milliseconds since 1970.
    from: i64,
    /// The end.
    to: i64,
    /// How many at most, 1 to 10000; 200 if nothing is said.
    most: Option<u32>,
}

/// Which rise, in what volume.
#[derive(Debug, Deserialize, IntoParams)]
pub struct Rising {
    /// The name of what was recorded.
    series: String,
    /// The beginning, in milliseconds since 1970.
    from: i64,
    /// The end.
    to: i64,
    /// The volume in m³, for flows.
    volume_m3: Option<f64>,
}

/// What to export.
#[derive(Debug, Deserialize, IntoParams)]
pub struct Export {
    /// Names, separated by commas; everything if nothing is said.
    series: Option<String>,
    /// The beginning, in milliseconds since 1970.
    from: i64,
    /// The end.
    to: i64,
}

/// What was recorded of a series, drawn for so many pixels.
#[utoipa::path(get, path = "/api/trend", params(Window), responses((status = 200, body = Trend), (status = 400, body = Problem)))]
pub async fn trend(
    State(plant): State<Arc<Plant>>,
    window: Result<Query<Window>, QueryRejection>,
) -> Result<Json<Trend>, Problem> {
    let window = taken(window)?;
    let (from, to) = times(window.from, window.to)?;
    let pixels = within("pixels", window.pixels.unwrap_or(1000), MOST_PIXELS)?;
    read(plant, move |reader| {
        let bins = reader.draw(&window.series, from, to, pixels)?;
        Ok(Json(Trend::of(&window.series, &bins)))
    })
    .await
}

/// What happened, the latest first.
#[utoipa::path(get, path = "/api/events", params(Time), responses((status = 200, body = [Happening]), (status = 400, body = Problem)))]
pub async fn events(
    State(plant): State<Arc<Plant>>,
    time: Result<Query<Time>, QueryRejection>,
) -> Result<Json<Vec<Happening>>, Problem> {
    let time = taken(time)?;
    let (from, to) = times(time.from, time.to)?;
    let most = within("most", time.most.unwrap_or(200), MOST_EVENTS)?;
    read(plant, move |reader| {
        let events = reader.events(from, to, most)?;
        Ok(Json(events.into_iter().map(Happening::from).collect()))
    })
    .await
}

/// A rise of pressure after a valve was closed, told apart into a leak and outgassing.
#[utoipa::path(get, path = "/api/rise", params(Rising), responses((status = 200, body = RiseView), (status = 400, body = Problem)))]
pub async fn rise(
    State(plant): State<Arc<Plant>>,
    rising: Result<Query<Rising>, QueryRejection>,
) -> Result<Json<RiseView>, Problem> {
    let rising = taken(rising)?;
    let (from, to) = times(rising.from, rising.to)?;
    let volume = rising.volume_m3;
    if let Some(volume) = volume.filter(|volume| !(volume.is_finite() && *volume > 0.0)) {
        return Err(Problem::bad(format!("expected a volume in m³ above 0, got {volume}")));
    }
    let samples = read(plant, move |reader| Ok(reader.samples(&rising.series, from, to)?)).await?;
    let samples = pressures(&samples, from);
    let fitted = rise::fit(&samples).map_err(|error| Problem::bad(error.to_string()))?;
    Ok(Json(seen(&fitted, volume, samples.len())))
}

/// What was recorded, as a table: time (ISO 8601, UTC), series, pressure in Pa, quality.
#[utoipa::path(get, path = "/api/export.csv", params(Export), responses((status = 200, content_type = "text/csv", body = String), (status = 400, body = Problem)))]
pub async fn export(
    State(plant): State<Arc<Plant>>,
    wanted: Result<Query<Export>, QueryRejection>,
) -> Result<impl IntoResponse, Problem> {
    let wanted = taken(wanted)?;
    let (from, to) = times(wanted.from, wanted.to)?;
    let csv = read(plant, move |reader| {
        let series = match &wanted.series {
            Some(names) => names.split(',').map(str::to_owned).collect(),
            None => reader.gauges()?,
        };
        let mut csv = Vec::new();
        reader.export(&series, from, to, &mut csv).map_err(|error| Problem::unavailable(error.to_string()))?;
        Ok(csv)
    })
    .await?;
    let headers =
        [(CONTENT_TYPE, "text/csv; charset=utf-8"), (CONTENT_DISPOSITION, "attachment; filename=\"pressures.csv\"")];
    Ok((headers, csv))
}

fn taken<T>(query: Result<Query<T>, QueryRejection>) -> Result<T, Problem> {
    query.map(|Query(query)| query).map_err(|rejection| Problem::bad(rejection.body_text()))
}

fn times(from: i64, to: i64) -> Result<(Micros, Micros), Problem> {
    if from >= to {
        return Err(Problem::bad(format!("expected from to lie before to, got {from} and {to}")));
    }
    Ok((Micros(from.saturating_mul(1000)), Micros(to.saturating_mul(1000))))
}

fn within(name: &str, given: u32, most: u32) -> Result<u32, Problem> {
    let fits = (1..=most).contains(&given);
    if fits { Ok(given) } else { Err(Problem::bad(format!("expected {name} from 1 to {most}, got {given}"))) }
}

/// Reads on a thread that may wait for the disk.
async fn read<T: Send + 'static>(
    plant: Arc<Plant>,
    question: impl FnOnce(&Reader) -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    let read = tokio::task::spawn_blocking(move || question(&plant.reader()?)).await;
    read.unwrap_or_else(|_| Err(Problem::unavailable("the station is stopping")))
}

impl From<StoreError> for Problem {
    fn from(error: StoreError) -> Self {
        Self::unavailable(error.to_string())
    }
}

/// Seconds since `from` and pressures, evenly thinned where there are very many.
fn pressures(samples: &[Sample], from: Micros) -> Vec<(f64, f64)> {
    let step = samples.len().div_ceil(MOST_FITTED).max(1);
    let seconds = |at: Micros| (at.0.saturating_sub(from.0)) as f64 / Micros::SECOND as f64;
    samples.iter().step_by(step).filter_map(|sample| Some((seconds(sample.at), sample.pa?))).collect()
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
