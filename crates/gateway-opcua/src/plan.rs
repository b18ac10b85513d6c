//! The nodes of a station: their identifiers, browse names and places. A pure function of the points.

use crate::types::{HEALTH, NAMEPLATE, ObjectKind, Specification};
use profivac_gateway::names::capitalized;
use profivac_gateway::{Kind, Limits, Point, Signal, Subject};
use std::collections::BTreeSet;
use std::sync::Arc;

/// The namespace of all nodes of the station.
pub const NAMESPACE: &str = "urn:profivac:station";

/// What a node hangs on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Parent {
    /// The folder `Objects` of the server.
    Objects,
    /// The node with this identifier.
    Node(String),
    /// The node with this identifier, of which it is a property.
    PropertyOf(String),
    /// `DeviceSet` of DI, and the folder of the station with this identifier.
    DeviceSet(String),
}

/// The unit of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unit {
    /// The symbol.
    pub symbol: &'static str,
    /// The common code of UNECE Recommendation 20; empty for a unit without one, which has the namespace of the station.
    pub code: &'static str,
    /// The name.
    pub name: &'static str,
}

/// Units with their codes in UNECE Recommendation 20: first those of the signals, then usual ones of points of slaves.
const UNITS: [Unit; 46] = [
    Unit { symbol: "Pa", code: "PAL", name: "pascal" },
    Unit { symbol: "%", code: "P1", name: "percent or per cent" },
    Unit { symbol: "bit/s", code: "B10", name: "bit per second" },
    Unit { symbol: "s", code: "SEC", name: "second [unit of time]" },
    Unit { symbol: "Hz", code: "HTZ", name: "hertz" },
    Unit { symbol: "rpm", code: "RPM", name: "revolutions per minute" },
    Unit { symbol: "1/min", code: "C94", name: "reciprocal minute" },
    Unit { symbol: "A", code: "AMP", name: "ampere" },
    Unit { symbol: "mA", code: "4K", name: "milliampere" },
    Unit { symbol: "V", code: "VLT", name: "volt" },
    Unit { symbol: "W", code: "WTT", name: "watt" },
    Unit { symbol: "kW", code: "KWT", name: "kilowatt" },
    Unit { symbol: "°C", code: "CEL", name: "degree Celsius" },
    Unit { symbol: "K", code: "KEL", name: "kelvin" },
    Unit { symbol: "l/min", code: "L2", name: "litre per minute" },
    Unit { symbol: "mbar", code: "MBR", name: "millibar" },
    Unit { symbol: "bar", code: "BAR", name: "bar [unit of pressure]" },
    Unit { symbol: "h", code: "HUR", name: "hour" },
    Unit { symbol: "mm", code: "MMT", name: "millimetre" },
    Unit { symbol: "hPa", code: "A97", name: "hectopascal" },
    Unit { symbol: "kPa", code: "KPA", name: "kilopascal" },
    Unit { symbol: "MPa", code: "MPA", name: "megapascal" },
    Unit { symbol: "Torr", code: "UA", name: "torr" },
    Unit { symbol: "m3", code: "MTQ", name: "cubic metre" },
    Unit { symbol: "m³", code: "MTQ", name: "cubic metre" },
    Unit { symbol: "m3/h", code: "MQH", name: "cubic metre per hour" },
    Unit { symbol: "m³/h", code: "MQH", name: "cubic metre per hour" },
    Unit { symbol: "l", code: "LTR", name: "litre" },
    Unit { symbol: "l/h", code: "E32", name: "litre per hour" },
    Unit { symbol: "l/s", code: "G51", name: "litre per second" },
    Unit { symbol: "kg", code: "KGM", name: "kilogram" },
    Unit { symbol: "g", code: "GRM", name: "gram" },
    Unit { symbol: "N", code: "NEW", name: "newton" },
    Unit { symbol: "N m", code: "NU", name: "newton metre" },
    Unit { symbol: "Nm", code: "NU", name: "newton metre" },
    Unit { symbol: "°F", code: "FAH", name: "degree Fahrenheit" },
    Unit { symbol: "mV", code: "2Z", name: "millivolt" },
    Unit { symbol: "kV", code: "KVT", name: "kilovolt" },
    Unit { symbol: "kHz", code: "KHZ", name: "kilohertz" },
    Unit { symbol: "MHz", code: "MHZ", name: "megahertz" },
    Unit { symbol: "kWh", code: "KWH", name: "kilowatt hour" },
    Unit { symbol: "ms", code: "C26", name: "millisecond" },
    Unit { symbol: "min", code: "MIN", name: "minute [unit of time]" },
    Unit { symbol: "d", code: "DAY", name: "day" },
    Unit { symbol: "m", code: "MTR", name: "metre" },
    Unit { symbol: "cm", code: "CMT", name: "centimetre" },
];

