//! User parameters of a Set_Prm back to named values.

use crate::configuration::{Place, plain, slot_number};
use crate::device::{Device, Module};
use crate::fit::{Fit, FittedSlot};
use crate::parameter::{DataType, Parameter, PrmArea, PrmContent, PrmDefinition, PrmItem};
use crate::words::list;
use profivac_wire::prm::{Dpv1Status1, Dpv1Status2, Dpv1Status3};
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::fmt;

/// The user parameters of a Set_Prm in the words of the file.
///
/// ```
/// use profivac_gsd::{Fit, GsdFile};
///
/// let file = GsdFile::read(b"#Profibus_DP
/// Ident_Number = 0x1234
/// PrmText = 1
/// Text(0) = \"opens\"
/// Text(1) = \"closes\"
/// EndPrmText
/// ExtUserPrmData = 1 \"Valve without bus\"
/// Bit(0) 0 0-1
/// Prm_Text_Ref = 1
/// EndExtUserPrmData
/// Ext_User_Prm_Data_Const(0) = 0x00,0x10
/// Ext_User_Prm_Data_Ref(1) = 1
/// Module = \"valve\" 0x20
/// EndModule
/// ");
/// let reading = Fit::new(file.device(), &[0x20])?.read_prm(&[0x07, 0x11]);
/// assert_eq!(reading.values[0].to_string(), "Valve without bus = closes (1), default opens (0)");
/// assert_eq!(reading.differences[0].to_string(), "octet 0 is 07, the file has 00");
/// # Ok::<(), profivac_gsd::FitError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Reading<'a> {
    /// The parameters with their values, first of the station, then by slot, in the order of the file.
    pub values: Vec<ReadValue<'a>>,
    /// Octets that differ from the constants of the file, or that the file does not define.
    pub differences: Vec<Difference>,
    /// The modules whose parameters these are: where several have the same configuration octets, the first that fits best.
    pub modules: Vec<(u32, &'a Module)>,
    /// The number of octets that station and modules have by the file.
    pub expected: usize,
    /// The number of octets in Set_Prm.
    pub found: usize,
}

/// A parameter and its value in the octets.
#[derive(Clone, Debug)]
pub struct ReadValue<'a> {
    /// The station or a slot.
    pub place: Place,
    /// Its first octet in the user parameters, from 0.
    pub octet: usize,
    /// Its definition.
    pub parameter: &'a Parameter,
    /// The value.
    pub value: i64,
    /// The file's text for the value.
    pub text: Option<&'a str>,
    /// The value that the file gives: the default, or the number of the slot.
    pub usual: i64,
    /// The file's text for the usual value.
    pub usual_text: Option<&'a str>,
    /// The values that the file allows, if this one is not among them.
    pub possible: Option<String>,
    /// What the file defines later in the same bits, which counts: a name, or `a constant`.
    pub covered_by: Option<Cow<'a, str>>,
}

impl ReadValue<'_> {
    /// Whether the value is the usual one, or the bits belong to a later definition.
    #[must_use]
    pub fn is_usual(&self) -> bool {
        self.value == self.usual || self.covered_by.is_some()
    }
}

impl fmt::Display for ReadValue<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words = |value: i64, text: Option<&str>| {
            text.map_or_else(|| value.to_string(), |text| format!("{} ({value})", text.trim()))
        };
        write!(f, "{} = {}", self.parameter.name, words(self.value, self.text))?;
        if let Some(later) = &self.covered_by {
            return write!(f, ", but the file defines {later} in the same bits later, which counts");
        }
        if self.value != self.usual {
            let what = if slot_number(self.place, self.parameter).is_some() { "the slot is" } else { "default" };
            write!(f, ", {what} {}", words(self.usual, self.usual_text))?;
        }
        self.possible
            .as_ref()
            .map_or(Ok(()), |possible| write!(f, ", which the file does not allow: possible are {possible}"))
    }
}

