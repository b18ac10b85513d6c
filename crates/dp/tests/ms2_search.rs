//! The search of the master for a connection that was left at a slave. profibus-wire 4.6.1 and 4.10.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "helpers of tests are tests")]

use crate::ms2_master::Stand::{Aborting, Searching};
use crate::ms2_master::{
    BAUD, Class2Rig, INITIATE_RES, MANAGER, answer, failed, message, open, opening, parameters, stand,
};
use crate::support::bus;
use profivac_dp::link::BitTime;
use profivac_dp::link::active::Failure;
use profivac_dp::master::{Cause, ConnectionEnd, Master, Ms2Parameters, Phase, Settings};
use profivac_wire::acyclic::AbortReason;
use profivac_wire::control::Status;

/// Answers the next message to each access point from 48 down to `last` with RS.
pub fn search_down_to(rig: &mut Class2Rig, last: u8) {
    for sap in (last..=48).rev() {
        let (asked, du) = message(&rig.next_request().octets);
        assert!(asked == sap && du.starts_with("58 "), "{du} to {asked} instead of an Abort to {sap}");
        answer(rig, sap, "RS");
    }
}

const LOST: ConnectionEnd = failed(AbortReason::Fdl(15), Cause::NoAnswer(Failure::Silence));
pub const CLOSED: ConnectionEnd = failed(AbortReason::Fdl(3), Cause::Status(Status::ServiceNotActivated));

/// The slave has a connection for the master, which does not know its access point: profibus-wire 4.6.1 and 4.10.
#[test]
fn after_a_lost_answer_of_the_resource_manager_each_access_point_is_sent_an_abort_until_one_accepts_it() {
    let (mut rig, connection) = opening();
    search_down_to(&mut rig, 41);
    assert_eq!(message(&rig.next_request().octets).0, 40);
    answer(&mut rig, 40, "SC");
    assert_eq!(rig.station.user.outcome(connection), Some(Err(LOST)));
    assert!(rig.next_request_within(40_000).is_none(), "the search is over");
}

/// An earlier program with this station address may have left a connection.
#[test]
fn a_closed_resource_manager_is_asked_again_when_the_search_has_freed_a_connection() {
    let (mut rig, connection) = opening();
    answer(&mut rig, 49, "RS");
    search_down_to(&mut rig, 48);
    assert_eq!(message(&rig.next_request().octets).0, 47);
    answer(&mut rig, 47, "SC");
    // The slave takes a moment until it offers the access point again.
    for _ in 0..3 {
        let (sap, du) = message(&rig.next_request().octets);
        assert!(sap == 49 && du.starts_with("57"), "{du} to {sap}");
        answer(&mut rig, 49, "RS");
    }
    rig.next_request();
    answer(&mut rig, 49, MANAGER);
    rig.next_request();
    answer(&mut rig, 48, INITIATE_RES);
    assert!(matches!(rig.station.user.outcome(connection), Some(Ok(_))));
}

/// The slave accepts an Abort, then nothing is free all the same. T is 5 s for every reaction of the user at the slave.
#[test]
fn a_resource_manager_that_stays_closed_after_an_accepted_abort_ends_the_connection_after_a_second() {
    let mut rig = Class2Rig::new(Master::on(bus().check().unwrap(), Settings::new(BAUD), BitTime(0)));
    let connection = rig.station.user.ms2_open(8, &Ms2Parameters::new(BAUD)).unwrap();
    rig.next_request();
    answer(&mut rig, 49, "RS");
    rig.next_request();
    answer(&mut rig, 48, "SC");
    let began = rig.now;
    let mut last = began;
    while rig.station.user.ms2_phase(connection) != Some(Phase::Ended) {
        last = rig.next_request().start;
        answer(&mut rig, 49, "RS");
    }
    // Between two requests the station also asks an address of the GAP.
    assert!((BAUD.tbit_of_ms(1000)..BAUD.tbit_of_ms(1100)).contains(&(last - began)), "{}", last - began);
    assert_eq!(rig.station.user.outcome(connection), Some(Err(CLOSED)));
}

