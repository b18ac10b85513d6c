//! A device file as TOML: its tables and keys.
//!
//! The octets of a [`Spanned`] value are counted from the first octet of the file that is read; the devices that it is like follow.

use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

/// The format of the files that this program reads.
pub const FORMAT: i64 = 1;

/// A list in which each entry has its position, and the position of the whole.
pub type List<T> = Spanned<Vec<Spanned<T>>>;

/// The telegrams of one direction, by their numbers.
pub type Telegrams = BTreeMap<String, List<String>>;

/// The part of a file that says whether this program can read the rest.
#[derive(Deserialize)]
pub struct FormatToml {
    pub format: Option<Spanned<i64>>,
}

/// The whole file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct DeviceToml {
    /// Checked before the rest: [`FormatToml`].
    #[serde(rename = "format")]
    pub _format: i64,
    /// The name in profivac.
    pub name: Spanned<String>,
    /// The name on the device.
    pub title: Spanned<String>,
    /// A known device, or a device file, whose tables this device has where this file says nothing else.
    pub like: Option<Spanned<String>>,
    /// The built-in device whose behaviour a simulated device has.
    pub behaviour: Option<Spanned<String>>,
    /// What the device does and this behaviour does not.
    pub left_out: Option<Spanned<String>>,
    pub vendor: Option<Spanned<String>>,
    pub manual: Option<Spanned<String>>,
    /// What the manual has wrong or does not say.
    pub errata: Option<Spanned<String>>,
    /// `Ident_Number`.
    pub ident: Option<u16>,
    pub services: Option<ServicesToml>,
    pub units: Option<List<UnitToml>>,
    /// The highest integer of a pressure.
    pub max_integer: Option<u16>,
    pub user_parameters: Option<List<UserPrmToml>>,
    /// The bits of the first user parameter octet that a master may add.
    pub free_bits: Option<u8>,
    /// Telegrams from the master to the slave.
    #[serde(default)]
    pub outputs: Telegrams,
    /// Telegrams from the slave to the master.
    #[serde(default)]
    pub inputs: Telegrams,
    pub configurations: Option<List<ConfigurationToml>>,
    /// The answer to Get_Cfg before the first Chk_Cfg.
    pub default_configuration: Option<Spanned<String>>,
    /// Values of the cyclic data that are no pressures.
    pub values: Option<List<ValueToml>>,
    pub parts: Option<List<PartToml>>,
    pub parameter_channel: Option<ChannelToml>,
    pub alarms: Option<AlarmsToml>,
    pub faults: Option<List<FaultToml>>,
    pub gsd: Option<GsdToml>,
    #[serde(default)]
    pub block: Vec<BlockToml>,
    #[serde(default)]
    pub codes: BTreeMap<String, Spanned<CodesToml>>,
}

/// `[services]`.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ServicesToml {
    pub sync: bool,
    pub freeze: bool,
    pub dpv1: bool,
    pub ms1: bool,
}

/// An entry of `units`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct UnitToml {
    pub code: u16,
    pub name: Spanned<String>,
    /// Another common name.
    pub alias: Option<Spanned<String>>,
    /// This number of units for one mbar; none for COUNTS.
    pub per_mbar: Option<Spanned<f64>>,
}

/// An entry of `user-parameters`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UserPrmToml {
    pub name: Spanned<String>,
    pub octets: Spanned<String>,
}

/// An entry of `configurations`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConfigurationToml {
    pub outputs: Option<Spanned<u8>>,
    pub inputs: Option<Spanned<u8>>,
    pub octets: Spanned<String>,
}

/// An entry of `values`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ValueToml {
    pub name: Spanned<String>,
    /// The number of its telegram, from the device; or [`Self::outputs`].
    pub inputs: Option<Spanned<u8>>,
    /// The number of its telegram, to the device.
    pub outputs: Option<Spanned<u8>>,
    /// The first octet in the telegram.
    #[serde(default)]
    pub octet: u8,
    /// The bit of the octet, of a BOOLEAN. Default: 0, the lowest.
    pub bit: Option<Spanned<u8>>,
    #[serde(rename = "type")]
    pub data_type: Spanned<String>,
    pub unit: Option<Spanned<String>>,
    /// One step of the number, in this unit. Default: 1.
    pub factor: Option<Spanned<f64>>,
    /// A table with names.
    pub codes: Option<Spanned<String>>,
}

