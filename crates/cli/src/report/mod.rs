//! `profivac report`: writes a page about a pump-down.

use crate::database::{Database, micros, time};
use crate::failure::Failure;
use crate::output::{json, notice, out};
use crate::time_argument::checked;
use crate::values;
use crate::whole_file::{check_absent, write_text};
use clap::Args;
use jiff::tz::TimeZone;
use jiff::{Timestamp, Zoned};
use profivac_client::pressure::Pressure;
use profivac_recorder::{Micros, Reader};
use profivac_station::comparison::summary::{PlantPart, complete};
use profivac_station::config::Config;
use profivac_station::pumpdown::{PumpDown, TimeRange};
use profivac_station::report::format::{duration, moment, timestamp, with_unit};
use profivac_station::report::series::{known, moved, pump_downs};
use profivac_station::report::{GaugeInfo, Report, ReportRequest, Unit, page::page};
use serde::Serialize;
use std::ffi::OsStr;
use std::path::PathBuf;

/// Write a page about a pump-down: curves, times to pressure, pumping speed and events in one HTML file.
///
/// Without --from and --to the page covers the last pump-down: from the last sample at the highest pressure until the next vent
/// or the end of the database. The station may continue to record. The page needs only a browser, and prints on A4.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A station's database, or its file, which also has devices and levels
    #[arg(value_name = "DATABASE.db|STATION.toml")]
    source: PathBuf,
    /// A gauge; may be repeated. Default: the gauges whose pressure changed most, at most eight
    #[arg(long, value_name = "NAME")]
    gauge: Vec<String>,
    /// The beginning: '2026-11-21 14:00', 14:00, yesterday, -2h, -7d, or RFC 3339
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = checked)]
    from: Option<String>,
    /// The end, in the same form
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = checked)]
    to: Option<String>,
    /// The pumped volume: '50 l', '1.2 m3'; adds pumping speeds and leak rates
    #[arg(long, value_name = "VOLUME", value_parser = values::volume)]
    volume: Option<f64>,
    /// The accuracy of the gauge in percent of the reading, as its manual states it; it widens leak and outgassing of the plant
    #[arg(long, value_name = "PERCENT", requires = "plant")]
    accuracy: Option<f64>,
    /// Add pumping speed, leak and outgassing, as `identify` fits them; this takes seconds, or minutes if the model does not fit
    #[arg(long, requires = "volume")]
    plant: bool,
    /// Also show the time to this pressure; may be repeated
    #[arg(long, value_name = "PRESSURE")]
    to_pressure: Vec<Pressure>,
    /// The unit of the page: mbar, Pa, hPa, Torr or micron
    #[arg(long, value_name = "UNIT", default_value = "mbar")]
    unit: Unit,
    /// The heading of the page
    #[arg(long, value_name = "TITLE")]
    title: Option<String>,
    /// Write to this file, or - for standard output; default: TITLE-DATE.html
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Overwrite an existing file
    #[arg(long)]
    force: bool,
    /// Only list the pump-downs in the database
    #[arg(long, conflicts_with_all = ["out", "title", "force", "volume", "to_pressure"])]
    list: bool,
    /// Print the numbers as JSON instead of a page, in Pa, s and m3
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  profivac report plant.toml
  profivac report plant.db --list
  profivac report plant.toml --gauge chamber --volume '50 l' --to-pressure '5e-7 mbar' --title 'Acceptance of chamber 7'
  profivac report plant.db --from '2026-11-21 14:00' --to '2026-11-21 18:30' --unit Torr --out report.html
  profivac report plant.toml --volume '50 l' --plant --accuracy 15
  profivac report plant.db --from -2h --json";

/// The largest number of curves on a page without --gauge.
const MAX_CURVES: usize = 8;

/// The smallest change of pressure, in decades, for which a gauge is shown without --gauge: a fifth.
const MIN_CHANGE_DECADES: f64 = 0.1;

/// A database, and the station's file if it was given.
struct Source {
    reader: Reader,
    path: PathBuf,
    config: Option<Config>,
    /// All series, or those selected by --gauge.
    names: Vec<String>,
    unit: Unit,
    zone: TimeZone,
}

/// A pump-down in the JSON list.
#[derive(Serialize)]
struct PumpDownRow {
    begin: Timestamp,
    end: Timestamp,
    gauge: String,
    start_pa: f64,
    lowest_pa: f64,
    is_vented: bool,
}

/// Finds the pump-down, calculates and writes the page.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let now = Zoned::now();
    let source = Source::open(arguments, &now)?;
    if arguments.list {
        return source.list(arguments.json);
    }
    let (span, why) = source.span(arguments, &now)?;
    notice(&why);
    let plant = plant(arguments)?;
    let request = source.request(arguments, span, why, now.timestamp())?;
    let mut report = Report::make(&source.reader, request)?;
    complete(&source.reader, &mut report, plant, &|| false)?;
    write_report(arguments, &report)
}

