//! Pages and the sources of the dashboard, line by line.

use super::Found;
use super::words::{Place, Rules, sentence, sentences};

/// Everything in a source of the dashboard that breaks a rule: each line is names and prose at once.
pub fn lines(rules: &Rules, text: &str) -> Vec<Found> {
    let mut found = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let words = line.split(|char: char| !char.is_alphanumeric() && char != '_').filter(|word| !word.is_empty());
        found.extend(words.flat_map(|word| rules.identifier(word)).map(|found| (number, found)));
        let spaced = rules.text(line, Place::Prose).into_iter().filter(|found| found.word.contains(' '));
        found.extend(spaced.map(|found| (number, found)));
    }
    found
}

/// Everything in a page that breaks a rule. Blocks of code are not checked for sentences.
pub fn markdown(rules: &Rules, text: &str) -> Vec<Found> {
    let (mut found, mut in_code) = (Vec::new(), false);
    for (number, line) in (1..).zip(text.lines()) {
        if line.trim_start().starts_with("```") {
            in_code = !in_code;
            continue;
        }
        found.extend(rules.text(line, Place::Prose).into_iter().map(|found| (number, found)));
        if !in_code {
            let line = line.trim_start_matches([' ', '-', '*', '#', '>']);
            found.extend(
                sentences(line).into_iter().filter_map(|(_, part)| sentence(part)).map(|found| (number, found)),
            );
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prose::words::tests::rules;

    fn words(found: Vec<Found>) -> Vec<(usize, String)> {
        found.into_iter().map(|(line, found)| (line, found.word)).collect()
    }

    #[test]
    fn names_and_labels_of_the_dashboard_are_read() {
        let source = "const firstEar = 1;\n<p>No slack</p>\n// after so many seconds\n.early { }";
        let expected = [(1, "ear".to_owned()), (2, "slack".to_owned()), (3, "so many".to_owned())];
        assert_eq!(words(lines(&rules(), source)), expected);
    }

    #[test]
    fn pages_are_read_and_code_has_no_sentences() {
        let page = "# Ears\n- What is sent is read.\n```\nWhat is this\nslack\n```\nA tool. Who waits loses.";
        let expected = [(1, "ear"), (2, "What is"), (5, "slack"), (7, "Who waits")];
        assert_eq!(words(markdown(&rules(), page)), expected.map(|(line, word)| (line, word.to_owned())));
    }
}
