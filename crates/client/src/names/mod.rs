//! Finds the parameters and commands of a device by the words or the numbers of its manual.
//!
//! `pirani.process-value`, `trip-point.1/high-trip-point`, `1/19` (slot and index), `1:2/19` (of instance 2). Case, blanks
//! and hyphens do not matter. To read, a word that only one parameter has is enough, and so is the beginning of a name: `serial`
//! finds `device.serial-number`, and `pressure` the process value. A write needs the whole name.

#[cfg(test)]
mod tests;

use crate::suggestion::similarity;
use profivac_devices::catalog::MODELS;
use profivac_devices::model::{Block, Code, Location, Model, Role, Row};
use std::fmt;
use std::sync::{LazyLock, PoisonError, RwLock};

/// A parameter and its location.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Slot and instance.
    pub location: &'static Location,
    /// The block.
    pub block: &'static Block,
    /// The row of the table.
    pub row: &'static Row,
}

/// The number of suggestions in an error.
const SUGGESTIONS: usize = 3;

/// The similarity from which a name is suggested, 0 to 1. Long names with the same block are similar already. chosen.
const MIN_SIMILARITY: f64 = 0.75;

/// The parameters of a device with their names.
///
/// ```
/// use profivac_client::names::{ParameterNames, Target};
/// use profivac_devices::catalog::model_named;
///
/// let names = ParameterNames::of(model_named("bcg450").ok_or("no such model")?);
/// for text in ["pirani.process-value", "Pirani Process Value", "1:1/19"] {
///     let Target::Parameter(named) = names.find("bcg450", text)? else { return Err("ambiguous".into()) };
///     assert_eq!(named.to_string(), "pirani.process-value (1:1/19)");
/// }
/// let (named, code) = names.command("degas on")?.ok_or("no such command")?;
/// assert_eq!(profivac_client::names::command_name(named, code), "ba.degas-on");
/// let unknown = names.find("bcg450", "pirani.proces-value").unwrap_err().to_string();
/// assert!(unknown.contains("did you mean pirani.process-value"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct ParameterNames {
    list: Vec<NamedParameter>,
}

/// A parameter with its name.
#[derive(Clone, Debug)]
pub struct NamedParameter {
    /// The parameter.
    pub parameter: Parameter,
    /// The name: `pirani.process-value`.
    pub name: String,
    /// The letters and digits of every accepted name.
    keys: Vec<String>,
}

/// The result of a search.
#[derive(Clone, Copy, Debug)]
pub enum Target<'a> {
    /// One parameter.
    Parameter(&'a NamedParameter),
    /// The parameter at this slot and index of the instance that the slot shows.
    CurrentInstance {
        /// The slot.
        slot: u8,
        /// The index.
        index: u8,
    },
    /// A record outside the tables.
    Raw {
        /// The slot.
        slot: u8,
        /// The index.
        index: u8,
    },
}

/// The reason why a search failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TargetError {
    /// No parameter or command has this name.
    #[error("{device} has no parameter or command {text:?}{}", suggestion(.alike))]
    Unknown {
        /// The device.
        device: &'static str,
        /// The text that was searched for.
        text: String,
        /// The most similar names.
        alike: Vec<String>,
    },
    /// Several parameters or commands have this name.
    #[error("{text:?} is ambiguous: it may be {}", candidates.join(", "))]
    Ambiguous {
        /// The text that was searched for.
        text: String,
        /// Their names.
        candidates: Vec<String>,
    },
    /// The numbers are not a slot, an instance and an index.
    #[error("expected SLOT/INDEX or SLOT:INSTANCE/INDEX with numbers from 0 to 254, got {0:?}")]
    InvalidNumbers(String),
    /// No table has a parameter at this slot and index with this instance.
    #[error("{device} has no parameter {text}; {}", other_instances(.known))]
    UnknownInstance {
        /// The device.
        device: &'static str,
        /// The numbers that were searched for.
        text: String,
        /// The numbers of the parameters at this slot and index, none for a record outside the tables.
        known: Vec<String>,
    },
}

fn other_instances(known: &[String]) -> String {
    if known.is_empty() {
        return "a record outside its tables has no instance: expected SLOT/INDEX".to_owned();
    }
    format!("expected {}", known.join(" or "))
}

