//! The slaves of a line beside their GSD files.

use super::Finding;
use crate::device_files::known;
use crate::output::visible;
use profivac_dp::link::Baud;
use profivac_explain::gsd::{Extent, Seen};
use profivac_listen::Observer;
use profivac_listen::station::Station;

/// What the traffic of each slave says otherwise than its GSD file, and which device it is. `baud` is the rate if the line or the recording
/// shows it.
pub fn findings(observer: &Observer, baud: Option<Baud>) -> Vec<Finding> {
    let all = observer.stations().flat_map(|(address, station)| of_slave(address, station, baud));
    // The texts of a file can have control characters.
    all.map(|finding| Finding { found: visible(&finding.found), ..finding }).collect()
}

fn of_slave(address: u8, station: &Station, baud: Option<Baud>) -> Vec<Finding> {
    let Some(ident) = station.knowledge.ident() else { return Vec::new() };
    let described = &station.described;
    if !described.is_known() {
        let is_gauge = known().knows(ident);
        let unknown = Finding::note(
            format!("slave {address}: no GSD file of --gsd has the ident {ident:04X}"),
            "get the file from the vendor of the slave, and name it or its folder with --gsd",
        );
        return if is_gauge { Vec::new() } else { vec![unknown] };
    }
    let modules = described.modules_text(Extent::Changes);
    let modules = if modules.is_empty() { "no Chk_Cfg was received".to_owned() } else { modules };
    let names = described.names();
    let device = format!("slave {address}: {}, {modules}", described.names_text());
    let mut findings = vec![match names.len() {
        1 => Finding::good(device),
        _ => Finding::note(device, "name only the GSD file of the installed device with --gsd"),
    }];
    let seen = Seen {
        bits_per_second: baud.map(Baud::bits_per_second),
        set_prm: &station.set_prm,
        diagnosis: &station.diagnosis_octets,
        longest_tsdr: station.longest_tsdr,
    };
    let mismatches = described.mismatches(&seen).into_iter();
    findings.extend(mismatches.map(|one| Finding::bad_port(format!("slave {address}: {}", one.found), one.next)));
    let reports = station.diagnoses.back().map(|last| last.reports.as_slice()).unwrap_or_default();
    if !reports.is_empty() {
        findings.push(Finding::note(
            format!("slave {address}: its diagnosis reports {}", reports.join("; ")),
            "the manual of the slave says what to do",
        ));
    }
    findings
}
