//! `profivac sniff`: explains the traffic on a line while it listens.

pub mod statistics;

use crate::bus::open_port_to_listen;
use crate::console::Signals;
use crate::device_files::DeviceFileOptions;
use crate::explanation::{Accounting, Capture, PrintOptions, Printer};
use crate::failure::Failure;
use crate::gsd_files;
use crate::gsd_slaves::GsdOptions;
use crate::output::{check, notice, notices};
use crate::values::{self, Rate};
use clap::Args;
use clap::builder::NonEmptyStringValueParser;
use profivac_explain::frame::TimeSource;
use profivac_explain::tap::{Tap, TapEvent};
use profivac_explain::{Decoder, ExplainedPiece};
use profivac_virtual::device_spec::DeviceSpec;
use std::time::{Duration, Instant};

/// Explain the traffic on a line while it happens. The command only listens and sends nothing.
///
/// Sentences that repeat in the same order are printed twice and then counted; --json and --raw print all of them.
/// It ends with Ctrl-C or after the time of --for, and prints a summary of stations and errors.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A serial device, a pty, or tcp://HOST:PORT
    #[arg(long, value_name = "PORT", value_parser = NonEmptyStringValueParser::new())]
    port: String,
    /// Bits per second; with auto, a serial device listens at each rate until it receives a telegram
    #[arg(long, value_name = "RATE|auto", default_value = "19200", value_parser = values::rate)]
    baud: Rate,
    /// End after this time
    #[arg(long = "for", value_name = "SECONDS", value_parser = values::seconds)]
    time: Option<Duration>,
    /// Print the live list and the statistics of the bus at the end instead of sentences; with --json as one object
    #[arg(long, conflicts_with_all = ["raw", "out"])]
    statistics: bool,
    /// The device at an address, for the pressures of a bus whose start-up was not received: bcg450@5
    #[arg(long = "gauge", value_name = "DEVICE@ADDRESS", requires = "statistics")]
    gauges: Vec<DeviceSpec>,
    #[command(flatten)]
    gsd: GsdOptions,
    #[command(flatten)]
    device_files: DeviceFileOptions,
    #[command(flatten)]
    options: PrintOptions,
}

const EXAMPLES: &str = "\
Examples:
  profivac sniff --port /dev/ttyUSB0 --baud 93750
  profivac sniff --port tcp://127.0.0.1:4000 --raw
  profivac sniff --port /tmp/line --for 60 --out line.pcapng --json
  profivac sniff --port /dev/ttyUSB0 --baud auto --for 60 --statistics
  profivac sniff --port /dev/ttyUSB0 --for 60 --statistics --gauge bcg450@5
  profivac sniff --port /dev/ttyUSB0 --gsd gsd/                      # any slave, in the words of its GSD file";

/// The longest single wait without --for.
const MAX_WAIT: Duration = Duration::from_secs(3600);

/// Listens until a signal or the end of --for.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let files = gsd_files::files(&arguments.gsd, &arguments.device_files)?;
    let signals = Signals::catch()?;
    let (port, baud) = open_port_to_listen(&arguments.port, arguments.baud)?;
    let mut tap = Tap::new(port, baud);
    notice(&format_args!("listening on {}; Ctrl-C ends", arguments.port));
    if arguments.statistics {
        return statistics::run(arguments, files, &signals, &mut tap, baud);
    }
    let mut decoder = Decoder::new(baud, TimeSource::Platform).with_gsd(files);
    let mut capture = Capture::begin(&arguments.options, baud, Some(baud))?;
    let mut printer = Printer::new(&arguments.options, baud);
    let end = arguments.time.and_then(|time| Instant::now().checked_add(time));
    let (mut explained, mut octets) = (Vec::new(), 0_u64);
    let ended = loop {
        let left = end.map_or(MAX_WAIT, |end| end.saturating_duration_since(Instant::now()));
        let (event, stop) = match tap.receive(&[signals.readiness()], left) {
            Ok((event, readable)) => (event, readable.first() == Some(&true)),
            Err(error) => break Err(Failure::from(error)),
        };
        notices(|| tap.next_notice());
        match event {
            TapEvent::Octets(chunk) => {
                octets = octets.saturating_add(chunk.octets.len() as u64);
                decoder.push(&chunk, &mut explained);
            }
            TapEvent::Silence => decoder.end(&mut explained),
            TapEvent::Nothing => {}
        }
        show(&mut printer, capture.as_mut(), &mut explained)?;
        if stop || end.is_some_and(|end| end <= Instant::now()) {
            break Ok(());
        }
    };
    decoder.end(&mut explained);
    show(&mut printer, capture.as_mut(), &mut explained)?;
    printer.summary(decoder.explainer(), Accounting { read: octets, ..Accounting::default() });
    ended
}

fn show(
    printer: &mut Printer<'_>,
    capture: Option<&mut Capture>,
    explained: &mut Vec<ExplainedPiece>,
) -> Result<(), Failure> {
    printer.print(explained);
    check()?;
    capture.map_or(Ok(()), |capture| capture.add(explained))?;
    explained.clear();
    Ok(())
}
