//! The settings of a gauge as a file. Settings are the writable parameters that survive power loss. A file can be compared
//! with a gauge and written to its replacement.
//!
//! The file is TOML. [`restore`] writes `[settings]`; `[readings]` contains the other values, for the reader of the file. Pressures
//! have their unit, so a file fits a gauge with another unit; a pressure without one is an error.
//!
//! ```
//! # use profivac_client::Bus;
//! use profivac_client::settings::{self, RestoreOutcome, SettingsFile};
//!
//! # let mut bus = Bus::on(profivac_virtual::open::devices(&["bcg450@5:unit=mbar", "bcg450@6:unit=torr"])?).open()?;
//! bus.gauge(5)?.write("pirani.safe-value", "12.5 Pa")?;
//! let file = SettingsFile::parse(&settings::dump(&mut bus.gauge(5)?)?.to_toml())?;
//!
//! let mut replacement = bus.gauge(6)?;
//! file.check(&replacement)?;
//! for (named, setting) in file.in_order(&replacement)? {
//!     if let Some(difference) = settings::compare(&mut replacement, &named, &setting)? {
//!         // A value outside the measuring range would be reported here.
//!         assert!(difference.write.beyond_range.is_none());
//!         match settings::restore(&mut replacement, difference)? {
//!             RestoreOutcome::Written { name, before, after } => println!("{name}: {before} -> {after}"),
//!             RestoreOutcome::Refused(error) => println!("{error}"),
//!         }
//!     }
//! }
//! assert_eq!(replacement.read("pirani.safe-value")?.text, "0.125 mbar");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod dump;
mod file;
mod restore;

pub use dump::{Dump, IN_IDLE, ReadResult, dump, dump_with_progress};
pub use file::{Setting, SettingsFile, SettingsFileError};
pub use restore::{Difference, RestoreOutcome, compare, restore};

use super::error::ClientError;
use super::gauge::Gauge;
use super::names::NamedParameter;
use super::records::Records;
use profivac_devices::model::{Access, Role};

/// The values of the parameter that opens and closes a set.
const OPEN: &str = "open-for-changes";
const CLOSED: &str = "valid";

/// Whether a parameter is a setting: a value that survives power loss and that a request can write.
///
/// ```
/// use profivac_client::names::ParameterNames;
/// use profivac_client::settings::is_setting;
/// use profivac_devices::catalog::model_named;
///
/// let names = ParameterNames::of(model_named("bcg450").ok_or("no such model")?);
/// let settings: Vec<_> = names.all().iter().filter(|named| is_setting(named)).map(|named| named.name.as_str()).collect();
/// assert!(settings.contains(&"pirani.safe-value") && !settings.contains(&"pirani.process-value"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn is_setting(named: &NamedParameter) -> bool {
    let row = named.parameter.row;
    row.is_stored()
        && row.access.intersects(Access::WRITE)
        && !row.codes.is_command()
        && row.role != Some(Role::InstanceSelector)
}

/// Opens a set of parameters for changes.
///
/// ```
/// # use profivac_client::Bus;
/// use profivac_client::Gauge;
/// use profivac_client::class1::Class1Session;
/// use profivac_client::cyclic::CyclicSlave;
/// use profivac_client::settings::{close_set, open_set};
/// use profivac_devices::catalog::model_named;
/// use profivac_devices::model::AccessPath;
///
/// # let mut bus = Bus::on(profivac_virtual::open::devices(&["tpg300@7"])?).open()?;
/// // A TPG300 has no MS2: its parameters are read through the parameter channel.
/// let slave = CyclicSlave::find(bus.session(), 7, 0)?;
/// let records = Class1Session::open(bus.session(), &slave, AccessPath::ParameterChannel)?;
/// let mut gauge = Gauge::with_model(records, 7, model_named("tpg300").ok_or("no such model")?);
/// let named = gauge.find("relay.1/upper-threshold")?;
/// let lock = gauge.names().lock_of(&named).cloned().ok_or("it belongs to no set")?;
/// open_set(&mut gauge, &lock)?;
/// gauge.write(&named.name, "2e-3 mbar")?;
/// close_set(&mut gauge, &lock)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`Gauge::write`].
pub fn open_set<R: Records>(gauge: &mut Gauge<R>, lock: &NamedParameter) -> Result<(), ClientError> {
    let write = gauge.prepare(lock, OPEN)?;
    gauge.execute(write).map(|_| ())
}

/// Closes a set of parameters, which applies its values. An example is at [`open_set`].
///
/// # Errors
/// As [`Gauge::write`]; the device refuses if the values contradict each other.
pub fn close_set<R: Records>(gauge: &mut Gauge<R>, lock: &NamedParameter) -> Result<(), ClientError> {
    let write = gauge.prepare(lock, CLOSED)?;
    gauge.execute(write).map(|_| ())
}
