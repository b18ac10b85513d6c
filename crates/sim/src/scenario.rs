//! Tests as a dialogue: who sends what at which bit time, and what must come back in which window.
//!
//! ```
//! use profivac_dp::link::Baud;
//! use profivac_sim::scenario::Dialogue;
//! use profivac_sim::stations::Puppet;
//!
//! // A station that answers everything with SC, 11 bit times later.
//! let mut talk = Dialogue::new(Baud::B1500000, Puppet::new(|end, _| Some((end + 11, vec![0xE5]))));
//! talk.play("
//!     +40     ->  10 08 02 49 53 16      # FDL status, after 40 bit times of idle line
//!     11..60  <-  E5                     # begins 11 to 60 bit times after the end of that
//!     @1000   ->  10 08 02 49 53 16      # at bit time 1000
//!     11      <-  ..                     # exactly 11 bit times later, any octet
//!     300     <-  nothing                # nobody says anything for 300 bit times
//! ").unwrap();
//! ```

use crate::describe::{Hex, octet};
use crate::segment::{Segment, StationHandle, StationId};
use crate::stations::Tester;
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Station};
use std::fmt;
use std::ops::RangeInclusive;

/// The octets of `text`, two hexadecimal digits each, spaces where they help.
///
/// # Panics
/// If `text` is anything else: it is a slip in a test.
#[must_use]
#[expect(clippy::panic, reason = "a slip in a test has to be seen")]
pub fn hex(text: &str) -> Vec<u8> {
    let octet = |text| octet(text).unwrap_or_else(|| panic!("'{text}' is no octet"));
    text.split_whitespace().map(octet).collect()
}

/// A station alone on a line with one that says what the test wants.
#[derive(Debug)]
pub struct Dialogue<S> {
    /// The line, for faults and a look at the clock.
    pub bus: Segment,
    /// The station that is tested.
    pub station: StationHandle<S>,
    tester: StationHandle<Tester>,
    /// How many telegrams were on the line and have been accounted for.
    seen: usize,
    /// When the last of them ended.
    end: BitTime,
}

/// Where the dialogue went another way. `Debug` shows the story too, for failed tests.
#[derive(Clone, PartialEq, Eq)]
pub struct Mismatch(String);

impl fmt::Display for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl fmt::Debug for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Mismatch {}

/// One line of a dialogue.
enum Step {
    /// The tester sends.
    Send(SendTime, Vec<u8>),
    /// The station sends, so many bit times after the last telegram. `None` matches any octet.
    Expect(RangeInclusive<u64>, Vec<Option<u8>>),
    /// Nobody sends for so many bit times after the last telegram.
    Nothing(u64),
}

enum SendTime {
    After(u64),
    At(BitTime),
}

