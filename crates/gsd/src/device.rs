//! The typed model of a GSD file.

use crate::alarm::Alarms;
use crate::diagnosis::Diagnosis;
use crate::general::{General, Rate, RateError};
use crate::parameter::{Parameter, PrmArea, PrmContent, PrmText};
use crate::words::list;
use std::collections::BTreeMap;

/// A device as its GSD file describes it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Device {
    /// Keywords with one value.
    pub general: General,
    /// The baud rates of the file, in the order of [`RATES`](crate::RATES).
    pub rates: Vec<Rate>,
    /// User_Prm_Data of the station, for tools that do not know the Ext ones.
    pub user_prm_data: Option<Vec<u8>>,
    /// Ext_User_Prm_Data of the station. Its length is Max_User_Prm_Data_Len, a limit.
    pub prm: PrmArea,
    /// ExtUserPrmData by number.
    pub parameters: BTreeMap<u32, Parameter>,
    /// PrmText by number.
    pub texts: BTreeMap<u32, PrmText>,
    /// The modules in the order of the file.
    pub modules: Vec<Module>,
    /// SlotDefinition by number of the slot; empty if every slot takes every module.
    pub slots: BTreeMap<u32, Slot>,
    /// Texts for diagnosis.
    pub diagnosis: Diagnosis,
    /// Lines that the model does not interpret.
    pub others: Vec<Other>,
}

/// A module, the keyword Module.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Module {
    /// The number in the file. Without one the reader numbers it by its place, see [`Module::numbered`].
    pub number: u32,
    /// Whether the file gives the number.
    pub numbered: bool,
    /// The name without blanks at its ends.
    pub name: String,
    /// Its configuration identifiers: none, one or several.
    pub config: Vec<u8>,
    /// Whether the module is plugged at first; with FixPresetModules always.
    pub preset: bool,
    /// Info_Text.
    pub info: Option<String>,
    /// Its part of the user parameters; its length is Ext_Module_Prm_Data_Len.
    pub prm: PrmArea,
    /// The parameters for PROFIsafe. A safety controller computes their checksums, so they are never part of our octets;
    /// [`Configuration::warnings`](crate::Configuration::warnings) names such modules.
    pub safety: PrmArea,
    /// Its alarms; the keywords of the station are in [`General`].
    pub alarms: Alarms,
    /// Texts for diagnosis of this module.
    pub diagnosis: Diagnosis,
    /// Lines that the model does not interpret.
    pub others: Vec<Other>,
    /// The line of the definition, from 1; 0 if it comes from no file.
    pub line: usize,
}

/// A slot and the modules that it takes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Slot {
    /// The number of the slot.
    pub number: u32,
    /// Its name.
    pub name: String,
    /// The number of the module that is plugged at first.
    pub default: u32,
    /// The numbers of the allowed modules, from the first to the second.
    pub allowed: Vec<(u32, u32)>,
    /// The line of the definition, from 1; 0 if it comes from no file.
    pub line: usize,
}

/// A line that the model does not interpret.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Other {
    /// The line, from 1.
    pub line: usize,
    /// The keyword as the file writes it.
    pub keyword: String,
    /// The line without the comment at its end; a line that goes on in others has its continuations.
    pub text: String,
}

impl Slot {
    /// Whether the slot takes the module with this number.
    #[must_use]
    pub fn allows(&self, module: u32) -> bool {
        module == self.default || self.allowed.iter().any(|(low, high)| (*low..=*high).contains(&module))
    }
}

impl Device {
    /// The module with this number; the first if the file gives it twice.
    #[must_use]
    pub fn module(&self, number: u32) -> Option<&Module> {
        self.modules.iter().find(|module| module.number == number)
    }

