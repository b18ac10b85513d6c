//! The rules of the referee: for each a station that violates it, and one at the limit that does not.

use crate::common;

use common::*;
use profivac_dp::link::{Baud, BitTime, Station};
use profivac_dp::slave::Slave;
use profivac_sim::stations::{MockStation, Tester};
use profivac_sim::{Fault, Limits, Rule, Segment, TelegramFault, Violation};
use profivac_wire::{DataTelegram, Telegram};

const BAUD: Baud = Baud::B1500000;
/// FDL status of the slave, 66 bit times long.
const ASK: [u8; 6] = [0x10, TS, OWN, 0x49, 0x53, 0x16];
const ANSWER: [u8; 6] = [0x10, OWN, TS, 0x00, 0x0A, 0x16];

/// A segment with a tester that sends telegrams at given times.
fn segment_with(script: &[(u64, &[u8])]) -> Segment {
    let mut segment = Segment::new(BAUD);
    let tester = segment.attach(Tester::new());
    for (time, octets) in script {
        segment.station_mut(tester).send(BitTime(*time), octets);
    }
    segment
}

/// A station that answers every telegram with `octets` after `tsdr`.
fn answering(tsdr: u64, octets: &[u8]) -> impl Station + Send + 'static {
    let octets = octets.to_vec();
    MockStation::new(move |end, _| Some((end + tsdr, octets.clone())))
}

fn outcome(segment: &mut Segment) -> Result<(), Rule> {
    segment.run_until(BitTime(100_000)).map_err(|violation| violation.rule)
}

/// The result of a single request and an answer `tsdr` after it.
fn answered(tsdr: u64, octets: &[u8]) -> Result<(), Rule> {
    let mut segment = segment_with(&[(100, &ASK)]);
    segment.attach(answering(tsdr, octets));
    outcome(&mut segment)
}

/// The result of two telegrams of one master, the second `idle` bit times after the end of the first.
fn after(first: &[u8], idle: u64) -> Result<(), Rule> {
    let end = 100 + 11 * first.len() as u64;
    outcome(&mut segment_with(&[(100, first), (end + idle, &ASK)]))
}

#[test]
fn a_good_dialogue_passes() {
    assert_eq!(answered(11, &ANSWER), Ok(()));
    assert_eq!(answered(150, &ANSWER), Ok(()));
    assert_eq!(answered(11, &[0xE5]), Ok(()));
}

#[test]
fn a_collision_is_found() {
    let mut segment = segment_with(&[(100, &ASK)]);
    let other = segment.attach(Tester::new());
    segment.station_mut(other).send(BitTime(165), &ASK);
    assert_eq!(outcome(&mut segment), Err(Rule::Collision));
}

#[test]
fn a_collision_is_found_where_the_signals_meet() {
    // In the middle the signals do not overlap; at each end the other telegram arrives during the own transmission.
    for (distance, expected) in [(65, Err(Rule::Collision)), (66, Err(Rule::Syn))] {
        let mut segment = segment_with(&[(100, &ASK)]);
        let other = segment.attach_at(distance, Tester::new());
        segment.station_mut(other).send(BitTime(100), &ASK);
        assert_eq!(outcome(&mut segment), expected, "{distance} bit times apart");
    }
}

#[test]
fn a_transmission_during_an_arriving_telegram_is_a_collision() {
    // The first is sent from 100 to 166 and arrives at the other station from 150 to 216.
    for (begin, expected) in [(215, Err(Rule::Collision)), (216, Err(Rule::Syn))] {
        let mut segment = segment_with(&[(100, &ASK)]);
        let other = segment.attach_at(50, Tester::new());
        segment.station_mut(other).send(BitTime(begin), &ASK);
        assert_eq!(outcome(&mut segment), expected, "{begin}");
    }
}

#[test]
fn answers_of_two_slaves_at_one_address_are_a_collision() {
    let mut segment = segment_with(&[(100, &ASK)]);
    segment.attach(Slave::new(Plain::new(), TS, BAUD));
    segment.attach(Slave::new(Plain::new(), TS, BAUD));
    assert_eq!(outcome(&mut segment), Err(Rule::Collision));
}

