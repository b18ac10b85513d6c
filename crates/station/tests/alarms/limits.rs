//! Limits of a pressure, their texts, and ends of ranges.

use super::{Fixture, above, rule, series};
use crate::support::inputs::{inputs, silent};
use profivac_recorder::Quality;
use profivac_station::alarm::{AlarmChangeKind, AlarmState, Condition, Inputs};

#[test]
fn a_limit_alarm_is_raised_at_the_limit_and_returns_at_the_reset() {
    let mut fixture = Fixture::new(vec![above(0, 0)]);
    assert_eq!(fixture.evaluate(&inputs(1.0, Quality::Valid)), [], "the limit itself is not above the limit");
    assert_eq!(fixture.evaluate(&inputs(1.000_001, Quality::Valid)), [AlarmChangeKind::Raised]);
    for pa in [0.99, 0.500_001, 1.5, 0.7] {
        assert_eq!(fixture.evaluate(&inputs(pa, Quality::Valid)), [], "{pa}");
    }
    assert_eq!(fixture.evaluate(&inputs(0.5, Quality::Valid)), [AlarmChangeKind::Returned]);
    assert_eq!(fixture.evaluate(&inputs(0.99, Quality::Valid)), [], "after the return the limit counts again");
    let mut fixture = Fixture::new(vec![rule(Condition::Below { series: series(), limit: 1.0, reset: 2.0 }, 0, 0)]);
    assert_eq!(fixture.evaluate(&inputs(1.0, Quality::Valid)), []);
    assert_eq!(fixture.evaluate(&inputs(0.999, Quality::Valid)), [AlarmChangeKind::Raised]);
    assert_eq!(fixture.evaluate(&inputs(1.999, Quality::Valid)), []);
    assert_eq!(fixture.evaluate(&inputs(2.0, Quality::Valid)), [AlarmChangeKind::Returned]);
}

#[test]
fn the_text_of_a_change_states_where_the_pressure_is() {
    let above = |limit, reset| Condition::Above { series: series(), limit, reset };
    let below = |limit, reset| Condition::Below { series: series(), limit, reset };
    let table = [
        (above(101_300.0, 50.0), 101_325.0, "1013 mbar, above the limit of 1013 mbar"),
        (above(100.0, 50.0), 2_340.0, "23.4 mbar, above the limit of 1.00 mbar"),
        (above(100.0, 50.0), 200.0, "2.00 mbar, above the limit of 1.00 mbar"),
        (above(100.0, 50.0), 7.75e-5, "7.75e-7 mbar, not above the reset value of 5.00e-1 mbar"),
        (above(100.0, 50.0), 50.0, "5.00e-1 mbar, not above the reset value of 5.00e-1 mbar"),
        (above(100.0, 100.0), 100.0, "1.00 mbar, not above the limit of 1.00 mbar"),
        (below(100.0, 200.0), 50.0, "5.00e-1 mbar, below the limit of 1.00 mbar"),
        (below(100.0, 200.0), 300.0, "3.00 mbar, not below the reset value of 2.00 mbar"),
        (below(100.0, 100.0), 150.0, "1.50 mbar, not below the limit of 1.00 mbar"),
    ];
    for (condition, pa, expected) in table {
        let mut fixture = Fixture::new(vec![rule(condition.clone(), 0, 0)]);
        let now = fixture.now();
        let mut text = fixture.registry.evaluate(&inputs(pa, Quality::Valid), now).pop().map(|change| change.text);
        if text.is_none() {
            let beyond = if matches!(condition, Condition::Above { .. }) { 1e4 } else { 1e-4 };
            assert_eq!(fixture.evaluate(&inputs(beyond, Quality::Valid)), [AlarmChangeKind::Raised]);
            text = fixture.registry.evaluate(&inputs(pa, Quality::Valid), now).pop().map(|change| change.text);
        }
        assert_eq!(text, Some(format!("chamber shows {expected}")), "{condition:?}");
    }
}

