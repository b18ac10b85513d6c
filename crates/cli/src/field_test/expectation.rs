//! Sentences about measured times that are longer than profivac expects of the port.

use super::figures::{Distribution, Figures, Time};
use super::report::PortFacts;
use profivac_dp::link::Baud;
use profivac_host::clock::duration_of;
use profivac_host::session::MAX_SLOT_TBIT;

/// A sentence with the remedy for each longest time of `figures` that exceeds what the port should need. `slot_tbit` is the slot time
/// of the measurement. A port without a rate has no expectation.
pub fn of(figures: &Figures, port: &PortFacts, baud: Baud, slot_tbit: u64) -> Vec<String> {
    let Some(expected) = port.expected_turnaround_bit_times else { return Vec::new() };
    let tolerated = port.tolerated_pause_bit_times;
    let late = longest(&figures.turnaround, expected).map(|time| turnaround(time, expected, baud, slot_tbit));
    let apart = longest(&figures.gaps, tolerated).map(|time| pause(time, tolerated, baud));
    late.into_iter().chain(apart).collect()
}

/// The longest time, if it exceeds `limit` bit times.
fn longest(times: &Option<Distribution>, limit: u64) -> Option<Time> {
    times.as_ref().map(|times| times.max).filter(|max| max.bit_times > limit)
}

fn turnaround(found: Time, expected: u64, baud: Baud, slot_tbit: u64) -> String {
    let maximum = u64::from(MAX_SLOT_TBIT);
    let wanted = found.bit_times.saturating_mul(2).min(maximum);
    let remedy = match found.bit_times {
        tbit if tbit > maximum => {
            "no slot time is that long: use an adapter with less delay, or a lower rate".to_owned()
        }
        tbit if tbit > slot_tbit => {
            format!("the slot time of {slot_tbit} bit times is too short: run profivac with --slot-time {wanted}")
        }
        _ => format!(
            "the slot time of {slot_tbit} bit times is long enough for it; beside other masters set T_SL of each master to at least \
             {wanted} bit times"
        ),
    };
    let expected = milliseconds(baud, expected);
    format!(
        "the longest turnaround is {:.1} ms, expected of this port are at most {expected:.1} ms; {remedy}; {CAUSES}",
        found.ms
    )
}

fn pause(found: Time, tolerated: u64, baud: Baud) -> String {
    let tolerated = milliseconds(baud, tolerated);
    format!(
        "the longest pause within an answer is {:.1} ms, expected of this port are at most {tolerated:.1} ms; a master of profivac \
         tolerates such a pause after the first one, and `sniff` and `simulate` may take it as the end of a telegram; {CAUSES}",
        found.ms
    )
}

/// What a user can do about both.
const CAUSES: &str = "set the latency of the adapter to 1 ms, and end programs that load the computer";

fn milliseconds(baud: Baud, tbit: u64) -> f64 {
    duration_of(baud, tbit).as_secs_f64() * 1e3
}

#[cfg(test)]
mod tests {
    use super::*;

    const BAUD: Baud = Baud::B19200;

    fn port(expected: Option<u64>) -> PortFacts {
        PortFacts {
            name: "/dev/ttyUSB0".to_owned(),
            driver: None,
            usb_id: None,
            delivery: String::new(),
            has_rate: expected.is_some(),
            tolerated_pause_bit_times: 96,
            expected_turnaround_bit_times: expected,
            slot_time_bit_times: 480,
            notices: Vec::new(),
        }
    }

    fn times(bit_times: u64) -> Option<Distribution> {
        let time = Time { ms: milliseconds(BAUD, bit_times), bit_times };
        Some(Distribution { count: 1, min: time, median: time, p99: time, max: time, histogram: Vec::new() })
    }

    fn notices(turnaround: u64, gaps: u64) -> Vec<String> {
        let figures = Figures { turnaround: times(turnaround), gaps: times(gaps), ..Figures::default() };
        of(&figures, &port(Some(192)), BAUD, 480)
    }

    #[test]
    fn times_within_the_expectation_need_no_notice() {
        assert_eq!(notices(192, 96), Vec::<String>::new());
        let figures = Figures { turnaround: times(5_000), gaps: times(5_000), ..Figures::default() };
        assert_eq!(of(&figures, &port(None), BAUD, 480), Vec::<String>::new(), "no rate, no expectation");
    }

    #[test]
    fn a_longer_turnaround_than_expected_has_a_sentence_with_the_remedy() {
        for (tbit, remedy) in [
            (
                193,
                "the longest turnaround is 10.1 ms, expected of this port are at most 10.0 ms; the slot time of 480 bit times is long enough",
            ),
            (481, "is too short: run profivac with --slot-time 962; set the latency"),
            (16_384, "no slot time is that long: use an adapter with less delay, or a lower rate; set"),
        ] {
            let notices = notices(tbit, 96);
            assert!(matches!(&notices[..], [notice] if notice.contains(remedy)), "{tbit}: {notices:?}");
        }
    }

    #[test]
    fn a_longer_pause_than_expected_has_a_sentence_with_the_remedy() {
        let notices = notices(192, 192);
        let beginning = "the longest pause within an answer is 10.0 ms, expected of this port are at most 5.0 ms; ";
        assert!(
            matches!(&notices[..], [notice] if notice.starts_with(beginning) && notice.ends_with(CAUSES)),
            "{notices:?}"
        );
    }
}