#[test]
fn octets_that_are_no_telegram_are_found() {
    let mut altered = ASK;
    altered[4] += 1;
    for octets in [&altered[..], &ASK[..5], &[ASK, ASK].concat(), &[0x00]] {
        assert_eq!(outcome(&mut segment_with(&[(100, octets)])), Err(Rule::NoTelegram), "{octets:02X?}");
    }
}

#[test]
fn a_pause_inside_a_telegram_is_found() {
    for index in 1..6 {
        let mut segment = Segment::new(BAUD);
        let tester = segment.attach(Tester::new());
        segment.station_mut(tester).send(BitTime(100), &ASK);
        segment.inject(Fault::Telegram(tester.id(), TelegramFault::Pause(index, 1)));
        assert_eq!(outcome(&mut segment), Err(Rule::Gap));
    }
}

#[test]
fn a_request_within_t_syn_is_found() {
    assert_eq!(after(&[0xDC, OWN, OWN], 32), Err(Rule::Syn));
    assert_eq!(after(&[0xDC, OWN, OWN], 33), Err(Rule::Id1));
}

#[test]
fn a_token_within_t_syn_is_found() {
    let segment = &mut segment_with(&[(100, &[0xDC, OWN, OWN]), (133 + 32, &[0xDC, OWN, OWN])]);
    assert_eq!(outcome(segment), Err(Rule::Syn));
}

#[test]
fn a_request_within_t_id1_is_found_at_every_rate() {
    for (baud, t_id1) in Baud::ALL.into_iter().zip([37, 37, 225, 37, 37, 37, 37, 46, 57, 76]) {
        for (idle, expected) in [(t_id1 - 1, Err(Rule::Id1)), (t_id1, Ok(()))] {
            let mut segment = Segment::new(baud);
            segment.attach(answering(11, &ANSWER));
            let tester = segment.attach(Tester::new());
            segment.station_mut(tester).send(BitTime(100), &ASK);
            segment.station_mut(tester).send(BitTime(100 + 66 + 11 + 66 + idle), &ASK);
            assert_eq!(outcome(&mut segment), expected, "{baud}, {idle}");
        }
    }
}

#[test]
fn a_request_within_t_id1_after_a_token_is_found() {
    assert_eq!(after(&[0xDC, OWN, OWN], 36), Err(Rule::Id1));
    assert_eq!(after(&[0xDC, OWN, OWN], 37), Ok(()));
}

#[test]
fn a_request_within_t_id2_after_an_unconfirmed_one_is_found() {
    let all =
        emit(&Telegram::Data(DataTelegram { da: 127, sa: OWN, dsap: Some(58), ssap: Some(62), fc: 0x46, du: &[0, 0] }));
    assert_eq!(after(&all, 149), Err(Rule::Id2));
    assert_eq!(after(&all, 150), Ok(()));
}

#[test]
fn a_request_within_the_slot_time_is_found() {
    assert_eq!(after(&ASK, 299), Err(Rule::BeforeSlotTime));
    assert_eq!(after(&ASK, 300), Ok(()));
}

#[test]
fn an_answer_before_min_tsdr_is_found() {
    assert_eq!(answered(10, &ANSWER), Err(Rule::Early));
    assert_eq!(answered(0, &[0xE5]), Err(Rule::Early));
}

#[test]
fn an_answer_before_the_parameterised_min_tsdr_is_found_after_a_diagnosis_confirms_it() {
    // Set_Prm with min T_SDR 40, Slave_Diag, then FDL status, answered after `tsdr` each time.
    let talk = |tsdr: u64, diag: &'static [u8]| {
        let prm = request(OWN, FIRST, 61, &[0x80, 0, 0, 40, 0x12, 0x34, 0]);
        let ask_diag = request(OWN, FCB_0, 60, &[]);
        let mut segment = segment_with(&[(100, &prm), (1000, &ask_diag), (2000, &ASK)]);
        segment.attach(MockStation::new(move |end, telegram| {
            let Telegram::Data(data) = telegram else { return None };
            Some(match data.dsap {
                Some(61) => (end + 11, vec![0xE5]),
                Some(_) => {
                    let answer = DataTelegram { da: OWN, sa: TS, dsap: Some(62), ssap: Some(60), fc: 8, du: diag };
                    (end + 40, emit(&Telegram::Data(answer)))
                }
                None => (end + tsdr, ANSWER.to_vec()),
            })
        }));
        outcome(&mut segment)
    };
    let taken = &[0x02, 0x04, 0x00, OWN, 0x12, 0x34];
    assert_eq!(talk(39, taken), Err(Rule::Early));
    assert_eq!(talk(40, taken), Ok(()));
    assert_eq!(talk(11, &[0x42, 0x05, 0x00, 0xFF, 0x12, 0x34]), Ok(()), "the slave refused it");
}

