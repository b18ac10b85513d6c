//! Data exchange. profibus-wire 2.8 to 2.10. Outputs are zeros, as a master in Clear sends them.

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
        rule: "a diagnosis that the owner has fetched is not announced any more",
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
        rule: "Global_Control is not answered, to all or to one, by the owner or another",
        section: "2.9",
        run: global_control,
    },
    Check { name: "exchange.ms1-closed", rule: "MS1 is closed outside data exchange", section: "4.3", run: ms1_closed },
];

fn inputs(talk: &mut Dialogue<'_>) -> CheckOutcome {
    talk.start([0, 0])?;
    for _ in 0..4 {
        talk.exchange()?;
    }
    talk.release()
}

fn diagnosis_flag(talk: &mut Dialogue<'_>) -> CheckOutcome {
    talk.start([0, 0])?;
    talk.diagnosis()?;
    let outputs = talk.outputs();
    let answer = talk.request(Sap::Default, &outputs)?;
    let announced = matches!(answer, Answer::Frame { status: Status::DataHigh, .. });
    // Stat_Diag stays announced.
    let [_, second, ..] = talk.diagnosis()?;
    require(!announced || second & 0x02 != 0, "DL: its diagnosis was fetched")?;
    talk.release()
}

fn wrong_length(talk: &mut Dialogue<'_>) -> CheckOutcome {
    talk.start([0, 0])?;
    let mut outputs = talk.outputs();
    let right = outputs.clone();
    outputs.push(0);
    let refused = Answer::Frame { status: Status::NoResource, du: Vec::new() };
    if talk.request(Sap::Default, &outputs)? == refused {
        talk.exchange()?;
    } else {
        talk.expect_closed(Sap::Default, &right, "RS: the outputs before were too long")?;
    }
    talk.release()
}

fn read(talk: &mut Dialogue<'_>) -> CheckOutcome {
    talk.start([0, 0])?;
    talk.exchange()?;
    let lengths = talk.lengths();
    for (sap, length) in [(Sap::RdInp, lengths.inputs), (Sap::RdOutp, lengths.outputs)] {
        let other = talk.other_master_address();
        let came = match talk.request_from(other, sap, &[])? {
            Answer::ShortAck => 0,
            Answer::Frame { du, .. } => du.len(),
        };
        require(came == usize::from(length), &format!("{length} octets"))?;
    }
    talk.release()
}

fn global_control(talk: &mut Dialogue<'_>) -> CheckOutcome {
    const SDN_HIGH: u8 = 0x46;
    const CLEAR_ALL: [u8; 2] = [0x02, 0];
    talk.start([0, 0])?;
    for (da, sa) in [
        (BROADCAST, talk.own_address()),
        (talk.slave.address, talk.own_address()),
        (BROADCAST, talk.other_master_address()),
    ] {
        let command = octets(da, sa, Sap::GlobalControl, SDN_HIGH, &CLEAR_ALL);
        require(talk.send(&command)? == Received::Nothing, "silence: nobody answers SDN")?;
    }
    talk.exchange()?;
    talk.release()
}

fn ms1_closed(talk: &mut Dialogue<'_>) -> CheckOutcome {
    talk.release()?;
    talk.expect_closed(Sap::Ms1, &[0x5E, 0, 1, 4], "RS: it is not in data exchange")
}