/// The slave has accepted the Abort to 48, and its SC and the answer to the repetition are lost: the next Abort gets RS.
#[test]
fn a_search_with_an_abort_that_went_unanswered_asks_the_resource_manager_again() {
    for lost in 0..=2 {
        let (mut rig, connection) = opening();
        answer(&mut rig, 49, "RS");
        // The Abort and its repetition by the link layer.
        for _ in 0..lost {
            assert_eq!(message(&rig.next_request().octets).0, 48);
        }
        search_down_to(&mut rig, 0);
        let next = rig.next_request_within(40_000).map(|sent| message(&sent.octets).0);
        assert_eq!(next, (lost > 0).then_some(49), "{lost}");
        assert_eq!(rig.station.user.ms2_phase(connection) == Some(Phase::Ended), lost == 0, "{lost}");
    }
}

/// Only RS says that an access point is not the master's: 4.10.
#[test]
fn an_access_point_that_answers_an_abort_with_neither_sc_nor_rs_is_sent_it_again_a_limited_number_of_times() {
    for what in ["RR", "UE", "58 00 13", "DH 58 00 13"] {
        for is_for_reuse in [true, false] {
            let (mut rig, connection) = opening();
            if is_for_reuse {
                answer(&mut rig, 49, "RS");
            }
            // Without an answer, the Initiate is repeated by the link layer.
            while message(&rig.next_request().octets).0 != 48 {}
            for _ in 0..2 {
                answer(&mut rig, 48, what);
                assert_eq!(message(&rig.next_request().octets).0, 48, "{what}");
            }
            answer(&mut rig, 48, "RS");
            assert_eq!(message(&rig.next_request().octets).0, 47, "{what}");
            // A slave may be busy twice.
            for _ in 0..2 {
                answer(&mut rig, 47, what);
                assert_eq!(message(&rig.next_request().octets).0, 47, "{what}");
            }
            answer(&mut rig, 47, what);
            assert_eq!(rig.station.user.ms2_phase(connection), Some(Phase::Ended), "{what}");
            // The slave may still have the connection: the next one searches again.
            rig.station.user.outcome(connection);
            rig.station.user.ms2_open(8, &parameters()).unwrap();
            rig.next_request();
            answer(&mut rig, 49, "RS");
            search_down_to(&mut rig, 48);
        }
        let (mut rig, connection) = open();
        rig.station.user.ms2_close(connection).unwrap();
        let began = rig.now;
        while rig.station.user.ms2_phase(connection) != Some(Phase::Ended) {
            assert!(rig.next_request().text().contains(" 30 32 58 "), "{what}");
            answer(&mut rig, 48, what);
        }
        let took = rig.now - began;
        assert!((BAUD.tbit_of_ms(500)..BAUD.tbit_of_ms(510)).contains(&took), "{what}: {took}");
    }
}

/// Three messages without an answer: the slave is gone, which is another error than a slave without a free connection.
#[test]
fn a_slave_that_does_not_answer_a_search_any_more_has_not_refused() {
    let (mut rig, connection) = opening();
    answer(&mut rig, 49, "RS");
    search_down_to(&mut rig, 40);
    while rig.station.user.ms2_phase(connection) != Some(Phase::Ended) {
        rig.next_telegram();
    }
    assert_eq!(rig.station.user.outcome(connection), Some(Err(LOST)));
}

/// A station without the token sends no Abort, and gives it up after T. A new connection waits for that and then has its own T.
#[test]
fn an_abort_and_a_search_end_without_the_token_too() {
    for at in [Aborting, Searching] {
        let (mut rig, connection, _) = stand(at);
        let second = rig.station.user.ms2_open(8, &parameters()).unwrap();
        // The message is answered with nothing; its confirmation comes first.
        rig.next_request();
        rig.station.listen(rig.now);
        let begun = rig.now;
        let mut elapse = |ms| {
            rig.station.user.elapse(begun + BAUD.tbit_of_ms(ms));
            (rig.station.user.ms2_phase(connection), rig.station.user.ms2_phase(second))
        };
        assert_eq!(elapse(0), (Some(Phase::Aborting), Some(Phase::Initiating)), "{at:?}");
        assert_eq!(elapse(998).0, Some(Phase::Aborting), "{at:?}");
        assert_eq!(elapse(1001).0, Some(Phase::Ended), "{at:?}");
        if matches!(at, Searching) {
            assert_eq!(elapse(1002).1, Some(Phase::Initiating));
            assert_eq!(elapse(2000).1, Some(Phase::Initiating));
            assert_ne!(elapse(2003).1, Some(Phase::Initiating));
        }
    }
}

