//! The target `api::server`.
#![no_main]

libfuzzer_sys::fuzz_target!(|octets: &[u8]| fuzz::api::server(octets));
