//! TTR compatibility mode: 3.8, 4.4.1, (49), (50).

use crate::pxg55x::{FLOATS, Gauge, MBAR, TTR, float, of_instance, pcg, psg, tester};
use crate::support::{Tester, hex};
use profivac_devices::pxg55x::Pxg55xModel;

fn in_ttr_mode(kind: Pxg55xModel, mbar: f64) -> Tester<Gauge> {
    let mut tester = tester(kind);
    tester.pressure_mbar(mbar);
    tester.bring_up(&hex(TTR), &hex("A1 91"));
    tester
}

/// The pressure of the 12 bits by the three printed formulas: mbar, Torr, Pa.
fn decode(octets: &[u8]) -> [f64; 3] {
    let value = f64::from(u16::from_be_bytes([octets[0] & 0x0F, octets[1]]));
    [4.778, 4.9029, 2.778].map(|offset| 10f64.powf(value / 482.0 - offset))
}

/// (48)
#[test]
fn the_twelve_bits_are_the_pressure_by_all_three_formulas() {
    for kind in [pcg(), psg()] {
        for mbar in [5e-5, 1e-3, 0.5, 9.5, 100.0, 1000.0] {
            let octets = in_ttr_mode(kind, mbar).exchange(&[0, 0]);
            for (found, expected) in decode(&octets).into_iter().zip([mbar, mbar / 1.333_223_69, mbar * 100.0]) {
                // One step is 0.48 %, the offset of the Torr formula is rounded.
                assert!((found / expected - 1.0).abs() < 0.003, "{mbar} mbar: {found} instead of {expected}");
            }
        }
    }
}

/// Bit 7: error; bit 6: trip point 1; bits 5 and 4: 0.
#[test]
fn every_range_status_sets_its_bits() {
    let mut tester = in_ttr_mode(psg(), 100.0);
    let status = |tester: &mut Tester<Gauge>| tester.exchange(&[0, 0])[0] & 0xF0;
    assert_eq!(status(&mut tester), 0x00);
    // Low trip point 1 at 200 mbar; trip point 2 does not matter. Pressures are still in mbar.
    tester.put(3, 19, &200f32.to_be_bytes()).unwrap();
    assert_eq!((status(&mut tester), tester.get(3, 21)), (0x00, vec![1]));
    tester.put(2, 19, &200f32.to_be_bytes()).unwrap();
    assert_eq!(status(&mut tester), 0x40);
    for fault in ["ram", "comm", "sensor1"] {
        tester.fault(fault, true);
        assert_eq!(status(&mut tester) & 0x80, 0x80, "{fault}");
        tester.fault(fault, false);
        assert_eq!(status(&mut tester), 0x40, "{fault} gone");
    }
    // A warning is no error.
    tester.pressure_mbar(1300.0);
    assert_eq!((status(&mut tester), tester.get(0, 26)), (0x00, vec![0xA0]));
}

#[test]
fn pressures_beyond_twelve_bits_saturate() {
    assert_eq!(in_ttr_mode(psg(), 1e-7).exchange(&[0, 0]), [0x40, 0x00]);
    // 4095 is 5280 mbar.
    assert_eq!(in_ttr_mode(psg(), 6000.0).exchange(&[0, 0]), [0x0F, 0xFF]);
}

#[test]
fn unit_and_data_type_keep_their_values() {
    let mut tester = tester(psg());
    tester.pressure_mbar(100.0);
    tester.put(1, 22, &hex("13 09")).unwrap();
    tester.put(1, 21, &[3]).unwrap();
    tester.bring_up(&hex(TTR), &hex("A1 91"));
    assert_eq!((tester.get(1, 22), tester.get(1, 21), tester.get(1, 19)), (hex("13 09"), vec![3], hex("27 10")));
    assert_eq!(decode(&tester.exchange(&[1, 2]))[0].round(), 100.0);
    // The mode is that of this parameterisation.
    tester.unlock();
    tester.bring_up(&hex(MBAR), &hex(FLOATS));
    assert_eq!((of_instance(&mut tester, 1, 22), float(&mut tester, 1, 19)), (hex("13 08"), 100.0));
    tester.set_prm(&hex(MBAR));
    tester.chk_cfg(&hex("A1 91"));
    assert!(!tester.is_exchanging());
}

/// The mode belongs to the parameterisation: a factory reset does not change it.
#[test]
fn a_factory_reset_keeps_ttr_compatibility_mode() {
    let mut tester = in_ttr_mode(psg(), 100.0);
    tester.command(128).unwrap();
    tester.chk_cfg(&hex("A1 91"));
    assert!(tester.is_exchanging());
}