fn suggestion(alike: &[String]) -> String {
    if alike.is_empty() { String::new() } else { format!("; did you mean {}?", alike.join(" or ")) }
}

impl fmt::Display for NamedParameter {
    /// The name with the numbers.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.name, self.parameter.numbers())
    }
}

impl NamedParameter {
    /// Whether both parameters have the same slot and instance.
    ///
    /// ```
    /// use profivac_client::names::ParameterNames;
    /// use profivac_devices::catalog::model_named;
    ///
    /// let names = ParameterNames::of(model_named("bcg450").ok_or("no such model")?);
    /// let pirani = names.at(1, 1, 19).ok_or("no such parameter")?;
    /// assert!(names.at(1, 1, 39).is_some_and(|named| named.is_same_instance(pirani)));
    /// assert!(names.at(1, 2, 19).is_some_and(|named| !named.is_same_instance(pirani)));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn is_same_instance(&self, other: &Self) -> bool {
        let (location, other) = (self.parameter.location, other.parameter.location);
        (location.slot, location.instance) == (other.slot, other.instance)
    }
}

impl NamedParameter {
    /// Whether this is a process value that `wanted` calls a pressure: `pressure`, `piranipressure`.
    fn is_pressure(&self, wanted: &str) -> bool {
        let part = wanted.strip_suffix("pressure").filter(|_| self.parameter.row.role == Some(Role::ProcessValue));
        part.is_some_and(|part| part.is_empty() || part == key(self.parameter.location.name))
    }

    /// Whether a search for `text` shows this parameter: its name, a command or code, its index, or its numbers with or without an
    /// instance contain it.
    ///
    /// ```
    /// use profivac_client::names::ParameterNames;
    /// use profivac_devices::catalog::model_named;
    ///
    /// let names = ParameterNames::of(model_named("bcg450").ok_or("no such model")?);
    /// let found = |text: &str| names.all().iter().filter(|named| named.is_found_by(text)).count();
    /// assert_eq!((found("1:2/19"), found("degas on"), found("nonsense")), (1, 1, 0));
    /// assert_eq!(found("1/19"), names.at_index(1, 19).count());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn is_found_by(&self, text: &str) -> bool {
        let Parameter { location, row, .. } = self.parameter;
        if let Ok(index) = text.parse::<u8>() {
            return row.index == index;
        }
        if let Some((slot, instance, index)) = numbers(text) {
            let is_instance = instance.is_none_or(|instance| instance == location.instance);
            return (location.slot, row.index) == (slot, index) && is_instance;
        }
        let wanted = slug(text);
        [&self.name, row.name].iter().any(|name| slug(name).contains(&wanted))
            || self.is_pressure(&key(text))
            || row.codes.codes().iter().any(|code| slug(&command_name(self, code)).contains(&wanted))
    }
}

/// The row that opens the set of a block for changes and closes it: i9973ber/a 3.2.4.2.
fn lock(block: &Block) -> Option<&'static Row> {
    block.rows.iter().find(|row| row.role == Some(Role::SetLock))
}

impl NamedParameter {
    /// The row that opens the set of this parameter, if it belongs to a set.
    fn lock(&self) -> Option<&'static Row> {
        let Parameter { row, block, .. } = self.parameter;
        lock(block).filter(|lock| lock.index != row.index)
    }

    /// The name of the parameter that opens the set of this one, if it belongs to a set.
    pub(super) fn lock_name(&self) -> Option<String> {
        let location = self.name.rsplit_once(['.', '/']).map_or("", |(location, _)| location);
        let separator = if location.contains('.') { '/' } else { '.' };
        self.lock().map(|lock| format!("{location}{separator}{}", slug(lock.name)))
    }
}

