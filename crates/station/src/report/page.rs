//! The page: one HTML file without scripts and without external resources, so that it can be archived with the chamber. All text
//! from the database or the configuration file passes through [`escape`].

use super::charts::{over_log_time, over_time, speeds};
use super::figures::{Outcome, Report};
use super::format::{duration, escape, moment, number, with_unit};
use super::plot::lane_swatch;
use super::tables;
use jiff::tz::TimeZone;
use profivac_recorder::{Micros, Quality};
use std::fmt::Write;

const STYLE: &str = include_str!("style.css");

/// The whole page.
#[must_use]
pub fn page(report: &Report) -> String {
    let mut page = String::new();
    for part in [
        head(report),
        key_figures(report),
        facts(report),
        section("Gauges", &tables::gauges(report)),
        pictures(report),
        section("Times to pressure", &tables::times(report)),
        section("Time for each decade", &tables::decades(report)),
        speed(report),
        section("Slope at the end", &tables::slopes(report)),
        section("Rises", &tables::rises(report)),
        section("Plant", &tables::plant(report)),
        section("Compared with the usual pump-downs", &tables::usual(report)),
        section("Events", &tables::events(report)),
        section("Data behind the numbers", &tables::coverage(report)),
        section("Methods of calculation", &tables::how(report)),
        foot(report),
    ] {
        page.push_str(&part);
    }
    page
}

/// A section; empty if it has no content.
fn section(heading: &str, content: &str) -> String {
    if content.is_empty() { String::new() } else { format!("<section>\n<h2>{heading}</h2>\n{content}</section>\n") }
}

fn head(report: &Report) -> String {
    let title = escape(&report.title);
    let station = report.station.as_ref().map_or(String::new(), |station| format!("{} · ", escape(station)));
    let begin = moment(report.span.start, &report.zone);
    let took = duration(report.seconds);
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\">\n\
         <meta name=\"generator\" content=\"{}\">\n<title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <header>\n<p class=\"kind\">Pump-down report</p>\n<h1>{title}</h1>\n\
         <p>{station}<strong>{begin}</strong>, {took}</p>\n</header>\n<main>\n",
        report.generator
    )
}

/// The four key figures of the leading gauge.
fn key_figures(report: &Report) -> String {
    let Some(lead) = report.lead() else { return String::new() };
    let mut figures = String::new();
    let mut put = |what: &str, value: &str, more: &str| {
        let figure = format!("<div><dt>{what}</dt><dd>{value}<small>{more}</small></dd></div>\n");
        figures.push_str(&figure);
    };
    if let Some(first) = lead.first {
        put("Pressure at the beginning", &with_unit(first.pa, report.unit), &moment(report.span.start, &report.zone));
    }
    if let Some(end) = tables::lowest_bound(lead) {
        put("Lowest pressure", &format!("&lt; {}", with_unit(end, report.unit)), "below the range of the gauge");
    } else if let Some(lowest) = lead.lowest {
        put("Lowest pressure", &with_unit(lowest.pa, report.unit), &format!("after {}", duration(lowest.s)));
    }
    let last = report.targets.iter().zip(&lead.times).rfind(|(_, reached)| reached.outcome == Outcome::Reached);
    if let Some((target, s)) = last.and_then(|(target, reached)| Some((target, reached.s?))) {
        put(&format!("Time to {}", escape(&target.words(report.unit))), &duration(s), "since the beginning");
    }
    // While a pump runs up and walls outgas, a fall shows less than the speed of the pump: a rise shows that at its beginning.
    let by_rise = lead.rises.iter().find_map(|rise| Some((rise.from.pa, rise.speed_m3_per_s?)));
    if let Some((pa, speed)) = by_rise {
        let more = format!("at {}, from the rise", with_unit(pa, report.unit));
        put("Effective speed", &format!("{} l/s", number(speed * 1e3)), &more);
    } else if let Some(fall) = lead.quickest {
        let more = format!("near {}", with_unit(fall.pa, report.unit));
        match fall.speed_m3_per_s {
            Some(speed) => put("Highest effective speed", &format!("{} l/s", number(speed * 1e3)), &more),
            None => put("Shortest time constant", &duration(fall.time_constant_s), &more),
        }
    }
    let note = format!(
        "<p class=\"note\">Measured by {}, the gauge that followed most of the pump-down.</p>\n",
        escape(&lead.name)
    );
    format!("<dl class=\"key\">\n{figures}</dl>\n{}", if report.gauges.len() > 1 { note } else { String::new() })
}

