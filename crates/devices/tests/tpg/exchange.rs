//! TPG300 and TPG500 in cyclic exchange: every configuration of modules, every board combination, the status of every
//! channel. IF300P/IF301P manual 3.2.1.2, 3.2.2, 3.2.4.1.

use crate::support::{Tester, hex};
use crate::tpg::{COLD, Controller, PIRANI, controller};
use profivac_devices::model::Fault;
use profivac_devices::profile::Setup;
use profivac_devices::store::RamStore;
use profivac_devices::tpg::{Tpg, TpgGauge, table};
use profivac_devices::{Action, SimulatedDevice};

/// errata-bpg-bcg-tpg 122 and 125: configuration, inputs. The outputs are always nine octets.
const CONFIGURATIONS: [(&str, usize); 9] = [
    ("97 A7 A0", 8),
    ("97 A7 94 A0", 13),
    ("97 A7 94 94 A0", 18),
    ("97 A7 94 94 94 A0", 23),
    ("97 A7 94 94 94 94 A0", 28),
    ("97 A7 93 A0", 12),
    ("97 A7 93 93 A0", 16),
    ("97 A7 93 93 93 A0", 20),
    ("97 A7 93 93 93 93 A0", 24),
];

fn tester(boards: [Option<TpgGauge>; 4]) -> Tester<Controller> {
    Tester::new(controller(boards))
}

/// Nine octets of outputs: no instruction, and this Sensor On_Off.
fn outputs(sensor_on_off: u8) -> [u8; 9] {
    [0, 0, 0, 0, 0, 0, 0, 0, sensor_on_off]
}

#[test]
fn every_configuration_has_its_lengths_and_the_value_of_every_channel() {
    for (cfg, inputs) in CONFIGURATIONS {
        let mut tester = tester([PIRANI, PIRANI, PIRANI, PIRANI]);
        tester.pressure_mbar(8.3e-3);
        tester.device().settle();
        tester.bring_up(&[], &hex(cfg));
        let du = tester.exchange(&outputs(0));
        assert_eq!(du.len(), inputs, "{cfg}");
        assert_eq!(du[..8], [0; 8], "{cfg}");
        // 8.3E-3 as a float, and as 830 x 10^-5 (errata-bpg-bcg-tpg 126); status 0
        let channel = if cfg.contains("94") { hex("3C 07 FC B9 00") } else { hex("03 3E FB 00") };
        assert!(du[8..].chunks(channel.len()).all(|octets| octets == channel), "{cfg}: {du:02X?}");
    }
}

#[test]
fn every_other_string_of_modules_is_refused() {
    let known: Vec<Vec<u8>> = CONFIGURATIONS.iter().map(|(cfg, _)| hex(cfg)).collect();
    let others = [
        "",
        "97",
        "97 A7",
        "97 A0",
        "A7 A0",
        "94 A0",
        "A7 97 A0",
        "97 A7 A0 94",
        "97 A7 94",
        "97 A7 94 94 94 94 94 A0",
        // one format per configuration: errata-bpg-bcg-tpg 123
        "97 A7 94 93 A0",
        "97 A7 93 93 93 94 A0",
        "97 A7 A0 00",
    ];
    let changed = known.iter().flat_map(|cfg| {
        (0..cfg.len()).flat_map(move |position| {
            (0..=255u8).map(move |octet| {
                let mut other = cfg.clone();
                other[position] = octet;
                other
            })
        })
    });
    for cfg in others.iter().map(|cfg| hex(cfg)).chain(changed) {
        let mut tester = tester([PIRANI; 4]);
        tester.set_prm(&[]);
        tester.chk_cfg(&cfg);
        assert_eq!(tester.is_exchanging(), known.contains(&cfg), "{cfg:02X?}");
        // Cfg_Fault
        assert_eq!(tester.diag()[0] & 0x04 != 0, !known.contains(&cfg), "{cfg:02X?}");
    }
}

#[test]
fn user_parameters_are_empty_or_three_zeros() {
    // errata-bpg-bcg-tpg 151
    for (user, accepted) in [
        ("", true),
        ("00 00 00", true),
        ("00", false),
        ("00 00", false),
        ("80 00 00", false),
        ("00 00 01", false),
        ("00 00 00 00", false),
        ("00 00 00 05 1C", false),
    ] {
        let mut tester = tester([PIRANI; 4]);
        tester.set_prm(&hex(user));
        assert_eq!(tester.diag()[0] & 0x40 == 0, accepted, "{user}");
    }
}

