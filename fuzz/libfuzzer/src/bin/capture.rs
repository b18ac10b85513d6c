//! The target `files::capture`.
#![no_main]

libfuzzer_sys::fuzz_target!(|octets: &[u8]| fuzz::files::capture(octets));
