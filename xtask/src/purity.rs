//! Checks that the inner crates and all their dependencies are `no_std` and do not use `alloc`.
//!
//! `ci/purity` is a static library outside the workspace with a panic handler, without an allocator, that depends on all
//! inner crates. If any dependency uses `std` there are two panic handlers, and with `alloc` the allocator is missing; the
//! compiler rejects both. The features `std` and `alloc` of that library cause these errors on purpose, and the check
//! fails if the compiler accepts them.

use crate::{root, verdict};
use anyhow::{Context, Result};
use std::fs::read_to_string;
use std::process::Command;

/// A feature of `ci/purity` and the expected error of the compiler.
const WRONG: [(&str, &str); 2] = [("std", "panic_impl"), ("alloc", "no global memory allocator")];

/// Builds the library without features, and with each of the two features that must fail.
pub fn check() -> Result<()> {
    let mut defects = forgotten(&read_to_string(root().join("ARCHITECTURE.md"))?, &manifest()?);
    let (built, said) = build(&[])?;
    if !built {
        defects.push(format!("the inner crates need std or alloc\n{said}"));
    }
    for (feature, expected) in WRONG {
        let (built, said) = build(&["--features", feature])?;
        if built || !said.contains(expected) {
            defects.push(format!("{feature} compiles, so this check does not detect it\n{said}"));
        }
    }
    verdict("purity", &defects)
}

/// The crates that `ARCHITECTURE.md` calls `no_std` and that are missing in the library.
fn forgotten(architecture: &str, manifest: &str) -> Vec<String> {
    let inner = architecture.lines().filter_map(|line| {
        let mut cells = line.split('|').map(str::trim).skip(2);
        let name = cells.next()?.trim_matches('`');
        (cells.next()? == "yes").then_some(name)
    });
    let missing = inner.filter(|name| !manifest.contains(&format!("profivac-{name} =")));
    missing.map(|name| format!("{name} is not in ci/purity/Cargo.toml")).collect()
}

fn manifest() -> Result<String> {
    read_to_string(root().join("ci/purity/Cargo.toml")).context("ci/purity/Cargo.toml")
}

/// Whether the library builds, and the output of the compiler.
fn build(options: &[&str]) -> Result<(bool, String)> {
    let output = Command::new(env!("CARGO"))
        .args(["build", "--quiet", "--manifest-path", "ci/purity/Cargo.toml", "--target-dir", "target/purity"])
        .args(options)
        .current_dir(root())
        .output()
        .context("cargo build")?;
    Ok((output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crate_without_std_must_be_in_the_library() {
        let table =
            "| Rank | Crate | no_std | Holds |\n|---|---|---|---|\n| 0 | `wire` | yes | a |\n| 3 | `host` | | b |";
        assert!(forgotten(table, "profivac-wire = {}").is_empty());
        assert_eq!(forgotten(table, "profivac-dp = {}"), ["wire is not in ci/purity/Cargo.toml"]);
    }
}
