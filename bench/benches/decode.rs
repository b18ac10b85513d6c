//! `cargo bench -p bench --bench decode`: how long 100,000 telegrams take, from a file to the explanation, beside pyprofibus's parser.
//!
//! Wall time of the fastest of five runs, on one core. pyprofibus runs in a process of its own, in the environment that
//! `./test` makes; it is given the telegrams one by one, valid ones only, because it has nothing that finds them in a stream.

use profivac_dp::link::Baud;
use profivac_explain::Decoder;
use profivac_explain::input::Capture;
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
    match table() {
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
