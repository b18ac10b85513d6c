//! `profivac demo`: a small vacuum plant with its gauges and a master on a PROFIBUS segment, all in memory.

mod alarms;
mod dashboard;
mod picture;
mod plant;
mod pump_down;
mod trend;

use crate::console::Signals;
use crate::failure::Failure;
use crate::output::{check, notice, out};
use crate::screen::Screen;
use crate::values;
use clap::Args;
use dashboard::{Dashboard, DashboardOptions};
use profivac_dp::link::Baud;
use profivac_dp::master::Counters;
use profivac_host::readiness::wait;
use profivac_virtual::device::VirtualDevice;
use profivac_virtual::memory_segment::MemorySegment;
use profivac_virtual::scenario::{MasterPresence, Run, Scenario};
use serde::Serialize;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use trend::Trend;

/// Show a vacuum plant in memory: gauges and a master on a PROFIBUS segment, without any hardware.
///
/// The output shows the values that the master reads: every octet passes the codec and both state machines. The command serves the
/// dashboard until q, SIGTERM, Ctrl-C or --for ends it; after the scenario the plant stays in its last state. With --headless it ends with
/// the scenario, and fails if an expectation of the scenario is not met.
#[derive(Args, Debug)]
#[command(after_help = format!("{EXAMPLES}\n\n{}", values::included_scenarios()))]
pub struct Arguments {
    /// Run this scenario instead of the small plant with all devices: a file, or the name of an included one (below)
    #[arg(long, value_name = "NAME|FILE")]
    scenario: Option<PathBuf>,
    /// The address of the dashboard, on this computer only; default: 127.0.0.1:8080 or a free port; with --headless there is no default
    #[arg(long, value_name = "HOST:PORT")]
    listen: Option<SocketAddr>,
    /// Keep the database in this file, which must not exist; `profivac report FILE` makes a page of it. Its times are those of
    /// the computer's clock: with --speed N every process in it looks N times faster
    #[arg(long, value_name = "FILE.db")]
    record: Option<PathBuf>,
    /// The speed relative to real time. The plant is the same at every speed; rows and pictures keep their interval in real
    /// time
    #[arg(long, value_name = "N", default_value = "1", value_parser = values::speed, allow_hyphen_values = true)]
    speed: f64,
    /// End after these seconds of real time; with --headless the end of the scenario may come first
    #[arg(long = "for", value_name = "SECONDS", value_parser = values::seconds, allow_hyphen_values = true)]
    time: Option<Duration>,
    /// Print a row every second instead of drawing, as without a terminal; fails if an exchange was lost
    #[arg(long)]
    headless: bool,
    /// Print each row as a line of JSON
    #[arg(long, requires = "headless")]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  profivac demo
  profivac demo --speed 60
  profivac demo --headless --listen 127.0.0.1:0
  profivac demo --record demo.db
  profivac demo --scenario coater --speed 60
  profivac demo --scenario my-plant.toml --speed 30
  profivac demo --headless --for 5";

/// The scenario without --scenario.
const SCENARIO: &str = include_str!("../../../../scenarios/demo.toml");
const SCENARIO_NAME: &str = "scenarios/demo.toml";

/// The address of the master.
const MASTER: u8 = 1;

/// chosen: fast enough for some hundred exchanges per second.
const BAUD: Baud = Baud::B187500;

/// The interval between two pictures.
const FRAME: Duration = Duration::from_millis(50);

/// The interval between two rows.
const PERIOD: Duration = Duration::from_secs(1);

/// The longest delay of the computer that the plant catches up with.
const MAX_LAG: Duration = Duration::from_millis(200);

/// Runs until the user quits or the time is over.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let headless = arguments.headless || !Screen::is_possible();
    if headless && !arguments.headless {
        notice(&format_args!(
            "standard output is no terminal; printing rows as with --headless, until SIGTERM, Ctrl-C or --for"
        ));
    }
    let speed = arguments.speed;
    if arguments.record.is_some() && speed > 1.0 {
        notice(&format_args!(
            "the database has the computer's time: everything in it is {speed} times as fast as in the plant"
        ));
    }
    let mut demo = Demo::new(arguments)?;
    if let Some(url) = demo.dashboard.as_ref().and_then(Dashboard::url).filter(|_| headless) {
        notice(&format_args!("the dashboard is at {url}"));
    }
    if headless {
        demo.print_rows(arguments.json, if arguments.headless { Ending::Scenario } else { Ending::Command })?
    } else {
        demo.draw_on_screen()?
    }
    demo.outcome(headless)
}

/// What ends the rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ending {
    /// The end of the scenario, or the user.
    Scenario,
    /// The user alone: a signal, or the time of --for.
    Command,
}

/// The plant and its clock.
struct Demo {
    title: String,
    run: Run,
    segment: MemorySegment,
    dashboard: Option<Dashboard>,
    speed: f64,
    signals: Signals,
    end: Option<Instant>,
    /// The real time up to which the plant has advanced.
    advanced_until: Instant,
    /// Seconds by which the plant still has to advance.
    pending_s: f64,
    /// The exchanges that the watched gauge missed without power or plug.
    missed_absent: u32,
}

