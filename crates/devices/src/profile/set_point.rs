//! A relay with a potentiometer. tira41d1 3.2.5, errata-bpg-bcg-tpg 106 to 109.

use crate::model::mbar;

/// The potentiometer of a relay: p = 10^(`per_volt` x U + `at_0_v`) mbar.
#[derive(Debug, PartialEq)]
pub struct Potentiometer {
    /// Decades for one volt.
    pub per_volt: f64,
    /// The logarithm of the pressure in mbar at 0 V.
    pub at_0_v: f64,
    /// Above this pressure in Pa the relay stays open, whatever the threshold.
    pub highest_pa: f64,
}

/// It has no more volts than this.
const HIGHEST_V: f64 = 10.0;

/// 10 % of the threshold (108).
pub const HYSTERESIS: f64 = 0.1;

/// Potentiometer and contacts.
#[derive(Clone, Debug)]
pub struct SetPoint {
    potentiometer: &'static Potentiometer,
    volts: f64,
    closed: bool,
}

impl SetPoint {
    /// free choice: the manuals do not say where a potentiometer stands; at 0 V the relay hardly ever closes.
    #[must_use]
    pub const fn new(potentiometer: &'static Potentiometer) -> Self {
        Self { potentiometer, volts: 0.0, closed: false }
    }

    /// The same when power returns: the potentiometer stays where it is.
    #[must_use]
    pub const fn restarted(&self) -> Self {
        Self { volts: self.volts, ..Self::new(self.potentiometer) }
    }

    /// Somebody turns the potentiometer, as far as it goes.
    pub const fn turn(&mut self, volts: f64) {
        self.volts = volts.clamp(0.0, HIGHEST_V);
    }

    /// What the potentiometer is set to, in Pa.
    #[must_use]
    pub fn threshold_pa(&self) -> f64 {
        mbar(libm::exp10(self.potentiometer.per_volt * self.volts + self.potentiometer.at_0_v))
    }

    /// Whether the contacts are closed.
    #[must_use]
    pub const fn is_closed(&self) -> bool {
        self.closed
    }

    /// Status: closed shows in both low exceptions (106).
    #[must_use]
    pub const fn status(&self) -> u8 {
        if self.closed { 0x0A } else { 0 }
    }

    /// The contacts fall back.
    pub const fn open(&mut self) {
        self.closed = false;
    }

    /// Closed below the threshold, open 10 % above it, if it may be closed at all.
    pub fn follow(&mut self, allowed: bool, pa: f64) {
        let threshold_pa = self.threshold_pa().min(self.potentiometer.highest_pa);
        self.switch(allowed, pa < threshold_pa, pa <= threshold_pa * (1.0 + HYSTERESIS));
    }

    /// Closes where it `closes`, and stays closed where it `stays`.
    pub const fn switch(&mut self, allowed: bool, closes: bool, stays: bool) {
        self.closed = allowed && (closes || self.closed && stays);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// HPG400-SP, errata-bpg-bcg-tpg 107 and 109.
    static HPG: Potentiometer = Potentiometer { per_volt: 0.9, at_0_v: -6.0, highest_pa: mbar(100.0) };

    #[test]
    fn above_the_highest_pressure_a_relay_stays_open() {
        let mut point = SetPoint::new(&HPG);
        point.turn(10.0);
        assert!((point.threshold_pa() / mbar(1000.0) - 1.0).abs() < 1e-9, "the setting is shown as it is");
        for (pressure, closed) in [(500.0, false), (99.0, true), (109.0, true), (111.0, false)] {
            point.follow(true, mbar(pressure));
            assert_eq!(point.is_closed(), closed, "{pressure} mbar");
        }
    }

    #[test]
    fn what_is_not_allowed_opens_at_once() {
        let mut point = SetPoint::new(&HPG);
        point.turn(5.0);
        point.follow(true, mbar(1e-6));
        assert_eq!(point.status(), 0x0A);
        point.follow(false, mbar(1e-6));
        assert_eq!(point.status(), 0);
    }
}