/// An octet that is not as the file says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The station or a slot.
    pub place: Place,
    /// The octet in the user parameters, from 0.
    pub octet: usize,
    /// The octet in Set_Prm.
    pub found: u8,
    /// The octet with the constants of the file in place of the bits that differ; `None` if the file defines nothing there.
    pub expected: Option<u8>,
    /// The octet is one of the three DP-V1 status octets, which a master changes.
    pub is_dpv1_status: bool,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { octet, found, .. } = self;
        match self.expected {
            None => write!(f, "octet {octet} is {found:02X}, the file defines nothing there"),
            Some(expected) if self.is_dpv1_status => {
                write!(
                    f,
                    "DP-V1 status octet {}: {}",
                    octet.saturating_add(1),
                    status_changes(*octet, expected, *found)
                )
            }
            Some(expected) => write!(f, "octet {octet} is {found:02X}, the file has {expected:02X}"),
        }
    }
}

/// The bits of a DP-V1 status octet that a master has changed: `DPV1_ENABLE on, FAIL_SAFE off`.
fn status_changes(octet: usize, before: u8, now: u8) -> String {
    let on = dpv1_status_bits(octet, now & !before).into_iter().map(|name| format!("{name} on"));
    let off = dpv1_status_bits(octet, before & !now).into_iter().map(|name| format!("{name} off"));
    let mut changes: Vec<_> = on.chain(off).collect();
    let alarms = Dpv1Status3::ALARM_MODE.bits();
    if octet == 2 && (before ^ now) & alarms != 0 {
        changes.push(format!("ALARM_MODE {}", now & alarms));
    }
    changes.join(", ")
}

/// The names of the bits in a DP-V1 status octet, the first one with the number 0. Reserved bits and the number of alarms have no name.
#[must_use]
pub fn dpv1_status_bits(octet: usize, bits: u8) -> Vec<&'static str> {
    match octet {
        0 => Dpv1Status1::from_bits_retain(bits).iter_names().map(|(name, _)| name).collect(),
        1 => Dpv1Status2::from_bits_retain(bits).iter_names().map(|(name, _)| name).collect(),
        _ => {
            let third = Dpv1Status3::from_bits_retain(bits).difference(Dpv1Status3::ALARM_MODE);
            third.iter_names().map(|(name, _)| name).collect()
        }
    }
}

impl Device {
    /// The user parameters of a Set_Prm as far as the station defines them: the modules, and so their parameters, are not known.
    #[must_use]
    pub fn read_station_prm(&self, user: &[u8]) -> Reading<'_> {
        let mut reading = Reading { found: user.len(), ..Reading::default() };
        reading.add(self, Part::station(self), user);
        reading
    }
}

