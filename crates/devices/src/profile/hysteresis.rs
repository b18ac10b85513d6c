//! A switch with two thresholds.

/// The state of a switch that switches on below one pressure and off above another; between the two it keeps its state `was`.
/// Pressures in Pa; without a pressure it is off.
#[must_use]
pub fn switched(pressure: Option<f64>, on_below_pa: f64, off_above_pa: f64, was: bool) -> bool {
    match pressure {
        None => false,
        Some(pa) if pa < on_below_pa => true,
        Some(pa) if pa > off_above_pa => false,
        Some(_) => was,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_switch_keeps_its_state_between_the_thresholds() {
        for (pa, was, is) in [
            (0.9, false, true),
            (1.0, false, false),
            (1.5, false, false),
            (1.5, true, true),
            (2.0, true, true),
            (2.1, true, false),
        ] {
            assert_eq!(switched(Some(pa), 1.0, 2.0, was), is, "{pa} {was}");
        }
        assert!(!switched(None, 1.0, 2.0, true));
    }
}
