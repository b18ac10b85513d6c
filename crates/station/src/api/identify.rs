//! A plant identified from the samples of one gauge.

use super::database::DatabaseReaders;
use super::fits::{Fits, LONGEST};
use super::history::RiseGauge;
use super::names::check_series;
use crate::identification::identified;
use crate::identification::record::{Known, KnownVolume};
use crate::identification::view::{Asked, PlantView};
use crate::pumpdown::TimeRange;
use crate::services::Services;
use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use profivac_identify::plant::NotIdentified;
use profivac_identify::standard_uncertainty;
use profivac_recorder::Micros;
use profivac_web_server::problem::Problem;
use profivac_web_server::query::{checked_accuracy, parsed_query, positive, time_range};
use serde::Deserialize;
use std::sync::Arc;
use utoipa::IntoParams;

/// The most samples of a fit: two days at two samples per second, in 16 MB.
const MAX_SAMPLES: u32 = 400_000;

/// The time range of a fit, and what is known of the plant.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct IdentifyParameters {
    /// The name of the series: that of a gauge, or `gauge.N` for channel N of a controller.
    #[param(example = "chamber")]
    series: String,
    /// The start of the pump-down, in milliseconds since 1970.
    #[param(example = 0)]
    from: i64,
    /// The end of the time range, in milliseconds since 1970.
    #[param(example = 4_102_444_800_000_i64)]
    to: i64,
    /// When the valve to the pump was closed, in milliseconds since 1970. Without it the beginning of the largest rise.
    closed: Option<i64>,
    /// When the valve was opened again, in milliseconds since 1970. Without it the end of that rise.
    opened: Option<i64>,
    /// The volume in m³. Without it a dose is needed.
    #[param(example = 0.1)]
    volume_m3: Option<f64>,
    /// A dose of gas in Pa m³, let in while the valve was closed, from which the volume follows.
    dose_pa_m3: Option<f64>,
    /// When the dose was let in, in milliseconds since 1970.
    dose_at: Option<i64>,
    /// How the indication depends on the gas, `none` unless given. The correction takes outgassing as water and a leak as air.
    #[param(inline, example = "none")]
    gauge: Option<RiseGauge>,
    /// The accuracy of the gauge as a fraction of the reading, as its manual states it: 0.15 for ±15 %. It widens leak and
    /// outgassing, and the volume from a dose.
    #[param(example = 0.15)]
    accuracy: Option<f64>,
    /// A pressure in Pa whose time is predicted.
    target_pa: Option<f64>,
}

/// The numbers of a plant from the samples of one pump-down, base pressure and rise, with 95 % intervals
///
/// The station fits one plant at a time, and stops when the client disconnects or after two minutes.
#[utoipa::path(
    get,
    path = "/api/identify",
    params(IdentifyParameters),
    responses(
        (status = 200, body = PlantView),
        (status = 400, body = Problem, description = "A parameter is out of range, or the samples cannot be fitted"),
        (status = 404, body = Problem, description = "There is no series of this name"),
        (status = 503, body = Problem, description = "The database cannot be read, another fit runs, or the fit takes too long")
    )
)]
pub async fn identify(
    State(services): State<Arc<Services>>,
    State(readers): State<DatabaseReaders>,
    State(fits): State<Fits>,
    parameters: Result<Query<IdentifyParameters>, QueryRejection>,
) -> Result<Json<PlantView>, Problem> {
    let parameters = parsed_query(parameters)?;
    let (known, asked) = parameters.checked()?;
    let series = parameters.series;
    // The permit first: requests that wait for it hold no samples.
    let fit = fits.begin().await?;
    let TimeRange { start, end } = known.span;
    let wanted = series.clone();
    let read = readers.read(move |reader| {
        check_series(&services, &reader, &wanted)?;
        Ok(reader.page(&wanted, start, end, MAX_SAMPLES.saturating_add(1))?)
    });
    let samples = read.await?;
    if samples.len() > MAX_SAMPLES as usize {
        return Err(Problem::bad_request(format!(
            "expected a record of at most {MAX_SAMPLES} samples, found more; choose a shorter time, or run `profivac identify`"
        )));
    }
    let found =
        fit.run(move |stopped| identified(series, &samples, &known, &asked, stopped).map(Json).map_err(problem));
    found.await?
}

pub fn problem(error: NotIdentified) -> Problem {
    match error {
        NotIdentified::Stopped => Problem::unavailable(format!(
            "the fit took longer than {} s and was stopped; choose a shorter time, or run `profivac identify`",
            LONGEST.as_secs()
        )),
        error => Problem::bad_request(error.to_string()),
    }
}

impl IdentifyParameters {
    fn checked(&self) -> Result<(Known, Asked), Problem> {
        let (start, end) = time_range(self.from, self.to)?;
        let micros = |ms: i64| Micros(ms.saturating_mul(1000));
        let volume = match (self.volume_m3, self.dose_pa_m3, self.dose_at) {
            (Some(m3), None, None) => KnownVolume::Given(positive("volume_m3", m3)?),
            (None, Some(amount), Some(at)) => {
                KnownVolume::Dose { amount: positive("dose_pa_m3", amount)?, at: micros(at) }
            }
            _ => {
                return Err(Problem::bad_request(
                    "expected either volume_m3, or dose_pa_m3 with dose_at: the record alone has no volume",
                ));
            }
        };
        let accuracy = checked_accuracy(self.accuracy)?;
        if let Some([closed, opened]) = self.closed.zip(self.opened).map(<[i64; 2]>::from).filter(|[a, b]| a >= b) {
            return Err(Problem::bad_request(format!(
                "expected closed to lie before opened, found {closed} and {opened}"
            )));
        }
        let target_pa = self.target_pa.map(|pa| positive("target_pa", pa)).transpose()?;
        let known = Known {
            span: TimeRange { start, end },
            closed: self.closed.map(micros),
            opened: self.opened.map(micros),
            volume,
            gauge_uncertainty: accuracy.map_or(0.0, standard_uncertainty),
        };
        let gauge = self.gauge.unwrap_or(RiseGauge::None).into();
        let is_volume_given = self.volume_m3.is_some();
        Ok((known, Asked { gauge, accuracy, target_pa, is_volume_given }))
    }
}