impl<'a> Fit<'a> {
    /// The user parameters of a Set_Prm to these modules.
    ///
    /// Where several modules have the same configuration octets, the modules whose lengths and constants fit best are taken. Of very many
    /// modules with different parameters only the first ones of each slot are compared.
    #[must_use]
    pub fn read_prm(&self, user: &[u8]) -> Reading<'a> {
        let mut reading = Reading { found: user.len(), ..Reading::default() };
        let station = Part::station(self.device);
        let start = station.length();
        reading.add(self.device, station, user);
        for (slot, module) in self.modules_by_prm(user, start) {
            reading.modules.push((slot, module));
            reading.add(self.device, Part::module(self.device, slot, module), user);
        }
        reading.add_rest(user);
        reading
    }

    /// For each slot the module whose parameters fit best: the total length first, then the fewest octets that differ from constants, then
    /// the fewest values that are not allowed, then the fewest that are not the usual ones.
    fn modules_by_prm(&self, user: &[u8], start: usize) -> Vec<(u32, &'a Module)> {
        let most = MAX_COMPARED.checked_div(self.slots.len()).unwrap_or(1).max(1);
        let mut definitions = Definitions::default();
        let mut ways: Ways<'a> =
            BTreeMap::from([(start, Way { misfit: Misfit::default(), from: start, module: None })]);
        let mut before: Vec<Ways<'a>> = Vec::new();
        for slot in &self.slots {
            let next = self.ways_behind(slot.slot, &definitions.of(slot, most), &ways, user);
            before.push(std::mem::replace(&mut ways, next));
        }
        let best = ways.iter().min_by_key(|(end, way)| (end.abs_diff(user.len()), way.misfit));
        let mut way = best.map(|(_, way)| *way);
        let mut modules = Vec::new();
        for (slot, ways) in self.slots.iter().zip(&before).rev() {
            modules.extend(way.and_then(|way| Some((slot.slot, way.module?))));
            way = way.and_then(|way| ways.get(&way.from).copied());
        }
        modules.reverse();
        modules
    }

    /// The ways behind a slot that has one of these modules.
    fn ways_behind(&self, slot: u32, modules: &[&'a Module], ways: &Ways<'a>, user: &[u8]) -> Ways<'a> {
        let mut next: Ways<'a> = BTreeMap::new();
        for module in modules {
            let part = Part::module(self.device, slot, module);
            for (at, way) in ways {
                let octets = user.get((*at).min(user.len())..).unwrap_or_default();
                let misfit = way.misfit.plus(part.misfit(self.device, octets));
                let end = at.saturating_add(part.length());
                if next.get(&end).is_none_or(|before| misfit < before.misfit) {
                    next.insert(end, Way { misfit, from: *at, module: Some(module) });
                }
            }
        }
        // Beyond the octets only the shortest way is of use.
        let beyond = next.keys().copied().find(|end| *end > user.len());
        next.retain(|end, _| beyond.is_none_or(|beyond| *end <= beyond));
        next
    }
}

/// The greatest number of modules with different parameters that are compared with a Set_Prm, in all slots together. chosen: slots of the
/// largest known files have some ten.
const MAX_COMPARED: usize = 2_048;

/// How the user parameters can be divided up to a slot, by the end of its part.
type Ways<'a> = BTreeMap<usize, Way<'a>>;

/// The best way to one end.
#[derive(Clone, Copy)]
struct Way<'a> {
    misfit: Misfit,
    /// The end of the part of the slot before.
    from: usize,
    module: Option<&'a Module>,
}

/// Modules by the definition of their parameters: equal ones fit equally well.
#[derive(Default)]
struct Definitions<'a> {
    numbers: HashMap<PrmDefinition<'a>, usize>,
    by_module: HashMap<*const Module, usize>,
}

impl<'a> Definitions<'a> {
    /// The first module of each definition, at most `most` of them.
    fn of(&mut self, slot: &FittedSlot<'a>, most: usize) -> Vec<&'a Module> {
        let mut seen = HashSet::new();
        slot.modules.iter().copied().filter(|module| seen.insert(self.number(module))).take(most).collect()
    }

    fn number(&mut self, module: &'a Module) -> usize {
        let numbers = &mut self.numbers;
        *self.by_module.entry(std::ptr::from_ref(module)).or_insert_with(|| {
            let next = numbers.len();
            *numbers.entry(module.prm.definition()).or_insert(next)
        })
    }
}

impl<'a> Reading<'a> {
    /// Whether Set_Prm is as long as the file says.
    #[must_use]
    pub fn has_right_length(&self) -> bool {
        self.expected == self.found
    }

    fn add(&mut self, device: &'a Device, part: Part<'a>, user: &[u8]) {
        let start = self.expected;
        let octets = user.get(start.min(user.len())..).unwrap_or_default();
        let values =
            part.values(device, octets).into_iter().map(|Value { offset, parameter, value, usual, later }| ReadValue {
                place: part.place,
                octet: start.saturating_add(offset),
                parameter,
                value,
                text: device.text_of(parameter, value),
                usual,
                usual_text: device.text_of(parameter, usual),
                possible: (!is_allowed(parameter, value, usual)).then(|| ranges(parameter)),
                covered_by: later.map(|later| what(device, &part.area, later)),
            });
        self.values.extend(values);
        let is_dpv1 = device.general.dpv1_slave == Some(true) && part.place == Place::Station;
        for (octet, found, expected) in part.differences(octets) {
            self.differences.push(Difference {
                place: part.place,
                octet: start.saturating_add(octet),
                found,
                expected,
                is_dpv1_status: is_dpv1 && octet < 3,
            });
        }
        self.expected = start.saturating_add(part.length());
    }

