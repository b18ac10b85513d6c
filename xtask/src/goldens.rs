//! The one way to write goldens anew: every test that compares with a golden writes it instead when `PROFIVAC_BLESS` is 1.

use crate::root;
use anyhow::{Context, Result, ensure};
use std::process::Command;

/// Runs all tests so that they write, and shows which files changed.
pub fn bless() -> Result<()> {
    let tests = Command::new(env!("CARGO"))
        .args(["test", "--quiet", "--workspace"])
        .env("PROFIVAC_BLESS", "1")
        .current_dir(root())
        .status()
        .context("cargo test")?;
    ensure!(tests.success(), "some tests fail for other reasons than their goldens");
    println!("Changed now, to be read before they are committed:");
    Command::new("git").args(["status", "--short"]).current_dir(root()).status().context("git status")?;
    Ok(())
}
