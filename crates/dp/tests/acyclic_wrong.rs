//! Wrong answers of every kind to MS1 and MS2: none becomes a value, and each error has its text. profibus-wire 4.11, 9.5.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "helpers of tests are tests")]

use crate::support;

use profivac_dp::link::Baud;
use profivac_dp::link::active::{Failure, Mismatch};
use profivac_dp::master::{
    Cause, ConnectionEnd, ExchangeError, Handle, Master, Ms1Parameters, Ms2Parameters, ms1, ms2,
};
use profivac_wire::control::Status;
use profivac_wire::{DataTelegram, Telegram};
use support::rig::MasterRig;

const BAUD: Baud = Baud::B1500000;

type Station = MasterRig<Master<1, 8>>;

/// The access points of a relation, at the slave and at the master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Relation {
    Ms1,
    Ms2,
}

use Relation::{Ms1, Ms2};

impl Relation {
    fn saps(self) -> (u8, u8) {
        match self {
            Ms1 => (51, 51),
            Ms2 => (48, 50),
        }
    }

    /// A response with these octets.
    fn response(self, du: &[u8]) -> DataTelegram<'_> {
        let (server, client) = self.saps();
        DataTelegram { da: 2, sa: 8, dsap: Some(client), ssap: Some(server), fc: 0x08, du }
    }
}

fn octets(data: DataTelegram<'_>) -> Vec<u8> {
    let mut octets = [0; 255];
    let length = Telegram::Data(data).emit(&mut octets).unwrap();
    octets[..length].to_vec()
}

/// A read of 1/16 by MS1, or by MS2 on its connection.
#[derive(Clone, Copy)]
enum Read {
    Ms1(Handle<ms1::Read>),
    Ms2(Handle<ms2::Connect>, Handle<ms2::Read>),
}

impl Read {
    /// The record, or the cause if the master itself has one.
    fn outcome(self, rig: &mut Station) -> Option<Result<Vec<u8>, Option<Cause>>> {
        let user = &mut rig.station.user;
        Some(match self {
            Self::Ms1(handle) => user.outcome(handle)?.map(<[u8]>::to_vec).map_err(|error| match error {
                ms1::RequestError::Failed(cause) | ms1::RequestError::NotExecuted(cause) => Some(cause),
                ms1::RequestError::Refused(_) | ms1::RequestError::LeftExchange | ms1::RequestError::NotSent => None,
            }),
            Self::Ms2(_, handle) => user.outcome(handle)?.map(<[u8]>::to_vec).map_err(|error| match error {
                ms2::RequestError::Ended(ConnectionEnd::Failed { cause, .. })
                | ms2::RequestError::NotExecuted(ConnectionEnd::Failed { cause, .. }) => Some(cause),
                ms2::RequestError::Ended(_) | ms2::RequestError::NotExecuted(_) | ms2::RequestError::Refused(_) => None,
            }),
        })
    }
}

/// A master that has exchanged data with slave 8 and now sends only the requests of the test.
fn exchanging() -> Station {
    let mut rig = MasterRig::exchanging();
    while rig.station.user.next_event().is_some() {}
    rig
}

/// Times out after 100 ms.
fn read(rig: &mut Station, relation: Relation) -> Read {
    let user = &mut rig.station.user;
    match relation {
        Ms1 => {
            let parameters = Ms1Parameters { response_tbit: BAUD.tbit_of_ms(100), ..Ms1Parameters::new(BAUD) };
            Read::Ms1(user.ms1_read(8, 1, 16, 8, &parameters).unwrap())
        }
        Ms2 => {
            let parameters = Ms2Parameters { send_timeout: 10, response_timeout: 10, ..Ms2Parameters::new(BAUD) };
            let connection = user.ms2_open(8, &parameters).unwrap();
            rig.next_request();
            rig.receive_octets(11, &octets(DataTelegram { ssap: Some(49), ..Ms2.response(&[0x56, 48, 0, 10]) }));
            rig.next_request();
            let opened = [0x57, 0xF0, 1, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 0];
            rig.receive_octets(11, &octets(Ms2.response(&opened)));
            assert!(matches!(rig.station.user.outcome(connection), Some(Ok(_))));
            Read::Ms2(connection, rig.station.user.ms2_read(connection, 1, 16, 8).unwrap())
        }
    }
}

/// A read of 1/16 whose response is being polled for.
fn polling(relation: Relation) -> (Station, Read) {
    let mut rig = exchanging();
    let handle = read(&mut rig, relation);
    rig.next_request();
    rig.receive("E5");
    rig.next_request();
    (rig, handle)
}

