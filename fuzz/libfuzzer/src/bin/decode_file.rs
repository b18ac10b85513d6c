//! The target `decode::file`.
#![no_main]

libfuzzer_sys::fuzz_target!(|octets: &[u8]| fuzz::decode::file(octets));
