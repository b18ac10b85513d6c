//! `profivac decode`: explains recorded traffic.

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

/// Explain recorded traffic: start-ups, refusals with their reason, reads and writes.
///
/// The command accepts a capture file (pcapng), a trace of profivac, or text with hexadecimal octets as programs print them: dumps of
/// xxd and hexdump, logs with times, arrows and words, 0x, commas, colons. Damaged telegrams are reported and never hide valid
/// telegrams beside them. Each explanation is printed as soon as its input is read, also from a pipe that never ends. A file that is truncated, or still
/// being written, is explained up to its end; then a message gives the position, and the exit code is 2.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The file; - or no argument for standard input
    #[arg(value_name = "FILE", default_value = "-")]
    file: String,
    /// Bits per second, if the file does not contain it
    #[arg(long, value_name = "RATE", default_value = "19200", value_parser = values::baud)]
    baud: Baud,
    #[command(flatten)]
    options: PrintOptions,
}

const EXAMPLES: &str = "\
Examples:
  profivac decode capture.pcapng
  profivac decode --raw log.txt
  echo 'TX 68 05 05 68 88 82 6D 3C 3E F1 16' | profivac decode --raw
  profivac decode log.txt --out log.pcapng        # for Wireshark, see contrib/wireshark
  profivac decode --json capture.pcapng";

/// The number of pieces that are explained before they are printed.
const BATCH: usize = 1000;

/// Explains the file and prints a summary.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let name = if arguments.file == "-" { "standard input" } else { &arguments.file };
    let file = open(&arguments.file).map_err(|error| Failure::usage(format!("{name} cannot be read: {error}")))?;
    let bad = |error: InputError| Failure::usage(format!("{name}: {error}"));
    let mut source = Source::open(file, arguments.baud).map_err(bad)?;
    let baud = source.line_baud.unwrap_or(arguments.baud);
    let mut output = DecodeOutput {
        decoder: Decoder::new(baud, source.times),
        printer: Printer::new(&arguments.options, baud),
        capture: Capture::begin(&arguments.options, baud)?,
        octets: 0,
    };
    let (mut chunks, mut has_more) = (Vec::new(), true);
    while has_more {
        has_more = source.read(&mut chunks).map_err(bad)?;
        output.explain(&chunks)?;
        chunks.clear();
    }
    output.end()?;
    report_skipped_lines(source.skipped, name);
    output.check_damage(source.damage, name)
}

/// A file or standard input.
fn open(file: &str) -> io::Result<Box<dyn Read>> {
    Ok(if file == "-" { Box::new(io::stdin().lock()) } else { Box::new(fs::File::open(file)?) })
}

/// Prints a notice about lines that were skipped.
fn report_skipped_lines(skipped: Skipped, name: &str) {
    if let Skipped { count, first: Some(first) } = skipped {
        let lines = if count == 1 { "line" } else { "lines" };
        notice(&format_args!("{name}: {count} {lines} without octets, the first is line {first}"));
    }
}

/// Explains, prints and writes the capture file.
struct DecodeOutput<'a> {
    decoder: Decoder,
    printer: Printer<'a>,
    capture: Option<Capture>,
    octets: usize,
}

impl DecodeOutput<'_> {
    fn explain(&mut self, chunks: &[Chunk]) -> Result<(), Failure> {
        let mut explained = Vec::new();
        for batch in chunks.chunks(BATCH) {
            for chunk in batch {
                self.octets = self.octets.saturating_add(chunk.octets.len());
                self.decoder.push(chunk, &mut explained);
            }
            self.show(&mut explained)?;
        }
        Ok(())
    }

    fn end(&mut self) -> Result<(), Failure> {
        let mut explained = Vec::new();
        self.decoder.end(&mut explained);
        self.show(&mut explained)?;
        self.printer.summary(self.decoder.explainer());
        Ok(())
    }

    fn show(&mut self, explained: &mut Vec<ExplainedPiece>) -> Result<(), Failure> {
        self.printer.print(explained);
        check()?;
        self.capture.as_mut().map_or(Ok(()), |capture| capture.add(explained))?;
        explained.clear();
        Ok(())
    }

    /// Fails for a file without a telegram, and for a capture or a trace that is truncated.
    fn check_damage(&self, damage: Option<Damage>, name: &str) -> Result<(), Failure> {
        if let Some(damage) = damage {
            return Err(Failure::usage(format!(
                "{name}: {damage}; the output above explains everything before this position"
            )));
        }
        if self.decoder.explainer().summary().telegrams > 0 {
            return Ok(());
        }
        let octets = self.octets;
        Err(Failure::usage(format!("{name}: expected telegrams, none of {octets} octets belongs to a valid one")))
    }
}
