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
        ("1 min", "1 minute", "x.toml:2:9: until: expected a time like \"90 s\" in ms, s, min, h, d, got \"1 minute\""),
        ("10 l\"", "0 l\"", "x.toml:4:34: volume: expected a volume above zero, got \"0 l\""),
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
        ("until = \"1 min\"\n", "until = 5\n", "x.toml:2:9: until: invalid type: integer `5`, expected a string"),
        ("title = \"test\"", "title = ", "x.toml:1:9: title: "),
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
        (
            "fault = [{ device = 6, name = \"ram\" }]",
            "x.toml:12:21: device: expected the address of a gauge, got 6; known: 5 (bpg400)",
        ),
        (
            "fault = [{ device = 5, name = \"sensor3\" }]",
            "x.toml:12:31: name: bpg400 at address 5 has no fault \"sensor3\"; it has eeprom (EEPROM exception",
        ),
        ("button = [{ device = 5, number = 1 }]", "x.toml:12:34: number: bpg400 at address 5 has no button"),
        ("heat = [{ wall = \"w\", to = \"hot\" }]", "x.toml:12:28: to: expected a temperature like"),
        (
            "expect = [{ device = 5, near = \"1 mbar\", below = \"2 mbar\" }]",
            "x.toml:12:11: expected near, or above and below",
        ),
        (
            "expect = [{ volume = \"chamber\", valid = true }]",
            "x.toml:12:11: expected only above, below or near for a volume",
        ),
        (
            "expect = [{ device = 5, state = \"EXECUTNG\" }]",
            "x.toml:12:33: state: expected a device state, got \"EXECUTNG\"; known: none, OFF, INIT, SELFTESTING, IDLE, \
             SELFTESTEXCEPTION, EXECUTING, ABORT, CRITICALFAULT; did you mean \"EXECUTING\"?",
        ),
        ("expect = [{ device = 5 }]", "x.toml:12:11: expected a check"),
        (
            "expect = [{ device = 5, below = \"low\" }]",
            "x.toml:12:33: below: expected a pressure like '1e-3 mbar', got \"low\"",
        ),
        ("opne = [\"gate\"]", "x.toml:12:1: unknown field `opne`"),
        (
            "atmosphere = { humidity = \"120 %\" }",
            "x.toml:12:27: humidity: expected a percentage from 0 % to 100 %, got \"120 %\"",
        ),
    ] {
        let found = with(entry);
        assert!(found.starts_with(sentence), "{found}\ninstead of\n{sentence}");
    }
    let late = said(&format!("{GOOD}[[timeline]]\nat = \"2 min\"\n"));
    assert_eq!(late, "x.toml:11:6: at: expected a time before the end of the scenario, got \"2 min\"");
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
        ("\"10 l\"", "\"1e-300 l\"", "x.toml:4:34: volume: expected a volume from 1 mm3 to 1e6 m3, got \"1e-300 l\""),
        ("\"10 l\"", "\"1e300 l\"", "x.toml:4:34: volume: expected a volume from 1 mm3 to 1e6 m3, got \"1e300 l\""),
        ("\"10 l/s\"", "\"1e30 l/s\"", "x.toml:7:15: conductance: expected a pumping speed from 1e-15 l/s to 1e6 m3/s"),
        ("\"1 min\"", "\"1e300 d\"", "x.toml:2:9: until: expected a time from 1 ms to 36500 d, got \"1e300 d\""),
        ("\"1 min\"", "\"1 min\"\nstep = \"1e-9 s\"", "x.toml:3:8: step: expected a time from 1 ms to 36500 d"),
        ("\"1 min\"", "\"1 min\"\nstep = \"2 h\"", "x.toml:3:8: step: expected a step of at most 1 h, got \"2 h\""),
        (
            "\"10 l\"",
            "\"10 l\", pressure = \"1e9 bar\"",
            "x.toml:4:53: pressure: expected a pressure from 1e-15 mbar to 10 bar",
        ),
    ] {
        let found = changed(from, to);
        assert!(found.starts_with(sentence), "{found}\ninstead of\n{sentence}");
    }
    for volts in ["nan", "inf", "-1e300"] {
        let found = with(&format!("pot = [{{ device = 5, which = \"a\", volts = {volts} }}]"));
        assert!(found.starts_with("x.toml:12:43: volts: expected volts from -24 to 24, got "), "{found}");
    }
    let turbo = "[turbo-pumps]\nt = { inlet = \"chamber\", fore = \"fore\", speed = \"1 l/s\", compression = nan }\n";
    let found = said(&format!("{GOOD}{turbo}"));
    assert!(found.starts_with("x.toml:11:72: compression: expected a compression from 1 to 1e15, got NaN"), "{found}");
    let many: String = (0..65).map(|number| format!("v{number} = {{ volume = \"1 l\" }}\n")).collect();
    let found = said(&format!("title = \"t\"\nuntil = \"1 s\"\n[volumes]\n{many}"));
    assert!(found.contains("expected at most 64 volumes"), "{found}");
}

