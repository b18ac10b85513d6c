//! Raw requests, with and without a cycle. profibus-wire 1.10, 2.10 and 2.11.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "helpers of tests are tests")]

use crate::support;

use profivac_dp::link::active::{Active, Answer, BusParameters, Confirmation, Failure, Request};
use profivac_dp::link::{Baud, BitTime};
use profivac_dp::master::{Busy, Master, Mode, Settings, SlaveParameters, services};
use profivac_wire::address::SetSlaveAdd;
use profivac_wire::control::{Function, StationType, Status};
use profivac_wire::diag::SlaveDiag;
use support::line::{From, Line};
use support::plain::Plain;
use support::{bus, text};

const IDENT: u16 = 0x1234;
/// Two octets in, two octets out.
const CFG: [u8; 2] = [0x11, 0x21];

fn line<const SLAVES: usize, const OCTETS: usize>(
    master: Active<Master<SLAVES, OCTETS>>,
    addresses: &[u8],
) -> Line<Master<SLAVES, OCTETS>> {
    let mut line = Line::new(master);
    for address in addresses {
        let mut device = Plain::new(IDENT + u16::from(*address), &CFG);
        device.inputs = vec![1, *address];
        device.address_is_settable = true;
        line.attach(device, *address);
    }
    line
}

/// A master that exchanges with slave 8.
fn exchanging(addresses: &[u8]) -> Line<Master<4, 16>> {
    let mut master = Master::on(bus().check().unwrap(), Settings::new(Baud::B1500000), BitTime(0));
    master.user.add(&SlaveParameters::new(8, IDENT + 8, &CFG)).expect("room for it");
    master.user.set_mode(Mode::Operate);
    let mut line = line(master, addresses);
    line.run_until(100_000, |line| line.master.user.inputs(8).is_some());
    line
}

/// A result without borrowing.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Outcome {
    Sent,
    Answer(Status, Vec<u8>),
    Failed(Failure),
}

/// Submits one request and waits for its result.
fn outcome<const SLAVES: usize, const OCTETS: usize>(
    line: &mut Line<Master<SLAVES, OCTETS>>,
    request: Request<'_>,
) -> Outcome {
    assert_eq!(line.master.user.submit_request(&request), Ok(()));
    let mut result = None;
    line.run_until(100_000, |line| {
        result = line.master.user.take_confirmation().map(|confirmation| match confirmation {
            Confirmation::Sent => Outcome::Sent,
            Confirmation::Answer(Answer { status, du, .. }) => Outcome::Answer(status, du.to_vec()),
            Confirmation::Failed(failure) => Outcome::Failed(failure),
        });
        result.is_some()
    });
    result.expect("there is one now")
}

#[test]
fn a_scan_finds_every_slave_and_never_sends_set_prm() {
    let master = Master::<0, 0>::on(
        BusParameters { hsa: 10, ..bus() }.check().unwrap(),
        Settings::new(Baud::B1500000),
        BitTime(0),
    );
    let mut line = line(master, &[0, 7, 8, 125, 126]);
    let mut found = Vec::new();
    for address in 0..=126 {
        match outcome(&mut line, services::fdl_status(address)) {
            Outcome::Answer(Status::Ok, du) => assert_eq!(du, []),
            other => {
                let expected = if address == 2 { Failure::Impossible } else { Failure::Silence };
                assert_eq!(other, Outcome::Failed(expected), "{address}");
                continue;
            }
        }
        let Outcome::Answer(Status::DataLow, du) = outcome(&mut line, services::slave_diag(address)) else {
            panic!("{address} has a diagnosis");
        };
        let ident = SlaveDiag::parse(&du).unwrap().ident;
        assert_eq!(outcome(&mut line, services::get_cfg(address)), Outcome::Answer(Status::DataLow, CFG.to_vec()));
        found.push((address, ident));
    }
    assert_eq!(found, [0, 7, 8, 125, 126].map(|address| (address, IDENT + u16::from(address))));
    // FDL status, Slave_Diag and Get_Cfg, and nothing else.
    for entry in line.trace.iter().filter(|entry| entry.from == From::Master) {
        let harmless = matches!(
            entry.octets[..],
            [0xDC, 2, 2] | [0x10, _, 2, 0x49, _, 0x16] | [0x68, 5, 5, 0x68, _, 0x82, _, 0x3B | 0x3C, 0x3E, _, 0x16]
        );
        assert!(harmless, "{}", text(&entry.octets));
    }
    // The live list has every station that answered FDL status to the GAP or to the user.
    let live: Vec<_> = line.master.live_list().collect();
    assert_eq!(live, [0, 7, 8, 125, 126].map(|address| (address, StationType::Slave)));
}

