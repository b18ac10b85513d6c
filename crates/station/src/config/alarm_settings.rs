//! The settings of one `[[alarm]]` that an engineer changes in the dashboard, and their change in the text of the file.
//!
//! Only the values of this alarm change: comments, order and every other value of the file stay.

use serde::{Deserialize, Serialize};
use std::fmt;
use toml_edit::{DocumentMut, Item, TableLike, Value};
use utoipa::ToSchema;

/// The settings of an `[[alarm]]` as the file writes them; `null` is a key that the file does not have, so that its default applies.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct AlarmSettings {
    /// The alarm is raised above this pressure.
    #[schema(example = "1e-3 mbar")]
    above: Option<String>,
    /// The alarm is raised below this pressure.
    below: Option<String>,
    /// The alarm is raised by a rise of this many decades per minute.
    rise: Option<f64>,
    /// The alarm is raised above this percentage of repetitions.
    repetitions: Option<f64>,
    /// The alarm is raised above this percentage of lost message cycles.
    lost: Option<f64>,
    /// The alarm is raised above this percentage of damaged telegrams.
    damaged: Option<f64>,
    /// The pressure at which the condition ends.
    reset: Option<String>,
    /// The hysteresis in decades, or in decades per minute.
    hysteresis: Option<f64>,
    /// The time over which a rise is fitted.
    window: Option<String>,
    /// The condition must be met for this time.
    #[schema(example = "1 s")]
    delay: Option<String>,
    /// The condition must not be met for this time.
    #[schema(example = "5 s")]
    off_delay: Option<String>,
    /// The priority: high, medium, low.
    #[schema(example = "high")]
    priority: Option<String>,
}

/// The reason why the text of the file is not changed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// The text has no such `[[alarm]]`.
    #[error("the station's file has no [[alarm]] with the name {0:?}: a default alarm has its settings in [alarms]")]
    NotInFile(String),
    /// The request has another kind of limit than the file.
    #[error(
        "expected a value for {expected} alone, as the station's file has it, got {got}; edit the file to change what an alarm watches"
    )]
    OtherLimit {
        /// The limit in the file.
        expected: String,
        /// The limits in the request.
        got: String,
    },
    /// There is no such default alarm.
    #[error("there is no default alarm {name:?}; expected one of: {known}")]
    UnknownDefault {
        /// The name.
        name: String,
        /// Those of `[alarms]`.
        known: String,
    },
    /// The text is not TOML.
    #[error("the station's file cannot be edited: {0}")]
    Syntax(String),
}

/// The number of keys that say what an alarm watches; they come first.
const LIMIT_KEYS: usize = 6;

impl AlarmSettings {
    /// Reads the settings of the alarm `name`.
    ///
    /// # Errors
    /// [`SettingsError`] if the text has no such alarm.
    pub fn read(text: &str, name: &str) -> Result<Self, SettingsError> {
        let mut document = parsed(text)?;
        let table = alarm(&mut document, name)?;
        let word = |key: &str| table.get(key).and_then(Item::as_str).map(str::to_owned);
        let number = |key: &str| {
            let item = table.get(key)?;
            item.as_float().or_else(|| item.as_integer().map(|whole| whole as f64))
        };
        Ok(Self {
            above: word("above"),
            below: word("below"),
            rise: number("rise"),
            repetitions: number("repetitions"),
            lost: number("lost"),
            damaged: number("damaged"),
            reset: word("reset"),
            hysteresis: number("hysteresis"),
            window: word("window"),
            delay: word("delay"),
            off_delay: word("off-delay"),
            priority: word("priority"),
        })
    }

    /// The text of the file in which the alarm `name` has these settings. A value that stays is not written again.
    ///
    /// # Errors
    /// [`SettingsError`] if the text has no such alarm, or if the settings have another kind of limit.
    pub fn write(&self, text: &str, name: &str) -> Result<String, SettingsError> {
        let present = Self::read(text, name)?;
        if present.limits() != self.limits() {
            return Err(SettingsError::OtherLimit { expected: present.limits(), got: self.limits() });
        }
        let mut document = parsed(text)?;
        let table = alarm(&mut document, name)?;
        for ((key, old), (_, new)) in present.entries().into_iter().zip(self.entries()) {
            match new {
                Some(new) if old.as_ref().map(ToString::to_string) != Some(new.to_string()) => set(table, key, new),
                Some(_) => {}
                None => drop(table.remove(key)),
            }
        }
        let edited = document.to_string();
        // The editor writes the line ends of Unix.
        Ok(if text.contains("\r\n") { edited.replace("\r\n", "\n").replace('\n', "\r\n") } else { edited })
    }

    /// The keys of the file with their values, those that say what the alarm watches first.
    fn entries(&self) -> [(&'static str, Option<Value>); 12] {
        let word = |text: &Option<String>| text.as_deref().map(Value::from);
        let number = |value: Option<f64>| value.map(Value::from);
        [
            ("above", word(&self.above)),
            ("below", word(&self.below)),
            ("rise", number(self.rise)),
            ("repetitions", number(self.repetitions)),
            ("lost", number(self.lost)),
            ("damaged", number(self.damaged)),
            ("reset", word(&self.reset)),
            ("hysteresis", number(self.hysteresis)),
            ("window", word(&self.window)),
            ("delay", word(&self.delay)),
            ("off-delay", word(&self.off_delay)),
            ("priority", word(&self.priority)),
        ]
    }

    /// The keys of the limits that have a value.
    fn limits(&self) -> String {
        let given = self.entries().into_iter().take(LIMIT_KEYS).filter(|(_, value)| value.is_some());
        let keys: Vec<_> = given.map(|(key, _)| key).collect();
        if keys.is_empty() { "no limit".to_owned() } else { keys.join(" and ") }
    }
}

impl fmt::Display for AlarmSettings {
    /// The keys and values as the file writes them, in one line.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let given = self.entries().into_iter().filter_map(|(key, value)| Some((key, value?)));
        let all: Vec<_> = given.map(|(key, value)| format!("{key} = {}", value.to_string().trim())).collect();
        formatter.write_str(&all.join(", "))
    }
}

