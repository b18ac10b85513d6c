//! The simple device for the real slave. What its octets are it has in common with the model; what is called when is the slave's.

use crate::slave_model::line::Driven;
use crate::slave_model::model::DeviceDiagnosis;
use crate::slave_model::process::{Process, Refusal, Simple, Via};
use crate::slave_model::tables::Table;
use profivac_dp::slave::{CfgFault, Device, Diagnosis, Dpv1Error, Features, Outputs, PrmFault, Relation};
use profivac_wire::acyclic::ErrorCode;
use profivac_wire::address::SetSlaveAdd;
use profivac_wire::cfg::Lengths;
use profivac_wire::ident::Ident;
use std::collections::BTreeMap;

/// What an access that takes time returns, and when.
type Pending = (u64, Result<Vec<u8>, Dpv1Error>);

/// The device.
#[derive(Clone, Debug)]
pub struct SimpleDevice {
    table: Table,
    content: Simple,
    configuration: usize,
    diagnosis: DeviceDiagnosis,
    changed: bool,
    now: u64,
    pending: BTreeMap<u16, Pending>,
}

impl SimpleDevice {
    /// As delivered.
    pub fn new(table: Table) -> Self {
        let configuration = table.default_configuration;
        let diagnosis = DeviceDiagnosis::default();
        Self {
            table,
            content: Simple::new(),
            configuration,
            diagnosis,
            changed: false,
            now: 0,
            pending: BTreeMap::new(),
        }
    }

    const fn key(via: Relation) -> u16 {
        match via {
            Relation::Ms1 => 256,
            Relation::Ms2(number) => number as u16,
        }
    }

    const fn class(via: Relation) -> Via {
        match via {
            Relation::Ms1 => Via::Ms1,
            Relation::Ms2(_) => Via::Ms2,
        }
    }

    /// Keeps what takes time.
    fn keep(&mut self, via: Relation, octets: Vec<u8>, delay: u64, record: &mut [u8]) -> usize {
        if delay != 0 {
            self.pending.insert(Self::key(via), (self.now + delay, Ok(octets)));
            return 0;
        }
        self.pending.remove(&Self::key(via));
        record[..octets.len()].copy_from_slice(&octets);
        octets.len()
    }
}

const fn error(refusal: Refusal) -> Dpv1Error {
    Dpv1Error::new(ErrorCode(refusal.0)).with(refusal.1)
}

impl Device for SimpleDevice {
    fn ident_number(&self) -> u16 {
        self.table.ident
    }

    fn features(&self) -> Features {
        let Table { sync, freeze, dpv1, ms1, .. } = self.table;
        Features { sync, freeze, dpv1, ms1 }
    }

    fn set_prm(&mut self, user: &[u8]) -> Result<(), PrmFault> {
        if self.table.takes_user_parameters(user) { Ok(()) } else { Err(PrmFault) }
    }

    fn chk_cfg(&mut self, cfg: &[u8]) -> Result<Lengths, CfgFault> {
        let position = self.table.configurations.iter().position(|it| it.octets == cfg).ok_or(CfgFault)?;
        self.configuration = position;
        let it = &self.table.configurations[position];
        let octets = |count: usize| u8::try_from(count).expect("244 at most");
        Ok(Lengths { outputs: octets(it.outputs), inputs: octets(it.inputs) })
    }

    fn get_cfg(&self) -> &[u8] {
        &self.table.configurations[self.configuration].octets
    }

    fn outputs(&mut self, outputs: Outputs<'_>) {
        self.content.outputs(match outputs {
            Outputs::Data(octets) => Some(octets),
            Outputs::Safe => None,
        });
    }

    fn inputs(&mut self, inputs: &mut [u8]) {
        inputs.copy_from_slice(&self.content.inputs(inputs.len()));
    }

    fn diagnosis(&self) -> Diagnosis<'_> {
        let DeviceDiagnosis { event, static_diag, ref blocks } = self.diagnosis;
        Diagnosis { event, static_diag, blocks }
    }

    fn take_diagnosis_change(&mut self) -> bool {
        std::mem::take(&mut self.changed)
    }

    fn address_is_settable(&self) -> bool {
        self.table.address_settable
    }

    fn set_address(&mut self, request: &SetSlaveAdd<'_>) -> Option<u8> {
        self.content.set_address(request.address, request.no_add_chg != 0).then_some(request.address)
    }

    fn read(&mut self, via: Relation, slot: u8, index: u8, record: &mut [u8]) -> Result<usize, Dpv1Error> {
        self.pending.remove(&Self::key(via));
        let (octets, delay) = self.content.read(&self.table, Self::class(via), slot, index).map_err(error)?;
        Ok(self.keep(via, octets, delay, record))
    }

    fn write(&mut self, via: Relation, slot: u8, index: u8, record: &[u8]) -> Result<(), Dpv1Error> {
        self.pending.remove(&Self::key(via));
        let delay = self.content.write(&self.table, Self::class(via), slot, index, record).map_err(error)?;
        self.keep(via, Vec::new(), delay, &mut []);
        Ok(())
    }

    fn is_executing(&self, via: Relation) -> bool {
        self.pending.get(&Self::key(via)).is_some_and(|(until, _)| self.now < *until)
    }

    fn complete(&mut self, via: Relation, record: &mut [u8]) -> Result<usize, Dpv1Error> {
        let Some((_, result)) = self.pending.remove(&Self::key(via)) else { return Ok(0) };
        let octets = result?;
        record[..octets.len()].copy_from_slice(&octets);
        Ok(octets.len())
    }

    fn im0(&self) -> Option<[u8; 64]> {
        self.table.im0
    }

    fn ident(&self) -> Option<Ident<'_>> {
        let [vendor, controller, hardware, software] = self.table.ident_strings.as_ref()?;
        let (vendor, controller) = (vendor.as_bytes(), controller.as_bytes());
        Some(Ident { vendor, controller, hardware: hardware.as_bytes(), software: software.as_bytes() })
    }
}

impl Driven for SimpleDevice {
    type Process = Simple;

    fn set_time(&mut self, now: u64) {
        self.now = now;
    }

    fn set_diagnosis(&mut self, diagnosis: DeviceDiagnosis) {
        self.diagnosis = diagnosis;
        self.changed = true;
    }

    fn show(&self, _process: &mut Simple) {}
}
