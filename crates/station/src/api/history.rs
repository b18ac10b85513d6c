//! Recorded pressures, values of points, and events.

use super::database::DatabaseReaders;
use super::names::{all_series, check_series};
use crate::pumpdown;
use crate::services::Services;
use crate::view::{GaugeKind, RiseFlows, RisePoint, RiseShapes, RiseView, WatchedParameter};
use axum::Json;
use axum::body::Body;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_TYPE};
use axum::response::IntoResponse;
use profivac_identify::rise::{Flow, GasDependence, Rise, RiseSetup, analyse};
use profivac_identify::standard_uncertainty;
use profivac_model::Event;
use profivac_recorder::{
    Chunks, DatabaseError, DescribedPoint, Exported, Micros, Point, PointKind, PointTrend, Quality,
};
use profivac_recorder::{Reader, Sample, Span, Trend};
use profivac_vacuum::gas::Gas;
use profivac_web_server::problem::Problem;
use profivac_web_server::query::{
    MomentError, checked_accuracy, checked_range, moment, parsed_query, positive, time_range,
};
use serde::Deserialize;
use std::collections::HashSet;
use std::sync::Arc;
use std::time::Duration;
use utoipa::{IntoParams, ToSchema};

/// The most spans of a trend: more than a screen has pixels.
const MAX_PIXELS: u32 = 20_000;

/// The most events of an answer.
const MAX_EVENTS: u32 = 10_000;

/// The most points to which a rise is fitted.
const MAX_FITTED: u32 = 20_000;

/// The longest time before a rise in which its pump-down is searched.
const PUMPED_WITHIN: Duration = Duration::from_secs(7 * 24 * 3600);

/// The temperature of the gas, in K.
const GAS_K: f64 = profivac_vacuum::atmosphere::ROOM_K;

/// The series and the time range of a trend.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct TrendParameters {
    /// The name of the series: that of a gauge, or `gauge.N` for channel N of a controller.
    #[param(example = "chamber")]
    series: String,
    /// The beginning, in milliseconds since 1970.
    #[param(example = 0)]
    from: i64,
    /// The end, in milliseconds since 1970.
    #[param(example = 4_102_444_800_000_i64)]
    to: i64,
    /// The most entries of the trend, 1 to 20000.
    #[param(default = 1000, minimum = 1, maximum = 20_000)]
    pixels: Option<u32>,
}

/// The point and the time range of a trend.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct PointTrendParameters {
    /// The name of the slave.
    #[param(example = "turbo")]
    slave: String,
    /// The name of the point.
    #[param(example = "speed")]
    point: String,
    /// The unit, if the point was recorded in several; empty for a point without a unit. Default: the unit of the last value.
    unit: Option<String>,
    /// The beginning, in milliseconds since 1970.
    #[param(example = 0)]
    from: i64,
    /// The end, in milliseconds since 1970.
    #[param(example = 4_102_444_800_000_i64)]
    to: i64,
    /// The most entries of the trend, 1 to 20000.
    #[param(default = 1000, minimum = 1, maximum = 20_000)]
    pixels: Option<u32>,
}

/// The time range of events.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct EventsParameters {
    /// The beginning, in milliseconds since 1970.
    #[param(example = 0)]
    from: i64,
    /// The end, in milliseconds since 1970.
    #[param(example = 4_102_444_800_000_i64)]
    to: i64,
    /// The most events of the answer, 1 to 10000.
    #[param(default = 200, minimum = 1, maximum = 10_000)]
    limit: Option<u32>,
}

/// The series, the time range and the volume of a rise.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct RiseParameters {
    /// The name of the series: that of a gauge, or `gauge.N` for channel N of a controller.
    #[param(example = "chamber")]
    series: String,
    /// The beginning, in milliseconds since 1970.
    #[param(example = 0)]
    from: i64,
    /// The end, in milliseconds since 1970.
    #[param(example = 4_102_444_800_000_i64)]
    to: i64,
    /// The volume in m³. With it the answer has flows in Pa m³/s.
    #[param(example = 0.1)]
    volume_m3: Option<f64>,
    /// How the indication depends on the gas, `none` unless given. The correction takes outgassing as water and a leak as air.
    #[param(inline, example = "none")]
    gauge: Option<RiseGauge>,
    /// The accuracy of the gauge as a fraction of the reading, as its manual states it: 0.15 for ±15 %. Without it the intervals
    /// do not contain the uncertainty of the gauge.
    #[param(example = 0.15)]
    accuracy: Option<f64>,
}