/// The text as a document that keeps its form.
pub(super) fn parsed(text: &str) -> Result<DocumentMut, SettingsError> {
    text.parse().map_err(|error: toml_edit::TomlError| SettingsError::Syntax(error.message().to_owned()))
}

/// The table of the alarm `name`, written as `[[alarm]]` or in a list.
fn alarm<'a>(document: &'a mut DocumentMut, name: &str) -> Result<&'a mut dyn TableLike, SettingsError> {
    let has_name = |table: &dyn TableLike| table.get("name").and_then(Item::as_str) == Some(name);
    let found: Option<&mut dyn TableLike> = match document.get_mut("alarm") {
        Some(Item::ArrayOfTables(tables)) => {
            tables.iter_mut().find(|table| has_name(*table)).map(|table| table as &mut dyn TableLike)
        }
        Some(Item::Value(Value::Array(tables))) => tables
            .iter_mut()
            .filter_map(Value::as_inline_table_mut)
            .find(|table| has_name(*table))
            .map(|table| table as &mut dyn TableLike),
        _ => None,
    };
    found.ok_or_else(|| SettingsError::NotInFile(name.to_owned()))
}

/// Sets a value. The comment behind the value that it replaces stays.
pub(super) fn set(table: &mut dyn TableLike, key: &str, mut new: Value) {
    let old = table.get(key).and_then(Item::as_value).map(|value| value.decor().clone());
    if let Some(decor) = old {
        *new.decor_mut() = decor;
    }
    table.insert(key, Item::Value(new));
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"# The hall.
[station]
name = "hall"   # not the annex

[[alarm]]
name = "other"
gauge = "lock"
above = "1e-3 mbar"

# The process needs it.
[[alarm]]
priority = "high"
name = "too high" # of the chamber
above = '1e-3 mbar'     # from the process
gauge = "chamber"
hysteresis = 1

[alarms]
# at the end
fault = { priority = "high" }
"#;

    fn settings(text: &str) -> AlarmSettings {
        AlarmSettings::read(text, "too high").unwrap()
    }

    #[test]
    fn only_the_changed_values_of_the_alarm_are_written() {
        let mut new = settings(TEXT);
        assert_eq!(new.to_string(), r#"above = "1e-3 mbar", hysteresis = 1.0, priority = "high""#);
        assert_eq!(new.write(TEXT, "too high").unwrap(), TEXT, "what stays is not written again");
        new.above = Some("2e-3 mbar".to_owned());
        new.delay = Some("3 s".to_owned());
        new.priority = None;
        let expected = TEXT
            .replace("'1e-3 mbar'", "\"2e-3 mbar\"")
            .replace("priority = \"high\"\nname", "name")
            .replace("hysteresis = 1\n", "hysteresis = 1\ndelay = \"3 s\"\n");
        let edited = new.write(TEXT, "too high").unwrap();
        assert_eq!(edited, expected);
        assert_eq!(settings(&edited), new);
        let crlf = TEXT.replace('\n', "\r\n");
        assert_eq!(new.write(&crlf, "too high").unwrap(), expected.replace('\n', "\r\n"));
    }

    #[test]
    fn an_alarm_in_a_list_is_edited() {
        let text = "alarm = [{ name = \"too high\", gauge = \"a\", above = \"1 Pa\" }] # all\n";
        let new = AlarmSettings { above: Some("2 Pa".to_owned()), ..settings(text) };
        assert_eq!(new.write(text, "too high").unwrap(), text.replace("1 Pa", "2 Pa"));
    }

    #[test]
    fn an_alarm_keeps_what_it_watches() {
        let new = AlarmSettings { above: None, below: Some("1 mbar".to_owned()), ..settings(TEXT) };
        let error = new.write(TEXT, "too high").unwrap_err();
        assert_eq!(error, SettingsError::OtherLimit { expected: "above".to_owned(), got: "below".to_owned() });
        let none = AlarmSettings { above: None, ..settings(TEXT) };
        assert!(matches!(none.write(TEXT, "too high"), Err(SettingsError::OtherLimit { .. })));
        let unknown = AlarmSettings::read(TEXT, "chamber: fault").unwrap_err();
        assert_eq!(unknown, SettingsError::NotInFile("chamber: fault".to_owned()));
    }

    #[test]
    fn a_value_cannot_add_keys_or_tables() {
        let evil = "1 mbar\"\nmessage = \"x\"\n[[alarm]]\nname = \"y";
        let new = AlarmSettings { above: Some(evil.to_owned()), ..settings(TEXT) };
        let edited = new.write(TEXT, "too high").unwrap();
        assert_eq!(settings(&edited).above.as_deref(), Some(evil), "the text is one string");
        assert!(AlarmSettings::read(&edited, "y").is_err());
    }
}
