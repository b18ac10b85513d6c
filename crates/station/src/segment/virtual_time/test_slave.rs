//! A slave by a GSD file for tests: it takes parameters and configuration of the file, and shows what it got.

use profivac_dp::slave::{CfgFault, Device, Diagnosis, Dpv1Error, Features, Outputs, PrmFault, Relation};
use profivac_gsd_slave::GsdSlave;
use profivac_wire::cfg::{self, Lengths};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard};

/// What a test sets and sees.
#[derive(Default)]
pub struct TestState {
    pub inputs: Vec<u8>,
    /// The outputs of each exchange that differ from those before; `None` for the safe state.
    pub outputs: Vec<Option<Vec<u8>>>,
    pub user_prm: Option<Vec<u8>>,
    /// The DP-V1 records by slot and index. A slave without any has no MS2.
    pub records: BTreeMap<(u8, u8), Vec<u8>>,
    /// The next diagnosis has these blocks.
    pub blocks: Vec<u8>,
    pub has_changed: bool,
}

#[derive(Clone)]
pub struct TestSlave {
    pub address: u8,
    gsd: Arc<GsdSlave>,
    state: Arc<Mutex<TestState>>,
    /// The blocks of the present diagnosis.
    blocks: Vec<u8>,
}

impl TestSlave {
    pub fn new(address: u8, gsd: &Arc<GsdSlave>) -> Self {
        let state = TestState { inputs: vec![0; gsd.lengths().inputs.into()], ..TestState::default() };
        Self { address, gsd: Arc::clone(gsd), state: Arc::new(Mutex::new(state)), blocks: Vec::new() }
    }

    pub fn state(&self) -> MutexGuard<'_, TestState> {
        self.state.lock().unwrap()
    }

    pub fn report(&self, blocks: &[u8]) {
        let mut state = self.state();
        (state.blocks, state.has_changed) = (blocks.to_vec(), true);
    }

    fn note(&self, outputs: Option<Vec<u8>>) {
        let mut state = self.state();
        if state.outputs.last() != Some(&outputs) {
            state.outputs.push(outputs);
        }
    }
}

impl Device for TestSlave {
    fn ident_number(&self) -> u16 {
        self.gsd.ident()
    }

    fn features(&self) -> Features {
        Features::default()
    }

    fn has_ms2(&self) -> bool {
        !self.state().records.is_empty()
    }

    fn read(&mut self, _via: Relation, slot: u8, index: u8, record: &mut [u8]) -> Result<usize, Dpv1Error> {
        let state = self.state();
        let octets = state.records.get(&(slot, index)).ok_or(Dpv1Error::INVALID_INDEX)?;
        record[..octets.len()].copy_from_slice(octets);
        Ok(octets.len())
    }

    fn set_prm(&mut self, user: &[u8]) -> Result<(), PrmFault> {
        self.state().user_prm = Some(user.to_vec());
        Ok(())
    }

    fn chk_cfg(&mut self, octets: &[u8]) -> Result<Lengths, CfgFault> {
        if octets == self.gsd.chk_cfg() { cfg::lengths(octets).map_err(|_| CfgFault) } else { Err(CfgFault) }
    }

    fn get_cfg(&self) -> &[u8] {
        self.gsd.chk_cfg()
    }

    fn outputs(&mut self, outputs: Outputs<'_>) {
        self.note(match outputs {
            Outputs::Data(octets) => Some(octets.to_vec()),
            Outputs::Safe => None,
        });
    }

    fn inputs(&mut self, inputs: &mut [u8]) {
        inputs.copy_from_slice(&self.state().inputs);
    }

    fn diagnosis(&self) -> Diagnosis<'_> {
        Diagnosis { event: !self.blocks.is_empty(), static_diag: false, blocks: &self.blocks }
    }

    fn take_diagnosis_change(&mut self) -> bool {
        let mut state = self.state.lock().unwrap();
        self.blocks = state.blocks.clone();
        std::mem::take(&mut state.has_changed)
    }
}
