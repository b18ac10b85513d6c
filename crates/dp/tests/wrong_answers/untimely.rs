//! Right answers at a wrong time: late, or after another one.

use super::case::{INPUTS, Station, THERE, all, class2_cases, cyclic, exchange, is_exchange, known, set_prm};
use profivac_dp::master::EventKind;
use profivac_dp::master::services;

/// The late answer arrives while the master waits for another station.
#[test]
fn a_late_answer_does_not_become_the_answer_to_the_next_request() {
    for case in cyclic() {
        let mut rig = (case.asked)();
        let before = known(&rig);
        rig.station.user.submit_request(&services::slave_diag(9)).unwrap();
        // The request to station 9 follows the cycle; requests to station 8 until then stay unanswered.
        while rig.next_request().octets[4] & 0x7F != 9 {}
        rig.receive_octets(100, &case.right.octets());
        rig.next_telegram();
        let result = rig
            .station
            .user
            .take_confirmation()
            .map(|confirmation| services::diagnosis(&confirmation).unwrap_err().to_string());
        assert_eq!(result.as_deref(), Some("the answer came from station 8"), "{}", case.name);
        case.nothing_is_new(&rig, &before, "late");
    }
    for case in class2_cases() {
        let mut rig = (case.asked)();
        let before = known(&rig);
        let class2 = case.class2.unwrap();
        rig.station.user.submit_request(&class2.request).unwrap();
        rig.receive(INPUTS);
        // The request and its repetitions stay unanswered until the next Data_Exchange.
        while !is_exchange(&rig.next_request()) {}
        rig.receive_octets(100, &case.right.octets());
        // The master repeats Data_Exchange and gets the right answer.
        rig.next_request();
        rig.receive(INPUTS);
        let result = rig
            .station
            .user
            .take_confirmation()
            .map(|confirmation| (class2.read)(&confirmation).unwrap_err().to_string());
        assert_eq!(result.as_deref(), Some("no answer"), "{}", case.name);
        // SC is valid as an acknowledgement of any request. It has no inputs, so it changes no value.
        if case.right.fc == 9 {
            let error = rig.station.user.exchange_error(8).unwrap().to_string();
            assert_eq!((error.as_str(), known(&rig).inputs), ("its answer has 0 octets instead of 2", None));
        } else {
            case.nothing_is_new(&rig, &before, "late");
        }
    }
}

/// Two stations at one address, one slower than the other: the master takes the first answer and drops the second.
#[test]
fn a_second_answer_from_the_same_address_is_dropped() {
    for case in all() {
        let mut duplicate = case.right.clone();
        duplicate.du.iter_mut().rev().take(1).for_each(|octet| *octet ^= 0x40);
        let mut rig = (case.asked)();
        if let Some(class2) = &case.class2 {
            rig.station.user.submit_request(&class2.request).unwrap();
            rig.receive(INPUTS);
            rig.next_request();
        }
        rig.receive_octets(11, &case.right.octets());
        let before = known(&rig);
        while rig.station.user.next_event().is_some() {}
        // Within T_ID1, and a third answer later.
        rig.receive_octets(15, &duplicate.octets());
        rig.receive_octets(200, &duplicate.octets());
        assert_eq!(known(&rig), before, "{}", case.name);
        assert_eq!(strays(&mut rig), (2, 1), "{}: counted each time, reported once", case.name);
        if let Some(class2) = &case.class2 {
            let result = rig.station.user.take_confirmation().map(|confirmation| (class2.read)(&confirmation).unwrap());
            assert!(case.right.du.ends_with(&result.unwrap()), "{}", case.name);
        }
    }
}

/// The number of stray answers of slave 8, and the number of events about them.
fn strays(rig: &mut Station) -> (u32, usize) {
    let events = std::iter::from_fn(|| rig.station.user.next_event());
    let reported = events.filter(|event| (event.address, event.kind) == (8, EventKind::Stray)).count();
    (rig.station.user.counters(8).unwrap().strays, reported)
}

/// SC has no address: it counts for the slave that answered last, and for none if none answered.
#[test]
fn a_second_acknowledgement_counts_for_the_slave_that_answered_last() {
    let mut rig = set_prm();
    rig.receive("E5");
    rig.receive_after(15, "E5");
    assert_eq!(strays(&mut rig), (1, 1));
    let mut rig = rig_in_pause();
    rig.receive_after(5, "E5");
    assert_eq!(strays(&mut rig), (0, 0));
}

/// The token has just come back, and no request was sent since.
fn rig_in_pause() -> Station {
    let mut rig = exchange();
    rig.receive(INPUTS);
    while !rig.next_telegram().is_token() {}
    rig
}

#[test]
fn an_answer_to_another_master_is_no_second_answer() {
    let mut rig = exchange();
    rig.receive(INPUTS);
    // An answer of the same slave to master 3, and an answer of an unknown slave.
    rig.receive_after(15, "68 05 05 68 03 08 08 01 02 16 16");
    rig.receive_after(15, "68 05 05 68 02 09 08 01 02 16 16");
    assert_eq!(strays(&mut rig), (0, 0));
}

/// After a slave was lost and found again, the next second answer is reported again.
#[test]
fn a_second_answer_is_reported_again_after_the_slave_was_lost() {
    let mut rig = exchange();
    rig.receive(INPUTS);
    rig.receive_after(15, INPUTS);
    assert_eq!(strays(&mut rig), (1, 1));
    // The bring-up starts again.
    rig.station.user.restart(8);
    rig.next_request();
    rig.receive(THERE);
    rig.receive_after(15, THERE);
    assert_eq!(strays(&mut rig), (2, 1));
}
