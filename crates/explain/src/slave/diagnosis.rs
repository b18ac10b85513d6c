//! The notes about a diagnosis: the result of a start-up, the owner, lost parameters, and what the device reports.

use super::{Slave, releases};
use crate::dpv1::DeviceBlocks;
use crate::gsd::Described;
use crate::note::{Kind, Notes};
use crate::refusal::{RefusedConfiguration, chk_cfg_reason, set_prm_reason};
use profivac_dp::link::Baud;
use profivac_host::scan::SlaveStatus;
use profivac_wire::diag::{NO_MASTER, SlaveDiag, StationStatus};
use profivac_wire::ext_diag::{Block, Blocks};
use profivac_wire::prm::SetPrm;

/// The contents of the last Slave_Diag.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Diagnosis {
    pub(super) status: StationStatus,
    pub(super) owner: u8,
    /// What it reports, as text.
    reports: Vec<String>,
}

/// The status bits of the start-up; all others are diagnosis.
const PROGRESS: StationStatus = StationStatus::STATION_NOT_READY
    .union(StationStatus::PRM_REQ)
    .union(StationStatus::CFG_FAULT)
    .union(StationStatus::PRM_FAULT);

/// The status bits that a working slave may have and that report no condition.
const ORDINARY: StationStatus = StationStatus::ALWAYS_ONE
    .union(StationStatus::WD_ON)
    .union(StationStatus::FREEZE_MODE)
    .union(StationStatus::SYNC_MODE);

impl Slave {
    pub(super) fn diagnosed(&mut self, du: &[u8], baud: Baud, notes: &mut Notes<'_>) {
        let (Ok(diag), Some(parsed)) = (SlaveDiag::parse(du), SlaveStatus::parse(du)) else { return };
        self.identify(diag.ident);
        let reports = diagnosis_reports(&diag, self.device_blocks(), &self.described);
        let now = Diagnosis { status: diag.status, owner: diag.master_add, reports: reports.clone() };
        let before = self.diagnosis.replace(now);
        let refused = self.start_up_result(&diag, notes);
        let Some(before) = before else {
            let owner =
                parsed.owner.map_or_else(|| "has no owner".to_owned(), |owner| format!("belongs to master {owner}"));
            let known: Vec<_> = self.described.devices().names_with_ident(parsed.ident).collect();
            let devices = match (known.join(", "), self.described.names_text()) {
                (known, _) if !known.is_empty() => known,
                (_, described) if !described.is_empty() => format!("{described} by the GSD file"),
                _ => "an unknown device".to_owned(),
            };
            let text = format!("is present: {devices} (ident {:04X}), {owner}, {}", diag.ident, parsed.state_text());
            notes.about(self.address, Kind::Presence, text);
            return self.report_diagnosis(&reports, notes);
        };
        if !refused {
            self.report_lost_parameters(&before, &diag, baud, notes);
        }
        if before.owner != diag.master_add {
            notes.about(self.address, Kind::Owner, owner_change(before.owner, diag.master_add));
        }
        if before.reports != reports {
            self.report_diagnosis(&reports, notes);
        }
        let is_ready = !diag.status.intersects(PROGRESS);
        if is_ready && before.status.intersects(PROGRESS) {
            notes.about(self.address, Kind::StartUp, "has taken parameters and configuration: ready for data exchange");
        }
    }

