//! A slave: its file, its modules and its octets.

use crate::layout::Layout;
use crate::selection::{Change, Selection, SelectionError};
use profivac_dp::link::Baud;
use profivac_dp::master::{SlaveParameters, watchdog_factors};
use profivac_gsd::{Chosen, Configuration, Device, GsdFile, PrmError, Warning};
use profivac_wire::cfg::{self, CfgError, Lengths};
use profivac_wire::prm::Dpv1Status1;
use std::sync::Arc;
use thiserror::Error;

/// A slave by its GSD file with chosen modules and parameters. It owns everything that it needs.
#[derive(Clone, Debug)]
pub struct GsdSlave {
    file: Arc<GsdFile>,
    chosen: Chosen,
    ident: u16,
    chk_cfg: Vec<u8>,
    user_prm: Vec<u8>,
    lengths: Lengths,
    layout: Layout,
}

/// Why a file and a selection make no slave.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SlaveError {
    /// The selection does not fit the file.
    #[error("{0}")]
    Selection(#[from] SelectionError),
    /// The file has no Ident_Number from 0 to 65535.
    #[error("the file has no Ident_Number from 0 to 0xFFFF, which Set_Prm carries; add it to the file")]
    NoIdent,
    /// The user parameters are too long.
    #[error("{0}")]
    UserPrm(#[from] PrmError),
    /// The configuration octets of the file are wrong.
    #[error("the file's configuration octets of these modules are wrong: {0}; see `profivac gsd check`")]
    Cfg(#[from] CfgError),
}

impl From<profivac_gsd::ConfigurationError> for SlaveError {
    fn from(error: profivac_gsd::ConfigurationError) -> Self {
        Self::Selection(error.into())
    }
}

impl GsdSlave {
    /// The slave of a file with the modules and parameters of a selection.
    ///
    /// # Errors
    ///
    /// [`SlaveError`] says which module, slot, parameter or keyword is wrong, and what is possible.
    pub fn new(file: Arc<GsdFile>, selection: &Selection) -> Result<Self, SlaveError> {
        let configuration = selection.configure(file.device())?;
        let parts = Parts::of(&configuration)?;
        Ok(parts.with(file))
    }

    /// The slave of a file with the modules of a configuration, which must be of this file's device.
    pub(crate) fn of(file: &Arc<GsdFile>, configuration: &Configuration<'_>) -> Result<Self, SlaveError> {
        Ok(Parts::of(configuration)?.with(Arc::clone(file)))
    }

    /// The same slave with changed parameters.
    ///
    /// # Errors
    ///
    /// [`SlaveError`] says which parameter, and what is possible.
    pub fn changed(&self, changes: &[Change]) -> Result<Self, SlaveError> {
        let mut configuration = self.configuration();
        for change in changes {
            change.apply(&mut configuration)?;
        }
        Self::of(&self.file, &configuration)
    }

    /// The file.
    #[must_use]
    pub fn file(&self) -> &Arc<GsdFile> {
        &self.file
    }

    /// The device of the file.
    #[must_use]
    pub fn device(&self) -> &Device {
        self.file.device()
    }

    /// Modules and parameters with their values.
    #[must_use]
    pub fn configuration(&self) -> Configuration<'_> {
        Configuration::again(self.file.device(), &self.chosen)
    }

    /// Ident_Number.
    #[must_use]
    pub fn ident(&self) -> u16 {
        self.ident
    }

    /// The octets of Chk_Cfg.
    #[must_use]
    pub fn chk_cfg(&self) -> &[u8] {
        &self.chk_cfg
    }

    /// The user parameters of Set_Prm, from octet 7 on. With DPV1_Slave they have at least the three octets of the DP-V1 status, which
    /// are the file's; a file that requires Fail_Safe has its bit set.
    #[must_use]
    pub fn user_prm(&self) -> &[u8] {
        &self.user_prm
    }

    /// Number of input and output octets.
    #[must_use]
    pub fn lengths(&self) -> Lengths {
        self.lengths
    }

    /// Which octet belongs to which module.
    #[must_use]
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// What the octets lack, for instance the parameters for PROFIsafe.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        self.configuration().warnings()
    }

    /// Whether the first three user parameters are the DP-V1 status.
    #[must_use]
    pub fn is_dpv1(&self) -> bool {
        is_dpv1(self.device())
    }

    /// Greatest length of the answer to Slave_Diag, 6 to 244 octets: Max_Diag_Data_Len. chosen: 244 without the keyword.
    #[must_use]
    pub fn max_diag_len(&self) -> u8 {
        let most = self.device().general.max_diag_data_len.unwrap_or(244).clamp(6, 244);
        u8::try_from(most).unwrap_or(244)
    }

    /// How a master owns the slave at an address: watchdog of one second, min T_SDR 11, intervals and modes as the file says.
    #[must_use]
    pub fn parameters(&self, address: u8, baud: Baud) -> SlaveParameters<'_> {
        let general = &self.device().general;
        let status = self.dpv1_status_1();
        let base = if status.contains(Dpv1Status1::WD_BASE_1MS) { 1 } else { 10 };
        let interval_us = general.min_slave_interval.unwrap_or(0).saturating_mul(100);
        SlaveParameters {
            user_prm: &self.user_prm,
            watchdog: watchdog_factors(1000, base),
            min_interval_tbit: baud.tbit_of_us(interval_us.into()),
            fail_safe: status.contains(Dpv1Status1::FAIL_SAFE) || general.fail_safe_required == Some(true),
            dpv1: self.is_dpv1(),
            diag_update_delay: u8::try_from(general.diag_update_delay.unwrap_or(0)).unwrap_or(u8::MAX),
            ..SlaveParameters::new(address, self.ident, &self.chk_cfg)
        }
    }

    fn dpv1_status_1(&self) -> Dpv1Status1 {
        let first = self.user_prm.first().filter(|_| self.is_dpv1()).copied();
        Dpv1Status1::from_bits_retain(first.unwrap_or(0))
    }
}

