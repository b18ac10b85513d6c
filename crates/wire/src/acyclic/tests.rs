//! Every PDU of profibus-wire 4.1.1 and 4.1.2 with the telegrams printed in profibus-wire 4.4 to 4.8 and 5.4.

extern crate std;

use super::initiate::{AddAddr, Capabilities, Network};
use super::*;
use crate::TooLong;
use crate::testing::{du, hex};
use std::vec::Vec;

const HERE: AddAddr<'_> = AddAddr { api: 0, scl: 0, network: None };

/// Requests: telegram and content.
fn requests() -> [(&'static str, Request<'static>); 9] {
    let initiate =
        Initiate { send_timeout: 100, capabilities: Capabilities::READ_WRITE, source: HERE, destination: HERE };
    [
        // profibus-wire 4.4
        ("68 09 09 68 88 82 5C 33 33 5E 01 10 14 4F 16", Request::Read(Access { slot: 1, index: 16, length: 20 })),
        (
            "68 0B 0B 68 88 82 7C 33 33 5F 01 20 02 00 64 D2 16",
            Request::Write(Transfer { slot: 1, index: 32, data: &[0, 0x64] }),
        ),
        // profibus-wire 4.5
        (
            "68 09 09 68 88 82 5C 33 33 5C 03 02 10 3D 16",
            Request::AlarmAck(AlarmAck { slot: 3, alarm_type: 2, specifier: 0x10 }),
        ),
        // profibus-wire 4.6.6
        (
            "68 19 19 68 88 82 6C 31 32 57 00 00 00 00 64 01 00 00 00 00 00 00 02 00 02 00 00 00 00 99 16",
            Request::Initiate(initiate),
        ),
        ("68 09 09 68 88 82 5C 30 32 5E 00 10 1A 50 16", Request::Read(Access { slot: 0, index: 16, length: 26 })),
        ("68 06 06 68 88 82 5C 30 32 48 10 16", Request::Idle(&[])),
        ("68 08 08 68 88 82 5C 30 32 58 00 20 40 16", Request::Abort(Abort::new(AbortReason::User(0)))),
        // profibus-wire 5.4
        (
            "68 0D 0D 68 88 82 5C 30 32 5F 00 FF 04 08 00 FD E8 17 16",
            Request::Write(Transfer { slot: 0, index: 255, data: &[8, 0, 0xFD, 0xE8] }),
        ),
        ("68 09 09 68 88 82 5C 30 32 5E 00 FF 44 69 16", Request::Read(Access { slot: 0, index: 255, length: 68 })),
    ]
}

/// Responses: telegram and content.
fn responses() -> [(&'static str, Response<'static>); 8] {
    let initiate =
        InitiateRes { max_len_data_unit: 240, capabilities: Capabilities::READ_WRITE, source: HERE, destination: HERE };
    [
        // profibus-wire 4.4
        (
            "68 0D 0D 68 82 88 08 33 33 5E 01 10 04 11 22 33 44 95 16",
            Response::Read(Transfer { slot: 1, index: 16, data: &[0x11, 0x22, 0x33, 0x44] }),
        ),
        (
            "68 09 09 68 82 88 08 33 33 DF 80 B6 00 8D 16",
            Response::Negative(Negative::new(Function::Write, ErrorCode::ACCESS_DENIED)),
        ),
        // profibus-wire 4.5
        (
            "68 09 09 68 82 88 08 33 33 5C 03 02 10 E9 16",
            Response::AlarmAck(AlarmAck { slot: 3, alarm_type: 2, specifier: 0x10 }),
        ),
        // profibus-wire 4.6.6
        (
            "68 09 09 68 82 88 08 32 31 56 30 00 64 5F 16",
            Response::ResourceManager(ResourceManager { server_sap: 48, min_send_timeout: 100 }),
        ),
        (
            "68 15 15 68 82 88 08 32 30 57 F0 01 00 00 00 00 00 00 02 00 02 00 00 00 00 C0 16",
            Response::Initiate(initiate),
        ),
        (
            "68 0D 0D 68 82 88 08 32 30 5E 00 10 04 DE AD BE EF 1E 16",
            Response::Read(Transfer { slot: 0, index: 16, data: &[0xDE, 0xAD, 0xBE, 0xEF] }),
        ),
        ("68 06 06 68 82 88 08 32 30 48 BC 16", Response::Idle(&[])),
        // profibus-wire 5.4
        ("68 09 09 68 82 88 08 32 30 5F 00 FF 04 D6 16", Response::Write(Access { slot: 0, index: 255, length: 4 })),
    ]
}

