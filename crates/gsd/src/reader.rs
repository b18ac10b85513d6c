//! Statements to the model.

mod block;
mod check;
mod diagnosis;
mod keywords;

use crate::device::{Device, Module, Other, Slot};
use crate::general::read_rate;
use crate::lexer::HEADER;
use crate::parameter::{Parameter, PrmArea, PrmContent, PrmItem, PrmText};
use crate::problem::{Fault, Problem};
use crate::statement::Statement;
use block::Block;
use check::Lines;
use diagnosis::OpenArea;

/// The last octet of user parameters, profibus-wire 2.4.
const MAX_OFFSET: u8 = 236;

/// The greatest number of modules, which bounds the work for one configuration. chosen: ten times the largest known files.
pub(crate) const MAX_MODULES: usize = 10_000;

/// The greatest number of parameters and constants of the station or of a module. chosen: more than one for each bit of the longest user
/// parameters, which have 1896.
pub(crate) const MAX_ITEMS: usize = 2_048;

/// The last number of a slot, profibus-wire 3.
pub(crate) const MAX_SLOT: u32 = 254;

type Outcome = Result<(), Fault>;

/// Takes statements one by one.
#[derive(Default)]
pub(crate) struct Reader {
    device: Device,
    block: Block,
    area: Option<OpenArea>,
    /// The line of `#Profibus_DP`, where the section starts.
    header: Option<usize>,
    /// The line with the next `#`, where the section ends.
    end: Option<usize>,
    before_header: Option<usize>,
    /// The lines of Ident_Number and User_Prm_Data.
    lines: Lines,
    problems: Vec<Problem>,
    /// There are more modules than are read.
    has_too_many: bool,
}

impl Reader {
    pub(crate) fn statement(&mut self, statement: &Statement<'_>) {
        if !self.is_in_section(statement) {
            return;
        }
        self.look_at_keyword(statement);
        if let Err(fault) = self.interpret(statement) {
            let found = if statement.values.is_empty() || fault == Fault::UnknownKeyword {
                statement.spelled.to_owned()
            } else {
                format!("{} {}", statement.spelled, statement.values.brief()).trim().to_owned()
            };
            self.problem(statement, fault, &found);
            self.keep(statement);
        }
    }

    /// Whether the statement belongs to the section of PROFIBUS DP. The lines before it are read until its header comes, because a
    /// file may have none.
    fn is_in_section(&mut self, statement: &Statement<'_>) -> bool {
        let is_header = statement.keyword == HEADER;
        match self.header {
            None if is_header => {
                let (header, before_header) = (Some(statement.line), self.before_header);
                *self = Self { header, before_header, ..Self::default() };
            }
            None => {
                self.before_header.get_or_insert(statement.line);
            }
            Some(_) if self.end.is_none() && !is_header && statement.keyword.starts_with('#') => {
                self.problem(statement, Fault::SectionEnd, statement.spelled);
                self.end = Some(statement.line);
            }
            Some(_) => {}
        }
        self.end.is_none()
    }

    /// The model, and all problems by line.
    pub(crate) fn finish(mut self, lexical: Vec<Problem>) -> (Device, Vec<Problem>) {
        self.close_block(None);
        check::check(&mut self.device, self.lines, &mut self.problems);
        let (start, end) = (self.header.unwrap_or(0), self.end.unwrap_or(usize::MAX));
        self.problems.extend(lexical.into_iter().filter(|problem| (start..end).contains(&problem.line)));
        match (self.header, self.before_header) {
            (None, _) => self.problems.push(Problem::new(1, Fault::NoHeader, "")),
            (Some(_), Some(line)) => self.problems.push(Problem::new(line, Fault::TextBeforeHeader, "")),
            (Some(_), None) => {}
        }
        self.problems.sort_by_key(|problem| problem.line);
        (self.device, self.problems)
    }

    fn problem(&mut self, statement: &Statement<'_>, fault: Fault, found: &str) {
        self.problems.push(Problem::new(statement.line, fault, found));
    }

