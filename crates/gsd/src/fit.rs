//! Configuration octets to the modules that give them: Chk_Cfg and Get_Cfg back to words.

use crate::configuration::{Configuration, ConfigurationError, first_slot, is_fixed, name, takes_slot_number};
use crate::device::{Device, Module, Slot};
use crate::reader::MAX_SLOT;
use crate::words::{hex, list};
use profivac_wire::cfg::{Area, CfgError, Identifiers, lengths};
use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;

/// The modules that give configuration octets, slot by slot.
///
/// ```
/// use profivac_gsd::{Fit, GsdFile};
///
/// let file = GsdFile::read(b"#Profibus_DP
/// Ident_Number = 0x1234
/// Modular_Station = 1
/// Max_Module = 4
/// Module = \"valve\" 0x20
/// EndModule
/// Module = \"valve HF\" 0x20
/// EndModule
/// Module = \"two switches\" 0x10, 0x10
/// EndModule
/// ");
/// let fit = Fit::new(file.device(), &[0x10, 0x10, 0x20])?;
/// let names = |slot: usize| fit.slots[slot].modules.iter().map(|module| module.name.as_str()).collect::<Vec<_>>();
/// assert_eq!((names(0), names(1)), (vec!["two switches"], vec!["valve", "valve HF"]));
/// # Ok::<(), profivac_gsd::FitError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Fit<'a> {
    pub(crate) device: &'a Device,
    /// The slots with a module, in their order.
    pub slots: Vec<FittedSlot<'a>>,
    /// Whether other modules, or modules in other slots, divide the same octets otherwise.
    pub has_other_division: bool,
    /// Whether a module without identifiers may be in another slot: the octets do not show it.
    pub may_hide_module: bool,
}

/// A slot, and the modules that may be in it: several modules can have the same configuration octets.
#[derive(Clone, Debug)]
pub struct FittedSlot<'a> {
    /// The number of the slot.
    pub slot: u32,
    /// Its octets in the configuration.
    pub config: Range<usize>,
    /// Its identifiers, counted from 0 as diagnosis does.
    pub identifiers: Range<usize>,
    /// Its octets in the inputs.
    pub inputs: Range<usize>,
    /// Its octets in the outputs.
    pub outputs: Range<usize>,
    /// The modules with these octets that the slot takes, at least one: first the default of the slot, then modules with Preset.
    pub modules: Vec<&'a Module>,
}

/// Why no modules of the file give the octets.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FitError {
    /// The octets are no list of identifiers.
    Octets(CfgError),
    /// No module that the slot takes begins with these octets.
    NoModule {
        /// The place of the first octet that belongs to no module, from 0.
        at: usize,
        /// The octets from there on.
        rest: Vec<u8>,
        /// The slot that is next.
        slot: u32,
        /// The modules that it takes.
        possible: String,
    },
    /// The octets are those of more modules than the station takes.
    TooManyModules {
        /// Number of modules.
        given: usize,
        /// Greatest number of modules.
        most: usize,
    },
}

impl fmt::Display for FitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Octets(error) => write!(f, "the configuration is no list of identifiers: {error}"),
            Self::NoModule { at, rest, slot, possible } => write!(
                f,
                "no module for slot {slot} begins with {} (configuration octet {}); the slot takes {possible}",
                hex(rest),
                at.saturating_add(1)
            ),
            Self::TooManyModules { given, most } => {
                write!(f, "the configuration has {given} modules; the station takes at most {most}")
            }
        }
    }
}

impl std::error::Error for FitError {}

impl<'a> Fit<'a> {
    /// The modules that give these octets. Where several divisions are possible, the one with the fewest free slots and modules.
    ///
    /// The work is bounded by the protocol: at most 244 octets in at most 255 slots.
    ///
    /// # Errors
    ///
    /// [`FitError`] says which octets belong to no module, and which modules are possible there.
    pub fn new(device: &'a Device, octets: &[u8]) -> Result<Self, FitError> {
        lengths(octets).map_err(FitError::Octets)?;
        let mut search = Search::new(device, octets);
        search.run();
        let (path, has_other_division) = search.path()?;
        let (given, most) = (path.len(), device.max_modules());
        if given > most {
            return Err(FitError::TooManyModules { given, most });
        }
        let may_hide_module = given < most && search.may_hide_module(&path);
        let mut fit = Self { device, slots: Vec::new(), has_other_division, may_hide_module };
        let mut counts = Counts::default();
        for (slot, config) in path {
            let modules = search.candidates(slot, &config);
            let before = counts;
            counts.add(octets.get(config.clone()).unwrap_or_default());
            fit.slots.push(FittedSlot::between(slot, config, before, counts, modules));
        }
        Ok(fit)
    }

