//! `profivac identify`: a known plant from a CSV file, its table, JSON and picture, and errors with their exit codes.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test")]

use serde_json::Value;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// 50 l, 20 l/s; leak 2e-7, outgassing 2e-6 Pa m³/s after an hour.
const VOLUME: f64 = 0.05;
const SPEED: f64 = 0.02;
const LEAK: f64 = 2e-7;
const OUTGASSING: f64 = 2e-6;

fn gas(t: f64) -> f64 {
    LEAK + OUTGASSING * 3600.0 / (t + 5.0)
}

/// Two hours of pumping from 100 Pa and twenty minutes with a closed valve, as `monitor --csv` writes it.
fn csv() -> String {
    csv_with(|_| 0.0)
}

/// The same with a change of the indication, in Pa.
fn csv_with(change: impl Fn(f64) -> f64) -> String {
    let mut text = String::from(
        "unix_time,address,device,pressure,unit,mbar,instance,state,remarks,exchanges,lost,quality,limit_mbar,inputs\n",
    );
    let mut random = fastrand::Rng::with_seed(4);
    let (mut pa, closed) = (100.0, 7_200.0);
    for second in 0..8_400 {
        let t = f64::from(second);
        let noise: f64 = (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
        let mbar = (pa + change(t)) * (1.0 + 0.01 * noise) / 100.0;
        writeln!(text, "{:.3},5,pcg550,{mbar:e},mbar,{mbar:e},1,DATA,\"\",1,0,valid,,", 1_795_262_400.0 + t).unwrap();
        for part in 0..100 {
            let now = t + f64::from(part) / 100.0;
            let pumped = if now < closed { SPEED * pa } else { 0.0 };
            pa += (gas(now) - pumped) / VOLUME / 100.0;
        }
    }
    text
}

fn written(folder: &Path) -> PathBuf {
    let path = folder.join("pressures.csv");
    std::fs::write(&path, csv()).unwrap();
    path
}

fn identify(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_profivac")).arg("identify").args(arguments).output().unwrap()
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

#[test]
fn a_known_plant_is_identified_from_a_csv_file() {
    let folder = tempfile::tempdir().unwrap();
    let (file, picture) = (written(folder.path()), folder.path().join("fit.svg"));
    let (file, picture) = (file.to_str().unwrap(), picture.to_str().unwrap());
    let output = identify(&[file, "--volume", "50 l", "--json", "--target", "5e-8 mbar", "--plot", picture]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    for (name, truth) in
        [("leak_pa_m3_per_s", LEAK), ("outgassing_1h_pa_m3_per_s", OUTGASSING), ("outgassing_exponent", 1.0)]
    {
        let [low, high] = ["low", "high"].map(|key| found[name][key].as_f64().unwrap());
        assert!(low <= truth && truth <= high, "{name}: {low:e} to {high:e}");
    }
    // After another day the leak makes three quarters of the pressure.
    assert_eq!(found["remedies"][0]["remedy"], "close the leak", "{}", found["remedies"]);
    assert!(found["misfit"].as_f64().unwrap() < 1.2, "{}", found["misfit"]);
    let closed = found["closed_s"].as_f64().unwrap();
    assert!((closed - 7_200.0).abs() < 0.5, "{closed}");
    assert!(
        found["targets"][0]["s"].is_null(),
        "the leak alone gives 1e-7 mbar, so 5e-8 is not reached: {}",
        found["targets"]
    );
    let svg = std::fs::read_to_string(picture).unwrap();
    assert!(svg.starts_with("<svg") && svg.contains("predicted") && svg.matches("<circle").count() > 200);
    assert_eq!(found["sprays"], serde_json::json!([]), "nothing was sprayed");
    let table = stdout(&identify(&[file, "--volume", "50 l", "--accuracy", "15"]));
    for word in ["leak", "speed at", "exponent of outgassing", "what would help most", "±15 %"] {
        assert!(table.contains(word), "{word}: {table}");
    }
}

/// An ion gauge while helium replaces the air of the leak for a minute: 2.69 times as much helium, a 5.9th as sensitive.
#[test]
fn helium_at_a_leak_is_recognised_in_words() {
    let tau_s = VOLUME / SPEED;
    let filled = |s: f64| 1.0 - (-s.max(0.0) / tau_s).exp();
    let left = |t: f64| filled(t.min(6_060.0) - 6_000.0) * (-(t - 6_060.0).max(0.0) / tau_s).exp();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("sprayed.csv");
    std::fs::write(&file, csv_with(|t| LEAK / SPEED * (2.69 / 5.9 - 1.0) * left(t))).unwrap();
    let output = identify(&[file.to_str().unwrap(), "--volume", "50 l", "--gauge-kind", "ion", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let sprays = found["sprays"].as_array().unwrap();
    assert_eq!(sprays.len(), 1, "{sprays:?}");
    let leak = &sprays[0]["leak_pa_m3_per_s"];
    let [low, high] = ["low", "high"].map(|key| leak[key].as_f64().unwrap());
    assert!(low <= LEAK && LEAK <= high, "{low:e} to {high:e}");
    let text = sprays[0]["text"].as_str().unwrap();
    for words in ["the indication falls by", "as with helium sprayed on a leak", "The leak is"] {
        assert!(text.contains(words), "{words}: {text}");
    }
}

#[test]
fn wrong_input_is_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let file = written(folder.path());
    let file = file.to_str().unwrap();
    let empty = folder.path().join("empty.csv");
    std::fs::write(&empty, "").unwrap();
    for (arguments, reason) in [
        (vec![file], "--volume"),
        (vec![file, "--volume", "50 l", "--gauge", "6"], "has no gauge \"6\""),
        (vec![file, "--volume", "50 l", "--accuracy", "150"], "expected an accuracy from 0 to 100 percent, found 150"),
        (vec![empty.to_str().unwrap(), "--volume", "50 l"], "expected a heading, found an empty file"),
        (
            vec![file, "--volume", "50 l", "--closed", "08:00", "--opened", "08:30"],
            "expected samples while the valve is closed, found none; in --closed and --opened, a time without a date is one of today",
        ),
        (vec!["absent.csv", "--volume", "50 l"], "absent.csv cannot be read"),
        (vec!["absent.toml", "--volume", "50 l"], "absent.toml"),
    ] {
        let output = identify(&arguments);
        let text = String::from_utf8(output.stderr.clone()).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {text}");
        assert!(text.contains(reason), "{arguments:?}: {text}");
    }
}

/// A file of as many samples, a second apart.
fn file_of(folder: &Path, name: &str, count: u32, mbar: impl Fn(u32) -> String) -> String {
    let mut text = String::from("unix_time,address,mbar,quality\n");
    for second in 0..count {
        writeln!(text, "{}.000,5,{},valid", 1_795_262_400 + second, mbar(second)).unwrap();
    }
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn a_fit_that_takes_longer_than_it_may_ends_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let file = written(folder.path());
    let output = identify(&[file.to_str().unwrap(), "--volume", "50 l", "--longest", "0.001"]);
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(output.stdout.is_empty());
    for part in ["expected a fit within 0.001 s, found none for", "--from and --to", "--longest"] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn a_record_that_is_no_pump_down_ends_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let falling = |second: u32| 1e3 * 0.98_f64.powi(second.cast_signed()) + 1e-6;
    let constant = file_of(folder, "constant.csv", 500, |_| "1e-3".to_owned());
    let rising = file_of(folder, "rising.csv", 500, |second| format!("{:e}", falling(500 - second)));
    let nan = file_of(folder, "nan.csv", 500, |second| if second == 7 { "NaN".to_owned() } else { "1".to_owned() });
    let few = file_of(folder, "few.csv", 20, |second| format!("{:e}", falling(60 * second)));
    let impossible =
        file_of(folder, "impossible.csv", 500, |second| if second < 50 { "1e300" } else { "1e-300" }.to_owned());
    for (file, reason) in [
        (constant, "expected a pump-down, found no fall by two decades; choose its start with --from"),
        (rising, "expected a pump-down, found no fall by two decades; choose its start with --from"),
        (nan, "nan.csv:9: expected a pressure above 0, found \"NaN\""),
        (few, "expected at least 30 samples, got 20"),
        (impossible, "expected rising times and pressures from 1e-15 to 1e9 Pa"),
    ] {
        let output = identify(&[&file, "--volume", "50 l"]);
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{file}: {text}");
        assert!(text.contains(reason), "{file}: {text}");
    }
}

/// Without a rise, and with a pump-down of a minute, hardly a number is determined, and each says so.
#[test]
fn a_record_that_determines_little_says_so_for_each_number() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = fastrand::Rng::with_seed(8);
    let noise: Vec<f64> = (0..60).map(|_| 1.0 + 0.02 * (random.f64() - 0.5)).collect();
    let file = file_of(folder.path(), "short.csv", 60, |second| {
        let pa = 100.0 * 0.8_f64.powi(second.cast_signed()) + 1e-2;
        format!("{:e}", pa * noise[second as usize])
    });
    let output = identify(&[&file, "--volume", "50 l", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let notes: Vec<&str> = found["notes"].as_array().unwrap().iter().map(|note| note.as_str().unwrap()).collect();
    for name in
        ["The leak cannot be", "The outgassing cannot be", "The exponent cannot be", "The ultimate pressure cannot be"]
    {
        assert!(notes.iter().any(|note| note.starts_with(name)), "{name}: {notes:?}");
    }
}
