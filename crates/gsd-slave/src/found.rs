//! The modules of configuration octets that a slave returned.

use crate::slave::{GsdSlave, SlaveError};
use profivac_gsd::{Configuration, Device, GsdFile, Module};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

/// The modules of a file that give configuration octets, see [`GsdSlave::by_chk_cfg`].
#[derive(Clone, Debug)]
pub struct FoundModules {
    /// The slave with the first possible module in each slot and the file's default parameters.
    pub slave: GsdSlave,
    /// The slots with all modules that have their octets.
    pub slots: Vec<FoundSlot>,
    /// Whether the octets can also be divided into modules with other octets.
    pub is_divided_otherwise: bool,
}

/// A slot and its possible modules.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoundSlot {
    /// The number of the slot.
    pub slot: u32,
    /// Number and name of each module with these configuration octets that the slot takes, in the order of the file.
    pub modules: Vec<(u32, String)>,
    /// Its octets within Chk_Cfg.
    pub range: Range<usize>,
}

impl FoundModules {
    /// Whether one module is possible in each slot, and no other division.
    #[must_use]
    pub fn is_unique(&self) -> bool {
        !self.is_divided_otherwise && self.slots.iter().all(|slot| slot.modules.len() == 1)
    }
}

impl FoundSlot {
    /// `slot 2 4DO`; several modules with the same octets are all named: `slot 2 4DO or 4DO HF`.
    #[must_use]
    pub fn label(&self) -> String {
        let names: Vec<_> = self.modules.iter().map(|(_, name)| name.as_str()).collect();
        format!("slot {} {}", self.slot, names.join(" or "))
    }
}

impl GsdSlave {
    /// The modules whose configuration octets are these, from Get_Cfg or Chk_Cfg. Several modules can have the same octets; all are
    /// named.
    ///
    /// The slots of the file count: only modules that a slot takes, and free slots only where the file defines slots. chosen: as few
    /// free slots as possible, then as few modules as possible. None if no modules of the file give these octets.
    ///
    /// ```
    /// use profivac_gsd::GsdFile;
    /// use profivac_gsd_slave::GsdSlave;
    ///
    /// let file = GsdFile::read(b"#Profibus_DP
    /// Ident_Number = 0x1234
    /// Modular_Station = 1
    /// Max_Module = 4
    /// Module = \"4DO\" 0x20
    /// EndModule
    /// Module = \"4DO HF\" 0x20
    /// EndModule
    /// ");
    /// let found = GsdSlave::by_chk_cfg(&file.into(), &[0x20, 0x20]).unwrap();
    /// assert_eq!(found.slots[1].label(), "slot 2 4DO or 4DO HF");
    /// assert!(GsdSlave::by_chk_cfg(found.slave.file(), &[0x21]).is_none());
    /// ```
    #[must_use]
    pub fn by_chk_cfg(file: &Arc<GsdFile>, octets: &[u8]) -> Option<FoundModules> {
        let device = file.device();
        let (path, is_divided_otherwise) = Search::new(device, octets).best()?;
        let first = path.iter().filter_map(|one| Some((one.slot, *one.modules.first()?)));
        let configuration = Configuration::in_slots(device, first).ok()?;
        let slave: Result<GsdSlave, SlaveError> = Self::of(file, &configuration);
        Some(FoundModules { slave: slave.ok()?, slots: path.iter().map(Step::found).collect(), is_divided_otherwise })
    }
}

/// A slot in a division of the octets.
#[derive(Clone)]
struct Step<'d> {
    slot: u32,
    modules: Vec<&'d Module>,
    range: Range<usize>,
}

impl Step<'_> {
    fn found(&self) -> FoundSlot {
        let modules = self.modules.iter().map(|module| (module.number, module.name.clone())).collect();
        FoundSlot { slot: self.slot, modules, range: self.range.clone() }
    }
}

/// Free slots and modules of the best rest, and the length of its first module; none if the slot is free.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Rest {
    free: usize,
    modules: usize,
    first: Option<usize>,
    several: bool,
}

