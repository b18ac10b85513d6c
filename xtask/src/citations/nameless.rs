//! Citations that do not name their document: their folder or their table determines it.

use super::grammar::{Place, number};

/// Points without the name of a document: `section 9, point 38`, `4.9, rule 2`, `Point 38 of section 9` or `points 6 and 7 of
/// section 9`.
pub fn points(text: &str) -> Vec<usize> {
    let words = ["oint", "ule", "ransition"].into_iter().flat_map(|word| text.match_indices(word));
    let nameless = |(at, word): (usize, &str)| {
        let (before, after) = (text.get(..at)?, text.get(at + word.len()..)?);
        let before = before.strip_suffix(['p', 'P', 'r', 'R', 't', 'T'])?;
        let after = after.strip_prefix('s').unwrap_or(after).strip_prefix(' ')?;
        let after = after.get(number(after)?.len()..)?;
        let section = before.strip_suffix(", ").unwrap_or("");
        let last = section.rsplit([' ', '(']).next()?;
        let dotted = number(last).is_some_and(|number| number == last && number.contains('.'));
        let named = section.trim_end_matches(|char: char| char.is_ascii_digit() || char == '.').ends_with("section ");
        let after = behind_the_list(after);
        let of = after.starts_with(" of section ") || after.starts_with(" in section ");
        (dotted || named || of).then_some(before.len())
    };
    words.filter_map(nameless).collect()
}

/// The text behind the further numbers of a list: `, 7 and 12`.
fn behind_the_list(mut text: &str) -> &str {
    while let Some(rest) = [", ", " and ", " to "].into_iter().find_map(|word| text.strip_prefix(word)) {
        let Some(next) = number(rest).and_then(|number| rest.get(number.len()..)) else { break };
        text = next;
    }
    text
}

/// The section number with which a comment begins: `2.4: the order`, `2.13, the first trace` or `2.8` alone.
pub fn first(text: &str) -> Option<&str> {
    let section = number(text).filter(|number| number.contains('.'))?;
    let rest = text.get(section.len()..)?;
    (rest.is_empty() || rest.starts_with([':', ','])).then_some(section)
}

/// Numbers in brackets, `(14)`, `(61, 63)` or `(84) to (92)`, with their places.
pub fn bracketed(text: &str) -> Vec<(usize, Place)> {
    let mut found = Vec::new();
    let mut done = 0;
    for (at, _) in text.match_indices('(') {
        let glued = text.get(..at).is_some_and(|before| before.ends_with(|char: char| char.is_alphanumeric()));
        let Some((numbers, end)) = bracket(text, at).filter(|_| at >= done && !glued) else { continue };
        done = end;
        let last = text.get(end..).filter(|rest| rest.starts_with(" to ")).and_then(|_| bracket(text, end + 4));
        match (&numbers[..], last.as_ref().map(|(numbers, end)| (&numbers[..], *end))) {
            ([first], Some(([last], end))) => {
                done = end;
                found.push((at, Place::Range(first.clone(), last.clone())));
            }
            _ => found.extend(numbers.into_iter().map(|number| (at, Place::Section(number)))),
        }
    }
    found
}

/// The numbers of a bracket that contains nothing else, with its end.
fn bracket(text: &str, at: usize) -> Option<(Vec<String>, usize)> {
    let inside = text.get(at..)?.strip_prefix('(')?;
    let inside = inside.get(..inside.find(')')?)?;
    let is_one = |part: &&str| (1..=3).contains(&part.len()) && part.chars().all(|char| char.is_ascii_digit());
    let numbers: Option<Vec<_>> = inside.split(", ").map(|part| Some(part).filter(is_one).map(str::to_owned)).collect();
    Some((numbers?, at + inside.len() + 2))
}

/// Numbers of three parts or more, which in the folder of a device are sections of its manual.
pub fn bare(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(rest) = text.get(at..).filter(|rest| !rest.is_empty()) {
        let begins = !text
            .get(..at)
            .is_some_and(|before| before.ends_with(|char: char| char.is_alphanumeric() || ".-".contains(char)));
        let numbers = number(rest).filter(|_| begins);
        if let Some(section) = numbers.filter(|number| number.split('.').count() > 2) {
            found.push((at, section.to_owned()));
        }
        at += numbers.map_or_else(|| rest.chars().next().map_or(1, char::len_utf8), str::len);
    }
    found
}

/// The section in a row of the table of a block: `N "11.2.2";`, after the store class.
pub fn row(code: &str) -> Option<(usize, String)> {
    let (at, _) = code.match_indices(" \"").find(|(at, _)| {
        let before = code.get(..*at).unwrap_or("").trim_end();
        ["N", "V", "D", "-"]
            .iter()
            .any(|store| before.strip_suffix(store).is_some_and(|before| before.ends_with([' ', ']'])))
    })?;
    let quoted = code.get(at + 2..)?;
    let section = quoted.get(..quoted.find('"')?)?;
    Some((at, section.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_of_a_table_has_its_section_behind_the_store_class() {
        let section = |code| row(code).map(|(_, section)| section);
        assert_eq!(section("17 High \"High\" BY_TYPE [1_R/W 2_R/W]   N  \"11.2.2\";").as_deref(), Some("11.2.2"));
        assert_eq!(section("20 Key \"Key N\" UINT8 [1_R]  -  \"3.1\" LOCK;").as_deref(), Some("3.1"));
        assert_eq!(section("hardware: \"1.0\","), None);
    }

    #[test]
    fn points_of_a_section_without_a_document_are_found() {
        for text in [
            "Point 38 of section 9.",
            "points 6, 7 and 12 of section 10",
            "section 9, point 38",
            "see 4.9, rule 2",
            "Rule 1 to 3 in section 2",
        ] {
            assert_eq!(points(text).len(), 1, "{text}");
        }
        for text in ["point 38", "Points 6 and 7 are open", "a point of section 9", "module 3"] {
            assert!(points(text).is_empty(), "{text}");
        }
    }

    #[test]
    fn a_comment_begins_with_a_section_if_a_sign_or_nothing_is_behind_the_number() {
        for (text, section) in [("2.4: the order", "2.4"), ("2.13, the first trace", "2.13"), ("4.6.1", "4.6.1")] {
            assert_eq!(first(text), Some(section));
        }
        for text in ["1.5 Mbit/s", "3.8.", "8: eight", "2.4 refuses", "a 2.4: b"] {
            assert_eq!(first(text), None, "{text}");
        }
    }

    #[test]
    fn numbers_in_brackets_and_sections_of_three_parts_are_found() {
        let found: Vec<Place> = bracketed("one (14), (84) to (92); RECORD(12), (1.5), (2022)")
            .into_iter()
            .map(|(_, place)| place)
            .collect();
        assert_eq!(found, [Place::Section("14".to_owned()), Place::Range("84".to_owned(), "92".to_owned())]);
        let found: Vec<Place> =
            bracketed("as printed (61, 63); (1, 2.5), (7, 8 to 9)").into_iter().map(|(_, place)| place).collect();
        assert_eq!(found, [Place::Section("61".to_owned()), Place::Section("63".to_owned())]);
        let found: Vec<String> =
            bare("3.2.1 and 1.5 of v1.2.3, 3.2.10.").into_iter().map(|(_, section)| section).collect();
        assert_eq!(found, ["3.2.1", "3.2.10"]);
    }
}
