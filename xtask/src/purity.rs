//! The inner crates are `no_std` without `alloc`, all the way down.
//!
//! `ci/purity` is a static library outside the workspace that has a panic handler, no allocator, and all inner crates
//! below it. With `std` anywhere in that tree there are two panic handlers, with `alloc` an allocator is missing; the
//! compiler refuses both. The features `std` and `alloc` of that library do the wrong thing on purpose: the check fails
//! as well when they are not refused.

use crate::{root, verdict};
use anyhow::{Context, Result};
use std::process::Command;

/// A feature of `ci/purity`, and what the compiler says to it.
const WRONG: [(&str, &str); 2] = [("std", "panic_impl"), ("alloc", "no global memory allocator")];

/// Builds the library as it is, and in the two ways that must fail.
pub fn check() -> Result<()> {
    let mut defects = Vec::new();
    let (built, said) = build(&[])?;
    if !built {
        defects.push(format!("the inner crates need std or alloc\n{said}"));
    }
    for (feature, expected) in WRONG {
        let (built, said) = build(&["--features", feature])?;
        if built || !said.contains(expected) {
            defects.push(format!("{feature} is not noticed, so this check proves nothing\n{said}"));
        }
    }
    verdict("purity", &defects)
}

/// Whether it builds, and what the compiler said.
fn build(options: &[&str]) -> Result<(bool, String)> {
    let output = Command::new(env!("CARGO"))
        .args(["build", "--quiet", "--manifest-path", "ci/purity/Cargo.toml", "--target-dir", "target/purity"])
        .args(options)
        .current_dir(root())
        .output()
        .context("cargo build")?;
    Ok((output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned()))
}