#[test]
fn printed_pdus_parse() {
    for (text, request) in requests() {
        assert_eq!(Request::parse(&du(text)), Ok(request), "{text}");
    }
    for (text, response) in responses() {
        assert_eq!(Response::parse(&du(text)), Ok(response), "{text}");
    }
}

#[test]
fn printed_pdus_emit() {
    let mut out = [0; 244];
    for (text, request) in requests() {
        let length = request.emit(&mut out).unwrap();
        assert_eq!(out[..length], du(text), "{text}");
        assert_eq!(request.emit(&mut out[..length - 1]), Err(TooLong), "{text}");
    }
    for (text, response) in responses() {
        let length = response.emit(&mut out).unwrap();
        assert_eq!(out[..length], du(text), "{text}");
        assert_eq!(response.emit(&mut out[..length - 1]), Err(TooLong), "{text}");
    }
}

#[test]
fn every_shorter_pdu_is_an_error() {
    for (text, request) in requests() {
        let pdu = du(text);
        assert_eq!(Request::parse(&[]), Err(PduError::Empty));
        for length in 1..pdu.len() {
            assert_eq!(
                Request::parse(&pdu[..length]),
                Err(PduError::Length(request.function())),
                "{text} cut to {length}"
            );
        }
    }
    for (text, _) in responses() {
        let pdu = du(text);
        for length in 0..pdu.len() {
            assert!(Response::parse(&pdu[..length]).is_err(), "{text} cut to {length}");
        }
    }
}

/// A PDU with one altered octet is an error, or has another content that emits exactly these octets.
#[test]
fn every_altered_octet_is_an_error_or_is_emitted_again() {
    let mut out = [0; 244];
    for (text, request) in requests() {
        for altered in alterations(&du(text)) {
            let reserved = matches!(request, Request::Initiate(_)) && altered[1..4] != [0; 3];
            if let (false, Ok(other)) = (reserved, Request::parse(&altered)) {
                assert_ne!(other, request, "{text}");
                let length = other.emit(&mut out).unwrap();
                assert_eq!(out[..length], altered, "{text}");
            }
        }
    }
    for (text, response) in responses() {
        for altered in alterations(&du(text)) {
            if let Ok(other) = Response::parse(&altered) {
                assert_ne!(other, response, "{text}");
                let length = other.emit(&mut out).unwrap();
                assert_eq!(out[..length], altered, "{text}");
            }
        }
    }
}

/// `pdu` with each octet replaced by each other value.
fn alterations(pdu: &[u8]) -> impl Iterator<Item = Vec<u8>> {
    let others = (0..pdu.len()).flat_map(|position| (1..=0xFF).map(move |flipped| (position, flipped)));
    others.map(|(position, flipped)| {
        let mut altered = pdu.to_vec();
        altered[position] ^= flipped;
        altered
    })
}

#[test]
fn a_wrong_length_octet_is_an_error() {
    for text in [
        "5E 01 10 00",
        "5E 01 10 F1",
        "5E 01 10 04 00",
        "5F 01 10 00",
        "5F 01 10 01",
        "5F 01 10 01 AA BB",
        "51 01 10 00",
        "5C 01 02 03 04",
    ] {
        let pdu = hex(text);
        let function = Function::from_number(pdu[0]).unwrap();
        assert_eq!(Request::parse(&pdu), Err(PduError::Length(function)), "{text}");
    }
}

#[test]
fn a_record_has_at_most_240_octets() {
    let mut out = [0; 300];
    let write = |data| Request::Write(Transfer { slot: 1, index: 2, data });
    assert_eq!(write(&[7; 240]).emit(&mut out), Ok(244));
    assert_eq!(Request::parse(&out[..244]), Ok(write(&[7; 240])));
    assert_eq!(write(&[7; 241]).emit(&mut out), Err(TooLong));
    assert_eq!(write(&[7; 256]).emit(&mut out), Err(TooLong));
}

