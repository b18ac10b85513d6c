//! Faults on purpose: each is a change of the answers of a slave, and the comparison must find it.

use crate::slave_model::line::Fault;

/// Name and change.
pub const FAULTS: &[(&str, Fault)] = &[
    ("a constant that is read over MS1 or MS2", |answer| {
        pdu(answer, 0x5E, |it| it[1..3] == [1, 24], |it| it[4] ^= 0x10)
    }),
    ("a stored octet that is read", |answer| pdu(answer, 0x5E, |it| it[1..3] == [1, 39], |it| it[4] ^= 1)),
    ("the state of the device", |answer| pdu(answer, 0x5E, |it| it[1..3] == [0, 25], |it| it[4] = 2)),
    ("a text", |answer| pdu(answer, 0x5E, |it| it[1..3] == [0, 19], |it| it[4] = b'L')),
    ("the code of a refused write: range", |answer| pdu(answer, 0xDF, |it| it[2] == 0xB7, |it| it[2] = 0xB5)),
    ("a write outside the range that is confirmed", |answer| {
        pdu(answer, 0xDF, |it| it[2] == 0xB7, |it| it[0] = 0x5F);
    }),
    ("a write of a wrong length that is confirmed", |answer| {
        pdu(answer, 0xDF, |it| it[2] == 0xB1, |it| it[0] = 0x5F);
    }),
    ("the code of the mode that forbids a write", |answer| pdu(answer, 0xDF, |it| it[3] == 17, |it| it[3] = 18)),
    ("a word for an octet in the parameter channel", |answer| channel(answer, 0xB0, |it| it[0] = 0x10)),
    ("a double word for a word in the parameter channel", |answer| channel(answer, 0x10, |it| it[0] = 0x20)),
    ("an error number of the parameter channel", |answer| channel(answer, 0x70, |it| it[7] ^= 1)),
    ("the index of an answer of the parameter channel", |answer| channel(answer, 0x70, |it| it[2] ^= 1)),
    ("a value in the parameter channel", |answer| channel(answer, 0x20, |it| it[4] ^= 0x40)),
    ("Exception Status in the inputs", |answer| {
        if answer.len() == 13 + 9 {
            answer[7 + 8] ^= 4;
        }
    }),
    ("SC in place of RR while a request is executed", |answer| {
        if answer.len() == 6 && answer[3] == 2 {
            *answer = vec![0xE5];
        }
    }),
    ("the reason of an Abort", |answer| pdu(answer, 0x58, |_| true, |it| it[2] ^= 1)),
    ("the longest data of an Initiate response", |answer| pdu(answer, 0x57, |_| true, |it| it[1] = 100)),
    ("the SAP of a connection", |answer| pdu(answer, 0x56, |_| true, |it| it[1] -= 1)),
];

/// Changes the answers with SAPs whose function is this.
fn pdu(answer: &mut [u8], function: u8, which: impl Fn(&[u8]) -> bool, change: impl Fn(&mut [u8])) {
    let end = answer.len().saturating_sub(2);
    if answer.first() == Some(&0x68)
        && answer.get(4).is_some_and(|it| it & 0x80 != 0)
        && let Some(pdu) = answer.get_mut(9..end)
        && pdu.len() >= 4 - usize::from(function == 0x58)
        && pdu[0] == function
        && which(pdu)
    {
        change(pdu);
    }
}

/// Changes the inputs with this octet at the beginning of the parameter channel.
fn channel(answer: &mut [u8], first: u8, change: impl Fn(&mut [u8])) {
    if matches!(answer.len(), 22 | 24)
        && answer[4] & 0x80 == 0
        && let Some(octets) = answer.get_mut(7..15)
        && octets[0] == first
    {
        change(octets);
    }
}