impl Unit {
    /// The unit with this symbol. One that this table does not have has no code, and its symbol as its name.
    #[must_use]
    pub fn of(symbol: &'static str) -> Self {
        let known = UNITS.into_iter().find(|unit| unit.symbol == symbol);
        known.unwrap_or(Self { symbol, code: "", name: symbol })
    }

    /// The number of the unit in OPC UA: the characters of its code as octets of a number, -1 without a code (OPC 10000-8, 5.6.4.3).
    #[must_use]
    pub fn id(self) -> i32 {
        if self.code.is_empty() {
            return -1;
        }
        self.code.bytes().fold(0, |id, octet| (id << 8) | i32::from(octet))
    }
}

/// A property of a variable.
#[derive(Clone, Debug, PartialEq)]
pub enum Property {
    /// The unit.
    EngineeringUnits(Unit),
    /// `EURange` or `InstrumentRange`: the ends of the measuring range.
    Range(&'static str, (f64, f64)),
    /// The words of an enumeration.
    EnumStrings(Vec<&'static str>),
    /// A limit of an alarm in the unit of the variable, under its name.
    Limit(&'static str, f64),
}

impl Property {
    /// Its browse name, in the namespace of OPC UA.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::EngineeringUnits(_) => "EngineeringUnits",
            Self::Range(name, _) | Self::Limit(name, _) => name,
            Self::EnumStrings(_) => "EnumStrings",
        }
    }
}

/// The type of the value of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DataType {
    /// 32 bit, for pressures as PA-DIM has them.
    Float,
    /// 64 bit.
    Double,
    /// Signed, 64 bit.
    Int64,
    /// Unsigned, 32 bit: the position of a word in `EnumStrings`.
    UInt32,
    /// True or false.
    Boolean,
    /// A text.
    String,
    /// A time.
    UtcTime,
    /// A text that people read.
    LocalizedText,
    /// Signed, 32 bit.
    Int32,
    /// The health of a device: `DeviceHealthEnumeration` of DI.
    Health,
}

impl DataType {
    /// The type for a signal.
    #[must_use]
    pub fn of(signal: Signal) -> Self {
        match signal.kind() {
            Kind::Float if signal.unit() == Some("Pa") => Self::Float,
            Kind::Float => Self::Double,
            Kind::Integer => Self::Int64,
            Kind::Boolean => Self::Boolean,
            Kind::Text => Self::String,
            Kind::Choice(_) => Self::UInt32,
            Kind::Time => Self::UtcTime,
        }
    }
}

/// What a variable shows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// The point at this position.
    Point(usize),
    /// The worst health of the readings at these positions.
    Health(Vec<usize>),
    /// The health of a device without readings: by its state and its faults, at these positions.
    DeviceState(Vec<usize>),
    /// The vendor of the device that the point at this position names.
    Manufacturer(usize),
    /// The model of the device that the point at this position names, without its vendor.
    Model(usize),
    /// What the station does not know, such as the serial number of a device: it has no value.
    Unknown,
    /// A property of the nameplate that the station does not know: DI says an empty text, or -1 as the counter of revisions.
    Blank,
    /// A text that never changes.
    Fixed(String),
}

