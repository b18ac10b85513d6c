//! `cargo bench -p bench --bench decode`: how long 100,000 telegrams take, from a file to the explanation, beside pyprofibus's parser.
//!
//! Also ten mebibytes of each periodic noise, as octets and in forms of text, read in portions as from standard input.
//!
//! Wall time of the fastest of five runs, on one core. pyprofibus runs in a process of its own, in the environment that
//! `./test` makes; it is given the telegrams one by one, valid ones only, because it has nothing that finds them in a stream.

use profivac_dp::link::Baud;
use profivac_explain::Decoder;
use profivac_explain::input::{Capture, Source, SourceKind};
use profivac_sim::Trace;
use profivac_sim::describe::Hex;
use profivac_sim::trace::pcapng;
use profivac_wire::Telegram;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::Instant;

const TELEGRAMS: usize = 100_000;
const RUNS: usize = 5;

/// Start-ups of five devices, and a trace with every service and damaged telegrams.
const TRACES: [&str; 6] = [
    "crates/explain/tests/golden/notes/start-bcg450.trace",
    "crates/explain/tests/golden/notes/start-pcg550.trace",
    "crates/explain/tests/golden/notes/start-tpg500.trace",
    "crates/explain/tests/golden/notes/start-img400.trace",
    "crates/explain/tests/golden/notes/power-cut.trace",
    "crates/cli/tests/golden/wireshark/services.trace",
];

