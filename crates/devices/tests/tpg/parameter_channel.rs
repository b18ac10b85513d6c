//! The parameter channel of TPG300 and TPG500, line by line: the examples of the manual with errata-bpg-bcg-tpg
//! applied, every refusal, repetition and width. IF300P/IF301P manual 3.2.2.1, 3.2.4.2, 4.1.

use crate::tpg::BOARDS;
use crate::tpg::master::Exchange;
use profivac_devices::SimulatedDevice;
use profivac_devices::model::Fault;

fn exchange() -> Exchange {
    Exchange::new(BOARDS)
}

#[test]
fn the_example_of_chapter_4_sets_the_unit_to_torr() {
    // errata-bpg-bcg-tpg 134, 135
    let mut master = exchange();
    master.line("20 01 16 00 00 00 00 02", "B0 01 16 00 00 00 00 02");
    master.line("00 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00");
    for slot in ["01", "02", "03", "04"] {
        master.line(&format!("10 {slot} 16 00 00 00 00 00"), &format!("B0 {slot} 16 00 00 00 00 02"));
    }
}

#[test]
fn the_self_monitoring_example_works_step_by_step() {
    // 3.2.4.2 with the corrected table of the errata (136); a threshold has four octets (130).
    let mut master = exchange();
    for (request, answer) in [
        ("20 0A 14 00 00 00 00 00", "B0 0A 14 00 00 00 00 00"),
        ("30 0A 15 00 3B 03 12 6F", "20 0A 15 00 3B 03 12 6F"),
        ("30 0A 16 00 3A 83 12 6F", "20 0A 16 00 3A 83 12 6F"),
        ("20 0A 17 00 00 00 00 03", "B0 0A 17 00 00 00 00 03"),
        ("20 0A 14 00 00 00 00 01", "B0 0A 14 00 00 00 00 01"),
    ] {
        master.line(request, answer);
        // The controller accepts an instruction with and without AK 0 before it (153).
        master.line("00 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00");
    }
    master.line("10 0A 15 00 00 00 00 00", "20 0A 15 00 3B 03 12 6F");
    master.line("10 0A 16 00 00 00 00 00", "20 0A 16 00 3A 83 12 6F");
    master.line("10 0A 17 00 00 00 00 00", "B0 0A 17 00 00 00 00 03");
}

#[test]
fn the_upper_threshold_of_the_printed_example_is_above_every_pressure() {
    // 59 03 12 6F is 2.3e15 mbar (136): a valid number, so the controller accepts it.
    let mut master = exchange();
    master.line("20 0A 14 00 00 00 00 00", "B0 0A 14 00 00 00 00 00");
    master.line("30 0A 15 00 59 03 12 6F", "20 0A 15 00 59 03 12 6F");
}

#[test]
fn tasks_follow_each_other_without_ak_0() {
    // (153)
    let mut master = exchange();
    master.line("20 01 16 00 00 00 00 02", "B0 01 16 00 00 00 00 02");
    master.line("20 01 16 00 00 00 00 03", "B0 01 16 00 00 00 00 03");
    master.line("10 01 16 00 00 00 00 00", "B0 01 16 00 00 00 00 03");
}

#[test]
fn a_write_is_executed_once_and_a_read_in_every_cycle() {
    // (153)
    let mut master = exchange();
    master.line("20 00 1A 00 00 00 00 01", "B0 00 1A 00 00 00 00 01");
    master.line("10 00 1A 00 00 00 00 00", "B0 00 1A 00 00 00 00 01");
    // The controller stores the value with its next refresh (143); the unchanged read request shows it.
    master.advance(0.2);
    master.line("10 00 1A 00 00 00 00 00", "B0 00 1A 00 00 00 00 00");
    master.line("20 00 1A 00 00 00 00 01", "B0 00 1A 00 00 00 00 01");
    master.tester.device().settle();
    master.line("20 00 1A 00 00 00 00 01", "B0 00 1A 00 00 00 00 01");
    master.line("10 00 1A 00 00 00 00 00", "B0 00 1A 00 00 00 00 00");
}

