//! A file: of a station, a segment, a gauge, a database, recorded traffic.

use super::{Finding, database, slaves, station};
use crate::explanation::counted;
use crate::gsd_files::{Peeked, is_gsd};
use crate::output::visible;
use profivac_client::settings::SettingsFile;
use profivac_dp::link::Baud;
use profivac_explain::divider::Divider;
use profivac_explain::frame::TimeSource;
use profivac_explain::gsd::Files;
use profivac_explain::input::{Source, SourceKind};
use profivac_listen::Observer;
use profivac_listen::report::BusReport;
use profivac_virtual::open;
use profivac_virtual::scenario::Scenario;
use std::fs::{self, File};
use std::io::{ErrorKind, Read};
use std::path::Path;
use std::sync::Arc;

/// The first octets of a SQLite database. SQLite, database file format, 1.3.1.
const SQLITE: &[u8] = b"SQLite format 3\0";

/// Capture files without a rate are read at this one; it decides about nothing but times.
const ANY_RATE: Baud = Baud::B19200;

/// The findings about a file.
pub fn check(path: &Path, files: &Files) -> Vec<Finding> {
    let mut first = [0; SQLITE.len()];
    let read = File::open(path).and_then(|mut file| file.read(&mut first));
    match read {
        Err(error) => vec![unreadable(path, &error)],
        Ok(_) if first == SQLITE => database::check(path, |_| None),
        Ok(_) if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml")) => toml(path),
        Ok(_) if has_gsd_head(path) => gsd(path),
        Ok(_) => traffic(path, files),
    }
}

fn unreadable(path: &Path, error: &std::io::Error) -> Finding {
    let next = match error.kind() {
        ErrorKind::NotFound => {
            "check the name; `profivac init --port PORT --out plant.toml` writes the file of a station"
        }
        ErrorKind::PermissionDenied => "run the command as the user who owns it, or change its permissions",
        _ => "check the name",
    };
    Finding::bad_file(format!("{} cannot be read: {error}", path.display()), next)
}

/// The kinds of TOML files of profivac, by a line that only they have.
fn toml(path: &Path) -> Vec<Finding> {
    let text = match fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) => return vec![unreadable(path, &error)],
    };
    let has = |table: &str| text.lines().any(|line| line.trim() == table);
    if has("[[segment]]") || has("[station]") {
        return station::check(path);
    }
    let next = "correct this position; docs/scenarios.md and docs/station.md describe the files";
    if has("[settings]") {
        return vec![match SettingsFile::parse(&text) {
            Ok(_) => Finding::good("settings of a gauge; `profivac diff` compares them with a gauge"),
            Err(error) => Finding::bad_file(format!("settings of a gauge: {error}"), next),
        }];
    }
    if has("[postgres]") {
        return vec![Finding::note(
            "the file of an archive",
            format!("`profivac archive {} --check` checks it", path.display()),
        )];
    }
    if text.lines().any(|line| line.trim_start().starts_with("devices")) {
        let port = format!("sim:{}", path.display());
        return vec![match open::port(&port, ANY_RATE) {
            Ok(_) => Finding::good(format!("a segment in memory; `--port {port}` uses it")),
            Err(error) => Finding::bad_file(error.to_string(), next),
        }];
    }
    vec![match Scenario::read(path) {
        Ok(scenario) => Finding::good(format!("a scenario with {} gauges", scenario.specs().count())),
        Err(error) => Finding::bad_file(error.to_string(), next),
    }]
}

/// Whether the file is a GSD file.
fn has_gsd_head(path: &Path) -> bool {
    File::open(path).and_then(Peeked::of).is_ok_and(|peeked| is_gsd(path, &peeked.head))
}

