//! The target `master::run`.
#![no_main]

libfuzzer_sys::fuzz_target!(|octets: &[u8]| fuzz::master::run(octets));
