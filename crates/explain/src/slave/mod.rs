//! The state of a slave as the telegrams show it: its device, its owner and the progress of its start-up.

mod diagnosis;

pub use diagnosis::diagnosis_reports;

use crate::acyclic::Records;
use crate::cycle::{Answer, Request, status_text};
use crate::cyclic::Cyclic;
use crate::dpv1::{DeviceBlocks, Dpv1Traffic};
use crate::gsd::{Described, Extent, Files};
use crate::names::DeviceTables;
use crate::note::{Kind, Notes, octets};
use diagnosis::Diagnosis;
use profivac_devices::model::Model;
use profivac_dp::link::{Baud, BitTime};
use profivac_sim::describe::{Hex, set_prm_with_watchdog};
use profivac_wire::Sap;
use profivac_wire::address::SetSlaveAdd;
use profivac_wire::control::Status;
use profivac_wire::prm::{Dpv1Status1, PrmStatus, SetPrm};
use std::collections::BTreeMap;

/// The number of unanswered requests in a row after which a note reports it.
const REPORTED_SILENCE: u32 = 2;

/// The last Set_Prm that the slave acknowledged.
#[derive(Clone, Debug, Default)]
struct Parameters {
    octets: Vec<u8>,
    /// The last note about its user parameters by the GSD file.
    words: String,
    watchdog_ms: Option<u32>,
    /// No diagnosis has shown the result yet.
    is_new: bool,
}

/// Counters of the requests to a slave.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Requests, with repetitions.
    pub requests: u64,
    /// Repetitions.
    pub repetitions: u64,
    /// Requests without an answer.
    pub unanswered: u64,
    /// Data_Exchange cycles with data or an acknowledgement.
    pub exchanges: u64,
}

/// The state of one slave.
#[derive(Clone, Debug)]
pub struct Slave {
    address: u8,
    /// Counters of the requests to it.
    pub counters: Counters,
    /// The tables of its device, for the meaning of its octets.
    pub tables: DeviceTables,
    /// The slave in the words of its GSD file.
    pub described: Described,
    ident: Option<u16>,
    /// The configuration of Get_Cfg.
    offered_cfg: Option<Vec<u8>>,
    /// The configuration of Chk_Cfg.
    requested_cfg: Vec<u8>,
    prm: Parameters,
    /// No diagnosis has shown the result of Chk_Cfg yet.
    cfg_is_new: bool,
    diagnosis: Option<Diagnosis>,
    dpv1: Dpv1Traffic,
    records: Records,
    cyclic: Cyclic,
    unanswered_in_a_row: u32,
    /// The services that the slave refuses, or answers without data, and how.
    refusals: BTreeMap<String, Status>,
    /// Start of the last request of its owner.
    last_owner_request: Option<BitTime>,
    /// The longest pause between requests of its owner since data exchange began.
    pause_tbit: u64,
}

impl Slave {
    pub(crate) fn new(address: u8, files: Files) -> Self {
        Self {
            address,
            described: Described::new(files),
            counters: Counters::default(),
            tables: DeviceTables::default(),
            ident: None,
            offered_cfg: None,
            requested_cfg: Vec::new(),
            prm: Parameters::default(),
            cfg_is_new: false,
            diagnosis: None,
            dpv1: Dpv1Traffic::default(),
            records: Records::default(),
            cyclic: Cyclic::default(),
            unanswered_in_a_row: 0,
            refusals: BTreeMap::new(),
            last_owner_request: None,
            pause_tbit: 0,
        }
    }

    /// Whether its Ident_Number is known.
    #[must_use]
    pub const fn is_known(&self) -> bool {
        self.ident.is_some()
    }

    /// The slave in a sentence: `the bcg450`, or `the slave` if several devices or none have its Ident_Number.
    #[must_use]
    pub fn name(&self) -> String {
        let is_only = self.candidates().count() == 1;
        let model = self.tables.model.filter(|_| is_only).map(|model| model.name.to_owned());
        let model = model.or_else(|| match self.described.models().as_slice() {
            [only] if self.tables.model.is_none() => Some(only.clone()),
            _ => None,
        });
        model.map_or_else(|| "the slave".to_owned(), |model| format!("the {model}"))
    }

    /// Records a request. Returns its meaning from the tables of the device.
    pub(crate) fn request(&mut self, request: &Request, is_repetition: bool) -> String {
        self.counters.requests = self.counters.requests.saturating_add(1);
        self.counters.repetitions = self.counters.repetitions.saturating_add(u64::from(is_repetition));
        let owner = self.diagnosis.as_ref().is_none_or(|diagnosis| diagnosis.owner == request.master);
        if let (true, Some(now)) = (owner, request.at) {
            let pause = self.last_owner_request.map_or(0, |before| now - before);
            self.pause_tbit = self.pause_tbit.max(pause);
            self.last_owner_request = Some(now);
        }
        match request.sap {
            Sap::Default => self.cyclic.outputs(&self.tables, &self.described, &request.du),
            Sap::SetPrm => self.parameters_meaning(&request.du),
            Sap::ChkCfg => self.modules_meaning(&request.du),
            Sap::Ms1 | Sap::Ms2(_) => self.records.request(&self.tables, request),
            _ => String::new(),
        }
    }

