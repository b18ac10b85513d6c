//! The output of `decode` and `sniff`: explanations, a summary and a capture file.

mod capture;
mod repeats;

pub use capture::Capture;

use crate::gsd_files::{ModuleRow, module_rows};
use crate::output::{out, visible};
use crate::values::{Expected, ValueError};
use clap::Args;
use profivac_dp::link::{Baud, BitTime};
use profivac_explain::ExplainedPiece;
use profivac_explain::explainer::{Explainer, OctetCounts, Role, Summary};
use profivac_explain::frame::{Piece, PieceKind};
use profivac_explain::input::{LeftOver, SourceKind};
use profivac_explain::note::Note;
use profivac_explain::slave::Slave;
use profivac_sim::describe::{Description, Hex};
use profivac_sim::trace::pcapng;
use profivac_wire::Telegram;
use repeats::{Repeats, Shown};
use serde::Serialize;
use std::path::PathBuf;

/// The output options of both commands.
#[derive(Args, Debug)]
pub struct PrintOptions {
    /// Print lines of JSON
    #[arg(long)]
    pub json: bool,
    /// Also print every telegram with its octets
    #[arg(long)]
    raw: bool,
    /// Also write a capture file
    #[arg(long, value_name = "FILE.pcapng")]
    pub out: Option<PathBuf>,
    /// The link type of the capture file: user0 (147), which the dissector in contrib/wireshark uses, or profibus-dl (257)
    #[arg(long, value_name = "TYPE", default_value = "user0", value_parser = link_type, requires = "out")]
    pub link_type: u16,
}

fn link_type(text: &str) -> Result<u16, ValueError> {
    match text {
        "user0" | "147" => Ok(pcapng::USER0),
        "profibus-dl" | "257" => Ok(pcapng::PROFIBUS_DL),
        _ => Err(Expected::LinkType.but_found(text)),
    }
}

/// Prints explanations.
pub struct Printer<'a> {
    options: &'a PrintOptions,
    baud: Baud,
    repeats: Repeats,
}

/// A telegram or damaged octets in the JSON output.
#[derive(Debug, Serialize)]
struct PieceRow<'a> {
    kind: &'static str,
    number: usize,
    time_s: Option<f64>,
    octets: String,
    words: Option<String>,
    meaning: &'a str,
}

/// A sentence in the JSON output.
#[derive(Debug, Serialize)]
struct NoteRow<'a> {
    kind: &'static str,
    /// The number of the telegram.
    number: usize,
    time_s: Option<f64>,
    station: Option<u8>,
    text: &'a str,
}

/// The summary in the JSON output.
#[derive(Debug, Serialize)]
struct SummaryRow<'a> {
    kind: &'static str,
    telegrams: u64,
    damaged: u64,
    doubtful: u64,
    input: Option<&'static str>,
    octets: OctetsRow,
    sent: &'a std::collections::BTreeMap<u8, u64>,
    masters: Vec<u8>,
    slaves: Vec<SlaveRow>,
}

/// Where the octets of the input are. `input` is the sum of the others.
#[derive(Debug, Serialize)]
struct OctetsRow {
    input: u64,
    telegrams: u64,
    doubtful: u64,
    damaged: u64,
    left_over: u64,
}

/// Text that may be octets and was not decoded, in the JSON output.
#[derive(Debug, Serialize)]
struct LeftOverRow<'a> {
    kind: &'static str,
    line: usize,
    text: &'a str,
    octets: usize,
}

/// The octets that were read.
#[derive(Clone, Copy, Debug, Default)]
pub struct Accounting {
    /// Kind of the file; `None` for a port.
    pub kind: Option<SourceKind>,
    /// Octets that were decoded.
    pub read: u64,
    /// Octets that were not decoded.
    pub left_over: u64,
}

#[derive(Debug, Serialize)]
struct SlaveRow {
    address: u8,
    /// The device of the tables, or the only one that a GSD file describes.
    device: Option<String>,
    /// Model and vendor of each device by the GSD files.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    possible_devices: Vec<String>,
    /// The modules by the GSD file.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    modules: Vec<ModuleRow>,
    requests: u64,
    retries: u64,
    unanswered: u64,
    exchanges: u64,
}

impl<'a> Printer<'a> {
    /// Makes a printer; times are bit times of `baud`.
    pub fn new(options: &'a PrintOptions, baud: Baud) -> Self {
        Self { options, baud, repeats: Repeats::default() }
    }

