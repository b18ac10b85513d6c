//! The target `prometheus::run`.
#![no_main]

libfuzzer_sys::fuzz_target!(|octets: &[u8]| fuzz::prometheus::run(octets));
