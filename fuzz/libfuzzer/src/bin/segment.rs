//! The target `files::segment`.
#![no_main]

libfuzzer_sys::fuzz_target!(|octets: &[u8]| fuzz::files::segment(octets));