    /// Prints pieces and their notes.
    pub fn print(&mut self, explained: &[ExplainedPiece]) {
        let mut lines = Vec::new();
        for piece in explained {
            if self.options.raw {
                lines.push(if self.options.json { self.piece_json(piece) } else { self.piece(piece) });
            }
            for note in &piece.notes {
                if self.options.json {
                    lines.push(self.note_json(note));
                } else {
                    self.note_lines(note, &mut lines);
                }
            }
        }
        if !lines.is_empty() {
            out(&lines.join("\n"));
        }
    }

    /// The lines of a note: a loop is said once and counted, unless the telegrams between are printed too.
    fn note_lines(&mut self, note: &Note, lines: &mut Vec<String>) {
        let shown = if self.options.raw { Shown::Print { ended: None } } else { self.repeats.next(note) };
        match shown {
            Shown::Count => {}
            Shown::Begin(text) => lines.push(self.note(note, &text)),
            Shown::Print { ended } => {
                lines.extend(ended.map(|text| self.note(note, &text)));
                lines.push(self.note(note, &note.text));
            }
        }
    }

    fn note(&self, note: &Note, text: &str) -> String {
        let station = note.station.map(|station| station.to_string()).unwrap_or_default();
        format!("{} {station:>4}  {}", self.time(note.at, note.number), visible(text))
    }

    fn piece(&self, explained: &ExplainedPiece) -> String {
        let ExplainedPiece { piece, number, meaning, .. } = explained;
        let meaning = if meaning.is_empty() { String::new() } else { format!(" = {}", visible(meaning)) };
        format!("{}       {}{meaning} | {}", self.time(piece.start, *number), words(piece), octets(piece))
    }

    /// The time in seconds, or the number of the telegram if the recording has no times.
    fn time(&self, at: Option<BitTime>, number: usize) -> String {
        at.map_or_else(|| format!("{:>14}", format!("#{number}")), |at| format!("{:12.6} s", self.seconds(at)))
    }

    fn seconds(&self, at: BitTime) -> f64 {
        at.0 as f64 / f64::from(self.baud.bits_per_second())
    }

    fn note_json(&self, note: &Note) -> String {
        let time_s = note.at.map(|at| self.seconds(at));
        let Note { number, station, text, .. } = note;
        json(&NoteRow { kind: note.kind.name(), number: *number, time_s, station: *station, text })
    }

    fn piece_json(&self, explained: &ExplainedPiece) -> String {
        let piece = &explained.piece;
        let kind = match piece.kind {
            PieceKind::Valid => "telegram",
            PieceKind::Doubtful => "doubtful",
            PieceKind::Damaged => "octets",
        };
        let words = Telegram::parse(&piece.octets).ok().filter(|_| piece.kind != PieceKind::Damaged);
        json(&PieceRow {
            kind,
            number: explained.number,
            time_s: piece.start.map(|at| self.seconds(at)),
            octets: octets(piece),
            words: words.map(|telegram| single_spaced(&Description(&telegram).to_string())),
            meaning: &explained.meaning,
        })
    }

    /// Prints what is left over of a line.
    pub fn left_over(&self, left_over: &LeftOver) {
        let LeftOver { line, text, octets } = left_over;
        match (self.options.raw, self.options.json) {
            (false, _) => {}
            (true, true) => out(&json(&LeftOverRow { kind: "left-over", line: *line, text, octets: *octets })),
            (true, false) => out(&format!("{:>14}       left over: {text}", format!("line {line}"))),
        }
    }

    /// Prints the summary.
    pub fn summary(&self, explainer: &Explainer, input: Accounting) {
        let summary = explainer.summary();
        let rows = slave_rows(explainer);
        if self.options.json {
            let Summary { telegrams, damaged, doubtful, sent, roles, .. } = summary;
            let masters =
                roles.iter().filter(|(_, role)| **role == Role::Master).map(|(address, _)| *address).collect();
            let [telegrams, damaged, doubtful] = [telegrams, damaged, doubtful].map(|count| *count);
            let (octets, input) = (octets_row(summary, input), input.kind.map(SourceKind::name));
            let kind = "summary";
            let row = SummaryRow { kind, telegrams, damaged, doubtful, input, octets, sent, masters, slaves: rows };
            return out(&json(&row));
        }
        for (station, text) in self.repeats.running() {
            let station = station.map(|station| station.to_string()).unwrap_or_default();
            out(&format!("{:>14} {station:>4}  {text}", ""));
        }
        out(&format!("\n{}\n{}", counts_line(summary), octets_line(&octets_row(summary, input))));
        out(&table(summary, &rows));
    }
}

