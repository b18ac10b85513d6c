//! All models in cyclic exchange: every configuration and every user parameter string; all others are refused. 3.7, 3.8, 4.4.

use crate::pxg55x::{COUNTS, MBAR, PASCAL, TORR, TTR, tester};
use crate::support::hex;
use profivac_devices::pxg55x::Pxg55xModel;
use profivac_wire::Sap;

/// The contents of a telegram, in order.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Part {
    /// Parameter channel.
    Channel,
    /// Exception Status.
    Exceptions,
    /// Status extension.
    Status,
    /// PV Selector.
    Selector,
    /// Process value, integer.
    Integer,
    /// Process value, float.
    Float,
    /// Trip relays.
    Relays,
}

use Part::{Channel, Exceptions, Float, Integer, Relays, Selector, Status};

/// 4.4.1 and 4.4.2: configuration, octets out, octets in, and their contents. Without TTR compatibility.
const CONFIGURATIONS: [(&str, usize, usize, &[Part]); 12] = [
    ("42 82 05 03", 0, 3, &[Exceptions, Integer]),
    ("42 84 05 08", 0, 5, &[Exceptions, Float]),
    ("44 84 05 05 05 03", 0, 5, &[Exceptions, Status, Selector, Integer]),
    ("44 86 05 05 05 08", 0, 7, &[Exceptions, Status, Selector, Float]),
    ("C4 87 8A 0A 0A 05 03", 8, 11, &[Channel, Exceptions, Integer]),
    ("C4 87 8C 0A 0A 05 08", 8, 13, &[Channel, Exceptions, Float]),
    ("C6 87 8C 0A 0A 05 05 05 03", 8, 13, &[Channel, Exceptions, Status, Selector, Integer]),
    ("C6 87 8E 0A 0A 05 05 05 08", 8, 15, &[Channel, Exceptions, Status, Selector, Float]),
    ("44 85 05 03 05 0A", 0, 6, &[Exceptions, Integer, Status, Relays]),
    ("44 87 05 08 05 0A", 0, 8, &[Exceptions, Float, Status, Relays]),
    ("C6 87 8D 0A 0A 05 03 05 0A", 8, 14, &[Channel, Exceptions, Integer, Status, Relays]),
    ("C6 87 8F 0A 0A 05 08 05 0A", 8, 16, &[Channel, Exceptions, Float, Status, Relays]),
];

/// "A1 91" is for TTR compatibility only (49).
const TTR_CONFIGURATION: &str = "A1 91";

/// 3.8: the string, and 800 mbar as a float and as an integer. 3511 x log10(800 x 2^20) + 1 counts (81); an
/// integer is cut and saturates (16, 17).
const UNITS: [(&str, f64, u16); 4] =
    [(COUNTS, 31_332.06, 31332), (TORR, 600.049_304, 600), (MBAR, 800.0, 800), (PASCAL, 80_000.0, 32767)];

/// Splits the inputs of a telegram into its fields.
fn check(du: &[u8], parts: &[Part], selector: u8, float: f64, integer: u16) {
    let mut rest = du;
    let mut take = |octets: usize| {
        let (taken, after) = rest.split_at(octets);
        rest = after;
        taken
    };
    for part in parts {
        match part {
            Channel => assert_eq!(take(8), [0; 8]),
            Exceptions => assert_eq!(take(1), [0x80]),
            Status => assert_eq!(take(1), [0]),
            Selector => assert_eq!(take(1), [selector]),
            Integer => assert_eq!(take(2), integer.to_be_bytes()),
            Float => {
                let value = f64::from(f32::from_be_bytes(take(4).try_into().unwrap()));
                assert!((value / float - 1.0).abs() < 1e-6, "{value} instead of {float}");
            }
            Relays => assert_eq!(take(2), [0, 0]),
        }
    }
    assert!(rest.is_empty());
}

/// (29), (46), (47), (51), (64), (65): the telegrams have what their table lists.
#[test]
fn every_gauge_exchanges_in_every_configuration_and_unit() {
    for kind in Pxg55xModel::all() {
        for (cfg, outputs, inputs, parts) in CONFIGURATIONS {
            for (user, float, integer) in UNITS {
                let mut tester = tester(kind);
                tester.pressure_mbar(800.0);
                tester.bring_up(&hex(user), &hex(cfg));
                let du = tester.exchange(&vec![0; outputs]);
                assert_eq!(du.len(), inputs, "{cfg}");
                check(&du, parts, 1, float, integer);
            }
        }
    }
}

#[test]
fn every_gauge_exchanges_in_ttr_compatibility() {
    for kind in Pxg55xModel::all() {
        let mut tester = tester(kind);
        tester.pressure_mbar(1.0);
        tester.bring_up(&hex(TTR), &hex(TTR_CONFIGURATION));
        // 482 x 4.778 = 2303; the two octets to the gauge are not processed.
        assert_eq!(tester.exchange(&[0xFF, 0xFF]), [0x08, 0xFF]);
    }
}

