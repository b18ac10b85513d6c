//! Detects the baud rate of a line by listening; sends nothing. profibus-wire 3.7.
//!
//! [`RateControl`] decides how long to listen and which telegrams prove a rate, as it does for a slave.

use crate::clock::duration_of;
use crate::port::{Character, Port, PortClock, PortError, wait_for_port};
use profivac_dp::link::{Baud, BitTime, Rate, RateControl, Received, Receiver};
use profivac_wire::BROADCAST;
use std::time::Duration;

/// The order of the rates. chosen: first those common in plants with gauges, last those that few adapters support.
const SEARCH_ORDER: [Baud; 10] = [
    Baud::B1500000,
    Baud::B500000,
    Baud::B187500,
    Baud::B93750,
    Baud::B19200,
    Baud::B9600,
    Baud::B45450,
    Baud::B3000000,
    Baud::B6000000,
    Baud::B12000000,
];

/// Listens at one rate after the other until a telegram arrives, each rate once. The port stays at the detected rate.
///
/// # Errors
/// [`PortError::NoBaudRate`] for a port without a rate; [`PortError::NoTelegram`] with the rates tried.
pub fn detect(port: &mut dyn Port) -> Result<Baud, PortError> {
    let mut tried = Vec::new();
    for baud in SEARCH_ORDER {
        match port.set_baud(baud) {
            // An adapter that does not support a rate cannot be on a line with this rate.
            Err(PortError::UnsupportedRate { .. }) => continue,
            done => done?,
        }
        if carries_telegrams(port, baud)? {
            return Ok(baud);
        }
        tried.push(baud);
    }
    Err(PortError::NoTelegram { name: port.name().to_owned(), tried })
}

/// Whether the line carries telegrams at `baud`.
fn carries_telegrams(port: &mut dyn Port, baud: Baud) -> Result<bool, PortError> {
    let mut control = searching(baud);
    let mut receiver = Receiver::with_idle(BitTime(0), port.delivery().idle_tbit(baud));
    let clock = PortClock::starting_at(BitTime(0), baud, port);
    let mut characters = Vec::new();
    loop {
        let left = control.wake_at().map_or(Duration::ZERO, |until| duration_of(baud, until - clock.now(port)));
        wait_for_port(port, &[], left)?;
        port.receive(&mut characters)?;
        let now = clock.now(port);
        for character in characters.drain(..) {
            if is_proof(&mut receiver, &mut control, now, character) {
                return Ok(true);
            }
        }
        // Only now: a program that was not run for a while has characters in the port.
        if left.is_zero() {
            return Ok(false);
        }
    }
}

/// Whether a character completes a telegram that proves the rate.
fn is_proof(receiver: &mut Receiver, control: &mut RateControl, now: BitTime, character: Character) -> bool {
    match character {
        Character::Octet(octet) => match receiver.octet(now, octet) {
            Received::Telegram(telegram) => control.telegram_received(now, &telegram, BROADCAST),
            Received::Nothing | Received::Damaged(_) => false,
        },
        Character::Error => {
            receiver.character_error(now);
            false
        }
    }
}

