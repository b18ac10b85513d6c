//! `profivac demo`: a chamber is pumped down, a gauge measures, a master reads it over PROFIBUS. All of it in memory.

mod picture;
mod pump_down;

use crate::console::Signals;
use crate::failure::Failure;
use crate::output::out;
use crate::screen::Screen;
use crate::values;
use clap::Args;
use picture::Trend;
use profivac_dp::link::Baud;
use profivac_host::bench::{Conditions, VirtualDevice};
use profivac_host::instrument::{Spec, entry};
use profivac_host::memory::Memory;
use profivac_host::port::wait;
use profivac_host::pressure::Pressure;
use profivac_host::scene::Scene;
use profivac_host::watch::Watched;
use profivac_vacuum::Gas;
use rustix::fd::AsFd;
use serde::Serialize;
use std::time::{Duration, Instant};

/// A pump-down in memory: a gauge and a master on a PROFIBUS segment, with nothing attached and nothing installed.
///
/// The pressure on the right is what the master reads: every octet goes through the real codec and both state machines.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// How much faster than real time
    #[arg(long, value_name = "N", default_value = "1", value_parser = values::speed, allow_hyphen_values = true)]
    speed: f64,
    /// End after so many seconds
    #[arg(long = "for", value_name = "SECONDS", value_parser = values::seconds, allow_hyphen_values = true)]
    time: Option<Duration>,
    /// Print a row every second instead of drawing, as without a terminal; fails if a single exchange was lost
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
  profivac demo --headless --for 5";

/// The gauge, its address, and that of the master.
const DEVICE: &str = "bcg450";
const GAUGE: u8 = 5;
const MASTER: u8 = 1;

/// free choice: quick enough for some hundred exchanges a second.
const BAUD: Baud = Baud::B187500;

/// How often a picture is drawn.
const FRAME: Duration = Duration::from_millis(50);

/// How often a row is printed.
const PERIOD: Duration = Duration::from_secs(1);

/// The longest time made up for when the computer was busy with something else.
const MAX_LAG: Duration = Duration::from_millis(200);

/// The pressure follows the formula in steps of so many seconds.
const STEP: f64 = 0.01;

/// Runs until somebody wants it to end, or its time is over.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let headless = arguments.headless || !Screen::is_possible();
    if headless && !arguments.headless {
        eprintln!("profivac: there is no terminal to draw on: rows as with --headless");
    }
    let mut demo = Demo::new(arguments)?;
    if headless {
        demo.in_rows(arguments.json)?
    } else {
        demo.on_screen()?
    }
    demo.verdict(headless)
}

/// The plant, and the clock it runs by.
struct Demo {
    scene: Scene,
    speed: f64,
    signals: Signals,
    end: Option<Instant>,
    /// Up to when the plant has lived.
    lived: Instant,
}

/// One moment, as a row.
#[derive(Debug, Serialize)]
struct Row {
    seconds: f64,
    true_mbar: f64,
    /// What the master reads; nothing unless it is valid.
    read_mbar: Option<f64>,
    instance: u8,
    exchanges: u32,
    lost: u32,
}

impl Demo {
    fn new(arguments: &Arguments) -> Result<Self, Failure> {
        let spec: Spec = format!("{DEVICE}@{GAUGE}").parse()?;
        let gauge = VirtualDevice::new(spec.build(Memory::volatile(), BAUD)?, GAUGE, BAUD, conditions(0.0));
        let model = entry(DEVICE)?.model;
        let unit = model.unit_named("mbar").ok_or_else(|| Failure::usage("the gauge does not know mbar"))?;
        let watched = Watched { address: GAUGE, model, configuration: model.default_configuration, unit };
        let scene =
            Scene::new(vec![gauge], vec![watched], MASTER, BAUD).map_err(|error| Failure::usage(error.to_string()))?;
        let lived = Instant::now();
        let end = arguments.time.and_then(|time| lived.checked_add(time));
        Ok(Self { scene, speed: arguments.speed, signals: Signals::catch()?, end, lived })
    }

