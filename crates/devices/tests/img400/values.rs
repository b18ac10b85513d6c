//! Units, types, limits and adjustment. BG 5530 4.4.2; errata-pxg55x-img400 14 to 18, 32, 130 to 136, 143.

use crate::img400::{CHANNEL, Controller, FLOATS, HPA, controller, exchanging, float, put_float, tester};
use crate::support::{Tester, hex};
use profivac_devices::img400::{Gauges, IonGauge, OtherGauge};

const INTEGERS: &str = "45 88 05 03 03 03 03";

/// Two octets.
fn word(tester: &mut Tester<Controller>, slot: u8, index: u8) -> u16 {
    u16::from_be_bytes(tester.get(slot, index).try_into().unwrap())
}

#[test]
fn counts_are_an_unsigned_word_truncated_and_saturated() {
    // (15, 17, 134): 4000 x (log10 p + 12.5)
    let mut tester = tester();
    tester.bring_up(&hex("00 00 00 10 01"), &hex(INTEGERS));
    for (hpa, counts) in [
        (1000.0, 62_000),
        (1.0, 50_000),
        (4.9e-5, 32_760),
        (1.5, 50_704),
        (1e4, 65_535),
        (1e-12, 2_000),
        (1e-13, 0),
        (0.0, 0),
    ] {
        tester.pressure_mbar(hpa);
        assert_eq!(word(&mut tester, 4, 19), counts, "{hpa} hPa");
        assert_eq!(tester.exchange(&[])[7..9], counts.to_be_bytes(), "{hpa} hPa");
    }
}

#[test]
fn counts_as_floats_are_not_rounded() {
    // (18)
    let mut tester = tester();
    tester.bring_up(&hex("00 00 00 10 01"), &hex(FLOATS));
    tester.pressure_mbar(2.0);
    assert!((float(&mut tester, 4, 19) - 51_204.12).abs() < 0.01);
}

#[test]
fn limits_are_those_of_the_gauge_in_every_unit() {
    // (133): full scale and overrange, underrange, in hPa
    let bag = (1e-2, 1e-10);
    let ext = (1e-4, 1e-12);
    let tpr = (1000.0, 8e-4);
    let cmr = (1000.0, 0.1);
    for (unit, factor) in [("13 01", 0.750_061_68), ("13 02", 750.061_68), ("13 08", 1.0), ("13 09", 100.0)] {
        let others = Gauges {
            ch1: Some(IonGauge::Ext),
            ch2: Some(IonGauge::Bag),
            ch3: Some(OtherGauge::Cmr),
            ch4: Some(OtherGauge::Tpr),
        };
        for (gauges, limits) in [(Gauges::default(), [bag, ext, tpr, cmr]), (others, [ext, bag, cmr, tpr])] {
            let mut tester: Tester<Controller> = Tester::new(controller(gauges));
            tester.bring_up(&hex(&format!("00 00 00 {unit}")), &hex(FLOATS));
            for (slot, (over, under)) in (1..).zip(limits) {
                for (index, limit) in [(24, over), (44, over), (45, under)] {
                    let value = f64::from(float(&mut tester, slot, index));
                    assert!((value / (limit * factor) - 1.0).abs() < 1e-6, "{slot}/{index} is {value}");
                }
            }
        }
    }
}

#[test]
fn all_channels_share_the_data_type_which_is_fixed_during_exchange() {
    let mut tester = tester();
    tester.put(2, 21, &[3]).unwrap();
    for slot in 1..=4 {
        assert_eq!(tester.get(slot, 21), [3]);
    }
    // The configuration overrides it (4.4.2).
    tester.bring_up(&hex(HPA), &hex(FLOATS));
    assert_eq!(tester.get(1, 21), [8]);
    assert_eq!(tester.put(1, 21, &[3]), Err(17));
    tester.unlock();
    tester.bring_up(&hex(HPA), &hex(INTEGERS));
    assert_eq!(tester.get(4, 21), [3]);
}

