//! The tables of a device as a device file.

use super::check::{UNITS, VERSION};
use super::intern::{built_in_like, description, left_out};
use super::toml_file::FORMAT;
use super::words::{
    ACCESS_ERRORS, BEHAVIOURS, CLIPPINGS, PRINCIPLES, ROLES, STORAGES, condition_words, field_words, pressure_words,
    word_of,
};
use profivac_client::values::hex;
use profivac_devices::catalog::MODELS;
use profivac_devices::described::BlockBehaviour;
use profivac_devices::model::{
    Code, Codes, Configuration, Counts, CyclicValue, DataType, Model, PartSpec, PlacedBlock, Quantity, Role, Row,
    Scale, TaskKind, Telegram, Unit,
};
use std::collections::BTreeMap;

/// The device file of a model. Read again it gives the same tables, but for the name, which belongs to profivac's own device.
///
/// ```
/// use profivac_device_file::{DeviceFile, show};
/// use profivac_devices::catalog::model_named;
///
/// let bcg450 = model_named("bcg450").ok_or("no such model")?;
/// let text = show(bcg450).replace("name = \"bcg450\"", "name = \"mine\"");
/// let mine = DeviceFile::parse(&text)?.model()?;
/// assert_eq!(format!("{:?}", mine.blocks), format!("{:?}", bcg450.blocks));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn show(model: &Model) -> String {
    let tables = CodeNames::of(model);
    let mut file = File::default();
    file.head(model);
    file.lists(model);
    file.values(model, &tables);
    file.sections(model);
    let behaviours = description(model).map_or(&[][..], |description| description.blocks);
    for (number, placed) in model.blocks.iter().enumerate() {
        file.block(placed, behaviours.get(number).copied().flatten(), &tables);
    }
    tables.tables.iter().for_each(|(name, codes)| file.codes(name, codes));
    file.text
}

/// The built-in device whose behaviour a device has: of the twelve, each its own.
fn behaviour(model: &Model) -> Option<&'static Model> {
    MODELS.into_iter().find(|known| *known == model).or_else(|| built_in_like(model))
}

/// A text in quotation marks.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' => quoted.push_str("\\\""),
            '\\' => quoted.push_str("\\\\"),
            control if control.is_control() => quoted.push_str(&format!("\\u{:04X}", u32::from(control))),
            letter => quoted.push(letter),
        }
    }
    quoted.push('"');
    quoted
}

/// A code: in hexadecimal where the manuals write it so.
fn code_number(code: u16) -> String {
    if code > 0x0FFF { format!("0x{code:04X}") } else { code.to_string() }
}

fn list<T: ToString>(values: impl IntoIterator<Item = T>) -> String {
    format!("[{}]", values.into_iter().map(|value| value.to_string()).collect::<Vec<_>>().join(", "))
}

#[derive(Default)]
struct File {
    text: String,
}

impl File {
    fn line(&mut self, line: &str) {
        self.text.push_str(line.trim_end());
        self.text.push('\n');
    }

    fn key(&mut self, key: &str, value: impl std::fmt::Display) {
        self.line(&format!("{key} = {value}"));
    }

    /// A list of tables, one on each line, with their keys below each other.
    fn list(&mut self, key: &str, entries: &[Vec<String>]) {
        if entries.is_empty() {
            return self.key(key, "[]");
        }
        self.line(&format!("{key} = ["));
        let columns = entries.iter().map(Vec::len).max().unwrap_or_default();
        let width = |column: usize| {
            let cells = entries.iter().filter(|cells| cells.len() > column.saturating_add(1));
            cells.filter_map(|cells| cells.get(column)).map(|cell| cell.chars().count()).max().unwrap_or_default()
        };
        let widths: Vec<_> = (0..columns).map(width).collect();
        for cells in entries {
            let last = cells.len().saturating_sub(1);
            let padded = cells.iter().zip(&widths).enumerate().map(|(column, (cell, width))| {
                let cell = if column == last { cell.clone() } else { format!("{cell},") };
                let width = if column == last { 0 } else { width.saturating_add(1) };
                format!("{cell:<width$}")
            });
            self.line(&format!("  {{ {} }},", padded.collect::<Vec<_>>().join(" ")));
        }
        self.line("]");
    }