    /// Waits until `moment` and lets the plant live up to it. False when it is time to end.
    fn live_until(&mut self, moment: Instant) -> Result<bool, Failure> {
        let moment = self.end.unwrap_or(moment).min(moment);
        let readable = wait(&[self.signals.as_fd()], moment.saturating_duration_since(Instant::now()))?;
        let now = Instant::now();
        let lag = now.duration_since(self.lived).min(MAX_LAG);
        self.lived = now;
        self.pass(lag.as_secs_f64() * self.speed);
        Ok(readable != [true] && self.end.is_none_or(|end| now < end))
    }

    /// Time of the plant passes, as much of it as the computer can do in the same time.
    fn pass(&mut self, seconds: f64) {
        let begun = Instant::now();
        let mut at = self.scene.seconds();
        let end = at + seconds;
        while at < end && begun.elapsed() < MAX_LAG {
            at = (at + STEP).min(end);
            self.scene.surround(conditions(at));
            self.scene.run_until(at);
        }
    }

    fn row(&self) -> Row {
        let reading = self.scene.watched().first().map(|watched| self.scene.reading(watched)).unwrap_or_default();
        let value = reading.values.first();
        let counters = self.scene.master().and_then(|master| master.counters(GAUGE)).copied().unwrap_or_default();
        Row {
            seconds: self.scene.seconds(),
            true_mbar: pump_down::pressure(self.scene.seconds()).mbar(),
            read_mbar: value.and_then(|value| value.pa).map(|pa| pa / 100.0),
            instance: value.map_or(0, |value| value.instance),
            exchanges: counters.exchanges,
            lost: counters.lost,
        }
    }

    fn in_rows(&mut self, json: bool) -> Result<(), Failure> {
        if !json {
            out(&format!(
                "{:>9}{:>12}{:>12}{:>10}{:>11}{:>6}",
                "SECONDS", "TRUE mbar", "READ mbar", "INSTANCE", "EXCHANGES", "LOST"
            ));
        }
        let mut next = self.lived + PERIOD;
        loop {
            let mut going = true;
            while going && Instant::now() < next {
                going = self.live_until(next.min(Instant::now() + FRAME))?;
            }
            next += PERIOD;
            // Texts and numbers always have a JSON form.
            out(&if json { serde_json::to_string(&self.row()).unwrap_or_default() } else { self.row().line() });
            if !going {
                return Ok(());
            }
        }
    }

    fn on_screen(&mut self) -> Result<(), Failure> {
        let mut screen = Screen::open()?;
        let mut trend = Trend::default();
        while self.live_until(Instant::now() + FRAME)? && !screen.wants_to_leave()? {
            trend.add(&self.row());
            screen.draw(|frame| picture::draw(frame, &self.scene, &trend, self.speed))?;
        }
        Ok(())
    }

    /// A lost exchange is a failure where nobody sees it.
    fn verdict(&self, headless: bool) -> Result<(), Failure> {
        let Row { exchanges, lost, .. } = self.row();
        if headless && (exchanges == 0 || lost > 0) {
            return Err(Failure::no_answer(format!("{exchanges} exchanges, {lost} lost")));
        }
        Ok(())
    }
}

impl Row {
    fn line(&self) -> String {
        let read = self.read_mbar.map_or_else(|| "-".to_owned(), |mbar| format!("{mbar:.3e}"));
        format!(
            "{:>9.2}{:>12.3e}{read:>12}{:>10}{:>11}{:>6}",
            self.seconds, self.true_mbar, self.instance, self.exchanges, self.lost
        )
    }
}

/// What surrounds the gauge after so many seconds.
fn conditions(seconds: f64) -> Conditions {
    Conditions { pressure: pump_down::pressure(seconds), atmosphere: Pressure::from_mbar(1013.25), gas: Gas::N2 }
}
