//! The form of a citation: the name of a document and a list of its sections.
//!
//! `profibus-wire 1.9 and 1.10`, `errata-bpg-bcg-tpg 2 to 37, 39`, `BG 5530 4.4.1 (ID 205), App. D`,
//! `profibus-wire 9.4, point 36`. Brackets after a section do not end the list. Numbers after `table`,
//! `ID`, `step` or `part` have no anchor; the check ignores them.

use super::library::{Document, Library};

/// A named document and the list of its places.
#[derive(Debug)]
pub struct Citation<'l> {
    /// The position of the name in the text.
    pub at: usize,
    /// The position of the end of the list.
    pub end: usize,
    /// The document, or a name that belongs to no document.
    pub document: Result<&'l Document, String>,
    /// Its sections and points.
    pub places: Vec<Place>,
}

/// A place in a document.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// One section.
    Section(String),
    /// All sections from the first to the last.
    Range(String, String),
    /// A point of a section; of a range of points, the first and the last. Without a section the document has no such point.
    Point(Option<String>, u32),
}

/// All citations in a text.
pub fn citations<'l>(text: &str, library: &'l Library) -> Vec<Citation<'l>> {
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(rest) = text.get(at..) {
        let Some(first) = rest.chars().next() else { break };
        let begins = is_begin(text.get(..at).and_then(|before| before.chars().next_back()));
        let named = if begins { name(rest, library) } else { None };
        at = match named {
            Some((document, length)) => {
                let (places, end) = list(text, at + length);
                found.push(Citation { at, end, document, places });
                end
            }
            None => at + first.len_utf8(),
        };
    }
    found
}

/// Whether a name may begin after this text.
fn is_begin(before: Option<char>) -> bool {
    !before.is_some_and(|char| char.is_alphanumeric() || matches!(char, '-' | '_' | '/' | '.'))
}

/// The document whose name begins a text, or a word that looks like a name and belongs to no document, with the length of the name.
fn name<'l>(text: &str, library: &'l Library) -> Option<(Result<&'l Document, String>, usize)> {
    if let Some((document, name)) = library.at_start_of(text) {
        return Some((Ok(document), name.len()));
    }
    let end = text.find(|char: char| !char.is_ascii_alphanumeric() && char != '-').unwrap_or(text.len());
    let (word, rest) = text.split_at_checked(end)?;
    let digit = |text: &str| text.bytes().next().is_some_and(|byte| byte.is_ascii_digit());
    let section = rest.strip_prefix(' ').is_some_and(digit);
    let manual = ["tira", "tina", "tima"].iter().any(|begin| word.strip_prefix(begin).is_some_and(digit));
    let of_us = word.starts_with("errata-") || word.starts_with("profibus-") && section;
    let looks_like = |known: &Document| section && known.ours && known.name().eq_ignore_ascii_case(word);
    if manual || of_us || library.documents().any(looks_like) {
        return Some((Err(word.to_owned()), word.len()));
    }
    let number = text.strip_prefix("BG ").filter(|number| digit(number))?;
    let length = number.find(|char: char| !char.is_ascii_digit()).unwrap_or(number.len());
    Some((Err(text.get(..3 + length)?.to_owned()), 3 + length))
}

/// The meaning of the numbers of a list.
#[derive(Clone, Copy, PartialEq)]
enum Count {
    Sections,
    Appendices,
    Points,
    Other,
}

/// The words before numbers.
const WORDS: [(&str, Count); 20] = [
    ("App. ", Count::Appendices),
    ("Appendix ", Count::Appendices),
    ("appendix ", Count::Appendices),
    ("Appendices ", Count::Appendices),
    ("appendices ", Count::Appendices),
    ("points ", Count::Points),
    ("point ", Count::Points),
    ("rules ", Count::Points),
    ("rule ", Count::Points),
    ("transitions ", Count::Points),
    ("transition ", Count::Points),
    ("sections ", Count::Sections),
    ("section ", Count::Sections),
    ("tables ", Count::Other),
    ("table ", Count::Other),
    ("IDs ", Count::Other),
    ("ID ", Count::Other),
    ("step ", Count::Other),
    ("parts ", Count::Other),
    ("part ", Count::Other),
];

/// The list that begins at a position in a text, and its end.
pub fn list(text: &str, begin: usize) -> (Vec<Place>, usize) {
    let mut places = Vec::new();
    let mut section: Option<String> = None;
    let mut count = Count::Sections;
    let mut to = false;
    let mut end = begin;
    let mut at = begin + text.get(begin..).map_or(0, |rest| usize::from(rest.starts_with(' ')));
    while let Some((kind, id, length)) = item(text.get(at..).unwrap_or(""), count) {
        count = kind;
        match (kind, places.last_mut()) {
            (Count::Other, _) => {}
            (Count::Points, _) => places.extend(id.parse().ok().map(|point| Place::Point(section.clone(), point))),
            (_, Some(last @ Place::Section(_))) if to => {
                let first = section.take().unwrap_or_default();
                *last = Place::Range(first, id.clone());
            }
            _ => places.push(Place::Section(id.clone())),
        }
        if matches!(kind, Count::Sections | Count::Appendices) {
            section = Some(id);
        }
        end = at + length;
        let Some((step, is_to)) = separator(text.get(end..).unwrap_or("")) else { break };
        (at, to) = (end + step, is_to);
    }
    (places, end)
}

