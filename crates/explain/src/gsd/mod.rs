//! Slaves in the words of their GSD files: names, modules, parameters, diagnosis.
//!
//! A slave shows its Ident_Number in a diagnosis, its master in Set_Prm. Several devices can have one Ident_Number: then all are named
//! until Chk_Cfg or Get_Cfg has a configuration that only some of them can have.

mod diagnosis;
mod mismatch;
mod parameters;

pub use mismatch::{Mismatch, Seen};
pub use parameters::Extent;

use profivac_devices::catalog::KnownDevices;
use profivac_gsd::{Configuration, Device, Fit, FitError, GsdFile, Module};
use profivac_sim::describe::Hex;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::ops::Range;
use std::sync::Arc;

/// The number of things that a sentence lists.
const LISTED: usize = 20;

/// The number of modules that a slot names, and of characters of a name. chosen: a damaged file has thousands of modules with one
/// configuration, or names of a megabyte.
const NAMED: usize = 100;

/// What files say about slaves: GSD files by Ident_Number, and the devices of device files beside the built-in ones.
#[derive(Clone, Debug, Default)]
pub struct Files {
    gsd: Arc<BTreeMap<u16, Vec<Arc<GsdFile>>>>,
    devices: KnownDevices,
}

impl Files {
    /// These GSD files. A file without an Ident_Number is left out.
    pub fn new(files: impl IntoIterator<Item = Arc<GsdFile>>) -> Self {
        let mut by_ident: BTreeMap<u16, Vec<Arc<GsdFile>>> = BTreeMap::new();
        for file in files {
            if let Some(ident) = file.device().general.ident_number.and_then(|ident| u16::try_from(ident).ok()) {
                by_ident.entry(ident).or_default().push(file);
            }
        }
        Self { gsd: Arc::new(by_ident), devices: KnownDevices::BUILT_IN }
    }

    /// The same files, and these devices.
    #[must_use]
    pub fn with_devices(self, devices: KnownDevices) -> Self {
        Self { devices, ..self }
    }

    /// The devices whose tables are known.
    #[must_use]
    pub const fn devices(&self) -> KnownDevices {
        self.devices
    }

    /// Whether there is no GSD file.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.gsd.is_empty()
    }

    /// The files of the devices with this Ident_Number.
    #[must_use]
    pub fn of(&self, ident: u16) -> &[Arc<GsdFile>] {
        self.gsd.get(&ident).map(Vec::as_slice).unwrap_or_default()
    }
}

/// One slave in the words of the files with its Ident_Number, as far as the traffic has shown which one it is.
#[derive(Clone, Debug, Default)]
pub struct Described {
    files: Files,
    ident: Option<u16>,
    /// The files that the configuration leaves possible; all files with the Ident_Number until there is one.
    possible: Vec<Arc<GsdFile>>,
    /// The octets of the last Chk_Cfg or Get_Cfg.
    config: Vec<u8>,
    /// They came in a Chk_Cfg after the last Set_Prm, so its user parameters belong to these modules.
    is_of_set_prm: bool,
    /// For each possible file the modules in their slots; empty if the configuration is not known or no file has its modules.
    fitted: Vec<Fitted>,
    /// The same of all files together.
    slots: Vec<Slot>,
    /// What else the octets can be.
    other: OtherDivision,
}

/// Whether the modules in their slots are the only ones that give the configuration, in rising order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
enum OtherDivision {
    #[default]
    None,
    /// Other modules of a file divide the octets otherwise.
    InOneFile,
    /// The files divide the octets differently, so that no octet has a certain module.
    BetweenFiles,
}