/// A rate control that has arrived at `baud`.
fn searching(baud: Baud) -> RateControl {
    let mut control = RateControl::automatic(BitTime(0));
    while control.rate() != Rate::Searching(baud)
        && let Some(until) = control.wake_at()
    {
        control.elapse(until, false);
    }
    control
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::port::SCHEDULING_DELAY;
    use crate::readiness::Readiness;
    use std::io::Write;
    use std::os::unix::net::UnixStream;
    use std::time::Instant;

    const REQUEST: [u8; 6] = [0x10, 8, 2, 0x49, 0x53, 0x16];
    const TOKENS: [u8; 6] = [0xDC, 2, 2, 0xE5, 0xDC, 2];

    /// What a receiver gets at a wrong rate.
    #[derive(Clone, Copy)]
    enum Otherwise {
        /// Characters with errors.
        Errors,
        /// Octets without any error, among them the beginnings of telegrams, short acknowledgements and tokens.
        Garbage,
    }

    /// A line with the same telegram repeatedly, and an adapter with certain rates.
    struct Bus {
        offered: &'static [Baud],
        carried: Option<(Baud, [u8; 6])>,
        otherwise: Otherwise,
        /// The number of telegrams that the line would have carried before it begins to.
        silent_for: u32,
        set: Vec<Baud>,
        last: Instant,
        /// Readable if the line carries telegrams.
        ours: UnixStream,
        _theirs: UnixStream,
    }

    impl Bus {
        fn new(offered: &'static [Baud], carried: Option<(Baud, [u8; 6])>) -> Self {
            let (ours, mut theirs) = UnixStream::pair().unwrap();
            if carried.is_some() {
                theirs.write_all(&[0]).unwrap();
            }
            let (otherwise, silent_for) = (Otherwise::Errors, 0);
            Self {
                offered,
                carried,
                otherwise,
                silent_for,
                set: Vec::new(),
                last: Instant::now(),
                ours,
                _theirs: theirs,
            }
        }

        fn character(&self, baud: Baud, octet: u8) -> Character {
            match self.otherwise {
                _ if self.set.last() == Some(&baud) => Character::Octet(octet),
                Otherwise::Errors => Character::Error,
                Otherwise::Garbage => Character::Octet([0x68, 0xE5, 0xDC, 0x10, 0x00, 0x16][usize::from(octet % 6)]),
            }
        }
    }

    impl Port for Bus {
        fn name(&self) -> &str {
            "bus"
        }

        fn readiness(&self) -> Vec<Readiness<'_>> {
            vec![Readiness::of(&self.ours)]
        }

        fn receive(&mut self, heard: &mut Vec<Character>) -> Result<(), PortError> {
            // Telegrams have pauses between them.
            if let Some((baud, octets)) = self.carried
                && self.last.elapsed() > SCHEDULING_DELAY * 4
            {
                self.last = Instant::now();
                self.silent_for = self.silent_for.saturating_sub(1);
                if self.silent_for == 0 {
                    heard.extend(octets.map(|octet| self.character(baud, octet)));
                }
            }
            Ok(())
        }

        fn send(&mut self, _octets: &[u8]) -> Result<(), PortError> {
            panic!("detection sends nothing");
        }

        fn set_baud(&mut self, baud: Baud) -> Result<(), PortError> {
            if !self.offered.contains(&baud) {
                return Err(PortError::UnsupportedRate { name: "bus".to_owned(), baud, offered: None });
            }
            self.set.push(baud);
            Ok(())
        }
    }

    /// Each rate of the list behind the one before it, at which the line is errors or garbage.
    #[test]
    fn every_rate_of_the_list_is_detected_and_a_wrong_one_before_it_is_not_kept() {
        static ORDER: [Baud; 10] = SEARCH_ORDER;
        let search = |rates: &'static [Baud], otherwise| {
            let baud = *rates.last().unwrap();
            let mut bus = Bus { otherwise, ..Bus::new(rates, Some((baud, REQUEST))) };
            assert_eq!(detect(&mut bus).unwrap(), baud);
            assert_eq!(bus.set, rates, "the port stays at the rate");
        };
        search(&ORDER[..1], Otherwise::Errors);
        std::thread::scope(|scope| {
            for otherwise in [Otherwise::Errors, Otherwise::Garbage] {
                scope.spawn(move || ORDER.windows(2).for_each(|rates| search(rates, otherwise)));
            }
        });
    }

    #[test]
    fn traffic_that_starts_late_is_found_by_the_next_search() {
        const RATES: &[Baud] = &[Baud::B500000, Baud::B19200];
        // A line that is silent for longer than a search, however slow this computer is.
        let mut bus = Bus { silent_for: u32::MAX, ..Bus::new(RATES, Some((Baud::B500000, REQUEST))) };
        assert!(matches!(detect(&mut bus), Err(PortError::NoTelegram { tried, .. }) if tried == RATES));
        bus.silent_for = 1;
        assert_eq!(detect(&mut bus).unwrap(), Baud::B500000, "the rate at which the first search ended is not kept");
    }

    /// A port that holds a telegram when its receiver is called for the second time, and reports nothing before.
    struct Late {
        calls: u32,
        ours: UnixStream,
        _theirs: UnixStream,
    }

    impl Port for Late {
        fn name(&self) -> &str {
            "late"
        }

        fn readiness(&self) -> Vec<Readiness<'_>> {
            vec![Readiness::of(&self.ours)]
        }

        fn receive(&mut self, heard: &mut Vec<Character>) -> Result<(), PortError> {
            self.calls += 1;
            if self.calls == 2 {
                heard.extend(REQUEST.map(Character::Octet));
            }
            Ok(())
        }

        fn send(&mut self, _octets: &[u8]) -> Result<(), PortError> {
            panic!("detection sends nothing");
        }

        fn set_baud(&mut self, _baud: Baud) -> Result<(), PortError> {
            Ok(())
        }
    }

    #[test]
    fn characters_that_the_port_holds_when_the_time_of_a_rate_is_over_count() {
        let (ours, theirs) = UnixStream::pair().unwrap();
        let mut port = Late { calls: 0, ours, _theirs: theirs };
        assert_eq!(detect(&mut port).unwrap(), SEARCH_ORDER[0]);
    }

    #[test]
    fn the_rate_at_which_telegrams_arrive_is_detected() {
        let mut bus = Bus::new(&[Baud::B500000, Baud::B93750, Baud::B19200], Some((Baud::B93750, REQUEST)));
        assert_eq!(detect(&mut bus).unwrap(), Baud::B93750);
        assert_eq!(
            bus.set,
            [Baud::B500000, Baud::B93750],
            "what the adapter cannot is left out, and the rest not tried"
        );
    }

    #[test]
    fn a_silent_line_is_an_error_that_names_the_rates_tried() {
        let refused = detect(&mut Bus::new(&[Baud::B1500000, Baud::B500000], None)).unwrap_err().to_string();
        assert!(refused.starts_with("no telegram on bus at any of 1500000, 500000 bit/s"), "{refused}");
    }

    #[test]
    fn tokens_prove_no_rate() {
        let refused = detect(&mut Bus::new(&[Baud::B1500000], Some((Baud::B1500000, TOKENS))));
        assert!(matches!(refused, Err(PortError::NoTelegram { .. })), "{refused:?}");
    }

    #[test]
    fn every_rate_is_tried_once() {
        let mut sorted = SEARCH_ORDER;
        sorted.sort();
        assert_eq!(sorted, Baud::ALL);
        assert!(SEARCH_ORDER.into_iter().all(|baud| searching(baud).rate() == Rate::Searching(baud)));
    }
}
