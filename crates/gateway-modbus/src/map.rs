//! The register map: which register shows which point. docs/gateways.md describes it; `profivac names --for modbus` prints it.

use profivac_gateway::names::NameTable;
use profivac_gateway::signal::SubjectKind;
use profivac_gateway::{Kind, Point, Signal, Subject};
use profivac_station::config::gateways::modbus::{SLOTS, Settings};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// The version of the map. It changes when a register gets another meaning.
pub const VERSION: u16 = 1;

/// The first register of the slots, and the registers of each.
const SLOTS_AT: u16 = 100;
const SLOT: u16 = 20;

/// The first register of the gauges, and the registers of each: its parameters, then its counters.
const GAUGES_AT: u16 = 10_000;
const GAUGE: u16 = 100;

/// The most parameters of a gauge; a test compares it with the catalog. A slave by its GSD file has a slot for each 46 points.
pub const PARAMETERS: usize = 46;

/// The first register of the further bits of the slots, one register each.
const MORE_AT: u16 = 59_500;

/// The first register of the segments, and the registers of each.
const SEGMENTS_AT: u16 = 60_000;
const SEGMENT: u16 = 20;
const SEGMENTS: u16 = 100;

/// The first register of the alarms, and the registers of each.
const ALARMS_AT: u16 = 62_000;
const ALARM: u16 = 2;
const ALARMS: u16 = 1_700;

/// The reason why the points do not fit into the map.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// The channels of a controller, or the points of a slave, reach a slot that another gauge has.
    #[error(
        "[modbus]: the channels or points of {gauge:?} begin at slot {first} and need slot {slot}, which belongs to {other:?}: give \
         one of them another number with the key modbus"
    )]
    Overlap {
        /// The gauge.
        gauge: String,
        /// Its first slot.
        first: u16,
        /// The slot that is taken.
        slot: u16,
        /// The gauge that has it.
        other: String,
    },
    /// There are more subjects than places.
    #[error(
        "[modbus]: the map has {places} places for {what}, and the station needs more: remove some, or use another gateway"
    )]
    Full {
        /// The subject that has too many.
        what: &'static str,
        /// The number of places.
        places: u16,
    },
}

/// What a register shows. The numbers are positions of points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// A number that never changes.
    Word(u16),
    /// A number of 32 bits that never changes.
    Long(u32),
    /// A floating-point number that never changes; NaN if there is none.
    Constant(Option<f64>),
    /// A floating-point number; NaN if there is none.
    Float(usize),
    /// A pressure in the unit of the file; NaN if there is none.
    InUnit(usize),
    /// A thousandfold, with sign; 8000 hex if there is none.
    Thousandfold(usize),
    /// The state of a reading.
    State(usize),
    /// The bits of a reading: the position of its pressure.
    Bits(usize),
    /// The bits of a slave without readings: the position of its state on the bus.
    SlaveBits(usize),
    /// Which of the bits of emission and degas are known: the position of the pressure.
    Known(usize),
    /// The age of a reading in 0.1 s, from the point with its time; 65535 if it is older than that or there is none.
    Age(usize),
    /// The number of readings, modulo 65536, from the point with the time of the last one.
    Readings(usize),
    /// A whole number, a choice or a Boolean, modulo 65536.
    Number(usize),
    /// The same in 32 bits.
    LongNumber(usize),
    /// A time in seconds since 1970, in 32 bits.
    Seconds(usize),
    /// The present time in seconds since 1970, in 32 bits.
    Now,
}

impl Source {
    /// Its type, for users.
    #[must_use]
    pub const fn kind(self) -> &'static str {
        match self {
            Self::Constant(_) | Self::Float(_) | Self::InUnit(_) => "float32",
            Self::Long(_) | Self::LongNumber(_) | Self::Seconds(_) | Self::Now => "uint32",
            Self::Thousandfold(_) => "int16",
            _ => "uint16",
        }
    }
}

