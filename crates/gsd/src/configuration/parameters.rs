//! The user parameters of Set_Prm.

use super::Configuration;
use crate::device::{Device, Module};
use crate::parameter::{DataType, MAX_USER_PRM, Parameter, PrmArea, PrmContent};
use crate::words;
use std::collections::BTreeMap;
use std::fmt;

/// Changed values by area (0 the station, then the modules) and item of the area.
#[derive(Clone, Debug, Default)]
pub(crate) struct Changes(BTreeMap<(usize, usize), i64>);

/// Where a parameter belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// The station.
    Station,
    /// The module in this slot.
    Slot(u32),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Station => f.write_str("the station"),
            Place::Slot(slot) => write!(f, "slot {slot}"),
        }
    }
}

/// A parameter to change. Place, offset and bit are needed only if several parameters have the name.
#[derive(Clone, Copy, Debug, Default)]
pub struct Target<'a> {
    /// Its name in the file; blanks at its ends do not count.
    pub name: &'a str,
    /// The station or a slot.
    pub place: Option<Place>,
    /// Its first octet within the parameters of this place.
    pub offset: Option<u8>,
    /// Its first bit, 0 to 7: parameters in one octet can have one name.
    pub bit: Option<u8>,
}

impl<'a> From<&'a str> for Target<'a> {
    fn from(name: &'a str) -> Self {
        Self { name, ..Self::default() }
    }
}

/// A parameter of a configuration with its place and value.
#[derive(Clone, Copy, Debug)]
pub struct PlacedParameter<'a> {
    /// The station or a slot.
    pub place: Place,
    /// Its first octet within the parameters of this place.
    pub offset: u8,
    /// Its definition.
    pub parameter: &'a Parameter,
    /// The value: the default or the change.
    pub value: i64,
    area: usize,
    item: usize,
}

impl PlacedParameter<'_> {
    /// Its place, as messages name it: `slot 1 offset 23 bits 2-3`.
    fn words(&self) -> String {
        let octet = format!("{} offset {}", self.place, self.offset);
        match self.parameter.kind {
            DataType::Bit(bit) => format!("{octet} bit {bit}"),
            DataType::BitArea(first, last) => format!("{octet} bits {first}-{last}"),
            _ => octet,
        }
    }
}

/// Why a parameter cannot be changed, or why there are no user parameters.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PrmError {
    /// No parameter has this name there.
    Unknown {
        /// The name.
        name: String,
        /// The parameters that can be changed there.
        possible: String,
    },
    /// The parameter is in other places only.
    Elsewhere {
        /// The name.
        name: String,
        /// Its places.
        possible: String,
    },
    /// Several parameters have this name.
    Ambiguous {
        /// The name.
        name: String,
        /// Their places.
        possible: String,
    },
    /// The parameter does not have this value.
    Value {
        /// The name.
        name: String,
        /// The value.
        value: String,
        /// The possible values.
        possible: String,
    },
    /// The parameter is the number of its slot.
    SlotNumber {
        /// The name.
        name: String,
        /// The slot.
        slot: u32,
    },
    /// The file says that the parameter cannot be changed.
    NotChangeable {
        /// The name.
        name: String,
    },
    /// A later line of the file puts other octets in the same place.
    Covered {
        /// The name.
        name: String,
        /// The line of the reference.
        line: usize,
    },
    /// The user parameters are longer than allowed.
    TooLong {
        /// Number of octets.
        octets: usize,
        /// Greatest number of octets.
        most: usize,
        /// Number of octets of the station alone.
        station: usize,
    },
}

impl fmt::Display for PrmError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown { name, possible } => write!(f, "no parameter {name}; there are {possible}"),
            Self::Elsewhere { name, possible } => write!(f, "{name} is not at this place; it is at {possible}"),
            Self::Ambiguous { name, possible } => {
                write!(f, "several parameters {name}; say slot, offset and first bit: {possible}")
            }
            Self::Value { name, value, possible } => write!(f, "{name} cannot be {value}; possible are {possible}"),
            Self::SlotNumber { name, slot } => {
                write!(f, "{name} is always the number of its slot, here {slot}; plug the module in another slot")
            }
            Self::NotChangeable { name } => write!(f, "the file does not let users change {name}"),
            Self::Covered { name, line } => {
                write!(
                    f,
                    "{name} cannot be changed: a definition behind line {line} of the file writes the same octets"
                )
            }
            Self::TooLong { most, station, .. } if station > most => write!(
                f,
                "the parameters of the station alone have {station} octets, and at most {most} are possible, so no choice of modules helps; \
                 correct Max_User_Prm_Data_Len or the offsets in a copy of the file, or ask the vendor for another one"
            ),
            Self::TooLong { octets, most, .. } => {
                write!(f, "{octets} octets of user parameters; at most {most} are possible; choose fewer modules")
            }
        }
    }
}

