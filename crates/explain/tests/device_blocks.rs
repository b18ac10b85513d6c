//! The device-related blocks of a diagnosis, by what the recording shows about DP-V1 on the slave. profibus-wire 2.3.2.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::decoded::decoded;
use crate::log::{Log, MASTER, SLAVE};
use profivac_devices::catalog::MODELS;
use profivac_dp::link::Baud;
use profivac_explain::dpv1::DeviceBlocks;
use profivac_explain::input::Capture;
use profivac_explain::note::Kind;

const BAUD: Baud = Baud::B500000;
/// An Ident_Number that no device of the catalogue has.
const UNKNOWN: u16 = 0xAAAB;
const BCG450: u16 = 0x08E6;

/// A process alarm, Module_Status, a status message, and octets whose first one is no type of DP-V1.
const BLOCKS: [&[u8]; 4] =
    [&[0x05, 0x02, 0x03, 0x09, 0x50], &[0x05, 0x82, 0x00, 0x00, 0x04], &[0x04, 0x81, 0x02, 0x01], &[0x04, 0, 1, 2]];

/// The texts of [`BLOCKS`].
const MESSAGES: [&str; 4] = [
    "process alarm of slot 3, sequence number 1, appears: 50",
    "module status of slot 0: 1 invalid data",
    "status message of slot 2, appears",
    "device-related octets 00 01 02",
];
const VENDOR: [&str; 4] = [
    "vendor-specific octets 02 03 09 50",
    "vendor-specific octets 82 00 00 04",
    "vendor-specific octets 81 02 01",
    "vendor-specific octets 00 01 02",
];
const VENDOR_OR_MODULE_STATUS: [&str; 4] = [
    VENDOR[0],
    "device-related octets 82 00 00 04 (as DP-V1: module status of slot 0: 1 invalid data)",
    VENDOR[2],
    VENDOR[3],
];
const BOTH: [&str; 4] = [
    "device-related octets 02 03 09 50 (as DP-V1: process alarm of slot 3, sequence number 1, appears: 50)",
    VENDOR_OR_MODULE_STATUS[1],
    "device-related octets 81 02 01 (as DP-V1: status message of slot 2, appears)",
    MESSAGES[3],
];

/// The notes about the diagnosis of a slave.
fn notes(log: &Log, slave: u8) -> Vec<String> {
    let (_, explained) = decoded(&Capture::read(log.text.as_bytes(), BAUD).unwrap(), BAUD);
    let notes = explained.into_iter().flat_map(|explained| explained.notes);
    notes.filter(|note| note.kind == Kind::Diagnosis && note.station == Some(slave)).map(|note| note.text).collect()
}

const ENABLE: &[u8] = &[0x80, 0, 0];
const NO_ENABLE: &[u8] = &[0x00, 2, 0];
/// Alarm_Ack of the process alarm in slot 3.
const ALARM_ACK: &[u8] = &[0x5C, 3, 2, 8];
const READ: &[u8] = &[0x5E, 1, 19, 4];
const INITIATE: &[u8] = &[0x57, 0, 0, 0, 0, 100, 1, 0, 0, 0, 0, 0];

