//! `profivac sniff`: what happens on a line, while it happens.

use crate::bus::open_port;
use crate::console::Signals;
use crate::explanation::{Capture, PrintOptions, Printer};
use crate::failure::Failure;
use crate::output::{check, notice};
use crate::values::{self, Rate};
use clap::Args;
use clap::builder::NonEmptyStringValueParser;
use profivac_explain::frame::TimeSource;
use profivac_explain::tap::{Tap, TapEvent};
use profivac_explain::{Decoder, ExplainedPiece};
use rustix::fd::AsFd;
use std::time::{Duration, Instant};

/// The story of a line while it happens. Only listens: not one octet is sent.
///
/// Ends with Ctrl-C, or after the time of --for, with a summary: who spoke, and how often something went wrong.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A serial device, a pty, or tcp://HOST:PORT
    #[arg(long, value_name = "PORT", value_parser = NonEmptyStringValueParser::new())]
    port: String,
    /// Bits per second; on a serial device auto listens until a telegram is heard at some rate
    #[arg(long, value_name = "RATE|auto", default_value = "19200", value_parser = values::rate)]
    baud: Rate,
    /// End after so long
    #[arg(long = "for", value_name = "SECONDS", value_parser = values::seconds)]
    time: Option<Duration>,
    #[command(flatten)]
    style: PrintOptions,
}

const EXAMPLES: &str = "\
Examples:
  profivac sniff --port /dev/ttyUSB0 --baud 93750
  profivac sniff --port tcp://127.0.0.1:4000 --raw
  profivac sniff --port /tmp/line --for 60 --out line.pcapng --json";

/// How long to wait when nothing ends the wait.
const MAX_WAIT: Duration = Duration::from_secs(3600);

/// Listens until it is enough.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let signals = Signals::catch()?;
    let (port, baud) = open_port(&arguments.port, arguments.baud)?;
    let mut ear = Tap::new(port, baud);
    notice(&format_args!("listening on {}, Ctrl-C ends", arguments.port));
    let mut teller = Decoder::new(baud, TimeSource::Platform);
    let mut capture = Capture::begin(&arguments.style, baud)?;
    let printer = Printer::new(&arguments.style, baud);
    let end = arguments.time.and_then(|time| Instant::now().checked_add(time));
    let mut told = Vec::new();
    let ended = loop {
        let left = end.map_or(MAX_WAIT, |end| end.saturating_duration_since(Instant::now()));
        let (heard, stop) = match ear.receive(&[signals.as_fd()], left) {
            Ok((heard, readable)) => (heard, readable.first() == Some(&true)),
            Err(error) => break Err(Failure::from(error)),
        };
        match heard {
            TapEvent::Octets(noted) => teller.push(&noted, &mut told),
            TapEvent::Silence => teller.end(&mut told),
            TapEvent::Nothing => {}
        }
        show(&printer, capture.as_mut(), &mut told)?;
        if stop || end.is_some_and(|end| end <= Instant::now()) {
            break Ok(());
        }
    };
    teller.end(&mut told);
    show(&printer, capture.as_mut(), &mut told)?;
    printer.summary(teller.explainer());
    ended
}

fn show(printer: &Printer<'_>, capture: Option<&mut Capture>, told: &mut Vec<ExplainedPiece>) -> Result<(), Failure> {
    printer.print(told);
    check()?;
    capture.map_or(Ok(()), |capture| capture.add(told))?;
    told.clear();
    Ok(())
}