fn main() -> ExitCode {
    match table().and_then(|()| noise()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("cargo bench: {reason}");
            ExitCode::FAILURE
        }
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The traces one after the other, repeated.
fn traffic() -> Result<Trace, String> {
    let mut traces = Vec::new();
    for name in TRACES {
        let text = std::fs::read_to_string(root().join(name)).map_err(|error| format!("{name}: {error}"))?;
        traces.push(text.parse::<Trace>().map_err(|error| format!("{name}: {error}"))?);
    }
    let mut traffic = Trace { baud: Baud::B500000, entries: Default::default() };
    let mut offset = 0;
    for trace in traces.iter().cycle() {
        for entry in &trace.entries {
            let mut entry = entry.clone();
            entry.start = entry.start + offset;
            traffic.entries.push_back(entry);
        }
        offset = traffic.entries.back().map_or(0, |last| last.end().0 + 1000);
        if traffic.entries.len() >= TELEGRAMS {
            traffic.entries.truncate(TELEGRAMS);
            return Ok(traffic);
        }
    }
    Err("no traffic".to_owned())
}

fn table() -> Result<(), String> {
    let traffic = traffic()?;
    let lines: String = traffic.entries.iter().map(|entry| format!("{}\n", Hex(&entry.octets))).collect();
    let octets: Vec<u8> = traffic.entries.iter().flat_map(|entry| entry.octets.to_vec()).collect();
    println!("| {TELEGRAMS} telegrams, {} octets | seconds |", octets.len());
    println!("|---|--:|");
    for (what, file) in [
        ("a trace of profivac, explained", traffic.to_string().into_bytes()),
        ("pcapng, explained", pcapng::write(&traffic, pcapng::USER0)),
        ("octets in hexadecimal, a telegram a line, explained", lines.clone().into_bytes()),
        ("the octets alone, nothing between them, explained", octets),
    ] {
        println!("| {what} | {:.3} |", fastest(&file)?);
    }
    let valid: Vec<_> = traffic.entries.iter().filter(|entry| Telegram::parse(&entry.octets).is_ok()).collect();
    let started = Instant::now();
    let parse = |octets: &[u8]| black_box(Telegram::parse(black_box(octets))).is_ok();
    let parsed = valid.iter().filter(|entry| parse(&entry.octets)).count();
    println!("| {parsed} valid telegrams one by one, parsed only | {:.4} |", started.elapsed().as_secs_f64());
    let lines: String = valid.iter().map(|entry| format!("{}\n", Hex(&entry.octets))).collect();
    println!("| the same, pyprofibus 1.13 | {} |", pyprofibus(&lines)?);
    Ok(())
}

/// Seconds from the octets of a file to the last sentence.
fn fastest(file: &[u8]) -> Result<f64, String> {
    let mut best = f64::INFINITY;
    for _ in 0..RUNS {
        let started = Instant::now();
        let recording = Capture::read(file, Baud::B500000).map_err(|error| error.to_string())?;
        let (mut decoder, mut explained) = (Decoder::new(Baud::B500000, recording.times), Vec::new());
        recording.chunks.iter().for_each(|chunk| decoder.push(chunk, &mut explained));
        decoder.end(&mut explained);
        best = best.min(started.elapsed().as_secs_f64());
        if decoder.explainer().summary().telegrams < TELEGRAMS as u64 * 9 / 10 {
            return Err(format!("only {} telegrams were found", decoder.explainer().summary().telegrams));
        }
    }
    Ok(best)
}

/// Noise whose octets may begin a telegram again and again. A line of each table.
const NOISE: [(&str, &[u8]); 8] = [
    ("`10` in every 6th octet", &[0x10, 0, 0, 0, 0, 0]),
    ("`A2` in every 14th", &[0xA2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]),
    ("`DC` in every 3rd", &[0xDC, 0, 0]),
    ("`68` without end", &[0x68]),
    ("`10` without end", &[0x10]),
    ("zeros", &[0]),
    ("`E5`", &[0xE5]),
    ("tokens", &[0xDC, 2, 2]),
];

const NOISE_OCTETS: usize = 10 << 20;

/// Octets as text: the separator behind each octet and behind each sixteenth.
const TEXTS: [(char, char); 3] = [('\n', '\n'), (' ', '\n'), (' ', ' ')];

fn noise() -> Result<(), String> {
    println!("\n| seconds for 10 MiB of | octets | an octet a line | sixteen a line | one line |");
    println!("|---|--:|--:|--:|--:|");
    for (what, period) in NOISE {
        let octets: Vec<u8> = period.iter().copied().cycle().take(NOISE_OCTETS).collect();
        let mut row = format!("| {what} | {:.2} |", streamed(&octets, SourceKind::Octets)?);
        for (separator, sixteenth) in TEXTS {
            let mut text = String::with_capacity(3 * NOISE_OCTETS);
            for (number, octet) in octets.iter().enumerate() {
                text += &format!("{octet:02x}");
                text.push(if number % 16 == 15 { sixteenth } else { separator });
            }
            row += &format!(" {:.2} |", streamed(text.as_bytes(), SourceKind::Text)?);
        }
        println!("{row}");
    }
    Ok(())
}

/// Seconds from the octets of a pipe to the last sentence.
fn streamed(file: &[u8], kind: SourceKind) -> Result<f64, String> {
    let started = Instant::now();
    let mut source = Source::open_as(file, Baud::B500000, kind).map_err(|error| error.to_string())?;
    let mut decoder = Decoder::new(Baud::B500000, source.times);
    let (mut chunks, mut explained, mut more) = (Vec::new(), Vec::new(), true);
    while more {
        more = source.read(&mut chunks).map_err(|error| error.to_string())?;
        chunks.drain(..).for_each(|chunk| decoder.push(&chunk, &mut explained));
        black_box(&explained);
        explained.clear();
    }
    decoder.end(&mut explained);
    if source.octets != NOISE_OCTETS as u64 {
        return Err(format!("{} octets were read", source.octets));
    }
    Ok(started.elapsed().as_secs_f64())
}

fn pyprofibus(lines: &str) -> Result<String, String> {
    let file = std::env::temp_dir().join(format!("profivac-bench-{}.txt", std::process::id()));
    std::fs::write(&file, lines).map_err(|error| error.to_string())?;
    let python = root().join("target/venv/bin/python");
    let output = Command::new(&python).arg(root().join("bench/pyprofibus_parser.py")).arg(&file).output();
    std::fs::remove_file(&file).ok();
    let output = output.map_err(|error| format!("{} ({error}): ./test makes it", python.display()))?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned());
    }
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
