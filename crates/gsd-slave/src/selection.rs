//! Which modules are plugged and which parameters are changed, as people write it.

use profivac_gsd::{Configuration, ConfigurationError, Device, Module, Place, PrmError, Target};
use serde::Deserialize;
use serde::de::{self, Deserializer, MapAccess, SeqAccess, Visitor};
use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;
use std::str::FromStr;
use thiserror::Error;

/// Modules and changed parameters of a slave, not yet checked against a file.
///
/// ```
/// use profivac_gsd_slave::{Change, Selection};
///
/// let selection = Selection::from_toml(r#"
/// [modules]
/// 1 = "4DI"
/// 5 = 7
///
/// [parameters]
/// "Start = up" = "on"
///
/// [slot.5.parameters]
/// Delay = 9
/// "#)?;
/// assert_eq!(selection.changes[1], Change { slot: Some(5), target: "Delay".into(), value: "9".into() });
/// # Ok::<(), profivac_gsd_slave::SelectionError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// The modules in their slots.
    pub modules: Modules,
    /// The changed parameters, in the order in which they are set.
    pub changes: Vec<Change>,
}

/// The modules of a slave.
///
/// As text the numbers of the file in slot order, `3+7`. In TOML this text, a list of numbers and names in slot order, or a table from
/// slots to numbers and names.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Modules {
    /// The modules that the file presets.
    #[default]
    Preset,
    /// In the slots from the first on.
    InOrder(Vec<ModuleChoice>),
    /// By slot.
    Slots(BTreeMap<u32, ModuleChoice>),
}

/// A module by its number or its name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ModuleChoice {
    /// The number in the file.
    Number(u32),
    /// The name in the file; blanks at its ends do not count.
    Name(String),
}

/// A changed parameter. As text `NAME=VALUE`, where the last `=` separates.
///
/// The target is the parameter's name in the file. If several parameters have the name, place and `:` stand in front: `SLOT:NAME`,
/// `station:NAME`, `SLOT@OFFSET:NAME` or `SLOT@OFFSET.BIT:NAME`. A name of the file that looks like this counts first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// The slot, if it stands outside the target.
    pub slot: Option<u32>,
    /// The name, with place if needed.
    pub target: String,
    /// The value: a number or the file's text for it.
    pub value: String,
}

/// A value of a parameter in TOML: a text or a whole number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Value(pub String);

/// Why a selection does not fit a file, or cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SelectionError {
    /// The text is no list of module numbers.
    #[error("expected module numbers of the file in slot order like 3+7, got {0:?}")]
    Modules(String),
    /// The text is no change of a parameter.
    #[error("expected NAME=VALUE, got {0:?}")]
    Change(String),
    /// The TOML text has an error.
    #[error("{0}")]
    Toml(String),
    /// No module has the name.
    #[error("the file has no module {name:?}{}; it has {possible}", did_you_mean(.suggestion))]
    UnknownModule {
        /// The name.
        name: String,
        /// The most similar name.
        suggestion: Option<String>,
        /// The modules of the file.
        possible: String,
    },
    /// Several modules have the name.
    #[error("several modules are called {name:?}; give a number: {possible}")]
    ModuleNameTwice {
        /// The name.
        name: String,
        /// The numbers of these modules.
        possible: String,
    },
    /// The modules do not fit the device.
    #[error("{0}")]
    Configuration(#[from] ConfigurationError),
    /// The target names another slot than the one in which it stands.
    #[error(
        "{target:?} stands in slot {slot} and names another place; write it in the table of its place, or without a place"
    )]
    Place {
        /// The slot in which it stands.
        slot: u32,
        /// The name with its place.
        target: String,
    },
    /// A parameter cannot be changed like this.
    #[error("{error}{}{}", did_you_mean(.suggestion), places(.error))]
    Parameter {
        /// What is wrong.
        error: PrmError,
        /// The most similar name.
        suggestion: Option<String>,
    },
}

