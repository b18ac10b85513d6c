//! Data exchange (profibus-wire 2.8 to 2.10). The outputs are zero, like those of a master in Clear.

use super::Check;
use crate::dialogue::{Answer, CheckOutcome, Dialogue, octets, require};
use crate::probe::Received;
use profivac_wire::control::Status;
use profivac_wire::{BROADCAST, Sap};

pub const CHECKS: &[Check] = &[
    Check {
        name: "exchange.inputs",
        rule: "Data_Exchange answers with as many inputs as the configuration says",
        section: "2.8",
        run: inputs,
    },
    Check {
        name: "exchange.diagnosis-flag",
        rule: "a diagnosis that the owner has read is not announced any more",
        section: "3.3",
        run: diagnosis_flag,
    },
    Check {
        name: "exchange.wrong-length",
        rule: "outputs of another length end data exchange, or are refused with RR",
        section: "2.8",
        run: wrong_length,
    },
    Check {
        name: "exchange.read",
        rule: "RD_Inp and RD_Outp show any master the images of the configured lengths",
        section: "2.10",
        run: read,
    },
    Check {
        name: "exchange.global-control",
        rule: "Global_Control is not answered, to all slaves or to one, from the owner or another master",
        section: "2.9",
        run: global_control,
    },
    Check { name: "exchange.ms1-closed", rule: "MS1 is closed outside data exchange", section: "4.3", run: ms1_closed },
];

fn inputs(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start([0, 0])?;
    for _ in 0..4 {
        dialogue.exchange()?;
    }
    dialogue.release()
}

fn diagnosis_flag(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start([0, 0])?;
    dialogue.diagnosis()?;
    let outputs = dialogue.outputs();
    let answer = dialogue.request(Sap::Default, &outputs)?;
    let announced = matches!(answer, Answer::Data { status: Status::DataHigh, .. });
    // Static diagnosis stays announced after it was read.
    let [_, second, ..] = dialogue.diagnosis()?;
    require(!announced || second & 0x02 != 0, "DL: the owner has read the diagnosis")?;
    dialogue.release()
}

fn wrong_length(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start([0, 0])?;
    let mut outputs = dialogue.outputs();
    let configured = outputs.clone();
    outputs.push(0);
    let refused = Answer::Data { status: Status::NoResource, du: Vec::new() };
    if dialogue.request(Sap::Default, &outputs)? == refused {
        dialogue.exchange()?;
    } else {
        dialogue.expect_closed(Sap::Default, &configured, "RS: the outputs before were too long")?;
    }
    dialogue.release()
}

fn read(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.start([0, 0])?;
    dialogue.exchange()?;
    let lengths = dialogue.lengths();
    for (sap, length) in [(Sap::RdInp, lengths.inputs), (Sap::RdOutp, lengths.outputs)] {
        let other = dialogue.other_master_address();
        let length_received = match dialogue.request_from(other, sap, &[])? {
            Answer::ShortAck => 0,
            Answer::Data { du, .. } => du.len(),
        };
        require(length_received == usize::from(length), &format!("{length} octets"))?;
    }
    dialogue.release()
}

fn global_control(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    const SDN_HIGH: u8 = 0x46;
    const CLEAR_ALL: [u8; 2] = [0x02, 0];
    dialogue.start([0, 0])?;
    for (da, sa) in [
        (BROADCAST, dialogue.own_address()),
        (dialogue.slave.address, dialogue.own_address()),
        (BROADCAST, dialogue.other_master_address()),
    ] {
        let command = octets(da, sa, Sap::GlobalControl, SDN_HIGH, &CLEAR_ALL);
        require(dialogue.send(&command)? == Received::Nothing, "silence: no slave answers SDN")?;
    }
    dialogue.exchange()?;
    dialogue.release()
}

fn ms1_closed(dialogue: &mut Dialogue<'_>) -> CheckOutcome {
    dialogue.release()?;
    dialogue.expect_closed(Sap::Ms1, &[0x5E, 0, 1, 4], "RS: the slave is not in data exchange")
}
