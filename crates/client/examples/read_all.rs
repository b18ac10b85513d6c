//! Finds all gauges of a bus and reads their pressures, one after the other.
//!
//! ```sh
//! profivac simulate --pty /tmp/line --pressure '5e-6 mbar' bcg450@5 hpg400@6
//! cargo run -p profivac-client --example read_all -- /tmp/line
//! ```

use profivac_client::pressure::Pressure;
use profivac_client::{Bus, ClientError};
use std::error::Error;

/// A gauge with its pressure.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The station address.
    pub address: u8,
    /// The name of the device.
    pub title: &'static str,
    /// The pressure. `None` without a valid reading.
    pub pressure: Option<Pressure>,
}

/// Reads every gauge that answers at one of `addresses`. Skips masters and slaves that are no known gauge.
pub fn read_all(bus: &mut Bus, addresses: impl IntoIterator<Item = u8>) -> Result<Vec<Row>, ClientError> {
    let mut rows = Vec::new();
    for station in bus.scan(addresses)? {
        let mut gauge = match bus.gauge(station.address) {
            Err(ClientError::Master(_) | ClientError::UnknownDevice { .. }) => continue,
            gauge => gauge?,
        };
        let pressure = gauge.pressure()?.pressure();
        rows.push(Row { address: station.address, title: gauge.model().title, pressure });
    }
    Ok(rows)
}

#[allow(dead_code, reason = "a test calls only the function above")]
fn main() -> Result<(), Box<dyn Error>> {
    let port = std::env::args().nth(1).ok_or("expected PORT")?;
    let mut bus = Bus::builder(port).open()?;
    for Row { address, title, pressure } in read_all(&mut bus, 1..126)? {
        match pressure {
            Some(pressure) => println!("{title} at address {address}: {:.3e} mbar", pressure.mbar()),
            None => println!("{title} at address {address}: no valid reading"),
        }
    }
    Ok(())
}
