//! Helium at a leak in the record of a gauge, in words.

use crate::view::unix_ms;
use jiff::Timestamp;
use profivac_identify::Interval;
use profivac_identify::plant::Plant;
use profivac_identify::rise::GasDependence;
use profivac_identify::spray::{LeakPressure, Spray, find, response};
use profivac_recorder::Micros;
use serde::Serialize;
use utoipa::ToSchema;

/// A value with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct BoundsView {
    /// The best value.
    pub mean: f64,
    /// The lower bound.
    pub low: f64,
    /// The upper bound; `null` if there is none.
    pub high: Option<f64>,
}

/// Known facts beside a record.
#[derive(Clone, Copy, Debug, Default)]
pub struct Circumstances<'a> {
    /// How the indication depends on the gas, if it is known.
    pub gauge: Option<GasDependence>,
    /// The plant, of which the speed at the base pressure counts.
    pub plant: Option<&'a Plant>,
}

/// A change of the indication that looks like helium at a leak.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct SprayView {
    /// When the gas came, in milliseconds since 1970.
    pub start_ms: i64,
    /// When it went, in milliseconds since 1970.
    pub end_ms: i64,
    /// The change of the indication after many time constants in Pa; below zero if it falls.
    pub change_pa: BoundsView,
    /// The time constant of change and return in seconds: volume by pumping speed.
    pub time_constant_s: BoundsView,
    /// The leak in Pa m³/s of air; `null` if the kind of the gauge or the pumping speed is not known, or the change is not that of
    /// helium in place of air.
    pub leak_pa_m3_per_s: Option<BoundsView>,
    /// What it looks like, in words.
    #[schema(
        example = "2026-11-21 14:05:00 UTC, for 90.0 s: the indication falls by 5.4e-8 mbar (5.2e-8 to 5.6e-8), 27 % of it"
    )]
    pub text: String,
}

/// The changes in a part of a record with the valve to the pump open: seconds since `start` and pressures in Pa.
#[must_use]
pub fn sprays(start: Micros, samples: &[(f64, f64)], known: Circumstances<'_>) -> Vec<SprayView> {
    find(samples).iter().map(|spray| view(start, spray, known)).collect()
}

/// The changes in a record without the time in which the valve was closed.
#[must_use]
pub fn around(
    start: Micros,
    samples: &[(f64, f64)],
    closed: Option<[f64; 2]>,
    known: Circumstances<'_>,
) -> Vec<SprayView> {
    let [from, to] = closed.unwrap_or([f64::INFINITY; 2]);
    let before = samples.get(..samples.partition_point(|(s, _)| *s < from)).unwrap_or_default();
    let after = samples.get(samples.partition_point(|(s, _)| *s <= to)..).unwrap_or_default();
    [before, after].into_iter().flat_map(|part| sprays(start, part, known)).collect()
}

fn view(start: Micros, spray: &Spray, known: Circumstances<'_>) -> SprayView {
    let at = |s: f64| Micros(start.0.saturating_add((s * Micros::SECOND as f64) as i64));
    let leak = leak(spray, known);
    let flow = leak.as_ref().and_then(|leak| match leak {
        Leak::Flow(flow) => Some(*flow),
        Leak::OtherSign | Leak::TooLarge => None,
    });
    SprayView {
        start_ms: unix_ms(at(spray.from_s.mean)),
        end_ms: unix_ms(at(spray.to_s.mean)),
        change_pa: spray.change_pa.into(),
        time_constant_s: spray.tau_s.into(),
        leak_pa_m3_per_s: flow.map(BoundsView::from),
        text: sentence(at(spray.from_s.mean), spray, known.gauge, leak),
    }
}

/// What a change says about a leak, with the pumping speed.
enum Leak {
    Flow(Interval),
    OtherSign,
    TooLarge,
}

/// `None` without the kind of the gauge or the pumping speed.
fn leak(spray: &Spray, known: Circumstances<'_>) -> Option<Leak> {
    match spray.air_pa(known.gauge?) {
        LeakPressure::OtherSign => Some(Leak::OtherSign),
        LeakPressure::TooLarge => Some(Leak::TooLarge),
        LeakPressure::Air(air) => {
            let far = |pa: f64| (pa / spray.base_pa).ln().abs();
            let speeds = known.plant?.speeds.iter();
            let (_, speed) = speeds.min_by(|(one, _), (two, _)| far(*one).total_cmp(&far(*two)))?;
            let [low, high] = [air.low * speed.low, air.high * speed.high];
            Some(Leak::Flow(Interval { mean: air.mean * speed.mean, low, high }))
        }
    }
}

