//! A segment in memory, described by a file: the port `sim:FILE.toml`.
//!
//! ```toml
//! devices = ["bcg450@5:unit=torr", "pcg550@6"]    # as on the command line of `simulate`; GSD files beside the file
//! baud = 19200                                    # delays of the devices count in its bit times
//! pressure = "5e-6 mbar"
//! atmosphere = "1013.25 mbar"
//! gas = "n2"
//! state = "gauges"                                # their nonvolatile memory, in this folder beside the file
//! ```
//!
//! Only `devices` is required. The devices run in a thread and in real time, at the other end of a socket, so the port
//! behaves like any other; they end with the port.

use crate::device::{GasConditions, VirtualDevice};
use crate::device_spec::{DeviceSpec, MemoryError, SpecError, check_distinct};
use crate::gas_pressure::GasPressure;
use crate::gsd_slave::{GsdSpec, GsdSpecError, GsdStation};
use crate::nonvolatile::NonvolatileMemory;
use crate::station_spec::{StationSpec, StationSpecError, VirtualStation};
use profivac_client::pressure::Pressure;
use profivac_dp::link::Baud;
use profivac_host::port::{Notice, PortError, Stream};
use profivac_host::readiness::{Local, pair};
use profivac_host::segment::Segment;
use profivac_host::text_file::{self, Parsed, baud, line_and_column, usual_baud};
use profivac_vacuum::Gas;
use serde::Deserialize;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;
use toml::Spanned;

/// The contents of the file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Description {
    devices: Spanned<Vec<Spanned<String>>>,
    #[serde(default = "usual_baud", deserialize_with = "baud")]
    baud: Baud,
    pressure: Option<Parsed<GasPressure>>,
    atmosphere: Option<Parsed<GasPressure>>,
    gas: Option<Parsed<Gas>>,
    state: Option<Spanned<PathBuf>>,
}

impl Description {
    /// The devices, each with its position in the text.
    fn specs(&self, folder: &Path) -> Result<Vec<(Range<usize>, StationSpec)>, Positioned> {
        let mut specs = Vec::new();
        for text in self.devices.get_ref() {
            let spec = StationSpec::parse_in(text.get_ref(), folder);
            specs.push(spec.map_err(|error| Positioned::at(&text.span(), error))?);
        }
        let addresses = specs.iter().map(StationSpec::address);
        check_distinct(addresses).map_err(|error| Positioned::at(&self.devices.span(), error))?;
        Ok(self.devices.get_ref().iter().map(Spanned::span).zip(specs).collect())
    }

    /// The environment, with the defaults of `simulate`.
    fn environment(&self) -> GasConditions {
        let or = |given: &Option<Parsed<GasPressure>>, mbar| {
            given.as_ref().map_or(Pressure::from_mbar(mbar), |given| given.0.0)
        };
        GasConditions {
            pressure: or(&self.pressure, 1e-3),
            atmosphere: or(&self.atmosphere, 1013.25),
            gas: self.gas.as_ref().map_or(Gas::N2, |gas| gas.0),
        }
    }
}

/// The reason why a segment file cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SegmentFileError {
    /// The file cannot be read.
    #[error("{name}: {source}")]
    Read {
        /// The file.
        name: String,
        /// The error of the system.
        source: std::io::Error,
    },
    /// The text is wrong.
    #[error("{name}:{line}:{column}: {error}")]
    Text {
        /// The file.
        name: String,
        /// From 1.
        line: usize,
        /// From 1.
        column: usize,
        /// The error at this position.
        error: Box<EntryError>,
    },
}

