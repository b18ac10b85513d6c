//! A trip point and its relay. tira56e1 11; numbers in brackets are those of errata-pxg55x-img400. Pressures are in Pa:
//! units are the business of whoever asks.

/// Parameter 202, Setpoint Mode: 11.2.13.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Both points are set by push button and bus.
    #[default]
    Setpoint = 0,
    /// The low point is calculated from the atmosphere.
    LowByAtmosphere = 1,
    /// The high point is calculated from the atmosphere.
    HighByAtmosphere = 2,
    /// Both points are set by the bus only.
    BusOnly = 4,
}

impl Mode {
    /// The mode of a code; 3 is missing on purpose (100).
    pub const fn of_code(code: u8) -> Option<Self> {
        match code {
            0 => Some(Self::Setpoint),
            1 => Some(Self::LowByAtmosphere),
            2 => Some(Self::HighByAtmosphere),
            4 => Some(Self::BusOnly),
            _ => None,
        }
    }

    /// The point this mode calculates.
    pub const fn calculated(self) -> Option<Side> {
        match self {
            Self::LowByAtmosphere => Some(Side::Low),
            Self::HighByAtmosphere => Some(Side::High),
            Self::Setpoint | Self::BusOnly => None,
        }
    }
}

/// Which of the two points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Trips at or below.
    Low,
    /// Trips at or above.
    High,
}

/// One point with its enable, its hysteresis and its memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// ID 18, ID 20
    pub enabled: bool,
    /// ID 17, ID 19
    pub point_pa: f64,
    /// ID 31, ID 32: a difference of pressures.
    pub hysteresis_pa: f64,
    /// The condition exists. Inside the hysteresis this remembers from which side the pressure came.
    tripped: bool,
}

impl Limit {
    const fn new(enabled: bool, point_pa: f64, hysteresis_pa: f64) -> Self {
        Self { enabled, point_pa, hysteresis_pa, tripped: false }
    }

    /// Where the condition ends.
    const fn release_pa(&self, side: Side) -> f64 {
        match side {
            Side::Low => self.point_pa + self.hysteresis_pa,
            Side::High => self.point_pa - self.hysteresis_pa,
        }
    }

    /// Compares in the precision of the bus, so that a pressure that reads like the point is at the point: 11.1.1. Whatever is
    /// not compared leaves no memory (98).
    fn compare(&mut self, side: Side, pa: Option<f64>) {
        let Some(pa) = pa.filter(|_| self.enabled) else {
            self.tripped = false;
            return;
        };
        let (pa, point, release) = (pa as f32, self.point_pa as f32, self.release_pa(side) as f32);
        let (reached, held) = match side {
            Side::Low => (pa <= point, pa <= release),
            Side::High => (pa >= point, pa >= release),
        };
        self.tripped = reached || (self.tripped && held);
    }
}

/// A trip point function block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TripPoint {
    low: Limit,
    high: Limit,
    /// ID 201, Factor of ATM: a plain factor (99).
    pub factor: f32,
    /// ID 202
    pub mode: Mode,
}

impl TripPoint {
    /// The factory setting of a gauge that measures down to `lowest_pa` (102).
    pub const fn factory(lowest_pa: f64) -> Self {
        let hysteresis_pa = lowest_pa * 0.1;
        Self {
            low: Limit::new(true, lowest_pa, hysteresis_pa),
            high: Limit::new(false, lowest_pa, hysteresis_pa),
            // free choice: the manual gives no default.
            factor: 0.9,
            mode: Mode::Setpoint,
        }
    }

    /// One of the points.
    pub const fn limit(&self, side: Side) -> &Limit {
        match side {
            Side::Low => &self.low,
            Side::High => &self.high,
        }
    }

    /// One of the points, to set it.
    pub const fn limit_mut(&mut self, side: Side) -> &mut Limit {
        match side {
            Side::Low => &mut self.low,
            Side::High => &mut self.high,
        }
    }

    /// ID 21: one status for both conditions (97).
    pub const fn status(&self) -> bool {
        self.low.tripped || self.high.tripped
    }

