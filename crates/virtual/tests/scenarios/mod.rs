//! Runs the shipped scenarios as fast as possible: every expectation of the files is met.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

mod curves;
mod finite;
mod hand;
mod picture;
mod plants;
mod wrong;

use profivac_dp::link::Baud;
use profivac_virtual::device::VirtualDevice;
use profivac_virtual::device_spec::SpecError;
use profivac_virtual::nonvolatile::NonvolatileMemory;
use profivac_virtual::scenario::{MasterPresence, Run, Scenario};
use std::path::{Path, PathBuf};

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../scenarios/{name}.toml"))
}

fn scenario(name: &str) -> Scenario {
    Scenario::read(&file(name)).unwrap_or_else(|error| panic!("{error}"))
}

fn devices(scenario: &Scenario) -> Vec<VirtualDevice> {
    scenario.devices::<SpecError>(Baud::B1500000, |_| Ok(NonvolatileMemory::volatile())).unwrap()
}

/// Runs a whole scenario without a bus and calls `look` at a fixed interval.
fn run(name: &str, every_s: f64, mut look: impl FnMut(&Run, &[VirtualDevice])) -> Run {
    let scenario = scenario(name);
    let mut devices = devices(&scenario);
    let mut run = scenario.start(MasterPresence::Absent);
    let mut next = 0.0;
    while !run.is_over() {
        run.step(&mut devices);
        if run.seconds() >= next {
            look(&run, &devices);
            next += every_s;
        }
    }
    run
}

fn holds(name: &str) {
    let run = run(name, f64::INFINITY, |_, _| {});
    let findings: Vec<_> = run.failures().iter().map(ToString::to_string).collect();
    assert!(findings.is_empty(), "\n{}", findings.join("\n"));
}

#[test]
fn a_clean_chamber_is_pumped_down() {
    holds("pump-down");
}

#[test]
fn a_leak_holds_the_pressure_and_lets_it_rise_in_a_straight_line() {
    holds("leak");
}

#[test]
fn a_vent_switches_the_emission_off_and_wets_the_wall() {
    holds("vent");
}

#[test]
fn argon_is_shown_by_the_factors_of_the_manuals() {
    holds("argon");
}

#[test]
fn degas_is_refused_then_runs_and_ends() {
    holds("degas");
}

#[test]
fn a_broken_filament_is_reported_until_it_is_replaced() {
    holds("filament");
}

/// Address, instance and the bits of the shown value, for all devices.
type Shown = Vec<(u8, u8, u64)>;

/// The bits of all shown values, noise included.
fn shown<'d>(devices: impl Iterator<Item = &'d VirtualDevice>) -> Shown {
    let shown = devices.flat_map(|device| {
        let report = device.report();
        let values: Vec<_> = report.indicated.iter().map(|it| (it.instance, it.value_mbar.to_bits())).collect();
        values.into_iter().map(|(instance, value)| (device.switch_address(), instance, value))
    });
    shown.collect()
}

/// Runs on a segment in memory in steps of `piece_s` seconds; records the shown values every ten seconds.
fn on_a_bus(name: &str, baud: Baud, piece_s: f64) -> (Run, Vec<Shown>) {
    let scenario = scenario(name);
    let mut segment = scenario.memory_segment(1, baud).unwrap();
    let mut run = scenario.start(MasterPresence::Present);
    let mut trajectory = Vec::new();
    let mut served = 0.0;
    while !run.is_over() {
        served += piece_s;
        let until = served.min((trajectory.len() + 1) as f64 * 10.0);
        run.step_segment(&mut segment, until + 1e-6);
        if until < served {
            trajectory.push(shown(segment.devices()));
        }
    }
    (run, trajectory)
}

#[test]
fn a_master_finds_devices_again_after_unplugging_and_power_loss() {
    let (run, _) = on_a_bus("bus", Baud::B187500, 1.0);
    let findings: Vec<_> = run.failures().iter().map(ToString::to_string).collect();
    assert!(findings.is_empty(), "\n{}", findings.join("\n"));
}

#[test]
fn the_trajectory_does_not_depend_on_the_speed_of_the_run() {
    let (_, slow) = on_a_bus("bus", Baud::B187500, 0.0371);
    let (_, fast) = on_a_bus("bus", Baud::B187500, 3.0);
    assert!(slow.len() >= 5 && slow.iter().all(|shown| shown.len() >= 5), "{slow:?}");
    assert_eq!(slow, fast);
}

