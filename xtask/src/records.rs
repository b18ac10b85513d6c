//! The decision records in DESIGN.md: each has a number of its own, a decision, a reason, alternatives and a cost.

use crate::{root, verdict};
use anyhow::{Context, Result};
use std::collections::BTreeSet;

/// The parts of a record behind its decision.
const PARTS: [&str; 3] = ["- **Reason:** ", "- **Alternatives:** ", "- **Cost:** "];

/// Checks the records.
pub fn check() -> Result<()> {
    let text = std::fs::read_to_string(root().join("DESIGN.md")).context("DESIGN.md")?;
    verdict("records", &defects(&text))
}

/// A record: its title and the lines up to the next heading.
struct Record<'a> {
    title: &'a str,
    lines: Vec<&'a str>,
}

fn records(text: &str) -> Vec<Record<'_>> {
    let mut found: Vec<Record<'_>> = Vec::new();
    let mut is_open = false;
    for line in text.lines() {
        if let Some(title) = line.strip_prefix("### ") {
            found.push(Record { title, lines: Vec::new() });
            is_open = true;
        } else if line.starts_with("## ") {
            is_open = false;
        } else if let Some(record) = found.last_mut().filter(|_| is_open) {
            record.lines.push(line);
        }
    }
    found
}

fn defects(text: &str) -> Vec<String> {
    let records = records(text);
    let number = |title: &str| title.split_once(". ").and_then(|(number, _)| number.parse::<u32>().ok());
    let known: BTreeSet<u32> = records.iter().filter_map(|record| number(record.title)).collect();
    let mut seen = BTreeSet::new();
    let mut all = Vec::new();
    for Record { title, lines } in &records {
        match number(title) {
            None => all.push(format!("'{title}': expected 'NUMBER. TITLE'")),
            Some(number) if !seen.insert(number) => all.push(format!("'{title}': another record has this number")),
            Some(_) => {}
        }
        if lines.last().is_some_and(|last| !last.is_empty()) && !text.trim_end().ends_with(&lines.join("\n")) {
            all.push(format!("'{title}': expected an empty line behind it"));
        }
        if let Some(successor) = successor(title) {
            if !known.contains(&successor) {
                all.push(format!("'{title}': there is no record {successor}"));
            }
            continue;
        }
        let decision = lines.iter().find(|line| !line.is_empty());
        if decision.is_none_or(|line| line.starts_with("- ")) {
            all.push(format!("'{title}': expected the decision in a sentence before the reason"));
        }
        for part in PARTS.iter().filter(|part| !lines.iter().any(|line| line.starts_with(*part))) {
            all.push(format!("'{title}': expected a line that begins with '{part}'"));
        }
    }
    all
}

/// The number in `(replaced by 163)`.
fn successor(title: &str) -> Option<u32> {
    let (_, rest) = title.split_once("replaced by ")?;
    rest.split(|letter: char| !letter.is_ascii_digit()).next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    const RECORD: &str =
        "### 1. One (0.2.0)\n\nIt is so.\n\n- **Reason:** a.\n- **Alternatives:** b.\n- **Cost:** c.\n";

    #[test]
    fn a_whole_record_has_no_defect() {
        assert_eq!(defects(&format!("## A\n\n{RECORD}\n## B\n\ntext\n")), [""; 0]);
        assert_eq!(defects(&format!("{RECORD}\n### 2. Two (0.2.0, replaced by 1)\n")), [""; 0]);
    }

    #[test]
    fn a_missing_part_number_or_line_is_a_defect() {
        let defect = |text: &str| defects(text).first().cloned().unwrap_or_default();
        assert!(defect(&RECORD.replace("- **Cost:** c.\n", "")).ends_with("begins with '- **Cost:** '"));
        assert!(defect(&RECORD.replace("It is so.\n\n", "")).ends_with("before the reason"));
        assert!(defect(&RECORD.replace("1. One", "One")).ends_with("expected 'NUMBER. TITLE'"));
        assert!(defect(&format!("{RECORD}\n{RECORD}")).ends_with("another record has this number"));
        assert!(defect(&format!("{RECORD}### 2. Two (replaced by 1)\n")).ends_with("an empty line behind it"));
        assert!(defect(&format!("{RECORD}\n### 2. Two (replaced by 9)\n")).ends_with("there is no record 9"));
    }
}
