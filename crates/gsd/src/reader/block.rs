//! Blocks: modules, texts, parameters, slots, types of diagnosis.

use super::{Fault, MAX_MODULES, Module, Outcome, Parameter, PrmText, Problem, Reader, Statement};
use crate::parameter::DataType;
use profivac_wire::cfg;
use std::collections::BTreeMap;

/// The block that is open.
#[derive(Default)]
pub(super) enum Block {
    #[default]
    None,
    Module(Box<Module>),
    Texts(PrmText),
    Parameter(Parameter),
    Slots,
    UnitDiag(u8),
}

impl Block {
    fn end(&self) -> &'static str {
        match self {
            Block::None => "",
            Block::Module(_) => "endmodule",
            Block::Texts(_) => "endprmtext",
            Block::Parameter(_) => "endextuserprmdata",
            Block::Slots => "endslotdefinition",
            Block::UnitDiag(_) => "endunitdiagtype",
        }
    }
}

impl Reader {
    pub(super) fn open_block(&mut self, statement: &Statement<'_>) -> Outcome {
        self.close_block(Some(statement));
        self.block = match statement.keyword.as_str() {
            "module" => Block::Module(Box::new(self.module(statement))),
            "prmtext" => Block::Texts(PrmText {
                number: statement.values.number()?,
                texts: BTreeMap::new(),
                line: statement.line,
            }),
            "extuserprmdata" => Block::Parameter(parameter(statement)?),
            "slotdefinition" => Block::Slots,
            _ => Block::UnitDiag(statement.values.number()?),
        };
        Ok(())
    }

    pub(super) fn end_block(&mut self, statement: &Statement<'_>) -> Outcome {
        if self.block.end() == statement.keyword {
            self.close_block(None);
        } else if matches!(self.block, Block::None) {
            self.problem(statement, Fault::StrayEnd, statement.spelled);
        } else {
            self.close_block(Some(statement));
        }
        Ok(())
    }

    /// Closes the block. It is a problem if another statement than its end closes it.
    pub(super) fn close_block(&mut self, by: Option<&Statement<'_>>) {
        self.close_area();
        let block = std::mem::take(&mut self.block);
        if let Some(statement) = by.filter(|_| !matches!(block, Block::None)) {
            self.problem(statement, Fault::MissingEnd, statement.spelled);
        }
        let (line, replaced) = match block {
            Block::Module(module) => return self.add(*module),
            Block::Texts(texts) => (texts.line, self.device.texts.insert(texts.number, texts).is_some()),
            Block::Parameter(one) => {
                if !one.allows(one.default) {
                    let found = format!("{} has {}", one.name, one.default);
                    self.problems.push(Problem::new(one.line, Fault::DefaultOutOfRange, found));
                }
                (one.line, self.device.parameters.insert(one.number, one).is_some())
            }
            _ => return,
        };
        if replaced {
            self.problems.push(Problem::new(line, Fault::DefinitionTwice, ""));
        }
    }

    /// Of many modules beyond the limit only the first is a problem.
    fn add(&mut self, module: Module) {
        if self.device.modules.len() < MAX_MODULES {
            self.device.modules.push(module);
        } else if !std::mem::replace(&mut self.has_too_many, true) {
            self.problems.push(Problem::new(
                module.line,
                Fault::TooMany,
                format!("a file has at most {MAX_MODULES} modules"),
            ));
        }
    }

    fn module(&mut self, statement: &Statement<'_>) -> Module {
        let mut values = statement.values;
        let name = values.quoted().unwrap_or_default().trim().to_owned();
        let (config, fault) = values.octets();
        if let Some(fault) = fault {
            self.problem(statement, fault.in_list(), &values.brief());
        }
        let behind_name =
            statement.values.raw().rsplit_once('"').filter(|(name, _)| name.contains('"')).map_or("", |(_, rest)| rest);
        if !behind_name.is_empty() && !behind_name.starts_with([' ', '\t']) {
            self.problem(statement, Fault::ModuleBlank, &name);
        }
        if !config.is_empty() && cfg::lengths(&config).is_err() {
            self.problem(statement, Fault::BadIdentifiers, &name);
        }
        Module { name, config, line: statement.line, ..Module::default() }
    }

    /// Prm_Text_Ref, Changeable and Visible.
    pub(super) fn attribute(&mut self, statement: &Statement<'_>) -> Outcome {
        let Block::Parameter(parameter) = &mut self.block else { return Err(Fault::MisplacedKeyword) };
        let value: u32 = statement.values.number()?;
        match statement.keyword.as_str() {
            "prm_text_ref" => parameter.texts = Some(value),
            "changeable" => parameter.changeable = value != 0,
            _ => parameter.visible = value != 0,
        }
        Ok(())
    }

    /// The type, the default and the allowed values of a parameter.
    pub(super) fn data_type(&mut self, statement: &Statement<'_>) -> Outcome {
        let kind = data_type(statement).ok_or(Fault::UnknownKeyword)?;
        let is_bits = matches!(kind, DataType::Bit(_) | DataType::BitArea(..));
        let bad_bits = is_bits && statement.argument != bits(kind);
        let Block::Parameter(parameter) = &mut self.block else { return Err(Fault::MisplacedKeyword) };
        let mut values = statement.values;
        let no_default = values.starts_with_range() || values.is_empty();
        let given = if no_default { None } else { Some(values.signed().ok_or(Fault::BadValue)?) };
        parameter.kind = kind;
        parameter.allowed = values.intervals()?;
        parameter.default = given.or_else(|| parameter.allowed.first().map(|(low, _)| *low)).unwrap_or(0);
        if no_default {
            self.problem(statement, Fault::MissingDefault, &statement.values.brief());
        }
        if bad_bits {
            self.problem(statement, Fault::BadBits, statement.spelled);
        }
        Ok(())
    }
}

fn parameter(statement: &Statement<'_>) -> Result<Parameter, Fault> {
    let mut values = statement.values;
    let number = values.unsigned().and_then(|number| u32::try_from(number).ok()).ok_or(Fault::BadValue)?;
    let name = values.quoted().unwrap_or_default().trim().to_owned();
    Ok(Parameter {
        number,
        name,
        kind: DataType::Unsigned8,
        default: 0,
        allowed: Vec::new(),
        texts: None,
        changeable: true,
        visible: true,
        line: statement.line,
    })
}

/// The type of a keyword. Bits are within the octet and in rising order.
fn data_type(statement: &Statement<'_>) -> Option<DataType> {
    let bit = |index: usize| {
        statement.argument.get(index).and_then(|bit| u8::try_from(*bit).ok()).map_or(0, |bit| bit.min(7))
    };
    Some(match statement.keyword.as_str() {
        "bit" => DataType::Bit(bit(0)),
        "bitarea" => {
            let last = if statement.argument.len() > 1 { bit(1) } else { bit(0) };
            DataType::BitArea(bit(0).min(last), bit(0).max(last))
        }
        "unsigned8" => DataType::Unsigned8,
        "unsigned16" => DataType::Unsigned16,
        "unsigned32" => DataType::Unsigned32,
        "signed8" => DataType::Signed8,
        "signed16" => DataType::Signed16,
        "signed32" => DataType::Signed32,
        _ => return None,
    })
}

fn bits(kind: DataType) -> Vec<i128> {
    match kind {
        DataType::Bit(bit) => vec![i128::from(bit)],
        DataType::BitArea(first, last) => vec![i128::from(first), i128::from(last)],
        _ => Vec::new(),
    }
}
