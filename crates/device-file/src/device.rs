//! The tables of a device that a file describes, and the [`Model`] that they become.

use profivac_devices::described::BlockBehaviour;
use profivac_devices::model::{
    Access, AccessError, AlarmBit, AlarmWords, Block, ChannelRules, Code, Codes, Configuration, CyclicValue, DataType,
    Fault, FaultList, Field, Gsd, Location, Model, PartSpec, PlacedBlock, Precondition, Principle, Quantity, Role, Row,
    RowTexts, Scale, Storage, TaskKind, Telegram, Unit, UserPrm,
};
use profivac_devices::profile::Thresholds;
use profivac_dp::slave::Features;
use std::collections::BTreeMap;
use std::ops::Range;

/// The telegrams of one direction, by their numbers.
pub type TelegramFields = BTreeMap<u8, Vec<Field>>;

/// The tables of a device, free of contradictions. A [`Model`] with owned contents.
#[derive(Debug)]
pub struct Device {
    pub name: String,
    pub title: String,
    pub vendor: String,
    pub manual: String,
    pub errata: String,
    /// The built-in device whose behaviour it has.
    pub behaviour: Option<&'static Model>,
    /// What this behaviour leaves out.
    pub left_out: String,
    pub ident: u16,
    pub features: Features,
    pub units: Vec<OwnedUnit>,
    pub max_integer: u16,
    pub user_prm: Vec<OwnedPrm>,
    pub free_bits: u8,
    pub outputs: TelegramFields,
    pub inputs: TelegramFields,
    pub configurations: Vec<OwnedConfiguration>,
    /// The position of the default configuration.
    pub default_configuration: usize,
    pub values: Vec<OwnedValue>,
    pub parts: Vec<PartSpec>,
    pub tasks: Vec<(u8, OwnedTask)>,
    pub needs_idle_between: bool,
    pub error_codes: Vec<(AccessError, u8)>,
    pub alarm_instances: Vec<u8>,
    pub sensor_alarms: Vec<(usize, u8, String)>,
    pub manufacturer_alarms: Vec<(u8, String)>,
    pub faults: Vec<(Fault, String)>,
    pub gsd: OwnedGsd,
    pub tables: Vec<CodeList>,
    pub blocks: Vec<OwnedBlock>,
}

#[derive(Debug)]
pub struct OwnedUnit {
    pub code: u16,
    pub name: String,
    pub alias: String,
    pub scale: Scale,
}

#[derive(Debug)]
pub struct OwnedPrm {
    pub name: String,
    pub octets: Vec<u8>,
}

#[derive(Debug)]
pub struct OwnedConfiguration {
    pub outputs: Option<u8>,
    pub inputs: Option<u8>,
    pub octets: Vec<u8>,
}

/// A value of the cyclic data that is no pressure.
#[derive(Debug)]
pub struct OwnedValue {
    pub name: String,
    pub is_output: bool,
    pub telegram: u8,
    pub octet: u8,
    pub bit: u8,
    pub data_type: DataType,
    pub codes: RowCodes,
    pub quantity: Option<OwnedQuantity>,
}

#[derive(Debug)]
pub enum OwnedTask {
    Read,
    Write(Vec<usize>),
}

#[derive(Debug)]
pub struct OwnedGsd {
    pub revision: u8,
    pub hardware: String,
    pub software: String,
    pub max_diag_octets: u8,
    pub set_slave_add: bool,
}

/// A code table with a name.
#[derive(Debug)]
pub enum CodeList {
    Names(Vec<OwnedCode>),
    Commands(Vec<OwnedCode>),
    BitCommands(Vec<OwnedCode>),
    Bits(Vec<(u8, String)>),
}

#[derive(Debug)]
pub struct OwnedCode {
    pub number: u16,
    pub name: String,
    pub preconditions: Vec<Precondition>,
    pub risk: String,
}

/// The codes of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowCodes {
    Plain,
    Range(i64, i64),
    PerMille(i64, i64),
    Units,
    Version,
    /// A number in a unit: [`OwnedRow::quantity`].
    Quantity,
    /// The table at this position of [`Device::tables`].
    Table(usize),
}

#[derive(Debug)]
pub struct OwnedBlock {
    pub name: String,
    pub block_type: Option<u16>,
    pub behaviour: Option<BlockBehaviour>,
    pub rows: Vec<OwnedRow>,
    pub locations: Vec<OwnedLocation>,
}

#[derive(Debug)]
pub struct OwnedRow {
    /// Where the file describes it.
    pub span: Range<usize>,
    pub index: u8,
    pub name: String,
    pub data_type: DataType,
    pub access: Access,
    pub access_text: String,
    pub storage: Storage,
    pub section: String,
    pub codes: RowCodes,
    pub quantity: Option<OwnedQuantity>,
    pub role: Option<Role>,
}

