//! The target `gateways::modbus`.
#![no_main]

libfuzzer_sys::fuzz_target!(|octets: &[u8]| fuzz::gateways::modbus(octets));