/// One row of the map.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The first register, zero-based.
    pub register: u16,
    /// What it shows.
    pub source: Source,
    /// The name of its subject in the station's file.
    pub subject: Arc<str>,
    /// A short name.
    pub name: String,
    /// The unit.
    pub unit: &'static str,
    /// A description, with the words of its numbers.
    pub text: String,
}

/// The positions of the points that a slot needs besides those of its reading.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Gauge {
    /// Whether another master owns it.
    pub listen_only: Option<usize>,
    /// Its state on the bus.
    pub bus_state: Option<usize>,
    /// The highest priority of its active alarms.
    pub alarm_priority: Option<usize>,
    /// Whether an alarm waits for an acknowledgement.
    pub unacknowledged: Option<usize>,
    /// The codes of its emission.
    pub emission: OfChannels,
    /// The codes of its degas.
    pub degas: OfChannels,
}

/// The positions of a parameter that a gauge has once, or each channel of a controller.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OfChannels(BTreeMap<Option<u8>, usize>);

impl OfChannels {
    /// The position for a reading of this channel.
    #[must_use]
    pub fn of(&self, channel: Option<u8>) -> Option<usize> {
        self.0.get(&None).or_else(|| self.0.get(&channel)).copied()
    }

    fn insert(&mut self, target: &str, index: usize) {
        self.0.entry(channel_of(target)).or_insert(index);
    }
}

/// The channel in the name of a parameter: 2 in `channel.2/emission-status`.
fn channel_of(target: &str) -> Option<u8> {
    let (location, _) = target.rsplit_once('/')?;
    location.rsplit_once('.')?.1.parse().ok()
}

/// The map of a list of points.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// The rows, by register.
    pub rows: Vec<Row>,
    /// The areas that can be read: first register and length.
    pub areas: Vec<(u16, u16)>,
    /// The gauges, by name.
    pub gauges: BTreeMap<String, Gauge>,
}

impl Map {
    /// The map of these points.
    ///
    /// # Errors
    /// [`MapError`] when they do not fit.
    pub fn of(points: &[Point], settings: &Settings) -> Result<Self, MapError> {
        let slots = Slots::of(points, settings)?;
        let used = slots.names().map(|(slot, _)| slot.saturating_add(1)).max().unwrap_or_default();
        let mut rows = Rows { points, settings, rows: Vec::new() };
        let mut first_slots: BTreeMap<&str, u16> = BTreeMap::new();
        for (index, point) in with_signal(points, Signal::Pressure) {
            let (Some(slot), Some(gauge)) = (slots.readings.get(point.subject.name()), point.subject.gauge()) else {
                continue;
            };
            first_slots.entry(gauge).and_modify(|first| *first = (*first).min(*slot)).or_insert(*slot);
            rows.slot(slot_register(*slot), index, point);
            rows.known(MORE_AT.saturating_add(*slot), index, point);
        }
        for (gauge, slot) in first_slots {
            rows.gauge(&[slot], gauge);
        }
        for (slave, slots) in &slots.slaves {
            slots.iter().for_each(|slot| rows.slot_without_reading(slot_register(*slot), slave));
            rows.gauge(slots, slave);
        }
        let segments =
            rows.numbered(Signal::SegmentState, SEGMENTS_AT, SEGMENT, SEGMENTS, "segments", Rows::segment)?;
        let alarms = rows.numbered(Signal::AlarmState, ALARMS_AT, ALARM, ALARMS, "alarms", Rows::alarm)?;
        let check = check_of(slots.meanings().chain(rows.meanings()));
        rows.header(used, check);
        let mut rows = rows.rows;
        rows.sort_by_key(|row| row.register);
        let areas = [
            (0, SLOTS_AT.saturating_add(used.saturating_mul(SLOT))),
            (GAUGES_AT, used.saturating_mul(GAUGE)),
            (MORE_AT, used),
            (SEGMENTS_AT, segments.saturating_mul(SEGMENT)),
            (ALARMS_AT, alarms.saturating_mul(ALARM)),
        ];
        Ok(Self { rows, areas: areas.to_vec(), gauges: gauges(points) })
    }
}

