//! A master on the desk: each method is one telegram to the slave and what it answers.
#![allow(dead_code, reason = "every test file uses its own part of this")]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "this is test code")]

use profivac_devices::Instrument;
use profivac_dp::link::{Baud, BitTime, Station};
use profivac_dp::slave::{Slave, State};
use profivac_wire::{Frame, Sap, Telegram};

/// The address of the master, and of the slave.
const MASTER: u8 = 2;
const SLAVE: u8 = 5;

/// SRD high with FCV = 0: a first contact each time, so that nothing counts as a repetition.
const SRD: u8 = 0x6D;

/// The octets of `text`, two hexadecimal digits each.
pub fn hex(text: &str) -> Vec<u8> {
    text.split_whitespace().map(|octet| u8::from_str_radix(octet, 16).unwrap()).collect()
}

/// A slave on the desk.
pub struct Desk<D> {
    pub slave: Slave<D>,
    ident: u16,
    now: BitTime,
}

impl<D: Instrument> Desk<D> {
    /// A device that has settled after power-up.
    pub fn new(mut device: D) -> Self {
        device.settle();
        let ident = device.ident_number();
        Self { slave: Slave::new(device, SLAVE, Baud::B1500000), ident, now: BitTime(0) }
    }

    pub fn device(&mut self) -> &mut D {
        self.slave.device_mut()
    }

    /// Every sensor of the device in a chamber at this pressure, the ambient sensor in air.
    pub fn pressure_mbar(&mut self, mbar: f64) {
        sense_all(self.device(), mbar);
    }

    /// One request; the function code and the data of the answer.
    pub fn request(&mut self, sap: Sap, du: &[u8]) -> Option<(u8, Vec<u8>)> {
        self.now = self.now + 1000u64;
        let dsap = sap.to_octet();
        let frame = Frame { da: SLAVE, sa: MASTER, dsap, ssap: dsap.map(|_| 62), fc: SRD, du };
        let transmit = self.slave.telegram(self.now, &Telegram::Frame(frame))?;
        match Telegram::parse(transmit.octets).expect("a slave sends valid telegrams") {
            Telegram::ShortAck => Some((0xE5, Vec::new())),
            Telegram::Frame(answer) => Some((answer.fc, answer.du.to_vec())),
            Telegram::Token { .. } => panic!("a slave has no token"),
        }
    }

    /// Slave_Diag: the three octets of Station_Status.
    pub fn diag(&mut self) -> [u8; 3] {
        let (_, du) = self.request(Sap::SlaveDiag, &[]).expect("an answer");
        [du[0], du[1], du[2]]
    }

    /// Set_Prm with lock.
    pub fn set_prm(&mut self, user: &[u8]) {
        let [high, low] = self.ident.to_be_bytes();
        let du = [&[0x88, 10, 10, 11, high, low, 0], user].concat();
        assert_eq!(self.request(Sap::SetPrm, &du), Some((0xE5, vec![])));
    }

    pub fn chk_cfg(&mut self, cfg: &[u8]) {
        assert_eq!(self.request(Sap::ChkCfg, cfg), Some((0xE5, vec![])));
    }

    /// Bring-up to DATA-EXCH.
    pub fn bring_up(&mut self, user: &[u8], cfg: &[u8]) {
        self.set_prm(user);
        self.chk_cfg(cfg);
        assert!(self.is_exchanging(), "user parameters {user:02X?}, configuration {cfg:02X?}: {:02X?}", self.diag());
    }

    pub fn is_exchanging(&self) -> bool {
        matches!(self.slave.state(), State::DataExch(..))
    }

    /// Data_Exchange.
    pub fn exchange(&mut self, outputs: &[u8]) -> Vec<u8> {
        self.request(Sap::Default, outputs).expect("an answer").1
    }

    /// The master lets go.
    pub fn unlock(&mut self) {
        let [high, low] = self.ident.to_be_bytes();
        self.request(Sap::SetPrm, &[0x40, 10, 10, 11, high, low, 0]);
    }
}

/// Every sensor in a chamber at this pressure, the ambient sensor in air.
pub fn sense_all(device: &mut impl Instrument, mbar: f64) {
    let ambient: Vec<bool> =
        device.parts().iter().map(|part| part.principle == profivac_devices::Principle::Atmosphere).collect();
    for (part, ambient) in ambient.into_iter().enumerate() {
        device.sense(part, if ambient { 101_325.0 } else { mbar * 100.0 });
    }
}
