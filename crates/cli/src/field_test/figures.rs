//! Timing figures of an adapter: turnaround, gaps within telegrams, lost characters.

use super::capture::octets;
use profivac_dp::link::{Baud, CHARACTER_TBIT};
use profivac_host::clock::{duration_of, tbit_of};
use profivac_host::port::{Character, Direction, RecordedChunk};
use profivac_wire::Telegram;
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// Figures of the message cycles with one slave.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Requests that were sent.
    pub requests: usize,
    /// Valid answers.
    pub answered: usize,
    /// Valid answers whose first character was delivered after the slot time.
    pub late: usize,
    /// Answers that are no telegram.
    pub damaged: usize,
    /// Requests without any octet of an answer.
    pub missing: usize,
    /// Characters that damaged answers are shorter than the valid answers to the same request.
    pub lost_characters: usize,
    /// Characters that damaged answers are longer than the valid answers to the same request.
    pub extra_characters: usize,
    /// Characters with a wrong parity or stop bit.
    pub character_errors: usize,
    /// From the end of the last octet sent to the delivery of the first octet.
    pub turnaround: Option<Distribution>,
    /// Between two deliveries of the same answer.
    pub gaps: Option<Distribution>,
    /// The most deliveries in which one answer came.
    pub most_pieces: usize,
}

/// A distribution of times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Distribution {
    /// The number of times.
    pub count: usize,
    /// The shortest.
    pub min: Time,
    /// Half of the times are not longer.
    pub median: Time,
    /// 99 % of the times are not longer.
    pub p99: Time,
    /// The longest.
    pub max: Time,
    /// Ranges that double; those without a time at both ends are left out.
    pub histogram: Vec<Bucket>,
}

/// A time in both units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Time {
    /// Milliseconds.
    pub ms: f64,
    /// Bit times of the line.
    pub bit_times: u64,
}

/// A range of a histogram.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bucket {
    /// The lower end, included.
    pub from: Time,
    /// The upper end, excluded.
    pub below: Time,
    /// The number of times in it.
    pub count: usize,
}

impl Time {
    fn of(time: Duration, baud: Baud) -> Self {
        // Microseconds are finer than what an operating system delivers.
        let us = u32::try_from(time.as_micros()).unwrap_or(u32::MAX);
        Self { ms: f64::from(us) / 1000.0, bit_times: tbit_of(baud, time) }
    }
}

/// The upper end of the first range of a histogram, in bit times. chosen: less than the shortest answer needs.
const FIRST_BUCKET_TBIT: u64 = 16;

impl Distribution {
    fn of(mut times: Vec<Duration>, baud: Baud) -> Option<Self> {
        times.sort_unstable();
        let last = times.len().checked_sub(1)?;
        // The smallest time that this part of the times does not exceed.
        let rank = |percent: usize| times.len().saturating_mul(percent).div_ceil(100).saturating_sub(1).min(last);
        let at = |index: usize| times.get(index).map(|time| Time::of(*time, baud));
        Some(Self {
            count: times.len(),
            min: at(0)?,
            median: at(rank(50))?,
            p99: at(rank(99))?,
            max: at(last)?,
            histogram: histogram(&times, baud),
        })
    }
}

fn histogram(times: &[Duration], baud: Baud) -> Vec<Bucket> {
    let tbit: Vec<_> = times.iter().map(|time| tbit_of(baud, *time)).collect();
    let longest = tbit.iter().copied().max().unwrap_or_default();
    let (mut buckets, mut from, mut below) = (Vec::new(), 0, FIRST_BUCKET_TBIT);
    loop {
        let count = tbit.iter().filter(|tbit| (from..below).contains(tbit)).count();
        let time = |tbit| Time::of(duration_of(baud, tbit), baud);
        if count > 0 || !buckets.is_empty() {
            buckets.push(Bucket { from: time(from), below: time(below), count });
        }
        if longest < below || below == u64::MAX {
            return buckets;
        }
        (from, below) = (below, below.saturating_mul(2));
    }
}

/// A request and the characters before the next one.
struct Exchange {
    request: Vec<u8>,
    /// When the last octet of the request had left.
    sent: Duration,
    /// When the octets of the answer were delivered.
    deliveries: Vec<Duration>,
    answer: Vec<Character>,
}

impl Exchange {
    fn turnaround(&self) -> Option<Duration> {
        self.deliveries.first().map(|first| first.saturating_sub(self.sent))
    }

    fn is_valid(&self) -> bool {
        !self.answer.contains(&Character::Error) && Telegram::parse(&octets(&self.answer)).is_ok()
    }
}

/// The exchanges in `chunks`. Characters before the first request are left out.
fn exchanges(chunks: &[RecordedChunk], baud: Baud, is_timed: bool) -> Vec<Exchange> {
    let mut exchanges: Vec<Exchange> = Vec::new();
    for chunk in chunks {
        match chunk.direction {
            Direction::Sent => {
                let tbit = CHARACTER_TBIT.saturating_mul(chunk.characters.len() as u64);
                let leaves = if is_timed { duration_of(baud, tbit) } else { Duration::ZERO };
                let sent = chunk.at.saturating_add(leaves);
                let request = octets(&chunk.characters);
                exchanges.push(Exchange { request, sent, deliveries: Vec::new(), answer: Vec::new() });
            }
            Direction::Received => {
                let Some(exchange) = exchanges.last_mut() else { continue };
                exchange.deliveries.push(chunk.at);
                exchange.answer.extend(&chunk.characters);
            }
        }
    }
    exchanges
}

