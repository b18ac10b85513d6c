//! Checks that crates and modules use lower ranks only.
//!
//! The ranks are in the tables of `ARCHITECTURE.md`: a row begins with a rank and the names of crates (`dp`) or of modules
//! at the root of a crate (`dp::link`); `devices::*` covers the modules of `devices` without a row. The arrows between
//! crates are the dependencies of a build according to `cargo metadata`; the arrows between modules are the paths in the
//! source. Tests may use anything, because no tests are shipped. Below the root modules have no ranks, but no module may use
//! another one in a circle ([`circles`]).

use crate::circles;
use crate::modules::{Arrow, Modules};
use crate::{root, verdict};
use anyhow::{Context, Result};
use cargo_metadata::{DependencyKind, Metadata, MetadataCommand, Package};
use std::collections::{BTreeMap, BTreeSet};

/// The prefix of the names of the crates; the tables omit it.
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

    /// The modules of a crate that have rows, `*` included.
    fn modules_of(&self, krate: &str) -> impl Iterator<Item = &str> {
        let inside = move |name: &'_ String| name.strip_prefix(krate).is_some_and(|rest| rest.starts_with("::"));
        let names = self.0.keys().filter(move |name| inside(name));
        names.filter_map(|name| name.split_once("::")).map(|(_, module)| module)
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

/// Prints a row for each module at the root of a crate that has none: the lowest rank that its arrows permit, and the first
/// line of its documentation.
pub fn suggest() -> Result<()> {
    let ranks = Ranks::parse(&std::fs::read_to_string(root().join("ARCHITECTURE.md")).context("ARCHITECTURE.md")?);
    let metadata = MetadataCommand::new().no_deps().current_dir(root()).exec()?;
    for package in metadata.workspace_packages().into_iter().filter(|package| package.name.starts_with(PREFIX)) {
        let modules = Modules::read(package.manifest_path.with_file_name("src").as_std_path())?;
        let (name, arrows) = (short(package), modules.arrows());
        for module in modules.children(&[]).into_iter().filter(|module| ranks.of_module(name, module).is_none()) {
            let rank = lowest(&arrows, module, &mut Vec::new());
            println!("| {rank} | `{name}::{module}` | {} |", modules.first_line(&[module.to_owned()]));
        }
    }
    Ok(())
}

/// One more than the highest rank of the root modules that `module` uses. A circle counts once.
fn lowest(arrows: &BTreeSet<Arrow>, module: &str, above: &mut Vec<String>) -> usize {
    above.push(module.to_owned());
    let from_here = arrows.iter().filter(|arrow| arrow.from.first().is_some_and(|from| from == module));
    let used: BTreeSet<&String> = from_here.filter_map(|arrow| arrow.to.first()).collect();
    let below = used.into_iter().filter(|to| !above.contains(to)).collect::<Vec<_>>();
    let highest = below.into_iter().map(|to| lowest(arrows, to, above).saturating_add(1)).max();
    above.pop();
    highest.unwrap_or_default()
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

/// The defects of the modules at the root of a crate: each needs a rank and may use lower ranks only, and each row needs a
/// module.
fn between_modules(ranks: &Ranks, krate: &str, modules: &Modules) -> Vec<String> {
    let stale = ranks.modules_of(krate).filter(|module| *module != "*" && !modules.children(&[]).contains(module));
    let stale = stale.map(|module| format!("{krate}::{module} has a row in ARCHITECTURE.md and does not exist"));
    let unranked = modules.children(&[]).into_iter().filter(|module| ranks.of_module(krate, module).is_none());
    let unranked = unranked.map(|name| format!("{krate}::{name} has no row in ARCHITECTURE.md"));
    let mut defects: Vec<String> = unranked.chain(stale).collect();
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
        let ranks = Ranks::parse("| 0 | `dp::link` | |\n| 1 | `dp::slave`, `dp::master`, `dp::gone` | |");
        let sources = [
            ("link", "use crate::master::X;"),
            ("slave", "use crate::link::Y; mod inner { use crate::master::Z; }"),
            ("master", ""),
            ("orphan", ""),
        ];
        let defects = between_modules(&ranks, "dp", &made_up(&sources));
        assert_eq!(defects.len(), 4);
        assert_eq!(defects[0], "dp::orphan has no row in ARCHITECTURE.md");
        assert_eq!(defects[1], "dp::gone has a row in ARCHITECTURE.md and does not exist");
        assert!(defects[2].starts_with("dp: link (rank 0) uses master (rank 1)"), "{}", defects[2]);
        assert!(defects[3].starts_with("dp: slave (rank 1) uses master (rank 1)"), "{}", defects[3]);
    }

    #[test]
    fn the_lowest_rank_is_above_all_that_is_used() {
        let sources = [("a", "use crate::b::X; use crate::c::Y;"), ("b", "use crate::c::Y;"), ("c", ""), ("d", "")];
        let arrows = made_up(&sources).arrows();
        let ranks = ["a", "b", "c", "d"].map(|module| lowest(&arrows, module, &mut Vec::new()));
        assert_eq!(ranks, [2, 1, 0, 0]);
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
