//! `[modbus]`, and the key `modbus` of a gauge.

use super::super::error::{ConfigProblem, Located};
use super::super::number_range::NumberRange;
use super::super::values::number;
use crate::time_span::{Listen, TimeSpan};
use profivac_host::text_file::Parsed;
use profivac_station::config::gateways::modbus::{MapUnit, Network, SLOTS, Settings, WordOrder};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::net::Ipv4Addr;
use std::ops::RangeInclusive;
use std::time::Duration;
use toml::Spanned;

/// The default of `listen`: loopback, and a port that needs no privileges.
const LISTEN: (Ipv4Addr, u16) = (Ipv4Addr::LOCALHOST, 1502);

/// The default and the largest number of `connections`. chosen.
const CONNECTIONS: usize = 64;
const MAX_CONNECTIONS: f64 = 1000.0;

/// The default and the range of `idle`. chosen: masters poll every few seconds.
const IDLE: Duration = Duration::from_secs(60);
const IDLE_RANGE: RangeInclusive<Duration> = Duration::from_secs(1)..=Duration::from_secs(3600);

/// `[modbus]` as TOML.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ModbusToml {
    /// The address. Default: `127.0.0.1:1502`.
    listen: Option<Spanned<Parsed<Listen>>>,
    /// The order of the two registers of a value: `high-first` (default) or `low-first`.
    #[serde(default)]
    word_order: WordOrder,
    /// The unit of the second pressure: `pa`, `mbar`, `torr`, `hpa`, `micron`. Default: `mbar`.
    unit: Option<MapUnit>,
    /// The computers that may connect, as addresses or networks; needed beyond loopback.
    #[serde(default)]
    allow: Vec<Parsed<Network>>,
    /// The most connections at the same time, 1 to 1000. Default: 64.
    connections: Option<Spanned<usize>>,
    /// A connection without a request ends after this time, 1 s to 1 h. Default: `60 s`.
    idle: Option<Spanned<Parsed<TimeSpan>>>,
}

impl ModbusToml {
    /// The settings, with the defaults of the keys that are absent, and the slots of the gauges.
    pub fn into_settings(self, slots: BTreeMap<String, u16>) -> Result<Settings, Located> {
        let (span, listen) = match self.listen {
            Some(listen) => (listen.span(), listen.into_inner().0.0),
            None => (0..0, LISTEN.into()),
        };
        if !listen.ip().is_loopback() && self.allow.is_empty() {
            let needs = "allow, a list of the computers that may read, because Modbus has neither encryption nor login";
            return Err(Located::new(span, ConfigProblem::GatewayExposed { gateway: "modbus", listen, needs }));
        }
        if let Some(given) = &self.connections {
            let range = NumberRange::Between(1.0, MAX_CONNECTIONS);
            number(*given.get_ref() as f64, given.span(), "connections", range)?;
        }
        let idle = match self.idle {
            Some(given) if !IDLE_RANGE.contains(&*given.get_ref().0) => {
                return Err(Located::new(given.span(), ConfigProblem::Idle(given.get_ref().0)));
            }
            given => given.map_or(IDLE, |given| given.into_inner().0.into()),
        };
        Ok(Settings {
            listen,
            word_order: self.word_order,
            unit: self.unit.unwrap_or(MapUnit::Mbar),
            allow: self.allow.into_iter().map(|network| network.0).collect(),
            connections: self.connections.map_or(CONNECTIONS, Spanned::into_inner),
            idle,
            slots,
        })
    }
}

/// Checks the slots of the gauges: within the map, and each once.
pub fn check_slots<'a>(
    given: impl Iterator<Item = (&'a str, &'a Spanned<u16>)>,
) -> Result<BTreeMap<String, u16>, Located> {
    let mut slots: BTreeMap<String, u16> = BTreeMap::new();
    for (gauge, slot) in given {
        let wanted = *slot.get_ref();
        let range = NumberRange::Between(0.0, f64::from(SLOTS - 1));
        number(wanted.into(), slot.span(), "a slot", range)?;
        if let Some((other, _)) = slots.iter().find(|(_, taken)| **taken == wanted) {
            let problem = ConfigProblem::SlotInUse { slot: wanted, gauge: other.clone() };
            return Err(Located::new(slot.span(), problem));
        }
        slots.insert(gauge.to_owned(), wanted);
    }
    Ok(slots)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_network_contains_its_computers() {
        let contains = |network: &str, peer: &str| network.parse::<Network>().unwrap().contains(peer.parse().unwrap());
        assert!(contains("192.168.1.0/24", "192.168.1.200") && !contains("192.168.1.0/24", "192.168.2.1"));
        assert!(contains("10.0.0.5", "10.0.0.5") && contains("10.0.0.5", "::ffff:10.0.0.5"));
        assert!(!contains("10.0.0.5", "10.0.0.6") && !contains("10.0.0.0/8", "::1"));
        assert!(contains("0.0.0.0/0", "8.8.8.8") && contains("fe80::/10", "fe80::1"));
        for wrong in ["", "10.0.0", "10.0.0.0/33", "10.0.0.0/x", "name"] {
            assert!(wrong.parse::<Network>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn the_units_have_the_same_pressure() {
        assert_eq!(
            (MapUnit::Pa.of_pa(100.0), MapUnit::Mbar.of_pa(100.0), MapUnit::Hpa.of_pa(100.0)),
            (100.0, 1.0, 1.0)
        );
        assert!((MapUnit::Torr.of_pa(133.322_368) - 1.0).abs() < 1e-6);
        assert!((MapUnit::Micron.of_pa(133.322_368) - 1000.0).abs() < 1e-3);
    }
}
