//! Exception Status, its two records and their copies. tira36e1 3.1.1.10 to 3.1.1.20, (38) to (58).

use crate::support::{Tester, hex};
use crate::xpg400::{FLOATS, Gauge, KINDS, exchanging, of_instance};
use profivac_devices::SimulatedDevice;
use profivac_devices::xpg400::Xpg400Model;

/// A fault; Exception Status in EXECUTING at 1e-3 mbar, ID 27 and ID 28.
const FAULTS: [(&str, u8, &str, &str); 10] = [
    ("", 0x80, "02 00 00 04 00 00 00 00 01 00", "02 00 00 05 00 00 00 00 00 01 00"),
    ("eprom", 0xB1, "02 04 00 04 00 00 00 00 01 00", "02 04 00 05 01 00 00 00 00 01 00"),
    ("eeprom", 0xB1, "02 08 00 04 00 00 00 00 01 00", "02 08 00 05 01 00 00 00 00 01 00"),
    ("ram", 0xB1, "02 10 00 04 00 00 00 00 01 00", "02 10 00 05 01 00 00 00 00 01 00"),
    ("comm", 0xE4, "02 00 00 04 00 00 00 00 01 01", "02 00 00 05 01 00 00 00 00 01 01"),
    ("pirani-adjust", 0xA0, "02 00 00 04 00 00 00 00 01 00", "02 00 00 05 01 00 02 00 00 01 00"),
    ("sensor1", 0xA2, "02 00 00 04 00 02 00 00 01 00", "02 00 00 05 01 00 00 00 00 01 00"),
    ("electronics1", 0xA2, "02 00 00 04 00 02 00 00 01 00", "02 00 00 05 01 00 00 00 00 01 00"),
    ("sensor2", 0xA2, "02 00 00 04 00 00 00 02 01 00", "02 00 00 05 01 00 00 00 00 01 00"),
    ("electronics2", 0xA2, "02 00 00 04 00 00 00 02 01 00", "02 00 00 05 01 00 00 00 00 01 00"),
];

/// (105), (118)
#[test]
fn every_fault_sets_its_bits_while_it_is_active() {
    for (kind, (fault, status, alarm, warning)) in KINDS.into_iter().flat_map(|kind| FAULTS.map(|it| (kind, it))) {
        let mut tester = exchanging(kind, FLOATS, 1e-3);
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
    for kind in KINDS {
        let mut listed: Vec<&str> = crate::xpg400::gauge(kind).faults().names().collect();
        let mut tested: Vec<&str> = FAULTS.iter().map(|(fault, ..)| *fault).filter(|fault| !fault.is_empty()).collect();
        listed.sort_unstable();
        tested.sort_unstable();
        assert_eq!(listed, tested);
    }
}

/// 3.1.1.15 to 3.1.1.20 with (40), and the sensor records and status extensions behind them.
pub fn copies_are_equal(tester: &mut Tester<Gauge>) {
    let [alarm, warning] = [27, 28].map(|index| tester.get(0, index));
    let parts = [
        (204, &alarm[1..2]),
        (205, &alarm[4..8]),
        (206, &alarm[9..10]),
        (207, &warning[1..2]),
        (208, &warning[5..9]),
        (209, &warning[10..11]),
    ];
    for (index, part) in parts {
        assert_eq!(tester.get(0, index), part, "copy {index}");
    }
    let selected = tester.get(1, 46)[0];
    for (position, instance) in [(0, 1), (2, 2)] {
        assert_eq!(of_instance(tester, instance, 103), alarm[4 + position..][..2], "alarm of {instance}");
        assert_eq!(of_instance(tester, instance, 104), warning[5 + position..][..2], "warning of {instance}");
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
    for (kind, mbar) in KINDS.into_iter().flat_map(|kind| [1e-5, 1e-1, 1000.0].map(|mbar| (kind, mbar))) {
        let mut tester = crate::xpg400::tester(kind);
        tester.pressure_mbar(mbar);
        assert_eq!((tester.get(0, 26), tester.get(1, 120)), (vec![0xA0], vec![0x01]), "{kind:?} {mbar} mbar");
        copies_are_equal(&mut tester);
    }
}

/// A pressure; Reading Valid and Status Extension of both instances in EXECUTING (55, 58, 81).
fn ranges(kind: Xpg400Model) -> &'static [(f64, [u8; 2], [u8; 2])] {
    match kind {
        Xpg400Model::Bpg => &[
            (4e-10, [0, 0], [5, 5]),
            (5e-10, [0, 1], [5, 0]),
            (5.4e-3, [0, 1], [5, 0]),
            (5.5e-3, [1, 1], [0, 0]),
            (2e-2, [1, 1], [0, 0]),
            (2.1e-2, [1, 0], [0, 3]),
            (1000.0, [1, 0], [0, 3]),
            (1001.0, [0, 0], [3, 3]),
        ],
        Xpg400Model::Hpg => &[
            (9e-7, [0, 0], [5, 5]),
            (1e-6, [0, 1], [5, 0]),
            (9.9e-3, [0, 1], [5, 0]),
            (1e-2, [1, 1], [0, 0]),
            (0.99, [1, 1], [0, 0]),
            (1.0, [1, 0], [0, 3]),
            (1000.0, [1, 0], [0, 3]),
            (1001.0, [0, 0], [3, 3]),
        ],
    }
}

#[test]
fn every_instance_has_the_status_of_its_own_range() {
    for (kind, (mbar, valid, extension)) in
        KINDS.into_iter().flat_map(|kind| ranges(kind).iter().map(move |it| (kind, it)))
    {
        let mut tester = exchanging(kind, FLOATS, *mbar);
        assert_eq!([1, 2].map(|instance| of_instance(&mut tester, instance, 23)[0]), *valid, "{kind:?} {mbar} mbar");
        let extensions = [1, 2].map(|instance| of_instance(&mut tester, instance, 102)[0]);
        assert_eq!(extensions, *extension, "{kind:?} {mbar} mbar");
        // Status is always 0 (3.2.2.2).
        assert_eq!([1, 2].map(|instance| of_instance(&mut tester, instance, 20)[0]), [0; 2]);
        copies_are_equal(&mut tester);
    }
}

/// (54): alarms and, unlike on the BCG450-SP, warnings of a defect make every reading invalid. The range does not.
#[test]
fn alarms_and_warnings_make_every_reading_invalid() {
    for (kind, fault) in
        KINDS.into_iter().flat_map(|kind| ["sensor2", "pirani-adjust", "ram", "comm"].map(|it| (kind, it)))
    {
        let mut tester = exchanging(kind, FLOATS, 5.0);
        assert_eq!(of_instance(&mut tester, 1, 23), [1]);
        tester.fault(fault, true);
        assert_eq!(of_instance(&mut tester, 1, 23), [0], "{kind:?} {fault}");
        tester.fault(fault, false);
        assert_eq!(of_instance(&mut tester, 1, 23), [1]);
        // The set points are always valid (56).
        tester.fault(fault, true);
        tester.command(2).unwrap();
        assert_eq!([3, 4].map(|instance| of_instance(&mut tester, instance, 23)[0]), [1, 1]);
    }
}