/// A row of the output.
#[derive(Debug, Serialize)]
struct Row {
    /// The gauge: `bcg450@5`.
    gauge: String,
    seconds: f64,
    true_mbar: f64,
    /// The pressure that the master reads; `None` unless it is valid.
    read_mbar: Option<f64>,
    instance: u8,
    exchanges: u32,
    lost: u32,
}

impl Demo {
    fn new(arguments: &Arguments) -> Result<Self, Failure> {
        let scenario = match &arguments.scenario {
            Some(given) => Scenario::of_file_or_name(given)?,
            None => Scenario::parse(SCENARIO, SCENARIO_NAME)?,
        };
        let mut segment = scenario.memory_segment(MASTER, BAUD)?;
        let run = scenario.start(MasterPresence::Present);
        let Arguments { listen, headless, .. } = *arguments;
        let record = arguments.record.as_deref();
        let begins_vented = arguments.scenario.is_none();
        let options = DashboardOptions { is_served: !headless || listen.is_some(), listen, record, begins_vented };
        let is_wanted = options.is_served || record.is_some();
        let dashboard = is_wanted.then(|| Dashboard::open(&scenario, &mut segment, MASTER, &options)).transpose()?;
        let started = Instant::now();
        let end = arguments.time.and_then(|time| started.checked_add(time));
        let signals = Signals::catch()?;
        Ok(Self {
            title: scenario.title,
            run,
            segment,
            dashboard,
            speed: arguments.speed,
            signals,
            end,
            advanced_until: started,
            pending_s: 0.0,
            missed_absent: 0,
        })
    }

    /// Waits until `moment` and advances the plant to it. Returns false when the command ends.
    fn run_until(&mut self, moment: Instant) -> Result<bool, Failure> {
        let moment = self.end.unwrap_or(moment).min(moment);
        let readable = wait(&[self.signals.readiness()], moment.saturating_duration_since(Instant::now()))?;
        let now = Instant::now();
        let lag = now.duration_since(self.advanced_until).min(MAX_LAG);
        self.advanced_until = now;
        self.advance(lag.as_secs_f64() * self.speed);
        if let Some(dashboard) = &mut self.dashboard {
            dashboard.update(&mut self.segment, &self.run);
        }
        Ok(readable != [true] && self.end.is_none_or(|end| now < end))
    }

    /// Advances the plant by `seconds`, or by as much as the computer can calculate in [`MAX_LAG`].
    fn advance(&mut self, seconds: f64) {
        let started = Instant::now();
        self.pending_s += seconds;
        while self.pending_s >= self.run.step_s() && started.elapsed() < MAX_LAG {
            self.pending_s -= self.run.step_s();
            let next = self.run.seconds() + self.run.step_s();
            let (was_present, before) = (self.is_watched_present(), self.counters().lost);
            self.run.step_segment(&mut self.segment, next);
            if !(was_present && self.is_watched_present()) {
                self.missed_absent += self.counters().lost.saturating_sub(before);
            }
        }
        // The rest is skipped.
        self.pending_s = self.pending_s.min(self.run.step_s());
    }

    /// The gauge of the rows, as `simulate` takes it.
    fn gauge(&self) -> String {
        let watched = self.segment.slaves().first();
        watched.map_or_else(String::new, |watched| format!("{}@{}", watched.model.name, watched.address))
    }

    /// Whether the gauge of the rows has power and is connected to the bus.
    fn is_watched_present(&self) -> bool {
        self.segment.devices().next().is_none_or(VirtualDevice::is_present)
    }

    fn counters(&self) -> Counters {
        let watched = self.segment.slaves().first();
        let counters = watched.and_then(|watched| self.segment.master().counters(watched.address));
        counters.copied().unwrap_or_default()
    }

    /// A row about the gauge at the lowest address.
    fn row(&self) -> Row {
        let watched = self.segment.slaves().first();
        let reading = watched.map(|watched| self.segment.values(watched)).unwrap_or_default();
        let value = reading.values.first();
        let counters = self.counters();
        Row {
            gauge: self.gauge(),
            seconds: self.run.seconds(),
            true_mbar: self.segment.devices().next().map_or(0.0, |device| device.environment().gas.total() / 100.0),
            read_mbar: value.and_then(|value| value.pa).map(|pa| pa / 100.0),
            instance: value.map_or(0, |value| value.instance),
            exchanges: counters.exchanges,
            lost: counters.lost,
        }
    }

    fn print_rows(&mut self, json: bool, ending: Ending) -> Result<(), Failure> {
        if !json {
            out(&format!(
                "{:>9}{:>12}{:>12}{:>10}{:>11}{:>6}  {}",
                "SECONDS", "TRUE mbar", "READ mbar", "INSTANCE", "EXCHANGES", "LOST", "GAUGE"
            ));
        }
        let mut next = self.advanced_until + PERIOD;
        loop {
            let mut going = true;
            while going && Instant::now() < next {
                going = self.run_until(next.min(Instant::now() + FRAME))?;
            }
            next += PERIOD;
            // Strings and numbers always have a JSON form.
            out(&if json { serde_json::to_string(&self.row()).unwrap_or_default() } else { self.row().line() });
            check()?;
            if !going || ending == Ending::Scenario && self.run.is_over() {
                return Ok(());
            }
        }
    }