/// `5 telegrams, 1 damaged piece (16.7 %)`
fn counts_line(summary: &Summary) -> String {
    let Summary { telegrams, damaged, doubtful, .. } = *summary;
    let percent = damaged as f64 * 100.0 / telegrams.saturating_add(damaged).max(1) as f64;
    let share = if damaged == 0 { String::new() } else { format!(" ({percent:.1} %)") };
    let doubtful = if doubtful == 0 { String::new() } else { format!(", {doubtful} doubtful") };
    format!("{}, {}{share}{doubtful}", counted(telegrams, "telegram"), counted(damaged, "damaged piece"))
}

/// `2 octets`
pub fn counted(count: u64, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

fn octets_row(summary: &Summary, Accounting { read, left_over, .. }: Accounting) -> OctetsRow {
    let OctetCounts { telegrams, doubtful, damaged } = summary.octets;
    OctetsRow { input: read.saturating_add(left_over), telegrams, doubtful, damaged, left_over }
}

/// `116 octets: 99 in telegrams, 17 damaged, 0 left over`
fn octets_line(row: &OctetsRow) -> String {
    let OctetsRow { input, telegrams, doubtful, damaged, left_over } = row;
    let doubtful = if *doubtful == 0 { String::new() } else { format!(", {doubtful} doubtful") };
    let octets = counted(*input, "octet");
    format!("{octets}: {telegrams} in telegrams{doubtful}, {damaged} damaged, {left_over} left over")
}

fn slave_rows(explainer: &Explainer) -> Vec<SlaveRow> {
    let rows = explainer.slaves().map(|(address, slave)| {
        let counters = slave.counters;
        SlaveRow {
            address,
            device: device(slave),
            possible_devices: slave.described.names(),
            modules: module_rows(&slave.described),
            requests: counters.requests,
            retries: counters.repetitions,
            unanswered: counters.unanswered,
            exchanges: counters.exchanges,
        }
    });
    rows.collect()
}

/// The name of a device: of the tables, or the only model of the GSD files.
fn device(slave: &Slave) -> Option<String> {
    let by_tables = slave.tables.model.map(|model| model.name.to_owned());
    by_tables.or_else(|| match slave.described.models().as_slice() {
        [only] => Some(only.clone()),
        _ => None,
    })
}

/// A row for each station with its counters.
fn table(summary: &Summary, rows: &[SlaveRow]) -> String {
    let longest = rows.iter().filter_map(|row| row.device.as_ref()).map(|device| device.chars().count()).max();
    let width = longest.unwrap_or(0).max(8);
    let mut text = format!(
        "{:>4}  {:<width$}{:>10}{:>10}{:>10}{:>12}{:>11}",
        "ADDR", "DEVICE", "SENT", "REQUESTS", "REPEATED", "UNANSWERED", "EXCHANGES"
    );
    let stations: std::collections::BTreeSet<u8> =
        summary.sent.keys().copied().chain(rows.iter().map(|row| row.address)).collect();
    for address in stations {
        let sent = summary.sent.get(&address).copied().unwrap_or_default();
        text += &match rows.iter().find(|row| row.address == address) {
            Some(SlaveRow { device, requests, retries, unanswered, exchanges, .. }) => {
                let device = visible(device.as_deref().unwrap_or("?"));
                format!(
                    "\n{address:>4}  {device:<width$}{sent:>10}{requests:>10}{retries:>10}{unanswered:>12}{exchanges:>11}"
                )
            }
            None => format!("\n{address:>4}  {:<width$}{sent:>10}", role_name(summary.roles.get(&address))),
        };
    }
    text
}

const fn role_name(role: Option<&Role>) -> &'static str {
    match role {
        Some(Role::Master) => "master",
        Some(Role::Slave) => "slave",
        None => "?",
    }
}

/// A row as one line of JSON.
fn json(row: &impl Serialize) -> String {
    serde_json::to_string(row).unwrap_or_default()
}

fn words(piece: &Piece) -> String {
    match (piece.kind, Telegram::parse(&piece.octets)) {
        (PieceKind::Valid, Ok(telegram)) => Description(&telegram).to_string(),
        (PieceKind::Doubtful, Ok(telegram)) => format!("{} (doubtful)", Description(&telegram)),
        _ => "damaged".to_owned(),
    }
}

/// The octets, with `!` after those with a character error.
fn octets(piece: &Piece) -> String {
    if piece.errors.is_empty() {
        return Hex(&piece.octets).to_string();
    }
    let mark = |at| if piece.errors.contains(&at) { "!" } else { "" };
    let octets = piece.octets.iter().enumerate().map(|(at, octet)| format!("{octet:02X}{}", mark(at)));
    octets.collect::<Vec<_>>().join(" ")
}

/// Replaces the spaces between columns by one.
fn single_spaced(words: &str) -> String {
    words.split_whitespace().collect::<Vec<_>>().join(" ")
}