    /// All user parameters of a Set_Prm by the GSD file.
    fn parameters_meaning(&mut self, du: &[u8]) -> String {
        let Ok(prm) = SetPrm::parse(du) else { return String::new() };
        if self.ident.is_none() {
            self.described.identify(prm.ident);
        }
        self.described.new_parameters_text(prm.user, Extent::All)
    }

    /// All modules of a Chk_Cfg by the GSD file. The slave may refuse it.
    fn modules_meaning(&self, du: &[u8]) -> String {
        let mut asked = self.described.clone();
        asked.configure(du);
        asked.modules_text(Extent::All)
    }

    /// Adds a note about a repetition, unless the slave is silent for a longer time already.
    pub(crate) fn repeated(&self, request: &Request, reason: &str, notes: &mut Notes<'_>) {
        if self.unanswered_in_a_row < REPORTED_SILENCE {
            let text = format!("master {} repeats {}: {reason}", request.master, request.service());
            notes.about(self.address, Kind::Repetition, text);
        }
    }

    /// Records a request without an answer.
    pub(crate) fn unanswered(&mut self, request: &Request, notes: &mut Notes<'_>) {
        self.counters.unanswered = self.counters.unanswered.saturating_add(1);
        self.unanswered_in_a_row = self.unanswered_in_a_row.saturating_add(1);
        if self.unanswered_in_a_row == REPORTED_SILENCE {
            let since = if self.is_known() { " any more" } else { "" };
            let text = format!("does not answer master {}{since}", request.master);
            notes.about(self.address, Kind::Presence, text);
        }
    }

