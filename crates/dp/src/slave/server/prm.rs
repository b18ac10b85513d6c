//! Set_Prm: the owner of the slave and the parameters it gives. profibus-wire 2.4.

use super::{MIN_TSDR_TBIT, Server};
use crate::link::{Baud, Indication, Reply};
use crate::slave::{Device, Fault, Owner, SlaveState, Watchdog};
use profivac_wire::prm::{Dpv1Status1, Dpv1Status2, Dpv1Status3, PrmStatus, SetPrm};

/// The bits of DPV1_Status_1 that a slave of this project refuses: the reserved ones.
/// chosen: the publisher mode of DP-V2 as well.
const DPV1_STATUS_1_REFUSED: Dpv1Status1 = Dpv1Status1::RESERVED.union(Dpv1Status1::PUBLISHER_ENABLE);

/// The base of the watchdog factors in milliseconds, without and with WD_Base_1ms.
const WATCHDOG_BASE_MS: u64 = 10;
const WATCHDOG_FINE_BASE_MS: u64 = 1;

impl<D: Device, const CONNECTIONS: usize> Server<D, CONNECTIONS> {
    /// The slave always acknowledges; the next diagnosis says whether it accepted the parameters.
    pub(super) fn set_prm(&mut self, request: &Indication<'_>) -> Reply<'static> {
        // A foreign master changes nothing while the slave is locked, not even with a faulty telegram:
        // profibus-wire 10, points 6 and 12.
        if self.state.is_locked_against(request.sa) {
            return Reply::ShortAck;
        }
        match SetPrm::parse(request.du) {
            Ok(prm) => self.evaluate(request.sa, &prm),
            Err(_) => self.enter_wait_prm(Fault::Prm),
        }
        Reply::ShortAck
    }

    /// The table of Lock_Req and Unlock_Req.
    fn evaluate(&mut self, sa: u8, prm: &SetPrm<'_>) {
        let lock = prm.status.contains(PrmStatus::LOCK_REQ);
        let unlock = prm.status.contains(PrmStatus::UNLOCK_REQ);
        match (lock, unlock) {
            (false, false) => self.set_min_tsdr(prm.min_tsdr),
            (_, true) => self.enter_wait_prm(Fault::None),
            (true, false) => match self.accept_parameters(sa, prm) {
                Some(owner) => {
                    self.set_min_tsdr(prm.min_tsdr);
                    self.enter(SlaveState::WaitCfg(owner));
                }
                None => self.enter_wait_prm(Fault::Prm),
            },
        }
    }

    /// The owner with its parameters; `None` if slave or device refuse them.
    fn accept_parameters(&mut self, sa: u8, prm: &SetPrm<'_>) -> Option<Owner> {
        let features = self.device.features();
        let (dpv1_status_1, dpv1_known) = dpv1_status(prm.user);
        let dpv1_status_1 = if features.dpv1 { dpv1_status_1 } else { Dpv1Status1::empty() };
        let watchdog_on = prm.status.contains(PrmStatus::WD_ON);
        let acceptable = prm.ident == self.device.ident_number()
            // Only a DP-V1 slave checks reserved bits.
            && (!features.dpv1 || (dpv1_known && !prm.status.intersects(PrmStatus::RESERVED)))
            // profibus-wire 10, point 11
            && !(watchdog_on && prm.wd_fact.contains(&0));
        if !acceptable || self.device.set_prm(prm.user).is_err() {
            return None;
        }
        let fine_base = dpv1_status_1.contains(Dpv1Status1::WD_BASE_1MS);
        let watchdog = watchdog_on.then(|| self.watchdog(prm.wd_fact, fine_base));
        let sync = prm.status.contains(PrmStatus::SYNC_REQ) && !features.sync;
        let freeze = prm.status.contains(PrmStatus::FREEZE_REQ) && !features.freeze;
        Some(Owner {
            master: sa,
            group: prm.group,
            watchdog,
            dpv1: dpv1_status_1.contains(Dpv1Status1::DPV1_ENABLE),
            fail_safe: dpv1_status_1.contains(Dpv1Status1::FAIL_SAFE) || self.device.is_fail_safe(),
            not_supported: sync || freeze,
        })
    }

    /// T_WD = base x WD_Fact_1 x WD_Fact_2, counted from the end of the request.
    fn watchdog(&self, [first, second]: [u8; 2], fine_base: bool) -> Watchdog {
        let base_ms = if fine_base { WATCHDOG_FINE_BASE_MS } else { WATCHDOG_BASE_MS };
        let ms = base_ms.saturating_mul(u64::from(first)).saturating_mul(u64::from(second));
        let period_tbit = self.baud.tbit_of_ms(ms);
        Watchdog { period_tbit, deadline: self.now + period_tbit }
    }

    /// 0 keeps the present value; a value below 11 is raised to 11. chosen: a value above max T_SDR is lowered to it,
    /// since the slave declares never to answer later.
    fn set_min_tsdr(&mut self, min_tsdr: u8) {
        if min_tsdr != 0 {
            let latest = u8::try_from(self.device.max_tsdr_tbit(self.baud)).unwrap_or(u8::MAX);
            self.min_tsdr = min_tsdr.clamp(MIN_TSDR_TBIT, latest.max(MIN_TSDR_TBIT));
        }
    }

    /// The bus runs at another rate, whose max T_SDR may be lower.
    pub(in crate::slave) fn set_baud(&mut self, baud: Baud) {
        self.baud = baud;
        self.set_min_tsdr(self.min_tsdr);
    }
}

/// DPV1_Status_1, and whether a DP-V1 slave accepts the three octets: all absent, or without reserved bits. It refuses one
/// or two octets (profibus-wire 10, point 37).
///
/// chosen: it accepts the other bits of the second and third octet, although it has no isochronous mode and no
/// PrmCmd: profibus-wire 2.4 refuses reserved bits only, and masters set Prm_Structure for DP-V1 slaves. The device gets the
/// octets and may refuse them.
fn dpv1_status(user: &[u8]) -> (Dpv1Status1, bool) {
    match user {
        [] => (Dpv1Status1::empty(), true),
        [first, second, third, ..] => {
            let first = Dpv1Status1::from_bits_retain(*first);
            let known = !first.intersects(DPV1_STATUS_1_REFUSED)
                && !Dpv1Status2::from_bits_retain(*second).intersects(Dpv1Status2::RESERVED)
                && !Dpv1Status3::from_bits_retain(*third).intersects(Dpv1Status3::RESERVED);
            (first, known)
        }
        _ => (Dpv1Status1::empty(), false),
    }
}