    fn draw_on_screen(&mut self) -> Result<(), Failure> {
        let mut screen = Screen::open()?;
        let mut trend = Trend::default();
        while self.run_until(Instant::now() + FRAME)? && !screen.is_quit_requested()? {
            trend.add(self.run.seconds(), &self.run, &self.row());
            screen.draw(|frame| picture::draw(frame, self, &trend))?;
        }
        Ok(())
    }

    /// With --headless, an expectation that does not hold or a lost exchange is a failure.
    fn outcome(&self, headless: bool) -> Result<(), Failure> {
        let Row { exchanges, lost, .. } = self.row();
        // A gauge without power or plug answers nothing: that is the scenario, and no fault of the line.
        let lost = lost.saturating_sub(self.missed_absent);
        self.run.failures().iter().for_each(|finding| notice(&format_args!("{finding}")));
        if !headless {
            return Ok(());
        }
        match self.run.failures().len() {
            0 if exchanges == 0 || lost > 0 => Err(Failure::no_answer(format!("{exchanges} exchanges, {lost} lost"))),
            0 => Ok(()),
            1 => Err(Failure::refused("one expectation of the scenario does not hold")),
            several => Err(Failure::refused(format!("{several} expectations of the scenario do not hold"))),
        }
    }
}

impl Row {
    fn line(&self) -> String {
        let read = self.read_mbar.map_or_else(|| "-".to_owned(), |mbar| format!("{mbar:.3e}"));
        format!(
            "{:>9.2}{:>12.3e}{read:>12}{:>10}{:>11}{:>6}  {}",
            self.seconds, self.true_mbar, self.instance, self.exchanges, self.lost, self.gauge
        )
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test")]
mod tests {
    use super::*;
    use clap::FromArgMatches;
    use std::collections::BTreeMap;

    /// A demo with --headless.
    fn demo(speed: f64) -> Demo {
        let command = Arguments::augment_args(clap::Command::new("demo"));
        let words = ["demo".to_owned(), "--headless".to_owned(), format!("--speed={speed}")];
        let matches = command.try_get_matches_from(words).unwrap();
        Demo::new(&Arguments::from_arg_matches(&matches).unwrap()).unwrap()
    }

    /// The values at each step at which the demo is observed, up to `until_s` of the plant.
    fn watched(speed: f64, until_s: f64) -> BTreeMap<u64, String> {
        let mut demo = demo(speed);
        let mut rows = BTreeMap::new();
        while demo.run.seconds() < until_s {
            // One step of real time: at speed 1 every step is observed.
            demo.advance(demo.run.step_s() * demo.speed);
            let step = (demo.run.seconds() / demo.run.step_s()).round() as u64;
            let all = demo.segment.slaves().iter().map(|watched| demo.segment.values(watched).values);
            rows.insert(step, format!("{:?} {:?}", demo.row(), all.collect::<Vec<_>>()));
        }
        rows
    }

    #[test]
    fn requests_on_the_line_do_not_advance_the_plant() {
        let mut demo = demo(1.0);
        let step_s = demo.run.step_s();
        demo.advance(step_s);
        // A minute of the line: requests to a gauge take that long.
        demo.segment.run_until(demo.segment.seconds() + 60.0);
        let asked = demo.row();
        demo.advance(3.0 * step_s);
        let row = demo.row();
        assert!(row.exchanges > asked.exchanges, "{row:?} after {asked:?}");
        assert!(row.seconds < asked.seconds + 4.0 * step_s, "{row:?} after {asked:?}");
    }

    /// The plant has its own steps, independent of the wall clock: true pressures, the values of all twelve devices and those
    /// that the master reads are equal to the last digit at the same time of the plant. Only the number of observations
    /// differs: at speed 50 every fiftieth step is shown, so shorter events may be invisible, and the trend has fewer points.
    /// Nothing is interpolated.
    #[test]
    fn a_pump_down_is_the_same_at_every_speed() {
        // From the beginning through the bypass and the opening of the gate, scenarios/demo.toml.
        let until_s = 26.0;
        let (slow, fast) = (watched(1.0, until_s), watched(50.0, until_s));
        assert!(slow.len() >= 1300 && fast.len() < slow.len() / 4, "{} and {}", slow.len(), fast.len());
        let (mut compared, last) = (0, *slow.keys().next_back().unwrap());
        for (step, row) in fast.range(..=last) {
            assert_eq!(slow.get(step), Some(row), "step {step}");
            compared += 1;
        }
        assert!(compared > 20, "{compared}");
        let true_mbar = |step: u64| slow[&step].split("true_mbar: ").nth(1).unwrap().split(',').next().unwrap().parse();
        let (before, after): (f64, f64) = (true_mbar(1).unwrap(), true_mbar(last).unwrap());
        assert!(before > 1000.0 && after < 1e-2, "it is a pump-down: {before} to {after}");
    }
}
