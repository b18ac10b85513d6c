//! The target `plant::users`.
#![no_main]

libfuzzer_sys::fuzz_target!(|octets: &[u8]| fuzz::plant::users(octets));
