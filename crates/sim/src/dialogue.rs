//! Scripted dialogues for tests: telegrams at given bit times, and the expected answers with their time windows.
//!
//! ```
//! use profivac_dp::link::Baud;
//! use profivac_sim::dialogue::Dialogue;
//! use profivac_sim::stations::MockStation;
//!
//! // A station that answers each telegram with SC, 11 bit times later.
//! let mut talk = Dialogue::new(Baud::B1500000, MockStation::new(|end, _| Some((end + 11, vec![0xE5]))));
//! talk.play("
//!     +40     ->  10 08 02 49 53 16      # sends FDL status after 40 bit times of idle line
//!     11..60  <-  E5                     # expects E5, beginning 11 to 60 bit times after that
//!     @1000   ->  10 08 02 49 53 16      # sends at bit time 1000
//!     11      <-  ..                     # expects any octet, exactly 11 bit times later
//!     300     <-  nothing                # expects silence for 300 bit times
//! ").unwrap();
//! ```

use crate::describe::{Hex, octet};
use crate::rule::Violation;
use crate::segment::Segment;
use crate::station_id::{StationHandle, StationId};
use crate::stations::Tester;
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Station};
use std::fmt;
use std::ops::RangeInclusive;

/// The octets of `text`: pairs of hexadecimal digits, separated by spaces.
///
/// # Panics
/// If `text` is anything else, which is an error in the test.
#[must_use]
#[expect(clippy::panic, reason = "an error in a test must be visible")]
pub fn hex(text: &str) -> Vec<u8> {
    let octet = |text| octet(text).unwrap_or_else(|| panic!("'{text}' is no octet"));
    text.split_whitespace().map(octet).collect()
}

/// A station on a segment with a tester that sends the telegrams of a script.
#[derive(Debug)]
pub struct Dialogue<S> {
    /// The segment, for faults and the time.
    pub segment: Segment,
    /// The station under test.
    pub station: StationHandle<S>,
    tester: StationHandle<Tester>,
    /// The number of telegrams that the script has covered.
    seen: usize,
    /// The end of the last one.
    end: BitTime,
}

/// A difference between script and line. `Debug` prints the same text as `Display`, for failed tests.
#[derive(Clone, PartialEq, Eq)]
pub struct Mismatch {
    /// The line of the script, or the octets of the request.
    pub line: String,
    /// The difference.
    pub difference: Difference,
    /// The trace of the segment.
    pub trace: String,
}

/// The kinds of difference between script and line. Times are in bit times after the end of the last telegram.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Difference {
    /// The line is not a line of a dialogue.
    Syntax,
    /// A station violates a rule.
    Violation(Box<Violation>),
    /// A station sends before the request of the script.
    Interrupted,
    /// No telegram begins within this time.
    Silence(u64),
    /// The telegram begins outside its window, after this time.
    Time(u64),
    /// The telegram has these octets.
    Octets(Vec<u8>),
    /// A telegram begins after this time although none is expected.
    Unexpected(u64, Vec<u8>),
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Syntax => f.write_str("this is no line of a dialogue"),
            Self::Violation(violation) => violation.fmt(f),
            Self::Interrupted => f.write_str("a station sent a telegram before"),
            Self::Silence(within_tbit) => write!(f, "no telegram began within {within_tbit} bit times"),
            Self::Time(tsdr) => write!(f, "the telegram began {tsdr} bit times after the last one"),
            Self::Octets(octets) => write!(f, "the telegram is {}", Hex(octets)),
            Self::Unexpected(tsdr, octets) => write!(f, "after {tsdr} bit times this telegram began: {}", Hex(octets)),
        }
    }
}

impl fmt::Display for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}\n{}\n{}", self.line, self.difference, self.trace)
    }
}

impl fmt::Debug for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl std::error::Error for Mismatch {}

/// One line of a script.
enum Step {
    /// The tester sends.
    Send(SendTime, Vec<u8>),
    /// The station sends within a window of bit times after the last telegram. `None` matches any octet.
    Expect(RangeInclusive<u64>, Vec<Option<u8>>),
    /// No station sends for this number of bit times after the last telegram.
    Nothing(u64),
}

enum SendTime {
    After(u64),
    At(BitTime),
}

