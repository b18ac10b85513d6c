//! The modules of configuration octets that a slave returned.

use crate::slave::{GsdSlave, SlaveError};
use profivac_gsd::{Fit, FitError, FittedSlot, GsdFile};
use std::ops::Range;
use std::sync::Arc;
use thiserror::Error;

/// The modules of a file that give configuration octets, see [`GsdSlave::by_chk_cfg`].
#[derive(Clone, Debug)]
pub struct FoundModules {
    /// The slave with the first possible module in each slot and the file's default parameters.
    pub slave: GsdSlave,
    /// The slots with all modules that have their octets.
    pub slots: Vec<FoundSlot>,
    /// Whether the octets can also be divided into modules with other octets.
    pub is_divided_otherwise: bool,
    /// Whether a module without identifiers may be plugged besides: the octets do not show it.
    pub may_hide_module: bool,
}

/// A slot and its possible modules.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoundSlot {
    /// The number of the slot.
    pub slot: u32,
    /// Number and name of each module with these configuration octets that the slot takes; the first one is the most likely.
    pub modules: Vec<(u32, String)>,
    /// Whether all of them have the same parameters, so that the first stands for each.
    pub has_equal_parameters: bool,
    /// Its octets within Chk_Cfg.
    pub range: Range<usize>,
}

/// Why configuration octets give no slave of a file.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum FoundError {
    /// No modules of the file give these octets.
    #[error("{0}")]
    Fit(#[from] FitError),
    /// The modules break a rule of the file.
    #[error("{0}")]
    Slave(#[from] SlaveError),
}

impl FoundModules {
    /// Whether one module is possible in each slot, no other division, and no module without identifiers besides.
    #[must_use]
    pub fn is_unique(&self) -> bool {
        !self.is_divided_otherwise && !self.may_hide_module && self.slots.iter().all(|slot| slot.modules.len() == 1)
    }
}

impl FoundSlot {
    fn of(slot: &FittedSlot<'_>) -> Self {
        let modules = slot.modules.iter().map(|module| (module.number, module.name.clone())).collect();
        let mut definitions = slot.modules.iter().map(|module| (module.prm.definition(), module.safety.definition()));
        let first = definitions.next();
        let has_equal_parameters = definitions.all(|other| Some(other) == first);
        Self { slot: slot.slot, modules, has_equal_parameters, range: slot.config.clone() }
    }

    /// `slot 2 4DO`; several modules with the same octets are all named: `slot 2 4DO or 4DO HF`.
    #[must_use]
    pub fn label(&self) -> String {
        let names: Vec<_> = self.modules.iter().map(|(_, name)| name.as_str()).collect();
        format!("slot {} {}", self.slot, names.join(" or "))
    }
}

impl GsdSlave {
    /// The modules whose configuration octets are these, from Get_Cfg or Chk_Cfg, see [`Fit`]. Several modules can have the same
    /// octets; all are named.
    ///
    /// ```
    /// use profivac_gsd::GsdFile;
    /// use profivac_gsd_slave::GsdSlave;
    ///
    /// let file = GsdFile::read(b"#Profibus_DP
    /// Ident_Number = 0x1234
    /// Modular_Station = 1
    /// Max_Module = 4
    /// Module = \"4DO\" 0x20
    /// EndModule
    /// Module = \"4DO HF\" 0x20
    /// EndModule
    /// ");
    /// let found = GsdSlave::by_chk_cfg(&file.into(), &[0x20, 0x20])?;
    /// assert_eq!(found.slots[1].label(), "slot 2 4DO or 4DO HF");
    /// assert!(GsdSlave::by_chk_cfg(found.slave.file(), &[0x21]).is_err());
    /// # Ok::<(), profivac_gsd_slave::FoundError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`FoundError`] says which octets belong to no module, or which rule of the file the modules break.
    pub fn by_chk_cfg(file: &Arc<GsdFile>, octets: &[u8]) -> Result<FoundModules, FoundError> {
        let fit = Fit::new(file.device(), octets)?;
        let configuration = fit.configuration().map_err(SlaveError::from)?;
        Ok(FoundModules {
            slave: Self::of(file, &configuration)?,
            slots: fit.slots.iter().map(FoundSlot::of).collect(),
            is_divided_otherwise: fit.has_other_division,
            may_hide_module: fit.may_hide_module,
        })
    }
}
