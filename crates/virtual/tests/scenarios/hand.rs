//! What an engineer calculates by hand for a plant, in mbar, l, s and cm2. Nothing here uses the crate `vacuum`.

/// 20 degrees Celsius in K, and the gas constant in J/(mol K).
pub const ROOM_K: f64 = 293.15;
pub const R: f64 = 8.314_462_6;

/// Air of 1 atm in mbar, and the part of it that is dry with 50 % relative humidity.
pub const ATMOSPHERE: f64 = 1013.25;
pub const DRY: f64 = 1.0 - 0.5 * 23.39 / ATMOSPHERE;

/// Molar masses in g/mol.
pub const N2: f64 = 28.013;
pub const AIR: f64 = 28.965;
pub const WATER: f64 = 18.015;
pub const H2: f64 = 2.016;
pub const HE: f64 = 4.0026;
pub const CO2: f64 = 44.01;
pub const AR: f64 = 39.948;
pub const O2: f64 = 31.998;

/// The mean thermal speed at 20 degrees Celsius, in m/s.
pub fn mean_speed(mass: f64) -> f64 {
    (8.0 * R * ROOM_K / (std::f64::consts::PI * mass * 1e-3)).sqrt()
}

/// A conductance for nitrogen in series with a pumping speed, for a gas, in l/s.
pub fn series(nitrogen: f64, mass: f64, speed: f64) -> f64 {
    1.0 / (1.0 / of_gas(nitrogen, mass) + 1.0 / speed)
}

/// A molecular conductance for a gas, from that for nitrogen.
pub fn of_gas(nitrogen: f64, mass: f64) -> f64 {
    nitrogen * (N2 / mass).sqrt()
}

/// A round tube for nitrogen by its transmission probability, with diameter in cm, in l/s.
pub fn tube(diameter: f64, transmission: f64) -> f64 {
    let area = std::f64::consts::PI * diameter * diameter / 4.0;
    area * mean_speed(N2) / 4.0 * 0.1 * transmission
}

/// The transmission probability of a long tube by the lengths of Dushman: 1 / (1 + 3 l / 8 r).
pub fn dushman(length: f64, radius: f64) -> f64 {
    1.0 / (1.0 + 3.0 * length / (8.0 * radius))
}

/// One gas of a material: molar mass, mbar l/(s cm2) after an hour at 20 degrees, exponent, energy in J/mol.
#[derive(Clone, Copy)]
pub struct Gives(pub f64, pub f64, pub f64, pub f64);

/// The table "Outgassing" of docs/vacuum.md.
pub const STEEL: [Gives; 5] = [
    Gives(WATER, 3e-9, 1.0, 80e3),
    Gives(N2, 2e-10, 1.0, 80e3),
    Gives(CO2, 1e-10, 1.0, 80e3),
    Gives(N2, 1e-10, 1.0, 80e3),
    Gives(H2, 2e-10, 0.5, 48e3),
];
pub const ALUMINIUM: [Gives; 3] =
    [Gives(WATER, 6e-9, 1.0, 80e3), Gives(N2, 3e-10, 1.0, 80e3), Gives(CO2, 2e-10, 1.0, 80e3)];
pub const VITON: [Gives; 3] =
    [Gives(WATER, 9.4e-7, 0.5, 60e3), Gives(N2, 1e-7, 0.5, 60e3), Gives(CO2, 1e-7, 0.5, 60e3)];

/// The Arrhenius factor of a temperature against 20 degrees Celsius.
pub fn faster(energy: f64, kelvin: f64) -> f64 {
    (energy / R * (1.0 / ROOM_K - 1.0 / kelvin)).exp()
}

/// The outgassing of an area in cm2 after hours at a temperature and further hours at 20 degrees: molar mass and mbar l/s.
pub fn outgassing(gases: &[Gives], cm2: f64, hot: (f64, f64), hours: f64) -> Vec<(f64, f64)> {
    let of = |Gives(mass, q1, exponent, energy): &Gives| {
        let age = hot.0 * faster(*energy, hot.1) + hours;
        (*mass, q1 * cm2 * age.powf(-exponent))
    };
    gases.iter().map(of).collect()
}

/// The same without a bake-out.
pub fn aged(gases: &[Gives], cm2: f64, hours: f64) -> Vec<(f64, f64)> {
    outgassing(gases, cm2, (0.0, ROOM_K), hours)
}

/// The pressure of gas flows that are pumped, in mbar. `speed` has the molar mass.
pub fn pressure(flows: &[(f64, f64)], speed: impl Fn(f64) -> f64) -> f64 {
    flows.iter().map(|(mass, flow)| flow / speed(*mass)).sum()
}

/// The pressures of volumes in a row with these conductances between them, flows into them and speeds at them.
pub fn row(conductances: &[f64], flows: &[f64], speeds: &[f64]) -> Vec<f64> {
    let count = flows.len();
    let mut mbar = vec![0.0; count];
    for _ in 0..200_000 {
        for at in 0..count {
            let (mut into, mut out) = (flows[at], speeds[at]);
            if at > 0 {
                into += conductances[at - 1] * mbar[at - 1];
                out += conductances[at - 1];
            }
            if at + 1 < count {
                into += conductances[at] * mbar[at + 1];
                out += conductances[at];
            }
            mbar[at] = into / out;
        }
    }
    mbar
}

/// A leak of dry air in mbar l/s, as helium: molecular below 1e-7, viscous above 1e-4.
pub fn as_helium(air: f64) -> f64 {
    let viscous = air / (air + 3e-6);
    air * ((1.0 - viscous) * (AIR / HE).sqrt() + viscous * 18.2 / 19.6)
}

/// 1 sccm in mbar l/s of gas at 20 degrees.
pub fn sccm(count: f64) -> f64 {
    count * ATMOSPHERE * 1e-3 / 60.0 * ROOM_K / 273.15
}
