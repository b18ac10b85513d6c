//! The target `decode::line`.
#![no_main]

libfuzzer_sys::fuzz_target!(|octets: &[u8]| fuzz::decode::line(octets));
