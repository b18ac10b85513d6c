//! `profivac identify`: the numbers of a plant from one record of pump-down, base pressure and rise.

mod picture;
mod source;

use crate::failure::Failure;
use crate::output::{json, notice, out};
use crate::time_argument::{checked, parse_time};
use crate::values;
use crate::whole_file::write_text;
use clap::{Args, ValueEnum};
use jiff::{Timestamp, Zoned};
use profivac_client::pressure::Pressure;
use profivac_identify::plant::{NotIdentified, Plant, PlantRecord, identify_unless};
use profivac_identify::rise::GasDependence;
use profivac_identify::{Interval, standard_uncertainty};
use profivac_recorder::{Micros, Sample};
use profivac_station::identification::record::{Chosen, Known, KnownVolume, chosen};
use profivac_station::identification::sprays::{Circumstances, SprayView, around};
use profivac_station::identification::words::{MISFIT, Parameter, note, remedy};
use profivac_station::pumpdown::{TimeRange, find};
use profivac_station::report::format::{duration, timestamp};
use serde_json::{Value, json as object};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Fit pumping speed, leak, outgassing and ultimate pressure to a recorded pump-down, with 95 % intervals.
///
/// The record has a pump-down, best down to the base pressure, and then a rise with the valve to the pump closed. The fit needs the
/// volume, or a known dose of gas let in while the valve is closed. The command then predicts when a pressure is reached, and what would
/// help most: to close the leak, to bake, a larger pump, a better pump.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A station's file or database, or the CSV of `monitor --csv` or of an export
    #[arg(value_name = "STATION.toml|DATABASE.db|FILE.csv")]
    source: PathBuf,
    /// The gauge; needed if there are several. In the CSV of monitor it is the address
    #[arg(long, value_name = "NAME")]
    gauge: Option<String>,
    /// The start of the pump-down: '2026-11-21 14:00', 14:00, yesterday, -2h, -7d, or RFC 3339. Default: the start of the last pump-down
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = checked)]
    from: Option<String>,
    /// The end of the record, in the same form
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = checked)]
    to: Option<String>,
    /// When the valve to the pump was closed; default: the beginning of the largest rise
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = checked)]
    closed: Option<String>,
    /// When it was opened again; default: the end of that rise
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = checked)]
    opened: Option<String>,
    /// The volume: '50 l', '1.2 m3'
    #[arg(long, value_name = "VOLUME", value_parser = values::volume, required_unless_present = "dose_mbar_l", conflicts_with = "dose_mbar_l")]
    volume: Option<f64>,
    /// A dose of gas in mbar l, let in while the valve was closed, in place of the volume
    #[arg(long = "dose", value_name = "MBAR_L", requires = "dose_at")]
    dose_mbar_l: Option<f64>,
    /// When the dose was let in
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, requires = "dose_mbar_l")]
    dose_at: Option<String>,
    /// The accuracy of the gauge in percent of the reading, as its manual states it; it widens leak and outgassing
    #[arg(long, value_name = "PERCENT")]
    accuracy: Option<f64>,
    /// The kind of the gauge: with it a change that looks like helium at a leak gives the leak
    #[arg(long, value_name = "KIND")]
    gauge_kind: Option<GaugeKind>,
    /// Predict when this pressure is reached; may be repeated
    #[arg(long, value_name = "PRESSURE")]
    target: Vec<Pressure>,
    /// Stop the fit after this time; a usual fit takes seconds
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds, default_value = "300")]
    longest: Duration,
    /// Draw measurement, fit, prediction and residuals into this SVG file
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    /// Print the numbers as JSON, in Pa, s, m3 and Pa m3/s
    #[arg(long)]
    json: bool,
}

/// How an indication depends on the gas.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum GaugeKind {
    /// A capacitance diaphragm gauge, whose indication does not depend on the gas
    Diaphragm,
    /// A gauge with a hot or a cold cathode
    Ion,
    /// A Pirani gauge, which measures the conduction of heat
    Pirani,
}

impl From<GaugeKind> for GasDependence {
    fn from(kind: GaugeKind) -> Self {
        match kind {
            GaugeKind::Diaphragm => Self::None,
            GaugeKind::Ion => Self::Ionisation,
            GaugeKind::Pirani => Self::Conduction,
        }
    }
}

