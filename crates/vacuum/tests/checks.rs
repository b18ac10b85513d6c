//! The laws compared with values of the literature, as a table in docs/vacuum.md. `PROFIVAC_BLESS=1` writes it.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use crate::golden;
use profivac_vacuum::atmosphere::{ROOM_K, STANDARD_PA, WATER_SATURATED_PA};
use profivac_vacuum::conductance::{
    Bulk, SHARP_DISCHARGE, choked_factor, discharge, long_tube_factor, mean_speed_m_per_s, transmission,
};
use profivac_vacuum::network::Outside;
use profivac_vacuum::pump::{Capture, Roughing, flow_of_sccm, sccm_of_flow};
use profivac_vacuum::surface::{Material, Surface, hydrogen_diffusion_m2_per_s};
use profivac_vacuum::{Atmosphere, Conductance, Gas, Mixture, Network};
use std::f64::consts::PI;
use std::fmt::Write;
use std::path::Path;

const FROM: &str = "<!-- checks: printed by crates/vacuum/tests/checks.rs -->";
const TO: &str = "<!-- end of checks -->";

/// One check: what, the expected value with its source, the found value, and the largest deviation.
struct Check {
    what: String,
    expected: f64,
    unit: &'static str,
    source: &'static str,
    found: f64,
    within: f64,
}

#[derive(Default)]
struct Table(Vec<Check>);

impl Table {
    fn add(
        &mut self,
        what: impl Into<String>,
        expected: f64,
        unit: &'static str,
        source: &'static str,
        found: f64,
        within: f64,
    ) {
        self.0.push(Check { what: what.into(), expected, unit, source, found, within });
    }

    fn text(&self) -> String {
        let mut text = String::from("| Check | Expected | Found | Deviation | Source |\n|---|--:|--:|--:|---|\n");
        for Check { what, expected, unit, source, found, .. } in &self.0 {
            // Without a negative zero.
            let percent = ((found / expected - 1.0) * 1000.0).round() / 10.0 + 0.0;
            let [expected, found] = [expected, found].map(|number| digits(*number));
            writeln!(
                text,
                "| {what} | {} | {found} | {percent:+.1} % | {source} |",
                format!("{expected} {unit}").trim_end()
            )
            .unwrap();
        }
        text
    }
}

/// A number with three digits.
fn digits(number: f64) -> String {
    if (0.01..10_000.0).contains(&number.abs()) {
        let places = (2 - number.abs().log10().floor() as i32).clamp(0, 4);
        format!("{number:.0$}", places as usize)
    } else {
        format!("{number:.2e}")
    }
}

fn bulk(gas: Gas, pa: f64) -> Bulk {
    Bulk::of_mixture(&Mixture::pure(gas, pa))
}

/// The conductance for a pure gas, in m³/s.
fn conductance(of: &Conductance, gas: Gas, high_pa: f64, low_pa: f64) -> f64 {
    let (molecular, viscous) = of.parts(&bulk(gas, high_pa), &bulk(gas, low_pa));
    molecular * mean_speed_m_per_s(gas) / mean_speed_m_per_s(Gas::N2) + viscous
}

/// The share of molecules that pass a tube of radius 1, traced with diffuse reflection.
fn traced(length: f64) -> f64 {
    let mut random = fastrand::Rng::with_seed(5);
    let molecules = 200_000;
    let passed = (0..molecules).filter(|_| {
        let radius = random.f64().sqrt();
        let (mut x, mut y, mut z) = (radius, 0.0, 0.0);
        let mut normal = [0.0, 0.0, 1.0];
        loop {
            // The cosine law about the normal.
            let (sine, turn) = (random.f64().sqrt(), 2.0 * PI * random.f64());
            let cosine = (1.0 - sine * sine).sqrt();
            let side = if normal[2] > 0.5 { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] };
            let other = [
                normal[1] * side[2] - normal[2] * side[1],
                normal[2] * side[0] - normal[0] * side[2],
                normal[0] * side[1] - normal[1] * side[0],
            ];
            let way: Vec<f64> = (0..3)
                .map(|axis| cosine * normal[axis] + sine * (turn.cos() * side[axis] + turn.sin() * other[axis]))
                .collect();
            let a = way[0] * way[0] + way[1] * way[1];
            let b = x * way[0] + y * way[1];
            let far = (-b + (b * b - a * (x * x + y * y - 1.0)).max(0.0).sqrt()) / a;
            (x, y, z) = (x + far * way[0], y + far * way[1], z + far * way[2]);
            if z < 0.0 || z > length {
                return z > length;
            }
            normal = [-x, -y, 0.0];
        }
    });
    passed.count() as f64 / f64::from(molecules)
}