#[test]
fn ident_and_first_configuration_are_those_of_the_manual() {
    let mut tester: Tester<Controller> =
        Tester::new(Tpg::new(&table::TPG300, RamStore::default(), Setup::new(5), [PIRANI; 4]));
    let (_, diag) = tester.request(profivac_wire::Sap::SlaveDiag, &[]).unwrap();
    assert_eq!(diag[4..], [0x05, 0xD9]);
    let (_, cfg) = tester.request(profivac_wire::Sap::GetCfg, &[]).unwrap();
    assert_eq!(cfg, hex("97 A7 94 94 94 94 A0"));
}

/// Status of A1, A2, B1, B2 in a configuration of four floats.
fn statuses(du: &[u8]) -> [u8; 4] {
    [du[12], du[17], du[22], du[27]]
}

#[test]
fn every_board_combination_shows_its_channels_and_no_hardware() {
    let choices = [None, PIRANI, COLD];
    for number in 0..81 {
        let gauges = [0, 1, 2, 3].map(|channel| choices[number / 3usize.pow(channel) % 3]);
        let mut tester = tester(gauges);
        tester.bring_up(&[], &hex("97 A7 94 94 94 94 A0"));
        // All gauges are switched on at a pressure that is too low for a Pirani gauge.
        tester.pressure_mbar(1e-5);
        tester.device().settle();
        let du = tester.exchange(&outputs(0xFF));
        let expected = gauges.map(|gauge| match gauge {
            None => 5,
            Some(TpgGauge::Pirani) => 1,
            Some(TpgGauge::ColdCathode) => 0,
        });
        assert_eq!(statuses(&du), expected, "{gauges:?}");
        assert_eq!(tester.device().parts().len(), gauges.iter().flatten().count());
    }
}

#[test]
fn the_status_follows_pressure_switch_and_faults() {
    let mut tester = tester([PIRANI, PIRANI, COLD, COLD]);
    tester.bring_up(&[], &hex("97 A7 94 94 94 94 A0"));
    // B1 and B2 on, the Pirani gauges unchanged.
    for (mbar, expected) in [
        (1013.0, [2, 2, 2, 2]),
        (1000.0, [0, 0, 2, 2]),
        (1.0, [0, 0, 2, 2]),
        (5e-3, [0, 0, 0, 0]),
        (1e-4, [1, 1, 0, 0]),
        (1e-11, [1, 1, 1, 1]),
    ] {
        tester.pressure_mbar(mbar);
        tester.device().settle();
        assert_eq!(statuses(&tester.exchange(&outputs(0xF0))), expected, "{mbar} mbar");
    }
    tester.pressure_mbar(5e-3);
    tester.device().settle();
    assert_eq!(statuses(&tester.exchange(&outputs(0x54))), [0, 4, 4, 4]);
    // 5 is a channel without a board (124), and an unplugged gauge does not remove the board.
    let faults = [Fault::Sensor1, Fault::Electronics2, Fault::Unplugged3, Fault::Sensor4];
    for (channel, fault) in faults.into_iter().enumerate() {
        tester.exchange(&outputs(0));
        tester.exchange(&outputs(0xFF));
        tester.device().operate(Action::Fault { fault, active: true }).unwrap();
        let du = tester.exchange(&outputs(0xFF));
        assert_eq!(statuses(&du)[channel], 3, "{fault:?}");
        // errata-bpg-bcg-tpg 154
        assert_eq!(du[8 + 5 * channel..12 + 5 * channel], [0; 4], "{fault:?}");
        tester.device().operate(Action::Fault { fault, active: false }).unwrap();
        assert_eq!(statuses(&tester.exchange(&outputs(0xFF))), [0; 4], "{fault:?}");
    }
    tester.device().operate(Action::Fault { fault: Fault::Comm, active: true }).unwrap();
    // errata-bpg-bcg-tpg 156
    assert_eq!(statuses(&tester.exchange(&outputs(0xFF))), [3; 4]);
}

#[test]
fn measured_values_are_renewed_every_100_ms() {
    // IF300P/IF301P manual 3.2.1.1
    let mut tester = tester([PIRANI; 4]);
    tester.bring_up(&[], &hex("97 A7 94 A0"));
    let value = |tester: &mut Tester<Controller>| {
        let du = tester.exchange(&outputs(0));
        f32::from_be_bytes([du[8], du[9], du[10], du[11]])
    };
    tester.pressure_mbar(1.0);
    tester.device().settle();
    assert_eq!(value(&mut tester), 1.0);
    tester.pressure_mbar(100.0);
    tester.device().advance(0.09);
    assert_eq!(value(&mut tester), 1.0);
    tester.device().advance(0.02);
    let first = value(&mut tester);
    assert!(first > 1.0 && first < 100.0, "{first} mbar");
    tester.device().advance(60.0);
    assert!((value(&mut tester) / 100.0 - 1.0).abs() < 1e-3);
}
