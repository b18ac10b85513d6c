//! What the slave and the flash store log with defmt, behind the feature `defmt`.
//!
//! Nothing is logged between a request and its answer: what a telegram changed is logged at the next [`BusLog::observe`], which the
//! work context calls when the answer has left, or before the next telegram.

use profivac_dp::link::BitTime;
use profivac_dp::slave::{Fault, SlaveState};
use profivac_wire::Telegram;
use profivac_wire::sap::Sap;

/// The octets of a Set_Prm or Chk_Cfg that are logged when it is refused.
const SHOWN: usize = 16;

/// A Set_Prm or Chk_Cfg that was not logged yet.
#[derive(Clone, Copy, Debug)]
struct Service {
    sa: u8,
    sap: Sap,
    du: [u8; SHOWN],
    length: usize,
    /// The owner before it.
    owner: Option<u8>,
}

impl Service {
    fn du(&self) -> &[u8] {
        self.du.get(..self.length).unwrap_or(&self.du)
    }

    /// The ident number of a Set_Prm.
    fn ident(&self) -> Option<u16> {
        let ident = self.du().get(4..6)?.first_chunk()?;
        Some(u16::from_be_bytes(*ident))
    }
}

/// The part of the slave that is in the log.
#[derive(Clone, Debug)]
pub struct BusLog {
    state: SlaveState,
    service: Option<Service>,
    /// The watchdog has expired before the last event.
    is_watchdog_due: bool,
    late: u32,
}

impl BusLog {
    /// A slave after power-up.
    pub const NEW: Self = Self { state: SlaveState::POWER_UP, service: None, is_watchdog_due: false, late: 0 };

    /// The time is `now`; a telegram or the time changes the slave next, which has this state.
    pub fn before(&mut self, state: &SlaveState, now: BitTime) {
        let watchdog = state.owner().and_then(|owner| owner.watchdog);
        self.is_watchdog_due = watchdog.is_some_and(|watchdog| watchdog.deadline <= now);
    }

    /// This telegram comes next.
    pub fn telegram(&mut self, telegram: &Telegram<'_>, address: u8) {
        let Telegram::Data(data) = telegram else { return };
        let sap = Sap::from_octet(data.dsap);
        if data.da != address || !matches!(sap, Sap::SetPrm | Sap::ChkCfg) {
            return;
        }
        let mut du = [0; SHOWN];
        for (target, octet) in du.iter_mut().zip(data.du) {
            *target = *octet;
        }
        let owner = self.state.owner().map(|owner| owner.master);
        self.service = Some(Service { sa: data.sa, sap, du, length: data.du.len(), owner });
    }

    /// Logs what has changed since the last call. `ident` is that of the device, `late` the number of answers that were dropped.
    pub fn observe(&mut self, state: &SlaveState, ident: u16, late: u32) {
        let service = self.service.take();
        if late != self.late {
            self.late = late;
            defmt::warn!("an answer was later than max T_SDR and was not sent; {=u32} since the start", late);
        }
        if let Some(service) = &service {
            log_refused(service, state, ident);
        }
        let before = core::mem::replace(&mut self.state, *state);
        let owner = before.owner().map(|owner| owner.master);
        if self.is_watchdog_due
            && !state.is_exchanging()
            && let Some(master) = owner
        {
            defmt::warn!("watchdog expired: master {=u8} sent no request in time", master);
        }
        match state {
            SlaveState::WaitPrm(_) if owner.is_some() => defmt::info!("WAIT-PRM"),
            SlaveState::WaitPrm(_) => {}
            SlaveState::WaitCfg(new) if !matches!(before, SlaveState::WaitCfg(_)) || owner != Some(new.master) => {
                defmt::info!("WAIT-CFG: parameters of master {=u8}", new.master);
            }
            SlaveState::WaitCfg(_) => {}
            SlaveState::DataExch(new, exchange) if !before.is_exchanging() => defmt::info!(
                "DATA-EXCH with master {=u8}: {=u8} octets of inputs, {=u8} of outputs",
                new.master,
                exchange.lengths.inputs,
                exchange.lengths.outputs
            ),
            SlaveState::DataExch(..) => {}
        }
    }
}

/// Logs a Set_Prm or Chk_Cfg that was refused or, from a master that does not own the slave, ignored.
fn log_refused(service: &Service, state: &SlaveState, ident: u16) {
    let (sa, du) = (service.sa, service.du());
    match (service.sap, state) {
        (Sap::SetPrm, _) if service.owner.is_some_and(|owner| owner != sa) && state.is_locked_against(sa) => {
            defmt::warn!("Set_Prm of master {=u8} ignored: the slave is locked to another master", sa);
        }
        (Sap::SetPrm, SlaveState::WaitPrm(Fault::Prm)) => match service.ident() {
            Some(other) if other != ident => {
                defmt::warn!(
                    "Set_Prm of master {=u8} refused: ident {=u16:04x} instead of {=u16:04x}",
                    sa,
                    other,
                    ident
                );
            }
            _ => defmt::warn!("Set_Prm of master {=u8} refused: {=[u8]:02x}", sa, du),
        },
        (Sap::ChkCfg, SlaveState::WaitPrm(Fault::Cfg)) => {
            defmt::warn!("Chk_Cfg of master {=u8} refused: {=[u8]:02x}", sa, du);
        }
        _ => {}
    }
}
