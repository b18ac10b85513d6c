//! `profivac scan`: finds the stations of a bus.

use crate::bus::BusOptions;
use crate::failure::Failure;
use crate::output::{json, notice, notices, out};
use clap::Args;
use profivac_client::identify::device_names;
use profivac_host::scan::{FoundStation, SlaveStatus, probe_all};
use profivac_host::session::BusSession;
use profivac_wire::control::StationType;
use serde::Serialize;

/// Find the stations of a bus: a map of the addresses, and the identity and state of each slave.
///
/// The command asks every address for its FDL status and every slave for its diagnosis; it never sends Set_Prm. On a line with
/// another master it joins the token ring: read docs/adapters.md before you use it beside a PLC, or listen with `profivac sniff`, which
/// sends nothing.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    bus: BusOptions,
    /// Print JSON instead of map and table
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  profivac scan --port /dev/ttyUSB0
  profivac scan --port /tmp/line --hsa 20
  profivac scan --port tcp://127.0.0.1:4000 --json";

/// Asks every address and prints the stations that answered. A bus without an answer is a failure.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let bus = &arguments.bus;
    let mut session = bus.open()?;
    let mut seen = Vec::new();
    let others = (0..=bus.hsa()).filter(|address| *address != bus.master());
    let looked = probe_all(&mut session, others, &mut seen).map_err(Failure::from);
    notices(|| session.next_notice());
    let looked = looked.and_then(|()| add_station_at_own_address(bus, session, &mut seen));
    if arguments.json {
        let rows: Vec<_> = seen.iter().map(Row::of).collect();
        out(&json(&rows));
    } else if looked.is_ok() || !seen.is_empty() {
        out(&map(&seen, bus.master(), bus.hsa()));
        if !seen.is_empty() {
            out(&table(&seen));
        }
    }
    // The stations found before the line was lost, or a signal came, have been printed.
    looked?;
    if seen.is_empty() {
        return Err(Failure::no_answer(format!("no station answers on {}", bus.port())));
    }
    Ok(())
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
}

impl Row {
    /// A station as the JSON output shows it.
    pub fn of(seen: &FoundStation) -> Self {
        Self {
            address: seen.address,
            kind: kind(seen.station_type),
            ident: seen.slave.map(|slave| format!("0x{:04X}", slave.ident)),
            devices: seen.slave.map(|slave| device_names(slave.ident)).unwrap_or_default(),
            state: seen.slave.map(|slave| slave.state_text()),
            owner: seen.slave.and_then(|slave| slave.owner),
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
fn table(seen: &[FoundStation]) -> String {
    let header = format!("{:>4}  {:<8}{:<8}{:<10}{:<36}{}\n", "ADDR", "KIND", "IDENT", "OWNER", "STATE", "DEVICE");
    seen.iter().fold(header, |text, station| text + &line(station)).trim_end().to_owned()
}

fn line(seen: &FoundStation) -> String {
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
    let devices = device_names(slave.ident).join(" or ");
    let devices = if devices.is_empty() { "unknown" } else { &devices };
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
        assert_eq!(table(&[slave(5), silent]), expected);
    }
}
