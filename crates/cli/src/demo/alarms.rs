//! The alarms of the demonstration: the default alarms, two limits for its chamber, and the plant state in which it begins.

use crate::failure::Failure;
use profivac_station::alarm::{PlantStateRule, Rule};
use profivac_station::config::MEMORY_PORT;
use profivac_virtual::scenario::Scenario;
use std::fmt::Write;
use std::path::Path;

/// The name of the gauge of the chamber in the default scenario.
pub const CHAMBER: &str = "bcg450 5";

/// The limits, as in a station's file.
const LIMITS: &str = r#"
[[alarm]]
name = "chamber above 1e-3 mbar"
gauge = "bcg450 5"
above = "1e-3 mbar"
priority = "high"
message = "Is a flange open? The gate can be closed."

[[alarm]]
name = "chamber pressure rises"
gauge = "bcg450 5"
rise = 2.0
window = "5 s"
"#;

/// The plant state in which the demonstration begins, as in a station's file.
const PUMP_DOWN_STATE: &str = r#"
[[plant-state]]
name = "Chamber pump-down"
description = "The chamber is evacuated."
alarms = ["chamber above 1e-3 mbar"]
"#;

/// Short delays for a short demonstration.
const DELAYS: &str = "
[alarms]
stale = { delay = \"3 s\" }
fault = { delay = \"1 s\" }
";

/// The alarms and plant states of `scenario`, whose gauges are shown on one segment under these names.
pub fn rules(
    scenario: &Scenario,
    segment: &str,
    names: impl Fn(u8) -> (String, String),
) -> Result<(Vec<Rule>, Vec<PlantStateRule>), Failure> {
    let master = free_address(scenario);
    let mut text = format!("[[segment]]\nname = {segment:?}\nport = {MEMORY_PORT:?}\nmaster = {master}\n");
    let mut has_chamber = false;
    for spec in scenario.specs() {
        let (name, device) = names(spec.address);
        has_chamber |= name == CHAMBER;
        // Writing to a string never fails.
        write!(text, "[[segment.gauge]]\nname = {name:?}\naddress = {}\ndevice = {device:?}\n", spec.address).ok();
    }
    let (limits, states) = if has_chamber { (LIMITS, PUMP_DOWN_STATE) } else { ("", "") };
    let config = profivac_config::parse(&format!("{text}{limits}{states}{DELAYS}"), Path::new("demo"));
    config.map(|config| (config.alarms, config.plant_states)).map_err(|error| Failure::usage(error.to_string()))
}

/// An address that no gauge has, for the master.
fn free_address(scenario: &Scenario) -> u8 {
    (0..=125).find(|address| scenario.specs().all(|spec| spec.address != *address)).unwrap_or_default()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test")]
mod tests {
    use super::super::{MASTER, SCENARIO, SCENARIO_NAME, pump_down};
    use super::*;
    use profivac_dp::link::Baud;
    use profivac_recorder::Micros;
    use profivac_station::alarm::{AlarmRegistry, AlarmTime};
    use profivac_station::segment::demo_segment::simulated_inputs;
    use profivac_virtual::memory_segment::MemorySegment;
    use profivac_virtual::scenario::{MasterPresence, Run};

    /// The plant of the demonstration with its alarms, in simulated time.
    struct Plant {
        run: Run,
        segment: MemorySegment,
        registry: AlarmRegistry,
        names: Vec<(u8, String)>,
        step: u32,
    }

    /// The alarms are evaluated this often, in steps of the plant: 12 x 20 ms, as in a running station.
    const STEPS: u32 = 12;

    impl Plant {
        fn new() -> Self {
            let scenario = Scenario::parse(SCENARIO, SCENARIO_NAME).unwrap();
            let names: Vec<_> = scenario.specs().map(|spec| (spec.address, spec.device.clone())).collect();
            let named = |address: u8| {
                let device = names.iter().find(|(known, _)| *known == address).unwrap().1.clone();
                (format!("{device} {address}"), device)
            };
            let mut registry = AlarmRegistry::default();
            let (rules, plant_states) = rules(&scenario, "demo", named).unwrap();
            let now = AlarmTime::default();
            registry.reconfigure(rules, Vec::new(), now);
            registry.plant_states_mut().reconfigure(plant_states, Vec::new(), now);
            registry.plant_states_mut().declare(pump_down::NAME, "demo", "vented", pump_down::LONGEST, now).unwrap();
            // A slow line makes the test fast; every gauge still exchanges data several times a second.
            let segment = scenario.memory_segment(MASTER, Baud::B45450).unwrap();
            Self { run: scenario.start(MasterPresence::Present), segment, registry, names, step: 0 }
        }

        fn advance(&mut self) {
            let next = self.run.seconds() + self.run.step_s();
            self.run.step_segment(&mut self.segment, next);
            self.step += 1;
            if self.step.is_multiple_of(STEPS) {
                let device = |address: u8| self.names.iter().find(|(known, _)| *known == address).unwrap().1.clone();
                let names = |address: u8| (format!("{} {address}", device(address)), device(address));
                let inputs = simulated_inputs(&self.segment, "demo", MASTER, names);
                let time = Micros((self.run.seconds() * 1e6) as i64);
                let now = AlarmTime { monotonic: time, wall: time };
                if inputs.gauges.iter().any(pump_down::is_evacuated) {
                    // It has been ended before.
                    self.registry.plant_states_mut().end(pump_down::NAME, "demo", "high vacuum", now).ok();
                }
                self.registry.evaluate(&inputs, now);
            }
        }

        /// The names of the alarms whose condition is met.
        fn active(&self) -> Vec<&str> {
            let alarms = self.registry.alarms().iter().filter(|alarm| alarm.status().state.is_active());
            alarms.map(|alarm| alarm.rule().name.as_str()).collect()
        }
    }

    const CHAMBER_HIGH: &str = "chamber above 1e-3 mbar";
    const FILAMENT: &str = "bpg400 6: fault";
    const EXTRACTOR: &str = "img400 16: fault";

    /// The alarms that are active at the end of each part of the timeline. In high vacuum nine Piranis and diaphragms are below their
    /// range, and before 32 s two ion gauges are off: none of these is an alarm.
    #[test]
    fn each_part_of_the_demonstration_has_the_alarms_that_an_operator_expects_and_the_end_has_none() {
        let parts: [(&str, f64, &[&str]); 15] = [
            ("air", 2.9, &[]),
            ("roughing", 19.9, &[]),
            ("backing", 22.9, &[]),
            ("turbo", 31.9, &[]),
            ("high vacuum", 41.9, &[]),
            ("leak", 49.9, &[CHAMBER_HIGH, "chamber pressure rises", EXTRACTOR]),
            ("cable", 57.9, &[CHAMBER_HIGH, "hpg400 7: no data", EXTRACTOR]),
            ("filament", 69.9, &[CHAMBER_HIGH, FILAMENT, "hpg400 7: no data", EXTRACTOR]),
            ("repair", 79.9, &[FILAMENT, EXTRACTOR]),
            ("quiet bus", 84.9, &[FILAMENT, EXTRACTOR]),
            ("off", 94.9, &[FILAMENT, "bpg400 6: no data", EXTRACTOR]),
            ("on", 109.9, &[EXTRACTOR]),
            ("cleared", 129.9, &[]),
            ("end", 180.0, &[]),
            ("two minutes later", 300.0, &[]),
        ];
        let mut plant = Plant::new();
        for (part, until_s, expected) in parts {
            while plant.run.seconds() < until_s {
                plant.advance();
            }
            assert_eq!(plant.active(), expected, "{part}, at {until_s} s");
        }
        assert_eq!(plant.run.failures().len(), 0);
    }
}
