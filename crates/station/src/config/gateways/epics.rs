//! The settings of the gateway for EPICS.

use super::write::Write;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::net::Ipv4Addr;

/// The places that `name` may have.
pub const PLACES: [&str; 8] = ["prefix", "station", "segment", "gauge", "GAUGE", "address", "device", "channel"];

/// The longest name of a record, in characters: `PVNAME_STRINGSZ` of EPICS base without its end mark.
pub const MAX_NAME: usize = 60;

/// The units and their size in Pa, in lower case.
const UNITS: [(&str, f64); 9] = [
    ("pa", 1.0),
    ("hpa", 100.0),
    ("kpa", 1000.0),
    ("mbar", 100.0),
    ("bar", 1e5),
    ("ubar", 0.1),
    ("torr", TORR),
    ("mtorr", TORR / 1000.0),
    ("micron", TORR / 1000.0),
];

/// One torr in Pa: the 760th part of the standard atmosphere.
const TORR: f64 = 101_325.0 / 760.0;

/// A network interface at which the gateway listens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interface {
    /// Its address; 0.0.0.0 stands for all.
    pub address: Ipv4Addr,
    /// The broadcast address of its network, if the file gives the length of its prefix.
    pub broadcast: Option<Ipv4Addr>,
}

/// The value of a pressure whose reading has none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OnInvalid {
    /// Not a number.
    #[default]
    Nan,
    /// The last value; the severity tells that it is old.
    Hold,
}

/// The states of a reading whose severity a site may set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ReadingState {
    /// Below the range.
    Underrange,
    /// Above the range.
    Overrange,
    /// Switched off.
    Off,
    /// Being brought into data exchange.
    Starting,
    /// The gauge declares its number invalid.
    Invalid,
    /// No gauge is connected to the channel.
    NotPresent,
    /// No data, or the last ones are too old.
    Gap,
    /// The gauge reports a defect.
    Fault,
}

/// The severity of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// `NO_ALARM`.
    None,
    /// `MINOR`.
    Minor,
    /// `MAJOR`.
    Major,
    /// `INVALID`.
    Invalid,
}

/// The names that a facility gives to signals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Preset {
    /// ISIS Neutron and Muon Source.
    Isis,
    /// Diamond Light Source.
    Dls,
    /// NSLS-II.
    Nsls2,
    /// LCLS.
    Lcls,
    /// European Spallation Source.
    Ess,
    /// Sirius.
    Sirius,
}

/// The settings of the EPICS gateway.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    /// The port of Channel Access; `None` if it is switched off.
    pub ca_port: Option<u16>,
    /// The ports of PV Access for circuits and for search; `None` if it is switched off.
    pub pva_ports: Option<(u16, u16)>,
    /// Where it listens.
    pub interfaces: Vec<Interface>,
    /// The template of the names of gauges.
    pub name: String,
    /// What all names begin with.
    pub prefix: String,
    /// The unit of pressures, as the site spells it.
    pub unit: String,
    /// The value of a pressure whose reading has none.
    pub on_invalid: OnInvalid,
    /// Severities that differ from the default.
    pub severities: BTreeMap<ReadingState, Severity>,
    /// The names that a facility gives to signals.
    pub preset: Option<Preset>,
    /// Names of signals, by the key of the signal; they precede those of the preset.
    pub signals: BTreeMap<String, String>,
    /// Further names: what they stand for, as `gauge.signal`, by name.
    pub aliases: BTreeMap<String, String>,
    /// As which user clients write; `None` if they only read.
    pub write: Option<Write>,
}

impl Settings {
    /// The size of its unit in Pa.
    #[must_use]
    pub fn unit_pa(&self) -> f64 {
        size_of(&self.unit).unwrap_or(1.0)
    }

    /// Whether other computers reach the gateway, for which the protocols have no login.
    #[must_use]
    pub fn is_open_to_network(&self) -> bool {
        self.interfaces.iter().any(|interface| !interface.address.is_loopback())
    }

    /// The addresses at which it listens.
    #[must_use]
    pub fn addresses(&self) -> String {
        self.interfaces.iter().map(|interface| interface.address.to_string()).collect::<Vec<_>>().join(", ")
    }
}

/// The size of a unit in Pa; `None` if it is none of pressure.
#[must_use]
pub fn size_of(unit: &str) -> Option<f64> {
    let unit = unit.to_lowercase();
    UNITS.iter().find(|(name, _)| *name == unit).map(|(_, pa)| *pa)
}