#[test]
fn an_alarm_raised_between_limit_and_reset_does_not_claim_the_limit() {
    let mut fixture = Fixture::new(vec![above(0, 0)]);
    fixture.evaluate(&inputs(2.0, Quality::Valid));
    let now = fixture.now();
    fixture.registry.take_out_of_service("it", "Eve", "service", None, now).unwrap();
    fixture.registry.return_to_service("it", "Eve", now).unwrap();
    assert_eq!(fixture.evaluate(&inputs(0.7, Quality::Valid)), [AlarmChangeKind::Raised]);
    let expected = "chamber shows 7.00e-3 mbar, above the reset value of 5.00e-3 mbar";
    assert_eq!(fixture.status().text, expected);
    fixture.registry.take_out_of_service("it", "Eve", "service", None, now).unwrap();
    fixture.registry.return_to_service("it", "Eve", now).unwrap();
    assert_eq!(fixture.evaluate(&silent()), [AlarmChangeKind::Raised]);
    assert_eq!(fixture.status().text, "its condition was met when it was last known");
}

#[test]
fn an_unknown_pressure_neither_raises_nor_clears_an_alarm() {
    let without_pressure = [Quality::Fault, Quality::Stale, Quality::Off, Quality::Missing];
    for nothing in without_pressure.map(|quality| inputs(0.1, quality)).into_iter().chain([silent(), Inputs::default()])
    {
        let mut fixture = Fixture::new(vec![above(0, 0)]);
        assert_eq!(fixture.evaluate(&nothing), []);
        fixture.evaluate(&inputs(2.0, Quality::Valid));
        assert_eq!(fixture.evaluate(&nothing), [], "{nothing:?}");
        assert_eq!(fixture.state(), AlarmState::Unacknowledged);
        assert_eq!(fixture.evaluate(&inputs(0.1, Quality::Valid)), [AlarmChangeKind::Returned]);
    }
}

#[test]
fn the_end_of_a_range_bounds_the_pressure() {
    let table = [
        // end of the range, quality, whether the limit of 1 Pa is exceeded
        (2.0, Quality::Overrange, Some(true)),
        (0.5, Quality::Overrange, None),
        (0.2, Quality::Underrange, Some(false)),
        (2.0, Quality::Underrange, None),
    ];
    for (pa, quality, known) in table {
        let mut fixture = Fixture::new(vec![above(0, 0)]);
        assert_eq!(fixture.evaluate(&inputs(pa, quality)).is_empty(), known != Some(true), "{pa} {quality:?}");
        let mut fixture = Fixture::new(vec![above(0, 0)]);
        fixture.evaluate(&inputs(9.0, Quality::Valid));
        assert_eq!(fixture.evaluate(&inputs(pa, quality)).is_empty(), known != Some(false), "{pa} {quality:?}");
        let blind = Condition::NotMeasurable { series: series(), limits: vec![1.0], has_fault_alarm: false };
        let mut fixture = Fixture::new(vec![rule(blind, 0, 0)]);
        assert_eq!(
            fixture.evaluate(&inputs(pa, quality)).is_empty(),
            known.is_some(),
            "{pa} {quality:?} is not measurable"
        );
    }
}

/// The limit is 1 Pa, the reset value 0.5 Pa, and the range of the gauge ends at 0.7 Pa.
#[test]
fn an_alarm_returns_below_the_range_of_its_gauge_although_the_reset_value_is_below_the_range() {
    let mut fixture = Fixture::new(vec![above(0, 0)]);
    fixture.evaluate(&inputs(2.0, Quality::Valid));
    assert_eq!(fixture.evaluate(&inputs(0.8, Quality::Valid)), [], "not past the reset value");
    let now = fixture.now();
    let changes = fixture.registry.evaluate(&inputs(0.7, Quality::Underrange), now);
    assert_eq!(changes[0].kind, AlarmChangeKind::Returned);
    assert_eq!(changes[0].text, "chamber shows under range (< 7.00e-3 mbar), not above the limit of 1.00e-2 mbar");
}

#[test]
fn the_text_of_a_change_says_on_which_side_of_the_limit_the_pressure_is() {
    let mut fixture = Fixture::new(vec![above(0, 0)]);
    let now = fixture.now();
    let raised = fixture.registry.evaluate(&inputs(2.0, Quality::Valid), now);
    assert_eq!(raised[0].text, "chamber shows 2.00e-2 mbar, above the limit of 1.00e-2 mbar");
    let returned = fixture.registry.evaluate(&inputs(0.4, Quality::Valid), now);
    assert_eq!(returned[0].text, "chamber shows 4.00e-3 mbar, not above the reset value of 5.00e-3 mbar");
}