    /// The modules of a configuration in their slots: each slot has the chosen module only.
    ///
    /// ```
    /// use profivac_gsd::{Configuration, Fit, GsdFile};
    ///
    /// let file = GsdFile::read(b"#Profibus_DP
    /// Ident_Number = 0x1234
    /// Modular_Station = 1
    /// Max_Module = 4
    /// Module = \"valve\" 0x20
    /// EndModule
    /// Module = \"valve HF\" 0x20
    /// EndModule
    /// ");
    /// let modules = &file.device().modules;
    /// let configuration = Configuration::in_slots(file.device(), [(1, &modules[1]), (2, &modules[0])])?;
    /// let fit = Fit::of(&configuration);
    /// assert_eq!((fit.slots[0].modules[0].name.as_str(), fit.slots[1].outputs.clone()), ("valve HF", 1..2));
    /// # Ok::<(), profivac_gsd::ConfigurationError>(())
    /// ```
    #[must_use]
    pub fn of(configuration: &Configuration<'a>) -> Self {
        let (mut at, mut counts) = (0_usize, Counts::default());
        let slots = configuration.modules().iter().map(|plugged| {
            let config = &plugged.module.config;
            let (before, first) = (counts, at);
            counts.add(config);
            at = at.saturating_add(config.len());
            FittedSlot::between(plugged.slot, first..at, before, counts, vec![plugged.module])
        });
        let slots = slots.collect();
        Self { device: configuration.device(), slots, has_other_division: false, may_hide_module: false }
    }

    /// The slot of an identifier. Diagnosis counts identifiers from 0, and a module has none, one or several.
    #[must_use]
    pub fn slot_of_identifier(&self, identifier: usize) -> Option<&FittedSlot<'a>> {
        self.slots.iter().find(|slot| slot.identifiers.contains(&identifier))
    }

    /// The slot with this number.
    #[must_use]
    pub fn slot(&self, number: u32) -> Option<&FittedSlot<'a>> {
        self.slots.iter().find(|slot| slot.slot == number)
    }

    /// The first possible module of each slot as a configuration.
    ///
    /// # Errors
    ///
    /// [`ConfigurationError`] if the file has a rule that these modules break, for instance a missing module that is always plugged.
    pub fn configuration(&self) -> Result<Configuration<'a>, ConfigurationError> {
        let first = self.slots.iter().filter_map(|slot| Some((slot.slot, *slot.modules.first()?)));
        Configuration::in_slots(self.device, first)
    }
}

impl<'a> FittedSlot<'a> {
    /// A slot between two counts.
    fn between(slot: u32, config: Range<usize>, from: Counts, to: Counts, modules: Vec<&'a Module>) -> Self {
        Self {
            slot,
            config,
            identifiers: from.identifiers..to.identifiers,
            inputs: from.inputs..to.inputs,
            outputs: from.outputs..to.outputs,
            modules,
        }
    }
}

/// Identifiers and octets of data so far.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    identifiers: usize,
    inputs: usize,
    outputs: usize,
}

impl Counts {
    fn add(&mut self, config: &[u8]) {
        let octets = |area: Option<Area>| area.map_or(0, |area| usize::from(area.octets()));
        for identifier in Identifiers::new(config).flatten() {
            self.identifiers = self.identifiers.saturating_add(1);
            self.inputs = self.inputs.saturating_add(octets(identifier.input));
            self.outputs = self.outputs.saturating_add(octets(identifier.output));
        }
    }
}

/// How the octets up to a place can be divided among the slots up to one.
#[derive(Clone, Copy, Debug)]
struct State {
    /// Free slots, then modules: the fewest.
    cost: (usize, usize),
    /// There is another division with as few free slots.
    has_other: bool,
    /// Octets in the slot before; `None` for a free slot.
    from: Option<usize>,
}

/// Slots with their octets.
type Path = Vec<(u32, Range<usize>)>;

struct Search<'a, 'o> {
    device: &'a Device,
    octets: &'o [u8],
    /// The modules by their octets.
    groups: Vec<Vec<&'a Module>>,
    /// By place: where the modules of a group that begin there end.
    matches: Vec<Vec<(usize, usize)>>,
    first: u32,
    /// The modules that are always plugged, in the first slots; empty if slot definitions say where they may be.
    fixed: Vec<&'a Module>,
    /// By slot from the first one, and by place in the octets.
    states: Vec<Vec<Option<State>>>,
    /// Number of modules that were compared with slots, to prove that the work is linear.
    steps: usize,
}

