//! Topics and metrics as a table: `profivac names`.

use crate::plain::layout::{self, Layout};
use crate::plain::{default_prefix, discovery};
use crate::sparkplug::{self, metric};
use crate::topic::level;
use profivac_gateway::{NameTable, Point};
use profivac_station::config::gateways::mqtt::Settings;

/// The topics and metrics of these points of a station. A topic with a JSON object has a row for each of its keys.
#[must_use]
pub fn names(settings: &Settings, station: &str, points: &[Point]) -> NameTable {
    let mut table = NameTable::new(&["topic", "name", "unit", "description"]);
    if let Some(plain) = &settings.plain {
        let prefix = plain.prefix.clone().unwrap_or_else(|| default_prefix(station));
        let about = "online or offline; offline is the will";
        table.push([layout::status_topic(&prefix), String::new(), String::new(), about.to_owned()]);
        let layout = Layout::new(&prefix, points);
        for topic in layout.topics() {
            for point in topic.positions.iter().filter_map(|position| points.get(*position)) {
                let about = point.signal.description();
                push(&mut table, topic.object.clone(), layout::key(point.signal), point, about);
            }
            if let Some(pressure) = &topic.pressure {
                let text = ["the measured pressure alone, empty while none is measured", "Pa"].map(str::to_owned);
                let [about, unit] = text;
                table.push([pressure.clone(), String::new(), unit, about]);
            }
        }
        let prefixes = plain.discovery.iter();
        for message in prefixes.flat_map(|it| discovery::sensors(it, &prefix, station, &layout, points, &[])) {
            let about = "description of a sensor for Home Assistant";
            table.push([message.topic, String::new(), String::new(), about.to_owned()]);
        }
    }
    if let Some(settings) = &settings.sparkplug {
        let names = sparkplug::names(settings, station);
        for point in points {
            let device = point.subject.gauge().map(level);
            let verb = if device.is_some() { "DDATA" } else { "NDATA" };
            let (topic, about) = (names.topic(verb, device.as_deref()), metric::description(point.signal));
            push(&mut table, topic, metric::name(point), point, about);
        }
    }
    table
}

fn push(table: &mut NameTable, topic: String, name: String, point: &Point, about: &str) {
    let unit = point.unit.unwrap_or_default();
    table.push([topic, name, unit.to_owned(), about.to_owned()]);
}
