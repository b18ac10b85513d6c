//! The contents of all registers at one moment.

use crate::map::{Gauge, Map, OfChannels, Source};
use profivac_gateway::signal::{gauge_state, priority};
use profivac_gateway::{Point, PointValue, Snapshot, State, Subject, Value};
use profivac_recorder::Micros;
use profivac_station::config::gateways::modbus::{Settings, WordOrder};
use std::collections::BTreeMap;
use std::time::Instant;

/// The registers of an area, from its first one.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Area {
    first: u16,
    registers: Vec<u16>,
}

/// The contents of all registers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    areas: Vec<Area>,
    /// When it was made.
    pub made: Instant,
}

impl Image {
    /// The contents of `count` registers from `first` on; `None` if they are not in one area.
    #[must_use]
    pub fn read(&self, first: u16, count: u16) -> Option<&[u16]> {
        self.areas.iter().find_map(|area| {
            let start = usize::from(first.checked_sub(area.first)?);
            area.registers.get(start..start.checked_add(usize::from(count))?)
        })
    }
}

/// Makes images from snapshots.
#[derive(Debug)]
pub struct Encoder {
    map: Map,
    word_order: WordOrder,
    settings: Settings,
    /// The time of the last reading of a point, and how many there were.
    readings: BTreeMap<usize, (Option<Micros>, u16)>,
}

impl Encoder {
    /// An encoder for this map.
    #[must_use]
    pub fn new(map: Map, settings: &Settings) -> Self {
        Self { map, word_order: settings.word_order, settings: settings.clone(), readings: BTreeMap::new() }
    }

    /// The registers of a snapshot.
    pub fn image(&mut self, snapshot: &Snapshot, now: Micros) -> Image {
        let area = |(first, length): &(u16, u16)| Area { first: *first, registers: vec![0; usize::from(*length)] };
        let mut image = Image { areas: self.map.areas.iter().map(area).collect(), made: Instant::now() };
        for index in 0..self.map.rows.len() {
            let Some((register, source)) = self.map.rows.get(index).map(|row| (row.register, row.source)) else {
                continue;
            };
            match self.content(source, snapshot, now) {
                Content::One(word) => put(&mut image, register, &[word]),
                Content::Two(long) => put(&mut image, register, &self.words(long)),
            }
        }
        image
    }

    /// The two words of a 32-bit value in the order of the file. Octets are in the order of the protocol: high octet first.
    fn words(&self, long: u32) -> [u16; 2] {
        let [a, b, c, d] = long.to_be_bytes();
        let (high, low) = (u16::from_be_bytes([a, b]), u16::from_be_bytes([c, d]));
        match self.word_order {
            WordOrder::HighFirst => [high, low],
            WordOrder::LowFirst => [low, high],
        }
    }

    fn content(&mut self, source: Source, snapshot: &Snapshot, now: Micros) -> Content {
        let value = |index: usize| snapshot.values.get(index);
        let number = |index: usize| value(index).map_or(0, |value| whole(&value.value));
        let state = |index: usize| value(index).map_or(State::default(), |value| value.state);
        match source {
            Source::Word(word) => Content::One(word),
            Source::Long(long) => Content::Two(long),
            Source::Constant(number) => Content::float(number),
            Source::Float(index) => Content::float(value(index).and_then(|value| value.value.float())),
            Source::InUnit(index) => {
                let pa = value(index).and_then(|value| value.value.float());
                Content::float(pa.map(|pa| self.settings.unit.of_pa(pa)))
            }
            Source::Thousandfold(index) => Content::One(thousandfold(value(index))),
            Source::State(index) => Content::One(state(index).codes().modbus),
            Source::Bits(index) => {
                Content::One(self.of_gauge(index, snapshot, |point, gauge| bits(point, state(index), gauge, snapshot)))
            }
            // A slave has no reading.
            Source::SlaveBits(index) => {
                Content::One(self.of_gauge(index, snapshot, |point, gauge| bits(point, State::Stale, gauge, snapshot)))
            }
            Source::Known(index) => Content::One(self.of_gauge(index, snapshot, |point, gauge| {
                word(emission_and_degas(point, gauge, snapshot).map(|it| it.is_some()))
            })),
            Source::Age(index) => Content::One(age(time(value(index)), now)),
            Source::Readings(index) => Content::One(self.count(index, time(value(index)))),
            Source::Number(index) => Content::One(low_word(number(index))),
            Source::LongNumber(index) => Content::Two(low_long(number(index))),
            Source::Seconds(index) => Content::Two(time(value(index)).map_or(0, seconds)),
            Source::Now => Content::Two(seconds(now)),
        }
    }

    /// Counts the readings of a point: each time of a reading once.
    fn count(&mut self, index: usize, at: Option<Micros>) -> u16 {
        let (last, count) = self.readings.entry(index).or_default();
        if at.is_some() && *last != at {
            *last = at;
            *count = count.wrapping_add(1);
        }
        *count
    }

