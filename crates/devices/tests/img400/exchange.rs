//! Cyclic exchange: all configurations, all unit strings, every combination of gauges. BG 5530 4.2, 4.3.3, Appendix A.

use crate::img400::{Controller, controller, every_combination, tester};
use crate::support::{Tester, hex};
use profivac_devices::SimulatedDevice;
use profivac_devices::img400::{Gauges, IonGauge, OtherGauge};

/// The verified strings of the errata: configuration, outputs, inputs. 9, 10 (113) and 14 (114) are corrected.
pub const CONFIGURATIONS: [(&str, usize, usize); 16] = [
    ("45 88 05 03 03 03 03", 0, 9),
    ("45 90 05 08 08 08 08", 0, 17),
    ("C7 81 88 05 05 05 03 03 03 03", 2, 9),
    ("C7 81 90 05 05 05 08 08 08 08", 2, 17),
    ("C7 87 90 0A 0A 05 03 03 03 03", 8, 17),
    ("C7 87 98 0A 0A 05 08 08 08 08", 8, 25),
    ("C9 89 90 0A 05 05 0A 05 03 03 03 03", 10, 17),
    ("C9 89 98 0A 05 05 0A 05 08 08 08 08", 10, 25),
    ("47 91 05 03 03 03 03 0A 0A", 0, 18),
    ("47 99 05 08 08 08 08 0A 0A", 0, 26),
    ("C9 81 91 05 05 05 03 03 03 03 0A 0A", 2, 18),
    ("C9 81 99 05 05 05 08 08 08 08 0A 0A", 2, 26),
    ("C9 87 99 0A 0A 05 03 03 03 03 0A 0A", 8, 26),
    ("C9 87 A1 0A 0A 05 08 08 08 08 0A 0A", 8, 34),
    ("CB 89 99 0A 05 05 0A 05 03 03 03 03 0A 0A", 10, 26),
    ("CB 89 A1 0A 05 05 0A 05 08 08 08 08 0A 0A", 10, 34),
];

/// The printed strings of 9, 10 and 14.
const PRINTED: [&str; 3] =
    ["47 91 05 03 03 03 03 0A 0A 0A", "47 99 05 08 08 08 08 0A 0A 0A", "C9 87 A1 0A 0A 05 08 08 08 08 08 0A 0A"];

/// 4.2.5: the string, and 500 hPa as a float and as an unsigned word.
const UNITS: [(&str, f64, u16); 5] = [
    ("00 00 00 10 01", 60_795.880_017, 60_795),
    ("00 00 00 13 01", 375.030_84, 375),
    ("00 00 00 13 02", 375_030.84, 65_535),
    ("00 00 00 13 08", 500.0, 500),
    ("00 00 00 13 09", 50_000.0, 50_000),
];

const HPA: &str = "00 00 00 13 08";

/// The position of Exception Status.
fn process(du: &[u8], outputs: usize) -> &[u8] {
    if outputs >= 8 { &du[8..] } else { du }
}

/// (115)
#[test]
fn every_configuration_sends_every_channel_in_every_unit() {
    let gauges = Gauges { ch1: None, ch2: None, ch3: Some(OtherGauge::Tpr), ch4: Some(OtherGauge::Cmr) };
    for (cfg, outputs, inputs) in CONFIGURATIONS {
        for (user, float, integer) in UNITS {
            let mut tester = Tester::new(controller(gauges));
            tester.pressure_mbar(500.0);
            tester.bring_up(&hex(user), &hex(cfg));
            let du = tester.exchange(&vec![0; outputs]);
            assert_eq!(du.len(), inputs, "{cfg}");
            let process = process(&du, outputs);
            // Placeholders on channels 1 and 2 set a warning and no other bit (126).
            assert_eq!(process[0], 0xA0, "{cfg} {user}");
            let rest = if cfg.contains("08 08") {
                for channel in process[1..17].chunks(4).skip(2) {
                    let value = f64::from(f32::from_be_bytes(channel.try_into().unwrap()));
                    assert!((value / float - 1.0).abs() < 1e-6, "{cfg} {user}: {value} instead of {float}");
                }
                &process[17..]
            } else {
                assert_eq!(process[5..9], [integer.to_be_bytes(), integer.to_be_bytes()].concat(), "{cfg} {user}");
                &process[9..]
            };
            // Channel Status (127) and seven open relays, where the telegram has them.
            let expected: &[u8] = if rest.is_empty() { &[] } else { &[0x11, 0x00, 0, 0, 0, 0, 0, 0, 0] };
            assert_eq!(rest, expected, "{cfg}");
        }
    }
}

