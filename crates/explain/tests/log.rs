//! Logs of telegrams, made by the tests.

use profivac_sim::describe::Hex;
use profivac_wire::{DataTelegram, MAX_TELEGRAM, Telegram};

pub const MASTER: u8 = 2;
pub const SLAVE: u8 = 5;

/// A log of requests of one master, and the answers of its slaves.
#[derive(Clone, Default)]
pub struct Log {
    pub text: String,
    frame_count: bool,
}

impl Log {
    pub fn telegram(&mut self, telegram: Telegram<'_>) {
        let mut out = [0; MAX_TELEGRAM];
        let length = telegram.emit(&mut out).unwrap();
        self.text += &format!("{}\n", Hex(&out[..length]));
    }

    fn next_fc(&mut self) -> u8 {
        let fc = if self.frame_count { 0x7D } else { 0x5D };
        self.frame_count = !self.frame_count;
        fc
    }

    pub fn request(mut self, slave: u8, sap: u8, du: &[u8]) -> Self {
        let fc = self.next_fc();
        let (dsap, ssap) = (Some(sap), Some(62));
        self.telegram(Telegram::Data(DataTelegram { da: slave, sa: MASTER, dsap, ssap, fc, du }));
        self
    }

    pub fn ack(mut self) -> Self {
        self.telegram(Telegram::ShortAck);
        self
    }

    /// RS: the slave does not serve the access point.
    pub fn refuse(mut self, slave: u8) -> Self {
        let fc = 0x03;
        self.telegram(Telegram::Data(DataTelegram { da: MASTER, sa: slave, dsap: None, ssap: None, fc, du: &[] }));
        self
    }

    pub fn diag_of(self, slave: u8, ident: u16, first: u8, blocks: &[u8]) -> Self {
        let [high, low] = ident.to_be_bytes();
        let du = [&[first, 0x0C, 0, MASTER, high, low], blocks].concat();
        let mut log = self.request(slave, 60, &[]);
        log.answer(slave, 60, &du);
        log
    }

    pub fn answer(&mut self, slave: u8, sap: u8, du: &[u8]) {
        let (dsap, ssap) = (Some(62), Some(sap));
        self.telegram(Telegram::Data(DataTelegram { da: MASTER, sa: slave, dsap, ssap, fc: 0x08, du }));
    }

    /// A Data_Exchange.
    pub fn exchange(mut self, outputs: &[u8], inputs: &[u8]) -> Self {
        let fc = self.next_fc();
        let plain = |da, sa, fc, du| Telegram::Data(DataTelegram { da, sa, dsap: None, ssap: None, fc, du });
        self.telegram(plain(SLAVE, MASTER, fc, outputs));
        self.telegram(plain(MASTER, SLAVE, 0x08, inputs));
        self
    }

    pub fn diag(self, ident: u16, blocks: &[u8]) -> Self {
        self.diag_of(SLAVE, ident, 0x08, blocks)
    }

    /// Set_Prm with these user parameters and the octet Station_Status; no answer yet.
    pub fn send_prm(self, ident: u16, status: u8, user: &[u8]) -> Self {
        let [high, low] = ident.to_be_bytes();
        self.request(SLAVE, 61, &[&[status, 20, 11, 11, high, low, 1], user].concat())
    }

    pub fn prm(self, ident: u16, user: &[u8]) -> Self {
        self.send_prm(ident, 0x88, user).ack()
    }
}
