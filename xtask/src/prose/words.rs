//! The retired words and forms, with the places where a word has another meaning.

use anyhow::{Result, bail};
use std::collections::BTreeMap;

/// The kind of text that contains a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A name in the source.
    Identifier,
    /// A comment, a page, a label.
    Prose,
    /// A string literal.
    Text,
}

/// A rule that a text breaks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Match {
    /// The word or form.
    pub word: String,
    /// The advice.
    pub better: String,
}

/// The scope of the check for words of the glossary with a second meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// In names only.
    Identifiers,
    /// Nowhere.
    Nowhere,
}

use Scope::{Identifiers, Nowhere};

/// Words of the column "Not" with another meaning, and that meaning.
pub const AMBIGUOUS: [(&str, Scope, &str); 25] = [
    ("patience", Nowhere, "the most evaluations of a fit, in the library levenberg-marquardt"),
    ("member", Identifiers, "a member of a set or of the ring"),
    ("frame", Nowhere, "the frame control octet, the frame count bit, a frame of the terminal"),
    ("packet", Nowhere, "a packet of a capture file"),
    ("byte", Nowhere, "a byte of a file or of memory; methods of the standard library"),
    ("question", Identifiers, "a question of the reader"),
    ("retry", Nowhere, "max_retry_limit of the bus parameters, an attempt to deliver"),
    ("tool", Identifiers, "a development tool"),
    ("live", Nowhere, "live values, aria-live"),
    ("look", Nowhere, "to look at something"),
    ("instrument", Identifiers, "the vendors' manuals"),
    ("unit", Nowhere, "a unit of measurement, a data unit"),
    ("bench", Nowhere, "cargo bench"),
    ("record", Nowhere, "a record of DP-V1, to record samples"),
    ("recording", Nowhere, "a recording of samples"),
    ("bin", Nowhere, "a binary of a package"),
    ("book", Identifiers, "a printed book"),
    ("letter", Nowhere, "a letter of the alphabet"),
    ("person", Identifiers, "a person, not as a user"),
    ("people", Identifiers, "people, not as users"),
    ("act", Identifiers, "to act"),
    ("order", Nowhere, "the order of a list, ORDER_ID"),
    ("fire", Identifiers, "fire"),
    ("tbit", Nowhere, "the unit at the end of a name"),
    ("participant", Identifiers, "a participant of the bus, in its definition"),
];

/// Words without an actor, with the advice.
pub const FORMS: [(&str, &str); 5] = [
    ("whoever", "name the actor"),
    ("nobody", "name the actor: no station, no user"),
    ("somebody", "name the actor"),
    ("someone", "name the actor"),
    ("so many", "give the number, or its name"),
];

/// Verbs that make "What" at the beginning of a sentence its subject.
const VERBS: [&str; 28] = [
    "is", "are", "was", "were", "has", "have", "had", "does", "did", "can", "cannot", "may", "might", "must", "will",
    "would", "comes", "came", "goes", "went", "lies", "stands", "takes", "needs", "says", "said", "makes", "happens",
];

