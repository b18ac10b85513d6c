//! Cyclic exchange: all configurations and all unit strings; all others are refused. tira36e1 1.3, 1.4, 1.5, 2.3.

use crate::support::{Tester, hex};
use crate::xpg400::{Gauge, KINDS, MBAR, tester};
use profivac_devices::xpg400::Xpg400Model;
use profivac_dp::slave::Device;
use profivac_wire::Sap;

/// errata-bpg-bcg-tpg, corrected tables: configuration, outputs, inputs. The last octet of the last one is 08h (1).
const CONFIGURATIONS: [(&str, usize, usize); 4] = [
    ("44 84 05 05 05 03", 0, 5),
    ("44 86 05 05 05 08", 0, 7),
    ("C6 87 8C 0A 0A 05 05 05 03", 8, 13),
    ("C6 87 8E 0A 0A 05 05 05 08", 8, 15),
];

/// 1.5: the string, and 0.012 mbar as a float and as an integer, without COUNTS.
const UNITS: [(&str, f64, u16); 4] = [
    ("00 00 00 05 15", 9.000_740_16e-3, 0),
    ("00 00 00 05 16", 9.000_740_16, 9),
    ("00 00 00 05 1C", 0.012, 0),
    ("00 00 00 05 1D", 1.2, 1),
];

/// At 0.012 mbar the Pirani of a BPG400-SP measures, and the ionisation part of an HPG400-SP.
const AT_0_012_MBAR: [(Xpg400Model, u8, f64, u16); 2] =
    [(Xpg400Model::Bpg, 1, 21158.362, 21158), (Xpg400Model::Hpg, 2, 19211.15, 19211)];

#[test]
fn the_ident_numbers_are_those_of_the_manual() {
    assert_eq!(KINDS.map(|kind| crate::xpg400::gauge(kind).ident_number()), [0x06A9, 0x06A8]);
}

/// (10), (14), (15): inputs are what the slave sends; the table has the contents; lengths are consistent.
#[test]
fn every_configuration_sends_the_pressure_in_every_unit() {
    for (kind, active, counts, whole_counts) in AT_0_012_MBAR {
        for (cfg, outputs, inputs) in CONFIGURATIONS {
            for (user, float, integer) in UNITS.into_iter().chain([("00 00 00 03 E9", counts, whole_counts)]) {
                let mut tester = tester(kind);
                tester.pressure_mbar(0.012);
                tester.bring_up(&hex(user), &hex(cfg));
                let du = tester.exchange(&vec![0; outputs]);
                assert_eq!(du.len(), inputs, "{cfg}");
                let process = if inputs > 8 { &du[8..] } else { &du[..] };
                assert_eq!(process[..3], [0x80, 0x00, active], "{kind:?} {cfg} {user}");
                match process[3..] {
                    [a, b] => assert_eq!(u16::from_be_bytes([a, b]), integer, "{kind:?} {cfg} {user}"),
                    [a, b, c, d] => {
                        let value = f64::from(f32::from_be_bytes([a, b, c, d]));
                        assert!((value / float - 1.0).abs() < 1e-6, "{kind:?} {cfg} {user}: {value}, not {float}");
                    }
                    _ => panic!("{cfg} {user}: {du:02X?}"),
                }
            }
        }
    }
}

/// Exception Status, status extension and PV selector at a pressure. Ambient air is overrange (53).
fn statuses(kind: Xpg400Model) -> &'static [(f64, [u8; 3])] {
    match kind {
        Xpg400Model::Bpg => &[
            (1e-11, [0xA0, 0x05, 2]),
            (5e-10, [0x80, 0x00, 2]),
            (1e-7, [0x80, 0x00, 2]),
            (5.49e-3, [0x80, 0x00, 2]),
            (5.5e-3, [0x80, 0x00, 1]),
            (1.0, [0x80, 0x00, 1]),
            (1000.0, [0x80, 0x00, 1]),
            (1013.25, [0xA0, 0x03, 1]),
        ],
        Xpg400Model::Hpg => &[
            (9e-7, [0xA0, 0x05, 2]),
            (1e-6, [0x80, 0x00, 2]),
            (5e-3, [0x80, 0x00, 2]),
            (0.99, [0x80, 0x00, 2]),
            (1.0, [0x80, 0x00, 1]),
            (1000.0, [0x80, 0x00, 1]),
            (1013.25, [0xA0, 0x03, 1]),
        ],
    }
}

