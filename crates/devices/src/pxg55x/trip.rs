//! A trip point and its relay. tira56e1 11; numbers in brackets are those of errata-pxg55x-img400. Pressures are in Pa.

use super::codes::SetpointMode;

impl SetpointMode {
    /// The point that this mode calculates.
    pub const fn calculated(self) -> Option<TripSide> {
        match self {
            Self::LowByAtmosphere => Some(TripSide::Low),
            Self::HighByAtmosphere => Some(TripSide::High),
            Self::Setpoint | Self::BusOnly => None,
        }
    }
}

/// One of the two points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TripSide {
    /// Trips at or below.
    Low,
    /// Trips at or above.
    High,
}

/// A point with its enable and its hysteresis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TripLimit {
    /// ID 18, ID 20
    pub enabled: bool,
    /// ID 17, ID 19
    pub point_pa: f64,
    /// ID 31, ID 32: a difference of pressures.
    pub hysteresis_pa: f64,
    /// The condition exists. Within the hysteresis it depends on the side from which the pressure came.
    tripped: bool,
}

impl TripLimit {
    const fn new(enabled: bool, point_pa: f64, hysteresis_pa: f64) -> Self {
        Self { enabled, point_pa, hysteresis_pa, tripped: false }
    }

    /// The pressure at which the condition ends.
    const fn release_pa(&self, side: TripSide) -> f64 {
        match side {
            TripSide::Low => self.point_pa + self.hysteresis_pa,
            TripSide::High => self.point_pa - self.hysteresis_pa,
        }
    }

    /// Compares in the precision of the bus, so that a pressure that reads like the point is at the point: 11.1.1. A
    /// point that is disabled, or without a pressure, has no condition (98).
    fn compare(&mut self, side: TripSide, pa: Option<f64>) {
        let Some(pa) = pa.filter(|_| self.enabled) else {
            self.tripped = false;
            return;
        };
        let (pa, point, release) = (pa as f32, self.point_pa as f32, self.release_pa(side) as f32);
        let (reached, held) = match side {
            TripSide::Low => (pa <= point, pa <= release),
            TripSide::High => (pa >= point, pa >= release),
        };
        self.tripped = reached || (self.tripped && held);
    }
}

/// A trip point function block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TripPoint {
    low: TripLimit,
    high: TripLimit,
    /// ID 201, Factor of ATM: a plain factor (99).
    pub factor: f32,
    /// ID 202
    pub mode: SetpointMode,
}

impl TripPoint {
    /// The factory setting of a gauge that measures down to `lowest_pa` (102).
    pub const fn factory(lowest_pa: f64) -> Self {
        let hysteresis_pa = lowest_pa * 0.1;
        Self {
            low: TripLimit::new(true, lowest_pa, hysteresis_pa),
            high: TripLimit::new(false, lowest_pa, hysteresis_pa),
            // chosen: the manual gives no default.
            factor: 0.9,
            mode: SetpointMode::Setpoint,
        }
    }

    /// One of the points.
    pub const fn limit(&self, side: TripSide) -> &TripLimit {
        match side {
            TripSide::Low => &self.low,
            TripSide::High => &self.high,
        }
    }

    /// One of the points, to set it.
    pub const fn limit_mut(&mut self, side: TripSide) -> &mut TripLimit {
        match side {
            TripSide::Low => &mut self.low,
            TripSide::High => &mut self.high,
        }
    }

    /// ID 21: one status for both conditions (97).
    pub const fn status(&self) -> bool {
        self.low.tripped || self.high.tripped
    }

    /// Calculates the point that depends on the atmosphere: 11.1.2.
    pub fn set_atmosphere(&mut self, atmosphere_pa: f64) {
        if let Some(side) = self.mode.calculated() {
            self.limit_mut(side).point_pa = f64::from(self.factor) * atmosphere_pa;
        }
    }

    /// Compares the process value; `None` while the gauge does not measure.
    pub fn evaluate(&mut self, pa: Option<f64>) {
        self.low.compare(TripSide::Low, pa);
        self.high.compare(TripSide::High, pa);
    }

