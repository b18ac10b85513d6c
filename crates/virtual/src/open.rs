//! Ports by name, virtual segments included: a serial device or pty, `tcp://HOST:PORT`, or `sim:FILE.toml`.

use crate::segment_file::SegmentFile;
use profivac_dp::link::Baud;
use profivac_host::port::{self, Opener, Port, PortError};
use std::path::Path;
use std::sync::Arc;

/// Opens the port of this name. Names other than `sim:FILE.toml` are those of [`port::open`].
///
/// # Errors
/// A [`PortError`] that names the port and says what to do.
pub fn port(name: &str, baud: Baud) -> Result<Box<dyn Port>, PortError> {
    port_unless(name, baud, &|| false)
}

/// The same with the wait of [`port::open_unless`].
///
/// # Errors
/// As [`port::open_unless`].
pub fn port_unless(name: &str, baud: Baud, is_cancelled: &dyn Fn() -> bool) -> Result<Box<dyn Port>, PortError> {
    match name.strip_prefix("sim:") {
        Some(path) => Ok(Box::new(SegmentFile::read(Path::new(path))?.run()?)),
        None => port::open_unless(name, baud, is_cancelled),
    }
}

/// Opens a segment in memory with these devices, as the command line writes them. The devices end with the port.
///
/// ```
/// use profivac_client::Bus;
///
/// let port = profivac_virtual::open::devices(&["bcg450@5:unit=torr", "pcg550@6"])?;
/// let mut bus = Bus::on(port).open()?;
/// assert_eq!(bus.gauge(6)?.model().name, "pcg550");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`PortError::File`] names the device that is wrong.
pub fn devices(specs: &[&str]) -> Result<Box<dyn Port>, PortError> {
    let quoted: Vec<_> = specs.iter().map(|spec| format!("{spec:?}")).collect();
    let text = format!("devices = [{}]", quoted.join(", "));
    Ok(Box::new(SegmentFile::parse(&text, Path::new("virtual"))?.run()?))
}

/// Opens the port of this name again after it was lost. A segment file that is wrong stays wrong; the opener keeps trying.
#[must_use]
pub fn opener(name: &str, baud: Baud) -> Opener {
    let name = name.to_owned();
    Arc::new(move || port(&name, baud).ok())
}
