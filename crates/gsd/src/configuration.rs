//! Modules in their slots: the octets of Chk_Cfg, and whose identifier is meant.

mod parameters;

pub use parameters::{Place, PlacedParameter, PrmError, Target};
pub(crate) use parameters::{plain, slot_number};

use crate::alarm::Alarm;
use crate::device::{Device, Module, Slot};
use crate::parameter::{Parameter, PrmArea};
use parameters::Changes;
use profivac_wire::cfg::{Area, Identifiers};
use profivac_wire::prm::Dpv1Status2;
use std::fmt;

/// The longest Chk_Cfg, profibus-wire 2.6.
const MAX_CHK_CFG: usize = 244;

/// The greatest number of octets in one direction, profibus-wire 2.6.
const MAX_DATA: usize = 244;

/// Modules in their slots, with changed parameters.
///
/// ```
/// use profivac_gsd::{Configuration, GsdFile};
///
/// let file = GsdFile::read(b"#Profibus_DP
/// Ident_Number = 0x1234
/// Modular_Station = 1
/// Max_Module = 2
/// Module = \"valve\" 0x20
/// 5
/// EndModule
/// Module = \"switch\" 0x10
/// 7
/// EndModule
/// ");
/// let configuration = Configuration::new(file.device(), &[7, 5])?;
/// assert_eq!(configuration.chk_cfg(), [0x10, 0x20]);
///
/// let error = Configuration::new(file.device(), &[6]).unwrap_err();
/// assert_eq!(error.to_string(), "the file has no module 6; it has 5 (valve), 7 (switch)");
/// # Ok::<(), profivac_gsd::ConfigurationError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Configuration<'a> {
    pub(crate) device: &'a Device,
    pub(crate) plugged: Vec<Plugged<'a>>,
    pub(crate) changes: Changes,
}

/// Modules and changes without the device: a program keeps them together with the file, and gets the configuration again with
/// [`Configuration::again`].
#[derive(Clone, Debug, Default)]
pub struct Chosen {
    /// Slots, and places of the modules in the file: numbers can occur twice.
    modules: Vec<(u32, usize)>,
    changes: Changes,
}

/// A module in its slot.
#[derive(Clone, Copy, Debug)]
pub struct Plugged<'a> {
    /// The number of the slot.
    pub slot: u32,
    /// The module.
    pub module: &'a Module,
}

/// What the octets of a configuration lack.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Warning {
    /// The module has parameters for PROFIsafe, and these are not among the user parameters.
    Safety {
        /// The number of the slot.
        slot: u32,
        /// The module.
        module: String,
    },
    /// The slave is DP-V1 and requires alarms that the second user parameter does not enable.
    Alarm {
        /// The slot of the module that requires them; `None` for the station.
        slot: Option<u32>,
        /// The module, or the station.
        what: String,
        /// The alarms.
        alarm: Alarm,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Safety { slot, module } => write!(
                f,
                "slot {slot}: {module} has parameters for PROFIsafe, which are not in the user parameters; take them from the safety controller"
            ),
            Self::Alarm { slot, what, alarm } => {
                if let Some(slot) = slot {
                    write!(f, "slot {slot}: ")?;
                }
                write!(
                    f,
                    "{what} requires {alarm}, which the second user parameter does not enable; set its bit {:02X}",
                    alarm.enable_bit()
                )
            }
        }
    }
}

/// Why modules are no configuration of the device.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ConfigurationError {
    /// No module of the file has this number.
    UnknownModule {
        /// The number.
        number: u32,
        /// The modules of the file.
        possible: String,
    },
    /// The slot does not take the module.
    Slot {
        /// The number of the slot.
        slot: u32,
        /// The module.
        module: String,
        /// The modules that the slot takes.
        possible: String,
    },
    /// No modules were given, and the file presets none.
    NoModule {
        /// The modules of the file.
        possible: String,
    },
    /// More modules than the station takes.
    TooManyModules {
        /// Number of given modules.
        given: usize,
        /// Greatest number of modules.
        most: usize,
    },
    /// A module that is always plugged is missing, or in another slot than its own.
    Fixed {
        /// The module.
        module: String,
        /// Its slot; none if the slots of the file say where it may be.
        slot: Option<u32>,
    },
    /// The station has no slot with this number.
    NoSlot {
        /// The number.
        slot: u32,
        /// The slots that it has by Max_Module; those of a SlotDefinition are slots too.
        first: u32,
        /// The last one.
        last: u32,
    },
    /// Two modules in one slot.
    SlotTwice {
        /// The number of the slot.
        slot: u32,
    },
    /// The module sends the number of its slot, and this number is not allowed.
    SlotNumber {
        /// The number of the slot.
        slot: u32,
        /// The module.
        module: String,
        /// The numbers of slots that are allowed.
        possible: String,
    },
    /// The modules have no identifiers, so that there is nothing to send in Chk_Cfg.
    NoIdentifier,
    /// More octets than the file or the protocol allows.
    TooLong {
        /// What is too long.
        what: &'static str,
        /// Number of octets.
        octets: usize,
        /// Greatest number of octets.
        most: usize,
    },
}