    /// The octets behind the last module.
    fn add_rest(&mut self, user: &[u8]) {
        let place = self.modules.last().map_or(Place::Station, |(slot, _)| Place::Slot(*slot));
        let rest = user.iter().enumerate().skip(self.expected);
        self.differences.extend(rest.map(|(octet, found)| Difference {
            place,
            octet,
            found: *found,
            expected: None,
            is_dpv1_status: false,
        }));
    }
}

/// How badly octets fit a definition: octets that differ from constants, values that are not allowed, values that are not the usual ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Misfit(usize, usize, usize);

impl Misfit {
    fn plus(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0), self.1.saturating_add(other.1), self.2.saturating_add(other.2))
    }
}

/// A parameter in octets.
struct Value<'a> {
    /// Its first octet within the part.
    offset: usize,
    parameter: &'a Parameter,
    value: i64,
    usual: i64,
    /// The item that is defined later in the same bits.
    later: Option<usize>,
}

/// The allowed values as ranges: `1 to 63`. Their texts would make a sentence of a telegram too long.
fn ranges(parameter: &Parameter) -> String {
    let mut allowed =
        if parameter.allowed.is_empty() { vec![parameter.kind.limits()] } else { parameter.allowed.clone() };
    allowed.sort_unstable();
    let mut ranges: Vec<(i64, i64)> = Vec::new();
    for (low, high) in allowed {
        match ranges.last_mut() {
            Some((_, last)) if low <= last.saturating_add(1) => *last = high.max(*last),
            _ => ranges.push((low, high)),
        }
    }
    list(ranges.iter().map(|(low, high)| if low == high { low.to_string() } else { format!("{low} to {high}") }))
}

/// A default is right even where the file does not list it.
fn is_allowed(parameter: &Parameter, value: i64, usual: i64) -> bool {
    parameter.allows(value) || value == usual
}

/// The definition of the octets of the station or of a slot.
struct Part<'a> {
    place: Place,
    area: Cow<'a, PrmArea>,
    /// The octets with the usual values.
    usual: Vec<u8>,
    /// For each bit the item that counts: the last one.
    owners: Vec<[Option<usize>; 8]>,
}

impl<'a> Part<'a> {
    /// Ext_User_Prm_Data, or User_Prm_Data as one constant.
    fn station(device: &'a Device) -> Self {
        if device.prm.items.is_empty() {
            let content = PrmContent::Const(plain(device));
            let area = PrmArea { length: None, items: vec![PrmItem { offset: 0, content, line: 0 }] };
            return Self::new(device, Place::Station, Cow::Owned(area));
        }
        Self::new(device, Place::Station, Cow::Borrowed(&device.prm))
    }

    fn module(device: &'a Device, slot: u32, module: &'a Module) -> Self {
        Self::new(device, Place::Slot(slot), Cow::Borrowed(&module.prm))
    }

    fn new(device: &Device, place: Place, area: Cow<'a, PrmArea>) -> Self {
        let usual = |_, parameter: &Parameter| slot_number(place, parameter).map_or(parameter.default, i64::from);
        let usual = area.octets(&device.parameters, usual);
        let owners = owners(device, &area, usual.len());
        Self { place, area, usual, owners }
    }

    fn length(&self) -> usize {
        self.usual.len()
    }

