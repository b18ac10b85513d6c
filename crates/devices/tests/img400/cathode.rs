//! Emission and degas of channels 1 (BAG) and 2 (EXT). BG 5530 4.4.4, Appendix E; errata-pxg55x-img400 116 to 118, 147
//! to 152.

use crate::img400::{COMMANDS, Controller, FLOATS, HPA, controller, every_combination, exchanging};
use crate::support::{Tester, hex};
use profivac_devices::img400::{Gauges, IonGauge};
use profivac_devices::{Action, SimulatedDevice};

const CONFLICT: u8 = 202;

fn emission(tester: &mut Tester<Controller>) -> [u8; 2] {
    [tester.get(1, 105)[0], tester.get(2, 105)[0]]
}

/// The second octet of Sensor Alarm: 0x08 overpressure, 0x10 key.
fn alarm(tester: &mut Tester<Controller>, slot: u8) -> u8 {
    tester.get(slot, 103)[1]
}

fn on(tester: &mut Tester<Controller>, slot: u8) -> Result<(), u8> {
    tester.put(slot, 14, &[3, 1])
}

#[test]
fn emission_is_off_after_power_up_and_switched_by_command_or_status() {
    let mut tester = exchanging(FLOATS, 1e-6);
    assert_eq!(emission(&mut tester), [0, 0]);
    on(&mut tester, 1).unwrap();
    assert_eq!(emission(&mut tester), [1, 0]);
    tester.put(2, 105, &[1]).unwrap();
    assert_eq!(emission(&mut tester), [1, 1]);
    tester.put(1, 105, &[0]).unwrap();
    tester.put(2, 14, &[3, 0]).unwrap();
    assert_eq!(emission(&mut tester), [0, 0]);
}

#[test]
fn a_cyclic_command_takes_effect_when_it_changes() {
    // (117)
    let mut tester = exchanging(COMMANDS, 1e-6);
    tester.exchange(&[3, 1]);
    assert_eq!(emission(&mut tester), [1, 1]);
    tester.put(1, 105, &[0]).unwrap();
    tester.exchange(&[3, 1]);
    assert_eq!(emission(&mut tester), [0, 1], "the same pair is no new command");
    tester.exchange(&[0, 0]);
    assert_eq!(emission(&mut tester), [0, 1]);
    tester.exchange(&[3, 1]);
    assert_eq!(emission(&mut tester), [1, 1]);
    tester.exchange(&[3, 0]);
    assert_eq!(emission(&mut tester), [0, 0]);
    // Clear is no command.
    tester.exchange(&[3, 1]);
    tester.request_sdn(&[0x02, 0x00]);
    assert_eq!(emission(&mut tester), [1, 1]);
}

#[test]
fn a_cyclic_command_has_no_effect_on_an_empty_channel() {
    // (116)
    let mut tester: Tester<Controller> =
        Tester::new(controller(Gauges { ch1: None, ch2: Some(IonGauge::Bag), ..Gauges::default() }));
    tester.pressure_mbar(1e-6);
    tester.bring_up(&hex(HPA), &hex(COMMANDS));
    tester.exchange(&[3, 1]);
    assert_eq!(emission(&mut tester), [0, 1]);
    assert_eq!(on(&mut tester, 1), Err(CONFLICT));
    assert_eq!(tester.put(1, 105, &[1]), Err(CONFLICT));
    assert_eq!(tester.put(1, 105, &[0]), Ok(()));
}

#[test]
fn degas_starts_below_the_limit_of_the_gauge_and_ends_after_three_minutes() {
    // 4.4.4, (151): BAG 1e-4 hPa, EXT 1e-5 hPa
    for (slot, limit) in [(1, 1e-4), (2, 1e-5)] {
        let mut tester = exchanging(FLOATS, limit * 0.9);
        assert_eq!(tester.put(slot, 14, &[1, 1]), Err(CONFLICT), "without emission");
        on(&mut tester, slot).unwrap();
        tester.pressure_mbar(limit * 1.1);
        assert_eq!(tester.put(slot, 14, &[1, 1]), Err(CONFLICT), "{limit} hPa");
        assert_eq!(tester.get(slot, 104), [0, 0x08], "pressure too high for degas");
        tester.pressure_mbar(limit * 0.9);
        assert_eq!(tester.get(slot, 104), [0, 0]);
        tester.put(slot, 14, &[1, 1]).unwrap();
        assert_eq!(tester.get(slot, 110), [1]);
        assert_eq!(tester.get(3 - slot, 110), [0], "the other channel");
        tester.device().advance(179.0);
        assert_eq!(tester.get(slot, 110), [1]);
        tester.device().advance(2.0);
        assert_eq!(tester.get(slot, 110), [0]);
        assert_eq!(tester.get(slot, 105), [1], "emission stays on");
        for stop in [[1, 0], [3, 0]] {
            on(&mut tester, slot).unwrap();
            tester.put(slot, 14, &[1, 1]).unwrap();
            tester.put(slot, 14, &stop).unwrap();
            assert_eq!(tester.get(slot, 110), [0], "{stop:?}");
        }
    }
}

#[test]
fn a_refused_cyclic_command_has_no_effect_and_no_answer() {
    // (118)
    let mut tester = exchanging(COMMANDS, 1e-3);
    tester.exchange(&[3, 1]);
    tester.pressure_mbar(1e-3);
    let before = tester.exchange(&[0, 0]);
    assert_eq!(tester.exchange(&[1, 1]), before);
    assert_eq!(tester.exchange(&[77, 9]), before);
    assert_eq!([tester.get(1, 110), tester.get(2, 110)], [[0], [0]]);
}

