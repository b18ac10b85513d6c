//! Whether a telegram is the answer to a request. profibus-wire 1.3, 1.5 and 2.8.
//!
//! An answer comes from the station that the request went to, is addressed to this station, has swapped access points, and has
//! a function code and a form that the request allows. A late or repeated answer to another request never becomes a value.

use super::request::{Answer, Kind, Mismatch, OpenRequest};
use profivac_wire::control::{Control, StationType, Status};
use profivac_wire::{DataTelegram, Telegram};

/// The answer in `telegram`, received by the station `address` that waits for it.
#[inline]
pub(super) fn matched<'a>(request: &OpenRequest, address: u8, telegram: &Telegram<'a>) -> Result<Answer<'a>, Mismatch> {
    match telegram {
        Telegram::Data(data) => matched_data(request, address, data),
        Telegram::ShortAck => match request.kind {
            Kind::Reply => Ok(short(Status::NoReply)),
            Kind::Acknowledge => Ok(short(Status::Ok)),
            Kind::FdlStatus | Kind::Information | Kind::Unconfirmed => Err(Mismatch::Form),
        },
        Telegram::Token { .. } => Err(Mismatch::Form),
    }
}

/// SC does not name its sender.
const fn short(status: Status) -> Answer<'static> {
    Answer { station: StationType::Slave, status, du: &[], repetitions: 0 }
}

fn matched_data<'a>(request: &OpenRequest, address: u8, data: &DataTelegram<'a>) -> Result<Answer<'a>, Mismatch> {
    let Control::Response { station, status } = data.control() else { return Err(Mismatch::Function(data.fc)) };
    if data.da != address {
        return Err(Mismatch::Destination(data.da));
    }
    if data.sa != request.da {
        return Err(Mismatch::Source(data.sa));
    }
    let carries_data = carries_data(request.kind, status).ok_or(Mismatch::Function(data.fc))?;
    let bare = data.dsap.is_none() && data.ssap.is_none() && data.du.is_empty();
    let swapped = data.dsap == request.ssap && data.ssap == request.dsap;
    match (carries_data, bare, swapped) {
        // An SD1 never has access points.
        (_, true, _) | (true, _, true) => Ok(Answer { station, status, du: data.du, repetitions: 0 }),
        (true, false, false) => Err(Mismatch::AccessPoint),
        (false, false, _) => Err(Mismatch::Form),
    }
}

/// Whether an answer with `status` may carry data; `None` if a request of this kind has no such answer.
const fn carries_data(kind: Kind, status: Status) -> Option<bool> {
    match (kind, status) {
        (Kind::Reply, Status::DataLow | Status::DataHigh | Status::DataLowNotTaken | Status::DataHighNotTaken)
        | (Kind::Information, Status::DataLow) => Some(true),
        (Kind::Reply, Status::NoReply)
        | (Kind::Acknowledge | Kind::FdlStatus, Status::Ok)
        | (
            Kind::Reply | Kind::Acknowledge | Kind::Information,
            Status::UserError | Status::NoResource | Status::ServiceNotActivated,
        ) => Some(false),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    const EXCHANGE: OpenRequest = OpenRequest { da: 8, kind: Kind::Reply, dsap: None, ssap: None };
    const DIAG: OpenRequest = OpenRequest { da: 8, kind: Kind::Reply, dsap: Some(60), ssap: Some(62) };
    const FDL_STATUS: OpenRequest = OpenRequest { da: 8, kind: Kind::FdlStatus, dsap: None, ssap: None };

    /// The result of the octets in `text` at master 2: status and data, or the mismatch.
    fn heard(request: OpenRequest, text: &str) -> Result<(Status, Vec<u8>), Mismatch> {
        let octets: Vec<u8> = text.split_whitespace().map(|octet| u8::from_str_radix(octet, 16).unwrap()).collect();
        matched(&request, 2, &Telegram::parse(&octets).unwrap()).map(|answer| (answer.status, answer.du.to_vec()))
    }

    #[test]
    fn the_answers_in_the_reference_match_their_requests() {
        for (request, text, status, du) in [
            (FDL_STATUS, "10 02 08 00 0A 16", Status::Ok, &[][..]),
            (EXCHANGE, "68 05 05 68 02 08 08 01 02 15 16", Status::DataLow, &[1, 2]),
            (EXCHANGE, "68 05 05 68 02 08 0A 01 02 17 16", Status::DataHigh, &[1, 2]),
            (EXCHANGE, "E5", Status::NoReply, &[]),
            (EXCHANGE, "10 02 08 09 13 16", Status::NoReply, &[]),
            (EXCHANGE, "10 02 08 0A 14 16", Status::DataHigh, &[]),
            (EXCHANGE, "10 02 08 03 0D 16", Status::ServiceNotActivated, &[]),
            (EXCHANGE, "10 02 08 02 0C 16", Status::NoResource, &[]),
            (EXCHANGE, "10 02 08 01 0B 16", Status::UserError, &[]),
            (DIAG, "68 0B 0B 68 82 88 08 3E 3C 02 05 00 FF 12 34 D8 16", Status::DataLow, &[2, 5, 0, 0xFF, 0x12, 0x34]),
            (DIAG, "10 02 08 03 0D 16", Status::ServiceNotActivated, &[]),
        ] {
            assert_eq!(heard(request, text), Ok((status, du.to_vec())), "{text}");
        }
    }

    #[test]
    fn every_mismatch_is_named() {
        for (request, text, mismatch) in [
            // A diagnosis that comes late, while inputs are awaited, and the other way round.
            (EXCHANGE, "68 0B 0B 68 82 88 08 3E 3C 02 05 00 FF 12 34 D8 16", Mismatch::AccessPoint),
            (DIAG, "68 05 05 68 02 08 08 01 02 15 16", Mismatch::AccessPoint),
            // Another service of the same station: the answer of Get_Cfg, profibus-wire 2.7.
            (DIAG, "68 07 07 68 82 88 08 3E 3B 11 21 BD 16", Mismatch::AccessPoint),
            (EXCHANGE, "68 05 05 68 02 09 08 01 02 16 16", Mismatch::Source(9)),
            (EXCHANGE, "68 05 05 68 03 08 08 01 02 16 16", Mismatch::Destination(3)),
            (EXCHANGE, "10 02 08 00 0A 16", Mismatch::Function(0x00)),
            (EXCHANGE, "68 05 05 68 02 08 4D 01 02 5A 16", Mismatch::Function(0x4D)),
            (EXCHANGE, "68 05 05 68 02 08 03 01 02 10 16", Mismatch::Form),
            (FDL_STATUS, "E5", Mismatch::Form),
            (FDL_STATUS, "10 02 08 03 0D 16", Mismatch::Function(0x03)),
            (FDL_STATUS, "68 05 05 68 02 08 00 01 02 0D 16", Mismatch::Form),
            (EXCHANGE, "DC 02 08", Mismatch::Form),
        ] {
            assert_eq!(heard(request, text), Err(mismatch), "{text}");
        }
    }
}