/// Other masters hold all connections: the search is not repeated until this master may have left one itself.
#[test]
fn a_search_that_has_found_nothing_is_not_repeated_before_a_connection_may_have_been_left() {
    let (mut rig, connection) = opening();
    answer(&mut rig, 49, "RS");
    search_down_to(&mut rig, 0);
    assert_eq!(rig.station.user.outcome(connection), Some(Err(CLOSED)));

    let second = rig.station.user.ms2_open(8, &parameters()).unwrap();
    rig.next_request();
    answer(&mut rig, 49, "RS");
    assert_eq!(rig.station.user.outcome(second), Some(Err(CLOSED)), "at once");

    // The answer of the manager is lost, and the search too.
    let third = rig.station.user.ms2_open(8, &parameters()).unwrap();
    while rig.station.user.ms2_phase(third) != Some(Phase::Ended) {
        rig.next_telegram();
    }
    rig.station.user.ms2_open(8, &parameters()).unwrap();
    rig.next_request();
    answer(&mut rig, 49, "RS");
    search_down_to(&mut rig, 47);
}

/// The search would end the other connection, which has the same station address.
#[test]
fn a_slave_with_another_connection_of_this_master_is_not_searched() {
    let (mut rig, held) = open();
    let second = rig.station.user.ms2_open(8, &parameters()).unwrap();
    rig.next_request();
    answer(&mut rig, 49, "RS");
    assert_eq!(rig.station.user.outcome(second), Some(Err(CLOSED)));
    let third = rig.station.user.ms2_open(8, &parameters()).unwrap();
    while rig.station.user.ms2_phase(third) != Some(Phase::Ended) {
        rig.next_telegram();
    }
    assert_eq!(rig.station.user.outcome(third), Some(Err(LOST)));
    assert_eq!(
        message(&rig.next_request().octets),
        (48, "48".to_owned()),
        "the Idle of the other connection, no Abort"
    );
    assert_eq!(rig.station.user.ms2_phase(held), Some(Phase::Transferring));
}

/// The search could end the connection that the slave has just given.
#[test]
fn a_new_connection_waits_until_the_search_at_its_slave_is_over() {
    let (mut rig, _) = opening();
    answer(&mut rig, 49, "RS");
    let (sap, _) = message(&rig.next_request().octets);
    assert_eq!(sap, 48);
    let second = rig.station.user.ms2_open(8, &parameters()).unwrap();
    answer(&mut rig, 48, "RS");
    for sap in (0..=47).rev() {
        assert_eq!(message(&rig.next_request().octets).0, sap);
        answer(&mut rig, sap, "RS");
    }
    assert_eq!(rig.station.user.ms2_phase(second), Some(Phase::Initiating));
    assert_eq!(message(&rig.next_request().octets).0, 49);
}

/// A slave has few connections, so an Abort counts only with an answer. RS: the slave has received an earlier one.
#[test]
fn an_abort_without_an_answer_is_repeated_until_the_slave_answers_or_half_a_second_has_passed() {
    let closed = ConnectionEnd::Closed(AbortReason::User(0));
    for what in ["SC", "RS"] {
        let (mut rig, connection) = open();
        rig.station.user.ms2_close(connection).unwrap();
        for _ in 0..20 {
            assert!(rig.next_request().text().contains(" 30 32 58 "), "an Abort");
        }
        answer(&mut rig, 48, what);
        assert_eq!(rig.station.user.outcome(connection), Some(Err(closed)));
    }
    let (mut rig, connection) = open();
    rig.station.user.ms2_close(connection).unwrap();
    let began = rig.now;
    while rig.station.user.ms2_phase(connection) != Some(Phase::Ended) {
        rig.next_telegram();
    }
    let took = rig.now - began;
    assert!((BAUD.tbit_of_ms(500)..BAUD.tbit_of_ms(510)).contains(&took), "{took}");
    assert_eq!(rig.station.user.outcome(connection), Some(Err(closed)));
}