/// What the recorder keeps of a variable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum History {
    /// The pressures of this series.
    Series(String),
    /// The values of a point of a slave, in its present unit.
    Point {
        /// The point as the recorder knows it.
        point: Arc<profivac_recorder::Point>,
        /// The type of the values.
        data_type: DataType,
    },
}

/// What a node is.
#[derive(Clone, Debug, PartialEq)]
pub enum NodeKind {
    /// A folder.
    Folder,
    /// An object.
    Object(ObjectKind),
    /// A variable.
    Variable {
        /// What it shows.
        source: Source,
        /// The type of its value.
        data_type: DataType,
        /// Its properties.
        properties: Vec<Property>,
        /// What the recorder keeps of it.
        history: Option<History>,
    },
}

/// A node.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Its identifier, a string, unique and independent of order.
    pub id: String,
    /// What it hangs on.
    pub parent: Parent,
    /// Its browse name.
    pub name: String,
    /// The specification that gives it the browse name.
    pub named_by: Specification,
    /// What it is for.
    pub description: String,
    /// What it is.
    pub kind: NodeKind,
}

/// The nodes of these points, parents before children.
#[must_use]
pub fn nodes(points: &[Point]) -> Vec<Node> {
    let mut plan = Plan { points, nodes: Vec::new(), objects: BTreeSet::new() };
    for (index, point) in points.iter().enumerate() {
        plan.add_point(index, point);
    }
    plan.nodes
}

/// Collects nodes.
struct Plan<'a> {
    points: &'a [Point],
    nodes: Vec<Node>,
    /// The identifiers of folders and objects that are there.
    objects: BTreeSet<String>,
}