/// Without gas outside, a volume of air has no composition, and every value was NaN.
#[test]
fn a_pressure_that_no_gas_has_is_refused_with_key_and_position() {
    let top = |table: &str| changed("until = \"1 min\"\n", &format!("until = \"1 min\"\n{table}\n"));
    for pressure in ["0 mbar", "0 Pa", "1e-16 mbar", "11 bar", "1e300 mbar"] {
        let sentence = format!("expected a pressure from 1e-15 mbar to 10 bar, got \"{pressure}\"");
        for (found, position) in [
            (top(&format!("atmosphere = {{ pressure = \"{pressure}\" }}")), "x.toml:3:27: pressure"),
            (changed("\"10 l\"", &format!("\"10 l\", pressure = \"{pressure}\"")), "x.toml:4:53: pressure"),
            (with(&format!("atmosphere = {{ pressure = \"{pressure}\" }}")), "x.toml:12:27: pressure"),
            (
                said(&format!(
                    "{GOOD}[roughing-pumps]\np = {{ at = \"fore\", speed = \"1 l/s\", ultimate = \"{pressure}\" }}\n"
                )),
                "x.toml:11:48: ultimate",
            ),
        ] {
            assert_eq!(found, format!("{position}: {sentence}"));
        }
    }
    for pressure in ["-1 mbar", "nan mbar", "inf mbar", "-inf Pa"] {
        let found = top(&format!("atmosphere = {{ pressure = \"{pressure}\" }}"));
        let sentence = format!("x.toml:3:27: pressure: expected a pressure like '1e-3 mbar', got \"{pressure}\"");
        assert_eq!(found, sentence);
    }
    assert_eq!(top("atmosphere = { pressure = \"1e-15 mbar\", humidity = \"100 %\" }"), "nothing");
}

/// Every other number of a file, with zero, a negative number, infinity, no number, and more than any plant has.
#[test]
fn every_quantity_of_a_file_is_bounded() {
    let plant = "\
[walls]
w = { in = \"chamber\", material = \"steel\", area = \"AREA\", aged = \"AGED\", aged_at = \"AGED_AT\" }
[tubes]
t = { between = [\"chamber\", \"fore\"], diameter = \"DIAMETER\", length = \"LENGTH\" }
[pockets]
p = { in = \"chamber\", volume = \"POCKET\", conductance = \"CONDUCTANCE\" }
[roughing-pumps]
r = { at = \"fore\", speed = \"SPEED\", ultimate = \"1e-2 mbar\" }
[turbo-pumps]
u = { inlet = \"chamber\", fore = \"fore\", speed = \"TURBO\", compression = COMPRESSION, critical-pressure = \"CRITICAL\", \
spin-up = \"SPIN_UP\" }
[leaks]
l = { at = \"chamber\", rate = \"RATE\" }
[inlets]
i = { at = \"chamber\", gas = \"ar\" }
[[timeline]]
at = \"1 s\"
flow = [{ inlet = \"i\", flow = \"FLOW\" }, { inlet = \"i\", pressure = \"REGULATED\" }]
heat = [{ wall = \"w\", to = \"HEAT\" }]
";
    // Key, a valid number, its unit, whether zero is valid.
    let keys = [
        ("AREA", "1", " m2", false),
        ("AGED", "1", " h", true),
        ("AGED_AT", "20", " C", true),
        ("DIAMETER", "1", " cm", false),
        ("LENGTH", "1", " cm", false),
        ("POCKET", "1", " ml", false),
        ("CONDUCTANCE", "1e-9", " l/s", false),
        ("SPEED", "1", " l/s", false),
        ("TURBO", "1", " l/s", false),
        ("COMPRESSION", "1e6", "", false),
        ("CRITICAL", "1", " mbar", false),
        ("SPIN_UP", "1", " s", false),
        ("RATE", "1", " sccm", true),
        ("FLOW", "1", " sccm", true),
        ("REGULATED", "1", " mbar", true),
        ("HEAT", "20", " C", true),
    ];
    let filled = |wrong: &str, number: &str| {
        // The longest names first, because some contain another.
        let mut sorted = keys;
        sorted.sort_by_key(|(key, ..)| std::cmp::Reverse(key.len()));
        sorted.iter().fold(format!("{GOOD}{plant}"), |text, (key, valid, unit, _)| {
            text.replace(key, &format!("{}{unit}", if *key == wrong { number } else { valid }))
        })
    };
    assert_eq!(said(&filled("", "")), "nothing");
    for (key, _, _, zero_is_valid) in keys {
        for number in ["-1000", "nan", "inf", "-inf", "1e30", "1e308"] {
            let found = said(&filled(key, number));
            assert!(found.starts_with("x.toml:") && found.contains(": expected "), "{key} = {number}: {found}");
        }
        assert_eq!(said(&filled(key, "0")) == "nothing", zero_is_valid, "{key} = 0");
    }
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

/// Replaces a few keys of every shipped file with odd text: the file is accepted or rejected with a position, and nothing
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
                let key = error.to_string();
                let key = key.strip_prefix("x.toml:").and_then(|rest| rest.split_once(": ")).unwrap();
                let (line, column) = key.0.split_once(':').unwrap();
                assert!(line.parse::<usize>().unwrap() <= text.lines().count() + 1, "{error}");
                assert!(column.parse::<usize>().unwrap() >= 1 && !key.1.is_empty(), "{error}");
                told += 1;
            }
            Ok(scenario) => {
                let mut devices = super::devices(&scenario);
                let mut going = scenario.start(MasterPresence::Absent);
                (0..20).for_each(|_| going.step(&mut devices));
                assert!(going.pressures().all(|(_, pa)| pa.is_finite() && pa > 0.0), "{text}");
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