fn duration(seconds: f64) -> String {
    format!("{seconds:.1} s")
}

/// A kind of gauge, and how it responds.
fn of_gauge(gauge: GasDependence) -> String {
    let name = match gauge {
        GasDependence::None => "a diaphragm",
        GasDependence::Ionisation => "a hot or cold cathode",
        GasDependence::Conduction => "a Pirani",
    };
    let [least, greatest] = response(gauge).map(|part| part * 100.0);
    format!("{name} by {least:+.0} to {greatest:+.0} %")
}

fn sentence(at: Micros, spray: &Spray, gauge: Option<GasDependence>, leak: Option<Leak>) -> String {
    let Interval { mean, low, high } = spray.change_pa;
    let falls = mean < 0.0;
    let [size, least, most] = if falls { [-mean, -high, -low] } else { [mean, low, high] }.map(|pa| pa / 100.0);
    let verb = if falls { "falls" } else { "rises" };
    let tau = spray.tau_s;
    let mut text = format!(
        "{}, for {}: the indication {verb} by {size:.1e} mbar ({least:.1e} to {most:.1e}), {:.0} % of it, with a time constant of {} \
         ({} to {}), and returns with the same one: as with helium sprayed on a leak, or with another gas let in for this time",
        Timestamp::from_microsecond(at.0).unwrap_or_default().strftime("%Y-%m-%d %H:%M:%S UTC"),
        duration(spray.to_s.mean - spray.from_s.mean),
        100.0 * mean.abs() / spray.base_pa,
        duration(tau.mean),
        duration(tau.low),
        duration(tau.high),
    );
    text += &match (gauge, leak) {
        (None, _) => format!(
            ". Helium in place of the air of a leak changes the part of the indication that is this air: {}, {}, {}",
            of_gauge(GasDependence::Ionisation),
            of_gauge(GasDependence::Conduction),
            of_gauge(GasDependence::None),
        ),
        (Some(gauge), None) => {
            format!(". Helium changes the part of the indication that is air of the leak: {}", of_gauge(gauge))
        }
        (Some(_), Some(Leak::Flow(flow))) => {
            // 1 mbar l/s is 0.1 Pa m³/s.
            format!(". The leak is {:.1e} to {:.1e} mbar l/s of air", flow.low * 10.0, flow.high * 10.0)
        }
        (Some(gauge), Some(Leak::OtherSign)) => format!(
            ". Helium in place of air does not make it rise ({}), unless the pump takes helium badly: another gas is likelier",
            of_gauge(gauge)
        ),
        (Some(gauge), Some(Leak::TooLarge)) => format!(
            ". That is more than helium in place of all the gas would do ({}): another gas is likelier",
            of_gauge(gauge)
        ),
    };
    text
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test")]

    use super::*;

    fn spray(change: f64) -> Spray {
        Spray {
            from_s: Interval::normal(300.0, 0.2),
            to_s: Interval::normal(390.0, 0.2),
            tau_s: Interval { mean: 10.0, low: 9.0, high: 11.0 },
            change_pa: Interval { mean: change, low: change - 1e-7, high: change + 1e-7 },
            base_pa: 2e-5,
            misfit: 1.0,
        }
    }

    fn words(change: f64, gauge: Option<GasDependence>) -> String {
        view(Micros(0), &spray(change), Circumstances { gauge, plant: None }).text
    }

    #[test]
    fn a_spray_in_words_has_time_size_and_uncertainty_and_what_each_gauge_would_do() {
        assert_eq!(
            words(-5e-6, None),
            "1970-01-01 00:05:00 UTC, for 90.0 s: the indication falls by 5.0e-8 mbar (4.9e-8 to 5.1e-8), 25 % of it, with a time \
             constant of 10.0 s (9.0 s to 11.0 s), and returns with the same one: as with helium sprayed on a leak, or with another \
             gas let in for this time. Helium in place of the air of a leak changes the part of the indication that is this air: a \
             hot or cold cathode by -94 to -54 %, a Pirani by -57 to +236 %, a diaphragm by -65 to +169 %"
        );
        assert!(words(5e-6, Some(GasDependence::Conduction)).contains("a Pirani by -57 to +236 %"));
    }

    #[test]
    fn a_change_that_helium_cannot_make_says_so() {
        assert!(words(5e-6, Some(GasDependence::Ionisation)).contains("does not make it rise"));
        assert!(words(-1.98e-5, Some(GasDependence::Ionisation)).contains("more than helium in place of all the gas"));
    }
}
