//! Octets as tests write them: two hexadecimal digits each, separated by spaces.

#![allow(clippy::expect_used, reason = "a test")]

/// The octets of `text`.
pub fn hex(text: &str) -> Vec<u8> {
    text.split_whitespace().map(|octet| u8::from_str_radix(octet, 16).expect("two hexadecimal digits")).collect()
}

/// The text of `octets`.
pub fn text(octets: &[u8]) -> String {
    octets.iter().map(|octet| format!("{octet:02X}")).collect::<Vec<_>>().join(" ")
}
