//! The known facts about the device of a slave: model, configuration and unit, each with its origin, and the pressures of its inputs.

use profivac_client::cyclic::{Cause, ChannelValue, CyclicSlave, CyclicValues, ReportedChannels, TtrReading};
use profivac_devices::catalog::KnownDevices;
use profivac_devices::model::{Configuration, Field, Limits, Model, Telegram, Unit};
use profivac_devices::profile::StatusExtension;
use profivac_devices::reading::Quality;
use profivac_dp::link::BitTime;
use profivac_sim::describe::Hex;
use serde::Serialize;
use std::fmt;

/// Where a fact about a slave comes from. An earlier one is stronger.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum Origin {
    /// A telegram on the line showed it.
    Heard,
    /// The user said so.
    Configured,
    /// It fits the traffic, and nothing confirms it.
    Assumed,
}

impl Origin {
    /// The word for users.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Heard => "heard",
            Self::Configured => "configured",
            Self::Assumed => "assumed",
        }
    }
}

/// What the user says about the gauge at an address.
#[derive(Clone, Copy, Debug)]
pub struct Declared {
    /// The model.
    pub model: &'static Model,
    /// The configuration, if the user knows it.
    pub configuration: Option<&'static Configuration>,
    /// The unit of its pressures, if the user knows it.
    pub unit: Option<&'static Unit>,
}

/// The device of a slave as far as it is known.
#[derive(Clone, Copy, Debug)]
pub struct GaugeFacts {
    /// Everything that decodes its inputs.
    pub slave: CyclicSlave,
    /// The origin of the model.
    pub model: Origin,
    /// The origin of the configuration.
    pub configuration: Origin,
    /// The origin of the unit.
    pub unit: Origin,
}

impl GaugeFacts {
    /// The weakest of the three origins.
    #[must_use]
    pub fn origin(&self) -> Origin {
        self.model.max(self.configuration).max(self.unit)
    }
}

/// What the file says about a gauge otherwise than the line shows.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Contradiction {
    /// The units by name.
    Unit {
        /// In the file.
        file: &'static str,
        /// On the line.
        line: &'static str,
    },
    /// The octets of the configurations.
    Configuration {
        /// In the file.
        file: &'static [u8],
        /// On the line.
        line: Vec<u8>,
    },
}

impl fmt::Display for Contradiction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unit { file, line } => {
                write!(f, "the file says unit {file}, the line shows {line}: {line} counts, correct the file")
            }
            Self::Configuration { file, line } => {
                let (file, line) = (Hex(file), Hex(line));
                write!(
                    f,
                    "the file says configuration {file}, the line shows {line}: the line counts, correct the file"
                )
            }
        }
    }
}

/// A fact about a slave that the traffic has not shown, or that it shows otherwise than the file.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unknown {
    /// The file contradicts the line.
    Contradiction(Contradiction),
    /// The device: no known one has this Ident_Number, or none was heard and the file does not name the device.
    Device {
        /// Ident_Number.
        ident: Option<u16>,
    },
    /// Several devices have the Ident_Number; the first that fits is assumed.
    AssumedDevice {
        /// The assumed device.
        device: &'static str,
        /// All devices with the Ident_Number.
        all: Vec<&'static str>,
    },
    /// No configuration of the device has the lengths of the exchange.
    NoConfiguration {
        /// The device.
        device: &'static str,
        /// The octets of the outputs.
        outputs: usize,
        /// The octets of the inputs.
        inputs: usize,
    },
    /// The configuration with these octets is assumed.
    AssumedConfiguration(&'static [u8]),
    /// The unit of this name is assumed.
    AssumedUnit(&'static str),
    /// The numbers of the configuration are assumed, as [`CyclicSlave::assumption`] says it.
    AssumedNumbers(&'static str),
}

impl fmt::Display for Unknown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Contradiction(contradiction) => contradiction.fmt(f),
            Self::Device { ident: Some(ident) } => {
                write!(f, "the device with ident {ident:04X} is not one that profivac knows")
            }
            Self::Device { ident: None } => f.write_str(
                "the device is not known: neither a diagnosis nor a start-up was heard, and the file does not name it",
            ),
            Self::AssumedDevice { device, all } => {
                write!(f, "the device is one of {}; {device} is assumed", all.join(", "))
            }
            Self::NoConfiguration { device, outputs, inputs } => {
                write!(f, "no configuration of the {device} has {outputs} octets out and {inputs} in")
            }
            Self::AssumedConfiguration(octets) => write!(
                f,
                "no Chk_Cfg was heard; the configuration {} is assumed from the lengths and contents",
                Hex(octets)
            ),
            Self::AssumedUnit(unit) => write!(f, "neither Set_Prm nor the file shows the unit; {unit} is assumed"),
            Self::AssumedNumbers(text) => f.write_str(text),
        }
    }
}

