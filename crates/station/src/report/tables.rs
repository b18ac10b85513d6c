//! The tables of a report.

use super::figures::{Gauge, Outcome, PressurePoint, Reached, Report, ReportEvent, Rising, Slope};
use super::format::{Unit, duration, escape, number, pressure, target_pressure, time_of_day, with_unit};
use super::plot::swatch;
use crate::identification::view::{BoundsView, ParameterView, PlantFlowView};
use crate::pumpdown::compare::Direction;
use crate::pumpdown::time_range::seconds;
use crate::view::{IntervalView, RiseCause};
use profivac_recorder::{Micros, Quality};
use profivac_vacuum::Gas;

/// A table that scrolls sideways on a narrow screen.
fn table(caption: &str, head: &str, rows: &[String]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let rows: String = rows.iter().map(|row| format!("<tr>{row}</tr>\n")).collect();
    let caption = if caption.is_empty() { String::new() } else { format!("<caption>{caption}</caption>\n") };
    format!(
        "<div class=\"wide\" tabindex=\"0\" role=\"group\" aria-label=\"Table, can be moved sideways\">\n<table>\n{caption}\
         <thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table>\n</div>\n"
    )
}

fn heads(words: &[&str]) -> String {
    words.iter().map(|word| format!("<th scope=\"col\">{word}</th>")).collect()
}

fn cell(text: &str) -> String {
    format!("<td>{text}</td>")
}

/// The longest name without a line break, in characters.
const SHORT: usize = 24;

fn named(style: usize, gauge: &Gauge) -> String {
    let class = if gauge.name.chars().count() > SHORT { " class=\"text\"" } else { "" };
    format!("<th scope=\"row\"{class}>{}{}</th>", swatch(style), escape(&gauge.name))
}

/// The gauges. Columns from the configuration file are left out if it has no entry for any gauge.
pub fn gauges(report: &Report) -> String {
    let is_known = report.gauges.iter().any(|gauge| gauge.identity.device.is_some());
    let row = |(style, gauge): (usize, &Gauge)| {
        let identity = if is_known { identity(gauge) } else { String::new() };
        let pressure = |seen: Option<PressurePoint>| {
            seen.map_or("–".to_owned(), |seen| {
                format!("{}<small>{}</small>", pressure(seen.pa, report.unit), time_of(report, seen))
            })
        };
        let lowest = lowest_bound(gauge)
            .map_or_else(|| pressure(gauge.lowest), |end| format!("&lt; {}", self::pressure(end, report.unit)));
        let ends = [pressure(gauge.first), lowest, pressure(gauge.last)].map(|text| cell(&text));
        named(style, gauge) + &identity + &ends.concat()
    };
    let rows: Vec<String> = report.gauges.iter().enumerate().map(row).collect();
    let unit = report.unit.name();
    let ends = ["First valid", "Lowest", "Last valid"].map(|word| format!("{word}, {unit}"));
    let ends = heads(&ends.each_ref().map(String::as_str));
    let known = if is_known { heads(&["Device", "Address", "Segment", "Gas"]) } else { String::new() };
    table("", &(heads(&["Gauge"]) + &known + &ends), &rows)
}

/// The time of day of a pressure.
fn time_of(report: &Report, seen: PressurePoint) -> String {
    time_of_day(Micros(seen.at.as_microsecond()), report.span.start, &report.zone)
}

/// The 95 % interval of a value. Where both ends have the digits of the value, its width.
fn interval_text([mean, low, high]: [f64; 3], text: &dyn Fn(f64) -> String) -> String {
    let [low_text, high_text] = [low, high].map(|end| if end == 0.0 { "0".to_owned() } else { text(end) });
    if low_text != high_text {
        return format!("{low_text} to {high_text}");
    }
    // chosen: no interval of a measurement is narrower than this.
    let percent = (100.0 * (high - mean).max(mean - low) / mean.abs()).max(0.01);
    format!("±{}\u{a0}%", number(percent))
}

/// The end of the range in Pa that stands for the lowest pressure of a gauge that was below its range.
pub fn lowest_bound(gauge: &Gauge) -> Option<f64> {
    let below = gauge.trace.sections.iter().filter(|section| section.quality == Quality::Underrange);
    below.filter_map(|section| section.points.last()).map(|(_, pa)| *pa).reduce(f64::min)
}

