//! `profivac decode`: explains recorded traffic.

mod other_protocol;

use crate::advice::NO_TELEGRAM;
use crate::device_files::DeviceFileOptions;
use crate::explanation::{Accounting, Capture, PrintOptions, Printer, counted};
use crate::failure::Failure;
use crate::gsd_files::{self, Peeked, is_gsd};
use crate::gsd_slaves::GsdOptions;
use crate::output::{check, notice};
use crate::sniff::statistics;
use crate::values;
use clap::{Args, ValueEnum};
use other_protocol::{MOST_WAITING, OtherProtocol};
use profivac_dp::link::Baud;
use profivac_explain::input::{
    Chunk, Damage, Ignored, IgnoredKind, IgnoredText, InputError, LeftOver, Source, SourceKind, StatedNotation,
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
/// print them: dumps of od, xxd and hexdump, logs with times, arrows and words, one octet per line of a logic analyser, decimal lists,
/// Python strings, the output of strace; docs/decode.md has them all. No octet is lost: each one is part of a
/// telegram, of a damaged piece, or left over, with the number of its line. Damaged telegrams never hide valid ones beside them. Each
/// explanation is printed as soon as its input is read, also from a pipe that never ends; only the first eight wait while they may be of
/// another protocol. A file that is truncated, or still being written, is explained up to its end; then a message gives the position, and the exit code is 2.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The file; - or no argument for standard input
    #[arg(value_name = "FILE", default_value = "-")]
    file: String,
    /// Bits per second, if the file does not state it. A file with sample numbers instead of times needs it; default: 19200
    #[arg(long, value_name = "RATE", value_parser = values::baud)]
    baud: Option<Baud>,
    /// How to read the file, if its first bytes mislead or no telegram shows the notation
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
    device_files: DeviceFileOptions,
    #[command(flatten)]
    options: PrintOptions,
}

/// How a file is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Input {
    /// As its first bytes and its telegrams show
    Auto,
    /// Text in the notation that its telegrams show
    Text,
    /// Text with octets in hexadecimal
    Hex,
    /// Text with octets as decimal numbers
    Decimal,
    /// Text with octets in quoted strings
    Strings,
    /// The calls that strace prints
    Strace,
    /// The octets of the line
    Octets,
}

impl Input {
    /// The notation that the user states.
    const fn notation(self) -> Option<StatedNotation> {
        match self {
            Self::Hex => Some(StatedNotation::Hexadecimal),
            Self::Decimal => Some(StatedNotation::Decimal),
            Self::Strings => Some(StatedNotation::Strings),
            Self::Strace => Some(StatedNotation::Calls),
            Self::Auto | Self::Text | Self::Octets => None,
        }
    }
}

/// The rate of a line that neither the file nor the user names. chosen: it only turns numbers of samples into times.
const USUAL_RATE: Baud = Baud::B19200;

/// What a user can say about a text in which no telegram shows the notation.
const OTHER_INPUT: &str = "--input hex, decimal, strings, strace or octets says how to read it";

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
    let files = gsd_files::files(&arguments.gsd, &arguments.device_files)?;
    let Peeked { head, stream: file } = open(&arguments.file, arguments.input).map_err(unreadable)?;
    if arguments.input == Input::Auto && is_gsd(Path::new(&arguments.file), &head) {
        return Err(no_traffic(name));
    }
    let given = arguments.baud.unwrap_or(USUAL_RATE);
    let mut source = match (arguments.input, arguments.input.notation()) {
        (_, Some(notation)) => Source::open_in(file, given, notation),
        (Input::Octets, None) => Source::open_as(file, given, SourceKind::Octets),
        (Input::Text, None) => Source::open_as(file, given, SourceKind::Text),
        (_, None) => Source::open(file, given),
    }
    .map_err(|error| refused(error, name, arguments.input))?;
    let (clock, line) = (source.clock(), source.line_baud.unwrap_or(given));
    let observer = statistics::observer(clock, source.times, &arguments.gauges)?;
    let mut output = DecodeOutput {
        decoder: Decoder::new(clock, source.times).with_line_rate(line).with_gsd(files.clone()),
        printer: Printer::new(&arguments.options, clock),
        capture: Capture::begin(&arguments.options, clock, source.line_baud.or(arguments.baud))?,
        left_over: LeftOverCount::default(),
        observer: observer.with_line_rate(line).with_gsd(files),
        has_statistics: arguments.statistics,
        is_json: arguments.options.json,
        other: OtherProtocol::default(),
        held: Vec::new(),
        held_texts: Vec::new(),
        is_told: false,
        name,
    };
    let (mut chunks, mut has_more, mut is_reported) = (Vec::new(), true, false);
    while has_more {
        let read = source.read(&mut chunks);
        if read.is_err() {
            output.release()?;
        }
        has_more = read.map_err(|error| refused(error, name, arguments.input))?;
        is_reported = is_reported || report_kind(&source, name);
        output.explain(&chunks)?;
        output.leave_over(&mut source.left_over)?;
        chunks.clear();
    }
    output.end(&source)?;
    report_ignored(&source.ignored(), name);
    report_skipped(&source, name);
    output.left_over.report(name);
    output.check_damage(source.damage, source.octets, name)
}

