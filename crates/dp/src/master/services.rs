//! The single requests of DP-V0, for tools: to be handed to [`Master::submit`](super::Master::submit). None of them changes
//! a slave but [`set_slave_add`]; there is no Set_Prm among them. profibus-wire 2.

use crate::link::active::Request;
use profivac_wire::Sap;
use profivac_wire::control::Function;
use profivac_wire::sap::MASTER_MS0;

/// FDL status: who is there.
#[must_use]
pub const fn fdl_status(da: u8) -> Request<'static> {
    Request { da, function: Function::FdlStatus, dsap: None, ssap: None, du: &[] }
}

/// Slave_Diag.
#[must_use]
pub const fn slave_diag(da: u8) -> Request<'static> {
    ms0(da, Sap::SlaveDiag, &[])
}

/// Get_Cfg.
#[must_use]
pub const fn get_cfg(da: u8) -> Request<'static> {
    ms0(da, Sap::GetCfg, &[])
}

/// RD_Inp.
#[must_use]
pub const fn rd_inp(da: u8) -> Request<'static> {
    ms0(da, Sap::RdInp, &[])
}

/// RD_Outp.
#[must_use]
pub const fn rd_outp(da: u8) -> Request<'static> {
    ms0(da, Sap::RdOutp, &[])
}

/// Set_Slave_Add, with the data unit that [`SetSlaveAdd`](profivac_wire::address::SetSlaveAdd) emits.
#[must_use]
pub const fn set_slave_add(da: u8, du: &[u8]) -> Request<'_> {
    ms0(da, Sap::SetSlaveAdd, du)
}

/// Data_Exchange: SRD high without access points.
pub(super) const fn data_exchange(da: u8, du: &[u8]) -> Request<'_> {
    Request { da, function: Function::SrdHigh, dsap: None, ssap: None, du }
}

/// A service of the relation between master and slave: SRD high.
pub(super) const fn ms0(da: u8, sap: Sap, du: &[u8]) -> Request<'_> {
    Request { da, function: Function::SrdHigh, dsap: sap.to_octet(), ssap: Some(MASTER_MS0), du }
}
