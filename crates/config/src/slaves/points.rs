//! `[[segment.slave.point]]`.

use super::alarms::{AlarmedPoint, PointAlarmToml};
use super::at;
use crate::error::{Located, NamedItem};
use crate::names;
use crate::slave_problem::SlaveProblem;
use crate::time_span::TimeSpan;
use profivac_gsd_slave::{Direction, GsdSlave, ModuleData};
use profivac_host::text_file::Parsed;
use profivac_station::alarm::Rule;
use profivac_station::config::{PointType, SlavePoint, WatchedRecord, unit};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::ops::{Range, RangeInclusive};
use std::time::Duration;
use toml::Spanned;

/// The most characters of a unit. chosen: EPICS shows seven, OPC UA and the dashboard more.
const MAX_UNIT: usize = 16;

/// The most characters of the text of a code. chosen: a table of the dashboard shows it in one line.
const MAX_TEXT: usize = 80;

/// The longest record, profibus-wire 4.1, and the highest slot and index.
const MAX_RECORD: usize = 240;
const MAX_PLACE: u8 = 254;

/// The time between two readings of a record, and its range. chosen: as for the parameters of gauges.
const EVERY_USUALLY: Duration = Duration::from_secs(10);
const EVERY: RangeInclusive<Duration> = Duration::from_secs(1)..=Duration::from_secs(3600);

/// `[[segment.slave.point]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointToml {
    /// The name, unique for its slave.
    name: Spanned<String>,
    /// The slot of its module. Not needed if one module only has inputs.
    slot: Option<Spanned<u32>>,
    /// The name of its module, instead of `slot`.
    module: Option<Spanned<String>>,
    /// Instead of `slot`: the DP-V1 record as `"SLOT/INDEX"`, which the station reads over MS2. Only of a slave that it does not own.
    record: Option<Spanned<String>>,
    /// The time between two readings of the record, 1 s to 1 h. Default: `10 s`.
    every: Option<Spanned<Parsed<TimeSpan>>>,
    /// Its first octet within the inputs of the module, or within the record. Default: 0.
    octet: Option<Spanned<usize>>,
    /// The bit of the octet, 0 (lowest) to 7. Needed for `bool`.
    bit: Option<Spanned<u8>>,
    /// `bool`, `u8`, `i8`, `u16`, `i16`, `u32`, `i32`, `f32`, or `pa`: a float with the status octet of PROFIBUS PA behind it.
    #[serde(rename = "type")]
    kind: Spanned<String>,
    /// `big` or `little`: which octet comes first. Default: `big`, as PROFIBUS has it.
    order: Option<Spanned<String>>,
    /// The value is the number times `scale` plus `offset`. Default: 1.
    scale: Option<Spanned<f64>>,
    /// See `scale`. Default: 0.
    offset: Option<Spanned<f64>>,
    /// The unit of the value, up to 16 characters.
    unit: Option<Spanned<String>>,
    /// Texts for codes: `{ 0 = "closed", 1 = "open" }`.
    #[serde(default)]
    texts: BTreeMap<Spanned<String>, Spanned<String>>,
    /// The octet of the module that has the quality of the value as a status of PROFIBUS PA.
    status: Option<Spanned<usize>>,
    /// Only of an output, and needed there: its value with the unit, the text of a code, or `"on"` and `"off"` of a bit.
    value: Option<Spanned<ValueToml>>,
    /// The recorder keeps a value that differs by more than this from the last one that it kept, in the unit of the point. Default: 0, each
    /// change. Not for bits and codes.
    deadband: Option<Spanned<f64>>,
    /// An alarm of the value.
    #[serde(default)]
    alarm: Vec<PointAlarmToml>,
}

/// The value of an output.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
pub enum ValueToml {
    /// `true` is on.
    Bit(bool),
    /// A number, for an output without a unit.
    Number(f64),
    /// A number with its unit, or a text.
    Text(String),
}

/// The points of a slave. `refusal` says why the station reads no records of it, if so.
pub fn points(points: &[PointToml], gsd: &GsdSlave, refusal: Option<&'static str>) -> Result<Vec<SlavePoint>, Located> {
    names::unique(NamedItem::Point, points.iter().map(|point| &point.name))?;
    points.iter().map(|point| point.input(gsd, refusal)).collect()
}

/// The octets that contain a point: a module's part of the inputs or outputs, or a record.
struct Space {
    name: String,
    /// The first octet within all inputs or outputs.
    start: usize,
    octets: usize,
}

impl From<ModuleData<'_>> for Space {
    fn from(data: ModuleData<'_>) -> Self {
        Self { name: data.name(), start: data.start, octets: data.octets }
    }
}

