//! The page docs/conform-rules.md: the rules, their faulty slaves, and the outcome of every rule for every faulty slave.

use super::faults::{self, FaultySlave};
use super::faulty::FaultyLine;
use super::{results, slave};
use profivac_conform::dialogue::LoggedCycle;
use profivac_conform::probe::Received;
use profivac_conform::{CheckResult, Outcome, checks};
use std::fmt::Write;

const HEAD: &str = "\
# The rules of `profivac conform`, and one faulty slave for each

`cargo test -p profivac-conform --test rules` prints this page and compares it with every run. A faulty slave is a correct one
with one fault between it and the line. Each breaks its own rule and no other. A rule that cannot be tested because of the
fault is not broken but not tested. Sections are those of [profibus-wire](spec/profibus-wire/README.md).

The correct slave keeps every rule, and none of the twelve devices breaks one.
";

const RULES: &str = "
## Rules

*Needs* lists the rules that must be kept, so that the test of this one proves something and shows a fault of its own.

| # | Rule | Name | Section | Needs |
|---|---|---|---|---|
";

const SLAVES: &str = "
## Faulty slaves

*Expected*, *request* and *answer* are what `profivac conform` shows for the broken rule.

| # | The slave | breaks | Expected | Request | Answer | Not tested |
|---|---|---|---|---|---|---|
";

const MATRIX: &str = "
## Every rule for every faulty slave

A row is a faulty slave, a column is a rule; both have the numbers above. `.` passed, `B` broken, `-` not tested.

```text
";

/// The page.
pub fn print() -> String {
    let rules: Vec<_> = checks::all().collect();
    let number = |name: &str| rules.iter().position(|rule| rule.name == name).unwrap() + 1;
    let mut page = format!("{HEAD}{RULES}");
    for rule in &rules {
        let needs: Vec<_> = rule.needs.iter().chain(rule.shares).map(|name| number(name).to_string()).collect();
        let (n, text, name, section) = (number(rule.name), rule.rule, rule.name, rule.section);
        writeln!(page, "| {n} | {text} | `{name}` | {} | {} |", link(section), needs.join(", ")).unwrap();
    }
    let rows: Vec<_> = faults::all().map(|slave| (slave, outcomes(slave))).collect();
    page += SLAVES;
    for (slave, results) in &rows {
        writeln!(page, "| {} |", [number(slave.rule).to_string(), row(slave, results)].join(" | ")).unwrap();
    }
    page += MATRIX;
    for digit in [100, 10, 1] {
        let digits = (1..=rules.len()).map(|n| char::from(b'0' + (n / digit % 10) as u8));
        writeln!(page, "     {}", digits.collect::<String>()).unwrap();
    }
    for (slave, results) in &rows {
        let signs: String = results.iter().map(|result| sign(&result.outcome)).collect();
        writeln!(page, "{:>3}  {signs}", number(slave.rule)).unwrap();
    }
    page + "```\n"
}

/// A section of the reference with its anchor.
fn link(section: &str) -> String {
    let file = match section.split('.').next() {
        Some("1") => "01-fdl",
        Some("2") => "02-dp-v0",
        Some("3") => "03-slave",
        _ => "04-acyclic",
    };
    format!("[{section}](spec/profibus-wire/{file}.md#{section})")
}

fn outcomes(slave: &FaultySlave) -> Vec<CheckResult> {
    let (line, subject) = slave::sample();
    results(&mut FaultyLine::new(line, &slave.fault), &subject)
}

const fn sign(outcome: &Outcome) -> char {
    match outcome {
        Outcome::Passed => '.',
        Outcome::Broken { .. } => 'B',
        Outcome::NotTested(_) => '-',
    }
}

/// The cells of a faulty slave behind its number.
fn row(slave: &FaultySlave, results: &[CheckResult]) -> String {
    let broken = results.iter().find_map(|result| match &result.outcome {
        Outcome::Broken { expected, shown } => Some((expected.to_string(), shown.as_ref())),
        Outcome::Passed | Outcome::NotTested(_) => None,
    });
    let (expected, shown) = broken.unwrap();
    let untested = results.iter().filter(|result| sign(&result.outcome) == '-').count();
    let (request, answer) = shown.map_or_else(Default::default, cycle);
    [slave.does.to_owned(), format!("`{}`", slave.rule), expected, request, answer, untested.to_string()].join(" | ")
}

fn cycle(cycle: &LoggedCycle) -> (String, String) {
    let answer = match &cycle.received {
        Received::Nothing => "none".to_owned(),
        Received::Damaged => "damaged".to_owned(),
        Received::Telegram(octets) => hex(octets),
    };
    (hex(&cycle.sent), answer)
}

fn hex(octets: &[u8]) -> String {
    let octets: Vec<_> = octets.iter().map(|octet| format!("{octet:02X}")).collect();
    format!("`{}`", octets.join(" "))
}
