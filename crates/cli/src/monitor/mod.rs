//! `profivac monitor`: shows pressures of many slaves in cyclic exchange. Each segment has its own thread, so that a lost port
//! does not delay the other segments.

mod display;
mod gsd;
mod plan;
mod row;
mod segment;
mod slave;
mod table;

use crate::bus::MasterOptions;
use crate::console::Signals;
use crate::failure::Failure;
use crate::output::notice;
use crate::screen::Screen;
use crate::values::{self, Octets};
use clap::Args;
use clap::builder::NonEmptyStringValueParser;
use display::MonitorView;
use gsd::GsdSlaves;
use profivac_host::readiness::{Readiness, pair};
use segment::SegmentMonitor;
use std::io;
use std::panic::resume_unwind;
use std::thread::{self, ScopedJoinHandle};
use std::time::{Duration, Instant};

/// Show the pressures of slaves in cyclic exchange: a live table on a terminal, otherwise rows once a second.
///
/// The command takes ownership of the slaves: it sets their parameters, keeps their units, and unlocks them at the end. An unlocked
/// gauge returns to IDLE: it stops measuring and opens its relays. The command refuses a slave that belongs to another master. It
/// tries to open a lost port again until that succeeds. A slave that is not a known device is shown too, with its inputs as octets: it gets
/// its own configuration, the user parameters of `--prm` and the outputs of `--outputs`. If another master exchanges data with such a
/// slave, its inputs are read with RD_Inp, without ownership.
///
/// With `--gsd` a slave of any vendor gets the modules and parameters of its GSD file, and its inputs and diagnosis are shown in the
/// words of the file. The modules come from `--modules`, otherwise from the slave's present configuration. The command asks before it
/// owns a slave with outputs, because zeros can stop a pump or close a valve; without a terminal it needs `--outputs`. The segments of
/// a station's file are independent: a failure in one is reported, and the others continue.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A serial device, a pty, tcp://HOST:PORT, or sim:FILE.toml for a segment in memory; not with a FILE.toml
    #[arg(long, value_name = "PORT", value_parser = NonEmptyStringValueParser::new())]
    port: Option<String>,
    #[command(flatten)]
    line: MasterOptions,
    /// Take ownership of the slaves without an announcement; required without a terminal
    #[arg(long)]
    own: bool,
    /// The user parameters of slaves that are not known devices, in hex, from their GSD files; default: none
    #[arg(long, value_name = "HEX", value_parser = values::octets, conflicts_with = "paths")]
    prm: Option<Octets>,
    #[command(flatten)]
    gsd: GsdSlaves,
    /// Print CSV
    #[arg(long, conflicts_with = "json")]
    csv: bool,
    /// Print a line of JSON for every row
    #[arg(long)]
    json: bool,
    /// End after this time
    #[arg(long = "for", value_name = "SECONDS", value_parser = values::seconds)]
    time: Option<Duration>,
    /// The addresses of the slaves, or a station's file with segments, ports, rates, masters and gauges
    #[arg(value_name = "ADDR|FILE.toml", required = true)]
    targets: Vec<String>,
}

const EXAMPLES: &str = "\
Examples:
  profivac monitor --port /dev/ttyUSB0 5 6 7
  profivac monitor --port /tmp/line --own --csv 5 > pressures.csv
  profivac monitor --port tcp://127.0.0.1:4000 --own --json --for 10 5
  profivac monitor --port /dev/ttyUSB0 --own --prm '00 00 00' --outputs '9=00 00' 9
  profivac monitor --port /dev/ttyUSB0 --gsd VALVES.GSD 9
  profivac monitor --port /dev/ttyUSB0 --gsd gsd_files --modules 9=3+7 --set '9=State without bus=closed' 9
  profivac monitor --port /dev/ttyUSB0 --gsd gsd_files --own --modules 9=valves.toml --outputs '9=00 00' --json 9
  profivac monitor plant.toml

`profivac gsd show FILE` lists modules and parameters. A file for --modules has a module for each slot, and parameters:
  [modules]
  1 = \"4DI\"
  2 = 7
  [parameters]
  \"State without bus\" = \"closed\"
  [slot.2.parameters]
  Delay = 5
If several parameters have one name, write SLOT:NAME, SLOT@OFFSET:NAME or SLOT@OFFSET.BIT:NAME.";

/// The interval between two pictures on a screen.
const FRAME: Duration = Duration::from_millis(200);

/// Monitors every segment until the user quits or all segments have ended.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut plans = arguments.plans()?;
    let is_screen = Screen::is_possible() && !arguments.csv && !arguments.json;
    announce(arguments, is_screen)?;
    let signals = &Signals::catch()?;
    arguments.gsd.prepare(&mut plans, signals)?;
    let plans = &plans;
    let (stop, stopped) = pair()?;
    let show = &MonitorView::new(plans, is_screen, arguments);
    let end = arguments.time.and_then(|time| Instant::now().checked_add(time));
    let ends = &[signals.readiness(), Readiness::of(&stopped)];
    let verdicts = thread::scope(|scope| {
        let watch = |(number, plan)| scope.spawn(move || SegmentMonitor { plan, number, show, ends, end }.run());
        let threads: Vec<_> = plans.iter().enumerate().map(watch).collect();
        let drawn = if is_screen { draw(show, &threads) } else { Ok(()) };
        if is_screen {
            // Leaving the screen ends every segment.
            drop(stop);
        }
        let verdicts = threads.into_iter().map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic)));
        let verdicts: Vec<_> = verdicts.collect();
        drawn.map(|()| verdicts)
    })?;
    show.combine(verdicts)
}

/// Announces that the command takes ownership; without a terminal `--own` is required.
fn announce(arguments: &Arguments, is_screen: bool) -> Result<(), Failure> {
    match (arguments.own, is_screen) {
        (true, _) => {}
        (false, true) => notice(
            &"monitor takes ownership of the slaves and sets their parameters; they keep their units, and are unlocked at the end",
        ),
        (false, false) => {
            return Err(Failure::usage(
                "monitor takes ownership of the slaves and sets their parameters; without a terminal add --own",
            ));
        }
    }
    Ok(())
}

/// Draws the screen until the user quits or all threads have ended.
fn draw<T>(show: &MonitorView<'_>, threads: &[ScopedJoinHandle<'_, T>]) -> io::Result<()> {
    let mut screen = Screen::open()?;
    while !threads.iter().all(ScopedJoinHandle::is_finished) && !screen.is_quit_requested()? {
        screen.draw(|frame| show.draw(frame))?;
        thread::sleep(FRAME);
    }
    Ok(())
}