impl<S: Station + Send + 'static> Dialogue<S> {
    /// A segment with `station` and a tester. The referee checks the station only.
    #[must_use]
    pub fn new(baud: Baud, station: S) -> Self {
        let mut segment = Segment::new(baud);
        let (station, tester) = (segment.attach(station), segment.attach(Tester::new()));
        segment.exempt(tester.id());
        segment.set_trace_length(usize::MAX);
        Self { segment, station, tester, seen: 0, end: BitTime(0) }
    }

    /// The station under test.
    #[must_use]
    pub fn station(&self) -> &S {
        self.segment.station(self.station)
    }

    /// The station under test, to change its device.
    pub fn station_mut(&mut self) -> &mut S {
        self.segment.station_mut(self.station)
    }

    /// The tester, for faults of its telegrams.
    #[must_use]
    pub const fn tester(&self) -> StationId {
        self.tester.id()
    }

    /// Plays the lines of `script`, continuing at the time at which the last script ended.
    ///
    /// # Errors
    /// [`Mismatch`] at the first line that differs, with the trace.
    pub fn play(&mut self, script: &str) -> Result<(), Mismatch> {
        for line in script.lines() {
            let line = line.split('#').next().unwrap_or_default().trim();
            if !line.is_empty() {
                let played = step(line).ok_or(Difference::Syntax).and_then(|step| self.step(&step));
                played.map_err(|difference| self.mismatch(line.to_owned(), difference))?;
            }
        }
        Ok(())
    }

    fn mismatch(&self, line: String, difference: Difference) -> Mismatch {
        Mismatch { line, difference, trace: self.segment.trace().to_string() }
    }

    fn step(&mut self, step: &Step) -> Result<(), Difference> {
        match step {
            Step::Send(when, octets) => self.send(when, octets),
            Step::Expect(window, octets) => self.expect(window, octets),
            Step::Nothing(tbit) => self.nothing(*tbit),
        }
    }

    /// Sends `octets` after `idle_tbit` bit times of idle line. Returns the answer that begins within the slot time, or
    /// `None`.
    ///
    /// # Errors
    /// [`Mismatch`] if the station violates a rule or sends before the request.
    pub fn ask(&mut self, idle_tbit: u64, octets: &[u8]) -> Result<Option<Vec<u8>>, Mismatch> {
        let slot = u64::from(self.segment.baud().default_slot_tbit());
        let answer = self.send(&SendTime::After(idle_tbit), octets).and_then(|()| self.answer(slot));
        let answer = answer.map_err(|difference| self.mismatch(Hex(octets).to_string(), difference))?;
        Ok(answer.map(|(_, octets)| octets))
    }

    fn send(&mut self, when: &SendTime, octets: &[u8]) -> Result<(), Difference> {
        let begin = match when {
            SendTime::After(tbit) => (self.end + *tbit).max(self.segment.now()),
            SendTime::At(time) => *time,
        };
        self.segment.station_mut(self.tester).send(begin, octets);
        self.run(begin)?;
        if self.segment.trace().entries.len() != self.seen + 1 {
            return Err(Difference::Interrupted);
        }
        self.seen += 1;
        self.end = begin + octets.len() as u64 * CHARACTER_TBIT;
        self.run(self.end)
    }

    fn expect(&mut self, window: &RangeInclusive<u64>, expected: &[Option<u8>]) -> Result<(), Difference> {
        let Some((tsdr, octets)) = self.answer(*window.end())? else {
            return Err(Difference::Silence(*window.end()));
        };
        if !window.contains(&tsdr) {
            return Err(Difference::Time(tsdr));
        }
        let matches = octets.len() == expected.len()
            && octets.iter().zip(expected).all(|(octet, expected)| expected.is_none_or(|expected| expected == *octet));
        if matches { Ok(()) } else { Err(Difference::Octets(octets)) }
    }

    fn nothing(&mut self, tbit: u64) -> Result<(), Difference> {
        match self.answer(tbit)? {
            Some((tsdr, octets)) => Err(Difference::Unexpected(tsdr, octets)),
            None => Ok(()),
        }
    }

    /// The telegram that begins within `within_tbit` after the last one, with the bit times in between.
    fn answer(&mut self, within_tbit: u64) -> Result<Option<(u64, Vec<u8>)>, Difference> {
        self.run(self.end + within_tbit)?;
        let Some(entry) = self.segment.trace().entries.get(self.seen).cloned() else { return Ok(None) };
        let tsdr = entry.start - self.end;
        self.seen += 1;
        self.end = entry.end();
        self.run(self.end)?;
        Ok(Some((tsdr, entry.octets.to_vec())))
    }

    fn run(&mut self, until: BitTime) -> Result<(), Difference> {
        self.segment.run_until(until).map_err(Difference::Violation)
    }
}

