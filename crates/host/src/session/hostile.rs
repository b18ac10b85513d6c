//! A session on a line whose other end sends what it likes, when it likes, while the clock jumps.
//!
//! No octets make the session panic, raise its times without a limit, or send outside of its window: without the token, into a
//! telegram, or while an answer may come. The numbers of a failed case are in its message.

use super::{BusSession, MAX_SLOT_TBIT, bus_parameters};
use crate::clock::tbit_of;
use crate::port::{Character, Delivery, Port, PortError};
use crate::readiness::Readiness;
use fastrand::Rng;
use profivac_dp::link::active::BusParameters;
use profivac_dp::link::{Baud, CHARACTER_TBIT, T_SYN_TBIT};
use profivac_dp::master::services;
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// The address of the master under test.
const OWN: u8 = 2;

/// The most characters of one delivery.
const MOST: usize = 40;

/// What happened at the port, in the order of time.
#[derive(Clone, Debug)]
enum Event {
    Received(Vec<u8>),
    Sent(Vec<u8>),
}

type Journal = Arc<Mutex<Vec<(Duration, Event)>>>;

/// The line and its hostile other end.
struct HostilePort {
    rng: Rng,
    delivery: Delivery,
    now: Duration,
    /// The last request of the session.
    request: Vec<u8>,
    delivered: Vec<u8>,
    journal: Journal,
}

impl HostilePort {
    /// Something that looks like an answer, a token, a request or nothing at all, in whole or in part.
    fn octets(&mut self) -> Vec<u8> {
        let rng = &mut self.rng;
        let address = |rng: &mut Rng| {
            let any = rng.u8(..);
            rng.choice([OWN, 5, 7, 126, 127, any]).unwrap_or(OWN)
        };
        let (da, sa, fc) = (address(rng), address(rng), rng.u8(..));
        let asked = self.request.get(1).copied().unwrap_or(5) & 0x7F;
        let sd1 = |da: u8, sa: u8, fc: u8| vec![0x10, da, sa, fc, da.wrapping_add(sa).wrapping_add(fc), 0x16];
        let mut octets = match rng.u8(..8) {
            0 => sd1(OWN, asked, 0),
            1 => sd1(OWN, asked, fc),
            2 => vec![0xDC, da, sa],
            3 => vec![0xDC, OWN, sa],
            4 => vec![0xE5],
            5 => {
                let du: Vec<u8> = (0..rng.u8(..20)).map(|_| rng.u8(..)).collect();
                let body = [vec![OWN, asked, fc], du].concat();
                let length = u8::try_from(body.len()).unwrap_or(3);
                let sum = body.iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet));
                [vec![0x68, length, length, 0x68], body, vec![sum, 0x16]].concat()
            }
            6 => sd1(OWN, sa, 0x49),
            _ => (0..rng.usize(1..MOST)).map(|_| rng.u8(..)).collect(),
        };
        if rng.u8(..4) == 0 {
            octets.truncate(rng.usize(1..=octets.len()));
        }
        octets
    }
}

impl Port for HostilePort {
    fn name(&self) -> &str {
        "hostile"
    }

    fn delivery(&self) -> Delivery {
        self.delivery
    }

    fn readiness(&self) -> Vec<Readiness<'_>> {
        Vec::new()
    }

    fn receive(&mut self, characters: &mut Vec<Character>) -> Result<(), PortError> {
        let octets = std::mem::take(&mut self.delivered);
        for octet in octets {
            let is_damaged = self.rng.u8(..50) == 0;
            characters.push(if is_damaged { Character::Error } else { Character::Octet(octet) });
        }
        Ok(())
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError> {
        self.journal.lock().unwrap().push((self.now, Event::Sent(octets.to_vec())));
        self.request = octets.to_vec();
        Ok(())
    }

    fn simulated_time(&self) -> Option<Duration> {
        Some(self.now)
    }

    fn simulate(&mut self, at_most: Duration) {
        let at_most = at_most.min(Duration::from_secs(1));
        let jump = match self.rng.u16(..2000) {
            // The computer was suspended.
            0 => Duration::from_secs(self.rng.u64(1..100_000)),
            1..=20 => Duration::from_millis(self.rng.u64(1..3_000)),
            _ => Duration::ZERO,
        };
        let speaks = self.rng.u8(..3) == 0;
        let part = if speaks { at_most.mul_f64(self.rng.f64()) } else { at_most };
        self.now += part.max(Duration::from_micros(1)) + jump;
        if speaks {
            self.delivered = self.octets();
            self.journal.lock().unwrap().push((self.now, Event::Received(self.delivered.clone())));
        }
    }
}