impl From<PrmError> for SelectionError {
    fn from(error: PrmError) -> Self {
        Self::Parameter { error, suggestion: None }
    }
}

fn did_you_mean(suggestion: &Option<String>) -> String {
    suggestion.as_ref().map_or_else(String::new, |name| format!("; did you mean {name:?}?"))
}

fn places(error: &PrmError) -> &'static str {
    match error {
        PrmError::Ambiguous { .. } => "; write SLOT:NAME, SLOT@OFFSET:NAME or SLOT@OFFSET.BIT:NAME",
        _ => "",
    }
}

impl Selection {
    /// Reads a TOML text: `[modules]` with `SLOT = "NAME"` or `SLOT = NUMBER` (or `modules = [3, "NAME"]` in slot order),
    /// `[parameters]` with `"NAME" = "VALUE"`, and `[slot.3.parameters]` for a slot.
    ///
    /// # Errors
    ///
    /// [`SelectionError::Toml`] with line and column.
    pub fn from_toml(text: &str) -> Result<Self, SelectionError> {
        let table: Table =
            toml::from_str(text).map_err(|error| SelectionError::Toml(error.to_string().trim_end().to_owned()))?;
        let mut changes = changes(None, table.parameters);
        for (slot, content) in table.slot.0 {
            changes.extend(self::changes(Some(slot), content.parameters));
        }
        Ok(Self { modules: table.modules, changes })
    }

    /// The configuration of a device with these modules and changes.
    ///
    /// # Errors
    ///
    /// [`SelectionError`] says which module or parameter, and what is possible.
    pub fn configure<'d>(&self, device: &'d Device) -> Result<Configuration<'d>, SelectionError> {
        let mut configuration = self.modules.plug(device)?;
        for change in &self.changes {
            change.apply(&mut configuration)?;
        }
        Ok(configuration)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    #[serde(default)]
    modules: Modules,
    #[serde(default)]
    parameters: BTreeMap<String, Value>,
    #[serde(default)]
    slot: BySlot<SlotTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SlotTable {
    parameters: BTreeMap<String, Value>,
}

fn changes(slot: Option<u32>, parameters: BTreeMap<String, Value>) -> Vec<Change> {
    parameters.into_iter().map(|(target, Value(value))| Change { slot, target, value }).collect()
}

impl Modules {
    fn plug<'d>(&self, device: &'d Device) -> Result<Configuration<'d>, SelectionError> {
        match self {
            Self::Preset => Ok(Configuration::preset(device)?),
            Self::InOrder(modules) => {
                let modules = modules.iter().map(|choice| choice.module(device)).collect::<Result<_, _>>()?;
                Ok(Configuration::of(device, modules)?)
            }
            Self::Slots(slots) => {
                let module = |(slot, choice): (&u32, &ModuleChoice)| Ok((*slot, choice.module(device)?));
                let modules = slots.iter().map(module).collect::<Result<Vec<_>, SelectionError>>()?;
                Ok(Configuration::in_slots(device, modules)?)
            }
        }
    }
}

impl FromStr for Modules {
    type Err = SelectionError;

    fn from_str(text: &str) -> Result<Self, SelectionError> {
        let number = |part: &str| part.trim().parse().map(ModuleChoice::Number);
        let numbers = text.split('+').map(number).collect::<Result<_, _>>();
        numbers.map(Self::InOrder).map_err(|_| SelectionError::Modules(text.to_owned()))
    }
}

impl ModuleChoice {
    fn module<'d>(&self, device: &'d Device) -> Result<&'d Module, SelectionError> {
        match self {
            Self::Number(number) => device.module(*number).ok_or_else(|| {
                ConfigurationError::UnknownModule { number: *number, possible: possible(device.modules.iter()) }.into()
            }),
            Self::Name(name) => named(device, name),
        }
    }
}

