//! The target `files::scenario`.
#![no_main]

libfuzzer_sys::fuzz_target!(|octets: &[u8]| fuzz::files::scenario(octets));
