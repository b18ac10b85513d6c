//! The active station in a ring, telegram by telegram: the table of `link::active::token`, and random octets.
//! profibus-wire 1.5, 1.12 and 1.13.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "helpers of tests are tests")]

use crate::support;

use profivac_dp::link::active::{
    Active, BusParameter, BusParameters, Confirmation, FdlUser, OutOfRange, Priority, Request, RingState,
};
use profivac_dp::link::{BitTime, CHARACTER_TBIT, Received, Receiver, Station};
use profivac_dp::master::services;
use profivac_wire::control::Control;
use profivac_wire::{MAX_TELEGRAM, Telegram};
use support::rig::MasterRig;
use support::{Random, bus, hex, text};

/// Asks slave 40 for its diagnosis a given number of times.
#[derive(Clone, Default)]
struct Requester {
    left: u32,
    failed: u32,
}

impl FdlUser for Requester {
    fn next_request(&mut self, _priority: Priority, _now: BitTime) -> Option<Request<'_>> {
        self.left = self.left.checked_sub(1)?;
        Some(services::slave_diag(40))
    }

    fn confirm(&mut self, _now: BitTime, confirmation: Confirmation<'_>) {
        self.failed += u32::from(matches!(confirmation, Confirmation::Failed(_)));
    }
}

/// T_SL 300, T_ID1 37; no address to ask between 5 and 9, for a long time.
fn parameters() -> BusParameters {
    BusParameters { address: 5, hsa: 5, ..bus() }
}

fn listening() -> MasterRig<Requester> {
    MasterRig::new(Active::new(parameters().check().unwrap(), Requester::default(), BitTime(0)))
}

/// Station 5 knows the ring of 3, 9 and 15 and is not in it.
fn ready() -> MasterRig<Requester> {
    let mut rig = listening();
    for _ in 0..3 {
        for token in ["DC 09 03", "DC 0F 09", "DC 03 0F"] {
            rig.receive_after(40, token);
        }
    }
    assert_eq!(rig.station.ring_state(), RingState::Ready);
    rig
}

/// Station 5 is in the ring of 3, 5, 9 and 15 and has passed the token on; 9 has it.
fn idle() -> MasterRig<Requester> {
    let mut rig = ready();
    rig.receive_after(40, "DC 05 03");
    while rig.next_telegram().text() != "DC 09 05" {}
    rig.receive_after(40, "DC 0F 09");
    assert_eq!((rig.station.ring_state(), rig.station.has_token()), (RingState::InRing, false));
    rig
}

/// The answer of the station to a telegram that ends now, and its delay in bit times.
fn answer(rig: &mut MasterRig<Requester>, telegram: &str) -> Option<(u64, String)> {
    let octets = hex(telegram);
    rig.now = rig.now + 40 + octets.len() as u64 * CHARACTER_TBIT;
    let end = rig.now;
    let answer = rig.station.telegram(end, &Telegram::parse(&octets).unwrap())?;
    let (start, octets) = (answer.not_before, answer.octets.to_vec());
    rig.now = start + octets.len() as u64 * CHARACTER_TBIT;
    rig.station.sent(rig.now);
    Some((start - end, text(&octets)))
}

#[test]
fn fdl_status_reports_the_ring_state() {
    const ASK: &str = "10 05 03 49 51 16";
    for (mut rig, expected) in
        [(listening(), "10 03 05 10 18 16"), (ready(), "10 03 05 20 28 16"), (idle(), "10 03 05 30 38 16")]
    {
        assert_eq!(answer(&mut rig, ASK), Some((11, expected.into())));
        assert_eq!(answer(&mut rig, ASK), Some((11, expected.into())), "and again");
        // Requests to another station, to all stations, or from an impossible address.
        for other in ["10 06 03 49 52 16", "10 7F 03 49 CB 16", "10 05 7F 49 CD 16"] {
            assert_eq!(answer(&mut rig, other), None, "{other}");
        }
    }
}

#[test]
fn a_station_of_the_ring_has_no_services() {
    // Slave_Diag, Data_Exchange and Ident to station 5: RS. Global_Control to it: nothing.
    for ask in ["68 05 05 68 85 83 6D 3C 3E EF 16", "10 05 03 6D 75 16", "10 05 03 4E 56 16"] {
        assert_eq!(answer(&mut idle(), ask), Some((11, "10 03 05 33 3B 16".into())), "{ask}");
        assert_eq!(answer(&mut listening(), ask), None, "{ask}");
    }
    assert_eq!(answer(&mut idle(), "10 05 03 46 4E 16"), None);
}

