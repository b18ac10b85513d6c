//! The settings of the gateway for Modbus TCP.

use profivac_client::pressure::Pressure;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt;
use std::net::{IpAddr, SocketAddr};
use std::str::FromStr;
use std::time::Duration;

/// The number of slots of the map, see docs/gateways.md.
pub const SLOTS: u16 = 495;

/// The order of the two registers of a 32-bit value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum WordOrder {
    /// The high half first.
    #[default]
    HighFirst,
    /// The low half first.
    LowFirst,
}

/// The unit of the second pressure of a slot, with its code in the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MapUnit {
    /// Pascal.
    Pa = 0,
    /// Millibar.
    Mbar = 1,
    /// Torr.
    Torr = 2,
    /// Hectopascal.
    Hpa = 3,
    /// Micron: a thousandth of a Torr.
    Micron = 4,
}

impl MapUnit {
    /// A pressure in this unit.
    #[must_use]
    pub fn of_pa(self, pa: f64) -> f64 {
        let pressure = Pressure::from_pa(pa);
        match self {
            Self::Pa => pa,
            Self::Mbar | Self::Hpa => pressure.mbar(),
            Self::Torr => pressure.torr(),
            Self::Micron => pressure.torr() * 1e3,
        }
    }

    /// Its symbol.
    #[must_use]
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::Pa => "Pa",
            Self::Mbar => "mbar",
            Self::Torr => "Torr",
            Self::Hpa => "hPa",
            Self::Micron => "micron",
        }
    }
}

/// Computers that may connect: an address, or a network like `192.168.1.0/24`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Network {
    address: IpAddr,
    prefix: u8,
}

impl Network {
    /// The computers whose address begins with the first `prefix` bits of this one.
    #[must_use]
    pub const fn of(address: IpAddr, prefix: u8) -> Self {
        Self { address, prefix }
    }

    /// Whether this computer belongs to it. An IPv4 address that is mapped into IPv6 counts as IPv4.
    #[must_use]
    pub fn contains(self, peer: IpAddr) -> bool {
        match (self.address, peer.to_canonical()) {
            (IpAddr::V4(own), IpAddr::V4(peer)) => {
                let mask = u32::MAX.checked_shl(u32::from(32_u8.saturating_sub(self.prefix))).unwrap_or_default();
                own.to_bits() & mask == peer.to_bits() & mask
            }
            (IpAddr::V6(own), IpAddr::V6(peer)) => {
                let mask = u128::MAX.checked_shl(u32::from(128_u8.saturating_sub(self.prefix))).unwrap_or_default();
                own.to_bits() & mask == peer.to_bits() & mask
            }
            _ => false,
        }
    }
}

/// A text that is neither an address nor a network.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected an address like 192.168.1.5 or a network like 192.168.1.0/24, found {0:?}")]
pub struct NetworkError(String);

impl FromStr for Network {
    type Err = NetworkError;

    fn from_str(text: &str) -> Result<Self, NetworkError> {
        let problem = || NetworkError(text.to_owned());
        let (address, prefix) = text.split_once('/').map_or((text, None), |(address, prefix)| (address, Some(prefix)));
        let address: IpAddr = address.parse().map_err(|_| problem())?;
        let longest = if address.is_ipv4() { 32 } else { 128 };
        let prefix = prefix.map_or(Ok(longest), str::parse).map_err(|_| problem())?;
        if prefix <= longest { Ok(Self { address, prefix }) } else { Err(problem()) }
    }
}

impl fmt::Display for Network {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}/{}", self.address, self.prefix)
    }
}

/// The settings of the Modbus gateway.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    /// The address at which it listens.
    pub listen: SocketAddr,
    /// The order of the registers of a 32-bit value.
    pub word_order: WordOrder,
    /// The unit of the second pressure of a slot.
    pub unit: MapUnit,
    /// The computers that may connect, besides this one.
    pub allow: Vec<Network>,
    /// The most connections at the same time.
    pub connections: usize,
    /// The longest time without a request.
    pub idle: Duration,
    /// The first slot of each gauge that the file gives one.
    pub slots: BTreeMap<String, u16>,
}