/// The table of the map.
///
/// # Errors
/// [`MapError`] when the points do not fit.
pub fn names(points: &[Point], settings: &Settings) -> Result<NameTable, MapError> {
    let map = Map::of(points, settings)?;
    let mut table = NameTable::new(&["register", "type", "subject", "name", "unit", "description"]);
    for Row { register, source, subject, name, unit, text } in map.rows {
        table.push([register.to_string(), source.kind().to_owned(), subject.to_string(), name, unit.to_owned(), text]);
    }
    Ok(table)
}

fn with_signal(points: &[Point], signal: Signal) -> impl Iterator<Item = (usize, &Point)> {
    points.iter().enumerate().filter(move |(_, point)| point.signal == signal)
}

fn slot_register(slot: u16) -> u16 {
    SLOTS_AT.saturating_add(slot.saturating_mul(SLOT))
}

/// The numbers of a gauge or slave: its parameters or points, each with its position.
fn numbers<'a>(points: &'a [Point], gauge: &'a str) -> impl Iterator<Item = (usize, &'a Point)> {
    let is_number =
        |point: &Point| point.signal.subject() == SubjectKind::Parameter && point.signal.kind() == Kind::Float;
    points.iter().enumerate().filter(move |(_, point)| is_number(point) && point.subject.gauge() == Some(gauge))
}

/// The slaves by their GSD files: they have no reading. With the number of their slots.
fn slaves(points: &[Point]) -> impl Iterator<Item = (&str, u16)> {
    let gauges: BTreeSet<&str> =
        with_signal(points, Signal::Pressure).filter_map(|(_, point)| point.subject.gauge()).collect();
    let all = with_signal(points, Signal::GaugeState).filter_map(|(_, point)| point.subject.gauge());
    all.filter(move |name| !gauges.contains(name)).map(move |slave| {
        let slots = numbers(points, slave).count().div_ceil(PARAMETERS).max(1);
        (slave, u16::try_from(slots).unwrap_or(u16::MAX))
    })
}

/// The slots: the numbers of the file, then the lowest free slots in the order of the file, those of slaves behind those of gauges.
struct Slots {
    /// The slot of each reading, by the name of its series.
    readings: BTreeMap<String, u16>,
    /// The slots of each slave, in the order of its points.
    slaves: BTreeMap<String, Vec<u16>>,
}

impl Slots {
    fn of(points: &[Point], settings: &Settings) -> Result<Self, MapError> {
        let mut taken: BTreeMap<u16, &str> = BTreeMap::new();
        let mut slots = Self { readings: BTreeMap::new(), slaves: BTreeMap::new() };
        let (mut waiting, mut waiting_slaves) = (Vec::new(), Vec::new());
        let mut channels: BTreeMap<&str, u16> = BTreeMap::new();
        for (_, point) in with_signal(points, Signal::Pressure) {
            let Some(gauge) = point.subject.gauge() else { continue };
            let Some(first) = settings.slots.get(gauge) else {
                waiting.push(point.subject.name());
                continue;
            };
            let channel = channels.entry(gauge).or_default();
            let slot = take(&mut taken, gauge, *first, *channel)?;
            *channel = channel.saturating_add(1);
            slots.readings.insert(point.subject.name().to_owned(), slot);
        }
        for (slave, count) in slaves(points) {
            let Some(first) = settings.slots.get(slave) else {
                waiting_slaves.push((slave, count));
                continue;
            };
            let own = (0..count).map(|part| take(&mut taken, slave, *first, part)).collect::<Result<_, _>>()?;
            slots.slaves.insert(slave.to_owned(), own);
        }
        let mut free = (0..SLOTS).filter(|slot| !taken.contains_key(slot));
        let mut next = || free.next().ok_or(FULL);
        for series in waiting {
            slots.readings.insert(series.to_owned(), next()?);
        }
        for (slave, count) in waiting_slaves {
            let own = (0..count).map(|_| next()).collect::<Result<_, _>>()?;
            slots.slaves.insert(slave.to_owned(), own);
        }
        Ok(slots)
    }

