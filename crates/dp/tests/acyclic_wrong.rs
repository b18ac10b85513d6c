//! Wrong answers of every kind to MS1 and MS2: none becomes a value, and each is named. profibus-wire 4.11, 9.5.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "helpers of tests are tests")]

mod support;

use profivac_dp::link::Baud;
use profivac_dp::link::active::{Failure, Mismatch};
use profivac_dp::master::{Cause, ConnectionEnd, ExchangeError, Handle, Master, Ms1Parameters, Ms2Parameters, ms1, ms2};
use profivac_wire::{DataTelegram, Telegram};
use support::desk::Desk;

const BAUD: Baud = Baud::B1500000;

type Station = Desk<Master<1, 8>>;

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

fn octets(frame: DataTelegram<'_>) -> Vec<u8> {
    let mut octets = [0; 255];
    let length = Telegram::Data(frame).emit(&mut octets).unwrap();
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
    fn outcome(self, desk: &mut Station) -> Option<Result<Vec<u8>, Option<Cause>>> {
        let user = &mut desk.station.user;
        Some(match self {
            Self::Ms1(handle) => user.outcome(handle)?.map(<[u8]>::to_vec).map_err(|error| match error {
                ms1::RequestError::Failed(cause) => Some(cause),
                ms1::RequestError::Refused(_) | ms1::RequestError::LeftExchange => None,
            }),
            Self::Ms2(_, handle) => user.outcome(handle)?.map(<[u8]>::to_vec).map_err(|error| match error {
                ms2::RequestError::Ended(ConnectionEnd::Failed { cause, .. }) => Some(cause),
                ms2::RequestError::Ended(_) | ms2::RequestError::Refused(_) => None,
            }),
        })
    }
}

/// A master that has exchanged data with slave 8 and is silent but for what it is asked for.
fn exchanging() -> Station {
    let mut desk = Desk::exchanging();
    while desk.station.user.next_event().is_some() {}
    desk
}

/// Times out after 100 ms.
fn read(desk: &mut Station, relation: Relation) -> Read {
    let user = &mut desk.station.user;
    match relation {
        Ms1 => {
            let parameters = Ms1Parameters { response_tbit: BAUD.tbit_of_ms(100), ..Ms1Parameters::new(BAUD) };
            Read::Ms1(user.ms1_read(8, 1, 16, 8, &parameters).unwrap())
        }
        Ms2 => {
            let parameters = Ms2Parameters { send_timeout: 10, response_timeout: 10, ..Ms2Parameters::new(BAUD) };
            let connection = user.ms2_open(8, &parameters).unwrap();
            desk.asks();
            desk.hears_octets(11, &octets(DataTelegram { ssap: Some(49), ..Ms2.response(&[0x56, 48, 0, 10]) }));
            desk.asks();
            let opened = [0x57, 0xF0, 1, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 0];
            desk.hears_octets(11, &octets(Ms2.response(&opened)));
            assert!(matches!(desk.station.user.outcome(connection), Some(Ok(_))));
            Read::Ms2(connection, desk.station.user.ms2_read(connection, 1, 16, 8).unwrap())
        }
    }
}

/// A read of 1/16 whose response is being polled for.
fn polling(relation: Relation) -> (Station, Read) {
    let mut desk = exchanging();
    let handle = read(&mut desk, relation);
    desk.asks();
    desk.hears("E5");
    desk.asks();
    (desk, handle)
}

