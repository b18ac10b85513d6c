//! `cargo bench`: counts instructions under callgrind and prints the table of `docs/benchmarks.md`.
//!
//! Every operation runs in a process of its own, twice, with a different number of repetitions. The difference divided by
//! the difference of the repetitions is what one costs: starting the process and making things ready drop out, and
//! nothing has to be marked in the program. The counts are the same on every run; they change with the compiler and the
//! architecture.

use bench::{Operation, ROWS, Row};
use std::env;
use std::process::{Command, ExitCode};

const FEW: u32 = 1_000;
const MANY: u32 = 3_000;

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
    match table() {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("cargo bench: {reason}");
            ExitCode::FAILURE
        }
    }
}

/// What runs under callgrind.
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
        let count = |role| operation(row, role).map(|_| per_operation(number, role)).transpose();
        let ours = count("ours")?.unwrap_or(0.0) - count("minus")?.unwrap_or(0.0);
        let ours = ours / f64::from(row.units);
        let peer = count("peer")?.map_or_else(|| "-".to_owned(), |peer| format!("{peer:.0}"));
        let target = row.target.map_or_else(|| "-".to_owned(), |target| target.to_string());
        println!("| {} | {ours:.0} | {peer} | {target} |", row.what);
    }
    Ok(())
}

fn per_operation(row: usize, role: &str) -> Result<f64, String> {
    let (few, many) = (collected(row, role, FEW)?, collected(row, role, MANY)?);
    Ok(many.saturating_sub(few) as f64 / f64::from(MANY - FEW))
}

/// How many instructions callgrind sees in a process that repeats an operation so many times.
fn collected(row: usize, role: &str, times: u32) -> Result<u64, String> {
    let program = env::current_exe().map_err(|error| error.to_string())?;
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(program)
        .args([row.to_string(), role.to_owned(), times.to_string()])
        .output()
        .map_err(|error| format!("valgrind does not start ({error}); on Debian it is the package valgrind"))?;
    let said = String::from_utf8_lossy(&output.stderr);
    let total = said.lines().find_map(|line| line.split_once("Collected :"));
    total.and_then(|(_, total)| total.trim().parse().ok()).ok_or_else(|| format!("callgrind counted nothing:\n{said}"))
}