    fn head(&mut self, model: &Model) {
        self.line(&format!("# {} as a device file. docs/device-files.md explains the keys.", model.title));
        self.key("format", FORMAT);
        self.key("name", quoted(model.name));
        self.key("title", quoted(model.title));
        if let Some(behaviour) = behaviour(model) {
            self.key("behaviour", quoted(behaviour.name));
        }
        if !left_out(model).is_empty() {
            self.key("left-out", quoted(left_out(model)));
        }
        self.key("vendor", quoted(model.vendor));
        self.key("manual", quoted(model.manual));
        if !model.errata.is_empty() {
            self.key("errata", quoted(model.errata));
        }
        self.key("ident", format!("0x{:04X}", model.ident));
        self.key("max-integer", model.max_integer);
        self.key("free-bits", format!("0x{:02X}", model.dpv1_status));
        self.key("default-configuration", quoted(&hex(model.default_configuration.octets)));
    }

    fn lists(&mut self, model: &Model) {
        self.list("configurations", &model.configurations.iter().map(configuration).collect::<Vec<_>>());
        self.list("units", &model.units.iter().map(unit).collect::<Vec<_>>());
        let user_prm = |prm: &profivac_devices::model::UserPrm| {
            vec![format!("name = {}", quoted(prm.name)), format!("octets = {}", quoted(&hex(prm.octets)))]
        };
        self.list("user-parameters", &model.user_prm.iter().map(user_prm).collect::<Vec<_>>());
        self.list("parts", &model.parts.iter().copied().map(part).collect::<Vec<_>>());
        let faults = model.faults.faults.iter().zip(model.faults.effects);
        let fault = |(fault, effect): (&profivac_devices::model::Fault, &&str)| {
            vec![format!("name = {}", quoted(fault.name())), format!("effect = {}", quoted(effect))]
        };
        self.list("faults", &faults.map(fault).collect::<Vec<_>>());
    }

    /// The values of the cyclic data that are no pressures.
    fn values(&mut self, model: &Model, tables: &CodeNames) {
        if !model.values.is_empty() {
            self.list("values", &model.values.iter().map(|value| tables.value(value)).collect::<Vec<_>>());
        }
    }

    fn section(&mut self, heading: &str) {
        self.line("");
        self.line(heading);
    }

    fn sections(&mut self, model: &Model) {
        self.section("[services]");
        let features = &model.features;
        for (key, has) in
            [("sync", features.sync), ("freeze", features.freeze), ("dpv1", features.dpv1), ("ms1", features.ms1)]
        {
            self.key(key, has);
        }
        self.telegrams("[outputs]", model.configurations.iter().filter_map(|one| one.outputs));
        self.telegrams("[inputs]", model.configurations.iter().filter_map(|one| one.inputs));
        self.channel(model);
        self.alarms(model);
        self.section("[gsd]");
        self.key("revision", model.gsd.revision);
        self.key("hardware", quoted(model.gsd.hardware));
        self.key("software", quoted(model.gsd.software));
        self.key("max-diagnosis-octets", model.gsd.max_diag_octets);
        self.key("set-slave-address", model.gsd.set_slave_add);
    }

    fn telegrams(&mut self, heading: &str, telegrams: impl Iterator<Item = &'static Telegram>) {
        self.section(heading);
        let by_number: BTreeMap<u8, _> = telegrams.map(|telegram| (telegram.number, telegram.fields)).collect();
        for (number, fields) in by_number {
            let fields = list(fields.iter().map(|field| quoted(&field_words(*field))));
            self.key(&number.to_string(), fields);
        }
    }

    fn channel(&mut self, model: &Model) {
        let rules = model.channel_rules;
        if rules.tasks.is_empty() {
            return;
        }
        self.section("[parameter-channel]");
        self.key("idle-between-tasks", rules.needs_idle_between);
        let task = |(ak, kind): &(u8, TaskKind)| match kind {
            TaskKind::Read => vec![format!("ak = {ak}")],
            TaskKind::Write(lengths) => vec![format!("ak = {ak}"), format!("write = {}", list(*lengths))],
        };
        self.list("tasks", &rules.tasks.iter().map(task).collect::<Vec<_>>());
        let error = |(error, code): &(_, u8)| {
            vec![format!("error = {}", quoted(word_of(&ACCESS_ERRORS, error))), format!("code = {code}")]
        };
        if !rules.error_codes.is_empty() {
            self.list("errors", &rules.error_codes.iter().map(error).collect::<Vec<_>>());
        }
    }