/// What becomes of the read when every poll gets `wrong`, and the Abort SC.
fn cause(relation: Relation, wrong: &[u8]) -> Result<Vec<u8>, Cause> {
    let (mut desk, handle) = polling(relation);
    let limit = desk.now + BAUD.tbit_of_ms(500);
    while desk.now < limit {
        desk.hears_octets(11, wrong);
        loop {
            match handle.outcome(&mut desk) {
                Some(Ok(record)) => return Ok(record),
                Some(Err(Some(cause))) => return Err(cause),
                Some(Err(None)) => panic!("refused or closed"),
                None => {}
            }
            let said = desk.says();
            match said.text() {
                text if text.contains(" 58 00 ") => desk.hears("E5"),
                _ if said.is_token() => {}
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

/// What does not fit below the PDU is no answer: it is polled on, and what was wrong is named in the end.
#[test]
fn wrong_telegrams() {
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

/// A flipped bit anywhere is found by the check octet or the form.
#[test]
fn altered_telegrams() {
    for relation in [Ms1, Ms2] {
        let telegram = octets(relation.response(&RIGHT));
        for bit in 0..telegram.len() * 8 {
            let mut wrong = telegram.clone();
            wrong[bit / 8] ^= 1 << (bit % 8);
            let told = cause(relation, &wrong);
            assert!(matches!(told, Err(Cause::NoAnswer(_))), "{relation:?} {wrong:02X?}: {told:?}");
        }
    }
}

/// Every other value of every octet before the record, with a check octet that fits.
#[test]
fn forged_telegrams() {
    for relation in [Ms1, Ms2] {
        let telegram = octets(relation.response(&RIGHT));
        // DA, SA, FC, DSAP, SSAP, function, slot, index, length.
        for place in 4..13 {
            for octet in (0..=255u8).filter(|octet| *octet != telegram[place]) {
                // Which kind of station answers is not looked at, and a request is the ring's affair.
                if place == 6 && (octet & 0x4F == 0x08 || octet & 0x40 != 0) {
                    continue;
                }
                let mut wrong = telegram.clone();
                wrong[place] = octet;
                let end = wrong.len() - 2;
                wrong[end] = wrong[4..end].iter().fold(0, |sum: u8, octet| sum.wrapping_add(*octet));
                let (mut desk, handle) = polling(relation);
                desk.hears_octets(11, &wrong);
                for _ in 0..3 {
                    let told = handle.outcome(&mut desk);
                    assert!(!matches!(told, Some(Ok(_))), "{relation:?} {wrong:02X?}: {told:?}");
                    let Some(said) = desk.asks_within(40_000) else { break };
                    if !said.is_token() {
                        desk.hears("E5");
                    }
                }
            }
        }
    }
}

/// The response to something else: the connection, or the job, ends with what was wrong.
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
            let told = cause(relation, &octets(relation.response(du))).map_err(|cause| cause.to_string());
            assert_eq!(told, Err(text.to_owned()), "{relation:?} {du:02X?}");
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
        let mut desk = exchanging();
        let alarm = AlarmAck { slot: 3, alarm_type: 2, specifier: 0x10 };
        let ack = desk.station.user.ms1_alarm_ack(8, alarm, &Ms1Parameters::new(BAUD)).unwrap();
        desk.asks();
        desk.hears_octets(11, &octets(Ms1.response(&du)));
        let Some(Err(ms1::RequestError::Failed(cause))) = desk.station.user.outcome(ack) else { panic!("failed") };
        assert_eq!(cause.to_string(), words);
    }
}

/// A response that comes when nobody waits for it any more is not the next answer.
#[test]
fn late_answers_are_not_heard() {
    for relation in [Ms1, Ms2] {
        let (mut desk, handle) = polling(relation);
        let right = octets(relation.response(&RIGHT));
        // After the slot time and while the repeated poll is leaving: what is heard then is a collision.
        let repeated = desk.asks();
        assert!(!repeated.is_token());
        desk.hears("E5");
        desk.hears_octets(40, &right);
        assert_eq!(handle.outcome(&mut desk), None);
        // The response is gone now: it was fetched, as the slave sees it.
        let told = loop {
            if let Some(outcome) = handle.outcome(&mut desk) {
                break format!("{outcome:?}");
            }
            let said = desk.says();
            if !said.is_token() {
                desk.hears("E5");
            }
        };
        assert!(told.contains("Timeout"), "{told}");
    }
}

/// The same response twice: the second is not the answer to the next read.
#[test]
fn a_repeated_response_is_not_the_next_one() {
    let (mut desk, handle) = polling(Ms2);
    let Read::Ms2(connection, read) = handle else { panic!("MS2") };
    let right = octets(Ms2.response(&RIGHT));
    desk.hears_octets(11, &right);
    assert!(matches!(desk.station.user.outcome(read), Some(Ok(_))));
    let read = desk.station.user.ms2_read(connection, 1, 17, 8).unwrap();
    desk.hears_octets(15, &right);
    assert_eq!(desk.station.user.outcome(read), None);
    assert!(desk.asks().text().contains(" 30 32 5E 01 11 08 "));
    desk.hears("E5");
    desk.asks();
    // And if the slave itself gives it again, the connection ends.
    desk.hears_octets(11, &right);
    desk.asks();
    desk.hears("E5");
    let Some(Err(ms2::RequestError::Ended(end))) = desk.station.user.outcome(read) else { panic!("ended") };
    assert!(end.to_string().contains("the response is about 1/16 instead of 1/17"), "{end}");
}

/// Two slaves at one address: the other one says SC, or that the access point is closed, before or instead of ours.
#[test]
fn a_twin_at_the_same_address_gives_no_value() {
    for relation in [Ms1, Ms2] {
        let right = octets(relation.response(&RIGHT));
        let (mut desk, handle) = polling(relation);
        desk.hears("E5");
        desk.hears_octets(1, &right);
        assert_eq!(handle.outcome(&mut desk), None, "{relation:?}: the first answer counts");

        let (mut desk, handle) = polling(relation);
        desk.hears("10 02 08 03 0D 16");
        let told = handle.outcome(&mut desk).map(|outcome| format!("{outcome:?}"));
        assert!(told.is_some_and(|told| told.contains("ServiceNotActivated")), "{relation:?}");

        // Both at once.
        let mut both = octets(relation.response(&[0x5E, 1, 16, 2, 0xCC, 0xDD]));
        both.iter_mut().zip(&right).for_each(|(octet, other)| *octet &= other);
        assert!(matches!(cause(relation, &both), Err(Cause::NoAnswer(Failure::Damaged))));
    }
}

/// After a time-out or a wrong response of MS1 the next response could be the late one: the slave begins anew.
#[test]
fn ms1_that_is_out_of_step_begins_anew_with_data_exchange() {
    for wrong in [None, Some(&[0x5E, 1, 17, 2, 0xAA, 0xBB][..])] {
        let (mut desk, handle) = polling(Ms1);
        if let Some(du) = wrong {
            desk.hears_octets(11, &octets(Ms1.response(du)));
        }
        while handle.outcome(&mut desk).is_none() {
            if !desk.says().is_token() {
                desk.hears("E5");
            }
        }
        desk.says();
        assert_eq!(desk.station.user.exchange_error(8), Some(ExchangeError::Ms1));
        assert_eq!(desk.station.user.inputs(8), None);
        let parameters = Ms1Parameters::new(BAUD);
        assert!(desk.station.user.ms1_read(8, 1, 16, 8, &parameters).is_err(), "not before it exchanges data");
    }
}
