//! `profivac decode`: what happened on a line, out of a file.

use crate::explanation::{Capture, PrintOptions, Printer};
use crate::failure::Failure;
use crate::output::{check, notice};
use crate::values;
use clap::Args;
use profivac_dp::link::Baud;
use profivac_explain::input::{Chunk, Damage, InputError, Skipped, Source};
use profivac_explain::{Decoder, ExplainedPiece};
use std::fs;
use std::io::{self, Read};

/// The story of a recording: who started, what was refused and why, what was read and written.
///
/// Takes a capture file (pcapng), a trace of profivac, or text with octets in hexadecimal as programs print them: dumps of
/// xxd and hexdump, logs with times, arrows and words, 0x, commas, colons. Damaged telegrams are named and never hide valid
/// ones beside them. Everything is told while it is read, also from a pipe that never ends. Of a file that was cut off, or
/// is still being written, everything up to there is told; then a sentence says where it ends, and the exit code is 2.
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
    style: PrintOptions,
}

const EXAMPLES: &str = "\
Examples:
  profivac decode capture.pcapng
  profivac decode --raw log.txt
  echo 'TX 68 05 05 68 88 82 6D 3C 3E F1 16' | profivac decode --raw
  profivac decode log.txt --out log.pcapng        # for Wireshark, see contrib/wireshark
  profivac decode --json capture.pcapng";

/// So many pieces are told before they are printed.
const BATCH: usize = 1000;

/// Reads and tells, sums up.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let name = if arguments.file == "-" { "standard input" } else { &arguments.file };
    let file = open(&arguments.file).map_err(|error| Failure::usage(format!("{name} cannot be read: {error}")))?;
    let bad = |error: InputError| Failure::usage(format!("{name}: {error}"));
    let mut source = Source::open(file, arguments.baud).map_err(bad)?;
    let baud = source.line_baud.unwrap_or(arguments.baud);
    let mut story = DecodeOutput {
        teller: Decoder::new(baud, source.times),
        printer: Printer::new(&arguments.style, baud),
        capture: Capture::begin(&arguments.style, baud)?,
        octets: 0,
    };
    let (mut noted, mut goes_on) = (Vec::new(), true);
    while goes_on {
        goes_on = source.read(&mut noted).map_err(bad)?;
        story.explain(&noted)?;
        noted.clear();
    }
    story.end()?;
    report_skipped_lines(source.skipped, name);
    story.check_damage(source.damage, name)
}

/// A file or standard input.
fn open(file: &str) -> io::Result<Box<dyn Read>> {
    Ok(if file == "-" { Box::new(io::stdin().lock()) } else { Box::new(fs::File::open(file)?) })
}

/// Lines that were passed over are worth a word.
fn report_skipped_lines(skipped: Skipped, name: &str) {
    if let Skipped { count, first: Some(first) } = skipped {
        let lines = if count == 1 { "line" } else { "lines" };
        notice(&format_args!("{name}: {count} {lines} without octets, the first is line {first}"));
    }
}

/// What is told, printed and captured.
struct DecodeOutput<'a> {
    teller: Decoder,
    printer: Printer<'a>,
    capture: Option<Capture>,
    octets: usize,
}

impl DecodeOutput<'_> {
    fn explain(&mut self, noted: &[Chunk]) -> Result<(), Failure> {
        let mut told = Vec::new();
        for batch in noted.chunks(BATCH) {
            for noted in batch {
                self.octets = self.octets.saturating_add(noted.octets.len());
                self.teller.push(noted, &mut told);
            }
            self.show(&mut told)?;
        }
        Ok(())
    }

    fn end(&mut self) -> Result<(), Failure> {
        let mut told = Vec::new();
        self.teller.end(&mut told);
        self.show(&mut told)?;
        self.printer.summary(self.teller.explainer());
        Ok(())
    }

    fn show(&mut self, told: &mut Vec<ExplainedPiece>) -> Result<(), Failure> {
        self.printer.print(told);
        check()?;
        self.capture.as_mut().map_or(Ok(()), |capture| capture.add(told))?;
        told.clear();
        Ok(())
    }

    /// A recording without a telegram is a bad file, and so is a capture or a trace that ends before its end.
    fn check_damage(&self, damage: Option<Damage>, name: &str) -> Result<(), Failure> {
        if let Some(damage) = damage {
            return Err(Failure::usage(format!("{name}: {damage}; what comes before it is told above")));
        }
        if self.teller.explainer().summary().telegrams > 0 {
            return Ok(());
        }
        let octets = self.octets;
        Err(Failure::usage(format!("{name}: expected telegrams, none of {octets} octets belongs to a valid one")))
    }
}