const EXAMPLES: &str = "\
Examples:
  profivac identify plant.toml --gauge chamber --volume '50 l'
  profivac identify plant.toml --gauge chamber --volume '50 l' --target '1e-7 mbar' --plot fit.svg
  profivac identify plant.db --from '2026-11-20 16:00' --closed '2026-11-21 08:00' --to '2026-11-21 08:30' --volume '1.2 m3' --accuracy 15
  profivac identify pressures.csv --gauge 5 --dose 0.2 --dose-at '2026-11-21 14:30' --closed '2026-11-21 14:25' --opened '2026-11-21 14:45'

How to record: start to record, pump down to the base pressure, close the valve to the pump, wait until the pressure has risen at
least tenfold, open the valve. The longer the pump-down, the better leak and outgassing can be distinguished. A dose is a jump within
the rise: give the times of the valve with it.";

/// Reads the record, fits and prints.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let source = source::read(&arguments.source, arguments.gauge.as_deref())?;
    let known = known(arguments, &source.samples)?;
    let start = known.span.start;
    let chosen = chosen(&source.samples, &known);
    let plant = fitted(&chosen.record, arguments)?;
    if let Some(path) = &arguments.plot {
        write_text(path, &picture::svg(&plant, &format!("{}: measured and fitted", source.gauge)))?;
        notice(&format_args!("drew {}", path.display()));
    }
    out(&if arguments.json {
        json(&numbers(arguments, &source.gauge, start, &chosen, &plant))
    } else {
        text(arguments, &source.gauge, start, &chosen, &plant)
    });
    Ok(())
}

/// The fit, within the time that it may take.
fn fitted(record: &PlantRecord, arguments: &Arguments) -> Result<Plant, Failure> {
    let (begun, longest) = (Instant::now(), arguments.longest);
    identify_unless(record, &|| begun.elapsed() > longest).map_err(|error| {
        let file = arguments.source.display();
        Failure::usage(match error {
            NotIdentified::Stopped => format!(
                "{file}: expected a fit within {} s, found none for {} samples; choose a shorter record with --from and --to, \
                 or give the fit more time with --longest",
                longest.as_secs_f64(),
                record.samples.len()
            ),
            NotIdentified::NoRise => format!("{file}: {error}; in --closed and --opened, a time without a date is one of today"),
            error => format!("{file}: {error}; choose the record with --from, --to, --closed and --opened"),
        })
    })
}

fn micros(at: Timestamp) -> Micros {
    Micros(at.as_microsecond())
}

/// The record between the chosen times, or of the last pump-down and the largest rise.
fn known(arguments: &Arguments, samples: &[Sample]) -> Result<Known, Failure> {
    let now = Zoned::now();
    let time = |text: &Option<String>| text.as_deref().map(|text| parse_time(text, &now).map(micros)).transpose();
    let (from, to) = (time(&arguments.from)?, time(&arguments.to)?);
    let end = to.or_else(|| samples.last().map(|sample| sample.at)).unwrap_or(Micros(0));
    let start =
        match from {
            Some(from) => from,
            None => find(samples, 0).iter().rfind(|one| one.span.start < end).map(|one| one.span.start).ok_or_else(
                || Failure::usage("expected a pump-down, found no fall by two decades; choose its start with --from"),
            )?,
        };
    let volume = match (arguments.volume, arguments.dose_mbar_l, time(&arguments.dose_at)?) {
        (Some(m3), ..) => KnownVolume::Given(m3),
        // 1 mbar l is 0.1 Pa m³.
        (None, Some(mbar_l), Some(at)) => KnownVolume::Dose { amount: mbar_l * 0.1, at },
        _ => return Err(Failure::usage("expected --volume, or --dose with --dose-at")),
    };
    let accuracy = arguments.accuracy.unwrap_or(0.0);
    if !(0.0..=100.0).contains(&accuracy) {
        return Err(Failure::usage(format!("expected an accuracy from 0 to 100 percent, found {accuracy}")));
    }
    Ok(Known {
        span: TimeRange { start, end },
        closed: time(&arguments.closed)?,
        opened: time(&arguments.opened)?,
        volume,
        gauge_uncertainty: standard_uncertainty(accuracy / 100.0),
    })
}

/// No pressure, gas flow or speed is as small as this: it is zero.
const NOTHING: f64 = 1e-25;

