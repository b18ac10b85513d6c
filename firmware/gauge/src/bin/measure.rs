//! Counts the instructions of a BCG450 for each service: `firmware/check.py` prints them.
#![no_std]
#![no_main]

use profivac_board::{entry, start_timer, wait};
use profivac_devices::SimulatedDevice;
use profivac_devices::bcg450::Bcg450;
use profivac_devices::profile::Setup;
use profivac_gauge::{Request, measure, store};

const fn request(name: &'static str, saps: (u8, u8), du: &'static [u8]) -> Request {
    Request { name, saps: Some(saps), du }
}

const fn exchange(name: &'static str, du: &'static [u8]) -> Request {
    Request { name, saps: None, du }
}

const CFG: &[u8] = &[0xC8, 0x89, 0x8E, 0x0A, 0x05, 0x05, 0x0A, 0x05, 0x05, 0x05, 0x08];
const INITIATE: &[u8] = &[0x57, 0, 0, 0, 0, 0x64, 1, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 0];

/// Each request comes first where it has an effect for the first time, and again where masters repeat it.
const REQUESTS: &[Request] = &[
    request("Slave_Diag", (60, 62), &[]),
    request("Set_Prm", (61, 62), &[0x80, 0, 0, 0, 0x08, 0xE6, 0, 0, 0, 0, 5, 0x1D]),
    request("Chk_Cfg", (62, 62), CFG),
    request("Get_Cfg", (59, 62), &[]),
    exchange("Data_Exchange, first", &[0; 10]),
    exchange("Data_Exchange", &[0; 10]),
    exchange("Data_Exchange, channel read", &[0x10, 1, 19, 0, 0, 0, 0, 0, 0, 0]),
    exchange("Data_Exchange, channel read, answer", &[0x10, 1, 19, 0, 0, 0, 0, 0, 0, 0]),
    exchange("Data_Exchange, channel idle", &[0; 10]),
    exchange("Data_Exchange, channel write", &[0xA0, 1, 39, 0, 0, 0, 0, 2, 0, 0]),
    request("MS2 Initiate", (49, 50), INITIATE),
    request("MS2 Initiate, poll", (48, 50), &[]),
    request("MS2 read, request", (48, 50), &[0x5E, 0, 24, 240]),
    request("MS2 read, poll", (48, 50), &[]),
    request("MS2 write, request", (48, 50), &[0x5F, 1, 39, 1, 2]),
    request("MS2 write, poll", (48, 50), &[]),
    request("RD_Inp", (56, 62), &[]),
    request("Set_Prm, refused", (61, 62), &[0x80, 0, 0, 0, 0x08, 0xE6, 0, 0, 0, 0, 9, 9]),
];

entry!(main);

fn main() -> ! {
    start_timer();
    let mut gauge = Bcg450::new(store(), Setup::new(5));
    gauge.settle();
    measure(&mut gauge, REQUESTS);
    loop {
        wait();
    }
}
