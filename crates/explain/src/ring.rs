//! The token ring: the masters that pass the token to each other.

use super::note::{Kind, Notes};
use std::collections::BTreeMap;

/// The token ring as the tokens show it.
#[derive(Clone, Debug, Default)]
pub struct Ring {
    /// The station to which each master passed the token last.
    next: BTreeMap<u8, u8>,
    /// The ring of the last note, beginning with the lowest address.
    reported: Vec<u8>,
}

impl Ring {
    /// Records a token, and adds a note when the ring has changed.
    pub fn token(&mut self, from: u8, to: u8, notes: &mut Notes<'_>) {
        if self.next.insert(from, to) == Some(to) && self.reported.contains(&from) {
            return;
        }
        let Some(ring) = self.ring(from) else { return };
        if ring == self.reported {
            return;
        }
        let entered = ring.iter().filter(|station| !self.reported.contains(station));
        let left = self.reported.iter().filter(|station| !ring.contains(station));
        let changes: Vec<String> = match self.reported[..] {
            [] => Vec::new(),
            _ => entered
                .map(|station| format!("{station} has entered"))
                .chain(left.map(|station| format!("{station} has left")))
                .collect(),
        };
        let changes = if changes.is_empty() { String::new() } else { format!(" ({})", changes.join(", ")) };
        let text = match ring[..] {
            [alone] => format!("master {alone} is alone in the token ring{changes}"),
            _ => format!("token ring: {}{changes}", path(&ring)),
        };
        notes.add(None, Kind::Ring, text);
        self.next.retain(|station, _| ring.contains(station));
        self.reported = ring;
    }

    /// The masters from `start` back to `start`, if the ring closes.
    fn ring(&self, start: u8) -> Option<Vec<u8>> {
        let mut ring = vec![start];
        let mut here = *self.next.get(&start)?;
        while here != start {
            if ring.contains(&here) {
                return None;
            }
            ring.push(here);
            here = *self.next.get(&here)?;
        }
        let lowest = ring.iter().enumerate().min_by_key(|(_, station)| **station).map(|(index, _)| index)?;
        ring.rotate_left(lowest);
        Some(ring)
    }
}

fn path(ring: &[u8]) -> String {
    let stations = ring.iter().chain(ring.first()).map(ToString::to_string);
    stations.collect::<Vec<_>>().join(" -> ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn notes_about(tokens: &[(u8, u8)]) -> Vec<String> {
        let (mut ring, mut list) = (Ring::default(), Vec::new());
        for (from, to) in tokens {
            ring.token(*from, *to, &mut Notes { at: None, number: 1, list: &mut list });
        }
        list.into_iter().map(|note| note.text).collect()
    }

    #[test]
    fn the_ring_adds_a_note_when_it_closes_and_when_it_changes() {
        let tokens = [(2, 2), (2, 2), (2, 5), (5, 2), (2, 5), (5, 9), (9, 2), (2, 5), (5, 9), (9, 2), (2, 9), (9, 2)];
        let expected = [
            "master 2 is alone in the token ring",
            "token ring: 2 -> 5 -> 2 (5 has entered)",
            "token ring: 2 -> 5 -> 9 -> 2 (9 has entered)",
            "token ring: 2 -> 9 -> 2 (5 has left)",
        ];
        assert_eq!(notes_about(&tokens), expected);
    }

    #[test]
    fn an_open_chain_of_tokens_adds_no_note() {
        assert_eq!(notes_about(&[(2, 5), (5, 7)]), [""; 0]);
    }
}