    fn keep(&mut self, statement: &Statement<'_>) {
        let text = statement.whole.to_owned();
        let other = Other { line: statement.line, keyword: statement.spelled.to_owned(), text };
        match &mut self.block {
            Block::Module(module) => module.others.push(other),
            _ => self.device.others.push(other),
        }
    }

    fn look_at_keyword(&mut self, statement: &Statement<'_>) {
        if statement.spelled.contains([' ', '\t']) {
            self.problem(statement, Fault::BlankInKeyword, statement.spelled);
        } else if let Some(right) = keywords::known(&statement.keyword).filter(|right| *right != statement.spelled) {
            let fault = if statement.keyword == HEADER { Fault::HeaderCapitals } else { Fault::Capitals };
            self.problem(statement, fault, &format!("{} for {right}", statement.spelled));
        }
        if statement.values.has_capital_x() {
            self.problem(statement, Fault::CapitalX, &statement.values.brief());
        }
    }

    fn interpret(&mut self, statement: &Statement<'_>) -> Outcome {
        let keyword = statement.keyword.as_str();
        match keyword {
            HEADER => self.read_header(statement),
            "" => self.bare(statement),
            "module" | "prmtext" | "extuserprmdata" | "slotdefinition" | "unitdiagtype" => self.open_block(statement),
            "endmodule" | "endprmtext" | "endextuserprmdata" | "endslotdefinition" | "endunitdiagtype" => {
                self.end_block(statement)
            }
            "text" => self.prm_text(statement),
            "slot" => self.slot(statement),
            "prm_text_ref" | "changeable" | "visible" => self.attribute(statement),
            _ if keyword.starts_with("bit") && !keyword.contains('_') => self.data_type(statement),
            _ if keyword.starts_with("unsigned") || keyword.starts_with("signed") => self.data_type(statement),
            _ if keyword.contains("ext_user_prm_data_") || keyword.ends_with("ext_module_prm_data_len") => {
                self.prm(statement)
            }
            "value" | "x_value" | "value_help" | "x_value_help" => self.diagnosis(statement),
            _ if keyword.contains("_diag_") || keyword.starts_with("channel_diag") => self.diagnosis(statement),
            _ => self.single(statement),
        }
    }

    fn read_header(&mut self, statement: &Statement<'_>) -> Outcome {
        if !statement.values.is_empty() || !statement.comment.is_empty() {
            self.problem(statement, Fault::TextBehindHeader, "");
        }
        Ok(())
    }

    /// A line of values alone: the number of a module.
    fn bare(&mut self, statement: &Statement<'_>) -> Outcome {
        let Block::Module(module) = &mut self.block else { return Err(Fault::NoKeyword) };
        if module.numbered {
            return Err(Fault::NoKeyword);
        }
        // A module reference is an Unsigned16.
        module.number = statement.values.number::<u16>()?.into();
        module.numbered = true;
        Ok(())
    }

    fn prm_text(&mut self, statement: &Statement<'_>) -> Outcome {
        let Block::Texts(texts) = &mut self.block else { return Err(Fault::MisplacedKeyword) };
        let value = statement.argument.first().ok_or(Fault::BadValue)?;
        let value = i64::try_from(*value).map_err(|_| Fault::OutOfRange)?;
        let is_repeated = texts.texts.insert(value, statement.values.text()).is_some();
        if is_repeated {
            self.problem(statement, Fault::Repeated, statement.spelled);
        }
        Ok(())
    }

    fn slot(&mut self, statement: &Statement<'_>) -> Outcome {
        if !matches!(self.block, Block::Slots) {
            return Err(Fault::MisplacedKeyword);
        }
        let number = statement.index()?;
        if number > MAX_SLOT {
            return Err(Fault::OutOfRange);
        }
        let mut values = statement.values;
        let name = values.quoted().ok_or(Fault::BadValue)?.trim().to_owned();
        let default = values.unsigned().and_then(|value| u32::try_from(value).ok()).ok_or(Fault::BadValue)?;
        let small = |value: i64| u32::try_from(value).map_err(|_| Fault::OutOfRange);
        let allowed = values.intervals()?.into_iter().map(|(low, high)| Ok((small(low)?, small(high)?)));
        let slot = Slot { number, name, default, allowed: allowed.collect::<Result<_, _>>()?, line: statement.line };
        if self.device.slots.insert(number, slot).is_some() {
            self.problem(statement, Fault::DefinitionTwice, statement.spelled);
        }
        Ok(())
    }

