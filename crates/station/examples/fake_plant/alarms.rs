//! The alarms of the example: some are raised from the beginning, one is acknowledged, one is out of service.

use super::gauges::Fake;
use profivac_station::alarm::thread::inputs;
use profivac_station::config::Email;
use profivac_station::services::Services;
use profivac_web_server::auth::{Actor, Role, User};
use std::error::Error;
use std::fmt::Write;
use std::path::Path;

/// The alarms in the file of the station.
const ALARMS: &str = r#"
[[alarm]]
name = "gate 2 not evacuated"
gauge = "gate 2"
above = "1e-3 mbar"
priority = "high"
delay = "0 s"
message = "Keep the gate valve closed and call the vacuum group."

[[alarm]]
name = "transfer above 3e-5 mbar"
gauge = "transfer"
above = "3e-5 mbar"
reset = "1e-5 mbar"
priority = "low"
delay = "0 s"

[[alarm]]
name = "cryostat above 1e-4 mbar"
gauge = "cryostat"
above = "1e-4 mbar"

[[alarm]]
name = "vessel vented"
gauge = "vessel"
above = "10 mbar"
priority = "high"
delay = "0 s"
off-delay = "0 s"

[[alarm]]
name = "chamber leaks"
gauge = "chamber"
rise = 0.5
window = "1 min"

[[plant-state]]
name = "Vented"
description = "The vessel is open to air."
gauges = ["vessel"]
longest = "12 h"

[[plant-state]]
name = "Bake-out"
kinds = ["rise"]
longest = "14 days"
role = "engineer"

# No server listens at this port.
[[email]]
name = "shift"
server = "127.0.0.1:9"
security = "none"
from = "hall@example.org"
to = ["shift@example.org"]

[alarms]
fault = { delay = "0 s" }
stale = { delay = "0 s", priority = "low" }
not-measurable = { delay = "0 s" }
segment = { delay = "0 s" }
"#;

/// Writes the file of the station into `folder`, starts its alarms, and changes them as users would. Returns the e-mails.
pub fn start(services: &Services, fakes: &[Fake], folder: &Path) -> Result<Vec<Email>, Box<dyn Error>> {
    let path = folder.join("fake.toml");
    std::fs::write(&path, file(fakes)?)?;
    let config = profivac_config::read(&path)?;
    services.alarm_editor().set_source(config.source);
    services.alarms().start(config.alarms, config.emails.iter().map(Email::target).collect())?;
    services.alarms().start_plant_states(config.plant_states)?;
    services.alarms().evaluate(&inputs(services.snapshots(), services.recorder(), services.gateways()));
    let known = services.alarms().all().into_iter().find(|alarm| alarm.name == "segment bench: down");
    let occurrence = known.map(|alarm| alarm.occurrence).unwrap_or_default();
    services.alarms().acknowledge("segment bench: down", occurrence, &actor("olga", Role::Operator))?;
    services.alarms().take_out_of_service(
        "spare: no data",
        &actor("ada", Role::Engineer),
        "It is not installed yet.",
        None,
    )?;
    Ok(config.emails)
}

fn actor(name: &str, role: Role) -> Actor {
    Actor { user: User { name: name.into(), role }, peer: None }
}

fn file(fakes: &[Fake]) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    for segment in ["hall", "beam line", "bench"] {
        writeln!(text, "[[segment]]\nname = {segment:?}\nport = {segment:?}\nmaster = 1")?;
        for Fake { name, address, device, .. } in fakes.iter().filter(|fake| fake.segment == segment) {
            writeln!(text, "[[segment.gauge]]\nname = {name:?}\naddress = {address}\ndevice = {device:?}")?;
        }
    }
    Ok(text + ALARMS)
}