/// Only for devices that measure as soon as they have power: the times of a master's requests depend on the rate.
#[test]
fn the_trajectory_is_the_same_at_any_rate_and_without_a_bus() {
    let pcg = |trajectory: Vec<Shown>| -> Vec<Shown> {
        let of_pcg = |shown: Shown| shown.into_iter().filter(|(address, ..)| *address == 3).collect();
        trajectory.into_iter().map(of_pcg).collect()
    };
    let [slow, fast] = [Baud::B19200, Baud::B93750].map(|baud| pcg(on_a_bus("bus", baud, 10.0).1));
    let mut alone = Vec::new();
    run("bus", 10.0, |run, devices| {
        if run.seconds() > 1.0 {
            alone.push(shown(devices.iter()));
        }
    });
    assert_eq!(slow, fast);
    let alone = pcg(alone);
    assert!(alone.len() >= 5 && alone.iter().zip(&slow).all(|(alone, bus)| alone == bus), "{alone:?}\n{slow:?}");
}

#[test]
fn a_failed_expectation_is_reported_with_its_line() {
    let text = std::fs::read_to_string(file("filament")).unwrap();
    let text = text
        .replace("above", "below")
        .replace("below = \"1e-7 mbar\", valid = true, fault = false, emission = true", "above = \"1 mbar\"");
    let scenario = Scenario::parse(&text, "x.toml").unwrap();
    let mut devices = devices(&scenario);
    let mut run = scenario.start(MasterPresence::Absent);
    while run.seconds() < 301.0 {
        run.step(&mut devices);
    }
    let told = run.failures().first().unwrap().to_string();
    assert!(told.starts_with("x.toml:32: after 300 s: expected bpg400@5 to show above 1.000e0 mbar, got "), "{told}");
}

/// A plant with a leak of 1e-6 mbar l/s: helium on it raises the flow, and a heated wall follows its ramp.
#[test]
fn helium_on_a_leak_and_a_ramp_of_temperature_are_steps_of_a_timeline() {
    let text = r#"
title = "t"
until = "30 min"
step = "1 s"
[volumes]
chamber = { volume = "10 l", gas = "n2", pressure = "1e-6 mbar" }
[walls]
wall = { in = "chamber", material = "glass", area = "1 cm2", aged = "1000 h" }
[roughing-pumps]
pump = { at = "chamber", speed = "10 l/s", ultimate = "1e-12 mbar", running = true }
[leaks]
leak = { at = "chamber", rate = "1e-6 mbar l/s", open = true }
[[timeline]]
at = "10 min"
expect = [{ volume = "chamber", near = "1.0e-7 mbar", within = "5 %" }]
spray = [{ leak = "leak", gas = "he" }]
heat = [{ wall = "wall", to = "100 C", over = "10 min" }]
[[timeline]]
at = "15 min"
# Three quarters of the leak are molecular: 0.77 x 2.69 + 0.23 x 0.93.
expect = [{ volume = "chamber", near = "2.3e-7 mbar", within = "5 %" }]
spray = [{ leak = "leak", gas = "air" }]
"#;
    let scenario = Scenario::parse(text, "x.toml").unwrap();
    let mut run = scenario.start(MasterPresence::Absent);
    let mut devices = devices(&scenario);
    while run.seconds() < 905.0 {
        run.step(&mut devices);
    }
    let findings: Vec<_> = run.failures().iter().map(ToString::to_string).collect();
    assert!(findings.is_empty(), "{}", findings.join("\n"));
    let warm = run.states().into_iter().find(|(name, _)| *name == "wall").unwrap().1;
    assert_eq!(warm.to_string(), "61 C", "half of the way after five minutes and six seconds");
    while !run.is_over() {
        run.step(&mut devices);
    }
    let (_, pa) = run.pressures().next().unwrap();
    assert!((pa / 1.0e-5 - 1.0).abs() < 0.05, "air again: {pa:e} Pa");
}

/// Of two closed glass bulbs of nitrogen, the one with a burning hot cathode is pumped by it.
#[test]
fn a_hot_cathode_pumps_the_volume_to_which_it_belongs() {
    let text = r#"
title = "t"
until = "1 h"
step = "1 s"
[volumes]
with = { volume = "1 l", gas = "n2", pressure = "1e-5 mbar" }
without = { volume = "1 l", gas = "n2", pressure = "1e-5 mbar" }
[gauges]
"bpg400@5" = "with"
[[timeline]]
at = "1 h"
expect = [{ volume = "with", below = "2e-6 mbar" }, { volume = "without", near = "1e-5 mbar", within = "1 %" }]
"#;
    let scenario = Scenario::parse(text, "x.toml").unwrap();
    let mut run = scenario.start(MasterPresence::Absent);
    let mut devices = devices(&scenario);
    while !run.is_over() {
        run.step(&mut devices);
    }
    let findings: Vec<_> = run.failures().iter().map(ToString::to_string).collect();
    assert!(findings.is_empty(), "{}", findings.join("\n"));
}

