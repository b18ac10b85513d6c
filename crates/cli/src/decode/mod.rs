//! `profivac decode`: explains recorded traffic.

mod other_protocol;

use crate::advice::NO_TELEGRAM;
use crate::explanation::{Accounting, Capture, PrintOptions, Printer, counted};
use crate::failure::Failure;
use crate::gsd_files::{self, Peeked, is_gsd};
use crate::gsd_slaves::GsdOptions;
use crate::output::{check, notice};
use crate::sniff::statistics;
use crate::values;
use clap::{Args, ValueEnum};
use other_protocol::OtherProtocol;
use profivac_dp::link::Baud;
use profivac_explain::input::{
    Chunk, Damage, Ignored, IgnoredKind, IgnoredText, InputError, LeftOver, Source, SourceKind,
};
use profivac_explain::text::OMITTED;
use profivac_explain::{Decoder, ExplainedPiece};
use profivac_listen::Observer;
use profivac_virtual::device_spec::DeviceSpec;
use std::fs;
use std::io::{self, Read};
use std::path::Path;

/// Explain recorded traffic: start-ups, refusals with their reason, reads and writes.
///
/// The command accepts a capture file (pcapng, pcap, also gzip), a trace of profivac, the octets of a line, or text with octets as programs
/// print them: dumps of od, xxd and hexdump, logs with times, arrows and words, one octet a line of a logic analyser, decimal lists, strings
/// of Python, the output of strace; docs/decode.md has them all. No octet is lost: each one is part of a
/// telegram, of a damaged piece, or left over, with the number of its line. Damaged telegrams never hide valid ones beside them. Each
/// explanation is printed as soon as its input is read, also from a pipe that never ends. A file that is truncated, or still being written,
/// is explained up to its end; then a message gives the position, and the exit code is 2.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The file; - or no argument for standard input
    #[arg(value_name = "FILE", default_value = "-")]
    file: String,
    /// Bits per second, if the file does not contain it
    #[arg(long, value_name = "RATE", default_value = "19200", value_parser = values::baud)]
    baud: Baud,
    /// How to read the file, if its first octets mislead: text with octets in hexadecimal, or the octets of the line
    #[arg(long, value_name = "KIND", default_value = "auto", value_enum)]
    input: Input,
    /// Print the live list and the statistics of the bus instead of sentences; with --json as one object
    #[arg(long, conflicts_with_all = ["raw", "out"])]
    statistics: bool,
    /// The device at an address, for the pressures of a bus whose start-up was not recorded: bcg450@5
    #[arg(long = "gauge", value_name = "DEVICE@ADDRESS", requires = "statistics")]
    gauges: Vec<DeviceSpec>,
    #[command(flatten)]
    gsd: GsdOptions,
    #[command(flatten)]
    options: PrintOptions,
}

/// How a file is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Input {
    /// As its first octets show
    Auto,
    /// Text with octets in hexadecimal
    Text,
    /// The octets of the line
    Octets,
}

const EXAMPLES: &str = "\
Examples:
  profivac decode capture.pcapng
  profivac decode --raw log.txt
  echo 'TX 68 05 05 68 88 82 6D 3C 3E F1 16' | profivac decode --raw
  profivac decode log.txt --out log.pcapng        # for Wireshark, see contrib/wireshark
  profivac decode --input octets line.bin         # not text, though its octets may look like it
  profivac decode --gsd PUMP.GSD capture.pcapng   # any slave: modules, parameters and diagnosis in the words of its file
  profivac decode --json capture.pcapng
  profivac decode --statistics --gauge bcg450@5 capture.pcapng";

/// The number of pieces that are explained before they are printed.
const BATCH: usize = 1000;

