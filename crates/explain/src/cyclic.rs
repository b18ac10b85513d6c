//! The contents of Data_Exchange: pressures, states and the parameter channel.

use super::cycle::{Answer, Request};
use super::gsd::Described;
use super::names::DeviceTables;
use super::note::{Kind, Notes, octets};
use profivac_client::cyclic::{
    Cause, ChannelValue, CyclicSlave, ReportedChannels, TtrReading, exception_texts, extension_texts, mantissa_number,
};
use profivac_client::records::RefusalCodes;
use profivac_client::values::cyclic_text;
use profivac_devices::model::{Codes, Configuration, DataType, Field, TaskKind, Telegram};
use profivac_devices::profile::{ExceptionStatus, StatusExtension};
use profivac_sim::describe::Hex;
use profivac_wire::control::Status;

/// AK of an answer in the parameter channel (errata-bpg-bcg-tpg 24).
const NOTHING: u8 = 0;
const WORD: u8 = 1;
const REFUSED: u8 = 7;
const BYTE: u8 = 11;

/// The cyclic data of one slave.
#[derive(Clone, Debug, Default)]
pub(super) struct Cyclic {
    configuration: Option<&'static Configuration>,
    exchanging: bool,
    refusing: bool,
    /// The states in the last note about the inputs; pressures change too often for notes.
    reported: String,
    /// The last task in the parameter channel of the outputs.
    task: [u8; 8],
    /// Whether a note about the answer to `task` exists.
    is_answered: bool,
}

impl Cyclic {
    /// Starts again with a configuration; `None` if the tables do not have it.
    pub(super) fn configure(&mut self, configuration: Option<&'static Configuration>) {
        *self = Self { configuration, ..Self::default() };
    }

    /// Records the end of data exchange.
    pub(super) fn end(&mut self) {
        self.exchanging = false;
        self.reported.clear();
    }

    /// Records a refused Data_Exchange. Returns whether it is the first one in a row.
    pub(super) fn refuse(&mut self) -> bool {
        let is_first = !self.refusing;
        (self.refusing, self.exchanging) = (true, false);
        is_first
    }

    /// Whether the next exchange is the first one.
    pub(super) const fn begins(&self) -> bool {
        !self.exchanging
    }

    /// The meaning of outputs.
    pub(super) fn outputs(&mut self, tables: &DeviceTables, described: &Described, du: &[u8]) -> String {
        let Some(telegram) = self.configuration.and_then(|configuration| configuration.outputs) else {
            return described.outputs(du);
        };
        let mut texts = Vec::new();
        for (field, octets) in fields(telegram, du) {
            match (field, <[u8; 8]>::try_from(octets)) {
                (Field::ParameterChannel, Ok(channel)) => {
                    if channel != self.task {
                        (self.task, self.is_answered) = (channel, false);
                    }
                    texts.extend(task(tables, channel).map(|(text, _)| text));
                }
                (Field::Ignored(_), _) => {}
                _ => texts.push(format!("{} {}", field.name(), Hex(octets))),
            }
        }
        texts.extend(self.named(tables, du, true).into_iter().map(|(text, _)| text));
        texts.join(", ")
    }

    /// The values of one direction that the tables name, and whether each is a state and no quantity.
    fn named(&self, tables: &DeviceTables, du: &[u8], is_output: bool) -> Vec<(String, bool)> {
        let (Some(model), Some(configuration)) = (tables.model, self.configuration) else { return Vec::new() };
        let values = model.values_of(configuration, is_output);
        let named = values.filter_map(|value| {
            let is_state = value.data_type == DataType::Boolean || matches!(value.codes, Codes::Names(_));
            Some((format!("{} {}", value.name, cyclic_text(value, du)?), is_state))
        });
        named.collect()
    }

    /// The meaning of inputs. Adds notes about changed states.
    pub(super) fn inputs(
        &mut self,
        address: u8,
        (tables, described): (&DeviceTables, &Described),
        request: &Request,
        answer: Answer<'_>,
        has_started: bool,
        notes: &mut Notes<'_>,
    ) -> String {
        let telegram = self.configuration.and_then(|configuration| configuration.inputs);
        let (mut all, mut states) = (Vec::new(), Vec::new());
        let selected = telegram.and_then(|telegram| octet_of(telegram, answer.du, Field::PvSelector));
        let values = self.values(tables, answer.du);
        let named = self.named(tables, answer.du, false);
        for (field, octets) in telegram.into_iter().flat_map(|telegram| fields(telegram, answer.du)) {
            if field == Field::ParameterChannel {
                all.extend(self.channel(address, tables, octets, notes));
                continue;
            }
            if matches!(field, Field::Ignored(_)) && !named.is_empty() {
                continue;
            }
            let mut text = field_text(field, octets, tables, selected);
            if is_below_one_unit(field, &values) {
                text += " (less than one unit)";
            }
            if !is_measured(field) && !text.is_empty() {
                states.push(text.clone());
            }
            all.push(text);
        }
        for (text, is_state) in named {
            states.extend(is_state.then(|| text.clone()));
            all.push(text);
        }
        all.retain(|text| !text.is_empty());
        let all = if telegram.is_some() { all.join(", ") } else { described.inputs(answer.du) };
        let beginning = if has_started { "" } else { "; its start-up was not received" };
        self.report(address, request, answer, [&states.join(", "), &all, beginning], notes);
        all
    }

