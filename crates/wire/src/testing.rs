//! Telegrams as hexadecimal text, for the tests of this crate.

extern crate std;
use crate::Telegram;
use std::vec::Vec;

/// The octets of `text`: pairs of hexadecimal digits, separated by spaces.
pub fn hex(text: &str) -> Vec<u8> {
    text.split_whitespace().map(|octet| u8::from_str_radix(octet, 16).unwrap()).collect()
}

/// The data unit of the telegram in `text`.
pub fn du(text: &str) -> Vec<u8> {
    let octets = hex(text);
    let Ok(Telegram::Data(telegram)) = Telegram::parse(&octets) else { panic!("expected a data telegram: {text}") };
    telegram.du.to_vec()
}
