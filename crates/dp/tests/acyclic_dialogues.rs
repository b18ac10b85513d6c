//! The acyclic dialogues that profibus-wire prints: this master sends exactly these octets and takes exactly these answers.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "helpers of tests are tests")]

use crate::support;

use profivac_dp::link::active::BusParameters;
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::ms1::RequestError;
use profivac_dp::master::ms2::Connect;
use profivac_dp::master::{
    AcyclicEvent, ConnectionEnd, EventKind, Handle, Master, Ms1Parameters, Ms2Parameters, Phase, Settings,
};
use profivac_wire::acyclic::{AbortReason, AlarmAck, Call, ErrorCode, Im0};
use support::bus;
use support::rig::MasterRig;

const BAUD: Baud = Baud::B1500000;

/// A master without slaves, for MS2.
fn class2_master() -> MasterRig<Master<0, 0>> {
    MasterRig::new(Master::on(bus().check().unwrap(), Settings::new(BAUD), BitTime(0)))
}

/// The Send_Timeout of the example is 1 s.
fn open(rig: &mut MasterRig<Master<0, 0>>) -> Handle<Connect> {
    let parameters = Ms2Parameters { send_timeout: 100, ..Ms2Parameters::new(BAUD) };
    rig.station.user.ms2_open(8, &parameters).unwrap()
}

const OPENING: &str = "
    M 68 19 19 68 88 82 6C 31 32 57 00 00 00 00 64 01 00 00 00 00 00 00 02 00 02 00 00 00 00 99 16 | Initiate.req
    S 68 09 09 68 82 88 08 32 31 56 30 00 64 5F 16                                                 | RM: SAP 48
    M 68 05 05 68 88 82 5C 30 32 C8 16                                                             | poll SAP 48
    S E5
    M 68 05 05 68 88 82 7C 30 32 E8 16
    S 68 15 15 68 82 88 08 32 30 57 F0 01 00 00 00 00 00 00 02 00 02 00 00 00 00 C0 16             | Initiate.res
";

/// profibus-wire 4.6.6, octet by octet.
#[test]
fn ms2_as_printed() {
    let mut rig = class2_master();
    let connection = open(&mut rig);
    assert_eq!(rig.station.user.ms2_phase(connection), Some(Phase::Initiating));
    rig.dialogue(OPENING);
    let Some(Ok(opened)) = rig.station.user.outcome(connection) else { panic!("open") };
    assert_eq!((opened.server_sap, opened.max_len_data_unit, opened.send_timeout), (48, 240, 100));

    let read = rig.station.user.ms2_read(connection, 0, 16, 26).unwrap();
    rig.dialogue(
        "
        M 68 09 09 68 88 82 5C 30 32 5E 00 10 1A 50 16              | Read slot 0 index 16 len 26
        S E5
        M 68 05 05 68 88 82 7C 30 32 E8 16
        S 68 0D 0D 68 82 88 08 32 30 5E 00 10 04 DE AD BE EF 1E 16
    ",
    );
    assert_eq!(rig.station.user.outcome(read), Some(Ok(&[0xDE, 0xAD, 0xBE, 0xEF][..])));
    let fetched = rig.now;

    // No request for T: the master sends Idle.
    rig.dialogue("M 68 06 06 68 88 82 5C 30 32 48 10 16");
    assert!((BAUD.tbit_of_ms(1000)..BAUD.tbit_of_ms(1001)).contains(&(rig.now - fetched)), "{}", rig.now - fetched);
    rig.dialogue(
        "
        S E5
        M 68 05 05 68 88 82 7C 30 32 E8 16
        S 68 06 06 68 82 88 08 32 30 48 BC 16
    ",
    );
    assert_eq!(rig.station.user.ms2_phase(connection), Some(Phase::Open));

    rig.station.user.ms2_close(connection).unwrap();
    rig.dialogue("M 68 08 08 68 88 82 5C 30 32 58 00 20 40 16\n S E5");
    let end = ConnectionEnd::Closed(AbortReason::User(0));
    assert_eq!(rig.station.user.outcome(connection), Some(Err(end)));
    assert_eq!(rig.station.user.outcome(connection), None, "the handle is used up");
    let reported: Vec<_> = std::iter::from_fn(|| rig.station.user.next_event()).map(|event| event.kind).collect();
    let notice = |notice| EventKind::Acyclic(connection.id(), notice);
    assert_eq!(
        reported,
        [notice(AcyclicEvent::OutcomeReady), notice(AcyclicEvent::OutcomeReady), notice(AcyclicEvent::Ended(end))]
    );
}