/// Three digits, so that a table stays narrow.
fn digits(value: f64) -> String {
    let size = value.abs();
    if value.is_infinite() {
        "∞".to_owned()
    } else if size < NOTHING {
        "0".to_owned()
    } else if (0.01..1e4).contains(&size) {
        let places = (2 - size.log10().floor() as i32).clamp(0, 4) as usize;
        format!("{value:.places$}")
    } else {
        format!("{value:.2e}")
    }
}

fn interval(found: Interval, one: f64, unit: &str) -> String {
    let [mean, low, high] = [found.mean, found.low, found.high].map(|value| digits(value / one));
    format!("{mean} {unit} ({low} to {high})").replace("  ", " ")
}

/// A time, or from when on at the earliest.
fn hours(found: Interval) -> String {
    if found.mean.is_finite() {
        interval(found, 3_600.0, "h")
    } else {
        format!("perhaps never, not before {} h", digits(found.low / 3_600.0))
    }
}

fn text(arguments: &Arguments, gauge: &str, start: Micros, chosen: &Chosen, plant: &Plant) -> String {
    let rise = chosen.rise.map_or_else(
        || "no rise with a closed valve: leak and speed follow from the curve alone".to_owned(),
        |[closed, opened]| format!("valve closed from {} to {}", duration(closed), duration(opened)),
    );
    let rise = rise.replace('\u{a0}', " ");
    let mut lines = vec![format!(
        "{gauge}: {} samples since {}, {rise}",
        chosen.record.samples.len(),
        timestamp(start).to_string()
    )];
    let rows = plant_rows(arguments, plant).into_iter().chain(prediction_rows(arguments, plant));
    lines.extend(rows.map(|(name, value)| format!("  {name:<32} {value}")));
    lines.extend(sprays(arguments, start, chosen, plant).iter().map(|spray| format!("{}.", spray.text)));
    lines.extend(notes(arguments, plant).into_iter().map(|(name, text)| format!("{name} {text}.")));
    lines.push(accuracy_note(arguments));
    lines.join("\n")
}

/// A flow in mbar l/s: 0.1 Pa m³/s.
fn flow(found: Interval) -> String {
    interval(found, 0.1, "mbar l/s")
}

fn mbar(found: Interval) -> String {
    interval(found, 100.0, "mbar")
}

/// The numbers of the plant, and how well they fit.
fn plant_rows(arguments: &Arguments, plant: &Plant) -> Vec<(String, String)> {
    let fits = if plant.misfit > MISFIT {
        "the fit does not describe the record: do not rely on these numbers"
    } else {
        "a good fit is near 1"
    };
    let volume = if arguments.volume.is_some() {
        format!("{} l, as given", digits(plant.volume_m3.mean * 1e3))
    } else {
        interval(plant.volume_m3, 1e-3, "l")
    };
    let speed = |(pa, speed): &(f64, Interval)| {
        (format!("speed at {} mbar", digits(pa / 100.0)), interval(*speed, 1e-3, "l/s"))
    };
    let mut rows = vec![("volume".to_owned(), volume)];
    rows.extend(plant.speeds.iter().map(speed));
    let others = [
        ("leak", flow(plant.leak)),
        ("outgassing after 1 h", flow(plant.outgassing_1h)),
        ("exponent of outgassing", interval(plant.exponent, 1.0, "")),
        ("ultimate pressure of pump", mbar(plant.ultimate_pa)),
        ("misfit", format!("{} ({fits})", digits(plant.misfit))),
        ("residuals", picture::residual_line(&plant.residuals)),
    ];
    rows.extend(others.map(|(name, value)| (name.to_owned(), value)));
    rows
}

/// The parts of the pressure at the end, what comes, and what would help.
fn prediction_rows(arguments: &Arguments, plant: &Plant) -> Vec<(String, String)> {
    let [leak, walls, pump] = plant.parts_pa(plant.end_s());
    let parts = [
        ("pressure at the end by leak", mbar(leak)),
        ("  by outgassing", mbar(walls)),
        ("  by the pump", mbar(pump)),
        ("with the valve open: + 1 d", mbar(plant.predicted_pa(plant.end_s() + 86_400.0))),
    ];
    let mut rows: Vec<_> = parts.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
    rows.extend(arguments.target.iter().map(|target| {
        let found = plant.time_to_pa(target.pa());
        let name = format!("{} mbar is reached after", digits(target.pa() / 100.0));
        (name, found.map_or_else(|| "not within a year".to_owned(), hours))
    }));
    rows.push(("what would help most".to_owned(), "pressure after another day, divided by".to_owned()));
    let remedies = plant.remedies().into_iter();
    rows.extend(remedies.map(|(one, factor)| (String::new(), format!("{:>8}  {}", digits(factor.mean), remedy(one)))));
    rows
}

