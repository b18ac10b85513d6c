//! Lists of the names for other programs: the Archiver Appliance and Phoebus.

use crate::database::Database;
use crate::names::{self, Entry, NameError};
use crate::record::{Record, RecordType};
use profivac_gateway::{NameTable, Point, Signal, Snapshot, Subject};
use profivac_station::config::gateways::epics::Settings;
use std::fmt::Write;

/// All published names of a station, for `profivac names`.
///
/// # Errors
/// A name is too long or is given twice, or the settings name something that does not exist.
pub fn names(station: &str, snapshot: &Snapshot, settings: &Settings) -> Result<NameTable, NameError> {
    let database = Database::new(station, snapshot, settings)?;
    let mut table = NameTable::new(&["name", "record", "unit", "values", "point", "description"]);
    for (record, row) in database.records.iter().zip(names::rows(station, snapshot, settings)?) {
        let point = snapshot.points.get(record.point).map(|point| match row.entry {
            Entry::Point | Entry::Alias => names::described(point),
            Entry::Command | Entry::Acknowledge => point.subject.name().to_owned(),
        });
        table.push([
            record.name.to_string(),
            record.kind.name().to_owned(),
            record.meta.unit.clone(),
            record.meta.states.join(", "),
            point.unwrap_or_default(),
            record.about.to_string(),
        ]);
    }
    if settings.pva_ports.is_some() {
        let description = "Table of all gauges, over PV Access only".to_owned();
        let empty = String::new;
        table.push([
            database.table.clone(),
            "NTTable".to_owned(),
            empty(),
            empty(),
            "all gauges".to_owned(),
            description,
        ]);
    }
    Ok(table)
}

/// The names for the Archiver Appliance: one a line, of what has a history: numbers and states of readings, segments and alarms.
///
/// # Errors
/// As `names`.
pub fn archiver(station: &str, snapshot: &Snapshot, settings: &Settings) -> Result<String, NameError> {
    let database = Database::new(station, snapshot, settings)?;
    let of_points = database.records.iter().take(database.of_points);
    let archived = of_points.filter(|record| is_archived(record));
    Ok(archived.map(|record| format!("{}\n", record.name)).collect())
}

const fn is_archived(record: &Record) -> bool {
    !matches!(record.kind, RecordType::Stringin)
        && !matches!(record.signal, Signal::Heartbeat | Signal::Address | Signal::Simulated | Signal::ListenOnly)
}

/// The columns of a screen: title, signal, width in pixels.
const COLUMNS: [(&str, Signal, u32); 4] = [
    ("Pressure", Signal::Pressure, 160),
    ("State", Signal::State, 140),
    ("In words", Signal::StateText, 220),
    ("Last reading", Signal::LastReading, 220),
];
const NAME_WIDTH: u32 = 180;
const ROW_HEIGHT: u32 = 30;

/// A screen for Phoebus (`.bob`): a row for each reading with pressure, state, text and time. Channels without a protocol use the default
/// of Phoebus.
///
/// # Errors
/// As `names`.
pub fn bob(station: &str, snapshot: &Snapshot, settings: &Settings) -> Result<String, NameError> {
    let database = Database::new(station, snapshot, settings)?;
    let readings = snapshot.points.iter().filter(|point| point.signal == Signal::Pressure);
    let mut screen = Screen::new(station);
    screen.head();
    for reading in readings {
        let pv = |signal| {
            let is_it = |point: &Point| point.subject == reading.subject && point.signal == signal;
            let position = snapshot.points.iter().position(is_it)?;
            database.records.iter().find(|record| record.point == position).map(|record| record.name.as_ref())
        };
        let Subject::Reading { series, .. } = &reading.subject else { continue };
        screen.row(series, pv);
    }
    Ok(screen.end())
}

/// A screen that is being written.
struct Screen {
    text: String,
    y: u32,
}

impl Screen {
    fn new(title: &str) -> Self {
        let text = format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<display version=\"2.0.0\">\n  <name>{}</name>\n",
            escaped(title)
        );
        Self { text, y: 10 }
    }

    fn head(&mut self) {
        let mut x = 10;
        self.label("Gauge", x, NAME_WIDTH);
        x = x.saturating_add(NAME_WIDTH);
        for (title, _, width) in COLUMNS {
            self.label(title, x, width);
            x = x.saturating_add(width);
        }
        self.y = self.y.saturating_add(ROW_HEIGHT);
    }

    fn row<'a>(&mut self, name: &str, pv: impl Fn(Signal) -> Option<&'a str>) {
        let mut x = 10;
        self.label(name, x, NAME_WIDTH);
        x = x.saturating_add(NAME_WIDTH);
        for (_, signal, width) in COLUMNS {
            if let Some(pv) = pv(signal) {
                // Format 2 is exponential, 6 a text as it is.
                let format = if signal == Signal::Pressure { 2 } else { 6 };
                // The precision of the record is for a number without an exponent.
                let precision = if signal == Signal::Pressure { "<precision>2</precision>" } else { "" };
                let content = format!("<pv_name>{}</pv_name><format>{format}</format>{precision}", escaped(pv));
                self.widget("textupdate", &format!("{name} {}", signal.key()), &content, x, width);
            }
            x = x.saturating_add(width);
        }
        self.y = self.y.saturating_add(ROW_HEIGHT);
    }

    fn label(&mut self, text: &str, x: u32, width: u32) {
        self.widget("label", text, &format!("<text>{}</text>", escaped(text)), x, width);
    }

    fn widget(&mut self, kind: &str, name: &str, content: &str, x: u32, width: u32) {
        let (y, width, height) = (self.y, width.saturating_sub(5), ROW_HEIGHT.saturating_sub(5));
        let name = escaped(name);
        // Writing to a String cannot fail.
        let _written = writeln!(
            self.text,
            "  <widget type=\"{kind}\" version=\"2.0.0\"><name>{name}</name>{content}<x>{x}</x><y>{y}</y><width>{width}</width>\
             <height>{height}</height></widget>"
        );
    }

    fn end(mut self) -> String {
        self.text.push_str("</display>\n");
        self.text
    }
}

/// A text inside an element of XML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
