//! A plain device: the test sets its inputs and reads its outputs.

use profivac_dp::slave::{CfgFault, Device, Diagnosis, Dpv1Error, Features, Outputs, PrmFault, Relation};
use profivac_wire::cfg::{self, Lengths};

#[derive(Clone, Debug)]
pub struct Plain {
    pub ident: u16,
    pub cfg: Vec<u8>,
    pub inputs: Vec<u8>,
    /// The last outputs; `None` is the safe state.
    pub outputs: Option<Vec<u8>>,
    pub user_prm: Vec<u8>,
    pub blocks: Vec<u8>,
    pub static_diag: bool,
    /// The blocks have changed.
    pub changed: bool,
    pub accepts_prm: bool,
    pub address_is_settable: bool,
    pub features: Features,
    /// The record at 1/16.
    pub record: Vec<u8>,
}

impl Plain {
    pub fn new(ident: u16, cfg: &[u8]) -> Self {
        let lengths = cfg::lengths(cfg).unwrap();
        Self {
            ident,
            cfg: cfg.to_vec(),
            inputs: vec![0; lengths.inputs.into()],
            outputs: None,
            user_prm: Vec::new(),
            blocks: Vec::new(),
            static_diag: false,
            changed: false,
            accepts_prm: true,
            address_is_settable: false,
            features: Features { sync: true, freeze: true, dpv1: false, ms1: false },
            record: Vec::new(),
        }
    }

    /// A diagnosis event begins; without blocks it ends.
    pub fn diagnose(&mut self, blocks: &[u8]) {
        self.blocks = blocks.to_vec();
        self.changed = true;
    }
}

impl Device for Plain {
    fn ident_number(&self) -> u16 {
        self.ident
    }

    fn features(&self) -> Features {
        self.features
    }

    fn set_prm(&mut self, user: &[u8]) -> Result<(), PrmFault> {
        self.user_prm = user.to_vec();
        if self.accepts_prm { Ok(()) } else { Err(PrmFault) }
    }

    fn chk_cfg(&mut self, cfg: &[u8]) -> Result<Lengths, CfgFault> {
        if cfg == self.cfg { cfg::lengths(cfg).map_err(|_| CfgFault) } else { Err(CfgFault) }
    }

    fn get_cfg(&self) -> &[u8] {
        &self.cfg
    }

    fn outputs(&mut self, outputs: Outputs<'_>) {
        self.outputs = match outputs {
            Outputs::Data(data) => Some(data.to_vec()),
            Outputs::Safe => None,
        };
    }

    fn inputs(&mut self, inputs: &mut [u8]) {
        inputs.copy_from_slice(&self.inputs);
    }

    fn diagnosis(&self) -> Diagnosis<'_> {
        Diagnosis { event: !self.blocks.is_empty(), static_diag: self.static_diag, blocks: &self.blocks }
    }

    fn take_diagnosis_change(&mut self) -> bool {
        std::mem::take(&mut self.changed)
    }

    fn address_is_settable(&self) -> bool {
        self.address_is_settable
    }

    fn set_address(&mut self, request: &profivac_wire::address::SetSlaveAdd<'_>) -> Option<u8> {
        Some(request.address)
    }

    fn read(&mut self, _: Relation, slot: u8, index: u8, record: &mut [u8]) -> Result<usize, Dpv1Error> {
        if (slot, index) != (1, 16) {
            return Err(Dpv1Error::INVALID_INDEX);
        }
        record[..self.record.len()].copy_from_slice(&self.record);
        Ok(self.record.len())
    }

    fn write(&mut self, _: Relation, slot: u8, index: u8, record: &[u8]) -> Result<(), Dpv1Error> {
        if (slot, index) != (1, 16) {
            return Err(Dpv1Error::INVALID_INDEX);
        }
        self.record = record.to_vec();
        Ok(())
    }
}