impl Plan<'_> {
    fn add_point(&mut self, index: usize, point: &Point) {
        let parent = self.object(&point.subject);
        self.nodes.push(Node {
            id: identifier(&point.subject, point.signal),
            parent: Parent::Node(parent),
            name: browse_name(point.signal),
            named_by: match point.signal {
                Signal::Pressure => Specification::PaDim,
                _ => Specification::Station,
            },
            description: point.signal.description().to_owned(),
            kind: NodeKind::Variable {
                source: Source::Point(index),
                data_type: DataType::of(point.signal),
                properties: properties(point),
                history: history(point),
            },
        });
    }

    /// The identifier of the object of a subject, which is added with all above it.
    fn object(&mut self, subject: &Subject) -> String {
        match subject {
            Subject::Station => {
                self.add(Parent::Objects, "station".to_owned(), "Station", NodeKind::Object(ObjectKind::Plain))
            }
            Subject::Segment(name) => self.below_station(
                ("segments", "Segments"),
                format!("segment/{}", escaped(name)),
                name,
                ObjectKind::Plain,
            ),
            Subject::Alarm(name) => {
                self.below_station(("alarms", "Alarms"), format!("alarm/{}", escaped(name)), name, ObjectKind::Alarm)
            }
            Subject::Gauge(name) => self.gauge(name),
            Subject::Reading { gauge, channel, .. } => {
                let device = self.gauge(gauge);
                let set = format!("{device}/signals");
                let set = self.add_of(Specification::PaDim, device, set, "SignalSet", ObjectKind::Signals);
                self.signal(set, gauge, *channel, subject.name())
            }
            Subject::Parameter { gauge, target, .. } => {
                let device = self.gauge(gauge);
                let set = format!("{device}/parameters");
                let id = format!("{device}/parameter/{target}");
                let set = self.add_of(Specification::Di, device, set, "ParameterSet", ObjectKind::Plain);
                self.add(Parent::Node(set), id, target, NodeKind::Object(ObjectKind::Plain))
            }
        }
    }

    fn gauge(&mut self, gauge: &str) -> String {
        let station = self.object(&Subject::Station);
        let set = self.add(Parent::Node(station), "devices".to_owned(), "DeviceSet", NodeKind::Folder);
        let id = format!("gauge/{}", escaped(gauge));
        if !self.objects.contains(&id) {
            self.add(Parent::DeviceSet(set), id.clone(), gauge, NodeKind::Object(ObjectKind::Device));
            let readings = self.points_of(gauge, &[Signal::State]);
            let has_readings = !readings.is_empty();
            let health = NodeKind::Variable {
                source: if has_readings {
                    Source::Health(readings)
                } else {
                    Source::DeviceState(self.points_of(gauge, &[Signal::GaugeState, Signal::Faults]))
                },
                data_type: DataType::Health,
                properties: vec![Property::EnumStrings(HEALTH.to_vec())],
                history: None,
            };
            self.nodes.push(Node {
                id: format!("{id}/device-health"),
                parent: Parent::Node(id.clone()),
                name: "DeviceHealth".to_owned(),
                named_by: Specification::Di,
                description: match has_readings {
                    true => "Worst health of the readings, as in NAMUR NE 107",
                    false => "Health by the state and the faults of the device, as in NAMUR NE 107",
                }
                .to_owned(),
                kind: health,
            });
            self.identification(&id, gauge);
            self.nameplate(&id, gauge);
        }
        id
    }

    /// The positions of the points of a gauge with these signals.
    fn points_of(&self, gauge: &str, signals: &[Signal]) -> Vec<usize> {
        let is_one = |point: &Point| signals.contains(&point.signal) && point.subject.gauge() == Some(gauge);
        self.points.iter().enumerate().filter(|(_, point)| is_one(point)).map(|(index, _)| index).collect()
    }

    /// `Identification` of a device: what DI (OPC 10000-100, DeviceType) makes mandatory and the station has a place for.
    fn identification(&mut self, device: &str, gauge: &str) {
        let is_device = |point: &Point| point.signal == Signal::Device && point.subject.gauge() == Some(gauge);
        let Some(index) = self.points.iter().position(is_device) else { return };
        let id = format!("{device}/identification");
        let group = self.add_of(Specification::Di, device.to_owned(), id, "Identification", ObjectKind::Group);
        let rows = [
            ("manufacturer", "Manufacturer", "Vendor of the device", Source::Manufacturer(index)),
            ("model", "Model", "Device model", Source::Model(index)),
            ("serial-number", "SerialNumber", "Serial number; the station does not read it", Source::Unknown),
        ];
        for (key, name, description, source) in rows {
            self.nodes.push(Node {
                id: format!("{device}/{key}"),
                parent: Parent::Node(group.clone()),
                name: name.to_owned(),
                named_by: Specification::Di,
                description: description.to_owned(),
                kind: NodeKind::Variable { source, data_type: DataType::String, properties: Vec::new(), history: None },
            });
        }
    }

    /// A signal of PA-DIM with its mandatory tag.
    fn signal(&mut self, set: String, gauge: &str, channel: Option<u8>, tag: &str) -> String {
        let name = channel.map_or_else(|| "Pressure".to_owned(), |channel| format!("Pressure{channel}"));
        let id = format!("{}/signal", reading(gauge, channel));
        if !self.objects.contains(&id) {
            self.add(Parent::Node(set), id.clone(), &name, NodeKind::Object(ObjectKind::Signal));
            self.nodes.push(Node {
                id: format!("{id}/tag"),
                parent: Parent::PropertyOf(id.clone()),
                name: "SignalTag".to_owned(),
                named_by: Specification::PaDim,
                description: "Name of the signal".to_owned(),
                kind: NodeKind::Variable {
                    source: Source::Fixed(tag.to_owned()),
                    data_type: DataType::String,
                    properties: Vec::new(),
                    history: None,
                },
            });
        }
        id
    }

    /// The properties that `DeviceType` of DI makes mandatory.
    fn nameplate(&mut self, device: &str, gauge: &str) {
        let is_device = |point: &Point| point.signal == Signal::Device && point.subject.gauge() == Some(gauge);
        let index = self.points.iter().position(is_device);
        for row in NAMEPLATE {
            let (source, data_type) = match (row.name, index) {
                ("Manufacturer", Some(index)) => (Source::Manufacturer(index), DataType::LocalizedText),
                ("Model", Some(index)) => (Source::Model(index), DataType::LocalizedText),
                ("Manufacturer" | "Model", None) => (Source::Blank, DataType::LocalizedText),
                ("RevisionCounter", _) => (Source::Blank, DataType::Int32),
                _ => (Source::Blank, DataType::String),
            };
            self.nodes.push(Node {
                id: format!("{device}/nameplate/{}", row.name),
                parent: Parent::PropertyOf(device.to_owned()),
                name: row.name.to_owned(),
                named_by: Specification::Di,
                description: "Nameplate; empty where the station does not read it".to_owned(),
                kind: NodeKind::Variable { source, data_type, properties: Vec::new(), history: None },
            });
        }
    }

    fn below_station(&mut self, (folder_id, folder): (&str, &str), id: String, name: &str, kind: ObjectKind) -> String {
        let station = self.object(&Subject::Station);
        let folder = self.add(Parent::Node(station), folder_id.to_owned(), folder, NodeKind::Folder);
        self.add(Parent::Node(folder), id, name, NodeKind::Object(kind))
    }

    /// Adds an object or a folder, unless it is there, and returns its identifier.
    fn add(&mut self, parent: Parent, id: String, name: &str, kind: NodeKind) -> String {
        self.insert(Specification::Station, parent, id, name, kind)
    }

    /// Adds an object whose name is that of a specification.
    fn add_of(&mut self, by: Specification, parent: String, id: String, name: &str, kind: ObjectKind) -> String {
        self.insert(by, Parent::Node(parent), id, name, NodeKind::Object(kind))
    }

    fn insert(&mut self, by: Specification, parent: Parent, id: String, name: &str, kind: NodeKind) -> String {
        if self.objects.insert(id.clone()) {
            let (name, description) = (name.to_owned(), String::new());
            self.nodes.push(Node { id: id.clone(), parent, name, named_by: by, description, kind });
        }
        id
    }
}