fn identity(gauge: &Gauge) -> String {
    let identity = &gauge.identity;
    let known = |text: Option<&String>| text.map_or("–".to_owned(), |text| escape(text));
    [
        known(identity.device.as_ref()),
        identity.address.map_or("–".to_owned(), |address| address.to_string()),
        known(identity.segment.as_ref()),
        identity.gas.as_ref().map_or("nitrogen, air".to_owned(), |gas| escape(gas_word(gas))),
    ]
    .map(|text| cell(&text))
    .concat()
}

/// The English name of a gas of the configuration file.
fn gas_word(name: &str) -> &str {
    match name.parse::<Gas>() {
        Ok(gas) => gas.word(),
        Err(_) => name,
    }
}

/// The time at which each gauge reached each pressure.
pub fn times(report: &Report) -> String {
    let rows = report.targets.iter().enumerate().map(|(index, target)| {
        let cells = report.gauges.iter().filter_map(|gauge| Some(reached(report, gauge, gauge.times.get(index)?)));
        format!("<th scope=\"row\">{}</th>{}", escape(&target.words(report.unit)), cells.collect::<String>())
    });
    let rows: Vec<String> = rows.collect();
    let caption = "Since the beginning, for the first time; below it the time of day.";
    table(caption, &format!("<th scope=\"col\">Pressure</th>{}", columns(report)), &rows)
}

/// The time that each decade took.
pub fn decades(report: &Report) -> String {
    let one = report.unit.pa();
    let is_power = |pa: f64| ((pa / one).log10() - (pa / one).log10().round()).abs() < 1e-6;
    let powers: Vec<usize> =
        report.targets.iter().enumerate().filter(|(_, target)| is_power(target.pa)).map(|(index, _)| index).collect();
    let rows: Vec<String> = powers.windows(2).filter_map(|pair| decade_row(report, pair[0], pair[1])).collect();
    table("", &format!("<th scope=\"col\">From – to, {}</th>{}", report.unit.name(), columns(report)), &rows)
}

/// `None` if no gauge crossed both ends.
fn decade_row(report: &Report, from: usize, to: usize) -> Option<String> {
    let time =
        |gauge: &Gauge, index: usize| gauge.times.get(index).filter(|reached| reached.outcome == Outcome::Reached)?.s;
    let took = |gauge: &Gauge| Some(time(gauge, to)? - time(gauge, from)?);
    if report.gauges.iter().all(|gauge| took(gauge).is_none()) {
        return None;
    }
    let cells = report
        .gauges
        .iter()
        .map(|gauge| took(gauge).map_or("<td class=\"no\">–</td>".to_owned(), |s| cell(&duration(s))));
    let [from, to] = [from, to].map(|index| report.targets.get(index).map_or(0.0, |target| target.pa));
    let head =
        format!("<th scope=\"row\">{} – {}</th>", target_pressure(from, report.unit), target_pressure(to, report.unit));
    Some(head + &cells.collect::<String>())
}

/// The fastest fall of each gauge.
pub fn speeds(report: &Report) -> String {
    let row = |(style, gauge): (usize, &Gauge)| {
        let fall = gauge.quickest?;
        let speed = fall
            .speed_m3_per_s
            .map(|speed| cell(&format!("{} l/s<small>{} m³/h</small>", number(speed * 1e3), number(speed * 3_600.0))));
        let cells = [
            cell(&duration(fall.time_constant_s)),
            speed.unwrap_or_default(),
            cell(&with_unit(fall.pa, report.unit)),
            cell(&duration(fall.s)),
        ];
        Some(named(style, gauge) + &cells.concat())
    };
    let rows: Vec<String> = report.gauges.iter().enumerate().filter_map(row).collect();
    let speed = if report.volume_m3.is_some() { "<th scope=\"col\">Highest effective speed</th>" } else { "" };
    let head = format!("{}{speed}{}", heads(&["Gauge", "Shortest time constant"]), heads(&["Near", "After"]));
    let note = match report.volume_m3 {
        Some(_) => "",
        None => "<p class=\"note\">With the volume this would be a pumping speed: S = V / τ.</p>\n",
    };
    let table = table("", &head, &rows);
    if table.is_empty() { table } else { table + note }
}