    /// The pressures of the inputs as a master decodes them. Empty without a known device or unit.
    fn values(&self, tables: &DeviceTables, du: &[u8]) -> Vec<ChannelValue> {
        let (Some(model), Some(unit), Some(configuration)) = (tables.model, tables.unit, self.configuration) else {
            return Vec::new();
        };
        let channels = ReportedChannels::default();
        CyclicSlave { address: 0, model, configuration, unit, channels }.decode_inputs(du).values
    }

    fn report(
        &mut self,
        address: u8,
        request: &Request,
        answer: Answer<'_>,
        [states, all, beginning]: [&str; 3],
        notes: &mut Notes<'_>,
    ) {
        let contents = if all.is_empty() { String::new() } else { format!(": {all}") };
        if self.begins() {
            let octets = format!("{} out, {} in", octets(request.du.len()), answer.du.len());
            notes.about(
                address,
                Kind::Exchange,
                format!("exchanges data with master {}, {octets}{contents}{beginning}", request.master),
            );
        } else if self.reported != states {
            notes.about(address, Kind::Exchange, format!("its inputs have changed{contents}"));
        }
        if answer.status == Status::DataHigh {
            notes.about(address, Kind::Diagnosis, "asks its master to fetch its diagnosis (DH)");
        }
        (self.exchanging, self.refusing, self.reported) = (true, false, states.to_owned());
    }

    /// The meaning of the parameter channel of the inputs; `None` without an answer to the last task.
    fn channel(&mut self, address: u8, tables: &DeviceTables, octets: &[u8], notes: &mut Notes<'_>) -> Option<String> {
        let (task, reads) = task(tables, self.task)?;
        let [pke, slot, index, _, value @ ..] = octets else { return None };
        let [_, task_slot, task_index, ..] = self.task;
        // An answer with other numbers belongs to the task before.
        let ak = Some(pke >> 4).filter(|ak| *ak != NOTHING && (*slot, *index) == (task_slot, task_index))?;
        let result = match (ak, tables.model, value) {
            (REFUSED, Some(_), [.., code]) => format!(" is refused: {}", RefusalCodes { code_1: None, code: *code }),
            (REFUSED, None, [.., code]) => format!(" is refused: code {code}"),
            _ if !reads => " is done".to_owned(),
            (BYTE, _, [.., low]) => format!(" = {}", tables.value(*slot, *index, &[*low])),
            (WORD, _, [.., high, low]) => format!(" = {}", tables.value(*slot, *index, &[*high, *low])),
            _ => format!(" = {}", tables.value(*slot, *index, value)),
        };
        let text = format!("parameter channel: {task}{result}");
        if !self.is_answered {
            let kind = if ak == REFUSED { Kind::Refused } else { Kind::Parameter };
            notes.about(address, kind, text.clone());
        }
        self.is_answered = true;
        Some(text)
    }
}

/// The meaning of a task of the parameter channel, and whether the task reads.
fn task(tables: &DeviceTables, [pke, slot, index, _, value @ ..]: [u8; 8]) -> Option<(String, bool)> {
    let ak = Some(pke >> 4).filter(|ak| *ak != NOTHING)?;
    let name = tables.name(slot, index);
    Some(match tables.model.and_then(|model| model.channel_rules.task(ak)) {
        Some(TaskKind::Read) => (format!("read {name}"), true),
        Some(TaskKind::Write(lengths)) => {
            let length = lengths.iter().copied().max().unwrap_or(4).min(4);
            let octets = value.get(4usize.saturating_sub(length)..).unwrap_or_default();
            (format!("write {name} = {}", tables.value(slot, index, octets)), false)
        }
        None => (format!("task {ak} for {name}"), true),
    })
}

fn fields<'a>(telegram: &'static Telegram, du: &'a [u8]) -> impl Iterator<Item = (Field, &'a [u8])> {
    telegram.layout().filter_map(move |(start, field)| Some((field, du.get(start..)?.get(..field.octets())?)))
}

fn octet_of(telegram: &'static Telegram, du: &[u8], wanted: Field) -> Option<u8> {
    fields(telegram, du).find(|(field, _)| *field == wanted).and_then(|(_, octets)| octets.first().copied())
}

/// Whether a field is a measured value, which changes all the time.
const fn is_measured(field: Field) -> bool {
    matches!(field, Field::ProcessValue(_) | Field::ChannelValue(..) | Field::ChannelMantissa(_) | Field::TtrValue)
}

/// Whether the integer of this field is a pressure below one unit. 0 of a gauge that does not measure is none.
fn is_below_one_unit(field: Field, values: &[ChannelValue]) -> bool {
    let value = match field {
        Field::ProcessValue(_) => values.first(),
        Field::ChannelValue(channel, _) => values.iter().find(|value| value.instance == channel),
        _ => None,
    };
    value.is_some_and(|value| value.cause == Some(Cause::BelowOneUnit))
}