impl Parameter {
    /// `1/19`, or `1:2/19` where several instances share the slot.
    ///
    /// ```
    /// use profivac_client::names::ParameterNames;
    /// use profivac_devices::catalog::model_named;
    ///
    /// let names = ParameterNames::of(model_named("bcg450").ok_or("no such model")?);
    /// let numbers = |slot, instance, index| names.at(slot, instance, index).map(|named| named.parameter.numbers());
    /// assert_eq!((numbers(0, 0, 25).as_deref(), numbers(1, 2, 19).as_deref()), (Some("0/25"), Some("1:2/19")));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn numbers(&self) -> String {
        let Location { slot, instance, .. } = self.location;
        match instance {
            0 => format!("{slot}/{}", self.row.index),
            _ => format!("{slot}:{instance}/{}", self.row.index),
        }
    }

    /// Whether both have the same slot, instance and index.
    fn is_at(&self, other: &Self) -> bool {
        (self.location.slot, self.location.instance, self.row.index)
            == (other.location.slot, other.location.instance, other.row.index)
    }
}

impl ParameterNames {
    /// The parameters of a model with their names.
    #[must_use]
    pub fn of(model: &'static Model) -> Self {
        let mut all: Vec<Parameter> = Vec::new();
        for placed in model.blocks {
            for (address, row) in
                placed.locations.iter().flat_map(|it| placed.block.rows.iter().map(move |row| (it, row)))
            {
                let parameter = Parameter { location: address, block: placed.block, row };
                // Two blocks with the same rows may be at one location: the device decides which of them is present.
                if !all.iter().any(|other| other.is_at(&parameter)) {
                    all.push(parameter);
                }
            }
        }
        all.sort_by_key(|parameter| (parameter.location.slot, parameter.location.instance));
        let words: Vec<Words> = all.into_iter().map(Words::of).collect();
        Self { list: words.iter().map(|it| NamedParameter::from_words(it, &words)).collect() }
    }

