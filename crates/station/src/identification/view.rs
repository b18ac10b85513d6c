//! A plant as the API shows it.

use super::record::Chosen;
pub use super::sprays::BoundsView;
use super::sprays::{Circumstances, SprayView, around};
use super::words::{Certainty, MISFIT, Parameter, certainty, note, remedy};
use crate::view::{FlowView, unix_ms};
use profivac_identify::Interval;
use profivac_identify::plant::{Plant, Remedy};
use profivac_identify::rise::{Flow, GasDependence};
use profivac_recorder::Micros;
use profivac_vacuum::gas::Gas;
use serde::Serialize;
use utoipa::ToSchema;

/// The temperature of the gas, in K.
const GAS_K: f64 = profivac_vacuum::atmosphere::ROOM_K;

/// The points of a prediction.
const POINTS: i32 = 60;

/// How far a prediction goes beyond the samples, in s.
const AHEAD_S: f64 = 86_400.0;

/// A plant identified from the samples of one gauge.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct PlantView {
    /// The series.
    pub series: String,
    /// The start of the samples, in milliseconds since 1970.
    pub start_ms: i64,
    /// The seconds after the start at which the samples end.
    pub end_s: f64,
    /// The number of fitted samples.
    pub samples: usize,
    /// When the valve to the pump was closed; `null` if the samples have no rise.
    pub rise: Option<ClosedView>,
    /// The volume in m³.
    pub volume_m3: ParameterView,
    /// Whether the volume was given.
    pub is_volume_given: bool,
    /// The effective pumping speed, from low to high pressure.
    pub speeds: Vec<SpeedView>,
    /// The leak, as air.
    pub leak: PlantFlowView,
    /// The outgassing after an hour, as water.
    pub outgassing_1h: PlantFlowView,
    /// The exponent of the outgassing over time: 1 for water on metals, 1/2 for diffusion.
    pub exponent: ParameterView,
    /// The ultimate pressure of the pump in Pa, as indicated.
    pub ultimate_pa: ParameterView,
    /// The root mean square of the residuals divided by the noise: near 1 for a good fit.
    pub misfit: f64,
    /// Whether the fit describes the samples: the misfit is at most 2. If not, the numbers are worth nothing.
    pub is_described: bool,
    /// The accuracy of the gauge that the intervals contain, as a fraction; `null` if it was not given.
    pub accuracy: Option<f64>,
    /// The parts of the pressure at the end of the samples with the valve open, in Pa as indicated.
    pub at_end_pa: PartsView,
    /// The pressure after another day of pumping in Pa, as indicated.
    pub after_another_day_pa: BoundsView,
    /// The time in seconds after the start at which the target is reached; `null` without a target, or if it is certainly not within a
    /// year.
    pub target_s: Option<TimeView>,
    /// Changes that lower the pressure, the best one first.
    pub remedies: Vec<RemedyView>,
    /// Changes of the indication that look like helium at a leak, the earliest first.
    pub sprays: Vec<SprayView>,
    /// Groups of samples beside the fit.
    pub residuals: Vec<ResidualView>,
    /// The predicted pressure if the pumping goes on from the start until a day after the last sample, with its band.
    pub prediction: Vec<PredictionView>,
}

/// When the valve to the pump was closed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct ClosedView {
    /// Seconds after the start.
    pub closed_s: f64,
    /// When it was opened again, or the samples end: seconds after the start.
    pub opened_s: f64,
}

/// A time with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct TimeView {
    /// The best value in seconds; `null` if the target is more likely never reached.
    pub mean: Option<f64>,
    /// The lower bound in seconds.
    pub low: f64,
    /// The upper bound in seconds; `null` if the target may never be reached.
    pub high: Option<f64>,
}

/// How well the samples determine a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CertaintyView {
    /// Within its interval.
    Determined,
    /// It may be zero: only the upper bound is known.
    UpperBound,
    /// Its interval is too wide to be of use.
    Undetermined,
}

/// A number of a plant.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct ParameterView {
    /// The value with its 95 % interval.
    pub value: BoundsView,
    /// How well the samples determine it.
    #[schema(inline)]
    pub certainty: CertaintyView,
    /// Why it is not determined and what to record, in words; `null` if it is.
    pub note: Option<String>,
}

/// An effective pumping speed.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct SpeedView {
    /// The pressure in Pa, as indicated.
    pub pa: f64,
    /// The speed in m³/s.
    pub m3_per_s: ParameterView,
}

/// A gas flow of a plant.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct PlantFlowView {
    /// The flow in three units.
    pub flow: FlowView,
    /// How well the samples determine it.
    #[schema(inline)]
    pub certainty: CertaintyView,
    /// Why it is not determined and what to record, in words; `null` if it is.
    pub note: Option<String>,
}

/// The parts of a pressure, in Pa.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct PartsView {
    /// By the leak.
    pub by_leak: BoundsView,
    /// By outgassing.
    pub by_outgassing: BoundsView,
    /// By the ultimate pressure of the pump.
    pub by_pump: BoundsView,
}

/// A change that lowers the pressure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RemedyName {
    /// Close the leak.
    CloseLeak,
    /// Bake the chamber: a hundredth of the outgassing.
    Bake,
    /// A pump of twice the speed.
    LargerPump,
    /// A pump with a tenth of the ultimate pressure.
    BetterPump,
}

/// The effect of a remedy.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct RemedyView {
    /// The remedy.
    #[schema(inline)]
    pub remedy: RemedyName,
    /// The remedy in words.
    pub text: String,
    /// The pressure after another day of pumping divided by that with the remedy.
    pub divided_by: BoundsView,
}

