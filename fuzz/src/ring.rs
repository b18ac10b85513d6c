//! An active station in a ring: tokens, requests, answers, damaged telegrams, pauses.
//!
//! The station has no deadline in the past, sends only telegrams, answers only requests to it, and on a silent line forms a ring with
//! itself.

use crate::script::Script;
use profivac_dp::link::active::{Active, BusParameters, Confirmation, FdlUser, Priority, Request, RingState};
use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Received, Receiver, Station};
use profivac_dp::master::services;
use profivac_wire::Telegram;
use profivac_wire::control::Control;

const OWN: u8 = 5;
/// The most polls at one bit time.
const POLLS: u32 = 8;

/// Asks slave 40 for its diagnosis.
struct Asker;

impl FdlUser for Asker {
    fn next_request(&mut self, _: Priority, _: BitTime) -> Option<Request<'_>> {
        Some(services::slave_diag(40))
    }

    fn confirm(&mut self, _: BitTime, _: Confirmation<'_>) {}
}

/// A station on a line.
struct Line {
    station: Active<Asker>,
    receiver: Receiver,
    now: BitTime,
    /// The user has taken the station out of the ring.
    has_left: bool,
}

impl Line {
    /// The station sends what is due until `until`. It may send longer.
    fn serve(&mut self, until: BitTime) {
        let mut polls = 0;
        while let Some(due) = self.station.wake_at().filter(|due| *due <= until) {
            polls = if due <= self.now { polls + 1 } else { 0 };
            assert!(polls < POLLS, "it waits for {due}, and it is {}", self.now);
            self.now = self.now.max(due);
            let Some(transmit) = self.station.poll(self.now) else { continue };
            assert!(Telegram::parse(transmit.octets).is_ok(), "not a telegram: {:02X?}", transmit.octets);
            self.now = transmit.not_before.max(self.now) + transmit.octets.len() as u64 * CHARACTER_TBIT;
            self.station.sent(self.now);
        }
        self.now = self.now.max(until);
    }

    fn receive(&mut self, octets: &[u8]) {
        for octet in octets {
            self.now = self.now + CHARACTER_TBIT;
            let Received::Telegram(telegram) = self.receiver.octet(self.now, *octet) else {
                self.station.activity(self.now);
                continue;
            };
            let is_request = matches!(&telegram, Telegram::Data(frame)
                if frame.da == OWN && matches!(frame.control(), Control::Request { .. }));
            let Some(transmit) = self.station.telegram(self.now, &telegram) else { continue };
            assert!(is_request, "{telegram:?} was answered");
            self.now = transmit.not_before + transmit.octets.len() as u64 * CHARACTER_TBIT;
            self.station.sent(self.now);
        }
    }

    /// One step of the script.
    fn step(&mut self, kind: u8, script: &mut Script<'_>) {
        /// Stations that are masters, slaves, or nothing.
        const ADDRESSES: [u8; 12] = [3, OWN, OWN, 9, 15, 40, 125, 126, 127, 133, 4, 6];
        match kind % 8 {
            0 | 1 => {
                let token = [0xDC, script.one_of(&ADDRESSES), script.one_of(&ADDRESSES)];
                self.receive(&token);
            }
            2 => {
                let (da, sa, fc) = (script.one_of(&ADDRESSES), script.one_of(&ADDRESSES), script.choice());
                self.receive(&[0x10, da, sa, fc, da.wrapping_add(sa).wrapping_add(fc), 0x16]);
            }
            3 => {
                let octets = script.piece(40);
                self.receive(octets);
            }
            4 => self.receive(&[0xE5]),
            // As long as a slot, T_ID1, or the time without a token.
            5 => self.serve(self.now + [11, 40, 60, 310, 1000, 6000][usize::from(kind >> 4) % 6]),
            6 => {
                let tbit = script.pause_tbit() & 0xF_FFFF;
                self.serve(self.now + tbit);
            }
            _ => match script.choice() % 6 {
                0 => self.station.listen(self.now),
                1 => {
                    self.station.leave();
                    self.has_left = true;
                }
                2 => self.station.delay_gap_scan(),
                3 => self.station.raise_slot_time(u32::from(script.choice())),
                4 => drop(self.station.set_hsa(script.choice())),
                _ => self.receiver.character_error(self.now),
            },
        }
        assert!(self.station.masters().all(|master| master <= 125));
    }
}

/// Runs the target.
pub fn run(octets: &[u8]) {
    let mut script = Script::new(octets);
    let bus = BusParameters {
        gap_factor: 1 + script.choice() % 3,
        hsa: 15,
        rotation_tbit: 3000,
        ..BusParameters::new(OWN, Baud::B1500000)
    };
    let station = Active::new(bus.check().expect("possible parameters"), Asker, BitTime(0));
    let mut line = Line { station, receiver: Receiver::new(BitTime(0)), now: BitTime(0), has_left: false };
    while let Some(kind) = script.octet() {
        line.step(kind, &mut script);
    }
    if line.has_left {
        line.station.listen(line.now);
    }
    line.serve(line.now + 200_000);
    let masters: Vec<u8> = line.station.masters().collect();
    assert_eq!((line.station.ring_state(), masters), (RingState::InRing, vec![OWN]), "on a silent line");
}