    /// The parameters of a model, computed once per process.
    ///
    /// ```
    /// use profivac_client::names::ParameterNames;
    /// use profivac_devices::catalog::model_named;
    ///
    /// let names = ParameterNames::shared(model_named("bcg450").ok_or("no such model")?);
    /// // Slot 1, instance 1, index 19, and the same index of each instance.
    /// let pirani = names.at(1, 1, 19).ok_or("no such parameter")?;
    /// assert_eq!((pirani.name.as_str(), pirani.parameter.numbers().as_str()), ("pirani.process-value", "1:1/19"));
    /// assert_eq!(names.at_index(1, 19).filter(|named| named.is_same_instance(pirani)).count(), 1);
    /// assert!(names.commands().any(|(_, code)| code.name == "degas-on"));
    /// // Parameters of a TPG300 belong to sets; those of a BCG450 do not.
    /// assert!(names.lock_of(pirani).is_none());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn shared(model: &'static Model) -> &'static Self {
        static BUILT_IN: LazyLock<Vec<ParameterNames>> =
            LazyLock::new(|| MODELS.iter().map(|model| ParameterNames::of(model)).collect());
        // Those of device files, and of the model that stands for several devices. A model is never freed, and neither are its names.
        static OTHERS: RwLock<Vec<(&'static Model, &'static ParameterNames)>> = RwLock::new(Vec::new());
        let of = |known: &[(&'static Model, &'static Self)]| {
            known.iter().find(|(other, _)| *other == model).map(|(_, names)| *names)
        };
        let built_in = MODELS.iter().position(|known| *known == model).and_then(|position| BUILT_IN.get(position));
        if let Some(names) = built_in.or_else(|| of(&OTHERS.read().unwrap_or_else(PoisonError::into_inner))) {
            return names;
        }
        let mut others = OTHERS.write().unwrap_or_else(PoisonError::into_inner);
        if let Some(names) = of(&others) {
            return names;
        }
        let names: &'static Self = Box::leak(Box::new(Self::of(model)));
        others.push((model, names));
        names
    }

    /// All parameters, by slot, instance and table.
    #[must_use]
    pub fn all(&self) -> &[NamedParameter] {
        &self.list
    }

    /// The parameter at these numbers.
    #[must_use]
    pub fn at(&self, slot: u8, instance: u8, index: u8) -> Option<&NamedParameter> {
        self.list.iter().find(|named| {
            let Parameter { location, row, .. } = named.parameter;
            (location.slot, location.instance, row.index) == (slot, instance, index)
        })
    }

    /// The parameter that opens the set of `named` for changes, if it belongs to a set.
    #[must_use]
    pub fn lock_of(&self, named: &NamedParameter) -> Option<&NamedParameter> {
        let location = named.parameter.location;
        self.at(location.slot, location.instance, named.lock()?.index)
    }

    /// The parameters at this slot and index, one for each instance.
    pub fn at_index(&self, slot: u8, index: u8) -> impl Iterator<Item = &NamedParameter> {
        self.list
            .iter()
            .filter(move |named| (named.parameter.location.slot, named.parameter.row.index) == (slot, index))
    }

    /// Finds the parameter that `text` names, to read it: an abbreviation is enough. `device` is the name of the model, for the
    /// text of an error.
    ///
    /// # Errors
    /// [`TargetError`] with the most similar names, or with all that match.
    pub fn find(&self, device: &'static str, text: &str) -> Result<Target<'_>, TargetError> {
        if is_numbers(text) {
            return self.by_numbers(device, text);
        }
        let mut found = self.whole(text);
        if found.is_empty() {
            found = self.abbreviated(text);
        }
        only(text, &found)
            .unwrap_or_else(|| Err(TargetError::Unknown { device, text: text.to_owned(), alike: self.similar(text) }))
    }

    /// Finds the parameter that `text` names, to write it: the whole name or the numbers, no abbreviation.
    ///
    /// ```
    /// use profivac_client::names::ParameterNames;
    /// use profivac_devices::catalog::model_named;
    ///
    /// let names = ParameterNames::of(model_named("bcg450").ok_or("no such model")?);
    /// assert!(names.find_whole("bcg450", "pirani.safe-state").is_ok());
    /// let refused = names.find_whole("bcg450", "pirani.safe-s").unwrap_err().to_string();
    /// assert!(refused.ends_with("did you mean pirani.safe-state?"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`TargetError`] with the names that the text abbreviates or resembles, or with all that match.
    pub fn find_whole(&self, device: &'static str, text: &str) -> Result<Target<'_>, TargetError> {
        if is_numbers(text) {
            return self.by_numbers(device, text);
        }
        only(text, &self.whole(text)).unwrap_or_else(|| {
            let mut alike = self.similar(text);
            if alike.is_empty() {
                alike = self.abbreviated(text).iter().take(SUGGESTIONS).map(|named| named.name.clone()).collect();
            }
            Err(TargetError::Unknown { device, text: text.to_owned(), alike })
        })
    }

    /// The parameters with this name, or with this name in their block.
    fn whole(&self, text: &str) -> Vec<&NamedParameter> {
        let wanted = key(text);
        let found = self.filtered(|named| named.keys.contains(&wanted));
        if found.is_empty() {
            return self.filtered(|named| row_keys(named.parameter.row, named.parameter.block).contains(&wanted));
        }
        found
    }

    /// The parameters whose name `text` abbreviates: `pressure` for a process value, the beginning of a name, the beginning of a
    /// word. The first of these that fits counts.
    fn abbreviated(&self, text: &str) -> Vec<&NamedParameter> {
        let wanted = key(text);
        if wanted.is_empty() {
            return Vec::new();
        }
        let begins = |text: &str| key(text).starts_with(&wanted);
        let steps: [&dyn Fn(&NamedParameter) -> bool; 3] = [
            &|named| named.is_pressure(&wanted),
            &|named| named.keys.iter().any(|key| key.starts_with(&wanted)),
            &|named| {
                let row = row_slug(named.parameter.row, named.parameter.block);
                begins(&row) || row.match_indices('-').any(|(at, _)| row.get(at..).is_some_and(begins))
            },
        ];
        steps.into_iter().map(|fits| self.filtered(fits)).find(|found| !found.is_empty()).unwrap_or_default()
    }

    fn filtered(&self, fits: impl Fn(&NamedParameter) -> bool) -> Vec<&NamedParameter> {
        self.list.iter().filter(|named| fits(named)).collect()
    }

    fn by_numbers(&self, device: &'static str, text: &str) -> Result<Target<'_>, TargetError> {
        let (slot, instance, index) = numbers(text).ok_or_else(|| TargetError::InvalidNumbers(text.to_owned()))?;
        if let Some(instance) = instance {
            return self.at(slot, instance, index).map(Target::Parameter).ok_or_else(|| {
                let known = self.at_index(slot, index).map(|named| named.parameter.numbers()).collect();
                TargetError::UnknownInstance { device, text: text.to_owned(), known }
            });
        }
        let mut found = self.at_index(slot, index);
        Ok(match (found.next(), found.next()) {
            (None, _) => Target::Raw { slot, index },
            (Some(only), None) => Target::Parameter(only),
            (Some(_), Some(_)) => Target::CurrentInstance { slot, index },
        })
    }

    /// The names most similar to `text`.
    fn similar(&self, text: &str) -> Vec<String> {
        let wanted = slug(text);
        let likeness = |name: &str| {
            let row = name.rsplit(['.', '/']).next().unwrap_or(name);
            similarity(&wanted, &slug(name)).max(similarity(&wanted, row))
        };
        let parameters = self.list.iter().map(|named| named.name.clone());
        // A command without its last word: `degas` in place of `degas on`.
        let begin = format!("{wanted}-");
        let commands = self.commands().map(|(named, code)| {
            let name = command_name(named, code);
            (if code.name.starts_with(&begin) { 1.0 } else { likeness(&name) }, name)
        });
        let mut alike: Vec<_> = parameters.map(|name| (likeness(&name), name)).chain(commands).collect();
        alike.retain(|(likeness, _)| *likeness >= MIN_SIMILARITY);
        alike.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        alike.into_iter().take(SUGGESTIONS).map(|(_, name)| name).collect()
    }

    /// Finds the command that `text` names: `execute`, `degas on`, `channel.1/degas on`. `None` if no command has this
    /// name.
    ///
    /// # Errors
    /// [`TargetError::Ambiguous`] when several instances have the command.
    pub fn command(&self, text: &str) -> Result<Option<(&NamedParameter, &'static Code)>, TargetError> {
        let wanted = key(text);
        let is_called = |named: &NamedParameter, code: &Code| {
            let command = key(code.name);
            let locations = named.keys.iter().cloned().chain([key(named.parameter.location.name)]);
            wanted == command || locations.into_iter().any(|location| wanted == location + &command)
        };
        let found: Vec<_> = self.commands().filter(|(named, code)| is_called(named, code)).collect();
        match found[..] {
            [] => Ok(None),
            [only] => Ok(Some(only)),
            _ => {
                let candidates = found.iter().map(|(named, code)| command_name(named, code)).collect();
                Err(TargetError::Ambiguous { text: text.to_owned(), candidates })
            }
        }
    }

    /// All commands of the device.
    pub fn commands(&self) -> impl Iterator<Item = (&NamedParameter, &'static Code)> {
        let orders = self.list.iter().filter(|named| named.parameter.row.codes.is_command());
        orders.flat_map(|named| named.parameter.row.codes.codes().iter().map(move |code| (named, code)))
    }
}

/// The name of a command: `cdg.zero-adjust`.
#[must_use]
pub fn command_name(named: &NamedParameter, code: &Code) -> String {
    let location = named.parameter.location;
    format!("{}{}{}", location_slug(location), separator(location), code.name)
}

/// Whether the text is to be read as numbers: `1/19`.
fn is_numbers(text: &str) -> bool {
    text.starts_with(|first: char| first.is_ascii_digit()) && text.contains('/')
}

/// The only parameter found, an error for several, `None` for none.
fn only<'a>(text: &str, found: &[&'a NamedParameter]) -> Option<Result<Target<'a>, TargetError>> {
    match found {
        [] => None,
        [only] => Some(Ok(Target::Parameter(only))),
        several => {
            let candidates = several.iter().map(ToString::to_string).collect();
            Some(Err(TargetError::Ambiguous { text: text.to_owned(), candidates }))
        }
    }
}