/// What the session may send, from what it has received and sent.
struct Window {
    baud: Baud,
    is_timed: bool,
    /// The silence before the beginning: a line without a rate is idle when a segment begins.
    idle_before: u64,
    timeout_tbit: u64,
    heard: Vec<u8>,
    /// The last telegram of the session.
    sent: Vec<u8>,
    /// When characters came that no answer has followed.
    receptions: Vec<u64>,
    /// The end of the last character in either direction.
    busy: u64,
    /// The end of the last request or token to another station, if nothing came since.
    waits_since: Option<u64>,
    /// A token to this master, or a silence after which it claims one, has come since it passed the last one on.
    may_hold_token: bool,
    /// The last token went to another master, and nothing came since.
    has_passed: bool,
}

impl Window {
    fn new(baud: Baud, bus: &BusParameters, delivery: Delivery) -> Self {
        let is_timed = delivery.is_timed();
        let idle_before = if is_timed { 0 } else { delivery.idle_tbit(baud) + CHARACTER_TBIT };
        // T_TO of a master is 6 slot times and 2 for its address. profibus-wire 1.12.
        let timeout_tbit = u64::from(bus.slot_tbit) * (6 + 2 * u64::from(bus.address));
        Self {
            baud,
            is_timed,
            idle_before,
            timeout_tbit,
            heard: Vec::new(),
            sent: Vec::new(),
            receptions: Vec::new(),
            busy: 0,
            waits_since: None,
            may_hold_token: false,
            has_passed: false,
        }
    }

    fn check(&mut self, at: Duration, event: &Event, slot_tbit: u64) -> Result<(), String> {
        // Bit times are rounded down.
        let now = self.idle_before + tbit_of(self.baud, at) + 1;
        match event {
            Event::Received(octets) => {
                self.heard.extend(octets);
                self.heard.drain(..self.heard.len().saturating_sub(64));
                self.may_hold_token |= self.heard.windows(3).any(|token| matches!(token, [0xDC, OWN, _]));
                // Characters beside a token that it sends itself, and their echo, are no sign of another master.
                self.has_passed = match self.sent[..] {
                    [0xDC, da, _] if *octets == self.sent => da != OWN,
                    _ => self.has_passed && now <= self.busy,
                };
                (self.busy, self.waits_since) = (self.busy.max(now), None);
                self.receptions.push(now);
                Ok(())
            }
            Event::Sent(octets) => self.check_sent(now, octets, slot_tbit),
        }
    }

