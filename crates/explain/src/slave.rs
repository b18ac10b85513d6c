//! A slave as the telegrams show it: what it is, whose it is, how far its start-up has come.

use super::acyclic::Records;
use super::cycle::{Answer, Request, status_text};
use super::cyclic::Cyclic;
use super::names::DeviceTables;
use super::note::{Kind, Notes};
use super::refusal;
use profivac_devices::catalog::MODELS;
use profivac_devices::model::Model;
use profivac_dp::link::{Baud, BitTime};
use profivac_host::scan::SlaveStatus;
use profivac_sim::describe::{Hex, station_status};
use profivac_wire::Sap;
use profivac_wire::address::SetSlaveAdd;
use profivac_wire::control::Status;
use profivac_wire::diag::{NO_MASTER, SlaveDiag, StationStatus};
use profivac_wire::ext_diag::{Block, Blocks, MessageKind};
use profivac_wire::prm::{Dpv1Status1, PrmStatus, SetPrm};

/// So many requests in a row without an answer are told.
const REPORTED_SILENCE: u32 = 2;

/// What the last Slave_Diag said.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Diagnosis {
    status: StationStatus,
    owner: u8,
    ext_diag: Vec<u8>,
}

/// What the last Set_Prm asked for.
#[derive(Clone, Debug, Default)]
pub(super) struct Parameters {
    pub(super) octets: Vec<u8>,
    pub(super) watchdog_ms: Option<u32>,
    /// Nobody has heard yet what the slave thinks of them.
    pub(super) is_new: bool,
}

/// Bits that say how far a start-up has come; all others are diagnosis.
const PROGRESS: StationStatus = StationStatus::STATION_NOT_READY
    .union(StationStatus::PRM_REQ)
    .union(StationStatus::CFG_FAULT)
    .union(StationStatus::PRM_FAULT);

/// Bits that a working slave may have or not, and that say nothing.
const ORDINARY: StationStatus = StationStatus::ALWAYS_ONE
    .union(StationStatus::WD_ON)
    .union(StationStatus::FREEZE_MODE)
    .union(StationStatus::SYNC_MODE);

/// How often it was asked, and what became of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Requests to it.
    pub requests: u64,
    /// Requests that were sent once more.
    pub retries: u64,
    /// Requests without an answer.
    pub unanswered: u64,
    /// Data_Exchange with data or acknowledgement.
    pub exchanges: u64,
}

/// A slave.
#[derive(Clone, Debug)]
pub struct Slave {
    pub(super) address: u8,
    /// How often it was asked.
    pub counters: Counters,
    /// What its octets mean.
    pub tables: DeviceTables,
    pub(super) ident: Option<u16>,
    pub(super) offered: Option<Vec<u8>>,
    pub(super) asked: Vec<u8>,
    pub(super) prm: Parameters,
    cfg_is_new: bool,
    diagnosis: Option<Diagnosis>,
    records: Records,
    cyclic: Cyclic,
    unanswered_in_a_row: u32,
    /// When its owner spoke to it last, and the longest pause since data were exchanged.
    last_owner_request: Option<BitTime>,
    pause_tbit: u64,
}

impl Slave {
    pub(super) fn new(address: u8) -> Self {
        Self {
            address,
            counters: Counters::default(),
            tables: DeviceTables::default(),
            ident: None,
            offered: None,
            asked: Vec::new(),
            prm: Parameters::default(),
            cfg_is_new: false,
            diagnosis: None,
            records: Records::default(),
            cyclic: Cyclic::default(),
            unanswered_in_a_row: 0,
            last_owner_request: None,
            pause_tbit: 0,
        }
    }

    /// Whether it has ever said what it is.
    #[must_use]
    pub const fn is_known(&self) -> bool {
        self.ident.is_some()
    }

    /// What it is called: by its name, unless several devices share the ident number.
    #[must_use]
    pub fn name(&self) -> String {
        let alone = self.candidates().count() == 1;
        let model = self.tables.model.filter(|_| alone);
        model.map_or_else(|| "the slave".to_owned(), |model| format!("the {}", model.name))
    }