/// The error at a position of a segment file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EntryError {
    /// The text is no TOML, or has unknown keys or invalid values.
    #[error("{}", .0.message())]
    Toml(Box<toml::de::Error>),
    /// A device spec is invalid.
    #[error(transparent)]
    Device(#[from] SpecError),
    /// A slave by its GSD file cannot be built.
    #[error(transparent)]
    Slave(#[from] Box<GsdSpecError>),
    /// The folder of the nonvolatile memory cannot be used.
    #[error(transparent)]
    Store(#[from] MemoryError),
}

impl From<StationSpecError> for EntryError {
    fn from(error: StationSpecError) -> Self {
        match error {
            StationSpecError::Gauge(error) => Self::Device(error),
            StationSpecError::Slave(error) => Self::Slave(error),
        }
    }
}

impl From<SegmentFileError> for PortError {
    fn from(error: SegmentFileError) -> Self {
        Self::File(Box::new(error))
    }
}

/// An error with its position in the text, in octets.
struct Positioned {
    at: usize,
    error: EntryError,
}

impl Positioned {
    fn at(span: &Range<usize>, error: impl Into<EntryError>) -> Self {
        Self { at: span.start, error: error.into() }
    }
}

/// The devices of a file, switched on.
pub struct SegmentFile {
    name: String,
    baud: Baud,
    devices: Vec<VirtualStation>,
    notices: Vec<Notice>,
}

impl SegmentFile {
    /// Reads the file at `path` and builds its devices.
    ///
    /// # Errors
    /// [`SegmentFileError`] with the position in the file.
    pub fn read(path: &Path) -> Result<Self, SegmentFileError> {
        let name = path.display().to_string();
        let text = text_file::read(path).map_err(|source| SegmentFileError::Read { name, source })?;
        Self::parse(&text, path)
    }

    /// Builds the devices that `text` describes. `path` is used for messages and for the folder of the nonvolatile memory.
    ///
    /// # Errors
    /// [`SegmentFileError::Text`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, SegmentFileError> {
        Self::make(text, path).map_err(|Positioned { at, error }| {
            let (line, column) = line_and_column(text, at);
            SegmentFileError::Text { name: path.display().to_string(), line, column, error: Box::new(error) }
        })
    }

    fn make(text: &str, path: &Path) -> Result<Self, Positioned> {
        let described: Description = toml::from_str(text)
            .map_err(|error| Positioned::at(&error.span().unwrap_or_default(), EntryError::Toml(Box::new(error))))?;
        let (conditions, baud) = (described.environment(), described.baud);
        let mut file = Self { name: format!("sim:{}", path.display()), baud, devices: Vec::new(), notices: Vec::new() };
        for (span, spec) in described.specs(path.parent().unwrap_or(Path::new("")))? {
            let station = match spec {
                StationSpec::Gauge(spec) => {
                    let memory = file.memory(&described, path, &spec)?;
                    let slave = spec.build(memory, baud).map_err(|error| Positioned::at(&span, error))?;
                    VirtualStation::Gauge(VirtualDevice::new(slave, spec.address, baud, conditions))
                }
                StationSpec::Slave(spec) => VirtualStation::Slave(file.slave(&described, path, spec, &span)?),
            };
            file.devices.push(station);
        }
        Ok(file)
    }

    /// The nonvolatile memory of a device: from its file in the folder, or empty.
    fn memory(
        &mut self,
        described: &Description,
        path: &Path,
        spec: &DeviceSpec,
    ) -> Result<NonvolatileMemory, Positioned> {
        let Some(folder) = &described.state else { return Ok(NonvolatileMemory::volatile()) };
        let opened = spec
            .open_memory(&path.with_file_name(folder.get_ref()))
            .map_err(|error| Positioned::at(&folder.span(), error))?;
        self.notices.extend(opened.set_aside.map(|aside| aside.notice(&spec.device, spec.address)));
        Ok(opened.memory)
    }

    /// A slave by its GSD file; its files are relative to the segment file.
    fn slave(
        &mut self,
        described: &Description,
        path: &Path,
        spec: GsdSpec,
        span: &Range<usize>,
    ) -> Result<GsdStation, Positioned> {
        let address = spec.address;
        let state = described.state.as_ref().map(|folder| path.with_file_name(folder.get_ref()));
        let opened = spec.open(self.baud, state.as_deref()).map_err(|error| Positioned::at(span, Box::new(error)))?;
        self.notices.extend(opened.set_aside.map(|(name, aside)| aside.notice(&name, address)));
        Ok(opened.station)
    }

    /// Starts the devices. They run until the port is dropped.
    ///
    /// # Errors
    /// [`PortError::System`] when the system has no socket or thread left.
    pub fn run(self) -> Result<Stream<Local>, PortError> {
        let Self { name, baud, devices, notices } = self;
        let failed = |source| PortError::System { name: name.clone(), source };
        let (ours, theirs) = pair().map_err(failed)?;
        for socket in [&ours, &theirs] {
            socket.set_nonblocking(true).map_err(failed)?;
        }
        let mut segment = Segment::new(Box::new(Stream::new(name.clone(), theirs, Vec::new())), baud, false, devices);
        let live = move || while segment.serve(&[], Duration::MAX).is_ok() {};
        // The name of a thread must not contain a zero.
        std::thread::Builder::new().name(name.replace('\0', "")).spawn(live).map_err(failed)?;
        Ok(Stream::new(name, ours, notices))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_host::port::Delivery;
    use profivac_host::scan::probe;
    use profivac_host::session::{BusSession, bus_parameters};
    use std::fs;
    use std::time::Instant;

    const FILE: &str = "\
devices = [\"bcg450@5:unit=torr\", \"pcg550@6\"]
pressure = \"5e-6 mbar\"
gas = \"ar\"
baud = 93750
";

    fn parse(text: &str) -> Result<SegmentFile, SegmentFileError> {
        SegmentFile::parse(text, Path::new("segment.toml"))
    }

    fn gauges(file: &SegmentFile) -> impl Iterator<Item = &VirtualDevice> {
        file.devices.iter().filter_map(|station| match station {
            VirtualStation::Gauge(device) => Some(device),
            VirtualStation::Slave(_) => None,
        })
    }

    #[test]
    fn a_file_describes_the_same_devices_as_a_command_line() {
        let file = parse(FILE).unwrap();
        let devices: Vec<_> = gauges(&file).map(|device| (device.device().name(), device.switch_address())).collect();
        assert_eq!((devices.as_slice(), file.baud), (&[("bcg450", 5), ("pcg550", 6)][..], Baud::B93750));
        assert_eq!(file.name, "sim:segment.toml");
        let usual = toml::from_str::<Description>("devices = []").unwrap();
        assert_eq!((usual.baud, usual.environment().pressure.mbar()), (Baud::B19200, 1e-3));
        let described = toml::from_str::<Description>(FILE).unwrap().environment();
        assert_eq!((described.pressure.mbar(), described.gas), (5e-6, Gas::Ar));
    }

    #[test]
    fn an_invalid_file_is_an_error_with_its_position() {
        for (text, sentence) in [
            ("devices = [", "segment.toml:1:12: "),
            ("gas = \"n2\"", "missing field `devices`"),
            ("devices = []\nbaud = 115200", "segment.toml:2:8: expected a PROFIBUS rate, one of 9600, "),
            ("devices = []\nbaud = \"fast\"", "segment.toml:2:8: invalid type: string \"fast\", expected u32"),
            ("devices = []\n\npressure = \"1 psi\"", "segment.toml:3:12: expected a unit, one of mbar, "),
            (
                "devices = []\npressure = \"0 mbar\"",
                "segment.toml:2:12: expected a pressure from 1e-15 mbar to 10 bar, got \"0 mbar\"",
            ),
            (
                "devices = []\natmosphere = \"1e300 mbar\"",
                "segment.toml:2:14: expected a pressure from 1e-15 mbar to 10 bar, got \"1e300 mbar\"",
            ),
            ("devices = []\ngas = \"beer\"", "segment.toml:2:7: "),
            (
                "devices = []\ncolour = 1",
                "segment.toml:2:1: unknown field `colour`, expected one of `devices`, `baud`, ",
            ),
            (
                "devices = [\n  \"bcg450@5\",\n  \"bcg451@6\",\n]",
                "segment.toml:3:3: unknown device \"bcg451\"; known: ",
            ),
            (
                "devices = [\"bcg450@5\", \"pcg550@6:atm=x\"]",
                "segment.toml:1:24: pcg550: expected atm=on|off, got \"x\"",
            ),
            ("devices = [\"bcg450@5\", \"pcg550@5\"]", "segment.toml:1:11: two devices at address 5"),
        ] {
            let Err(error) = parse(text) else { panic!("{text}") };
            assert!(error.to_string().contains(sentence), "{text}: {error}");
        }
    }

    #[test]
    fn a_master_finds_the_devices() {
        let port = parse(FILE).unwrap().run().unwrap();
        let bus = bus_parameters(2, Baud::B19200, Delivery::Unpaced);
        let timeout = Duration::from_secs(30);
        let mut session = BusSession::new(Box::new(port), Baud::B19200, bus, timeout).unwrap();
        let mut ident =
            |address| probe(&mut session, address).unwrap().and_then(|station| station.slave).map(|slave| slave.ident);
        assert_eq!((ident(5), ident(6)), (Some(0x08E6), Some(0x0C85)));
    }

    /// The number of threads with this name.
    fn threads(name: &str) -> usize {
        let tasks = fs::read_dir("/proc/self/task").unwrap();
        let names = tasks.filter_map(|task| fs::read_to_string(task.ok()?.path().join("comm")).ok());
        names.filter(|comm| comm.trim() == name).count()
    }

    #[test]
    fn the_devices_end_with_the_port() {
        let file = SegmentFile::parse(FILE, Path::new("ends.toml")).unwrap();
        let port = file.run().unwrap();
        let deadline = Instant::now() + Duration::from_secs(30);
        while threads("sim:ends.toml") == 0 {
            assert!(Instant::now() < deadline, "the thread did not start");
            std::thread::yield_now();
        }
        drop(port);
        while threads("sim:ends.toml") > 0 {
            assert!(Instant::now() < deadline, "the thread did not end");
            std::thread::yield_now();
        }
    }

    #[test]
    fn values_are_stored_in_a_folder_beside_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("segment.toml");
        fs::write(&path, "devices = [\"bcg450@5\"]\nstate = \"gauges\"").unwrap();
        drop(SegmentFile::read(&path).unwrap());
        assert!(folder.path().join("gauges").is_dir());
        fs::write(folder.path().join("gauges/bcg450-5.state"), "damaged").unwrap();
        let notices = SegmentFile::read(&path).unwrap().notices;
        assert!(matches!(&notices[..], [Notice::StoreDamaged { address: 5, .. }]), "{notices:?}");
        let missing = SegmentFile::read(&folder.path().join("nothing.toml"));
        assert!(matches!(missing, Err(SegmentFileError::Read { .. })));
    }
}
