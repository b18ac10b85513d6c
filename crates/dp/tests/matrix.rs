//! Every state and every service, as the slave answers them: the goldens `services.txt` and `ms2.txt`. profibus-wire 2.2,
//! 3.2 and 4.10.

use crate::rig;

use profivac_dp::slave::SlaveState;
use profivac_wire::control::{Control, FrameCount, Function, Status};
use profivac_wire::{DataTelegram, Telegram};
use rig::golden::{compare, table};
use rig::{Answer, Gauge, INITIATE, MASTER, Rig, SLAVE, emit, hex, low, text};

const OTHER: u8 = 3;

/// An answer in the abbreviations of the reference.
fn short(answer: &Answer) -> String {
    match answer {
        Answer::Silence => "-".to_owned(),
        Answer::Ack => "SC".to_owned(),
        Answer::Low(_) => "DL".to_owned(),
        Answer::High(_) => "DH".to_owned(),
        Answer::Status(Status::Ok) => "OK".to_owned(),
        Answer::Status(Status::ServiceNotActivated) => "RS".to_owned(),
        Answer::Status(Status::NoResource) => "RR".to_owned(),
        Answer::Status(other) => format!("{other:?}"),
    }
}

/// The master that sends the request, and the state of the slave.
const COLUMNS: [(&str, &str, u8); 5] = [
    ("WAIT-PRM", "", MASTER),
    ("WAIT-CFG own", "WAIT-CFG", MASTER),
    ("WAIT-CFG other", "WAIT-CFG", OTHER),
    ("DATA-EXCH own", "DATA-EXCH", MASTER),
    ("DATA-EXCH other", "DATA-EXCH", OTHER),
];

fn slave_in(state: &str) -> Rig {
    let mut rig = Rig::new(Gauge::default());
    if !state.is_empty() {
        rig.ms0(MASTER, 61, &hex("80 01 01 00 12 34 00 80 00 00"));
    }
    if state == "DATA-EXCH" {
        rig.ms0(MASTER, 62, &hex("11 21"));
    }
    rig
}

/// A request: its name, function, access points and data unit.
type Service = (&'static str, Function, Option<(u8, u8)>, &'static str);

const SRD: Function = Function::SrdHigh;
const SDN: Function = Function::SdnHigh;

const fn ms0(sap: u8) -> Option<(u8, u8)> {
    Some((sap, 62))
}

const SERVICES: [Service; 44] = [
    ("FDL status", Function::FdlStatus, None, ""),
    ("Ident", Function::Ident, None, ""),
    ("LSAP status", Function::LsapStatus, None, ""),
    ("SDA", Function::SdaHigh, None, ""),
    ("SDN, no service", SDN, None, "00 00"),
    ("Data_Exchange", SRD, None, "05 06"),
    ("Data_Exchange, wrong length", SRD, None, "05"),
    ("Data_Exchange, no outputs", SRD, None, ""),
    ("Slave_Diag", SRD, ms0(60), ""),
    ("Slave_Diag with data", SRD, ms0(60), "00"),
    ("Set_Prm", SRD, ms0(61), "80 01 01 00 12 34 00 80 00 00"),
    ("Set_Prm, faulty", SRD, ms0(61), "80 01 01 00 FF FF 00"),
    ("Set_Prm, too short", SRD, ms0(61), "80"),
    ("Set_Prm, unlock", SRD, ms0(61), "40 01 01 00 12 34 00"),
    ("Set_Prm, min T_SDR", SRD, ms0(61), "00 00 00 14 12 34 00"),
    ("Set_Ext_Prm", SRD, ms0(53), "05 81 00 00 00"),
    ("Chk_Cfg", SRD, ms0(62), "11 21"),
    ("Chk_Cfg, wrong", SRD, ms0(62), "FF"),
    ("Get_Cfg", SRD, ms0(59), ""),
    ("Get_Cfg with data", SRD, ms0(59), "00"),
    ("RD_Inp", SRD, ms0(56), ""),
    ("RD_Inp with data", SRD, ms0(56), "00"),
    ("RD_Outp", SRD, ms0(57), ""),
    ("RD_Outp with data", SRD, ms0(57), "00"),
    ("Set_Slave_Add", SRD, ms0(55), "08 12 34 00"),
    ("Set_Slave_Add, wrong ident", SRD, ms0(55), "08 FF FF 00"),
    ("Global_Control", SDN, ms0(58), "20 00"),
    ("Global_Control as SRD", SRD, ms0(58), "20 00"),
    ("MS1 poll", SRD, Some((51, 51)), ""),
    ("MS1 Read", SRD, Some((51, 51)), "5E 01 10 04"),
    ("MS1 Read, malformed", SRD, Some((51, 51)), "5E 01"),
    ("MS1 unknown function", SRD, Some((51, 51)), "48"),
    ("MS1 Alarm_Ack", SRD, Some((51, 51)), "5C 00 01 08"),
    ("alarm SAP poll", SRD, Some((50, 51)), ""),
    ("alarm SAP Alarm_Ack", SRD, Some((50, 51)), "5C 00 01 08"),
    ("resource manager poll", SRD, Some((49, 50)), ""),
    ("resource manager Initiate", SRD, Some((49, 50)), INITIATE),
    ("resource manager, else", SRD, Some((49, 50)), "48"),
    ("MS2 without connection", SRD, Some((48, 50)), "5E 00 10 04"),
    ("SAP 52", SRD, Some((52, 62)), ""),
    ("SAP 54", SRD, Some((54, 62)), ""),
    ("SAP 63", SRD, Some((63, 62)), ""),
    ("only a DSAP", SRD, Some((60, 255)), ""),
    ("reserved function", Function::Other(2), None, ""),
];