/// The pressures of a gauge.
#[derive(Clone, Debug)]
pub struct GaugeReading {
    /// Its device.
    pub facts: GaugeFacts,
    /// The values of its last inputs.
    pub values: CyclicValues,
    /// When the answer with the inputs began.
    pub at: BitTime,
}

/// The facts that telegrams show about the device of a slave, and its last cyclic data.
#[derive(Clone, Debug, Default)]
pub struct Knowledge {
    devices: KnownDevices,
    declared: Option<Declared>,
    ident: Option<u16>,
    /// The configuration of the last acknowledged Chk_Cfg, or of an answer to Get_Cfg.
    configuration: Vec<u8>,
    /// The code of the unit in Set_Prm, or of the record that holds it.
    unit_code: Option<u16>,
    /// The number of outputs of the last exchange.
    outputs: usize,
    inputs: Vec<u8>,
    /// When the answer with the inputs began.
    at: Option<BitTime>,
    /// The configuration by which the images are divided into fields, until a fact changes.
    layout: Option<Option<&'static Configuration>>,
}

impl Knowledge {
    /// Nothing is known yet about the slave, which may be one of `devices`.
    #[must_use]
    pub fn new(devices: KnownDevices) -> Self {
        Self { devices, ..Self::default() }
    }

    /// Takes what the user says.
    pub const fn declare(&mut self, declared: Declared) {
        self.declared = Some(declared);
        self.layout = None;
    }

    /// Whether the user declared a gauge at this address.
    #[must_use]
    pub const fn is_declared(&self) -> bool {
        self.declared.is_some()
    }

    /// Records Ident_Number. Another device at the address has another configuration and unit.
    pub fn identify(&mut self, ident: u16) {
        if self.ident.is_some_and(|known| known != ident) {
            self.configuration.clear();
            self.unit_code = None;
        }
        self.ident = Some(ident);
        self.layout = None;
    }

    /// The Ident_Number, if a telegram showed it.
    #[must_use]
    pub const fn ident(&self) -> Option<u16> {
        self.ident
    }

    /// Records user parameters of an acknowledged Set_Prm.
    pub fn parameterise(&mut self, user: &[u8]) {
        let unit = self.model().and_then(|(model, _)| model.user_prm(user)).map(|prm| prm.unit_code());
        self.unit_code = unit.filter(|code| *code != 0).or(self.unit_code);
    }

    /// Records the code of the unit, read or written as a parameter.
    pub fn learn_unit(&mut self, code: u16) {
        if self.model().is_some_and(|(model, _)| model.unit(code).is_some()) {
            self.unit_code = Some(code);
        }
    }

    /// Records a configuration. Returns whether it differs from the known one.
    pub fn configure(&mut self, octets: &[u8]) -> bool {
        let is_new = self.configuration != octets;
        self.configuration.clear();
        self.configuration.extend_from_slice(octets);
        self.layout = None;
        is_new
    }

    /// The configuration that was heard; empty if none was.
    #[must_use]
    pub fn heard_configuration(&self) -> &[u8] {
        &self.configuration
    }

    /// Records a data exchange that answered at `at`.
    pub fn exchange(&mut self, outputs: usize, inputs: &[u8], at: BitTime) {
        if (self.outputs, self.inputs.len()) != (outputs, inputs.len()) {
            self.layout = None;
        }
        self.outputs = outputs;
        self.inputs.clear();
        self.inputs.extend_from_slice(inputs);
        self.at = Some(at);
    }

