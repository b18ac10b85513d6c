//! The scenario file as it is written: keys and texts, not yet resolved.
//!
//! The crate `virtual` is optimised, because its scenarios last for days. The code that reads the file is most of what the compiler
//! would optimise there, and it runs once: so it is a crate of its own.

use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

/// A text with its position.
pub type Text = Spanned<String>;

/// Parts by name.
pub type Named<T> = BTreeMap<String, Spanned<T>>;

/// The whole file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct File {
    pub title: String,
    /// The seed of sensor noise and sensor errors.
    #[serde(default)]
    pub seed: u64,
    /// `real`, or `ideal` without noise, lag and errors.
    pub sensors: Option<Text>,
    pub step: Option<Text>,
    pub until: Text,
    pub atmosphere: Option<Air>,
    pub volumes: Named<Volume>,
    #[serde(default)]
    pub walls: Named<Wall>,
    #[serde(default)]
    pub tubes: Named<Tube>,
    #[serde(default)]
    pub valves: Named<Tube>,
    #[serde(default)]
    pub pockets: Named<Pocket>,
    #[serde(default)]
    pub roughing_pumps: Named<Roughing>,
    #[serde(default)]
    pub turbo_pumps: Named<Turbo>,
    #[serde(default)]
    pub capture_pumps: Named<Capture>,
    #[serde(default)]
    pub leaks: Named<Leak>,
    #[serde(default)]
    pub vents: Named<Vent>,
    #[serde(default)]
    pub inlets: Named<Inlet>,
    #[serde(default)]
    pub seals: Named<Seal>,
    /// The volume of each device, by `DEVICE@ADDR[:key=value,...]`.
    #[serde(default)]
    pub gauges: BTreeMap<Text, Text>,
    /// The volumes of measuring parts outside the volume of their device, by address and instance.
    #[serde(default)]
    pub channels: BTreeMap<Text, BTreeMap<Text, Text>>,
    /// Slaves by their GSD files, as `FILE.gsd@ADDR:modules=3+7`.
    #[serde(default)]
    pub slaves: Vec<Text>,
    #[serde(default)]
    pub timeline: Vec<Spanned<Entry>>,
}

impl File {
    /// Reads the text of a file.
    ///
    /// # Errors
    /// The first key or value that the file may not have, with its position.
    pub fn read(text: &str) -> Result<Self, toml::de::Error> {
        toml::from_str(text)
    }
}

/// The air outside.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Air {
    pub pressure: Option<Text>,
    pub humidity: Option<Text>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Volume {
    pub volume: Text,
    /// Filled with the air outside unless a gas is given.
    pub gas: Option<Text>,
    pub pressure: Option<Text>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    #[serde(rename = "in")]
    pub of: Text,
    pub material: Text,
    pub area: Text,
    /// How long it has been in vacuum.
    pub aged: Option<Text>,
    /// The temperature meanwhile.
    pub aged_at: Option<Text>,
}

/// A tube or a valve.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Tube {
    pub between: [Text; 2],
    pub diameter: Option<Text>,
    pub length: Option<Text>,
    pub conductance: Option<Text>,
    /// Whether its opening has sharp edges; rounded unless given.
    #[serde(default)]
    pub sharp_edged: bool,
    pub open: Option<bool>,
}

/// A virtual leak.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pocket {
    #[serde(rename = "in")]
    pub of: Text,
    pub volume: Text,
    pub conductance: Text,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Roughing {
    pub at: Text,
    pub speed: Text,
    pub ultimate: Text,
    /// Speeds by inlet pressure, instead of one speed at every pressure.
    #[serde(default)]
    pub speed_at: BTreeMap<Text, Text>,
    #[serde(default)]
    pub running: bool,
}