#[test]
fn telegram_3_follows_the_pressure_over_the_whole_range() {
    for kind in KINDS {
        let mut tester = tester(kind);
        tester.bring_up(&hex(MBAR), &hex("44 86 05 05 05 08"));
        for (mbar, status) in statuses(kind) {
            tester.pressure_mbar(*mbar);
            let du = tester.exchange(&[]);
            assert_eq!(du[..3], *status, "{kind:?} {mbar} mbar");
            let value = f64::from(crate::xpg400::float_of(&du[3..]));
            assert!((value / mbar - 1.0).abs() < 1e-6, "{kind:?}: {mbar} mbar reads {value}");
        }
    }
}

/// (12), (13): also that of the parameter channel alone, and those of other devices.
#[test]
fn a_configuration_that_is_not_in_the_table_is_refused() {
    let strings: Vec<Vec<u8>> = CONFIGURATIONS.iter().map(|(cfg, ..)| hex(cfg)).collect();
    let refused = |tester: &mut Tester<Gauge>, other: &[u8]| {
        tester.set_prm(&hex(MBAR));
        tester.chk_cfg(other);
        // Cfg_Fault (7)
        assert_eq!(tester.diag()[0] & 0x04 != 0, !tester.is_exchanging(), "{other:02X?}");
        !tester.is_exchanging()
    };
    for string in &strings {
        for position in 0..string.len() {
            for octet in 0..=255 {
                let mut other = string.clone();
                other[position] = octet;
                assert_eq!(refused(&mut tester(Xpg400Model::Bpg), &other), !strings.contains(&other), "{other:02X?}");
            }
        }
        assert!(refused(&mut tester(Xpg400Model::Hpg), &string[..string.len() - 1]));
    }
    // Those of the BCG450-SP with a transition command.
    assert!(refused(&mut tester(Xpg400Model::Bpg), &hex("C6 81 86 05 05 05 05 05 08")));
}

#[test]
fn only_the_unit_strings_are_accepted_with_or_without_dpv1_enable_fail_safe_and_check_cfg_mode() {
    let mut tester = tester(Xpg400Model::Hpg);
    let mut accepts = |user: &[u8]| {
        tester.set_prm(user);
        // Prm_Fault (6)
        tester.diag()[0] & 0x40 == 0
    };
    for code in 0..=u16::MAX {
        let [high, low] = code.to_be_bytes();
        let known = [1001, 1301, 1302, 1308, 1309].contains(&code);
        assert_eq!(accepts(&[0, 0, 0, high, low]), known, "{code}");
    }
    for first in 0..=255 {
        // (4)
        assert_eq!(accepts(&[first, 0, 0, 0x05, 0x1C]), first & !0xC0 == 0, "{first:02X}");
        assert_eq!(accepts(&[0, first, 0, 0x05, 0x1C]), first & !0x01 == 0, "{first:02X}");
    }
    for user in ["", "00", "00 00 00", "00 00 00 05", "00 00 00 05 1C 00", "C0 01 00 13 08", "05 1C"] {
        assert!(!accepts(&hex(user)), "{user}");
    }
}

#[test]
fn get_cfg_returns_the_default_before_the_first_configuration() {
    let mut tester = tester(Xpg400Model::Bpg);
    let (_, cfg) = tester.request(Sap::GetCfg, &[]).unwrap();
    assert_eq!(cfg, hex("44 86 05 05 05 08"));
    tester.bring_up(&hex(MBAR), &hex("C6 87 8E 0A 0A 05 05 05 08"));
    let (_, cfg) = tester.request(Sap::GetCfg, &[]).unwrap();
    assert_eq!(cfg, hex("C6 87 8E 0A 0A 05 05 05 08"));
}