    fn alarms(&mut self, model: &Model) {
        self.section("[alarms]");
        let alarms = &model.alarms;
        self.key("instances", list(alarms.instances));
        let sensor = |bit: &profivac_devices::model::AlarmBit| {
            vec![
                format!("octet = {}", bit.octet),
                format!("mask = 0x{:02X}", bit.mask),
                format!("name = {}", quoted(bit.name)),
            ]
        };
        self.list("sensor", &alarms.sensor.iter().map(sensor).collect::<Vec<_>>());
        let manufacturer =
            |(mask, name): &(u8, &str)| vec![format!("mask = 0x{mask:02X}"), format!("name = {}", quoted(name))];
        self.list("manufacturer", &alarms.manufacturer.iter().map(manufacturer).collect::<Vec<_>>());
    }

    fn block(&mut self, placed: &PlacedBlock, behaviour: Option<BlockBehaviour>, tables: &CodeNames) {
        let PlacedBlock { block, locations } = placed;
        self.section("[[block]]");
        self.key("name", quoted(block.name));
        if let Some(number) = block.block_type {
            self.key("type", number);
        }
        if let Some(behaviour) = behaviour {
            self.key("behaviour", quoted(word_of(&BEHAVIOURS, &behaviour)));
        }
        let location = |at: &profivac_devices::model::Location| {
            let slot = format!("slot = {}", at.slot);
            let instance = (at.instance > 0).then(|| format!("instance = {}", at.instance));
            std::iter::once(slot).chain(instance).chain([format!("name = {}", quoted(at.name))]).collect()
        };
        self.list("at", &locations.iter().map(location).collect::<Vec<_>>());
        self.list("parameters", &block.rows.iter().map(|row| tables.row(row)).collect::<Vec<_>>());
    }

    fn codes(&mut self, name: &str, codes: &Codes) {
        self.section(&format!("[codes.{name}]"));
        match codes {
            Codes::Names(codes) => self.list("names", &code_entries(codes)),
            Codes::Commands(codes) => self.list("commands", &code_entries(codes)),
            Codes::BitCommands(codes) => self.list("bit-commands", &code_entries(codes)),
            Codes::Bits(bits) => {
                let bit = |(bit, name): &(u8, &str)| vec![format!("bit = {bit}"), format!("name = {}", quoted(name))];
                self.list("bits", &bits.iter().map(bit).collect::<Vec<_>>());
            }
            Codes::Plain
            | Codes::Range(..)
            | Codes::PerMille(..)
            | Codes::Quantity(_)
            | Codes::Units
            | Codes::Version => {}
        }
    }
}

fn configuration(one: &Configuration) -> Vec<String> {
    let outputs = one.outputs.map(|telegram| format!("outputs = {}", telegram.number));
    let inputs = one.inputs.map(|telegram| format!("inputs = {}", telegram.number));
    let octets = format!("octets = {}", quoted(&hex(one.octets)));
    outputs.into_iter().chain(inputs).chain([octets]).collect()
}

fn unit(unit: &Unit) -> Vec<String> {
    let mut cells = vec![format!("code = {}", code_number(unit.code)), format!("name = {}", quoted(unit.name))];
    if unit.alias != unit.name {
        cells.push(format!("alias = {}", quoted(unit.alias)));
    }
    if let Scale::PerMbar(factor) = unit.scale {
        cells.push(format!("per-mbar = {factor:?}"));
    }
    cells
}

fn part(spec: &PartSpec) -> Vec<String> {
    let pressure = |pa: f64| quoted(&pressure_words(pa));
    let limits = spec.limits;
    let mut cells = vec![
        format!("instance = {}", spec.part.instance),
        format!("principle = {}", quoted(word_of(&PRINCIPLES, &spec.part.principle))),
        format!("underrange = {}", pressure(limits.under_pa)),
        format!("overrange = {}", pressure(limits.over_pa)),
        format!("full-scale = {}", pressure(limits.full_scale_pa)),
        format!("clips = {}", quoted(word_of(&CLIPPINGS, &spec.clipping))),
    ];
    match spec.counts {
        Counts::Log { per_decade, at_1_mbar } => {
            cells.push(format!("counts = {{ per-decade = {per_decade:?}, at-1-mbar = {at_1_mbar:?} }}"));
        }
        Counts::Linear { per_mbar } => cells.push(format!("counts = {{ per-mbar = {per_mbar:?} }}")),
        // Of a trip point, not of a part.
        Counts::Distance { .. } => {}
    }
    cells
}

fn code_entries(codes: &[Code]) -> Vec<Vec<String>> {
    let entry = |code: &Code| {
        let mut cells = vec![format!("code = {}", code_number(code.number)), format!("name = {}", quoted(code.name))];
        if !code.preconditions.is_empty() {
            let needs = code.preconditions.iter().map(|condition| quoted(&condition_words(*condition)));
            cells.push(format!("needs = {}", list(needs)));
        }
        if !code.risk.is_empty() {
            cells.push(format!("risk = {}", quoted(code.risk)));
        }
        cells
    };
    codes.iter().map(entry).collect()
}

