//! The JSON schema of device files, for editors.

/// The schema: keys, types, words and limits of a device file. The loader checks more than a schema can say.
pub const SCHEMA: &str = include_str!("../schema.json");

#[cfg(test)]
mod tests {
    use super::SCHEMA;
    use crate::words::{ACCESS_ERRORS, BEHAVIOURS, CLIPPINGS, PLAIN_FIELDS, PRINCIPLES, ROLES, STORAGES};
    use crate::{DeviceFile, show};
    use profivac_devices::catalog::MODELS;
    use serde_json::Value;
    use std::collections::BTreeSet;

    fn schema() -> Value {
        serde_json::from_str(SCHEMA).unwrap()
    }

    /// The keys that the loader knows where `zzz` is.
    fn keys(text: &str) -> BTreeSet<String> {
        let error = DeviceFile::parse(&format!("format = 1\n{text}\n")).unwrap_err().text;
        let known = error.split_once("unknown field `zzz`, expected ").unwrap_or_else(|| panic!("{text}: {error}")).1;
        let known = known.split_once("; did you mean").map_or(known, |(known, _)| known);
        known.split('`').skip(1).step_by(2).map(str::to_owned).collect()
    }

    /// Every table of a file has the same keys in the schema and in the loader.
    #[test]
    fn the_schema_has_the_keys_of_the_loader() {
        let code = "/properties/codes/additionalProperties/properties/names/items";
        for (text, place) in [
            ("zzz = 1", ""),
            ("[services]\nzzz = 1", "/properties/services"),
            ("units = [{ zzz = 1 }]", "/properties/units/items"),
            ("user-parameters = [{ zzz = 1 }]", "/properties/user-parameters/items"),
            ("configurations = [{ zzz = 1 }]", "/properties/configurations/items"),
            ("values = [{ zzz = 1 }]", "/properties/values/items"),
            ("parts = [{ zzz = 1 }]", "/properties/parts/items"),
            ("parts = [{ counts = { zzz = 1 } }]", "/properties/parts/items/properties/counts"),
            ("[parameter-channel]\nzzz = 1", "/properties/parameter-channel"),
            ("[parameter-channel]\ntasks = [{ zzz = 1 }]", "/properties/parameter-channel/properties/tasks/items"),
            ("[parameter-channel]\nerrors = [{ zzz = 1 }]", "/properties/parameter-channel/properties/errors/items"),
            ("[alarms]\nzzz = 1", "/properties/alarms"),
            ("[alarms]\nsensor = [{ zzz = 1 }]", "/properties/alarms/properties/sensor/items"),
            ("[alarms]\nmanufacturer = [{ zzz = 1 }]", "/properties/alarms/properties/manufacturer/items"),
            ("faults = [{ zzz = 1 }]", "/properties/faults/items"),
            ("[gsd]\nzzz = 1", "/properties/gsd"),
            ("[[block]]\nzzz = 1", "/properties/block/items"),
            ("[[block]]\nat = [{ zzz = 1 }]", "/properties/block/items/properties/at/items"),
            ("[[block]]\nparameters = [{ zzz = 1 }]", "/properties/block/items/properties/parameters/items"),
            ("[codes.a]\nzzz = 1", "/properties/codes/additionalProperties"),
            ("[codes.a]\nnames = [{ zzz = 1 }]", code),
            ("[codes.a]\nbits = [{ zzz = 1 }]", "/properties/codes/additionalProperties/properties/bits/items"),
        ] {
            let schema = schema();
            let table = schema.pointer(place).unwrap_or_else(|| panic!("{place}"));
            let described: BTreeSet<String> = table["properties"].as_object().unwrap().keys().cloned().collect();
            assert_eq!(described, keys(text), "{place}");
            assert_eq!(table["additionalProperties"], false, "{place}");
        }
    }