    /// What `make` gives for the point at `index` and its gauge; 0 if there is no such point.
    fn of_gauge(&self, index: usize, snapshot: &Snapshot, make: impl FnOnce(&Point, &Gauge) -> u16) -> u16 {
        let Some(point) = snapshot.points.get(index) else { return 0 };
        let gauge = point.subject.gauge().and_then(|name| self.map.gauges.get(name));
        make(point, gauge.unwrap_or(&Gauge::default()))
    }
}

/// The content of a register, or of two.
enum Content {
    One(u16),
    Two(u32),
}

impl Content {
    /// A number as binary32; the quiet NaN 7FC0 0000 if there is none.
    #[expect(clippy::cast_possible_truncation, reason = "the registers have a precision of 24 bits")]
    fn float(number: Option<f64>) -> Self {
        Self::Two(number.map_or(0x7FC0_0000, |number| (number as f32).to_bits()))
    }
}

fn put(image: &mut Image, register: u16, words: &[u16]) {
    for (offset, word) in (0..).zip(words) {
        let register = register.saturating_add(offset);
        let target = image
            .areas
            .iter_mut()
            .find_map(|area| area.registers.get_mut(usize::from(register.checked_sub(area.first)?)));
        if let Some(target) = target {
            *target = *word;
        }
    }
}

fn whole(value: &Value) -> i64 {
    match value {
        Value::Integer(number) => *number,
        Value::Boolean(value) => i64::from(*value),
        Value::Choice(number) => i64::from(*number),
        Value::None | Value::Float(_) | Value::Text(_) | Value::Time(_) => 0,
    }
}

/// The low 16 bits: counters begin again at 0.
fn low_word(number: i64) -> u16 {
    let [.., high, low] = number.to_be_bytes();
    u16::from_be_bytes([high, low])
}

/// The low 32 bits.
fn low_long(number: i64) -> u32 {
    let [.., a, b, c, d] = number.to_be_bytes();
    u32::from_be_bytes([a, b, c, d])
}

fn seconds(at: Micros) -> u32 {
    u32::try_from(at.0 / 1_000_000).unwrap_or_default()
}

/// 8000 hex where there is no pressure.
#[expect(clippy::cast_possible_truncation, reason = "clamped to the range of the type")]
fn thousandfold(value: Option<&PointValue>) -> u16 {
    let log = value.and_then(|value| value.value.float()).filter(|pa| *pa > 0.0).map(f64::log10);
    log.map_or(0x8000, |log| (log * 1000.0).round().clamp(-32_767.0, 32_767.0) as i16 as u16)
}

/// The time that a point has as its value.
fn time(value: Option<&PointValue>) -> Option<Micros> {
    match value?.value {
        Value::Time(at) => Some(at),
        _ => None,
    }
}

/// In 0.1 s.
fn age(at: Option<Micros>, now: Micros) -> u16 {
    let Some(at) = at else { return u16::MAX };
    let tenths = now.0.saturating_sub(at.0).max(0) / 100_000;
    u16::try_from(tenths).unwrap_or(u16::MAX)
}

/// A word with these bits, from bit 0.
fn word<const COUNT: usize>(flags: [bool; COUNT]) -> u16 {
    let set = flags.into_iter().enumerate().filter(|(_, is_set)| *is_set);
    set.fold(0, |bits, (bit, _)| bits | (1 << bit))
}

/// Whether emission and degas of a reading are on; `None` where the station does not know it.
fn emission_and_degas(point: &Point, gauge: &Gauge, snapshot: &Snapshot) -> [Option<bool>; 2] {
    let channel = match point.subject {
        Subject::Reading { channel, .. } => channel,
        _ => None,
    };
    // The codes of all devices have 0 for off; the others say with which current it is on, or that a degas runs.
    let is_on = |parameter: &OfChannels| {
        let value = parameter.of(channel).and_then(|index| snapshot.values.get(index));
        value.and_then(|it| it.value.float()).map(|code| code != 0.0)
    };
    [is_on(&gauge.emission), is_on(&gauge.degas)]
}

fn bits(point: &Point, state: State, gauge: &Gauge, snapshot: &Snapshot) -> u16 {
    let number = |index: Option<usize>| index.and_then(|index| snapshot.values.get(index)).map(|it| whole(&it.value));
    let has_priority = |priority: u16| number(gauge.alarm_priority) == Some(priority.into());
    let [emission, degas] = emission_and_degas(point, gauge, snapshot).map(|it| it == Some(true));
    let flags = [
        matches!(state, State::Stale | State::Starting),
        state == State::Fault,
        emission,
        degas,
        has_priority(priority::HIGH),
        has_priority(priority::MEDIUM),
        has_priority(priority::LOW),
        number(gauge.unacknowledged) == Some(1),
        point.is_simulated,
        number(gauge.listen_only) == Some(1),
        state.codes().is_measured,
        number(gauge.bus_state) == Some(gauge_state::DATA_EXCHANGE.into()),
    ];
    word(flags) | (state.number() << 12)
}