/// The modules that a slot takes by its definition.
struct Allowed {
    default: u32,
    /// In rising order, without overlaps.
    numbers: Vec<(u32, u32)>,
}

impl Allowed {
    fn of(slot: &Slot) -> Self {
        let mut all = slot.allowed.clone();
        all.sort_unstable();
        let mut numbers: Vec<(u32, u32)> = Vec::new();
        for (low, high) in all {
            match numbers.last_mut() {
                Some((_, last)) if low <= last.saturating_add(1) => *last = high.max(*last),
                _ => numbers.push((low, high)),
            }
        }
        Self { default: slot.default, numbers }
    }

    fn contains(&self, number: u32) -> bool {
        let behind = self.numbers.partition_point(|(low, _)| *low <= number);
        let within = behind.checked_sub(1).and_then(|place| self.numbers.get(place));
        number == self.default || within.is_some_and(|(_, high)| number <= *high)
    }
}

impl<'a, 'o> Search<'a, 'o> {
    fn new(device: &'a Device, octets: &'o [u8]) -> Self {
        let first = first_slot(device);
        let fixed: Vec<_> = if device.slots.is_empty() && is_fixed(device) {
            device.modules.iter().filter(|module| module.preset).collect()
        } else {
            Vec::new()
        };
        let defined = device.slots.keys().last().and_then(|last| usize::try_from(last.saturating_sub(first)).ok());
        let slots = defined.map_or(0, |last| last.saturating_add(1));
        let most = usize::try_from(MAX_SLOT.saturating_sub(first)).unwrap_or(0).saturating_add(1);
        let slots = slots.max(octets.len().saturating_add(fixed.len())).min(most);
        let states = vec![vec![None; octets.len().saturating_add(1)]; slots.saturating_add(1)];
        let (groups, matches) = matches(device, octets);
        Self { device, octets, groups, matches, first, fixed, states, steps: 0 }
    }

    fn number(&self, slot: usize) -> u32 {
        self.first.saturating_add(u32::try_from(slot).unwrap_or(u32::MAX))
    }

    fn run(&mut self) {
        self.reach(0, 0, State { cost: (0, 0), has_other: false, from: None });
        for slot in 0..self.states.len().saturating_sub(1) {
            let (allowed, has_silent) = (self.allowed(slot), self.silent(slot).is_some());
            let mut taken: Vec<Option<bool>> = vec![None; self.groups.len()];
            for at in 0..=self.octets.len() {
                let Some(State { cost: (free, modules), has_other, .. }) = self.state(slot, at) else { continue };
                let next = slot.saturating_add(1);
                if has_silent {
                    self.reach(next, at, State { cost: (free, modules), has_other, from: Some(0) });
                } else if self.can_be_free() {
                    self.reach(next, at, State { cost: (free.saturating_add(1), modules), has_other, from: None });
                }
                for (end, group) in self.matches.get(at).cloned().unwrap_or_default() {
                    let Some(known) = taken.get_mut(group) else { continue };
                    let is_taken = match *known {
                        Some(is_taken) => is_taken,
                        None => *known.insert(self.group_is_taken(slot, allowed.as_ref(), group)),
                    };
                    if is_taken {
                        let cost = (free, modules.saturating_add(1));
                        self.reach(next, end, State { cost, has_other, from: Some(end.saturating_sub(at)) });
                    }
                }
            }
        }
    }

    fn group_is_taken(&mut self, slot: usize, allowed: Option<&Allowed>, group: usize) -> bool {
        let modules = self.groups.get(group).map(Vec::as_slice).unwrap_or_default();
        let first = modules.iter().position(|module| self.slot_takes(slot, allowed, module));
        self.steps = self.steps.saturating_add(first.unwrap_or(modules.len()));
        first.is_some()
    }

    fn allowed(&self, slot: usize) -> Option<Allowed> {
        self.device.slots.get(&self.number(slot)).map(Allowed::of)
    }

    fn state(&self, slot: usize, at: usize) -> Option<State> {
        *self.states.get(slot)?.get(at)?
    }

