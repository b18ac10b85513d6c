//! How a slave differs from the station's file, in words.

use crate::config;
use profivac_listen::Hex;

pub fn other_device(ident: u16, slave: &config::Slave) -> String {
    format!(
        "it has the ident number 0x{ident:04X}, the GSD file of the station's file 0x{:04X}: another device has the address",
        slave.gsd.ident()
    )
}

pub fn other_modules(octets: &[u8], slave: &config::Slave) -> String {
    let (found, expected) = (Hex(octets), Hex(slave.gsd.chk_cfg()));
    format!("its master configures it with {found}, the modules in the station's file give {expected}: correct modules")
}

pub fn other_plugged(octets: &[u8], slave: &config::Slave) -> String {
    let (found, needed) = (Hex(octets), Hex(slave.gsd.chk_cfg()));
    format!("it has the configuration {found}, the chosen modules need {needed}: correct modules in the station's file")
}