impl OtherDivision {
    fn of(fits: &[(&Arc<GsdFile>, Fit<'_>)]) -> Self {
        let division =
            |fit: &Fit<'_>| fit.slots.iter().map(|slot| (slot.slot, slot.config.clone())).collect::<Vec<_>>();
        let mut divisions = fits.iter().map(|(_, fit)| division(fit));
        let first = divisions.next();
        if divisions.any(|other| Some(other) != first) {
            return Self::BetweenFiles;
        }
        match fits.iter().any(|(_, fit)| fit.has_other_division) {
            true => Self::InOneFile,
            false => Self::None,
        }
    }
}

/// The modules of one file in their slots.
#[derive(Clone, Debug)]
struct Fitted {
    slots: Vec<FittedSlot>,
}

/// A slot, its identifiers, and the places of its modules in the list of the file.
#[derive(Clone, Debug)]
struct FittedSlot {
    slot: u32,
    identifiers: Range<usize>,
    modules: Vec<usize>,
}

impl Fitted {
    fn new(file: &GsdFile, fit: &Fit<'_>) -> Self {
        let places: HashMap<_, _> = file.device().modules.iter().map(std::ptr::from_ref).zip(0..).collect();
        let place = |module: &Module| places.get(&std::ptr::from_ref(module)).copied();
        let slot = |slot: &profivac_gsd::FittedSlot<'_>| FittedSlot {
            slot: slot.slot,
            identifiers: slot.identifiers.clone(),
            modules: slot.modules.iter().filter_map(|module| place(module)).collect(),
        };
        Self { slots: fit.slots.iter().map(slot).collect() }
    }
}

/// The modules that may be in a slot, and where their data are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Slot {
    /// The number of the slot.
    pub slot: u32,
    /// The modules with the configuration octets of this slot, at most a hundred.
    pub modules: Vec<String>,
    /// The number of further modules with these octets.
    pub more: usize,
    /// Its identifiers, counted from 0 as diagnosis does.
    pub identifiers: Range<usize>,
    /// Its octets in the inputs.
    pub inputs: Range<usize>,
    /// Its octets in the outputs.
    pub outputs: Range<usize>,
}

impl Slot {
    /// The modules in words: `4DO or 4DO HF`; of more than three the first two and the number of the others.
    #[must_use]
    pub fn names(&self) -> String {
        match self.modules.as_slice() {
            [first, second, others @ ..] if others.len() > 1 => {
                let more = others.len().saturating_add(self.more);
                format!("{first} or {second} or {more} others with the same octets")
            }
            modules => modules.join(" or "),
        }
    }

    fn all_names(&self) -> String {
        let more = match self.more {
            0 => String::new(),
            more => format!(" or {more} others with the same octets"),
        };
        format!("{}{more}", self.modules.join(" or "))
    }

    fn names_of(&self, extent: Extent) -> String {
        match extent {
            Extent::Changes => self.names(),
            Extent::All => self.all_names(),
        }
    }
}

impl Described {
    /// The devices whose tables are known.
    #[must_use]
    pub const fn devices(&self) -> KnownDevices {
        self.files.devices()
    }

    /// A slave whose Ident_Number is not known yet.
    #[must_use]
    pub fn new(files: Files) -> Self {
        Self { files, ..Self::default() }
    }

    /// A slave of which the file and the chosen modules are known. `configuration` is of the device of this file.
    #[must_use]
    pub fn chosen(file: &Arc<GsdFile>, configuration: &Configuration<'_>) -> Self {
        let fit = Fit::of(configuration);
        Self {
            files: Files::new([Arc::clone(file)]),
            ident: file.device().general.ident_number.and_then(|ident| u16::try_from(ident).ok()),
            possible: vec![Arc::clone(file)],
            config: configuration.chk_cfg(),
            is_of_set_prm: true,
            fitted: vec![Fitted::new(file, &fit)],
            slots: slots(&[(file, fit)]),
            other: OtherDivision::None,
        }
    }

    /// Takes the Ident_Number. Another one than before is another device; the configuration that came before the first one is kept.
    pub fn identify(&mut self, ident: u16) {
        if self.ident == Some(ident) {
            return;
        }
        let before = std::mem::replace(self, Self::new(self.files.clone()));
        self.ident = Some(ident);
        self.possible = self.files.of(ident).to_vec();
        if before.ident.is_none() && !before.config.is_empty() {
            self.is_of_set_prm = before.is_of_set_prm;
            self.fit(&before.config);
        }
    }

    /// Takes a Set_Prm: its user parameters belong to the modules of the Chk_Cfg that follows.
    pub const fn parameterise(&mut self) {
        self.is_of_set_prm = false;
    }

    /// Takes the octets of Chk_Cfg.
    pub fn configure(&mut self, octets: &[u8]) {
        self.is_of_set_prm = true;
        self.fit(octets);
    }