#[test]
fn the_token_is_taken_from_the_predecessor_at_once_and_from_others_the_second_time() {
    for mut rig in [ready(), idle()] {
        rig.receive_after(40, "DC 05 0F");
        assert!(!rig.station.has_token(), "15 is not the predecessor");
        rig.receive_after(300, "DC 05 09");
        assert!(!rig.station.has_token(), "nor is 9");
        rig.receive_after(300, "DC 05 0F");
        assert!(!rig.station.has_token(), "this was not the second time in a row");
        rig.receive_after(300, "DC 05 0F");
        assert!(rig.station.has_token(), "now the ring has changed");
        assert!(!rig.station.masters().any(|master| master == 3), "no master is between 15 and 5");
    }
    for mut rig in [ready(), idle()] {
        rig.receive_after(40, "DC 05 03");
        let token = rig.now;
        assert!(rig.station.has_token());
        assert_eq!(rig.next_telegram().start, token + 37);
    }
}

#[test]
fn a_station_that_does_not_know_the_ring_accepts_no_token() {
    let mut rig = listening();
    for _ in 0..5 {
        rig.receive_after(300, "DC 05 03");
    }
    assert!(!rig.station.has_token());
}

#[test]
fn a_token_that_is_not_taken_is_sent_three_times_and_then_to_the_next_master() {
    let mut rig = ready();
    rig.receive_after(40, "DC 05 03");
    let mut expected = rig.now + 37;
    for token in ["DC 09 05", "DC 0F 05", "DC 03 05"] {
        for _ in 0..3 {
            let sent = rig.next_telegram();
            assert_eq!((sent.start, sent.text().as_str()), (expected, token));
            expected = rig.now + 300;
        }
    }
    // No other master is left: the GAP has all addresses again, and the token comes back.
    assert_eq!(rig.next_telegram().text(), "DC 05 05");
    assert_eq!(rig.station.masters().collect::<Vec<_>>(), [5]);
    assert_eq!(rig.next_telegram().text(), "10 00 05 49 4E 16");
    let counters = rig.station.ring_counters();
    assert_eq!((counters.repeated, counters.lost_successors), (6, 3));
}

#[test]
fn a_master_that_is_found_in_the_gap_gets_the_token_if_it_can_take_it() {
    for (answer, kind, token) in [
        ("10 05 03 00 08 16", "a slave", "DC 05 05"),
        ("10 05 03 10 18 16", "not ready", "DC 05 05"),
        ("10 05 03 20 28 16", "ready", "DC 03 05"),
        ("10 05 03 30 38 16", "in a ring of its own", "DC 03 05"),
    ] {
        let mut rig = listening();
        while rig.next_telegram().text() != "10 03 05 49 51 16" {}
        rig.receive(answer);
        assert_eq!(rig.next_telegram().text(), token, "{kind}");
    }
}

#[test]
fn any_telegram_after_the_token_confirms_the_pass() {
    for received in ["DC 0F 09", "10 28 09 49 7A 16", "FF", "10 28"] {
        let mut rig = ready();
        rig.receive_after(40, "DC 05 03");
        assert_eq!(rig.next_telegram().text(), "DC 09 05");
        rig.receive_after(280, received);
        // Silence from here on: T_TO of 5 is 16 slot times.
        let silent = rig.now;
        let claim = rig.next_telegram();
        assert_eq!((claim.start, claim.text().as_str()), (silent + 16 * 300, "DC 09 05"), "{received}");
    }
}

#[test]
fn a_token_that_skips_the_station_puts_it_out_of_the_ring_and_keeps_it_ready() {
    for token in ["DC 09 03", "DC 03 03", "DC 06 0F"] {
        let mut rig = idle();
        rig.receive_after(40, token);
        assert_eq!(rig.station.ring_state(), RingState::Ready, "{token}");
        assert_eq!(rig.station.ring_counters().left_out, 1, "{token}");
    }
    for token in ["DC 0F 09", "DC 03 0F", "DC 06 09"] {
        let mut rig = idle();
        rig.receive_after(40, token);
        if token == "DC 06 09" {
            // From 9 around the end to 6: the token skips this station.
            assert_eq!(rig.station.ring_state(), RingState::Ready);
        } else {
            assert_eq!(rig.station.ring_state(), RingState::InRing, "{token}");
        }
    }
}

