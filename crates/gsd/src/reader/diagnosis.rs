//! Lines of diagnosis.

use super::block::Block;
use super::{Fault, Outcome, Reader, Statement};
use crate::diagnosis::{DiagArea, Diagnosis, UnitDiag, Words};

/// An area whose values follow, and whether it belongs to a type of diagnosis.
pub(super) struct OpenArea {
    area: DiagArea,
    typed: bool,
}

impl Reader {
    /// The lines of Unit_Diag, X_Unit_Diag and Channel_Diag.
    pub(super) fn diagnosis(&mut self, statement: &Statement<'_>) -> Outcome {
        let keyword = statement.keyword.as_str();
        let typed = keyword.strip_prefix("x_");
        match typed.unwrap_or(keyword) {
            "unit_diag_area" => self.open_area(statement, typed.is_some()),
            "unit_diag_area_end" => {
                if self.area.is_none() {
                    self.problem(statement, Fault::StrayEnd, statement.spelled);
                }
                self.close_area();
                Ok(())
            }
            "value" => self.value(statement, false),
            "value_help" => self.value(statement, true),
            "channel_diag" | "channel_diag_help" => self.channel(statement),
            "unit_diag_bit"
            | "unit_diag_bit_help"
            | "unit_diag_!bit"
            | "unit_diag_not_bit"
            | "unit_diag_!bit_help"
            | "unit_diag_not_bit_help" => self.unit_bit(statement, typed.is_some()),
            _ => self.single(statement),
        }
    }

    fn texts(&mut self) -> &mut Diagnosis {
        match &mut self.block {
            Block::Module(module) => &mut module.diagnosis,
            _ => &mut self.device.diagnosis,
        }
    }

    /// The texts of the open type, or else the texts for every block.
    fn unit(&mut self, typed: bool) -> &mut UnitDiag {
        let kind = if let Block::UnitDiag(kind) = self.block { Some(kind).filter(|_| typed) } else { None };
        let texts = self.texts();
        match kind {
            Some(kind) => texts.types.entry(kind).or_default(),
            None => &mut texts.unit,
        }
    }

    fn unit_bit(&mut self, statement: &Statement<'_>, typed: bool) -> Outcome {
        let keyword = statement.keyword.as_str();
        let number = u16::try_from(statement.index()?).map_err(|_| Fault::OutOfRange)?;
        let inverted = keyword.contains("!bit") || keyword.contains("not_bit");
        if keyword == "unit_diag_!bit" {
            self.problem(statement, Fault::InvertedBit, "");
        }
        let unit = self.unit(typed);
        let texts = if inverted { &mut unit.inverted } else { &mut unit.bits };
        put(texts.entry(number).or_default(), statement, keyword.ends_with("_help"));
        Ok(())
    }

    fn channel(&mut self, statement: &Statement<'_>) -> Outcome {
        let error = u8::try_from(statement.index()?).ok().filter(|error| *error < 32).ok_or(Fault::OutOfRange)?;
        put(self.texts().channels.entry(error).or_default(), statement, statement.keyword.ends_with("_help"));
        Ok(())
    }

    fn open_area(&mut self, statement: &Statement<'_>, typed: bool) -> Outcome {
        if self.area.is_some() {
            self.problem(statement, Fault::MissingEnd, statement.spelled);
            self.close_area();
        }
        let &[(first, last)] = statement.values.intervals()?.as_slice() else { return Err(Fault::BadValue) };
        // `24 -31` looks like a negative number.
        let bit = |bit: i64| u16::try_from(bit.unsigned_abs()).map_err(|_| Fault::OutOfRange);
        let (first, last) = (bit(first)?, bit(last)?);
        self.area = Some(OpenArea { area: DiagArea { first, last, ..DiagArea::default() }, typed });
        Ok(())
    }

    fn value(&mut self, statement: &Statement<'_>, help: bool) -> Outcome {
        let value = statement.argument.first().and_then(|value| u64::try_from(*value).ok()).ok_or(Fault::BadValue)?;
        let open = self.area.as_mut().ok_or(Fault::MisplacedKeyword)?;
        put(open.area.values.entry(value).or_default(), statement, help);
        Ok(())
    }

    /// Ends an area.
    pub(super) fn close_area(&mut self) {
        if let Some(OpenArea { area, typed }) = self.area.take() {
            self.unit(typed).areas.push(area);
        }
    }
}

fn put(words: &mut Words, statement: &Statement<'_>, help: bool) {
    let text = statement.values.text().trim().to_owned();
    if help {
        words.help = Some(text);
    } else {
        words.text = text;
    }
}