/// Explains the file and prints a summary.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let name = if arguments.file == "-" { "standard input" } else { &arguments.file };
    let unreadable = |error: io::Error| Failure::usage(format!("{name} cannot be read: {error}"));
    let files = gsd_files::files(&arguments.gsd)?;
    let Peeked { head, stream: file } = open(&arguments.file, arguments.input).map_err(unreadable)?;
    if arguments.input == Input::Auto && is_gsd(Path::new(&arguments.file), &head) {
        return Err(no_traffic(name));
    }
    let mut source = match arguments.input {
        Input::Auto => Source::open(file, arguments.baud),
        Input::Text => Source::open_as(file, arguments.baud, SourceKind::Text),
        Input::Octets => Source::open_as(file, arguments.baud, SourceKind::Octets),
    }
    .map_err(|error| refused(error, name, arguments.input))?;
    let baud = source.line_baud.unwrap_or(arguments.baud);
    let mut output = DecodeOutput {
        decoder: Decoder::new(baud, source.times).with_gsd(files.clone()),
        printer: Printer::new(&arguments.options, baud),
        capture: Capture::begin(&arguments.options, baud)?,
        left_over: LeftOverCount::default(),
        observer: statistics::observer(baud, source.times, &arguments.gauges)?.with_gsd(files),
        has_statistics: arguments.statistics,
        is_json: arguments.options.json,
        other: OtherProtocol::default(),
    };
    let (mut chunks, mut has_more, mut is_reported) = (Vec::new(), true, false);
    while has_more {
        has_more = source.read(&mut chunks).map_err(|error| refused(error, name, arguments.input))?;
        is_reported = is_reported || report_kind(&source, name);
        output.explain(&chunks)?;
        output.leave_over(&mut source.left_over)?;
        chunks.clear();
    }
    output.end(&source, name)?;
    report_ignored(&source.ignored(), name);
    output.left_over.report(name);
    output.check_damage(source.damage, source.octets, name)
}

/// The failure of a file that cannot be decoded.
fn refused(error: InputError, name: &str, input: Input) -> Failure {
    let other = match (&error, input) {
        (InputError::NoOctets { .. }, Input::Auto) => "; --input octets reads the file as the octets of a line",
        _ => "",
    };
    Failure::usage(format!("{name}: {error}{other}"))
}

/// The failure of a GSD file, which has no traffic.
fn no_traffic(name: &str) -> Failure {
    Failure::usage(format!(
        "{name} is a GSD file, expected recorded traffic; `profivac gsd show {name}` shows its modules and parameters, `profivac gsd check {name}` \
         its faults, and `profivac decode --gsd {name} FILE` explains the traffic of its slave"
    ))
}

/// Prints how the file is read, and how to read it otherwise. Returns false while a text has not shown its notation.
fn report_kind<R: Read>(source: &Source<R>, name: &str) -> bool {
    match source.kind {
        SourceKind::Text if source.is_detected => {
            let Some(notation) = source.notation() else { return false };
            notice(&format_args!("{name}: read as text with {notation} (--input octets: as the octets of a line)"));
        }
        SourceKind::Octets if source.is_detected => {
            notice(&format_args!(
                "{name}: read as the octets of a line (--input text: as text with octets in hexadecimal)"
            ));
        }
        SourceKind::Text | SourceKind::Octets | SourceKind::Pcapng | SourceKind::Pcap | SourceKind::Trace => {}
    }
    true
}

/// A file or standard input, unpacked unless the octets of the line are wanted.
fn open(file: &str, input: Input) -> io::Result<Peeked> {
    let file = if file == "-" { Peeked::of(io::stdin()) } else { Peeked::of(fs::File::open(file)?) }?;
    if input == Input::Octets { Ok(file) } else { file.unpacked() }
}

/// Prints a notice about text that is not octets.
fn report_ignored(ignored: &Ignored, name: &str) {
    for (kind, IgnoredText { lines, first_line, first_text, .. }) in ignored.kinds() {
        let what = match kind {
            IgnoredKind::Line => "without octets",
            IgnoredKind::Words => "with words beside octets",
            IgnoredKind::Comment => "with a comment",
            IgnoredKind::Address => "with an address",
            IgnoredKind::Characters => "with octets as characters",
            IgnoredKind::Bits => "with bits of characters",
            IgnoredKind::ByteOrderMark => "with a byte order mark",
        };
        notice(&format_args!(
            "{name}: {} {what}, the first is line {first_line}: '{first_text}'",
            counted(*lines as u64, "line")
        ));
    }
}

/// Counts text that may be octets and was not decoded.
#[derive(Debug, Default)]
struct LeftOverCount {
    octets: u64,
    texts: u64,
    first: Option<LeftOver>,
    /// Lines that a dump omits are missing, and their number is not known.
    has_omitted: bool,
}