    /// The configuration by which the images are divided into fields. It is found once for each change of the facts.
    pub fn layout(&mut self) -> Option<&'static Configuration> {
        if let Some(known) = self.layout {
            return known;
        }
        let found = self.facts(0).map(|facts| facts.slave.configuration);
        if self.at.is_some() {
            self.layout = Some(found);
        }
        found
    }

    /// The number of octets in the outputs of the last exchange; 0 without one.
    #[must_use]
    pub const fn outputs(&self) -> usize {
        self.outputs
    }

    /// The inputs of the last exchange; empty without one.
    #[must_use]
    pub fn inputs(&self) -> &[u8] {
        &self.inputs
    }

    /// When the last answer to Data_Exchange began.
    #[must_use]
    pub const fn exchanged_at(&self) -> Option<BitTime> {
        self.at
    }

    /// The model with its origin.
    #[must_use]
    pub fn model(&self) -> Option<(&'static Model, Origin)> {
        let declared = self.declared.map(|declared| declared.model);
        match (self.ident, declared) {
            (Some(ident), Some(model)) if ident == model.ident => {
                let is_only = self.devices.with_ident(ident).count() == 1;
                Some((model, if is_only { Origin::Heard } else { Origin::Configured }))
            }
            (Some(ident), _) => {
                let is_only = self.devices.with_ident(ident).count() == 1;
                let with_configuration =
                    self.devices.with_ident(ident).find(|model| model.configuration(&self.configuration).is_some());
                let model = with_configuration.or_else(|| self.devices.assumed_with_ident(ident))?;
                Some((model, if is_only { Origin::Heard } else { Origin::Assumed }))
            }
            (None, model) => Some((model?, Origin::Configured)),
        }
    }

    /// All that decodes the inputs of the slave at `address`, with the origins. `None` without a model or an exchange, or if no
    /// configuration of the model fits the lengths of the exchange.
    #[must_use]
    pub fn facts(&self, address: u8) -> Option<GaugeFacts> {
        self.at?;
        let (model, model_origin) = self.model()?;
        let declared = self.declared.filter(|declared| declared.model.name == model.name);
        let fits = |configuration: &&Configuration| self.fits(configuration);
        let heard = model.configuration(&self.configuration).filter(fits).map(|it| (it, Origin::Heard));
        let named = declared.and_then(|it| it.configuration).filter(fits).map(|it| (it, Origin::Configured));
        let heard_unit = self.unit_code.and_then(|code| model.unit(code)).map(|unit| (unit, Origin::Heard));
        let named_unit = declared.and_then(|it| it.unit).map(|unit| (unit, Origin::Configured));
        let unit = heard_unit.or(named_unit);
        let only = || Some((self.only_fitting(model)?, model_origin));
        let assumed = || Some((self.assumed(model, unit.map(|it| it.0))?, Origin::Assumed));
        let (configuration, configuration_origin) = heard.or(named).or_else(only).or_else(assumed)?;
        let slave = |unit| CyclicSlave { address, model, configuration, unit, channels: ReportedChannels::default() };
        let (unit, unit_origin) = unit.or_else(|| {
            let plausible = usual_units(model).find(|unit| self.is_plausible(&slave(unit)));
            Some((plausible.or_else(|| usual_units(model).next())?, Origin::Assumed))
        })?;
        let unit_origin = if has_unit(configuration) { unit_origin } else { configuration_origin };
        Some(GaugeFacts {
            slave: slave(unit),
            model: model_origin,
            configuration: configuration_origin,
            unit: unit_origin,
        })
    }

    /// The pressures in the last inputs of the slave at `address`.
    #[must_use]
    pub fn reading(&self, address: u8) -> Option<GaugeReading> {
        let (facts, at) = (self.facts(address)?, self.at?);
        Some(GaugeReading { facts, values: facts.slave.decode_inputs(&self.inputs), at })
    }

    /// What the traffic has not shown about the slave, and what it shows otherwise than the file.
    #[must_use]
    pub fn unknown(&self) -> Vec<Unknown> {
        let Some((model, model_origin)) = self.model() else { return vec![Unknown::Device { ident: self.ident }] };
        let mut all: Vec<Unknown> = self.contradictions().into_iter().map(Unknown::Contradiction).collect();
        if model_origin == Origin::Assumed {
            let names = self.devices.names_with_ident(model.ident).collect();
            all.push(Unknown::AssumedDevice { device: model.name, all: names });
        }
        if self.at.is_none() {
            return all;
        }
        let Some(facts) = self.facts(0) else {
            let (outputs, inputs) = (self.outputs, self.inputs.len());
            all.push(Unknown::NoConfiguration { device: model.name, outputs, inputs });
            return all;
        };
        if facts.configuration == Origin::Assumed {
            all.push(Unknown::AssumedConfiguration(facts.slave.configuration.octets));
        }
        if facts.unit == Origin::Assumed && has_unit(facts.slave.configuration) {
            all.push(Unknown::AssumedUnit(facts.slave.unit.name));
        }
        all.extend(facts.slave.assumption().map(Unknown::AssumedNumbers));
        all
    }

    /// What the file says otherwise than the line: the unit and the configuration. The line counts.
    #[must_use]
    pub fn contradictions(&self) -> Vec<Contradiction> {
        let Some((model, _)) = self.model() else { return Vec::new() };
        let Some(declared) = self.declared.filter(|declared| declared.model.name == model.name) else {
            return Vec::new();
        };
        let heard_unit = self.unit_code.and_then(|code| model.unit(code));
        let unit = declared.unit.zip(heard_unit).filter(|(file, line)| file.code != line.code);
        let unit = unit.map(|(file, line)| Contradiction::Unit { file: file.name, line: line.name });
        let heard = Some(&self.configuration).filter(|octets| !octets.is_empty());
        let configuration = declared.configuration.zip(heard).filter(|(file, line)| file.octets != line.as_slice());
        let configuration =
            configuration.map(|(file, line)| Contradiction::Configuration { file: file.octets, line: line.clone() });
        unit.into_iter().chain(configuration).collect()
    }

    fn fits(&self, configuration: &Configuration) -> bool {
        let length = |telegram: Option<&Telegram>| telegram.map_or(0, Telegram::octets);
        length(configuration.outputs) == self.outputs && length(configuration.inputs) == self.inputs.len()
    }

    /// The configurations of the model that fit the lengths of the exchange, the default one first.
    fn fitting(&self, model: &'static Model) -> impl Iterator<Item = &'static Configuration> {
        std::iter::once(model.default_configuration).chain(model.configurations).filter(|it| self.fits(it))
    }

    /// The configuration of the model, if no other one with these lengths divides the inputs and outputs into other fields: a slave accepts
    /// no configuration that its manual does not list.
    fn only_fitting(&self, model: &'static Model) -> Option<&'static Configuration> {
        let first = self.fitting(model).next()?;
        let is_equal = |other: &Configuration| {
            let layout = |telegram: Option<&'static Telegram>| telegram.map(|telegram| telegram.fields);
            layout(other.inputs) == layout(first.inputs) && layout(other.outputs) == layout(first.outputs)
        };
        self.fitting(model).all(is_equal).then_some(first)
    }

    /// The configuration of the model that fits the lengths of the exchange and whose contents are plausible.
    fn assumed(&self, model: &'static Model, unit: Option<&'static Unit>) -> Option<&'static Configuration> {
        let is_plausible = |configuration: &&'static Configuration| {
            let mut units = unit.into_iter().chain(usual_units(model).filter(|_| unit.is_none()));
            let slave =
                |unit| CyclicSlave { address: 0, model, configuration, unit, channels: ReportedChannels::default() };
            units.any(|unit| self.is_plausible(&slave(unit)))
        };
        self.fitting(model).find(is_plausible).or_else(|| self.fitting(model).next())
    }

    /// Whether the last inputs can be those of this slave: a selector that the model has, only defined status bits, and pressures, or
    /// their bounds, within the range of a gauge.
    fn is_plausible(&self, slave: &CyclicSlave) -> bool {
        let layout = slave.configuration.inputs.into_iter().flat_map(|telegram| telegram.layout());
        let is_allowed = |(start, field): (usize, Field)| {
            let octet = self.inputs.get(start).copied().unwrap_or_default();
            match field {
                Field::PvSelector => {
                    slave.model.parts.is_empty() || slave.model.parts.iter().any(|spec| spec.part.instance == octet)
                }
                Field::StatusExtension => StatusExtension::from_bits(octet).is_some(),
                Field::MeasurementStatus(_) => octet <= 6,
                Field::TtrValue => {
                    self.inputs.get(start..).and_then(TtrReading::decode).is_some_and(|reading| reading.is_defined)
                }
                _ => true,
            }
        };
        let values = slave.decode_inputs(&self.inputs).values;
        layout.into_iter().all(is_allowed)
            && values.iter().all(|value| {
                let mut parts = slave.model.parts.iter().filter(|spec| spec.part.instance == value.instance).peekable();
                let is_of_part = |limits: &Limits| can_be_within(value, limits.under_pa * 0.5, limits.over_pa * 2.0);
                // A controller accepts different gauges on a channel.
                let is_in_range = parts.peek().is_none() || parts.any(|spec| is_of_part(&spec.limits));
                can_be_within(value, LOWEST_PA, HIGHEST_PA) && is_in_range
            })
    }
}

