//! Slaves with a fault in their layer 2, and in their first answers.

use super::*;

pub static SLAVES: &[FaultySlave] = &[
    slave(
        "layer2.fdl-status",
        "refuses FDL status with RS",
        ChangesAnswer(|request, answer| {
            if request.function() == FDL_STATUS {
                answer.fc = RS;
            }
        }),
    ),
    slave(
        "layer2.station-type",
        "reports that it is a master",
        ChangesAnswer(|request, answer| {
            if request.function() == FDL_STATUS {
                answer.fc = 0x20;
            }
        }),
    ),
    slave(
        "layer2.addresses",
        "sends the addresses as it received them",
        ChangesAnswer(|request, answer| {
            (answer.da, answer.sa) = (request.da, request.sa);
        }),
    ),
    slave("count.first", "takes a first request for a repetition", Counts(Counting::CountsFirst)),
    slave(
        "diagnosis.answer",
        "sends a diagnosis of five octets",
        ChangesAnswer(|request, answer| {
            if request.dsap == SLAVE_DIAG {
                answer.du.truncate(5);
            }
        }),
    ),
    slave(
        "layer2.access-points",
        "sends the access points as it received them",
        ChangesAnswer(|request, answer| {
            if answer.dsap.is_some() {
                (answer.dsap, answer.ssap) = (request.dsap, request.ssap);
            }
        }),
    ),
    slave(
        "layer2.low-priority",
        "ignores Slave_Diag of low priority",
        Answers(
            |_, request, answer| {
                if request.dsap == SLAVE_DIAG && request.function() == 0xC { Received::Nothing } else { answer }
            },
        ),
    ),
    slave(
        "layer2.sd3",
        "ignores SD3",
        Reacts(|| Box::new(|line, octets| if octets[0] == 0xA2 { Received::Nothing } else { line.send(octets) })),
    ),
    slave(
        "layer2.closed",
        "acknowledges requests to any access point",
        Answers(|_, request, answer| if request.dsap == Some(52) && is_rs(&answer) { sc() } else { answer }),
    ),
    slave(
        "layer2.other-station",
        "answers requests to the address of the master",
        ChangesRequest(|request| {
            if request.da == MASTER {
                request.da = ADDRESS;
            }
        }),
    ),
    slave(
        "layer2.broadcast",
        "answers broadcast requests",
        ChangesRequest(|request| {
            if request.da == 127 && matches!(request.function(), FDL_STATUS | 0xD) {
                request.da = ADDRESS;
            }
        }),
    ),
    slave(
        "layer2.own-source",
        "answers requests from its own address",
        ChangesRequest(|request| {
            if request.sa == ADDRESS {
                request.sa = 1;
            }
        }),
    ),
    slave(
        "layer2.broadcast-source",
        "answers requests from address 127",
        ChangesRequest(|request| {
            if request.sa == 127 {
                request.sa = 1;
            }
        }),
    ),
    slave(
        "layer2.token",
        "acknowledges a token",
        Reacts(|| Box::new(|line, octets| if octets[0] == 0xDC { sc() } else { line.send(octets) })),
    ),
    slave(
        "layer2.short-ack",
        "acknowledges SC",
        Reacts(|| Box::new(|line, octets| if octets == [0xE5] { sc() } else { line.send(octets) })),
    ),
    slave(
        "layer2.response",
        "acknowledges a response",
        Answers(|_, request, answer| if request.fc & 0x40 == 0 { sc() } else { answer }),
    ),
    slave(
        "damage.start-delimiter",
        "ignores bit 2 of the first octet",
        Reacts(|| damaged::repaired(|octets| octets[0] = if octets[0] == 0x14 { 0x10 } else { octets[0] & !0x04 })),
    ),
    slave(
        "damage.length",
        "does not compare LE with LEr",
        Reacts(|| {
            damaged::repaired(|octets| {
                if octets.len() > 6 {
                    octets[1] = octets.len() as u8 - 6;
                    octets[2] = octets[1];
                }
            })
        }),
    ),
    slave(
        "damage.second-start",
        "does not look at the second 68",
        Reacts(|| {
            damaged::repaired(|octets| {
                if octets.len() > 6 {
                    octets[3] = 0x68;
                }
            })
        }),
    ),
    slave(
        "damage.check-octet",
        "does not check the check octet",
        Reacts(|| {
            damaged::repaired(|octets| {
                let end = octets.len() - 2;
                let first = if octets[0] == 0x68 { 4 } else { 1 };
                if end > first {
                    octets[end] = octets[first..end].iter().fold(0, |sum: u8, octet| sum.wrapping_add(*octet));
                }
            })
        }),
    ),
    slave(
        "damage.end-delimiter",
        "does not look at the end delimiter",
        Reacts(|| damaged::repaired(|octets| *octets.last_mut().unwrap() = 0x16)),
    ),
    slave(
        "damage.cut-off",
        "acknowledges the beginning of a telegram",
        Reacts(|| {
            Box::new(|line, octets| if octets.len() == 6 && octets[0] == 0x68 { sc() } else { line.send(octets) })
        }),
    ),
    slave("damage.next", "ignores one telegram after the beginning of another one", Reacts(damaged::ignores_the_next)),
];
