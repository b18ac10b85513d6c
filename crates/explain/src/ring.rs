//! Who is in the token ring: each passes the token to the next.

use super::note::{Kind, Notes};
use std::collections::BTreeMap;

/// The ring, as the tokens show it.
#[derive(Clone, Debug, Default)]
pub struct Ring {
    /// To whom each station passed the token last.
    next: BTreeMap<u8, u8>,
    /// The ring that was told, beginning with the lowest address.
    reported: Vec<u8>,
}

impl Ring {
    /// A token was passed.
    pub fn token(&mut self, from: u8, to: u8, notes: &mut Notes<'_>) {
        if self.next.insert(from, to) == Some(to) && self.reported.contains(&from) {
            return;
        }
        let Some(ring) = self.ring(from) else { return };
        if ring == self.reported {
            return;
        }
        let came = ring.iter().filter(|station| !self.reported.contains(station));
        let left = self.reported.iter().filter(|station| !ring.contains(station));
        let changes: Vec<String> = match self.reported[..] {
            [] => Vec::new(),
            _ => {
                came.map(|who| format!("{who} has entered")).chain(left.map(|who| format!("{who} has left"))).collect()
            }
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

    /// The stations from `start` back to it, if the ring closes.
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
        let lowest = ring.iter().enumerate().min_by_key(|(_, station)| **station).map(|(place, _)| place)?;
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

    fn told(tokens: &[(u8, u8)]) -> Vec<String> {
        let (mut ring, mut list) = (Ring::default(), Vec::new());
        for (from, to) in tokens {
            ring.token(*from, *to, &mut Notes { at: None, number: 1, list: &mut list });
        }
        list.into_iter().map(|note| note.text).collect()
    }

    #[test]
    fn a_ring_is_told_when_it_closes_and_when_it_changes() {
        let tokens = [(2, 2), (2, 2), (2, 5), (5, 2), (2, 5), (5, 9), (9, 2), (2, 5), (5, 9), (9, 2), (2, 9), (9, 2)];
        let expected = [
            "master 2 is alone in the token ring",
            "token ring: 2 -> 5 -> 2 (5 has entered)",
            "token ring: 2 -> 5 -> 9 -> 2 (9 has entered)",
            "token ring: 2 -> 9 -> 2 (5 has left)",
        ];
        assert_eq!(told(&tokens), expected);
    }

    #[test]
    fn a_ring_that_was_not_seen_to_close_is_not_told() {
        assert_eq!(told(&[(2, 5), (5, 7)]), [""; 0]);
    }
}
