//! The device of the slave: two octets each way, a few records, and a log of the calls.

use profivac_dp::link::Baud;
use profivac_dp::slave::{CfgFault, Device, Diagnosis, Dpv1Error, Features, Outputs, PrmFault, Relation};
use profivac_wire::acyclic::{AlarmAck, Im0};
use profivac_wire::address::SetSlaveAdd;
use profivac_wire::cfg::{self, Lengths};
use profivac_wire::ident::Ident;
use std::collections::BTreeMap;

/// A call of the slave to the device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Seen {
    Prm(Vec<u8>),
    Exchanging(bool),
    Outputs(Vec<u8>),
    Safe,
    Read(Relation, u8, u8),
    Write(Relation, u8, u8, Vec<u8>),
}

/// A device with everything, whose answers a test sets.
#[derive(Clone, Debug)]
pub struct Gauge {
    pub features: Features,
    /// Instead of those that follow from the features.
    pub ms2: Option<bool>,
    pub fail_safe: bool,
    pub max_tsdr_tbit: Option<u16>,
    pub inputs: Vec<u8>,
    pub configurations: Vec<Vec<u8>>,
    pub cfg: Vec<u8>,
    /// Instead of the lengths of the configuration.
    pub lengths: Option<cfg::Lengths>,
    pub prm_ok: bool,
    pub records: BTreeMap<(u8, u8), Vec<u8>>,
    pub im0: Option<[u8; 64]>,
    pub ident: bool,
    pub event: bool,
    pub static_diag: bool,
    pub blocks: Vec<u8>,
    pub changed: bool,
    pub settable: bool,
    pub no_add_chg: bool,
    /// Data are exchanged.
    pub running: bool,
    /// Whether the outputs come from a master; otherwise they are safe.
    pub driven: bool,
    /// The slave may prepare its answers.
    pub keeps_inputs: bool,
    /// The alarm that waits for its acknowledgement.
    pub alarm: Option<AlarmAck>,
    /// Extra_Alarm_SAP_supp.
    pub alarm_access_point: bool,
    /// How often the owner has fetched the diagnosis.
    pub fetched: usize,
    /// The inputs follow the outputs of the same request.
    pub echo: bool,
    /// How often the slave has collected the inputs.
    pub collected: usize,
    pub seen: Vec<Seen>,
}

impl Default for Gauge {
    fn default() -> Self {
        let im0 = Im0 {
            header: [b' '; 10],
            manufacturer_id: 0x0123,
            order_id: b"DEMO-1",
            serial_number: b"000042",
            hardware_revision: 1,
            software_revision: [b'V', 1, 2, 3],
            rev_counter: 0,
            profile_id: 0,
            profile_specific_type: 0,
            im_version: [1, 1],
            im_supported: 0,
        };
        let mut record = [0; 64];
        im0.emit(&mut record).expect("64 octets");
        let records = [((1, 16), vec![0x11, 0x22, 0x33, 0x44]), ((0, 16), vec![0xDE, 0xAD, 0xBE, 0xEF])];
        Self {
            features: Features { sync: true, freeze: true, dpv1: true, ms1: true },
            ms2: None,
            fail_safe: false,
            max_tsdr_tbit: None,
            inputs: vec![1, 2],
            configurations: vec![vec![0x11, 0x21]],
            cfg: vec![0x11, 0x21],
            lengths: None,
            prm_ok: true,
            records: BTreeMap::from(records),
            im0: Some(record),
            ident: true,
            event: false,
            static_diag: false,
            blocks: Vec::new(),
            changed: false,
            settable: true,
            no_add_chg: false,
            running: false,
            driven: false,
            keeps_inputs: true,
            alarm: None,
            alarm_access_point: false,
            fetched: 0,
            echo: false,
            collected: 0,
            seen: Vec::new(),
        }
    }
}

impl Device for Gauge {
    fn ident_number(&self) -> u16 {
        0x1234
    }

    fn features(&self) -> Features {
        self.features
    }

    fn has_ms2(&self) -> bool {
        self.ms2.unwrap_or(self.features.dpv1)
    }

