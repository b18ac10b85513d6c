//! The target `gateways::channel_access`.
#![no_main]

libfuzzer_sys::fuzz_target!(|octets: &[u8]| fuzz::gateways::channel_access(octets));
