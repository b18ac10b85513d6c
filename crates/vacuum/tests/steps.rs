//! Steps of any length give the same result, gas is conserved, and all pressures are plausible.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use profivac_vacuum::network::{Joint, Opening, Outside, Supply, TurboPump, Volume, Wall};
use profivac_vacuum::pump::{Roughing, Turbo};
use profivac_vacuum::surface::{Material, Surface};
use profivac_vacuum::{Atmosphere, Conductance, Gas, Network};

/// A chamber with a turbo, a fore line, a vent, a leak and an argon inlet.
struct Plant {
    network: Network,
    chamber: Volume,
    fore: Volume,
    gate: Joint,
    turbo: TurboPump,
    vent: Opening,
    wall: Wall,
}

impl Plant {
    fn new() -> Self {
        let air = Atmosphere::default().mixture();
        let mut network = Network::new(Atmosphere::default());
        let [chamber, throat, fore] = [0.1, 0.005, 0.003].map(|m3| network.add_volume(m3, air));
        let gate = network.add_joint(chamber, throat, Conductance::tube(0.1, 0.1));
        let through = Conductance::tube(0.025, 0.3);
        let turbo = network.add_turbo_pump(throat, fore, Turbo { standstill: through, ..Turbo::ordinary(0.3) });
        network.add_roughing_pump(fore, Roughing::dry(0.006, 1.0));
        let wall = network.add_wall(chamber, Surface::fresh(1.5, Material::named("steel").unwrap()));
        let leak = network.add_opening(chamber, Conductance::viscous(1e-11), Outside::Air);
        network.set_opening(leak, 1.0);
        let vent = network.add_opening(chamber, Conductance::tube(0.004, 0.05), Outside::Air);
        Self { network, chamber, fore, gate, turbo, vent, wall }
    }

    /// Pump-down, turbo, argon, bake-out, closed valve, vent. Returns the pressures during each phase, the last one at its end,
    /// in Pa.
    fn life(mut self, step: f64) -> Vec<[f64; 2]> {
        let mut pressures = Vec::new();
        let argon = self.network.add_inlet(self.chamber, Gas::Ar);
        for part in 0..8 {
            match part {
                1 => self.network.run_turbo(self.turbo, true),
                3 => self.network.set_inlet(argon, Supply::Flow(0.02)),
                4 => self.network.set_inlet(argon, Supply::Closed),
                5 => self.network.set_wall_temperature(self.wall, 423.0),
                6 => self.network.set_joint(self.gate, 0.0),
                7 => self.network.set_opening(self.vent, 1.0),
                _ => {}
            }
            let times = if part == 7 { [1.0, 3.0, 10.0, 20.0] } else { [10.0, 40.0, 100.0, 300.0] };
            let mut before = 0.0;
            for time in times {
                for _ in 0..((time - before) / step).round() as u32 {
                    self.network.advance(step);
                }
                before = time;
                pressures.push([self.chamber, self.fore].map(|volume| self.network.mixture(volume).total()));
            }
        }
        pressures
    }
}

#[test]
fn steps_of_ten_milliseconds_and_of_a_second_agree() {
    let [fine, middle, coarse] = [0.01, 0.1, 1.0].map(|step| Plant::new().life(step));
    for (number, ((fine, middle), coarse)) in fine.iter().zip(&middle).zip(&coarse).enumerate() {
        for index in 0..2 {
            for other in [middle[index], coarse[index]] {
                let apart = (other / fine[index] - 1.0).abs();
                assert!(apart < 5e-3, "moment {number}: {:e} and {other:e} Pa", fine[index]);
            }
        }
    }
}

#[test]
fn entered_gas_has_left_or_is_present() {
    let mut plant = Plant::new();
    plant.network.run_turbo(plant.turbo, true);
    for part in 0..4 {
        plant.network.advance(600.0);
        plant.network.set_opening(plant.vent, if part == 2 { 1.0 } else { 0.0 });
        let balance = plant.network.balance();
        for (gas, entered) in balance.entered.iter() {
            let elsewhere = balance.left[gas] + balance.present[gas];
            assert!(
                (elsewhere - entered).abs() <= 1e-9 * entered,
                "{gas}: {entered:e} entered, {elsewhere:e} left or is present"
            );
        }
    }
}

#[test]
fn the_pressures_of_each_phase_are_plausible() {
    let life = Plant::new().life(0.1);
    let ends: Vec<_> = life.chunks(4).map(|times| times[3]).collect();
    let [roughed, turbo, high_vacuum, argon, pumped, hot, closed, vented] = ends[..] else { panic!() };
    assert!(roughed[0] < 100.0, "{roughed:?}");
    assert!(turbo[0] < 1e-2 && high_vacuum[0] < turbo[0], "{turbo:?} {high_vacuum:?}");
    assert!((0.01..1.0).contains(&argon[0]), "{argon:?}");
    assert!(pumped[0] < argon[0] / 100.0, "{pumped:?}");
    assert!(hot[0] > 3.0 * pumped[0], "{hot:?}");
    assert!(closed[0] > 10.0 * hot[0], "{closed:?}");
    assert!(vented[0] > 1e3 && vented[1] < 10.0, "{vented:?}");
}

#[test]
fn every_pressure_stays_within_its_limits() {
    let air = Atmosphere { pressure_pa: 2e5, humidity: 1.0 }.mixture();
    let mut network = Network::new(Atmosphere::default());
    let full = network.add_volume(1e-6, air);
    let empty = network.add_volume(100.0, air.scaled(1e-17));
    let joint = network.add_joint(full, empty, Conductance::tube(0.2, 0.01));
    let pump = network.add_turbo_pump(empty, full, Turbo { rotor: 1.0, compression: 1e12, ..Turbo::ordinary(3.0) });
    for (step, open, running) in
        [(1e-9, 1.0, false), (1e-3, 0.5, false), (1e6, 1.0, false), (10.0, 0.0, true), (1e4, 1.0, false)]
    {
        network.set_joint(joint, open);
        network.run_turbo(pump, running);
        network.advance(step);
        for volume in [full, empty] {
            let pa = network.mixture(volume).total();
            assert!(pa.is_finite() && pa > 0.0, "{pa:e} Pa after {step} s");
        }
    }
    let balance = network.balance();
    assert!((balance.present.total() / balance.entered.total() - 1.0).abs() < 1e-9, "{balance:?}");
}