/// profibus-wire 5.4: I&M0 is called and read on the connection, at once after it was opened with one poll.
#[test]
fn i_and_m0_as_printed() {
    let mut rig = class2_master();
    let connection = open(&mut rig);
    rig.dialogue(OPENING);
    assert!(matches!(rig.station.user.outcome(connection), Some(Ok(_))));
    let call = rig.station.user.ms2_write(connection, 0, 255, &[8, 0, 0xFD, 0xE8]).unwrap();
    rig.dialogue(
        "
        M 68 0D 0D 68 88 82 5C 30 32 5F 00 FF 04 08 00 FD E8 17 16
        S E5
        M 68 05 05 68 88 82 7C 30 32 E8 16
        S 68 09 09 68 82 88 08 32 30 5F 00 FF 04 D6 16
    ",
    );
    assert_eq!(rig.station.user.outcome(call), Some(Ok(())));
    let read = rig.station.user.ms2_read(connection, 0, 255, 68).unwrap();
    rig.dialogue(
        "
        M 68 09 09 68 88 82 5C 30 32 5E 00 FF 44 69 16
        S E5
        M 68 05 05 68 88 82 7C 30 32 E8 16
        S 68 4D 4D 68 82 88 08 32 30 5E 00 FF 44 08 00 FD E8 20 20 20 20 20 20 20 20 20 20 01 23 44 45 4D 4F 2D 31 20 20 20 20 20 20 20 20 20 20 20 20 20 20 30 30 30 30 34 32 20 20 20 20 20 20 20 20 20 20 00 01 56 01 02 03 00 00 00 00 00 00 01 01 00 00 6E 16
    ",
    );
    let Some(Ok(record)) = rig.station.user.outcome(read) else { panic!("a record") };
    let im0 = Im0::parse(Call::parse(record).unwrap().record).unwrap();
    assert_eq!((im0.order_id, im0.serial_number), (&b"DEMO-1"[..], &b"000042"[..]));
}

/// profibus-wire 4.7, from a real bus: master 0, slave 32, the connection at SAP 40.
#[test]
fn idle_as_on_a_real_bus() {
    let bus = BusParameters { address: 0, hsa: 0, ..bus() };
    let mut rig = MasterRig::new(Master::<0, 0>::on(bus.check().unwrap(), Settings::new(BAUD), BitTime(0)));
    let parameters = Ms2Parameters { send_timeout: 100, ..Ms2Parameters::new(BAUD) };
    let connection = rig.station.user.ms2_open(32, &parameters).unwrap();
    rig.dialogue(
        "
        M 68 19 19 68 A0 80 6C 31 32 57 00 00 00 00 64 01 00 00 00 00 00 00 02 00 02 00 00 00 00 AF 16
        S 68 09 09 68 80 A0 08 32 31 56 28 00 64 6D 16
        M 68 05 05 68 A0 80 5C 28 32 D6 16
        S 68 15 15 68 80 A0 08 32 28 57 F0 01 00 00 00 00 00 00 02 00 02 00 00 00 00 CE 16
        M 68 06 06 68 A0 80 7C 28 32 48 3E 16      | Idle
        S E5
        M 68 05 05 68 A0 80 5C 28 32 D6 16         | poll
        S 68 06 06 68 80 A0 08 32 28 48 CA 16      | Idle.res
        M 68 06 06 68 A0 80 7C 28 32 48 3E 16      | Idle, after T
    ",
    );
    let Some(Ok(opened)) = rig.station.user.outcome(connection) else { panic!("open") };
    assert_eq!(opened.server_sap, 40);
}

/// profibus-wire 4.4, octet by octet.
#[test]
fn ms1_as_printed() {
    let mut rig = MasterRig::exchanging();
    let parameters = Ms1Parameters::new(BAUD);
    let read = rig.station.user.ms1_read(8, 1, 16, 20, &parameters).unwrap();
    rig.dialogue(
        "
        M 68 09 09 68 88 82 5C 33 33 5E 01 10 14 4F 16
        S E5
        M 68 05 05 68 88 82 7C 33 33 EC 16                          | poll
        S E5
        M 68 05 05 68 88 82 5C 33 33 CC 16                          | poll
        S 68 0D 0D 68 82 88 08 33 33 5E 01 10 04 11 22 33 44 95 16
    ",
    );
    assert_eq!(rig.station.user.outcome(read), Some(Ok(&[0x11, 0x22, 0x33, 0x44][..])));
    let write = rig.station.user.ms1_write(8, 1, 32, &[0, 0x64], &parameters).unwrap();
    rig.dialogue(
        "
        M 68 0B 0B 68 88 82 7C 33 33 5F 01 20 02 00 64 D2 16
        S E5
        M 68 05 05 68 88 82 5C 33 33 CC 16
        S 68 09 09 68 82 88 08 33 33 DF 80 B6 00 8D 16               | access denied
    ",
    );
    let Some(Err(RequestError::Refused(negative))) = rig.station.user.outcome(write) else { panic!("refused") };
    assert_eq!(negative.code_1, ErrorCode::ACCESS_DENIED);
    assert_eq!(rig.station.user.outcome(write), None, "once");
}

/// profibus-wire 4.5: the acknowledgement of alarm type 2 (process) of slot 3, Seq_Nr 2.
#[test]
fn alarm_ack_as_printed() {
    let mut rig = MasterRig::exchanging();
    let alarm = AlarmAck { slot: 3, alarm_type: 2, specifier: 0x10 };
    let ack = rig.station.user.ms1_alarm_ack(8, alarm, &Ms1Parameters::new(BAUD)).unwrap();
    rig.dialogue(
        "
        M 68 09 09 68 88 82 5C 33 33 5C 03 02 10 3D 16
        S E5
        M 68 05 05 68 88 82 7C 33 33 EC 16
        S 68 09 09 68 82 88 08 33 33 5C 03 02 10 E9 16
    ",
    );
    assert_eq!(rig.station.user.outcome(ack), Some(Ok(())));
}