/// The slope in the last decade of time, with possible causes.
pub fn slopes(report: &Report) -> String {
    let row = |(style, gauge): (usize, &Gauge)| {
        let slope = gauge.slope?;
        let rose = gauge.rises.iter().any(|rise| rise.to.s > slope.from_s);
        let cells = [
            cell(&format!("{} ± {:.2}", hundredths(slope.exponent), slope.error.max(0.005))),
            cell(&format!("{} to {}", duration(slope.from_s), duration(slope.to_s))),
            cell(if rose { "no straight line: the pressure rose in this time" } else { meaning(&slope) }),
        ];
        Some(named(style, gauge) + &cells.concat())
    };
    let rows: Vec<String> = report.gauges.iter().enumerate().filter_map(row).collect();
    let table = table("", &heads(&["Gauge", "n in p ~ t<sup>−n</sup>", "In the time", "Possible cause"]), &rows);
    if table.is_empty() {
        return table;
    }
    table
        + "<p class=\"note\">A slope is a hint and no proof: it depends on the chosen beginning, and a bake-out, a leak, the ultimate pressure of \
             the pump or the lower end of a gauge change it as well.</p>\n"
}

/// A number with two decimals. Zero has no sign.
fn hundredths(value: f64) -> String {
    let text = format!("{value:.2}");
    if text == "-0.00" { "0.00".to_owned() } else { text }
}

fn meaning(slope: &Slope) -> &'static str {
    match slope.exponent {
        _ if slope.error > 0.1 => "no straight line: something changed in this time",
        ..0.1 => "nearly constant: ultimate pressure, a leak, or the end of the range",
        0.1..0.35 => "flattening: near an ultimate pressure, or a leak besides outgassing",
        0.35..0.7 => "typical of diffusion out of polymers and elastomers (about 0.5)",
        0.7..0.85 => "between diffusion (0.5) and metal surfaces (1)",
        0.85..1.3 => "typical of water on unbaked metal surfaces (about 1)",
        _ => "steeper than outgassing: the volume is still being evacuated, or something cools down",
    }
}

/// The rises in the time range.
pub fn rises(report: &Report) -> String {
    let rows =
        report.gauges.iter().enumerate().flat_map(|(style, gauge)| {
            gauge.rises.iter().map(move |rise| named(style, gauge) + &rise_cells(report, rise))
        });
    let rows: Vec<String> = rows.collect();
    let columns =
        ["Gauge", "From", "To", "Duration", "Leak", "Outgassing at the start", "Effective speed before", "Cause"];
    let table = table("", &heads(&columns), &rows);
    if table.is_empty() {
        return table;
    }
    table
        + "<p class=\"note\">A flow and a speed are valid only if the valve to the pump was closed during the rise, which the pressure alone does \
           not show. Intervals of 95 % are as indicated: not corrected for the gas, without the uncertainty of the gauge. The speed is the gas that \
           the valve stopped divided by the pressure before.</p>\n"
}

fn rise_cells(report: &Report, rise: &Rising) -> String {
    let point =
        |seen: PressurePoint| format!("{}<small>{}</small>", with_unit(seen.pa, report.unit), time_of(report, seen));
    let unit = report.unit;
    let with_interval = |IntervalView { mean, low, high }: IntervalView, text: &dyn Fn(f64) -> String, unit: &str| {
        format!("{} {unit}<small>{}</small>", text(mean), interval_text([mean, low, high], text))
    };
    let rate = |rate| with_interval(rate, &|pa_per_s| pressure(pa_per_s, unit), &format!("{}/s", unit.name()));
    let flow = |flow| with_interval(flow, &|pa_m3_per_s| number(pa_m3_per_s * 10.0), "mbar l/s");
    let part = |as_flow: Option<IntervalView>, as_rate: Option<IntervalView>| {
        as_flow.map(flow).or_else(|| as_rate.map(rate)).unwrap_or_else(|| "–".to_owned())
    };
    let leak = part(rise.leak_pa_m3_per_s, rise.leak_pa_per_s);
    let outgassing = part(rise.outgassing_pa_m3_per_s, rise.outgassing_pa_per_s);
    let words = match rise.cause {
        None => rise.note.unwrap_or_default(),
        Some(RiseCause::Leak) => "a leak; outgassing is not certain",
        Some(RiseCause::Outgassing) => "outgassing; a leak is not certain",
        Some(RiseCause::Both) => "a leak and outgassing",
        Some(RiseCause::Undistinguished) => "leak and outgassing cannot be distinguished",
        Some(RiseCause::NoRise) => "no certain rise",
    };
    let speed = rise.speed_m3_per_s.map_or_else(|| "–".to_owned(), |speed| format!("{} l/s", number(speed * 1e3)));
    let duration = duration(rise.to.s - rise.from.s);
    [point(rise.from), point(rise.to), duration, leak, outgassing, speed, words.to_owned()]
        .map(|text| cell(&text))
        .concat()
}

