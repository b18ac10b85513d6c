//! The active station alone: when it sends, which requests it repeats, and which answers it accepts. profibus-wire 1.10, 1.12, 1.13.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "helpers of tests are tests")]

use crate::support;

use profivac_dp::link::active::{
    Active, Answer, BusParameters, Confirmation, Failure, FdlUser, Mismatch, Priority, Request,
};
use profivac_dp::link::{BitTime, Station};
use profivac_dp::master::services;
use profivac_wire::control::{Function, StationType, Status};
use std::collections::VecDeque;
use support::bus;
use support::rig::MasterRig;

/// A confirmation to the FDL user, without borrowing.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Reported {
    Sent,
    Answer(Status, Vec<u8>, u8),
    Failed(Failure),
}

/// An FDL user with two lists of requests: high priority and low priority.
#[derive(Default)]
struct List {
    high: VecDeque<Request<'static>>,
    low: VecDeque<Request<'static>>,
    sent: Option<Request<'static>>,
    reported: Vec<Reported>,
}

impl FdlUser for List {
    fn next_request(&mut self, priority: Priority, _now: BitTime) -> Option<Request<'_>> {
        assert_eq!(self.sent, None, "the message before was not confirmed");
        self.sent = match priority {
            Priority::High => self.high.pop_front(),
            Priority::Low => self.low.pop_front(),
        };
        self.sent
    }

    fn confirm(&mut self, _now: BitTime, confirmation: Confirmation<'_>) {
        assert!(self.sent.take().is_some(), "no message is to be confirmed");
        self.reported.push(match confirmation {
            Confirmation::Sent => Reported::Sent,
            Confirmation::Answer(Answer { status, du, repetitions, .. }) => {
                Reported::Answer(status, du.to_vec(), repetitions)
            }
            Confirmation::Failed(failure) => Reported::Failed(failure),
        });
    }
}

const EXCHANGE: Request<'static> =
    Request { da: 8, function: Function::SrdHigh, dsap: None, ssap: None, du: &[0xAA, 0x55] };
const CONTROL: Request<'static> =
    Request { da: 127, function: Function::SdnHigh, dsap: Some(58), ssap: Some(62), du: &[0, 0] };