/// How the indication of a gauge depends on the gas.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RiseGauge {
    /// Not at all, or unknown: a diaphragm.
    None,
    /// By ionisation: a hot or cold cathode.
    Ionisation,
    /// By the conduction of heat: a Pirani.
    Conduction,
}

impl From<RiseGauge> for GasDependence {
    fn from(gauge: RiseGauge) -> Self {
        match gauge {
            RiseGauge::None => Self::None,
            RiseGauge::Ionisation => Self::Ionisation,
            RiseGauge::Conduction => Self::Conduction,
        }
    }
}

/// The series and the time range of an export.
#[derive(Debug, PartialEq, Eq, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(try_from = "Vec<(String, String)>")]
pub struct ExportParameters {
    /// The name of a series; `series` may be repeated. Without it the export has all series. A value that is not the name of a
    /// series is split at its commas.
    #[serde(default)]
    series: Vec<String>,
    /// The beginning, in milliseconds since 1970.
    #[param(example = 0)]
    from: i64,
    /// The end, in milliseconds since 1970.
    #[param(example = 4_102_444_800_000_i64)]
    to: i64,
}

impl TryFrom<Vec<(String, String)>> for ExportParameters {
    type Error = MomentError;

    /// A derived implementation does not accept repeated keys.
    fn try_from(pairs: Vec<(String, String)>) -> Result<Self, MomentError> {
        let (mut series, mut from, mut to) = (Vec::new(), None, None);
        for (name, value) in pairs {
            match name.as_str() {
                "series" => series.push(value),
                "from" => from = Some(moment("from", &value)?),
                "to" => to = Some(moment("to", &value)?),
                _ => {}
            }
        }
        let missing = |name| MomentError::Missing { name };
        Ok(Self { series, from: from.ok_or_else(|| missing("from"))?, to: to.ok_or_else(|| missing("to"))? })
    }
}

/// The points and the time range of an export.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct PointsExportParameters {
    /// The name of a slave. Without it the export has the points of all slaves.
    slave: Option<String>,
    /// The name of a point. Without it the export has all points.
    point: Option<String>,
    /// The beginning, in milliseconds since 1970.
    #[param(example = 0)]
    from: i64,
    /// The end, in milliseconds since 1970.
    #[param(example = 4_102_444_800_000_i64)]
    to: i64,
}

/// The requested series, each once. Names may contain commas, so only a value that is not a known name is split.
fn selected(requested: &[String], known: Vec<String>) -> Vec<String> {
    if requested.is_empty() {
        return known;
    }
    let names = requested.iter().flat_map(|text| match known.contains(text) {
        true => vec![text.clone()],
        false => text.split(',').map(str::to_owned).collect(),
    });
    let mut seen = HashSet::new();
    names.filter(|name| seen.insert(name.clone())).collect()
}

/// The trend of a series: minimum, maximum and mean of each pixel
#[utoipa::path(
    get,
    path = "/api/trend",
    params(TrendParameters),
    responses(
        (status = 200, body = Trend),
        (status = 400, body = Problem, description = "A parameter is missing or out of range"),
        (status = 404, body = Problem, description = "There is no series of this name"),
        (status = 503, body = Problem, description = "The database cannot be read")
    )
)]
pub async fn trend(
    State(services): State<Arc<Services>>,
    State(readers): State<DatabaseReaders>,
    parameters: Result<Query<TrendParameters>, QueryRejection>,
) -> Result<Json<Trend>, Problem> {
    let TrendParameters { series, from, to, pixels } = parsed_query(parameters)?;
    let (from, to) = time_range(from, to)?;
    let pixels = checked_range("pixels", pixels.unwrap_or(1000), MAX_PIXELS)?;
    let read = readers.read(move |reader| {
        check_series(&services, &reader, &series)?;
        let spans = reader.trend(&series, from, to, pixels)?;
        Ok(Json(Trend::of(&series, &spans)))
    });
    read.await
}

