//! The target `plant::run`.
#![no_main]

libfuzzer_sys::fuzz_target!(|octets: &[u8]| fuzz::plant::run(octets));