/// The result of a Set_Prm with min T_SDR 40 to `TS`, a Slave_Diag that confirms it, and an FDL status that is answered after 11.
/// Between the last two a station is switched off and on: `TS` itself or the slave at address 9.
fn early_after_power_failure(of_itself: bool) -> Result<(), Rule> {
    let set_prm = request(OWN, FIRST, 61, &[0x80, 0, 0, 40, 0x12, 0x34, 0]);
    let mut segment =
        segment_with(&[(100, &set_prm), (1000, &request(OWN, FIRST, 60, &[])), (2000, &status(9, OWN)), (3000, &ASK)]);
    let itself = segment.attach(MockStation::new(|end, telegram: &Telegram<'_>| {
        let Telegram::Data(request) = telegram else { return None };
        let diag =
            DataTelegram { da: OWN, sa: TS, dsap: Some(62), ssap: Some(60), fc: 8, du: &[2, 4, 0, OWN, 0x12, 0x34] };
        match (request.da, request.dsap) {
            (TS, Some(61)) => Some((end + 11, vec![0xE5])),
            (TS, Some(_)) => Some((end + 40, emit(&Telegram::Data(diag)))),
            (TS, None) => Some((end + 11, ANSWER.to_vec())),
            _ => None,
        }
    }));
    let other = segment.attach(Slave::new(Plain::new(), 9, BAUD));
    let failing = if of_itself { itself.id() } else { other.id() };
    segment.schedule_fault(BitTime(2500), Fault::Power(failing, false));
    segment.schedule_fault(BitTime(2600), Fault::Power(failing, true));
    outcome(&mut segment)
}

#[test]
fn a_power_failure_resets_the_min_tsdr_of_that_slave_only() {
    assert_eq!(early_after_power_failure(true), Ok(()));
    assert_eq!(early_after_power_failure(false), Err(Rule::Early));
}

#[test]
fn an_answer_after_max_tsdr_is_found_at_every_rate() {
    for (baud, max) in Baud::ALL.into_iter().zip([60, 60, 60, 60, 60, 100, 150, 250, 450, 800]) {
        for (tsdr, expected) in [(max, Ok(())), (max + 1, Err(Rule::Late))] {
            let mut segment = Segment::new(baud);
            segment.attach(answering(tsdr, &ANSWER));
            let tester = segment.attach(Tester::new());
            segment.station_mut(tester).send(BitTime(100), &ASK);
            assert_eq!(outcome(&mut segment), expected, "{baud}, {tsdr}");
        }
    }
}

#[test]
fn an_answer_after_the_slot_time_is_found() {
    // Max T_SDR does not limit here; the first character must end within 300 bit times.
    for (tsdr, expected) in [(289, Ok(())), (290, Err(Rule::Slot))] {
        let mut segment = segment_with(&[(100, &ASK)]);
        segment.set_limits(Limits { max_tsdr_tbit: 1000, ..Limits::of(BAUD) });
        segment.attach(answering(tsdr, &ANSWER));
        assert_eq!(outcome(&mut segment), expected, "{tsdr}");
    }
}

#[test]
fn propagation_delay_counts_for_the_slot_time_and_not_for_tsdr() {
    for (position, expected) in [(69, Ok(())), (70, Err(Rule::Slot))] {
        let mut segment = segment_with(&[(100, &ASK)]);
        segment.attach_at(position, answering(150, &ANSWER));
        assert_eq!(outcome(&mut segment), expected, "{position}");
    }
}