    fn check_sent(&mut self, now: u64, octets: &[u8], slot_tbit: u64) -> Result<(), String> {
        let silence = now.saturating_sub(self.busy);
        self.sent = octets.to_vec();
        let length = if self.is_timed { octets.len() as u64 * CHARACTER_TBIT } else { 0 };
        self.busy = now + length;
        let fc = match octets {
            [0x10 | 0xA2, _, _, fc, ..] | [0x68, _, _, 0x68, _, _, fc, ..] => *fc,
            _ => 0x40,
        };
        if fc & 0x40 == 0 {
            // An answer to a request of another master: min T_SDR after that. Other characters may have come since.
            let open = self.receptions.iter().position(|end| now >= end + 11);
            self.receptions.drain(..open.map_or(0, |index| index + 1));
            return open.map(|_| ()).ok_or_else(|| format!("an answer {silence} bit times after the last character"));
        }
        if silence < T_SYN_TBIT {
            return Err(format!("after {silence} bit times of silence"));
        }
        if let Some(since) = self.waits_since
            && now.saturating_sub(since) < slot_tbit
        {
            return Err(format!("{} bit times after a request, within the slot time", now - since));
        }
        self.may_hold_token |= silence >= self.timeout_tbit;
        let token = if let [0xDC, da, _] = octets { Some(*da) } else { None };
        // A token that the next master does not take is passed again, and then to the one behind it.
        let is_repeated_pass = token.is_some() && self.has_passed;
        if !self.may_hold_token && !is_repeated_pass {
            return Err(format!("without the token, after {silence} of {} bit times", self.timeout_tbit));
        }
        match token {
            Some(OWN) => (self.has_passed, self.may_hold_token) = (false, true),
            None => self.has_passed = false,
            Some(_) => {
                (self.has_passed, self.may_hold_token) = (true, false);
                // The begin of a token may be there already.
                self.heard.drain(..self.heard.len().saturating_sub(2));
            }
        }
        self.waits_since = (token != Some(OWN)).then_some(self.busy);
        Ok(())
    }
}

/// One line with one session. Returns what was wrong, and the number of telegrams that the session sent.
fn attack(seed: u64) -> Result<usize, String> {
    let mut rng = Rng::with_seed(seed);
    let baud = rng.choice([Baud::B9600, Baud::B19200, Baud::B500000, Baud::B12000000]).unwrap_or(Baud::B19200);
    let usb = |ms| Delivery::Usb { hold: Duration::from_millis(ms), is_known: true };
    let deliveries = [Delivery::Unpaced, Delivery::Fifo { trigger: Some(8) }, usb(1), usb(16)];
    let delivery = rng.choice(deliveries).unwrap_or_default();
    let bus = bus_parameters(OWN, baud, delivery);
    let bus = BusParameters { slot_tbit: bus.slot_tbit.min(MAX_SLOT_TBIT), ..bus };
    let journal = Journal::default();
    let port = HostilePort {
        rng: rng.fork(),
        delivery,
        now: Duration::ZERO,
        request: Vec::new(),
        delivered: Vec::new(),
        journal: Arc::clone(&journal),
    };
    let mut session =
        BusSession::new(Box::new(port), baud, bus, Duration::from_secs(3600)).map_err(|e| e.to_string())?;
    let mut window = Window::new(baud, &bus, delivery);
    let longest_pause = tbit_of(baud, delivery.max_pause()).max(delivery.idle_tbit(baud));
    let mut sent = 0;
    for _ in 0..600 {
        let slot_tbit = u64::from(session.station().bus().slot_tbit);
        session.serve(&[], Duration::from_millis(rng.u64(..50))).map_err(|error| error.to_string())?;
        for (at, event) in std::mem::take(&mut *journal.lock().map_err(|error| error.to_string())?) {
            sent += usize::from(matches!(event, Event::Sent(_)));
            window.check(at, &event, slot_tbit).map_err(|error| format!("{error}: {event:02X?} at {at:?}"))?;
        }
        session.master().take_confirmation();
        let _busy = session.master().submit_request(&services::slave_diag(rng.u8(3..8)));
        let (slot_tbit, pause) = (session.station().bus().slot_tbit, session.segment.idle_tbit());
        if slot_tbit > MAX_SLOT_TBIT || pause > longest_pause {
            return Err(format!("a slot time of {slot_tbit} bit times, a tolerated pause of {pause}"));
        }
        while session.next_notice().is_some() {}
    }
    Ok(sent)
}

#[test]
fn no_octets_and_no_clock_make_the_session_speak_outside_its_window_or_wait_without_a_limit() {
    let cases = std::env::var("PROFIVAC_CASES").ok().and_then(|cases| cases.parse().ok()).unwrap_or(100);
    let mut sent = 0;
    for seed in 0..cases {
        sent += attack(seed).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
    }
    assert!(sent as u64 > cases, "the session sent only {sent} telegrams");
}
