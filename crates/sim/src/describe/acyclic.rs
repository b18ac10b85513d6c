//! PDUs of MS1 and MS2 in English. profibus-wire 4.

use super::Hex;
use profivac_wire::acyclic::{Abort, PduError, Request, Response, Transfer};

/// Describes a PDU from a master.
pub(super) fn request(pdu: &[u8]) -> Result<String, PduError> {
    Ok(match Request::parse(pdu) {
        Err(PduError::Empty) => " poll".to_owned(),
        Err(defect) => return Err(defect),
        Ok(Request::Idle(_)) => " Idle".to_owned(),
        Ok(Request::DataTransport(data)) => format!(" Data_Transport {}", transfer(&data)),
        Ok(Request::Initiate(initiate)) => {
            format!(" Initiate, Send_Timeout {} ms", u32::from(initiate.send_timeout) * 10)
        }
        Ok(Request::Abort(reason)) => abort(&reason),
        Ok(Request::AlarmAck(ack)) => format!(" Alarm_Ack slot {}, alarm type {}", ack.slot, ack.alarm_type),
        Ok(Request::Read(read)) => format!(" Read slot {} index {}, {} octets", read.slot, read.index, read.length),
        Ok(Request::Write(data)) => format!(" Write {}", transfer(&data)),
    })
}

/// Describes a PDU from a slave.
pub(super) fn response(pdu: &[u8]) -> Result<String, PduError> {
    Ok(match Response::parse(pdu)? {
        Response::Idle(_) => " Idle".to_owned(),
        Response::DataTransport(data) => format!(" Data_Transport {}", transfer(&data)),
        Response::ResourceManager(answer) => {
            let timeout = u32::from(answer.min_send_timeout) * 10;
            format!(" connection on SAP {}, Send_Timeout at least {timeout} ms", answer.server_sap)
        }
        Response::Initiate(open) => format!(" Initiate, records up to {} octets", open.max_len_data_unit),
        Response::Abort(reason) => abort(&reason),
        Response::AlarmAck(ack) => format!(" Alarm_Ack slot {}, alarm type {}", ack.slot, ack.alarm_type),
        Response::Read(data) => format!(" Read {}", transfer(&data)),
        Response::Write(done) => format!(" Write slot {} index {}, {} octets", done.slot, done.index, done.length),
        Response::Negative(refusal) => {
            format!(" {} refused: {}, {:02X}", refusal.function, refusal.code_1, refusal.code_2)
        }
    })
}

fn transfer(data: &Transfer<'_>) -> String {
    format!("slot {} index {}: {}", data.slot, data.index, Hex(data.data))
}

fn abort(abort: &Abort<'_>) -> String {
    format!(" Abort, {}", abort.reason)
}

#[cfg(test)]
mod tests {
    use crate::describe::Description;
    use crate::dialogue::hex;
    use profivac_wire::Telegram;

    /// The telegrams of profibus-wire 4.4 and 4.6.6 with their descriptions after the addresses.
    #[test]
    fn the_dialogues_of_the_specification_are_described() {
        for (text, words) in [
            ("68 09 09 68 88 82 5C 33 33 5E 01 10 14 4F 16", "MS1 FCB 0 Read slot 1 index 16, 20 octets"),
            ("68 05 05 68 88 82 7C 33 33 EC 16", "MS1 FCB 1 poll"),
            ("68 0D 0D 68 82 88 08 33 33 5E 01 10 04 11 22 33 44 95 16", "MS1 DL Read slot 1 index 16: 11 22 33 44"),
            ("68 0B 0B 68 88 82 7C 33 33 5F 01 20 02 00 64 D2 16", "MS1 FCB 1 Write slot 1 index 32: 00 64"),
            ("68 09 09 68 82 88 08 33 33 DF 80 B6 00 8D 16", "MS1 DL Write refused: access denied (B6), 00"),
            (
                "68 19 19 68 88 82 6C 31 32 57 00 00 00 00 64 01 00 00 00 00 00 00 02 00 02 00 00 00 00 99 16",
                "MS2 Initiate first Initiate, Send_Timeout 1000 ms",
            ),
            (
                "68 09 09 68 82 88 08 32 31 56 30 00 64 5F 16",
                "MS2 Initiate DL connection on SAP 48, Send_Timeout at least 1000 ms",
            ),
            (
                "68 15 15 68 82 88 08 32 30 57 F0 01 00 00 00 00 00 00 02 00 02 00 00 00 00 C0 16",
                "MS2 SAP 48 DL Initiate, records up to 240 octets",
            ),
            ("68 06 06 68 88 82 5C 30 32 48 10 16", "MS2 SAP 48 FCB 0 Idle"),
            ("68 08 08 68 88 82 5C 30 32 58 00 20 40 16", "MS2 SAP 48 FCB 0 Abort, user (20)"),
        ] {
            let report = Description(&Telegram::parse(&hex(text)).unwrap()).to_string();
            let report = report.split_whitespace().skip(3).collect::<Vec<_>>().join(" ");
            assert_eq!(report, words, "{text}");
        }
    }
}