    /// Takes the octets of Get_Cfg. The master may have written Set_Prm for other modules.
    pub fn offer(&mut self, octets: &[u8]) {
        self.is_of_set_prm &= self.config == octets;
        self.fit(octets);
    }

    /// The modules of a file to which the user parameters of the last Set_Prm belong.
    fn fit_of_set_prm<'f>(&self, file: &'f GsdFile) -> Option<Fit<'f>> {
        self.is_of_set_prm.then(|| Fit::new(file.device(), &self.config).ok())?
    }

    fn fit(&mut self, octets: &[u8]) {
        if self.config == octets {
            return;
        }
        octets.clone_into(&mut self.config);
        let all: Vec<_> = self.ident.map(|ident| self.files.of(ident).to_vec()).unwrap_or_default();
        let fits: Vec<_> = all.iter().filter_map(|file| Some((file, Fit::new(file.device(), octets).ok()?))).collect();
        self.slots = slots(&fits);
        self.other = OtherDivision::of(&fits);
        self.fitted = fits.iter().map(|(file, fit)| Fitted::new(file, fit)).collect();
        let fitting: Vec<_> = fits.iter().map(|(file, _)| Arc::clone(file)).collect();
        self.possible = if fitting.is_empty() { all } else { fitting };
    }

    /// Whether a file describes the slave.
    #[must_use]
    pub fn is_known(&self) -> bool {
        !self.possible.is_empty()
    }

    /// The files that may be the slave's.
    #[must_use]
    pub fn possible(&self) -> &[Arc<GsdFile>] {
        &self.possible
    }

    /// The devices that it may be: model and vendor, each once.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        distinct(self.possible.iter().map(|file| name(file.device())))
    }

    /// The devices that it may be in a sentence, which names twenty of them and counts the others.
    #[must_use]
    pub fn names_text(&self) -> String {
        shortened(&self.names(), " or ", LISTED)
    }

    /// The models that it may be, each once.
    #[must_use]
    pub fn models(&self) -> Vec<String> {
        let model = |file: &Arc<GsdFile>| file.device().general.model_name.clone();
        distinct(self.possible.iter().filter_map(model).map(|model| brief(&model)))
    }

    /// DPV1_Slave of the files; `None` without a file or if the files differ.
    #[must_use]
    pub fn dpv1_slave(&self) -> Option<bool> {
        let mut all = self.possible.iter().map(|file| file.device().general.dpv1_slave == Some(true));
        let first = all.next()?;
        all.all(|other| other == first).then_some(first)
    }

    /// The modules in their slots.
    #[must_use]
    pub fn slots(&self) -> &[Slot] {
        &self.slots
    }

    /// The modules in words, with what is wrong with the configuration: `slot 1 4DI, slot 2 4DO or 4DO HF`. Empty without a file.
    #[must_use]
    pub fn modules_text(&self, extent: Extent) -> String {
        if !self.is_known() || self.config.is_empty() {
            return String::new();
        }
        if let Some(error) = self.misfit() {
            return format!("not possible by the GSD file: {error}");
        }
        let slots: Vec<_> =
            self.slots.iter().map(|slot| format!("slot {} {}", slot.slot, slot.names_of(extent))).collect();
        let other = match self.other {
            OtherDivision::None => "",
            OtherDivision::InOneFile => "; other modules can have these octets too",
            OtherDivision::BetweenFiles => "; by another of the GSD files other modules have these octets",
        };
        format!("{}{other}", shortened(&slots, ", ", extent.most()))
    }

    /// Why no file has modules for the configuration.
    #[must_use]
    pub fn misfit(&self) -> Option<FitError> {
        let mut errors = Vec::new();
        for file in &self.possible {
            errors.push(Fit::new(file.device(), &self.config).err()?);
        }
        errors.into_iter().next()
    }

    /// Each possible device with the modules in the slot that `is_meant`.
    fn modules_in(&self, is_meant: impl Fn(&FittedSlot) -> bool) -> impl Iterator<Item = (&Device, Vec<&Module>)> {
        self.possible.iter().enumerate().map(move |(place, file)| {
            let fitted = self.fitted.get(place);
            let slot = fitted.and_then(|fitted| fitted.slots.iter().find(|slot| is_meant(slot)));
            let places = slot.map(|slot| slot.modules.as_slice()).unwrap_or_default();
            let device = file.device();
            (device, places.iter().filter_map(|place| device.modules.get(*place)).collect())
        })
    }

    /// The inputs by module: `slot 1 4DI: 0F, slot 3 2AI: 12 34 56 78`. Empty if the modules are not known or have other lengths.
    #[must_use]
    pub fn inputs(&self, du: &[u8]) -> String {
        self.data(du, |slot| &slot.inputs)
    }

    /// The outputs by module, as the inputs.
    #[must_use]
    pub fn outputs(&self, du: &[u8]) -> String {
        self.data(du, |slot| &slot.outputs)
    }

    fn data(&self, du: &[u8], place: impl Fn(&Slot) -> &Range<usize>) -> String {
        let is_certain = self.other != OtherDivision::BetweenFiles;
        if !is_certain || self.slots.last().is_none_or(|last| place(last).end != du.len()) {
            return String::new();
        }
        let part = |slot: &Slot| {
            let octets = du.get(place(slot).clone()).filter(|octets| !octets.is_empty())?;
            Some(format!("slot {} {}: {}", slot.slot, slot.names(), Hex(octets)))
        };
        self.slots.iter().filter_map(part).collect::<Vec<_>>().join(", ")
    }

    /// An identifier of a diagnosis with its module: `identifier 3 (slot 2, module 4DO)`. Diagnosis counts identifiers from 0, and a module
    /// has none, one or several.
    #[must_use]
    pub fn identifier_text(&self, identifier: usize) -> String {
        match self.slots.iter().find(|slot| slot.identifiers.contains(&identifier)) {
            _ if self.other == OtherDivision::BetweenFiles => {
                format!("identifier {identifier} (module unknown: the GSD files divide the configuration differently)")
            }
            Some(slot) => format!("identifier {identifier} (slot {}, module {})", slot.slot, slot.names()),
            None if self.slots.is_empty() => {
                format!("identifier {identifier} (module unknown: no Chk_Cfg that fits was received)")
            }
            None => format!("identifier {identifier} (beyond the modules)"),
        }
    }
}

