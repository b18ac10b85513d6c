//! `[[segment.slave.point]]`.

use super::alarms::{AlarmedPoint, PointAlarmToml};
use super::at;
use crate::error::{Located, NamedItem};
use crate::names;
use crate::slave_problem::SlaveProblem;
use profivac_gsd_slave::{GsdSlave, ModuleData};
use profivac_station::alarm::Rule;
use profivac_station::config::{PointType, SlavePoint, unit};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::ops::Range;
use toml::Spanned;

/// The most characters of a unit. chosen: EPICS shows seven, OPC UA and the dashboard more.
const MAX_UNIT: usize = 16;

/// The most characters of the text of a code. chosen: a table of the dashboard shows it in one line.
const MAX_TEXT: usize = 80;

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
    /// Its first octet within the inputs of the module. Default: 0.
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
    /// An alarm of the value.
    #[serde(default)]
    alarm: Vec<PointAlarmToml>,
}

/// The points of a slave.
pub fn points(points: &[PointToml], gsd: &GsdSlave) -> Result<Vec<SlavePoint>, Located> {
    names::unique(NamedItem::Point, points.iter().map(|point| &point.name))?;
    points.iter().map(|point| point.settings(gsd)).collect()
}

impl PointToml {
    fn settings(&self, gsd: &GsdSlave) -> Result<SlavePoint, Located> {
        let data = self.data(gsd)?;
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
        let place = format!("{} octet {octet}", data.name());
        Ok(SlavePoint {
            name: self.name.get_ref().clone(),
            place: if kind == PointType::Bool { format!("{place} bit {bit}") } else { place },
            kind,
            octet: data.start.saturating_add(octet),
            bit,
            is_little_endian: self.is_little_endian()?,
            scale: self.scale()?,
            offset: self.finite(self.offset.as_ref(), 0.0)?,
            unit: self.unit()?,
            texts: self.texts(kind)?,
            status: status.map(|status| data.start.saturating_add(status)),
        })
    }

    /// The module in the slot or with the name of the point; the only module with inputs without them.
    fn data<'g>(&self, gsd: &'g GsdSlave) -> Result<ModuleData<'g>, Located> {
        let all: Vec<ModuleData<'g>> = gsd.layout().inputs().collect();
        let possible: Vec<String> = all.iter().map(ModuleData::name).collect();
        let wrong = |span: Range<usize>, problem: String| {
            let possible = if possible.is_empty() { "none".to_owned() } else { possible.join(", ") };
            Err(at(span, SlaveProblem::PointModule { point: self.name.get_ref().clone(), problem, possible }))
        };
        let in_slot =
            |data: &&ModuleData<'_>| self.slot.as_ref().is_none_or(|slot| data.module.slot == *slot.get_ref());
        let has_name =
            |data: &&ModuleData<'_>| self.module.as_ref().is_none_or(|name| data.module.name == name.get_ref().trim());
        let found: Vec<_> = all.iter().filter(in_slot).filter(has_name).collect();
        let span = self.slot.as_ref().map(Spanned::span).or(self.module.as_ref().map(Spanned::span));
        match (found.as_slice(), span) {
            ([only], _) => Ok(**only),
            ([], Some(span)) => wrong(span, "no module with inputs is there".to_owned()),
            ([], None) => wrong(self.name.span(), "the slave has no inputs".to_owned()),
            (_, span) => {
                wrong(span.unwrap_or_else(|| self.name.span()), "several modules may have it: say slot".to_owned())
            }
        }
    }

    fn check_within(
        &self,
        data: ModuleData<'_>,
        octet: usize,
        length: usize,
        span: Range<usize>,
    ) -> Result<(), Located> {
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
                module: data.name(),
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