/// An ion pump, a getter or a cryopump: speeds and capacities by gas.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Capture {
    pub at: Text,
    pub speeds: BTreeMap<Text, Text>,
    /// A gas without a capacity is captured without a limit.
    #[serde(default)]
    pub capacities: BTreeMap<Text, Text>,
    pub highest_pressure: Text,
    #[serde(default)]
    pub running: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Turbo {
    pub inlet: Text,
    pub fore: Text,
    pub speed: Text,
    pub compression: Option<Spanned<f64>>,
    /// Speeds and compressions of other gases than nitrogen.
    #[serde(default)]
    pub speeds: BTreeMap<Text, Text>,
    #[serde(default)]
    pub compressions: BTreeMap<Text, Spanned<f64>>,
    pub critical_pressure: Option<Text>,
    pub spin_up: Option<Text>,
    #[serde(default)]
    pub running: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Leak {
    pub at: Text,
    pub rate: Text,
    #[serde(default)]
    pub open: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Vent {
    pub at: Text,
    pub diameter: Text,
    pub length: Text,
    /// Whether its opening has sharp edges; rounded unless given.
    #[serde(default)]
    pub sharp_edged: bool,
    /// Fed at the pressure outside; air unless a gas is given.
    pub gas: Option<Text>,
    #[serde(default)]
    pub open: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Inlet {
    pub at: Text,
    pub gas: Text,
}

/// A seal between a volume and the air outside, through which gas permeates.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Seal {
    #[serde(rename = "in")]
    pub of: Text,
    /// The area that the gas passes, and the way through the seal.
    pub area: Text,
    pub thickness: Text,
    /// By gas. A gas without a permeability does not pass.
    pub permeabilities: BTreeMap<Text, Text>,
}

/// The events at one time.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Entry {
    pub at: Text,
    pub say: Option<String>,
    #[serde(default)]
    pub open: Vec<Text>,
    #[serde(default)]
    pub close: Vec<Text>,
    #[serde(default)]
    pub start: Vec<Text>,
    #[serde(default)]
    pub stop: Vec<Text>,
    #[serde(default)]
    pub flow: Vec<Flow>,
    #[serde(default)]
    pub heat: Vec<Heat>,
    #[serde(default)]
    pub spray: Vec<Spray>,
    /// Capture pumps that lose all their gas: regeneration outside the plant.
    #[serde(default)]
    pub regenerate: Vec<Text>,
    pub atmosphere: Option<Air>,
    #[serde(default)]
    pub fault: Vec<Fault>,
    #[serde(default)]
    pub clear: Vec<Fault>,
    #[serde(default)]
    pub power_off: Vec<Spanned<u8>>,
    #[serde(default)]
    pub power_on: Vec<Spanned<u8>>,
    #[serde(default)]
    pub unplug: Vec<Spanned<u8>>,
    #[serde(default)]
    pub plug: Vec<Spanned<u8>>,
    /// The fraction of the octets on the bus that noise damages from now on.
    pub noise: Option<Text>,
    #[serde(default)]
    pub button: Vec<Button>,
    #[serde(default)]
    pub switch: Vec<Switch>,
    #[serde(default)]
    pub pot: Vec<Pot>,
    #[serde(default)]
    pub write: Vec<Write>,
    /// Lines to slaves by their GSD files, as on the standard input of `simulate`.
    #[serde(default)]
    pub order: Vec<Text>,
    #[serde(default)]
    pub expect: Vec<Spanned<Expect>>,
}

/// A gas inlet: a flow, or the pressure that it regulates.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Flow {
    pub inlet: Text,
    pub flow: Option<Text>,
    pub pressure: Option<Text>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Heat {
    pub wall: Text,
    pub to: Text,
    /// The time of the change.
    pub over: Option<Text>,
}

/// A gas that is sprayed on a leak; air ends it.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spray {
    pub leak: Text,
    pub gas: Text,
}

/// A fault of a device.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fault {
    pub device: Spanned<u8>,
    pub name: Text,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Button {
    pub device: Spanned<u8>,
    pub number: Spanned<u8>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Switch {
    pub device: Spanned<u8>,
    pub name: Text,
    pub value: Text,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pot {
    pub device: Spanned<u8>,
    pub which: Spanned<char>,
    pub volts: Spanned<f64>,
}

/// A record that a class 2 master writes.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Write {
    pub device: Spanned<u8>,
    pub slot: u8,
    pub index: u8,
    pub octets: Vec<u8>,
}

/// An expectation.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expect {
    pub volume: Option<Text>,
    pub device: Option<Spanned<u8>>,
    /// The instance of a device; the active one unless given.
    pub instance: Option<u8>,
    pub above: Option<Text>,
    pub below: Option<Text>,
    pub near: Option<Text>,
    /// The tolerance of `near` as a fraction; a tenth unless given.
    pub within: Option<Text>,
    pub valid: Option<bool>,
    pub state: Option<Text>,
    pub emission: Option<bool>,
    pub degas: Option<bool>,
    pub relay: Option<u8>,
    pub closed: Option<bool>,
    pub fault: Option<bool>,
    pub exchanging: Option<bool>,
}