#[derive(Debug)]
pub struct OwnedQuantity {
    pub unit: String,
    pub factor: f64,
    pub range: Option<(i64, i64)>,
}

#[derive(Debug)]
pub struct OwnedLocation {
    pub slot: u8,
    pub instance: u8,
    pub name: String,
}

impl OwnedLocation {
    pub fn is_at(&self, other: &Self) -> bool {
        (self.slot, self.instance) == (other.slot, other.instance)
    }
}

impl CodeList {
    /// The key of its list in a file.
    pub const fn key(&self) -> &'static str {
        match self {
            Self::Names(_) => "names",
            Self::Commands(_) => "commands",
            Self::BitCommands(_) => "bit-commands",
            Self::Bits(_) => "bits",
        }
    }

    /// The numbers with names, and whether writing one is a command.
    pub fn codes(&self) -> (&[OwnedCode], bool) {
        match self {
            Self::Names(codes) => (codes, false),
            Self::Commands(codes) | Self::BitCommands(codes) => (codes, true),
            Self::Bits(_) => (&[], false),
        }
    }
}

impl Device {
    /// The code table of a row.
    pub fn table(&self, codes: RowCodes) -> Option<&CodeList> {
        match codes {
            RowCodes::Table(position) => self.tables.get(position),
            _ => None,
        }
    }

    /// The pressures at which cathodes are switched, if the library has the behaviour. chosen: on and off above the range as in the BCG450,
    /// degas below the condition of the command, without one below a thousandth of the range.
    pub fn thresholds(&self) -> Thresholds {
        let has_cathode =
            |part: &&PartSpec| matches!(part.part.principle, Principle::HotCathode | Principle::ColdCathode);
        let over_pa = self.parts.iter().filter(has_cathode).map(|part| part.limits.over_pa).fold(0.0, f64::max);
        let limit = |condition: &Precondition| match condition {
            Precondition::PressureBelow(_, pa) => Some(*pa),
            _ => None,
        };
        let mut degas = self.tables.iter().flat_map(|table| table.codes().0).filter(|code| code.name == "degas-on");
        let degas_pa = degas.find_map(|code| code.preconditions.iter().find_map(limit));
        Thresholds { off_pa: 1.6 * over_pa, on_pa: 1.2 * over_pa, degas_pa: degas_pa.unwrap_or(over_pa / 1000.0) }
    }

    /// The model, which is never freed.
    pub fn leak(self) -> &'static Model {
        let outputs = leak_telegrams(self.outputs);
        let inputs = leak_telegrams(self.inputs);
        let telegram = |telegrams: &BTreeMap<u8, &'static Telegram>, number: Option<u8>| {
            number.and_then(|number| telegrams.get(&number).copied())
        };
        let configurations = self.configurations.into_iter().map(|one| Configuration {
            outputs: telegram(&outputs, one.outputs),
            inputs: telegram(&inputs, one.inputs),
            octets: one.octets.leak(),
        });
        let configurations: &'static [Configuration] = leak(configurations);
        let tables: Vec<StaticCodes> = self.tables.into_iter().map(StaticCodes::leak).collect();
        let parts: Vec<&'static PartSpec> = Vec::leak(self.parts).iter().collect();
        Box::leak(Box::new(Model {
            name: self.name.leak(),
            title: self.title.leak(),
            vendor: self.vendor.leak(),
            manual: self.manual.leak(),
            ident: self.ident,
            features: self.features,
            configurations,
            default_configuration: configurations.get(self.default_configuration).unwrap_or(&NO_CONFIGURATION),
            values: leak(self.values.into_iter().map(|value| value.leak(&tables))),
            units: leak(self.units.into_iter().map(OwnedUnit::leak)),
            max_integer: self.max_integer,
            user_prm: leak(
                self.user_prm
                    .into_iter()
                    .map(|OwnedPrm { name, octets }| UserPrm { name: name.leak(), octets: octets.leak() }),
            ),
            dpv1_status: self.free_bits,
            blocks: leak(self.blocks.into_iter().map(|block| block.leak(&tables))),
            parts: parts.leak(),
            channel_rules: Box::leak(Box::new(ChannelRules {
                tasks: leak(self.tasks.into_iter().map(|(ak, task)| (ak, task.leak()))),
                needs_idle_between: self.needs_idle_between,
                error_codes: self.error_codes.leak(),
            })),
            alarms: AlarmWords {
                instances: self.alarm_instances.leak(),
                sensor: leak(self.sensor_alarms.into_iter().map(|(octet, mask, name)| AlarmBit {
                    octet,
                    mask,
                    name: name.leak(),
                })),
                manufacturer: leak(self.manufacturer_alarms.into_iter().map(|(mask, name)| (mask, leak_text(name)))),
            },
            faults: leak_faults(self.faults),
            errata: self.errata.leak(),
            gsd: self.gsd.leak(),
        }))
    }
}

/// No configuration: a device has at least one.
static NO_CONFIGURATION: Configuration = Configuration { outputs: None, inputs: None, octets: &[] };