    /// A request goes to it. Returns what the request means, in its own terms.
    pub(super) fn request(&mut self, request: &Request, is_retry: bool) -> String {
        self.counters.requests = self.counters.requests.saturating_add(1);
        self.counters.retries = self.counters.retries.saturating_add(u64::from(is_retry));
        let owner = self.diagnosis.as_ref().is_none_or(|diagnosis| diagnosis.owner == request.master);
        if let (true, Some(now)) = (owner, request.at) {
            let pause = self.last_owner_request.map_or(0, |before| now - before);
            self.pause_tbit = self.pause_tbit.max(pause);
            self.last_owner_request = Some(now);
        }
        match request.sap {
            Sap::Default => self.cyclic.outputs(&self.tables, &request.du),
            Sap::Ms1 | Sap::Ms2(_) => self.records.request(&self.tables, request),
            _ => String::new(),
        }
    }

    /// Nobody answered.
    pub(super) fn unanswered(&mut self, request: &Request, notes: &mut Notes<'_>) {
        self.counters.unanswered = self.counters.unanswered.saturating_add(1);
        self.unanswered_in_a_row = self.unanswered_in_a_row.saturating_add(1);
        if self.unanswered_in_a_row == REPORTED_SILENCE {
            let text = format!("does not answer master {} any more", request.master);
            let never = format!("does not answer master {}", request.master);
            notes.about(self.address, Kind::Presence, if self.is_known() { text } else { never });
        }
    }

    /// The answer came. Returns what it means, in the slave's own terms.
    pub(super) fn answer(
        &mut self,
        request: &Request,
        answer: Answer<'_>,
        baud: Baud,
        notes: &mut Notes<'_>,
    ) -> String {
        if self.unanswered_in_a_row >= REPORTED_SILENCE {
            let text = format!("answers again, {} requests were in vain", self.unanswered_in_a_row);
            notes.about(self.address, Kind::Presence, text);
        }
        self.unanswered_in_a_row = 0;
        match request.sap {
            Sap::SlaveDiag => self.diagnosed(answer.du, baud, notes),
            Sap::SetPrm => self.parameterised(request, answer, notes),
            Sap::ChkCfg => self.configured(request, answer, notes),
            Sap::GetCfg => self.offers(answer, notes),
            Sap::SetSlaveAdd => self.address_changed(request, answer, notes),
            Sap::Default => return self.exchanged(request, answer, notes),
            Sap::Ms1 | Sap::Ms2(_) | Sap::ResourceManager | Sap::Alarm => {
                return self.records.answer(self.address, &mut self.tables, request, answer, notes);
            }
            Sap::SetExtPrm | Sap::RdInp | Sap::RdOutp | Sap::GlobalControl | Sap::Other(_) => {}
        }
        String::new()
    }

    fn parameterised(&mut self, request: &Request, answer: Answer<'_>, notes: &mut Notes<'_>) {
        let Ok(prm) = SetPrm::parse(&request.du) else { return };
        if !answer.is_ack() {
            let text = format!("does not take Set_Prm of master {}: {}", request.master, status_text(answer.status));
            return notes.about(self.address, Kind::Refused, text);
        }
        self.identify(prm.ident);
        let watchdog_ms = watchdog_ms(&prm);
        let unit = self.tables.model.and_then(|model| model.user_prm(prm.user)).map(|known| known.unit_code());
        let unit = unit.and_then(|code| self.tables.model?.unit(code));
        self.tables.unit = unit.or(self.tables.unit);
        self.prm = Parameters { octets: request.du.clone(), watchdog_ms, is_new: !releases(&prm) };
        let [first, second] = prm.wd_fact;
        let watchdog = watchdog_ms.map(|ms| format!("watchdog {ms} ms")).unwrap_or_default();
        let words = profivac_sim::describe::set_prm(&prm).replace(&format!("watchdog {first} x {second}"), &watchdog);
        let unit = unit.map(|unit| format!(" (unit {})", unit.name)).unwrap_or_default();
        let text = format!("master {} sets its parameters:{words}{unit}", request.master);
        notes.about(self.address, Kind::StartUp, text);
    }

    fn configured(&mut self, request: &Request, answer: Answer<'_>, notes: &mut Notes<'_>) {
        if !answer.is_ack() {
            let text = format!("does not take Chk_Cfg of master {}: {}", request.master, status_text(answer.status));
            return notes.about(self.address, Kind::Refused, text);
        }
        self.asked.clone_from(&request.du);
        self.cfg_is_new = true;
        // Of devices that share an ident number the first that has this configuration.
        let known = self.candidates().find_map(|model| Some((model, model.configuration(&request.du)?)));
        self.tables.model = known.map(|(model, _)| model).or(self.tables.model);
        self.cyclic.configure(known.map(|(_, configuration)| configuration));
        let lengths = profivac_wire::cfg::lengths(&request.du);
        let octets = lengths
            .map_or_else(|error| error.to_string(), |sum| format!("{} octets out, {} in", sum.outputs, sum.inputs));
        let text = format!("master {} asks for the configuration {}: {octets}", request.master, Hex(&request.du));
        notes.about(self.address, Kind::StartUp, text);
    }