/// (145), (152): a string of one octet is an octet, and requests and answers have eight octets.
#[test]
fn every_task_has_its_width_and_its_ak() {
    let mut master = exchange();
    for (request, answer) in [
        // Byte, word and double word have their own answers (133).
        ("10 00 18 00 00 00 00 00", "10 00 18 00 00 00 00 00"),
        ("20 00 18 00 00 00 04 D2", "10 00 18 00 00 00 04 D2"),
        // The program version has four octets (129).
        ("10 00 15 00 00 00 00 00", "20 00 15 00 50 97 31 01"),
        // The controller ignores octets outside the width and answers zero in them (24, 152).
        ("2F 01 17 FF AA BB CC 01", "B0 01 17 00 00 00 00 01"),
        // Another width than the parameter's: data type error.
        ("30 01 17 00 00 00 00 01", "70 01 17 00 00 00 00 05"),
        ("30 00 18 00 00 00 04 D2", "70 00 18 00 00 00 00 05"),
        ("20 05 14 00 00 00 00 00", "B0 05 14 00 00 00 00 00"),
        ("20 05 15 00 00 00 00 01", "70 05 15 00 00 00 00 05"),
        // Unknown instructions, among them the byte write of other devices (133, 148).
        ("A0 01 17 00 00 00 00 01", "70 01 17 00 00 00 00 11"),
        ("40 01 17 00 00 00 00 01", "70 01 17 00 00 00 00 11"),
        ("F0 01 17 00 00 00 00 01", "70 01 17 00 00 00 00 11"),
        // No such slot, no such index (155).
        ("10 0B 14 00 00 00 00 00", "70 0B 14 00 00 00 00 00"),
        ("20 FF 14 00 00 00 00 00", "70 FF 14 00 00 00 00 00"),
        ("10 00 16 00 00 00 00 00", "70 00 16 00 00 00 00 03"),
        ("10 00 17 00 00 00 00 00", "70 00 17 00 00 00 00 03"),
        ("20 05 19 00 00 00 00 00", "70 05 19 00 00 00 00 03"),
        // Measured value and status are in the cyclic data only (127).
        ("10 01 14 00 00 00 00 00", "70 01 14 00 00 00 00 03"),
        ("10 04 15 00 00 00 00 00", "70 04 15 00 00 00 00 03"),
        ("30 01 14 00 00 00 00 00", "70 01 14 00 00 00 00 01"),
        // Not changeable.
        ("20 00 14 00 00 00 00 FF", "70 00 14 00 00 00 00 01"),
        ("30 00 15 00 00 00 00 00", "70 00 15 00 00 00 00 01"),
        ("20 05 18 00 00 00 00 00", "70 05 18 00 00 00 00 01"),
        // A valid set is locked (138).
        ("30 06 15 00 3B 03 12 6F", "70 06 15 00 00 00 00 11"),
        ("30 06 16 00 3B 03 12 6F", "70 06 16 00 00 00 00 11"),
        ("20 06 17 00 00 00 00 01", "70 06 17 00 00 00 00 11"),
    ] {
        master.line(request, answer);
    }
}

#[test]
fn values_outside_the_range_are_refused_and_change_nothing() {
    let mut master = exchange();
    let unlock = "20 05 14 00 00 00 00 00";
    master.line(unlock, "B0 05 14 00 00 00 00 00");
    for (read, before, writes) in [
        // Access code 0 to 9999 (132)
        ("10 00 18", "10 00 18 00 00 00 00 00", &["20 00 18 00 00 00 27 10", "20 00 18 00 00 00 FF FF"][..]),
        // Underrange control (144), volatility (143), unit (147), filter (146)
        ("10 00 19", "B0 00 19 00 00 00 00 00", &["20 00 19 00 00 00 00 02", "20 00 19 00 00 00 00 FF"]),
        ("10 00 1A", "B0 00 1A 00 00 00 00 00", &["20 00 1A 00 00 00 00 03", "20 00 1A 00 00 00 00 FF"]),
        ("10 01 16", "B0 01 16 00 00 00 00 01", &["20 01 16 00 00 00 00 00", "20 01 16 00 00 00 00 04"]),
        ("10 01 17", "B0 01 17 00 00 00 00 02", &["20 01 17 00 00 00 00 00", "20 01 17 00 00 00 00 04"]),
        // Validation
        ("10 05 14", "B0 05 14 00 00 00 00 00", &["20 05 14 00 00 00 00 02", "20 05 14 00 00 00 00 FF"]),
        // Thresholds: zero, negative, infinite, not a number (137); 2e-3 mbar from the factory
        (
            "10 05 15",
            "20 05 15 00 3B 03 12 6F",
            &[
                "30 05 15 00 00 00 00 00",
                "30 05 15 00 BF 80 00 00",
                "30 05 15 00 7F 80 00 00",
                "30 05 15 00 7F C0 00 00",
            ],
        ),
        ("10 05 16", "20 05 16 00 3A 83 12 6F", &["30 05 16 00 00 00 00 00", "30 05 16 00 80 00 00 00"]),
        // Source (140)
        ("10 05 17", "B0 05 17 00 00 00 00 01", &["20 05 17 00 00 00 00 00", "20 05 17 00 00 00 00 05"]),
    ] {
        for write in writes {
            let refused = format!("70 {} 00 00 00 00 02", &write[3..8]);
            master.line(write, &refused);
            master.line(&format!("{read} 00 00 00 00 00"), before);
        }
    }
}

#[test]
fn every_write_is_refused_while_the_link_is_lost() {
    // (156)
    let mut master = exchange();
    master.fault(Fault::Comm, true);
    master.line("20 01 16 00 00 00 00 02", "70 01 16 00 00 00 00 11");
    master.fault(Fault::Comm, false);
    master.line("00 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00");
    master.line("20 01 16 00 00 00 00 02", "B0 01 16 00 00 00 00 02");
}

#[test]
fn the_controller_has_no_acyclic_services() {
    // 150: the access points of MS1 and MS2 stay closed, and DPV1_Enable is no user parameter (151).
    let mut master = exchange();
    for sap in [profivac_wire::Sap::Ms1, profivac_wire::Sap::ResourceManager] {
        let (code, _) = master.tester.request(sap, &[0x5E, 0, 20, 1]).unwrap();
        assert_eq!(code & 0x0F, 3, "service not activated");
    }
}