    /// The modules with this name: blanks at its ends do not count.
    pub fn modules_named<'a, 'n>(&'a self, name: &'n str) -> impl Iterator<Item = &'a Module> + use<'a, 'n> {
        self.modules.iter().filter(move |module| module.name == name.trim())
    }

    /// The modules with these configuration octets: several modules can have the same.
    pub fn modules_with<'a>(&'a self, config: &'a [u8]) -> impl Iterator<Item = &'a Module> {
        self.modules.iter().filter(move |module| module.config == config)
    }

    /// Whether a user chooses several modules. A compact station has one.
    #[must_use]
    pub fn is_modular(&self) -> bool {
        self.general.modular_station.unwrap_or(false)
    }

    /// Number of modules that the station takes: Max_Module, 1 for a compact station, 244 if the file does not say.
    #[must_use]
    pub fn max_modules(&self) -> usize {
        if !self.is_modular() {
            return 1;
        }
        self.general.max_module.map_or(244, |most| usize::try_from(most).unwrap_or(usize::MAX))
    }

    /// What the file says about a baud rate in bit/s.
    ///
    /// ```
    /// use profivac_gsd::GsdFile;
    ///
    /// let file = GsdFile::read(b"#Profibus_DP\n1.5M_supp = 1\nMaxTsdr_1.5M = 150\n45.45_supp = 0\n");
    /// let device = file.device();
    /// assert_eq!(device.rate(1_500_000).and_then(|rate| rate.max_tsdr), Some(150));
    /// assert_eq!(device.rate(45_450).and_then(|rate| rate.supported), Some(false));
    /// assert_eq!(device.rate(9_600), None);
    /// ```
    #[must_use]
    pub fn rate(&self, bits_per_second: u32) -> Option<&Rate> {
        self.rates.iter().find(|rate| rate.bits_per_second() == Some(bits_per_second))
    }

    /// Whether the slave has a baud rate in bit/s. chosen: it has every rate if the file lists none.
    ///
    /// # Errors
    ///
    /// The rates that the file lists.
    ///
    /// ```
    /// use profivac_gsd::GsdFile;
    ///
    /// let file = GsdFile::read(b"#Profibus_DP\n9.6_supp = 1\n1.5M_supp = 1\n12M_supp = 0\n");
    /// assert_eq!(file.device().check_rate(1_500_000), Ok(()));
    /// let error = file.device().check_rate(12_000_000).unwrap_err();
    /// assert_eq!(error.to_string(), "the GSD file does not have 12 Mbit/s; it has 9.6 kbit/s, 1.5 Mbit/s");
    /// ```
    pub fn check_rate(&self, bits_per_second: u32) -> Result<(), RateError> {
        let rates: Vec<_> = self.rates.iter().filter(|rate| rate.supported == Some(true)).collect();
        if rates.is_empty() || rates.iter().any(|rate| rate.bits_per_second() == Some(bits_per_second)) {
            return Ok(());
        }
        Err(RateError { bits_per_second, possible: list(rates.iter().map(ToString::to_string)) })
    }

    /// The parameters to which an area refers.
    pub(crate) fn parameters_of<'a>(&'a self, area: &'a PrmArea) -> impl Iterator<Item = &'a Parameter> {
        area.items.iter().filter_map(|item| match item.content {
            PrmContent::Ref(number) => self.parameters.get(&number),
            PrmContent::Const(_) => None,
        })
    }

    /// The text for a value of a parameter.
    #[must_use]
    pub fn text_of<'a>(&'a self, parameter: &Parameter, value: i64) -> Option<&'a str> {
        self.texts.get(&parameter.texts?)?.texts.get(&value).map(String::as_str)
    }

    /// The possible values of a parameter in words: `0 (open), 1 (closed)` or `-5 to 20`. The first twenty; the others are counted.
    #[must_use]
    pub fn values_of(&self, parameter: &Parameter) -> String {
        let whole = [parameter.kind.limits()];
        let allowed = if parameter.allowed.is_empty() { &whole } else { parameter.allowed.as_slice() };
        let texts =
            parameter.texts.and_then(|number| self.texts.get(&number)).into_iter().flat_map(|texts| &texts.texts);
        let named: Vec<_> = texts.filter(|(value, _)| parameter.allows(**value)).collect();
        if !named.is_empty() {
            return list(named.iter().map(|(value, text)| format!("{value} ({text})")));
        }
        list(allowed.iter().map(|(low, high)| if low == high { low.to_string() } else { format!("{low} to {high}") }))
    }
}
