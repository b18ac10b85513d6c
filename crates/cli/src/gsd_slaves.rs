//! Slaves of any vendor by their GSD files: the options that master commands share, and the choice of file, modules and parameters.

use crate::failure::Failure;
use crate::output::notice;
use clap::Args;
use profivac_client::values::hex;
use profivac_dp::link::Baud;
use profivac_gsd_slave::{
    Catalog, CatalogError, Change, ChoiceError, FoundModules, GsdSlave, Modules, Selection, SelectionError, SlaveError,
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
        for unread in catalog.unread() {
            notice(&format_args!("{} is left out: {}", unread.path.display(), unread.reason));
        }
        Ok(catalog)
    }
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

impl Wanted<'_> {
    /// The slave by its file: with the modules of the command line, else those of Get_Cfg, else those that the file presets.
    pub fn find(&self, catalog: &Catalog) -> Result<GsdSlave, Failure> {
        let Self { address, ident, .. } = self;
        let at_address = |text: String| Failure::usage(format!("slave at address {address}: {text}"));
        let entry = catalog.choose(*ident, self.get_cfg).map_err(|error| at_address(error.to_string()))?;
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