/// The answer, and the state after it where it is another one.
fn ask(service: &Service, state: &str, sa: u8) -> String {
    let (_, function, saps, du) = service;
    let mut rig = slave_in(state);
    let before = rig.slave.state().to_string();
    let count = match function {
        Function::SrdHigh => FrameCount::First,
        _ => FrameCount::Uncounted,
    };
    let fc = Control::Request { function: *function, count }.to_octet();
    let (dsap, ssap) = saps.unzip();
    let du = hex(du);
    let data = DataTelegram { da: SLAVE, sa, dsap, ssap: ssap.filter(|ssap| *ssap != 255), fc, du: &du };
    let octets = rig.raw(&emit(&Telegram::Data(data)));
    let answer = short(&rig::read(&data, octets.as_deref()));
    let after = rig.slave.state().to_string();
    let fault = if matches!(rig.slave.state(), SlaveState::WaitPrm(_)) { fault(&mut rig) } else { "" };
    if before == after && fault.is_empty() { answer } else { format!("{answer} {after}{fault}") }
}

/// The fault in the diagnosis, for a master that has not read it yet.
fn fault(rig: &mut Rig) -> &'static str {
    match &rig.diag(1)[..2] {
        "42" => " Prm_Fault",
        "06" => " Cfg_Fault",
        _ => "",
    }
}

/// profibus-wire 3.1
#[test]
fn every_service_is_answered_in_every_state_as_in_the_golden() {
    let head = std::iter::once("service").chain(COLUMNS.iter().map(|(name, ..)| *name)).map(str::to_owned).collect();
    let rows = SERVICES.iter().map(|service| {
        let cells = COLUMNS.iter().map(|(_, state, sa)| ask(service, state, *sa));
        std::iter::once(service.0.to_owned()).chain(cells).collect()
    });
    let rows: Vec<Vec<String>> = std::iter::once(head).chain(rows).collect();
    compare(
        "services.txt",
        &format!(
            "What a slave answers: SC, DL, DH, OK, RS (closed), RR (no room), - (nothing); then the state, if it changed.\n\
             The device has two octets each way, DP-V1 is enabled, Fail_Safe is not.\n\n{}",
            table(&rows)
        ),
    );
}

/// T at 1.5 Mbit/s.
const T: u64 = 1_500_000;

const PHASES: [&str; 6] = ["free", "Initiate answered", "Initiate refused", "open", "answered", "aborting"];

fn connection_in(phase: &str) -> Rig {
    let mut rig = Rig::new(Gauge::default());
    match phase {
        "free" => {}
        "Initiate answered" => assert_eq!(rig.ms2(1, 49, INITIATE), low("56 30 00 64")),
        "Initiate refused" => assert_eq!(rig.ms2(1, 49, &INITIATE.replace("64 01", "64 00")), low("56 30 00 64")),
        "aborting" => assert_eq!(rig.ms2(1, 49, "57"), low("56 30 00 64")),
        _ => assert_eq!(rig.connect(1), 48),
    }
    if phase == "answered" {
        assert_eq!(rig.ms2(1, 48, "5E 00 10 04"), Answer::Ack);
    }
    rig
}

/// An input: a request of the master, or a number of T.
#[derive(Clone, Copy)]
enum Input {
    Sends(&'static str),
    OtherMaster,
    OtherSap,
    Passes(u64),
}

const INPUTS: [(&str, Input); 12] = [
    ("poll", Input::Sends("")),
    ("Read", Input::Sends("5E 00 10 02")),
    ("Read, malformed", Input::Sends("5E 00")),
    ("Write", Input::Sends("5F 00 10 01 AA")),
    ("Data_Transport", Input::Sends("51 00 00 01 00")),
    ("Idle", Input::Sends("48")),
    ("Initiate", Input::Sends(INITIATE)),
    ("unknown function", Input::Sends("00")),
    ("Abort", Input::Sends("58 00 20")),
    ("another master", Input::OtherMaster),
    ("another SSAP", Input::OtherSap),
    ("T passes", Input::Passes(1)),
];

fn full(answer: &Answer) -> String {
    match answer {
        Answer::Low(pdu) => format!("DL {}", text(&pdu[..pdu.len().min(4)])),
        other => short(other),
    }
}

/// The answer to the input, and the response that the next poll fetches.
fn step(phase: &str, input: Input) -> String {
    let mut rig = connection_in(phase);
    let answer = match input {
        Input::Sends(pdu) => full(&rig.ms2(1, 48, pdu)),
        Input::OtherMaster => full(&rig.ms2(OTHER, 48, "48")),
        Input::OtherSap => full(&rig.srd(1, Some(48), Some(51), &hex("48"))),
        Input::Passes(times) => {
            rig.pass(times * T);
            "-".to_owned()
        }
    };
    format!("{answer} / {}", full(&rig.ms2(1, 48, "")))
}

#[test]
fn every_request_is_answered_in_every_phase_of_a_connection_as_in_the_golden() {
    let head = std::iter::once("input").chain(PHASES).map(str::to_owned).collect();
    let more = [("2 T pass", Input::Passes(2)), ("3 T pass", Input::Passes(3))];
    let rows = INPUTS.iter().chain(&more).map(|(name, input)| {
        let cells = PHASES.iter().map(|phase| step(phase, *input));
        std::iter::once((*name).to_owned()).chain(cells).collect()
    });
    let rows: Vec<Vec<String>> = std::iter::once(head).chain(rows).collect();
    compare(
        "ms2.txt",
        &format!(
            "What an MS2 connection answers / what the next poll fetches: the first octets of a DL, SC, RS (closed), RR.\n\
             58 00 12 is Abort ABT_FE, 58 00 13 ABT_TO, 58 00 17 ABT_IA.\n\n{}",
            table(&rows)
        ),
    );
}