/// Flows into vacuum relative to A v/4, by the simulation of colliding molecules in `tests/collisions`: gas (argon for hard spheres),
/// length by radius, δ, W. Their standard deviations are in docs/vacuum.md.
const COLLIDING: [(Gas, f64, f64, f64); 25] = [
    (Gas::N2, 0.0, 1.0, 1.128),
    (Gas::N2, 0.0, 3.0, 1.287),
    (Gas::N2, 0.0, 10.0, 1.437),
    (Gas::N2, 0.0, 30.0, 1.493),
    (Gas::N2, 0.0, 100.0, 1.476),
    (Gas::N2, 0.2, 10.0, 1.329),
    (Gas::N2, 1.0, 0.3, 0.702),
    (Gas::N2, 1.0, 1.0, 0.755),
    (Gas::N2, 1.0, 3.0, 0.872),
    (Gas::N2, 1.0, 10.0, 1.044),
    (Gas::N2, 1.0, 30.0, 1.187),
    (Gas::N2, 1.0, 100.0, 1.293),
    (Gas::N2, 2.0, 10.0, 0.846),
    (Gas::N2, 2.0, 30.0, 1.038),
    (Gas::N2, 5.0, 1.0, 0.333),
    (Gas::N2, 5.0, 3.0, 0.388),
    (Gas::N2, 5.0, 10.0, 0.542),
    (Gas::N2, 5.0, 30.0, 0.771),
    (Gas::N2, 5.0, 100.0, 1.005),
    (Gas::N2, 10.0, 1.0, 0.202),
    (Gas::N2, 10.0, 10.0, 0.332),
    (Gas::N2, 10.0, 30.0, 0.551),
    (Gas::Ar, 0.0, 10.0, 1.462),
    (Gas::Ar, 1.0, 3.0, 0.871),
    (Gas::Ar, 1.0, 10.0, 1.059),
];

/// Flows of nitrogen into a gas behind the tube, by the same simulation: length by radius, δ before the tube, the quotient of the
/// pressures, W.
const COLLIDING_BETWEEN: [(f64, f64, f64, f64); 19] = [
    (0.0, 1.0, 0.5, 0.624),
    (0.0, 3.0, 0.5, 0.824),
    (0.0, 3.0, 0.8, 0.374),
    (0.0, 10.0, 0.5, 1.196),
    (0.0, 10.0, 0.8, 0.692),
    (0.0, 30.0, 0.5, 1.307),
    (0.5, 10.0, 0.8, 0.554),
    (1.0, 1.0, 0.5, 0.418),
    (1.0, 1.0, 0.8, 0.172),
    (1.0, 3.0, 0.5, 0.539),
    (1.0, 3.0, 0.8, 0.240),
    (1.0, 10.0, 0.5, 0.855),
    (1.0, 10.0, 0.8, 0.457),
    (1.0, 30.0, 0.5, 1.107),
    (2.0, 3.0, 0.5, 0.396),
    (2.0, 10.0, 0.5, 0.663),
    (5.0, 3.0, 0.5, 0.221),
    (5.0, 10.0, 0.5, 0.381),
    (5.0, 10.0, 0.8, 0.178),
];

/// The flow through a tube with sharp edges into vacuum, relative to its molecular flow through an opening.
fn into_vacuum(gas: Gas, length: f64, delta: f64) -> f64 {
    between(gas, length, delta, 0.0)
}

/// The same into a gas of a part of the pressure.
fn between(gas: Gas, length: f64, delta: f64, behind: f64) -> f64 {
    let radius = 0.05;
    let tube = Conductance::tube_with_discharge(2.0 * radius, length * radius, SHARP_DISCHARGE);
    let speed = (2.0 * 8.314_463 * ROOM_K / gas.molar_mass_kg_per_mol()).sqrt();
    let pa = delta * gas.viscosity_pa_s() * speed / radius;
    conductance(&tube, gas, pa, behind * pa) * (1.0 - behind) / (PI * radius * radius * mean_speed_m_per_s(gas) / 4.0)
}

