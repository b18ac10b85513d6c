//! The target `files::device_spec`.
#![no_main]

libfuzzer_sys::fuzz_target!(|octets: &[u8]| fuzz::files::device_spec(octets));
