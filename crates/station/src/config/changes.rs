//! What differs between two texts of a station's file, key by key.
//!
//! A table of a list has the name of its key `name`: `[[segment.gauge]]` with `name = "chamber"` is `segment.gauge "chamber"`, so that
//! a new entry before it changes nothing of it.

use std::collections::BTreeMap;
use toml_edit::{DocumentMut, Item, TableLike, Value};

/// The most changes that are named one by one.
pub const MAX_CHANGES: usize = 500;

/// The most characters of a value.
const MAX_VALUE: usize = 200;

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
    let (before, after) = (keys(before), keys(after));
    let all: std::collections::BTreeSet<_> = before.keys().chain(after.keys()).collect();
    let changed = all.into_iter().filter(|key| before.get(*key) != after.get(*key));
    changed
        .map(|key| {
            let shown = |value: &String| if is_secret(key, value) { "(not shown)".to_owned() } else { short(value) };
            FileChange { key: key.clone(), before: before.get(key).map(shown), after: after.get(key).map(shown) }
        })
        .collect()
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
        let long = format!("a = \"{}\"", "ä".repeat(MAX_VALUE));
        let value = changes("", &long).remove(0).after.unwrap();
        assert_eq!(value.chars().count(), MAX_VALUE + 4);
    }
}