/// A group of samples beside the fit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct ResidualView {
    /// Seconds after the start.
    pub s: f64,
    /// The mean measured pressure in Pa.
    pub measured_pa: f64,
    /// The fitted pressure in Pa.
    pub fitted_pa: f64,
    /// The logarithm of measured by fitted pressure, in standard deviations.
    pub deviations: f64,
}

/// A predicted pressure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct PredictionView {
    /// Seconds after the start.
    pub s: f64,
    /// The pressure in Pa with its 95 % band.
    pub pa: BoundsView,
}

impl From<Interval> for BoundsView {
    fn from(Interval { mean, low, high }: Interval) -> Self {
        Self { mean, low, high: Some(high).filter(|high| high.is_finite()) }
    }
}

impl From<Interval> for TimeView {
    fn from(Interval { mean, low, high }: Interval) -> Self {
        let finite = |s: f64| Some(s).filter(|s| s.is_finite());
        Self { mean: finite(mean), low, high: finite(high) }
    }
}

impl From<Certainty> for CertaintyView {
    fn from(certainty: Certainty) -> Self {
        match certainty {
            Certainty::Determined => Self::Determined,
            Certainty::UpperBound => Self::UpperBound,
            Certainty::Undetermined => Self::Undetermined,
        }
    }
}

impl From<Remedy> for RemedyName {
    fn from(remedy: Remedy) -> Self {
        match remedy {
            Remedy::CloseLeak => Self::CloseLeak,
            Remedy::Bake => Self::Bake,
            Remedy::LargerPump => Self::LargerPump,
            Remedy::BetterPump => Self::BetterPump,
        }
    }
}

impl ParameterView {
    fn new(parameter: Parameter, found: Interval) -> Self {
        let note = note(parameter, found).map(str::to_owned);
        Self { value: found.into(), certainty: certainty(parameter, found).into(), note }
    }
}

impl PlantFlowView {
    /// `factor` is the true by the indicated pressure of the gas.
    fn new(parameter: Parameter, indicated: Interval, factor: f64) -> Self {
        let flow = Flow { pa_m3_per_s: indicated.scaled(factor), gas_k: GAS_K };
        let note = note(parameter, indicated).map(str::to_owned);
        Self { flow: flow.into(), certainty: certainty(parameter, indicated).into(), note }
    }
}

/// What a plant was identified from, beside the samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// How the indication depends on the gas.
    pub gauge: GasDependence,
    /// The accuracy of the gauge as a fraction.
    pub accuracy: Option<f64>,
    /// A target in Pa.
    pub target_pa: Option<f64>,
    /// Whether the volume was given.
    pub is_volume_given: bool,
}

impl PlantView {
    /// The view of a plant.
    #[must_use]
    pub fn new(series: String, start: Micros, chosen: &Chosen, plant: &Plant, asked: &Asked) -> Self {
        let [air, water] = [Gas::Air, Gas::H2o].map(|gas| asked.gauge.factor(gas));
        let speeds = plant
            .speeds
            .iter()
            .map(|(pa, speed)| SpeedView { pa: *pa, m3_per_s: ParameterView::new(Parameter::Speed, *speed) });
        let [by_leak, by_outgassing, by_pump] = plant.parts_pa(plant.end_s()).map(BoundsView::from);
        // A gauge of an unknown kind is asked for as one that does not depend on the gas.
        let gauge = Some(asked.gauge).filter(|gauge| *gauge != GasDependence::None);
        let circumstances = Circumstances { gauge, plant: Some(plant) };
        let remedies = plant.remedies().into_iter().map(|(one, factor)| RemedyView {
            remedy: one.into(),
            text: remedy(one).to_owned(),
            divided_by: factor.into(),
        });
        let residuals = plant.residuals.iter().map(|one| ResidualView {
            s: one.at_s,
            measured_pa: one.measured_pa,
            fitted_pa: one.fitted_pa,
            deviations: one.deviations,
        });
        Self {
            series,
            start_ms: unix_ms(start),
            end_s: plant.end_s(),
            samples: chosen.record.samples.len(),
            rise: chosen.rise.map(|[closed_s, opened_s]| ClosedView { closed_s, opened_s }),
            volume_m3: ParameterView::new(Parameter::Volume, plant.volume_m3),
            is_volume_given: asked.is_volume_given,
            speeds: speeds.collect(),
            leak: PlantFlowView::new(Parameter::Leak, plant.leak, air),
            outgassing_1h: PlantFlowView::new(Parameter::Outgassing, plant.outgassing_1h, water),
            exponent: ParameterView::new(Parameter::Exponent, plant.exponent),
            ultimate_pa: ParameterView::new(Parameter::Ultimate, plant.ultimate_pa),
            misfit: plant.misfit,
            is_described: plant.misfit <= MISFIT,
            accuracy: asked.accuracy,
            at_end_pa: PartsView { by_leak, by_outgassing, by_pump },
            after_another_day_pa: plant.predicted_pa(plant.end_s() + AHEAD_S).into(),
            target_s: asked.target_pa.and_then(|pa| plant.time_to_pa(pa)).map(TimeView::from),
            remedies: remedies.collect(),
            sprays: around(start, &chosen.indicated, chosen.rise, circumstances),
            residuals: residuals.collect(),
            prediction: prediction(plant),
        }
    }
}

/// The prediction at times that are even on a logarithmic axis.
fn prediction(plant: &Plant) -> Vec<PredictionView> {
    let first = plant.residuals.iter().map(|one| one.at_s).find(|s| *s > 0.0).unwrap_or(1.0).max(0.1);
    let ratio = (plant.end_s() + AHEAD_S) / first;
    let times = (0..=POINTS).map(|point| first * ratio.powf(f64::from(point) / f64::from(POINTS)));
    times.map(|s| PredictionView { s, pa: plant.predicted_pa(s).into() }).collect()
}