    fn is_fail_safe(&self) -> bool {
        self.fail_safe
    }

    fn max_tsdr_tbit(&self, baud: Baud) -> u16 {
        self.max_tsdr_tbit.unwrap_or(baud.max_tsdr_tbit())
    }

    fn set_prm(&mut self, user: &[u8]) -> Result<(), PrmFault> {
        self.seen.push(Seen::Prm(user.to_vec()));
        if self.prm_ok { Ok(()) } else { Err(PrmFault) }
    }

    fn chk_cfg(&mut self, cfg: &[u8]) -> Result<Lengths, CfgFault> {
        if !self.configurations.iter().any(|known| known == cfg) {
            return Err(CfgFault);
        }
        self.cfg = cfg.to_vec();
        self.lengths.map_or_else(|| cfg::lengths(cfg).map_err(|_| CfgFault), Ok)
    }

    fn get_cfg(&self) -> &[u8] {
        &self.cfg
    }

    fn set_exchanging(&mut self, running: bool) {
        self.running = running;
        self.seen.push(Seen::Exchanging(running));
    }

    fn outputs(&mut self, outputs: Outputs<'_>) {
        self.driven = matches!(outputs, Outputs::Data(_));
        if self.echo {
            self.inputs = match outputs {
                Outputs::Data(data) => data.to_vec(),
                Outputs::Safe => vec![0xEE; self.inputs.len()],
            };
        }
        self.seen.push(match outputs {
            Outputs::Data(data) => Seen::Outputs(data.to_vec()),
            Outputs::Safe => Seen::Safe,
        });
    }

    fn inputs(&mut self, inputs: &mut [u8]) {
        self.collected += 1;
        for (target, input) in inputs.iter_mut().zip(&self.inputs) {
            *target = *input;
        }
    }

    fn keeps_inputs(&self, before: &[u8], outputs: &[u8]) -> bool {
        self.keeps_inputs && (!self.echo || before == outputs)
    }

    fn diagnosis(&self) -> Diagnosis<'_> {
        Diagnosis { event: self.event, static_diag: self.static_diag, blocks: &self.blocks }
    }

    fn take_diagnosis_change(&mut self) -> bool {
        std::mem::take(&mut self.changed)
    }

    fn diagnosis_fetched(&mut self) {
        self.fetched += 1;
    }

    fn acknowledge_alarm(&mut self, alarm: AlarmAck) -> bool {
        self.alarm.take_if(|waiting| *waiting == alarm).is_some()
    }

    fn has_alarm_access_point(&self) -> bool {
        self.alarm_access_point
    }

    fn address_is_settable(&self) -> bool {
        self.settable
    }

    fn set_address(&mut self, request: &SetSlaveAdd<'_>) -> Option<u8> {
        if self.no_add_chg {
            return None;
        }
        self.no_add_chg = request.no_add_chg != 0;
        Some(request.address)
    }

    fn read(&mut self, via: Relation, slot: u8, index: u8, record: &mut [u8]) -> Result<usize, Dpv1Error> {
        self.seen.push(Seen::Read(via, slot, index));
        if slot > 1 {
            return Err(Dpv1Error::INVALID_SLOT);
        }
        let known = self.records.get(&(slot, index)).ok_or(Dpv1Error::INVALID_INDEX)?;
        record[..known.len()].copy_from_slice(known);
        Ok(known.len())
    }

    fn write(&mut self, via: Relation, slot: u8, index: u8, record: &[u8]) -> Result<(), Dpv1Error> {
        self.seen.push(Seen::Write(via, slot, index, record.to_vec()));
        let known = self.records.get_mut(&(slot, index)).ok_or(Dpv1Error::ACCESS_DENIED)?;
        if record.len() > known.len() {
            return Err(Dpv1Error::WRITE_LENGTH);
        }
        *known = record.to_vec();
        Ok(())
    }

    fn im0(&self) -> Option<[u8; 64]> {
        self.im0
    }

    fn ident(&self) -> Option<Ident<'_>> {
        let ident = Ident { vendor: b"AB", controller: b"CDE", hardware: b"F", software: b"" };
        self.ident.then_some(ident)
    }
}
