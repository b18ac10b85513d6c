//! Loops: sentences of one station that repeat in the same order are printed once and counted.

use profivac_explain::note::{Kind, Note};
use std::collections::BTreeMap;

/// The longest loop that is found. chosen: a start-up that does not end has three sentences; twice as many leave room for others.
const LONGEST: usize = 6;

/// The sentences of each station that were printed last, and the loops that run.
#[derive(Debug, Default)]
pub struct Repeats {
    stations: BTreeMap<Option<u8>, Station>,
}

#[derive(Debug, Default)]
struct Station {
    /// The last sentences, at most twice the longest loop.
    last: Vec<(Kind, String)>,
    /// The loop that runs.
    cycle: Option<Cycle>,
}

/// A loop: its last sentences are the same as those before them.
#[derive(Debug)]
struct Cycle {
    length: usize,
    /// The sentences that followed in their order.
    repeated: u64,
}

/// What becomes of a sentence.
#[derive(Debug, PartialEq, Eq)]
pub enum Shown {
    /// It is printed, behind the end of a loop if there was one.
    Print { ended: Option<String> },
    /// It begins the second repetition: this is printed in its place.
    Begin(String),
    /// It is counted.
    Count,
}

impl Repeats {
    /// Takes the next sentence.
    pub fn next(&mut self, note: &Note) -> Shown {
        self.stations.entry(note.station).or_default().next((note.kind, note.text.clone()))
    }

    /// The loops that have not ended, each with its station and its number of repetitions.
    pub fn running(&self) -> impl Iterator<Item = (Option<u8>, String)> {
        self.stations.iter().filter_map(|(station, it)| Some((*station, it.count()?)))
    }
}

impl Station {
    fn next(&mut self, note: (Kind, String)) -> Shown {
        if let Some(cycle) = &mut self.cycle {
            let at = self.last.len().checked_sub(cycle.length);
            if at.and_then(|at| self.last.get(at)) == Some(&note) {
                cycle.repeated = cycle.repeated.saturating_add(1);
                // The loop goes round: its first sentence becomes its last.
                self.keep(note);
                return Shown::Count;
            }
            let ended = self.count();
            self.cycle = None;
            self.last.clear();
            self.keep(note);
            return Shown::Print { ended };
        }
        let Some(length) = self.loop_with(&note) else {
            self.keep(note);
            return Shown::Print { ended: None };
        };
        self.keep(note);
        self.cycle = Some(Cycle { length, repeated: 1 });
        Shown::Begin(format!(
            "{} again and again; further repetitions are counted{}",
            sentences(length),
            self.missing(length)
        ))
    }

    /// The length of the loop that the sentences have shown twice and that `note` continues.
    fn loop_with(&self, note: &(Kind, String)) -> Option<usize> {
        (1..=LONGEST).find(|length| {
            let tail = self.last.len().checked_sub(2 * length).and_then(|from| self.last.get(from..));
            tail.and_then(|tail| tail.split_at_checked(*length))
                .is_some_and(|(before, after)| before == after && after.first() == Some(note))
        })
    }

    fn keep(&mut self, note: (Kind, String)) {
        if self.last.len() >= 2 * LONGEST {
            self.last.remove(0);
        }
        self.last.push(note);
    }

    /// What a loop of start-up sentences lacks.
    fn missing(&self, length: usize) -> &'static str {
        let from = self.last.len().saturating_sub(length);
        let looped = self.last.get(from..).unwrap_or_default();
        let is_start_up = looped.iter().any(|(_, text)| text.contains("ready for data exchange"));
        let exchanges = looped.iter().any(|(kind, _)| *kind == Kind::Exchange);
        if is_start_up && !exchanges { ": parameterised and configured, but no Data_Exchange follows" } else { "" }
    }

    fn count(&self) -> Option<String> {
        let Cycle { length, repeated } = self.cycle.as_ref()?;
        // Two rounds were printed before the loop was noticed.
        let rounds = (repeated / *length as u64).saturating_add(2);
        Some(format!("{} {rounds} times{}", sentences(*length), self.missing(*length)))
    }
}

fn sentences(count: usize) -> String {
    if count == 1 { "the last sentence".to_owned() } else { format!("the last {count} sentences") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn note(station: u8, kind: Kind, text: &str) -> Note {
        Note { at: None, number: 1, station: Some(station), kind, text: text.to_owned() }
    }

    #[test]
    fn a_loop_is_said_once_and_counted_and_says_that_no_data_exchange_follows() {
        let start = [
            "takes parameters",
            "takes a configuration",
            "has taken parameters and configuration: ready for data exchange",
        ];
        let mut repeats = Repeats::default();
        let mut shown = Vec::new();
        for _ in 0..65 {
            shown.extend(start.map(|text| repeats.next(&note(5, Kind::StartUp, text))));
        }
        let printed = shown.iter().filter(|it| matches!(it, Shown::Print { .. })).count();
        let begun: Vec<_> = shown.iter().filter(|it| matches!(it, Shown::Begin(_))).collect();
        assert_eq!((printed, begun.len(), shown.len()), (6, 1, 195));
        let sentence = begun.iter().find_map(|it| if let Shown::Begin(text) = it { Some(text.as_str()) } else { None });
        let sentence = sentence.unwrap_or_default();
        assert!(sentence.ends_with(": parameterised and configured, but no Data_Exchange follows"), "{sentence}");
        let running: Vec<_> = repeats.running().collect();
        assert_eq!(running.len(), 1);
        assert!(
            running.iter().all(|(station, text)| *station == Some(5) && text.contains("3 sentences 65 times")),
            "{running:?}"
        );
        let after = repeats.next(&note(5, Kind::Exchange, "exchanges data"));
        assert!(matches!(&after, Shown::Print { ended: Some(text) } if text.contains("65 times")), "{after:?}");
        assert_eq!(repeats.running().count(), 0);
    }

    #[test]
    fn another_station_does_not_end_a_loop_and_different_sentences_are_none() {
        let mut repeats = Repeats::default();
        for round in 0..5 {
            let one = repeats.next(&note(5, Kind::Diagnosis, "reports a fault"));
            assert_eq!(matches!(one, Shown::Print { .. }), round < 2, "{round}");
            let two = repeats.next(&note(6, Kind::Diagnosis, &format!("reports {round}")));
            assert_eq!(two, Shown::Print { ended: None });
        }
    }

    #[test]
    fn a_loop_without_a_start_up_makes_no_claim_about_data_exchange() {
        let mut repeats = Repeats::default();
        let shown: Vec<_> = (0..3).map(|_| repeats.next(&note(5, Kind::Diagnosis, "reports a fault"))).collect();
        let expected = "the last sentence again and again; further repetitions are counted";
        assert_eq!(shown.last(), Some(&Shown::Begin(expected.to_owned())));
    }
}
