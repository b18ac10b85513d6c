//! A relay that closes below a pressure.

use crate::model::{Role, Row};

/// A row of a trip point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TripRow {
    /// Low Trip Point.
    Threshold,
    /// Low Trip Enable.
    Enable,
    /// Status.
    Status,
    /// Hysteresis.
    Hysteresis,
    /// The instance that it watches; 0 for the value of the gauge.
    Source,
}

impl TripRow {
    /// The row by its index, as BG 5530 4.4.3 and tira56e1 11.2 number it, and the hysteresis by its role.
    pub fn of(row: &Row) -> Option<Self> {
        if row.role == Some(Role::PressureDifference) {
            return Some(Self::Hysteresis);
        }
        Some(match row.index {
            19 => Self::Threshold,
            20 => Self::Enable,
            21 => Self::Status,
            27 => Self::Source,
            _ => return None,
        })
    }
}

/// The relay and its settings.
#[derive(Clone, Copy, Debug)]
pub struct Trip {
    /// Below this pressure in Pa it closes.
    pub threshold_pa: f64,
    /// It opens this far above, in Pa.
    pub hysteresis_pa: f64,
    /// Whether it may close.
    pub enabled: bool,
    /// The instance that it watches; 0 for the value of the gauge.
    pub source: u8,
    closed: bool,
}

impl Trip {
    /// As from the factory: not enabled.
    pub const NEW: Self = Self { threshold_pa: 0.0, hysteresis_pa: 0.0, enabled: false, source: 0, closed: false };

    /// Whether the contacts are closed.
    pub const fn is_closed(&self) -> bool {
        self.closed
    }

    /// ID 21, 1 while the relay is closed (errata-pxg55x-img400 97).
    pub const fn status(&self) -> u8 {
        self.closed as u8
    }

    /// Closes below the threshold, opens above threshold and hysteresis.
    pub fn follow(&mut self, allowed: bool, pa: Option<f64>) {
        let is_below = |limit_pa: f64| pa.is_some_and(|pa| pa < limit_pa);
        let limit_pa = if self.closed { self.threshold_pa + self.hysteresis_pa } else { self.threshold_pa };
        self.closed = allowed && self.enabled && is_below(limit_pa);
    }
}