#[test]
fn an_answer_without_a_request_is_found() {
    assert_eq!(outcome(&mut segment_with(&[(100, &[0xE5])])), Err(Rule::Unrequested));
    assert_eq!(outcome(&mut segment_with(&[(100, &ANSWER)])), Err(Rule::Unrequested));
    // After a token, after a request to all stations, after a request without answer.
    for octets in [&[0xDC, TS, OWN][..], &[0x10, 127, OWN, 0x46, 0xC7, 0x16], &[0x10, TS, OWN, 0x46, 0x50, 0x16]] {
        let mut segment = segment_with(&[(100, octets)]);
        segment.attach(answering(11, &ANSWER));
        assert_eq!(outcome(&mut segment), Err(Rule::Unrequested), "{octets:02X?}");
    }
}

#[test]
fn an_answer_from_or_to_the_wrong_station_is_found() {
    assert_eq!(answered(11, &[0x10, OWN, 9, 0x00, 0x0B, 0x16]), Err(Rule::Unrequested));
    assert_eq!(answered(11, &[0x10, OTHER, TS, 0x00, 0x0B, 0x16]), Err(Rule::Unrequested));
}

#[test]
fn a_second_answer_is_found() {
    let mut segment = segment_with(&[(100, &ASK)]);
    segment.attach(answering(11, &ANSWER));
    segment.attach(answering(120, &ANSWER));
    assert_eq!(outcome(&mut segment), Err(Rule::SecondAnswer));
}

/// A request of `sa` for the FDL status of `da`, 66 bit times long.
fn status(da: u8, sa: u8) -> Vec<u8> {
    emit(&Telegram::Data(DataTelegram { da, sa, dsap: None, ssap: None, fc: 0x49, du: &[] }))
}

/// The result of `octets` after `idle` bit times, after the token was passed to `OTHER`.
fn after_the_token(octets: &[u8], idle: u64) -> Result<(), Rule> {
    outcome(&mut segment_with(&[(100, &[0xDC, OTHER, OWN]), (133 + idle, octets)]))
}

#[test]
fn a_request_without_the_token_is_found() {
    // T_SL is 300, and T_TO of OWN (address 2) is ten times that.
    assert_eq!(after_the_token(&status(TS, OTHER), 40), Ok(()));
    for (idle, expected) in [(40, Err(Rule::NoToken)), (2999, Err(Rule::NoToken)), (3000, Ok(()))] {
        assert_eq!(after_the_token(&status(TS, OWN), idle), expected, "{idle}");
    }
    // The holder of the token may send repeatedly, other stations may not.
    for (sa, expected) in [(OTHER, Ok(())), (OWN, Err(Rule::NoToken))] {
        let mut segment =
            segment_with(&[(100, &[0xDC, OTHER, OWN]), (200, &status(TS, OTHER)), (700, &status(TS, sa))]);
        assert_eq!(outcome(&mut segment), expected, "{sa}");
    }
}

#[test]
fn a_second_token_is_found() {
    const AGAIN: [u8; 3] = [0xDC, OTHER, OWN];
    // The token may be sent again after T_SL, while the receiver has not sent.
    for (idle, expected) in [(299, Err(Rule::SecondToken)), (300, Ok(()))] {
        assert_eq!(after_the_token(&AGAIN, idle), expected, "{idle}");
    }
    let mut segment = segment_with(&[(100, &AGAIN), (200, &status(TS, OTHER)), (700, &AGAIN)]);
    assert_eq!(outcome(&mut segment), Err(Rule::SecondToken));
    // A third station may claim the token after its T_TO of 6 + 2 x 9 slot times.
    for (idle, expected) in [(7199, Err(Rule::SecondToken)), (7200, Ok(()))] {
        assert_eq!(after_the_token(&[0xDC, 9, 9], idle), expected, "{idle}");
    }
}

#[test]
fn the_holder_is_unknown_after_a_damaged_token() {
    let mut segment = Segment::new(BAUD);
    let tester = segment.attach(Tester::new());
    segment.inject(Fault::Telegram(tester.id(), TelegramFault::Flip(vec![12, 13])));
    segment.station_mut(tester).send(BitTime(100), &[0xDC, OTHER, OWN]);
    segment.station_mut(tester).send(BitTime(200), &status(TS, 9));
    assert_eq!(outcome(&mut segment), Ok(()));
}

