//! `profivac decode`: what happened on a line, out of a file.

use crate::failure::Failure;
use crate::story::{Capture, Printer, Style};
use crate::values;
use clap::Args;
use profivac_dp::link::Baud;
use profivac_host::explain::Teller;
use profivac_host::explain::input::{Noted, Recording};
use std::fs;
use std::io::{self, Read};

/// The story of a recording: who started, what was refused and why, what was read and written.
///
/// Takes a capture file (pcapng), a trace of profivac, or text with octets in hexadecimal as programs print them: dumps of
/// xxd and hexdump, logs with times, arrows and words, 0x, commas, colons. Damaged telegrams are named and never hide valid
/// ones beside them.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The file; - or nothing for standard input
    #[arg(value_name = "FILE", default_value = "-")]
    file: String,
    /// Bits per second, where the file does not say it
    #[arg(long, value_name = "RATE", default_value = "19200", value_parser = values::baud)]
    baud: Baud,
    #[command(flatten)]
    style: Style,
}

const EXAMPLES: &str = "\
Examples:
  profivac decode capture.pcapng
  profivac decode --raw log.txt
  echo 'TX 68 05 05 68 88 82 6D 3C 3E F1 16' | profivac decode --raw
  profivac decode log.txt --out log.pcapng        for Wireshark, see contrib/wireshark
  profivac decode --json capture.pcapng";

/// So many pieces are told before they are printed.
const BATCH: usize = 1000;

/// Reads, tells, sums up.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let name = if arguments.file == "-" { "standard input" } else { &arguments.file };
    let file = read(&arguments.file).map_err(|error| Failure::usage(format!("{name} cannot be read: {error}")))?;
    let recording =
        Recording::read(&file, arguments.baud).map_err(|error| Failure::usage(format!("{name}: {error}")))?;
    remark(&recording, name);
    let baud = recording.baud.unwrap_or(arguments.baud);
    let mut teller = Teller::new(baud, recording.times);
    let mut capture = Capture::begin(&arguments.style, baud)?;
    tell(&recording.noted, &mut teller, &Printer::new(&arguments.style, baud), capture.as_mut())?;
    verdict(&recording, &teller, name)
}

/// A recording without a telegram is a bad file, and so is a capture that ends before its end.
fn verdict(recording: &Recording, teller: &Teller, name: &str) -> Result<(), Failure> {
    if let Some(damage) = &recording.damage {
        return Err(Failure::usage(format!("{name}: {damage}; what comes before it is told above")));
    }
    if teller.explainer().summary().telegrams > 0 {
        return Ok(());
    }
    let octets: usize = recording.noted.iter().map(|noted| noted.octets.len()).sum();
    Err(Failure::usage(format!("{name}: expected telegrams, none of {octets} octets belongs to a valid one")))
}

fn read(file: &str) -> io::Result<Vec<u8>> {
    if file != "-" {
        return fs::read(file);
    }
    let mut octets = Vec::new();
    io::stdin().lock().read_to_end(&mut octets)?;
    Ok(octets)
}

/// Lines that were passed over are worth a word.
fn remark(recording: &Recording, name: &str) {
    if let Some(first) = recording.skipped.first() {
        let count = recording.skipped.len();
        let lines = if count == 1 { "line" } else { "lines" };
        eprintln!("profivac: {name}: {count} {lines} without octets, the first is line {first}");
    }
}

fn tell(
    noted: &[Noted],
    teller: &mut Teller,
    printer: &Printer<'_>,
    mut capture: Option<&mut Capture>,
) -> Result<(), Failure> {
    let mut told = Vec::new();
    for batch in noted.chunks(BATCH) {
        batch.iter().for_each(|noted| teller.noted(noted, &mut told));
        printer.print(&told);
        capture.as_mut().map_or(Ok(()), |capture| capture.add(&told))?;
        told.clear();
    }
    teller.end(&mut told);
    printer.print(&told);
    capture.as_mut().map_or(Ok(()), |capture| capture.add(&told))?;
    printer.summary(teller.explainer());
    Ok(())
}