impl std::error::Error for PrmError {}

impl<'a> Configuration<'a> {
    /// The user parameters of Set_Prm, from octet 7 on: first the parameters of the station, then of each module by slot.
    ///
    /// Ext_User_Prm_Data replace User_Prm_Data as a whole. On a DP-V1 slave the first three octets are the DP-V1 status, as the file
    /// gives them. The parameters for PROFIsafe are left out. A parameter `[SlotNumber]` of a module is the number of its slot.
    ///
    /// # Errors
    ///
    /// [`PrmError::TooLong`] if there are more octets than the file or the protocol allows.
    pub fn user_prm(&self) -> Result<Vec<u8>, PrmError> {
        let parts: Vec<_> = self.user_prm_by_place().map(|(_, octets)| octets).collect();
        let station = parts.first().map_or(0, Vec::len);
        let octets = parts.concat();
        let most = self.device.general.max_user_prm_data_len.and_then(|most| usize::try_from(most).ok());
        let most = most.unwrap_or(MAX_USER_PRM).min(MAX_USER_PRM);
        if octets.len() > most {
            return Err(PrmError::TooLong { octets: octets.len(), most, station });
        }
        Ok(octets)
    }

    /// The parts of the user parameters: the octets of the station, then of each module by slot.
    pub fn user_prm_by_place(&self) -> impl Iterator<Item = (Place, Vec<u8>)> + use<'a, '_> {
        self.areas().map(|(index, place, area)| (place, self.octets_of(index, place, area)))
    }

    /// The parameters of the station and of the modules, in the order of their octets' definitions.
    #[must_use]
    pub fn parameters(&self) -> Vec<PlacedParameter<'a>> {
        self.areas().flat_map(|(area, place, content)| self.placed(area, place, content)).collect()
    }

    /// Changes a parameter: a number, or the file's text for a value. chosen: a text counts before a number.
    ///
    /// # Errors
    ///
    /// [`PrmError`] says which parameters or values are possible.
    pub fn set<'t>(&mut self, target: impl Into<Target<'t>>, value: &str) -> Result<(), PrmError> {
        let target = target.into();
        let found = self.find(&target)?;
        let name = || found.parameter.name.clone();
        if let Some(slot) = slot_number(found.place, found.parameter) {
            return Err(PrmError::SlotNumber { name: name(), slot });
        }
        if !found.parameter.changeable {
            return Err(PrmError::NotChangeable { name: name() });
        }
        let number = value_of(self.device, found.parameter, value)?;
        let before = self.changes.0.insert((found.area, found.item), number);
        if self.sent(&found) == Some(number) {
            return Ok(());
        }
        match before {
            Some(before) => self.changes.0.insert((found.area, found.item), before),
            None => self.changes.0.remove(&(found.area, found.item)),
        };
        let line = self.area(found.area).and_then(|area| area.items.get(found.item)).map_or(0, |item| item.line);
        Err(PrmError::Covered { name: name(), line })
    }

    fn area(&self, index: usize) -> Option<&'a PrmArea> {
        self.areas().nth(index).map(|(_, _, area)| area)
    }

    /// The value of a parameter in the octets.
    fn sent(&self, placed: &PlacedParameter<'_>) -> Option<i64> {
        let octets = self.octets_of(placed.area, placed.place, self.area(placed.area)?);
        placed.parameter.kind.get(octets.get(usize::from(placed.offset)..)?)
    }

    fn areas(&self) -> impl Iterator<Item = (usize, Place, &'a PrmArea)> + use<'a, '_> {
        let station = std::iter::once((Place::Station, &self.device.prm));
        let modules = self.plugged.iter().map(|plugged| (Place::Slot(plugged.slot), &plugged.module.prm));
        station.chain(modules).enumerate().map(|(index, (place, area))| (index, place, area))
    }

    fn octets_of(&self, index: usize, place: Place, area: &PrmArea) -> Vec<u8> {
        self.device.octets_of(place, area, |item, parameter| self.value(index, place, item, parameter))
    }

    /// The number of the slot, the change or the default.
    fn value(&self, area: usize, place: Place, item: usize, parameter: &Parameter) -> i64 {
        let changed = || self.changes.0.get(&(area, item)).copied().unwrap_or(parameter.default);
        slot_number(place, parameter).map_or_else(changed, i64::from)
    }

    fn placed(&self, area: usize, place: Place, content: &'a PrmArea) -> Vec<PlacedParameter<'a>> {
        let one = |(item, definition): (usize, &'a crate::parameter::PrmItem)| {
            let PrmContent::Ref(number) = definition.content else { return None };
            let parameter = self.device.parameters.get(&number)?;
            let value = self.value(area, place, item, parameter);
            Some(PlacedParameter { place, offset: definition.offset, parameter, value, area, item })
        };
        content.items.iter().enumerate().filter_map(one).collect()
    }

    fn find(&self, target: &Target<'_>) -> Result<PlacedParameter<'a>, PrmError> {
        let name = target.name.trim();
        let there = |one: &PlacedParameter<'_>| {
            target.place.is_none_or(|place| place == one.place)
                && target.offset.is_none_or(|offset| offset == one.offset)
                && target.bit.is_none_or(|bit| bit == one.parameter.kind.first_bit())
        };
        let all = self.parameters();
        let found: Vec<_> = all.iter().filter(|one| one.parameter.name == name && there(one)).copied().collect();
        match found.as_slice() {
            [only] => Ok(*only),
            [] if all.iter().any(|one| one.parameter.name == name) => {
                let same = all.iter().filter(|one| one.parameter.name == name);
                Err(PrmError::Elsewhere {
                    name: name.to_owned(),
                    possible: words::list(same.map(PlacedParameter::words)),
                })
            }
            [] => {
                let possible: std::collections::BTreeSet<_> =
                    all.iter().map(|one| one.parameter.name.clone()).collect();
                Err(PrmError::Unknown { name: name.to_owned(), possible: words::list(possible.into_iter()) })
            }
            several => Err(PrmError::Ambiguous {
                name: name.to_owned(),
                possible: words::list(several.iter().map(PlacedParameter::words)),
            }),
        }
    }
}