impl PointToml {
    fn input(&self, gsd: &GsdSlave, refusal: Option<&'static str>) -> Result<SlavePoint, Located> {
        if let Some(value) = &self.value {
            return Err(self.wrong(value.span(), "value only in [[segment.slave.output]]", "a value of an input"));
        }
        let Some(given) = &self.record else {
            self.check_no_record()?;
            return self.settings(&self.data(gsd, Direction::Input)?.into());
        };
        if let Some(refusal) = refusal {
            return Err(self.wrong(given.span(), refusal, "a record"));
        }
        if let Some(span) = self.slot.as_ref().map(Spanned::span).or(self.module.as_ref().map(Spanned::span)) {
            return Err(self.wrong(span, "record, or slot or module", "both"));
        }
        let record = self.record(given)?;
        let name = format!("record {}/{}", record.slot, record.index);
        let point = self.settings(&Space { name, start: 0, octets: MAX_RECORD })?;
        Ok(SlavePoint { record: Some(record), ..point })
    }

    /// Slot and index of a record, and how often it is read.
    fn record(&self, given: &Spanned<String>) -> Result<WatchedRecord, Located> {
        let number = |text: &str| text.trim().parse::<u8>().ok().filter(|number| *number <= MAX_PLACE);
        let place = given.get_ref().split_once('/').and_then(|(slot, index)| Some((number(slot)?, number(index)?)));
        let (slot, index) = place.ok_or_else(|| {
            let expected = "a record as \"SLOT/INDEX\" like \"1/24\", each from 0 to 254";
            self.wrong(given.span(), expected, format!("{:?}", given.get_ref()))
        })?;
        let every = match &self.every {
            Some(every) if !EVERY.contains(&*every.get_ref().0) => {
                return Err(self.wrong(every.span(), "a time from 1 s to 1 h", every.get_ref().0));
            }
            Some(every) => every.get_ref().0.into(),
            None => EVERY_USUALLY,
        };
        Ok(WatchedRecord { slot, index, every })
    }

    fn check_no_record(&self) -> Result<(), Located> {
        match (&self.record, &self.every) {
            (Some(record), _) => Err(self.wrong(record.span(), "record only of an input", "an output with it")),
            (None, Some(every)) => Err(self.wrong(every.span(), "every only with record", "one without")),
            (None, None) => Ok(()),
        }
    }

    /// The place of an output, and its number before `scale` and `offset`.
    pub fn output(&self, gsd: &GsdSlave) -> Result<(SlavePoint, f64), Located> {
        if let Some(status) = &self.status {
            return Err(self.wrong(status.span(), "status only of an input", "an output with it"));
        }
        if !self.alarm.is_empty() {
            return Err(self.wrong(self.name.span(), "alarms only of an input", "an output with one"));
        }
        self.check_no_record()?;
        let point = self.settings(&self.data(gsd, Direction::Output)?.into())?;
        let value = self.value.as_ref().ok_or_else(|| self.wrong(self.name.span(), "the key value", "none"))?;
        let found = match value.get_ref() {
            ValueToml::Bit(on) => if *on { "on" } else { "off" }.to_owned(),
            ValueToml::Number(number) => number.to_string(),
            ValueToml::Text(text) => format!("{text:?}"),
        };
        let raw = raw(&point, value.get_ref()).filter(|raw| point.put_raw(*raw, &mut []));
        let raw = raw.ok_or_else(|| {
            let (output, expected) = (self.name.get_ref().clone(), values(&point));
            at(value.span(), SlaveProblem::OutputValue { output, expected, found })
        })?;
        Ok((point, raw))
    }

    /// The name of the point.
    pub const fn name(&self) -> &Spanned<String> {
        &self.name
    }

    fn settings(&self, data: &Space) -> Result<SlavePoint, Located> {
        let word = self.kind.get_ref();
        let kind = PointType::ALL.iter().find(|(known, _)| known == word).map(|(_, kind)| *kind);
        let kind = kind.ok_or_else(|| at(self.kind.span(), SlaveProblem::PointType { found: word.clone() }))?;
        let octet = self.octet.as_ref().map_or(0, |octet| *octet.get_ref());
        let octet_at = self.octet.as_ref().map_or_else(|| self.name.span(), Spanned::span);
        self.check_within(data, octet, kind.octets(), octet_at)?;
        let own_status = (kind == PointType::Pa).then_some(octet.saturating_add(4));
        if let Some(status) = &self.status {
            self.check_within(data, *status.get_ref(), 1, status.span())?;
        }
        let status = self.status.as_ref().map(|status| *status.get_ref()).or(own_status);
        let bit = self.bit(kind)?;
        let place = format!("{} octet {octet}", data.name);
        Ok(SlavePoint {
            name: self.name.get_ref().clone(),
            place: if kind == PointType::Bool { format!("{place} bit {bit}") } else { place },
            record: None,
            kind,
            octet: data.start.saturating_add(octet),
            bit,
            is_little_endian: self.is_little_endian()?,
            scale: self.scale()?,
            offset: self.finite(self.offset.as_ref(), 0.0)?,
            unit: self.unit()?,
            texts: self.texts(kind)?,
            status: status.map(|status| data.start.saturating_add(status)),
            deadband: self.deadband(kind)?,
        })
    }