#[test]
fn a_configuration_that_is_not_in_the_table_is_refused() {
    let strings: Vec<Vec<u8>> = CONFIGURATIONS.iter().map(|(cfg, ..)| hex(cfg)).collect();
    let altered = strings.iter().flat_map(|string| {
        (0..string.len()).flat_map(move |position| {
            [0x00, 0x01, 0x05, 0x08, 0x80, 0xFF].into_iter().map(move |bits| {
                let mut other = string.clone();
                other[position] ^= bits;
                other
            })
        })
    });
    let shortened = strings.iter().map(|string| string[..string.len() - 1].to_vec());
    for other in PRINTED.iter().map(|string| hex(string)).chain(altered).chain(shortened) {
        let mut tester = tester();
        tester.set_prm(&hex(HPA));
        tester.chk_cfg(&other);
        assert_eq!(tester.is_exchanging(), strings.contains(&other), "{other:02X?}");
        // Cfg_Fault (41)
        assert_eq!(tester.diag()[0] & 0x04 != 0, !strings.contains(&other), "{other:02X?}");
    }
}

#[test]
fn only_the_unit_strings_are_accepted_with_or_without_dpv1_bits() {
    let mut tester = tester();
    let mut accepts = |user: &[u8]| {
        tester.unlock();
        tester.set_prm(user);
        // Prm_Fault (40)
        tester.diag()[0] & 0x40 == 0
    };
    for code in 0..=u16::MAX {
        let [high, low] = code.to_be_bytes();
        let known = [0x1001, 0x1301, 0x1302, 0x1308, 0x1309].contains(&code);
        assert_eq!(accepts(&[0, 0, 0, high, low]), known, "{code:04X}");
    }
    for first in 0..=255 {
        // DPV1_Enable, Fail_Safe, WD_Base_1ms (39)
        assert_eq!(accepts(&[first, 0, 0, 0x13, 0x08]), first & !0xC4 == 0, "{first:02X}");
        // Check_Cfg_Mode (39)
        assert_eq!(accepts(&[0, first, 0, 0x13, 0x08]), first & !0x01 == 0, "{first:02X}");
    }
    for user in ["", "00 00 00", "13 08", "00 00 00 13", "00 00 00 13 08 00", "00 00 01 13 08", "00 00 00 05 1C"] {
        assert!(!accepts(&hex(user)), "{user}");
    }
}

#[test]
fn get_cfg_returns_the_default_before_the_first_configuration() {
    let mut tester = tester();
    let (_, cfg) = tester.request(profivac_wire::Sap::GetCfg, &[]).unwrap();
    assert_eq!(cfg, hex("45 90 05 08 08 08 08"));
    let (_, diag) = tester.request(profivac_wire::Sap::SlaveDiag, &[]).unwrap();
    assert_eq!(diag[4..], [0x09, 0x47]);
}