/// The points of slaves whose values were recorded, with their units, and the texts of codes in the station's file
#[utoipa::path(
    get,
    path = "/api/points",
    responses(
        (status = 200, body = [DescribedPoint]),
        (status = 503, body = Problem, description = "The database cannot be read")
    )
)]
pub async fn points(
    State(services): State<Arc<Services>>,
    State(readers): State<DatabaseReaders>,
) -> Result<Json<Vec<DescribedPoint>>, Problem> {
    let directory = services.directory().view();
    let read = move |reader: Reader| {
        Ok(Json(reader.points()?.into_iter().map(|point| directory.described(point)).collect::<Vec<_>>()))
    };
    readers.read(read).await
}

/// The trend of a point in its unit: minimum, maximum, mean and last value of each pixel
#[utoipa::path(
    get,
    path = "/api/point-trend",
    params(PointTrendParameters),
    responses(
        (status = 200, body = PointTrend),
        (status = 400, body = Problem, description = "A parameter is missing or out of range"),
        (status = 404, body = Problem, description = "There is no such point"),
        (status = 503, body = Problem, description = "The database cannot be read")
    )
)]
pub async fn point_trend(
    State(services): State<Arc<Services>>,
    State(readers): State<DatabaseReaders>,
    parameters: Result<Query<PointTrendParameters>, QueryRejection>,
) -> Result<Json<PointTrend>, Problem> {
    let PointTrendParameters { slave, point, unit, from, to, pixels } = parsed_query(parameters)?;
    let (from, to) = time_range(from, to)?;
    let pixels = checked_range("pixels", pixels.unwrap_or(1000), MAX_PIXELS)?;
    let directory = services.directory().view();
    let read = readers.read(move |reader| {
        if let Some(found) = reader.point(&slave, &point, unit.as_deref())? {
            let spans = reader.point_trend(&found, from, to, pixels)?;
            return Ok(Json(PointTrend::of(directory.described(found), &spans)));
        }
        let unrecorded = without_values(&services, &slave, &point, unit.as_deref()).ok_or_else(|| {
            Problem::not_found(format!("no value of point {point:?} of {slave:?} was recorded; /api/points lists all"))
        })?;
        Ok(Json(PointTrend::of(directory.described(unrecorded), &[])))
    });
    read.await
}

/// A point of the station's file of which nothing was recorded yet: a page asks for it before its slave has answered.
fn without_values(services: &Services, slave: &str, name: &str, unit: Option<&str>) -> Option<Point> {
    let shown = services.snapshots().gauge(slave).filter(|slave| slave.kind == GaugeKind::Slave)?;
    let is_asked = |point: &&WatchedParameter| {
        point.target == name && unit.is_none_or(|unit| point.unit.unwrap_or_default() == unit)
    };
    let point = shown.parameters.iter().find(is_asked)?;
    // chosen: without a unit it counts as a code, of which a chart draws no mean.
    let kind = if point.unit.is_some() { PointKind::Number } else { PointKind::Code };
    Some(Point { slave: slave.to_owned(), name: name.to_owned(), unit: point.unit.map(str::to_owned), kind })
}

/// The events of a time range, the latest first
#[utoipa::path(
    get,
    path = "/api/events",
    params(EventsParameters),
    responses(
        (status = 200, body = [Event]),
        (status = 400, body = Problem, description = "A parameter is missing or out of range"),
        (status = 503, body = Problem, description = "The database cannot be read")
    )
)]
pub async fn events(
    State(readers): State<DatabaseReaders>,
    parameters: Result<Query<EventsParameters>, QueryRejection>,
) -> Result<Json<Vec<Event>>, Problem> {
    let parameters = parsed_query(parameters)?;
    let (from, to) = time_range(parameters.from, parameters.to)?;
    let limit = checked_range("limit", parameters.limit.unwrap_or(200), MAX_EVENTS)?;
    readers.read(move |reader| Ok(Json(reader.events(from, to, limit)?))).await
}