impl Source {
    fn open(arguments: &Arguments, now: &Zoned) -> Result<Self, Failure> {
        let database = Database::open(&arguments.source)?;
        let names = database.series(&arguments.gauge)?;
        let Database { reader, path, config } = database;
        Ok(Self { reader, path, config, names, unit: arguments.unit, zone: now.time_zone().clone() })
    }

    /// The request for the report.
    fn request(
        &self,
        arguments: &Arguments,
        span: TimeRange,
        why: String,
        made: Timestamp,
    ) -> Result<ReportRequest, Failure> {
        let gauges = self.gauges_to_show(arguments, span)?.into_iter().map(|name| {
            let identity = self.config.as_ref().map(|config| GaugeInfo::of(config, &name)).unwrap_or_default();
            (name, identity)
        });
        let text = |part: Option<&OsStr>| part.map_or_else(String::new, |part| part.to_string_lossy().into_owned());
        let station = self.config.as_ref().map(|config| config.name.clone());
        let title = arguments.title.clone().or_else(|| station.clone());
        let title = title.unwrap_or_else(|| text(self.path.file_stem()));
        Ok(ReportRequest {
            station: station.filter(|station| *station != title),
            title,
            // Without its folder, which the reader of a page need not know.
            record: text(self.path.file_name()),
            span,
            why,
            gauges: gauges.collect(),
            volume_m3: arguments.volume,
            pressures: arguments.to_pressure.iter().map(|pressure| pressure.pa()).filter(|pa| *pa > 0.0).collect(),
            unit: arguments.unit,
            zone: self.zone.clone(),
            made: micros(made),
        })
    }

    fn recorded_span(&self) -> Result<TimeRange, Failure> {
        let known = known(&self.reader, &self.names)?;
        known.ok_or_else(|| Failure::usage(format!("{} contains no samples yet", self.path.display())))
    }

    fn local_time(&self, at: Micros) -> String {
        moment(at, &self.zone)
    }

    /// The time range, and the sentence that explains it.
    fn span(&self, arguments: &Arguments, now: &Zoned) -> Result<(TimeRange, String), Failure> {
        let (from, to) = (time(arguments.from.as_deref(), now)?, time(arguments.to.as_deref(), now)?);
        let known = self.recorded_span()?;
        let span = match (from, to) {
            (Some(start), Some(end)) if start >= end => {
                let [start, end] = [start, end].map(|at| self.local_time(at));
                return Err(Failure::usage(format!("expected a beginning before the end, got {start} to {end}")));
            }
            (None, None) => return self.last_pump_down(None, known),
            (None, Some(end)) => return self.last_pump_down(Some(end), known),
            (Some(start), end) => TimeRange { start, end: end.unwrap_or(Micros::now()).min(known.end) },
        };
        if span.start >= span.end || span.end < known.start {
            return Err(self.no_samples(span.start, to, known));
        }
        Ok((span, format!("from {} to {}, as requested", self.local_time(span.start), self.local_time(span.end))))
    }

    fn no_samples(&self, from: Micros, to: Option<Micros>, known: TimeRange) -> Failure {
        let to = to.map_or_else(String::new, |to| format!(" to {}", self.local_time(to)));
        let [first, last] = [known.start, known.end].map(|at| self.local_time(at));
        Failure::usage(format!(
            "no samples from {}{to}; {} contains {first} to {last}",
            self.local_time(from),
            self.path.display()
        ))
    }

    /// The last pump-down that began before `to`.
    fn last_pump_down(&self, to: Option<Micros>, known: TimeRange) -> Result<(TimeRange, String), Failure> {
        let all = pump_downs(&self.reader, &self.names, to.is_some())?;
        let Some(last) = all.into_iter().rfind(|pump_down| to.is_none_or(|to| pump_down.span.start < to)) else {
            let [first, last] = [known.start, known.end].map(|at| self.local_time(at));
            return Err(Failure::usage(format!(
                "found no pump-down in {}: no pressure falls by two decades from {first} to {last}; choose a time with --from and --to",
                self.path.display()
            )));
        };
        let end = to.map_or(last.span.end, |to| to.min(last.span.end));
        let span = TimeRange { end, ..last.span };
        let until = match last.is_vented {
            _ if end < last.span.end => "as requested",
            true => "before it was vented",
            false => "the end of the database",
        };
        let why = format!(
            "the last pump-down: from {}, when {:?} was last at {}, to {}, {until}",
            self.local_time(span.start),
            self.name(&last),
            with_unit(last.start_pa, self.unit).replace('\u{a0}', " "),
            self.local_time(end),
        );
        Ok((span, why))
    }

    fn name(&self, pump_down: &PumpDown) -> &str {
        self.names.get(pump_down.gauge).map_or("", String::as_str)
    }