    /// What each slot shows.
    fn names(&self) -> impl Iterator<Item = (u16, &str)> {
        let slaves = self.slaves.iter().flat_map(|(slave, slots)| slots.iter().map(|slot| (*slot, slave.as_str())));
        self.readings.iter().map(|(series, slot)| (*slot, series.as_str())).chain(slaves)
    }

    /// The same by the first register of each slot.
    fn meanings(&self) -> impl Iterator<Item = (u16, String)> {
        self.names().map(|(slot, name)| (slot_register(slot), name.to_owned()))
    }
}

const FULL: MapError = MapError::Full { what: "readings and slaves", places: SLOTS };

/// Takes the slot of a gauge that the file numbers.
fn take<'a>(taken: &mut BTreeMap<u16, &'a str>, gauge: &'a str, first: u16, channel: u16) -> Result<u16, MapError> {
    let slot = first.saturating_add(channel);
    if slot >= SLOTS {
        return Err(FULL);
    }
    match taken.insert(slot, gauge) {
        Some(other) => Err(MapError::Overlap { gauge: gauge.to_owned(), first, slot, other: other.to_owned() }),
        None => Ok(slot),
    }
}

/// A number that changes when a place gets another name: CRC-16 with the polynomial of Modbus over the lines `place name`.
fn check_of(names: impl Iterator<Item = (u16, String)>) -> u16 {
    let sorted: BTreeSet<(u16, String)> = names.collect();
    let text: String = sorted.into_iter().map(|(place, name)| format!("{place} {name}\n")).collect();
    let shifted = |crc: u16, _: u8| (crc >> 1) ^ (0xA001 * (crc & 1));
    text.bytes().fold(0xFFFF, |crc, octet| (0..8).fold(crc ^ u16::from(octet), shifted))
}

/// The positions that the slots of each gauge need.
fn gauges(points: &[Point]) -> BTreeMap<String, Gauge> {
    let mut gauges: BTreeMap<String, Gauge> = BTreeMap::new();
    for (index, point) in points.iter().enumerate() {
        let Some(name) = point.subject.gauge() else { continue };
        let gauge = gauges.entry(name.to_owned()).or_default();
        let place = match (&point.subject, point.signal) {
            (_, Signal::ListenOnly) => &mut gauge.listen_only,
            (_, Signal::GaugeState) => &mut gauge.bus_state,
            (_, Signal::AlarmPriority) => &mut gauge.alarm_priority,
            (_, Signal::Unacknowledged) => &mut gauge.unacknowledged,
            (Subject::Parameter { target, .. }, Signal::ParameterNumber) => {
                if target.ends_with("emission-status") {
                    gauge.emission.insert(target, index);
                } else if target.ends_with("degas-status") {
                    gauge.degas.insert(target, index);
                }
                continue;
            }
            _ => continue,
        };
        *place = place.or(Some(index));
    }
    gauges
}

/// The description of a signal, with the number of each of its words: Modbus has no texts.
fn text_of(signal: Signal) -> String {
    let Kind::Choice(words) = signal.kind() else { return signal.description().to_owned() };
    let words: Vec<_> = words.iter().enumerate().map(|(number, word)| format!("{number} {word}")).collect();
    format!("{}: {}", signal.description(), words.join(", "))
}

/// A row of a signal: the offset of its register, what it shows, and the signal.
type SignalRow = (u16, fn(usize) -> Source, Signal);

/// A row of a slot: offset, name, what it shows, unit, description.
type SlotRow = (u16, &'static str, Source, &'static str, &'static str);

/// The rows under construction.
struct Rows<'a> {
    points: &'a [Point],
    settings: &'a Settings,
    rows: Vec<Row>,
}

