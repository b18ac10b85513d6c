//! Telegram 205 of the TTR compatibility mode: tira56e1 4.4.1, errata-pxg55x-img400 50.

use crate::model::{log, mbar};

/// The highest 12-bit value.
const HIGHEST: f64 = 4095.0;

/// "Error".
const ERROR: u8 = 1 << 7;
/// "Trip Point 1 activated".
const TRIP_POINT_1: u8 = 1 << 6;

/// The measurement value of a pressure in Pa.
fn measurement(pa: f64) -> u16 {
    // A pressure of 0 has no logarithm and becomes 0, and so does NaN.
    let value = libm::round(482.0 * (log::log10(pa / mbar(1.0)) + 4.778));
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let value = value.clamp(0.0, HIGHEST) as u16;
    value
}

/// The octets of the telegram: status in the high nibble, then the 12 bits.
pub fn octets(error: bool, trip_point_1: bool, pa: f64) -> [u8; 2] {
    let [high, low] = measurement(pa).to_be_bytes();
    [high | if error { ERROR } else { 0 } | if trip_point_1 { TRIP_POINT_1 } else { 0 }, low]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_decodes_to_the_pressure_in_all_three_printed_units() {
        for pressure in [1e-4, 5e-3, 1.0, 12.0, 1013.25] {
            let value = f64::from(measurement(mbar(pressure)));
            for (unit, offset) in [(1.0, 4.778), (1.0 / 1.333_223_69, 4.9029), (100.0, 2.778)] {
                let decoded = log::exp10(value / 482.0 - offset);
                // Half a step is 0.24 %, and the offsets are rounded.
                assert!((decoded / (pressure * unit) - 1.0).abs() < 0.003, "{pressure} mbar: {decoded}");
            }
        }
    }

    #[test]
    fn values_have_12_bits() {
        assert_eq!([0.0, -1.0, 1e-9, 1e9, f64::NAN].map(measurement), [0, 0, 0, 4095, 0]);
    }

    #[test]
    fn status_and_value_share_the_first_octet() {
        // 1 mbar: 482 x 4.778 = 2303 = 8FF hex.
        assert_eq!(octets(false, false, mbar(1.0)), [0x08, 0xFF]);
        assert_eq!(octets(true, false, mbar(1.0)), [0x88, 0xFF]);
        assert_eq!(octets(false, true, mbar(1.0)), [0x48, 0xFF]);
    }
}
