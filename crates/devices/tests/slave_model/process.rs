//! The application behind the model: what the octets of inputs and records are.

use crate::slave_model::tables::Table;
use fastrand::Rng;
use std::collections::BTreeMap;

/// Error_Code_1 and Error_Code_2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refusal(pub u8, pub u8);

/// The class of the master of an acyclic access.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Via {
    Ms1,
    Ms2,
}

/// The application as the model calls it.
pub trait Process: Clone {
    /// User parameters; false is Prm_Fault.
    fn set_prm(&mut self, table: &Table, user: &[u8]) -> bool {
        table.takes_user_parameters(user)
    }
    /// The place of a configuration that the device takes now.
    fn chk_cfg(&mut self, table: &Table, octets: &[u8]) -> Option<usize> {
        table.configurations.iter().position(|it| it.octets == octets)
    }
    /// Data_Exch begins.
    fn begin_exchange(&mut self) {}
    /// Data_Exch ends.
    fn end_exchange(&mut self) {}
    /// Device time passes until everything is done.
    fn settle(&mut self) {}
    /// Outputs reach the process; `None` is the safe state.
    fn outputs(&mut self, outputs: Option<&[u8]>);
    /// The inputs.
    fn inputs(&mut self, length: usize) -> Vec<u8>;
    /// The next inputs are those before the telegram, whose end the device has seen by now.
    fn rewind(&mut self) {}
    /// Stores a station address; false if the address is locked.
    fn set_address(&mut self, address: u8, lock: bool) -> bool;
    /// A record, and the bit times until it is there.
    fn read(&mut self, table: &Table, via: Via, slot: u8, index: u8) -> Result<(Vec<u8>, u64), Refusal>;
    /// Writes a record; returns the bit times until that is done.
    fn write(&mut self, table: &Table, via: Via, slot: u8, index: u8, data: &[u8]) -> Result<u64, Refusal>;
    /// A Read or Write that suits the tables of the device.
    fn suggested_access(&self, _random: &mut Rng) -> Option<Vec<u8>> {
        None
    }
    /// Outputs that suit them.
    fn suggested_outputs(&self, _random: &mut Rng, _length: usize) -> Option<Vec<u8>> {
        None
    }
    /// Counts of the instructions and errors that came.
    fn reached(&self) -> BTreeMap<&'static str, u64> {
        BTreeMap::new()
    }
    /// Index 255 of a device without I&M.
    fn no_im0(&self, _table: &Table, _slot: u8, _read: bool) -> Refusal {
        Refusal(0xB0, 0)
    }
}

/// Bit times that the slow records of the simple device take: 0.2 s, and 5 s.
pub const SLOW: [u64; 2] = [300_000, 7_500_000];

/// The simple device: inputs follow the outputs, slot 1 has records.
#[derive(Clone, Debug)]
pub struct Simple {
    outputs: Option<Vec<u8>>,
    record: Vec<u8>,
    locked: bool,
}

impl Simple {
    /// As delivered.
    pub const fn new() -> Self {
        Self { outputs: None, record: Vec::new(), locked: false }
    }
}

impl Process for Simple {
    fn outputs(&mut self, outputs: Option<&[u8]>) {
        self.outputs = outputs.map(<[u8]>::to_vec);
    }

    fn inputs(&mut self, length: usize) -> Vec<u8> {
        let outputs = self.outputs.as_deref();
        (0..length).map(|it| outputs.map_or(0xFE, |all| all.get(it).map_or(0x11, |octet| octet ^ 0x5A))).collect()
    }

    fn set_address(&mut self, _address: u8, lock: bool) -> bool {
        let free = !self.locked;
        self.locked |= lock;
        free
    }

    fn read(&mut self, _: &Table, _: Via, slot: u8, index: u8) -> Result<(Vec<u8>, u64), Refusal> {
        match (slot, index) {
            (1, 0) => Ok((self.record.clone(), 0)),
            (1, 1) => Ok(((0..240).collect(), 0)),
            (1, 2) => Err(Refusal(0xB6, 9)),
            (1, 3) => Err(Refusal(0xA2, 7)),
            (1, 4) => Ok((vec![1, 2, 3], SLOW[0])),
            (1, 5) => Ok((vec![4; 20], SLOW[1])),
            (1, _) => Err(Refusal(0xB0, 0)),
            _ => Err(Refusal(0xB2, 0)),
        }
    }

    fn write(&mut self, _: &Table, _: Via, slot: u8, index: u8, data: &[u8]) -> Result<u64, Refusal> {
        match (slot, index, data) {
            (1, 0, [0xEE, ..]) => Err(Refusal(0xB7, 1)),
            (1, 0, _) if data.len() > 8 => Err(Refusal(0xB1, 8)),
            (1, 0, _) => {
                self.record = data.to_vec();
                Ok(0)
            }
            (1, 2, _) => Ok(0),
            (1, 4, _) => Ok(SLOW[0]),
            (1, 5, _) => Ok(SLOW[1]),
            (1, 1 | 3, _) => Err(Refusal(0xB6, 2)),
            (1, _, _) => Err(Refusal(0xB0, 0)),
            _ => Err(Refusal(0xB2, 0)),
        }
    }
}
