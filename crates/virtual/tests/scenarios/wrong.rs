//! An invalid scenario file is an error with line, column, the expected and the found value.

use profivac_virtual::scenario::{MasterPresence, Scenario};

/// Lines 1 to 9; appended text begins at line 10.
const GOOD: &str = "\
title = \"test\"
until = \"1 min\"
# Two of them, as tables of one line.
volumes = { chamber = { volume = \"10 l\" }, fore = { volume = \"1 l\" } }
[valves.gate]
between = [\"chamber\", \"fore\"]
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
fn a_valid_file_is_accepted() {
    assert_eq!(said(GOOD), "nothing");
    assert_eq!(with("open = [\"gate\"]\nfault = [{ device = 5, name = \"sensor2\" }]"), "nothing");
}

#[test]
fn the_error_for_an_invalid_value_names_its_position() {
    for (from, to, sentence) in [
        ("1 min", "1 minute", "x.toml:2:9: expected a time like \"90 s\" in ms, s, min, h, d, got \"1 minute\""),
        ("10 l\"", "0 l\"", "x.toml:4:34: expected a volume above zero, got \"0 l\""),
        (
            "\"chamber\", \"fore\"",
            "\"chamber\", \"camber\"",
            "x.toml:6:23: expected a volume, got \"camber\"; known: chamber, fore; did you mean \"chamber\"?",
        ),
        (
            "\"chamber\", \"fore\"",
            "\"chamber\", \"chamber\"",
            "x.toml:6:23: expected another volume than \"chamber\", got it twice",
        ),
        ("bpg400@5", "bpg401@5", "x.toml:9:1: unknown device \"bpg401\"; known: pcg550"),
        ("= \"chamber\"\n", "= \"room\"\n", "x.toml:9:14: expected a volume, got \"room\"; known: chamber, fore"),
        ("conductance = \"10 l/s\"", "diameter = \"1 cm\"", "x.toml:5:1: expected diameter and length, or conductance"),
        (
            "volume = \"10 l\"",
            "volum = \"10 l\"",
            "x.toml:4:25: unknown field `volum`, expected one of `volume`, `gas`, `pressure`; did you mean `volume`?",
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
fn an_impossible_event_is_an_error_before_the_start() {
    for (entry, sentence) in [
        (
            "open = [\"gaet\"]",
            "x.toml:12:9: expected a valve, tube, leak or vent, got \"gaet\"; known: gate; did you mean \"gate\"?",
        ),
        ("start = [\"gate\"]", "x.toml:12:10: expected a pump, got \"gate\"; there is none"),
        ("fault = [{ device = 6, name = \"ram\" }]", "x.toml:12:21: expected the address of a gauge, got 6; known: 5"),
        (
            "fault = [{ device = 5, name = \"sensor3\" }]",
            "x.toml:12:31: expected a fault or control of bpg400, got \"sensor3\"; it has eeprom, ram",
        ),
        (
            "button = [{ device = 5, number = 1 }]",
            "x.toml:12:34: expected a fault or control of bpg400, got \"1\"; it has nothing",
        ),
        ("heat = [{ wall = \"w\", to = \"hot\" }]", "x.toml:12:28: expected a temperature like"),
        (
            "expect = [{ device = 5, near = \"1 mbar\", below = \"2 mbar\" }]",
            "x.toml:12:11: expected near, or above and below",
        ),
        (
            "expect = [{ volume = \"chamber\", valid = true }]",
            "x.toml:12:11: expected only above, below or near for a volume",
        ),
        ("expect = [{ device = 5 }]", "x.toml:12:11: expected a check"),
        (
            "expect = [{ device = 5, below = \"low\" }]",
            "x.toml:12:33: expected a pressure like '1e-3 mbar', got \"low\"",
        ),
        ("opne = [\"gate\"]", "x.toml:12:1: unknown field `opne`"),
        (
            "atmosphere = { humidity = \"120 %\" }",
            "x.toml:12:27: expected a percentage from 0 % to 100 %, got \"120 %\"",
        ),
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

/// Quantities beyond any real plant would overflow calculations or need unlimited time.
#[test]
fn quantities_beyond_all_plants_are_refused() {
    for (from, to, sentence) in [
        ("\"10 l\"", "\"1e-300 l\"", "x.toml:4:34: expected a volume from 1 mm3 to 1e6 m3, got \"1e-300 l\""),
        ("\"10 l\"", "\"1e300 l\"", "x.toml:4:34: expected a volume from 1 mm3 to 1e6 m3, got \"1e300 l\""),
        ("\"10 l/s\"", "\"1e30 l/s\"", "x.toml:7:15: expected a pumping speed from 1e-15 l/s to 1e6 m3/s"),
        ("\"1 min\"", "\"1e300 d\"", "x.toml:2:9: expected a time from 1 ms to 36500 d, got \"1e300 d\""),
        ("\"1 min\"", "\"1 min\"\nstep = \"1e-9 s\"", "x.toml:3:8: expected a time from 1 ms to 36500 d"),
        ("\"1 min\"", "\"1 min\"\nstep = \"2 h\"", "x.toml:3:8: expected a step of at most 1 h, got \"2 h\""),
        ("\"10 l\"", "\"10 l\", pressure = \"1e9 bar\"", "x.toml:4:53: expected a pressure up to 10 bar"),
    ] {
        let found = changed(from, to);
        assert!(found.starts_with(sentence), "{found}\ninstead of\n{sentence}");
    }
    for volts in ["nan", "inf", "-1e300"] {
        let found = with(&format!("pot = [{{ device = 5, which = \"a\", volts = {volts} }}]"));
        assert!(found.starts_with("x.toml:12:43: expected volts from -24 to 24, got "), "{found}");
    }
    let turbo = "[turbo-pumps]\nt = { inlet = \"chamber\", fore = \"fore\", speed = \"1 l/s\", compression = nan }\n";
    let found = said(&format!("{GOOD}{turbo}"));
    assert!(found.starts_with("x.toml:11:72: expected a compression from 1 to 1e15, got NaN"), "{found}");
    let many: String = (0..65).map(|number| format!("v{number} = {{ volume = \"1 l\" }}\n")).collect();
    let found = said(&format!("title = \"t\"\nuntil = \"1 s\"\n[volumes]\n{many}"));
    assert!(found.contains("expected at most 64 volumes"), "{found}");
}

#[test]
fn a_file_without_an_end_is_an_error() {
    let error = Scenario::read(std::path::Path::new("/dev/zero")).unwrap_err().to_string();
    assert_eq!(error, "/dev/zero: expected a text of at most 262144 octets, got more");
}

/// Numbers, texts and signs that a file may contain by accident.
const ODD: [&str; 22] = [
    "",
    "0",
    "-1",
    "1e999",
    "nan",
    "-inf",
    "9999999999999999999",
    "\"",
    "\"\"\"",
    "[",
    "[[",
    "{",
    "}",
    "]",
    "=",
    "\n",
    "#",
    "\\u0000",
    "\u{FFFD}",
    "\"chamber\"",
    "\"it's \\\"quoted\\\"\"",
    "'",
];

/// Replaces a few places of every shipped file with odd text: the file is accepted or rejected with a position, and nothing
/// panics. An accepted file also runs.
#[test]
fn damaged_files_are_rejected_with_a_position_or_run() {
    let folder = super::file("demo").parent().unwrap().to_owned();
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(files.len() >= 9, "{files:?}");
    let mut rng = fastrand::Rng::with_seed(9);
    let (mut told, mut run) = (0, 0);
    for file in files.iter().cycle().take(600) {
        let mut text = std::fs::read_to_string(file).unwrap();
        for _ in 0..rng.usize(1..4) {
            damage(&mut text, &mut rng);
        }
        match Scenario::parse(&text, "x.toml") {
            Err(error) => {
                let place = error.to_string();
                let place = place.strip_prefix("x.toml:").and_then(|rest| rest.split_once(": ")).unwrap();
                let (line, column) = place.0.split_once(':').unwrap();
                assert!(line.parse::<usize>().unwrap() <= text.lines().count() + 1, "{error}");
                assert!(column.parse::<usize>().unwrap() >= 1 && !place.1.is_empty(), "{error}");
                told += 1;
            }
            Ok(scenario) => {
                let mut devices = super::devices(&scenario);
                let mut going = scenario.start(MasterPresence::Absent);
                (0..20).for_each(|_| going.step(&mut devices));
                assert!(going.pressures().all(|(_, pa)| pa.is_finite() && pa >= 0.0), "{text}");
                run += 1;
            }
        }
    }
    assert!(told > 200 && run > 20, "{told} told, {run} run");
}

/// Replaces a word or a sign with odd text, or drops or doubles a line.
fn damage(text: &mut String, rng: &mut fastrand::Rng) {
    let bounds: Vec<usize> = text.char_indices().map(|(at, _)| at).collect();
    let at = bounds[rng.usize(..bounds.len())];
    let is_word = |c: char| c.is_alphanumeric() || "._-".contains(c);
    let end =
        |from: usize, stop: &dyn Fn(char) -> bool| text[from..].find(stop).map_or(text.len(), |length| from + length);
    match rng.u8(..4) {
        0 => {
            let end = end(at, &|c| !is_word(c));
            text.replace_range(at..end, rng.choice(ODD).unwrap_or_default());
        }
        1 => text.insert_str(at, rng.choice(ODD).unwrap_or_default()),
        2 => {
            let end = end(at, &|c| c == '\n');
            text.replace_range(at..end, "");
        }
        _ => {
            let end = end(at, &|c| c == '\n');
            let twice = text[at..end].to_owned();
            text.insert_str(end, &twice);
        }
    }
}