    fn values<'d>(&self, device: &'d Device, octets: &[u8]) -> Vec<Value<'d>> {
        let items = self.area.items.iter().enumerate();
        items
            .filter_map(|(index, item)| {
                let PrmContent::Ref(number) = item.content else { return None };
                let parameter = device.parameters.get(&number)?;
                let offset = usize::from(item.offset);
                let value = parameter.kind.get(octets.get(offset..)?)?;
                let usual = slot_number(self.place, parameter).map_or(parameter.default, i64::from);
                let later = bits(parameter, offset).filter_map(|(octet, bit)| owner(&self.owners, octet, bit));
                let later = later.filter(|owner| *owner > index).max();
                Some(Value { offset, parameter, value, usual, later })
            })
            .collect()
    }

    fn misfit(&self, device: &Device, octets: &[u8]) -> Misfit {
        let values = self.values(device, octets);
        let counting = || values.iter().filter(|one| one.later.is_none());
        let refused = counting().filter(|one| !is_allowed(one.parameter, one.value, one.usual)).count();
        let changed = counting().filter(|one| one.value != one.usual).count();
        Misfit(self.differences(octets).len(), refused, changed)
    }

    /// The octets whose constant bits differ, or that are not 0 although nothing is defined there: their place within the part, the
    /// octet, and the octet with the constants.
    fn differences(&self, octets: &[u8]) -> Vec<(usize, u8, Option<u8>)> {
        let is_constant = |owner: &Option<usize>| {
            let item = owner.and_then(|owner| self.area.items.get(owner));
            item.is_none_or(|item| matches!(item.content, PrmContent::Const(_)))
        };
        let both = octets.iter().zip(&self.usual).zip(&self.owners).enumerate();
        both.filter_map(|(octet, ((found, usual), owners))| {
            let constant = (0..8_u32).zip(owners).filter(|(_, owner)| is_constant(owner));
            let mask = constant.fold(0_u8, |mask, (bit, _)| mask | 1_u8.wrapping_shl(bit));
            let expected = (found & !mask) | (usual & mask);
            let is_defined = owners.iter().any(Option::is_some);
            (expected != *found).then_some((octet, *found, is_defined.then_some(expected)))
        })
        .collect()
    }
}

/// The item that counts for each bit of an area: the last one.
fn owners(device: &Device, area: &PrmArea, length: usize) -> Vec<[Option<usize>; 8]> {
    let mut owners = vec![[None; 8]; length];
    for (index, item) in area.items.iter().enumerate() {
        let offset = usize::from(item.offset);
        let mut own = |octet: usize, bit: usize| {
            if let Some(owner) = owners.get_mut(octet).and_then(|octet| octet.get_mut(bit)) {
                *owner = Some(index);
            }
        };
        match &item.content {
            PrmContent::Const(constant) => {
                let octets = offset..offset.saturating_add(constant.len());
                octets.for_each(|octet| (0..8).for_each(|bit| own(octet, bit)));
            }
            PrmContent::Ref(number) => {
                if let Some(parameter) = device.parameters.get(number) {
                    bits(parameter, offset).for_each(|(octet, bit)| own(octet, bit));
                }
            }
        }
    }
    owners
}

/// The bits of a parameter: octet of the part and bit.
fn bits(parameter: &Parameter, offset: usize) -> impl Iterator<Item = (usize, usize)> + use<> {
    let octets = offset..offset.saturating_add(parameter.kind.octets());
    let (first, count) = match parameter.kind {
        kind @ (DataType::Bit(_) | DataType::BitArea(..)) => {
            (usize::from(kind.first_bit()), usize::try_from(kind.bits()).unwrap_or(8))
        }
        _ => (0, 8),
    };
    octets.flat_map(move |octet| (first..first.saturating_add(count).min(8)).map(move |bit| (octet, bit)))
}

fn owner(owners: &[[Option<usize>; 8]], octet: usize, bit: usize) -> Option<usize> {
    *owners.get(octet)?.get(bit)?
}

/// The name of an item, for messages.
fn what<'a>(device: &'a Device, area: &PrmArea, item: usize) -> Cow<'a, str> {
    let content = area.items.get(item).map(|item| &item.content);
    let parameter = match content {
        Some(PrmContent::Ref(number)) => device.parameters.get(number),
        _ => None,
    };
    parameter.map_or(Cow::Borrowed("a constant"), |parameter| Cow::Borrowed(parameter.name.as_str()))
}
