//! The target `batch::run`.
#![no_main]

libfuzzer_sys::fuzz_target!(|octets: &[u8]| fuzz::batch::run(octets));
