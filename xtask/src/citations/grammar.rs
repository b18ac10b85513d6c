//! The form of a citation: the name of a document and a list of its sections.
//!
//! `profibus-wire 1.9 and 1.10`, `errata-bpg-bcg-tpg 2 to 37, 39`, `BG 5530 4.4.1 (ID 205), App. D`,
//! `profibus-wire 9.4, point 36`. Brackets after a section do not end the list; any other word does.

use super::library::Document;

/// A named document and the list of its places.
pub struct Citation<'l> {
    /// The position of the name in the text.
    pub at: usize,
    /// The document, or a name that belongs to no document.
    pub document: Result<&'l Document, String>,
    /// Its sections and points.
    pub places: Vec<Place>,
}

/// A place in a document.
pub enum Place {
    /// One section.
    Section(String),
    /// All sections from the first to the last.
    Range(String, String),
    /// A point of a section; of a range of points, the first and the last.
    Point(String, u32),
}

/// All citations in a text.
pub fn citations<'l>(text: &str, library: &'l [Document]) -> Vec<Citation<'l>> {
    let mut found = Vec::new();
    // Few words begin like a name, and this question is quick.
    let names = library.iter().flat_map(|known| &known.names);
    let firsts: Vec<char> = names.filter_map(|name| name.chars().next()).chain("eEpPtTB".chars()).collect();
    let (mut at, mut before) = (0, None);
    while let Some((rest, first)) = text.get(at..).and_then(|rest| Some((rest, rest.chars().next()?))) {
        let inside = before.is_some_and(|char: char| char.is_alphanumeric() || "-_/.".contains(char));
        let named = if inside || !firsts.contains(&first) { None } else { name(rest, library) };
        if let Some((document, length)) = named {
            let (places, end) = list(text, at + length);
            found.push(Citation { at, document, places });
            (at, before) = (end, None);
        } else {
            (at, before) = (at + first.len_utf8(), Some(first));
        }
    }
    found
}

/// The document whose name begins a text, or a word that looks like a name and belongs to no document, with the length of the name.
fn name<'l>(text: &str, library: &'l [Document]) -> Option<(Result<&'l Document, String>, usize)> {
    let digit = |text: &str| text.starts_with(|char: char| char.is_ascii_digit());
    let named = library.iter().flat_map(|document| document.names.iter().map(move |name| (document, name)));
    let begins = |name: &str| text.strip_prefix(name).is_some_and(|rest| is_end(rest, "_"));
    if let Some((document, name)) = named.filter(|(_, name)| begins(name)).max_by_key(|(_, name)| name.len()) {
        return Some((Ok(document), name.len()));
    }
    let end = text.find(|char: char| !char.is_ascii_alphanumeric() && char != '-').unwrap_or(text.len());
    let (word, rest) = text.split_at_checked(end)?;
    let lower = word.to_ascii_lowercase();
    let manual = ["tira", "tina", "tima"].iter().any(|begin| lower.strip_prefix(begin).is_some_and(digit));
    let section = rest.strip_prefix(' ').is_some_and(digit);
    if manual || section && ["errata-", "profibus-"].iter().any(|begin| lower.starts_with(begin)) {
        return Some((Err(word.to_owned()), word.len()));
    }
    let number = text.strip_prefix("BG ").and_then(number)?;
    Some((Err(format!("BG {number}")), 3 + number.len()))
}

/// The meaning of the numbers of a list.
#[derive(Clone, Copy, PartialEq)]
enum Count {
    Sections,
    Appendices,
    Points,
}

/// The words before numbers.
const WORDS: [(Count, &[&str]); 3] = [
    (Count::Sections, &["section "]),
    (Count::Appendices, &["App. ", "Appendix ", "Appendices "]),
    (Count::Points, &["point ", "points ", "rule ", "rules ", "transition ", "transitions "]),
];

/// The list that begins at a position in a text, and its end.
fn list(text: &str, begin: usize) -> (Vec<Place>, usize) {
    let mut places = Vec::new();
    let mut section = String::new();
    let (mut count, mut to, mut end) = (Count::Sections, false, begin);
    let mut at = begin + text.get(begin..).map_or(0, |rest| usize::from(rest.starts_with(' ')));
    while let Some((kind, id, length)) = item(text.get(at..).unwrap_or(""), count) {
        count = kind;
        match (kind, places.last_mut()) {
            (Count::Points, _) => places.extend(id.parse().ok().map(|point| Place::Point(section.clone(), point))),
            (_, Some(last @ Place::Section(_))) if to => {
                *last = Place::Range(std::mem::take(&mut section), id.to_owned());
            }
            _ => places.push(Place::Section(id.to_owned())),
        }
        if kind != Count::Points {
            section = id.to_owned();
        }
        end = at + length;
        let Some((step, is_to)) = separator(text.get(end..).unwrap_or("")) else { break };
        (at, to) = (end + step, is_to);
    }
    (places, end)
}