impl fmt::Display for ConfigurationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownModule { number, possible } => write!(f, "the file has no module {number}; it has {possible}"),
            Self::Slot { slot, module, possible } => {
                write!(f, "slot {slot} does not take {module}; it takes {possible}")
            }
            Self::NoModule { possible } => write!(f, "expected modules, and the file presets none; it has {possible}"),
            Self::TooManyModules { given, most: 1 } => write!(f, "{given} modules for a compact station; choose one"),
            Self::TooManyModules { given, most } => write!(f, "{given} modules; the station takes at most {most}"),
            Self::Fixed { module, slot: Some(slot) } => {
                write!(f, "{module} is always plugged, in slot {slot}; put it there")
            }
            Self::Fixed { module, slot: None } => write!(f, "{module} is always plugged; add it to the modules"),
            Self::NoSlot { slot, first, last } => {
                write!(f, "the station has no slot {slot}; by Max_Module it has the slots {first} to {last}")
            }
            Self::SlotTwice { slot } => write!(f, "two modules in slot {slot}; put one into another slot"),
            Self::SlotNumber { slot, module, possible } => {
                write!(f, "{module} sends the number of its slot, which cannot be {slot}; possible are {possible}")
            }
            Self::NoIdentifier => {
                f.write_str("the modules have no identifier, and Chk_Cfg needs one; choose a module that has")
            }
            Self::TooLong { what, octets, most } => {
                write!(f, "{octets} octets of {what}; at most {most} are possible; choose fewer modules")
            }
        }
    }
}

impl std::error::Error for ConfigurationError {}

impl<'a> Configuration<'a> {
    /// The modules with these numbers in the slots from the first on.
    ///
    /// # Errors
    ///
    /// [`ConfigurationError`] says which module or slot, and what is possible.
    pub fn new(device: &'a Device, numbers: &[u32]) -> Result<Self, ConfigurationError> {
        let module = |number: &u32| {
            let unknown =
                || ConfigurationError::UnknownModule { number: *number, possible: names(device.modules.iter()) };
            device.module(*number).ok_or_else(unknown)
        };
        Self::of(device, numbers.iter().map(module).collect::<Result<_, _>>()?)
    }

    /// These modules in the slots from the first on, for modules that share a number or were chosen by name.
    ///
    /// # Errors
    ///
    /// [`ConfigurationError`] says which module or slot, and what is possible.
    pub fn of(device: &'a Device, modules: Vec<&'a Module>) -> Result<Self, ConfigurationError> {
        let first = first_slot(device);
        Self::in_slots(device, (first..).zip(modules))
    }

    /// These modules in these slots, in any order: slots may be free. chosen: a free slot sends nothing, because files have modules for
    /// that.
    ///
    /// ```
    /// use profivac_gsd::{Configuration, GsdFile};
    ///
    /// let file = GsdFile::read(b"#Profibus_DP
    /// Ident_Number = 0x1234
    /// Modular_Station = 1
    /// Max_Module = 5
    /// Module = \"valve\" 0x20
    /// EndModule
    /// ");
    /// let valve = &file.device().modules[0];
    /// let configuration = Configuration::in_slots(file.device(), [1, 2, 5].map(|slot| (slot, valve)))?;
    /// assert_eq!(configuration.modules()[2].slot, 5);
    /// # Ok::<(), profivac_gsd::ConfigurationError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`ConfigurationError`] says which module or slot, and what is possible.
    pub fn in_slots(
        device: &'a Device,
        modules: impl IntoIterator<Item = (u32, &'a Module)>,
    ) -> Result<Self, ConfigurationError> {
        let mut plugged: Vec<_> = modules.into_iter().map(|(slot, module)| Plugged { slot, module }).collect();
        plugged.sort_by_key(|one| one.slot);
        let twice = plugged.windows(2).find_map(|pair| match pair {
            [one, other] if one.slot == other.slot => Some(one.slot),
            _ => None,
        });
        if let Some(slot) = twice {
            return Err(ConfigurationError::SlotTwice { slot });
        }
        let configuration = Self { device, plugged, changes: Changes::default() };
        configuration.check()?;
        Ok(configuration)
    }

    /// The modules that are plugged at first: the defaults of the slots, else the modules with Preset, else the only module.
    ///
    /// # Errors
    ///
    /// [`ConfigurationError::NoModule`] if the file does not say.
    pub fn preset(device: &'a Device) -> Result<Self, ConfigurationError> {
        let default = |slot: &'a Slot| device.module(slot.default).map(|module| (slot.number, module));
        let slots: Vec<_> = device.slots.values().filter_map(default).collect();
        if !slots.is_empty() && slots.len() == device.slots.len() {
            return Self::in_slots(device, slots);
        }
        let presets: Vec<_> = device.modules.iter().filter(|module| module.preset).collect();
        match (presets.is_empty(), device.modules.as_slice()) {
            (true, [only]) => Self::of(device, vec![only]),
            _ => Self::of(device, presets),
        }
    }

    /// The device whose modules are plugged.
    #[must_use]
    pub fn device(&self) -> &'a Device {
        self.device
    }

