//! Hex as a person reads a trace, for the tests of this crate.

extern crate std;
use crate::Telegram;
use std::vec::Vec;

/// The octets of `text`, two hexadecimal digits each, spaces where they help.
pub fn hex(text: &str) -> Vec<u8> {
    text.split_whitespace().map(|octet| u8::from_str_radix(octet, 16).unwrap()).collect()
}

/// The data unit of the telegram printed as `text`.
pub fn du(text: &str) -> Vec<u8> {
    let octets = hex(text);
    let Ok(Telegram::Data(frame)) = Telegram::parse(&octets) else { panic!("a telegram: {text}") };
    frame.du.to_vec()
}