fn field_text(field: Field, octets: &[u8], tables: &DeviceTables, selected: Option<u8>) -> String {
    let [first, ..] = octets else { return String::new() };
    match field {
        Field::ProcessValue(_) => {
            let part = selected.map(|instance| part(tables, instance)).unwrap_or_default();
            format!("{part}{}", tables.pressure(octets).unwrap_or_default())
        }
        Field::ChannelValue(channel, _) => format!("channel {channel} {}", tables.pressure(octets).unwrap_or_default()),
        Field::ExceptionStatus => exception_texts(ExceptionStatus::from_bits_retain(*first)).join(", "),
        Field::StatusExtension => extension_texts(StatusExtension::from_bits_retain(*first)).join(", "),
        Field::PvSelector | Field::ParameterChannel => String::new(),
        Field::MeasurementStatus(channel) => format!("channel {channel} status {}", Hex(octets)),
        Field::ChannelMantissa(channel) => {
            let unit = tables.unit.map_or("(unit unknown)", |unit| unit.name);
            let number = mantissa_number(octets).map_or_else(String::new, |number| format!("{number:.2e} {unit}"));
            format!("channel {channel} {number} (the format of the mantissa is assumed)")
        }
        Field::TtrValue => TtrReading::decode(octets).map_or_else(String::new, |reading| {
            let error = if reading.has_error { ", error" } else { "" };
            format!("{:.2e} Pa{error}", reading.pa)
        }),
        _ if octets.iter().all(|octet| *octet == 0) => String::new(),
        _ => format!("{} {}", field.name(), Hex(octets)),
    }
}

/// The name of the part whose value the slave sends, followed by a space.
fn part(tables: &DeviceTables, instance: u8) -> String {
    let locations = tables.model.into_iter().flat_map(|model| model.blocks).flat_map(|placed| placed.locations);
    let name =
        locations.into_iter().find(|address| address.instance == instance && instance > 0).map(|address| address.name);
    name.map(|name| format!("{name} ")).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_devices::bcg450::table::MODEL;
    use profivac_devices::model::{Code, CyclicValue, Gsd, Model, NumberType, Quantity, code, telegram};

    #[test]
    fn values_of_a_device_file_have_their_names_and_codes_are_states() {
        static INPUTS: Telegram = telegram(1, &[Field::Ignored(3)]);
        static CONFIGURATION: Configuration = Configuration { outputs: None, inputs: Some(&INPUTS), octets: &[0x12] };
        static NAMES: [Code; 1] = [code(3, "at speed")];
        static VALUES: [CyclicValue; 2] = [
            CyclicValue {
                name: "speed",
                is_output: false,
                telegram: 1,
                octet: 0,
                bit: 0,
                data_type: DataType::Uint16,
                codes: Codes::Quantity(Quantity { unit: "Hz", factor: 0.5, range: None }),
            },
            CyclicValue {
                name: "state",
                is_output: false,
                telegram: 1,
                octet: 2,
                bit: 0,
                data_type: DataType::Uint8,
                codes: Codes::Names(&NAMES),
            },
        ];
        let gsd = Gsd { ..MODEL.gsd };
        let model: &'static Model = Box::leak(Box::new(Model { values: &VALUES, gsd, ..MODEL }));
        let tables = DeviceTables { model: Some(model), unit: None, instance: None };
        let cyclic = Cyclic { configuration: Some(&CONFIGURATION), ..Cyclic::default() };
        let expected = [("speed 1000 Hz".to_owned(), false), ("state at speed".to_owned(), true)];
        assert_eq!(cyclic.named(&tables, &[0x07, 0xD0, 3], false), expected);
        assert!(cyclic.named(&tables, &[0x07, 0xD0, 3], true).is_empty(), "of the outputs");
    }

    /// In IDLE a gauge shows its Safe Value.
    #[test]
    fn only_the_0_of_a_gauge_that_measures_is_less_than_one_unit() {
        let cyclic = Cyclic { configuration: MODEL.configurations.get(4), ..Cyclic::default() };
        let tables = DeviceTables { model: Some(&MODEL), unit: MODEL.unit_named("mbar"), instance: None };
        let is_below = |tables: &DeviceTables, [exception, status, part, word]: [u8; 4]| {
            let values = cyclic.values(tables, &[&[0; 8][..], &[exception, status, part, 0, word]].concat());
            is_below_one_unit(Field::ProcessValue(NumberType::Integer), &values)
        };
        assert!(is_below(&tables, [0x80, 0, 1, 0]));
        assert!(!is_below(&tables, [0x80, 0, 1, 1]));
        assert!(!is_below(&tables, [0xA0, 1, 2, 0]), "invalid");
        assert!(!is_below(&tables, [0x80, 0, 0, 0]), "no part");
        assert!(!is_below(&tables, [0, 0, 0, 0]), "no gauge has filled the inputs");
        assert!(!is_below(&DeviceTables { unit: MODEL.unit_named("COUNTS"), ..tables }, [0x80, 0, 1, 0]));
        assert!(!is_below(&DeviceTables::default(), [0x80, 0, 1, 0]));
    }
}
