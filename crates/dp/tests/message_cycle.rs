//! The active station by itself: when it speaks, what it repeats, and whose answers it takes. profibus-wire 1.10, 1.12, 1.13.

mod support;

use profivac_dp::link::active::{
    Active, Answer, BusParameters, Confirmation, Failure, FdlUser, Mismatch, Priority, Request,
};
use profivac_dp::link::{BitTime, Station};
use profivac_dp::master::services;
use profivac_wire::control::{Function, StationType, Status};
use std::collections::VecDeque;
use support::bus;
use support::desk::Desk;

/// What a layer above is told, without borrowing.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Told {
    Sent,
    Answer(Status, Vec<u8>, u8),
    Failed(Failure),
}

/// A layer above that has a list of requests: each of the first goes as high priority, the others as low.
#[derive(Default)]
struct List {
    high: VecDeque<Request<'static>>,
    low: VecDeque<Request<'static>>,
    sent: Option<Request<'static>>,
    told: Vec<Told>,
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
        self.told.push(match confirmation {
            Confirmation::Sent => Told::Sent,
            Confirmation::Answer(Answer { status, du, retries, .. }) => Told::Answer(status, du.to_vec(), retries),
            Confirmation::Failed(failure) => Told::Failed(failure),
        });
    }
}

const EXCHANGE: Request<'static> =
    Request { da: 8, function: Function::SrdHigh, dsap: None, ssap: None, du: &[0xAA, 0x55] };
const CONTROL: Request<'static> =
    Request { da: 127, function: Function::SdnHigh, dsap: Some(58), ssap: Some(62), du: &[0, 0] };