#[test]
fn outside_the_ring_a_silent_line_is_claimed_with_two_tokens_and_inside_the_token_is_passed_on() {
    for mut rig in [listening(), ready()] {
        let silent = rig.now;
        let sent = [rig.next_telegram(), rig.next_telegram()].map(|sent| sent.text());
        assert_eq!((sent, rig.now), (["DC 05 05".into(), "DC 05 05".into()], silent + 4800 + 33 + 37 + 33));
        assert_eq!(rig.station.masters().collect::<Vec<_>>(), [5]);
    }
    let mut rig = idle();
    let silent = rig.now;
    let sent = rig.next_telegram();
    assert_eq!((sent.start, sent.text().as_str()), (silent + 4800, "DC 09 05"));
    assert_eq!(rig.station.ring_counters().claimed, 1);
}

#[test]
fn a_token_holder_that_receives_another_master_gives_the_token_up() {
    for received in ["10 28 03 49 74 16", "DC 0F 09", "68 05 05 68 A8 83 6D 3C 3E 12 16"] {
        let mut rig = ready();
        rig.station.user.left = 5;
        rig.receive_after(40, "DC 05 03");
        assert_eq!(rig.next_telegram().text(), "68 05 05 68 A8 85 6D 3C 3E 14 16");
        rig.receive_after(100, received);
        assert_eq!((rig.station.has_token(), rig.station.user.failed), (false, 1), "{received}");
        assert_eq!(rig.station.ring_counters().given_up, 1, "{received}");
        // The station accepts the next token.
        rig.receive_after(40, "DC 05 03");
        assert!(rig.station.has_token(), "{received}");
    }
}

#[test]
fn a_station_that_receives_its_own_address_twice_is_silent_until_two_rotations_without_it() {
    for received in ["DC 09 05", "10 28 05 49 76 16", "10 03 05 00 08 16"] {
        let mut rig = idle();
        rig.receive_after(40, received);
        assert_eq!(rig.station.ring_state(), RingState::InRing, "once may be noise: {received}");
        rig.receive_after(40, received);
        assert_eq!(rig.station.ring_state(), RingState::AddressTaken, "{received}");
        assert_eq!(answer(&mut rig, "10 05 03 49 51 16"), None, "the other station answers");
        for _ in 0..3 {
            for token in ["DC 09 03", "DC 0F 09", "DC 03 0F"] {
                assert_ne!(rig.station.ring_state(), RingState::Ready);
                rig.receive_after(40, token);
            }
        }
        assert_eq!(rig.station.ring_state(), RingState::Ready, "{received}");
    }
}

#[test]
fn a_single_telegram_with_the_own_address_now_and_then_is_noise() {
    let mut rig = idle();
    for _ in 0..10 {
        rig.receive_after(40, "DC 09 05");
        for _ in 0..2 {
            rig.receive_after(40, "DC 05 03");
            while rig.next_telegram().text() != "DC 09 05" {}
            rig.receive_after(40, "DC 0F 09");
        }
    }
    assert_eq!(rig.station.ring_state(), RingState::InRing);
}

/// A station that is alone leaves while it passes the token to itself: the returning token starts no message.
#[test]
fn a_leaving_station_does_not_use_a_token_that_comes_back() {
    let mut rig = listening();
    while !rig.station.has_token() {
        rig.next_telegram();
    }
    loop {
        let due = rig.station.wake_at().unwrap();
        let sent = rig.station.poll(due).map(|transmit| (transmit.not_before, transmit.octets.to_vec()));
        let Some((start, octets)) = sent else { continue };
        if octets[0] == 0xDC {
            rig.station.user.left = 5;
            rig.station.leave();
            rig.station.sent(start + 33);
            break;
        }
        rig.station.sent(start + octets.len() as u64 * CHARACTER_TBIT);
    }
    let due = rig.station.wake_at().unwrap();
    assert_eq!(rig.station.poll(due), None);
    assert_eq!((rig.station.ring_state(), rig.station.user.left), (RingState::Offline, 5));
}