/// Slot, instance and index of `1/19` and `1:2/19`.
///
/// ```
/// assert_eq!(profivac_client::names::numbers("1:2/19"), Some((1, Some(2), 19)));
/// assert_eq!(profivac_client::names::numbers("1/255"), None);
/// ```
#[must_use]
pub fn numbers(text: &str) -> Option<(u8, Option<u8>, u8)> {
    let number = |text: &str| text.parse().ok().filter(|number| *number < u8::MAX);
    let (location, index) = text.split_once('/')?;
    let (slot, instance) = match location.split_once(':') {
        Some((slot, instance)) => (slot, Some(number(instance)?)),
        None => (location, None),
    };
    Some((number(slot)?, instance, number(index)?))
}

/// The words of a parameter.
struct Words {
    parameter: Parameter,
    /// The words of the location, the block and the row.
    location: String,
    block: String,
    row: String,
}

impl Words {
    fn of(parameter: Parameter) -> Self {
        let Parameter { location, block, row } = parameter;
        Self { parameter, location: location_slug(location), block: slug(block.name), row: row_slug(row, block) }
    }

    /// Whether another location with the same name has a parameter with the same name.
    fn has_same_name(&self, other: &Self) -> bool {
        self.location == other.location && self.row == other.row
    }
}

impl NamedParameter {
    fn from_words(words: &Words, all: &[Words]) -> Self {
        let Words { parameter, location, block, row } = words;
        let short = format!("{location}{}{row}", separator(parameter.location));
        let long = format!("{location}.{block}/{row}");
        // If two blocks at one location have the same words, the first gets the short name, and the block name
        // distinguishes the others.
        let is_first =
            all.iter().find(|other| words.has_same_name(other)).is_some_and(|it| it.parameter.is_at(parameter));
        let mut keys = vec![key(&long), key(location) + &key(block) + &key(parameter.row.name)];
        for row in row_keys(parameter.row, parameter.block) {
            keys.push(key(block) + &row);
            if is_first {
                keys.push(key(location) + &row);
            }
        }
        keys.sort();
        keys.dedup();
        Self { parameter: *parameter, name: if is_first { short } else { long }, keys }
    }
}