/// The numbers of the plant; empty without a volume.
pub fn plant(report: &Report) -> String {
    let Some(plant) = &report.plant else {
        let note = |note: &String| format!("<p class=\"note\">The plant cannot be identified: {}.</p>\n", escape(note));
        return report.plant_note.as_ref().map_or_else(String::new, note);
    };
    let row = |name: &str, unit: &str, found: [f64; 3], note: Option<&String>| {
        let text = |value: f64| if value.is_finite() { number(value) } else { "∞".to_owned() };
        let (mean, interval) = (text(found[0]), interval_text(found, &text));
        let note = note.map_or_else(String::new, |note| format!("<small>{}</small>", escape(note)));
        format!("<th scope=\"row\">{name}{note}</th><td>{mean} {unit}</td><td>{interval}</td>")
    };
    let parameter = |name: &str, unit: &str, size: f64, found: &ParameterView| {
        let BoundsView { mean, low, high } = found.value;
        let bounds = [mean, low, high.unwrap_or(f64::INFINITY)].map(|value| value / size);
        row(name, unit, bounds, found.note.as_ref())
    };
    let flow = |name: &str, found: &PlantFlowView| {
        let IntervalView { mean, low, high } = found.flow.mbar_l_per_s;
        row(name, "mbar\u{a0}l/s", [mean, low, high], found.note.as_ref())
    };
    let speeds = plant.speeds.iter().map(|speed| {
        let name = format!("Effective speed at {}", with_unit(speed.pa, report.unit));
        parameter(&name, "l/s", 1e-3, &speed.m3_per_s)
    });
    let others = [
        flow("Leak", &plant.leak),
        flow("Outgassing after 1 h", &plant.outgassing_1h),
        parameter("Exponent of outgassing", "", 1.0, &plant.exponent),
        parameter("Ultimate pressure of the pump", report.unit.name(), report.unit.pa(), &plant.ultimate_pa),
    ];
    let rows: Vec<String> = speeds.chain(others).collect();
    let accuracy = plant.accuracy.map_or_else(
        || "without the uncertainty of the gauge".to_owned(),
        |accuracy| format!("with an accuracy of the gauge of ±{} %", number(accuracy * 100.0)),
    );
    let worth =
        if plant.is_described { "Near 1 is as good as the noise permits" } else { "Do not rely on these numbers" };
    let remedies = plant.remedies.iter().map(|remedy| {
        format!(
            "<li>{}: the pressure after another day divided by {}</li>\n",
            remedy.text,
            number(remedy.divided_by.mean)
        )
    });
    format!(
        "{}<p class=\"note\">Fitted to the record of {}; the residuals are {} times the noise. {worth}. Intervals of 95 %, {accuracy}, \
         as indicated: not corrected for the gas.</p>\n<p>What would help most:</p>\n<ol>\n{}</ol>\n",
        table("", &heads(&["Quantity", "Value", "Interval"]), &rows),
        escape(&plant.series),
        number(plant.misfit),
        remedies.collect::<String>()
    )
}

