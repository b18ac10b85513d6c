//! The answers to all services in all states: the table of profibus-wire 2.2, cell by cell.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::common;

use common::*;
use profivac_dp::link::Baud;
use profivac_dp::slave::Slave;
use profivac_wire::control::{Control, Status};
use profivac_wire::{DataTelegram, Telegram};

/// The answer of every service in every state, to the owner of the slave and to another master. `SC>WAIT-CFG` changes
/// the state, other entries keep it. The device has neither MS1 nor MS2.
const MATRIX: &str = "
                 WAIT-PRM     WAIT-CFG                  DATA-EXCH
service          own          own           other       own          other
FDL_Status       OK           OK            OK          OK           OK
Slave_Diag       DL           DL            DL          DL           DL
Get_Cfg          DL           DL            DL          DL           DL
Set_Prm          SC>WAIT-CFG  SC>WAIT-CFG   SC          SC>WAIT-CFG  SC
wrong_Set_Prm    SC           SC>WAIT-PRM   SC          SC>WAIT-PRM  SC
Unlock           SC           SC>WAIT-PRM   SC          SC>WAIT-PRM  SC
Chk_Cfg          SC           SC>DATA-EXCH  SC          SC           SC
wrong_Chk_Cfg    SC           SC>WAIT-PRM   SC          SC>WAIT-PRM  SC
Data_Exchange    RS           RS            RS          DL           RS
RD_Inp           RS           RS            RS          DL           DL
RD_Outp          RS           RS            RS          DL           DL
Global_Control   -            -             -           -            -
Set_Slave_Add    SC           RS            RS          RS           RS
Set_Ext_Prm      RS           RS            RS          RS           RS
MS1              RS           RS            RS          RS           RS
Alarm            RS           RS            RS          RS           RS
SAP_52           RS           RS            RS          RS           RS
SAP_54           RS           RS            RS          RS           RS
SAP_63           RS           RS            RS          RS           RS
";

/// The same services with data where none are expected.
const WITH_DATA: &str = "
Slave_Diag       RR           RR            RR          RR           RR
Get_Cfg          RR           RR            RR          RR           RR
RD_Inp           RS           RS            RS          RR           RR
RD_Outp          RS           RS            RS          RR           RR
";

const COLUMNS: [(&str, u8); 5] =
    [("WAIT-PRM", OWN), ("WAIT-CFG", OWN), ("WAIT-CFG", OTHER), ("DATA-EXCH", OWN), ("DATA-EXCH", OTHER)];

/// The request of a row: function code bits 3 to 0, access point, data.
fn service(row: &str) -> (Option<u8>, Option<u8>, &'static [u8]) {
    match row {
        "FDL_Status" => (Some(0x49), None, &[]),
        "Slave_Diag" => (None, Some(60), &[]),
        "Get_Cfg" => (None, Some(59), &[]),
        "Set_Prm" => (None, Some(61), &LOCK),
        "wrong_Set_Prm" => (None, Some(61), &[0x80, 0, 0, 11, 0x12, 0x35, 0]),
        "Unlock" => (None, Some(61), &[0x40, 0, 0, 0, 0x12, 0x34, 0]),
        "Chk_Cfg" => (None, Some(62), &CFG),
        "wrong_Chk_Cfg" => (None, Some(62), &[0x11, 0x22]),
        "Data_Exchange" => (None, None, &[0xAA, 0x55]),
        "RD_Inp" => (None, Some(56), &[]),
        "RD_Outp" => (None, Some(57), &[]),
        "Global_Control" => (Some(0x46), Some(58), &[0, 0]),
        "Set_Slave_Add" => (None, Some(55), &[TS, 0x12, 0x34, 0]),
        "Set_Ext_Prm" => (None, Some(53), &[5, 0x81, 0, 0, 1]),
        "MS1" => (None, Some(51), &[0x5E, 0, 0, 10]),
        "Alarm" => (None, Some(50), &[0x5C, 0, 0, 0]),
        "SAP_52" => (None, Some(52), &[]),
        "SAP_54" => (None, Some(54), &[]),
        "SAP_63" => (None, Some(63), &[]),
        other => panic!("unknown row: {other}"),
    }
}

fn in_state(state: &str) -> Talk {
    let mut talk = talk(Plain::new());
    match state {
        "WAIT-PRM" => {}
        "WAIT-CFG" => to_wait_cfg(&mut talk),
        _ => to_data_exch(&mut talk),
    }
    talk
}