fn openings(table: &mut Table) {
    let clausing = "Clausing 1932";
    for (l, expected) in [(1.0, 0.672), (2.0, 0.514), (4.0, 0.357), (10.0, 0.191), (20.0, 0.109)] {
        table.add(format!("short tube, l/r = {l}, W"), expected, "", clausing, transmission(l), 0.005);
    }
    for l in [1.0, 5.0] {
        let found = transmission(l);
        table.add(
            format!("short tube, l/r = {l}, W"),
            traced(l),
            "",
            "200 000 molecules traced in the test",
            found,
            0.01,
        );
    }
    let kinetic = "kinetic theory (BGK), source 3";
    for (delta, expected) in [(0.01, 1.4768), (0.02, 1.4608), (0.04, 1.4391), (0.08, 1.4131)] {
        table.add(format!("long tube, δ = {delta}, G"), expected, "", kinetic, 1.5045 * long_tube_factor(delta), 0.01);
    }
    for (delta, expected) in [(1.0, 0.97), (10.0, 2.37)] {
        let what = format!("long tube, δ = {delta}, G(δ)/G(0)");
        table.add(what, expected, "", "Sharipov and Seleznev 1998, not reached again", long_tube_factor(delta), 0.03);
    }
    let slip = 1000.0 / 4.0 + 1.018;
    table.add(
        "long tube, δ = 1000, G",
        slip,
        "",
        "Poiseuille with slip, δ/4 + 1.018",
        1.5045 * long_tube_factor(1000.0),
        0.01,
    );
    let area = PI * 0.05 * 0.05;
    let hole = Conductance::tube(0.1, 0.0);
    table.add(
        "choked opening, air",
        200.0,
        "m/s",
        "20 l/(s cm²), general knowledge",
        conductance(&hole, Gas::Air, 1e5, 1.0) / area,
        0.03,
    );
    // Kn = sqrt(pi) / (2 δ) with the radius.
    let pa = 18.2e-6 * (2.0 * 8.314_463 * ROOM_K / 28.965e-3).sqrt() / 0.05 * PI.sqrt() / 2.0 / 7.0;
    let found = conductance(&hole, Gas::Air, pa, 0.0) / area;
    table.add("thin opening at Kn = 7, air", 117.0, "m/s", "A v/4, and 1 % more in the transition", found, 0.03);
    for delta in [0.1, 1.0, 3.0, 10.0, 30.0, 100.0_f64] {
        let found = into_vacuum(Gas::N2, 0.0, delta);
        let rise = (0.4733 + 0.6005 / delta.sqrt()) / (1.0 + 4.559 / delta + 3.094 / (delta * delta));
        table.add(
            format!("thin sharp opening into vacuum, δ = {delta}, W"),
            1.0 + rise,
            "",
            "source 16, formula from memory",
            found,
            0.03,
        );
    }
    for (gas, length, delta, expected) in COLLIDING {
        let name = if gas == Gas::Ar { "argon" } else { "nitrogen" };
        let what = format!("{name} through a sharp tube into vacuum, l/r = {length}, δ = {delta}, W");
        table.add(what, expected, "", "colliding molecules, see below", into_vacuum(gas, length, delta), 0.03);
    }
    for (length, delta, behind, expected) in COLLIDING_BETWEEN {
        let what =
            format!("nitrogen through a sharp tube into {behind} of the pressure, l/r = {length}, δ = {delta}, W");
        table.add(what, expected, "", "colliding molecules, see below", between(Gas::N2, length, delta, behind), 0.04);
    }
    let isentropic = |ratio: f64| {
        let kappa = 1.4_f64;
        let flow = ratio.powf(2.0 / kappa) - ratio.powf((kappa + 1.0) / kappa);
        (2.0 * kappa / (kappa - 1.0) * flow).sqrt() / choked_factor(kappa)
    };
    for ratio in [0.6, 0.8, 0.95] {
        let what = format!("discharge function, ratio {ratio}");
        table.add(what, isentropic(ratio), "", "isentropic nozzle", discharge(ratio, 1.4), 0.01);
    }
}

/// The time in s to vent 100 l through 6 mm x 50 mm to 99 %, with a discharge coefficient.
fn vent_s(discharge: f64) -> f64 {
    let air = Atmosphere { humidity: 0.0, ..Atmosphere::default() };
    let mut plant = Network::new(air);
    let chamber = plant.add_volume(0.1, air.mixture().scaled(1e-6));
    let vent = plant.add_opening(chamber, Conductance::tube_with_discharge(0.006, 0.05, discharge), Outside::Air);
    plant.set_opening(vent, 1.0);
    let mut seconds = 0.0;
    while plant.mixture(chamber).total() < 0.99 * STANDARD_PA {
        plant.advance(0.05);
        seconds += 0.05;
    }
    seconds
}