    /// Adds a note if the slave refused Set_Prm or Chk_Cfg. Returns whether it did.
    fn start_up_result(&mut self, diag: &SlaveDiag<'_>, notes: &mut Notes<'_>) -> bool {
        let (prm, cfg) = (self.prm.is_new, self.cfg_is_new);
        (self.prm.is_new, self.cfg_is_new) = (false, false);
        let text = if prm && diag.status.contains(StationStatus::PRM_FAULT) {
            let reason = set_prm_reason(&self.prm.octets, self.tables.model, diag.ident);
            let by_file = self.described.set_prm_mismatches(&self.prm.octets);
            format!("Set_Prm refused: {reason}{}", by_gsd_file(by_file.into_iter().map(|one| one.found)))
        } else if cfg && diag.status.contains(StationStatus::CFG_FAULT) {
            let refused = RefusedConfiguration {
                slave: &self.name(),
                model: self.tables.model,
                offered: self.offered_cfg.as_deref(),
                requested: &self.requested_cfg,
            };
            let by_file = self.described.misfit().map(|error| error.to_string());
            format!("Chk_Cfg refused: {}{}", chk_cfg_reason(&refused), by_gsd_file(by_file))
        } else {
            return false;
        };
        notes.about(self.address, Kind::Refused, text);
        self.cyclic.end();
        true
    }

    /// Adds a note when a slave in data exchange requires parameters again: its master has released it, its watchdog has
    /// expired, or it was restarted.
    fn report_lost_parameters(&mut self, before: &Diagnosis, diag: &SlaveDiag<'_>, baud: Baud, notes: &mut Notes<'_>) {
        let was_ready = !before.status.intersects(PROGRESS);
        if !was_ready || !diag.status.contains(StationStatus::PRM_REQ) {
            return;
        }
        let pause_ms = self.pause_tbit.saturating_mul(1000) / u64::from(baud.bits_per_second());
        let released = SetPrm::parse(&self.prm.octets).is_ok_and(|prm| releases(&prm));
        let text = match self.prm.watchdog_ms {
            _ if released => "was released".to_owned(),
            Some(limit) if pause_ms > u64::from(limit) => {
                format!("its watchdog has expired: its owner sent no request for {pause_ms} ms, {limit} ms are allowed")
            }
            Some(limit) if self.last_owner_request.is_none() => {
                format!("has lost its parameters: its watchdog of {limit} ms has expired, or it was restarted")
            }
            _ => "has lost its parameters: it was restarted".to_owned(),
        };
        notes.about(self.address, Kind::Watchdog, text);
        self.cyclic.end();
        self.pause_tbit = 0;
    }

    /// Adds a note about the contents of a diagnosis beyond the start-up.
    fn report_diagnosis(&self, reports: &[String], notes: &mut Notes<'_>) {
        let is_initial = reports.is_empty() && self.counters.exchanges == 0;
        if !is_initial {
            let text = if reports.is_empty() {
                "its diagnosis reports nothing".to_owned()
            } else {
                format!("its diagnosis: {}", reports.join("; "))
            };
            notes.about(self.address, Kind::Diagnosis, text);
        }
    }
}

/// What the GSD file says about a refusal.
fn by_gsd_file(reasons: impl IntoIterator<Item = String>) -> String {
    let reasons: Vec<_> = reasons.into_iter().collect();
    if reasons.is_empty() { String::new() } else { format!("; by the GSD file: {}", reasons.join("; ")) }
}

/// The text of the note about a change of the owner.
fn owner_change(before: u8, now: u8) -> String {
    match (before, now) {
        (NO_MASTER, now) => format!("belongs to master {now} now"),
        (before, NO_MASTER) => format!("has no owner any more, before it belonged to master {before}"),
        (before, now) => format!("belongs to master {now} now, before it belonged to master {before}"),
    }
}

/// What a diagnosis reports beyond the start-up: the status bits and the blocks of the extended diagnosis, each as text, in the words of the
/// GSD file if there is one.
#[must_use]
pub fn diagnosis_reports(diag: &SlaveDiag<'_>, device_blocks: DeviceBlocks, described: &Described) -> Vec<String> {
    let status = (diag.status - PROGRESS - ORDINARY).names().map(str::to_owned);
    let blocks = Blocks::new(diag.ext_diag).map(|block| match block {
        Ok(block) => described.block_text(&block, device_blocks).unwrap_or_else(|| match block {
            Block::Device(content) => device_blocks.text(content),
            block => block.to_string(),
        }),
        Err(_) => "a damaged block".to_owned(),
    });
    status.chain(blocks).collect()
}