/// What the recording shows about a device that is not in the catalogue, and the texts of the blocks behind it.
fn recordings() -> Vec<(&'static str, Log, [&'static str; 4])> {
    let log = Log::default;
    let prm = |user| log().prm(UNKNOWN, user);
    let service = |log: Log, sap, du| log.request(SLAVE, sap, du).ack();
    vec![
        ("nothing", log(), BOTH),
        ("DPV1_Enable", prm(ENABLE), MESSAGES),
        ("Set_Prm without DPV1_Enable", prm(NO_ENABLE), VENDOR_OR_MODULE_STATUS),
        ("Fail_Safe is not DPV1_Enable", prm(&[0x7F, 0x80, 0x80]), VENDOR_OR_MODULE_STATUS),
        ("Set_Prm without user parameters", prm(&[]), VENDOR_OR_MODULE_STATUS),
        // DP-V1 has three status octets, and a slave in DP-V1 mode refuses reserved bits in them (profibus-wire 2.4).
        ("one user octet", prm(&[0x80]), VENDOR_OR_MODULE_STATUS),
        ("two user octets", prm(&[0x80, 0x02]), VENDOR_OR_MODULE_STATUS),
        ("two user octets with reserved bits", prm(&[0x98, 0x02]), VENDOR_OR_MODULE_STATUS),
        ("reserved bits in the first octet", prm(&[0x98, 0x10, 0x00]), BOTH),
        ("bit 3 in the first octet", prm(&[0x88, 0, 0]), BOTH),
        ("bit 4 in the first octet", prm(&[0x90, 0, 0]), BOTH),
        ("bit 1 in the second octet", prm(&[0x80, 0x02, 0]), BOTH),
        ("bit 5 in the third octet", prm(&[0x80, 0, 0x20]), BOTH),
        ("bit 6 in the third octet", prm(&[0x80, 0, 0x40]), BOTH),
        ("every bit that has a meaning", prm(&[0xE7, 0xFD, 0x9F]), MESSAGES),
        ("reserved bits without DPV1_Enable", prm(&[0x18, 0, 0]), VENDOR_OR_MODULE_STATUS),
        ("reserved bits, then Set_Prm without", prm(&[0x98, 0, 0]).prm(UNKNOWN, NO_ENABLE), VENDOR_OR_MODULE_STATUS),
        ("an alarm acknowledgement, SAP 50", service(log(), 50, ALARM_ACK), MESSAGES),
        ("an alarm acknowledgement, SAP 51", service(log(), 51, ALARM_ACK), MESSAGES),
        ("MS1", service(log(), 51, READ), MESSAGES),
        ("MS2", service(log(), 48, READ), MESSAGES),
        ("Initiate", service(log(), 49, INITIATE), MESSAGES),
        // A refused or unanswered request shows what the master expects, and nothing about the slave.
        ("MS1 refused", log().request(SLAVE, 51, READ).refuse(SLAVE), BOTH),
        ("MS2 refused", log().request(SLAVE, 0, READ).refuse(SLAVE), BOTH),
        ("Initiate refused", log().request(SLAVE, 49, INITIATE).refuse(SLAVE), BOTH),
        ("MS1 not answered", log().request(SLAVE, 51, READ), BOTH),
        ("DPV1_Enable not answered", log().send_prm(UNKNOWN, 0x88, ENABLE), BOTH),
        ("Set_Prm not answered", log().send_prm(UNKNOWN, 0x88, NO_ENABLE), BOTH),
        ("Set_Prm not taken", log().send_prm(UNKNOWN, 0x88, NO_ENABLE).refuse(SLAVE), BOTH),
        ("DPV1_Enable with Prm_Fault", prm(ENABLE).diag_of(SLAVE, UNKNOWN, 0x42, &[]), BOTH),
        ("Set_Prm with Prm_Fault", prm(NO_ENABLE).diag_of(SLAVE, UNKNOWN, 0x42, &[]), BOTH),
        ("MS1 refused to a slave in DP-V0 mode", prm(NO_ENABLE).request(SLAVE, 51, READ).refuse(SLAVE), {
            VENDOR_OR_MODULE_STATUS
        }),
        // Without Lock_Req, or with Unlock_Req, Set_Prm sets no mode.
        ("a release", log().send_prm(UNKNOWN, 0x40, &[]).ack(), BOTH),
        ("Lock_Req and Unlock_Req", log().send_prm(UNKNOWN, 0xC0, NO_ENABLE).ack(), BOTH),
        ("only min T_SDR", log().send_prm(UNKNOWN, 0x00, &[]).ack(), BOTH),
        ("DPV1_Enable, then a release", prm(ENABLE).send_prm(UNKNOWN, 0x40, &[]).ack(), MESSAGES),
        // The order counts.
        ("DPV1_Enable after Set_Prm without", prm(NO_ENABLE).prm(UNKNOWN, ENABLE), MESSAGES),
        ("Set_Prm without after DPV1_Enable", prm(ENABLE).prm(UNKNOWN, NO_ENABLE), BOTH),
        ("Set_Prm without after MS1", service(log(), 51, READ).prm(UNKNOWN, NO_ENABLE), BOTH),
        ("MS1 after Set_Prm without", service(prm(NO_ENABLE), 51, READ), MESSAGES),
        ("MS2 and Set_Prm without", service(log(), 48, READ).prm(UNKNOWN, NO_ENABLE), BOTH),
        ("Set_Prm without and MS2", service(prm(NO_ENABLE), 48, READ), BOTH),
        (
            "a refused DPV1_Enable, then Set_Prm without",
            prm(ENABLE).diag_of(SLAVE, UNKNOWN, 0x42, &[]).prm(UNKNOWN, NO_ENABLE),
            { VENDOR_OR_MODULE_STATUS },
        ),
        (
            "DPV1_Enable, a refused Set_Prm, and one without",
            { prm(ENABLE).prm(UNKNOWN, ENABLE).diag_of(SLAVE, UNKNOWN, 0x42, &[]).prm(UNKNOWN, NO_ENABLE) },
            BOTH,
        ),
        // Another device at the address.
        ("another device with MS2 before", service(log(), 48, READ).diag(0xAAAC, &[]), BOTH),
        ("another device with Set_Prm before", prm(NO_ENABLE).diag(0xAAAC, &[]), BOTH),
    ]
}

fn check(what: &str, before: &Log, ident: u16, texts: [&str; 4]) {
    for (block, text) in BLOCKS.into_iter().zip(texts) {
        let notes = notes(&before.clone().diag(ident, block), SLAVE);
        assert_eq!(notes.last(), Some(&format!("its diagnosis: Ext_Diag; {text}")), "{what}, {block:02X?}");
    }
}

#[test]
fn a_block_of_an_unknown_device_has_the_meaning_that_the_recording_shows() {
    for (what, before, texts) in recordings() {
        check(what, &before, UNKNOWN, texts);
    }
}