#[test]
fn no_token_with_an_impossible_address_changes_anything() {
    for make in [listening, ready, idle] {
        let before = make();
        for address in [126, 127, 128, 131, 200, 255] {
            for (da, sa) in [(5, address), (address, 5), (address, 3), (3, address), (address, address)] {
                let mut rig = make();
                rig.station.telegram(rig.now + 100, &Telegram::Token { da, sa });
                let all =
                    |rig: &MasterRig<Requester>| (rig.station.masters().collect::<Vec<_>>(), rig.station.ring_state());
                assert_eq!(all(&rig), all(&before), "{sa} to {da}");
                assert!(!rig.station.has_token());
            }
        }
    }
}

#[test]
fn a_message_of_high_priority_is_sent_however_late_the_token_comes() {
    let mut rig = MasterRig::new(Active::new(
        BusParameters { rotation_tbit: 256, ..parameters() }.check().unwrap(),
        Requester { left: 100, failed: 0 },
        BitTime(0),
    ));
    for _ in 0..3 {
        for token in ["DC 09 03", "DC 0F 09", "DC 03 0F"] {
            rig.receive_after(40, token);
        }
    }
    for _ in 0..5 {
        rig.receive_after(2000, "DC 05 03");
        let messages = std::iter::from_fn(|| Some(rig.next_telegram())).take_while(|sent| !sent.is_token());
        assert_eq!(messages.filter(|sent| sent.octets[0] == 0x68).count(), 1);
        rig.receive_after(40, "DC 0F 09");
    }
}

/// A model of the token, from the telegrams that the station receives.
struct Watch {
    /// The last sender was another master, and it did not pass the token to this station.
    theirs: bool,
    /// The end of the last telegram received or sent.
    busy: BitTime,
    /// The last telegram was a request to this station.
    asked: bool,
    /// The telegram sent last, which may come back as an echo.
    sent: Vec<u8>,
    /// The station asked last, and whether for its FDL status.
    asking: Option<(u8, bool)>,
}

impl Watch {
    fn receive(&mut self, own: u8, end: BitTime, telegram: Option<&Telegram<'_>>) {
        self.busy = end;
        self.asked = false;
        let mut octets = [0; MAX_TELEGRAM];
        let length = telegram.and_then(|telegram| telegram.emit(&mut octets).ok()).unwrap_or_default();
        let is_sender = match telegram {
            Some(Telegram::Token { da, sa }) => *da <= 125 && *sa <= 125,
            Some(Telegram::Data(data)) => {
                data.sa == own || matches!(data.control(), Control::Request { .. }) && data.sa < 127
            }
            Some(Telegram::ShortAck) | None => false,
        };
        if is_sender && std::mem::take(&mut self.sent) == octets[..length] {
            return;
        }
        match telegram {
            Some(Telegram::Token { da, sa }) if *da <= 125 && *sa <= 125 => self.theirs = *da != own || *sa == own,
            Some(Telegram::Data(data)) if data.sa < 127 && matches!(data.control(), Control::Request { .. }) => {
                let status = data.fc & 0x4F == 0x49;
                if data.da == own && self.asking.is_some_and(|(da, asked)| da == data.sa && !(asked && status)) {
                    // A damaged answer, or a request if the answer came before: the station may take it for either.
                    self.asked = true;
                    return;
                }
                self.theirs = true;
                self.asked = data.da == own && data.sa != own;
            }
            _ => {}
        }
    }

    /// The station is about to send.
    fn sends(&mut self, bus: &BusParameters, start: BitTime, octets: &[u8]) {
        let telegram = Telegram::parse(octets).expect("a station sends telegrams");
        let answers = matches!(&telegram, Telegram::Data(data) if matches!(data.control(), Control::Response { .. }));
        let idle = start - self.busy;
        if answers {
            assert!(self.asked && idle == 11, "an answer without a request: {}", text(octets));
        } else {
            assert!(idle >= bus.id1_tbit(), "{} after {idle}", text(octets));
            assert!(!self.theirs || idle >= bus.timeout_tbit(), "it has no token: {}", text(octets));
            self.theirs = false;
        }
        self.asked = false;
        self.sent = octets.to_vec();
        self.asking = match &telegram {
            Telegram::Data(data) if !answers => Some((data.da, data.fc & 0x4F == 0x49)),
            _ => None,
        };
    }
}