    /// The modules and changes, without the device.
    #[must_use]
    pub fn chosen(&self) -> Chosen {
        let place = |one: &Plugged<'_>| {
            let place = self.device.modules.iter().position(|module| std::ptr::eq(module, one.module));
            place.map(|place| (one.slot, place))
        };
        Chosen { modules: self.plugged.iter().filter_map(place).collect(), changes: self.changes.clone() }
    }

    /// The configuration whose modules and changes were kept. The device must be the same one: its modules are found by their places.
    #[must_use]
    pub fn again(device: &'a Device, chosen: &Chosen) -> Self {
        let plugged =
            |(slot, place): &(u32, usize)| device.modules.get(*place).map(|module| Plugged { slot: *slot, module });
        Self { device, plugged: chosen.modules.iter().filter_map(plugged).collect(), changes: chosen.changes.clone() }
    }

    /// The modules in their slots.
    #[must_use]
    pub fn modules(&self) -> &[Plugged<'a>] {
        &self.plugged
    }

    /// What the octets lack: the parameters of modules for PROFIsafe, and the bits of required alarms.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        let safe = self.plugged.iter().filter(|plugged| plugged.module.safety != PrmArea::default());
        let safe = safe.map(|plugged| Warning::Safety { slot: plugged.slot, module: name(plugged.module) });
        safe.chain(self.missing_alarms()).collect()
    }

    /// Required alarms that the second DP-V1 status octet does not enable.
    fn missing_alarms(&self) -> Vec<Warning> {
        let octets = match self.user_prm() {
            Ok(octets) if self.device.general.dpv1_slave == Some(true) => octets,
            _ => return Vec::new(),
        };
        let enabled = Dpv1Status2::from_bits_retain(octets.get(1).copied().unwrap_or(0));
        let station = (None, "the station".to_owned(), self.device.general.required_alarms());
        let module =
            |plugged: &Plugged<'_>| (Some(plugged.slot), name(plugged.module), plugged.module.alarms.required.clone());
        let all = std::iter::once(station).chain(self.plugged.iter().map(module));
        all.flat_map(|(slot, what, alarms)| {
            let missing = alarms.into_iter().filter(|alarm| !enabled.contains(alarm.enable_bit()));
            missing.map(move |alarm| Warning::Alarm { slot, what: what.clone(), alarm })
        })
        .collect()
    }

    /// The octets of Chk_Cfg: the identifiers of the modules, one after the other.
    #[must_use]
    pub fn chk_cfg(&self) -> Vec<u8> {
        self.plugged.iter().flat_map(|plugged| plugged.module.config.iter().copied()).collect()
    }

    /// The module of an identifier: diagnosis counts identifiers from 0, and a module has none, one or several.
    #[must_use]
    pub fn module_of_identifier(&self, identifier: usize) -> Option<&Plugged<'a>> {
        let mut count = 0_usize;
        self.plugged.iter().find(|plugged| {
            count = count.saturating_add(Identifiers::new(&plugged.module.config).count());
            identifier < count
        })
    }

    /// The file's text for a channel error of an identifier: the module's own text, else the text of the device.
    #[must_use]
    pub fn channel_text(&self, identifier: usize, error: u8) -> Option<&str> {
        let own = self.module_of_identifier(identifier).and_then(|plugged| plugged.module.diagnosis.channel(error));
        own.or_else(|| self.device.diagnosis.channel(error)).map(|words| words.text.as_str())
    }

    fn check(&self) -> Result<(), ConfigurationError> {
        let (given, most) = (self.plugged.len(), self.device.max_modules());
        if given == 0 {
            return Err(ConfigurationError::NoModule { possible: names(self.device.modules.iter()) });
        }
        if given > most {
            return Err(ConfigurationError::TooManyModules { given, most });
        }
        self.check_slots_exist(most)?;
        self.check_fixed()?;
        self.check_slots()?;
        self.check_slot_numbers()?;
        self.check_lengths()
    }

    fn check_slots_exist(&self, most: usize) -> Result<(), ConfigurationError> {
        let first = first_slot(self.device);
        let last = first.saturating_add(u32::try_from(most).unwrap_or(u32::MAX)).saturating_sub(1);
        let exists = |slot: &u32| (first..=last).contains(slot) || self.device.slots.contains_key(slot);
        match self.plugged.iter().map(|plugged| plugged.slot).find(|slot| !exists(slot)) {
            Some(slot) => Err(ConfigurationError::NoSlot { slot, first, last }),
            None => Ok(()),
        }
    }

    fn check_fixed(&self) -> Result<(), ConfigurationError> {
        if !is_fixed(self.device) {
            return Ok(());
        }
        let is_free = !self.device.slots.is_empty();
        let plugged = |fixed: &Module, slot: u32| {
            self.plugged.iter().any(|one| std::ptr::eq(one.module, fixed) && (is_free || one.slot == slot))
        };
        let fixed = self.device.modules.iter().filter(|module| module.preset);
        let missing = (first_slot(self.device)..).zip(fixed).find(|(slot, fixed)| !plugged(fixed, *slot));
        let error =
            |(slot, module)| ConfigurationError::Fixed { module: name(module), slot: (!is_free).then_some(slot) };
        missing.map_or(Ok(()), |missing| Err(error(missing)))
    }

    fn check_slots(&self) -> Result<(), ConfigurationError> {
        for Plugged { slot: number, module } in &self.plugged {
            let Some(slot) = self.device.slots.get(number).filter(|slot| !slot.allows(module.number)) else { continue };
            let possible = names(self.device.modules.iter().filter(|module| slot.allows(module.number)));
            return Err(ConfigurationError::Slot { slot: *number, module: name(module), possible });
        }
        Ok(())
    }

    fn check_slot_numbers(&self) -> Result<(), ConfigurationError> {
        for Plugged { slot, module } in &self.plugged {
            if let Some(parameter) = wrong_slot_number(self.device, *slot, module) {
                let possible = self.device.values_of(parameter);
                return Err(ConfigurationError::SlotNumber { slot: *slot, module: name(module), possible });
            }
        }
        Ok(())
    }

    fn check_lengths(&self) -> Result<(), ConfigurationError> {
        let octets = self.chk_cfg();
        if octets.is_empty() {
            return Err(ConfigurationError::NoIdentifier);
        }
        at_most("Chk_Cfg", octets.len(), MAX_CHK_CFG)?;
        let (inputs, outputs) = lengths(&octets);
        at_most("inputs", inputs, MAX_DATA)?;
        at_most("outputs", outputs, MAX_DATA)?;
        let general = &self.device.general;
        // Max_Input_Len and the others are keywords of modular stations.
        if !self.device.is_modular() {
            return Ok(());
        }
        let limit = |most: Option<u32>| most.and_then(|most| usize::try_from(most).ok()).unwrap_or(usize::MAX);
        at_most("inputs", inputs, limit(general.max_input_len))?;
        at_most("outputs", outputs, limit(general.max_output_len))?;
        at_most("inputs and outputs", inputs.saturating_add(outputs), limit(general.max_data_len))
    }
}

