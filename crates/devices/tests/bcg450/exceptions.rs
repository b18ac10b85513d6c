//! Exception Status, its two records and their copies. tira41d1 3.1.1.10 to 3.1.1.20, (42) to (54).

use crate::bcg450::{FLOATS, Gauge, exchanging, of_instance};
use crate::support::Tester;
use crate::support::hex;
use profivac_wire::Sap;

/// A fault; Exception Status in EXECUTING at 1e-3 mbar, ID 27 and ID 28.
const FAULTS: [(&str, u8, &str, &str); 12] = [
    ("", 0x80, "02 00 00 06 00 00 00 00 00 00 01 00", "02 00 00 07 00 00 00 00 00 00 00 01 00"),
    ("eprom", 0xB1, "02 04 00 06 00 00 00 00 00 00 01 00", "02 04 00 07 01 00 00 00 00 00 00 01 00"),
    ("eeprom", 0xB1, "02 08 00 06 00 00 00 00 00 00 01 00", "02 08 00 07 01 00 00 00 00 00 00 01 00"),
    ("ram", 0xB1, "02 10 00 06 00 00 00 00 00 00 01 00", "02 10 00 07 01 00 00 00 00 00 00 01 00"),
    ("comm", 0xE4, "02 00 00 06 00 00 00 00 00 00 01 01", "02 00 00 07 01 00 00 00 00 00 00 01 01"),
    ("pirani-adjust", 0xA0, "02 00 00 06 00 00 00 00 00 00 01 00", "02 00 00 07 00 00 00 00 02 00 00 01 00"),
    ("sensor1", 0xA2, "02 00 00 06 00 00 00 02 00 00 01 00", "02 00 00 07 01 00 00 00 00 00 00 01 00"),
    ("electronics1", 0xA2, "02 00 00 06 00 00 00 02 00 00 01 00", "02 00 00 07 01 00 00 00 00 00 00 01 00"),
    ("sensor2", 0xA2, "02 00 00 06 00 00 00 00 00 02 01 00", "02 00 00 07 01 00 00 00 00 00 00 01 00"),
    ("electronics2", 0xA2, "02 00 00 06 00 00 00 00 00 02 01 00", "02 00 00 07 01 00 00 00 00 00 00 01 00"),
    ("sensor3", 0xA2, "02 00 00 06 00 02 00 00 00 00 01 00", "02 00 00 07 01 00 00 00 00 00 00 01 00"),
    ("electronics3", 0xA2, "02 00 00 06 00 02 00 00 00 00 01 00", "02 00 00 07 01 00 00 00 00 00 00 01 00"),
];

