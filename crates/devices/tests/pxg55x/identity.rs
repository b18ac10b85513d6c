//! The identity of a gauge: 7.1.1 to 7.1.9, 7.1.15, 7.1.22, chapter 5; and its station address, 3.3.

use crate::pxg55x::{Gauge, gauge, pcg, pcg_without_atm, psg, tester};
use crate::support::Tester;
use profivac_devices::model::Fault;
use profivac_devices::profile::{SerialNumber, Setup};
use profivac_devices::pxg55x::Pxg55xModel;
use profivac_devices::store::RamStore;
use profivac_devices::{Action, Potentiometer, SimulatedDevice, Switch, SwitchName, UnsupportedAction};
use profivac_dp::slave::{Device, Dpv1Error, Relation};
use profivac_wire::Sap;
use profivac_wire::acyclic::{Call, Im0, call};
use profivac_wire::address::SetSlaveAdd;

/// A visible string without its padding blanks (60).
fn text(tester: &mut Tester<Gauge>, index: u8) -> String {
    String::from_utf8(tester.get(0, index)).unwrap().trim_end().to_owned()
}

#[test]
fn the_identity_of_each_family_is_that_of_the_manual() {
    for (kind, device_type, number, configuration) in [
        // The example of 7.1.9.
        (pcg(), "CVG", "3PC1-001-3121", "DS9 SP WO ATM PB CDG AO0 PIR"),
        (pcg_without_atm(), "CVG", "3PC1-001-2121", "DS9 SP WO PB CDG AO0 PIR"),
        (psg(), "VPG", "3PI1-001-2121", "DS9 SP WO PB AO0 PIR"),
    ] {
        let mut tester = tester(kind);
        let strings = [17, 18, 19, 20, 23, 24].map(|index| text(&mut tester, index));
        assert_eq!(strings, [device_type, "E54-0997", "INFICON AG", number, "100", configuration]);
        // xxyyzz (59)
        for index in [21, 22, 202] {
            let revision = text(&mut tester, index);
            assert!(revision.len() == 6 && revision.bytes().all(|digit| digit.is_ascii_digit()), "{revision}");
        }
    }
}

/// (63): tokens, in any order.
#[test]
fn the_models_of_a_family_differ_in_part_number_and_filament() {
    let of = |name| {
        let mut tester = tester(Pxg55xModel::named(name, None).unwrap());
        (text(&mut tester, 20), text(&mut tester, 24))
    };
    // Filament digit 1, 2, 3 (61); WO and NI, a ceramic coating has no abbreviation (7.1.9).
    let pcg = ["pcg550", "pcg552", "pcg554"].map(of);
    assert_eq!(pcg.each_ref().map(|(number, _)| &number[2..4]), ["C1", "C2", "C3"]);
    let psg = ["psg550", "psg552", "psg554"].map(of);
    assert_eq!(psg.each_ref().map(|(number, _)| &number[2..4]), ["I1", "I2", "I3"]);
    for models in [pcg, psg] {
        let has = |token| models.each_ref().map(|(_, configuration)| configuration.split(' ').any(|it| it == token));
        assert_eq!((has("WO"), has("NI")), ([true, false, false], [false, true, false]));
        assert_eq!((has("PB"), has("PIR"), has("SP")), ([true; 3], [true; 3], [true; 3]));
    }
}

/// (31)
#[test]
fn a_block_type_is_a_word_and_two_zeros() {
    let mut tester = tester(pcg());
    assert_eq!(tester.get(0, 16), [0, 1, 0, 0]);
    for slot in [2, 3] {
        assert_eq!(tester.get(slot, 16), [0, 17, 0, 0]);
    }
    for slot in [4, 5] {
        // Four octets (92).
        assert_eq!(tester.get(slot, 16), [0, 7, 0, 0]);
    }
    // The selected blocks have the indices (70).
    for (instance, transducer) in [(1, [0, 14, 0, 0]), (2, [0, 13, 0, 0]), (3, [1, 0, 0, 0])] {
        assert_eq!(crate::pxg55x::of_instance(&mut tester, instance, 16), [0, 2, 0, 0]);
        assert_eq!(crate::pxg55x::of_instance(&mut tester, instance, 101), transducer, "instance {instance}");
    }
    assert_eq!(crate::pxg55x::of_instance(&mut crate::pxg55x::tester(psg()), 1, 101), [0, 13, 0, 0]);
}

/// (110)
#[test]
fn i_and_m0_has_the_fields_of_chapter_5() {
    let mut setup = Setup::new(5);
    setup.serial = SerialNumber::new("12345678901234567890");
    for kind in Pxg55xModel::all() {
        let gauge = Gauge::new(RamStore::default(), kind, setup);
        let record = gauge.im0().unwrap();
        assert_eq!((&record[..10], &record[10..12]), (&[0; 10][..], &[0x01, 0x7A][..]));
        let im0 = Im0::parse(&record).unwrap();
        assert_eq!(im0.order_id, kind.variant().number.as_bytes());
        // A string longer than the field is cut.
        assert_eq!(im0.serial_number, b"1234567890123456");
        // The revisions of the PROFIBUS board, as ID 21 and ID 22 have them.
        let mut tester = tester(kind);
        let hex_of = |text: String| u64::from_str_radix(&text, 16).unwrap();
        let [_, xx, yy, zz] = im0.software_revision.map(u64::from);
        assert_eq!((im0.software_revision[0], xx << 16 | yy << 8 | zz), (b'V', hex_of(text(&mut tester, 21))));
        assert_eq!(u64::from(im0.hardware_revision) << 8, hex_of(text(&mut tester, 22)));
        assert_eq!(record[56..], [0x5A, 0x00, 0x00, 0x00, 0x01, 0x01, 0x00, 0x00]);
    }
}

