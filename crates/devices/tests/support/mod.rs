//! A master and a slave in one test: each method is one telegram to the slave and its answer.
#![allow(dead_code, reason = "every test file uses its own part of this")]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "this is test code")]

pub mod counting_store;
pub mod golden;
#[path = "../../../../tests/support/octets.rs"]
mod octets;
pub mod off;
pub mod random;
pub mod rows;
pub mod selftest;
pub mod walk;

pub use octets::hex;
use profivac_devices::model::Fault;
use profivac_devices::{Action, Principle, SimulatedDevice, StateReport};
use profivac_dp::link::{Baud, BitTime, Station};
use profivac_dp::slave::{Dpv1Error, Relation, Slave, SlaveState};
use profivac_wire::{DataTelegram, Sap, Telegram};

/// The address of the master, and of the slave.
const MASTER: u8 = 2;
const SLAVE: u8 = 5;

/// SRD high with FCV = 0: a first contact each time, so that no request is a repetition.
const SRD: u8 = 0x6D;

/// SDN high.
const SDN: u8 = 0x46;

/// A slave with its master.
pub struct Tester<D> {
    pub slave: Slave<D>,
    ident: u16,
    now: BitTime,
}

impl<D: SimulatedDevice> Tester<D> {
    /// A device that has settled after power-up.
    pub fn new(mut device: D) -> Self {
        device.settle();
        let ident = device.ident_number();
        Self { slave: Slave::new(device, SLAVE, Baud::B1500000), ident, now: BitTime(0) }
    }

    pub fn device(&mut self) -> &mut D {
        self.slave.device_mut()
    }

    /// Every sensor of the device in a chamber at this pressure.
    pub fn pressure_mbar(&mut self, mbar: f64) {
        sense_all(self.device(), mbar);
    }

    /// One request of a class 1 master's cyclic side; the function code and the data of the answer.
    pub fn request(&mut self, sap: Sap, du: &[u8]) -> Option<(u8, Vec<u8>)> {
        self.ask(sap, 62, du)
    }

    /// One request from this source access point.
    pub fn ask(&mut self, sap: Sap, ssap: u8, du: &[u8]) -> Option<(u8, Vec<u8>)> {
        self.now = self.now + 1000u64;
        let dsap = sap.to_octet();
        let data = DataTelegram { da: SLAVE, sa: MASTER, dsap, ssap: dsap.map(|_| ssap), fc: SRD, du };
        let transmit = self.slave.telegram(self.now, &Telegram::Data(data))?;
        match Telegram::parse(transmit.octets).expect("a slave sends valid telegrams") {
            Telegram::ShortAck => Some((0xE5, Vec::new())),
            Telegram::Data(answer) => Some((answer.fc, answer.du.to_vec())),
            Telegram::Token { .. } => panic!("a slave has no token"),
        }
    }

    /// Global_Control to this slave.
    pub fn request_sdn(&mut self, du: &[u8]) {
        self.now = self.now + 1000u64;
        let data =
            DataTelegram { da: SLAVE, sa: MASTER, dsap: Sap::GlobalControl.to_octet(), ssap: Some(62), fc: SDN, du };
        assert!(self.slave.telegram(self.now, &Telegram::Data(data)).is_none());
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
        matches!(self.slave.state(), SlaveState::DataExch(..))
    }

    /// The number of octets that the master sends in data exchange.
    pub fn outputs(&self) -> Option<usize> {
        match self.slave.state() {
            SlaveState::DataExch(_, exchange) => Some(exchange.lengths.outputs.into()),
            _ => None,
        }
    }

    /// Data_Exchange.
    pub fn exchange(&mut self, outputs: &[u8]) -> Vec<u8> {
        self.request(Sap::Default, outputs).expect("an answer").1
    }

    /// The octets that a class 2 master reads.
    pub fn get(&mut self, slot: u8, index: u8) -> Vec<u8> {
        self.read(Relation::Ms2(0), slot, index).unwrap_or_else(|refusal| panic!("{slot}/{index}: {refusal:02X?}"))
    }

    /// A class 2 master writes; the code of the parameter channel if it is refused.
    pub fn put(&mut self, slot: u8, index: u8, octets: &[u8]) -> Result<(), u8> {
        self.write(Relation::Ms2(0), slot, index, octets).map_err(|Dpv1Error { code_2, .. }| code_2)
    }

    /// A Device Block State Command.
    pub fn command(&mut self, number: u8) -> Result<(), u8> {
        self.put(0, 15, &[number])
    }

    /// Device State.
    pub fn state(&mut self) -> u8 {
        self.get(0, 25)[0]
    }

    /// A fault by its name begins or ends.
    pub fn fault(&mut self, name: &str, active: bool) {
        let fault = Fault::from_name(name).expect("the name of a fault");
        self.device().operate(Action::Fault { fault, active }).unwrap();
    }

    pub fn report(&mut self) -> StateReport {
        self.device().report()
    }

    /// The master unlocks the slave.
    pub fn unlock(&mut self) {
        let [high, low] = self.ident.to_be_bytes();
        self.request(Sap::SetPrm, &[0x40, 10, 10, 11, high, low, 0]);
    }
}

/// Sets the pressure of every sensor; one that measures the ambient air keeps its own.
pub fn sense_all(device: &mut impl SimulatedDevice, mbar: f64) {
    let ambient: Vec<bool> = device.parts().iter().map(|part| part.principle == Principle::Atmosphere).collect();
    for (part, _) in ambient.into_iter().enumerate().filter(|(_, ambient)| !ambient) {
        device.sense(part, mbar * 100.0);
    }
}
