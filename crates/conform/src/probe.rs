//! A station that says whatever it is told to, also what no master would say, and writes down what comes back.
//!
//! It takes the line like a master that is alone (profibus-wire 1.13) and needs it for itself: a damaged request in the
//! middle of somebody's token rotation would prove nothing and disturb everybody.

use profivac_dp::link::active::BusParameters;
use profivac_dp::link::{BitTime, CHARACTER_TBIT, Station, Transmit};
use profivac_wire::control::Control;
use profivac_wire::{BROADCAST, MAX_TELEGRAM, Telegram};

/// What came back.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Received {
    /// Nothing within the slot time.
    Nothing,
    /// Octets that are no telegram.
    Damaged,
    /// A telegram.
    Telegram(Vec<u8>),
}

/// Where the station stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// It has nothing to say.
    Idle,
    /// It speaks when the line has been idle for so long.
    Ready { idle_tbit: u64 },
    /// It speaks.
    Sending,
    /// Somebody may answer.
    Waiting { until: BitTime },
}

/// The station.
#[derive(Debug)]
pub struct Probe {
    bus: BusParameters,
    state: State,
    busy: BitTime,
    octets: Vec<u8>,
    heard: Received,
    other: Option<u8>,
}

impl Probe {
    /// A station that listens.
    #[must_use]
    pub const fn new(bus: BusParameters, now: BitTime) -> Self {
        let octets = Vec::new();
        Self { bus, state: State::Idle, busy: now, octets, heard: Received::Nothing, other: None }
    }

    /// The address it has as a master.
    #[must_use]
    pub const fn address(&self) -> u8 {
        self.bus.address
    }

    /// Another master that was heard.
    #[must_use]
    pub const fn other_master(&self) -> Option<u8> {
        self.other
    }

    /// How long the line must be silent before a master may claim it, in bit times.
    #[must_use]
    pub fn timeout_tbit(&self) -> u64 {
        self.bus.timeout_tbit()
    }

    /// Says `octets` as soon as the line has been idle for T_ID2, or T_ID1 if that is longer.
    pub fn send(&mut self, octets: &[u8]) {
        self.octets = octets.iter().take(MAX_TELEGRAM).copied().collect();
        self.heard = Received::Nothing;
        self.state = State::Ready { idle_tbit: self.bus.id1_tbit().max(self.bus.id2_tbit()) };
    }

    /// What came back, once that is known.
    #[must_use]
    pub fn received(&self) -> Option<&Received> {
        (self.state == State::Idle).then_some(&self.heard)
    }

    fn slot_tbit(&self) -> u64 {
        u64::from(self.bus.slot_tbit)
    }
}

impl Station for Probe {
    fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
        self.busy = self.busy.max(end);
        self.other = sending_master(telegram).or(self.other);
        if matches!(self.state, State::Sending | State::Waiting { .. }) {
            let mut octets = [0; MAX_TELEGRAM];
            let length = telegram.emit(&mut octets).unwrap_or_default();
            self.heard = Received::Telegram(octets.iter().take(length).copied().collect());
            self.state = State::Idle;
        }
        None
    }

    fn activity(&mut self, end: BitTime) {
        self.busy = self.busy.max(end);
        if let State::Waiting { until } = &mut self.state {
            self.heard = Received::Damaged;
            // A telegram that has begun is heard to its end.
            *until = end + u64::from(self.bus.slot_tbit) + CHARACTER_TBIT;
        }
    }

    fn sent(&mut self, end: BitTime) {
        self.busy = self.busy.max(end);
        if self.state == State::Sending {
            self.state = State::Waiting { until: end + self.slot_tbit() };
        }
    }

    fn poll(&mut self, now: BitTime) -> Option<Transmit<'_>> {
        let due = self.wake_at().filter(|due| *due <= now)?;
        match self.state {
            State::Ready { .. } => {
                self.state = State::Sending;
                Some(Transmit { not_before: due, octets: &self.octets })
            }
            State::Waiting { .. } => {
                self.state = State::Idle;
                None
            }
            State::Idle | State::Sending => None,
        }
    }

    fn wake_at(&self) -> Option<BitTime> {
        match self.state {
            State::Ready { idle_tbit } => Some(self.busy + idle_tbit),
            State::Waiting { until } => Some(until),
            State::Idle | State::Sending => None,
        }
    }
}

/// The master that only can have sent `telegram`.
fn sending_master(telegram: &Telegram<'_>) -> Option<u8> {
    match telegram {
        Telegram::Token { da, sa } if *da < BROADCAST && *sa < BROADCAST => Some(*sa),
        Telegram::Data(frame) if matches!(frame.control(), Control::Request { .. }) => Some(frame.sa),
        Telegram::Token { .. } | Telegram::Data(_) | Telegram::ShortAck => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_dp::link::Baud;

    const REQUEST: [u8; 6] = [0x10, 8, 2, 0x49, 0x53, 0x16];

    fn probe() -> Probe {
        Probe::new(BusParameters::new(2, Baud::B19200), BitTime(0))
    }

    /// Says the request; returns when it has left.
    fn say(probe: &mut Probe) -> BitTime {
        probe.send(&REQUEST);
        let due = probe.wake_at().unwrap();
        assert_eq!(probe.poll(due).map(|transmit| transmit.octets.to_vec()), Some(REQUEST.to_vec()));
        probe.sent(due + 66);
        due + 66
    }

    #[test]
    fn silence_is_known_after_the_slot_time() {
        let mut probe = probe();
        let sent = say(&mut probe);
        assert_eq!((probe.received(), probe.wake_at()), (None, Some(sent + 100)));
        assert_eq!(probe.poll(sent + 100), None);
        assert_eq!(probe.received(), Some(&Received::Nothing));
    }

    #[test]
    fn an_answer_is_kept_octet_by_octet() {
        let mut probe = probe();
        let sent = say(&mut probe);
        probe.activity(sent + 22);
        let answer = [0x10, 2, 8, 0, 0x0A, 0x16];
        probe.telegram(sent + 77, &Telegram::parse(&answer).unwrap());
        assert_eq!(probe.received(), Some(&Received::Telegram(answer.to_vec())));
        assert_eq!(probe.other_master(), None);
    }

    #[test]
    fn octets_without_a_telegram_are_damaged() {
        let mut probe = probe();
        let sent = say(&mut probe);
        probe.activity(sent + 22);
        let end = probe.wake_at().unwrap();
        assert_eq!(end, sent + 22 + 111);
        probe.poll(end);
        assert_eq!(probe.received(), Some(&Received::Damaged));
    }

    #[test]
    fn another_master_is_noticed() {
        let mut probe = probe();
        probe.telegram(BitTime(50), &Telegram::Token { da: 3, sa: 7 });
        assert_eq!(probe.other_master(), Some(7));
    }
}