    /// The module in the slot or with the name of the point; the only module with inputs (outputs) without them.
    fn data<'g>(&self, gsd: &'g GsdSlave, direction: Direction) -> Result<ModuleData<'g>, Located> {
        let what = if direction == Direction::Input { "inputs" } else { "outputs" };
        let all: Vec<ModuleData<'g>> = gsd.layout().data(direction).collect();
        let possible: Vec<String> = all.iter().map(ModuleData::name).collect();
        let wrong = |span: Range<usize>, problem: String| {
            let possible = if possible.is_empty() { "none".to_owned() } else { possible.join(", ") };
            Err(at(span, SlaveProblem::PointModule { point: self.name.get_ref().clone(), problem, what, possible }))
        };
        let in_slot =
            |data: &&ModuleData<'_>| self.slot.as_ref().is_none_or(|slot| data.module.slot == *slot.get_ref());
        let has_name =
            |data: &&ModuleData<'_>| self.module.as_ref().is_none_or(|name| data.module.name == name.get_ref().trim());
        let found: Vec<_> = all.iter().filter(in_slot).filter(has_name).collect();
        let span = self.slot.as_ref().map(Spanned::span).or(self.module.as_ref().map(Spanned::span));
        match (found.as_slice(), span) {
            ([only], _) => Ok(**only),
            ([], Some(span)) => wrong(span, format!("no module with {what} is there")),
            ([], None) => wrong(self.name.span(), format!("the slave has no {what}")),
            (_, span) => {
                wrong(span.unwrap_or_else(|| self.name.span()), "several modules may have it: say slot".to_owned())
            }
        }
    }

    fn check_within(&self, data: &Space, octet: usize, length: usize, span: Range<usize>) -> Result<(), Located> {
        let last = octet.saturating_add(length.saturating_sub(1));
        if last < data.octets {
            return Ok(());
        }
        let needed = if length == 1 { format!("octet {octet}") } else { format!("the octets {octet} to {last}") };
        Err(at(
            span,
            SlaveProblem::PointBeyond {
                point: self.name.get_ref().clone(),
                needed,
                module: data.name.clone(),
                last: data.octets.saturating_sub(1),
            },
        ))
    }

    fn wrong(&self, span: Range<usize>, expected: &'static str, found: impl ToString) -> Located {
        let (point, found) = (self.name.get_ref().clone(), found.to_string());
        at(span, SlaveProblem::PointValue { point, expected, found })
    }

    /// The alarms of the point of `slave`, with the places of their conditions.
    pub fn rules(&self, slave: &str) -> Vec<Result<(Range<usize>, Rule), Located>> {
        let unit = self.unit.as_ref().map(|text| unit(text.get_ref()));
        let point = AlarmedPoint { slave, name: &self.name, unit, texts: self.possible_texts() };
        self.alarm.iter().map(|alarm| alarm.rule(&point)).collect()
    }

    /// The texts that the value may have, apart from numbers.
    fn possible_texts(&self) -> Vec<String> {
        let given = self.texts.values().map(|text| text.get_ref().clone());
        if self.kind.get_ref() != "bool" {
            return given.collect();
        }
        let has_text = |bit: &str| self.texts.keys().any(|code| code.get_ref() == bit);
        let usual = [("0", "off"), ("1", "on")].into_iter().filter(|(bit, _)| !has_text(bit));
        usual.map(|(_, text)| text.to_owned()).chain(given).collect()
    }

    fn bit(&self, kind: PointType) -> Result<u8, Located> {
        match (&self.bit, kind) {
            (Some(bit), PointType::Bool) if *bit.get_ref() <= 7 => Ok(*bit.get_ref()),
            (Some(bit), PointType::Bool) => Err(self.wrong(bit.span(), "a bit from 0 to 7", bit.get_ref())),
            (Some(bit), _) => Err(self.wrong(bit.span(), "bit only with type = \"bool\"", self.kind.get_ref())),
            (None, PointType::Bool) => Err(self.wrong(self.kind.span(), "the key bit with type = \"bool\"", "none")),
            (None, _) => Ok(0),
        }
    }

    fn is_little_endian(&self) -> Result<bool, Located> {
        let Some(order) = &self.order else { return Ok(false) };
        match order.get_ref().as_str() {
            "big" => Ok(false),
            "little" => Ok(true),
            other => Err(self.wrong(order.span(), "an order, big or little", format!("{other:?}"))),
        }
    }

    fn finite(&self, given: Option<&Spanned<f64>>, default: f64) -> Result<f64, Located> {
        let Some(given) = given else { return Ok(default) };
        let number = *given.get_ref();
        if number.is_finite() { Ok(number) } else { Err(self.wrong(given.span(), "a number", number)) }
    }

    /// With 0 every value of the point would be `offset`.
    fn scale(&self) -> Result<f64, Located> {
        match &self.scale {
            Some(given) if *given.get_ref() == 0.0 => Err(self.wrong(given.span(), "a number other than 0", 0)),
            given => self.finite(given.as_ref(), 1.0),
        }
    }

    /// A code has none: two codes with neighbouring numbers are two states.
    fn deadband(&self, kind: PointType) -> Result<f64, Located> {
        let Some(given) = &self.deadband else { return Ok(0.0) };
        if kind == PointType::Bool || !self.texts.is_empty() {
            return Err(self.wrong(
                given.span(),
                "deadband only for numbers",
                "a bit or a code, of which each change is recorded",
            ));
        }
        match self.finite(Some(given), 0.0)? {
            width if width >= 0.0 => Ok(width),
            width => Err(self.wrong(given.span(), "a number that is not negative", width)),
        }
    }

    fn unit(&self) -> Result<Option<&'static str>, Located> {
        let Some(given) = &self.unit else { return Ok(None) };
        names::check_length(NamedItem::Unit, given, MAX_UNIT)?;
        Ok(Some(unit(given.get_ref())))
    }

    /// The texts of the codes. A float has no codes.
    fn texts(&self, kind: PointType) -> Result<Vec<(i64, String)>, Located> {
        let text = |(code, text): (&Spanned<String>, &Spanned<String>)| {
            let word = self.kind.get_ref();
            let codes = kind.codes();
            let codes = codes.ok_or_else(|| self.wrong(code.span(), "texts only for whole numbers and bits", word))?;
            // One code has one key: 1, 01 and +1 are not three of them.
            let number = code.get_ref().parse::<i64>().ok().filter(|number| number.to_string() == *code.get_ref());
            let number = number
                .ok_or_else(|| self.wrong(code.span(), "a whole number as code", format!("{:?}", code.get_ref())))?;
            if !codes.contains(&number) {
                let found = format!("{number}, {word} has {} to {}", codes.start(), codes.end());
                return Err(self.wrong(code.span(), "a code of the type", found));
            }
            names::check_length(NamedItem::CodeText, text, MAX_TEXT)?;
            Ok((number, text.get_ref().clone()))
        };
        self.texts.iter().map(text).collect()
    }
}

