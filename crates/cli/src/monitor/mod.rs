//! `profivac monitor`: pressures of many slaves, exchanged cyclically.

mod row;
mod table;

use crate::bus::{Bus, Line};
use crate::console::Signals;
use crate::failure::Failure;
use crate::output::{out, remark, remarks};
use crate::screen::Screen;
use crate::values;
use clap::Args;
use profivac_dp::master::{Mode, State, Trouble};
use profivac_host::tool::{Tool, take};
use profivac_host::watch::Watched;
use profivac_station::config::Config;
use row::Row;
use rustix::fd::AsFd;
use std::path::Path;
use std::time::{Duration, Instant, SystemTime};

/// The pressures of slaves, exchanged cyclically: a live table on a terminal, rows once a second otherwise.
///
/// This takes the slaves over: they are parameterised, with the unit they have, and unlocked at the end. A slave that
/// belongs to another master is left alone. A port that is lost is looked for until it is back.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A serial device, a pty, tcp://HOST:PORT, or sim:FILE.toml for a segment in memory; not with a FILE.toml
    #[arg(long, value_name = "PORT")]
    port: Option<String>,
    #[command(flatten)]
    line: Line,
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
    /// The addresses of the slaves, or a station's file with one segment: it says port, rate, master and gauges
    #[arg(value_name = "ADDR|FILE.toml", required = true)]
    watched: Vec<String>,
}

const EXAMPLES: &str = "\
Examples:
  profivac monitor --port /dev/ttyUSB0 5 6 7
  profivac monitor --port /tmp/line --own --csv 5 > pressures.csv
  profivac monitor --port tcp://127.0.0.1:4000 --own --json --for 10 5
  profivac monitor plant.toml";

/// How often rows are made.
const PERIOD: Duration = Duration::from_secs(1);

/// How often a screen is drawn.
const FRAME: Duration = Duration::from_millis(200);

/// How long slaves are given to be unlocked.
const FAREWELL: Duration = Duration::from_secs(1);

/// Finds the slaves, takes them, shows them, gives them back.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (bus, addresses) = &arguments.watched()?;
    check(addresses, bus)?;
    let signals = Signals::catch()?;
    let mut tool = bus.open_lasting()?;
    let screen = Screen::is_possible() && !arguments.csv && !arguments.json;
    announce(arguments, screen)?;
    let mut slaves = Vec::new();
    for address in addresses {
        let found = Watched::find(&mut tool, *address, bus.master());
        // If the port went meanwhile, that is why nobody answers.
        remarks(|| tool.next_remark());
        slaves.push(found?);
    }
    for slave in &slaves {
        let parameters = slave.parameters(tool.baud());
        take(tool.master(), &parameters).map_err(|error| Failure::usage(error.to_string()))?;
    }
    tool.master().set_mode(Mode::Operate);
    let end = arguments.time.and_then(|time| Instant::now().checked_add(time));
    let mut monitor = Monitor { tool, slaves, signals, end, title: screen.then(|| bus.port().to_owned()) };
    let shown = if screen { monitor.on_screen() } else { monitor.in_rows(arguments) };
    let verdict = monitor.verdict();
    monitor.give_back()?;
    shown.and(verdict)
}

impl Arguments {
    /// Which bus, and who is watched on it.
    fn watched(&self) -> Result<(Bus, Vec<u8>), Failure> {
        match (&self.port, self.watched.as_slice()) {
            (None, [file]) if file.ends_with(".toml") => self.of_file(Path::new(file)),
            (Some(_), all) if all.iter().any(|text| text.ends_with(".toml")) => {
                Err(Failure::usage("a station's file says which port: leave --port out, or say addresses"))
            }
            (Some(port), all) => {
                let addresses = all.iter().map(|text| values::slave_address(text));
                let addresses = addresses.collect::<Result<_, _>>().map_err(Failure::usage)?;
                Ok((Bus::at(port, &self.line), addresses))
            }
            (None, _) => Err(Failure::usage("expected --port PORT with addresses, or a station's FILE.toml alone")),
        }
    }

    /// What a station's file says, if it has one segment with gauges.
    fn of_file(&self, file: &Path) -> Result<(Bus, Vec<u8>), Failure> {
        let config = Config::read(file)?;
        let [segment] = config.segments.as_slice() else {
            let segments = config.segments.len();
            let sentence =
                format!("{}: expected one segment, got {segments}: say --port and addresses", file.display());
            return Err(Failure::usage(sentence));
        };
        let addresses: Vec<_> = segment.gauges.iter().map(|gauge| gauge.address).collect();
        if addresses.is_empty() {
            return Err(Failure::usage(format!("{}: the segment {:?} has no gauges", file.display(), segment.name)));
        }
        Ok((Bus::of(segment, &self.line), addresses))
    }
}