/// A GSD file, which other commands read.
fn gsd(path: &Path) -> Vec<Finding> {
    let name = path.display();
    let file = match profivac_gsd_slave::Catalog::read(&[path.to_owned()]) {
        Ok(catalog) => catalog.entries().next().map(|(_, entry)| (entry.name(), Arc::clone(&entry.file))),
        Err(error) => {
            return vec![Finding::bad_file(
                error.to_string(),
                format!("`profivac gsd check {name}` says what is wrong in which line"),
            )];
        }
    };
    let Some((device, file)) = file else { return Vec::new() };
    let (device, modules) = (visible(&device), counted(file.device().modules.len() as u64, "module"));
    let found =
        format!("a GSD file: {device}, {modules}; `profivac doctor --gsd {name} CAPTURE` compares traffic with it");
    vec![match file.faults().count() {
        0 => Finding::note(found, format!("`profivac gsd show {name}` shows its modules and parameters")),
        faults => Finding::note(
            format!("{found}; {}", counted(faults as u64, "fault")),
            format!("`profivac gsd check {name}` says what is wrong in which line"),
        ),
    }]
}

/// Recorded traffic.
fn traffic(path: &Path, files: &Files) -> Vec<Finding> {
    let file = match File::open(path) {
        Ok(file) => file,
        Err(error) => return vec![unreadable(path, &error)],
    };
    let source = match Source::open(file, ANY_RATE) {
        Ok(source) => source,
        Err(error) => {
            return vec![Finding::bad_file(
                error.to_string(),
                "name a file of profivac, a capture (pcapng), or text with octets in hexadecimal",
            )];
        }
    };
    explained(source, path, files)
}

fn explained(mut source: Source<File>, path: &Path, files: &Files) -> Vec<Finding> {
    let kind = match source.kind {
        SourceKind::Pcapng | SourceKind::Pcap => "a capture file",
        SourceKind::Trace => "a trace of profivac",
        SourceKind::Text => "text with octets",
        SourceKind::Octets => "the octets of a line",
    };
    let (clock, line) = (source.clock(), source.line_baud.unwrap_or(ANY_RATE));
    // Captures have the times of an operating system, which say nothing about T_SDR.
    let times = if source.kind == SourceKind::Trace { source.times } else { TimeSource::Platform };
    let mut divider = Divider::new(clock, TimeSource::Platform).with_line_rate(line);
    let mut observer = Observer::new(clock, times).with_line_rate(line).with_gsd(files.clone());
    let (mut chunks, mut pieces, mut has_more) = (Vec::new(), Vec::new(), true);
    while has_more {
        has_more = match source.read(&mut chunks) {
            Ok(has_more) => has_more,
            Err(error) => return vec![Finding::bad_file(error.to_string(), "record the traffic again")],
        };
        for chunk in chunks.drain(..) {
            divider.push(&chunk, &mut pieces);
        }
        source.left_over.clear();
        pieces.drain(..).for_each(|piece| observer.piece(&piece));
    }
    divider.end(&mut pieces);
    pieces.drain(..).for_each(|piece| observer.piece(&piece));
    let report = BusReport::of(&observer);
    let explain = format!("`profivac decode {}` explains each one", path.display());
    let counted = format!("{kind}: {} telegrams, {} damaged", report.telegrams, report.damaged);
    let mut findings = vec![match (report.telegrams, report.damaged) {
        (0, _) => Finding::bad_file(
            format!("{kind} without a telegram"),
            "check that it has traffic of PROFIBUS; --input of `profivac decode` reads it otherwise",
        ),
        (_, 0) => Finding::good(format!("{counted}; {explain}")),
        _ => Finding::note(counted, explain),
    }];
    if !files.is_empty() {
        findings.extend(slaves::findings(&observer, source.line_baud));
    }
    if let Some(skipped) = source.skipped() {
        findings.push(Finding::note(skipped.to_string(), "the other packets are of another network"));
    }
    if let Some(damage) = &source.damage {
        findings.push(Finding::bad_file(
            format!("the file ends early: {damage}"),
            "what is before its end can be used; record the traffic again if more is needed",
        ));
    }
    findings
}
