//! The target `decode::known_kind`.
#![no_main]

libfuzzer_sys::fuzz_target!(|octets: &[u8]| fuzz::decode::known_kind(octets));
