//! Layer 2: the telegrams that a slave answers (profibus-wire 1.2 to 1.8).

use super::contact::fdl_status_telegram;
use super::{Check, NO_SERVICE};
use crate::dialogue::{CheckOutcome, Dialogue, SRD_HIGH_FIRST, Step, octets, require};
use crate::expected::{Closed, Expected, Unanswered};
use profivac_wire::control::{Control, Function, Status};
use profivac_wire::{BROADCAST, Sap};

pub const CHECKS: &[Check] = &[
    Check::new("layer2.low-priority", "1.4", "a request of low priority is answered like one of high priority", low)
        .after(&["diagnosis.answer"]),
    Check::new("layer2.sd3", "1.2", "a request with eight octets is accepted as SD3", sd3),
    Check::new("layer2.closed", "1.8", "a request to an access point that does not exist is answered with RS", closed),
    Check::new("layer2.other-station", "1.8", "a request to another station is not answered", other_station),
    Check::new("layer2.broadcast", "1.8", "a request to all stations is not answered", broadcast)
        .unless_broken(&["layer2.other-station"]),
    Check::new("layer2.own-source", "1.8", "a request from the slave's own address is not answered", own_source),
    Check::new("layer2.broadcast-source", "1.8", "a request from address 127 is not answered", broadcast_source)
        .unless_broken(&["layer2.own-source"]),
    Check::new("layer2.token", "1.8", "a token is not answered", token),
    Check::new("layer2.short-ack", "1.8", "SC is not answered", short_ack),
    Check::new("layer2.response", "1.8", "a response is not answered", response),
];

fn low(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let own = dialogue.own_address();
    let fc = Control::Request { function: Function::SrdLow, count: dialogue.next_count(own) }.to_octet();
    let telegram = octets(dialogue.slave.address, own, Sap::SlaveDiag, fc, &[]);
    let answer = dialogue.transmit(own, &telegram).tested()?;
    require(answer.has_data_status() && answer.du.len() >= 6, Expected::Diagnosis).tested()
}

/// Chk_Cfg to a slave that may wait for parameters: it answers with any status. The preparation sends the same as SD2.
fn sd3(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    const IDENTIFIERS: [u8; 6] = [0; 6];
    dialogue.release()?;
    dialogue.request(Sap::ChkCfg, &IDENTIFIERS).prepared()?;
    let own = dialogue.own_address();
    let sd2 = dialogue.next_telegram(own, Sap::ChkCfg, &IDENTIFIERS);
    // SD3 has the octets of SD2 from DA to ED.
    let telegram: Vec<_> = [0xA2].into_iter().chain(sd2.into_iter().skip(4)).collect();
    dialogue.transmit(own, &telegram).map(|_| ()).tested()
}

fn closed(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let reason = Closed::NoSuchAccessPoint(NO_SERVICE);
    dialogue.expect_closed(dialogue.own_address(), Sap::Other(NO_SERVICE), &[], reason).tested()
}

/// The other station is the testing master itself, because no other station can have this address.
fn other_station(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let (da, sa) = (dialogue.own_address(), dialogue.other_master_address());
    for telegram in [fdl_status_telegram(da, sa), octets(da, sa, Sap::SlaveDiag, SRD_HIGH_FIRST, &[])] {
        dialogue.send_unanswered(&telegram, Unanswered::OtherStation).tested()?;
    }
    Ok(())
}

fn broadcast(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let own = dialogue.own_address();
    for telegram in [fdl_status_telegram(BROADCAST, own), octets(BROADCAST, own, Sap::SlaveDiag, SRD_HIGH_FIRST, &[])] {
        dialogue.send_unanswered(&telegram, Unanswered::Broadcast).tested()?;
    }
    Ok(())
}

fn own_source(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let slave = dialogue.slave.address;
    dialogue.send_unanswered(&fdl_status_telegram(slave, slave), Unanswered::OwnSource).tested()
}

fn broadcast_source(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let telegram = fdl_status_telegram(dialogue.slave.address, BROADCAST);
    dialogue.send_unanswered(&telegram, Unanswered::BroadcastSource).tested()
}

fn token(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let token = [0xDC, dialogue.slave.address, dialogue.own_address()];
    dialogue.send_unanswered(&token, Unanswered::Token).tested()
}

fn short_ack(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.send_unanswered(&[0xE5], Unanswered::ShortAck).tested()
}

fn response(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    let fc = Control::slave(Status::DataLow).to_octet();
    let telegram = octets(dialogue.slave.address, dialogue.own_address(), Sap::SlaveDiag, fc, &[0; 6]);
    dialogue.send_unanswered(&telegram, Unanswered::Response).tested()
}