/// The beginning of the identifiers of a reading.
fn reading(gauge: &str, channel: Option<u8>) -> String {
    let gauge = escaped(gauge);
    channel.map_or_else(|| format!("gauge/{gauge}"), |channel| format!("gauge/{gauge}/{channel}"))
}

/// A name as one part of an identifier: the slash separates the parts.
fn escaped(name: &str) -> String {
    name.replace('%', "%25").replace('/', "%2F")
}

/// The identifier of a point.
#[must_use]
pub fn identifier(subject: &Subject, signal: Signal) -> String {
    let key = signal.key();
    match subject {
        Subject::Station => format!("station/{key}"),
        Subject::Segment(name) => format!("segment/{}/{key}", escaped(name)),
        Subject::Gauge(name) => format!("gauge/{}/{key}", escaped(name)),
        Subject::Reading { gauge, channel, .. } => format!("{}/{key}", reading(gauge, *channel)),
        Subject::Parameter { gauge, target, .. } => format!("gauge/{}/parameter/{target}/{key}", escaped(gauge)),
        Subject::Alarm(name) => format!("alarm/{}/{key}", escaped(name)),
    }
}

/// The browse name: those of OPC UA where it has one, otherwise the key in OPC UA's way of writing.
fn browse_name(signal: Signal) -> String {
    match signal {
        Signal::Pressure => "AnalogSignal".to_owned(),
        Signal::AlarmActive => "ActiveState".to_owned(),
        Signal::AlarmAcknowledged => "AckedState".to_owned(),
        Signal::AlarmText => "Text".to_owned(),
        Signal::AlarmState | Signal::SegmentState => "State".to_owned(),
        other => capitalized(other.key()),
    }
}