fn named<'d>(device: &'d Device, name: &str) -> Result<&'d Module, SelectionError> {
    let found: Vec<_> = device.modules_named(name).collect();
    match found.as_slice() {
        [only] => Ok(only),
        [] => Err(SelectionError::UnknownModule {
            name: name.to_owned(),
            suggestion: closest(name, device.modules.iter().map(|module| module.name.as_str())),
            possible: possible(device.modules.iter()),
        }),
        several => {
            Err(SelectionError::ModuleNameTwice { name: name.to_owned(), possible: possible(several.iter().copied()) })
        }
    }
}

/// At most this many modules are listed.
const MOST: usize = 20;

/// Modules in a message, with their configuration octets if names repeat; what is beyond twenty is counted.
fn possible<'d>(modules: impl Iterator<Item = &'d Module>) -> String {
    let all: Vec<_> = modules.map(|module| format!("{} ({})", module.number, module.name)).collect();
    let shown = all.get(..MOST.min(all.len())).unwrap_or_default().join(", ");
    match all.len().saturating_sub(MOST) {
        0 if all.is_empty() => "none".to_owned(),
        0 => shown,
        more => format!("{shown} and {more} more, see `profivac gsd show`"),
    }
}

impl Change {
    /// Sets the parameter.
    ///
    /// # Errors
    ///
    /// [`SelectionError::Parameter`] says what is possible.
    pub fn apply(&self, configuration: &mut Configuration<'_>) -> Result<(), SelectionError> {
        let parameters = configuration.parameters();
        let is_name = |name: &str| parameters.iter().any(|one| one.parameter.name == name.trim());
        let target = self.target(is_name)?;
        let suggestion = || closest(target.name, parameters.iter().map(|one| one.parameter.name.as_str()));
        configuration.set(target, &self.value).map_err(|error| {
            let suggestion = matches!(error, PrmError::Unknown { .. }).then(suggestion).flatten();
            SelectionError::Parameter { error, suggestion }
        })
    }

    /// The name as a whole if the file has it, else the name behind the place.
    fn target(&self, is_name: impl Fn(&str) -> bool) -> Result<Target<'_>, SelectionError> {
        let place = self.slot.map(Place::Slot);
        let whole = Target { name: &self.target, place, ..Target::default() };
        if is_name(&self.target) {
            return Ok(whole);
        }
        let Some((head, name)) = self.target.split_once(':') else { return Ok(whole) };
        let Some(found) = placed(head, name) else { return Ok(whole) };
        match self.slot {
            Some(slot) if found.place.is_some_and(|other| other != Place::Slot(slot)) => {
                Err(SelectionError::Place { slot, target: self.target.clone() })
            }
            _ => Ok(Target { place: place.or(found.place), ..found }),
        }
    }
}

/// A place as people write it: `3`, `station`, `3@12`, `3@12.4` or `@12`.
fn placed<'t>(head: &str, name: &'t str) -> Option<Target<'t>> {
    let (place, octet) = head.trim().split_once('@').map_or((head.trim(), None), |(place, octet)| (place, Some(octet)));
    let place = match place {
        "" => None,
        "station" => Some(Place::Station),
        slot => Some(Place::Slot(slot.parse().ok()?)),
    };
    let (offset, bit) = match octet.map(|octet| octet.split_once('.').unwrap_or((octet, ""))) {
        None => (None, None),
        Some((offset, "")) => (Some(offset.parse().ok()?), None),
        Some((offset, bit)) => (Some(offset.parse().ok()?), Some(bit.parse().ok()?)),
    };
    (place.is_some() || offset.is_some()).then_some(Target { name, place, offset, bit })
}

impl FromStr for Change {
    type Err = SelectionError;

    fn from_str(text: &str) -> Result<Self, SelectionError> {
        let (target, value) = text.rsplit_once('=').ok_or_else(|| SelectionError::Change(text.to_owned()))?;
        if target.trim().is_empty() {
            return Err(SelectionError::Change(text.to_owned()));
        }
        Ok(Self { slot: None, target: target.trim().to_owned(), value: value.trim().to_owned() })
    }
}