/// Octets of inputs and of outputs. An identifier that is cut counts nothing: the reader reports it, and its octets are sent as they are.
fn lengths(octets: &[u8]) -> (usize, usize) {
    let add = |sum: usize, area: Option<Area>| sum.saturating_add(area.map_or(0, |area| usize::from(area.octets())));
    Identifiers::new(octets)
        .flatten()
        .fold((0, 0), |(inputs, outputs), identifier| (add(inputs, identifier.input), add(outputs, identifier.output)))
}

/// chosen: slots count from 1, or from 0 if the file defines a slot 0.
pub(crate) fn first_slot(device: &Device) -> u32 {
    u32::from(!device.slots.contains_key(&0))
}

/// Whether the modules with Preset are always plugged.
pub(crate) fn is_fixed(device: &Device) -> bool {
    device.general.fix_preset_modules == Some(true) && device.is_modular()
}

/// Whether the module can send the number of this slot, if it sends one.
pub(crate) fn takes_slot_number(device: &Device, slot: u32, module: &Module) -> bool {
    wrong_slot_number(device, slot, module).is_none()
}

fn wrong_slot_number<'a>(device: &'a Device, slot: u32, module: &'a Module) -> Option<&'a Parameter> {
    device.parameters_of(&module.prm).find(|parameter| parameter.is_slot_number() && !parameter.allows(i64::from(slot)))
}

fn at_most(what: &'static str, octets: usize, most: usize) -> Result<(), ConfigurationError> {
    if octets > most { Err(ConfigurationError::TooLong { what, octets, most }) } else { Ok(()) }
}

pub(crate) fn name(module: &Module) -> String {
    format!("{} ({})", module.number, module.name)
}

/// The first twenty of the modules in words.
fn names<'a>(modules: impl Iterator<Item = &'a Module>) -> String {
    crate::words::list(modules.map(name))
}
