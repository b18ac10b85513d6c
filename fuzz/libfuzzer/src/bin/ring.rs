//! The target `ring::run`.
#![no_main]

libfuzzer_sys::fuzz_target!(|octets: &[u8]| fuzz::ring::run(octets));
