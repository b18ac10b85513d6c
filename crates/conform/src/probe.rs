//! A station that sends any octets, even those that no master sends, and keeps the answer.
//!
//! The probe claims the line like a single master (profibus-wire 1.13) and needs it exclusively: damaged requests during the
//! token rotation of other masters would disturb them, and the results would prove nothing.

use profivac_dp::link::active::BusParameters;
use profivac_dp::link::{BitTime, CHARACTER_TBIT, Station, Transmit};
use profivac_wire::control::Control;
use profivac_wire::{BROADCAST, MAX_TELEGRAM, Telegram};

/// Answer to the octets that the probe sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Received {
    /// Nothing within the slot time.
    Nothing,
    /// Octets that are not a telegram.
    Damaged,
    /// A telegram.
    Telegram(Vec<u8>),
}

/// State of the probe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// It has no request.
    Idle,
    /// It sends when the line has been idle for this time.
    Ready { idle_tbit: u64 },
    /// It sends.
    Sending,
    /// It waits for the answer.
    Waiting { until: BitTime },
}

/// A station that sends one request at a time.
#[derive(Debug)]
pub struct Probe {
    bus: BusParameters,
    state: State,
    busy: BitTime,
    octets: Vec<u8>,
    received: Received,
    other: Option<u8>,
    /// Octets came while the probe waited for no answer.
    has_late: bool,
}

impl Probe {
    /// A probe without a request.
    #[must_use]
    pub const fn new(bus: BusParameters, now: BitTime) -> Self {
        let octets = Vec::new();
        Self { bus, state: State::Idle, busy: now, octets, received: Received::Nothing, other: None, has_late: false }
    }

    /// Its address.
    #[must_use]
    pub const fn address(&self) -> u8 {
        self.bus.address
    }

    /// The address of another master that was received, if there was one.
    #[must_use]
    pub const fn other_master(&self) -> Option<u8> {
        self.other
    }

    /// Idle time in bit times after which a master may claim the line.
    #[must_use]
    pub fn timeout_tbit(&self) -> u64 {
        self.bus.timeout_tbit()
    }

    /// Sends `octets` when the line has been idle for the longer one of T_ID1 and T_ID2; after a request without an answer, for
    /// a second slot time. So a late answer to that request is recognised, and not taken for the answer to these octets.
    pub fn send(&mut self, octets: &[u8]) {
        let idle_tbit = match self.received {
            Received::Nothing => self.idle_tbit().max(self.slot_tbit()),
            Received::Damaged | Received::Telegram(_) => self.idle_tbit(),
        };
        self.octets = octets.iter().take(MAX_TELEGRAM).copied().collect();
        self.received = Received::Nothing;
        self.state = State::Ready { idle_tbit };
    }

    /// The longest silence of a message cycle, in bit times: before the request, and for the answer.
    #[must_use]
    pub fn longest_silence_tbit(&self) -> u64 {
        self.idle_tbit().max(self.slot_tbit()).saturating_add(self.slot_tbit())
    }

    /// Whether octets came since the last call while the probe waited for no answer: they came too late.
    pub const fn take_late(&mut self) -> bool {
        std::mem::replace(&mut self.has_late, false)
    }

    /// The answer to the last request; `None` until it is known.
    #[must_use]
    pub fn received(&self) -> Option<&Received> {
        (self.state == State::Idle).then_some(&self.received)
    }

    fn idle_tbit(&self) -> u64 {
        self.bus.id1_tbit().max(self.bus.id2_tbit())
    }

    /// Its slot time.
    #[must_use]
    pub fn slot_tbit(&self) -> u64 {
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
            self.received = Received::Telegram(octets.iter().take(length).copied().collect());
            self.state = State::Idle;
        } else {
            self.has_late = true;
        }
        None
    }

    fn activity(&mut self, end: BitTime) {
        self.busy = self.busy.max(end);
        self.has_late |= matches!(self.state, State::Idle | State::Ready { .. });
        if let State::Waiting { until } = &mut self.state {
            self.received = Received::Damaged;
            // The probe receives a telegram that has begun until its end.
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
            State::Waiting { until } => {
                self.busy = self.busy.max(until);
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

/// The master that sent `telegram`; `None` if a slave may have sent it.
fn sending_master(telegram: &Telegram<'_>) -> Option<u8> {
    match telegram {
        Telegram::Token { da, sa } if *da < BROADCAST && *sa < BROADCAST => Some(*sa),
        Telegram::Data(data) if matches!(data.control(), Control::Request { .. }) => Some(data.sa),
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

    /// Sends the request. Returns the end of its last character.
    fn send_request(probe: &mut Probe) -> BitTime {
        probe.send(&REQUEST);
        let due = probe.wake_at().unwrap();
        assert_eq!(probe.poll(due).map(|transmit| transmit.octets.to_vec()), Some(REQUEST.to_vec()));
        probe.sent(due + 66);
        due + 66
    }

    #[test]
    fn the_probe_reports_silence_after_the_slot_time() {
        let mut probe = probe();
        let sent = send_request(&mut probe);
        assert_eq!((probe.received(), probe.wake_at()), (None, Some(sent + 100)));
        assert_eq!(probe.poll(sent + 100), None);
        assert_eq!(probe.received(), Some(&Received::Nothing));
    }

    #[test]
    fn the_probe_keeps_all_octets_of_an_answer() {
        let mut probe = probe();
        let sent = send_request(&mut probe);
        probe.activity(sent + 22);
        let answer = [0x10, 2, 8, 0, 0x0A, 0x16];
        probe.telegram(sent + 77, &Telegram::parse(&answer).unwrap());
        assert_eq!(probe.received(), Some(&Received::Telegram(answer.to_vec())));
        assert_eq!(probe.other_master(), None);
    }

    #[test]
    fn the_probe_reports_octets_without_a_telegram_as_damaged() {
        let mut probe = probe();
        let sent = send_request(&mut probe);
        probe.activity(sent + 22);
        let end = probe.wake_at().unwrap();
        assert_eq!(end, sent + 22 + 111);
        probe.poll(end);
        assert_eq!(probe.received(), Some(&Received::Damaged));
    }

    /// The second slot time begins where the first one ends.
    #[test]
    fn after_silence_the_probe_listens_for_another_slot_time_and_reports_a_late_answer() {
        let mut probe = probe();
        let sent = send_request(&mut probe);
        probe.poll(sent + 100);
        assert!(!probe.take_late());
        probe.send(&REQUEST);
        assert_eq!(probe.wake_at(), Some(sent + 100 + 100));
        probe.activity(sent + 150);
        probe.telegram(sent + 183, &Telegram::parse(&[0x10, 2, 8, 0, 0x0A, 0x16]).unwrap());
        assert_eq!(probe.received(), None);
        assert!(probe.take_late());
        assert!(!probe.take_late());
        assert_eq!(probe.wake_at(), Some(sent + 183 + 100));
    }

    #[test]
    fn the_probe_notices_another_master() {
        let mut probe = probe();
        probe.telegram(BitTime(50), &Telegram::Token { da: 3, sa: 7 });
        assert_eq!(probe.other_master(), Some(7));
    }
}
