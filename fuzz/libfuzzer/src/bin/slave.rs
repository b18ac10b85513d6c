//! The target `slave::run`.
#![no_main]

libfuzzer_sys::fuzz_target!(|octets: &[u8]| fuzz::slave::run(octets));