#[test]
fn every_combination_of_gauges_exchanges_in_every_configuration() {
    // 1e-5 hPa is in the range of BAG and EXT, and below that of TPR and CMR.
    for gauges in every_combination() {
        let mut tester: Tester<Controller> = Tester::new(controller(gauges));
        tester.pressure_mbar(1e-5);
        let ion = |gauge: Option<IonGauge>| if gauge.is_some() { 0 } else { 1 };
        let other = |gauge: Option<OtherGauge>| if gauge.is_some() { 4 } else { 1 };
        let nibbles = [ion(gauges.ch1), ion(gauges.ch2), other(gauges.ch3), other(gauges.ch4)];
        let [ch1, ch2, ch3, ch4] = nibbles;
        for (slot, gauge) in [(1, gauges.ch1), (2, gauges.ch2)] {
            // A placeholder has no emission.
            let switched = tester.put(slot, 105, &[1]);
            assert_eq!(switched, if gauge.is_some() { Ok(()) } else { Err(202) }, "{gauges:?}");
        }
        for (cfg, outputs, inputs) in CONFIGURATIONS {
            tester.unlock();
            tester.bring_up(&hex(HPA), &hex(cfg));
            let du = tester.exchange(&vec![0; outputs]);
            assert_eq!(du.len(), inputs, "{gauges:?} {cfg}");
            let process = process(&du, outputs);
            // Any placeholder and any value out of range sets bit 5 (126).
            assert_eq!(process[0], if nibbles == [0; 4] { 0x80 } else { 0xA0 }, "{gauges:?} {cfg}");
            let (values, width) = if cfg.contains("08 08") { (&process[1..17], 4) } else { (&process[1..9], 2) };
            for (value, nibble) in values.chunks(width).zip(nibbles).filter(|_| width == 4) {
                let value = f32::from_be_bytes(value.try_into().unwrap());
                assert_eq!(nibble & 1 == 0, value == 1e-5, "{gauges:?} {cfg}: {value}");
            }
            // Channel Status (127) and the relays, where the telegram has them.
            let rest = &process[1 + values.len()..];
            let expected = [ch2 << 4 | ch1, ch4 << 4 | ch3, 0, 0, 0, 0, 0, 0, 0];
            assert!(rest.is_empty() || rest == expected, "{gauges:?} {cfg}: {rest:02X?}");
        }
    }
}

#[test]
fn only_a_full_controller_with_everything_on_has_no_warning() {
    // (126): configurations 61 to 76 of Appendix A
    for gauges in every_combination() {
        let is_full = gauges.ch1.is_some() && gauges.ch2.is_some() && gauges.ch3.is_some() && gauges.ch4.is_some();
        let has_ion = gauges.ch1.is_some() || gauges.ch2.is_some();
        let mut tester: Tester<Controller> = Tester::new(controller(gauges));
        sense_in_range(tester.device());
        tester.bring_up(&hex(HPA), &hex(CONFIGURATIONS[11].0));
        assert_eq!(tester.exchange(&[0, 0])[0] == 0x80, is_full && !has_ion, "{gauges:?} without emission");
        assert_eq!(tester.exchange(&[3, 1])[0] == 0x80, is_full, "{gauges:?} with emission");
    }
}

/// Each gauge in a chamber where it can measure.
fn sense_in_range(device: &mut Controller) {
    let channels: Vec<u8> = device.parts().iter().map(|part| part.instance).collect();
    for (part, channel) in channels.into_iter().enumerate() {
        device.sense(part, if channel <= 2 { 1e-3 } else { 1e3 });
    }
}

#[test]
fn block_types_follow_the_gauges_and_place_holders() {
    // Appendix A, second table (154), (156)
    for gauges in every_combination() {
        let mut tester: Tester<Controller> = Tester::new(controller(gauges));
        tester.bring_up(&hex(HPA), &hex(CONFIGURATIONS[5].0));
        let block = |gauge: Option<OtherGauge>| if gauge == Some(OtherGauge::Cmr) { 14 } else { 13 };
        for (slot, number) in [(1, 16), (2, 16), (3, block(gauges.ch3)), (4, block(gauges.ch4))] {
            assert_eq!(tester.exchange(&[0; 8])[0], 0);
            let du = tester.exchange(&[0x10, slot, 101, 0, 0, 0, 0, 0]);
            assert_eq!(du[..8], [0x20, slot, 101, 0, 0, number, 0, 0], "{gauges:?}");
        }
    }
}
