//! A report about a pump-down as an HTML file.

use super::database::DatabaseReaders;
use super::fits::Fits;
use super::names::check_series;
use crate::comparison::summary::{PlantPart, complete};
use crate::pumpdown::TimeRange;
use crate::report::page::page;
use crate::report::{GaugeInfo, Report, ReportRequest, Unit};
use crate::services::Services;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_TYPE};
use axum::response::IntoResponse;
use jiff::tz::TimeZone;
use profivac_recorder::Micros;
use profivac_web_server::problem::Problem;
use profivac_web_server::query::{checked_accuracy, parsed_query, positive, time_range};
use serde::Deserialize;
use std::sync::Arc;
use std::time::Duration;
use utoipa::IntoParams;

/// The longest time range of a report: a year.
const LONGEST: Duration = Duration::from_secs(366 * 86_400);

/// The pump-down of a report.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct ReportParameters {
    /// The name of the series: that of a gauge, or `gauge.N` for channel N of a controller.
    #[param(example = "chamber")]
    series: String,
    /// The start of the pump-down, in milliseconds since 1970.
    #[param(example = 0)]
    from: i64,
    /// The end, in milliseconds since 1970; at most a year after the start.
    #[param(example = 31_000_000_000_i64)]
    to: i64,
    /// The volume in m³. With it the report has pumping speeds, flows and the numbers of the plant.
    #[param(example = 0.1)]
    volume_m3: Option<f64>,
    /// The accuracy of the gauge as a fraction of the reading: 0.15 for ±15 %.
    #[param(example = 0.15)]
    accuracy: Option<f64>,
    /// The unit of pressures: mbar, Pa, hPa, Torr or micron; mbar unless given.
    #[param(example = "mbar")]
    unit: Option<String>,
    /// The time zone of the page by its IANA name, for example `Europe/Berlin`; UTC unless given.
    zone: Option<String>,
}

/// A report about a pump-down: curves, times, rises, the numbers of the plant, and the usual times, as one HTML file
#[utoipa::path(
    get,
    path = "/api/report.html",
    params(ReportParameters),
    responses(
        (status = 200, content_type = "text/html", body = String),
        (status = 400, body = Problem, description = "A parameter is out of range"),
        (status = 404, body = Problem, description = "There is no series of this name"),
        (status = 503, body = Problem, description = "The database cannot be read, or another fit runs")
    )
)]
pub async fn report(
    State(services): State<Arc<Services>>,
    State(readers): State<DatabaseReaders>,
    State(fits): State<Fits>,
    parameters: Result<Query<ReportParameters>, QueryRejection>,
) -> Result<impl IntoResponse, Problem> {
    let parameters = parsed_query(parameters)?;
    let accuracy = checked_accuracy(parameters.accuracy)?;
    let series = parameters.series.clone();
    let request = parameters.request(services.name().to_owned())?;
    let fit = fits.begin().await?;
    let wanted = series.clone();
    let read = readers.read(move |reader| {
        check_series(&services, &reader, &wanted)?;
        Ok(reader)
    });
    let reader = read.await?;
    let text = fit.run(move |stopped| {
        let mut report = Report::make(&reader, request)?;
        if report.lead().is_none() {
            return Err(Problem::bad_request(format!("expected samples of {series:?} in this time, found none")));
        }
        complete(&reader, &mut report, PlantPart::Identified(accuracy), stopped)?;
        Ok::<_, Problem>((page(&report), report.begin))
    });
    let (text, begin) = text.await??;
    let name = format!("attachment; filename=\"pump-down-{}.html\"", begin.strftime("%Y-%m-%d-%H%M"));
    Ok(([(CONTENT_TYPE, "text/html; charset=utf-8".to_owned()), (CONTENT_DISPOSITION, name)], text))
}

impl ReportParameters {
    fn request(self, station: String) -> Result<ReportRequest, Problem> {
        let (start, end) = time_range(self.from, self.to)?;
        let end = end.min(Micros::now());
        if end > start.after(LONGEST) {
            return Err(Problem::bad_request("expected a time range of at most a year"));
        }
        let volume_m3 = self.volume_m3.map(|m3| positive("volume_m3", m3)).transpose()?;
        let unit = self.unit.map(|unit| unit.parse::<Unit>()).transpose();
        let unit = unit.map_err(|error| Problem::bad_request(error.to_string()))?.unwrap_or_default();
        let zone = self.zone.map(|zone| {
            TimeZone::get(&zone).map_err(|_| {
                Problem::bad_request(format!("expected a time zone such as Europe/Berlin, found {zone:?}"))
            })
        });
        Ok(ReportRequest {
            title: station,
            station: None,
            record: "the database of the station".to_owned(),
            span: TimeRange { start, end },
            why: "as requested in the dashboard".to_owned(),
            gauges: vec![(self.series, GaugeInfo::default())],
            volume_m3,
            pressures: Vec::new(),
            unit,
            zone: zone.transpose()?.unwrap_or(TimeZone::UTC),
            made: Micros::now(),
        })
    }
}