/// The outcome of the read when every poll is answered with `wrong`, and the Abort with SC.
fn cause(relation: Relation, wrong: &[u8]) -> Result<Vec<u8>, Cause> {
    let (mut rig, handle) = polling(relation);
    let limit = rig.now + BAUD.tbit_of_ms(500);
    while rig.now < limit {
        rig.receive_octets(11, wrong);
        loop {
            match handle.outcome(&mut rig) {
                Some(Ok(record)) => return Ok(record),
                Some(Err(Some(cause))) => return Err(cause),
                Some(Err(None)) => panic!("refused or closed"),
                None => {}
            }
            let sent = rig.next_telegram();
            match sent.text() {
                text if text.contains(" 58 00 ") => rig.receive("E5"),
                _ if sent.is_token() => {}
                _ => break,
            }
        }
    }
    panic!("it never ends");
}

const RIGHT: [u8; 6] = [0x5E, 1, 16, 2, 0xAA, 0xBB];

#[test]
fn the_right_answer_is_the_value() {
    for relation in [Ms1, Ms2] {
        assert_eq!(cause(relation, &octets(relation.response(&RIGHT))), Ok(vec![0xAA, 0xBB]));
    }
}

/// A telegram with a wrong header is no answer: the master keeps polling and names the mismatch in the end.
#[test]
fn telegrams_with_a_wrong_header_are_no_answer() {
    for relation in [Ms1, Ms2] {
        let right = relation.response(&RIGHT);
        for (wrong, mismatch) in [
            (DataTelegram { sa: 9, ..right }, Mismatch::Source(9)),
            (DataTelegram { da: 3, ..right }, Mismatch::Destination(3)),
            (DataTelegram { ssap: Some(47), ..right }, Mismatch::AccessPoint),
            (DataTelegram { dsap: Some(62), ..right }, Mismatch::AccessPoint),
            (DataTelegram { dsap: None, ssap: None, ..right }, Mismatch::AccessPoint),
            (DataTelegram { fc: 0x00, ..right }, Mismatch::Function(0x00)),
            (DataTelegram { fc: 0x09, ..right }, Mismatch::Form),
            (DataTelegram { fc: 0x03, ..right }, Mismatch::Form),
        ] {
            let expected = Err(Cause::NoAnswer(Failure::Mismatch(mismatch)));
            assert_eq!(cause(relation, &octets(wrong)), expected, "{relation:?} {wrong:?}");
        }
        let telegram = octets(right);
        for length in 1..telegram.len() {
            let expected = Err(Cause::NoAnswer(Failure::Damaged));
            assert_eq!(cause(relation, &telegram[..length]), expected, "{relation:?} cut to {length}");
        }
    }
}

/// The check octet or the form reveals a flipped bit anywhere.
#[test]
fn telegrams_with_a_flipped_bit_are_no_answer() {
    for relation in [Ms1, Ms2] {
        let telegram = octets(relation.response(&RIGHT));
        for bit in 0..telegram.len() * 8 {
            let mut wrong = telegram.clone();
            wrong[bit / 8] ^= 1 << (bit % 8);
            let reported = cause(relation, &wrong);
            assert!(matches!(reported, Err(Cause::NoAnswer(_))), "{relation:?} {wrong:02X?}: {reported:?}");
        }
    }
}

/// Every other value of every octet before the record, with a check octet that fits.
#[test]
fn no_altered_octet_with_a_right_check_octet_becomes_a_value() {
    for relation in [Ms1, Ms2] {
        let telegram = octets(relation.response(&RIGHT));
        // DA, SA, FC, DSAP, SSAP, function, slot, index, length.
        for index in 4..13 {
            for octet in (0..=255u8).filter(|octet| *octet != telegram[index]) {
                // The station type is not checked, and a request is handled by the ring.
                if index == 6 && (octet & 0x4F == 0x08 || octet & 0x40 != 0) {
                    continue;
                }
                let mut wrong = telegram.clone();
                wrong[index] = octet;
                let end = wrong.len() - 2;
                wrong[end] = wrong[4..end].iter().fold(0, |sum: u8, octet| sum.wrapping_add(*octet));
                let (mut rig, handle) = polling(relation);
                rig.receive_octets(11, &wrong);
                for _ in 0..3 {
                    let reported = handle.outcome(&mut rig);
                    assert!(!matches!(reported, Some(Ok(_))), "{relation:?} {wrong:02X?}: {reported:?}");
                    let Some(sent) = rig.next_request_within(40_000) else { break };
                    if !sent.is_token() {
                        rig.receive("E5");
                    }
                }
            }
        }
    }
}

