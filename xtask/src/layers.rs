//! Arrows point to lower ranks only.
//!
//! The ranks stand in the tables of `ARCHITECTURE.md` and nowhere else: a row begins with a rank and the name of a crate
//! (`dp`) or of a module (`dp::link`); `devices::*` stands for the modules of `devices` that have no row. Between crates
//! the arrows are what `cargo metadata` says a build needs; inside a crate they are the paths its source mentions. What
//! only tests need may come from anywhere: it is in nothing that is shipped.

use crate::{modules, root, verdict};
use anyhow::{Context, Result};
use cargo_metadata::{DependencyKind, Metadata, MetadataCommand, Package};
use std::collections::BTreeMap;

/// The names of the crates begin with this, those in the tables do not.
const PREFIX: &str = "profivac-";

/// Rank by name of a crate or module.
#[derive(Debug, PartialEq, Eq)]
pub struct Ranks(BTreeMap<String, u8>);

impl Ranks {
    /// Reads the tables.
    fn parse(architecture: &str) -> Self {
        Self(architecture.lines().filter_map(row).collect())
    }

    fn of(&self, name: &str) -> Option<u8> {
        self.0.get(name).copied()
    }

    /// The rank of a module of a crate, by its own row or that of `*`.
    fn of_module(&self, krate: &str, module: &str) -> Option<u8> {
        self.of(&format!("{krate}::{module}")).or_else(|| self.of(&format!("{krate}::*")))
    }

    /// Whether the modules of a crate have ranks.
    fn has_modules(&self, krate: &str) -> bool {
        let prefix = format!("{krate}::");
        self.0.keys().any(|name| name.starts_with(&prefix))
    }

    /// Whether `from` may use `to`; both have ranks.
    fn complaint(&self, krate: Option<&str>, from: &str, to: &str) -> Option<String> {
        let rank = |name| match krate {
            Some(krate) => self.of_module(krate, name),
            None => self.of(name),
        };
        match (rank(from), rank(to)) {
            (Some(above), Some(below)) if above > below => None,
            (Some(above), Some(below)) => Some(format!("{from} (rank {above}) uses {to} (rank {below})")),
            (None, _) => Some(format!("{from} has no row in ARCHITECTURE.md")),
            (_, None) => Some(format!("{to} has no row in ARCHITECTURE.md")),
        }
    }
}

/// `| 1 | `dp` | ...` gives `("dp", 1)`.
fn row(line: &str) -> Option<(String, u8)> {
    let mut cells = line.strip_prefix('|')?.split('|').map(str::trim);
    let rank = cells.next()?.parse().ok()?;
    let name = cells.next()?.strip_prefix('`')?.strip_suffix('`')?;
    Some((name.to_owned(), rank))
}

/// Checks crates, then the modules of those crates that have ranks inside.
pub fn check() -> Result<()> {
    let ranks = Ranks::parse(&std::fs::read_to_string(root().join("ARCHITECTURE.md")).context("ARCHITECTURE.md")?);
    let metadata = MetadataCommand::new().no_deps().current_dir(root()).exec()?;
    let mut defects = between_crates(&metadata, &ranks);
    for package in metadata.workspace_packages() {
        let name = short(package);
        if ranks.has_modules(name) {
            let source = package.manifest_path.with_file_name("src");
            let uses = modules::uses(source.as_std_path())?;
            defects.extend(uses.iter().filter_map(|arrow| inside_crate(&ranks, name, arrow)));
        }
    }
    verdict("layers", &defects)
}

/// The name of a package in the tables.
fn short(package: &Package) -> &str {
    package.name.strip_prefix(PREFIX).unwrap_or(&package.name)
}

fn between_crates(metadata: &Metadata, ranks: &Ranks) -> Vec<String> {
    let mut defects = Vec::new();
    for package in metadata.workspace_packages().into_iter().filter(|package| package.name.starts_with(PREFIX)) {
        let name = short(package);
        if ranks.of(name).is_none() {
            defects.push(format!("{name} has no row in ARCHITECTURE.md"));
        }
        let built = package.dependencies.iter().filter(|dependency| dependency.kind != DependencyKind::Development);
        let ours = built.filter_map(|dependency| dependency.name.strip_prefix(PREFIX));
        defects.extend(ours.filter_map(|lower| ranks.complaint(None, name, lower)));
    }
    defects
}

fn inside_crate(ranks: &Ranks, krate: &str, arrow: &modules::Arrow) -> Option<String> {
    let file = arrow.file.strip_prefix(root()).unwrap_or(&arrow.file);
    let complaint = ranks.complaint(Some(krate), &arrow.from, &arrow.to)?;
    Some(format!("{krate}: {complaint} in {}", file.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "
| Rank | Crate | Holds |
|---|---|---|
| 0 | `wire` | octets |
| 1 | `dp` | stations |
| 0 | `dp::link` | time |
| 1 | `dp::*` | the rest |
";

    #[test]
    fn rows_give_ranks_and_other_lines_do_not() {
        let ranks = Ranks::parse(TABLE);
        assert_eq!(ranks.of("wire"), Some(0));
        assert_eq!(ranks.of("dp"), Some(1));
        assert_eq!(ranks.of_module("dp", "link"), Some(0));
        assert_eq!(ranks.of_module("dp", "slave"), Some(1));
        assert_eq!(ranks.of("Crate"), None);
        assert!(ranks.has_modules("dp") && !ranks.has_modules("wire"));
    }

    #[test]
    fn an_arrow_up_or_sideways_is_a_complaint() {
        let ranks = Ranks::parse(TABLE);
        assert_eq!(ranks.complaint(None, "dp", "wire"), None);
        assert_eq!(ranks.complaint(None, "wire", "dp").as_deref(), Some("wire (rank 0) uses dp (rank 1)"));
        assert_eq!(ranks.complaint(Some("dp"), "slave", "link"), None);
        assert!(ranks.complaint(Some("dp"), "link", "slave").is_some());
        assert!(ranks.complaint(Some("dp"), "slave", "master").is_some());
        assert!(ranks.complaint(None, "dp", "nobody").is_some_and(|text| text.contains("no row")));
    }
}