/// A number with the word before it, if any, and its length.
fn item(text: &str, count: Count) -> Option<(Count, String, usize)> {
    let word = WORDS.iter().find(|(word, _)| text.starts_with(word));
    let (count, skip) = word.map_or((count, 0), |(word, count)| (*count, word.len()));
    let rest = text.get(skip..)?;
    let letter = count == Count::Appendices || count == Count::Other;
    let id =
        if letter && rest.starts_with(|char: char| char.is_ascii_uppercase()) { rest.get(..1)? } else { number(rest)? };
    let ends = is_end(rest.get(id.len()..)?);
    // Points are whole numbers; after them, a number with a dot is a section again.
    let count = if id.contains('.') && word.is_none() { Count::Sections } else { count };
    ends.then(|| (count, id.to_owned(), skip + id.len()))
}

/// The number with dots at the start of a text.
pub fn number(text: &str) -> Option<&str> {
    let mut end = 0;
    for part in text.split('.') {
        let digits = part.bytes().take_while(u8::is_ascii_digit).count();
        if digits == 0 {
            break;
        }
        end += digits + usize::from(end > 0);
        if digits < part.len() {
            break;
        }
    }
    text.get(..end).filter(|number| !number.is_empty())
}

/// Whether a number ends before this.
fn is_end(rest: &str) -> bool {
    let mut next = rest.chars();
    match next.next() {
        Some('-') => !next.next().is_some_and(char::is_alphanumeric),
        Some(char) => !char.is_alphanumeric() && !matches!(char, '%' | '_' | '\''),
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
    use super::super::library::tests::library;
    use super::*;

    fn cited(text: &str) -> Vec<(String, Vec<Place>)> {
        let library = library();
        let found = citations(text, &library).into_iter();
        found
            .map(|one| {
                (one.document.map_or_else(|name| format!("?{name}"), |known| known.name().to_owned()), one.places)
            })
            .collect()
    }

    fn section(id: &str) -> Place {
        Place::Section(id.to_owned())
    }

    fn range(from: &str, to: &str) -> Place {
        Place::Range(from.to_owned(), to.to_owned())
    }

    fn point(section: &str, number: u32) -> Place {
        Place::Point(Some(section.to_owned()), number)
    }

    fn one(text: &str) -> Vec<Place> {
        let mut found = cited(text);
        assert_eq!(found.len(), 1, "{text}");
        found.remove(0).1
    }

    #[test]
    fn a_section_ends_before_punctuation() {
        for text in [
            "bus-wire 1.2",
            "bus-wire 1.2.",
            "(bus-wire 1.2)",
            "bus-wire 1.2: text",
            "bus-wire 1.2 |",
            "bus-wire 1.2 says 3.4",
        ] {
            assert_eq!(one(text), [section("1.2")], "{text}");
        }
    }

    #[test]
    fn lists_and_ranges() {
        assert_eq!(one("bus-wire 1.9 and 1.10."), [section("1.9"), section("1.10")]);
        assert_eq!(one("bus-wire 2.3, 2.4"), [section("2.3"), section("2.4")]);
        assert_eq!(one("bus-wire 2.8 to 2.10, 3.3 and 3.8."), [range("2.8", "2.10"), section("3.3"), section("3.8")]);
        assert_eq!(one("errata-one 1, 3 to 10, and 12"), [section("1"), range("3", "10"), section("12")]);
    }

    #[test]
    fn points_rules_and_transitions_belong_to_the_section_before() {
        assert_eq!(one("bus-wire 9.4, point 36)"), [section("9.4"), point("9.4", 36)]);
        assert_eq!(one("bus-wire 10, points 9 and 10."), [section("10"), point("10", 9), point("10", 10)]);
        assert_eq!(
            one("bus-wire 4.9, rules 4 and 6, 5.1"),
            [section("4.9"), point("4.9", 4), point("4.9", 6), section("5.1")]
        );
        assert_eq!(
            one("bus-wire 2.6 and 3.2, transitions 8 to 11"),
            [section("2.6"), section("3.2"), point("3.2", 8), point("3.2", 11)]
        );
    }

    #[test]
    fn appendices_and_what_has_no_anchor() {
        assert_eq!(one("BG 12 App. D and E."), [section("D"), section("E")]);
        assert_eq!(one("tira01e1 1.2, Appendix A, 3.1"), [section("1.2"), section("A"), section("3.1")]);
        assert_eq!(one("BG 12 tables 1 to 4, Appendix B"), [section("B")]);
        assert_eq!(one("BG 12 4.4.4, ID 107: codes"), [section("4.4.4")]);
    }

    #[test]
    fn brackets_do_not_end_a_list() {
        assert_eq!(one("errata-one 25 (yes) and 153 (no)"), [section("25"), section("153")]);
        assert_eq!(one("BG 12 4.4.1 (ID 205), 4.4.4"), [section("4.4.1"), section("4.4.4")]);
    }

    #[test]
    fn documents_follow_each_other() {
        let names: Vec<String> =
            cited("tira01e1 4.3, BG 12 4.3.2; errata-one 7").into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["tira01e1", "BG 12", "errata-one"]);
    }

    #[test]
    fn a_quantity_is_no_section() {
        assert_eq!(one("bus-wire 1.2 allows 1 to 240 octets"), [section("1.2")]);
        assert_eq!(one("bus-wire 1.2, 8h"), [section("1.2")]);
        assert_eq!(one("bus-wire 1.2, 50% of it"), [section("1.2")]);
    }

    #[test]
    fn a_name_that_is_misspelt_is_noticed() {
        for name in ["errata-two", "errata-one-more", "profibus-wires", "tira02e1", "tina40e9", "BG 13", "Bus-Wire"] {
            let found = cited(&format!("after {name} 1.2"));
            assert_eq!(found.first().map(|(name, _)| name.clone()), Some(format!("?{name}")), "{name}");
        }
        assert!(cited("profibus-gauges, the crate; my-errata-two; BG509731-A; docs/errata-two.md").is_empty());
    }
}