#[test]
fn there_are_nine_gauges_of_six_names() {
    let kinds: Vec<_> =
        Pxg55xModel::all().map(|kind| (kind.variant().model.name, kind.variant().family.atm.is_some())).collect();
    let of = |name, atmosphere| kinds.contains(&(name, atmosphere));
    assert_eq!(kinds.len(), 9);
    for name in ["pcg550", "pcg552", "pcg554"] {
        assert!(of(name, true) && of(name, false), "{name}");
    }
    for name in ["psg550", "psg552", "psg554"] {
        assert!(of(name, false) && !of(name, true), "{name}");
        assert!(Pxg55xModel::named(name, Some(true)).is_none(), "{name}");
    }
    let with_sensor = |kind: Option<Pxg55xModel>| kind.map(|kind| kind.variant().family.atm.is_some());
    assert_eq!(with_sensor(Pxg55xModel::named("pcg552", None)), Some(true));
    assert_eq!(with_sensor(Pxg55xModel::named("pcg552", Some(false))), Some(false));
    assert_eq!(with_sensor(Pxg55xModel::named("psg554", None)), Some(false));
    assert!(Pxg55xModel::named("pcg551", None).is_none());
}

#[test]
fn a_configuration_that_is_not_in_the_table_is_refused() {
    let strings: Vec<Vec<u8>> = CONFIGURATIONS.iter().map(|(cfg, ..)| hex(cfg)).collect();
    let mut tester = tester(Pxg55xModel::named("pcg550", None).unwrap());
    for string in strings.iter().chain([&hex(TTR_CONFIGURATION)]) {
        for position in 0..string.len() {
            for octet in 0..=255 {
                let mut other = string.clone();
                other[position] = octet;
                tester.set_prm(&hex(MBAR));
                tester.chk_cfg(&other);
                assert_eq!(tester.is_exchanging(), strings.contains(&other), "{other:02X?}");
                // Cfg_Fault (41)
                assert_eq!(tester.diag()[0] & 0x04 != 0, !strings.contains(&other), "{other:02X?}");
            }
        }
    }
}

#[test]
fn ttr_compatibility_excludes_all_other_configurations() {
    for (cfg, ..) in CONFIGURATIONS {
        let mut tester = tester(Pxg55xModel::named("psg550", None).unwrap());
        tester.set_prm(&hex(TTR));
        tester.chk_cfg(&hex(cfg));
        assert!(!tester.is_exchanging(), "{cfg}");
        assert_ne!(tester.diag()[0] & 0x04, 0, "{cfg}");
    }
}

#[test]
fn only_the_printed_strings_are_accepted() {
    let mut tester = tester(Pxg55xModel::named("pcg554", None).unwrap());
    let mut accepts = |user: &[u8]| {
        tester.set_prm(user);
        // Prm_Fault (40)
        tester.diag()[0] & 0x40 == 0
    };
    for code in 0..=u16::MAX {
        let [high, low] = code.to_be_bytes();
        // Hexadecimal (14), no micron (62), 0 for TTR.
        let known = [0x1001, 0x1301, 0x1308, 0x1309, 0].contains(&code);
        assert_eq!(accepts(&[0, 0, 0, high, low]), known, "{code:04X}");
    }
    for first in 0..=255 {
        // The slave handles DPV1_Enable, Fail_Safe and WD_Base_1ms (39).
        assert_eq!(accepts(&[first, 0, 0, 0x13, 0x08]), first & !0xC4 == 0, "{first:02X}");
        // Check_Cfg_Mode (39)
        assert_eq!(accepts(&[0, first, 0, 0x13, 0x08]), first & !0x01 == 0, "{first:02X}");
    }
    for user in ["", "13 08", "00 00 00", "00 00 00 13", "00 00 00 13 08 00", "C0 01 00 13 02", "00 00 01 13 08"] {
        assert!(!accepts(&hex(user)), "{user}");
    }
}

#[test]
fn get_cfg_returns_the_default_before_the_first_configuration() {
    let mut tester = tester(Pxg55xModel::named("pcg550", None).unwrap());
    let (_, cfg) = tester.request(Sap::GetCfg, &[]).unwrap();
    assert_eq!(cfg, hex("42 84 05 08"));
    tester.bring_up(&hex(MBAR), &hex("C6 87 8F 0A 0A 05 08 05 0A"));
    let (_, cfg) = tester.request(Sap::GetCfg, &[]).unwrap();
    assert_eq!(cfg, hex("C6 87 8F 0A 0A 05 08 05 0A"));
}
