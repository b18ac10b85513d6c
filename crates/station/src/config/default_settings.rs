//! The settings of a default alarm of `[alarms]` that an engineer changes in the dashboard, and their change in the text of the file.
//!
//! Only the values of this default alarm change: comments, order and every other value of the file stay.

use super::alarm_settings::{SettingsError, parsed, set};
use serde::{Deserialize, Serialize};
use std::fmt;
use toml_edit::{Array, DocumentMut, InlineTable, Item, Table, TableLike, Value};
use utoipa::ToSchema;

/// The settings of a default alarm as the file writes them; `null` is a key that the file does not have, so that its default applies.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct DefaultAlarmSettings {
    /// The priority: high, medium, low, or off: then there is no such alarm.
    #[schema(example = "high")]
    pub(super) priority: Option<String>,
    /// The condition must be met for this time.
    #[schema(example = "10 s")]
    pub(super) delay: Option<String>,
    /// The condition must not be met for this time.
    #[schema(example = "5 s")]
    pub(super) off_delay: Option<String>,
    /// For `damage` only: the damaged telegrams in a minute.
    pub(super) limit: Option<f64>,
    /// The gauges or segments without this alarm, up to 1000.
    #[schema(max_items = 1000)]
    pub(super) except: Option<Vec<String>>,
}

/// A default alarm: its key in `[alarms]`, and the former one that the file may have instead.
const KEYS: [(&str, Option<&str>); 7] = [
    ("fault", None),
    ("stale", None),
    ("not-measurable", Some("blind")),
    ("segment", None),
    ("damage", None),
    ("database", Some("record")),
    ("database-damage", None),
];

/// The key of the default alarm in this document: the present one, or the former one if the file has it.
fn key_in(document: &DocumentMut, name: &str) -> Result<&'static str, SettingsError> {
    let known = KEYS.iter().find(|(key, _)| *key == name);
    let (key, former) = known.ok_or_else(|| {
        let known = KEYS.map(|(key, _)| key).join(", ");
        SettingsError::UnknownDefault { name: name.to_owned(), known }
    })?;
    let has = |key: &str| document.get("alarms").and_then(|alarms| alarms.get(key)).is_some();
    Ok(former.filter(|former| has(former)).unwrap_or(key))
}

impl DefaultAlarmSettings {
    /// The names of all default alarms, as the file has them.
    pub const NAMES: [&str; 7] = [KEYS[0].0, KEYS[1].0, KEYS[2].0, KEYS[3].0, KEYS[4].0, KEYS[5].0, KEYS[6].0];

    /// Reads the settings of the default alarm `name`. All are `None` if the file has none for it.
    ///
    /// # Errors
    /// [`SettingsError`] if there is no such default alarm.
    pub fn read(text: &str, name: &str) -> Result<Self, SettingsError> {
        let document = parsed(text)?;
        let key = key_in(&document, name)?;
        let table = document.get("alarms").and_then(|alarms| alarms.get(key)).and_then(Item::as_table_like);
        let Some(table) = table else { return Ok(Self::default()) };
        let word = |key: &str| table.get(key).and_then(Item::as_str).map(str::to_owned);
        let limit = table.get("limit");
        let limit = limit.and_then(|item| item.as_float().or_else(|| item.as_integer().map(|whole| whole as f64)));
        let except = table.get("except").and_then(Item::as_array);
        let names = |list: &Array| list.iter().filter_map(Value::as_str).map(str::to_owned).collect();
        Ok(Self {
            priority: word("priority"),
            delay: word("delay"),
            off_delay: word("off-delay"),
            limit,
            except: except.map(names),
        })
    }

    /// The text of the file in which the default alarm `name` has these settings. A value that stays is not written again.
    ///
    /// # Errors
    /// [`SettingsError`] if there is no such default alarm.
    pub fn write(&self, text: &str, name: &str) -> Result<String, SettingsError> {
        let present = Self::read(text, name)?;
        let mut document = parsed(text)?;
        let key = key_in(&document, name)?;
        let table = table(&mut document, key)?;
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

    /// The keys of the file with their values.
    fn entries(&self) -> [(&'static str, Option<Value>); 5] {
        let word = |text: &Option<String>| text.as_deref().map(Value::from);
        let names = |names: &Vec<String>| Value::Array(names.iter().map(String::as_str).collect());
        [
            ("priority", word(&self.priority)),
            ("delay", word(&self.delay)),
            ("off-delay", word(&self.off_delay)),
            ("limit", self.limit.map(Value::from)),
            ("except", self.except.as_ref().map(names)),
        ]
    }
}

impl fmt::Display for DefaultAlarmSettings {
    /// The keys and values as the file writes them, in one line.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let given = self.entries().into_iter().filter_map(|(key, value)| Some((key, value?)));
        let all: Vec<_> = given.map(|(key, value)| format!("{key} = {}", value.to_string().trim())).collect();
        formatter.write_str(if all.is_empty() { "the defaults" } else { "" })?;
        formatter.write_str(&all.join(", "))
    }
}

/// The table of the default alarm with this key; made if the file has none.
fn table<'a>(document: &'a mut DocumentMut, key: &str) -> Result<&'a mut dyn TableLike, SettingsError> {
    let no_table = || SettingsError::Syntax("alarms is no table".to_owned());
    let alarms = document.entry("alarms").or_insert_with(|| Item::Table(Table::new()));
    let alarms = alarms.as_table_like_mut().ok_or_else(no_table)?;
    if alarms.get(key).is_none() {
        alarms.insert(key, Item::Value(Value::InlineTable(InlineTable::new())));
    }
    alarms.get_mut(key).and_then(Item::as_table_like_mut).ok_or_else(no_table)
}