/// Helium through a seal, and a capture pump that is emptied.
#[test]
fn gas_permeates_through_a_seal_and_a_capture_pump_is_regenerated() {
    let text = r#"
title = "t"
until = "2 h"
step = "1 s"
[volumes]
bulb = { volume = "1 l", gas = "n2", pressure = "1e-9 mbar" }
beam = { volume = "10 l", gas = "n2", pressure = "1e-7 mbar" }
[seals]
lid = { in = "bulb", area = "10 cm2", thickness = "5 mm", permeabilities = { n2 = "1e-11 m2/s" } }
[capture-pumps]
getter = { at = "beam", speeds = { n2 = "10 l/s" }, capacities = { n2 = "1e-3 mbar l" }, highest-pressure = "1e-4 mbar", running = true }
[inlets]
nitrogen = { at = "beam", gas = "n2" }
[[timeline]]
at = "1 s"
flow = [{ inlet = "nitrogen", flow = "1e-6 mbar l/s" }]
[[timeline]]
at = "1000 s"
# 1e-11 x 1e-3 / 5e-3 m3/s from 781.9 mbar into 1 l; the getter has used two thirds of its capacity.
expect = [{ volume = "bulb", near = "1.564e-3 mbar", within = "2 %" }, { volume = "beam", above = "2e-7 mbar" }]
regenerate = ["getter"]
[[timeline]]
at = "1010 s"
expect = [{ volume = "beam", near = "1e-7 mbar", within = "10 %" }]
"#;
    let scenario = Scenario::parse(text, "x.toml").unwrap();
    let mut run = scenario.start(MasterPresence::Absent);
    while run.seconds() < 1012.0 {
        run.step(&mut []);
    }
    let findings: Vec<_> = run.failures().iter().map(ToString::to_string).collect();
    assert!(findings.is_empty(), "{}", findings.join("\n"));
    let wrong = text.replace("1e-11 m2/s", "1e-11 m3/s");
    let error = Scenario::parse(&wrong, "x.toml").unwrap_err().to_string();
    assert!(error.contains("n2: expected a permeability like \"1e-11 m2/s\" in cm2/s, m2/s, got"), "{error}");
    let wrong = text.replace("regenerate = [\"getter\"]", "regenerate = [\"lid\"]");
    let error = Scenario::parse(&wrong, "x.toml").unwrap_err().to_string();
    assert!(error.contains("expected a capture pump, got \"lid\"; known: getter"), "{error}");
}

/// Through a thin sharp opening less air flows than through a rounded one, and the less, the higher the pressure behind.
#[test]
fn a_vent_with_sharp_edges_is_slower() {
    let text = r#"
title = "t"
until = "1 min"
step = "100 ms"
[volumes]
round = { volume = "100 l", pressure = "1e-3 mbar" }
sharp = { volume = "100 l", pressure = "1e-3 mbar" }
[vents]
round-vent = { at = "round", diameter = "6 mm", length = "0.001 mm", open = true }
sharp-vent = { at = "sharp", diameter = "6 mm", length = "0.001 mm", sharp-edged = true, open = true }
[[timeline]]
at = "5 s"
# 0.2827 cm2 x 20 l/(s cm2) x 1013 mbar over 100 l; through sharp edges 0.88 of it into vacuum, and 0.84 into a quarter of the pressure.
expect = [
    { volume = "round", near = "286 mbar", within = "2 %" },
    { volume = "sharp", near = "246 mbar", within = "2 %" },
]
"#;
    let scenario = Scenario::parse(text, "x.toml").unwrap();
    let mut run = scenario.start(MasterPresence::Absent);
    while run.seconds() < 6.0 {
        run.step(&mut []);
    }
    let findings: Vec<_> = run.failures().iter().map(ToString::to_string).collect();
    assert!(findings.is_empty(), "{}", findings.join("\n"));
    let tube =
        "[tubes]\nt = { between = [\"round\", \"sharp\"], conductance = \"1 l/s\", sharp-edged = true }\n[vents]";
    let error = Scenario::parse(&text.replace("[vents]", tube), "x.toml").unwrap_err().to_string();
    assert!(error.contains("expected diameter and length, or conductance"), "{error}");
}