#[test]
fn function_numbers_of_the_other_direction_are_errors() {
    for number in [0x00, 0x47, 0x56, 0xDE, 0xDF, 0x5D] {
        assert_eq!(Request::parse(&[number, 0, 0, 0]), Err(PduError::Function(number)), "{number:02X}");
    }
    for number in [0x00, 0x47, 0xC8, 0xD6, 0xD8] {
        assert_eq!(Response::parse(&[number, 0, 0, 0]), Err(PduError::Function(number)), "{number:02X}");
    }
}

#[test]
fn negative_responses_keep_foreign_codes() {
    let pdu = hex("DE FE 12 34");
    let negative =
        Negative { function: Function::Read, decode: ErrorDecode::Fms, code_1: ErrorCode(0x12), code_2: 0x34 };
    assert_eq!(Response::parse(&pdu), Ok(Response::Negative(negative)));
}

#[test]
fn an_abort_may_carry_a_detail() {
    let pdu = hex("58 02 16 00 64");
    let abort = Abort { subnet: 2, reason: AbortReason::SEND_TIMEOUT, detail: &[0, 0x64] };
    assert_eq!(Request::parse(&pdu), Ok(Request::Abort(abort)));
    assert_eq!(Response::parse(&pdu), Ok(Response::Abort(abort)));
}

#[test]
fn an_initiate_may_name_an_end_point_behind_a_gateway() {
    let pdu = hex("57 00 00 00 00 64 01 00 00 00 97 00  00 02 01 0A  00 00  07 01 11 22 33 44 55 66 AA BB");
    let network = Network { address: [0x11, 0x22, 0x33, 0x44, 0x55, 0x66], mac: &[0xAA, 0xBB] };
    let initiate = Initiate {
        send_timeout: 100,
        capabilities: Capabilities { profile_ident: 0x9700, ..Capabilities::READ_WRITE },
        source: HERE,
        destination: AddAddr { api: 7, scl: 1, network: Some(network) },
    };
    assert_eq!(Request::parse(&pdu), Ok(Request::Initiate(initiate)));
    let mut out = [0; 244];
    assert_eq!(Request::Initiate(initiate).emit(&mut out), Ok(pdu.len()));
    assert_eq!(out[..pdu.len()], pdu);
}

#[test]
fn a_length_that_does_not_fit_the_address_type_is_an_error() {
    let fixed = "57 00 00 00 00 64 01 00 00 00 00 00";
    for (tail, defect) in [
        ("00 03 00 02 00 00 00 00 00", PduError::Address),
        ("00 02 00 01 00 00 00", PduError::Address),
        ("01 07 00 02 00 00 00 00 00 00 00 00 00", PduError::Address),
        ("02 02 00 02 00 00 00 00", PduError::Address),
        ("00 02 00 02 00 00 00", PduError::Length(Function::Initiate)),
        ("00 02 01 08 00 00 00 00 00 00 00 00 00", PduError::Length(Function::Initiate)),
    ] {
        assert_eq!(Request::parse(&hex(&std::format!("{fixed} {tail}"))), Err(defect), "{tail}");
    }
}

/// Each kind of wrong PDU has its own error.
#[test]
fn a_wrong_field_is_named() {
    let length = |function| Err(PduError::Length(function));
    for (pdu, error) in [
        (&[0x5E, 1, 16][..], length(Function::Read)),
        (&[0x5E, 1, 16, 0], length(Function::Read)),
        (&[0x5E, 1, 16, 241], length(Function::Read)),
        (&[0x5E, 1, 16, 20, 0], length(Function::Read)),
        (&[0x5F, 1, 16, 2, 0], length(Function::Write)),
    ] {
        assert_eq!(Request::parse(pdu), error, "{pdu:02X?}");
    }
    let manager = Function::ResourceManager.number();
    assert!(Response::parse(&[manager, 48, 0, 100]).is_ok());
    assert_eq!(Response::parse(&[manager, 49, 0, 100]), Err(PduError::AccessPoint(49)));
    assert_eq!(Response::parse(&[manager, 48, 0]), Err(PduError::Length(Function::ResourceManager)));
    assert_eq!(Response::parse(&[manager, 49, 0, 100, 0]), Err(PduError::Length(Function::ResourceManager)));
    assert_eq!(std::format!("{}", PduError::AccessPoint(49)), "expected an access point from 0 to 48, got 49");
}