/// An entry of `parts`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct PartToml {
    pub instance: u8,
    pub principle: Spanned<String>,
    pub underrange: Spanned<String>,
    pub overrange: Spanned<String>,
    /// Default: `overrange`.
    pub full_scale: Option<Spanned<String>>,
    /// At which ends the part shows the end of its range. Default: `never`.
    pub clips: Option<Spanned<String>>,
    pub counts: Option<Spanned<CountsToml>>,
}

/// COUNTS of a part: `per-decade` and `at-1-mbar`, or `per-mbar`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct CountsToml {
    pub per_decade: Option<f64>,
    #[serde(rename = "at-1-mbar")]
    pub at_1_mbar: Option<f64>,
    pub per_mbar: Option<f64>,
}

/// `[parameter-channel]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ChannelToml {
    /// Whether the device starts a new task only after AK 0.
    #[serde(default)]
    pub idle_between_tasks: bool,
    pub tasks: List<TaskToml>,
    #[serde(default)]
    pub errors: Vec<Spanned<ErrorToml>>,
}

/// An entry of `tasks`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TaskToml {
    pub ak: u8,
    /// The numbers of octets that the task writes; without it the task reads.
    pub write: Option<Vec<u8>>,
}

/// An entry of `errors`: an error code that differs from that of the other manuals.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ErrorToml {
    pub error: Spanned<String>,
    pub code: u8,
}

/// `[alarms]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AlarmsToml {
    /// The instances of the pairs of octets in Device Exception Detail Alarm.
    #[serde(default)]
    pub instances: Vec<u8>,
    #[serde(default)]
    pub sensor: Vec<Spanned<SensorAlarmToml>>,
    #[serde(default)]
    pub manufacturer: Vec<MaskToml>,
}

/// An entry of `sensor`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorAlarmToml {
    pub octet: u8,
    pub mask: u8,
    pub name: Spanned<String>,
}

/// An entry of `manufacturer`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaskToml {
    pub mask: u8,
    pub name: Spanned<String>,
}

/// An entry of `faults`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FaultToml {
    pub name: Spanned<String>,
    pub effect: Spanned<String>,
}

/// `[gsd]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct GsdToml {
    pub revision: Option<u8>,
    pub hardware: Option<Spanned<String>>,
    pub software: Option<Spanned<String>>,
    pub max_diagnosis_octets: Option<Spanned<u8>>,
    #[serde(default)]
    pub set_slave_address: bool,
}

/// `[[block]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BlockToml {
    /// The heading of its table.
    pub name: Spanned<String>,
    #[serde(rename = "type")]
    pub block_type: Option<u16>,
    /// What the block does in a simulated device.
    pub behaviour: Option<Spanned<String>>,
    pub at: Option<List<LocationToml>>,
    #[serde(default)]
    pub parameters: Vec<Spanned<RowToml>>,
    /// Indices of the block that the device does not have.
    #[serde(default)]
    pub without: Vec<Spanned<u8>>,
}

/// An entry of `at`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LocationToml {
    pub slot: u8,
    /// 0 where the slot has only one.
    #[serde(default)]
    pub instance: u8,
    pub name: Spanned<String>,
}

/// An entry of `parameters`: a row of the manual's table.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct RowToml {
    pub index: u8,
    pub name: Spanned<String>,
    #[serde(rename = "type")]
    pub data_type: Spanned<String>,
    pub access: Spanned<String>,
    pub store: Option<Spanned<String>>,
    pub section: Option<Spanned<String>>,
    pub codes: Option<Spanned<String>>,
    pub range: Option<Spanned<(i64, i64)>>,
    pub per_mille: Option<Spanned<(i64, i64)>>,
    /// The unit of a number that is no pressure.
    pub unit: Option<Spanned<String>>,
    /// One step of the number, in this unit. Default: 1.
    pub factor: Option<Spanned<f64>>,
    /// What the parameter is for, where its name does not say so.
    pub role: Option<Spanned<String>>,
}

/// `[codes.NAME]`: one of the lists.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct CodesToml {
    pub names: Option<Vec<Spanned<CodeToml>>>,
    pub commands: Option<Vec<Spanned<CodeToml>>>,
    pub bit_commands: Option<Vec<Spanned<CodeToml>>>,
    pub bits: Option<Vec<Spanned<BitToml>>>,
}

/// A number with a name.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CodeToml {
    pub code: u16,
    pub name: Spanned<String>,
    /// The conditions under which it may be written.
    #[serde(default)]
    pub needs: Vec<Spanned<String>>,
    pub risk: Option<Spanned<String>>,
}

/// A bit with a name.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BitToml {
    pub bit: u8,
    pub name: Spanned<String>,
}
