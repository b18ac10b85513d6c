//! Writes the golden files again: each test that compares with a golden file writes it if `PROFIVAC_BLESS` is 1.

use crate::root;
use anyhow::{Context, Result, ensure};
use std::process::Command;

/// Runs all tests in this mode and lists the changed files.
pub fn bless() -> Result<()> {
    let tests = Command::new(env!("CARGO"))
        .args(["test", "--quiet", "--workspace"])
        .env("PROFIVAC_BLESS", "1")
        .current_dir(root())
        .status()
        .context("cargo test")?;
    ensure!(tests.success(), "some tests fail for other reasons than their golden files");
    println!("Changed files, to be reviewed before the commit:");
    Command::new("git").args(["status", "--short"]).current_dir(root()).status().context("git status")?;
    Ok(())
}
