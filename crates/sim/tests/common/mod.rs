//! A plain device and requests to it, for the tests of this folder.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "this is test code")]

use profivac_dp::link::Baud;
use profivac_dp::slave::{
    CfgFault, Device, Diagnosis, Dpv1Error, Features, Outputs, PrmFault, Relation, Slave, SlaveState,
};
use profivac_sim::dialogue::Dialogue;
use profivac_wire::address::SetSlaveAdd;
use profivac_wire::cfg::{self, Lengths};
use profivac_wire::{DataTelegram, MAX_TELEGRAM, Telegram};

pub const IDENT: u16 = 0x1234;
/// The slave.
pub const TS: u8 = 8;
/// The owner of the slave.
pub const OWN: u8 = 2;
/// Another master.
pub const OTHER: u8 = 3;

/// FC of an SRD high: the first of a relation, and counted ones.
pub const FIRST: u8 = 0x6D;
pub const FCB_0: u8 = 0x5D;
pub const FCB_1: u8 = 0x7D;

/// Set_Prm of the owner: lock, min T_SDR 11.
pub const LOCK: [u8; 7] = [0x80, 0, 0, 11, 0x12, 0x34, 0];
/// The configuration: two octets in, two out.
pub const CFG: [u8; 2] = [0x11, 0x21];

/// A device that stores its outputs and counts its inputs.
pub struct Plain {
    pub features: Features,
    pub cfg: Vec<u8>,
    /// All outputs received, `None` for the safe state.
    pub outputs: Vec<Option<Vec<u8>>>,
    /// Its first input: the number of input samples.
    pub samples: u8,
    pub ext_diag: Vec<u8>,
    pub diagnosis_changed: bool,
    pub stored_address: Option<u8>,
}

impl Plain {
    pub fn new() -> Self {
        Self {
            features: Features { sync: true, freeze: true, ..Features::default() },
            cfg: CFG.to_vec(),
            outputs: Vec::new(),
            samples: 0,
            ext_diag: Vec::new(),
            diagnosis_changed: false,
            stored_address: None,
        }
    }
}

impl Device for Plain {
    fn ident_number(&self) -> u16 {
        IDENT
    }

    fn features(&self) -> Features {
        self.features
    }

    /// Accepts no user parameters except the three DPV1_Status octets.
    fn set_prm(&mut self, user: &[u8]) -> Result<(), PrmFault> {
        if matches!(user.len(), 0 | 3) { Ok(()) } else { Err(PrmFault) }
    }

    fn chk_cfg(&mut self, wanted: &[u8]) -> Result<Lengths, CfgFault> {
        if wanted == self.cfg { cfg::lengths(wanted).map_err(|_| CfgFault) } else { Err(CfgFault) }
    }

    fn get_cfg(&self) -> &[u8] {
        &self.cfg
    }

    fn outputs(&mut self, outputs: Outputs<'_>) {
        self.outputs.push(match outputs {
            Outputs::Data(data) => Some(data.to_vec()),
            Outputs::Safe => None,
        });
    }

    fn inputs(&mut self, inputs: &mut [u8]) {
        self.samples = self.samples.wrapping_add(1);
        inputs.fill(0);
        if let Some(first) = inputs.first_mut() {
            *first = self.samples;
        }
    }

    fn diagnosis(&self) -> Diagnosis<'_> {
        Diagnosis { event: !self.ext_diag.is_empty(), static_diag: false, blocks: &self.ext_diag }
    }

    fn take_diagnosis_change(&mut self) -> bool {
        std::mem::take(&mut self.diagnosis_changed)
    }

    /// Slot 1, index 16: the last sample, 200 times.
    fn read(&mut self, _: Relation, slot: u8, index: u8, record: &mut [u8]) -> Result<usize, Dpv1Error> {
        match (slot, index, record.get_mut(..200)) {
            (1, 16, Some(record)) => {
                record.fill(self.samples);
                Ok(record.len())
            }
            _ => Err(Dpv1Error::INVALID_INDEX),
        }
    }

    fn address_is_settable(&self) -> bool {
        true
    }

    fn set_address(&mut self, request: &SetSlaveAdd<'_>) -> Option<u8> {
        self.stored_address = Some(request.address);
        self.stored_address
    }
}

pub fn emit(telegram: &Telegram<'_>) -> Vec<u8> {
    let mut octets = vec![0; MAX_TELEGRAM];
    let length = telegram.emit(&mut octets).unwrap();
    octets.truncate(length);
    octets
}

/// A request to the slave without access points.
pub fn plain(sa: u8, fc: u8, du: &[u8]) -> Vec<u8> {
    emit(&Telegram::Data(DataTelegram { da: TS, sa, dsap: None, ssap: None, fc, du }))
}

/// A request to an access point of the slave.
pub fn request(sa: u8, fc: u8, dsap: u8, du: &[u8]) -> Vec<u8> {
    emit(&Telegram::Data(DataTelegram { da: TS, sa, dsap: Some(dsap), ssap: Some(62), fc, du }))
}

pub type Talk = Dialogue<Slave<Plain>>;

/// A dialogue with a slave after power-up.
pub fn talk(device: Plain) -> Talk {
    talk_at(Baud::B1500000, device)
}

pub fn talk_at(baud: Baud, device: Plain) -> Talk {
    Dialogue::new(baud, Slave::new(device, TS, baud))
}

/// Sends a request after T_ID1 and returns the answer.
pub fn ask(talk: &mut Talk, octets: &[u8]) -> Vec<u8> {
    ask_or_silence(talk, octets).expect("an answer")
}

pub fn ask_or_silence(talk: &mut Talk, octets: &[u8]) -> Option<Vec<u8>> {
    talk.ask(400, octets).unwrap()
}

pub fn to_wait_cfg(talk: &mut Talk) {
    assert_eq!(ask(talk, &request(OWN, FIRST, 61, &LOCK)), [0xE5]);
    assert!(matches!(talk.station().state(), SlaveState::WaitCfg(_)));
}

pub fn to_data_exch(talk: &mut Talk) {
    to_wait_cfg(talk);
    let cfg = talk.station().device().cfg.clone();
    assert_eq!(ask(talk, &request(OWN, FIRST, 62, &cfg)), [0xE5]);
    assert!(matches!(talk.station().state(), SlaveState::DataExch(..)));
}

/// The first four octets of the diagnosis, as `00 0C 00 02`.
pub fn diagnosis(talk: &mut Talk) -> String {
    let answer = ask(talk, &request(OTHER, FIRST, 60, &[]));
    let Ok(Telegram::Data(telegram)) = Telegram::parse(&answer) else { panic!("expected a diagnosis") };
    profivac_sim::describe::Hex(&telegram.du[..4]).to_string()
}
