//! Slaves of any vendor by their GSD files: the options that master commands share, and the choice of file, modules and parameters.

use crate::failure::Failure;
use crate::gauge::{choose, is_interactive};
use crate::output::{notice, visible};
use clap::Args;
use profivac_client::values::hex;
use profivac_dp::link::Baud;
use profivac_gsd_slave::{
    Catalog, CatalogError, Change, ChoiceError, Entry, FoundModules, GsdSlave, Modules, Selection, SelectionError,
    SlaveError, Unread,
};
use profivac_host::text_file;
use std::path::{Path, PathBuf};

/// The files that describe slaves.
#[derive(Args, Clone, Debug, Default)]
pub struct GsdOptions {
    /// GSD files that describe slaves of any vendor, and folders of them: names that end in .gsd, .gse, .gsg ...
    #[arg(long = "gsd", value_name = "FILE|FOLDER")]
    paths: Vec<PathBuf>,
}

impl GsdOptions {
    /// Whether there are any.
    pub fn is_given(&self) -> bool {
        !self.paths.is_empty()
    }

    /// Reads the files. A file of a folder that describes no DP slave is a notice.
    pub fn read(&self) -> Result<Catalog, Failure> {
        let catalog = Catalog::read(&self.paths)?;
        left_out(catalog.unread()).iter().for_each(|line| notice(&visible(line)));
        Ok(catalog)
    }
}

/// The most files that are named when they are left out. chosen: a folder can have thousands.
const MOST_LEFT_OUT: usize = 20;

/// A line for each file that is left out; those beyond the first twenty are counted.
fn left_out(unread: &[Unread]) -> Vec<String> {
    let line = |one: &Unread| format!("{} is left out: {}", one.path.display(), one.reason);
    let more = unread.len().saturating_sub(MOST_LEFT_OUT);
    let rest =
        (more > 0).then(|| format!("{more} more files are left out; `profivac gsd check FOLDER --all` shows why"));
    unread.iter().take(MOST_LEFT_OUT).map(line).chain(rest).collect()
}

/// Reads `--modules`: module numbers in slot order, or a TOML file with modules and parameters.
pub fn selection(text: &str) -> Result<Selection, Failure> {
    if !text.to_ascii_lowercase().ends_with(".toml") {
        return Ok(Selection { modules: text.parse()?, changes: Vec::new() });
    }
    let read = text_file::read(Path::new(text));
    let content = read.map_err(|error| Failure::usage(format!("{text} cannot be read: {error}; check the path")))?;
    Selection::from_toml(&content).map_err(|error| Failure::usage(format!("{text}: {error}")))
}

/// A slave on the bus, for which the file and the modules are wanted.
pub struct Wanted<'a> {
    pub address: u8,
    pub ident: u16,
    /// The answer to Get_Cfg.
    pub get_cfg: Option<&'a [u8]>,
    /// `--modules`.
    pub selection: Option<&'a Selection>,
    /// `--set`.
    pub changes: &'a [Change],
}

/// The most devices among which the user is asked to choose on a terminal. chosen: a screen.
const MOST_CHOICES: usize = 20;

