//! Ports as people name them: a serial device or pty, `tcp://host:port`, or `sim:FILE.toml`.

use crate::segment_file::SegmentFile;
use profivac_dp::link::Baud;
use profivac_host::port::{Opener, Port, PortError, Serial, TcpClient};
use std::path::Path;
use std::sync::Arc;

/// Opens the port of this name.
///
/// # Errors
/// A [`PortError`] in one sentence.
pub fn port(name: &str, baud: Baud) -> Result<Box<dyn Port>, PortError> {
    if let Some(address) = name.strip_prefix("tcp://") {
        return Ok(Box::new(TcpClient::connect(address)?));
    }
    if let Some(path) = name.strip_prefix("sim:") {
        return Ok(Box::new(SegmentFile::read(Path::new(path))?.run()?));
    }
    Ok(Box::new(Serial::open(name, baud)?))
}

/// What opens it again whenever it is lost.
#[must_use]
pub fn opener(name: &str, baud: Baud) -> Opener {
    let name = name.to_owned();
    Arc::new(move || port(&name, baud))
}
