//! The alarms of the demonstration: the default alarms and two limits for its chamber.

use crate::failure::Failure;
use profivac_station::alarm::Rule;
use profivac_station::config::Config;
use profivac_virtual::scenario::Scenario;
use std::fmt::Write;
use std::path::Path;

/// The name of the gauge of the chamber in the default scenario.
const CHAMBER: &str = "bcg450 5";

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

/// Short delays for a short demonstration.
const DELAYS: &str = "
[alarms]
stale = { delay = \"3 s\" }
fault = { delay = \"1 s\" }
";

/// The alarms of `scenario`, whose gauges are shown on one segment under these names.
pub fn rules(scenario: &Scenario, segment: &str, names: impl Fn(u8) -> (String, String)) -> Result<Vec<Rule>, Failure> {
    let master = free_address(scenario);
    let mut text = format!("[[segment]]\nname = {segment:?}\nport = \"in memory\"\nmaster = {master}\n");
    let mut has_chamber = false;
    for spec in scenario.specs() {
        let (name, device) = names(spec.address);
        has_chamber |= name == CHAMBER;
        // Writing to a string never fails.
        write!(text, "[[segment.gauge]]\nname = {name:?}\naddress = {}\ndevice = {device:?}\n", spec.address).ok();
    }
    let limits = if has_chamber { LIMITS } else { "" };
    let config = Config::parse(&format!("{text}{limits}{DELAYS}"), Path::new("demo"));
    config.map(|config| config.alarms).map_err(|error| Failure::usage(error.to_string()))
}

/// An address that no gauge has, for the master.
fn free_address(scenario: &Scenario) -> u8 {
    (0..=125).find(|address| scenario.specs().all(|spec| spec.address != *address)).unwrap_or_default()
}