#[test]
fn a_telegram_cut_short_by_a_power_failure_counts_up_to_the_cut() {
    // The token ends after two of its three characters: station 3 does not receive it, and T_TO of 2 begins at the cut.
    for (begin, expected) in [(122 + 32, Err(Rule::Syn)), (122 + 300, Ok(()))] {
        let mut segment = segment_with(&[(begin, &status(TS, OWN))]);
        let victim = segment.attach(Tester::new());
        segment.station_mut(victim).send(BitTime(100), &[0xDC, OTHER, OWN]);
        segment.schedule_fault(BitTime(122), Fault::Power(victim.id(), false));
        assert_eq!(outcome(&mut segment), expected, "{begin}");
    }
}

#[test]
fn a_token_outside_the_expected_ring_is_found() {
    for (tokens, expected) in [
        (&[[2, 3], [3, 9], [9, 2]][..], Ok(())),
        (&[[2, 9]], Err(Rule::Ring)),
        (&[[3, 2]], Err(Rule::Ring)),
        (&[[9, 9]], Err(Rule::Ring)),
        (&[[5, 9]], Err(Rule::Ring)),
    ] {
        let script: Vec<(u64, [u8; 3])> =
            (1..).zip(tokens).map(|(index, [sa, da])| (1000 * index, [0xDC, *da, *sa])).collect();
        let script: Vec<(u64, &[u8])> = script.iter().map(|(time, octets)| (*time, &octets[..])).collect();
        let mut segment = segment_with(&script);
        segment.expect_ring(&[9, 3, 2], BitTime(1000));
        assert_eq!(outcome(&mut segment), expected, "{tokens:?}");
        // Before and after the expectation any receiver of the token is accepted.
        for (ring, from) in [(&[9, 3, 2][..], 3001), (&[], 0)] {
            let mut segment = segment_with(&script);
            segment.expect_ring(ring, BitTime(from));
            assert_eq!(outcome(&mut segment), Ok(()), "{tokens:?}");
        }
    }
}

#[test]
fn a_rule_that_is_disallowed_again_is_found() {
    let mut segment = segment_with(&[(100, &[0xDC, OTHER, OWN]), (200, &status(TS, OWN)), (1000, &status(TS, OTHER))]);
    segment.allow(Rule::NoToken);
    segment.run_until(BitTime(900)).unwrap();
    segment.disallow(Rule::NoToken);
    assert_eq!(outcome(&mut segment), Err(Rule::NoToken));
}

#[test]
fn a_violation_shows_the_trace() {
    let mut segment = segment_with(&[(100, &ASK)]);
    let slave = segment.attach(answering(10, &ANSWER));
    let violation: Violation = *segment.run_until(BitTime(100_000)).unwrap_err();
    assert_eq!(
        (violation.station, violation.at, violation.measured_tbit, violation.limit_tbit),
        (slave.id(), BitTime(176), 10, 11)
    );
    let report: Vec<String> = violation.to_string().lines().map(squeezed).collect();
    assert_eq!(
        report,
        [
            "bit time 176, station #1: it answered after 10 bit times, min T_SDR is 11",
            "100 2 -> 8 FDL_Status ? | 10 08 02 49 53 16",
            "176 +10 8 -> 2 OK, passive station | 10 02 08 00 0A 16",
        ]
    );
}

fn squeezed(line: &str) -> String {
    line.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn an_allowed_violation_does_not_end_the_run() {
    let mut segment = segment_with(&[(100, &ASK)]);
    segment.attach(answering(10, &ANSWER));
    segment.allow(Rule::Early);
    assert_eq!(outcome(&mut segment), Ok(()));
    assert_eq!(segment.trace().entries.len(), 2);
}

#[test]
fn violations_of_an_exempt_station_are_ignored_and_those_of_others_are_found() {
    let mut segment = Segment::new(BAUD);
    let tester = segment.attach(Tester::new());
    segment.station_mut(tester).send(BitTime(100), &[0x00]);
    segment.station_mut(tester).send(BitTime(120), &ASK);
    segment.exempt(tester.id());
    assert_eq!(outcome(&mut segment), Ok(()));
    let mut segment = segment_with(&[(100, &ASK)]);
    let slave = segment.attach(answering(10, &ANSWER));
    segment.exempt(Segment::new(BAUD).attach(Tester::new()).id());
    assert_eq!(segment.run_until(BitTime(1000)).map_err(|violation| violation.station), Err(slave.id()));
}