/// (105), (118)
#[test]
fn every_fault_sets_its_bits_while_it_is_active() {
    for (fault, status, alarm, warning) in FAULTS {
        let mut tester = exchanging(FLOATS, 1e-3);
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

#[test]
fn the_faults_are_those_of_the_list() {
    let mut tester = exchanging(FLOATS, 1e-3);
    let mut listed: Vec<&str> = profivac_devices::SimulatedDevice::faults(tester.device()).names().collect();
    let mut tested: Vec<&str> = FAULTS.iter().map(|(fault, ..)| *fault).filter(|fault| !fault.is_empty()).collect();
    listed.sort_unstable();
    tested.sort_unstable();
    assert_eq!(listed, tested);
}

/// 3.1.1.13 to 3.1.1.20 with (41), and the sensor records and status extensions behind them.
pub fn copies_are_equal(tester: &mut Tester<Gauge>) {
    let [alarm, warning] = [27, 28].map(|index| tester.get(0, index));
    let parts = [
        (204, &alarm[1..2]),
        (205, &alarm[4..8]),
        (206, &alarm[8..10]),
        (207, &alarm[11..12]),
        (208, &warning[1..2]),
        (209, &warning[4..8]),
        (210, &warning[8..11]),
        (211, &warning[12..13]),
    ];
    for (index, part) in parts {
        assert_eq!(tester.get(0, index), part, "copy {index}");
    }
    let selected = tester.get(1, 46)[0];
    // Instances 3, 1, 2 in the records (46).
    for (position, instance) in [(0, 3), (1, 1), (2, 2)] {
        assert_eq!(of_instance(tester, instance, 103), alarm[4 + 2 * position..][..2], "alarm of {instance}");
        assert_eq!(of_instance(tester, instance, 104), warning[5 + 2 * position..][..2], "warning of {instance}");
        // (57)
        let valid = of_instance(tester, instance, 23)[0];
        assert_eq!(of_instance(tester, instance, 102)[0] & 1, 1 - valid, "status extension of {instance}");
    }
    assert_eq!(tester.get(1, 120), warning[4..5]);
    let groups = |record: &[u8]| {
        let any = |octets: &[u8]| u8::from(octets.iter().any(|octet| *octet != 0));
        let (device, manufacturer) = record[4..].split_at(record[3].into());
        any(&record[1..3]) | any(device) << 1 | any(&manufacturer[1..]) << 2
    };
    assert_eq!(tester.get(0, 26), [0x80 | groups(&alarm) | groups(&warning) << 4]);
    tester.put(1, 46, &[selected]).unwrap();
}

/// (57): in IDLE there is no fault, and no reading is valid.
#[test]
fn the_reading_is_invalid_outside_executing() {
    for mbar in [1e-9, 1e-3, 1.0, 1000.0] {
        let mut tester = crate::bcg450::tester();
        tester.pressure_mbar(mbar);
        assert_eq!((tester.get(0, 26), tester.get(1, 120)), (vec![0xA0], vec![0x01]), "{mbar} mbar");
        copies_are_equal(&mut tester);
    }
}

/// A pressure; Reading Valid and Status Extension of Pirani, BA and CDG in EXECUTING (58), (81).
const RANGES: [(f64, [u8; 3], [u8; 3]); 10] = [
    (4e-10, [0, 0, 0], [5, 5, 5]),
    (5e-10, [0, 1, 0], [5, 0, 5]),
    (5.4e-3, [0, 1, 0], [5, 0, 5]),
    (5.5e-3, [1, 1, 0], [0, 0, 5]),
    (2e-2, [1, 1, 0], [0, 0, 5]),
    (2.1e-2, [1, 0, 0], [0, 3, 5]),
    (1.0, [1, 0, 1], [0, 3, 0]),
    (1000.0, [1, 0, 1], [0, 3, 0]),
    (1001.0, [0, 0, 1], [3, 3, 0]),
    (1501.0, [0, 0, 0], [3, 3, 3]),
];

#[test]
fn every_instance_has_the_status_of_its_own_range() {
    for (mbar, valid, extension) in RANGES {
        let mut tester = exchanging(FLOATS, mbar);
        let instances = [1, 2, 3];
        assert_eq!(instances.map(|instance| of_instance(&mut tester, instance, 23)[0]), valid, "{mbar} mbar");
        assert_eq!(instances.map(|instance| of_instance(&mut tester, instance, 102)[0]), extension, "{mbar} mbar");
        // Status is always 0 (3.2.2.2).
        assert_eq!(instances.map(|instance| of_instance(&mut tester, instance, 20)[0]), [0; 3]);
        copies_are_equal(&mut tester);
    }
}

/// (54): an alarm of one part makes the reading of the others invalid too, a warning does not.
#[test]
fn any_alarm_makes_every_reading_invalid() {
    let mut tester = exchanging(FLOATS, 5.0);
    assert_eq!(of_instance(&mut tester, 3, 23), [1]);
    tester.fault("sensor2", true);
    assert_eq!(of_instance(&mut tester, 3, 23), [0]);
    tester.fault("sensor2", false);
    tester.fault("pirani-adjust", true);
    assert_eq!(of_instance(&mut tester, 3, 23), [1]);
    // The set points are always valid (56).
    tester.command(2).unwrap();
    assert_eq!(of_instance(&mut tester, 5, 23), [1]);
}

/// (16): faults are in Exception Status, not in the diagnosis.
#[test]
fn the_diagnosis_has_six_octets_with_the_ident_number_also_with_a_fault() {
    let mut tester = exchanging(FLOATS, 1e-3);
    for is_faulty in [false, true] {
        tester.fault("electronics3", is_faulty);
        let (_, du) = tester.request(Sap::SlaveDiag, &[]).unwrap();
        assert_eq!((du.len(), &du[4..]), (6, &[0x08, 0xE6][..]), "fault: {is_faulty}");
    }
}