/// Everything except the file.
struct Parts {
    chosen: Chosen,
    ident: u16,
    chk_cfg: Vec<u8>,
    user_prm: Vec<u8>,
    lengths: Lengths,
    layout: Layout,
}

impl Parts {
    fn of(configuration: &Configuration<'_>) -> Result<Self, SlaveError> {
        let device = configuration.device();
        let ident = device.general.ident_number.and_then(|ident| u16::try_from(ident).ok());
        let chk_cfg = configuration.chk_cfg();
        // An identifier that is cut would take octets of the next module.
        for plugged in configuration.modules().iter().filter(|plugged| !plugged.module.config.is_empty()) {
            cfg::lengths(&plugged.module.config)?;
        }
        Ok(Self {
            chosen: configuration.chosen(),
            ident: ident.ok_or(SlaveError::NoIdent)?,
            lengths: cfg::lengths(&chk_cfg)?,
            chk_cfg,
            user_prm: with_dpv1_status(device, configuration.user_prm()?),
            layout: Layout::new(configuration.modules()),
        })
    }

    fn with(self, file: Arc<GsdFile>) -> GsdSlave {
        let Self { chosen, ident, chk_cfg, user_prm, lengths, layout } = self;
        GsdSlave { file, chosen, ident, chk_cfg, user_prm, lengths, layout }
    }
}

fn is_dpv1(device: &Device) -> bool {
    device.general.dpv1_slave == Some(true)
}

/// The three octets of the DP-V1 status are there even if the file has none. chosen: zeros, which activate nothing.
fn with_dpv1_status(device: &Device, mut user_prm: Vec<u8>) -> Vec<u8> {
    if !is_dpv1(device) {
        return user_prm;
    }
    if user_prm.len() < 3 {
        user_prm.resize(3, 0);
    }
    if let Some(status) = user_prm.first_mut().filter(|_| device.general.fail_safe_required == Some(true)) {
        *status |= Dpv1Status1::FAIL_SAFE.bits();
    }
    user_prm
}
