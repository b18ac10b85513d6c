//! Right answers at a wrong time: late, or after another one.

use crate::case::{INPUTS, Station, THERE, all, cyclic, exchange, is_exchange, known, set_prm, tools};
use profivac_dp::master::EventKind;
use profivac_dp::master::services;

/// It comes when the master has given up and asks another station.
#[test]
fn a_late_answer_does_not_become_the_answer_to_the_next_request() {
    for case in cyclic() {
        let mut desk = (case.asked)();
        let before = known(&desk);
        desk.station.user.submit_request(&services::slave_diag(9)).unwrap();
        // Station 9 is asked once the cycle is over; whatever is asked of station 8 until then stays unanswered.
        while desk.asks().octets[4] & 0x7F != 9 {}
        desk.hears_octets(100, &case.right.octets());
        desk.says();
        let result = desk
            .station
            .user
            .take_confirmation()
            .map(|confirmation| services::diagnosis(&confirmation).unwrap_err().to_string());
        assert_eq!(result.as_deref(), Some("the answer came from station 8"), "{}", case.name);
        case.nothing_is_new(&desk, &before, "late");
    }
    for case in tools() {
        let mut desk = (case.asked)();
        let before = known(&desk);
        let tool = case.tool.unwrap();
        desk.station.user.submit_request(&tool.request).unwrap();
        desk.hears(INPUTS);
        // Unanswered, again and again, until the exchange is asked for.
        while !is_exchange(&desk.asks()) {}
        desk.hears_octets(100, &case.right.octets());
        // The exchange is asked for once more, and answered as it should.
        desk.asks();
        desk.hears(INPUTS);
        let result = desk
            .station
            .user
            .take_confirmation()
            .map(|confirmation| (tool.read)(&confirmation).unwrap_err().to_string());
        assert_eq!(result.as_deref(), Some("no answer"), "{}", case.name);
        // An acknowledgement is one to anything. It has no length of inputs, and so it is no value either.
        if case.right.fc == 9 {
            let trouble = desk.station.user.exchange_error(8).unwrap().to_string();
            assert_eq!((trouble.as_str(), known(&desk).inputs), ("its answer has 0 octets instead of 2", None));
        } else {
            case.nothing_is_new(&desk, &before, "late");
        }
    }
}

/// Two stations at one address, one slower than the other: the first answer is an answer, the second never is.
#[test]
fn the_second_answer_of_a_twin_is_nobodys() {
    for case in all() {
        let mut twin = case.right.clone();
        twin.du.iter_mut().rev().take(1).for_each(|octet| *octet ^= 0x40);
        let mut desk = (case.asked)();
        if let Some(tool) = &case.tool {
            desk.station.user.submit_request(&tool.request).unwrap();
            desk.hears(INPUTS);
            desk.asks();
        }
        desk.hears_octets(11, &case.right.octets());
        let before = known(&desk);
        while desk.station.user.next_event().is_some() {}
        // Within T_ID1, and a third one as well.
        desk.hears_octets(15, &twin.octets());
        desk.hears_octets(200, &twin.octets());
        assert_eq!(known(&desk), before, "{}", case.name);
        assert_eq!(strays(&mut desk), (2, 1), "{}: counted each time, told once", case.name);
        if let Some(tool) = &case.tool {
            let result = desk.station.user.take_confirmation().map(|confirmation| (tool.read)(&confirmation).unwrap());
            assert!(case.right.du.ends_with(&result.unwrap()), "{}", case.name);
        }
    }
}

/// How many answers to nothing slave 8 has given, and how many events tell of them.
fn strays(desk: &mut Station) -> (u32, usize) {
    let events = std::iter::from_fn(|| desk.station.user.next_event());
    let told = events.filter(|event| (event.address, event.kind) == (8, EventKind::Stray)).count();
    (desk.station.user.counters(8).unwrap().strays, told)
}

/// SC does not say who sends it: it counts for the slave that has just answered, and for nobody if none has.
#[test]
fn a_second_acknowledgement_counts_for_who_was_asked() {
    let mut desk = set_prm();
    desk.hears("E5");
    desk.hears_after(15, "E5");
    assert_eq!(strays(&mut desk), (1, 1));
    let mut desk = desk_in_pause();
    desk.hears_after(5, "E5");
    assert_eq!(strays(&mut desk), (0, 0));
}

/// The token has just come back, and nobody was asked since.
fn desk_in_pause() -> Station {
    let mut desk = exchange();
    desk.hears(INPUTS);
    while !desk.says().is_token() {}
    desk
}

#[test]
fn what_others_are_answered_is_no_second_answer() {
    let mut desk = exchange();
    desk.hears(INPUTS);
    // The same slave to master 3, and a slave that this master does not have.
    desk.hears_after(15, "68 05 05 68 03 08 08 01 02 16 16");
    desk.hears_after(15, "68 05 05 68 02 09 08 01 02 16 16");
    assert_eq!(strays(&mut desk), (0, 0));
}

/// A slave that was lost and comes back is another matter: the next second answer is told again.
#[test]
fn a_second_answer_is_told_again_after_the_slave_was_lost() {
    let mut desk = exchange();
    desk.hears(INPUTS);
    desk.hears_after(15, INPUTS);
    assert_eq!(strays(&mut desk), (1, 1));
    // It begins from the beginning.
    desk.station.user.restart(8);
    desk.asks();
    desk.hears(THERE);
    desk.hears_after(15, THERE);
    assert_eq!(strays(&mut desk), (2, 1));
}