fn facts(report: &Report) -> String {
    let mut facts = String::new();
    let mut put = |what: &str, value: &str| {
        // Writing to a String cannot fail.
        writeln!(facts, "<dt>{what}</dt><dd>{value}</dd>").ok();
    };
    let both = |at: Micros| {
        let [local, utc] = [&report.zone, &TimeZone::UTC].map(|zone| moment(at, zone));
        if local == utc { utc } else { format!("{local} ({utc})") }
    };
    put("Begin", &both(report.span.start));
    put("End", &format!("{}, after {}", both(report.span.end), duration(report.seconds)));
    put("Selection", &escape(&report.why));
    if let Some(volume) = report.volume_m3 {
        put("Volume", &format!("{} l, as given", number(volume * 1e3)));
    }
    put("Database", &escape(&report.record));
    put("Pressures", "as indicated: equivalent to nitrogen where a gauge depends on the gas, not corrected");
    format!("<dl class=\"facts\">\n{facts}</dl>\n")
}

fn pictures(report: &Report) -> String {
    let lanes =
        report.gauges.iter().any(|gauge| gauge.trace.sections.iter().any(|section| section.quality != Quality::Valid));
    let lanes = if lanes { legend() } else { String::new() };
    let events = if report.events.is_empty() { "" } else { " Numbers at the top are events." };
    section(
        "Pressure over the logarithm of time",
        &figure(
            &over_log_time(report).svg(),
            &format!(
                "Outgassing that falls with 1/t is a straight line here, one decade down for each decade of time.{events}{lanes}"
            ),
        ),
    ) + &section(
        "Pressure over time",
        &figure(&over_time(report).svg(), &format!("The same over time.{events}{lanes}")),
    )
}

fn legend() -> String {
    let named = [
        (Quality::Overrange, "above the range"),
        (Quality::Underrange, "below the range"),
        (Quality::Fault, "fault"),
        (Quality::Off, "off, no gauge, or unit or configuration assumed"),
        (Quality::Stale, "no samples"),
    ];
    let named = named.map(|(quality, words)| format!("{}{words}", lane_swatch(quality))).concat();
    format!(" Where a gauge has no valid reading, its curve has a gap; the strips below show the reason:{named}.")
}

fn figure(svg: &str, caption: &str) -> String {
    format!(
        "<figure>\n<div class=\"wide\" tabindex=\"0\" role=\"group\" aria-label=\"Picture, can be moved sideways\">\n{svg}</div>\n<figcaption>{caption}</figcaption>\n</figure>\n"
    )
}

fn speed(report: &Report) -> String {
    let picture = speeds(report).map_or(String::new(), |plot| {
        figure(&plot.svg(), "While the volume is being evacuated this is the speed of the pumps at the chamber; later, outgassing and leaks are pumped and the pressure falls more slowly than they could make it. A step between two sensors of one gauge looks like pumping speed, too.")
    });
    section("Effective pumping speed", &(picture + &tables::speeds(report)))
}

fn foot(report: &Report) -> String {
    let made = report.made.to_zoned(report.zone.clone()).strftime("%Y-%m-%d %H:%M:%S %Z").to_string();
    format!("</main>\n<footer>Made by {} on {made}.</footer>\n</body>\n</html>\n", report.generator)
}