impl Rows<'_> {
    fn put(&mut self, register: u16, subject: &str, name: &str, source: Source, unit: &'static str, text: &str) {
        let (name, text) = (name.to_owned(), text.to_owned());
        self.rows.push(Row { register, source, subject: Arc::from(subject), name, unit, text });
    }

    /// The position of another point of the subject at `index`.
    fn beside(&self, index: usize, signal: Signal) -> Option<usize> {
        let subject = &self.points.get(index)?.subject;
        let mut own = self.points.iter().enumerate().skip(index).take_while(|(_, point)| point.subject == *subject);
        own.find(|(_, point)| point.signal == signal).map(|(position, _)| position)
    }

    /// Rows of signals of the subject at `index`: offset, source, signal.
    fn signals(&mut self, register: u16, index: usize, rows: &[SignalRow]) {
        let subject = self.points.get(index).map(|point| point.subject.name().to_owned()).unwrap_or_default();
        for (offset, source, signal) in rows {
            if let Some(position) = self.beside(index, *signal) {
                let unit = signal.unit().unwrap_or_default();
                let register = register.saturating_add(*offset);
                self.put(register, &subject, signal.key(), source(position), unit, &text_of(*signal));
            }
        }
    }

    fn header(&mut self, slots: u16, check: u16) {
        let alarms = with_signal(self.points, Signal::AlarmState).map(|(_, point)| point.subject.name().to_owned());
        let alarms = check_of((0_u16..).zip(alarms));
        let rows: [(u16, &str, Source, &'static str); 8] = [
            (0, "test-float", Source::Constant(Some(1.0)), "The number 1.0, to find the order of octets and words"),
            (2, "test-integer", Source::Long(0x0102_0304), "The number 16909060 (01020304 hex), for the same purpose"),
            (4, "map-version", Source::Word(VERSION), "Version of this map"),
            (5, "slots", Source::Word(slots), "Number of slots, with unused ones between"),
            (
                7,
                "slot-check",
                Source::Word(check),
                "Changes when a slot gets another reading, or a register another parameter, point, unit or segment",
            ),
            (8, "time", Source::Now, "Time of the station, seconds since 1970"),
            (18, "alarm-check", Source::Word(alarms), "Changes when an alarm gets another number"),
            (15, "word-order", Source::Word(self.settings.word_order as u16), "0 high word first, 1 low word first"),
        ];
        for (register, name, source, text) in rows {
            self.put(register, "", name, source, "", text);
        }
        if let Some((index, _)) = with_signal(self.points, Signal::Heartbeat).next() {
            self.signals(
                0,
                index,
                &[
                    (6, Source::Number, Signal::Heartbeat),
                    (10, Source::Number, Signal::UnacknowledgedAlarms),
                    (11, Source::Number, Signal::SegmentsDown),
                    (12, Source::Number, Signal::ActiveAlarms),
                    (13, Source::Number, Signal::Recording),
                    (14, Source::Number, Signal::LostSamples),
                    (16, Source::Seconds, Signal::Started),
                    (19, Source::Number, Signal::LostEvents),
                    (20, Source::Seconds, Signal::LastWrite),
                ],
            );
        }
    }

    fn slot(&mut self, register: u16, index: usize, point: &Point) {
        let at = |offset: u16| register.saturating_add(offset);
        let subject = point.subject.name();
        let unit = self.settings.unit;
        let limits = &point.limits;
        let least = |a: Option<f64>, b: Option<f64>| [a, b].into_iter().flatten().reduce(f64::min);
        let greatest = |a: Option<f64>, b: Option<f64>| [a, b].into_iter().flatten().reduce(f64::max);
        let high = Source::Constant(least(limits.high, limits.high_high));
        let low = Source::Constant(greatest(limits.low, limits.low_low));
        let [range_low, range_high] =
            [0, 1].map(|end| Source::Constant(point.range.map(|(low, high)| if end == 0 { low } else { high })));
        let is_time = |other: &Point| other.signal == Signal::LastReading && other.subject == point.subject;
        let read =
            self.points.iter().skip(index).position(is_time).map_or(index, |offset| index.saturating_add(offset));
        let rows: [SlotRow; 12] = [
            (0, "pressure", Source::Float(index), "Pa", "Pressure; the end of the range beyond it; NaN without one"),
            (
                2,
                "log10",
                Source::Thousandfold(index),
                "0.001",
                "Decimal logarithm of the pressure in Pa times 1000; 8000 hex without one",
            ),
            (3, "state", Source::State(index), "", "0 valid, 1 over range, 2 under range, 3 invalid, 4 no data"),
            (
                4,
                "bits",
                Source::Bits(index),
                "",
                "0 stale, 1 fault, 2 emission, 3 degas (register 59500 + slot: whether they are known), 4 5 6 highest active alarm high \
                 medium low, 7 unacknowledged, 8 simulated, 9 listen only, 10 measured, 11 data exchange, 12 to 15 number of the state",
            ),
            (5, "age", Source::Age(read), "0.1 s", "Age of the reading; 65535 for older ones and without one"),
            (6, "pressure-in-unit", Source::InUnit(index), unit.symbol(), "The same pressure in the unit of the file"),
            (
                8,
                "unit",
                Source::Word(unit as u16),
                "",
                "Unit of the register before: 0 Pa, 1 mbar, 2 Torr, 3 hPa, 4 micron",
            ),
            (9, "readings", Source::Readings(read), "", "Counter of readings, modulo 65536"),
            (10, "limit-high", high, "Pa", "Lowest limit of an alarm above it; NaN without one"),
            (12, "limit-low", low, "Pa", "Highest limit of an alarm below it; NaN without one"),
            (16, "range-low", range_low, "Pa", "Lower end of the measuring range; NaN if unknown"),
            (18, "range-high", range_high, "Pa", "Upper end of the measuring range; NaN if unknown"),
        ];
        for (offset, name, source, unit, text) in rows {
            self.put(at(offset), subject, name, source, unit, text);
        }
        self.signals(register, index, &[(14, Source::Float, Signal::CorrectedPressure)]);
    }

    /// Whether the bits of emission and degas are known. The slots have no free register.
    fn known(&mut self, register: u16, index: usize, point: &Point) {
        let text = "0 the bit of the emission is known, 1 the bit of the degas is known; 0 where the gauge has none";
        self.put(register, point.subject.name(), "known", Source::Known(index), "", text);
    }

    /// A slot of a slave: its registers say that there is no reading, because 0 would be a pressure. Its bits show alarms and whether it is
    /// in data exchange.
    fn slot_without_reading(&mut self, register: u16, slave: &str) {
        let text = "A slave by its GSD file has no pressure";
        let floats = [(0, "pressure"), (6, "pressure-in-unit"), (10, "limit-high"), (12, "limit-low")];
        let more = [(14, "corrected-pressure"), (16, "range-low"), (18, "range-high")];
        let floats = floats.into_iter().chain(more).map(|(offset, name)| (offset, name, Source::Constant(None)));
        let words = [(2, "log10", 0x8000), (3, "state", 4), (5, "age", u16::MAX)];
        let words = words.map(|(offset, name, word)| (offset, name, Source::Word(word)));
        for (offset, name, source) in floats.chain(words) {
            self.put(register.saturating_add(offset), slave, name, source, "", text);
        }
        let mut states = with_signal(self.points, Signal::GaugeState);
        if let Some((index, _)) = states.find(|(_, point)| point.subject.gauge() == Some(slave)) {
            let text = "4 5 6 highest active alarm high medium low, 7 unacknowledged, 8 simulated, 9 listen only, 11 data exchange; \
                        0 and 12 to 15 as for a gauge without a reading";
            self.put(register.saturating_add(4), slave, "bits", Source::SlaveBits(index), "", text);
        }
    }

    /// The numbers of a gauge or slave, 46 for each of its slots, and the counters behind those of the first one.
    fn gauge(&mut self, slots: &[u16], gauge: &str) {
        let registers = |slot: &u16| GAUGES_AT.saturating_add(slot.saturating_mul(GAUGE));
        let numbers: Vec<(usize, &Point)> = numbers(self.points, gauge).collect();
        for (first, numbers) in slots.iter().map(registers).zip(numbers.chunks(PARAMETERS)) {
            for (number, (index, point)) in (0..).zip(numbers) {
                let register = first.saturating_add(2_u16.saturating_mul(number));
                let (target, unit) = (point.subject.name(), point.unit.unwrap_or_default());
                self.put(register, gauge, target, Source::Float(*index), unit, point.signal.description());
            }
        }
        let Some(register) = slots.first().map(registers) else { return };
        let mut states = with_signal(self.points, Signal::GaugeState);
        if let Some((index, _)) = states.find(|(_, point)| point.subject.gauge() == Some(gauge)) {
            self.signals(
                register,
                index,
                &[
                    (92, Source::Number, Signal::GaugeState),
                    (93, Source::Number, Signal::Address),
                    (94, Source::Number, Signal::Requests),
                    (95, Source::Number, Signal::Repetitions),
                    (96, Source::Number, Signal::LostCycles),
                    (97, Source::Number, Signal::DamagedAnswers),
                    (98, Source::Number, Signal::Refusals),
                    (99, Source::Number, Signal::LongestSequence),
                ],
            );
        }
    }

    /// What the registers show that depend on parameters, points and segments: the file or a device decides it. All other registers have
    /// the meaning of this version of the map, and alarms have a check value of their own.
    fn meanings(&self) -> impl Iterator<Item = (u16, String)> {
        let is_of_file = |row: &&Row| match row.source {
            Source::Float(index) | Source::Number(index) => self.points.get(index).is_some_and(|point| {
                point.signal.subject() == SubjectKind::Parameter || point.signal == Signal::SegmentState
            }),
            _ => false,
        };
        self.rows
            .iter()
            .filter(is_of_file)
            .map(|row| (row.register, format!("{} {} {}", row.subject, row.name, row.unit)))
    }

    fn segment(&mut self, register: u16, index: usize) {
        self.signals(
            register,
            index,
            &[
                (0, Source::Number, Signal::SegmentState),
                (2, Source::Float, Signal::CycleTime),
                (4, Source::Float, Signal::TokenRotation),
                (6, Source::LongNumber, Signal::Telegrams),
                (8, Source::LongNumber, Signal::DamagedTelegrams),
                (10, Source::LongNumber, Signal::SegmentRepetitions),
                (12, Source::LongNumber, Signal::SegmentLostCycles),
                (14, Source::Float, Signal::LongestCycle),
                (16, Source::Float, Signal::LongestRotation),
                (18, Source::Number, Signal::DamagedLastMinute),
            ],
        );
    }

    fn alarm(&mut self, register: u16, index: usize) {
        let rows: [SignalRow; 2] = [(0, Source::Number, Signal::AlarmState), (1, Source::Number, Signal::Priority)];
        self.signals(register, index, &rows);
    }

    /// The rows of the subjects that have `signal`, in their order. Returns their number.
    fn numbered(
        &mut self,
        signal: Signal,
        first: u16,
        length: u16,
        places: u16,
        what: &'static str,
        put: fn(&mut Self, u16, usize),
    ) -> Result<u16, MapError> {
        let positions: Vec<usize> = with_signal(self.points, signal).map(|(index, _)| index).collect();
        let count = u16::try_from(positions.len()).unwrap_or(u16::MAX);
        if count > places {
            return Err(MapError::Full { what, places });
        }
        for (number, index) in (0_u16..).zip(positions) {
            put(self, first.saturating_add(number.saturating_mul(length)), index);
        }
        Ok(count)
    }
}