/// The times beside the usual ones; empty if the gauge has no pump-down.
pub fn usual(report: &Report) -> String {
    let Some(usual) = &report.usual else { return String::new() };
    let time = |s: Option<f64>, none: &str| s.map_or_else(|| none.to_owned(), duration);
    let rows = usual.levels.iter().filter(|level| level.usual_s.is_some()).map(|level| {
        let limits = level.limits_s.map(|[least, most]| format!("{} to {}", duration(least), duration(most)));
        format!(
            "<th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td>",
            with_unit(level.pa, report.unit),
            time(level.s, "not reached"),
            time(level.usual_s, ""),
            limits.unwrap_or_default(),
            level.deviation.map(Direction::word).unwrap_or_default()
        )
    });
    let rows: Vec<String> = rows.collect();
    let likeness = usual.likeness.as_ref().map_or_else(String::new, |likeness| format!(": {}", escape(likeness)));
    let sprays: String = usual.sprays.iter().map(|text| format!("<p>{}.</p>\n", escape(text))).collect();
    format!(
        "<p>{}: {}{likeness}.</p>\n{sprays}{}",
        escape(&usual.gauge),
        escape(&usual.text),
        table("", &heads(&["Pressure", "Time", "Usual time", "Limits", "Deviation"]), &rows)
    )
}

/// The events.
pub fn events(report: &Report) -> String {
    let row = |event: &ReportEvent| {
        let s = seconds(report.span.start, event.moment);
        let at = time_of_day(event.moment, report.span.start, &report.zone);
        let cells = [
            format!("<span class=\"number\">{}</span>", event.number),
            at,
            duration(s),
            event.gauge.as_ref().map_or("–".to_owned(), |gauge| escape(gauge)),
            escape(&event.text),
        ];
        cells.map(|text| cell(&text)).concat()
    };
    let rows: Vec<String> = report.events.iter().map(row).collect();
    let more = if report.has_more_events {
        "<p class=\"note\">There were more events; these are the latest ones.</p>\n"
    } else {
        ""
    };
    let table = table("", &heads(&["No.", "Time of day", "Since the beginning", "Gauge", "Event"]), &rows);
    if table.is_empty() { "<p>There are no events in this time range.</p>\n".to_owned() } else { table + more }
}

/// The data behind the numbers.
pub fn coverage(report: &Report) -> String {
    let row = |(style, gauge): (usize, &Gauge)| {
        let coverage = &gauge.coverage;
        let time = |s: f64| if s > 0.0 { duration(s) } else { "–".to_owned() };
        let spacing = coverage.spacing_s.map_or("–".to_owned(), duration);
        let cells = [
            coverage.samples.to_string(),
            coverage
                .coarsest_s
                .map_or(spacing.clone(), |span| format!("{spacing}<small>in part means of {}</small>", duration(span))),
            time(coverage.valid_s),
            time(coverage.overrange_s),
            time(coverage.underrange_s),
            time(coverage.off_s),
            time(coverage.missing_s),
            time(coverage.fault_s),
            time(coverage.stale_s),
            time(coverage.assumed_s),
        ];
        named(style, gauge) + &cells.iter().map(|text| cell(text)).collect::<String>()
    };
    let rows: Vec<String> = report.gauges.iter().enumerate().map(row).collect();
    let head = heads(&[
        "Gauge",
        "Samples kept",
        "Usually every",
        "Measured",
        "Above its range",
        "Below its range",
        "Off",
        "No gauge",
        "Fault",
        "No samples",
        "Assumed",
    ]);
    let percent = (10_f64.powf(report.dead_band_decades) - 1.0) * 100.0;
    table("", &head, &rows)
        + &format!(
            "<p class=\"note\">A recorder keeps a sample when the pressure has changed by {} decades ({percent:.1} %), when its quality \
             has changed, and once a minute; around events it keeps every sample. The database does not \
             show samples that the recorder could not store.</p>\n",
            report.dead_band_decades
        )
}