impl<S: Station + Send + 'static> Dialogue<S> {
    /// A line with `station` and the tester. The referee judges the station only.
    #[must_use]
    pub fn new(baud: Baud, station: S) -> Self {
        let mut bus = Segment::new(baud);
        let (station, tester) = (bus.attach(station), bus.attach(Tester::new()));
        bus.exempt(tester.id());
        bus.set_trace_length(usize::MAX);
        Self { bus, station, tester, seen: 0, end: BitTime(0) }
    }

    /// The station that is tested.
    #[must_use]
    pub fn station(&self) -> &S {
        self.bus.station(self.station)
    }

    /// The station that is tested, to change what is behind it.
    pub fn station_mut(&mut self) -> &mut S {
        self.bus.station_mut(self.station)
    }

    /// The station that says what the script says, to tamper with.
    #[must_use]
    pub const fn tester(&self) -> StationId {
        self.tester.id()
    }

    /// Plays the lines of `script`. The line goes on where the last play has ended.
    ///
    /// # Errors
    /// [`Mismatch`] at the first line that is not met, with the trace.
    pub fn play(&mut self, script: &str) -> Result<(), Mismatch> {
        for line in script.lines() {
            let line = line.split('#').next().unwrap_or_default().trim();
            if !line.is_empty() {
                let turn = turn(line).ok_or_else(|| Mismatch(format!("'{line}' is no line of a dialogue")))?;
                self.turn(&turn).map_err(|what| Mismatch(format!("{line}\n{what}\n{}", self.bus.trace())))?;
            }
        }
        Ok(())
    }

    fn turn(&mut self, turn: &Step) -> Result<(), String> {
        match turn {
            Step::Send(when, octets) => self.send(when, octets),
            Step::Expect(window, octets) => self.expect(window, octets),
            Step::Nothing(tbit) => self.nothing(*tbit),
        }
    }

    /// Sends `octets` after `idle_tbit` without anybody speaking, and returns the answer that begins within the slot time
    /// after it, if one does.
    ///
    /// # Errors
    /// [`Mismatch`] when the station broke a rule or spoke out of turn.
    pub fn ask(&mut self, idle_tbit: u64, octets: &[u8]) -> Result<Option<Vec<u8>>, Mismatch> {
        let slot = u64::from(self.bus.baud().default_slot_tbit());
        let asked = self.send(&SendTime::After(idle_tbit), octets).and_then(|()| self.answer(slot));
        let answer = asked.map_err(|what| Mismatch(format!("{}\n{what}\n{}", Hex(octets), self.bus.trace())))?;
        Ok(answer.map(|(_, octets)| octets))
    }

    fn send(&mut self, when: &SendTime, octets: &[u8]) -> Result<(), String> {
        let begin = match when {
            SendTime::After(tbit) => (self.end + *tbit).max(self.bus.now()),
            SendTime::At(time) => *time,
        };
        self.bus.station_mut(self.tester).send(begin, octets);
        self.run(begin)?;
        if self.bus.trace().entries.len() != self.seen + 1 {
            return Err("something else was said before".to_owned());
        }
        self.seen += 1;
        self.end = begin + octets.len() as u64 * CHARACTER_TBIT;
        self.run(self.end)
    }

    fn expect(&mut self, window: &RangeInclusive<u64>, expected: &[Option<u8>]) -> Result<(), String> {
        let Some((tsdr, octets)) = self.answer(*window.end())? else {
            return Err(format!("nothing came within {} bit times", window.end()));
        };
        if !window.contains(&tsdr) {
            return Err(format!("it began {tsdr} bit times after the last telegram"));
        }
        let matches = octets.len() == expected.len()
            && octets.iter().zip(expected).all(|(octet, expected)| expected.is_none_or(|expected| expected == *octet));
        if matches { Ok(()) } else { Err(format!("this came instead: {}", Hex(&octets))) }
    }

    fn nothing(&mut self, tbit: u64) -> Result<(), String> {
        match self.answer(tbit)? {
            Some((tsdr, octets)) => Err(format!("this came after {tsdr} bit times: {}", Hex(&octets))),
            None => Ok(()),
        }
    }

    /// What begins within so many bit times after the last telegram, and after how many.
    fn answer(&mut self, within_tbit: u64) -> Result<Option<(u64, Vec<u8>)>, String> {
        self.run(self.end + within_tbit)?;
        let Some(entry) = self.bus.trace().entries.get(self.seen).cloned() else { return Ok(None) };
        let tsdr = entry.start - self.end;
        self.seen += 1;
        self.end = entry.end();
        self.run(self.end)?;
        Ok(Some((tsdr, entry.octets.to_vec())))
    }

    fn run(&mut self, until: BitTime) -> Result<(), String> {
        self.bus.run_until(until).map_err(|foul| foul.to_string())
    }
}

/// Reads `TIME -> OCTETS`, `WINDOW <- OCTETS` or `TIME <- nothing`.
fn turn(line: &str) -> Option<Step> {
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

    /// Says SC after 20 bit times, whatever it hears.
    fn dialogue() -> Dialogue<impl Station + Send + 'static> {
        Dialogue::new(Baud::B1500000, MockStation::new(|end, _| Some((end + 20, vec![0xE5]))))
    }

    fn mismatch(script: &str) -> String {
        dialogue().play(script).unwrap_err().to_string()
    }

    #[test]
    fn a_dialogue_that_is_met_is_met() {
        let script = "
            +40 -> 10 08 02 49 53 16
            20 <- E5
            +40 -> 10 08 02 49 53 16  # a remark
            11..60 <- ..
            500 <- nothing
            @2000 -> 10 08 02 49 53 16
            0..20 <- E5
        ";
        assert_eq!(dialogue().play(script), Ok(()));
    }

    #[test]
    fn whatever_is_not_met_is_told() {
        for (line, told) in [
            ("21..60 <- E5", "21..60 <- E5\nit began 20 bit times after the last telegram\n"),
            ("11..19 <- E5", "11..19 <- E5\nnothing came within 19 bit times\n"),
            ("20 <- E6", "20 <- E6\nthis came instead: E5\n"),
            ("20 <- E5 E5", "this came instead: E5\n"),
            ("20 <- nothing", "this came after 20 bit times: E5\n"),
            ("+40 -> E5", "something else was said before\n"),
            ("soon -> E5", "'soon -> E5' is no line of a dialogue"),
            ("+40 E5", "'+40 E5' is no line of a dialogue"),
            ("+40 -> 5X", "'+40 -> 5X' is no line of a dialogue"),
        ] {
            let message = mismatch(&format!("+40 -> 10 08 02 49 53 16\n{line}"));
            assert!(message.contains(told), "{line}: {message}");
        }
    }

    #[test]
    fn a_mismatch_shows_the_trace() {
        assert!(mismatch("+40 -> 10 08 02 49 53 16\n20 <- E6").contains("FDL_Status ?"));
    }

    #[test]
    fn a_broken_rule_is_a_mismatch() {
        let mut dialogue = Dialogue::new(Baud::B1500000, MockStation::new(|end, _| Some((end + 10, vec![0xE5]))));
        let error = dialogue.play("+40 -> 10 08 02 49 53 16\n10 <- E5").unwrap_err();
        assert!(error.to_string().contains("it answered after 10 bit times, min T_SDR is 11"), "{error}");
    }
}
