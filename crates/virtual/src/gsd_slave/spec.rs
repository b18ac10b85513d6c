//! Slaves by their files, as a command line writes them: `FILE.gsd@9:modules=3+7`, `FILE.gsd@9:setup=FILE.toml`.

use super::GsdStation;
use super::plan::Plan;
use crate::device_spec::{SpecError, parse_address};
use crate::nonvolatile::{NonvolatileMemory, SetAside};
use profivac_dp::link::Baud;
use profivac_gsd_slave::{Catalog, CatalogError, GsdSlave, Modules, Selection, SelectionError, SlaveError};
use profivac_host::text_file;
use std::io;
use std::path::{Path, PathBuf};
use std::slice;
use std::str::FromStr;
use std::sync::Arc;

/// The form of a spec.
const FORM: &str = "FILE.gsd@ADDR, FILE.gsd@ADDR:modules=3+7 or FILE.gsd@ADDR:setup=FILE.toml";

/// A slave as the command line writes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GsdSpec {
    /// The GSD file.
    pub path: PathBuf,
    /// The address by which the user names the slave, 0 to 126.
    pub address: u8,
    modules: Choice,
}

/// Which modules are plugged.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Choice {
    /// Those that the file presets, or its only one.
    Preset,
    Modules(Modules),
    /// Those of a TOML file.
    Setup(PathBuf),
}

