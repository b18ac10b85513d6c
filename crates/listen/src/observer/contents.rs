//! The contents of services: cyclic data, diagnosis, parameters and configuration.

use super::Observer;
use super::requests::Sent;
use crate::event::{Change, Comparison};
use crate::parameters::{Done, Passed};
use crate::station::{Diagnosis, MAX_DIAGNOSES, Station};
use profivac_dp::link::BitTime;
use profivac_explain::cycle::{Answer, Request};
use profivac_explain::names::DeviceTables;
use profivac_explain::slave::diagnosis_reports;
use profivac_wire::Sap;
use profivac_wire::control::Status;
use profivac_wire::diag::{NO_MASTER, SlaveDiag};
use profivac_wire::prm::SetPrm;

impl Observer {
    /// Records the contents of a request.
    pub(super) fn note_contents(&mut self, sent: &Sent<'_>, is_first: bool) {
        let (data, slave) = (sent.data, sent.data.da);
        if sent.sap == Sap::Default && is_first {
            self.cycle_request(data.sa, slave, sent.start);
        }
        let Some(station) = self.station_mut(slave) else { return };
        match sent.sap {
            Sap::Default => {
                if has_channel(station)
                    && let Some(telegram) = station.knowledge.layout().and_then(|configuration| configuration.outputs)
                {
                    station.parameters.outputs(telegram, data.sa, data.du);
                }
            }
            Sap::Ms1 | Sap::Ms2(_) => {
                if let Some(last) = &station.last {
                    station.parameters.request(&last.request);
                }
            }
            _ => {}
        }
    }

    pub(super) fn exchanged(&mut self, slave: u8, request: &Request, answer: Answer<'_>, start: BitTime) {
        let is_valid = matches!(answer.status, Status::Ok | Status::DataLow | Status::DataHigh | Status::NoReply);
        let Some(station) = self.station_mut(slave) else { return };
        station.is_exchanging = is_valid;
        if !is_valid {
            if !std::mem::replace(&mut station.refuses_exchange, true) {
                self.event(Some(slave), Change::ExchangeRefused(answer.status));
            }
            return;
        }
        station.refuses_exchange = false;
        station.knowledge.exchange(request.du.len(), answer.du, start);
        let layout = if has_channel(station) { station.knowledge.layout() } else { None };
        let inputs = layout.and_then(|configuration| configuration.inputs);
        let tables = station.tables;
        let passed =
            inputs.and_then(|telegram| station.parameters.inputs(telegram, &tables, answer.du, start)).cloned();
        self.count(slave, |counts| counts.exchanges = counts.exchanges.saturating_add(1));
        if let Some(passed) = passed {
            self.learn(slave, &passed);
        }
    }

    pub(super) fn diagnosed(&mut self, slave: u8, du: &[u8]) {
        self.count(slave, |counts| counts.diagnoses = counts.diagnoses.saturating_add(1));
        let now = self.now;
        let Some(station) = self.station_mut(slave) else { return };
        if station.diagnosis_octets == du {
            return;
        }
        let Ok(diag) = SlaveDiag::parse(du) else { return };
        if station.knowledge.ident() == Some(diag.ident) {
            // The words for the format that this diagnosis shows: they are no change of the contents.
            station.reword_diagnosis();
        }
        station.diagnosis_octets.clear();
        station.diagnosis_octets.extend_from_slice(du);
        station.status = Some(diag.status);
        let owner = station.owner.replace(diag.master_add);
        identify(station, diag.ident);
        let reports = diagnosis_reports(&diag, station.device_blocks(), &station.described);
        let is_report = station.diagnoses.back().map_or(!reports.is_empty(), |before| before.reports != reports);
        if station.diagnoses.back().is_none_or(|before| before.reports != reports) {
            if station.diagnoses.len() >= MAX_DIAGNOSES {
                station.diagnoses.pop_front();
            }
            station.diagnoses.push_back(Diagnosis { at: now, reports: reports.clone() });
        }
        if owner.is_some_and(|owner| owner != diag.master_add) {
            let owner = Some(diag.master_add).filter(|owner| *owner != NO_MASTER);
            self.event(Some(slave), Change::Owner(owner));
        }
        if is_report {
            self.event(Some(slave), Change::Diagnosis(reports));
        }
    }