/// Every slave once, and none is this master.
fn check(addresses: &[u8], bus: &Bus) -> Result<(), Failure> {
    for (number, address) in addresses.iter().enumerate() {
        bus.check_other(*address, "address")?;
        if addresses.iter().take(number).any(|other| other == address) {
            return Err(Failure::usage(format!("address {address} is named twice")));
        }
    }
    Ok(())
}

/// Taking slaves over is announced; in a script somebody must have said so.
fn announce(arguments: &Arguments, screen: bool) -> Result<(), Failure> {
    if arguments.own {
        return Ok(());
    }
    if !screen {
        return Err(Failure::usage("monitor parameterises the slaves and owns them: say --own in a script"));
    }
    eprintln!("profivac: the slaves are parameterised now, with the unit they have, and unlocked at the end");
    Ok(())
}

/// What is watched, and how it ends.
struct Monitor {
    tool: Tool,
    slaves: Vec<Watched>,
    signals: Signals,
    end: Option<Instant>,
    /// What stands above the table, if there is a screen.
    title: Option<String>,
}

impl Monitor {
    /// What there is to remark is said: on a screen in its title.
    fn listen_to_port(&mut self) {
        while let Some(said) = self.tool.next_remark() {
            match &mut self.title {
                Some(title) => *title = said.to_string(),
                None => remark(&said),
            }
        }
    }

    /// Serves the line until `moment`. False when it is time to end.
    fn serve_until(&mut self, moment: Instant) -> Result<bool, Failure> {
        loop {
            let now = Instant::now();
            if self.end.is_some_and(|end| end <= now) {
                return Ok(false);
            }
            let wait = self.end.unwrap_or(moment).min(moment).saturating_duration_since(now);
            let readable = self.tool.serve(&[self.signals.as_fd()], wait)?;
            self.listen_to_port();
            while self.tool.master().next_event().is_some() {}
            match readable.first() {
                Some(true) => return Ok(false),
                _ if Instant::now() >= moment => return Ok(true),
                _ => {}
            }
        }
    }

    fn rows(&mut self) -> Vec<Row> {
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        let master = self.tool.master();
        self.slaves.iter().flat_map(|slave| Row::of(slave, master, now.as_secs_f64())).collect()
    }

    fn in_rows(&mut self, arguments: &Arguments) -> Result<(), Failure> {
        match (arguments.csv, arguments.json) {
            (true, _) => out(row::CSV_COLUMNS),
            (_, true) => {}
            (false, false) => out(&row::header()),
        }
        let mut next = Instant::now() + PERIOD;
        while self.serve_until(next)? {
            next += PERIOD;
            for row in self.rows() {
                out(&match (arguments.csv, arguments.json) {
                    (true, _) => row.csv(),
                    // Texts and numbers always have a JSON form.
                    (_, true) => serde_json::to_string(&row).unwrap_or_default(),
                    (false, false) => row.line(),
                });
            }
        }
        Ok(())
    }

    fn on_screen(&mut self) -> Result<(), Failure> {
        let mut screen = Screen::open()?;
        while self.serve_until(Instant::now() + FRAME)? && !screen.wants_to_leave()? {
            let rows = self.rows();
            let title = self.title.as_deref().unwrap_or_default();
            screen.draw(|frame| table::draw(frame, title, &rows))?;
        }
        Ok(())
    }

    /// A slave that never exchanged data is a failure.
    fn verdict(&mut self) -> Result<(), Failure> {
        let master = self.tool.master();
        for address in self.slaves.iter().map(|slave| slave.address) {
            if master.counters(address).is_some_and(|counters| counters.exchanges == 0) {
                let trouble = master.trouble(address);
                let reason =
                    trouble.map_or_else(|| "it was not asked long enough".to_owned(), |trouble| trouble.to_string());
                let sentence = format!("no data from the slave at address {address}: {reason}");
                return Err(match trouble {
                    None | Some(Trouble::Lost(_)) => Failure::no_answer(sentence),
                    Some(_) => Failure::refused(sentence),
                });
            }
        }
        Ok(())
    }

    /// Unlocks the slaves.
    fn give_back(&mut self) -> Result<(), Failure> {
        let end = Instant::now() + FAREWELL;
        for address in self.slaves.iter().map(|slave| slave.address) {
            self.tool.master().release(address);
        }
        while Instant::now() < end && !self.is_free() {
            self.tool.serve(&[], end.saturating_duration_since(Instant::now()))?;
        }
        Ok(())
    }

    fn is_free(&mut self) -> bool {
        let master = self.tool.master();
        self.slaves.iter().all(|slave| master.state(slave.address) == Some(State::Inactive))
    }
}