/// The figures of requests that each need an answer. `slot_tbit` is the slot time of the master.
pub fn of(chunks: &[RecordedChunk], baud: Baud, is_timed: bool, slot_tbit: u64) -> Figures {
    let exchanges = exchanges(chunks, baud, is_timed);
    let valid: Vec<_> = exchanges.iter().filter(|exchange| exchange.is_valid()).collect();
    let usual = |request: &[u8]| {
        valid.iter().find(|exchange| exchange.request == request).map(|exchange| exchange.answer.len())
    };
    let slot = duration_of(baud, slot_tbit);
    let gaps = valid.iter().flat_map(|exchange| {
        exchange.deliveries.windows(2).filter_map(|pair| Some(pair.last()?.saturating_sub(*pair.first()?)))
    });
    let mut figures = Figures {
        requests: exchanges.len(),
        answered: valid.len(),
        late: valid.iter().filter(|exchange| exchange.turnaround() > Some(slot)).count(),
        turnaround: Distribution::of(valid.iter().filter_map(|exchange| exchange.turnaround()).collect(), baud),
        gaps: Distribution::of(gaps.collect(), baud),
        most_pieces: exchanges.iter().map(|exchange| exchange.deliveries.len()).max().unwrap_or_default(),
        ..Figures::default()
    };
    for exchange in exchanges.iter().filter(|exchange| !exchange.is_valid()) {
        let length = exchange.answer.len();
        if length == 0 {
            figures.missing = figures.missing.saturating_add(1);
            continue;
        }
        figures.damaged = figures.damaged.saturating_add(1);
        let errors = exchange.answer.iter().filter(|character| **character == Character::Error).count();
        figures.character_errors = figures.character_errors.saturating_add(errors);
        let usual = usual(&exchange.request).unwrap_or(length);
        figures.lost_characters = figures.lost_characters.saturating_add(usual.saturating_sub(length));
        figures.extra_characters = figures.extra_characters.saturating_add(length.saturating_sub(usual));
    }
    figures
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;

    const REQUEST: [u8; 6] = [0x10, 5, 0, 0x49, 0x4E, 0x16];
    const ANSWER: [u8; 6] = [0x10, 0, 5, 0, 5, 0x16];

    fn chunk(us: u64, direction: Direction, octets: &[u8]) -> RecordedChunk {
        let characters = octets.iter().copied().map(Character::Octet).collect();
        RecordedChunk { at: Duration::from_micros(us), direction, characters }
    }

    const MS: Duration = Duration::from_millis(1);

    #[test]
    fn a_distribution_has_minimum_median_ninety_nine_percent_and_maximum() {
        let distribution = Distribution::of((1..=200).rev().map(|ms| MS * ms).collect(), Baud::B19200).unwrap();
        let Distribution { count, min, median, p99, max, .. } = distribution;
        assert_eq!((count, min.ms, median.ms, p99.ms, max.ms), (200, 1.0, 100.0, 198.0, 200.0));
        assert_eq!((min.bit_times, max.bit_times), (19, 3840));
        assert_eq!(Distribution::of(Vec::new(), Baud::B19200), None);
    }

    #[test]
    fn the_ranges_of_a_histogram_double_and_hold_every_time() {
        let distribution = Distribution::of(vec![MS, MS, MS * 10], Baud::B19200).unwrap();
        let seen: Vec<_> = distribution
            .histogram
            .iter()
            .map(|range| (range.from.bit_times, range.below.bit_times, range.count))
            .collect();
        assert_eq!(seen, [(16, 32, 2), (32, 64, 0), (64, 128, 0), (128, 256, 1)]);
    }

    /// 66 bit times at 19200 bit/s are 3.4375 ms; the answer comes 5 ms later in two pieces that are 4 ms apart.
    #[test]
    fn turnaround_counts_from_the_end_of_the_last_octet_sent_on_a_port_with_a_rate() {
        let chunks = [
            chunk(0, Direction::Sent, &REQUEST),
            chunk(8_438, Direction::Received, &ANSWER[..4]),
            chunk(12_438, Direction::Received, &ANSWER[4..]),
        ];
        let timed = of(&chunks, Baud::B19200, true, 100);
        assert_eq!(timed.turnaround.unwrap().median.ms, 5.0);
        assert_eq!((timed.gaps.unwrap().max.ms, timed.most_pieces, timed.late), (4.0, 2, 0));
        let unpaced = of(&chunks, Baud::B19200, false, 100);
        assert_eq!((unpaced.turnaround.unwrap().median.ms, unpaced.late), (8.438, 1));
    }

    #[test]
    fn damaged_and_missing_answers_and_lost_characters_are_counted() {
        let mut broken = chunk(60_000, Direction::Received, &ANSWER[..3]);
        broken.characters.push(Character::Error);
        let chunks = [
            chunk(0, Direction::Sent, &REQUEST),
            chunk(10_000, Direction::Received, &ANSWER),
            chunk(20_000, Direction::Sent, &REQUEST),
            chunk(30_000, Direction::Sent, &REQUEST),
            chunk(40_000, Direction::Received, &ANSWER[..5]),
            chunk(50_000, Direction::Sent, &REQUEST),
            broken,
        ];
        let figures = of(&chunks, Baud::B19200, false, 1000);
        assert_eq!((figures.requests, figures.answered, figures.missing, figures.damaged), (4, 1, 1, 2));
        assert_eq!((figures.lost_characters, figures.extra_characters, figures.character_errors), (3, 0, 1));
    }
}
