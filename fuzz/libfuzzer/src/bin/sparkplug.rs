//! The target `gateways::sparkplug`.
#![no_main]

libfuzzer_sys::fuzz_target!(|octets: &[u8]| fuzz::gateways::sparkplug(octets));
