//! The target `gateways::pv_access`.
#![no_main]

libfuzzer_sys::fuzz_target!(|octets: &[u8]| fuzz::gateways::pv_access(octets));
