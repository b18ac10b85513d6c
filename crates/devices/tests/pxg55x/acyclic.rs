//! Acyclic dialogues to the octet, by a class 1 and by a class 2 master: 4.1, chapter 5.

use crate::pxg55x::{CHANNEL, Gauge, gauge, pcg, psg, tester};
use crate::support::{Tester, hex};
use profivac_dp::slave::Device;
use profivac_wire::Sap;

/// A PDU, and the answer that a poll fetches.
fn job(tester: &mut Tester<Gauge>, sap: Sap, ssap: u8, pdu: &str) -> Vec<u8> {
    assert_eq!(tester.ask(sap, ssap, &hex(pdu)).unwrap().0, 0xE5, "{pdu}");
    tester.ask(sap, ssap, &[]).unwrap().1
}

/// Opens a connection (profibus-wire 4.6.6).
fn connect(tester: &mut Tester<Gauge>) -> Sap {
    let initiate = "57 00 00 00 00 64 01 00 00 00 00 00 00 02 00 02 00 00 00 00";
    let (_, answer) = tester.ask(Sap::ResourceManager, 50, &hex(initiate)).unwrap();
    let sap = Sap::Ms2(answer[1]);
    assert_eq!(tester.ask(sap, 50, &[]).unwrap().1[0], 0x57);
    sap
}

/// The rights of 1_R/W and 2_R/W.
/// (13), (52): a refusal has the code of DP-V1, and there is no slot behind those of the table.
#[test]
fn a_class_2_master_reads_and_writes_without_an_exchange() {
    let mut tester = tester(pcg());
    let sap = connect(&mut tester);
    for (request, answer) in [
        // Device Type: a class 2 master may write it.
        ("5E 00 11 F0", "5E 00 11 08 43 56 47 20 20 20 20 20"),
        // Data Unit to Torr, in IDLE.
        ("5F 01 16 02 13 01", "5F 01 16 02"),
        ("5E 03 1C F0", "5E 03 1C 02 13 01"),
        // Micron is out of range (62).
        ("5F 01 16 02 13 02", "DF 80 B7 02"),
        // Execute, twice; Data Unit is locked then.
        ("5F 00 0F 01 04", "5F 00 0F 01"),
        ("5F 00 0F 01 04", "DF 80 B5 C9"),
        ("5F 01 16 02 13 08", "DF 80 B5 11"),
        // Process Value is read-only, slot 6 and index 14 do not exist, Safe State has one octet.
        ("5F 01 13 04 00 00 00 00", "DF 80 B6 01"),
        ("5E 06 10 F0", "DE 80 B2 00"),
        ("5E 01 0E F0", "DE 80 B0 03"),
        ("5F 01 27 02 00 00", "DF 80 B1 05"),
    ] {
        assert_eq!(job(&mut tester, sap, 50, request), hex(answer), "{request}");
    }
}

#[test]
fn a_class_1_master_reads_and_writes_beside_its_exchange() {
    let mut tester = tester(pcg());
    tester.pressure_mbar(100.0);
    // DPV1_Enable (39).
    tester.bring_up(&hex("80 00 00 13 08"), &hex(CHANNEL));
    for (request, answer) in [
        // Process Value, 100 mbar.
        ("5E 01 13 F0", "5E 01 13 04 42 C8 00 00"),
        // Only a class 2 master may write Device Type and Data Unit (58).
        ("5E 00 11 F0", "DE 80 B6 12"),
        ("5F 01 16 02 13 01", "DF 80 B6 01"),
        // Low Trip Point 2 to 200 mbar; relay 2 follows.
        ("5F 03 13 04 43 48 00 00", "5F 03 13 04"),
        ("5E 03 15 F0", "5E 03 15 01 01"),
    ] {
        assert_eq!(job(&mut tester, Sap::Ms1, 51, request), hex(answer), "{request}");
    }
}

/// (30), (111): DS_Write slot 0 index 255 with 08 00 FD E8, then DS_Read of 4 + 64 octets.
#[test]
fn both_classes_read_i_and_m0() {
    let call = "5F 00 FF 04 08 00 FD E8";
    let expected = [hex("5E 00 FF 44 08 00 FD E8"), gauge(psg()).im0().unwrap().to_vec()].concat();
    let mut tester = tester(psg());
    let sap = connect(&mut tester);
    assert_eq!(job(&mut tester, sap, 50, call), hex("5F 00 FF 04"));
    assert_eq!(job(&mut tester, sap, 50, "5E 00 FF F0"), expected);
    tester.bring_up(&hex("80 00 00 13 08"), &hex(CHANNEL));
    assert_eq!(job(&mut tester, Sap::Ms1, 51, call), hex("5F 00 FF 04"));
    assert_eq!(job(&mut tester, Sap::Ms1, 51, "5E 00 FF F0"), expected);
    // There is no I&M1, and none in other slots.
    assert_eq!(job(&mut tester, sap, 50, "5F 00 FF 04 08 00 FD E9")[0], 0xDF);
    assert_eq!(job(&mut tester, sap, 50, "5F 01 FF 04 08 00 FD E8")[0], 0xDF);
}
