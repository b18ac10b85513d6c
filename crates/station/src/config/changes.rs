//! What differs between two texts of a station's file, key by key.
//!
//! A table of a list has the name of its key `name`: `[[segment.gauge]]` with `name = "chamber"` is `segment.gauge "chamber"`, so that
//! a new entry before it changes nothing of it.

use profivac_web_server::auth::password::{Hash, LONGEST};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use toml_edit::{DocumentMut, Item, TableLike, Value};

/// The most changes that are named one by one.
pub const MAX_CHANGES: usize = 500;

/// The most characters of a value.
const MAX_VALUE: usize = 200;

/// What is shown in place of a secret.
const NOT_SHOWN: &str = "(not shown)";

/// Words in keys whose values are secrets or may contain them.
const SECRET: [&str; 6] = ["secret", "password", "token", "url", "credential", "headers"];

/// A key whose value differs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileChange {
    /// The tables with their names, then the key: `segment "a" gauge "chamber" poll`.
    pub key: String,
    /// The value before; `None` if the key is new.
    pub before: Option<String>,
    /// The value now; `None` if the key is gone.
    pub after: Option<String>,
}

/// The keys whose values differ, in the order of their names. A text that is not TOML has no keys.
#[must_use]
pub fn changes(before: &str, after: &str) -> Vec<FileChange> {
    let before = keys(before);
    let shown = |key: &str| before.get(key).map(|value| shown(key, value));
    compare(before.keys(), &keys(after), |key, value| before.get(key).map(String::as_str) == value, shown)
}

/// The changed keys. `before` are the keys before; `is_same` says whether the value of a key is this one, `before_shown` the one before.
fn compare<'a>(
    before: impl Iterator<Item = &'a String>,
    after: &'a BTreeMap<String, String>,
    is_same: impl Fn(&str, Option<&str>) -> bool,
    before_shown: impl Fn(&str) -> Option<String>,
) -> Vec<FileChange> {
    let all: BTreeSet<_> = before.chain(after.keys()).collect();
    let changed = all.into_iter().filter(|key| !is_same(key, after.get(*key).map(String::as_str)));
    let change = |key: &String| {
        let (before, after) = (before_shown(key), after.get(key).map(|value| shown(key, value)));
        FileChange { key: key.clone(), before, after }
    };
    changed.map(change).collect()
}

/// The keys of a file with their values, as the database keeps them over a stop of the station.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct KnownKeys(BTreeMap<String, KnownValue>);

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum KnownValue {
    Value(String),
    /// The password hash of a secret, so that the database and its copies give nobody the secret. Empty without one: the value is too long.
    Secret(String),
}

impl KnownKeys {
    /// The keys of a text. Each secret takes some ten milliseconds of a processor.
    #[must_use]
    pub fn of(text: &str) -> Self {
        let known = |key: &str, value: String| {
            if is_secret(key, &value) { KnownValue::secret(&value) } else { KnownValue::Value(value) }
        };
        Self(keys(text).into_iter().map(|(key, value)| (key.clone(), known(&key, value))).collect())
    }

    /// What differs in `text`.
    #[must_use]
    pub fn changes_to(&self, text: &str) -> Vec<FileChange> {
        let Self(before) = self;
        let is_same = |key: &str, value: Option<&str>| match (before.get(key), value) {
            (Some(known), Some(value)) => known.is(value),
            (known, value) => known.is_none() && value.is_none(),
        };
        compare(before.keys(), &keys(text), is_same, |key| before.get(key).map(|known| known.shown(key)))
    }
}

impl KnownValue {
    fn secret(value: &str) -> Self {
        let hash = (value.len() <= LONGEST).then(|| Hash::of(value).ok()).flatten();
        Self::Secret(hash.map(|hash| hash.as_str().to_owned()).unwrap_or_default())
    }

    fn is(&self, value: &str) -> bool {
        match self {
            Self::Value(known) => known == value,
            // Without a hash nothing tells whether the secret is another one.
            Self::Secret(hash) => Hash::parse(hash).map_or(true, |hash| hash.matches(value)),
        }
    }

    fn shown(&self, key: &str) -> String {
        match self {
            Self::Value(value) => shown(key, value),
            Self::Secret(_) => NOT_SHOWN.to_owned(),
        }
    }
}

/// A value as events and the audit trail show it.
fn shown(key: &str, value: &str) -> String {
    if is_secret(key, value) { NOT_SHOWN.to_owned() } else { short(value) }
}

/// Whether the value must not be shown: for its key, or for a key of a table in a list within a list, which stays one value.
fn is_secret(key: &str, value: &str) -> bool {
    let last = key.rsplit(' ').next().unwrap_or_default();
    let is_list_of_tables = value.starts_with('[') && value.contains('{');
    let has_word = |text: &str| SECRET.iter().any(|word| text.contains(word));
    has_word(last) || (is_list_of_tables && has_word(value))
}

fn short(value: &str) -> String {
    match value.char_indices().nth(MAX_VALUE) {
        Some((end, _)) => format!("{} ...", value.get(..end).unwrap_or_default()),
        None => value.to_owned(),
    }
}

fn keys(text: &str) -> BTreeMap<String, String> {
    let mut keys = BTreeMap::new();
    if let Ok(document) = text.parse::<DocumentMut>() {
        add_table(document.as_table(), "", &mut keys);
    }
    keys
}

