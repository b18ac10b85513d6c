//! The corpora of the targets and their finds, without libFuzzer: nothing panics any more.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};

/// A target: its name, and what takes the octets.
type Target = (&'static str, fn(&[u8]));

const TARGETS: [Target; 26] = [
    ("api", fuzz::api::run),
    ("batch", fuzz::batch::run),
    ("capture", fuzz::files::capture),
    ("channel_access", fuzz::gateways::channel_access),
    ("decode_file", fuzz::decode::file),
    ("decode_line", fuzz::decode::line),
    ("decode_text", fuzz::decode::known_kind),
    ("device_file", fuzz::files::device_file),
    ("device_spec", fuzz::files::device_spec),
    ("gsd", fuzz::gsd::run),
    ("master", fuzz::master::run),
    ("modbus", fuzz::gateways::modbus),
    ("opcua", fuzz::opcua::run),
    ("plant", fuzz::plant::run),
    ("prometheus", fuzz::prometheus::run),
    ("pv_access", fuzz::gateways::pv_access),
    ("receiver", fuzz::receiver::run),
    ("ring", fuzz::ring::run),
    ("scenario", fuzz::files::scenario),
    ("segment", fuzz::files::segment),
    ("server", fuzz::api::server),
    ("settings", fuzz::files::settings),
    ("slave", fuzz::slave::run),
    ("sparkplug", fuzz::gateways::sparkplug),
    ("trace", fuzz::files::trace),
    ("users", fuzz::plant::users),
];

fn folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The inputs of a corpus: each behind its number of octets in 32 bits.
fn inputs(packed: &[u8]) -> Vec<&[u8]> {
    let (mut inputs, mut rest) = (Vec::new(), packed);
    while let Some((length, behind)) = rest.split_first_chunk() {
        let (input, behind) = behind.split_at(u32::from_le_bytes(*length) as usize);
        inputs.push(input);
        rest = behind;
    }
    assert!(rest.is_empty(), "a corpus ends with a whole input");
    inputs
}

/// The names of the files in a folder, without their ends.
fn names(folder: PathBuf) -> BTreeSet<String> {
    let files = fs::read_dir(folder).unwrap();
    files.map(|file| file.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned()).collect()
}

fn replay(name: &str, run: fn(&[u8]), inputs: &[&[u8]]) {
    for (number, input) in inputs.iter().enumerate() {
        if catch_unwind(|| run(input)).is_err() {
            panic!("{name}: input {number} fails: {input:02x?}");
        }
    }
}

#[test]
fn every_input_of_every_corpus_passes() {
    for (name, run) in TARGETS {
        let packed = fs::read(folder().join(format!("corpus/{name}.bin"))).unwrap();
        let inputs = inputs(&packed);
        assert!(!inputs.is_empty(), "{name} has no corpus");
        replay(name, run, &inputs);
        println!("{name}: {} inputs", inputs.len());
    }
}

#[test]
fn every_find_passes() {
    for (name, run) in TARGETS {
        let Ok(finds) = fs::read_dir(folder().join("finds").join(name)) else { continue };
        for find in finds {
            let find = find.unwrap().path();
            println!("{}", find.display());
            run(&fs::read(&find).unwrap());
        }
    }
}

#[test]
fn every_target_has_a_program_and_is_in_the_document() {
    let targets: BTreeSet<String> = TARGETS.iter().map(|(name, _)| (*name).to_owned()).collect();
    assert_eq!(names(folder().join("libfuzzer/src/bin")), targets);
    assert_eq!(names(folder().join("corpus")), targets);
    let document = fs::read_to_string(folder().join("../docs/fuzzing.md")).unwrap();
    let script = fs::read_to_string(folder().join("../ci/fuzz.py")).unwrap();
    for target in targets {
        assert!(document.contains(&format!("| `{target}` |")), "docs/fuzzing.md has no row for {target}");
        assert!(script.contains(&format!("\"{target}\": ")), "ci/fuzz.py does not know {target}");
    }
}

/// The entries `name` of a lock file, each with the names of its dependencies.
fn locked(lock: &str) -> BTreeMap<String, BTreeSet<String>> {
    let lock: toml::Table = lock.parse().unwrap();
    let packages = lock["package"].as_array().unwrap();
    let name = |text: &toml::Value| text.as_str().unwrap().split(' ').next().unwrap().to_owned();
    let dependencies = |package: &toml::Value| {
        package.get("dependencies").and_then(toml::Value::as_array).map(|all| all.iter().map(name).collect())
    };
    packages.iter().map(|package| (name(&package["name"]), dependencies(package).unwrap_or_default())).collect()
}

#[test]
fn the_lock_file_of_libfuzzer_has_the_dependencies_of_all_crates() {
    let lock = fs::read_to_string(folder().join("libfuzzer/Cargo.lock")).unwrap();
    for (package, dependencies) in locked(&lock) {
        let Some(place) = package.strip_prefix("profivac-").map(|name| format!("../crates/{name}")) else { continue };
        let manifest = fs::read_to_string(folder().join(place).join("Cargo.toml")).unwrap();
        let manifest: toml::Table = manifest.parse().unwrap();
        let is_always = |value: &toml::Value| value.get("optional").is_none_or(|it| it.as_bool() != Some(true));
        let wanted = manifest.get("dependencies").and_then(toml::Value::as_table).into_iter().flatten();
        for (name, _) in wanted.filter(|(_, value)| is_always(value)) {
            let next_step = "cargo metadata --format-version 1 --manifest-path fuzz/libfuzzer/Cargo.toml >/dev/null";
            assert!(
                dependencies.contains(name),
                "{package} needs {name}, fuzz/libfuzzer/Cargo.lock lacks it: {next_step}"
            );
        }
    }
}