fn properties(point: &Point) -> Vec<Property> {
    let unit = point.unit.map(Unit::of).map(Property::EngineeringUnits);
    let ranges = point
        .range
        .into_iter()
        .flat_map(|range| [Property::Range("EURange", range), Property::Range("InstrumentRange", range)]);
    let words = match point.signal.kind() {
        Kind::Choice(words) => Some(Property::EnumStrings(words.to_vec())),
        _ => None,
    };
    let Limits { high_high, high, low, low_low } = point.limits;
    let limits = [("HighHighLimit", high_high), ("HighLimit", high), ("LowLimit", low), ("LowLowLimit", low_low)];
    let limits = limits.into_iter().filter_map(|(name, limit)| Some(Property::Limit(name, limit?)));
    unit.into_iter().chain(ranges).chain(words).chain(limits).collect()
}

/// What the recorder keeps of a point: indicated pressures, and the numbers of points of slaves.
fn history(point: &Point) -> Option<History> {
    if point.signal == Signal::Pressure {
        return Some(History::Series(point.subject.name().to_owned()));
    }
    let recorded = Arc::clone(point.recorded.as_ref()?);
    Some(History::Point { point: recorded, data_type: DataType::of(point.signal) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::value::data_value;
    use opcua_types::{UAString, Variant};
    use profivac_gateway::model::Modeller;
    use profivac_gateway::{Health, Inputs, points};
    use profivac_recorder::{Micros, PointKind};
    use profivac_station::view::BusStationState;
    use std::path::Path;

    const PLANT: &str = r#"
        [[segment]]
        name = "hall"
        port = "sim:hall.toml"
        [[segment.gauge]]
        name = "chamber"
        address = 5
        device = "bcg450"
        [[segment.gauge]]
        name = "tpg"
        address = 6
        device = "tpg300"
        [[alarm]]
        name = "Chamber high"
        gauge = "chamber"
        above = "1e-3 mbar"
        priority = "high"
    "#;

    fn plan(text: &str) -> Vec<Node> {
        nodes(&points(&Inputs::planned(&profivac_config::parse(text, Path::new("plant.toml")).unwrap())))
    }

    fn node<'a>(nodes: &'a [Node], id: &str) -> &'a Node {
        nodes.iter().find(|node| node.id == id).unwrap_or_else(|| panic!("{id}"))
    }

    #[test]
    fn every_node_has_an_identifier_of_its_own_and_a_parent_before_it() {
        let mut seen = BTreeSet::new();
        for node in plan(PLANT) {
            if let Parent::Node(parent) | Parent::PropertyOf(parent) | Parent::DeviceSet(parent) = &node.parent {
                assert!(seen.contains(parent), "{node:?}");
            }
            assert!(seen.insert(node.id.clone()), "{node:?}");
        }
    }

    #[test]
    fn every_point_is_a_variable() {
        let points = points(&Inputs::planned(&profivac_config::parse(PLANT, Path::new("plant.toml")).unwrap()));
        let shown: BTreeSet<usize> = nodes(&points)
            .into_iter()
            .filter_map(|node| match node.kind {
                NodeKind::Variable { source: Source::Point(index), .. } => Some(index),
                _ => None,
            })
            .collect();
        assert_eq!(shown, (0..points.len()).collect());
    }

    #[test]
    fn a_pressure_has_unit_ranges_limits_and_history() {
        let nodes = plan(PLANT);
        let pressure = node(&nodes, "gauge/chamber/pressure");
        let NodeKind::Variable { data_type, properties, history, .. } = &pressure.kind else { panic!("{pressure:?}") };
        assert_eq!((*data_type, history), (DataType::Float, &Some(History::Series("chamber".to_owned()))));
        let names: Vec<_> = properties.iter().map(Property::name).collect();
        assert_eq!(names, ["EngineeringUnits", "EURange", "InstrumentRange", "HighHighLimit"]);
        assert_eq!(pressure.parent, Parent::Node("gauge/chamber/signal".to_owned()));
        assert_eq!(node(&nodes, "gauge/chamber/signal").parent, Parent::Node("gauge/chamber/signals".to_owned()));
    }

    const GSD: &str = "#Profibus_DP\nIdent_Number = 0x0FA7\nModule = \"m\" 0x15\n1\nEndModule\n";

    const SLAVE: &str = r#"
        [[segment]]
        name = "hall"
        port = "sim:hall.toml"
        [[segment.slave]]
        name = "turbo"
        address = 9
        gsd = "turbo.gsd"
        [[segment.slave.point]]
        name = "speed"
        octet = 0
        type = "u16"
        unit = "Hz"
        [[segment.slave.point]]
        name = "fore pressure"
        octet = 2
        type = "u16"
        unit = "Pa"
        [[segment.slave.point]]
        name = "running"
        octet = 4
        bit = 0
        type = "bool"
    "#;

    #[test]
    fn the_number_of_a_point_of_a_slave_has_a_history_in_its_present_unit_and_its_text_has_none() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("turbo.gsd"), GSD).unwrap();
        let config = profivac_config::parse(SLAVE, &folder.path().join("plant.toml")).unwrap();
        let nodes = nodes(&points(&Inputs::planned(&config)));
        let with_history = nodes.iter().filter_map(|node| match &node.kind {
            NodeKind::Variable { data_type, history: Some(History::Point { point, data_type: of_values }), .. } => {
                assert_eq!(data_type, of_values);
                Some((node.id.as_str(), point.to_string(), point.unit.as_deref(), point.kind, *data_type))
            }
            _ => None,
        });
        let parameter = |name: &str, key: &str| format!("gauge/turbo/parameter/{name}/parameter-{key}");
        let ids =
            [parameter("speed", "number"), parameter("fore pressure", "pressure"), parameter("running", "number")];
        let expected = [
            (&*ids[0], "turbo.speed".to_owned(), Some("Hz"), PointKind::Number, DataType::Double),
            (&*ids[1], "turbo.fore pressure".to_owned(), Some("Pa"), PointKind::Number, DataType::Float),
            (&*ids[2], "turbo.running".to_owned(), None, PointKind::Code, DataType::Double),
        ];
        assert_eq!(with_history.collect::<Vec<_>>(), expected);
    }

    /// A percent deadband is a part of EURange (OPC 10000-8, 6.2): of the pressure it is useless over decades, of the logarithm it is not.
    #[test]
    fn the_logarithm_of_a_pressure_has_a_range_for_percent_deadbands() {
        let nodes = plan(PLANT);
        let logarithm = node(&nodes, "gauge/chamber/pressure-log10");
        let NodeKind::Variable { properties, .. } = &logarithm.kind else { panic!("{logarithm:?}") };
        let range = properties.iter().find_map(|property| match property {
            Property::Range("EURange", range) => Some(*range),
            _ => None,
        });
        // 5e-8 to 1.5e5 Pa.
        let (low, high) = range.unwrap();
        assert!((low + 7.301).abs() < 1e-3 && (high - 5.176).abs() < 1e-3, "{low} {high}");
    }

    /// UNECE Recommendation 20 and OPC 10000-8: pascal is 5259596, second 5457219, percent 20529, bit per second 4337968.
    #[test]
    fn the_number_of_a_unit_is_that_of_its_code() {
        let ids = ["Pa", "s", "%", "bit/s"].map(|unit| Unit::of(unit).id());
        assert_eq!(ids, [5_259_596, 5_457_219, 20_529, 4_337_968]);
    }

    #[test]
    fn a_point_in_any_unit_has_engineering_units_and_one_without_a_code_those_of_the_station() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("turbo.gsd"), GSD).unwrap();
        let unit_of = |unit: &str| {
            let text = SLAVE.replace("\"Hz\"", &format!("{unit:?}"));
            let config = profivac_config::parse(&text, &folder.path().join("plant.toml")).unwrap();
            let nodes = nodes(&points(&Inputs::planned(&config)));
            let speed = node(&nodes, "gauge/turbo/parameter/speed/parameter-number");
            let NodeKind::Variable { properties, .. } = &speed.kind else { panic!("{speed:?}") };
            properties.iter().find_map(|it| if let Property::EngineeringUnits(unit) = it { Some(*unit) } else { None })
        };
        assert_eq!(unit_of("m3"), Some(Unit { symbol: "m3", code: "MTQ", name: "cubic metre" }));
        // The characters M, T and Q.
        assert_eq!(unit_of("m3").map(Unit::id), Some(5_067_857));
        let own = unit_of("sccm");
        assert_eq!(own, Some(Unit { symbol: "sccm", code: "", name: "sccm" }));
        assert_eq!(own.map(Unit::id), Some(-1));
    }

    #[test]
    fn the_health_of_a_slave_is_by_its_state_and_faults_and_its_vendor_by_its_gsd_file() {
        let folder = tempfile::tempdir().unwrap();
        let identity = "Vendor_Name = \"Invented\"\nModel_Name = \"Pump 3\"\nIdent_Number";
        std::fs::write(folder.path().join("turbo.gsd"), GSD.replace("Ident_Number", identity)).unwrap();
        let config = profivac_config::parse(SLAVE, &folder.path().join("plant.toml")).unwrap();
        let mut inputs = Inputs::planned(&config);
        let shown = |inputs: &Inputs, id: &str| {
            let snapshot = Modeller::default().next(inputs.clone(), Micros(1));
            let nodes = nodes(&snapshot.points);
            let NodeKind::Variable { source, data_type, .. } = &node(&nodes, id).kind else { panic!("{id}") };
            data_value(source, *data_type, &snapshot).and_then(|value| value.value)
        };
        let health = |inputs: &Inputs| shown(inputs, "gauge/turbo/device-health");
        assert_eq!(health(&inputs), Some(Variant::Int32(Health::Failure as i32)), "missing");
        inputs.gauges[0].state = BusStationState::Starting;
        assert_eq!(health(&inputs), Some(Variant::Int32(Health::CheckFunction as i32)));
        inputs.gauges[0].state = BusStationState::DataExchange;
        assert_eq!(health(&inputs), Some(Variant::Int32(Health::Normal as i32)));
        inputs.gauges[0].exceptions = vec!["bearing".to_owned()];
        assert_eq!(health(&inputs), Some(Variant::Int32(Health::Failure as i32)));
        let text = |text: &str| Some(Variant::String(UAString::from(text)));
        assert_eq!(shown(&inputs, "gauge/turbo/manufacturer"), text("Invented"));
        assert_eq!(shown(&inputs, "gauge/turbo/model"), text("Pump 3"), "the vendor has a node of its own");
        assert_eq!(shown(&inputs, "gauge/turbo/device"), text("Invented Pump 3"));
    }

    #[test]
    fn every_unit_of_a_signal_is_known() {
        for unit in Signal::ALL.iter().filter_map(|signal| signal.unit()) {
            assert_ne!(Unit::of(unit).code, "", "{unit}");
        }
    }

    /// Another order of segments and gauges gives the same identifiers.
    #[test]
    fn the_order_of_the_file_does_not_change_identifiers() {
        let swapped =
            PLANT.replace("\"chamber\"\n        address = 5\n        device = \"bcg450\"", "\"GAUGE\"").replace(
                "\"tpg\"\n        address = 6\n        device = \"tpg300\"",
                "\"chamber\"\n        address = 5\n        device = \"bcg450\"",
            );
        let swapped = swapped.replace("\"GAUGE\"", "\"tpg\"\n        address = 6\n        device = \"tpg300\"");
        assert_ne!(swapped, PLANT);
        let ids = |text: &str| plan(text).into_iter().map(|node| node.id).collect::<BTreeSet<_>>();
        assert_eq!(ids(&swapped), ids(PLANT));
    }

    #[test]
    fn a_channel_is_part_of_the_identifier_of_a_controller() {
        let nodes = plan(PLANT);
        assert!(nodes.iter().any(|node| node.id == "gauge/tpg/1/pressure"), "{nodes:#?}");
        assert_eq!(node(&nodes, "gauge/tpg/device-health").name, "DeviceHealth");
        assert_eq!(node(&nodes, "alarm/Chamber high/alarm-active").name, "ActiveState");
    }
}