/// The same by integrating the discharge function.
fn isentropic_vent_s() -> f64 {
    let speed = choked_factor(1.4) * (8.314_463 * ROOM_K / 28.965e-3_f64).sqrt() * PI * 0.003 * 0.003;
    let steps = 100_000;
    let part = 0.99 / f64::from(steps);
    (0..steps).map(|step| part / discharge((f64::from(step) + 0.5) * part, 1.4)).sum::<f64>() * 0.1 / speed
}

fn gases(table: &mut Table) {
    table.add(
        "vent of 100 l, 6 mm x 50 mm, to 99 %",
        isentropic_vent_s(),
        "s",
        "isentropic, discharge coefficient 1",
        vent_s(1.0),
        0.03,
    );
    table.add(
        "the same with sharp edges",
        isentropic_vent_s() / 0.8,
        "s",
        "isentropic, discharge coefficient 0.8",
        vent_s(0.8),
        0.03,
    );
    let ratio = |flow: f64| {
        let leak = Conductance::leak(flow);
        conductance(&leak, Gas::He, STANDARD_PA, 1e-4) / conductance(&leak, Gas::Air, STANDARD_PA, 1e-4)
    };
    table.add("leak 1e-9 mbar l/s, He : air", 2.69, "", "roots of the masses", ratio(1e-10), 0.01);
    table.add("leak 1e-2 mbar l/s, He : air", 0.93, "", "viscosities of source 4", ratio(1e-3), 0.01);
    let tube = Conductance::tube(0.01, 5.0);
    let laminar = PI * 1e-8 / (128.0 * 8.8e-6 * 5.0) * 1500.0;
    table.add(
        "laminar flow of H2",
        laminar,
        "m³/s",
        "Poiseuille, viscosity of source 4",
        conductance(&tube, Gas::H2, 2000.0, 1000.0),
        0.05,
    );
    table.add("1 Pa m³/s at 20 °C", 551.8, "sccm", "definition: 0 °C, 1013.25 mbar", sccm_of_flow(1.0, ROOM_K), 0.001);
    table.add("100 sccm", 0.1812, "Pa m³/s", "the same", flow_of_sccm(100.0), 0.001);
}

fn steel(area: f64) -> Surface {
    Surface::fresh(area, Material::named("steel").unwrap())
}

/// A sealed chamber of 100 l with 1.5 m² of steel after ten hours of pumping: pressures in Pa after some days.
fn sealed(days: &[f64]) -> Vec<[f64; 2]> {
    let mut plant = Network::new(Atmosphere::default());
    let chamber = plant.add_volume(0.1, Mixture::pure(Gas::N2, 1e-5));
    plant.add_wall(chamber, steel(1.5).aged(36_000.0, ROOM_K));
    let mut before = 0.0;
    days.iter()
        .map(|day| {
            let steps = ((day - before) * 86_400.0 / 600.0).round() as u32;
            (0..steps).for_each(|_| plant.advance(600.0));
            before = *day;
            let gas = plant.mixture(chamber);
            [gas[Gas::H2o], gas.total()]
        })
        .collect()
}

