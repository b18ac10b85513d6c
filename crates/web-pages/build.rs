//! Builds the dashboard with Node, so that the program can embed it.
//!
//! The build runs in a copy of the sources below the build folder, so that the source tree stays unchanged. Without Node, or
//! without access to the packages, the program is built with a page that says so; a test of this crate detects that page.

use std::fs;
use std::io::{Error, Result};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The sources of the dashboard.
const SOURCES: [&str; 7] =
    ["index.html", "archive.html", "package.json", "package-lock.json", "tsconfig.json", "vite.config.ts", "src"];

/// Compresses the built files. Node has brotli and gzip.
const COMPRESS: &str = "compress.mjs";

fn main() -> Result<()> {
    let web = PathBuf::from(variable("CARGO_MANIFEST_DIR")?).join("../station/web");
    let copy = PathBuf::from(variable("OUT_DIR")?).join("web");
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed={COMPRESS}");
    for source in SOURCES {
        println!("cargo::rerun-if-changed={}", web.join(source).display());
    }
    let unchanged = fs::read(web.join("package-lock.json")).ok() == fs::read(copy.join("package-lock.json")).ok();
    fs::create_dir_all(&copy)?;
    let _gone = fs::remove_dir_all(copy.join("src"));
    for source in SOURCES {
        duplicate(&web.join(source), &copy.join(source))?;
    }
    let installed = unchanged && copy.join("node_modules").is_dir();
    if let Err(error) = build(&copy, installed) {
        println!("cargo::warning=the dashboard was not built: {}", error.to_string().replace('\n', " "));
        // This file does not exist, so the next build tries again.
        println!("cargo::rerun-if-changed={}", web.join("no-node").display());
        println!("cargo::warning=it needs Node 18 or newer, on Debian the packages nodejs and npm");
        // Files of an earlier build would be answered in place of the page below.
        let _gone = fs::remove_dir_all(copy.join("dist"));
        fs::create_dir_all(copy.join("dist"))?;
        fs::write(copy.join("dist/index.html"), MISSING)?;
    }
    Ok(())
}

/// The page of a program that was built without Node.
const MISSING: &str = "<!doctype html><title>profivac</title><p>This program was built without its dashboard, because Node \
    18 or newer was missing or could not fetch its packages (on Debian: the packages nodejs and npm). Build it again with \
    Node. The API is at <a href=\"/api/openapi.json\">/api/openapi.json</a>.";

fn build(folder: &Path, installed: bool) -> Result<()> {
    if !installed {
        npm(folder, &["ci", "--no-audit", "--no-fund"])?;
    }
    npm(folder, &["run", "build"])?;
    let script = Path::new(&variable("CARGO_MANIFEST_DIR")?).join(COMPRESS);
    succeeds("node", Command::new("node").arg(script).arg(folder.join("dist")))
}

fn variable(name: &str) -> Result<String> {
    std::env::var(name).map_err(|error| Error::other(format!("{name}: {error}")))
}

fn duplicate(from: &Path, to: &Path) -> Result<()> {
    if !from.is_dir() {
        return fs::copy(from, to).map(drop);
    }
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        duplicate(&entry.path(), &to.join(entry.file_name()))?;
    }
    Ok(())
}

fn npm(folder: &Path, arguments: &[&str]) -> Result<()> {
    let mut command = Command::new("npm");
    if !cfg!(feature = "parquet") {
        // The page does not offer what the station refuses.
        command.env("VITE_WITHOUT_PARQUET", "1");
    }
    succeeds(&format!("npm {}", arguments.join(" ")), command.args(arguments).current_dir(folder))
}

fn succeeds(name: &str, command: &mut Command) -> Result<()> {
    let output = command.output().map_err(|error| Error::other(format!("{name} cannot be started: {error}")))?;
    if output.status.success() {
        return Ok(());
    }
    let output = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    Err(Error::other(format!("{name}:\n{output}")))
}