/// The response to another request ends the connection, or the MS1 request, with the mismatch.
#[test]
fn wrong_responses_are_named() {
    for (du, text) in [
        (&[0x5E, 2, 16, 2, 0xAA, 0xBB][..], "the response is about 2/16 instead of 1/16"),
        (&[0x5E, 1, 17, 2, 0xAA, 0xBB], "the response is about 1/17 instead of 1/16"),
        (&[0x5E, 1, 16, 9, 1, 2, 3, 4, 5, 6, 7, 8, 9], "the response has a length of 9 octets, expected were 8"),
        (&[0x5E, 1, 16, 3, 0xAA, 0xBB], "the response is malformed: the length of Read does not fit its fields"),
        (&[0x5E, 1, 16], "the response is malformed: the length of Read does not fit its fields"),
        (&[0x5F, 1, 16, 2], "the response is one to Write instead of Read"),
        (&[0xDF, 0x80, 0xB6, 0], "the response is one to Write instead of Read"),
        (&[0x51, 1, 16, 2, 0xAA, 0xBB], "the response is one to Data_Transport instead of Read"),
        (&[0x48], "the response is one to Idle instead of Read"),
        (&[0x5C, 1, 16, 2], "the response is one to Alarm_Ack instead of Read"),
        (&[0x77, 1, 16, 2, 0xAA, 0xBB], "the response is malformed: there is no function 77"),
    ] {
        for relation in [Ms1, Ms2] {
            let reported = cause(relation, &octets(relation.response(du))).map_err(|cause| cause.to_string());
            assert_eq!(reported, Err(text.to_owned()), "{relation:?} {du:02X?}");
        }
    }
    // MS1 has no Abort; MS2 has.
    let abort = cause(Ms1, &octets(Ms1.response(&[0x58, 0, 0x13]))).unwrap_err();
    assert_eq!(abort.to_string(), "the response is one to Abort instead of Read");
}

/// profibus-wire 4.5: the acknowledgement is an echo, whole.
#[test]
fn another_alarm_is_not_acknowledged() {
    use profivac_wire::acyclic::AlarmAck;
    for (du, words) in [
        ([0x5C, 3, 2, 0x18], "the response acknowledges another alarm"),
        ([0x5C, 3, 1, 0x10], "the response is about 3/1 instead of 3/2"),
        ([0x5C, 4, 2, 0x10], "the response is about 4/2 instead of 3/2"),
    ] {
        let mut rig = exchanging();
        let alarm = AlarmAck { slot: 3, alarm_type: 2, specifier: 0x10 };
        let ack = rig.station.user.ms1_alarm_ack(8, alarm, &Ms1Parameters::new(BAUD)).unwrap();
        rig.next_request();
        rig.receive_octets(11, &octets(Ms1.response(&du)));
        let Some(Err(ms1::RequestError::Failed(cause))) = rig.station.user.outcome(ack) else { panic!("failed") };
        assert_eq!(cause.to_string(), words);
    }
}

/// UE: the slave's application interface failed (profibus-wire 4.12), maybe after it had taken the request.
#[test]
fn an_ms1_request_that_changes_something_is_not_sent_again_after_ue() {
    use profivac_wire::acyclic::AlarmAck;
    let parameters = Ms1Parameters::new(BAUD);
    let ue = Some(Err(ms1::RequestError::Failed(Cause::Status(Status::UserError))));

    let mut rig = exchanging();
    let write = rig.station.user.ms1_write(8, 1, 16, &[1, 2], &parameters).unwrap();
    rig.next_request();
    rig.receive("10 02 08 01 0B 16");
    assert_eq!(rig.station.user.outcome(write), ue);

    let mut rig = exchanging();
    let alarm = AlarmAck { slot: 3, alarm_type: 2, specifier: 0x10 };
    let ack = rig.station.user.ms1_alarm_ack(8, alarm, &parameters).unwrap();
    rig.next_request();
    rig.receive("10 02 08 01 0B 16");
    assert_eq!(rig.station.user.outcome(ack), ue);

    // A read may be executed twice.
    let mut rig = exchanging();
    let read = rig.station.user.ms1_read(8, 1, 16, 8, &parameters).unwrap();
    rig.next_request();
    rig.receive("10 02 08 01 0B 16");
    rig.next_request();
    rig.receive_octets(11, &octets(Ms1.response(&RIGHT)));
    assert_eq!(rig.station.user.outcome(read), Some(Ok(&[0xAA, 0xBB][..])));
}

