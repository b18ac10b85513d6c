//! The scenarios that are part of the program, by name.

use super::{Scenario, ScenarioError};
use profivac_client::suggestion::closest;
use std::path::Path;

/// A scenario that is part of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Included {
    /// Its name, which is that of its file without `.toml`.
    pub name: &'static str,
    /// The text of its file.
    pub text: &'static str,
}

/// Declares the included scenarios.
macro_rules! included {
    ($($name:literal),* $(,)?) => {
        /// All included scenarios, in the order of docs/scenarios.md.
        pub const INCLUDED: &[Included] = &[$(Included {
            name: $name,
            text: include_str!(concat!("../../../../scenarios/", $name, ".toml")),
        }),*];
    };
}

included![
    "demo",
    "pump-down",
    "leak",
    "vent",
    "argon",
    "degas",
    "filament",
    "bus",
    "load-lock",
    "beam-line",
    "coater",
    "cryostat",
    "bake-out",
    "helium-leak-test",
    "freeze-dryer",
    "furnace",
    "mass-spectrometer",
    "transfer-line",
    "storage-vessel",
    "electron-microscope",
];

impl Included {
    /// The scenario of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        INCLUDED.iter().find(|one| one.name == name)
    }

    /// The parsed scenario.
    ///
    /// # Errors
    /// [`ScenarioError::Invalid`], which the tests exclude.
    pub fn scenario(&self) -> Result<Scenario, ScenarioError> {
        Scenario::parse(self.text, &format!("scenarios/{}.toml", self.name))
    }
}

impl Scenario {
    /// The included scenario of this name, or the scenario of a file. A file with the name of an included scenario needs a path with a
    /// slash: `./demo`.
    ///
    /// # Errors
    /// [`ScenarioError::Unknown`] if a name without a dot or a slash is neither, else as [`Scenario::read`].
    pub fn of_file_or_name(given: &Path) -> Result<Self, ScenarioError> {
        let name = given.to_str().filter(|name| !name.contains(['.', '/', '\\']));
        if let Some(included) = name.and_then(Included::named) {
            return included.scenario();
        }
        let Some(name) = name.filter(|_| !given.exists()) else { return Self::read(given) };
        let unknown = || {
            let known = || INCLUDED.iter().map(|one| one.name);
            ScenarioError::Unknown {
                found: name.to_owned(),
                known: known().collect::<Vec<_>>().join(", "),
                suggestion: closest(name, known()).map(str::to_owned),
            }
        };
        Err(unknown())
    }
}