#[test]
fn a_scenario_has_a_name_or_is_a_file() {
    let title = |given: &str| Scenario::of_file_or_name(Path::new(given)).map(|scenario| scenario.title);
    assert_eq!(title("cryostat").unwrap(), "The insulating vacuum of a cryostat");
    assert_eq!(title(file("cryostat").to_str().unwrap()).unwrap(), "The insulating vacuum of a cryostat");
    let error = title("cryostate").unwrap_err().to_string();
    assert!(
        error.starts_with(
            "expected a scenario file or the name of an included scenario, found \"cryostate\"; included: demo, "
        ),
        "{error}"
    );
    assert!(error.ends_with("; did you mean \"cryostat\"?"), "{error}");
    assert!(matches!(title("cryostat.toml"), Err(profivac_virtual::scenario::ScenarioError::Read { .. })));
}

/// An ion pump that fills, a turbo with a speed for helium, a roughing pump that slows down at low pressure.
#[test]
fn pumps_have_speeds_by_gas_and_pressure_and_capture_pumps_fill() {
    let text = r#"
title = "t"
until = "1 h"
step = "1 s"
[volumes]
beam = { volume = "10 l", gas = "n2", pressure = "1e-6 mbar" }
chamber = { volume = "10 l", gas = "he", pressure = "1e-6 mbar" }
fore = { volume = "10 l", gas = "n2", pressure = "1e-2 mbar" }
[roughing-pumps]
scroll = { at = "fore", speed = "10 l/s", ultimate = "1e-9 mbar", speed-at = { "1 mbar" = "10 l/s", "1e-2 mbar" = "1 l/s" }, running = true }
[turbo-pumps]
turbo = { inlet = "chamber", fore = "fore", speed = "100 l/s", speeds = { he = "50 l/s" }, compressions = { he = 1e6 }, running = true }
[capture-pumps]
ion = { at = "beam", speeds = { n2 = "10 l/s" }, capacities = { n2 = "2e-3 mbar l" }, highest-pressure = "1e-4 mbar", running = true }
[inlets]
beam-inlet = { at = "beam", gas = "n2" }
chamber-inlet = { at = "chamber", gas = "he" }
fore-inlet = { at = "fore", gas = "n2" }
[[timeline]]
at = "1 s"
flow = [
    { inlet = "beam-inlet", flow = "1e-6 mbar l/s" },
    { inlet = "chamber-inlet", flow = "5e-5 mbar l/s" },
    { inlet = "fore-inlet", flow = "1e-3 mbar l/s" },
]
[[timeline]]
at = "10 min"
expect = [
    # A third of the capacity is used: 1e-6 mbar l/s over 7 l/s.
    { volume = "beam", near = "1.43e-7 mbar", within = "5 %" },
    { volume = "chamber", near = "1e-6 mbar", within = "5 %" },
    { volume = "fore", near = "1.05e-3 mbar", within = "5 %" },
]
[[timeline]]
at = "1 h"
expect = [{ volume = "beam", above = "1e-5 mbar" }]
"#;
    let scenario = Scenario::parse(text, "x.toml").unwrap();
    let mut run = scenario.start(MasterPresence::Absent);
    let mut devices = devices(&scenario);
    while !run.is_over() {
        run.step(&mut devices);
    }
    let findings: Vec<_> = run.failures().iter().map(ToString::to_string).collect();
    assert!(findings.is_empty(), "{}", findings.join("\n"));
    let wrong = text.replace("\"1 mbar\" = \"10 l/s\"", "\"0.01 mbar\" = \"10 l/s\"");
    let error = Scenario::parse(&wrong, "x.toml").unwrap_err().to_string();
    assert!(error.contains("expected points of pressure and speed in the order of the pressure"), "{error}");
}

/// The second Pirani of the controller is at the fore line and not in the chamber, which is at atmospheric pressure.
#[test]
fn a_channel_elsewhere_begins_with_the_pressure_of_its_volume() {
    let scenario = scenario("demo");
    let mut devices = devices(&scenario);
    let mut run = scenario.start(MasterPresence::Absent);
    for _ in 0..50 {
        run.step(&mut devices);
        let controller = devices.iter().find(|device| device.switch_address() == 15).unwrap();
        let report = controller.report();
        let shown = report.indicated.iter().find(|shown| shown.instance == 2).unwrap();
        assert!(shown.value_mbar < 5e-2, "{:e} mbar after {} s", shown.value_mbar, run.seconds());
    }
}