/// A response that comes too late is not the answer to the next poll.
#[test]
fn a_late_answer_is_ignored() {
    for relation in [Ms1, Ms2] {
        let (mut rig, handle) = polling(relation);
        let right = octets(relation.response(&RIGHT));
        // A telegram after the slot time, while the repeated poll is sent, is a collision.
        let repeated = rig.next_request();
        assert!(!repeated.is_token());
        rig.receive("E5");
        rig.receive_octets(40, &right);
        assert_eq!(handle.outcome(&mut rig), None);
        // The slave considers the response fetched, so it does not send it again.
        let reported = loop {
            if let Some(outcome) = handle.outcome(&mut rig) {
                break format!("{outcome:?}");
            }
            let sent = rig.next_telegram();
            if !sent.is_token() {
                rig.receive("E5");
            }
        };
        assert!(reported.contains("Timeout"), "{reported}");
    }
}

/// The same response twice: the second is not the answer to the next read.
#[test]
fn a_repeated_response_is_not_the_next_one() {
    let (mut rig, handle) = polling(Ms2);
    let Read::Ms2(connection, read) = handle else { panic!("MS2") };
    let right = octets(Ms2.response(&RIGHT));
    rig.receive_octets(11, &right);
    assert!(matches!(rig.station.user.outcome(read), Some(Ok(_))));
    let read = rig.station.user.ms2_read(connection, 1, 17, 8).unwrap();
    rig.receive_octets(15, &right);
    assert_eq!(rig.station.user.outcome(read), None);
    assert!(rig.next_request().text().contains(" 30 32 5E 01 11 08 "));
    rig.receive("E5");
    rig.next_request();
    // If the slave itself sends it again, the connection ends.
    rig.receive_octets(11, &right);
    rig.next_request();
    rig.receive("E5");
    let Some(Err(ms2::RequestError::Ended(end))) = rig.station.user.outcome(read) else { panic!("ended") };
    assert!(end.to_string().contains("the response is about 1/16 instead of 1/17"), "{end}");
}

/// Two slaves at one address: the other one answers SC or RS, before or instead of ours.
#[test]
fn a_second_slave_at_the_same_address_gives_no_value() {
    for relation in [Ms1, Ms2] {
        let right = octets(relation.response(&RIGHT));
        let (mut rig, handle) = polling(relation);
        rig.receive("E5");
        rig.receive_octets(1, &right);
        assert_eq!(handle.outcome(&mut rig), None, "{relation:?}: the first answer counts");

        let (mut rig, handle) = polling(relation);
        rig.receive("10 02 08 03 0D 16");
        let reported = handle.outcome(&mut rig).map(|outcome| format!("{outcome:?}"));
        assert!(reported.is_some_and(|reported| reported.contains("ServiceNotActivated")), "{relation:?}");

        // Both at once.
        let mut both = octets(relation.response(&[0x5E, 1, 16, 2, 0xCC, 0xDD]));
        both.iter_mut().zip(&right).for_each(|(octet, other)| *octet &= other);
        assert!(matches!(cause(relation, &both), Err(Cause::NoAnswer(Failure::Damaged))));
    }
}

/// After a timeout or a wrong response of MS1 the next response could belong to the earlier request, so the master restarts the
/// slave.
#[test]
fn after_a_timeout_or_a_wrong_response_of_ms1_the_slave_is_restarted() {
    for wrong in [None, Some(&[0x5E, 1, 17, 2, 0xAA, 0xBB][..])] {
        let (mut rig, handle) = polling(Ms1);
        if let Some(du) = wrong {
            rig.receive_octets(11, &octets(Ms1.response(du)));
        }
        while handle.outcome(&mut rig).is_none() {
            if !rig.next_telegram().is_token() {
                rig.receive("E5");
            }
        }
        rig.next_telegram();
        assert_eq!(rig.station.user.exchange_error(8), Some(ExchangeError::Ms1));
        assert_eq!(rig.station.user.inputs(8), None);
        let parameters = Ms1Parameters::new(BAUD);
        assert!(rig.station.user.ms1_read(8, 1, 16, 8, &parameters).is_err(), "not before it exchanges data");
    }
}