#[test]
fn overpressure_switches_the_emission_off_until_it_is_acknowledged() {
    // 4.4.4 (table 5), (152): three ways
    for acknowledge in [(1, 14, &[4u8, 1][..]), (0, 205, &[0x20]), (0, 205, &[0x80])] {
        let mut tester = exchanging(FLOATS, 1e-6);
        on(&mut tester, 1).unwrap();
        on(&mut tester, 2).unwrap();
        // Above the limit of the extractor gauge, within the range of the other.
        tester.pressure_mbar(1e-3);
        assert_eq!(emission(&mut tester), [1, 0]);
        assert_eq!([alarm(&mut tester, 1), alarm(&mut tester, 2)], [0, 0x08]);
        tester.pressure_mbar(1.0);
        assert_eq!(emission(&mut tester), [0, 0]);
        assert_eq!([alarm(&mut tester, 1), alarm(&mut tester, 2)], [0x08, 0x08]);
        // Sensor alarms: bit 1.
        assert_eq!(tester.get(0, 26), [0xA2]);
        tester.pressure_mbar(1e-6);
        assert_eq!(emission(&mut tester), [0, 0], "it stays off");
        assert_eq!(on(&mut tester, 1), Err(CONFLICT));
        assert_eq!(tester.put(1, 14, &[4, 0]), Ok(()), "no action");
        assert_eq!(alarm(&mut tester, 1), 0x08);
        let (slot, index, octets) = acknowledge;
        tester.put(slot, index, octets).unwrap();
        assert_eq!(alarm(&mut tester, 1), 0);
        assert_eq!(emission(&mut tester), [0, 0], "and does not come back by itself");
        on(&mut tester, 1).unwrap();
        assert_eq!(emission(&mut tester), [1, 0]);
    }
}

#[test]
fn the_overpressure_fault_switches_off_the_emission_that_is_on() {
    let mut tester = exchanging(FLOATS, 1e-6);
    on(&mut tester, 1).unwrap();
    tester.fault("overpressure", true);
    assert_eq!(emission(&mut tester), [0, 0]);
    assert_eq!([alarm(&mut tester, 1), alarm(&mut tester, 2)], [0x08, 0]);
    tester.put(0, 205, &[0x20]).unwrap();
    on(&mut tester, 1).unwrap();
    assert_eq!(emission(&mut tester), [0, 0], "at once off again");
    assert_eq!(alarm(&mut tester, 1), 0x08);
    tester.fault("overpressure", false);
    assert_eq!(alarm(&mut tester, 1), 0x08, "until acknowledged");
}

#[test]
fn the_key_switches_the_emission_off_and_can_be_locked() {
    // 4.4.4 (table 5, 3), 4.4.1 (ID 203), (129)
    let mut tester = exchanging(FLOATS, 1e-6);
    let press = |tester: &mut Tester<Controller>, channel| tester.device().operate(Action::Button(channel)).unwrap();
    for (lock, locked) in [(0, false), (1, false), (2, true), (3, true)] {
        tester.put(0, 203, &[lock]).unwrap();
        press(&mut tester, 1);
        assert_eq!(emission(&mut tester)[0] == 0, locked, "key lock {lock}");
        // The key lock does not lock the bus.
        on(&mut tester, 1).unwrap();
        press(&mut tester, 1);
        assert_eq!(emission(&mut tester), [0, 0]);
        assert_eq!(alarm(&mut tester, 1), 0x10, "environment failure");
        press(&mut tester, 1);
        assert_eq!(emission(&mut tester), [0, 0], "not before it is acknowledged");
        tester.put(1, 14, &[4, 1]).unwrap();
        assert_eq!(alarm(&mut tester, 1), 0);
    }
    assert!(tester.device().operate(Action::Button(3)).is_err());
}

#[test]
fn a_gauge_that_is_unplugged_goes_off() {
    let mut tester = exchanging(FLOATS, 1e-6);
    on(&mut tester, 2).unwrap();
    tester.fault("unplugged2", true);
    assert_eq!(emission(&mut tester), [0, 0]);
    assert_eq!(tester.get(2, 102), [1]);
    assert_eq!(on(&mut tester, 2), Err(CONFLICT));
    tester.fault("unplugged2", false);
    assert_eq!(emission(&mut tester), [0, 0]);
    on(&mut tester, 2).unwrap();
    assert_eq!(tester.get(2, 102), [0]);
}

/// The position in the list is that of the channel, with any gauge.
#[test]
fn the_report_has_an_entry_for_each_of_the_two_channels() {
    for gauges in every_combination() {
        let mut tester = Tester::new(controller(gauges));
        tester.pressure_mbar(1e-6);
        tester.bring_up(&hex(HPA), &hex(COMMANDS));
        tester.exchange(&[3, 1]);
        let fitted = [gauges.ch1.is_some(), gauges.ch2.is_some()];
        assert_eq!([1, 2].map(|slot| tester.get(slot, 105) == [1]), fitted);
        assert!(tester.report().emission.iter().eq(&fitted), "{gauges:?}: {:?}", tester.report());
        tester.exchange(&[0, 0]);
        tester.exchange(&[1, 1]);
        assert!(tester.report().degas.iter().eq(&[1, 2].map(|slot| tester.get(slot, 110) == [1])), "{gauges:?}");
    }
}