/// A master chooses the interpretation by the device and not by the mode that it requested.
#[test]
fn a_block_of_a_known_device_has_the_meaning_of_its_device() {
    let tpg = MODELS.into_iter().find(|model| !model.features.dpv1).unwrap().ident;
    for (ident, texts) in [(BCG450, MESSAGES), (tpg, VENDOR)] {
        let log = Log::default;
        check("nothing", &log(), ident, texts);
        check("DPV1_Enable", &log().prm(ident, ENABLE), ident, texts);
        check("Set_Prm without", &log().prm(ident, NO_ENABLE), ident, texts);
        check("MS2", &log().request(SLAVE, 48, READ).ack(), ident, texts);
    }
    for model in MODELS {
        let mut same = MODELS.into_iter().filter(|other| other.ident == model.ident);
        assert!(same.all(|other| other.features.dpv1 == model.features.dpv1), "{}", model.name);
    }
}

/// A note is right for the recording up to it; the next diagnosis with the same octets has a new one, once.
#[test]
fn evidence_behind_a_diagnosis_changes_the_words_of_the_next_one() {
    let note = |text: &str| format!("its diagnosis: Ext_Diag; {text}");
    for (user, texts) in [(ENABLE, MESSAGES), (NO_ENABLE, VENDOR_OR_MODULE_STATUS)] {
        for ((block, first), then) in BLOCKS.into_iter().zip(BOTH).zip(texts) {
            let log = Log::default().diag(UNKNOWN, block).diag(UNKNOWN, block).prm(UNKNOWN, user);
            let log = log.diag(UNKNOWN, block).diag(UNKNOWN, block);
            let mut expected = vec![note(first), note(then)];
            expected.dedup();
            assert_eq!(notes(&log, SLAVE), expected);
        }
    }
}

#[test]
fn two_slaves_in_one_recording_have_their_own_meaning() {
    let log = Log::default().request(SLAVE + 1, 51, READ).ack().prm(UNKNOWN, NO_ENABLE);
    let [alarm, ..] = BLOCKS;
    let log =
        log.diag(UNKNOWN, alarm).diag_of(SLAVE + 1, UNKNOWN, 0x08, alarm).diag_of(SLAVE + 2, UNKNOWN, 0x08, alarm);
    for (slave, text) in [(SLAVE, VENDOR[0]), (SLAVE + 1, MESSAGES[0]), (SLAVE + 2, BOTH[0])] {
        assert_eq!(notes(&log, slave), [format!("its diagnosis: Ext_Diag; {text}")], "{slave}");
    }
}

/// The position error of an encoder in DP-V0 mode.
#[test]
fn the_diagnosis_of_an_encoder_in_dp_v0_mode_is_no_alarm() {
    let text = "TX 68 0E 0E 68 89 82 5D 3D 3E 88 1E 14 0B AA AB 01 00 02 00 16\nRX E5\n\
                TX 68 05 05 68 89 82 7D 3C 3E 02 16\n\
                RX 68 1B 1B 68 82 89 08 3E 3C 08 0C 00 02 AA AB 10 02 00 00 00 00 00 00 00 00 00 00 00 00 00 00 0A 16\n";
    let log = Log { text: text.to_owned(), ..Log::default() };
    let octets = "02 00 00 00 00 00 00 00 00 00 00 00 00 00 00";
    assert_eq!(notes(&log, 9), [format!("its diagnosis: Ext_Diag; vendor-specific octets {octets}")]);
}

/// Blocks of every type and length: octets that are no alarm and no status message are shown, and none is lost.
#[test]
fn a_block_without_a_meaning_in_dp_v1_is_shown_as_octets() {
    for content in [&[0x02][..], &[0x02, 0x03], &[0x00, 1, 2], &[0x07, 1, 2], &[0x7F, 1, 2], &[0x84, 1, 2]] {
        let octets = Hex(content);
        for format in [DeviceBlocks::Messages, DeviceBlocks::Unknown] {
            assert_eq!(format.text(content), format!("device-related octets {octets}"));
        }
        for format in [DeviceBlocks::Vendor, DeviceBlocks::VendorOrModuleStatus] {
            assert_eq!(format.text(content), format!("vendor-specific octets {octets}"));
        }
    }
    assert_eq!(DeviceBlocks::Unknown.text(&[]), "an empty device-related block");
    let manufacturer = DeviceBlocks::Messages.text(&[0xFE, 0, 1, 4]);
    assert_eq!(manufacturer, "manufacturer specific status 126 of slot 0, appears: 04");
}

#[test]
fn a_channel_error_of_the_vendor_keeps_its_number() {
    for (kind, text) in [
        (0xB1, "module 2, input and output channel 3 (word): manufacturer specific error 17"),
        (0xBF, "module 2, input and output channel 3 (word): manufacturer specific error 31"),
        (0x2A, "module 2, input and output channel 3 (bit): reserved error 10"),
        (0x20, "module 2, input and output channel 3 (bit): reserved error 0"),
        (0x06, "module 2, input and output channel 3 (reserved width 0): line break"),
        (0xE6, "module 2, input and output channel 3 (reserved width 7): line break"),
    ] {
        let log = Log::default().diag(UNKNOWN, &[0x82, 0xC3, kind]);
        assert_eq!(notes(&log, SLAVE), [format!("its diagnosis: Ext_Diag; {text}")]);
    }
}