/// The failure of a file that cannot be decoded.
fn refused(error: InputError, name: &str, input: Input) -> Failure {
    let other = match (&error, input) {
        (InputError::NoOctets { .. }, Input::Auto | Input::Text) => format!("; {OTHER_INPUT}"),
        _ => String::new(),
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
            match source.is_notation_shown() {
                true => notice(&format_args!(
                    "{name}: read as text with {notation} (--input octets: as the octets of a line)"
                )),
                false => notice(&format_args!(
                    "{name}: read as text with {notation}, which no telegram shows: {OTHER_INPUT}"
                )),
            }
        }
        SourceKind::Octets if source.is_detected => {
            notice(&format_args!("{name}: read as the octets of a line (--input text: as text)"));
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

/// Prints a notice about packets of other link types.
fn report_skipped<R: Read>(source: &Source<R>, name: &str) {
    if let Some(skipped) = source.skipped() {
        notice(&format_args!("{name}: {skipped}"));
    }
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
    /// The pieces that wait until it is known whether they may be of another protocol.
    held: Vec<ExplainedPiece>,
    /// What is left over beside them.
    held_texts: Vec<LeftOver>,
    /// The user was told of the other protocol.
    is_told: bool,
    name: &'a str,
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

    /// Counts what is left over, and shows it behind the pieces.
    fn leave_over(&mut self, texts: &mut Vec<LeftOver>) -> Result<(), Failure> {
        texts.iter().for_each(|text| self.left_over.add(text));
        self.held_texts.append(texts);
        if self.waits() { check() } else { self.release() }
    }

    /// Whether the next pieces may still show another protocol.
    fn waits(&self) -> bool {
        self.other.is_open() && self.held_texts.len() < MOST_WAITING
    }

    fn end<R: Read>(&mut self, source: &Source<R>) -> Result<(), Failure> {
        let mut explained = Vec::new();
        self.decoder.end(&mut explained);
        self.show(&mut explained)?;
        self.release()?;
        if self.has_statistics {
            statistics::print(&self.observer, self.is_json);
            return check();
        }
        let input = Accounting { kind: Some(source.kind), read: source.octets, left_over: self.left_over.octets };
        self.printer.summary(self.decoder.explainer(), input);
        Ok(())
    }

    /// Examines the pieces, and prints them unless they wait.
    fn show(&mut self, explained: &mut Vec<ExplainedPiece>) -> Result<(), Failure> {
        for explained in &*explained {
            self.other.piece(&explained.piece);
            self.observer.piece(&explained.piece);
        }
        self.held.append(explained);
        if self.waits() { check() } else { self.release() }
    }

    /// Prints the pieces that have waited, behind the name of the protocol that they may be of.
    fn release(&mut self) -> Result<(), Failure> {
        let names = self.other.names().filter(|_| !std::mem::replace(&mut self.is_told, true));
        if let Some(names) = names {
            let name = self.name;
            notice(&format_args!(
                "{name}: could also be {names}: its first frames fit, and no station has answered as on PROFIBUS so far"
            ));
        }
        if !self.has_statistics {
            self.printer.print(&self.held);
        }
        self.held_texts.drain(..).for_each(|text| self.printer.left_over(&text));
        check()?;
        self.capture.as_mut().map_or(Ok(()), |capture| capture.add(&self.held))?;
        self.held.clear();
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
