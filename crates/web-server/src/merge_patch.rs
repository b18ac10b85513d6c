//! JSON merge patches (RFC 7396): the difference between two states of the station.

use serde_json::{Map, Value};

/// The patch that makes `new` of `old`; `None` if they are equal. A property that becomes `null` is removed, as the RFC has it.
pub fn merge_patch(old: &Value, new: &Value) -> Option<Value> {
    match (old, new) {
        (Value::Object(old), Value::Object(new)) => object_patch(old, new).map(Value::Object),
        _ => (old != new).then(|| new.clone()),
    }
}

fn object_patch(old: &Map<String, Value>, new: &Map<String, Value>) -> Option<Map<String, Value>> {
    let changed = new.iter().filter_map(|(key, value)| {
        let patch = match old.get(key) {
            Some(before) => merge_patch(before, value),
            None => Some(value.clone()),
        };
        Some((key.clone(), patch?))
    });
    let removed = old.keys().filter(|key| !new.contains_key(*key)).map(|key| (key.clone(), Value::Null));
    let patch: Map<String, Value> = changed.chain(removed).collect();
    (!patch.is_empty()).then_some(patch)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// MergePatch of RFC 7396 2, which a client applies.
    fn apply(target: &mut Value, patch: &Value) {
        let Value::Object(patch) = patch else {
            *target = patch.clone();
            return;
        };
        if !target.is_object() {
            *target = json!({});
        }
        let Value::Object(target) = target else { unreachable!("it is an object") };
        for (key, value) in patch {
            if value.is_null() {
                target.remove(key);
            } else {
                apply(target.entry(key).or_insert(Value::Null), value);
            }
        }
    }

    #[test]
    fn a_patch_has_only_what_has_changed() {
        let old = json!({"now": 1, "gauges": {"a": {"pa": 1.0, "state": "ok"}, "b": {"pa": 2.0}}, "order": ["a", "b"]});
        let new = json!({"now": 2, "gauges": {"a": {"pa": 1.5, "state": "ok"}, "c": {"pa": 3.0}}, "order": ["a", "c"]});
        let patch = merge_patch(&old, &new).unwrap();
        let expected =
            json!({"now": 2, "gauges": {"a": {"pa": 1.5}, "b": null, "c": {"pa": 3.0}}, "order": ["a", "c"]});
        assert_eq!(patch, expected);
        let mut patched = old;
        apply(&mut patched, &patch);
        assert_eq!(patched, new);
        assert_eq!(merge_patch(&new, &new), None);
    }

    #[test]
    fn a_property_that_becomes_null_is_removed() {
        let (old, new) = (json!({"pa": 1.0, "x": {"y": 1}}), json!({"pa": null, "x": 2}));
        assert_eq!(merge_patch(&old, &new), Some(json!({"pa": null, "x": 2})));
        assert_eq!(merge_patch(&new, &old), Some(json!({"pa": 1.0, "x": {"y": 1}})));
    }
}