/// Octets that mostly occur in a ring.
fn octets(random: &mut Random) -> Vec<u8> {
    let address = |random: &mut Random| [3, 5, 5, 9, 15, 40, 126, 127, 133][random.below(9)];
    let (da, sa) = (address(random), address(random));
    match random.below(10) {
        0..4 => vec![0xDC, da, sa],
        4 => vec![0xDC, 5, [3, 3, 9][random.below(3)]],
        5 => vec![[0xE5, 0xFF, random.next() as u8][random.below(3)]],
        6 => (0..random.below(12)).map(|_| random.next() as u8).collect(),
        _ => {
            let fc = [0x49, 0x6D, 0x46, 0x00, 0x08, 0x30, 0x10, random.next() as u8][random.below(8)];
            vec![0x10, da, sa, fc, da.wrapping_add(sa).wrapping_add(fc), 0x16]
        }
    }
}

/// Random telegrams, fragments and noise: the station does not panic, sends nothing without the token as far as it can know,
/// and has no deadline in the past.
fn storm(seed: u64) {
    let mut random = Random::new(seed);
    let bus = BusParameters { gap_factor: 1, hsa: 15, rotation_tbit: 3000, ..parameters() };
    let mut station = Active::new(bus.check().unwrap(), Requester { left: u32::MAX, failed: 0 }, BitTime(0));
    let mut receiver = Receiver::new(BitTime(0));
    let mut watch = Watch { theirs: true, busy: BitTime(0), asked: false, sent: Vec::new(), asking: None };
    let mut now = BitTime(0);
    for _ in 0..2_000 {
        let silence = [11, 40, 40, 60, 310, 310, 1000, 6000][random.below(8)];
        let until = now + silence;
        let mut quick = 0;
        while let Some(due) = station.wake_at().filter(|due| *due <= until) {
            quick = if due <= now { quick + 1 } else { 0 };
            assert!(quick < 4, "it waits for {due}, and it is {now}");
            now = now.max(due);
            let Some(transmit) = station.poll(now) else { continue };
            watch.sends(&bus, transmit.not_before.max(now), transmit.octets);
            now = transmit.not_before.max(now) + transmit.octets.len() as u64 * CHARACTER_TBIT;
            watch.busy = now;
            station.sent(now);
        }
        now = now.max(until);
        for octet in octets(&mut random) {
            now = now + CHARACTER_TBIT;
            match receiver.octet(now, octet) {
                Received::Telegram(telegram) => {
                    watch.receive(5, now, Some(&telegram));
                    if let Some(transmit) = station.telegram(now, &telegram) {
                        watch.sends(&bus, transmit.not_before, transmit.octets);
                        now = transmit.not_before + transmit.octets.len() as u64 * CHARACTER_TBIT;
                        watch.busy = now;
                        station.sent(now);
                    }
                }
                Received::Nothing | Received::Damaged(_) => {
                    watch.receive(5, now, None);
                    station.activity(now);
                }
            }
        }
        assert!(station.masters().all(|master| master <= 125));
        assert!(station.wake_at().is_some(), "it has no deadline");
    }
    // On a silent line the station forms a ring with itself.
    let end = now + 100_000;
    while now < end {
        now = now.max(station.wake_at().unwrap());
        let Some(transmit) = station.poll(now) else { continue };
        now = now + transmit.octets.len() as u64 * CHARACTER_TBIT;
        station.sent(now);
    }
    assert_eq!((station.ring_state(), station.masters().collect::<Vec<_>>()), (RingState::InRing, vec![5]));
}

#[test]
fn random_octets_cause_no_panic_no_telegram_without_token_and_no_hang() {
    for seed in 0..200 {
        storm(seed);
    }
}

/// A station relies on its parameters, so a wrong highest address is refused and the old one holds.
#[test]
fn an_impossible_highest_address_is_refused() {
    let bus = BusParameters { hsa: 20, ..parameters() };
    let mut station = Active::new(bus.check().unwrap(), Requester::default(), BitTime(0));
    for hsa in [0, 4, 127, 255] {
        let refused = OutOfRange { parameter: BusParameter::HighestAddress, given: hsa.into(), least: 5, most: 126 };
        assert_eq!(station.set_hsa(hsa), Err(refused));
        assert_eq!(station.bus().hsa, 20);
    }
    assert_eq!(station.set_hsa(126), Ok(()));
    assert_eq!(station.bus().hsa, 126);
}
