//! The target `files::trace`.
#![no_main]

libfuzzer_sys::fuzz_target!(|octets: &[u8]| fuzz::files::trace(octets));
