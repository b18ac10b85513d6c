//! Arrows point to lower ranks only.
//!
//! The ranks are in the tables of `ARCHITECTURE.md`: a row begins with a rank and the names of crates (`dp`) or of modules
//! at the root of a crate (`dp::link`); `devices::*` covers the modules of `devices` without a row. The arrows between
//! crates are the dependencies of a build according to `cargo metadata`; the arrows between modules are the paths in the
//! source. Tests may use anything, because no tests are shipped. Below the root modules have no ranks, but no module may use
//! another one in a circle ([`circles`]).

use crate::circles;
use crate::modules::Modules;
use crate::{root, verdict};
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
        Self(architecture.lines().flat_map(row).collect())
    }

    fn of(&self, name: &str) -> Option<u8> {
        self.0.get(name).copied()
    }

    /// The rank of a module of a crate, by its own row or that of `*`.
    fn of_module(&self, krate: &str, module: &str) -> Option<u8> {
        self.of(&format!("{krate}::{module}")).or_else(|| self.of(&format!("{krate}::*")))
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

/// `| 1 | `dp::slave`, `dp::master` | ...` gives both names with the rank 1.
fn row(line: &str) -> Vec<(String, u8)> {
    let mut cells = line.strip_prefix('|').unwrap_or_default().split('|').map(str::trim);
    let rank = cells.next().and_then(|cell| cell.parse().ok());
    let (Some(rank), Some(names)) = (rank, cells.next()) else { return Vec::new() };
    let name = |cell: &str| Some((cell.trim().strip_prefix('`')?.strip_suffix('`')?.to_owned(), rank));
    names.split(',').filter_map(name).collect()
}

/// Checks the arrows between crates, then those between the modules of each crate.
pub fn check() -> Result<()> {
    let ranks = Ranks::parse(&std::fs::read_to_string(root().join("ARCHITECTURE.md")).context("ARCHITECTURE.md")?);
    let metadata = MetadataCommand::new().no_deps().current_dir(root()).exec()?;
    let mut defects = between_crates(&metadata, &ranks);
    for package in metadata.workspace_packages() {
        let modules = Modules::read(package.manifest_path.with_file_name("src").as_std_path())?;
        let name = short(package);
        if package.name.starts_with(PREFIX) {
            defects.extend(between_modules(&ranks, name, &modules));
        }
        defects.extend(circles::find(&modules).iter().map(|circle| format!("{name}: {circle}")));
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

/// The complaints about the modules at the root of a crate: each has a rank and uses lower ones only.
fn between_modules(ranks: &Ranks, krate: &str, modules: &Modules) -> Vec<String> {
    let unranked = modules.children(&[]).into_iter().filter(|module| ranks.of_module(krate, module).is_none());
    let mut defects: Vec<String> =
        unranked.map(|name| format!("{krate}::{name} has no row in ARCHITECTURE.md")).collect();
    for arrow in modules.arrows() {
        let (Some(from), Some(to)) = (arrow.from.first(), arrow.to.first()) else { continue };
        let ranked = [from, to].into_iter().all(|module| ranks.of_module(krate, module).is_some());
        if ranked
            && from != to
            && let Some(complaint) = ranks.complaint(Some(krate), from, to)
        {
            let file = arrow.file.strip_prefix(root()).unwrap_or(&arrow.file);
            defects.push(format!("{krate}: {complaint} in {}", file.display()));
        }
    }
    defects
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modules::tests::made_up;

    const TABLE: &str = "
| Rank | Crate | Holds |
|---|---|---|
| 0 | `wire` | octets |
| 1 | `dp` | stations |
| 0 | `dp::link`, `dp::ident` | time |
| 1 | `dp::*` | the rest |
";

    #[test]
    fn rows_give_ranks_and_other_lines_do_not() {
        let ranks = Ranks::parse(TABLE);
        assert_eq!(ranks.of("wire"), Some(0));
        assert_eq!(ranks.of("dp"), Some(1));
        assert_eq!(ranks.of_module("dp", "link"), Some(0));
        assert_eq!(ranks.of_module("dp", "ident"), Some(0));
        assert_eq!(ranks.of_module("dp", "slave"), Some(1));
        assert_eq!(ranks.of("Crate"), None);
    }

    #[test]
    fn every_root_module_needs_a_rank_and_uses_lower_ones_only() {
        let ranks = Ranks::parse("| 0 | `dp::link` | |\n| 1 | `dp::slave`, `dp::master` | |");
        let sources = [
            ("link", "use crate::master::X;"),
            ("slave", "use crate::link::Y; mod inner { use crate::master::Z; }"),
            ("master", ""),
            ("orphan", ""),
        ];
        let defects = between_modules(&ranks, "dp", &made_up(&sources));
        assert_eq!(defects.len(), 3);
        assert_eq!(defects[0], "dp::orphan has no row in ARCHITECTURE.md");
        assert!(defects[1].starts_with("dp: link (rank 0) uses master (rank 1)"), "{}", defects[1]);
        assert!(defects[2].starts_with("dp: slave (rank 1) uses master (rank 1)"), "{}", defects[2]);
    }

    #[test]
    fn an_arrow_up_or_sideways_is_a_complaint() {
        let ranks = Ranks::parse(TABLE);
        assert_eq!(ranks.complaint(None, "dp", "wire"), None);
        assert_eq!(ranks.complaint(None, "wire", "dp").as_deref(), Some("wire (rank 0) uses dp (rank 1)"));
        assert_eq!(ranks.complaint(Some("dp"), "slave", "link"), None);
        assert!(ranks.complaint(Some("dp"), "link", "slave").is_some());
        assert!(ranks.complaint(Some("dp"), "slave", "master").is_some());
        assert!(ranks.complaint(None, "dp", "other").is_some_and(|text| text.contains("no row")));
    }
}