/// The code tables of a model, each once, with a name from the first parameter that has it.
struct CodeNames {
    tables: Vec<(String, &'static Codes)>,
}

impl CodeNames {
    fn of(model: &Model) -> Self {
        let mut names = Self { tables: Vec::new() };
        let of_rows = model.blocks.iter().flat_map(|placed| placed.block.rows).map(|row| (row.name, &row.codes));
        let of_values = model.values.iter().map(|value| (value.name, &value.codes));
        for (of, codes) in of_rows.chain(of_values) {
            let has_table =
                matches!(codes, Codes::Names(_) | Codes::Commands(_) | Codes::BitCommands(_) | Codes::Bits(_));
            if has_table && names.name(codes).is_none() {
                let name = names.unused(&slug(of));
                names.tables.push((name, codes));
            }
        }
        names
    }

    fn name(&self, codes: &Codes) -> Option<&str> {
        self.tables.iter().find(|(_, known)| *known == codes).map(|(name, _)| name.as_str())
    }

    /// The name, or the first with a number that no table has.
    fn unused(&self, name: &str) -> String {
        let is_used = |name: &str| self.tables.iter().any(|(known, _)| known == name);
        let numbered = (2..).map(|number: u32| format!("{name}-{number}"));
        std::iter::once(name.to_owned()).chain(numbered).find(|name| !is_used(name)).unwrap_or_default()
    }

    /// The cells of a value of the cyclic data.
    fn value(&self, value: &CyclicValue) -> Vec<String> {
        let direction = if value.is_output { "outputs" } else { "inputs" };
        let mut cells = vec![
            format!("name = {}", quoted(value.name)),
            format!("{direction} = {}", value.telegram),
            format!("octet = {}", value.octet),
            format!("type = {}", quoted(&value.data_type.to_string())),
        ];
        if value.data_type == DataType::Boolean {
            cells.push(format!("bit = {}", value.bit));
        }
        if let Codes::Quantity(Quantity { unit, factor, .. }) = value.codes {
            cells.push(format!("unit = {}", quoted(unit)));
            cells.push(format!("factor = {factor:?}"));
        }
        cells.extend(self.name(&value.codes).map(|name| format!("codes = {}", quoted(name))));
        cells
    }

    /// The cells of a row, as in the manual's table.
    fn row(&self, row: &Row) -> Vec<String> {
        let mut cells = vec![
            format!("index = {}", row.index),
            format!("name = {}", quoted(row.name)),
            format!("type = {}", quoted(&row.data_type.to_string())),
            format!("access = {}", quoted(row.access_text)),
            format!("store = {}", quoted(word_of(&STORAGES, &row.storage))),
        ];
        if !row.section.is_empty() {
            cells.push(format!("section = {}", quoted(row.section)));
        }
        match row.codes {
            Codes::Plain => {}
            Codes::Range(low, high) => cells.push(format!("range = {}", list([low, high]))),
            Codes::PerMille(low, high) => cells.push(format!("per-mille = {}", list([low, high]))),
            Codes::Quantity(Quantity { unit, factor, range }) => {
                cells.push(format!("unit = {}", quoted(unit)));
                cells.push(format!("factor = {factor:?}"));
                cells.extend(range.map(|(low, high)| format!("range = {}", list([low, high]))));
            }
            Codes::Units => cells.push(format!("codes = {}", quoted(UNITS))),
            Codes::Version => cells.push(format!("codes = {}", quoted(VERSION))),
            Codes::Names(_) | Codes::Commands(_) | Codes::BitCommands(_) | Codes::Bits(_) => {
                cells.extend(self.name(&row.codes).map(|name| format!("codes = {}", quoted(name))));
            }
        }
        // Without its word such a row becomes the unit where no other one is.
        let is_no_unit = row.codes == Codes::Units && row.role.is_none();
        if row.role != Role::of_printed_name(row.name) || is_no_unit {
            cells.push(format!("role = {}", quoted(word_of(&ROLES, &row.role))));
        }
        cells
    }
}

/// A name in small letters, digits and hyphens.
fn slug(name: &str) -> String {
    let letters = name.to_lowercase();
    let words = letters.split(|letter: char| !letter.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let slug = words.collect::<Vec<_>>().join("-");
    // The two names have a meaning of their own.
    if slug.is_empty() || slug == UNITS || slug == VERSION { format!("table-{slug}") } else { slug }
}