    /// The atmosphere moves the calculated point: 11.1.2.
    pub fn follow_atmosphere(&mut self, atmosphere_pa: f64) {
        if let Some(side) = self.mode.calculated() {
            self.limit_mut(side).point_pa = f64::from(self.factor) * atmosphere_pa;
        }
    }

    /// The process value is this now; `None` while nothing is measured.
    pub fn evaluate(&mut self, pa: Option<f64>) {
        self.low.compare(Side::Low, pa);
        self.high.compare(Side::High, pa);
    }

    /// The point the push button works on: 11.2.13. With both enabled only the low one, with none enabled none; never a
    /// calculated one.
    pub fn button_side(&self) -> Option<Side> {
        let side = match (self.low.enabled, self.high.enabled) {
            (true, _) => Side::Low,
            (false, true) => Side::High,
            (false, false) => return None,
        };
        (self.mode != Mode::BusOnly && self.mode.calculated() != Some(side)).then_some(side)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MBAR: f64 = 100.0;

    fn at(low: Option<f64>, high: Option<f64>, hysteresis: f64) -> TripPoint {
        let mut trip = TripPoint::factory(1.0);
        trip.low = Limit::new(low.is_some(), low.unwrap_or(0.0) * MBAR, hysteresis * MBAR);
        trip.high = Limit::new(high.is_some(), high.unwrap_or(0.0) * MBAR, hysteresis * MBAR);
        trip
    }

    fn walk(trip: &mut TripPoint, steps: &[(f64, bool)]) {
        for (mbar, status) in steps {
            trip.evaluate(Some(mbar * MBAR));
            assert_eq!(trip.status(), *status, "at {mbar} mbar");
        }
    }

    #[test]
    fn the_examples_of_11_2_10_and_11_2_11() {
        let high =
            [(99.0, false), (100.0, true), (98.5, true), (98.0, true), (97.9, false), (99.9, false), (100.0, true)];
        walk(&mut at(None, Some(100.0), 2.0), &high);
        let low =
            [(101.0, false), (100.0, true), (101.5, true), (102.0, true), (102.1, false), (100.1, false), (99.0, true)];
        walk(&mut at(Some(100.0), None, 2.0), &low);
    }

    #[test]
    fn each_point_has_its_own_memory() {
        let steps =
            [(50.0, false), (9.0, true), (10.9, true), (11.5, false), (90.0, true), (89.0, true), (50.0, false)];
        walk(&mut at(Some(10.0), Some(90.0), 1.0), &steps);
    }

    #[test]
    fn a_point_that_is_switched_off_and_on_starts_inside_its_hysteresis_with_no_condition() {
        let mut trip = at(Some(100.0), None, 2.0);
        walk(&mut trip, &[(99.0, true), (101.0, true)]);
        trip.limit_mut(Side::Low).enabled = false;
        walk(&mut trip, &[(50.0, false)]);
        trip.limit_mut(Side::Low).enabled = true;
        walk(&mut trip, &[(101.0, false), (100.0, true)]);
    }

    #[test]
    fn what_is_not_measured_leaves_no_memory() {
        let mut trip = at(Some(100.0), None, 2.0);
        walk(&mut trip, &[(99.0, true)]);
        trip.evaluate(None);
        assert!(!trip.status());
        walk(&mut trip, &[(101.0, false)]);
    }

    #[test]
    fn the_atmosphere_moves_only_the_point_the_mode_names() {
        for (mode, low, high) in
            [(Mode::Setpoint, 10.0, 20.0), (Mode::LowByAtmosphere, 500.0, 20.0), (Mode::HighByAtmosphere, 10.0, 500.0)]
        {
            let mut trip = at(Some(10.0), Some(20.0), 1.0);
            (trip.mode, trip.factor) = (mode, 0.5);
            trip.follow_atmosphere(1000.0 * MBAR);
            assert_eq!((trip.low.point_pa / MBAR, trip.high.point_pa / MBAR), (low, high), "{mode:?}");
        }
    }

    #[test]
    fn the_push_button_works_where_the_table_of_11_2_13_says() {
        use Mode::{BusOnly, HighByAtmosphere, LowByAtmosphere, Setpoint};
        let (low, high) = (Some(Side::Low), Some(Side::High));
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