fn rig(requests: &[Request<'static>]) -> MasterRig<List> {
    rig_with(bus(), requests)
}

fn rig_with(bus: BusParameters, requests: &[Request<'static>]) -> MasterRig<List> {
    let list = List { high: requests.iter().copied().collect(), ..List::default() };
    MasterRig::new(Active::new(bus.check().unwrap(), list, BitTime(0)))
}

#[test]
fn a_silent_line_is_claimed_after_t_to_with_two_tokens() {
    let mut rig = rig(&[]);
    // T_TO = 6 T_SL + 2 x 2 T_SL, with T_SL = 300; three characters per token, T_ID1 = 37 after each.
    assert_eq!(rig.station.wake_at(), Some(BitTime(3000)));
    assert_eq!(rig.station.poll(BitTime(2999)), None);
    for (start, telegram) in [(0, "DC 02 02"), (33 + 37, "DC 02 02"), (2 * (33 + 37), "10 00 02 49 4B 16")] {
        let sent = rig.next_telegram();
        assert_eq!((sent.start, sent.text().as_str()), (BitTime(3000 + start), telegram));
    }
    assert!(rig.station.has_token());
}

#[test]
fn any_activity_delays_the_claim() {
    let mut rig = rig(&[]);
    rig.receive_after(2000, "E5");
    assert_eq!(rig.station.wake_at(), Some(BitTime(2011 + 3000)));
    rig.receive_after(2989, "FF");
    assert_eq!(rig.next_telegram().start, BitTime(2011 + 2989 + 11 + 3000));
}

#[test]
fn the_idle_time_after_an_answer_is_t_id1_and_after_an_unanswered_message_t_id2() {
    let mut rig = rig(&[EXCHANGE, EXCHANGE, CONTROL, EXCHANGE]);
    assert_eq!(rig.next_request().text(), "68 05 05 68 08 02 6D AA 55 76 16");
    rig.receive_after(11, "68 05 05 68 02 08 08 01 02 15 16");
    let answered = rig.now;
    let second = rig.next_telegram();
    assert_eq!((second.start, second.text().as_str()), (answered + 37, "68 05 05 68 08 02 5D AA 55 66 16"));
    rig.receive_after(60, "E5");
    let answered = rig.now;
    let control = rig.next_telegram();
    assert_eq!((control.start, control.text().as_str()), (answered + 37, "68 07 07 68 FF 82 46 3A 3E 00 00 3F 16"));
    let left = rig.now;
    let third = rig.next_telegram();
    assert_eq!((third.start, third.text().as_str()), (left + 150, "68 05 05 68 08 02 7D AA 55 86 16"));
    rig.receive_after(11, "E5");
    let answered = rig.now;
    let gap = rig.next_telegram();
    assert_eq!((gap.start, gap.text().as_str()), (answered + 37, "10 00 02 49 4B 16"));
    let left = rig.now;
    let token = rig.next_telegram();
    assert_eq!((token.start, token.text().as_str()), (left + 300, "DC 02 02"));
    let data = |du: &[u8]| Reported::Answer(Status::DataLow, du.to_vec(), 0);
    let nothing = || Reported::Answer(Status::NoReply, vec![], 0);
    assert_eq!(rig.station.user.reported, [data(&[1, 2]), nothing(), Reported::Sent, nothing()]);
}

#[test]
fn every_wait_follows_the_parameters() {
    let slow = BusParameters { slot_tbit: 20_000, setup_tbit: 40, token_idle_tbit: Some(500), ..bus() };
    let mut rig = rig_with(slow, &[EXCHANGE, EXCHANGE]);
    assert_eq!(rig.next_telegram().start, BitTime(200_000));
    let claimed = rig.now;
    assert_eq!(rig.next_telegram().start, claimed + 500);
    rig.next_request();
    // The first character ends in the last bit time of T_SL, and the answer is taken.
    rig.receive_after(20_000 - 11, "E5");
    let answered = rig.now;
    // T_SM = 2 + 2 x 40, T_ID1 = 33 + T_SM
    assert_eq!(rig.next_telegram().start, answered + 115);
    let left = rig.now;
    assert_eq!(rig.next_telegram().start, left + 20_000);
}

#[test]
fn after_a_missing_answer_the_same_telegram_is_repeated_after_t_sl() {
    let mut rig = rig(&[EXCHANGE, EXCHANGE]);
    rig.next_request();
    rig.receive("E5");
    let first = rig.next_telegram();
    let left = rig.now;
    let again = rig.next_telegram();
    assert_eq!(again.octets, first.octets);
    assert_eq!(again.start, left + 300);
    rig.receive("E5");
    assert_eq!(rig.station.user.reported[1], Reported::Answer(Status::NoReply, vec![], 1));
}

#[test]
fn after_a_damaged_answer_the_same_telegram_is_repeated() {
    let mut rig = rig(&[EXCHANGE, EXCHANGE, EXCHANGE]);
    rig.next_request();
    rig.receive("E5");
    let first = rig.next_telegram();
    rig.receive("68 05 05 68 02 08 08 01 03 15 16");
    let received = rig.now;
    let again = rig.next_telegram();
    assert_eq!((again.start, &again.octets), (received + 300, &first.octets));
    rig.receive("68 05 05 68 02 08 08 01 02 15 16");
    assert_eq!(rig.station.user.reported[1], Reported::Answer(Status::DataLow, vec![1, 2], 1));
    // A second answer to the repeated request would look like the answer to the next one: the master waits two slot times for it.
    rig.receive_after(289, "68 05 05 68 02 08 08 01 02 15 16");
    assert_eq!(rig.station.wake_at(), Some(rig.now + 600));
    assert_eq!(rig.next_telegram().text(), "68 05 05 68 08 02 7D AA 55 86 16");
    assert_eq!(rig.station.user.reported.len(), 2);
}

#[test]
fn answers_that_are_always_late_are_never_matched_to_other_requests() {
    // The slave takes 400 bit times, and T_SL is 300: every answer comes after its request was repeated.
    let mut rig = rig(&[EXCHANGE; 8]);
    rig.next_request();
    rig.receive("E5");
    for round in 1..8 {
        // Two requests, two answers; the first answer comes 100 bit times after the second request.
        assert_eq!(rig.next_telegram().octets[0], 0x68);
        let repeated = rig.next_telegram();
        assert_eq!(repeated.octets[0], 0x68);
        let du = format!("{round:02X}");
        let answer = format!("68 04 04 68 02 08 08 {du} {:02X} 16", 0x12 + round);
        rig.receive_after(100, &answer);
        assert_eq!(rig.station.user.reported.last(), Some(&Reported::Answer(Status::DataLow, vec![round], 1)));
        // The second answer follows the first at the distance of the two requests.
        rig.receive_after(repeated.octets.len() as u64 * 11 + 300 - 110, &answer);
    }
    assert_eq!(rig.station.user.reported.len(), 8);
}

#[test]
fn after_a_late_answer_between_two_requests_the_master_waits_longer() {
    let mut rig = rig(&[EXCHANGE, EXCHANGE]);
    rig.next_request();
    rig.receive("E5");
    rig.receive_after(20, "68 05 05 68 02 08 08 01 02 15 16");
    assert_eq!(rig.station.wake_at(), Some(rig.now + 300));
    assert_eq!(rig.station.user.reported.len(), 1);
}

#[test]
fn the_wait_for_an_answer_that_has_begun_is_limited() {
    let mut rig = rig(&[EXCHANGE, EXCHANGE, EXCHANGE]);
    rig.next_request();
    rig.receive("E5");
    rig.next_telegram();
    // The first character arrives at the end of T_SL; the telegram ends long after it.
    let answer = {
        let mut octets = vec![0x68, 0xF7, 0xF7, 0x68, 2, 8, 8];
        octets.extend([7; 244]);
        let fcs = octets[4..].iter().fold(0u8, |sum, octet| sum.wrapping_add(*octet));
        octets.extend([fcs, 0x16]);
        octets
    };
    rig.receive_octets(289, &answer);
    assert_eq!(rig.station.user.reported[1], Reported::Answer(Status::DataLow, vec![7; 244], 0));

    // The station stops waiting for a line that is never idle: it listens and does not send.
    rig.next_telegram();
    for _ in 0..1000 {
        rig.receive_after(11, "FF");
        assert_eq!(rig.station.poll(rig.now), None);
    }
    assert!(!rig.station.has_token());
    assert_eq!(rig.station.user.reported[2], Reported::Failed(Failure::Interrupted));
    let quiet = rig.now;
    assert_eq!(rig.next_telegram().start, quiet + 3000);
}

#[test]
fn after_giving_up_the_next_request_is_a_first_contact_without_a_repetition() {
    let mut rig = rig(&[EXCHANGE; 5]);
    assert_eq!(rig.next_request().octets[6], 0x6D);
    // The station is not operational for the master yet, so the master sends the request once.
    assert_eq!(rig.next_request().octets[6], 0x6D);
    rig.receive("E5");
    assert_eq!(rig.next_telegram().octets[6], 0x5D);
    assert_eq!(rig.next_telegram().octets[6], 0x5D);
    assert_eq!(rig.next_telegram().octets[6], 0x6D, "one repetition, then the first contact again");
    rig.receive("E5");
    assert_eq!(rig.next_telegram().octets[6], 0x5D);
    rig.receive("E5");
    let sent = || Reported::Answer(Status::NoReply, vec![], 0);
    let silence = || Reported::Failed(Failure::Silence);
    assert_eq!(rig.station.user.reported, [silence(), sent(), silence(), sent(), sent()]);
}

#[test]
fn the_retry_limit_is_a_parameter() {
    for (retry_limit, tries) in [(0, 1), (1, 2), (4, 5)] {
        let mut rig = rig_with(BusParameters { retry_limit, ..bus() }, &[EXCHANGE, EXCHANGE]);
        rig.next_request();
        rig.receive("E5");
        let mut sent = 0;
        while rig.station.user.reported.len() == 1 {
            sent += usize::from(rig.next_telegram().octets[0] == 0x68);
        }
        assert_eq!(sent, tries);
    }
}

#[test]
fn any_valid_answer_toggles_the_one_bit_of_the_station_and_nothing_else_does() {
    let other = Request { da: 9, ..EXCHANGE };
    let mut rig = rig(&[
        services::slave_diag(8),
        services::get_cfg(8),
        other,
        EXCHANGE,
        services::fdl_status(8),
        CONTROL,
        services::slave_diag(8),
        EXCHANGE,
    ]);
    rig.dialogue(
        "M 68 05 05 68 88 82 6D 3C 3E F1 16 | Slave_Diag, first
         S 10 02 08 03 0D 16                | RS is an answer
         M 68 05 05 68 88 82 5D 3B 3E E0 16 | Get_Cfg, FCB = 0
         S 10 02 08 02 0C 16                | RR as well
         M 68 05 05 68 09 02 6D AA 55 77 16 | another station, first
         S E5
         M 68 05 05 68 08 02 7D AA 55 86 16 | Data_Exchange, FCB = 1
         S E5
         M 10 08 02 49 53 16                | FDL status does not count
         S 10 02 08 00 0A 16
         M 68 07 07 68 FF 82 46 3A 3E 00 00 3F 16
         M 68 05 05 68 88 82 5D 3C 3E E1 16 | Slave_Diag, FCB = 0
         S 10 02 08 01 0B 16                | UE
         M 68 05 05 68 08 02 7D AA 55 86 16 | Data_Exchange, FCB = 1
         S E5",
    );
    assert_eq!(rig.station.user.reported.len(), 8);
}

#[test]
fn an_answer_to_another_request_is_no_answer() {
    for (answer, mismatch) in [
        ("68 05 05 68 02 09 08 01 02 16 16", Mismatch::Source(9)),
        ("68 05 05 68 03 08 08 01 02 16 16", Mismatch::Destination(3)),
        ("68 0B 0B 68 82 88 08 3E 3C 02 05 00 FF 12 34 D8 16", Mismatch::AccessPoint),
        ("10 02 08 00 0A 16", Mismatch::Function(0)),
        ("68 05 05 68 02 08 03 01 02 10 16", Mismatch::Form),
    ] {
        // Only wrong answers: the request is repeated and then fails with the mismatch.
        let mut rig = rig(&[EXCHANGE, EXCHANGE, EXCHANGE]);
        rig.next_request();
        rig.receive("E5");
        for _ in 0..2 {
            assert_eq!(rig.next_telegram().octets[6], 0x5D, "{answer}");
            rig.receive(answer);
        }
        assert_eq!(rig.next_telegram().octets[6], 0x6D, "{answer}");
        assert_eq!(rig.station.user.reported[1], Reported::Failed(Failure::Mismatch(mismatch)), "{answer}");

        // The right answer after it is still in time.
        rig.receive(answer);
        rig.receive_after(200, "68 05 05 68 02 08 08 01 02 15 16");
        assert_eq!(rig.station.user.reported[2], Reported::Answer(Status::DataLow, vec![1, 2], 0), "{answer}");
    }
}

#[test]
fn the_failure_is_that_of_the_last_try() {
    const WRONG_FCS: &str = "68 05 05 68 02 08 08 01 02 16 16";
    const WRONG_SOURCE: &str = "68 05 05 68 02 09 08 01 02 16 16";
    let mismatch = Failure::Mismatch(Mismatch::Source(9));
    for (tries, failure) in [
        (["", ""], Failure::Silence),
        ([WRONG_FCS, WRONG_FCS], Failure::Damaged),
        ([WRONG_FCS, ""], Failure::Silence),
        ([WRONG_SOURCE, ""], Failure::Silence),
        ([WRONG_SOURCE, WRONG_FCS], Failure::Damaged),
        (["", WRONG_SOURCE], mismatch),
    ] {
        let mut rig = rig(&[EXCHANGE, EXCHANGE]);
        rig.next_request();
        rig.receive("E5");
        for answer in tries {
            rig.next_telegram();
            rig.receive(answer);
        }
        rig.next_telegram();
        assert_eq!(rig.station.user.reported[1], Reported::Failed(failure), "{tries:?}");
    }
}

#[test]
fn an_answer_may_come_before_the_report_that_the_request_was_sent() {
    let mut rig = rig(&[EXCHANGE, EXCHANGE]);
    rig.next_telegram();
    rig.next_telegram();
    let due = rig.station.wake_at().unwrap();
    assert!(rig.station.poll(due).is_some());
    let answered = due + 50;
    assert_eq!(rig.station.telegram(answered, &profivac_wire::Telegram::ShortAck), None);
    assert_eq!(rig.station.user.reported, [Reported::Answer(Status::NoReply, vec![], 0)]);
    rig.station.sent(answered + 20);
    assert_eq!(rig.station.wake_at(), Some(answered + 20 + 37));
}

#[test]
fn the_master_stops_sending_when_another_master_sends() {
    // After two of these, which skip this station, it has to enter the ring again; after the others it stays in the ring.
    for (foreign, claim) in [
        ("DC 03 03", "DC 02 02"),
        ("DC 02 03", "68 05 05 68 08 02 6D AA 55 76 16"),
        ("68 05 05 68 88 83 6D 3C 3E F2 16", "68 05 05 68 08 02 6D AA 55 76 16"),
        ("10 05 03 49 51 16", "68 05 05 68 08 02 6D AA 55 76 16"),
    ] {
        // The telegram arrives while the station waits for an answer.
        let mut rig = rig(&[EXCHANGE; 3]);
        rig.next_request();
        rig.receive_after(100, foreign);
        assert_eq!((rig.station.other_master(), rig.station.has_token()), (Some(3), false), "{foreign}");
        assert_eq!(rig.station.user.reported, [Reported::Failed(Failure::Interrupted)], "{foreign}");
        let received = rig.now;
        let sent = rig.next_telegram();
        assert_eq!((sent.start, sent.text().as_str()), (received + 3000, claim), "{foreign}");

        // The telegram arrives before the station sends.
        rig.receive_after(20, foreign);
        let received = rig.now;
        assert_eq!(rig.next_telegram().start, received + 3000, "{foreign}");
        // The station is alone again and continues.
        rig.next_telegram();
        rig.next_telegram();
        assert_eq!(rig.station.other_master(), None, "{foreign}");
        assert_eq!(rig.station.masters().collect::<Vec<_>>(), [2], "{foreign}");
    }
}

#[test]
fn impossible_addresses_in_a_token_are_noise() {
    let mut rig = rig(&[]);
    rig.next_telegram();
    for token in ["DC FF 03", "DC 03 FF", "DC 7F 7F"] {
        rig.receive_after(11, token);
        assert_eq!(rig.station.other_master(), None, "{token}");
    }
    let received = rig.now;
    let second = rig.next_telegram();
    assert_eq!((second.start, second.text().as_str()), (received + 37, "DC 02 02"));
}

#[test]
fn the_gap_is_polled_once_per_visit_and_then_after_g_target_rotation_times() {
    let mut rig = rig_with(BusParameters { gap_factor: 2, hsa: 10, rotation_tbit: 5000, ..bus() }, &[]);
    rig.next_telegram();
    rig.next_telegram();
    let mut begins = Vec::new();
    for _ in 0..2 {
        for address in [3, 4, 5, 6, 7, 8, 9, 10, 0, 1] {
            let mut poll = rig.next_telegram();
            if address == 3 {
                while poll.is_token() {
                    poll = rig.next_telegram();
                }
                begins.push(poll.start);
            }
            assert_eq!((poll.octets[3], poll.octets[1]), (0x49, address));
            match address {
                // In the second round no station is at 8 any more.
                8 if begins.len() == 1 => rig.receive("10 02 08 00 0A 16"),
                9 => rig.receive("10 02 09 10 1B 16"),
                // SC is no answer to FDL status.
                7 => rig.receive("E5"),
                _ => {}
            }
            assert!(rig.next_telegram().is_token(), "one request per visit");
        }
        let live: Vec<_> = rig.station.live_list().collect();
        let slave = [(8, StationType::Slave)].into_iter().filter(|_| begins.len() == 1);
        assert_eq!(live, slave.chain([(9, StationType::MasterNotReady)]).collect::<Vec<_>>());
    }
    // Ten FDL status requests, each with a token; then 2 x 5000 bit times until the next visit.
    let pause = begins[1] - begins[0];
    assert!((10_000 + 10 * 300..10_000 + 10 * 600).contains(&pause), "{pause}");
}

#[test]
fn an_interrupted_fdl_status_request_keeps_the_live_list() {
    let mut rig = rig_with(BusParameters { gap_factor: 1, rotation_tbit: 256, hsa: 3, ..bus() }, &[]);
    while rig.next_telegram().octets[1] != 3 {}
    rig.receive("10 02 03 10 15 16");
    assert_eq!(rig.station.live_list().count(), 1);
    while !matches!(rig.next_telegram().octets[..], [0x10, 3, ..]) {}
    rig.receive_after(100, "DC 04 04");
    assert_eq!(rig.station.live_list().count(), 1);
}

#[test]
fn low_priority_waits_for_the_end_of_the_high_one_and_for_hold_time() {
    // 400 bit times from token to token leave time for one exchange, and for none when the rotation before had one.
    let mut rig = rig_with(BusParameters { rotation_tbit: 400, ..bus() }, &[EXCHANGE; 4]);
    rig.station.user.low.push_back(Request { da: 9, ..EXCHANGE });
    let mut order = Vec::new();
    while rig.station.user.reported.len() < 5 {
        let sent = rig.next_telegram();
        if sent.octets[0] == 0x10 {
            continue;
        }
        order.push(sent.octets[0]);
        if sent.octets[0] == 0x68 {
            order.push(sent.octets[4]);
            rig.receive("E5");
        }
    }
    // One message of high priority per visit is always allowed; the station sends one of low priority when hold time is left.
    let (token, message) = (0xDC, 0x68);
    assert_eq!(order[..8], [token, token, message, 8, token, message, 8, token]);
    assert_eq!(order.last(), Some(&9));
    assert_eq!(order.iter().filter(|octet| **octet == 8).count(), 4);
}

#[test]
fn a_request_to_an_impossible_address_is_not_sent() {
    let own = Request { da: 2, ..EXCHANGE };
    let to_all = Request { da: 127, ..EXCHANGE };
    let beyond = Request { da: 128, ..CONTROL };
    let too_long = Request { du: &[0; 247], ..EXCHANGE };
    let mut rig = rig(&[own, to_all, beyond, too_long, EXCHANGE]);
    assert_eq!(rig.next_request().text(), "68 05 05 68 08 02 6D AA 55 76 16");
    assert_eq!(rig.station.user.reported, vec![Reported::Failed(Failure::Impossible); 4]);
}

#[test]
fn after_a_lost_port_the_master_begins_again() {
    let mut rig = rig(&[EXCHANGE, EXCHANGE]);
    rig.next_request();
    rig.station.listen(rig.now + 1_000_000);
    assert_eq!(rig.station.user.reported, [Reported::Failed(Failure::Interrupted)]);
    assert_eq!(rig.station.wake_at(), Some(rig.now + 1_003_000));
}
