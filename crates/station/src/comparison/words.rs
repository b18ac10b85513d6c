//! A deviation as a sentence, and what it looks like.

use crate::pumpdown::compare::{Comparison, Direction, Level, Pattern};
use crate::pumpdown::excess::Excess;
use crate::report::format::{duration, timestamp};
use jiff::tz::TimeZone;
use profivac_recorder::Micros;

/// The deviation at the lowest deviating pressure, as a sentence without a full stop; `None` without a deviation.
#[must_use]
pub fn sentence(comparison: &Comparison, zone: &TimeZone) -> Option<String> {
    let Level { pa, s, usual: Some(usual), deviation: Some(direction) } = comparison.last()? else { return None };
    let mbar = mbar(*pa);
    let base = match usual.runs {
        1 => "the chosen one".to_owned(),
        runs => format!("the median of the last {runs}"),
    };
    let limits = match direction {
        Direction::Later => format!("at most {}", duration(usual.most_s)),
        Direction::Earlier => format!("at least {}", duration(usual.least_s)),
    };
    let usual_time = duration(usual.s);
    let mut text = match (s, direction) {
        (Some(s), Direction::Later) => {
            format!("{} later to {mbar} mbar than usual: {}", duration(s - usual.s), duration(*s))
        }
        (Some(s), Direction::Earlier) => {
            format!("{} earlier to {mbar} mbar than usual: {}", duration(usual.s - s), duration(*s))
        }
        (None, _) => format!("{mbar} mbar not reached after {}", duration(comparison.run.seconds())),
    };
    text += &format!("; usual {usual_time}, {base}, {limits}");
    if let Some(since) = comparison.since.filter(|since| *since < comparison.run.start) {
        text += &format!("; since {}", day(since, zone));
    }
    Some(text.replace('\u{a0}', " "))
}

/// What the deviation looks like, as a sentence.
#[must_use]
pub fn likeness(comparison: &Comparison, excess: Option<Excess>) -> Option<String> {
    let direction = comparison.last()?.deviation?;
    let text = match (comparison.pattern()?, direction, excess) {
        (_, Direction::Later, Some(Excess::Constant { pa })) => {
            format!("the pressure is above the usual one by a constant {} mbar, as with a leak", number(pa / 100.0))
        }
        (_, Direction::Later, Some(Excess::Outgassing { exponent })) => format!(
            "the pressure above the usual one falls as the time to the power of -{exponent:.1}, as with wetter or larger walls"
        ),
        (_, Direction::Later, Some(Excess::VirtualLeak { tau_s })) => format!(
            "the pressure above the usual one falls exponentially with {}, as with a virtual leak: a volume behind a small opening",
            duration(tau_s)
        ),
        (Pattern::FromTheBeginning, Direction::Later, None) => {
            "late from the beginning, as with a slower roughing pump, a valve that is not open, or a much larger leak".to_owned()
        }
        (Pattern::AtHighPressure, Direction::Later, None) => {
            "late at high pressure only, as with a roughing pump or a valve that started later".to_owned()
        }
        (Pattern::AtLowPressure, Direction::Later, None) => {
            "late at low pressure only, as with more gas from the walls, a leak or a slower high vacuum pump; a rate of rise tells them apart"
                .to_owned()
        }
        (_, Direction::Earlier, _) => "earlier than usual, as with drier walls, a larger pump, or a shorter vent".to_owned(),
    };
    Some(text.replace('\u{a0}', " "))
}

/// The day of the week and the date.
fn day(at: Micros, zone: &TimeZone) -> String {
    timestamp(at).to_zoned(zone.clone()).strftime("%A, %Y-%m-%d").to_string()
}

/// A decade of mbar.
fn mbar(pa: f64) -> String {
    let mbar = pa / 100.0;
    if (0.1..1000.0).contains(&mbar) { format!("{}", (mbar * 10.0).round() / 10.0) } else { format!("{mbar:.0e}") }
}

fn number(value: f64) -> String {
    format!("{value:.1e}")
}