/// Whether the pressure of a value can be in a range, in Pa. A bound decides one side: the pressure below it can be in a range that begins
/// below it, and the pressure above it in one that ends above it. A number that is no pressure is in none.
fn can_be_within(value: &ChannelValue, low_pa: f64, high_pa: f64) -> bool {
    let (is_below, is_above) = (value.quality == Quality::Underrange, value.quality == Quality::Overrange);
    match value.pa.or(value.limit_pa) {
        Some(pa) => (is_above || pa >= low_pa) && (is_below || pa <= high_pa),
        None => value.cause != Some(Cause::NoPressure),
    }
}

/// Whether the unit changes the meaning of the inputs: telegram 205 of the TTR compatibility mode has none.
fn has_unit(configuration: &Configuration) -> bool {
    let mut fields = configuration.inputs.into_iter().flat_map(|telegram| telegram.fields);
    !fields.any(|field| *field == Field::TtrValue)
}

/// Pressures outside are not those of a gauge, in Pa. chosen: wider than every measuring range of the twelve devices.
const LOWEST_PA: f64 = 1e-11;
const HIGHEST_PA: f64 = 3e5;

/// The units of a model, first mbar, the unit in which the twelve devices are delivered most often. chosen.
fn usual_units(model: &'static Model) -> impl Iterator<Item = &'static Unit> {
    model.unit_named("mbar").into_iter().chain(model.units)
}

#[cfg(test)]
mod tests {
    use super::*;
    use profivac_devices::catalog::model_named;

    /// The unit that is assumed for these inputs, and their only reading.
    fn assumed(device: &str, configuration: usize, outputs: usize, inputs: &[u8]) -> (&'static str, ChannelValue) {
        let model = model_named(device).unwrap();
        let configuration = Some(&model.configurations[configuration]);
        let mut knowledge = Knowledge::default();
        knowledge.declare(Declared { model, configuration, unit: None });
        knowledge.exchange(outputs, inputs, BitTime(0));
        let unit = knowledge.facts(5).unwrap().slave.unit.name;
        assert_eq!(knowledge.unknown(), [Unknown::AssumedUnit(unit)]);
        (unit, knowledge.reading(5).unwrap().values.values[0])
    }

    fn bcg450(part: u8, word: u16) -> (&'static str, Quality, Option<f64>) {
        let [high, low] = word.to_be_bytes();
        let inputs = [&[0; 8][..], &[0x80, 0, part, high, low]].concat();
        let (unit, value) = assumed("bcg450", 4, 8, &inputs);
        (unit, value.quality, value.limit_pa)
    }

    /// 32767 mbar or more is beyond every gauge, 32767 Micron or more is not. Micron is the first such unit of the tables, and its bound
    /// also holds in Pascal.
    #[test]
    fn no_unit_is_assumed_in_which_the_highest_integer_is_beyond_the_gauge() {
        const DIAPHRAGM: u8 = 3;
        assert_eq!(bcg450(DIAPHRAGM, 900), ("mbar", Quality::Valid, None));
        let (unit, quality, limit_pa) = bcg450(DIAPHRAGM, 32767);
        assert_eq!((unit, quality), ("Micron", Quality::Overrange));
        assert!((limit_pa.unwrap() / 4368.6 - 1.0).abs() < 1e-4, "{limit_pa:?}");
    }

    /// An integer in mbar is 0 in the whole range of an ion gauge: 0 bounds the pressure from above only.
    #[test]
    fn the_integer_0_of_every_part_is_below_one_mbar_and_no_fault() {
        for part in model_named("bcg450").unwrap().parts.iter().map(|spec| spec.part.instance) {
            let (unit, quality, limit_pa) = bcg450(part, 0);
            let context = format!("part {part}: {unit} {quality:?} {limit_pa:?}");
            // The range of the diaphragm ends above one mbar at most.
            assert!(unit == "mbar" && quality == Quality::Underrange, "{context}");
            assert!((limit_pa.unwrap() / 100.0 - 1.0).abs() < 1e-9, "{context}");
        }
    }

    /// Zeros that no gauge has filled fit no unit, so COUNTS, in which 0 is no pressure, fit not better.
    #[test]
    fn zeros_that_are_no_pressure_are_no_sign_of_counts() {
        let (unit, value) = assumed("bcg450", 4, 8, &[0; 13]);
        assert_eq!((unit, value.quality), ("mbar", Quality::Fault));
        // Telegram 5 of the IMG 400: with Exception Status a pressure below one unit, without it none.
        let model = model_named("img400").unwrap();
        let number =
            model.configurations.iter().position(|it| it.inputs.is_some_and(|inputs| inputs.number == 5)).unwrap();
        let outputs = model.configurations[number].output_octets();
        let mbar = model.unit_named("mbar").unwrap().name;
        let (unit, value) = assumed("img400", number, outputs, &[0; 9]);
        assert_eq!((unit, value.quality), (mbar, Quality::Fault));
        let (unit, value) = assumed("img400", number, outputs, &[0x80, 0, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!((unit, value.quality), (mbar, Quality::Underrange));
    }
}