    fn reach(&mut self, slot: usize, at: usize, new: State) {
        let Some(place) = self.states.get_mut(slot).and_then(|states| states.get_mut(at)) else { return };
        *place = Some(match *place {
            Some(old) if old.cost.0 == new.cost.0 => {
                let better = if new.cost < old.cost { new } else { old };
                State { has_other: true, ..better }
            }
            Some(old) if old.cost < new.cost => old,
            _ => new,
        });
    }

    /// The module without an identifier in a slot. chosen: one that is always plugged, or the default of the slot, because the octets do
    /// not show others.
    fn silent(&self, slot: usize) -> Option<&'a Module> {
        let default = || self.device.module(self.device.slots.get(&self.number(slot))?.default);
        let module = self.fixed.get(slot).copied().or_else(default);
        module.filter(|module| module.config.is_empty())
    }

    /// The modules without identifiers: their octets are the first of all.
    fn silent_modules(&self) -> &[&'a Module] {
        let first = self.groups.first().map(Vec::as_slice).unwrap_or_default();
        if first.iter().all(|module| module.config.is_empty()) { first } else { &[] }
    }

    /// Whether a slot without a module, or one behind the last, takes a module without identifiers.
    fn may_hide_module(&self, path: &Path) -> bool {
        let is_used = |number: u32| path.iter().any(|(used, _)| *used == number);
        let takes = |slot: usize| {
            let allowed = self.allowed(slot);
            let is_fixed = |module: &Module| self.fixed.iter().any(|fixed| std::ptr::eq(*fixed, module));
            let mut others = self.silent_modules().iter().filter(|module| !is_fixed(module));
            others.any(|module| self.slot_takes(slot, allowed.as_ref(), module))
        };
        let last = self.first.saturating_add(u32::try_from(self.device.max_modules()).unwrap_or(u32::MAX));
        (0..self.states.len()).any(|slot| {
            let number = self.number(slot);
            let exists = number < last || self.device.slots.contains_key(&number);
            number <= MAX_SLOT && exists && !is_used(number) && takes(slot)
        })
    }

    /// Whether slots can be free. chosen: without slot definitions modules stand side by side, because the octets show no gap.
    fn can_be_free(&self) -> bool {
        !self.device.slots.is_empty()
    }

    fn slot_takes(&self, slot: usize, allowed: Option<&Allowed>, module: &Module) -> bool {
        if let Some(fixed) = self.fixed.get(slot) {
            return std::ptr::eq(*fixed, module);
        }
        let is_allowed = allowed.is_none_or(|allowed| allowed.contains(module.number));
        is_allowed && takes_slot_number(self.device, self.number(slot), module)
    }

    /// The modules with these octets that the slot takes.
    fn candidates(&self, number: u32, config: &Range<usize>) -> Vec<&'a Module> {
        let slot = usize::try_from(number.saturating_sub(self.first)).unwrap_or(usize::MAX);
        let there = self.matches.get(config.start).and_then(|there| there.iter().find(|(end, _)| *end == config.end));
        let group = match config.is_empty() {
            true => self.silent_modules(),
            false => there.and_then(|(_, group)| self.groups.get(*group)).map(Vec::as_slice).unwrap_or_default(),
        };
        let allowed = self.allowed(slot);
        let mut modules: Vec<_> =
            group.iter().filter(|module| self.slot_takes(slot, allowed.as_ref(), module)).copied().collect();
        if modules.is_empty() && config.is_empty() {
            modules.extend(self.silent(slot));
        }
        let default = self.device.slots.get(&number).map(|slot| slot.default);
        modules.sort_by_key(|module| (default != Some(module.number), !module.preset));
        modules
    }

    /// The slots with their octets, and whether there is another division.
    fn path(&self) -> Result<(Path, bool), FitError> {
        let end = self.octets.len();
        let reached = |slot: &usize| self.state(*slot, end).map(|state| (state.cost, *slot));
        let ends: Vec<_> = (0..self.states.len()).filter_map(|slot| reached(&slot)).collect();
        // The fixed modules at the end of the list have no octets.
        let Some((cost, last)) = ends.iter().min().copied() else { return Err(self.no_module()) };
        let free = cost.0;
        let has_other = self.state(last, end).is_some_and(|state| state.has_other)
            || ends.iter().any(|(cost, slot)| *slot != last && cost.0 == free && self.ends_with_octets(*slot, end));
        let (mut path, mut at, mut slot) = (Vec::new(), end, last);
        while let (Some(state), Some(before)) = (self.state(slot, at), slot.checked_sub(1)) {
            if let Some(length) = state.from {
                let start = at.saturating_sub(length);
                path.push((self.number(before), start..at));
                at = start;
            }
            slot = before;
        }
        path.reverse();
        // Modules without identifiers behind the last octets.
        let behind = (last..self.states.len().saturating_sub(1)).take_while(|slot| self.silent(*slot).is_some());
        path.extend(behind.map(|slot| (self.number(slot), end..end)));
        Ok((path, has_other))
    }

    /// Whether the division that ends behind this slot has a module in it, and not a free slot behind the same modules.
    fn ends_with_octets(&self, slot: usize, end: usize) -> bool {
        self.state(slot, end).is_some_and(|state| state.from.is_some_and(|length| length > 0))
    }

    /// The first octets that belong to no module.
    fn no_module(&self) -> FitError {
        let is_reached = |at: usize, slot: usize| self.state(slot, at).is_some();
        let slots = 0..self.states.len();
        let at = (0..=self.octets.len()).rev().find(|at| slots.clone().any(|slot| is_reached(*at, slot))).unwrap_or(0);
        let with_octets = |slot: usize| {
            let allowed = self.allowed(slot);
            let takes = |module: &&Module| !module.config.is_empty() && self.slot_takes(slot, allowed.as_ref(), module);
            self.device.modules.iter().filter(takes).collect::<Vec<_>>()
        };
        let slot = slots.clone().find(|slot| is_reached(at, *slot) && !with_octets(*slot).is_empty()).unwrap_or(0);
        FitError::NoModule {
            at,
            rest: self.octets.get(at..).unwrap_or_default().to_vec(),
            slot: self.number(slot),
            possible: list(
                with_octets(slot).into_iter().map(|module| format!("{} {}", name(module), hex(&module.config))),
            ),
        }
    }
}