    /// The gauges whose curves are shown.
    fn gauges_to_show(&self, arguments: &Arguments, span: TimeRange) -> Result<Vec<String>, Failure> {
        let mut all = Vec::new();
        for name in &self.names {
            all.extend(moved(&self.reader, name, span)?.map(|decades| (decades, name)));
        }
        if all.is_empty() {
            return Err(self.no_samples(span.start, Some(span.end), self.recorded_span()?));
        }
        if !arguments.gauge.is_empty() {
            return Ok(self.names.clone());
        }
        if all.iter().any(|(decades, _)| *decades > MIN_CHANGE_DECADES) {
            all.retain(|(decades, _)| *decades > MIN_CHANGE_DECADES);
        }
        all.sort_by(|one, two| two.0.total_cmp(&one.0));
        if all.len() > MAX_CURVES {
            let hidden: Vec<_> = all.drain(MAX_CURVES..).map(|(_, name)| name.as_str()).collect();
            notice(&format_args!(
                "not shown, because the page shows at most {MAX_CURVES} curves: {}; --gauge chooses",
                hidden.join(", ")
            ));
        }
        // In the order of the database, which is that of the station's file.
        let is_shown = |name: &&String| all.iter().any(|(_, shown)| shown == name);
        Ok(self.names.iter().filter(is_shown).cloned().collect())
    }

    fn row(&self, pump_down: &PumpDown) -> PumpDownRow {
        PumpDownRow {
            begin: timestamp(pump_down.span.start),
            end: timestamp(pump_down.span.end),
            gauge: self.name(pump_down).to_owned(),
            start_pa: pump_down.start_pa,
            lowest_pa: pump_down.lowest_pa,
            is_vented: pump_down.is_vented,
        }
    }

    fn list(&self, as_json: bool) -> Result<(), Failure> {
        self.recorded_span()?;
        let all = pump_downs(&self.reader, &self.names, true)?;
        if as_json {
            out(&json(&all.iter().map(|pump_down| self.row(pump_down)).collect::<Vec<_>>()));
            return Ok(());
        }
        if all.is_empty() {
            notice(&"no pressure in the database falls by two decades");
            return Ok(());
        }
        let plain = |text: String| text.replace('\u{a0}', " ");
        out(&format!("{:<26}{:<14}{:>16}{:>16}  {:<10}{}", "BEGIN", "TOOK", "FROM", "DOWN TO", "END", "GAUGE"));
        for pump_down in &all {
            let [top, low] = [pump_down.start_pa, pump_down.lowest_pa].map(|pa| plain(with_unit(pa, self.unit)));
            let end = if pump_down.is_vented { "vented" } else { "open" };
            let (begin, took) = (self.local_time(pump_down.span.start), plain(duration(pump_down.span.seconds())));
            out(&format!("{begin:<26}{took:<14}{top:>16}{low:>16}  {end:<10}{}", self.name(pump_down)));
        }
        Ok(())
    }
}

/// What the report says about the plant.
fn plant(arguments: &Arguments) -> Result<PlantPart, Failure> {
    match (arguments.plant, arguments.accuracy) {
        (_, Some(percent)) if !(0.0..=100.0).contains(&percent) => {
            Err(Failure::usage(format!("expected an accuracy from 0 to 100 percent, found {percent}")))
        }
        (true, percent) => Ok(PlantPart::Identified(percent.map(|percent| percent / 100.0))),
        (false, _) => Ok(PlantPart::Without),
    }
}

/// Writes the page or the JSON to a file or standard output.
fn write_report(arguments: &Arguments, report: &Report) -> Result<(), Failure> {
    let text = if arguments.json { json(report) + "\n" } else { page(report) };
    let path = match &arguments.out {
        Some(path) if path.as_os_str() == "-" => None,
        None if arguments.json => None,
        Some(path) => Some(path.clone()),
        None => Some(default_file_name(report)),
    };
    match path {
        None => out(text.trim_end()),
        Some(path) => {
            check_absent(&path, arguments.force)?;
            write_text(&path, &text)?;
            notice(&format_args!(
                "{} gauges, {} events in {}",
                report.gauges.len(),
                report.events.len(),
                path.display()
            ));
        }
    }
    Ok(())
}

/// `target-hall-2026-11-21-1400.html`: letters and digits of the title, and the beginning of the pump-down.
fn default_file_name(report: &Report) -> PathBuf {
    let letters = |letter: char| if letter.is_alphanumeric() { letter } else { ' ' };
    let words: String = report.title.to_lowercase().chars().map(letters).take(60).collect();
    let name = words.split_whitespace().collect::<Vec<_>>().join("-");
    let name = if name.is_empty() { "pump-down".to_owned() } else { name };
    let begin = report.begin.to_zoned(report.zone.clone());
    PathBuf::from(format!("{name}-{}.html", begin.strftime("%Y-%m-%d-%H%M")))
}