#[test]
fn i_and_m0_is_no_parameter() {
    let mut gauge = gauge(psg());
    // The slave handles the call; the device has no such index (111).
    assert_eq!(gauge.read(Relation::Ms2(0), 0, call::CALL_INDEX, &mut [0; 240]), Err(Dpv1Error::INVALID_INDEX.with(3)));
    let mut octets = [0; 240];
    let length = Call::new(call::IM0, &[]).emit(&mut octets).unwrap();
    let refused = gauge.write(Relation::Ms2(0), 0, call::CALL_INDEX, &octets[..length]);
    assert_eq!(refused, Err(Dpv1Error::INVALID_INDEX.with(3)));
}

/// 3.3: up to 7D hex the switch is the address.
#[test]
fn the_address_switch_is_readable_and_sets_the_address_at_power_up() {
    let mut tester = tester(pcg());
    assert_eq!((tester.get(0, 211), tester.device().station_address()), (vec![5], 5));
    tester.device().operate(Action::Switch(Switch::Address(125))).unwrap();
    // The parameter is the position of the switch; the address is the one read at power-up.
    assert_eq!((tester.get(0, 211), tester.device().station_address()), (vec![125], 5));
    tester.device().set_power(false);
    tester.device().set_power(true);
    assert_eq!(tester.device().station_address(), 125);
}

#[test]
fn set_slave_add_works_only_above_7d() {
    let set = |tester: &mut Tester<Gauge>, address: u8, lock: u8| {
        tester.request(Sap::SetSlaveAdd, &[address, 0x0C, 0x85, lock]);
    };
    // At or below 7D hex the service is closed and the switch sets the address (55).
    let mut tester = tester(psg());
    set(&mut tester, 9, 0);
    assert_eq!((tester.device().station_address(), tester.slave.address()), (5, 5));
    // Above it the stored address is valid, and a new one is stored.
    tester.device().operate(Action::Switch(Switch::Address(126))).unwrap();
    tester.device().set_power(false);
    tester.device().set_power(true);
    assert_eq!(tester.device().station_address(), 5);
    set(&mut tester, 9, 0);
    assert_eq!(tester.device().station_address(), 9);
    tester.device().set_power(false);
    tester.device().set_power(true);
    assert_eq!((tester.device().station_address(), tester.get(0, 211)), (9, vec![126]));
}

/// profibus-wire 2.11: an address is locked by No_Add_Chg until factory reset, which is 7.2.2, command 128.
#[test]
fn a_factory_reset_clears_no_add_chg_and_keeps_the_address() {
    let set = |tester: &mut Tester<Gauge>, address: u8| {
        // The tester sends to one address only, and the address of the gauge changes.
        let request = SetSlaveAdd { address, ident: 0x0C85, no_add_chg: 0xFF, rem_slave_data: &[] };
        tester.device().set_address(&request);
        tester.device().station_address()
    };
    let mut tester = tester(psg());
    tester.device().operate(Action::Switch(Switch::Address(126))).unwrap();
    tester.device().set_power(false);
    tester.device().set_power(true);
    tester.device().settle();
    assert_eq!((set(&mut tester, 9), set(&mut tester, 10)), (9, 9));
    // No other Reset unlocks the address.
    for command in [1, 129] {
        tester.command(command).unwrap();
        tester.device().settle();
        assert_eq!(set(&mut tester, 10), 9, "{command}");
    }
    tester.command(128).unwrap();
    tester.device().settle();
    assert_eq!(tester.device().station_address(), 9);
    // It is stored.
    tester.device().set_power(false);
    tester.device().set_power(true);
    assert_eq!((set(&mut tester, 10), set(&mut tester, 11)), (10, 10));
}

#[test]
fn a_gauge_has_two_buttons_one_switch_and_no_potentiometer() {
    let mut gauge = gauge(pcg());
    let panel = gauge.front_panel();
    assert_eq!((panel.buttons, panel.switches, panel.potentiometers), (2, &[SwitchName::Address][..], &[][..]));
    for action in [
        Action::Button(3),
        Action::Button(0),
        Action::Switch(Switch::Degas(true)),
        Action::Potentiometer { potentiometer: Potentiometer::A, volts: 1.0 },
    ] {
        assert_eq!(gauge.operate(action), Err(UnsupportedAction { action }));
    }
}

#[test]
fn a_gauge_has_the_faults_of_its_instances() {
    for (kind, instances) in [(pcg(), 3), (pcg_without_atm(), 2), (psg(), 1)] {
        let mut gauge = gauge(kind);
        let mut names = vec!["eeprom".to_owned(), "ram".into(), "eprom".into(), "comm".into()];
        for instance in 1..=instances {
            names.extend([format!("sensor{instance}"), format!("electronics{instance}")]);
        }
        assert!(gauge.faults().names().eq(names.iter().map(String::as_str)));
        for fault in Fault::ALL.iter().copied().filter(|fault| !names.iter().any(|name| name == fault.name())) {
            let action = Action::Fault { fault, active: true };
            assert_eq!(gauge.operate(action), Err(UnsupportedAction { action }));
        }
    }
}
