//! A rate of rise, separated into leak and outgassing.

use crate::failure::Failure;
use profivac_identify::Interval;
use profivac_identify::rise::{self, Cause, GasDependence, RiseSetup};
use pyo3::prelude::*;

/// Mean and bounds of a 95 % interval.
pub type IntervalRow = (f64, f64, f64);

/// Leak, outgassing, total, cause, misfit, fitted samples, time constant, and how many sccm one Pa m³/s is.
type RiseRow = (IntervalRow, IntervalRow, IntervalRow, &'static str, f64, Vec<(f64, f64)>, Option<f64>, f64);

/// An interval as a tuple.
pub const fn row(interval: Interval) -> IntervalRow {
    (interval.mean, interval.low, interval.high)
}

/// Separates the rise of a closed chamber. Flows are in Pa m³/s.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the package calls it with keywords")]
#[pyo3(signature = (samples, *, volume_m3, pumped_s, gauge, outgassed, gauge_uncertainty, gas_k))]
pub fn analyse_rise(
    py: Python<'_>,
    samples: Vec<(f64, f64)>,
    volume_m3: f64,
    pumped_s: Option<f64>,
    gauge: &str,
    outgassed: &str,
    gauge_uncertainty: f64,
    gas_k: f64,
) -> PyResult<RiseRow> {
    let gauge = match gauge {
        "none" => GasDependence::None,
        "ionisation" => GasDependence::Ionisation,
        "conduction" => GasDependence::Conduction,
        _ => return Err(Failure::usage(format!("expected gauge none, ionisation or conduction, got {gauge:?}")).into()),
    };
    let outgassed = outgassed.parse().map_err(Failure::usage)?;
    let setup = RiseSetup { volume_m3, pumped_s, gauge, outgassed, gauge_uncertainty, gas_k };
    let rise = py.detach(|| rise::analyse(&samples, &setup)).map_err(Failure::usage)?;
    let cause = match rise.cause {
        Cause::Leak => "leak",
        Cause::Outgassing => "outgassing",
        Cause::Both => "both",
        Cause::Undistinguished => "undistinguished",
        Cause::NoRise => "no-rise",
    };
    let [leak, outgassing, total] = [&rise.leak, &rise.outgassing, &rise.total].map(|flow| row(flow.pa_m3_per_s));
    let sccm = profivac_vacuum::pump::sccm_of_flow(1.0, gas_k);
    Ok((leak, outgassing, total, cause, rise.misfit, rise.fitted, rise.tau_s, sccm))
}