/// A place where a word has its proper meaning: the word, the beginning of the path, the reason.
pub type Allowed = (&'static str, &'static str, &'static str);

/// All of these places. An entry without use is a defect.
pub const ALLOWED: [Allowed; 13] = [
    ("gate", "crates/cli/src/demo/", "a gate valve"),
    ("gate", "crates/station/examples/fake_plant/", "a gate valve"),
    ("gate", "crates/vacuum/", "a gate valve"),
    ("gate", "crates/virtual/", "a gate valve"),
    ("gate", "docs/scenarios.md", "a gate valve"),
    ("remark", "crates/cli/src/monitor/", "the output key and column `remarks`"),
    ("remark", "crates/cli/tests/gauge_commands/ownership.rs", "the output key and column `remarks`"),
    ("remark", "crates/cli/tests/monitor.rs", "the output key and column `remarks`"),
    ("remark", "crates/cli/src/identify/source.rs", "the column `remarks` of `monitor --csv`"),
    ("remark", "crates/cli/tests/identify.rs", "the column `remarks` of `monitor --csv`"),
    ("remark", "docs/first-steps.md", "the output key and column `remarks`"),
    ("mastership", "crates/recorder/src/schema.rs", "a sentence in the database of an earlier version"),
    ("standing", "crates/station/src/report/figures.rs", "a key of the report in JSON"),
];

/// The rules of the glossary and of the tables of this file.
pub struct Rules {
    /// Retired words with the word to use, and whether they are checked in names only.
    words: BTreeMap<String, (String, bool)>,
}

impl Rules {
    /// Reads the tables of the glossary.
    pub fn new(glossary: &str) -> Result<Self> {
        let mut words = BTreeMap::new();
        let mut ambiguous: BTreeMap<&str, Scope> = AMBIGUOUS.iter().map(|(word, scope, _)| (*word, *scope)).collect();
        for (retired, better) in glossary.lines().flat_map(row) {
            let scope = AMBIGUOUS.iter().find(|(word, ..)| *word == retired).map(|(_, scope, _)| *scope);
            ambiguous.remove(retired.as_str());
            if scope != Some(Nowhere) {
                words.insert(retired, (better, scope == Some(Identifiers)));
            }
        }
        if let Some((word, _)) = ambiguous.first_key_value() {
            bail!("xtask/src/prose/words.rs: '{word}' is in no column \"Not\" of docs/glossary.md");
        }
        Ok(Self { words })
    }

    /// The rule for one word in lower case.
    fn word(&self, word: &str, place: Place) -> Option<Match> {
        let singular = word.strip_suffix('s').filter(|singular| !self.words.contains_key(word) && singular.len() > 2);
        let key = singular.unwrap_or(word);
        let (better, names_only) = self.words.get(key)?;
        let applies = place == Place::Identifier || !names_only;
        applies.then(|| Match { word: key.to_owned(), better: format!("use '{better}'") })
    }

    /// The rules that a name breaks: its parts, split at underscores and capitals, are words.
    pub fn identifier(&self, name: &str) -> Vec<Match> {
        let parts = parts(name);
        let mut found: Vec<Match> = parts.iter().filter_map(|part| self.word(part, Place::Identifier)).collect();
        let sentence = parts.join(" ");
        found.extend(FORMS.iter().filter(|(form, _)| contains(&sentence, form)).map(form));
        found
    }

    /// The rules that a sentence or a line breaks.
    pub fn text(&self, text: &str, place: Place) -> Vec<Match> {
        let lower = text.to_lowercase();
        let words = lower.split(|char: char| !char.is_alphanumeric() && char != '-' && char != '\'');
        let mut found: Vec<Match> = words.filter_map(|word| self.word(word, place)).collect();
        found.extend(FORMS.iter().filter(|(form, _)| contains(&lower, form)).map(form));
        found
    }
}

fn form((form, better): &(&str, &str)) -> Match {
    Match { word: (*form).to_owned(), better: (*better).to_owned() }
}

/// Whether `text` has `form` as whole words.
fn contains(text: &str, form: &str) -> bool {
    let is_word = |char: Option<char>| char.is_some_and(char::is_alphanumeric);
    text.match_indices(form).any(|(start, form)| {
        let before = text.get(..start).and_then(|before| before.chars().next_back());
        let after = text.get(start.saturating_add(form.len())..).and_then(|after| after.chars().next());
        !is_word(before) && !is_word(after)
    })
}

/// The rule that the form of a sentence breaks: its subject is "who" or "what", and it is not a question.
pub fn sentence(sentence: &str) -> Option<Match> {
    let mut words = sentence.split_whitespace();
    let (first, second) = (words.next()?, words.next()?);
    let headless = match first {
        "Who" => true,
        "What" => VERBS.contains(&second),
        _ => false,
    };
    (headless && !sentence.trim_end().ends_with('?'))
        .then(|| Match { word: format!("{first} {second}"), better: "begin with the actor or the thing".to_owned() })
}

/// The sentences of a text, each with the position of its first letter.
pub fn sentences(text: &str) -> Vec<(usize, &str)> {
    let mut found = Vec::new();
    let mut start = 0usize;
    for ((place, one), next) in text.char_indices().zip(text.chars().skip(1)) {
        if matches!((one, next), ('.' | '?' | '!' | ':', ' ' | '\n')) {
            let end = place.saturating_add(1);
            found.push((start, text.get(start..end).unwrap_or_default()));
            start = end;
        }
    }
    found.push((start, text.get(start..).unwrap_or_default()));
    let trimmed = found.into_iter().map(|(start, part)| {
        let begin = part.trim_start();
        (start.saturating_add(part.len().saturating_sub(begin.len())), begin.trim_end())
    });
    trimmed.filter(|(_, part)| !part.is_empty()).collect()
}

/// The words of a name in lower case: `sendsUntil2`, `SENDS_UNTIL` and `SendsUntil` have `sends` and `until`.
fn parts(name: &str) -> Vec<String> {
    let mut parts: Vec<String> = Vec::new();
    let mut before = '_';
    for char in name.chars() {
        let begins = !before.is_alphabetic() || char.is_uppercase() && before.is_lowercase();
        if char.is_alphabetic() {
            if begins {
                parts.push(String::new());
            }
            if let Some(part) = parts.last_mut() {
                part.extend(char.to_lowercase());
            }
        }
        before = char;
    }
    parts
}

/// The retired words of a row of the glossary, each with the word to use. A word with a remark in parentheses counts without.
fn row(line: &str) -> Vec<(String, String)> {
    let cells: Vec<&str> = line.split('|').map(str::trim).collect();
    let ["", better, _, retired, ""] = cells[..] else { return Vec::new() };
    if better == "Word" || better.starts_with("--") {
        return Vec::new();
    }
    let better = better.replace(['*', '`'], "");
    let without_remark = |word: &str| word.split('(').next().unwrap_or_default().replace('`', "").trim().to_lowercase();
    // Commas within a remark separate nothing.
    let mut depth = 0usize;
    let words = retired.split(|char| {
        match char {
            '(' => depth = depth.saturating_add(1),
            ')' => depth = depth.saturating_sub(1),
            _ => {}
        }
        char == ',' && depth == 0
    });
    let words = words.map(without_remark).filter(|word| !word.is_empty());
    words.map(|word| (word, better.clone())).collect()
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// Rules for tests: `slack` is retired, `tool` in names only, `record` nowhere.
    pub fn rules() -> Rules {
        let rest: Vec<&str> = AMBIGUOUS.iter().map(|(word, ..)| *word).collect();
        let glossary = format!(
            "| Word | Meaning | Not |\n|---|---|---|\n| timeout | the longest wait | slack (of `x`, y), ear |\n| x | | {} |\n",
            rest.join(", ")
        );
        Rules::new(&glossary).unwrap()
    }

    fn words(matches: Vec<Match>) -> Vec<String> {
        matches.into_iter().map(|found| found.word).collect()
    }

    #[test]
    fn retired_words_are_found_whole_and_in_the_plural() {
        let rules = rules();
        assert_eq!(words(rules.text("Slack, with two ears.", Place::Prose)), ["slack", "ear"]);
        assert!(rules.text("slacken, near, early, a record, a tool", Place::Prose).is_empty());
        assert_eq!(rules.text("slack", Place::Text)[0].better, "use 'timeout'");
    }

    #[test]
    fn names_are_split_at_underscores_and_capitals() {
        let rules = rules();
        assert_eq!(words(rules.identifier("first_ear")), ["ear"]);
        assert_eq!(words(rules.identifier("EarTool2")), ["ear", "tool"]);
        assert_eq!(words(rules.identifier("MOST_SLACK")), ["slack"]);
        assert!(rules.identifier("early_learner_toolbox_record").is_empty());
        assert_eq!(words(rules.identifier("it_disturbs_nobody_so_many_times")), ["nobody", "so many"]);
    }

    #[test]
    fn indefinite_actors_are_found() {
        let rules = rules();
        assert_eq!(words(rules.text("Whoever waits, somebody answers.", Place::Prose)), ["whoever", "somebody"]);
        assert_eq!(words(rules.text("after so many seconds", Place::Text)), ["so many"]);
        assert!(rules.text("not so manyfold", Place::Prose).is_empty());
    }

    #[test]
    fn who_and_what_are_no_subjects_but_ask() {
        assert_eq!(sentence("Who listens hears all.").unwrap().word, "Who listens");
        assert_eq!(sentence("What is sent is read.").unwrap().word, "What is");
        assert_eq!(sentence("What is sent?"), None);
        assert_eq!(sentence("What the reason means."), None);
        assert_eq!(sentence("Whole numbers."), None);
    }

    #[test]
    fn sentences_end_at_full_stops_and_not_within_numbers() {
        let expected = [(0, "One 1.5 two."), (13, "Three?"), (20, "Four:"), (26, "five")];
        assert_eq!(sentences("One 1.5 two. Three? Four:\nfive"), expected);
    }

    #[test]
    fn every_ambiguous_word_is_in_the_glossary() {
        assert!(Rules::new("| timeout | | slack |").is_err());
    }
}
