//! A master that sends one telegram after the other to a slave by its GSD file.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a rig that cannot go on stops the test")]

use profivac_dp::link::{Baud, BitTime, CHARACTER_TBIT, Station, T_SYN_TBIT};
use profivac_virtual::gsd_slave::{GsdStation, Order, Refused};
use profivac_virtual::station_spec::StationSpec;
use profivac_wire::{DataTelegram, Telegram};
use std::path::Path;

pub const MASTER: u8 = 2;

/// The access points of DP-V0.
pub const SET_PRM: u8 = 61;
pub const CHK_CFG: u8 = 62;
pub const GET_CFG: u8 = 59;
pub const DIAG: u8 = 60;
pub const SET_ADDRESS: u8 = 55;

/// The folder with the invented files.
pub fn folder() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/support/gsd"))
}

/// A slave of the invented files, as the command line writes it.
pub fn slave(spec: &str) -> GsdStation {
    opened(spec, None)
}

/// The same with a folder for its records.
pub fn opened(spec: &str, state: Option<&Path>) -> GsdStation {
    let StationSpec::Slave(spec) = spec.parse().unwrap() else { panic!("{spec} is no slave by its file") };
    spec.in_folder(folder()).open(Baud::B19200, state).unwrap().station
}

/// A slave by a file of this text, with an ident, one module and a rate.
pub fn slave_of(statements: &str) -> Rig {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.gsd");
    let text = format!(
        "#Profibus_DP\nIdent_Number = 0xF009\n19.2_supp = 1\nModular_Station = 1\nMax_Module = 1\n{statements}\nModule = \"4DI\" 0x10\n1\nEndModule\n"
    );
    std::fs::write(&path, text).unwrap();
    Rig::new(slave(&format!("{}@9:modules=1", path.display())))
}

/// A line to a slave, without its address.
pub fn order(slave: &mut GsdStation, line: &str) -> Result<String, Refused> {
    let words: Vec<_> = line.split_whitespace().collect();
    let (word, rest) = words.split_first().unwrap();
    slave.execute(&Order::parse(word, rest).unwrap().unwrap())
}

/// The answer of the slave: `DL 01 02`, `DH 01`, `SC`, `RS`, or `silence`.
pub struct Rig {
    pub slave: GsdStation,
    now: BitTime,
    count: bool,
    is_first: bool,
}

impl Rig {
    pub fn new(slave: GsdStation) -> Self {
        Self { slave, now: BitTime(0), count: true, is_first: true }
    }

    /// A request of the master with the next frame count bit.
    pub fn send(&mut self, dsap: Option<u8>, ssap: Option<u8>, du: &[u8]) -> String {
        let fc = match (self.is_first, self.count) {
            (true, _) => 0x6D,
            (false, true) => 0x7D,
            (false, false) => 0x5D,
        };
        (self.is_first, self.count) = (false, !self.count);
        let da = self.slave.station_address();
        self.octets(&DataTelegram { da, sa: MASTER, dsap, ssap, fc, du })
    }

    fn octets(&mut self, data: &DataTelegram<'_>) -> String {
        self.now = self.now + T_SYN_TBIT + CHARACTER_TBIT * (data.du.len() as u64 + 11);
        let end = self.now;
        let Some(answer) = self.slave.telegram(end, &Telegram::Data(*data)) else { return "silence".to_owned() };
        assert!(answer.not_before >= end + 11, "answered before min T_SDR");
        let octets = answer.octets.to_vec();
        self.now = answer.not_before + CHARACTER_TBIT * octets.len() as u64;
        self.slave.sent(self.now);
        self.slave.poll(self.now);
        said(&octets)
    }

    /// A Global_Control to all groups.
    pub fn control(&mut self, command: u8) {
        let du = [command, 0];
        let data = DataTelegram { da: 127, sa: MASTER, dsap: Some(58), ssap: Some(62), fc: 0x46, du: &du };
        assert_eq!(self.octets(&data), "silence");
    }

    pub fn ms0(&mut self, sap: u8, du: &[u8]) -> String {
        self.send(Some(sap), Some(62), du)
    }

    /// Set_Prm with these user parameters, without watchdog.
    pub fn set_prm(&mut self, ident: u16, user: &[u8]) {
        let [high, low] = ident.to_be_bytes();
        let du = [&[0x80, 0, 0, 11, high, low, 0][..], user].concat();
        assert_eq!(self.ms0(SET_PRM, &du), "SC");
    }

    pub fn chk_cfg(&mut self, octets: &[u8]) {
        assert_eq!(self.ms0(CHK_CFG, octets), "SC");
    }

    pub fn dx(&mut self, outputs: &[u8]) -> String {
        self.send(None, None, outputs)
    }

    /// The diagnosis from its first octet on.
    pub fn diag(&mut self) -> String {
        self.ms0(DIAG, &[]).strip_prefix("DL ").unwrap().to_owned()
    }
}

fn said(octets: &[u8]) -> String {
    let telegram = Telegram::parse(octets).unwrap();
    let Telegram::Data(data) = telegram else { return "SC".to_owned() };
    let kind = match data.fc & 0x0F {
        8 => "DL",
        10 => "DH",
        1 => "UE",
        2 => "RR",
        3 => "RS",
        _ => "other",
    };
    let octets: String = data.du.iter().map(|octet| format!(" {octet:02X}")).collect();
    format!("{kind}{octets}")
}