/// A rise of pressure after a valve was closed, separated into a leak and outgassing
#[utoipa::path(
    get,
    path = "/api/rise",
    params(RiseParameters),
    responses(
        (status = 200, body = RiseView),
        (status = 400, body = Problem, description = "A parameter is out of range, or the time range has too few samples"),
        (status = 404, body = Problem, description = "There is no series of this name"),
        (status = 503, body = Problem, description = "The database cannot be read")
    )
)]
pub async fn rise(
    State(services): State<Arc<Services>>,
    State(readers): State<DatabaseReaders>,
    parameters: Result<Query<RiseParameters>, QueryRejection>,
) -> Result<Json<RiseView>, Problem> {
    let RiseParameters { series, from, to, volume_m3, gauge, accuracy } = parsed_query(parameters)?;
    let (from, to) = time_range(from, to)?;
    let volume_m3 = volume_m3.map(|m3| positive("volume_m3", m3)).transpose()?;
    let accuracy = checked_accuracy(accuracy)?;
    let read = readers.read(move |reader| {
        check_series(&services, &reader, &series)?;
        let samples = pressures(&reader, &series, from, to)?;
        let setup = RiseSetup {
            // With 1 m³ a flow in Pa m³/s has the number of the rate in Pa/s.
            volume_m3: volume_m3.unwrap_or(1.0),
            pumped_s: pumped_s(&reader, &series, from)?,
            gauge: gauge.unwrap_or(RiseGauge::None).into(),
            outgassed: Gas::H2o,
            gauge_uncertainty: accuracy.map_or(0.0, standard_uncertainty),
            gas_k: GAS_K,
        };
        let rise = analyse(&samples, &setup).map_err(|error| Problem::bad_request(error.to_string()))?;
        Ok(Json(RiseView { accuracy, ..rise_view(&rise, &setup, volume_m3, samples.len()) }))
    });
    read.await
}

/// The samples of a time range as CSV: time (ISO 8601, UTC), series, pressure in Pa, quality
#[utoipa::path(
    get,
    path = "/api/export.csv",
    params(ExportParameters),
    responses(
        (status = 200, content_type = "text/csv", body = String),
        (status = 400, body = Problem, description = "A parameter is missing or malformed"),
        (status = 404, body = Problem, description = "There is no series of this name"),
        (status = 503, body = Problem, description = "The database cannot be read")
    )
)]
pub async fn export(
    State(services): State<Arc<Services>>,
    State(readers): State<DatabaseReaders>,
    parameters: Result<Query<ExportParameters>, QueryRejection>,
) -> Result<impl IntoResponse, Problem> {
    let headers =
        [(CONTENT_TYPE, "text/csv; charset=utf-8"), (CONTENT_DISPOSITION, "attachment; filename=\"pressures.csv\"")];
    let export = exported(services, &readers, parameters, profivac_recorder::Export::new).await?;
    Ok((headers, readers.stream_export(export)))
}

/// The samples of a time range as a Parquet file: time (UTC), series, pressure in Pa, quality
///
/// A program that is built without the feature `parquet` answers 501.
#[utoipa::path(
    get,
    path = "/api/export.parquet",
    params(ExportParameters),
    responses(
        (status = 200, content_type = "application/vnd.apache.parquet", body = String),
        (status = 400, body = Problem, description = "A parameter is missing or malformed"),
        (status = 404, body = Problem, description = "There is no series of this name"),
        (status = 501, body = Problem, description = "This program was built without Parquet"),
        (status = 503, body = Problem, description = "The database cannot be read")
    )
)]
pub async fn export_parquet(
    State(services): State<Arc<Services>>,
    State(readers): State<DatabaseReaders>,
    parameters: Result<Query<ExportParameters>, QueryRejection>,
) -> Result<impl IntoResponse, Problem> {
    let headers = [
        (CONTENT_TYPE, "application/vnd.apache.parquet"),
        (CONTENT_DISPOSITION, "attachment; filename=\"pressures.parquet\""),
    ];
    let chunks = exported(services, &readers, parameters, Chunks::new).await?;
    Ok((headers, parquet_body(&readers, chunks)?))
}

