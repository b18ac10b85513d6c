//! Answers, and the stations that they show.

use super::{Observer, is_acyclic};
use crate::event::Change;
use crate::station::Station;
use profivac_dp::link::BitTime;
use profivac_explain::cycle::{Answer, Request};
use profivac_explain::frame::TimeSource;
use profivac_wire::acyclic::Response;
use profivac_wire::control::{StationType, Status};
use profivac_wire::{DataTelegram, Sap};

impl Observer {
    pub(super) fn short_ack(&mut self, start: BitTime) {
        if let Some(slave) = self.pending.take() {
            self.finish(slave, Answer { status: Status::Ok, du: &[] }, start);
        }
    }

    pub(super) fn response(&mut self, data: &DataTelegram<'_>, station: StationType, status: Status, start: BitTime) {
        self.forget_damaged_request();
        if station != StationType::Slave {
            self.master_heard(data.sa, start);
        }
        if self.pending_status == Some((data.da, data.sa)) {
            self.pending_status = None;
            self.heard(data.sa, start);
            return;
        }
        let is_answer = self
            .pending
            .and_then(|slave| self.station(slave)?.last.as_ref())
            .is_some_and(|last| last.request.is_answered_by(data));
        if is_answer && let Some(slave) = self.pending.take() {
            self.finish(slave, Answer { status, du: data.du }, start);
        } else if self.station(data.sa).is_some() {
            if self.open != Some(data.sa) {
                // The request was not received: the next one may look like a repetition.
                self.damage_epoch = self.damage_epoch.saturating_add(1);
            }
            self.heard(data.sa, start);
        }
    }

    /// Records that a station sent something.
    pub(super) fn heard(&mut self, address: u8, start: BitTime) {
        let Some(station) = self.station_mut(address) else { return };
        let is_new = station.heard_at.replace(start).is_none();
        let unanswered = std::mem::take(&mut station.unanswered_in_a_row);
        let was_lost = std::mem::take(&mut station.is_reported_lost);
        if was_lost {
            self.event(Some(address), Change::Returned { unanswered });
        } else if is_new {
            self.event(Some(address), Change::Appeared);
        }
    }

    pub(super) fn finish(&mut self, slave: u8, answer: Answer<'_>, start: BitTime) {
        self.heard(slave, start);
        let Some(station) = self.station_mut(slave) else { return };
        let Some(mut last) = station.last.take() else { return };
        last.is_answered = true;
        self.open = self.open.filter(|open| *open != slave);
        self.attribute_disturbances(slave);
        if is_refusal(&last.request, answer) {
            self.count(slave, |counts| counts.refused = counts.refused.saturating_add(1));
        }
        self.take_answer(slave, &last.request, answer, start);
        let tsdr = (self.times == TimeSource::Exact && self.damage_end.is_none()).then(|| start - self.asked_end);
        if let Some(station) = self.station_mut(slave) {
            station.longest_tsdr = station.longest_tsdr.max(tsdr);
            station.last = Some(last);
        }
    }

    /// Takes the contents of an answer.
    fn take_answer(&mut self, slave: u8, request: &Request, answer: Answer<'_>, start: BitTime) {
        if request.sap == Sap::Default {
            return self.exchanged(slave, request, answer, start);
        }
        let Some(station) = self.station_mut(slave) else { return };
        let before = station.device_blocks();
        station.dpv1.answered(request, answer);
        match request.sap {
            Sap::SlaveDiag => self.diagnosed(slave, answer.du),
            Sap::SetPrm if answer.is_ack() => self.parameterised(slave, request),
            Sap::ChkCfg if answer.is_ack() => self.configured(slave, request.master, &request.du),
            Sap::GetCfg if !answer.du.is_empty() => {
                if let Some(station) = self.station_mut(slave) {
                    station.described.offer(answer.du);
                    station.knowledge.configure(answer.du);
                }
                self.report_contradictions(slave);
            }
            sap if is_acyclic(sap) => self.record_answered(slave, request, answer.du, start),
            _ => {}
        }
        // The words of a diagnosis depend on the format of its blocks, and with a GSD file on the modules.
        let is_configured = matches!(request.sap, Sap::ChkCfg | Sap::GetCfg);
        let is_other =
            |station: &&mut Station| station.device_blocks() != before || is_configured && station.described.is_known();
        if let Some(station) = self.station_mut(slave).filter(is_other) {
            station.reword_diagnosis();
        }
    }
}

/// Whether the answer refuses: UE, RR, RS, RDL, RDH, or a negative response of DP-V1.
fn is_refusal(request: &Request, answer: Answer<'_>) -> bool {
    answer.is_refusal()
        || matches!(answer.status, Status::DataLowNotTaken | Status::DataHighNotTaken)
        || (is_acyclic(request.sap) && matches!(Response::parse(answer.du), Ok(Response::Negative(_))))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test")]

    use super::*;
    use profivac_dp::link::{Baud, CHARACTER_TBIT};
    use profivac_explain::frame::{Piece, PieceKind};
    use profivac_explain::gsd::{Files, Seen};
    use profivac_gsd::GsdFile;
    use profivac_wire::{MAX_TELEGRAM, Telegram};
    use std::sync::Arc;

    const FILE: &[u8] = b"#Profibus_DP\nIdent_Number = 0xAAAB\n500_supp = 1\nMaxTsdr_500 = 29\n";

    /// The slave answers Slave_Diag 30 bit times after the end of the request.
    fn observed(times: TimeSource) -> Observer {
        let file = Arc::new(GsdFile::read(FILE));
        let mut observer = Observer::new(Baud::B500000, times).with_gsd(Files::new([file]));
        let mut at = BitTime(1000);
        let mut send = |data: DataTelegram<'_>| {
            let mut out = [0; MAX_TELEGRAM];
            let length = Telegram::Data(data).emit(&mut out).unwrap();
            let octets = out.get(..length).unwrap().to_vec();
            observer.piece(&Piece { start: Some(at), octets, errors: Vec::new(), kind: PieceKind::Valid });
            at = at + (length as u64 * CHARACTER_TBIT + 30);
        };
        send(DataTelegram { da: 5, sa: 2, dsap: Some(60), ssap: Some(62), fc: 0x6D, du: &[] });
        send(DataTelegram { da: 2, sa: 5, dsap: Some(62), ssap: Some(60), fc: 0x08, du: &[0, 0x0C, 0, 2, 0xAA, 0xAB] });
        observer
    }

    #[test]
    fn an_answer_that_is_later_than_the_gsd_file_says_is_found_with_exact_times_alone() {
        let observer = observed(TimeSource::Exact);
        let station = observer.station(5).unwrap();
        assert_eq!(station.longest_tsdr, Some(30));
        let seen = Seen { bits_per_second: Some(500_000), longest_tsdr: station.longest_tsdr, ..Seen::default() };
        let found: Vec<_> = station.described.mismatches(&seen).into_iter().map(|one| one.found).collect();
        assert_eq!(found, ["an answer began 30 bit times after its request, MaxTsdr is 29"]);
        assert_eq!(observed(TimeSource::Platform).station(5).unwrap().longest_tsdr, None);
    }
}
