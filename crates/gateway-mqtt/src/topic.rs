//! Names of the station as levels of a topic.

/// The levels below the prefix that are no gauges.
const RESERVED: [&str; 2] = ["segment", "alarm"];

/// A name as one level of a topic, or as an element of a topic of Sparkplug. `/`, `+`, `#`, `%` and control characters are written as `%`
/// and two digits for each octet, so that different names are different levels.
#[must_use]
pub fn level(name: &str) -> String {
    encoded(name, |character| matches!(character, '/' | '+' | '#' | '%') || character.is_control())
}

/// A path like that of a parameter, `trip-point.1/high-trip-point`, as several levels.
#[must_use]
pub fn levels(path: &str) -> String {
    path.split('/').map(level).collect::<Vec<_>>().join("/")
}

/// The level of a gauge below the prefix: that of its name. A gauge with the name of another level gets its first character encoded.
#[must_use]
pub fn gauge_level(name: &str) -> String {
    let level = level(name);
    match level.split_at_checked(1) {
        Some((first, rest)) if RESERVED.contains(&level.as_str()) => {
            format!("%{:02X}{rest}", first.bytes().next().unwrap_or_default())
        }
        _ => level,
    }
}

/// A name as an identifier of letters, digits, `-` and `_`, which Home Assistant asks for. A blank becomes two `_`, other characters `_`
/// and two digits for each octet, so that different names are different identifiers.
#[must_use]
pub fn identifier(name: &str) -> String {
    let mut identifier = String::new();
    for octet in name.bytes() {
        match octet {
            b' ' => identifier.push_str("__"),
            b'-' => identifier.push('-'),
            _ if octet.is_ascii_alphanumeric() => identifier.push(octet.into()),
            _ => identifier.push_str(&format!("_{octet:02X}")),
        }
    }
    identifier
}

/// The name of a station as a part of the default prefix and of a client identifier: lower case, letters and digits, joined by `-`.
#[must_use]
pub fn slug(name: &str) -> String {
    let words = name.split(|character: char| !character.is_alphanumeric()).filter(|word| !word.is_empty());
    let slug = words.collect::<Vec<_>>().join("-").to_lowercase();
    if slug.is_empty() { "station".to_owned() } else { slug }
}

fn encoded(name: &str, is_special: impl Fn(char) -> bool) -> String {
    let mut level = String::new();
    for character in name.chars() {
        if is_special(character) {
            level.extend(character.to_string().bytes().map(|octet| format!("%{octet:02X}")));
        } else {
            level.push(character);
        }
    }
    level
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn different_names_are_different_levels_and_identifiers() {
        let names = [
            "fore line",
            "fore-line",
            "fore_line",
            "fore/line",
            "fore%2Fline",
            "a+b",
            "a#b",
            "ä",
            "segment",
            "%73egment",
        ];
        for (index, name) in names.iter().enumerate() {
            for other in &names[index + 1..] {
                assert_ne!(gauge_level(name), gauge_level(other));
                assert_ne!(identifier(name), identifier(other));
            }
            assert!(!gauge_level(name).contains(['/', '+', '#']));
            assert!(identifier(name).bytes().all(|octet| octet.is_ascii_alphanumeric() || b"_-".contains(&octet)));
        }
        assert_eq!(gauge_level("fore line"), "fore line");
        assert_eq!(gauge_level("segment"), "%73egment");
        assert_eq!(identifier("fore line"), "fore__line");
    }

    #[test]
    fn a_station_without_letters_has_a_slug_too() {
        assert_eq!((slug("Target hall (2)").as_str(), slug("#").as_str()), ("target-hall-2", "station"));
    }
}