fn name(answer: Option<&[u8]>) -> String {
    match answer.map(Telegram::parse) {
        None => "-".to_owned(),
        Some(Ok(Telegram::ShortAck)) => "SC".to_owned(),
        Some(Ok(Telegram::Data(telegram))) => match telegram.control() {
            Control::Response { status, .. } => status_name(status).to_owned(),
            Control::Request { .. } => panic!("expected an answer"),
        },
        Some(other) => panic!("{other:?}"),
    }
}

fn status_name(status: Status) -> &'static str {
    match status {
        Status::Ok => "OK",
        Status::NoResource => "RR",
        Status::ServiceNotActivated => "RS",
        Status::DataLow => "DL",
        other => panic!("{other:?}"),
    }
}

/// Plays all cells of a table. `srd` is FC of the SRD requests, `more` is appended to every data unit.
fn play(table: &str, srd: u8, more: &[u8]) {
    let rows = table.lines().filter(|line| line.starts_with(|first: char| first.is_ascii_alphabetic()));
    for row in rows.filter(|row| !row.starts_with("service")) {
        let mut words = row.split_whitespace();
        let (fc, dsap, du) = service(words.next().unwrap());
        let du = [du, more].concat();
        for ((state, sa), cell) in COLUMNS.into_iter().zip(words) {
            let mut talk = in_state(state);
            let telegram = DataTelegram { da: TS, sa, dsap, ssap: dsap.map(|_| 62), fc: fc.unwrap_or(srd), du: &du };
            let answer = ask_or_silence(&mut talk, &emit(&Telegram::Data(telegram)));
            let (reply, after) = cell.split_once('>').unwrap_or((cell, state));
            let came = (name(answer.as_deref()), talk.station().state().to_string());
            assert_eq!(came, (reply.to_owned(), after.to_owned()), "{row}\nin {state}, master {sa}, FC {srd:02X}");
            swapped(&telegram, answer.as_deref());
        }
    }
}

/// An answer swaps addresses and access points. profibus-wire 1.3.
fn swapped(request: &DataTelegram<'_>, answer: Option<&[u8]>) {
    if let Some(Ok(Telegram::Data(answer))) = answer.map(Telegram::parse) {
        assert_eq!((answer.da, answer.sa), (request.sa, request.da));
        let with_data = matches!(answer.control(), Control::Response { status: Status::DataLow, .. });
        let expected = if with_data { (request.ssap, request.dsap) } else { (None, None) };
        assert_eq!((answer.dsap, answer.ssap), expected);
    }
}

#[test]
fn every_cell_matches_the_specification() {
    play(MATRIX, 0x6D, &[]);
}

#[test]
fn priority_makes_no_difference() {
    play(MATRIX, 0x6C, &[]);
}

#[test]
fn counted_or_not_makes_no_difference_to_a_new_request() {
    for fc in [0x4C, 0x4D, 0x5C, 0x5D] {
        play(MATRIX, fc, &[]);
    }
}

#[test]
fn data_where_none_are_expected_are_refused() {
    play(WITH_DATA, 0x6D, &[1]);
}

#[test]
fn an_answer_goes_to_the_source_access_point_of_the_request() {
    for ssap in [0, 50, 51, 54, 62] {
        let telegram = DataTelegram { da: TS, sa: OWN, dsap: Some(60), ssap: Some(ssap), fc: FIRST, du: &[] };
        let answer = ask(&mut talk(Plain::new()), &emit(&Telegram::Data(telegram)));
        assert_eq!(name(Some(&answer)), "DL");
        swapped(&telegram, Some(&answer));
    }
}

#[test]
fn requests_to_all_stations_are_not_answered() {
    for fc in [0x49, 0x4E, 0x6D, 0x6C, 0x43, 0x45] {
        let telegram = DataTelegram { da: 127, sa: OWN, dsap: Some(60), ssap: Some(62), fc, du: &[] };
        assert_eq!(ask_or_silence(&mut talk(Plain::new()), &emit(&Telegram::Data(telegram))), None, "FC {fc:02X}");
    }
}

#[test]
fn a_slave_at_address_126_is_diagnosed_and_gets_an_address() {
    let mut talk = Talk::new(Baud::B19200, Slave::new(Plain::new(), 126, Baud::B19200));
    let set = DataTelegram { da: 126, sa: OWN, dsap: Some(55), ssap: Some(62), fc: FIRST, du: &[TS, 0x12, 0x34, 0] };
    assert_eq!(ask(&mut talk, &emit(&Telegram::Data(set))), [0xE5]);
    assert_eq!(talk.station().address(), TS);
    assert_eq!(ask_or_silence(&mut talk, &emit(&Telegram::Data(set))), None);
    assert_eq!(diagnosis(&mut talk), "02 05 00 FF");
}