/// The best division of the octets from each place on, for each slot: work is octets x slots x modules.
struct Search<'d> {
    device: &'d Device,
    octets: &'d [u8],
    /// The modules whose octets stand at each place.
    fitting: Vec<Vec<&'d Module>>,
    slots: Vec<u32>,
    best: BTreeMap<(usize, usize), Rest>,
}

impl<'d> Search<'d> {
    fn new(device: &'d Device, octets: &'d [u8]) -> Self {
        let fits = |rest: &[u8]| device.modules.iter().filter(|one| rest.starts_with(&one.config)).collect();
        let fitting = (0..=octets.len()).map(|place| fits(octets.get(place..).unwrap_or_default())).collect();
        let most = u32::try_from(device.max_modules().min(MAX_SLOTS)).unwrap_or(u32::MAX);
        let first = device.first_slot();
        let slots = if device.slots.is_empty() {
            (first..first.saturating_add(most)).collect()
        } else {
            device.slots.keys().copied().take(MAX_SLOTS).collect()
        };
        let mut search = Self { device, octets, fitting, slots, best: BTreeMap::new() };
        search.fill();
        search
    }

    fn fill(&mut self) {
        let end = self.octets.len();
        for slot in 0..=self.slots.len() {
            self.best.insert((end, slot), Rest { free: 0, modules: 0, first: None, several: false });
        }
        for slot in (0..self.slots.len()).rev() {
            for place in (0..=end).rev() {
                if let Some(rest) = self.rest(place, slot) {
                    self.best.insert((place, slot), rest);
                }
            }
        }
    }

    /// The best way from this place in this slot.
    fn rest(&self, place: usize, slot: usize) -> Option<Rest> {
        let next = slot.saturating_add(1);
        let with = |length: usize| {
            let after = self.best.get(&(place.saturating_add(length), next))?;
            Some(Rest { modules: after.modules.saturating_add(1), first: Some(length), ..*after })
        };
        let mut lengths: Vec<_> = self.modules(place, slot).map(|module| module.config.len()).collect();
        lengths.sort_unstable();
        lengths.dedup();
        let free = self.best.get(&(place, next)).filter(|_| self.can_be_free(place, slot));
        let is_between = usize::from(place < self.octets.len());
        let free = free.map(|after| Rest { free: after.free.saturating_add(is_between), first: None, ..*after });
        let ways: Vec<_> = lengths.into_iter().filter_map(with).collect();
        let several = ways.len() > 1;
        let best = ways.into_iter().chain(free).min()?;
        Some(Rest { several: best.several || several, ..best })
    }

    fn can_be_free(&self, place: usize, slot: usize) -> bool {
        let fixed = self.slots.get(slot).and_then(|slot| self.device.fixed_in(*slot));
        fixed.is_none() && (place == self.octets.len() || !self.device.slots.is_empty())
    }

    /// The modules that the slot takes and whose octets stand here. chosen: a module without octets only where the file fixes it in this
    /// slot, because octets do not show it.
    fn modules(&self, place: usize, slot: usize) -> impl Iterator<Item = &'d Module> {
        let fitting = self.fitting.get(place).map(Vec::as_slice).unwrap_or_default();
        let number = self.slots.get(slot).copied();
        fitting.iter().copied().filter(move |module| {
            let is_fixed = |slot| self.device.fixed_in(slot).is_some_and(|fixed| std::ptr::eq(fixed, *module));
            number.is_some_and(|slot| (!module.config.is_empty() || is_fixed(slot)) && self.device.takes(slot, module))
        })
    }

    fn best(&self) -> Option<(Vec<Step<'d>>, bool)> {
        let several = self.best.get(&(0, 0))?.several;
        let (mut place, mut steps) = (0, Vec::new());
        for (index, slot) in self.slots.iter().enumerate() {
            let Some(length) = self.best.get(&(place, index))?.first else { continue };
            let range = place..place.saturating_add(length);
            let modules = self.modules(place, index).filter(|module| module.config.len() == length).collect();
            place = range.end;
            steps.push(Step { slot: *slot, modules, range });
        }
        (place == self.octets.len() && !steps.is_empty()).then_some((steps, several))
    }
}

/// At most this many slots are searched: Chk_Cfg has at most 244 octets.
const MAX_SLOTS: usize = 244;
