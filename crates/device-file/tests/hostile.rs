//! Damaged files: an error or a device, and what follows from a device never panics.

use profivac_client::gsd::gsd;
use profivac_client::names::ParameterNames;
use profivac_client::st::{Dialect, st};
use profivac_device_file::{DeviceFile, MAX_MODELS, show};
use profivac_devices::catalog::MODELS;

/// Words that a file has at other places, and numbers at the ends.
const WORDS: [&str; 16] = [
    "0",
    "255",
    "256",
    "65535",
    "-1",
    "1e300",
    "nan",
    "\"\"",
    "\"RECORD(50)\"",
    "[]",
    "{}",
    "\"parameter-channel\"",
    "\"ttr-value\"",
    "\"units\"",
    "[1, 0]",
    "\"bcg450\"",
];

/// The text with one place changed: a line twice, away, or exchanged; a value; a character.
fn damaged(text: &str, random: &mut fastrand::Rng) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let at = random.usize(..lines.len());
    match random.u8(..5) {
        0 => {
            lines.remove(at);
        }
        1 => lines.insert(at, lines[random.usize(..lines.len())].clone()),
        2 => lines.swap(at, random.usize(..text.lines().count())),
        3 => {
            let line = &lines[at];
            let places: Vec<_> = line.match_indices(" = ").map(|(place, _)| place + 3).collect();
            if let Some(place) = random.choice(places) {
                let end = line[place..].find([',', ' ', '}']).map_or(line.len(), |end| place + end);
                lines[at] = format!("{}{}{}", &line[..place], random.choice(WORDS).unwrap(), &line[end..]);
            }
        }
        _ => {
            let line = &lines[at];
            let place =
                line.char_indices().map(|(place, _)| place).nth(random.usize(..=line.len())).unwrap_or(line.len());
            let character = random.choice(['"', '[', ']', '\u{0}', '\u{FEFF}', 'é', '{', '=', '9']).unwrap();
            lines[at].insert(place, character);
        }
    }
    lines.join("\n")
}

#[test]
fn no_damage_of_a_file_panics() {
    let seed = fastrand::u64(..);
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    let mut devices = 0;
    for round in 0..600 {
        let model = MODELS[round % MODELS.len()];
        let mut text = show(model).replacen(&format!("name = \"{}\"\n", model.name), "name = \"damaged\"\n", 1);
        for _ in 0..random.usize(1..4) {
            text = damaged(&text, &mut random);
        }
        let Ok(file) = DeviceFile::parse(&text) else { continue };
        if devices + 16 > MAX_MODELS {
            continue;
        }
        devices += 1;
        let model = file.model().unwrap();
        let _ = (gsd(model), st(model, Dialect::Tia), ParameterNames::of(model), show(model));
    }
    assert!(devices > 20, "{devices} of 600 damaged files were devices");
}

/// Depth and repetition that a parser may not follow without a limit.
#[test]
fn deep_and_long_texts_end_with_an_error() {
    let deep = |open: &str, close: &str| format!("format = 1\nx = {}{}", open.repeat(200_000), close.repeat(200_000));
    for text in [
        deep("[", "]"),
        deep("{a=", "}"),
        format!("{}format = 1\n", "[a.b.c.d]\n".repeat(50_000)),
        format!("format = 1\n{} = 1", "a.".repeat(200_000)),
        format!("format = 1\n{}", "[[block]]\nname = \"x\"\n".repeat(40_000)),
        format!(
            "format = 1\nname = \"x\"\ntitle = \"x\"\nlike = \"bcg450\"\n{}",
            (0..20_000).map(|block| format!("[[block]]\nname = \"{block}\"\nat = []\n")).collect::<String>()
        ),
    ] {
        assert!(DeviceFile::parse(&text).is_err());
    }
}
