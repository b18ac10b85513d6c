//! `profivac monitor`: pressures of many slaves, exchanged cyclically. Each segment is served by a thread of its own, so that
//! one whose port is lost does not hold up the others.

mod display;
mod plan;
mod row;
mod segment;
mod table;

use crate::bus::MasterOptions;
use crate::console::Signals;
use crate::failure::Failure;
use crate::output::notice;
use crate::screen::Screen;
use crate::values;
use clap::Args;
use clap::builder::NonEmptyStringValueParser;
use display::MonitorView;
use rustix::fd::AsFd;
use segment::SegmentMonitor;
use std::io;
use std::os::unix::net::UnixStream;
use std::panic::resume_unwind;
use std::thread::{self, ScopedJoinHandle};
use std::time::{Duration, Instant};

/// The pressures of slaves, exchanged cyclically: a live table on a terminal, rows once a second otherwise.
///
/// This takes the slaves over: they are parameterised, with the unit they have, and unlocked at the end. A slave that
/// belongs to another master is left alone. A port that is lost is looked for until it is back. Of a station's file with
/// several segments each is watched for itself: what goes wrong in one is told and the others go on.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A serial device, a pty, tcp://HOST:PORT, or sim:FILE.toml for a segment in memory; not with a FILE.toml
    #[arg(long, value_name = "PORT", value_parser = NonEmptyStringValueParser::new())]
    port: Option<String>,
    #[command(flatten)]
    line: MasterOptions,
    /// Take the slaves over without telling anybody: needed where no terminal is
    #[arg(long)]
    own: bool,
    /// Print CSV
    #[arg(long, conflicts_with = "json")]
    csv: bool,
    /// Print a line of JSON for every row
    #[arg(long)]
    json: bool,
    /// End after so long
    #[arg(long = "for", value_name = "SECONDS", value_parser = values::seconds)]
    time: Option<Duration>,
    /// The addresses of the slaves, or a station's file: it says the segments, their ports, rates, masters and gauges
    #[arg(value_name = "ADDR|FILE.toml", required = true)]
    watched: Vec<String>,
}

const EXAMPLES: &str = "\
Examples:
  profivac monitor --port /dev/ttyUSB0 5 6 7
  profivac monitor --port /tmp/line --own --csv 5 > pressures.csv
  profivac monitor --port tcp://127.0.0.1:4000 --own --json --for 10 5
  profivac monitor plant.toml";

/// How often a screen is drawn.
const FRAME: Duration = Duration::from_millis(200);

/// Watches every segment until somebody wants to leave or none is left.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let plans = &arguments.plans()?;
    let is_screen = Screen::is_possible() && !arguments.csv && !arguments.json;
    announce(arguments, is_screen)?;
    let signals = &Signals::catch()?;
    let (stop, stopped) = UnixStream::pair()?;
    let show = &MonitorView::new(plans, is_screen, arguments);
    let end = arguments.time.and_then(|time| Instant::now().checked_add(time));
    let ends = &[signals.as_fd(), stopped.as_fd()];
    let verdicts = thread::scope(|scope| {
        let watch = |(number, plan)| scope.spawn(move || SegmentMonitor { plan, number, show, ends, end }.run());
        let threads: Vec<_> = plans.iter().enumerate().map(watch).collect();
        let drawn = if is_screen { draw(show, &threads) } else { Ok(()) };
        if is_screen {
            // Whoever leaves the screen leaves every segment.
            drop(stop);
        }
        let verdicts = threads.into_iter().map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic)));
        let verdicts: Vec<_> = verdicts.collect();
        drawn.map(|()| verdicts)
    })?;
    show.combine(verdicts)
}

/// Taking slaves over is announced; in a script somebody must have said so.
fn announce(arguments: &Arguments, is_screen: bool) -> Result<(), Failure> {
    match (arguments.own, is_screen) {
        (true, _) => {}
        (false, true) => notice(&"the slaves are parameterised, with the unit they have, and unlocked at the end"),
        (false, false) => {
            return Err(Failure::usage("monitor parameterises the slaves and owns them: say --own in a script"));
        }
    }
    Ok(())
}

/// Draws what is watched until somebody leaves or nothing is watched any more.
fn draw<T>(show: &MonitorView<'_>, threads: &[ScopedJoinHandle<'_, T>]) -> io::Result<()> {
    let mut screen = Screen::open()?;
    while !threads.iter().all(ScopedJoinHandle::is_finished) && !screen.is_quit_requested()? {
        screen.draw(|frame| show.draw(frame))?;
        thread::sleep(FRAME);
    }
    Ok(())
}
