//! The figures that an expert would check in each plant: calculated by hand, found in the scenario, and printed with a picture in
//! docs/plants.md. `PROFIVAC_BLESS=1` writes both.

use super::hand::*;
use super::picture::{Curve, Picture, Scale};
use super::{devices, scenario};
use crate::golden;
use profivac_devices::StateReport;
use profivac_vacuum::Gas;
use profivac_virtual::scenario::{INCLUDED, Included, MasterPresence, Part, Run};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::sync::Mutex;

/// The instance of the Pirani of a PSG 550, and of the diaphragm gauge of an IMG 400.
const PIRANI: u8 = 1;
const DIAPHRAGM: u8 = 4;

/// The most points of a curve.
const POINTS: usize = 400;

/// A whole run of a scenario, at every step.
struct Recording {
    name: &'static str,
    seconds: Vec<f64>,
    /// The pressures in mbar by volume, and by volume and gas where they are watched.
    mbar: BTreeMap<String, Vec<f64>>,
    /// The state of the devices at some times.
    reports: Vec<(f64, u8, StateReport)>,
    run: Run,
    figures: Vec<Figure>,
}

/// A figure: calculated by hand, found, and the largest deviation.
struct Figure {
    what: &'static str,
    expected: f64,
    unit: &'static str,
    how: &'static str,
    found: f64,
    within: f64,
}

impl Recording {
    /// Runs the scenario of this name; every expectation of its file holds.
    fn of(name: &'static str, watched: &[(&str, Gas)], looks: &[f64]) -> Self {
        assert!(Included::named(name).is_some(), "{name} is not included");
        let scenario = scenario(name);
        let mut devices = devices(&scenario);
        let mut run = scenario.start(MasterPresence::Absent);
        let (mut seconds, mut mbar, mut reports) = (Vec::new(), BTreeMap::<String, Vec<f64>>::new(), Vec::new());
        let mut looks = looks.iter().peekable();
        while !run.is_over() {
            run.step(&mut devices);
            seconds.push(run.seconds());
            for (volume, pa) in run.pressures() {
                mbar.entry(volume.to_owned()).or_default().push(pa / 100.0);
            }
            for (volume, gas) in watched {
                let pa = run.plant().network.mixture(run.plant().volumes[*volume])[*gas];
                mbar.entry(format!("{volume} {gas}")).or_default().push(pa / 100.0);
            }
            if looks.next_if(|at| run.seconds() >= **at).is_some() {
                reports.extend(devices.iter().map(|device| (run.seconds(), device.switch_address(), device.report())));
            }
        }
        let findings: Vec<_> = run.failures().iter().map(ToString::to_string).collect();
        assert!(findings.is_empty(), "\n{}", findings.join("\n"));
        Self { name, seconds, mbar, reports, run, figures: Vec::new() }
    }

    /// The pressure of a volume at a time, in mbar.
    fn at(&self, volume: &str, seconds: f64) -> f64 {
        let next = self.seconds.partition_point(|at| *at < seconds - 1e-6).min(self.seconds.len() - 1);
        self.mbar[volume][next]
    }

    /// The time after `from` at which the pressure of a volume crosses `mbar`, in s since then.
    fn crossing(&self, volume: &str, from: f64, mbar: f64) -> f64 {
        let curve = &self.mbar[volume];
        let first = self.seconds.partition_point(|at| *at < from);
        let falls = curve[first] > mbar;
        let at = (first..curve.len()).find(|at| (curve[*at] > mbar) != falls);
        let at = at.unwrap_or_else(|| panic!("{volume} does not reach {mbar} mbar"));
        let part = (curve[at - 1] / mbar).ln() / (curve[at - 1] / curve[at]).ln();
        self.seconds[at - 1] + part * (self.seconds[at] - self.seconds[at - 1]) - from
    }

