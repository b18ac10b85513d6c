//! `[[segment]]` and `[[segment.gauge]]`.

use super::{Gauge, Segment};
use profivac_client::pressure::Pressure;
use profivac_dp::link::Baud;
use profivac_host::text_file::{Parsed, baud, usual_baud};
use profivac_vacuum::Gas;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::time::Duration;
use toml::Spanned;

/// The default of `poll`.
pub const POLL: Duration = Duration::from_millis(200);

/// `[[segment]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SegmentToml {
    pub name: Spanned<String>,
    pub port: Spanned<String>,
    #[serde(default = "usual_baud", deserialize_with = "baud")]
    baud: Baud,
    #[serde(default)]
    pub master: Option<Spanned<u8>>,
    #[serde(default)]
    pub gauge: Vec<GaugeToml>,
}

/// `[[segment.gauge]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GaugeToml {
    pub name: Spanned<String>,
    pub address: Spanned<u8>,
    pub device: Spanned<String>,
    pub poll: Option<Spanned<Parsed<humantime::Duration>>>,
    gas: Option<Parsed<Gas>>,
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

    pub fn into_segment(self) -> Segment {
        Segment {
            master: self.master_address(),
            name: self.name.into_inner(),
            port: self.port.into_inner(),
            baud: self.baud,
            gauges: self.gauge.into_iter().map(GaugeToml::into_gauge).collect(),
        }
    }
}

impl GaugeToml {
    fn into_gauge(self) -> Gauge {
        Gauge {
            name: self.name.into_inner(),
            address: self.address.into_inner(),
            device: self.device.into_inner(),
            poll: self.poll.map_or(POLL, |poll| poll.into_inner().0.into()),
            gas: self.gas.map_or(Gas::N2, |gas| gas.0),
            levels: self.levels.into_iter().map(|(name, level)| (name.into_inner(), level.0)).collect(),
        }
    }
}