/// The least similarity of a suggestion: half of the letters are in place.
const MIN_SIMILARITY: f64 = 0.5;

/// The longest name that is compared: the work grows with the square. chosen: names of files have 32 characters.
const MAX_COMPARED: usize = 200;

fn closest<'a>(name: &str, candidates: impl Iterator<Item = &'a str>) -> Option<String> {
    if name.len() > MAX_COMPARED {
        return None;
    }
    let candidates = candidates.filter(|candidate| candidate.len() <= MAX_COMPARED);
    let similarity = |other: &str| strsim::normalized_damerau_levenshtein(&name.to_lowercase(), &other.to_lowercase());
    let best =
        candidates.map(|candidate| (similarity(candidate), candidate)).max_by(|one, two| one.0.total_cmp(&two.0))?;
    (best.0 >= MIN_SIMILARITY).then(|| best.1.to_owned())
}

impl<'de> Deserialize<'de> for Value {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Text;
        impl Visitor<'_> for Text {
            type Value = Value;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a text of the file or a whole number")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Value, E> {
                Ok(Value(text.to_owned()))
            }

            fn visit_i64<E: de::Error>(self, number: i64) -> Result<Value, E> {
                Ok(Value(number.to_string()))
            }
        }
        deserializer.deserialize_any(Text)
    }
}

impl<'de> Deserialize<'de> for ModuleChoice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Choice;
        impl Visitor<'_> for Choice {
            type Value = ModuleChoice;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the name or the number of a module in the GSD file")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<ModuleChoice, E> {
                Ok(ModuleChoice::Name(text.to_owned()))
            }

            fn visit_i64<E: de::Error>(self, number: i64) -> Result<ModuleChoice, E> {
                let wrong = |_| E::invalid_value(de::Unexpected::Signed(number), &self);
                u32::try_from(number).map(ModuleChoice::Number).map_err(wrong)
            }
        }
        deserializer.deserialize_any(Choice)
    }
}

/// A table by the number of the slot, which stands there once: `1` and `01` are one slot.
struct BySlot<T>(BTreeMap<u32, T>);

impl<T> Default for BySlot<T> {
    fn default() -> Self {
        Self(BTreeMap::new())
    }
}

impl<T> BySlot<T> {
    fn read<'de, A: MapAccess<'de>>(table: &mut A) -> Result<Self, A::Error>
    where
        T: Deserialize<'de>,
    {
        let mut slots = BTreeMap::new();
        while let Some((slot, content)) = table.next_entry::<String, T>()? {
            let number: u32 = slot
                .trim()
                .parse()
                .map_err(|_| de::Error::custom(format!("expected the number of a slot on the left, got {slot:?}")))?;
            if slots.insert(number, content).is_some() {
                return Err(de::Error::custom(format!("expected each slot once, got slot {number} twice")));
            }
        }
        Ok(Self(slots))
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for BySlot<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Slots<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Slots<T> {
            type Value = BySlot<T>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a table by slot")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut table: A) -> Result<BySlot<T>, A::Error> {
                BySlot::read(&mut table)
            }
        }
        deserializer.deserialize_map(Slots(PhantomData))
    }
}

impl<'de> Deserialize<'de> for Modules {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Choices;
        impl<'de> Visitor<'de> for Choices {
            type Value = Modules;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("module numbers like \"3+7\", a list of modules, or a table SLOT = MODULE")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Modules, E> {
                text.parse().map_err(E::custom)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Modules, A::Error> {
                let mut modules = Vec::new();
                while let Some(module) = list.next_element()? {
                    modules.push(module);
                }
                Ok(Modules::InOrder(modules))
            }

            fn visit_map<A: MapAccess<'de>>(self, mut table: A) -> Result<Modules, A::Error> {
                let BySlot(slots) = BySlot::read(&mut table)?;
                Ok(Modules::Slots(slots))
            }
        }
        deserializer.deserialize_any(Choices)
    }
}