fn add_table(table: &dyn TableLike, path: &str, keys: &mut BTreeMap<String, String>) {
    for (key, item) in table.iter() {
        let path = if path.is_empty() { key.to_owned() } else { format!("{path} {key}") };
        match item {
            Item::None => {}
            Item::Table(table) => add_table(table, &path, keys),
            Item::Value(value) => add_value(value, path, keys),
            Item::ArrayOfTables(tables) => {
                tables.iter().enumerate().for_each(|(index, table)| add_entry(table, index, &path, keys));
            }
        }
    }
}

fn add_value(value: &Value, path: String, keys: &mut BTreeMap<String, String>) {
    match value {
        Value::InlineTable(table) => add_table(table, &path, keys),
        Value::Array(array) if array.iter().all(Value::is_inline_table) && !array.is_empty() => {
            let tables = array.iter().filter_map(Value::as_inline_table).enumerate();
            tables.for_each(|(index, table)| add_entry(table, index, &path, keys));
        }
        value => {
            // Blanks and comments around a value are no part of it.
            let mut value = value.clone();
            value.decor_mut().clear();
            keys.insert(path, value.to_string());
        }
    }
}

/// Adds the keys of a table of a list: below its name, or below its number if it has none.
fn add_entry(table: &dyn TableLike, index: usize, path: &str, keys: &mut BTreeMap<String, String>) {
    let name = table.get("name").and_then(Item::as_str);
    let name = name.map_or_else(|| index.saturating_add(1).to_string(), |name| format!("{name:?}"));
    add_table(table, &format!("{path} {name}"), keys);
}

#[cfg(test)]
mod tests {
    use super::*;

    const BEFORE: &str = "[[segment]]\nname = \"a\"\n[[segment.gauge]]\nname = \"chamber\"\naddress = 5\npoll = \"1 s\"\n\
                          [[alarm]]\nname = \"too high\"\nabove = \"1e-3 mbar\" # the valve\n[openid]\nclient-secret = \"s1\"\n";

    fn change(key: &str, before: Option<&str>, after: Option<&str>) -> FileChange {
        FileChange { key: key.to_owned(), before: before.map(str::to_owned), after: after.map(str::to_owned) }
    }

    #[test]
    fn a_changed_a_new_and_a_deleted_key_are_named_with_their_tables() {
        let after = BEFORE.replace("1e-3 mbar", "2e-3 mbar").replace("poll = \"1 s\"\n", "gas = \"He\"\n");
        let expected = [
            change("alarm \"too high\" above", Some("\"1e-3 mbar\""), Some("\"2e-3 mbar\"")),
            change("segment \"a\" gauge \"chamber\" gas", None, Some("\"He\"")),
            change("segment \"a\" gauge \"chamber\" poll", Some("\"1 s\""), None),
        ];
        assert_eq!(changes(BEFORE, &after.replace("# the valve", "# another comment")), expected);
        assert!(changes(BEFORE, BEFORE).is_empty());
    }

    #[test]
    fn keys_that_were_stored_show_the_same_changes() {
        let known = serde_json::from_str::<KnownKeys>(&serde_json::to_string(&KnownKeys::of(BEFORE)).unwrap()).unwrap();
        let after = BEFORE.replace("1e-3 mbar", "2e-3 mbar").replace("poll = \"1 s\"\n", "gas = \"He\"\n");
        assert_eq!(known.changes_to(&after), changes(BEFORE, &after));
        assert_eq!(known.changes_to(&after).len(), 3);
        assert_eq!(known.changes_to(&format!("# a comment\n{BEFORE}")), []);
    }

    #[test]
    fn a_secret_that_is_too_long_for_a_hash_is_not_compared() {
        let with = |secret: &str| format!("token = \"{secret}\"\n");
        let known = KnownKeys::of(&with(&"s".repeat(LONGEST)));
        assert_eq!(known.changes_to(&with("other")), []);
        assert_eq!(known.changes_to(""), [change("token", Some("(not shown)"), None)]);
    }

    #[test]
    fn a_new_alarm_before_another_one_changes_only_itself() {
        let after = BEFORE.replace("[[alarm]]\n", "[[alarm]]\nname = \"new\"\nbelow = \"1 Pa\"\n[[alarm]]\n");
        let keys: Vec<_> = changes(BEFORE, &after).into_iter().map(|change| change.key).collect();
        assert_eq!(keys, ["alarm \"new\" below", "alarm \"new\" name"]);
    }

    #[test]
    fn a_secret_is_not_shown_and_a_long_value_is_cut() {
        let after = BEFORE.replace("s1", "s2");
        assert_eq!(changes(BEFORE, &after), [change("openid client-secret", Some("(not shown)"), Some("(not shown)"))]);
        let inline = "webhook = [{ name = \"a\", url = \"https://b/1\", token = \"s1\" }]\nlevels = [1, [{ password = \"s1\" }]]\n";
        let hidden = ["levels", "webhook \"a\" token"].map(|key| change(key, Some("(not shown)"), Some("(not shown)")));
        assert_eq!(changes(inline, &inline.replace("s1", "s2")), hidden);
        let known = KnownKeys::of(inline);
        let stored = serde_json::to_string(&known).unwrap();
        assert!(!stored.contains("s1") && !stored.contains("https"), "{stored}");
        assert_eq!(known.changes_to(inline), []);
        assert_eq!(known.changes_to(&inline.replace("s1", "s2")), hidden);
        let long = format!("a = \"{}\"", "ä".repeat(MAX_VALUE));
        let value = changes("", &long).remove(0).after.unwrap();
        assert_eq!(value.chars().count(), MAX_VALUE + 4);
    }
}