impl LeftOverCount {
    fn add(&mut self, left_over: &LeftOver) {
        self.octets = self.octets.saturating_add(left_over.octets as u64);
        self.texts = self.texts.saturating_add(1);
        self.has_omitted |= left_over.text == OMITTED;
        self.first.get_or_insert_with(|| left_over.clone());
    }

    fn report(&self, name: &str) {
        if let Some(LeftOver { line, text, .. }) = &self.first {
            let (octets, texts) = (counted(self.octets, "octet"), counted(self.texts, "line"));
            let omitted =
                if self.has_omitted { "; * stands for lines that the dump omits, od -v prints them" } else { "" };
            notice(&format_args!(
                "{name}: {octets} left over in {texts}, the first is line {line}: '{text}'; --raw shows all{omitted}"
            ));
        }
    }
}

/// Explains, prints and writes the capture file.
struct DecodeOutput<'a> {
    decoder: Decoder,
    printer: Printer<'a>,
    capture: Option<Capture>,
    left_over: LeftOverCount,
    observer: Observer,
    has_statistics: bool,
    is_json: bool,
    other: OtherProtocol,
}

impl DecodeOutput<'_> {
    fn explain(&mut self, chunks: &[Chunk]) -> Result<(), Failure> {
        let mut explained = Vec::new();
        for chunk in chunks {
            self.decoder.push(chunk, &mut explained);
            if explained.len() >= BATCH {
                self.show(&mut explained)?;
            }
        }
        self.show(&mut explained)
    }

    /// Counts and shows what is left over.
    fn leave_over(&mut self, texts: &mut Vec<LeftOver>) -> Result<(), Failure> {
        for left_over in texts.drain(..) {
            self.left_over.add(&left_over);
            self.printer.left_over(&left_over);
        }
        check()
    }

    fn end<R: Read>(&mut self, source: &Source<R>, name: &str) -> Result<(), Failure> {
        let mut explained = Vec::new();
        self.decoder.end(&mut explained);
        self.show(&mut explained)?;
        if let Some(names) = self.other.names() {
            notice(&format_args!(
                "{name}: could also be {names}: every frame fits it, and no station answers as on PROFIBUS"
            ));
        }
        if self.has_statistics {
            statistics::print(&self.observer, self.is_json);
            return check();
        }
        let input = Accounting { kind: Some(source.kind), read: source.octets, left_over: self.left_over.octets };
        self.printer.summary(self.decoder.explainer(), input);
        Ok(())
    }

    fn show(&mut self, explained: &mut Vec<ExplainedPiece>) -> Result<(), Failure> {
        for explained in &*explained {
            self.other.piece(&explained.piece);
            self.observer.piece(&explained.piece);
        }
        if !self.has_statistics {
            self.printer.print(explained);
        }
        check()?;
        self.capture.as_mut().map_or(Ok(()), |capture| capture.add(explained))?;
        explained.clear();
        Ok(())
    }

    /// The settings of a recorder; the advice about the cable follows.
    const SETTINGS: &'static str =
        "record at the rate of the bus with 8 data bits, even parity, 1 stop bit, not inverted; ";

    /// Fails for a file without a telegram, and for a capture or a trace that is truncated.
    fn check_damage(&self, damage: Option<Damage>, octets: u64, name: &str) -> Result<(), Failure> {
        if let Some(damage) = damage {
            return Err(Failure::usage(format!(
                "{name}: {damage}; the output above explains everything before this position"
            )));
        }
        let summary = self.decoder.explainer().summary();
        let read = octets.saturating_add(self.left_over.octets);
        let is_other = self.other.names().is_some();
        if summary.telegrams == 0 && !is_other {
            let octets = counted(read, "octet");
            return Err(Failure::usage(format!(
                "{name}: expected telegrams, none of {octets} belongs to a valid one: {}{NO_TELEGRAM}",
                Self::SETTINGS
            )));
        }
        if summary.telegrams == 0 {
            return Err(Failure::usage(format!("{name}: expected telegrams, found frames of another protocol")));
        }
        let valid = summary.octets.telegrams.saturating_add(summary.octets.doubtful);
        if valid.saturating_mul(2) < read {
            let lost = counted(read.saturating_sub(valid), "octet");
            notice(&format_args!("{name}: {lost} of {read} belong to no telegram: {}{NO_TELEGRAM}", Self::SETTINGS));
        }
        Ok(())
    }
}
