//! The BCG450-SP in cyclic exchange: all configurations and all unit strings; all others are refused. tira41d1 1.4, 1.5, 2.3.

use crate::bcg450::tester;
use crate::support::hex;
use profivac_wire::Sap;

/// errata-bpg-bcg-tpg, corrected tables: configuration, outputs, inputs. Outputs have 0, 2, 8 or 10 octets (11).
const CONFIGURATIONS: [(&str, usize, usize); 8] = [
    ("44 84 05 05 05 03", 0, 5),
    ("44 86 05 05 05 08", 0, 7),
    ("C6 81 84 05 05 05 05 05 03", 2, 5),
    ("C6 81 86 05 05 05 05 05 08", 2, 7),
    ("C6 87 8C 0A 0A 05 05 05 03", 8, 13),
    ("C6 87 8E 0A 0A 05 05 05 08", 8, 15),
    ("C8 89 8C 0A 05 05 0A 05 05 05 03", 10, 13),
    ("C8 89 8E 0A 05 05 0A 05 05 05 08", 10, 15),
];

/// 1.5: the string, and 0.012 mbar as a float and as an integer, with the unit factors of (83).
const UNITS: [(&str, f64, u16); 5] = [
    ("00 00 00 03 E9", 21158.362, 21158),
    ("00 00 00 05 15", 9.000_740_16e-3, 0),
    ("00 00 00 05 16", 9.000_740_16, 9),
    ("00 00 00 05 1C", 0.012, 0),
    ("00 00 00 05 1D", 1.2, 1),
];

/// (10), (14), (15): inputs are what the slave sends; the table has the contents; lengths are consistent.
#[test]
fn every_configuration_sends_the_pressure_in_every_unit() {
    for (cfg, outputs, inputs) in CONFIGURATIONS {
        for (user, float, integer) in UNITS {
            let mut tester = tester();
            tester.pressure_mbar(0.012);
            tester.bring_up(&hex(user), &hex(cfg));
            let du = tester.exchange(&vec![0; outputs]);
            assert_eq!(du.len(), inputs, "{cfg}");
            let process = if inputs > 8 { &du[8..] } else { &du[..] };
            // In the upper half of the overlap (79): the Pirani measures, and there is no exception.
            assert_eq!(process[..3], [0x80, 0x00, 0x01], "{cfg} {user}");
            match process[3..] {
                [a, b] => assert_eq!(u16::from_be_bytes([a, b]), integer, "{cfg} {user}"),
                [a, b, c, d] => {
                    let value = f64::from(f32::from_be_bytes([a, b, c, d]));
                    assert!((value / float - 1.0).abs() < 1e-6, "{cfg} {user}: {value} instead of {float}");
                }
                _ => panic!("{cfg} {user}: {du:02X?}"),
            }
        }
    }
}

/// A pressure, and Exception Status, status extension and PV selector at it: Pirani 1, BA 2, CDG 3 (78).
const PRESSURES: [(f64, [u8; 3]); 12] = [
    (1e-11, [0xA0, 0x05, 2]),
    (5e-10, [0x80, 0x00, 2]),
    (1e-7, [0x80, 0x00, 2]),
    (5.4e-3, [0x80, 0x00, 2]),
    (9e-3, [0x80, 0x00, 2]),
    (1.1e-2, [0x80, 0x00, 1]),
    (2.3e-2, [0x80, 0x00, 1]),
    (0.5, [0x80, 0x00, 1]),
    (3.0, [0x80, 0x00, 1]),
    (3.5, [0x80, 0x00, 3]),
    (1500.0, [0x80, 0x00, 3]),
    (2000.0, [0xA0, 0x03, 3]),
];

#[test]
fn telegram_5_follows_the_pressure_over_the_whole_range() {
    let mut tester = tester();
    tester.bring_up(&hex("00 00 00 05 1C"), &hex("44 86 05 05 05 08"));
    for (mbar, status) in PRESSURES {
        tester.pressure_mbar(mbar);
        let du = tester.exchange(&[]);
        assert_eq!(du[..3], status, "{mbar} mbar");
        let value = f64::from(f32::from_be_bytes(du[3..].try_into().unwrap()));
        assert!((value / mbar - 1.0).abs() < 1e-6, "{mbar} mbar reads {value}");
    }
}