    fn offers(&mut self, answer: Answer<'_>, notes: &mut Notes<'_>) {
        if !answer.du.is_empty() && self.offered.as_deref() != Some(answer.du) {
            self.offered = Some(answer.du.to_vec());
            notes.about(self.address, Kind::StartUp, format!("has the configuration {}", Hex(answer.du)));
        }
    }

    fn address_changed(&self, request: &Request, answer: Answer<'_>, notes: &mut Notes<'_>) {
        let Ok(wanted) = SetSlaveAdd::parse(&request.du) else { return };
        if answer.is_ack() {
            let lock = if wanted.no_add_chg == 0 { "" } else { ", for good" };
            notes.about(self.address, Kind::StartUp, format!("shall have the address {}{lock}", wanted.address));
        } else {
            notes.about(
                self.address,
                Kind::Refused,
                format!("does not take another address: {}", status_text(answer.status)),
            );
        }
    }

    /// All devices with the ident number.
    fn candidates(&self) -> impl Iterator<Item = &'static Model> + use<> {
        let ident = self.ident;
        MODELS.into_iter().filter(move |model| Some(model.ident) == ident)
    }

    fn identify(&mut self, ident: u16) {
        if self.ident != Some(ident) {
            self.ident = Some(ident);
            let model = self.candidates().next();
            self.tables = DeviceTables { model, ..DeviceTables::default() };
        }
    }

    fn diagnosed(&mut self, du: &[u8], baud: Baud, notes: &mut Notes<'_>) {
        let (Ok(diag), Some(seen)) = (SlaveDiag::parse(du), SlaveStatus::parse(du)) else { return };
        let before = self.diagnosis.replace(Diagnosis {
            status: diag.status,
            owner: diag.master_add,
            ext_diag: diag.ext_diag.to_vec(),
        });
        let refused = self.start_up_result(&diag, notes);
        self.identify(diag.ident);
        let Some(before) = before else {
            let owner = seen.owner.map_or_else(|| "nobody".to_owned(), |owner| format!("master {owner}"));
            let devices = seen.device_names().join(", ");
            let devices = if devices.is_empty() { "a device that is not known here" } else { &devices };
            let text =
                format!("is there: {devices} (ident {:04X}), belongs to {owner}, {}", diag.ident, seen.state_text());
            notes.about(self.address, Kind::Presence, text);
            return self.reported(&diag, notes);
        };
        if !refused {
            self.lost(&before, &diag, baud, notes);
        }
        if before.owner != diag.master_add {
            notes.about(self.address, Kind::Owner, ownership(before.owner, diag.master_add));
        }
        let news = |diagnosis: &Diagnosis| (diagnosis.status - PROGRESS - ORDINARY, diagnosis.ext_diag.clone());
        if self.diagnosis.as_ref().map(news) != Some(news(&before)) {
            self.reported(&diag, notes);
        }
        let settled = !diag.status.intersects(PROGRESS);
        if settled && before.status.intersects(PROGRESS) {
            notes.about(self.address, Kind::StartUp, "has taken parameters and configuration: ready for data exchange");
        }
    }

    /// What became of Set_Prm and Chk_Cfg: whether one was refused.
    fn start_up_result(&mut self, diag: &SlaveDiag<'_>, notes: &mut Notes<'_>) -> bool {
        let (prm, cfg) = (self.prm.is_new, self.cfg_is_new);
        (self.prm.is_new, self.cfg_is_new) = (false, false);
        let text = if prm && diag.status.contains(StationStatus::PRM_FAULT) {
            self.identify(diag.ident);
            format!("Set_Prm refused: {}", refusal::parameters(self, diag.ident))
        } else if cfg && diag.status.contains(StationStatus::CFG_FAULT) {
            format!("Chk_Cfg refused: {}", refusal::configuration(self))
        } else {
            return false;
        };
        notes.about(self.address, Kind::Refused, text);
        self.cyclic.end();
        true
    }

    /// A slave that exchanged data and wants parameters again has been restarted, released, or its watchdog has expired.
    fn lost(&mut self, before: &Diagnosis, diag: &SlaveDiag<'_>, baud: Baud, notes: &mut Notes<'_>) {
        let worked = !before.status.intersects(PROGRESS);
        if !worked || !diag.status.contains(StationStatus::PRM_REQ) {
            return;
        }
        let pause_ms = self.pause_tbit.saturating_mul(1000) / u64::from(baud.bits_per_second());
        let released = SetPrm::parse(&self.prm.octets).is_ok_and(|prm| releases(&prm));
        let text = match self.prm.watchdog_ms {
            _ if released => "was released".to_owned(),
            Some(limit) if pause_ms > u64::from(limit) => {
                format!("its watchdog has expired: nobody spoke to it for {pause_ms} ms, {limit} ms are allowed")
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

    /// What a diagnosis reports beyond the start-up.
    fn reported(&self, diag: &SlaveDiag<'_>, notes: &mut Notes<'_>) {
        let mut words: Vec<String> = station_status(diag.status - PROGRESS - ORDINARY).map(str::to_owned).collect();
        words.extend(
            Blocks::new(diag.ext_diag).map(|block| block.map_or_else(|_| "a damaged block".to_owned(), block_text)),
        );
        let nothing_to_say = self.diagnosis.is_some() && words.is_empty();
        let text = if nothing_to_say {
            "its diagnosis reports nothing".to_owned()
        } else {
            format!("its diagnosis: {}", words.join(", "))
        };
        let first = words.is_empty() && self.counters.exchanges == 0;
        if !first {
            notes.about(self.address, Kind::Diagnosis, text);
        }
    }

    fn exchanged(&mut self, request: &Request, answer: Answer<'_>, notes: &mut Notes<'_>) -> String {
        match answer.status {
            Status::Ok | Status::DataLow | Status::DataHigh | Status::NoReply => {}
            status => {
                if self.cyclic.refuse() {
                    notes.about(
                        self.address,
                        Kind::Refused,
                        format!("refuses to exchange data: {}", status_text(status)),
                    );
                }
                return String::new();
            }
        }
        self.counters.exchanges = self.counters.exchanges.saturating_add(1);
        if self.cyclic.begins() {
            self.pause_tbit = 0;
        }
        self.cyclic.inputs(self.address, &self.tables, request, answer, notes)
    }
}

/// Unlock without lock.
fn releases(prm: &SetPrm<'_>) -> bool {
    prm.status.contains(PrmStatus::UNLOCK_REQ) && !prm.status.contains(PrmStatus::LOCK_REQ)
}

/// The watchdog in ms; the first user parameter of a DP-V1 slave may change its base. profibus-wire 2.4
fn watchdog_ms(prm: &SetPrm<'_>) -> Option<u32> {
    let base = prm.user.first().map(|octet| Dpv1Status1::from_bits_retain(*octet));
    let base_ms = if base.is_some_and(|octet| octet.contains(Dpv1Status1::WD_BASE_1MS)) { 1 } else { 10 };
    let [first, second] = prm.wd_fact.map(u32::from);
    prm.status.contains(PrmStatus::WD_ON).then(|| first.saturating_mul(second).saturating_mul(base_ms))
}

fn ownership(before: u8, now: u8) -> String {
    match (before, now) {
        (NO_MASTER, now) => format!("belongs to master {now} now"),
        (before, NO_MASTER) => format!("belongs to nobody any more, before to master {before}"),
        (before, now) => format!("belongs to master {now} now, before to master {before}"),
    }
}

/// A block of an extended diagnosis.
fn block_text(block: Block<'_>) -> String {
    match block {
        Block::Device(content) => match profivac_wire::ext_diag::Message::parse(content) {
            Ok(message) if matches!(message.kind, MessageKind::Alarm(1..=6) | MessageKind::Status(1..=3)) => {
                format!("{} of slot {}: {}", message.kind.name(), message.slot, Hex(message.data))
            }
            _ => format!("device {}", Hex(content)),
        },
        Block::Identifier(content) => {
            let modules: Vec<String> =
                profivac_wire::ext_diag::identifiers_with_diagnosis(content).map(|number| number.to_string()).collect();
            format!("modules {}", modules.join(" "))
        }
        Block::Channel(channel) => {
            let error = profivac_wire::ext_diag::channel_error(channel.error);
            format!("module {} channel {}: {error}", channel.identifier, channel.number)
        }
        Block::Revision(revision) => format!("revision {revision}"),
    }
}