    /// The point that the push button sets: 11.2.13. With both enabled the low one, with none enabled none; never a
    /// calculated one.
    pub fn button_side(&self) -> Option<TripSide> {
        let side = match (self.low.enabled, self.high.enabled) {
            (true, _) => TripSide::Low,
            (false, true) => TripSide::High,
            (false, false) => return None,
        };
        (self.mode != SetpointMode::BusOnly && self.mode.calculated() != Some(side)).then_some(side)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MBAR: f64 = 100.0;

    fn at(low: Option<f64>, high: Option<f64>, hysteresis: f64) -> TripPoint {
        let mut trip = TripPoint::factory(1.0);
        trip.low = TripLimit::new(low.is_some(), low.unwrap_or(0.0) * MBAR, hysteresis * MBAR);
        trip.high = TripLimit::new(high.is_some(), high.unwrap_or(0.0) * MBAR, hysteresis * MBAR);
        trip
    }

    fn walk(trip: &mut TripPoint, steps: &[(f64, bool)]) {
        for (mbar, status) in steps {
            trip.evaluate(Some(mbar * MBAR));
            assert_eq!(trip.status(), *status, "at {mbar} mbar");
        }
    }

    #[test]
    fn the_trip_point_follows_the_examples_of_11_2_10_and_11_2_11() {
        let high =
            [(99.0, false), (100.0, true), (98.5, true), (98.0, true), (97.9, false), (99.9, false), (100.0, true)];
        walk(&mut at(None, Some(100.0), 2.0), &high);
        let low =
            [(101.0, false), (100.0, true), (101.5, true), (102.0, true), (102.1, false), (100.1, false), (99.0, true)];
        walk(&mut at(Some(100.0), None, 2.0), &low);
    }

    #[test]
    fn each_point_has_its_own_hysteresis() {
        let steps =
            [(50.0, false), (9.0, true), (10.9, true), (11.5, false), (90.0, true), (89.0, true), (50.0, false)];
        walk(&mut at(Some(10.0), Some(90.0), 1.0), &steps);
    }

    #[test]
    fn a_point_that_is_enabled_again_within_its_hysteresis_has_no_condition() {
        let mut trip = at(Some(100.0), None, 2.0);
        walk(&mut trip, &[(99.0, true), (101.0, true)]);
        trip.limit_mut(TripSide::Low).enabled = false;
        walk(&mut trip, &[(50.0, false)]);
        trip.limit_mut(TripSide::Low).enabled = true;
        walk(&mut trip, &[(101.0, false), (100.0, true)]);
    }

    #[test]
    fn a_trip_point_without_a_pressure_has_no_condition() {
        let mut trip = at(Some(100.0), None, 2.0);
        walk(&mut trip, &[(99.0, true)]);
        trip.evaluate(None);
        assert!(!trip.status());
        walk(&mut trip, &[(101.0, false)]);
    }

    #[test]
    fn the_atmosphere_moves_only_the_point_that_the_mode_calculates() {
        for (mode, low, high) in [
            (SetpointMode::Setpoint, 10.0, 20.0),
            (SetpointMode::LowByAtmosphere, 500.0, 20.0),
            (SetpointMode::HighByAtmosphere, 10.0, 500.0),
        ] {
            let mut trip = at(Some(10.0), Some(20.0), 1.0);
            (trip.mode, trip.factor) = (mode, 0.5);
            trip.set_atmosphere(1000.0 * MBAR);
            assert_eq!((trip.low.point_pa / MBAR, trip.high.point_pa / MBAR), (low, high), "{mode:?}");
        }
    }

    #[test]
    fn the_push_button_sets_the_point_of_the_table_of_11_2_13() {
        use SetpointMode::{BusOnly, HighByAtmosphere, LowByAtmosphere, Setpoint};
        let (low, high) = (Some(TripSide::Low), Some(TripSide::High));
        for (mode, both, only_low, only_high) in [
            (Setpoint, low, low, high),
            (LowByAtmosphere, None, None, high),
            (HighByAtmosphere, low, low, None),
            (BusOnly, None, None, None),
        ] {
            let side = |low: bool, high: bool| {
                let mut trip = at(low.then_some(1.0), high.then_some(1.0), 0.0);
                trip.mode = mode;
                trip.button_side()
            };
            assert_eq!(
                [side(true, true), side(true, false), side(false, true)],
                [both, only_low, only_high],
                "{mode:?}"
            );
            assert_eq!(side(false, false), None);
        }
    }
}