/// The number before `scale` and `offset` of a value; `None` if it is none of the point.
fn raw(point: &SlavePoint, value: &ValueToml) -> Option<f64> {
    let text = match value {
        ValueToml::Bit(on) => return (point.kind == PointType::Bool).then(|| f64::from(u8::from(*on))),
        // 9 of Hz is not 9 of rpm.
        ValueToml::Number(number) => return Some(point.raw(*number)).filter(|_| point.unit.is_none()),
        ValueToml::Text(text) => text.trim(),
    };
    if let Some((code, _)) = point.texts.iter().find(|(_, word)| word == text) {
        #[expect(clippy::cast_precision_loss, reason = "codes have 32 bits")]
        let number = *code as f64;
        return Some(number);
    }
    match (text, point.kind) {
        ("off", PointType::Bool) => return Some(0.0),
        ("on", PointType::Bool) => return Some(1.0),
        _ => {}
    }
    let number = text.strip_suffix(point.unit?)?.trim_end().parse::<f64>().ok()?;
    number.is_finite().then(|| point.raw(number))
}

/// The values that an output may have, in words.
fn values(point: &SlavePoint) -> String {
    let texts: Vec<_> = point.texts.iter().map(|(_, text)| format!("{text:?}")).collect();
    let unit = point.unit.map(|unit| format!(" {unit}")).unwrap_or_default();
    #[expect(clippy::cast_precision_loss, reason = "codes have 32 bits")]
    let end = |code: i64| (code as f64).mul_add(point.scale, point.offset);
    let numbers = match (point.kind, point.kind.codes()) {
        (PointType::Bool, _) => "\"on\" or \"off\"".to_owned(),
        (_, None) => format!("a number like \"1.5{unit}\""),
        (_, Some(codes)) => {
            let (one, other) = (end(*codes.start()), end(*codes.end()));
            let step =
                if point.scale.abs() == 1.0 { String::new() } else { format!(", in steps of {}", point.scale.abs()) };
            format!("a number with its unit from \"{}{unit}\" to \"{}{unit}\"{step}", one.min(other), one.max(other))
        }
    };
    if texts.is_empty() { numbers } else { format!("one of {}, or {numbers}", texts.join(", ")) }
}
