//! `profivac scan`: finds the stations of a bus.

use crate::bus::{BusOptions, present_cfg};
use crate::device_files::names_with_ident;
use crate::failure::Failure;
use crate::gsd_slaves::GsdOptions;
use crate::output::{json, notice, notices, out, visible};
use clap::Args;
use profivac_client::values::hex;
use profivac_gsd_slave::{Catalog, Entry, GsdSlave};
use profivac_host::scan::{FoundStation, SlaveStatus, probe_all};
use profivac_host::session::BusSession;
use profivac_wire::control::StationType;
use serde::Serialize;
use std::collections::BTreeMap;

/// Find the stations of a bus: a map of the addresses, and the identity and state of each slave.
///
/// The command asks every address for its FDL status and every slave for its diagnosis; it never sends Set_Prm. On a line with
/// another master it joins the token ring: read docs/adapters.md before you use it beside a PLC, or listen with `profivac sniff`, which
/// sends nothing. With --gsd it names slaves of any vendor; if several GSD files have the ident number of a slave, it asks the slave for
/// its configuration and names the devices whose modules fit.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    bus: BusOptions,
    #[command(flatten)]
    gsd: GsdOptions,
    /// Print JSON instead of map and table
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  profivac scan --port /dev/ttyUSB0
  profivac scan --port /tmp/line --hsa 20
  profivac scan --port /dev/ttyUSB0 --gsd gsd_files
  profivac scan --port tcp://127.0.0.1:4000 --json
  profivac scan --port /tmp/line --device-files my-gauge.toml";

/// Asks every address and prints the stations that answered. A bus without an answer is a failure.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let bus = &arguments.bus;
    let catalog = arguments.gsd.read()?;
    let mut session = bus.open()?;
    let mut seen = Vec::new();
    let others = (0..=bus.hsa()).filter(|address| *address != bus.master());
    let looked = probe_all(&mut session, others, &mut seen).map_err(Failure::from);
    let configurations = configurations(&mut session, &catalog, &seen);
    notices(|| session.next_notice());
    let looked = looked.and_then(|()| add_station_at_own_address(bus, session, &mut seen));
    let by_gsd = ByGsd { catalog: &catalog, configurations };
    if arguments.json {
        let rows: Vec<_> = seen.iter().map(|station| by_gsd.row(station)).collect();
        out(&json(&rows));
    } else if looked.is_ok() || !seen.is_empty() {
        out(&map(&seen, bus.master(), bus.hsa()));
        if !seen.is_empty() {
            out(&table(&seen, &by_gsd));
        }
        seen.iter().filter_map(|station| by_gsd.remark(station)).for_each(|remark| notice(&remark));
    }
    // The stations found before the line was lost, or a signal came, have been printed.
    looked?;
    if seen.is_empty() {
        return Err(Failure::no_answer(format!("no station answers on {}", bus.port())));
    }
    Ok(())
}

/// The answers to Get_Cfg of the slaves whose ident belongs to several devices of the files. A slave that does not answer, or a line that
/// is lost, leaves all of them possible.
fn configurations(session: &mut BusSession, catalog: &Catalog, seen: &[FoundStation]) -> BTreeMap<u8, Vec<u8>> {
    let is_unclear =
        |station: &&FoundStation| station.slave.is_some_and(|slave| catalog.by_ident(slave.ident).len() > 1);
    let addresses: Vec<_> = seen.iter().filter(is_unclear).map(|station| station.address).collect();
    let ask = |address: u8| Some((address, present_cfg(session, address).ok()??));
    addresses.into_iter().filter_map(ask).collect()
}

/// The devices of the GSD files that a slave can be.
struct ByGsd<'a> {
    catalog: &'a Catalog,
    /// The configurations of slaves whose ident belongs to several devices, by address.
    configurations: BTreeMap<u8, Vec<u8>>,
}

