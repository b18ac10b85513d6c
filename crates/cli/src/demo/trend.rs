//! The curves so far: the true pressures of the volumes and the pressure that the master reads.

use super::Row;
use profivac_virtual::scenario::Run;

/// The largest number of points; above it every second one is removed.
const POINTS: usize = 2000;

/// A curve: seconds and log10 of mbar.
pub type Curve = Vec<(f64, f64)>;

/// All curves.
#[derive(Debug, Default)]
pub struct Trend {
    /// The true pressure in each volume, by its name.
    pub true_pressures: Vec<(String, Curve)>,
    /// The pressure that the master reads from the first gauge.
    pub read_pressure: Curve,
}

impl Trend {
    /// Adds a point to each curve.
    pub fn add(&mut self, seconds: f64, run: &Run, row: &Row) {
        if self.true_pressures.is_empty() {
            self.true_pressures = run.pressures().map(|(name, _)| (name.to_owned(), Curve::new())).collect();
        }
        for ((_, curve), (_, pa)) in self.true_pressures.iter_mut().zip(run.pressures()) {
            curve.push((seconds, (pa / 100.0).log10()));
        }
        self.read_pressure.extend(row.read_mbar.map(|mbar| (seconds, mbar.log10())));
        let curves = self.true_pressures.iter_mut().map(|(_, curve)| curve).chain([&mut self.read_pressure]);
        curves.filter(|curve| curve.len() > POINTS).for_each(halve);
    }

    /// The time of the last point, in s.
    pub fn end(&self) -> f64 {
        self.true_pressures
            .iter()
            .filter_map(|(_, curve)| curve.last())
            .fold(0.0, |end, (seconds, _)| end.max(*seconds))
    }
}

/// Removes every second point.
fn halve(curve: &mut Curve) {
    let mut keep = false;
    curve.retain(|_| {
        keep = !keep;
        keep
    });
}
