//! Configuration octets to the modules that give them: Chk_Cfg and Get_Cfg back to words.

use crate::configuration::{Configuration, ConfigurationError, first_slot, is_fixed, name, takes_slot_number};
use crate::device::{Device, Module};
use crate::words::{hex, list};
use profivac_wire::cfg::{Area, CfgError, Identifiers, lengths};
use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;

/// Slots have the numbers 0 to 254, profibus-wire 3.
const MAX_SLOTS: usize = 255;

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
/// let slots: Vec<_> = fit.slots.iter().map(|slot| (slot.slot, slot.names())).collect();
/// assert_eq!(slots, [(1, "two switches".to_owned()), (2, "valve or valve HF".to_owned())]);
/// # Ok::<(), profivac_gsd::FitError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Fit<'a> {
    pub(crate) device: &'a Device,
    /// The slots with a module, in their order.
    pub slots: Vec<FittedSlot<'a>>,
    /// Whether other modules, or modules in other slots, divide the same octets otherwise.
    pub has_other_division: bool,
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

impl FittedSlot<'_> {
    /// The names of the modules: `valve or valve HF`.
    #[must_use]
    pub fn names(&self) -> String {
        let names: Vec<_> = self.modules.iter().map(|module| module.name.clone()).collect();
        match names.as_slice() {
            [only] => only.clone(),
            _ => list(names.into_iter()).replace(", ", " or "),
        }
    }
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
        let mut fit = Self { device, slots: Vec::new(), has_other_division };
        let mut counts = Counts::default();
        for (slot, config) in path {
            let modules = search.candidates(slot, &config);
            let before = counts;
            counts.add(octets.get(config.clone()).unwrap_or_default());
            fit.slots.push(FittedSlot {
                slot,
                config,
                identifiers: before.identifiers..counts.identifiers,
                inputs: before.inputs..counts.inputs,
                outputs: before.outputs..counts.outputs,
                modules,
            });
        }
        Ok(fit)
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
    /// By place: where modules that begin there end, and these modules.
    matches: Vec<Vec<(usize, Vec<&'a Module>)>>,
    first: u32,
    /// The modules that are always plugged, in the first slots; empty if slot definitions say where they may be.
    fixed: Vec<&'a Module>,
    /// By slot from the first one, and by place in the octets.
    states: Vec<Vec<Option<State>>>,
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
        let slots = slots.max(octets.len().saturating_add(fixed.len())).min(MAX_SLOTS);
        let states = vec![vec![None; octets.len().saturating_add(1)]; slots.saturating_add(1)];
        Self { device, octets, matches: matches(device, octets), first, fixed, states }
    }

    fn number(&self, slot: usize) -> u32 {
        self.first.saturating_add(u32::try_from(slot).unwrap_or(u32::MAX))
    }

    fn run(&mut self) {
        self.reach(0, 0, State { cost: (0, 0), has_other: false, from: None });
        for slot in 0..self.states.len().saturating_sub(1) {
            for at in 0..=self.octets.len() {
                let Some(State { cost: (free, modules), has_other, .. }) = self.state(slot, at) else { continue };
                let next = slot.saturating_add(1);
                if let Some(cost) = self.cost_of_free(slot) {
                    self.reach(next, at, State { cost: (free.saturating_add(cost), modules), has_other, from: None });
                }
                let there = self.matches.get(at).map(Vec::as_slice).unwrap_or_default();
                let taken = there.iter().filter(|(_, modules)| modules.iter().any(|one| self.slot_takes(slot, one)));
                for end in taken.map(|(end, _)| *end).collect::<Vec<_>>() {
                    let cost = (free, modules.saturating_add(1));
                    self.reach(next, end, State { cost, has_other, from: Some(end.saturating_sub(at)) });
                }
            }
        }
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

    /// What it costs to leave a slot without octets; `None` if it cannot be.
    ///
    /// chosen: without slot definitions modules stand side by side, because nothing in the octets would show a gap. A module without an
    /// identifier that is always plugged, or is the default of the slot, leaves no gap.
    fn cost_of_free(&self, slot: usize) -> Option<usize> {
        if let Some(fixed) = self.fixed.get(slot) {
            return fixed.config.is_empty().then_some(0);
        }
        let definition = self.device.slots.get(&self.number(slot));
        let has_silent =
            definition.and_then(|slot| self.device.module(slot.default)).is_some_and(|module| module.config.is_empty());
        (!self.device.slots.is_empty()).then_some(usize::from(!has_silent))
    }

    fn slot_takes(&self, slot: usize, module: &Module) -> bool {
        if let Some(fixed) = self.fixed.get(slot) {
            return std::ptr::eq(*fixed, module);
        }
        let number = self.number(slot);
        let is_allowed = self.device.slots.get(&number).is_none_or(|slot| slot.allows(module.number));
        is_allowed && takes_slot_number(self.device, number, module)
    }

    /// The modules with these octets that the slot takes.
    fn candidates(&self, number: u32, config: &Range<usize>) -> Vec<&'a Module> {
        let slot = usize::try_from(number.saturating_sub(self.first)).unwrap_or(usize::MAX);
        let there = self.matches.get(config.start).and_then(|there| there.iter().find(|(end, _)| *end == config.end));
        let modules = there.map(|(_, modules)| modules.as_slice()).unwrap_or_default();
        let mut modules: Vec<_> = modules.iter().filter(|module| self.slot_takes(slot, module)).copied().collect();
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
        Ok((path, has_other))
    }

    /// Whether the division that ends behind this slot has a module in it, and not a free slot behind the same modules.
    fn ends_with_octets(&self, slot: usize, end: usize) -> bool {
        self.state(slot, end).is_some_and(|state| state.from.is_some())
    }

    /// The first octets that belong to no module.
    fn no_module(&self) -> FitError {
        let is_reached = |at: usize, slot: usize| self.state(slot, at).is_some();
        let slots = 0..self.states.len();
        let at = (0..=self.octets.len()).rev().find(|at| slots.clone().any(|slot| is_reached(*at, slot))).unwrap_or(0);
        let with_octets = |slot: usize| {
            self.device.modules.iter().filter(move |module| !module.config.is_empty() && self.slot_takes(slot, module))
        };
        let slot = slots.clone().find(|slot| is_reached(at, *slot) && with_octets(*slot).next().is_some()).unwrap_or(0);
        FitError::NoModule {
            at,
            rest: self.octets.get(at..).unwrap_or_default().to_vec(),
            slot: self.number(slot),
            possible: list(with_octets(slot).map(|module| format!("{} {}", name(module), hex(&module.config)))),
        }
    }
}

/// For each place in the octets: the ends of the modules that begin there, the shortest first, with these modules.
fn matches<'a>(device: &'a Device, octets: &[u8]) -> Vec<Vec<(usize, Vec<&'a Module>)>> {
    let mut groups: BTreeMap<&'a [u8], Vec<&'a Module>> = BTreeMap::new();
    for module in &device.modules {
        groups.entry(module.config.as_slice()).or_default().push(module);
    }
    let longest = groups.keys().map(|config| config.len()).max().unwrap_or(0);
    let at = |at: usize| {
        let ends = at.saturating_add(1)..=at.saturating_add(longest).min(octets.len());
        ends.filter_map(|end| Some((end, groups.get(octets.get(at..end)?)?.clone()))).collect()
    };
    (0..octets.len()).map(at).collect()
}