/// The methods of calculation.
pub fn how(report: &Report) -> String {
    let volume = report.volume_m3.is_some();
    let mut parts = vec![
        (
            "Beginning",
            "If the program finds it, the last sample within 5 % of the highest pressure, and from there back to where the pressure began to fall monotonically. All times count from it.",
        ),
        ("Outliers", "Times and slopes are taken from a running median of five samples; the curves show every sample."),
        (
            "Time to pressure",
            "The first time at or below it; between two samples <span class=\"formula\">t = t₀ + (t₁ − t₀) ln(p₀/p) / ln(p₀/p₁)</span>. If the crossing lies in a gap of valid samples, the table has both ends of the gap. While the pressure is above its range, a gauge cannot show when a higher pressure was crossed.",
        ),
        (
            "Time constant",
            "At every sample since the last one with twice the pressure, over at least four samples: <span class=\"formula\">τ = Δt / ln(p₀/p₁)</span>. The shortest counts.",
        ),
    ];
    if volume {
        parts.push(("Effective pumping speed", "<span class=\"formula\">S = V / τ = −(V/p) dp/dt</span>, from the indicated pressure and the volume as given. It is that of the pump with all tubes and valves before the chamber, less what outgassing and leaks bring; a factor for the gas cancels as long as it is the same along the fall."));
    }
    parts.extend([
        ("Slope at the end", "A straight line by least squares through <span class=\"formula\">log p</span> over <span class=\"formula\">log t</span> in the last decade of time, at 40 places evenly over log t; ± is its standard error."),
        ("Rises", "Threefold or more, for 20 s or more. A leak <span class=\"formula\">dp/dt = a</span> and outgassing <span class=\"formula\">b (1 + t/t₀)^−α</span>, or outgassing that returns to the wall, are fitted together; t₀ is the time of pumping before. An interval holds every value with which one of them fits. Not given where none does."),
        ("Digits", "Gauges of these kinds are accurate to some per cent at best, and often to 15 to 50 %. Numbers have two digits; profivac report --json gives the data with all digits."),
    ]);
    let parts: String =
        parts.iter().map(|(term, words)| format!("<div><dt>{term}</dt><dd>{words}</dd></div>\n")).collect();
    format!("<dl class=\"how\">\n{parts}</dl>\n{}", units(report.unit))
}

fn units(unit: Unit) -> String {
    match unit {
        Unit::Pa => String::new(),
        other => format!("<p class=\"note\">1 {} = {} Pa.</p>\n", other.name(), (other.pa() * 1e4).round() / 1e4),
    }
}

/// A table cell with a duration, and the time of day below it.
fn reached(report: &Report, gauge: &Gauge, reached: &Reached) -> String {
    let at = |s: f64| {
        let at = Micros(report.span.start.0.saturating_add((s * 1e6) as i64));
        time_of_day(at, report.span.start, &report.zone)
    };
    let lowest = || {
        gauge
            .lowest
            .map_or("no valid pressure".to_owned(), |seen| format!("lowest {}", with_unit(seen.pa, report.unit)))
    };
    match (reached.outcome, reached.s, reached.from_s) {
        (Outcome::Reached, Some(s), _) => format!("<td>{}<small>{}</small></td>", duration(s), at(s)),
        (Outcome::Between, Some(s), Some(from)) => {
            format!("<td>{} to {}<small>not recorded between</small></td>", duration(from), duration(s))
        }
        (Outcome::Before, Some(s), _) => format!("<td>≤ {}<small>could not measure before</small></td>", duration(s)),
        (Outcome::Already, _, _) => "<td class=\"no\">from the beginning</td>".to_owned(),
        (Outcome::Unknown, _, Some(from)) => {
            let end = reached.limit_pa.map_or(String::new(), |end| format!(" (&lt; {})", with_unit(end, report.unit)));
            format!("<td class=\"no\">unknown<small>below its range{end} since {}</small></td>", at(from))
        }
        _ => format!("<td class=\"no\">not reached<small>{}</small></td>", lowest()),
    }
}

/// The column heads for all gauges.
fn columns(report: &Report) -> String {
    let head =
        |(style, gauge): (usize, &Gauge)| format!("<th scope=\"col\">{}{}</th>", swatch(style), escape(&gauge.name));
    report.gauges.iter().enumerate().map(head).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_has_no_sign_and_a_gas_has_its_name() {
        assert_eq!([-0.004, 0.004, -0.006, 1.0].map(hundredths), ["0.00", "0.00", "-0.01", "1.00"]);
        assert_eq!(["ar", "air", "freon12"].map(gas_word), ["argon", "air", "freon 12"]);
    }

    #[test]
    fn an_interval_whose_ends_have_the_digits_of_the_value_has_its_width() {
        assert_eq!(interval_text([2.0, 1.2, 3.4], &number), "1.2 to 3.4");
        assert_eq!(interval_text([2.0, 0.0, 3.4], &number), "0 to 3.4");
        assert_eq!(interval_text([1.99961, 1.99075, 2.00047], &number), "±0.44\u{a0}%");
        assert_eq!(interval_text([2.0, 2.0, 2.0], &number), "±0.010\u{a0}%");
    }
}