impl ByGsd<'_> {
    fn entries(&self, station: &FoundStation) -> Vec<&Entry> {
        let Some(slave) = station.slave else { return Vec::new() };
        match self.configurations.get(&station.address) {
            Some(octets) => self.catalog.narrowed(slave.ident, octets),
            None => self.catalog.by_ident(slave.ident).iter().collect(),
        }
    }

    fn row(&self, station: &FoundStation) -> Row {
        let device = |entry: &Entry| {
            let general = &entry.device().general;
            GsdDevice {
                vendor: general.vendor_name.clone(),
                model: general.model_name.clone(),
                file: entry.path.display().to_string(),
            }
        };
        let entries = self.entries(station);
        let is_narrowed = station.slave.is_some_and(|slave| entries.len() < self.catalog.by_ident(slave.ident).len());
        Row {
            gsd: entries.into_iter().map(device).collect(),
            narrowed_by: self.configurations.get(&station.address).filter(|_| is_narrowed).map(|octets| hex(octets)),
            ..Row::of(station)
        }
    }

    /// Vendor, model and file of each device.
    fn names(&self, station: &FoundStation) -> String {
        let name = |entry: &Entry| {
            let file = entry.path.file_name().unwrap_or_default().display();
            visible(&format!("{} ({file})", entry.name()))
        };
        self.entries(station).into_iter().map(name).collect::<Vec<_>>().join(" or ")
    }

    /// What is known of a slave whose ident belongs to several devices.
    fn remark(&self, station: &FoundStation) -> Option<String> {
        let slave = station.slave?;
        let (all, left) = (self.catalog.by_ident(slave.ident).len(), self.entries(station).len());
        if all < 2 {
            return None;
        }
        let result = match self.configurations.get(&station.address) {
            None => "the slave does not answer Get_Cfg, so all of them are possible".to_owned(),
            Some(octets) if left < all => {
                let devices = if left == 1 { "one device" } else { "the named devices" };
                format!("only {devices} can have its configuration {}", hex(octets))
            }
            Some(octets) if left == all && self.fits(slave.ident, octets) => {
                format!("all of them can have its configuration {}; compare the label of the slave", hex(octets))
            }
            Some(octets) => format!("none of them can have its configuration {}; look for another file", hex(octets)),
        };
        Some(format!(
            "address {}: {all} devices of the GSD files have the ident 0x{:04X}; {result}",
            station.address, slave.ident
        ))
    }

    fn fits(&self, ident: u16, octets: &[u8]) -> bool {
        self.catalog.by_ident(ident).iter().any(|entry| GsdSlave::by_chk_cfg(&entry.file, octets).is_ok())
    }
}

/// Adds the station that has the address of this master too, with a notice.
fn add_station_at_own_address(
    bus: &BusOptions,
    session: BusSession,
    seen: &mut Vec<FoundStation>,
) -> Result<(), Failure> {
    let Some(station) = bus.station_at_own_address(session, seen)? else { return Ok(()) };
    notice(&format_args!(
        "{} answers at address {}, which this master used: give the master another address with --master N",
        if station.station_type == StationType::Slave { "a slave" } else { "another master" },
        station.address
    ));
    seen.push(station);
    seen.sort_by_key(|station| station.address);
    Ok(())
}

/// A station in the JSON output.
#[derive(Debug, Serialize)]
pub struct Row {
    address: u8,
    kind: &'static str,
    ident: Option<String>,
    /// The names of the device in profivac; several devices may share an ident number.
    devices: Vec<&'static str>,
    state: Option<String>,
    /// The master that owns the slave.
    owner: Option<u8>,
    /// The devices of the GSD files that the slave can be.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    gsd: Vec<GsdDevice>,
    /// The configuration, in hex, by which other devices with this ident were left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    narrowed_by: Option<String>,
}

/// A device of a GSD file in the JSON output.
#[derive(Debug, Serialize)]
struct GsdDevice {
    vendor: Option<String>,
    model: Option<String>,
    file: String,
}

impl Row {
    /// A station as the JSON output shows it.
    pub fn of(seen: &FoundStation) -> Self {
        Self {
            address: seen.address,
            kind: kind(seen.station_type),
            ident: seen.slave.map(|slave| format!("0x{:04X}", slave.ident)),
            devices: seen.slave.map(|slave| names_with_ident(slave.ident)).unwrap_or_default(),
            state: seen.slave.map(|slave| slave.state_text()),
            owner: seen.slave.and_then(|slave| slave.owner),
            gsd: Vec::new(),
            narrowed_by: None,
        }
    }
}

