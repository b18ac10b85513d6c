//! Pressures in the units and data types of the manuals.

/// A unit of pressure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    Counts,
    Torr,
    Micron,
    Mbar,
    Pascal,
}

/// What COUNTS are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// `factor x log10(p / mbar) + offset`.
    Logarithm { factor: f64, offset: f64 },
    /// `factor x p / mbar`.
    Line(f64),
}

/// How a device shows a number: the unit, the data type, and the rules of its manual.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Form {
    pub unit: Unit,
    pub float: bool,
    /// Torr of a millibar.
    pub torr: f64,
    /// The largest integer.
    pub top: u16,
}

impl Form {
    /// The number that shows a pressure. Zero is 0 in every unit (74).
    pub fn number(&self, mbar: f64, scale: Scale) -> f64 {
        if mbar == 0.0 {
            return 0.0;
        }
        match (self.unit, scale) {
            (Unit::Counts, Scale::Logarithm { factor, offset }) => factor * mbar.log10() + offset,
            (Unit::Counts, Scale::Line(factor)) => factor * mbar,
            (Unit::Torr, _) => mbar * self.torr,
            (Unit::Micron, _) => mbar * self.torr * 1000.0,
            (Unit::Mbar, _) => mbar,
            (Unit::Pascal, _) => mbar * 100.0,
        }
    }

    /// The pressure of a number.
    pub fn mbar(&self, number: f64, scale: Scale) -> f64 {
        if number == 0.0 {
            return 0.0;
        }
        match (self.unit, scale) {
            (Unit::Counts, Scale::Logarithm { factor, offset }) => 10f64.powf((number - offset) / factor),
            (Unit::Counts, Scale::Line(factor)) => number / factor,
            (Unit::Torr, _) => number / self.torr,
            (Unit::Micron, _) => number / self.torr / 1000.0,
            (Unit::Mbar, _) => number,
            (Unit::Pascal, _) => number / 100.0,
        }
    }

    /// The octets of a number: an integer is truncated and has its limits.
    pub fn octets(&self, number: f64) -> Vec<u8> {
        if self.float {
            (number as f32).to_be_bytes().to_vec()
        } else {
            (number.clamp(0.0, f64::from(self.top)) as u16).to_be_bytes().to_vec()
        }
    }

    /// The number of octets.
    pub fn parse(&self, octets: &[u8]) -> Option<f64> {
        match *octets {
            [a, b, c, d] if self.float => Some(f64::from(f32::from_be_bytes([a, b, c, d]))),
            [a, b] if !self.float && self.top == u16::MAX => Some(f64::from(u16::from_be_bytes([a, b]))),
            [a, b] if !self.float => Some(f64::from(i16::from_be_bytes([a, b]))),
            _ => None,
        }
    }

    /// Octets of a pressure.
    pub const fn length(&self) -> usize {
        if self.float { 4 } else { 2 }
    }

    /// Whether octets show the same: floats to a millionth, integers to one.
    pub fn alike(&self, one: &[u8], other: &[u8]) -> bool {
        let (Some(one), Some(other)) = (self.parse(one), self.parse(other)) else { return false };
        let relative = 1e-6 * one.abs().max(other.abs());
        let allowed = match (self.float, self.unit) {
            (false, _) => 1.0,
            (true, Unit::Counts) => relative.max(1e-6),
            (true, _) => relative,
        };
        (one - other).abs() <= allowed
    }
}
