//! Slaves with one fault that several services have in common. It counts once.

use super::faulty::{CHK_CFG, Fault, Frame, GLOBAL_CONTROL, MS1, Reaction, SET_PRM, SLAVE_DIAG, is_waiting, leave, sc};
use super::slave::{ADDRESS, MASTER};
use Fault::{Answers, ChangesAnswer, ChangesRequest, Reacts};
use profivac_conform::probe::Received;

/// The rule that is broken, what the slave does, and how.
pub static COMPOUND: &[(&str, &str, Fault)] = &[
    ("lock.set-prm", "does not look at the owner", Reacts(ignores_the_owner)),
    (
        "diagnosis.any-master",
        "answers one master only",
        Answers(|_, request, answer| {
            if matches!(request.function(), 0xC | 0xD) && request.sa != MASTER { Received::Nothing } else { answer }
        }),
    ),
    (
        "layer2.other-station",
        "does not look at the destination",
        Reacts(|| {
            Box::new(|line, octets| match Frame::parse(octets) {
                Some(request) if request.fc & 0x40 != 0 => {
                    let received = line.send(&Frame { da: ADDRESS, ..request.clone() }.octets());
                    if request.dsap == GLOBAL_CONTROL && request.da == 127 { sc() } else { received }
                }
                _ => line.send(octets),
            })
        }),
    ),
    (
        "layer2.own-source",
        "does not look at the source",
        ChangesRequest(|request| {
            if matches!(request.sa, ADDRESS | 127) {
                request.sa = 1;
            }
        }),
    ),
    (
        "watchdog.expiry",
        "has no watchdog",
        ChangesRequest(|request| {
            if request.dsap == SET_PRM && request.du.len() >= 7 {
                request.du[0] &= !0x08;
            }
        }),
    ),
    (
        "control.sync",
        "has neither Sync nor Freeze and does not say so",
        ChangesAnswer(|request, answer| {
            if request.dsap == SLAVE_DIAG && answer.du.len() >= 6 {
                answer.du[1] &= !0x30;
            }
        }),
    ),
    (
        "control.broadcast",
        "acknowledges Global_Control",
        Answers(
            |_, request, answer| {
                if request.dsap == GLOBAL_CONTROL && request.function() == 6 { sc() } else { answer }
            },
        ),
    ),
    (
        "ms1.low-priority",
        "sends responses of DP-V1 with high priority",
        ChangesAnswer(|request, answer| {
            if (request.dsap == MS1 || request.is_connection()) && answer.fc == 8 {
                answer.fc = 0x0A;
            }
        }),
    ),
    (
        "ms1.error-decode",
        "sends a reserved Error_Decode",
        ChangesAnswer(|request, answer| {
            if (request.dsap == MS1 || request.is_connection()) && answer.du.first() == Some(&0xDE) {
                answer.du[1] = 0x81;
            }
        }),
    ),
];

/// A slave that any master parameterises, configures, commands and exchanges data with.
fn ignores_the_owner() -> Box<Reaction> {
    Box::new(|line, octets| {
        let Some(request) = Frame::parse(octets) else { return line.send(octets) };
        let of_owner = request.is_exchange() || matches!(request.dsap, CHK_CFG | GLOBAL_CONTROL | MS1);
        let owner = line.slave.state().owner().map(|owner| owner.master);
        if request.dsap == SET_PRM && owner.is_some_and(|owner| owner != request.sa) && !is_waiting(&line.slave) {
            leave(line);
        }
        match owner {
            Some(owner) if of_owner && owner != request.sa => line.send(&Frame { sa: owner, ..request }.octets()),
            _ => line.send(octets),
        }
    })
}