/// `trip-point.1` of "Trip Point 1".
fn location_slug(location: &Location) -> String {
    let words = slug(location.name);
    match words.rsplit_once('-') {
        Some((word, number)) if number.bytes().all(|octet| octet.is_ascii_digit()) => format!("{word}.{number}"),
        _ => words,
    }
}

/// The character between location and parameter: a second dot would suggest a third level.
fn separator(location: &Location) -> char {
    if location_slug(location).contains('.') { '/' } else { '.' }
}

/// The words of a row. The part in brackets is included only where an earlier row of the block has the same words before
/// it.
fn row_slug(row: &Row, block: &Block) -> String {
    let short = slug(before_brackets(row.name));
    let same = block.rows.iter().take_while(|other| other.index != row.index);
    if same.map(|other| slug(before_brackets(other.name))).any(|other| other == short) { slug(row.name) } else { short }
}

fn before_brackets(name: &str) -> &str {
    name.split_once(" (").map_or(name, |(name, _)| name)
}

/// The names of a row with and without the part in brackets.
fn row_keys(row: &Row, block: &Block) -> Vec<String> {
    let mut keys = vec![key(row.name), key(&row_slug(row, block))];
    keys.dedup();
    keys
}

/// The ASCII letters and digits of a text in lower case.
pub(super) fn key(text: &str) -> String {
    text.chars().filter(char::is_ascii_alphanumeric).map(|letter| letter.to_ascii_lowercase()).collect()
}

/// The words of a text in lower case with hyphens: `process-value` of "ProcessValue".
///
/// ```
/// assert_eq!(profivac_client::names::slug("Device Exception Detail Alarm 0 ... 3"), "device-exception-detail-alarm-0-3");
/// ```
#[must_use]
pub fn slug(text: &str) -> String {
    let mut slug = String::new();
    let mut before = ' ';
    let mut letters = text.chars().peekable();
    while let Some(letter) = letters.next() {
        // A word begins at a capital after a small letter ("ProcessValue"), and at the last capital before a small letter
        // ("AIBlock").
        let small_follows = letters.peek().is_some_and(char::is_ascii_lowercase);
        let begins = letter.is_ascii_uppercase()
            && (before.is_ascii_lowercase() || (before.is_ascii_uppercase() && small_follows));
        if (begins || !letter.is_ascii_alphanumeric()) && !slug.is_empty() && !slug.ends_with('-') {
            slug.push('-');
        }
        if letter.is_ascii_alphanumeric() {
            slug.push(letter.to_ascii_lowercase());
        }
        before = letter;
    }
    slug.trim_end_matches('-').to_owned()
}