fn walls(table: &mut Table) {
    // 1e-10 mbar l/s per cm² is 1e-7 Pa m/s.
    let rate = |wall: Surface, gas: Gas| wall.flow()[gas] * 1e-3;
    table.add(
        "steel, water after 10 h",
        3.0e-10,
        "mbar l/(s cm²)",
        "3e-9 after 1 h, 1/t",
        rate(steel(1.0).aged(36_000.0, ROOM_K), Gas::H2o),
        0.03,
    );
    let baked = steel(1.0).aged(86_400.0, 423.15);
    table.add(
        "steel, H2 after 24 h at 150 °C",
        2.0e-12,
        "mbar l/(s cm²)",
        "1.3e-12 after 100 °C to 2.7e-12 after 250 °C (sources 9, 10)",
        rate(baked, Gas::H2),
        0.35,
    );
    let viton = Surface::fresh(1.0, Material::named("viton").unwrap()).aged(3600.0, ROOM_K);
    table.add("Viton after 1 h", 1.14e-6, "mbar l/(s cm²)", "source 11", viton.flow().total() * 1e-3, 0.03);
    let diffusion = 7.01e-7 * (-48.0e3 / (8.314_463 * 423.15_f64)).exp();
    table.add(
        "diffusion of H2 in steel at 150 °C",
        diffusion,
        "m²/s",
        "source 8",
        hydrogen_diffusion_m2_per_s(423.15),
        0.001,
    );
    let [day, ten, sixty] = sealed(&[1.0, 10.0, 60.0])[..] else { panic!() };
    // W / age with all of the wall's own law: V p = A q1 1 h ln(age / 10 h).
    let equilibrium = equilibrium_pa();
    table.add(
        "sealed steel chamber, water after 10 days",
        equilibrium,
        "Pa",
        "equilibrium of gas and wall",
        ten[0],
        0.05,
    );
    table.add("the same after 60 days", ten[0], "Pa", "the value after 10 days", sixty[0], 0.05);
    assert!(day[0] < ten[0] * 1.1 && sixty[1] < WATER_SATURATED_PA, "{day:?} {ten:?} {sixty:?}");
}

/// The pressure at which `p = W / age` and `V p = A q1 1 h ln(age / 10 h)`.
fn equilibrium_pa() -> f64 {
    let (mut low, mut high) = (36_000.0, 1e9);
    for _ in 0..100 {
        let age = f64::sqrt(low * high);
        let pa = profivac_vacuum::surface::WETTING_PA_S / age;
        if 0.1 * pa > 1.5 * 3e-6 * 3600.0 * (age / 36_000.0_f64).ln() { low = age } else { high = age }
    }
    profivac_vacuum::surface::WETTING_PA_S / low
}

fn pumps(table: &mut Table) {
    let chamber = |m3: f64, gas: Mixture| {
        let mut plant = Network::new(Atmosphere::default());
        let volume = plant.add_volume(m3, gas);
        (plant, volume)
    };
    let (mut plant, volume) = chamber(0.01, Mixture::pure(Gas::N2, 1e-5));
    plant.set_gauge_speed(volume, 1e-4);
    plant.advance(100.0);
    let found = 100.0 / (1e-5 / plant.mixture(volume).total()).ln();
    table.add("gauge of 0.1 l/s at 10 l, time constant", 100.0, "s", "V/S, source 12", found, 0.01);
    let (mut plant, volume) = chamber(0.1, Mixture::pure(Gas::N2, 1e-3));
    let capture = Capture {
        speeds: Mixture::pure(Gas::N2, 0.1),
        capacities: Mixture::pure(Gas::N2, 1e-2),
        highest_pa: 1.0,
        running: true,
        captured: Mixture::default(),
    };
    let pump = plant.add_capture_pump(volume, capture);
    let leak = plant.add_opening(volume, Conductance::leak(1e-5), Outside::Gas(Mixture::pure(Gas::N2, STANDARD_PA)));
    plant.set_opening(leak, 1.0);
    plant.advance(2000.0);
    let balance = plant.balance();
    let gone = balance.entered[Gas::N2] - balance.present[Gas::N2];
    table.add("gas in a capture pump", gone, "Pa m³", "gas balance", plant.capture_pump(pump).captured[Gas::N2], 0.02);
    let (mut plant, volume) = chamber(0.1, Mixture::pure(Gas::He, 1.0));
    plant.add_roughing_pump(volume, Roughing::dry(0.01, 0.0));
    plant.advance(10.0);
    table.add(
        "helium signal, time constant V/S",
        10.0,
        "s",
        "V/S, source 6",
        -10.0 / plant.mixture(volume)[Gas::He].ln(),
        0.01,
    );
}

#[test]
fn the_laws_agree_with_the_literature_as_printed_in_the_docs() {
    let mut table = Table::default();
    openings(&mut table);
    gases(&mut table);
    walls(&mut table);
    pumps(&mut table);
    for Check { what, expected, found, within, .. } in &table.0 {
        assert!((found / expected - 1.0).abs() <= *within, "{what}: {found:e} instead of {expected:e}");
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/vacuum.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let (head, rest) = page.split_once(FROM).unwrap();
    let (_, tail) = rest.split_once(TO).unwrap();
    let text = format!("{head}{FROM}\n\n{}\n{TO}{tail}", table.text());
    golden::compare("docs/vacuum.md", &text);
}