/// For each place in the octets where a group of modules ends, and the number of the group.
type Matches = Vec<Vec<(usize, usize)>>;

/// The modules by their octets, and where each group stands in the octets, the shortest first.
fn matches<'a>(device: &'a Device, octets: &[u8]) -> (Vec<Vec<&'a Module>>, Matches) {
    let mut by_octets: BTreeMap<&'a [u8], Vec<&'a Module>> = BTreeMap::new();
    for module in &device.modules {
        by_octets.entry(module.config.as_slice()).or_default().push(module);
    }
    let longest = by_octets.keys().map(|config| config.len()).max().unwrap_or(0);
    let numbers: BTreeMap<&[u8], usize> = by_octets.keys().copied().zip(0..).collect();
    let at = |at: usize| {
        let ends = at.saturating_add(1)..=at.saturating_add(longest).min(octets.len());
        ends.filter_map(|end| Some((end, *numbers.get(octets.get(at..end)?)?))).collect()
    };
    let matches = (0..octets.len()).map(at).collect();
    (by_octets.into_values().collect(), matches)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::GsdFile;

    /// Modules that no slot takes, and slots with very many numbers, are the worst case: each slot looks at all modules once.
    #[test]
    fn the_work_of_the_search_grows_with_the_number_of_modules() {
        let steps = |modules: usize| {
            let lines: String =
                (1..=modules).map(|number| format!("Module=\"m\" 0x10\n{number}\nEndModule\n")).collect();
            let slots: String = (1..=40).map(|slot| format!("Slot({slot})=\"s\" 65000 65000\n")).collect();
            let text = format!("#Profibus_DP\nModular_Station=1\n{lines}SlotDefinition\n{slots}EndSlotDefinition\n");
            let file = GsdFile::read(text.as_bytes());
            let mut search = Search::new(file.device(), &[0x10; 40]);
            search.run();
            assert!(search.path().is_err());
            search.steps
        };
        let (few, many) = (steps(100), steps(400));
        assert!(few >= 100, "{few} steps are not all");
        assert!(many <= few * 4, "{few} steps, {many} for four times the modules");
    }

    #[test]
    fn numbers_of_a_slot_are_found_in_overlapping_ranges() {
        let allowed =
            Allowed::of(&Slot { default: 99, allowed: vec![(20, 30), (1, 3), (4, 4), (25, 27)], ..Slot::default() });
        assert_eq!(allowed.numbers, [(1, 4), (20, 30)]);
        let is = |number| allowed.contains(number);
        assert_eq!(
            [0, 1, 4, 5, 19, 20, 28, 30, 31, 99].map(is),
            [false, true, true, false, false, true, true, true, false, true]
        );
    }
}
