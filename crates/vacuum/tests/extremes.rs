//! Plants of extreme sizes: pressures stay finite and positive, and gas is conserved.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use profivac_vacuum::network::{Outside, Supply};
use profivac_vacuum::pump::{Roughing, Turbo};
use profivac_vacuum::surface::{Material, Surface};
use profivac_vacuum::{Atmosphere, Conductance, Gas, Mixture, Network};

/// Calculates some steps of a plant with a chamber, a throat and a fore line of these volumes in m³, tubes of this diameter in m,
/// pumps of this speed in m³/s, a vent and a regulated inlet.
fn calculate(volumes: [f64; 3], width: f64, speed: f64, step: f64, steps: u32) {
    // A tube is not wider than its volumes.
    let width = volumes.iter().fold(width, |width, m3| width.min(m3.cbrt()));
    let air = Atmosphere::default().mixture();
    let mut plant = Network::new(Atmosphere::default());
    let [chamber, throat, fore] = volumes.map(|m3| plant.add_volume(m3, air));
    let gate = plant.add_joint(chamber, throat, Conductance::tube(width, width));
    let turbo = plant.add_turbo_pump(
        throat,
        fore,
        Turbo { standstill: Conductance::tube(width, width), ..Turbo::ordinary(speed) },
    );
    plant.add_roughing_pump(fore, Roughing::dry(speed, 1.0));
    let area = 6.0 * volumes[0].powf(2.0 / 3.0);
    plant.add_wall(chamber, Surface::fresh(area, Material::named("steel").unwrap()));
    let vent = plant.add_opening(chamber, Conductance::tube(width, width), Outside::Gas(Mixture::pure(Gas::N2, 1.1e5)));
    let inlet = plant.add_inlet(chamber, Gas::Ar);
    for number in 0..steps {
        match number % 6 {
            1 => plant.run_turbo(turbo, true),
            2 => plant.set_inlet(inlet, Supply::Pressure { pa: 1.0, max_flow: 0.36 }),
            3 => plant.set_inlet(inlet, Supply::Closed),
            4 => plant.set_opening(vent, 1.0),
            5 => {
                plant.set_opening(vent, 0.0);
                plant.set_joint(gate, if number % 4 == 1 { 0.0 } else { 1.0 });
            }
            _ => {}
        }
        plant.advance(step);
        for volume in [chamber, throat, fore] {
            let pa = plant.mixture(volume).total();
            assert!(
                pa.is_finite() && pa > 0.0 && pa < 2e5,
                "{pa:e} Pa after step {number}: {volumes:?} {width} {speed}"
            );
        }
    }
    let balance = plant.balance();
    for (gas, entered) in balance.entered.iter() {
        let elsewhere = balance.left[gas] + balance.present[gas];
        assert!(
            (elsewhere - entered).abs() <= 1e-8 * entered,
            "{gas}: {entered:e} entered, {elsewhere:e} left or is present: {volumes:?} {width} {speed}"
        );
    }
}

#[test]
fn a_plant_of_any_size_is_calculated_with_steps_of_any_length() {
    for volumes in [[1e-9, 1e-9, 1e-9], [1e-9, 1.0, 1e-9], [1e4, 1e-6, 1e-9], [1e4, 1e4, 1e4]] {
        for width in [1e-4, 0.1, 5.0] {
            for speed in [1e-9, 0.3, 1000.0] {
                for step in [1e-3, 1.0, 1e4] {
                    // A volume of 1 mm³ that takes a day to empty needs short steps.
                    let slow = speed < volumes[0] * 1e3 && step > 1.0;
                    calculate(volumes, width, speed, if slow { 100.0 } else { step }, 6);
                }
            }
        }
    }
}
