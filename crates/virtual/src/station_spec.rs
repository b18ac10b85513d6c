//! Stations of a virtual segment: gauges by their names, and slaves by their GSD files.

use crate::device::VirtualDevice;
use crate::device_spec::{DeviceSpec, SpecError};
use crate::gsd_slave::{GsdSpec, GsdSpecError, GsdStation, is_gsd_file};
use profivac_dp::link::{BitTime, Listening, Station, Transmit};
use profivac_wire::Telegram;
use std::path::Path;
use std::str::FromStr;

/// A station as a command line writes it: `bcg450@5:unit=torr` or `FILE.gsd@9:modules=3+7`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StationSpec {
    /// A gauge.
    Gauge(DeviceSpec),
    /// A slave by its GSD file.
    Slave(GsdSpec),
}

/// Why a text is no station.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StationSpecError {
    /// It is no gauge.
    #[error(transparent)]
    Gauge(#[from] SpecError),
    /// It is no slave by its file.
    #[error(transparent)]
    Slave(#[from] Box<GsdSpecError>),
}

impl FromStr for StationSpec {
    type Err = StationSpecError;

    fn from_str(text: &str) -> Result<Self, StationSpecError> {
        Self::parse_in(text, Path::new(""))
    }
}

impl StationSpec {
    /// The address by which the user names the station.
    #[must_use]
    pub const fn address(&self) -> u8 {
        match self {
            Self::Gauge(spec) => spec.address,
            Self::Slave(spec) => spec.address,
        }
    }

    /// Parses a station whose files are relative to `folder`.
    ///
    /// # Errors
    /// [`StationSpecError`].
    pub fn parse_in(text: &str, folder: &Path) -> Result<Self, StationSpecError> {
        match is_gsd_file(text) {
            true => Ok(Self::Slave(text.parse::<GsdSpec>().map_err(Box::new)?.in_folder(folder))),
            false => Ok(Self::Gauge(DeviceSpec::parse_in(text, folder)?)),
        }
    }
}

/// A station of a virtual segment.
pub enum VirtualStation {
    /// A gauge.
    Gauge(VirtualDevice),
    /// A slave by its GSD file.
    Slave(GsdStation),
}

impl VirtualStation {
    /// The address by which the user names the station.
    #[must_use]
    pub const fn switch_address(&self) -> u8 {
        match self {
            Self::Gauge(device) => device.switch_address(),
            Self::Slave(slave) => slave.switch_address(),
        }
    }

    /// The address and the name, as a list of stations has them: `5 (bcg450)`.
    #[must_use]
    pub fn named(&self) -> String {
        let name = match self {
            Self::Gauge(device) => device.device().name(),
            Self::Slave(slave) => slave.name(),
        };
        format!("{} ({name})", self.switch_address())
    }

    fn station(&self) -> &dyn Station {
        match self {
            Self::Gauge(device) => device,
            Self::Slave(slave) => slave,
        }
    }

    fn station_mut(&mut self) -> &mut dyn Station {
        match self {
            Self::Gauge(device) => device,
            Self::Slave(slave) => slave,
        }
    }
}

impl Station for VirtualStation {
    fn telegram(&mut self, end: BitTime, telegram: &Telegram<'_>) -> Option<Transmit<'_>> {
        self.station_mut().telegram(end, telegram)
    }

    fn sent(&mut self, end: BitTime) {
        self.station_mut().sent(end);
    }

    fn poll(&mut self, now: BitTime) -> Option<Transmit<'_>> {
        self.station_mut().poll(now)
    }

    fn wake_at(&self) -> Option<BitTime> {
        self.station().wake_at()
    }

    fn listening(&self) -> Listening {
        self.station().listening()
    }
}

/// The gauges among stations.
pub fn gauges_of(stations: &mut [VirtualStation]) -> impl Iterator<Item = &mut VirtualDevice> {
    stations.iter_mut().filter_map(|station| match station {
        VirtualStation::Gauge(device) => Some(device),
        VirtualStation::Slave(_) => None,
    })
}
