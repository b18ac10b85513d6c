//! Exception Status, its two records and their copies. 7.1.11 to 7.1.13, 7.1.16 to 7.1.21, (71) to (75).

use crate::pxg55x::{FLOATS, Gauge, exchanging, of_instance, pcg, pcg_without_atm, psg};
use crate::support::{Tester, hex};
use profivac_devices::SimulatedDevice;
use profivac_devices::pxg55x::Pxg55xModel;
use profivac_wire::Sap;

/// A fault; Exception Status in EXECUTING at 100 mbar, ID 27 and ID 28.
type Row = (&'static str, u8, &'static str, &'static str);

const COMMON: [Row; 4] = [
    // Reading Valid stays (88), but the value is the safe one: the gauge's reading is invalid (13.1.1).
    ("eprom", 0xB1, "02 04 00 04 00 00 00 00 01 00", "02 04 00 05 01 00 00 00 00 01 00"),
    ("eeprom", 0xB1, "02 08 00 04 00 00 00 00 01 00", "02 08 00 05 01 00 00 00 00 01 00"),
    ("ram", 0xB1, "02 10 00 04 00 00 00 00 01 00", "02 10 00 05 01 00 00 00 00 01 00"),
    // The manufacturer's group makes readings invalid as well (88).
    ("comm", 0xE4, "02 00 00 04 00 00 00 00 01 01", "02 00 00 05 01 00 00 00 00 01 01"),
];

/// The diaphragm is active.
const PCG: [Row; 5] = [
    ("", 0x80, "02 00 00 04 00 00 00 00 01 00", "02 00 00 05 00 00 00 00 00 01 00"),
    ("sensor1", 0xA2, "02 00 00 04 01 00 00 00 01 00", "02 00 00 05 01 00 00 00 00 01 00"),
    ("electronics1", 0xA2, "02 00 00 04 00 02 00 00 01 00", "02 00 00 05 01 00 00 00 00 01 00"),
    // "If an error occurs": also an error of the instance that is not active (13.1.1), (165).
    ("sensor2", 0xA2, "02 00 00 04 00 00 01 00 01 00", "02 00 00 05 01 00 00 00 00 01 00"),
    ("electronics2", 0xA2, "02 00 00 04 00 00 00 02 01 00", "02 00 00 05 01 00 00 00 00 01 00"),
];

/// (74)
const ATM: [Row; 2] = [
    ("sensor3", 0x80, "02 00 00 04 00 00 00 00 01 00", "02 00 00 05 00 00 00 00 00 01 00"),
    ("electronics3", 0x80, "02 00 00 04 00 00 00 00 01 00", "02 00 00 05 00 00 00 00 00 01 00"),
];

/// 8 and 9 octets.
const PSG: [Row; 7] = [
    ("", 0x80, "02 00 00 02 00 00 01 00", "02 00 00 03 00 00 00 01 00"),
    ("eprom", 0xB1, "02 04 00 02 00 00 01 00", "02 04 00 03 01 00 00 01 00"),
    ("eeprom", 0xB1, "02 08 00 02 00 00 01 00", "02 08 00 03 01 00 00 01 00"),
    ("ram", 0xB1, "02 10 00 02 00 00 01 00", "02 10 00 03 01 00 00 01 00"),
    ("comm", 0xE4, "02 00 00 02 00 00 01 01", "02 00 00 03 01 00 00 01 01"),
    ("sensor1", 0xA2, "02 00 00 02 01 00 01 00", "02 00 00 03 01 00 00 01 00"),
    ("electronics1", 0xA2, "02 00 00 02 00 02 01 00", "02 00 00 03 01 00 00 01 00"),
];

/// Every fault of every kind of gauge.
fn rows() -> Vec<(Pxg55xModel, Row)> {
    let pcg_rows = || COMMON.iter().chain(&PCG).copied();
    let mut rows: Vec<(Pxg55xModel, Row)> = pcg_rows().chain(ATM).map(|row| (pcg(), row)).collect();
    rows.extend(pcg_rows().map(|row| (pcg_without_atm(), row)));
    rows.extend(PSG.map(|row| (psg(), row)));
    rows
}

/// `comm` is 7.1.12's internal communication exception, bit 0 of the manufacturer's detail, and not the communications
/// exception, bit 5 of the common one.
/// (106)
#[test]
fn every_fault_sets_its_bits_while_it_is_active() {
    for (kind, (fault, status, alarm, warning)) in rows() {
        let mut tester = exchanging(kind, FLOATS, 100.0);
        if !fault.is_empty() {
            tester.fault(fault, true);
        }
        assert_eq!(tester.get(0, 26), [status], "{fault}");
        assert_eq!(tester.exchange(&[])[0], status, "{fault}");
        assert_eq!(tester.report().exception_status, status, "{fault}");
        assert_eq!(tester.get(0, 27), hex(alarm), "{fault}");
        assert_eq!(tester.get(0, 28), hex(warning), "{fault}");
        copies_are_equal(&mut tester);
        if !fault.is_empty() {
            tester.fault(fault, false);
        }
        assert_eq!(tester.get(0, 26), [0x80], "{fault} gone");
    }
}

/// 7.1.16 to 7.1.21, and the blocks behind the details.
pub fn copies_are_equal(tester: &mut Tester<Gauge>) {
    let [alarm, warning] = [27, 28].map(|index| tester.get(0, index));
    // 4 on a PCG55x, 2 on a PSG55x.
    let sensors = usize::from(alarm[3]);
    assert_eq!((alarm.len(), warning.len(), usize::from(warning[3])), (6 + sensors, 7 + sensors, 1 + sensors));
    let parts = [
        (204, &alarm[1..3]),
        (205, &alarm[4..4 + sensors]),
        (206, &alarm[5 + sensors..]),
        (207, &warning[1..3]),
        (208, &warning[4..5]),
        (209, &warning[5..5 + sensors]),
        (210, &warning[6 + sensors..]),
    ];
    for (index, part) in parts {
        assert_eq!(tester.get(0, index), part, "copy {index}");
    }
    assert_eq!(tester.get(1, 120), warning[4..5], "(71)");
    let selected = tester.get(1, 46);
    for (instance, position) in (1u8..).zip(alarm[4..4 + sensors].chunks(2)) {
        assert_eq!(of_instance(tester, instance, 103), position, "alarm of {instance}");
        assert_eq!(of_instance(tester, instance, 104), [0, 0], "warning of {instance}");
    }
    let instances = u8::try_from(tester.report().indicated.iter().count()).unwrap();
    for instance in 1..=instances {
        let valid = of_instance(tester, instance, 23)[0];
        // "The logical inversion" (12.1.2).
        assert_eq!(of_instance(tester, instance, 102)[0] & 1, 1 - valid, "status extension of {instance}");
    }
    let any = |octets: &[u8]| u8::from(octets.iter().any(|octet| *octet != 0));
    let active = tester.get(1, 47)[0];
    // "If an error occurs" (13.1.1).
    let error = any(&alarm[1..3]) | any(&alarm[4..4 + sensors]) | any(&alarm[5 + sensors..]);
    assert_eq!(of_instance(tester, active, 102)[0] | error, warning[4], "the gauge's is that of the active instance");
    tester.put(1, 46, &selected).unwrap();
    let groups = |record: &[u8], device: usize| {
        any(&record[1..3]) | any(&record[4..4 + device]) << 1 | any(&record[5 + device..]) << 2
    };
    let status = 0x80 | groups(&alarm, sensors) | groups(&warning, sensors + 1) << 4;
    assert_eq!(tester.get(0, 26), [status], "each group bit is the OR of its details");
}

#[test]
fn an_alarm_invalidates_its_own_instance_only() {
    for (fault, failed) in [("sensor1", 1), ("electronics1", 1), ("sensor2", 2), ("electronics2", 2), ("sensor3", 3)] {
        let mut tester = exchanging(pcg(), FLOATS, 100.0);
        tester.fault(fault, true);
        for instance in 1..=3 {
            let valid = u8::from(instance != failed);
            assert_eq!(of_instance(&mut tester, instance, 23), [valid], "{fault}: instance {instance}");
        }
    }
}

/// 10.1.3, (166): the status of both relays is 1 with every error that Exception Detail Alarm has, and in CRITICAL FAULT.
#[test]
fn the_discrete_outputs_report_an_error() {
    let statuses = |tester: &mut Tester<Gauge>| [4, 5].map(|slot| tester.get(slot, 20)[0]);
    for (kind, (fault, ..)) in rows() {
        let mut tester = exchanging(kind, FLOATS, 100.0);
        assert_eq!(statuses(&mut tester), [0, 0]);
        if fault.is_empty() {
            continue;
        }
        tester.fault(fault, true);
        let expected = u8::from(!ATM.iter().any(|(name, ..)| *name == fault));
        assert_eq!(statuses(&mut tester), [expected; 2], "{fault}");
        tester.fault(fault, false);
        assert_eq!(statuses(&mut tester), [0, 0], "{fault} gone");
    }
    let mut tester = exchanging(pcg(), FLOATS, 100.0);
    ["eprom", "ram"].into_iter().for_each(|fault| tester.fault(fault, true));
    ["eprom", "ram"].into_iter().for_each(|fault| tester.fault(fault, false));
    assert_eq!((tester.report().device_state.name(), statuses(&mut tester)), ("CRITICALFAULT", [1, 1]));
    tester.command(1).unwrap();
    tester.device().settle();
    assert_eq!(statuses(&mut tester), [0, 0], "after Reset");
}

/// 13.1.1, (36): outside EXECUTING the reading is invalid, and that is a warning.
#[test]
fn exception_status_is_a0_in_idle_without_a_fault() {
    for kind in Pxg55xModel::all() {
        let mut tester = crate::pxg55x::tester(kind);
        tester.pressure_mbar(100.0);
        assert_eq!((tester.get(0, 26), tester.get(1, 120), tester.get(1, 23)), (vec![0xA0], vec![1], vec![0]));
        copies_are_equal(&mut tester);
    }
}

/// A range is no error, but a warning: 13.1.1, (87).
#[test]
fn a_reading_out_of_range_sets_its_bit_and_invalid() {
    for (kind, mbar, selector, extension) in [
        (pcg(), 4.9e-5, 2, 0x05),
        (pcg(), 5.1e-5, 2, 0x00),
        (pcg(), 1500.0, 1, 0x00),
        (pcg(), 1501.0, 1, 0x03),
        (psg(), 4.9e-5, 1, 0x05),
        (psg(), 5e-5, 1, 0x00),
        (psg(), 1200.0, 1, 0x00),
        (psg(), 1201.0, 1, 0x03),
    ] {
        let mut tester = exchanging(kind, FLOATS, mbar);
        let status = if extension == 0 { 0x80 } else { 0xA0 };
        assert_eq!(tester.exchange(&[])[..3], [status, extension, selector], "{mbar} mbar");
        copies_are_equal(&mut tester);
    }
}

/// (42): faults are in Exception Status, not in the diagnosis.
#[test]
fn the_diagnosis_has_six_octets_with_the_ident_number_also_with_a_fault() {
    for kind in [pcg(), psg()] {
        let mut tester = exchanging(kind, FLOATS, 100.0);
        let ident = kind.variant().model.ident.to_be_bytes();
        for is_faulty in [false, true] {
            tester.fault("electronics1", is_faulty);
            let (_, du) = tester.request(Sap::SlaveDiag, &[]).unwrap();
            assert_eq!((du.len(), &du[4..]), (6, &ident[..]), "fault: {is_faulty}");
        }
    }
}
