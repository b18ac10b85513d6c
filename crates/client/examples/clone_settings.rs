//! Copies the settings of a gauge to its replacement.
//!
//! ```sh
//! profivac simulate --pty /tmp/line bcg450@5:unit=torr bcg450@6
//! cargo run -p profivac-client --example clone_settings -- /tmp/line 5 6
//! ```

use profivac_client::settings::{self, RestoreOutcome, SettingsFile};
use profivac_client::{Bus, ClientError};
use std::error::Error;

/// A setting that was different.
#[derive(Debug)]
pub struct Change {
    /// The parameter.
    pub name: String,
    /// The value of the replacement before.
    pub before: String,
    /// The value now, or why it could not be written.
    pub after: Result<String, ClientError>,
}

/// Writes every setting of the gauge at `from` that differs to the gauge at `to`, which must be the same model.
pub fn clone_settings(bus: &mut Bus, from: u8, to: u8) -> Result<Vec<Change>, Box<dyn Error>> {
    let file = SettingsFile::parse(&settings::dump(&mut bus.gauge(from)?)?.to_toml())?;
    let mut target = bus.gauge(to)?;
    file.check(&target)?;
    let mut changes = Vec::new();
    // Unit and number type come first: the other values depend on them.
    for (parameter, setting) in file.in_order(&target)? {
        let Some(difference) = settings::compare(&mut target, &parameter, &setting)? else { continue };
        let before = difference.current.text.clone();
        let after = match settings::restore(&mut target, difference)? {
            RestoreOutcome::Written { after, .. } => Ok(after),
            RestoreOutcome::Refused(error) => Err(error),
        };
        changes.push(Change { name: parameter.name, before, after });
    }
    Ok(changes)
}

#[allow(dead_code, reason = "a test calls only the function above")]
fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(port), Some(from), Some(to)) = (arguments.next(), arguments.next(), arguments.next()) else {
        return Err("expected PORT FROM TO".into());
    };
    let mut bus = Bus::builder(port).open()?;
    for Change { name, before, after } in clone_settings(&mut bus, from.parse()?, to.parse()?)? {
        match after {
            Ok(after) => println!("{name}: {before} -> {after}"),
            Err(error) => println!("{name}: {before}, {error}"),
        }
    }
    Ok(())
}
