//! A gauge by name, in a program that waits: what it measures, one of its settings, a command, and what it refuses.
//!
//! ```sh
//! profivac simulate --pty /tmp/line --pressure '5e-6 mbar' bcg450@5
//! cargo run -p profivac-host --example blocking -- /tmp/line 5
//! ```

use profivac_client::Gauge;
use profivac_dp::link::Baud;
use profivac_host::session::{BusSession, bus_parameters};
use profivac_virtual::open;
use std::error::Error;
use std::time::Duration;

/// What the gauge at `address` says, line by line.
pub fn report(port_name: &str, address: u8) -> Result<Vec<String>, Box<dyn Error>> {
    let baud = Baud::B19200;
    let mut tool =
        BusSession::new(open::port(port_name, baud)?, baud, bus_parameters(0, baud), Duration::from_secs(5))?;
    let mut gauge = Gauge::open(&mut tool, address)?;
    let mut lines = vec![format!("{} at address {address}", gauge.model().title)];

    // Commands and parameters by the manual's words. What a gauge refuses is an error that says why.
    if gauge.parameter("device.device-state")?.text == "IDLE" {
        gauge.command("execute")?;
    }
    let pressure = gauge.pressure()?;
    lines.push(match pressure.pa {
        Some(pa) => format!("instance {} measures {:.3e} mbar", pressure.instance, pa / 100.0),
        None => format!("instance {} has no valid reading", pressure.instance),
    });
    let written = gauge.write("pirani.safe-value", "12.5 Pascal")?;
    if let Some(after) = written.after {
        lines.push(format!("{} is {} now", written.named.name, after.text));
    }
    if let Err(error) = gauge.write("device.serial-number", "4711") {
        lines.push(error.to_string());
    }
    // The instance selector goes back to where it was.
    gauge.restore_selector()?;
    Ok(lines)
}

#[allow(dead_code, reason = "a test takes only what is above")]
fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(port), Some(address)) = (arguments.next(), arguments.next()) else {
        return Err("expected PORT ADDRESS".into());
    };
    for line in report(&port, address.parse()?)? {
        println!("{line}");
    }
    Ok(())
}