/// The changes of the indication that look like helium at a leak.
fn sprays(arguments: &Arguments, start: Micros, chosen: &Chosen, plant: &Plant) -> Vec<SprayView> {
    let known = Circumstances { gauge: arguments.gauge_kind.map(GasDependence::from), plant: Some(plant) };
    around(start, &chosen.indicated, chosen.rise, known)
}

/// What the record does not determine, by the name in the table.
fn notes(arguments: &Arguments, plant: &Plant) -> Vec<(String, &'static str)> {
    let speeds = plant
        .speeds
        .iter()
        .map(|(pa, speed)| (format!("The speed at {} mbar", digits(pa / 100.0)), note(Parameter::Speed, *speed)));
    let volume = note(Parameter::Volume, plant.volume_m3).filter(|_| arguments.volume.is_none());
    let others = [
        ("The volume", volume),
        ("The leak", note(Parameter::Leak, plant.leak)),
        ("The outgassing", note(Parameter::Outgassing, plant.outgassing_1h)),
        ("The exponent", note(Parameter::Exponent, plant.exponent)),
        ("The ultimate pressure", note(Parameter::Ultimate, plant.ultimate_pa)),
    ];
    let others = others.map(|(name, note)| (name.to_owned(), note));
    speeds.chain(others).filter_map(|(name, note)| Some((name, note?))).collect()
}

fn accuracy_note(arguments: &Arguments) -> String {
    let gauge = match arguments.accuracy {
        Some(percent) => format!("with an accuracy of the gauge of ±{percent} %"),
        None => "without the uncertainty of the gauge (--accuracy)".to_owned(),
    };
    format!("95 % intervals, {gauge}; as indicated, not corrected for the gas.")
}

fn view(found: Interval) -> Value {
    object!({ "mean": found.mean, "low": found.low, "high": if found.high.is_finite() { object!(found.high) } else { Value::Null } })
}

fn numbers(arguments: &Arguments, gauge: &str, start: Micros, chosen: &Chosen, plant: &Plant) -> Value {
    let [leak, walls, pump] = plant.parts_pa(plant.end_s());
    object!({
        "gauge": gauge,
        "start": timestamp(start).to_string(),
        "samples": chosen.record.samples.len(),
        "closed_s": chosen.rise.map(|[closed, _]| closed),
        "opened_s": chosen.rise.map(|[_, opened]| opened),
        "volume_m3": view(plant.volume_m3),
        "is_volume_given": arguments.volume.is_some(),
        "speeds": plant.speeds.iter().map(|(pa, speed)| object!({ "pa": pa, "m3_per_s": view(*speed) })).collect::<Vec<_>>(),
        "leak_pa_m3_per_s": view(plant.leak),
        "outgassing_1h_pa_m3_per_s": view(plant.outgassing_1h),
        "outgassing_exponent": view(plant.exponent),
        "ultimate_pa": view(plant.ultimate_pa),
        "misfit": plant.misfit,
        "accuracy_percent": arguments.accuracy,
        "notes": notes(arguments, plant).iter().map(|(name, text)| format!("{name} {text}.")).collect::<Vec<_>>(),
        "at_end_pa": { "by_leak": view(leak), "by_outgassing": view(walls), "by_pump": view(pump) },
        "after_another_day_pa": view(plant.predicted_pa(plant.end_s() + 86_400.0)),
        "targets": arguments.target.iter().map(|target| object!({
            "pa": target.pa(), "s": plant.time_to_pa(target.pa()).map(view)
        })).collect::<Vec<_>>(),
        "remedies": plant.remedies().iter().map(|(one, factor)| object!({
            "remedy": remedy(*one), "pressure_divided_by": view(*factor)
        })).collect::<Vec<_>>(),
        "sprays": sprays(arguments, start, chosen, plant),
        "residuals": plant.residuals.iter().map(|one| object!({
            "s": one.at_s, "measured_pa": one.measured_pa, "fitted_pa": one.fitted_pa, "deviations": one.deviations
        })).collect::<Vec<_>>(),
    })
}
