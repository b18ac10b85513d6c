//! What is wrong with a file is told with line, column, what was expected and what came.

use profivac_host::scenario::Scenario;

/// Lines 1 to 9; what is appended begins at line 10.
const GOOD: &str = "\
title = \"test\"
until = \"1 min\"
[volumes]
chamber = { volume = \"10 l\" }
[valves.gate]
between = [\"chamber\", \"chamber\"]
conductance = \"10 l/s\"
[gauges]
\"bpg400@5\" = \"chamber\"
";

fn said(text: &str) -> String {
    match Scenario::parse(text, "x.toml") {
        Ok(_) => "nothing".to_owned(),
        Err(error) => error.to_string(),
    }
}

fn changed(from: &str, to: &str) -> String {
    assert!(GOOD.contains(from), "{from}");
    said(&GOOD.replace(from, to))
}

fn with(entry: &str) -> String {
    said(&format!("{GOOD}[[timeline]]\nat = \"10 s\"\n{entry}\n"))
}

#[test]
fn a_good_file_is_taken() {
    assert_eq!(said(GOOD), "nothing");
    assert_eq!(with("open = [\"gate\"]\nfault = [{ device = 5, name = \"sensor2\" }]"), "nothing");
}

#[test]
fn values_that_are_none_are_told_with_their_place() {
    for (from, to, sentence) in [
        ("1 min", "1 minute", "x.toml:2:9: expected a time like \"90 s\" in ms, s, min, h, d, got \"1 minute\""),
        ("10 l\"", "0 l\"", "x.toml:4:22: expected a volume above zero, got \"0 l\""),
        (
            "\"chamber\", \"chamber\"",
            "\"chamber\", \"camber\"",
            "x.toml:6:23: expected a volume, got \"camber\"; there are chamber; did you mean \"chamber\"?",
        ),
        ("bpg400@5", "bpg401@5", "x.toml:9:1: unknown device \"bpg401\"; there are pcg550"),
        ("= \"chamber\"\n", "= \"room\"\n", "x.toml:9:14: expected a volume, got \"room\"; there are chamber"),
        ("conductance = \"10 l/s\"", "diameter = \"1 cm\"", "x.toml:5:1: expected diameter and length, or conductance"),
        (
            "volume = \"10 l\"",
            "volum = \"10 l\"",
            "x.toml:4:13: unknown field `volum`, expected one of `volume`, `gas`, `pressure`; did you mean `volume`?",
        ),
        ("until = \"1 min\"\n", "until = 5\n", "x.toml:2:9: invalid type: integer `5`, expected a string"),
        ("title = \"test\"", "title = ", "x.toml:1:9: "),
    ] {
        let found = changed(from, to);
        assert!(found.starts_with(sentence), "{found}\ninstead of\n{sentence}");
    }
    assert!(said("until = \"1 s\"").contains("missing field `title`"));
}

#[test]
fn what_cannot_happen_is_told_before_anything_happens() {
    for (entry, sentence) in [
        (
            "open = [\"gaet\"]",
            "x.toml:12:9: expected a valve, tube, leak or vent, got \"gaet\"; there are gate; did you mean \"gate\"?",
        ),
        ("start = [\"gate\"]", "x.toml:12:10: expected a pump, got \"gate\"; there is none"),
        (
            "fault = [{ device = 6, name = \"ram\" }]",
            "x.toml:12:21: expected the address of a gauge, got 6; there are 5",
        ),
        (
            "fault = [{ device = 5, name = \"sensor3\" }]",
            "x.toml:12:31: expected something bpg400 has, got \"sensor3\"; it has eeprom, ram",
        ),
        (
            "button = [{ device = 5, number = 1 }]",
            "x.toml:12:34: expected something bpg400 has, got \"1\"; it has nothing",
        ),
        ("heat = [{ wall = \"w\", to = \"hot\" }]", "x.toml:12:28: expected a temperature like"),
        (
            "expect = [{ device = 5, near = \"1 mbar\", below = \"2 mbar\" }]",
            "x.toml:12:11: expected near, or above and below",
        ),
        (
            "expect = [{ volume = \"chamber\", valid = true }]",
            "x.toml:12:11: expected of a volume nothing but its pressure",
        ),
        ("expect = [{ device = 5 }]", "x.toml:12:11: expected something that has to be so"),
        (
            "expect = [{ device = 5, below = \"low\" }]",
            "x.toml:12:33: expected a pressure like '1e-3 mbar', got \"low\"",
        ),
        ("opne = [\"gate\"]", "x.toml:12:1: unknown field `opne`"),
        ("atmosphere = { humidity = \"120 %\" }", "x.toml:12:27: expected at most 100 %, got \"120 %\""),
    ] {
        let found = with(entry);
        assert!(found.starts_with(sentence), "{found}\ninstead of\n{sentence}");
    }
    let late = said(&format!("{GOOD}[[timeline]]\nat = \"2 min\"\n"));
    assert_eq!(late, "x.toml:11:6: expected a time before the end of the scenario, got \"2 min\"");
}

#[test]
fn a_name_or_an_address_is_given_once() {
    let twice = said(&format!("{GOOD}\"bcg450@5\" = \"chamber\"\n"));
    assert!(twice.contains("two devices at address 5"), "{twice}");
    let twice = said(&format!("{GOOD}[leaks]\ngate = {{ at = \"chamber\", rate = \"1 sccm\" }}\n"));
    assert!(twice.contains("the name \"gate\" is given twice"), "{twice}");
}
