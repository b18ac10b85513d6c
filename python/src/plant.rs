//! A plant identified from its record.

use crate::failure::Failure;
use crate::rise::{IntervalRow, row};
use profivac_identify::plant::{self, Dose, NotIdentified, Phase, Plant as Identified, PlantRecord, Remedy, Volume};
use pyo3::prelude::*;
use std::cell::{Cell, RefCell};
use std::time::{Duration, Instant};

/// The longest time between two looks for a signal. chosen: a user takes it for at once.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(50);

/// Volume, leak, outgassing after an hour, exponent, ultimate pressure, speeds at pressures, misfit.
type PlantRow = (IntervalRow, IntervalRow, IntervalRow, IntervalRow, IntervalRow, Vec<(f64, IntervalRow)>, f64);

/// A plant with its uncertainties.
#[pyclass(frozen, module = "profivac._profivac")]
pub struct Plant(Identified);

#[pymethods]
impl Plant {
    /// Finds the numbers of a plant. Ctrl-C ends the search.
    #[new]
    #[pyo3(signature = (samples, *, phases, volume_m3, dose, gauge_uncertainty))]
    fn new(
        py: Python<'_>,
        samples: Vec<(f64, f64)>,
        phases: Vec<(f64, bool)>,
        volume_m3: Option<f64>,
        dose: Option<(f64, f64)>,
        gauge_uncertainty: f64,
    ) -> PyResult<Self> {
        let volume = match (volume_m3, dose) {
            (Some(m3), None) => Volume::Given(m3),
            (None, Some((at_s, amount))) => Volume::FromDose(Dose { at_s, amount }),
            _ => return Err(Failure::usage("expected either volume_m3 or dose=(seconds, Pa m3)").into()),
        };
        let phases = phases.into_iter().map(|(from_s, pumped)| Phase { from_s, pumped }).collect();
        let record = PlantRecord { samples, phases, volume, gauge_uncertainty };
        let (found, interrupt) = py.detach(|| identify(&record));
        if let Some(interrupt) = interrupt {
            return Err(interrupt);
        }
        Ok(Self(found.map_err(Failure::usage)?))
    }

    /// The numbers of the plant.
    fn numbers(&self) -> PlantRow {
        let it = &self.0;
        let speeds = it.speeds.iter().map(|(pa, speed)| (*pa, row(*speed))).collect();
        let [volume, leak, outgassing, exponent, ultimate] =
            [it.volume_m3, it.leak, it.outgassing_1h, it.exponent, it.ultimate_pa].map(row);
        (volume, leak, outgassing, exponent, ultimate, speeds, it.misfit)
    }

    /// Time in s, measured and fitted pressure in Pa, deviations.
    fn residuals(&self) -> Vec<(f64, f64, f64, f64)> {
        self.0.residuals.iter().map(|it| (it.at_s, it.measured_pa, it.fitted_pa, it.deviations)).collect()
    }

    /// The pressure in Pa if the pumping goes on until `seconds`.
    fn predicted(&self, seconds: f64) -> IntervalRow {
        row(self.0.predicted_pa(seconds))
    }

    /// The time in s at which the pressure reaches a target in Pa.
    fn time_to(&self, pascal: f64) -> Option<IntervalRow> {
        self.0.time_to_pa(pascal).map(row)
    }

    /// By which factor each remedy lowers the pressure after another day.
    fn remedies(&self) -> Vec<(&'static str, IntervalRow)> {
        let word = |remedy| match remedy {
            Remedy::CloseLeak => "close-leak",
            Remedy::Bake => "bake",
            Remedy::LargerPump => "larger-pump",
            Remedy::BetterPump => "better-pump",
        };
        self.0.remedies().into_iter().map(|(remedy, factor)| (word(remedy), row(factor))).collect()
    }
}

/// Searches until a signal handler raises an exception.
fn identify(record: &PlantRecord) -> (Result<Identified, NotIdentified>, Option<PyErr>) {
    let interrupt = RefCell::new(None);
    let due = Cell::new(Instant::now());
    let stopped = || {
        if interrupt.borrow().is_some() {
            return true;
        }
        if due.get().elapsed() < SIGNAL_INTERVAL {
            return false;
        }
        due.set(Instant::now());
        let raised = Python::attach(|py| py.check_signals()).err();
        interrupt.replace(raised);
        interrupt.borrow().is_some()
    };
    let found = plant::identify_unless(record, &stopped);
    (found, interrupt.into_inner())
}