fn leak<T>(values: impl Iterator<Item = T>) -> &'static [T] {
    values.collect::<Vec<_>>().leak()
}

fn leak_text(text: String) -> &'static str {
    text.leak()
}

fn leak_telegrams(telegrams: TelegramFields) -> BTreeMap<u8, &'static Telegram> {
    let leaked = telegrams.into_iter().map(|(number, fields)| {
        let telegram: &'static Telegram = Box::leak(Box::new(Telegram { number, fields: fields.leak() }));
        (number, telegram)
    });
    leaked.collect()
}

fn leak_faults(faults: Vec<(Fault, String)>) -> &'static FaultList {
    let (faults, effects): (Vec<_>, Vec<_>) = faults.into_iter().unzip();
    Box::leak(Box::new(FaultList { faults: faults.leak(), effects: leak(effects.into_iter().map(leak_text)) }))
}

impl OwnedUnit {
    fn leak(self) -> Unit {
        Unit { code: self.code, name: self.name.leak(), alias: self.alias.leak(), scale: self.scale }
    }
}

impl OwnedTask {
    fn leak(self) -> TaskKind {
        match self {
            Self::Read => TaskKind::Read,
            Self::Write(lengths) => TaskKind::Write(lengths.leak()),
        }
    }
}

impl OwnedGsd {
    fn leak(self) -> Gsd {
        Gsd {
            revision: self.revision,
            hardware: self.hardware.leak(),
            software: self.software.leak(),
            max_diag_octets: self.max_diag_octets,
            set_slave_add: self.set_slave_add,
        }
    }
}

/// A code table that several rows can have.
enum StaticCodes {
    Names(&'static [Code]),
    Commands(&'static [Code]),
    BitCommands(&'static [Code]),
    Bits(&'static [(u8, &'static str)]),
}

impl StaticCodes {
    fn leak(list: CodeList) -> Self {
        match list {
            CodeList::Names(codes) => Self::Names(leak_codes(codes)),
            CodeList::Commands(codes) => Self::Commands(leak_codes(codes)),
            CodeList::BitCommands(codes) => Self::BitCommands(leak_codes(codes)),
            CodeList::Bits(bits) => Self::Bits(leak(bits.into_iter().map(|(bit, name)| (bit, leak_text(name))))),
        }
    }

    const fn codes(&self) -> Codes {
        match *self {
            Self::Names(codes) => Codes::Names(codes),
            Self::Commands(codes) => Codes::Commands(codes),
            Self::BitCommands(codes) => Codes::BitCommands(codes),
            Self::Bits(bits) => Codes::Bits(bits),
        }
    }
}

fn leak_codes(codes: Vec<OwnedCode>) -> &'static [Code] {
    leak(codes.into_iter().map(|code| Code {
        number: code.number,
        name: code.name.leak(),
        preconditions: code.preconditions.leak(),
        risk: code.risk.leak(),
    }))
}

impl OwnedBlock {
    fn leak(self, tables: &[StaticCodes]) -> PlacedBlock {
        let rows = leak(self.rows.into_iter().map(|row| row.leak(tables)));
        PlacedBlock {
            block: Box::leak(Box::new(Block { name: self.name.leak(), block_type: self.block_type, rows })),
            locations: leak(self.locations.into_iter().map(|OwnedLocation { slot, instance, name }| Location {
                slot,
                instance,
                name: name.leak(),
            })),
        }
    }
}

impl RowCodes {
    fn leak(self, quantity: Option<OwnedQuantity>, tables: &[StaticCodes]) -> Codes {
        match self {
            Self::Plain => Codes::Plain,
            Self::Range(low, high) => Codes::Range(low, high),
            Self::PerMille(low, high) => Codes::PerMille(low, high),
            Self::Units => Codes::Units,
            Self::Version => Codes::Version,
            Self::Quantity => quantity.map_or(Codes::Plain, |OwnedQuantity { unit, factor, range }| {
                Codes::Quantity(Quantity { unit: unit.leak(), factor, range })
            }),
            Self::Table(position) => tables.get(position).map_or(Codes::Plain, StaticCodes::codes),
        }
    }
}

impl OwnedValue {
    fn leak(self, tables: &[StaticCodes]) -> CyclicValue {
        let Self { name, is_output, telegram, octet, bit, data_type, codes, quantity } = self;
        let codes = codes.leak(quantity, tables);
        CyclicValue { name: name.leak(), is_output, telegram, octet, bit, data_type, codes }
    }
}

impl OwnedRow {
    fn leak(self, tables: &[StaticCodes]) -> Row {
        let codes = self.codes.leak(self.quantity, tables);
        let texts =
            RowTexts { name: self.name.leak(), access: self.access_text.leak(), section: self.section.leak(), codes };
        Row::new(self.index, self.data_type, self.access, self.storage, self.role, texts)
    }
}
