//! A simple pump-down: a volume that is emptied, a wall that gives off gas, a pump that can do no better.
//!
//! p(t) = p0 exp(-S t / V) + A q1 (1 h / t) / S + p_ult. free choice: a clean 100 l chamber of unbaked steel.

use profivac_host::pressure::Pressure;

const VOLUME_L: f64 = 100.0;
const SPEED_L_PER_S: f64 = 60.0;
const START_MBAR: f64 = 1013.25;
const ULTIMATE_MBAR: f64 = 1e-9;

/// The wall, and what a square centimetre of it gives off after an hour.
const WALL_CM2: f64 = 20_000.0;
const OUTGASSING_MBAR_L_PER_S_CM2: f64 = 1e-9;
const HOUR_S: f64 = 3600.0;

/// The true pressure after so many seconds.
pub fn pressure(seconds: f64) -> Pressure {
    let emptied = START_MBAR * (-SPEED_L_PER_S * seconds / VOLUME_L).exp();
    // In the first second the wall gives off as much as at its end: the power law has no beginning.
    let outgassing = WALL_CM2 * OUTGASSING_MBAR_L_PER_S_CM2 * HOUR_S / seconds.max(1.0);
    Pressure::from_mbar(emptied + outgassing / SPEED_L_PER_S + ULTIMATE_MBAR)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_chamber_is_emptied_and_then_the_wall_decides() {
        assert!((pressure(0.0).mbar() - START_MBAR).abs() < 0.01);
        // ln(1013.25 / 1) V / S = 11.5 s
        assert!((pressure(11.534).mbar() - 1.0).abs() < 1e-2);
        // Slope -1 on log-log axes.
        let ratio = pressure(600.0).mbar() / pressure(6000.0).mbar();
        assert!((ratio - 10.0).abs() < 0.1, "{ratio}");
    }
}