    /// The mean rise between two times, in mbar/s.
    fn rise(&self, volume: &str, from: f64, to: f64) -> f64 {
        (self.at(volume, to) - self.at(volume, from)) / (to - from)
    }

    /// The gas in a capture pump, in mbar l.
    fn captured(&self, pump: &str, gas: Gas) -> f64 {
        let Some(Part::Capture(pump)) = self.run.plant().parts.get(pump).copied() else { panic!("no pump {pump}") };
        self.run.plant().network.capture_pump(pump).captured[gas] * 10.0
    }

    /// What an instance of a device shows at the nth look, in mbar.
    fn shown(&self, look: usize, address: u8, instance: u8) -> f64 {
        let (_, _, report) = self.reports.iter().filter(|(_, at, _)| *at == address).nth(look).unwrap();
        report.indicated.iter().find(|shown| shown.instance == instance).unwrap().value_mbar
    }

    fn figure(
        &mut self,
        what: &'static str,
        expected: f64,
        unit: &'static str,
        how: &'static str,
        found: f64,
        within: f64,
    ) {
        self.figures.push(Figure { what, expected, unit, how, found, within });
    }

    /// Checks the figures, and that page and picture show them.
    fn check(self, wanted: &[&str], time: (&'static str, f64)) {
        let mut text = String::from("| Figure | Expected | Found | Deviation | By hand |\n|---|--:|--:|--:|---|\n");
        for Figure { what, expected, unit, how, found, .. } in &self.figures {
            let percent = ((found / expected - 1.0) * 100.0).round() + 0.0;
            let [expected, found] = [expected, found].map(|number| digits(*number));
            writeln!(text, "| {what} | {expected} {unit} | {found} | {percent:+.0} % | {how} |").unwrap();
        }
        println!("{}\n{text}", self.name);
        for Figure { what, expected, found, within, .. } in &self.figures {
            let deviation = found / expected - 1.0;
            assert!(deviation.abs() <= *within, "{what}: {found:e} instead of {expected:e}\n{text}");
        }
        in_page(self.name, &text);
        self.in_file();
        self.picture(wanted, time);
    }

    /// Compares the expected figures with the head of the scenario's file, or writes them there.
    fn in_file(&self) {
        let mut lines = String::from("# By hand, as docs/plants.md shows:\n");
        for Figure { what, expected, unit, .. } in &self.figures {
            let line = format!("# - {what}: {} {unit}", digits(*expected));
            writeln!(lines, "{}", line.trim_end()).unwrap();
        }
        let path = super::file(self.name);
        let file = std::fs::read_to_string(&path).unwrap();
        let (head, body) = file.split_once("title = ").unwrap();
        let head = head.split_once("# By hand").map_or(head, |(head, _)| head);
        let text = format!("{head}{lines}title = {body}");
        golden::compare(&format!("scenarios/{}.toml", self.name), &text);
    }

    fn picture(&self, wanted: &[&str], (unit, length): (&'static str, f64)) {
        let each = self.seconds.len().div_ceil(POINTS);
        let curve = |name: &&str| {
            let points = self.seconds.iter().zip(&self.mbar[*name]).step_by(each);
            let points = points.map(|(at, mbar)| (at / length, mbar.max(1e-14))).collect();
            Curve { name: (*name).to_owned(), points }
        };
        let title = Included::named(self.name).unwrap().scenario().unwrap().title;
        let picture = Picture {
            title: &title,
            x: unit,
            y: "mbar",
            curves: wanted.iter().map(curve).collect(),
            x_scale: Scale::Linear,
        };
        golden::compare(&format!("docs/curves/plants/{}.svg", self.name), &picture.svg());
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

/// The tests write and compare one page.
static PAGE: Mutex<()> = Mutex::new(());

/// Compares the table of a plant with docs/plants.md, or writes it.
fn in_page(name: &str, table: &str) {
    let _one = PAGE.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/plants.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let (from, to) = (format!("<!-- figures of {name} -->"), "<!-- end of figures -->");
    let (head, rest) = page.split_once(&from).unwrap_or_else(|| panic!("docs/plants.md has no {from}"));
    let (_, tail) = rest.split_once(to).unwrap();
    let text = format!("{head}{from}\n\n{table}\n{to}{tail}");
    golden::compare("docs/plants.md", &text);
}

/// All included scenarios are valid, and their files are all included.
#[test]
fn every_file_is_an_included_scenario() {
    for included in INCLUDED {
        included.scenario().unwrap_or_else(|error| panic!("{error}"));
    }
    let files = std::fs::read_dir(super::file("demo").parent().unwrap()).unwrap();
    let mut files: Vec<_> = files.map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    let mut names: Vec<_> = INCLUDED.iter().map(|included| format!("{}.toml", included.name)).collect();
    files.sort();
    names.sort();
    assert_eq!(files, names);
}

#[test]
fn a_load_lock() {
    let mut plant = Recording::of("load-lock", &[], &[]);
    let scroll = 15e3 / 3600.0;
    plant.figure(
        "time to 1 mbar",
        10.0 / scroll * ATMOSPHERE.ln(),
        "s",
        "V/S ln(1013), with the fore line",
        plant.crossing("lock", 10.0, 1.0),
        0.05,
    );
    let hours = 600.0 / 3600.0;
    let flows = [aged(&ALUMINIUM, 3000.0, hours), aged(&VITON, 40.0, hours)].concat();
    plant.figure(
        "lock after 10 min",
        pressure(&flows, |_| 70.0),
        "mbar",
        "q A/S of aluminium and seal",
        plant.at("lock", 610.0),
        0.1,
    );
    let hours = 890.0 / 3600.0;
    let lock: Vec<_> = [aged(&ALUMINIUM, 3000.0, hours), aged(&VITON, 40.0, hours)].concat();
    let shared: f64 =
        lock.iter().map(|(mass, flow)| row(&[of_gas(200.0, *mass)], &[*flow, 0.0], &[70.0, 300.0])[1]).sum::<f64>()
            + pressure(&aged(&STEEL, 1e4, 100.2), |mass| 300.0 + series(200.0, mass, 70.0));
    plant.figure(
        "process chamber with the slot valve open",
        shared,
        "mbar",
        "Q of the lock over two pumps with the slot between",
        plant.at("process", 899.0),
        0.1,
    );
    plant.check(&["lock", "process"], ("minutes", 60.0));
}

#[test]
fn a_beam_line_with_ion_pumps() {
    let mut plant = Recording::of("beam-line", &[], &[]);
    let tube = tube(4.0, dushman(200.0, 2.0));
    let speed = |mass: f64| match mass {
        H2 => 120.0,
        AR => 12.0,
        HE => 10.0,
        mass if (20.0..21.0).contains(&mass) => 5.0,
        _ => 60.0,
    };
    let walls = outgassing(&STEEL, 6000.0, (30.0, 423.15), 2.0);
    let sum = |index: usize, flows: &[(f64, [f64; 3])]| -> f64 {
        let of = |(mass, flows): &(f64, [f64; 3])| {
            let ends = speed(*mass);
            row(&[of_gas(tube, *mass); 2], flows, &[ends, 0.0, ends])[index]
        };
        flows.iter().map(of).sum()
    };
    let even: Vec<_> = walls.iter().map(|(mass, flow)| (*mass, [*flow; 3])).collect();
    plant.figure(
        "at the ion pumps",
        sum(0, &even),
        "mbar",
        "1.5 Q/S of baked steel, mostly hydrogen",
        plant.at("left", 7200.0),
        0.05,
    );
    plant.figure("in the middle", sum(1, &even), "mbar", "and Q/2C of the tubes", plant.at("middle", 7200.0), 0.05);
    let air = [(N2, 0.780_83), (O2, 0.209_45), (AR, 0.009_34), (20.18, 18.2e-6), (HE, 5.24e-6)];
    let leak = air.map(|(mass, part)| (mass, [0.0, 1e-7 * part * DRY * (AIR / mass).sqrt(), 0.0]));
    let water = (WATER, [0.0, 1e-7 * (1.0 - DRY) * (AIR / WATER).sqrt(), 0.0]);
    let mut all: Vec<_> =
        outgassing(&STEEL, 6000.0, (30.0, 423.15), 12.0).iter().map(|(mass, flow)| (*mass, [*flow; 3])).collect();
    all.extend(leak);
    all.push(water);
    plant.figure(
        "in the middle with the leak",
        sum(1, &all),
        "mbar",
        "Q/(2C) and Q/(2S) of each gas of the air",
        plant.at("middle", 43_190.0),
        0.05,
    );
    plant.figure(
        "nitrogen in an ion pump after ten hours",
        1e-7 * 0.780_83 * DRY * (AIR / N2).sqrt() * 36_000.0 / 2.0,
        "mbar l",
        "half of the nitrogen of the leak",
        plant.captured("left-ion", Gas::N2),
        0.05,
    );
    plant.check(&["left", "middle", "right"], ("hours", 3600.0));
}

#[test]
fn a_sputter_coater() {
    let mut plant = Recording::of("coater", &[("chamber", Gas::Ar)], &[]);
    // The pump has 60 m3/h above 20 mbar, 250 below 5, and a power of the pressure between.
    let speed = |mbar: f64| match mbar {
        mbar if mbar > 20.0 => 60.0,
        mbar if mbar > 5.0 => 250.0 * (60.0_f64 / 250.0).powf((mbar / 5.0).ln() / 4.0_f64.ln()),
        _ => 250.0,
    } / 3.6;
    let (mut mbar, mut time) = (ATMOSPHERE * 300.0 / 310.0, 0.0);
    while mbar > 1.0 {
        mbar -= mbar * speed(mbar) / 310.0 * 0.01;
        time += 0.01;
    }
    plant.figure("time to 1 mbar", time, "s", "V/S(p) dp/p, step by step", plant.crossing("chamber", 10.0, 1.0), 0.05);
    let gate = |mass: f64| series(3000.0, mass, 1000.0);
    plant.figure(
        "base pressure after 2 h",
        pressure(&aged(&STEEL, 4e4, 7190.0 / 3600.0), gate),
        "mbar",
        "q A/S of 4 m² of steel",
        plant.at("chamber", 7199.0),
        0.05,
    );
    let closed: f64 = aged(&STEEL, 4e4, 7260.0 / 3600.0).iter().map(|(_, flow)| flow).sum();
    plant.figure(
        "rate of rise",
        closed / 300.0,
        "mbar/s",
        "q A/V at the same time",
        plant.rise("chamber", 7205.0, 7320.0),
        0.05,
    );
    let argon = series(200.0, AR, 900.0);
    plant.figure(
        "argon, 100 sccm",
        sccm(100.0) / argon,
        "mbar",
        "Q/S of throttle and turbo for argon",
        plant.at("chamber ar", 9590.0),
        0.05,
    );
    plant.figure(
        "time to a hundredth without argon",
        305.0 / argon * 100.0_f64.ln(),
        "s",
        "V/S ln 100",
        plant.crossing("chamber ar", 9600.0, plant.at("chamber ar", 9599.0) / 100.0),
        0.05,
    );
    plant.check(&["chamber", "fore-line"], ("minutes", 60.0));
}

#[test]
fn the_insulating_vacuum_of_a_cryostat() {
    let mut plant = Recording::of("cryostat", &[("insulation", Gas::He)], &[]);
    let speed = |mass: f64| series(150.0, mass, 300.0);
    let hours = 24.0;
    let flows = [aged(&ALUMINIUM, 4e5, hours), aged(&STEEL, 3e4, 200.0 + hours)].concat();
    plant.figure(
        "after a day",
        pressure(&flows, speed),
        "mbar",
        "q A/S of 40 m² of foil and 3 m² of steel",
        plant.at("insulation", 86_390.0),
        0.1,
    );
    let cold = pressure(&aged(&STEEL, 3e4, 230.0), |mass| speed(mass) + if mass == WATER { 2e4 } else { 0.0 });
    plant.figure("cold", cold, "mbar", "the steel alone, without its water", plant.at("insulation", 107_990.0), 0.1);
    plant.figure(
        "helium after twelve hours",
        as_helium(3.7e-9) * 12.0 * 3600.0 / 500.0,
        "mbar",
        "Q t/V of 1e-8 mbar l/s",
        plant.at("insulation he", 151_200.0) - plant.at("insulation he", 108_000.0),
        0.05,
    );
    plant.check(&["insulation", "insulation he"], ("hours", 3600.0));
}

#[test]
fn a_bake_out() {
    let mut plant = Recording::of("bake-out", &[], &[]);
    // The gate: 100 mm wide, 70 mm long; Clausing's value for l/r = 1.4 is 0.597.
    let gate = tube(10.0, 0.597);
    let speed = |mass: f64| series(gate, mass, 300.0);
    let before = pressure(&aged(&STEEL, 15_000.0, 8.0), speed);
    plant.figure(
        "after 8 h of pumping",
        before,
        "mbar",
        "q A/S of 1.5 m² of steel",
        plant.at("chamber", 28_790.0),
        0.1,
    );
    let after = 2e-12 * 15_000.0 / speed(H2);
    plant.figure(
        "after the bake-out",
        after,
        "mbar",
        "2e-12 mbar l/(s cm²) of hydrogen after a day at 150 °C",
        plant.at("chamber", 172_790.0),
        0.1,
    );
    plant.figure(
        "gain of the bake-out",
        before / after,
        "",
        "the quotient",
        plant.at("chamber", 28_790.0) / plant.at("chamber", 172_790.0),
        0.15,
    );
    plant.check(&["chamber"], ("hours", 3600.0));
}

#[test]
fn a_leak_test_with_helium() {
    let mut plant = Recording::of("helium-leak-test", &[("vessel", Gas::He)], &[]);
    for (sprayed, off, valve, whats) in [
        (300.0, 480.0, 2.0, ["signal through the throttle", "its time constant"]),
        (720.0, 780.0, 500.0, ["signal without throttle", "its time constant"]),
    ] {
        let speed = series(valve, HE, 60.0);
        plant.figure(
            whats[0],
            as_helium(1e-6) / speed,
            "mbar",
            "Q/S of helium; Q molecular by a factor of 2.69, viscous 0.93",
            plant.at("vessel he", off - 0.2),
            0.05,
        );
        let volume = if valve < 10.0 { 50.0 } else { 51.0 };
        let rest = 1.0 - (-1.0_f64).exp();
        let base = plant.at("vessel he", sprayed - 0.1);
        let level = base + rest * (plant.at("vessel he", off - 0.2) - base);
        plant.figure(
            whats[1],
            volume / speed,
            "s",
            "V/S, from the time to 63 %",
            plant.crossing("vessel he", sprayed, level),
            0.05,
        );
    }
    plant.check(&["vessel", "vessel he"], ("minutes", 60.0));
}

#[test]
fn a_freeze_dryer() {
    let mut plant = Recording::of("freeze-dryer", &[], &[3590.0, 37_790.0]);
    let pump = 5.0 / 3.6;
    let water = |hours: f64| 3.6 / (40.0 * (1.0 - 3.6 * hours * 3600.0 / 1.353e6) + pump);
    plant.figure(
        "pressure at the condenser",
        water(1.0) + 0.9e-2,
        "mbar",
        "3.6 mbar l/s of vapour over condenser and pump, and the nitrogen of the pump",
        plant.at("condenser", 3590.0),
        0.05,
    );
    plant.figure("rise with the duct closed", 3.6 / 20.0, "mbar/s", "Q/V", plant.rise("product", 3600.2, 3601.2), 0.05);
    plant.figure("its end", 0.380, "mbar", "the vapour pressure of ice at -30 °C", plant.at("product", 3629.0), 0.02);
    let of_water = 1.0 - 0.9e-2 / plant.at("product", 3590.0);
    plant.figure(
        "Pirani : diaphragm during drying",
        2.0 * of_water + (1.0 - of_water),
        "",
        "a Pirani indicates twice the pressure of water",
        plant.shown(0, 4, PIRANI) / plant.shown(0, 7, DIAPHRAGM),
        0.25,
    );
    plant.figure(
        "the same when the product is dry",
        1.0,
        "",
        "both indicate nitrogen",
        plant.shown(1, 4, PIRANI) / plant.shown(1, 7, DIAPHRAGM),
        0.25,
    );
    plant.check(&["product", "condenser"], ("hours", 3600.0));
}

#[test]
fn a_vacuum_furnace() {
    let mut plant = Recording::of("furnace", &[], &[]);
    let speed = |mass: f64| series(20_000.0, mass, 3000.0);
    let leak = 5e-3 / speed(AIR);
    plant.figure(
        "before heating",
        pressure(&aged(&STEEL, 1e5, 2.0), speed) + leak,
        "mbar",
        "leak and q A over S",
        plant.at("furnace", 7198.0),
        0.05,
    );
    // The age of the wall for each gas while the temperature rises to 600 degrees in four hours, in steps of a second. The
    // hydrogen of a sheet of 2 mm ends after 2.06e8 s at 20 degrees.
    let mut ages = [7200.0; 5];
    let mut highest = 0.0_f64;
    for second in 0..14_400 {
        let kelvin = ROOM_K + (873.15 - ROOM_K) * f64::from(second) / 14_400.0;
        let mut mbar = leak;
        for (age, Gives(mass, q1, exponent, energy)) in ages.iter_mut().zip(STEEL) {
            let factor = faster(energy, kelvin);
            *age += factor;
            let law = (3600.0 / *age).powf(exponent);
            let supply = if mass == H2 {
                let x = *age / 2.06e8;
                let rows: f64 = [1.0, 9.0, 25.0].iter().map(|square| f64::exp(-square * x)).sum();
                if x < 0.2 { 1.0 } else { 4.0 * (x / std::f64::consts::PI).sqrt() * rows }
            } else {
                (-*age / 7e10).exp()
            };
            mbar += q1 * 1e5 * law * factor * supply / speed(mass);
        }
        highest = highest.max(mbar);
    }
    let found = (7200..22_000).step_by(10).map(|at| plant.at("furnace", f64::from(at))).fold(0.0, f64::max);
    plant.figure(
        "highest pressure while heating",
        highest,
        "mbar",
        "Arrhenius' law in steps of a second: the hydrogen of the steel",
        found,
        0.1,
    );
    plant.figure(
        "rate of rise when cold",
        5e-3 / 1000.0,
        "mbar/s",
        "leak over volume",
        plant.rise("furnace", 50_500.0, 53_900.0),
        0.05,
    );
    plant.figure(
        "time to 500 mbar of argon",
        500.0 * 1000.0 / sccm(1e5),
        "s",
        "V p/Q",
        plant.crossing("furnace", 54_000.0, 500.0),
        0.02,
    );
    plant.check(&["furnace"], ("hours", 3600.0));
}

#[test]
fn the_inlet_of_a_mass_spectrometer() {
    let mut plant = Recording::of("mass-spectrometer", &[("analyser", Gas::He)], &[]);
    let analyser = |stage: f64, mass: f64| stage * of_gas(1e-4, mass) / 70.0;
    plant.figure("first stage", 1.0 + 0.01, "mbar", "Q/S of the capillary", plant.at("stage", 599.0), 0.03);
    plant.figure(
        "analyser",
        analyser(1.0, AIR) + analyser(0.01, N2),
        "mbar",
        "C p/S of the pinhole",
        plant.at("analyser", 599.0),
        0.05,
    );
    plant.figure(
        "helium of the air in the analyser",
        analyser(5.24e-6 * DRY, HE),
        "mbar",
        "5.24 ppm, and √(28/4) through the pinhole",
        plant.at("analyser he", 599.0),
        0.05,
    );
    let argon = 18.2 / 22.3;
    plant.figure(
        "first stage with argon",
        argon + 0.01,
        "mbar",
        "the viscosities 18.2 and 22.3",
        plant.at("stage", 1199.0),
        0.03,
    );
    plant.figure(
        "analyser with argon",
        analyser(argon, AR) + analyser(0.01, N2),
        "mbar",
        "C p/S of argon",
        plant.at("analyser", 1199.0),
        0.05,
    );
    plant.check(&["stage", "analyser"], ("minutes", 60.0));
}

#[test]
fn a_transfer_line() {
    let mut plant = Recording::of("transfer-line", &[("six", Gas::He)], &[]);
    let tube = tube(6.0, dushman(500.0, 3.0));
    let walls = aged(&STEEL, 2e4, 196.0);
    let mut ends = [0.0; 2];
    for (mass, flow) in walls {
        // Water returns to the wall: A q1 3600 s / W with W = 10 mbar s.
        let back = if mass == WATER { 2e4 * 3e-9 * 3600.0 / 10.0 } else { 0.0 };
        let mut speeds = [back; 6];
        speeds[0] += series(100.0, mass, 60.0);
        let mbar = row(&[of_gas(tube, mass); 5], &[flow; 6], &speeds);
        ends[0] += mbar[0];
        ends[1] += mbar[5];
    }
    plant.figure("at the pump", ends[0], "mbar", "the sum of six walls over S", plant.at("one", 345_000.0), 0.1);
    plant.figure(
        "at the far end",
        ends[1],
        "mbar",
        "and 15 Q/C of five tubes, with the water that returns to the walls",
        plant.at("six", 345_000.0),
        0.1,
    );
    plant.figure(
        "helium after thirty days",
        as_helium(3.7e-10) * 30.0 * 86_400.0 / 120.0,
        "mbar",
        "Q t/V of 1e-9 mbar l/s",
        plant.at("six he", 34.0 * 86_400.0 - 120.0),
        0.05,
    );
    plant.check(&["one", "six", "six he"], ("days", 86_400.0));
}

/// Sealed chambers saturate: the water of the welded vessel reaches an equilibrium with its wall.
#[test]
fn sealed_storage_vessels() {
    let watched = [("sealed", Gas::He), ("sealed", Gas::N2), ("sealed", Gas::O2), ("welded", Gas::H2o)];
    let mut plant = Recording::of("storage-vessel", &watched, &[]);
    let month = 30.0 * 86_400.0;
    // 9 cm2 over 0.4 cm.
    for (what, volume, permeability, part) in [
        ("helium through the seal", "sealed he", 1e-7, 5.24e-6),
        ("nitrogen through the seal", "sealed n2", 2e-9, 0.780_83),
        ("oxygen through the seal", "sealed o2", 1e-8, 0.209_45),
    ] {
        let flow = permeability * 9.0 / 0.4 * part * DRY * ATMOSPHERE * 1e-3;
        let begin = plant.mbar[volume][0];
        plant.figure(what, flow * month / 20.0, "mbar", "K A Δp/d × t/V", plant.at(volume, month) - begin, 0.05);
    }
    // W over the age of the wall: 1000 Pa s over 100 h.
    let equilibrium = 10.0 / 360_000.0;
    for (what, seconds) in [("water in the welded vessel after a day", 86_400.0), ("the same after a month", month)] {
        plant.figure(what, equilibrium, "mbar", "equilibrium of gas and wall", plant.at("welded h2o", seconds), 0.05);
    }
    plant.check(&["sealed", "welded", "welded h2o", "sealed he"], ("days", 86_400.0));
}

#[test]
fn an_electron_microscope() {
    let mut plant = Recording::of("electron-microscope", &[], &[]);
    // Clausing's value for l/r = 4, of both apertures.
    let [upper, lower] = [0.1, 0.3].map(|diameter| tube(diameter, 0.357));
    let chamber = [aged(&STEEL, 6000.0, 11.0), aged(&VITON, 50.0, 101.0)].concat();
    let turbo = |mass: f64| series(400.0, mass, 250.0);
    let mut found = [pressure(&chamber, turbo), 0.0, 0.0];
    let gases = [WATER, N2, CO2, H2];
    for mass in gases {
        let of = |flows: &[(f64, f64)]| flows.iter().filter(|(gas, _)| *gas == mass).map(|(_, flow)| flow).sum::<f64>();
        let ion = if mass == H2 { 2.0 } else { 1.0 };
        let flows =
            [of(&outgassing(&STEEL, 1000.0, (48.0, 423.15), 1.0)), of(&aged(&STEEL, 2000.0, 1001.0)), of(&chamber)];
        let mbar = row(&[of_gas(upper, mass), of_gas(lower, mass)], &flows, &[20.0 * ion, 10.0 * ion, turbo(mass)]);
        found[1] += mbar[1];
        found[2] += mbar[0];
    }
    for (what, how, expected, volume) in [
        ("chamber", "q A/S of steel and seals", found[0], "chamber"),
        ("column", "its wall, and C p of the chamber through the aperture", found[1], "column"),
        ("gun", "its baked wall, and C p of the column", found[2], "gun"),
    ] {
        plant.figure(what, expected, "mbar", how, plant.at(volume, 3590.0), 0.1);
    }
    let hours = (5400.0 - 3720.0) / 3600.0;
    // The other gases return a hundred times slower than water.
    let mut wet = [aged(&STEEL, 6000.0, hours), aged(&VITON, 50.0, hours)].concat();
    wet.retain(|(mass, _)| *mass == WATER);
    plant.figure(
        "chamber 28 min after the exchange",
        pressure(&wet, turbo),
        "mbar",
        "the water of walls and seals that were in air",
        plant.at("chamber", 5399.0),
        0.15,
    );
    plant.check(&["gun", "column", "chamber"], ("minutes", 60.0));
}

/// The times of `profivac demo` are those of a clean chamber of 20 l with large pumps.
#[test]
fn the_demo_has_believable_times() {
    let mut plant = Recording::of("demo", &[], &[]);
    let scroll = 60.0 / 3.6;
    plant.figure(
        "time to 1 mbar",
        21.0 / scroll * (ATMOSPHERE * 20.0 / 21.0).ln(),
        "s",
        "V/S ln of chamber and fore line",
        plant.crossing("chamber", 3.0, 1.0),
        0.1,
    );
    let gate = tube(15.0, 0.69);
    let speed = |mass: f64| series(gate, mass, 500.0);
    let hours = (32.0 - 3.0) / 3600.0;
    let flows = [aged(&STEEL, 5000.0, hours), aged(&VITON, 100.0, hours)].concat();
    plant.figure(
        "nine seconds after the valve has opened",
        pressure(&flows, speed),
        "mbar",
        "q A/S of steel and seals",
        plant.at("chamber", 32.0),
        0.2,
    );
    plant.figure(
        "with the leak of 0.5 mbar l/s",
        0.5 / speed(AIR) + pressure(&aged(&STEEL, 5000.0, 66.0 / 3600.0), speed),
        "mbar",
        "Q/S",
        plant.at("chamber", 69.0),
        0.1,
    );
    plant.check(&["chamber", "throat", "fore-line"], ("seconds", 1.0));
}