/// The slots of all files that have modules for the configuration. Files that put modules at other places add none.
fn slots(fits: &[(&Arc<GsdFile>, Fit<'_>)]) -> Vec<Slot> {
    let Some((_, first)) = fits.first() else { return Vec::new() };
    let slot = |one: &profivac_gsd::FittedSlot<'_>| {
        let same = fits.iter().filter_map(|(_, fit)| fit.slot(one.slot)).filter(|other| other.config == one.config);
        let mut seen = HashSet::new();
        let names = same.flat_map(|other| &other.modules).map(|module| module.name.as_str());
        let mut names = names.filter(|name| seen.insert(*name));
        Slot {
            slot: one.slot,
            modules: names.by_ref().take(NAMED).map(brief).collect(),
            more: names.count(),
            identifiers: one.identifiers.clone(),
            inputs: one.inputs.clone(),
            outputs: one.outputs.clone(),
        }
    };
    first.slots.iter().map(slot).collect()
}

/// Model and vendor: `Island of Valves Ltd`.
fn name(device: &Device) -> String {
    let general = &device.general;
    let model = brief(general.model_name.as_deref().unwrap_or("a slave without Model_Name"));
    let vendor = general.vendor_name.as_deref().map(brief);
    vendor.map_or_else(|| model.clone(), |vendor| format!("{model} of {vendor}"))
}

/// A name of the file without blanks at its ends, and without the characters beyond a hundred.
fn brief(name: &str) -> String {
    let name = name.trim();
    match name.char_indices().nth(NAMED) {
        Some((end, _)) => format!("{}...", name.get(..end).unwrap_or_default()),
        None => name.to_owned(),
    }
}

/// Each text once, in their order.
fn distinct(texts: impl Iterator<Item = String>) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    let mut seen = HashSet::new();
    for text in texts {
        if seen.insert(text.clone()) {
            all.push(text);
        }
    }
    all
}

/// The first texts; the others are counted.
fn shortened(texts: &[String], between: &str, most: usize) -> String {
    let shown = texts.get(..most).unwrap_or(texts).join(between);
    match texts.len().saturating_sub(most) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}