/// A number with the word before it, if any, and its length.
fn item(text: &str, count: Count) -> Option<(Count, &str, usize)> {
    let behind =
        |(count, words): &(Count, &[&str])| Some((words.iter().find_map(|word| text.strip_prefix(word))?, *count));
    let word = WORDS.iter().find_map(behind);
    let (rest, count) = word.unwrap_or((text, count));
    let letter = count == Count::Appendices && rest.starts_with(|char: char| char.is_ascii_uppercase());
    let id = if letter { rest.get(..1)? } else { number(rest)? };
    // Points are whole numbers; after them, a number with a dot is a section again.
    let count = if id.contains('.') && word.is_none() { Count::Sections } else { count };
    is_end(rest.get(id.len()..)?, "%_'").then_some((count, id, text.len() - rest.len() + id.len()))
}

/// The number with dots at the start of a text.
fn number(text: &str) -> Option<&str> {
    let length = text.find(|char: char| !char.is_ascii_digit() && char != '.').unwrap_or(text.len());
    let number = text.get(..length)?.trim_end_matches('.');
    (number.starts_with(|char: char| char.is_ascii_digit()) && !number.contains("..")).then_some(number)
}

/// Whether a name or a number ends before this: no letter, digit or sign of `others`, and no hyphen within a word.
fn is_end(rest: &str, others: &str) -> bool {
    let mut next = rest.chars();
    match next.next() {
        Some('-') => !next.next().is_some_and(char::is_alphanumeric),
        Some(char) => !char.is_alphanumeric() && !others.contains(char),
        None => true,
    }
}

/// The separator between two numbers: its length, and whether it is `to`. Brackets before it belong to it.
fn separator(text: &str) -> Option<(usize, bool)> {
    let bracket = text.strip_prefix(" (").and_then(|inside| inside.find(')')).map_or(0, |length| length + 3);
    let rest = text.get(bracket..)?;
    let found = [", and ", ", ", " and ", " or ", " to "].iter().find(|separator| rest.starts_with(**separator))?;
    Some((bracket + found.len(), *found == " to "))
}

#[cfg(test)]
mod tests {
    use super::super::tests::library;
    use super::*;

    /// The places of the one citation in a text: `2.4`, `2.8-2.10`, `9.4#36`.
    fn one(text: &str) -> String {
        let library = library();
        let found = citations(text, &library);
        assert_eq!(found.len(), 1, "{text}");
        let places = found[0].places.iter().map(|place| match place {
            Place::Section(id) => id.clone(),
            Place::Range(from, to) => format!("{from}-{to}"),
            Place::Point(section, number) => format!("{section}#{number}"),
        });
        places.collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn a_section_ends_before_punctuation_and_a_quantity_is_none() {
        for rest in
            ["", ".", ")", ": text", " |", " says 3.4", " allows 1 to 240 octets", ", 8h", ", 50% of it", ", ID 5"]
        {
            assert_eq!(one(&format!("(bus-wire 1.2{rest}")), "1.2", "{rest}");
        }
    }

    #[test]
    fn lists_have_sections_ranges_appendices_and_points_of_the_section_before() {
        for (text, places) in [
            ("bus-wire 1.9 and 1.10.", "1.9 1.10"),
            ("bus-wire 2.8 to 2.10, 3.3 and 3.8.", "2.8-2.10 3.3 3.8"),
            ("errata-one 1, 3 to 10, and 12", "1 3-10 12"),
            ("errata-one 25 (yes) and 153 (no)", "25 153"),
            ("BG 12 App. D and E.", "D E"),
            ("tira01e1 1.2, Appendix A, 3.1", "1.2 A 3.1"),
            ("bus-wire 10, points 9 and 10.", "10 10#9 10#10"),
            ("bus-wire 4.9, rule 4, 5.1", "4.9 4.9#4 5.1"),
            ("bus-wire 2.6 and 3.2, transitions 8 to 11", "2.6 3.2 3.2#8 3.2#11"),
        ] {
            assert_eq!(one(text), places, "{text}");
        }
    }

    #[test]
    fn the_longest_name_wins_and_a_misspelt_one_is_noticed() {
        let library = library();
        let names = |text: &str| -> Vec<String> {
            let found = citations(text, &library).into_iter();
            found
                .map(|one| one.document.map_or_else(|name| format!("?{name}"), |known| known.names[0].clone()))
                .collect()
        };
        assert_eq!(names("tira01e1-a 4.3, BG 12 4.3.2; errata-one 7"), ["tira01e1", "BG 12", "errata-one"]);
        for name in ["errata-two", "errata-one-more", "profibus-wires", "Profibus-wire", "tira01e12", "BG 13"] {
            assert_eq!(names(&format!("after {name} 1.2")), [format!("?{name}")]);
        }
        assert_eq!(names("profibus-gauges, the crate; my-errata-two; BG509731-A; docs/errata-two.md"), [""; 0]);
    }
}