/// (12), (13): also that of the parameter channel alone, and those of other devices.
#[test]
fn a_configuration_that_is_not_in_the_table_is_refused() {
    let strings: Vec<Vec<u8>> = CONFIGURATIONS.iter().map(|(cfg, ..)| hex(cfg)).collect();
    for string in &strings {
        for position in 0..string.len() {
            for octet in 0..=255 {
                let mut other = string.clone();
                other[position] = octet;
                let mut tester = tester();
                tester.set_prm(&hex("00 00 00 05 1C"));
                tester.chk_cfg(&other);
                assert_eq!(tester.is_exchanging(), strings.contains(&other), "{other:02X?}");
                // Cfg_Fault, errata-bpg-bcg-tpg 7
                assert_eq!(tester.diag()[0] & 0x04 != 0, !strings.contains(&other), "{other:02X?}");
            }
        }
    }
}

#[test]
fn only_the_unit_strings_are_accepted_with_or_without_dpv1_enable_fail_safe_and_check_cfg_mode() {
    let mut tester = tester();
    let mut accepts = |user: &[u8]| {
        tester.set_prm(user);
        // Prm_Fault, errata-bpg-bcg-tpg 6
        tester.diag()[0] & 0x40 == 0
    };
    for code in 0..=u16::MAX {
        let [high, low] = code.to_be_bytes();
        let known = [1001, 1301, 1302, 1308, 1309].contains(&code);
        assert_eq!(accepts(&[0, 0, 0, high, low]), known, "{code}");
    }
    for first in 0..=255 {
        // errata-bpg-bcg-tpg 4
        assert_eq!(accepts(&[first, 0, 0, 0x05, 0x1C]), first & !0xC0 == 0, "{first:02X}");
        assert_eq!(accepts(&[0, first, 0, 0x05, 0x1C]), first & !0x01 == 0, "{first:02X}");
        assert_eq!(accepts(&[0xC0, 0x01, first, 0x05, 0x1C]), first == 0, "{first:02X}");
    }
    for user in ["", "00", "00 00 00", "00 00 00 05", "00 00 00 05 1C 00", "C0 01 00 13 08", "00 00 01 05 1C", "05 1C"]
    {
        assert!(!accepts(&hex(user)), "{user}");
    }
}

/// chosen, (4): `C0 01` is in the user parameters that awlsim sends to every DP-V1 slave. Check_Cfg_Mode makes no check easier; with
/// Fail_Safe outputs of length 0 are Clear.
#[test]
fn the_configuration_check_stays_strict_and_empty_outputs_need_fail_safe() {
    let mut tester = tester();
    tester.set_prm(&hex("C0 01 00 05 1C"));
    // One octet short, as 1.4 prints it (2).
    tester.chk_cfg(&hex("C6 81 86 05 05 05 05 08"));
    assert!(!tester.is_exchanging());
    for (user, exchanges) in [("C0 01 00 05 1C", true), ("80 01 00 05 1C", false)] {
        tester.bring_up(&hex(user), &hex("C6 81 86 05 05 05 05 05 08"));
        assert_eq!(tester.exchange(&[]).len(), 7, "{user}");
        assert_eq!(tester.is_exchanging(), exchanges, "{user}");
    }
}

#[test]
fn get_cfg_returns_the_default_before_the_first_configuration() {
    let mut tester = tester();
    let (_, cfg) = tester.request(Sap::GetCfg, &[]).unwrap();
    assert_eq!(cfg, hex("44 86 05 05 05 08"));
    tester.bring_up(&hex("00 00 00 05 1C"), &hex("C6 87 8E 0A 0A 05 05 05 08"));
    let (_, cfg) = tester.request(Sap::GetCfg, &[]).unwrap();
    assert_eq!(cfg, hex("C6 87 8E 0A 0A 05 05 05 08"));
}