/// Reads `TIME -> OCTETS`, `WINDOW <- OCTETS` or `TIME <- nothing`.
fn step(line: &str) -> Option<Step> {
    if let Some((when, octets)) = line.split_once("->") {
        let octets = octets.split_whitespace().map(octet).collect::<Option<_>>()?;
        return Some(Step::Send(self::when(when.trim())?, octets));
    }
    let (window, octets) = line.split_once("<-")?;
    if octets.trim() == "nothing" {
        return Some(Step::Nothing(window.trim().parse().ok()?));
    }
    let octets = octets.split_whitespace().map(octet_or_any).collect::<Option<_>>()?;
    Some(Step::Expect(self::window(window.trim())?, octets))
}

/// Two digits, or `..` for any octet.
fn octet_or_any(text: &str) -> Option<Option<u8>> {
    if text == ".." { Some(None) } else { octet(text).map(Some) }
}

fn when(text: &str) -> Option<SendTime> {
    match text.split_at_checked(1)? {
        ("+", tbit) => tbit.parse().ok().map(SendTime::After),
        ("@", time) => time.parse().ok().map(|time| SendTime::At(BitTime(time))),
        _ => None,
    }
}

fn window(text: &str) -> Option<RangeInclusive<u64>> {
    let (from, to) = text.split_once("..").unwrap_or((text, text));
    Some(from.parse().ok()?..=to.parse().ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stations::MockStation;

    /// A dialogue with a station that answers each telegram with SC after 20 bit times.
    fn dialogue() -> Dialogue<impl Station + Send + 'static> {
        Dialogue::new(Baud::B1500000, MockStation::new(|end, _| Some((end + 20, vec![0xE5]))))
    }

    fn mismatch(script: &str) -> String {
        dialogue().play(script).unwrap_err().to_string()
    }

    #[test]
    fn a_script_that_matches_passes() {
        let script = "
            +40 -> 10 08 02 49 53 16
            20 <- E5
            +40 -> 10 08 02 49 53 16  # a comment
            11..60 <- ..
            500 <- nothing
            @2000 -> 10 08 02 49 53 16
            0..20 <- E5
        ";
        assert_eq!(dialogue().play(script), Ok(()));
    }

    #[test]
    fn each_difference_is_reported() {
        for (line, report) in [
            ("21..60 <- E5", "21..60 <- E5\nthe telegram began 20 bit times after the last one\n"),
            ("11..19 <- E5", "11..19 <- E5\nno telegram began within 19 bit times\n"),
            ("20 <- E6", "20 <- E6\nthe telegram is E5\n"),
            ("20 <- E5 E5", "\nthe telegram is E5\n"),
            ("20 <- nothing", "after 20 bit times this telegram began: E5\n"),
            ("+40 -> E5", "a station sent a telegram before\n"),
            ("soon -> E5", "soon -> E5\nthis is no line of a dialogue"),
            ("+40 E5", "+40 E5\nthis is no line of a dialogue"),
            ("+40 -> 5X", "+40 -> 5X\nthis is no line of a dialogue"),
        ] {
            let message = mismatch(&format!("+40 -> 10 08 02 49 53 16\n{line}"));
            assert!(message.contains(report), "{line}: {message}");
        }
    }

    #[test]
    fn a_mismatch_shows_the_trace() {
        assert!(mismatch("+40 -> 10 08 02 49 53 16\n20 <- E6").contains("FDL_Status ?"));
    }

    #[test]
    fn a_violation_of_a_rule_is_a_mismatch() {
        let mut dialogue = Dialogue::new(Baud::B1500000, MockStation::new(|end, _| Some((end + 10, vec![0xE5]))));
        let error = dialogue.play("+40 -> 10 08 02 49 53 16\n10 <- E5").unwrap_err();
        assert!(error.to_string().contains("it answered after 10 bit times, min T_SDR is 11"), "{error}");
    }
}
