//! Counts instructions under callgrind.
//!
//! | Arguments | Effect |
//! |---|---|
//! | none | prints the table of `docs/benchmarks.md` |
//! | `--check` | fails if an operation takes more than 5 % more instructions than `bench/baseline.toml` says |
//! | `--check-release` | fails at more than 2 % |
//! | `--record` | writes `bench/baseline.toml` |
//!
//! Every operation runs in a process of its own, twice, with a different number of repetitions. The difference divided by
//! the difference of the repetitions is the cost of one operation: process start and preparation cancel out, and the program
//! needs no marks. The counts are the same on every run; they change with the compiler and the architecture.

use bench::{Operation, ROWS, Row};
use std::collections::BTreeMap;
use std::env;
use std::path::PathBuf;
use std::process::{Command, ExitCode};

const FEW: u32 = 1_000;
const MANY: u32 = 3_000;

/// The increase over the baseline that `--check` allows, as a factor: a change may cost some percent because the compiler
/// inlines differently.
const ALLOWED: f64 = 1.05;

/// The increase that a release may have.
const ALLOWED_IN_RELEASE: f64 = 1.02;

/// The increase that it allows in any case, in instructions: the counts per octet are small numbers.
const ALLOWED_INSTRUCTIONS: f64 = 1.0;

/// One of the operations of a row, by its name on the command line.
fn operation(row: &Row, role: &str) -> Option<Operation> {
    match role {
        "ours" => Some(row.ours),
        "minus" => row.minus,
        _ => row.peer,
    }
}

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    if let [row, role, times] = arguments.as_slice() {
        return repeat(row, role, times);
    }
    let has = |option: &str| arguments.iter().any(|argument| argument == option);
    let done = if has("--check") {
        check(ALLOWED)
    } else if has("--check-release") {
        check(ALLOWED_IN_RELEASE)
    } else if has("--record") {
        record()
    } else {
        table()
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("cargo bench: {reason}");
            ExitCode::FAILURE
        }
    }
}

/// The process that runs under callgrind.
fn repeat(row: &str, role: &str, times: &str) -> ExitCode {
    let row = row.parse().ok().and_then(|row: usize| ROWS.get(row));
    match (row.and_then(|row| operation(row, role)), times.parse()) {
        (Some(operation), Ok(times)) => operation(times),
        _ => return ExitCode::from(2),
    }
    ExitCode::SUCCESS
}

fn table() -> Result<(), String> {
    println!("| Instructions | profivac | profirust 0.6.0 | to reach |");
    println!("|---|--:|--:|--:|");
    for (number, row) in ROWS.iter().enumerate() {
        let ours = ours(number, row)?;
        let peer = row.peer.map(|_| per_operation(number, "peer")).transpose()?;
        let peer = peer.map_or_else(|| "-".to_owned(), |peer| format!("{peer:.0}"));
        let target = row.target.map_or_else(|| "-".to_owned(), |target| target.to_string());
        println!("| {} | {ours:.0} | {peer} | {target} |", row.what);
    }
    Ok(())
}

/// Compares all operations of this project with the baseline.
fn check(allowed: f64) -> Result<(), String> {
    let baseline = baseline()?;
    let mut slower = Vec::new();
    for (number, row) in ROWS.iter().enumerate() {
        let before = *baseline.get(row.key).ok_or_else(|| format!("{}: no baseline; record it", row.key))?;
        let now = ours(number, row)?;
        println!("{:<32} {now:>8.1} {:>+7.1} %", row.key, (now / before - 1.0) * 100.0);
        if now > (before * allowed).max(before + ALLOWED_INSTRUCTIONS) {
            slower.push(format!("{} takes {now:.1} instructions instead of {before:.1}", row.key));
        }
    }
    if slower.is_empty() { Ok(()) } else { Err(slower.join("; ")) }
}

fn record() -> Result<(), String> {
    let mut text =
        "# Instructions per unit, x86-64. Written by: cargo bench -p bench --bench instructions -- --record\n"
            .to_owned();
    for (number, row) in ROWS.iter().enumerate() {
        text += &format!("{} = {:.1}\n", row.key, ours(number, row)?);
    }
    std::fs::write(path(), text).map_err(|error| format!("{}: {error}", path().display()))
}

fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("baseline.toml")
}

/// The baseline: lines with a key and a number.
fn baseline() -> Result<BTreeMap<String, f64>, String> {
    let text = std::fs::read_to_string(path()).map_err(|error| format!("{}: {error}", path().display()))?;
    let lines = text.lines().filter(|line| !line.starts_with('#') && !line.is_empty());
    lines
        .map(|line| {
            let (key, count) = line.split_once('=').ok_or_else(|| format!("no count in the line {line:?}"))?;
            let count = count.trim().parse().map_err(|_| format!("no number in the line {line:?}"))?;
            Ok((key.trim().to_owned(), count))
        })
        .collect()
}

/// The instructions per unit of the operation of this project.
fn ours(number: usize, row: &Row) -> Result<f64, String> {
    let minus = if row.minus.is_some() { per_operation(number, "minus")? } else { 0.0 };
    Ok((per_operation(number, "ours")? - minus) / f64::from(row.units))
}

fn per_operation(row: usize, role: &str) -> Result<f64, String> {
    let (few, many) = (collected(row, role, FEW)?, collected(row, role, MANY)?);
    Ok(many.saturating_sub(few) as f64 / f64::from(MANY - FEW))
}

/// The instructions that callgrind counts in a process that repeats an operation `times` times.
fn collected(row: usize, role: &str, times: u32) -> Result<u64, String> {
    let program = env::current_exe().map_err(|error| error.to_string())?;
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(program)
        .args([row.to_string(), role.to_owned(), times.to_string()])
        .output()
        .map_err(|error| format!("valgrind does not start ({error}); on Debian it is the package valgrind"))?;
    let messages = String::from_utf8_lossy(&output.stderr);
    let total = messages.lines().find_map(|line| line.split_once("Collected :"));
    total
        .and_then(|(_, total)| total.trim().parse().ok())
        .ok_or_else(|| format!("callgrind counted nothing:\n{messages}"))
}