    /// Ext_User_Prm_Data_Const, Ext_User_Prm_Data_Ref, Ext_Module_Prm_Data_Len and those for PROFIsafe.
    fn prm(&mut self, statement: &Statement<'_>) -> Outcome {
        let keyword = statement.keyword.as_str();
        let safe = keyword.strip_prefix("f_");
        let content = match safe.unwrap_or(keyword) {
            "ext_module_prm_data_len" => None,
            "ext_user_prm_data_const" => Some(PrmContent::Const(self.octets(statement)?)),
            "ext_user_prm_data_ref" => Some(PrmContent::Ref(statement.values.number()?)),
            _ => return Err(Fault::UnknownKeyword),
        };
        let area = self.prm_area(safe.is_some())?;
        let Some(content) = content else {
            area.length = Some(statement.values.number()?);
            return Ok(());
        };
        let offset =
            u8::try_from(statement.index()?).ok().filter(|offset| *offset <= MAX_OFFSET).ok_or(Fault::OutOfRange)?;
        if area.items.len() >= MAX_ITEMS {
            return Err(Fault::TooMany);
        }
        area.items.push(PrmItem { offset, content, line: statement.line });
        Ok(())
    }

    /// The octets of a list. Those in front of a wrong value count, if there are any.
    fn octets(&mut self, statement: &Statement<'_>) -> Result<Vec<u8>, Fault> {
        let (octets, fault) = statement.values.octets();
        match fault {
            Some(fault @ (Fault::BadValue | Fault::OutOfRange)) if octets.is_empty() => return Err(fault),
            Some(fault) => self.problem(statement, fault.in_list(), &statement.values.brief()),
            None => {}
        }
        Ok(octets)
    }

    fn prm_area(&mut self, safe: bool) -> Result<&mut PrmArea, Fault> {
        match (&mut self.block, safe) {
            (Block::Module(module), true) => Ok(&mut module.safety),
            (Block::Module(module), false) => Ok(&mut module.prm),
            (_, true) => Err(Fault::MisplacedKeyword),
            (_, false) => Ok(&mut self.device.prm),
        }
    }

    /// A keyword with one value, of the module or of the device.
    fn single(&mut self, statement: &Statement<'_>) -> Outcome {
        let keyword = statement.keyword.as_str();
        if let Block::Module(module) = &mut self.block {
            match keyword {
                "preset" => {
                    module.preset = statement.values.number::<u64>()? != 0;
                    return Ok(());
                }
                "info_text" => {
                    module.info = Some(statement.values.text());
                    return Ok(());
                }
                // Modules have them too; here the device's stay.
                "ordernumber" | "ident_maintenance_supp" => {
                    self.keep(statement);
                    return Ok(());
                }
                _ => {}
            }
            if let Some((alarms, alarm)) = module.alarms.of_keyword(keyword) {
                match statement.values.number::<u64>()? {
                    0 => alarms.remove(&alarm),
                    _ => alarms.insert(alarm),
                };
                return Ok(());
            }
        }
        let read = match keyword {
            "ident_number" => {
                self.lines.ident = Some(statement.line);
                Some(
                    statement
                        .values
                        .number::<u16>()
                        .map(|ident| self.device.general.ident_number.replace(ident.into()).is_some()),
                )
            }
            "user_prm_data" => {
                self.lines.user_prm = Some(statement.line);
                Some(self.octets(statement).map(|octets| self.device.user_prm_data.replace(octets).is_some()))
            }
            _ => read_rate(&mut self.device.rates, statement).or_else(|| self.device.general.read(statement)),
        };
        match read {
            Some(Ok(true)) => self.problem(statement, Fault::Repeated, statement.spelled),
            Some(Ok(false)) => {}
            Some(Err(fault)) => return Err(fault),
            None if keywords::is_kept(keyword) => self.keep(statement),
            None => return Err(Fault::UnknownKeyword),
        }
        Ok(())
    }
}
