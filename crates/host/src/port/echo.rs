//! Removes the echo of sent octets that some RS-485 adapters return. profibus-wire 9.4, point 37.
//!
//! The filter detects the echo by itself: it holds octets back as long as they equal those just sent. No other station can
//! send the same telegram next, so the first octet that differs proves that there is no echo, and the held octets are
//! released. An SC is an exception: another station may send one too. So its echo is expected only of an adapter that has returned
//! the telegram before it.

use super::Character;
use std::collections::VecDeque;

/// The longest expected echo. Older octets were not echoed.
const CAPACITY: usize = 1024;

/// Short acknowledgement. profibus-wire 1.2.
const SC: u8 = 0xE5;

/// Filters the echo of sent octets.
#[derive(Clone, Debug, Default)]
pub struct Echo {
    expected: VecDeque<u8>,
    held: Vec<Character>,
    /// The last octets that were sent came back.
    is_returned: bool,
}

impl Echo {
    /// Registers octets that were sent.
    pub fn sent(&mut self, octets: &[u8]) {
        if self.expected.len() > CAPACITY {
            self.expected.clear();
        }
        if octets == [SC] && !self.is_returned {
            return;
        }
        self.expected.extend(octets);
    }

    /// Appends `character` to `characters` unless it is an echo.
    pub fn filter(&mut self, character: Character, characters: &mut Vec<Character>) {
        match (self.expected.front(), character) {
            (Some(expected), Character::Octet(octet)) if *expected == octet => {
                self.expected.pop_front();
                self.held.push(character);
                if self.expected.is_empty() {
                    self.held.clear();
                    self.is_returned = true;
                }
            }
            (expected, _) => {
                self.is_returned &= expected.is_none();
                self.expected.clear();
                characters.append(&mut self.held);
                characters.push(character);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filtered(echo: &mut Echo, octets: &[u8]) -> Vec<u8> {
        let mut characters = Vec::new();
        octets.iter().for_each(|octet| echo.filter(Character::Octet(*octet), &mut characters));
        let octet = |character: &Character| match character {
            Character::Octet(octet) => *octet,
            Character::Error => panic!("nothing is broken here"),
        };
        characters.iter().map(octet).collect()
    }

    const ANSWER: [u8; 6] = [0x10, 2, 8, 0, 0x0A, 0x16];
    const REQUEST: [u8; 6] = [0x10, 8, 2, 0x49, 0x53, 0x16];

    /// profibus-wire 9.4, point 37
    #[test]
    fn an_echo_is_removed_and_the_octets_behind_it_are_received() {
        let mut echo = Echo::default();
        echo.sent(&ANSWER);
        assert_eq!(filtered(&mut echo, &[ANSWER, REQUEST].concat()), REQUEST);
        echo.sent(&ANSWER);
        assert_eq!(filtered(&mut echo, &ANSWER), []);
    }

    #[test]
    fn without_an_echo_nothing_is_lost() {
        let mut echo = Echo::default();
        echo.sent(&ANSWER);
        assert_eq!(filtered(&mut echo, &REQUEST), REQUEST);
        assert_eq!(filtered(&mut echo, &ANSWER), ANSWER);
    }

    const SC: [u8; 1] = [0xE5];

    #[test]
    fn an_sc_of_another_station_is_no_echo_of_an_sc_that_was_sent_without_one() {
        let mut echo = Echo::default();
        echo.sent(&SC);
        echo.sent(&REQUEST);
        assert_eq!(filtered(&mut echo, &SC), SC);
        echo.sent(&SC);
        assert_eq!(filtered(&mut echo, &SC), SC);
    }

    #[test]
    fn the_echo_of_an_sc_is_removed_on_an_adapter_that_has_returned_a_telegram() {
        let mut echo = Echo::default();
        echo.sent(&REQUEST);
        assert_eq!(filtered(&mut echo, &[&REQUEST[..], &ANSWER[..]].concat()), ANSWER);
        echo.sent(&SC);
        assert_eq!(filtered(&mut echo, &[&SC[..], &REQUEST[..]].concat()), REQUEST);
        echo.sent(&ANSWER);
        assert_eq!(filtered(&mut echo, &[&ANSWER[..], &SC[..]].concat()), SC);
    }

    #[test]
    fn a_damaged_echo_is_received() {
        let mut echo = Echo::default();
        echo.sent(&ANSWER);
        let mut characters = Vec::new();
        echo.filter(Character::Octet(0x10), &mut characters);
        echo.filter(Character::Error, &mut characters);
        assert_eq!(characters, [Character::Octet(0x10), Character::Error]);
    }
}