    /// Records an answer. Returns its meaning from the tables of the device.
    pub(crate) fn answer(
        &mut self,
        request: &Request,
        answer: Answer<'_>,
        baud: Baud,
        notes: &mut Notes<'_>,
    ) -> String {
        if self.unanswered_in_a_row >= REPORTED_SILENCE {
            let text = format!("answers again after {} unanswered requests", self.unanswered_in_a_row);
            notes.about(self.address, Kind::Presence, text);
        }
        self.unanswered_in_a_row = 0;
        self.report_refusal(request, answer, notes);
        self.dpv1.answered(request, answer);
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

    /// Adds a note about the first refusal of a service that has no sentence of its own, and about an answer without the data that the
    /// service returns.
    fn report_refusal(&mut self, request: &Request, answer: Answer<'_>, notes: &mut Notes<'_>) {
        let has_sentence = match request.sap {
            Sap::SetPrm | Sap::ChkCfg | Sap::SetSlaveAdd | Sap::Default => true,
            Sap::Ms1 | Sap::Ms2(_) | Sap::ResourceManager | Sap::Alarm => true,
            Sap::SlaveDiag | Sap::GetCfg | Sap::SetExtPrm | Sap::RdInp | Sap::RdOutp => false,
            Sap::GlobalControl | Sap::Other(_) => false,
        };
        let (service, master) = (request.service(), request.master);
        let is_without_data = answer.is_ack() && matches!(request.sap, Sap::SlaveDiag | Sap::GetCfg);
        if has_sentence || !(answer.is_refusal() || is_without_data) {
            self.refusals.remove(&service);
            return;
        }
        let status = status_text(answer.status);
        let text = if answer.is_refusal() {
            format!("refuses {service} of master {master}: {status}")
        } else {
            format!("answers {service} of master {master} without data: {status}")
        };
        if self.refusals.insert(service, answer.status) != Some(answer.status) {
            notes.about(self.address, Kind::Refused, text);
        }
    }

    fn parameterised(&mut self, request: &Request, answer: Answer<'_>, notes: &mut Notes<'_>) {
        let Ok(prm) = SetPrm::parse(&request.du) else { return };
        if !answer.is_ack() {
            let text = format!("does not take Set_Prm of master {}: {}", request.master, status_text(answer.status));
            return notes.about(self.address, Kind::Refused, text);
        }
        self.identify(prm.ident);
        self.described.parameterise();
        let watchdog_ms = watchdog_ms(&prm);
        let unit = self.tables.model.and_then(|model| model.user_prm(prm.user)).map(|known| known.unit_code());
        let unit = unit.and_then(|code| self.tables.model?.unit(code));
        self.tables.unit = unit.or(self.tables.unit);
        let (octets, words) = (request.du.clone(), String::new());
        self.prm = Parameters { octets, words, watchdog_ms, is_new: !releases(&prm) };
        let watchdog = watchdog_ms.map(|ms| format!("{ms} ms")).unwrap_or_default();
        let contents = set_prm_with_watchdog(&prm, &watchdog);
        let unit = unit.map(|unit| format!(" (unit {})", unit.name)).unwrap_or_default();
        let text = format!("master {} sets its parameters:{contents}{unit}", request.master);
        notes.about(self.address, Kind::StartUp, text);
        self.describe_parameters(notes);
    }

    fn configured(&mut self, request: &Request, answer: Answer<'_>, notes: &mut Notes<'_>) {
        if !answer.is_ack() {
            let text = format!("does not take Chk_Cfg of master {}: {}", request.master, status_text(answer.status));
            return notes.about(self.address, Kind::Refused, text);
        }
        self.requested_cfg.clone_from(&request.du);
        self.described.configure(&request.du);
        self.cfg_is_new = true;
        // Of the devices with this Ident_Number, the first that has this configuration.
        let known = self.candidates().find_map(|model| Some((model, model.configuration(&request.du)?)));
        self.tables.model = known.map(|(model, _)| model).or(self.tables.model);
        self.cyclic.configure(known.map(|(_, configuration)| configuration));
        let lengths = profivac_wire::cfg::lengths(&request.du);
        let lengths = lengths.map_or_else(
            |error| error.to_string(),
            |sum| format!("{} out, {} in", octets(sum.outputs.into()), sum.inputs),
        );
        let text = format!("master {} asks for the configuration {}: {lengths}", request.master, Hex(&request.du));
        notes.about(self.address, Kind::StartUp, text);
        self.describe_modules(notes);
    }

    /// Adds notes about the modules of the configuration, and about parameters of Set_Prm that had no meaning without the modules.
    fn describe_modules(&mut self, notes: &mut Notes<'_>) {
        let modules = self.described.modules_text(Extent::Changes);
        if modules.is_empty() {
            return;
        }
        notes.about(self.address, Kind::StartUp, format!("its modules by the GSD file: {modules}"));
        self.describe_parameters(notes);
    }

    /// Adds a note about the user parameters of the last Set_Prm, unless the last note says the same.
    fn describe_parameters(&mut self, notes: &mut Notes<'_>) {
        let Ok(prm) = SetPrm::parse(&self.prm.octets) else { return };
        let words = self.described.parameters_text(prm.user, Extent::Changes);
        if !words.is_empty() && words != self.prm.words {
            notes.about(self.address, Kind::StartUp, format!("its parameters by the GSD file: {words}"));
            self.prm.words = words;
        }
    }

    fn offers(&mut self, answer: Answer<'_>, notes: &mut Notes<'_>) {
        if !answer.du.is_empty() && self.offered_cfg.as_deref() != Some(answer.du) {
            self.offered_cfg = Some(answer.du.to_vec());
            notes.about(self.address, Kind::StartUp, format!("has the configuration {}", Hex(answer.du)));
            if self.requested_cfg.is_empty() {
                self.described.offer(answer.du);
                self.describe_modules(notes);
            }
        }
    }

    fn address_changed(&self, request: &Request, answer: Answer<'_>, notes: &mut Notes<'_>) {
        let Ok(wanted) = SetSlaveAdd::parse(&request.du) else { return };
        if answer.is_ack() {
            let lock = if wanted.no_add_chg == 0 { "" } else { ", permanently" };
            notes.about(self.address, Kind::StartUp, format!("accepts the address {}{lock}", wanted.address));
        } else {
            notes.about(
                self.address,
                Kind::Refused,
                format!("does not take another address: {}", status_text(answer.status)),
            );
        }
    }

    /// The format of the device-related blocks in its diagnosis.
    fn device_blocks(&self) -> DeviceBlocks {
        let by_tables = self.tables.model.map(|model| model.features.dpv1);
        self.dpv1.device_blocks(by_tables.or(self.described.dpv1_slave()))
    }

    /// All devices with its Ident_Number.
    fn candidates(&self) -> impl Iterator<Item = &'static Model> + use<> {
        let devices = self.described.devices();
        self.ident.into_iter().flat_map(move |ident| devices.with_ident(ident))
    }

    fn identify(&mut self, ident: u16) {
        self.described.identify(ident);
        if self.ident != Some(ident) {
            self.ident = Some(ident);
            let model = self.described.devices().assumed_with_ident(ident);
            self.tables = DeviceTables { model, ..DeviceTables::default() };
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
        let has_started = !self.prm.octets.is_empty() || !self.requested_cfg.is_empty();
        let words = (&self.tables, &self.described);
        self.cyclic.inputs(self.address, words, request, answer, has_started, notes)
    }
}

/// Whether Set_Prm releases the slave: Unlock_Req without Lock_Req.
fn releases(prm: &SetPrm<'_>) -> bool {
    prm.status.contains(PrmStatus::UNLOCK_REQ) && !prm.status.contains(PrmStatus::LOCK_REQ)
}

/// The watchdog time in ms. The first user parameter of a DP-V1 slave may change its time base (profibus-wire 2.4).
fn watchdog_ms(prm: &SetPrm<'_>) -> Option<u32> {
    let base = prm.user.first().map(|octet| Dpv1Status1::from_bits_retain(*octet));
    let base_ms = if base.is_some_and(|octet| octet.contains(Dpv1Status1::WD_BASE_1MS)) { 1 } else { 10 };
    let [first, second] = prm.wd_fact.map(u32::from);
    prm.status.contains(PrmStatus::WD_ON).then(|| first.saturating_mul(second).saturating_mul(base_ms))
}
