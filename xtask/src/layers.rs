//! Checks that crates use lower ranks only, and that no modules use each other in a circle.
//!
//! The ranks are in the table of `ARCHITECTURE.md`: a row begins with a rank and the name of a crate (`dp`). The arrows between
//! crates are the dependencies of a build according to `cargo metadata`. Tests may use anything, because no tests are shipped.

use crate::circles;
use crate::modules::Modules;
use crate::{root, verdict};
use anyhow::{Context, Result};
use cargo_metadata::{DependencyKind, Metadata, MetadataCommand, Package};
use std::collections::BTreeMap;

/// The prefix of the names of the crates; the table omits it.
const PREFIX: &str = "profivac-";

/// Rank by name of a crate.
struct Ranks(BTreeMap<String, u8>);

impl Ranks {
    /// Reads the table.
    fn parse(architecture: &str) -> Self {
        Self(architecture.lines().filter_map(row).collect())
    }

    /// The defect, if `from` may not use `to`. A crate without a row is a defect of its own.
    fn complaint(&self, from: &str, to: &str) -> Option<String> {
        let (above, below) = (self.0.get(from)?, self.0.get(to)?);
        (above <= below).then(|| format!("{from} (rank {above}) uses {to} (rank {below})"))
    }
}

/// `| 1 | `dp` | ...` gives the name and the rank 1.
fn row(line: &str) -> Option<(String, u8)> {
    let mut cells = line.strip_prefix('|')?.split('|').map(str::trim);
    let rank = cells.next()?.parse().ok()?;
    Some((cells.next()?.strip_prefix('`')?.strip_suffix('`')?.to_owned(), rank))
}

/// Checks the arrows between crates, then the modules of each crate.
pub fn check() -> Result<()> {
    let ranks = Ranks::parse(&std::fs::read_to_string(root().join("ARCHITECTURE.md")).context("ARCHITECTURE.md")?);
    let metadata = MetadataCommand::new().no_deps().current_dir(root()).exec()?;
    let mut defects = between_crates(&metadata, &ranks);
    for package in metadata.workspace_packages() {
        let modules = Modules::read(package.manifest_path.with_file_name("src").as_std_path())?;
        defects.extend(circles::find(&modules).iter().map(|circle| format!("{}: {circle}", short(package))));
    }
    verdict("layers", &defects)
}

/// The name of a package in the table.
fn short(package: &Package) -> &str {
    package.name.strip_prefix(PREFIX).unwrap_or(&package.name)
}

fn between_crates(metadata: &Metadata, ranks: &Ranks) -> Vec<String> {
    let ours = || metadata.workspace_packages().into_iter().filter(|package| package.name.starts_with(PREFIX));
    let mut defects: Vec<String> = Vec::new();
    for package in ours() {
        let name = short(package);
        if !ranks.0.contains_key(name) {
            defects.push(format!("{name} has no row in ARCHITECTURE.md"));
        }
        let built = package.dependencies.iter().filter(|dependency| dependency.kind != DependencyKind::Development);
        let lower = built.filter_map(|dependency| dependency.name.strip_prefix(PREFIX));
        defects.extend(lower.filter_map(|lower| ranks.complaint(name, lower)));
    }
    let gone = ranks.0.keys().filter(|name| !ours().any(|package| short(package) == *name));
    defects.extend(gone.map(|name| format!("{name} has a row in ARCHITECTURE.md and does not exist")));
    defects
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "
| Rank | Crate | Holds |
|---|---|---|
| 0 | `wire` | octets |
| 1 | `dp` | stations |
| 1 | `sim` | a segment |
";

    #[test]
    fn rows_give_ranks_and_other_lines_do_not() {
        let ranks = Ranks::parse(TABLE).0;
        assert_eq!(ranks, [("dp".to_owned(), 1), ("sim".to_owned(), 1), ("wire".to_owned(), 0)].into());
    }

    #[test]
    fn an_arrow_up_or_sideways_is_a_complaint() {
        let ranks = Ranks::parse(TABLE);
        assert_eq!(ranks.complaint("dp", "wire"), None);
        assert_eq!(ranks.complaint("wire", "dp").as_deref(), Some("wire (rank 0) uses dp (rank 1)"));
        assert_eq!(ranks.complaint("sim", "dp").as_deref(), Some("sim (rank 1) uses dp (rank 1)"));
    }

    #[test]
    fn every_crate_has_a_row_and_every_row_a_crate() {
        let metadata = MetadataCommand::new().no_deps().current_dir(root()).exec().unwrap();
        let defects = between_crates(&metadata, &Ranks::parse("| 0 | `wire` | |\n| 1 | `gone` | |"));
        assert!(defects.contains(&"dp has no row in ARCHITECTURE.md".to_owned()), "{defects:?}");
        assert!(defects.contains(&"gone has a row in ARCHITECTURE.md and does not exist".to_owned()), "{defects:?}");
        assert!(!defects.iter().any(|defect| defect.starts_with("wire")), "{defects:?}");
    }
}