impl Device {
    /// The user parameters of the station with the defaults of the file: octets 7 and following of Set_Prm, before those of the modules.
    #[must_use]
    pub fn default_user_prm(&self) -> Vec<u8> {
        self.octets_of(Place::Station, &self.prm, |_, parameter| parameter.default)
    }

    /// The user parameters that a module adds, with the defaults of the file. chosen: a parameter `[SlotNumber]` has its default too,
    /// because the module is in no slot.
    #[must_use]
    pub fn default_module_prm(&self, module: &Module) -> Vec<u8> {
        module.prm.octets(&self.parameters, |_, parameter| parameter.default)
    }

    fn octets_of(&self, place: Place, area: &PrmArea, value: impl Fn(usize, &Parameter) -> i64) -> Vec<u8> {
        if place == Place::Station && area.items.is_empty() {
            return plain(self);
        }
        area.octets(&self.parameters, value)
    }
}

/// The slot if the parameter stands for its number. chosen: of the station it is a parameter like others, because it has no slot.
pub(crate) fn slot_number(place: Place, parameter: &Parameter) -> Option<u32> {
    match place {
        Place::Slot(slot) if parameter.is_slot_number() => Some(slot),
        _ => None,
    }
}

/// User_Prm_Data, as long as User_Prm_Data_Len says.
pub(crate) fn plain(device: &Device) -> Vec<u8> {
    let mut octets = device.user_prm_data.clone().unwrap_or_default();
    if let Some(length) = device.general.user_prm_data_len.and_then(|length| usize::try_from(length).ok()) {
        octets.resize(length.min(MAX_USER_PRM), 0);
    }
    octets
}

/// The value that a user means, if the parameter may have it.
fn value_of(device: &Device, parameter: &Parameter, value: &str) -> Result<i64, PrmError> {
    let texts = parameter.texts.and_then(|number| device.texts.get(&number)).into_iter().flat_map(|texts| &texts.texts);
    let wanted = value.trim();
    let named = texts.filter(|(number, text)| text.trim() == wanted && parameter.allows(**number));
    let named: std::collections::BTreeSet<i64> = named.map(|(number, _)| *number).collect();
    let number = match named.len() {
        0 => number(wanted).filter(|number| parameter.allows(*number)),
        1 => named.first().copied(),
        // One text for several values: the number says which.
        _ => None,
    };
    number.ok_or_else(|| PrmError::Value {
        name: parameter.name.clone(),
        value: value.to_owned(),
        possible: device.values_of(parameter),
    })
}

fn number(text: &str) -> Option<i64> {
    match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        Some(digits) => i64::from_str_radix(digits, 16).ok().filter(|value| *value >= 0),
        None => text.parse().ok(),
    }
}