#[test]
fn only_the_user_parameters_change_the_unit() {
    // (143)
    let mut tester = tester();
    assert_eq!(tester.get(1, 22), [0x13, 0x08], "from the factory");
    assert_eq!(tester.put(1, 22, &[0x13, 0x01]), Err(1));
    tester.set_prm(&hex("00 00 00 13 02"));
    for slot in 1..=4 {
        assert_eq!(tester.get(slot, 22), [0x13, 0x02]);
    }
    // A string that is refused changes nothing (40).
    tester.set_prm(&hex("00 00 00 13 03"));
    assert_eq!(tester.get(1, 22), [0x13, 0x02]);
}

#[test]
fn a_safe_value_keeps_its_pressure_and_zero_is_zero_in_every_unit() {
    // 4.4.2 (ID 40), (32)
    let mut tester = exchanging(FLOATS, 1.0);
    put_float(&mut tester, 1, 40, 2.0).unwrap();
    put_float(&mut tester, 2, 40, 0.0).unwrap();
    for (unit, value) in
        [("13 01", 1.500_123_4), ("13 02", 1_500.123_4), ("13 09", 200.0), ("10 01", 51_204.12), ("13 08", 2.0f32)]
    {
        tester.unlock();
        tester.bring_up(&hex(&format!("00 00 00 {unit}")), &hex(FLOATS));
        assert!((float(&mut tester, 1, 40) / value - 1.0).abs() < 1e-6, "{unit}");
        assert_eq!(float(&mut tester, 2, 40), 0.0, "{unit}");
    }
}

#[test]
fn a_zero_adjust_works_on_diaphragm_and_ionisation_gauges() {
    // (131)
    let mut tester = exchanging(CHANNEL, 0.5);
    let adjust = |tester: &mut Tester<Controller>, slot, target| tester.put(slot, 15, &[0, target]);
    // The diaphragm gauge on channel 4 has both adjustments.
    adjust(&mut tester, 4, 1).unwrap();
    assert_eq!(float(&mut tester, 4, 19), 0.0);
    tester.pressure_mbar(10.5);
    assert!((float(&mut tester, 4, 19) - 10.0).abs() < 1e-4);
    adjust(&mut tester, 4, 0).unwrap();
    assert_eq!(float(&mut tester, 4, 19), 10.5);
    // A Pirani gauge has none.
    assert_eq!(adjust(&mut tester, 3, 0), Err(202));
    assert_eq!(adjust(&mut tester, 3, 1), Err(202));
    // An ionisation gauge has the zero adjust; without emission the offset stays.
    tester.pressure_mbar(1e-6);
    assert_eq!(adjust(&mut tester, 1, 0), Err(202), "without emission");
    adjust(&mut tester, 1, 1).unwrap();
    tester.put(1, 105, &[1]).unwrap();
    assert!((float(&mut tester, 1, 19) / 1e-6 - 1.0).abs() < 1e-5);
    assert_eq!(adjust(&mut tester, 1, 0), Err(202));
    adjust(&mut tester, 1, 1).unwrap();
    tester.pressure_mbar(3e-6);
    assert!((float(&mut tester, 1, 19) / 2e-6 - 1.0).abs() < 1e-5);
    // No such command or target.
    assert_eq!(tester.put(4, 15, &[1, 1]), Err(2));
    assert_eq!(tester.put(4, 15, &[0, 2]), Err(2));
    assert_eq!(tester.get(4, 15), [0, 0]);
}

#[test]
fn emission_current_is_a_float_that_holds_a_code() {
    // (147)
    let mut tester = exchanging(FLOATS, 1.0);
    for code in 0..=6 {
        put_float(&mut tester, 1, 107, code as f32).unwrap();
        assert_eq!(float(&mut tester, 1, 107), code as f32);
    }
    for wrong in [0.1, 1.6, 7.0, 10.0, 45.0, 90.0, -1.0] {
        assert_eq!(put_float(&mut tester, 1, 107, wrong), Err(2), "{wrong}");
    }
    assert_eq!(float(&mut tester, 2, 107), 0.0, "each channel its own");
}