fn desk(requests: &[Request<'static>]) -> Desk<List> {
    desk_with(bus(), requests)
}

fn desk_with(bus: BusParameters, requests: &[Request<'static>]) -> Desk<List> {
    let list = List { high: requests.iter().copied().collect(), ..List::default() };
    Desk::new(Active::new(bus, list, BitTime(0)))
}

#[test]
fn a_silent_line_is_claimed_after_t_to_with_two_tokens() {
    let mut desk = desk(&[]);
    // T_TO = 6 T_SL + 2 x 2 T_SL, with T_SL = 300; three characters per token, T_ID1 = 37 after each.
    assert_eq!(desk.station.wake_at(), Some(BitTime(3000)));
    assert_eq!(desk.station.poll(BitTime(2999)), None);
    for (start, telegram) in [(0, "DC 02 02"), (33 + 37, "DC 02 02"), (2 * (33 + 37), "10 00 02 49 4B 16")] {
        let said = desk.says();
        assert_eq!((said.start, said.text().as_str()), (BitTime(3000 + start), telegram));
    }
    assert!(desk.station.has_token());
}

#[test]
fn whatever_is_heard_puts_off_the_claim() {
    let mut desk = desk(&[]);
    desk.hears_after(2000, "E5");
    assert_eq!(desk.station.wake_at(), Some(BitTime(2011 + 3000)));
    desk.hears_after(2989, "FF");
    assert_eq!(desk.says().start, BitTime(2011 + 2989 + 11 + 3000));
}

#[test]
fn the_idle_time_after_an_answer_is_t_id1_and_after_an_unanswered_message_t_id2() {
    let mut desk = desk(&[EXCHANGE, EXCHANGE, CONTROL, EXCHANGE]);
    assert_eq!(desk.asks().text(), "68 05 05 68 08 02 6D AA 55 76 16");
    desk.hears_after(11, "68 05 05 68 02 08 08 01 02 15 16");
    let answered = desk.now;
    let second = desk.says();
    assert_eq!((second.start, second.text().as_str()), (answered + 37, "68 05 05 68 08 02 5D AA 55 66 16"));
    desk.hears_after(60, "E5");
    let answered = desk.now;
    let control = desk.says();
    assert_eq!((control.start, control.text().as_str()), (answered + 37, "68 07 07 68 FF 82 46 3A 3E 00 00 3F 16"));
    let left = desk.now;
    let third = desk.says();
    assert_eq!((third.start, third.text().as_str()), (left + 150, "68 05 05 68 08 02 7D AA 55 86 16"));
    desk.hears_after(11, "E5");
    let answered = desk.now;
    let gap = desk.says();
    assert_eq!((gap.start, gap.text().as_str()), (answered + 37, "10 00 02 49 4B 16"));
    let left = desk.now;
    let token = desk.says();
    assert_eq!((token.start, token.text().as_str()), (left + 300, "DC 02 02"));
    let data = |du: &[u8]| Told::Answer(Status::DataLow, du.to_vec(), 0);
    let nothing = || Told::Answer(Status::NoReply, vec![], 0);
    assert_eq!(desk.station.user.told, [data(&[1, 2]), nothing(), Told::Sent, nothing()]);
}

#[test]
fn every_wait_follows_the_parameters() {
    let slow = BusParameters { slot_tbit: 20_000, setup_tbit: 40, token_idle_tbit: Some(500), ..bus() };
    let mut desk = desk_with(slow, &[EXCHANGE, EXCHANGE]);
    assert_eq!(desk.says().start, BitTime(200_000));
    let claimed = desk.now;
    assert_eq!(desk.says().start, claimed + 500);
    desk.asks();
    // The first character ends in the last bit time of T_SL, and the answer is taken.
    desk.hears_after(20_000 - 11, "E5");
    let answered = desk.now;
    // T_SM = 2 + 2 x 40, T_ID1 = 33 + T_SM
    assert_eq!(desk.says().start, answered + 115);
    let left = desk.now;
    assert_eq!(desk.says().start, left + 20_000);
}

#[test]
fn a_missing_answer_is_asked_for_again_with_the_same_telegram_after_t_sl() {
    let mut desk = desk(&[EXCHANGE, EXCHANGE]);
    desk.asks();
    desk.hears("E5");
    let first = desk.says();
    let left = desk.now;
    let again = desk.says();
    assert_eq!(again.octets, first.octets);
    assert_eq!(again.start, left + 300);
    desk.hears("E5");
    assert_eq!(desk.station.user.told[1], Told::Answer(Status::NoReply, vec![], 1));
}

#[test]
fn a_damaged_answer_is_asked_for_again_with_the_same_telegram() {
    let mut desk = desk(&[EXCHANGE, EXCHANGE, EXCHANGE]);
    desk.asks();
    desk.hears("E5");
    let first = desk.says();
    desk.hears("68 05 05 68 02 08 08 01 03 15 16");
    let heard = desk.now;
    let again = desk.says();
    assert_eq!((again.start, &again.octets), (heard + 300, &first.octets));
    desk.hears("68 05 05 68 02 08 08 01 02 15 16");
    assert_eq!(desk.station.user.told[1], Told::Answer(Status::DataLow, vec![1, 2], 1));
    // A second answer to the repeated request would look like the answer to the next one: it has two slot times to come in.
    desk.hears_after(289, "68 05 05 68 02 08 08 01 02 15 16");
    assert_eq!(desk.station.wake_at(), Some(desk.now + 600));
    assert_eq!(desk.says().text(), "68 05 05 68 08 02 7D AA 55 86 16");
    assert_eq!(desk.station.user.told.len(), 2);
}

#[test]
fn answers_that_are_always_late_are_never_taken_for_others() {
    // The slave takes 400 bit times, and T_SL is 300: every answer comes after its request was repeated.
    let mut desk = desk(&[EXCHANGE; 8]);
    desk.asks();
    desk.hears("E5");
    for round in 1..8 {
        // Two requests, two answers; the first answer comes 100 bit times after the second request.
        assert_eq!(desk.says().octets[0], 0x68);
        let repeated = desk.says();
        assert_eq!(repeated.octets[0], 0x68);
        let du = format!("{round:02X}");
        let answer = format!("68 04 04 68 02 08 08 {du} {:02X} 16", 0x12 + round);
        desk.hears_after(100, &answer);
        assert_eq!(desk.station.user.told.last(), Some(&Told::Answer(Status::DataLow, vec![round], 1)));
        // The second one: as long after the first as the second request after the first.
        desk.hears_after(repeated.octets.len() as u64 * 11 + 300 - 110, &answer);
    }
    assert_eq!(desk.station.user.told.len(), 8);
}

#[test]
fn a_late_answer_between_two_requests_asks_for_silence() {
    let mut desk = desk(&[EXCHANGE, EXCHANGE]);
    desk.asks();
    desk.hears("E5");
    desk.hears_after(20, "68 05 05 68 02 08 08 01 02 15 16");
    assert_eq!(desk.station.wake_at(), Some(desk.now + 300));
    assert_eq!(desk.station.user.told.len(), 1);
}

#[test]
fn an_answer_that_has_begun_is_waited_for_but_not_for_ever() {
    let mut desk = desk(&[EXCHANGE, EXCHANGE, EXCHANGE]);
    desk.asks();
    desk.hears("E5");
    desk.says();
    // The first character comes at the last moment; the telegram ends long after T_SL.
    let answer = {
        let mut octets = vec![0x68, 0xF7, 0xF7, 0x68, 2, 8, 8];
        octets.extend([7; 244]);
        let fcs = octets[4..].iter().fold(0u8, |sum, octet| sum.wrapping_add(*octet));
        octets.extend([fcs, 0x16]);
        octets
    };
    desk.hears_octets(289, &answer);
    assert_eq!(desk.station.user.told[1], Told::Answer(Status::DataLow, vec![7; 244], 0));

    // A line that is never quiet ends the patience: the station listens, and does not talk over it.
    desk.says();
    for _ in 0..1000 {
        desk.hears_after(11, "FF");
        assert_eq!(desk.station.poll(desk.now), None);
    }
    assert!(!desk.station.has_token());
    assert_eq!(desk.station.user.told[2], Told::Failed(Failure::Interrupted));
    let quiet = desk.now;
    assert_eq!(desk.says().start, quiet + 3000);
}

#[test]
fn after_giving_up_the_next_request_is_a_first_contact_without_a_retry() {
    let mut desk = desk(&[EXCHANGE; 5]);
    assert_eq!(desk.asks().octets[6], 0x6D);
    // Nobody is operational at first: one try.
    assert_eq!(desk.asks().octets[6], 0x6D);
    desk.hears("E5");
    assert_eq!(desk.says().octets[6], 0x5D);
    assert_eq!(desk.says().octets[6], 0x5D);
    assert_eq!(desk.says().octets[6], 0x6D, "one retry, then the first contact again");
    desk.hears("E5");
    assert_eq!(desk.says().octets[6], 0x5D);
    desk.hears("E5");
    let sent = || Told::Answer(Status::NoReply, vec![], 0);
    let silence = || Told::Failed(Failure::Silence);
    assert_eq!(desk.station.user.told, [silence(), sent(), silence(), sent(), sent()]);
}

#[test]
fn the_retry_limit_is_a_parameter() {
    for (retry_limit, tries) in [(0, 1), (1, 2), (4, 5)] {
        let mut desk = desk_with(BusParameters { retry_limit, ..bus() }, &[EXCHANGE, EXCHANGE]);
        desk.asks();
        desk.hears("E5");
        let mut said = 0;
        while desk.station.user.told.len() == 1 {
            said += usize::from(desk.says().octets[0] == 0x68);
        }
        assert_eq!(said, tries);
    }
}

#[test]
fn any_valid_answer_toggles_the_one_bit_of_the_station_and_nothing_else_does() {
    let other = Request { da: 9, ..EXCHANGE };
    let mut desk = desk(&[
        services::slave_diag(8),
        services::get_cfg(8),
        other,
        EXCHANGE,
        services::fdl_status(8),
        CONTROL,
        services::slave_diag(8),
        EXCHANGE,
    ]);
    desk.dialogue(
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
    assert_eq!(desk.station.user.told.len(), 8);
}

#[test]
fn an_answer_to_something_else_is_no_answer() {
    for (answer, mismatch) in [
        ("68 05 05 68 02 09 08 01 02 16 16", Mismatch::Source(9)),
        ("68 05 05 68 03 08 08 01 02 16 16", Mismatch::Destination(3)),
        ("68 0B 0B 68 82 88 08 3E 3C 02 05 00 FF 12 34 D8 16", Mismatch::AccessPoint),
        ("10 02 08 00 0A 16", Mismatch::Function(0)),
        ("68 05 05 68 02 08 03 01 02 10 16", Mismatch::Form),
    ] {
        // Wrong answers only: repeated, then failed with what was wrong.
        let mut desk = desk(&[EXCHANGE, EXCHANGE, EXCHANGE]);
        desk.asks();
        desk.hears("E5");
        for _ in 0..2 {
            assert_eq!(desk.says().octets[6], 0x5D, "{answer}");
            desk.hears(answer);
        }
        assert_eq!(desk.says().octets[6], 0x6D, "{answer}");
        assert_eq!(desk.station.user.told[1], Told::Failed(Failure::Mismatch(mismatch)), "{answer}");

        // The right one after it is still in time.
        desk.hears(answer);
        desk.hears_after(200, "68 05 05 68 02 08 08 01 02 15 16");
        assert_eq!(desk.station.user.told[2], Told::Answer(Status::DataLow, vec![1, 2], 0), "{answer}");
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
        let mut desk = desk(&[EXCHANGE, EXCHANGE]);
        desk.asks();
        desk.hears("E5");
        for answer in tries {
            desk.says();
            desk.hears(answer);
        }
        desk.says();
        assert_eq!(desk.station.user.told[1], Told::Failed(failure), "{tries:?}");
    }
}

#[test]
fn an_answer_may_be_faster_than_the_news_that_the_request_has_left() {
    let mut desk = desk(&[EXCHANGE, EXCHANGE]);
    desk.says();
    desk.says();
    let due = desk.station.wake_at().unwrap();
    assert!(desk.station.poll(due).is_some());
    let answered = due + 50;
    assert_eq!(desk.station.telegram(answered, &profivac_wire::Telegram::ShortAck), None);
    assert_eq!(desk.station.user.told, [Told::Answer(Status::NoReply, vec![], 0)]);
    desk.station.sent(answered + 20);
    assert_eq!(desk.station.wake_at(), Some(answered + 20 + 37));
}

#[test]
fn another_master_is_left_the_line() {
    // Two of these go past us, so that a new ring has to be made; after the others the old one is taken up again.
    for (foreign, claim) in [
        ("DC 03 03", "DC 02 02"),
        ("DC 02 03", "68 05 05 68 08 02 6D AA 55 76 16"),
        ("68 05 05 68 88 83 6D 3C 3E F2 16", "68 05 05 68 08 02 6D AA 55 76 16"),
        ("10 05 03 49 51 16", "68 05 05 68 08 02 6D AA 55 76 16"),
    ] {
        // While it waits for an answer.
        let mut desk = desk(&[EXCHANGE; 3]);
        desk.asks();
        desk.hears_after(100, foreign);
        assert_eq!((desk.station.other_master(), desk.station.has_token()), (Some(3), false), "{foreign}");
        assert_eq!(desk.station.user.told, [Told::Failed(Failure::Interrupted)], "{foreign}");
        let heard = desk.now;
        let said = desk.says();
        assert_eq!((said.start, said.text().as_str()), (heard + 3000, claim), "{foreign}");

        // While it is about to speak.
        desk.hears_after(20, foreign);
        let heard = desk.now;
        assert_eq!(desk.says().start, heard + 3000, "{foreign}");
        // Alone again: it goes on where it was.
        desk.says();
        desk.says();
        assert_eq!(desk.station.other_master(), None, "{foreign}");
        assert_eq!(desk.station.masters().collect::<Vec<_>>(), [2], "{foreign}");
    }
}

#[test]
fn impossible_addresses_in_a_token_are_noise() {
    let mut desk = desk(&[]);
    desk.says();
    for token in ["DC FF 03", "DC 03 FF", "DC 7F 7F"] {
        desk.hears_after(11, token);
        assert_eq!(desk.station.other_master(), None, "{token}");
    }
    let heard = desk.now;
    let second = desk.says();
    assert_eq!((second.start, second.text().as_str()), (heard + 37, "DC 02 02"));
}

#[test]
fn the_gap_is_asked_once_per_visit_and_then_after_g_target_rotation_times() {
    let mut desk = desk_with(BusParameters { gap_factor: 2, hsa: 10, rotation_tbit: 5000, ..bus() }, &[]);
    desk.says();
    desk.says();
    let mut begins = Vec::new();
    for _ in 0..2 {
        for address in [3, 4, 5, 6, 7, 8, 9, 10, 0, 1] {
            let mut poll = desk.says();
            if address == 3 {
                while poll.is_token() {
                    poll = desk.says();
                }
                begins.push(poll.start);
            }
            assert_eq!((poll.octets[3], poll.octets[1]), (0x49, address));
            match address {
                // In the second round nobody is at 8 any more.
                8 if begins.len() == 1 => desk.hears("10 02 08 00 0A 16"),
                9 => desk.hears("10 02 09 10 1B 16"),
                // SC is no answer to FDL status.
                7 => desk.hears("E5"),
                _ => {}
            }
            assert!(desk.says().is_token(), "one question per visit");
        }
        let live: Vec<_> = desk.station.live_list().collect();
        let slave = [(8, StationType::Slave)].into_iter().filter(|_| begins.len() == 1);
        assert_eq!(live, slave.chain([(9, StationType::MasterNotReady)]).collect::<Vec<_>>());
    }
    // Ten questions, each with a token; then 2 x 5000 bit times until the next visit.
    let pause = begins[1] - begins[0];
    assert!((10_000 + 10 * 300..10_000 + 10 * 600).contains(&pause), "{pause}");
}

#[test]
fn a_question_that_another_master_interrupts_forgets_nobody() {
    let mut desk = desk_with(BusParameters { gap_factor: 1, rotation_tbit: 256, hsa: 3, ..bus() }, &[]);
    while desk.says().octets[1] != 3 {}
    desk.hears("10 02 03 10 15 16");
    assert_eq!(desk.station.live_list().count(), 1);
    while !matches!(desk.says().octets[..], [0x10, 3, ..]) {}
    desk.hears_after(100, "DC 04 04");
    assert_eq!(desk.station.live_list().count(), 1);
}

#[test]
fn low_priority_waits_for_the_end_of_the_high_one_and_for_hold_time() {
    // 400 bit times from token to token leave time for one exchange, and for none when the rotation before had one.
    let mut desk = desk_with(BusParameters { rotation_tbit: 400, ..bus() }, &[EXCHANGE; 4]);
    desk.station.user.low.push_back(Request { da: 9, ..EXCHANGE });
    let mut order = Vec::new();
    while desk.station.user.told.len() < 5 {
        let said = desk.says();
        if said.octets[0] == 0x10 {
            continue;
        }
        order.push(said.octets[0]);
        if said.octets[0] == 0x68 {
            order.push(said.octets[4]);
            desk.hears("E5");
        }
    }
    // One message of high priority per visit is always allowed; the low one goes when a visit has time and nothing else.
    let (token, message) = (0xDC, 0x68);
    assert_eq!(order[..8], [token, token, message, 8, token, message, 8, token]);
    assert_eq!(order.last(), Some(&9));
    assert_eq!(order.iter().filter(|octet| **octet == 8).count(), 4);
}

#[test]
fn nobody_is_asked_at_an_impossible_address() {
    let own = Request { da: 2, ..EXCHANGE };
    let everybody = Request { da: 127, ..EXCHANGE };
    let beyond = Request { da: 128, ..CONTROL };
    let too_long = Request { du: &[0; 247], ..EXCHANGE };
    let mut desk = desk(&[own, everybody, beyond, too_long, EXCHANGE]);
    assert_eq!(desk.asks().text(), "68 05 05 68 08 02 6D AA 55 76 16");
    assert_eq!(desk.station.user.told, vec![Told::Failed(Failure::Impossible); 4]);
}

#[test]
fn a_lost_port_makes_it_begin_again() {
    let mut desk = desk(&[EXCHANGE, EXCHANGE]);
    desk.asks();
    desk.station.listen(desk.now + 1_000_000);
    assert_eq!(desk.station.user.told, [Told::Failed(Failure::Interrupted)]);
    assert_eq!(desk.station.wake_at(), Some(desk.now + 1_003_000));
}