const fn kind(station: StationType) -> &'static str {
    match station {
        StationType::Slave => "slave",
        StationType::MasterNotReady => "master, not ready",
        StationType::MasterReady => "master, ready for the ring",
        StationType::MasterInRing => "master",
    }
}

/// A map with ten addresses per line: `S` slave, `M` master, `*` this master, `.` no station.
fn map(seen: &[FoundStation], own: u8, hsa: u8) -> String {
    let mark = |address: u8| match seen.iter().find(|seen| seen.address == address) {
        Some(FoundStation { station_type: StationType::Slave, .. }) => 'S',
        Some(_) => 'M',
        None if address == own => '*',
        None => '.',
    };
    let mut text = "      0 1 2 3 4 5 6 7 8 9\n".to_owned();
    for first in (0..=hsa).step_by(10) {
        let marks: Vec<_> =
            (first..=hsa.min(first.saturating_add(9))).map(|address| mark(address).to_string()).collect();
        text.push_str(&format!("{first:>4}  {}\n", marks.join(" ")));
    }
    text + "S slave, M master, * this master, . no station\n"
}

/// A line for each station. The names of the devices are last, because several may share an ident number.
fn table(seen: &[FoundStation], by_gsd: &ByGsd<'_>) -> String {
    let header = format!("{:>4}  {:<8}{:<8}{:<10}{:<36}{}\n", "ADDR", "KIND", "IDENT", "OWNER", "STATE", "DEVICE");
    seen.iter().fold(header, |text, station| text + &line(station, &by_gsd.names(station))).trim_end().to_owned()
}

/// `by_gsd` are the devices of GSD files; they name a slave that profivac does not know.
fn line(seen: &FoundStation, by_gsd: &str) -> String {
    let FoundStation { address, station_type: station, slave } = seen;
    let Some(slave) = slave else {
        let (kind, state) = match station {
            StationType::Slave => ("slave", "no valid diagnosis"),
            StationType::MasterNotReady | StationType::MasterReady | StationType::MasterInRing => {
                ("master", kind(*station))
            }
        };
        return format!("{address:>4}  {kind:<8}{:<8}{:<10}{state:<36}-\n", "-", "-");
    };
    let SlaveStatus { ident, owner, .. } = slave;
    let devices = names_with_ident(slave.ident).join(" or ");
    let devices = match (devices.as_str(), by_gsd) {
        ("", "") => "unknown",
        ("", by_gsd) => by_gsd,
        (devices, _) => devices,
    };
    let owner = owner.map_or_else(|| "none".to_owned(), |owner| format!("master {owner}"));
    format!("{address:>4}  {:<8}0x{ident:04X}  {owner:<10}{:<36}{devices}\n", "slave", slave.state_text())
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_wire::diag::StationStatus;

    fn slave(address: u8) -> FoundStation {
        let slave = SlaveStatus { ident: 0x08E6, status: StationStatus::empty(), owner: Some(2) };
        FoundStation { address, station_type: StationType::Slave, slave: Some(slave) }
    }

    #[test]
    fn the_map_has_a_mark_for_every_address() {
        let master = FoundStation { address: 2, station_type: StationType::MasterInRing, slave: None };
        let expected = "      0 1 2 3 4 5 6 7 8 9\n   0  * . M . . S . . . .\n  10  . . .\nS slave, M master, * this master, . no station\n";
        assert_eq!(map(&[master, slave(5)], 0, 12), expected);
        assert!(map(&[], 0, 126).contains("\n 120  . . . . . . .\n"));
    }

    #[test]
    fn the_table_shows_the_device_and_the_owner_of_a_slave() {
        let silent = FoundStation { slave: None, ..slave(7) };
        let expected = "\
ADDR  KIND    IDENT   OWNER     STATE                               DEVICE
   5  slave   0x08E6  master 2  exchanges data                      bcg450
   7  slave   -       -         no valid diagnosis                  -";
        let none = ByGsd { catalog: &Catalog::default(), configurations: BTreeMap::new() };
        assert_eq!(table(&[slave(5), silent], &none), expected);
    }
}
