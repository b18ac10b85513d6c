//! Checks of segments, gauges and host names.

use super::error::{AddressUser, ConfigProblem, Located, NamedItem};
use super::file::ConfigToml;
use super::names::{self, unique};
use super::segments::{GaugeToml, SegmentToml};
use crate::time_span::TimeSpan;
use profivac_host::text_file::Parsed;
use profivac_listen::Hex;
use profivac_web_server::host_name::host;
use std::collections::HashSet;
use std::net::IpAddr;
use std::ops::RangeInclusive;
use std::time::Duration;
use toml::Spanned;

/// The highest address of a master, and of a slave that can be parameterised.
const MAX_ADDRESS: u8 = 125;

/// The range of sampling intervals.
const POLL_RANGE: RangeInclusive<Duration> = Duration::from_millis(20)..=Duration::from_secs(3600);

/// Checks what the type of a single value does not express.
pub fn check(file: &ConfigToml) -> Result<(), Located> {
    if file.segment.is_empty() {
        return Err(Located::new(0..0, ConfigProblem::NoSegment));
    }
    file.station.hosts.iter().try_for_each(check_host)?;
    file.station.name.as_ref().map_or(Ok(()), |name| names::check(NamedItem::Station, name))?;
    unique(NamedItem::Segment, file.segment.iter().map(|segment| &segment.name))?;
    unique(NamedItem::Port, file.segment.iter().map(|segment| &segment.port))?;
    unique(NamedItem::Gauge, file.segment.iter().flat_map(names_of))?;
    file.segment.iter().try_for_each(check_segment)
}

/// The names of gauges and other slaves: the views and the gateways have one list of both.
fn names_of(segment: &SegmentToml) -> impl Iterator<Item = &Spanned<String>> {
    segment.gauge.iter().map(|gauge| &gauge.name).chain(segment.slave.iter().map(|slave| &slave.name))
}

/// Host names have no port, because certificates have none.
fn check_host(name: &Spanned<String>) -> Result<(), Located> {
    let text = name.get_ref();
    let is_host = !text.is_empty() && host(text).as_deref() == Some(text);
    if is_host || text.parse::<IpAddr>().is_ok() {
        return Ok(());
    }
    Err(Located::new(name.span(), ConfigProblem::HostName(text.clone())))
}

fn check_segment(segment: &SegmentToml) -> Result<(), Located> {
    let master_address = segment.master_address();
    let mut used = HashSet::from([master_address]);
    if let Some(master) = segment.master.as_ref().filter(|master| *master.get_ref() > MAX_ADDRESS) {
        return Err(Located::new(master.span(), ConfigProblem::MasterAddress(*master.get_ref())));
    }
    if let Some(master) = segment.master.as_ref().filter(|_| segment.listen_only) {
        return Err(Located::new(master.span(), ConfigProblem::MasterOfListener));
    }
    if segment.listen_only {
        used.clear();
    }
    for gauge in &segment.gauge {
        check_gauge(gauge)?;
        check_declared(gauge, segment.listen_only)?;
    }
    segment.slave.iter().try_for_each(|slave| check_slave(&slave.address, slave.poll.as_ref()))?;
    let addresses = segment.gauge.iter().map(|gauge| &gauge.address);
    for given in addresses.chain(segment.slave.iter().map(|slave| &slave.address)) {
        let address = *given.get_ref();
        if !used.insert(address) {
            let user = if address == master_address { AddressUser::Master } else { AddressUser::Gauge };
            return Err(Located::new(given.span(), ConfigProblem::AddressInUse { address, user }));
        }
    }
    Ok(())
}

/// Checks address and sampling interval, which gauges and other slaves have.
fn check_slave(address: &Spanned<u8>, poll: Option<&Spanned<Parsed<TimeSpan>>>) -> Result<(), Located> {
    if *address.get_ref() > MAX_ADDRESS {
        return Err(Located::new(address.span(), ConfigProblem::SlaveAddress(*address.get_ref())));
    }
    match poll {
        Some(poll) if !POLL_RANGE.contains(&*poll.get_ref().0) => {
            Err(Located::new(poll.span(), ConfigProblem::PollInterval(poll.get_ref().0)))
        }
        _ => Ok(()),
    }
}

fn check_gauge(gauge: &GaugeToml) -> Result<(), Located> {
    check_slave(&gauge.address, gauge.poll.as_ref())?;
    gauge.levels.keys().try_for_each(|level| names::check(NamedItem::Level, level))
}

/// Checks `configuration` and `unit`.
fn check_declared(gauge: &GaugeToml, listen_only: bool) -> Result<(), Located> {
    let given = [("configuration", &gauge.configuration), ("unit", &gauge.unit)];
    for (key, value) in given {
        if let Some(value) = value.as_ref().filter(|_| !listen_only) {
            return Err(Located::new(value.span(), ConfigProblem::OnlyForListening(key)));
        }
    }
    let Some(model) = gauge.model else { return Ok(()) };
    let device = model.name;
    if let Some(found) = gauge.configuration.as_ref().filter(|_| gauge.configuration().is_none()) {
        let known = model.configurations.iter().map(|it| Hex(it.octets).to_string()).collect::<Vec<_>>().join(", ");
        let found_text = found.get_ref().clone();
        return Err(Located::new(
            found.span(),
            ConfigProblem::UnknownConfiguration { device, found: found_text, known },
        ));
    }
    if let Some(found) = gauge.unit.as_ref().filter(|_| gauge.unit().is_none()) {
        let known = model.units.iter().map(|unit| unit.name).collect::<Vec<_>>().join(", ");
        let found_text = found.get_ref().clone();
        return Err(Located::new(found.span(), ConfigProblem::UnknownUnit { device, found: found_text, known }));
    }
    Ok(())
}