#[cfg(feature = "parquet")]
fn parquet_body<S: Exported + Send + 'static>(readers: &DatabaseReaders, chunks: Chunks<S>) -> Result<Body, Problem> {
    let export = profivac_recorder::parquet::ParquetExport::new(chunks);
    Ok(readers.stream_export(export.map_err(|error| Problem::unavailable(error.to_string()))?))
}

#[cfg(not(feature = "parquet"))]
fn parquet_body<S: Exported>(_: &DatabaseReaders, _: Chunks<S>) -> Result<Body, Problem> {
    Err(Problem::not_implemented(
        "this program was built without Parquet: take the export as CSV, or build with --features parquet",
    ))
}

/// The values of points of a time range as CSV: time (ISO 8601, UTC), slave, point, unit, value, quality, text of a code
#[utoipa::path(
    get,
    path = "/api/points.csv",
    params(PointsExportParameters),
    responses(
        (status = 200, content_type = "text/csv", body = String),
        (status = 400, body = Problem, description = "A parameter is missing or malformed"),
        (status = 503, body = Problem, description = "The database cannot be read")
    )
)]
pub async fn export_points(
    State(services): State<Arc<Services>>,
    State(readers): State<DatabaseReaders>,
    parameters: Result<Query<PointsExportParameters>, QueryRejection>,
) -> Result<impl IntoResponse, Problem> {
    let headers =
        [(CONTENT_TYPE, "text/csv; charset=utf-8"), (CONTENT_DISPOSITION, "attachment; filename=\"points.csv\"")];
    let export = exported_points(&services, &readers, parameters, profivac_recorder::Export::new).await?;
    Ok((headers, readers.stream_export(export)))
}

/// The values of points of a time range as a Parquet file: time (UTC), slave, point, unit, value, quality, text of a code
///
/// A program that is built without the feature `parquet` answers 501.
#[utoipa::path(
    get,
    path = "/api/points.parquet",
    params(PointsExportParameters),
    responses(
        (status = 200, content_type = "application/vnd.apache.parquet", body = String),
        (status = 400, body = Problem, description = "A parameter is missing or malformed"),
        (status = 501, body = Problem, description = "This program was built without Parquet"),
        (status = 503, body = Problem, description = "The database cannot be read")
    )
)]
pub async fn export_points_parquet(
    State(services): State<Arc<Services>>,
    State(readers): State<DatabaseReaders>,
    parameters: Result<Query<PointsExportParameters>, QueryRejection>,
) -> Result<impl IntoResponse, Problem> {
    let headers = [
        (CONTENT_TYPE, "application/vnd.apache.parquet"),
        (CONTENT_DISPOSITION, "attachment; filename=\"points.parquet\""),
    ];
    let chunks = exported_points(&services, &readers, parameters, Chunks::new).await?;
    Ok((headers, parquet_body(&readers, chunks)?))
}

/// The export that `begin` makes of the points and the time range of a request.
async fn exported_points<T: Send + 'static>(
    services: &Services,
    readers: &DatabaseReaders,
    parameters: Result<Query<PointsExportParameters>, QueryRejection>,
    begin: impl FnOnce(Reader, Vec<DescribedPoint>, Micros, Micros) -> T + Send + 'static,
) -> Result<T, Problem> {
    let PointsExportParameters { slave, point, from, to } = parsed_query(parameters)?;
    let (from, to) = time_range(from, to)?;
    let directory = services.directory().view();
    let read = readers.read(move |reader| {
        let mut points = reader.points()?;
        points.retain(|known| {
            slave.as_ref().is_none_or(|slave| *slave == known.slave)
                && point.as_ref().is_none_or(|point| *point == known.name)
        });
        let points = points.into_iter().map(|point| directory.described(point)).collect();
        Ok(begin(reader, points, from, to))
    });
    read.await
}