    #[test]
    fn the_schema_has_the_words_of_the_loader() {
        fn words<T>(words: &[(&'static str, T)]) -> Vec<&'static str> {
            words.iter().map(|(word, _)| *word).collect()
        }
        let row = "/properties/block/items/properties/parameters/items/properties";
        let part = "/properties/parts/items/properties";
        for (place, words) in [
            (format!("{row}/role/enum"), words(&ROLES)),
            (format!("{row}/store/enum"), words(&STORAGES)),
            (format!("{part}/principle/enum"), words(&PRINCIPLES)),
            ("/properties/block/items/properties/behaviour/enum".to_owned(), words(&BEHAVIOURS)),
            (format!("{part}/clips/enum"), words(&CLIPPINGS)),
            (
                "/properties/parameter-channel/properties/errors/items/properties/error/enum".to_owned(),
                words(&ACCESS_ERRORS),
            ),
        ] {
            let schema = schema();
            let described = schema.pointer(&place).unwrap_or_else(|| panic!("{place}")).as_array().unwrap().clone();
            assert_eq!(described, words, "{place}");
        }
        let schema = schema();
        let fields = schema["definitions"]["field"]["pattern"].as_str().unwrap();
        assert!(PLAIN_FIELDS.iter().all(|(word, _)| fields.contains(word)), "{fields}");
    }

    /// What of `value` the schema does not allow, apart from patterns.
    fn problem(value: &Value, schema: &Value, root: &Value) -> Option<String> {
        if let Some(name) = schema["$ref"].as_str() {
            return problem(value, root.pointer(name.strip_prefix('#').unwrap()).unwrap(), root);
        }
        let wrong = |what: &str| Some(format!("{value} {what} {schema}"));
        let is_type = match schema["type"].as_str() {
            Some("object") => value.is_object(),
            Some("array") => value.is_array(),
            Some("string") => value.is_string(),
            Some("integer") => value.is_i64() || value.is_u64(),
            Some("number") => value.is_number(),
            Some("boolean") => value.is_boolean(),
            Some(other) => panic!("{other}"),
            None => true,
        };
        if !is_type {
            return wrong("is not of the type of");
        }
        if schema.get("const").is_some_and(|only| only != value)
            || schema["enum"].as_array().is_some_and(|all| !all.contains(value))
        {
            return wrong("is no word of");
        }
        let number = value.as_f64().unwrap_or_default();
        if schema["minimum"].as_f64().is_some_and(|lowest| number < lowest)
            || schema["maximum"].as_f64().is_some_and(|highest| number > highest)
        {
            return wrong("is beyond the limits of");
        }
        if let Some(list) = value.as_array() {
            let count = list.len() as u64;
            if schema["minItems"].as_u64().is_some_and(|least| count < least)
                || schema["maxItems"].as_u64().is_some_and(|most| count > most)
            {
                return wrong("has not as many entries as");
            }
            return list.iter().find_map(|entry| problem(entry, &schema["items"], root));
        }
        let table = value.as_object()?;
        let required = schema["required"].as_array().into_iter().flatten();
        if let Some(lacking) = required.filter_map(Value::as_str).find(|key| !table.contains_key(*key)) {
            return Some(format!("{value} lacks {lacking}"));
        }
        table.iter().find_map(|(key, entry)| match (schema["properties"].get(key), &schema["additionalProperties"]) {
            (Some(known), _) => problem(entry, known, root),
            (None, Value::Object(_)) => problem(entry, &schema["additionalProperties"], root),
            (None, _) => Some(format!("{key} is not in {schema}")),
        })
    }

    #[test]
    fn the_files_of_all_devices_fit_the_schema() {
        let schema = schema();
        let mut texts: Vec<String> = MODELS.iter().map(|model| show(model)).collect();
        texts.push(include_str!("../tests/own_gauge.toml").to_owned());
        for text in texts {
            let value: Value = toml::from_str(&text).unwrap();
            assert_eq!(problem(&value, &schema, &schema), None);
        }
        // And the validator finds something.
        let wrong: Value = toml::from_str("format = 2\nname = \"a\"\ntitle = \"A\"").unwrap();
        assert!(problem(&wrong, &schema, &schema).is_some());
    }
}