#[test]
fn the_frame_count_of_a_station_is_one_for_exchange_diagnosis_and_single_requests() {
    let mut line = exchanging(&[8]);
    let first = line.trace.len();
    assert_eq!(outcome(&mut line, services::rd_inp(8)), Outcome::Answer(Status::DataLow, vec![1, 8]));
    assert_eq!(outcome(&mut line, services::rd_outp(8)), Outcome::Answer(Status::DataLow, vec![0, 0]));
    line.slaves[0].device_mut().diagnose(&[0x02, 0x01]);
    let raw = Request { da: 8, function: Function::SrdLow, dsap: Some(51), ssap: Some(51), du: &[0x5E, 1, 19, 240] };
    assert_eq!(outcome(&mut line, raw), Outcome::Answer(Status::ServiceNotActivated, vec![]));
    assert_eq!(outcome(&mut line, services::slave_diag(8)).clone(), {
        let mut du = vec![0x08, 0x0C, 0x00, 0x02];
        du.extend((IDENT + 8).to_be_bytes());
        du.extend([0x02, 0x01]);
        Outcome::Answer(Status::DataLow, du)
    });
    line.run_for(5_000);
    let counted: Vec<u8> = line.trace[first..]
        .iter()
        .filter(|entry| entry.from == From::Master && entry.octets[0] == 0x68 && entry.octets[4] & 0x7F == 8)
        .map(|entry| entry.octets[6] & 0x30)
        .collect();
    assert!(counted.len() > 10);
    for pair in counted.windows(2) {
        assert_eq!(pair[0] ^ pair[1], 0x20, "FCV stays, FCB toggles: {counted:02X?}");
    }
    let counters = line.master.user.counters(8).unwrap();
    assert_eq!((counters.lost, counters.repetitions), (0, 0));
}

#[test]
fn a_single_request_does_not_cost_an_exchange() {
    let mut line = exchanging(&[8, 9]);
    for _ in 0..50 {
        let (cycles, exchanges) = (line.master.user.cycles(), line.master.user.counters(8).unwrap().exchanges);
        assert!(matches!(outcome(&mut line, services::slave_diag(9)), Outcome::Answer(Status::DataLow, _)));
        line.run_until(10_000, |line| line.trace.last().is_some_and(|entry| entry.octets[0] == 0xDC));
        let cycles = line.master.user.cycles() - cycles;
        let exchanges = line.master.user.counters(8).unwrap().exchanges - exchanges;
        assert!(exchanges.abs_diff(cycles) <= 1, "{exchanges} exchanges in {cycles} cycles");
    }
}

#[test]
fn a_request_to_an_absent_station_fails_and_the_cycle_continues() {
    let mut line = exchanging(&[8]);
    assert_eq!(outcome(&mut line, services::slave_diag(50)), Outcome::Failed(Failure::Silence));
    assert_eq!(outcome(&mut line, services::slave_diag(2)), Outcome::Failed(Failure::Impossible));
    assert_eq!(outcome(&mut line, services::slave_diag(128)), Outcome::Failed(Failure::Impossible));
    assert_eq!(outcome(&mut line, services::set_slave_add(50, &[0; 250])), Outcome::Failed(Failure::Impossible));
    assert_eq!(line.master.user.counters(8).unwrap().lost, 0);
}

#[test]
fn the_slot_is_busy_until_the_result_is_taken() {
    let mut line = exchanging(&[8]);
    assert_eq!(line.master.user.submit_request(&services::get_cfg(8)), Ok(()));
    assert_eq!(line.master.user.submit_request(&services::get_cfg(8)), Err(Busy));
    assert_eq!(line.master.user.take_confirmation(), None);
    line.run_for(5_000);
    assert_eq!(line.master.user.submit_request(&services::get_cfg(8)), Err(Busy));
    let answer = Answer { station: StationType::Slave, status: Status::DataLow, du: &CFG, repetitions: 0 };
    assert_eq!(line.master.user.take_confirmation(), Some(Confirmation::Answer(answer)));
    assert_eq!(line.master.user.submit_request(&services::get_cfg(8)), Ok(()));
}

#[test]
fn a_broadcast_is_sent_and_not_answered() {
    let mut line = exchanging(&[8]);
    let freeze = Request { da: 127, function: Function::SdnHigh, dsap: Some(58), ssap: Some(62), du: &[0x08, 0] };
    assert_eq!(outcome(&mut line, freeze), Outcome::Sent);
    line.slaves[0].device_mut().inputs = vec![9, 9];
    line.run_for(5_000);
    assert_eq!(line.master.user.inputs(8), Some(&[1, 8][..]), "frozen");
}

#[test]
fn a_slave_gets_another_address() {
    let mut line = exchanging(&[8, 126]);
    let mut du = [0; 4];
    let wanted = SetSlaveAdd { address: 5, ident: IDENT + 126, no_add_chg: 0, rem_slave_data: &[] };
    let length = wanted.emit(&mut du).unwrap();
    assert_eq!(
        outcome(&mut line, services::set_slave_add(126, &du[..length])),
        Outcome::Answer(Status::NoReply, vec![])
    );
    assert_eq!(line.slaves[1].address(), 5);
    assert_eq!(outcome(&mut line, services::fdl_status(5)), Outcome::Answer(Status::Ok, vec![]));
    assert_eq!(outcome(&mut line, services::slave_diag(126)), Outcome::Failed(Failure::Silence));
}