/// The export that `begin` makes of the series and the time range of a request.
async fn exported<T: Send + 'static>(
    services: Arc<Services>,
    readers: &DatabaseReaders,
    parameters: Result<Query<ExportParameters>, QueryRejection>,
    begin: impl FnOnce(Reader, Vec<String>, Micros, Micros) -> T + Send + 'static,
) -> Result<T, Problem> {
    let parameters = parsed_query(parameters)?;
    let (from, to) = time_range(parameters.from, parameters.to)?;
    let read = readers.read(move |reader| {
        let series = selected(&parameters.series, all_series(&services, &reader)?);
        series.iter().try_for_each(|name| check_series(&services, &reader, name))?;
        Ok(begin(reader, series, from, to))
    });
    read.await
}

/// Seconds since `from` and measured pressures in Pa: all valid samples, or the means of [`MAX_FITTED`] intervals if there are more. The end
/// of a range is no measured pressure.
fn pressures(reader: &Reader, series: &str, from: Micros, to: Micros) -> Result<Vec<(f64, f64)>, DatabaseError> {
    let seconds = |at: i64| at.saturating_sub(from.0) as f64 / Micros::SECOND as f64;
    let samples = reader.page(series, from, to, MAX_FITTED.saturating_add(1))?;
    if samples.len() <= MAX_FITTED as usize {
        let valid = samples.iter().filter(|sample| sample.quality == Quality::Valid);
        return Ok(valid.filter_map(|sample| Some((seconds(sample.at.0), sample.pa?))).collect());
    }
    let half = to.0.saturating_sub(from.0) / i64::from(MAX_FITTED) / 2;
    let spans = reader.trend(series, from, to, MAX_FITTED)?;
    let middle = |start: Micros| seconds(start.0.saturating_add(half));
    Ok(spans.iter().filter_map(|span| Some((middle(span.start), span.summary.mean()?))).collect())
}

/// The time of pumping before a rise in s, from the recorded beginning of its pump-down; `None` if the database has none in the
/// week before.
fn pumped_s(reader: &Reader, series: &str, closed: Micros) -> Result<Option<f64>, DatabaseError> {
    let before = i64::try_from(PUMPED_WITHIN.as_micros()).unwrap_or(i64::MAX);
    let from = Micros(closed.0.saturating_sub(before));
    let mut samples = reader.page(series, from, closed, MAX_FITTED.saturating_add(1))?;
    if samples.len() > MAX_FITTED as usize {
        let spans = reader.trend(series, from, closed, MAX_FITTED)?;
        // The means of intervals that are short beside a pump-down.
        let mean = |span: &Span| Some(Sample::new(span.start, Some(span.summary.mean()?), Quality::Valid));
        samples = spans.iter().filter_map(mean).collect();
    }
    let found = pumpdown::find(&samples, 0);
    let begun = found.last().filter(|one| !one.is_vented).map(|one| one.span.start.0);
    let pumped = begun.map(|begun| closed.0.saturating_sub(begun) as f64 / Micros::SECOND as f64);
    Ok(pumped.filter(|pumped| *pumped > 0.0))
}

fn rise_view(rise: &Rise, setup: &RiseSetup, volume_m3: Option<f64>, samples: usize) -> RiseView {
    let per_s = |flow: Flow| flow.pa_m3_per_s.scaled(setup.volume_m3.recip()).into();
    RiseView {
        cause: rise.cause.into(),
        leak_pa_per_s: per_s(rise.leak),
        outgassing_pa_per_s: per_s(rise.outgassing),
        flows: volume_m3.map(|_| RiseFlows { leak: rise.leak.into(), outgassing: rise.outgassing.into() }),
        shapes: RiseShapes {
            straight: rise.shapes.straight,
            inverse_time: rise.shapes.inverse_time,
            saturating: rise.shapes.saturating,
        },
        misfit: rise.misfit,
        tau_s: rise.tau_s,
        pumped_s: setup.pumped_s,
        accuracy: None,
        fitted: rise.fitted.iter().map(|(s, pa)| RisePoint { s: *s, pa: *pa }).collect(),
        samples,
    }
}