/// Why there is no slave.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GsdSpecError {
    /// The text does not have the form.
    #[error("expected {FORM}, got {0:?}")]
    Syntax(String),
    /// The address is none.
    #[error(transparent)]
    Address(#[from] SpecError),
    /// The modules are no numbers.
    #[error(transparent)]
    Modules(#[from] SelectionError),
    /// The GSD file cannot be read.
    #[error(transparent)]
    File(#[from] CatalogError),
    /// The TOML file of the modules cannot be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
    /// The TOML file of the modules is wrong.
    #[error("{}: {error}", path.display())]
    Setup {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        error: SelectionError,
    },
    /// The file and the modules make no slave.
    #[error("{}: {error}{}", path.display(), hint(.error))]
    Slave {
        /// The GSD file.
        path: PathBuf,
        /// What is wrong.
        error: Box<SlaveError>,
    },
    /// The slave does not run at the rate of the segment.
    #[error("{}: {sentence}", path.display())]
    Rate {
        /// The GSD file.
        path: PathBuf,
        /// The rates of the file.
        sentence: String,
    },
    /// The nonvolatile memory cannot be opened.
    #[error("{}: {source}", folder.display())]
    Memory {
        /// The folder.
        folder: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
}

/// How modules are chosen.
fn hint(error: &SlaveError) -> &'static str {
    match error {
        SlaveError::Selection(_) => "; write FILE.gsd@ADDR:modules=NUMBER+NUMBER, one number for each slot",
        _ => "",
    }
}

/// A slave, and a file of its memory that was put aside.
pub struct OpenedSlave {
    /// The slave, switched on.
    pub station: GsdStation,
    /// What the simulation leaves out, in sentences.
    pub warnings: Vec<String>,
    /// The name of the slave in the memory, and the file that was not used.
    pub set_aside: Option<(String, SetAside)>,
}

/// Whether a text names a GSD file: `.gsd`, or the ending of another language, at its end or before an `@`.
///
/// ```
/// use profivac_virtual::gsd_slave::is_gsd_file;
///
/// assert!(is_gsd_file("valves.GSE@9:modules=3"));
/// assert!(!is_gsd_file("bcg450@5"));
/// ```
#[must_use]
pub fn is_gsd_file(text: &str) -> bool {
    split(text).is_some()
}

/// The path, and the text behind it.
fn split(text: &str) -> Option<(&str, &str)> {
    let lower = text.to_ascii_lowercase();
    let dot = lower.match_indices(".gs").map(|(at, _)| at).find(|at| {
        let behind = at.saturating_add(3);
        let letter = lower.get(behind..).and_then(|rest| rest.chars().next());
        let end = lower.get(behind.saturating_add(1)..).unwrap_or("x");
        letter.is_some_and(|letter| letter.is_ascii_lowercase()) && (end.is_empty() || end.starts_with('@'))
    })?;
    text.split_at_checked(dot.saturating_add(4))
}

impl FromStr for GsdSpec {
    type Err = GsdSpecError;

    fn from_str(text: &str) -> Result<Self, GsdSpecError> {
        let form = || GsdSpecError::Syntax(text.to_owned());
        let (path, rest) = split(text).ok_or_else(form)?;
        let rest = rest.strip_prefix('@').ok_or_else(form)?;
        let (address, keys) = rest.split_once(':').map_or((rest, None), |(address, keys)| (address, Some(keys)));
        let address = parse_address(address)?;
        let modules = match keys.map(|keys| keys.split_once('=').ok_or_else(form)).transpose()? {
            None => Choice::Preset,
            Some(("modules", numbers)) => Choice::Modules(numbers.parse()?),
            Some(("setup", file)) if !file.is_empty() => Choice::Setup(file.into()),
            Some(_) => return Err(form()),
        };
        Ok(Self { path: path.into(), address, modules })
    }
}

impl GsdSpec {
    /// The same with its files relative to a folder.
    #[must_use]
    pub fn in_folder(mut self, folder: &Path) -> Self {
        self.path = folder.join(self.path);
        if let Choice::Setup(file) = &mut self.modules {
            *file = folder.join(&*file);
        }
        self
    }

    /// Reads the files and switches the slave on. Its records and its address are kept in `state`, or end with the process.
    ///
    /// # Errors
    /// [`GsdSpecError`] says which file, module or rate is wrong, and what is possible.
    pub fn open(&self, baud: Baud, state: Option<&Path>) -> Result<OpenedSlave, GsdSpecError> {
        let plan = self.plan()?;
        let rate = |sentence| GsdSpecError::Rate { path: self.path.clone(), sentence };
        plan.check_rate(baud).map_err(rate)?;
        let warnings = plan.slave.warnings().iter().map(ToString::to_string).collect();
        let (memory, set_aside) = match state {
            None => (NonvolatileMemory::volatile(), None),
            Some(folder) => {
                let name = format!("gsd-{:04x}", plan.slave.ident());
                let opened = NonvolatileMemory::open(folder, &name, self.address)
                    .map_err(|source| GsdSpecError::Memory { folder: folder.to_owned(), source })?;
                (opened.memory, opened.set_aside.map(|aside| (name, aside)))
            }
        };
        let station = GsdStation::new(plan, self.address, memory, baud);
        Ok(OpenedSlave { station, warnings, set_aside })
    }

    /// A slave of its own, to check the files and to try orders on.
    pub(crate) fn try_out(&self) -> Result<GsdStation, GsdSpecError> {
        Ok(GsdStation::new(self.plan()?, self.address, NonvolatileMemory::volatile(), Baud::B19200))
    }

    fn plan(&self) -> Result<Plan, GsdSpecError> {
        let catalog = Catalog::read(slice::from_ref(&self.path))?;
        let (_, entry) = catalog.entries().next().ok_or_else(|| CatalogError::Empty { path: self.path.clone() })?;
        let selection = match &self.modules {
            Choice::Preset => Selection::default(),
            Choice::Modules(modules) => Selection { modules: modules.clone(), ..Selection::default() },
            Choice::Setup(path) => {
                let text = text_file::read(path).map_err(|source| GsdSpecError::Read { path: path.clone(), source })?;
                Selection::from_toml(&text).map_err(|error| GsdSpecError::Setup { path: path.clone(), error })?
            }
        };
        let slave = GsdSlave::new(Arc::clone(&entry.file), &selection);
        slave
            .map(|slave| Plan::new(slave, entry.name()))
            .map_err(|error| GsdSpecError::Slave { path: self.path.clone(), error: Box::new(error) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spec_has_a_file_an_address_and_its_modules() {
        let spec = |text: &str| text.parse::<GsdSpec>().unwrap();
        let preset = spec("dir@2/a.b/valves.GSD@126");
        assert_eq!((preset.path.to_str(), preset.address), (Some("dir@2/a.b/valves.GSD"), 126));
        assert_eq!(preset.modules, Choice::Preset);
        assert_eq!(spec("a.gse@9:modules=3+7").modules, Choice::Modules("3+7".parse().unwrap()));
        let setup = spec("a.gsg@9:setup=b,c=d:e.toml").in_folder(Path::new("plant"));
        assert_eq!(setup.path, Path::new("plant/a.gsg"));
        assert_eq!(setup.modules, Choice::Setup("plant/b,c=d:e.toml".into()));
    }

    #[test]
    fn a_wrong_spec_is_an_error_that_says_the_form() {
        for text in ["a.gsd", "a.gsd@9:", "a.gsd@9:serial=1", "a.gsd@9:setup=", "a.gsd@9:modules"] {
            let sentence = text.parse::<GsdSpec>().unwrap_err().to_string();
            assert_eq!(sentence, format!("expected {FORM}, got {text:?}"));
        }
        let sentence = |text: &str| text.parse::<GsdSpec>().unwrap_err().to_string();
        assert_eq!(sentence("a.gsd@127"), "expected an address from 0 to 126, got \"127\"");
        assert_eq!(
            sentence("a.gsd@9:modules=valve"),
            "expected module numbers of the file in slot order like 3+7, got \"valve\""
        );
    }

    #[test]
    fn other_texts_name_no_gsd_file() {
        for text in ["bcg450@5", "gsd@5", "a.gsdx@9", "a.gs@9", "", ".gs", "ä.gs"] {
            assert!(!is_gsd_file(text), "{text}");
        }
    }
}