    pub(super) fn parameterised(&mut self, slave: u8, request: &Request) {
        let Ok(prm) = SetPrm::parse(&request.du) else { return };
        let Some(station) = self.station_mut(slave) else { return };
        identify(station, prm.ident);
        station.described.parameterise();
        station.knowledge.parameterise(prm.user);
        station.tables.unit = station
            .knowledge
            .model()
            .and_then(|(model, _)| model.user_prm(prm.user))
            .and_then(|known| station.tables.model?.unit(known.unit_code()))
            .or(station.tables.unit);
        let comparison = match &station.set_prm {
            before if before.is_empty() => Comparison::First,
            before if *before == request.du => Comparison::Same,
            _ => Comparison::Other,
        };
        station.set_prm.clone_from(&request.du);
        let (master, octets) = (request.master, request.du.clone());
        self.event(Some(slave), Change::Parameterised { master, octets, comparison });
        self.report_contradictions(slave);
    }

    /// Reports what the file says otherwise than the line, once until it changes.
    pub(super) fn report_contradictions(&mut self, slave: u8) {
        let Some(station) = self.station_mut(slave).filter(|station| station.knowledge.is_declared()) else { return };
        let now = station.knowledge.contradictions();
        let before = std::mem::replace(&mut station.contradictions, now.clone());
        for new in now.into_iter().filter(|contradiction| !before.contains(contradiction)) {
            self.event(Some(slave), Change::Contradiction(new));
        }
    }

    pub(super) fn configured(&mut self, slave: u8, master: u8, du: &[u8]) {
        let Some(station) = self.station_mut(slave) else { return };
        station.described.configure(du);
        let is_first = station.knowledge.heard_configuration().is_empty();
        let is_new = station.knowledge.configure(du);
        station.tables.model = station.knowledge.model().map(|(model, _)| model).or(station.tables.model);
        if is_new {
            self.event(Some(slave), Change::Configured { master, octets: du.to_vec(), is_first });
        }
        self.report_contradictions(slave);
    }

    pub(super) fn record_answered(&mut self, slave: u8, request: &Request, du: &[u8], start: BitTime) {
        let Some(station) = self.station_mut(slave) else { return };
        let passed = station.parameters.answer(request, du, start).cloned();
        if let Some(passed) = passed {
            self.learn(slave, &passed);
        }
    }

    /// Takes a value that changes the meaning of others, and reports a write.
    pub(super) fn learn(&mut self, slave: u8, passed: &Passed) {
        let Some(station) = self.station_mut(slave) else { return };
        let (slot, index) = passed.location;
        if passed.done != Done::Refused {
            let before = station.tables.unit.map(|unit| unit.code);
            station.tables.learn(slot, index, &passed.octets);
            if let Some(unit) = station.tables.unit.filter(|unit| Some(unit.code) != before) {
                station.knowledge.learn_unit(unit.code);
            }
        }
        if passed.done == Done::Written {
            let (name, value) = self.parameter_text(slave, passed);
            let (master, path) = (passed.requester, passed.path);
            self.event(Some(slave), Change::Written { master, name, value, path });
        }
        self.report_contradictions(slave);
    }
}

/// Takes Ident_Number, and the tables of the device.
fn identify(station: &mut Station, ident: u16) {
    station.described.identify(ident);
    if station.knowledge.ident() == Some(ident) {
        return;
    }
    station.knowledge.identify(ident);
    let model = station.knowledge.model().map(|(model, _)| model);
    if model.map(|model| model.name) != station.tables.model.map(|model| model.name) {
        station.tables = DeviceTables { model, ..DeviceTables::default() };
    }
}

/// Whether the device has a parameter channel at all: all others need no look into their images.
fn has_channel(station: &Station) -> bool {
    station.tables.model.is_some_and(|model| !model.channel_rules.tasks.is_empty())
}