impl Wanted<'_> {
    /// Describes the slave by its GSD file. The modules are those of the command line; without them those that the slave reports with
    /// Get_Cfg; without an answer those that the file presets. If several devices fit, the user is asked on a terminal: close the session
    /// first, its master would hold the token during the question.
    pub fn find(&self, catalog: &Catalog) -> Result<GsdSlave, Failure> {
        let address = self.address;
        let at_address = |text: String| Failure::usage(format!("slave at address {address}: {text}"));
        let entry = self.entry(catalog)?;
        let in_file = |error: String| at_address(format!("{}: {error}", entry.path.display()));
        let slave = match (self.selection, self.get_cfg) {
            (Some(selection), _) => {
                let changes = selection.changes.iter().chain(self.changes).cloned().collect();
                let selection = Selection { modules: selection.modules.clone(), changes };
                GsdSlave::new(entry.file.clone(), &selection).map_err(|error| in_file(error.to_string()))?
            }
            (None, Some(octets)) => {
                let found = GsdSlave::by_chk_cfg(&entry.file, octets).map_err(|error| {
                    in_file(format!(
                        "no modules for the configuration {} of the slave: {error}; choose them with --modules",
                        hex(octets)
                    ))
                })?;
                check_unique(&found).map_err(in_file)?;
                found.slave.changed(self.changes).map_err(|error| in_file(error.to_string()))?
            }
            (None, None) => {
                let selection = Selection { modules: Modules::Preset, changes: self.changes.to_vec() };
                GsdSlave::new(entry.file.clone(), &selection).map_err(|error| {
                    in_file(format!("the slave does not answer Get_Cfg: {error}; choose modules with --modules"))
                })?
            }
        };
        for warning in slave.warnings() {
            notice(&format_args!("slave at address {address}: {warning}"));
        }
        Ok(slave)
    }

    /// The file of the slave.
    fn entry<'c>(&self, catalog: &'c Catalog) -> Result<&'c Entry, Failure> {
        let Self { address, ident, .. } = self;
        let candidates = catalog.candidates(*ident, self.get_cfg);
        if !is_interactive() || !(2..=MOST_CHOICES).contains(&candidates.len()) {
            let chosen = catalog.choose(*ident, self.get_cfg);
            return chosen.map_err(|error| Failure::usage(format!("slave at address {address}: {error}")));
        }
        let question =
            format!("the slave at address {address} has the ident 0x{ident:04X} of several devices; compare its label");
        let names: Vec<_> =
            candidates.iter().map(|entry| format!("{} in {}", entry.name(), entry.path.display())).collect();
        let chosen = choose(&question, &names)?.and_then(|index| candidates.get(index).copied());
        let none = "no device was chosen; name the right file with --gsd";
        chosen.ok_or_else(|| Failure::usage(none))
    }
}

/// A sentence about chosen modules that differ from the plugged ones, which the slave lists in `present`, its answer to Get_Cfg.
pub fn modules_remark(slave: &GsdSlave, address: u8, present: Option<&[u8]>) -> Option<String> {
    let present = present.filter(|present| *present != slave.chk_cfg())?;
    Some(format!(
        "the slave at address {address} has the configuration {}, the chosen modules need {}",
        hex(present),
        hex(slave.chk_cfg())
    ))
}

/// A sentence about a rate that the file does not have.
pub fn rate_remark(slave: &GsdSlave, baud: Baud) -> Option<String> {
    slave.device().check_rate(baud.bits_per_second()).err().map(|error| error.to_string())
}

/// Modules with equal octets are told apart by the user, unless their parameters are equal too.
fn check_unique(found: &FoundModules) -> Result<(), String> {
    if found.is_divided_otherwise {
        let all = found.slots.iter().map(|slot| slot.label()).collect::<Vec<_>>().join(", ");
        return Err(format!("the configuration may be {all}, or other modules; choose them with --modules"));
    }
    let unclear = found.slots.iter().find(|slot| !slot.has_equal_parameters);
    let Some(slot) = unclear else { return Ok(()) };
    let numbers: Vec<_> = slot.modules.iter().map(|(number, name)| format!("{number} ({name})")).collect();
    Err(format!(
        "modules with the same configuration octets in slot {}, and with different parameters: {}; choose with --modules",
        slot.slot,
        numbers.join(", ")
    ))
}

macro_rules! wrong_usage {
    ($($error:ty),*) => {
        $(impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Failure::usage(error.to_string())
            }
        })*
    };
}

wrong_usage!(CatalogError, ChoiceError, SelectionError, SlaveError);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_files_that_are_left_out_twenty_are_named() {
        let unread = |count: usize| {
            let one = |number: usize| Unread {
                path: PathBuf::from(format!("{number}.gsd")),
                reason: "no Ident_Number".to_owned(),
            };
            (0..count).map(one).collect::<Vec<_>>()
        };
        assert_eq!(left_out(&unread(20)).len(), 20);
        let lines = left_out(&unread(25));
        assert_eq!(lines.first().map(String::as_str), Some("0.gsd is left out: no Ident_Number"));
        assert_eq!(lines.len(), 21);
        assert_eq!(lines[20], "5 more files are left out; `profivac gsd check FOLDER --all` shows why");
    }
}
