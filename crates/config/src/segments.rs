//! `[[segment]]` and `[[segment.gauge]]`.

use super::slaves::SlaveToml;
use super::values::hex;
use crate::time_span::TimeSpan;
use profivac_client::pressure::Pressure;
use profivac_devices::catalog::KnownDevices;
use profivac_devices::model::{Configuration, Model, Unit};
use profivac_dp::link::Baud;
use profivac_host::text_file::{Parsed, baud, usual_baud};
use profivac_station::config::{Gauge, POLL, Segment};
use profivac_vacuum::Gas;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use toml::Spanned;

/// `[[segment]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SegmentToml {
    /// The name, unique in the station.
    pub name: Spanned<String>,
    /// A serial device, a pty, `tcp://host:port`, or `sim:FILE.toml` beside this file.
    pub port: Spanned<String>,
    /// The rate in bit/s. Default: 19200; with `listen-only` the rate that is found by listening.
    #[serde(default)]
    baud: Option<BaudToml>,
    /// `true`: the station sends nothing, because a PLC owns the bus. Default: `false`.
    #[serde(default, rename = "listen-only")]
    pub listen_only: bool,
    /// The address of the station as a master, 0 to 125, which no other station has. Default: 0.
    #[serde(default)]
    pub master: Option<Spanned<u8>>,
    /// A gauge or controller of the segment.
    #[serde(default)]
    pub gauge: Vec<GaugeToml>,
    /// Another slave of the segment, by its GSD file.
    #[serde(default)]
    pub slave: Vec<SlaveToml>,
}

/// `baud`.
#[derive(Debug, Deserialize)]
#[serde(transparent)]
struct BaudToml(#[serde(deserialize_with = "baud")] Baud);

/// `[[segment.gauge]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GaugeToml {
    /// The name, unique in the station.
    pub name: Spanned<String>,
    /// The address on the segment, 0 to 125.
    pub address: Spanned<u8>,
    /// The device: a name that `profivac device list` knows, or a device file beside this file: `my-gauge.toml`.
    pub device: Spanned<String>,
    /// Its tables, once they were found.
    #[serde(skip)]
    pub model: Option<&'static Model>,
    /// The sampling interval, 20 ms to 1 h. Default: `200 ms`.
    pub poll: Option<Spanned<Parsed<TimeSpan>>>,
    /// The gas, for a corrected pressure beside the indicated one.
    gas: Option<Parsed<Gas>>,
    /// With `listen-only`: the octets of Chk_Cfg in hexadecimal, until they are heard.
    pub configuration: Option<Spanned<String>>,
    /// With `listen-only`: the unit of the pressures, until it is heard.
    pub unit: Option<Spanned<String>>,
    /// The first slot in the map of Modbus.
    pub modbus: Option<Spanned<u16>>,
    /// The group by which the overview filters, up to 40 characters.
    pub group: Option<Spanned<String>>,
    /// Up to 16 words by which the overview filters, up to 40 characters each.
    #[serde(default)]
    pub tags: Vec<Spanned<String>>,
    /// Where the gauge is, up to 120 characters.
    pub location: Option<Spanned<String>>,
    /// The day of the last calibration, without quotes: `2026-05-01`.
    pub calibrated: Option<Spanned<toml::Value>>,
    /// How long a calibration is valid: `365 days`.
    #[serde(rename = "calibration-interval")]
    pub calibration_interval: Option<Spanned<String>>,
    /// Pressures that are lines in trends, by name.
    #[serde(default)]
    pub levels: BTreeMap<Spanned<String>, Parsed<Pressure>>,
}

/// The names of all gauges.
pub fn gauge_names(segments: &[SegmentToml]) -> impl Iterator<Item = &str> {
    segments.iter().flat_map(|segment| &segment.gauge).map(|gauge| gauge.name.get_ref().as_str())
}

impl SegmentToml {
    /// The address of the station's master on this segment.
    pub fn master_address(&self) -> u8 {
        self.master.as_ref().map_or(0, |master| *master.get_ref())
    }

    /// The segment of a station's file in `folder`, without its slaves, whose GSD files are read before.
    pub fn into_segment(self, folder: &Path) -> Segment {
        Segment {
            master: self.master_address(),
            name: self.name.into_inner(),
            port: port_in(folder, self.port.into_inner()),
            detects_baud: self.listen_only && self.baud.is_none(),
            listen_only: self.listen_only,
            baud: self.baud.map_or(usual_baud(), |BaudToml(baud)| baud),
            gauges: self.gauge.into_iter().filter_map(GaugeToml::into_gauge).collect(),
            slaves: Vec::new(),
            devices: KnownDevices::BUILT_IN,
        }
    }
}

/// The file of a segment in memory is relative to the folder of the station's file; other ports are as they are.
fn port_in(folder: &Path, port: String) -> String {
    match port.strip_prefix("sim:") {
        Some(file) => format!("sim:{}", folder.join(file).display()),
        None => port,
    }
}

impl GaugeToml {
    /// The configuration that the file names, by the octets of Chk_Cfg in hexadecimal; `None` if the device has no such configuration.
    pub fn configuration(&self) -> Option<&'static Configuration> {
        let octets = hex(self.configuration.as_ref()?.get_ref())?;
        self.model?.configuration(&octets)
    }

    /// The unit that the file names; `None` if the device has no such unit.
    pub fn unit(&self) -> Option<&'static Unit> {
        self.model?.unit_named(self.unit.as_ref()?.get_ref())
    }

    /// The gauge; `None` before its device was found.
    fn into_gauge(self) -> Option<Gauge> {
        Some(Gauge {
            device: self.model?,
            configuration: self.configuration(),
            unit: self.unit(),
            name: self.name.into_inner(),
            address: self.address.into_inner(),
            poll: self.poll.map_or(POLL, |poll| poll.into_inner().0.into()),
            gas: self.gas.map_or(Gas::N2, |gas| gas.0),
            levels: self.levels.into_iter().map(|(name, level)| (name.into_inner(), level.0)).collect(),
        })
    }
}
